"""Solutions of a batch of poses as they are found: candidates are polished, each solution is noted once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Booleans, Floats, JointVector, PoseMatrix
from mafsil.geometry import pose
from mafsil.ik.chain import Chain
from mafsil.ik.tolerances import DETERMINED, MATCHED
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.ik.general.polish_loops as polish_loops
else:
    polish_loops = lazily("mafsil.ik.general.polish_loops")

MOST = 16
"""Isolated solutions of six revolute joints (Primrose, 1986)."""

FOLD = 0.05
"""Smallest over largest singular value of the Jacobian below which a second solution is looked for close by."""

WAYS: Floats = np.array([0.001, 0.01, 0.03, 0.1, 0.3, 0.6])
"""How far from a nearly singular solution along the direction that moves least [rad | unit of length]."""

Candidates = Callable[[NDArray[np.int64], Floats, int], tuple[Floats, Floats]]
"""From rows, zeros (m,) and a choice to candidates (m', 12), see `polish`, and how well they are determined (m,)."""


class Findings:
    """What is found for the poses of a batch.

    Attributes:
        P: (k, 4, 4) displacements of the loop, in units of the arm.
        q, size: (k, 16, 6) and (k, 16) solutions and their errors, NaN beyond their number.
        count: (k,) their number.
        proof: (k,) whether the list is proven complete.
        attempts: (k,) eliminations that were tried.
    """

    def __init__(self, frames: Floats, prismatic: NDArray[np.bool_], P: PoseMatrix) -> None:
        k = len(P)
        self.frames, self.prismatic, self.P = frames, prismatic, np.ascontiguousarray(P)
        self.q, self.size = np.full((k, MOST, 6), np.nan), np.full((k, MOST), np.nan)
        self.count, self.attempts = np.zeros(k, dtype=np.int64), np.zeros(k, dtype=np.int64)
        self.proof = np.zeros(k, dtype=np.bool_)

    def try_candidates(self, rows: NDArray[np.int64], turns: Floats) -> tuple[JointVector, NDArray[np.bool_]]:
        """Newton's method on candidates; what became of them (m, 6), and which of them are solutions.

        Args:
            rows: (m,) which pose each belongs to.
            turns: (m', 12) candidates as cosines and sines, see `polish`; lost.
        """
        q, size = self._polish(rows, turns)
        polish_loops.note_new(rows, q, size, self.prismatic, self.count, self.q, self.size)
        return q, size < polish_loops.CLOSED

    def _polish(self, rows: NDArray[np.int64], turns: Floats) -> tuple[JointVector, Floats]:
        q, size = np.empty((len(turns), 6)), np.empty(len(turns))
        polish_loops.polish(self.frames, self.prismatic, self.P, rows, turns, q, size)
        return q[: len(rows)], size[: len(rows)]

    def turns(self, q: JointVector) -> Floats:
        """(m', 12) cosine and sine of each joint, or length and zero, of candidates (m, 6)."""
        turns = np.zeros((whole(len(q)), 6, 2))
        turns[: len(q), :, 0], turns[: len(q), :, 1] = np.where(self.prismatic, q, np.cos(q)), np.sin(q)
        return turns.reshape(-1, 12)

    def explore_zeros(
        self,
        rows: NDArray[np.int64],
        zeros: tuple[Floats, NDArray[np.int64], NDArray[np.bool_]],
        candidates: Candidates,
        enough: Sequence[float],
        joint: int,
    ) -> None:
        """Solutions that zeros of one joint lead to; proven complete are lists that the zeros explain.

        Args:
            rows: (k,) the poses.
            zeros: (k, most) zeros, (k,) their number, (k,) whether there are no others and each is simple.
            candidates: from rows and zeros to candidates.
            enough: for each choice, tried one after the other, the rank beyond which a solution is enough.
            joint: whose value the zeros are.
        """
        values, number, certain = zeros
        listed: Booleans = np.asarray(np.arange(values.shape[1]) < number[:, None], dtype=np.bool_)
        row, place = np.nonzero(listed)
        zero = values[row, place]
        hit, todo, proven = np.zeros(len(row), dtype=np.bool_), np.arange(len(row)), certain & (number == 0)
        for choice, limit in enumerate(enough):
            if not len(todo):
                break
            turns, rank = candidates(row[todo], zero[todo], choice)
            q, closed = self.try_candidates(rows[row[todo]], turns)
            # The solution must be that of this zero, else the zero is not explained.
            away = np.abs((q[:, joint] - zero[todo] + np.pi) % (2 * np.pi) - np.pi)
            here = closed & (away < MATCHED)
            hit[todo] |= here
            unexplained = np.bincount(row[~hit], minlength=len(rows)) > 0
            proven = certain & ~unexplained & (self.count[rows] == number)
            done = here & (rank > limit)
            if choice == 0:
                # A list that is complete, its zeros well determined, needs no second look.
                vague = np.bincount(row[rank <= DETERMINED], minlength=len(rows)) > 0
                done |= (proven & ~vague)[row]
            todo = todo[~done]
        self.proof[rows] |= proven & (self.count[rows] == number)

    def add_nearby(self, rows: NDArray[np.int64], nearby: Findings) -> None:
        """Solutions that those of poses nearby lead to are added, the best conditioned first.

        Lists end with the members of continua, which would fill them.

        Args:
            rows: (k,) the poses.
            nearby: what was found for poses beside them, for one of each after the other.
        """
        count = np.concatenate([self.count[rows], nearby.count])
        which, place = np.nonzero(np.arange(MOST) < count[:, None])
        row, starts = rows[which % len(rows)], np.concatenate([self.q[rows], nearby.q])[which, place]
        q, size = self._polish(row, self.turns(starts))
        closed = np.flatnonzero(size < polish_loops.CLOSED)
        values = np.linalg.svd(self._jacobians(q[closed]), compute_uv=False)
        best = closed[np.argsort(-values[:, 5] / values[:, 0], kind="stable")]
        self.q[rows], self.size[rows], self.count[rows] = np.nan, np.nan, 0
        polish_loops.note_new(row[best], q[best], size[best], self.prismatic, self.count, self.q, self.size)

    def look_beside(self, rows: NDArray[np.int64]) -> None:
        """Solutions beside nearly singular ones, where two meet at a fold, along the direction that moves least."""
        row, place = np.nonzero(np.arange(MOST) < self.count[rows][:, None])
        if not len(row):
            return
        q = self.q[rows[row], place]
        _, values, Vt = np.linalg.svd(self._jacobians(q))
        folded = np.flatnonzero(values[:, 5] <= FOLD * values[:, 0])
        ways = np.concatenate([WAYS, -WAYS])
        starts = q[folded, None] + ways[:, None] * Vt[folded, None, 5]
        if len(folded):
            self.try_candidates(np.repeat(rows[row[folded]], len(ways)), self.turns(starts.reshape(-1, 6)))

    def _jacobians(self, q: JointVector) -> Floats:
        """(m, 6, 6) rows (axis, velocity of the tip)."""
        T: Floats = np.broadcast_to(_square(self.frames[0]), (len(q), 4, 4))
        axes: list[Floats] = []
        places: list[Floats] = []
        for k in range(6):
            axes.append(T[:, :3, 2])
            places.append(T[:, :3, 3])
            screw = np.array([0, 0, 0, 0, 0, 1.0]) if self.prismatic[k] else np.array([0, 0, 1.0, 0, 0, 0])
            T = T @ pose.exp(screw * q[:, k, None]) @ _square(self.frames[k + 1])
        columns: list[Floats] = [
            np.concatenate([0 * z, z] if prismatic else [z, np.cross(z, T[:, :3, 3] - p)], axis=1)
            for z, p, prismatic in zip(axes, places, self.prismatic, strict=True)
        ]
        return np.stack(columns, axis=2)


def whole(count: int) -> int:
    """The next multiple of eight: loops in lanes fill whole vectors."""
    return -(-count // 8) * 8


def loop_frames(chain: Chain) -> Floats:
    """(7, 3, 4) constants F_k: the loop is F_0 Z_0 F_1 Z_1 ... Z_5 F_6, Z_k about or along z."""
    B = np.tile(np.eye(4), (6, 1, 1))
    for k, z in enumerate(chain.axes):
        x = np.cross(z, np.eye(3)[int(np.abs(z).argmin())])
        x /= np.linalg.norm(x)
        B[k, :3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
        B[k, :3, 3] = chain.points[k]
    inverse = pose.inverse(B)
    frames = [B[0], *(inverse[k] @ B[k + 1] for k in range(5)), inverse[5]]
    return np.ascontiguousarray(np.array(frames)[:, :3])


def _square(F: Floats) -> PoseMatrix:
    return np.concatenate([F, np.array([[0, 0, 0, 1.0]])])
