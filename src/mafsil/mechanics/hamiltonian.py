"""Motion in coordinates and momenta: Hamilton's equations, in which conserved momenta stay constant to the last bit."""

from __future__ import annotations

import mafsil.expression as ex
from mafsil.mechanics.body_tree import BodyTree, lump_bodies
from mafsil.mechanics.frame_choice import in_chosen_frames, regroup
from mafsil.mechanics.placement import Expression
from mafsil.mechanics.quantities.energy import kinetic_energy
from mafsil.mechanics.quantities.forward_dynamics import solve_mass_matrix
from mafsil.mechanics.quantities.inverse_dynamics import inverse_dynamics
from mafsil.mechanics.quantities.mass_matrix import mass_matrix
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
