"""What all answers of inverse kinematics share: one pose or many, by closed form, by search, or along a path."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from html import escape
from typing import Any


class Answer(ABC):
    """True when what was asked for is solved within the limits, iterable, explained, plain data on request.

    Besides, each has `status` (of a batch one for each pose) and `explain(...)`, which gives its sentences.
    """

    __slots__ = ()

    @abstractmethod
    def __bool__(self) -> bool: ...

    @abstractmethod
    def __len__(self) -> int: ...

    @abstractmethod
    def __iter__(self) -> Iterator[Any]: ...

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """Plain data: names of statuses, arrays, numbers."""

    def _repr_html_(self) -> str:
        """In a notebook the sentences of `explain`, each in the direction of its language."""
        own: Any = self
        lines = str(own.explain()).split("\n")
        return "".join(f'<div dir="auto">{escape(line)}</div>' for line in lines)
