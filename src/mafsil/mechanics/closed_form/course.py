"""The branches of a closed form along the value of one held joint: what interval arithmetic is done with."""

from __future__ import annotations

from collections.abc import Sequence

import mafsil.expression as ex
from mafsil.kernels.tape import Tape, read
from mafsil.mechanics.arm_pattern import ArmPattern
from mafsil.mechanics.closed_form.table import motions_along


def course_tape(pattern: ArmPattern, held: int, near: Sequence[float]) -> Tape:
    """The program of (T_sd, value) to all branches.

    Args:
        pattern: of the arm, one joint held.
        held: its coordinate.
        near: (n,) what free joints take.

    Returns:
        Inputs: the pose (16) and the value of the held joint (1). Outputs, one port for every branch: (2 n + 1) cosine
        and sine of every coordinate but the held one, of a slide its value and zero, and by how much the worst step
        misses.
    """
    T, value = ex.symbol("T_sd", 16), ex.symbol("value")
    branches = motions_along(pattern, ex.reshape(T, 4, 4).T, held, value, near)
    return read(ex.Function("course", [T, value], ex.cse([ex.vertcat(*row) for row in branches])))
