"""Why a plan ended as it did: a text in the present language that can be said again in the other one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol, Self, TypeAlias

from mafsil.messages import clauses, say


class Sayable(Protocol):
    """What explains itself in either language."""

    def explain(self, *, language: str | None = None) -> str:
        """The text, in `en` or `ar` or the present language."""
        ...


Part: TypeAlias = tuple[str, Mapping[str, object]] | Sayable
"""Key of a sentence in the catalogue and its values, or what explains itself."""


class Reason(str):
    """Sentences one after the other; empty without any.

    Args:
        parts: of each sentence its key and its values, or what says it.
    """

    __slots__ = ("parts",)
    parts: tuple[Part, ...]

    def __new__(cls, *parts: Part) -> Self:
        """The text in the present language."""
        found = super().__new__(cls, _say(parts, None))
        found.parts = parts
        return found

    def explain(self, language: str | None = None) -> str:
        """The text, in `en` or `ar` or the present language."""
        return _say(self.parts, language)

    def and_then(self, *others: str) -> Reason:
        """With further reasons behind it."""
        return Reason(*self.parts, *(part for other in others if isinstance(other, Reason) for part in other.parts))

    def __reduce__(self) -> tuple[Any, ...]:
        return Reason, self.parts


@dataclass(frozen=True, slots=True)
class Named:
    """What is said of something that has a name.

    Attributes:
        name: of it.
        said: of it.
    """

    name: str
    said: Sayable

    def explain(self, language: str | None = None) -> str:
        """`left: ...`."""
        return f"{self.name}: {self.said.explain(language=language)}"


@dataclass(frozen=True, slots=True)
class FirstLine:
    """The first line of a longer answer.

    Attributes:
        said: the answer.
    """

    said: Sayable

    def explain(self, language: str | None = None) -> str:
        """The line."""
        return self.said.explain(language=language).split("\n")[0]


def reason_text(reason: str, language: str | None = None) -> str:
    """A reason in a language; a plain text as it is.

    Args:
        reason: of a plan.
        language: `en` or `ar`, or the present one.
    """
    return reason.explain(language) if isinstance(reason, Reason) else reason


def _say(parts: tuple[Part, ...], language: str | None) -> str:
    return clauses([_one(part, language) for part in parts], language)


def _one(part: Part, language: str | None) -> str:
    if isinstance(part, tuple):
        key, values = part
        return say(key, language=language, **values)
    return part.explain(language=language)
