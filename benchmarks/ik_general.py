"""How fast are all postures of arms without an elementary closed form, beside ssik (C++), in the same run?

python benchmarks/ik_general.py [--six jaco2 crx10ia hc10 xarm6] [--seven panda iiwa7] [--poses 2000] [--json FILE]

Six joints: ssik's prebuilt solvers of published arms and ours for the same geometry, read from ssik's forward
kinematics; random reachable poses, joint limits left out. Seven joints: a sweep over sixteen values of the free joint
within the limits, and all branches at one value. Every answer of ours is checked by ssik's forward kinematics, and
"lost" counts the poses whose planted configuration did not come back. Preparation is that of a new arm in a process
that has solved another one before; ssik's is its derivation from axes, published as minutes and not run here.
"""

from __future__ import annotations

import argparse
import json
import sys
from importlib import import_module
from pathlib import Path
from time import perf_counter
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

from benchmarks.stopwatch import machine, race  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.geometry import pose  # noqa: E402
from mafsil.ik.chain import chain_of  # noqa: E402
from mafsil.ik.general import GeneralSix  # noqa: E402
from mafsil.robot import Robot  # noqa: E402

SIX = {
    "jaco2": "kinova.jaco2_ik",
    "crx10ia": "fanuc.crx10ia_ik",
    "hc10": "yaskawa.hc10_ik",
    "xarm6": "ufactory.xarm6_ik",
}
TARGET = 30.0


def main() -> None:
    arguments = _arguments()
    rows = [_six(name, arguments.poses) for name in arguments.six]
    facts = machine("numpy", "numba", "ssik")
    print(", ".join(f"{key} {value}" for key, value in facts.items()))
    print(f"target: six joints, batch {TARGET:g} times ssik on one core, preparation below 1 s")
    for row in rows:
        print("  ".join(f"{key} {value}" for key, value in row.items()))
    if arguments.json:
        Path(arguments.json).write_text(json.dumps({"machine": facts, "rows": rows}, indent=2))


def robot_of(rival: Any, n: int) -> Robot:
    """The arm that a solver of ssik was made for, from its forward kinematics."""
    home = np.asarray(rival.fk(np.zeros(n)))
    moved = np.array([rival.fk(0.5 * np.eye(n)[k]) for k in range(n)])
    return Robot.from_screws(pose.log(moved @ pose.inverse(home)) / 0.5, home)


def _six(name: str, poses: int) -> dict[str, str]:
    rival = import_module(f"ssik.prebuilt.{SIX[name]}")
    robot = robot_of(rival, 6)
    chain = chain_of(robot.mechanism)
    assert chain is not None
    GeneralSix(chain.backwards()).solve(robot.forward_kinematics(np.zeros(6)))
    begin = perf_counter()
    solver = GeneralSix(chain)
    solver.solve(robot.forward_kinematics(np.zeros(6)))
    prepared = perf_counter() - begin
    rng = np.random.default_rng(1)
    q = rng.uniform(-np.pi, np.pi, (poses, 6))
    T = np.array([rival.fk(x) for x in q])
    turn = iter(range(10**9))
    few = min(poses, 200)
    times = race(
        {
            "batch": lambda: solver.solve_all(T, threads=1),
            "single": lambda: solver.solve_all(T[next(turn) % few], threads=1),
            "ssik": lambda: rival.solve(T[next(turn) % few], respect_limits=False, enumerate_windings=False),
        },
        repeats=7,
        seconds=0.1,
    )
    found = solver.solve_all(T)
    theirs = [
        np.array([s.q for s in rival.solve(X, respect_limits=False, enumerate_windings=False)]).reshape(-1, 6)
        for X in T[:few]
    ]
    ours = [found.q[i, : found.count[i]] for i in range(poses)]
    mine = times["batch"].least / poses
    return {
        "robot": name,
        "preparation": f"{prepared * 1e3:.0f} ms",
        "batch": f"{mine * 1e6:.1f} us a pose on one core",
        "single": f"{times['single'].least * 1e6:.0f} us",
        "ssik": f"{times['ssik'].least * 1e6:.0f} us",
        "batch ratio": f"{times['ssik'].least / mine:.1f}",
        "single ratio": f"{times['ssik'].least / times['single'].least:.1f}",
        "lost": f"{sum(_apart(s, x) > 1e-6 for s, x in zip(ours, q, strict=True))} of {poses}",
        "proven": f"{found.complete.mean():.4f}",
        "worst": f"{max(_worst(rival, s, X) for s, X in zip(ours[:few], T, strict=False)):.0e}",
        "solutions": f"{found.count[:few].mean():.3f}",
        "ssik solutions": f"{np.mean([len(_distinct(s)) for s in theirs]):.3f}",
        "ssik lost": f"{sum(_apart(s, x) > 1e-4 for s, x in zip(theirs, q, strict=False))} of {few}",
    }


def _apart(found: Floats, q: Floats) -> float:
    if not len(found):
        return np.inf
    return float(np.abs((found - q + np.pi) % (2 * np.pi) - np.pi).max(axis=1).min())


def _worst(rival: Any, found: Floats, T: Floats) -> float:
    return max((float(np.abs(rival.fk(x) - T).max()) for x in found), default=0.0)


def _distinct(found: Floats) -> list[Floats]:
    kept: list[Floats] = []
    for x in found:
        if _apart(np.array(kept).reshape(-1, found.shape[1]), x) > 1e-4:
            kept.append(x)
    return kept


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--six", nargs="*", default=list(SIX))
    parser.add_argument("--poses", type=int, default=2000)
    parser.add_argument("--json")
    return parser.parse_args()


if __name__ == "__main__":
    main()
