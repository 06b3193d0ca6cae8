"""All configurations of a pose, by every method that Python has: closed forms, elimination, search."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from mafsil.errors import InputError
from mafsil.ik import Branch, SolutionSet, inverse_kinematics
from mafsil.page.arm import Arm
from mafsil.page.session import pose_from
from mafsil.studio.protocol import Pose
from mafsil.studio.sentences import in_all_languages

MOST_SHOWN = 64


def configurations(arm: Arm, asked: Pose) -> Mapping[str, Any]:
    """The configurations that bring the tip to a pose, as data for a window.

    Args:
        arm: whose tip; with fewer than six joints only the position counts.
        asked: the pose, and where the arm is.

    Raises:
        InputError: the pose is none, or there are not as many coordinates as joints.
    """
    robot = arm.robot
    if len(asked.q) != robot.n:
        raise InputError("session.count", got=len(asked.q), wanted=robot.n)
    T = np.array(pose_from(asked.position, asked.quaternion)).reshape(4, 4)
    found = inverse_kinematics(robot, T, q0=np.array(asked.q), task="pose" if arm.rotates else "position")
    assert isinstance(found, SolutionSet)
    order = np.argsort(~found.within, kind="stable")[:MOST_SHOWN]
    branches: tuple[Branch, ...] = found.branches
    return {
        "count": len(found),
        "sentence": in_all_languages(found.explain),
        "rows": [
            {
                "q": found.q[k].tolist(),
                "within": bool(found.within[k]),
                "residual": float(found.residual[k]),
                **in_all_languages(branches[k].label),
            }
            for k in map(int, order)
        ],
    }
