"""How closed forms find their angles: the shoulder from above, two circles in a plane, two circles on a sphere.

Newton's method in one dimension: the graph of a function, and the tangents whose zeros are the iterates.
"""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, single, whole
from mafsil.errors import InputError
from mafsil.figures import space
from mafsil.figures.performance_sheet import FORCE, INK, SHELL, SOFT, VELOCITY, flat_axes, save, sheet
from mafsil.figures.space import picture_file
from mafsil.geometry import rotation
from mafsil.ik import RootRecord, find_root
from mafsil.ik.structure.subproblems import Angles, distances, project_off_axis, two_axes
from mafsil.messages import say
from mafsil.messages.visible import visible
from mafsil.model.placement import frame_along

POINTS = 400
"""Of the graph."""
MARGIN = 0.12
"""Shown on both sides of the iterates, in parts of their range."""
_TURN = np.linspace(0.0, 2 * np.pi, 181)
_FOUND = 1e-9
"""Residuals below it, over the lengths, are solutions."""


def plot_shoulder_plan(p: ArrayLike, d: float, path: str | PathLike[str]) -> Floats:
    """Draw an arm whose plane is set off by d from axis 1, from above: both arms that lead to a wrist centre.

    theta_1 = phi - alpha with phi = atan2(p_y, p_x), alpha = atan2(d, +-sqrt(p_x^2 + p_y^2 - d^2)).

    Args:
        p: (2,) wrist centre from axis 1 [m].
        d: offset to the left of the arm's direction [m].
        path: .png, .svg or .pdf.

    Returns:
        (k,) theta_1 of the arms that there are [rad]: none inside the circle of radius |d|, one on it, else two.

    Raises:
        InputError: numbers that are not finite, a wrist on axis 1 without offset, another kind of file.
    """
    path = picture_file(path)
    point, offset = single("p", p, (2,)), float(single("d", d, ()))
    reach, size = float(np.hypot(*point)), max(float(np.hypot(*point)), abs(offset))
    if reach == 0.0 and offset == 0.0:
        raise InputError("pictures.wrist_on_axis")
    square = reach**2 - offset**2
    merged = abs(square) <= _FOUND * size**2
    rho = np.sqrt(max(square, 0.0)) * (np.ones(1) if merged else np.array([1.0, -1.0]))
    theta = np.arctan2(point[1], point[0]) - np.arctan2(offset, rho) if merged or square > 0.0 else np.zeros(0)
    save(_plan(point, offset, rho, theta), path)
    return theta


def _plan(p: Floats, d: float, rho: Floats, theta: Floats) -> Any:
    figure = sheet(5.4, 5.4)
    axes: Any = figure.add_subplot()
    axes.plot(abs(d) * np.cos(_TURN), abs(d) * np.sin(_TURN), color=SHELL, linewidth=1.0, linestyle="--")
    axes.plot(*np.array([np.zeros(2), p]).T, color=INK, linewidth=1.0, linestyle=":")
    for k, (angle, length) in enumerate(zip(theta, rho, strict=False)):
        forward, left = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        corners = np.array([np.zeros(2), d * left, d * left + length * forward])
        colour = (VELOCITY, FORCE)[k]
        axes.plot(*corners.T, color=colour, linewidth=2.4, marker="o", markersize=5)
        words = rf"$\theta_1 = {np.degrees(angle):.1f}°$, $\alpha = {np.degrees(np.arctan2(d, length)):.1f}°$"
        axes.plot([], [], color=colour, label=words)
    axes.plot(*p, "o", color=INK, markersize=7, zorder=5)
    axes.plot([], [], color=INK, linestyle=":", label=rf"$\varphi = {np.degrees(np.arctan2(p[1], p[0])):.1f}°$")
    axes.plot([], [], color=SHELL, linestyle="--", label=f"$|d| = {abs(d):.4g}$ m")
    flat_axes(axes, "x [m]", "y [m]")
    axes.legend(fontsize=8, frameon=False, loc="best")
    key = "pictures.shoulder_plan" if len(theta) else "pictures.shoulder_inside"
    axes.set_title(visible(say(key, count=len(theta))), fontsize=10, color=INK)
    return figure


def plot_distance_construction(w: ArrayLike, r: ArrayLike, p: ArrayLike, c: float, path: str | PathLike[str]) -> Angles:
    """Draw the turns about an axis that bring a point to a given distance from the origin, seen along the axis.

    The point runs on a circle about the axis; what is c from the origin is a circle of radius sqrt(c^2 - (p . w)^2)
    about it. They meet in 0, 1 or 2 points, theta = psi +- phi.

    Args:
        w: (3,) unit axis.
        r: (3,) a point of it [m].
        p: (3,) the point that is turned [m].
        c: distance [m].
        path: .png, .svg or .pdf.

    Returns:
        The turns, as `mafsil.ik.subproblems.distances` finds them.

    Raises:
        InputError: shapes, numbers that are not finite, another kind of file.
    """
    path = picture_file(path)
    axis, place, point = single("w", w, (3,)), single("r", r, (3,)), single("p", p, (3,))
    found = distances(axis, place, point, c)
    across = frame_along(axis)[:, :2].T
    centre, arm = across @ project_off_axis(axis, place), across @ project_off_axis(axis, point - place)
    square = float(c) ** 2 - float(point @ axis) ** 2
    turned = [centre + _turn(float(q)) @ arm for q in found.solutions(_FOUND * max(1.0, float(np.abs(point).max())))]
    save(_circles(centre, arm, square, np.reshape(turned, (-1, 2))), path)
    return found


def _turn(q: float) -> Floats:
    return np.array([[np.cos(q), -np.sin(q)], [np.sin(q), np.cos(q)]])


def _circles(centre: Floats, arm: Floats, square: float, met: Floats) -> Any:
    figure = sheet(5.4, 5.4)
    axes: Any = figure.add_subplot()
    circle = np.array([np.cos(_TURN), np.sin(_TURN)])
    axes.plot(*(centre[:, None] + np.hypot(*arm) * circle), color=VELOCITY, linewidth=1.6)
    if square >= 0.0:
        axes.plot(*(np.sqrt(square) * circle), color=FORCE, linewidth=1.6)
    axes.plot(*np.array([np.zeros(2), centre, centre + arm]).T, color=INK, linewidth=1.0, linestyle="--")
    for q in met:
        axes.plot(*np.array([centre, q]).T, color=VELOCITY, linewidth=1.0)
        axes.plot(*np.array([np.zeros(2), q]).T, color=FORCE, linewidth=1.0)
    axes.plot(*met.T, "o", color=INK, markersize=7, zorder=5)
    for name, place in (("0", np.zeros(2)), ("w", centre), ("p", centre + arm)):
        axes.plot(*place, "o", color=INK, markersize=4)
        axes.annotate(f"${name}$", place, (6, 6), textcoords="offset points", color=INK)
    flat_axes(axes, "", "")
    axes.set_title(visible(say("pictures.distance_circles", count=len(met))), fontsize=10, color=INK)
    return figure


def plot_sphere_construction(
    w1: ArrayLike, w2: ArrayLike, p: ArrayLike, z: ArrayLike, path: str | PathLike[str]
) -> Angles:
    """Draw the turns about two crossing axes that bring p to z: two circles on a sphere and where they meet.

    Turned about w2, p runs on a circle; the places from which w1 leads to z are another. Rot(w1, q1) Rot(w2, q2) p = z.

    Args:
        w1, w2: (3,) unit axes, not parallel.
        p, z: (3,) start and goal, equally far from where the axes cross [m].
        path: .png, .svg or .pdf.

    Returns:
        The pairs of angles, as `mafsil.ik.subproblems.two_axes` finds them.

    Raises:
        InputError: shapes, numbers that are not finite, points at the crossing, another kind of file.
    """
    path = picture_file(path)
    first, second = single("w1", w1, (3,)), single("w2", w2, (3,))
    start, goal = single("p", p, (3,)), single("z", z, (3,))
    radius = float(np.linalg.norm(start))
    if radius == 0.0 or not np.any(goal):
        raise InputError("pictures.at_the_crossing")
    found = two_axes(first, second, start, goal)
    turned = [rotation.exp(row[1] * second) @ start for row in found.solutions(_FOUND * radius)]
    met = np.reshape(turned, (-1, 3))
    space.save(lambda: _sphere(first, second, start, goal, met), path)
    return found


def _sphere(w1: Floats, w2: Floats, p: Floats, z: Floats, met: Floats) -> Any:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.6, 5.6))
    FigureCanvasAgg(figure)
    axes = space.panel(figure, (0.0, 0.0, 1.0, 0.93))
    radius = float(np.linalg.norm(p))
    up, around = np.linspace(0.0, np.pi, 25), _TURN[::6]
    rings = np.outer(np.sin(up), np.cos(around)), np.outer(np.sin(up), np.sin(around))
    ball = radius * np.array([*rings, np.outer(np.cos(up), np.ones(len(around)))])
    axes.plot_wireframe(*ball, color=SOFT, linewidth=0.5)
    for name, w, point, colour in (("w_2", w2, p, VELOCITY), ("w_1", w1, z, FORCE)):
        space.line(axes, rotation.exp(_TURN[:, None] * w) @ point, colour, "-", 2.0)
        space.arrow(axes, np.zeros(3), 1.25 * radius * w, colour, 1.4)
        space.label(axes, 1.35 * radius * w, f"${name}$", colour)
    for name, point in (("p", p), ("z", z)):
        axes.plot(*point[:, None], marker="o", color=INK, markersize=5)
        space.label(axes, 1.12 * point, f"${name}$", INK)
    for point in met:
        axes.plot(*point[:, None], marker="D", color=INK, markersize=7, zorder=6)
    space.view(axes, 1.15 * radius * np.vstack([np.eye(3), -np.eye(3)]))
    space.title(figure, visible(say("pictures.sphere_circles", count=len(met))), y=0.98)
    return figure


def plot_newton_tangents(
    f: Callable[[Floats], ArrayLike],
    start: float,
    path: str | PathLike[str],
    jacobian: Callable[[Floats], ArrayLike] | None = None,
    *,
    steps: int = 4,
) -> RootRecord:
    """Draw the first steps of Newton's method for f(x) = 0: each goes along the tangent at an iterate to its zero.

    Args:
        f: of x (1,), to (1,).
        start: first iterate.
        path: .png, .svg or .pdf.
        jacobian: of x (1,), to (1, 1); central differences if None.
        steps: most steps that are drawn.

    Returns:
        The iteration that was drawn.

    Raises:
        InputError: no function, f not of one number, a slope of zero or a root at the start, another kind of file.
    """
    path, most = picture_file(path), whole("steps", steps)
    record = find_root(f, [start], jacobian, max_steps=most)
    if not record.iterations:
        raise InputError("pictures.no_tangent", start=f"{start:g}")
    save(_drawn(f, record), path)
    return record


def _drawn(f: Callable[[Floats], ArrayLike], record: RootRecord) -> Any:
    x, y = record.iterates[:, 0], record.values[:, 0]
    margin = MARGIN * float(np.ptp(x)) or 1.0
    first: float = x.min() - margin
    last: float = x.max() + margin
    graph = np.linspace(first, last, POINTS)
    figure = sheet(6.0, 4.2)
    axes: Any = figure.add_subplot()
    axes.axhline(0.0, color=INK, linewidth=0.8)
    axes.plot(graph, [float(np.ravel(f(np.array([one])))[0]) for one in graph], color=VELOCITY, linewidth=1.8)
    for k in range(record.iterations):
        axes.plot([x[k], x[k]], [0.0, y[k]], color=SHELL, linewidth=1.0, linestyle="--")
        axes.plot([x[k], x[k + 1]], [y[k], 0.0], color=FORCE, linewidth=1.3)
        axes.plot(x[k], y[k], "o", color=FORCE, markersize=4)
    shown = np.abs(np.subtract.outer(x, x)) + np.triu(np.full((len(x), len(x)), np.inf))
    for k in np.flatnonzero(shown.min(axis=1) > 0.04 * np.ptp(x)):
        axes.annotate(f"$x_{{{k}}}$", (x[k], 0.0), (0, -14), textcoords="offset points", ha="center", color=INK)
    flat_axes(axes, "$x$", "$f(x)$", equal=False)
    return figure
