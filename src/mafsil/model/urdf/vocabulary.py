"""Every element and attribute of URDF 1.0 to 1.2, and of its widespread extensions, and what becomes of it.

Facts from the schema and the parser of urdfdom 6, and from the documents of transmissions of ROS and of Drake.
"""

from __future__ import annotations

import re

from mafsil.model.diagnostics import Repair
from mafsil.model.faults import FOREIGN_ATTRIBUTE, UNKNOWN_ELEMENT, UNKNOWN_VERSION
from mafsil.model.reading import Reading
from mafsil.model.vocabulary import Row, Version, Vocabulary, read_rows
from mafsil.model.xml_tree import Element

FIRST, NEWEST = (1, 0), (1, 2)
WIDER_LIMITS = (1, 2)
"""From this version on what a `limit` does not give is infinite."""
_VERSION = re.compile(r"\s*\+?([0-9]{1,9})\.\s*\+?([0-9]{1,9})")

ROWS = read_rows(__file__)
"""What becomes of everything that a file may hold."""


def row_of(tag: str, parent: str) -> Row | None:
    """The row of an element that is read."""
    return ROWS.get(f"{parent}/{tag}") or ROWS.get(tag)


URDF = Vocabulary(
    "URDF", row_of, FOREIGN_ATTRIBUTE, UNKNOWN_ELEMENT, strict=False, is_neutral=lambda _tag, _attribute, _text: False,
    is_neutral_part=lambda _part: False,
)  # fmt: skip


def version_of(reading: Reading, robot: Element) -> Version:
    """The version that a robot declares; without one 1.0, as urdfdom has it. Others than 1.0 to 1.2 are errors."""
    text = robot.attributes.get("version")
    if text is None:
        return FIRST
    found = _VERSION.fullmatch(text)
    version = (int(found[1]), int(found[2])) if found else None
    if version is not None and FIRST <= version <= NEWEST:
        return version
    repair: Repair = reading.set_attribute(robot, "version", "1.0", guess=text.strip() != "1")
    reading.report(UNKNOWN_VERSION, robot, "version", repair, text=text)
    return NEWEST
