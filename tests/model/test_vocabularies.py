"""Every word of the vocabularies is known by the audit, and a misspelt twin of each is reported with the word meant."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import pytest

from mafsil.collision.srdf import SRDF
from mafsil.model.diagnostics import Diagnostic
from mafsil.model.mjcf.settings import MJCF
from mafsil.model.reading import Reading
from mafsil.model.sdf.scope import SDF
from mafsil.model.urdf.vocabulary import URDF
from mafsil.model.vocabulary import Row, Treatment, Vocabulary, audit, nearest_words
from mafsil.model.xml_tree import parse

ROOTS = {
    "URDF": (URDF, "robot"), "MJCF": (MJCF, "mujoco"), "SDFormat": (SDF, "sdf"), "SDFormat's models": (SDF, "model"),
    "SRDF": (SRDF, "robot"),
}  # fmt: skip


def places(vocabulary: Vocabulary, root: str) -> Iterator[tuple[tuple[str, ...], Row]]:
    """The way from the root to every row, each row once."""
    seen: set[int] = set()
    waiting: list[tuple[str, ...]] = [(root,)]
    while waiting:
        way = waiting.pop(0)
        row = vocabulary.row_of(way[-1], way[-2] if len(way) > 1 else "")
        if row is None or id(row) in seen:
            continue
        seen.add(id(row))
        yield way, row
        waiting += [(*way, tag) for tag, word in row.parts.items() if word.treatment is Treatment.READ]


CASES = [(form, way, row) for form, (vocabulary, root) in ROOTS.items() for way, row in places(vocabulary, root)]


def twins(word: str) -> Iterator[str]:
    """Misspelt: letters exchanged, one left out, one twice, other case, another sign between words."""
    middle = max(1, len(word) // 2)
    yield word[: middle - 1] + word[middle] * (middle < len(word)) + word[middle - 1] + word[middle + 1 :]
    yield word[:middle] + word[middle + 1 :]
    yield word[:middle] + word[middle - 1] + word[middle:]
    yield word.upper() if word != word.upper() else word.lower()
    yield word.replace("_", "-")


def remarks(form: str, way: tuple[str, ...], attribute: str = "", child: str = "") -> list[Diagnostic]:
    """What the audit says of an empty element at the end of a way, with an attribute or an element inside."""
    around = "".join(f"<{tag}>" for tag in way[:-1])
    inside = f"<{child}/>" if child else ""
    given = f' {attribute}="false"' if attribute else ""
    names = ' xmlns:drake="d" xmlns:xacro="x"'
    text = f"{around}<{way[-1]}{given}>{inside}</{way[-1]}>" + "".join(f"</{tag}>" for tag in reversed(way[:-1]))
    reading = Reading(parse(text.replace(f"<{way[0]}", f"<{way[0]}{names}", 1).encode()))
    audit(reading, reading.document.root, ROOTS[form][0])
    return reading.diagnostics


@pytest.mark.parametrize(("form", "way", "row"), CASES, ids=lambda v: "/".join(v) if isinstance(v, tuple) else "")
def test_every_word_is_known_and_its_twins_are_reported(form: str, way: tuple[str, ...], row: Row) -> None:
    vocabulary = ROOTS[form][0]
    for name in row.words:
        assert all(d.fault is not vocabulary.unknown_attribute for d in remarks(form, way, attribute=name)), name
        for twin in set(twins(name)) - set(row.words) - {""}:
            (said,) = (d for d in remarks(form, way, attribute=twin) if d.fault is vocabulary.unknown_attribute)
            assert name in str(said.details["known"]).split(", "), twin
    for name, word in row.parts.items():
        assert all(d.fault is not vocabulary.unknown_part for d in remarks(form, way, child=name)), name
        for twin in set(twins(name)) - set(row.parts) - {""}:
            (said,) = (d for d in remarks(form, way, child=twin) if d.fault is vocabulary.unknown_part)
            assert name in str(said.details["known"]).split(", "), (twin, word)


def test_nearness_of_words() -> None:
    inertia = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    assert nearest_words("ryp", ("xyz", "rpy", "quat_xyzw")) == ("rpy",)
    assert nearest_words("quatxyzw", ("xyz", "rpy", "quat_xyzw")) == ("quat_xyzw",)
    assert nearest_words("Ixx", inertia) == ("ixx",)
    assert nearest_words("iyx", inertia) == ("ixy",)
    assert nearest_words("pos", ("xyz", "rpy")) == ()
    assert nearest_words("viscous", ("damping", "friction")) == ()
    assert nearest_words("x" * 100_000, ("xyz",)) == ()


def test_words_of_other_versions_are_taken_out_and_said() -> None:
    text = b'<robot version="1.0"><joint><limit lower="1" jerk="2"/></joint></robot>'
    for version, kept in (((1, 0), {"lower"}), ((1, 1), {"lower"}), ((1, 2), {"lower", "jerk"})):
        reading = Reading(parse(text))
        audit(reading, reading.document.root, URDF, version)
        assert set(reading.document.root.children[0].children[0].attributes) == kept
        assert [d.code for d in reading.diagnostics] == (["F0140"] if len(kept) < 2 else [])
    old = replace(URDF, row_of=lambda tag, parent: Row("version lower@1.0-1.1") if tag == "robot" else None)
    reading = Reading(parse(b'<robot version="1.2" lower="1"/>'))
    audit(reading, reading.document.root, old, (1, 2))
    assert [d.code for d in reading.diagnostics] == ["F0140"]
    assert "1.1" in reading.diagnostics[0].sentence("en")
