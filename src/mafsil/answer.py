"""The one shape of answers. A class declares what it shows; truth, length, iteration, data and texts follow from that.

class Certificate(Answer, data="proven real radius"): ...     one answer, true if its status succeeded
class Curves(Answer, entries="curves", data="hits"): ...      as long as its curves, iterated over them
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from html import escape
from operator import attrgetter
from typing import TYPE_CHECKING, Any

from mafsil.errors import UnknownNameError
from mafsil.messages import placeholders, say
from mafsil.messages.tables import in_notebook, on_screen


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


class Answer:
    """True when the question is answered with yes or solved, iterable where there are several, plain data on request.

    Subclasses have `status` (of a batch one for each row). In the sentences of statuses `{name}` is the attribute of
    that name; who needs other details writes `explain`.

    Args:
        data: names of the attributes that `to_dict` shows beside the status, after those of the base class; what
            shall have another name there, or lies deeper, is `name=attribute.of.it`.
        entries: name of the attribute that holds the several things found; without it the answer is one.
    """

    __slots__ = ()
    _data: tuple[str, ...] = ()
    _entries: str = ""

    def __init_subclass__(cls, *, data: str = "", entries: str = "", **more: Any) -> None:
        # A dataclass with slots is made a second time, without these words: what it has stays.
        super().__init_subclass__(**more)
        if data:
            cls._data += tuple(data.split())
        if entries:
            cls._entries = entries

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Called for a name that is not there.

            Raises:
                UnknownNameError: the sentence says which look like it, or what to write instead.
            """
            if name.startswith("_"):
                raise AttributeError(name)
            raise UnknownNameError(type(self).__name__, name, dir(self))

    def __bool__(self) -> bool:
        return bool(_status(self).succeeded)

    def __len__(self) -> int:
        return len(getattr(self, self._entries)) if self._entries else 1

    def __iter__(self) -> Iterator[Any]:
        return iter(getattr(self, self._entries) if self._entries else (self,))

    def __repr__(self) -> str:
        return "\n".join([on_screen(self.explain()), *self._table()])

    def _repr_html_(self) -> str:
        """In a notebook the sentences of `explain`, each in the direction of its language, then the table."""
        lines = "".join(f'<div dir="auto">{escape(line)}</div>' for line in self.explain().split("\n"))
        shown = self._table()
        return lines + in_notebook("\n".join(shown)) if shown else lines

    def _table(self) -> list[str]:
        """Lines of the table that is printed below the sentences, if there is one."""
        return []

    def explain(self, language: str | None = None) -> str:
        """The sentence of the status, in `en` or `ar` or the current language."""
        status = _status(self)
        details = {name: getattr(self, name) for name in placeholders(status.key, language)}
        return str(status.sentence(language, **details))

    def to_dict(self) -> dict[str, Any]:
        """Plain data: names of statuses in small letters, numbers, texts, lists, dictionaries; arrays as they are."""
        pairs = (word.partition("=") for word in self._data)
        shown = {name: plain(attrgetter(path or name)(self)) for name, _, path in pairs}
        return {"status": plain(_status(self))} | shown


def _status(answer: Any) -> Any:
    return answer.status


def plain(value: Any) -> Any:
    """A value of an answer as plain data: enums by name, answers and records by their fields, arrays as they are."""
    if _is(value, Enum):
        return value.name.lower()
    if hasattr(value, "to_dict"):
        return value.to_dict()
    if hasattr(value, "_asdict"):
        return plain(value._asdict())
    if _is(value, Mapping):
        return {name: plain(each) for name, each in value.items()}
    if _is(value, tuple, list):
        return [plain(each) for each in value]
    if is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    of_objects = getattr(getattr(value, "dtype", None), "hasobject", False)
    return plain(value.ravel().tolist()) if of_objects else value


def _is(value: Any, *kinds: type) -> bool:
    return isinstance(value, kinds)
