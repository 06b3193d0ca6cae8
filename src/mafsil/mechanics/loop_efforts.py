"""Efforts of driven joints of a closed chain, as expressions of fixed size: for a motion, and to hold it up.

Motions that the loops allow feel only efforts, no forces of the loops. With P the orthogonal projection on them and S
the columns of the driven joints, efforts tau do what is needed, w, if P S tau = P w:

1. K = S' P S and b = S' P w, of a driven joints and d freedoms.
2. a <= d: tau = K^-1 b. a > d: the d equations `deciding` say it all, the shortest tau = K_T' (K_T K_T')^-1 b_T.
3. The rest w - S tau is carried by the loops: J_B J_B' x = J_B (w - S tau).

Reference: Nakamura and Ghodoussi, Dynamics computation of closed-link robot mechanisms with nonredundant and redundant
actuators, IEEE Trans. Rob. Autom. 5, 1989.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mafsil.expression as ex
from mafsil.mechanics.body_tree import lumped
from mafsil.mechanics.branch_factor import BranchFactor
from mafsil.mechanics.frame_choice import in_chosen_frames
from mafsil.mechanics.loop_constraints import loops
from mafsil.mechanics.loop_dynamics import HeldTree, pivot_doubt, spread
from mafsil.mechanics.placement import Expression
from mafsil.mechanics.quantities.inverse_dynamics import inverse_dynamics
from mafsil.mechanics.regrouping import regrouped
from mafsil.model import Mechanism


@dataclass(frozen=True, eq=False, slots=True)
class Efforts:
    """Efforts tau (a,), what is then left to the loops (n,), P S (n, a), and what speaks against them all."""

    tau: Expression
    rest: Expression
    allowed: Expression
    doubt: Expression


def efforts(held: HeldTree, w: Expression, driven: Sequence[int], deciding: Sequence[int]) -> Efforts:
    """The shortest efforts of the driven joints that do what is needed, as far as they can.

    Args:
        held: the loops with the unit matrix in place of a mass matrix.
        w: (n,) efforts that are needed.
        driven: coordinates of the driven joints.
        deciding: which of them decide, as many as freedoms or as driven joints.
    """
    n = held.n
    columns = [held.closing(spread(ex.ones(1), [k], n)) for k in driven]
    allowed = ex.horzcat(*columns) if columns else ex.zeros(n, 0)
    if not columns:
        return Efforts(ex.zeros(0, 1), w, allowed, held.doubt)
    b = allowed.T @ w
    K = ex.vertcat(*(allowed[k, :] for k in driven))
    if len(deciding) == len(driven):
        A, right, back = K, b, ex.eye(len(driven))
    else:
        across = ex.vertcat(*(K[k, :] for k in deciding))
        A, right, back = across @ across.T, ex.vertcat(*(b[k] for k in deciding)), across.T
    factor = BranchFactor(A)
    tau = back @ ex.vertcat(*factor.solved(list(right)))
    return Efforts(tau, w - spread(tau, driven, n), allowed, held.doubt + pivot_doubt(factor, A))


def accelerations_of_all(
    J: Expression, gamma: Expression, given: Expression, driven: Sequence[int], chosen: Sequence[int]
) -> tuple[Expression, Expression]:
    """Accelerations (n,) of all joints that keep the loops closed, from those of the driven joints; and the doubt.

    Args:
        J, gamma: (m, n), (m,) rows of the loops and their bias.
        given: (a,) accelerations of the driven joints.
        driven: their coordinates.
        chosen: independent rows.
    """
    n = J.shape[1]
    others = [k for k in range(n) if k not in driven]
    part = spread(given, driven, n)
    if not others:
        return part, ex.Expression(0)
    across, missing = ex.horzcat(*(J[:, k] for k in others)), J @ part + gamma
    if len(others) >= len(chosen):
        held = HeldTree(ex.eye(len(others)), across, chosen)
        change, doubt = held.accelerations(ex.zeros(len(others), 1), missing)[0], held.doubt
    else:
        A = across.T @ across
        factor = BranchFactor(A)
        change, doubt = -ex.vertcat(*factor.solved(list(across.T @ missing))), pivot_doubt(factor, A)
    return part + spread(change, others, n), doubt


def inverse_function(
    mechanism: Mechanism, chosen: Sequence[int], driven: Sequence[int], deciding: Sequence[int]
) -> ex.Function:
    """Efforts for a motion: q, qd, qdd (n,) to tau (a,), force (m,), missing, broken, needed, P S (n, a) and doubt.

    Missing is the size of what no driven joint makes, broken the acceleration with which the motion opens a loop, and
    needed the size of the efforts that the tree needs.

    Args:
        mechanism: with loops.
        chosen: independent rows.
        driven, deciding: as for `efforts`.
    """
    n = mechanism.n
    full = in_chosen_frames(lumped(mechanism))
    q, qd, qdd = ex.symbol("q", n), ex.symbol("qd", n), ex.symbol("qdd", n)
    asked = loops(full, mechanism.loops, q, qd)
    held = HeldTree(ex.eye(n), asked.rows, chosen)
    w = inverse_dynamics(regrouped(full), q, qd, qdd)
    found = efforts(held, w, driven, deciding)
    force = held.forces(held.carried(found.rest))
    missing = ex.sqrt(ex.sumsqr(held.closing(found.rest)))
    broken = ex.Expression(0)
    for each in asked.rows @ qdd + asked.bias:
        broken = ex.if_else(ex.fabs(each) <= broken, broken, ex.fabs(each))
    doubt = found.doubt + held.finite(ex.vertcat(found.tau, w))
    outputs = [found.tau, force, missing, broken, ex.sqrt(ex.sumsqr(w)), ex.vec(found.allowed.T), doubt]
    return ex.Function("closed_inverse_dynamics", [q, qd, qdd], ex.cse(outputs))
