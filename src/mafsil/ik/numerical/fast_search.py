"""The fast search: everything but the poses prepared once, one compiled call, fields made when they are read."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil import threads
from mafsil.arrays import Floats, JointVector, PoseMatrix, real_array
from mafsil.ik.numerical import block_loops as columns
from mafsil.ik.numerical.problem import problem_of
from mafsil.ik.numerical.program import PROGRAM
from mafsil.ik.numerical.search import LANES, Plan, cached_plan
from mafsil.ik.numerical.search_loops import GROUP, RECORD
from mafsil.ik.numerical.start_loops import LANE
from mafsil.ik.numerical.task import PoseTask, pose_task
from mafsil.ik.result import IKResult
from mafsil.ik.status import CODES, IKStatus
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

    def __init__(self, plan: Plan) -> None:
        self.plan, self.part, self.n = plan, plan.problem.part, plan.problem.robot.n
        self._entry = PROGRAM["block"]
        self._idle: list[_Work] = []

    def single(self, T_sd: PoseMatrix, q0: JointVector | None, restarts: int) -> IKResult | None:
        """The answer for one pose; None where there is none by this way.

        Args:
            T_sd: (4, 4).
            q0: (n,) where to start, of the joints that move the frame.
            restarts: how many more starts are tried after the first.
        """
        # Taking from and adding to a list is one step of the interpreter: no two threads get the same work.
        work = self._idle.pop() if self._idle else _Work(self.plan, self.n)
        work.wanted[...] = T_sd
        if q0 is not None:
            work.q0[...] = q0
        attempts = restarts + 1 if restarts < MOST_ATTEMPTS else MOST_ATTEMPTS
        solved = self._entry(*work.given, 0 if q0 is None else 1, 1, 1, attempts, *work.own)
        numbers = work.report.copy() if solved else None
        self._idle.append(work)
        return None if numbers is None else IKResult(Report(numbers, self.plan).field)

    def rows(self, wanted: Floats, starts: JointVector, restarts: int) -> Floats:
        """(k, CONFIGURATION + n) report of many poses, see `block_loops`: attempts are -1 where there is no answer.

        Args:
            wanted: (k, 16) contiguous.
            starts: (k, n) contiguous, or (0, n).
            restarts: how many more starts are tried after the first.
        """
        report = np.empty((len(wanted), columns.CONFIGURATION + self.n))
        attempts = min(restarts + 1, MOST_ATTEMPTS)

        def block(index: int) -> None:
            rows = slice(index * BLOCK, min((index + 1) * BLOCK, len(wanted)))
            self._block(wanted[rows], starts[rows], attempts, report[rows])

        blocks = -(-len(wanted) // BLOCK)
        threads.run(block, blocks, threads.available() if blocks > 1 else 1)
        return report

    def _block(self, wanted: Floats, starts: JointVector, attempts: int, report: Floats) -> None:
        k, n = len(wanted), self.n
        lanes = 1 if k == 1 else min(LANES, -(-k // GROUP) * GROUP)
        work, whole = (
            np.zeros((17 + n) * k + n + (28 + 2 * n) * lanes),
            np.empty(RECORD * k + LANE * lanes + 3, np.int64),
        )
        record, features, step = self.plan.head
        given = record, features, step, self.plan.check.addresses.batch, wanted.ctypes.data, starts.ctypes.data
        made = work.ctypes.data, whole.ctypes.data, report.ctypes.data
        self._entry(*given, int(len(starts) > 0), k, lanes, attempts, *made)


class _Work:
    """The memory of the search for one pose, see `block_loops`."""

    def __init__(self, plan: Plan, n: int) -> None:
        size = columns.CONFIGURATION + n
        self.numbers = np.zeros(16 + n + size + (17 + n) + n + 28 + 2 * n)
        self.whole = np.zeros(RECORD + LANE + 3, np.int64)
        self.wanted, self.q0 = self.numbers[:16].reshape(4, 4), self.numbers[16 : 16 + n]
        self.report = self.numbers[16 + n : 16 + n + size]
        at = self.numbers.ctypes.data
        tables = plan.record.ctypes.data, plan.pool.features.ctypes.data
        self.given = *tables, plan.step.addresses.few, plan.check.addresses.few, at, at + 128
        self.own = at + 8 * (16 + n + size), self.whole.ctypes.data, at + 8 * (16 + n)


class Report:
    """What was found of poses, from which the fields of an answer are made.

    Args:
        numbers: (*batch, CONFIGURATION + n) see `block_loops`.
        plan: of the search.
        codes: (*batch,) index into STATUSES; all solved if None.
        worst: row -> joint that a solution without limits exceeds most.
    """

    __slots__ = ("codes", "numbers", "plan", "worst")

    def __init__(
        self,
        numbers: Floats,
        plan: Plan,
        codes: NDArray[np.int8] | None = None,
        worst: dict[int, str] | None = None,
    ) -> None:
        self.numbers, self.plan, self.codes, self.worst = numbers, plan, codes, worst

    def shaped(self, batch: tuple[int, ...]) -> Report:
        """The same in the shape of a batch.

        Args:
            batch: leading dimensions.
        """
        codes = None if self.codes is None else self.codes.reshape(batch)
        return Report(self.numbers.reshape(*batch, self.numbers.shape[-1]), self.plan, codes, self.worst)

    def field(self, name: str) -> Any:
        """A field of the answer."""
        numbers = self.numbers
        batch = numbers.shape[:-1]
        if name == "nearest":
            return np.ascontiguousarray(numbers[..., columns.CONFIGURATION :])
        if name == "codes":
            return self.codes if self.codes is not None else np.full(batch, SOLVED, np.int8) if batch else _SOLVED
        if name == "T_reached":
            return np.ascontiguousarray(numbers[..., columns.REACHED : columns.REACHED + 16]).reshape(*batch, 4, 4)
        if name in _COLUMNS:
            column, kind = _COLUMNS[name]
            return np.array(numbers[..., column], kind)
        if name == "reach":
            return np.full(batch, self.plan.problem.reach[1])
        return self.plan.problem.robot.n if name == "moving" else self._worst(batch)

    def _worst(self, batch: tuple[int, ...]) -> NDArray[np.str_]:
        found = self.worst or {}
        names = np.zeros(batch, dtype=f"U{max((len(each) for each in found.values()), default=1)}")
        for row, joint in found.items():
            names.reshape(-1)[row] = joint
        return names


_COLUMNS = {
    "rotation_error": (columns.ROTATION, np.float64),
    "position_error": (columns.POSITION, np.float64),
    "distance": (columns.DISTANCE, np.float64),
    "iterations": (columns.ITERATIONS, np.int64),
    "attempts": (columns.ATTEMPTS, np.int64),
}


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
