"""The vocabulary of a format of robot files, by version, and the audit of a document against it.

Rows name an element by its tag or, where a tag means several things, by `parent/tag`. A name that a format has had only
for a while carries its versions: `quat_xyzw@1.1` from 1.1 on, `frame@1.5-1.6` no longer than 1.6. What lies below an
element that is not read as a whole is covered by its row. The rows of a format stand in its folder, in
`vocabulary.toml`.

Unknown names are reported with the nearest known one; names of other versions are taken out of the tree, as the
format's own reader ignores them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import lru_cache
from types import MappingProxyType
from typing import Any, NamedTuple, TypeAlias

from mafsil.model.diagnostics import Fault, Repair
from mafsil.model.faults import IGNORED_ELEMENT, NOT_KEPT, OTHER_VERSION
from mafsil.model.reading import Reading
from mafsil.model.xml_tree import Element
from mafsil.toml_source import own_tables

LONGEST = 60
"""Characters beyond which nothing is compared."""
_OTHER, _ADDED, _EXCHANGED, _STYLE = 1.0, 0.9, 0.7, 0.1
"""What it costs to type another letter, one too many or few, two exchanged; another case or sign between words."""
Version: TypeAlias = tuple[int, int]
NEWEST: Version = (1 << 30, 0)
"""Later than any version: names that are still in use end here."""


class Treatment(Enum):
    """What becomes of an attribute or of a whole element; all but the first three leave a mechanism as it is."""

    READ = "read"
    LEFT_OUT = "left out, with a warning where it is not neutral"
    SOFT = "a soft object: left out with a warning beside the robot, refused on a moving part of it"
    PICTURE = "only seen"
    CONTACT = "only where bodies touch"
    SOLVER = "only how a simulator integrates and solves"
    COMMAND = "only how a motor answers its command"
    SENSING = "only what is measured"
    MEDIUM = "only in a medium that has density or viscosity"
    SPRING = "only with a spring, which is left out"
    DATA = "only data, states or names"
    CONVERTING = "only how a simulator writes or stores the model"


class Word(NamedTuple):
    """One name of a vocabulary: what becomes of it, and the first and last version that has it."""

    treatment: Treatment
    first: Version = (0, 0)
    last: Version = NEWEST


def _nothing() -> Mapping[Treatment, str]:
    return MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Row:
    """One element: what becomes of its attributes, and of the elements inside that are not read.

    Attributes:
        read: attributes that are read.
        other: attributes by what becomes of them.
        children: elements inside that are read; each has a row of its own.
        whole: elements inside that are not read, by what becomes of them.
        extensible: whether anybody may put elements of other names inside; only misspelt ones are reported.
        judged: whether the reader itself says which elements do not belong inside.
        words: attributes by name.
        parts: elements inside by name.
    """

    read: str = ""
    other: Mapping[Treatment, str] = field(default_factory=_nothing)
    children: str = ""
    whole: Mapping[Treatment, str] = field(default_factory=_nothing)
    extensible: bool = False
    judged: bool = False
    words: Mapping[str, Word] = field(init=False)
    parts: Mapping[str, Word] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "words", _table({Treatment.READ: self.read}, self.other))
        object.__setattr__(self, "parts", _table({Treatment.READ: self.children}, self.whole))

    def treatment_of(self, attribute: str) -> Treatment | None:
        """What becomes of an attribute; None if the element has none of that name."""
        word = self.words.get(attribute)
        return None if word is None else word.treatment

    def treatment_inside(self, tag: str) -> Treatment | None:
        """What becomes of an element inside; None if none of that name may stand there."""
        word = self.parts.get(tag)
        return None if word is None else word.treatment


def _table(*groups: Mapping[Treatment, str]) -> Mapping[str, Word]:
    """Names with their meaning; a name with two meanings is a mistake of the table."""
    words: dict[str, Word] = {}
    for treatment, names in (pair for group in groups for pair in group.items()):
        for entry in names.split():
            name, _, versions = entry.partition("@")
            if name in words:
                raise ValueError(name)
            words[name] = Word(treatment, *_span(versions))
    return words


def _span(versions: str) -> tuple[Version, Version]:
    first, dash, last = versions.partition("-")
    return (_version(first) if first else (0, 0)), (_version(last) if dash else NEWEST)


def _version(text: str) -> Version:
    major, _, minor = text.partition(".")
    return int(major), int(minor)


def read_rows(module: str) -> Mapping[str, Row]:
    """The rows of `vocabulary.toml` beside a module, by what they are rows of.

    Args:
        module: path of the module's file.
    """
    tables: dict[str, dict[str, Any]] = own_tables(module, "vocabulary.toml")
    for table in tables.values():
        for kind in table.keys() & {"other", "whole"}:
            table[kind] = {Treatment[treatment.upper()]: words for treatment, words in table[kind].items()}
    return MappingProxyType({name: Row(**table) for name, table in tables.items()})


@dataclass(frozen=True, slots=True)
class Vocabulary:
    """All rows of a format, and how strict it is.

    Attributes:
        format: its name for sentences.
        row_of: the row of an element by its tag and that of the element around it; None if it is not looked at.
        unknown_attribute, unknown_part: faults of what stands in no row.
        strict: whether the format's own reader refuses what is unknown, so that a respelt name is no guess.
        is_neutral: whether an attribute that is left out leaves things as they are: tag, attribute, its text.
        is_neutral_part: the same of an element that is left out.
    """

    format: str
    row_of: Callable[[str, str], Row | None]
    unknown_attribute: Fault
    unknown_part: Fault
    strict: bool
    is_neutral: Callable[[str, str, str], bool]
    is_neutral_part: Callable[[Element], bool]


@lru_cache(maxsize=4096)
def nearest_words(word: str, known: tuple[str, ...]) -> tuple[str, ...]:
    """The known words that lie nearest to a misspelt one, all of the same distance; none if none is near.

    Letters exchanged count less than letters added or left out, and these less than other letters; case, blanks and
    underscores count nearly nothing. A word of up to five letters may have one fault, of up to three none
    of the last kind, a longer one more.
    """
    if not word or len(word) > LONGEST:
        return ()
    allowed = _ADDED if len(word) <= 3 else max(_OTHER, len(word) / 4)
    distances = {name: _distance(word, name, allowed) for name in known if abs(len(name) - len(word)) <= allowed + 1}
    least = min(distances.values(), default=allowed + 1)
    return tuple(sorted(name for name, distance in distances.items() if distance <= least)) if least <= allowed else ()


def _distance(a: str, b: str, enough: float) -> float:
    """Weighted edits between two words; more than `enough` as soon as that is certain."""
    before: list[float] = []
    row = [_step(b[:j]) for j in range(len(b) + 1)]
    for i in range(1, len(a) + 1):
        earlier, before, row = before, row, [row[0] + _gap(a[i - 1])]
        for j in range(1, len(b) + 1):
            best = min(
                before[j - 1] + _change(a[i - 1], b[j - 1]), before[j] + _gap(a[i - 1]), row[j - 1] + _gap(b[j - 1])
            )
            if i > 1 and j > 1 and a[i - 1] == b[j - 2] != a[i - 2] == b[j - 1]:
                best = min(best, earlier[j - 2] + _EXCHANGED)
            row.append(best)
        if min(row) > enough:
            return enough + 1
    return row[-1]


def _step(text: str) -> float:
    return sum(map(_gap, text))


def _gap(letter: str) -> float:
    return _STYLE if letter in "_-: ." else _ADDED


def _change(a: str, b: str) -> float:
    if a == b:
        return 0.0
    return _STYLE if a.lower() == b.lower() or {a, b} <= set("_-: .") else _OTHER


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
