"""YAML in which parameters of robots are written: PyYAML's safe loader with the units of xacro, bounded beforehand."""

from __future__ import annotations

import math
from typing import Any, TypeAlias, cast

from mafsil.model.xacro.expression import evaluate
from mafsil.model.xacro.fault import Budget, XacroFault

Node: TypeAlias = object
"""None, bool, int, float, str, date, list or dict of nodes."""
LARGEST = 200_000
"""Characters of a file."""
MOST_EVENTS, MOST_EVENTS_IN_PYTHON = 150_000, 15_000
"""Values and ends of collections of a file, by the parser in C and by that in Python: a second of either's time."""
DEEPEST = 40
UNITS = {
    "!radians": 1.0,
    "!degrees": math.pi / 180.0,
    "!meters": 1.0,
    "!millimeters": 0.001,
    "!foot": 0.3048,
    "!inches": 0.0254,
}
"""Tags of xacro, and what their numbers are multiplied by."""


class YamlFault(ValueError):
    """Not YAML, or more of it than a robot needs.

    Attributes:
        line: from 1.
        reason: what is wrong.
    """

    def __init__(self, line: int, reason: str) -> None:
        super().__init__(f"line {line}: {reason}")
        self.line = line
        self.reason = reason


def parsed(text: str) -> Node:
    """The value of a YAML text.

    What an alias stands for is the same object, so a small file stays small; who writes it out bounds it.

    Raises:
        YamlFault: it is no YAML, too long, nests too deeply, has a foreign tag or several documents; the line is given.
    """
    import yaml

    if len(text) > LARGEST:
        raise YamlFault(1, f"longer than {LARGEST} characters")
    try:
        fast = getattr(yaml, "CSafeLoader", None)
        loader, most = (yaml.SafeLoader, MOST_EVENTS_IN_PYTHON) if fast is None else (fast, MOST_EVENTS)
        _require_small(yaml, text, loader, most)
        return yaml.load(text, Loader=_with_units(loader))
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
        line = 1 if mark is None else min(mark.line, text.count("\n")) + 1  # the end of the text may be one line on
        raise YamlFault(line, _reason(error)) from None
    except (ValueError, OverflowError) as error:  # a date or number that is none
        if isinstance(error, YamlFault):
            raise
        raise YamlFault(1, str(error)) from None


def _reason(error: Exception) -> str:
    """The parser's own words, in one line."""
    words = getattr(error, "problem", None) or str(error)
    return " ".join(str(words).split())[:200]


def _require_small(yaml: Any, text: str, loader: Any, most: int) -> None:
    """The parser's own recursion would end in an error without a place, its time in none at all."""
    depth = 0
    for count, event in enumerate(yaml.parse(text, Loader=loader)):
        if count > most:
            raise YamlFault(event.start_mark.line + 1, f"more than {most} values")
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if depth > DEEPEST:
            raise YamlFault(event.start_mark.line + 1, "nested too deeply")


def _with_units(loader: Any) -> Any:
    """A safe loader that also knows the units."""

    class Units(loader):
        """PyYAML asks for a class."""

    for tag, factor in UNITS.items():
        Units.add_constructor(tag, _times(factor))
    return Units


def _times(factor: float) -> Any:
    def made(_loader: Any, node: Any) -> float:
        try:
            value = evaluate(str(node.value)[:200], _Pi(), Budget(1000))
            return float(cast("float", value)) * factor
        except (XacroFault, TypeError, ValueError):
            raise YamlFault(node.start_mark.line + 1, f"{node.tag} takes a number") from None

    return made


class _Pi:
    """The one name that numbers with units know."""

    def lookup(self, name: str) -> Any:
        return {"pi": math.pi}[name]

    def known(self) -> Any:
        return iter(("pi",))
