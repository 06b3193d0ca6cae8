"""Paths of an arm among obstacles: goals as configurations or poses, a compiled search, motions proved free."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil import collision, ik
from mafsil.arrays import Floats, JointVector, as_batch, positive, real_array, require_finite, single, whole
from mafsil.errors import InputError
from mafsil.geometry import Pose
from mafsil.lazy_module import lazily
from mafsil.model.loading import RobotLike
from mafsil.model.placement import checked_poses
from mafsil.planning.arm_limits import (
    GoalRegion,
    Moving,
    beyond_limits,
    bounds_of,
    rule_for,
    with_carriers,
)
from mafsil.planning.arm_plan import ArmPlan
from mafsil.planning.arm_planners import (
    ARM_PLANNERS,
    CELLS,
    LAZY,
    MOST_BOXES,
    ArmQuestion,
    answer_of,
    any_planner,
    ask_roadmap,
    connect_ends,
    decide_by_boxes,
)
from mafsil.planning.arm_search import search
from mafsil.planning.kept_planning import Kept, Measured, closed_configurations, loop_constraints, search_kept
from mafsil.planning.outcome import FirstLine, PlanningStatus, Reason, tells_of_interruption
from mafsil.planning.path_constraints import Constraint, kept_of
from mafsil.planning.search import PLANNERS
from mafsil.robot.degrees import in_radians, remark_on_degrees

if TYPE_CHECKING:
    import mafsil.planning.roadmap as roadmaps
    from mafsil.planning.roadmap import ArmRoadmap
else:
    roadmaps = lazily("mafsil.planning.roadmap")

if TYPE_CHECKING:
    from mafsil.collision import Checker, Obstacle, Scene


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
    max_nodes: int = 200_000,
    shortcut_iterations: int = 100,
    clearance: float | None = None,
    self_clearance: float | None = None,
    constraints: Constraint | Iterable[Constraint] = (),
    radius: float | None = None,
    active_joints: Iterable[str] | None = None,
    degrees: bool = False,
) -> ArmPlan:
    """A collision-free path of an arm from a configuration to a goal; every segment is verified continuously.

    1. Poses become configurations: all solutions of the inverse kinematics within the limits. A start or goal that is
       beyond a limit by no more than 1e-5 rad or m, as measured ones are, is planned for from the limit; the way to it
       is added, and that is said.
    2. Ends that collide or lie outside the limits are named with what they meet.
    3. RRT-Connect in compiled code, or another planner of `PLANNERS`; edges are looked at when they grow and proved
       when they count. What is to be kept is kept by projection, and proved between the points of the path.
    4. Shortcuts, proved too.
    5. Where nothing was found and at most three coordinates move, boxes of configurations that are proved free or full
       decide, if they can: a path, or `SEPARATED`.

    Coordinates that are the same at start and goals stay, but for the rest of the limbs that change: where the goal
    moves some joints of the left arm of a robot, all of that arm may move on the way, but neither the right arm nor
    head, wheels and fingers. A limb is a run of joints from which nothing branches off. What carries it, such as a
    torso, may move as well where half of the budget found nothing without. Where all that changes moves the tip, what
    follows on the way to the tip may move too. `active_joints` names others in place of all this. Of a `MultiArmCell`
    all joints of the arms that are planned may move.
    The loops of a mechanism stay closed: its poses become configurations with closed loops by a search, and every path
    keeps `loop_constraints` as well.

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
        max_nodes: most that it may make.
        shortcut_iterations: about how many motions are tried to make the path shorter; 0 for none.
        clearance: distance to keep from obstacles [m]; that of a Checker, or none.
        self_clearance: clearance between bodies of the robot, some of which are always near [m]; `clearance` if None.
        constraints: path constraints, one or several, such as `planning.Upright(0.1)`; with "rrt_connect" alone, which
            knows loops too.
        radius: of capsules along the links, for a robot without shapes or in place of those of the library [m]; a
            Checker was made with its own.
        active_joints: names of joints that may move though start and goals agree on them, in place of the rule above;
            none for an empty list.
        degrees: the angles in start, and in a goal of configurations, are in degrees; the path holds radians.

    Ctrl-C ends planners that improve with the best so far, `interrupted`; others raise `KeyboardInterrupt`.

    Raises:
        InputError: a wrong shape, a number that is not finite, an unknown planner; a loop that is closed by a joint
            other than a hinge, a ball or a fixed one; `active_joints` names no joint.

    Reference: J. Kuffner, S. LaValle, RRT-Connect, ICRA 2000; proofs as in Schwarzer, Saha, Latombe, IEEE T-RO 2005.
    """
    roadmap = robot if isinstance(robot, roadmaps.ArmRoadmap) else None
    if isinstance(robot, roadmaps.ArmRoadmap):
        if constraints or any(given is not None for given in (scene, radius, clearance, self_clearance)):
            raise InputError("planning.roadmap_as_it_is")
        checker, planner = robot.checker, LAZY
    else:
        checker = _checker(robot, scene, clearance, self_clearance, radius)
    n, mechanism = checker.robot.n, checker.robot.mechanism
    loops = loop_constraints(mechanism) if mechanism.loops else ()
    start = in_radians(mechanism, "start", start) if degrees else start
    q = single("start", start, (n,)).copy()
    remark_on_degrees(checker.robot, "start", start)
    _require_effort(planner, seed, seconds, max_nodes, shortcut_iterations)
    may_move = None if active_joints is None else tuple(active_joints)
    if may_move is not None:
        rule_for(checker, may_move)
    begun = perf_counter()
    goals = configurations_of(checker, goal, q, degrees=degrees)
    on = checker.robot.limits.snap_to_limits(q), checker.robot.limits.snap_to_limits(goals)
    if (on[0] != q).any() or (on[1] != goals).any():
        measured = plan(
            robot, scene, on[0], on[1] if len(goals) else goal, planner=planner, seed=seed, seconds=seconds,
            max_nodes=max_nodes, shortcut_iterations=shortcut_iterations, clearance=clearance,
            self_clearance=self_clearance, constraints=constraints, radius=radius, active_joints=may_move,
        )  # fmt: skip
        return _from_measured(measured, checker, q, goals)
    asked = ArmQuestion(checker, q, goals, planner, seed, seconds, max_nodes, shortcut_iterations)
    kept = ((constraints,) if not isinstance(constraints, Iterable) else tuple(constraints)) + loops
    rules: tuple[Moving, ...] = (may_move,)
    if active_joints is None and checker.has_carriers and len(goals):
        wider = with_carriers(checker, np.concatenate([q[None], goals]))
        rules = (None,) if wider is None else (None, wider)
    found = _between(asked, roadmap, kept, rules, begun)
    return _reason(found, checker, goal, q) if found.status is PlanningStatus.UNREACHABLE else found


def _require_effort(planner: str, seed: int, seconds: float, nodes: int, shorten: int) -> None:
    """Refuse a planner that is none, and budgets that are none."""
    if not isinstance(cast(object, planner), str) or (planner not in PLANNERS and planner not in ARM_PLANNERS):
        raise InputError("input.choice", name="planner", value=planner, known=", ".join({**ARM_PLANNERS, **PLANNERS}))
    whole("seed", seed)
    whole("max_nodes", nodes, 1)
    whole("shortcut_iterations", shorten)
    positive("seconds", seconds)


def _between(
    asked: ArmQuestion, roadmap: ArmRoadmap | None, constraints: tuple[Constraint, ...], rules: tuple[Moving, ...],
    begun: float,
) -> ArmPlan:  # fmt: skip
    """Steps 2 to 5 of `plan`, between ends within the limits, one rule of what may move after the other."""
    checker, q, goals, planner, seed, seconds, nodes, shorten = asked[:8]
    half = seconds / len(rules), max(nodes // len(rules), 1)
    if planner == "rrt_connect" and not constraints and roadmap is None and len(goals):
        found = connect_ends(checker, q, goals, rules, seed, *half, shorten, begun)
        if found is not None:
            return found
    # 2.
    refused = _refuse(checker, q, goals, planner, begun)
    if isinstance(refused, ArmPlan):
        return refused
    if constraints and planner != "rrt_connect":
        loops = checker.robot.mechanism.loops
        raise InputError("planning.loops_planner" if loops else "planning.constraint_planner", planner=planner)
    # 3., 4.
    first, *others = rules
    if others and not constraints:
        # What the best paths need is what any path needs, and that is found soon.
        path, _, _ = search(checker, q, goals, seed, *half, 0, first)
        first, others = first if path is not None else others[0], []
        half = max(seconds - (perf_counter() - begun), 0.5 * seconds), nodes
    asked = asked._replace(goals=goals[refused], seconds=half[0], nodes=half[1])
    found = _search(asked, goals, roadmap, constraints, first, begun)
    if others and found.status is PlanningStatus.NOT_FOUND:
        found = _search(asked, goals, roadmap, constraints, others[0], begun)
    # 5.
    if constraints:
        return found
    return decide_by_boxes(found, q, goals, seed, shorten, nodes if planner == CELLS else MOST_BOXES, seconds)


def _from_measured(found: ArmPlan, checker: Checker, q: JointVector, goals: JointVector) -> ArmPlan:
    """The same between ends as they were measured, a little beyond limits: with the way to and from them.

    Args:
        found: between ends on the limits.
        checker: the arm.
        q: (n,) start.
        goals: (k, n).
    """
    goal = goals[found.goal] if found else q
    ends = (q, found.path[0]), (found.path[-1], goal)
    away = max(float(np.abs(a - b).max()) for a, b in ends)
    if not found or not away:
        return found
    rows = [
        *([q] if (q != found.path[0]).any() else []),
        *found.path,
        *([goal] if (goal != found.path[-1]).any() else []),
    ]
    blocked = PlanningStatus.START_BLOCKED, PlanningStatus.GOAL_BLOCKED
    for status, (a, b), end in zip(blocked, ends, (q, goal), strict=True):
        if not checker.free_segment(a, b):
            return replace(found, status=status, path=q[None], ends=(checker.check(end),))
    said = Reason(("planning.on_limit", {"far": away}))
    reason = found.reason.and_then(said) if isinstance(found.reason, Reason) else said
    return replace(found, path=np.stack(rows), reason=reason)


def _search(
    asked: ArmQuestion, goals: JointVector, roadmap: ArmRoadmap | None, constraints: tuple[Constraint, ...],
    moving: Moving, begun: float,
) -> ArmPlan:  # fmt: skip
    """Steps 3 and 4 of `plan` by any planner, where some coordinates may move."""
    checker, q = asked.checker, asked.start
    bounds = bounds_of(checker, np.concatenate([q[None], goals]), moving)
    asked = asked._replace(bounds=bounds, moving=moving)
    kept = Kept(*kept_of(checker, constraints, q, bounds)) if constraints else None
    if kept is not None:
        off = _not_kept(checker, kept, q, asked.goals, begun)
        if isinstance(off, ArmPlan):
            return off
        budget = asked.seed, asked.seconds, asked.nodes, asked.shorten
        path, made, seen = search_kept(checker, kept, q, asked.goals[off], *budget)
    elif roadmap is not None:
        path, made, seen = ask_roadmap(roadmap, asked)
    else:
        path, made, seen = ARM_PLANNERS.get(asked.planner, any_planner)(asked)
    return answer_of(checker, path, asked.planner, made, seen, q, goals, begun, kept, moving)


def _checker(
    robot: RobotLike | Checker, scene: Scene | Iterable[Obstacle] | None, clearance: float | None,
    self_clearance: float | None, radius: float | None,
) -> Checker:  # fmt: skip
    if not isinstance(robot, collision.Checker):
        around, kept = () if scene is None else scene, 0.0 if clearance is None else clearance
        return collision.Checker(robot, around, clearance=kept, self_clearance=self_clearance, radius=radius)
    if radius is not None:
        raise InputError("planning.radius_of_a_checker")
    checker = robot if scene is None else robot.with_scene(scene)
    return (
        checker
        if clearance is None and self_clearance is None
        else checker.with_clearance(clearance, own=self_clearance)
    )


def configurations_of(
    checker: Checker, goal: ArrayLike | Pose | GoalRegion, start: JointVector, *, degrees: bool = False
) -> JointVector:
    """(k, n) goals; of poses all solutions within the limits.

    Args:
        checker: the arm in its scene.
        goal: as of `plan`.
        start: (n,) [rad | m].
        degrees: configurations among the goals are in degrees.
    """
    n = len(start)
    if isinstance(goal, GoalRegion):
        return _solutions(checker, goal.poses(), start)
    typed = isinstance(goal, Pose)
    array = np.asarray(goal, dtype=np.float64) if typed else real_array("goal", goal)
    rows = in_radians(checker.robot.mechanism, "goal", array) if degrees and array.shape[-1:] == (n,) else array
    if array.shape == (n,) and n:
        remark_on_degrees(checker.robot, "goal", rows if degrees else goal)
        return require_finite("goal", rows).copy()[None]
    if not array.size:
        raise InputError("planning.no_goals")
    if not typed and array.ndim == 2 and array.shape[-1] == n and not _looks_like_pose(array, n):
        return np.array(as_batch("goal", rows, (n,), finite=True), ndmin=2)
    if array.ndim not in (2, 3) or array.shape[-2:] != (4, 4):
        raise InputError("planning.no_goal", n=n, got=array.shape)
    return _solutions(checker, checked_poses("goal", array).reshape(-1, 4, 4), start)


def _solutions(checker: Checker, poses: Floats, start: JointVector) -> JointVector:
    if checker.robot.mechanism.loops:
        return closed_configurations(checker.robot, poses, start)
    rows: list[JointVector] = [np.zeros((0, checker.robot.n))]
    for T in poses:
        found = ik.inverse_kinematics(checker.robot, T, q0=start)
        rows.append(np.asarray(found.q)[np.asarray(found.within, dtype=np.bool_)].reshape(-1, checker.robot.n))
    return np.concatenate(rows)


def _reason(refused: ArmPlan, checker: Checker, goal: ArrayLike | Pose | GoalRegion, q: JointVector) -> ArmPlan:
    """The same, for poses without a configuration with what inverse kinematics says of the first of them."""
    if checker.robot.mechanism.loops:
        return refused
    poses = goal.poses() if isinstance(goal, GoalRegion) else np.asarray(goal, dtype=np.float64).reshape(-1, 4, 4)
    found = ik.inverse_kinematics(checker.robot, poses[0], q0=q)
    return replace(refused, reason=Reason(FirstLine(found)))


def _looks_like_pose(array: Floats, n: int) -> bool:
    """Whether rows of four numbers are a pose: an arm with four joints wants a Pose to be sure."""
    return n != 4 and array.shape == (4, 4)


def _refuse(
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
        reason = Reason(Measured(kept, kept.measures(checker, end[None])[0]))
        return ArmPlan(status, q[None], "rrt_connect", 1, 0, 0, perf_counter() - begun, reason, checker)

    if not kept.holds(checker, q[None])[0]:
        return ended(PlanningStatus.START_OFF, q)
    found = kept.holds(checker, goals)
    return found if found.any() else ended(PlanningStatus.GOAL_OFF, goals[0])
