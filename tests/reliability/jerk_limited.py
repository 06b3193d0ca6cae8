"""R11: jerk-limited motions from random states to random states, held against their limits and against Ruckig.

`python -m tests.reliability.jerk_limited --problems 1000000 --resume DIR`

Limits are looked at where each piece takes its extremes, not at samples. Every hundredth problem in any case, all of
them with Ruckig installed, is solved by Ruckig too. Ends are compared relative to the way and the largest state.
"""

from __future__ import annotations

import importlib
import sys
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.trajectory import MotionLimits, jerk_limited
from mafsil.trajectory.jerk import JerkLimitedBatch, JerkLimitedMotion
from tests.reliability import figures

KINDS = ("rest", "arbitrary", "outside", "asymmetric")
COORDINATES = (1, 2, 3, 7)
CHUNK = 500
LIMIT, LONGER = 1e-9, 1e-6


def random_problems(rng: np.random.Generator, count: int, n: int, kind: str) -> tuple[Floats, MotionLimits]:
    """(count, n, 6) states whose goals can be reached, and limits."""
    upper = {name: rng.uniform(low, high, n) for name, low, high in (("v", 0.3, 3), ("a", 0.3, 5), ("j", 0.5, 20))}
    sides = rng.uniform(0.3, 2.0, (2, n)) if kind in ("asymmetric", "outside") else np.ones((2, n))
    limits = MotionLimits.of(
        n,
        velocity=(-upper["v"] * sides[0], upper["v"]),
        acceleration=(-upper["a"] * sides[1], upper["a"]),
        jerk=upper["j"],
    )
    x = np.zeros((count, n, 6))
    x[..., 0] = rng.uniform(-3, 3, (count, n))
    x[..., 3] = x[..., 0] + rng.normal(size=(count, n)) * np.exp(rng.normal(size=(count, n)) * 1.5)
    if kind == "rest":
        return x, limits
    wide = 1.4 if kind == "outside" else 1.0
    for k, bounds, size in (
        (1, limits.velocity, wide),
        (2, limits.acceleration, wide),
        (4, limits.velocity, 1.0),
        (5, limits.acceleration, 1.0),
    ):
        x[..., k] = size * rng.uniform(*bounds, (count, n))
    x[..., 1:3][rng.random((count, n, 2)) < 0.1] = 0.0
    x[..., 4:6][rng.random((count, n, 2)) < 0.1] = 0.0
    for _ in range(60):
        x[..., 5] *= np.where(_late(x, limits), 0.75, 1.0)
    x[..., 5] *= ~_late(x, limits)
    return x, limits


def _late(x: Floats, limits: MotionLimits) -> Floats:
    """Goals that could only be reached from outside the limits of velocity."""
    before = x[..., 4] - 0.5 * x[..., 5] * np.abs(x[..., 5]) / limits.jerk[1]
    low, high = limits.velocity
    return (before < low + 1e-9) | (before > high - 1e-9)


def solve(x: Floats, limits: MotionLimits) -> JerkLimitedBatch:
    batch = jerk_limited(
        x[..., 0],
        x[..., 3],
        limits,
        start_velocity=x[..., 1],
        start_acceleration=x[..., 2],
        goal_velocity=x[..., 4],
        goal_acceleration=x[..., 5],
    )
    assert isinstance(batch, JerkLimitedBatch)
    return batch


def violations(times: Floats, jerks: Floats, count: Floats, first: Floats, limits: Floats) -> tuple[Floats, Floats]:
    """Largest excess over the limits, relative to each, and the last states.

    Args:
        times, jerks: (rows, n, pieces).
        count: (rows, n).
        first: (rows, n, 6).
        limits: (n, 6).

    Returns:
        (rows,), of which pieces of braking are left out; and (rows, n, 3).
    """
    p, v, a = first[..., 0], first[..., 1], first[..., 2]
    worst = np.zeros(len(times))
    braking = (times[..., :2] > 0.0).any(axis=-1)
    inside = np.ones_like(braking)
    for k in range(times.shape[-1]):
        used = k < count
        t, j = np.where(used, times[..., k], 0.0), np.where(used, jerks[..., k], 0.0)
        if k == 2:
            # What braking could not prevent, since the other limit is as near, is not held against the motion.
            inside = ~braking | (_excess(v, limits[:, 0], limits[:, 1]) <= LIMIT)
        if k >= 2:
            with np.errstate(divide="ignore", invalid="ignore"):
                turn = np.where(j != 0.0, np.clip(-a / j, 0.0, t), 0.0)
            values = [
                _excess(v + turn * (a + 0.5 * turn * j), limits[:, 0], limits[:, 1]),
                _excess(v, limits[:, 0], limits[:, 1]),
            ]
            values.append(_excess(a, limits[:, 2], limits[:, 3]))
            worst = np.maximum(worst, np.where(inside & (t > 0), np.max(values, axis=0), 0.0).max(axis=-1))
        worst = np.maximum(worst, _excess(j, limits[:, 4], limits[:, 5]).max(axis=-1))
        worst = np.maximum(worst, (-t).max(axis=-1))
        p, v, a = p + t * (v + t * (a / 2 + t * j / 6)), v + t * (a + t * j / 2), a + t * j
    return worst, np.stack([p, v, a], axis=-1)


def _excess(x: Floats, low: Floats, high: Floats) -> Floats:
    over, under = np.where(np.isinf(high), -1.0, x - high), np.where(np.isinf(low), -1.0, low - x)
    return np.maximum(over / np.maximum(1.0, np.abs(high)), under / np.maximum(1.0, np.abs(low)))


def violation(motion: JerkLimitedMotion) -> float:
    """Largest excess of one motion over its limits."""
    p = motion.pieces
    return float(violations(p.times, p.jerks, p.count, p.first, motion.problem.limits)[0][0])


def compared(rng: np.random.Generator, count: int, n: int, kind: str) -> dict[str, int]:
    """Counts of what went wrong with so many problems."""
    x, limits = random_problems(rng, count, n, kind)
    batch = solve(x, limits)
    p = batch.pieces
    worst, last = violations(p.times, p.jerks, p.count, p.first, batch.problem.limits)
    size = 1.0 + np.abs(x).max(axis=(1, 2)) + np.abs(x[..., 1]).max(axis=1) * batch.duration
    missed = np.abs(last - x[..., 3:]).max(axis=(1, 2)) / size
    found = {
        "problems": count,
        "bad_failed": int((~batch.valid).sum()),
        "bad_limits": int((worst > LIMIT).sum()),
        "bad_ends": int((missed > LIMIT).sum()),
    }
    theirs = ruckig_durations(x, limits)
    if theirs is not None:
        known = np.isfinite(theirs)
        longer = batch.duration[known] - theirs[known]
        found["compared"] = int(known.sum())
        found["ruckig_failed"] = int((~known).sum())
        found["bad_longer"] = int((longer > LONGER * theirs[known]).sum())
        found["shorter"] = int((longer < -LONGER * theirs[known]).sum())
    return found


def ruckig_durations(x: Floats, limits: MotionLimits) -> Floats | None:
    """Ruckig's durations, NaN where it fails; None where it is not installed."""
    try:
        ruckig: Any = importlib.import_module("ruckig")
    except ImportError:
        return None
    n = x.shape[1]
    solver, ask, answer = ruckig.Ruckig(n), ruckig.InputParameter(n), ruckig.Trajectory(n)
    ask.min_velocity, ask.max_velocity = limits.velocity
    ask.min_acceleration, ask.max_acceleration = limits.acceleration
    ask.max_jerk = limits.jerk[1]
    found = np.full(len(x), np.nan)
    for row, state in enumerate(x):
        ask.current_position, ask.current_velocity, ask.current_acceleration = state[:, 0], state[:, 1], state[:, 2]
        ask.target_position, ask.target_velocity, ask.target_acceleration = state[:, 3], state[:, 4], state[:, 5]
        if int(solver.calculate(ask, answer)) >= 0:
            found[row] = answer.duration
    return found


def work(seed: int, problems: int) -> dict[str, int]:
    """Counts of one shard: chunks of problems of all kinds and numbers of coordinates, each with limits of its own."""
    rng = np.random.default_rng([11, seed])
    total: dict[str, int] = {}
    for begin in range(0, problems, CHUNK):
        turn = begin // CHUNK
        kind, n = KINDS[turn % len(KINDS)], COORDINATES[(turn // len(KINDS)) % len(COORDINATES)]
        for name, value in compared(rng, min(CHUNK, problems - begin), n, kind).items():
            total[name] = total.get(name, 0) + value
    return total


if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "problems", 100_000, 50_000)
    sys.exit(not figures.run("R11", options, work)["passed"])
