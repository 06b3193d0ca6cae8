"""What stops an expansion, before it has a place in a file.

The list of parameters of a macro, such as `name parent:=world scale:=^|1.0 *origin **children`.
"""

from __future__ import annotations

import re
from time import thread_time

from mafsil.model.diagnostics import Fault
from mafsil.model.faults import XACRO_EXPRESSION, XACRO_NAME, XACRO_TOO_MUCH

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


_VALUE = r"""\$\{.*?\}|\$\(.*?\)|(?:'[^']*'|"[^"]*"|[^\s'"])+|"""
_WITH_DEFAULT = re.compile(rf"([^\s:=]+)\s*:?=\s*(\^\|?)?({_VALUE})(?=\s|$)")
_PLAIN = re.compile(r"\S+")
LONGEST = 20_000


def parameters_of(text: str) -> tuple[tuple[str, ...], dict[str, tuple[bool, str | None]]]:
    """Names and defaults.

    Args:
        text: the attribute `params`.

    Returns:
        The names in order, those of blocks with their stars; for each name with a default whether the caller's property
        of that name comes first (`^`), and the text or None.

    Raises:
        XacroFault: longer than any list of parameters.
    """
    if len(text) > LONGEST:
        raise XacroFault(XACRO_NAME, name=text)
    names: list[str] = []
    defaults: dict[str, tuple[bool, str | None]] = {}
    at = 0
    while (start := re.compile(r"\s*").match(text, at)) is not None and start.end() < len(text):
        found = _WITH_DEFAULT.match(text, start.end())
        if found is not None:
            defaults[found[1]] = (found[2] is not None, found[3] or None)
            names.append(found[1])
        else:
            found = _PLAIN.match(text, start.end())
            names.append(found[0] if found else "")
        at = found.end() if found else len(text)
    return tuple(names), defaults
