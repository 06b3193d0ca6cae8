"""Drawings as data: named elements on panels in the plane or in space, and the renderer that puts them on a sheet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.figures import space
from mafsil.messages import in_line

INK, SOFT, PALE, AXES, ACCENT, SECOND = space.INK, space.SOFT, space.PALE, space.AXES, space.ACCENT, space.SECOND
BLUE, GREEN, RED = "#2f6fd0", "#2e8b57", "#d33f3a"
COLOURS = (BLUE, ACCENT, GREEN, SECOND, RED, "#5b7fa6")
Points: TypeAlias = ArrayLike | Sequence[ArrayLike]
Kind: TypeAlias = Literal["line", "dots", "arrow", "fill", "label", "surface"]


@dataclass(frozen=True, eq=False, slots=True)
class Element:
    """One thing drawn.

    Attributes:
        kind: how its points are drawn; an arrow leads from the first to the second.
        points: (k, 2 | 3), of a surface (m, n, 3).
        name: by which the element is found again, in the panel and as `gid` of the artist.
        text: of a label.
        colour: of all of it.
        style: of lines as matplotlib writes it, of dots their marker.
        width: of lines, size of dots and of text [point].
        alpha: opacity.
        offset: of a label from its point [point].
    """

    kind: Kind
    points: Floats
    name: str = ""
    text: str = ""
    colour: str = INK
    style: str = "-"
    width: float = 1.6
    alpha: float = 1.0
    offset: tuple[float, float] = (0.0, 0.0)


class Panel:
    """A part of a drawing; every method adds elements and returns the panel.

    Args:
        labels: of the axes, for a graph; a drawing without axes if empty.
        equal: one scale for all axes.
        elevation, azimuth: of the eye in space [degree].
        zoom: of the drawing in space.
        limits: (left, right, bottom, top) of a graph; from the elements if None.
    """

    def __init__(
        self,
        labels: Sequence[str] = (),
        *,
        equal: bool = True,
        elevation: float = 22.0,
        azimuth: float = -58.0,
        zoom: float = 1.2,
        limits: tuple[float, float, float, float] | None = None,
    ) -> None:
        self.labels, self.equal, self.limits = tuple(labels), equal, limits
        self.elevation, self.azimuth, self.zoom = elevation, azimuth, zoom
        self.elements: list[Element] = []

    def __getitem__(self, name: str) -> Floats:
        """Points of the first element of that name.

        Raises:
            KeyError: there is none.
        """
        for element in self.elements:
            if element.name == name:
                return element.points
        raise KeyError(name)

    @property
    def names(self) -> list[str]:
        """Of all elements that have one."""
        return [element.name for element in self.elements if element.name]

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.elements[0].points.shape[-1] if self.elements else 2

    def _add(self, kind: Kind, points: Points, name: str, **look: Any) -> Panel:
        values = np.asarray(points, dtype=np.float64)
        self.elements.append(Element(kind, values if kind == "surface" else np.atleast_2d(values), name, **look))
        return self

    def line(self, points: Points, colour: str = INK, style: str = "-", width: float = 1.6, name: str = "") -> Panel:
        """A line through (k, 2 | 3) points."""
        return self._add("line", points, name, colour=colour, style=style, width=width)

    def dots(self, points: Points, colour: str = INK, style: str = "o", width: float = 5.0, name: str = "") -> Panel:
        """Markers at points."""
        return self._add("dots", points, name, colour=colour, style=style, width=width)

    def arrow(
        self,
        start: Points,
        step: Points,
        text: str = "",
        *,
        colour: str = ACCENT,
        width: float = 1.8,
        name: str = "",
        reach: float = 1.14,
    ) -> Panel:
        """An arrow from a point along a vector; a text stands beyond its tip, `reach` lengths from the start."""
        tail, along = np.asarray(start, dtype=np.float64), np.asarray(step, dtype=np.float64)
        self._add("arrow", np.stack([tail, tail + along]), name, colour=colour, width=width)
        return self.label(tail + reach * along, text, colour) if text else self

    def fill(self, points: Points, colour: str = SOFT, alpha: float = 0.22, edge: bool = True, name: str = "") -> Panel:
        """A polygon, with its outline unless `edge` is false."""
        corners = np.asarray(points, dtype=np.float64)
        self._add("fill", corners, name, colour=colour, alpha=alpha)
        return self.line(np.vstack([corners, corners[:1]]), colour, width=1.4) if edge else self

    def label(
        self,
        place: Points,
        text: str,
        colour: str = INK,
        offset: tuple[float, float] = (0.0, 0.0),
        width: float = 10.0,
    ) -> Panel:
        """A word at a point, moved by an offset [point]."""
        return self._add("label", place, "", text=text, colour=colour, offset=offset, width=width)

    def code(self, place: Points, text: str, width: float = 7.5) -> Panel:
        """Lines of a program, from a point to the right and downwards."""
        return self._add("label", place, "code", text=text, style="code", width=width)

    def surface(self, points: Floats, colour: str = PALE, alpha: float = 0.4, name: str = "") -> Panel:
        """A grid (m, n, 3) of points."""
        return self._add("surface", points, name, colour=colour, alpha=alpha)

    def arc(
        self,
        centre: Points,
        radius: float,
        span: tuple[float, float],
        text: str = "",
        *,
        colour: str = INK,
        style: str = "-",
        width: float = 1.2,
        name: str = "",
        head: bool = False,
    ) -> Panel:
        """An arc of a circle in the plane between two angles [rad], with a text at its middle and a head if asked."""
        middle, angles = np.asarray(centre, dtype=np.float64), np.linspace(*span, 73)
        points = middle + radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        self.line(points, colour, style, width, name)
        if head:
            self.arrow(points[-4], points[-1] - points[-4], colour=colour, width=width)
        if text:
            half = (span[0] + span[1]) / 2
            self.label(middle + 1.0 * radius * np.array([np.cos(half), np.sin(half)]), text, colour,
                       (9.0 * float(np.cos(half)), 9.0 * float(np.sin(half))))  # fmt: skip
        return self

    def frame(self, T: ArrayLike, length: float, name: str = "", colour: str | None = None) -> Panel:
        """Arrows along the axes of a pose (3, 3) of the plane or (4, 4), with letters where it has a name."""
        pose = np.asarray(T, dtype=np.float64)
        size = len(pose) - 1
        origin = pose[:size, size]
        for k in range(size):
            letter = f"${'xyz'[k]}_{{{name}}}$" if name and colour is None else ""
            self.arrow(origin, length * pose[:size, k], letter, colour=colour or AXES[k], name=f"{name}.{'xyz'[k]}")
        away = -pose[:size, :size].sum(axis=1) / np.sqrt(size)
        if size == 2 and name:
            return self.label(origin, "{" + name + "}", colour or INK, (13.0 * away[0], 13.0 * away[1]))
        return self.label(origin + 0.25 * length * away, "{" + name + "}", colour or INK) if name else self


def draw_panels(
    panels: Mapping[str, Panel],
    headings: Mapping[str, str],
    title: str,
    columns: int | None = None,
    cell: tuple[float, float] | None = None,
) -> Any:
    """A matplotlib figure of panels side by side.

    Args:
        panels: by name, in order.
        headings: of the panels that have one, by name.
        title: above all of them.
        columns: number of panels beside each other; three at most if None.
        cell: width and height of a panel [inch].
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    across = min(len(panels), 3) if columns is None else columns
    down = ceil(len(panels) / across)
    size = cell or ((5.6, 5.0) if len(panels) == 1 else (3.9, 3.7))
    width, height = size[0] * across, size[1] * down
    figure = Figure(figsize=(width, height + 0.5))
    FigureCanvasAgg(figure)
    top = height / (height + 0.5)
    for k, (name, panel) in enumerate(panels.items()):
        column, row = k % across, k // across
        place = (column / across, top * (1 - (row + 1) / down), 1 / across, top / down)
        _panel(figure, panel, place, headings.get(name, ""))
    space.title(figure, title)
    return figure


def _panel(figure: Any, panel: Panel, cell: tuple[float, float, float, float], heading: str) -> None:
    left, bottom, width, height = cell
    room = 0.88 if heading else 0.97
    if heading:
        figure.text(left + width / 2, bottom + 0.97 * height, in_line(heading), ha="center", va="top", fontsize=9.5)
    if panel.dimension == 3:
        axes = space.panel(figure, (left, bottom, width, room * height))
    elif panel.labels:
        axes = figure.add_axes((left + 0.17 * width, bottom + 0.16 * height, 0.76 * width, (room - 0.2) * height))
    else:
        axes = figure.add_axes((left + 0.03 * width, bottom + 0.02 * height, 0.94 * width, (room - 0.04) * height))
    for element in panel.elements:
        artist = _DRAWERS[element.kind](axes, element)
        if element.name:
            artist.set_gid(element.name)
    if panel.dimension == 3:
        points = np.vstack([element.points.reshape(-1, 3) for element in panel.elements])
        space.view(axes, points, panel.zoom, panel.elevation, panel.azimuth)
    else:
        _flat(axes, panel)


def _flat(axes: Any, panel: Panel) -> None:
    axes.update_datalim(np.vstack([element.points for element in panel.elements]))
    axes.autoscale_view()
    axes.margins(0.09)
    if panel.equal:
        axes.set_aspect("equal", adjustable="datalim" if not panel.limits else "box")
    if panel.limits:
        axes.set(xlim=panel.limits[:2], ylim=panel.limits[2:])
    if not panel.labels:
        axes.set_axis_off()
        return
    axes.set_xlabel(panel.labels[0], fontsize=9)
    axes.set_ylabel(panel.labels[1], fontsize=9)
    axes.tick_params(labelsize=8)
    axes.grid(color="#e4e7ea", linewidth=0.6)
    axes.set_axisbelow(True)


def _line(axes: Any, element: Element) -> Any:
    look = {"color": element.colour, "linestyle": element.style, "linewidth": element.width, "zorder": 3}
    return axes.plot(*element.points.T, solid_capstyle="round", **look)[0]


def _dots(axes: Any, element: Element) -> Any:
    look = {"marker": element.style, "color": element.colour, "markersize": element.width, "zorder": 6}
    return axes.plot(*element.points.T, linestyle="none", **look)[0]


def _arrow(axes: Any, element: Element) -> Any:
    start, end = element.points
    if len(start) == 3:
        head = {"arrow_length_ratio": 0.16, "zorder": 5}
        return axes.quiver(*start, *(end - start), color=element.colour, linewidth=element.width, **head)
    look = {"arrowstyle": "-|>", "color": element.colour, "lw": element.width, "shrinkA": 0, "shrinkB": 0}
    return axes.annotate("", end, start, arrowprops=look, annotation_clip=False, zorder=5)


def _fill(axes: Any, element: Element) -> Any:
    look = {"alpha": element.alpha, "linewidth": 0, "zorder": 2}
    if element.points.shape[1] == 2:
        return axes.fill(*element.points.T, color=element.colour, **look)[0]
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    return axes.add_collection3d(Poly3DCollection([element.points], facecolor=element.colour, **look))


def _label(axes: Any, element: Element) -> Any:
    ground = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.6}
    look = {"color": element.colour, "fontsize": element.width, "ha": "center", "va": "center", "zorder": 9}
    if element.style == "code":
        look |= {"ha": "left", "va": "top", "family": "monospace"}
    if element.points.shape[1] == 3:
        return axes.text(*element.points[0], element.text, bbox=ground, **look)
    return axes.annotate(
        element.text, element.points[0], element.offset, textcoords="offset points", bbox=ground, **look
    )


def _surface(axes: Any, element: Element) -> Any:
    look = {"color": element.colour, "alpha": element.alpha, "linewidth": 0.2, "edgecolor": SOFT}
    rows, columns = (max(1, size // 24) for size in element.points.shape[:2])
    return axes.plot_surface(*np.moveaxis(element.points, -1, 0), zorder=1, rstride=rows, cstride=columns, **look)


_DRAWERS = {
    "line": _line, "dots": _dots, "arrow": _arrow, "fill": _fill, "label": _label, "surface": _surface,
}  # fmt: skip
