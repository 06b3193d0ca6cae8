"""Starts for searches: sampled configurations, sorted into cells by their poses, so that near ones are found fast."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.ik.numerical.problem import PoseProblem
from mafsil.ik.numerical.start_loops import GROUP, MOST_CELLS, MOST_SAMPLES
from mafsil.ik.numerical.task import PoseTask

SAMPLES, CELLS = MOST_SAMPLES, MOST_CELLS
"""More samples save steps and cost comparisons; on six- and seven-joint arms the sum is flat around these."""


FAR = 1e15
"""Feature of places in a group that no sample fills; its square is a number of single precision."""


@dataclass(frozen=True, eq=False)
class Pool:
    """Uniform samples within the bounds.

    Attributes:
        samples: (m, n) sorted by cell.
        features: float32 whose distances measure how far poses lie apart, in groups (12, GROUP): of the cells' centres,
            then cell by cell, filled up with far ones.
        begins: (c + 1) first sample of every cell.
        groups: (c + 1) first group of features of every cell.
        turning, shifting: factors of the features of rotations and positions.
    """

    samples: JointVector
    features: NDArray[np.float32]
    begins: NDArray[np.int64]
    groups: NDArray[np.int64]
    turning: float
    shifting: float

    @property
    def cells(self) -> int:
        """How many."""
        return len(self.begins) - 1


def pool_of(problem: PoseProblem, task: PoseTask, seed: int) -> Pool:
    """The samples of a generator's seed, in cells around some of them.

    Args:
        problem: the frame and its bounds.
        task: what counts of a pose.
        seed: of the random samples.
    """
    q = problem.sample(np.random.default_rng(seed), SAMPLES)
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
    table = features[order]
    grouped = [_grouped(centres), *(_grouped(table[begin:end]) for begin, end in itertools.pairwise(begins))]
    groups = np.cumsum([len(each) for each in grouped])
    return Pool(np.ascontiguousarray(q[order]), np.concatenate(grouped), begins, groups, turning, shifting)


def _grouped(features: Floats) -> NDArray[np.float32]:
    """(k, 12, GROUP) features of samples, filled up with ones that are far from everything."""
    rows = np.full((-(-len(features) // GROUP) * GROUP, 12), FAR, np.float32)
    rows[: len(features)] = features
    return np.ascontiguousarray(rows.reshape(-1, GROUP, 12).transpose(0, 2, 1))


def _nearest(features: Floats, centres: Floats) -> NDArray[np.intp]:
    """(m,) the nearest centre of each; in parts, so that the products stay on one core."""
    half = (centres * centres).sum(axis=1) / 2
    parts = [(features[i : i + 128] @ centres.T - half).argmax(axis=1) for i in range(0, len(features), 128)]
    return np.concatenate(parts)
