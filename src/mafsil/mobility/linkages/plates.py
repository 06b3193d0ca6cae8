"""Links of a planar linkage as plates to cut: rounded outlines around their pins, side by side, as SVG or DXF.

Millimetres, scale 1. An outline is the convex hull of discs about the pins, a prismatic joint a line along its slide.
DXF is R12 text with one layer for each body: entities LINE, ARC, CIRCLE and TEXT.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, positive
from mafsil.errors import InputError
from mafsil.messages.visible import visible
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.linkages.linkage_joint import Kind
from mafsil.whole_file import write_whole

MILLIMETRES = 1000.0
WIDTH = 0.12
"""Of plates, over the size of the linkage."""
SAME = 1e-9
"""Of the size: pins nearer than that are one hole."""


@dataclass(frozen=True, eq=False)
class Plate:
    """A link, where it is drawn.

    Attributes:
        body: its name.
        pins: (k, 2) places of its holes [m].
        names: of the joints in each hole.
        slides: (s, 2, 2) points on the axes of prismatic joints and their directions.
    """

    body: str
    pins: Floats
    names: tuple[str, ...]
    slides: Floats

    @property
    def corners(self) -> NDArray[np.intp]:
        """Pins on the convex hull, counterclockwise, by Andrew's monotone chain."""
        order: list[int] = np.lexsort(self.pins.T[::-1]).tolist()

        def chain(indices: list[int]) -> list[int]:
            kept: list[int] = []
            for k in indices:
                while len(kept) > 1 and _turn(*self.pins[[*kept[-2:], k]]) <= 0:
                    kept.pop()
                kept.append(k)
            return kept[:-1]

        found = chain(order) + chain(order[::-1]) if len(order) > 1 else order
        return np.array(found, dtype=np.intp)


def plates(linkage: Linkage) -> tuple[Plate, ...]:
    """The moving links and the ground as plates.

    Raises:
        InputError: the linkage is not planar.
    """
    if not linkage.planar:
        raise InputError("mobility.plates_planar", name=linkage.name or "-")
    found: list[Plate] = []
    for body in linkage.bodies:
        pins: dict[tuple[float, ...], list[str]] = {}
        slides: list[Floats] = []
        for each in linkage.joints:
            if body not in (each.parent, each.child):
                continue
            if each.kind in (Kind.REVOLUTE, Kind.PIN_IN_SLOT):
                place = np.round(each.point[:2] / (SAME * linkage.size)) * SAME * linkage.size
                pins.setdefault(tuple(place.tolist()), []).append(each.name)
            if each.kind in (Kind.PRISMATIC, Kind.PIN_IN_SLOT):
                along = each.axis if each.kind is Kind.PRISMATIC else each.second
                slides.append(np.stack([each.point[:2], along[:2]]))
        places = np.array(list(pins)).reshape(-1, 2)
        lines = np.array(slides).reshape(-1, 2, 2)
        found.append(Plate(body, places, tuple(", ".join(names) for names in pins.values()), lines))
    return tuple(found)


def write_plates(
    linkage: Linkage, path: str | PathLike[str], *, width: float | None = None, hole: float | None = None
) -> Path:
    """Write the links side by side into a file, with names and distances of their pins.

    Args:
        linkage: planar.
        path: .svg or .dxf.
        width: of the plates [m]; an eighth of the size of the linkage if None.
        hole: diameter of the holes [m]; two fifths of the width if None.

    Raises:
        InputError: it is not planar, the holes are wider than the plates, or another ending.
        FileError: the file cannot be written.
    """
    file = Path(path)
    broad = MILLIMETRES * (WIDTH * linkage.size if width is None else positive("width", width))
    bore = 0.4 * broad if hole is None else MILLIMETRES * positive("hole", hole)
    if bore >= broad:
        raise InputError("mobility.plates_hole", hole=bore, width=broad)
    if file.suffix.lower() not in (".svg", ".dxf"):
        raise InputError("pictures.ending", path=str(path), known=".svg, .dxf")
    shapes, size = _side_by_side(plates(linkage), broad / 2, bore / 2)
    text = _svg(shapes, size, broad) if file.suffix.lower() == ".svg" else _dxf(shapes, broad)
    write_whole(file, text.encode())
    return file


@dataclass(frozen=True, eq=False)
class _Shape:
    """A plate in millimetres on the sheet: straight edges (e, 2, 2), arcs (x, y, radius, from, to), holes, texts."""

    name: str
    edges: Floats
    arcs: tuple[tuple[float, float, float, float, float], ...]
    holes: tuple[tuple[float, float, float], ...]
    texts: tuple[tuple[float, float, str], ...]
    lines: Floats


def _side_by_side(every: tuple[Plate, ...], r: float, bore: float) -> tuple[list[_Shape], tuple[float, float]]:
    """Plates in a row from left to right with gaps of their width, and the size of the sheet."""
    shapes, x, height = list[_Shape](), r, 0.0
    for each in every:
        points = MILLIMETRES * np.concatenate([each.pins, each.slides[:, 0]])
        if not len(points):
            continue
        shift = np.array([x + r, 2.0 * r]) - points.min(axis=0)
        shapes.append(_shape(each, MILLIMETRES * each.pins + shift, shift, r, bore))
        x += float(np.ptp(points[:, 0])) + 4.0 * r
        height = max(height, float(np.ptp(points[:, 1])) + 4.0 * r)
    return shapes, (x, height)


def _shape(plate: Plate, pins: Floats, shift: Floats, r: float, bore: float) -> _Shape:
    hull = pins[plate.corners]
    edges: list[Floats] = []
    arcs: list[tuple[float, float, float, float, float]] = []
    after = np.roll(hull, -1, axis=0) - hull
    headings = np.degrees(np.arctan2(after[:, 1], after[:, 0])) - 90.0
    for k, (x, y) in enumerate(hull.tolist()):
        if len(hull) > 1:
            side = r * np.array([after[k, 1], -after[k, 0]]) / np.linalg.norm(after[k])
            edges.append(np.stack([hull[k] + side, hull[(k + 1) % len(hull)] + side]))
        before = headings[k - 1] if len(hull) > 1 else 0.0
        swept = (headings[k] - before) % 360.0 if len(hull) > 1 else 360.0
        arcs.append((x, y, r, before % 360.0, before % 360.0 + swept))
    texts = [(float(x), float(y), name) for (x, y), name in zip(pins, plate.names, strict=True)]
    for i, j in _measure(plate.corners.tolist()):
        x, y = (pins[i] + pins[j]) / 2
        texts.append((float(x), float(y), f"{float(np.linalg.norm(pins[i] - pins[j])):.6g}"))
    if len(pins):
        texts.append((float(pins[:, 0].min()), float(pins[:, 1].min() - 1.6 * r), plate.body))
    at, along = MILLIMETRES * plate.slides[:, 0] + shift, plate.slides[:, 1]
    lines = np.stack([at - 2 * r * along, at + 2 * r * along], axis=1)
    holes = tuple((float(x), float(y), bore) for x, y in pins)
    return _Shape(plate.body, np.array(edges).reshape(-1, 2, 2), tuple(arcs), holes, tuple(texts), lines)


def _measure(corners: list[int]) -> list[tuple[int, int]]:
    """Pairs of neighbouring corners."""
    pairs = list(zip(corners, corners[1:] + corners[:1], strict=True))
    return pairs if len(corners) > 2 else pairs[:1] if len(corners) == 2 else []


def _turn(a: Floats, b: Floats, c: Floats) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _svg(shapes: list[_Shape], size: tuple[float, float], broad: float) -> str:
    """y runs down on the sheet: heights are counted from its top."""
    width, height = size
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.6f}mm" height="{height:.6f}mm" '
        f'viewBox="0 0 {width:.6f} {height:.6f}" fill="none" stroke="black" stroke-width="{broad / 100:.6f}">'
    ]
    style = f'font-size="{broad / 5:.6f}" fill="black" stroke="none" text-anchor="middle"'
    for each in shapes:
        parts.append(f'<g id="{escape(visible(each.name), quote=True)}">')
        for (x1, y1), (x2, y2) in np.concatenate([each.edges, each.lines]).tolist():
            parts.append(f'<path d="M {x1:.6f} {height - y1:.6f} L {x2:.6f} {height - y2:.6f}"/>')
        for x, y, r, a, b in each.arcs:
            parts += _svg_arc(x, height - y, r, a, b)
        parts += [f'<circle cx="{x:.6f}" cy="{height - y:.6f}" r="{r:.6f}"/>' for x, y, r in each.holes]
        parts += [
            f'<text x="{x:.6f}" y="{height - y:.6f}" {style}>{escape(visible(t))}</text>' for x, y, t in each.texts
        ]
        parts.append("</g>")
    return "\n".join([*parts, "</svg>", ""])


def _svg_arc(x: float, y: float, r: float, begin: float, end: float) -> Iterator[str]:
    if end - begin >= 360.0:
        yield f'<circle cx="{x:.6f}" cy="{y:.6f}" r="{r:.6f}"/>'
        return
    a, b = np.radians([begin, end])
    large = int(end - begin > 180.0)
    start, stop = (f"{x + r * np.cos(t):.6f} {y - r * np.sin(t):.6f}" for t in (a, b))
    yield f'<path d="M {start} A {r:.6f} {r:.6f} 0 {large} 0 {stop}"/>'


def _dxf(shapes: list[_Shape], broad: float) -> str:
    """Group codes and values, a line each."""
    found: list[tuple[int, object]] = [(0, "SECTION"), (2, "ENTITIES")]
    for each in shapes:
        layer = (8, "".join(c if c.isascii() and c.isalnum() else "_" for c in each.name) or "0")
        for (x1, y1), (x2, y2) in np.concatenate([each.edges, each.lines]).tolist():
            found += [(0, "LINE"), layer, (10, x1), (20, y1), (11, x2), (21, y2)]
        for x, y, r, a, b in each.arcs:
            if b - a >= 360.0:
                found += [(0, "CIRCLE"), layer, (10, x), (20, y), (40, r)]
            else:
                found += [(0, "ARC"), layer, (10, x), (20, y), (40, r), (50, a), (51, b % 360.0)]
        for x, y, r in each.holes:
            found += [(0, "CIRCLE"), layer, (10, x), (20, y), (40, r)]
        for x, y, text in each.texts:
            words = visible(text).encode("ascii", "replace").decode()
            found += [(0, "TEXT"), layer, (10, x), (20, y), (40, broad / 5), (1, words)]
    found += [(0, "ENDSEC"), (0, "EOF")]
    return "".join(f"{code}\n{f'{value:.6f}' if isinstance(value, float) else value}\n" for code, value in found)
