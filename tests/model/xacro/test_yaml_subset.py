"""The part of YAML that robots' parameters are written in."""

from __future__ import annotations

import math

import pytest

from mafsil.model.xacro.yaml_subset import YamlFault, parsed

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
    found = parsed(DOCUMENT)
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
    yaml = pytest.importorskip("yaml")
    plain = DOCUMENT.replace("!degrees 180.0", repr(math.pi)).replace("!radians -pi/2", repr(-math.pi / 2))
    assert yaml.safe_load(plain) == found


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("a: 1\n\tb: 2", 2), ("a: 1\n   b: 2", 2), ("a: [1, 2", 1), ("a: {b 1}", 1), ("a: 'x", 1), ("a: *b", 1),
        ("a: |\n  text", 1), ("a: !python/object 1", 1), ("- a\nb: 1", 2), ("a: !degrees x", 1), ("<<: 3", 1),
        ("a: [" + "[" * 100, 1), ("a: {b: 1} c", 1),
    ],
)  # fmt: skip
def test_what_is_refused_says_the_line(text: str, line: int) -> None:
    with pytest.raises(YamlFault) as fault:
        parsed(text)
    assert fault.value.line == line
