"""Pictures of parallel robots: platforms on legs with their vectors, Delta, Eclipse, five-bars, curves of four-bars.

Driven joints are filled circles, passive ones open; a blocked velocity is a dotted line through the point.
"""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, single
from mafsil.figures import space
from mafsil.figures.space import picture_file
from mafsil.geometry import pose
from mafsil.messages import say
from mafsil.messages.visible import visible
from mafsil.mobility import FourBar
from mafsil.parallel import (
    DeltaRobot,
    Eclipse,
    FiveBar,
    LegMechanism,
    LoopSingularities,
    PlanarThreeRPR,
    StewartPlatform,
)
from mafsil.parallel.planar import output_angles, singular_points

GROUND, PLATFORM, LEG, DRIVEN = "#8a949c", "#2f6fd0", "#39424a", "#2e8b57"
MEETING = 1e-9
"""Reciprocal product and sine of two unit axes below which they meet, or are parallel."""
SAMPLES = 1441
"""Angles of the crank along the curve of a four-bar: a quarter of a degree apart."""


def plot_platform(robot: StewartPlatform, T: ArrayLike, path: str | PathLike[str]) -> None:
    """A platform on six legs in a pose (4, 4), with a_1, b_1, d_1 and p as arrows.

    Args:
        robot: its geometry.
        T: pose T_sb.
        path: .png, .svg or .pdf.
    """
    place = single("T", T, (4, 4))
    space.save(lambda: draw_platform(robot, place), picture_file(path))


def draw_platform(robot: StewartPlatform, T: Floats) -> Any:
    """The picture of `plot_platform` as a matplotlib figure."""
    figure, axes = space.sheet()
    d = robot.leg_vectors(T)
    ends = robot.base + d
    _outline(axes, robot.base, GROUND)
    _outline(axes, ends, PLATFORM)
    for a, b in zip(robot.base, ends, strict=True):
        space.line(axes, np.stack([a, b]), LEG, width=1.8)
        axes.plot(*((a + b) / 2)[:, None], marker="s", color=DRIVEN, markersize=5, zorder=6)
    size = 0.35 * robot.size
    space.frame(axes, np.eye(4), size, "s")
    space.frame(axes, T, size, "b")
    p = T[:3, 3]
    for start, step, name in ((np.zeros(3), robot.base[0], "a_1"), (p, ends[0] - p, "b_1"), (np.zeros(3), p, "p")):
        space.arrow(axes, start, step, space.ACCENT, 1.3, 0.08)
        space.label(axes, start + 0.55 * step, f"${name}$", space.ACCENT)
    space.label(axes, robot.base[0] + 0.6 * d[0], "$d_1$")
    space.view(axes, np.concatenate([robot.base, ends, np.zeros((1, 3))]))
    space.title(figure, visible(say("parallel.picture_platform")))
    return figure


def plot_delta(robot: DeltaRobot, q: ArrayLike, path: str | PathLike[str]) -> None:
    """A Delta robot at angles (3,) of its motors, in the lower of both places.

    Args:
        robot: its lengths.
        q: angles that it reaches [rad].
        path: .png, .svg or .pdf.
    """
    angle = single("q", q, (3,))
    space.save(lambda: draw_delta(robot, angle), picture_file(path))


def draw_delta(robot: DeltaRobot, q: Floats) -> Any:
    """The picture of `plot_delta` as a matplotlib figure."""
    figure, axes = space.sheet()
    p = robot.forward_kinematics(q).x[0]
    u = robot.directions
    hinges, corners = robot.base * u, p + robot.platform * u
    elbows = robot.elbows(q) + robot.platform * u
    _outline(axes, hinges, GROUND)
    _outline(axes, corners, PLATFORM)
    across = 0.12 * robot.arm * np.stack([-u[:, 1], u[:, 0], u[:, 2]], axis=1)
    for hinge, elbow, corner, side in zip(hinges, elbows, corners, across, strict=True):
        space.line(axes, np.stack([hinge, elbow]), LEG, width=3.0)
        for sign in (-1, 1):
            space.line(axes, np.stack([elbow, corner]) + sign * side, LEG, width=1.2)
        space.line(axes, np.stack([elbow - side, elbow + side]), LEG)
        axes.plot(*hinge[:, None], marker="o", color=DRIVEN, markersize=7, zorder=6)
    space.frame(axes, pose.from_translation(p), 0.25 * robot.base, "b")
    space.view(axes, np.concatenate([hinges, elbows, corners]))
    space.title(figure, visible(say("parallel.picture_delta")))
    return figure


def plot_eclipse(robot: Eclipse, T: ArrayLike, path: str | PathLike[str]) -> None:
    """The Eclipse machine in a pose (4, 4): circle, columns, blocks, rods, platform.

    Args:
        robot: its lengths.
        T: pose T_sb that it reaches.
        path: .png, .svg or .pdf.
    """
    place = single("T", T, (4, 4))
    space.save(lambda: draw_eclipse(robot, place), picture_file(path))


def draw_eclipse(robot: Eclipse, T: Floats) -> Any:
    """The picture of `plot_eclipse` as a matplotlib figure."""
    figure, axes = space.sheet()
    feet, joints = robot.feet(T), robot.platform_joints(T)
    turn = np.linspace(0, 2 * np.pi, 181)
    circle = robot.guide * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    space.line(axes, circle, GROUND, width=2.0)
    _outline(axes, joints, PLATFORM)
    for foot, end in zip(feet, joints, strict=True):
        ground = foot * [1, 1, 0]
        space.line(axes, np.stack([ground, foot]), GROUND, width=3.0)
        space.line(axes, np.stack([foot, end]), LEG, width=1.8)
        for place in (ground, foot):
            axes.plot(*place[:, None], marker="s", color=DRIVEN, markersize=6, zorder=6)
    space.frame(axes, T, 0.3 * robot.guide, "b")
    space.view(axes, np.concatenate([circle, feet, joints]))
    space.title(figure, visible(say("parallel.picture_eclipse")))
    return figure


def plot_planar_platform(robot: PlanarThreeRPR, x: ArrayLike, path: str | PathLike[str]) -> None:
    """A planar platform on three legs in a pose (x, y, phi), with a_i, b_i, d_i and p.

    Args:
        robot: its hinges.
        x: (3,) pose [m, rad].
        path: .png, .svg or .pdf.
    """
    place = single("x", x, (3,))
    space.save(lambda: draw_planar_platform(robot, place), picture_file(path))


def draw_planar_platform(robot: PlanarThreeRPR, x: Floats) -> Any:
    """The picture of `plot_planar_platform` as a matplotlib figure."""
    figure, axes = _flat_sheet()
    d = robot.leg_vectors(x)
    ends, p = robot.base + d, x[:2]
    axes.fill(*ends.T, facecolor=PLATFORM, alpha=0.18, edgecolor=PLATFORM, zorder=1)
    for k, (a, b) in enumerate(zip(robot.base, ends, strict=True), start=1):
        axes.plot(*np.stack([a, b]).T, color=LEG, linewidth=1.8, zorder=2)
        axes.plot(*a, marker="o", markerfacecolor="white", color=GROUND, markersize=7, zorder=3)
        axes.plot(*b, marker="o", markerfacecolor="white", color=PLATFORM, markersize=7, zorder=3)
        axes.plot(*((a + b) / 2), marker="s", color=DRIVEN, markersize=6, zorder=3)
        _word(axes, a + 0.6 * (b - a), f"$d_{k}$", LEG)
        for start, step, name in ((np.zeros(2), a, f"a_{k}"), (p, b - p, f"b_{k}")):
            _vector(axes, start, step, f"${name}$")
    _vector(axes, np.zeros(2), p, "$p$")
    _finish(figure, axes, say("parallel.picture_planar"))
    return figure


def plot_five_bar(robot: FiveBar, theta: ArrayLike, path: str | PathLike[str], driven: Sequence[int] = (0, 4)) -> None:
    """A five-bar at relative angles (4,): driven joints filled, a blocked velocity of C as a dotted line.

    Args:
        robot: its lengths.
        theta: (4,) angles that close it [rad].
        path: .png, .svg or .pdf.
        driven: joints that are driven, counted from 0.
    """
    angles = single("theta", theta, (4,))
    found = robot.singularity(angles, driven)
    space.save(lambda: draw_five_bar(robot, angles, found), picture_file(path))


def draw_five_bar(robot: FiveBar, theta: Floats, found: LoopSingularities) -> Any:
    """The picture of `plot_five_bar` as a matplotlib figure; its heading is what was found."""
    figure, axes = _flat_sheet()
    s = np.cumsum(theta)
    steps = robot.chain.lengths[:4, None] * np.stack([np.cos(s), np.sin(s)], axis=1)
    places = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    axes.plot(*places.T, color=LEG, linewidth=2.5, zorder=2)
    axes.plot([0, robot.ground], [0, 0], color=GROUND, linewidth=1.2, linestyle="--", zorder=1)
    for k, place in enumerate(places):
        filled = k in found.driven.driven
        axes.plot(
            *place, marker="o", markersize=9, color=DRIVEN if filled else LEG,
            markerfacecolor=DRIVEN if filled else "white", zorder=4,
        )  # fmt: skip
    _numbers(axes, places, robot.chain.size)
    for along in found.blocked.T:
        reach = 0.5 * robot.chain.size * np.stack([-along, along])
        axes.plot(*(places[2] + reach).T, color=space.AXES[0], linestyle=":", linewidth=1.8, zorder=3)
    # Links on one line are no picture by themselves.
    middle, half = places[:, 1].mean(), max(float(np.ptp(places[:, 1])) / 2, 0.25 * robot.chain.size)
    axes.plot([0.0, 0.0], [middle - half, middle + half], alpha=0.0)
    _finish(figure, axes, say(f"parallel.picture_{found.status.key.removeprefix('parallel.')}"))
    return figure


def _numbers(axes: Any, places: Floats, size: float) -> None:
    """Numbers of joints away from the links that meet there; joints in one place share their words."""
    around = np.vstack([places[-1:], places, places[:1]])
    done: set[int] = set()
    for k, place in enumerate(places):
        if k in done:
            continue
        here = np.flatnonzero(np.linalg.norm(places - place, axis=1) < 1e-6 * size).tolist()
        done.update(here)
        away = sum((2 * place - around[j] - around[j + 2] for j in here), np.zeros(2))
        bent = len(here) == 1 and np.linalg.norm(away) > 0.1 * size and abs(np.ptp(places[:, 1])) > 0.05 * size
        step = away / np.linalg.norm(away) if bent else np.array([0.0, 1.0])
        _word(axes, place + 0.11 * size * step, ", ".join(str(j + 1) for j in here), LEG)


def plot_legs(mechanism: LegMechanism, q: ArrayLike, path: str | PathLike[str]) -> None:
    """A platform on any legs: joints as circles (turning) and squares (sliding), filled where driven, and both bodies.

    Args:
        mechanism: its legs.
        q: (n,) coordinates that close the loops.
        path: .png, .svg or .pdf.
    """
    value = single("q", q, (mechanism.n,))
    space.save(lambda: draw_legs(mechanism, value), picture_file(path))


def draw_legs(mechanism: LegMechanism, q: Floats) -> Any:
    """The picture of `plot_legs` as a matplotlib figure."""
    figure, axes = space.sheet()
    T = mechanism.legs[0].pose(q[mechanism.parts[0]])
    chains = [joint_places(J, T[:3, 3]) for J in mechanism.leg_jacobians(q)]
    for part, places, leg in zip(mechanism.parts, chains, mechanism.legs, strict=True):
        space.line(axes, places, LEG, width=1.8)
        for k, place in enumerate(places):
            colour = DRIVEN if part.start + k in mechanism.driven else LEG
            turns = bool(leg.screws[k, :3].any())
            fill = colour if colour == DRIVEN else "white"
            look = {"marker": "o" if turns else "s", "color": colour, "markerfacecolor": fill, "markersize": 6}
            axes.plot(*place[:, None], zorder=6, **look)
    first, last = (np.array([places[k] for places in chains]) for k in (0, -1))
    if len(chains) > 2:
        _outline(axes, first, GROUND)
        _outline(axes, last, PLATFORM)
    space.frame(axes, T, 0.3 * mechanism.size, "b")
    space.view(axes, np.concatenate([*chains, T[None, :3, 3]]))
    space.title(figure, visible(say("parallel.picture_legs")))
    return figure


def joint_places(screws: Floats, end: Floats) -> Floats:
    """(n, 3) where the joints of a leg are drawn.

    1. Neighbouring axes that meet: where they do, as in universal and ball joints.
    2. Other axes: where they come nearest to the next place that is known, or to the one before, or to the end.
    3. Slides: half way between their neighbours.

    Args:
        screws: (6, n) of the joints in {s}.
        end: (3,) the platform.
    """
    w, v = screws[:3].T, screws[3:].T
    n, turns = len(w), np.linalg.norm(w, axis=1) > 0
    places = np.full((n, 3), np.nan)
    # 1.
    for k in range(n - 1):
        across = np.cross(w[k], w[k + 1])
        parallel = np.linalg.norm(across) < MEETING
        if turns[k] and turns[k + 1] and not parallel and abs(w[k] @ v[k + 1] + v[k] @ w[k + 1]) < MEETING:
            foot = np.cross(w[k + 1], v[k + 1])
            along = across @ np.cross(w[k], np.cross(w[k], v[k]) - foot) / (across @ across)
            places[k : k + 2] = foot + along * w[k + 1]
    # 2.
    for k in np.flatnonzero(turns & np.isnan(places[:, 0])).tolist():
        before, after = _known(places, k, end)
        near = after if np.isfinite(places[k + 1 :, 0]).any() else before
        places[k] = np.cross(w[k], v[k]) + (near @ w[k]) * w[k]
    # 3.
    for k in np.flatnonzero(~turns).tolist():
        places[k] = np.mean(_known(places, k, end), axis=0)
    return places


def _known(places: Floats, k: int, end: Floats) -> tuple[Floats, Floats]:
    """The nearest known places before and after joint k; the end where there is none after, that one if none before."""
    known = np.isfinite(places[:, 0])
    later, earlier = np.flatnonzero(known[k + 1 :]), np.flatnonzero(known[:k])
    after = places[k + 1 + int(later[0])] if len(later) else end
    return (places[int(earlier[-1])] if len(earlier) else after), after


def plot_four_bar_curve(linkage: FourBar, path: str | PathLike[str]) -> None:
    """All configurations of a four-bar as a curve of both angles over a turn, with the points where branches cross.

    Args:
        linkage: its lengths.
        path: .png, .svg or .pdf.
    """
    space.save(lambda: draw_four_bar_curve(linkage), picture_file(path))


def draw_four_bar_curve(linkage: FourBar) -> Any:
    """The picture of `plot_four_bar_curve` as a matplotlib figure."""
    figure, axes = _flat_sheet()
    theta = np.linspace(0, 2 * np.pi, SAMPLES)
    found = output_angles(linkage, theta)
    for branch in np.where(found.missing > 0.0, np.nan, found.phi.T % (2 * np.pi)):
        jumps = np.abs(np.diff(branch, append=branch[-1])) > np.pi
        axes.plot(np.degrees(theta), np.degrees(np.where(jumps, np.nan, branch)), color=PLATFORM, linewidth=1.6)
    for point in singular_points(linkage):
        marker = {"marker": "o", "markersize": 9, "color": space.AXES[0], "linestyle": ""}
        fill = "white" if point.isolated else space.AXES[0]
        axes.plot(np.degrees(point.theta), np.degrees(point.phi), markerfacecolor=fill, **marker)
    axes.set(xlim=(0, 360), ylim=(0, 360), xticks=range(0, 361, 90), yticks=range(0, 361, 90), aspect="equal")
    axes.set_xlabel(r"$\theta$ [deg]")
    axes.set_ylabel(r"$\phi$ [deg]")
    lengths = ", ".join(f"{length:g}" for length in linkage.lengths)
    space.title(figure, visible(say("parallel.picture_curve", lengths=lengths)))
    return figure


def _outline(axes: Any, points: Floats, colour: str) -> None:
    """Ends on one body as a closed polygon about their middle, and their joints as open circles."""
    centred = points - points.mean(axis=0)
    _, _, basis = np.linalg.svd(centred)
    order = np.argsort(np.arctan2(centred @ basis[1], centred @ basis[0]))
    space.line(axes, points[[*order, order[0]]], colour, width=2.2)
    axes.plot(*points.T, linestyle="", marker="o", color=colour, markerfacecolor="white", markersize=6, zorder=6)


def _flat_sheet() -> tuple[Any, Any]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.0, 5.6))
    FigureCanvasAgg(figure)
    return figure, figure.add_axes((0.1, 0.09, 0.86, 0.82))


def _vector(axes: Any, start: Floats, step: Floats, name: str) -> None:
    look = {"arrowstyle": "-|>", "color": space.ACCENT, "shrinkA": 0, "shrinkB": 4, "linewidth": 1.2}
    axes.annotate("", xy=tuple(start + step), xytext=tuple(start), arrowprops=look, zorder=2)
    _word(axes, start + 0.55 * step, name, space.ACCENT)


def _word(axes: Any, place: Floats, text: str, colour: str) -> None:
    ground = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.6}
    axes.text(*place, text, color=colour, ha="center", va="center", zorder=5, bbox=ground)


def _finish(figure: Any, axes: Any, heading: str) -> None:
    axes.set_aspect("equal")
    axes.margins(0.12)
    axes.set_axis_off()
    space.title(figure, visible(heading))
