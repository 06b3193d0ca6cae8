"""What makes an arm solvable in closed form, as plain numbers: axes, their order, the method; and where a row counts.

The thresholds say from which numbers on a row of a closed form is a solution, may become one, or is one with another;
they stand in the compiled decision (`mafsil.mechanics.closed_form.decision`) and in inverse kinematics, which refines
what the decision leaves open.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, Vector3
from mafsil.model.limits import MEASURED


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


ORTHOGONALITY = 1e-6
"""Largest |R'R - I| that is taken for rounding of a printed matrix and repaired."""
FARTHEST = 1e100
"""Numbers of a position from here on [m] are refused: squares of distances would soon overflow."""
CLEAR = 1e-11
"""Residual below which a row of the closed form needs no refinement [m | rad]."""
SPLIT = 0.5
"""Residual, in units of the arm, up to which a row with four merged roots may become a solution by refinement.

A merged shoulder lets a straight wrist seem bent, and the turn of its last link is then anything.
"""
NEARLY, BENT = 1e-3, 1e-2
"""Residual up to which a row may become a solution by refinement where a solution's branch margin is that small."""
MERGED = 1e-7
"""Branch margins up to which two branches are one, and a solution may be a member of a continuum."""
APART = 1e-5
"""Branch margins above which two branches are distinct solutions: their coordinates differ by as much at least."""
QUARTIC = 1e-4
"""The same of roots of an equation of fourth degree, which merge by three and four: by elimination below."""
SECOND = 1e-2
"""Branch margins above which a branch takes no part where two others meet: four merged roots split by so much."""
ROUNDED = 1e-10
"""Residuals, in units of the arm and times the square of the second branch margin, that rounding may explain, amply."""
FOLD = 1e-6
"""Branch margins below which roots of an equation of fourth degree may have merged."""
LOOSE = 1e-8
"""Tolerances, and residuals of the closed form, above which a configuration that is near enough is looked for."""
INSIDE = 1e-12
"""By how much a joint may seem beyond its limit by rounding [rad | m]: where its value is chosen, not measured."""
ON_LIMIT = MEASURED
"""By how much a joint of an isolated solution may lie beyond its limit and count as on it [rad | m]."""
MISSED = 1e-9
"""Residual, in units of the arm, up to which rounding explains that two ways of an arm do not meet exactly; and the
cosine of axes that are at right angles."""

WHOLE_TURN = 1e-12
"""Share of a turn by which rounding may miss a whole one."""
FIRST_JOINTS = {Family.SPHERICAL_WRIST: 3, Family.THREE_PARALLEL: 1, Family.LINKED: 1}
"""How many joints of a closed form are found before those of the wrist; where they are free, continua may cross."""
WRIST_JOINTS = {Family.SPHERICAL_WRIST: (3, 5), Family.THREE_PARALLEL: (1, 2, 3, 5)}
"""Which joints of a closed form move while a wrist that stands straight is turned."""


def candidate(pattern: ArmPattern) -> float:
    """Residual up to which a row of an exact closed form may become a solution by refinement.

    Rounding splits merged roots: two by its square root, four by its fourth root.
    """
    return 1e-2 if pattern.quartic else 1e-5


def folds(pattern: ArmPattern) -> bool:
    """Whether two pairs of roots may merge at once, so that rounding moves rows far off."""
    return pattern.family in (Family.SPHERICAL_WRIST, Family.THREE_PARALLEL)


def merges_twice(pattern: ArmPattern) -> bool:
    """Whether two of shoulder, elbow and wrist may do so; prismatic joints alone are linear: nothing merges."""
    revolute = (j >= 0 and not prismatic for j, prismatic in zip(pattern.joints, pattern.prismatic, strict=True))
    return folds(pattern) and any(revolute)
