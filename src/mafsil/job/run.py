"""A planned job, driven: what happened, as arrays."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import PoseMatrix
from mafsil.job.description import Job
from mafsil.job.plan import Plan
from mafsil.job.remark import Remark
from mafsil.job.stretch import Driven
from mafsil.robot import Robot
from mafsil.simulation import Recording


@dataclass(frozen=True, eq=False, slots=True)
class Run:
    """Everything that a report needs.

    Attributes:
        job: what was asked.
        text: of the job file.
        robot: with its tool, empty-handed.
        plan: the motion that was asked of the controller.
        recording: what happened, tick by tick.
        driven: what was simulated, stretch by stretch.
        stopped: why the simulation ended early, or None.
        remarks: what the reader should know.
    """

    job: Job
    text: str
    robot: Robot
    plan: Plan
    recording: Recording
    driven: tuple[Driven, ...]
    stopped: Remark | None = None
    remarks: tuple[Remark, ...] = field(default=())

    def tips(self, rows: slice | NDArray[np.intp] = slice(None)) -> tuple[PoseMatrix, PoseMatrix]:
        """(rows, 4, 4) poses of the tip as it was and as it should be, in {s}."""
        forward = self.robot.forward_kinematics
        return np.asarray(forward(self.recording.q[rows])), np.asarray(forward(self.recording.q_ref[rows]))
