"""YAML of robots' parameters: units of xacro, nothing executed, nothing endless."""

from __future__ import annotations

import itertools
import math
from contextlib import suppress

import pytest
import yaml

from mafsil.model.xacro.files import LARGEST, YamlFault, parse_yaml
from tests.budget import within

DOCUMENT = """
---
# joints
first: &shape   # an anchor
  mass: 1.5
  "inertia": {xx: 1.0e-3, 'yy': .5, zz: 2}
  xyz: [0.0, -1, +2]
second:
  <<: *shape
  mass: 2.0
list:
- name: a
  on: true
-
  - 1
  - ~
- plain text: with colons
- 'it''s # no comment'
range: !degrees 180.0
arc: !radians -pi/2
octal: 010
hex: 0x1F
empty:
far: .inf
several: [1,
  2]
twice: 1
twice: 2
"""


def test_everything_that_robots_use() -> None:
    found = parse_yaml(DOCUMENT)
    shape = {"mass": 1.5, "inertia": {"xx": 1e-3, "yy": 0.5, "zz": 2}, "xyz": [0.0, -1, 2]}
    expected = {
        "first": shape,
        "second": {**shape, "mass": 2.0},
        "list": [{"name": "a", True: True}, [1, None], {"plain text": "with colons"}, "it's # no comment"],
        "range": math.pi,
        "arc": -math.pi / 2,
        "octal": 8,
        "hex": 31,
        "empty": None,
        "far": math.inf,
        "several": [1, 2],
        "twice": 2,
    }
    assert found == expected


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("a: 1\n\tb: 2", 2), ("a: 1\n   b: 2", 2), ("a: [1, 2", 1), ("a: 'x", 1), ("a: *b", 1),
        ("a: !python/object/apply:os.system ['x']", 1), ("- a\nb: 1", 2), ("a: !degrees x", 1), ("<<: 3", 1),
        ("a: [" + "[" * 100, 1), ("a: {b: 1} c", 1), ("a: 1\n---\nb: 2", 2), ("a: 2001-99-99", 1), ("x" * 300_000, 1),
    ],
)  # fmt: skip
def test_what_is_refused_says_the_line(text: str, line: int) -> None:
    with pytest.raises(YamlFault) as fault:
        parse_yaml(text)
    assert fault.value.line == line


def test_texts_over_lines_and_shared_objects() -> None:
    assert parse_yaml("a: |\n  one\n  two\n") == {"a": "one\ntwo\n"}
    names = "abcdefghijklmnopq"
    laughs = "a: &a [1]\n" + "".join(f"{c}: &{c} [*{b}, *{b}]\n" for b, c in itertools.pairwise(names))
    assert isinstance(parse_yaml(laughs), dict)


LARGE = {
    "list": "- 1\n" * (LARGEST // 4),
    "row": "[" + "1," * (LARGEST // 2 - 2) + "1]",
    "lists": "[" + "[]," * (LARGEST // 3 - 2) + "1]",
    "map": "".join(f"a{k}: 1\n" for k in range(LARGEST // 10)),
    "pairs": "!!omap\n" + "- a: 1\n" * (LARGEST // 7 - 2),
    "sexagesimal": "- " + ":".join(["59"] * (LARGEST // 4)),
}


def read_or_refuse(text: str) -> None:
    with suppress(YamlFault):
        parse_yaml(text)


@pytest.mark.row("F1")
@pytest.mark.parametrize("name", LARGE)
def test_the_largest_files_take_two_seconds_at_most(name: str) -> None:
    within(2.0, lambda: read_or_refuse(LARGE[name]))


@pytest.mark.parametrize("name", LARGE)
def test_without_the_parser_in_c_less_is_taken(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(yaml, "CSafeLoader", raising=False)
    assert parse_yaml("a: [1, !degrees 180]") == {"a": [1, math.pi]}
    within(2.0, lambda: read_or_refuse(LARGE[name]))
