"""Determinants of Jacobians as products of short factors, found by looking from the frame where most entries vanish."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

from mafsil.derivation.arm import SymbolicArm
from mafsil.derivation.polynomial import (
    ZERO,
    Entries,
    Monomial,
    Polynomial,
    Row,
    SymbolicPose,
    collect_terms,
    cross,
    minus,
    simplify,
    transform,
    transpose,
)

LONGEST = 400
"""A block whose expanded determinant has more terms is given up."""


@dataclass(frozen=True, slots=True, eq=False)
class Determinant:
    """det J = factors[0] factors[1] ..., of the rows `rows` of the Jacobian seen from frame {frame}, moments there.

    Attributes:
        factors: polynomials.
        frame: number of the frame.
        point: number of the frame at whose origin the linear part is taken; n + 1 is the tip.
        rows: of (omega_x, omega_y, omega_z, v_x, v_y, v_z), from 0.
        columns: (rows, n) the matrix.
    """

    factors: tuple[Polynomial, ...]
    frame: int
    point: int
    rows: tuple[int, ...]
    columns: Entries


def determinant(arm: SymbolicArm) -> Determinant | None:
    """The determinant of the square Jacobian of the arm's own task, or None if it has none or it is too long.

    Six joints: the whole Jacobian. Two parallel or three spatial joints: the velocity of the tip. Otherwise the rows
    that do not vanish, if they are as many as the joints.

    Args:
        arm: in letters.
    """
    views = sorted(_views(arm), key=lambda view: view[3])
    for frame, point, J, _ in views[:3]:
        rows = _task_rows(arm, J)
        if len(rows) != arm.n:
            continue
        square = tuple(J[r] for r in rows)
        factors = product_of_blocks(square)
        if factors is not None:
            return Determinant(_split(factors), frame, point, rows, square)
    return None


def _views(arm: SymbolicArm) -> Iterator[tuple[int, int, Entries, int]]:
    """The Jacobian seen from every frame, its linear part at every origin, with its length on paper."""
    position = _position_task(arm)
    for frame in range(1, arm.n + 1):
        poses = [relative_pose(arm, frame, i) for i in range(1, arm.n + 1)]
        tip = _tip(arm, poses[-1])
        points = range(arm.n + 1, arm.n + 2) if position else range(1, arm.n + 1)
        for point in points:
            at = (tip if point > arm.n else poses[point - 1]).p
            J = transpose(tuple(_screw(arm, i, pose, at) for i, pose in enumerate(poses)))
            yield frame, point, J, sum(entry.length for row in J for entry in row)


def relative_pose(arm: SymbolicArm, k: int, i: int) -> SymbolicPose:
    """T_ki of the table's frames {k} and {i}, 1 .. n."""
    if i >= k:
        return arm.between(k, i)
    T_ik = arm.between(i, k)
    R = transpose(T_ik.R)
    return SymbolicPose(R, tuple(-x for x in transform(R, T_ik.p)))


def _tip(arm: SymbolicArm, last: SymbolicPose) -> SymbolicPose:
    moved = transform(last.R, arm.tool.p)
    return SymbolicPose(last.R, tuple(simplify(x + y) for x, y in zip(last.p, moved, strict=True)))


def _screw(arm: SymbolicArm, index: int, pose: SymbolicPose, at: Row) -> Row:
    """Screw (omega, v) of a joint, v at the point `at`."""
    if arm.rows[index].row.kind == "P":
        return (ZERO, ZERO, ZERO, *pose.z)
    return (*pose.z, *cross(pose.z, minus(at, pose.p)))


def _position_task(arm: SymbolicArm) -> bool:
    """Whether the arm's task is to place a point."""
    parallel = all(not row.alpha and row.alpha_quarters % 2 == 0 for row in arm.rows)
    return arm.n == 2 if parallel else arm.n == 3


def _task_rows(arm: SymbolicArm, J: Entries) -> tuple[int, ...]:
    rows = tuple(r for r, row in enumerate(J) if any(not x.is_zero for x in row))
    return tuple(r for r in rows if r >= 3) if _position_task(arm) else rows


def product_of_blocks(A: Entries) -> tuple[Polynomial, ...] | None:
    """Factors whose product is det A: blocks of columns (or rows) that live in as many rows (columns) split off.

    Args:
        A: (n, n).

    Returns:
        The factors, or None if a block is too long to be written.
    """
    if len(A) == 1:
        return (A[0][0],)
    for rows, columns in _blocks(A):
        rest_rows = [r for r in range(len(A)) if r not in rows]
        rest_columns = [c for c in range(len(A)) if c not in columns]
        inner = product_of_blocks(_part(A, rows, columns))
        outer = product_of_blocks(_part(A, rest_rows, rest_columns))
        if inner is None or outer is None:
            return None
        odd = (_parity([*rows, *rest_rows]) + _parity([*columns, *rest_columns])) % 2
        return (*((-inner[0], *inner[1:]) if odd else inner), *outer)
    whole = _expand(A)
    return None if whole is None else (whole,)


def _blocks(A: Entries) -> Iterator[tuple[list[int], list[int]]]:
    """Smallest sets of columns whose entries lie in equally many rows, and the same of rows."""
    size, flipped = len(A), transpose(A)
    for count in range(1, size):
        for chosen in combinations(range(size), count):
            used = [r for r in range(size) if any(not A[r][c].is_zero for c in chosen)]
            if len(used) == count:
                yield used, list(chosen)
            used = [c for c in range(size) if any(not flipped[c][r].is_zero for r in chosen)]
            if len(used) == count:
                yield list(chosen), used


def _part(A: Entries, rows: Sequence[int], columns: Sequence[int]) -> Entries:
    return tuple(tuple(A[r][c] for c in columns) for r in rows)


def _parity(order: Sequence[int]) -> int:
    return sum(a > b for k, a in enumerate(order) for b in order[k + 1 :]) % 2


def _expand(A: Entries) -> Polynomial | None:
    """Det A by expansion along the first row, simplified."""
    if len(A) == 1:
        return A[0][0]
    total = ZERO
    for c, entry in enumerate(A[0]):
        if entry.is_zero:
            continue
        minor = _expand(_part(A, range(1, len(A)), [k for k in range(len(A)) if k != c]))
        if minor is None:
            return None
        total = total + (entry * minor if c % 2 == 0 else -(entry * minor))
        if len(total.terms) > LONGEST:
            return None
    return simplify(total)


def _split(factors: Sequence[Polynomial]) -> tuple[Polynomial, ...]:
    """One monomial in front, then what is left of every factor."""
    front: list[Monomial] = []
    rest: list[Polynomial] = []
    number = 1.0
    for factor in factors:
        if factor.is_zero:
            return (ZERO,)
        common = _common(factor)
        inner = collect_terms((_remove(m, common), x) for m, x in factor.terms.items())
        front.append(common)
        if len(inner.terms) == 1 and () in inner.terms:
            number *= inner.terms[()]
            continue
        if next(iter(inner.terms.values())) < 0:
            number, inner = -number, -inner
        rest.append(inner)
    product = Polynomial({(): number})
    for monomial in front:
        product = product * Polynomial({monomial: 1.0})
    return (product, *rest) if product.terms != {(): 1.0} or not rest else tuple(rest)


def _common(factor: Polynomial) -> Monomial:
    """Factors that all terms share, with their powers."""
    first, *others = factor.terms
    shared = list(first)
    for monomial in others:
        rest = list(monomial)
        shared = [f for f in shared if f in rest and (rest.remove(f) or True)]
    return tuple(shared)


def _remove(monomial: Monomial, common: Monomial) -> Monomial:
    rest = list(monomial)
    for factor in common:
        rest.remove(factor)
    return tuple(rest)
