"""Why a plan ended as it did: a text in the present language that can be said again in the other one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self, TypeAlias

from mafsil.messages import say

Part: TypeAlias = tuple[str, Mapping[str, object]]
"""Key of a sentence in the catalogue, and its values."""


class Reason(str):
    """Sentences one after the other; empty without any.

    Args:
        parts: of each sentence its key and its values.
    """

    __slots__ = ("parts",)
    parts: tuple[Part, ...]

    def __new__(cls, *parts: Part) -> Self:
        """The text in the present language."""
        found = super().__new__(cls, _said(parts, None))
        found.parts = parts
        return found

    def explain(self, language: str | None = None) -> str:
        """The text, in `en` or `ar` or the present language."""
        return _said(self.parts, language)

    def and_then(self, *others: str) -> Reason:
        """With further reasons behind it."""
        return Reason(*self.parts, *(part for other in others if isinstance(other, Reason) for part in other.parts))

    def __reduce__(self) -> tuple[Any, ...]:
        return Reason, self.parts


def _said(parts: tuple[Part, ...], language: str | None) -> str:
    return "; ".join(say(key, language=language, **values) for key, values in parts)
