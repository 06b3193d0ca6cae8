"""Proof that a piecewise polynomial keeps its limits at every time: by hulls of control points, not by samples."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np

from mafsil.answer import Answer
from mafsil.arrays import Floats, not_negative, require_kind, whole
from mafsil.model.limits import MEASURED
from mafsil.trajectory.checks.limit_check import Violation, jumps_over, not_checked, worst_of_each
from mafsil.trajectory.motion import ProofStatus
from mafsil.trajectory.motion_limits import Limits, MotionLimits, motion_limits
from mafsil.trajectory.splines.bspline import BSpline
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.tolerances import GIVEN

QUANTITIES = ("position", "velocity", "acceleration", "jerk")


@dataclass(frozen=True, slots=True, repr=False)
class LimitProof(Answer, data="violations in_doubt halvings tolerance unchecked", entries="violations"):
    """True if it is proven that every limit is kept at every time.

    Attributes:
        violations: values of the motion itself beyond a limit, one for each limit that is exceeded.
        in_doubt: pieces whose hulls still reach beyond a limit after all halvings, while no value does.
        halvings: how often doubtful pieces were halved; -1 if the control points as they are were enough.
        tolerance: a limit is kept if it is exceeded by no more than this, relative to max(1, limit).
        unchecked: what no limit was given of, such as the jerk.
    """

    violations: tuple[Violation, ...]
    in_doubt: int
    halvings: int
    tolerance: float
    unchecked: tuple[str, ...] = ()

    @property
    def status(self) -> ProofStatus:
        """PROVEN, EXCEEDED, or IN_DOUBT."""
        if self.violations:
            return ProofStatus.EXCEEDED
        return ProofStatus.IN_DOUBT if self.in_doubt else ProofStatus.PROVEN

    def explain(self, language: str | None = None) -> str:
        """What is proven, or where a limit is exceeded, or how much is in doubt."""
        if self.violations:
            return "\n".join(violation.explain(language) for violation in self.violations)
        sentence = self.status.sentence(
            language, in_doubt=self.in_doubt, halvings=max(self.halvings, 0), tolerance=self.tolerance
        )
        return sentence + not_checked(self.unchecked, language)


def prove(
    trajectory: BSpline | PiecewisePolynomial,
    limits: Limits,
    names: tuple[str, ...] = (),
    *,
    halvings: int = 40,
    tolerance: float = GIVEN,
    ends: bool = True,
) -> LimitProof:
    """Whether position, velocity, acceleration and jerk keep their limits at every time, both sides.

    1. Control points of a B-spline and of its derivatives: the motion stays in their hull.
    2. Knots inserted until each piece has a hull of its own: its Bernstein coefficients.
    3. Pieces that are in doubt are halved; the ends of each are values of the motion, and convict it.

    Jumps between the pieces are looked for first: a finite limit of derivative k asks that all below it are continuous.

    Args:
        trajectory: without batch dimensions; what else is made of polynomials by its `to_polynomial()`.
        limits: of the coordinates, or a robot's.
        names: (n,) of the coordinates, for the sentences.
        halvings: most of them; each halves the length of what is in doubt.
        tolerance: excess that is allowed, relative to max(1, limit).
        ends: whether jumps from rest at the start and into rest at the end count; False for a part of a longer motion.

    Raises:
        InputError: no B-spline or piecewise polynomial, limits of another number of coordinates.
    """
    tolerance = not_negative("tolerance", tolerance)
    require_kind("trajectory", trajectory, "BSpline or PiecewisePolynomial", "scale_time", "n", "breaks")
    bounds = motion_limits(limits, trajectory.n)
    most = whole("halvings", halvings, 0, 200)
    labels = names or tuple(str(k) for k in range(trajectory.n))
    leaps = jumps_over(trajectory, bounds, labels, ends=ends)
    if leaps:
        return LimitProof(worst_of_each([(abs(leap.jump), leap) for leap in leaps]), 0, -1, tolerance)
    # 1
    if isinstance(trajectory, BSpline) and _hull_keeps(trajectory, bounds, tolerance):
        return LimitProof((), 0, -1, tolerance, bounds.unbounded)
    # 2
    require_kind("trajectory", trajectory, "BSpline or PiecewisePolynomial", "derivative")
    pieces = trajectory.to_polynomial() if isinstance(trajectory, BSpline) else trajectory
    violations: list[Violation] = []
    doubtful = used = 0
    for order, quantity in enumerate(QUANTITIES):
        sides: Floats = getattr(bounds, quantity)
        for joint in np.flatnonzero(np.isfinite(sides).any(axis=0)).tolist():
            low, high = (float(side) for side in sides[:, joint])
            found = _decide(
                _bernstein(pieces, order, joint), pieces.knots, (low, high), most, MEASURED if order == 0 else tolerance
            )
            used = max(used, found.halvings)
            doubtful += found.left
            if found.value is not None:
                limit = high if found.value > high else low
                name = quantity if order else "upper" if found.value > high else "lower"
                violations.append(Violation(labels[joint], name, found.time, found.value, limit))
    return LimitProof(tuple(violations), doubtful, used, tolerance, bounds.unbounded)


@dataclass(frozen=True, slots=True)
class _Decision:
    """What is known of one coordinate's derivative: a value beyond, how many pieces are left in doubt."""

    value: float | None
    time: float
    left: int
    halvings: int


def _decide(hulls: Floats, knots: Floats, sides: tuple[float, float], most: int, allowed: float) -> _Decision:
    """3. Halve what is in doubt.

    Args:
        hulls: (pieces, degree + 1) Bernstein coefficients.
        knots: (pieces + 1,) [s].
        sides: lower and upper bound.
        most: halvings.
        allowed: excess, relative to max(1, limit).
    """
    low, high = sides[0] - allowed * max(1.0, abs(sides[0])), sides[1] + allowed * max(1.0, abs(sides[1]))
    begin, length = knots[:-1], np.diff(knots)
    for count in range(most + 1):
        ends = hulls[:, [0, -1]]
        excess = np.maximum(ends - high, low - ends)
        if excess.size and excess.max() > 0.0:
            k, side = np.unravel_index(int(excess.argmax()), excess.shape)
            return _Decision(float(ends[k, side]), float(begin[k] + side * length[k]), 0, count)
        doubt = (hulls.max(axis=1) > high) | (hulls.min(axis=1) < low)
        hulls, begin, length = hulls[doubt], begin[doubt], length[doubt]
        if not len(hulls) or count == most:
            return _Decision(None, 0.0, len(hulls), count)
        left, right = _halves(hulls)
        hulls = np.concatenate([left, right])
        begin, length = np.concatenate([begin, begin + length / 2]), np.tile(length / 2, 2)
    return _Decision(None, 0.0, len(hulls), most)


def _hull_keeps(spline: BSpline, bounds: MotionLimits, tolerance: float) -> bool:
    """1. Whether all control points of all derivatives lie within the limits."""
    for order, quantity in enumerate(QUANTITIES):
        low, high = getattr(bounds, quantity)
        least, most = spline.hull(order)
        allowed = MEASURED if order == 0 else tolerance
        if (most > high + allowed * np.maximum(1.0, np.abs(high))).any():
            return False
        if (least < low - allowed * np.maximum(1.0, np.abs(low))).any():
            return False
    return True


def _bernstein(pieces: PiecewisePolynomial, order: int, joint: int) -> Floats:
    """(pieces, degree + 1) coefficients of a derivative over each piece: b_j = sum_i C(j, i)/C(p, i) a_i h^i."""
    h = np.diff(pieces.knots)
    a: Floats = pieces.coefficients[:, :, joint]
    p = pieces.degree
    for _ in range(order):
        factors: Floats = np.arange(1, p + 1, dtype=np.float64)
        a = a[:, 1:] * factors if p else 0.0 * a
        p = max(p - 1, 0)
    change = np.array([[comb(j, i) / comb(p, i) if i <= j else 0.0 for i in range(p + 1)] for j in range(p + 1)])
    return (a * np.power(h[:, None], np.arange(p + 1.0))) @ change.T


def _halves(hulls: Floats) -> tuple[Floats, Floats]:
    """Bernstein coefficients of both halves, by de Casteljau."""
    left, right, row = np.empty_like(hulls), np.empty_like(hulls), hulls
    for k in range(hulls.shape[1]):
        left[:, k], right[:, hulls.shape[1] - 1 - k] = row[:, 0], row[:, -1]
        row = (row[:, :-1] + row[:, 1:]) / 2
    return left, right
