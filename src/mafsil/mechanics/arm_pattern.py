"""What makes an arm solvable in closed form, as plain numbers: its axes, their order, and the road to its solutions."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from mafsil.arrays import Floats, PoseMatrix, Vector3


class Family(Enum):
    """Arms with a closed form."""

    SPHERICAL_WRIST = "spherical_wrist"
    """Three joints that move a point, and three turning joints whose axes meet in it."""
    THREE_PARALLEL = "three_parallel"
    """One joint, three parallel axes, and two turning joints whose axes meet."""
    PLANAR = "planar"
    """Three parallel axes, and perhaps a slide along them."""
    POINT = "point"
    """Three joints that move a point; orientation is not asked for."""


class PointRoad(Enum):
    """How three joints are found that bring a point to a place."""

    PARALLEL = "parallel"
    """Height along the axes of the last two, then the distance from the second, then the second."""
    MEET = "meet"
    """Distance from the point where the first two axes meet, then both of them."""
    LINEAR = "linear"
    """Three slides."""


@dataclass(frozen=True, eq=False)
class HeldJoint:
    """A joint whose value is given, so that the others are a pattern.

    Attributes:
        at: number of the pattern's joints before it.
        axis, point: (3,) of it at q = 0, in the sense of the pattern.
        slides: whether it slides.
        joint: coordinate of the robot.
    """

    at: int
    axis: Vector3
    point: Vector3
    slides: bool
    joint: int

    @property
    def key(self) -> str:
        """Its numbers as words."""
        return f"{self.at} {self.axis.tobytes().hex()} {self.point.tobytes().hex()} {self.slides} {self.joint}"


@dataclass(frozen=True, eq=False)
class ArmPattern:
    """An arm as its closed form sees it: perhaps reversed, perhaps with joints added that do not exist.

    Attributes:
        family: which closed form.
        axes: (m, 3) unit directions of the joints at q = 0, in the order of the closed form, in {s}.
        points: (m, 3) a point of each axis [m].
        slides: (m) whether the joint slides.
        joints: (m) coordinate of the robot that each joint is; -1 for an added joint that must stand still, -2 for an
            added joint that may turn.
        home: (4, 4) pose of the tip at q = 0.
        reversed: the closed form sees the robot from its tip: exp(-S_n q_n) ... exp(-S_1 q_1) = home T^-1.
        centre: (3,) where the wrist's axes meet (the point that is placed, for Family.POINT; the meeting point of the
            last two axes, for Family.THREE_PARALLEL) [m].
        road: how the first three joints place a point.
        road_reversed: the road is walked from the placed point.
        meeting: (3,) where the first two axes of the road meet [m].
        size: length that tells large from small [m].
        n: number of coordinates of the robot.
        held: joints whose values are given, in the order of the pattern.
        defect: by how much the arm misses the pattern [rad, and m relative to size]; zero within rounding.
    """

    family: Family
    axes: Floats
    points: Floats
    slides: tuple[bool, ...]
    joints: tuple[int, ...]
    home: PoseMatrix
    reversed: bool
    centre: Vector3
    road: PointRoad
    road_reversed: bool
    meeting: Vector3
    size: float
    n: int
    defect: float = 0.0
    held: tuple[HeldJoint, ...] = ()

    @property
    def branches(self) -> int:
        """Rows of the closed form's table."""
        return {Family.SPHERICAL_WRIST: 8, Family.THREE_PARALLEL: 8, Family.PLANAR: 2, Family.POINT: 4}[self.family]

    @property
    def key(self) -> str:
        """Words for the compiled closed form: equal words, equal expressions."""
        arrays = (self.axes, self.points, self.home, self.centre, self.meeting)
        numbers = " ".join(array.tobytes().hex() for array in arrays)
        held = " ".join(joint.key for joint in self.held)
        words = f"{self.family} {self.slides} {self.joints} {self.reversed} {self.road} {self.road_reversed}"
        return f"{words} {self.size!r} {numbers} held {held}"
