"""A robot drawn in perspective: its body, base and tip frame."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, as_batch
from mafsil.figures.space import picture_file
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.job.planning.resting import resting_configuration
from mafsil.model import Mechanism
from mafsil.model.appearance import pieces
from mafsil.model.loading import of_any_mechanism
from mafsil.model.mesh import Surface
from mafsil.model.mesh.surface import triangles
from mafsil.robot import Robot

_INK, _SOFT = "#39424a", "#c9ced2"
_SUN = np.array([0.45, -0.55, 1.0]) / np.linalg.norm([0.45, -0.55, 1.0])
MOST_TRIANGLES = 20_000
"""Of all surfaces in files: matplotlib sorts and paints each triangle."""
_Triangles: TypeAlias = tuple[Floats, Floats]
_AXES = ("#d33f3a", "#2f9e57", "#2f6fd0")


@of_any_mechanism
def plot_mechanism(mechanism: Mechanism, path: str | PathLike[str], q: ArrayLike | None = None) -> Any:
    """Draw a robot into a picture file.

    Args:
        mechanism: what to draw.
        path: .png, .svg or .pdf.
        q: (n,) configuration [rad | m]; a relaxed one within the limits if None.

    Returns:
        The matplotlib Figure that was written.
    """
    path = picture_file(path)
    import matplotlib

    with matplotlib.rc_context({"svg.hashsalt": "mafsil", "font.size": 8, "text.color": _INK}):
        figure = draw_mechanism(mechanism, q)
        figure.savefig(path, dpi=200, bbox_inches="tight", pad_inches=0.05, metadata=_metadata(path))
        return figure


def draw_mechanism(mechanism: Mechanism, q: ArrayLike | None = None) -> Any:
    """A matplotlib figure of a robot.

    Args:
        mechanism: what to draw.
        q: (n,) configuration [rad | m]; a relaxed one within the limits if None.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    robot = Robot(mechanism)
    values = resting_configuration(mechanism) if q is None else as_batch("q", q, (mechanism.n,), finite=True)
    poses = np.asarray(robot.link_poses(values))
    tip = poses[mechanism.link_names.index(mechanism.tip)] @ mechanism.T_lt
    drawn = _triangles(mechanism, poses)
    corners = [piece.reshape(-1, 3) for piece, _ in drawn]
    points = np.vstack([poses[:, :3, 3], tip[:3, 3], [0.0, 0.0, 0.0], *corners])
    size = max(float(np.ptp(points, axis=0).max()), 0.05)
    figure = Figure(figsize=(5.2, 5.2))
    FigureCanvasAgg(figure)
    axes: Any = figure.add_subplot(projection="3d", computed_zorder=False)
    _floor(axes, points, size)
    _body(axes, drawn)
    for pose, scale in ((np.eye(4), 0.14), (tip, 0.12)):
        _frame(axes, pose, scale * size)
    _view(axes, points, size)
    return figure


def _body(axes: Any, drawn: list[_Triangles]) -> None:
    """All triangles in one collection, so that matplotlib sorts them by depth; lit from above."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    corners = np.concatenate([triangles for triangles, _ in drawn])
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), LEAST_DIVISOR)
    colours = np.concatenate([colour for _, colour in drawn])
    colours[:, :3] *= (0.62 + 0.38 * np.abs(normals @ _SUN))[:, None]
    body = Poly3DCollection(corners, facecolors=colours, edgecolors=colours, linewidths=0.15, zorder=3)
    body.set_rasterized(True)
    axes.add_collection3d(body)


def _triangles(mechanism: Mechanism, poses: PoseMatrix) -> list[_Triangles]:
    """Corners (k, 3, 3) in {s} and colours (k, 4) of each piece."""
    drawn: list[_Triangles] = []
    for pose, of_link in zip(poses, pieces(mechanism, MOST_TRIANGLES), strict=True):
        for piece in of_link:
            surface = piece.geometry if isinstance(piece.geometry, Surface) else triangles(piece.geometry)
            T = pose @ piece.T_lg
            corners = surface.vertices[surface.faces] @ T[:3, :3].T + T[:3, 3]
            given = np.tile(piece.colour, (len(corners), 1)) if surface.colours is None else surface.colours.copy()
            drawn.append((corners, np.clip(given, 0.0, 1.0)))
    return drawn


def _frame(axes: Any, pose: PoseMatrix, length: float) -> None:
    """Red, green and blue arrows along x, y and z."""
    for k, colour in enumerate(_AXES):
        axes.quiver(
            *pose[:3, 3], *(length * pose[:3, k]), color=colour, linewidth=1.8, arrow_length_ratio=0.25, zorder=6
        )


def _floor(axes: Any, points: Floats, size: float) -> None:
    """A grid at the height of the lowest point, or of the base if nothing is below it."""
    low = min(0.0, float(points[:, 2].min()))
    decade: float = 10.0 ** np.floor(np.log10(size))
    pitch: float = next(
        step for step in (0.1 * decade, 0.2 * decade, 0.5 * decade, decade, 2.0 * decade) if size / step <= 8.0
    )
    half: float = np.ceil(0.75 * size / pitch) * pitch
    middle: Floats = points.mean(axis=0)[:2]
    centre = np.round(middle / pitch) * pitch
    for offset in np.arange(-half, half + pitch / 2, pitch):
        for line in (([-half, half], [offset, offset]), ([offset, offset], [-half, half])):
            axes.plot(centre[0] + line[0], centre[1] + line[1], [low, low], color=_SOFT, linewidth=0.6, zorder=0)


def _view(axes: Any, points: Floats, size: float) -> None:
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    for setter, c in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), centre, strict=True):
        setter(c - 0.6 * size, c + 0.6 * size)
    axes.set_box_aspect((1, 1, 1))
    axes.view_init(elev=20, azim=-55)
    axes.set_axis_off()


def _metadata(path: Path) -> dict[str, Any]:
    """No dates in files: the same robot gives the same bytes."""
    return (
        {"Date": None}
        if path.suffix.lower() == ".svg"
        else {"CreationDate": None}
        if path.suffix.lower() == ".pdf"
        else {}
    )
