"""A single pose by the shortest way: everything but the pose prepared once, one compiled call, fields on demand."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from mafsil.arrays import Floats, JointVector, PoseMatrix, real_array
from mafsil.ik.numerical import single_loops as places
from mafsil.ik.numerical.problem import problem_of
from mafsil.ik.numerical.program import PROGRAM
from mafsil.ik.numerical.search import Plan, cached_plan
from mafsil.ik.numerical.task import PoseTask, pose_task
from mafsil.ik.result import STATUSES, IKResult, IKStatus
from mafsil.robot import Robot

MOST_ATTEMPTS = 32
"""Attempts of the shortest way; what resists them is begun again by the way that can be stopped."""

_SOLVED = np.array(STATUSES.index(IKStatus.SOLVED), np.int8)
_SOLVED.setflags(write=False)
_NOBODY = np.array("", dtype="U1")
_NOBODY.setflags(write=False)


class SingleSearch:
    """The search for one pose after another.

    Args:
        plan: of the search.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan, self.part, self.n = plan, plan.problem.part, plan.problem.robot.n
        self._entry = PROGRAM["single"]
        self._idle: list[_Work] = []

    def __call__(self, T_sd: PoseMatrix, seed: JointVector | None, restarts: int) -> IKResult | None:
        """The answer; None where there is none by this way, for the general way to say why.

        Args:
            T_sd: (4, 4).
            seed: (n,) where to start, of the joints that move the frame.
            restarts: how many more starts are tried after the first.
        """
        # Taking from and adding to a list is one step of the interpreter: no two threads get the same work.
        work = self._idle.pop() if self._idle else _Work(self.plan, self.n)
        work.wanted[...] = T_sd
        if seed is not None:
            work.seed[...] = seed
        solved = self._entry(*work.given, min(restarts + 1, MOST_ATTEMPTS), seed is not None)
        found = Report(work.report.copy(), self) if solved else None
        self._idle.append(work)
        return None if found is None else IKResult(found.field)


class _Work:
    """The memory of one search at a time, see `single_loops`."""

    def __init__(self, plan: Plan, n: int) -> None:
        whole = np.zeros(places.REPORT + places.JOINTS_FOUND + 1 + 2 * n + 16 + 16 + 2 * (n + 6))
        self.wanted = whole[:16].reshape(4, 4)
        begin = places.REPORT + places.JOINTS_FOUND + n + 1
        self.report, self.seed = whole[places.REPORT : begin - 1], whole[begin : begin + n]
        record, features, step = plan.head
        self.given = record, features, step, plan.check.addresses.batch, whole.ctypes.data
        self.keeps = plan, whole


class Report:
    """What the compiled search wrote of a pose that it solved.

    Args:
        numbers: see `single_loops`.
        search: whose it is.
    """

    __slots__ = ("numbers", "search")

    def __init__(self, numbers: Floats, search: SingleSearch) -> None:
        self.numbers, self.search = numbers, search

    def field(self, name: str) -> Any:
        """A field of the answer."""
        numbers = self.numbers
        if name == "nearest":
            return numbers[places.JOINTS_FOUND :]
        if name == "codes":
            return _SOLVED
        if name == "T_reached":
            return numbers[places.REACHED : places.REACHED + 16].reshape(4, 4)
        if name in _PLACES:
            place, kind = _PLACES[name]
            return numbers[place : place + 1].astype(kind).reshape(())
        if name == "reach":
            return np.asarray(self.search.plan.problem.reach[1])
        return self.search.n if name == "moving" else _NOBODY


_PLACES = {
    "rotation_error": (places.ROTATION, np.float64),
    "position_error": (places.POSITION, np.float64),
    "distance": (places.DISTANCE, np.float64),
    "iterations": (places.ITERATIONS, np.int64),
    "attempts": (places.ATTEMPTS, np.int64),
}


@lru_cache(maxsize=64, typed=True)
def search_of(
    robot: Robot,
    frame: str | None,
    limits: bool,
    rng: int,
    kind: str,
    axis: tuple[float, ...],
    weights: tuple[float, ...] | None,
    tolerance: float,
    rotation_tolerance: float | None,
) -> SingleSearch:
    """The search for single poses of a robot and a task; made once, found by what the user gave.

    Args:
        robot, frame, limits, rng: as for `solve_ik`.
        kind, axis, weights, tolerance, rotation_tolerance: of the task.
    """
    task = task_of(kind, axis, weights, tolerance, rotation_tolerance)
    return SingleSearch(cached_plan(problem_of(robot, frame, limits), task, rng))


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
