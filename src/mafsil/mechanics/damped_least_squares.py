"""Iterations towards a pose as functions: the twist that is left, a bounded damped step, one with self-motion."""

from __future__ import annotations

from math import nan, pi

import mafsil.expression as ex
from mafsil.algebra import se3, so3
from mafsil.mechanics.body_tree import BodyTree, lump_bodies
from mafsil.mechanics.frame_choice import in_chosen_frames
from mafsil.mechanics.quantities.kinematics import forward_kinematics, jacobian_body
from mafsil.mechanics.tolerances import OPPOSITE
from mafsil.model import JointKind, Mechanism

FAR = 16.0
"""Squared scaled error from which damping grows no more: only joints without limits lead so far; they are linear."""


def error(mechanism: Mechanism, frame: str | None, one_axis: bool, aligned: bool) -> ex.Function:
    """Of (q, T_sd, task) to 16 numbers of T_sf and 6 of the twist e that is left, as in `step`.

    Args:
        mechanism: its numbers become constants.
        frame: name of a link; the tip frame if None.
        one_axis: only the direction of the task's axis counts, not the rotation about it.
        aligned: e, and hence the weights, along the axes of {s}; along the frame's own if not.
    """
    goal = _Goal(mechanism, frame, one_axis, aligned)
    return ex.Function("pose_check", goal.inputs, [ex.cse(ex.vertcat(ex.reshape(goal.T_sf.T, 16, 1), goal.twist))])


def step(
    mechanism: Mechanism, frame: str | None, one_axis: bool, aligned: bool, relative: float, least: float, length: float
) -> ex.Function:
    """Of (q, T_sd, task) to q_next of n and e of 6 numbers; task = weights (6), axis (3), lower (n), upper (n).

    q_next = clip(q + W J' (J J' + lambda I)^-1 e),  e = (log(R_sf' R_sd), R_sf' (p_sd - p_sf)),
    lambda = relative min(|e|^2, FAR) + least

    Rows of J and e are multiplied by the weights, columns of J by W: the length for prismatic joints, one for the rest.
    For one axis the angular part of e is the least rotation that brings the axes together. Joints at a bound that the
    step would push further are fixed.

    Args:
        mechanism: its numbers become constants.
        frame: name of a link; the tip frame if None.
        one_axis: only the direction of the task's axis counts, not the rotation about it.
        aligned: e, and hence the weights, along the axes of {s}; along the frame's own if not.
        relative: damping relative to the squared error.
        least: smallest damping.
        length: unit of prismatic joints [m].

    Reference: Chan and Lawrence, General inverse kinematics with the error damped pseudoinverse, ICRA 1988.
    """
    goal = _Goal(mechanism, frame, one_axis, aligned)
    J, e = goal.weighted_task()
    dq = goal.damped_step(J, e, relative * ex.fmin(ex.dot(e, e), FAR) + least, length)
    return ex.Function("pose_step", goal.inputs, [ex.cse(ex.vertcat(goal.clip_step(dq), goal.twist))])


def step_with_self_motion(
    mechanism: Mechanism, frame: str | None, one_axis: bool, aligned: bool, relative: float, least: float, length: float
) -> ex.Function:
    """As `step`, of (q, T_sd, task, z): what the task leaves free moves along z; then n numbers of that motion.

    dq = z + J# (e - J z),  self-motion = z - J# J z

    Reference: Liegeois, Automatic supervisory control of the configuration and behavior of multibody mechanisms, 1977.

    Args:
        mechanism, frame, one_axis, aligned, relative, least, length: as of `step`.
    """
    goal = _Goal(mechanism, frame, one_axis, aligned)
    z = ex.symbol("z", goal.n)
    J, e = goal.weighted_task()
    towards = goal.damped_step(J, e, relative * ex.fmin(ex.dot(e, e), FAR) + least, length)
    J = goal.free_columns(J, J.T @ e)
    free = z
    # Joints that the self-motion would push through their bounds are fixed, then those that the rest pushes.
    for _ in range(2):
        free = free - _damp(J, J @ free, ex.Expression(least))
        J = goal.free_columns(J, free)
        free = ex.vertcat(*(ex.if_else(goal.is_at_bound(i, free[i]), 0, z[i]) for i in range(goal.n)))
    free = free - _damp(J, J @ free, ex.Expression(least))
    moved = goal.clip_step(towards + free)
    return ex.Function("pose_step_with_self_motion", [*goal.inputs, z], [ex.cse(ex.vertcat(moved, goal.twist, free))])


class _Goal:
    """A desired pose of a frame, and what is left to it."""

    def __init__(self, mechanism: Mechanism, frame: str | None, one_axis: bool, aligned: bool) -> None:
        self.tree: BodyTree = in_chosen_frames(lump_bodies(mechanism))
        self.n = mechanism.n
        self.prismatic = [joint.kind is JointKind.PRISMATIC for joint in mechanism.coordinates]
        self.attachment = self.tree.tip if frame is None else self.tree.frames[frame]
        self.one_axis, self.aligned = one_axis, aligned
        self.q, desired = ex.symbol("q", self.n), ex.symbol("T_sd", 16)
        task = ex.symbol("task", 9 + 2 * self.n)
        self.inputs = [self.q, desired, task]
        self.weights, self.axis = task[:6], task[6:9]
        self.lower, self.upper = task[9 : 9 + self.n], task[9 + self.n :]
        self.T_sf = forward_kinematics(self.tree, self.q, self.attachment)
        T_sd = ex.reshape(desired, 4, 4).T
        R = se3.rotation(self.T_sf)
        turn = R.T @ se3.rotation(T_sd)
        angular = _least_turn(self.axis, turn @ self.axis) if one_axis else so3.log(turn)
        linear = se3.translation(T_sd) - se3.translation(self.T_sf)
        self.twist = ex.vertcat(R @ angular, linear) if aligned else ex.vertcat(angular, R.T @ linear)

    def weighted_task(self) -> tuple[ex.Expression, ex.Expression]:
        """Jacobian (6, n) and twist (6) times the weights."""
        J = jacobian_body(self.tree, self.q, self.attachment)
        if self.one_axis:
            J = ex.vertcat(J[:3, :] - self.axis @ (self.axis.T @ J[:3, :]), J[3:, :])
        if self.aligned:
            R = se3.rotation(self.T_sf)
            J = ex.vertcat(R @ J[:3, :], R @ J[3:, :])
        return J * ex.repmat(self.weights, 1, self.n), self.twist * self.weights

    def is_at_bound(self, i: int, change: ex.Expression) -> ex.Expression:
        """Whether joint i is at a bound and the change would push it further."""
        below = ex.logic_and(self.q[i] <= self.lower[i], change < 0)
        return ex.logic_or(below, ex.logic_and(self.q[i] >= self.upper[i], change > 0))

    def free_columns(self, J: ex.Expression, descent: ex.Expression) -> ex.Expression:
        """J without the columns of joints that are at a bound and pushed further."""
        columns = [ex.if_else(self.is_at_bound(i, descent[i]), 0, J[:, i]) for i in range(self.n)]
        return ex.horzcat(*columns) if columns else J

    def damped_step(self, J: ex.Expression, e: ex.Expression, damping: ex.Expression, length: float) -> ex.Expression:
        """(n,) the damped change of the joints that brings e down, prismatic joints in units of the length."""
        units = ex.Expression([length if prismatic else 1.0 for prismatic in self.prismatic])
        J = self.free_columns(J, J.T @ e) @ ex.diag(units) if any(self.prismatic) else self.free_columns(J, J.T @ e)
        return units * _damp(J, e, damping)

    def clip_step(self, dq: ex.Expression) -> ex.Expression:
        """Q + dq within the bounds."""
        return ex.fmin(ex.fmax(self.q + dq, self.lower), self.upper)


def _least_turn(a: ex.Expression, b: ex.Expression) -> ex.Expression:
    """(3,) rotation vector of least length that takes unit vector a to b, normal to a."""
    normal = ex.cross(a, b)
    sine, cosine = ex.sqrt(ex.sumsqr(normal)), ex.dot(a, b)
    small = sine < OPPOSITE
    ratio = ex.atan2(sine, cosine) / ex.if_else(small, 1, sine)
    side = ex.if_else(a[2] * a[2] < 0.5, ex.vertcat(a[1], -a[0], 0), ex.vertcat(0, a[2], -a[1]))
    half = pi * side / ex.sqrt(ex.sumsqr(side))
    return ex.if_else(small, ex.if_else(cosine < 0, half, normal), ratio * normal)


def _damp(J: ex.Expression, e: ex.Expression, damping: ex.Expression) -> ex.Expression:
    """(n,) J' (J J' + damping I)^-1 e, by the smaller of the two matrices."""
    m, n = J.shape
    if n < m:
        return _solve(J.T @ J + damping * ex.eye(n), J.T @ e)
    return J.T @ _solve(J @ J.T + damping * ex.eye(m), e)


def _solve(A: ex.Expression, b: ex.Expression) -> ex.Expression:
    """x of A x = b by Cholesky's factors; NaN where A is not positive definite."""
    m = b.shape[0]
    L = ex.zeros(m, m)
    for j in range(m):
        pivot = A[j, j] - ex.sumsqr(L[j, :j]) if j else A[j, j]
        L[j, j] = 1 / ex.sqrt(ex.if_else(pivot > 0, pivot, nan))
        for i in range(j + 1, m):
            rest = A[i, j] - (ex.dot(L[i, :j], L[j, :j]) if j else 0)
            L[i, j] = rest * L[j, j]
    x = ex.zeros(m, 1)
    for j in range(m):
        x[j] = (b[j] - (ex.dot(L[j, :j].T, x[:j]) if j else 0)) * L[j, j]
    for j in reversed(range(m)):
        x[j] = (x[j] - (ex.dot(L[j + 1 :, j], x[j + 1 :]) if j + 1 < m else 0)) * L[j, j]
    return x
