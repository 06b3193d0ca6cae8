"""Moving pictures in a GIF: the four motions of a table's row, and an arm that gets its exponentials one by one."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix
from mafsil.figures import space
from mafsil.geometry import pose
from mafsil.model.denavit_hartenberg import Convention, DHRow
from mafsil.model.dh_frames import four_motions
from mafsil.performance.velocity.scaling import require_one
from mafsil.robot import Robot, of_robot

PER_MOTION = 12
"""Pictures for each elementary motion."""


def motion_frames(row: DHRow, convention: Convention | str = "modified", q: float = 0.0) -> PoseMatrix:
    """(k, 4, 4) where the frame stands while the four motions are made one after the other, {i-1} first, {i} last.

    Args:
        row: of a table.
        convention: `modified` or `classic`.
        q: joint coordinate [rad | m].
    """
    stations = [np.eye(4), *(motion.frame for motion in four_motions(row, convention, q))]
    shares = np.linspace(0.0, 1.0, PER_MOTION + 1)[1:]
    parts = [pose.interpolate_screw(a, b, shares) for a, b in pairwise(stations)]
    return np.concatenate([stations[0][None], *parts])


def exponential_frames(robot: Robot, q: ArrayLike) -> Floats:
    """(k, n) configurations while the last joint first, then the one before it, gets its coordinate.

    That is the order of T = exp([S_1] q_1) ... exp([S_n] q_n) home read from the right: every exponential moves what
    lies beyond its axis as one body.

    Args:
        robot: the arm.
        q: (n,) final coordinates [rad | m].
    """
    end = require_one("q", q, robot.n)
    rows = [np.zeros(robot.n)]
    for joint in reversed(range(robot.n)):
        for share in np.linspace(0.0, 1.0, PER_MOTION + 1)[1:]:
            row = rows[-1].copy()
            row[joint] = share * end[joint]
            rows.append(row)
    return np.stack(rows)


def animate_dh_row(
    row: DHRow, path: str | PathLike[str], convention: Convention | str = "modified", q: float = 0.0
) -> None:
    """Write the four motions of a table's row as a GIF.

    Args:
        row: of a table.
        path: .gif.
        convention: `modified` or `classic`.
        q: joint coordinate [rad | m].
    """
    frames = motion_frames(row, convention, q)
    size = max(float(np.ptp(frames[:, :3, 3], axis=0).max()), 0.3)
    names = [motion.name for motion in four_motions(row, convention, q)]
    corners = np.vstack([frames[:, :3, 3], *(f[:3, 3] + 0.5 * size * f[:3, :3].T for f in frames[::PER_MOTION])])

    def draw(axes: Any, k: int) -> str:
        space.frame(axes, frames[0], 0.4 * size, colour=space.PALE)
        space.frame(axes, frames[k], 0.4 * size, "i")
        space.view(axes, corners)
        return names[max(k - 1, 0) // PER_MOTION]

    _write(draw, len(frames), path)


@of_robot
def animate_exponentials(robot: Robot, q: ArrayLike, path: str | PathLike[str]) -> None:
    """Write as a GIF how an arm at home gets its exponentials one by one, the last joint first.

    Args:
        robot: the arm.
        q: (n,) final coordinates [rad | m].
        path: .gif.
    """
    rows = exponential_frames(robot, q)
    poses, tips = robot.link_poses(rows), robot.forward_kinematics(rows)
    chains = np.concatenate([poses[:, :, :3, 3], tips[:, None, :3, 3]], axis=1)
    size = max(float(np.ptp(chains.reshape(-1, 3), axis=0).max()), 1e-3)

    def draw(axes: Any, k: int) -> str:
        space.line(axes, chains[k], space.SOFT, "-", 5.0)
        space.frame(axes, tips[k], 0.2 * size, "b")
        space.frame(axes, np.eye(4), 0.2 * size, "s")
        space.view(axes, chains.reshape(-1, 3))
        return f"$q_{robot.n - max(k - 1, 0) // PER_MOTION}$"

    _write(draw, len(rows), path)


def _write(draw: Callable[[Any, int], str], count: int, path: str | PathLike[str]) -> None:
    import matplotlib
    from matplotlib.animation import FuncAnimation, PillowWriter

    with matplotlib.rc_context({"font.family": "DejaVu Sans", "text.color": space.INK}):
        figure, axes = space.sheet(4.2, 4.0)

        def show(k: int) -> list[Any]:
            axes.cla()
            figure.texts.clear()
            space.title(figure, draw(axes, k))
            return []

        FuncAnimation(figure, show, frames=count, blit=False).save(str(path), writer=PillowWriter(fps=16), dpi=80)
