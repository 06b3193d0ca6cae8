"""Job files in, checked jobs out; every complaint names the key, the line and the remedy."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any, cast

import msgspec

from mafsil.errors import JobError
from mafsil.job import lines
from mafsil.job.description import (
    QUICKEST,
    TIP_PATHS,
    Cell,
    Controller,
    Job,
    Move,
    Obstacle,
    Part,
    Pose,
    SceneFile,
    Simulation,
)
from mafsil.job.language import JobFile, in_metres, require_signals, resolved, substituted, with_cells
from mafsil.job.language.statements import Placed, PlacedGoal, Statement
from mafsil.job.language.types_of_keys import choices_at, field_type, path_of, tables_in, value_at
from mafsil.job.other_robot import OtherRobot
from mafsil.job.text import tables_of, text_of
from mafsil.job.variation_table import SPREADS, Normal, Spread
from mafsil.messages import say
from mafsil.messages.visible import visible

LARGEST_NUMBER = 1e9
"""Of any quantity of a job: larger than that is a slip of the unit or the exponent."""
ACTIONS = ("joints", "pose", "pick", "place", "tool", "pause", "set", "wait", "do")
KINDS_OF_OBSTACLE = ("box", "sphere", "cylinder", "capsule", "floor")
FORMS = {"surface": ("normal", "sphere", "cylinder"), "guide": ("direction", "normal")}
"""Keys of what is touched of which exactly one is given."""
DIRECTIONS = {"surface": ("normal", "axis"), "hole": ("axis",), "door": ("axis",), "guide": ("direction", "normal")}
TIP_TOLERANCES = ("position", "orientation")
JUDGED: dict[str, tuple[str, ...]] = {
    "joints": ("joints",),
    "pause": (),
    "tool": (),
    "set": (),
    "wait": (),
}
"""By what the end of a move is judged, where not by the tip."""
GAINS = {
    "computed_torque": ("frequency", "damping"),
    "pd_gravity": ("stiffness", "rate_gain"),
    "pid": ("stiffness", "rate_gain", "integral"),
    "feedforward": ("stiffness", "rate_gain"),
    "sliding_mode": ("mass_share", "margin", "width"),
    "min_max": ("mass_share", "width"),
    "model_predictive": ("frequency", "horizon", "interval"),
    "linear_quadratic": ("frequency",),
    "adaptive": ("learning",),
    "task_computed_torque": ("frequency", "damping"),
    "impedance": ("tip_stiffness", "turn_stiffness", "damping"),
    "admittance": ("tip_mass", "turn_inertia", "tip_stiffness", "turn_stiffness", "damping"),
    "hybrid": ("frequency", "damping", "press", "force_gain", "force_integral"),
}
"""Gains of each law; those of another one have no effect and are refused."""
_ALL = ("name", "tolerance")
_TRAVEL = (*_ALL, "path", "via", "profile", "duration", "speed", "avoid", "planner", "clearance")
EFFECTIVE = {
    "joints": _TRAVEL,
    "pose": (*_TRAVEL, "blend"),
    "pick": (*_ALL, "hold"),
    "place": (*_ALL, "hold"),
    "tool": (*_ALL, "hold"),
    "pause": _ALL,
    "set": _ALL,
    "wait": (*_ALL, "timeout"),
    "do": ("each", "repeat"),
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
TYPES = {
    "float": "number",
    "int": "whole",
    "str": "text",
    "bool": "truth",
    "array": "list",
    "object": "table",
    "null": "nothing",
}
"""Types of the parser -> how people call them."""
SHORTEST_NORMAL = 1e-6
"""Length of a vector that is taken as a direction."""
WHOLE = 1e-6
"""How far the period of the law, in steps, may be from a whole number."""
_MOST_CLOSE = 3


def read(path: Path) -> Job:
    """The job in a file.

    Args:
        path: a TOML file.

    Raises:
        FileError: it cannot be read, or is no TOML.
        JobError: a key is unknown, missing, of the wrong type or out of range.
    """
    return parse(text_of(path), source=path.name, folder=path.parent)


def parse(
    text: str, source: str = "<text>", variables: Mapping[str, object] | None = None, *, folder: Path | None = None
) -> Job:
    """The job in a text.

    Args:
        text: TOML.
        source: name of the file, for errors.
        variables: values by name, instead of those of the file.
        folder: to which paths of included files are relative; the present one if None.

    Raises:
        FileError: it is no TOML, or includes a file that cannot be read.
        JobError: a key is unknown, missing, of the wrong type or out of range; a variable is unknown.
    """
    data = tables_of(text, source)
    data, cells = with_cells(data, folder or Path(), lines.Places(text, visible(source)).error)
    reader = _Reader(text, visible(source), cells)
    data = substituted(data, variables or {}, reader.error)
    file = reader.file(data)
    job = msgspec.structs.replace(resolved(in_metres(file, data), reader.error), cells=cells)
    if not job.move:
        raise reader.error("job.no_moves", ("move",))
    reader.check_moves(job)
    return job


def parse_scene(text: str, source: str = "<text>") -> SceneFile:
    """Obstacles from a text: `[[obstacle]]` tables as in job files; arguments and errors as `parse`."""
    data = tables_of(text, source)
    reader = _Reader(text, visible(source))
    reader.refuse_unknown(data, SceneFile, ())
    reader.require(data, SceneFile, ())
    try:
        found = msgspec.convert(data, SceneFile, strict=True)
    except msgspec.ValidationError as error:
        raise reader.translated(error, data) from None
    reader.refuse_not_finite(data, ())
    reader.check_obstacles(found.obstacle, data["obstacle"])
    return found


@dataclass(frozen=True, slots=True)
class _Types:
    """What a value may be, in the reader's language."""

    names: tuple[str, ...]

    def explain(self, *, language: str | None = None) -> str:
        """`a number or a list`."""
        words = [say(f"job.type_{name}", language=language) for name in self.names if name != "nothing"]
        return say("job.type_or", language=language).join(words)


class _Reader:
    """Knows the text, so that each error can say the line."""

    def __init__(self, text: str, source: str, cells: tuple[Cell, ...] = ()) -> None:
        self.places = lines.Places(text, source, cells=cells)

    def error(self, key: str, path: lines.Path, **details: object) -> JobError:
        """The complaint about a key, with its place."""
        return self.places.error(key, path, **details)

    def file(self, data: dict[str, Any]) -> JobFile:
        """The checked statements of a file."""
        self.refuse_unknown(data, JobFile, ())
        self.require(data, JobFile, ())
        try:
            file = msgspec.convert(data, JobFile, strict=True)
        except msgspec.ValidationError as error:
            raise self.translated(error, data) from None
        self.refuse_not_finite(data, ())
        for name in ("frame", "pose", "pattern"):
            for each, placed in getattr(file, name).items():
                self.check_pose(placed, (name, each), data[name][each])
        for k, statement in enumerate(file.move):
            self.check_statement(statement, ("move", k), data["move"][k])
        self.check_obstacles(file.obstacle, data.get("obstacle", ()))
        self.check_start(file, data.get("start", {}))
        self.check_controller(file.controller, file.simulation)
        self.check_variation(file)
        self.check_contacts(file)
        self.check_other_robots(file.other_robot)
        require_signals(file, self.error)
        return file

    def check_moves(self, job: Job) -> None:
        """Moves fit those before and after them."""
        self.places = self.places.of(job)
        for k in range(len(job.move)):
            self.check_blend(job.move, k)
            goal = job.move[k].pose
            if goal is not None and goal.branch is not None and job.move[k].path in TIP_PATHS:
                raise self.error("job.branch_path", ("move", k, "pose", "branch"), kind=job.move[k].path)
        self.check_avoiding(job)

    def refuse_unknown(self, data: Any, kind: type[Part], path: lines.Path) -> None:
        """Every key of every table is one that we know; close matches are offered."""
        known = kind.__struct_fields__
        for name, value in data.items():
            here = (*path, name)
            if name not in known:
                close = get_close_matches(str(name), known, n=_MOST_CLOSE, cutoff=0.55)
                key = "job.unknown_key_close" if close else "job.unknown_key"
                raise self.error(key, here, close=", ".join(close), known=", ".join(known))
            for inner, place, part in tables_in(value, field_type(kind, name), here):
                self.refuse_unknown(inner, part, place)

    def require(self, data: Any, kind: type[Part], path: lines.Path) -> None:
        """Every key without a default is there."""
        for field in msgspec.structs.fields(kind):
            if field.required and field.name not in data:
                raise self.error("job.missing_key", (*path, field.name))
            if field.name in data:
                for inner, place, part in tables_in(data[field.name], field.type, (*path, field.name)):
                    self.require(inner, part, place)

    def check_statement(self, move: Statement, path: lines.Path, data: dict[str, Any]) -> None:
        """A move asks for exactly one thing, and its options fit it."""
        given = [name for name in ACTIONS if getattr(move, name) not in (None, False, {})]
        if len(given) != 1:
            key = "job.move_empty" if not given else "job.move_many"
            raise self.error(key, path, given=", ".join(given), known=", ".join(ACTIONS))
        effective = EFFECTIVE[given[0]]
        for name in data:
            if name not in (*effective, *ACTIONS):
                known = ", ".join(effective)
                raise self.error("job.no_effect", (*path, name), action=given[0], known=known)
        if move.do is not None:
            self.check_loop(move, path, data)
            return
        self.check_path(move, path, data)
        if isinstance(move.pose, PlacedGoal):
            self.check_pose(move.pose, (*path, "pose"), data["pose"])
        if move.tolerance is not None:
            judged = JUDGED.get(given[0], TIP_TOLERANCES)
            for name in move.tolerance.__struct_fields__:
                if getattr(move.tolerance, name) is not None and name not in judged:
                    raise self.error("job.no_tolerance", (*path, "tolerance", name), action=given[0])

    def check_loop(self, move: Statement, path: lines.Path, data: dict[str, Any]) -> None:
        """A loop is over something, and each of its moves is right."""
        assert move.do is not None
        if (move.each is None and move.repeat is None) or not move.do:
            raise self.error("job.loop_empty", path)
        for k, inner in enumerate(move.do):
            self.check_statement(inner, (*path, "do", k), data["do"][k])

    def check_path(self, move: Statement, path: lines.Path, data: dict[str, Any]) -> None:
        """The points on the way, the profile and the goal fit the path."""
        of_tip = move.path in TIP_PATHS
        if of_tip and move.pose is None:
            raise self.error("job.line_pose", (*path, "path"), kind=move.path)
        passing = () if move.path == "arc" else QUICKEST
        if passing and move.via and move.profile not in (None, *passing):
            raise self.error("job.via_profile", (*path, "profile"), known=", ".join(passing))
        least, most = POINTS_ON_THE_WAY[move.path]
        if not least <= len(move.via) <= most:
            key = "job.line_via" if most == 0 else "job.arc_via" if most == 1 else "job.spline_via"
            raise self.error(key, (*path, "via"), kind=move.path, got=len(move.via))
        for i, via in enumerate(move.via):
            if not isinstance(via, str) and isinstance(via, Placed) != of_tip:
                key = "job.via_pose" if of_tip else "job.via_joints"
                raise self.error(key, (*path, "via", i), kind=move.path)
            if isinstance(via, Placed):
                self.check_pose(via, (*path, "via", i), data["via"][i])

    def check_blend(self, moves: tuple[Move, ...], k: int) -> None:
        """A corner is rounded between two paths of the tip whose time is not ruled otherwise."""
        move = moves[k]
        if not move.blend:
            return
        then = moves[k + 1] if k + 1 < len(moves) else None
        if move.path not in TIP_PATHS or then is None or then.path not in TIP_PATHS or then.pose is None:
            raise self.error("job.blend_next", ("move", k, "blend"), known=", ".join(TIP_PATHS))
        for index, one in ((k, move), (k + 1, then)):
            if one.profile not in (None, *QUICKEST):
                raise self.error("job.blend_profile", ("move", index, "profile"))
            if one.duration is not None:
                raise self.error("job.blend_duration", ("move", index, "duration"))
        assert move.pose is not None
        if move.pose.task != then.pose.task:
            raise self.error("job.blend_task", ("move", k + 1, "pose", "task"), task=move.pose.task)

    def check_other_robots(self, robots: tuple[OtherRobot, ...]) -> None:
        """One way to say how a base is turned; each step of another robot is exactly one thing."""
        for k, robot in enumerate(robots):
            if robot.rpy is not None and robot.quaternion is not None:
                raise self.error("job.two_orientations", ("other_robot", k))
            if robot.quaternion is not None and math.hypot(*robot.quaternion) < 1e-6:
                raise self.error("job.zero_quaternion", ("other_robot", k, "quaternion"))
            for i, move in enumerate(robot.move):
                if sum(each is not None for each in (move.joints, move.pose, move.pause)) != 1:
                    raise self.error("job.other_move", ("other_robot", k, "move", i))
                if move.pose is not None:
                    self.check_pose(move.pose, ("other_robot", k, "move", i, "pose"), {"position": ()})

    def check_obstacles(self, obstacles: tuple[Obstacle, ...], data: Sequence[dict[str, Any]]) -> None:
        """Each obstacle is exactly one thing."""
        for k, obstacle in enumerate(obstacles):
            given = [name for name in KINDS_OF_OBSTACLE if getattr(obstacle, name) not in (None, False)]
            if len(given) != 1:
                known = ", ".join(KINDS_OF_OBSTACLE)
                raise self.error("job.obstacle_kind", ("obstacle", k), given=", ".join(given) or "-", known=known)
            self.check_pose(obstacle, ("obstacle", k), data[k])

    def check_avoiding(self, job: Job) -> None:
        """Only moves of the joints without points on the way go round, and only they have a planner."""
        usual = job.collision is not None and job.collision.avoid
        for k, move in enumerate(job.move):
            goes_round = (usual if move.avoid is None else move.avoid) and move.path == "joint" and not move.via
            if move.planner is not None and not goes_round:
                raise self.error("job.planner_avoid", ("move", k, "planner"))
            if not move.avoid:
                continue
            if move.path in TIP_PATHS:
                raise self.error("job.avoid_path", ("move", k, "avoid"), kind=move.path)
            if move.via:
                raise self.error("job.avoid_via", ("move", k, "via"))
            if move.profile not in (None, *QUICKEST):
                raise self.error("job.avoid_profile", ("move", k, "profile"), known=", ".join(QUICKEST))

    def check_start(self, file: JobFile, data: dict[str, Any]) -> None:
        """One way to say where the robot begins."""
        if file.start.joints is not None and file.start.pose is not None:
            raise self.error("job.two_starts", ("start", "pose"))
        if isinstance(file.start.pose, PlacedGoal):
            self.check_pose(file.start.pose, ("start", "pose"), data["pose"])
        for path, tool in ((("tool",), file.tool), *((("tools", name), tool) for name, tool in file.tools.items())):
            if tool.offset is not None:
                self.check_pose(tool.offset, (*path, "offset"), {"position": ()})

    def check_contacts(self, file: JobFile) -> None:
        """What is touched has one form, directions a length; a door is held where the tip starts."""
        for kind, choices in FORMS.items():
            for k, one in enumerate(getattr(file, kind)):
                given = [name for name in choices if getattr(one, name) is not None]
                if len(given) != 1:
                    known = ", ".join(choices)
                    raise self.error("job.contact_form", (kind, k), given=", ".join(given) or "-", known=known)
        for kind, names in DIRECTIONS.items():
            for k, one in enumerate(getattr(file, kind)):
                for name in names:
                    if getattr(one, name) is not None and math.hypot(*getattr(one, name)) < SHORTEST_NORMAL:
                        raise self.error("job.no_normal", (kind, k, name), given=name)
        for k, surface in enumerate(file.surface):
            if (surface.cylinder is None) != (surface.axis is None):
                raise self.error("job.bar_axis", ("surface", k, "axis"))
            if surface.hollow and surface.normal is not None:
                raise self.error("job.hollow_plane", ("surface", k, "hollow"))
        begin = file.start.pose
        held = file.pose.get(begin) if isinstance(begin, str) else begin
        if file.door and not (held is None and begin is not None) and not _is_whole(held):
            raise self.error("job.door_start", ("door", 0))
        if file.controller.kind == "hybrid" and not file.surface:
            raise self.error("job.no_surface", ("controller", "kind"))

    def check_variation(self, file: JobFile) -> None:
        """What is drawn has an order, changes something, and makes sense."""
        asked = file.variation
        if asked is None:
            return
        given: dict[str, Spread] = {name: getattr(asked, name) for name in SPREADS if getattr(asked, name) is not None}
        if not given:
            raise self.error("job.variation_empty", ("variation",), known=", ".join(SPREADS))
        for name, spread in given.items():
            path = ("variation", name)
            low = spread.mean if isinstance(spread, Normal) else spread[0]
            if isinstance(spread, tuple) and spread[1] < low:
                raise self.error("job.variation_order", path, low=low, high=spread[1])
            if low < 0.0 and name != "payload_offset":
                raise self.error("job.variation_negative", path, value=low)
        noise = file.simulation.noise
        if "noise" in given and noise.position == noise.velocity == 0.0:
            raise self.error("job.variation_noise", ("variation", "noise"))
        if "payload_offset" in given and "payload" not in given:
            raise self.error("job.variation_offset", ("variation", "payload_offset"))

    def check_controller(self, controller: Controller, simulation: Simulation) -> None:
        """Every gain that is given belongs to the law that is chosen, whose period is a whole number of steps."""
        step, rate = simulation.step, controller.rate
        if rate is not None:
            steps = 1.0 / (rate * step)
            if steps < 1.0 - WHOLE or abs(steps - round(steps)) > WHOLE * steps:
                near = sorted({max(math.floor(steps), 1), math.ceil(steps)}, reverse=True)
                rates = ", ".join(f"{1.0 / (k * step):.9g}" for k in near)
                raise self.error("job.rate_not_whole", ("controller", "rate"), value=rate, step=step, near=rates)
        own = GAINS[controller.kind]
        for name in {name: None for names in GAINS.values() for name in names if name not in own}:
            if getattr(controller, name) is not None:
                raise self.error("job.no_gain", ("controller", name), kind=controller.kind, known=", ".join(own))

    def check_pose(self, pose: Pose | Placed, path: lines.Path, data: dict[str, Any]) -> None:
        """A place, at most one way to say the orientation; a quaternion that can be normalised."""
        if pose.rpy is not None and pose.quaternion is not None:
            raise self.error("job.two_orientations", path)
        if "position" not in data and not ("frame" in data or "relative" in data or path[0] in ("frame", "pattern")):
            raise self.error("job.missing_key", (*path, "position"))
        if isinstance(pose, PlacedGoal) and pose.task == "position":
            for name in ("rpy", "quaternion"):
                if getattr(pose, name) is not None:
                    raise self.error("job.free_orientation", (*path, name))
        if pose.quaternion is not None and math.hypot(*pose.quaternion) < 1e-6:
            raise self.error("job.zero_quaternion", (*path, "quaternion"))

    def refuse_not_finite(self, value: Any, path: lines.Path) -> None:
        """TOML knows nan and inf; a job does not, nor numbers of which nothing but overflow can come."""
        if isinstance(value, float) and not math.isfinite(value):
            raise self.error("job.not_finite", path, value=value)
        if isinstance(value, float | int) and abs(value) > LARGEST_NUMBER and path[-1] != "seed":
            raise self.error("job.too_large_number", path, value=f"{value:g}", limit=f"{LARGEST_NUMBER:g}")
        items: Iterable[tuple[str | int, Any]] = ()
        if isinstance(value, dict):
            items = cast("dict[str, Any]", value).items()
        elif isinstance(value, list):
            items = enumerate(cast("list[Any]", value))
        for name, inner in items:
            self.refuse_not_finite(inner, (*path, name))

    def translated(self, error: msgspec.ValidationError, data: Any) -> JobError:
        """Msgspec's complaint with its path, in our words."""
        text = str(error)
        path = path_of(text, data)
        value = value_at(data, path)
        details = {"got": visible(repr(value))[:60], "reason": text.split(" - at ")[0].replace("`", "")}
        if length := re.search(r"of length (\d+)", text):
            return self.error("job.length", path, expected=length.group(1), **details)
        if "Invalid enum value" in text:
            known = ", ".join(choices_at(path))
            return self.error("job.choice", path, known=known, **details)
        if bound := re.search(r"Expected `\w+` (<=|>=|<|>) (\S+)", text):
            return self.error("job.bound", path, relation=bound.group(1), limit=bound.group(2), **details)
        if kind := re.search(r"Expected `([^`]+)`, got `([^`]+)`", text):
            expected = _Types(tuple(TYPES[one] for one in kind.group(1).split(" | ") if one in TYPES))
            return self.error("job.type", path, expected=expected, **details)
        return self.error("job.wrong", path, **details)


def _is_whole(pose: PlacedGoal | None) -> bool:
    """Whether a pose says all of its orientation."""
    return pose is not None and pose.task == "pose" and (pose.rpy is not None or pose.quaternion is not None)
