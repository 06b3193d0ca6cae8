"""The shortest time along a path when the jerk of its joints is limited, too."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from mafsil.arrays import Floats
from mafsil.lazy_module import lazily
from mafsil.trajectory.motion_limits import MotionLimits, share_of
from mafsil.trajectory.path import JointPath, PathMotion, PathPoint
from mafsil.trajectory.profiles.polynomial import quintic_coefficients
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.timing.sampled_limits import SampledLimit
from mafsil.trajectory.timing.sampled_timing import ALLOWED, GROWTH, MARGIN, MOST_ROUNDS, SETTLED, timed_within
from mafsil.trajectory.timing.timing_problem import TimingProblem, quadratic_basis, smooth_timing, solve_timing
from mafsil.trajectory.tolerances import ROUNDING

if TYPE_CHECKING:
    import mafsil.trajectory.timing.jerk_timing_loops as jerk_timing_loops
else:
    jerk_timing_loops = lazily("mafsil.trajectory.timing.jerk_timing_loops")

PIECES = 200
"""Of the spline along each stretch between stops, and at least this many times the path's own."""
WIDTHS = (1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.06, 0.12, 0.25, 0.5, 1.0)
"""Windows of the first motion, as shares of the duration without limits of jerk."""
GAP = 1e-5
"""Share of the duration by which the result may be above the optimum of its spline."""
INSIDE = 1e-3
"""By how much slower than just within its limits the search begins."""
NEAREST = 0.3
"""Share of a piece within which a knot of the first motion gives way to one of the path."""
NODES = 8
"""Of Gauss and Legendre in each piece of the time."""
TIGHTENED, NEARLY = 4, 1e-4
"""How often limits are tightened where a motion exceeds them between the places; what may be left to stretching."""
SHARES = np.linspace(0.0, 1.0, 9)
"""Of each piece, at which limits are measured that are no polynomials."""
SIMPSON = (1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0)
BISECTIONS = 60
SLOWER, MOST_SLOWER = 0.97, 600
"""How much slower a motion that is not inside the limits is tried, and how often: to a thousandth of its speed."""
NEARLY_STILL, FLOOR = 0.01, 0.05
"""Shares of the even dilation: below the first one the spline is solved again, at least as large as the second."""
NEVER = 1e100
"""A duration beyond which a motion does not move [s]."""


@dataclass(frozen=True, eq=False, slots=True)
class JerkTiming:
    """A motion along a path with limited jerk.

    Attributes:
        motion: the path with its law of time.
        excess: the largest excess over any limit, as share of it.
    """

    motion: PathMotion
    excess: float


def timed_with_jerk(path: JointPath, limits: MotionLimits, sampled: Sequence[SampledLimit]) -> JerkTiming | None:
    """The shortest time from rest to rest; None where a stretch between stops has none.

    1. Stops where direction or curvature jump: no finite jerk passes there. Between them, each stretch for itself:
    2. the timing without limits of jerk, smoothed by the window that suits best, is a first motion;
    3. its time is dilated by a spline, the best by a barrier method within the limits at three places of each piece;
    4. quintics of time through position, velocity and acceleration at the knots;
    5. what is beyond a limit anywhere is stretched uniformly, by some 0.1 %.

    Sampled limits are linearised about the last motion, measured, lowered where exceeded, and 3 to 5 repeated.

    Args:
        path: of n coordinates, with a length.
        limits: of velocity, acceleration and jerk.
        sampled: limits of effort and of the tip.
    """
    stops = np.concatenate([[0.0], path.stops(), [path.end]])
    pieces: list[PiecewisePolynomial] = []
    places: list[Floats] = []
    excess = 0.0
    for begin, end in pairwise(stops):
        part = _Stretch(path.between(float(begin), float(end)), limits, sampled).time_with_jerk()
        if part is None:
            return None
        assert isinstance(part.motion.law, PiecewisePolynomial)
        assert part.motion.places is not None
        pieces.append(part.motion.law)
        places.append(begin + part.motion.places)
        excess = max(excess, part.excess)
    rows = [law.coefficients.copy() for law in pieces]
    for row, begin in zip(rows, stops[:-1], strict=True):
        row[:, 0] += begin
    law = PiecewisePolynomial.from_pieces(np.concatenate([np.diff(law.knots) for law in pieces]), np.concatenate(rows))
    joined = np.concatenate([*(part[:-1] for part in places), stops[-1:]])
    return JerkTiming(PathMotion(path.curve, law, joined), excess)


@dataclass(frozen=True, eq=False, slots=True)
class _Grid:
    """A first motion on the pieces of the spline, seen at begin, middle and end of each.

    Attributes:
        knots: (pieces + 1,) tau.
        s: (pieces + 1,) path parameters there.
        law: (3, 3 pieces) s', s'', s''' of the first motion.
        here: position, slope and curvature of the path.
        first, second, third: (3 pieces, n) derivatives of the first motion of the joints.
    """

    knots: Floats
    s: Floats
    law: Floats
    here: PathPoint
    first: Floats
    second: Floats
    third: Floats


class _Stretch:
    """The shortest time along a path without stops inside.

    Args:
        path: with continuous direction and curvature.
        limits: of its coordinates.
        sampled: of effort and of the tip.
    """

    def __init__(self, path: JointPath, limits: MotionLimits, sampled: Sequence[SampledLimit]) -> None:
        self.path, self.limits, self.sampled = path, limits, sampled
        self.pieces = max(PIECES, 4 * (len(path.breaks()) - 1))
        # Least y that the spline of the dilation may have at its places; 0 while it needs no bound.
        self.floor = 0.0

    def time_with_jerk(self) -> JerkTiming | None:
        """Steps 2 to 5 of `timed_with_jerk`; None where the first motion or a limit at rest fails."""
        # 2.
        grid, slower = self._first_motion()
        if grid is None:
            return None
        basis, h = quadratic_basis(grid.knots), np.diff(grid.knots)
        weight = (h[:, None] * np.array(SIMPSON)).ravel()
        even = (slower * (1.0 + INSIDE)) ** -2
        c = np.full(len(grid.knots) + 1, even)
        slack, tight = [np.full((1, 1), MARGIN)] * len(self.sampled), np.ones((3, len(h)))
        best, found, duration = None, None, np.inf
        for _ in range(MOST_ROUNDS if self.sampled else TIGHTENED):
            # 3.
            linear = self._linear(grid, _at_places(basis, c), slack, np.repeat(tight, 3, axis=1))
            derivatives = grid.first, grid.second, grid.third, self.limits.jerk.copy(), np.repeat(tight[2], 3)
            imposed = jerk_timing_loops.Imposed(basis, weight, *derivatives, *linear)
            if not _slowed_inside(c, imposed):
                return best or found
            jerk_timing_loops.shortest(c, imposed, GAP)
            if _least_between(grid, basis, c) < NEARLY_STILL * even:
                # A spline that is nearly zero somewhere may be below it between places: it is held up, or even.
                c[:] = even
                if self.floor == 0.0:
                    self.floor = FLOOR * even
                    continue
            # 4. and 5.
            motion = _in_time(self.path, grid, basis, c)
            used = self._share_used(motion)
            motion = self._stretch(motion)
            excess = self._excess(motion)
            worst = max((float(part.max()) for part in excess), default=0.0)
            found = JerkTiming(motion, max(worst, 0.0))
            if worst <= ALLOWED and (best is None or motion.duration < best.motion.duration):
                best = found
            settled = abs(motion.duration - duration) <= SETTLED * motion.duration
            if worst <= ALLOWED and (settled if self.sampled else used.max() <= 1.0 + NEARLY):
                break
            duration = motion.duration
            tight = tight / np.maximum(used, 1.0)
            slack = [old + np.maximum(part, 0.0) * 1.1 for old, part in zip(slack, excess, strict=True)]
        return best or found

    def _first_motion(self) -> tuple[_Grid | None, float]:
        """The first motion on its grid, and how many times slower it has to be."""
        n = self.path.n
        velocity, acceleration = self.limits.velocity[None], self.limits.acceleration[None]
        problem = TimingProblem([self.path], velocity, acceleration, np.zeros(1), np.zeros(1), self.pieces)
        timing = timed_within(problem, self.sampled) if self.sampled else solve_timing(problem)[0]
        if timing.stopped >= 0 or not timing.duration < NEVER:
            return None, 1.0
        found: list[tuple[float, _Grid, float]] = []
        for share in WIDTHS:
            base = smooth_timing(timing, share * timing.duration, self.pieces)
            grid = _grid(self.path, base)
            slower = max(
                float(share_of(values.reshape(-1, n), bound).max()) ** (1.0 / order)
                for order, values, bound in (
                    (1, grid.first, self.limits.velocity),
                    (2, grid.second, self.limits.acceleration),
                    (3, grid.third, self.limits.jerk),
                )
            )
            found.append((slower * base.duration, grid, slower))
        _, grid, slower = min(found, key=lambda each: each[0])
        return grid, slower

    def _linear(
        self, grid: _Grid, y: Floats, slack: list[Floats], tight: Floats
    ) -> tuple[Floats, Floats, Floats, Floats]:
        """Factors (places, k) of y and y' and the bounds: of acceleration, of velocity, and of the sampled limits.

        Args:
            grid: of the first motion.
            y: (places,) about which friction is linearised.
            slack: of each sampled limit (pieces, k), or (1, 1), the share of it that is left free.
            tight: (3, places) shares of the limits of velocity and of acceleration that count.
        """
        allowed = tight[1][:, None]
        squares = [grid.second, share_of(grid.first, self.limits.velocity).max(axis=1, keepdims=True) ** 2]
        slopes = [grid.first / 2.0, np.zeros((len(y), 1))]
        lows = [self.limits.acceleration[0] * allowed, np.full((len(y), 1), -np.inf)]
        highs = [self.limits.acceleration[1] * allowed, tight[0][:, None] ** 2]
        rate, growth = grid.law[0][:, None], grid.law[1][:, None]
        if self.floor:
            squares.append(np.full((len(y), 1), -1.0 / self.floor))
            slopes.append(np.zeros((len(y), 1)))
            lows.append(np.full((len(y), 1), -np.inf))
            highs.append(np.full((len(y), 1), -1.0))
        if self.sampled:
            squares.append(1.0 / y[:, None])
            slopes.append(np.zeros((len(y), 1)))
            lows.append(np.full((len(y), 1), -np.inf))
            highs.append(np.full((len(y), 1), GROWTH))
        ends = np.repeat(np.stack([grid.here.slope[::3], grid.here.slope[2::3]]), 3, axis=1)
        for limit, less in zip(self.sampled, slack, strict=True):
            x = grid.law[0] ** 2 * y
            rows = limit.rows(grid.here, x, GROWTH * x, ends)
            squares.append(rows.A * growth + rows.B * rate**2)
            slopes.append(rows.A * rate / 2.0)
            lower = np.repeat(np.broadcast_to(less, (len(y) // 3, rows.A.shape[1])), 3, axis=0) * limit.scale()
            # What has no bound has nothing to be lowered.
            lows.append(rows.low + np.where(np.isfinite(rows.low), lower, 0.0))
            highs.append(rows.high - np.where(np.isfinite(rows.high), lower, 0.0))
        return tuple(np.concatenate(part, axis=1) for part in (squares, slopes, lows, highs))  # pyright: ignore[reportReturnType]

    def _stretch(self, motion: PathMotion) -> PathMotion:
        """Just within the limits of velocity, acceleration and jerk; no faster where others count."""
        factor = motion.stretch_needed(self.limits) * (1.0 + ROUNDING)
        return motion.scale_time(max(factor, 1.0) if self.sampled else factor)

    def _share_used(self, motion: PathMotion) -> Floats:
        """(3, pieces) the largest share of the limits of velocity, acceleration and jerk in each piece."""
        t = _in_pieces(motion)
        here = motion.at(t.ravel())
        pairs = ((here.v, self.limits.velocity), (here.a, self.limits.acceleration))
        shares = [share_of(*pair) for pair in (*pairs, (motion.jerk(t.ravel()), self.limits.jerk))]
        return np.stack([share.reshape(*t.shape, -1).max(axis=(1, 2)) for share in shares])

    def _excess(self, motion: PathMotion) -> list[Floats]:
        """Of each sampled limit (pieces, k) the largest excess in each piece."""
        t = _in_pieces(motion)
        s, rate, growth = motion.law.at(t.ravel())
        here = self.path.at(s[:, 0])
        found = [limit.excess(here, rate[:, 0] ** 2, growth[:, 0]) for limit in self.sampled]
        return [part.reshape(*t.shape, -1).max(axis=1) for part in found]


def _in_pieces(motion: PathMotion) -> Floats:
    """(pieces, SHARES) times in each piece, its end seen from inside."""
    knots = motion.law.breaks()
    return np.minimum(knots[:-1, None] + SHARES * np.diff(knots)[:, None], np.nextafter(knots[1:, None], 0.0))


def _slowed_inside(c: Floats, imposed: jerk_timing_loops.Imposed) -> bool:
    """Whether a motion that is slower everywhere is strictly inside the limits; c becomes its coefficients."""
    for _ in range(MOST_SLOWER):
        if np.isfinite(jerk_timing_loops.barrier(c, imposed, 1.0)):
            return True
        c *= SLOWER
    return False


def _grid(path: JointPath, base: PiecewisePolynomial) -> _Grid:
    """A first motion on pieces that end where the path's or its own do.

    1. When it passes the path's knots, by bisection; its own knots that are next to one of these give way.
    2. Just inside both ends of each piece, and in its middle.
    """
    # 1.
    inner, own = path.breaks()[1:-1], base.knots
    passed = np.searchsorted(base.derivative(own, 0)[1:-1, 0], inner)
    powers = base.coefficients[passed, :, 0].T
    low, high = np.zeros(len(inner)), np.diff(own)[passed]
    for _ in range(BISECTIONS):
        middle = (low + high) / 2.0
        before = np.polynomial.polynomial.polyval(middle, powers, tensor=False) < inner
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    high += own[passed]
    gaps = np.minimum(np.diff(own, prepend=-1.0), np.diff(own, append=base.duration + 1.0))
    apart = np.abs(own[:, None] - high).min(axis=1, initial=np.inf) > NEAREST * gaps
    apart[[0, -1]] = True
    knots = np.concatenate([own[apart], high])
    s = np.concatenate([base.at(own[apart]).u[:, 0], inner])
    order = np.argsort(knots, kind="stable")
    knots, s = knots[order], np.append(s[order][:-1], path.end)
    # 2.
    tau = np.stack([knots[:-1], (knots[:-1] + knots[1:]) / 2.0, np.nextafter(knots[1:], 0.0)], axis=1).ravel()
    place, rate, growth = (part[:, 0] for part in base.at(tau))
    jump = base.jerk(tau)[:, 0]
    place = np.clip(place, np.repeat(s[:-1], 3), np.repeat(np.nextafter(s[1:], 0.0), 3))
    here, third = path.at(place), path.third(place)
    v, a, j = rate[:, None], growth[:, None], jump[:, None]
    return _Grid(
        knots,
        s,
        np.stack([rate, growth, jump]),
        here,
        here.slope * v,
        here.curvature * v**2 + here.slope * a,
        third * v**3 + 3.0 * here.curvature * v * a + here.slope * j,
    )


def _at_places(basis: Floats, c: Floats, order: int = 0) -> Floats:
    """(places,) the spline of the dilation or a derivative of it."""
    local = np.repeat(np.stack([c[:-2], c[1:-1], c[2:]], axis=1), 3, axis=0)
    return np.einsum("pi,pi->p", basis[:, :, order], local)


def _between(grid: _Grid, basis: Floats, c: Floats) -> tuple[Floats, Floats]:
    """(pieces, NODES) the spline of the dilation at the nodes of Gauss, and their weights (NODES,)."""
    y, slope, bend = (_at_places(basis, c, order) for order in range(3))
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    tau = (nodes + 1.0) / 2.0 * np.diff(grid.knots)[:, None]
    return y[::3, None] + slope[::3, None] * tau + bend[::3, None] / 2.0 * tau**2, weights


def _least_between(grid: _Grid, basis: Floats, c: Floats) -> float:
    return float(_between(grid, basis, c)[0].min())


def _in_time(path: JointPath, grid: _Grid, basis: Floats, c: Floats) -> PathMotion:
    """The dilated motion: s(t) in quintics between the knots, whose times come from t = integral of dtau / sqrt(y)."""
    y, slope = (_at_places(basis, c, order) for order in range(2))
    between, weights = _between(grid, basis, c)
    h = np.diff(grid.knots)
    lengths = h / 2.0 * (weights / np.sqrt(between)).sum(axis=1)
    rate, growth = grid.law[0] * np.sqrt(y), grid.law[1] * y + grid.law[0] * slope / 2.0
    ends = (grid.s[:-1], grid.s[1:], rate[::3], rate[2::3], growth[::3], growth[2::3])
    rows = quintic_coefficients(*ends, lengths)
    return PathMotion(path.curve, PiecewisePolynomial.from_pieces(lengths, rows.T[..., None]), grid.s)
