"""Every element and attribute of SDFormat 1.4 to 1.12 around a mechanism, and what becomes of it.

Facts from the specification files of libsdformat, which brings older files to its newest version before it reads them:
words of later versions are read in older files too, those that a later version gave up carry the last one that has
them. Numbers stand as text between tags.
"""

from __future__ import annotations

import re

from mafsil.model.faults import FOREIGN_ATTRIBUTE, UNKNOWN_ELEMENT
from mafsil.model.vocabulary import Row, Version, Vocabulary, read_rows
from mafsil.model.xml_tree import Element

NEWEST = (1, 12)
ROWS = read_rows(__file__)
"""What becomes of everything that a file may hold; elements without a row are text alone."""
_TEXT = Row()
_NEUTRAL = {"gravity": ("", "true", "1"), "kinematic": ("", "false", "0")}


def row_of(tag: str, _parent: str) -> Row:
    """The row of an element that is read."""
    return ROWS.get(tag, _TEXT)


def _changes_nothing(element: Element) -> bool:
    """Whether an element that is left out has the value that it has without it."""
    if element.tag in _NEUTRAL:
        return element.text.strip().lower() in _NEUTRAL[element.tag]
    return not element.text and all(child.text.strip() in ("", "0", "0.0") for child in element.children)


SDF = Vocabulary(
    "SDFormat", row_of, FOREIGN_ATTRIBUTE, UNKNOWN_ELEMENT, strict=False,
    is_neutral=lambda _tag, _attribute, _text: False, is_neutral_part=_changes_nothing,
)  # fmt: skip


def version_of(root: Element) -> Version:
    """The version that a file declares; the newest if it declares none."""
    found = re.match(r"(\d{1,3})\.(\d{1,3})", root.get("version"))
    return NEWEST if found is None else (int(found[1]), int(found[2]))
