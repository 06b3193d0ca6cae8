"""Configurations of an arm in its plane: the annulus that its tip reaches, the law of cosines for two links."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.figures import space
from mafsil.messages import say
from mafsil.messages.visible import visible
from mafsil.model import JointKind
from mafsil.performance import reachable_annulus
from mafsil.robot import Robot

PARALLEL = 1e-9
"""Largest sine of the angle between axes that count as parallel."""


def plane(robot: Robot) -> Floats | None:
    """(2, 3) directions that span the plane in which an arm of turning, parallel axes moves; None of other arms.

    Args:
        robot: any arm.
    """
    kinds = {joint.kind for joint in robot.mechanism.coordinates}
    if robot.n < 2 or kinds != {JointKind.REVOLUTE}:
        return None
    axes = np.asarray(robot.jacobian_space(np.zeros(robot.n)))[:3].T
    if np.abs(np.cross(axes, axes[0])).max() > PARALLEL:
        return None
    # Seen from where the axis points, with x to the right if that can be.
    across = np.eye(3)[0 if abs(axes[0, 0]) < 0.9 else 1]
    right = across - (across @ axes[0]) * axes[0]
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(axes[0], right)])


def draw_planar_configurations(
    robot: Robot, q: Floats, names: Sequence[str], within: Any, count: int, colours: Sequence[str]
) -> Any:
    """A matplotlib figure of all configurations in the arm's plane.

    Args:
        robot: whose `plane` there is.
        q: (k, n).
        names: of the branches.
        within: (k,) whether they are within the limits.
        count: number of configurations that there are in all.
        colours: of the configurations, taken in turn.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 6.8))
    FigureCanvasAgg(figure)
    axes: Any = figure.add_axes((0.03, 0.06, 0.94, 0.86))
    corners = [_corners(robot, row) for row in q]
    lengths = np.linalg.norm(np.diff(corners[0], axis=0), axis=1)
    annulus = reachable_annulus(lengths)
    _annulus(axes, corners[0][0], annulus.inner, annulus.outer)
    for k, (points, name) in enumerate(zip(corners, names, strict=True)):
        colour = colours[k % len(colours)]
        line = "-" if within[k] else (0, (3, 2))
        axes.plot(*points.T, color=colour, linewidth=2.6, linestyle=line, marker="o", markersize=6)
        words = visible(f"{k + 1}: {name}" if name else str(k + 1))
        away = points[1] - points[[0, -1]].mean(axis=0)
        away = 18.0 * away / max(float(np.linalg.norm(away)), PARALLEL)
        side = "left" if away[0] > 0.0 else "right"
        axes.annotate(words, points[1], away, textcoords="offset points", color=colour, ha=side, va="center")
    if len(lengths) == 2:
        _law_of_cosines(axes, corners[0])
    axes.plot(*corners[0][-1], marker="o", color=space.INK, markersize=7, zorder=6)
    axes.set_aspect("equal")
    axes.margins(0.04)
    axes.set_axis_off()
    key = "pictures.configurations" if bool(np.all(within)) else "pictures.configurations_outside"
    space.title(figure, visible(say(key, robot=robot.name, count=count)), y=0.985)
    caption = say("pictures.reach_ring", inner=f"{annulus.inner:.4g}", outer=f"{annulus.outer:.4g}")
    space.title(figure, visible(caption), y=0.05, size=9.0)
    return figure


def _corners(robot: Robot, q: Floats) -> Floats:
    """(n + 1, 2) places of the axes and of the tip in the plane."""
    mechanism, basis = robot.mechanism, plane(robot)
    assert basis is not None
    poses = np.asarray(robot.link_poses(q))
    places = [poses[mechanism.link_names.index(joint.child)][:3, 3] for joint in mechanism.coordinates]
    places.append(np.asarray(robot.forward_kinematics(q))[:3, 3])
    return np.array(places) @ basis.T


def _annulus(axes: Any, centre: Floats, inner: float, outer: float) -> None:
    """What the tip reaches, pale; its boundaries as circles."""
    from matplotlib.patches import Circle

    axes.add_patch(Circle(tuple(centre), outer, facecolor=space.PALE, alpha=0.35, linewidth=0))
    axes.add_patch(Circle(tuple(centre), inner, facecolor="white", linewidth=0))
    for radius in (inner, outer):
        axes.add_patch(Circle(tuple(centre), radius, fill=False, edgecolor=space.SOFT, linewidth=1.0))


def _law_of_cosines(axes: Any, corners: Floats) -> None:
    """The triangle of base, elbow and tip: its angles alpha at the base and beta at the elbow."""
    base, elbow, tip = corners
    axes.plot(*np.array([base, tip]).T, color=space.INK, linewidth=1.0, linestyle="--")
    for letter, corner, ends in ((r"\alpha", base, (tip, elbow)), (r"\beta", elbow, (base, tip))):
        sides = [end - corner for end in ends]
        if min(np.linalg.norm(side) for side in sides) < PARALLEL:
            continue
        first, second = (float(np.arctan2(side[1], side[0])) for side in sides)
        turn = (second - first + np.pi) % (2 * np.pi) - np.pi
        radius = 0.25 * min(float(np.linalg.norm(side)) for side in sides)
        angles = first + np.linspace(0.0, turn, 40)
        axes.plot(
            *(corner[:, None] + radius * np.array([np.cos(angles), np.sin(angles)])), color=space.INK, linewidth=1.0
        )
        middle = corner + 1.7 * radius * np.array([np.cos(first + turn / 2), np.sin(first + turn / 2)])
        ground = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.6}
        words = f"${letter}$ = {np.degrees(abs(turn)):.1f}°"
        axes.text(*middle, words, ha="center", va="center", fontsize=9, zorder=7, bbox=ground)
