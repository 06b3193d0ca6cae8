"""Pictures of linkages: bodies and joints, what is idle or driven, how they move; curves on a torus, cut open."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.figures.space import picture_file
from mafsil.messages import in_line
from mafsil.messages.visible import visible
from mafsil.mobility import Linkage, Mobility, mobility, torus, trace_motion
from mafsil.mobility.linkages import Kind, LinkageJoint, body_poses, close_loops_near
from mafsil.mobility.linkages.loop_closure import units
from mafsil.mobility.spaces.motion_group import cross

_INK, _GROUND, _OUTPUT, _DRIVEN, _IDLE, _GHOST = "#39424a", "#8a949c", "#2f6fd0", "#2e8b57", "#d9902a", "#c9d0d6"
_BODIES = ("#5b7fa6", "#8c6bb1", "#4f9d8f", "#b07aa1", "#7f8c5a", "#a0674f")
_CURVES = ("#2f6fd0", "#d33f3a", "#2e8b57", "#d9902a")
GHOSTS = 5
VIEW = (50.0, -60.0)
"""Elevation and azimuth of the eye that looks at a torus [degrees]."""
MARKERS = {Kind.PRISMATIC: "s", Kind.SPHERICAL: "o", Kind.UNIVERSAL: "P", Kind.CYLINDRICAL: "D", Kind.PIN_IN_SLOT: "d"}


def save_linkage(linkage: Linkage, path: str | PathLike[str], *, found: Mobility | None = None) -> None:
    """Draw a linkage into a file, with faint copies along its motion.

    Args:
        linkage: as drawn, closed.
        path: .png, .svg or .pdf.
        found: its report; asked for if None.
    """
    file = picture_file(path)
    import matplotlib

    report = mobility(linkage) if found is None else found
    with matplotlib.rc_context({"svg.hashsalt": "mafsil", "font.size": 9, "text.color": _INK}):
        figure = draw_linkage(linkage, report)
        undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(file.suffix.lower(), {})
        figure.savefig(file, dpi=150, bbox_inches="tight", pad_inches=0.08, metadata=undated)


def draw_linkage(linkage: Linkage, found: Mobility) -> Any:
    """The picture as a matplotlib figure; flat if all joints move in the plane of x and y.

    Args:
        linkage: as drawn, closed.
        found: its report: idle joints are shown in orange, driven ones in green.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.5, 5.5))
    FigureCanvasAgg(figure)
    flat = is_flat(linkage)
    axes: Any = figure.add_axes((0.02, 0.02, 0.96, 0.88), projection=None if flat else "3d")
    for theta in _along_the_motion(linkage, found):
        _bodies(axes, linkage, theta, flat, ghost=True)
    skeleton(axes, linkage, np.zeros(linkage.coordinates), found)
    axes.set_aspect("equal")
    axes.margins(0.1)
    axes.axis("off")
    figure.suptitle(in_line(visible(found.explain().split("\n")[0])), fontsize=10, wrap=True)
    return figure


def skeleton(axes: Any, linkage: Linkage, theta: Floats, found: Mobility) -> None:
    """Draw bodies and joints.

    Args:
        axes: of matplotlib; flat if the linkage is, else 3D.
        linkage: as drawn.
        theta: (F,) closed configuration.
        found: its report: idle joints are shown in orange, driven ones in green.
    """
    flat = is_flat(linkage)
    _bodies(axes, linkage, theta, flat, ghost=False)
    T = body_poses(linkage, theta)
    dead = {one.joints for one in found.dead_points}
    idle = {name for one in found.instantaneous.idle if one.joints not in dead for name in one.joints}
    labels: dict[tuple[float, ...], list[LinkageJoint]] = {}
    for each in linkage.joints:
        colour = _IDLE if each.name in idle else _DRIVEN if each.actuated else _INK
        point = _joint(axes, linkage, each, T[linkage.bodies.index(each.parent)], colour)
        labels.setdefault(tuple(np.round(point / linkage.size, 6).tolist()), []).append(each)
    for place, joints in labels.items() if flat else ():
        _label(axes, linkage, linkage.size * np.array(place[:2]), joints, T)


def _label(axes: Any, linkage: Linkage, at: Floats, joints: Sequence[LinkageJoint], T: Floats) -> None:
    """Names of joints at a place, on the side that is farthest from the bodies that meet there."""
    ends = [at]
    for body in {end for each in joints for end in (each.parent, each.child)} - {linkage.ground}:
        k = linkage.bodies.index(body)
        ends += list((_places(linkage, body) @ T[k, :3, :3].T + T[k, :3, 3])[:, :2])
    away = np.array(ends) - at
    busy = away[np.linalg.norm(away, axis=1) > 1e-6 * linkage.size]
    sides = np.exp(1j * np.pi * (0.25 + np.arange(16) / 8))
    lines = busy[:, 0] + 1j * busy[:, 1]
    apart: Floats = np.abs(np.angle(sides[:, None] / lines)).min(axis=1, initial=np.pi)
    best = complex(sides[int(apart.round(3).argmax())])
    grounded = any(linkage.ground in (each.parent, each.child) for each in joints)
    offset = (13.0 if grounded else 8.0) * best
    axes.annotate(
        visible(", ".join(each.name for each in joints)), at, (offset.real, offset.imag), textcoords="offset points",
        ha=_side(best.real, "right", "left"), va=_side(best.imag, "top", "bottom"), zorder=5,
    )  # fmt: skip


def _side(x: float, below: str, above: str) -> str:
    return "center" if abs(x) < 0.3 else below if x < 0.0 else above


def is_flat(linkage: Linkage) -> bool:
    """Whether a linkage is drawn in the plane of x and y and moves in it."""
    for each in linkage.joints:
        if not each.kind.planar or (each.kind is not Kind.PRISMATIC and abs(each.axis[2]) < 1 - 1e-9):
            return False
        if abs(each.point[2]) > 1e-9 * linkage.size or (each.kind is Kind.PRISMATIC and abs(each.axis[2]) > 1e-9):
            return False
    return True


def _along_the_motion(linkage: Linkage, found: Mobility) -> list[Floats]:
    """A few configurations: along the curve of a linkage of mobility 1, else along its first rates."""
    if not found or not linkage.coordinates:
        return []
    if found.instantaneous.mobility == 1 and linkage.loops:
        curve = trace_motion(linkage, steps=400)
        reach = min(len(curve.theta) - 1, 12)
        return [curve.theta[k] for k in np.linspace(0, reach, GHOSTS).astype(int)[1:]]
    rates = found.instantaneous.rates[:, 0] * units(linkage)
    steps = close_loops_near(linkage, 0.12 * np.arange(1, 3)[:, None] * rates)
    return list(steps.theta[steps.closed])


def _places(linkage: Linkage, body: str) -> Floats:
    """(k, 3) points of the joints of a body where it is drawn, without repeats.

    A body whose joints all stand on one axis would rotate unseen, so it gets one more point, beside the axis; where all
    axes of the linkage meet in a point, bodies are sectors of circles about it.
    """
    own = [each for each in linkage.joints if body in (each.parent, each.child)]
    if body != linkage.ground and len(own) == 2 and _is_spherical(linkage):
        first, last = own[0].axis, own[1].axis
        first = np.where(first @ last < 0.0, -first, first)
        arc = first + np.linspace(0.0, 1.0, 9)[:, None] * (last - first)
        arc *= 0.5 * linkage.size / np.linalg.norm(arc, axis=1, keepdims=True)
        return own[0].point + np.vstack([np.zeros(3), arc])
    points = np.unique(np.round(np.array([each.point for each in own]), 12), axis=0)
    axis = own[0].axis
    rotating = all(each.kind in (Kind.REVOLUTE, Kind.CYLINDRICAL, Kind.HELICAL) for each in own)
    off_axis = np.cross(points - points[0], axis).any() or any(np.cross(each.axis, axis).any() for each in own)
    if not rotating or off_axis or body == linkage.ground:
        return points
    beside = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    return np.vstack([points, points.mean(axis=0) + 0.3 * linkage.size * beside / np.linalg.norm(beside)])


def _is_spherical(linkage: Linkage) -> bool:
    """Whether all joints are hinges that stand in one point."""
    points = np.array([each.point for each in linkage.joints])
    return all(each.kind is Kind.REVOLUTE for each in linkage.joints) and bool(
        np.abs(points - points[0]).max() < 1e-9 * linkage.size
    )


def _bodies(axes: Any, linkage: Linkage, theta: Floats, flat: bool, *, ghost: bool) -> None:
    T = body_poses(linkage, theta)
    size = 2 if flat else 3
    for k, body in enumerate(linkage.bodies):
        if ghost and k == 0:
            continue
        points = (_places(linkage, body) @ T[k, :3, :3].T + T[k, :3, 3])[:, :size]
        colour = _GHOST if ghost else _GROUND if k == 0 else _OUTPUT if body == linkage.output else _BODIES[k % 6]
        line = {"color": colour, "linewidth": 1.0 if ghost else 2.4, "zorder": 1 if ghost else 2}
        if k == 0:
            axes.plot(*points.T, linestyle="none", marker="^" if flat else "o", markersize=13, color=_GROUND, zorder=1)
            continue
        points = points[_around(points)]
        if len(points) > 2 and flat and not ghost:
            axes.fill(*points.T, color=colour, alpha=0.25, linewidth=0, zorder=1)
        closed = np.vstack([points, points[:1]]) if len(points) > 2 else points
        axes.plot(*closed.T, **line)


def _around(points: Floats) -> list[int]:
    """Order of points around their middle, in the plane that fits them best."""
    middle = points - points.mean(axis=0)
    plane = np.linalg.svd(middle, full_matrices=False)[2][:2]
    flat = middle @ plane.T
    return np.argsort(np.arctan2(flat[:, -1], flat[:, 0])).tolist()


def _joint(axes: Any, linkage: Linkage, each: LinkageJoint, T_parent: Floats, colour: str) -> Floats:
    """Draw a joint; its place (3,)."""
    flat = is_flat(linkage)
    point, axis = T_parent[:3, :3] @ each.point + T_parent[:3, 3], T_parent[:3, :3] @ each.axis
    look = {
        "marker": MARKERS.get(each.kind, "o"),
        "markersize": 6,
        "color": "white",
        "markeredgewidth": 1.8,
        "zorder": 4,
    }
    axes.plot(*point[: 2 if flat else 3, None], markeredgecolor=colour, **look)
    if not flat and each.kind in (Kind.REVOLUTE, Kind.CYLINDRICAL, Kind.HELICAL, Kind.PRISMATIC, Kind.UNIVERSAL):
        half = 0.12 * linkage.size * axis
        axes.plot(*np.array([point - half, point + half]).T, color=colour, linewidth=1.6, zorder=3)
    return point


def save_torus(curves: Sequence[Floats], path: str | PathLike[str], *, names: tuple[str, str] = ("a", "b")) -> None:
    """Draw curves of two angles on a torus and on the square that it is cut open to.

    Args:
        curves: (k, 2) angles each [rad].
        path: .png, .svg or .pdf.
        names: of the two angles.
    """
    file = picture_file(path)
    import matplotlib

    with matplotlib.rc_context({"svg.hashsalt": "mafsil", "font.size": 9, "text.color": _INK}):
        figure = draw_torus(curves, names)
        undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(file.suffix.lower(), {})
        figure.savefig(file, dpi=150, bbox_inches="tight", pad_inches=0.08, metadata=undated)


def draw_torus(curves: Sequence[Floats], names: tuple[str, str] = ("a", "b")) -> Any:
    """The picture as a matplotlib figure: the torus in space, the flat square beside it.

    Args:
        curves: (k, 2) angles each [rad].
        names: of the two angles.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.5, 4.6))
    FigureCanvasAgg(figure)
    solid: Any = figure.add_axes((0.0, 0.0, 0.52, 1.0), projection="3d", computed_zorder=False)
    square: Any = figure.add_axes((0.6, 0.14, 0.36, 0.76))
    a, b = np.meshgrid(np.linspace(0, 2 * np.pi, 73), np.linspace(0, 2 * np.pi, 37))
    X = torus.embed_in_space(np.stack([a, b], axis=-1))
    solid.plot_surface(*np.moveaxis(X, -1, 0), color="#e8ecef", edgecolor="#d4dade", linewidth=0.3, alpha=0.55)
    for k, curve in enumerate(curves):
        colour = _CURVES[k % len(_CURVES)]
        X, near = lift_off_torus(curve), facing(curve, VIEW)
        for width, style, seen in ((0.9, ":", ~near), (2.2, "-", near)):
            solid.plot(*np.where(seen[:, None], X, np.nan).T, color=colour, linewidth=width, linestyle=style, zorder=3)
        for piece in torus.cut_at_seams(curve):
            square.plot(*np.degrees(piece).T, color=colour, linewidth=1.8)
    solid.view_init(*VIEW)
    solid.set_aspect("equal")
    solid.axis("off")
    square.set(xlim=(0, 360), ylim=(0, 360), xlabel=f"{names[0]} [°]", ylabel=f"{names[1]} [°]")
    square.set_xticks(range(0, 361, 90))
    square.set_yticks(range(0, 361, 90))
    square.set_aspect("equal")
    return figure


def lift_off_torus(curve: Floats, height: float = 0.02) -> Floats:
    """(k, 3) a curve a little above the torus, so that the surface does not hide it."""
    X = torus.embed_in_space(curve)
    a = torus.embed_in_space(curve + np.array([1e-6, 0.0])) - X
    b = torus.embed_in_space(curve + np.array([0.0, 1e-6])) - X
    n = cross(a, b)
    return X + height * n / np.linalg.norm(n, axis=-1, keepdims=True)


def facing(curve: Floats, view: tuple[float, float]) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """(k,) where the surface under a curve is turned towards an eye at elevation and azimuth [degrees]."""
    up, round_axis = np.radians(view)
    eye = np.array([np.cos(up) * np.cos(round_axis), np.cos(up) * np.sin(round_axis), np.sin(up)])
    outward = lift_off_torus(curve, 1.0) - torus.embed_in_space(curve)
    return np.asarray(outward @ eye > 0, dtype=np.bool_)
