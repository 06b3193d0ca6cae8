"""Semantic robot descriptions (SRDF): the file, and the pairs of links that need no check."""

from __future__ import annotations

from pathlib import Path

from mafsil.errors import FileError
from mafsil.model.diagnostics import shown
from mafsil.model.xml_tree import Element, Refusal, parse


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
        return parse(path.read_bytes()).root
    except OSError:
        raise FileError("collision.no_srdf", path=shown(str(path))) from None
    except Refusal as refusal:
        raise FileError("collision.bad_srdf", path=shown(str(path)), why=refusal.diagnostic.sentence()) from None
