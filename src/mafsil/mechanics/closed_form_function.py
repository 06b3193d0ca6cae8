"""The closed form of an arm as a casadi.Function with one column per port."""

from __future__ import annotations

import casadi as ca

from mafsil.mechanics.arm_pattern import ArmPattern
from mafsil.mechanics.closed_form import closed_form


def function(pattern: ArmPattern, near: bool) -> ca.Function:
    """Of (T_sd[, near]) to the table of branches, row by row.

    Args:
        pattern: of the arm.
        near: whether the coordinates of free joints are an input.
    """
    T = ca.SX.sym("T_sd", 16)
    preferred = ca.SX.sym("near", pattern.n)
    table = closed_form(pattern, ca.reshape(T, 4, 4).T, preferred if near else None)
    column = ca.densify(ca.vec(table.T))
    return ca.Function("closed_form", [T, preferred] if near else [T], [ca.cse(column)])
