"""The list of parameters of a macro, such as `name parent:=world scale:=^|1.0 *origin **children`."""

from __future__ import annotations

import re

from mafsil.model.faults import XACRO_NAME
from mafsil.model.xacro.fault import XacroFault

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
