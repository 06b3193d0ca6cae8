"""Joints of any number of freedoms as drawn: kind, place, axes, what they connect.

Kinds of joints by freedoms: each expanded into the screws of joints of one freedom.

Gears, belts and cams: joints whose coordinate is a function of that of another one.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, frozen, number, real_array, require_kind, single
from mafsil.errors import InputError, ModelError
from mafsil.fields import check_fields
from mafsil.mobility.bodies.three_points import pose_by_points
from mafsil.mobility.tolerances import TYPED
from mafsil.solvers.cubic_spline import Spline

FULL_TURN = 1e-9
"""How far the table of a cam may miss a whole turn [rad], or its end the beginning: nine typed digits."""
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


class Kind(Enum):
    """How a joint lets its child move against its parent. Members: (name, symbol, freedoms, freedoms in a plane).

    Attributes:
        title: as files write it.
        symbol: letters of the field: R, P, H, C, U, S, E (planar), F (floating), RP (pin in a slot).
        freedoms: f, number of independent motions.
        planar: whether it may stand in a linkage of the plane.
        letters: the joints of one freedom that it is made of, from the parent to the child.
    """

    FIXED = ("fixed", "0", "", True)
    REVOLUTE = ("revolute", "R", "R", True)
    PRISMATIC = ("prismatic", "P", "P", True)
    HELICAL = ("helical", "H", "H", False)
    CYLINDRICAL = ("cylindrical", "C", "PR", False)
    UNIVERSAL = ("universal", "U", "RR", False)
    SPHERICAL = ("spherical", "S", "RRR", False)
    PLANAR = ("planar", "E", "PPR", True)
    FLOATING = ("floating", "F", "PPPRRR", False)
    PIN_IN_SLOT = ("pin_in_slot", "RP", "PR", True)

    def __init__(self, title: str, symbol: str, letters: str, planar: bool) -> None:
        self.title = title
        self.symbol = symbol
        self.letters = letters
        self.planar = planar

    @property
    def freedoms(self) -> int:
        """Number of independent motions."""
        return len(self.letters)

    def screws(self, point: Floats, axis: Floats, second: Floats, pitch: float) -> Floats:
        """(6, f) screws (omega, v) in the frame of the drawing, from the parent to the child, as columns.

        A point moves with omega x p + v. Revolute (w, -w x p), prismatic (0, w), helical (w, -w x p + h w).

        Args:
            point: (3,) on the axis [m].
            axis: (3,) unit direction; of planar joints the normal.
            second: (3,) unit: the second axis of a universal joint, the direction of the slot of a pin.
            pitch: advance per angle [m/rad].

        Reference: Lynch & Park, Modern Robotics, sec. 3.3.2.2.
        """
        none = np.zeros(3)

        def rotation(w: Floats, advance: float = 0.0) -> Floats:
            return np.concatenate([w, np.cross(point, w) + advance * w])

        def translation(w: Floats) -> Floats:
            return np.concatenate([none, w])

        columns: list[Floats] = []
        match self:
            case Kind.FIXED:
                return np.zeros((6, 0))
            case Kind.REVOLUTE:
                columns = [rotation(axis)]
            case Kind.PRISMATIC:
                columns = [translation(axis)]
            case Kind.HELICAL:
                columns = [rotation(axis, pitch)]
            case Kind.CYLINDRICAL:
                columns = [translation(axis), rotation(axis)]
            case Kind.UNIVERSAL:
                columns = [rotation(axis), rotation(second)]
            case Kind.PIN_IN_SLOT:
                columns = [translation(second), rotation(axis)]
            case Kind.PLANAR:
                columns = [*map(translation, across(axis)), rotation(axis)]
            case Kind.SPHERICAL:
                columns = [rotation(w) for w in np.eye(3)]
            case Kind.FLOATING:
                columns = [*map(translation, np.eye(3)), *(rotation(w) for w in np.eye(3))]
        return np.column_stack(columns)


KINDS = {kind.title: kind for kind in Kind} | {kind.symbol: kind for kind in Kind}
"""By the names and letters that files write."""
ALIASES = {
    "hinge": Kind.REVOLUTE, "pin": Kind.REVOLUTE, "rotary": Kind.REVOLUTE, "linear": Kind.PRISMATIC,
    "translational": Kind.PRISMATIC, "slider": Kind.PRISMATIC, "screw": Kind.HELICAL, "ball": Kind.SPHERICAL,
    "ball_and_socket": Kind.SPHERICAL, "hooke": Kind.UNIVERSAL, "cardan": Kind.UNIVERSAL,
    "free": Kind.FLOATING, "pr": Kind.PIN_IN_SLOT,
}  # fmt: skip
"""Other names of the field."""


def kind_named(word: str) -> Kind | None:
    """The kind of a name, a letter or an alias, in any case, with blanks or hyphens; None if there is none."""
    title = word.strip().lower().replace(" ", "_").replace("-", "_")
    return KINDS.get(word) or KINDS.get(title) or ALIASES.get(title) or KINDS.get(word.strip().upper())


def across(normal: Floats) -> Floats:
    """(2, 3) two unit directions that make a right-handed frame with a unit normal; x and y for z."""
    least = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = least - normal * float(least @ normal)
    first = first / np.linalg.norm(first)
    return np.array([first, np.cross(normal, first)], dtype=np.float64)


def _cam_rows(name: str, value: object) -> tuple[tuple[float, float], ...]:
    """Rows of a cam over one turn; none is no cam.

    Raises:
        InputError: the leader does not increase through one turn, or the follower does not come back.
    """
    given = real_array(name, cast("ArrayLike", value))
    if not given.size:
        return ()
    rows = as_batch(name, given, (2,), finite=True)
    increases = rows.ndim == 2 and len(rows) > 3 and bool((np.diff(rows[:, 0]) > 0).all())
    ends = rows[-1] - rows[0] if increases else np.zeros(2)
    if not increases or abs(ends[0] - 2 * np.pi) > FULL_TURN or abs(ends[1]) > FULL_TURN * np.abs(rows[:, 1]).max():
        raise InputError("mobility.cam", name=name, count=len(rows), turn=float(ends[0]), miss=float(ends[1]))
    inside = [(float(angle), float(lift)) for angle, lift in rows[:-1]]
    return (*inside, (inside[0][0] + 2 * np.pi, inside[0][1]))


@dataclass(frozen=True)
class Coupling:
    """Gears, belts, cams, joints that follow others: theta_follower = f(theta_leader) - f(0), counted from the drawing.

    Attributes:
        follower, leader: names of joints of one freedom.
        ratio: f is ratio theta_leader [1, m/rad or rad/m]; not zero, unless there is a table.
        table: of a cam, rows (leader, follower) [rad, rad | m] over one turn of the leader, the last follower as the
            first: f is the periodic cubic spline through them, so that accelerations are continuous.
    """

    follower: str
    leader: str
    ratio: float = 0.0
    table: tuple[tuple[float, float], ...] = ()
    __post_init__ = check_fields(ratio=number, table=_cam_rows)

    @cached_property
    def _spline(self) -> Spline:
        angle, lift = np.array(self.table).T
        return Spline(angle, lift, periodic=True)

    def motion(self, leader: Floats) -> tuple[Floats, Floats, Floats]:
        """Coordinate of the follower with its first and second derivative, at coordinates (*batch) of the leader."""
        if not self.table:
            return self.ratio * leader, np.full(leader.shape, self.ratio), np.zeros(leader.shape)
        value, slope, bend = (self._spline(leader, k) for k in range(3))
        return value - self._spline(0.0), slope, bend

    def counted_from(self, leader: float) -> Coupling:
        """The same with coordinates that are zero where the leader is at one [rad | m]."""
        return replace(self, table=tuple((angle - leader, lift) for angle, lift in self.table))
