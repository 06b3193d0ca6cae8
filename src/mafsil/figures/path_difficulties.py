"""A diagnosed path: the joints over the path, with the stretches that cannot be passed and why."""

from __future__ import annotations

from os import PathLike
from textwrap import fill
from typing import Any

import numpy as np

from mafsil.arrays import require_kind
from mafsil.figures.motion_over_time import COLOURS
from mafsil.figures.performance_sheet import SINGULAR, flat_axes, save, sheet
from mafsil.figures.picture_file import picture_file
from mafsil.messages import say
from mafsil.trajectory.difficulties import PathDiagnosis

NARROWEST = 0.004
"""Share of the path that a stretch is drawn wide at least."""


def plot_path_difficulties(diagnosis: PathDiagnosis, path: str | PathLike[str], *, language: str | None = None) -> None:
    """Draw the joints of the best chain of solutions over s, and their rates; difficulties are shaded and numbered.

    Args:
        diagnosis: of `mafsil.trajectory.diagnose_path`.
        path: .png, .svg or .pdf.
        language: of the texts; the current one if None.

    Raises:
        InputError: no diagnosis, or an ending of no picture.
    """
    file = picture_file(path)
    require_kind("diagnosis", diagnosis, "PathDiagnosis", "difficulties", "rates")
    figure = sheet(6.4, 5.2)
    panels: Any = figure.subplots(2, 1, sharex=True)
    rows = ((diagnosis.q, say("trajectory.upper", language=language)), (np.abs(diagnosis.rates), "|dq/ds|"))
    names = diagnosis.robot.joint_names
    for axes, (values, label) in zip(panels, rows, strict=True):
        for k, name in enumerate(names):
            axes.plot(
                diagnosis.s, values[:, k], color=COLOURS[k % len(COLOURS)], linewidth=1.2, marker=".", markersize=2.5,
                label=name,
            )  # fmt: skip
        for number, each in enumerate(diagnosis, start=1):
            begin, end = each.where.begin, max(each.where.end, each.where.begin + NARROWEST)
            axes.axvspan(begin, end, color=SINGULAR, alpha=0.15, linewidth=0)
            axes.annotate(
                str(number),
                ((begin + end) / 2, 1.0),
                xycoords=("data", "axes fraction"),
                ha="center",
                va="bottom",
                fontsize=8,
                color=SINGULAR,
            )
        flat_axes(axes, "s" if axes is panels[-1] else "", label, equal=False)
    panels[1].set_yscale("symlog", linthresh=1.0)
    panels[0].legend(frameon=False, fontsize=7, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    said = [f"{number}. {each.explain(language)}" for number, each in enumerate(diagnosis, start=1)]
    if said:
        figure.supxlabel("\n".join(fill(line, 95) for line in said), fontsize=7, x=0.02, ha="left")
    save(figure, file)
