"""Derivatives of inverse and forward dynamics in closed form: a sweep out, one in, few vectors per pair of joints.

The velocities of a body are taken relative to the origin of its own frame. Then the composite body behind joint i is
described by its mass, first moment h, inertia I, p = twice its linear momentum and W = twice the integral of v r' dm,
and the wrench that a change X = (xi, x) of its twist demands on top of G dX/dt is 2 B X = (N xi, xi x p) with
N = tr(W) E - W: it needs the angular part alone.

Reference: Singh, Wensing & Echeandia, Efficient analytical derivatives of rigid-body dynamics using spatial vector
algebra, IEEE RA-L 7, 2022 (the recursion over composite bodies); Carpentier & Mansard, RSS 2018.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.mechanics.arm_size import ArmSize
from mafsil.mechanics.articulated_derivatives import forward_derivatives
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.branch_factor import BranchFactor
from mafsil.mechanics.composite_motion import body_motion, composites
from mafsil.mechanics.joint_pairs import BodyFramePairs, GroundFramePairs
from mafsil.mechanics.placement import Expression, joint_accelerations, joint_values, placements
from mafsil.mechanics.quantities.forward_dynamics import forward_dynamics, require_accelerations
from mafsil.mechanics.quantities.mass_matrix import mass_matrix
from mafsil.mechanics.quantity import Quantity, SecondMethod, States
from mafsil.mechanics.textbook import Numbers, Textbook, gradient, repeat_states
from mafsil.mechanics.wrench import ground_is_shorter

DEEP = 14
"""From this many joints in a row on, derivatives of forward dynamics need fewer operations by articulated bodies."""


def inverse_dynamics_derivatives(
    tree: BodyTree, q: Expression, qd: Expression, qdd: Expression, F_tip: Expression | None = None
) -> Expression:
    """(3 n, n): d tau/dq, d tau/dqd and d tau/dqdd = M, stacked.

    With Psi' = [V_parent, S], Psi'' = [A_parent, S] + [V_parent, Psi'] of each joint, for j before or equal i:
        d tau_i/dq_j  = S_i . (2 B_i Psi'_j + G_i Psi''_j)
        d tau_j/dq_i  = S_j . (2 B_i Psi'_i + G_i Psi''_i + S_i x* F_i)
        d tau_i/dqd_j = 2 S_i . (B_i S_j + G_i Psi'_j),  d tau_j/dqd_i = 2 S_j . (B_i S_i + G_i Psi'_i)

    Args:
        tree: the bodies.
        q, qd, qdd: (n,) coordinates [rad | m] and time derivatives.
        F_tip: (6,) wrench (m, f) the tip exerts on the world, in {tip}, constant there [N m, N]; None for none.

    Reference: as the module.
    """
    return ex.vertcat(*matrices(tree, q, qd, qdd, F_tip))


def forward_dynamics_derivatives(
    tree: BodyTree, q: Expression, qd: Expression, tau: Expression, F_tip: Expression | None = None
) -> Expression:
    """(3 n, n): d qdd/dq, d qdd/dqd and d qdd/dtau = M^-1, stacked.

    From tau = ID(q, qd, qdd): d qdd = M^-1 (d tau - dID/dq dq - dID/dqd dqd). Of two exact methods the one with fewer
    operations for this tree: articulated bodies where paths are long (`articulated_derivatives`), else M factored along
    the tree (`BranchFactor`); the latter always where joints follow each other.

    Args:
        tree: the bodies.
        q, qd: (n,) coordinates [rad | m] and rates.
        tau: (n,) joint efforts [N m | N].
        F_tip: (6,) wrench (m, f) the tip exerts on the world, in {tip}, constant there [N m, N]; None for none.

    Raises:
        ModelError: some joints move no inertia, so that no acceleration follows from their efforts.

    Reference: Carpentier & Mansard, Analytical derivatives of rigid body dynamics algorithms, RSS 2018.
    """
    if tree.depth >= DEEP and not tree.follows:
        require_accelerations(tree, q)
        return ex.vertcat(*forward_derivatives(tree, q, qd, tau, F_tip))
    qdd = forward_dynamics(tree, q, qd, tau, F_tip)
    by_q, by_qd, _ = matrices(tree, q, qd, qdd, F_tip)
    factor = BranchFactor(mass_matrix(tree, q))
    blocks = (_solved_columns(factor, by_q), _solved_columns(factor, by_qd), _matrix(factor.inverse()))
    return ex.vertcat(*blocks)


def _solved_columns(factor: BranchFactor, matrix: Expression) -> Expression:
    """-M^-1 matrix (n, n), column by column."""
    n = factor.n
    columns = [factor.solve([-matrix[i, j] for i in range(n)]) for j in range(n)]
    return _matrix([[columns[j][i] for j in range(n)] for i in range(n)])


def _matrix(rows: Sequence[Sequence[Expression]]) -> Expression:
    return ex.vertcat(*(ex.horzcat(*row) for row in rows))


def matrices(
    tree: BodyTree, q: Expression, qd: Expression, qdd: Expression, F_tip: Expression | None = None
) -> tuple[Expression, Expression, Expression]:
    """(n, n) each: d tau/dq, d tau/dqd and M.

    Arguments as in `inverse_dynamics_derivatives`. What is not used of the result costs nothing.
    """
    steps = placements(tree, q)
    motion = body_motion(tree, steps, joint_values(tree, steps, qd), joint_accelerations(tree, steps, qd, qdd))
    pairs = GroundFramePairs if ground_is_shorter(tree, wrenches=3, rows=1) else BodyFramePairs
    return pairs(tree, steps, motion, composites(tree, steps, motion, F_tip)).matrices(qd, qdd)


def _size_of_efforts(arm: ArmSize) -> Floats:
    return np.stack([arm.moment / arm.units, arm.inertia / arm.units, arm.inertia / arm.units])


def _size_of_motion(arm: ArmSize) -> Floats:
    by_position = arm.unit[:, None] / arm.unit
    return np.stack([by_position, by_position, arm.units / arm.inertia])


def _of_efforts(book: Textbook, s: States) -> Floats:
    """The recursion of Newton and Euler, differentiated by the complex step."""

    def efforts(q: Numbers, qd: Numbers, qdd: Numbers) -> Numbers:
        F = None if s.tip_wrench is None else repeat_states(s.tip_wrench, len(q))
        return book.newton_euler(_complex(q), _complex(qd), _complex(qdd), F).tau

    return _blocks(efforts, s.q, s.qd, s.qdd)


def _of_accelerations(book: Textbook, s: States) -> Floats:
    """The equation M qdd = tau - bias, solved in complex numbers."""

    def motion(q: Numbers, qd: Numbers, tau: Numbers) -> Numbers:
        F = None if s.tip_wrench is None else repeat_states(s.tip_wrench, len(q))
        return book.accelerations_of(_complex(q), _complex(qd), _complex(tau), F)

    return _blocks(motion, s.q, s.qd, s.tau)


def _blocks(function: Callable[[Numbers, Numbers, Numbers], Numbers], *inputs: Floats) -> Floats:
    """(b, 3, n, n): derivatives by each of three inputs (b, n)."""
    found: list[Floats] = []
    for k in range(3):

        def varied(x: Numbers, k: int = k) -> Numbers:
            others = [repeat_states(value, len(x)) for value in inputs]
            return function(*(x if j == k else other for j, other in enumerate(others)))

        found.append(gradient(varied, inputs[k]))
    return np.stack(found, axis=1)


def _complex(x: Numbers) -> Numbers:
    return x.astype(np.complex128)


INVERSE_DYNAMICS_DERIVATIVES = Quantity(
    name="inverse_dynamics_derivatives",
    symbol="dtau/d(q, qd, qdd)",
    title="Derivatives of inverse dynamics, in closed form: [0] by q, [1] by qd, [2] by qdd, the mass matrix.",
    builder=inverse_dynamics_derivatives,
    inputs=("q", "qd", "qdd"),
    optional=("tip_wrench",),
    shape=(3, "n", "n"),
    unit="N m | N per rad | m, and per s, s^2",
    reference="Singh, Wensing, Echeandia 2022",
    size=_size_of_efforts,
    second=SecondMethod("verification.complex_recursion", _of_efforts),
    needs_mass=True,
)

FORWARD_DYNAMICS_DERIVATIVES = Quantity(
    name="forward_dynamics_derivatives",
    symbol="dqdd/d(q, qd, tau)",
    title="Derivatives of forward dynamics, in closed form: [0] by q, [1] by qd, [2] by tau, the inverse mass matrix.",
    builder=forward_dynamics_derivatives,
    inputs=("q", "qd", "tau"),
    optional=("tip_wrench",),
    shape=(3, "n", "n"),
    unit="rad/s^2 | m/s^2 per rad | m, per their rates, per N m | N",
    reference="Carpentier & Mansard 2018",
    size=_size_of_motion,
    second=SecondMethod("verification.complex_solution", _of_accelerations),
    needs_mass=True,
    solves_mass_matrix=True,
)
