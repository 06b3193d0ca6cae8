"""The impact of a point on a rigid surface with Coulomb friction, followed through its impulse (Routh, Stronge).

The normal impulse p grows from zero, and with it dv/dp = G (n + friction), |friction| <= mu.

1. While the point slides, friction is mu against its velocity; where that turns, the direction is integrated.
2. Where sliding ends it sticks, if friction can hold it, or slides on in the direction in which it is then driven.
3. Compression ends where the speed along the normal is zero. The work W of the normal force is then at its least.
4. Restitution ends when it has given back e^2 of that work (Stronge). Friction only takes: energy never grows.

Reference: Stronge, Impact Mechanics, 2nd ed., ch. 4; Routh, Dynamics of a System of Rigid Bodies, 1905.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, exp, inf, log, sin, sqrt

import numpy as np

from mafsil.arrays import Floats
from mafsil.simulation.point_contact import aligned_directions, tangents
from mafsil.simulation.tolerances import END_OF_SLIDING, PARALLEL
from mafsil.solvers import Event, Tolerance, integrate_adaptively, pair

PIECES = 50
"""Of an impact: sliding, sticking or sliding on, in compression and in restitution."""
LONGEST = 1e4
"""Of the integral of dp / |v_t|, over the inverse mass: speeds of sliding change by a factor e^LONGEST at most."""
IMPACT_TOLERANCE = Tolerance(1e-11, 1e-12)


def after_impact(G: Floats, normal: Floats, friction: float, velocity: Floats, restitution: float) -> Floats:
    """Velocity (r,) of a point after it has hit a surface [m/s].

    Args:
        G: (r, r) change of velocity for an impulse [1/kg].
        normal: (r,) unit, out of the surface.
        friction: mu.
        velocity: (r,) before, into the surface [m/s].
        restitution: square root of the share of the normal work that comes back.
    """
    run = _Impact(G, normal, friction, velocity.copy(), restitution, float(np.linalg.norm(velocity)))
    for _ in range(PIECES):
        if run.piece():
            break
    return run.v


@dataclass(slots=True)
class _Impact:
    """An impact that goes on: the velocity, its size before, the work of the normal force and where it ends."""

    G: Floats
    n: Floats
    friction: float
    v: Floats
    restitution: float
    size: float
    work: float = 0.0
    goal: float = inf
    compressed: bool = False

    def piece(self) -> bool:
        """Go on to the next change; true at the end."""
        T = tangents(self.n)
        slip = T.T @ self.v
        speed = float(np.linalg.norm(slip))
        slides = speed > END_OF_SLIDING * self.size
        if slides and self.friction > 0.0:
            d = T @ slip / speed
            rate = self.G @ (self.n - self.friction * d)
            aside = T.T @ rate - float(d @ rate) * (slip / speed)
            if float(np.linalg.norm(aside)) > PARALLEL * float(np.linalg.norm(rate)):
                return self._rotating_slip(T)
            decrease = -float(d @ rate)
            return self._straight(rate, speed / decrease if decrease > 0.0 else inf, T)
        if self.friction == 0.0:
            return self._straight(self.G @ self.n, inf, T)
        self.v = self.v - T @ slip
        return self._straight(self._from_rest(T), inf, T)

    def _from_rest(self, T: Floats) -> Floats:
        """dv/dp (r,) of a point that does not slide: it sticks, or begins to."""
        if T.shape[1] == 0:
            return np.asarray(self.G @ self.n)
        hold = -np.linalg.solve(T.T @ self.G @ T, T.T @ self.G @ self.n)
        driven = aligned_directions(T, lambda d: (self.n - self.friction * d) @ self.G)
        if float(np.linalg.norm(hold)) <= self.friction or not driven:
            return np.asarray(self.G @ (self.n + T @ hold))
        return np.asarray(self.G @ (self.n - self.friction * driven[0]))

    def _straight(self, rate: Floats, until: float, T: Floats) -> bool:
        """A piece whose dv/dp is constant, up to the impulse at which sliding ends."""
        normal, growth = float(self.n @ self.v), float(self.n @ rate)
        if self.compressed:
            end = _work_done(normal, growth, self.goal - self.work)
        else:
            end = -normal / growth if growth > 0.0 else inf
        p = min(until, end)
        self.work += normal * p + growth * p * p / 2.0
        self.v = self.v + p * rate
        if until <= end:
            self.v = self.v - T @ (T.T @ self.v)
            return until == end and self._phase_ended()
        return self._phase_ended()

    def _rotating_slip(self, T: Floats) -> bool:
        """Sliding whose direction turns: log of its speed, its angle, normal speed and work over s, dp = |v_t| ds."""
        first = T.T @ self.v
        speed = float(np.linalg.norm(first))
        A, b, c = self.friction * (T.T @ self.G @ T), T.T @ self.G @ self.n, float(self.n @ self.G @ self.n)

        def field(_: float, y: Floats) -> Floats:
            logarithm, angle, normal, _ = y.tolist()
            x, z = cos(angle), sin(angle)
            p, q = float(b[0] - A[0, 0] * x - A[0, 1] * z), float(b[1] - A[1, 0] * x - A[1, 1] * z)
            size = speed * exp(logarithm)
            growth = c - self.friction * (float(b[0]) * x + float(b[1]) * z)
            return np.array([p * x + q * z, q * x - p * z, size * growth, size * normal])

        least = log(END_OF_SLIDING * self.size / speed)

        def slow(_: float, y: Floats) -> float:
            return float(y[0]) - least

        def phase_end(_: float, y: Floats) -> float:
            return float(y[3]) - self.goal if self.compressed else float(y[2])

        ends = (Event(slow, -1, terminal=True), Event(phase_end, 1, terminal=True))
        start = np.array([0.0, atan2(first[1], first[0]), float(self.n @ self.v), self.work])
        found = integrate_adaptively(
            pair("dop853"), field, start, (0.0, LONGEST / float(np.linalg.norm(self.G))), tolerance=IMPACT_TOLERANCE,
            events=ends,
        ).value  # fmt: skip
        logarithm, angle, normal, self.work = found.y[-1].tolist()
        stopped = bool(found.crossings) and found.crossings[-1].event == 0
        size = 0.0 if stopped else speed * exp(logarithm)
        self.v = normal * self.n + T @ (size * np.array([cos(angle), sin(angle)]))
        return not stopped and self._phase_ended()

    def _phase_ended(self) -> bool:
        """Compression is over, or all of it."""
        if self.compressed:
            return True
        self.v = self.v - float(self.n @ self.v) * self.n
        self.compressed, self.goal = True, (1.0 - self.restitution**2) * self.work
        return self.restitution == 0.0


def _work_done(speed: float, growth: float, work: float) -> float:
    """The impulse at which a normal force has done some work >= 0, rising; infinite if it never does."""
    if growth == 0.0:
        return work / speed if speed > 0.0 else inf
    under = speed * speed + 2.0 * growth * work
    return (sqrt(under) - speed) / growth if under >= 0.0 else inf
