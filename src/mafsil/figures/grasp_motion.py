"""The motions that a plane grasp leaves, as a moving picture: the body swings along each, never into a finger."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.figures.grasp import draw_grasp
from mafsil.figures.picture_file import picture_file
from mafsil.grasp import Grasp
from mafsil.grasp.displacement import displaced_pose, free_twists

FRAMES = 24
"""Of one motion."""
REACH = 0.08
"""How far the body is moved, as a share of its size."""
_MOVED = "#2e8b57"


def save_free_motions(grasp: Grasp, path: str | PathLike[str], *, outline: Floats | None = None) -> None:
    """Write a moving picture.

    Args:
        grasp: in the plane, with some motion that neither its normals nor curvature forbid.
        path: .gif.
        outline: (k, 2) corners of the body; the contact points if None.

    Raises:
        InputError: a grasp in space, or one that leaves no motion that can be shown.
    """
    path = picture_file(path, (".gif",))
    if grasp.dimension != 2:
        raise InputError("grasp.motion_in_plane")
    paths = free_twists(grasp)
    if not paths:
        raise InputError("grasp.motion_blocked", finding=grasp.second_order().explain())
    from matplotlib.animation import FuncAnimation, PillowWriter

    corners = np.array([c.point for c in grasp.contacts]) if outline is None else outline
    figure = draw_grasp(grasp, grasp.closure(margins=False), outline)
    moved: Any = figure.axes[0].fill(*corners.T, facecolor="none", edgecolor=_MOVED, linewidth=2.0)[0]
    places = [_place(grasp, corners, y, t) for y, both in paths for t in _swing(both)]

    def show(frame: int) -> tuple[Any, ...]:
        moved.set_xy(places[frame])
        return (moved,)

    FuncAnimation(figure, show, frames=len(places), blit=False).save(path, writer=PillowWriter(fps=16), dpi=80)


def _swing(both_ways: bool) -> Floats:
    """Shares of the reach over one motion: to and fro; a one-way motion never goes behind its start."""
    t = np.sin(2 * np.pi * np.arange(FRAMES) / FRAMES)
    return t if both_ways else np.abs(t)


def _place(grasp: Grasp, corners: Floats, twist: Floats, share: float) -> Floats:
    """Corners moved along a plane twist by a share of the reach; at rest where a finger would be inside."""
    size = float(np.ptp(corners, axis=0).max()) or 1.0
    pose = displaced_pose(grasp, np.sign(share) * twist, abs(share) * REACH * size)
    return corners if pose is None else corners @ pose[:2, :2].T + pose[:2, 2]
