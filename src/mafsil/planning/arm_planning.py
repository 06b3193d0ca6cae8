"""Paths of an arm among obstacles: goals as configurations or poses, a compiled search, motions proved free."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from threading import local
from time import perf_counter
from typing import TYPE_CHECKING, TypeAlias, cast
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, as_batch, positive, real_array, require_finite, single, whole
from mafsil.collision import Checker, Obstacle, Scene
from mafsil.errors import InputError
from mafsil.geometry import Pose
from mafsil.ik import inverse_kinematics
from mafsil.lazy_module import lazily
from mafsil.model.loading import RobotLike
from mafsil.model.placement import checked_poses
from mafsil.planning.arm_limits import UNBOUNDED, beyond_limits, bounds_of, endless_joints
from mafsil.planning.arm_plan import ArmPlan
from mafsil.planning.closed_arms import closed_configurations, loops_kept
from mafsil.planning.goal_region import GoalRegion
from mafsil.planning.interruption import tells_of_interruption
from mafsil.planning.kept_planning import Kept, search_kept
from mafsil.planning.outcome import PlanningStatus
from mafsil.planning.path_constraints import Constraint, kept_of
from mafsil.planning.path_optimisation import POINTS, optimise_from_straight
from mafsil.planning.problem import Problem
from mafsil.planning.roadmap import ArmRoadmap
from mafsil.planning.search import PLANNERS, Budget
from mafsil.planning.shortening import shortened

if TYPE_CHECKING:
    import mafsil.planning.arm_question_loops as arm_question_loops
    import mafsil.planning.arm_search_loops as arm_search_loops
    import mafsil.solvers.held_loops as held_loops
    from mafsil.collision.laid_arm import LaidArm
    from mafsil.planning.arm_question_loops import Question
    from mafsil.planning.arm_search_loops import Forests
    from mafsil.solvers.held_loops import Held
else:
    arm_question_loops = lazily("mafsil.planning.arm_question_loops")
    arm_search_loops = lazily("mafsil.planning.arm_search_loops")
    held_loops = lazily("mafsil.solvers.held_loops")

LAZY = "lazy_prm_star"
FIRST_ROOM = 1024
"""Nodes of each side that there are arrays for at first."""
SLICE = 512
"""Samples between two looks at the clock."""
Searched: TypeAlias = tuple[JointVector | None, int, tuple[int, int, int]]
"""Path, nodes, (edges looked at, proofs, states)."""


class _OfThread(local):
    def __init__(self) -> None:
        self.forests: dict[int, Forests] = {}
        self.questions: WeakKeyDictionary[LaidArm, Held[Question]] = WeakKeyDictionary()


_OF_THREAD = _OfThread()


@tells_of_interruption
def plan(
    robot: RobotLike | Checker | ArmRoadmap,
    scene: Scene | Iterable[Obstacle] | None,
    start: ArrayLike,
    goal: ArrayLike | Pose | GoalRegion,
    *,
    planner: str = "rrt_connect",
    seed: int = 0,
    seconds: float = 10.0,
    nodes: int = 200_000,
    shorten: int = 100,
    margin: float | None = None,
    keep: Constraint | Iterable[Constraint] = (),
    radius: float | None = None,
) -> ArmPlan:
    """A path of an arm from a configuration to a goal, each straight motion of it proved free of collisions.

    1. Poses become configurations: all solutions of the inverse kinematics within the limits.
    2. Ends that collide or lie outside the limits are named with what they meet.
    3. RRT-Connect in compiled code, or another planner of `PLANNERS`; edges are looked at when they grow and proved
       when they count. What is to be kept is kept by projection, and proved between the points of the path.
    4. Shortcuts, proved too.

    Coordinates that do not move the tip and are the same at start and goals, such as those of a gripper, stay.
    The loops of a mechanism stay closed: its poses become configurations with closed loops by a search, and every path
    keeps `loops_kept` as well.

    Many questions about one arm: make a `collision.Checker` once and give it as `robot`.

    Args:
        robot: a Robot, a Mechanism, a library name, a path, a Checker, or an ArmRoadmap that is asked and grows.
        scene: obstacles in {s}; None for that of a Checker, or none.
        start: (n,) [rad | m].
        goal: (n,); (k, n) of which any will do; a Pose, or (4, 4) or (k, 4, 4) poses of the tip in {s}; a GoalRegion,
            of whose poses any will do.
        planner: a name of `mafsil.planning.PLANNERS` or of `ARM_PLANNERS`.
        seed: of the samples; equal seeds give equal paths where the time does not end the search.
        seconds: after which it gives up, or for planners that improve gives the best so far.
        nodes: most that it may make.
        shorten: about how many motions are tried to make the path shorter; 0 for none.
        margin: clearance to keep [m]; that of a Checker, or none.
        keep: what the path keeps all along, such as `planning.Upright(0.1)`: one or several constraints. Only with
            "rrt_connect", which alone knows loops too.
        radius: of capsules along the links, for a robot without shapes [m]; a Checker was made with its own.

    Ctrl-C ends planners that improve with the best so far, `interrupted`; others raise `KeyboardInterrupt`.

    Raises:
        InputError: a wrong shape, a number that is not finite, an unknown planner; a loop that is closed by a joint
            other than a hinge, a ball or a fixed one.

    Reference: J. Kuffner, S. LaValle, RRT-Connect, ICRA 2000; proofs as in Schwarzer, Saha, Latombe, IEEE T-RO 2005.
    """
    roadmap = robot if isinstance(robot, ArmRoadmap) else None
    if roadmap is not None:
        if scene is not None or keep or margin is not None or radius is not None:
            raise InputError("planning.roadmap_as_it_is")
        planner = LAZY
    checker = _checker(robot, scene, margin, radius) if not isinstance(robot, ArmRoadmap) else robot.checker
    n, mechanism = checker.robot.n, checker.robot.mechanism
    loops = loops_kept(mechanism) if mechanism.loops else ()
    q = np.array(single("start", start, (n,)))
    if not isinstance(cast(object, planner), str) or (planner not in PLANNERS and planner not in ARM_PLANNERS):
        raise InputError("input.choice", name="planner", value=planner, known=", ".join({**ARM_PLANNERS, **PLANNERS}))
    for name, number, least in (("seed", seed, 0), ("nodes", nodes, 1), ("shorten", shorten, 0)):
        whole(name, number, least=least)
    positive("seconds", seconds)
    begun = perf_counter()
    # 1.
    goals = configurations_of(checker, goal, q)
    if planner == "rrt_connect" and not keep and not loops and roadmap is None and len(goals):
        path, made, seen = _search(checker, q, goals, seed, seconds, nodes, shorten)
        if made:  # Else an end cannot be, which follows by name.
            return _answer(checker, path, planner, made, seen, q, goals, begun)
    # 2.
    refused = _refused(checker, q, goals, planner, begun)
    if isinstance(refused, ArmPlan):
        return _reasoned(refused, checker, goal, q)
    open_goals = goals[refused]
    lower, upper = bounds_of(checker, np.concatenate([q[None], goals]))
    constraints = ((keep,) if not isinstance(keep, Iterable) else tuple(keep)) + loops
    kept = Kept(*kept_of(checker, constraints, q, (lower, upper))) if constraints else None
    # 3., 4.
    if kept is not None:
        if planner != "rrt_connect":
            raise InputError("planning.loops_planner" if loops else "planning.keep_planner", planner=planner)
        off = _not_kept(checker, kept, q, open_goals, begun)
        if isinstance(off, ArmPlan):
            return off
        path, made, seen = search_kept(checker, kept, q, open_goals[off], seed, seconds, nodes, shorten)
    elif roadmap is not None:
        path, made, seen = _asked(roadmap, (lower, upper), q, open_goals, seconds, nodes)
    else:
        search = ARM_PLANNERS.get(planner, _general)
        path, made, seen = search(checker, (lower, upper), q, open_goals, planner, seed, seconds, nodes, shorten)
    return _answer(checker, path, planner, made, seen, q, goals, begun, kept)


def _answer(
    checker: Checker, path: JointVector | None, planner: str, made: int, seen: tuple[int, int, int], q: JointVector,
    goals: JointVector, begun: float, kept: Kept | None = None,
) -> ArmPlan:  # fmt: skip
    status = PlanningStatus.NOT_FOUND if path is None else PlanningStatus.FOUND
    points = q[None] if path is None else path
    reached = -1 if path is None else 0 if len(goals) == 1 else int(np.abs(goals - points[-1]).max(axis=1).argmin())
    looked_at, proofs, states = seen
    seconds, reason = perf_counter() - begun, "" if path is not None else endless_joints(checker)
    return ArmPlan(
        status, points, planner, states, looked_at, made, seconds, reason, checker, (), proofs, reached, kept
    )  # fmt: skip


def _checker(
    robot: RobotLike | Checker, scene: Scene | Iterable[Obstacle] | None, margin: float | None, radius: float | None
) -> Checker:
    if not isinstance(robot, Checker):
        return Checker(
            robot, () if scene is None else scene, margin=0.0 if margin is None else margin, radius=radius
        )  # fmt: skip
    if radius is not None:
        raise InputError("planning.radius_of_a_checker")
    checker = robot if scene is None else robot.with_scene(scene)
    return checker if margin is None else checker.with_margin(margin)


def configurations_of(checker: Checker, goal: ArrayLike | Pose | GoalRegion, start: JointVector) -> JointVector:
    """(k, n) goals; of poses all solutions within the limits."""
    n = checker.robot.n
    if isinstance(goal, GoalRegion):
        return _solutions(checker, goal.poses(), start)
    typed = isinstance(goal, Pose)
    array = np.asarray(goal, dtype=np.float64) if typed else real_array("goal", goal)
    if not array.size:
        raise InputError("planning.no_goals")
    if not typed and array.shape == (n,):
        return np.array(require_finite("goal", array), ndmin=2)
    if not typed and array.ndim == 2 and array.shape[-1] == n and not _looks_like_pose(array, n):
        return np.array(as_batch("goal", array, (n,), finite=True), ndmin=2)
    if array.ndim not in (2, 3) or array.shape[-2:] != (4, 4):
        raise InputError("planning.no_goal", n=n, got=array.shape)
    return _solutions(checker, checked_poses("goal", array).reshape(-1, 4, 4), start)


def _solutions(checker: Checker, poses: Floats, start: JointVector) -> JointVector:
    if checker.robot.mechanism.loops:
        return closed_configurations(checker.robot, poses, start)
    rows: list[JointVector] = [np.zeros((0, checker.robot.n))]
    for T in poses:
        found = inverse_kinematics(checker.robot, T, q0=start)
        rows.append(np.asarray(found.q)[np.asarray(found.within, dtype=np.bool_)].reshape(-1, checker.robot.n))
    return np.concatenate(rows)


def _reasoned(refused: ArmPlan, checker: Checker, goal: ArrayLike | Pose | GoalRegion, q: JointVector) -> ArmPlan:
    """The same, for poses without a configuration with what inverse kinematics says of the first of them."""
    if refused.status is not PlanningStatus.UNREACHABLE or checker.robot.mechanism.loops:
        return refused
    poses = goal.poses() if isinstance(goal, GoalRegion) else np.asarray(goal, dtype=np.float64).reshape(-1, 4, 4)
    found = inverse_kinematics(checker.robot, poses[0], q0=q)
    return replace(refused, reason=found.explain().split("\n")[0])


def _looks_like_pose(array: Floats, n: int) -> bool:
    """Whether rows of four numbers are a pose: an arm with four joints wants a Pose to be sure."""
    return n != 4 and array.shape == (4, 4)


def _refused(
    checker: Checker, q: JointVector, goals: JointVector, planner: str, begun: float
) -> ArmPlan | np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """An end that cannot be, with the reason; else which goals are open."""

    def ended(status: PlanningStatus, reason: str = "", ends: JointVector | None = None) -> ArmPlan:
        checks = () if ends is None else tuple(checker.check(row) for row in ends[:10])
        return ArmPlan(status, q[None], planner, 1, 0, 0, perf_counter() - begun, reason, checker, checks)

    beyond = beyond_limits(checker, q)
    if beyond:
        return ended(PlanningStatus.START_OUTSIDE, beyond)
    if not checker.free(q):
        return ended(PlanningStatus.START_BLOCKED, ends=q[None])
    if not len(goals):
        return ended(PlanningStatus.UNREACHABLE)
    outside = [beyond_limits(checker, row) for row in goals]
    within = np.array([not each for each in outside])
    if not within.any():
        return ended(PlanningStatus.GOAL_OUTSIDE, outside[0])
    found = within & checker.free(goals)
    if not found.any():
        return ended(PlanningStatus.GOAL_BLOCKED, ends=goals[within])
    return found


def _not_kept(
    checker: Checker, kept: Kept, q: JointVector, goals: JointVector, begun: float
) -> ArmPlan | np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """An end that does not keep what is to be kept, with by how much; else which goals do."""

    def ended(status: PlanningStatus, end: JointVector) -> ArmPlan:
        reason = "; ".join(kept.sentences(kept.measures(checker, end[None])[0]))
        return ArmPlan(status, q[None], "rrt_connect", 1, 0, 0, perf_counter() - begun, reason, checker)

    if not kept.holds(checker, q[None])[0]:
        return ended(PlanningStatus.START_OFF, q)
    found = kept.holds(checker, goals)
    return found if found.any() else ended(PlanningStatus.GOAL_OFF, goals[0])


def _search(
    checker: Checker, q: JointVector, goals: JointVector, seed: int, seconds: float, nodes: int, shorten: int
) -> Searched:  # fmt: skip
    """RRT-Connect in slices: the clock and an interruption are looked at between them.

    1. A slice is one compiled call; the first also looks at the ends and tries straight motions, the last makes
       shortcuts.
    2. Arrays double where they are full. The clock starts after the first slice: a first call ever also waits for the
       compiler.

    Returns:
        None in place of the path if there is none, or if an end cannot be, which leaves no nodes.
    """
    loops, workshop, question = arm_question_loops, checker.workshop(), _question_for(checker, len(goals))
    forests, deadline = question.value.forests, np.inf
    drawn = min(SLICE, nodes)
    code, path = loops.solve(workshop, question, q, goals, seed, 0, drawn, shorten)  # 1
    if code == loops.REFUSED:
        return None, 0, (0, 0, 0)
    while code != loops.JOINED:
        made, now = _nodes(forests), perf_counter()
        deadline = min(deadline, now + seconds)
        if made >= nodes or now > deadline:
            return None, made, _counted(forests.seen)
        if code == loops.FULL:  # 2
            forests = arm_search_loops.doubled(forests)
            question = held_loops.Held(question.value._replace(forests=forests))
        left = max(min(SLICE, nodes - made), 1)
        code, path = loops.solve(workshop, question, q, goals, seed, drawn, left, shorten)
        drawn += left
    return path, _nodes(forests), _counted(forests.seen)


def _question_for(checker: Checker, goals: int) -> Held[Question]:
    """Where this thread searches for paths of an arm, with place for so many goals; kept for the next question."""
    known, n = _OF_THREAD.questions.get(checker.laid), checker.robot.n
    if known is None or known.value.forests.q.shape[1] < goals + 2:
        limits = checker.robot.limits
        between = arm_question_loops.Limits(limits.lower.copy(), limits.upper.copy(), checker.moves_tip, UNBOUNDED)
        known = held_loops.Held(arm_question_loops.Question(between, _forests_for(n, goals), *np.empty((2, 2, n))))
        _OF_THREAD.questions[checker.laid] = known
    return known


def _forests_for(n: int, goals: int) -> Forests:
    """Arrays of this thread for a search, used again by the next one."""
    known = _OF_THREAD.forests
    if n not in known or known[n].q.shape[1] < goals + 2:
        ends, random = np.zeros((goals, n)), np.zeros(1, np.uint64)
        known[n] = arm_search_loops.forests_of(np.zeros(n), ends, FIRST_ROOM, random, np.zeros(3, np.int64))
    return known[n]


def _compiled(
    checker: Checker, bounds: tuple[Floats, Floats], q: JointVector, goals: JointVector, planner: str, seed: int,
    seconds: float, nodes: int, shorten: int,
) -> Searched:  # fmt: skip
    """As every search of `ARM_PLANNERS`."""
    del bounds, planner
    return _search(checker, q, goals, seed, seconds, nodes, shorten)


def _nodes(forests: Forests) -> int:
    of_start, of_goals, _ = forests.sizes.tolist()
    return of_start + of_goals


def _counted(seen: NDArray[np.int64]) -> tuple[int, int, int]:
    looked_at, proved, states = seen.tolist()
    return looked_at, proved, states


def _general(
    checker: Checker, bounds: tuple[Floats, Floats], q: JointVector, goals: JointVector, planner: str, seed: int,
    seconds: float, nodes: int, shorten: int,
) -> Searched:  # fmt: skip
    """Any planner of `PLANNERS`; each segment is proved."""
    problem = Problem(*bounds, checker.free, checker.free_segment)
    rng = np.random.default_rng(seed)
    path, made = PLANNERS[planner](problem, q, goals, Budget(rng, perf_counter() + seconds, nodes))
    if path is not None and shorten:
        path = shortened(problem, path, rng, shorten)
    counts = problem.counts
    return path, made, (counts.segments, counts.segments, counts.configurations)


def _optimising(
    checker: Checker, bounds: tuple[Floats, Floats], q: JointVector, goals: JointVector, planner: str, seed: int,
    seconds: float, nodes: int, shorten: int,
) -> Searched:  # fmt: skip
    """Straight lines bent by the gradients of distances until they are free; nodes are steps."""
    del planner, shorten
    path, made = optimise_from_straight(checker, bounds, q, goals, seed, seconds, nodes)
    return path, made, (made, 0 if path is None else len(path) - 1, made * (POINTS + 2))


def _lazy_prm_star(
    checker: Checker, bounds: tuple[Floats, Floats], q: JointVector, goals: JointVector, planner: str, seed: int,
    seconds: float, nodes: int, shorten: int,
) -> Searched:  # fmt: skip
    """A first path by RRT-Connect, then a roadmap where a shorter one can pass, until the budget ends."""
    begun = perf_counter()
    first, made, seen = _compiled(checker, bounds, q, goals, planner, seed, seconds, nodes, shorten)
    left = max(seconds - (perf_counter() - begun), 1e-9)
    if first is None or made >= nodes:
        return first, made, seen
    path, more, also = _asked(ArmRoadmap(checker, seed), bounds, q, goals, left, nodes - made, first)
    a, b, c = (x + y for x, y in zip(seen, also, strict=True))
    return path, made + more, (a, b, c)


def _asked(
    roadmap: ArmRoadmap, bounds: tuple[Floats, Floats], q: JointVector, goals: JointVector, seconds: float, nodes: int,
    first: JointVector | None = None,
) -> Searched:  # fmt: skip
    """A roadmap's answer, with its nodes and what was looked at for it."""
    before = roadmap.seen
    path = roadmap.path(q, goals, seconds=seconds, nodes=nodes, first=first, bounds=bounds)
    a, b, c = (now - then for now, then in zip(roadmap.seen, before, strict=True))
    return path, roadmap.nodes, (a, b, c)


ArmSearch: TypeAlias = Callable[
    [Checker, tuple[Floats, Floats], JointVector, JointVector, str, int, float, int, int], Searched
]
"""(checker, bounds, start, goals, name, seed, seconds, nodes, shorten) -> path, nodes, (edges, proofs, states)."""
ARM_PLANNERS: dict[str, ArmSearch] = {
    "rrt_connect": _compiled, LAZY: _lazy_prm_star, "trajectory_optimisation": _optimising,
}  # fmt: skip
"""Planners made for arms: they ask a `Checker` itself and not one configuration or segment after the other."""
