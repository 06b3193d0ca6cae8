"""Pieces of HTML as element trees: text becomes text nodes, so nothing in a name can become markup."""

from __future__ import annotations

import re
from collections.abc import Iterable
from xml.etree.ElementTree import Element, SubElement, tostring

from mafsil.messages import say
from mafsil.messages.isolates import runs
from mafsil.messages.visible import visible
from mafsil.report.content import Details, Figure, Finding, Step, Table

LONG = 60
"""Letters from which on a cell of a table is a text that goes over several lines."""
_ARABIC = re.compile(r"[\u0600-\u06ff]")


def header(title: str, subtitle: str, verdict: Finding | None = None) -> str:
    """Title, subtitle and verdict."""
    words = Element("div")
    _say(SubElement(words, "h1"), title)
    line = SubElement(words, "p")
    for part in subtitle.split(" · "):  # each keeps its own direction; they follow in that of the page
        if len(line):
            line[-1].tail = " · "
        _say(line, part)
    if verdict is None:
        return _html(words)
    chip = Element("span", {"class": f"chip {verdict.level}"})
    _say(chip, verdict.text)
    return _html(words, chip)


def figures(items: Iterable[Figure]) -> str:
    """The numbers that matter, one card each."""
    return _html(*(_figure(item) for item in items))


def findings(items: Iterable[Finding]) -> str:
    """What the reader must know."""
    root = Element("ul", {"class": "findings"})
    for item in items:
        _say(SubElement(root, "li", {"class": item.level}), item.text)
    return _html(root)


def steps(items: Iterable[Step], language: str) -> str:
    """The sequence of moves, as a table."""
    root, body = _table(
        tuple(say(f"report.{key}", language=language) for key in ("move", "kind", "start", "length", "result"))
    )
    for item in items:
        row = SubElement(body, "tr", {"class": item.level})
        for text in (item.name, item.kind, f"{item.start:.3f} s", f"{item.end - item.start:.3f} s"):
            _say(SubElement(row, "td"), text)
        _say(SubElement(row, "td", {"class": "text"}), item.text)
    return _html(root)


def table(content: Table) -> str:
    """A table of texts."""
    root, body = _table(content.head)
    for texts in content.rows:
        row = SubElement(body, "tr")
        for text in texts:
            _say(SubElement(row, "td", {"class": "text"} if len(text) > LONG else {}), text)
    return _html(root)


def details(items: Iterable[Details]) -> str:
    """Provenance, the job, versions: each under a heading that folds."""
    return _html(*(_details(item) for item in items))


def text(value: str) -> str:
    """One text, isolated left to right when it has no Arabic."""
    holder = Element("span")
    _say(holder, value)
    return _html(holder)


def _figure(item: Figure) -> Element:
    card = Element("div", {"class": f"number {item.level}"})
    _say(SubElement(card, "div", {"class": "label"}), item.label)
    value = SubElement(SubElement(card, "div", {"class": "value"}), "bdi", {"dir": "ltr"})
    value.text = item.value
    if item.unit:
        value.text += " "
        SubElement(value, "small").text = item.unit
    _say(SubElement(card, "div", {"class": "note"}), item.note)
    return card


def _details(item: Details) -> Element:
    root = Element("details", {"open": "open"} if item.open else {})
    SubElement(root, "summary").text = visible(item.title)
    if item.text:
        SubElement(root, "pre", {"dir": "ltr"}).text = "\n".join(map(visible, item.text.splitlines()))
        return root
    pairs = SubElement(root, "dl")
    for label, value in item.pairs:
        _say(SubElement(pairs, "dt"), label)
        _say(SubElement(pairs, "dd"), value)
    return root


def _table(head: tuple[str, ...]) -> tuple[Element, Element]:
    root = Element("table")
    row = SubElement(SubElement(root, "thead"), "tr")
    for label in head:
        _say(SubElement(row, "th"), label)
    return root, SubElement(root, "tbody")


def _say(parent: Element, value: str) -> None:
    """Put a text into an element; in Arabic sentences numbers and names are isolated left to right."""
    shown = visible(value)
    if not _ARABIC.search(shown):
        SubElement(parent, "bdi", {"dir": "ltr"}).text = shown
        return
    sentence = SubElement(parent, "bdi", {"dir": "rtl"})
    sentence.text, last = "", None
    for run in runs(shown):
        if run.foreign:
            last = SubElement(sentence, "bdi", {"dir": "ltr"})
            last.text, last.tail = run.text, ""
        elif last is None:
            sentence.text += run.text
        else:
            last.tail = (last.tail or "") + run.text


def _html(*elements: Element) -> str:
    return "".join(tostring(element, encoding="unicode", method="html") for element in elements)
