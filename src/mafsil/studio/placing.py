"""What of a job the pointer can place, and the text of the job with such a thing somewhere else.

Only the numbers of its place change; that they mean the pose that was wished for is checked by reading the text again.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.geometry import pose, rotation
from mafsil.job import Job
from mafsil.job.language.part import Pose
from mafsil.job.language.text import Keys, Places, tables_of
from mafsil.job.language.units import facing, pose_matrix
from mafsil.report.content import Scene

POINTS = {"obstacle": "position", "surface": "point", "guide": "point", "hole": "mouth"}
"""Kinds of tables of what stands around, in the order of the scene, and the key of the place of each."""
DIRECTIONS = ("normal", "axis", "direction")
"""Keys of the z axis of what has no x axis."""
ORIENTATIONS = ("rpy", "quaternion", "look_at")
DECIMALS, OF_DEGREES = 6, 4
"""Of numbers that are written: finer than any pointer leads, and coarser than the single precision of windows."""
TURNED = 1e-5
"""Angle below which nothing was turned: windows compute poses in single precision [rad]."""
PLACED = 2e-5
"""How near what is read is to what was wished for: the decimals that are written, and `TURNED` [m, 1]."""


@dataclass(frozen=True, slots=True)
class Thing:
    """A target, or a thing that stands around, whose numbers stand in the text.

    Attributes:
        keys: of its table.
        point: key of its place in that table.
        direction: key of its z axis, where it has one and no x axis.
        index: among the targets of the scene, or among what is fixed.
    """

    keys: Keys
    point: str
    direction: str | None
    index: int

    @property
    def is_target(self) -> bool:
        """Whether it is a pose of the tool."""
        return self.keys[0] == "move"

    def pose(self, scene: Scene) -> PoseMatrix:
        """(4, 4) where it is in a scene."""
        row = scene.targets[self.index][1] if self.is_target else scene.fixed[self.index][1]
        return pose.from_rotation_translation(rotation.from_quaternion(row[3:]), row[:3])


def placeable(job: Job, text: str) -> list[Thing]:
    """Targets that are not relative, then what stands around, of all of which the table has lines of its own here.

    Args:
        job: as it is read.
        text: TOML.
    """
    places, tables = Places(text).of(job), tables_of(text, "")
    goals = [k for k, move in enumerate(job.move) if move.pose is not None]
    rows = [(("move", k, "pose"), "position", at) for at, k in enumerate(goals)]
    around = [(kind, k) for kind in POINTS for k in range(len(getattr(job, kind)))]
    rows += [((kind, k), POINTS[kind], at) for at, (kind, k) in enumerate(around)]
    things: list[Thing] = []
    for keys, point, at in rows:
        typed = _typed(tables, places, keys)
        if places.has_line(keys) and point in typed and not typed.get("relative"):
            direction = next((key for key in DIRECTIONS if key in typed and point != "position"), None)
            things.append(Thing(keys, point, direction, at))
    return things


def things_data(job: Job, things: list[Thing]) -> Iterator[dict[str, Any]]:
    """The same for the windows, with the parts that are picked: each goes with the target at which it is taken."""
    for one in things:
        turns = one.point == "position" or one.direction is not None
        yield {"kind": "target" if one.is_target else "around", "index": one.index, "turns": turns}
    own = {one.keys[1]: at for at, one in enumerate(things) if one.is_target}
    waiting, parts = None, dict[str, int | None]()
    for k, move in enumerate(job.move):
        if move.joints is not None or (move.pose is not None and move.pose.relative is None):
            waiting = own.get(k)
        if move.pick is not None:
            parts.setdefault(move.pick.name, waiting)
    for index, leads in enumerate(parts.values()):
        if leads is not None:
            yield {"kind": "part", "index": index, "leads": leads, "turns": True}


def placed_text(text: str, job: Job, thing: Thing, before: PoseMatrix, after: PoseMatrix) -> str:
    """The text with a thing at another pose: its place, and how it is turned where that changes.

    1. What is written holds in a frame F of the job: T_before = F T_written, so T_new = T_written T_before^-1 T_after.
    2. A thing without an x axis is written as a point and its z axis.

    Args:
        text: TOML.
        job: as it is read.
        thing: of that text.
        before, after: (4, 4) where it is, and will be, in {s}.
    """
    places, unit = Places(text).of(job), 1e-3 if job.lengths == "millimetres" else 1.0
    typed, degrees = _typed(tables_of(text, ""), places, thing.keys), job.angles == "degrees"
    turns, edit = _turns(before, after), Edit(text, places, thing.keys)
    if thing.point == "position":
        # 1
        T = _written(typed, unit, degrees, before) @ pose.inverse(before) @ after
        key = next((key for key in ORIENTATIONS if key in typed), None)
        if turns:
            edit.write(key, *_turned(T, key, degrees), behind=thing.point)
    else:
        # 2
        T = after
        if turns and thing.direction is not None:
            edit.write(thing.direction, thing.direction, np.round(T[:3, 2], DECIMALS))
    edit.write(thing.point, thing.point, np.round(T[:3, 3], DECIMALS) / unit)
    return edit.text


def is_placed(thing: Thing, scene: Scene, before: PoseMatrix, after: PoseMatrix) -> bool:
    """Whether a thing of a scene is where it was wished for; of what has no x axis the z axis counts.

    What was only shifted may look elsewhere: at the point that it is written to look at.

    Args:
        thing: of the scene.
        scene: of the text in which it was placed.
        before, after: (4, 4) where it was, and was wished for.
    """
    first = 3 if not _turns(before, after) else 0 if thing.point == "position" else 2
    return bool(np.abs(thing.pose(scene) - after)[:, first:].max() < PLACED)


def _turns(before: PoseMatrix, after: PoseMatrix) -> bool:
    return bool(rotation.angle_between(before[:3, :3], after[:3, :3]) > TURNED)


def _typed(tables: Mapping[str, Any], places: Places, keys: Keys) -> Mapping[str, Any]:
    """The table at some keys as it is typed; empty where a name stands for it."""
    here: Any = tables
    for key in places.as_typed(keys):
        try:
            here = here[key]
        except (LookupError, TypeError):
            return {}
    return cast("Mapping[str, Any]", here) if isinstance(here, Mapping) else {}


def _written(typed: Mapping[str, Any], unit: float, degrees: bool, before: PoseMatrix) -> PoseMatrix:
    """(4, 4) the pose that is written; without an orientation it has that of its frame, or in {s} that of before."""
    x, y, z = (unit * float(value) for value in typed["position"])
    position = (x, y, z)
    plain = Pose(position=position, rpy=typed.get("rpy"), quaternion=typed.get("quaternion"))
    T = pose_matrix(plain, degrees=degrees, orientation=None if "frame" in typed else before[:3, :3])
    if "look_at" in typed:
        T[:3, :3] = facing(unit * np.array(typed["look_at"], dtype=float) - position)
    return T


def _turned(T: PoseMatrix, key: str | None, degrees: bool) -> tuple[str, Floats]:
    """Key and numbers of an orientation, as a quaternion where one stood."""
    if key == "quaternion":
        return key, np.round(rotation.to_quaternion(T[:3, :3]), DECIMALS)
    angles = rotation.to_rpy(T[:3, :3])
    if not degrees:
        return "rpy", np.round(angles, DECIMALS)
    angles *= 180.0 / np.pi
    return "rpy", np.round(angles, OF_DEGREES)


class Edit:
    """A text whose lists of numbers are replaced one by one.

    Args:
        text: TOML.
        places: where its keys stand.
        table: keys of the table in which they are replaced.
    """

    def __init__(self, text: str, places: Places, table: Keys) -> None:
        self.text, self._places, self._table = text, places, table

    def write(self, old: str | None, key: str, values: Floats, *, behind: str = "") -> None:
        """Put a list in the place of that of another key; behind one where there was none.

        Args:
            old: key whose list is replaced; None where the new one is added.
            key: of the new list.
            values: its numbers.
            behind: key behind which it is added.
        """
        new = f"{key} = [{', '.join(f'{value + 0.0:.9g}' for value in values.tolist())}]"
        begin, end = self._span(old or behind)
        before = self.text[self.text.rfind("\n", 0, begin) + 1 : begin]
        if old is not None:
            self.text = self.text[:begin] + new + self.text[end:]
        else:
            alone = re.fullmatch(r"\s*(?:[\w\"'-]+\s*\.\s*)*", before) is not None
            self.text = self.text[:end] + (f"\n{before}" if alone else ", ") + new + self.text[end:]

    def _span(self, key: str) -> tuple[int, int]:
        """Where a key and its list begin and end."""
        line = self._places.line((*self._table, key)) or 1
        start = sum(len(row) for row in self.text.splitlines(keepends=True)[: line - 1])
        match = re.compile(rf"(?<![\w-]){key}\s*=\s*\[[^\]]*\]").search(self.text, start)
        return match.span() if match else (start, start)
