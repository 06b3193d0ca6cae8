"""What makes an arm solvable in closed form, as plain numbers: its axes, their order, and the road to its solutions."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, Vector3


class Family(Enum):
    """Arms with a closed form."""

    SPHERICAL_WRIST = "spherical_wrist"
    """Three joints that move a point, and three turning joints whose axes meet in it."""
    THREE_PARALLEL = "three_parallel"
    """One joint, three parallel axes, and two turning joints whose axes meet."""
    LINKED = "linked"
    """One joint, three parallel axes, and two turning joints whose axes do not meet."""
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
    ACROSS = "across"
    """Height along the first axis, then how far the second joint slides across it, then the first."""
    QUARTIC = "quartic"
    """One equation of fourth degree for the third joint, then the others."""


class Missed(Enum):
    """The step of a closed form that misses where there is no solution."""

    NONE = 0
    SHOULDER = 1
    """The first joint cannot give the height along the next axis: the shoulder's hole or rim."""
    FAR = 2
    """Too far away."""
    NEAR = 3
    """Too near: the hole of the workspace."""
    DIRECTION = 4
    """The first two axes cannot point there."""
    ORIENTATION = 5
    """The last axes cannot give the orientation."""


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
        shifted: the first joint of the closed form is the last of the chain, carried to the front by the pose:
            (P e_m P^-1) e_1 ... e_m-1 = P.
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
    shifted: bool = False

    @property
    def branches(self) -> int:
        """Rows of the closed form's table."""
        first = 1 if self.slides[0] else 2
        match self.family:
            case Family.SPHERICAL_WRIST:
                return 2 * self._roads
            case Family.THREE_PARALLEL | Family.LINKED:
                return 4 * first
            case Family.PLANAR:
                return 2
            case Family.POINT:
                return self._roads

    @property
    def parameters(self) -> int:
        """Number of values that have to be given: of the held joints."""
        return len(self.held)

    @property
    def quartic(self) -> bool:
        """Whether an equation of fourth degree is solved, whose roots may merge by three or four."""
        places = self.family in (Family.SPHERICAL_WRIST, Family.POINT)
        return self.family is Family.LINKED or (places and self.road is PointRoad.QUARTIC)

    @property
    def equations(self) -> int:
        """Of the task: three of a place, five of a place and a direction, six of a pose."""
        return 3 if self.family is Family.POINT else 5 if -2 in self.joints else 6

    @property
    def plain(self) -> bool:
        """Whether rows with marks far from zero are distinct and isolated: no turning joint was added."""
        if self.road is PointRoad.QUARTIC and any(self.slides[:3]):
            # Where the equation is of lower degree, the table repeats roots.
            return False
        return all(j >= 0 or slides for j, slides in zip(self.joints, self.slides, strict=True))

    @property
    def _roads(self) -> int:
        """Solutions of the first three joints."""
        ends = (self.slides[2], self.slides[0]) if self.road_reversed else (self.slides[0], self.slides[2])
        match self.road:
            case PointRoad.LINEAR:
                return 1
            case PointRoad.PARALLEL:
                return 2 if ends[0] else 4
            case PointRoad.ACROSS:
                return 2 if ends[1] else 4
            case _:
                return 4

    @property
    def numbers(self) -> Floats:
        """(6 m + 23,) all lengths and directions: what arms of the same structure differ in."""
        parts = (self.axes, self.points, self.home, self.centre, self.meeting, np.array([self.size]))
        return np.concatenate([np.ravel(part) for part in parts])

    @property
    def structure(self) -> str:
        """Words for what is left without the numbers: arms of equal words share one compiled function."""
        words = (
            self.family,
            self.slides,
            self.joints,
            self.reversed,
            self.road,
            self.road_reversed,
            self.shifted,
            self.n,
        )
        return " ".join(str(word) for word in words)

    @property
    def key(self) -> str:
        """Words for the compiled closed form: equal words, equal expressions."""
        held = " ".join(joint.key for joint in self.held)
        return f"{self.structure} {self.numbers.tobytes().hex()} held {held}"
