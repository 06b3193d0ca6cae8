"""The report of laws side by side: one self-contained page in all languages, and its numbers for machines.

The page has cards, tables and curves; its numbers are chosen and its texts said here.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.control.analysis import words_for
from mafsil.job import Job
from mafsil.job.judging.law_bench import CONDITIONS, LawBench, LawResult, LawStatus
from mafsil.messages import LANGUAGES, direction, language, say
from mafsil.messages.quantities import digits, quantity
from mafsil.messages.visible import visible
from mafsil.page.content import sentence
from mafsil.report import fragments
from mafsil.report.content import Details, Figure, Finding, Level, Plot, Table
from mafsil.report.contents import versions
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


@dataclass(frozen=True, eq=False, slots=True)
class LawPage:
    """What the page shows, in one language.

    Attributes:
        language: `en` or `ar`.
        title, subtitle: headline and the line under it.
        verdict: how many laws did the job, in a few words.
        figures: cards with the best of each number.
        compared, borne, stability: tables.
        findings: what each law made of the job, and why.
        times: (rows,) [s], of all plots.
        laws: kinds, in the order of the plots' columns.
        names: of the laws.
        plots: a curve for each law.
        details: formulas, the job, versions.
    """

    language: str
    title: str
    subtitle: str
    verdict: Finding
    figures: tuple[Figure, ...]
    compared: Table
    borne: Table
    stability: Table
    findings: tuple[Finding, ...]
    times: Floats
    laws: tuple[str, ...]
    names: tuple[str, ...]
    plots: tuple[Plot, ...]
    details: tuple[Details, ...]


def law_page(bench: LawBench, job: Job, text: str, language: str) -> LawPage:
    """The page of laws side by side.

    Args:
        bench: what they made of the job.
        job, text: what was asked, and its file.
        language: of all texts.
    """
    words = _Words(language)
    done = sum(each.status.succeeded for each in bench)
    level: Level = "good" if done == len(bench) else "warning" if done else "failure"
    return LawPage(
        language=language,
        title=words("laws_title", title=job.title or words("untitled", robot=job.robot)),
        subtitle=f"{job.robot} · {quantity(job.simulation.step, 's')} · {words('laws_count', count=len(bench))}",
        verdict=Finding(level, words("laws_verdict", done=done, count=len(bench))),
        figures=tuple(_figures(bench, words)),
        compared=_compare(bench, words),
        borne=_borne(bench, words),
        stability=_stability(bench, words),
        findings=tuple(_findings(bench, language)),
        times=bench.results[0].curves.t,
        laws=tuple(each.kind for each in bench),
        names=tuple(map(words.law, bench)),
        plots=tuple(_plots(bench, words)),
        details=tuple(_details(bench, text, words)),
    )


class _Words:
    """Sentences of the report in one language."""

    def __init__(self, language: str) -> None:
        self.language = language

    def __call__(self, key: str, **details: object) -> str:
        return say(f"report.{key}", language=self.language, **details)

    def law(self, result: LawResult) -> str:
        """The name of a law."""
        return result.name(self.language)


def _figures(bench: LawBench, words: _Words) -> Iterator[Figure]:
    """The best of each number among the laws that did the job, and how many are stable."""
    able = [each for each in bench if each.status is LawStatus.DONE]
    stable = sum(each.stable for each in bench)
    level: Level = "good" if stable == len(bench) else "warning"
    yield Figure(words("laws_stable"), f"{stable} / {len(bench)}", "", words("laws_stable_note"), level)
    best: list[tuple[str, str, Callable[[LawResult], float]]] = [
        ("tip_error", "m", lambda one: one.numbers.tip_error),
        ("laws_effort", "N m, N", _effort),
        ("energy", "J", lambda one: one.numbers.energy),
        ("laws_steadiest", "rad, m", _worst_error),
    ]
    if bench.results[0].curves.force is not None:
        best.append(("contact_force", "N", lambda one: one.peak_force))
    for name, unit, of in best if able else ():
        winner = min(able, key=of)
        mixed = ", " in unit  # A norm over joints that rotate and joints that slide has no multiple of a unit.
        number, _, shown = (digits(of(winner)), "", unit) if mixed else quantity(of(winner), unit).partition(" ")
        yield Figure(words(f"laws_least_{name}"), number, shown, words.law(winner))


def _effort(one: LawResult) -> float:
    return float(np.linalg.norm(one.numbers.rms_effort))


def _worst_error(one: LawResult) -> float:
    """Under the worst condition; endless where a run ended early."""
    return float(np.nan_to_num(np.array(one.joint_error), nan=np.inf).max())


def _compare(bench: LawBench, words: _Words) -> Table:
    keys = ["law", "result", "joint_rms", "tip_error", "effort", "peak", "energy", "saturated"]
    touching = bench.results[0].curves.force is not None
    head = [words(f"laws_head_{key}") for key in (*keys, *(["force"] if touching else []))]
    rows: list[tuple[str, ...]] = []
    for one in bench:
        row = (
            words.law(one), words(f"laws_{one.status.name.lower()}"), digits(one.joint_error[0]),
            quantity(one.numbers.tip_error, "m"), digits(_effort(one)),
            digits(float(one.numbers.peak_effort.max(initial=0.0))), quantity(one.numbers.energy, "J"),
            quantity(one.saturated, "s"),
        )  # fmt: skip
        rows.append((*row, quantity(one.peak_force, "N")) if touching else row)
    return Table(tuple(head), tuple(rows))


def _borne(bench: LawBench, words: _Words) -> Table:
    head = (
        words("laws_head_law"),
        *(words(f"laws_{name.replace(' ', '_')}") for name in CONDITIONS),
        words("laws_times"),
    )
    rows: list[tuple[str, ...]] = []
    for one in bench:
        errors = tuple(digits(each) if np.isfinite(each) else words("laws_stopped") for each in one.joint_error)
        first, worst = one.joint_error[0], _worst_error(one)
        rows.append((words.law(one), *errors, digits(worst / first) if 0.0 < first and np.isfinite(worst) else "–"))
    return Table(head, tuple(rows))


def _stability(bench: LawBench, words: _Words) -> Table:
    head = tuple(words(f"laws_head_{key}") for key in ("law", "condition", "holds"))
    rows: list[tuple[str, ...]] = []
    for one in bench:
        known = [(each.explain(language=words.language), each.holds) for each in one.conditions]
        for said, holds in known or [(words("laws_no_condition"), None)]:
            rows.append((words.law(one), said, "–" if holds is None else words("laws_yes" if holds else "laws_no")))
    return Table(head, tuple(rows))


def _findings(bench: LawBench, language: str) -> Iterator[Finding]:
    """A sentence for each law, and another where the cause of its error is known."""
    for one in bench:
        levels: dict[LawStatus, Level] = {
            LawStatus.DONE: "good", LawStatus.MISSED: "warning", LawStatus.STOPPED: "failure",
        }  # fmt: skip
        level = levels[one.status]
        if level == "good" and not one.stable and one.conditions:
            level = "warning"
        said = one.explain(language)
        yield Finding(level, said if one.cause is None else f"{said}. {one.cause.explain(language=language)}")


def _plots(bench: LawBench, words: _Words) -> Iterator[Plot]:
    curves = [each.curves for each in bench]
    yield Plot(
        "joint_error", words("laws_joint_error"), "rad, m", np.stack([each.joint_error for each in curves], axis=1)
    )
    yield Plot("tip_error", words("tip_error"), "m", np.stack([each.tip_error for each in curves], axis=1))
    yield Plot("effort", words("laws_effort"), "N m, N", np.stack([each.effort for each in curves], axis=1))
    forces = [each.force for each in curves if each.force is not None]
    if len(forces) == len(curves):
        yield Plot("contact_force", words("contact_force"), "N", np.stack(forces, axis=1))


def _details(bench: LawBench, text: str, words: _Words) -> Iterator[Details]:
    """Every law in words with its formula, the job, versions."""
    accounts: list[tuple[str, str]] = []
    for one in bench:
        found = words_for(one.kind)
        accounts.append((words.law(one), f"{found.paragraph(words.language)} {found.formula}"))
    yield Details(words("explained"), tuple(accounts))
    yield Details(words("job_file"), text=text)
    yield Details(words("versions"), tuple(versions().items()))
