"""A stretch of the plan: legs that follow each other while the same things hang on the flange and in the hand."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby

from mafsil.control.contact import Door
from mafsil.job.description import Grasp
from mafsil.job.door_grips import Grip
from mafsil.job.equipment import Load
from mafsil.job.plan import Plan
from mafsil.simulation import Scenario
from mafsil.trajectory import Trajectory, sequence


@dataclass(frozen=True, eq=False, slots=True)
class Stretch:
    """Legs during which tool, part and the handles that are held should be the same.

    Attributes:
        start: in the time of the plan [s].
        first: index of its first leg.
        trajectory: of all its legs.
        load: what the plan has on the flange.
        doors: whose handles the tip holds.
    """

    start: float
    first: int
    trajectory: Trajectory
    load: Load
    doors: tuple[Door, ...] = ()

    @property
    def carried(self) -> Grasp | None:
        """What the plan has in the tool."""
        return self.load.carried


@dataclass(frozen=True, eq=False, slots=True)
class Passed:
    """A stretch as it was passed.

    Attributes:
        stretch: what was planned.
        gripped: whether the part that the plan holds was really taken; true where it holds none.
    """

    stretch: Stretch
    gripped: bool

    @property
    def carried(self) -> Grasp | None:
        """What the tool really carried."""
        return self.stretch.carried if self.gripped else None


@dataclass(frozen=True, eq=False, slots=True)
class Driven(Passed):
    """A stretch as it was simulated.

    Attributes:
        scenario: what was simulated: true arm, model, law, pushes.
    """

    scenario: Scenario


def stretches(plan: Plan, held: tuple[Grip, ...] = ()) -> Iterator[Stretch]:
    """The stretches of a plan, in order.

    Args:
        plan: of all moves.
        held: doors whose handles the tip holds at some time.
    """

    def kept(k: int) -> tuple[Load, tuple[bool, ...]]:
        return plan.legs[k].load, tuple(each.holds(k) for each in held)

    start, first = 0.0, 0
    for _, group in groupby(range(len(plan.legs)), key=kept):
        legs = [plan.legs[k] for k in group]
        whole = sequence(*(leg.trajectory for leg in legs))
        yield Stretch(start, first, whole, legs[0].load, tuple(each.door for each in held if each.holds(first)))
        start, first = start + whole.duration, first + len(legs)
