"""Panels as numbers that a page draws: flat shapes in a common view, and what changes from one drawing to another."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.figures.panel import Element, Panel
from mafsil.messages import in_line

WIDTH, HEIGHT, EDGE = 560.0, 440.0, 44.0
"""Of the view, and its border."""
MOST_POINTS, _GRID_LINES = 120, 9
"""Of a line or a polygon; of a surface in each direction."""
_LETTER = re.compile(r"\\([A-Za-z]+)\s?")
_DASHES = {"--": "7 5", "-.": "9 4 2 4", ":": "2 4"}


class PanelView:
    """The view that a panel keeps while sliders redraw it: it holds all of its drawings.

    Args:
        panels: its drawings.
    """

    def __init__(self, panels: Sequence[Panel]) -> None:
        first = panels[0]
        points = np.vstack([_flat(panel, one.points) for panel in panels for one in panel.elements])
        low, high = np.nanmin(points, axis=0), np.nanmax(points, axis=0)
        if first.limits:
            low, high = np.array(first.limits).reshape(2, 2).T
        span = np.maximum(high - low, 1e-9 + 1e-3 * float(np.max(high - low)))
        scale = np.array([WIDTH - 2 * EDGE, HEIGHT - 2 * EDGE]) / span
        if first.equal or first.dimension == 3:
            scale = np.full(2, scale.min())
        self._middle, self._scale, self._low, self._high = (low + high) / 2, scale, low, high

    def whole(self, panel: Panel) -> dict[str, Any]:
        """The panel with all its shapes, and its axes if it is a graph."""
        axes = {}
        if panel.labels:
            corners = np.array([self._low, self._high])
            axes = {
                "box": self._places(corners),
                "ends": corners.ravel().tolist(),
                "labels": [_plain(label) for label in panel.labels],
            }
        return {"shapes": [self._shape(panel, one) for one in panel.elements]} | axes

    def changes(self, panel: Panel | None, first: Panel) -> list[Any] | None:
        """What differs from the first drawing: for each shape 0, its new numbers, or all of it; None if it is gone."""
        if panel is None:
            return None
        before = [self._shape(first, one) for one in first.elements]
        now = [self._shape(panel, one) for one in panel.elements]
        if len(before) != len(now):
            return now
        looks = [{k: v for k, v in one.items() if k != "p"} for one in before]
        return [
            0 if one == old else one["p"] if look == {k: v for k, v in one.items() if k != "p"} else one
            for one, old, look in zip(now, before, looks, strict=True)
        ]

    def _shape(self, panel: Panel, element: Element) -> dict[str, Any]:
        shape: dict[str, Any] = {"k": element.kind, "c": element.colour, "w": element.width}
        if element.kind == "surface":
            rows, columns = (
                np.linspace(0, n - 1, min(n, _GRID_LINES), dtype=np.intp) for n in element.points.shape[:2]
            )
            lines = [*element.points[rows], *element.points[:, columns].swapaxes(0, 1)]
            return shape | {"a": element.alpha, "p": [self._places(_flat(panel, line)) for line in lines]}
        if element.alpha != 1:
            shape["a"] = element.alpha
        if element.kind == "label":
            shape |= {"t": _plain(element.text), "o": list(element.offset), "f": int(element.style == "code")}
        if element.style in _DASHES:
            shape["d"] = _DASHES[element.style]
        return shape | {"p": self._places(_flat(panel, element.points))}

    def _places(self, points: Floats) -> list[int]:
        """Tenths of a pixel from the middle of the view, y down; of long lines every so many points."""
        points = points[np.isfinite(points).all(axis=1)]
        if len(points) > MOST_POINTS:
            points = points[np.linspace(0, len(points) - 1, MOST_POINTS).round().astype(int)]
        return np.rint(10 * (points - self._middle) * self._scale * [1, -1]).astype(int).ravel().tolist()


def _flat(panel: Panel, points: Floats) -> Floats:
    """Points of the plane as they are, of space as the eye of the panel sees them."""
    if points.shape[-1] == 2:
        return points.reshape(-1, 2)
    up, round_about = np.radians([panel.elevation, panel.azimuth])
    s, c = np.sin(round_about), np.cos(round_about)
    across, upwards = [-s, c, 0.0], [-np.sin(up) * c, -np.sin(up) * s, np.cos(up)]
    return points.reshape(-1, 3) @ np.array([across, upwards]).T


def _plain(text: str) -> str:
    """A label without the signs of formulas: Greek letters as such, indices after `_`."""

    def letter(name: re.Match[str]) -> str:
        case = "SMALL" if name[1].islower() else "CAPITAL"
        found = f"GREEK {case} LETTER {name[1].upper().replace('LAMBDA', 'LAMDA')}"
        try:
            return unicodedata.lookup(found)
        except KeyError:
            return {"cdot": "·", "times": "×", "leq": "≤", "geq": "≥"}.get(name[1], "")

    return _LETTER.sub(letter, in_line(text)).replace("$", "")
