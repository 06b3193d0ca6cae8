"""Joints of one degree of freedom (and none), as screws; joints of several freedoms, which close loops."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import Enum
from math import isfinite, perm
from typing import Any, TypeVar

import numpy as np

from mafsil.arrays import PoseMatrix, Vector3, Vector6, frozen
from mafsil.errors import ModelError
from mafsil.fields import check_fields, real
from mafsil.model.limits import Actuator, Friction, Limits
from mafsil.model.link import fixed_array
from mafsil.model.placement import checked_pose
from mafsil.model.tolerances import WRITTEN

Number = TypeVar("Number")
"""A float, an array or an expression."""


class JointKind(Enum):
    """How the child moves against the parent."""

    REVOLUTE = "revolute"
    PRISMATIC = "prismatic"
    HELICAL = "helical"
    FIXED = "fixed"
    CYLINDRICAL = "cylindrical"
    UNIVERSAL = "universal"
    SPHERICAL = "spherical"
    PLANAR = "planar"

    @property
    def freedoms(self) -> int:
        """Number of independent motions; only joints that close loops may have more than one."""
        return _FREEDOMS.get(self, 1)


_FREEDOMS = {
    JointKind.FIXED: 0,
    JointKind.CYLINDRICAL: 2,
    JointKind.UNIVERSAL: 2,
    JointKind.SPHERICAL: 3,
    JointKind.PLANAR: 3,
}


@dataclass(frozen=True, slots=True)
class Mimic:
    """The joint follows another: q = offset + multiplier x + higher[0] x^2 + ... with x = q[leader].

    Attributes:
        leader: name of the joint that is followed.
        multiplier, offset: of the line.
        higher: factors of x^2, x^3 and so on; none of a line.
    """

    leader: str
    multiplier: float = 1.0
    offset: float = 0.0
    higher: tuple[float, ...] = ()
    _numbers = check_fields(multiplier=real, offset=real)

    def __post_init__(self) -> None:
        self._numbers()
        higher = [real("higher", value) for value in self.higher]
        for name, value in (("multiplier", self.multiplier), ("offset", self.offset), *(("higher", x) for x in higher)):
            if not isfinite(value):
                raise ModelError("model.finite", name=name, value=value)
        while higher and not higher[-1]:
            higher.pop()
        object.__setattr__(self, "higher", tuple(higher))

    def curve(self, order: int = 0) -> tuple[float, ...]:
        """Coefficients of q, or of one of its derivatives by x, the lowest power first."""
        return differentiate((self.offset, self.multiplier, *self.higher), order)

    def after(self, other: Mimic) -> Mimic:
        """The coupling to the leader of another one, which this one's leader follows."""
        offset = self.multiplier * other.offset + self.offset
        if not (self.higher or other.higher):
            return Mimic(other.leader, self.multiplier * other.multiplier, offset)
        from numpy.polynomial import Polynomial

        offset, multiplier, *higher = polynomial(self.curve(), Polynomial(other.curve())).coef
        return Mimic(other.leader, float(multiplier), float(offset), tuple(float(x) for x in higher))

    def reverse(self, *, leader: bool) -> Mimic:
        """The coupling where the leader, or else the follower, is counted the other way."""
        offset, multiplier, *higher = ((-1.0) ** (k if leader else 1) * c for k, c in enumerate(self.curve()))
        return Mimic(self.leader, multiplier, offset, tuple(higher))

    def value(self, x: float) -> float:
        """Where the joint stands when its leader stands at x."""
        return polynomial(self.curve(), x)

    def range(self, lower: float, upper: float) -> tuple[float, float]:
        """Least and largest value while the leader is within two bounds."""
        turns = np.roots(self.curve(1)[::-1]) if self.higher else np.zeros(0)
        inside = [float(x.real) for x in turns if abs(x.imag) <= WRITTEN and lower < x.real < upper]
        values = [self.value(x) for x in (lower, upper, *inside)]
        return min(values), max(values)


def require_lines(joints: Iterable[Joint]) -> None:
    """No joint follows another along a curve.

    Raises:
        ModelError: one does, for a calculation that takes lines alone.
    """
    for joint in joints:
        if joint.mimic is not None and joint.mimic.higher:
            raise ModelError("model.curved", joint=joint.name, leader=joint.mimic.leader)


def polynomial(coefficients: Sequence[float], x: Number) -> Number:
    """The sum of coefficients[k] x^k, by Horner's rule."""
    total: Any = coefficients[-1] if coefficients else 0.0
    for coefficient in reversed(coefficients[:-1]):
        total = total * x + coefficient
    return total


def differentiate(coefficients: Sequence[float], order: int) -> tuple[float, ...]:
    """Coefficients of a derivative of a polynomial, the lowest power first."""
    return tuple(c * perm(k, order) for k, c in enumerate(coefficients) if k >= order)


@dataclass(frozen=True, eq=False, slots=True)
class Joint:
    """Connects `child` to `parent`: T_parent,child(q) = T_pj exp([S] q).

    Attributes:
        name: unique among the joints.
        kind: revolute, prismatic, helical or fixed; of joints that close loops also cylindrical, universal, spherical
            or planar.
        parent, child: names of links.
        T_pj: (4, 4) pose of the joint frame, which is the child's frame at q = 0, in the parent's frame.
        axis: (3,) unit direction in the joint frame; of a planar joint the normal, of a universal one the axis on the
            parent.
        second: (3,) unit direction in the joint frame: the axis of a universal joint on the child.
        pitch: advance per angle of a helical joint [m/rad].
        limits: bounds of q and its derivatives.
        wraps: the joint rotates without end (URDF `continuous`).
        actuated: False for a passive joint of a closed chain.
        mimic: the joint follows another one.
        actuator, friction: what drives and what resists it.

    Arrays are copied.

    Raises:
        InputError: wrong shapes, NaN or infinities.
        ModelError: T_pj is no pose, the axis of a moving joint has not length one, the pitch is not finite, the axes of
            a universal joint are not perpendicular.
    """

    name: str
    kind: JointKind
    parent: str
    child: str
    T_pj: PoseMatrix = field(default_factory=lambda: frozen(np.eye(4)))
    axis: Vector3 = field(default_factory=lambda: frozen([0.0, 0.0, 1.0]))
    pitch: float = 0.0
    limits: Limits = Limits()
    wraps: bool = False
    actuated: bool = True
    mimic: Mimic | None = None
    actuator: Actuator | None = None
    friction: Friction | None = None
    second: Vector3 = field(default_factory=lambda: frozen([1.0, 0.0, 0.0]))

    def __post_init__(self) -> None:
        object.__setattr__(self, "T_pj", frozen(checked_pose(f"{self.name}: T_pj", self.T_pj)))
        object.__setattr__(self, "axis", fixed_array(f"{self.name}: axis", self.axis, (3,)))
        length = float(np.linalg.norm(self.axis))
        if self.moves and abs(length - 1) > WRITTEN:
            raise ModelError("model.axis", joint=self.name, axis=self.axis.tolist(), length=length)
        object.__setattr__(self, "second", fixed_array(f"{self.name}: second", self.second, (3,)))
        if self.kind is JointKind.UNIVERSAL:
            self._require_cross()
        object.__setattr__(self, "pitch", real(f"{self.name}: pitch", self.pitch))
        if not isfinite(self.pitch):
            raise ModelError("model.finite", name=f"{self.name}: pitch", value=self.pitch)

    def _require_cross(self) -> None:
        """The second axis of a universal joint has length one and stands across the first."""
        length, along = float(np.linalg.norm(self.second)), float(self.axis @ self.second)
        if abs(length - 1) > WRITTEN:
            raise ModelError("model.axis", joint=self.name, axis=self.second.tolist(), length=length)
        if abs(along) > WRITTEN:
            raise ModelError("model.cross", joint=self.name, angle=float(np.degrees(np.arccos(along))))

    @property
    def moves(self) -> bool:
        """Whether the joint has a coordinate (its own or, as a mimic, another's)."""
        return self.kind is not JointKind.FIXED

    @property
    def screw(self) -> Vector6:
        """(6,) screw axis S = (omega, v) in the joint frame; zero for a fixed joint.

        Raises:
            ModelError: the joint has several freedoms.
        """
        zero = np.zeros(3)
        match self.kind:
            case JointKind.REVOLUTE:
                return np.concatenate([self.axis, zero])
            case JointKind.PRISMATIC:
                return np.concatenate([zero, self.axis])
            case JointKind.HELICAL:
                return np.concatenate([self.axis, self.pitch * self.axis])
            case JointKind.FIXED:
                return np.zeros(6)
            case _:
                raise ModelError("model.many_screws", joint=self.name, kind=self.kind.value)
