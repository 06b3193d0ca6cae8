"""Pictures of a synthesis: what was asked for, a linkage in its positions, its coupler curve, Burmester's curves."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np

from mafsil.arrays import Floats, whole
from mafsil.errors import InputError
from mafsil.figures.space import picture_file
from mafsil.messages import in_line, say
from mafsil.messages.visible import visible
from mafsil.mobility import FourBar
from mafsil.mobility.synthesis import Candidate, ChainCandidate, ChainSynthesis, SixBar, SphericalFourBar, Synthesis
from mafsil.mobility.synthesis.dyads import as_points

_INK, _GROUND, _GHOST = "#39424a", "#8a949c", "#c9d0d6"
_CRANK, _COUPLER, _ROCKER = "#2e8b57", "#2f6fd0", "#8c6bb1"
_CURVE, _CENTRE, _CIRCLE, _TASK = "#7f9fc9", "#d9902a", "#4f9d8f", "#d33f3a"
MARGIN = 0.25
"""Free border about pivots and poses, over their extent; curves that run to infinity are cut there."""


def plot_synthesis(found: Synthesis | ChainSynthesis, path: str | PathLike[str], *, index: int = 0) -> None:
    """Draw a candidate of a synthesis into a file.

    Args:
        found: the answer of a synthesis: four-bars, six-bars, spherical four-bars.
        path: .png, .svg or .pdf.
        index: of the candidate; without candidates the task is drawn alone.

    Raises:
        InputError: there is no candidate of that index.
        FileError: the ending names no format.
    """
    file = picture_file(path)
    if len(found) and whole("index", index) >= len(found):
        raise InputError("input.whole", name="index", value=index, low=0, high=len(found) - 1)
    import matplotlib

    with matplotlib.rc_context({"svg.hashsalt": "mafsil", "font.size": 9, "text.color": _INK}):
        figure = draw_synthesis(found, index)
        undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(file.suffix.lower(), {})
        figure.savefig(file, dpi=150, bbox_inches="tight", pad_inches=0.08, metadata=undated)


def draw_synthesis(found: Synthesis | ChainSynthesis, index: int = 0) -> Any:
    """The picture as a matplotlib figure.

    Args:
        found: the answer.
        index: of the candidate.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 6.0))
    FigureCanvasAgg(figure)
    axes: Any = figure.add_axes((0.02, 0.02, 0.96, 0.86))
    if isinstance(found, ChainSynthesis):
        _draw_chain(axes, found, index)
    else:
        _draw_four_bar(axes, found, index)
    axes.set_aspect("equal")
    axes.axis("off")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="lower right", fontsize=8, frameon=False)
    figure.suptitle(in_line(visible(found.explain().split("\n")[0])), fontsize=10, wrap=True)
    return figure


def _draw_four_bar(axes: Any, found: Synthesis, index: int) -> None:
    """The task, Burmester's curves, a candidate and its coupler curve."""
    one = found[index] if len(found) else None
    view = _view(found, one)
    if found.curves is not None:
        for points, colour, key in (
            (found.curves.centre_points, _CENTRE, "centre_points"),
            (found.curves.circle_points, _CIRCLE, "circle_points"),
        ):
            axes.plot(*_inside(points.reshape(-1, 2), view).T, ".", color=colour, markersize=2, label=_label(key))
    if one is not None:
        _linkage(axes, one)
        if found.aim != "function":
            for k, curve in enumerate(one.coupler_curves(1441)):
                name = {"label": _label("coupler_curve")} if not k else {}
                axes.plot(*_inside(curve, view).T, color=_CURVE, linewidth=1.0, zorder=1, **name)
    _task(axes, found, 0.06 * float((view[1] - view[0]).max()))
    axes.set(xlim=view[:, 0], ylim=view[:, 1])


def _draw_chain(axes: Any, found: ChainSynthesis, index: int) -> None:
    """A six-bar, or the axes of a spherical four-bar as points of the sphere, in its positions; path and curve."""
    if found.aim == "path":
        for k, place in enumerate(found.task[:, :2]):
            axes.plot(*place, marker="o", markersize=3.5, color=_TASK, zorder=7)
            axes.annotate(str(k + 1), place, (5, 5), textcoords="offset points", color=_TASK, zorder=8)
    if not len(found):
        return
    one = found[index]
    for k in range(len(one.theta) - 1, -1, -1):
        lines = _chain_lines(one, k)
        for line, colour in zip(lines, (_CRANK, _COUPLER, _ROCKER, _COUPLER, _ROCKER), strict=False):
            axes.plot(*line.T, color=_GHOST if k else colour, linewidth=1.0 if k else 2.6, zorder=2 if k else 4)
    linkage = one.linkage
    if isinstance(linkage, SixBar):
        modes: list[int] = one.modes[0].tolist()
        angles = np.linspace(-np.pi, np.pi, 1441)
        stretch = np.abs(linkage.cosines(angles, modes)).max(axis=1, keepdims=True)
        curve = np.where(stretch <= 1.0, linkage.path_points(angles, modes), np.nan)
        axes.plot(*curve.T, color=_CURVE, linewidth=1.0, zorder=1, label=_label("coupler_curve"))
        fixed = linkage.pivots
    else:
        fixed = _project_axes(linkage.pivots, one)
        axes.add_patch(_circle())
    axes.plot(*fixed.T, linestyle="none", marker="^", markersize=12, color=_GROUND, zorder=5)


def _circle() -> Any:
    """The outline of the unit sphere."""
    from matplotlib.patches import Circle

    return Circle((0.0, 0.0), 1.0, fill=False, color=_GHOST, linewidth=1.0)


def _chain_lines(one: ChainCandidate, k: int) -> list[Floats]:
    """Links (m, 2) of a chain in a position: crank, then both links of each dyad, through all points that they hold."""
    linkage, theta, modes = one.linkage, one.theta[k : k + 1], one.modes[k].tolist()
    if isinstance(linkage, SphericalFourBar):
        B, C = (axis[0] for axis in linkage.axes(theta, modes[0]))
        ends = ((linkage.A, B), (B, C), (C, linkage.D))
        share = np.linspace(0.0, 1.0, 40)[:, None]
        arcs = [(1 - share) * start + share * end for start, end in ends]
        return [_project_axes(arc / np.linalg.norm(arc, axis=1, keepdims=True), one) for arc in arcs]
    assert isinstance(linkage, SixBar)
    places, ways, _ = linkage.bodies(theta, modes)
    z, u = places[:, 0], ways[:, 0]
    held: list[list[complex]] = [[z[1], z[1] + linkage.crank * u[1]], *([z[m]] for m in range(2, 6))]
    for number, pair in enumerate(linkage.arms):
        hinge = z[2 + 2 * number] + pair[0].length * u[2 + 2 * number]
        held[1 + 2 * number].append(hinge)
        held[2 + 2 * number].append(hinge)
        for arm in pair:
            if arm.body:
                held[arm.body - 1].append(z[arm.body] + arm.point * u[arm.body])
    if linkage.point is not None:
        held[3].append(z[4] + linkage.point * u[4])
    return [as_points(np.array([*points, points[0]], dtype=np.complex128)) for points in held]


def _project_axes(axes: Floats, one: ChainCandidate) -> Floats:
    """(k, 2) unit vectors seen from the middle of the fixed axes of a spherical four-bar."""
    A, D = one.linkage.pivots
    z = (A + D) / np.linalg.norm(A + D)
    x = (D - A) / np.linalg.norm(D - A)
    return np.stack([axes @ x, axes @ np.cross(z, x)], axis=-1)


def _label(key: str) -> str:
    return visible(say(f"synthesis.{key}"))


def _view(found: Synthesis, one: Candidate | None) -> Floats:
    """(2, 2) lower and upper corner about all that must be seen."""
    points = [np.zeros((1, 2))] if found.aim == "function" else [found.task[:, :2]]
    if one is not None:
        points += [one.A[None], one.D[None], one.B, one.C]
    together = np.concatenate(points)
    low, high = together.min(axis=0), together.max(axis=0)
    border = MARGIN * max(float((high - low).max()), 1e-9)
    return np.stack([low - border, high + border])


def _inside(points: Floats, view: Floats) -> Floats:
    """Points beyond the view as NaN, so that lines end there."""
    with np.errstate(invalid="ignore"):
        seen = ((points >= view[0]) & (points <= view[1])).all(axis=1)
    return np.where(seen[:, None], points, np.nan)


def _linkage(axes: Any, one: Candidate) -> None:
    """The first position in colour, the others as ghosts, and the fixed pivots."""
    for k in range(len(one.theta) - 1, -1, -1):
        colours = (_GHOST,) * 3 if k else (_CRANK, _COUPLER, _ROCKER)
        width, height = (1.0, 2) if k else (2.6, 4)
        traced = one.coupler_poses(one.theta[k], int(one.modes[k]))[:2]
        plate = np.stack([one.B[k], one.C[k], traced])
        if abs(one.along) + abs(one.across) > 0:
            axes.fill(*plate.T, color=colours[1], alpha=0.18 if not k else 0.12, linewidth=0, zorder=height - 1)
        axes.plot(*np.stack([one.A, one.B[k]]).T, color=colours[0], linewidth=width, zorder=height)
        axes.plot(*np.stack([one.B[k], one.C[k]]).T, color=colours[1], linewidth=width, zorder=height)
        if isinstance(one.linkage, FourBar):
            axes.plot(*np.stack([one.C[k], one.D]).T, color=colours[2], linewidth=width, zorder=height)
        else:
            axes.plot(*one.C[k], marker="s", markersize=9, color=colours[2], zorder=height)
    if isinstance(one.linkage, FourBar):
        fixed = np.stack([one.A, one.D])
    else:
        axes.plot(*one.C.T, color=_GROUND, linewidth=1.2, linestyle="--", zorder=1)
        fixed = one.A[None]
    axes.plot(*fixed.T, linestyle="none", marker="^", markersize=12, color=_GROUND, zorder=5)
    moving = np.stack([one.B[0], one.C[0]])
    axes.plot(
        *moving.T, linestyle="none", marker="o", markersize=5, color="white", markeredgecolor=_INK, zorder=6
    )  # fmt: skip


def _task(axes: Any, found: Synthesis, length: float) -> None:
    """Poses as frames, or points, with their numbers."""
    if found.aim == "function":
        return
    for k, row in enumerate(found.task):
        place = row[:2]
        axes.annotate(str(k + 1), place, (5, 5), textcoords="offset points", color=_TASK, zorder=8)
        axes.plot(*place, marker="o", markersize=3.5, color=_TASK, zorder=7)
        if found.aim == "motion":
            for turn, width in ((0.0, 1.8), (np.pi / 2, 1.0)):
                tip = place + length * np.array([np.cos(row[2] + turn), np.sin(row[2] + turn)])
                axes.plot(*np.stack([place, tip]).T, color=_TASK, linewidth=width, zorder=7)
