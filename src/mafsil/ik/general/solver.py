"""All solutions of arms of six joints without a special shape, for whole batches, with a proof where there is one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix, gate
from mafsil.geometry import pose
from mafsil.ik.chain import Chain
from mafsil.ik.general.roads import TWIST, roads
from mafsil.ik.problem import clean_poses
from mafsil.kernels import threads as pool
from mafsil.kernels.lazy import lazy

DEGREE = 8
"""Of the determinant as a trigonometric polynomial of the first joint found, if all six joints turn."""

TURNS: Floats = np.array([0.0, 0.7, 1.2])
"""Turns of the half angle of joint d that are tried until a zero of the determinant leads to a solution."""

STILL = 1e-7
"""Values of added joints that count as standing still [rad | m]."""

CHUNK = 256
"""Poses that one thread takes at a time."""


@dataclass(frozen=True, eq=False)
class GeneralSolutions:
    """All solutions of a batch of poses.

    Attributes:
        q: (*batch, 16, n) solutions, NaN in rows beyond their number; angles in (-pi, pi] [rad | m].
        count: (*batch,) their number.
        complete: (*batch,) whether it is proven that there are no others: every zero of the determinant on the circle
            isolated beyond the rounding of its coefficients, and each the first joint of one solution.
        error: (*batch, 16) error of the loop that was left [rad, unit of length].
        roads: (*batch,) eliminations that were tried.
    """

    q: JointVector
    count: NDArray[np.int64]
    complete: NDArray[np.bool_]
    error: Floats
    roads: NDArray[np.int64]


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
        wanted = gate("T", T, (4, 4))
        clean, valid = clean_poses(wanted.reshape(-1, 4, 4))
        return self._machine.solve(clean, valid, wanted.shape[:-2], pool.available() if threads is None else threads)

    def proves(self, T: PoseMatrix, count: int) -> bool:
        """Whether it is proven that a pose (4, 4) has so many solutions and no more."""
        found = self.solve_all(T)
        return bool(found.complete) and int(found.count) == count

    @lazy
    def _machine(self) -> _Machine:
        return _Machine(self.chain)


class _Machine:
    """Constants of an arm in the shape that the compiled loop takes."""

    def __init__(self, chain: Chain) -> None:
        self.home = chain.home
        self.joints = chain.joints
        filled = _filled(chain)
        turning = ~np.array(filled.slides, dtype=np.bool_)
        self.size = _size(filled)
        self.middle = filled.points[turning].mean(axis=0) if turning.any() else np.zeros(3)
        self.filled = _normalised(filled, self.middle, self.size)
        found = roads(self.filled)
        self.order = np.arange(len(found))
        self.numbers = np.array([road.joints for road in found], dtype=np.int64).reshape(-1, 6)
        self.backwards = np.array([road.backwards for road in found], dtype=np.bool_)
        self.before = np.array([road.before for road in found])
        self.lines = np.array([road.lines for road in found], dtype=np.int64)
        self.after = np.array([road.after for road in found])
        self.products = np.array([road.products.T for road in found])
        self.left = np.array([road.left for road in found])
        self.unit = np.array([road.unit for road in found])
        self.slides = np.array(self.filled.slides, dtype=np.bool_)
        self.frames = _frames(self.filled)
        self.degree = DEGREE if not self.slides.any() else 12
        self.fourier = _fourier(self.degree)
        self._ordered()

    def _ordered(self) -> None:
        """The roads with the most proofs first."""
        if not len(self.order):
            return
        generator = np.random.default_rng(3)
        q = generator.uniform(-np.pi, np.pi, (24, 6))
        P = _product(self.filled, q)
        score: list[tuple[float, float]] = []
        every = self.order
        for road in every:
            self.order = np.array([road])
            out = self._run(P)
            good = np.array([_holds(found[:k], wanted) for found, k, wanted in zip(out.q, out.count, q, strict=True)])
            score.append((-float(out.complete.sum() + good.sum()), float(road)))
        self.order = np.array([int(road) for _, road in sorted(score)], dtype=np.int64)
        self.score = [s for s, _ in sorted(score)]

    def solve(self, T: PoseMatrix, valid: NDArray[np.bool_], batch: tuple[int, ...], threads: int) -> GeneralSolutions:
        """All solutions of those of the poses (k, 4, 4) that are valid, as a batch of a shape."""
        P = T @ pose.inverse(self.home)
        P[:, :3, 3] = (P[:, :3, 3] + P[:, :3, :3] @ self.middle - self.middle) / self.size
        P[~valid] = np.nan
        out = self._run(P, threads)
        where = [self.filled.joints.index(j) for j in sorted(j for j in self.joints if j >= 0)]
        q, error = out.q * np.where(self.slides, self.size, 1.0), out.error
        added = [k for k in range(6) if k not in where]
        if added:
            stray = ~(np.abs(q[:, :, added]) <= STILL).all(axis=-1)
            q[stray], error[stray] = np.nan, np.nan
            order = np.argsort(stray, axis=1, kind="stable")
            q, error = np.take_along_axis(q, order[..., None], 1), np.take_along_axis(error, order, 1)
        return GeneralSolutions(
            q[..., where].reshape(*batch, *q.shape[1:2], len(where)),
            (~np.isnan(error)).sum(axis=1).reshape(batch),
            out.complete.reshape(batch),
            error.reshape(*batch, *error.shape[1:]),
            out.roads.reshape(batch),
        )

    def _run(self, P: PoseMatrix, threads: int = 1) -> GeneralSolutions:
        from mafsil.ik.general.polish_loops import MOST
        from mafsil.ik.general.solution_loops import Arm, solved

        b = len(P)
        Q = pose.inverse(P)
        q, size = np.full((b, MOST, 6), np.nan), np.full((b, MOST), np.nan)
        proof, taken = np.zeros(b, np.int64), np.zeros(b, np.int64)
        count = -(-b // CHUNK)

        arm = Arm(
            self.numbers, self.backwards, self.before, self.lines, self.after, self.products, self.left, self.unit,
            self.frames, self.slides, self.fourier, self.degree, TWIST, TURNS,
        )  # fmt: skip

        def part(i: int) -> None:
            s = slice(i * CHUNK, min(b, (i + 1) * CHUNK))
            solved(P[s], Q[s], self.order, arm, q[s], size[s], proof[s], taken[s])

        if len(self.order):
            pool.run(part, count, threads)
        return GeneralSolutions(q, (~np.isnan(size)).sum(axis=1), proof > 0, size, taken)


def _filled(chain: Chain) -> Chain:
    """Six joints: those added stand still wherever the pose can be reached."""
    generator = np.random.default_rng(4)
    while len(chain) < 6:
        place = chain.home[:3, 3] + 0.3 * chain.size * generator.normal(size=3)
        chain = chain.with_joint(generator.normal(size=3), place)
    return chain


def _size(chain: Chain) -> float:
    turning = ~np.array(chain.slides, dtype=np.bool_)
    places = chain.points[turning]
    extent = float(np.linalg.norm(places.max(axis=0) - places.min(axis=0))) if len(places) else 0.0
    return 0.5 * extent if extent > 1e-9 else chain.size


def _normalised(chain: Chain, middle: Floats, size: float) -> Chain:
    """The chain about another origin, in another unit of length, its home pose left out."""
    turning = ~np.array(chain.slides, dtype=np.bool_)[:, None]
    points = (chain.points - middle) * turning / size
    points = points - (points * chain.axes).sum(axis=1, keepdims=True) * chain.axes
    return Chain(chain.axes, points, chain.slides, chain.joints, np.eye(4), chain.reversed)


def _frames(chain: Chain) -> Floats:
    """(7, 3, 4) constants F_k: the loop is F_0 Z_0 F_1 Z_1 ... Z_5 F_6."""
    B = np.tile(np.eye(4), (6, 1, 1))
    for k, z in enumerate(chain.axes):
        x = np.cross(z, np.eye(3)[int(np.abs(z).argmin())])
        x /= np.linalg.norm(x)
        B[k, :3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
        B[k, :3, 3] = chain.points[k]
    inverse = pose.inverse(B)
    frames = [B[0], *(inverse[k] @ B[k + 1] for k in range(5)), inverse[5]]
    return np.ascontiguousarray(np.array(frames)[:, :3])


def _product(chain: Chain, q: JointVector) -> PoseMatrix:
    """(k, 4, 4) the displacement of the whole chain."""
    E = pose.exp(chain.screws * q[..., None])
    P = E[:, 0]
    for k in range(1, 6):
        P = P @ E[:, k]
    return P


def _fourier(degree: int) -> Floats:
    """(nodes, nodes) from samples to coefficients, rows a_0, b_1, a_1, b_2, a_2, ...; the last rows are of no use."""
    nodes = 4 * (2 * degree // 4 + 1)
    angle = 2 * np.pi * np.arange(nodes) / nodes
    rows = [np.ones(nodes) / nodes]
    for k in range(1, nodes // 2):
        rows.extend([2 * np.sin(k * angle) / nodes, 2 * np.cos(k * angle) / nodes])
    rows.append(np.cos(nodes // 2 * angle) / nodes)
    return np.array(rows)


def _holds(found: JointVector, wanted: JointVector) -> bool:
    """Whether one of the solutions is the wanted one."""
    d = (found - wanted + np.pi) % (2 * np.pi) - np.pi
    return len(found) > 0 and bool((np.abs(d).max(axis=1) < 1e-6).any())
