"""Sentences about a job and its moves in either language, whenever they are asked for: remarks, refusals, the end."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol, TypeAlias, runtime_checkable

from mafsil.answer import Answer, Status
from mafsil.collision import ContactPair
from mafsil.job.language.description import Move
from mafsil.messages import say
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible

Level: TypeAlias = Literal["good", "warning", "failure"]
"""How good the news is."""


@runtime_checkable
class Explains(Protocol):
    """A value that can say in words what it means: outcomes of solvers, violations of limits."""

    def explain(self, *, language: str | None = None) -> str:
        """The sentence."""
        ...


@dataclass(frozen=True, slots=True)
class Remark:
    """What the reader of a report should know.

    Attributes:
        level: good, warning or failure.
        key: of the sentence.
        details: its values; a text `@area.name` is itself a key, an object that explains itself is asked to.
        cause: what it comes from, where that is proved or was looked for.
    """

    level: Level
    key: str
    details: Mapping[str, object] = field(default_factory=dict[str, object])
    cause: Explains | None = None

    def sentence(self, language: str | None = None) -> str:
        """The sentence, in `en` or `ar` or the current language."""
        what = say_with(self.key, self.details, language)
        if self.cause is None:
            return what
        return say("job.with_cause", language=language, what=what, cause=self.cause.explain(language=language))


class JobStatus(Status):
    """How a job ended."""

    DONE = ("job.status_done", True)
    FAILED = ("job.status_failed", False)
    STOPPED = ("job.status_stopped", False)
    REFUSED = ("job.status_refused", False)


@dataclass(frozen=True, slots=True)
class Refusal(Answer):
    """A well-formed job that the robot cannot do; false, and empty.

    Attributes:
        key: of the sentence.
        details: its values, as for Remark; they name the move and the reason.
    """

    key: str
    details: Mapping[str, object]

    @property
    def status(self) -> JobStatus:
        """REFUSED."""
        return JobStatus.REFUSED

    def __bool__(self) -> bool:
        return False

    def __len__(self) -> int:
        return 0

    def __iter__(self) -> Iterator[Remark]:
        return iter(())

    def __str__(self) -> str:
        return self.explain()

    def to_dict(self) -> dict[str, Any]:
        """Status, code of the sentence, and the sentence itself."""
        return {"status": "refused", "complete": False, "code": self.key, "reason": self.explain()}

    def explain(self, language: str | None = None) -> str:
        """Which move, and why."""
        return say_with(self.key, self.details, language)


@dataclass(frozen=True, slots=True)
class Meeting:
    """Two bodies that meet, or come nearer than the clearance that is kept [m], for sentences in any language."""

    contact: ContactPair
    kept: float = 0.0

    def explain(self, *, language: str | None = None) -> str:
        """Which bodies, how near, where; of what does not touch, which clearance was asked for."""
        sentence = self.contact.sentence(language)
        if not 0.0 < self.contact.distance <= self.kept:
            return sentence
        return say("job.nearer_than", language=language, contact=sentence, kept=quantity(self.kept, "m"))


def said_of(contact: ContactPair, kept: float = 0.0) -> Meeting:
    """A contact as a detail of a sentence, with the clearance that was asked for [m]."""
    return Meeting(contact, kept)


class Refused(Exception):
    """Carries a refusal out of the planner; never leaves this package."""

    def __init__(self, key: str, **details: object) -> None:
        super().__init__(key)
        self.refusal = Refusal(key, details)


def say_with(key: str, details: Mapping[str, object], language: str | None = None) -> str:
    """A sentence whose details may themselves be sentences, in a language."""
    return say(key, language=language, **{name: detail_text(value, language) for name, value in details.items()})


def detail_text(value: object, language: str | None) -> object:
    """A detail of a sentence: a text `@area.name` is itself a key, an object that explains itself is asked to."""
    if isinstance(value, str) and value.startswith("@"):
        return say(value[1:], language=language)
    return value.explain(language=language) if isinstance(value, Explains) else value


def label(index: int, move: Move, language: str | None = None) -> str:
    """`move 3 'lift'`: how sentences call a move."""
    if move.name:
        return say("job.move_named", language=language, number=index + 1, name=visible(move.name))
    return say("job.move", language=language, number=index + 1)


@dataclass(frozen=True, slots=True)
class Where:
    """A move, or the start where there is none, called in the reader's language, with its line."""

    index: int
    move: Move | None
    line: int | None = None

    def explain(self, *, language: str | None = None) -> str:
        """`move 3 'lift' (line 41)`."""
        called = say("job.start", language=language) if self.move is None else label(self.index, self.move, language)
        return called if self.line is None else say("job.at_line", language=language, what=called, line=self.line)
