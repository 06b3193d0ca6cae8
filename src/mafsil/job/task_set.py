"""What an arm has to do in a job, for those who design one: poses, payload, cycle and surroundings as a task set."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

import numpy as np

from mafsil.design import TaskSet
from mafsil.errors import InputError
from mafsil.job.language.reading import parse_job
from mafsil.job.language.text import text_of
from mafsil.job.remark import Refusal
from mafsil.job.solve import prepare

SAME_POSE = 1e-9
"""Largest difference of two poses [1 | m] between which the tool rests."""


def task_set(path: str | PathLike[str]) -> TaskSet:
    """The tasks of a job, planned with its own robot: where its moves end, what it carries, how long it takes.

    Poses are those of the tool's tip in {s}, each once where the tool rests; what is carried is the heaviest part, and
    the tool itself belongs to the arm that is designed.

    Args:
        path: of the job file.

    Raises:
        MafsilError: the job or its robot cannot be read, or the job cannot be planned.
    """
    place = Path(path)
    text = text_of(place)
    planned = prepare(parse_job(text, place.name, folder=place.parent), text, place.parent, source=place.name)
    if isinstance(planned, Refusal):
        raise InputError("design.job_refused", path=place.name, why=str(planned))
    plan = planned[1]
    ends = [leg.load.robot.fk(leg.trajectory.at(leg.trajectory.duration).u) for leg in plan.legs]
    poses = [T for k, T in enumerate(ends) if not k or np.abs(T - ends[k - 1]).max() > SAME_POSE]
    if len(poses) > 1 and np.abs(poses[-1] - poses[0]).max() <= SAME_POSE:
        poses.pop()
    heaviest = max(
        (leg.load.carried for leg in plan.legs if leg.load.carried), key=lambda part: part.mass, default=None
    )
    kinds = {leg.task for leg in plan.legs if leg.target is not None}
    return TaskSet(
        np.array(poses),
        "position" if kinds == {"position"} else "pose",
        payload=0.0 if heaviest is None else heaviest.mass,
        centre=(0.0, 0.0, 0.0) if heaviest is None else np.add(heaviest.offset, heaviest.com),
        period=plan.cycle,
        scene=None if plan.surroundings is None else plan.surroundings.scene,
    )
