"""Sentences about a run that can be said in either language, whenever they are asked for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, Protocol, TypeAlias, runtime_checkable

from mafsil.messages import say

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
    """

    level: Level
    key: str
    details: Mapping[str, object] = field(default_factory=dict[str, object])

    def sentence(self, language: str | None = None) -> str:
        """The sentence, in `en` or `ar` or the current language."""
        return say(self.key, language=language, **{name: said(value, language) for name, value in self.details.items()})


@dataclass(frozen=True, slots=True)
class Refusal:
    """An honest no: the job is well written, but the robot cannot do it.

    Attributes:
        key: of the sentence.
        details: its values, as for Remark; they name the move and the reason.
    """

    key: str
    details: Mapping[str, object]

    def explain(self, language: str | None = None) -> str:
        """Which move, and why."""
        return say(self.key, language=language, **{name: said(value, language) for name, value in self.details.items()})


class Refused(Exception):
    """Carries a refusal out of the planner; never leaves this package."""

    def __init__(self, key: str, **details: object) -> None:
        super().__init__(key)
        self.refusal = Refusal(key, details)


def said(value: object, language: str | None) -> object:
    """A fact of a sentence: a text `@area.name` is itself a key, an object that explains itself is asked to."""
    if isinstance(value, str) and value.startswith("@"):
        return say(value[1:], language=language)
    return value.explain(language=language) if isinstance(value, Explains) else value
