"""Bodies that roll without slipping: coin, unicycle, cart of two wheels, car; their constraints and exact motions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import mafsil.expression as ex
from mafsil.arrays import Floats, as_batch, positive, single
from mafsil.errors import InputError
from mafsil.mobility.spaces.pfaffian import Pfaffian
from mafsil.mobility.spaces.planar_positions import finite_numbers
from mafsil.solvers import first_order, integrate
from mafsil.solvers.integrate import RK4

SMALL_TURN = 1e-4
"""Turns [rad] below it use the series of sin(x)/x, whose first dropped term is x^6/5040, below rounding."""


def _arc(turn: Floats) -> tuple[Floats, Floats]:
    """sin(x)/x and (1 - cos x)/x of turns x."""
    small = np.abs(turn) < SMALL_TURN
    safe = np.where(small, 1.0, turn)
    half = np.where(small, turn / 2 - turn**3 / 24, 2 * np.sin(safe / 2) ** 2 / safe)
    return np.where(small, 1 - turn**2 / 6 + turn**4 / 120, np.sin(safe) / safe), half


def roll_along(x: Floats, y: Floats, phi: Floats, way: Floats, turn: Floats) -> tuple[Floats, Floats]:
    """Place after a way [m] along an arc that turns by `turn` [rad] from heading phi: exact for constant rates."""
    forward, sideward = _arc(turn)
    return (
        x + way * (forward * np.cos(phi) - sideward * np.sin(phi)),
        y + way * (forward * np.sin(phi) + sideward * np.cos(phi)),
    )


@dataclass(frozen=True)
class Coin:
    """An upright disc that rolls on a plane: q = (x, y, phi, theta), contact point, heading, roll.

    Attributes:
        radius: r [m].
    """

    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", positive("radius", self.radius))

    @property
    def constraints(self) -> Pfaffian:
        """x' = r theta' cos phi, y' = r theta' sin phi."""
        r = self.radius

        def rows(q: Any) -> Sequence[Sequence[Any]]:
            return [[1, 0, 0, -r * ex.cos(q[2])], [0, 1, 0, -r * ex.sin(q[2])]]

        return Pfaffian(("x", "y", "phi", "theta"), rows)

    def drive(self, q: ArrayLike, phi_dot: ArrayLike, theta_dot: ArrayLike, duration: ArrayLike) -> Floats:
        """(*batch, 4) configuration after constant rates of heading and roll [rad/s] for a time [s]: exact.

        Args:
            q: (*batch, 4) start.
            phi_dot, theta_dot: (*batch,) [rad/s].
            duration: (*batch,) [s].
        """
        start, T = as_batch("q", q, (4,)), finite_numbers("duration", duration)
        turn, roll = finite_numbers("phi_dot", phi_dot) * T, finite_numbers("theta_dot", theta_dot) * T
        x, y = roll_along(start[..., 0], start[..., 1], start[..., 2], self.radius * roll, turn)
        return np.stack(np.broadcast_arrays(x, y, start[..., 2] + turn, start[..., 3] + roll), axis=-1)

    def manoeuvre(self, q: ArrayLike, steps: Sequence[tuple[float, float]]) -> Floats:
        """(len(steps) + 1, 4) configurations after each (change of heading, roll) [rad], one after the other."""
        path = [as_batch("q", q, (4,), finite=True)]
        for steer, roll in steps:
            path.append(self.drive(path[-1], steer, roll, 1.0))
        return np.array(path)

    def pose(self, q: ArrayLike) -> Floats:
        """(*batch, 4, 4) pose of the coin: origin in its centre, y along the spin axis (-sin phi, cos phi, 0)."""
        c = as_batch("q", q, (4,))
        phi, theta = c[..., 2], c[..., 3]
        spin = np.stack([-np.sin(phi), np.cos(phi), np.zeros_like(phi)], axis=-1)
        ahead = np.stack([np.cos(phi), np.sin(phi), np.zeros_like(phi)], axis=-1)
        up = np.broadcast_to(np.array([0.0, 0.0, 1.0]), ahead.shape)
        ct, st = np.cos(theta)[..., None], np.sin(theta)[..., None]
        T = np.zeros((*phi.shape, 4, 4))
        T[..., :3, 0], T[..., :3, 1], T[..., :3, 2] = ct * ahead - st * up, spin, st * ahead + ct * up
        T[..., 0, 3], T[..., 1, 3], T[..., 2, 3], T[..., 3, 3] = c[..., 0], c[..., 1], self.radius, 1.0
        return T

    def rim_point(self, q: ArrayLike) -> Floats:
        """(*batch, 3) the point of the rim that touches the plane at theta = 0 [m]."""
        T = self.pose(q)
        return T[..., :3, 3] - self.radius * T[..., :3, 2]


@dataclass(frozen=True)
class Unicycle:
    """A wheel without its roll angle: q = (x, y, phi)."""

    @property
    def constraints(self) -> Pfaffian:
        """x' sin phi - y' cos phi = 0: no slip across the heading."""
        return Pfaffian(("x", "y", "phi"), lambda q: [[ex.sin(q[2]), -ex.cos(q[2]), 0]])

    def drive(self, q: ArrayLike, speed: ArrayLike, phi_dot: ArrayLike, duration: ArrayLike) -> Floats:
        """(*batch, 3) configuration after constant speed [m/s] and turning rate [rad/s] for a time [s]: exact.

        Args:
            q: (*batch, 3) start.
            speed, phi_dot, duration: (*batch,).
        """
        start, T = as_batch("q", q, (3,)), finite_numbers("duration", duration)
        turn = finite_numbers("phi_dot", phi_dot) * T
        x, y = roll_along(start[..., 0], start[..., 1], start[..., 2], finite_numbers("speed", speed) * T, turn)
        return np.stack(np.broadcast_arrays(x, y, start[..., 2] + turn), axis=-1)


@dataclass(frozen=True)
class Cart:
    """A cart on two driven wheels: q = (x, y, phi, theta_R, theta_L).

    Attributes:
        radius: of the wheels, r [m].
        width: distance of the wheels, b [m].
    """

    radius: float
    width: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", positive("radius", self.radius))
        object.__setattr__(self, "width", positive("width", self.width))

    @property
    def constraints(self) -> Pfaffian:
        """No slip across, and none along at either wheel: x' cos phi + y' sin phi +- (b/2) phi' = r theta'."""
        r, half = self.radius, self.width / 2

        def rows(q: Any) -> Sequence[Sequence[Any]]:
            c, s = ex.cos(q[2]), ex.sin(q[2])
            return [[-s, c, 0, 0, 0], [c, s, half, -r, 0], [c, s, -half, 0, -r]]

        return Pfaffian(("x", "y", "phi", "theta_R", "theta_L"), rows)

    def first_integral(self, q: Any) -> Any:
        """phi - (r/b)(theta_R - theta_L), which no motion changes; of numbers or expressions."""
        return q[2] - self.radius / self.width * (q[3] - q[4])

    def drive(self, q: ArrayLike, wheel_rates: ArrayLike, duration: ArrayLike) -> Floats:
        """(*batch, 5) configuration after constant rates of the wheels for a time: exact.

        Args:
            q: (*batch, 5) start.
            wheel_rates: (*batch, 2) right, left [rad/s].
            duration: (*batch,) [s].
        """
        start, rates = as_batch("q", q, (5,)), as_batch("wheel_rates", wheel_rates, (2,))
        roll = rates * finite_numbers("duration", duration)[..., None]
        way = self.radius * (roll[..., 0] + roll[..., 1]) / 2
        turn = self.radius * (roll[..., 0] - roll[..., 1]) / self.width
        x, y = roll_along(start[..., 0], start[..., 1], start[..., 2], way, turn)
        parts = (x, y, start[..., 2] + turn, start[..., 3] + roll[..., 0], start[..., 4] + roll[..., 1])
        return np.stack(np.broadcast_arrays(*parts), axis=-1)


@dataclass(frozen=True)
class Car:
    """A car with steered front wheels: q = (x, y, phi, steer), place of the rear axle.

    Attributes:
        length: distance of the axles [m].
    """

    length: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "length", positive("length", self.length))

    @property
    def constraints(self) -> Pfaffian:
        """No slip across at the rear axle and at the front wheels."""
        L = self.length

        def rows(q: Any) -> Sequence[Sequence[Any]]:
            front = q[2] + q[3]
            return [
                [-ex.sin(q[2]), ex.cos(q[2]), 0, 0],
                [-ex.sin(front), ex.cos(front), L * ex.cos(q[3]), 0],
            ]

        return Pfaffian(("x", "y", "phi", "steer"), rows)

    def rates(self, q: Floats, speed: Floats, steer_rate: Floats) -> Floats:
        """(*batch, 4) rates at a speed of the rear axle [m/s] and a rate of steering [rad/s]."""
        phi, steer = q[..., 2], q[..., 3]
        parts = (speed * np.cos(phi), speed * np.sin(phi), speed * np.tan(steer) / self.length, steer_rate)
        return np.stack(np.broadcast_arrays(*parts), axis=-1)

    def drive(
        self, q: ArrayLike, inputs: Callable[[float], tuple[float, float]], duration: float, step: float = 0.005
    ) -> Floats:
        """(k + 1, *batch, 4) configurations under inputs over time, Runge-Kutta of fourth order.

        Args:
            q: (*batch, 4) start; steering angles within a right angle.
            inputs: of the time [s]: speed [m/s] and rate of steering [rad/s].
            duration: of the drive [s].
            step: of the integration [s].

        Raises:
            InputError: steering angles of a right angle or more.
        """
        start = as_batch("q", q, (4,), finite=True)
        if not (np.abs(start[..., 3]) < np.pi / 2).all():
            raise InputError("mobility.steer", angle=float(np.abs(start[..., 3]).max()))
        steps = max(1, int(np.ceil(positive("duration", duration) / positive("step", step))))

        def field(t: float, state: Floats) -> Floats:
            speed, steer = single("inputs(t)", inputs(t), (2,))
            return self.rates(state, np.asarray(speed), np.asarray(steer))

        done = integrate(first_order(RK4, field), (start,), duration / steps, steps)
        return done.value[0]
