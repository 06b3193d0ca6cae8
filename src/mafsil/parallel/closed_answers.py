"""Answers about closed chains: configurations that close the loops, accelerations, efforts of the actuators."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, Integers, JointVector
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages.visible import visible
from mafsil.parallel.tolerances import RANK


class ClosingStatus(Status):
    """Whether configurations that close the loops were found."""

    CLOSED = ("parallel.closed", True)
    NOT_FOUND = ("parallel.not_closed", False)


@dataclass(frozen=True, eq=False, repr=False)
class ClosedConfigurations(Answer, data="q error steps widest distance angle"):
    """Configurations near given ones; true if all close their loops, iterable over the rows.

    Attributes:
        q: (*batch, n) the best that were found [rad | m].
        error: (*batch) their largest gap [rad | m]; infinite where a loop is closed the wrong way round.
        steps: (*batch) of Newton's method.
        tolerance: up to which a loop counts as closed: roundings, and (*batch) what digits of the description that
            contradict each other leave.
        widest: name of the loop that gapes most where none was found; empty otherwise.
        distance, angle: by how much it is open there, in the nearest to closing that was found [m], [rad].
    """

    q: JointVector
    error: Floats
    steps: Integers
    tolerance: float | Floats
    widest: str = ""
    distance: float = 0.0
    angle: float = 0.0

    @property
    def found(self) -> Booleans:
        """(*batch) whether the loops are closed."""
        return np.asarray(self.error <= self.tolerance, dtype=np.bool_)

    @property
    def status(self) -> ClosingStatus:
        """CLOSED if all rows are."""
        return ClosingStatus.CLOSED if self.found.all() else ClosingStatus.NOT_FOUND

    def __bool__(self) -> bool:
        if not self.error.ndim:
            return bool(self.error <= self.tolerance)
        return bool(self.found.all()) and self.error.size > 0

    def __len__(self) -> int:
        return self.error.size

    def __iter__(self) -> Iterator[JointVector]:
        return iter(self.q.reshape(-1, self.q.shape[-1]))

    def explain(self, language: str | None = None) -> str:
        """How many are closed, and the largest gap."""
        return self.status.sentence(
            language, found=int(self.found.sum()), count=len(self), error=float(self.error.max(initial=0.0)),
            steps=int(self.steps.max(initial=0)), widest=visible(self.widest), distance=self.distance, angle=self.angle,
        )  # fmt: skip


class ClosedMotionStatus(Status):
    """Whether the accelerations of a closed chain are known."""

    SOLVED = ("parallel.closed_solved", True)
    SINGULAR_MASS = ("parallel.closed_singular_mass", False)


class ClosedAccelerations(Answer, tuple[JointVector, Floats], data="qdd force rank error"):
    """Accelerations under efforts and forces of the loops; true if known in every row, iterable over the rows.

    Attributes:
        qdd: (*batch, n) accelerations of all joints [rad/s^2 | m/s^2]; along motions without mass infinite where a
            force acts on them, zero where none does.
        force: (*batch, m) forces along the rows of the loops, the shortest that do it [N m, N].
        rank: (*batch) independent rows of the loops; -1 where the loops allow motions that move no mass.
        rows: number of rows.
        error: (*batch) largest gap of a loop [rad | m].

    Args:
        found: qdd, and (*batch, m + 2) forces, rank and error.
    """

    # A single call takes less than a microsecond: machine code makes the answer, a tuple of few arrays
    # (`Kernel.answer`). Answers are equal if they are the same one, as those of other classes.
    __slots__ = ()
    __eq__ = object.__eq__
    __ne__ = object.__ne__
    __hash__ = object.__hash__

    @property
    def qdd(self) -> JointVector:
        """(*batch, n) accelerations of all joints [rad/s^2 | m/s^2]."""
        return self[0]

    @property
    def force(self) -> Floats:
        """(*batch, m) forces along the rows of the loops, the shortest that do it [N m, N]."""
        return self[1][..., :-2]

    @property
    def error(self) -> Floats:
        """(*batch) largest gap of a loop [rad | m]."""
        return self[1][..., -1][()]

    @property
    def rows(self) -> int:
        """Number of rows of the loops."""
        return self.force.shape[-1]

    @property
    def rank(self) -> Integers:
        """(*batch) independent rows of the loops; -1 where the loops allow motions that move no mass."""
        return self[1][..., -2].astype(np.int64)

    @property
    def redundant(self) -> Integers:
        """(*batch) rows that say what others say: so many parameters of the forces are not determined."""
        return self.rows - self.rank

    @property
    def status(self) -> ClosedMotionStatus:
        """SOLVED if all rows are."""
        return ClosedMotionStatus.SOLVED if (self.rank >= 0).all() else ClosedMotionStatus.SINGULAR_MASS

    def __bool__(self) -> bool:
        return self.status.succeeded and self.rank.size > 0

    def __len__(self) -> int:
        return self.rank.size

    def __iter__(self) -> Iterator[JointVector]:
        return iter(self.qdd.reshape(-1, self.qdd.shape[-1]))

    def explain(self, language: str | None = None) -> str:
        """The rank of the loops, and how far they gape."""
        return self.status.sentence(
            language, rank=int(self.rank.min(initial=self.rows)), rows=self.rows,
            redundant=int(self.rows - self.rank.max(initial=0)), error=float(np.max(self.error, initial=0.0)),
        )  # fmt: skip


class EffortStatus(Status):
    """Whether actuators can make a motion."""

    UNIQUE = ("parallel.efforts_unique", True)
    SEVERAL = ("parallel.efforts_several", True)
    IMPOSSIBLE = ("parallel.efforts_impossible", False)
    BROKEN = ("parallel.efforts_broken", False)


ATTAINED = 1e-7
"""Share of the needed efforts that may be missing, and acceleration by which loops may break."""


class ActuatorEfforts(Answer, data="tau force missing broken"):
    """Efforts of the driven joints for a motion; true if they make it in every row, iterable over the rows.

    Attributes:
        tau: (*batch, a) the shortest that do it, in the sense of least squares where none does [N m | N].
        force: (*batch, m) forces of the loops, the shortest [N m, N].
        missing: (*batch) size of the efforts that no driven joint makes [N m | N].
        broken: (*batch) acceleration with which the motion asked for opens a loop.
        needed: (*batch) size of the efforts that the tree needs.
        driven: (*batch, n, a) what the driven joints do to motions that the loops allow.
    """

    __slots__ = ("_redundancy", "broken", "driven", "force", "missing", "needed", "tau")

    def __init__(
        self,
        tau: Floats,
        force: Floats,
        missing: Floats,
        broken: Floats,
        needed: Floats,
        driven: Floats,
        redundancy: int | None = None,
    ) -> None:
        self.tau = tau
        self.force = force
        self.missing = missing
        self.broken = broken
        self.needed = needed
        self.driven = driven
        self._redundancy = redundancy

    @property
    def redundancy(self) -> Integers:
        """(*batch) dimensions of the preload."""
        if self._redundancy is not None:
            return np.broadcast_to(np.int64(self._redundancy), np.shape(self.missing))
        values = np.linalg.svd(self.driven, compute_uv=False)
        return np.asarray(self.driven.shape[-1] - (values > RANK).sum(axis=-1), dtype=np.int64)

    def preload(self, row: tuple[int, ...] = ()) -> Floats:
        """(a, k) orthonormal efforts of the driven joints that move nothing, only strain the loops.

        Args:
            row: index in the batch.
        """
        _, values, right = np.linalg.svd(self.driven[row])
        return right[int((values > RANK).sum()) :].T

    @property
    def status(self) -> EffortStatus:
        """The worst of the rows."""
        if np.any(self.broken > ATTAINED * (1.0 + self.needed)):
            return EffortStatus.BROKEN
        if np.any(self.missing > ATTAINED * np.maximum(self.needed, LEAST_DIVISOR)):
            return EffortStatus.IMPOSSIBLE
        return EffortStatus.SEVERAL if np.any(self.redundancy > 0) else EffortStatus.UNIQUE

    def __bool__(self) -> bool:
        return self.status.succeeded and np.size(self.missing) > 0

    def __len__(self) -> int:
        return np.size(self.missing)

    def __iter__(self) -> Iterator[Floats]:
        return iter(self.tau.reshape(-1, self.tau.shape[-1]))

    def explain(self, language: str | None = None) -> str:
        """Whether they are unique, and what is missing."""
        return self.status.sentence(
            language, missing=float(np.max(self.missing, initial=0.0)), broken=float(np.max(self.broken, initial=0.0)),
            preload=int(self.redundancy.max(initial=0)), actuators=self.tau.shape[-1],
        )  # fmt: skip
