"""What moves of a job keep, as constraints of the planner and in words."""

from __future__ import annotations

import numpy as np

from mafsil.job.constraint_table import PathConstraints
from mafsil.job.equipment import Equipment
from mafsil.planning import FixedOrientation, InPlane, OnLine, Upright
from mafsil.planning.path_constraints import Constraint

WIDTH = 1e-3
"""Of lines and planes, where the job names none [m]."""


def constraints_of(constraints: PathConstraints, equipment: Equipment, unit: float) -> tuple[Constraint, ...]:
    """Constraints of the tip of the tool that is mounted, in the tip frame of the first one.

    Args:
        constraints: of the move.
        equipment: the tool.
        unit: of angles [rad].
    """
    T = np.asarray(equipment.T_of_first)
    at, width = T[:3, 3], WIDTH if constraints.tolerance is None else constraints.tolerance
    found: list[Constraint] = []
    if constraints.upright is not None:
        found.append(Upright(unit * constraints.upright, axis=T[:3, 2]))
    if constraints.orientation:
        found.append(
            FixedOrientation() if constraints.angle is None else FixedOrientation(tolerance=unit * constraints.angle)
        )
    if constraints.line is not None:
        found.append(OnLine(constraints.line, tolerance=width, at=at))
    if constraints.plane is not None:
        found.append(InPlane(constraints.plane, tolerance=width, at=at))
    return tuple(found)
