"""Configuration spaces of chains and trees by name: products of circles, intervals, lines, spheres and rotations.

Task spaces of textbook arms: annuli, spheres and bands, directions, what stays free behind a task point.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, positive, real_array, single, whole
from mafsil.errors import InputError
from mafsil.mobility.linkages.linkage import Linkage, on_linkage
from mafsil.mobility.linkages.linkage_joint import Kind
from mafsil.mobility.spaces.planar_positions import PolygonSpace, polygon_space
from mafsil.mobility.tolerances import TYPED


class SpaceFactor(Enum):
    """Factors of products: (name, dimension)."""

    LINE = ("R", 1)
    INTERVAL = ("I", 1)
    CIRCLE = ("S^1", 1)
    SPHERE = ("S^2", 2)
    ROTATIONS = ("SO(3)", 3)
    POINTS = ("points", 0)

    def __init__(self, symbol: str, dimension: int) -> None:
        self.symbol = symbol
        self.dimension = dimension


@dataclass(frozen=True)
class ProductSpace:
    """A product of factors, in the order of the coordinates.

    Attributes:
        factors: one after the other.
        sheets: number of separate copies: faces of a coin, say.
    """

    factors: tuple[SpaceFactor, ...]
    sheets: int = 1

    @property
    def dimension(self) -> int:
        """Least number of real coordinates; separate copies add none."""
        return sum(factor.dimension for factor in self.factors)

    @property
    def name(self) -> str:
        """As the field writes it: equal factors together, T^n for n circles, SE(3) for R^3 with SO(3)."""
        count = {factor: self.factors.count(factor) for factor in SpaceFactor}
        words: list[str] = []
        lines, rotations = count[SpaceFactor.LINE], count[SpaceFactor.ROTATIONS]
        if lines >= 3 and rotations == 1:
            words.append("SE(3)")
            lines, rotations = lines - 3, 0
        words += [_power("R", lines), _power("I", count[SpaceFactor.INTERVAL])]
        circles = count[SpaceFactor.CIRCLE]
        words += ["S^1" if circles == 1 else f"T^{circles}" if circles else ""]
        words += [_power("S^2", count[SpaceFactor.SPHERE]), _power("SO(3)", rotations)]
        found = " x ".join(word for word in words if word) or "point"
        return found if self.sheets == 1 else f"({found}) x {{{', '.join(str(k + 1) for k in range(self.sheets))}}}"

    def __str__(self) -> str:
        return f"{self.name} (dimension {self.dimension})"

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "name": self.name, "dimension": self.dimension, "factors": [f.symbol for f in self.factors],
            "sheets": self.sheets,
        }  # fmt: skip

    def __mul__(self, other: ProductSpace) -> ProductSpace:
        return ProductSpace(self.factors + other.factors, self.sheets * other.sheets)


def _power(symbol: str, count: int) -> str:
    if not count:
        return ""
    if count == 1:
        return symbol
    return f"({symbol})^{count}" if "^" in symbol or "(" in symbol else f"{symbol}^{count}"


_FREE = {
    Kind.FIXED: (),
    Kind.REVOLUTE: (SpaceFactor.CIRCLE,),
    Kind.PRISMATIC: (SpaceFactor.LINE,),
    Kind.HELICAL: (SpaceFactor.LINE,),
    Kind.CYLINDRICAL: (SpaceFactor.LINE, SpaceFactor.CIRCLE),
    Kind.UNIVERSAL: (SpaceFactor.CIRCLE, SpaceFactor.CIRCLE),
    Kind.SPHERICAL: (SpaceFactor.ROTATIONS,),
    Kind.PLANAR: (SpaceFactor.LINE, SpaceFactor.LINE, SpaceFactor.CIRCLE),
    Kind.FLOATING: (SpaceFactor.LINE, SpaceFactor.LINE, SpaceFactor.LINE, SpaceFactor.ROTATIONS),
    Kind.PIN_IN_SLOT: (SpaceFactor.LINE, SpaceFactor.CIRCLE),
}
DICTIONARY: dict[str, ProductSpace] = {
    "door": ProductSpace((SpaceFactor.INTERVAL,)),
    "point in a plane": ProductSpace((SpaceFactor.LINE,) * 2),
    "coin": ProductSpace((SpaceFactor.LINE, SpaceFactor.LINE, SpaceFactor.CIRCLE)),
    "coin with two faces": ProductSpace((SpaceFactor.LINE, SpaceFactor.LINE, SpaceFactor.CIRCLE), 2),
    "body in a plane": ProductSpace((SpaceFactor.LINE, SpaceFactor.LINE, SpaceFactor.CIRCLE)),
    "body in space": ProductSpace((SpaceFactor.LINE,) * 3 + (SpaceFactor.ROTATIONS,)),
    "rolling coin": ProductSpace((SpaceFactor.LINE, SpaceFactor.LINE, SpaceFactor.CIRCLE, SpaceFactor.CIRCLE)),
    "position": ProductSpace((SpaceFactor.LINE,) * 3),
    "position and angle": ProductSpace((SpaceFactor.LINE,) * 3 + (SpaceFactor.CIRCLE,)),
    "position and direction": ProductSpace((SpaceFactor.LINE,) * 3 + (SpaceFactor.SPHERE,)),
    "pose": ProductSpace((SpaceFactor.LINE,) * 3 + (SpaceFactor.ROTATIONS,)),
    "orientation": ProductSpace((SpaceFactor.ROTATIONS,)),
    "direction": ProductSpace((SpaceFactor.SPHERE,)),
}
"""Configuration and task spaces of the field's examples, by name."""


def configuration_space_names() -> tuple[str, ...]:
    """Names of the DICTIONARY."""
    return tuple(DICTIONARY)


def named_space(name: str) -> ProductSpace:
    """One of the DICTIONARY.

    Raises:
        InputError: another name; deformable bodies have no finite number of coordinates and are not in it.
    """
    if not isinstance(cast("object", name), str) or name not in DICTIONARY:
        raise InputError("mobility.unknown_space", name=name, known=", ".join(DICTIONARY))
    return DICTIONARY[name]


@on_linkage
def configuration_space(linkage: Linkage) -> ProductSpace:
    """The configuration space of a chain or tree as the product over its joints; a limited angle is an interval.

    Args:
        linkage: without loops.

    Raises:
        InputError: it has loops, so that its joints are not independent.
    """
    if linkage.loops:
        raise InputError("mobility.not_open", name=linkage.name or "-", loops=linkage.loops)
    factors: list[SpaceFactor] = []
    followers = {each.follower for each in linkage.couplings}
    for each in linkage.joints:
        if each.name in followers:
            continue
        free = _FREE[each.kind]
        limited = each.freedoms == 1 and np.isfinite(each.lower) and np.isfinite(each.upper)
        whole_turn = each.kind is Kind.REVOLUTE and each.upper - each.lower >= 2 * np.pi
        factors += [SpaceFactor.INTERVAL] if limited and not whole_turn else list(free)
    return ProductSpace(tuple(factors))


def product(spaces: Iterable[ProductSpace]) -> ProductSpace:
    """The product of spaces."""
    found = ProductSpace(())
    for space in spaces:
        found = found * space
    return found


def annulus(lengths: ArrayLike) -> tuple[float, float]:
    """Least and greatest distance of the tip of a planar chain of revolute joints from its base, without limits [m].

    R_max = sum L, R_min = max(0, 2 L_max - sum L)

    Args:
        lengths: (n,) positive [m].
    """
    L = [positive(f"lengths[{k}]", value) for k, value in enumerate(np.atleast_1d(real_array("lengths", lengths)))]
    if not L:
        raise InputError("mobility.polygon_lengths", got=(0,))
    total = sum(L)
    return max(0.0, 2 * max(L) - total), total


def self_motion_manifold(lengths: ArrayLike, distance: float) -> PolygonSpace:
    """All configurations of a planar chain of revolute joints whose tip stands at a distance from the base.

    The chain and the distance make a polygon: none, some, or families of configurations lie behind a task point.

    Args:
        lengths: (n,) of the links [m].
        distance: of the tip from the base [m], zero or more.
    """
    return polygon_space(np.append(real_array("lengths", lengths), real_array("distance", distance)))


@dataclass(frozen=True)
class SphereBand:
    """Where the tip of a spatial 2R arm with axes that meet can be: a band of a sphere.

    Attributes:
        radius: of the sphere about the point where the axes meet [m].
        z_min, z_max: of the band along the first axis [m].
    """

    radius: float
    z_min: float
    z_max: float

    @property
    def whole_sphere(self) -> bool:
        """Whether the band is everything."""
        small = TYPED * self.radius
        return self.z_max >= self.radius - small and self.z_min <= -self.radius + small


def spatial_2r(alpha: float, distance: float, offset: float = 0.0) -> SphereBand:
    """Reach of two revolute joints whose axes meet: z within c cos(alpha) +- rho sin(alpha) on a sphere.

    Args:
        alpha: angle of the axes [rad].
        distance: rho of the tip from the second axis [m].
        offset: c of the tip along the second axis [m].
    """
    rho, (angle, c) = positive("distance", distance), single("alpha, offset", [alpha, offset], (2,)).tolist()
    middle, half = c * np.cos(angle), rho * abs(np.sin(angle))
    return SphereBand(float(np.hypot(rho, c)), float(middle - half), float(middle + half))


def direction_of(theta: ArrayLike, phi: ArrayLike) -> Floats:
    """(*batch, 3) (sin theta cos phi, sin theta sin phi, cos theta): polar angle from z, azimuth [rad]."""
    t, p = np.broadcast_arrays(real_array("theta", theta), real_array("phi", phi))
    return np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1)


def angles_of_direction(direction: ArrayLike) -> tuple[Floats, np.ndarray[tuple[int, ...], np.dtype[np.bool_]]]:
    """(*batch, 2) polar angle and azimuth of directions [rad], and (*batch,) where the azimuth is free (poles: 0).

    Args:
        direction: (*batch, 3) of any length but zero.

    Raises:
        InputError: a direction is zero.
    """
    d = as_batch("direction", direction, (3,), finite=True)
    if not d.any(axis=-1).all():
        raise InputError("mobility.no_direction")
    level = np.hypot(d[..., 0], d[..., 1])
    pole = level <= TYPED * np.linalg.norm(d, axis=-1)
    phi = np.where(pole, 0.0, np.arctan2(d[..., 1], d[..., 0]))
    return np.stack([np.arctan2(level, d[..., 2]), phi], axis=-1), np.asarray(pole, dtype=np.bool_)


def task_redundancy(freedoms: int, task: str) -> int:
    """Freedoms of an arm beyond those of a task, named as in `configuration_space.DICTIONARY`."""
    return whole("freedoms", freedoms) - named_space(task).dimension
