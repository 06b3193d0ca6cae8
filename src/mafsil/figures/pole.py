"""A planar displacement and its pole: a body before and after, and the point about which one turn carries it over."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.figures import space
from mafsil.figures.space import picture_file
from mafsil.geometry import membership, planar
from mafsil.messages import say

_BODY = np.array([[-0.35, -0.25], [0.9, -0.25], [0.9, 0.05], [0.05, 0.05], [0.05, 0.5], [-0.35, 0.5], [-0.35, -0.25]])
"""An L, so that its turn is seen; the frame sits in its corner."""


def plot_pole(T: ArrayLike, path: str | PathLike[str], start: ArrayLike | None = None) -> None:
    """Draw a planar displacement and its pole into a file.

    Args:
        T: (3, 3) displacement in the coordinates of {s}.
        path: .png, .svg or .pdf.
        start: (3, 3) pose T_sb of the body before; {s} itself if None.
    """
    path = picture_file(path)
    displacement = membership.require("planar_pose", "T", T)
    begin = np.eye(3) if start is None else membership.require("planar_pose", "start", start)
    space.save(lambda: draw_pole(displacement, begin), path)


def draw_pole(T: Floats, start: Floats) -> Any:
    """A matplotlib figure of a displacement and its pole; arguments as for `plot_pole`."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.0, 5.4))
    FigureCanvasAgg(figure)
    axes: Any = figure.add_axes((0.02, 0.02, 0.96, 0.88))
    end = planar.compose(T, start)
    (psi, *_), (point, exists) = planar.log(T), planar.finite_pole(T)
    before, after = (pose[:2, 2] for pose in (start, end))
    size = max(float(np.linalg.norm(after - before)), 1e-3)
    size = size if size > 1e-2 else 1.0
    names = ("s", "b") if np.array_equal(start, np.eye(3)) else ("b", "c")
    for pose, name, colour in ((start, names[0], space.SOFT), (end, names[1], space.ACCENT)):
        _body(axes, pose, 0.35 * size, name, colour)
    if exists:
        _turn(axes, np.asarray(point), np.array([before, after]), float(psi))
    else:
        _arrow(axes, before, after, space.SECOND)
    space.title(figure, _heading(float(psi), np.asarray(point), bool(exists)))
    axes.set_aspect("equal")
    axes.margins(0.12)
    axes.set_axis_off()
    return figure


def _body(axes: Any, T: Floats, scale: float, name: str, colour: str) -> None:
    outline = scale * _BODY @ T[:2, :2].T + T[:2, 2]
    axes.fill(*outline.T, color=colour, alpha=0.16, linewidth=0)
    axes.plot(*outline.T, color=colour, linewidth=1.6)
    origin = T[:2, 2]
    for k, letter in enumerate("xy"):
        tip = origin + 0.85 * scale * T[:2, k]
        _arrow(axes, origin, tip, space.AXES[k])
        axes.text(*(origin + scale * T[:2, k]), f"${letter}_{name}$", color=space.AXES[k], ha="center", va="center")
    axes.text(*(origin - 0.16 * scale * T[:2, :2].sum(axis=1)), "{" + name + "}", ha="center", va="center")


def _arrow(axes: Any, start: Floats, end: Floats, colour: str) -> None:
    style = {"arrowstyle": "-|>", "color": colour, "lw": 1.8, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, start, arrowprops=style, annotation_clip=False)
    axes.update_datalim([end])  # matplotlib leaves arrows out when it looks for limits


def _turn(axes: Any, pole: Floats, origins: Floats, psi: float) -> None:
    """Both arms from the pole, the arc of the origin, and the angle."""
    arm = origins[0] - pole
    angles = np.linspace(0.0, psi, 80)
    arc = pole + np.array([planar.rotation(a) @ arm for a in angles])
    axes.plot(*arc.T, color=space.SECOND, linewidth=1.6)
    for origin in origins:
        axes.plot(*np.array([pole, origin]).T, color=space.SOFT, linewidth=1.0, linestyle="--")
    small = pole + 0.28 * np.array([planar.rotation(a) @ arm for a in angles])
    axes.plot(*small.T, color=space.INK, linewidth=1.2)
    axes.text(*(pole + 0.36 * planar.rotation(psi / 2) @ arm), r"$\psi$", ha="center", va="center")
    axes.plot(*pole, marker="o", color=space.SECOND, markersize=7)
    axes.annotate("$P$", pole, (-12, -12), textcoords="offset points", color=space.SECOND, ha="center", va="center")


def _heading(psi: float, pole: Floats, exists: bool) -> str:
    if not exists:
        return say("pictures.pole_at_infinity")
    x, y = (0.0 if abs(v) < 1e-12 else v for v in pole)
    return say("pictures.pole", angle=f"{np.degrees(psi):.4g}", x=f"{x:.4g}", y=f"{y:.4g}")
