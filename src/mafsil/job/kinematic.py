"""Jobs without forces: the arm follows its plan exactly, where masses are missing or nobody asks for dynamics."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from mafsil.job.description import Job
from mafsil.job.driving_tables import Controller, Simulation
from mafsil.job.equipment import Equipment, links_without_mass
from mafsil.job.lines import Path, Places
from mafsil.job.remark import Remark
from mafsil.messages.visible import visible
from mafsil.simulation.stored_arrays import KINEMATIC

TABLES = ("disturbance", "surface", "hole", "door", "guide", "variation")
"""Tables of a job that mean nothing without forces."""
MOVE_KEYS = ("process_wrench", "until_force")
"""Keys of moves that do not either."""
KEYS = ("method", "mass_error", "payload", "noise", "real_time")
"""Keys of `[simulation]` that do not either."""


def kinematic(job: Job, first: Equipment, places: Places) -> Remark | None:
    """Whether the arm follows its plan exactly, as a remark that says why and what is not judged; None if it is driven.

    Args:
        job: what is asked.
        first: the robot with the tool with which it starts.
        places: of the keys, for errors.

    Raises:
        JobError: forces are asked for, and masses are missing or the job wants none.
    """
    details = {"robot": visible(first.robot.name), "links": ", ".join(map(visible, first.light))}
    asked = job.simulation.plant == KINEMATIC
    if not asked and not first.light:
        return None
    if not asked and job.simulation.plant is not None:
        still = links_without_mass(first.robot.mechanism)
        if still:
            details["links"] = ", ".join(map(visible, still))
            raise places.error("job.no_mass", ("simulation", "plant"), **details)
        return None
    why = "asked" if asked else "masses"
    for path in _forces(job):
        raise places.error(f"job.forces_{why}", path, **details)
    ignored = job.controller != Controller(frequency=job.controller.frequency)
    return Remark("warning" if ignored or not asked else "good", f"job.kinematic_{why}", details)


def _forces(job: Job) -> Iterator[Path]:
    """The keys of a job that need forces, in their order."""
    for table in TABLES:
        if getattr(job, table):
            yield (table, 0) if isinstance(getattr(job, table), tuple) else (table,)
    for k, move in enumerate(job.move):
        yield from (("move", k, key) for key in MOVE_KEYS if getattr(move, key) is not None)
    usual = msgspec.structs.asdict(Simulation())
    for key in KEYS:
        if getattr(job.simulation, key) != usual[key]:
            yield ("simulation", key)
