"""Errors that remain: under gravity at rest, behind a ramp, behind a sine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats, require_function, single
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.one_joint.error_dynamics import ErrorDynamics
from mafsil.one_joint.polynomial import Complexes
from mafsil.one_joint.rows import RowAnswer, above_zero, check_batch, finite, magnitude, row, together
from mafsil.one_joint.tolerances import BALANCED, ROUNDOFF

ITERATIONS = 100
"""Of Newton's method for the rest of many joints."""

AT_REST = 1e-13
"""Torque, as a share of the torques that balance, below which joints are at rest."""

STEP = 1e-6
"""Of the differences for the slope of a gravity function [rad | m]."""


class RestStatus(Status):
    """Where PD control comes to rest."""

    UNIQUE = ("one_joint.rest_unique", True)
    ONE_OF_SEVERAL = ("one_joint.rest_several", True)
    NOT_FOUND = ("one_joint.rest_not_found", False)
    FOUND = ("one_joint.rest_found", True)


@dataclass(frozen=True, eq=False, repr=False)
class RestError(RowAnswer):
    """Where Kp (theta_d - theta) = g(theta); true where found.

    Attributes:
        verdict: (*batch) which of `statuses`.
        error: (*batch), or (*batch, n) of many joints, theta_d - theta [rad | m].
        torque: same shape, Kp error [N m | N].
        residual: (*batch) largest torque that does not balance [N m | N].
    """

    statuses: ClassVar[tuple[Status, ...]] = tuple(RestStatus)
    verdict: NDArray[np.int8]
    error: Floats
    torque: Floats
    residual: Floats


def steady_state_error(kp: ArrayLike, gravity_moment: ArrayLike, goal: ArrayLike) -> RestError:
    """Rest of one joint under PD control: Kp (theta_d - theta) = m g r cos(theta), theta from the horizontal.

    Args:
        kp: (*batch) [N m/rad].
        gravity_moment: m g r (*batch) [N m]; of a model that is partly compensated, what is left of it.
        goal: theta_d (*batch) [rad].

    Returns:
        The rest position nearest to the goal. It is the only one if Kp > m g r; otherwise there may be several, and
        which one is reached depends on the start.

    Raises:
        InputError: a number out of its range, shapes that do not go together.

    Reference: Lynch and Park, Modern Robotics, eq. (11.20).
    """
    k, load, desired = together(
        kp=above_zero("kp", kp), gravity_moment=finite("gravity_moment", gravity_moment), goal=finite("goal", goal)
    )
    # 1. F(e) = k e - L cos(theta_d - e) has the sign of -L cos(theta_d) at e = 0 and the other one at e = L cos / k...
    side = np.where(load * np.cos(desired) < 0.0, -1.0, 1.0)
    # 2. ... or before |e| = |L| / k: march to the first change of sign, so that the nearest root is found,
    reach = np.abs(load) / k
    samples = np.linspace(0.0, 1.0, 257) * np.maximum(reach, 0.0)[..., None] * (1.0 + ROUNDOFF)
    value = side[..., None] * _net_load(k[..., None], load[..., None], desired[..., None], side[..., None] * samples)
    first = np.argmax(value >= 0.0, axis=-1)
    low = np.take_along_axis(samples, np.maximum(first - 1, 0)[..., None], -1)[..., 0]
    high = np.take_along_axis(samples, first[..., None], -1)[..., 0]
    # 3. and halve.
    for _ in range(80):
        middle = 0.5 * (low + high)
        before = side * _net_load(k, load, desired, side * middle) < 0.0
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    e = side * high
    verdict = np.where(k > np.abs(load), 0, 1).astype(np.int8)
    return RestError(verdict, e, k * e, np.abs(_net_load(k, load, desired, e)))


def _net_load(k: Floats, load: Floats, desired: Floats, e: Floats) -> Floats:
    return k * e - load * np.cos(desired - e)


def steady_state_of_joints(kp: ArrayLike, gravity: Callable[[Floats], ArrayLike], goal: ArrayLike) -> RestError:
    """Rest of many joints under PD control: Kp theta_e = g(theta), by Newton's method from the goal.

    Args:
        kp: (n,) or (n, n), symmetric and positive definite [N m/rad | N/m].
        gravity: torques (n,) of positions (n,), such as `robot.gravity_torque`.
        goal: (n,) [rad | m].

    Returns:
        The rest nearest along Newton's steps, FOUND or NOT_FOUND, with the residual in both cases. Nothing is said
        about others: with Kp above the slopes of g there are none.

    Raises:
        InputError: wrong shapes, not finite, no function.
    """
    desired = row("goal", goal)
    if desired.ndim != 1:
        raise InputError("input.shape", name="goal", expected="(n,)", got=desired.shape, hint="")
    require_function("gravity", gravity, "function g(theta)", 1)
    K, n = finite("kp", kp), len(desired)
    if K.shape not in ((), (n,), (n, n)):
        raise InputError("input.shape", name="kp", expected=(n,), got=K.shape, hint="")
    K = np.diag(np.broadcast_to(K, (n,))) if K.ndim < 2 else K

    def load(theta: Floats) -> Floats:
        return single("gravity", gravity(theta), (n,))

    e = np.zeros(n)
    for _ in range(ITERATIONS):
        theta = desired - e
        g = load(theta)
        F = K @ e - g
        if np.abs(F).max() <= AT_REST * (np.abs(g).max() + np.abs(K @ e).max()):
            break
        slope = np.stack([(load(theta + d) - load(theta - d)) / (2.0 * STEP) for d in STEP * np.eye(n)], axis=1)
        e = e - np.linalg.solve(K + slope, F)
    g = load(desired - e)
    residual = np.abs(K @ e - g).max()
    found = residual <= BALANCED * max(float(np.abs(g).max()), LEAST_DIVISOR)
    return RestError(np.array(3 if found else 2, dtype=np.int8), e, K @ e, np.asarray(residual))


@dataclass(frozen=True, eq=False, slots=True)
class TrackingError:
    """What feedback alone leaves when the reference moves, without gravity.

    M e'' + (b + Kd) e' + Kp e + Ki int e = M theta_d'' + b theta_d'

    Attributes:
        inertia, friction, kp, ki, kd: (*batch).
    """

    inertia: Floats
    friction: Floats
    kp: Floats
    ki: Floats
    kd: Floats
    __post_init__ = check_batch(inertia=above_zero, friction=magnitude, kp=above_zero, ki=magnitude, kd=magnitude)

    @classmethod
    def of(
        cls, inertia: ArrayLike, friction: ArrayLike, kp: ArrayLike, ki: ArrayLike = 0.0, kd: ArrayLike = 0.0
    ) -> TrackingError:
        """From the joint and its gains.

        Args:
            inertia: M (*batch) [kg m^2 | kg].
            friction: b (*batch) [N m s/rad | N s/m].
            kp, ki, kd: gains of the torque (*batch).

        Raises:
            InputError: a number out of its range, shapes that do not go together.
        """
        return cls(*together(inertia=inertia, friction=friction, kp=kp, ki=ki, kd=kd))

    def ramp(self, speed: ArrayLike) -> Floats:
        """(*batch) the error that remains behind a ramp theta_d = speed t: b speed / Kp; zero with an integral."""
        rate, _ = together(speed=finite("speed", speed), kp=self.kp)
        lag = rate * self.friction / self.kp
        return np.where(self.ki > 0.0, 0.0, lag)

    def sine(self, frequency: ArrayLike) -> Complexes:
        """(*batch, k) error per sine theta_d = sin(w t): modulus and phase of its steady oscillation.

        Args:
            frequency: (k,) w > 0 [rad/s].

        Returns:
            (M s^2 + b s) / (M s^2 + (b + Kd) s + Kp + Ki / s) at s = j w. An integral term does not remove it.
        """
        w = above_zero("frequency", row("frequency", frequency))
        M, b, d = self.inertia, self.friction, self.friction + self.kd
        zero = np.zeros_like(M)
        closed = ErrorDynamics.of(M, d, self.kp, self.ki)
        return closed.frequency_response(np.stack([M, b, zero, zero], axis=-1), w)
