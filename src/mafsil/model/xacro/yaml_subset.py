"""The part of YAML in which parameters of robots are written: block and flow collections, scalars, units, anchors.

Several documents, texts over several lines and tags other than units are refused. Of a key that stands twice the last
counts. What an alias stands for is the same object, so a small file stays small; who writes it out bounds it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias, cast

from mafsil.model.xacro.expression import evaluate
from mafsil.model.xacro.fault import Budget, XacroFault

Node: TypeAlias = object
"""None, bool, int, float, str, list or dict of nodes."""
LARGEST = 1_000_000
"""Bytes of a file."""
DEEPEST = 40
UNITS = {
    "!radians": 1.0,
    "!degrees": math.pi / 180.0,
    "!meters": 1.0,
    "!millimeters": 0.001,
    "!foot": 0.3048,
    "!inches": 0.0254,
}
"""Tags of xacro, and what their numbers are multiplied by."""
_BLANK = re.compile(r"\s*(?:#.*)?$")
_COLON = re.compile(r":(?=\s|$)")
_INTEGER = re.compile(r"[-+]?[0-9][0-9_]*")
_HEXADECIMAL = re.compile(r"0x[0-9a-fA-F_]+")
_FLOAT = re.compile(r"[-+]?(?:[0-9][0-9_]*\.[0-9_]*(?:[eE][-+]?[0-9]+)?|\.[0-9][0-9_]*(?:[eE][-+]?[0-9]+)?)")
_EXPONENT = re.compile(r"[-+]?[0-9]+(?:\.[0-9]*)?[eE][-+][0-9]+")
_WORDS: dict[str, Node] = {
    **dict.fromkeys(("true", "True", "TRUE", "yes", "Yes", "YES", "on", "On", "ON"), True),
    **dict.fromkeys(("false", "False", "FALSE", "no", "No", "NO", "off", "Off", "OFF"), False),
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys((".inf", ".Inf", ".INF", "+.inf"), math.inf),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), -math.inf),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), math.nan),
}
_PRODUCT = re.compile(r"[-+0-9.eE*/() ]*(?:pi[-+0-9.eE*/() ]*)*")


class YamlFault(ValueError):
    """Not of this part of YAML.

    Attributes:
        line: from 1.
        reason: what is wrong.
    """

    def __init__(self, line: int, reason: str) -> None:
        super().__init__(f"line {line}: {reason}")
        self.line = line
        self.reason = reason


@dataclass(slots=True)
class _Line:
    """A line that says something."""

    number: int
    indent: int
    text: str


def parsed(text: str) -> Node:
    """The value of a YAML text.

    Raises:
        YamlFault: it is not of this part of YAML; the line is given.
    """
    if len(text) > LARGEST:
        raise YamlFault(1, f"longer than {LARGEST} characters")
    lines = [_line(number, raw) for number, raw in enumerate(text.splitlines(), 1) if not _BLANK.fullmatch(raw)]
    if lines and lines[0].text == "---":
        lines = lines[1:]
    if lines and lines[-1].text == "...":
        lines = lines[:-1]
    if not lines:
        return None
    block = _Block(lines)
    value = block.node(lines[0].indent, 0)
    if block.at < len(lines):
        raise YamlFault(lines[block.at].number, "unexpected indentation")
    return value


def _line(number: int, raw: str) -> _Line:
    body = raw.lstrip(" ")
    if body.startswith("\t"):
        raise YamlFault(number, "a tab cannot indent")
    return _Line(number, len(raw) - len(body), _uncommented(body).rstrip())


def _uncommented(text: str) -> str:
    """The text before a comment, which begins with # after a blank and outside quotes."""
    quote = ""
    for at, c in enumerate(text):
        if quote:
            quote = "" if c == quote else quote
        elif c in "'\"" and (at == 0 or text[at - 1] in " \t[{,:" or text[at - 1] == c == "'"):
            quote = c
        elif c == "#" and (at == 0 or text[at - 1] in " \t"):
            return text[:at]
    return text


class _Block:
    """Collections by indentation."""

    def __init__(self, lines: list[_Line]) -> None:
        self.lines = lines
        self.at = 0
        self.anchors: dict[str, Node] = {}

    def node(self, indent: int, depth: int) -> Node:
        """The collection or scalar that begins at the present line."""
        line = self.lines[self.at]
        if depth > DEEPEST:
            raise YamlFault(line.number, "nested too deeply")
        if line.text == "-" or line.text.startswith("- "):
            return self._sequence(indent, depth)
        if _key(line) is not None:
            return self._mapping(indent, depth)
        return self._scalar(indent)

    def _sequence(self, indent: int, depth: int) -> Node:
        found: list[Node] = []
        while self._here(indent) and (self.lines[self.at].text == "-" or self.lines[self.at].text.startswith("- ")):
            line = self.lines[self.at]
            rest = line.text[1:].lstrip(" ")
            if rest:
                line.indent += len(line.text) - len(rest)
                line.text = rest
                found.append(self.node(line.indent, depth + 1))
            else:
                self.at += 1
                found.append(self._below(indent, depth))
        return found

    def _mapping(self, indent: int, depth: int) -> Node:
        found: dict[Node, Node] = {}
        while self._here(indent):
            line = self.lines[self.at]
            key = _key(line)
            if key is None:
                raise YamlFault(line.number, "expected `key: value`")
            name = line.text[:key].rstrip()
            anchor, rest = _anchor(line.text[key + 1 :].strip())
            if rest:
                line.indent, line.text = line.indent + 1, rest
                value = self._scalar(indent)
            else:
                self.at += 1
                value = self._below(indent, depth, sequences_too=True)
            if anchor:
                self.anchors[anchor] = value
            if name == "<<":
                self._merge(found, value, line.number)
            else:
                found[_scalar(name, line.number)] = value
        return found

    @staticmethod
    def _merge(found: dict[Node, Node], value: Node, line: int) -> None:
        """Keys of another mapping, or of several, that are not there yet."""
        for other in cast("list[Node]", value) if isinstance(value, list) else [value]:
            if not isinstance(other, dict):
                raise YamlFault(line, "only mappings can be merged")
            for key, inner in cast("dict[Node, Node]", other).items():
                found.setdefault(key, inner)

    def _here(self, indent: int) -> bool:
        if self.at >= len(self.lines) or self.lines[self.at].indent < indent:
            return False
        if self.lines[self.at].indent > indent:
            raise YamlFault(self.lines[self.at].number, "unexpected indentation")
        return True

    def _below(self, indent: int, depth: int, *, sequences_too: bool = False) -> Node:
        """What is indented under a key or a dash; a list may stand right under its key."""
        if self.at >= len(self.lines):
            return None
        line = self.lines[self.at]
        is_item = line.text == "-" or line.text.startswith("- ")
        if line.indent > indent or (sequences_too and line.indent == indent and is_item):
            return self.node(line.indent, depth + 1)
        return None

    def _scalar(self, indent: int) -> Node:
        """A scalar or a flow collection, which may go on over more deeply indented lines."""
        first = self.lines[self.at]
        text, number = first.text, first.number
        self.at += 1
        if text[0] in "|>":
            raise YamlFault(number, "texts over several lines are not read")
        while self.at < len(self.lines) and (self.lines[self.at].indent > indent or _is_open(text)):
            if text[0] not in "[{" and _key(self.lines[self.at]) is not None:
                raise YamlFault(self.lines[self.at].number, "unexpected indentation")
            text += " " + self.lines[self.at].text
            self.at += 1
        return _Flow(text, number, self.anchors).whole()


def _anchor(text: str) -> tuple[str, str]:
    """The name of an anchor before a value, or empty, and the value."""
    if not text.startswith("&"):
        return "", text
    name, _, rest = text[1:].partition(" ")
    return name, rest.strip()


def _key(line: _Line) -> int | None:
    """Where the colon after the key of a line stands, or None if the line has no key."""
    text = line.text
    if text[0] in "[]{},&*!|>%@`":
        return None
    start = text.find(text[0], 1) + 1 if text[0] in "'\"" else 0
    found = _COLON.search(text, start)
    return None if found is None or (start and text[start : found.start()].strip()) else found.start()


def _is_open(text: str) -> bool:
    """Whether a flow collection has not been closed."""
    return text[:1] in "[{" and text.count("[") + text.count("{") > text.count("]") + text.count("}")


class _Flow:
    """A scalar, `[a, b]` or `{a: b}` on one line."""

    def __init__(self, text: str, line: int, anchors: dict[str, Node]) -> None:
        self.text = text
        self.line = line
        self.anchors = anchors
        self.at = 0

    def whole(self) -> Node:
        """The value, with nothing after it."""
        if self.text[0] not in "[{":
            return self._value(self.text)
        value = self._node(0)
        if self.text[self.at :].strip():
            raise YamlFault(self.line, f"unexpected text: {self.text[self.at :][:20]}")
        return value

    def _node(self, depth: int) -> Node:
        if depth > DEEPEST:
            raise YamlFault(self.line, "nested too deeply")
        self._skip()
        start = self.text[self.at : self.at + 1]
        if start == "[":
            return self._list(depth)
        if start == "{":
            return self._dictionary(depth)
        return self._value(self._word(",]}"))

    def _value(self, text: str) -> Node:
        """A scalar, or what an alias stands for."""
        if not text.startswith("*"):
            return _scalar(text, self.line)
        if text[1:] not in self.anchors:
            raise YamlFault(self.line, f"the anchor {text[1:40]} is not defined before")
        return self.anchors[text[1:]]

    def _list(self, depth: int) -> Node:
        found: list[Node] = []
        self.at += 1
        while not self._closed("]"):
            found.append(self._node(depth + 1))
            self._separator("]")
        return found

    def _dictionary(self, depth: int) -> Node:
        found: dict[Node, Node] = {}
        self.at += 1
        while not self._closed("}"):
            key = _scalar(self._word(":"), self.line)
            if self.text[self.at : self.at + 1] != ":":
                raise YamlFault(self.line, "expected `key: value`")
            self.at += 1
            found[key] = self._node(depth + 1)
            self._separator("}")
        return found

    def _skip(self) -> None:
        while self.text[self.at : self.at + 1] in (" ", "\t"):
            self.at += 1

    def _closed(self, bracket: str) -> bool:
        self._skip()
        if self.at >= len(self.text):
            raise YamlFault(self.line, f"{bracket} is missing")
        if self.text[self.at] != bracket:
            return False
        self.at += 1
        return True

    def _separator(self, bracket: str) -> None:
        self._skip()
        here = self.text[self.at : self.at + 1]
        if here == ",":
            self.at += 1
        elif here != bracket:
            raise YamlFault(self.line, f"expected , or {bracket}")

    def _word(self, ends: str) -> str:
        """A scalar up to one of the characters, quotes respected."""
        self._skip()
        start = self.at
        quote = self.text[start : start + 1]
        if quote in ("'", '"') and quote:
            close = self.text.find(quote, start + 1)
            self.at = len(self.text) if close < 0 else close + 1
        else:
            while self.at < len(self.text) and self.text[self.at] not in ends:
                self.at += 1
        return self.text[start : self.at].strip()


def _scalar(text: str, line: int) -> Node:
    """A plain or quoted scalar, or a number with a unit."""
    if text[:1] == "!":
        tag, _, rest = text.partition(" ")
        if tag not in UNITS:
            raise YamlFault(line, f"the tag {tag[:40]} is not read")
        return _number(rest.strip(), line) * UNITS[tag]
    if text[:1] in ("&", "*"):
        raise YamlFault(line, "an anchor or alias cannot stand here")
    if text[:1] in ("'", '"'):
        return _quoted(text, line)
    if text in _WORDS:
        return _WORDS[text]
    if len(text) < 400:
        if _INTEGER.fullmatch(text):
            digits = text.replace("_", "")
            leading_zero = digits.lstrip("+-").startswith("0") and len(digits.lstrip("+-")) > 1
            return int(digits, 8) if leading_zero and not set(digits) & set("89") else int(digits)
        if _HEXADECIMAL.fullmatch(text):
            return int(text.replace("_", ""), 16)
        if _FLOAT.fullmatch(text) or _EXPONENT.fullmatch(text):
            return float(text.replace("_", ""))
    return text


def _quoted(text: str, line: int) -> str:
    quote = text[0]
    if len(text) < 2 or text[-1] != quote:
        raise YamlFault(line, "a quote is not closed")
    inner = text[1:-1]
    if quote == "'":
        return inner.replace("''", "'")
    if "\\" in inner.replace('\\"', "").replace("\\\\", ""):
        raise YamlFault(line, 'escapes other than \\" and \\\\ are not read')
    return inner.replace('\\"', '"').replace("\\\\", "\\")


def _number(text: str, line: int) -> float:
    """A number before which a unit stands; products with pi are allowed, as xacro allows expressions there."""
    try:
        return float(text)
    except ValueError:
        pass
    if _PRODUCT.fullmatch(text[:200]):
        try:
            value = evaluate(text, _Constants(), Budget(1000))
        except XacroFault:
            value = None
        if isinstance(value, int | float):
            return float(value)
    raise YamlFault(line, f"{text[:40]} is no number")


class _Constants:
    """The only name in a number with a unit."""

    def lookup(self, name: str) -> Node:
        return {"pi": math.pi}[name]

    def known(self) -> Iterator[str]:
        yield "pi"
