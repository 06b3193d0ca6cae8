"""Least squares on the coupler curve: four-bars whose coupler point passes many points as nearly as possible.

Unknowns of size one: A (2), ground D - A (2), lengths of crank, coupler and rocker, the point on the coupler (2), then
the angle of the crank at each point, or one angle by which all given ones are shifted. The coupler's angle psi closes
|K + b e^(i psi)| = c with K = a e^(i theta) - (D - A); its derivatives follow from that equation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.mobility.synthesis.poses import Complexes, spread
from mafsil.mobility.synthesis.positions import Positions
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
