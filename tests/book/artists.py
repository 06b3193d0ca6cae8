"""Where the artists of a drawn figure are, by the names of their elements."""

from collections.abc import Callable
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.book import Figure


def drawn(figure: Figure) -> Callable[[str, str], Floats]:
    """Draw a figure once; gives (k, 2 | 3) points of the artist of a name on a panel, read back from matplotlib."""
    axes = dict(zip(figure.panels, figure.draw().axes, strict=True))

    def points(panel: str, name: str) -> Floats:
        return _points(next(each for each in axes[panel].get_children() if each.get_gid() == name))

    return points


def artist_points(figure: Figure, panel: str, name: str) -> Floats:
    """Points of one artist of a figure."""
    return drawn(figure)(panel, name)


def lines(figure: Figure, axes: int = 0) -> list[Floats]:
    """Points of every line of the axes of a figure, also of one that another module draws."""
    return [_points(line) for line in figure.draw().axes[axes].lines]


def _points(artist: Any) -> Floats:
    if hasattr(artist, "get_data_3d"):
        return np.array(artist.get_data_3d()).T
    if hasattr(artist, "xyann"):
        return np.array([artist.xyann, artist.xy])
    if hasattr(artist, "_segments3d"):
        return np.asarray(artist._segments3d[0])[::-1]  # matplotlib begins a quiver at its head
    if hasattr(artist, "_faces"):
        return np.asarray(artist._faces[0])
    if hasattr(artist, "get_xydata"):
        return np.asarray(artist.get_xydata())
    return np.asarray(artist.get_xy())
