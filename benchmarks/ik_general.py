"""How fast are all postures of arms without an elementary closed form, beside ssik (C++), in the same run?

python benchmarks/ik_general.py [--six jaco2 crx10ia hc10 xarm6] [--seven iiwa7 panda] [--poses 1000] [--json FILE]

Six joints: ssik's prebuilt solvers of published arms and `mafsil.inverse_kinematics` for the same geometry, read from
ssik's forward kinematics: one pose, 32 poses and `--poses` poses at once; random reachable poses, no joint limits. The
lists are compared before anything is timed, ours checked by the rival's forward kinematics; "lost" counts the poses
whose planted configuration did not come back. The elimination alone stands below to explain. ssik takes one pose a
call; its options are bound outside the clock. Seven joints: a sweep over sixteen values of the free joint, beside
ssik's sweep within the limits; and all branches at one value of the last joint, beside frankik where it is installed
(`--frankik FOLDER` where it is unpacked). Preparation is that of a new arm in a process that has solved another one
before; ssik's is its derivation from axes, published as minutes and not run here. All on one thread.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from dataclasses import replace
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from itertools import cycle
from pathlib import Path
from time import perf_counter
from types import SimpleNamespace
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

from benchmarks.stopwatch import machine, race  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.geometry import pose  # noqa: E402
from mafsil.ik import SolutionBatch, inverse_kinematics  # noqa: E402
from mafsil.ik.chain import chain_of  # noqa: E402
from mafsil.ik.general import GeneralSix  # noqa: E402
from mafsil.ik.redundant import redundancy  # noqa: E402
from mafsil.robot import Robot, load  # noqa: E402

SIX = {
    "jaco2": "kinova.jaco2_ik",
    "crx10ia": "fanuc.crx10ia_ik",
    "hc10": "yaskawa.hc10_ik",
    "xarm6": "ufactory.xarm6_ik",
}
SEVEN = {"iiwa7": "kuka.iiwa7_ik", "panda": "franka.panda_ik"}
TARGETS = (5.0, 30.0)
SOME = 32
VALUES = 16


def main() -> None:
    arguments = _arguments()
    os.environ["MAFSIL_THREADS"] = "1"
    rows = [_six(name, arguments.poses) for name in arguments.six]
    rows += [_sweep(name, arguments.poses) for name in arguments.seven]
    if arguments.frankik:
        sys.path.insert(0, arguments.frankik)
    if find_spec("frankik"):
        rows.append(_held(arguments.poses))
    facts = machine("numpy", "numba", "ssik")
    print(", ".join(f"{key} {value}" for key, value in facts.items()))
    print(
        "targets: six joints, single {:g} and batch {:g} times ssik on one core, preparation below 1 s;".format(
            *TARGETS
        )
    )
    print("seven joints, sweep 20 times ssik's, one value 10 times frankik")
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
    count = {"some": min(SOME, poses), "all": poses, "alone, all": poses}
    each = {key: value.least / count.get(key, 1) for key, value in times.items()}
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


def _limited(name: str, forward: Any) -> Robot:
    """An arm read from its forward kinematics, with the limits of the library."""
    mechanism, limits = robot_of(forward, 7).mechanism, load(name).limits
    bounds = iter(zip(limits.lower, limits.upper, strict=True))
    joints = [
        replace(joint, limits=replace(joint.limits, lower=bound[0], upper=bound[1]))
        if joint.moves and (bound := next(bounds))
        else joint
        for joint in mechanism.joints
    ]
    return Robot(replace(mechanism, joints=tuple(joints)))


def _sweep(name: str, poses: int) -> dict[str, str]:
    """All postures at sixteen values of the free parameter."""
    rival = import_module(f"ssik.prebuilt.{SEVEN[name]}")
    robot = _limited(name, rival)
    form = redundancy(robot)
    q = np.random.default_rng(1).uniform(robot.limits.lower, robot.limits.upper, (poses, 7))
    T = np.array([rival.fk(x) for x in q])
    turn = iter(range(10**9))
    few = min(poses, 200)
    tasks = {"ours": lambda: form.sweep(T, VALUES), "ssik": lambda: rival.solve(T[next(turn) % few])}
    times = race(tasks, repeats=7, seconds=0.1)
    found = form.solve(T, form.value(q)[:, None])
    lost = sum(_apart(s[np.isfinite(s[:, 0])], x) > 1e-6 for s, x in zip(found.q[:, 0], q, strict=True))
    swept = form.sweep(T, VALUES)
    mine = times["ours"].least / poses
    each = f"{np.isfinite(swept.residual).sum() / poses:.1f}, within the limits {swept.within.sum() / poses:.1f}"
    return {
        "robot": name,
        "parameter": form.parameter,
        "sweep": f"{mine * 1e6:.2f} us a pose for {VALUES} values",
        "ssik": f"{times['ssik'].least * 1e6:.0f} us",
        "ratio": f"{times['ssik'].least / mine:.1f}",
        "postures": each,
        "ssik postures": f"{np.mean([len(rival.solve(X)) for X in T[:few]]):.1f}",
        "lost": f"{lost} of {poses}",
        "worst": f"{max(_worst(rival, swept.q[i][swept.within[i]], T[i]) for i in range(20)):.0e}",
    }


def _held(poses: int) -> dict[str, str]:
    """All postures at one value of the last joint."""
    frankik: Any = import_module("frankik")
    # Its inverse takes the pose of a frame that its forward kinematics is a hand's offset away from.
    hand = pose.inverse(pose.exp(np.array([0.0, 0.0, -np.pi / 4, 0.0, 0.0, 0.1034])))
    rival = SimpleNamespace(fk=lambda x: frankik.fk(x) @ hand)
    robot = _limited("panda", rival)
    form = redundancy(robot, robot.joint_names[6])
    assert form.closed is not None
    closed = form.closed
    q = np.random.default_rng(2).uniform(robot.limits.lower, robot.limits.upper, (poses, 7))
    T = np.array([rival.fk(x) for x in q])
    near = np.zeros((poses, 7))
    near[:, 6] = q[:, 6]
    turn = iter(range(10**9))

    def one() -> Any:
        i = next(turn) % poses
        return frankik.ik_full(T[i], q[i], q[i, 6])

    tasks = {"judged": lambda: form.solve(T, q[:, 6:]), "bare": lambda: closed.solve(T, near), "frankik": one}
    times = race(tasks, repeats=9, seconds=0.05)
    found = form.solve(T, q[:, 6:])
    lost = sum(_apart(s[np.isfinite(s[:, 0])], x) > 1e-6 for s, x in zip(found.q[:, 0], q, strict=True))
    theirs = sum(not _apart(np.asarray(frankik.ik_full(X, x, x[6])), x) < 1e-4 for X, x in zip(T, q, strict=True))
    judged, bare, other = (times[key].least for key in ("judged", "bare", "frankik"))
    return {
        "robot": "panda at a given joint 7",
        "judged and wound into limits": f"{judged / poses * 1e6:.3f} us a pose",
        "bare table of branches": f"{bare / poses * 1e6:.3f} us",
        "frankik": f"{other * 1e6:.2f} us",
        "ratios": f"{other / judged * poses:.1f} and {other / bare * poses:.1f}",
        "lost": f"{lost} of {poses}",
        "frankik lost": f"{theirs} of {poses}",
    }


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
    parser.add_argument("--seven", nargs="*", default=list(SEVEN))
    parser.add_argument("--frankik", help="folder of an unpacked frankik")
    parser.add_argument("--poses", type=int, default=1000)
    parser.add_argument("--json")
    return parser.parse_args()


if __name__ == "__main__":
    main()
