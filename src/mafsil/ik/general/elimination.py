"""Elimination for whole batches: the determinant of every pose sampled on the circle of one joint, and its zeros.

Each road (see `roads`) gives a polynomial for every pose. Where samples differ too much in size for their zeros to be
isolated, the circle is sampled again on a projective image of it that makes them more alike.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.geometry import pose
from mafsil.ik.chain import Chain
from mafsil.ik.general.findings import Findings
from mafsil.ik.general.roads import TWIST, Road, roads

CHOICES: tuple[tuple[float, int, float], ...] = (
    (0.0, 0, 1e-4), (0.0, 1, np.inf), (0.0, -1, 1e-9), (0.7, 0, 1e-9), (1.2, 0, 1e-9),
)  # fmt: skip
"""How a zero is tried: turn of the half angle of joint d, null vector, and rank beyond which a solution is enough.

Where zeros almost coincide the rank is small: each may lead to two solutions.
"""

CLEAN = 1e-12
"""Coefficients that must be zero, relative to the others, beyond which rounding is measured: it also stays within."""

ROUNDING = 2.0**-52

DISTURBANCE = 1e-10
"""Of the equations, relative, by which the effect of rounding is measured."""

NOISE: Floats = np.cos(np.arange(162.0) ** 2).reshape(6, 27)
"""Directions of that disturbance, as good as random."""


class Elimination:
    """All roads of one arm; what does not depend on the pose is computed once.

    Attributes:
        roads: of the chain.
        slides: (6,) which joints slide.
        degree: of the determinant as a trigonometric polynomial: eight if all six joints turn.
    """

    def __init__(self, chain: Chain) -> None:
        self.roads = roads(chain)
        self.slides = np.array(chain.slides, dtype=np.bool_)
        self.degree = 12 if self.slides.any() else 8
        self._fourier = fourier_rows(self.degree)
        nodes = len(self._fourier)
        self._angles = 2 * np.pi / nodes * np.arange(nodes)
        self._cosines, self._sines = np.cos(self._angles)[None], np.sin(self._angles)[None]

    def __len__(self) -> int:
        return len(self.roads)

    def take(self, road: int, found: Findings, rows: NDArray[np.int64]) -> None:
        """What one road finds for some poses of a batch.

        Args:
            road: its number.
            found: is filled.
            rows: (k,) the poses.
        """
        one, P = self.roads[road], found.P[rows]
        systems = _Systems(one, pose.inverse(P) if one.backwards else P)
        f = systems.samples(self._cosines, self._sines)
        coefficients, dust = self._harmonics(f)
        rough = np.flatnonzero(dust > CLEAN * np.abs(coefficients).sum(axis=(1, 2)))
        if len(rough):
            dust[rough] += self._rounding(systems.chosen(rough), self._cosines, self._sines, f[rough])
        zeros, number, certain = self._zeros(coefficients, dust)
        # Without a proof the image is better, except that no zero at all may be all there is.
        good = np.flatnonzero(certain | (number == 0))
        self._explored(systems, found, rows, good, (zeros[good], number[good], certain[good]))
        rest = np.flatnonzero(~found.proof[rows])
        if len(rest):
            self._explored(systems, found, rows, rest, self._image(systems.chosen(rest), f[rest]))

    def _explored(
        self,
        systems: _Systems,
        found: Findings,
        rows: NDArray[np.int64],
        some: NDArray[np.intp],
        zeros: tuple[Floats, NDArray[np.int64], NDArray[np.bool_]],
    ) -> None:
        """Zeros of some of the rows."""

        def candidates(row: NDArray[np.int64], zero: Floats, choice: int) -> tuple[JointVector, NDArray[np.bool_]]:
            turn, pick, enough = CHOICES[choice]
            q, rank = systems.candidates(some[row], zero, turn, pick, self.slides)
            return q, rank > enough

        joints = systems.road.joints
        found.explored(rows[some], zeros, candidates, len(CHOICES), joints[2], joints[5])

    def _image(self, systems: _Systems, f: Floats) -> tuple[Floats, NDArray[np.int64], NDArray[np.bool_]]:
        """Zeros found on the projective image of the circle on which samples f (k, nodes) are most alike.

        On the image f(t) is multiplied by r^(2 degree), r^2 = |(m c, s / m)|^2 with the half angle (c, s) of the image
        and the squeeze m: the first harmonic of log r^(2 degree) is made opposite to that of log |f|.
        """
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            level = np.log(np.abs(f) / np.abs(f).max(axis=1, keepdims=True) + 1e-16)
            x, y = (level * self._cosines).sum(axis=1), (level * self._sines).sum(axis=1)
            depth = np.minimum(0.85, np.hypot(x, y) / (f.shape[1] * self.degree))
            centre, squeeze = np.arctan2(-y, -x)[:, None], np.sqrt((1 + depth) / (1 - depth))[:, None]
            c, s = squeeze * np.cos(0.5 * self._angles), np.sin(0.5 * self._angles) / squeeze
            theta, weights = centre + 2 * np.arctan2(s, c), (c * c + s * s) ** self.degree
            cosines, sines = np.cos(theta), np.sin(theta)
            even = systems.samples(cosines, sines) * weights
            coefficients, dust = self._harmonics(even)
            dust += self._rounding(systems, cosines, sines, even, weights)
            zeros, number, certain = self._zeros(coefficients, dust)
            back = centre + 2 * np.arctan2(np.sin(0.5 * zeros) / squeeze, squeeze * np.cos(0.5 * zeros))
        return back, number, certain

    def _rounding(
        self, systems: _Systems, cosines: Floats, sines: Floats, f: Floats, weights: Floats | float = 1.0
    ) -> Floats:
        """(k,) what rounding in the equations does to the coefficients, measured by a larger disturbance."""
        changed = systems.disturbed().samples(cosines, sines) * weights - f
        change = np.abs(self._harmonics(changed)[0]).sum(axis=(1, 2))
        return 0.5 * ROUNDING / DISTURBANCE * (1 + systems.condition()) * change

    def _harmonics(self, f: Floats) -> tuple[Floats, Floats]:
        from mafsil.ik.general.elimination_loops import harmonics_of

        out, dust = np.empty((len(f), 2, self.degree + 1)), np.empty(len(f))
        harmonics_of(f, self._fourier, self.degree, out, dust)
        return out, dust

    @staticmethod
    def _zeros(coefficients: Floats, dust: Floats) -> tuple[Floats, NDArray[np.int64], NDArray[np.bool_]]:
        from mafsil.ik.general.circle_loops import zeros_of

        return zeros_of(coefficients, dust)


class _Systems:
    """The equations of one road for many poses."""

    def __init__(self, road: Road, P: PoseMatrix) -> None:
        from mafsil.ik.general.elimination_loops import eliminated

        k = len(P)
        self.road = road
        self.C, self.beta, self.A = np.empty((k, 14, 9)), np.empty((k, 16)), np.empty((k, 6, 27))
        eliminated(
            P, road.before, road.lines, road.after, road.products, road.left, road.unit, self.C, self.beta, self.A
        )

    def chosen(self, rows: NDArray[np.intp]) -> _Systems:
        """Those of some poses."""
        some = object.__new__(_Systems)
        some.road, some.C, some.beta, some.A = self.road, self.C[rows], self.beta[rows], self.A[rows]
        return some

    def disturbed(self) -> _Systems:
        """With equations that are a little wrong."""
        some = object.__new__(_Systems)
        some.road, some.C, some.beta = self.road, self.C, self.beta
        some.A = self.A + DISTURBANCE * np.abs(self.A).max(axis=2, keepdims=True) * NOISE
        return some

    def condition(self) -> Floats:
        """(k,) of the systems of a and b, roughly."""
        pivots = np.abs(self.beta[:, 8:])
        return pivots.max(axis=1) / (pivots.min(axis=1) + 1e-300)

    def samples(self, cosines: Floats, sines: Floats) -> Floats:
        """(k, nodes) determinants."""
        from mafsil.ik.general.elimination_loops import determinants

        f = np.empty((len(self.A), cosines.shape[1]))
        determinants(self.A, cosines, sines, f)
        return f

    def candidates(
        self, rows: NDArray[np.int64], zeros: Floats, turn: float, pick: int, slides: NDArray[np.bool_]
    ) -> tuple[JointVector, Floats]:
        """(m, 6) candidates of zeros, and how well they are determined (m,)."""
        from mafsil.ik.general.candidate_loops import candidates

        q, rank = np.zeros((len(rows), 6)), np.empty(len(rows))
        joints = np.array(self.road.joints)
        candidates(joints, slides, TWIST, turn, pick, rows, zeros, self.A, self.C, self.beta, self.road.left, q, rank)
        return q, rank


def fourier_rows(degree: int) -> Floats:
    """(nodes, nodes) from samples to coefficients, rows a_0, b_1, a_1, b_2, a_2, ...; the last rows must give zero.

    Args:
        degree: of the trigonometric polynomial.
    """
    nodes = 4 * (2 * degree // 4 + 1)
    angle = 2 * np.pi * np.arange(nodes) / nodes
    rows = [np.ones(nodes) / nodes]
    for k in range(1, nodes // 2):
        rows.extend([2 * np.sin(k * angle) / nodes, 2 * np.cos(k * angle) / nodes])
    rows.append(np.cos(nodes // 2 * angle) / nodes)
    return np.array(rows)
