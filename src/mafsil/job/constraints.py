"""What moves of a job keep, as constraints of the planner and in words."""

from __future__ import annotations

import numpy as np

from mafsil.job.equipment import Equipment
from mafsil.job.keep_table import Keep
from mafsil.planning import FixedOrientation, InPlane, OnLine, Upright
from mafsil.planning.path_constraints import Constraint

WIDTH = 1e-3
"""Of lines and planes, where the job names none [m]."""


def constraints_of(keep: Keep, equipment: Equipment, unit: float) -> tuple[Constraint, ...]:
    """Constraints of the tip of the tool that is mounted, in the tip frame of the first one.

    Args:
        keep: of the move.
        equipment: the tool.
        unit: of angles [rad].
    """
    T = np.asarray(equipment.T_of_first)
    at, width = T[:3, 3], WIDTH if keep.tolerance is None else keep.tolerance
    found: list[Constraint] = []
    if keep.upright is not None:
        found.append(Upright(unit * keep.upright, axis=T[:3, 2]))
    if keep.orientation:
        found.append(FixedOrientation() if keep.angle is None else FixedOrientation(tolerance=unit * keep.angle))
    if keep.line is not None:
        found.append(OnLine(keep.line, tolerance=width, at=at))
    if keep.plane is not None:
        found.append(InPlane(keep.plane, tolerance=width, at=at))
    return tuple(found)
