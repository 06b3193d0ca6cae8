"""The fast search: everything but the poses prepared once, one compiled call, fields made when they are read."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil import threads
from mafsil.arrays import Floats, JointVector, PoseMatrix, real_array
from mafsil.ik.numerical.batch_loops import solve_batch
from mafsil.ik.numerical.problem import PoseTask, pose_task, problem_of
from mafsil.ik.numerical.records import (
    BEGUN,
    CONFIGURATION,
    DISTANCE,
    POSITION_ERROR,
    REACHED,
    ROTATION_ERROR,
    STEPS,
    TWIST,
    WINNER,
    Batch,
    Whole,
)
from mafsil.ik.numerical.search import SearchPlan, cached_plan, new_search
from mafsil.ik.result import CODES, IKResult, IKStatus
from mafsil.kernels.loops import Held, hold
from mafsil.robot import Robot

MOST_ATTEMPTS = 32
"""Attempts of the fast search; poses that resist them are begun again by the full search, which says why it fails."""

BLOCK = 4096
"""Poses that a thread takes at once; what it needs besides input and answer is proportional to them."""

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
        self._single: list[_SinglePose] = []

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
        batch = work.unguessed
        if q0 is not None:
            work.q0[...] = q0
            batch = work.guessed
        report = None
        if solve_batch(batch, min(restarts + 1, MOST_ATTEMPTS)):
            report = Report(work.report[0].copy(), work.attempts[0].copy(), self.plan)
        self._single.append(work)
        return None if report is None else IKResult(report.field)

    def rows(self, desired: Floats, q0: JointVector, restarts: int) -> tuple[Floats, Whole]:
        """(k, CONFIGURATION + n) report of many poses and their (k, 4) attempts; those without a winner are open.

        Args:
            desired: (k, 16) contiguous.
            q0: (k, n) contiguous initial guesses, or (0, n).
            restarts: how many more starts are tried after the first.
        """
        k = len(desired)
        report, attempts = np.empty((k, CONFIGURATION + self.n)), np.empty((k, 4), np.int64)
        step, check = self.plan.step.addresses.batch, self.plan.check.addresses.batch

        def block(index: int) -> None:
            rows = slice(index * BLOCK, min((index + 1) * BLOCK, k))
            search = new_search(self.plan, step, np.empty((len(report[rows]), 16)), q0[rows], attempts[rows])
            batch = Batch(self.plan.record, search, check, desired[rows], np.zeros(self.n), report[rows])
            solve_batch(hold(batch), min(restarts + 1, MOST_ATTEMPTS))

        blocks = -(-k // BLOCK)
        threads.run(block, blocks, threads.available() if blocks > 1 else 1)
        return report, attempts


class _SinglePose:
    """The memory of the search for one pose, with and without an initial guess."""

    def __init__(self, plan: SearchPlan) -> None:
        n = plan.problem.robot.n
        self.T, self.q0, self.report = np.zeros((4, 4)), np.zeros(n), np.zeros((1, CONFIGURATION + n))
        self.attempts = np.zeros((1, 4), np.int64)
        self.guessed, self.unguessed = self._held(plan, self.q0[None]), self._held(plan, np.empty((0, n)))

    def _held(self, plan: SearchPlan, q0: JointVector) -> Held[Batch]:
        search = new_search(plan, plan.step.addresses.few, np.empty((1, 16)), q0, self.attempts)
        check, given = plan.check.addresses.few, self.T.reshape(1, 16)
        return hold(Batch(plan.record, search, check, given, np.zeros(q0.shape[1]), self.report))


class Report:
    """What was found of poses, from which the fields of an answer are made.

    Args:
        numbers: (*batch, CONFIGURATION + n) columns as `records` names them.
        attempts: (*batch, 4) of the poses.
        plan: of the search.
        codes: (*batch,) index into `STATUSES`; all solved if None.
        worst: row -> joint that a solution without limits exceeds most.
    """

    __slots__ = ("attempts", "codes", "numbers", "plan", "worst")

    def __init__(
        self,
        numbers: Floats,
        attempts: Whole,
        plan: SearchPlan,
        codes: NDArray[np.int8] | None = None,
        worst: dict[int, str] | None = None,
    ) -> None:
        self.numbers, self.attempts, self.plan, self.codes, self.worst = numbers, attempts, plan, codes, worst

    def reshape(self, batch: tuple[int, ...]) -> Report:
        """The same in the shape of a batch.

        Args:
            batch: leading dimensions.
        """
        codes = None if self.codes is None else self.codes.reshape(batch)
        numbers = self.numbers.reshape(*batch, self.numbers.shape[-1])
        attempts = self.attempts.reshape(*batch, self.attempts.shape[-1])
        return Report(numbers, attempts, self.plan, codes, self.worst)

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
            return np.array(self.attempts[..., STEPS])
        if name == "attempts":
            # What solved it was the last attempt.
            winner = self.attempts[..., WINNER]
            return np.where(winner >= 0, winner + 1, self.attempts[..., BEGUN])
        if name == "reach":
            return np.full(batch, self.plan.problem.reach[1])
        return self.plan.problem.robot.n if name == "moving" else self._worst(batch)

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
    expressed_in: str = "body",
) -> FastSearch:
    """The search for the poses of a robot and a task; made once.

    Args:
        robot, frame, limits, seed: as for `solve_ik`.
        kind, axis, weights, tolerance, rotation_tolerance, expressed_in: of the task.
    """
    task = task_of(kind, axis, weights, tolerance, rotation_tolerance, expressed_in)
    return FastSearch(cached_plan(problem_of(robot, frame, limits), task, seed))


@lru_cache(maxsize=64)
def task_of(
    kind: str,
    axis: tuple[float, ...],
    weights: tuple[float, ...] | None,
    tolerance: float,
    rotation_tolerance: float | None,
    expressed_in: str = "body",
) -> PoseTask:
    """As `pose_task`, made once.

    Args:
        kind, axis, weights, tolerance, rotation_tolerance, expressed_in: as there.
    """
    return pose_task(kind, axis, weights, tolerance, rotation_tolerance, expressed_in)


def hashable(name: str, values: Any) -> tuple[float, ...]:
    """Numbers of a user as a tuple."""
    return tuple(real_array(name, values).ravel().tolist())
