"""Searches as values: a plan made once for a frame and a task, and the runs over blocks of poses."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.ik.numerical.pool import Pool, pool_of
from mafsil.ik.numerical.problem import PoseProblem
from mafsil.ik.numerical.task import PoseTask
from mafsil.kernels import Kernel
from mafsil.kernels.lazy import lazy

LANES = 64
"""Poses that step together: their numbers fit the first-level cache."""

SLICE = 2048
"""Rounds between two looks at the clock and at the keyboard, without a time limit: some ten milliseconds."""

SHORT_SLICE = 32
"""The same with a time limit: some hundred microseconds."""


@dataclass(frozen=True, eq=False)
class Plan:
    """All that a search needs besides poses.

    Attributes:
        problem: the frame and its bounds.
        task: what counts.
        vector: (9 + 2 n) weights, axis, bounds: the kernels' third port.
        numbers: for the compiled loops.
        pool: starts.
        step, check: kernels.
    """

    problem: PoseProblem
    task: PoseTask
    vector: Floats
    numbers: Floats
    pool: Pool
    step: Kernel
    check: Kernel

    @lazy
    def tables(self) -> tuple[JointVector, NDArray[np.float32], NDArray[np.float32], NDArray[np.int64]]:
        """The arrays of the pool."""
        return self.pool.samples, self.pool.features, self.pool.centres, self.pool.begins

    @lazy
    def entries(self) -> tuple[int, int]:
        """Addresses of the kernels, one row at a time."""
        return self.step.addresses.few, self.check.addresses.few

    @lazy
    def setting(self) -> tuple[float, Floats, Floats, Floats, NDArray[np.int64]]:
        """What a single search needs besides: radius and centre of the reach, numbers, vector, turning joints."""
        centre, radius = self.problem.reach
        bound = radius if self.task.all_positions else np.inf
        return bound, centre, self.numbers, self.vector, self.problem.turning

    def run(
        self,
        T_sd: Floats,
        first: JointVector,
        allowed: NDArray[np.int64],
        *,
        trust: bool = True,
        patient: bool = False,
        deadline: float = np.inf,
    ) -> tuple[Floats, NDArray[np.int64]]:
        """Search for all poses.

        Args:
            T_sd: (k, 16) clean poses.
            first: (k, n) starts, or (0, n).
            allowed: (k,) attempts.
            trust: whether a last step from a small error is taken without a look.
            patient: whether attempts are given up only at their end.
            deadline: of `perf_counter`.

        Returns:
            (k, n + 1) configurations and errors, and (k, RECORD) records.
        """
        from mafsil.ik.numerical import search_loops as loops

        k, n = len(T_sd), self.problem.robot.n
        lanes = min(LANES, max(k, 1))
        best = np.full((k, n + 1), np.inf)
        records = np.zeros((k, loops.RECORD), np.int64)
        records[:, loops.ALLOWED], records[:, loops.WINNER] = allowed, -1
        numbers = self.numbers
        if not trust or patient:
            numbers = numbers.copy()
            numbers[loops.TRUST], numbers[loops.PATIENT] = numbers[loops.TRUST] if trust else 0.0, patient
        work = np.empty((lanes, 2 * n + 6)), np.empty((lanes, 2), np.int64), best, records, np.zeros(2, np.int64)
        rounds = SLICE if deadline == np.inf else SHORT_SLICE
        entry = self.step.addresses.batch
        while loops.advance(entry, rounds, numbers, self.vector, T_sd, first, *self.tables, *work):
            if perf_counter() >= deadline:
                break
        return best, records

    def checked(self, best: Floats, T_sd: Floats) -> tuple[Floats, Floats, Floats, NDArray[np.int64]]:
        """Computed afresh: (k, 22) poses and twists left, (k,) rotation and position errors, (k,) 1 where all met."""
        from mafsil.ik.numerical import search_loops as loops

        k = len(best)
        out = self.check.ufunc(best[:, :-1], T_sd.reshape(k, 4, 4), self.vector)
        rotation, position, good = np.empty(k), np.empty(k), np.empty(k, np.int64)
        loops.judge(out, best, self.numbers, self.vector, rotation, position, good)
        return out, rotation, position, good


def plan_of(problem: PoseProblem, task: PoseTask, rng: int) -> Plan:
    """The plan of a search.

    Args:
        problem: the frame and its bounds.
        task: what counts.
        rng: seed of the starts.
    """
    from mafsil.ik.numerical import search_loops as loops

    pool = pool_of(problem, task, rng)
    vector = np.concatenate([task.scaled(problem.length), task.axis, problem.lower, problem.upper])
    limits = [tolerance * tolerance / 4 for tolerance in (task.rotation_tolerance, task.position_tolerance)]
    # A last step squares the scaled error; of long arms less is left to it.
    trusted = loops.NEWTON / max(1.0, problem.length) ** 0.5
    numbers = np.array([*limits, pool.turning, pool.shifting, task.one_axis, trusted, pool.largest, 0.0])
    return Plan(problem, task, vector, numbers, pool, problem.step(task.one_axis), problem.check(task.one_axis))


@lru_cache(maxsize=32)
def cached_plan(problem: PoseProblem, task: PoseTask, rng: int) -> Plan:
    """As `plan_of`, made once.

    Args:
        problem, task: for which the plan is made.
        rng: source of seeds.
    """
    return plan_of(problem, task, rng)
