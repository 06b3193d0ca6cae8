"""`mafsil run`, `mafsil demo`: a job solved end to end; `mafsil check-job`: planned only; `mafsil sweep`: often."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Literal

from mafsil.cli.answer import Answer, Laid, Tone, Toned
from mafsil.cli.state import count, typed_value
from mafsil.cli.status_line import Progress
from mafsil.cli.table import table
from mafsil.errors import FileError, InputError
from mafsil.job import Job, Refusal, Run, solve
from mafsil.job.driving.run import SHARES
from mafsil.job.judging.holding import overload_remarks, planned_overloads
from mafsil.job.judging.judgement import late_pushes, summary
from mafsil.job.judging.symptoms import joint_quantity
from mafsil.job.language.reading import parse_job
from mafsil.job.language.text import text_of
from mafsil.job.planning.cell_signals import assignments, conditions
from mafsil.job.planning.plan import Leg
from mafsil.job.planning.ros_program import program_for
from mafsil.job.remark import Remark
from mafsil.job.solve import prepare, simulated_by, with_runs
from mafsil.job.sweep import sweep as swept
from mafsil.messages import language, say
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible
from mafsil.report.contents import verdict
from mafsil.report.results import as_data, others_data, require_replaceable, signals_data, write_results
from mafsil.simulation.recording import SimulationStatus
from mafsil.whole_file import write_whole

MARKS: dict[str, tuple[str, Tone]] = {"good": ("-", "plain"), "warning": ("!", "warning"), "failure": ("!!", "bad")}
"""What stands before a finding of each level, and its colour."""


def run(
    job: str,
    out: str | None,
    progress: bool,
    open: bool,
    dry_run: bool = False,
    set: list[str] | None = None,
    plant: Literal["mafsil", "mujoco", "kinematic"] | None = None,
    real_time: bool = False,
    log: str | None = None,
    runs: str | None = None,
    cluster: str | None = None,
) -> Answer:
    """Solve a job file and write the report.

    Args:
        job: path of the file.
        out: directory for the results; `mafsil-results/<name of the job>` if None.
        progress: print progress even when stderr is no terminal.
        open: show the report in the browser.
        dry_run: plan only: nothing is simulated, nothing is written.
        set: `name=value` of variables of the job.
        plant: who computes the motion; as the job says if None.
        real_time: drive against the clock, and count what comes late.
        log: path of a live log, `.mcap`; none if None.
        runs: of a job with `[variation]`, if others than it says; 0 for none.
        cluster: who drives them: a number of processes here, or the address of a dask scheduler.

    Raises:
        MafsilError: the job or the robot cannot be read, or do not fit each other.
    """
    path, variables = Path(job), dict(map(_assign, set or ()))
    if dry_run:
        return _plan(text_of(path), path.name, path.parent, variables, progress=progress)
    target = Path("mafsil-results") / path.stem if out is None else Path(out)
    options = _Options(variables, plant, real_time, log, None if runs is None else count("--runs", runs), cluster)
    return _run(text_of(path), path.name, path.parent, target, options, progress=progress, show=open)


def _assign(words: str) -> tuple[str, bool | float | str]:
    """Name and value of `name=value`."""
    name, equals, value = words.partition("=")
    if not equals or not name.strip():
        raise InputError("cli.run_assignment", given=words)
    return name.strip(), typed_value(value)


def check_job(job: str, program: str | None = None) -> Answer:
    """Plan a job without simulating it.

    Args:
        job: path of the file.
        program: file for the plan as a program of a controller, in the language of its ending; none if None.

    Raises:
        MafsilError: the job or its robot cannot be read, or do not fit each other; a controller that cannot drive it.
    """
    path = Path(job)
    return _plan(text_of(path), path.name, path.parent, {}, progress=False, program=program)


def demo(out: str | None, progress: bool, open: bool) -> Answer:
    """The job that comes with mafsil, on the default robot; arguments as for `run`."""
    text = resources.files("mafsil.cli").joinpath("demo.toml").read_text(encoding="utf-8")
    target = Path("mafsil-results") / "demo" if out is None else Path(out)
    return _run(text, "demo.toml", Path(), target, progress=progress, show=open)


@dataclass(frozen=True, slots=True)
class _Options:
    """How a job is run for once; see `run`."""

    variables: Mapping[str, object] | None = None
    plant: Literal["mafsil", "mujoco", "kinematic"] | None = None
    real_time: bool = False
    log: str | None = None
    runs: int | None = None
    cluster: str | None = None

    def of(self, job: Job) -> Job:
        """The job with them.

        Raises:
            InputError: many runs of a job that does not say what differs between them.
        """
        if job.variation is None and (self.runs is not None or self.cluster is not None):
            raise InputError("cli.run_no_variation")
        changed = simulated_by(job, self.plant, real_time=self.real_time)
        return changed if self.runs is None else with_runs(changed, self.runs)


def _run(
    text: str, source: str, folder: Path, target: Path, options: _Options = _Options(), *, progress: bool, show: bool
) -> Answer:
    require_replaceable(target)
    with Progress(progress) as bar:
        job = options.of(parse_job(text, source, options.variables, folder=folder))
        outcome = solve(job, text, folder, bar, source, log=options.log, cluster=options.cluster)
        if isinstance(outcome, Refusal):
            return _refuse(outcome)
        bar.enter("stage_writing")
        report = _written(outcome, target)
    if show:
        import webbrowser

        webbrowser.open(report.as_uri())
    return _answer(outcome, report)


def _plan(
    text: str, source: str, folder: Path, variables: Mapping[str, object], *, progress: bool, program: str | None = None
) -> Answer:
    """The motion of a job, and how long it takes; as a program of a controller if a file is named."""
    with Progress(progress) as bar:
        job = parse_job(text, source, variables, folder=folder)
        outcome = prepare(job, text, folder, bar, source)
    if isinstance(outcome, Refusal):
        return _refuse(outcome)
    robot, motion = outcome
    overloaded = overload_remarks(planned_overloads(job, motion), robot)
    late = late_pushes(job, motion.duration + job.simulation.settle)
    findings = [*overloaded, *late, *motion.remarks]
    moves = [(k, leg) for k, leg in enumerate(motion.legs) if leg.index >= 0]
    starts = motion.starts
    cycle = float(starts[len(moves)])
    data = {
        "robot": robot.name,
        "cycle": cycle,
        "start": motion.start.tolist(),
        "moves": [
            {
                "number": leg.index + 1,
                "name": leg.name,
                "kind": leg.kind,
                "start": float(starts[k]),
                "duration": leg.trajectory.duration,
                "choice": None if leg.decision is None else leg.decision.to_dict(),
                "joints": leg.trajectory.at(leg.trajectory.duration).u.tolist(),
            }
            for k, leg in moves
        ],
        "other_robots": others_data(motion.neighbours),
        "signals": signals_data(motion.signals, motion.duration),
        "findings": [
            {"level": one.level, "code": one.key, "en": one.sentence("en"), "ar": one.sentence("ar")}
            for one in findings
        ],
    }
    rows = [
        (_call(job, leg), say(f"report.kind_{leg.kind}"), quantity(leg.trajectory.duration, "s")) for _, leg in moves
    ]
    for each in motion.neighbours:
        for one in each.steps:
            name = say("report.other_move", name=each.neighbour.name, number=one.number)
            words = " ".join(word for word in (name, one.text) if word)
            rows.append((words, say(f"report.kind_{one.kind}"), quantity(one.end - one.start, "s")))
    heading = tuple(say(f"cli.run_{name}") for name in ("move", "kind", "duration"))
    lines = [say("cli.run_planned", title=visible(job.title or robot.name), cycle=quantity(cycle, "s"))]
    lines += table(heading, rows)
    lines += map(_finding, findings)
    if program is not None and not overloaded:
        file = Path(program)
        written = program_for(job, motion, file.suffix)
        write_whole(file, written.text.encode())
        data["program"] = {"path": program, "lost": [one.sentence("en") for one in written.lost]}
        lines.append(say("job.program_written", path=program, count=written.count))
        if written.scene:
            scene = file.with_suffix(f".scene{file.suffix}")
            write_whole(scene, written.scene.encode())
            data["program"]["scene"] = str(scene)
            lines.append(say("job.program_scene", path=str(scene)))
        lines += map(_finding, written.lost)
    return Answer(data, tuple(lines), overloaded[0].sentence() if overloaded else None)


def _call(job: Job, leg: Leg) -> str:
    """Number and name of a move, and what it does with signals."""
    move = job.move[leg.index]
    signals = assignments(move.set) or conditions(move.wait)
    signals = signals if leg.decision is None else leg.decision.explain()
    name = leg.name if leg.decision is None else visible(move.name)
    words = (str(leg.index + 1), name, signals if signals != leg.name else "")
    return " ".join(word for word in words if word)


def _refuse(outcome: Refusal) -> Answer:
    return Answer(outcome.to_dict(), refusal=outcome.explain())


def _written(outcome: Run, target: Path) -> Path:
    try:
        return write_results(outcome, target)
    except OSError as error:
        raise FileError("file.cannot_write", path=str(target), reason=error.strerror or str(error)) from None


def _answer(outcome: Run, report: Path) -> Answer:
    numbers = summary(outcome)
    data = as_data(outcome, numbers) | {"report": str(report)}
    judged = verdict(outcome)
    title = say("cli.run_title", title=outcome.job.title or outcome.robot.name, verdict=judged.text)
    lines: list[str] = [Toned(title, "good" if judged.level == "good" else MARKS[judged.level][1])]
    worst = int(numbers.joint_error.argmax())
    joint = visible(outcome.robot.joint_names[worst])
    off = f"{joint_quantity(outcome, worst, float(numbers.joint_error[worst]))} ({joint})"
    rows = [(say("report.cycle"), quantity(numbers.cycle, "s"))]
    driven = [
        (say("report.tip_error"), quantity(numbers.tip_error, "m")),
        (say("report.tip_turn"), quantity(numbers.tip_turn, "rad")),
        (say("report.joint_error"), off),
        (say("report.energy"), quantity(numbers.energy, "J")),
    ]
    rows += [] if outcome.plan.kinematic else driven
    if numbers.targets:
        reached = sum(one.reached for one in numbers.arrivals)
        rows.insert(1, (say("report.targets"), say("report.targets_value", reached=reached, total=numbers.targets)))
    lines += table(("", ""), rows)[1:]
    lines += map(_finding, outcome.remarks)
    lines += _vary(outcome)
    lines.append(say("cli.run_written", path=report))
    failures = [remark.sentence(language()) for remark in outcome.remarks if remark.level == "failure"]
    broken = outcome.recording.status is SimulationStatus.INTERRUPTED
    return Answer(data, tuple(lines), failures[0] if failures else None, broken)


def _finding(remark: Remark) -> Toned:
    sign, tone = MARKS[remark.level]
    return Toned(f"  {sign} {remark.sentence()}", tone)


def _vary(outcome: Run) -> list[str]:
    """The many runs of a job: a table, and what failed by what."""
    found = outcome.variation
    if found is None:
        return []
    head = ("", *(f"{100.0 * share:g} %" for share in SHARES))
    rows = [(say(f"report.variation_{name}"), *cells) for name, *cells in found.rows()]
    return [*(Laid(line) for line in table(head, rows)), *found.explain().splitlines()]


def sweep(job: str, over: list[str], simulate: bool, progress: bool) -> Answer:
    """Every combination of values.

    Args:
        job: path of the file.
        over: `name=value,value,...` of variables of the job.
        simulate: drive each case too.
        progress: print progress even when stderr is no terminal.

    Raises:
        MafsilError: the job or the robot cannot be read, or do not fit each other; a name that is no variable.
    """
    path = Path(job)
    with Progress(progress) as bar:
        bar.enter("stage_planning")
        grid = dict(map(_values, over))
        found = swept(text_of(path), grid, path.parent, path.name, simulate=simulate, progress=bar.update)
    head, rows = found.columns()
    shown = [name if name in grid else say(f"cli.sweep_{name}") for name in head]
    lines = [*(Laid(line) for line in table(shown, rows)), *found.explain().splitlines()]
    return Answer(found.to_dict(), tuple(lines))


def _values(words: str) -> tuple[str, list[bool | float | str]]:
    """Name and values of `name=value,value`."""
    name, equals, values = words.partition("=")
    parts = [part.strip() for part in values.split(",") if part.strip()]
    if not equals or not name.strip() or not parts:
        raise InputError("cli.sweep_values", given=words)
    return name.strip(), [typed_value(part) for part in parts]
