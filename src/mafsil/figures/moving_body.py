"""Pictures that explain twists, wrenches and screws seen from two frames."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, Vector3, single
from mafsil.errors import InputError
from mafsil.figures import space
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import membership, pose, rotation, screw, twist, wrench
from mafsil.geometry.logarithms import ball_points
from mafsil.messages import say


def plot_rotation_vector_ball(R: ArrayLike, path: str | PathLike[str]) -> None:
    """Draw the solid ball of radius pi and the rotation as a point of it; of a half turn both names on the rim.

    Args:
        R: (3, 3) rotation.
        path: .png, .svg or .pdf.
    """
    matrix = rotation.check(single("R", R, (3, 3)))
    space.save(lambda: draw_solid_ball(matrix), Path(path))


def draw_solid_ball(R: Floats) -> Any:
    """A matplotlib figure of the solid ball; arguments as for `plot_rotation_vector_ball`."""
    figure, axes = space.sheet()
    turns = np.linspace(0, 2 * np.pi, 73)
    circle = np.pi * np.stack([np.cos(turns), np.sin(turns), np.zeros(73)], axis=-1)
    for order in ((0, 1, 2), (2, 0, 1), (1, 2, 0)):
        space.line(axes, circle[:, order], space.PALE, "-", 1.0)
    points = ball_points(R)
    for k, r in enumerate(points):
        space.arrow(axes, np.zeros(3), r, space.ACCENT if k == 0 else space.SECOND, 2.0, 0.1)
        space.label(axes, 1.1 * r, "$r$" if k == 0 else "$-r$", space.ACCENT if k == 0 else space.SECOND)
    if len(points) == 2:
        space.line(axes, points, space.SOFT, "--")
    key = "pictures.ball_rim" if len(points) == 2 else "pictures.ball"
    space.title(figure, say(key, angle=f"{np.degrees(np.linalg.norm(points[0])):.4g}"))
    space.view(axes, np.concatenate([circle, circle[:, (2, 0, 1)]]))
    return figure


def plot_displaced_body(X_ai: ArrayLike, X_af: ArrayLike, path: str | PathLike[str]) -> None:
    """Draw a body before and after a displacement, and the frame {b} that names it: T_ba = X_af X_ai^-1.

    {b} stands to the body before as {a} stands to the body after.

    Args:
        X_ai, X_af: (4, 4) poses of the body in {a}, initial and final.
        path: .png, .svg or .pdf.
    """
    before, after = (membership.require("pose", name, single(name, X, (4, 4))) for name, X in
                     (("X_ai", X_ai), ("X_af", X_af)))  # fmt: skip
    space.save(lambda: draw_displaced_body(before, after), Path(path))


def draw_displaced_body(X_ai: PoseMatrix, X_af: PoseMatrix) -> Any:
    """A matplotlib figure of a displacement and {b}; arguments as for `plot_displaced_body`."""
    figure, axes = space.sheet()
    T_ab = pose.compose(X_ai, pose.inverse(X_af))
    named = (("a", np.eye(4)), ("b", T_ab), ("i", X_ai), ("f", X_af))
    origins = np.stack([T[:3, 3] for _, T in named])
    length = 0.3 * max(float(np.ptp(origins, axis=0).max()), 1e-3)
    for name, T in named:
        space.frame(axes, T, length, name)
    for start, end in ((0, 3), (1, 2)):  # the same step twice: {a} to the body after, {b} to the body before
        space.line(axes, origins[[start, end]], space.ACCENT, "--", 1.4)
    space.title(figure, say("pictures.displaced_body"))
    space.view(axes, np.vstack([origins, *(T[:3, 3] + length * T[:3, :3].T for _, T in named)]))
    return figure


def plot_two_frames(
    T_ab: ArrayLike, path: str | PathLike[str], *, S_b: ArrayLike | None = None, F_b: ArrayLike | None = None
) -> None:
    """Draw one screw, or one wrench, in two frames, with its numbers in both.

    Args:
        T_ab: (4, 4) pose of {b} in {a}.
        path: .png, .svg or .pdf.
        S_b: (6,) unit screw in {b}.
        F_b: (6,) wrench (m, f) in {b} [N m, N]; one of both is given.
    """
    T = membership.require("pose", "T_ab", single("T_ab", T_ab, (4, 4)))
    if (S_b is None) == (F_b is None):
        raise InputError("pictures.one_of", names="S_b, F_b")
    is_wrench = F_b is not None
    given = single("F_b" if is_wrench else "S_b", F_b if F_b is not None else np.asarray(S_b), (6,))
    space.save(lambda: draw_two_frames(T, given, is_wrench=is_wrench), Path(path))


def draw_two_frames(T_ab: PoseMatrix, given: Floats, *, is_wrench: bool) -> Any:
    """A matplotlib figure of a screw or a wrench in {b}, seen from {a} too; arguments as for `plot_two_frames`."""
    figure, axes = space.sheet()
    in_a = wrench.transform(pose.inverse(T_ab), given) if is_wrench else twist.transform(T_ab, given)
    directed, point = _line(in_a, is_wrench=is_wrench)
    size = max(float(np.linalg.norm(T_ab[:3, 3])), float(np.linalg.norm(point)), 1e-3)
    space.frame(axes, np.eye(4), 0.4 * size, "a")
    space.frame(axes, T_ab, 0.4 * size, "b")
    ends = np.stack([point - 0.8 * size * directed, point + 0.8 * size * directed])
    space.line(axes, ends, space.INK, "-.")
    space.arrow(axes, point, 0.5 * size * directed, space.ACCENT, 2.4)
    letter = "F" if is_wrench else "S"
    space.label(axes, point + 0.6 * size * directed, f"${letter}$", space.ACCENT)
    for origin, name in ((np.zeros(3), "a"), (T_ab[:3, 3], "b")):
        foot = point + directed * float(directed @ (origin - point))
        space.line(axes, np.stack([origin, foot]), space.SOFT, "--")
        space.label(axes, (origin + foot) / 2, f"$r_{name}$", space.SOFT)
    numbers = "   ".join(f"{letter}_{name} = {_six(x)}" for name, x in (("a", in_a), ("b", given)))
    space.title(figure, numbers, size=8.5)
    space.view(axes, np.vstack([ends, np.zeros(3), T_ab[:3, 3] + 0.4 * size * T_ab[:3, :3].T]))
    return figure


def plot_space_velocity(T_sb: ArrayLike, V_s: ArrayLike, path: str | PathLike[str]) -> None:
    """Draw the meaning of v_s: the velocity of the body's point at the origin of {s}.

    Args:
        T_sb: (4, 4) pose of the body.
        V_s: (6,) its space twist.
        path: .png, .svg or .pdf.
    """
    T = membership.require("pose", "T_sb", single("T_sb", T_sb, (4, 4)))
    V = single("V_s", V_s, (6,))
    space.save(lambda: draw_space_velocity(T, V), Path(path))


def draw_space_velocity(T_sb: PoseMatrix, V_s: Floats) -> Any:
    """A matplotlib figure of a space twist; arguments as for `plot_space_velocity`."""
    figure, axes = space.sheet()
    origin = T_sb[:3, 3]
    size = max(float(np.linalg.norm(origin)), 1e-3)
    velocity = twist.point_velocity(V_s, origin)
    scale = 0.6 * size / max(float(np.linalg.norm(V_s[3:])), float(np.linalg.norm(velocity)), 1e-12)
    space.frame(axes, np.eye(4), 0.35 * size, "s")
    space.frame(axes, T_sb, 0.35 * size, "b")
    space.line(axes, np.stack([np.zeros(3), origin]), space.PALE, "-", 7.0)  # the body, reaching to {s}
    space.arrow(axes, np.zeros(3), scale * V_s[3:], space.ACCENT, 2.4)
    space.label(axes, 1.15 * scale * V_s[3:], "$v_s$", space.ACCENT)
    space.arrow(axes, origin, scale * velocity, space.SECOND, 2.4)
    space.label(axes, origin + 1.15 * scale * velocity, r"$\dot p$", space.SECOND)
    ends = [np.zeros(3), origin, scale * V_s[3:], origin + scale * velocity]
    if V_s[:3].any():
        axis, point = _line(V_s, is_wrench=False)
        line = np.stack([point - 0.5 * size * axis, point + 0.9 * size * axis])
        space.line(axes, line, space.INK, "-.")
        space.label(axes, line[1], r"$\omega$")
        ends += list(line)
    space.title(figure, say("pictures.space_velocity"))
    space.view(axes, np.vstack(ends))
    return figure


def _line(vector: Floats, *, is_wrench: bool) -> tuple[Vector3, Vector3]:
    """Unit direction and nearest point of the axis; of couples and translations through the origin."""
    both = np.concatenate([vector[3:], vector[:3]]) if is_wrench else vector
    directed = both[:3] if both[:3].any() else both[3:]
    point = screw.nearest_point(both) if both[:3].any() else np.zeros(3)
    return directed / max(float(np.linalg.norm(directed)), LEAST_DIVISOR), np.asarray(point)


def _six(x: Floats) -> str:
    return "(" + ", ".join(f"{0.0 if abs(value) < 5e-10 else value:.3g}" for value in x) + ")"
