"""Joints of any number of freedoms as drawn: kind, place, axes, what they connect."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, frozen, real_array, require_kind, single
from mafsil.errors import InputError, ModelError
from mafsil.mobility.bodies.three_points import pose_by_points
from mafsil.mobility.linkages.joint_kind import Kind, kind_named
from mafsil.mobility.tolerances import TYPED

Z = (0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False, slots=True)
class LinkageJoint:
    """A joint as drawn, between two bodies; coordinates are zero where it is drawn.

    Attributes:
        name: unique among the joints.
        kind: of how many freedoms it is.
        parent, child: names of the bodies; the coordinates move the child against the parent.
        point: (3,) on its axis, in the frame of the drawing [m].
        axis: (3,) unit direction; of planar joints the normal.
        second: (3,) unit; second axis of a universal joint, direction of the slot of a pin.
        pitch: of a helical joint [m/rad].
        actuated: whether a motor drives it.
        lower, upper: bounds of each of its coordinates [rad | m].
        child_point: (3,) place on the child, as drawn, that belongs in the joint [m]; None where the child is drawn in
            it.
        corners: (3, 3) of a floating body, whose places are its nine coordinates instead of shifts and angles [m]: only
            of surfaces of configurations.
    """

    name: str
    kind: Kind
    parent: str
    child: str
    point: Floats = field(default_factory=lambda: frozen(np.zeros(3)))
    axis: Floats = field(default_factory=lambda: frozen(Z))
    second: Floats = field(default_factory=lambda: frozen((1.0, 0.0, 0.0)))
    pitch: float = 0.0
    actuated: bool = False
    lower: float = -np.inf
    upper: float = np.inf
    child_point: Floats | None = None
    corners: Floats | None = None

    @property
    def freedoms(self) -> int:
        """Number of coordinates."""
        return self.kind.freedoms if self.corners is None else self.corners.size

    @property
    def screws(self) -> Floats:
        """(6, f) screws in the frame of the drawing."""
        if self.corners is not None:
            return pose_by_points(self.corners, np.zeros(self.corners.size))[1]
        return self.kind.screws(self.point, self.axis, self.second, self.pitch)


def joint(
    name: str,
    kind: Kind | str,
    bodies: Sequence[str],
    at: ArrayLike = (0.0, 0.0, 0.0),
    axis: ArrayLike | None = None,
    *,
    second: ArrayLike | None = None,
    pitch: float = 0.0,
    actuated: bool = False,
    limits: tuple[float, float] = (-np.inf, np.inf),
    child_at: ArrayLike | None = None,
) -> LinkageJoint:
    """A joint between two bodies where it is drawn.

    Args:
        name: of the joint, for reports.
        kind: of the joint: a member of `Kind`, its name (hinge, slider, screw, ball ... too), or a letter: R, P, H, C,
            U, S, E (planar), F (floating), RP.
        bodies: names of parent and child.
        at: (2,) or (3,) point on the axis [m].
        axis: (2,) or (3,) direction, of any length; z if None. Planar joints: the normal.
        second: (2,) or (3,) second axis of a universal joint, perpendicular to the first; direction of a slot, which is
            in the parent.
        pitch: of a helical joint [m/rad].
        actuated: whether a motor drives it.
        limits: least and greatest coordinate [rad | m].
        child_at: (2,) or (3,) place on the child, as drawn, that belongs in the joint [m]: links drawn apart, whose
            lengths are known but not where they meet. `at` if None.

    Raises:
        ModelError: an unknown kind, not two bodies, a zero axis, axes that are not perpendicular, limits that cross.
        InputError: points or directions that are not 2 or 3 finite numbers.
    """
    found = kind_named(kind) if isinstance(kind, str) else kind
    if not isinstance(cast("object", found), Kind) or found is None:
        raise ModelError("mobility.unknown_kind", joint=name, kind=kind, known=", ".join(k.title for k in Kind))
    require_kind(f"{name}: bodies", bodies, "pair of names", "__len__", "__getitem__")
    if isinstance(bodies, str) or len(bodies) != 2 or bodies[0] == bodies[1]:
        given = bodies if isinstance(bodies, str) else ", ".join(map(str, bodies))
        raise ModelError("mobility.two_bodies", joint=name, bodies=given)
    point = _in_space(f"{name}: at", at)
    direction = _unit(name, "axis", Z if axis is None else axis)
    other = np.array([1.0, 0.0, 0.0])
    if found in (Kind.UNIVERSAL, Kind.PIN_IN_SLOT):
        if second is None:
            raise ModelError("mobility.needs_second", joint=name, kind=found.title)
        other = _unit(name, "second", second)
        if abs(float(direction @ other)) > TYPED:
            angle = float(np.degrees(np.arccos(np.clip(direction @ other, -1, 1))))
            raise ModelError("mobility.not_perpendicular", joint=name, angle=angle)
    if found is Kind.HELICAL and not (np.isfinite(pitch) and pitch):
        raise ModelError("mobility.pitch", joint=name, pitch=pitch)
    low, high = bounds(name, limits)
    if not low <= high:
        raise ModelError("mobility.limits", joint=name, lower=low, upper=high)
    return LinkageJoint(
        name, found, str(bodies[0]), str(bodies[1]), frozen(point), frozen(direction), frozen(other), float(pitch),
        bool(actuated), low, high, None if child_at is None else frozen(_in_space(f"{name}: child_at", child_at)),
    )  # fmt: skip


def coincident_joints(
    name: str, kind: Kind | str, bodies: Sequence[str], at: ArrayLike = (0.0, 0.0, 0.0), **given: Any
) -> tuple[LinkageJoint, ...]:
    """A pin through k bodies: k - 1 joints at one place, each between neighbours of the list.

    Args:
        name: of the joint; of several `name-1`, `name-2` and so on.
        kind: as for `joint`.
        bodies: names of two or more, one after the other.
        at: (2,) or (3,) point on the axis [m].
        given: what else `joint` takes.

    Raises:
        ModelError, InputError: as `joint`.
    """
    require_kind(f"{name}: bodies", bodies, "list of names", "__len__", "__getitem__")
    if isinstance(bodies, str) or len(bodies) <= 2:
        return (joint(name, kind, bodies, at, **given),)
    return tuple(
        joint(f"{name}-{k}", kind, pair, at, **given) for k, pair in enumerate(itertools.pairwise(bodies), start=1)
    )


def bounds(name: str, limits: object) -> tuple[float, float]:
    """Two bounds, infinite ones among them."""
    pair = real_array(f"{name}: limits", cast("ArrayLike", limits))
    if pair.shape != (2,):
        raise InputError("input.shape", name=f"{name}: limits", expected=(2,), got=pair.shape, hint="")
    return float(pair[0]), float(pair[1])


def _in_space(name: str, value: ArrayLike) -> Floats:
    array = np.asarray(value, dtype=object)
    if array.shape == (2,):
        return np.append(single(name, value, (2,)), 0.0)
    return single(name, value, (3,))


def _unit(owner: str, name: str, value: ArrayLike) -> Floats:
    direction = _in_space(f"{owner}: {name}", value)
    size = float(np.abs(direction).max())
    if not size > 0:
        raise ModelError("mobility.zero_axis", joint=owner, name=name)
    direction = direction / size
    return direction / np.linalg.norm(direction)
