"""Error feedback, and the memory that its integral needs.

What laws remember from one run to the next: integrals, learned parameters, efforts that wait, a contact.
"""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, positive, require_kind
from mafsil.control.laws.gains import Gains
from mafsil.control.laws.law import Combined, Law
from mafsil.trajectory import Motion


def pd(gains: Gains, q: JointVector, qd: JointVector, reference: Motion) -> Floats:
    """The term Kp (u - q) + Kd (v - qd), (*batch, n)."""
    return gains.kp * (reference.u - q) + gains.kd * (reference.v - qd)


class RunningSum:
    """What a law adds up from call to call.

    Attributes:
        value: of all that was added.

    Args:
        start: value before the first call.
    """

    def __init__(self, start: Floats) -> None:
        self.value = self._before = start

    def add(self, growth: Floats, most: ArrayLike = np.inf) -> Floats:
        """Add the growth of a call, and return the value.

        Args:
            growth: of this call.
            most: size that the value does not exceed.
        """
        self._before = self.value
        self.value = np.minimum(np.maximum(self.value + growth, -np.asarray(most)), most)
        return self.value

    def become(self, before: Floats, value: Floats) -> None:
        """Be a sum that was added up elsewhere.

        Args:
            before: of the last growth.
            value: with it.
        """
        self._before, self.value = before, value

    def go_on(self, before: RunningSum) -> None:
        """Go on with another sum, but for its last growth: the state at which two runs meet is seen by both.

        Args:
            before: of an earlier run.
        """
        self.value = before._before


class Integral:
    """Ki times the error summed over the control periods: the rectangle rule.

    Attributes:
        sum: of all calls.

    Args:
        gains: whose ki is used.
        period: time between calls [s].
    """

    def __init__(self, gains: Gains, period: float) -> None:
        self._weight = gains.ki * period
        self.sum = RunningSum(0.0 * gains.ki)

    def __call__(self, q: JointVector, reference: Motion) -> Floats:
        """Add the present error and return the term (*batch, n)."""
        return self.sum.add(self._weight * (reference.u - q))

    def within(self, effort: Floats, limit: Floats, q: JointVector, reference: Motion) -> Floats:
        """Effort and term together (*batch, n); the term waits where it would drive them further beyond a limit.

        Args:
            effort: (*batch, n) without the term [N m | N].
            limit: (n,) > 0.
            q: (*batch, n) measured.
            reference: that is followed.
        """
        growth = self._weight * (reference.u - q)
        ahead = effort + self.sum.value + growth
        waits = (np.abs(ahead) > limit) & (ahead * growth > 0.0)
        return effort + self.sum.add(np.where(waits, 0.0, growth))

    def go_on(self, before: Integral) -> None:
        """Go on with the term that another integral ended with, whatever its gain.

        Args:
            before: of an earlier run.
        """
        self.sum.go_on(before.sum)


@runtime_checkable
class Remembering(Protocol):
    """A session that can go on where an earlier one of its kind ended."""

    def go_on(self, before: Any) -> None:
        """Take over what the earlier session knows.

        Args:
            before: which has ended; of the same class.
        """
        ...


@runtime_checkable
class Integrating(Protocol):
    """A session of a law of joints with an integral."""

    integral: Integral


class LawMemory:
    """The memory of laws across consecutive runs.

    Without it every run begins with fresh memory. An integral is handed on as what it adds to the efforts, so that it
    does not jump where the next law has other gains.

    Attributes:
        session: of the last run, or None.
        waiting: (k, b, n) commands of the last run's end that differing delays still hold back, the latest first.
    """

    def __init__(self) -> None:
        self.session: Law | None = None
        self.waiting: Floats | None = None

    def begun(self, law: Law, period: float) -> Law:
        """The session of a run, which goes on with what the last one remembers.

        Args:
            law: of the run.
            period: between its calls [s].
        """
        require_kind("law", law, "Law", "session")
        session = law.session(positive("period", period))
        take_over(session, self.session)
        self.session = session
        return session


def take_over(session: Law, before: Law | None) -> None:
    """Let a session go on where another one ended, part by part where they are of the same kind.

    Args:
        session: that begins.
        before: that has ended, or None.
    """
    if isinstance(session, Combined) and isinstance(before, Combined):
        for part, earlier in zip(session.laws, before.laws, strict=False):
            take_over(part, earlier)
    elif isinstance(session, Remembering) and type(session) is type(before):
        session.go_on(before)


def integrals_of(session: Law) -> tuple[Integral, ...]:
    """The integrals of a session of laws of joints, part by part.

    Args:
        session: of one law, or of a sum of them.
    """
    if isinstance(session, Combined):
        return tuple(integral for part in session.laws for integral in integrals_of(part))
    return (session.integral,) if isinstance(session, Integrating) else ()
