"""A robot standing still, as a page to be turned around."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import as_batch
from mafsil.job.resting import resting_configuration
from mafsil.messages import language
from mafsil.model import Mechanism
from mafsil.model.loading import of_any_mechanism
from mafsil.report.page import render_picture
from mafsil.robot import Robot
from mafsil.scene import Drawing, as_data, compact, pack_floats
from mafsil.whole_file import write_whole


@of_any_mechanism
def write_picture(mechanism: Mechanism, path: Path, q: ArrayLike | None = None) -> None:
    """Write a self-contained HTML file that shows the robot in 3D.

    Args:
        mechanism: what to show.
        path: of the file; replaced at once when the page is whole.
        q: (n,) configuration [rad | m]; a relaxed one within the limits if None.
    """
    values = resting_configuration(mechanism) if q is None else as_batch("q", q, (mechanism.n,), finite=True)
    poses = np.asarray(Robot(mechanism).link_poses(values))
    tip = poses[mechanism.link_names.index(mechanism.tip)] @ mechanism.T_lt
    drawing = Drawing(mechanism)
    centre, size, floor = drawing.extent(np.vstack([poses[:, :3, 3], tip[:3, 3]]), poses)
    scene = as_data(drawing.bodies(floor, poses)) | {
        "poses": pack_floats(compact(poses)),
        "tip": compact(tip).tolist(),
        "centre": centre,
        "size": size,
        "floor": floor,
    }
    subtitle = " · ".join(mechanism.joint_names)
    write_whole(path, render_picture(mechanism.name, subtitle, scene, language()).encode())
