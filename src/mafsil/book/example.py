"""Worked examples of the book by number: live objects, printed numbers, ours, and errata."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from mafsil.book.entry import Entry, EntryStatus, Fact, Index

Worked = tuple[Mapping[str, Any], Iterable[Fact]]
"""Objects by name and facts of an example."""


@dataclass(frozen=True, eq=False, repr=False)
class Example(Entry):
    """A worked example of the book: what it is about, its printed numbers and ours; see `Entry`."""

    AREA: ClassVar[str] = "book_examples"


_INDEX: Index[Callable[[], Worked]] = Index(("worked_examples", "remarks"), "book.unknown_example")


def works(number: str) -> Callable[[Callable[[], Worked]], Callable[[], Worked]]:
    """Declare what computes a worked example.

    Args:
        number: as the source has it, with a name where the source has none: "5.1.4 RRRP".
    """

    def declare(compute: Callable[[], Worked]) -> Callable[[], Worked]:
        _INDEX.declare(number, compute)
        return compute

    return declare


def example(number: str, /) -> Example:
    """A worked example of the book.

    Args:
        number: such as "2.4" or "5.1.4 RRRP".

    Raises:
        InputError: no example of that number.
    """
    objects, facts = _INDEX[number]()
    return Example(number, EntryStatus.FIXED, objects, tuple(facts))


def examples() -> list[str]:
    """Numbers of all worked examples of the book that are computed here."""
    return _INDEX.numbers()
