"""The configurations of a four-bar as a curve of (theta, phi): output angles, and the points where branches cross.

Crank L1 at theta from the origin, rocker L3 at phi from (L4, 0), their ends L2 apart:
alpha cos phi + beta sin phi = gamma. Where all links lie on one line, e1 L1 + e2 L2 = L4 + e3 L3, the curve is
singular; the determinant of the curvature there is - e1 e2 e3 L1 L2 L3 L4: two branches cross if it is negative, the
point is all there is if it is positive.

Reference: Lynch & Park, Modern Robotics, sec. 7.3 (input-output equation).

Three or more equal parallel cranks on one platform: movable although the count says it is not.

Coordinates: the angle of each crank and the angle psi of the platform; pivots on the ground and on the platform on the
x axis at the same places. Closure of crank i with the first: c_i + e(a_i) r = e(a_1) r + R(psi) c_i.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Booleans, Floats, as_batch, frozen, positive, real_array, require_kind, single
from mafsil.errors import InputError
from mafsil.mobility.four_bar import FourBar
from mafsil.mobility.spaces.planar_positions import finite_numbers, wrap_angle
from mafsil.mobility.tolerances import TOUCHING, TYPED
from mafsil.parallel.loop_singularity import LoopSingularities, loop_singularities


@dataclass(frozen=True, eq=False)
class FourBarPoint:
    """A configuration of a four-bar with all links on one line.

    Attributes:
        theta, phi: absolute angles of crank and rocker, 0 or pi [rad].
        curvature: (2, 2) second derivatives of (|tip - tip|^2 - L2^2) / 2 by theta and phi [m^2].
    """

    theta: float
    phi: float
    curvature: Floats

    @property
    def isolated(self) -> bool:
        """Whether the linkage cannot move from here; otherwise two branches cross."""
        return float(np.linalg.det(self.curvature)) > 0

    @property
    def slopes(self) -> Floats:
        """(2,) dphi/dtheta of the branches, ascending, infinite where theta stands; empty if isolated."""
        if self.isolated:
            return np.zeros(0)
        (a, b), (_, c) = self.curvature.tolist()
        root = float(np.sqrt(b * b - a * c))
        # The larger of -b + root and -b - root is exact; the other follows from the product of both slopes, a / c.
        large = -b - np.copysign(root, b)
        if abs(c) <= TYPED * max(abs(a), abs(b)):
            return np.array([-a / (2 * b), np.inf])
        return np.sort(np.array([large / c, a / large if large else 0.0]))


class OutputAngles(NamedTuple):
    """Angles of the rocker of a four-bar.

    Attributes:
        phi: (*batch, 2) both angles, in (-pi, pi]; where it does not close twice the one that comes nearest [rad].
        every: (*batch,) whether any angle will do; two opposite ones are given.
        missing: (*batch,) length by which the coupler is too short or too long; zero where it closes [m].
    """

    phi: Floats
    every: Booleans
    missing: Floats


def output_angles(linkage: FourBar, theta: ArrayLike) -> OutputAngles:
    """Both angles of the rocker for angles of the crank, where any angle will do, and where none does.

    Args:
        linkage: its lengths.
        theta: (*batch,) angles of the crank [rad].

    Returns:
        The angles, the coupler's end to the left of the line from crank pin to ground pivot first.
    """
    require_kind("linkage", linkage, "FourBar", "lengths", "grashof")
    angle = finite_numbers("theta", theta)
    L1, L2, L3, L4 = linkage.lengths.tolist()
    alpha, beta = 2 * L3 * (L4 - L1 * np.cos(angle)), -2 * L1 * L3 * np.sin(angle)
    d2: Floats = (L1 - L4) ** 2 + 4 * L1 * L4 * np.sin(angle / 2) ** 2
    gamma: Floats = (L2 - L3) * (L2 + L3) - d2
    reach: Floats = 2 * L3 * np.sqrt(d2)
    small = TOUCHING * float(linkage.lengths.max()) ** 2
    every = (reach <= small) & (np.abs(gamma) <= small)
    ratio: Floats = np.where(reach > 0.0, gamma / np.where(reach > 0.0, reach, 1.0), np.copysign(np.inf, gamma))
    closes = every | (np.abs(ratio) - 1 < TOUCHING)
    half = np.where(every, np.pi / 2, np.arccos(np.clip(ratio, -1.0, 1.0)))
    middle = np.where(every, np.pi / 2, np.arctan2(beta, alpha))
    way = np.sqrt(d2)
    missing = np.where(closes, 0.0, np.maximum(way - (L2 + L3), np.maximum(np.abs(way - L3) - L2, L2 - (way + L3))))
    phi = wrap_angle(np.stack([middle + half, middle - half], axis=-1))
    return OutputAngles(phi, np.asarray(every, dtype=np.bool_), np.maximum(missing, 0.0))


def singular_points(linkage: FourBar) -> tuple[FourBarPoint, ...]:
    """All configurations with every link on one line: where the curve crosses itself or is a point."""
    require_kind("linkage", linkage, "FourBar", "lengths", "grashof")
    L1, L2, L3, L4 = linkage.lengths.tolist()
    found: list[FourBarPoint] = []
    for e1, e2, e3 in product((1.0, -1.0), repeat=3):
        if abs(e1 * L1 + e2 * L2 - L4 - e3 * L3) <= TYPED * max(linkage.lengths):
            cross = -e1 * e3 * L1 * L3
            H = np.array([[L1 * L4 * e1 - cross, cross], [cross, -L3 * L4 * e3 - cross]])
            found.append(FourBarPoint(0.0 if e1 > 0 else np.pi, 0.0 if e3 > 0 else np.pi, H))
    return tuple(sorted(found, key=lambda point: (point.theta, point.phi)))


@dataclass(frozen=True, eq=False)
class ParallelCranks:
    """A platform on equal cranks.

    Attributes:
        length: of the cranks [m].
        pivots: (n,) places along x, the first at 0 [m].
    """

    length: float
    pivots: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "length", positive("length", self.length))
        places = real_array("pivots", self.pivots)
        if places.ndim != 1 or len(places) < 2 or not np.isfinite(places).all() or places[0] != 0:
            raise InputError("parallel.pivots", got=np.asarray(self.pivots).tolist())
        object.__setattr__(self, "pivots", frozen(places))

    def closure(self, q: ArrayLike) -> Floats:
        """(*batch, 2 n - 2) what each crank misses: all x, then all y [m]; q (*batch, n + 1) angles, psi last."""
        a, psi = self._parts(q)
        c = self.pivots[1:]
        x = self.length * (np.cos(a[..., 1:]) - np.cos(a[..., :1])) + c * (1 - np.cos(psi))
        y = self.length * (np.sin(a[..., 1:]) - np.sin(a[..., :1])) - c * np.sin(psi)
        return np.concatenate([x, y], axis=-1)

    def loop_matrix(self, q: ArrayLike) -> Floats:
        """(*batch, 2 n - 2, n + 1) derivatives of the closure."""
        a, psi = self._parts(q)
        n = len(self.pivots)
        H = np.zeros((*a.shape[:-1], 2 * n - 2, n + 1))
        for k, (by_angle, by_psi) in enumerate(((-np.sin(a), np.sin(psi)), (np.cos(a), -np.cos(psi)))):
            rows = slice(k * (n - 1), (k + 1) * (n - 1))
            H[..., rows, 0] = -self.length * by_angle[..., :1]
            H[..., rows, 1:n] = self.length * by_angle[..., 1:, None] * np.eye(n - 1)
            H[..., rows, n] = self.pivots[1:] * by_psi
        return H

    def curvature(self, q: ArrayLike) -> Floats:
        """(*batch, 2 n - 2, n + 1, n + 1) second derivatives of the closure."""
        a, psi = self._parts(q)
        n = len(self.pivots)
        found = np.zeros((*a.shape[:-1], 2 * n - 2, n + 1, n + 1))
        for k, (bend, of_psi) in enumerate(((-np.cos(a), np.cos(psi)), (-np.sin(a), np.sin(psi)))):
            for i in range(1, n):
                row = k * (n - 1) + i - 1
                found[..., row, 0, 0] = -self.length * bend[..., 0]
                found[..., row, i, i] = self.length * bend[..., i]
                found[..., row, n, n] = self.pivots[i] * of_psi[..., 0]
        return found

    def singularity(self, q: ArrayLike, driven: Sequence[int] = (0,)) -> LoopSingularities:
        """What is singular at a configuration (n + 1,): of three cranks or more the rank of the loops is n at most.

        On the parallel motion, psi = 0, one row depends on the others for every crank after the second.
        """
        n = len(self.pivots)
        angles = single("q", q, (n + 1,))
        rank = n if n > 2 else 2
        return loop_singularities(
            self.loop_matrix(angles), self.curvature(angles), driven, full_rank=rank,
            closure=lambda x: (self.closure(x), self.loop_matrix(x)), q=angles,
        )  # fmt: skip

    def _parts(self, q: ArrayLike) -> tuple[Floats, Floats]:
        value = as_batch("q", q, (len(self.pivots) + 1,))
        return value[..., :-1], value[..., -1:]
