"""`mafsil book`: figures, worked examples and remarks of the textbook by number, with the numbers that decide them."""

from __future__ import annotations

import mafsil.book as book_of
from mafsil.cli.answer import Answer
from mafsil.cli.picture import PLAIN, drawn, require_kind
from mafsil.cli.table import table
from mafsil.errors import InputError
from mafsil.messages import say

_OPEN = {"figure": book_of.figure, "example": book_of.example, "remark": book_of.remark}
_LISTS = {"figure": book_of.figures, "example": book_of.examples, "remark": book_of.remarks}


def book(what: str | None = None, number: str | None = None, picture: str | None = None) -> Answer:
    """One entry of the book explained, a figure drawn into a file, or the numbers and titles of all.

    Args:
        what: `figure`, `example` or `remark`; all of them if None.
        number: as the book has it; all of that kind if None.
        picture: file for a figure: PNG, SVG or PDF.

    Raises:
        InputError: no such entry, or a picture of what is no figure.
    """
    if picture is not None and (what != "figure" or number is None):
        raise InputError("cli.book_no_figure")
    if what is None or number is None:
        kinds = _OPEN if what is None else (what,)
        titles = {kind: {each: _OPEN[kind](each).title for each in _LISTS[kind]()} for kind in kinds}
        rows = [[kind, each, title] for kind, entries in titles.items() for each, title in entries.items()]
        return Answer(
            titles, tuple(table([say(f"cli.book_{key}") for key in ("kind", "at", "title")], rows, words=(2,)))
        )
    entry = _OPEN[what](number)
    lines = entry.explain().split("\n")
    if picture is not None:
        require_kind(picture, PLAIN)
        drawn(book_of.figure(number).save, picture)
        lines.append(say("cli.picture_written", path=picture))
    return Answer(entry.to_dict(), tuple(lines))
