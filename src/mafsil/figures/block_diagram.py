"""Block diagrams of laws, and a response with the poses of the arm beside it."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np

from mafsil.arrays import Floats, require_kind
from mafsil.control.analysis import BlockDiagram
from mafsil.figures.motion_over_time import COLOURS
from mafsil.figures.performance_sheet import flat_axes, legend, save, sheet
from mafsil.figures.space import picture_file
from mafsil.messages import say
from mafsil.model import JointKind
from mafsil.robot import Robot
from mafsil.simulation import Recording

WIDE, HIGH = 2.6, 1.1
"""Of a column and a row [inch]."""
NAMED = ("trajectory", "amplifier", "actuator", "arm", "sensors", "delay")
"""Blocks whose names are words."""


def plot_block_diagram(diagram: BlockDiagram, path: str | PathLike[str], *, language: str | None = None) -> None:
    """Draw a block diagram: blocks in columns, arrows between them, feedback below.

    Args:
        diagram: of `mafsil.control.block_diagram`.
        path: .png, .svg or .pdf.
        language: of the names; the current one if None.

    Raises:
        InputError: no diagram, or an ending of no picture.
    """
    file = picture_file(path)
    require_kind("diagram", diagram, "BlockDiagram", "blocks", "arrows")
    columns = 1 + max(block.column for block in diagram.blocks)
    rows = 2 + max(block.row for block in diagram.blocks)
    figure = sheet(WIDE * columns, HIGH * rows)
    axes: Any = figure.subplots()
    axes.set(xlim=(-0.5, columns - 0.5), ylim=(-rows + 0.5, 0.5))
    axes.set_axis_off()
    place = {block.name: (float(block.column), -float(block.row)) for block in diagram.blocks}
    boxes: dict[str, Any] = {}
    for block in diagram.blocks:
        name = say(f"pictures.block_{block.name}", language=language) if block.name in NAMED else ""
        words = "\n".join(part for part in (name, block.text) if part)
        frame = {"boxstyle": "round,pad=0.5", "facecolor": "white", "edgecolor": COLOURS[0]}
        text = axes.text(*place[block.name], words, fontsize=8, ha="center", va="center", bbox=frame, zorder=2)
        boxes[block.name] = text.get_bbox_patch()
    figure.canvas.draw()
    for arrow in diagram.arrows:
        start, end = place[arrow.start], place[arrow.end]
        bend = 0.0 if end[0] > start[0] or arrow.start == "arm" else -0.25 if arrow.start == "sensors" else 0.35
        axes.annotate(
            "", end, start, zorder=1,
            arrowprops={
                "arrowstyle": "-|>", "color": "0.35", "shrinkA": 1, "shrinkB": 1,
                "patchA": boxes[arrow.start], "patchB": boxes[arrow.end],
                "connectionstyle": f"arc3,rad={bend}",
            },
        )  # fmt: skip
        if arrow.signal and end[0] >= start[0]:
            x, y = _between(axes, boxes[arrow.start], boxes[arrow.end], start, end)
            paper = {"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none"}
            axes.text(x, y, arrow.signal, fontsize=7, ha="center", va="center", color="0.35", bbox=paper, zorder=1.5)
    save(figure, file)


def _between(
    axes: Any, first: Any, second: Any, start: tuple[float, float], end: tuple[float, float]
) -> tuple[float, float]:
    """The middle of an arrow between two boxes, in the coordinates of the axes."""
    boxes = [axes.transData.inverted().transform_bbox(box.get_window_extent()) for box in (first, second)]
    if end[0] == start[0]:
        return start[0], (boxes[0].y0 + boxes[1].y1) / 2.0
    x = (boxes[0].x1 + boxes[1].x0) / 2.0
    return x, start[1] + (end[1] - start[1]) * (x - start[0]) / (end[0] - start[0])


def plot_response(
    recording: Recording, robot: Robot, path: str | PathLike[str], *, language: str | None = None
) -> None:
    """Draw the joints of one run over their reference, and beside it the arm where it began and where it ended.

    Args:
        recording: of one run.
        robot: that moved.
        path: .png, .svg or .pdf.
        language: of the labels; the current one if None.

    Raises:
        InputError: no recording of this robot, or an ending of no picture.
    """
    file = picture_file(path)
    require_kind("recording", recording, "Recording", "q_ref", "q")
    figure = sheet(8.0, 3.2)
    pose_axes, response = figure.subplots(1, 2, width_ratios=(1, 2))
    drawn: Any = response
    for k, name in enumerate(robot.joint_names):
        colour = COLOURS[k % len(COLOURS)]
        drawn.plot(recording.t, recording.q[:, k], color=colour, linewidth=1.2, label=name)
        drawn.plot(recording.t, recording.q_ref[:, k], color=colour, linewidth=0.8, linestyle="--")
    drawn.plot([], [], color="0.35", linewidth=0.8, linestyle="--", label=say("pictures.reference", language=language))
    units = {"m" if one.kind is JointKind.PRISMATIC else "rad" for one in robot.mechanism.joints if one.moves}
    position = say("pictures.position_of_joints", language=language, unit=" | ".join(sorted(units, reverse=True)))
    legend(drawn)
    flat_axes(drawn, "t [s]", position, equal=False)
    poses = {"pose_start": recording.q[0], "pose_end": recording.q[-1]}
    lines = {key: skeleton(robot, q) for key, q in poses.items()}
    axes_shown = np.argsort(-np.ptp(np.concatenate(list(lines.values())), axis=0), kind="stable")[:2]
    beside: Any = pose_axes
    for (key, line), colour in zip(lines.items(), ("0.6", COLOURS[0]), strict=True):
        label = say(f"pictures.{key}", language=language)
        beside.plot(line[:, axes_shown.min()], line[:, axes_shown.max()], "o-", color=colour, markersize=3, label=label)
    legend(beside)
    flat_axes(beside, "xyz"[axes_shown.min()] + " [m]", "xyz"[axes_shown.max()] + " [m]")
    save(figure, file)


def skeleton(robot: Robot, q: Floats) -> Floats:
    """(joints + 2, 3) origins of the links of a chain from the base to the tip, in {s} [m].

    Args:
        robot: whose chain it is.
        q: (n,) configuration.
    """
    places = [robot.forward_kinematics(q, frame=link.name)[:3, 3] for link in robot.mechanism.links]
    return np.array([*places, robot.forward_kinematics(q)[:3, 3]])
