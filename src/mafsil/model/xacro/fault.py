"""What stops an expansion, before it has a place in a file."""

from __future__ import annotations

from mafsil.model.diagnostics import Fault
from mafsil.model.faults import XACRO_EXPRESSION, XACRO_TOO_MUCH


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
    """Steps that an expansion may still take: a file that never ends is refused in a few seconds.

    Attributes:
        limit: steps in all.
        left: steps not yet taken.
    """

    def __init__(self, limit: int) -> None:
        self.limit = limit
        self.left = limit

    def spend(self, steps: int = 1) -> None:
        """Take steps.

        Raises:
            XacroFault: there are none left.
        """
        self.left -= steps
        if self.left < 0:
            raise XacroFault(XACRO_TOO_MUCH, limit=self.limit)
