"""Planners side by side on the same questions with the same seeds: what they solve, how fast, how short.

A search watched: every edge that a planner asked for, in order, and whether it is free.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.answer import Answer, plain
from mafsil.arrays import Floats, JointVector, positive, whole
from mafsil.collision import Checker
from mafsil.errors import InputError
from mafsil.fields import check_fields, finite
from mafsil.messages import say
from mafsil.messages.tables import number, table
from mafsil.planning.arm_limits import bounds_of
from mafsil.planning.arm_planners import ARM_PLANNERS, CELLS
from mafsil.planning.arm_planning import plan
from mafsil.planning.cell_cover import MOST_MOVING
from mafsil.planning.outcome import Plan, PlanningStatus
from mafsil.planning.pipeline import find_path
from mafsil.planning.problem import Problem
from mafsil.planning.search import PLANNERS


@dataclass(frozen=True, eq=False, slots=True)
class Query:
    """A planning query: start, goal and problem.

    Attributes:
        name: of it.
        space: an arm in its scene, or any problem.
        start: (n,) [rad | m].
        goal: (n,), or (k, n) of which any will do.
    """

    name: str
    space: Checker | Problem
    start: JointVector
    goal: JointVector
    __post_init__ = check_fields(start=finite(1), goal=finite(1, 2))

    @property
    def planners(self) -> tuple[str, ...]:
        """Names of all planners that can be asked."""
        if isinstance(self.space, Problem):
            return tuple(PLANNERS)
        few = self.space.robot.n <= MOST_MOVING
        return tuple(dict.fromkeys(name for name in (*ARM_PLANNERS, *PLANNERS) if few or name != CELLS))

    def run_planner(self, planner: str, seed: int, seconds: float, nodes: int, shorten: bool) -> Plan:
        """The answer of a planner; Ctrl-C goes on to who asked for the table.

        Raises:
            KeyboardInterrupt: Ctrl-C.
        """
        found = self._asked(planner, seed, seconds, nodes, shorten)
        if found.interrupted:
            raise KeyboardInterrupt
        return found

    def _asked(self, planner: str, seed: int, seconds: float, nodes: int, shorten: bool) -> Plan:
        if isinstance(self.space, Problem):
            return find_path(
                self.space, self.start, self.goal, planner=planner, seed=seed, seconds=seconds, max_nodes=nodes,
                shortcut_iterations=shorten,
            )  # fmt: skip
        return plan(
            self.space, None, self.start, self.goal, planner=planner, seed=seed, seconds=seconds, max_nodes=nodes,
            shortcut_iterations=100 if shorten else 0,
        )  # fmt: skip


@dataclass(frozen=True, eq=False, slots=True)
class PlannerResult:
    """The results of one planner on all queries.

    Attributes:
        planner: its name.
        status: (queries, seeds) how each search ended.
        seconds, length, clearance: (queries, seeds); length infinite without a path, clearance of the path of an arm
            at 100 places, NaN where there is none [s], [rad | m], [m].
        configurations, segments, nodes: (queries, seeds) what was looked at.
    """

    planner: str
    status: tuple[tuple[PlanningStatus, ...], ...]
    seconds: Floats
    length: Floats
    clearance: Floats
    configurations: Floats
    segments: Floats
    nodes: Floats

    @property
    def solved(self) -> int:
        """Searches that ended with a path."""
        return int(np.isfinite(self.length).sum())

    @property
    def median_length(self) -> float:
        """Of the paths that were found; NaN without any [rad | m]."""
        found = self.length[np.isfinite(self.length)]
        return float(np.median(found)) if found.size else np.nan

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "planner": self.planner, "solved": self.solved,
            "status": plain(self.status),
            **{name: getattr(self, name) for name in
               ("seconds", "length", "clearance", "configurations", "segments", "nodes")},
        }  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class PlannerBench(Answer, entries="results", data="queries seeds planners=results interrupted"):
    """Planners compared on the same queries; true if each solved all, iterable over the results.

    Those that solved most come first, among equals the quicker ones.

    Attributes:
        results: of the planners.
        queries: names of the questions.
        seeds: of the searches.
        interrupted: whether Ctrl-C ended it: planners that had not answered all questions are left out.
    """

    results: tuple[PlannerResult, ...]
    queries: tuple[str, ...]
    seeds: tuple[int, ...]
    interrupted: bool = False

    @property
    def status(self) -> tuple[PlanningStatus, ...]:
        """Of every search, planner by planner, question by question."""
        return tuple(status for each in self.results for row in each.status for status in row)

    def __bool__(self) -> bool:
        return not self.interrupted and all(each.solved == each.length.size for each in self.results)

    def columns(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """Head (keys) and rows of the table."""
        head = ("", "solved", "median_ms", "most_ms", "length", "clearance_mm", "configurations", "segments", "nodes")
        rows = [
            (
                each.planner, f"{each.solved}/{each.length.size}", number(1e3 * float(np.median(each.seconds))),
                number(1e3 * float(np.quantile(each.seconds, 0.95))), number(each.median_length),
                number(1e3 * float(np.nanmin(each.clearance))) if np.isfinite(each.clearance).any() else "-",
                *(number(float(np.median(x))) for x in (each.configurations, each.segments, each.nodes)),
            )
            for each in self.results
        ]  # fmt: skip
        return head, rows

    def _table(self) -> list[str]:
        head, rows = self.columns()
        return table(head, rows)

    def explain(self, language: str | None = None) -> str:
        """A line for each planner: what it solved, and how the rest ended."""
        lines = [say("planning.bench_interrupted", language=language)] if self.interrupted else []
        for each in self.results:
            total = each.length.size
            lines.append(
                say("planning.bench_line", language=language, planner=each.planner, solved=each.solved, total=total)
            )
            ends = Counter(status for row in each.status for status in row if not status.succeeded)
            lines += [f"  {count} x {status.sentence(language)}" for status, count in ends.most_common()]
        return "\n".join(lines)


def bench_planners(
    queries: Sequence[Query],
    planners: Sequence[str] = (),
    *,
    seeds: Sequence[int] = (0, 1, 2),
    seconds: float = 5.0,
    max_nodes: int = 20_000,
    shortcut_iterations: bool = True,
    progress: Callable[[float], None] = lambda share: None,
) -> PlannerBench:
    """Compare planners on the same queries with the same seeds and budget.

    A planner of one's own takes part by its row in `mafsil.planning.PLANNERS`. Planners that improve while there is
    time use all of it.

    Args:
        queries: what is asked.
        planners: names; all that can answer every question if empty.
        seeds: of the searches.
        seconds: for one search.
        max_nodes: for one search.
        shortcut_iterations: whether paths are shortened.
        progress: called with the share that is done.

    Ctrl-C gives the planners that have answered all questions, `interrupted`; if there is none yet, it goes on to you.

    Raises:
        InputError: no question, an unknown planner, a number out of its range.
    """
    if not len(queries) or not len(seeds):
        raise InputError("planning.bench_nothing")
    known = [name for name in queries[0].planners if all(name in query.planners for query in queries)]
    for name in planners:
        if name not in known:
            raise InputError("input.choice", name="planners", value=name, known=", ".join(known))
    positive("seconds", seconds)
    whole("max_nodes", max_nodes, least=1)
    numbers = tuple(whole("seeds", seed) for seed in seeds)
    chosen = list(planners) or known
    results: list[PlannerResult] = []
    try:
        for k, name in enumerate(chosen):
            plans: list[list[Plan]] = []
            for i, query in enumerate(queries):
                plans.append(
                    [query.run_planner(name, seed, seconds, max_nodes, shortcut_iterations) for seed in numbers]
                )
                progress((k + (i + 1) / len(queries)) / len(chosen))
            results.append(_result(name, queries, plans))
    except KeyboardInterrupt:
        if not results:
            raise
    order = sorted(results, key=lambda each: (-each.solved, float(np.median(each.seconds))))
    names = tuple(query.name for query in queries)
    return PlannerBench(tuple(order), names, numbers, len(results) < len(chosen))


def _result(name: str, queries: Sequence[Query], plans: list[list[Plan]]) -> PlannerResult:
    def each(value: Callable[[Plan], float]) -> Floats:
        return np.array([[value(one) for one in row] for row in plans], dtype=np.float64)

    clearance = np.array([[_clearance(query, one) for one in row] for query, row in zip(queries, plans, strict=True)])
    return PlannerResult(
        name,
        tuple(tuple(one.status for one in row) for row in plans),
        each(lambda one: one.seconds),
        each(lambda one: one.length),
        clearance,
        each(lambda one: one.configurations),
        each(lambda one: one.segments),
        each(lambda one: one.nodes),
    )


def _clearance(query: Query, found: Plan) -> float:
    if not found or isinstance(query.space, Problem):
        return np.nan
    path = found.path
    ways = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    places: Floats = np.linspace(0.0, float(ways[-1]), 100)
    columns: list[Floats] = [np.interp(places, ways, column) for column in path.T]
    q = np.stack(columns, axis=-1)
    return float(query.space.distance(q).distance.min())


@dataclass(frozen=True, eq=False, slots=True)
class SearchLog:
    """The edges and nodes that a search examined.

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
    """Run a planner and record every edge that it examines.

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
