"""Live pages of the site: `mafsil show` of every robot of the library, `mafsil run` of every example job, the book.

The first two are made after the other pages, each once: one that stands in the folder is kept.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory

from sphinx.application import Sphinx

import mafsil as mf
from mafsil.book.edition import section_table
from mafsil.toml_source import parsed_toml

JOBS = {path.stem: path for path in sorted((Path(__file__).parents[2] / "examples" / "jobs").glob("*.toml"))}
QUICK = ("panda", "pick_and_place_puma560")
"""The pages that a quick build makes."""
LIVE = "live"
"""Folder of the pages beside the others."""


def setup(app: Sphinx) -> None:
    """The gallery's cards are written as its page is read; the pages that they open are made at the end."""
    app.connect("source-read", fill_gallery)
    app.connect("source-read", fill_edition)
    app.connect("build-finished", make_pages)


def fill_gallery(app: Sphinx, document: str, source: list[str]) -> None:
    """Cards in the place of `{robots}` and `{jobs}`: each opens the live page of its name."""
    if document == "gallery":
        robots = _list(f'<img src="{LIVE}/{name}.png" alt="" loading="lazy">{_name(name)}' for name in mf.robots())
        jobs = _list(_job_card(path) for path in JOBS.values())
        source[0] = source[0].replace("{robots}", robots).replace("{jobs}", jobs)


def fill_edition(app: Sphinx, document: str, source: list[str]) -> None:
    """The pages of the book's sections and their table in the place of `{sections}` and `{table}`."""
    if document.startswith("book_pages"):
        code = "ar" if document.endswith(".ar") else "en"
        pictures = "" if os.environ.get("MAFSIL_SITE_QUICK") else f"{LIVE}/book"
        head, *rows = (f"| {' | '.join(row)} |" for row in section_table(code))
        table = "\n".join([head, "|" + "---|" * 7, *rows])
        pages = (mf.book.section(number) for number in mf.book.sections())
        text = "\n".join(page.to_markdown(code, pictures) for page in pages if page)
        source[0] = source[0].replace("{table}", table).replace("{sections}", text)


def make_pages(app: Sphinx, failure: Exception | None) -> None:
    """Write the pages that are missing, with a picture of each robot; a job that fails, fails the build."""
    if failure or app.builder.format != "html":
        return
    folder = Path(app.outdir) / LIVE
    folder.mkdir(exist_ok=True)
    names = QUICK if os.environ.get("MAFSIL_SITE_QUICK") else (*mf.robots(), *JOBS)
    (folder / "book").mkdir(exist_ok=True)
    for number in () if os.environ.get("MAFSIL_SITE_QUICK") else mf.book.figures():
        mf.book.figure(number).save(folder / "book" / f"{number}.svg")
    for number in () if os.environ.get("MAFSIL_SITE_QUICK") else mf.book.sections():
        if (page := mf.book.section(number)).figures:
            page.save(folder / "book" / f"{number}.html")
    for name in names:
        path = folder / f"{name}.html"
        if path.exists():
            continue
        if name in JOBS:
            _run(JOBS[name], path)
        else:
            mf.load(name).plot(path=path.with_suffix(".png"))
            mf.show(name, language="en").write(path)


def _run(job: Path, path: Path) -> None:
    with TemporaryDirectory() as results:
        command = [sys.executable, "-m", "mafsil", "run", str(job), "--out", results]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        shutil.copyfile(Path(results) / "report.html", path)


def _job_card(path: Path) -> str:
    """Title and opening comment of a job, as the text says them."""
    text = path.read_text("utf-8")
    comment = re.match(r"# (.*)", text)
    return _name(path.stem, parsed_toml(text).get("title"), comment and comment[1])


def _name(name: str, title: str | None = None, line: str | None = None) -> str:
    """The words on a card, the link first."""
    link = f'<a href="{LIVE}/{name}.html">{escape(title or name.replace("_", " "))}</a>'
    return link + (f"<span>{escape(line)}</span>" if line else "")


def _list(cards: Iterable[str]) -> str:
    return "\n".join(['<ul class="gallery">', *(f"<li>{card}</li>" for card in cards), "</ul>"])
