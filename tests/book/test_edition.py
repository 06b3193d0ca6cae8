"""The edition: a page or an honest no for each section, nothing of the source without a page, errata with proof."""

from __future__ import annotations

import re
import shlex
from collections import Counter
from functools import reduce
from itertools import chain
from pathlib import Path
from xml.etree import ElementTree

import axe_core_python
import numpy as np
import pytest

import mafsil as mf
from mafsil.book.edition import section_table
from mafsil.book.entry import Fact
from mafsil.book.formula_markup import TOKEN, mathml
from mafsil.cli.main import main
from mafsil.errors import InputError
from tests.page.browser import Browser

AXE = Path(axe_core_python.__file__).with_name("axe.min.js").read_text("utf-8")
SECTIONS = mf.book.sections()
PAGES = [number for number in SECTIONS if mf.book.section(number)]
RIGHT = {
    "02-E12": 2 * 6 - 5, "03-E10": True, "04-E14": -1, "04-E35": [np.sin(1), 1 - np.cos(1), 0], "04-E40": [0, 1, 0],
    "05-E1": 1, "07-E7": 0.927295218, "07-E12": -0.175, "08-E2": 3, "08-E8": 0, "09-E23": 0, "10-E21": -20 / 3,
    "10-E3": -4.8 + 4 * np.sqrt(0.44), "05-E27": [-np.sin(0.4) - np.sin(-0.3), np.cos(0.4) + np.cos(-0.3)],
    "11-E7": 2 - np.sqrt(3.88), "11-E4": 40, "10-E23": 12, "05-E28": 1, "07-E25": [0, 0, 0], "04-E37": np.eye(3),
    "09-E17": [-np.sin(-0.7) * (2 * 0.5 * -0.3 + 0.09), np.sin(-0.7) * 0.25], "07-E30": 0, "10-E24": [0, 0],
    "10-E1": -2.1, "04-E45": [0, -1, 0], "08-E12": [100 / np.sqrt(2)] * 2, "02-E26": 6,
    "10-E10": False, "03-E16": 1, "05-E19": 1,
}  # fmt: skip
"""What is right, by other means than the proofs."""
LISTED = {"02": (29, 15), "03": (28, 20), "04": (49, 18), "05": (32, 15), "07": (42, 9), "08": (19, 8), "09": (30, 6),
          "10": (29, 16), "11": (12, 0)}  # fmt: skip
"""Errata of each part of the specification: of its first and of its further list."""
PROVED = [number for number in mf.book.errata() if mf.book.erratum(number).proof]


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
    assert PAGES == SECTIONS


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


def test_every_erratum_of_the_specification_stands_on_its_section() -> None:
    counts = Counter(number[:4] for number in mf.book.errata())
    assert counts == {
        f"{part}-{kind}": n for part, both in LISTED.items() for kind, n in zip("ED", both, strict=True) if n
    }
    shown = [number for section in SECTIONS for number in mf.book.section(section).errata]
    assert sorted(shown) == sorted(mf.book.errata())
    assert len(PROVED) >= 300
    for language in ("en", "ar"):
        pages = {section: mf.book.section(section).explain(language) for section in SECTIONS}
        for number in shown:
            entry = mf.book.erratum(number)
            text = entry.explain(language)
            assert number in text
            assert entry.words("", language) in text
            assert text in pages[entry.section]


@pytest.mark.parametrize("number", PROVED)
def test_what_is_printed_is_not_right(number: str) -> None:
    proof = mf.book.erratum(number).proof
    assert proof is not None
    assert not proof.agrees
    assert Fact("proof", proof.printed, proof.printed).agrees
    if number in RIGHT:
        assert proof.value == pytest.approx(np.asarray(RIGHT[number]), abs=1e-6)


@pytest.mark.parametrize(("number", "share"), [("07-E36", 0.1), ("07-E37", 0.1), ("10-E18", 0.6), ("07-E39", 0.9)])
def test_the_right_step_is_better(number: str, share: float) -> None:
    proof = mf.book.erratum(number).proof
    assert proof is not None
    assert proof.value < share * proof.printed


@pytest.mark.parametrize("number", SECTIONS)
def test_what_a_page_calls_exists(number: str) -> None:
    call = mf.book.section(number).call
    for path in re.findall(r"\bmf(?:\.\w+)+", call):
        assert reduce(getattr, path.split(".")[1:], mf) is not None
    for robot in re.findall(r"load\('(\w+)'\)", call):
        assert mf.load(robot).n
    for name in re.findall(r"^robot\.(\w+)", call):
        assert hasattr(mf.load("puma560"), name), name


def test_the_table_has_a_row_for_each_section() -> None:
    heads, *rows = section_table("en")
    assert [row[0] for row in rows] == SECTIONS
    for row in rows:
        page = dict(zip(heads, row, strict=True))
        if page["figures"] != "-" or page["examples"] != "-" or page["exercises"] != "-":
            assert page["tests"] != "-", page
    assert sum(int(row[heads.index("errata")]) for row in rows) == len(mf.book.errata())


def test_numbers_keep_their_direction_on_arabic_pages() -> None:
    assert '<bdi dir="ltr">Rz(pi / 2) @ [1, 0, 0] + [1, 2, 0] = (1, 3, 0)</bdi>' in mf.book.section(
        "4.3.3.3"
    ).to_markdown("ar")


def test_unknown_sections_and_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(InputError, match=r"4\.2\.3"):
        mf.book.section("4.2.9")
    with pytest.raises(InputError, match="04-E12"):
        mf.book.erratum("04-E120")
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


def test_a_live_figure_moves_as_the_figure_does() -> None:
    data = mf.book.figure("4.6").live_data()
    (slider,) = data["sliders"]
    assert len(slider["frames"]) == 25
    first = data["panels"][0]["shapes"]
    changed = [shape for shape in slider["frames"][0][0][0] if shape != 0]
    assert 0 < len(changed) < len(first)
    still, moving = mf.book.figure("4.6"), mf.book.figure("4.6", theta=slider["least"])
    names = [one.name for one in next(iter(still.panels.values())).elements]
    same = [
        np.array_equal(a.points, b.points)
        for a, b in zip(*(next(iter(one.panels.values())).elements for one in (still, moving)), strict=True)
    ]
    assert [one == 0 for one in slider["frames"][0][0][0]] == same, names
    assert slider["frames"][0][1]["en"] == [moving.fact_line(fact, "en") for fact in moving.facts]


@pytest.mark.parametrize("number", ["2.2.1", "7.0", "10.2.1.2"])
def test_a_page_redraws_its_figures_in_the_browser(number: str, tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    assert main(["book", number, "--out", str(path)]) == 0
    assert path.stat().st_size < 400_000
    with Browser(tmp_path) as browser:
        browser.load(path, drawn="document.querySelectorAll('.pictures svg > *').length")
        before = browser.ask("[...document.querySelectorAll('.pictures svg')].map(one => one.innerHTML).join()")
        assert "NaN" not in before
        assert "undefined" not in before
        for place in (0.31, 1.0):
            browser.ask(
                "document.querySelectorAll('input[type=range]').forEach(one => { one.value = Number(one.min) + "
                f"{place} * (one.max - one.min); one.dispatchEvent(new Event('input', {{bubbles: true}})); }})"
            )
            after = browser.ask("[...document.querySelectorAll('.pictures svg')].map(one => one.innerHTML).join()")
            assert before != after
            assert "NaN" not in after
        for language in ("ar", "en"):
            browser.ask(f"document.documentElement.lang === '{language}' || document.querySelector('button').click()")
            assert (
                browser.ask(f"{AXE}; axe.run().then(found => found.violations.map(v => v.id + v.nodes[0].html))") == []
            )
            browser.picture(tmp_path / f"{language}.png")
        assert browser.errors == []
        assert [url for url in browser.requests if not url.startswith(("file:", "blob:", "data:"))] == []


def test_a_section_and_an_exercise_say_what_to_type_next(capsys: pytest.CaptureFixture[str]) -> None:
    """What they name runs: the command of a section draws an exercise, that of an exercise takes its answer."""
    assert main(["book", "4.3.2"]) == 0
    drawn = capsys.readouterr().out.rstrip().split("\n")[-1]
    assert main(shlex.split(drawn)[1:]) == 0
    answered, solved = capsys.readouterr().out.rstrip().split("\n")[-2:]
    assert main(shlex.split(solved)[1:]) == 0
    right = capsys.readouterr().out.rstrip().rpartition("= ")[2]
    assert main(shlex.split(answered.replace("...", right))[1:]) == 0


def test_every_formula_of_the_pages_is_typeset_whole() -> None:
    """Nothing of a formula is left out, brackets and elements close, and only letters that it has are written."""
    formulas = {formula for number in mf.book.sections() for formula in mf.book.section(number).formulas}
    assert len(formulas) > 100
    for formula in formulas:
        assert not TOKEN.sub("", formula).strip(), formula
        root = ElementTree.fromstring(mathml(formula))
        assert root.tag == "math"
        signs, roots = "".join(root.itertext()), sum(1 for _ in root.iter("msqrt"))
        assert roots == formula.count("sqrt(")
        assert [signs.count(sign) for sign in "[]|,"] == [formula.count(sign) for sign in "[]|,"]
        assert [signs.count(sign) + roots for sign in "()"] == [formula.count(sign) for sign in "()"]


def test_indices_powers_roots_and_derivatives_of_formulas() -> None:
    assert "<msub><mi>θ</mi><mi>1</mi></msub>" in mathml("theta_1 = 0")
    assert "<msup><mi>T</mi><mrow>" in mathml("T^-1")
    assert "<msqrt>" in mathml("w = sqrt(det(J J'))")
    assert "×" in mathml("m = r x f")
    assert "×" not in mathml("A x = b")
    assert "<mfrac>" in mathml("dV/dt")
    assert "</mrow><mo>⊤</mo></msup>" in mathml("(a b)'")
