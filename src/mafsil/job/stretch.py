"""A stretch of the plan: legs that follow each other while the same things hang on the flange."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby

from mafsil.job.description import Grasp
from mafsil.job.equipment import Load
from mafsil.job.plan import Plan
from mafsil.simulation import Scenario
from mafsil.trajectory import Trajectory, sequence


@dataclass(frozen=True, eq=False, slots=True)
class Stretch:
    """Legs during which tool and part should be the same.

    Attributes:
        start: in the time of the plan [s].
        first: index of its first leg.
        trajectory: of all its legs.
        load: what the plan has on the flange.
    """

    start: float
    first: int
    trajectory: Trajectory
    load: Load

    @property
    def carried(self) -> Grasp | None:
        """What the plan has in the tool."""
        return self.load.carried


@dataclass(frozen=True, eq=False, slots=True)
class Driven:
    """A stretch as it was simulated.

    Attributes:
        stretch: what was planned.
        scenario: what was simulated: true arm, model, law, pushes.
        gripped: whether the part that the plan holds was really taken; true where it holds none.
    """

    stretch: Stretch
    scenario: Scenario
    gripped: bool

    @property
    def carried(self) -> Grasp | None:
        """What the tool really carried."""
        return self.stretch.carried if self.gripped else None


def stretches(plan: Plan) -> Iterator[Stretch]:
    """The stretches of a plan, in order."""
    start, first = 0.0, 0
    for _, group in groupby(plan.legs, key=lambda leg: leg.load):
        legs = list(group)
        whole = sequence(*(leg.trajectory for leg in legs))
        yield Stretch(start, first, whole, legs[0].load)
        start, first = start + whole.duration, first + len(legs)
