"""Signals of a job over time, and which way it goes by them: outputs as moves set them, inputs as cells give them."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from heapq import merge
from itertools import chain, count, islice, takewhile
from typing import Any, NamedTuple

from mafsil.job.language.description import Job
from mafsil.job.language.part import Between, Condition, Fork, SignalValue, Test
from mafsil.messages import say
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible

LONGEST_WAIT = 3600.0
"""How long is waited for a signal where a move names no time-out [s]."""
MOST_LOOKS = 200_000
"""Changes of signals at which a wait looks before it gives up."""
INSTANT = 1e-9
"""Times closer than this are the same [s]."""


class Change(NamedTuple):
    """A signal takes a value.

    Attributes:
        time: [s].
        signal: its name.
        value: from then on.
    """

    time: float
    signal: str
    value: SignalValue


@dataclass(frozen=True, slots=True)
class SignalStates:
    """Values of signals and since when, in the reader's language.

    Attributes:
        changes: the latest of each signal.
        again: those whose tables begin again, and after which time [s].
    """

    changes: tuple[Change, ...]
    again: Mapping[str, float]

    def explain(self, *, language: str | None = None) -> str:
        """`part_present is false since 6.5 s`."""
        return say("job.list_separator", language=language).join(self._say(each, language) for each in self.changes)

    def _say(self, change: Change, language: str | None) -> str:
        signal = visible(change.signal)
        if change.signal in self.again:
            every = quantity(self.again[change.signal], "s")
            return say("job.signal_again", language=language, signal=signal, every=every)
        details = {"signal": signal, "value": value_text(change.value), "since": quantity(change.time, "s")}
        return say("job.signal_since" if change.time > 0.0 else "job.signal_always", language=language, **details)


class CellSignals:
    """Every signal of a job, as far as its moves have been planned.

    Args:
        job: names the signals.
        period: of the controller, which reads and sets signals at its ticks [s].
    """

    def __init__(self, job: Job, period: float) -> None:
        self.job, self.period = job, period
        self._past = {name: [Change(0.0, name, value)] for name, value in job.output.items()}
        self._given = {
            name: [Change(0.0, name, each.start), *(Change(t, name, value) for t, value in each.changes)]
            for name, each in job.input.items()
        }

    @property
    def names(self) -> tuple[str, ...]:
        """Of outputs, then inputs."""
        return (*self.job.output, *self.job.input)

    def put(self, time: float, values: Mapping[str, SignalValue]) -> None:
        """Outputs take values at a time, not before those that they took last."""
        for name, value in values.items():
            self._past[name].append(Change(time, name, value))

    def tick_after(self, time: float, hold: float = 0.0) -> float:
        """The first tick that is at least `hold`, and at least a period, after a time [s]."""
        return math.ceil((time + max(hold, self.period)) / self.period - INSTANT) * self.period

    def tick_at(self, time: float) -> float:
        """The first tick that is not before a time [s]."""
        return math.ceil(time / self.period - INSTANT) * self.period

    def take_back(self, names: Iterable[str], time: float) -> None:
        """Outputs have not yet taken the values that they took later than a time [s]."""
        for name in names:
            self._past[name] = [change for change in self._past[name] if change.time <= time + INSTANT]

    def end_of_wait(self, time: float, wanted: Mapping[str, Condition], timeout: float | None = None) -> float | None:
        """The first tick at which all conditions hold; None if there is none before the time-out.

        A change that is over before the next tick is not seen, as by a controller.

        Args:
            time: when the wait begins [s].
            wanted: conditions on signals.
            timeout: longest wait; an hour if None [s].
        """
        first = self.tick_after(time)
        until = max(first, time + (LONGEST_WAIT if timeout is None else timeout))
        coming = merge(*(self._changes_after(name, first) for name in wanted), key=lambda change: change.time)
        for moment in islice(chain([first], (change.time for change in coming)), MOST_LOOKS):
            tick = max(first, math.ceil(moment / self.period - INSTANT) * self.period)
            if tick > until + INSTANT:
                break
            if all(holds(each, self.value(name, tick)) for name, each in wanted.items()):
                return tick
        return None

    def value(self, name: str, time: float) -> SignalValue:
        """Of a signal at a time."""
        return self.latest(name, time).value

    def latest(self, name: str, time: float) -> Change:
        """The change that gave a signal the value that it has at a time; at 0 what it begins with."""
        source = self.job.input.get(name)
        if source is not None and source.follows is not None:
            cause = self.latest(source.follows, time - source.after)
            return Change(cause.time + source.after if cause.time > 0.0 else 0.0, name, cause.value)
        begin = 0.0
        if source is not None and source.every is not None:
            begin = math.floor((time + INSTANT) / source.every) * source.every
        table = self._table(name)
        k = bisect_right(table, time - begin + INSTANT, key=lambda change: change.time) - 1
        found = table[max(k, 0)]
        return Change(begin + found.time, name, found.value)

    def last_rise(self, name: str, time: float) -> float | None:
        """When a signal last became true up to a time; None if it never did [s]."""
        begin = [self.latest(name, 0.0)]
        coming = takewhile(lambda one: one.time <= time + INSTANT, self._changes_after(name, 0.0))
        rises = [one.time for one in chain(begin, coming) if one.value is True]
        return rises[-1] if rises else None

    def states(self, names: tuple[str, ...], time: float) -> SignalStates:
        """What signals are at the end of the longest wait that begins at a time, and since when."""
        again = {name: each.every for name, each in self.job.input.items() if each.every is not None}
        return SignalStates(tuple(self.latest(name, time + LONGEST_WAIT) for name in names), again)

    def timeline(self, until: float, most: int) -> list[Change]:
        """All changes up to a time, the initial values first, in the order of time; `most` of them at most."""
        found = [self.latest(name, 0.0) for name in self.names]
        coming = merge(*(self._changes_after(name, 0.0) for name in self.names), key=lambda change: change.time)
        for change in coming:
            if change.time > until + INSTANT or len(found) >= most:
                break
            found.append(change)
        return found

    def _changes_after(self, name: str, time: float) -> Iterator[Change]:
        """Of one signal, later than a time, in order; without end where its table begins again and again."""
        source = self.job.input.get(name)
        if source is not None and source.follows is not None:
            for cause in self._changes_after(source.follows, max(time - source.after, 0.0)):
                if cause.time + source.after > time + INSTANT:
                    yield Change(cause.time + source.after, name, cause.value)
            return
        table = self._table(name)
        if source is not None and source.every is not None:
            for turn in count(math.floor(time / source.every)):
                moved = (Change(turn * source.every + one.time, name, one.value) for one in table)
                yield from (change for change in moved if change.time > time + INSTANT)
        yield from table[bisect_right(table, time + INSTANT, key=lambda change: change.time) :]

    def _table(self, name: str) -> Sequence[Change]:
        """What a signal begins with at 0, and its changes; of outputs as far as they are known."""
        return self._past[name] if name in self._past else self._given[name]


def holds(wanted: Test, value: SignalValue | str) -> bool:
    """Whether a value is what is asked for."""
    if isinstance(wanted, Between):
        return not isinstance(value, str) and wanted.holds(float(value))
    return wanted == value


def value_text(value: SignalValue | str) -> str:
    """As it is typed in a job file."""
    if isinstance(value, str):
        return f'"{visible(value)}"'
    return str(value).lower() if isinstance(value, bool) else f"{value:g}"


def assignments(values: Mapping[str, SignalValue]) -> str:
    """`close = true, speed = 2`."""
    return ", ".join(f"{visible(name)} = {value_text(value)}" for name, value in values.items())


def conditions(wanted: Mapping[str, Test]) -> str:
    """`part = true, 2 < pressure < 3`."""
    return ", ".join(_condition(visible(name), each) for name, each in wanted.items())


def _condition(name: str, wanted: Test) -> str:
    if not isinstance(wanted, Between):
        return f"{name} = {value_text(wanted)}"
    below = "" if wanted.below is None else f" < {wanted.below:g}"
    above = "" if wanted.above is None else f"{wanted.above:g} < "
    return f"{above}{name}{below}"


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
