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
from mafsil.ik.numerical.program import PROGRAM
from mafsil.ik.numerical.records import GROUP, LEFT, Lane, Plan, PoseRecord, Search
from mafsil.ik.numerical.search_loops import PATIENT, TRUSTED
from mafsil.ik.numerical.task import PoseTask
from mafsil.ik.problem import ORTHOGONALITY
from mafsil.ik.tolerances import ONE_MORE
from mafsil.kernels import Kernel
from mafsil.kernels.lazy import lazy
from mafsil.kernels.loop_compiler import Rows

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

    def run(
        self,
        T_sd: Floats,
        q0: JointVector,
        allowed: NDArray[np.int64],
        *,
        trust: bool = True,
        patient: bool = False,
        deadline: float = np.inf,
    ) -> tuple[Floats, NDArray[np.void]]:
        """Search for all poses.

        Args:
            T_sd: (k, 16) clean poses.
            q0: (k, n) initial guesses, or (0, n).
            allowed: (k,) attempts.
            trust: whether a last step from a small error is taken without a look.
            patient: whether attempts are given up only at their end.
            deadline: of `perf_counter`.

        Returns:
            (k, n + 1) configurations and errors, and (k,) `PoseRecord`s.
        """
        record = np.zeros(len(T_sd), PoseRecord.dtype())
        record["allowed"], record["winner"] = allowed, -1
        search = new_search(self, np.ascontiguousarray(T_sd), record)
        search.q[:] = np.inf
        search.q0, search.guessed = np.ascontiguousarray(q0), int(len(q0) > 0)
        search.step = self.step.addresses.batch
        search.mode = TRUSTED * trust + PATIENT * patient
        search.rounds = SLICE if deadline == np.inf else SHORT_SLICE
        advance = PROGRAM["advance"]
        while advance(search.address):
            if perf_counter() >= deadline:
                break
        return search.q, record

    def checked(self, best: Floats, T_sd: Floats) -> tuple[Floats, Floats, Floats, NDArray[np.int64]]:
        """Computed afresh: (k, 22) poses and twists left, (k,) rotation and position errors, (k,) 1 where all met."""
        k, best = len(best), np.ascontiguousarray(best)
        out = np.ascontiguousarray(self.check.ufunc(best[:, :-1], T_sd.reshape(k, 4, 4), self.vector))
        errors, good = np.empty((k, 2)), np.empty(k, np.int64)
        PROGRAM["check"](self.record.address, k, *(each.ctypes.data for each in (out, best, errors, good)))
        return out, errors[:, 0], errors[:, 1], good

    def wind(self, q: Floats, q0: JointVector) -> None:
        """Whole turns of revolute joints towards an initial guess, as far as bounds allow.

        Args:
            q: (k, n + 1) contiguous, changed.
            q0: (k, n), or (1, n) for all.
        """
        q0 = np.ascontiguousarray(q0)
        PROGRAM["wind"](self.record.address, len(q), q.ctypes.data, q0.ctypes.data, int(len(q0) == 1))

    def clean(self, desired: Floats) -> tuple[Floats, Floats]:
        """Poses with repaired rotations (k, 16), distances from the base (k,), -1 where a row is no pose.

        Args:
            desired: (k, 16) as the user gave them.
        """
        desired, k = np.ascontiguousarray(desired), len(desired)
        out, distance = np.empty((k, 16)), np.empty(k)
        PROGRAM["clean"](self.record.address, desired.ctypes.data, k, out.ctypes.data, distance.ctypes.data)
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
    vector = np.concatenate([task.scaled(problem.length), task.axis, problem.lower, problem.upper], dtype=np.float64)
    record = Plan(
        joints=n,
        samples=len(pool.samples),
        cells=pool.cells,
        rotation_limit=task.rotation_tolerance**2 / 4,
        position_limit=task.position_tolerance**2 / 4,
        rotation_factor=pool.rotation_factor,
        position_factor=pool.position_factor,
        one_axis=int(task.one_axis),
        # A last step squares the scaled error; of long arms less is left to it.
        trust=ONE_MORE / max(1.0, problem.length) ** 0.5,
        radius=radius if task.all_positions else np.inf,
        defect=ORTHOGONALITY,
        centre=centre,
        task=vector,
        weights=vector,
        axis=vector[6:],
        lower=vector[9:],
        upper=vector[9 + n :],
        revolute=problem.revolute,
        first_sample=pool.first_sample,
        first_group=pool.first_group,
        configurations=pool.samples.ravel(),
        features=pool.features.ravel(),
    )
    return SearchPlan(problem, task, record, pool, problem.step(task.one_axis), problem.check(task.one_axis))


def new_search(plan: SearchPlan, desired: Floats, record: NDArray[np.void]) -> Search:
    """Memory of a search for some poses; its kernel, mode and initial guesses are not given yet.

    Args:
        plan: of the search.
        desired: (k, 16) clean poses.
        record: (k,) of every pose.
    """
    k, n = len(desired), plan.problem.robot.n
    lanes = lanes_for(k)
    return Search(
        plan=plan.record,
        poses=k,
        lanes=lanes,
        desired=desired,
        q=np.empty((k, n + 1)),
        record=Rows(PoseRecord, record),
        lane=Rows(Lane, np.zeros(lanes, Lane.dtype())),
        lane_desired=np.zeros((lanes, 16)),
        lane_states=np.zeros((2, lanes, n + LEFT)),
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
