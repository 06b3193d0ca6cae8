"""How fast are the mechanics of an arm beside Pinocchio, in the same run?

python benchmarks/dynamics_vs_pinocchio.py [--robots panda ur5e ...] [--json FILE] [--quick]

Per quantity and robot: one evaluation in a batch on one thread, one call from Python, the first call in a fresh process
with an empty cache (compiles) and with a full one (loads). Beside each stand Pinocchio's single Python call and, where
its wheel has them, `rneaInParallel` and `abaInParallel` on one thread. Pinocchio's model is built in memory with its
own quick joint classes; its results stay in its data object, ours are fresh arrays in single calls. Where a batch
falls short of the target, the last lines say what the hardware allows (`floor`).
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402
import pinocchio as pin  # noqa: E402

from benchmarks.floor import bytes_per_ns, floor_ns, products_per_ns  # noqa: E402
from benchmarks.large_robots import large_robot  # noqa: E402
from benchmarks.stopwatch import BRIEF, BRIEFER, Timing, machine, race, verdict  # noqa: E402
from mafsil.mechanics.catalogue import quantity  # noqa: E402
from mafsil.model import Mechanism, library  # noqa: E402
from mafsil.robot import Robot  # noqa: E402
from tests.oracles.pinocchio_model import model_of  # noqa: E402
from tests.oracles.states import States, sample  # noqa: E402

ROBOTS = ("panda", "ur5e", "puma560", "iiwa7", "tree30", "talos")
ROWS = 2048
BATCH_TARGET, PARALLEL_TARGET, SINGLE_TARGET = 40.0, 20.0, 2.0
"""Ratios of DESIGN.md section 7: a batch row against the Python call and the C++ loop, a call against a call."""

QUANTITIES: dict[str, tuple[str, ...]] = {
    "inverse dynamics": ("inverse_dynamics",),
    "mass matrix": ("mass_matrix",),
    "forward dynamics": ("forward_dynamics",),
    "forward kinematics": ("forward_kinematics",),
    "body Jacobian": ("jacobian_body",),
    "FK + Jacobian": ("forward_kinematics", "jacobian_body"),
    "gravity": ("gravity_torque",),
    "Coriolis matrix": ("coriolis_matrix",),
}
"""Title -> quantities of the catalogue, of the same inputs."""


def mechanism_named(name: str) -> Mechanism:
    """A robot of the library, or one of many joints."""
    return large_robot(name) or library.load(name)


def main() -> None:
    options = _parsed()
    details = machine("mafsil", "numpy", "llvmlite", "pin")
    print(" | ".join(f"{key} {value}" for key, value in details.items()), flush=True)
    repeats = 3 if options.quick else 9
    rows: list[dict[str, Any]] = []
    print(HEADING)
    for robot in options.robots:
        for row in measured(robot, options.quick):
            rows.append(row)
            print(line(row), flush=True)
    imports = import_times(repeats)
    print("import [ms]: " + ", ".join(f"{name} {ms:.0f}" for name, ms in imports.items()))
    for summary in (*verdicts(rows), *rows_below_goal(rows)):
        print(summary)
    if options.json:
        options.json.write_text(json.dumps({"machine": details, "rows": rows, "import_ms": imports}, indent=1))


def measured(name: str, quick: bool) -> Iterator[dict[str, Any]]:
    """One row per quantity."""
    mechanism = mechanism_named(name)
    robot, states = Robot(mechanism), sample(mechanism, ROWS, np.random.default_rng(1))
    rivals = Rivals(mechanism, states)
    first, turns = starts(name), BRIEFER if quick else BRIEF
    for title, routines in QUANTITIES.items():
        inputs = quantity(routines[0]).inputs
        batch = race(_batch_tasks(robot, states, routines, inputs) | rivals.parallel(title), **turns)
        single = race(_single_tasks(robot, states, routines, inputs) | {"pinocchio": rivals.call(title)}, **turns)
        yield {
            "robot": name,
            "joints": mechanism.n,
            "quantity": title,
            "batch_ns": _scaled(batch["mafsil"], 1e9 / ROWS),
            "pinocchio_parallel_ns": _scaled(batch["pinocchio"], 1e9 / ROWS) if "pinocchio" in batch else None,
            "single_ns": _scaled(single["mafsil"], 1e9),
            "pinocchio_single_ns": _scaled(single["pinocchio"], 1e9),
            "floor_ns": floor_ns(mechanism, routines, ROWS),
            "compile_s": first["cold"][title],
            "load_ms": 1e3 * first["warm"][title],
        }


def routine(robot: Robot, names: tuple[str, ...]) -> Callable[..., Any]:
    """The routine of one quantity, or of several at once."""
    return getattr(robot, names[0]) if len(names) == 1 else robot.fused_routine(*names)


def _batch_tasks(
    robot: Robot, states: States, routines: tuple[str, ...], inputs: tuple[str, ...]
) -> dict[str, Callable[[], object]]:
    evaluate, arguments = routine(robot, routines), states.arguments(inputs)
    result = evaluate(*arguments)
    return {"mafsil": lambda: evaluate(*arguments, out=result, threads=1)}


def _single_tasks(
    robot: Robot, states: States, routines: tuple[str, ...], inputs: tuple[str, ...]
) -> dict[str, Callable[[], object]]:
    a, *rest = (np.ascontiguousarray(x[0]) for x in states.arguments(inputs))
    f = routine(robot, routines)
    match rest:
        case []:
            task = lambda: f(a)  # noqa: E731
        case [b]:
            task = lambda: f(a, b)  # noqa: E731
        case [b, c]:
            task = lambda: f(a, b, c)  # noqa: E731
        case _:
            raise AssertionError(routines)
    return {"mafsil": task}


class Rivals:
    """Pinocchio's calls on the same states."""

    def __init__(self, mechanism: Mechanism, states: States) -> None:
        self.model, frames = model_of(mechanism)
        self.tip = frames[-1]
        self.data = self.model.createData()
        self.states = states

    def call(self, title: str) -> Callable[[], object]:
        """The usual Python call (or calls) for one state."""
        model, data, tip = self.model, self.data, self.tip
        q, v, a, tau = (np.ascontiguousarray(x[0]) for x in self.states.arguments(("q", "qd", "qdd", "tau")))

        def forward_kinematics() -> None:
            pin.forwardKinematics(model, data, q)
            pin.updateFramePlacement(model, data, tip)

        def kinematics_and_jacobian() -> None:
            pin.computeJointJacobians(model, data, q)
            pin.updateFramePlacement(model, data, tip)
            pin.getFrameJacobian(model, data, tip, pin.LOCAL)

        return {
            "inverse dynamics": lambda: pin.rnea(model, data, q, v, a),
            "mass matrix": lambda: pin.crba(model, data, q),
            "forward dynamics": lambda: pin.aba(model, data, q, v, tau),
            "forward kinematics": forward_kinematics,
            "body Jacobian": lambda: pin.computeFrameJacobian(model, data, q, tip, pin.LOCAL),
            "FK + Jacobian": kinematics_and_jacobian,
            "gravity": lambda: pin.computeGeneralizedGravity(model, data, q),
            "Coriolis matrix": lambda: pin.computeCoriolisMatrix(model, data, q, v),
        }[title]

    def parallel(self, title: str) -> dict[str, Callable[[], object]]:
        """The C++ loop over all states on one thread, where there is one."""
        pool = pin.ModelPool(self.model, 1)
        q, v, a, tau = (np.asfortranarray(x.T) for x in self.states.arguments(("q", "qd", "qdd", "tau")))
        match title:
            case "inverse dynamics":
                result = pin.rneaInParallel(1, pool, q, v, a)
                return {"pinocchio": lambda: pin.rneaInParallel(1, pool, q, v, a, result)}
            case "forward dynamics":
                result = pin.abaInParallel(1, pool, q, v, tau)
                return {"pinocchio": lambda: pin.abaInParallel(1, pool, q, v, tau, result)}
            case _:
                return {}


def starts(name: str) -> dict[str, dict[str, float]]:
    """Seconds until the first result of each routine: in a fresh process without and with entries in the cache."""
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {"MAFSIL_CACHE": folder}
        command = [sys.executable, __file__, "--first-calls", name]
        taken: dict[str, dict[str, float]] = {}
        for state in ("cold", "warm", "warm again"):
            answer = subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout
            taken[state] = json.loads(answer)
    warm = {key: min(taken["warm"][key], taken["warm again"][key]) for key in taken["warm"]}
    return {"cold": taken["cold"], "warm": warm}


def first_calls(name: str) -> dict[str, float]:
    """In this process: seconds of the first call of each routine; compilers are imported before and not counted."""
    from time import perf_counter

    mechanism = mechanism_named(name)
    state = sample(mechanism, 1, np.random.default_rng(1))
    if not any(Path(os.environ["MAFSIL_CACHE"]).rglob("*.kernel")):
        import llvmlite.binding  # noqa: F401

        import mafsil.expression  # noqa: F401
    robot = Robot(mechanism)
    robot.potential_energy(state.q[0])
    seconds: dict[str, float] = {}
    for title, routines in QUANTITIES.items():
        inputs = quantity(routines[0]).inputs
        arguments = [x[0] for x in state.arguments(inputs)]
        start = perf_counter()
        routine(robot, routines)(*arguments)
        seconds[title] = perf_counter() - start
    return seconds


def import_times(repeats: int) -> dict[str, float]:
    """Milliseconds of whole processes, least of the repeats."""
    programs = {
        "nothing": "",
        "numpy": "import numpy",
        "mafsil": "import mafsil",
        "mafsil.load('panda')": "import mafsil; mafsil.load('panda')",
    }
    tasks = {
        name: (lambda code=code: subprocess.run([sys.executable, "-c", code], check=True))
        for name, code in programs.items()
    }
    return {name: 1e3 * timing.least for name, timing in race(tasks, repeats=repeats, seconds=0.01).items()}


HEADING = (
    f"{'robot':9}{'n':>3} {'quantity':19}"
    f"{'batch ns':>16}{'x call':>8}{'C++ ns':>8}{'x C++':>7}{'call ns':>15}{'pin ns':>8}{'x':>6}"
    f"{'compile s':>10}{'load ms':>8}"
)


def line(row: dict[str, Any]) -> str:
    """The row as text: least (median) of the repeats; ratios of the least."""
    batch, call, rival = row["batch_ns"], row["single_ns"], row["pinocchio_single_ns"]
    parallel = row["pinocchio_parallel_ns"]
    ratios = ratios_of(row)
    loop = f"{parallel['least']:8.0f}{ratios['parallel']:7.1f}" if parallel else f"{'':15}"
    return (
        f"{row['robot']:9}{row['joints']:3} {row['quantity']:19}"
        f"{batch['least']:8.1f} ({batch['median']:5.1f}){ratios['batch']:8.1f}{loop}"
        f"{call['least']:7.0f} ({call['median']:5.0f}){rival['least']:8.0f}{ratios['single']:6.2f}"
        f"{row['compile_s']:10.2f}{row['load_ms']:8.1f}"
    )


def ratios_of(row: dict[str, Any]) -> dict[str, float]:
    """How many times quicker than Pinocchio: batch row, against its C++ loop, single call."""
    call = row["pinocchio_single_ns"]["least"]
    ratios = {"batch": call / row["batch_ns"]["least"], "single": call / row["single_ns"]["least"]}
    if row["pinocchio_parallel_ns"]:
        ratios["parallel"] = row["pinocchio_parallel_ns"]["least"] / row["batch_ns"]["least"]
    return ratios


def verdicts(rows: list[dict[str, Any]]) -> Iterator[str]:
    """How many rows reach each target."""
    for kind, target in (("batch", BATCH_TARGET), ("parallel", PARALLEL_TARGET), ("single", SINGLE_TARGET)):
        ratios = [ratios_of(row)[kind] for row in rows if kind in ratios_of(row)]
        if ratios:
            yield verdict(kind, ratios, target)


def rows_below_goal(rows: list[dict[str, Any]]) -> Iterator[str]:
    """What the machine would allow where a batch does not reach its target: Pinocchio's call over the floor."""
    yield f"one core: {products_per_ns():.1f} products a ns; writes {bytes_per_ns(1 << 20):.0f} B/ns into 1 MiB"
    for row in rows:
        reached = ratios_of(row)["batch"]
        if reached < BATCH_TARGET:
            products, writing = row["floor_ns"]
            rival, batch = row["pinocchio_single_ns"]["least"], row["batch_ns"]["least"]
            yield (
                f"{row['robot']} {row['quantity']}: {reached:.0f} times; of its {batch:.0f} ns the products alone take "
                f"{products:.0f} and writing alone {writing:.0f}: at most {rival / max(products, writing):.0f} times, "
                f"{rival / (products + writing):.0f} where neither hides the other"
            )


def _scaled(timing: Timing, factor: float) -> dict[str, float]:
    return {name: value * factor for name, value in asdict(timing).items()}


def _parsed() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", nargs="+", default=list(ROBOTS), choices=(*ROBOTS, "chain30"))
    parser.add_argument("--json", type=Path, help="file for the figures")
    parser.add_argument("--quick", action="store_true", help="a quarter of the repeats")
    parser.add_argument("--first-calls", choices=(*ROBOTS, "chain30"), help=argparse.SUPPRESS)
    return parser.parse_args()


if __name__ == "__main__":
    chosen = _parsed().first_calls
    if chosen:
        print(json.dumps(first_calls(chosen)))
    else:
        main()
