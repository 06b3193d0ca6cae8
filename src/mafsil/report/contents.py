"""A run as a page: numbers chosen, frames picked, texts in the reader's language."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.job import judgement
from mafsil.job.arrival import Arrival
from mafsil.job.judgement import Summary, error_details, joint_quantity
from mafsil.job.payload import box_in_tip
from mafsil.job.plan import Leg
from mafsil.job.run import Run
from mafsil.messages import say
from mafsil.messages.quantities import digits, quantity
from mafsil.model import JointKind
from mafsil.model.shape import Box, Capsule, Cylinder, Sphere
from mafsil.report.content import Details, Figure, Finding, Level, Page, Plot, Scene, Step, Table
from mafsil.scene import Body, Drawing, Solid, compact

PACKAGES = ("mafsil", "numpy", "scipy", "llvmlite", "msgspec")
MOST_POSES = 60_000
"""Of all bodies in all frames: a long replay gets fewer frames, so that the page stays below some megabytes."""
Rows: TypeAlias = NDArray[np.intp]

PART_COLOUR = (0.23, 0.47, 0.70, 1.0)
OBSTACLE_COLOUR = (0.72, 0.66, 0.58, 1.0)


def page(run: Run, numbers: Summary, language: str) -> Page:
    """The page of a run."""
    words = _Words(language)
    rows = plot_rows(run)
    findings = tuple(Finding(remark.level, remark.sentence(language)) for remark in run.remarks)
    findings = findings or (Finding("good", words("no_findings")),)
    robot, controller = run.robot.name, words(f"controller_{run.job.controller.kind}")
    return Page(
        language=language,
        title=run.job.title or words("untitled", robot=robot),
        subtitle=f"{robot} · {controller} · {method(run)} · {quantity(run.job.simulation.step, 's')}",
        verdict=verdict(run, language),
        duration=numbers.duration,
        scene=scene(run),
        times=run.recording.t[rows],
        joints=run.robot.joint_names,
        plots=_plots(run, rows, numbers, words),
        figures=_figures(run, numbers, words),
        findings=findings,
        steps=_steps(run, numbers, words),
        joint_table=_joint_table(run, numbers, words),
        details=_details(run, words),
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
    if grave & {"job.cannot_hold", "job.cannot_hold_part"}:
        return failure("cannot_hold")
    if grave:
        return failure("failures", count=sum(remark.level == "failure" for remark in run.remarks))
    if mild:
        return Finding("warning", say("report.verdict_warnings", language=language, count=mild))
    return Finding("good", say("report.verdict_good", language=language))


def plot_rows(run: Run) -> Rows:
    """Rows to plot: evenly spaced ones, and every extreme of every curve, so that no peak is lost."""
    tape = run.recording
    count = len(tape.t)
    even = np.unique(np.linspace(0, count - 1, min(count, run.job.report.rows)).round().astype(np.intp))
    curves = (tape.q, tape.qd, tape.tau, tape.q - tape.q_ref)
    peaks = [side(curve, axis=0) for curve in curves for side in (np.argmax, np.argmin)]
    return np.unique(np.concatenate([even, *peaks]))


def scene(run: Run) -> Scene:
    """Frames of the replay, the part that is carried included."""
    t = run.recording.t
    period = max(1.0 / run.job.report.frame_rate, t[-1] * (len(run.robot.mechanism.links) + 3) / MOST_POSES)
    moments = np.arange(0.0, t[-1] + period * 0.999, period)
    rows = np.minimum(np.searchsorted(t, np.minimum(moments, t[-1])), len(t) - 1)
    mechanism = run.robot.mechanism
    poses = np.asarray(run.robot.link_poses(run.recording.q[rows]))
    tips, references = run.tips(rows)
    parts = part_tracks(run, moments)
    seen = np.concatenate([poses[:, :, :3, 3].reshape(-1, 3), tips[:, :3, 3]])
    drawing = Drawing(mechanism)
    centre, size, floor = drawing.extent(seen, poses[0])
    floor = min([floor, *(_lowest(body, track) for body, track in parts)])
    fixed = _obstacles(run, size)
    bodies = (*drawing.bodies(floor, poses[0]), *(body for body, _ in parts), *(body for body, _ in fixed))
    still = [np.broadcast_to(T, (len(poses), 1, 4, 4)) for _, T in fixed]
    every = np.concatenate([poses, *(track[:, None] for _, track in parts), *still], axis=1)
    targets = [(leg.name, compact(leg.target)) for leg in run.plan.legs if leg.target is not None]
    return Scene(
        bodies=bodies,
        period=period,
        poses=compact(every),
        tips=compact(tips),
        references=compact(references),
        targets=tuple(targets),
        centre=centre,
        size=size,
        floor=floor,
    )


def _obstacles(run: Run, size: float) -> list[tuple[Body, Floats]]:
    """What stands around the arm, with its pose; a half space is a flat plate as wide as the scene."""
    around = run.plan.surroundings
    found: list[tuple[Body, Floats]] = []
    for obstacle in () if around is None else around.scene:
        match obstacle.geometry:
            case Box(size=edges):
                solid = Solid("box", edges, colour=OBSTACLE_COLOUR)
            case Sphere(radius=radius):
                solid = Solid("sphere", (radius,), colour=OBSTACLE_COLOUR)
            case Cylinder(radius=radius, length=length):
                solid = Solid("cylinder", (radius, length), colour=OBSTACLE_COLOUR)
            case Capsule(radius=radius, length=length):
                solid = Solid("capsule", (radius, length), colour=OBSTACLE_COLOUR)
            case _:
                thin = 2e-3 * size
                below = (0.0, 0.0, -thin / 2, 1.0, 0.0, 0.0, 0.0)
                solid = Solid("box", (3 * size, 3 * size, thin), below, OBSTACLE_COLOUR)
        found.append((Body(obstacle.name, (solid,)), np.asarray(obstacle.T_so)))
    return found


def part_tracks(run: Run, moments: Floats) -> list[tuple[Body, Floats]]:
    """Each thing that is picked, with its pose at each moment: waiting where the plan takes it, carried, left.

    Args:
        run: what happened.
        moments: (frames,) times [s].
    """
    found: list[tuple[Body, Floats]] = []
    starts, t = run.plan.starts, run.recording.t
    tips, _ = run.tips(np.minimum(np.searchsorted(t, np.minimum(moments, t[-1])), len(t) - 1))
    taken = {one.stretch.first - 1 for one in run.driven if one.gripped}
    for k, leg in enumerate(run.plan.legs):
        grasp = run.job.move[leg.index].pick if leg.kind == "pick" else None
        if grasp is None:
            continue
        until = next((j for j in range(k + 1, len(run.plan.legs)) if run.plan.legs[j].kind == "place"), None)
        goal = leg.trajectory.at(leg.trajectory.duration).u
        track = np.tile(np.asarray(run.robot.forward_kinematics(goal)), (len(moments), 1, 1))
        if k in taken:
            begin = int(np.searchsorted(moments, float(starts[k + 1])))
            end = len(moments) if until is None else int(np.searchsorted(moments, float(starts[until + 1])))
            track[begin:end] = tips[begin:end]
            track[end:] = tips[min(end, len(tips)) - 1]
        found.append((Body(grasp.name, (Solid("box", grasp.size, colour=PART_COLOUR),)), track @ box_in_tip(grasp)))
    return found


def _lowest(body: Body, track: Floats) -> float:
    """Height of the lowest corner of a box on its way [m]."""
    half = np.array(body.solids[0].size) / 2
    return float((track[:, 2, 3] - np.abs(track[:, 2, :3]) @ half).min())


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

    return (
        Plot(words("position"), angle, tape.q[rows], np.stack([limits.lower, limits.upper], axis=1)),
        Plot(words("velocity"), f"{angle}/s", tape.qd[rows], both(limits.velocity)),
        Plot(words("effort"), effort, tape.tau[rows], both(limits.effort)),
        Plot(words("error"), angle, (tape.q - tape.q_ref)[rows]),
        *_clearance_plot(tape.t[rows], numbers, words),
    )


def _clearance_plot(t: Floats, numbers: Summary, words: _Words) -> tuple[Plot, ...]:
    """How near the arm came to anything, over time."""
    found = numbers.clearances
    if found is None or not np.isfinite(found.distance).all():
        return ()
    values = np.interp(t, found.t, found.distance)[:, None]
    return (Plot(words("clearance"), "m", values, np.array([[found.wanted, np.inf]]), (words("clearance_curve"),)),)


def _figures(run: Run, numbers: Summary, words: _Words) -> tuple[Figure, ...]:
    names, limit = run.robot.joint_names, run.robot.limits.effort
    worst = int(numbers.joint_error.argmax())
    share = np.where(np.isfinite(limit), numbers.peak_effort / np.where(limit > 0, limit, 1.0), 0.0)
    hardest = int(share.argmax())
    level: Level = "failure" if numbers.saturated.any() else "warning" if share[hardest] > 0.9 else "good"
    figures = [
        Figure(words("cycle"), f"{numbers.cycle:.3f}", "s", words("cycle_note", count=len(run.job.move))),
        *_target_figures(numbers, words),
        _figure(words("tip_error"), quantity(numbers.tip_error, "m"), _at(numbers.tip_error_time, words)),
        _figure(words("tip_turn"), quantity(numbers.tip_turn, "rad"), _at(numbers.tip_turn_time, words)),
        _figure(words("joint_error"), joint_quantity(run, worst, float(numbers.joint_error[worst])), names[worst]),
    ]
    if np.isfinite(limit).any():
        percent = digits(100 * float(share[hardest]))
        figures.append(Figure(words("peak_effort"), percent, words("percent_limit"), names[hardest], level))
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
            text = _arrived(run, leg, judged[k], words)
            level = "good" if judged[k].reached else "failure"
        elif end > run.recording.t[-1] + 2 * run.job.simulation.step:
            text, level = words("not_finished"), "failure"
        steps.append(Step(_name(leg, words), words(f"kind_{leg.kind}"), float(start), float(end), text, level))
    return tuple(steps)


def _arrived(run: Run, leg: Leg, judged: Arrival, words: _Words) -> str:
    """Where the arm was at the end of a leg, by all that is judged there."""
    details = error_details(run, judged)
    grasp = run.job.move[leg.index].pick
    if judged.goal == "pick" and grasp is not None:
        part = {"name": grasp.name, "mass": quantity(grasp.mass, "kg")}
        return words("picked" if judged.reached else "not_gripped", **part, **details)
    if judged.goal == "place":
        driven = max((one for one in run.driven if one.stretch.first <= judged.leg), key=lambda one: one.stretch.first)
        if not driven.gripped:
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
    head = tuple(words(key) for key in keys)
    rows: list[tuple[str, ...]] = []
    for k, joint in enumerate(run.robot.mechanism.coordinates):
        unit, effort = ("m", "N") if joint.kind is JointKind.PRISMATIC else ("rad", "N m")
        bounds, acceleration = joint.limits, float(numbers.peak_acceleration[k])
        rows.append(
            (
                joint.name,
                f"{numbers.lowest[k]:.3f} … {numbers.highest[k]:.3f} {unit}",
                f"{digits(float(numbers.peak_speed[k]))} {unit}/s{_share(numbers.peak_speed[k], bounds.velocity)}",
                f"{digits(acceleration)} {unit}/s²{_share(acceleration, bounds.acceleration)}",
                f"{digits(float(numbers.peak_effort[k]))} {effort}{_share(numbers.peak_effort[k], bounds.effort)}",
                f"{digits(float(numbers.rms_effort[k]))} {effort}",
                joint_quantity(run, k, float(numbers.joint_error[k])),
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
        Details(words("job_file"), text=run.text),
        Details(words("versions"), tuple(versions().items())),
    )


def versions() -> dict[str, str]:
    """Versions of everything that took part."""
    found = {"python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found
