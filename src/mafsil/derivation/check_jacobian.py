"""A student's Jacobian, in numbers or as formulas, against the compiled robot: which entry is wrong, by which slip."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, gate, real_array
from mafsil.derivation.arm import symbolic_arm
from mafsil.derivation.formula_slips import repaired
from mafsil.derivation.formula_text import evaluate, parsed
from mafsil.derivation.review import Finding, Review, Slip, shown
from mafsil.errors import InputError, ModelError
from mafsil.model import Mechanism
from mafsil.model.loading import RobotLike, as_mechanism
from mafsil.robot import Robot

Kind: TypeAlias = Literal["space", "body", "tip"]
KINDS = ("space", "body", "tip")
STATES = 12


class _Truth:
    """Jacobians of the compiled robot at states q (states, n), rows chosen to match the given matrix."""

    def __init__(self, mechanism: Mechanism, q: Floats, rows: int) -> None:
        self.robot, self.q, self.rows = Robot(mechanism), q, rows

    def jacobian(self, kind: str, q: Floats | None = None) -> Floats:
        """(states, rows, n): `space`, `body`, `tip` (velocity of the tip point in {s}, angular rows first if six)."""
        at = self.q if q is None else q
        if kind == "body":
            J = np.asarray(self.robot.jacobian_body(at))
        else:
            J = np.array(self.robot.jacobian_space(at))
            if kind == "tip":
                J[:, 3:] += np.cross(J[:, :3], self.position(at)[:, :, None], axisa=1, axisb=1, axisc=1)
        return J if self.rows == 6 else J[:, 3 : 3 + self.rows]

    def position(self, q: Floats) -> Floats:
        """(states, 3) of the tip."""
        return np.asarray(self.robot.forward_kinematics(q))[:, :3, 3]

    def points(self) -> list[Floats]:
        """Positions (states, 3) of the origins of all links and of the tip."""
        poses = np.asarray(self.robot.link_poses(self.q))[:, :, :3, 3]
        return [*np.moveaxis(poses, 1, 0), self.position(self.q)]


def check_jacobian(
    J: ArrayLike | Sequence[Sequence[str]],
    mechanism: RobotLike,
    q: ArrayLike | None = None,
    kind: Kind = "space",
    *,
    values: Mapping[str, float] | None = None,
    tolerance: float = 1e-6,
) -> Review:
    """Whether a Jacobian is that of the robot; if not, which column or entry is wrong and why.

    Args:
        J: (rows, n) numbers at q, or formulas as text in q1 .. qn (c12, s3, L1, a2 ... are understood). Six rows
            (omega, v), or of kind `tip` also three (x, y, z) or two (x, y).
        mechanism: the robot.
        q: (n,) configuration of a numerical J [rad | m]; formulas are compared at random ones.
        kind: `space`, `body`, or `tip`: velocity of the tip point in {s}.
        values: numbers of the student's own letters, besides those of `derive_fk`.
        tolerance: of every entry.

    Raises:
        InputError: another shape, numbers without q, a formula that cannot be read, an unknown kind.
    """
    mechanism = as_mechanism(mechanism)
    if kind not in KINDS:
        raise InputError("derivation.form", value=kind, known=", ".join(KINDS))
    if _is_text(J):
        return _check_formulas(cast("Sequence[Sequence[str]]", J), mechanism, kind, values or {}, tolerance)
    given = real_array("J", cast("ArrayLike", J))
    if q is None:
        raise InputError("derivation.q_missing")
    at = gate("q", q, (mechanism.n,), finite=True)[None]
    if given.shape == (mechanism.n, 6) and mechanism.n != 6:
        return Review((Finding(Slip.TRANSPOSED),))
    _require_shape(given.shape, mechanism.n, kind)
    truth = _Truth(mechanism, at, given.shape[0])
    return _compared(given[None], truth, kind, tolerance)


def _is_text(J: Any) -> bool:
    return (
        isinstance(J, list | tuple)
        and bool(J)
        and isinstance(J[0], list | tuple)
        and any(isinstance(x, str) for x in J[0])
    )


def _require_shape(shape: tuple[int, ...], n: int, kind: Kind) -> None:
    rows = (2, 3, 6) if kind == "tip" else (6,)
    if len(shape) != 2 or shape[0] not in rows or shape[1] != n:
        raise InputError("input.shape", name="J", expected=f"({' | '.join(map(str, rows))}, {n})", got=shape, hint="")


def _compared(J: Floats, truth: _Truth, kind: Kind, tolerance: float) -> Review:
    """Slips of the whole matrix, then of columns, then of entries; J (states, rows, n)."""
    right = truth.jacobian(kind)
    if _equal(J, right, tolerance):
        return Review()
    for slip, other in _whole(truth, kind):
        if _equal(J, other, tolerance):
            return Review((Finding(slip),))
    findings: list[Finding] = []
    for c in range(right.shape[2]):
        if not _equal(J[:, :, c], right[:, :, c], tolerance):
            findings += _column(J, right, truth, kind, c, tolerance)
    return Review(tuple(findings), proven=all(finding.slip is not Slip.VALUE for finding in findings))


def _whole(truth: _Truth, kind: Kind) -> Iterator[tuple[Slip, Floats]]:
    """What the matrix would be after each slip."""
    right = truth.jacobian(kind)
    for other in KINDS:
        if other != kind:
            yield Slip.FRAME, truth.jacobian(other)
    if truth.rows == 6:
        yield Slip.PARTS_SWAPPED, np.roll(right, 3, axis=1)
        yield Slip.CROSS_ORDER, np.concatenate([right[:, :3], -right[:, 3:]], axis=1)
    yield Slip.REVERSED, -right
    yield Slip.DEGREES, truth.jacobian(kind, np.degrees(truth.q))
    yield Slip.ZERO_CONFIGURATION, truth.jacobian(kind, np.zeros_like(truth.q))
    if right.shape[1] == right.shape[2]:
        yield Slip.TRANSPOSED, right.transpose(0, 2, 1)


def _column(J: Floats, right: Floats, truth: _Truth, kind: Kind, c: int, tolerance: float) -> list[Finding]:
    column = J[:, :, c]
    for slip, entry, other in _columns(right, truth, kind, c):
        if _equal(column, other, tolerance):
            return [Finding(slip, column=c + 1, entry=entry)]
    wrong = [r for r in range(J.shape[1]) if not _equal(column[:, r], right[:, r, c], tolerance)]
    return [
        Finding(
            Slip.SIGN if _equal(column[:, r], -right[:, r, c], tolerance) else Slip.VALUE,
            row=r + 1,
            column=c + 1,
            given=shown(float(column[0, r])),
            expected=shown(float(right[0, r, c])),
        )
        for r in wrong
    ]


def _columns(right: Floats, truth: _Truth, kind: Kind, c: int) -> Iterator[tuple[Slip, str, Floats]]:
    """What one column would be after each slip."""
    column = right[:, :, c]
    for point in truth.points():
        if truth.rows < 6:
            yield Slip.POSITION_VECTOR, "", point[:, : truth.rows]
        else:
            yield Slip.POSITION_VECTOR, "v", np.concatenate([column[:, :3], point], axis=1)
    if truth.rows == 6 and column[:, 3:].any():
        yield Slip.CROSS_ORDER, "v", np.concatenate([column[:, :3], -column[:, 3:]], axis=1)
        yield Slip.NO_MOMENT, "v", np.concatenate([column[:, :3], 0 * column[:, 3:]], axis=1)
        yield Slip.PARTS_SWAPPED, "", np.roll(column, 3, axis=1)
    yield Slip.REVERSED, "", -column
    for other in KINDS:
        if other != kind:
            yield Slip.FRAME, "", truth.jacobian(other)[:, :, c]
    yield Slip.ZERO_CONFIGURATION, "", truth.jacobian(kind, np.zeros_like(truth.q))[:, :, c]
    for k in range(right.shape[2]):
        if k != c:
            yield Slip.COLUMN_SWAPPED, "", right[:, :, k]


def _check_formulas(
    J: Sequence[Sequence[str]], mechanism: Mechanism, kind: Kind, letters: Mapping[str, float], tolerance: float
) -> Review:
    trees = [[parsed(str(entry)) for entry in row] for row in J]
    if len({len(row) for row in trees}) != 1:
        raise InputError("derivation.ragged")
    shape = (len(trees), len(trees[0]))
    if shape == (mechanism.n, 6) and mechanism.n != 6:
        return Review((Finding(Slip.TRANSPOSED),))
    _require_shape(shape, mechanism.n, kind)
    rng = np.random.default_rng(11)
    q = rng.uniform(-1.4, 1.4, (STATES, mechanism.n))
    names: dict[str, Any] = {**_letters(mechanism), **letters, **{f"q{i + 1}": q[:, i] for i in range(mechanism.n)}}
    truth = _Truth(mechanism, q, shape[0])
    numbers = np.stack([np.stack([_numbers(tree, names) for tree in row], axis=-1) for row in trees], axis=1)
    review = _compared(numbers, truth, kind, tolerance)
    right = truth.jacobian(kind)
    findings = tuple(_in_formula(finding, trees, right, names, mechanism.n, tolerance) for finding in review.findings)
    return Review(findings, proven=all(finding.slip is not Slip.VALUE for finding in findings))


def _letters(mechanism: Mechanism) -> dict[str, float]:
    """The robot's own letters, with and without underscore; none for a robot without a table."""
    try:
        found = symbolic_arm(mechanism).letters
    except ModelError:
        return {}
    return {spelled: value for name, value in found.items() for spelled in (name, name.replace("_", ""))}


def _in_formula(
    finding: Finding, trees: list[list[ast.expr]], right: Floats, names: Mapping[str, Any], n: int, tolerance: float
) -> Finding:
    """The finding of one entry with the slip inside its formula, if one change makes it right."""
    if finding.row is None or finding.column is None:
        return finding
    r, c = finding.row - 1, finding.column - 1
    tree, wanted = trees[r][c], right[:, r, c]
    for slip, changed in repaired(tree, n):
        if _equal(_numbers(changed, names), wanted, tolerance):
            return Finding(slip, finding.row, finding.column, given=ast.unparse(tree), expected=ast.unparse(changed))
    return Finding(Slip.VALUE, finding.row, finding.column, given=ast.unparse(tree), expected="")


def _numbers(tree: ast.expr, names: Mapping[str, Any]) -> Floats:
    with np.errstate(all="ignore"):
        return np.broadcast_to(np.asarray(evaluate(tree, names), dtype=np.float64), (STATES,))


def _equal(A: Floats, B: Floats, tolerance: float) -> bool:
    return A.shape == B.shape and bool(np.abs(A - B).max(initial=0.0) <= tolerance)
