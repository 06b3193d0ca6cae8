"""Starts for numerical inverse kinematics: sampled configurations whose poses are near the wanted ones."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.problem import PoseProblem

FIRST_CHOICE = 512
"""Samples among which the first attempt picks the nearest; later waves pick among fewer, for variety."""

CHUNK = 32
"""Poses compared at once: small products stay on one core, where BLAS threads would only get in each other's way."""


class SeedPool:
    """Uniform samples with their poses, a block for every attempt.

    The start of a pose depends on the pose, the attempt and the generator's seed only.
    """

    def __init__(self, problem: PoseProblem, rng: int) -> None:
        self.rng = rng
        self._problem = problem
        self._blocks: dict[int, tuple[JointVector, Floats, Floats]] = {}

    def nearest(self, T_sd: PoseMatrix, wave: int, attempt: int) -> JointVector:
        """(k, n) for each pose the sample of the attempt's block whose pose is nearest."""
        samples, features, half_norms = self._block(max(FIRST_CHOICE >> (2 * wave), 1), attempt)
        if len(samples) == 1:
            return np.repeat(samples, len(T_sd), axis=0)
        wanted = self._features(T_sd)
        chosen = np.empty(len(T_sd), dtype=np.intp)
        for begin in range(0, len(T_sd), CHUNK):
            part = slice(begin, begin + CHUNK)
            chosen[part] = (wanted[part] @ features.T - half_norms).argmax(axis=1)
        return samples[chosen]

    def _block(self, size: int, attempt: int) -> tuple[JointVector, Floats, Floats]:
        if attempt not in self._blocks:
            samples = self._problem.sample(np.random.default_rng((self.rng, attempt)), size)
            features = self._features(self._problem.poses(samples))
            self._blocks[attempt] = samples, features, (features * features).sum(axis=1) / 2
        return self._blocks[attempt]

    def _features(self, T: PoseMatrix) -> Floats:
        """(k, 12) numbers whose Euclidean distance measures how far poses lie apart: |R - R'| ~ sqrt(2) angle."""
        return np.concatenate([T[:, :3, :3].reshape(-1, 9) / np.sqrt(2.0), T[:, :3, 3] / self._problem.length], axis=1)
