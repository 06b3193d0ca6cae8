"""How fast is `inverse_kinematics` with all solutions, by its public name, beside EAIK (C++), in the same run?

python benchmarks/ik_closed_form.py [--robots puma560 ur5e ...] [--poses 20000] [--json FILE]

Main rows: `mf.inverse_kinematics(robot, T)` with `.q` read, of batches `.q` and `.valid`, over random reachable poses,
on one thread; ratios to `EAIK.IK` with its `.Q` read, and beside them to `EAIK.IK_batched` on one and two threads. The
table of the closed form alone stands below to explain. Then poses that need care: wrists that stand straight, poses out
of reach and beyond the limits. Both give the same solutions; "lost" counts, of 300 poses at multiples of 45 degrees,
those for which no configuration within 1e-6 comes back. EAIK is left out where it is not installed.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable
from itertools import cycle
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
os.environ.setdefault("MAFSIL_THREADS", "1")

import numpy as np  # noqa: E402

from benchmarks.comparison import Comparisons  # noqa: E402
from benchmarks.stopwatch import Timing, machine, race  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.ik import SolutionBatch, closed_form, inverse_kinematics  # noqa: E402
from mafsil.ik.chain import chain_of  # noqa: E402
from mafsil.robot import Robot, load  # noqa: E402

ROBOTS = ("puma560", "elbow6r", "ur5e", "ur10e")
BATCH_TARGET, SINGLE_TARGET, CAREFUL_TARGET = 15.0, 1.5, 20.0
SIZES = (32, 4_000)
"""Poses of batches, besides those of `--poses`."""
DISTINCT = 64
"""Poses that single calls take in turn."""
CAREFUL = 1_000
"""Poses of the batches that need care."""


def main() -> None:
    arguments = _arguments()
    details = machine("numpy")
    print(", ".join(f"{key} {value}" for key, value in details.items()))
    print(
        f"targets: single {SINGLE_TARGET:g} times EAIK.IK, batches of {SIZES[-1]} and more {BATCH_TARGET:g} times, "
        f"wrist-singular poses {CAREFUL_TARGET:g} us each; one thread"
    )
    rows: list[dict[str, Any]] = []
    found = Comparisons()
    for name in arguments.robots:
        rows.append(_row(name, arguments.poses, found))
        print(f"{name}:")
        for key, value in rows[-1].items():
            print(f"  {key:34} {value}")
    if arguments.json:
        Path(arguments.json).write_text(
            json.dumps({"machine": details, "rows": rows, "comparisons": found.plain()}, indent=2)
        )


def _row(name: str, poses: int, found: Comparisons) -> dict[str, Any]:
    robot = load(name)
    form = closed_form(robot)
    assert form is not None
    T = robot.forward_kinematics(np.random.default_rng(1).uniform(-np.pi, np.pi, (poses, robot.n)))
    rival = _eaik(robot)
    singles: dict[str, Callable[[], object]] = {
        "inverse_kinematics": _in_turn(lambda X: inverse_kinematics(robot, X).q, T),
        "table alone": _in_turn(form.kernel.call, T),
    }
    sizes = sorted({*SIZES, poses})
    batches: dict[str, tuple[int, Callable[[], object]]] = {
        f"batch of {size}": (size, lambda X=T[:size]: _read(inverse_kinematics(robot, X))) for size in sizes
    }
    batches[f"table alone, {SIZES[-1]}"] = (SIZES[-1], lambda: form.kernel(T[: SIZES[-1]], threads=1))
    if rival is not None:
        solver, tool = rival
        asked = T[: SIZES[-1]].copy()
        asked[:, :3, :3] = asked[:, :3, :3] @ tool
        listed = list(map(np.ascontiguousarray, asked))
        _compared(robot, T[:DISTINCT], solver, asked[:DISTINCT])
        singles["EAIK.IK"] = _in_turn(lambda X: solver.IK(X).Q, asked)
        for threads in (1, 2):
            batches[f"EAIK.IK_batched, {threads} threads"] = (
                len(listed),
                lambda count=threads: solver.IK_batched(listed, count),
            )
    batches |= _careful(robot)
    one = race(singles, repeats=60, seconds=0.001)
    many = race({key: task for key, (_, task) in batches.items()}, repeats=15, seconds=0.002)
    each = {key: Timing(t.least / batches[key][0], t.median / batches[key][0]) for key, t in many.items()}
    if "EAIK.IK" in one:
        theirs, goals = 1e6 * one["EAIK.IK"].least, {f"batch of {size}": BATCH_TARGET for size in sizes if size > 32}
        ours = 1e6 * one["inverse_kinematics"].least
        found.add("mf.inverse_kinematics(robot, T).q, one pose", name, ours, "EAIK.IK", theirs, SINGLE_TARGET)
        for size in sizes:
            call, ours = f"mf.inverse_kinematics(robot, T), {size:,} poses", 1e6 * each[f"batch of {size}"].least
            found.add(call, name, ours, "EAIK.IK", theirs, goals.get(f"batch of {size}"))
    for key, time in each.items():
        if key.startswith("wrist-singular"):
            found.add(f"mf.inverse_kinematics, {key}", name, 1e6 * time.least, "goal of 20 us", CAREFUL_TARGET, 1.0)
        if "EAIK.IK" in one and key.endswith("single"):
            found.add(
                f"mf.inverse_kinematics, {key}", name, 1e6 * time.least, "EAIK.IK", 1e6 * one["EAIK.IK"].least, 1.0
            )
    return _printed(one, each) | {
        "solutions of a pose": f"{_solutions(robot, T):.2f}",
        "lost of 300 at 45 degrees": _lost(robot, rival),
    }


def _printed(one: dict[str, Timing], many: dict[str, Timing]) -> dict[str, str]:
    """Microseconds of a pose, least and median, and how many times quicker than a single call of EAIK."""
    eaik = one.get("EAIK.IK")
    shown: dict[str, str] = {}
    for times, kind in ((one, "single "), (many, "")):
        for key, time in times.items():
            ratio = "" if eaik is None else f"  EAIK.IK / this {eaik.least / time.least:6.2f}"
            shown[kind + key] = f"{1e6 * time.least:9.3f} us a pose (median {1e6 * time.median:9.3f}){ratio}"
    return shown


def _careful(robot: Robot) -> dict[str, tuple[int, Callable[[], object]]]:
    """Batches and single calls with straight wrists and nearly straight ones, and poses out of reach."""
    rng = np.random.default_rng(2)
    low, high = (np.clip(x, -np.pi, np.pi) for x in (robot.limits.lower, robot.limits.upper))
    q = rng.uniform(0.4 * low, 0.4 * high, (CAREFUL, robot.n))
    tasks: dict[str, tuple[int, Callable[[], object]]] = {}
    for kind, bend in (("wrist-singular", 0.0), *((f"wrist bent by {x:.0e}", x) for x in (1e-10, 1e-8, 1e-6))):
        q[:, 4] = bend
        _add(tasks, robot, kind, robot.forward_kinematics(q))
    near = rng.uniform(0.4 * low, 0.4 * high, q.shape)
    pairs = cycle(list(zip(robot.forward_kinematics(near)[:DISTINCT], near[:DISTINCT], strict=True)))
    tasks["q0 given, single"] = 1, lambda: _near(robot, *next(pairs))
    far = robot.forward_kinematics(q)
    far[:, :3, 3] *= 5.0
    _add(tasks, robot, "out of reach", far)
    return tasks


def _add(tasks: dict[str, tuple[int, Callable[[], object]]], robot: Robot, kind: str, T: Floats) -> None:
    tasks[f"{kind}, batch of {len(T)}"] = len(T), lambda: _read(inverse_kinematics(robot, T))
    tasks[f"{kind}, single"] = 1, _in_turn(lambda X: inverse_kinematics(robot, X).q, T)
    tasks[f"{kind}, single, status"] = 1, _in_turn(lambda X: inverse_kinematics(robot, X).status, T)


def _near(robot: Robot, T: Floats, q0: Floats) -> object:
    """All solutions, wound near the configuration."""
    return inverse_kinematics(robot, T, q0=q0).q


def _read(batch: object) -> object:
    """What a program reads of a batch: the coordinates, and which rows are solutions."""
    assert isinstance(batch, SolutionBatch)
    return batch.q, batch.valid


def _in_turn(call: Callable[[Floats], object], T: Floats) -> Callable[[], object]:
    """The call with one of a few poses after the other."""
    poses = cycle([np.ascontiguousarray(X) for X in T[:DISTINCT]])
    return lambda: call(next(poses))


def _solutions(robot: Robot, T: Floats) -> float:
    batch = inverse_kinematics(robot, T)
    assert isinstance(batch, SolutionBatch)
    return float(batch.count.mean())


def _compared(robot: Robot, T: Floats, solver: Any, asked: Floats) -> None:
    """EAIK lists every solution that we list, and nearest misses: else a comparison of speed says nothing."""
    for X, Y in zip(T, asked, strict=True):
        mine, other = inverse_kinematics(robot, X).q, np.asarray(solver.IK(Y).Q).reshape(-1, robot.n)
        apart = mine[:, None] - other[None]
        apart = np.abs(apart - 2 * np.pi * np.round(apart / (2 * np.pi))).max(axis=-1)
        missing = int((apart.min(axis=1, initial=np.inf) > 1e-6).sum())
        if missing or len(mine) > len(other):
            print(f"  EAIK misses {missing} of {len(mine)} solutions")


def _lost(robot: Robot, rival: tuple[Any, Floats] | None) -> str:
    rng = np.random.default_rng(1)
    T = robot.forward_kinematics(rng.integers(-4, 5, (300, robot.n)) * (np.pi / 4))
    mine = sum(not len(inverse_kinematics(robot, X, tolerance=1e-6)) for X in T)
    return str(mine) if rival is None else f"{mine}, EAIK {sum(not _reached(robot, rival, X) for X in T)}"


def _eaik(robot: Robot) -> tuple[Any, Floats] | None:
    """EAIK's solver and the rotation that takes our tip to its."""
    try:
        from eaik.IK_HP import HPRobot
    except ImportError:
        return None
    chain = chain_of(robot.mechanism)
    assert chain is not None
    offsets = np.diff(np.concatenate([np.zeros((1, 3)), chain.points, chain.home[None, :3, 3]]), axis=0)
    return HPRobot(chain.axes, offsets), chain.home[:3, :3].T


def _reached(robot: Robot, rival: tuple[Any, Floats], T: Floats) -> bool:
    solver, tool = rival
    asked = T.copy()
    asked[:3, :3] = T[:3, :3] @ tool
    q = np.asarray(solver.IK(asked).Q).reshape(-1, robot.n)
    return len(q) > 0 and bool((np.abs(robot.forward_kinematics(q) - T).max(axis=(1, 2)) < 1e-6).any())


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", nargs="+", default=ROBOTS)
    parser.add_argument("--poses", type=int, default=20_000)
    parser.add_argument("--json")
    return parser.parse_args()


if __name__ == "__main__":
    main()
