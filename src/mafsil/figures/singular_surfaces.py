"""Where an arm is singular: zeros of the determinant's factors in a plane of two joints, and where the tip is then."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.figures.performance_sheet import INK, SOFT, flat_axes, label, save, sheet
from mafsil.figures.space import picture_file
from mafsil.messages import direction
from mafsil.performance import determinant_factors, workspace_map
from mafsil.performance.singularities import DeterminantFactors
from mafsil.performance.velocity.scaling import prismatic_joints, ranges, require_one
from mafsil.robot import Robot, of_robot

_COLOURS = ("#c4312c", "#2f6fd0", "#2f9e57", "#8a4fb5", "#d9702a", "#39424a")


@of_robot
def save_singular_surfaces(
    robot: Robot,
    path: str | PathLike[str],
    *,
    joints: tuple[int, int] | None = None,
    at: ArrayLike | None = None,
    task: str | None = None,
    language: str | None = None,
) -> None:
    """Draw the zeros of each factor in a plane of two joints, and the section (rho, z) or (x, y) the tip reaches there.

    Args:
        robot: an arm whose determinant factors.
        path: .png, .svg or .pdf.
        joints: indices from 0 of the two joints of the plane; the two that most factors share if None.
        at: (n,) values of the other joints; the middles of their ranges if None.
        task: as for `determinant_factors`.
        language: of the labels; the current one if None.
    """
    path = picture_file(path)
    determinant = determinant_factors(robot, task)
    lower, upper = ranges(robot)
    rest = (lower + upper) / 2 if at is None else require_one("at", at, robot.n)
    i, j = _busiest(determinant, robot.n) if joints is None else joints
    figure = sheet(9.6, 4.6)
    left: Any = figure.add_subplot(1, 2, 1)
    right: Any = figure.add_subplot(1, 2, 2)
    x, y = (np.linspace(float(lower[k]), float(upper[k]), 301) for k in (i, j))
    grid = np.broadcast_to(rest, (len(y), len(x), robot.n)).copy()
    grid[..., i], grid[..., j] = np.meshgrid(x, y)
    flat = determinant.task in ("planar", "planar_position", "schoenflies")
    drawn = {k: rest[[k, k]] for k in range(robot.n)} | {i: x, j: y}
    _background(right, robot, flat, drawn)
    for k, values in enumerate(determinant.each(grid)):
        form = determinant.factors[k].form
        if form is not None and not {i, j} & set(form.joints):
            continue  # constant in this plane
        _curves(left, right, robot, grid, values, (x, y), (i, j), _COLOURS[k % len(_COLOURS)], flat)
        if values.min() < 0.0 < values.max():
            caption = _caption(determinant.factors[k].formula, language)
            left.plot([], [], color=_COLOURS[k % len(_COLOURS)], label=caption)
    flat_axes(left, f"q{i + 1} [rad]", f"q{j + 1} [rad]", equal=False)
    flat_axes(right, "x [m]" if flat else "ρ [m]", "y [m]" if flat else "z [m]")
    left.set_title(label("joint_space", language), fontsize=9)
    right.set_title(label("tip_space", language), fontsize=9)
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", frameon=False, fontsize=8)
    save(figure, path)


def _caption(formula: str, language: str | None) -> str:
    """The formula, kept left to right inside right-to-left words."""
    return f"{formula} = 0" if direction(language) == "ltr" else f"\u2066{formula} = 0\u2069"


def _busiest(determinant: DeterminantFactors, n: int) -> tuple[int, int]:
    uses = np.zeros(n)
    for factor in determinant.factors:
        if factor.form is not None:
            uses[list(factor.form.joints)] += len(factor.form.joints)
    first, second = np.sort(np.argsort(-uses, kind="stable")[:2])
    return int(first), int(second)


def _background(axes: Any, robot: Robot, flat: bool, drawn: Mapping[int, Floats]) -> None:
    """What the tip reaches at all, in grey; prismatic joints without limits in the drawn range, or fixed."""
    endless = prismatic_joints(robot) & (np.isinf(robot.limits.lower) | np.isinf(robot.limits.upper))
    given = {name: (float(drawn[k][0]), float(drawn[k][-1])) for k, name in enumerate(robot.joint_names) if endless[k]}
    workspace = workspace_map(robot, 200_000, view="xy" if flat else "radial", ranges=given)
    x, y = workspace.centres(0), workspace.centres(1)
    axes.contourf(x, y, workspace.reached.T.astype(float), levels=[0.5, 1.5], colors=[SOFT], zorder=0)
    axes.contour(x, y, workspace.reached.T.astype(float), levels=[0.5], colors=[INK], linewidths=0.5, zorder=1)


def _curves(
    left: Any,
    right: Any,
    robot: Robot,
    grid: Floats,
    values: Floats,
    plane: tuple[Floats, Floats],
    joints: tuple[int, int],
    colour: str,
    flat: bool,
) -> None:
    """Zero curves of a factor in the plane of joints, and their images under the forward kinematics."""
    if not (values.min() < 0.0 < values.max()):
        return
    drawn = left.contour(*plane, values, levels=[0.0], colors=[colour], linewidths=1.6)
    for segment in drawn.allsegs[0]:
        q = np.broadcast_to(grid[0, 0], (len(segment), robot.n)).copy()
        q[:, joints[0]], q[:, joints[1]] = segment.T
        p = robot.forward_kinematics(q)[:, :3, 3]
        image = p[:, :2] if flat else np.stack([np.hypot(p[:, 0], p[:, 1]), p[:, 2]], axis=1)
        right.plot(*image.T, color=colour, linewidth=1.4, zorder=2)
