"""How near a target has to be reached."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians
from typing import cast

import numpy as np

from mafsil.arrays import Floats
from mafsil.job.description import Job
from mafsil.job.language.units import angle_unit, length_unit
from mafsil.robot import Robot

POSITION, ORIENTATION = 1e-3, radians(0.5)
"""Tolerances where the job names none [m, rad]."""


@dataclass(frozen=True, eq=False, slots=True)
class Tolerances:
    """How near a target has to be reached: position [m], orientation [rad], joints (n,) [rad | m]."""

    position: float
    orientation: float
    joints: Floats


def tolerances(job: Job, robot: Robot, move: int | None = None) -> Tolerances:
    """What is allowed at the end of a move: its own tolerance, else the job's, else the defaults.

    Args:
        job, robot: what is asked; the robot with its tool.
        move: index in the job; None for what the job says in general, as for the start.
    """
    degree = angle_unit(job)
    own, general = None if move is None else job.move[move].tolerance, job.tolerance
    position, orientation, joints = (
        getattr(general, name) if own is None or getattr(own, name) is None else getattr(own, name)
        for name in ("position", "orientation", "joints")
    )
    metres = POSITION if position is None else float(position)
    angle = ORIENTATION if orientation is None else degree * float(orientation)
    revolute = robot.mechanism.angular
    if isinstance(joints, tuple):
        return Tolerances(
            metres, angle, np.array(cast("tuple[float, ...]", joints)) * np.where(revolute, degree, length_unit(job))
        )
    turn = angle if joints is None else degree * float(joints)
    return Tolerances(metres, angle, np.where(revolute, turn, metres))
