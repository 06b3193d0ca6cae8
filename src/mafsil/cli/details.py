"""Named values as lines for people, such as those of a computer or of an exported file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

from mafsil.messages import say


def details(values: Mapping[str, Any]) -> list[str]:
    """A line for each fact, named in the reader's language; variables of the environment keep their names.

    Args:
        values: plain data by name.
    """
    lines: list[str] = []
    for name, value in values.items():
        label = name if name.isupper() else say(f"cli.fact_{name}")
        parts: list[Any] = list(cast("list[Any]", value)) if isinstance(value, list | tuple) else [value]
        words = [say("cli.yes" if part else "cli.no") if isinstance(part, bool) else str(part) for part in parts]
        lines.append(f"  {label}: {', '.join(words)}")
    return lines
