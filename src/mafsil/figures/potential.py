"""Artificial potentials of two coordinates as pictures: lines of equal potential, local minima marked, a path.

Configuration-space obstacles of two or three joints as pictures: the patch of each obstacle in its own colour.
"""

from __future__ import annotations

from collections.abc import Iterable
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Truth, as_batch, require_kind, single, whole
from mafsil.collision import Checker
from mafsil.errors import InputError
from mafsil.figures.motion_over_time import COLOURS
from mafsil.figures.performance_sheet import INK, SINGULAR, flat_axes, save, sheet
from mafsil.figures.space import picture_file
from mafsil.messages import say
from mafsil.planning import PlanarArm, PotentialField, configuration_space_obstacles

SLICES = 6
"""Pictures of three joints, one for each of some values of the third."""


def plot_potential(
    field: PotentialField,
    path: str | PathLike[str],
    lower: ArrayLike,
    upper: ArrayLike,
    *,
    way: ArrayLike | None = None,
    cells: int = 120,
    starts: int = 40,
    language: str | None = None,
) -> None:
    """Draw a field of two coordinates: a ring at the goal, crosses at local minima, grey where no distance is left.

    Args:
        field: of a point in the plane, or of an arm of two joints.
        path: .png, .svg or .pdf.
        lower, upper: (2,) what is drawn [m | rad].
        way: (k, 2) a path that is drawn, if given.
        cells: of the grid, in each direction.
        starts: descents by which local minima are searched.
        language: of the labels; the current one if None.

    Raises:
        InputError: an ending of no picture, a field of more than two coordinates, a wrong shape.
    """
    file = picture_file(path)
    require_kind("field", field, "PotentialField", "potential", "minima", "goal")
    if field.goal.shape != (2,):
        raise InputError("input.shape", name="field.goal", expected=(2,), got=field.goal.shape, hint="")
    low, high = single("lower", lower, (2,)), single("upper", upper, (2,))
    count = whole("cells", cells, least=2)
    shares: Floats = np.arange(count) / (count - 1.0)
    x, y = (low[k] + shares * (high[k] - low[k]) for k in range(2))
    grid = np.stack([np.tile(x, (count, 1)), np.tile(y[:, None], (1, count))], axis=-1)
    U = field.potential(grid.reshape(-1, 2)).reshape(grid.shape[:2])
    finite = np.isfinite(U)
    figure = sheet(6.4, 5.4)
    plot: Any = figure.add_subplot(1, 1, 1)
    plot.contourf(x, y, np.where(finite, 0.0, 1.0), levels=[0.5, 1.5], colors=["#bbbbbb"])
    if finite.any():
        levels = np.unique(np.quantile(U[finite], np.linspace(0.0, 0.97, 24)))
        plot.contour(x, y, np.where(finite, U, np.nan), levels=levels, cmap="viridis", linewidths=0.8)
    minima = field.minima(low, high, starts=starts)
    label = say("planning.label_minimum", language=language)
    plot.plot(*minima.T, "x", color=SINGULAR, markersize=9, markeredgewidth=2.0, label=label)
    goal = say("planning.label_goal", language=language)
    plot.plot(*field.goal, "o", color=INK, markersize=9, markerfacecolor="none", markeredgewidth=2.0, label=goal)
    if way is not None:
        plot.plot(*as_batch("way", way, (2,), finite=True).T, color=INK, linewidth=1.4)
    flat_axes(plot, "x", "y")
    figure.legend(loc="outside upper center", ncols=2, fontsize=8, frameon=False)
    save(figure, file)


def plot_configuration_space(
    arm: PlanarArm | Checker,
    path: str | PathLike[str],
    *,
    cells: int = 200,
    joints: Iterable[str] | None = None,
    at: ArrayLike | None = None,
    way: ArrayLike | None = None,
    language: str | None = None,
) -> None:
    """Draw the configuration-space obstacles of an arm, in slices for three joints.

    Args:
        arm: among polygons, or any arm in its scene.
        path: .png, .svg or .pdf.
        cells, joints, at: as of `mafsil.planning.configuration_space_obstacles`.
        way: (k, n) configurations of a path that is drawn over two joints, if given [rad | m].
        language: of the labels; the current one if None.

    Raises:
        InputError: an ending of no picture, one joint, or what `configuration_space_obstacles` refuses.
    """
    file = picture_file(path)
    names = None if joints is None else tuple(joints)
    axes, patches = configuration_space_obstacles(arm, cells, joints=names, at=at)
    if len(axes) < 2:
        raise InputError("planning.one_painted")
    if isinstance(arm, Checker):
        known = [each.name for each in arm.robot.mechanism.coordinates]
        labels, kinds = list(names or known), [*arm.scene.names, arm.robot.name]
    else:
        known = labels = [f"q{k + 1}" for k in range(len(axes))]
        kinds = [say("planning.label_polygon", language=language, number=k + 1) for k in range(len(patches))]
    third: list[int | None] = [None]
    heights = axes[-1]
    if len(axes) > 2:
        third = [round(k * (len(heights) - 1) / (SLICES - 1)) for k in range(SLICES)]
    figure = sheet(6.0, 5.2) if len(axes) == 2 else sheet(10.5, 6.6)
    for i, k in enumerate(third):
        plot: Any = figure.add_subplot(1, 1, 1) if k is None else figure.add_subplot(2, SLICES // 2, i + 1)
        _paint(plot, axes, patches if k is None else patches[..., k])
        plot.set_xlabel(labels[0])
        plot.set_ylabel(labels[1])
        if k is not None:
            plot.set_title(f"{labels[2]} = {heights[k]:.3g}", fontsize=9)
    if way is not None and len(axes) == 2:
        rows = as_batch("way", way, (len(known),), finite=True)[..., [known.index(name) for name in labels]]
        figure.axes[0].plot(rows[..., 0], rows[..., 1], color=INK, linewidth=1.6)
    for k, kind in enumerate(kinds):
        if patches[k].any():
            figure.axes[0].plot([], [], "s", color=COLOURS[k % len(COLOURS)], alpha=0.7, label=kind)
    if patches.any():
        figure.legend(loc="outside upper center", ncols=6, fontsize=8, frameon=False)
    save(figure, file)


def _paint(plot: Any, axes: tuple[Floats, ...], patches: Truth) -> None:
    """The patches over each other, each half transparent."""
    (low, high), (bottom, top) = (_ends(axis) for axis in axes[:2])
    for k, patch in enumerate(patches):
        colour = tuple(int(COLOURS[k % len(COLOURS)][c : c + 2], 16) / 255.0 for c in (1, 3, 5))
        image = np.zeros((*patch.T.shape, 4))
        image[...] = (*colour, 0.0)
        image[patch.T, 3] = 0.7
        plot.imshow(image, extent=(low, high, bottom, top), origin="lower", aspect="auto", interpolation="nearest")


def _ends(axis: Floats) -> tuple[float, float]:
    """Where the cells of an axis begin and end."""
    half = (axis[-1] - axis[0]) / (2.0 * max(len(axis) - 1, 1))
    return float(axis[0] - half), float(axis[-1] + half)
