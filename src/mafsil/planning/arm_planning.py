"""Paths of an arm among obstacles: goals as configurations or poses, a compiled search, motions proved free."""

from __future__ import annotations

from collections.abc import Iterable
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, as_batch, positive, single, whole
from mafsil.collision import Checker, Obstacle, Scene
from mafsil.collision.joints import joints_of
from mafsil.errors import InputError
from mafsil.geometry import Pose
from mafsil.ik import inverse_kinematics
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.model.loading import RobotLike
from mafsil.planning.arm_plan import ArmPlan
from mafsil.planning.outcome import PlanningStatus
from mafsil.planning.problem import Problem
from mafsil.planning.search import PLANNERS, Budget
from mafsil.planning.shortening import shortened

if TYPE_CHECKING:
    import mafsil.planning.arm_search_loops as arm_search_loops
else:
    arm_search_loops = lazily("mafsil.planning.arm_search_loops")

STEP = 0.1
"""Longest edge of a tree, as share of the diagonal of the limits."""
FIRST_ROOM = 1024
"""Nodes of each side that there are arrays for at first."""
SLICE = 512
"""Samples between two looks at the clock."""
UNBOUNDED = np.pi
"""Where a joint without limits is searched, to both sides of start and goals [rad | m]."""


def plan(
    robot: RobotLike | Checker,
    scene: Scene | Iterable[Obstacle] | None,
    start: ArrayLike,
    goal: ArrayLike | Pose,
    *,
    planner: str = "rrt_connect",
    seed: int = 0,
    seconds: float = 10.0,
    nodes: int = 200_000,
    shorten: int = 100,
    margin: float = 0.0,
) -> ArmPlan:
    """A path of an arm from a configuration to a goal, each straight motion of it proved free of collisions.

    1. Poses become configurations: all solutions of the inverse kinematics within the limits.
    2. Ends that collide or lie outside the limits are named with what they meet.
    3. RRT-Connect in compiled code, or another planner of `PLANNERS`; edges are looked at when they grow and proved
       when they count.
    4. Shortcuts, proved too.

    Coordinates that do not move the tip and are the same at start and goals, such as those of a gripper, stay.

    Many questions about one arm: make a `collision.Checker` once and give it as `robot`.

    Args:
        robot: a Robot, a Mechanism, a library name, a path, or a Checker.
        scene: obstacles in {s}; None for that of a Checker, or none.
        start: (n,) [rad | m].
        goal: (n,); (k, n) of which any will do; a Pose, or (4, 4) or (k, 4, 4) poses of the tip in {s}.
        planner: a name of `mafsil.planning.PLANNERS`.
        seed: of the samples; equal seeds give equal paths where the time does not end the search.
        seconds: after which it gives up, or for planners that improve gives the best so far.
        nodes: most that it may make.
        shorten: how many shortcuts are tried; 0 for none.
        margin: clearance to keep, where `robot` is no Checker [m].

    Raises:
        InputError: a wrong shape, a number that is not finite, an unknown planner.

    Reference: J. Kuffner, S. LaValle, RRT-Connect, ICRA 2000; proofs as in Schwarzer, Saha, Latombe, IEEE T-RO 2005.
    """
    checker = _checker(robot, scene, margin)
    n = checker.robot.n
    q = np.asarray(single("start", start, (n,)), dtype=np.float64)
    if planner not in PLANNERS:
        raise InputError("input.choice", name="planner", value=planner, known=", ".join(PLANNERS))
    for name, number, least in (("seed", seed, 0), ("nodes", nodes, 1), ("shorten", shorten, 0)):
        whole(name, number, least=least)
    positive("seconds", seconds)
    begun = perf_counter()
    # 1.
    goals = _configurations(checker, goal, q)
    # 2.
    refused = _refused(checker, q, goals, planner, begun)
    if isinstance(refused, ArmPlan):
        return refused
    open_goals = goals[refused]
    lower, upper = _bounds(checker, np.concatenate([q[None], goals]))
    # 3., 4.
    search = _compiled if planner == "rrt_connect" else _general
    path, made, seen = search(checker, (lower, upper), q, open_goals, planner, seed, seconds, nodes, shorten)
    status = PlanningStatus.NOT_FOUND if path is None else PlanningStatus.FOUND
    points = q[None] if path is None else path
    reached = -1 if path is None else int(np.abs(goals - points[-1]).max(axis=1).argmin())
    return ArmPlan(
        status, points, planner, seen[2], seen[0], made, perf_counter() - begun, "", checker, (), seen[1], reached
    )


def _checker(robot: RobotLike | Checker, scene: Scene | Iterable[Obstacle] | None, margin: float) -> Checker:
    if not isinstance(robot, Checker):
        return Checker(robot, () if scene is None else scene, margin=margin)
    return robot if scene is None else robot.with_scene(scene)


def _configurations(checker: Checker, goal: ArrayLike | Pose, start: JointVector) -> JointVector:
    """(k, n) goals; of poses all solutions within the limits."""
    n = checker.robot.n
    typed = isinstance(goal, Pose)
    array = np.asarray(goal, dtype=np.float64)
    if not typed and array.ndim in (1, 2) and array.shape[-1] == n and not _looks_like_pose(array, n):
        return np.atleast_2d(np.asarray(as_batch("goal", array, (n,), finite=True), dtype=np.float64))
    if array.ndim not in (2, 3) or array.shape[-2:] != (4, 4):
        raise InputError("planning.no_goal", n=n, got=array.shape)
    rows: list[JointVector] = [np.zeros((0, n))]
    for T in array.reshape(-1, 4, 4):
        found = inverse_kinematics(checker.robot, T, q0=start)
        rows.append(np.asarray(found.q)[np.asarray(found.within, dtype=np.bool_)].reshape(-1, n))
    return np.concatenate(rows)


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

    beyond = _beyond_limits(checker, q)
    if beyond:
        return ended(PlanningStatus.START_OUTSIDE, beyond)
    if not checker.free(q):
        return ended(PlanningStatus.START_BLOCKED, ends=q[None])
    if not len(goals):
        return ended(PlanningStatus.UNREACHABLE)
    outside = [_beyond_limits(checker, row) for row in goals]
    within = np.array([not each for each in outside])
    if not within.any():
        return ended(PlanningStatus.GOAL_OUTSIDE, outside[0])
    found = within & checker.free(goals)
    if not found.any():
        return ended(PlanningStatus.GOAL_BLOCKED, ends=goals[within])
    return found


def _beyond_limits(checker: Checker, q: JointVector) -> str:
    """A sentence for the joint that is furthest beyond its limits; empty if none is."""
    limits = checker.robot.limits
    beyond = np.maximum(limits.lower - q, q - limits.upper)
    k = int(beyond.argmax())
    if not beyond[k] > 0.0:
        return ""
    joint = checker.robot.mechanism.coordinates[k].name
    lower, upper = float(limits.lower[k]), float(limits.upper[k])
    return say("planning.beyond_limit", joint=joint, value=float(q[k]), lower=lower, upper=upper)


def _bounds(checker: Checker, ends: JointVector) -> tuple[Floats, Floats]:
    """(n,) between which to search: the limits, or around the ends where there are none.

    Coordinates that do not move the tip and have one value at all ends, such as those of a gripper, keep it.
    """
    limits, mechanism = checker.robot.limits, checker.robot.mechanism
    lower = np.where(np.isfinite(limits.lower), limits.lower, ends.min(axis=0) - UNBOUNDED)
    upper = np.where(np.isfinite(limits.upper), limits.upper, ends.max(axis=0) + UNBOUNDED)
    joints = joints_of(mechanism)
    moving = set(joints.column[joints.moves[:, mechanism.link_names.index(mechanism.tip)]].tolist())
    for k in range(len(lower)):
        if k not in moving and np.ptp(ends[:, k]) == 0.0:
            lower[k] = upper[k] = ends[0, k]
    return lower, upper


def _compiled(
    checker: Checker, bounds: tuple[Floats, Floats], q: JointVector, goals: JointVector, planner: str, seed: int,
    seconds: float, nodes: int, shorten: int,
) -> tuple[JointVector | None, int, tuple[int, int, int]]:  # fmt: skip
    """RRT-Connect in slices: the clock and an interruption are looked at between them.

    1. A straight motion to a goal is the path where it is free.
    2. Both sides grow; arrays double where they are full. The clock starts after the first slice: a first call ever
       also waits for the compiler.
    3. Shortcuts.
    """
    world, (lower, upper) = checker.world(), bounds
    seen, random = np.zeros(3, np.int64), np.array([seed], np.uint64)
    order = np.argsort(np.linalg.norm(goals - q, axis=1), kind="stable")
    # 1.
    straight = arm_search_loops.first_free(world, q, goals[order], seen)
    if straight >= 0:
        return np.stack([q, goals[order[straight]]]), 2, _counted(seen)
    # 2.
    forests = _forests(q, goals, FIRST_ROOM, random, seen)
    step = STEP * float(np.linalg.norm(upper - lower))
    deadline, made = np.inf, 0
    while (
        code := arm_search_loops.grow(world, lower, upper, step, max(min(SLICE, nodes - made), 1), forests)
    ) != arm_search_loops.JOINED:
        made = int(forests.sizes[:2].sum())
        deadline = min(deadline, perf_counter() + seconds)
        if made >= nodes or perf_counter() > deadline:
            return None, made, _counted(seen)
        if code == arm_search_loops.FULL:
            forests = _doubled(forests)
    # 3.
    path = forests.path[: forests.sizes[2]].copy()
    path = arm_search_loops.shorten(world, path, shorten, random, seen)
    return path, int(forests.sizes[:2].sum()), _counted(seen)


def _counted(seen: Floats | np.ndarray[tuple[int, ...], np.dtype[np.int64]]) -> tuple[int, int, int]:
    looked_at, proved, states = (int(x) for x in seen)
    return looked_at, proved, states


def _forests(
    q: JointVector, goals: JointVector, most: int,
    random: np.ndarray[tuple[int, ...], np.dtype[np.uint64]], seen: np.ndarray[tuple[int, ...], np.dtype[np.int64]],
) -> arm_search_loops.Forests:  # fmt: skip
    """The roots, with room for as many nodes on each side."""
    n, most = len(q), max(most, 2 * len(goals) + 2)
    rows, parent = np.empty((2, most, n)), np.full((2, most), arm_search_loops.ROOT)
    rows[0, 0], rows[1, : len(goals)] = q, goals
    count = np.array([1, len(goals), 0])
    return arm_search_loops.Forests(
        rows, parent, np.zeros((2, most), np.bool_), count, random, seen, np.empty((2 * most, n))
    )


def _doubled(forests: arm_search_loops.Forests) -> arm_search_loops.Forests:
    q, parent, proved = (
        np.concatenate([array, np.zeros_like(array)], axis=1) for array in (forests.q, forests.parent, forests.proved)
    )
    return forests._replace(q=q, parent=parent, proved=proved, path=np.empty((2 * q.shape[1], q.shape[2])))


def _general(
    checker: Checker, bounds: tuple[Floats, Floats], q: JointVector, goals: JointVector, planner: str, seed: int,
    seconds: float, nodes: int, shorten: int,
) -> tuple[JointVector | None, int, tuple[int, int, int]]:  # fmt: skip
    """Any planner of `PLANNERS`; each segment is proved."""
    problem = Problem(*bounds, checker.free, checker.free_segment)
    rng = np.random.default_rng(seed)
    path, made = PLANNERS[planner](problem, q, goals, Budget(rng, perf_counter() + seconds, nodes))
    if path is not None and shorten:
        path = shortened(problem, path, rng, shorten)
    counts = problem.counts
    return path, made, (counts.segments, counts.segments, counts.configurations)
