"""Three rings that carry each other, as the angles of a sequence: free, and locked where two axes fall together."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Vector3, as_batch
from mafsil.figures import space
from mafsil.figures.space import picture_file
from mafsil.geometry import euler, rotation
from mafsil.messages import say

_RADII = (1.0, 0.82, 0.64)


def plot_gimbals(angles: ArrayLike, sequence: str, path: str | PathLike[str]) -> None:
    """Draw the rings of three angles into a file, beside the same rings far from a lock.

    Args:
        angles: (3,) [rad].
        sequence: such as `ZYX`; a fixed one is drawn as the moving one that makes the same rotations.
        path: .png, .svg or .pdf.
    """
    path = picture_file(path)
    moving, name = euler.to_moving(as_batch("angles", angles, (3,)), sequence)
    space.save(lambda: draw_gimbals(np.asarray(moving), name), path)


def draw_gimbals(angles: Vector3, sequence: str) -> Any:
    """A matplotlib figure of rings; arguments as for `plot_gimbals`, the sequence a moving one."""
    known = euler.sequence_named(sequence)
    easy = 0.5 * np.pi if known.body_axes[0] == known.body_axes[2] else 0.0
    figure, _ = _sheet()
    free = np.array([angles[0], easy + np.radians(35.0), angles[2]])
    for k, values in enumerate((free, angles)):
        axes = space.panel(figure, (0.5 * k, 0.0, 0.5, 0.86))
        locked = _rings(axes, values, known.body_axes)
        words = say("pictures.locked" if locked else "pictures.free", angle=f"{np.degrees(values[1]):.4g}")
        space.title(figure, words, 0.25 + 0.5 * k, 0.9, 10.0)
    space.title(figure, say("pictures.gimbals", sequence=sequence))
    return figure


def _sheet() -> tuple[Any, Any]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.8, 5.4))
    return figure, FigureCanvasAgg(figure)


def _rings(axes: Any, angles: Vector3, body_axes: tuple[int, ...]) -> bool:
    """Each ring turns about its axis, carried by the ring outside; whether first and third axis fall together."""
    R, directions, normals = np.eye(3), list[Vector3](), list[Vector3]()
    for k, (angle, axis) in enumerate(zip(angles, body_axes, strict=True)):
        direction = R @ np.eye(3)[axis]
        R = R @ rotation.from_axis_angle(np.eye(3)[axis], angle)
        following = body_axes[k + 1] if k < 2 else _other(axis, body_axes[1])
        directions.append(direction)
        normals.append(R @ np.cross(np.eye(3)[axis], np.eye(3)[following]))
        _ring(axes, R, axis, following, _RADII[k], space.AXES[k])
    for k, direction in enumerate(directions):
        _spindle(axes, direction, k)
    _body(axes, R)
    space.view(axes, np.array([-1.2 * np.ones(3), 1.2 * np.ones(3)]), 1.35, azimuth=_azimuth(normals))
    return bool(np.linalg.norm(np.cross(directions[0], directions[2])) < 1e-6)


def _azimuth(normals: list[Vector3], elevation: float = 22.0) -> float:
    """Of the eye [degree], from where no ring is seen edge-on."""
    azimuths = np.arange(-60.0, 300.0, 10.0)
    up, around = np.radians(elevation), np.radians(azimuths)
    eyes = np.stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.full_like(around, np.sin(up))], -1)
    openness = np.abs(eyes @ np.array(normals).T).min(axis=1)
    return float(azimuths[np.argmax(np.minimum(openness, 0.45))])


def _other(first: int, second: int) -> int:
    """An axis that is not the first, the third of all if the second is another."""
    return 3 - first - second if first != second else (first + 1) % 3


def _ring(axes: Any, R: Floats, own: int, following: int, radius: float, colour: str) -> None:
    """A circle through the ring's own axis and the one that it carries."""
    turn = np.linspace(0.0, 2 * np.pi, 121)
    plane = np.eye(3)[[own, following]]
    circle = radius * (np.cos(turn)[:, None] * plane[0] + np.sin(turn)[:, None] * plane[1])
    axes.plot(*(circle @ R.T).T, color=colour, linewidth=4.0, alpha=0.85, zorder=4)


def _spindle(axes: Any, direction: Vector3, k: int) -> None:
    """The axis of a ring, through its bearings in the ring outside."""
    outside = _RADII[k - 1] if k else 1.2
    for side in (-1.0, 1.0):
        ends = np.array([side * _RADII[k] * direction, side * outside * direction])
        axes.plot(*ends.T, color=space.AXES[k], linewidth=5.0, solid_capstyle="butt", zorder=5)
    space.line(axes, np.array([-outside * direction, outside * direction]), space.AXES[k], ":", 1.0)
    space.label(axes, (0.42 if k == 2 else outside + 0.12) * direction, str(k + 1), space.AXES[k], 11.0)


def _body(axes: Any, R: Floats) -> None:
    """A plate with a nose in the middle."""
    shape = 0.4 * np.array([[1.0, 0, 0], [-0.6, 0.45, 0], [-0.35, 0, 0], [-0.6, -0.45, 0], [1.0, 0, 0]])
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    axes.add_collection3d(Poly3DCollection([shape @ R.T], facecolor=space.PALE, edgecolor=space.INK, zorder=3))
