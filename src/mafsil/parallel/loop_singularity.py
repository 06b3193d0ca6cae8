"""What is singular about a configuration of a mechanism with loops: the loops, the choice of motors, or the task.

1. C-space: the rank of H is below what it is on most configurations. The curvature of the loops on the left-over
   motions says more: indefinite, branches cross; definite, an isolated configuration that cannot move.
2. Actuators: the passive joints move to first order while the driven ones are locked. With w the combination of loop
   rows that no passive joint feels and v the free motion, w . g''(v, v) decides: not zero, the locked mechanism is
   shaky but stands (nondegenerate). Zero: a motion along v is searched with Newton's method on the loops; if it goes
   on, inner links move freely (degenerate); if not, the form vanishes but the mechanism stands (higher order).
3. Task: rank of J_task on the motions H leaves is less than it could be; the left null vectors are blocked.

Reference: Park and Kim 1999; Lynch & Park, Modern Robotics, sec. 7.3.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import comb

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, Integers, real_array
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.parallel.closure import DrivenRates, driven_rates, kernel, numerical_rank, second_form
from mafsil.parallel.tolerances import DEFINITE, FEASIBLE, OPEN, RANK

STEP = 1e-2
"""Length of the steps of a searched self-motion, of coordinates of size one."""
STEPS = 20
MOST_CHOICES = 200_000


class LoopSingularity(Status):
    """What is singular; succeeded means nothing."""

    REGULAR = ("parallel.loop_regular", True)
    CROSSING = ("parallel.loop_crossing", False)
    ISOLATED = ("parallel.loop_isolated", False)
    HIGHER_CSPACE = ("parallel.loop_higher_cspace", False)
    NONDEGENERATE = ("parallel.loop_nondegenerate", False)
    DEGENERATE = ("parallel.loop_degenerate", False)
    HIGHER_ACTUATOR = ("parallel.loop_higher_actuator", False)
    TASK = ("parallel.loop_task", False)


@dataclass(frozen=True, eq=False, repr=False)
class LoopSingularities(
    Answer,
    entries="findings",
    data="findings rank full_rank second_order blocked driven=driven.driven",
):
    """Singularities of one configuration of a closed chain; true if there are none, iterable over the findings.

    Attributes:
        findings: all that was found, the loops first; REGULAR alone if nothing.
        rank: of H here.
        full_rank: of H on most configurations.
        driven: rates for the chosen motors.
        form: (k, k) curvature of the loops on the motions that H leaves, along the first lost row; empty if none is.
        tangents: (b, n) unit rates of the joints along which branches leave a singular configuration of the loops, to
            second order; sought where H leaves two motions, otherwise empty.
        second_order: w . g''(v, v) of unit w and v at an actuator singularity; of several the largest; 0 without.
        blocked: (t, l) orthonormal directions of the task in which nothing moves, beyond those that never do.
    """

    findings: tuple[LoopSingularity, ...]
    rank: int
    full_rank: int
    driven: DrivenRates
    form: Floats
    tangents: Floats
    second_order: float
    blocked: Floats

    @property
    def status(self) -> LoopSingularity:
        """The first finding."""
        return self.findings[0]

    @property
    def signature(self) -> tuple[int, int, int]:
        """Numbers of positive, negative and zero eigenvalues of the form."""
        values = np.linalg.eigvalsh(self.form) if self.form.size else np.zeros(0)
        limit = DEFINITE * max(float(np.abs(values).max(initial=0.0)), LEAST_DIVISOR)
        return int((values > limit).sum()), int((values < -limit).sum()), int((np.abs(values) <= limit).sum())

    def explain(self, language: str | None = None) -> str:
        """One sentence for each finding, with the numbers behind it."""
        plus, minus, zero = self.signature
        s = self.driven.singular_values
        details = {
            "rank": self.rank, "full": self.full_rank, "passive": self.driven.rank_passive,
            "wanted": len(self.driven.passive), "form": abs(self.second_order), "plus": plus, "minus": minus,
            "zero": zero, "least": float(s.min(initial=np.inf)), "blocked": self.blocked.T.round(6).tolist(),
        }  # fmt: skip
        return "\n".join(each.sentence(language, **details) for each in self.findings)


Closure = Callable[[Floats], tuple[Floats, Floats]]
"""From coordinates (n,) to what the loops miss (m,) and their matrix (m, n)."""


def loop_singularities(
    H: Floats, hessians: Floats, driven: Sequence[int], *, full_rank: int, closure: Closure | None, q: Floats,
    task: Floats | None = None, idle: bool = False,
) -> LoopSingularities:  # fmt: skip
    """All that is singular about one configuration.

    Args:
        H: (m, n) matrix of the loops, free of units or with lengths over the size.
        hessians: (m, n, n) second derivatives.
        driven: indices of the motors.
        full_rank: rank of H on most configurations.
        closure: of coordinates, for the search for a self-motion; None leaves a vanishing form undecided as of
            higher order.
        q: (n,) the configuration.
        task: (t, n) rates of the task per rate of the joints.
        idle: motions that leave the task alone, such as the spin of a rod, do not count as actuator singularities.

    Raises:
        InputError: the loops do not close there.
    """
    if closure is not None:
        require_closed(closure(q)[0], float(np.abs(H).max(initial=1.0)))
    rank, rates = numerical_rank(H), driven_rates(H, driven, full_rank)
    findings: list[LoopSingularity] = []
    form, size, tangents = np.zeros((0, 0)), 0.0, np.zeros((0, H.shape[1]))
    # 1.
    if rank < full_rank:
        motions = kernel(H)
        forms = [second_form(hessians, w, motions) for w in kernel(H.T).T]
        forms = sorted(forms, key=lambda each: -float(np.abs(each).max()))
        form, tangents = forms[0], _tangents(forms) @ motions.T
        findings.append(_crossing(forms, len(tangents)))
    # 2.
    elif (free := _count(rates, H.shape[1], task if idle else None)).size:
        kind, size = _lock(H, hessians, rates, free, closure, q)
        findings.append(kind)
    # 3.
    blocked = np.zeros((0 if task is None else task.shape[0], 0))
    if task is not None and rank == full_rank:
        blocked = _block(task, kernel(H), H.shape[1] - full_rank)
        if blocked.shape[1]:
            findings.append(LoopSingularity.TASK)
    return LoopSingularities(
        tuple(findings) or (LoopSingularity.REGULAR,), rank, full_rank, rates, form, tangents, size, blocked
    )


def require_closed(gap: Floats, size: float = 1.0) -> None:
    """Refuse a configuration whose loops gape: nothing that is said of it would be true.

    Args:
        gap: (k,) what the loops miss.
        size: over which it is judged.

    Raises:
        InputError: it does not close.
    """
    worst = float(np.abs(gap).max(initial=0.0))
    if worst > OPEN * size:
        raise InputError("parallel.open", gap=worst)


def _crossing(forms: list[Floats], tangents: int) -> LoopSingularity:
    values = np.linalg.eigvalsh(forms[0])
    limit = DEFINITE * max(float(np.abs(values).max(initial=0.0)), LEAST_DIVISOR)
    plus, minus = bool((values > limit).any()), bool((values < -limit).any())
    if len(values) and bool((np.abs(values) > limit).all()) and plus != minus:
        return LoopSingularity.ISOLATED
    if len(values) == 2 and not tangents and limit > DEFINITE**2:
        return LoopSingularity.ISOLATED
    single = sum(float(np.abs(each).max()) > DEFINITE for each in forms) == 1
    if tangents > 1 or (plus and minus and single and len(values) != 2):
        return LoopSingularity.CROSSING
    return LoopSingularity.HIGHER_CSPACE


def _tangents(forms: list[Floats]) -> Floats:
    """(b, k) unit motions on which all forms vanish, for forms on two motions; none otherwise."""
    size = float(np.abs(forms[0]).max())
    if len(forms[0]) != 2 or size <= DEFINITE:
        return np.zeros((0, len(forms[0])))
    values, axes = np.linalg.eigh(forms[0])
    if values[0] * values[1] > (DEFINITE * size) ** 2:
        return np.zeros((0, 2))
    angle = np.arctan(np.sqrt(abs(values[0] / values[1]))) if abs(values[1]) > abs(values[0]) else None
    if angle is None:
        angle = np.pi / 2 - np.arctan(np.sqrt(abs(values[1] / values[0])))
    found = [axes @ np.array([np.cos(each), np.sin(each)]) for each in ({angle, -angle} if angle > DEFINITE else {0.0})]
    kept = [x for x in found if all(abs(float(x @ each @ x)) <= 1e3 * DEFINITE * size for each in forms)]
    return np.array(kept).reshape(-1, 2)


def _count(rates: DrivenRates, n: int, task: Floats | None) -> Floats:
    """(n, k) motions with the driven joints locked; only those that move the task if it is given."""
    free = np.zeros((n, rates.free.shape[1]))
    free[list(rates.passive)] = rates.free
    if task is None or not free.size:
        return free
    _, s, right = np.linalg.svd(task @ free, full_matrices=False)
    return free @ right[s > 10 * RANK].T


def _lock(
    H: Floats, hessians: Floats, rates: DrivenRates, free: Floats, closure: Closure | None, q: Floats
) -> tuple[LoopSingularity, float]:
    dependent = kernel(H.T)
    felt = rates.internal - dependent @ (dependent.T @ rates.internal)
    left, s, _ = np.linalg.svd(felt, full_matrices=False)
    forms = [second_form(hessians, w, free) for w in left[:, s > 0.5].T]
    sizes = [float(f[np.unravel_index(np.abs(f).argmax(), f.shape)]) for f in forms if f.size]
    size = max(sizes, key=abs, default=0.0)
    if free.shape[1] == 1 and abs(size) > DEFINITE:
        return LoopSingularity.NONDEGENERATE, size
    if any(bool((np.linalg.eigvalsh(f) > DEFINITE).all() or (np.linalg.eigvalsh(f) < -DEFINITE).all()) for f in forms):
        return LoopSingularity.NONDEGENERATE, size
    if closure is not None and _moves(closure, q, free, rates.passive):
        return LoopSingularity.DEGENERATE, size
    return LoopSingularity.HIGHER_ACTUATOR, size


def _moves(closure: Closure, q: Floats, free: Floats, passive: Sequence[int]) -> bool:
    """Whether the passive joints go on along a free motion, step by step, with the loops closed."""
    columns = list(passive)
    direction, at = free[:, 0], q.copy()
    for _ in range(STEPS):
        begin = at.copy()
        at = at + STEP * direction
        for _ in range(20):
            miss, H = closure(at)
            if float(np.abs(miss).max(initial=0.0)) < FEASIBLE:
                break
            at[columns] -= np.linalg.pinv(H[:, columns], rcond=1e-6) @ miss
        moved = at - begin
        miss, _ = closure(at)
        if float(np.abs(miss).max(initial=0.0)) > FEASIBLE or np.linalg.norm(moved) < STEP / 2:
            return False
        direction = moved / np.linalg.norm(moved)
    return bool(np.linalg.norm(at - q) > STEP * STEPS / 4)


def _block(task: Floats, motions: Floats, mobility: int) -> Floats:
    """(t, l) directions of the task lost to the motions (n, d), orthonormal; none while the rank is what it can be."""
    J = task @ motions
    left, s, _ = np.linalg.svd(J)
    possible = min(task.shape[0], mobility)
    rank = int((s > RANK * max(float(np.linalg.norm(task, 2)), LEAST_DIVISOR)).sum())
    return left[:, rank:possible] if rank < possible else np.zeros((task.shape[0], 0))


def choose_actuators(
    H: ArrayLike, count: int, full_rank: int | None = None, *, task: Floats | None = None,
    among: Sequence[int] | None = None,
) -> tuple[tuple[int, ...], ...]:  # fmt: skip
    """All choices of `count` joints that, when driven, decide all other joints, or the task, to first order.

    With N a basis of the motions and T those of them that move the task, the rows of a choice must tell all of T apart
    from each other and from the motions that leave the task alone.

    Args:
        H: (m, n) matrix of the loops at one configuration.
        count: of motors.
        full_rank: rank of H on most configurations; its rank here if None. Where it is less, no choice is good.
        task: (t, n) rates of the task per rate of the joints: motions that leave it alone do not count; all do if None.
        among: joints that may be driven; all if None.

    Raises:
        InputError: no matrix, or more than 200,000 choices; give fewer joints.
    """
    matrix = real_array("H", H)
    if matrix.ndim != 2:
        raise InputError("input.shape", name="H", expected="(m, n)", got=matrix.shape, hint="")
    n = matrix.shape[1]
    joints = tuple(range(n)) if among is None else tuple(among)
    if comb(len(joints), count) > MOST_CHOICES:
        raise InputError("parallel.many_choices", choices=comb(len(joints), count), most=MOST_CHOICES)
    if full_rank is not None and numerical_rank(matrix) < full_rank:
        return ()
    N = kernel(matrix)
    moves = np.eye(N.shape[1]) if task is None else np.asarray(task, dtype=np.float64) @ N
    _, s, right = np.linalg.svd(moves)
    moving = int((s > 10 * RANK * float(s.max(initial=0.0))).sum())
    N = N @ right.T
    every: Integers = np.array(list(combinations(joints, count)), dtype=np.int64).reshape(-1, count)
    rows = N[every]
    idle = ranks_above(rows[..., moving:], RANK)
    good = ranks_above(rows, RANK) == moving + idle
    return tuple(tuple(choice) for choice in every[good].tolist())


def ranks_above(A: Floats, limit: float) -> Integers:
    """(k,) numbers of singular values of (k, m, n) above a limit: of parts of orthonormal columns."""
    if not A.size:
        return np.zeros(len(A), dtype=np.int64)
    return np.asarray((np.linalg.svd(A, compute_uv=False) > limit).sum(axis=-1), dtype=np.int64)
