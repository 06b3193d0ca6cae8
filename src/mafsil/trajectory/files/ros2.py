"""Trajectories as the ROS 2 message trajectory_msgs/msg/JointTrajectory, in YAML or JSON.

Reference: the message definitions of common_interfaces (trajectory_msgs, std_msgs, builtin_interfaces).

A trajectory as rows on an even grid of time, as files hold it.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mafsil.arrays import Floats, positive
from mafsil.errors import InputError
from mafsil.trajectory.motion import Trajectory
from mafsil.trajectory.tolerances import ROUNDING

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
