"""A run as a page: numbers chosen, frames picked, texts in the reader's language."""

from __future__ import annotations

import platform
import re
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.control.analysis import words_for
from mafsil.job.driving.arrival import INSTANT, Arrival
from mafsil.job.driving.run import Run
from mafsil.job.judging import judgement
from mafsil.job.judging.judgement import Summary, error_details
from mafsil.job.judging.symptoms import joint_quantity
from mafsil.job.planning.cell_signals import assignments, conditions
from mafsil.job.planning.plan import Leg
from mafsil.job.planning.surroundings import WayRound
from mafsil.job.remark import Remark
from mafsil.messages import LANGUAGES, say
from mafsil.messages.quantities import digits, quantity
from mafsil.model import JointKind
from mafsil.report.content import Details, Figure, Finding, Level, Page, Plot, Scene, Step, Table
from mafsil.report.replay import recipe, replay_scene
from mafsil.report.run_tables import limit_plot, limit_table, variation_findings, variation_table

NARROW = ("job.gap_below_error", "job.gap_below_smallest")
"""Warnings of gaps that are smaller than the error of the run, or than any that is safe."""
PACKAGES = ("mafsil", "numpy", "scipy", "llvmlite", "msgspec")
Rows: TypeAlias = NDArray[np.intp]


def pages(run: Run, numbers: Summary, language: str) -> tuple[Page, ...]:
    """The page of a run in every language, the given one first; they share what is drawn."""
    drawn = replay_scene(run)
    return tuple(page(run, numbers, code, drawn) for code in (language, *(c for c in LANGUAGES if c != language)))


def page(run: Run, numbers: Summary, language: str, drawn: Scene | None = None) -> Page:
    """The page of a run.

    Args:
        run: what happened.
        numbers: what is judged.
        language: of all texts.
        drawn: its scene, if that is made already.
    """
    words = _Words(language)
    rows = plot_rows(run)
    findings = tuple(Finding(remark.level, remark.sentence(language), _moment(remark)) for remark in run.remarks)
    findings = findings or (Finding("good", words("no_findings")),)
    robot, controller = run.robot.name, words(f"controller_{run.job.controller.kind}")
    return Page(
        language=language,
        title=run.job.title or words("untitled", robot=robot),
        subtitle=f"{robot} · {controller} · {method(run)} · {quantity(run.job.simulation.step, 's')}",
        verdict=verdict(run, language),
        duration=numbers.duration,
        robot=run.robot,
        recipe=recipe(run.job),
        scene=replay_scene(run) if drawn is None else drawn,
        times=run.recording.t[rows],
        joints=run.robot.joint_names,
        plots=(*_plots(run, rows, numbers, words), *limit_plot(run, run.recording.t[rows], language)),
        figures=_figures(run, numbers, words),
        findings=findings,
        steps=_steps(run, numbers, words),
        joint_table=_joint_table(run, numbers, words),
        limit_table=limit_table(run, numbers.cycle, language),
        details=_details(run, words),
        variation_table=variation_table(run, language),
        variation_findings=variation_findings(run, language),
    )


def method(run: Run) -> str:
    """The integrator that ran."""
    return str(run.recording.metadata["integrator"])


def verdict(run: Run, language: str | None = None) -> Finding:
    """How the run went, in a few words: the gravest thing that its remarks say."""
    grave = {remark.key for remark in run.remarks if remark.level == "failure"}
    mild = sum(remark.level == "warning" for remark in run.remarks)

    def failure(key: str, **details: object) -> Finding:
        return Finding("failure", say(f"report.verdict_{key}", language=language, **details))

    if run.stopped is not None:
        return failure("stopped")
    if "job.gives_way" in grave:
        return failure("gives_way")
    if not_reached := judgement.not_reached(run.remarks):
        return failure("not_reached", count=not_reached, total=judgement.targets(run.plan))
    if grave & {"job.cannot_hold", "job.cannot_hold_part", "job.cannot_press"}:
        return failure("cannot_hold")
    if grave:
        return failure("failures", count=sum(remark.level == "failure" for remark in run.remarks))
    if narrow := [remark.key.removeprefix("job.") for remark in run.remarks if remark.key in NARROW]:
        return Finding("warning", say(f"report.verdict_{narrow[0]}", language=language))
    if mild:
        return Finding("warning", say("report.verdict_warnings", language=language, count=mild))
    return Finding("good", say("report.verdict_good", language=language))


def _moment(remark: Remark) -> float | None:
    """When what is not good happened, as its sentence says [s]."""
    said = re.fullmatch(r"([\d.]+) (m?s)", str(remark.details.get("time")))
    return None if said is None or remark.level == "good" else float(said[1]) * (1e-3 if said[2] == "ms" else 1.0)


def plot_rows(run: Run) -> Rows:
    """Rows to plot: evenly spaced ones, every extreme of every curve, and before and after each change of a signal."""
    tape = run.recording
    count = len(tape.t)
    even = np.unique(np.linspace(0, count - 1, min(count, run.job.report.rows)).round().astype(np.intp))
    curves = (tape.q, tape.qd, tape.tau, tape.q - tape.q_ref)
    peaks = [side(curve, axis=0) for curve in curves for side in (np.argmax, np.argmin)]
    changes = [] if run.plan.signals is None else run.plan.signals.timeline(float(tape.t[-1]), run.job.report.rows)
    after = np.searchsorted(tape.t, [change.time - INSTANT for change in changes]).clip(1, count - 1)
    return np.unique(np.concatenate([even, *peaks, after, after - 1]))


class _Words:
    """Sentences of the report in one language."""

    def __init__(self, language: str) -> None:
        self.language = language

    def __call__(self, key: str, **details: object) -> str:
        return say(f"report.{key}", language=self.language, **details)


def _plots(run: Run, rows: Rows, numbers: Summary, words: _Words) -> tuple[Plot, ...]:
    limits, tape = run.robot.limits, run.recording
    kinds = {joint.kind is JointKind.PRISMATIC for joint in run.robot.mechanism.coordinates}
    angle = "rad" if kinds == {False} else "m" if kinds == {True} else "rad, m"
    effort = "N m" if kinds == {False} else "N" if kinds == {True} else "N m, N"

    def both(bound: Floats) -> Floats:
        return np.stack([-bound, bound], axis=1)

    driven = (
        Plot("tau", words("effort"), effort, tape.tau[rows], both(limits.effort)),
        Plot("q_error", words("error"), angle, (tape.q - tape.q_ref)[rows]),
    )
    return (
        Plot("q", words("position"), angle, tape.q[rows], np.stack([limits.lower, limits.upper], axis=1)),
        Plot("qd", words("velocity"), f"{angle}/s", tape.qd[rows], both(limits.velocity)),
        *(() if run.plan.kinematic else driven),
        *_clearance_plot(tape.t[rows], numbers, words),
        *_contact_plot(run, rows, words),
        *_signal_plot(run, rows, words),
    )


def _clearance_plot(t: Floats, numbers: Summary, words: _Words) -> tuple[Plot, ...]:
    """How near the arm came to anything, over time."""
    found = numbers.clearances
    if found is None or not np.isfinite(found.distance).all():
        return ()
    values = np.interp(t, found.t, found.distance)[:, None]
    title, name = words("clearance"), words("clearance_curve")
    if np.ptp(found.wanted) == 0.0:
        return (Plot("clearance", title, "m", values, np.array([[found.wanted[0], np.inf]]), (name,)),)
    wanted = found.wanted[np.searchsorted(found.t, t).clip(0, len(found.t) - 1)][:, None]
    names, keys = (name, words("clearance_wanted")), ("distance", "wanted")
    return (Plot("clearance", title, "m", np.concatenate([values, wanted], axis=1), None, names, keys),)


def _contact_plot(run: Run, rows: Rows, words: _Words) -> tuple[Plot, ...]:
    """Force of the surfaces on the tip, over time."""
    wrench = run.recording.contact_wrench
    if wrench is None:
        return ()
    force = np.linalg.norm(wrench[rows][:, 3:], axis=-1)[:, None]
    return (Plot("contact_force", words("contact_force"), "N", force, None, (words("contact_force"),)),)


def _signal_plot(run: Run, rows: Rows, words: _Words) -> tuple[Plot, ...]:
    """Outputs and inputs over time; true is 1."""
    signals = run.plan.signals
    if signals is None:
        return ()
    t = run.recording.t[rows].tolist()
    values = np.array([[float(signals.value(name, time)) for name in signals.names] for time in t])
    return (Plot("signals", words("signals"), words("signals_unit"), values, None, signals.names, signals.names),)


def _figures(run: Run, numbers: Summary, words: _Words) -> tuple[Figure, ...]:
    names, limit = run.robot.joint_names, run.robot.limits.effort
    worst = int(numbers.joint_error.argmax())
    share = np.where(np.isfinite(limit), numbers.peak_effort / np.where(limit > 0, limit, 1.0), 0.0)
    hardest = int(share.argmax())
    level: Level = "failure" if numbers.saturated.any() else "warning" if share[hardest] > 0.9 else "good"
    planned = [
        Figure(words("cycle"), f"{numbers.cycle:.3f}", "s", words("cycle_note", count=run.plan.made)),
        *_target_figures(numbers, words),
    ]
    if run.plan.kinematic:
        return tuple(planned)
    figures = [
        *planned,
        _figure(words("tip_error"), quantity(numbers.tip_error, "m"), _at(numbers.tip_error_time, words)),
        _figure(words("tip_turn"), quantity(numbers.tip_turn, "rad"), _at(numbers.tip_turn_time, words)),
        _figure(words("joint_error"), joint_quantity(run, worst, float(numbers.joint_error[worst])), names[worst]),
    ]
    if np.isfinite(limit).any():
        percent = digits(100 * float(share[hardest]))
        figures.append(Figure(words("peak_effort"), percent, words("percent_limit"), names[hardest], level))
    pressed = numbers.touching
    if pressed is not None:
        note = _at(pressed.peak_time, words)
        figures.append(_figure(words("contact_force"), quantity(pressed.peak, "N"), note))
    figures.append(Figure(words("energy"), digits(numbers.energy), "J", words("energy_note")))
    seconds = float(run.recording.metadata["seconds"])
    real = numbers.duration / seconds if seconds > 0 else 0.0
    figures.append(Figure(words("speed_of_simulation"), f"{real:.1f}", "×", words("speed_note")))
    return tuple(figures)


def _figure(label: str, value: str, note: str) -> Figure:
    """A quantity, its unit shown smaller."""
    number, _, unit = value.partition(" ")
    return Figure(label, number, unit, note)


def _at(time: float, words: _Words) -> str:
    return words("at", time=quantity(time, "s"))


def _target_figures(numbers: Summary, words: _Words) -> list[Figure]:
    """How many targets were reached, and the largest errors at the ends of their moves."""
    if not numbers.targets:
        return []
    reached = sum(one.reached for one in numbers.arrivals)
    worst = {
        "position": quantity(max((one.position_error for one in numbers.arrivals), default=0.0), "m"),
        "angle": quantity(max((one.orientation_error for one in numbers.arrivals), default=0.0), "rad"),
    }
    level: Level = "good" if reached == numbers.targets else "failure"
    # Read left to right in both languages, as all values of the cards.
    value = f"{reached} / {numbers.targets}"
    note = words("targets_note", **worst) if numbers.arrivals else ""
    return [Figure(words("targets"), value, "", note, level)]


def _steps(run: Run, numbers: Summary, words: _Words) -> tuple[Step, ...]:
    judged = {one.leg: one for one in numbers.arrivals}
    steps: list[Step] = []
    for k, (leg, start, end) in enumerate(zip(run.plan.legs, run.plan.starts, run.plan.starts[1:], strict=False)):
        text, level = "", "good"
        if k in judged:
            text = _arrive(run, leg, judged[k], words)
            level = "good" if judged[k].reached else "failure"
        elif end > run.recording.t[-1] + 2 * run.job.simulation.step:
            text, level = words("not_finished"), "failure"
        elif leg.kind in ("set", "wait"):
            move = run.job.move[leg.index]
            said = assignments(move.set) or conditions(move.wait)
            text = "" if said == leg.name else said
        elif leg.decision is not None:
            text = leg.decision.explain(language=words.language)
        steps.append(Step(_name(leg, words), words(f"kind_{leg.kind}"), float(start), float(end), text, level))
    return (*steps, *_other_steps(run, words))


def _other_steps(run: Run, words: _Words) -> Iterator[Step]:
    """What other robots do, each after the other."""
    for beside in run.plan.neighbours:
        for one in beside.steps:
            name = words("other_move", name=beside.neighbour.name, number=one.number)
            text = one.text if one.decision is None else one.decision.explain(language=words.language)
            yield Step(name, words(f"kind_{one.kind}"), one.start, one.end, text, "good", beside=True)


def _arrive(run: Run, leg: Leg, judged: Arrival, words: _Words) -> str:
    """Where the arm was at the end of a leg, by all that is judged there."""
    details = error_details(run, judged)
    grasp = run.job.move[leg.index].pick
    if judged.goal == "pick" and grasp is not None:
        part = {"name": grasp.name, "mass": quantity(grasp.mass, "kg")}
        return words("picked" if judged.reached else "not_gripped", **part, **details)
    if judged.goal == "place":
        passed = max((one for one in run.passed if one.stretch.first <= judged.leg), key=lambda one: one.stretch.first)
        if not passed.gripped:
            return words("nothing_placed")
        return words("placed" if judged.reached else "place_not_reached", **details)
    kind = "_joints" if judged.goal == "joints" else ""
    return words(("reached" if judged.reached else "not_reached") + kind, **details)


def _name(leg: Leg, words: _Words) -> str:
    """The job's name of a leg, or its number."""
    if leg.kind == "settle":
        return words("settle")
    return leg.name or words("move_number", number=leg.index + 1)


def _joint_table(run: Run, numbers: Summary, words: _Words) -> Table:
    keys = ("joint", "range", "peak_speed", "peak_acceleration", "peak_torque", "rms_torque", "largest_error")
    head = tuple(words(key) for key in (keys[:4] if run.plan.kinematic else keys))
    rows: list[tuple[str, ...]] = []
    for k, joint in enumerate(run.robot.mechanism.coordinates):
        unit, effort = ("m", "N") if joint.kind is JointKind.PRISMATIC else ("rad", "N m")
        bounds, acceleration = joint.limits, float(numbers.peak_acceleration[k])
        driven = (
            ()
            if run.plan.kinematic
            else (
                f"{digits(float(numbers.peak_effort[k]))} {effort}{_share(numbers.peak_effort[k], bounds.effort)}",
                f"{digits(float(numbers.rms_effort[k]))} {effort}",
                joint_quantity(run, k, float(numbers.joint_error[k])),
            )
        )
        rows.append(
            (
                joint.name,
                f"{numbers.lowest[k]:z.3f} … {numbers.highest[k]:z.3f} {unit}",
                f"{digits(float(numbers.peak_speed[k]))} {unit}/s{_share(numbers.peak_speed[k], bounds.velocity)}",
                f"{digits(acceleration)} {unit}/s²{_share(acceleration, bounds.acceleration)}",
                *driven,
            )
        )
    return Table(head, tuple(rows))


def _share(value: float, limit: float) -> str:
    return f" ({digits(100 * value / limit)} %)" if np.isfinite(limit) and limit > 0 else ""


def _details(run: Run, words: _Words) -> tuple[Details, ...]:
    origin = run.robot.mechanism.provenance
    robot = [(words("name"), run.robot.name), (words("source"), origin.source or words("unknown"))]
    robot += [(words("licence"), origin.licence)] if origin.licence else []
    robot += [(words("note"), note) for note in origin.notes]
    return (
        Details(words("robot"), tuple(robot), open=True),
        *_ways(run, words),
        Details(words("explained"), tuple(_explain(run, words))),
        Details(words("job_file"), text=run.text),
        Details(words("versions"), tuple(versions().items())),
    )


def _ways(run: Run, words: _Words) -> Iterator[Details]:
    """The planner's account of each move that goes round something."""
    rounds = [leg for leg in run.plan.legs if leg.way is not None]
    if rounds:
        pairs = ((_name(leg, words), _account(leg.way, words)) for leg in rounds if leg.way is not None)
        yield Details(words("ways_round"), tuple(pairs), open=True)


def _account(way: WayRound, words: _Words) -> str:
    """What the planner looked at, and what would have been hit or was kept."""
    kept = way.keeps
    if kept is None:
        return words("way_round", **way.details())
    return words("way_kept", **way.details(), kept=kept.explain(language=words.language))


def _explain(run: Run, words: _Words) -> Iterator[tuple[str, str]]:
    """The law, the measures and the plots of the page in words, each with its formula."""
    kind, names = run.job.controller.kind, {"response_plot": words("position")}
    if not run.plan.kinematic:
        names |= {kind: words(f"controller_{kind}"), "tip_error": words("tip_error"), "energy": words("energy")}
        names["effort_plot"] = words("effort")
    if run.recording.contact_wrench is not None:
        names["contact_force"] = words("contact_force")
    for name, label in names.items():
        found = words_for(name)
        yield label, f"{found.paragraph(words.language)} {found.formula}"


def versions() -> dict[str, str]:
    """Versions of everything that took part."""
    found = {"python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found
