"""What pictures of motions in space share: sheet, arrows, frames with their letters, labels, the view, the file."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import Any, cast

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, Vector3
from mafsil.errors import FileError, InputError
from mafsil.messages import in_line

INK, SOFT, PALE = "#39424a", "#8a949c", "#c9ced2"
AXES = ("#d33f3a", "#2f9e57", "#2f6fd0")
ACCENT, SECOND = "#d9702a", "#7a4fb5"
ENDINGS = (".png", ".svg", ".pdf")
"""Kinds of pictures."""
_DEJAVU: dict[Any, Any] = {"font.family": "DejaVu Sans", "svg.hashsalt": "mafsil", "text.color": INK, "font.size": 10}


def sheet(width: float = 6.0, height: float = 5.6) -> tuple[Any, Any]:
    """A matplotlib figure and its axes in space, the whole sheet but the strip of the title.

    Args:
        width: of the sheet [inch].
        height: likewise.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    return figure, panel(figure, (0.0, 0.0, 1.0, 0.93))


def panel(figure: Any, place: tuple[float, float, float, float]) -> Any:
    """Axes in space on a part of a sheet: left, bottom, width, height as fractions."""
    return figure.add_axes(place, projection="3d", computed_zorder=False)


def title(figure: Any, text: str, x: float = 0.5, y: float = 0.975, size: float = 12.0) -> None:
    """The heading, centred at x, in the direction of the language."""
    figure.text(x, y, "\n".join(map(in_line, text.split("\n"))), ha="center", va="top", fontsize=size, color=INK)


def arrow(axes: Any, start: Vector3, step: Vector3, colour: str, width: float = 1.8, head: float = 0.16) -> None:
    """An arrow from a point along a vector."""
    axes.quiver(*start, *step, color=colour, linewidth=width, arrow_length_ratio=head, zorder=5)


def label(axes: Any, place: Vector3, text: str, colour: str = INK, size: float = 10.0) -> None:
    """A word at a point, on a white ground so that lines do not cross it."""
    ground = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.6}
    axes.text(*place, text, color=colour, fontsize=size, ha="center", va="center", zorder=9, bbox=ground)


def frame(axes: Any, T: PoseMatrix, length: float, name: str = "", colour: str | None = None) -> None:
    """Arrows along x, y, z; with a name also letters x_b, y_b, z_b and {b} at the origin; in one colour for a ghost."""
    origin, R = T[:3, 3], T[:3, :3]
    for k, letter in enumerate("xyz"):
        arrow(axes, origin, length * R[:, k], colour or AXES[k], 1.2 if colour else 2.0)
        if name:
            label(axes, origin + 1.16 * length * R[:, k], f"$x_{{{name}}}$".replace("x", letter, 1), colour or AXES[k])
    axes.plot(*origin[:, None], marker="o", color=colour or INK, markersize=3.5, zorder=6)
    if name:
        away = -R.sum(axis=1) / np.sqrt(3.0)
        label(axes, origin + 0.26 * length * away, "{" + name + "}", colour or INK)


def line(axes: Any, points: Floats, colour: str, style: str = "-", width: float = 1.4) -> None:
    """A line through (k, 3) points."""
    axes.plot(*np.asarray(points).T, color=colour, linestyle=style, linewidth=width, zorder=3)


def view(axes: Any, points: Floats, zoom: float = 1.25, elevation: float = 22.0, azimuth: float = -58.0) -> None:
    """Show all points, equal units along all axes, no box.

    Args:
        axes: in space.
        points: (k, 3).
        zoom: how much of the sheet the cube about the points fills.
        elevation: of the eye above the x-y plane [degree].
        azimuth: of the eye about z [degree].
    """
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    half = max(0.52 * float(np.ptp(points, axis=0).max()), 1e-9)
    for setter, c in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), centre, strict=True):
        setter(c - half, c + half)
    axes.set_box_aspect((1, 1, 1), zoom=zoom)
    axes.view_init(elev=elevation, azim=azimuth)
    axes.set_axis_off()


def save(draw: Callable[[], Any], path: Path) -> None:
    """Draw a figure and write it: the same figure, the same bytes.

    Args:
        draw: makes the figure.
        path: .png, .svg or .pdf.

    Raises:
        FileError: it cannot be written there.
    """
    import matplotlib

    undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(path.suffix.lower(), {})
    with matplotlib.rc_context(_DEJAVU):
        figure = draw()
        try:
            figure.savefig(path, dpi=160, bbox_inches=_ink(figure), metadata=undated)
        except OSError as error:
            raise FileError("pictures.unwritable", path=str(path), reason=error.strerror or str(error)) from None


def _ink(figure: Any, margin: float = 0.12) -> Any:
    """The part of the sheet with ink on it [inch]: in space, matplotlib's own tight box keeps the empty axes."""
    from matplotlib.transforms import Bbox

    figure.canvas.draw()
    pixels: Any = np.asarray(figure.canvas.buffer_rgba())
    inked = (pixels[::-1, :, :3] < 250).any(axis=-1)
    rows, columns = np.flatnonzero(inked.any(axis=1)), np.flatnonzero(inked.any(axis=0))
    corners = np.array([[columns[0], rows[0]], [columns[-1] + 1, rows[-1] + 1]]) / figure.dpi
    return Bbox(corners).padded(margin)


def picture_file(path: str | PathLike[str], endings: tuple[str, ...] = ENDINGS) -> Path:
    """The path of a picture.

    Args:
        path: as the user gave it.
        endings: that can be written.

    Raises:
        InputError: no path, or an ending of no picture.
    """
    if not isinstance(cast(object, path), str | PathLike):
        raise InputError("input.kind", name="path", expected="str / pathlib.Path", got=type(path).__name__)
    file = Path(path)
    if file.suffix.lower() not in endings:
        raise InputError("pictures.ending", path=str(path), known=", ".join(endings))
    return file
