"""`mafsil run` and `mafsil demo`: a job solved end to end."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from mafsil.cli.answer import Answer
from mafsil.cli.progress import Progress
from mafsil.cli.table import table
from mafsil.errors import FileError
from mafsil.job import Refusal, Run, solve
from mafsil.job.judgement import joint_quantity, summary
from mafsil.job.reading import parse, text_of
from mafsil.messages import language, say
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible
from mafsil.report.contents import verdict
from mafsil.report.results import as_data, require_replaceable, write_results


def run(job: str, out: str | None, progress: bool, open: bool) -> Answer:
    """Solve a job file and write the report.

    Args:
        job: path of the file.
        out: directory for the results; `mafsil-results/<name of the job>` if None.
        progress: print progress even when stderr is no terminal.
        open: show the report in the browser.

    Raises:
        MafsilError: the job or the robot cannot be read, or do not fit each other.
    """
    path = Path(job)
    target = Path("mafsil-results") / path.stem if out is None else Path(out)
    return _run(text_of(path), path.name, path.parent, target, progress=progress, show=open)


def demo(out: str | None, progress: bool, open: bool) -> Answer:
    """The job that comes with mafsil, on the default robot; arguments as for `run`."""
    text = resources.files("mafsil.cli").joinpath("demo.toml").read_text(encoding="utf-8")
    target = Path("mafsil-results") / "demo" if out is None else Path(out)
    return _run(text, "demo.toml", Path(), target, progress=progress, show=open)


def _run(text: str, source: str, folder: Path, target: Path, *, progress: bool, show: bool) -> Answer:
    require_replaceable(target)
    with Progress(progress) as bar:
        job = parse(text, source)
        outcome = solve(job, text, folder, bar)
        if isinstance(outcome, Refusal):
            refusal = {"complete": False, "code": outcome.key, "reason": outcome.explain()}
            return Answer(refusal, refusal=outcome.explain())
        bar.enter("stage_writing")
        report = _written(outcome, target)
    if show:
        import webbrowser

        webbrowser.open(report.as_uri())
    return _answer(outcome, report)


def _written(outcome: Run, target: Path) -> Path:
    try:
        return write_results(outcome, target)
    except OSError as error:
        raise FileError("cli.cannot_write", path=str(target), reason=error.strerror or str(error)) from None


def _answer(outcome: Run, report: Path) -> Answer:
    numbers = summary(outcome)
    data = as_data(outcome, numbers) | {"report": str(report)}
    lines = [say("cli.run_title", title=outcome.job.title or outcome.robot.name, verdict=verdict(outcome).text)]
    worst = int(numbers.joint_error.argmax())
    joint = visible(outcome.robot.joint_names[worst])
    off = f"{joint_quantity(outcome, worst, float(numbers.joint_error[worst]))} ({joint})"
    rows = [
        (say("report.cycle"), quantity(numbers.cycle, "s")),
        (say("report.tip_error"), quantity(numbers.tip_error, "m")),
        (say("report.tip_turn"), quantity(numbers.tip_turn, "rad")),
        (say("report.joint_error"), off),
        (say("report.energy"), quantity(numbers.energy, "J")),
    ]
    if numbers.targets:
        reached = sum(one.reached for one in numbers.arrivals)
        rows.insert(1, (say("report.targets"), say("report.targets_value", reached=reached, total=numbers.targets)))
    lines += table(("", ""), rows)[1:]
    marks = {"good": "-", "warning": "!", "failure": "!!"}
    lines += [f"  {marks[remark.level]} {remark.sentence()}" for remark in outcome.remarks]
    lines.append(say("cli.run_written", path=report))
    failures = [remark.sentence(language()) for remark in outcome.remarks if remark.level == "failure"]
    return Answer(data, tuple(lines), failures[0] if failures else None)
