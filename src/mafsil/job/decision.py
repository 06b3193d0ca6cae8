"""Which way a job went where it divides, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from mafsil.job.cell_signals import CellSignals, Change, conditions, holds, value_text
from mafsil.job.description import Job
from mafsil.job.signals import Fork, SignalValue
from mafsil.messages import say
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible


class Known(NamedTuple):
    """The value of a variable.

    Attributes:
        variable: its name.
        value: in this job.
    """

    variable: str
    value: SignalValue | str


@dataclass(frozen=True, slots=True)
class Decision:
    """Whether the tests of a fork hold, and why.

    Attributes:
        fork: where the way divides.
        holds: whether all of its tests do.
        reasons: the signals and variables that decide: all where all tests hold, else those that do not fit.
    """

    fork: Fork
    holds: bool
    reasons: tuple[Change | Known, ...]

    def explain(self, *, language: str | None = None) -> str:
        """`part_ok = true holds: part_ok is true since 2 s`."""
        why = say("job.list_separator", language=language).join(_say(each, language) for each in self.reasons)
        return say(f"job.test_{str(self.holds).lower()}", language=language, tests=conditions(self.fork.tests), why=why)

    def to_dict(self) -> dict[str, Any]:
        """Plain data: the tests as typed, whether they hold, what decided."""
        return {
            "tests": conditions(self.fork.tests),
            "holds": self.holds,
            "reasons": [dict(each._asdict()) for each in self.reasons],
        }


def decide_fork(job: Job, fork: Fork, signals: CellSignals, time: float) -> Decision:
    """The way that is taken at a fork.

    Args:
        job: with its variables.
        fork: of one of its moves.
        signals: as far as they are known.
        time: of the tick at which the controller looks [s].
    """
    values = _values(job, fork, signals, time)
    against = tuple(each for name, each in values.items() if not holds(fork.tests[name], each.value))
    return Decision(fork, not against, against or tuple(values.values()))


def _values(job: Job, fork: Fork, signals: CellSignals, time: float) -> Mapping[str, Change | Known]:
    found: dict[str, Change | Known] = {}
    for name in fork.tests:
        value = job.variables.get(name)
        found[name] = signals.latest(name, time) if value is None or isinstance(value, tuple) else Known(name, value)
    return found


def _say(reason: Change | Known, language: str | None) -> str:
    if isinstance(reason, Known):
        details = {"signal": visible(reason.variable), "value": value_text(reason.value)}
        return say("job.variable_is", language=language, **details)
    details = {"signal": visible(reason.signal), "value": value_text(reason.value)}
    if reason.time > 0.0:
        return say("job.signal_since", language=language, **details, since=quantity(reason.time, "s"))
    return say("job.signal_first", language=language, **details)
