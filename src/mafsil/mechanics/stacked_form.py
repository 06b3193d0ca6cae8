"""The recursion of Newton and Euler as one equation of large matrices: V = L (A qd + V_base), tau = A' F.

With the N bodies' twists stacked, Gamma shifts each to the bodies it carries, Gamma^N = 0, and
L = (I - Gamma)^-1 = I + Gamma + ... + Gamma^(N-1) sums along the chain. Signs as in the recursion; some printings of
the stacked equations have others.

Reference: Lynch & Park, Modern Robotics, sec. 8.4.

Inverse dynamics in twists and wrenches, step by step as the textbook has it, with all it passes through.

Reference: Lynch & Park, Modern Robotics, sec. 8.3.2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats, JointVector, as_batch
from mafsil.mechanics.body_tree import BodyTree, lump_bodies
from mafsil.mechanics.placement import Expression
from mafsil.mechanics.twist_chain import TwistChain, ad
from mafsil.model import Mechanism


@dataclass(frozen=True, eq=False, slots=True)
class StackedForm:
    """The matrices of one state, as expressions or as arrays; N bodies, n coordinates.

    Attributes:
        A: (6N, n) joint screws, each in its body's frame.
        G: (6N, 6N) inertias, block diagonal.
        Gamma: (6N, 6N) Ad(T_i,parent) at the block (i, parent).
        L: (6N, 6N) the inverse of I - Gamma.
        ad_Aqd: (6N, 6N) ad of the joints' own twists A qd, block diagonal.
        ad_V: (6N, 6N) ad of the bodies' twists, block diagonal.
        V: (6N,) the bodies' twists.
        dV_base: (6N,) the base's acceleration, gravity as its upward motion, seen by the bodies on the base.
        M: (n, n) = A' L' G L A + armatures.
        C_newton_euler: (n, n) = -A' L' (G L ad_Aqd Gamma + ad_V' G) L A: C qd = c, but dM/dt - 2 C is not skew.
        C_skew: (n, n), the same with ad_V' G - G ad_V in place of ad_V' G: dM/dt - 2 C is skew.
        C: (n, n) that of the Christoffel symbols.
        c: (n,) = C qd.
        g: (n,) = A' L' G L dV_base.
    """

    A: Floats
    G: Floats
    Gamma: Floats
    L: Floats
    ad_Aqd: Floats
    ad_V: Floats
    V: Floats
    dV_base: Floats
    M: Floats
    C_newton_euler: Floats
    C_skew: Floats
    C: Floats
    c: JointVector
    g: JointVector


NAMES = tuple(StackedForm.__dataclass_fields__)


def stacked_form(mechanism: Mechanism, q: JointVector, qd: JointVector) -> StackedForm:
    """The matrices at one state, as arrays.

    Args:
        mechanism: any open chain or tree.
        q, qd: (n,) coordinates [rad | m] and rates.

    Raises:
        InputError: a wrong shape, NaN or infinity.
    """
    values = [as_batch(name, x, (mechanism.n,), finite=True) for name, x in (("q", q), ("qd", qd))]
    symbols = [ex.symbol(name, mechanism.n) for name in ("q", "qd")]
    matrices = stacked_expressions(TwistChain.of(lump_bodies(mechanism)), *symbols)
    function = ex.Function("stacked", symbols, [matrices[name] for name in NAMES], cse=True)
    results = [np.array(x.full()) for x in function.call([ex.Expression(x) for x in values])]
    vectors = ("V", "dV_base", "c", "g")
    return StackedForm(*(x.ravel() if name in vectors else x for name, x in zip(NAMES, results, strict=True)))


def stacked_expressions(chain: TwistChain, q: Expression, qd: Expression) -> dict[str, Expression]:
    """The same as expressions, by the names of `StackedForm`.

    Args:
        chain: the bodies.
        q, qd: (n,) symbols or expressions.
    """
    N, coupling = chain.count, ex.Expression(chain.coupling)
    rates, screws = coupling @ qd, [ex.Expression(A) for A in chain.A]
    G = ex.diagcat(*(ex.Expression(G) for G in chain.G))
    A = ex.diagcat(*screws) @ coupling
    Gamma, dV_base = ex.zeros(6 * N, 6 * N), ex.zeros(6 * N, 1)
    fall = ex.Expression(np.concatenate([np.zeros(3), chain.gravity]))
    for i, (p, X) in enumerate(zip(chain.parent, chain.adjoints(q), strict=True)):
        if p >= 0:
            Gamma[6 * i : 6 * i + 6, 6 * p : 6 * p + 6] = X
        else:
            dV_base[6 * i : 6 * i + 6] = -X @ fall
    L = neumann_sum(Gamma, N)
    V = L @ A @ qd
    ad_Aqd = ex.diagcat(*(ad(screws[i] * rates[i]) for i in range(N)))
    ad_V = ex.diagcat(*(ad(V[6 * i : 6 * i + 6]) for i in range(N)))
    momenta = G @ V
    duals = ex.diagcat(*(_momentum_block(momenta[6 * i : 6 * i + 6]) for i in range(N)))
    LA = L @ A
    carried = G @ L @ ad_Aqd @ Gamma
    armature = coupling.T @ ex.diag(ex.Expression(chain.armature)) @ coupling
    C_newton_euler = -LA.T @ (carried + ad_V.T @ G) @ LA
    return {
        "A": A,
        "G": G,
        "Gamma": Gamma,
        "L": L,
        "ad_Aqd": ad_Aqd,
        "ad_V": ad_V,
        "V": V,
        "dV_base": dV_base,
        "M": LA.T @ G @ LA + armature,
        "C_newton_euler": C_newton_euler,
        "C_skew": -LA.T @ (carried + ad_V.T @ G - G @ ad_V) @ LA,
        "C": LA.T @ (-carried + (G @ ad_V - ad_V.T @ G + duals) / 2) @ LA,
        "c": C_newton_euler @ qd,
        "g": LA.T @ G @ L @ dV_base,
    }


def neumann_sum(Gamma: Expression, N: int) -> Expression:
    """I + Gamma + ... + Gamma^(N-1), the inverse of I - Gamma for a nilpotent Gamma."""
    one = ex.eye(Gamma.shape[0])
    total = one
    for _ in range(N - 1):
        total = one + Gamma @ total
    return total


def _momentum_block(P: Expression) -> Expression:
    """-[[ [m], [f] ], [ [f], 0 ]] of a momentum (m, f)."""
    m, f = ex.skew(P[:3]), ex.skew(P[3:])
    return -ex.vertcat(ex.horzcat(m, f), ex.horzcat(f, ex.zeros(3, 3)))


@dataclass(frozen=True, slots=True)
class Recursion:
    """What the recursion passes through; lists by body, each in its own frame {i}.

    Attributes:
        V: (6,) twists.
        dV: (6,) their derivatives less gravity: the recursion lets the base accelerate upwards instead.
        F: (6,) wrenches that the body before exerts on body i through joint i.
        tau: (n,) efforts.
    """

    V: list[Expression]
    dV: list[Expression]
    F: list[Expression]
    tau: Expression


def newton_euler(
    chain: TwistChain,
    q: Expression,
    qd: Expression,
    qdd: Expression,
    F_tip: Expression | None = None,
    V_0: Expression | None = None,
    dV_0: Expression | None = None,
) -> Recursion:
    """The recursion of Newton and Euler.

    Outward:  V_i = X_i V_p + A_i qd_i,  dV_i = X_i dV_p + [ad_V_i] A_i qd_i + A_i qdd_i,  X_i = Ad(T_ip)
    Inward:   F_i = sum of X_c' F_c + G_i dV_i - [ad_V_i]' G_i V_i,  tau_i = A_i . F_i

    Args:
        chain: the bodies.
        q, qd, qdd: (n,) coordinates [rad | m] and time derivatives.
        F_tip: (6,) wrench the tip exerts on the world, in {tip}; None for none.
        V_0, dV_0: (6,) twist of the ground frame {s} and its true derivative, in {s}; None for rest.
    """
    X, coupling = chain.adjoints(q), ex.Expression(chain.coupling)
    rates, accelerations = coupling @ qd, coupling @ qdd
    fall = ex.Expression(np.concatenate([np.zeros(3), chain.gravity]))
    rest = ex.zeros(6, 1)
    V_base, dV_base = rest if V_0 is None else V_0, (rest if dV_0 is None else dV_0) - fall
    V: list[Expression] = []
    dV: list[Expression] = []
    for i, p in enumerate(chain.parent):
        A = ex.Expression(chain.A[i])
        V.append(X[i] @ (V[p] if p >= 0 else V_base) + A * rates[i])
        dV.append(X[i] @ (dV[p] if p >= 0 else dV_base) + ad(V[i]) @ A * rates[i] + A * accelerations[i])
    F = _wrenches(chain, X, V, dV, F_tip)
    efforts = [
        ex.dot(ex.Expression(chain.A[i]), F[i]) + chain.armature[i] * accelerations[i] for i in range(chain.count)
    ]
    return Recursion(V, dV, F, coupling.T @ ex.vertcat(*efforts))


def twist_torque(tree: BodyTree, q: Expression, qd: Expression, qdd: Expression) -> Expression:
    """tau (n,) [N m | N] by twists and wrenches, a second method; arguments as in `inverse_dynamics`."""
    return newton_euler(TwistChain.of(tree), q, qd, qdd).tau


def _wrenches(
    chain: TwistChain, X: list[Expression], V: list[Expression], dV: list[Expression], F_tip: Expression | None
) -> list[Expression]:
    F: list[Expression] = []
    for i in range(chain.count):
        G = ex.Expression(chain.G[i])
        F.append(G @ dV[i] - ad(V[i]).T @ (G @ V[i]))
    if F_tip is not None and chain.tip_body >= 0:
        R, p = ex.Expression(chain.T_tip[:3, :3]), ex.Expression(chain.T_tip[:3, 3])
        f = R @ F_tip[3:]
        F[chain.tip_body] = F[chain.tip_body] + ex.vertcat(R @ F_tip[:3] + ex.cross(p, f), f)
    for i in reversed(range(chain.count)):
        p = chain.parent[i]
        if p >= 0:
            F[p] = F[p] + X[i].T @ F[i]
    return F
