"""Flat maps of a workspace: reached cells, share of orientations, boundary and voids.

Maps of base placement from above: how many targets are reached from where, how well, and the best base.
"""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np

from mafsil.collision import Scene
from mafsil.collision.piece_loops import boxes_of
from mafsil.design import PayloadMap, ReachMap
from mafsil.design.slices import SliceMap
from mafsil.errors import InputError
from mafsil.figures.performance_sheet import INK, SHELL, SINGULAR, flat_axes, label, save, sheet
from mafsil.figures.space import picture_file
from mafsil.messages import say
from mafsil.performance.workspace import WorkspaceMap
from mafsil.planning import BasePlacement

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


def plot_payload_map(held: PayloadMap, path: str | PathLike[str], *, language: str | None = None) -> None:
    """Draw what an arm holds over a slice, one panel for each orientation of its tool; the dot is where it is least.

    Args:
        held: the map.
        path: .png, .svg or .pdf.
        language: of the labels; the current one if None.

    Raises:
        InputError: an ending of no picture.
    """
    path = picture_file(path)
    shown = np.ma.masked_invalid(held.payload)
    most = float(np.percentile(shown.compressed(), 95)) if shown.count() else 1.0
    figure, panels, image = _slice_panels(held, shown, "viridis", most)
    for axes in panels:
        axes.plot(*held.least_at, "o", color=SINGULAR, markersize=5)
    bar = figure.colorbar(image, ax=panels, shrink=0.8, pad=0.02, extend="max")
    bar.outline.set_visible(False)
    bar.set_label(label("payload", language))
    figure.suptitle(label("payload_map", language, robot=held.robot, least=held.least), fontsize=9)
    save(figure, path)


def plot_reach_map(reached: ReachMap, path: str | PathLike[str], *, language: str | None = None) -> None:
    """Draw where a tool gets in a slice, one panel for each orientation; crosses and circles are the voids.

    Args:
        reached: the map.
        path: .png, .svg or .pdf.
        language: of the labels; the current one if None.

    Raises:
        InputError: an ending of no picture.
    """
    path = picture_file(path)
    shown = np.ma.masked_equal((reached.distance == 0.0).astype(float), 0.0)
    figure, panels, _ = _slice_panels(reached, shown, "Blues", 2.0)
    for axes, voids in zip(panels, reached.voids, strict=True):
        for x, y, radius, _area in voids:
            axes.plot(x, y, "x", color=SINGULAR, markersize=6, markeredgewidth=1.4)
            if np.isfinite(radius):
                turn = np.linspace(0.0, 2 * np.pi, 73)
                axes.plot(x + radius * np.cos(turn), y + radius * np.sin(turn), color=SINGULAR, linewidth=1.0)
    details = {"robot": reached.robot, "voids": sum(map(len, reached.voids))}
    figure.suptitle(label("reach_map", language, **details), fontsize=9)
    save(figure, path)


def _slice_panels(values: SliceMap, shown: Any, colours: str, top: float) -> tuple[Any, list[Any], Any]:
    """Figure, axes and one image of cells (X, Y, K), a panel for each orientation of the tool."""
    count: int = shown.shape[2]
    figure = sheet(6.0 * count, 5.2)
    panels: Any = figure.subplots(1, count, squeeze=False)[0]
    image: Any = None
    for k, axes in enumerate(panels):
        edges = [np.append(c - values.cell / 2, c[-1] + values.cell / 2) for c in (values.x, values.y)]
        image = axes.pcolormesh(*edges, shown[..., k].T, cmap=colours, vmin=0.0, vmax=top, rasterized=True)
        flat_axes(axes, *_NAMES[values.plane])
        if len(values.rpy):
            axes.set_title(f"rpy = {', '.join(f'{angle:.3g}' for angle in values.rpy[k])} rad", fontsize=9)
    return figure, list(panels), image


def plot_placement(
    placement: BasePlacement, path: str | PathLike[str], *, scene: Scene | None = None, language: str | None = None
) -> None:
    """Draw the grid of base positions, each with the best of its heights and yaws.

    Left the share of the targets that are reached, right the score where all are; crosses are the targets, the arrow
    stands at the best base and points along its x axis, grey is what stands around.

    Args:
        placement: of an arm.
        path: .png, .svg or .pdf.
        scene: what stands around; half spaces are not drawn.
        language: of the labels; the current one if None.

    Raises:
        InputError: an ending of no picture.
    """
    file = picture_file(path)
    x, y, share, score = placement.score_map()
    figure = sheet(9.6, 4.6)
    for k, (values, colours, name) in enumerate(((share, "Blues", "share"), (score, "viridis", "score"))):
        axes: Any = figure.add_subplot(1, 2, k + 1)
        shown = np.ma.masked_where(values <= 0.0, values)
        top = 1.0 if k == 0 else max(float(score.max()), 1e-9)
        image = axes.pcolormesh(_edges(x), _edges(y), shown.T, cmap=colours, vmin=0.0, vmax=top, rasterized=True)
        for low, high in _footprints(scene):
            axes.fill_between([low[0], high[0]], low[1], high[1], facecolor="none", edgecolor=SHELL, linewidth=0.8)
        axes.plot(*placement.targets[:, :2, 3].T, "x", color=SINGULAR, markersize=6, markeredgewidth=1.4)
        T = placement.T_sb
        length = 0.08 * max(np.ptp(x), np.ptp(y), 0.5)
        axes.plot(*T[:2, 3], "o", color=INK, markersize=5, clip_on=False)
        axes.annotate(
            "",
            xy=T[:2, 3] + length * T[:2, 0],
            xytext=T[:2, 3],
            annotation_clip=False,
            arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 1.6},
        )
        flat_axes(axes, "x [m]", "y [m]")
        axes.set_title(say(f"planning.label_{name}", language=language), fontsize=9)
        bar = figure.colorbar(image, ax=axes, shrink=0.8, pad=0.02)
        bar.outline.set_visible(False)
    save(figure, file)


def _edges(centres: Any) -> Any:
    """Borders of cells around even centres."""
    step = (centres[-1] - centres[0]) / (len(centres) - 1) if len(centres) > 1 else 0.1
    return np.append(centres - step / 2, centres[-1] + step / 2)


def _footprints(scene: Scene | None) -> list[tuple[Any, Any]]:
    """Lower and upper corners, seen from above, of what has an end."""
    if scene is None or not len(scene):
        return []
    rows = boxes_of(scene.pieces)
    return [(row[:2], row[3:5]) for row in rows[np.isfinite(rows).all(axis=1)]]
