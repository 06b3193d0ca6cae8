"""Holds a document against the vocabulary: what is unknown is an error, what is left out though it acts is said."""

from __future__ import annotations

from difflib import get_close_matches

from mafsil.model.diagnostics import Repair
from mafsil.model.faults import NOT_KEPT, UNKNOWN_ATTRIBUTE, UNKNOWN_PART
from mafsil.model.mjcf.vocabulary import Row, Treatment, is_neutral, row_of
from mafsil.model.reading import Reading
from mafsil.model.xml_tree import Element

_FOREIGN = ("xmlns", "xml:", "xsi:")
"""Beginnings of attributes that belong to XML itself."""


def audit(reading: Reading, root: Element) -> None:
    """Report every element and attribute below a root that MJCF does not have or that the reader leaves out."""
    waiting = [(root, root.tag, "")]
    while waiting:
        element, tag, parent = waiting.pop()
        row = row_of(tag, parent)
        if row is None:
            continue
        _audit_attributes(reading, element, row)
        for child in reversed(element.children):
            treatment = row.treatment_inside(child.tag)
            if treatment is Treatment.READ:
                waiting.append((child, child.tag, tag))
            else:
                _audit_whole(reading, child, tag, treatment, row)


def _audit_attributes(reading: Reading, element: Element, row: Row) -> None:
    for attribute, text in element.attributes.items():
        treatment = row.treatment_of(attribute)
        if treatment is None and not attribute.startswith(_FOREIGN):
            repair = _respelled(reading, element, attribute, row)
            reading.report(
                UNKNOWN_ATTRIBUTE, element, attribute, repair, element=element.tag, attribute=attribute
            )  # fmt: skip
        elif treatment is Treatment.LEFT_OUT and not is_neutral(element.tag, attribute, text):
            reading.report(NOT_KEPT, element, attribute, element=element.tag, what=attribute)


def _audit_whole(reading: Reading, child: Element, parent: str, treatment: Treatment | None, row: Row) -> None:
    if treatment is None:
        known = ", ".join((*row.children.split(), *(name for names in row.whole.values() for name in names.split())))
        reading.report(UNKNOWN_PART, child, None, None, element=child.tag, parent=parent, known=known)
    elif treatment is Treatment.LEFT_OUT:
        reading.report(NOT_KEPT, child, None, None, element=parent, what=child.tag)


def _respelled(reading: Reading, element: Element, attribute: str, row: Row) -> Repair | None:
    """The repair that gives an attribute its nearest name, if exactly one is near and it is not there already."""
    near = get_close_matches(attribute, row.attributes, 2, 0.8)
    if len(near) != 1 or near[0] in element.attributes:
        return None
    return reading.rename_attribute(element, attribute, near[0])
