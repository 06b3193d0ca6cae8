"""Artificial potentials of two coordinates as pictures: lines of equal potential, local minima marked, a path."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, require_kind, single, whole
from mafsil.errors import InputError
from mafsil.figures.performance_sheet import INK, SINGULAR, flat_axes, save, sheet
from mafsil.figures.picture_file import picture_file
from mafsil.messages import say
from mafsil.planning import PotentialField


def plot_potential(
    field: PotentialField,
    path: str | PathLike[str],
    lower: ArrayLike,
    upper: ArrayLike,
    *,
    way: ArrayLike | None = None,
    cells: int = 120,
    starts: int = 40,
    language: str | None = None,
) -> None:
    """Draw a field of two coordinates: a ring at the goal, crosses at local minima, grey where no distance is left.

    Args:
        field: of a point in the plane, or of an arm of two joints.
        path: .png, .svg or .pdf.
        lower, upper: (2,) what is drawn [m | rad].
        way: (k, 2) a path that is drawn, if given.
        cells: of the grid, in each direction.
        starts: descents by which local minima are searched.
        language: of the labels; the current one if None.

    Raises:
        InputError: an ending of no picture, a field of more than two coordinates, a wrong shape.
    """
    file = picture_file(path)
    require_kind("field", field, "PotentialField", "potential", "minima", "goal")
    if field.goal.shape != (2,):
        raise InputError("input.shape", name="field.goal", expected=(2,), got=field.goal.shape, hint="")
    low, high = single("lower", lower, (2,)), single("upper", upper, (2,))
    count = whole("cells", cells, least=2)
    shares: Floats = np.arange(count) / (count - 1.0)
    x, y = (low[k] + shares * (high[k] - low[k]) for k in range(2))
    grid = np.stack([np.tile(x, (count, 1)), np.tile(y[:, None], (1, count))], axis=-1)
    U = field.potential(grid.reshape(-1, 2)).reshape(grid.shape[:2])
    finite = np.isfinite(U)
    figure = sheet(6.4, 5.4)
    plot: Any = figure.add_subplot(1, 1, 1)
    plot.contourf(x, y, np.where(finite, 0.0, 1.0), levels=[0.5, 1.5], colors=["#bbbbbb"])
    if finite.any():
        levels = np.unique(np.quantile(U[finite], np.linspace(0.0, 0.97, 24)))
        plot.contour(x, y, np.where(finite, U, np.nan), levels=levels, cmap="viridis", linewidths=0.8)
    minima = field.minima(low, high, starts=starts)
    label = say("planning.label_minimum", language=language)
    plot.plot(*minima.T, "x", color=SINGULAR, markersize=9, markeredgewidth=2.0, label=label)
    goal = say("planning.label_goal", language=language)
    plot.plot(*field.goal, "o", color=INK, markersize=9, markerfacecolor="none", markeredgewidth=2.0, label=goal)
    if way is not None:
        plot.plot(*as_batch("way", way, (2,), finite=True).T, color=INK, linewidth=1.4)
    flat_axes(plot, "x", "y")
    figure.legend(loc="outside upper center", ncols=2, fontsize=8, frameon=False)
    save(figure, file)
