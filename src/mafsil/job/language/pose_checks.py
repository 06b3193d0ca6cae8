"""Whether a pose of a job file says one thing."""

from __future__ import annotations

import math
from typing import Any

from mafsil.job.description import Pose
from mafsil.job.language.frames import Complaint
from mafsil.job.language.statements import Placed, PlacedGoal
from mafsil.job.lines import Path

ORIENTATIONS = ("rpy", "quaternion", "look_at")


def check_pose(pose: Pose | Placed, path: Path, data: dict[str, Any], error: Complaint) -> None:
    """A place, at most one way to say the orientation; a quaternion that can be normalised."""
    given = [name for name in ORIENTATIONS if getattr(pose, name, None) is not None]
    if len(given) > 1:
        raise error("job.two_orientations", path, given=", ".join(given))
    if "position" not in data and not ("frame" in data or "relative" in data or path[0] in ("frame", "pattern")):
        raise error("job.missing_key", (*path, "position"))
    if isinstance(pose, PlacedGoal) and pose.task == "position":
        for name in given:
            raise error("job.free_orientation", (*path, name))
    if "look_at" in given and (
        getattr(pose, "relative", None) is not None or math.dist(pose.position, data["look_at"]) < 1e-9
    ):
        raise error("job.look_at", (*path, "look_at"))
    if pose.quaternion is not None and math.hypot(*pose.quaternion) < 1e-6:
        raise error("job.zero_quaternion", (*path, "quaternion"))
