"""What a task may ask of an environment: independent motions and forces, natural and artificial constraints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, SingleAnswer, Status
from mafsil.arrays import Floats, real_array, require_finite
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.messages.tables import on_screen, table
from mafsil.one_joint.arguments import finite

RANK = 1e-10
"""Singular value, as a share of the largest, below which a choice counts as dependent."""

AXES = ("x", "y", "z")


class ChoiceStatus(Status):
    """Whether motions and forces can be chosen so."""

    DETERMINED = ("one_joint.choice_determined", True)
    CONFLICT = ("one_joint.choice_conflict", False)


@dataclass(frozen=True, eq=False, repr=False)
class MotionForceChoice(SingleAnswer):
    """What follows from n wanted motions and forces against an environment F = B V; false if they conflict.

    Attributes:
        status: whether they are independent.
        motion, force: (n,) V and F; NaN if they conflict.
        rank: of the n conditions.
        conflict: (n,) combination of the wanted numbers that the environment fixes or leaves without effect; zero if
            there is none.
    """

    status: ChoiceStatus
    motion: Floats
    force: Floats
    rank: int
    conflict: Floats

    def explain(self, language: str | None = None) -> str:
        """Whether the choice can be had, and which combination of it cannot."""
        terms = " + ".join(f"{c:.3g} * wanted[{k}]" for k, c in enumerate(self.conflict.tolist()) if abs(c) > 1e-6)
        return self.status.sentence(language, rank=self.rank, n=len(self.conflict), terms=terms)

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "status": self.status.name.lower(), "motion": self.motion, "force": self.force, "rank": self.rank,
            "conflict": self.conflict,
        }  # fmt: skip


def choose(
    environment: ArrayLike, force_rows: ArrayLike, motion_rows: ArrayLike, wanted: ArrayLike
) -> MotionForceChoice:
    """Impose n linear functionals of motion and force on an environment F = B V.

    S_F F + S_V V = wanted has one solution exactly if S_F B + S_V is regular. Motion and force along one direction
    cannot both be imposed: the environment makes one of the other.

    Args:
        environment: B (n, n) [N s/m].
        force_rows, motion_rows: S_F, S_V (n, n).
        wanted: (n,).

    Returns:
        Motion and force, or CONFLICT with the combination that cannot be chosen.

    Raises:
        InputError: wrong shapes, not finite.
    """
    B = finite("environment", environment)
    if B.ndim != 2 or B.shape[0] != B.shape[1] or not B.size:
        raise InputError("input.shape", name="environment", expected="(n, n)", got=B.shape, hint="")
    n = len(B)
    S_F, S_V, goal = (
        require_finite(name, real_array(name, value))
        for name, value in (("force_rows", force_rows), ("motion_rows", motion_rows), ("wanted", wanted))
    )
    for name, array, shape in (("force_rows", S_F, (n, n)), ("motion_rows", S_V, (n, n)), ("wanted", goal, (n,))):
        if array.shape != shape:
            raise InputError("input.shape", name=name, expected=shape, got=array.shape, hint="")
    conditions = S_F @ B + S_V
    left, sizes, _ = np.linalg.svd(conditions)
    rank = int((sizes > RANK * max(float(sizes[0]), 1e-300)).sum())
    if rank < n:
        nothing: Floats = np.full(n, np.nan)
        return MotionForceChoice(ChoiceStatus.CONFLICT, nothing, nothing, rank, left[:, -1])
    V: Floats = np.asarray(np.linalg.solve(conditions, goal), dtype=np.float64)
    return MotionForceChoice(ChoiceStatus.DETERMINED, V, B @ V, rank, np.zeros(n))


class ConstraintStatus(Status):
    """Whether a task sets exactly what its contact leaves open."""

    COMPLETE = ("one_joint.constraints_complete", True)
    INCOMPLETE = ("one_joint.constraints_incomplete", False)
    CONFLICT = ("one_joint.constraints_conflict", False)


@dataclass(frozen=True, eq=False, repr=False)
class ConstraintTable(Answer):
    """Natural and artificial constraints of a task in a frame of the contact; true if the task is complete.

    Attributes:
        status: whether each open motion and each open force is set, and nothing else.
        constrained: names of the directions in which the contact prevents motion.
        natural: what the contact sets: (quantity, 0), a velocity where it constrains, a force where it is free.
        artificial: what the task sets: (quantity, value), a force where it constrains, a velocity where it is free.
        missing: quantities that the task should set and does not.
        refused: quantities that the task sets although the contact sets them.
    """

    status: ConstraintStatus
    constrained: tuple[str, ...]
    natural: tuple[tuple[str, float], ...]
    artificial: tuple[tuple[str, float], ...]
    missing: tuple[str, ...]
    refused: tuple[str, ...]

    def __bool__(self) -> bool:
        return self.status.succeeded

    def __len__(self) -> int:
        return len(self.natural)

    def __iter__(self) -> Iterator[tuple[str, str, float]]:
        """For each direction: the natural constraint, the artificial one, and its value (NaN if missing)."""
        given = dict(self.artificial)
        for name, _ in self.natural:
            dual = _dual(name)
            yield name, dual, given.get(dual, np.nan)

    def __repr__(self) -> str:
        head = (say("one_joint.natural"), say("one_joint.artificial"))
        rows = [(f"{natural} = 0", f"{dual} = {value:g}") for natural, dual, value in self]
        return "\n".join([on_screen(self.explain()), *table(head, rows)])

    def explain(self, language: str | None = None) -> str:
        """Freedoms of motion and force, and what the task lacks or may not set."""
        return self.status.sentence(
            language, motion=len(self.natural) - len(self.constrained), force=len(self.constrained),
            missing=", ".join(self.missing), refused=", ".join(self.refused),
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        names = ("constrained", "natural", "artificial", "missing", "refused")
        return {"status": self.status.name.lower()} | {name: getattr(self, name) for name in names}


VELOCITIES = (*(f"omega_{a}" for a in AXES), *(f"v_{a}" for a in AXES))
FORCES = (*(f"m_{a}" for a in AXES), *(f"f_{a}" for a in AXES))
"""Components of a twist (omega, v) and of a wrench (m, f), in the same order."""


def constraint_table(constrained: Sequence[str], task: Mapping[str, float]) -> ConstraintTable:
    """Natural and artificial constraints of a frictionless contact that keeps some directions of a frame.

    Where the contact constrains, the velocity is zero by nature and the task sets the force; where it does not, the
    force is zero by nature and the task sets the velocity: six natural and six artificial ones.

    Args:
        constrained: velocities that the contact prevents, of omega_x, omega_y, omega_z, v_x, v_y, v_z.
        task: values that the task sets, by velocity or force (m_x, m_y, m_z, f_x, f_y, f_z).

    Returns:
        The table; INCOMPLETE if something open is not set, CONFLICT if the task sets what the contact sets: motion and
        force along one direction cannot both be imposed.

    Raises:
        InputError: an unknown name, or a value that is not finite.

    Reference: Mason, Compliance and force control for computer controlled manipulators, 1981.
    """
    known = (*VELOCITIES, *FORCES)
    kept = tuple(dict.fromkeys(constrained))
    for name in kept:
        if name not in VELOCITIES:
            raise InputError("input.choice", name="constrained", value=name, known=", ".join(VELOCITIES))
    for name, value in task.items():
        if name not in known:
            raise InputError("input.choice", name="task", value=name, known=", ".join(known))
        finite(f"task[{name!r}]", value)
    natural = tuple(
        (velocity if velocity in kept else force, 0.0) for velocity, force in zip(VELOCITIES, FORCES, strict=True)
    )
    by_nature = {name for name, _ in natural}
    missing = tuple(_dual(name) for name, _ in natural if _dual(name) not in task)
    refused = tuple(name for name in task if name in by_nature)
    status = (
        ConstraintStatus.CONFLICT if refused else ConstraintStatus.INCOMPLETE if missing else ConstraintStatus.COMPLETE
    )
    artificial = tuple((name, float(value)) for name, value in task.items() if name not in by_nature)
    return ConstraintTable(status, kept, natural, artificial, missing, refused)


def _dual(name: str) -> str:
    """The force of a velocity, the velocity of a force."""
    return dict(zip((*VELOCITIES, *FORCES), (*FORCES, *VELOCITIES), strict=True))[name]


class ContactStatus(Status):
    """What a point contact with friction does."""

    STICKS = ("one_joint.contact_sticks", True)
    SLIPS = ("one_joint.contact_slips", True)
    FREE = ("one_joint.contact_free", True)


def contact_freedoms(normal: float, tangential: ArrayLike, friction: float) -> tuple[ContactStatus, int]:
    """Which constraints hold at a point that presses on a surface, such as chalk on a board.

    Args:
        normal: F_n, positive when it presses [N].
        tangential: F_t (2,) or (1,) [N].
        friction: mu >= 0.

    Returns:
        STICKS with 3 constraints if |F_t| <= mu F_n, SLIPS with 1, FREE with 0 if nothing presses.

    Raises:
        InputError: not finite, a negative coefficient.
    """
    F_n, F_t, mu = float(finite("normal", normal)), finite("tangential", tangential), finite("friction", friction)
    if mu < 0.0:
        raise InputError("input.range", name="friction", value=float(mu), low=0.0, high=np.inf)
    if F_n <= 0.0:
        return ContactStatus.FREE, 0
    return (ContactStatus.STICKS, 3) if np.linalg.norm(F_t) <= mu * F_n else (ContactStatus.SLIPS, 1)
