"""Searches as values: a plan made once for a frame and a task, and the runs over blocks of poses.

Starts for searches: sampled configurations, sorted into cells by their poses, so that near ones are found fast.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import lru_cache
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.ik.numerical.batch_loops import check, clean, resume, wind
from mafsil.ik.numerical.problem import PoseProblem, PoseTask
from mafsil.ik.numerical.records import (
    ALLOWED,
    FEATURE_GROUP,
    FEATURES,
    GROUP,
    LEFT,
    MOST_CELLS,
    MOST_SAMPLES,
    WINNER,
    Plan,
    Search,
    Whole,
)
from mafsil.ik.numerical.search_loops import PATIENT, TRUSTED
from mafsil.ik.result import ORTHOGONALITY
from mafsil.ik.tolerances import ONE_MORE
from mafsil.kernels import Kernel
from mafsil.kernels.lazy import lazy
from mafsil.kernels.loops import Held, hold

SAMPLES, CELLS = MOST_SAMPLES, MOST_CELLS
"""More samples save steps and cost comparisons; on six- and seven-joint arms the sum is flat around these."""
FAR = 1e15
"""Feature of places in a group that no sample fills; its square is a number of single precision."""
LANES = 64
"""Poses that step together: their numbers fit the first-level cache."""
SLICE = 2048
"""Rounds between two looks at the clock and at the keyboard, without a time limit: some ten milliseconds."""
SHORT_SLICE = 32
"""The same with a time limit: some hundred microseconds."""


@dataclass(frozen=True, eq=False)
class SearchPlan:
    """All that a search needs besides poses.

    Attributes:
        problem: the frame and its bounds.
        task: what counts.
        record: the plan as the compiled loops take it.
        pool: starts.
        step, check: kernels.
    """

    problem: PoseProblem
    task: PoseTask
    record: Plan
    pool: Pool
    step: Kernel
    check: Kernel

    @lazy
    def vector(self) -> Floats:
        """(9 + 2 n) weights, axis, bounds: the kernels' third port."""
        return self.record.task

    @lazy
    def held(self) -> Held[Plan]:
        """The plan in memory."""
        return hold(self.record)

    def run(
        self,
        T_sd: Floats,
        q0: JointVector,
        allowed: NDArray[np.int64],
        *,
        trust: bool = True,
        patient: bool = False,
        deadline: float = np.inf,
    ) -> tuple[Floats, Whole]:
        """Search for all poses.

        Args:
            T_sd: (k, 16) clean poses.
            q0: (k, n) initial guesses, or (0, n).
            allowed: (k,) attempts.
            trust: whether a last step from a small error is taken without a look.
            patient: whether attempts are given up only at their end.
            deadline: of `perf_counter`.

        Returns:
            (k, n + 1) configurations and errors, and (k, 4) attempts.
        """
        attempts = np.zeros((len(T_sd), 4), np.int64)
        attempts[:, ALLOWED], attempts[:, WINNER] = allowed, -1
        search = new_search(self, self.step.addresses.batch, np.ascontiguousarray(T_sd), q0, attempts)
        search.q[:] = np.inf
        held, mode = hold(search), TRUSTED * trust + PATIENT * patient
        rounds = SLICE if deadline == np.inf else SHORT_SLICE
        while resume(self.held, held, rounds, mode):
            if perf_counter() >= deadline:
                break
        return search.q, attempts

    def check_best(self, best: Floats, T_sd: Floats) -> tuple[Floats, Floats, Floats, NDArray[np.int64]]:
        """Computed afresh: (k, 22) poses and twists left, (k,) rotation and position errors, (k,) 1 where all met."""
        k, best = len(best), np.ascontiguousarray(best)
        out = np.ascontiguousarray(self.check.ufunc(best[:, :-1], T_sd.reshape(k, 4, 4), self.vector))
        errors, good = np.empty((k, 2)), np.empty(k, np.int64)
        check(self.held, out, best, errors, good)
        return out, errors[:, 0], errors[:, 1], good

    def wind(self, q: Floats, q0: JointVector) -> None:
        """Whole turns of revolute joints towards an initial guess, as far as bounds allow.

        Args:
            q: (k, n + 1) contiguous, changed.
            q0: (k, n), or (1, n) for all.
        """
        wind(self.held, q, np.ascontiguousarray(q0))

    def clean(self, desired: Floats) -> tuple[Floats, Floats]:
        """Poses with repaired rotations (k, 16), distances from the base (k,), -1 where a row is no pose.

        Args:
            desired: (k, 16) as the user gave them.
        """
        desired, k = np.ascontiguousarray(desired), len(desired)
        out, distance = np.empty((k, 16)), np.empty(k)
        clean(self.held, desired, out, distance)
        return out, distance


def plan_of(problem: PoseProblem, task: PoseTask, seed: int) -> SearchPlan:
    """The plan of a search.

    Args:
        problem: the frame and its bounds.
        task: what counts.
        seed: of the sampled starts.
    """
    pool = pool_of(problem, task, seed)
    centre, radius = problem.reach
    n = problem.robot.n
    vector = np.concatenate(
        [task.scaled_weights(problem.length), task.axis, problem.lower, problem.upper], dtype=np.float64
    )
    record = Plan(
        rotation_limit=task.rotation_tolerance**2 / 4,
        position_limit=task.position_tolerance**2 / 4,
        rotation_factor=pool.rotation_factor,
        position_factor=pool.position_factor,
        one_axis=task.one_axis,
        # A last step squares the scaled error; of long arms less is left to it.
        trust=ONE_MORE / max(1.0, problem.length) ** 0.5,
        radius=radius if task.all_positions else np.inf,
        defect=ORTHOGONALITY,
        centre=centre,
        task=vector,
        weights=vector[:6],
        axis=vector[6:9],
        lower=vector[9 : 9 + n],
        upper=vector[9 + n :],
        revolute=problem.revolute,
        first_sample=pool.first_sample,
        first_group=pool.first_group,
        configurations=pool.samples,
        features=pool.features,
    )
    step, check_kernel = (make(task.one_axis, task.aligned) for make in (problem.step, problem.check))
    return SearchPlan(problem, task, record, pool, step, check_kernel)


def new_search(plan: SearchPlan, step: int, desired: Floats, q0: JointVector, attempts: Whole) -> Search:
    """Memory of a search for some poses.

    Args:
        plan: of the search.
        step: address of its kernel.
        desired: (k, 16) clean poses.
        q0: (k, n) initial guesses, or (0, n).
        attempts: (k, 4) of every pose.
    """
    k, n = len(desired), plan.problem.robot.n
    lanes = lanes_for(k)
    return Search(
        step=step,
        desired=desired,
        q0=np.ascontiguousarray(q0),
        q=np.empty((k, n + 1)),
        attempts=attempts,
        lanes=np.zeros((lanes, 5), np.int64),
        lane_desired=np.zeros((lanes, 16)),
        states=np.zeros((2, lanes, n + LEFT)),
        progress=np.zeros(3, np.int64),
    )


def lanes_for(poses: int) -> int:
    """Lanes that work on so many poses."""
    return 1 if poses <= 1 else min(LANES, -(-poses // GROUP) * GROUP)


@lru_cache(maxsize=32)
def cached_plan(problem: PoseProblem, task: PoseTask, seed: int) -> SearchPlan:
    """As `plan_of`, made once.

    Args:
        problem, task: for which the plan is made.
        seed: of the sampled starts.
    """
    return plan_of(problem, task, seed)


@dataclass(frozen=True, eq=False)
class Pool:
    """Uniform samples within the bounds.

    Attributes:
        samples: (m, n) sorted by cell.
        features: float32 whose distances measure how far poses lie apart, in groups (FEATURES, FEATURE_GROUP): of the
            cells' centres, then cell by cell, filled up with far ones.
        first_sample, first_group: (c + 1) of every cell.
        rotation_factor, position_factor: of the features of rotations and positions.
    """

    samples: JointVector
    features: NDArray[np.float32]
    first_sample: NDArray[np.int64]
    first_group: NDArray[np.int64]
    rotation_factor: float
    position_factor: float

    @property
    def cells(self) -> int:
        """How many."""
        return len(self.first_sample) - 1


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
    rotation_factor = float(task.rotates) * (1.0 if task.one_axis else np.sqrt(0.5))
    position_factor = float(task.translates) / problem.length
    features = np.zeros((SAMPLES, FEATURES))
    if task.one_axis:
        features[:, :3] = rotation_factor * (T[:, :3, :3] @ task.axis)
    else:
        features[:, :9] = rotation_factor * T[:, :3, :3].reshape(-1, 9)
    features[:, 9:] = position_factor * T[:, :3, 3]
    centres = features[:CELLS]
    cell = _nearest(features, centres)
    order = np.argsort(cell, kind="stable")
    first_sample = np.searchsorted(cell[order], np.arange(CELLS + 1)).astype(np.int64)
    table = features[order]
    grouped = [_group(centres), *(_group(table[begin:end]) for begin, end in itertools.pairwise(first_sample))]
    first_group = np.cumsum([len(each) for each in grouped])
    factors = rotation_factor, position_factor
    return Pool(np.ascontiguousarray(q[order]), np.concatenate(grouped), first_sample, first_group, *factors)


def _group(features: Floats) -> NDArray[np.float32]:
    """(k, FEATURES, FEATURE_GROUP) features of samples, filled up with ones that are far from everything."""
    rows = np.full((-(-len(features) // FEATURE_GROUP) * FEATURE_GROUP, FEATURES), FAR, np.float32)
    rows[: len(features)] = features
    return np.ascontiguousarray(rows.reshape(-1, FEATURE_GROUP, FEATURES).transpose(0, 2, 1))


def _nearest(features: Floats, centres: Floats) -> NDArray[np.intp]:
    """(m,) the nearest centre of each; in parts, so that the products stay on one core."""
    half = (centres * centres).sum(axis=1) / 2
    parts = [(features[i : i + 128] @ centres.T - half).argmax(axis=1) for i in range(0, len(features), 128)]
    return np.concatenate(parts)
