"""Trajectories in files for controllers, held against the limits first: CSV (read back, too), ROS 2 and URScript.

References: the message definitions of common_interfaces (trajectory_msgs, std_msgs, builtin_interfaces); Universal
Robots, The URScript Programming Language, servoj and movej.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from os import PathLike
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, positive
from mafsil.csv_table import CsvTable, csv_text, joint_columns, read_csv_table
from mafsil.errors import FileError, InputError
from mafsil.robot import Robot
from mafsil.trajectory.checks.limit_check import LimitCheck, check, not_checked
from mafsil.trajectory.motion import Trajectory
from mafsil.trajectory.motion_limits import Limits
from mafsil.trajectory.profiles.polynomial import cubic_coefficients, quintic_coefficients
from mafsil.trajectory.splines.cubic_spline import cubic_through
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.tolerances import ROUNDING
from mafsil.whole_file import write_whole

MOST_ROWS = 10_000_000
"""Rows of a file: a longer motion at this rate is refused before memory is asked for."""
NANO = 1_000_000_000


def message(samples: Samples) -> dict[str, Any]:
    """The message as plain data."""
    rows = zip(samples.t.tolist(), samples.q.tolist(), samples.qd.tolist(), samples.qdd.tolist(), strict=True)
    return {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""},
        "joint_names": list(samples.joints),
        "points": [
            {
                "positions": q,
                "velocities": qd,
                "accelerations": qdd,
                "effort": [],
                "time_from_start": _duration(time),
            }
            for time, q, qd, qdd in rows
        ],
    }


def as_json(samples: Samples) -> bytes:
    """The message as JSON, a point to a line."""
    whole = message(samples)
    points = ",\n    ".join(json.dumps(point) for point in whole["points"])
    head = ",\n  ".join(f"{json.dumps(key)}: {json.dumps(whole[key])}" for key in ("header", "joint_names"))
    return f'{{\n  {head},\n  "points": [\n    {points}\n  ]\n}}\n'.encode()


def as_yaml(samples: Samples) -> bytes:
    """The message as YAML, as `ros2 topic pub` and `ros2 action send_goal` take it.

    Lists and strings in the flow style of YAML are written as in JSON, which is a part of it.
    """
    whole = message(samples)
    lines = ["header:", "  stamp: {sec: 0, nanosec: 0}", "  frame_id: ''"]
    lines += [f"joint_names: {json.dumps(whole['joint_names'])}", "points:"]
    for point in whole["points"]:
        time = point["time_from_start"]
        lines.append(f"- positions: {_flow(point['positions'])}")
        lines += [f"  {name}: {_flow(point[name])}" for name in ("velocities", "accelerations", "effort")]
        lines.append(f"  time_from_start: {{sec: {time['sec']}, nanosec: {time['nanosec']}}}")
    return ("\n".join(lines) + "\n").encode()


def _flow(values: list[float]) -> str:
    """Numbers with a point in every mantissa: YAML 1.1 reads 1e-17 as text, and 1.0e-17 as a number."""
    return "[" + ", ".join(_number(value) for value in values) + "]"


def _number(value: float) -> str:
    mantissa, exponent, power = repr(value).partition("e")
    return mantissa + (".0" if "." not in mantissa else "") + exponent + power


def _duration(time: float) -> dict[str, int]:
    """Whole seconds and nanoseconds."""
    sec, nanosec = divmod(round(time * NANO), NANO)
    return {"sec": sec, "nanosec": nanosec}


@dataclass(frozen=True, eq=False, slots=True)
class Samples:
    """Rows of a trajectory of n joints.

    Attributes:
        joints: (n) names.
        t: (k,) increasing times, 0 and the duration included [s].
        q, qd, qdd: (k, n) [rad | m] and time derivatives.
    """

    joints: tuple[str, ...]
    t: Floats
    q: Floats
    qd: Floats
    qdd: Floats


def sample_trajectory(trajectory: Trajectory, joints: Sequence[str], rate: float) -> Samples:
    """The trajectory at even times, and at its end.

    Args:
        trajectory: of n joints, not a batch.
        joints: (n) names; joint1, joint2, ... if empty.
        rate: rows per second [Hz].

    Raises:
        InputError: a rate that is not positive, names that do not fit, a batch, or too many rows.
    """
    period = 1.0 / positive("rate", rate)
    if trajectory.duration / period > MOST_ROWS:
        raise InputError("trajectory.too_many_rows", duration=trajectory.duration, rate=rate, most=MOST_ROWS)
    start = trajectory.at(0.0).u
    if start.ndim != 1:
        raise InputError("input.shape", name="trajectory", expected=(trajectory.n,), got=start.shape, hint="")
    names = tuple(joints) or tuple(f"joint{k}" for k in range(1, trajectory.n + 1))
    if len(names) != trajectory.n or len(set(names)) != len(names):
        raise InputError("trajectory.joint_names", count=trajectory.n, got=", ".join(names))
    # A last step that is shorter than the rounding of its time is none.
    even = np.arange(int(np.floor(trajectory.duration / period * (1 - ROUNDING))) + 1) * period
    t = np.append(even[even < trajectory.duration], trajectory.duration)
    return Samples(names, t, *trajectory.at(t))


SIGNALS = ("q", "qd", "qdd")


def as_csv(samples: Samples) -> bytes:
    """The rows as text that reads back to the last bit."""
    values = (samples.q, samples.qd, samples.qdd)
    return b"".join(csv_text({"t": samples.t, **joint_columns(SIGNALS, values, samples.joints)}))


def read_trajectory(
    path: str | PathLike[str], joints: Sequence[str] = (), *, driven: bool = False
) -> PiecewisePolynomial:
    """The trajectory of a CSV file, through every row; of a recording the plan that was to be driven.

    Between rows: quintics where velocities and accelerations are recorded, cubics where velocities are, and the cubic
    spline at rest at both ends where only positions are. Its time begins at zero whatever that of the file.

    Args:
        path: of a file with a heading line, columns `t` or `time`, and for every joint `q[NAME]` (or `q1`, `q_1`),
            if recorded `qd[NAME]` and `qdd[NAME]`; other columns are passed over. In rad or m, and seconds.
        joints: names of the joints, in the order of coordinates; as the file names them if empty.
        driven: of a recording, which holds the plan in `q_ref[NAME]`, `qd_ref[NAME]`, `qdd_ref[NAME]`, the motion that
            was driven instead, in `q[NAME]` and its derivatives.

    Raises:
        FileError: no such file, a missing column, a cell that is no number, times that do not increase.

    Example: `mf.trajectory.read_trajectory("motion.csv").at(0.5).u`
    """
    table = read_csv_table(path)
    names = tuple(joints) or joint_names(table)
    if not names:
        names = tuple(str(k) for k in range(1, 1 + sum(_is_numbered(head) for head in table.heads)))
    if not names:
        raise table.no_column("q[JOINT]")
    planned = not driven and is_recording(table, names)
    signals = [f"{signal}_ref" if planned else signal for signal in SIGNALS]
    found = [table.joint_columns(signal, names, required=signal == "q") for signal in signals]
    time = table.numbers([table.time_column()])[:, 0]
    table.require_increasing(time)
    q, qd, qdd = (None if columns is None else table.numbers(columns) for columns in found)
    if q is None:
        raise FileError("csv_table.no_column", path=table.file, column="q", found="")
    return _through(time, q, qd, qdd)


def is_recording(table: CsvTable, joints: Sequence[str]) -> bool:
    """Whether a table holds a plan beside the motion that was driven.

    Raises:
        FileError: it does for some of the joints only.
    """
    return table.joint_columns(f"{SIGNALS[0]}_ref", joints, required=False) is not None


def joint_names(table: CsvTable) -> tuple[str, ...]:
    """Names of the joints in columns `q[NAME]`, in the order of the file; none where joints are numbered."""
    named = tuple(head[2:-1] for head in table.heads if head.startswith("q[") and head.endswith("]"))
    return () if all(name.isdecimal() for name in named) else named


def _is_numbered(head: str) -> bool:
    return head.startswith("q") and head[1:].strip("_[]").isdecimal()


def _through(t: Floats, q: Floats, qd: Floats | None, qdd: Floats | None) -> PiecewisePolynomial:
    """The smoothest curve that the recorded derivatives determine."""
    h = np.diff(t)
    if qd is None:
        return cubic_through(q, h)
    if qdd is None:
        pieces = [cubic_coefficients(q[i], q[j], qd[i], qd[j], float(h[i])) for i, j in pairwise(range(len(t)))]
    else:
        pieces = [
            quintic_coefficients(q[i], q[j], qd[i], qd[j], qdd[i], qdd[j], float(h[i]))
            for i, j in pairwise(range(len(t)))
        ]
    return PiecewisePolynomial.from_pieces(h, pieces)


JOINTS = 6
APPROACH = "a=0.5, v=0.25"
"""Of the move to the start [rad/s^2, rad/s]: slow, for it begins wherever the arm stands."""
LOOKAHEAD = 0.03
"""Shortest time over which servoj smooths what it follows [s]; it lags behind by about as much."""
GAIN = 1000
"""Proportional gain of servoj, within 100 .. 2000."""


def as_urscript(samples: Samples) -> bytes:
    """The program.

    Raises:
        InputError: not six joints.
    """
    if len(samples.joints) != JOINTS:
        raise InputError("trajectory.urscript_joints", got=len(samples.joints))
    lines = ["def mafsil_motion():", f"  movej({_joints(samples.q[0].tolist())}, {APPROACH})"]
    # The last step, which may be shorter than a period, takes a whole one.
    period = f"{samples.t[1]:.9g}"
    for q in samples.q[1:].tolist():
        lines.append(f"  servoj({_joints(q)}, t={period}, lookahead_time={LOOKAHEAD}, gain={GAIN})")
    return "\n".join([*lines, "  stopj(2.0)", "end", "mafsil_motion()", ""]).encode()


def _joints(q: list[float]) -> str:
    return "[" + ", ".join(f"{value:.10g}" for value in q) + "]"


Format: TypeAlias = Literal["csv", "ros2_yaml", "ros2_json", "urscript"]
FORMATS: dict[Format, tuple[tuple[str, ...], Callable[[Samples], bytes]]] = {
    "csv": ((".csv",), as_csv),
    "ros2_yaml": ((".yaml", ".yml"), as_yaml),
    "ros2_json": ((".json",), as_json),
    "urscript": ((".script", ".urscript"), as_urscript),
}
"""All formats: the endings of files by which they are known, and what writes them."""


class ExportStatus(Status):
    """Whether a trajectory was written."""

    WRITTEN = ("trajectory.written", True)
    LIMITS_EXCEEDED = ("trajectory.not_written", False)


@dataclass(frozen=True, slots=True, repr=False)
class TrajectoryFile(Answer):
    """True if the file was written; false, and nothing written, if the trajectory exceeds a limit.

    Attributes:
        status: whether it was written.
        path: of the file.
        rows: points in it.
        limit_check: what the trajectory was held against, and how it ended.
    """

    status: ExportStatus
    path: Path
    rows: int
    limit_check: LimitCheck

    def explain(self, language: str | None = None) -> str:
        """What was written, or which limits kept it from being written."""
        details = {"path": str(self.path), "rows": self.rows, "count": len(self.limit_check)}
        sentence = self.status.sentence(language, **details)
        if self:
            return sentence + not_checked(self.limit_check.unchecked, language)
        return "\n".join([sentence, self.limit_check.explain(language)])

    def to_dict(self) -> dict[str, Any]:
        """Status, path, number of rows and violations as plain data."""
        data = {"status": self.status.name.lower(), "path": str(self.path), "rows": self.rows}
        return data | {"violations": self.limit_check.to_dict()["violations"]}


def export(
    trajectory: Trajectory,
    path: str | PathLike[str],
    limits: Limits,
    *,
    joints: Sequence[str] = (),
    rate: float = 125.0,
    format: Format | None = None,
    ends: bool = True,
) -> TrajectoryFile:
    """Write a trajectory for a controller, if it keeps the limits.

    Every position, velocity, acceleration and jerk is checked over the whole motion before a byte is written, and jumps
    that no finite limit allows.

    Args:
        trajectory: of n joints, not a batch.
        path: of the file; its ending says the format: .csv, .yaml (ROS 2 JointTrajectory), .json (the same as JSON),
            .script (URScript).
        limits: a robot, or bounds of n coordinates; what has no limits is written with `MotionLimits.of(n)`.
        joints: (n) names; those of the robot if `limits` is one, else joint1, joint2, ...
        rate: points per second [Hz]; URScript's servoj runs at 125 or 500.
        format: if the ending does not say it: `csv`, `ros2_yaml`, `ros2_json` or `urscript`.
        ends: whether jumps from rest at the start and into rest at the end count; False for a part of a longer motion.

    Returns:
        Whether it was written; if not, which limit is exceeded, when and by how much.

    Raises:
        InputError: an unknown format, names that do not fit, a rate that is not positive.
        FileError: the place cannot be written.

    Example: `mf.trajectory.export(motion, "pick.yaml", robot, rate=100)`
    """
    write = FORMATS[_format(Path(path), format)][1]
    names = tuple(joints) or (limits.joint_names if isinstance(limits, Robot) else ())
    samples = sample_trajectory(trajectory, names, rate)
    verdict = check(trajectory, limits, samples.joints, ends=ends)
    if not verdict:
        return TrajectoryFile(ExportStatus.LIMITS_EXCEEDED, Path(path), 0, verdict)
    write_whole(Path(path), write(samples))
    return TrajectoryFile(ExportStatus.WRITTEN, Path(path), len(samples.t), verdict)


def _format(path: Path, format: Format | None) -> Format:
    if format is None:
        for name, (endings, _) in FORMATS.items():
            if path.suffix.lower() in endings:
                return name
        known = ", ".join(ending for endings, _ in FORMATS.values() for ending in endings)
        raise InputError("input.choice", name="path", value=path.suffix, known=known)
    if format not in FORMATS:
        raise InputError("input.choice", name="format", value=format, known=", ".join(FORMATS))
    return format
