"""Pictures of velocity kinematics and statics: joint axes, forces on links, frames that no table has."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Vector3
from mafsil.figures import space
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import screw
from mafsil.messages import say
from mafsil.model.dh_frames import link_fit
from mafsil.performance import joint_reactions, tool_jacobian
from mafsil.performance.statics import LinkLoad
from mafsil.performance.velocity.scaling import require_one
from mafsil.robot import Robot, of_robot

REACH = 1.15


@of_robot
def plot_joint_screws(robot: Robot, q: ArrayLike, path: str | PathLike[str]) -> None:
    """Draw the axes of all joints at a configuration: the columns of the space Jacobian, each with its part at the tip.

    Args:
        robot: the arm.
        q: (n,) joint coordinates [rad | m].
        path: .png, .svg or .pdf.
    """
    configuration = require_one("q", q, robot.n)
    space.save(lambda: draw_joint_screws(robot, configuration), Path(path))


def draw_joint_screws(robot: Robot, q: Floats) -> Any:
    """A matplotlib figure of joint axes and tip velocities; arguments as for `plot_joint_screws`."""
    figure, axes = space.sheet()
    chain, size = _skeleton(axes, robot, q)
    tip, J = chain[-1], robot.jacobian_space(q)
    columns = tool_jacobian(robot, q)[3:]
    scale = 0.35 * size / max(float(np.linalg.norm(columns, axis=0).max()), 1e-12)
    for k, S in enumerate(J.T):
        colour = space.AXES[k % 3]
        if S[:3].any():
            foot = np.asarray(screw.nearest_point(S))
            near = foot + S[:3] * float(S[:3] @ (chain[min(k + 1, len(chain) - 1)] - foot))
        else:
            near = chain[min(k + 1, len(chain) - 1)]
        direction = S[:3] if S[:3].any() else S[3:]
        space.line(axes, np.stack([near - 0.25 * size * direction, near + 0.25 * size * direction]), colour, "-.")
        space.label(axes, near + 0.3 * size * direction, f"$S_{k + 1}$", colour)
        if np.linalg.norm(columns[:, k]) * scale > 0.02 * size:
            space.arrow(axes, tip, scale * columns[:, k], colour, 1.6)
            space.label(axes, tip + REACH * scale * columns[:, k], rf"$\dot q_{k + 1}$", colour)
    space.title(figure, say("pictures.joint_screws", robot=robot.name), size=10.0)
    space.view(axes, np.vstack([chain, *(tip + scale * c for c in columns.T)]))
    return figure


@of_robot
def plot_free_bodies(robot: Robot, q: ArrayLike, path: str | PathLike[str], loads: Sequence[LinkLoad] = ()) -> None:
    """Draw the free-body diagram of every link in equilibrium: loads, and the force that each joint passes on.

    Args:
        robot: the arm.
        q: (n,) joint coordinates [rad | m].
        path: .png, .svg or .pdf.
        loads: acting on links; the weights are counted besides.
    """
    configuration = require_one("q", q, robot.n)
    space.save(lambda: draw_free_bodies(robot, configuration, loads), Path(path))


def draw_free_bodies(robot: Robot, q: Floats, loads: Sequence[LinkLoad] = ()) -> Any:
    """A matplotlib figure of forces on links; arguments as for `plot_free_bodies`."""
    figure, axes = space.sheet()
    chain, size = _skeleton(axes, robot, q)
    poses, reactions = robot.link_poses(q), joint_reactions(robot, q, loads=loads)
    applied: list[tuple[Vector3, Vector3]] = []
    for load in loads:
        T = poses[robot.mechanism.link_names.index(load.link)]
        applied.append((T[:3, 3] + T[:3, :3] @ np.asarray(load.point, float), load.in_space(T)[1]))
    passed = [(poses[k + 1, :3, 3], F[3:]) for k, F in enumerate(reactions.at_joint)]
    largest = max((float(np.linalg.norm(f)) for _, f in (*applied, *passed)), default=0.0)
    ends = [chain]
    for forces, colour, letter in ((applied, space.ACCENT, "f"), (passed, space.SECOND, "r")):
        for k, (place, force) in enumerate(forces, 1):
            if np.linalg.norm(force) > 1e-9 * max(largest, LEAST_DIVISOR):
                step = 0.45 * size * force / largest
                space.arrow(axes, place, step, colour, 2.0)
                space.label(axes, place + REACH * step, f"${letter}_{k}$", colour)
                ends.append((place + step)[None])
    space.title(figure, say("pictures.free_bodies", robot=robot.name, largest=f"{largest:.4g}"), size=9.0)
    space.view(axes, np.vstack(ends))
    return figure


def plot_unreachable_frame(T: ArrayLike, path: str | PathLike[str]) -> None:
    """Draw two link frames and whether one row of a table can connect them, with the condition that fails.

    Args:
        T: (4, 4) pose of the second frame in the first.
        path: .png, .svg or .pdf.
    """
    fit = link_fit(T)
    matrix = np.asarray(T, dtype=np.float64)
    space.save(lambda: _draw_unreachable(matrix, fit.explain()), Path(path))


def _draw_unreachable(T: Floats, message: str) -> Any:
    figure, axes = space.sheet()
    length = 0.5 * max(float(np.linalg.norm(T[:3, 3])), 0.5)
    space.frame(axes, np.eye(4), length, "i-1")
    space.frame(axes, T, length, "i")
    space.line(axes, np.stack([np.zeros(3), T[:3, 3]]), space.SOFT, "--")
    space.title(figure, message, size=8.0)
    space.view(axes, np.vstack([length * np.eye(3), np.zeros(3), T[:3, 3], T[:3, 3] + length * T[:3, :3].T]))
    return figure


def _skeleton(axes: Any, robot: Robot, q: Floats) -> tuple[Floats, float]:
    """The line through the origins of all links to the tip, with joints as dots, and its size."""
    poses = robot.link_poses(q)
    chain = np.vstack([poses[:, :3, 3], robot.forward_kinematics(q)[:3, 3]])
    size = max(float(np.ptp(chain, axis=0).max()), 1e-3)
    space.line(axes, chain, space.PALE, "-", 6.0)
    axes.plot(*chain[1:-1].T, marker="o", linestyle="", color=space.INK, markersize=4, zorder=6)
    space.frame(axes, robot.forward_kinematics(q), 0.18 * size, "b")
    space.frame(axes, np.eye(4), 0.18 * size, "s")
    return chain, size
