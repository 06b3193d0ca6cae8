"""Frames of a job file: where each stands in {s}, what is said in them as poses in {s}, and the places of patterns."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import product
from math import prod
from pathlib import Path
from typing import TypeAlias

import msgspec
import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.csv_table import read_csv_table
from mafsil.errors import JobError
from mafsil.geometry import rotation
from mafsil.geometry.pose import inverse
from mafsil.geometry.quaternion import to_quaternion
from mafsil.job.language.description import Four, Goal, MovingFrame, Obstacle, Pose, Three
from mafsil.job.language.statements import JobFile, MovableFrame, Pattern, Placed, PlacedGoal, PlacedObstacle
from mafsil.job.language.surrounding_tables import DIRECTIONS, PathConstraints, PlacedConstraints
from mafsil.job.language.text import Keys
from mafsil.job.language.units import facing, pose_matrix
from mafsil.messages.visible import visible

SPACE, TOOL = "space", "tool"
"""Names that frames of a file cannot have."""
Complaint: TypeAlias = Callable[..., JobError]


class Frames:
    """The frames of a job by name, and inside loops those of the present places of patterns.

    Args:
        poses: (4, 4) of each in {s}.
        file: with the patterns, whose names are frames inside loops only.
        error: makes the complaint about a key.
    """

    def __init__(self, poses: Mapping[str, PoseMatrix], file: JobFile, error: Complaint) -> None:
        self._poses, self._file, self._error = dict(poses), file, error
        self.degrees = file.angles == "degrees"

    @classmethod
    def of(cls, file: JobFile, error: Complaint) -> Frames:
        """Of a file.

        Raises:
            JobError: a frame in an unknown one or in itself, a name that means something else.
        """
        frames = cls({}, file, error)
        for name in (*file.frame, *file.pattern):
            place = ("frame" if name in file.frame else "pattern", name)
            if name in (SPACE, TOOL) or (name in file.frame and name in file.pattern):
                raise error("job.frame_name", place, frame=visible(name))
        for name, given in file.frame.items():
            frames._settle(name, file.frame, ())
            if given.robot and (given.frame is not None or given.since is not None or given.travels):
                raise error("job.frame_on_robot", ("frame", name, "robot"))
            if given.robot and given.robot not in [each.name for each in file.other_robot]:
                known = ", ".join(visible(each.name) for each in file.other_robot) or "-"
                details = {"table": "other_robot", "given": visible(given.robot), "known": known}
                raise error("job.unknown_name", ("frame", name, "robot"), **details)
            if given.since is not None and not given.moves:
                raise error("job.frame_stands", ("frame", name, "since"))
            if given.moves and frames.carrier(given.frame) is not None:
                raise error("job.frame_moves", ("frame", name, "frame"), frame=visible(str(given.frame)))
        return frames

    def carrier(self, name: str | None) -> str | None:
        """The moving frame that a frame or pattern is, or stands in; None of what stands still."""
        frame = self._file.frame.get(name or "")
        if frame is not None and frame.moves:
            return name
        placed = frame or self._file.pattern.get(name or "")
        return None if placed is None else self.carrier(placed.frame)

    def require_standing(self, name: str | None, path: Keys) -> None:
        """Refuse a frame that moves where one has to stand still."""
        if self.carrier(name) is not None:
            raise self._error("job.frame_moves", path, frame=visible(str(name)))

    def moving(self) -> dict[str, MovingFrame]:
        """The frames that move."""
        found: dict[str, MovingFrame] = {}
        for name, given in self._file.frame.items():
            if given.moves:
                around = np.eye(4) if given.frame is None else self.pose(given.frame, ("frame", name, "frame"))
                velocity = _vector(around[:3, :3] @ given.velocity)
                pose = pose_of(self._poses[name])
                found[name] = MovingFrame(
                    pose=pose,
                    velocity=velocity,
                    angular_speed=given.angular_speed,
                    since=given.since,
                    robot=given.robot,
                )
        return found

    def inside(self, places: Mapping[str, PoseMatrix]) -> Frames:
        """The same and the present places of patterns."""
        return Frames(self._poses | dict(places), self._file, self._error)

    def pose(self, name: str, path: Keys) -> PoseMatrix:
        """(4, 4) of a frame in {s}.

        Raises:
            JobError: there is none of that name, or it is a pattern and this is no loop over it.
        """
        if name == SPACE:
            return np.eye(4)
        if name in self._poses:
            return self._poses[name]
        if name in self._file.pattern:
            raise self._error("job.pattern_outside", path, pattern=visible(name))
        raise self._error(
            "job.unknown_frame", path, frame=visible(name), known=", ".join(map(visible, self._poses)) or "-"
        )

    def place(self, given: Placed | PlacedObstacle, path: Keys) -> PoseMatrix:
        """(4, 4) in {s} of what is placed; in a frame it has the frame's orientation if it names none."""
        own = pose_matrix(_plain(given), degrees=self.degrees)
        return own if given.frame is None else self.pose(given.frame, (*path, "frame")) @ own

    def goal(self, given: PlacedGoal, path: Keys) -> Goal:
        """A goal in {s}, or a displacement along its axes or those of the tool.

        Raises:
            JobError: an unknown frame, or a pose in a frame that is relative as well.
        """
        if given.relative is not None:
            return msgspec.structs.replace(self._displacement(given, path), branch=given.branch)
        pose = self.point(given, path, free=given.task == "position")
        return Goal(
            position=pose.position, rpy=pose.rpy, quaternion=pose.quaternion, task=given.task, branch=given.branch,
            carrier=self.carrier(given.frame),
        )  # fmt: skip

    def point(self, given: Placed, path: Keys, free: bool = False) -> Pose:
        """A pose in {s}, or in the frame that carries it; one without a frame stays as it was typed.

        Args:
            given: a pose in a frame.
            path: where it stands in the file.
            free: its orientation does not count.
        """
        if given.frame is None:
            return _plain(given)
        T, carrier = self.place(given, path), self.carrier(given.frame)
        T = T if carrier is None else inverse(self._poses[carrier]) @ T
        return Pose(position=_three(T), quaternion=None if free else _four(T[:3, :3]))

    def obstacle(self, given: PlacedObstacle, path: Keys) -> Obstacle:
        """A body in {s}."""
        names = Obstacle.__struct_fields__
        plain = {name: getattr(given, name) for name in names}
        if given.frame is not None:
            self.require_standing(given.frame, (*path, "frame"))
            T = self.place(given, path)
            plain |= {"position": _three(T), "rpy": None, "quaternion": _four(T[:3, :3])}
        return Obstacle(**plain)

    def constraints_in_space(self, given: PlacedConstraints, path: Keys) -> PathConstraints:
        """What is kept, its directions in {s}."""
        plain = {name: getattr(given, name) for name in PathConstraints.__struct_fields__}
        if given.frame is not None:
            self.require_standing(given.frame, (*path, "frame"))
            R = self.pose(given.frame, (*path, "frame"))[:3, :3]
            for name in DIRECTIONS:
                if plain[name] is not None:
                    plain[name] = tuple((R @ plain[name]).tolist())
        return PathConstraints(**plain)

    def _displacement(self, given: PlacedGoal, path: Keys) -> Goal:
        if given.frame is not None:
            raise self._error("job.relative_frame", (*path, "frame"))
        if given.relative == TOOL:
            own = _plain(given)
            return Goal(position=own.position, rpy=own.rpy, quaternion=own.quaternion, task=given.task, relative="tool")
        self.require_standing(given.relative, (*path, "relative"))
        R = self.pose(str(given.relative), (*path, "relative"))[:3, :3]
        own = pose_matrix(_plain(given), degrees=self.degrees)
        turned = given.rpy is not None or given.quaternion is not None
        return Goal(
            position=_vector(R @ own[:3, 3]),
            quaternion=_four(R @ own[:3, :3] @ R.T) if turned else None, task=given.task, relative="space",
        )  # fmt: skip

    def _settle(self, name: str, frames: Mapping[str, MovableFrame], above: tuple[str, ...]) -> None:
        """The pose of a frame after that of the one that it stands in."""
        if name in self._poses:
            return
        parent, place = frames[name].frame, ("frame", name, "frame")
        if parent is not None and parent != SPACE:
            if parent in (*above, name):
                circle = " -> ".join(map(visible, (*above, name, parent)))
                raise self._error("job.frame_circle", place, circle=circle)
            if parent in frames:
                self._settle(parent, frames, (*above, name))
        self._poses[name] = self.place(frames[name], ("frame", name))


def pose_of(T: PoseMatrix) -> Pose:
    """The pose of a matrix (4, 4)."""
    return Pose(position=_three(T), quaternion=_four(T[:3, :3]))


def _plain(given: Placed | PlacedObstacle) -> Pose:
    if isinstance(given, Placed) and given.look_at is not None:
        return Pose(position=given.position, quaternion=_four(facing(np.subtract(given.look_at, given.position))))
    return Pose(position=given.position, rpy=given.rpy, quaternion=given.quaternion)


def _three(T: PoseMatrix) -> Three:
    return _vector(T[:3, 3])


def _vector(p: Floats) -> Three:
    return float(p[0]), float(p[1]), float(p[2])


def _four(R: Floats) -> Four:
    w, x, y, z = (float(each) for each in to_quaternion(rotation.check(R)))
    return w, x, y, z


ANGLES = ("roll", "pitch", "yaw")
"""Columns of a file of places that may be absent."""
MOST_PLACES = 100_000
"""Of one pattern."""


def places(
    pattern: Pattern, name: str, frames: Frames, unit: float, folder: Path, error: Complaint
) -> list[tuple[str, PoseMatrix]]:
    """Label `2,3` and pose (4, 4) in {s} of every place, in the order in which they are gone to.

    Args:
        pattern: of the file.
        name: of it.
        frames: of the job.
        unit: of lengths in the files that it names [m].
        folder: to which their paths are relative.
        error: makes the complaint about a key.

    Raises:
        JobError: not one pitch for each count, not one to three of them, or too many places.
        FileError: the file of places cannot be read; it names line and column.
    """
    if pattern.file is not None:
        if pattern.count or pattern.pitch:
            raise error("job.pattern_file", ("pattern", name))
        given = frames.place(msgspec.structs.replace(pattern, frame=None), ("pattern", name))
        rows = _of_file(folder / pattern.file, unit, degrees=frames.degrees)
        rows[:, :3, 3] += given[:3, 3]
        rows[:, :3, :3] = rows[:, :3, :3] @ given[:3, :3]
        around = np.eye(4) if pattern.frame is None else frames.pose(pattern.frame, ("pattern", name, "frame"))
        return [(str(k + 1), T) for k, T in enumerate(around @ rows)]
    if not 1 <= len(pattern.count) <= 3 or len(pattern.pitch) != len(pattern.count):
        raise error("job.pattern_pitch", ("pattern", name), count=len(pattern.count), pitch=len(pattern.pitch))
    if prod(pattern.count) > MOST_PLACES:
        raise error("job.too_many_places", ("pattern", name, "count"), places=prod(pattern.count), most=MOST_PLACES)
    origin = frames.place(pattern, ("pattern", name))
    found: list[tuple[str, PoseMatrix]] = []
    backwards = pattern.order == "snake"
    for row, above in enumerate(product(*(range(count) for count in reversed(pattern.count[1:])))):
        along = range(pattern.count[0])
        for first in reversed(along) if backwards and row % 2 else along:
            index = (first, *reversed(above))
            T = np.array(origin)
            steps = np.array([k * pitch for k, pitch in zip(index, pattern.pitch, strict=True)])
            T[:3, 3] += T[:3, : len(steps)] @ steps
            found.append((",".join(str(k + 1) for k in index), T))
    return found


def _of_file(path: Path, unit: float, *, degrees: bool) -> PoseMatrix:
    """(m, 4, 4) of the rows of a file."""
    table = read_csv_table(path, fewest=1)
    turned = any(table.column(name) is not None for name in ANGLES)
    columns = list[int]()
    for name in ("x", "y", "z", *(ANGLES if turned else ())):
        column = table.column(name)
        if column is None:
            raise table.no_column(name)
        columns.append(column)
    values = table.numbers(columns)
    T = np.tile(np.eye(4), (len(values), 1, 1))
    T[:, :3, 3] = unit * values[:, :3]
    if turned:
        T[:, :3, :3] = rotation.from_rpy(np.radians(values[:, 3:]) if degrees else values[:, 3:])
    return T
