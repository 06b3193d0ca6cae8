"""How fast and how sure is numerical inverse kinematics, beside Robotics Toolbox's ik_LM in C++, in the same run?

python benchmarks/ik_numerical.py [--robots panda ur5e ...] [--poses 10000] [--rtb PYTHON] [--json FILE]

Random reachable poses within the limits, no seed given, every answer rechecked by forward kinematics. Ours: tolerance
1e-10 [m, rad]; batch on one core and single calls. Means and ratios are of the thread's processor time, which other
programs on the machine touch less than the clock; medians are of the clock. The rival gets the same chains and poses,
starts of its own, 30 iterations, 100 searches, limits on; its tolerance E = |e|^2 / 2 is 1e-12, so its errors are near
1e-6. `--rtb` names the interpreter of an environment with roboticstoolbox-python (its dependencies need not fit ours);
without it only ours is measured. What TRAC-IK published of the same arms (other machine, errors 1e-5) stands beside.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter, thread_time
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
os.environ.setdefault("MAFSIL_THREADS", "1")

import numpy as np  # noqa: E402

from benchmarks.stopwatch import machine  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.geometry import pose  # noqa: E402
from mafsil.ik import solve_ik  # noqa: E402
from mafsil.model import JointKind  # noqa: E402
from mafsil.model.exponentials import chain_to_tip  # noqa: E402
from mafsil.robot import Robot  # noqa: E402
from tests.reliability.ik_arms import ARMS, arm  # noqa: E402
from tests.reliability.ik_numerical import PUBLISHED, targets  # noqa: E402

ROBOTS = ("panda", "fr3", "iiwa7", "ur5e", "puma560", "stanford_arm", "kinova", "baxter", "pr2", "tiago", "talos", "z1")
BATCH_TARGET, SINGLE_TARGET = 30.0, 5.0
"""Ratios of DESIGN.md section 7."""


def main() -> None:
    arguments = _arguments()
    rows = [_row(name, arguments) for name in arguments.robots if arm(name) is not None]
    facts = machine("numpy", "numba")
    print(", ".join(f"{key} {value}" for key, value in facts.items()))
    print(f"targets: batch {BATCH_TARGET:g} times, single {SINGLE_TARGET:g} times ik_LM")
    for row in rows:
        print("  ".join(f"{key} {value}" for key, value in row.items()))
    if arguments.json:
        Path(arguments.json).write_text(json.dumps({"machine": facts, "rows": rows}, indent=2))


def _row(name: str, arguments: argparse.Namespace) -> dict[str, str]:
    robot = arm(name)
    assert robot is not None
    T = targets(robot, arguments.poses, 9)
    solve_ik(robot, T[:4])
    solve_ik(robot, T[0])
    batch: list[float] = []
    rival = _rival(robot, T[: arguments.rival_poses], arguments.rtb)
    for _ in range(5):
        begin = thread_time()
        answer = solve_ik(robot, T)
        batch.append((thread_time() - begin) / len(T))
    clock, work = _singles(robot, T[: arguments.rival_poses])
    mine = min(batch) * 1e6
    row = {
        "robot": name,
        "joints": str(robot.n),
        "poses": str(len(T)),
        "solved": f"{answer.solved.mean():.4%}",
        "worst error": f"{_errors(robot, answer.q, T).max():.1e}",
        "batch": f"{mine:.2f} us",
        "single mean": f"{work.mean():.1f} us",
        "median": f"{np.median(clock):.1f} us",
        "p95": f"{np.quantile(clock, 0.95):.1f} us",
        "attempts": f"{answer.attempts.mean():.2f}",
    }
    for solver, (share, mean) in PUBLISHED.get(name, {}).items():
        row[f"{solver} published"] = f"{share:.2%} {mean:.0f} us"
    if rival is None:
        return row
    theirs, worked, q = np.array(rival["seconds"]) * 1e6, np.array(rival["work"]) * 1e6, rival["q"]
    found = np.array([each is not None for each in q])
    good = np.zeros(len(q), bool)
    if found.any():
        rows = np.array([each for each in q if each is not None])
        inside = ((rows >= robot.limits.lower - 1e-9) & (rows <= robot.limits.upper + 1e-9)).all(axis=1)
        good[found] = (_errors(robot, rows, T[: len(q)][found]) < 1e-4) & inside
    return row | {
        f"ik_LM {rival['version']}": f"{good.mean():.2%}",
        "mean": f"{worked.mean():.0f} us",
        "its median": f"{np.median(theirs):.0f} us",
        "batch ratio": f"{worked.mean() / mine:.0f}",
        "single ratio": f"{worked.mean() / work.mean():.1f}",
        "median ratio": f"{np.median(theirs) / np.median(clock):.1f}",
    }


def _singles(robot: Robot, T: Floats) -> tuple[Floats, Floats]:
    """Clock and processor time of one call for each pose [us]."""
    times: list[tuple[float, float]] = []
    for pose_wanted in T:
        begin, worked = perf_counter(), thread_time()
        solve_ik(robot, pose_wanted)
        work = thread_time() - worked
        times.append((perf_counter() - begin, work))
    clock, work = np.array(times).T * 1e6
    return clock, work


def _errors(robot: Robot, q: Floats, T: Floats) -> Floats:
    e = pose.error(robot.forward_kinematics(q), T)
    return np.maximum(np.linalg.norm(e[:, :3], axis=1), np.linalg.norm(e[:, 3:], axis=1))


def _rival(robot: Robot, T: Floats, python: str | None) -> dict[str, Any] | None:
    """What ik_LM gives for the same chain and poses."""
    if python is None:
        return None
    lower, upper = np.array(robot.limits.lower), np.array(robot.limits.upper)
    chain = {
        "constants": _constants(robot),
        "slides": [joint.kind is JointKind.PRISMATIC for joint in robot.mechanism.coordinates],
        "lower": np.where(np.isfinite(lower), lower, -np.pi),
        "upper": np.where(np.isfinite(upper), upper, np.pi),
        "T": T,
        "tolerance": 1e-12,
    }
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "chain.npz"
        np.savez(path, **chain)
        script = Path(__file__).with_name("ik_rival_rtb.py")
        done = subprocess.run([python, str(script), str(path)], capture_output=True, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def _constants(robot: Robot) -> Floats:
    """(n + 1, 4, 4) poses between the joints, whose axes are made the z axes."""
    mechanism = robot.mechanism
    constants, T = [], np.array(mechanism.T_sb)
    for joint in chain_to_tip(mechanism):
        T = T @ joint.T_pj
        if joint.moves:
            A = np.eye(4)
            A[:3, :3] = _towards(np.asarray(joint.axis, dtype=np.float64))
            constants.append(T @ A)
            T = A.T
    return np.array([*constants, T @ mechanism.T_lt])


def _towards(axis: Floats) -> Floats:
    """(3, 3) a rotation whose z axis is the given one."""
    x = np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())])
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(axis, x), axis], axis=1)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", nargs="+", default=ROBOTS, choices=list(ARMS))
    parser.add_argument("--poses", type=int, default=10_000)
    parser.add_argument("--rival-poses", type=int, default=1000)
    parser.add_argument("--rtb", help="interpreter with roboticstoolbox-python")
    parser.add_argument("--json")
    return parser.parse_args()


if __name__ == "__main__":
    main()
