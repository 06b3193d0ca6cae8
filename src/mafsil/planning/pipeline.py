"""One pipeline: plan, shorten; a path for `time_optimal`, and the account of it."""

from __future__ import annotations

from time import perf_counter
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import JointVector, as_batch, positive, require_kind, whole
from mafsil.errors import InputError
from mafsil.planning.interruption import tells_of_interruption
from mafsil.planning.outcome import Plan, PlanningStatus
from mafsil.planning.problem import Problem
from mafsil.planning.search import PLANNERS, SearchBudget
from mafsil.planning.shortening import take_shortcuts


@tells_of_interruption
def find_path(
    problem: Problem,
    start: ArrayLike,
    goal: ArrayLike,
    *,
    planner: str = "rrt_connect",
    seed: int = 0,
    seconds: float = 10.0,
    max_nodes: int = 100_000,
    shortcut_iterations: bool = True,
) -> Plan:
    """A free path from a configuration to a goal, or to any of several.

    1. Ends that are not free are said at once.
    2. The planner, within its budget.
    3. Shortcuts; every segment of the result was looked at.

    Args:
        problem: what is free.
        start: (n,) [rad | m].
        goal: (n,), or (k, n) of which any will do.
        planner: a name of `mafsil.planning.PLANNERS`.
        seed: of the samples; equal seeds give equal paths where the time does not end the search.
        seconds: after which it gives up, or for planners that improve gives the best so far.
        max_nodes: most that it may make.
        shortcut_iterations: whether the path is shortened.

    Raises:
        InputError: a wrong shape, a number that is not finite, an unknown planner.

    Reference: LaValle, Planning Algorithms, ch. 5.
    """
    require_kind("problem", problem, "Problem", "is_free", "is_free_segment")
    q = np.asarray(as_batch("start", start, (problem.n,), finite=True))
    goals = np.atleast_2d(as_batch("goal", goal, (problem.n,), finite=True))
    if q.ndim != 1 or goals.ndim != 2:
        raise InputError("input.shape", name="start", expected=(problem.n,), got=q.shape, hint="")
    if not isinstance(cast(object, planner), str) or planner not in PLANNERS:
        raise InputError("input.choice", name="planner", value=planner, known=", ".join(PLANNERS))
    begun = perf_counter()
    problem.counts.configurations = problem.counts.segments = 0
    # 1.
    open_goals = goals[problem.is_free(goals)]
    if not problem.is_free(q)[0]:
        return _end(problem, PlanningStatus.START_BLOCKED, q[None], planner, 0, begun)
    if not len(open_goals):
        return _end(problem, PlanningStatus.GOAL_BLOCKED, q[None], planner, 0, begun)
    same = np.abs(open_goals - q).max(axis=1) == 0.0
    if same.any():
        return _end(problem, PlanningStatus.FOUND, q[None], planner, 1, begun)
    # 2.
    rng = np.random.default_rng(whole("seed", seed))
    budget = SearchBudget(rng, begun + positive("seconds", seconds), whole("max_nodes", max_nodes, least=1))
    path, made = PLANNERS[planner](problem, q, open_goals, budget)
    if path is None:
        return _end(problem, PlanningStatus.NOT_FOUND, q[None], planner, made, begun)
    # 3.
    if shortcut_iterations:
        path = take_shortcuts(problem, path, rng)
    return _end(problem, PlanningStatus.FOUND, path, planner, made, begun)


def _end(problem: Problem, status: PlanningStatus, path: JointVector, planner: str, nodes: int, begun: float) -> Plan:
    counts = problem.counts
    return Plan(status, path, planner, counts.configurations, counts.segments, nodes, perf_counter() - begun)
