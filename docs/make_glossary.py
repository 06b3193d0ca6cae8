"""Writes docs/glossary.md and docs/glossary.ar.md from docs/glossary.toml: the words of the field, as mafsil uses them.

python docs/make_glossary.py          writes the pages
python docs/make_glossary.py --check  fails if a page is not what would be written
"""

from __future__ import annotations

import re
import sys
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

DOCS = Path(__file__).parent
SOURCE = DOCS / "glossary.toml"
AREAS = {
    "general": ("General", "عام"),
    "model": ("Models of robots", "نماذج الروبوت"),
    "geometry": ("Rigid motions", "حركات الجسم الصلب"),
    "kinematics": ("Kinematics", "الكينماتيكا"),
    "ik": ("Inverse kinematics", "الكينماتيكا العكسية"),
    "performance": ("Statics, singularities, dexterity", "الاستاتيكا والشذوذ والمهارة"),
    "dynamics": ("Dynamics", "الديناميكا"),
    "identification": ("Identification", "تعيين المعاملات"),
    "grasp": ("Grasps", "المسكات"),
    "trajectory": ("Trajectories", "المسارات الزمنية"),
    "control": ("Control", "التحكم"),
    "planning": ("Collision and planning", "التصادم والتخطيط"),
    "simulation": ("Simulation", "المحاكاة"),
    "derivation": ("Derivations", "الاشتقاقات"),
    "numerics": ("Numerics", "الحساب العددي"),
}
"""Areas of the field in the order of the pages: their titles in English and Arabic."""
ARABIC = re.compile(r"[\u0600-\u06ff]")
ENGLISH_HEAD = """\
# Terms in English and Arabic

Made by `docs/make_glossary.py` from `docs/glossary.toml`. One word for each notion, as mafsil's code and messages use
it; tests keep them. Behind "not": words for the same notion that one meets in books and that mafsil does not use. The
same page in Arabic: [المصطلحات](glossary.ar.md).
"""
ARABIC_HEAD = """\
# المصطلحات بالعربية والإنكليزية

<div dir="rtl">

كتبها `docs/make_glossary.py` من `docs/glossary.toml`. لفظ واحد لكل معنى كما في شيفرة mafsil ورسائلها،
وتحفظ ذلك اختبارات. بعد «لا»: ألفاظ للمعنى نفسه ترد في الكتب ولا تستعملها mafsil.
الصفحة بالإنكليزية: [Terms](glossary.md).
"""


@dataclass(frozen=True)
class Term:
    """One notion.

    Attributes:
        area: key of AREAS.
        english, arabic: the words for it.
        code: names in the package.
        line, line_ar: what it is, in English and Arabic.
        avoided: words for it that are not used.
    """

    area: str
    english: str
    arabic: str
    code: tuple[str, ...]
    line: str
    line_ar: str
    avoided: tuple[str, ...]

    @property
    def anchor(self) -> str:
        """Target of links to the term."""
        return "term-" + re.sub(r"[^a-z0-9]+", "-", self.english.lower()).strip("-")

    def avoided_in(self, *, arabic: bool) -> tuple[str, ...]:
        """The words that are not used, of one of the two scripts."""
        return tuple(word for word in self.avoided if bool(ARABIC.search(word)) == arabic)


def terms() -> list[Term]:
    """All terms, in the order of the file."""
    rows = tomllib.loads(SOURCE.read_text("utf-8"))["term"]
    return [
        Term(
            row["area"],
            row["english"],
            row["arabic"],
            tuple(row["code"]),
            row["line"],
            row["line_ar"],
            tuple(row.get("not", ())),
        )
        for row in rows
    ]


def english_page(words: list[Term]) -> str:
    """The page for readers of English: an index, then a table for each area."""
    lines = [ENGLISH_HEAD, _index(words, key=lambda term: term.english)]
    for area, (title, _) in AREAS.items():
        lines += ["", f"## {title}", "", "| English | Arabic | in code | what it is |", "|---|---|---|---|"]
        for term in (term for term in words if term.area == area):
            arabic, names = _with_avoided(term.arabic, term.avoided_in(arabic=True), "not"), _names(term)
            english = _with_avoided(_anchored(term, term.english), term.avoided_in(arabic=False), "not")
            lines.append(f"| {english} | {arabic} | {names} | {term.line} |")
    return "\n".join(lines) + "\n"


def arabic_page(words: list[Term]) -> str:
    """The page for readers of Arabic, from right to left: an index, then a table for each area."""
    lines = [ARABIC_HEAD, _index(words, key=lambda term: term.arabic)]
    for area, (_, title) in AREAS.items():
        lines += ["", f"## {title}", "", "| بالعربية | بالإنكليزية | في الشيفرة | ما هو |", "|---|---|---|---|"]
        for term in (term for term in words if term.area == area):
            arabic = _with_avoided(_anchored(term, term.arabic), term.avoided_in(arabic=True), "لا")
            lines.append(f"| {arabic} | {term.english} | {_names(term)} | {term.line_ar} |")
    return "\n".join([*lines, "", "</div>"]) + "\n"


def _index(words: list[Term], key: Callable[[Term], str]) -> str:
    """All terms in alphabetical order, each a link to its row."""
    ordered = sorted(words, key=lambda term: key(term).removeprefix("ال").casefold())
    return " ·\n".join(f'<a href="#{term.anchor}">{key(term)}</a>' for term in ordered)


def _anchored(term: Term, text: str) -> str:
    return f'<a id="{term.anchor}"></a>{text}'


def _with_avoided(text: str, avoided: tuple[str, ...], no: str) -> str:
    if not avoided:
        return text
    comma = "، " if ARABIC.search(avoided[0]) else ", "
    return f"{text} ({no}: {comma.join(avoided)})"


def _names(term: Term) -> str:
    return ", ".join(f"`{name}`" for name in term.code)


def main() -> int:
    """Write or check the pages."""
    words = terms()
    pages = {"glossary.md": english_page(words), "glossary.ar.md": arabic_page(words)}
    if "--check" in sys.argv:
        return int(any((DOCS / name).read_text("utf-8") != text for name, text in pages.items()))
    for name, text in pages.items():
        (DOCS / name).write_text(text, "utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
