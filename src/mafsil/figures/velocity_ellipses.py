"""Velocity and force ellipses of planar arms in several poses, ellipsoids of spatial arms."""

from __future__ import annotations

from itertools import pairwise
from os import PathLike
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch
from mafsil.figures.performance_sheet import FORCE, INK, SHELL, VELOCITY, flat_axes, label, save, sheet
from mafsil.figures.space import picture_file
from mafsil.performance import force_ellipsoid, velocity_ellipsoid
from mafsil.robot import Robot, of_robot


@of_robot
def save_planar_ellipses(robot: Robot, q: ArrayLike, path: str | PathLike[str], *, language: str | None = None) -> None:
    """Draw a planar arm in several poses with its velocity and force ellipses at the tip.

    Args:
        robot: an arm that moves in the x-y plane of {s}.
        q: (k, n) poses [rad | m].
        path: .png, .svg or .pdf.
        language: of the labels; the current one if None.
    """
    path = picture_file(path)
    poses = np.atleast_2d(as_batch("q", q, (robot.n,), finite=True))
    figure = sheet(6.0, 5.4)
    axes: Any = figure.add_subplot()
    points = [_skeleton(robot, pose) for pose in poses]
    size = float(np.ptp(np.vstack(points), axis=0).max())
    for k, (pose, chain) in enumerate(zip(poses, points, strict=True)):
        axes.plot(*chain.T, color=SHELL, linewidth=3.5, solid_capstyle="round", zorder=2)
        axes.plot(*chain[:-1].T, "o", color=INK, markersize=4, zorder=3)
        for force, colour in ((False, VELOCITY), (True, FORCE)):
            found = (force_ellipsoid if force else velocity_ellipsoid)(robot, pose, "planar")
            lengths = np.minimum(found.lengths, 2.5)
            scale = 0.13 * size * lengths / max(1.0, float(lengths.max()) / 1.6)
            name = label("force_ellipse" if force else "velocity_ellipse", language) if k == 0 else None
            _ellipse(axes, chain[-1], found.axes, scale, colour, name, dashed=force)
    flat_axes(axes, "x [m]", "y [m]")
    figure.legend(loc="outside lower center", frameon=False, ncols=2)
    save(figure, path)


@of_robot
def save_ellipsoid(
    robot: Robot,
    q: ArrayLike,
    path: str | PathLike[str],
    *,
    part: Literal["linear", "angular"] = "linear",
    language: str | None = None,
) -> None:
    """Draw a spatial arm with the velocity ellipsoid at its tip and the ellipsoid's principal axes.

    Args:
        robot: the arm.
        q: (n,) configuration [rad | m].
        path: .png, .svg or .pdf.
        part: which ellipsoid.
        language: of the labels; the current one if None.
    """
    path = picture_file(path)
    configuration = as_batch("q", q, (robot.n,), finite=True)
    found = velocity_ellipsoid(robot, configuration, part)
    figure = sheet(5.6, 5.6)
    axes: Any = figure.add_subplot(projection="3d", computed_zorder=False)
    chain = _skeleton(robot, configuration, spatial=True)
    reach = float(np.ptp(np.vstack([chain, np.zeros(3)]), axis=0).max())
    scale = 0.35 * reach / max(float(found.lengths.max()), 1e-9)
    x, y, z = _sphere(found.axes * (scale * found.lengths), chain[-1])
    axes.plot_surface(x, y, z, color=VELOCITY, alpha=0.28, linewidth=0, antialiased=True, zorder=3)
    axes.plot_wireframe(x, y, z, color=VELOCITY, alpha=0.35, linewidth=0.4, rcount=9, ccount=9, zorder=4)
    axes.plot(*chain.T, color=SHELL, linewidth=6, solid_capstyle="round", solid_joinstyle="round", zorder=2)
    axes.plot(*chain[:-1].T, "o", color=INK, markersize=5, zorder=5)
    for k in range(3):
        half = found.axes[:, k] * found.lengths[k] * scale
        name = f"{label('axis', language)} {k + 1}: {found.lengths[k]:.3g}"
        colour = ("#d33f3a", "#2f9e57", "#2f6fd0")[k]
        axes.plot(*np.array([chain[-1] - half, chain[-1] + half]).T, color=colour, linewidth=2.2, zorder=6, label=name)
    _cube(axes, np.vstack([chain, chain[-1] + 0.35 * reach, chain[-1] - 0.35 * reach]))
    axes.legend(loc="upper right", frameon=False, title=label(f"{part}_ellipsoid", language))
    save(figure, path)


def _skeleton(robot: Robot, q: Floats, *, spatial: bool = False) -> Floats:
    """(k, 2 | 3) origins of the links on the way to the tip, and the tip."""
    poses = robot.link_poses(q)
    names = robot.mechanism.link_names
    chain = [names.index(robot.mechanism.tip)]
    while chain[-1]:
        chain.append(robot.mechanism.parents[chain[-1] - 1])
    points = [poses[k][:3, 3] for k in reversed(chain)] + [robot.forward_kinematics(q)[:3, 3]]
    distinct = [points[0], *(b for a, b in pairwise(points) if np.linalg.norm(b - a) > 1e-9)]
    return np.array(distinct)[:, : 3 if spatial else 2]


def _ellipse(
    axes: Any, centre: Floats, directions: Floats, lengths: Floats, colour: str, name: str | None, *, dashed: bool
) -> None:
    angle = np.linspace(0, 2 * np.pi, 181)
    outline = centre[:, None] + directions @ (lengths[:, None] * np.array([np.cos(angle), np.sin(angle)]))
    axes.plot(*outline, color=colour, linewidth=1.4, linestyle="--" if dashed else "-", label=name, zorder=4)
    if not dashed:
        axes.fill(*outline, color=colour, alpha=0.12, linewidth=0, zorder=1)


def _sphere(shape: Floats, centre: Floats) -> tuple[Floats, Floats, Floats]:
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 49), np.linspace(0, np.pi, 25))
    unit = np.array([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)])
    x, y, z = np.einsum("ij,jkl->ikl", shape, unit) + centre[:, None, None]
    return x, y, z


def _cube(axes: Any, points: Floats) -> None:
    middle, half = (points.min(axis=0) + points.max(axis=0)) / 2, 0.55 * float(np.ptp(points, axis=0).max())
    for setter, c in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), middle, strict=True):
        setter(c - half, c + half)
    axes.set_box_aspect((1, 1, 1))
    axes.view_init(elev=20, azim=-55)
    axes.tick_params(labelsize=7, pad=0)
    for name, setter in zip("xyz", (axes.set_xlabel, axes.set_ylabel, axes.set_zlabel), strict=True):
        setter(f"{name} [m]", labelpad=0)
