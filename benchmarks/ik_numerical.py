"""How fast and how sure is numerical inverse kinematics, beside a loop over Pinocchio, in the same run?

python benchmarks/ik_numerical.py [--robots panda ur5e ...] [--poses 10000] [--json FILE]

Random reachable poses within the limits, no seed given, tolerance 1e-10 [m, rad], every answer rechecked by forward
kinematics. The rival is the same damped least squares written over Pinocchio's forward kinematics, Jacobian and log6
with LAPACK's solver, clipped to the limits, restarted from uniform samples until it succeeds; times include failures.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402
import pinocchio as pin  # noqa: E402

from benchmarks.stopwatch import machine  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.geometry import pose  # noqa: E402
from mafsil.ik import solve_ik  # noqa: E402
from mafsil.robot import Robot, load  # noqa: E402
from tests.oracles.pinocchio_model import model_of  # noqa: E402

ROBOTS = ("panda", "iiwa7", "ur5e", "puma560")
TOLERANCE = 1e-10
SINGLES = 200
BATCH_TARGET, SINGLE_TARGET = 30.0, 5.0
"""Ratios of DESIGN.md section 7; its rival is Robotics Toolbox's ik_LM in C++, which no wheel of today brings."""


@dataclass
class Rival:
    """Damped least squares over Pinocchio, one pose at a time."""

    robot: Robot

    def __post_init__(self) -> None:
        self.model, frames = model_of(self.robot.mechanism)
        self.data, self.tip = self.model.createData(), frames[-1]
        limits = self.robot.limits
        self.lower = np.where(np.isfinite(limits.lower), limits.lower, -np.pi)
        self.upper = np.where(np.isfinite(limits.upper), limits.upper, np.pi)

    def solve(self, T: Floats, rng: np.random.Generator, restarts: int = 100) -> Floats | None:
        wanted = pin.SE3(T[:3, :3], T[:3, 3])
        for _ in range(restarts + 1):
            q = self._descend(wanted, rng.uniform(self.lower, self.upper))
            if q is not None:
                return q
        return None

    def _descend(self, wanted: Any, q: Floats, steps: int = 40) -> Floats | None:
        model, data, tip = self.model, self.data, self.tip
        for _ in range(steps):
            pin.framesForwardKinematics(model, data, q)
            e = pin.log6(data.oMf[tip].actInv(wanted)).vector
            if np.abs(e).max() <= TOLERANCE / 2:
                return q
            J = pin.computeFrameJacobian(model, data, q, tip, pin.LOCAL)
            damping = 0.02 * (e @ e) + 1e-14
            q = q + J.T @ np.linalg.solve(J @ J.T + damping * np.eye(6), e)
            q = np.clip(q, self.lower, self.upper)
        return None


def main() -> None:
    arguments = _arguments()
    rows = [_row(name, arguments.poses, arguments.rival_poses) for name in arguments.robots]
    facts = machine("numpy", "pin")
    print(", ".join(f"{key} {value}" for key, value in facts.items()))
    print(f"targets: batch {BATCH_TARGET:g} times, single {SINGLE_TARGET:g} times ik_LM; ratios below are to the rival")
    for row in rows:
        print("  ".join(f"{key} {value}" for key, value in row.items()))
    if arguments.json:
        Path(arguments.json).write_text(json.dumps({"machine": facts, "rows": rows}, indent=2))


def _row(name: str, poses: int, rival_poses: int) -> dict[str, str]:
    robot = load(name)
    rival = Rival(robot)
    rng = np.random.default_rng(9)
    T = robot.forward_kinematics(rng.uniform(rival.lower, rival.upper, (poses, robot.n)))
    solve_ik(robot, T[:4])
    batch, worked = [], []
    for _ in range(3):
        begin, used = perf_counter(), process_time()
        answer = solve_ik(robot, T, tolerance=TOLERANCE)
        batch.append((perf_counter() - begin) / poses)
        worked.append((process_time() - used) / poses)
    singles = _each(lambda k: solve_ik(robot, T[k], tolerance=TOLERANCE), SINGLES)
    solved: list[bool] = []
    others = _each(lambda k: solved.append(rival.solve(T[k], rng) is not None), rival_poses)
    error = np.abs(pose.error(robot.forward_kinematics(answer.q), T)).max()
    mine, his = min(batch), float(np.mean(others))
    return {
        "robot": name,
        "poses": str(poses),
        "solved": f"{answer.solved.mean():.4%}",
        "worst error": f"{error:.1e}",
        "batch": f"{mine * 1e6:.1f} us",
        "processor time": f"{min(worked) * 1e6:.1f} us",
        "single median": f"{np.median(singles) * 1e6:.0f} us",
        "p95": f"{np.quantile(singles, 0.95) * 1e6:.0f} us",
        "rival": f"{his * 1e6:.0f} us, {np.mean(solved):.2%}",
        "batch ratio": f"{his / mine:.1f}",
        "single ratio": f"{his / float(np.mean(singles)):.2f}",
        "attempts": f"{answer.attempts.mean():.2f}",
        "steps": f"{answer.iterations.mean():.1f}",
    }


def _each(task: Any, count: int) -> list[float]:
    """Seconds of each call."""
    taken = []
    for k in range(count):
        begin = perf_counter()
        task(k)
        taken.append(perf_counter() - begin)
    return taken


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", nargs="+", default=ROBOTS)
    parser.add_argument("--poses", type=int, default=10_000)
    parser.add_argument("--rival-poses", type=int, default=300)
    parser.add_argument("--json")
    return parser.parse_args()


if __name__ == "__main__":
    main()
