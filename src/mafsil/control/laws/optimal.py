"""Optimal control: linear-quadratic gains about a pose, and the best efforts over a horizon within their limits.

A quadratic cost of errors and efforts asks for the gains of the linear-quadratic law. Model-predictive control looks at
each tick for the best efforts over a horizon, of which the first acts. With tau = M (a + w) + c + g the errors obey
e'' = -w. Over N intervals the law minimises

    sum (position e^2 + rate e'^2 + acceleration w^2) + (e, e')' P (e, e') at the end,   |tau_k| <= limit,

M, c and g taken as they are now. P is the cost of going on for ever without limits, so where none is reached the law is
the linear-quadratic one of the sampled errors, whatever the horizon.

Reference: Mayne, Rawlings, Rao and Scokaert, Constrained model predictive control: stability and optimality,
Automatica 36, 2000.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, as_batch, frozen, positive, require_kind, single, whole
from mafsil.control.laws.feedback import Gains, per_joint
from mafsil.control.laws.law import Law
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.robot import Robot, of_robot
from mafsil.solvers.decompositions import riccati
from mafsil.trajectory import Motion

if TYPE_CHECKING:
    import mafsil.solvers.horizon_loops as horizon_loops
else:
    horizon_loops = lazily("mafsil.solvers.horizon_loops")


ANGLE = 1e-5
"""Step of the differences of gravity [rad | m]."""
ROUNDS = 400
COARSEST = 1e8
"""Largest weight of an error against the acceleration that removes it in one interval: beyond, rounding decides."""
SETTLED = 1e-13
"""Relative change of the cost in one round below which it is that of an infinite horizon."""
MOST_NUMBERS = 2000
"""Joints times intervals: a matrix of that size is kept where every effort is at its limit."""


@dataclass(frozen=True, eq=False, slots=True)
class LinearQuadratic:
    """tau = M(u) a + c(u, v) + g(u) + gain (u - q, v - qd): optimal for small errors about one pose.

    Attributes:
        robot: the model.
        pose: (n,) at which it was linearised [rad | m].
        gain: (n, 2 n) from errors of position and rate to efforts.
        A, B: (2 n, 2 n), (2 n, n) of the errors x' = A x - B (tau - tau_0) there.
        cost: (2 n, 2 n) P: what an error x costs from now on is x' P x.
    """

    robot: Robot
    pose: Floats
    gain: Floats
    A: Floats = field(repr=False)
    B: Floats = field(repr=False)
    cost: Floats = field(repr=False)

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Efforts (*batch, n) [N m | N]."""
        x = np.concatenate(np.broadcast_arrays(reference.u - q, reference.v - qd), axis=-1)
        return self.robot.inverse_dynamics(reference.u, reference.v, reference.a) + x @ self.gain.T

    @property
    def roots(self) -> NDArray[np.complex128]:
        """(2 n,) of the errors at the pose, the slowest first [1/s]."""
        found = np.linalg.eigvals(self.A - self.B @ self.gain)
        return np.asarray(found[np.argsort(-found.real)], dtype=np.complex128)

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self


@of_robot
def linear_quadratic(
    robot: Robot, pose: ArrayLike, *, position: ArrayLike = 100.0, rate: ArrayLike = 1.0, effort: ArrayLike = 1e-3
) -> LinearQuadratic:
    """The law that minimises the integral of position e^2 + rate e'^2 + effort (tau - tau_0)^2 about a pose.

    Args:
        robot: its model.
        pose: (n,) [rad | m].
        position, rate, effort: weights, each a number or (n,): such as one over the square of what is tolerable.

    Raises:
        InputError: a wrong shape, a number that is not finite, a negative weight, one of the effort or position that is
            zero.
        ModelError: the robot has no masses.

    Reference: Kalman, Contributions to the theory of optimal control, 1960; Siciliano et al., Robotics, app. C.
    """
    n = robot.n
    place = as_batch("pose", pose, (n,), finite=True).reshape(n)
    weights, costs = Gains.of(n, position, rate), Gains.of(n, effort, 0.0)
    for name, values in (("position", weights.kp), ("effort", costs.kp)):
        if not (values > 0.0).all():
            raise InputError("input.positive", name=name, value=float(values.min()))
    aside = ANGLE * np.eye(n)
    slope = (robot.gravity_torque(place + aside) - robot.gravity_torque(place - aside)).T / (2.0 * ANGLE)
    inverse: Floats = np.asarray(np.linalg.inv(robot.mass_matrix(place)), dtype=np.float64)
    zero = np.zeros((n, n))
    A = np.block([[zero, np.eye(n)], [-inverse @ slope, zero]])
    B = np.vstack([zero, inverse])
    P = riccati(A, B, np.diag(np.concatenate([weights.kp, weights.kd])), np.diag(costs.kp))
    if P is None:
        raise InputError("control.no_optimal_gain")
    return LinearQuadratic(robot, frozen(place), frozen((B.T @ P) / costs.kp[:, None]), A, B, P)


@dataclass(frozen=True, eq=False, slots=True)
class ModelPredictive:
    """The first of the best efforts over a horizon.

    Attributes:
        robot: the model.
        interval: of the prediction, during which efforts are constant [s].
        hessian: (n, N, N) of the cost of each joint by its accelerations over the horizon.
        inverse: (n, N, N) of the Hessians.
        slope: (n, N, 2) of its gradient by the present error and its rate.
        gain: (n, 2) from error and rate to the acceleration where no limit is reached.
        limit: (n,) magnitudes of efforts that are never exceeded; infinite where there is none [N m | N].
    """

    robot: Robot
    interval: float
    hessian: Floats = field(repr=False)
    inverse: Floats = field(repr=False)
    slope: Floats = field(repr=False)
    gain: Floats = field(repr=False)
    limit: Floats

    @property
    def horizon(self) -> int:
        """Number of intervals N."""
        return int(self.hessian.shape[1])

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N].

        Raises:
            InputError: the best efforts were not found: the weights differ too much for floating point.
        """
        e, rate = np.broadcast_arrays(reference.u - q, reference.v - qd)
        n, shape = self.robot.n, e.shape
        M = self.robot.mass_matrix(q)
        known = self.robot.inverse_dynamics(q, qd, reference.a)
        if len(shape) > 1 or M.ndim > 2 or known.ndim > 1:
            M, known = np.broadcast_to(M, (*shape, n)), np.broadcast_to(known, shape)
        effort = np.empty((e.size // n, n))
        failed = horizon_loops.first_efforts(
            self.inverse, self.slope, _rows(M, n, n), _rows(known, n), _rows(e, n), _rows(rate, n), self.limit, effort
        )
        if failed >= 0:
            raise InputError("control.no_best_efforts")
        return effort.reshape(shape)

    def plan(self, q: JointVector, qd: JointVector, reference: Motion) -> Floats:
        """(N, n) efforts over the horizon at one state, as the law would give them [N m | N].

        Args:
            q, qd: (n,) state.
            reference: desired motion now.

        Raises:
            InputError: the best efforts were not found: the weights differ too much for floating point.
        """
        require_kind("reference", reference, "Motion", "u", "v", "a")
        q, qd = (single(name, x, (self.robot.n,)) for name, x in (("q", q), ("qd", qd)))
        M, known = self.robot.mass_matrix(q), self.robot.inverse_dynamics(q, qd, reference.a)
        w, free, efforts = np.empty((3, self.horizon, self.robot.n))
        errors, rates = (np.asarray(x, dtype=np.float64) for x in (reference.u - q, reference.v - qd))
        arrays = (self.inverse, self.slope, M, known, errors, rates, self.limit, w, free, efforts)
        if not horizon_loops.plan_efforts(*arrays):
            raise InputError("control.no_best_efforts")
        return efforts

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self


def _rows(array: Floats, *core: int) -> Floats:
    """(b, *core), row after row, of one kind of array: loops are compiled for each kind."""
    return np.require(array, np.float64, ("C", "W")).reshape(-1, *core)


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
    """Model predictive control: a finite horizon, efforts within their limits.

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
    if (weights[0] * h**4 + weights[1] * h**2 > COARSEST * spent).any():
        raise InputError("control.interval_coarse", value=h)
    P, gain = _endless(A, B, Q, spent)
    hessian, slope = _condense(A, B, Q, spent, P, N)
    inverse = np.linalg.inv(hessian)
    parts = (hessian, (inverse + np.swapaxes(inverse, 1, 2)) / 2.0, slope, gain, np.asarray(limit, dtype=np.float64))
    return ModelPredictive(robot, h, *(frozen(np.ascontiguousarray(part)) for part in parts))


def _endless(A: Floats, B: Floats, Q: Floats, R: Floats) -> tuple[Floats, Floats]:
    """(n, 2, 2) cost of errors over an infinite horizon without limits, and (n, 2) its gain: w = -gain (e, e')."""
    h = -B[1]
    # With the rate counted per interval and the cost of an acceleration as unit, all entries are pure numbers.
    unit = h**4 / np.outer([1.0, h], [1.0, h]) / R[:, None, None]
    P: Floats = Q * unit
    F: Floats = np.broadcast_to(np.array([[1.0, 1.0], [0.0, 1.0]]), Q.shape)
    one = np.eye(2)
    G: Floats = np.broadcast_to(np.outer([0.5, 1.0], [0.5, 1.0]), Q.shape)
    for _ in range(ROUNDS):
        through: Floats = np.asarray(np.linalg.solve(one + G @ P, np.concatenate([F, G], axis=2)), np.float64)
        back: Floats = np.swapaxes(F, 1, 2)
        after: Floats = P + back @ P @ through[..., :2]
        F, G = F @ through[..., :2], G + F @ through[..., 2:] @ back
        settled = np.abs(after - P).max() <= SETTLED * np.abs(after).max()
        P = after
        if settled:
            break
    else:
        raise InputError("control.interval_coarse", value=h)
    P = P / unit
    PB: Floats = P @ B
    return P, (PB @ A) / (R + PB @ B)[:, None]


def _condense(A: Floats, B: Floats, Q: Floats, R: Floats, P: Floats, N: int) -> tuple[Floats, Floats]:
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
