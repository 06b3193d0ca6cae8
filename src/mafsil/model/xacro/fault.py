"""What stops an expansion, before it has a place in a file."""

from __future__ import annotations

from time import thread_time

from mafsil.model.diagnostics import Fault
from mafsil.model.faults import XACRO_EXPRESSION, XACRO_TOO_MUCH

SECONDS = 1.5
"""Of the processor, for one expansion: with reading the file and the result less than two."""
_BETWEEN_LOOKS = 500
"""Steps between two looks at the clock."""


class XacroFault(Exception):
    """A fault with its details; whoever knows the element gives it a place. Never leaves the expander.

    Attributes:
        fault: what kind.
        details: values for the sentence.
    """

    def __init__(self, fault: Fault, **details: object) -> None:
        super().__init__(fault.code)
        self.fault = fault
        self.details = details


class Reported(Exception):
    """Ends an expansion after its error was reported. Never leaves the expander."""


def wrong(reason: str) -> XacroFault:
    """An expression that has no value."""
    return XacroFault(XACRO_EXPRESSION, reason=reason)


class Budget:
    """Steps and seconds that an expansion may still take: a file that never ends is refused in a moment.

    A step is about a microsecond of a plain machine, or sixteen bytes. Steps end a text at the same place everywhere;
    the processor's time, looked at now and then, ends what costs more than its steps.

    Attributes:
        limit: steps in all.
        left: steps not yet taken.
    """

    def __init__(self, limit: int, seconds: float = SECONDS) -> None:
        self.limit = limit
        self.left = limit
        self._seconds = seconds
        self._end = thread_time() + seconds
        self._look_at = limit - _BETWEEN_LOOKS

    def spend(self, steps: int = 1) -> None:
        """Take steps.

        Raises:
            XacroFault: there are none left, or no time.
        """
        self.left -= steps
        if self.left <= self._look_at:
            self._look_at = self.left - _BETWEEN_LOOKS
            if self.left < 0 or thread_time() > self._end:
                raise XacroFault(XACRO_TOO_MUCH, limit=self.limit, seconds=self._seconds)
