"""Numbers, names and formulas inside Arabic text: each in an isolate, so that nothing around it can turn it round.

A terminal, a page and LaTeX order letters by the Unicode bidirectional algorithm. Without isolates it moves the sign of
`−m g·p` to the other end and gives the numbers of a table's row to the wrong columns.

Reference: Unicode Standard Annex 9, sections 2.4 and 2.7.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Literal, NamedTuple, TypeAlias

from mafsil.messages.catalogue import direction

Medium: TypeAlias = Literal["terminal", "page", "latex"]

LEFT_TO_RIGHT, FIRST_STRONG, END = "\u2066", "\u2068", "\u2069"
"""Unicode's own marks: LRI, FSI and PDI."""
RIGHT_TO_LEFT_MARK = "\u200f"
_MARKS: dict[Medium, tuple[str, str]] = {
    "terminal": (LEFT_TO_RIGHT, END),
    "page": ('<bdi dir="ltr">', "</bdi>"),
    "latex": (r"\LR{", "}"),
}
_ARABIC = "\u200f\u0600-\u06ff\u0750-\u077f\u08a0-\u08ff\ufb50-\ufdff\ufe70-\ufefc"
# A right-to-left mark counts as a letter: whoever set it wanted the text turned there.
_FOREIGN = re.compile(f"[^{_ARABIC}\n]+")
_DONE = re.compile("([\u2066-\u2068][^\u2066-\u2069]*\u2069)")
_SAYS_SOMETHING = re.compile(r"[^\W_]|[½∞∂°%]")
# A mark with a blank behind it ends what stands before it, unless both are inside brackets.
_PAUSES = ".,:;!?"
_OUTSIDE = " \t" + _PAUSES + "«»“”\u200e\u200f\u061c…"
_BRACKETS = {")": "(", "]": "[", "}": "{"}


class Run(NamedTuple):
    """A stretch of a text; `foreign` if it runs from left to right on its own."""

    text: str
    foreign: bool


def runs(text: str) -> Iterator[Run]:
    """An Arabic text cut into its words and what stands among them: numbers, names, formulas.

    Args:
        text: of a right-to-left language.

    Yields:
        Stretches that together are the text. Spaces, pauses and brackets that belong to the sentence stay outside.
    """
    end = 0
    for start, stop in _foreign(text):
        if start > end:
            yield Run(text[end:start], False)
        yield Run(text[start:stop], True)
        end = stop
    if end < len(text):
        yield Run(text[end:], False)


def in_sentence(
    text: str,
    language: str | None = None,
    medium: Medium = "terminal",
    *,
    words: Callable[[str], str] = str,
    foreign: Callable[[str], str] = str,
) -> str:
    """A sentence whose numbers, names and formulas keep their own direction.

    Args:
        text: one sentence or more; in a left-to-right language nothing is isolated.
        language: `en` or `ar`; the current one if None.
        medium: how isolates are written.
        words, foreign: what else happens to the words of the language and to the rest, such as escaping.
    """
    if direction(language) == "ltr":
        return foreign(text)
    before, after = _MARKS[medium]
    pieces: list[str] = []
    # What is isolated already, such as a cell, stays as it is.
    for piece in _DONE.split(text):
        if _DONE.fullmatch(piece):
            pieces.append(piece)
        else:
            pieces += [f"{before}{foreign(r.text)}{after}" if r.foreign else words(r.text) for r in runs(piece)]
    return "".join(pieces)


def in_cell(text: str, language: str | None = None) -> str:
    """A cell of a table for a terminal: an isolate with the direction of its own first letter.

    A minus sign, a decimal point or a unit so stays at its number, and neighbouring cells in their columns.

    Args:
        text: whole content, already made visible; an empty cell stays empty.
        language: `en` or `ar`; the current one if None.
    """
    if direction(language) == "ltr" or not text.strip():
        return text
    if END in text:
        return text
    if not re.search(f"[{_ARABIC}]", text):
        return f"{LEFT_TO_RIGHT}{text}{END}"
    return f"{FIRST_STRONG}{in_sentence(text, language)}{END}"


def in_line(text: str, language: str | None = None) -> str:
    """A line of a terminal: sentences that read in their order whichever way the terminal's paragraphs run.

    Marks at both ends keep a number or a full stop that stands there from jumping to the other end; a line without a
    word of the language is one isolate.

    Args:
        text: one line, already made visible; blanks in front of it stay in front.
        language: `en` or `ar`; the current one if None.
    """
    if direction(language) == "ltr" or not text.strip():
        return text
    words = text.lstrip(" ")
    indent = text[: len(text) - len(words)]
    if not re.search(f"[{_ARABIC}]", words):
        return indent + in_cell(words, language)
    return f"{indent}{RIGHT_TO_LEFT_MARK}{in_sentence(words, language)}{RIGHT_TO_LEFT_MARK}"


def _foreign(text: str) -> Iterator[tuple[int, int]]:
    """Start and end of every foreign stretch."""
    for stretch in _FOREIGN.finditer(text):
        for start, end in _phrases(text, stretch.start(), stretch.end()):
            start, end = _trim(text, start, end)
            if _SAYS_SOMETHING.search(text, start, end):
                yield start, end


def _phrases(text: str, start: int, end: int) -> Iterator[tuple[int, int]]:
    """The stretch cut at pauses that stand outside its brackets."""
    depth, first = 0, start
    for k in range(start, end):
        depth = max(0, depth + (text[k] in "([{") - (text[k] in ")]}"))
        if text[k] in _PAUSES and depth == 0 and text[k + 1 : k + 2] == " ":
            yield first, k
            first = k + 1
    yield first, end


def _trim(text: str, start: int, end: int) -> tuple[int, int]:
    """Without spaces, pauses and brackets of the sentence at its ends; the point of `.png` belongs to the name."""
    while start < end:
        alone = _unmatched_brackets(text, start, end)
        begins_a_word = text[start] in _PAUSES and text[start + 1 : start + 2].strip() != "" and start + 1 < end
        if (text[start] in _OUTSIDE and not begins_a_word) or start in alone:
            start += 1
        elif text[end - 1] in _OUTSIDE or end - 1 in alone:
            end -= 1
        else:
            break
    return start, end


def _unmatched_brackets(text: str, start: int, end: int) -> set[int]:
    """Places of brackets whose partner is outside the stretch."""
    waiting: list[int] = []
    lost: set[int] = set()
    for k in range(start, end):
        if text[k] in "([{":
            waiting.append(k)
        elif text[k] in _BRACKETS:
            if waiting and text[waiting[-1]] == _BRACKETS[text[k]]:
                waiting.pop()
            else:
                lost.add(k)
    return lost | set(waiting)
