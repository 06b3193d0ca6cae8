"""Semantic robot descriptions (SRDF): the file, and the pairs of links that need no check."""

from __future__ import annotations

from pathlib import Path

from mafsil.errors import FileError
from mafsil.model.diagnostics import shown
from mafsil.model.xml_tree import Element, Refusal, parse
from mafsil.regular_file import reason, whole_bytes

MOST_BYTES = 50_000_000
"""Of an SRDF file, by far more than any has."""


def disabled_pairs(path: str | Path) -> dict[frozenset[str], str]:
    """Unordered pairs of link names of an SRDF file, with the reason that it gives.

    Args:
        path: of the file, with elements `disable_collisions link1 link2 reason`.

    Raises:
        FileError: no such file, or no XML.
    """
    return {
        frozenset((each.get("link1"), each.get("link2"))): each.get("reason")
        for each in read(path).walk()
        if each.tag == "disable_collisions"
    }


def read(path: str | Path) -> Element:
    """The root of an SRDF file.

    Raises:
        FileError: no such file, or no XML.
    """
    path = Path(path)
    try:
        return parse(whole_bytes(path, MOST_BYTES)).root
    except (OSError, ValueError) as fault:
        raise FileError("collision.no_srdf", path=shown(str(path)), reason=reason(fault)) from None
    except Refusal as refusal:
        raise FileError("collision.bad_srdf", path=shown(str(path)), why=refusal.diagnostic.sentence()) from None
