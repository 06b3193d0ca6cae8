"""Proposed grasps on their body: the best ones in small pictures, one view for all."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np

from mafsil.figures.grasp import draw_body, draw_contacts, frame_space
from mafsil.figures.picture_file import picture_file
from mafsil.grasp import GraspPlan
from mafsil.messages import say
from mafsil.messages.visible import visible

SHOWN = 6


def save_plan(plan: GraspPlan, path: str | PathLike[str]) -> None:
    """Draw the best proposals into a file.

    Args:
        plan: with at least one grasp.
        path: .png, .svg or .pdf.
    """
    path = picture_file(path)
    import matplotlib

    with matplotlib.rc_context({"svg.hashsalt": "mafsil", "font.size": 8}):
        figure = draw_plan(plan)
        undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(path.suffix.lower(), {})
        figure.savefig(path, dpi=130, metadata=undated)


def draw_plan(plan: GraspPlan) -> Any:
    """A matplotlib figure with the best proposals.

    Args:
        plan: with at least one grasp.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    shown = plan.grasps[:SHOWN]
    columns = min(3, len(shown))
    rows = -(-len(shown) // columns)
    figure = Figure(figsize=(3.4 * columns, 3.4 * rows + 0.3))
    FigureCanvasAgg(figure)
    for k, proposal in enumerate(shown):
        axes: Any = figure.add_subplot(rows, columns, k + 1, projection="3d")
        draw_body(axes, plan.body)
        draw_contacts(axes, proposal.grasp, labels=False, scale=0.2 * plan.body.size)
        frame_space(axes, np.asarray(plan.body.corners).reshape(-1, 3))
        axes.set_axis_off()
        axes.set_title(visible(f"{k + 1}: {say('grasp.epsilon_head')} {proposal.epsilon:.3g}"))
    figure.tight_layout()
    return figure
