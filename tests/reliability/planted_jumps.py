"""Motions with and without planted jumps: every jump is found where it is, and no motion without one is accused.

`python -m tests.reliability.planted_jumps --motions 10000 --resume DIR`; beside every twenty clean motions there is one
with a planted jump.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

import mafsil.trajectory as tr
from mafsil.trajectory.motion import Motion, Trajectory, derivative
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from tests.reliability import figures

MEASURED = -2
"""Instead of an order that is not known by construction."""
CLEAN_PER_PLANTED = 20
QUANTITIES = ("velocity", "acceleration", "jerk")


@dataclass(frozen=True)
class Kicked:
    """A motion to which size (t - time)^order / order! is added from a time on; whether it names that time or not."""

    inner: Trajectory
    time: float
    order: int
    size: np.ndarray
    named: bool

    @property
    def duration(self):
        return self.inner.duration

    @property
    def n(self):
        return self.inner.n

    def breaks(self):
        own = self.inner.breaks()
        return np.unique(np.append(own, self.time)) if self.named else own

    def at(self, t):
        moment = np.asarray(t, dtype=float)
        return Motion(*(value + self._kick(moment, k) for k, value in enumerate(self.inner.at(moment))))

    def jerk(self, t):
        moment = np.asarray(t, dtype=float)
        return self.inner.jerk(moment) + self._kick(moment, 3)

    def _kick(self, t, k):
        since = np.where(t >= self.time, t - self.time, 0.0)[..., None]
        if k > self.order:
            return 0.0 * since * self.size
        power = self.order - k
        value = since**power / max(1.0, float(power)) if power else np.where(t >= self.time, 1.0, 0.0)[..., None]
        return np.where((t >= 0.0) & (t <= self.duration), 1.0, 0.0 if k else 1.0)[..., None] * value * self.size


def motion(rng: np.random.Generator) -> tuple[Trajectory, int]:
    """A motion of a random kind on random scales of time and place, and the highest derivative that is continuous."""
    n, k = int(rng.integers(1, 5)), int(rng.integers(1, 7))
    place, pace = 10.0 ** rng.uniform(-3, 3), 10.0 ** rng.uniform(-4, 4)
    u = place * (rng.normal(size=(k + 1, n)) + 10.0 ** rng.uniform(-3, 2) * (rng.random() < 0.3))
    h = pace * 10.0 ** rng.uniform(-1.5, 0.5, k)
    kind = int(rng.integers(9))
    if kind == 0:
        return tr.quintic(u[0], u[1], h[0]), 2
    if kind == 1:
        return tr.septic(u[0], u[1], h[0]), 3
    if kind == 2:
        return tr.cubic_through(u, h), 1
    if kind == 3:
        return tr.sequence(*(tr.quintic(a, b, T) for a, b, T in zip(u, u[1:], h, strict=False)), rests=float(h[0])), 2
    if kind == 4:
        d = np.ptp(u, axis=0).max()
        plan = tr.linear_blends(u, h, acceleration=100.0 * d / h.min() ** 2)
        if plan.trajectory is None or not plan:
            return tr.quintic(u[0], u[1], h[0]), 2
        return plan.trajectory if rng.random() < 0.5 else plan.trajectory.to_polynomial(), 1
    if kind == 5:
        scale = np.ptp(u, axis=0).max() + place * 1e-3
        limits = tr.MotionLimits.of(
            n, velocity=scale / pace, acceleration=5.0 * scale / pace**2, jerk=60.0 * scale / pace**3
        )
        found = tr.jerk_limited(u[0], u[1], limits)
        return found if rng.random() < 0.5 else found.polynomial(), 2
    if kind == 6:
        names = [row for row in _laws() if row.order >= 1]
        law = names[int(rng.integers(len(names)))]
        return tr.time_law(law.name).between(u[0], u[1], float(h[0])), law.order
    if kind == 7:
        return tr.bspline_through(u, h, degree=int(rng.choice([3, 5]))), MEASURED
    scale = np.ptp(u, axis=0).max() + place * 1e-3
    bounds = tr.MotionLimits.of(n, velocity=scale / pace, acceleration=5.0 * scale / pace**2)
    found = tr.time_optimal(tr.JointPath.through(u, "spline" if k > 1 else "lines"), bounds, intervals=60).trajectory
    assert found is not None
    return found, 1


@cache
def _laws() -> tuple[Any, ...]:
    return tr.profiles.profiles().rows


def peaks(trajectory: Trajectory, order: int) -> np.ndarray:
    """(n,) the largest magnitudes of a derivative among its breaks and many times."""
    breaks = trajectory.breaks()
    t = np.unique(np.concatenate([np.linspace(0, trajectory.duration, 2001), breaks, np.nextafter(breaks[1:], 0.0)]))
    return np.abs(derivative(trajectory, t, order)).max(axis=0)


def limits_of(trajectory: Trajectory, highest: int) -> tr.MotionLimits:
    """Twice what the motion needs, up to a derivative; no limit above."""
    bounds = {QUANTITIES[k - 1]: 2.0 * peaks(trajectory, k) + 1e-12 for k in range(1, highest + 1)}
    return tr.MotionLimits.of(trajectory.n, **bounds)


def accused(rng: np.random.Generator) -> str:
    """What a clean motion is accused of; nothing if it is not."""
    trajectory, order = motion(rng)
    measured = order == MEASURED
    if measured:
        order = tr.continuity(trajectory, ends=False).order
    limits = limits_of(trajectory, min(order + 1, 3))
    verdict = tr.check(trajectory, limits, ends=not measured)
    exact = isinstance(trajectory, PiecewisePolynomial | tr.splines.BSpline)
    proof = tr.prove(trajectory, limits, ends=not measured) if exact else True
    return "" if verdict and proof else f"{type(trajectory).__name__} {order}: {verdict} {proof}"


def missed(rng: np.random.Generator) -> str:
    """The jump that is planted in a motion and not found where it is; nothing if it is."""
    trajectory, order = motion(rng)
    kick = int(rng.integers(0, min(max(order, 1), 2) + 1))
    size = np.zeros(trajectory.n)
    joint = int(rng.integers(trajectory.n))
    largest = max(peaks(trajectory, kick)[joint], 1e-2 if kick == 0 else 0.0)
    size[joint] = rng.choice([-1.0, 1.0]) * largest * 10.0 ** rng.uniform(-4, 0.5)
    if size[joint] == 0.0:
        return ""
    time = trajectory.duration * rng.uniform(0.02, 0.98)
    if rng.random() < 0.3:
        time = float(rng.choice(trajectory.breaks()[1:-1])) if len(trajectory.breaks()) > 2 else time
    named = isinstance(trajectory, PiecewisePolynomial) or bool(rng.random() < 0.5)
    kicked: Trajectory = Kicked(trajectory, time, kick, size, named)
    if isinstance(trajectory, PiecewisePolynomial):
        kicked = planted(trajectory, time, kick, size)
    limits = tr.MotionLimits.of(trajectory.n, **{QUANTITIES[kick]: 1e30})
    found = tr.check(kicked, limits, ends=False)
    right = [v for v in found if v.joint == str(joint) and v.quantity == QUANTITIES[kick] and np.isinf(v.value)]
    near = right and abs(right[0].time - time) <= 1e-6 * trajectory.duration
    exact = near and abs(right[0].jump - size[joint]) <= 1e-2 * abs(size[joint])
    proof = tr.prove(kicked, limits, ends=False) if isinstance(kicked, PiecewisePolynomial) else False
    if exact and not proof:
        return ""
    what = f"derivative {kick} by {size[joint]:.3g} at {time:.6g}, named {named}"
    return f"{type(trajectory).__name__} {what}: {found} {proof}"


def planted(motion: PiecewisePolynomial, time: float, order: int, size: np.ndarray) -> PiecewisePolynomial:
    """The same with a jump, as polynomials: a knot at the time, a power added to all pieces behind it."""
    knots = np.unique(np.append(motion.knots, time))
    degree = max(motion.degree, order)
    factorial = np.cumprod(np.append(1.0, np.arange(1.0, degree + 1.0)))
    rows = np.stack([motion.derivative(knots[:-1], k) for k in range(degree + 1)], axis=1)
    rows = rows / factorial[:, None]
    for i, knot in enumerate(knots[:-1]):
        if knot >= time:
            for k in range(order + 1):
                since = (knot - time) ** (order - k)
                rows[i, k] += size * since / max(1.0, float(order - k)) / factorial[k]
    return PiecewisePolynomial(knots, rows)


def work(seed: int, motions: int) -> dict[str, int]:
    """Clean motions, and a planted jump in one more of every twenty; what was missed or accused is printed."""
    planted_ones = motions // CLEAN_PER_PLANTED
    counts = {"motions": motions, "planted": planted_ones}
    for name, count, trial in (("missed", planted_ones, missed), ("accused", motions, accused)):
        said = [(k, trial(np.random.default_rng((0, k)))) for k in range(seed * count, (seed + 1) * count)]
        counts[f"bad_{name}"] = sum(bool(words) for _, words in said)
        for k, words in said:
            if words:
                print(f"{name} {k}: {words}", file=sys.stderr)
    return counts


if __name__ == "__main__":
    figures.run("R11-jumps", figures.arguments(__doc__ or "", "motions", 10_000, 1_000), work)
