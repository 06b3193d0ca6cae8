"""The report of laws side by side: one self-contained page in all languages, and its numbers for machines."""

from __future__ import annotations

import json
import os
from functools import cache
from pathlib import Path
from typing import Any

from mafsil.job import Job
from mafsil.job.judging.law_bench import LawBench
from mafsil.messages import LANGUAGES, direction, language, say
from mafsil.messages.visible import visible
from mafsil.page.content import sentence
from mafsil.report import fragments
from mafsil.report.contents import versions
from mafsil.report.law_contents import LawPage, law_page
from mafsil.report.page import fill_slots, frame, hidden_language, plot_data, report_style
from mafsil.report.results import write_file, write_folder
from mafsil.scene import one_script, pack_floats
from mafsil.scene.inline import embed_json, policy

MAIN = "report/template/laws.js"
PLOT_WORDS = ("whole_time", "save_picture", "save_values")
"""What buttons of plots say."""
LABELS = (
    "numbers_title", "warnings_title", "source_title", "save_table", "laws_compared", "laws_compared_hint",
    "laws_curves", "laws_curves_hint", "laws_borne", "laws_borne_hint", "laws_stability", "laws_stability_hint",
)  # fmt: skip
FORMAT = "mafsil-laws-1"


def write_law_report(bench: LawBench, job: Job, text: str, directory: str | os.PathLike[str]) -> Path:
    """Write page and numbers of laws side by side into a directory, as `write_results` does those of a run.

    Args:
        bench: what they made of the job.
        job, text: what was asked, and its file.
        directory: to be created; an earlier result in it is replaced.

    Returns:
        Path of the page.

    Raises:
        InputError: the directory holds something that is no result of ours.
        OSError: the disk is full, the place is not writable.
    """
    code = job.report.language or language()
    others = [each for each in LANGUAGES if each != code]

    def write(folder: Path) -> None:
        pages = [law_page(bench, job, text, each) for each in (code, *others)]
        write_file(folder / "report.html", render_laws(*pages).encode())
        data = {"format": FORMAT, **bench.to_dict(), "versions": versions()}
        write_file(folder / "results.json", json.dumps(data, ensure_ascii=False, indent=2, allow_nan=False).encode())
        write_file(folder / "job.toml", text.encode())

    return write_folder(Path(directory), write)


def render_laws(page: LawPage, *others: LawPage) -> str:
    """The page as HTML text.

    Args:
        page: in the language in which it opens.
        others: the same in other languages, to which its reader may switch.
    """
    style, code = report_style(), _script()
    slots = frame(page.language, page.title, style, code) | _texts(page)
    slots |= {name: say(f"report.{name}", language=page.language) for name in LABELS}
    slots["policy"] = policy(style, code)
    slots["alone"] = "" if others else "hidden"
    slots["data"] = embed_json(_data(page, *others))
    slots["languages"] = "".join(hidden_language(each.language, _texts(each)) for each in others)
    return fill_slots("laws.html", slots)


@cache
def _script() -> str:
    return "(() => {\n" + one_script(MAIN) + "\n})();"


def _texts(page: LawPage) -> dict[str, str]:
    """What stands in the page's `data-slot` elements, as HTML."""
    return {
        "header": fragments.header(page.title, page.subtitle, page.verdict),
        "numbers": fragments.figures(page.figures),
        "compared": fragments.table(page.compared),
        "borne": fragments.table(page.borne),
        "stability": fragments.table(page.stability),
        "warnings": fragments.findings(page.findings),
        "source": fragments.details(page.details),
        "footer": fragments.text(say("report.footer", language=page.language)),
    }


def _data(*pages: LawPage) -> dict[str, Any]:
    """What the script needs: curves, and what it says in each language."""
    page = pages[0]
    return {
        "language": page.language,
        "languages": {each.language: _language(each.language) for each in pages},
        "titles": {each.language: visible(each.title) for each in pages},
        "texts": {each.language: _curves(each) for each in pages},
        "joints": list(page.laws),
        "time": pack_floats(page.times),
        "moves": [],
        "plots": [plot_data(plot) for plot in page.plots],
    }


def _curves(page: LawPage) -> dict[str, Any]:
    """Names of the laws, and what the plots say."""
    names = list(page.names)
    return {"laws": names, "plots": [{"title": plot.title, "names": names} for plot in page.plots]}


def _language(code: str) -> dict[str, Any]:
    sentences = {name: sentence(code, f"report.{name}") for name in LABELS}
    sentences |= {name: sentence(code, f"page.{name}") for name in ("other_language", *PLOT_WORDS)}
    return {"direction": direction(code), "sentences": sentences}
