"""The drawing that travels with a Denavit-Hartenberg table: axes, link frames, common normals, and the table itself."""

from __future__ import annotations

from math import degrees
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, Vector3
from mafsil.figures.space import picture_file
from mafsil.model import Mechanism
from mafsil.model.denavit_hartenberg import Convention, DHRow
from mafsil.model.dh_frames import four_motions, frame_poses
from mafsil.model.dh_from_axes import DHTable
from mafsil.model.exponentials import chain_to_tip
from mafsil.model.loading import of_mechanism

_INK, _AXIS, _NORMAL, _OFFSET = "#39424a", "#8a949c", "#d9702a", "#7a4fb5"
_X, _Z = "#d33f3a", "#2f6fd0"
_SHORT = 1e-6
"""Lengths below this fraction of the arm's size are not drawn."""


@of_mechanism
def plot_dh_frames(mechanism: Mechanism, table: DHTable, path: str | PathLike[str], q: ArrayLike | None = None) -> None:
    """Draw the frames of a table into a file.

    Args:
        mechanism: the robot, for a configuration in which links do not lie on each other.
        table: in either convention; its own letters and normals are drawn.
        path: .png, .svg or .pdf.
        q: (n,) coordinates of the table's joints [rad | m]; a relaxed configuration if None.
    """
    path = picture_file(path)
    import matplotlib

    with matplotlib.rc_context({"svg.hashsalt": "mafsil", "font.size": 9, "text.color": _INK}):
        figure = draw_dh_frames(mechanism, table, q)
        undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(path.suffix.lower(), {})
        figure.savefig(path, dpi=160, bbox_inches="tight", pad_inches=0.08, metadata=undated)


def draw_dh_frames(mechanism: Mechanism, table: DHTable, q: ArrayLike | None = None) -> Any:
    """A matplotlib figure of the frames of a table, with the table beside it.

    Args:
        mechanism: the robot.
        table: in either convention.
        q: (n,) coordinates of the table's joints; a relaxed configuration if None.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    frames = frame_poses(table, _relax(mechanism) if q is None else q)
    size = max(float(np.ptp(frames[:, :3, 3], axis=0).max()), 0.05)
    figure = Figure(figsize=(9.0, 5.6))
    FigureCanvasAgg(figure)
    axes: Any = figure.add_axes((0.0, 0.0, 0.66, 1.0), projection="3d", computed_zorder=False)
    classic = table.convention is Convention.CLASSIC
    for frame, row in zip(frames[:-1] if classic else frames[1:], table.rows, strict=True):
        _axis(axes, frame, size, prismatic=row.kind == "P")
    for i in range(1, len(frames)):
        link = _classic_link if classic else _modified_link
        for start, end, colour, name in link(frames[i - 1], frames[i], i):
            _segment(axes, start, end, colour, name, size)
    arrows = _arrows(frames, size)
    for arrow in arrows:
        _arrow(axes, *arrow)
    _view(axes, np.array([tip for _, tip, _, _ in arrows] + [origin for origin, _, _, _ in arrows]))
    _numbers(figure, table)
    return figure


def _relax(mechanism: Mechanism) -> Floats:
    """Small angles, so that neighbouring links do not lie on one line; prismatic joints drawn out a little."""
    names = [joint.name for joint in chain_to_tip(mechanism) if joint.moves]
    places = [mechanism.joint_names.index(name) for name in names]
    lower, upper = mechanism.limits.lower[places], mechanism.limits.upper[places]
    bend = np.resize(np.array([0.35, 0.5, -0.6, 0.3, 0.45, -0.3, 0.2]), len(places))
    return np.clip(np.clip(0.0, lower, upper) + bend, lower, upper)


def _axis(axes: Any, frame: PoseMatrix, size: float, *, prismatic: bool) -> None:
    """A dash-dotted line along the joint's axis, doubled for a prismatic joint."""
    centre, z = frame[:3, 3], frame[:3, 2]
    ends = np.array([centre - 0.16 * size * z, centre + 0.30 * size * z])
    axes.plot(*ends.T, color=_AXIS, linewidth=2.4 if prismatic else 1.0, linestyle="-.", zorder=1)


Segment = tuple[Vector3, Vector3, str, str]
"""Ends, colour and letter of a length of a link."""


def _modified_link(before: PoseMatrix, after: PoseMatrix, i: int) -> tuple[Segment, Segment]:
    """Length a_(i-1) along x of {i-1}, then offset d_i along z of {i}."""
    start, end = before[:3, 3], after[:3, 3]
    corner = start + before[:3, 0] * (before[:3, 0] @ (end - start))
    return (start, corner, _NORMAL, f"a_{i - 1}"), (corner, end, _OFFSET, f"d_{i}")


def _classic_link(before: PoseMatrix, after: PoseMatrix, i: int) -> tuple[Segment, Segment]:
    """Offset d_i along z of {i-1}, then length a_i along x of {i}."""
    start, end = before[:3, 3], after[:3, 3]
    corner = start + before[:3, 2] * (before[:3, 2] @ (end - start))
    return (start, corner, _OFFSET, f"d_{i}"), (corner, end, _NORMAL, f"a_{i}")


def _segment(axes: Any, start: Vector3, end: Vector3, colour: str, name: str, size: float) -> None:
    if np.linalg.norm(end - start) > _SHORT * size:
        axes.plot(*np.array([start, end]).T, color=colour, linewidth=3.2, solid_capstyle="round", zorder=3)
        _label(axes, (start + end) / 2 + 0.02 * size, f"${name}$", colour)


def _arrows(frames: PoseMatrix, size: float) -> list[tuple[Vector3, Vector3, str, str]]:
    """Origin, tip, label and colour of every arrow x and z; equal ones of one place share an arrow."""
    arrows: list[tuple[Vector3, Vector3, str, str]] = []
    for column, colour, letter in ((0, _X, "x"), (2, _Z, "z")):
        groups: list[list[int]] = []
        for i in range(len(frames)):
            same = next((g for g in groups if _same_arrow(frames[g[0]], frames[i], column, size)), None)
            if same is None:
                groups.append([i])
            else:
                same.append(i)
        for group in groups:
            frame, length = frames[group[0]], (0.13 + 0.022 * group[0]) * size
            label = f"${letter}_{{{','.join(map(str, group))}}}$"
            arrows.append((frame[:3, 3], frame[:3, 3] + length * frame[:3, column], label, colour))
    return arrows


def _same_arrow(one: PoseMatrix, other: PoseMatrix, column: int, size: float) -> bool:
    apart = float(np.linalg.norm(one[:3, 3] - other[:3, 3])) / size
    return apart < _SHORT and float(np.linalg.norm(one[:3, column] - other[:3, column])) < _SHORT


def _arrow(axes: Any, origin: Vector3, tip: Vector3, label: str, colour: str) -> None:
    """An arrow with its name beyond its tip, the origin as a dot."""
    axes.plot(*origin[:, None], marker="o", color=_INK, markersize=3.5, zorder=6)
    axes.quiver(*origin, *(tip - origin), color=colour, linewidth=1.6, arrow_length_ratio=0.18, zorder=5)
    _label(axes, origin + 1.2 * (tip - origin), label, colour)


def _label(axes: Any, place: Vector3, text: str, colour: str) -> None:
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.6}
    axes.text(*place, text, color=colour, ha="center", va="center", zorder=8, bbox=box)


def _view(axes: Any, points: Floats, zoom: float = 1.1) -> None:
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    half = 0.56 * float(np.ptp(points, axis=0).max())
    for setter, c in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), centre, strict=True):
        setter(c - half, c + half)
    axes.set_box_aspect((1, 1, 1), zoom=zoom)
    axes.view_init(elev=22, azim=-60)
    axes.set_axis_off()


def _numbers(figure: Any, table: DHTable) -> None:
    """The table at the right, angles in degrees."""
    rows = [[str(i), *_cells(row, i)] for i, row in enumerate(table.rows, start=1)]
    head = ["$i$", r"$\alpha_{i-1}$", "$a_{i-1}$", "$d_i$", r"$\theta_i$"]
    if table.convention is Convention.CLASSIC:
        head = ["$i$", r"$\theta_i$", "$d_i$", "$a_i$", r"$\alpha_i$"]
        rows = [[i, *cells[::-1]] for i, *cells in rows]
    panel = figure.add_axes((0.665, 0.1, 0.325, 0.8))
    panel.set_axis_off()
    shown = panel.table(cellText=rows, colLabels=head, loc="center", cellLoc="center", edges="horizontal")
    shown.auto_set_font_size(False)
    shown.set_fontsize(9)
    shown.scale(1.0, 1.6)


def _cells(row: DHRow, i: int) -> list[str]:
    variable = f"$q_{i}$"
    zero = row.offset
    turn = f"{_round(degrees(row.theta + (zero if row.kind == 'R' else 0.0))):.5g}°"
    offset = f"{_round(row.d + (zero if row.kind == 'P' else 0.0)):.4g}"
    theta = _after(variable, turn) if row.kind == "R" else turn
    d = _after(variable, offset) if row.kind == "P" else offset
    return [f"{_round(degrees(row.alpha)):.5g}°", f"{_round(row.a):.4g}", d, theta]


def _after(variable: str, constant: str) -> str:
    """q, q + constant or q − constant."""
    if constant in ("0", "0°"):
        return variable
    return variable + (constant.replace("-", "−") if constant.startswith("-") else f"+{constant}")


def _round(value: float) -> float:
    return 0.0 if abs(value) < 1e-11 else value


def plot_link_motions(row: DHRow, path: str | PathLike[str], q: float = 0.0, convention: str = "modified") -> None:
    """Draw the four motions that carry {i-1} into {i}, one panel each: the frame before in grey, the frame after.

    Args:
        row: of a table.
        path: .png, .svg or .pdf.
        q: joint coordinate [rad | m].
        convention: `modified` or `classic`.
    """
    path = picture_file(path)
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    motions = four_motions(row, convention, q)
    frames = [np.eye(4), *(motion.frame for motion in motions)]
    origins = np.array([frame[:3, 3] for frame in frames])
    size = max(float(np.ptp(origins, axis=0).max()), 0.3)
    reach = np.vstack([origins, *(f[:3, 3] + 0.5 * size * f[:3, k] for f in frames for k in (0, 2))])
    figure = Figure(figsize=(13.0, 3.6))
    FigureCanvasAgg(figure)
    for k, motion in enumerate(motions):
        axes: Any = figure.add_subplot(1, 4, k + 1, projection="3d", computed_zorder=False)
        for frame, colours in ((frames[0], (_AXIS,) * 3), (frames[k], (_AXIS,) * 3), (frames[k + 1], (_X, _INK, _Z))):
            for column, colour in enumerate(colours):
                axes.quiver(*frame[:3, 3], *(0.5 * size * frame[:3, column]), color=colour, arrow_length_ratio=0.15)
        after = frames[k + 1]
        for column, (letter, colour) in enumerate(zip("xyz", (_X, _INK, _Z), strict=True)):
            _label(axes, after[:3, 3] + 0.62 * size * after[:3, column], f"${letter}$", colour)
        axes.set_title(f"{k + 1}. {motion.name} = {motion.value:.4g}", fontsize=9, y=0.98)
        _view(axes, reach, zoom=1.2)
    figure.subplots_adjust(left=0.0, right=1.0, top=0.92, bottom=0.0, wspace=0.0)
    figure.savefig(path, dpi=140, bbox_inches="tight", pad_inches=0.08)
