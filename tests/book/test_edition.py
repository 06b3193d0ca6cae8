"""The edition: a page or an honest no for each section, nothing of the source without a page, errata with proof."""

from __future__ import annotations

from itertools import chain

import numpy as np
import pytest

import mafsil as mf
from mafsil.book.edition import section_table
from mafsil.book.errata import COUNTEREXAMPLES
from mafsil.cli.main import main
from mafsil.errors import InputError

SECTIONS = mf.book.sections()
PAGES = [number for number in SECTIONS if mf.book.section(number)]
RIGHT = {
    "2.2.1": [2 * 6 - 5], "3.2.4": [1], "4.2.3": [-1], "4.3.3.1": [[np.sin(1), 1 - np.cos(1), 0]], "4.3.3.3": [[0, 1,
    0]],
    "5.1.2": [1], "7.1.1": [0.927295218], "8.1.3": [3], "8.3": [0], "9.4": [0], "10.3": [-20 / 3],
    "10.2.1.1": [-4.8 + 4 * np.sqrt(0.44)],
    "6.4": [[-np.sin(0.4) - np.sin(-0.3), np.cos(0.4) + np.cos(-0.3)]],
}  # fmt: skip


def test_everything_of_the_source_has_a_page() -> None:
    pages = [mf.book.section(number) for number in PAGES]
    for name, known in (
        ("figures", mf.book.figures()),
        ("examples", mf.book.examples()),
        ("remarks", mf.book.remarks()),
    ):
        shown = list(chain.from_iterable(getattr(page, name) for page in pages))
        assert len(shown) == len(set(shown)), name
        assert set(shown) == set(known), name
    assert sorted(chain.from_iterable(page.exercises for page in pages)) == sorted(mf.book.exercises())
    assert len(PAGES) == 76


@pytest.mark.parametrize("number", SECTIONS)
def test_a_page_in_both_languages(number: str) -> None:
    page = mf.book.section(number)
    for language in ("en", "ar"):
        text = page.explain(language)
        assert number in text
        assert page.words("", language) in text
        if page:
            assert page.words("caption", language) in text
            assert page.call in text
            assert all(figure in text for figure in page.figures)
            assert page.to_markdown(language).startswith("## ")
        else:
            assert page.within or page.status.sentence(language) in text
    assert page.to_dict()["number"] == number


@pytest.mark.parametrize("number", sorted(COUNTEREXAMPLES))
def test_errata_are_proved_on_the_spot(number: str) -> None:
    page = mf.book.section(number)
    assert page.erratum
    assert page.errata >= 1
    assert any(not fact.agrees for fact in page.facts)
    for fact, right in zip(page.facts, RIGHT.get(number, ()), strict=False):
        assert fact.value == pytest.approx(np.asarray(right), abs=1e-6)
    if number in ("7.2", "10.2.3"):
        fact = page.facts[0]
        assert fact.value < 0.6 * fact.printed
    if number == "7.3":
        assert page["cost"] < page.facts[0].printed


def test_the_table_has_a_row_for_each_section() -> None:
    heads, *rows = section_table("en")
    assert [row[0] for row in rows] == SECTIONS
    for row in rows:
        page = dict(zip(heads, row, strict=True))
        if page["figures"] != "-" or page["examples"] != "-" or page["exercises"] != "-":
            assert page["tests"] != "-", page
    assert sum(int(row[heads.index("errata")]) for row in rows) >= 78


def test_numbers_keep_their_direction_on_arabic_pages() -> None:
    assert '<bdi dir="ltr">(1, 3, 0)</bdi>' in mf.book.section("4.3.3.3").to_markdown("ar")


def test_unknown_sections_and_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(InputError, match=r"4\.2\.3"):
        mf.book.section("4.2.9")
    assert main(["book", "4.3.3.3"]) == 0
    assert "(1, 3, 0)" in capsys.readouterr().out
    assert main(["book", "figur"]) != 0
    assert "exercise" in capsys.readouterr().err


@pytest.mark.parametrize(("words", "kind", "number"), [
    ("اليعقوبي", "section", "6.1.1"), ("يعقوبي الفضاء", "section", "6.1.1"), ("يعقوبيّ", "section", "6.1.2"),
    ("تلوّ", "exercise", "4.4.3 wrench"), ("تلوٍّ", "exercise", "4.4.3 wrench"), ("التلوّيات", "section", "4.4.3"),
    ("زوايا اويلر", "section", "4.2.3"), ("وزوايا أويلر", "section", "4.2.3"), ("JACOBIAN", "section", "6.1.1"),
    ("pole", "figure", "4.1"), ("friction", "section", "10.2.1.4"), ("هيئات شاذة", "section", "6.3"),
])  # fmt: skip
def test_search_with_and_without_marks_and_article(words: str, kind: str, number: str) -> None:
    found = mf.book.find(words)
    assert (kind, number) in [entry[:2] for entry in found]
    assert all(title for _, _, title in found)


def test_search_finds_nothing_where_nothing_is() -> None:
    assert mf.book.find("") == []
    assert mf.book.find("quaternion jerk") == []
    assert mf.book.find("(") == mf.book.find("  ( ")
    assert main(["book", "find", "zzz"]) != 0
    assert main(["book", "find", "التلوي"]) == 0
