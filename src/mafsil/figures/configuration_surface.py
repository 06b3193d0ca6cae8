"""Pictures of surfaces of configurations: as they lie in space, and folded over the square of two joints."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.figures.space import picture_file
from mafsil.messages import in_line
from mafsil.messages.visible import visible
from mafsil.mobility import ConfigurationSurface
from mafsil.mobility.charts import angular, differences
from mafsil.mobility.linkages.loop_closure import are_lengths, units

_INK, _BRANCH, _PINCH = "#39424a", "#2e8b57", "#d9902a"
_FACES = ("#2f6fd0", "#d33f3a")
"""Of the two senses in which the surface lies over the square."""
VIEW = (35.0, -60.0)


def plot_surface(
    surface: ConfigurationSurface, path: str | PathLike[str], *, joints: tuple[str, str] | None = None
) -> None:
    """Draw a surface of configurations into a file, in space and over the square of two joints.

    Args:
        surface: as `trace_surface` follows it.
        path: .png, .svg or .pdf.
        joints: names of two joints of one freedom; the first two driven ones, else the first two, if None.
    """
    file = picture_file(path)
    import matplotlib

    with matplotlib.rc_context({"svg.hashsalt": "mafsil", "font.size": 9, "text.color": _INK}):
        figure = draw_surface(surface, joints)
        undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(file.suffix.lower(), {})
        figure.savefig(file, dpi=150, bbox_inches="tight", pad_inches=0.08, metadata=undated)


def draw_surface(surface: ConfigurationSurface, joints: tuple[str, str] | None = None) -> Any:
    """The picture as a matplotlib figure.

    Left the surface in space, where it is broadest: angles as points of circles, so that it has no seams. Right the
    same triangles over the square of two joints, blue and red where they lie on it one way or the other, violet where
    both do. It folds where the colours meet: these two joints drive it no longer there.

    Args:
        surface: as `trace_surface` follows it.
        joints: as for `plot_surface`.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

    columns, names = _two(surface, joints)
    corners, sense = over_square(surface, columns)
    figure = Figure(figsize=(9.5, 4.6))
    FigureCanvasAgg(figure)
    solid: Any = figure.add_axes((0.0, 0.0, 0.52, 0.92), projection="3d")
    square: Any = figure.add_axes((0.6, 0.14, 0.36, 0.74))
    X = in_space(surface, surface.theta)
    colours = [_FACES[int(one > 0)] for one in sense]
    if len(surface.triangles):
        faces = solid.plot_trisurf(*X.T, triangles=surface.triangles, linewidth=0.15, edgecolor="#ffffff", alpha=0.75)
        faces.set_facecolor(colours)
    for points, colour in ((surface.branch_points, _BRANCH), (surface.singular_points, _PINCH)):
        if len(points):
            solid.plot(*in_space(surface, points).T, "o", markersize=3, color=colour)
            square.plot(*(points * _degrees(surface))[:, columns].T, "o", markersize=3, color=colour, zorder=3)
    for shift in _shifts(surface, columns):
        square.add_collection(PolyCollection(list(corners + shift), facecolors=colours, alpha=0.35, linewidths=0))
    solid.view_init(*VIEW)
    solid.axis("off")
    for axis, k, name in ((square.xaxis, columns[0], names[0]), (square.yaxis, columns[1], names[1])):
        axis.set_label_text(visible(f"{name} [°]" if _degrees(surface)[k] != 1.0 else f"{name} [m]"))
        _limits(axis, corners[..., 0 if axis is square.xaxis else 1], bool(angular(surface.linkage)[k]))
    figure.suptitle("\n".join(in_line(visible(line)) for line in surface.explain().split("\n")), fontsize=9, wrap=True)
    return figure


def _limits(axis: Any, values: Floats, turns: bool) -> None:
    if turns:
        axis.set_view_interval(-180, 180, ignore=True)
        axis.set_ticks(range(-180, 181, 90))
    elif values.size:
        axis.set_view_interval(float(values.min()), float(values.max()), ignore=True)


def in_space(surface: ConfigurationSurface, theta: Floats) -> Floats:
    """(k, 3) configurations (k, F) in the three directions of most spread, angles of hinges as points of circles."""

    def flat(values: Floats) -> Floats:
        u = values / units(surface.linkage)
        round_ = angular(surface.linkage)
        return np.concatenate([np.cos(u[:, round_]), np.sin(u[:, round_]), u[:, ~round_]], axis=1)

    own = flat(surface.theta)
    middle = own.mean(axis=0)
    directions = np.linalg.svd(own - middle, full_matrices=False)[2][:3]
    found = (flat(theta) - middle) @ directions.T
    return np.pad(found, ((0, 0), (0, 3 - found.shape[1])))


def over_square(surface: ConfigurationSurface, columns: tuple[int, int]) -> tuple[Floats, Floats]:
    """Triangles over two coordinates: corners (t, 3, 2) [degrees, m], and the sense (t,) in which they lie there.

    Triangles are turned alike on an orientable surface; corners follow the first, across seams if need be.
    """
    a, b, c = _alike(surface.triangles).T
    P, pick = surface.charts.points, list(columns)
    first = P[a][:, pick]
    u, v = (differences(surface.linkage, P[a], P[end])[:, pick] for end in (b, c))
    sense = np.sign(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    corners = np.stack([first, first + u, first + v], axis=1)
    return corners * units(surface.linkage)[pick] * _degrees(surface)[pick], sense


def _alike(triangles: NDArray[np.intp]) -> NDArray[np.intp]:
    """The triangles with their corners in the same sense around, as far as each can follow from its neighbour."""
    found = triangles.copy()
    at: dict[tuple[int, int], list[int]] = {}
    for k, (a, b, c) in enumerate(triangles.tolist()):
        for side in ((a, b), (b, c), (a, c)):
            at.setdefault(side, []).append(k)
    done = np.zeros(len(found), dtype=bool)
    for start in range(len(found)):
        waiting = [] if done[start] else [start]
        done[start] = True
        while waiting:
            a, b, c = found[waiting.pop()].tolist()
            for x, y in ((a, b), (b, c), (c, a)):
                for k in at[(min(x, y), max(x, y))]:
                    if not done[k]:
                        done[k] = True
                        (third,) = set(found[k].tolist()) - {x, y}
                        found[k] = (y, x, third)
                        waiting.append(k)
    return found


def _two(surface: ConfigurationSurface, joints: tuple[str, str] | None) -> tuple[tuple[int, int], tuple[str, str]]:
    linkage = surface.linkage
    single = [each.name for each in linkage.joints if each.freedoms == 1]
    driven = [each.name for each in linkage.joints if each.freedoms == 1 and each.actuated]
    if joints is None:
        chosen = (driven if len(driven) > 1 else single)[:2]
        columns = linkage.columns_of(chosen) if len(chosen) == 2 else np.arange(2)
        names = linkage.coordinate_names
        return (int(columns[0]), int(columns[1])), (names[int(columns[0])], names[int(columns[1])])
    first, second = (int(linkage.columns_of([name])[0]) for name in joints)
    return (first, second), joints


def _degrees(surface: ConfigurationSurface) -> Floats:
    """(F,) factors from coordinates to what is drawn: degrees of angles, metres."""
    return np.where(are_lengths(surface.linkage), 1.0, 180 / np.pi)


def _shifts(surface: ConfigurationSurface, columns: tuple[int, int]) -> list[Floats]:
    """(2,) shifts by full turns [degrees] with which triangles that cross a seam show on its other side too."""
    first, second = ((0.0, -360.0, 360.0) if angular(surface.linkage)[k] else (0.0,) for k in columns)
    return [np.array([x, y]) for x in first for y in second]
