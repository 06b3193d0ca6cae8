"""Tools on the flange, and where they hold things."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.job.description import Grasp, Tool
from mafsil.job.poses import pose_matrix
from mafsil.model import Mechanism
from mafsil.model.tolerances import WRITTEN


def with_tool(mechanism: Mechanism, tool: Tool, *, degrees: bool) -> Mechanism:
    """The mechanism with a tool: another tip frame, one more mass; on the flange, or on the link that the tool names.

    Raises:
        ModelError: the tool's link does not exist.
    """
    offset = None if tool.offset is None else pose_matrix(tool.offset, degrees=degrees)
    return mechanism.with_tool(offset, mass=tool.mass, com=tool.com, link=tool.link)


def part_inertia(grasp: Grasp) -> Floats:
    """(3, 3) rotational inertia of a part about its centre of mass [kg m^2]; of an even box if it names none."""
    if grasp.inertia is None:
        a, b, c = (edge**2 for edge in grasp.size)
        return grasp.mass / 12 * np.diag([b + c, a + c, a + b])
    xx, yy, zz, xy, xz, yz = (*grasp.inertia, 0.0, 0.0, 0.0)[:6]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def centre_of_mass(grasp: Grasp) -> Floats:
    """(3,) of a part, in the tip frame [m]."""
    return np.add(grasp.offset, grasp.com)


def is_possible(grasp: Grasp) -> bool:
    """Whether some body has the inertia of a part: three or six numbers, moments that keep the triangle inequality."""
    if grasp.inertia is not None and len(grasp.inertia) not in (3, 6):
        return False
    moments = np.linalg.eigvalsh(part_inertia(grasp))
    return bool(moments[0] >= 0.0 and moments[0] + moments[1] >= moments[2] * (1.0 - WRITTEN))


def box_in_tip(grasp: Grasp) -> PoseMatrix:
    """(4, 4) pose of the box in the tip frame."""
    T = np.eye(4)
    T[:3, 3] = grasp.offset
    return T
