"""Holds a document against the vocabulary of its format: what is unknown, left out or of another version is said.

Unknown names are reported with the nearest known one; names of other versions are taken out of the tree, as the
format's own reader ignores them.
"""

from __future__ import annotations

from collections.abc import Iterable

from mafsil.model.diagnostics import Repair
from mafsil.model.faults import IGNORED_ELEMENT, NOT_KEPT, OTHER_VERSION
from mafsil.model.nearest_word import nearest_words
from mafsil.model.reading import Reading
from mafsil.model.vocabulary import Row, Treatment, Version, Vocabulary, Word
from mafsil.model.xml_tree import Element

_FOREIGN = ("xmlns", "xml:", "xsi:")
_KNOWN = "drake:"
"""A prefix whose words the vocabularies hold: others under it are slips."""
"""Beginnings of attributes that belong to XML itself."""
_MOST_KNOWN = 12
"""Names listed where none is near."""


def audit(reading: Reading, root: Element, vocabulary: Vocabulary, version: Version | None = None) -> None:
    """Report every element and attribute below a root that a format does not have or that its reader leaves out.

    Args:
        reading: of the file.
        root: of the part that is looked at.
        vocabulary: of the format.
        version: of the file; None takes the words of all versions.
    """
    waiting = [(root, "")]
    while waiting:
        element, parent = waiting.pop()
        row = vocabulary.row_of(element.tag, parent)
        if row is None:
            continue
        audit_attributes(reading, root, element, row, vocabulary, version)
        inside: list[Element] = []
        for child in [*element.children]:
            word = row.parts.get(child.tag)
            if word is None:
                _report_unknown_part(reading, child, element.tag, row, vocabulary)
            elif _is_of_another_version(reading, root, child, None, word, version):
                element.children.remove(child)
            elif word.treatment is Treatment.READ:
                inside.append(child)
            elif word.treatment is Treatment.LEFT_OUT and not vocabulary.is_neutral_part(child):
                reading.report(NOT_KEPT, child, None, None, element=element.tag, what=child.tag)
        waiting.extend((child, element.tag) for child in reversed(inside))


def audit_attributes(
    reading: Reading, root: Element, element: Element, row: Row, vocabulary: Vocabulary, version: Version | None
) -> None:
    """Report the attributes of one element.

    Args:
        reading, root, vocabulary, version: as of `audit`.
        element: the one.
        row: of it.
    """
    for attribute, text in [*element.attributes.items()]:
        word = row.words.get(attribute)
        if word is None:
            _report_unknown_attribute(reading, element, attribute, row, vocabulary)
        elif _is_of_another_version(reading, root, element, attribute, word, version):
            del element.attributes[attribute]
        elif word.treatment is Treatment.LEFT_OUT and not vocabulary.is_neutral(element.tag, attribute, text):
            reading.report(NOT_KEPT, element, attribute, element=element.tag, what=attribute)


def _is_of_another_version(
    reading: Reading, root: Element, element: Element, attribute: str | None, word: Word, version: Version | None
) -> bool:
    """Whether a name belongs to other versions than the file's, which is reported."""
    if version is None or word.first <= version <= word.last:
        return False
    name = element.tag if attribute is None else attribute
    bound = _written(word.first if version < word.first else word.last)
    repair = reading.set_attribute(root, "version", bound, guess=True)
    reading.report(
        OTHER_VERSION, element, attribute, repair,
        element=element.tag, what=name, bound=bound, version=_written(version),
    )  # fmt: skip
    return True


def _written(version: Version) -> str:
    return f"{version[0]}.{version[1]}"


def _report_unknown_attribute(
    reading: Reading, element: Element, attribute: str, row: Row, vocabulary: Vocabulary
) -> None:
    if attribute.startswith(_FOREIGN):
        return
    near = nearest_words(attribute, tuple(row.words))
    if ":" in attribute and not near:
        return  # an extension under a prefix of its own
    repair = _respelt(reading, element, attribute, near, guess=not vocabulary.strict)
    reading.report(
        vocabulary.unknown_attribute, element, attribute, repair,
        element=element.tag, attribute=attribute, format=vocabulary.format, known=_list(near or row.words),
    )  # fmt: skip


def _report_unknown_part(reading: Reading, child: Element, parent: str, row: Row, vocabulary: Vocabulary) -> None:
    near = nearest_words(child.tag, tuple(row.parts))
    if row.extensible and not near:
        reading.report(IGNORED_ELEMENT, child, element=child.tag)
    elif near or not (row.judged or (":" in child.tag and not child.tag.startswith(_KNOWN) and not vocabulary.strict)):
        reading.report(
            vocabulary.unknown_part, child, None, None,
            element=child.tag, parent=parent, format=vocabulary.format, known=_list(near or row.parts),
        )  # fmt: skip


def _respelt(
    reading: Reading, element: Element, attribute: str, near: tuple[str, ...], *, guess: bool
) -> Repair | None:
    """The repair that gives an attribute its nearest name, if exactly one is near and it is not there already."""
    if len(near) != 1 or near[0] in element.attributes:
        return None
    return reading.rename_attribute(element, attribute, near[0], guess=guess)


def _list(names: Iterable[str]) -> str:
    found = list(names)
    return ", ".join(found[:_MOST_KNOWN]) + (", ..." if len(found) > _MOST_KNOWN else "") or "-"
