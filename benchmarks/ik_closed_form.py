"""How fast are closed forms, all postures of a pose, beside EAIK (C++), in the same run?

python benchmarks/ik_closed_form.py [--robots puma560 ur5e ...] [--poses 20000] [--json FILE]

Random reachable poses; every row is checked by forward kinematics inside the kernel. "Lost" counts, of 300 poses at
multiples of 45 degrees, those for which no posture within 1e-6 comes back. EAIK is left out where it is not installed.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

from benchmarks.stopwatch import machine, race  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.ik import closed_form, inverse_kinematics  # noqa: E402
from mafsil.ik.chain import chain_of  # noqa: E402
from mafsil.robot import Robot, load  # noqa: E402

ROBOTS = ("puma560", "elbow6r", "ur5e", "ur10e")
BATCH_TARGET, SINGLE_TARGET = 25.0, 2.5
BLOCK = 4_000
"""Poses whose table stays in the cache; that of the whole batch is new memory, which takes time of its own."""


def main() -> None:
    arguments = _arguments()
    rows = [_row(name, arguments.poses) for name in arguments.robots]
    facts = machine("numpy")
    print(", ".join(f"{key} {value}" for key, value in facts.items()))
    print(f"targets: batch {BATCH_TARGET:g} times EAIK on one core, single call {SINGLE_TARGET:g} times")
    for row in rows:
        print("  ".join(f"{key} {value}" for key, value in row.items()))
    if arguments.json:
        Path(arguments.json).write_text(json.dumps({"machine": facts, "rows": rows}, indent=2))


def _row(name: str, poses: int) -> dict[str, str]:
    robot = load(name)
    form = closed_form(robot)
    assert form is not None
    rng = np.random.default_rng(1)
    T = robot.forward_kinematics(rng.uniform(-np.pi, np.pi, (poses, robot.n)))
    one = np.ascontiguousarray(T[0])
    rival = _eaik(robot)
    table = form.kernel
    tasks: dict[str, Any] = {
        "batch": lambda: table(T, threads=1),
        "block": lambda: table(T[:BLOCK], threads=1),
        "single": lambda: table(one),
        "labelled": lambda: inverse_kinematics(robot, one),
    }
    if rival is not None:
        solver, tool = rival
        asked = one.copy()
        asked[:3, :3] = one[:3, :3] @ tool
        tasks["eaik"] = lambda: solver.IK(asked)
    # Short and many: on a busy machine some of them are not interrupted.
    times = race(tasks, repeats=150, seconds=0.001)
    round_T = robot.forward_kinematics(rng.integers(-4, 5, (300, robot.n)) * (np.pi / 4))
    mine, block = times["batch"].least / poses, times["block"].least / min(BLOCK, poses)
    row = {
        "robot": name,
        "solutions": f"{form.solve(T).found().sum(axis=1).mean():.2f}",
        "batch": f"{mine * 1e6:.3f} us a pose on one core",
        f"batch of {BLOCK}": f"{block * 1e6:.3f} us",
        "single table": f"{times['single'].least * 1e6:.2f} us",
        "labelled set": f"{times['labelled'].least * 1e6:.0f} us",
        "lost": str(sum(not len(inverse_kinematics(robot, X, tolerance=1e-6)) for X in round_T)),
    }
    if rival is not None:
        eaik = times["eaik"].least
        row |= {
            "EAIK": f"{eaik * 1e6:.2f} us",
            "batch ratio": f"{eaik / mine:.1f}",
            f"ratio of {BLOCK}": f"{eaik / block:.1f}",
        }
        row |= {
            "single ratio": f"{eaik / times['single'].least:.2f}",
            "EAIK lost": str(sum(not _reached(robot, rival, X) for X in round_T)),
        }
    return row


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
