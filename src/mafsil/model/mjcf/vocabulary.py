"""Every element and attribute of MJCF, and what becomes of it: read, without bearing on a mechanism, left out.

The table is the rule of the reader: what stands in it as read is read, what it does not know is an error. `frame`,
`replicate` and `worldbody` hold what a body holds, and a default class sets attributes of the elements it names.
"""

from __future__ import annotations

from mafsil.model.faults import UNKNOWN_ATTRIBUTE, UNKNOWN_PART
from mafsil.model.vocabulary import Row, Vocabulary, read_rows

_TURN = "quat axisangle euler xyaxes zaxis"
ROWS = read_rows(__file__)
"""What becomes of everything that a file may hold, by the element and, where a tag means several things, its parent."""

MOTORS = tuple(ROWS["actuator"].children.split())
"""Elements of `actuator`; all have the row of `motor`."""

NUMBERS = frozenset(
    f"{_TURN} pos size fromto rgba mass density diaginertia fullinertia axis range ref armature damping frictionloss "
    "actuatorfrcrange group contype conaffinity fitscale shellinertia scale refpos refquat gear forcerange ctrlrange "
    "polycoef anchor relpose coef gravity count offset sep boundmass boundinertia settotalmass inertiagrouprange "
    "vertex face".split()
)
"""Attributes of numbers that are read: MuJoCo takes an empty one as not given."""

_STYLED = {
    "joint": "body/joint",
    "geom": "body/geom",
    "mesh": "asset/mesh",
    "material": "asset/material",
    "equality": "default/equality",
    "tendon": "default/tendon",
    "site": "body/site",
}


def row_of(tag: str, parent: str) -> Row | None:
    """The row of an element that is read.

    Args:
        tag: of the element.
        parent: tag of the element around it; `frame` and `replicate` hold what a body holds.
    """
    holder = "body" if parent in ("worldbody", "frame", "replicate") else parent
    if holder == "default" and tag in _STYLED:
        return ROWS[_STYLED[tag]]
    if tag in MOTORS and holder in ("actuator", "default"):
        return ROWS["actuator/motor"]
    return ROWS.get(f"{holder}/{tag}") or ROWS.get(tag)


def is_neutral(tag: str, attribute: str, text: str) -> bool:
    """Whether a value leaves things as they are: zeros, `false`, `none`, a spring that is no spring."""
    words = text.split()
    if attribute in ("limited", "actuatorfrclimited", "range", "actuatorfrcrange"):
        return tag == "default" or attribute.endswith("limited")
    return all(word.lower() in ("false", "none", "auto") or _is_zero(word) for word in words)


def _is_zero(word: str) -> bool:
    try:
        return float(word) == 0.0
    except ValueError:
        return False


MJCF = Vocabulary(
    "MJCF", row_of, UNKNOWN_ATTRIBUTE, UNKNOWN_PART, strict=True, is_neutral=is_neutral,
    is_neutral_part=lambda _part: False,
)  # fmt: skip
