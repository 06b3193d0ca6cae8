"""Motion in coordinates and momenta: Hamilton's equations, and steps that make a discrete Lagrangian stationary.

In Hamilton's equations conserved momenta stay constant to the last bit. The variational integrator of the midpoint
rule,

L_d(q0, q1) = h L((q0 + q1) / 2, (q1 - q0) / h),  p0 = -dL_d/dq0,  p1 = dL_d/dq1,

conserves momenta of symmetries exactly and lets the energy oscillate, but not drift.

Reference: Marsden and West, Discrete mechanics and variational integrators, Acta Numerica 10, 2001.
"""

from __future__ import annotations

import mafsil.expression as ex
from mafsil.mechanics.body_tree import BodyTree, lump_bodies
from mafsil.mechanics.frame_choice import in_chosen_frames, regroup
from mafsil.mechanics.placement import Expression
from mafsil.mechanics.quantities.energy import kinetic_energy
from mafsil.mechanics.quantities.forward_dynamics import mass_matrix, solve_mass_matrix
from mafsil.mechanics.quantities.inverse_dynamics import inverse_dynamics
from mafsil.model import Mechanism


def lagrangian_slope(tree: BodyTree, q: Expression, qd: Expression) -> Expression:
    """DL/dq (n,) of L = K - P: half of qd' dM/dq_i qd, minus gravity; exactly zero for a cyclic coordinate.

    Args:
        tree: the bodies.
        q: (n,) symbols of the coordinates.
        qd: (n,) rates, any expression: they are fixed while the derivative is taken.
    """
    fixed = ex.symbol("fixed", tree.n)
    slope = ex.gradient(kinetic_energy(tree, q, fixed), q)
    still = ex.zeros(tree.n, 1)
    return ex.substitute(slope, fixed, qd) - inverse_dynamics(tree, q, still, still)


def hamiltonian_field(tree: BodyTree, q: Expression, p: Expression) -> tuple[Expression, Expression]:
    """Hamilton's equations without outside efforts: (qd, pd) = (M^-1 p, dL/dq).

    Args:
        tree: the bodies.
        q: (n,) symbols of the coordinates.
        p: (n,) momenta M qd.
    """
    qd = solve_mass_matrix(mass_matrix(tree, q), p)
    return qd, lagrangian_slope(tree, q, qd)


def function(mechanism: Mechanism) -> ex.Function:
    """Of (q, p) to the 2 n numbers (qd, pd).

    Args:
        mechanism: its numbers become constants.
    """
    n = mechanism.n
    q, p = ex.symbol("q", n), ex.symbol("p", n)
    column = ex.vertcat(*hamiltonian_field(regroup(in_chosen_frames(lump_bodies(mechanism))), q, p))
    return ex.Function("hamiltonian_field", [q, p], [ex.cse(column)])


def discrete_function(mechanism: Mechanism) -> ex.Function:
    """Of (q0, p0, v, load, h) to 3 n numbers: the next v of Newton's iteration, p1, and what is left of the equation.

    r(v) = M(q) v - h/2 (dL/dq(q, v) + load) - p0 at q = q0 + h v / 2; at its zero q1 = q0 + h v and
    p1 = p0 + h (dL/dq + load).

    Args:
        mechanism: its numbers become constants.
    """
    n = mechanism.n
    tree = regroup(in_chosen_frames(lump_bodies(mechanism)))
    q0, p0, v, load = (ex.symbol(name, n) for name in ("q0", "p0", "v", "load"))
    h, middle = ex.symbol("h", 1), ex.symbol("q", n)
    force = lagrangian_slope(tree, middle, v) + load
    residual_there = mass_matrix(tree, middle) @ v - (h / 2) * force - p0
    # The chain rule by hand: q moves by h/2 with v.
    slope_there = ex.jacobian(residual_there, v) + (h / 2) * ex.jacobian(residual_there, middle)
    residual, slope, impulse = ex.substitute([residual_there, slope_there, h * force], [middle], [q0 + (h / 2) * v])
    column = ex.vertcat(v - gauss_solve(slope, residual), p0 + impulse, residual)
    return ex.Function("variational_step", [q0, p0, v, load, h], [ex.cse(column)])


def gauss_solve(A: Expression, b: Expression) -> Expression:
    """x (n,) with A x = b for a matrix (n, n) close to a positive definite one: Gauss without exchange of rows.

    1. Forward: row k, times A_ik / A_kk, is taken from every row i below it; structural zeros cost nothing.
    2. Backward: x_k = (x_k - sum of A_kj x_j over j > k) / A_kk.
    """
    n = A.shape[0]
    A, x = ex.Expression(A), ex.Expression(b)
    # 1.
    for k in range(n):
        for i in range(k + 1, n):
            if A[i, k].is_zero():
                continue
            factor = A[i, k] / A[k, k]
            for j in range(k + 1, n):
                if not A[k, j].is_zero():
                    A[i, j] = A[i, j] - factor * A[k, j]
            x[i] = x[i] - factor * x[k]
    # 2.
    for k in reversed(range(n)):
        for j in range(k + 1, n):
            if not A[k, j].is_zero():
                x[k] = x[k] - A[k, j] * x[j]
        x[k] = x[k] / A[k, k]
    return x
