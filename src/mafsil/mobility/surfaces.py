"""All surfaces of configurations of a linkage of mobility 2 that a search finds: followed, told apart, counted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import positive, whole
from mafsil.messages import say
from mafsil.messages.tables import number, table
from mafsil.mobility.balls import without_balls, without_balls_at
from mafsil.mobility.finite import all_are_real
from mafsil.mobility.instantaneous import instantaneous_mobility
from mafsil.mobility.linkages.linkage import Linkage, on_linkage
from mafsil.mobility.linkages.loop_closure import are_lengths, close_loops_near
from mafsil.mobility.surface import LONGEST, MOST_POINTS, ConfigurationSurface, follow_surface


class SurfacesStatus(Status):
    """Whether surfaces were found; a search never says that there is no other."""

    FOUND = ("mobility.surfaces_found", True)
    NOT_FOUND = ("mobility.surfaces_not_found", False)


@dataclass(frozen=True, eq=False, repr=False)
class ConfigurationSurfaces(Answer, data="hits others surfaces", entries="surfaces"):
    """Surfaces of configurations; true if there are any, iterable over them.

    Attributes:
        surfaces: followed from the first configuration that was met on each.
        hits: how many starts led to each surface.
        others: configurations met that are singular or of another mobility; no surface was followed from them.
    """

    surfaces: tuple[ConfigurationSurface, ...]
    hits: tuple[int, ...]
    others: int

    @property
    def status(self) -> SurfacesStatus:
        """Found or not found."""
        return SurfacesStatus.FOUND if self.surfaces else SurfacesStatus.NOT_FOUND

    def __bool__(self) -> bool:
        return len(self.surfaces) > 0

    def _table(self) -> list[str]:
        names = ("surface_head", "hits_head", "area_head", "euler_head", "branches_head", "singular_head")
        rows = [
            (
                str(k + 1), str(hits), number(one.area),
                "-" if one.euler_characteristic is None else str(one.euler_characteristic),
                str(len(one.branch_points)), str(len(one.singular_points)),
            )
            for k, (hits, one) in enumerate(zip(self.hits, self.surfaces, strict=True))
        ]  # fmt: skip
        head = tuple(say(f"mobility.{name}") for name in names)
        return table(head, rows) if rows else []

    def explain(self, language: str | None = None) -> str:
        """How many surfaces, how many of them closed, how rare the rarest was."""
        closed = sum(one.status.name in ("CLOSED", "ONE_SIDED") for one in self.surfaces)
        return self.status.sentence(
            language, count=len(self.surfaces), closed=closed, fewest=min(self.hits, default=0), others=self.others
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return Answer.to_dict(self) | {"count": len(self.surfaces)}


@on_linkage
def configuration_surfaces(
    linkage: Linkage, *, starts: int = 64, step: float = LONGEST, points: int = MOST_POINTS, seed: int = 0
) -> ConfigurationSurfaces:
    """The surfaces that make up the configurations of a linkage of mobility 2, as far as random starts find them.

    1. Random coordinates, closed by Newton's method, all at once.
    2. From the first of them that is regular a surface is followed; those that lie on it are hits.
    3. The next surface starts from what is left.

    Where sheets cross, each goes straight on and is counted apart; a pinched surface ends at its singular places, so
    that what meets only there is counted apart too.

    Args:
        linkage: as drawn; balls as for `trace_surface`.
        starts: random starts; where it is drawn is the first.
        step, points: of each surface, see `trace_surface`.
        seed: of the starts.

    Raises:
        ModelError: a rod between two balls that holds on to another such rod.
    """
    count, longest, most = whole("starts", starts, 1, 10_000), positive("step", step), whole("points", points, 3, 10**6)
    drawn, linkage = without_balls_at(linkage, np.zeros(linkage.coordinates)), without_balls(linkage)
    start = np.random.default_rng(seed).uniform(-np.pi, np.pi, (count, linkage.coordinates))
    start = start * np.where(are_lengths(linkage), linkage.size / np.pi, 1.0)
    start[0] = drawn
    closed = close_loops_near(linkage, start)
    left = closed.theta[closed.closed]
    surfaces: list[ConfigurationSurface] = []
    hits: list[int] = []
    others = 0
    while len(left):
        if instantaneous_mobility(linkage, left[0]).mobility != 2 or not all_are_real(linkage, left[0], 2):
            others, left = others + 1, left[1:]
            continue
        surfaces.append(follow_surface(linkage, left[0], longest, most))
        on = surfaces[-1].holds(left)
        on[0] = True
        hits.append(int(on.sum()))
        left = left[~on]
    return ConfigurationSurfaces(tuple(surfaces), tuple(hits), others)
