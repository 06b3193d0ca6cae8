"""Where the artists of a drawn figure are, by the names of their elements."""

from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.book import Figure


def artist_points(figure: Figure, panel: str, name: str) -> Floats:
    """(k, 2 | 3) points of the artist of that name, read back from matplotlib."""
    sheet = figure.draw()
    axes = sheet.axes[list(figure.panels).index(panel)]
    artist: Any = next(each for each in axes.get_children() if each.get_gid() == name)
    if hasattr(artist, "get_data_3d"):
        return np.array(artist.get_data_3d()).T
    if hasattr(artist, "xyann"):
        return np.array([artist.xyann, artist.xy])
    if hasattr(artist, "get_xydata"):
        return np.asarray(artist.get_xydata())
    if hasattr(artist, "_segments3d"):
        return np.asarray(artist._segments3d[0])
    return np.asarray(artist.get_xy())
