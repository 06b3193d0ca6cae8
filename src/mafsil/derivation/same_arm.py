"""Whether lists of screws or Denavit-Hartenberg tables are the same arm: many at once against one robot.

Lists of screws are the same arm up to a change of the base frame between them. Of tables that are not the arm, single
values are found that would make them so.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, PoseMatrix
from mafsil.derivation.tolerances import (
    ALMOST_PARALLEL,
    DEPENDENT,
    DH_STEP,
    LEAST_LENGTH,
    NEAREST,
    PSEUDOINVERSE,
    QUARTER,
)
from mafsil.model import Mechanism
from mafsil.model.denavit_hartenberg import Convention, DHRow
from mafsil.model.dh_frames import tables_of_screws
from mafsil.model.dh_from_axes import classic_from_modified, screws

_REFINEMENTS = 3


def misfit(S: Floats, other: Floats, B: Floats) -> Floats:
    """(m, n, 6) how far Ad(B) S is from the other axes.

    Args:
        S: (m, n, 6) lists of screw axes (omega, v).
        other: (n, 6) the axes they should be.
        B: (m, 4, 4) poses.
    """
    R, p = B[:, None, :3, :3], B[:, None, :3, 3]
    omega = (R @ S[..., :3, None])[..., 0]
    v = (R @ S[..., 3:, None])[..., 0] + np.cross(p, omega)
    return np.concatenate([omega, v], axis=-1) - other


def base_between(S: Floats, other: Floats) -> Floats:
    """The poses B (m, 4, 4) that bring every list of axes nearest to the other one.

    1. The rotation between the directions (Kabsch). Where all are parallel, or almost, it leaves a turn about them
       free: there the turn that fits the places of the axes in the plane across them is tried too.
    2. The origin by linear least squares: p x omega' = v' - R v for every revolute axis.
    3. Where the misfit is small, all six freedoms together by Gauss-Newton: places also tell directions.

    Args:
        S: (m, n, 6) lists of screw axes.
        other: (n, 6) axes.

    Reference: Kabsch, Acta Crystallographica A 32, 1976.
    """
    revolute = np.abs(S[..., :3]).max(axis=-1) > 0.5
    before = np.where(revolute[..., None], S[..., :3], S[..., 3:])
    after = np.where((np.abs(other[:, :3]).max(axis=1) > 0.5)[:, None], other[:, :3], other[:, 3:])
    U, sizes, Vt = np.linalg.svd(np.einsum("nj,mnk->mjk", after, before))
    U[..., 2] *= np.linalg.det(U @ Vt)[:, None]
    R = U @ Vt
    B = _with_origin(R, S, other, revolute)
    flat = sizes[:, 1] < ALMOST_PARALLEL * sizes[:, 0]
    if flat.any():
        spun = _spun(R[flat], S[flat], other, after[0], revolute[flat])
        B[flat] = _better(S[flat], other, B[flat], _with_origin(spun, S[flat], other, revolute[flat]))
    return _refine(S, other, B)


def _with_origin(R: Floats, S: Floats, other: Floats, revolute: Floats) -> Floats:
    """Poses (m, 4, 4) with those rotations, and p with R v + p x R omega = v' as nearly as possible."""
    omega = (R[:, None] @ S[..., :3, None])[..., 0] * revolute[..., None]
    missing = other[:, 3:] - (R[:, None] @ S[..., 3:, None])[..., 0]
    square = np.einsum("mni,mni->m", omega, omega)[:, None, None] * np.eye(3) - np.einsum("mni,mnj->mij", omega, omega)
    right = np.cross(omega, missing).sum(axis=1)
    B = np.broadcast_to(np.eye(4), (len(S), 4, 4)).copy()
    B[:, :3, :3] = R
    B[:, :3, 3] = (np.linalg.pinv(square, rcond=PSEUDOINVERSE, hermitian=True) @ right[..., None])[..., 0]
    return B


def _spun(R: Floats, S: Floats, other: Floats, z: Floats, revolute: Floats) -> Floats:
    """Rotations turned further about z, the direction of all axes, so that the axes' places fit."""
    weight = revolute[..., None].astype(np.float64)
    count = np.maximum(weight.sum(axis=1, keepdims=True), 1.0)
    mine = np.cross(S[..., :3], S[..., 3:]) @ R.transpose(0, 2, 1)
    theirs = np.broadcast_to(np.cross(other[:, :3], other[:, 3:]), mine.shape)
    mine, theirs = ((x - (weight * x).sum(axis=1, keepdims=True) / count) * weight for x in (mine, theirs))
    angle = np.arctan2((np.cross(mine, theirs) @ z).sum(axis=1), (mine * theirs).sum(axis=(1, 2)))
    c, s = np.cos(angle)[:, None, None], np.sin(angle)[:, None, None]
    Z = np.cross(z, np.eye(3)).T
    return (np.eye(3) + s * Z + (1 - c) * (Z @ Z)) @ R


def _better(S: Floats, other: Floats, one: Floats, two: Floats) -> Floats:
    """Of two poses for every list, the one with the smaller misfit."""
    sizes = [np.abs(misfit(S, other, B)).max(axis=(1, 2), initial=0.0) for B in (one, two)]
    return np.where((sizes[0] <= sizes[1])[:, None, None], one, two)


def _refine(S: Floats, other: Floats, B: Floats) -> Floats:
    scale = max(1.0, float(np.abs(other).max(initial=0.0)))
    for _ in range(_REFINEMENTS):
        size = np.abs(misfit(S, other, B)).max(axis=(1, 2), initial=0.0)
        near = (size < 1e-2 * scale) & (size > NEAREST * scale)
        if not near.any():
            break
        B[near] = _better(S[near], other, B[near], _step(S[near], other, B[near]))
    return B


def _step(S: Floats, other: Floats, B: Floats) -> Floats:
    """One Gauss-Newton step: B moved by the small twist that takes most of the misfit away."""
    error = misfit(S, other, B)
    omega, v = error[..., :3] + other[:, :3], error[..., 3:] + other[:, 3:]
    J = np.zeros((*error.shape, 6))
    J[..., :3, :3] = J[..., 3:, 3:] = -_skew(omega)
    J[..., 3:, :3] = -_skew(v)
    rows = J.reshape(len(S), -1, 6)
    twist = -(np.linalg.pinv(rows, rcond=PSEUDOINVERSE / 10) @ error.reshape(len(S), -1, 1))[..., 0]
    U, _, Vt = np.linalg.svd(np.eye(3) + _skew(twist[:, :3]))
    moved = np.broadcast_to(np.eye(4), B.shape).copy()
    moved[:, :3, :3], moved[:, :3, 3] = U @ Vt, twist[:, 3:]
    return moved @ B


def _skew(w: Floats) -> Floats:
    """(..., 3, 3) matrices [w] with [w] x = w x x."""
    out = np.zeros((*w.shape, 3))
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -w[..., 2], w[..., 1], -w[..., 0]
    out[..., 1, 0], out[..., 2, 0], out[..., 2, 1] = w[..., 2], -w[..., 1], w[..., 0]
    return out


Rows: TypeAlias = tuple[DHRow, ...]
Field: TypeAlias = Literal["a", "alpha", "d", "theta"]
FIELDS: tuple[Field, ...] = ("alpha", "a", "d", "theta")
ANGLES = ("alpha", "theta")
_STEPS = 10
_STARTS = 8
_MOST_TABLES = 64


class Solved(NamedTuple):
    """The value of one entry with which the table would be the robot."""

    row: int
    field: Field
    value: float


class Truth:
    """The robot's axes and home pose, and whether tables have the same.

    Args:
        mechanism: the robot.
        base, tool: (4, 4) poses that go with the tables; None if any will do.
        tolerance: of directions and of lengths [m].
    """

    def __init__(
        self, mechanism: Mechanism, base: PoseMatrix | None, tool: PoseMatrix | None, tolerance: float
    ) -> None:
        self.S, _, self.home = screws(mechanism)
        self.base, self.tool, self.tolerance = base, tool, tolerance

    def agreeing(self, tables: Sequence[Rows], convention: Convention) -> NDArray[np.bool_]:
        """(m,) which of the tables are the robot."""
        if not tables:
            return np.zeros(0, dtype=np.bool_)
        numbers, revolute = _numbers(tables)
        return np.abs(self._misfit(numbers, revolute, convention)).max(axis=1, initial=0.0) <= self.tolerance

    def solve_entries(self, rows: Rows, convention: Convention) -> list[Solved]:
        """Every entry that alone can make the table right, with the value that does.

        1. Each of the 4n entries from several starts: angles all round, lengths from the given value and from zero.
        2. Newton's steps on the one number, x <- x - (r . r') / (r' . r'), r the misfit after the best base pose.
        3. What agrees within the tolerance, the value nearest to the given one first.
        """
        given, turns = _numbers([rows])
        places = [(i, f, x) for i in range(len(rows)) for f in range(4) for x in _starts(f, float(given[0, i, f]))]
        numbers = np.repeat(given, len(places), axis=0)
        revolute = np.repeat(turns, len(places), axis=0)
        at = (np.arange(len(places)), np.array([p[0] for p in places]), np.array([p[1] for p in places]))
        numbers[at] = [p[2] for p in places]
        size = max(LEAST_LENGTH, float(np.abs(given[..., 1:3]).max(initial=0.0)))
        width = np.where(np.isin(at[2], (0, 3)), DH_STEP, DH_STEP * size)
        for _ in range(_STEPS):
            ahead, behind = numbers.copy(), numbers.copy()
            ahead[at] += width
            behind[at] -= width
            error = self._misfit(numbers, revolute, convention)
            slope = (self._misfit(ahead, revolute, convention) - self._misfit(behind, revolute, convention)) / (
                2 * width[:, None]
            )
            numbers[at] -= (error * slope).sum(axis=1) / np.maximum((slope * slope).sum(axis=1), DEPENDENT)
        fits = np.abs(self._misfit(numbers, revolute, convention)).max(axis=1) <= self.tolerance
        return _nearest(given[0], [(*places[k][:2], float(numbers[at][k])) for k in np.flatnonzero(fits)])

    def tables(self, convention: Convention) -> list[Rows]:
        """Right tables with our own frames, all senses of meeting axes.

        Raises:
            ModelError: a helical joint, which no table has.
        """
        own = islice(tables_of_screws(self.S, self.home), _MOST_TABLES)
        return [(t if convention is Convention.MODIFIED else classic_from_modified(t)).rows for t in own]

    def _misfit(self, numbers: Floats, revolute: Floats, convention: Convention) -> Floats:
        """(m, k) differences of axes, and of the tip's pose where the tool is given."""
        S, ends = _axes(numbers, revolute, convention, np.eye(4) if self.base is None else self.base)
        if self.base is not None:
            B = np.broadcast_to(np.eye(4), ends.shape)
        elif self.tool is not None:
            B = self.home @ np.linalg.inv(ends @ self.tool)
        else:
            B = base_between(S, self.S)
        axes = misfit(S, self.S, B).reshape(len(S), -1)
        if self.tool is None:
            return axes
        return np.concatenate([axes, (B @ ends @ self.tool - self.home).reshape(len(S), -1)], axis=1)


def distance(rows: Rows, tables: Sequence[Rows], tolerance: float) -> int:
    """Number of entries in which a table differs from the nearest of others."""
    return min((sum(1 for _ in differing(rows, table, tolerance)) for table in tables), default=0)


def differing(rows: Rows, right: Rows, tolerance: float) -> list[tuple[int, Field | Literal["kind"]]]:
    """Row (from 0) and name of every entry in which two tables differ, whole turns aside."""
    found: list[tuple[int, Field | Literal["kind"]]] = []
    for i, (row, other) in enumerate(zip(rows, right, strict=True)):
        if row.kind != other.kind:
            found.append((i, "kind"))
        for field in FIELDS:
            apart = value_of(row, field) - value_of(other, field)
            if field in ANGLES:
                apart = float(np.angle(np.exp(1j * apart)))
            if abs(apart) > tolerance:
                found.append((i, field))
    return found


def value_of(row: DHRow, field: Field) -> float:
    """An entry at q = 0: the constant offset of the coordinate counts."""
    moving = "theta" if row.kind == "R" else "d"
    return float(getattr(row, field)) + (row.offset if field == moving else 0.0)


def _numbers(tables: Sequence[Rows]) -> tuple[Floats, Floats]:
    """(m, n, 4) entries in the order of FIELDS, and (m, n) whether the joints turn."""
    numbers = np.array([[[value_of(row, field) for field in FIELDS] for row in rows] for rows in tables])
    return numbers, np.array([[row.kind == "R" for row in rows] for rows in tables])


def _axes(numbers: Floats, revolute: Floats, convention: Convention, base: PoseMatrix) -> tuple[Floats, Floats]:
    """(m, n, 6) screw axes at q = 0 and (m, 4, 4) poses of {n}."""
    T = np.broadcast_to(base, (len(numbers), 4, 4))
    axes = np.zeros((*numbers.shape[:2], 6))
    for i in range(numbers.shape[1]):
        before, T = T, T @ _link(numbers[:, i], convention)
        frame = T if convention is Convention.MODIFIED else before
        z, moment = frame[:, :3, 2], np.cross(frame[:, :3, 3], frame[:, :3, 2])
        turns = revolute[:, i, None]
        axes[:, i, :3] = np.where(turns, z, 0.0)
        axes[:, i, 3:] = np.where(turns, moment, z)
    return axes, T


def _link(numbers: Floats, convention: Convention) -> Floats:
    """(m, 4, 4) link transforms."""
    alpha, a, d, theta = numbers.T
    along_x = np.broadcast_to(np.eye(4), (len(numbers), 4, 4)).copy()
    along_z = along_x.copy()
    along_x[:, 1, 1] = along_x[:, 2, 2] = np.cos(alpha)
    along_x[:, 2, 1], along_x[:, 1, 2], along_x[:, 0, 3] = np.sin(alpha), -np.sin(alpha), a
    along_z[:, 0, 0] = along_z[:, 1, 1] = np.cos(theta)
    along_z[:, 1, 0], along_z[:, 0, 1], along_z[:, 2, 3] = np.sin(theta), -np.sin(theta), d
    return along_x @ along_z if convention is Convention.MODIFIED else along_z @ along_x


def _starts(field: int, given: float) -> list[float]:
    if FIELDS[field] in ANGLES:
        return [given + 2 * np.pi * k / _STARTS for k in range(_STARTS)]
    return [given, 0.0] if given else [0.0]


def _nearest(given: Floats, found: list[tuple[int, int, float]]) -> list[Solved]:
    """For every entry the value nearest to the given one; angles within half a turn, cleaned of roundoff."""
    best: dict[tuple[int, int], float] = {}
    for i, f, value in found:
        tidy = _tidy(value, FIELDS[f])
        before = best.get((i, f))
        if before is None or _apart(tidy, given[i, f], f) < _apart(before, given[i, f], f):
            best[i, f] = tidy
    return [Solved(i, FIELDS[f], value) for (i, f), value in best.items()]


def _tidy(value: float, field: Field) -> float:
    """An angle in (-pi, pi]; rounding of quarter turns and of lengths removed."""
    if field in ANGLES:
        value = float(-np.angle(np.exp(-1j * value)))
        quarters = round(value / (np.pi / 2))
        return quarters * np.pi / 2 if abs(value - quarters * np.pi / 2) < QUARTER else value
    return round(value, 9)


def _apart(x: float, y: float, field: int) -> float:
    return abs(float(np.angle(np.exp(1j * (x - y))))) if FIELDS[field] in ANGLES else abs(x - y)
