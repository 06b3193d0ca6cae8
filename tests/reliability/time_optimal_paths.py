"""R11, paths: the shortest time along random paths of library arms keeps every limit between the places of its grid.

`python -m tests.reliability.time_optimal_paths --paths 10000 --seed 0 --resume DIR`

Each path is a random spline, or lines, of a random arm of the library, from 1e-6 of its reach to all of it, with
one-sided limits of velocity and acceleration, on a grid of 50 to 400 intervals. Judged at 4,000 times of the motion,
knots from both sides included: the excess over any limit, the ends, and that the motion moves on. Every twentieth
path has limits of effort instead of acceleration, judged by inverse dynamics and friction.
"""

from __future__ import annotations

import sys

import numpy as np

import mafsil as mf
from mafsil.robot import Robot
from mafsil.trajectory import JointPath, MotionLimits, time_optimal
from mafsil.trajectory.timing import TimeOptimal
from mafsil.trajectory.timing.timing_answer import TimingStatus
from tests.reliability import figures

ARMS = ("panda", "iiwa7", "ur5e", "ur10e", "puma560")
"""Of the library, all with masses."""
ALLOWED = 1e-6
TIMES = 4_000
EFFORTS_EVERY = 20


def question(seed: int, number: int, robots: list[Robot]) -> tuple[Robot, JointPath, MotionLimits, int]:
    """An arm, a path, its limits and how many intervals."""
    rng = np.random.default_rng([11, seed, number])
    robot = robots[int(rng.integers(len(robots)))]
    low, high = np.maximum(robot.limits.lower, -3.0), np.minimum(robot.limits.upper, 3.0)
    size = 10.0 ** rng.uniform(-6.0, 0.0) if rng.random() < 0.5 else 1.0
    points = (low + high) / 2 + size * 0.4 * (high - low) * rng.uniform(-1, 1, (int(rng.integers(2, 12)), robot.n))
    path = JointPath.through(points, "lines" if rng.random() < 0.2 else "spline")
    velocity, acceleration = (
        (-scale * r[0], scale * r[1]) for scale, r in zip((2.0, 8.0), rng.uniform(0.3, 2, (2, 2, robot.n)), strict=True)
    )
    limits = MotionLimits.of(robot.n, velocity=velocity, acceleration=acceleration)
    return robot, path, limits, int(rng.integers(50, 400))


def excess(answer: TimeOptimal, robot: Robot | None) -> float:
    """The largest excess over a limit at many times, as share of the limit."""
    motion_law = answer.trajectory
    assert motion_law is not None
    knots = motion_law.breaks()
    t = np.unique(np.concatenate([np.linspace(0.0, answer.duration, TIMES), knots, np.nextafter(knots[1:], 0.0)]))
    motion = motion_law.at(t)
    pairs = [(motion.v, answer.limits.velocity)]
    if robot is None:
        pairs.append((motion.a, answer.limits.acceleration))
    else:
        tau = robot.inverse_dynamics(motion.u, motion.v, motion.a) + robot.friction_torque(motion.v)
        pairs.append((tau, answer.limits.effort))
    return max(float((np.maximum(x - high, low - x) / np.maximum(high, -low)).max()) for x, (low, high) in pairs)


def judged(answer: TimeOptimal, path: JointPath, robot: Robot | None) -> dict[str, int]:
    """Counts of one answer."""
    if answer.status is TimingStatus.NO_REST:
        return {"too_weak": 1}
    if not answer:
        return {f"bad_{answer.status.name.lower()}": 1}
    worst = excess(answer, robot)
    assert answer.trajectory is not None
    ends = answer.trajectory.at([0.0, answer.duration])
    gap = np.abs(ends.u - path.at([0.0, path.end]).u).max()
    power = int(np.clip(np.floor(-np.log10(max(worst, 1e-18))), 0, 17))
    return {
        f"excess_below_1e-{power:02d}": 1,
        "bad_excess": int(worst > ALLOWED),
        "bad_claim": int(answer.excess > ALLOWED),
        "bad_ends": int(gap > 1e-9 or np.abs(ends.v).max() > 1e-9),
        "bad_still": int((np.diff(answer.velocities[:, 0]) <= 0.0).any() or not np.isfinite(answer.duration)),
    }


def work(seed: int, count: int) -> dict[str, int]:
    """Counts of one shard."""
    robots = [mf.load(name) for name in ARMS]
    total: dict[str, int] = {"paths": count, "with_efforts": 0}
    for number in range(count):
        robot, path, limits, intervals = question(seed, number, robots)
        dynamic = None
        if number % EFFORTS_EVERY == EFFORTS_EVERY - 1 and np.isfinite(robot.limits.effort).all():
            dynamic, total["with_efforts"] = robot, total["with_efforts"] + 1
            limits = MotionLimits.of(robot.n, velocity=tuple(limits.velocity), effort=robot.limits.effort)
        answer = time_optimal(path, limits, intervals=intervals, robot=dynamic)
        for name, value in judged(answer, path, dynamic).items():
            total[name] = total.get(name, 0) + value
    return total


if __name__ == "__main__":
    found = figures.run("R11-paths", figures.arguments(__doc__ or "", "paths", 10_000, 500), work)
    sys.exit(0 if found["passed"] else 1)
