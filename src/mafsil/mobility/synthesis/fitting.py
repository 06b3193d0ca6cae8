"""Least squares on the coupler curve: four-bars whose coupler point passes many points as nearly as possible.

Unknowns of size one: A (2), ground D - A (2), lengths of crank, coupler and rocker, the point on the coupler (2), then
the angle of the crank at each point, or one angle by which all given ones are shifted. The coupler's angle psi closes
|K + b e^(i psi)| = c with K = a e^(i theta) - (D - A); its derivatives follow from that equation.

Linkages of a synthesis as batches of positions: pivots in every pose, and where the coupler's frame sits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from mafsil.arrays import Booleans, Floats, Integers
from mafsil.mobility.synthesis.assessment import Assessment, assess_four_bars, assess_slider_cranks
from mafsil.mobility.synthesis.dyads import Complexes, Dyad, as_complex, as_points, spread
from mafsil.mobility.tolerances import NO_LENGTH
from mafsil.solvers.least_squares import levenberg_marquardt

ITERATIONS = 200
"""Most steps from one start: those that approach a minimum take some dozens."""
SAME_FIT = 1e-6
"""Fits whose unknowns agree so far are one minimum, reached from several starts."""


@dataclass(frozen=True, eq=False)
class CouplerFit:
    """The equations of one fit.

    Attributes:
        z: (N,) points of size one.
        timing: (N,) angles of the crank from any line, or None [rad].
        side: +1 or -1: on which side of the line from D to B the coupler lies.
    """

    z: Complexes
    timing: Floats | None
    side: float

    def crank_angles(self, x: Floats) -> Floats:
        """(N,) from the unknowns."""
        return x[9:] if self.timing is None else self.timing + x[9]

    def coupler_angles(self, x: Floats) -> Floats:
        """(N,) psi; NaN where the linkage does not close."""
        K = x[4] * np.exp(1j * self.crank_angles(x)) - complex(x[2], x[3])
        length = np.abs(K)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.angle(K) + self.side * np.arccos((x[6] ** 2 - length**2 - x[5] ** 2) / (2 * x[5] * length))

    def __call__(self, x: Floats) -> tuple[Floats, Floats]:
        """Distances from the points (2 N,) and their derivatives (2 N, n)."""
        theta, psi = self.crank_angles(x), self.coupler_angles(x)
        e, u, count = np.exp(1j * theta), np.exp(1j * psi), len(theta)
        arm = complex(x[7], x[8])
        error = complex(x[0], x[1]) + x[4] * e + arm * u - self.z
        C = x[4] * e - complex(x[2], x[3]) + x[5] * u
        dK = np.zeros((count, len(x)), dtype=np.complex128)  # of K + b u at fixed psi
        dK[:, 2], dK[:, 3], dK[:, 4], dK[:, 5] = -1.0, -1.0j, e, u
        fixed = np.zeros_like(dK)  # of the point at fixed psi
        fixed[:, 0], fixed[:, 1], fixed[:, 4], fixed[:, 7], fixed[:, 8] = 1.0, 1.0j, e, u, 1j * u
        by_angle = 1j * x[4] * e
        if self.timing is None:
            dK[np.arange(count), 9 + np.arange(count)] = by_angle
            fixed[np.arange(count), 9 + np.arange(count)] = by_angle
        else:
            dK[:, 9] = fixed[:, 9] = by_angle
        closing = -(np.conj(C)[:, None] * dK).real
        closing[:, 6] += x[6]
        with np.errstate(invalid="ignore", divide="ignore"):
            d_psi = closing / (np.conj(C) * 1j * x[5] * u).real[:, None]
        J = fixed + (1j * arm * u)[:, None] * d_psi
        return np.concatenate([error.real, error.imag]), np.concatenate([J.real, J.imag])


def fit_four_bars(z: Complexes, timing: Floats | None, starts: Sequence[Positions]) -> Positions:
    """Four-bars fitted to points from starts, each minimum once.

    Args:
        z: (N,) points [m].
        timing: (N,) angles of the crank, or None [rad].
        starts: batches of one four-bar each, in any number of positions.
    """
    middle, size = complex(z.mean()), float(spread(z))
    unit = (z - middle) / size
    seen, parts = list[Floats](), list[Positions]()
    for start in starts:
        for fit, x in _first_guesses(unit, timing, start, middle, size):
            found = levenberg_marquardt(fit, x, tolerance=1e-12, iterations=ITERATIONS)
            if not np.isfinite(found.residual) or not np.isfinite(fit.coupler_angles(found.value)).all():
                continue
            key = np.append(np.abs(found.value[4:7]), found.value[:4])
            if any(np.abs(key - other).max() <= SAME_FIT * (1 + np.abs(key).max()) for other in seen):
                continue
            seen.append(key)
            parts.append(_positions(fit, found.value, middle, size))
    return _join(parts, len(z))


def _first_guesses(
    unit: Complexes, timing: Floats | None, start: Positions, middle: complex, size: float
) -> list[tuple[CouplerFit, Floats]]:
    """Equations and unknowns for a start; none if it does not close at all points.

    Args:
        unit: (N,) points of size one.
        timing: (N,) angles of the crank, or None.
        start: one four-bar.
        middle, size: of the points [m].
    """
    A, D, B, C = (complex(start.A[0]), complex(start.D[0]), start.B[0], start.C[0])
    a, b, c = (float(np.abs(link).mean()) / size for link in (B - A, C - B, D - C))
    base = [((A - middle) / size).real, ((A - middle) / size).imag, (D - A).real / size, (D - A).imag / size, a, b, c]
    base += (start.frame[0, :2] / size).tolist()
    K, u = B[0] - D, C[0] - B[0]
    side = 1.0 if (np.conj(K) * u).imag >= 0 else -1.0
    if timing is not None:
        shift = float(np.angle(B[0] - A)) - float(timing[0])
        guess = CouplerFit(unit, timing, side), np.array([*base, shift])
        return [guess] if np.isfinite(guess[0].coupler_angles(guess[1])).all() else []
    around = np.linspace(-np.pi, np.pi, 181)
    x = np.array([*base, *around])
    fit = CouplerFit(around.astype(np.complex128), None, side)
    curve = complex(x[0], x[1]) + x[4] * np.exp(1j * around) + complex(x[7], x[8]) * np.exp(1j * fit.coupler_angles(x))
    if not np.isfinite(curve).any():
        return []
    far = np.nan_to_num(np.abs(curve[None] - unit[:, None]), nan=np.inf)
    nearest = around[far.argmin(axis=1)]
    return [(CouplerFit(unit, None, side), np.array([*base, *nearest]))]


def _positions(fit: CouplerFit, x: Floats, middle: complex, size: float) -> Positions:
    """The fitted linkage at the points, in the world."""
    theta, psi = fit.crank_angles(x), fit.coupler_angles(x)
    A, ground = complex(x[0], x[1]), complex(x[2], x[3])
    B = A + x[4] * np.exp(1j * theta)
    C = B + x[5] * np.exp(1j * psi)
    miss = np.abs(B + complex(x[7], x[8]) * np.exp(1j * psi) - fit.z).max() * size
    frame = np.array([[x[7] * size, x[8] * size, 0.0]]) * np.sign(x[5])
    pivots = np.asarray(middle + size * np.array([A, A + ground]), dtype=np.complex128)
    return Positions(
        pivots[:1], middle + size * B[None], middle + size * C[None], pivots[1:], frame, misses=np.array([miss])
    )


def _join(parts: Sequence[Positions], count: int) -> Positions:
    """Batches of one four-bar each as one batch in `count` positions."""
    if not parts:
        none, empty = np.zeros(0, dtype=np.complex128), np.zeros((0, count), dtype=np.complex128)
        return Positions(none, empty, empty, none, np.zeros((0, 3)), misses=np.zeros(0))
    misses = np.concatenate([part.misses for part in parts if part.misses is not None])
    A, D = (np.concatenate([getattr(part, name) for part in parts]) for name in ("A", "D"))
    B, C = (np.concatenate([getattr(part, name) for part in parts]) for name in ("B", "C"))
    return Positions(A, B, C, D, np.concatenate([part.frame for part in parts]), misses=misses)


@dataclass(frozen=True, eq=False)
class Positions:
    """k linkages of one kind in N positions.

    Attributes:
        A: (k,) fixed pivots of the cranks.
        B, C: (k, N) moving pivots, or crank pins and blocks.
        D: (k,) fixed pivots of the rockers; of slider-cranks the directions of the lines.
        frame: (k, 3) the coupler's frame from B: along B -> C, across it to the left [m], and its angle from it [rad].
        slider: whether they are slider-cranks.
        misses: (k,) how far the farthest position is from what was asked [m | rad]; None if all are met exactly.
    """

    A: Complexes
    B: Complexes
    C: Complexes
    D: Complexes
    frame: Floats
    slider: bool = False
    misses: Floats | None = None

    def __len__(self) -> int:
        return len(self.A)

    @property
    def fixed_pivots(self) -> list[Floats]:
        """(k, 2) for each: of crank and rocker, of slider-cranks of the crank alone [m]."""
        return [as_points(self.A)] if self.slider else [as_points(self.A), as_points(self.D)]

    def chosen(self, which: Booleans | Integers) -> Positions:
        """Some of them."""
        return Positions(
            self.A[which], self.B[which], self.C[which], self.D[which], self.frame[which], self.slider,
            None if self.misses is None else self.misses[which],
        )  # fmt: skip

    def triples(self) -> int:
        """Number of cognate triples that the linkages stand in: a triple has one triangle of fixed pivots."""
        ratio = (self.frame[:, 0] + 1j * self.frame[:, 1]) / np.abs(self.C - self.B).mean(axis=1)
        corners = np.sort_complex(np.stack([self.A, self.D, self.A + ratio * (self.D - self.A)], axis=1))
        seen = list[Complexes]()
        for each in corners:
            if all(np.abs(each - other).max() > SAME_FIT * np.abs(each - each.mean()).max() for other in seen):
                seen.append(each)
        return len(seen)

    def assess(self) -> Assessment:
        """Their defects."""
        assess = assess_slider_cranks if self.slider else assess_four_bars
        return assess(self.A, self.B, self.C, self.D)

    def driven_from_the_other_side(self) -> Positions:
        """The same four-bars with the rocker as crank."""
        length = np.abs(self.C - self.B).mean(axis=1)
        frame = np.stack([length - self.frame[:, 0], -self.frame[:, 1], self.frame[:, 2] - np.pi], axis=1)
        return Positions(self.D, self.C, self.B, self.A, frame)

    def built(self, size: float) -> Positions:
        """Those all of whose links have a length, for a task of a size [m]."""
        if not len(self):
            return self
        least = NO_LENGTH * size
        links = [np.abs(self.B - self.A[:, None]).min(axis=1), np.abs(self.C - self.B).min(axis=1)]
        if not self.slider:
            links += [np.abs(self.D - self.A), np.abs(self.C - self.D[:, None]).min(axis=1)]
        return self.chosen(np.asarray((np.stack(links) > least).all(axis=0), dtype=np.bool_))


def four_bars_of(first: Sequence[Dyad], second: Sequence[Dyad] | None = None) -> Positions:
    """Four-bars of cranks.

    Args:
        first: cranks.
        second: what each of them is paired with; if None, all pairs of the first.
    """
    if second is None:
        pairs = list(combinations(range(len(first)), 2))
        second = first
    else:
        pairs = list(product(range(len(first)), range(len(second))))
    return _pair(first, second, pairs, slider=False)


def slider_cranks_of(cranks: Sequence[Dyad], blocks: Sequence[Dyad]) -> Positions:
    """Slider-cranks of each crank with each block."""
    return _pair(cranks, blocks, list(product(range(len(cranks)), range(len(blocks)))), slider=True)


def _pair(first: Sequence[Dyad], second: Sequence[Dyad], pairs: list[tuple[int, int]], *, slider: bool) -> Positions:
    i, j = np.array(pairs, dtype=int).reshape(-1, 2).T
    N = max((len(one.places) for one in (*first, *second)), default=0)
    left, right = (np.array([one.places for one in side]).reshape(len(side), N, 2) for side in (first, second))
    m, n = (as_complex(np.array([one.pivot for one in side]).reshape(-1, 2)) for side in (first, second))
    v, w = (as_complex(np.array([one.point for one in side]).reshape(-1, 2)) for side in (first, second))
    rod = w[j] - v[i]
    with np.errstate(divide="ignore", invalid="ignore"):
        u = rod / np.abs(rod)
    origin = -v[i] * np.conj(u)
    frame = np.stack([origin.real, origin.imag, -np.angle(u)], axis=1)
    D = 1j * n[j] if slider else n[j]
    return Positions(m[i], as_complex(left[i]), as_complex(right[j]), D, frame, slider)
