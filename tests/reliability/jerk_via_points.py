"""R11, via points: random motions through via points pass all of them, keep their limits, and beat stops.

`python -m tests.reliability.jerk_via_points --problems 100000 --resume DIR`
"""

from __future__ import annotations

import sys

import numpy as np

from mafsil.arrays import Floats
from mafsil.trajectory import MotionLimits, jerk_limited_through
from mafsil.trajectory.jerk import ViaMotion
from tests.reliability import figures
from tests.reliability.jerk_limited import LIMIT, violations

SIZES = ((3, 1), (3, 2), (4, 1), (4, 2), (5, 3), (8, 2))
CHUNK = 100


def random_vias(rng: np.random.Generator, count: int, m: int, n: int) -> tuple[Floats, MotionLimits]:
    """(count, m, n) points and limits."""
    limits = MotionLimits.of(
        n, velocity=rng.uniform(0.5, 2, n), acceleration=rng.uniform(0.5, 4, n), jerk=rng.uniform(2, 20, n)
    )
    return np.cumsum(rng.normal(size=(count, m, n)), axis=1), limits


def excess_through(motion: ViaMotion) -> float:
    """Largest excess over the limits, relative to each."""
    p = motion.motion.pieces
    # Two pieces without time in front: `violations` takes the first two for braking.
    times, jerks = (np.concatenate([np.zeros((1, motion.n, 2)), x], axis=-1) for x in (p.times, p.jerks))
    return float(violations(times, jerks, p.count + 2, p.first, motion.motion.problem.limits)[0][0])


def work(seed: int, problems: int) -> dict[str, int]:
    """Counts of one shard."""
    rng = np.random.default_rng([11, 36, seed])
    found = {"problems": problems, "bad_failed": 0, "bad_limits": 0, "bad_points": 0, "bad_longer_than_stops": 0}
    found["shorter_than_stops"] = 0
    for begin in range(0, problems, CHUNK):
        m, n = SIZES[(begin // CHUNK) % len(SIZES)]
        points, limits = random_vias(rng, min(CHUNK, problems - begin), m, n)
        motions = jerk_limited_through(points, limits)
        assert isinstance(motions, tuple)
        for row, motion in zip(points, motions, strict=True):
            if not motion:
                found["bad_failed"] += 1
                continue
            size = 1.0 + np.abs(row).max()
            found["bad_limits"] += excess_through(motion) > LIMIT
            found["bad_points"] += np.abs(motion.at(motion.passing).u - row).max() > LIMIT * size
            found["bad_longer_than_stops"] += motion.duration > motion.stops * (1.0 + 1e-12)
            found["shorter_than_stops"] += motion.duration < motion.stops * (1.0 - 1e-6)
    return {name: int(value) for name, value in found.items()}


if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "problems", 10_000, 5_000)
    sys.exit(not figures.run("R11-via", options, work)["passed"])
