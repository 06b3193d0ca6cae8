"""A trajectory over time: position, velocity, acceleration and jerk of each coordinate, with their limits."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np

from mafsil.arrays import Floats, require_kind
from mafsil.errors import InputError
from mafsil.figures.performance_sheet import FORCE, INK, SHELL, SINGULAR, VELOCITY, flat_axes, save, sheet
from mafsil.figures.picture_file import picture_file
from mafsil.messages import say
from mafsil.trajectory import Trajectory
from mafsil.trajectory.motion import derivative
from mafsil.trajectory.motion_limits import Limits, motion_limits

COLOURS = (VELOCITY, FORCE, "#4a9c5d", "#8a5fb0", "#b08a2e", "#3aa0a8", INK)
ROWS = (("upper", "position"), ("velocity", "velocity"), ("acceleration", "acceleration"), ("jerk", "jerk"))
"""Name in the catalogue of sentences, and in limits, of derivatives 0 to 3."""
SAMPLES = 600


def plot_trajectory(
    trajectory: Trajectory,
    path: str | PathLike[str],
    *,
    limits: Limits | None = None,
    names: tuple[str, ...] = (),
    language: str | None = None,
) -> None:
    """Draw u, v, a and jerk over time, one line for each coordinate; jumps stay jumps, limits are dashed.

    Args:
        trajectory: of n coordinates, without batch dimensions.
        path: .png, .svg or .pdf.
        limits: of the coordinates; drawn where all of them have the same.
        names: (n,) of the coordinates; their indices if empty.
        language: of the labels; the current one if None.

    Raises:
        InputError: no trajectory, a batch, or an ending of no picture.
    """
    file = picture_file(path)
    require_kind("trajectory", trajectory, "Trajectory", "duration", "at", "jerk", "breaks")
    if trajectory.at(0.0).u.ndim != 1:
        got = trajectory.at(0.0).u.shape
        raise InputError("input.shape", name="trajectory", expected="one motion (n,)", got=got, hint="")
    labels = names or tuple(str(k) for k in range(trajectory.n))
    bounds = None if limits is None else motion_limits(limits, trajectory.n)
    figure = sheet(6.4, 7.2)
    panels: Any = figure.subplots(4, 1, sharex=True)
    t = sample_times(trajectory)
    for order, (axes, (word, quantity)) in enumerate(zip(panels, ROWS, strict=True)):
        values = derivative(trajectory, t, order)
        for k, label in enumerate(labels):
            axes.plot(t, values[:, k], color=COLOURS[k % len(COLOURS)], linewidth=1.3, label=label)
        for side in () if bounds is None else getattr(bounds, quantity):
            if np.isfinite(side).all() and np.ptp(side) == 0.0:
                axes.axhline(float(side[0]), color=SINGULAR, linewidth=0.9, linestyle="--")
        for moment in trajectory.breaks()[1:-1] if len(trajectory.breaks()) <= 40 else ():
            axes.axvline(float(moment), color=SHELL, linewidth=0.4, zorder=0)
        last = "t [s]" if order == 3 else ""
        flat_axes(axes, last, say(f"trajectory.{word}", language=language), equal=False)
    panels[0].legend(loc="upper right", frameon=False, fontsize=8, ncols=min(len(labels), 7))
    save(figure, file)


def sample_times(trajectory: Trajectory) -> Floats:
    """Even times, and both sides of every break, where derivatives jump.

    Args:
        trajectory: any.
    """
    breaks = trajectory.breaks()
    even = np.linspace(0.0, trajectory.duration, SAMPLES)
    return np.unique(np.concatenate([even, breaks, np.nextafter(breaks[1:], 0.0)]))
