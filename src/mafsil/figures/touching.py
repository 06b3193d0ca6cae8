"""Touching in pictures: what a surface blocks and leaves free, and what a hand feels of a device."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, positive, real_array, require_finite, require_kind
from mafsil.control import Impedance, TaskConstraint
from mafsil.control.analysis.linearization import exponential
from mafsil.errors import InputError
from mafsil.figures import space
from mafsil.figures.motion_over_time import COLOURS
from mafsil.figures.performance_sheet import FORCE, INK, SHELL, flat_axes, save, sheet
from mafsil.figures.space import picture_file
from mafsil.geometry import pose
from mafsil.messages import say
from mafsil.messages.tables import number

PLACES, DECAYS = 400, 6.0
"""Of a curve, and slowest time constants that it shows."""
TURNS, HALF_COIL = 6, 0.12
"""Of a drawn spring, and half its width; the drawing is about four wide."""
THICK = 0.6
"""Height of the eraser, as a share of its width."""


def plot_constrained_task(
    T_sb: ArrayLike,
    constraints: Sequence[TaskConstraint],
    path: str | PathLike[str],
    *,
    half_width: float = 0.02,
    half_board: float = 0.08,
    language: str | None = None,
) -> None:
    """Draw an eraser on a board with the frames {s} of the board and {b} of the eraser, and its constraints beside.

    Args:
        T_sb: (4, 4) pose of the eraser in the frame of the board, whose z axis points out of it.
        constraints: of `mafsil.control.constraint_table`.
        path: .png, .svg or .pdf.
        half_width, half_board: of the eraser and of the board [m].
        language: of the words; the current one if None.

    Raises:
        InputError: no pose, no constraints, a width that is not positive, or an ending of no picture.
    """
    file = picture_file(path)
    T = pose.check(T_sb, "T_sb")
    for k, each in enumerate(constraints):
        require_kind(f"constraints[{k}]", each, "TaskConstraint", "natural", "artificial")
    w, board = positive("half_width", half_width), positive("half_board", half_board)
    space.save(lambda: _constrain(T, constraints, w, board, language), file)


def _constrain(
    T: PoseMatrix, constraints: Sequence[TaskConstraint], w: float, board: float, language: str | None
) -> Any:
    """Board, eraser and frames in space; the table under them."""
    figure, axes = space.sheet(6.4, 5.8)
    plate = board * np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    plate += np.array([T[0, 3], T[1, 3], 0.0])
    _faces(axes, [plate], space.PALE, 0.35)
    _faces(axes, _box(T, w), FORCE, 0.45)
    corner = np.eye(4)
    corner[:3, 3] = plate[0] + [0.15 * board, 0.15 * board, 0.0]
    space.frame(axes, corner, 0.5 * board, "s")
    space.frame(axes, T, 2.2 * w, "b")
    reach = T[:3, 3] + 2.6 * w * T[:3, 2]
    space.view(axes, np.vstack([plate, reach, _box(T, w)[0]]), 1.1)
    heads = [say(f"pictures.{name}", language=language) for name in ("natural", "artificial")]
    # Signs, no sentences: they are read from left to right in every language.
    for x, head, lines in zip(
        (0.16, 0.58), heads, ([c.natural for c in constraints], [c.artificial for c in constraints]), strict=True
    ):
        figure.text(x, 0.985, head, ha="left", va="top", fontsize=10, color=space.INK, fontweight="bold")
        for k, line in enumerate(lines):
            figure.text(x, 0.945 - 0.034 * k, line, ha="left", va="top", fontsize=9, color=space.INK)
    return figure


def _box(T: PoseMatrix, w: float) -> list[Floats]:
    """The six faces of an eraser that stands on its frame's x-y plane, in {s}."""
    low, high = 0.0, 2.0 * THICK * w
    x, y, z = np.meshgrid([-w, w], [-w, w], [low, high], indexing="ij")
    corners = np.stack([x, y, z], axis=-1) @ T[:3, :3].T + T[:3, 3]
    faces: list[Floats] = []
    for axis in range(3):
        for side in range(2):
            four = np.take(corners, side, axis=axis)
            faces.append(np.array([four[0, 0], four[0, 1], four[1, 1], four[1, 0]]))
    return faces


def _faces(axes: Any, faces: list[Floats], colour: str, opacity: float) -> None:
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    axes.add_collection3d(
        Poly3DCollection(faces, facecolors=colour, edgecolors=space.INK, linewidths=0.6, alpha=opacity, zorder=2)
    )


def plot_virtual_impedance(
    impedance: Impedance, path: str | PathLike[str], *, push: float = 1.0, language: str | None = None
) -> None:
    """Draw the virtual impedance of a haptic device in one direction and its response to a push.

    Args:
        impedance: of one direction, with a mass.
        path: .png, .svg or .pdf.
        push: constant force of the hand from time 0 on [N].
        language: of the words; the current one if None.

    Raises:
        InputError: an impedance of several directions or without mass, a push that is not finite, or an ending of no
            picture.
    """
    file = picture_file(path)
    require_kind("impedance", impedance, "Impedance", "inertia", "damping", "stiffness")
    if impedance.inertia.shape != (1, 1):
        raise InputError("input.shape", name="impedance", expected=(1, 1), got=impedance.inertia.shape, hint="")
    m, b, k = (float(part[0, 0]) for part in (impedance.inertia, impedance.damping, impedance.stiffness))
    if not m > 0.0:
        raise InputError("control.no_virtual_mass")
    force = float(require_finite("push", real_array("push", push)))
    figure = sheet(8.0, 3.0)
    drawing, response = figure.subplots(1, 2, width_ratios=(1.15, 1.0))
    _felt(drawing, {"m": f"{number(m)} kg", "b": f"{number(b)} N s/m", "k": f"{number(k)} N/m"}, force, language)
    t, x = push_response(m, b, k, force)
    curves: Any = response
    curves.plot(t, x, color=COLOURS[0], linewidth=1.4)
    if k > 0.0:
        curves.axhline(force / k, color=FORCE, linewidth=0.8, linestyle="--")
    flat_axes(curves, "t [s]", say("pictures.displacement", language=language), equal=False)
    save(figure, file)


def push_response(mass: float, damping: float, stiffness: float, force: float) -> tuple[Floats, Floats]:
    """Times (k,) [s] and displacements (k,) [m] of m x'' + b x' + k x = F from rest, exactly.

    Args:
        mass, damping, stiffness: m, b, k.
        force: F [N].
    """
    rates = -np.roots([mass, damping, stiffness]).real
    slow = float(rates[rates > 0.0].min(initial=np.inf))
    period = 2.0 * np.pi * np.sqrt(mass / stiffness) if stiffness > 0.0 else 1.0
    t = np.linspace(0.0, min(DECAYS / slow, 20.0 * period) if np.isfinite(slow) else 5.0 * period, PLACES)
    step = np.zeros((3, 3))
    step[0, 1] = 1.0
    step[1] = np.array([-stiffness, -damping, force]) / mass
    states = exponential(step * t[:, None, None]) @ np.array([0.0, 0.0, 1.0])
    return t, states[:, 0]


def _felt(axes: Any, words: dict[str, str], push: float, language: str | None) -> None:
    """A wall, spring and damper side by side, the mass, and the hand that pushes it; what is virtual is dashed."""
    axes.set(xlim=(-0.35, 3.9), ylim=(-0.95, 1.15))
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.plot([0.0, 0.0], [-0.6, 0.6], color=INK, linewidth=1.6)
    for y in np.linspace(-0.6, 0.5, 7):
        axes.plot([-0.14, 0.0], [y, y + 0.12], color=INK, linewidth=0.8)
    coil = np.linspace(0.35, 1.25, 4 * TURNS + 1)
    swing = HALF_COIL * np.sin(np.arange(4 * TURNS + 1) * np.pi / 2.0)
    spring = np.column_stack([[0.0, *coil, 1.6], 0.3 + np.array([0.0, *swing, 0.0])])
    axes.plot(*spring.T, color=COLOURS[0], linewidth=1.2)
    for piece in (
        [(0.0, -0.3), (0.6, -0.3)], [(1.1, -0.18), (0.6, -0.18), (0.6, -0.42), (1.1, -0.42)],
        [(0.85, -0.2), (0.85, -0.4)], [(0.85, -0.3), (1.6, -0.3)],
    ):  # fmt: skip
        axes.plot(*np.array(piece).T, color=COLOURS[1], linewidth=1.2)
    body = np.array([(1.6, -0.5), (2.4, -0.5), (2.4, 0.5), (1.6, 0.5), (1.6, -0.5)])
    axes.fill(*body.T, color=SHELL, alpha=0.25)
    axes.plot(*body.T, color=INK, linewidth=1.2, linestyle="--")
    side = 1.0 if push < 0.0 else -1.0
    ends = ((2.4, 0.0), (3.3, 0.0))
    start, end = ends if side < 0.0 else ends[::-1]
    axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": FORCE, "linewidth": 1.8})
    hand = say("pictures.hand", language=language)
    axes.text(2.85, 0.16, f"F = {number(push)} N", ha="center", fontsize=8, color=FORCE)
    axes.text(2.85, -0.3, hand, ha="center", fontsize=8, color=INK)
    for (x, y), name in (((0.8, 0.55), "k"), ((0.85, -0.72), "b"), ((2.0, -0.05), "m")):
        axes.text(x, y, f"{name} = {words[name]}" if name != "m" else words[name], ha="center", fontsize=8, color=INK)
    axes.text(2.0, 0.7, say("pictures.virtual", language=language), ha="center", fontsize=8, color=INK)
