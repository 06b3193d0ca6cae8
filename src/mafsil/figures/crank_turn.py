"""A linkage over one turn of its crank: the linkage with its coupler curve, and what happens over the crank's angle."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np

from mafsil.arrays import require_kind
from mafsil.figures.linkage import is_flat, skeleton
from mafsil.figures.performance_sheet import FORCE, SINGULAR, VELOCITY, flat_axes, save, sheet
from mafsil.figures.space import picture_file
from mafsil.messages import say
from mafsil.mobility import mobility
from mafsil.mobility.linkages import CrankTurn

COLOURS = (VELOCITY, FORCE, "#4a9c5d", "#8a5fb0", "#b08a2e", "#3aa0a8")
WORST = 40.0
"""Transmission angle below which textbooks ask for another linkage [deg]."""


def plot_crank_turn(turn: CrankTurn, path: str | PathLike[str], *, language: str | None = None) -> None:
    """Draw the linkage with the curve of its output, to scale, and beside it curves over the crank.

    Speed and acceleration of the middle of the output, transmission angles, motor effort and largest joint force.

    Args:
        turn: as `turn_crank` gives it.
        path: .png, .svg or .pdf.
        language: of the labels; the current one if None.

    Raises:
        InputError: no turn, or an ending of no picture.
    """
    file = picture_file(path)
    require_kind("turn", turn, "CrankTurn", "transmission", "loads", "columns")
    heads, rows = turn.columns()
    figure = sheet(9.6, 6.4)
    grid = figure.add_gridspec(4, 2, width_ratios=(1.2, 1.0))
    flat = is_flat(turn.linkage)
    left: Any = figure.add_subplot(grid[:, 0], projection=None if flat else "3d")
    skeleton(left, turn.linkage, turn.theta[0], mobility(turn.linkage))
    places = turn.point(turn.linkage.output, turn.output_point())[0]
    left.plot(*places[:, : 2 if flat else 3].T, color=SINGULAR, linewidth=0.9, zorder=1)
    left.set_aspect("equal")
    left.set_xlabel("x [m]")
    left.set_ylabel("y [m]")
    followers = len(turn.followers)
    panels = ((3, 4), tuple(range(5, 5 + followers)), (5 + followers,), (6 + followers,))
    for k, columns in enumerate(panels):
        axes: Any = figure.add_subplot(grid[k, 1])
        for colour, column in zip(COLOURS, columns, strict=False):
            for arc in range(int(turn.arc.max()) + 1):
                on = turn.arc == arc
                name = heads[column] if arc == 0 else None
                axes.plot(rows[on, 0], rows[on, column], color=colour, linewidth=1.2, label=name)
        if k == 1:
            axes.axhline(WORST, color=SINGULAR, linewidth=0.8, linestyle="--")
        if columns:
            axes.legend(loc="upper right", frameon=False, fontsize=7)
        _show_scale(axes, rows[:, list(columns)])
        flat_axes(axes, heads[0] if k == 3 else "", "", equal=False)
    figure.suptitle(say(turn.status.key, language=language, **turn.details()), fontsize=9)
    save(figure, file)


def _show_scale(axes: Any, values: np.ndarray[Any, np.dtype[np.float64]]) -> None:
    """Limits that leave out what grows without bound towards a dead point."""
    known = values[np.isfinite(values)]
    if known.size:
        low, high = np.percentile(known, [1.0, 99.0])
        margin = 0.1 * (high - low) or 1.0
        axes.set_ylim(max(low - margin, float(known.min()) - margin), min(high + margin, float(known.max()) + margin))
