"""Whether each move of a job file asks for one thing, with options that fit it and the moves after it."""

from __future__ import annotations

import math
from typing import Any

from mafsil.job.language.description import JOINT_BOUNDS, QUICKEST, TIP_BOUNDS, TIP_PATHS, Job, Move, Pose
from mafsil.job.language.frames import Complaint
from mafsil.job.language.part import keys_of
from mafsil.job.language.statements import Placed, PlacedGoal, Statement
from mafsil.job.language.surrounding_tables import (
    CONSTRAINED_PLANNER,
    DIRECTIONS,
    KINDS,
    PathConstraints,
    PlacedConstraints,
)
from mafsil.job.language.text import Keys
from mafsil.job.language.units import angle_unit
from mafsil.job.tolerances import NO_DIRECTION, SAME_POINT
from mafsil.messages.visible import visible

ORIENTATIONS = ("rpy", "quaternion", "look_at")
SHORTEST_DIRECTION = 1e-6
"""Length of a vector that is taken as a direction."""
OF: dict[str, tuple[str, ...]] = {"tolerance": DIRECTIONS, "frame": DIRECTIONS, "angle": ("orientation",)}
"""Keys that say something of others."""
ACTIONS = ("joints", "pose", "through", "pick", "place", "tool", "pause", "set", "wait", "do", "call", "if")
TIP_TOLERANCES = ("position", "orientation")
JUDGED: dict[str, tuple[str, ...]] = {"joints": ("joints",), "pause": (), "tool": (), "set": (), "wait": ()}
"""By what the end of a move is judged, where not by the tip."""
FIELDS = keys_of(Statement)
_ALL = ("name", "tolerance")
_TRAVEL = (*_ALL, "path", "via", "profile", "duration", "speed", "avoid", "planner", "clearance", "constraints")
_TRAVEL += (*JOINT_BOUNDS, "outputs", "process_wrench", "process_known", "until", "until_force")
EFFECTIVE = {
    "joints": (*_TRAVEL, "blend"),
    "pose": (*_TRAVEL, "blend", *TIP_BOUNDS),
    "through": (*_TRAVEL, "blend", *TIP_BOUNDS),
    "pick": (*_ALL, "hold"),
    "place": (*_ALL, "hold"),
    "tool": (*_ALL, "hold"),
    "pause": _ALL,
    "set": _ALL,
    "wait": (*_ALL, "timeout"),
    "do": ("each", "repeat", "while"),
    "call": ("each", "repeat", "while"),
    "if": ("name", "then", "else"),
}
"""Keys that do something next to each action; a tolerance has a sentence of its own."""
POINTS_ON_THE_WAY: dict[str, tuple[float, float]] = {
    "joint": (0, math.inf),
    "line": (0, 0),
    "screw": (0, 0),
    "arc": (1, 1),
    "spline": (1, math.inf),
}
"""How many `via` each path has."""


def check_statements(moves: tuple[Statement, ...], path: Keys, data: list[dict[str, Any]], error: Complaint) -> None:
    """Refuse moves that ask for nothing, for several things, or have keys without effect.

    Args:
        moves: one after the other.
        path: where they stand in the file.
        data: what was typed.
        error: makes the complaint about a key.
    """
    for k, move in enumerate(moves):
        _check_statement(move, (*path, k), data[k], error)


def _check_statement(move: Statement, path: Keys, data: dict[str, Any], error: Complaint) -> None:
    """A move asks for exactly one thing, and its options fit it."""
    given = [name for name in ACTIONS if getattr(move, FIELDS[name]) not in (None, False, {})]
    if len(given) != 1:
        key = "job.move_empty" if not given else "job.move_many"
        raise error(key, path, given=", ".join(given), known=", ".join(ACTIONS))
    effective = EFFECTIVE[given[0]]
    for name in data:
        if name not in (*effective, *ACTIONS):
            known = ", ".join(effective)
            raise error("job.no_effect", (*path, name), action=given[0], known=known)
    if move.call is not None and move.while_ and move.each is None and move.repeat is None:
        raise error("job.loop_endless", path)
    if move.do is not None:
        _check_loop(move, path, data, error)
    elif move.if_:
        _check_choice(move, path, data, error)
    else:
        _check_path(move, path, data, error)
    if isinstance(move.pose, PlacedGoal):
        check_pose(move.pose, (*path, "pose"), data["pose"], error)
    if move.constraints is not None:
        check_constraints(move.constraints, (*path, "constraints"), data["constraints"], error)
    _check_options(move, given[0], path, data, error)


def _check_options(move: Statement, action: str, path: Keys, data: dict[str, Any], error: Complaint) -> None:
    """Options that need others, or a value of their own."""
    if "process_known" in data and move.process_wrench is None:
        raise error("job.no_effect", (*path, "process_known"), action=action, known="process_wrench")
    jerk = next((name for name in ("joint_jerk", "tip_jerk") if getattr(move, name) is not None), None)
    curved = move.tip_jerk is not None and (move.path != "line" or move.blend > 0.0)
    if jerk is not None and (curved or move.profile not in (None, *QUICKEST)):
        raise error("job.jerk_where", (*path, jerk))
    if move.until_force is not None and (move.until or move.blend > 0.0):
        raise error("job.search_alone", (*path, "until_force"))
    for k, output in enumerate(move.outputs):
        if not output.set or [output.share, output.distance, output.after].count(None) != 2:
            raise error("job.path_output", (*path, "outputs", k))
    if move.tolerance is not None:
        judged = JUDGED.get(action, TIP_TOLERANCES)
        for name in move.tolerance.__struct_fields__:
            if getattr(move.tolerance, name) is not None and name not in judged:
                raise error("job.no_tolerance", (*path, "tolerance", name), action=action)


def _check_loop(move: Statement, path: Keys, data: dict[str, Any], error: Complaint) -> None:
    """A loop is over something, and each of its moves is right."""
    assert move.do is not None
    if (move.each is None and move.repeat is None) or not move.do:
        raise error("job.loop_endless" if move.while_ and move.do else "job.loop_empty", path)
    if "while" in data and not move.while_:
        raise error("job.test_empty", (*path, "while"))
    check_statements(move.do, (*path, "do"), data["do"], error)


def _check_choice(move: Statement, path: Keys, data: dict[str, Any], error: Complaint) -> None:
    """A choice has moves for where its tests hold, and perhaps for where they do not."""
    if not move.then or move.else_ == ():
        raise error("job.choice_empty", path)
    for key, moves in (("then", move.then), ("else", move.else_ or ())):
        check_statements(moves, (*path, key), data.get(key, []), error)


def _check_path(move: Statement, path: Keys, data: dict[str, Any], error: Complaint) -> None:
    """The points on the way, the profile and the goal fit the path."""
    if move.through is not None:
        if move.path != "spline" or move.via:
            raise error("job.through", (*path, "through"))
        return
    of_tip = move.path in TIP_PATHS
    for name in TIP_BOUNDS:
        if name in data and not of_tip:
            raise error("job.tip_bound", (*path, name), known=", ".join(TIP_PATHS))
    if of_tip and move.pose is None:
        raise error("job.line_pose", (*path, "path"), kind=move.path)
    passing = () if move.path == "arc" else QUICKEST
    if passing and move.via and move.profile not in (None, *passing):
        raise error("job.via_profile", (*path, "profile"), known=", ".join(passing))
    _check_points(move, path, data, error, of_tip=of_tip)


def _check_points(move: Statement, path: Keys, data: dict[str, Any], error: Complaint, *, of_tip: bool) -> None:
    """As many points on the way as the path has, poses or joints as it wants them."""
    least, most = POINTS_ON_THE_WAY[move.path]
    if not least <= len(move.via) <= most:
        key = "job.line_via" if most == 0 else "job.arc_via" if most == 1 else "job.spline_via"
        raise error(key, (*path, "via"), kind=move.path, got=len(move.via))
    for i, via in enumerate(move.via):
        if not isinstance(via, str) and isinstance(via, Placed) != of_tip:
            key = "job.via_pose" if of_tip else "job.via_joints"
            raise error(key, (*path, "via", i), kind=move.path)
        if isinstance(via, Placed):
            check_pose(via, (*path, "via", i), data["via"][i], error)


def check_constraints(constraints: PlacedConstraints, path: Keys, data: dict[str, Any], error: Complaint) -> None:
    """Refuse a table that keeps nothing, directions without a length, and keys without effect."""
    given = [name for name in KINDS if getattr(constraints, name) not in (None, False)]
    if not given:
        raise error("job.constraint_empty", path, known=", ".join(KINDS))
    for name in DIRECTIONS:
        if name in given and math.hypot(*getattr(constraints, name)) < SHORTEST_DIRECTION:
            raise error("job.no_normal", (*path, name), given=name)
    for name, owners in OF.items():
        if name in data and not set(owners) & set(given):
            raise error("job.constraint_key", (*path, name), known=", ".join(owners))


def require_keepable(job: Job, error: Complaint) -> None:
    """Refuse moves that cannot keep anything, and angles that keep nothing.

    Args:
        job: its moves, one after the other.
        error: makes the complaint about a key of a move of the job.

    Raises:
        JobError: a path of the tip, points on the way, a law of time, another planner, an angle of half a turn or more.
    """
    for k, move in enumerate(job.move):
        if move.constraints is not None:
            _check_move(move, ("move", k), error)
            _check_angles(move.constraints, ("move", k, "constraints"), angle_unit(job), error)


def _check_move(move: Move, path: Keys, error: Complaint) -> None:
    """Only a way that is planned keeps something."""
    if move.path in TIP_PATHS:
        raise error("job.constraint_path", (*path, "constraints"), kind=move.path)
    if move.via:
        raise error("job.constraint_via", (*path, "via"))
    if move.profile not in (None, *QUICKEST):
        raise error("job.constraint_profile", (*path, "profile"), known=", ".join(QUICKEST))
    if move.planner not in (None, CONSTRAINED_PLANNER):
        raise error("job.constraint_planner", (*path, "planner"), planner=CONSTRAINED_PLANNER)
    if move.avoid is False:
        raise error("job.constraint_avoid", (*path, "avoid"))


def _check_angles(constraints: PathConstraints, path: Keys, unit: float, error: Complaint) -> None:
    """Angles below half a turn."""
    for name in ("upright", "angle"):
        angle = getattr(constraints, name)
        if angle is not None and unit * angle >= math.pi:
            raise error("job.constraint_angle", (*path, name), value=f"{angle:g}", limit=f"{math.pi / unit:.4g}")


def check_pose(pose: Pose | Placed, path: Keys, data: dict[str, Any], error: Complaint) -> None:
    """A place, at most one way to say the orientation; a quaternion that can be normalised."""
    given = [name for name in ORIENTATIONS if getattr(pose, name, None) is not None]
    if len(given) > 1:
        raise error("job.two_orientations", path, given=", ".join(given))
    if "position" not in data and not ("frame" in data or "relative" in data or path[0] in ("frame", "pattern")):
        raise error("job.missing_key", (*path, "position"))
    if isinstance(pose, PlacedGoal) and pose.task == "position":
        for name in given:
            raise error("job.free_orientation", (*path, name))
    if "look_at" in given and (
        getattr(pose, "relative", None) is not None or math.dist(pose.position, data["look_at"]) < SAME_POINT
    ):
        raise error("job.look_at", (*path, "look_at"))
    if pose.quaternion is not None and math.hypot(*pose.quaternion) < NO_DIRECTION:
        raise error("job.zero_quaternion", (*path, "quaternion"))


def require_order(job: Job, error: Complaint) -> None:
    """Refuse moves that do not fit those after them.

    Args:
        job: its moves, one after the other.
        error: makes the complaint about a key of a move of the job.

    Raises:
        JobError: a corner that cannot be rounded, a branch on a path of the tip, a way round where there is none.
    """
    for k in range(len(job.move)):
        _check_blend(job.move, k, error)
        goal = job.move[k].pose
        if goal is not None and goal.branch is not None and job.move[k].path in TIP_PATHS:
            raise error("job.branch_path", ("move", k, "pose", "branch"), kind=job.move[k].path)
    _check_avoiding(job, error)


def _check_blend(moves: tuple[Move, ...], k: int, error: Complaint) -> None:
    """A corner is rounded between two paths of the tip whose time is not ruled otherwise."""
    move = moves[k]
    if not move.blend:
        return
    then = moves[k + 1] if k + 1 < len(moves) and not move.skip else None
    both = [one for one in (move, then) if one is not None and (one.pose is not None or one.joints is not None)]
    if len(both) < 2 or then is None:
        raise error("job.blend_next", ("move", k, "blend"))
    mixed = any(one.path not in TIP_PATHS for one in both)
    if mixed and any(one.via or one.constraints or one.avoid or one.path not in ("joint", "line") for one in both):
        raise error("job.blend_mixed", ("move", k, "blend"))
    for index, one in ((k, move), (k + 1, then)):
        _check_time_of_corner(one, index, error)
    if not mixed and move.pose is not None and then.pose is not None and move.pose.task != then.pose.task:
        raise error("job.blend_task", ("move", k + 1, "pose", "task"), task=move.pose.task)


def _check_time_of_corner(move: Move, k: int, error: Complaint) -> None:
    """Nothing else rules the time of a move at a rounded corner."""
    if move.profile not in (None, *QUICKEST):
        raise error("job.blend_profile", ("move", k, "profile"))
    if move.duration is not None:
        raise error("job.blend_duration", ("move", k, "duration"))
    if move.tip_jerk is not None:
        raise error("job.jerk_where", ("move", k, "tip_jerk"))


def _check_avoiding(job: Job, error: Complaint) -> None:
    """Only moves of the joints without points on the way go round, and only they have a planner."""
    usual = job.collision is not None and job.collision.avoid
    for k, move in enumerate(job.move):
        goes_round = (usual if move.avoid is None else move.avoid) and move.path == "joint" and not move.via
        goes_round = goes_round or move.constraints is not None
        if move.planner is not None and not goes_round:
            raise error("job.planner_avoid", ("move", k, "planner"))
        if not move.avoid:
            continue
        if move.path in TIP_PATHS:
            raise error("job.avoid_path", ("move", k, "avoid"), kind=move.path)
        if move.via:
            raise error("job.avoid_via", ("move", k, "via"))
        if move.profile not in (None, *QUICKEST):
            raise error("job.avoid_profile", ("move", k, "profile"), known=", ".join(QUICKEST))


def require_grips(job: Job, error: Complaint) -> None:
    """The moves with which doors are taken and let go exist, in this order.

    Args:
        job: all moves, in the order of the file.
        error: how a complaint is made.

    Raises:
        JobError: no such move, or the door is let go before it is taken.
    """
    names = [move.name for move in job.move]
    for k, door in enumerate(job.door):
        for key in ("grip", "release"):
            name = getattr(door, key)
            if name and name not in names:
                raise error("job.door_move", ("door", k, key), given=visible(name))
        begun = names.index(door.grip) if door.grip else 0
        if door.release and door.release not in names[begun:]:
            raise error("job.door_order", ("door", k, "release"))
