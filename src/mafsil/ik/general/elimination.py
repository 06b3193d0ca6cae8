"""Elimination for whole batches: the determinant of every pose sampled on the circle of one joint, and its zeros.

Each elimination order (see `orders`) gives a polynomial for every pose. Where samples differ too much in size for their
zeros to be isolated, the circle is sampled again on a projective image of it that makes them more alike.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.floating_point import EPS, LEAST_DIVISOR
from mafsil.geometry import pose
from mafsil.ik.chain import Chain
from mafsil.ik.general.elimination_orders import TWIST, EliminationOrder, orders
from mafsil.ik.general.findings import DETERMINED, MATCHED, MOST, Findings, whole
from mafsil.ik.tolerances import CLEAN, DISTURBANCE
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.ik.general.candidate_loops as candidate_loops
    import mafsil.ik.general.circle_loops as circle_loops
    import mafsil.ik.general.elimination_loops as elimination_loops
    import mafsil.ik.general.polish_loops as polish_loops
else:
    candidate_loops = lazily("mafsil.ik.general.candidate_loops")
    circle_loops = lazily("mafsil.ik.general.circle_loops")
    elimination_loops = lazily("mafsil.ik.general.elimination_loops")
    polish_loops = lazily("mafsil.ik.general.polish_loops")

CHOICES: tuple[tuple[float, int, float], ...] = (
    (0.0, 0, 1e-4), (0.0, 1, np.inf), (0.0, -1, 1e-9), (0.7, 0, 1e-9), (1.2, 0, 1e-9),
)  # fmt: skip
"""How a zero is tried: turn of the half angle of joint d, null vector, and rank beyond which a solution is enough.

Where zeros almost coincide the rank is small: each may lead to two solutions.
"""

EMPTY = 1e5
"""Size of coefficients, relative to their rounding, beyond which a polynomial without zeros is believed."""

NOISE: Floats = np.cos(np.arange(162.0) ** 2).reshape(6, 27)
"""Directions of that disturbance, as good as random."""


DIAGONAL: NDArray[np.int64] = np.cumsum(np.arange(1, 9)) - 1
"""Where the triangular factor has its diagonal."""

FIRST: NDArray[np.int64] = np.zeros(MOST, dtype=np.int64)
"""Rows of a batch of one."""

Circle = tuple[Floats, Floats, Floats]
"""Cosines, sines and weights of nodes."""


class Elimination:
    """All elimination orders of one arm; what does not depend on the pose is computed once.

    Attributes:
        orders: of the chain.
        prismatic: (6,) which joints are prismatic.
        degree: of the determinant as a trigonometric polynomial: eight if all six joints turn.
    """

    def __init__(self, chain: Chain) -> None:
        self.orders = orders(chain)
        self.prismatic = np.array(chain.prismatic, dtype=np.bool_)
        self.degree = 12 if self.prismatic.any() else 8
        self._fourier = fourier_columns(self.degree)
        nodes = len(self._fourier)
        self._angles = 2 * np.pi / nodes * np.arange(nodes)
        self._circle = np.cos(self._angles)[None], np.sin(self._angles)[None], np.ones((1, nodes))

    def __len__(self) -> int:
        return len(self.orders)

    def take(self, order: int, found: Findings, rows: NDArray[np.int64]) -> None:
        """What one elimination order finds for some poses of a batch.

        Args:
            order: its number.
            found: is filled.
            rows: (k,) the poses.
        """
        one, P = self.orders[order], found.P if len(rows) == len(found.P) else found.P[rows]
        systems = _Systems(one, pose.inverse(P) if one.backwards else P)
        f, coefficients, size = self._sample(systems, self._circle)
        roundoff = size[:, 0]
        rough = np.flatnonzero(roundoff > CLEAN * size[:, 1])
        if len(rough):
            roundoff[rough] += self._rounding(systems.chosen(rough), self._circle, coefficients[rough])
        zeros, number, certain = self._zeros(coefficients, roundoff)
        self._doubt(systems, number, certain, size[:, 1], roundoff)
        # Without a proof the image is better, except that no zero at all may be all there is.
        vague = np.flatnonzero(~certain & (number > 0))
        if len(vague):
            zeros[vague], number[vague], certain[vague] = self._image(systems.chosen(vague), f[vague])
        self._explore(systems, found, rows, None, (zeros, number, certain))
        again = ~found.proof[rows]
        again[vague] = False
        rest = np.flatnonzero(again)
        if len(rest):
            self._explore(systems, found, rows, rest, self._image(systems.chosen(rest), f[rest]))

    def one(self, order: int, P: PoseMatrix, frames: Floats) -> tuple[JointVector, Floats] | None:
        """All solutions of one pose and their errors, (k, 6) and (k,), where one look proves them; else None.

        The zeros must be isolated, and the candidate of each must lead to a solution of its own.

        Args:
            order: its number.
            P: (1, 4, 4) displacement of the loop.
            frames: (7, 3, 4) its constants.
        """
        one = self.orders[order]
        systems = _Systems(one, pose.inverse(P) if one.backwards else P)
        _, coefficients, size = self._sample(systems, self._circle)
        if not size[0, 0] <= CLEAN * size[0, 1]:
            return None
        zeros, number, certain = circle_loops.zeros_of(coefficients, size[:, 0], self.degree)
        count = int(number[0])
        if not 0 < count <= MOST or not certain[0]:
            return None
        zero, rows = zeros[0, :count], FIRST[:count]
        turns, rank = systems.candidates(P, frames, self.prismatic, rows, rows, zero, 0.0, 0)
        if not rank.min() > DETERMINED:
            return None
        q, error = np.empty((len(turns), 6)), np.empty(len(turns))
        polish_loops.polish(frames, self.prismatic, P, rows, turns, q, error)
        return (
            (q[:count], error[:count])
            if polish_loops.are_explained(zero, one.joints[2], self.prismatic, q, error, MATCHED)
            else None
        )

    def _explore(
        self,
        systems: _Systems,
        found: Findings,
        rows: NDArray[np.int64],
        some: NDArray[np.intp] | None,
        zeros: tuple[Floats, NDArray[np.int64], NDArray[np.bool_]],
    ) -> None:
        """Zeros of some of the rows, or of all."""
        poses = rows if some is None else rows[some]

        def candidates(row: NDArray[np.int64], zero: Floats, choice: int) -> tuple[Floats, Floats]:
            turn, pick, _ = CHOICES[choice]
            at = row if some is None else some[row]
            return systems.candidates(found.P, found.frames, self.prismatic, poses[row], at, zero, turn, pick)

        joints = systems.order.joints
        found.explore_zeros(poses, zeros, candidates, [enough for _, _, enough in CHOICES], joints[2])

    def _image(self, systems: _Systems, f: Floats) -> tuple[Floats, NDArray[np.int64], NDArray[np.bool_]]:
        """Zeros found on the projective image of the circle on which samples f (k, nodes) are most alike.

        On the image f(t) is multiplied by r^(2 degree), r^2 = |(m c, s / m)|^2 with the half angle (c, s) of the image
        and the squeeze m: the first harmonic of log r^(2 degree) is made opposite to that of log |f|.
        """
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            level = np.log(np.abs(f) / np.abs(f).max(axis=1, keepdims=True) + EPS)
            cosines, sines, _ = self._circle
            x, y = (level * cosines).sum(axis=1), (level * sines).sum(axis=1)
            depth = np.minimum(0.85, np.hypot(x, y) / (f.shape[1] * self.degree))
            centre, squeeze = np.arctan2(-y, -x)[:, None], np.sqrt((1 + depth) / (1 - depth))[:, None]
            c, s = squeeze * np.cos(0.5 * self._angles), np.sin(0.5 * self._angles) / squeeze
            theta = centre + 2 * np.arctan2(s, c)
            circle = np.cos(theta), np.sin(theta), (c * c + s * s) ** self.degree
            _, coefficients, size = self._sample(systems, circle)
            roundoff = size[:, 0] + self._rounding(systems, circle, coefficients)
            zeros, number, certain = self._zeros(coefficients, roundoff)
            self._doubt(systems, number, certain, size[:, 1], roundoff)
            back = centre + 2 * np.arctan2(np.sin(0.5 * zeros) / squeeze, squeeze * np.cos(0.5 * zeros))
        return back, number, certain

    def _rounding(self, systems: _Systems, circle: Circle, coefficients: Floats) -> Floats:
        """(k,) what rounding in the equations does to the coefficients, measured by a larger disturbance."""
        changed = self._sample(systems.perturb(), circle)[1] - coefficients
        change = np.abs(changed[:, : 2 * self.degree + 1]).sum(axis=1)
        return 0.5 * EPS / DISTURBANCE * (1 + systems.condition()) * change

    @staticmethod
    def _doubt(
        systems: _Systems, number: NDArray[np.int64], certain: NDArray[np.bool_], size: Floats, roundoff: Floats
    ) -> None:
        """That there is no zero at all is not certain where the equations are small beside the terms of their sums.

        Their rounding is that of the terms, and no solution would confirm the list.
        """
        empty = np.flatnonzero(certain & (number == 0))
        if len(empty):
            certain[empty] = size[empty] > EMPTY * roundoff[empty] * systems.chosen(empty).cancellation()

    def _sample(self, systems: _Systems, circle: Circle) -> tuple[Floats, Floats, Floats]:
        """(k, nodes) determinants, (k, nodes) their harmonics, and (k, 2) what is left of zeros, and the others' size.

        Args:
            systems: of k poses.
            circle: (k, nodes) or (1, nodes) cosines, sines and weights of the nodes.
        """
        nodes = len(self._fourier)
        f, h, size = np.empty((systems.count, nodes)), np.empty((systems.count, nodes)), np.empty((systems.count, 2))
        elimination_loops.determinants(systems.A, *circle, self._fourier, self.degree, f, h, size)
        return f, h, size

    def _zeros(self, coefficients: Floats, roundoff: Floats) -> tuple[Floats, NDArray[np.int64], NDArray[np.bool_]]:
        return circle_loops.zeros_of(coefficients, roundoff, self.degree)


class _Systems:
    """The equations of one elimination order for many poses."""

    def __init__(self, order: EliminationOrder, P: PoseMatrix) -> None:
        self.order, self.count = order, len(P)
        k = whole(len(P))
        self.A, self.Q, self.R = np.empty((k, 6, 27)), np.empty((k, 8, 15)), np.empty((k, 36))
        elimination_loops.eliminate(P, *order.constants, self.A, self.Q, self.R)

    def chosen(self, rows: NDArray[np.intp]) -> _Systems:
        """Those of some poses."""
        return self._like(len(rows), self.A[rows], self.Q[rows], self.R[rows])

    def perturb(self) -> _Systems:
        """With equations that are a little wrong."""
        A = self.A + DISTURBANCE * np.abs(self.A).max(axis=2, keepdims=True) * NOISE
        return self._like(self.count, A, self.Q, self.R)

    def _like(self, count: int, A: Floats, Q: Floats, R: Floats) -> _Systems:
        some = object.__new__(_Systems)
        some.order, some.count, some.A, some.Q, some.R = self.order, count, A, Q, R
        return some

    def condition(self) -> Floats:
        """(k,) of the systems of a and b, roughly."""
        pivots = np.abs(self.R[: self.count, DIAGONAL])
        return pivots.max(axis=1) / (pivots.min(axis=1) + LEAST_DIVISOR)

    def cancellation(self) -> Floats:
        """(k,) how much larger than the smallest equation the terms are whose sums the equations are."""
        size = np.abs(self.A[: self.count]).max(axis=2).min(axis=1)
        return np.abs(self.order.left).max() / (size + LEAST_DIVISOR)

    def candidates(
        self,
        P: PoseMatrix,
        frames: Floats,
        prismatic: NDArray[np.bool_],
        poses: NDArray[np.int64],
        rows: NDArray[np.int64],
        zeros: Floats,
        turn: float,
        pick: int,
    ) -> tuple[Floats, Floats]:
        """(m', 12) candidates of zeros, see `polish`, and how well they are determined (m,).

        Args:
            P: (k, 4, 4) displacements of the loop.
            frames, prismatic: its constants.
            poses, rows: (m,) places among the displacements and in these systems.
            zeros: (m,) values of joint c.
            turn, pick: as in `CHOICES`.
        """
        count, order = len(rows), self.order
        turns, rank = np.empty((whole(count), 12)), np.empty(whole(count))
        loop = candidate_loops.Loop(frames, prismatic, order.joints, order.left, TWIST)
        systems = candidate_loops.Systems(self.A, self.Q, self.R)
        found = candidate_loops.Zeros(zeros, rows, poses)
        candidate_loops.candidates(loop, P, systems, found, turn, pick, turns, rank)
        return turns, rank[:count]


def fourier_columns(degree: int) -> Floats:
    """(nodes, nodes) from samples to coefficients, columns a_0, a_1, ..., b_1, b_2, ...; the last must give zero.

    Args:
        degree: of the trigonometric polynomial; nodes are the next multiple of eight beyond 2 degree + 2.
    """
    nodes = whole(2 * degree + 2)
    half = nodes // 2
    angle, k = 2 * np.pi * np.arange(nodes)[:, None] / nodes, np.arange(half + 1)
    cosines, sines = 2 * np.cos(k * angle) / nodes, 2 * np.sin(k * angle) / nodes
    cosines[:, [0, half]] *= 0.5
    parts = cosines[:, : degree + 1], sines[:, 1 : degree + 1], cosines[:, degree + 1 :], sines[:, degree + 1 : half]
    return np.ascontiguousarray(np.concatenate(parts, axis=1))
