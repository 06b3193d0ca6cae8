"""The branches of a closed form along the value of one locked joint: what interval arithmetic is done with."""

from __future__ import annotations

from collections.abc import Sequence

import mafsil.expression as ex
from mafsil.kernels.tape import Tape, read
from mafsil.mechanics.arm_pattern import ArmPattern
from mafsil.mechanics.closed_form.table import motions_along


def locked_joint_tape(pattern: ArmPattern, locked: int, q0: Sequence[float]) -> Tape:
    """The program of (T_sd, value) to all branches.

    Args:
        pattern: of the arm, one joint locked.
        locked: its coordinate.
        q0: (n,) what free joints take.

    Returns:
        Inputs: the pose (16) and the value of the locked joint (1). Outputs, one port for every branch: (2 n + 1)
            cosine
        and sine of every coordinate but the locked one, of a prismatic joint its value and zero, and residual of the
        worst subproblem.
    """
    T, value = ex.symbol("T_sd", 16), ex.symbol("value")
    branches = motions_along(pattern, ex.reshape(T, 4, 4).T, locked, value, q0)
    return read(ex.Function("course", [T, value], ex.cse([ex.vertcat(*row) for row in branches])))
