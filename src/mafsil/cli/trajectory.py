"""`mafsil trajectory`: why a motion through points is impossible and what mends it; motions for controllers.

How the run ended whose recording a file is: what stands beside it says so.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np

from mafsil.arrays import Floats
from mafsil.cli.answer import Answer, Laid, Toned
from mafsil.cli.state import number
from mafsil.csv_table import read_csv_table
from mafsil.errors import InputError
from mafsil.job.remark import JobStatus
from mafsil.messages import say
from mafsil.regular_file import whole_text
from mafsil.robot import Robot, load
from mafsil.simulation.recording import SimulationStatus
from mafsil.trajectory import MotionLimits, check, compare_profiles, export, read_trajectory, suggest_fixes
from mafsil.trajectory.files import TrajectoryFile
from mafsil.trajectory.files.exporting import is_recording, joint_names
from mafsil.trajectory.motion import overview
from mafsil.trajectory.splines import PiecewisePolynomial

MOST_BYTES = 50_000_000
"""Of a file that says how a run ended."""
USUAL_RATE = 125.0
"""Points per second, where none is asked for [Hz]."""


def trajectory(
    action: str,
    robot: str,
    file: str,
    out: str | None,
    rate: str | None,
    acceleration: str | None,
    jerk: str | None,
    curve: str | None,
    remedy: str | None,
    tip: str | None,
    driven: bool,
    failed: bool,
) -> Answer:
    """One of the actions of the command.

    Args:
        action: `check`, `suggest-fixes`, `compare` or `export`.
        robot: name or file, whose limits count.
        file: CSV with a column of times and one for each joint.
        out: file to be written; of `export` its ending says the format, of `compare` it is a picture.
        rate: points per second, as typed [Hz].
        acceleration, jerk: of `compare`, limits of joints that have none, as typed [rad/s^2 | m/s^2, rad/s^3 | m/s^3].
        curve, remedy: of `suggest-fixes`: the curve through the points, and the kind of change that is applied.
        tip: another tip link.
        driven: of `check` and `export`: of a recording the motion that was driven, not the plan.
        failed: of `export`: a recording of a run that failed is written too.

    Raises:
        MafsilError: no such robot or file, a column for another joint, an option that the action does not have.
    """
    owners = (
        ("--curve", curve, ("suggest-fixes",)),
        ("--remedy", remedy, ("suggest-fixes",)),
        ("--acceleration", acceleration, ("compare",)),
        ("--jerk", jerk, ("compare",)),
        ("--driven", driven or None, ("check", "export")),
        ("--failed", failed or None, ("export",)),
    )
    for name, value, owner in owners:
        if value is not None and action not in owner:
            raise InputError("cli.trajectory_option", option=name, action=action, owner=", ".join(owner))
    arm = load(robot, tip=tip)
    points = USUAL_RATE if rate is None else number("--rate", rate)
    actions: dict[str, Callable[[], Answer]] = {
        "check": lambda: _check(arm, file, driven),
        "suggest-fixes": lambda: _suggest_fixes(arm, file, curve, remedy, out, points),
        "compare": lambda: _compare(arm, file, acceleration, jerk, out),
        "export": lambda: _export(arm, file, out, points, driven, failed),
    }
    return actions[action]()


def _check(arm: Robot, file: str, driven: bool) -> Answer:
    """What the motion of a file looks like, and whether it keeps the limits."""
    motion, which = _motion(arm, file, driven)
    verdict = check(motion, arm, arm.joint_names)
    data: dict[str, Any] = {"robot": arm.name, "duration": motion.duration, **verdict.to_dict()}
    lines = (*which, *(Laid(line) for line in overview(motion, arm.joint_names).split("\n")))
    if verdict:
        return Answer(data, (*lines, Toned(verdict.explain(), "good")))
    return Answer(data, lines, verdict.explain())


def _compare(arm: Robot, file: str, acceleration: str | None, jerk: str | None, out: str | None) -> Answer:
    """Every profile through the points of a file; a picture of them."""
    table = read_csv_table(file, fewest=2)
    columns = table.joint_columns("q", _joints(arm, file), required=True) or []
    own = MotionLimits.of_joints(arm.limits)
    given = {
        "acceleration": own.acceleration if acceleration is None else number("--acceleration", acceleration),
        "jerk": own.jerk if jerk is None else number("--jerk", jerk),
    }
    bounds = {name: _where_known(getattr(own, name), value) for name, value in given.items()}
    limits = MotionLimits.of(arm.n, velocity=tuple(own.velocity), **bounds)
    found = compare_profiles(table.numbers(columns), limits, robot=arm)
    data: dict[str, Any] = {"robot": arm.name, **found.to_dict()}
    if out is not None:
        from mafsil.figures import plot_profiles

        plot_profiles(found, out)
        data["picture"] = out
    first, *rows = found.explain().split("\n")
    lines = tuple(Laid(row) for row in rows)
    return Answer(data, (first, *lines)) if found else Answer(data, lines, first)


def _where_known(own: Floats, other: Floats | float) -> tuple[Floats, Floats]:
    """Lower and upper limits: a joint's own, or the other where it has none."""
    both = np.broadcast_to(other, own.shape) if isinstance(other, np.ndarray) else np.array([[-other], [other]])
    lower, upper = np.where(np.isfinite(own), own, both)
    return lower, upper


def _suggest_fixes(
    arm: Robot, file: str, curve: str | None, remedy: str | None, out: str | None, rate: float
) -> Answer:
    """What makes the motion through the points of a file impossible; the mended motion in another file."""
    table = read_csv_table(file, fewest=2)
    t = table.numbers([table.time_column()])[:, 0]
    table.require_increasing(t)
    names = _joints(arm, file)
    columns = table.joint_columns("q", names, required=True) or []
    found = suggest_fixes(table.numbers(columns), np.diff(t), arm, curve="stops" if curve == "stops" else "spline")
    data: dict[str, Any] = {"robot": arm.name, **found.to_dict()}
    lines = found.explain().split("\n")
    if out is None and remedy is None:
        return Answer(data, tuple(lines) if found else tuple(lines[1:]), None if found else lines[0])
    if out is None:
        raise InputError("cli.trajectory_out_missing", option="--remedy")
    written = export(found.apply_fix(remedy), out, arm, rate=rate)
    return _written(data, lines, written)


def _export(arm: Robot, file: str, out: str | None, rate: float, driven: bool, failed: bool) -> Answer:
    """The motion of a file for a controller; of a recording the plan, if the run did not fail."""
    if out is None:
        raise InputError("cli.trajectory_out_missing", option="export")
    motion, which = _motion(arm, file, driven)
    if which and not failed:
        require_success(Path(file))
    return _written({"robot": arm.name}, list(which), export(motion, out, arm, rate=rate))


def _motion(arm: Robot, file: str, driven: bool) -> tuple[PiecewisePolynomial, tuple[str, ...]]:
    """The motion of a file, and, of a recording, the line that says which of its two motions it is."""
    joints = _joints(arm, file)
    recorded = is_recording(read_csv_table(file), joints)
    which = (say(f"cli.trajectory_{'driven_motion' if driven else 'plan'}", file=file),) if recorded else ()
    return read_trajectory(file, joints=joints, driven=driven), which


def _written(data: dict[str, Any], lines: list[str], written: TrajectoryFile) -> Answer:
    sentence = written.explain()
    data = data | {"file": written.to_dict()}
    return Answer(data, (*lines, sentence)) if written else Answer(data, tuple(lines), sentence)


def _joints(arm: Robot, file: str) -> tuple[str, ...]:
    """Joints of the robot, as the file names or numbers them; joint1, joint2, ... are numbers of any robot's joints.

    Raises:
        InputError: the file names other joints.
    """
    named = joint_names(read_csv_table(Path(file)))
    counted = tuple(f"joint{k}" for k in range(1, arm.n + 1))
    if set(named) == set(counted) and not set(named) & set(arm.joint_names):
        return counted
    if named and set(arm.joint_names) - set(named):
        raise InputError("cli.trajectory_joints", file=file, got=", ".join(named), expected=", ".join(arm.joint_names))
    return arm.joint_names


def require_success(recording: Path) -> None:
    """Refuse the recording of a run that did not reach its end, or of a job that failed.

    Args:
        recording: a CSV file; its notes (`recording.json`) and the results of its job (`results.json`) are looked for
            beside it.

    Raises:
        InputError: the run failed; the sentence says how.
    """
    note = _status(recording.with_suffix(".json"))
    if note in SimulationStatus.__members__ and not SimulationStatus[note].succeeded:
        raise InputError("cli.trajectory_failed_run", file=str(recording), status=note.lower())
    result = _status(recording.with_name("results.json")) if recording.stem == "recording" else ""
    if result.upper() in JobStatus.__members__ and not JobStatus[result.upper()].succeeded:
        raise InputError("cli.trajectory_failed_run", file=str(recording), status=result)


def _status(path: Path) -> str:
    """The status that a file of ours holds; empty for any other file, or none."""
    try:
        data = json.loads(whole_text(path, MOST_BYTES))
    except (OSError, ValueError, RecursionError):
        return ""
    status = cast("dict[str, Any]", data).get("status") if isinstance(data, dict) else None
    return status if isinstance(status, str) else ""
