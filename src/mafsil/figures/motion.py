"""The picture that fits a motion: rotation, rings at a gimbal lock, screw motion, or pole in the plane."""

from __future__ import annotations

from os import PathLike

import numpy as np

from mafsil.arrays import PoseMatrix
from mafsil.figures.frames import plot_rotation
from mafsil.figures.gimbals import plot_gimbals
from mafsil.figures.picture_file import picture_file
from mafsil.figures.pole import plot_pole
from mafsil.figures.screw_motion import plot_screw_motion
from mafsil.geometry import euler


def plot_motion(T: PoseMatrix, path: str | PathLike[str], kind: str, sequence: str | None = None) -> None:
    """Draw a motion into a file.

    Args:
        T: (4, 4) pose.
        path: .png, .svg or .pdf.
        kind: `rotation`, `pose` or `planar`.
        sequence: of the angles in which a rotation was given: at a lock of it the rings are drawn.
    """
    path = picture_file(path)
    R = T[:3, :3]
    if kind == "planar":
        flat = np.eye(3)
        flat[:2, :2], flat[:2, 2] = T[:2, :2], T[:2, 3]
        plot_pole(flat, path)
    elif kind == "pose":
        plot_screw_motion(T, path)
    elif sequence is not None and euler.solutions(R, sequence).locked:
        plot_gimbals(euler.to_euler(R, sequence), sequence, path)
    else:
        plot_rotation(R, path)
