"""Trajectories as the ROS 2 message trajectory_msgs/msg/JointTrajectory, in YAML or JSON.

Reference: the message definitions of common_interfaces (trajectory_msgs, std_msgs, builtin_interfaces).
"""

from __future__ import annotations

import json
from typing import Any

from mafsil.trajectory.files.sampling import Samples

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
