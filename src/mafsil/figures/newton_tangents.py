"""Newton's method in one dimension: the graph of a function, and the tangents whose zeros are the iterates."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, whole
from mafsil.errors import InputError
from mafsil.figures.performance_sheet import FORCE, INK, SHELL, VELOCITY, flat_axes, save, sheet
from mafsil.figures.picture_file import picture_file
from mafsil.ik import RootRecord, find_root

POINTS = 400
"""Of the graph."""

MARGIN = 0.12
"""Shown on both sides of the iterates, in parts of their range."""


def plot_newton_tangents(
    f: Callable[[Floats], ArrayLike],
    start: float,
    path: str | PathLike[str],
    jacobian: Callable[[Floats], ArrayLike] | None = None,
    *,
    steps: int = 4,
) -> RootRecord:
    """Draw the first steps of Newton's method for f(x) = 0: each goes along the tangent at an iterate to its zero.

    Args:
        f: of x (1,), to (1,).
        start: first iterate.
        path: .png, .svg or .pdf.
        jacobian: of x (1,), to (1, 1); central differences if None.
        steps: most steps that are drawn.

    Returns:
        The iteration that was drawn.

    Raises:
        InputError: no function, f not of one number, a slope of zero or a root at the start, another kind of file.
    """
    path, most = picture_file(path), whole("steps", steps)
    record = find_root(f, [start], jacobian, max_steps=most)
    if not record.iterations:
        raise InputError("pictures.no_tangent", start=f"{start:g}")
    save(_drawn(f, record), path)
    return record


def _drawn(f: Callable[[Floats], ArrayLike], record: RootRecord) -> Any:
    x, y = record.iterates[:, 0], record.values[:, 0]
    margin = MARGIN * float(np.ptp(x)) or 1.0
    first: float = x.min() - margin
    last: float = x.max() + margin
    graph = np.linspace(first, last, POINTS)
    figure = sheet(6.0, 4.2)
    axes: Any = figure.add_subplot()
    axes.axhline(0.0, color=INK, linewidth=0.8)
    axes.plot(graph, [float(np.ravel(f(np.array([one])))[0]) for one in graph], color=VELOCITY, linewidth=1.8)
    for k in range(record.iterations):
        axes.plot([x[k], x[k]], [0.0, y[k]], color=SHELL, linewidth=1.0, linestyle="--")
        axes.plot([x[k], x[k + 1]], [y[k], 0.0], color=FORCE, linewidth=1.3)
        axes.plot(x[k], y[k], "o", color=FORCE, markersize=4)
    shown = np.abs(np.subtract.outer(x, x)) + np.triu(np.full((len(x), len(x)), np.inf))
    for k in np.flatnonzero(shown.min(axis=1) > 0.04 * np.ptp(x)):
        axes.annotate(f"$x_{{{k}}}$", (x[k], 0.0), (0, -14), textcoords="offset points", ha="center", color=INK)
    flat_axes(axes, "$x$", "$f(x)$", equal=False)
    return figure
