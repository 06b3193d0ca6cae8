"""The phase plane of a timed path: path velocity over the path, the limit curve above it, which limit decides where."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np

from mafsil.arrays import require_kind
from mafsil.figures.motion_over_time import COLOURS
from mafsil.figures.performance_sheet import SINGULAR, flat_axes, save, sheet
from mafsil.figures.picture_file import picture_file
from mafsil.messages import say
from mafsil.trajectory.timing import TimeOptimal

PLACES = 2000
"""Of the curve."""


def plot_phase_plane(timed: TimeOptimal, path: str | PathLike[str], *, language: str | None = None) -> None:
    """Draw ds/dt over s, coloured by the limit that decides, below the largest ds/dt from which the end can be reached.

    Args:
        timed: of `mafsil.trajectory.time_optimal`.
        path: .png, .svg or .pdf.
        language: of the labels; the current one if None.

    Raises:
        InputError: no timed path, or an ending of no picture.

    Reference: J. Bobrow, S. Dubowsky, J. Gibson, Int. J. Robotics Research 4(3), 1985.
    """
    file = picture_file(path)
    require_kind("timed", timed, "TimeOptimal", "limit_curve", "bindings")
    figure = sheet(6.4, 3.6)
    axes: Any = figure.subplots()
    limit = timed.limit_curve
    axes.plot(
        limit[:, 0], limit[:, 1], color=SINGULAR, linewidth=0.9, linestyle="--", label=_word("limit_curve", language)
    )
    deciding = list(dict.fromkeys((one.quantity, one.joint) for one in timed.bindings))
    motion = timed.trajectory
    for binding in timed.bindings if motion is not None else ():
        assert motion is not None
        t = np.linspace(
            binding.begin, binding.end, max(int(PLACES * (binding.end - binding.begin) / timed.duration), 2)
        )
        s, rate, _ = motion.law.at(t)
        key = (binding.quantity, binding.joint)
        colour = COLOURS[deciding.index(key) % len(COLOURS)]
        axes.plot(s[:, 0], rate[:, 0], color=colour, linewidth=1.8, label=_name(key, language))
    handles, labels = axes.get_legend_handles_labels()
    once = dict(zip(labels, handles, strict=True))
    axes.legend(once.values(), once.keys(), frameon=False, fontsize=7, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    axes.set_ylim(bottom=0.0)
    flat_axes(axes, "s", "ds/dt [1/s]", equal=False)
    save(figure, file)


def _word(name: str, language: str | None) -> str:
    return say(f"trajectory.{name}", language=language)


def _name(key: tuple[str, int], language: str | None) -> str:
    quantity, joint = key
    return _word(quantity, language) if joint < 0 else f"{_word(quantity, language)} {joint}"
