"""A stretch of the plan: legs in a row while the same things hang on the flange, in the hand, on the door's handle."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from mafsil.control.contact import Door
from mafsil.job.language.description import Grasp, Job
from mafsil.job.language.surrounding_tables import Door as DoorTable
from mafsil.job.planning.equipment import Load
from mafsil.job.planning.plan import Plan
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


@dataclass(frozen=True, eq=False, slots=True)
class Grip:
    """A door, and while which legs of a plan the tip holds its handle.

    Attributes:
        table: of the job.
        door: shut where the tip takes the handle.
        first, last: legs, both held.
        start, end: in the time of the plan [s].
    """

    table: DoorTable
    door: Door
    first: int
    last: int
    start: float
    end: float

    def holds(self, leg: int) -> bool:
        """Whether the handle is held during a leg."""
        return self.first <= leg <= self.last


def grips(job: Job, plan: Plan) -> tuple[Grip, ...]:
    """The doors of a job that are held at some time; one whose moves are on a way that is not taken is not.

    Args:
        job: with its doors.
        plan: of its moves.
    """
    ends = np.cumsum([leg.trajectory.duration for leg in plan.legs])
    found: list[Grip] = []
    for one in job.door:
        begun = _legs_of(job, plan, one.grip) if one.grip else [0]
        if not begun:
            continue
        over = [k for k in _legs_of(job, plan, one.release) if k >= begun[0]] if one.release else []
        first, last = begun[0], over[0] if over else len(plan.legs) - 1
        leg = plan.legs[first]
        start = float(ends[first] - leg.trajectory.duration)
        handle = leg.load.robot.forward_kinematics(leg.trajectory.at(0.0).u)
        door = Door(
            np.array(one.hinge), np.array(one.axis), handle, one.stiffness, one.damping, one.rotational_stiffness,
            one.rotational_damping, one.friction, one.closer,
        )  # fmt: skip
        found.append(Grip(one, door, first, last, start, float(ends[last])))
    return tuple(found)


def _legs_of(job: Job, plan: Plan, name: str) -> list[int]:
    """The legs in which moves of a name are made, also within one that goes on without a stop."""
    named = [k for k, move in enumerate(job.move) if move.name == name]
    found: list[int] = []
    before = -1
    for k, leg in enumerate(plan.legs):
        made = range(before + 1 if leg.kind == "blended" else leg.index, leg.index + 1)
        if any(index in made for index in named):
            found.append(k)
        before = leg.index
    return found
