"""Configuration spaces of chains and trees by name: products of circles, intervals, lines, spheres and rotations."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from typing import Any, cast

import numpy as np

from mafsil.errors import InputError
from mafsil.mobility.joint_kind import Kind
from mafsil.mobility.linkage import Linkage
from mafsil.mobility.on_linkage import on_linkage


class Factor(Enum):
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

    factors: tuple[Factor, ...]
    sheets: int = 1

    @property
    def dimension(self) -> int:
        """Least number of real coordinates; separate copies add none."""
        return sum(factor.dimension for factor in self.factors)

    @property
    def name(self) -> str:
        """As the field writes it: equal factors together, T^n for n circles, SE(3) for R^3 with SO(3)."""
        count = {factor: self.factors.count(factor) for factor in Factor}
        words: list[str] = []
        lines, rotations = count[Factor.LINE], count[Factor.ROTATIONS]
        if lines >= 3 and rotations == 1:
            words.append("SE(3)")
            lines, rotations = lines - 3, 0
        words += [_power("R", lines), _power("I", count[Factor.INTERVAL])]
        circles = count[Factor.CIRCLE]
        words += ["S^1" if circles == 1 else f"T^{circles}" if circles else ""]
        words += [_power("S^2", count[Factor.SPHERE]), _power("SO(3)", rotations)]
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
    Kind.REVOLUTE: (Factor.CIRCLE,),
    Kind.PRISMATIC: (Factor.LINE,),
    Kind.HELICAL: (Factor.LINE,),
    Kind.CYLINDRICAL: (Factor.LINE, Factor.CIRCLE),
    Kind.UNIVERSAL: (Factor.CIRCLE, Factor.CIRCLE),
    Kind.SPHERICAL: (Factor.ROTATIONS,),
    Kind.PLANAR: (Factor.LINE, Factor.LINE, Factor.CIRCLE),
    Kind.FLOATING: (Factor.LINE, Factor.LINE, Factor.LINE, Factor.ROTATIONS),
    Kind.PIN_IN_SLOT: (Factor.LINE, Factor.CIRCLE),
}
DICTIONARY: dict[str, ProductSpace] = {
    "door": ProductSpace((Factor.INTERVAL,)),
    "point in a plane": ProductSpace((Factor.LINE,) * 2),
    "coin": ProductSpace((Factor.LINE, Factor.LINE, Factor.CIRCLE)),
    "coin with two faces": ProductSpace((Factor.LINE, Factor.LINE, Factor.CIRCLE), 2),
    "body in a plane": ProductSpace((Factor.LINE, Factor.LINE, Factor.CIRCLE)),
    "body in space": ProductSpace((Factor.LINE,) * 3 + (Factor.ROTATIONS,)),
    "rolling coin": ProductSpace((Factor.LINE, Factor.LINE, Factor.CIRCLE, Factor.CIRCLE)),
    "position": ProductSpace((Factor.LINE,) * 3),
    "position and angle": ProductSpace((Factor.LINE,) * 3 + (Factor.CIRCLE,)),
    "position and direction": ProductSpace((Factor.LINE,) * 3 + (Factor.SPHERE,)),
    "pose": ProductSpace((Factor.LINE,) * 3 + (Factor.ROTATIONS,)),
    "orientation": ProductSpace((Factor.ROTATIONS,)),
    "direction": ProductSpace((Factor.SPHERE,)),
}
"""Configuration and task spaces of the field's examples, by name."""


def configuration_space_names() -> tuple[str, ...]:
    """Names of the DICTIONARY."""
    return tuple(DICTIONARY)


def space_named(name: str) -> ProductSpace:
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
    factors: list[Factor] = []
    followers = {each.follower for each in linkage.couplings}
    for each in linkage.joints:
        if each.name in followers:
            continue
        free = _FREE[each.kind]
        limited = each.freedoms == 1 and np.isfinite(each.lower) and np.isfinite(each.upper)
        whole_turn = each.kind is Kind.REVOLUTE and each.upper - each.lower >= 2 * np.pi
        factors += [Factor.INTERVAL] if limited and not whole_turn else list(free)
    return ProductSpace(tuple(factors))


def product(spaces: Iterable[ProductSpace]) -> ProductSpace:
    """The product of spaces."""
    found = ProductSpace(())
    for space in spaces:
        found = found * space
    return found
