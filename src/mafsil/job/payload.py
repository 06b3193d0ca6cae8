"""Tools on the flange, and where they hold things."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.job.description import Grasp, Tool
from mafsil.job.poses import pose_matrix
from mafsil.model import Mechanism


def with_tool(mechanism: Mechanism, tool: Tool, *, degrees: bool) -> Mechanism:
    """The mechanism with a tool on its flange: another tip frame, one more mass.

    Raises:
        ModelError: the tool's link does not exist.
    """
    link = tool.link or mechanism.tip
    if tool.offset is None and tool.link is None:
        return mechanism.with_payload(tool.mass, com=tool.com, link=link)
    offset = None if tool.offset is None else pose_matrix(tool.offset, degrees=degrees)
    return mechanism.with_tool(offset, mass=tool.mass, com=tool.com, link=link)


def box_inertia(grasp: Grasp) -> Floats:
    """(3, 3) rotational inertia of the box about its centre [kg m^2]."""
    a, b, c = (edge**2 for edge in grasp.size)
    return grasp.mass / 12 * np.diag([b + c, a + c, a + b])


def box_in_tip(grasp: Grasp) -> PoseMatrix:
    """(4, 4) pose of the box in the tip frame."""
    T = np.eye(4)
    T[:3, 3] = grasp.offset
    return T
