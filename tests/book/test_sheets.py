"""Sheets: one file that asks nothing of the network, judged in the page as in Python, marks from saved answers."""

from __future__ import annotations

import json
import re
import time
from pathlib import Path

import axe_core_python
import pytest

import mafsil as mf
from mafsil.book.judging import Asked, judge, numbers_of, page_rules
from mafsil.book.sheet import collect_marks, marks_csv, read_students
from mafsil.cli.main import main
from mafsil.errors import InputError
from tests.page.browser import Browser
from tests.page.node import SOURCE, run_module
from tests.reliability.exercise_mistakes import equivalent_text, exercises, planted

JUDGE = """
import { readFileSync } from "node:fs";
import { judge, numbersOf } from "./judging.js";
const { rules, cases } = JSON.parse(readFileSync("cases.json", "utf8"));
const judged = cases.map(([part, text]) => {
  const given = numbersOf(part, text, rules);
  return given === null ? ["unread", ""] : judge(part, given, rules);
});
console.log(JSON.stringify(judged));
"""
ODD = (
    "1_000",
    "1_",
    "1__0",
    "_1",
    "inf",
    "nan",
    "1e3",
    "PI",
    "2π/3",
    "π * 2",
    ".5",
    "5.",
    "1,5؛ ٢",
    "3 DEG",
    "+-1",
    "1 / 2",
    "e3",
)
AXE = Path(axe_core_python.__file__).with_name("axe.min.js").read_text("utf-8")


def _python(part: Asked, text: str) -> list[str]:
    try:
        given = numbers_of(part, text)
    except InputError:
        return ["unread", ""]
    verdict = judge(part, given) if given.size else None
    return ["empty", ""] if verdict is None else [verdict.mistake, ", ".join(map(str, verdict.place))]


def test_the_page_judges_as_python_does(tmp_path: Path) -> None:
    cases: list[tuple[Asked, str]] = []
    for number in mf.book.exercises():
        for exercise, rng in exercises(2 if ": " in number else 6, number):
            for part in exercise.asked:
                wrong = planted(part, rng)
                noise = part.forms[0] + rng.normal(size=part.forms[0].size)
                forms = [part.forms[0], part.forms[-1], noise] + ([wrong[1]] if wrong else [])
                cases += [(part, equivalent_text(part, form, rng)) for form in forms]
                cases += [
                    (part, text)
                    for text in ("", "نعم", "no", "x", "1", "2 pi/3, ٣٫٥", "1/0", "5 %", "−3", "9e999", *ODD)
                ]
    text = {"rules": page_rules(), "cases": [(part.page_data(), typed) for part, typed in cases]}
    (tmp_path / "cases.json").write_text(json.dumps(text))
    (tmp_path / "judging.js").write_text((SOURCE / "book" / "judging.js").read_text("utf-8"))
    judged = json.loads(run_module(JUDGE, tmp_path))
    expected = [_python(part, typed) for part, typed in cases]
    differing = [
        (part.name, typed, here, there)
        for (part, typed), here, there in zip(cases, expected, judged, strict=True)
        if here != there
    ]
    assert len(cases) > 2000
    assert not differing, differing[:5]


@pytest.mark.parametrize("level", [1, 3])
def test_a_sheet_is_one_small_file(level: int, tmp_path: Path) -> None:
    sheet = mf.book.sheet(seed=level, level=level, student='Layla "<b>" & ليلى')
    page = sheet.to_html()
    assert len(page.encode()) < 400_000
    assert len(sheet.exercises) == 10
    assert "<b>" not in page.split("<body>")[1].split('id="data"')[0].replace("&lt;b&gt;", "")
    assert not re.search(r"(?:src|href)=|https?://(?!www\.w3\.org)", page)
    assert page == mf.book.sheet(seed=level, level=level, student='Layla "<b>" & ليلى').to_html()
    assert page != mf.book.sheet(seed=level, level=level, student="Omar").to_html()
    answers = sheet.to_html(answers=True)
    assert "<textarea" not in answers
    assert "<script" not in answers


def test_an_exam_holds_no_answers() -> None:
    page = mf.book.sheet("6", seed=4, count=3, exam=True).to_html()
    data = json.loads(re.search(r'id="data">(.*?)</script>', page, re.S)[1])  # type: ignore[index]
    assert all(not part["forms"] and not part["mistakes"] for one in data["exercises"] for part in one["parts"])
    assert "<details" not in page
    with pytest.raises(InputError):
        mf.book.sheet("12")


def test_a_student_answers_in_the_page(tmp_path: Path) -> None:
    sheet = mf.book.sheet("4", seed=7, level=2, student="Layla")
    path = tmp_path / "sheet.html"
    sheet.save(path)
    first = sheet.exercises[0]
    with Browser(tmp_path) as browser:
        browser.load(path, drawn="document.getElementById('points') && document.getElementById('points').textContent")
        for part in first.asked:
            text = ", ".join(f"{x:.5g}" for x in part.forms[-1])
            browser.ask(f"document.getElementById('answer-0-{part.name}').value = {json.dumps(text)}")
        browser.ask("document.querySelector('#exercise-0 [data-say=check]').click()")
        assert browser.ask("document.querySelectorAll('#exercise-0 .verdict.good').length") == len(first.asked)
        browser.ask("document.querySelector('#exercise-1 [data-say=hint]').click()")
        assert browser.ask("document.querySelectorAll('#exercise-1 .hints > li:not([hidden])').length") == 1
        browser.ask("document.querySelector('[data-say=other_language]').click()")
        assert browser.ask("document.documentElement.dir") == "rtl"
        assert "صحيح" in browser.ask("document.querySelector('#exercise-0 .verdict').textContent")
        browser.ask("document.querySelector('[data-say=save_marks]').click()")
        saved = browser.downloads / "Layla-7.csv"
        deadline = time.monotonic() + 20
        while not saved.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        for language in ("ar", "en"):
            browser.ask("document.querySelectorAll('details').forEach(one => { one.open = true; })")
            assert (
                browser.ask(f"{AXE}; axe.run().then(found => found.violations.map(v => v.id + v.nodes[0].html))") == []
            )
            browser.picture(tmp_path / f"{language}.png")
            browser.ask("document.querySelector('[data-say=other_language]').click()")
        assert browser.errors == []
        assert [url for url in browser.requests if not url.startswith(("file:", "blob:", "data:"))] == []
    rows = collect_marks([saved])
    assert (rows[0]["points"], rows[0]["greatest"]) == (len(first.asked), len(first.asked))
    assert "Layla" in marks_csv(rows)


def test_marks_are_judged_anew(tmp_path: Path) -> None:
    one = mf.book.exercise("4.3.3.1 screw", seed=2)
    right = " ".join(str(x) for x in one.asked[0].value)
    head = "student,exercise,seed,level,quantity,answer,points\n"
    (tmp_path / "a.csv").write_text(f'{head}Layla,4.3.3.1 screw,2,1,S,"{right}",0\nOmar,4.3.3.1 screw,2,1,S,"abc",1\n')
    rows = collect_marks([tmp_path / "a.csv"])
    assert [(row["student"], row["points"], row["mistakes"]) for row in rows] == [
        ("Layla", 1, ""),
        ("Omar", 0, "S: unread"),
    ]
    (tmp_path / "b.csv").write_text("a,b\n1,2\n")
    with pytest.raises(InputError):
        collect_marks([tmp_path / "b.csv"])


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "list.csv").write_text("student\nAli\nAli\nليلى\n", "utf-8")
    assert read_students(tmp_path / "list.csv") == ["Ali", "Ali (2)", "ليلى"]
    (tmp_path / "bare.csv").write_text("ليلى\nSam\n", "utf-8")
    assert read_students(tmp_path / "bare.csv") == ["ليلى", "Sam"]
    arguments = ["--seed", "7", "--students", str(tmp_path / "list.csv"), "--out", str(tmp_path / "class")]
    assert main(["book", "sheet", "2.2", *arguments]) == 0
    assert len(list((tmp_path / "class").glob("*.answers.html"))) == 3
    value = mf.book.exercise("9.1.1 particle", seed=3).asked[0].value.item()
    for answer, code in ((value, 0), (-value, 1)):
        assert main(["book", "exercise", "9.1.1 particle", "--seed", "3", "--answer", f"force={answer}"]) == code
    assert main(["book", "exercise", "9.1.1 torques", "--solution"]) == 0
    assert main(["book", "exercise", "9.1.1 torques", "--answer", "M"]) != 0
    assert main(["book", "marks"]) != 0
    capsys.readouterr()


def test_eastern_digits_stand_in_arabic_sentences_alone() -> None:
    western, eastern = (mf.book.sheet("4.2", seed=3, count=3, eastern_digits=flag).to_html() for flag in (False, True))
    assert not re.search("[٠-٩]", re.sub(r"<script.*?</script>", "", western, flags=re.S))
    back = eastern.translate(str.maketrans("٠١٢٣٤٥٦٧٨٩٫", "0123456789."))
    assert back == western.translate(str.maketrans("٠١٢٣٤٥٦٧٨٩٫", "0123456789."))
    for tag, text in re.findall(r'<(?:span|p|li) data-lang="(\w+)"[^>]*>(.*?)</', eastern):
        assert tag == "ar" or not re.search("[٠-٩]", text)
    assert re.search("[٠-٩]", eastern[: eastern.index("<script")])
    page = mf.book.section("4.3.2")
    assert re.search("[٠-٩]", page.to_markdown("ar", eastern_digits=True))
    assert page.to_markdown("en", eastern_digits=True) == page.to_markdown("en")
