"""Trajectories as a URScript program: a move to the start, then one servoj for each period of the controller.

Reference: Universal Robots, The URScript Programming Language, servoj and movej.
"""

from __future__ import annotations

from mafsil.errors import InputError
from mafsil.trajectory.files.ros2 import Samples

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
