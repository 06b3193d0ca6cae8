"""Notebooks: the sections of docs/tutorials.md, and the weeks of docs/course_weeks.toml in both languages.

All are executed while the site is built; a quick build makes the first of each. jupytext makes cells of the tutorials'
text and code, nbclient runs them, and their outputs stand in the file that readers download. A cell that fails, fails
the build.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import jupytext
import nbformat
from nbclient import NotebookClient
from sphinx.application import Sphinx

import mafsil as mf
from mafsil.messages import LANGUAGES
from mafsil.toml_source import parsed_toml

FOLDER = "notebooks"
SECTION = re.compile(r"^## (.+)$", re.M)
WEEKS = Path(__file__).parents[1] / "course_weeks.toml"
WORDS = {
    "en": ("Week", "Read", "Script", "Mini-project", "Exercises", "Other numbers: another seed.", "Notebook"),
    "ar": ("الأسبوع", "للقراءة", "البرنامج", "مشروع صغير", "تمارين", "أعداد أخرى ببذرة أخرى.", "الدفتر"),
}
SHOWN = re.compile(r"```text\n.*?```\n", re.S)


def setup(app: Sphinx) -> None:
    """Each section of the page begins with a link to its notebook."""
    app.connect("source-read", link_notebooks)
    app.connect("build-finished", write_notebooks)


def link_notebooks(app: Sphinx, document: str, source: list[str]) -> None:
    """A link below each heading of the tutorials."""
    if document == "tutorials":
        source[0] = SECTION.sub(
            lambda heading: f'{heading[0]}\n\n<a href="{_address(heading[1])}" download>As a notebook</a>\n', source[0]
        )
    language = "ar" if document.endswith(".ar") else "en"
    if document.removesuffix(".ar") in ("course", "teachers_guide"):
        source[0] = source[0].replace("{weeks}", week_table(language))


def write_notebooks(app: Sphinx, failure: Exception | None) -> None:
    """One notebook a section, each with the page's first imports; a quick build makes the first one."""
    if failure or app.builder.format != "html":
        return
    (Path(app.outdir) / FOLDER).mkdir(exist_ok=True)
    tutorials = notebooks((Path(app.srcdir) / "tutorials.md").read_text("utf-8"))[: _count()]
    weeks = [pair for language in LANGUAGES for pair in week_notebooks(language)[: _count()]]
    for title, notebook in (*tutorials, *weeks):
        with TemporaryDirectory() as folder:
            NotebookClient(
                notebook, timeout=600, kernel_name="python3", resources={"metadata": {"path": folder}}
            ).execute()
        nbformat.write(notebook, Path(app.outdir) / _address(title))


def week_notebooks(language: str) -> list[tuple[str, Any]]:
    """Name and unexecuted notebook of each week of the course: what to read, text and code, project, exercises."""
    return [(f"week {k} {language}", _week(k, week, language)) for k, week in enumerate(_weeks(), start=1)]


def week_table(language: str) -> str:
    """Weeks, their sections of the book, and links to their notebooks, as a table of Markdown."""
    week, read, *_, notebook = WORDS[language]
    rows = [
        f"| {k} | {entry[language]} | {', '.join(entry['sections'])} "
        f'| <a href="{_address(f"week {k} {language}")}" download>{notebook}</a> |'
        for k, entry in enumerate(_weeks(), start=1)
    ]
    return "\n".join([f"| {week} | | {read} | {notebook} |", "|---|---|---|---|", *rows])


def _weeks() -> list[dict[str, Any]]:
    return parsed_toml(WEEKS.read_text("utf-8"))["week"]


def _week(number: int, week: dict[str, Any], language: str) -> Any:
    name, read, script, project, tasks, hint, _ = WORDS[language]
    sections = [f"- {section}: {mf.book.section(section).words('', language)}" for section in week["sections"]]
    pages = ", ".join(f"[{page}](../{page.replace('.md', '.html')})" for page in week["pages"])
    head = [
        f"# {name} {number}: {week[language]}",
        f"{read}:",
        "\n".join(sections),
        pages,
        f"{script}: {week['script']}",
    ]
    cells = [
        _text("\n\n".join(head), language),
        _code(f'import numpy as np\n\nimport mafsil as mf\n\nmf.language("{language}")'),
    ]
    for cell in week["cell"]:
        cells.append(_text(f"## {project}\n\n{cell[language]}" if cell.get("project") else cell[language], language))
        if file := cell.get("robot"):
            cells.append(_code(f'file = "{file}"\nmf.load("{Path(file).stem}").save(file)\nrobot = mf.load(file)'))
        cells.append(_code(cell["code"].strip()))
    families = [
        family
        for section in week["sections"]
        for family in mf.book.exercises(section)
        if _is_of(family, section) and not family.endswith((": inverse", ": scaling", ": choose"))
    ]
    if families:
        asked = f"for family in {families}:\n    print(mf.book.exercise(family, seed={number}), end='\\n\\n')"
        cells += [_text(f"## {tasks}\n\n{hint}", language), _code(asked)]
    return nbformat.v4.new_notebook(cells=cells)


def _is_of(family: str, section: str) -> bool:
    return family.split()[0] == section


def _text(text: str, language: str) -> Any:
    if language == "ar":
        text = f'<div dir="rtl">\n\n{text}\n\n</div>'
    return nbformat.v4.new_markdown_cell(text)


def _code(source: str) -> Any:
    return nbformat.v4.new_code_cell(source)


def notebooks(page: str) -> list[tuple[str, Any]]:
    """Title and unexecuted notebook of each section; what the page shows as printed is left to the run."""
    start, *sections = SECTION.split(SHOWN.sub("", page))
    imports = "\n".join(re.findall(r"```python\n.*?```\n", start, re.S))
    pairs = zip(sections[::2], sections[1::2], strict=True)
    return [(title, jupytext.reads(f"# {title}\n\n{imports}\n{text}", fmt="md")) for title, text in pairs]


def _count() -> int | None:
    return 1 if os.environ.get("MAFSIL_SITE_QUICK") else None


def _address(title: str) -> str:
    return f"{FOLDER}/{re.sub(r'[^a-z0-9]+', '-', title.lower()).strip('-')}.ipynb"
