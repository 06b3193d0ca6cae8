"""Frames in space with their letters, and the poses known between them."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix
from mafsil.figures import space
from mafsil.figures.space import picture_file
from mafsil.geometry import pose, rotation
from mafsil.geometry.frames import FrameGraph
from mafsil.messages import say


def plot_frames(
    frames: Mapping[str, ArrayLike], path: str | PathLike[str], edges: tuple[tuple[str, str], ...] = ()
) -> None:
    """Draw frames into a file.

    Args:
        frames: letter -> (4, 4) pose in one common frame.
        path: .png, .svg or .pdf.
        edges: pairs (a, b) between which an arrow T_ab is drawn.
    """
    path = picture_file(path)
    poses = {name: pose.check(T, name) for name, T in frames.items()}
    space.save(lambda: draw_frames(poses, edges), path)


def plot_frame_graph(graph: FrameGraph, root: str, path: str | PathLike[str]) -> None:
    """Draw all frames of a graph that a chain connects with a root, its known poses as arrows.

    Args:
        graph: poses of one value each.
        root: the frame from which the others are seen.
        path: .png, .svg or .pdf.
    """
    path = picture_file(path)
    frames = {name: graph.pose(root, name).array for name in graph.frames}
    edges = tuple(T.frames for T in graph.edges if T.frames is not None)
    plot_frames(frames, path, edges)


def draw_frames(frames: Mapping[str, PoseMatrix], edges: tuple[tuple[str, str], ...] = ()) -> Any:
    """A matplotlib figure of frames; arguments as for `plot_frames`."""
    figure, axes = space.sheet()
    origins = np.array([T[:3, 3] for T in frames.values()])
    size = max(float(np.ptp(origins, axis=0).max()), 1e-9) if len(frames) > 1 else 1.0
    length = 0.24 * size
    for name, T in frames.items():
        space.frame(axes, T, length, name)
    for a, b in edges:
        _edge(axes, frames[a][:3, 3], frames[b][:3, 3], f"$T_{{{a}{b}}}$")
    reach = [T[:3, 3] + 1.2 * length * T[:3, k] for T in frames.values() for k in range(3)]
    space.view(axes, np.array([*origins, *reach]))
    return figure


def _edge(axes: Any, start: Floats, end: Floats, text: str) -> None:
    space.line(axes, np.array([start, end]), space.SOFT, "--", 1.2)
    middle = start + 0.55 * (end - start)
    space.arrow(axes, middle, 0.06 * (end - start), space.SOFT, 1.4, 0.9)
    space.label(axes, start + 0.42 * (end - start), text, space.SECOND)


def plot_rotation(R: ArrayLike, path: str | PathLike[str]) -> None:
    """Draw a rotation into a file: {s}, {b}, the axis and the angle.

    Args:
        R: (3, 3) rotation R_sb.
        path: .png, .svg or .pdf.
    """
    path = picture_file(path)
    matrix = rotation.check(R)
    space.save(lambda: draw_rotation(matrix), path)


def draw_rotation(R: Floats) -> Any:
    """A matplotlib figure of a rotation; arguments as for `plot_rotation`."""
    figure, axes = space.sheet()
    axis, angle = rotation.to_axis_angle(R)
    T = pose.from_rotation_translation(R, np.zeros(3))
    space.frame(axes, np.eye(4), 1.0, "s", space.SOFT)
    space.frame(axes, T, 1.0, "b")
    if angle > 0:
        space.line(axes, np.array([-0.5 * axis, 1.35 * axis]), space.ACCENT, "-.")
        space.label(axes, 1.45 * axis, r"$\hat\omega$", space.ACCENT)
        for k in range(3):
            _sweep(axes, axis, float(angle), np.eye(3)[k], space.AXES[k])
    space.title(figure, say("pictures.rotation", angle=f"{np.degrees(angle):.4g}"))
    space.view(axes, np.array([-0.9 * np.ones(3), 1.1 * np.ones(3)]), 1.2)
    return figure


def _sweep(axes: Any, axis: Floats, angle: float, start: Floats, colour: str) -> None:
    """The arc along which the tip of a unit axis turns."""
    turns = rotation.from_axis_angle(axis, np.linspace(0.0, angle, 60))
    space.line(axes, turns @ start, colour, ":", 1.2)
