"""A search watched: every edge that a planner asked for, in order, and whether it is free."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.collision import Checker
from mafsil.errors import InputError
from mafsil.planning.arm_limits import bounds_of
from mafsil.planning.outcome import Plan
from mafsil.planning.pipeline import find_path
from mafsil.planning.planner_bench import Query
from mafsil.planning.problem import Problem
from mafsil.planning.search import PLANNERS


@dataclass(frozen=True, eq=False, slots=True)
class SearchLog:
    """What a search looked at.

    Attributes:
        query: what was asked.
        plan: how it ended.
        edges: (m, 2, n) segments in the order in which they were asked for.
        free: (m,) whether each is free.
    """

    query: Query
    plan: Plan
    edges: Floats
    free: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.free)


@dataclass(slots=True)
class _Edges:
    ends: list[JointVector] = field(default_factory=list[JointVector])
    free: list[bool] = field(default_factory=list[bool])


def log_search(
    query: Query, planner: str = "rrt_connect", *, seed: int = 0, seconds: float = 10.0, max_nodes: int = 2000
) -> SearchLog:
    """Run a planner and note every edge that it asks for.

    Planners of `PLANNERS` can be watched, one's own too; those that run compiled (`ARM_PLANNERS`) are watched in the
    form that they have there.

    Args:
        query: what is asked.
        planner: its name.
        seed: of the samples.
        seconds: after which it gives up.
        max_nodes: most that it may make.

    Raises:
        InputError: a planner that asks for no edges one by one.
    """
    if planner not in PLANNERS:
        raise InputError("input.choice", name="planner", value=planner, known=", ".join(PLANNERS))
    problem, edges = _problem(query), _Edges()
    plain = problem.is_free_segment

    def noted(a: JointVector, b: JointVector) -> bool:
        free = plain(a, b)
        edges.ends.append(np.stack([a, b]))
        edges.free.append(free)
        return free

    found = find_path(
        replace(problem, segment=noted), query.start, query.goal, planner=planner, seed=seed, seconds=seconds,
        max_nodes=max_nodes, shortcut_iterations=False,
    )  # fmt: skip
    n = problem.n
    return SearchLog(query, found, np.array(edges.ends).reshape(-1, 2, n), np.array(edges.free, dtype=np.bool_))


def _problem(query: Query) -> Problem:
    if not isinstance(query.space, Checker):
        return query.space
    arm, ends = query.space, np.concatenate([query.start[None], np.atleast_2d(query.goal)])
    return Problem(*bounds_of(arm, ends), arm.free, arm.free_segment)
