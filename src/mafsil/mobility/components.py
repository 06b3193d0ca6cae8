"""All curves of configurations of a linkage of mobility 1 that a search finds: traced, told apart, counted."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, positive, whole
from mafsil.messages import say
from mafsil.messages.tables import number, on_screen, table
from mafsil.mobility.finite import all_are_real
from mafsil.mobility.instantaneous import instantaneous_mobility
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.linkages.loop_closure import body_poses, close_loops_near, units
from mafsil.mobility.on_linkage import on_linkage
from mafsil.mobility.tracing import LONGEST, Trace, trace_motion

ON_CURVE = 0.75
"""Times the square of the longest step, for each body: as far as a curve of curvature up to 6 bends off its chords."""


class CurvesStatus(Status):
    """Whether curves were found; a search never says that there is no other."""

    FOUND = ("mobility.curves_found", True)
    NOT_FOUND = ("mobility.curves_not_found", False)


@dataclass(frozen=True, eq=False, repr=False)
class ConfigurationCurves(Answer):
    """Curves of configurations, each with its branch points; true if there are any, iterable over them.

    Attributes:
        curves: traced from the first configuration that was met on each.
        hits: how many starts led to each curve.
        others: configurations met that are singular or of another mobility; no curve was traced from them.
    """

    curves: tuple[Trace, ...]
    hits: tuple[int, ...]
    others: int

    @property
    def status(self) -> CurvesStatus:
        """Found or not found."""
        return CurvesStatus.FOUND if self.curves else CurvesStatus.NOT_FOUND

    def __bool__(self) -> bool:
        return len(self.curves) > 0

    def __len__(self) -> int:
        return len(self.curves)

    def __iter__(self) -> Iterator[Trace]:
        return iter(self.curves)

    def __repr__(self) -> str:
        head = (
            say("mobility.curve_head"),
            say("mobility.hits_head"),
            say("mobility.length_head"),
            say("mobility.branches_head"),
        )
        rows = [
            (str(k + 1), str(hits), number(curve.length), str(len(curve.branch_points)))
            for k, (hits, curve) in enumerate(zip(self.hits, self.curves, strict=True))
        ]
        return "\n".join([on_screen(self.explain()), *(table(head, rows) if rows else [])])

    def explain(self, language: str | None = None) -> str:
        """How many curves, how many of them closed, how rare the rarest was."""
        closed = sum(curve.status.name == "CLOSED" for curve in self.curves)
        return self.status.sentence(
            language, count=len(self.curves), closed=closed, fewest=min(self.hits, default=0), others=self.others
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "status": self.status.name.lower(), "count": len(self.curves), "hits": list(self.hits),
            "others": self.others, "curves": [curve.to_dict() for curve in self.curves],
        }  # fmt: skip


@on_linkage
def configuration_curves(
    linkage: Linkage, *, starts: int = 64, step: float = LONGEST, steps: int = 4000, seed: int = 0
) -> ConfigurationCurves:
    """The curves that make up the configurations of a linkage of mobility 1, as far as random starts find them.

    1. Random coordinates, closed by Newton's method, all at once.
    2. Each configuration that lies on no curve yet is the start of the next.

    Branch points join curves that are counted apart here: a curve goes straight on through them.

    Args:
        linkage: as drawn.
        starts: random starts; where it is drawn is the first.
        step, steps: of the curves, see `trace_motion`.
        seed: of the starts.
    """
    count, longest = whole("starts", starts, 1, 10_000), positive("step", step)
    scale = units(linkage)
    start = np.random.default_rng(seed).uniform(-np.pi, np.pi, (count, linkage.coordinates))
    start = start * np.where(scale == 1.0, 1.0, linkage.size / np.pi)
    start[0] = 0.0
    closed = close_loops_near(linkage, start)
    curves: list[Trace] = []
    hits: list[int] = []
    others = 0
    for theta in closed.theta[closed.closed]:
        on = [k for k, curve in enumerate(curves) if _lies_on(linkage, theta, curve, longest)]
        if on:
            hits[on[0]] += 1
        elif instantaneous_mobility(linkage, theta).mobility != 1 or not all_are_real(linkage, theta, 1):
            others += 1
        else:
            curves.append(trace_motion(linkage, theta, step=longest, steps=steps))
            hits.append(1)
    return ConfigurationCurves(tuple(curves), tuple(hits), others)


def _lies_on(linkage: Linkage, theta: Floats, curve: Trace, step: float) -> bool:
    """Whether the bodies stand as somewhere on a curve: the nearest point of its chords, in places of the bodies."""
    scale = np.append(np.ones(9), np.full(3, 1 / linkage.size))

    def places(value: Floats) -> Floats:
        T = body_poses(linkage, value)
        rows = np.concatenate([T[..., :3, :3].reshape(*T.shape[:-2], 9), T[..., :3, 3]], axis=-1) * scale
        return rows.reshape(*rows.shape[:-2], -1)

    here, path = places(theta), places(curve.theta)
    chord = np.diff(path, axis=0)
    size = np.maximum(np.sum(chord**2, axis=1), 1e-300)
    along = np.clip(np.sum((here - path[:-1]) * chord, axis=1) / size, 0.0, 1.0)
    apart = np.linalg.norm(here - path[:-1] - along[:, None] * chord, axis=1)
    return bool((apart < ON_CURVE * step**2 * np.sqrt(len(linkage.bodies))).any())
