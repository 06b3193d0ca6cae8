"""The one shape of answers: a status with its sentence, truth, iteration, plain data, and a text in notebooks."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from enum import Enum
from html import escape
from typing import TYPE_CHECKING, Any

from mafsil.errors import UnknownNameError
from mafsil.messages import say
from mafsil.messages.tables import on_screen


class Status(Enum):
    """How a computation ended. Subclasses declare members as `(sentence key, succeeded)`; this base has none.

    Attributes:
        key: name of the sentence in the message catalogue, `area.name`.
        succeeded: whether the value is an answer to the question.
    """

    def __init__(self, key: str, succeeded: bool) -> None:
        self.key = key
        self.succeeded = succeeded

    def sentence(self, language: str | None = None, **details: object) -> str:
        """The sentence of this status, in `en` or `ar` or the current language, with its details filled in."""
        return say(self.key, language=language, **details)


class Answer(ABC):
    """True when the question is answered with yes or solved, iterable where there are several, plain data on request.

    Besides, each has `status` (of a batch one for each row) and `explain(...)`, which gives its sentences.
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

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Called for a name that is not there.

            Raises:
                UnknownNameError: the sentence says which look like it, or what to write instead.
            """
            if name.startswith("_"):
                raise AttributeError(name)
            raise UnknownNameError(type(self).__name__, name, dir(self))

    def _repr_html_(self) -> str:
        """In a notebook the sentences of `explain`, each in the direction of its language."""
        own: Any = self
        lines = str(own.explain()).split("\n")
        return "".join(f'<div dir="auto">{escape(line)}</div>' for line in lines)


class SingleAnswer(Answer):
    """One answer, of length 1: true if its `status` succeeded, printed as its sentence."""

    __slots__ = ()

    def __bool__(self) -> bool:
        own: Any = self
        return bool(own.status.succeeded)

    def __len__(self) -> int:
        return 1

    def __iter__(self) -> Iterator[Any]:
        return iter((self,))

    def __repr__(self) -> str:
        return on_screen(self.explain())

    def explain(self, language: str | None = None) -> str:
        """The sentence of the status, in `en` or `ar` or the current language."""
        own: Any = self
        return str(own.status.sentence(language))
