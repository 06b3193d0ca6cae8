"""A planned job, driven: what happened, as arrays; or driven many times (`job.vary`): what fails how often, and why."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, PoseMatrix
from mafsil.job.language.description import Job
from mafsil.job.language.driving_tables import VariationTable
from mafsil.job.planning.limiting import CycleLimit
from mafsil.job.planning.plan import Plan
from mafsil.job.planning.stretch import Driven, Passed, stretches
from mafsil.job.remark import JobStatus, Remark
from mafsil.messages import LANGUAGES, say
from mafsil.messages.quantities import quantity
from mafsil.messages.tables import number, table
from mafsil.messages.visible import visible
from mafsil.robot import Robot
from mafsil.simulation import MonteCarlo, Recording
from mafsil.simulation.many_runs import wilson
from mafsil.simulation.variation import drawn_name

SHARES = (0.5, 0.9, 0.95, 0.99, 1.0)
"""Of the runs, up to whose worst errors are told."""
CLIPPED = 0.01
"""Share of the time with clipped efforts from which on they are taken as the cause of a missed target."""
CAUSES = ("blown_up", "loops_lost", "saturated", "not_reached")
"""Why a run fails: the motion ran away; its loops could not be followed; a target was missed while efforts were
clipped, or without that."""
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


class VariationStatus(Status):
    """Whether all runs did the job."""

    ALL_DONE = ("job.variation_all", True)
    SOME_FAILED = ("job.variation_some", False)


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class JobVariation(Answer):
    """Many runs of a job; true if each did it; iterable over the numbers of those that did not.

    Attributes:
        drawn: the runs: what was drawn, and what came out.
        asked: the table of the job.
        missed: (b,) index of the leg whose target was missed first, -1 where none was.
        legs: names of the legs.
    """

    drawn: MonteCarlo
    asked: VariationTable
    missed: NDArray[np.int64]
    legs: tuple[str, ...]

    @property
    def causes(self) -> dict[str, NDArray[np.bool_]]:
        """(b,) each: which runs failed by what; no run by two causes."""
        ended, clipped = self.drawn.outcomes.finished, self.drawn.outcomes.saturated > CLIPPED
        off, lost = ended & (self.missed >= 0), self.drawn.outcomes.lost
        return dict(zip(CAUSES, (~ended & ~lost, ~ended & lost, off & clipped, off & ~clipped), strict=True))

    @property
    def failed(self) -> NDArray[np.bool_]:
        """(b,) which runs did not do the job."""
        return np.logical_or.reduce(list(self.causes.values()))

    @property
    def runs(self) -> int:
        """How many there are."""
        return len(self.missed)

    @property
    def done(self) -> int:
        """How many did the job."""
        return self.runs - len(self)

    @property
    def status(self) -> VariationStatus:
        """Whether all did."""
        return VariationStatus.SOME_FAILED if self.failed.any() else VariationStatus.ALL_DONE

    def __len__(self) -> int:
        return int(self.failed.sum())

    def __iter__(self) -> Iterator[int]:
        return iter(np.flatnonzero(self.failed).tolist())

    def quantiles(self) -> dict[str, Floats]:
        """Values that SHARES of the runs do not exceed: tip error [m, rad], its mean square, clipped time, work [J]."""
        found = self.drawn.outcomes
        names = ("tip_error", "tip_rotation", "tip_rms", "saturated", "work")
        place = [max(0, int(np.ceil(share * len(found.end))) - 1) for share in SHARES]
        return {name: np.sort(getattr(found, name))[place] for name in names}

    def rows(self) -> list[tuple[str, ...]]:
        """The table of quantiles: a row for each quantity, with its key first."""
        units = {"tip_error": "m", "tip_rotation": "rad", "tip_rms": "m", "work": "J"}
        shown: list[tuple[str, ...]] = []
        for name, values in self.quantiles().items():
            cells = (
                "–" if not np.isfinite(value) else quantity(value, units[name]) if name in units
                else f"{number(100.0 * value)} %"
                for value in values.tolist()
            )  # fmt: skip
            shown.append((name, *cells))
        return shown

    def explain(self, language: str | None = None) -> str:
        """How many runs did the job, what the others failed by, and what goes most with the error."""
        share, low, high = wilson(self.done, self.runs)
        details = {"runs": self.runs, "done": self.done, "seed": self.asked.seed}
        percent = {"share": 100.0 * share, "low": 100.0 * low, "high": 100.0 * high}
        lines = [self.status.sentence(language, **details, **percent)]
        for name, which in self.causes.items():
            if which.any():
                lines.append(self._cause(name, which, language))
        if self.asked.bound is not None:
            within, low, high = (100.0 * x for x in self.drawn.share_within)
            bound = {"share": within, "low": low, "high": high, "bound": 1e3 * self.asked.bound}
            lines.append(say("simulation.share_within", language=language, **bound))
        strongest = next(iter(self.drawn.influence.items()), None)
        if strongest is not None:
            words = {"name": drawn_name(strongest[0], language), "correlation": strongest[1]}
            lines.append(say("simulation.influence", language=language, **words))
        return "\n".join(lines)

    def _table(self) -> list[str]:
        head = ("", *(f"{100.0 * share:g} %" for share in SHARES))
        return table(head, self.rows())

    def to_dict(self) -> dict[str, Any]:
        """Plain data: the counts, the quantiles, and every run."""
        found, causes = self.drawn.outcomes, self.causes
        return {
            "status": self.status.name.lower(),
            "runs": self.runs, "asked": self.asked.runs, "seed": self.asked.seed,
            "done": self.done, "done_share": wilson(self.done, self.runs),
            "failed_by": {name: int(which.sum()) for name, which in causes.items()},
            "missed": {name: int(count) for name, count in self._missed_legs().items()},
            "bound": self.asked.bound,
            "within_bound": None if self.asked.bound is None else self.drawn.share_within,
            "shares": SHARES,
            "quantiles": {name: _plain(values) for name, values in self.quantiles().items()},
            "influence": self.drawn.influence,
            "sentence": {language: self.explain(language) for language in ("en", "ar")},
            "each": {
                "drawn": {name: _plain(column) for name, column in self.drawn.variants.columns().items()},
                "tip_error": _plain(found.tip_error), "tip_rms": _plain(found.tip_rms),
                "saturated": _plain(found.saturated), "work": _plain(found.work), "end": _plain(found.end),
                "failed_by": [next((name for name in CAUSES if causes[name][k]), None) for k in range(self.runs)],
            },
        }  # fmt: skip

    def _cause(self, name: str, which: NDArray[np.bool_], language: str | None) -> str:
        details: dict[str, object] = {"count": int(which.sum()), "total": len(which), "first": int(which.argmax())}
        if name in ("saturated", "not_reached"):
            legs, counts = np.unique(self.missed[which], return_counts=True)
            details["move"] = self.legs[int(legs[counts.argmax()])]
        return say(f"job.variation_{name}", language=language, **details)

    def _missed_legs(self) -> dict[str, int]:
        legs, counts = np.unique(self.missed[self.missed >= 0], return_counts=True)
        return {self.legs[int(leg)]: int(count) for leg, count in zip(legs, counts, strict=True)}


def _plain(values: Floats) -> list[float | None]:
    """Numbers as JSON can hold them."""
    return [value if np.isfinite(value) else None for value in np.asarray(values, dtype=float).tolist()]
