"""The free motions of a plane grasp as a moving picture: the body swings along each of them in turn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.figures.grasp import draw_grasp
from mafsil.grasp import Grasp

FRAMES = 24
"""Of one motion."""
REACH = 0.08
"""How far the body is moved, as a share of its size."""
_MOVED = "#2e8b57"


def save_free_motions(grasp: Grasp, path: Path, *, outline: Floats | None = None) -> None:
    """Write a moving picture.

    Args:
        grasp: in the plane, with some motion that its normals leave free.
        path: .gif.
        outline: (k, 2) corners of the body; the contact points if None.

    Raises:
        InputError: a grasp in space, or form closure.
    """
    if grasp.dimension != 2:
        raise InputError("grasp.motion_in_plane")
    free = grasp.free_motions()
    paths = [(y, True) for y in free.reversible] + [(y, False) for y in free.rays]
    if not paths:
        raise InputError("grasp.no_motion")
    from matplotlib.animation import FuncAnimation, PillowWriter

    corners = np.array([c.point for c in grasp.contacts]) if outline is None else outline
    figure = draw_grasp(grasp, grasp.closure(margins=False), outline)
    moved: Any = figure.axes[0].fill(*corners.T, facecolor="none", edgecolor=_MOVED, linewidth=2.0)[0]
    places = [_place(corners, y, t) for y, both in paths for t in _swing(both)]

    def show(frame: int) -> tuple[Any, ...]:
        moved.set_xy(places[frame])
        return (moved,)

    FuncAnimation(figure, show, frames=len(places), blit=False).save(path, writer=PillowWriter(fps=16), dpi=80)


def _swing(both_ways: bool) -> Floats:
    """Shares of the reach over one motion: to and fro; a one-way motion never goes behind its start."""
    t = np.sin(2 * np.pi * np.arange(FRAMES) / FRAMES)
    return t if both_ways else np.abs(t)


def _place(corners: Floats, twist: Floats, share: float) -> Floats:
    """Corners moved along a plane twist by a share of the reach."""
    size = float(np.ptp(corners, axis=0).max()) or 1.0
    speed = float(np.linalg.norm(twist[1:] + twist[0] * np.array([-1.0, 1.0]) * corners[:, ::-1], axis=1).max())
    s = share * REACH * size / speed
    # exp of the twist: a turn about its centre, or a straight motion.
    angle, v = s * twist[0], s * twist[1:]
    if abs(angle) < 1e-12:
        return corners + v
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    centre = np.array([-twist[2], twist[1]]) / twist[0]
    return (corners - centre) @ turn.T + centre
