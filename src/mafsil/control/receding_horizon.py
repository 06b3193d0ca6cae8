"""Model-predictive control: at each tick the best efforts over a horizon, within their limits, of which the first acts.

With tau = M (a + w) + c + g the errors obey e'' = -w. Over N intervals the law minimises

    sum (position e^2 + rate e'^2 + acceleration w^2) + (e, e')' P (e, e') at the end,   |tau_k| <= limit,

M, c and g taken as they are now. P is the cost of going on for ever without limits, so where none is reached the law is
the linear-quadratic one of the sampled errors, whatever the horizon.

Reference: Mayne, Rawlings, Rao and Scokaert, Constrained model predictive control: stability and optimality,
Automatica 36, 2000.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, as_batch, frozen, positive, whole
from mafsil.control.gains import per_joint
from mafsil.control.law import Law
from mafsil.errors import InputError
from mafsil.robot import Robot, of_robot
from mafsil.solvers.box_quadratic import box_minimum
from mafsil.trajectory import Motion

ROUNDS = 100_000
SETTLED = 1e-13
"""Relative change of the cost in one round below which it is that of an infinite horizon."""
MOST_NUMBERS = 2000
"""Joints times intervals: matrices of that size are factored at each tick where a limit is reached."""


@dataclass(frozen=True, eq=False, slots=True)
class ModelPredictive:
    """The first of the best efforts over a horizon.

    Attributes:
        robot: the model.
        interval: of the prediction, during which efforts are constant [s].
        hessian: (n, N, N) of the cost of each joint by its accelerations over the horizon.
        slope: (n, N, 2) of its gradient by the present error and its rate.
        gain: (n, 2) from error and rate to the acceleration where no limit is reached.
        limit: (n,) magnitudes of efforts that are never exceeded; infinite where there is none [N m | N].
    """

    robot: Robot
    interval: float
    hessian: Floats
    slope: Floats
    gain: Floats
    limit: Floats

    @property
    def horizon(self) -> int:
        """Number of intervals N."""
        return int(self.hessian.shape[1])

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N]."""
        errors = np.stack(np.broadcast_arrays(reference.u - q, reference.v - qd), axis=-1)
        wanted = np.broadcast_to(reference.a, errors.shape[:-1])
        free = -np.linalg.solve(self.hessian, (self.slope @ errors[..., None]))[..., 0]
        M = self.robot.mass_matrix(q)
        known = self.robot.inverse_dynamics(q, qd, wanted)
        efforts = known[..., None] + M @ free
        effort = np.array(efforts[..., 0])
        beyond = (np.abs(efforts) > self.limit[:, None]).any(axis=(-2, -1))
        for row in np.argwhere(beyond):
            at = tuple(row.tolist())
            effort[at] = self._limited(M[at], known[at], errors[at], efforts[at])
        return effort

    def plan(self, q: JointVector, qd: JointVector, reference: Motion) -> Floats:
        """(N, n) efforts over the horizon at one state, as the law would give them [N m | N].

        Args:
            q, qd: (n,) state.
            reference: desired motion now.
        """
        errors = np.stack([reference.u - q, reference.v - qd], axis=-1)
        M, known = self.robot.mass_matrix(q), self.robot.inverse_dynamics(q, qd, reference.a)
        free = -np.linalg.solve(self.hessian, self.slope @ errors[..., None])[..., 0]
        return self._planned(M, known, errors, known[:, None] + M @ free)

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self

    def _limited(self, M: Floats, known: Floats, errors: Floats, efforts: Floats) -> Floats:
        return self._planned(M, known, errors, efforts)[0]

    def _planned(self, M: Floats, known: Floats, errors: Floats, efforts: Floats) -> Floats:
        """(N, n) the best efforts within their limits: w = M^-1 (tau - known) makes their cost quadratic in a box."""
        n, N = self.slope.shape[:2]
        W = np.linalg.inv(M)
        H = np.einsum("ja,jkl,jb->kalb", W, self.hessian, W).reshape(N * n, N * n)
        at_zero = -(W @ known)
        gradient = (self.slope @ errors[..., None])[..., 0] + self.hessian.sum(axis=-1) * at_zero[:, None]
        g = (W.T @ gradient).T.reshape(-1)
        bound = np.tile(self.limit, N)
        return box_minimum(H, g, -bound, bound, efforts.T.reshape(-1)).x.reshape(N, n)


@of_robot
def model_predictive(
    robot: Robot,
    *,
    horizon: int = 10,
    interval: float = 0.02,
    position: ArrayLike = 1e4,
    rate: ArrayLike = 10.0,
    acceleration: ArrayLike = 0.01,
    effort_limit: ArrayLike | None = None,
) -> ModelPredictive:
    """The law that looks a horizon ahead and keeps efforts within their limits.

    Args:
        robot: the model.
        horizon: number of intervals.
        interval: length of one [s].
        position, rate, acceleration: weights of e^2, e'^2 and of the acceleration spent on them, numbers or (n,).
        effort_limit: (n,) magnitudes; those of the robot if None [N m | N].

    Raises:
        InputError: a wrong shape, a negative weight, none of position or acceleration, too long a horizon.
        ModelError: the robot has no masses.
    """
    n, N, h = robot.n, whole("horizon", horizon, 1), positive("interval", interval)
    if n * N > MOST_NUMBERS:
        raise InputError("input.range", name="horizon", value=N, low=1, high=MOST_NUMBERS // max(n, 1))
    weights = per_joint("position", position, n, positive=True), per_joint("rate", rate, n)
    spent = per_joint("acceleration", acceleration, n, positive=True)
    limit = robot.limits.effort if effort_limit is None else as_batch("effort_limit", effort_limit, (n,))
    if not (limit > 0.0).all():
        raise InputError("input.positive", name="effort_limit", value=float(np.min(limit)))
    A, B = np.array([[1.0, h], [0.0, 1.0]]), -np.array([h * h / 2.0, h])
    Q = np.einsum("ni,ij->nij", np.stack(weights, axis=-1), np.eye(2))
    P, gain = _endless(A, B, Q, spent)
    hessian, slope = _condensed(A, B, Q, spent, P, N)
    return ModelPredictive(robot, h, frozen(hessian), frozen(slope), frozen(gain), frozen(np.asarray(limit)))


def _endless(A: Floats, B: Floats, Q: Floats, R: Floats) -> tuple[Floats, Floats]:
    """(n, 2, 2) cost of errors over an infinite horizon without limits, and (n, 2) its gain: w = -gain (e, e')."""
    P = Q.copy()
    gain = np.zeros((len(R), 2))
    for _ in range(ROUNDS):
        PB = P @ B
        gain = (PB @ A) / (R + PB @ B)[:, None]
        closed = A - B[:, None] * gain[:, None, :]
        after = Q + R[:, None, None] * gain[:, :, None] * gain[:, None, :] + np.swapaxes(closed, 1, 2) @ P @ closed
        settled = np.abs(after - P).max() <= SETTLED * np.abs(after).max()
        P = after
        if settled:
            break
    return P, gain


def _condensed(A: Floats, B: Floats, Q: Floats, R: Floats, P: Floats, N: int) -> tuple[Floats, Floats]:
    """Hessian (n, N, N) and slope (n, N, 2) of the cost by the accelerations w_0 .. w_(N-1)."""
    powers = [np.linalg.matrix_power(A, k) for k in range(N + 1)]
    hessian, slope = np.zeros((len(R), N, N)), np.zeros((len(R), N, 2))
    for k in range(1, N + 1):
        weight = P if k == N else Q
        S = np.zeros((2, N))
        for i in range(k):
            S[:, i] = powers[k - 1 - i] @ B
        hessian += 2.0 * np.swapaxes(S.T @ weight @ S, 1, 2)
        slope += 2.0 * S.T @ weight @ powers[k]
    hessian += 2.0 * R[:, None, None] * np.eye(N)
    return (hessian + np.swapaxes(hessian, 1, 2)) / 2.0, slope
