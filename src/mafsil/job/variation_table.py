"""What may differ from run to run of a job, as its file says it."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import msgspec

from mafsil.job.part import NotNegative, Part, Positive


class Normal(Part, frozen=True, kw_only=True):
    """Values about a mean, normally distributed."""

    mean: float
    deviation: NotNegative


Spread: TypeAlias = tuple[float, float] | Normal
"""Two ends, between which any value is as likely, or a mean with a deviation."""


class VariationTable(Part, frozen=True, kw_only=True):
    """The job is driven many times; in each run what stands here is drawn anew, and the controller does not know it.

    Attributes:
        runs: how many.
        seed: of the draws.
        bound: distance of the tip from its path that counts as good, if any [m].
        payload: mass that hangs at the tip besides [kg].
        payload_offset: of its centre of mass from the tip, drawn for each axis of the tip frame [m].
        inertia: factor of mass and inertia, drawn for each link.
        friction: factor of all coefficients of friction, drawn for each joint.
        gains: factor of all gains of the law.
        delay: by which efforts come later, rounded to whole periods of the law [s].
        noise: factor of the noise of positions and rates in `[simulation]`.
    """

    runs: Annotated[int, msgspec.Meta(ge=1, le=100_000)] = 200
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    bound: Positive | None = None
    payload: Spread | None = None
    payload_offset: Spread | None = None
    inertia: Spread | None = None
    friction: Spread | None = None
    gains: Spread | None = None
    delay: Spread | None = None
    noise: Spread | None = None


SPREADS = tuple(name for name in VariationTable.__struct_fields__ if name not in ("runs", "seed", "bound"))
"""Keys of what is drawn, as `mafsil.simulation.Variation` calls them."""
