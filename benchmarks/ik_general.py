"""How fast are all configurations of arms without an elementary closed form, beside ssik (C++), in the same run?

python benchmarks/ik_general.py [--six jaco2 crx10ia hc10 xarm6] [--poses 1000] [--json FILE]

Six joints: ssik's prebuilt solvers of published arms and `mafsil.inverse_kinematics` for the same geometry, read from
ssik's forward kinematics: one pose, 32 poses and `--poses` poses at once; random reachable poses, no joint limits. The
lists are compared before anything is timed, ours checked by the rival's forward kinematics; "lost" counts the poses
whose planted configuration did not come back. The elimination alone stands below to explain. ssik takes one pose a
call; its options are bound outside the clock. Preparation is that of a new arm in a process that has solved another one
before; ssik's is its derivation from axes, published as minutes and not run here. All on one thread. Where
crx-kinematics (Rust, for this arm alone, not among the dependencies) is installed, the CRX-10iA is raced with it too,
each at poses of its own frames. Seven joints have a benchmark of their own, `ik_redundant.py`.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from functools import partial
from importlib import import_module
from itertools import cycle
from pathlib import Path
from time import perf_counter
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

from benchmarks.comparison import Comparisons  # noqa: E402
from benchmarks.stopwatch import machine, race  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.geometry import pose  # noqa: E402
from mafsil.ik import SolutionBatch, inverse_kinematics  # noqa: E402
from mafsil.ik.chain import chain_of  # noqa: E402
from mafsil.ik.general import GeneralSix  # noqa: E402
from mafsil.robot import Robot  # noqa: E402

SIX = {
    "jaco2": "kinova.jaco2_ik",
    "crx10ia": "fanuc.crx10ia_ik",
    "hc10": "yaskawa.hc10_ik",
    "xarm6": "ufactory.xarm6_ik",
}
TARGETS = (5.0, 30.0)
CRX_TARGETS = (1.5, 10.0)
SOME = 32


def main() -> None:
    arguments = _arguments()
    os.environ["MAFSIL_THREADS"] = "1"
    found = Comparisons()
    rows = [_six(name, arguments.poses, found) for name in arguments.six]
    details = machine("numpy", "ssik")
    print(", ".join(f"{key} {value}" for key, value in details.items()))
    print(
        "targets: six joints, single {:g} and batch {:g} times ssik on one core, preparation below 1 s;".format(
            *TARGETS
        )
    )
    for row in rows:
        print("  ".join(f"{key} {value}" for key, value in row.items()))
    if arguments.json:
        Path(arguments.json).write_text(
            json.dumps({"machine": details, "rows": rows, "comparisons": found.plain()}, indent=2)
        )


def robot_of(rival: Any, n: int) -> Robot:
    """The arm that a solver of ssik was made for, from its forward kinematics."""
    home = np.asarray(rival.fk(np.zeros(n)))
    moved = np.array([rival.fk(0.5 * np.eye(n)[k]) for k in range(n)])
    return Robot.from_screws(pose.log(moved @ pose.inverse(home)) / 0.5, home)


def _six(name: str, poses: int, found: Comparisons) -> dict[str, str]:
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
    few = min(poses, 200)
    theirs_of = partial(rival.solve, respect_limits=False, enumerate_windings=False)
    # Compared first.
    answers = inverse_kinematics(robot, T)
    assert isinstance(answers, SolutionBatch)
    ours = [answers.q[i][answers.valid[i]] for i in range(poses)]
    theirs = [np.array([s.q for s in theirs_of(X)]).reshape(-1, 6) for X in T[:few]]
    proven = solver.solve_all(T).complete
    turns = {name: cycle(T[:few]) for name in ("one", "alone", "ssik")}
    some = cycle([T[i : i + SOME] for i in range(0, max(1, min(poses, 10 * SOME) - SOME + 1), SOME)])
    times = race(
        {
            "one": lambda: inverse_kinematics(robot, next(turns["one"])),
            "some": lambda: inverse_kinematics(robot, next(some)),
            "all": lambda: inverse_kinematics(robot, T),
            "alone": lambda: solver.solve_all(next(turns["alone"]), threads=1),
            "alone, all": lambda: solver.solve_all(T, threads=1),
            "ssik": lambda: theirs_of(next(turns["ssik"])),
        },
        repeats=7,
        seconds=0.1,
    )
    if name == "crx10ia":
        _race_crx(robot, T, found)
    count = {"some": min(SOME, poses), "all": poses, "alone, all": poses}
    each = {key: value.least / count.get(key, 1) for key, value in times.items()}
    for key, size, goal in (("one", 1, TARGETS[0]), ("some", SOME, None), ("all", poses, TARGETS[1])):
        call = f"mf.inverse_kinematics(robot, T), {size:,} pose{'s' * (size > 1)}"
        found.add(call, name, 1e6 * each[key], "ssik prebuilt", 1e6 * each["ssik"], goal)
    return {
        "robot": name,
        "preparation": f"{prepared * 1e3:.0f} ms",
        "one pose": f"{each['one'] * 1e6:.0f} us",
        f"{SOME} poses": f"{each['some'] * 1e6:.1f} us a pose",
        f"{poses} poses": f"{each['all'] * 1e6:.1f} us a pose",
        "ssik": f"{each['ssik'] * 1e6:.0f} us",
        "ratios": ", ".join(f"{each['ssik'] / each[key]:.1f}" for key in ("one", "some", "all")),
        "elimination alone": f"{each['alone'] * 1e6:.0f} us, {each['alone, all'] * 1e6:.1f} us a pose",
        "lost": f"{sum(_apart(s, x) > 1e-6 for s, x in zip(ours, q, strict=True))} of {poses}",
        "proven": f"{proven.mean():.4f}",
        "worst": f"{max(_worst(rival, s, X) for s, X in zip(ours[:few], T, strict=False)):.0e}",
        "solutions": f"{np.mean([len(s) for s in ours[:few]]):.3f}",
        "ssik solutions": f"{np.mean([len(_distinct(s)) for s in theirs]):.3f}",
        "ssik lost": f"{sum(_apart(s, x) > 1e-4 for s, x in zip(theirs, q, strict=False))} of {few}",
    }


def _race_crx(robot: Robot, T: Floats, found: Comparisons) -> None:
    """The CRX-10iA beside the solver that is made for it, if that is installed."""
    try:
        arm = import_module("crx_kinematics").Crx.crx10ia()
    except ImportError:
        return
    few = min(len(T), 200)
    theirs = cycle([np.asarray(arm.fk(x)) for x in np.random.default_rng(1).uniform(-180, 180, (few, 6))])
    ours = cycle(T[:few])
    times = race(
        {
            "one": lambda: inverse_kinematics(robot, next(ours)),
            "all": lambda: inverse_kinematics(robot, T),
            "crx": lambda: arm.ik(next(theirs)),
        },
        repeats=7,
        seconds=0.1,
    )
    rival = 1e6 * times["crx"].least
    for key, size, goal in zip(("one", "all"), (1, len(T)), CRX_TARGETS, strict=True):
        call = f"mf.inverse_kinematics(robot, T), {size:,} pose{'s' * (size > 1)}"
        found.add(call, "crx10ia", 1e6 * times[key].least / size, "crx-kinematics", rival, goal)


def _apart(found: Floats, q: Floats) -> float:
    if not len(found):
        return np.inf
    away = np.abs((found - q + np.pi) % (2 * np.pi) - np.pi).max(axis=1)
    return float(np.where(np.isnan(away), np.inf, away).min())


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
    parser.add_argument("--poses", type=int, default=1000)
    parser.add_argument("--json")
    return parser.parse_args()


if __name__ == "__main__":
    main()
