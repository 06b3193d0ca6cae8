"""The fast search: everything but the poses prepared once, one compiled call, fields made when they are read."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil import threads
from mafsil.arrays import Floats, JointVector, PoseMatrix, real_array
from mafsil.ik.numerical.problem import problem_of
from mafsil.ik.numerical.program import PROGRAM
from mafsil.ik.numerical.records import (
    CONFIGURATION,
    DISTANCE,
    POSITION_ERROR,
    REACHED,
    ROTATION_ERROR,
    TWIST,
    Batch,
    PoseRecord,
)
from mafsil.ik.numerical.search import SearchPlan, cached_plan, lanes_for, new_search
from mafsil.ik.numerical.task import PoseTask, pose_task
from mafsil.ik.result import IKResult
from mafsil.ik.status import CODES, IKStatus
from mafsil.kernels.loop_compiler import Rows
from mafsil.robot import Robot

MOST_ATTEMPTS = 32
"""Attempts of the fast search; poses that resist them are begun again by the full search, which says why it fails."""

BLOCK = 4096
"""Poses that a thread takes at once; what it needs besides input and answer is proportional to them."""

KEPT = 512
"""Most poses for which the memory of a search is kept for the next call."""

POSE_RECORD = PoseRecord.dtype()
"""Of a NumPy array of records of poses."""

SOLVED = CODES[IKStatus.SOLVED]
_SOLVED = np.array(SOLVED, np.int8)
_SOLVED.setflags(write=False)


class FastSearch:
    """The search for the poses of one call after another.

    Args:
        plan: of the search.
    """

    def __init__(self, plan: SearchPlan) -> None:
        self.plan, self.part, self.n = plan, plan.problem.part, plan.problem.robot.n
        self._entry = PROGRAM["solve_batch"]
        self._single: list[_SinglePose] = []
        self._batches: list[_Workspace] = []

    def single(self, T_sd: PoseMatrix, q0: JointVector | None, restarts: int) -> IKResult | None:
        """The answer for one pose; None where the fast search finds none.

        Args:
            T_sd: (4, 4).
            q0: (n,) initial guess of the joints that move the frame, or None.
            restarts: how many more starts are tried after the first.
        """
        # Taking from and adding to a list is one step of the interpreter: no two threads get the same memory.
        work = self._single.pop() if self._single else _SinglePose(self.plan)
        work.T[...] = T_sd
        if q0 is not None:
            work.q0[...] = q0
        guessed = q0 is not None
        if guessed is not work.guessed or restarts != work.restarts:
            work.set(guessed, restarts)
        report = None
        if self._entry(work.address):
            report = Report(work.report.copy(), work.counts.copy(), self.plan)
        self._single.append(work)
        return None if report is None else IKResult(report.field)

    def rows(self, desired: Floats, q0: JointVector, restarts: int) -> tuple[Floats, NDArray[np.void]]:
        """(k, CONFIGURATION + n) report of many poses and their (k,) records; those without a winner are open.

        Args:
            desired: (k, 16) contiguous.
            q0: (k, n) contiguous initial guesses, or (0, n).
            restarts: how many more starts are tried after the first.
        """
        k = len(desired)
        report, record = np.empty((k, CONFIGURATION + self.n)), np.empty(k, POSE_RECORD)
        attempts = min(restarts + 1, MOST_ATTEMPTS)

        def block(index: int) -> None:
            rows = slice(index * BLOCK, min((index + 1) * BLOCK, k))
            self._block(desired[rows], q0[rows], attempts, report[rows], record[rows])

        blocks = -(-k // BLOCK)
        threads.run(block, blocks, threads.available() if blocks > 1 else 1)
        return report, record

    def _block(self, desired: Floats, q0: JointVector, attempts: int, report: Floats, record: NDArray[np.void]) -> None:
        k = len(desired)
        work = self._workspace(k)
        search, batch = work.search, work.batch
        search.poses, search.lanes = k, lanes_for(k)
        search.record, search.q0, search.guessed = Rows(PoseRecord, record), q0, int(len(q0) > 0)
        batch.given, batch.allowed, batch.report = desired, attempts, report
        self._entry(batch.address)
        if work.size <= KEPT:
            search.release("record", "q0")
            batch.release("given", "report")
            self._batches.append(work)

    def _workspace(self, poses: int) -> _Workspace:
        """Memory for so many poses, used before or new."""
        if poses > KEPT:
            return _Workspace(self.plan, poses)
        return self._batches.pop() if self._batches else _Workspace(self.plan, KEPT)


class _Workspace:
    """The memory of the search for up to some poses: everything but the poses themselves, the report and the records.

    Args:
        plan: of the search.
        size: most poses.
    """

    def __init__(self, plan: SearchPlan, size: int) -> None:
        self.size = size
        self.search = new_search(plan, np.empty((size, 16)), np.empty(size, POSE_RECORD))
        self.search.step = plan.step.addresses.batch
        self.batch = Batch(search=self.search, check=plan.check.addresses.batch, zeros=np.zeros(plan.problem.robot.n))


class _SinglePose(_Workspace):
    """The memory of the search for one pose, all of it."""

    def __init__(self, plan: SearchPlan) -> None:
        super().__init__(plan, 1)
        n = plan.problem.robot.n
        self.T, self.q0, self.report = np.zeros((4, 4)), np.zeros(n), np.zeros(CONFIGURATION + n)
        self.counts, self.address = self.search.record[0].memory, self.batch.address
        self.search.step, self.batch.check = plan.step.addresses.few, plan.check.addresses.few
        self.search.q0, self.batch.given, self.batch.report = self.q0, self.T, self.report
        self.set(False, 0)

    def set(self, guessed: bool, restarts: int) -> None:
        """Whether there is an initial guess, and how many more starts are tried; mostly the same in the next call."""
        self.guessed, self.restarts = guessed, restarts
        self.search.guessed, self.batch.allowed = int(guessed), min(restarts + 1, MOST_ATTEMPTS)


class Report:
    """What was found of poses, from which the fields of an answer are made.

    Args:
        numbers: (*batch, CONFIGURATION + n) columns as `records` names them.
        counts: (*batch, 4) int64, the memory of the poses' records.
        plan: of the search.
        codes: (*batch,) index into `STATUSES`; all solved if None.
        worst: row -> joint that a solution without limits exceeds most.
    """

    __slots__ = ("codes", "counts", "numbers", "plan", "worst")

    def __init__(
        self,
        numbers: Floats,
        counts: NDArray[np.int64],
        plan: SearchPlan,
        codes: NDArray[np.int8] | None = None,
        worst: dict[int, str] | None = None,
    ) -> None:
        self.numbers, self.counts, self.plan, self.codes, self.worst = numbers, counts, plan, codes, worst

    def shaped(self, batch: tuple[int, ...]) -> Report:
        """The same in the shape of a batch.

        Args:
            batch: leading dimensions.
        """
        codes = None if self.codes is None else self.codes.reshape(batch)
        numbers = self.numbers.reshape(*batch, self.numbers.shape[-1])
        counts = self.counts.reshape(*batch, self.counts.shape[-1])
        return Report(numbers, counts, self.plan, codes, self.worst)

    def field(self, name: str) -> Any:
        """A field of the answer."""
        numbers = self.numbers
        batch = numbers.shape[:-1]
        if name == "nearest":
            return np.ascontiguousarray(numbers[..., CONFIGURATION:])
        if name == "codes":
            return self.codes if self.codes is not None else np.full(batch, SOLVED, np.int8) if batch else _SOLVED
        if name == "T_reached":
            return np.ascontiguousarray(numbers[..., REACHED:TWIST]).reshape(*batch, 4, 4)
        if name in _COLUMNS:
            return np.array(numbers[..., _COLUMNS[name]])
        if name == "iterations":
            return np.array(self._record["steps"])
        if name == "attempts":
            # What solved it was the last attempt.
            winner = self._record["winner"]
            return np.where(winner >= 0, winner + 1, self._record["begun"])
        if name == "reach":
            return np.full(batch, self.plan.problem.reach[1])
        return self.plan.problem.robot.n if name == "moving" else self._worst(batch)

    @property
    def _record(self) -> NDArray[np.void]:
        """(*batch,) `PoseRecord` of every pose."""
        return self.counts.view(POSE_RECORD)[..., 0]

    def _worst(self, batch: tuple[int, ...]) -> NDArray[np.str_]:
        found = self.worst or {}
        names = np.zeros(batch, dtype=f"U{max((len(each) for each in found.values()), default=1)}")
        for row, joint in found.items():
            names.reshape(-1)[row] = joint
        return names


_COLUMNS = {"rotation_error": ROTATION_ERROR, "position_error": POSITION_ERROR, "distance": DISTANCE}


@lru_cache(maxsize=64)
def search_of(
    robot: Robot,
    frame: str | None,
    limits: bool,
    seed: int,
    kind: str,
    axis: tuple[float, ...],
    weights: tuple[float, ...] | None,
    tolerance: float,
    rotation_tolerance: float | None,
) -> FastSearch:
    """The search for the poses of a robot and a task; made once.

    Args:
        robot, frame, limits, seed: as for `solve_ik`.
        kind, axis, weights, tolerance, rotation_tolerance: of the task.
    """
    task = task_of(kind, axis, weights, tolerance, rotation_tolerance)
    return FastSearch(cached_plan(problem_of(robot, frame, limits), task, seed))


@lru_cache(maxsize=64)
def task_of(
    kind: str,
    axis: tuple[float, ...],
    weights: tuple[float, ...] | None,
    tolerance: float,
    rotation_tolerance: float | None,
) -> PoseTask:
    """As `pose_task`, made once.

    Args:
        kind, axis, weights, tolerance, rotation_tolerance: as there.
    """
    return pose_task(kind, axis, weights, tolerance, rotation_tolerance)


def hashable(name: str, values: Any) -> tuple[float, ...]:
    """Numbers of a user as a tuple."""
    return tuple(real_array(name, values).ravel().tolist())
