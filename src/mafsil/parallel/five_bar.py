"""The planar five-bar: two motors on the ground move a point C in the plane; all its positions, rates, singularities.

B = L1 e(alpha) and D = E + L4 e(beta) with E = (L5, 0) are the ends of the cranks; |C - B| = L2, |C - D| = L3.
As a chain of relative angles: alpha = theta_1, beta = theta_1 + ... + theta_4 + pi.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, positive, single
from mafsil.mobility.planar_positions import circle_crossings, wrapped
from mafsil.parallel.crank_reach import rod_misfit
from mafsil.parallel.loop_singularity import LoopSingularities, loop_singularities
from mafsil.parallel.planar_chain import PlanarChain
from mafsil.parallel.singular_kinds import SingularKinds, singular_kinds


@dataclass(frozen=True)
class FiveBar:
    """A planar five-bar by its lengths [m].

    Attributes:
        crank_1, rod_1, rod_2, crank_2, ground: L1 ... L5.
    """

    crank_1: float
    rod_1: float
    rod_2: float
    crank_2: float
    ground: float

    def __post_init__(self) -> None:
        for name in ("crank_1", "rod_1", "rod_2", "crank_2", "ground"):
            object.__setattr__(self, name, positive(name, getattr(self, name)))

    @cached_property
    def chain(self) -> PlanarChain:
        """The same as a chain of relative angles."""
        return PlanarChain(np.array([self.crank_1, self.rod_1, self.rod_2, self.crank_2, self.ground]))

    def crank_ends(self, q: ArrayLike) -> tuple[Floats, Floats]:
        """B and D (*batch, 2) at angles (alpha, beta) (*batch, 2) [rad]."""
        angle = as_batch("q", q, (2,))
        e = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        return self.crank_1 * e[..., 0, :], self.crank_2 * e[..., 1, :] + np.array([self.ground, 0.0])

    def points(self, q: ArrayLike) -> Floats:
        """(*batch, 2, 2) both places of C at angles (alpha, beta): left of B -> D first; NaN where there are none.

        Where B = D and the rods are equal, C is any point of a circle about B: NaN too, see `singularity`.
        """
        B, D = self.crank_ends(q)
        return circle_crossings(B, self.rod_1, D, self.rod_2)

    def angles(self, C: ArrayLike) -> Floats:
        """(*batch, 2, 2, 2) all four pairs (alpha, beta) for a place C (*batch, 2), in (-pi, pi]; NaN out of reach.

        The first index is the elbow B, the second D; each left of the line from its motor to C first.
        """
        place = as_batch("C", C, (2,), finite=True)
        E = np.array([self.ground, 0.0])
        B = circle_crossings(np.zeros(place.shape), self.crank_1, place, self.rod_1)
        D = circle_crossings(np.broadcast_to(E, place.shape), self.crank_2, place, self.rod_2) - E
        alpha, beta = np.arctan2(B[..., 1], B[..., 0]), np.arctan2(D[..., 1], D[..., 0])
        pairs = np.broadcast_arrays(alpha[..., :, None], beta[..., None, :])
        return np.stack(pairs, axis=-1)

    def rod_misfit(self, C: ArrayLike) -> Floats:
        """(*batch, 2) by how much rods are too short (positive) or too long for places C [m]; zero in reach."""
        place = as_batch("C", C, (2,), finite=True)
        far = [np.linalg.norm(place - motor, axis=-1) for motor in (np.zeros(2), np.array([self.ground, 0.0]))]
        cranks, rods = np.array([self.crank_1, self.crank_2]), np.array([self.rod_1, self.rod_2])
        return rod_misfit(np.stack(far, axis=-1), 0.0, cranks, rods)

    def rods_apart(self, q: ArrayLike) -> Floats:
        """(*batch,) by how much both rods together are too short (positive), or one too long, at angles q [m]."""
        B, D = self.crank_ends(q)
        return rod_misfit(np.linalg.norm(D - B, axis=-1), 0.0, self.rod_1, self.rod_2)

    def chain_angles(self, q: ArrayLike, mode: int = 0) -> Floats:
        """(*batch, 5) relative angles at (alpha, beta) in one of both assembly modes; NaN if there is none."""
        angle = as_batch("q", q, (2,))
        B, D = self.crank_ends(angle)
        C = self.points(angle)[..., mode, :]
        forth, back = C - B, D - C
        turned = [
            angle[..., 0], np.arctan2(forth[..., 1], forth[..., 0]), np.arctan2(back[..., 1], back[..., 0]),
            angle[..., 1] + np.pi, np.full(angle.shape[:-1], np.pi),
        ]  # fmt: skip
        absolute = np.stack(turned, axis=-1)
        before = np.concatenate([np.zeros_like(absolute[..., :1]), absolute[..., :-1]], axis=-1)
        return wrapped(absolute - before)

    def motor_matrices(self, q: ArrayLike, C: ArrayLike) -> tuple[Floats, Floats]:
        """A and B (*batch, 2, 2) of A C' = B (alpha', beta'): rows (C - B)' and (C - D)'."""
        first, second = self.crank_ends(q)
        place = as_batch("C", C, (2,))
        rods = np.stack([place - first, place - second], axis=-2)
        cranks = np.stack([first, second - np.array([self.ground, 0.0])], axis=-2)
        across = np.stack([-cranks[..., 1], cranks[..., 0]], axis=-1)
        return rods, (rods * across).sum(axis=-1)[..., None] * np.eye(2)

    def jacobian(self, q: ArrayLike, C: ArrayLike) -> Floats:
        """(*batch, 2, 2) of C' = J (alpha', beta'); infinite or NaN where the rods are in line."""
        A, B = self.motor_matrices(q, C)
        det = A[..., 0, 0] * A[..., 1, 1] - A[..., 0, 1] * A[..., 1, 0]
        adjugate = np.stack(
            [np.stack([A[..., 1, 1], -A[..., 0, 1]], -1), np.stack([-A[..., 1, 0], A[..., 0, 0]], -1)], axis=-2
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            return adjugate @ B / det[..., None, None]

    def motor_singularity(self, q: ArrayLike, C: ArrayLike) -> SingularKinds:
        """Kind of singularity with both motors on the ground: first, a crank in line with its rod; second, the rods."""
        A, B = self.motor_matrices(q, C)
        rods = np.array([[self.rod_1], [self.rod_2]])
        return singular_kinds(A / rods, B / (rods * np.array([[self.crank_1], [self.crank_2]])), 1.0, 0)

    def point_rates(self, theta: ArrayLike) -> Floats:
        """(*batch, 2, 5) of C' = J theta' for all five relative angles of the chain, given by the first four."""
        s = np.cumsum(as_batch("theta", theta, (4,)), axis=-1)[..., :2]
        x, y = (np.array([self.crank_1, self.rod_1]) * f(s) for f in (np.cos, np.sin))
        zero = np.zeros((*s.shape[:-1], 3))
        rows = [np.concatenate([np.stack(r, axis=-1), zero], axis=-1) for r in _both(x, y)]
        return np.stack(rows, axis=-2)

    def singularity(self, theta: ArrayLike, driven: Sequence[int] = (0, 4)) -> LoopSingularities:
        """All that is singular for any choice of driven joints, with C as the task.

        Args:
            theta: (4,) relative angles of the chain that close it.
            driven: joints that are driven, counted from 0.
        """
        angles = single("theta", theta, (4,))
        full = np.append(angles, self.chain.last_angle(angles))

        def closure(q: Floats) -> tuple[Floats, Floats]:
            miss = np.append(self.chain.closure(q[:4]), wrapped(q.sum() - np.pi))
            return miss, self.chain.loop_matrix(q[:4])

        return loop_singularities(
            self.chain.loop_matrix(angles), self.chain.curvature(angles), driven, full_rank=3, closure=closure, q=full,
            task=self.point_rates(angles),
        )  # fmt: skip


def _both(x: Floats, y: Floats) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """Rows of C' by theta_1 and theta_2."""
    return (-y[..., 0] - y[..., 1], -y[..., 1]), (x[..., 0] + x[..., 1], x[..., 1])
