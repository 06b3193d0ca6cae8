"""All configurations of an arm for one pose: one small picture for each branch, and all of them over each other.

Configurations of an arm in its plane: the annulus that its tip reaches, the law of cosines for two links.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from os import PathLike
from textwrap import wrap
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, as_batch
from mafsil.errors import InputError
from mafsil.figures import space
from mafsil.figures.space import picture_file
from mafsil.messages import say
from mafsil.messages.visible import visible
from mafsil.model import JointKind
from mafsil.model.exponentials import chain_to_tip
from mafsil.performance import reachable_annulus
from mafsil.robot import Robot, of_robot

PARALLEL = 1e-9
"""Largest sine of the angle between axes that count as parallel."""
MOST = 24
"""Configurations in one picture; more would be too small to see."""
_COLOURS = ("#2f6fd0", "#d9702a", "#2f9e57", "#7a4fb5", "#c2455d", "#16899a", "#9a7a16", "#5b6770")


@of_robot
def plot_configurations(
    robot: Robot,
    q: ArrayLike,
    path: str | PathLike[str],
    names: Sequence[str] | None = None,
    within: ArrayLike | None = None,
) -> None:
    """Draw configurations that reach the same pose into a file; arms in a plane with the ring that their tip reaches.

    Args:
        robot: whose configurations they are.
        q: (k, n) configurations [rad | m].
        path: .png, .svg or .pdf.
        names: of the branches, one for each; numbers alone if None.
        within: (k,) whether they are within the joint limits; others are drawn with broken lines.

    Raises:
        InputError: no configuration at all, wrong shapes.
    """
    path = picture_file(path)
    rows = as_batch("q", q, (robot.n,), finite=True).reshape(-1, robot.n)
    if not len(rows):
        raise InputError("pictures.no_configurations", name="q")
    labels = [""] * len(rows) if names is None else list(names)
    inside = np.ones(len(rows), np.bool_) if within is None else np.asarray(within, np.bool_)
    shown = slice(0, MOST)
    drawn = rows[shown], labels[shown], inside[shown], len(rows)
    if plane(robot) is None:
        space.save(lambda: draw_configurations(robot, *drawn), path)
    else:
        space.save(lambda: draw_planar_configurations(robot, *drawn, _COLOURS), path)


def draw_configurations(robot: Robot, q: Floats, names: Sequence[str], within: Any, count: int) -> Any:
    """A matplotlib figure: all configurations over each other first, then one panel for each.

    Args:
        robot: whose configurations they are.
        q: (k, n).
        names: of the branches.
        within: (k,) whether they are within the limits.
        count: number of configurations that there are in all.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    bones = [_bones(robot, row) for row in q]
    tip = np.asarray(robot.forward_kinematics(q[0]))
    points = np.concatenate(bones)
    length = 0.16 * max(float(np.ptp(points, axis=0).max()), 1e-6)
    columns = min(len(q) + 1, 3 if len(q) < 9 else 5)
    lines = ceil((len(q) + 1) / columns)
    figure = Figure(figsize=(2.6 * columns, 2.7 * lines + 0.5))
    FigureCanvasAgg(figure)
    top = 1.0 - 0.5 / (2.7 * lines + 0.5)
    for k in range(len(q) + 1):
        column, line = k % columns, k // columns
        place = (column / columns, top * (1 - (line + 1) / lines), 1 / columns, 0.84 * top / lines)
        axes = space.panel(figure, place)
        for j in range(len(q)) if k == 0 else (k - 1,):
            _skeleton(axes, bones[j], _COLOURS[j % len(_COLOURS)], inside=bool(within[j]), width=1.6 if k == 0 else 2.4)
        if k > 0:
            _axes(axes, robot, q[k - 1], 0.45 * length)
        space.frame(axes, tip, length)
        _floor(axes, points)
        # One cube for all panels, so that sizes compare.
        space.view(axes, points, zoom=1.35)
        words = say("pictures.configurations_all") if k == 0 else _words(k, names[k - 1])
        colour = space.INK if k == 0 else _COLOURS[(k - 1) % len(_COLOURS)]
        figure.text(
            place[0] + place[2] / 2,
            place[1] + place[3] + 0.005,
            words,
            ha="center",
            va="bottom",
            fontsize=9,
            color=colour,
        )
    key = "pictures.configurations" if bool(np.all(within)) else "pictures.configurations_outside"
    space.title(figure, visible(say(key, robot=robot.name, count=count)), y=0.995)
    return figure


def _words(k: int, name: str) -> str:
    """Number and name of a branch, in short lines."""
    return "\n".join(wrap(visible(f"{k}: {name}" if name else str(k)), 30))


def _bones(robot: Robot, q: Floats) -> Floats:
    """(j, 3) base, joints on the way, tip: the corners of the skeleton."""
    mechanism = robot.mechanism
    poses: PoseMatrix = np.asarray(robot.link_poses(q))
    order = mechanism.link_names
    path = [np.asarray(mechanism.T_sb)[:3, 3]]
    for joint in chain_to_tip(mechanism):
        path.append(poses[order.index(joint.child)][:3, 3])
    path.append(np.asarray(robot.forward_kinematics(q))[:3, 3])
    return np.array(path)


def _skeleton(axes: Any, bones: Floats, colour: str, *, inside: bool, width: float) -> None:
    space.line(axes, bones, colour, "-" if inside else (0, (3, 2)), width)  # pyright: ignore[reportArgumentType]
    axes.plot(*bones.T, linestyle="none", marker="o", color=colour, markersize=1.6 * width, zorder=4)


def _axes(axes: Any, robot: Robot, q: Floats, length: float) -> None:
    """A tick along the positive axis of every joint: it tells a flipped wrist from the other."""
    mechanism = robot.mechanism
    poses, J = np.asarray(robot.link_poses(q)), np.asarray(robot.jacobian_space(q))
    for column, joint in enumerate(mechanism.coordinates):
        place, axis = poses[mechanism.link_names.index(joint.child)][:3, 3], J[:3, column]
        space.line(axes, np.stack([place, place + length * axis]), space.INK, "-", 1.2)


def _floor(axes: Any, points: Floats) -> None:
    """A square under the base, to tell up from down."""
    half = 0.18 * float(np.ptp(points, axis=0).max())
    x, y, z = points[0]
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) * half
    axes.plot(x + corners[:, 0], y + corners[:, 1], np.full(5, z), color=space.PALE, linewidth=1.0, zorder=1)


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
