"""The search of numerical inverse kinematics: waves of damped least squares from more and more starts."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.problem import PoseProblem
from mafsil.ik.seeds import SeedPool

QUICK_WAVES = 4
"""Waves whose attempts are given up early; later ones are for the hard poses, which need patience."""

QUICK_STEPS, PATIENT_STEPS = 16, 40
"""Most steps of an attempt. Of those that succeed, nine of ten need less than twelve."""

QUICK_BARS: dict[int, float] = {8: 0.1, 12: 0.01}
"""Step -> the scaled error above which a quick attempt is given up there; few of these would have succeeded."""

PATIENT_BARS: dict[int, float] = {16: 0.3}
"""The same for patient attempts."""

LANES = 4096
"""Attempts that run at once: their arrays fit the cache."""

Rows = NDArray[np.intp]


class Search:
    """Damped least squares for many poses at once.

    dq = J' (J J' + lambda I)^-1 e,  e = log(T_sf(q)^-1 T_sd),  lambda ~ |e|^2

    Steps are not refused when the error grows. Joints at a bound that the step would push further are held. Each wave
    tries the poses still open from twice as many starts as the one before; of the starts that succeed the first counts.

    Attributes:
        q: (k, n) the solution of each pose, or the nearest configuration so far.
        error: (k,) its scaled error norm.
        solved: (k,) whether it is within the tolerance.
        iterations, attempts: (k,) effort spent.
    """

    def __init__(
        self, problem: PoseProblem, target: PoseMatrix, pool: SeedPool, first: JointVector | None, tolerance: float
    ) -> None:
        k = len(target)
        self.problem, self.target, self.pool, self.first, self.tolerance = problem, target, pool, first, tolerance
        self.q = np.full((k, problem.robot.n), np.nan)
        self.error = np.full(k, np.inf)
        self.solved = np.zeros(k, dtype=np.bool_)
        self.iterations = np.zeros(k, dtype=np.int64)
        self.attempts = np.zeros(k, dtype=np.int64)
        self._scale = np.repeat([1.0, 1.0 / problem.length], 3)

    def run(self, rows: Rows, restarts: int) -> None:
        """Work until every row is solved or has used its restarts."""
        for wave, (begin, width) in enumerate(_waves(restarts + 1)):
            rows = rows[~self.solved[rows]]
            together = max(1, LANES // width)
            for some in (rows[i : i + together] for i in range(0, len(rows), together)):
                self._wave(some, wave, begin, width)

    def _wave(self, rows: Rows, wave: int, begin: int, width: int) -> None:
        """Try each row from `width` starts and keep the first success, else the nearest miss."""
        starts = np.stack([self._start(rows, wave, begin + k) for k in range(width)], axis=1)
        q, error, steps = self._descend(np.repeat(rows, width), starts.reshape(-1, starts.shape[-1]), wave)
        q, error, steps = q.reshape(starts.shape), error.reshape(-1, width), steps.reshape(-1, width)
        solved = error == 0.0
        found = solved.any(axis=1)
        best = np.where(found, solved.argmax(axis=1), error.argmin(axis=1))
        picked = np.arange(len(rows)), best
        better = error[picked] < self.error[rows]
        self.q[rows[better]], self.error[rows[better]] = q[picked][better], error[picked][better]
        self.solved[rows] = found
        self.iterations[rows] += steps.sum(axis=1)
        self.attempts[rows] += np.where(found, best + 1, width)

    def _descend(self, rows: Rows, start: JointVector, wave: int) -> tuple[JointVector, Floats, NDArray[np.int64]]:
        """Iterate from each start; returns the best q of each, its error norm (0 within the tolerance), its steps."""
        best, error, steps = start.copy(), np.full(len(rows), np.inf), np.zeros(len(rows), dtype=np.int64)
        lanes, q, target = np.arange(len(rows)), start, self.target[rows]
        quick = wave < QUICK_WAVES
        bars = QUICK_BARS if quick else PATIENT_BARS
        for step in range((QUICK_STEPS if quick else PATIENT_STEPS) + 1):
            ahead, twist = self.problem.stepped(q, target)
            e = twist * self._scale
            size = np.sqrt((e * e).sum(axis=1))
            done = np.abs(twist).max(axis=1) <= self.tolerance / 2
            better = size < error[lanes]
            improved = lanes[better]
            best[improved], error[improved] = q[better], size[better]
            error[lanes[done]] = 0.0
            steps[lanes] = step
            keep = ~done & (size <= bars.get(step, np.finfo(np.float64).max))
            if not keep.all():
                lanes, ahead, target = lanes[keep], ahead[keep], target[keep]
            if not len(lanes):
                break
            q = ahead
        return best, error, steps

    def _start(self, rows: Rows, wave: int, attempt: int) -> JointVector:
        """(k, n) where attempt number `attempt` begins."""
        if self.first is None:
            return self.pool.nearest(self.target[rows], wave, attempt)
        if attempt == 0:
            return self.problem.clipped(self.first[rows])
        return self.pool.nearest(self.target[rows], wave - 1, attempt)


def _waves(attempts: int) -> Iterator[tuple[int, int]]:
    """First attempt and width of each wave: 1, 1, 2, 4, ... until all attempts are used."""
    begin, width = 0, 1
    while begin < attempts:
        yield begin, min(width, attempts - begin)
        begin, width = begin + width, max(begin + width, 1)
