"""The form of a vocabulary: what becomes of every element and attribute that a format of robot files has, by version.

Rows name an element by its tag or, where a tag means several things, by `parent/tag`. A name that a format has had only
for a while carries its versions: `quat_xyzw@1.1` from 1.1 on, `frame@1.5-1.6` no longer than 1.6. What lies below an
element that is not read as a whole is covered by its row.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

from mafsil.model.diagnostics import Fault
from mafsil.model.xml_tree import Element

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
