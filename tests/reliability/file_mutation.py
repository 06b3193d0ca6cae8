"""Random damage to robot files: at the level of bytes, of words that look like numbers, and of elements."""

from __future__ import annotations

import random
import re
from collections.abc import Callable

_VALUE = re.compile(rb'"([^"]*)"')
_NUMBER = re.compile(rb"-?[0-9]+(?:\.[0-9]*)?(?:e-?[0-9]+)?")
_ATTRIBUTE = re.compile(rb'\s[A-Za-z_:]+="[^"]*"')
_NAME = re.compile(rb'(?:name|link|joint|class|body1|body2|joint1|joint2)="([^"]*)"')
_ELEMENT = re.compile(rb"<([A-Za-z_]+)[^<>]*?/>|<([A-Za-z_]+)[^<>]*>[^<]*</\2>")
_TAG = re.compile(rb"</?[A-Za-z_]+")

NUMBERS = tuple(
    text.encode()
    for text in (
        "nan", "-inf", "1e400", "-1e308", "1e308", "1e-400", "5e-324", "0", "-0", "0x10", "1,5", "١٫٥", "", " ",
        "1 2", "1e", "e5", "--1", "+.5", "1.", ".", "1_000", "1kg", "∞", "1" * 500, "9" * 320, "1e15", "1e16", "-1",
    )
)  # fmt: skip
WORDS = tuple(
    text.encode()
    for text in (
        "", " ", "a", "b", "r", "revolute", "prismatic", "floating", "planar", "continuous", "fixed", "hinge", "true",
        "../../etc/passwd", "package://../x", "file:///dev/zero", "model://a/b", "a\u202eb", "&#0;", "&lt;", "&e;",
        "ا", "x" * 600, "${1}", "$(find a)", "\u0000", "'", "\n", "%s%n", "{0}", "{}", "\ufeff", "XYZ",
    )
)  # fmt: skip
SNIPPETS = (
    b"<!DOCTYPE a>", b"<!DOCTYPE a [<!ENTITY e 'x'>]>", b"<![CDATA[", b"]]>", b"<!--", b"-->", b"<?xml?>", b"<", b">",
    b"&", b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"</robot>", b"<robot>", b"<a>" * 70, b'"', b"/>", b"<inertial/>",
    b'<joint name="x" type="fixed"/>', b"<mimic/>", b"<axis/>", b"<limit/>", b"<link/>", b"<geometry/>", b"<mesh/>",
    b'<include file="x"/>', b"<default/>", b"<body/>", b"<geom/>", b"<freejoint/>", b"<compiler/>",
)  # fmt: skip

Mutation = Callable[[random.Random, bytes], bytes]


def mutated(dice: random.Random, data: bytes) -> bytes:
    """The file after one to six random mutations."""
    for _ in range(dice.choice((1, 1, 1, 2, 2, 3, 6))):
        data = dice.choice(MUTATIONS)(dice, data)
    return data


def _flip(dice: random.Random, data: bytes) -> bytes:
    if not data:
        return data
    at = dice.randrange(len(data))
    return data[:at] + bytes([data[at] ^ (1 << dice.randrange(8))]) + data[at + 1 :]


def _cut(dice: random.Random, data: bytes) -> bytes:
    return data[: dice.randrange(len(data) + 1)]


def _drop(dice: random.Random, data: bytes) -> bytes:
    start = dice.randrange(len(data) + 1)
    return data[:start] + data[start + dice.randrange(1, 40) :]


def _repeat(dice: random.Random, data: bytes) -> bytes:
    start = dice.randrange(len(data) + 1)
    return data[:start] + data[start : start + dice.randrange(1, 300)] * dice.randrange(2, 5) + data[start:]


def _insert(dice: random.Random, data: bytes) -> bytes:
    at = dice.randrange(len(data) + 1)
    return data[:at] + dice.choice(SNIPPETS) + data[at:]


def _replace(pattern: re.Pattern[bytes], words: tuple[bytes, ...], group: int = 0) -> Mutation:
    def mutation(dice: random.Random, data: bytes) -> bytes:
        found = [m.span(group) for m in pattern.finditer(data)]
        if not found:
            return data
        start, end = dice.choice(found)
        return data[:start] + dice.choice(words) + data[end:]

    return mutation


def _exchange(pattern: re.Pattern[bytes], group: int = 0) -> Mutation:
    """Put the text of one match in the place of another."""

    def mutation(dice: random.Random, data: bytes) -> bytes:
        found = [m.span(group) for m in pattern.finditer(data)]
        if len(found) < 2:
            return data
        (start, end), (first, last) = dice.sample(found, 2)
        return data[:start] + data[first:last] + data[end:]

    return mutation


def _double(pattern: re.Pattern[bytes]) -> Mutation:
    """Write one match twice."""

    def mutation(dice: random.Random, data: bytes) -> bytes:
        found = [m.span() for m in pattern.finditer(data)]
        if not found:
            return data
        start, end = dice.choice(found)
        return data[:end] + data[start:end] + data[end:]

    return mutation


MUTATIONS: tuple[Mutation, ...] = (
    _flip,
    _cut,
    _drop,
    _repeat,
    _insert,
    _replace(_VALUE, WORDS, 1),
    _replace(_NUMBER, NUMBERS),
    _replace(_NUMBER, NUMBERS),
    _replace(_ATTRIBUTE, (b"",)),
    _replace(_ELEMENT, (b"",)),
    _exchange(_VALUE, 1),
    _exchange(_NAME, 1),
    _exchange(_NAME, 1),
    _exchange(_ELEMENT),
    _exchange(_TAG),
    _double(_ELEMENT),
    _double(_ATTRIBUTE),
)
