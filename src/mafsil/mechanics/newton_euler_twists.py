"""Inverse dynamics in twists and wrenches, step by step as the textbook has it, with all it passes through.

Reference: Lynch & Park, Modern Robotics, sec. 8.3.2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import mafsil.expression as ex
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.placement import Expression
from mafsil.mechanics.twist_chain import TwistChain, ad


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
