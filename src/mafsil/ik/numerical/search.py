"""Searches as values: a plan made once for a frame and a task, and the runs over blocks of poses."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.ik.numerical import search_loops as loops
from mafsil.ik.numerical import start_loops as places
from mafsil.ik.numerical.pool import Pool, pool_of
from mafsil.ik.numerical.problem import PoseProblem
from mafsil.ik.numerical.program import PROGRAM
from mafsil.ik.numerical.task import PoseTask
from mafsil.ik.problem import ORTHOGONALITY
from mafsil.kernels import Kernel
from mafsil.kernels.lazy import lazy

LANES = 64
"""Poses that step together: their numbers fit the first-level cache."""

SLICE = 2048
"""Rounds between two looks at the clock and at the keyboard, without a time limit: some ten milliseconds."""

SHORT_SLICE = 32
"""The same with a time limit: some hundred microseconds."""

NEWTON = 1e-7
"""Scaled error from which one more step is trusted to end within rounding, for arms up to a metre; the check of every
answer judges."""


@dataclass(frozen=True, eq=False)
class Plan:
    """All that a search needs besides poses.

    Attributes:
        problem: the frame and its bounds.
        task: what counts.
        record: for the compiled loops, see `start_loops`.
        pool: starts.
        step, check: kernels.
    """

    problem: PoseProblem
    task: PoseTask
    record: Floats
    pool: Pool
    step: Kernel
    check: Kernel

    @lazy
    def vector(self) -> Floats:
        """(9 + 2 n) weights, axis, bounds: the kernels' third port."""
        return self.record[places.TASK : places.TASK + 9 + 2 * self.problem.robot.n]

    @lazy
    def head(self) -> tuple[int, int, int]:
        """Addresses of the record and of the samples' features, and of the step kernel."""
        return self.record.ctypes.data, self.pool.features.ctypes.data, self.step.addresses.batch

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
        k, n = len(T_sd), self.problem.robot.n
        lanes = 1 if k <= 1 else min(LANES, -(-k // loops.GROUP) * loops.GROUP)
        best = np.full((k, n + 1), np.inf)
        records = np.zeros((k, loops.RECORD), np.int64)
        records[:, loops.ALLOWED], records[:, loops.WINNER] = allowed, -1
        work, seats = np.zeros(lanes * (16 + 2 * (n + 6))), np.empty(lanes * places.LANE, np.int64)
        T_sd, first, cursor = np.ascontiguousarray(T_sd), np.ascontiguousarray(first), np.zeros(3, np.int64)
        mode = loops.TRUSTED * trust + loops.PATIENT * patient
        rounds = SLICE if deadline == np.inf else SHORT_SLICE
        given = T_sd.ctypes.data, first.ctypes.data, int(len(first) > 0), k, lanes
        made = (each.ctypes.data for each in (work, seats, best, records, cursor))
        call = (*self.head, rounds, mode, *given, *made)
        advance = PROGRAM["advance"]
        while advance(*call):
            if perf_counter() >= deadline:
                break
        return best, records

    def checked(self, best: Floats, T_sd: Floats) -> tuple[Floats, Floats, Floats, NDArray[np.int64]]:
        """Computed afresh: (k, 22) poses and twists left, (k,) rotation and position errors, (k,) 1 where all met."""
        k, best = len(best), np.ascontiguousarray(best)
        out = np.ascontiguousarray(self.check.ufunc(best[:, :-1], T_sd.reshape(k, 4, 4), self.vector))
        errors, good = np.empty((k, 2)), np.empty(k, np.int64)
        PROGRAM["verdict"](self.head[0], k, *(each.ctypes.data for each in (out, best, errors, good)))
        return out, errors[:, 0], errors[:, 1], good

    def wind(self, best: Floats, near: JointVector) -> None:
        """Whole turns of turning joints towards `near`, as far as bounds allow.

        Args:
            best: (k, n + 1) contiguous, changed.
            near: (k, n), or (1, n) for all.
        """
        near = np.ascontiguousarray(near)
        PROGRAM["wind"](self.head[0], len(best), best.ctypes.data, near.ctypes.data, int(len(near) == 1))

    def clean(self, wanted: Floats) -> tuple[Floats, Floats]:
        """Poses with repaired rotations (k, 16), distances from the base (k,), -1 where a row is no pose.

        Args:
            wanted: (k, 16) as the user gave them.
        """
        wanted, k = np.ascontiguousarray(wanted), len(wanted)
        out, distance = np.empty((k, 16)), np.empty(k)
        PROGRAM["clean"](self.head[0], wanted.ctypes.data, k, out.ctypes.data, distance.ctypes.data)
        return out, distance


def plan_of(problem: PoseProblem, task: PoseTask, seed: int) -> Plan:
    """The plan of a search.

    Args:
        problem: the frame and its bounds.
        task: what counts.
        seed: of the sampled starts.
    """
    pool = pool_of(problem, task, seed)
    centre, radius = problem.reach
    head = np.zeros(places.TASK)
    head[places.JOINTS], head[places.SAMPLES], head[places.CELLS] = problem.robot.n, len(pool.samples), pool.cells
    head[places.TURN_LIMIT], head[places.SHIFT_LIMIT] = task.rotation_tolerance**2 / 4, task.position_tolerance**2 / 4
    head[places.TURN_FACTOR], head[places.SHIFT_FACTOR] = pool.turning, pool.shifting
    # A last step squares the scaled error; of long arms less is left to it.
    head[places.ONE_AXIS], head[places.TRUST] = task.one_axis, NEWTON / max(1.0, problem.length) ** 0.5
    head[places.RADIUS], head[places.DEFECT] = radius if task.all_positions else np.inf, ORTHOGONALITY
    head[places.CENTRE : places.CENTRE + 3] = centre
    rows = task.scaled(problem.length), task.axis, problem.lower, problem.upper, problem.turning
    record = np.concatenate([head, *rows, pool.begins, pool.groups, pool.samples.ravel()], dtype=np.float64)
    return Plan(problem, task, record, pool, problem.step(task.one_axis), problem.check(task.one_axis))


@lru_cache(maxsize=32)
def cached_plan(problem: PoseProblem, task: PoseTask, seed: int) -> Plan:
    """As `plan_of`, made once.

    Args:
        problem, task: for which the plan is made.
        seed: of the sampled starts.
    """
    return plan_of(problem, task, seed)
