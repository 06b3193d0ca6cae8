"""All solutions of arms of six joints without a special shape, for whole batches, with a proof where there is one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil import threads as pool
from mafsil.arrays import Floats, JointVector, PoseMatrix, as_batch
from mafsil.geometry import pose
from mafsil.ik.chain import Chain
from mafsil.ik.general.elimination import Elimination
from mafsil.ik.general.findings import MOST, Findings, loop_frames
from mafsil.ik.general.offset_wrist import OffsetWrist, offset_wrist
from mafsil.ik.general.prismatic import ThreePrismatic, TwoPrismatic
from mafsil.ik.result import clean_poses
from mafsil.ik.tolerances import ADDED_STILL, NO_EXTENT, SAME
from mafsil.kernels.lazy import lazy

CHUNK = 256
"""Poses that one thread takes at a time."""

FEW = 64
"""Poses that are not worth another thread."""


BESIDE: Floats = np.random.default_rng(5).normal(size=(3, 6)) * np.array([[1e-3], [3e-3], [1e-2]])
"""Ways to poses beside one whose elimination is singular [rad, unit of length].

A continuum of configurations makes all equations of an elimination order singular, and with it the isolated
configurations are lost. Beside the pose there is no continuum, and every well conditioned configuration has a
neighbour, from which Newton's method leads back.
"""


@dataclass(frozen=True, eq=False)
class GeneralSolutions:
    """All solutions of a batch of poses.

    Attributes:
        q: (*batch, 16, n) solutions, NaN in rows beyond their number; angles in (-pi, pi] [rad | m].
        count: (*batch,) their number.
        complete: (*batch,) whether it is proven that there are no others: every zero of the determinant on the circle
            isolated beyond the rounding of its coefficients, and each the first joint of one solution.
        error: (*batch, 16) error of the loop that was left [rad, unit of length].
        attempts: (*batch,) eliminations that were tried.
    """

    q: JointVector
    count: NDArray[np.int64]
    complete: NDArray[np.bool_]
    error: Floats
    attempts: NDArray[np.int64]

    def __getitem__(self, row: int) -> GeneralSolutions:
        """Those of one pose of a flat batch."""
        return GeneralSolutions(self.q[row], self.count[row], self.complete[row], self.error[row], self.attempts[row])

    def reshape(self, batch: tuple[int, ...]) -> GeneralSolutions:
        """As many poses in another shape."""
        if batch == self.count.shape:
            return self
        return GeneralSolutions(
            self.q.reshape(*batch, *self.q.shape[1:]),
            self.count.reshape(batch),
            self.complete.reshape(batch),
            self.error.reshape(*batch, *self.error.shape[1:]),
            self.attempts.reshape(batch),
        )


@dataclass(frozen=True, eq=False)
class GeneralSix:
    """Elimination for one arm; what does not depend on the pose is computed once.

    Attributes:
        chain: of six joints, or fewer, which are filled up with joints that stand still.
    """

    chain: Chain

    def solve(self, T: PoseMatrix) -> JointVector:
        """(k, n) candidates for one pose; forward kinematics has to judge them."""
        found = self.solve_all(T)
        return found.q[: int(found.count)]

    def solve_all(self, T: ArrayLike, *, threads: int | None = None) -> GeneralSolutions:
        """All solutions of a batch of poses; none, and no proof, for rows that are no poses.

        Args:
            T: (*batch, 4, 4) poses of the tip in {s}.
            threads: how many work at once; all available if None.

        Raises:
            InputError: a wrong shape.
        """
        requested = as_batch("T", T, (4, 4))
        clean, valid = clean_poses(requested.reshape(-1, 4, 4))
        return self._machine.solve(clean, valid, requested.shape[:-2], pool.available() if threads is None else threads)

    @property
    def proves(self) -> bool:
        """Whether some of the random poses at which the elimination orders were tried had a list that is proven.

        Of wrists whose axes nearly meet, and other arms beside one whose elimination is singular, there are none.
        """
        machine = self._machine
        return machine.offset is not None or machine.ranking[1] > 0

    @property
    def offset(self) -> OffsetWrist | None:
        """The polynomial of the last joint, if the arm has an offset wrist."""
        return self._machine.offset

    @lazy
    def _machine(self) -> _Machine:
        return _Machine(self.chain)


class _Machine:
    """Constants of an arm: its loop about a fitting origin, in a fitting unit of length, and the orders to try."""

    def __init__(self, chain: Chain) -> None:
        self.back = pose.inverse(chain.home)
        filled = _fill(chain)
        revolute = ~np.array(filled.prismatic, dtype=np.bool_)
        self.size = _size(filled)
        self.middle = filled.points[revolute].mean(axis=0) if revolute.any() else np.zeros(3)
        self.filled = _normalise(filled, self.middle, self.size)
        self.prismatic = np.array(self.filled.prismatic, dtype=np.bool_)
        self.lengths = np.where(self.prismatic, self.size, 1.0)
        self.where = [self.filled.joints.index(j) for j in sorted(j for j in chain.joints if j >= 0)]
        self.added = [k for k in range(6) if k not in self.where]
        self.frames = loop_frames(self.filled)
        self.offset = None if self.added else offset_wrist(self.filled, (self.back, self.middle, self.size))

    @lazy
    def method(self) -> Elimination | TwoPrismatic | ThreePrismatic:
        """Elimination, as the joints need it."""
        return _method(self.filled)

    @lazy
    def ranking(self) -> tuple[list[int], int]:
        """The orders with the most proofs first, those at one look counted twice, and how many lists they proved."""
        q = np.random.default_rng(3).uniform(-np.pi, np.pi, (24, 6))
        P = _product(self.filled, q)
        score, proofs = list[tuple[int, int]](), 0
        for order in range(len(self.method)):
            out = self._eliminate(Findings(self.frames, self.prismatic, P), [order], beside=False)
            good = [_holds(found[:k], sampled) for found, k, sampled in zip(out.q, out.count, q, strict=True)]
            looks = sum(self._look(P[i : i + 1], order) is not None for i in range(len(P)))
            score.append((-int(out.proof.sum()) - sum(good) - looks, order))
            proofs += int(out.proof.sum())
        return [order for _, order in sorted(score)], proofs

    def solve(self, T: PoseMatrix, valid: NDArray[np.bool_], batch: tuple[int, ...], threads: int) -> GeneralSolutions:
        """All solutions of those of the poses (k, 4, 4) that are valid, as a batch of a shape."""
        P = T @ self.back
        P[:, :3, 3] = (P[:, :3, 3] + P[:, :3, :3] @ self.middle - self.middle) / self.size
        P[~valid] = np.nan
        if len(P) == 1 and valid[0] and not self.added and self.offset is None and (one := self._one(P)) is not None:
            return one.reshape(batch)
        count, done = max(1, -(-len(P) // CHUNK), min(threads, len(P) // FEW)), dict[int, Findings]()
        size = -(-len(P) // count)

        def part(i: int) -> None:
            done[i] = self._run(P[i * size : (i + 1) * size])

        pool.run(part, count, threads)
        parts = [done[i] for i in range(count)]
        q = np.concatenate([one.q for one in parts]) * self.lengths
        error = np.concatenate([one.size for one in parts])
        proof = np.concatenate([one.proof for one in parts])
        taken = np.concatenate([one.attempts for one in parts])
        if self.added:
            stray = ~(np.abs(q[:, :, self.added]) <= ADDED_STILL).all(axis=-1)
            q[stray], error[stray] = np.nan, np.nan
            order = np.argsort(stray, axis=1, kind="stable")
            q, error = np.take_along_axis(q, order[..., None], 1), np.take_along_axis(error, order, 1)
        return GeneralSolutions(q[..., self.where], (~np.isnan(error)).sum(axis=1), proof, error, taken).reshape(batch)

    def _one(self, P: PoseMatrix) -> GeneralSolutions | None:
        """All solutions of one pose (1, 4, 4) where one look proves them; else None."""
        found = self._look(P, self.ranking[0][0])
        if found is None:
            return None
        count = len(found[1])
        q, error = np.full((1, MOST, 6), np.nan), np.full((1, MOST), np.nan)
        q[0, :count], error[0, :count] = found
        q *= self.lengths
        return GeneralSolutions(q[..., self.where], np.array([count]), np.array([True]), error, np.array([1]))

    def _look(self, P: PoseMatrix, order: int) -> tuple[JointVector, Floats] | None:
        """What an elimination order proves of one pose at one look."""
        return self.method.one(order, P, self.frames) if isinstance(self.method, Elimination) else None

    def _run(self, P: PoseMatrix) -> Findings:
        """The polynomial of an offset wrist first; elimination for what it does not prove."""
        found = Findings(self.frames, self.prismatic, P)
        if self.offset is not None:
            self.offset.take(found)
        return found if found.proof.all() else self._eliminate(found, self.ranking[0])

    def _eliminate(self, found: Findings, orders: list[int], *, beside: bool = True) -> Findings:
        """Elimination orders one by one, until one proves that nothing is missing; else also at poses beside."""
        P = found.P
        rows = np.flatnonzero(~found.proof & np.isfinite(P).all(axis=(1, 2)))
        for order in orders:
            if not len(rows):
                return found
            found.attempts[rows] += 1
            self.method.take(order, found, rows)
            rows = rows[~found.proof[rows]]
        if beside and len(rows):
            ways = (P[rows] @ pose.exp(BESIDE)[:, None]).reshape(-1, 4, 4)
            nearby = Findings(self.frames, self.prismatic, ways)
            found.add_nearby(rows, self._eliminate(nearby, orders, beside=False))
        found.look_beside(rows)
        return found


def _method(chain: Chain) -> Elimination | TwoPrismatic | ThreePrismatic:
    match sum(chain.prismatic):
        case 2:
            return TwoPrismatic(chain)
        case 3:
            return ThreePrismatic(chain)
        case _:
            return Elimination(chain)


def _fill(chain: Chain) -> Chain:
    """Six joints: those added stand still wherever the pose can be reached."""
    generator = np.random.default_rng(4)
    while len(chain) < 6:
        place = chain.home[:3, 3] + 0.3 * chain.size * generator.normal(size=3)
        chain = chain.with_joint(generator.normal(size=3), place)
    return chain


def _size(chain: Chain) -> float:
    revolute = ~np.array(chain.prismatic, dtype=np.bool_)
    places = chain.points[revolute]
    extent = float(np.linalg.norm(places.max(axis=0) - places.min(axis=0))) if len(places) else 0.0
    return 0.5 * extent if extent > NO_EXTENT else chain.size


def _normalise(chain: Chain, middle: Floats, size: float) -> Chain:
    """The chain about another origin, in another unit of length, its home pose left out."""
    revolute = ~np.array(chain.prismatic, dtype=np.bool_)[:, None]
    points = (chain.points - middle) * revolute / size
    points = points - (points * chain.axes).sum(axis=1, keepdims=True) * chain.axes
    return Chain(chain.axes, points, chain.prismatic, chain.joints, np.eye(4), chain.reversed)


def _product(chain: Chain, q: JointVector) -> PoseMatrix:
    """(k, 4, 4) the displacement of the whole chain."""
    E = pose.exp(chain.screws * q[..., None])
    P = E[:, 0]
    for k in range(1, 6):
        P = P @ E[:, k]
    return P


def _holds(found: JointVector, requested: JointVector) -> bool:
    """Whether one of the solutions is the requested one."""
    d = (found - requested + np.pi) % (2 * np.pi) - np.pi
    return len(found) > 0 and bool((np.abs(d).max(axis=1) < SAME).any())
