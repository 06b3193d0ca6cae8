"""Many runs as a picture: how often the tip strays how far, and what goes with it."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np

from mafsil.arrays import require_kind
from mafsil.figures.motion_over_time import COLOURS
from mafsil.figures.performance_sheet import SINGULAR, flat_axes, save, sheet
from mafsil.figures.space import picture_file
from mafsil.messages import say
from mafsil.simulation import MonteCarlo
from mafsil.simulation.variation import drawn_name


def plot_monte_carlo(result: MonteCarlo, path: str | PathLike[str], *, language: str | None = None) -> None:
    """Draw the distribution of the largest tip error, and that error over the variable that it correlates with most.

    Args:
        result: of `mafsil.simulation.monte_carlo`.
        path: .png, .svg or .pdf.
        language: of the labels; the current one if None.

    Raises:
        InputError: no such result, or an ending of no picture.
    """
    file = picture_file(path)
    require_kind("result", result, "MonteCarlo", "outcomes", "variants")
    figure = sheet(8.0, 3.4)
    left, right = figure.subplots(1, 2)
    error = say("simulation.tip_error_of", language=language)
    _shares(left, result, error, say("simulation.runs_not_worse", language=language))
    _strongest(right, result, error, language)
    save(figure, file)


def _shares(axes: Any, result: MonteCarlo, error: str, share: str) -> None:
    """The share of runs that do not exceed an error; runs without end never come to it."""
    errors = np.sort(1e3 * result.outcomes.tip_error[result.outcomes.finished])
    axes.step(errors, 100.0 * np.arange(1, len(errors) + 1) / len(result), where="post", color=COLOURS[0])
    if result.bound is not None:
        axes.axvline(1e3 * result.bound, color=SINGULAR, linewidth=0.9, linestyle="--")
    axes.set_ylim(0.0, 102.0)
    flat_axes(axes, error, share, equal=False)


def _strongest(axes: Any, result: MonteCarlo, error: str, language: str | None) -> None:
    name = next(iter(result.influence), None)
    ended = result.outcomes.finished
    if name is not None:
        column = result.variants.columns()[name]
        axes.plot(column[ended], 1e3 * result.outcomes.tip_error[ended], ".", markersize=2.5, color=COLOURS[1])
    flat_axes(axes, "" if name is None else drawn_name(name, language, unit=True), error, equal=False)
