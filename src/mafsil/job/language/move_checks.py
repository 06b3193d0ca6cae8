"""Whether each move of a job file asks for one thing, with options that fit it."""

from __future__ import annotations

import math
from typing import Any

from mafsil.job.description import JOINT_BOUNDS, QUICKEST, TIP_BOUNDS, TIP_PATHS
from mafsil.job.language.constraint_checks import check_constraints
from mafsil.job.language.frames import Complaint
from mafsil.job.language.pose_checks import check_pose
from mafsil.job.language.statements import Placed, PlacedGoal, Statement
from mafsil.job.lines import Path
from mafsil.job.part import keys_of

ACTIONS = ("joints", "pose", "through", "pick", "place", "tool", "pause", "set", "wait", "do", "if")
TIP_TOLERANCES = ("position", "orientation")
JUDGED: dict[str, tuple[str, ...]] = {
    "joints": ("joints",),
    "pause": (),
    "tool": (),
    "set": (),
    "wait": (),
}
"""By what the end of a move is judged, where not by the tip."""
FIELDS = keys_of(Statement)
_ALL = ("name", "tolerance")
_TRAVEL = (*_ALL, "path", "via", "profile", "duration", "speed", "avoid", "planner", "clearance", "constraints")
_TRAVEL += (*JOINT_BOUNDS, "outputs", "process_wrench", "process_known", "until", "until_force")
EFFECTIVE = {
    "joints": _TRAVEL,
    "pose": (*_TRAVEL, "blend", *TIP_BOUNDS),
    "through": (*_TRAVEL, "blend", *TIP_BOUNDS),
    "pick": (*_ALL, "hold"),
    "place": (*_ALL, "hold"),
    "tool": (*_ALL, "hold"),
    "pause": _ALL,
    "set": _ALL,
    "wait": (*_ALL, "timeout"),
    "do": ("each", "repeat", "while"),
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


def check_statements(moves: tuple[Statement, ...], path: Path, data: list[dict[str, Any]], error: Complaint) -> None:
    """Refuse moves that ask for nothing, for several things, or have keys without effect.

    Args:
        moves: one after the other.
        path: where they stand in the file.
        data: what was typed.
        error: makes the complaint about a key.
    """
    for k, move in enumerate(moves):
        _check_statement(move, (*path, k), data[k], error)


def _check_statement(move: Statement, path: Path, data: dict[str, Any], error: Complaint) -> None:
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
    if "process_known" in data and move.process_wrench is None:
        raise error("job.no_effect", (*path, "process_known"), action=given[0], known="process_wrench")
    if move.until_force is not None and (move.until or move.blend > 0.0):
        raise error("job.search_alone", (*path, "until_force"))
    for k, output in enumerate(move.outputs):
        if not output.set or [output.share, output.distance, output.after].count(None) != 2:
            raise error("job.path_output", (*path, "outputs", k))
    if move.tolerance is not None:
        judged = JUDGED.get(given[0], TIP_TOLERANCES)
        for name in move.tolerance.__struct_fields__:
            if getattr(move.tolerance, name) is not None and name not in judged:
                raise error("job.no_tolerance", (*path, "tolerance", name), action=given[0])


def _check_loop(move: Statement, path: Path, data: dict[str, Any], error: Complaint) -> None:
    """A loop is over something, and each of its moves is right."""
    assert move.do is not None
    if (move.each is None and move.repeat is None) or not move.do:
        raise error("job.loop_endless" if move.while_ and move.do else "job.loop_empty", path)
    if "while" in data and not move.while_:
        raise error("job.test_empty", (*path, "while"))
    check_statements(move.do, (*path, "do"), data["do"], error)


def _check_choice(move: Statement, path: Path, data: dict[str, Any], error: Complaint) -> None:
    """A choice has moves for where its tests hold, and perhaps for where they do not."""
    if not move.then or move.else_ == ():
        raise error("job.choice_empty", path)
    for key, moves in (("then", move.then), ("else", move.else_ or ())):
        check_statements(moves, (*path, key), data.get(key, []), error)


def _check_path(move: Statement, path: Path, data: dict[str, Any], error: Complaint) -> None:
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
