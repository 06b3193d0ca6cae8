"""TOML from strangers: what would take the parser minutes is refused before it sees it."""

from __future__ import annotations

import re
import tomllib
from typing import Any

from mafsil.messages import say

LONGEST_KEY = 32
"""Most parts of a dotted key: the parser's time and memory grow with their square."""

_PART = r"""(?:(?<![\w-])[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_LONG_KEY = re.compile(rf"{_PART}(?:[ \t]*+\.[ \t]*+(?:[\w-]++|\"[^\"\n]*+\"|'[^'\n]*+')){{{LONGEST_KEY}}}")


def parsed_toml(text: str) -> dict[str, Any]:
    """The tables of a TOML text.

    Args:
        text: of a file whose size the caller has bounded.

    Raises:
        ValueError: it is no TOML, or a key has more than LONGEST_KEY parts, or it nests too deeply; the sentence says
            where.
    """
    found = _LONG_KEY.search(text)
    if found:
        line = text.count("\n", 0, found.start()) + 1
        raise ValueError(say("input.toml_key", line=line, limit=LONGEST_KEY))
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError(say("input.toml_depth")) from None
