"""Flat maps of a workspace: reached cells, share of orientations, boundary and voids."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np

from mafsil.errors import InputError
from mafsil.figures.performance_sheet import INK, SINGULAR, flat_axes, label, save, sheet
from mafsil.figures.picture_file import picture_file
from mafsil.performance.workspace import WorkspaceMap

_NAMES = {"xy": ("x [m]", "y [m]"), "xz": ("x [m]", "z [m]"), "yz": ("y [m]", "z [m]")}


def save_workspace(workspace: WorkspaceMap, path: str | PathLike[str], *, language: str | None = None) -> None:
    """Draw a flat map: colour is the share of approach directions if recorded, else the density of samples.

    Args:
        workspace: made with a flat view.
        path: .png, .svg or .pdf.
        language: of the labels; the current one if None.

    Raises:
        InputError: the map is spatial.
    """
    path = picture_file(path)
    if workspace.counts.ndim != 2:
        raise InputError("performance.flat_view", view=workspace.view)
    figure = sheet(6.4, 5.4)
    axes: Any = figure.add_subplot()
    dexterous = workspace.directions is not None
    shown = workspace.dexterity if dexterous else np.log10(np.maximum(workspace.counts, 1))
    shown = np.ma.masked_where(~workspace.reached, shown)
    x, y = (workspace.centres(axis) for axis in (0, 1))
    edges = [np.append(c - workspace.cell / 2, c[-1] + workspace.cell / 2) for c in (x, y)]
    image = axes.pcolormesh(*edges, shown.T, cmap="Blues" if not dexterous else "viridis", rasterized=True)
    axes.contour(x, y, workspace.reached.T.astype(float), levels=[0.5], colors=INK, linewidths=1.0)
    for void in workspace.voids():
        axes.plot(void[0], void[1], "x", color=SINGULAR, markersize=7, markeredgewidth=1.6)
    radial = ("ρ [m]", "z [m]")
    flat_axes(axes, *_NAMES.get(workspace.view, radial))
    bar = figure.colorbar(image, ax=axes, shrink=0.8, pad=0.02)
    bar.outline.set_visible(False)
    bar.set_label(label("dexterity" if dexterous else "density", language))
    size, error = workspace.volume()
    details = {"robot": workspace.robot, "size": size, "error": error, "unit": _unit(workspace)}
    axes.set_title(label("workspace", language, **details), fontsize=9)
    save(figure, path)


def _unit(workspace: WorkspaceMap) -> str:
    return "m³" if workspace.view == "radial" else "m²"
