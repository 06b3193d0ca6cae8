"""Friction coefficients of pairs of materials: a small table with its source, and room for one's own."""

from __future__ import annotations

from dataclasses import dataclass

from mafsil.errors import InputError
from mafsil.grasp.friction import FrictionLaw

SERWAY = "R. A. Serway, J. W. Jewett, Physics for Scientists and Engineers, table of coefficients of friction"


@dataclass(frozen=True)
class PairFriction:
    """Coefficients of one pair.

    Attributes:
        mu_s: at rest.
        mu_k: in motion, or None if the source has none.
        source: where the numbers are from.
    """

    mu_s: float
    mu_k: float | None
    source: str

    @property
    def law(self) -> FrictionLaw:
        """The pair as a friction law."""
        return FrictionLaw(self.mu_s, self.mu_k)


TABLE: dict[frozenset[str], PairFriction] = {
    frozenset(("steel",)): PairFriction(0.74, 0.57, SERWAY),
    frozenset(("aluminium", "steel")): PairFriction(0.61, 0.47, SERWAY),
    frozenset(("copper", "steel")): PairFriction(0.53, 0.36, SERWAY),
    frozenset(("rubber", "concrete")): PairFriction(1.0, 0.8, SERWAY),
    frozenset(("glass",)): PairFriction(0.94, 0.40, SERWAY),
    frozenset(("teflon",)): PairFriction(0.04, 0.04, SERWAY),
}
"""Dry and clean, by unordered pair; one name stands for a material on itself."""


def pair_friction(body: str, finger: str, own: dict[tuple[str, str], PairFriction] | None = None) -> PairFriction:
    """Friction coefficients of two materials, in either order.

    Args:
        body, finger: names of materials.
        own: further pairs; they go before the table's.

    Raises:
        InputError: no such pair.
    """
    pair = frozenset((body, finger))
    mine = {frozenset(key): value for key, value in (own or {}).items()}
    found = mine.get(pair) or TABLE.get(pair)
    if found is None:
        known = sorted(" / ".join(sorted(key)) for key in {*mine, *TABLE})
        raise InputError("grasp.no_material", body=body, finger=finger, known=", ".join(known))
    return found
