"""The edition and its search: for each section a page of idea, formula, example, figure, erratum with its proof.

What stands on a page is declared in `edition.toml`, the words in the catalogue `book_pages`; sections that are only
named there have no page yet, and say so. Arabic is found with and without marks, article and joined particles.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cache, partial
from html import escape
from os import PathLike
from pathlib import Path
from typing import Any, ClassVar, cast

from mafsil.book.entry import Entry, EntryStatus
from mafsil.book.errata import errata, erratum
from mafsil.book.example import example, examples
from mafsil.book.exercise import exercises, title_of
from mafsil.book.family import families
from mafsil.book.figure import Figure, figure, figures, module_of
from mafsil.book.formula_markup import mathml
from mafsil.book.remarks import remark, remarks
from mafsil.book.sheet import both_languages
from mafsil.errors import InputError
from mafsil.messages import LANGUAGES, direction, in_sentence, keys, language, say
from mafsil.messages.catalogue import template
from mafsil.scene import one_script
from mafsil.scene.inline import embed_json, policy
from mafsil.scene.modules import read
from mafsil.toml_source import own_tables
from mafsil.typed_number import eastern
from mafsil.whole_file import write_whole

AREA = "book_pages"
_FIGURE, _EXAMPLE = cache(figure), cache(example)
"""At their first values: a page asks for them in two languages."""
_COLUMNS = ("section", "page", "figures", "examples", "errata", "exercises", "tests")


@dataclass(frozen=True, eq=False, repr=False)
class SectionPage(Entry):
    """The page of a section; false where there is none yet. See `Entry` for number, facts and words.

    Attributes:
        formulas: in the notation of docstrings.
        call: what computes it.
        figures, examples, remarks, exercises, errata: numbers of what belongs to it.
        within: numbers of the sections inside it.
    """

    AREA: ClassVar[str] = AREA
    formulas: Sequence[str] = ()
    call: str = ""
    figures: Sequence[str] = ()
    examples: Sequence[str] = ()
    remarks: Sequence[str] = ()
    exercises: Sequence[str] = ()
    errata: Sequence[str] = ()
    within: Sequence[str] = field(default=())

    def explain(self, language: str | None = None) -> str:
        """The whole page as lines of text, in `en`, `ar` or the current language."""
        return "\n".join(line for _, line in self._lines(language))

    def to_markdown(self, language: str | None = None, pictures: str = "", *, eastern_digits: bool = False) -> str:
        """The page for the site, beginning with its heading.

        Args:
            language: `en` or `ar`; the current one if None.
            pictures: folder of the figures' pictures, `NUMBER.svg`; none are shown if empty.
            eastern_digits: Arabic-Indic digits in the sentences of an Arabic page; formulas and code keep theirs.
        """
        written = partial(_isolate, language=language, digits=eastern if eastern_digits else str)
        lines: list[str] = []
        for kind, line in self._lines(language):
            match kind:
                case "heading":
                    lines.append(f"## {line}\n")
                case "formula" | "call":
                    lines.append(f"\n`{line}`\n")
                case "proof":
                    lines.append(f"  {_isolate(line, language)}")
                case "within" | "caption":
                    lines.append(f"\n{written(line)}\n")
                case _:
                    lines.append(f"- {written(line)}")
        shown = [
            f'<img src="{pictures}/{n}.svg" alt="{escape(_title(n, language))}" loading="lazy">' for n in self.figures
        ]
        live = say(f"{AREA}.live", language=language)
        link = [f'\n<a href="{pictures}/{self.number}.html">{escape(live)}</a>'] if shown else []
        return "\n".join([*lines, "", *([*shown, *link] if pictures else []), ""])

    def save(self, path: str | PathLike[str]) -> None:
        """Write it as one HTML file with live figures, in both languages, that asks the network for nothing.

        Raises:
            FileError: the place cannot be written.
        """
        write_whole(Path(path), self.to_html().encode())

    def to_html(self) -> str:
        """The page with its figures, whose sliders redraw them without Python; it opens in the current language."""
        lines = {code: self._lines(code) for code in LANGUAGES}
        pairs = zip(*lines.values(), strict=True)
        body = "\n".join(_html_line(kind, {"en": text, "ar": other}) for (kind, text), (_, other) in pairs)
        shown = [_FIGURE(number) for number in self.figures if _FIGURE(number).panels]
        blocks = "\n".join(_figure_block(k, one) for k, one in enumerate(shown))
        titles = {code: self.words("", code) for code in LANGUAGES}
        other = {code: say("page.other_language", language=code) for code in LANGUAGES}
        data = {"titles": titles, "other": other, "figures": [one.live_data() for one in shown]}
        code, script = language(), "(() => {\n" + one_script("book/page.js") + "\n})();"
        style = f"{read('page/page.css').strip()}\n{read('book/sheet.css').strip()}"
        return (
            f'<!doctype html>\n<html lang="{code}" dir="{direction(code)}">\n<head>\n<meta charset="utf-8">\n'
            f'<meta http-equiv="Content-Security-Policy" content="{policy(style, script)}">\n'
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            '<meta name="color-scheme" content="light dark">\n<meta name="generator" content="mafsil">\n'
            f"<title>{escape(titles[code])}</title>\n<style>{style}</style>\n</head>\n<body>\n<main>\n"
            f'<div class="buttons"><button type="button" class="quiet" data-say="other_language">{escape(other[code])}'
            f"</button></div>\n{body}\n{blocks}\n</main>\n"
            f'<script type="application/json" id="data">{embed_json(data)}</script>\n<script>{script}</script>\n'
            "</body>\n</html>\n"
        )

    def to_dict(self) -> dict[str, Any]:
        """What `Entry` has, and what stands on the page."""
        names = ("formulas", "call", "figures", "examples", "remarks", "exercises", "errata", "within")
        return super().to_dict() | {name: getattr(self, name) for name in names}

    def _lines(self, language: str | None) -> list[tuple[str, str]]:
        head, *rest = Entry.explain(self, language).split("\n")
        lines = [("heading", head)]
        lines += [("within", say(f"{AREA}.within", language=language, numbers=", ".join(self.within)))] * bool(
            self.within
        )
        if not self.status.succeeded and not self.within:
            lines.append(("caption", self.status.sentence(language)))
        lines += [("caption", line) for line in rest[:1]]
        lines += [("formula", formula) for formula in self.formulas]
        lines += [("call", self.call)] * bool(self.call)
        lines += [("fact", line) for line in rest[1:]]
        for number in self.figures:
            shown = _FIGURE(number)
            lines.append(
                ("figure", say(f"{AREA}.see_figure", language=language, number=number, title=shown.words("", language)))
            )
            wrong = shown.words("erratum", language)
            lines += [("erratum", say("book.erratum", language=language, text=wrong))] * bool(wrong)
        entries: list[Entry] = [*map(_EXAMPLE, self.examples), *map(remark, self.remarks)]
        lines += [("entry", line) for entry in entries for line in entry.explain(language).split("\n")]
        for number in self.errata:
            lines += zip(("erratum", "proof"), erratum(number).explain(language).split("\n"), strict=False)
        for number in self.exercises:
            title = title_of(number, language)
            lines.append(("exercise", say(f"{AREA}.see_exercise", language=language, number=number, title=title)))
        return lines


def _isolate(line: str, language: str | None, digits: Callable[[str], str] = str) -> str:
    """A line of Markdown whose numbers and formulas keep their direction."""

    def write(text: str) -> str:
        return escape(digits(text))

    return in_sentence(line, language, "page", words=write, foreign=write if direction(language) == "rtl" else escape)


def _html_line(kind: str, texts: Mapping[str, str]) -> str:
    """A line of a page in both languages."""
    if kind == "formula":
        return f'<p dir="ltr" class="formula">{mathml(texts["en"])}</p>'
    if kind == "call":
        return f'<p dir="ltr"><code>{escape(texts["en"])}</code></p>'
    if kind == "proof":
        return "".join(
            f'<p class="soft" data-lang="{code}" lang="{code}" dir="{direction(code)}">{_isolate(text, code)}</p>'
            for code, text in texts.items()
        )
    name = {"heading": "h1"}.get(kind, "p")
    return f"<{name}>{both_languages(texts)}</{name}>"


def _unit_text(unit: str) -> str:
    return f" [{escape(unit)}]" if unit not in ("", "1") else ""


def _figure_block(k: int, one: Figure) -> str:
    """Heading, pictures, sliders and facts of a figure; the pictures and the facts are drawn by the page."""
    heading = both_languages({
        code: say(f"{AREA}.see_figure", language=code, number=one.number, title=one.words("", code))
        for code in LANGUAGES
    })  # fmt: skip
    sliders = "".join(
        f'<label class="slider" dir="ltr"><span>{escape(name)}{_unit_text(s.unit)}</span>'
        f'<input type="range" data-k="{n}" '
        f'min="{s.least}" max="{s.greatest}" step="any" value="{s.value}"><output>{s.value:.2f}</output></label>'
        for n, (name, s) in enumerate(one.parameters.items())
    )
    captions = both_languages({code: one.words("caption", code) for code in LANGUAGES})
    facts = "".join(
        f'<ul class="facts" data-lang="{code}" lang="{code}" dir="{direction(code)}"></ul>' for code in LANGUAGES
    )
    return (
        f'<section id="figure-{k}" aria-labelledby="figure-{k}-title"><h2 id="figure-{k}-title">{heading}</h2>'
        f'<div class="pictures"></div>{sliders}<p>{captions}</p>{facts}</section>'
    )


def _title(number: str, language: str | None) -> str:
    return _FIGURE(number).words("", language)


@cache
def _pages() -> Mapping[str, Mapping[str, Any]]:
    return cast("Mapping[str, Mapping[str, Any]]", own_tables(__file__))


def sections() -> list[str]:
    """Numbers of all sections of the source, in its order."""
    numbers = [key for key in keys("en", AREA) if re.fullmatch(r"\d[\d.]*", key)]
    return sorted(numbers, key=lambda number: [int(part) for part in number.split(".")])


def section(number: str, /) -> SectionPage:
    """The page of a section of the source.

    Args:
        number: such as "4.2.3".

    Raises:
        InputError: the source has no such section.
    """
    known, name = sections(), str(number)
    if name not in known:
        near = get_close_matches(name, known, n=5, cutoff=0.3) or known[:5]
        raise InputError(f"{AREA}.unknown", number=name, known=", ".join(near))
    content = _pages().get(name)
    within = [other for other in known if other.startswith(name + ".")]
    own = [family for family in exercises(name) if family.split()[0] == name]
    status = EntryStatus.MISSING if content is None else EntryStatus.FIXED
    return SectionPage(name, status, {}, (), exercises=own, errata=errata(name), within=within, **(content or {}))


def section_table(language: str | None = None) -> list[list[str]]:
    """A row for each section: its page, figures, examples, errata, exercises and tests, below the heads.

    Args:
        language: `en` or `ar`; the current one if None.
    """
    rows = [[say(f"{AREA}.column_{name}", language=language) for name in _COLUMNS]]
    for number in sections():
        page = section(number)
        rows.append([
            number, page.words("", language) if page else "-", ", ".join(page.figures) or "-",
            ", ".join(page.examples) or "-", str(len(page.errata)), _counts(page), _tests(page),
        ])  # fmt: skip
    return rows


def _counts(page: SectionPage) -> str:
    """Families of exercises of a page, each with the number of its questions."""
    names = [one.partition(":")[0] for one in page.exercises]
    return ", ".join(f"{name} ({names.count(name)})" for name in dict.fromkeys(names)) or "-"


def _tests(page: SectionPage) -> str:
    """Files of tests/book that hold the numbers of a page."""
    files = [f"test_{module_of(number)}_figures" for number in page.figures]
    files += ["test_examples"] * bool(page.examples) + ["test_remarks"] * bool(page.remarks)
    files += ["test_exercises"] * bool(page.exercises) + ["test_edition"] * bool(page.errata)
    return ", ".join(dict.fromkeys(files)) or "-"


def _family_numbers() -> list[str]:
    return [family.number for family in families()]


_KINDS = {
    "section": (AREA, sections), "figure": ("book_figures", figures), "example": ("book_examples", examples),
    "remark": ("book_remarks", remarks), "exercise": ("book_exercises", _family_numbers),
    "erratum": ("book_errata", errata),
}  # fmt: skip
"""What is searched: area of the words, and numbers."""
_PARTS = ("caption", "erratum", "text", "hint1", "hint2")
_MARKS = re.compile("[\u0610-\u061a\u064b-\u0652\u0670\u0640]")
_LETTERS = str.maketrans("أإآٱىةؤئ", "ااااي" + "هوي")
_PREFIX = "(?:[وف]?(?:ال|بال|كال|لل|[بكل])?)"
_ARTICLE = re.compile(f"^{_PREFIX}(?=[\u0600-\u06ff]{{3}})")


def find(words: str, /) -> list[tuple[str, str, str]]:
    """Sections, figures, examples, remarks, exercises and errata of the book that have all the words.

    Args:
        words: in Arabic or English; beginnings of words are enough.

    Returns:
        Kind, number and title in the language of the words, those with the words in the title first.
    """
    words = str(words)
    sought = [_pattern(word) for word in _plain(words).split()]
    code = "ar" if re.search("[\u0600-\u06ff]", words) else "en"
    hits: list[tuple[bool, str, str, str]] = []
    for (kind, number), (title, rest) in _texts(code).items() if sought else ():
        where = [(pattern.search(_plain(title)), pattern.search(rest)) for pattern in sought]
        if all(any(places) for places in where):
            hits.append((not all(places[0] for places in where), kind, number, title))
    return [(kind, number, title) for _, kind, number, title in sorted(hits, key=lambda entry: entry[0])]


@cache
def _texts(code: str) -> Mapping[tuple[str, str], tuple[str, str]]:
    """Title and plain words of each entry, by kind and number."""
    assert code in LANGUAGES
    texts: dict[tuple[str, str], tuple[str, str]] = {}
    for kind, (area, numbers) in _KINDS.items():
        known = keys(code, area)
        for number in numbers():
            head = number if number in known else f"{number}.title"
            rest = [template(f"{area}.{key}", code) for key in (f"{number}.{part}" for part in _PARTS) if key in known]
            texts[kind, number] = template(f"{area}.{head}", code), _plain(" ".join([number, *rest]))
    return texts


def _plain(text: str) -> str:
    """Small letters, without marks; letters that people write one for another are one."""
    return _MARKS.sub("", text).translate(_LETTERS).lower()


def _pattern(word: str) -> re.Pattern[str]:
    """Finds a word that begins so, whatever particles are joined to it."""
    stem = _ARTICLE.sub("", word)
    return re.compile(rf"(?<!\w){_PREFIX}(?:{re.escape(word)}|{re.escape(stem)})")
