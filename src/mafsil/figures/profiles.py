"""Profiles side by side: position, velocity, acceleration and jerk of one coordinate, a line for each profile."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np

from mafsil.arrays import require_kind, whole
from mafsil.figures.motion_over_time import COLOURS, ROWS, sample_times
from mafsil.figures.performance_sheet import SINGULAR, flat_axes, save, sheet
from mafsil.figures.picture_file import picture_file
from mafsil.messages import say
from mafsil.trajectory.motion import derivative
from mafsil.trajectory.profiles import ProfileComparison

STYLES = ("-", "--", ":")
"""Of lines, when there are more profiles than colours."""


def plot_profiles(
    comparison: ProfileComparison,
    path: str | PathLike[str],
    *,
    coordinate: int | None = None,
    language: str | None = None,
) -> None:
    """Draw u, v, a and jerk over time, one line for each profile; the coordinate's limits are dashed.

    Args:
        comparison: of `mafsil.trajectory.compare_profiles`.
        path: .png, .svg or .pdf.
        coordinate: index; the one that goes farthest if None.
        language: of the labels; the current one if None.

    Raises:
        InputError: no comparison, an index out of range, or an ending of no picture.
    """
    file = picture_file(path)
    require_kind("comparison", comparison, "ProfileComparison", "runs", "limits")
    shortest = comparison.runs[0].trajectory
    way = np.abs(np.ptp(shortest.at(np.linspace(0.0, shortest.duration, 101)).u, axis=0))
    k = int(way.argmax()) if coordinate is None else whole("coordinate", coordinate, 0, shortest.n - 1)
    figure = sheet(6.4, 7.6)
    panels: Any = figure.subplots(4, 1, sharex=True)
    for order, (axes, (word, quantity)) in enumerate(zip(panels, ROWS, strict=True)):
        for index, run in enumerate(comparison):
            t = sample_times(run.trajectory)
            style = STYLES[index // len(COLOURS) % len(STYLES)]
            values = derivative(run.trajectory, t, order)[:, k]
            axes.plot(t, values, color=COLOURS[index % len(COLOURS)], linewidth=1.2, linestyle=style, label=run.name)
        bounds = getattr(comparison.limits, quantity)[:, k]
        for side in bounds if order and np.isfinite(bounds).all() else ():
            axes.axhline(float(side), color=SINGULAR, linewidth=0.9, linestyle="--")
        flat_axes(axes, "t [s]" if order == 3 else "", say(f"trajectory.{word}", language=language), equal=False)
    panels[0].legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False, fontsize=7, ncols=6)
    save(figure, file)
