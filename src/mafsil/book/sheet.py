"""Sheets of exercises: one HTML file that works from disk and judges itself, its answers for the teacher, marks."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from html import escape
from io import StringIO
from os import PathLike
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

from mafsil.arrays import whole
from mafsil.book.exercise import AREA, Exercise, exercise, exercises
from mafsil.book.judging import page_rules
from mafsil.csv_table import read_csv_table
from mafsil.derivation.html import sentence, steps_html
from mafsil.errors import InputError
from mafsil.messages import LANGUAGES, direction, keys, language, say
from mafsil.scene import one_script
from mafsil.scene.inline import embed_json, policy
from mafsil.scene.modules import read
from mafsil.typed_number import eastern
from mafsil.whole_file import write_whole

_BUTTONS = ("check", "hint", "save_marks", "print", "other_language")
_COLUMNS = ("student", "exercise", "seed", "level", "quantity", "answer")
_PLACE = "\ue000"
"""Stands for a matrix while a sentence is cut into its runs."""
_MATRIX = re.compile(r"\[[^\[\];]*;[^\[\]]*\]")


@dataclass(frozen=True, eq=False, slots=True)
class Sheet:
    """Exercises of one student.

    Attributes:
        exercises: in order.
        seed: from which it was drawn, together with the student's name.
        student: name, or "".
        is_exam: whether it is without hints, solutions and the forms that judge; then `collect_marks` judges.
        eastern_digits: whether its Arabic sentences have Arabic-Indic digits; formulas keep theirs.
    """

    exercises: tuple[Exercise, ...]
    seed: int
    student: str
    is_exam: bool
    eastern_digits: bool = False

    def save(self, path: str | PathLike[str], *, answers: bool = False) -> None:
        """Write it as one HTML file that asks the network for nothing.

        Args:
            path: of the file.
            answers: with the solutions open and no fields, for the teacher.

        Raises:
            FileError: the place cannot be written.
        """
        write_whole(Path(path), self.to_html(answers=answers).encode())

    def to_html(self, *, answers: bool = False) -> str:
        """The page, in Arabic and English; it opens in the current language.

        Args:
            answers: with the solutions open and no fields, for the teacher.
        """
        code, script = language(), "" if answers else _script()
        style = f"{read('page/page.css').strip()}\n{read('book/sheet.css').strip()}"
        title = {lang: self._title(lang, answers=answers) for lang in LANGUAGES}
        body = "\n".join(self._section(k, answers=answers) for k in range(len(self.exercises)))
        data = "" if answers else f'<script type="application/json" id="data">{embed_json(self._data(title))}</script>'
        tools = (
            ""
            if answers
            else '<span id="points" class="chip" dir="ltr"></span>' + _buttons("save_marks", "print", "other_language")
        )
        page = (
            f'<!doctype html>\n<html lang="{code}" dir="{direction(code)}">\n<head>\n<meta charset="utf-8">\n'
            f'<meta http-equiv="Content-Security-Policy" content="{policy(style, script)}">\n'
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            '<meta name="color-scheme" content="light dark">\n<meta name="generator" content="mafsil">\n'
            f"<title>{escape(title[code])}</title>\n<style>{style}</style>\n</head>\n<body>\n<main>\n<header>\n"
            f"<h1>{both_languages(title)}</h1>\n{tools}</header>\n"
            f"{'' if answers else _paragraph('sheet_hint', 'soft')}\n{body}\n</main>\n{data}\n"
            f"{f'<script>{script}</script>' if script else ''}\n</body>\n</html>\n"
        )
        return _with_eastern_digits(page) if self.eastern_digits else page

    def _title(self, code: str, *, answers: bool) -> str:
        key = f"{AREA}.{'sheet_answers' if answers else 'sheet_title'}"
        text = say(key, language=code, seed=self.seed)
        return say(f"{AREA}.sheet_for", language=code, title=text, student=self.student) if self.student else text

    def _section(self, k: int, *, answers: bool) -> str:
        one = self.exercises[k]
        place = {"k": k + 1, "section": one.number.split()[0]}
        titles = {c: one.words("title", c) for c in LANGUAGES}
        name = {
            c: say(f"{AREA}.sheet_heading", language=c, title=title[:1].upper() + title[1:], **place)
            for c, title in titles.items()
        }
        parts = [
            f'<h2 id="title-{k}">{both_languages(name)}</h2>',
            f"<p>{both_languages({c: one.words('text', c) for c in LANGUAGES})}</p>",
        ]
        if not answers:
            parts += [self._field(k, j) for j in range(len(one.asked))]
            buttons = () if self.is_exam else ("check", "hint")
            parts.append(_buttons(*buttons, k=k) if buttons else "")
        if answers or not self.is_exam:
            parts.append(_hints(one) if not answers else "")
            parts.append(_solution(one, answers=answers))
        return (
            f'<section id="exercise-{k}" aria-labelledby="title-{k}">\n'
            + "\n".join(filter(None, parts))
            + "\n</section>"
        )

    def _field(self, k: int, j: int) -> str:
        part = self.exercises[k].asked[j]
        name, rows = f"answer-{k}-{part.name}", part.shape[0] if len(part.shape) == 2 else 1
        label = both_languages({code: part.label(code) for code in LANGUAGES})
        return (
            f'<div class="asked"><label for="{name}">{label}</label><textarea id="{name}" rows="{rows}" dir="ltr" '
            f'spellcheck="false" autocomplete="off" aria-describedby="{name}-verdict"></textarea>'
            f'<p class="verdict" id="{name}-verdict" role="status"></p></div>'
        )

    def _data(self, titles: Mapping[str, str]) -> dict[str, Any]:
        entries: list[dict[str, Any]] = []
        for one in self.exercises:
            parts = [part.page_data() for part in one.asked]
            if self.is_exam:
                parts = [part | {"forms": [], "mistakes": []} for part in parts]
            entries.append({"number": one.number, "seed": one.seed, "level": one.level, "parts": parts})
        used = {name for one in self.exercises for part in one.asked for name, _ in part.mistakes}
        name = f"{self.student or 'sheet'}-{self.seed}"
        return {
            "exercises": entries, "student": self.student, "name": name, "exam": self.is_exam, "titles": dict(titles),
            "key": f"{crc32(repr([(e['number'], e['seed'], e['level']) for e in entries]).encode()):x}",
            "words": {code: _words(code, used) for code in LANGUAGES},
            "rules": page_rules(),
        }  # fmt: skip


def sheet(
    section: str = "",
    *,
    seed: int = 0,
    level: int = 1,
    count: int = 10,
    student: str = "",
    exam: bool = False,
    eastern_digits: bool = False,
) -> Sheet:
    """A sheet of exercises with its own numbers for each seed and student.

    Args:
        section: from which the families are taken, such as "4" or "4.2"; all if empty.
        seed: of the class.
        level: 1 to 3.
        count: number of exercises, up to 100.
        student: whose it is.
        exam: without hints, solutions and judgement in the page.
        eastern_digits: Arabic-Indic digits in its Arabic sentences.

    Raises:
        InputError: a section without exercises, no such level.
    """
    families = exercises(section)
    if not families:
        exercise(section)
    seed, count, student = whole("seed", seed), whole("count", count, least=1, most=100), str(student)
    own = np.random.default_rng([seed, crc32(student.encode())])
    rounds = (own.permutation(len(families)) for _ in range(-(-count // len(families))))
    order = [families[int(k)] for turn in rounds for k in turn][:count]
    order.sort(key=exercises().index)
    drawn = tuple(exercise(number, seed=int(own.integers(10**6)), level=level) for number in order)
    return Sheet(drawn, seed, student, exam, eastern_digits)


def read_students(path: str | PathLike[str]) -> list[str]:
    """Names of a class, each once: the column `student` or `name` of a CSV file; without either its first cells.

    Of those who have the same name the second becomes `NAME (2)`. A first line without such a column is a student's.

    Raises:
        FileError: a file that cannot be read.
    """
    table = read_csv_table(path, fewest=1)
    column = table.column("student", "name", "الاسم", "الطالب")
    rows = table.rows if column is not None else [table.heads, *table.rows]
    names = [row[column or 0].strip() for row in rows if row[column or 0].strip()]
    before = [names[:k].count(name) for k, name in enumerate(names)]
    return [f"{name} ({k + 1})" if k else name for name, k in zip(names, before, strict=True)]


def collect_marks(paths: Iterable[str | PathLike[str]]) -> list[dict[str, Any]]:
    """Judge the answers that students saved from their sheets, anew from seed and number.

    Args:
        paths: CSV files that the pages wrote.

    Returns:
        A row for each student and exercise: student, exercise, points, greatest, and the mistakes by name.

    Raises:
        FileError: a file that cannot be read.
        InputError: a file that no sheet wrote.
    """
    answers: dict[tuple[str, str, int, int], dict[str, str]] = {}
    for path in paths:
        table = read_csv_table(path, fewest=1)
        columns = [table.column(name) for name in _COLUMNS]
        for row in table.rows:
            cells = [row[column].strip() for column in columns if column is not None]
            if len(cells) != len(_COLUMNS) or not (cells[2].isdigit() and cells[3].isdigit()):
                raise InputError(f"{AREA}.no_sheet", path=str(path))
            student, number, seed, level, quantity, answer = cells
            answers.setdefault((student, number, int(seed), int(level)), {})[quantity] = answer
    return [_marks(*key, given) for key, given in answers.items()]


def _marks(student: str, number: str, seed: int, level: int, given: Mapping[str, str]) -> dict[str, Any]:
    one = exercise(number, seed=seed, level=level)
    mistakes: dict[str, str] = {}
    points = 0
    for part in one.asked:
        try:
            verdict = next(v for v in one.check({part.name: given.get(part.name, "")}) if v.part == part.name)
            mistake = verdict.mistake
        except InputError:
            mistake = "unread"
        points += not mistake
        mistakes |= {part.name: mistake} if mistake else {}
    names = "; ".join(f"{part}: {mistake}" for part, mistake in mistakes.items())
    return {"student": student, "exercise": number, "points": points, "greatest": len(one.asked), "mistakes": names}


def marks_csv(rows: Sequence[Mapping[str, Any]]) -> str:
    """Rows of `collect_marks` as CSV."""
    text = StringIO()
    writer = csv.DictWriter(text, ["student", "exercise", "points", "greatest", "mistakes"], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


@cache
def _script() -> str:
    return "(() => {\n" + one_script("book/sheet.js") + "\n})();"


def _words(code: str, used: set[str]) -> dict[str, str]:
    placed = {"none", "empty", "other", "entries", "sign", "count", "missed", "solution", "unread"}
    known = {f"mistake_{name}" for name in placed | used} & keys(code, AREA)
    return {name: _label(name, code) for name in sorted(known | set(_BUTTONS))}


def _label(name: str, code: str | None = None) -> str:
    area = "page" if name == "other_language" else AREA
    return say(f"{area}.{name}", language=code, place="{place}")


def both_languages(texts: Mapping[str, str]) -> str:
    """A text in both languages; the page shows that of its own."""
    return "".join(
        f'<span data-lang="{code}" lang="{code}" dir="{direction(code)}">{_formulas(text, code)}</span>'
        for code, text in texts.items()
    )


def _with_eastern_digits(page: str) -> str:
    """The texts of a page inside what is marked as Arabic, without its formulas."""
    opened: list[bool] = []
    pieces = re.split(r"(<[^>]+>)", page)
    for k, piece in enumerate(pieces):
        if not k % 2:
            pieces[k] = eastern(piece) if opened and opened[-1] else piece
        elif piece.startswith("</"):
            opened = opened[:-1]
        elif not re.match(r"<(!|meta|br|input|img|hr)", piece):
            opened.append(not piece.startswith("<math") and ('lang="ar"' in piece or bool(opened and opened[-1])))
            opened[-1] &= not piece.startswith(("<html", "<script", "<style"))
    return "".join(pieces)


def _formulas(text: str, code: str) -> str:
    """A sentence with its matrices typeset; each stays in the formula that it belongs to."""
    matrices = iter(_MATRIX.findall(text))
    return re.sub(_PLACE, lambda _: _matrix(next(matrices)), sentence(_MATRIX.sub(_PLACE, text), code))


def _matrix(text: str) -> str:
    rows = "".join(
        "<mtr>" + "".join(f"<mtd><mn>{escape(cell.replace('-', '−'))}</mn></mtd>" for cell in row.split()) + "</mtr>"
        for row in text[1:-1].split(";")
    )
    return f'<math dir="ltr"><mtable class="matrix">{rows}</mtable></math>'


def _paragraph(key: str, kind: str) -> str:
    return f'<p class="{kind}">{both_languages({code: say(f"{AREA}.{key}", language=code) for code in LANGUAGES})}</p>'


def _buttons(*names: str, k: int | None = None) -> str:
    place = "" if k is None else f' data-k="{k}"'
    kinds = ("strong" if name == "check" else "quiet" for name in names)
    buttons = "".join(
        f'<button type="button" class="{kind}" data-say="{name}"{place}>{escape(_label(name))}</button>'
        for name, kind in zip(names, kinds, strict=True)
    )
    return f'<div class="buttons">{buttons}</div>'


def _hints(one: Exercise) -> str:
    by_language = {code: one.hints(code) for code in LANGUAGES}
    count = len(by_language["en"])
    items = "".join(
        f"<li hidden>{both_languages({c: by_language[c][k] for c in LANGUAGES})}</li>" for k in range(count)
    )
    return f'<ol class="hints">{items}</ol>'


def _solution(one: Exercise, *, answers: bool) -> str:
    by_language = {code: one.solution(code) for code in LANGUAGES}
    count = len(by_language["en"]) - answers  # the results stand above the steps
    steps = "".join(f"<li>{both_languages({c: by_language[c][k] for c in LANGUAGES})}</li>" for k in range(count))
    body = f"<ol>{steps}</ol>"
    if one.derivation is not None and not answers:
        derivation = one.derivation()
        heading = both_languages({code: say(f"{AREA}.in_letters", language=code) for code in LANGUAGES})
        both = "".join(
            f'<div data-lang="{c}" lang="{c}" dir="{direction(c)}">{steps_html(derivation, c)}</div>' for c in LANGUAGES
        )
        body += f"<h3>{heading}</h3>{both}"
    if answers:
        results = both_languages({c: by_language[c][-1] for c in LANGUAGES})
        return f"<p><strong>{results}</strong></p>{body}"
    title = both_languages({code: say(f"{AREA}.solution", language=code) for code in LANGUAGES})
    return f'<details class="practice"><summary>{title}</summary>{body}</details>'
