"""Every element of xacro's own and its attributes, as the xacro of ROS has them; all other elements call macros."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from mafsil.model.faults import FOREIGN_ATTRIBUTE, UNKNOWN_ELEMENT
from mafsil.model.reading import Reading
from mafsil.model.vocabulary import Row, Vocabulary, audit_attributes, nearest_words
from mafsil.model.xml_tree import Element

PREFIX = "xacro:"
DEFINITIONS = ("property", "macro", "arg")
"""Elements that leave nothing behind."""
SOURCES = (*DEFINITIONS, "include")
"""Elements that give names a meaning: where there is none, the document is finished, whatever is left in it."""
ROWS: Mapping[str, Row] = MappingProxyType(
    {
        "property": Row("name value default scope lazy_eval remove"),
        "macro": Row("name params"),
        "arg": Row("name default"),
        "include": Row("filename ns optional"),
        "if": Row("value"),
        "unless": Row("value"),
        "insert_block": Row("name"),
        "attribute": Row("name value"),
    }
)
"""Elements whose attributes are fixed."""
CONSTRUCTS = (*ROWS, "element", "call")
"""Elements of the language; the last two pass further attributes on."""

XACRO = Vocabulary(
    "xacro", lambda tag, _parent: ROWS.get(tag.removeprefix(PREFIX)), FOREIGN_ATTRIBUTE, UNKNOWN_ELEMENT, strict=False,
    is_neutral=lambda _tag, _attribute, _text: True, is_neutral_part=lambda _part: True,
)  # fmt: skip


def is_construct(element: Element) -> bool:
    """Whether an element belongs to the language, or is a misspelt one that does."""
    name = element.tag.removeprefix(PREFIX)
    return element.tag.startswith(PREFIX) and (name in CONSTRUCTS or bool(nearest_words(name, CONSTRUCTS)))


def is_source(element: Element) -> bool:
    """Whether an element gives names a meaning, or is a misspelt one that would."""
    name = element.tag.removeprefix(PREFIX)
    return element.tag.startswith(PREFIX) and (name in SOURCES or bool(nearest_words(name, SOURCES)))


def audit(reading: Reading, root: Element) -> None:
    """Report attributes that the elements of xacro do not have, with the nearest that they have."""
    for element in root.walk():
        if element.tag.startswith(PREFIX) and (row := XACRO.row_of(element.tag, "")) is not None:
            audit_attributes(reading, root, element, row, XACRO, None)
