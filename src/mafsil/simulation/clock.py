"""A run against the clock: ticks begin when they are due, and late ones are counted."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from time import perf_counter, sleep
from typing import Any

from mafsil.answer import Answer, Status
from mafsil.messages import say
from mafsil.messages.quantities import quantity

AWAKE = 5e-4
"""Time before a tick that is waited without sleeping: no later does a system wake a sleeper, as a rule [s]."""


class DeadlineStatus(Status):
    """Whether a run kept up with the clock."""

    KEPT = ("simulation.deadlines_kept", True)
    MISSED = ("simulation.deadlines_missed", False)


@dataclass(frozen=True, slots=True, repr=False)
class Deadlines(Answer):
    """Deadlines of a real-time run, kept and missed; true if all were kept.

    Attributes:
        law: name of the law.
        period: of the ticks [s].
        ticks: that were timed; each is due when its period ends, law and simulated motion together.
        missed: of them.
        worst_lateness: of a missed one [s].
        law_mean, law_worst: how long the law took [s].
    """

    law: str
    period: float
    ticks: int
    missed: int
    worst_lateness: float
    law_mean: float
    law_worst: float

    @property
    def status(self) -> DeadlineStatus:
        """Whether all were kept."""
        return DeadlineStatus.MISSED if self.missed else DeadlineStatus.KEPT

    @property
    def law_is_slow(self) -> bool:
        """Whether the law alone takes longer than its period, on average."""
        return self.law_mean > self.period

    def explain(self, language: str | None = None) -> str:
        """How many deadlines were missed, by how much, and whether the law is why."""
        details = {name: quantity(getattr(self, name), "s") for name in ("period", "law_mean", "law_worst")}
        words = {"law": self.law, "ticks": self.ticks, "missed": self.missed, **details}
        sentence = self.status.sentence(language, late=quantity(self.worst_lateness, "s"), **words)
        return f"{sentence}. {say('simulation.slow_law', language=language, **words)}" if self.law_is_slow else sentence

    def to_dict(self) -> dict[str, Any]:
        """Plain data, as the metadata of a recording holds it."""
        return asdict(self)

    @classmethod
    def of(cls, metadata: Mapping[str, Any]) -> Deadlines | None:
        """From the metadata of a recording; None of a run that was not timed."""
        found = metadata.get("clock")
        return None if found is None else cls(**found)

    @classmethod
    def of_all(cls, parts: Sequence[Deadlines]) -> Deadlines:
        """Of runs that followed each other.

        Args:
            parts: at least one.
        """
        ticks = sum(part.ticks for part in parts)
        whole = sum(part.law_mean * part.ticks for part in parts)
        return cls(
            law=parts[-1].law,
            period=parts[-1].period,
            ticks=ticks,
            missed=sum(part.missed for part in parts),
            worst_lateness=max(part.worst_lateness for part in parts),
            law_mean=whole / max(ticks, 1),
            law_worst=max(part.law_worst for part in parts),
        )


class RealTime:
    """The clock of one run; after a late tick the next one begins at once, so that each delay counts once.

    Args:
        law: name of the law.
        period: of the ticks [s].
        now: the clock [s].
        rest: sleeps for some seconds.
    """

    def __init__(
        self,
        law: str,
        period: float,
        now: Callable[[], float] = perf_counter,
        rest: Callable[[float], object] = sleep,
    ) -> None:
        self._law, self._period, self._now, self._rest = law, period, now, rest
        self._due = self._began = now()
        self._ticks = self._missed = 0
        self._late = self._sum = self._worst = 0.0

    def begin(self) -> None:
        """Wait until the tick is due."""
        while (left := self._due - self._now()) > 0.0:
            if left > AWAKE:
                self._rest(left - AWAKE)
        self._began = self._now()

    def end_law(self) -> None:
        """The law has returned."""
        spent = self._now() - self._began
        self._sum, self._worst = self._sum + spent, max(self._worst, spent)
        self._ticks += 1

    def end(self) -> None:
        """All work of the tick is done."""
        end, self._due = self._now(), self._due + self._period
        if end > self._due:
            self._missed, self._late = self._missed + 1, max(self._late, end - self._due)
            self._due = end

    def deadlines(self) -> Deadlines:
        """What has been counted."""
        mean = self._sum / max(self._ticks, 1)
        return Deadlines(self._law, self._period, self._ticks, self._missed, self._late, mean, self._worst)
