"""When the tip of a job holds the handle of a door: from the start to the end, or from one move to another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.control.contact import Door
from mafsil.job.contact_tables import Door as DoorTable
from mafsil.job.description import Job
from mafsil.job.plan import Plan


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
