"""A trajectory as rows on an even grid of time, as files hold it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, positive
from mafsil.errors import InputError
from mafsil.trajectory.motion import Trajectory
from mafsil.trajectory.tolerances import ROUNDING

MOST_ROWS = 10_000_000
"""Rows of a file: a longer motion at this rate is refused before memory is asked for."""


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
