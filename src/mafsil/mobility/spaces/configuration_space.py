"""Configuration spaces of chains and trees by name: products of circles, intervals, lines, spheres and rotations."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from typing import Any, cast

import numpy as np

from mafsil.errors import InputError
from mafsil.mobility.linkages.joint_kind import Kind
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.on_linkage import on_linkage


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
