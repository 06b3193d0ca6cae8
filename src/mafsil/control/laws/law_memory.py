"""What laws remember from one run to the next: integrals, learned parameters, efforts that wait, a contact."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

from mafsil.arrays import Floats, positive, require_kind
from mafsil.control.laws.feedback import Integral
from mafsil.control.laws.law import Combined, Law


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
    """What the laws of runs that follow each other hand on: each run goes on with what the last one remembers.

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
