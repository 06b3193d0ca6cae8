"""`mafsil dynamics --duration`: what constant efforts make of a state over time."""

from __future__ import annotations

from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from mafsil.arrays import Floats, JointVector, positive
from mafsil.cli.answer import Answer
from mafsil.cli.numerals import number
from mafsil.cli.state import with_units
from mafsil.cli.table import number as shown
from mafsil.cli.table import table
from mafsil.csv_table import csv_text, joint_columns
from mafsil.messages import say
from mafsil.robot import Robot
from mafsil.simulation import ForwardMotion, forward_dynamics_trajectory
from mafsil.whole_file import write_whole

PER_SECOND = 100
"""Rows of the file per second."""
PATIENCE = 60.0
"""Seconds after which the motion ends where it is."""


def motion(
    arm: Robot, q: JointVector, qd: JointVector, tau: JointVector, duration: str, out: str | None, *, friction: bool
) -> Answer:
    """The motion from a state under constant efforts; a table of its end, and a file of all of it.

    Args:
        arm: the robot.
        q, qd, tau: (n,) initial state and efforts.
        duration: as typed [s].
        out: CSV file with t, q[JOINT], qd[JOINT], qdd[JOINT], tau[JOINT].
        friction: whether the joints' friction acts.

    Raises:
        MafsilError: no duration, or a file that cannot be written.
    """
    end = positive("--duration", number("--duration", duration))
    moved = forward_dynamics_trajectory(arm, q, qd, tau, duration=end, friction=friction, seconds=PATIENCE)
    if out is not None:
        _write(moved, tau, Path(out))
    first, last = float(moved.energy[0]), float(moved.energy[-1])
    data: dict[str, Any] = {
        "robot": arm.name,
        "question": "motion",
        "joints": list(arm.joint_names),
        "status": moved.outcome.status.name.lower(),
        "t": moved.duration,
        "q": moved.q[-1],
        "qd": moved.qd[-1],
        "qdd": moved.qdd[-1],
        "tau": tau,
        "steps": len(moved.t) - 1,
        "energy": {"start": first, "end": last},
        "out": out,
    }
    ends = zip(arm.joint_names, moved.q[-1], moved.qd[-1], moved.qdd[-1], strict=True)
    rows = [(name, *map(shown, values)) for name, *values in ends]
    lines = [say("cli.motion_title", robot=arm.name, time=shown(moved.duration))]
    lines += [moved.explain()] if moved.succeeded else []
    lines += table((say("cli.joint"), *with_units(arm.mechanism, ("q", "qd", "qdd"))), rows)
    lines.append(say("cli.motion_energy", first=shown(first), last=shown(last)))
    lines += [say("cli.motion_written", path=out)] if out is not None else []
    return Answer(data, tuple(lines), None if moved.succeeded else moved.explain())


def _write(moved: ForwardMotion, tau: JointVector, path: Path) -> None:
    """The motion on an even grid, in columns that `mafsil identify` reads."""
    t: Floats = np.linspace(0.0, moved.duration, 1 + max(1, ceil(moved.duration * PER_SECOND)))
    state = moved.at(t)
    columns = {"q": state.u, "qd": state.v, "qdd": state.a, "tau": np.broadcast_to(tau, state.u.shape)}
    table = {"t": t, **joint_columns(tuple(columns), tuple(columns.values()), moved.robot.joint_names)}
    write_whole(path, lambda file: file.writelines(csv_text(table)))
