"""Pictures of wrench sets in the plane: columns, the cone that they span, their hull, and where the origin lies."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch
from mafsil.errors import InputError
from mafsil.grasp import Contact, ContactForces
from mafsil.grasp.hull import convex_hull

_INK, _SET, _CONE, _YES, _NO = "#39424a", "#1d4488", "#2f6fd0", "#2e8b57", "#d33f3a"


def save_hull(columns: ArrayLike, path: Path) -> None:
    """Draw columns in the plane with their cone and their hull; the origin is green where it lies strictly inside.

    Args:
        columns: (2, n).
        path: .png, .svg or .pdf.
    """
    draw_hull(columns).savefig(path, dpi=150)


def draw_hull(columns: ArrayLike) -> Any:
    """The picture as a matplotlib figure.

    Args:
        columns: (2, n).

    Raises:
        InputError: not two coordinates.
    """
    A = np.asarray(columns, float)
    if A.ndim != 2 or A.shape[0] != 2:
        raise InputError("grasp.flat_plot", got=A.shape[:1])
    hull = convex_hull(A.T)
    inside = hull.contains((0.0, 0.0), strictly=True)
    figure, axes = _figure()
    size = float(np.abs(A).max()) or 1.0
    sector = _cone(A)
    if sector is not None:
        axes.fill(*(1.5 * size * sector).T, color=_CONE, alpha=0.15, linewidth=0, label="cone")
    corners = A.T[hull.vertices]
    axes.fill(*corners.T, facecolor=_SET, alpha=0.2, edgecolor=_SET, label="hull")
    axes.plot(*np.vstack([corners, corners[:1]]).T, color=_SET, linewidth=1.2)
    for k, column in enumerate(A.T):
        axes.annotate("", column, (0, 0), arrowprops={"arrowstyle": "-|>", "color": _INK, "lw": 1.4})
        axes.text(*(1.08 * column), f"a{k + 1}", ha="center", va="center")
    axes.plot(0, 0, "o", color=_YES if inside else _NO, markersize=7)
    return figure


def _cone(A: Floats) -> Floats | None:
    """Polygon of the directions that non-negative sums reach, up to length 1; None for the zero set."""
    columns = A.T[np.linalg.norm(A, axis=0) > 0]
    if not len(columns):
        return None
    angles = np.sort(np.arctan2(columns[:, 1], columns[:, 0]))
    gaps = np.diff(np.append(angles, angles[0] + 2 * np.pi))
    widest = int(np.argmax(gaps))
    whole = gaps[widest] < np.pi
    start = -np.pi if whole else angles[(widest + 1) % len(angles)]
    span = 2 * np.pi if whole else 2 * np.pi - gaps[widest]
    t = start + span * np.linspace(0, 1, 60)
    rim = np.column_stack([np.cos(t), np.sin(t)])
    return rim if whole else np.vstack([np.zeros((1, 2)), rim])


def save_force_diagram(
    contacts: list[Contact] | tuple[Contact, ...], forces: ContactForces, wrench: ArrayLike, path: Path
) -> None:
    """Draw the forces of plane contacts head to tail with the load, and write the moment of each beside it.

    Args:
        contacts: in the plane.
        forces: their forces against the load.
        wrench: (3,) external (m, f) on the body [N m, N].
        path: .png, .svg or .pdf.
    """
    draw_force_diagram(contacts, forces, wrench).savefig(path, dpi=150)


def draw_force_diagram(contacts: list[Contact] | tuple[Contact, ...], forces: ContactForces, wrench: ArrayLike) -> Any:
    """The picture as a matplotlib figure; forces that balance close the polygon.

    Args:
        contacts: in the plane.
        forces: their forces against the load.
        wrench: (3,) external (m, f) on the body [N m, N].

    Raises:
        InputError: contacts in space.
    """
    if contacts[0].dimension != 2:
        raise InputError("grasp.needs_plane", what="draw_force_diagram")
    load = as_batch("wrench", wrench, (3,), finite=True)
    moments = forces.moments([c.point for c in contacts])
    arrows = [*forces.forces, load[1:]]
    names = [f"{c.name or k}: {m:.4g} N m" for k, (c, m) in enumerate(zip(contacts, moments, strict=True))]
    names.append(f"{load[0]:.4g} N m")
    figure, axes = _figure()
    tail = np.zeros(2)
    for k, (arrow, name) in enumerate(zip(arrows, names, strict=True)):
        colour = _NO if k == len(arrows) - 1 else _SET
        axes.annotate("", tail + arrow, tail, arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.8})
        axes.text(*(tail + 0.5 * arrow), name, fontsize=8)
        axes.plot(*np.array([tail, tail + arrow]).T, color=colour, linewidth=0.1)
        tail = tail + arrow
    return figure


def _figure() -> tuple[Any, Any]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.0, 5.0))
    FigureCanvasAgg(figure)
    axes: Any = figure.add_subplot(111)
    axes.set_aspect("equal")
    axes.margins(0.15)
    axes.axhline(0, color=_INK, linewidth=0.4)
    axes.axvline(0, color=_INK, linewidth=0.4)
    return figure, axes
