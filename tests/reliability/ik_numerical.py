"""Row R5: numerical inverse kinematics by TRAC-IK's protocol: reachable poses, a mid-range seed, one call per pose.

python -m tests.reliability.ik_numerical --cases 1000000 --robots panda ur5e ... [--resume DIR]

Every shard is one arm. A pose counts as solved if the call says so within 5 ms of its core's time and the answer,
rechecked by the robot's own forward kinematics, is within 1e-9 m and rad and within the limits. TRAC-IK's published
figures for the same protocol (README of version 1.4.6, seed mid-range, errors 1e-5, 5 ms) stand in PUBLISHED.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path
from time import perf_counter, thread_time

import numpy as np

from mafsil.geometry import pose
from mafsil.ik import solve_ik
from mafsil.robot import Robot
from tests.reliability import figures
from tests.reliability.ik_arms import ARMS, arm

LIMIT, SECONDS = 1e-9, 5e-3
RATE = 0.99999

PUBLISHED = {
    "panda": {"KDL": (0.6177, 2140.0), "TRAC-IK": (0.9970, 380.0)},
    "baxter": {"KDL": (0.6107, 2210.0), "TRAC-IK": (0.9962, 430.0)},
    "kinova": {"KDL": (0.2623, 3790.0), "TRAC-IK": (0.9978, 410.0)},
    "pr2": {"KDL": (0.8318, 1370.0), "TRAC-IK": (0.9995, 380.0)},
}
"""Arm -> solver -> share solved, mean time [us]; facts from TRAC-IK's README, of its 22 chains those here."""


def targets(robot: Robot, count: int, seed: int) -> np.ndarray:
    """Poses of uniform configurations within the limits, a turn where there are none."""
    rng = np.random.default_rng(seed)
    lower = np.where(np.isfinite(robot.limits.lower), robot.limits.lower, -np.pi)
    upper = np.where(np.isfinite(robot.limits.upper), robot.limits.upper, np.pi)
    return robot.forward_kinematics(rng.uniform(lower, upper, (count, robot.n)))


def shard(name: str, count: int, seed: int = 0) -> dict[str, float]:
    """Solve `count` poses of one arm one by one, and count."""
    robot = arm(name)
    if robot is None:
        return {"poses": 0}
    lower, upper = np.array(robot.limits.lower), np.array(robot.limits.upper)
    bounded = np.isfinite(lower) & np.isfinite(upper)
    middle = np.where(bounded, (np.where(bounded, lower, 0) + np.where(bounded, upper, 0)) / 2, 0.0)
    found = {"poses": 0, "missed": 0, "late": 0, "bad_pose": 0, "bad_limit": 0}
    times: list[float] = []
    worked = 0.0
    for begin in range(0, count, 10_000):
        T = targets(robot, min(10_000, count - begin), seed * 1_000_003 + begin)
        solve_ik(robot, T[0], middle)
        q, said = np.empty((len(T), robot.n)), np.zeros(len(T), bool)
        for k in range(len(T)):
            wall, work = perf_counter(), thread_time()
            answer = solve_ik(robot, T[k], middle)
            work, wall = thread_time() - work, perf_counter() - wall
            times.append(wall)
            worked += work
            q[k], said[k] = answer.q, bool(answer.solved)
            found["late"] += work > SECONDS
        error = pose.error(robot.forward_kinematics(q), T)
        missed = np.maximum(np.linalg.norm(error[:, :3], axis=1), np.linalg.norm(error[:, 3:], axis=1)) > LIMIT
        found["poses"] += len(T)
        found["missed"] += int((~said).sum())
        found["bad_pose"] += int((missed & said).sum())
        found["bad_limit"] += int((((q < lower) | (q > upper)).any(axis=1) & said).sum())
    allowed = int(np.ceil((1.0 - RATE) * count))
    found["bad_rate"] = max(0, found["missed"] + found["late"] - allowed)
    return {**found, f"median_us_{name}": np.median(times) * 1e6, f"mean_processor_us_{name}": worked / count * 1e6}


def summary(sums: dict[str, object]) -> tuple[dict[str, object], dict[str, dict[str, int]]]:
    """The sums with the largest times of all arms, and the times of every arm."""
    arms: dict[str, dict[str, int]] = {}
    kept: dict[str, object] = {}
    for key, value in sums.items():
        for stem in ("median_us", "mean_processor_us"):
            if key.startswith(stem + "_"):
                arms.setdefault(key.removeprefix(stem + "_"), {})[stem] = round(float(str(value)))
                break
        else:
            kept[key] = value
    for stem in ("median_us", "mean_processor_us"):
        kept[f"largest_{stem}"] = max((row[stem] for row in arms.values()), default=0)
    return kept, arms


def main() -> None:
    """All arms asked for, one shard each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=10_000, help="poses for each arm")
    parser.add_argument("--robots", nargs="+", default=list(ARMS), choices=list(ARMS))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--resume", type=Path, default=None)
    given = parser.parse_args()
    folder = given.resume or Path(tempfile.mkdtemp(prefix="mafsil-R5-"))
    options = argparse.Namespace(count=len(given.robots), shard=1, seed=0, resume=folder)
    sums = figures.run("R5", options, lambda k, _: shard(given.robots[k], given.cases, given.seed))
    whole, arms = summary(sums)
    (folder / "R5.json").write_text(json.dumps(whole, indent=1))
    (folder / "R5-arms.json").write_text(json.dumps(arms, indent=1))
    print(json.dumps({"published": PUBLISHED}))


if __name__ == "__main__":
    main()
