"""Arabic text with numbers, names and formulas: nothing foreign outside an isolate, nothing inside turned round."""

import re
import tomllib
from pathlib import Path

import pytest

import mafsil.messages as messages
from mafsil.messages.isolates import END, FIRST_STRONG, LEFT_TO_RIGHT, in_cell, in_sentence, runs
from mafsil.messages.visible import visible

SENTENCES = sorted(
    sentence
    for path in (Path(messages.__file__).parent / "ar").glob("*.toml")
    for sentence in tomllib.loads(path.read_text("utf-8")).values()
    if isinstance(sentence, str)
)
VALUES = [
    "-1.1e-15",
    "−m g·p",
    "a² + b²",
    "½ m v·v",
    "Γ_ijk = ½",
    "(ω, v)",
    "0.25 m",
    "-30°",
    "q̈_2",
    "[-0.1, 2]",
    "5 %",
]


def filled():
    """Every sentence of the catalogue with values of many shapes in its places."""
    for k, sentence in enumerate(SENTENCES):
        yield re.sub(r"\{[^{}]*\}", VALUES[k % len(VALUES)], sentence)


def test_the_runs_are_the_text_again():
    for text in filled():
        assert "".join(run.text for run in runs(text)) == text


def test_no_letter_or_digit_stands_outside_an_isolate():
    for text in filled():
        bare = re.sub(f"{LEFT_TO_RIGHT}[^{END}]*{END}", "", in_sentence(text, "ar"))
        assert not re.search(r"[0-9A-Za-zα-ωΑ-Ω½²−°]", bare), text


@pytest.mark.parametrize("value", VALUES)
def test_a_value_is_not_cut(value):
    """Cut before its exponent, 4.3e-16 is read as e-164.3."""
    for frame in ("أكبر فرق {}.", "الفرق و{} صغير", "{}؛ والباقي", "القيمة ({}) هنا", "من: {}"):
        inside = re.findall(f"{LEFT_TO_RIGHT}([^{END}]*){END}", in_sentence(frame.format(value), "ar"))
        assert inside in ([value], [f"({value})"]), frame


def test_names_of_a_list_keep_the_order_of_the_language():
    assert in_sentence("من: puma560, ur5e (والباقي)", "ar", "latex") == r"من: \LR{puma560}, \LR{ur5e} (والباقي)"
    assert in_sentence("الصف 1: L1 (a) (نص)", "ar", "page") == (
        'الصف <bdi dir="ltr">1</bdi>: <bdi dir="ltr">L1 (a)</bdi> (نص)'
    )


def test_english_has_no_isolates():
    assert in_sentence("largest difference 4.3e-16.", "en") == "largest difference 4.3e-16."
    assert in_cell("-1.5", "en") == "-1.5"


def test_cells_have_the_direction_of_their_first_letter():
    assert in_cell("-1.5", "ar") == f"{LEFT_TO_RIGHT}-1.5{END}"
    assert in_cell("دوراني", "ar") == f"{FIRST_STRONG}دوراني{END}"
    assert in_cell("", "ar") == ""


def test_the_bidirectional_algorithm_shows_every_value_whole():
    """The Unicode algorithm itself, of python-bidi, in paragraphs of both directions."""
    bidi = pytest.importorskip("bidi")
    for text in filled():
        for line in in_sentence(text, "ar").split("\n"):
            for base in ("R", "L"):
                seen = bidi.get_display(line, base_dir=base)
                for value in re.findall(f"{LEFT_TO_RIGHT}([^{END}]*){END}", line):
                    assert value in seen, line


def test_the_bidirectional_algorithm_leaves_cells_in_their_columns():
    bidi = pytest.importorskip("bidi")
    cells = ["مفصل 1", "-6.283", "6.283", "3.142", "rad"]
    row = "  ".join(in_cell(cell, "ar") for cell in cells)
    shown = [bidi.get_display(row, base_dir=base) for base in ("L", "R")]
    places = [[text.index(cell) for cell in cells[1:]] for text in shown]
    assert places[0] == sorted(places[0])
    assert places[1] == sorted(places[1], reverse=True)


def test_what_is_isolated_stays_as_it_is():
    once = in_sentence("أكبر فرق 4.3e-16.", "ar")
    assert in_sentence(once, "ar") == once
    assert in_cell(in_cell("-1.5", "ar"), "ar") == in_cell("-1.5", "ar")


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("\u2066-1.5\u2069 ب", "\u2066-1.5\u2069 ب"),
        ("a\u2066b", "a<U+2066>b"),
        ("a\u2069b\u2066", "a<U+2069>b<U+2066>"),
        ("\u2066a\nb\u2069", "<U+2066>a<U+000A>b<U+2069>"),
        ("\u2067a\u2069", "<U+2067>a<U+2069>"),
        ("\u202ea", "<U+202E>a"),
    ],
)
def test_only_isolates_that_are_closed_are_obeyed(text, shown):
    """A name from a file that opens one and leaves it open would turn the rest of the line."""
    assert visible(text) == shown
