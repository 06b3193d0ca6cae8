"""Planners of arms: a question becomes a path, its nodes and what was looked at, or a proof by boxes that none is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product, repeat
from time import perf_counter
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.planning.arm_limits import Moving, bounds_of, endless_joints, held_joints, held_of
from mafsil.planning.arm_plan import ArmPlan
from mafsil.planning.arm_search import Searched, add_counts, search
from mafsil.planning.cell_cover import MOST_MOVING, cover
from mafsil.planning.kept_planning import Kept
from mafsil.planning.outcome import PlanningStatus, Reason, best_kept
from mafsil.planning.pipeline import take_shortcuts
from mafsil.planning.problem import Problem, length_of
from mafsil.planning.search import PLANNERS, SearchBudget

if TYPE_CHECKING:
    import mafsil.planning.path_optimisation as path_optimisation
    import mafsil.planning.roadmap as roadmaps
    from mafsil.planning.roadmap import ArmRoadmap
else:
    path_optimisation = lazily("mafsil.planning.path_optimisation")
    roadmaps = lazily("mafsil.planning.roadmap")

if TYPE_CHECKING:
    from mafsil.collision import Checker

LAZY = "lazy_prm_star"
CELLS = "cell_decomposition"
RESTARTS, MOST_SEARCHES, KEPT = 0.5, 100_000, 20
"""Share of a budget that searches from other seeds take; most of them, and of their paths that a roadmap holds."""
BETWEEN = 7919
"""Seeds of searches differ by that."""


class ArmQuestion(NamedTuple):
    """What a planner of arms is asked.

    Attributes:
        checker: the arm in its scene.
        start: (n,) [rad | m].
        goals: (g, n) of which any will do: free, and within the limits.
        planner: its name.
        seed, seconds, nodes, shorten: as of `plan`.
        bounds: (n,), (n,) between which it may search; one value for what is held.
        moving: joints that were named as free to move, if they were.
        leave: whether searches begin with tools that go back, whatever the seed.
    """

    checker: Checker
    start: JointVector
    goals: JointVector
    planner: str
    seed: int
    seconds: float
    nodes: int
    shorten: int
    bounds: tuple[Floats, Floats] = (np.zeros(0), np.zeros(0))
    moving: Moving = None
    leave: bool = True


def rrt_connect(asked: ArmQuestion) -> Searched:
    """The compiled search."""
    budget = asked.seed, asked.seconds, asked.nodes, asked.shorten
    return search(asked.checker, asked.start, asked.goals, *budget, asked.moving, asked.leave)


def lazy_prm_star(asked: ArmQuestion) -> Searched:
    """Paths by RRT-Connect, then a roadmap that holds the best of them, where a shorter one can pass.

    1. A first path; without one there is no answer.
    2. Searches from other seeds, for a share of the budget: they go round obstacles on other sides.
    3. The roadmap, until the budget ends: its ways change from one path to another.

    Reference: B. Raveh, A. Enosh, D. Halperin, A little more, a lot better: improving path quality by a path-merging
        algorithm, IEEE T-RO 2011.
    """
    begun = perf_counter()
    # 1.
    asked = asked._replace(leave=False)  # Other seeds are to lead elsewhere.
    first, made, seen = rrt_connect(asked)
    if first is None or made >= asked.nodes:
        return first, made, seen
    # 2.
    paths, straight = [first], float(np.linalg.norm(asked.goals - asked.start, axis=1).min())
    stopped = True
    with best_kept(lambda: True):
        for k in range(1, MOST_SEARCHES):
            used = perf_counter() - begun
            if made >= RESTARTS * asked.nodes or used >= RESTARTS * asked.seconds:
                break
            if length_of(paths[0]) <= straight * (1.0 + 1e-9):
                break
            left = RESTARTS * asked.seconds - used
            again = asked._replace(seed=asked.seed + k * BETWEEN, seconds=left, nodes=asked.nodes - made)
            path, more, also = rrt_connect(again)
            made, seen = made + more, add_counts(seen, also)
            if path is not None:
                paths = sorted([*paths, path], key=length_of)[:KEPT]
        stopped = False
    if stopped:
        return paths[0], made, seen
    # 3.
    left = max(asked.seconds - (perf_counter() - begun), 1e-9)
    roadmap = roadmaps.ArmRoadmap(asked.checker, asked.seed)
    for path in paths[1:]:
        roadmap.include(path)
    rest = asked._replace(seconds=left, nodes=max(asked.nodes - made, roadmap.nodes + 1))
    path, more, also = ask_roadmap(roadmap, rest, paths[0])
    return path, made + more, add_counts(seen, also)


def trajectory_optimisation(asked: ArmQuestion) -> Searched:
    """Straight lines bent by the gradients of distances until they are free; nodes are steps."""
    budget = asked.seed, asked.seconds, asked.nodes
    path, made = path_optimisation.optimise_from_straight(
        asked.checker, asked.bounds, asked.start, asked.goals, *budget
    )
    return path, made, (made, 0 if path is None else len(path) - 1, made * (path_optimisation.POINTS + 2))


def cell_decomposition(asked: ArmQuestion) -> Searched:
    """No search: boxes of configurations decide, as after any search that finds nothing.

    Raises:
        InputError: more coordinates move than boxes are made of.
    """
    lower, upper = asked.bounds
    count = int((upper > lower).sum())
    if count > MOST_MOVING:
        raise InputError("planning.many_moving", planner=asked.planner, count=count, most=MOST_MOVING)
    return None, 0, (0, 0, 0)


def any_planner(asked: ArmQuestion) -> Searched:
    """A planner of `PLANNERS`; each segment is proved."""
    problem = Problem(*asked.bounds, asked.checker.free, asked.checker.free_segment)
    rng = np.random.default_rng(asked.seed)
    budget = SearchBudget(rng, perf_counter() + asked.seconds, asked.nodes)
    path, made = PLANNERS[asked.planner](problem, asked.start, asked.goals, budget)
    if path is not None and asked.shorten:
        path = take_shortcuts(problem, path, rng, asked.shorten)
    counts = problem.counts
    return path, made, (counts.segments, counts.segments, counts.configurations)


def ask_roadmap(roadmap: ArmRoadmap, asked: ArmQuestion, first: JointVector | None = None) -> Searched:
    """A roadmap's answer, with its nodes and what was looked at for it.

    Args:
        roadmap: that is asked and grows.
        asked: what it is asked.
        first: (k, n) a path that is known already.
    """
    before = roadmap.seen
    path = roadmap.path(
        asked.start, asked.goals, seconds=asked.seconds, nodes=asked.nodes, first=first, bounds=asked.bounds
    )
    a, b, c = (now - then for now, then in zip(roadmap.seen, before, strict=True))
    return path, roadmap.nodes, (a, b, c)


ArmSearch: TypeAlias = Callable[[ArmQuestion], Searched]
ARM_PLANNERS: dict[str, ArmSearch] = {
    "rrt_connect": rrt_connect, LAZY: lazy_prm_star, "trajectory_optimisation": trajectory_optimisation,
    CELLS: cell_decomposition,
}  # fmt: skip
"""Planners made for arms: they ask a `Checker` itself and not one configuration or segment after the other."""


MOST_BOXES = 200_000
"""Of the cover that is asked where a search found nothing: about a second."""


def connect_ends(
    checker: Checker, q: JointVector, goals: JointVector, rules: tuple[Moving, ...], seed: int, seconds: float,
    nodes: int, shorten: int, begun: float,
) -> ArmPlan | None:  # fmt: skip
    """What RRT-Connect and boxes of configurations find, one rule of what may move after the other.

    Where boxes may decide, they are asked before most of the budget of a rule is spent.

    Returns:
        None if an end cannot be.
    """
    made, seen, found = 0, (0, 0, 0), None
    for rule, share in product(rules, (0.1, 1.0)) if len(q) <= MOST_MOVING else zip(rules, repeat(1.0)):
        budget = share * seconds, max(int(share * nodes), 1)
        path, more, also = search(checker, q, goals, seed, *budget, shorten, rule)
        if not more:
            return None
        made, seen = made + more, add_counts(seen, also)
        found = answer_of(checker, path, "rrt_connect", made, seen, q, goals, begun, moving=rule)
        if path is None:
            found = decide_by_boxes(found, q, goals, seed, shorten, MOST_BOXES, seconds)
        if found.status is not PlanningStatus.NOT_FOUND:
            return found
    return found


def decide_by_boxes(
    found: ArmPlan, q: JointVector, goals: JointVector, seed: int, shorten: int, boxes: int, seconds: float
) -> ArmPlan:
    """The same, but where nothing was found and few coordinates move, with what boxes of configurations prove.

    While coordinates are held that could move, a proof that there is no path says nothing of them: it is a reason.
    """
    checker = found.checker
    if checker is None or found.status is not PlanningStatus.NOT_FOUND:
        return found
    bounds = bounds_of(checker, np.concatenate([q[None], goals]), found.moving)
    moving = bounds[1] > bounds[0]
    if not 0 < moving.sum() <= MOST_MOVING:
        return found
    begun, limits = perf_counter(), checker.robot.limits
    is_open = ((goals >= limits.lower) & (goals <= limits.upper)).all(axis=1) & checker.free(goals)
    sure = cover(checker, bounds, q, goals[is_open], boxes, seconds)
    found = replace(
        found, nodes=found.nodes + sure.boxes, configurations=found.configurations + sure.boxes,
        seconds=found.seconds + perf_counter() - begun,
    )  # fmt: skip
    if sure.separated:
        status = PlanningStatus.SEPARATED if moving.all() else found.status
        proof = Reason(("planning.boxes" if moving.all() else "planning.boxes_held", {"count": sure.boxes}))
        reason = found.reason if isinstance(found.reason, Reason) else Reason()
        return replace(found, status=status, reason=reason.and_then(proof))
    if sure.path is None:
        return found
    problem = Problem(*bounds, checker.free, checker.free_segment)
    path = take_shortcuts(problem, sure.path, np.random.default_rng(seed), shorten) if shorten else sure.path
    goal = int(np.abs(goals - path[-1]).max(axis=1).argmin())
    return replace(found, status=PlanningStatus.FOUND, path=path, reason="", goal=goal)


def answer_of(
    checker: Checker, path: JointVector | None, planner: str, made: int, seen: tuple[int, int, int], q: JointVector,
    goals: JointVector, begun: float, kept: Kept | None = None, moving: Moving = None,
) -> ArmPlan:  # fmt: skip
    """The answer with the path that a planner found, or with what was held that could move."""
    status = PlanningStatus.NOT_FOUND if path is None else PlanningStatus.FOUND
    points = q[None] if path is None else path
    reached = -1 if path is None else 0 if len(goals) == 1 else int(np.abs(goals - points[-1]).max(axis=1).argmin())
    looked_at, proofs, states = seen
    seconds, reason = perf_counter() - begun, ""
    if path is None:
        held = held_of(checker, np.concatenate([q[None], goals]), moving)
        reason = endless_joints(checker, held).and_then(held_joints(checker, held))
    return ArmPlan(
        status, points, planner, states, looked_at, made, seconds, reason, checker, (), proofs, reached, kept,
        moving=moving,
    )  # fmt: skip
