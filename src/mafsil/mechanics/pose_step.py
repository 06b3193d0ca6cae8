"""One bounded, damped least-squares step towards a pose as one function, and the twist that was left before it."""

from __future__ import annotations

from math import nan

import casadi as ca

from mafsil.algebra import se3
from mafsil.mechanics.body_tree import lumped
from mafsil.mechanics.forward_kinematics import forward_kinematics
from mafsil.mechanics.gauge import regauged
from mafsil.mechanics.jacobian import jacobian_body
from mafsil.model import Mechanism


def function(mechanism: Mechanism, frame: str | None, relative: float, least: float) -> ca.Function:
    """Of (q, T_sd, lower, upper, length) to (q_next, e) of n + 6 numbers.

    q_next = clip(q + J' (J J' + lambda I)^-1 e),  e = log(T_sf^-1 T_sd),  lambda = relative |e|^2 + least

    Linear rows of J and e count in units of `length`. Joints at a bound that the step would push further are held.

    Args:
        mechanism: its numbers become constants.
        frame: name of a link; the tip frame if None.
        relative: damping relative to the squared error.
        least: smallest damping.

    Reference: Chan and Lawrence, General inverse kinematics with the error damped pseudoinverse, ICRA 1988.
    """
    tree, n = regauged(lumped(mechanism)), mechanism.n
    attachment = tree.tip if frame is None else tree.frames[frame]
    q, T, length = ca.SX.sym("q", n), ca.SX.sym("T_sd", 16), ca.SX.sym("length", 1)
    lower, upper = ca.SX.sym("lower", n), ca.SX.sym("upper", n)
    twist = se3.body_error(forward_kinematics(tree, q, attachment), ca.reshape(T, 4, 4).T)
    scale = ca.vertcat(1, 1, 1, 1 / length, 1 / length, 1 / length)
    J = ca.densify(jacobian_body(tree, q, attachment)) * ca.repmat(scale, 1, n)
    e = twist * scale
    descent = J.T @ e
    for i in range(n):
        below, above = ca.logic_and(q[i] <= lower[i], descent[i] < 0), ca.logic_and(q[i] >= upper[i], descent[i] > 0)
        J[:, i] = ca.if_else(ca.logic_or(below, above), 0, J[:, i])
    damping = relative * ca.dot(e, e) + least
    if n < 6:
        dq = _solved(J.T @ J + damping * ca.SX.eye(n), J.T @ e)
    else:
        dq = J.T @ _solved(J @ J.T + damping * ca.SX.eye(6), e)
    moved = q + dq
    clipped = ca.vertcat(
        *(
            ca.if_else(moved[i] < lower[i], lower[i], ca.if_else(moved[i] > upper[i], upper[i], moved[i]))
            for i in range(n)
        )
    )
    column = ca.densify(ca.vertcat(clipped, twist))
    return ca.Function("pose_step", [q, T, lower, upper, length], [ca.cse(column)])


def _solved(A: ca.SX, b: ca.SX) -> ca.SX:
    """X of A x = b by Cholesky's factors; NaN where A is not positive definite."""
    m = b.shape[0]
    L = ca.SX.zeros(m, m)
    for j in range(m):
        pivot = A[j, j] - ca.sumsqr(L[j, :j]) if j else A[j, j]
        L[j, j] = 1 / ca.sqrt(ca.if_else(pivot > 0, pivot, nan))
        for i in range(j + 1, m):
            rest = A[i, j] - (ca.dot(L[i, :j], L[j, :j]) if j else 0)
            L[i, j] = rest * L[j, j]
    x = ca.SX.zeros(m, 1)
    for j in range(m):
        x[j] = (b[j] - (ca.dot(L[j, :j].T, x[:j]) if j else 0)) * L[j, j]
    for j in reversed(range(m)):
        x[j] = (x[j] - (ca.dot(L[j + 1 :, j], x[j + 1 :]) if j + 1 < m else 0)) * L[j, j]
    return x
