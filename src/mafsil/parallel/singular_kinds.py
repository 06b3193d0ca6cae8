"""Singularities of robots with A V = B q': which of the two matrices loses rank, and what that means.

First kind (B singular): a motor turns and the platform stands; the platform cannot move in some direction, which the
structure carries without any motor. Second kind (A singular): the platform moves with all motors locked; no effort
of them resists some wrench. Third kind: both at once.

Reference: Gosselin and Angeles, Singularity analysis of closed-loop kinematic chains, IEEE Trans. Rob. Autom. 6, 1990.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, Integers
from mafsil.parallel.tolerances import RANK
from mafsil.solvers.decompositions import singular_values


class SingularKind(Status):
    """Of Gosselin and Angeles; succeeded means that motors and platform decide each other's motion."""

    REGULAR = ("parallel.kind_regular", True)
    FIRST = ("parallel.kind_first", False)
    SECOND = ("parallel.kind_second", False)
    THIRD = ("parallel.kind_third", False)


KINDS = (SingularKind.REGULAR, SingularKind.FIRST, SingularKind.SECOND, SingularKind.THIRD)


@dataclass(frozen=True, eq=False, repr=False)
class SingularKinds(Answer, data="kinds of_A of_B"):
    """Kinds of singularity of a batch of configurations; true if all are regular, iterable over the kinds.

    Attributes:
        A: (*batch, m, k) with A V = B q', rows as forces along unit vectors, moments over the size.
        B: (*batch, m, m), each entry over the largest that it can be.
        units: (k,) by which the columns of A were divided: the size of the robot [m] for rotations, 1.
        of_A, of_B: (*batch,) least singular value, over the largest if that is above one: 0 at a singularity.
    """

    A: Floats
    B: Floats
    units: Floats
    of_A: Floats
    of_B: Floats

    @property
    def kinds(self) -> Integers:
        """(*batch,) 0 regular, 1 first kind, 2 second, 3 both."""
        return np.asarray((self.of_B <= RANK) + 2 * (self.of_A <= RANK), dtype=np.intp)

    @property
    def status(self) -> SingularKind:
        """Of one configuration; of a batch the worst."""
        return KINDS[int(self.kinds.max(initial=0))]

    def __len__(self) -> int:
        return int(self.of_A.size)

    def __iter__(self) -> Iterator[SingularKind]:
        return (KINDS[k] for k in self.kinds.reshape(-1).tolist())

    def explain(self, language: str | None = None) -> str:
        """The kind, with both measures."""
        return self.status.sentence(
            language, of_A=float(self.of_A.min(initial=np.inf)), of_B=float(self.of_B.min(initial=np.inf)),
            rows=self.of_A.size, regular=int((self.kinds == 0).sum()),
        )  # fmt: skip

    @property
    def free_motion(self) -> Floats:
        """(*batch, k) the motion that A resists least: free at the second kind; a unit if lengths are over the size."""
        return _smallest(self.A)[1] / self.units

    @property
    def internal_forces(self) -> Floats:
        """(*batch, m) combination of the rows of A with the least resultant: what the legs do to each other."""
        return _smallest(np.swapaxes(self.A, -1, -2))[1]

    @property
    def blocked_motion(self) -> Floats:
        """(*batch, k) w with w . V = 0 for every motion that motors can make, at the first kind."""
        left = _smallest(np.swapaxes(self.B, -1, -2))[1]
        return np.einsum("...mk,...m->...k", self.A, left) * self.units


def singular_kinds(A: Floats, B: Floats, size: float, angles: int) -> SingularKinds:
    """Kinds of singularity of A V = B q'.

    Args:
        A: (*batch, m, k) rows as forces along unit vectors.
        B: (*batch, m, m), rows divided as those of A, columns by the size of what the motors move.
        size: of the robot [m].
        angles: how many of the first columns of A are moments.
    """
    units = np.concatenate([np.full(angles, size), np.ones(A.shape[-1] - angles)])
    rows = A / units
    measures: list[Floats] = []
    for M in (rows, B):
        s = singular_values(np.ascontiguousarray(M))
        measures.append(s[..., -1] / np.maximum(s[..., 0], 1.0))
    return SingularKinds(rows, B, units, measures[0], measures[1])


def _smallest(M: Floats) -> tuple[Floats, Floats]:
    """The least singular value (*batch,) and its right vector (*batch, k)."""
    _, s, right = np.linalg.svd(M)
    return s[..., -1], right[..., -1, :]
