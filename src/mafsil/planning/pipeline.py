"""One pipeline: plan, shorten; a path for `time_optimal`, and the account of it.

Paths made shorter: straight pieces between random places of them, as long as these are free.
"""

from __future__ import annotations

from time import perf_counter
from typing import cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, as_batch, positive, require_kind, whole
from mafsil.errors import InputError
from mafsil.planning.outcome import Plan, PlanningStatus, tells_of_interruption
from mafsil.planning.problem import Problem, length_of
from mafsil.planning.search import PLANNERS, SearchBudget

ALONG = 1e-9
"""Share of the length by which a shortcut must be shorter to count."""


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


def take_shortcuts(problem: Problem, path: JointVector, rng: np.random.Generator, tries: int = 200) -> JointVector:
    """A path (k, n) with shortcuts, never longer.

    1. Corners that a straight piece can leave out, from the ends inwards.
    2. Two random places of the path; if the straight piece between them is free, it replaces the way between. What is
       left of the segments that it cuts is looked at too: each segment of the result was.

    Args:
        problem: what is free.
        path: (k, n) free.
        rng: for the places.
        tries: how many shortcuts are tried.
    """
    # 1.
    k = 0
    rows: list[JointVector] = list(path)
    while k + 2 < len(rows):
        farthest = next(
            (j for j in range(len(rows) - 1, k + 1, -1) if problem.is_free_segment(rows[k], rows[j])), k + 1
        )
        rows[k + 1 : farthest] = []
        k += 1
    best: Floats = np.stack(rows)
    # 2.
    for _ in range(tries):
        if len(best) < 3:
            break
        lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(best, axis=0), axis=1))])
        s: Floats = np.sort(rng.uniform(0.0, lengths[-1], 2))
        i, j = (np.searchsorted(lengths, s, side="right") - 1).tolist()
        if i == j:
            continue
        a, b = (
            best[m] + (best[m + 1] - best[m]) * ((x - lengths[m]) / (lengths[m + 1] - lengths[m]))
            for m, x in zip((i, j), s, strict=True)
        )
        candidate: Floats = np.concatenate([best[: i + 1], np.stack([a, b]), best[j + 1 :]])
        pieces = ((a, b), (best[i], a), (b, best[j + 1]))
        if length_of(candidate) < length_of(best) * (1.0 - ALONG) and all(
            problem.is_free_segment(*piece) for piece in pieces
        ):
            best = np.asarray(candidate[_move(candidate)], dtype=np.float64)
    return best


def _move(path: Floats) -> NDArray[np.bool_]:
    """(k,) which points differ from the one before."""
    return np.append(True, np.abs(np.diff(path, axis=0)).max(axis=1) > 0.0)
