"""Cubics through via points: velocities given, by a rule, from those of the tip, or for continuous acceleration."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer
from mafsil.arrays import Floats, JointVector, Scalar, as_batch, positive, real_array, require_finite, spread
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.robot import Robot, of_robot
from mafsil.trajectory.motion import ViaRateStatus
from mafsil.trajectory.profiles.polynomial import cubic_coefficients
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.tolerances import GIVEN, ROUNDING

if TYPE_CHECKING:
    import mafsil.solvers.cholesky_loops as cholesky_loops
else:
    cholesky_loops = lazily("mafsil.solvers.cholesky_loops")


ViaRule = Literal["continuous", "heuristic", "mean", "weighted_mean", "stop"]
SplineEnds = Literal["clamped", "natural", "periodic"]


def cubic_through(
    points: ArrayLike,
    durations: ArrayLike,
    *,
    velocities: ViaRule | ArrayLike = "continuous",
    start_velocity: ArrayLike = 0.0,
    goal_velocity: ArrayLike = 0.0,
    ends: SplineEnds = "clamped",
) -> PiecewisePolynomial:
    """Cubics through via points.

    continuous: h_k v_{k-1} + 2 (h_{k-1} + h_k) v_k + h_{k-1} v_{k+1} = 3 (h_k d_{k-1} + h_{k-1} d_k), d_k the slopes

    Args:
        points: (*batch, k + 1, n) positions, start and goal included [rad | m]; (k + 1,) is one coordinate.
        durations: (k,) times from point to point, or one number for all [s].
        velocities: at the via points: `continuous` acceleration (a spline), `heuristic` (the mean of the slopes on both
            sides, zero where they differ in sign), `mean` (of the slopes), `weighted_mean` (by the other side's
            duration: that of the parabola through three points), `stop`, or given values, (k - 1, n) or
            (*batch, k - 1, n) [rad/s | m/s], such as `via_rates(...).qd`.
        start_velocity, goal_velocity: (n,) or (*batch, n) at clamped ends [rad/s | m/s].
        ends: of a continuous spline: `clamped` has those velocities, `natural` no acceleration, `periodic` the same
            velocity and acceleration at both ends, which must be one point.

    Raises:
        InputError: a wrong shape, an unknown rule, a duration that is not positive, ends that do not meet.

    Reference: Craig, Introduction to Robotics, sec. 7.3; de Boor, A Practical Guide to Splines, ch. IV.
    """
    u, h = points_and_durations(points, durations)
    if ends not in ("clamped", "natural", "periodic"):
        raise InputError("input.choice", name="ends", value=ends, known="clamped, natural, periodic")
    moving = [
        _end(name, value, u[0].shape)
        for name, value in (("start_velocity", start_velocity), ("goal_velocity", goal_velocity))
    ]
    v = _velocities(u, h, velocities, moving, ends)
    T = h.reshape((-1,) + (1,) * (u.ndim - 1))
    return PiecewisePolynomial.from_pieces(h, np.moveaxis(cubic_coefficients(u[:-1], u[1:], v[:-1], v[1:], T), 0, 1))


def _end(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Floats:
    """A velocity at an end, for all rows of a batch."""
    velocity = require_finite(name, real_array(name, value))
    if velocity.shape not in ((), shape[-1:], shape):
        raise InputError("input.shape", name=name, expected=shape, got=velocity.shape, hint="")
    return np.broadcast_to(velocity, shape)


def _velocities(u: Floats, h: Floats, rule: ViaRule | ArrayLike, moving: list[Floats], ends: SplineEnds) -> Floats:
    """(k + 1, *batch, n) velocities at all points."""
    if isinstance(rule, str) and rule == "continuous":
        return spline_velocities(u, h, ends, moving[0], moving[1])
    if ends != "clamped":
        raise InputError("trajectory.spline_ends", ends=ends)
    return np.concatenate([moving[0][None], _inner(u, h, rule), moving[1][None]])


def _inner(u: Floats, h: Floats, rule: ViaRule | ArrayLike) -> Floats:
    """(k - 1, *batch, n) velocities at the inner points by a rule, or as given."""
    if not isinstance(rule, str):
        given = require_finite("velocities", real_array("velocities", rule))
        inner = (*u.shape[1:-1], len(u) - 2, u.shape[-1])
        if given.shape not in (inner, inner[-2:]):
            raise InputError("input.shape", name="velocities", expected=inner, got=given.shape, hint="")
        return np.moveaxis(np.broadcast_to(given, inner), -2, 0)
    before, after = (x.reshape((-1,) + (1,) * (u.ndim - 1)) for x in (h[:-1], h[1:]))
    slopes = np.diff(u, axis=0) / h.reshape((-1,) + (1,) * (u.ndim - 1))
    left, right = slopes[:-1], slopes[1:]
    match rule:
        case "heuristic":
            return np.where(left * right <= 0.0, 0.0, (left + right) / 2)
        case "mean":
            return (left + right) / 2
        case "weighted_mean":
            return (after * left + before * right) / (before + after)
        case "stop":
            return np.zeros_like(left)
        case _:
            known = "continuous, heuristic, mean, weighted_mean, stop"
            raise InputError("input.choice", name="velocities", value=rule, known=known)


def spline_velocities(
    u: Floats, h: Floats, ends: SplineEnds, v0: Floats | None = None, vn: Floats | None = None
) -> Floats:
    """(k + 1, *batch, n) velocities with which the acceleration is continuous.

    Args:
        u: (k + 1, *batch, n) points.
        h: (k,) durations [s].
        ends: of the spline.
        v0, vn: (*batch, n) velocities of clamped ends.

    Raises:
        InputError: ends of a periodic spline that do not meet.
    """
    rows = u.reshape(len(u), -1)
    slopes = np.diff(rows, axis=0) / h[:, None]
    if ends == "periodic":
        gap = np.abs(rows[-1] - rows[0])
        if gap.max() > GIVEN * max(1.0, float(np.abs(rows).max())):
            raise InputError("trajectory.periodic", gap=float(gap.max()))
        return _periodic(slopes, h).reshape(u.shape)
    lower, diagonal, upper = np.zeros(len(u)), np.ones(len(u)), np.zeros(len(u))
    right = np.empty_like(rows)
    lower[1:-1], diagonal[1:-1], upper[1:-1] = h[1:], 2 * (h[:-1] + h[1:]), h[:-1]
    right[1:-1] = 3 * (h[1:, None] * slopes[:-1] + h[:-1, None] * slopes[1:])
    if ends == "clamped":
        assert v0 is not None
        assert vn is not None
        right[0], right[-1] = v0.ravel(), vn.ravel()
    else:
        diagonal[[0, -1]], upper[0], lower[-1] = 2.0, 1.0, 1.0
        right[0], right[-1] = 3 * slopes[0], 3 * slopes[-1]
    cholesky_loops.solve_tridiagonal(lower, diagonal, upper, right)
    return right.reshape(u.shape)


def _periodic(slopes: Floats, h: Floats) -> Floats:
    """(k + 1, m) velocities of the closed spline: a cyclic system, by Sherman and Morrison."""
    k = len(h)
    before = np.roll(h, 1)
    right = 3 * (h[:, None] * np.roll(slopes, 1, axis=0) + before[:, None] * slopes)
    if k <= 2:
        matrix = np.zeros((k, k))
        for i in range(k):
            matrix[i, i] += 2 * (before[i] + h[i])
            matrix[i, (i - 1) % k] += h[i]
            matrix[i, (i + 1) % k] += before[i]
        closed = np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)
        return np.concatenate([closed, closed[:1]])
    lower, diagonal, upper = h.copy(), 2 * (before + h), before.copy()
    corner_first, corner_last = lower[0], upper[-1]
    gamma = -diagonal[0]
    diagonal[0] -= gamma
    diagonal[-1] -= corner_first * corner_last / gamma
    lower[0] = upper[-1] = 0.0
    bend = np.zeros((k, 1))
    bend[0], bend[-1] = gamma, corner_last
    both = np.concatenate([right, bend], axis=1)
    cholesky_loops.solve_tridiagonal(lower, diagonal, upper, both)
    y, z = both[:, :-1], both[:, -1:]
    share = (y[0] + corner_first / gamma * y[-1]) / (1.0 + z[0] + corner_first / gamma * z[-1])
    v = y - z * share
    return np.concatenate([v, v[:1]])


def points_and_durations(points: ArrayLike, durations: ArrayLike) -> tuple[Floats, Floats]:
    """(k + 1, *batch, n) points, the points first, and (k,) durations.

    Args:
        points: (*batch, k + 1, n), or (k + 1,) of one coordinate [rad | m].
        durations: (k,), or one number for all [s].

    Raises:
        InputError: a wrong shape, a number that is not finite, a duration that is not positive.
    """
    u = require_finite("points", real_array("points", points))
    u = u[:, None] if u.ndim == 1 else u
    h = require_finite("durations", real_array("durations", durations))
    if u.ndim < 2 or u.shape[-2] < 2 or u.shape[-1] < 1:
        raise InputError("input.shape", name="points", expected="(*batch, k + 1, n), k >= 1", got=u.shape, hint="")
    legs = (u.shape[-2] - 1,)
    if h.shape not in ((), legs):
        raise InputError("input.shape", name="durations", expected=legs, got=h.shape, hint="")
    for extreme in (h.min(), h.max()):
        positive("durations", float(extreme))
    return np.moveaxis(u, -2, 0), np.broadcast_to(h, legs).astype(np.float64)


@dataclass(frozen=True, eq=False, repr=False)
class ViaRates(Answer, data="qd condition damping residual exact most_condition"):
    """Joint rates for velocities of the tip; true where all are made.

    Attributes:
        qd: (*batch, n) [rad/s | m/s].
        condition: (*batch,) largest over smallest singular value of the Jacobian of what was asked.
        damping: (*batch,) lambda of the damped inverse; 0 where it is exact.
        residual: (*batch,) norm of what J qd lacks of the velocity.
        exact: (*batch,) whether the velocity is made.
        most_condition: from which condition number on the inverse is damped.
    """

    qd: JointVector
    condition: Scalar
    damping: Scalar
    residual: Scalar
    exact: NDArray[np.bool_]
    most_condition: float

    def __bool__(self) -> bool:
        return bool(self.exact.all())

    def __len__(self) -> int:
        return len(self.exact) if self.exact.ndim else 1

    def __iter__(self) -> Iterator[JointVector]:
        return iter(self.qd if self.exact.ndim else (self.qd,))

    @property
    def status(self) -> Any:
        """The status, a member of `ViaRateStatus`; of a batch an array (*batch,) of them."""
        found = np.full(self.exact.shape, ViaRateStatus.EXACT, dtype=np.object_)
        found[~self.exact & (self.damping > 0.0)] = ViaRateStatus.DAMPED
        found[~self.exact & (self.damping == 0.0)] = ViaRateStatus.NOT_POSSIBLE
        return found if found.ndim else found[()]

    def explain(self, language: str | None = None) -> str:
        """How many velocities are made, and the worst of the others."""
        count, made = self.exact.size, int(self.exact.sum())
        lines = [say("trajectory.via_rates", language=language, made=made, count=count)]
        if made < count:
            worst = np.unravel_index(int(np.where(self.exact, -1.0, self.residual).argmax()), self.exact.shape)
            details = {name: float(getattr(self, name)[worst]) for name in ("condition", "damping", "residual")}
            status: ViaRateStatus = self.status[worst] if self.exact.ndim else self.status
            lines.append(status.sentence(language, most=self.most_condition, **details))
        return "\n".join(lines)


@of_robot
def via_rates(
    robot: Robot,
    q: ArrayLike,
    *,
    linear: ArrayLike | None = None,
    angular: ArrayLike | None = None,
    weights: ArrayLike | None = None,
    most_condition: float = 1e3,
    frame: str | None = None,
) -> ViaRates:
    """qd = J# (omega; v) at via points, for `cubic_through(..., velocities=via_rates(...).qd)`.

    J# = W^-1 J' (J W^-1 J' + lambda^2 I)^-1,  lambda = 0 below `most_condition`; beyond it grows with
    lambda^2 = (1 - (s_min most_condition/s_max)^2) (s_max/most_condition)^2, so that no rate jumps.

    Args:
        robot: whose tip or `frame` moves.
        q: (*batch, n) at the points [rad | m].
        linear: (*batch, 3) velocity of the tip's origin in {s}; None if it is free [m/s].
        angular: (*batch, 3) angular velocity in {s}; None if it is free [rad/s].
        weights: (n,) cost of each joint's rate, positive; all 1 if None.
        most_condition: the condition number beyond which the inverse is damped.
        frame: name of a link; the tip if None.

    Raises:
        InputError: a wrong shape, a number that is not finite, neither velocity, a weight that is not positive.

    Reference: Nakamura and Hanafusa, Inverse kinematic solutions with singularity robustness, 1986.
    """
    Q = as_batch("q", q, (robot.n,), finite=True)
    bound = positive("most_condition", most_condition)
    wanted = [
        None if value is None else as_batch(name, value, (3,), finite=True)
        for name, value in (("angular", angular), ("linear", linear))
    ]
    if linear is None and angular is None:
        raise InputError("trajectory.no_tip_velocity")
    W = np.ones(robot.n) if weights is None else real_array("weights", weights)
    if W.shape != (robot.n,) or not ((W > 0.0) & np.isfinite(W)).all():
        raise InputError("trajectory.weights", n=robot.n)
    if frame is None:
        J_b, T = robot.jacobian_body(Q), robot.forward_kinematics(Q)
    else:
        J_b, T = robot.jacobian_body(Q, frame=frame), robot.forward_kinematics(Q, frame=frame)
    R = T[..., :3, :3]
    blocks = [R @ J_b[..., k : k + 3, :] for k, each in zip((0, 3), wanted, strict=True) if each is not None]
    J = np.concatenate(blocks, axis=-2)
    V = np.concatenate(
        [
            spread(name, each, (*Q.shape[:-1], 3))
            for name, each in zip(("angular", "linear"), wanted, strict=True)
            if each is not None
        ],
        axis=-1,
    )
    return _rates(J, V, 1.0 / np.sqrt(W), bound)


def _rates(J: Floats, V: Floats, scale: Floats, bound: float) -> ViaRates:
    """1. Singular values of the weighted Jacobian, which the task's rows or the joints have.  2. Damping.  3. Rates."""
    # 1
    s_all = np.linalg.svd(J, compute_uv=False)
    U, s, Vt = np.linalg.svd(J * scale, full_matrices=False)
    # Rows that no joint can move, as those out of the plane of a planar arm, are no singularity.
    rank = min(int((s_all.max(axis=tuple(range(s_all.ndim - 1))) > ROUNDING * s_all.max()).sum()), s.shape[-1])
    s_all, s, U, Vt = s_all[..., :rank], s[..., :rank], U[..., :rank], Vt[..., :rank, :]
    with np.errstate(divide="ignore"):
        condition = s_all[..., 0] / s_all[..., -1]
    # 2
    least = s[..., 0] / bound
    squared = np.where(s[..., -1] < least, (1.0 - (s[..., -1] / least) ** 2) * least**2, 0.0)
    # 3
    inverse = s / (s**2 + squared[..., None])
    along = (np.swapaxes(U, -1, -2) @ V[..., None])[..., 0]
    qd = scale * (np.swapaxes(Vt, -1, -2) @ (inverse * along)[..., None])[..., 0]
    residual = np.linalg.norm((J @ qd[..., None])[..., 0] - V, axis=-1)
    exact = np.asarray(residual <= GIVEN * np.linalg.norm(V, axis=-1), dtype=np.bool_)
    return ViaRates(qd, np.asarray(condition), np.sqrt(squared), np.asarray(residual), exact, bound)
