"""Job files in, checked jobs out; every complaint names the key, the line and the remedy."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal, cast, get_args, get_origin, get_type_hints

import msgspec

from mafsil.errors import FileError, JobError
from mafsil.job import lines
from mafsil.job.description import QUICKEST, TIP_PATHS, Goal, Job, Move, Obstacle, Part, Pose, SceneFile
from mafsil.job.syntax import syntax_error
from mafsil.messages import say
from mafsil.messages.visible import visible
from mafsil.model.source import regular_bytes
from mafsil.toml_source import parsed_toml

LARGEST_FILE = 20_000_000
"""In bytes: some hundred thousand points."""
LARGEST_NUMBER = 1e9
"""Of any quantity of a job: larger than that is a slip of the unit or the exponent."""
ACTIONS = ("joints", "pose", "pick", "place", "pause")
KINDS_OF_OBSTACLE = ("box", "sphere", "cylinder", "capsule", "floor")
TIP_TOLERANCES = ("position", "orientation")
GAINS = {"computed_torque": ("frequency", "damping"), "pd_gravity": ("stiffness", "rate_gain")}
"""Gains of each law; those of another one have no effect and are refused."""
_ALL = ("name", "tolerance")
_TRAVEL = (*_ALL, "path", "via", "profile", "duration", "speed", "avoid")
EFFECTIVE = {
    "joints": _TRAVEL,
    "pose": (*_TRAVEL, "blend"),
    "pick": (*_ALL, "hold"),
    "place": (*_ALL, "hold"),
    "pause": _ALL,
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
    return parse(text_of(path), source=path.name)


def text_of(path: Path) -> str:
    """The text of a job file.

    Raises:
        FileError: missing, unreadable, too large, not UTF-8.
    """
    shown = visible(str(path))
    if path.is_dir():
        raise FileError("job.directory", path=shown)
    try:
        data = regular_bytes(path, LARGEST_FILE + 1)
    except FileNotFoundError:
        raise FileError("job.no_file", path=shown) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError("job.unreadable", path=shown, reason=reason) from None
    if len(data) > LARGEST_FILE:
        raise FileError("job.too_large", path=shown, limit=LARGEST_FILE // 1_000_000)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileError("job.encoding", path=shown, position=error.start) from None


def parse(text: str, source: str = "<text>") -> Job:
    """The job in a text.

    Args:
        text: TOML.
        source: name of the file, for errors.

    Raises:
        FileError: it is no TOML.
        JobError: a key is unknown, missing, of the wrong type or out of range.
    """
    try:
        data = parsed_toml(text)
    except ValueError as error:
        raise syntax_error(visible(source), str(error)) from None
    reader = _Reader(text, visible(source))
    reader.refuse_unknown(data, Job, ())
    reader.require(data, Job, ())
    try:
        job = msgspec.convert(data, Job, strict=True)
    except msgspec.ValidationError as error:
        raise reader.translated(error, data) from None
    reader.refuse_not_finite(data, ())
    for k, move in enumerate(job.move):
        reader.check_move(move, k, data["move"][k])
        reader.check_blend(job.move, k)
    reader.check_obstacles(job.obstacle)
    reader.check_avoiding(job.move)
    reader.check_start(job)
    reader.check_controller(job)
    if not job.move:
        raise reader.error("job.no_moves", ("move",))
    return job


def parse_scene(text: str, source: str = "<text>") -> SceneFile:
    """Obstacles from a text: `[[obstacle]]` tables as in job files; arguments and errors as `parse`."""
    try:
        data = parsed_toml(text)
    except ValueError as error:
        raise syntax_error(visible(source), str(error)) from None
    reader = _Reader(text, visible(source))
    reader.refuse_unknown(data, SceneFile, ())
    reader.require(data, SceneFile, ())
    try:
        found = msgspec.convert(data, SceneFile, strict=True)
    except msgspec.ValidationError as error:
        raise reader.translated(error, data) from None
    reader.refuse_not_finite(data, ())
    reader.check_obstacles(found.obstacle)
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

    def __init__(self, text: str, source: str) -> None:
        self.error = lines.Places(text, source).error

    def refuse_unknown(self, data: Any, kind: type[Part], path: lines.Path) -> None:
        """Every key of every table is one that we know; close matches are offered."""
        known = kind.__struct_fields__
        for name, value in data.items():
            here = (*path, name)
            if name not in known:
                close = get_close_matches(str(name), known, n=_MOST_CLOSE, cutoff=0.55)
                key = "job.unknown_key_close" if close else "job.unknown_key"
                raise self.error(key, here, close=", ".join(close), known=", ".join(known))
            for inner, place, part in _tables(value, _field_type(kind, name), here):
                self.refuse_unknown(inner, part, place)

    def require(self, data: Any, kind: type[Part], path: lines.Path) -> None:
        """Every key without a default is there."""
        for field in msgspec.structs.fields(kind):
            if field.required and field.name not in data:
                raise self.error("job.missing_key", (*path, field.name))
            if field.name in data:
                for inner, place, part in _tables(data[field.name], field.type, (*path, field.name)):
                    self.require(inner, part, place)

    def check_move(self, move: Move, k: int, keys: Iterable[str]) -> None:
        """A move asks for exactly one thing, and its options fit it."""
        given = [name for name in ACTIONS if getattr(move, name) not in (None, False)]
        if len(given) != 1:
            key = "job.move_empty" if not given else "job.move_many"
            raise self.error(key, ("move", k), given=", ".join(given), known=", ".join(ACTIONS))
        effective = EFFECTIVE[given[0]]
        for name in keys:
            if name not in (*effective, *ACTIONS):
                known = ", ".join(effective)
                raise self.error("job.no_effect", ("move", k, name), action=given[0], known=known)
        self.check_path(move, k)
        if move.pose is not None:
            self.check_pose(move.pose, ("move", k, "pose"))
        if move.tolerance is not None:
            judged = () if move.pause is not None else ("joints",) if move.joints is not None else TIP_TOLERANCES
            for name in move.tolerance.__struct_fields__:
                if getattr(move.tolerance, name) is not None and name not in judged:
                    raise self.error("job.no_tolerance", ("move", k, "tolerance", name), action=given[0])

    def check_path(self, move: Move, k: int) -> None:
        """The points on the way, the profile and the goal fit the path."""
        of_tip = move.path in TIP_PATHS
        if of_tip and move.pose is None:
            raise self.error("job.line_pose", ("move", k, "path"), kind=move.path)
        passing = () if move.path == "arc" else QUICKEST
        if passing and move.via and move.profile not in (None, *passing):
            raise self.error("job.via_profile", ("move", k, "profile"), known=", ".join(passing))
        least, most = POINTS_ON_THE_WAY[move.path]
        if not least <= len(move.via) <= most:
            key = "job.line_via" if most == 0 else "job.arc_via" if most == 1 else "job.spline_via"
            raise self.error(key, ("move", k, "via"), kind=move.path, got=len(move.via))
        for i, via in enumerate(move.via):
            if isinstance(via, Pose) != of_tip:
                key = "job.via_pose" if of_tip else "job.via_joints"
                raise self.error(key, ("move", k, "via", i), kind=move.path)
            if isinstance(via, Pose):
                self.check_pose(via, ("move", k, "via", i))

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

    def check_obstacles(self, obstacles: tuple[Obstacle, ...]) -> None:
        """Each obstacle is exactly one thing."""
        for k, obstacle in enumerate(obstacles):
            given = [name for name in KINDS_OF_OBSTACLE if getattr(obstacle, name) not in (None, False)]
            if len(given) != 1:
                known = ", ".join(KINDS_OF_OBSTACLE)
                raise self.error("job.obstacle_kind", ("obstacle", k), given=", ".join(given) or "-", known=known)
            self.check_pose(obstacle, ("obstacle", k))

    def check_avoiding(self, moves: tuple[Move, ...]) -> None:
        """Only moves of the joints without points on the way go round."""
        for k, move in enumerate(moves):
            if not move.avoid:
                continue
            if move.path in TIP_PATHS:
                raise self.error("job.avoid_path", ("move", k, "avoid"), kind=move.path)
            if move.via:
                raise self.error("job.avoid_via", ("move", k, "via"))
            if move.profile not in (None, *QUICKEST):
                raise self.error("job.avoid_profile", ("move", k, "profile"), known=", ".join(QUICKEST))

    def check_start(self, job: Job) -> None:
        """One way to say where the robot begins."""
        if job.start.joints is not None and job.start.pose is not None:
            raise self.error("job.two_starts", ("start", "pose"))
        if job.start.pose is not None:
            self.check_pose(job.start.pose, ("start", "pose"))
        if job.tool.offset is not None:
            self.check_pose(job.tool.offset, ("tool", "offset"))

    def check_controller(self, job: Job) -> None:
        """Every gain that is given belongs to the law that is chosen, whose period is a whole number of steps."""
        step, rate = job.simulation.step, job.controller.rate
        if rate is not None:
            steps = 1.0 / (rate * step)
            if steps < 1.0 - WHOLE or abs(steps - round(steps)) > WHOLE * steps:
                near = sorted({max(math.floor(steps), 1), math.ceil(steps)}, reverse=True)
                rates = ", ".join(f"{1.0 / (k * step):.9g}" for k in near)
                raise self.error("job.rate_not_whole", ("controller", "rate"), value=rate, step=step, near=rates)
        foreign = [kind for kind in GAINS if kind != job.controller.kind]
        for kind in foreign:
            for name in GAINS[kind]:
                if getattr(job.controller, name) is not None:
                    details = {"kind": job.controller.kind, "known": ", ".join(GAINS[job.controller.kind])}
                    raise self.error("job.no_gain", ("controller", name), **details)

    def check_pose(self, pose: Pose, path: lines.Path) -> None:
        """At most one way to say the orientation; a quaternion that can be normalised."""
        if pose.rpy is not None and pose.quaternion is not None:
            raise self.error("job.two_orientations", path)
        if isinstance(pose, Goal) and pose.task == "position":
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
        path = _path(text)
        value = _value(data, path)
        details = {"got": visible(repr(value))[:60], "reason": text.split(" - at ")[0].replace("`", "")}
        if length := re.search(r"of length (\d+)", text):
            return self.error("job.length", path, expected=length.group(1), **details)
        if "Invalid enum value" in text:
            known = ", ".join(_choices(path))
            return self.error("job.choice", path, known=known, **details)
        if bound := re.search(r"Expected `\w+` (<=|>=|<|>) (\S+)", text):
            return self.error("job.bound", path, relation=bound.group(1), limit=bound.group(2), **details)
        if kind := re.search(r"Expected `([^`]+)`, got `([^`]+)`", text):
            expected = _Types(tuple(TYPES[one] for one in kind.group(1).split(" | ") if one in TYPES))
            return self.error("job.type", path, expected=expected, **details)
        return self.error("job.wrong", path, **details)


def _field_type(kind: type[Part], name: str) -> Any:
    return _hints(kind)[name]


@lru_cache
def _hints(kind: type[Part]) -> dict[str, Any]:
    return get_type_hints(kind)


def _tables(value: Any, annotation: Any, path: lines.Path) -> Iterator[tuple[dict[str, Any], lines.Path, type[Part]]]:
    """The tables inside a value, with their places and types."""
    inner = get_args(annotation)
    for option in (annotation, *inner, *(part for one in inner for part in get_args(one))):
        if isinstance(option, type) and issubclass(option, Part):
            if isinstance(value, dict):
                yield value, path, option
            elif isinstance(value, list) and get_origin(annotation) is tuple:
                for k, item in enumerate(cast("list[Any]", value)):
                    if isinstance(item, dict):
                        yield item, (*path, k), option
            return


def _path(text: str) -> lines.Path:
    """`$.move[2].pose` as ("move", 2, "pose")."""
    found = re.search(r"at `\$([^`]*)`", text)
    steps = re.findall(r"\.([^.\[\]]+)|\[(\d+)\]", found.group(1)) if found else []
    return tuple(name or int(index) for name, index in steps)


def _value(data: Any, path: lines.Path) -> Any:
    for step in path:
        data = data[step]
    return data


def _choices(path: lines.Path) -> tuple[str, ...]:
    kind: Any = Job
    for step in path:
        if isinstance(step, str):
            annotation = _field_type(kind, step)
            options = [annotation, *get_args(annotation)]
            kind = next((o for o in options if isinstance(o, type) and issubclass(o, Part)), annotation)
    literals = [kind, *get_args(kind)]
    return tuple(str(x) for option in literals if get_origin(option) is Literal for x in get_args(option))
