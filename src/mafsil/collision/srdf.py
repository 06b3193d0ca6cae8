"""Semantic robot descriptions (SRDF): the file, its words, and the pairs of links that need no check."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from mafsil.errors import FileError, ModelWarning, warn
from mafsil.model.diagnostics import shown
from mafsil.model.faults import FILE_MISSING, FOREIGN_ATTRIBUTE, NOT_A_FILE, UNKNOWN_ELEMENT
from mafsil.model.reading import Reading
from mafsil.model.source import load
from mafsil.model.vocabulary import Row, Treatment, Vocabulary, audit
from mafsil.model.xml_tree import Element, Refusal, parse

ROWS: Mapping[str, Row] = MappingProxyType(
    {
        "robot": Row(
            other={Treatment.DATA: "name version"},
            children="group group_state disable_collisions",
            whole={
                Treatment.LEFT_OUT: "enable_collisions disable_default_collisions",
                Treatment.DATA: "end_effector virtual_joint passive_joint joint_property",
                Treatment.CONTACT: "link_sphere_approximation",
            },
        ),
        "group": Row("name", children="link joint chain group"),
        "link": Row("name"),
        "chain": Row("base_link tip_link"),
        "group/joint": Row("name"),
        "group_state": Row("name group", children="joint"),
        "group_state/joint": Row("name value"),
        "disable_collisions": Row("link1 link2 reason"),
    }
)
"""The words of SRDF, as srdfdom and MoveIt write and read them."""
SRDF = Vocabulary(
    "SRDF", lambda tag, parent: ROWS.get(f"{parent}/{tag}") or ROWS.get(tag), FOREIGN_ATTRIBUTE, UNKNOWN_ELEMENT,
    strict=False, is_neutral=lambda _tag, _attribute, _text: False, is_neutral_part=lambda _part: False,
)  # fmt: skip
_MOST_SHOWN = 3


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

    Warns:
        ModelWarning: misspelt and unknown words, words that are left out though they mean something, pardoned XML.

    Raises:
        FileError: no such file, or no XML.
    """
    path = Path(path)
    try:
        text = load(path)
        document = parse(text.data)
    except Refusal as refusal:
        if refusal.diagnostic.fault in (FILE_MISSING, NOT_A_FILE):
            raise FileError("collision.no_srdf", path=shown(str(path)), reason=refusal.diagnostic) from None
        raise FileError("collision.bad_srdf", path=shown(str(path)), why=refusal.diagnostic) from None
    reading = Reading(document, [*text.remarks, *document.remarks])
    audit(reading, document.root, SRDF)
    if remarks := reading.diagnostics:
        first = "; ".join(remark.line_of_text() for remark in remarks[:_MOST_SHOWN])
        warn(ModelWarning("collision.srdf_remarks", path=shown(str(path)), count=len(remarks), remarks=first))
    return document.root
