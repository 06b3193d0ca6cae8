"""A law whose efforts come late: the time that sensors, computing and amplifiers take."""

from __future__ import annotations

from dataclasses import dataclass

from mafsil.arrays import JointVector, single
from mafsil.control.laws.feedback import take_over
from mafsil.control.laws.law import Law, LawFunction, LawWrapper, as_law
from mafsil.errors import InputError
from mafsil.trajectory import Motion

WHOLE = 1e-6
"""How far a delay may be from a whole number of periods."""


@dataclass(frozen=True, eq=False, slots=True)
class Delayed(LawWrapper):
    """A law whose efforts act a while after the state that they answer.

    Attributes:
        law: the law itself.
        delay: from the measurement to the effort [s]; a whole number of the periods of a run.
    """

    delay: float

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Efforts (*batch, n) of the law without delay; a session keeps them back [N m | N]."""
        return self.law(t, q, qd, reference)

    def session(self, period: float) -> Law:
        """One run.

        Raises:
            InputError: the delay is no whole number of periods.
        """
        count = round(self.delay / period)
        if abs(count * period - self.delay) > WHOLE * period:
            raise InputError("control.delay", delay=self.delay, period=period)
        return _Queue(self, period, count) if count else self.law.session(period)


class _Queue:
    """One run of a delayed law: efforts wait in a queue; until the first comes, it acts already."""

    def __init__(self, law: Delayed, period: float, count: int) -> None:
        self._whole, self._law = law, law.law.session(period)
        self._count = count
        self._waiting: tuple[JointVector, ...] | None = None
        self._earlier: tuple[JointVector, ...] | None = None

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """The efforts that were asked for a delay ago (*batch, n) [N m | N]."""
        effort = self._law(t, q, qd, reference)
        before = (effort,) * (self._count + 1) if self._waiting is None else self._waiting
        self._earlier, self._waiting = self._waiting, (*before[1:], effort)
        return self._waiting[0]

    def go_on(self, before: _Queue) -> None:
        # The state at which two runs meet is seen by both.
        self._waiting = before._earlier
        take_over(self._law, before._law)

    def session(self, period: float) -> Law:
        """A new run."""
        return self._whole.session(period)


def add_delay(law: Law | LawFunction, delay: float) -> Delayed:
    """A law whose efforts act a delay after the measurement.

    Args:
        law: without delay; a function of (t, q, qd, reference) too.
        delay: a whole number of the periods of the run [s].

    Raises:
        InputError: a negative or infinite delay, or no law.
    """
    late = float(single("delay", delay, ()))
    if not 0.0 <= late < float("inf"):
        raise InputError("input.range", name="delay", value=late, low=0.0, high=float("inf"))
    return Delayed(as_law(law), late)
