"""Limits of effort and of the tip along a path: linear in the square of the path velocity and the path acceleration.

A limit is  low <= A(s) u + B(s) x <= high  with u = s'' and x = s'^2. What is no polynomial of s is imposed at three
places of each interval, and measured between them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.robot import Robot
from mafsil.trajectory.path import PathPoint

DIRECTIONS = 16
"""Half the sides of the polygon that stands for a circle of accelerations; it lies inside by 0.5 %."""
LOWEST = 1e-6
"""Share of the largest square of the path velocity below which friction is not linearised."""
NUDGE = 1e-4
"""Relative step of the slope of friction."""


@dataclass(frozen=True, eq=False, slots=True)
class Rows:
    """low <= A u + B x <= high at many places, each (*places, k).

    Attributes:
        A, B, low, high: as in the inequality.
    """

    A: Floats
    B: Floats
    low: Floats
    high: Floats


class SampledLimit(Protocol):
    """A limit along a path."""

    def rows(self, here: PathPoint, x: Floats, most: Floats, ends: Floats) -> Rows:
        """The inequalities at places (places, n) of a path.

        Args:
            here: position, slope and curvature (places, n).
            x: (places,) squares of the path velocity about which friction is linearised.
            most: (places,) the largest squares that are allowed.
            ends: (2, places, n) slopes at both ends of the interval in which each place lies.
        """
        ...

    def excess(self, here: PathPoint, x: Floats, u: Floats) -> Floats:
        """(places, k) by how much a motion exceeds its limits, as share of them; negative where it does not."""
        ...

    def scale(self) -> Floats:
        """(k,) what a bound is lowered by for an excess of its whole size."""
        ...

    def scale_limit(self, joint: int, quantity: str, factor: float) -> SampledLimit:
        """The same limits, of which one is `factor` times as much; itself if it has no such limit."""
        ...

    def label(self, k: int) -> tuple[int, str]:
        """Joint (-1 for the tip) and quantity of column k of `excess`."""
        ...


@dataclass(frozen=True, eq=False, slots=True)
class EffortLimit:
    """The efforts of all joints: the robot's inverse dynamics with rotors, payload and friction.

    tau = a u + b x + g + friction(q' sqrt(x)),  a = M q',  b = M q'' + c(q, q'),  g = gravity.

    Friction grows ever slower with x: its tangent bounds it from above, its chord from zero from below. Where a joint
    turns within an interval friction is taken against both limits.

    Attributes:
        robot: whose dynamics count.
        effort: (2, n) lower and upper limits [N m | N].
    """

    robot: Robot
    effort: Floats

    def rows(self, here: PathPoint, x: Floats, most: Floats, ends: Floats) -> Rows:
        """The inequalities; first those of the upper limits, then those of the lower ones."""
        rest = np.zeros_like(here.u)
        g = self.robot.inverse_dynamics(here.u, rest, rest)
        a = self.robot.inverse_dynamics(here.u, rest, here.slope) - g
        b = self.robot.inverse_dynamics(here.u, here.slope, here.curvature) - g
        g = g + self.robot.friction_torque(rest)
        reverses = ends[0] * ends[1] <= 0.0
        steep = np.where(reverses, np.abs(ends).max(axis=0), np.abs(here.slope))
        about = np.maximum(x, LOWEST * max(float(x.max(initial=0.0)), LEAST_DIVISOR))
        forth, back = (self._bounds(sign * steep, about, np.maximum(most, about)) for sign in (1.0, -1.0))
        ahead = reverses | (here.slope >= 0.0)
        up, up_at_rest = (np.where(ahead, *pair) for pair in zip(forth[:2], back[:2], strict=True))
        behind = reverses | (here.slope < 0.0)
        down, down_at_rest = (np.where(behind, *pair) for pair in zip(back[2:], forth[2:], strict=True))
        unbounded = np.full_like(g, np.inf)
        return Rows(
            np.concatenate([a, a], axis=1),
            np.concatenate([b + up, b + down], axis=1),
            np.concatenate([-unbounded, self.effort[0] - g - down_at_rest], axis=1),
            np.concatenate([self.effort[1] - g - up_at_rest, unbounded], axis=1),
        )

    def excess(self, here: PathPoint, x: Floats, u: Floats) -> Floats:
        """(places, 2 n) of the upper and of the lower limits."""
        tau = self.torque(here, x, u)
        return np.concatenate([(tau - self.effort[1]) / self._size, (self.effort[0] - tau) / self._size], axis=1)

    def torque(self, here: PathPoint, x: Floats, u: Floats) -> Floats:
        """(places, n) efforts of a motion along the path [N m | N]."""
        qd = here.slope * np.sqrt(x)[:, None]
        qdd = here.curvature * x[:, None] + here.slope * u[:, None]
        return self.robot.inverse_dynamics(here.u, qd, qdd) + self.robot.friction_torque(qd)

    def scale(self) -> Floats:
        """(2 n,) the larger magnitude of each joint's limits."""
        return np.tile(self._size, 2)

    def scale_limit(self, joint: int, quantity: str, factor: float) -> EffortLimit:
        """More effort of one joint."""
        if quantity != "effort":
            return self
        effort = self.effort.copy()
        effort[:, joint] *= factor
        return replace(self, effort=effort)

    def label(self, k: int) -> tuple[int, str]:
        """The joint of a column."""
        return k % self.robot.n, "effort"

    @property
    def _size(self) -> Floats:
        size = np.abs(self.effort).max(axis=0)
        return np.where(size > 0.0, size, 1.0)

    def _bounds(self, slope: Floats, x: Floats, most: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Lines over x, slope and constant, above the friction for joint slopes of one sign, and below it."""
        at, before = self._friction(slope, x), self._friction(slope, x * (1.0 - NUDGE))
        tangent = (at - before) / (NUDGE * x[:, None])
        chord, none = self._friction(slope, most) / most[:, None], np.zeros_like(slope)
        line = (tangent, at - tangent * x[:, None])
        outer = (*line, chord, none)
        inner = (chord, none, *line)
        return tuple(np.where(slope >= 0.0, a, b) for a, b in zip(outer, inner, strict=True))  # pyright: ignore[reportReturnType]

    def _friction(self, slope: Floats, x: Floats) -> Floats:
        """Friction beyond that at rest."""
        return self.robot.friction_torque(slope * np.sqrt(x)[:, None]) - self.robot.friction_torque(
            np.zeros_like(slope)
        )


@dataclass(frozen=True, eq=False, slots=True)
class TipLimit:
    """Speed, turning rate and acceleration of the tip.

    With the body Jacobian's rows of velocity J and of rotation W, all in the tip's own axes:
    velocity J q' s',  turning rate W q' s',  acceleration J q' u + (J q'' + J' q' + (W q') x (J q')) x.

    Attributes:
        robot: whose tip is meant.
        speed, turn_rate, acceleration: of the tip's origin, of its axes and of its origin [m/s, rad/s, m/s^2]; infinite
            where there is no limit.
        frame: name of the link whose frame is meant; the tip frame if None.
    """

    robot: Robot
    speed: float
    acceleration: float
    turn_rate: float = np.inf
    frame: str | None = None

    def rows(self, here: PathPoint, x: Floats, most: Floats, ends: Floats) -> Rows:
        """The squares of speed and turning rate; accelerations in DIRECTIONS of the plane in which they lie."""
        w, along, across = self._vectors(here)
        speeds = np.column_stack([(along**2).sum(axis=1), (w**2).sum(axis=1)])
        size = np.linalg.norm(along, axis=1)
        e1 = np.divide(along, size[:, None], out=np.zeros_like(along), where=size[:, None] > 0.0)
        b1 = (across * e1).sum(axis=1)
        b2 = np.linalg.norm(across - b1[:, None] * e1, axis=1)
        angle = np.pi * np.arange(DIRECTIONS) / DIRECTIONS
        c, s = np.cos(angle), np.sin(angle)
        reach = np.full((len(size), DIRECTIONS), self.acceleration * np.cos(np.pi / (2 * DIRECTIONS)))
        return Rows(
            np.column_stack([np.zeros_like(speeds), size[:, None] * c]),
            np.column_stack([speeds, b1[:, None] * c + b2[:, None] * s]),
            np.column_stack([np.full_like(speeds, -np.inf), -reach]),
            np.column_stack([np.full_like(speeds, 1.0) * [self.speed**2, self.turn_rate**2], reach]),
        )

    def excess(self, here: PathPoint, x: Floats, u: Floats) -> Floats:
        """(places, 2 + DIRECTIONS) of both speeds, and of the acceleration in every direction's column."""
        w, along, across = self._vectors(here)
        fast = np.linalg.norm(along, axis=1) * np.sqrt(x) / self.speed - 1.0
        rotating = np.linalg.norm(w, axis=1) * np.sqrt(x) / self.turn_rate - 1.0
        hard = np.linalg.norm(along * u[:, None] + across * x[:, None], axis=1) / self.acceleration - 1.0
        return np.column_stack([fast, rotating, np.repeat(hard[:, None], DIRECTIONS, axis=1)])

    def scale(self) -> Floats:
        """(2 + DIRECTIONS,) twice the squares of the speeds, which grow twice as fast as these; accelerations."""
        return np.append([2.0 * self.speed**2, 2.0 * self.turn_rate**2], np.full(DIRECTIONS, self.acceleration))

    def scale_limit(self, joint: int, quantity: str, factor: float) -> TipLimit:
        """More speed, turning rate or acceleration."""
        match quantity:
            case "tip_speed":
                return replace(self, speed=factor * self.speed)
            case "tip_angular_speed":
                return replace(self, turn_rate=factor * self.turn_rate)
            case "tip_acceleration":
                return replace(self, acceleration=factor * self.acceleration)
            case _:
                return self

    def label(self, k: int) -> tuple[int, str]:
        """Speed, turning rate or acceleration."""
        return -1, ("tip_speed", "tip_angular_speed", "tip_acceleration")[min(k, 2)]

    def _vectors(self, here: PathPoint) -> tuple[Floats, Floats, Floats]:
        """Turning by s, and the vectors (places, 3) of the acceleration by u, which is the velocity by s, and by x."""
        if self.frame is None:
            J, rate = self.robot.jacobian_body(here.u), self.robot.jacobian_body_rate(here.u, here.slope)
        else:
            J = self.robot.jacobian_body(here.u, frame=self.frame)
            rate = self.robot.jacobian_body_rate(here.u, here.slope, frame=self.frame)
        twist = np.einsum("...ij,...j->...i", J, here.slope)
        growth = np.einsum("...ij,...j->...i", J, here.curvature) + np.einsum("...ij,...j->...i", rate, here.slope)
        return twist[:, :3], twist[:, 3:], growth[:, 3:] + np.cross(twist[:, :3], twist[:, 3:])
