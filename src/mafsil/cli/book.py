"""`mafsil book`: entries of the textbook by number, sheets of exercises, marks."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import mafsil.book as book_of
from mafsil.book.exercise import title_of
from mafsil.book.sheet import marks_csv, read_students
from mafsil.cli.answer import PLAIN, Answer, Toned, draw_picture, require_kind
from mafsil.cli.state import count
from mafsil.cli.table import table
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.whole_file import write_whole

_OPEN = {
    "section": book_of.section, "figure": book_of.figure, "example": book_of.example, "remark": book_of.remark,
    "exercise": book_of.exercise, "erratum": book_of.erratum,
}  # fmt: skip
_LISTS = {
    "section": book_of.sections, "figure": book_of.figures, "example": book_of.examples, "remark": book_of.remarks,
    "exercise": book_of.exercises, "erratum": book_of.errata,
}  # fmt: skip

KINDS = (*_OPEN, "sheet", "marks", "find")
"""What the book has, and what is made of its exercises."""


def book(
    what: str | None = None,
    number: str | None = None,
    picture: str | None = None,
    seed: str | None = None,
    level: str | None = None,
    answer: list[str] | None = None,
    hints: str | None = None,
    solution: bool = False,
    students: str | None = None,
    exam: bool = False,
    eastern_digits: bool = False,
    files: list[str] | None = None,
    out: str | None = None,
) -> Answer:
    """One entry of the book explained, draw_picture or judged, sheets of exercises, or the numbers and titles of all.

    Args:
        what: a section such as `4.2.3`, or one of KINDS; all entries if None.
        number: as the book has it, of exercises and sheets a section, or words to find; all of that kind if None.
        picture: file for a figure: PNG, SVG or PDF.
        seed, level: of exercises.
        answer: answers to an exercise, `NAME=NUMBERS`.
        hints: how many hints of an exercise are shown, from the first one on.
        solution: with hints and solution of an exercise.
        students: CSV file with the names of those who get a sheet each.
        exam: sheets that do not judge themselves.
        eastern_digits: Arabic-Indic digits in the Arabic sentences of sheets.
        files: answers that students saved.
        out: HTML page of a section, folder of sheets, or file of marks.

    Raises:
        InputError: no such entry, or a picture of what is no figure.
        FileError: a file that cannot be read or written.
    """
    if what is not None and what not in KINDS:
        if not what[:1].isdigit():
            raise InputError("input.choice", name="what", value=what, known=", ".join((*KINDS, "4.2.3")))
        what, number = "section", what
    if picture is not None and (what != "figure" or number is None):
        raise InputError("cli.book_no_figure")
    drawn_from, difficulty = count("seed", seed or "0"), count("level", level or "1")
    options: dict[str, Any] = {"level": difficulty, "exam": exam, "eastern_digits": eastern_digits}
    collections: dict[str, Callable[[], Answer]] = {
        "sheet": lambda: _sheets(number or "", students, Path(out or "."), seed=drawn_from, **options),
        "marks": lambda: _marks(files or [], out),
        "find": lambda: _find(number or ""),
    }
    if what in collections:
        return collections[what]()
    if what is None or number is None:
        return _entries(what)
    if what == "exercise":
        shown = count("hints", hints or "0")
        return _exercise(number, drawn_from, difficulty, answer or [], hints=shown, solution=solution)
    return _entry(what, number, picture, out)


def _entry(what: str, number: str, picture: str | None, out: str | None) -> Answer:
    """One entry explained, with its picture or page, and what to type next."""
    entry = _OPEN[what](number)
    lines = entry.explain().split("\n")
    if picture is not None:
        require_kind(picture, PLAIN)
        lines.append(draw_picture(book_of.figure(number).save, picture, {}))
    data = entry.to_dict()
    if what == "section" and out is not None:
        book_of.section(number).save(out)
        lines = [say("cli.book_written", path=out)]
    elif what == "section" and (commands := _next_commands(number, data)):
        lines += [say("cli.book_next"), *commands]
    return Answer(data, tuple(lines))


def _next_commands(number: str, section: dict[str, Any]) -> list[str]:
    """How the figures and exercises of a section are opened."""
    commands = [f"mafsil book figure {each} --picture FILE.png" for each in section["figures"][:1]]
    return commands + [f"mafsil book exercise {number} --seed 1"] * bool(section["exercises"])


def _find(words: str) -> Answer:
    rows = [list(row) for row in book_of.find(words)]
    refusal = None if rows else say("cli.book_not_found", words=words)
    return Answer({"entries": rows}, tuple(_list_lines(rows)) if rows else (), refusal)


def _entries(what: str | None) -> Answer:
    """Numbers and titles."""
    kinds = _OPEN if what is None else (what,)
    titles = {
        kind: {each: title_of(each) if kind == "exercise" else _OPEN[kind](each).title for each in _LISTS[kind]()}
        for kind in kinds
    }
    rows = [[kind, each, title] for kind, entries in titles.items() for each, title in entries.items()]
    return Answer(titles, tuple(_list_lines(rows)))


def _list_lines(rows: list[list[str]]) -> list[str]:
    return table([say(f"cli.book_{key}") for key in ("kind", "at", "title")], rows, words=(2,))


def _exercise(number: str, seed: int, level: int, answers: Sequence[str], *, hints: int, solution: bool) -> Answer:
    """An exercise, with its solution or with the judgement of answers."""
    one = book_of.exercise(number, seed=seed, level=level)
    lines, data = one.explain().split("\n"), one.to_dict()
    lines += [f"- {hint}" for hint in one.hints()[:hints]]
    if solution:
        lines += [f"{k}. {step}" for k, step in enumerate(one.solution(), start=1)] + one.derive().split("\n")
    if not answers:
        hidden = () if solution else ("hints", "solution", "answers")
        asks = " ".join(f"{part.name}=..." for part in one.asked)
        drawn = f'mafsil book exercise "{one.number}" --seed {seed}' + (f" --level {level}" if level != 1 else "")
        further = ["--hints 1"] if not hints and data["hints"] else []
        more = [] if solution else [f"{drawn} {option}" for option in (*further, f"--answer {asks}", "--solution")]
        lines += [say("cli.book_next"), *more] if more else []
        return Answer({key: value for key, value in data.items() if key not in hidden}, tuple(filter(None, lines)))
    named: dict[str, str] = {}
    for text in answers:
        name, sign, value = text.partition("=")
        if not sign:
            raise InputError("cli.book_unnamed", text=text, known=", ".join(part.name for part in one.asked))
        named[name.strip()] = value
    verdict = one.check(named)
    wrong = (
        None if verdict else say("cli.book_wrong", number=one.number, points=verdict.points, greatest=verdict.greatest)
    )
    head, *rest = verdict.explain().split("\n")
    return Answer(data | verdict.to_dict(), (*lines, Toned(head, "good" if verdict else "bad"), *rest), wrong)


def _sheets(section: str, students: str | None, folder: Path, *, seed: int, **options: Any) -> Answer:
    """A sheet and its answers for each student."""
    folder.mkdir(parents=True, exist_ok=True)
    written: list[str] = []
    for student in read_students(students) if students else [""]:
        sheet = book_of.sheet(section, seed=seed, student=student, **options)
        name = re.sub(r"[^\w -]+", "_", student) or f"sheet-{seed}"
        for ending, answers in ((".html", False), (".answers.html", True)):
            path = folder / f"{name}{ending}"
            sheet.save(path, answers=answers)
            written.append(str(path))
    return Answer({"written": written}, tuple(say("cli.book_written", path=path) for path in written))


def _marks(files: Sequence[str], out: str | None) -> Answer:
    """Points of each student and exercise."""
    if not files:
        raise InputError("cli.book_no_files")
    rows = book_of.collect_marks(files)
    if out is not None:
        write_whole(Path(out), marks_csv(rows).encode("utf-8-sig"))
    heads = ["student", "exercise", "points", "greatest", "mistakes"]
    lines = table(heads, [[str(row[head]) for head in heads] for row in rows], words=(0, 4))
    return Answer({"marks": rows}, (*lines, *([say("cli.book_written", path=out)] if out else [])))
