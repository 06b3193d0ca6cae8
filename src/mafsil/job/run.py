"""A planned job, driven: what happened, as arrays."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mafsil.answer import Answer
from mafsil.arrays import PoseMatrix
from mafsil.job.description import Job
from mafsil.job.limiting import CycleLimit
from mafsil.job.plan import Plan
from mafsil.job.remark import Remark
from mafsil.job.status import JobStatus
from mafsil.job.stretch import Driven, Passed, stretches
from mafsil.messages import LANGUAGES
from mafsil.messages.visible import visible
from mafsil.robot import Robot
from mafsil.simulation import Recording

if TYPE_CHECKING:
    from mafsil.job.variation import JobVariation

MOST_SHOWN = 20
"""Remarks that are printed; the rest are counted."""


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class Run(Answer, entries="remarks"):
    """The result of a job; true if it was done without a failure, iterable over its findings.

    Attributes:
        job: what was asked.
        text: of the job file.
        robot: with the tool that it starts with, empty-handed.
        plan: the motion that was asked of the controller.
        recording: what happened, tick by tick.
        driven: what was simulated, stretch by stretch; nothing of a kinematic run.
        stopped: why the simulation ended early, or None.
        remarks: what the reader should know.
        limits: of the cycle: how long each decides, and what ten per cent more of it would save.
        variation: the job driven many times, where it asks for that.
    """

    job: Job
    text: str
    robot: Robot
    plan: Plan
    recording: Recording
    driven: tuple[Driven, ...]
    stopped: Remark | None = None
    remarks: tuple[Remark, ...] = field(default=())
    limits: tuple[CycleLimit, ...] = ()
    variation: JobVariation | None = None

    def tips(self, rows: slice | NDArray[np.intp] = slice(None)) -> tuple[PoseMatrix, PoseMatrix]:
        """(rows, 4, 4) poses of the tip as it was and as it should be, in {s}."""
        tape = self.recording
        return self.plan.tips(tape.t[rows], tape.q[rows]), self.plan.tips(tape.t[rows], tape.q_ref[rows])

    @property
    def passed(self) -> tuple[Passed, ...]:
        """The stretches and what was gripped in each: without forces whatever the plan takes."""
        return self.driven or tuple(Passed(stretch, gripped=True) for stretch in stretches(self.plan))

    @property
    def status(self) -> JobStatus:
        """How the job ended: by the gravest of its remarks."""
        if self.stopped is not None:
            return JobStatus.STOPPED
        failed = any(remark.level == "failure" for remark in self.remarks)
        return JobStatus.FAILED if failed else JobStatus.DONE

    def __repr__(self) -> str:
        lines = self.explain().split("\n")
        more = len(lines) - MOST_SHOWN
        return "\n".join([*lines[:MOST_SHOWN], *([f"... + {more}"] if more > 0 else [])])

    def explain(self, language: str | None = None) -> str:
        """How the job ended, then a line for each remark."""
        title = visible(self.job.title or self.robot.name)
        first = self.status.sentence(language, title=title, duration=f"{self.recording.duration:.4g}")
        return "\n".join([first, *(remark.sentence(language) for remark in self.remarks)])

    def to_dict(self) -> dict[str, Any]:
        """Plain data: status, length in time, and the remarks in every language; the numbers are in `recording`."""
        return {
            "status": self.status.name.lower(),
            "complete": self.stopped is None,
            "title": self.job.title,
            "robot": self.robot.name,
            "duration": self.recording.duration,
            "findings": [
                {
                    "level": remark.level,
                    "code": remark.key,
                    "sentence": {language: remark.sentence(language) for language in LANGUAGES},
                }
                for remark in self.remarks
            ],
        }
