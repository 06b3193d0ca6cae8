"""What makes an arm solvable in closed form, as plain numbers: its axes, their order, and the method that solves it.

Arms with a spherical shoulder, an elbow and a spherical wrist as plain numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, Vector3


class Family(Enum):
    """Arms with a closed form."""

    SPHERICAL_WRIST = "spherical_wrist"
    """Three joints that move a point, and three revolute joints whose axes meet in it."""
    THREE_PARALLEL = "three_parallel"
    """One joint, three parallel axes, and two revolute joints whose axes meet."""
    LINKED = "linked"
    """One joint, three parallel axes, and two revolute joints whose axes do not meet."""
    PLANAR = "planar"
    """Three parallel axes, and perhaps a prismatic joint along them."""
    POINT = "point"
    """Three joints that move a point; orientation is not asked for."""


class PositioningMethod(Enum):
    """How three joints are found that bring a point to a place."""

    PARALLEL = "parallel"
    """Height along the axes of the last two, then the distance from the second, then the second."""
    MEET = "meet"
    """Distance from the point where the first two axes meet, then both of them."""
    LINEAR = "linear"
    """Three prismatic joints."""
    ACROSS = "across"
    """Height along the first axis, then how far the second joint is prismatic across it, then the first."""
    QUARTIC = "quartic"
    """One equation of fourth degree for the third joint, then the others."""


class FailedStep(Enum):
    """The step of a closed form that fails where there is no solution."""

    NONE = 0
    SHOULDER = 1
    """The first joint cannot give the height along the next axis: the shoulder's hole or rim."""
    TOO_FAR = 2
    """Too far away."""
    TOO_NEAR = 3
    """Too near: the hole of the workspace."""
    DIRECTION = 4
    """The first two axes cannot point there."""
    ORIENTATION = 5
    """The last axes cannot give the orientation."""


@dataclass(frozen=True, eq=False)
class LockedJoint:
    """A joint whose value is given, so that the others are a pattern.

    Attributes:
        at: number of the pattern's joints before it.
        axis, point: (3,) of it at q = 0, in the sense of the pattern.
        prismatic: whether it is prismatic.
        joint: coordinate of the robot.
    """

    at: int
    axis: Vector3
    point: Vector3
    prismatic: bool
    joint: int

    @property
    def key(self) -> str:
        """Its numbers as words."""
        return f"{self.at} {self.axis.tobytes().hex()} {self.point.tobytes().hex()} {self.prismatic} {self.joint}"


@dataclass(frozen=True, eq=False)
class ArmPattern:
    """An arm as its closed form sees it: perhaps reversed, perhaps with joints added that do not exist.

    Attributes:
        family: which closed form.
        axes: (m, 3) unit directions of the joints at q = 0, in the order of the closed form, in {s}.
        points: (m, 3) a point of each axis [m].
        prismatic: (m) whether the joint is prismatic.
        joints: (m) coordinate of the robot that each joint is; -1 for an added joint that must stand still, -2 for an
            added joint that may turn.
        home: (4, 4) pose of the tip at q = 0.
        reversed: the closed form sees the robot from its tip: exp(-S_n q_n) ... exp(-S_1 q_1) = home T^-1.
        centre: (3,) where the wrist's axes meet (the point that is placed, for Family.POINT; the meeting point of the
            last two axes, for Family.THREE_PARALLEL) [m].
        positioning: how the first three joints place a point.
        positioning_reversed: the method starts from the placed point.
        meeting: (3,) where the first two axes of the elimination order meet [m].
        size: length that tells large from small [m].
        n: number of coordinates of the robot.
        shifted: the first joint of the closed form is the last of the chain, carried to the front by the pose:
            (P e_m P^-1) e_1 ... e_m-1 = P.
        locked: joints whose values are given, in the order of the pattern.
        defect: how far the arm is from the pattern [rad, and m relative to size]; zero within rounding.
    """

    family: Family
    axes: Floats
    points: Floats
    prismatic: tuple[bool, ...]
    joints: tuple[int, ...]
    home: PoseMatrix
    reversed: bool
    centre: Vector3
    positioning: PositioningMethod
    positioning_reversed: bool
    meeting: Vector3
    size: float
    n: int
    defect: float = 0.0
    locked: tuple[LockedJoint, ...] = ()
    shifted: bool = False

    @property
    def branches(self) -> int:
        """Rows of the closed form's table."""
        first = 1 if self.prismatic[0] else 2
        match self.family:
            case Family.SPHERICAL_WRIST:
                return 2 * self._positions
            case Family.THREE_PARALLEL | Family.LINKED:
                return 4 * first
            case Family.PLANAR:
                return 2
            case Family.POINT:
                return self._positions

    @property
    def parameters(self) -> int:
        """Number of values that have to be given: of the locked joints."""
        return len(self.locked)

    @property
    def quartic(self) -> bool:
        """Whether an equation of fourth degree is solved, whose roots may merge by three or four."""
        places = self.family in (Family.SPHERICAL_WRIST, Family.POINT)
        return self.family is Family.LINKED or (places and self.positioning is PositioningMethod.QUARTIC)

    @property
    def equations(self) -> int:
        """Of the task: three of a place, five of a place and a direction, six of a pose."""
        return 3 if self.family is Family.POINT else 5 if -2 in self.joints else 6

    @property
    def plain(self) -> bool:
        """Whether rows with branch margins far from zero are distinct and isolated: no revolute joint was added."""
        if self.positioning is PositioningMethod.QUARTIC and any(self.prismatic[:3]):
            # Where the equation is of lower degree, the table repeats roots.
            return False
        return all(j >= 0 or prismatic for j, prismatic in zip(self.joints, self.prismatic, strict=True))

    @property
    def _positions(self) -> int:
        """Solutions of the first three joints."""
        ends = (
            (self.prismatic[2], self.prismatic[0])
            if self.positioning_reversed
            else (self.prismatic[0], self.prismatic[2])
        )
        match self.positioning:
            case PositioningMethod.LINEAR:
                return 1
            case PositioningMethod.PARALLEL:
                return 2 if ends[0] else 4
            case PositioningMethod.ACROSS:
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
            self.prismatic,
            self.joints,
            self.reversed,
            self.positioning,
            self.positioning_reversed,
            self.shifted,
            self.n,
        )
        return " ".join(str(word) for word in words)

    @property
    def key(self) -> str:
        """Words for the compiled closed form: equal words, equal expressions."""
        locked = " ".join(joint.key for joint in self.locked)
        return f"{self.structure} {self.numbers.tobytes().hex()} locked {locked}"


@dataclass(frozen=True, eq=False)
class ArmAnglePattern:
    """Seven revolute joints: three axes that meet, one, and three that meet, neighbours of three normal to each other.

    Attributes:
        axes: (7, 3) unit directions of the joints at q = 0, in {s}.
        home: (4, 4) pose of the tip at q = 0.
        shoulder, elbow, wrist: (3,) where the axes meet, and a point of axis 4, at q = 0 [m].
    """

    axes: Floats
    home: PoseMatrix
    shoulder: Vector3
    elbow: Vector3
    wrist: Vector3

    @property
    def branches(self) -> int:
        """Two elbows, two shoulders, two wrists."""
        return 8

    @property
    def parameters(self) -> int:
        """Number of values that have to be given: the arm angle."""
        return 1

    @property
    def quartic(self) -> bool:
        """Whether an equation of fourth degree is solved."""
        return False

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return 7

    @property
    def key(self) -> str:
        """Words for the compiled form: equal words, equal expressions."""
        numbers = (self.axes, self.home, self.shoulder, self.elbow, self.wrist)
        return " ".join(np.ascontiguousarray(one).tobytes().hex() for one in numbers)
