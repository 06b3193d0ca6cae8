"""A displacement as the screw motion that makes it: axis, pitch, the way of a frame along the helix.

The picture that fits a motion: rotation, rings at a gimbal lock, screw motion, or pole in the plane.
"""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, Vector6
from mafsil.figures import space
from mafsil.figures.frames import plot_rotation
from mafsil.figures.gimbals import plot_gimbals
from mafsil.figures.pole import plot_pole
from mafsil.figures.space import picture_file
from mafsil.geometry import euler, pose, screw
from mafsil.messages import say

_GHOSTS = 4


def plot_screw_motion(T: ArrayLike, path: str | PathLike[str], start: ArrayLike | None = None) -> None:
    """Draw the screw motion of a displacement into a file.

    Args:
        T: (4, 4) displacement in the coordinates of {s}.
        path: .png, .svg or .pdf.
        start: (4, 4) pose T_sa of the frame that is carried along; {s} itself if None.
    """
    path = picture_file(path)
    displacement = pose.check(T)
    begin = np.eye(4) if start is None else pose.check(start, "start")
    space.save(lambda: draw_screw_motion(displacement, begin), path)


def draw_screw_motion(T: PoseMatrix, start: PoseMatrix) -> Any:
    """A matplotlib figure of a screw motion; arguments as for `plot_screw_motion`."""
    S, amount = screw.chasles(T)
    names = ("s", "b") if np.array_equal(start, np.eye(4)) else ("a", "b")
    way = np.asarray(pose.compose(screw.displacement(_unit(S), np.linspace(0.0, float(amount), 121)), start))
    path = way[:, :3, 3]
    size = max(float(np.ptp(np.vstack([path, _feet(S, path)]), axis=0).max()), 1e-9) if amount else 1.0
    length = 0.3 * size
    figure, axes = space.sheet()
    corners = [path, way[0, :3, 3] - (0.0 if amount else 2.0 * length) * np.ones((1, 3))]
    if amount:
        corners.append(_axis(axes, S, path, size))
        space.line(axes, path, space.ACCENT, "-", 1.8)
        for k in np.linspace(0, 120, _GHOSTS + 2).astype(int)[1:-1]:
            space.frame(axes, way[k], 0.55 * length, colour=space.PALE)
    space.frame(axes, way[0], length, names[0])
    if amount:
        space.frame(axes, way[-1], length, names[1])
    corners += [w[:3, 3] + 1.15 * length * w[:3, :3].T for w in (way[0], way[-1])]
    space.title(figure, _heading(S, float(amount)))
    space.view(axes, np.vstack(corners))
    return figure


def _unit(S: Vector6) -> Vector6:
    """The screw; of the identity, which has none, any."""
    return S if S.any() else np.eye(6)[0]


def _feet(S: Vector6, points: Floats) -> Floats:
    """(k, 3) points of the axis nearest to points, or the points themselves where there is no axis."""
    omega = S[:3]
    if not omega.any():
        return points
    foot = screw.nearest_point(S)
    return foot + np.outer((points - foot) @ omega, omega)


def _axis(axes: Any, S: Vector6, path: Floats, size: float) -> Floats:
    """The axis line with its arrow, the two feet of the moving origin and the advance between them; its ends."""
    omega = S[:3]
    if not omega.any():
        return path
    feet = _feet(S, path)
    direction = omega if (feet[-1] - feet[0]) @ omega >= 0 else -omega
    low, high = sorted((feet[0], feet[-1]), key=lambda foot: float(foot @ omega))
    ends = np.array([low - 0.3 * size * omega, high + 0.45 * size * omega])
    space.line(axes, ends, space.INK, "-.", 1.4)
    space.arrow(axes, ends[1] - 0.18 * size * omega, 0.18 * size * omega, space.INK, 1.8, 0.35)
    space.label(axes, ends[1] + 0.1 * size * omega, "$S$")
    for foot, point in ((feet[0], path[0]), (feet[-1], path[-1])):
        space.line(axes, np.array([foot, point]), space.SOFT, "--", 1.0)
        axes.plot(*foot[:, None], marker="o", color=space.SECOND, markersize=4, zorder=6)
    advance = float(np.linalg.norm(feet[-1] - feet[0]))
    if advance > 1e-3 * size:
        space.line(axes, feet[[0, -1]], space.SECOND, "-", 3.0)
        aside = np.cross(direction, path[0] - feet[0])
        aside = aside / max(float(np.linalg.norm(aside)), 1e-12)
        space.label(axes, (feet[0] + feet[-1]) / 2 + 0.12 * size * aside, r"$h\,\theta$", space.SECOND)
    return ends


def _heading(S: Vector6, amount: float) -> str:
    if not amount:
        return say("pictures.no_motion")
    if not S[:3].any():
        return say("pictures.translation", distance=f"{amount:.4g}")
    pitch = float(screw.pitch(S))
    return say("pictures.screw", angle=f"{np.degrees(amount):.4g}", pitch=f"{0.0 if abs(pitch) < 1e-12 else pitch:.4g}")


def plot_motion(T: PoseMatrix, path: str | PathLike[str], kind: str, sequence: str | None = None) -> None:
    """Draw a motion into a file.

    Args:
        T: (4, 4) pose.
        path: .png, .svg or .pdf.
        kind: `rotation`, `pose` or `planar`.
        sequence: of the angles in which a rotation was given: at a lock of it the rings are drawn.
    """
    path = picture_file(path)
    R = T[:3, :3]
    if kind == "planar":
        flat = np.eye(3)
        flat[:2, :2], flat[:2, 2] = T[:2, :2], T[:2, 3]
        plot_pole(flat, path)
    elif kind == "pose":
        plot_screw_motion(T, path)
    elif sequence is not None and euler.solutions(R, sequence).locked:
        plot_gimbals(euler.to_euler(R, sequence), sequence, path)
    else:
        plot_rotation(R, path)
