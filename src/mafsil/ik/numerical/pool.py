"""Starts for searches: sampled configurations, sorted into cells by their poses, so that near ones are found fast."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.ik.numerical.problem import PoseProblem
from mafsil.ik.numerical.task import PoseTask

SAMPLES, CELLS = 2048, 64
"""More samples save steps and cost comparisons; on six- and seven-joint arms the sum is flat around these."""


@dataclass(frozen=True, eq=False)
class Pool:
    """Uniform samples within the bounds.

    Attributes:
        samples: (m, n) sorted by cell.
        features: (12 m) float32, cell by cell (12, size): numbers whose distances measure how far poses lie apart.
        centres: (12 c) float32, (12, c).
        begins: (c + 1) first sample of every cell.
        largest: size of the largest cell, or number of cells.
        turning, shifting: factors of the features of rotations and positions.
    """

    samples: JointVector
    features: NDArray[np.float32]
    centres: NDArray[np.float32]
    begins: NDArray[np.int64]
    largest: int
    turning: float
    shifting: float


def pool_of(problem: PoseProblem, task: PoseTask, rng: int) -> Pool:
    """The samples of a generator's seed, in cells around some of them.

    Args:
        problem: the frame and its bounds.
        task: what counts of a pose.
        rng: seed.
    """
    q = problem.sample(np.random.default_rng(rng), SAMPLES)
    T = problem.poses(q)
    # |R - R'| ~ sqrt(2) angle, |a - a'| ~ angle.
    turning = float(task.turns) * (1.0 if task.one_axis else np.sqrt(0.5))
    shifting = float(task.shifts) / problem.length
    features = np.zeros((SAMPLES, 12))
    if task.one_axis:
        features[:, :3] = turning * (T[:, :3, :3] @ task.axis)
    else:
        features[:, :9] = turning * T[:, :3, :3].reshape(-1, 9)
    features[:, 9:] = shifting * T[:, :3, 3]
    centres = features[:CELLS]
    cell = _nearest(features, centres)
    order = np.argsort(cell, kind="stable")
    begins = np.searchsorted(cell[order], np.arange(CELLS + 1)).astype(np.int64)
    table = features[order].astype(np.float32)
    flat = [table[begin:end].T.ravel() for begin, end in itertools.pairwise(begins)]
    return Pool(
        np.ascontiguousarray(q[order]),
        np.concatenate(flat),
        np.ascontiguousarray(centres.T.ravel(), np.float32),
        begins,
        max(int(np.diff(begins).max()), CELLS),
        turning,
        shifting,
    )


def _nearest(features: Floats, centres: Floats) -> NDArray[np.intp]:
    """(m,) the nearest centre of each; in parts, so that the products stay on one core."""
    half = (centres * centres).sum(axis=1) / 2
    parts = [(features[i : i + 128] @ centres.T - half).argmax(axis=1) for i in range(0, len(features), 128)]
    return np.concatenate(parts)
