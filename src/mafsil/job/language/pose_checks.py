"""Whether a pose of a job file says one thing."""

from __future__ import annotations

import math
from typing import Any

from mafsil.job.description import Pose
from mafsil.job.language.frames import Complaint
from mafsil.job.language.statements import Placed, PlacedGoal
from mafsil.job.lines import Path


def check_pose(pose: Pose | Placed, path: Path, data: dict[str, Any], error: Complaint) -> None:
    """A place, at most one way to say the orientation; a quaternion that can be normalised."""
    if pose.rpy is not None and pose.quaternion is not None:
        raise error("job.two_orientations", path)
    if "position" not in data and not ("frame" in data or "relative" in data or path[0] in ("frame", "pattern")):
        raise error("job.missing_key", (*path, "position"))
    if isinstance(pose, PlacedGoal) and pose.task == "position":
        for name in ("rpy", "quaternion"):
            if getattr(pose, name) is not None:
                raise error("job.free_orientation", (*path, name))
    if pose.quaternion is not None and math.hypot(*pose.quaternion) < 1e-6:
        raise error("job.zero_quaternion", (*path, "quaternion"))
