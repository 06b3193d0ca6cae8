"""Control laws side by side on one job: errors, efforts, energy, and how each bears what it does not know."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats
from mafsil.control.laws.feedback import NATURAL_FREQUENCY
from mafsil.errors import JobError
from mafsil.job.driving.laws import KINDS, kinds_for
from mafsil.job.driving.plan_simulation import simulate_plan
from mafsil.job.driving.run import Run
from mafsil.job.judging.causes import Cause, causes_of
from mafsil.job.judging.judgement import Summary, summary
from mafsil.job.judging.law_conditions import Condition, beside, conditions
from mafsil.job.language.description import Controller, Job
from mafsil.job.language.table_checks import GAINS
from mafsil.job.planning.plan import Plan
from mafsil.messages import say
from mafsil.messages.tables import number, table
from mafsil.robot import Robot
from mafsil.simulation.recording import SimulationStatus

HEAVIER = 0.2
"""Share by which all masses are larger than the law knows, under `heavier`."""
LOADED = 0.1
"""Mass at the tip that the law does not know of, under `loaded`, over that of the links behind the base."""
SLOWER = 4
"""Times as rarely is the law evaluated under `slower`."""
LATE = 2
"""Periods of the law by which its efforts come late under `late`."""
PIECES = 600
"""Of the time of the plan, each a point of the curves; fewer where they would not have two ticks each."""
CONDITIONS = ("as asked", "heavier", "loaded", "slower", "late")
"""What is tried with every law."""


class LawStatus(Status):
    """What a law made of the job as it is asked."""

    DONE = ("job.law_done", True)
    MISSED = ("job.law_missed", False)
    STOPPED = ("job.law_stopped", False)


@dataclass(frozen=True, eq=False, slots=True)
class Curves:
    """A run over time, each number the largest of its piece of the time of the plan; NaN where the run had ended.

    Attributes:
        t: (p,) middle of each piece [s].
        joint_error: of all joints [rad | m].
        tip_error: distance of the tip from its path [m].
        effort: norm over the joints [N m | N].
        force: of contact [N]; None of a job without surfaces.
    """

    t: Floats
    joint_error: Floats
    tip_error: Floats
    effort: Floats
    force: Floats | None


@dataclass(frozen=True, eq=False, slots=True)
class LawResult:
    """One law on the job.

    Attributes:
        kind: of the law, as in `[controller]`.
        status: whether the run came to its end and reached its targets.
        numbers: of the run as it is asked.
        joint_error: root mean square over time and joints, under each of CONDITIONS; NaN where the run stopped early.
        saturated: time during which it asked for more than the limits [s].
        conditions: that make the law stable, each with the number that proves it.
        curves: of the run as it is asked.
        cause: of the first thing that went wrong; None if nothing did.
    """

    kind: str
    status: LawStatus
    numbers: Summary
    joint_error: tuple[float, ...]
    saturated: float
    conditions: tuple[Condition, ...]
    curves: Curves
    cause: Cause | None

    @property
    def growth(self) -> float:
        """Largest factor by which small errors grow from tick to tick along the plan; NaN of laws without a slope."""
        return next((each.value for each in self.conditions if each.name == "sampled"), float("nan"))

    @property
    def stable(self) -> bool:
        """Whether all its conditions hold; false where none is known."""
        return bool(self.conditions) and all(each.holds for each in self.conditions)

    def name(self, language: str | None = None) -> str:
        """Of the law, in words.

        Args:
            language: `en` or `ar`; the current one if None.
        """
        return say(f"report.controller_{self.kind}", language=language)

    def explain(self, language: str | None = None) -> str:
        """What the law made of the job."""
        stopped, tried = int(np.isnan(self.joint_error).sum()), len(self.joint_error)
        key = "job.law_worst_stopped" if stopped else "job.law_worst"
        worst = say(key, language=language, worst=max(self.joint_error), stopped=stopped, tried=tried)
        details = {
            "law": self.name(language),
            "error": self.joint_error[0],
            "tip": self.numbers.tip_error,
            "worst": worst,
        }
        return self.status.sentence(language, **details)

    @property
    def peak_force(self) -> float:
        """Largest force of contact [N]; NaN of a job without surfaces."""
        return float("nan") if self.numbers.touching is None else self.numbers.touching.peak

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        own = self.numbers
        return {
            "kind": self.kind, "status": self.status.name.lower(), "tip_error": _plain(own.tip_error),
            "energy": _plain(own.energy), "rms_effort": [_plain(x) for x in own.rms_effort.tolist()],
            "peak_effort": [_plain(x) for x in own.peak_effort.tolist()], "saturated": self.saturated,
            "contact": None if own.touching is None else own.touching.to_dict(),
            "growth": _plain(self.growth),
            "stability": [each.to_dict() for each in self.conditions],
            "joint_error": {name: _plain(each) for name, each in zip(CONDITIONS, self.joint_error, strict=True)},
            "cause": None if self.cause is None else self.cause.explain(language="en"),
        }  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class LawBench(Answer, entries="results", data="laws=results"):
    """Control laws compared on one job; true if each did it, iterable over the results, the smallest error first.

    Attributes:
        results: of the laws.
    """

    results: tuple[LawResult, ...]

    @property
    def status(self) -> tuple[LawStatus, ...]:
        """Of each law."""
        return tuple(each.status for each in self.results)

    def __bool__(self) -> bool:
        return all(each.status.succeeded for each in self.results)

    def _table(self) -> list[str]:
        return table(*self.columns())

    def columns(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """Head and rows: errors under each condition, tip error, contact force, effort and its peak, energy, growth."""
        head = ("", *CONDITIONS, "tip", "force", "effort", "peak", "energy", "growth")
        rows = [
            (
                each.kind, *(number(x) for x in each.joint_error), number(each.numbers.tip_error),
                number(each.peak_force), number(float(np.linalg.norm(each.numbers.rms_effort))),
                number(float(each.numbers.peak_effort.max(initial=0.0))),
                number(each.numbers.energy),
                beside(each.growth, 1.0) if np.isfinite(each.growth) else number(each.growth),
            )
            for each in self.results
        ]  # fmt: skip
        return head, rows

    def explain(self, language: str | None = None) -> str:
        """A line for each law: what it made of the job; where its error comes from; what proves it stable."""
        lines: list[str] = []
        for each in self.results:
            lines.append(each.explain(language))
            if each.cause is not None:
                lines.append(f"  {each.cause.explain(language=language)}")
            lines += [f"  {one.explain(language=language)}" for one in each.conditions]
        return "\n".join(lines)


def bench_laws(
    job: Job,
    text: str,
    robot: Robot,
    plan: Plan,
    kinds: Sequence[str] | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> LawBench:
    """Simulate a planned job under several control laws, nominally and under four unmodelled conditions.

    Laws get the gains that the job gives them, else those that fit the arm; computed torque then the natural frequency
    that the others ask for, so that bandwidths are alike. `heavier`: all masses are 20 per cent larger; `loaded`: a
    tenth of the mass of the links hangs at the tip besides; `slower`: the law is evaluated four times as rarely;
    `late`: its efforts come two periods late. Nothing is driven against the clock.

    Args:
        job, text: what is asked, and its file.
        robot: with its tool.
        plan: the motion.
        kinds: of the laws; if None, those of the joints, and those of the tip where the job has a surface.
        progress: called with the share that is done.

    Raises:
        JobError: an unknown law.
    """
    if plan.kinematic:
        raise JobError("job.bench_kinematic")
    kinds = kinds_for(job) if kinds is None else kinds
    if "hybrid" in kinds and not job.surface:
        raise JobError("job.bench_surface")
    unknown = [kind for kind in kinds if kind not in KINDS]
    if unknown:
        raise JobError("job.unknown_law", law=unknown[0], known=", ".join(KINDS))
    found: list[LawResult] = []
    for k, kind in enumerate(kinds):
        runs: list[Run] = []
        for c, changed in enumerate(_conditions(_with_law(job, kind), robot)):
            runs.append(simulate_plan(changed, text, robot, plan))
            if runs[-1].recording.status is SimulationStatus.INTERRUPTED:
                raise KeyboardInterrupt
            progress((k + (c + 1) / len(CONDITIONS)) / len(kinds))
        found.append(_result(kind, runs))
    return LawBench(tuple(sorted(found, key=lambda each: (not each.status.succeeded, each.joint_error[0]))))


def _with_law(job: Job, kind: str) -> Job:
    """The job with another law; gains of its own law have no meaning for others."""
    own = job.controller
    kept = {name: getattr(own, name) for name in (*GAINS[kind], "friction")} if kind == own.kind else {}
    if kind == "computed_torque" and kept.get("frequency") is None:
        kept["frequency"] = NATURAL_FREQUENCY
    simulated = msgspec.structs.replace(job.simulation, real_time=False)
    controller = Controller(kind=kind, rate=own.rate, delay=own.delay, **kept)  # pyright: ignore[reportArgumentType]
    return msgspec.structs.replace(job, controller=controller, simulation=simulated)


def _conditions(job: Job, robot: Robot) -> list[Job]:
    """The job as it is asked, and under the other conditions."""
    own, simulated, period = job.controller, job.simulation, job.control_period
    heavier = msgspec.structs.replace(simulated, mass_error=(1.0 + simulated.mass_error) * (1.0 + HEAVIER) - 1.0)
    links = sum(link.inertial.mass for link in robot.mechanism.links[1:] if link.inertial is not None)
    loaded = msgspec.structs.replace(simulated, payload=simulated.payload + LOADED * links)
    slower = msgspec.structs.replace(own, rate=1.0 / (SLOWER * period), delay=0.0)
    late = msgspec.structs.replace(own, delay=own.delay + LATE * period)
    return [
        job,
        msgspec.structs.replace(job, simulation=heavier),
        msgspec.structs.replace(job, simulation=loaded),
        msgspec.structs.replace(job, controller=slower),
        msgspec.structs.replace(job, controller=late),
    ]


def _result(kind: str, runs: list[Run]) -> LawResult:
    first = runs[0]
    numbers = summary(first)
    if not first.recording:
        status = LawStatus.STOPPED
    else:
        status = LawStatus.DONE if all(each.reached for each in numbers.arrivals) else LawStatus.MISSED
    errors = tuple(_rms(run) if run.recording else float("nan") for run in runs)
    reason = next(iter(causes_of(first).values()), None)
    saturated = float(numbers.saturated.max(initial=0.0))
    return LawResult(kind, status, numbers, errors, saturated, conditions(first), _curves(first), reason)


def _curves(run: Run) -> Curves:
    """The run in pieces of the time of its plan."""
    tape, ticks = run.recording, run.plan.duration / run.driven[0].scenario.control_period
    count = int(np.clip(ticks / 2.0, 1, PIECES))
    edges = np.linspace(0.0, run.plan.duration, count + 1)
    piece = np.clip(np.searchsorted(edges, tape.t, side="right") - 1, 0, count - 1)

    def largest(values: Floats) -> Floats:
        found = np.full(count, -np.inf)
        np.maximum.at(found, piece, values)
        return np.where(np.isfinite(found), found, np.nan)

    wrench = tape.contact_wrench
    return Curves(
        (edges[:-1] + edges[1:]) / 2.0,
        largest(np.abs(tape.q_ref - tape.q).max(axis=1)),
        largest(tape.tip_position_error),
        largest(np.linalg.norm(tape.tau, axis=1)),
        None if wrench is None else largest(np.linalg.norm(wrench[:, 3:], axis=1)),
    )


def _rms(run: Run) -> float:
    error = run.recording.q_ref - run.recording.q
    return float(np.sqrt(np.mean(error**2)))


def _plain(value: float) -> float | None:
    return value if np.isfinite(value) else None
