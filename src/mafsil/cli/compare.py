"""`mafsil compare`: laws or planners on a job, or its plan and the log of a controller; `mafsil diff`: two results."""

from __future__ import annotations

import webbrowser
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from mafsil.cli.answer import Answer, Laid
from mafsil.cli.state import count, number
from mafsil.cli.status_line import Progress
from mafsil.cli.table import table
from mafsil.errors import FileError, InputError, MafsilError
from mafsil.figures import plot_search
from mafsil.job import Job, Refusal
from mafsil.job.judging.better_job import better_job
from mafsil.job.judging.law_bench import CONDITIONS, LawBench, bench_laws
from mafsil.job.judging.log_comparison import compare_with_log
from mafsil.job.language.reading import parse_job
from mafsil.job.language.text import text_of
from mafsil.job.planning.joint_moves import queries_of
from mafsil.job.planning.plan import Plan
from mafsil.job.solve import prepare
from mafsil.messages import say
from mafsil.planning import PLANNERS, Query, bench_planners, log_search
from mafsil.report import compare_results, write_law_report
from mafsil.report.results import require_replaceable
from mafsil.robot import Robot
from mafsil.whole_file import write_whole

SEEDS, SECONDS = 3, 2.0


def compare(
    what: str,
    job: str,
    laws: list[str] | None,
    planners: list[str] | None,
    seeds: str | None,
    seconds: str | None,
    replay: str | None,
    log: str | None,
    better: str | None,
    progress: bool,
    out: str | None = None,
    open: bool = False,
) -> Answer:
    """Several ways to do the same, side by side.

    Args:
        what: `control`: laws on a job; `planners`: on its moves of the joints among its obstacles; `log`: the plan
            and what a controller logged.
        job: path of the file.
        laws: names of some; all if empty.
        planners: names of some; all if empty.
        seeds: how many searches of each move.
        seconds: for one search [s].
        replay: folder for pictures of the searches of the move that took most nodes, slowly; none if None.
        log: CSV file that a controller logged.
        better: file for a better job by what the log taught; none is written if None.
        progress: print progress even when stderr is no terminal.
        out: directory for a report of laws; none is written if None.
        open: show it in the browser.

    Raises:
        MafsilError: the job or the robot cannot be read, or do not fit each other; an unknown law or planner, options
            of the other kind.
    """
    options = (
        ("laws", laws, "control"), ("planners", planners, "planners"), ("seeds", seeds, "planners"),
        ("seconds", seconds, "planners"), ("replay", replay, "planners"),
        ("out", out, "control"), ("open", open, "control"), ("log", log, "log"),
        ("better", better, "log"),
    )  # fmt: skip
    if wrong := next((name for name, given, kind in options if given and what != kind), None):
        raise InputError("cli.compare_option", name=wrong, what=what)
    searches = SEEDS if seeds is None else max(count("--seeds", seeds), 1)
    budget = SECONDS if seconds is None else number("--seconds", seconds)
    path, target = Path(job), _target(out, job, open=open)
    text = text_of(path)
    with Progress(progress) as bar:
        asked = parse_job(text, path.name, folder=path.parent)
        planned = prepare(asked, text, path.parent, bar, path.name)
        if isinstance(planned, Refusal):
            return Answer(planned.to_dict(), refusal=planned.explain())
        if what == "log":
            return _compare_log(asked, text, path.parent, planned, log, better)
        if what == "planners":
            bar.enter("stage_planning")
            return _compare_planners(planned[1], planners or (), searches, budget, replay, bar)
        bar.enter("stage_simulating")
        laid = bench_laws(asked, text, *planned, laws or None, bar.update)
    _, rows = laid.columns()
    head = ["", *(say(f"cli.compare_{name.replace(' ', '_')}") for name in CONDITIONS)]
    head += [say(f"cli.compare_{name}") for name in ("tip", "force", "effort", "peak", "energy", "growth")]
    lines = [say("cli.compare_control"), *(Laid(line) for line in table(head, rows)), *laid.explain().splitlines()]
    data = laid.to_dict()
    if target is not None:
        report = _report(laid, asked, text, target)
        lines.append(say("cli.run_written", path=report))
        data["report"] = str(report)
        if open:
            webbrowser.open(report.as_uri())
    return Answer(data, tuple(lines))


def _compare_log(
    job: Job, text: str, folder: Path, planned: tuple[Robot, Plan], log: str | None, better: str | None
) -> Answer:
    """The plan of a job and what a controller logged; a better job if a file is named."""
    if log is None:
        raise InputError("cli.compare_log_missing")
    found = compare_with_log(job, *planned, log)
    first, *rest = found.explain().split("\n")
    if better is not None:
        offer = better_job(job, text, planned[1], found, partial(_replan, folder))
        if offer.text:
            write_whole(Path(better), offer.text.encode())
            rest.append(say("cli.run_written", path=better))
        rest += [remark.sentence() for remark in offer.remarks]
    return Answer(found.to_dict(), (first, *rest)) if found else Answer(found.to_dict(), tuple(rest), first)


def _replan(folder: Path, text: str) -> tuple[Job, Plan] | None:
    """A changed job and its plan; None where it is refused."""
    try:
        job = parse_job(text, folder=folder)
        planned = prepare(job, text, folder)
    except MafsilError:
        return None
    return None if isinstance(planned, Refusal) else (job, planned[1])


def _compare_planners(
    plan: Plan, planners: Sequence[str], searches: int, budget: float, replay: str | None, bar: Progress
) -> Answer:
    """Planners on the moves of the joints among the obstacles of a job."""
    queries = queries_of(plan)
    found = bench_planners(queries, planners, seeds=range(searches), seconds=budget, progress=bar.update)
    hardest = int(np.argmax(sum(each.nodes.mean(axis=1) for each in found)))
    names = [] if found.interrupted else [each.planner for each in found]
    pictures = _replay(queries[hardest], names, budget, replay)
    head, rows = found.columns()
    shown = ["", *(say(f"cli.compare_{name}") for name in head[1:])]
    lines = [say("cli.compare_planners_table", moves=len(queries), seeds=len(found.seeds))]
    lines += [*(Laid(line) for line in table(shown, rows)), *found.explain().splitlines(), *pictures]
    return Answer({**found.to_dict(), "pictures": pictures}, tuple(lines), interrupted=found.interrupted)


def _target(out: str | None, job: str, *, open: bool) -> Path | None:
    """Where the report of laws goes, refused before anything is driven if something else stands there."""
    if out is None and not open:
        return None
    target = Path("mafsil-results") / f"{Path(job).stem}-laws" if out is None else Path(out)
    require_replaceable(target)
    return target


def _report(laid: LawBench, job: Job, text: str, target: Path) -> Path:
    try:
        return write_law_report(laid, job, text, target)
    except OSError as error:
        raise FileError("file.cannot_write", path=str(target), reason=error.strerror or str(error)) from None


def _replay(query: Query, planners: list[str], seconds: float, replay: str | None) -> list[str]:
    """Paths of the pictures of those planners that can be watched."""
    if replay is None:
        return []
    folder = Path(replay)
    folder.mkdir(parents=True, exist_ok=True)
    written: list[str] = []
    for name in planners:
        if name in PLANNERS:
            file = folder / f"{name}.svg"
            plot_search(log_search(query, name, seconds=seconds), file)
            written.append(str(file))
    return written


def diff(before: str, after: str) -> Answer:
    """The differences between the results of two runs.

    Args:
        before: folder of the first, or its results.json.
        after: of the second.

    Raises:
        FileError: one of them is no result of a run.
    """
    found = compare_results(before, after)
    return Answer(found.to_dict(), tuple(found.explain().splitlines()))
