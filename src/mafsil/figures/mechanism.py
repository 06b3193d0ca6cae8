"""A robot drawn in perspective: links, joint axes, base and tip frame."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, gate
from mafsil.job.resting import resting_place
from mafsil.model import JointKind, Mechanism
from mafsil.robot import Robot

_INK, _SHELL, _JOINT, _SOFT = "#39424a", "#9aa4ad", "#d9702a", "#c9ced2"
_AXES = ("#d33f3a", "#2f9e57", "#2f6fd0")


def save_mechanism(mechanism: Mechanism, path: Path, q: ArrayLike | None = None) -> None:
    """Draw a robot into a file.

    Args:
        mechanism: what to draw.
        path: .png, .svg or .pdf.
        q: (n,) configuration [rad | m]; a relaxed one within the limits if None.
    """
    import matplotlib

    with matplotlib.rc_context({"svg.hashsalt": "mafsil", "font.size": 8, "text.color": _INK}):
        figure = draw_mechanism(mechanism, q)
        figure.savefig(path, dpi=200, bbox_inches="tight", pad_inches=0.05, metadata=_metadata(path))


def draw_mechanism(mechanism: Mechanism, q: ArrayLike | None = None) -> Any:
    """A matplotlib figure of a robot.

    Args:
        mechanism: what to draw.
        q: (n,) configuration [rad | m]; a relaxed one within the limits if None.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    robot = Robot(mechanism)
    values = resting_place(mechanism.limits) if q is None else gate("q", q, (mechanism.n,), finite=True)
    poses = np.asarray(robot.link_poses(values))
    tip = poses[mechanism.link_names.index(mechanism.tip)] @ mechanism.T_lt
    points = np.vstack([poses[:, :3, 3], tip[:3, 3], [0.0, 0.0, 0.0]])
    size = max(float(np.ptp(points, axis=0).max()), 0.05)
    figure = Figure(figsize=(5.2, 5.2))
    FigureCanvasAgg(figure)
    axes: Any = figure.add_subplot(projection="3d", computed_zorder=False)
    _floor(axes, points, size)
    _links(axes, mechanism, poses, tip)
    _joints(axes, mechanism, poses, size)
    for pose, scale in ((np.eye(4), 0.14), (tip, 0.12)):
        _frame(axes, pose, scale * size)
    _view(axes, points, size)
    return figure


def _links(axes: Any, mechanism: Mechanism, poses: PoseMatrix, tip: PoseMatrix) -> None:
    """Lines from each link's own frame along its axis, then across, to what it carries."""
    ends = [(parent, poses[k + 1][:3, 3]) for k, parent in enumerate(mechanism.parents)]
    ends.append((mechanism.link_names.index(mechanism.tip), tip[:3, 3]))
    for parent, end in ends:
        start = poses[parent][:3, 3]
        axis = poses[parent][:3, :3] @ (mechanism.joints[parent - 1].axis if parent else np.array([0.0, 0.0, 1.0]))
        bend = start + axis * (axis @ (end - start))
        corners = np.array([start, bend, end])
        axes.plot(*corners.T, color=_INK, linewidth=9, solid_capstyle="round", solid_joinstyle="round", zorder=2)
        axes.plot(*corners.T, color=_SHELL, linewidth=7, solid_capstyle="round", solid_joinstyle="round", zorder=3)


def _joints(axes: Any, mechanism: Mechanism, poses: PoseMatrix, size: float) -> None:
    """A bar along each joint's axis."""
    for k, joint in enumerate(mechanism.joints):
        if not joint.moves:
            continue
        centre, axis = poses[k + 1][:3, 3], poses[k + 1][:3, :3] @ joint.axis
        half = 0.045 * size * axis
        style = {"linewidth": 11, "solid_capstyle": "butt", "zorder": 4}
        colour = _JOINT if joint.kind is not JointKind.PRISMATIC else _AXES[2]
        axes.plot(*np.array([centre - half, centre + half]).T, color=colour, **style)


def _frame(axes: Any, pose: PoseMatrix, length: float) -> None:
    """Red, green and blue arrows along x, y and z."""
    for k, colour in enumerate(_AXES):
        axes.quiver(
            *pose[:3, 3], *(length * pose[:3, k]), color=colour, linewidth=1.8, arrow_length_ratio=0.25, zorder=6
        )


def _floor(axes: Any, points: Floats, size: float) -> None:
    """A grid on z = 0."""
    decade = 10.0 ** np.floor(np.log10(size))
    pitch = next(step for step in (0.1 * decade, 0.2 * decade, 0.5 * decade, decade) if size / step <= 8.0)
    half = np.ceil(0.75 * size / pitch) * pitch
    centre = np.round(points.mean(axis=0)[:2] / pitch) * pitch
    for offset in np.arange(-half, half + pitch / 2, pitch):
        for line in (([-half, half], [offset, offset]), ([offset, offset], [-half, half])):
            axes.plot(centre[0] + line[0], centre[1] + line[1], [0, 0], color=_SOFT, linewidth=0.6, zorder=0)


def _view(axes: Any, points: Floats, size: float) -> None:
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    for setter, c in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), centre, strict=True):
        setter(c - 0.6 * size, c + 0.6 * size)
    axes.set_box_aspect((1, 1, 1))
    axes.view_init(elev=20, azim=-55)
    axes.set_axis_off()


def _metadata(path: Path) -> dict[str, Any]:
    """No dates in files: the same robot gives the same bytes."""
    return (
        {"Date": None}
        if path.suffix.lower() == ".svg"
        else {"CreationDate": None}
        if path.suffix.lower() == ".pdf"
        else {}
    )
