"""From one state to a million: what does a row cost beside Pinocchio's Python call, in the same run, on one thread?

python benchmarks/batch_sizes.py [--robots panda talos ...] [--quantities FK ID ...] [--json FILE] [--quick]

Public names only, fresh arrays everywhere (no `out=`), threads=1. Columns: one state, 32 rows, 2,048 rows whose results
stay in the caches, and 10^6 rows, or as many as have inputs and results of 1 GB; their number is said. Pinocchio gets
one state a call and writes into its data object. Results are compared before anything is timed. The first of the large
calls fetches its pages from the system; the turns that are timed find them again (`kernels.result_memory`).

Where a row misses its goal, the last lines say what bounds it: the arithmetic alone, as the cached batch shows it, and
the writing alone, at the rate that this machine wrote during this run.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402
import pinocchio as pin  # noqa: E402

from benchmarks.comparison import Comparisons  # noqa: E402
from benchmarks.floor import bytes_per_ns, fresh_bytes_per_ns, past_bytes_per_ns  # noqa: E402
from benchmarks.stopwatch import Task, machine, race, verdict  # noqa: E402
from mafsil.mechanics.catalogue import quantity  # noqa: E402
from mafsil.model import library  # noqa: E402
from mafsil.robot import Robot, load  # noqa: E402
from tests.model.urdf.real_files import FOLDER  # noqa: E402
from tests.oracles.pinocchio_model import MOTION_ORDER, model_of  # noqa: E402
from tests.oracles.random_tree import branched_tree  # noqa: E402
from tests.oracles.states import sample  # noqa: E402

ARMS = ("panda", "iiwa7", "ur5e", "puma560")
TREES = ("tree30", "talos")
SIZES = (1, 32, 2048, 1_000_000)
MOST_BYTES = 1_000_000_000
"""Of inputs and results together."""
ROUTINES: dict[str, str] = {
    "FK": "forward_kinematics",
    "J_s": "jacobian_space",
    "J_b": "jacobian_body",
    "ID": "inverse_dynamics",
    "M": "mass_matrix",
    "FD": "forward_dynamics",
    "g": "gravity_torque",
    "C": "coriolis_matrix",
    "dID": "inverse_dynamics_derivatives",
    "dFD": "forward_dynamics_derivatives",
}
"""Quantities of the catalogue by their titles here."""
DERIVATIVES = ("dID", "dFD")
GOALS = {"arm": {1: 4.0, 32: 4.0, 2048: 40.0, 1_000_000: 30.0}, "tree": {1: 4.0, 32: 4.0, 2048: 20.0, 1_000_000: 20.0}}
"""Times Pinocchio's call, by the number of rows; derivatives want 25 in the caches and 7 in single calls."""
GOALS_OF_DERIVATIVES = {1: 7.0, 32: 7.0, 2048: 30.0, 1_000_000: 30.0}


def main() -> None:
    options = _parsed()
    details = machine("mafsil", "numpy", "pin")
    print(" | ".join(f"{key} {value}" for key, value in details.items()), flush=True)
    print(HEADING)
    rows: list[dict[str, Any]] = []
    for name in options.robots:
        for row in measured(name, options.quantities, options.quick):
            rows.append(row)
            print(line(row), flush=True)
    rates = {
        "plain": bytes_per_ns(64 << 20),
        "past the caches": past_bytes_per_ns(256 << 20),
        "fresh pages": fresh_bytes_per_ns(256 << 20),
    }
    print("one core writes [bytes a ns]: " + ", ".join(f"{name} {rate:.1f}" for name, rate in rates.items()))
    for size in SIZES:
        ratios = [cell["ratio"] / cell["goal"] for row in rows for cell in row["cells"] if cell["column"] == size]
        print(verdict(f"{size} rows, in parts of the goal", ratios, 1.0))
    for text in rows_below_goal(rows, rates["past the caches"]):
        print(text)
    if options.json:
        figures = {"machine": details, "rates": rates, "rows": rows, "comparisons": comparisons(rows).plain()}
        options.json.write_text(json.dumps(figures, indent=1))


def comparisons(rows: list[dict[str, Any]]) -> Comparisons:
    """One line for each cell of the table."""
    found = Comparisons()
    for row in rows:
        for cell in row["cells"]:
            call = f"{ROUTINES[row['quantity']]}, {cell['rows']:,} row{'s' * (cell['rows'] > 1)}"
            found.add(call, row["robot"], cell["ns"] / 1e3, "Pinocchio call", cell["pinocchio_ns"] / 1e3, cell["goal"])
    return found


def robot_named(name: str) -> Robot:
    """A robot of the library, the tree of 30 joints, or the reduced Talos of example-robot-data."""
    if name == "talos":
        return load(FOLDER / "talos_data" / "robots" / "talos_reduced.urdf", tip="gripper_left_base_link")
    return Robot(branched_tree(30, np.random.default_rng(30)) if name == "tree30" else library.load(name))


def measured(name: str, quantities: tuple[str, ...], quick: bool) -> Iterator[dict[str, Any]]:
    """One row for each quantity: its cells, one for each number of rows."""
    robot = robot_named(name)
    states = sample(robot.mechanism, max(SIZES[:-1]), np.random.default_rng(1))
    rivals = Rivals(robot)
    for title in quantities:
        if title in DERIVATIVES and name in TREES:
            continue
        routine = ROUTINES[title]
        names = quantity(routine).inputs
        evaluate, some = getattr(robot, routine), states.arguments(names)
        point = [np.ascontiguousarray(x[0]) for x in some]
        call = rivals.call(title, point)
        size = compare(title, evaluate(*point), rivals)
        bytes_a_row = size + sum(x[0].nbytes for x in some)
        cells: list[dict[str, Any]] = []
        for column in SIZES:
            count = min(column, MOST_BYTES // bytes_a_row)
            arrays = point if count == 1 else [np.resize(x, (count, x.shape[1])) for x in some]
            taken = race({"mafsil": _task(evaluate, arrays), "pinocchio": call}, **turns(count, quick))
            ours, rival = 1e9 * taken["mafsil"].least / count, 1e9 * taken["pinocchio"].least
            goals = GOALS_OF_DERIVATIVES if title in DERIVATIVES else GOALS["tree" if name in TREES else "arm"]
            details = {"column": column, "rows": count, "ns": ours, "pinocchio_ns": rival}
            cells.append({**details, "ratio": rival / ours, "goal": goals[column]})
        yield {"robot": name, "quantity": title, "bytes": size, "cells": cells}


def turns(count: int, quick: bool) -> dict[str, Any]:
    """Many short turns for small batches, a few calls for large ones."""
    repeats = 12 if count > 10_000 else 40
    return {"repeats": repeats // 3 if quick else repeats, "seconds": 0.003}


def _task(evaluate: Callable[..., Any], arrays: list[Any]) -> Task:
    match arrays:
        case [q] if q.ndim == 1:
            return lambda: evaluate(q)
        case [q, v] if q.ndim == 1:
            return lambda: evaluate(q, v)
        case [q, v, a] if q.ndim == 1:
            return lambda: evaluate(q, v, a)
        case _:
            return lambda: evaluate(*arrays, threads=1)


class Rivals:
    """Pinocchio's calls for one state, and their results in our order."""

    def __init__(self, robot: Robot) -> None:
        self.model, frames = model_of(robot.mechanism)
        self.data: Any = self.model.createData()
        self.tip = frames[-1]

    def call(self, title: str, point: list[Any]) -> Task:
        """The usual Python call (or calls)."""
        model, data, tip, q = self.model, self.data, self.tip, point[0]
        v = point[1] if len(point) > 1 else q
        w = point[2] if len(point) > 2 else q

        def forward_kinematics() -> object:
            pin.forwardKinematics(model, data, q)
            return pin.updateFramePlacement(model, data, tip)

        def space_jacobian() -> object:
            pin.computeJointJacobians(model, data, q)
            return pin.getFrameJacobian(model, data, tip, pin.WORLD)

        calls: dict[str, Task] = {
            "FK": forward_kinematics,
            "J_s": space_jacobian,
            "J_b": lambda: pin.computeFrameJacobian(model, data, q, tip, pin.LOCAL),
            "ID": lambda: pin.rnea(model, data, q, v, w),
            "M": lambda: pin.crba(model, data, q),
            "FD": lambda: pin.aba(model, data, q, v, w),
            "g": lambda: pin.computeGeneralizedGravity(model, data, q),
            "C": lambda: pin.computeCoriolisMatrix(model, data, q, v),
            "dID": lambda: pin.computeRNEADerivatives(model, data, q, v, w),
            "dFD": lambda: pin.computeABADerivatives(model, data, q, v, w),
        }
        self.last = calls[title]
        return self.last

    def answer(self, title: str) -> Any:
        """The result of the last call, as our routine gives it."""
        found: Any = self.last()
        match title:
            case "FK":
                return found.homogeneous
            case "J_s" | "J_b":
                return np.asarray(found)[MOTION_ORDER]
            case "M":
                upper = np.triu(found)
                return upper + np.triu(upper, 1).T
            case "C":
                return None  # another of the many factorisations: only C qd is the same
            case "dID" | "dFD":
                return np.asarray(found[0])
            case _:
                return np.asarray(found)


def compare(title: str, ours: Any, rivals: Rivals) -> int:
    """Ours against Pinocchio's; returns the bytes of the result."""
    wanted = rivals.answer(title)
    if wanted is not None:
        found = ours[0] if title in DERIVATIVES else ours
        np.testing.assert_allclose(found, wanted, rtol=1e-6, atol=1e-7 * np.abs(wanted).max(), err_msg=title)
    return int(ours.nbytes)


HEADING = f"{'robot':9}{'':5}" + "".join(f"{f'{size} rows':>26}" for size in SIZES) + f"{'pin ns':>9}"


def line(row: dict[str, Any]) -> str:
    """Nanoseconds a row and how many times Pinocchio's call, for each size."""
    cells = "".join(map(_cell, row["cells"]))
    return f"{row['robot']:9}{row['quantity']:5}{cells}{row['cells'][0]['pinocchio_ns']:9.0f}"


def _cell(cell: dict[str, Any]) -> str:
    """Nanoseconds, ratio, a star where the goal is missed, the rows if they are fewer than the column says."""
    star = "" if cell["ratio"] >= cell["goal"] else "*"
    fewer = "" if cell["rows"] == cell["column"] else f"{cell['rows'] / 1e6:.2f}M"
    return f"{cell['ns']:11.1f}{cell['ratio']:8.1f}{star:1}{fewer:>6}"


def rows_below_goal(rows: list[dict[str, Any]], rate: float) -> Iterator[str]:
    """What bounds every batch that misses its goal: marked * above."""
    for row in rows:
        cached = row["cells"][2]["ns"]
        for cell in row["cells"][2:]:
            if cell["ratio"] < cell["goal"]:
                writing = row["bytes"] / rate
                bound = max(writing, cached) if cell["column"] > 2048 else cached
                yield (
                    f"{row['robot']} {row['quantity']}, {cell['rows']} rows: {cell['ratio']:.1f} of {cell['goal']:g} "
                    f"times; of {cell['ns']:.0f} ns writing {row['bytes']} bytes past the caches alone takes "
                    f"{writing:.0f}, the whole in the caches {cached:.0f}: at most "
                    f"{cell['pinocchio_ns'] / bound:.0f} times"
                )


def _parsed() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", nargs="+", default=[*ARMS, *TREES], choices=[*ARMS, *TREES])
    parser.add_argument("--quantities", nargs="+", default=list(ROUTINES), choices=list(ROUTINES))
    parser.add_argument("--json", type=Path, help="file for the figures")
    parser.add_argument("--quick", action="store_true", help="a quarter of the repeats")
    return parser.parse_args()


if __name__ == "__main__":
    main()
