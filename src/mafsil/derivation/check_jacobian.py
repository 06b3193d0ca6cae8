"""A student's Jacobian, in numbers or as formulas, against the robot: which entry is wrong, by which mistake.

Formulas are held against the robot as it is and against arms of the same structure with other lengths, so that L1 in
the place of L2, or no letter at all, is found although both may be 1 m long.

Mistakes inside a formula: every term's sign, every sine and cosine, every angle is changed in turn.
"""

from __future__ import annotations

import ast
import copy
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any, Literal, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, not_negative, number, real_array
from mafsil.derivation.formula_text import CompiledArm, Reading, Truth, evaluate, parse_formula, readings_of
from mafsil.derivation.jacobian import expected_formulas
from mafsil.derivation.review import Finding, Mistake, Review, shown
from mafsil.errors import InputError
from mafsil.model import Mechanism
from mafsil.model.loading import RobotLike, as_mechanism

_SHORT = re.compile(r"^([cs])(_?)(\d{1,9})$")
Kind: TypeAlias = Literal["space", "body", "tip"]
KINDS = ("space", "body", "tip")
STATES, KEPT = 16, 6
"""States at which formulas are compared, and how many of them have the robot's own lengths."""


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
        mechanism: a Robot, a Mechanism, a name of the library or a path.
        q: (n,) configuration of a numerical J [rad | m]; formulas are compared at random ones, and with other lengths
            than the robot's wherever they have letters.
        kind: `space`, `body`, or `tip`: velocity of the tip point in {s}.
        values: numbers of the student's own letters, besides those of `derive_fk`.
        tolerance: of every entry.

    Raises:
        InputError: another shape, numbers without q, a formula that cannot be read, an unknown kind.
    """
    tolerance = not_negative("tolerance", tolerance)
    if kind not in KINDS:
        raise InputError("derivation.form", value=kind, known=", ".join(KINDS))
    mechanism = as_mechanism(mechanism)
    if _is_text(J):
        return _check_formulas(cast("Sequence[Sequence[str]]", J), mechanism, kind, _number(values or {}), tolerance)
    given = real_array("J", cast("ArrayLike", J))
    if q is None:
        raise InputError("derivation.q_missing")
    at = as_batch("q", q, (mechanism.n,), finite=True)[None]
    if given.shape == (mechanism.n, 6) and mechanism.n != 6:
        return Review((Finding(Mistake.TRANSPOSED),))
    _require_shape(given.shape, mechanism.n, kind)
    return _compare(given[None], Truth(CompiledArm(mechanism), at, given.shape[0]), kind, tolerance)


def _is_text(J: Any) -> bool:
    if not isinstance(J, list | tuple):
        return False
    rows = cast("Sequence[Any]", J)
    return bool(rows) and isinstance(rows[0], list | tuple) and any(isinstance(x, str) for row in rows for x in row)


def _require_shape(shape: tuple[int, ...], n: int, kind: Kind) -> None:
    rows = (2, 3, 6) if kind == "tip" else (6,)
    if len(shape) != 2 or shape[0] not in rows or shape[1] != n:
        raise InputError("input.shape", name="J", expected=f"({' | '.join(map(str, rows))}, {n})", got=shape, hint="")


def _compare(J: Floats, truth: Truth, kind: Kind, tolerance: float) -> Review:
    """Mistakes of the whole matrix, then of columns, then of entries; J (states, rows, n)."""
    right = truth.jacobian(kind)
    if _equal(J, right, tolerance):
        return Review()
    for mistake, other in _whole(truth, kind):
        if _equal(J, other, tolerance):
            return Review((Finding(mistake),))
    findings: list[Finding] = []
    for c in range(right.shape[2]):
        if not _equal(J[:, :, c], right[:, :, c], tolerance):
            findings += _column(J, right, truth, kind, c, tolerance)
    return Review(tuple(findings), proven=all(finding.mistake is not Mistake.VALUE for finding in findings))


def _whole(truth: Truth, kind: Kind) -> Iterator[tuple[Mistake, Floats]]:
    """What the matrix would be after each mistake."""
    right = truth.jacobian(kind)
    for other in KINDS:
        if other != kind:
            yield Mistake.FRAME, truth.jacobian(other)
    if truth.rows == 6:
        yield Mistake.PARTS_SWAPPED, np.roll(right, 3, axis=1)
        yield Mistake.CROSS_ORDER, np.concatenate([right[:, :3], -right[:, 3:]], axis=1)
    yield Mistake.REVERSED, -right
    yield Mistake.DEGREES, truth.jacobian(kind, np.degrees(truth.q))
    yield Mistake.ZERO_CONFIGURATION, truth.jacobian(kind, np.zeros_like(truth.q))
    if right.shape[1] == right.shape[2]:
        yield Mistake.TRANSPOSED, right.transpose(0, 2, 1)


def _column(J: Floats, right: Floats, truth: Truth, kind: Kind, c: int, tolerance: float) -> list[Finding]:
    column = J[:, :, c]
    wrong = [r for r in range(J.shape[1]) if not _equal(column[:, r], right[:, r, c], tolerance)]
    for mistake, entry, other in _columns(right, truth, kind, c):
        if _equal(column, other, tolerance):
            return [Finding(mistake, column=c + 1, entry=entry)]
    return [
        Finding(
            Mistake.SIGN if _equal(column[:, r], -right[:, r, c], tolerance) else Mistake.VALUE,
            row=r + 1,
            column=c + 1,
            given=shown(float(column[0, r])),
            expected=shown(float(right[0, r, c])),
        )
        for r in wrong
    ]


def _columns(right: Floats, truth: Truth, kind: Kind, c: int) -> Iterator[tuple[Mistake, str, Floats]]:
    """What one column would be after each mistake."""
    column = right[:, :, c]
    for point in truth.points():
        if not point.any():
            # A zero where the moment belongs is no point, it is no moment.
            continue
        if truth.rows < 6:
            yield Mistake.POSITION_VECTOR, "", point[:, : truth.rows]
        else:
            yield Mistake.POSITION_VECTOR, "v", np.concatenate([column[:, :3], point], axis=1)
    if truth.rows == 6 and column[:, 3:].any():
        yield Mistake.CROSS_ORDER, "v", np.concatenate([column[:, :3], -column[:, 3:]], axis=1)
        yield Mistake.NO_MOMENT, "v", np.concatenate([column[:, :3], 0 * column[:, 3:]], axis=1)
        yield Mistake.PARTS_SWAPPED, "", np.roll(column, 3, axis=1)
    yield Mistake.REVERSED, "", -column
    for other in KINDS:
        if other != kind:
            yield Mistake.FRAME, "", truth.jacobian(other)[:, :, c]
    yield Mistake.ZERO_CONFIGURATION, "", truth.jacobian(kind, np.zeros_like(truth.q))[:, :, c]
    for k in range(right.shape[2]):
        if k != c:
            yield Mistake.COLUMN_SWAPPED, "", right[:, :, k]


def _number(values: Mapping[str, float]) -> dict[str, float]:
    return {name: number(f"values[{name!r}]", value) for name, value in values.items()}


def _check_formulas(
    J: Sequence[Sequence[str]], mechanism: Mechanism, kind: Kind, own: Mapping[str, float], tolerance: float
) -> Review:
    trees = [[parse_formula(str(entry)) for entry in row] for row in J]
    if len({len(row) for row in trees}) != 1:
        raise InputError("derivation.ragged")
    shape = (len(trees), len(trees[0]))
    if shape == (mechanism.n, 6) and mechanism.n != 6:
        return Review((Finding(Mistake.TRANSPOSED),))
    _require_shape(shape, mechanism.n, kind)
    rng = np.random.default_rng(11)
    q = rng.uniform(-1.4, 1.4, (STATES, mechanism.n))
    reviews: list[Review] = []
    for reading in readings_of(mechanism, trees, own, q, KEPT, rng):
        reviews.append(_read(trees, reading, kind, tolerance))
        if reviews[-1].correct:
            return reviews[-1]
    best = min(reviews, key=lambda review: (not review.proven, len(review.findings)))
    return _with_expected(best, mechanism, kind, shape[0])


def _read(trees: list[list[ast.expr]], reading: Reading, kind: Kind, tolerance: float) -> Review:
    """The review of the formulas, their letters read in one way."""
    n = len(trees[0])
    truth = Truth(reading.arm, reading.q, len(trees))
    names = reading.names
    numbers = np.stack([np.stack([_numbers(tree, names) for tree in row], axis=-1) for row in trees], axis=1)
    review = _compare(numbers, truth, kind, tolerance)
    right = truth.jacobian(kind)
    findings = tuple(_in_formula(finding, trees, right, reading, n, tolerance) for finding in review.findings)
    return Review(findings, proven=all(finding.mistake is not Mistake.VALUE for finding in findings))


def _in_formula(
    finding: Finding, trees: list[list[ast.expr]], right: Floats, reading: Reading, n: int, tolerance: float
) -> Finding:
    """The finding of one entry with the mistake inside its formula, if one change makes it right."""
    if finding.row is None or finding.column is None:
        return finding
    r, c = finding.row - 1, finding.column - 1
    tree, right_entry = trees[r][c], right[:, r, c]
    given = ast.unparse(tree)
    for mistake, changed in one_mistake_repairs(tree, n, reading.letters):
        if _equal(_numbers(changed, reading.names), right_entry, tolerance):
            return Finding(mistake, finding.row, finding.column, given=given, expected=ast.unparse(changed))
    here = _equal(_numbers(tree, reading.names)[:KEPT], right_entry[:KEPT], tolerance)
    at = ", ".join(shown(float(x)) for x in reading.q[0])
    expected = f"{shown(float(right_entry[0]))} (q = ({at}))"
    return replace(finding, mistake=Mistake.LENGTHS if here else Mistake.VALUE, given=given, expected=expected)


def _with_expected(review: Review, mechanism: Mechanism, kind: Kind, rows: int) -> Review:
    """Where no mistake gave the right formula, ours stands there."""
    columns = [f.column for f in review.findings if f.column is not None and _needs_formula(f)]
    formulas = expected_formulas(mechanism, kind, rows, columns) if columns else {}
    findings: list[Finding] = []
    for finding in review.findings:
        column = formulas.get(finding.column or 0)
        if column is None or not _needs_formula(finding):
            findings.append(finding)
        else:
            text = column[finding.row - 1] if finding.row is not None else "(" + ", ".join(column) + ")"
            findings.append(replace(finding, expected=text))
    return replace(review, findings=tuple(findings))


def _needs_formula(finding: Finding) -> bool:
    return finding.row is None or finding.mistake in (Mistake.VALUE, Mistake.LENGTHS)


def _numbers(tree: ast.expr, names: Mapping[str, Any]) -> Floats:
    with np.errstate(all="ignore"):
        return np.broadcast_to(np.asarray(evaluate(tree, names), dtype=np.float64), (STATES,))


def _equal(A: Floats, B: Floats, tolerance: float) -> bool:
    return A.shape == B.shape and bool(np.abs(A - B).max(initial=0.0) <= tolerance)


def one_mistake_repairs(
    tree: ast.expr, joints: int, letters: Collection[str] = ()
) -> Iterator[tuple[Mistake, ast.expr]]:
    """Formulas that differ from the given one by one mistake.

    Args:
        tree: of the formula.
        joints: number of joints, for angles with one more or one less.
        letters: of the arm's lengths, for one in the place of another.
    """
    yield Mistake.SIGN, ast.UnaryOp(ast.USub(), tree)
    yield Mistake.SINE_COSINE, _rename(tree, {"sin": "cos", "cos": "sin"}, {"s": "c", "c": "s"})
    places = list(ast.walk(tree))
    for index, node in enumerate(places):
        for mistake, changed in _change(node, joints):
            yield mistake, _with(tree, index, changed)
    yield from _exchange(tree, letters)


def _exchange(tree: ast.expr, letters: Collection[str]) -> Iterator[tuple[Mistake, ast.expr]]:
    """One length for another at one place, or two lengths for each other everywhere."""
    used = [node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and node.id in letters]
    for index, node in enumerate(ast.walk(tree)):
        if isinstance(node, ast.Name) and node.id in letters:
            for other in letters:
                if other != node.id:
                    yield Mistake.LETTER, _with(tree, index, ast.Name(other))
    for one, two in combinations(sorted(set(used)), 2):
        yield Mistake.LETTER, _rename(tree, {one: two, two: one}, {})


def _rename(tree: ast.expr, names: dict[str, str], short: dict[str, str]) -> ast.expr:
    """A copy with names exchanged, and with the first letters of c12 and s3 exchanged."""
    copied = copy.deepcopy(tree)
    for node in ast.walk(copied):
        if isinstance(node, ast.Name):
            node.id = names.get(node.id, node.id)
            found = _SHORT.match(node.id)
            if found and short:
                node.id = short[found[1]] + found[2] + found[3]
    return copied


def _change(node: ast.AST, joints: int) -> Iterator[tuple[Mistake, ast.AST]]:
    match node:
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            yield Mistake.TERM_SIGN, ast.BinOp(left, ast.Sub(), right)
        case ast.BinOp(left=left, op=ast.Sub(), right=right):
            yield Mistake.TERM_SIGN, ast.BinOp(left, ast.Add(), right)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            yield Mistake.TERM_SIGN, operand
        case ast.Call(func=ast.Name(id="sin" | "cos" as name), args=arguments):
            other = "cos" if name == "sin" else "sin"
            yield Mistake.SINE_COSINE, ast.Call(ast.Name(other), arguments, [])
        case ast.Name(id=name):
            yield from ((mistake, ast.Name(text)) for mistake, text in _names(name, joints))
        case ast.BinOp(op=ast.Mult()):
            yield Mistake.TERM_SIGN, ast.UnaryOp(ast.USub(), node)
        case _:
            return


def _names(name: str, joints: int) -> Iterator[tuple[Mistake, str]]:
    """c12 for s12, and c1, c2, c123 for c12."""
    short = _SHORT.match(name)
    if not short:
        return
    letter, line, digits = short.groups()
    yield Mistake.SINE_COSINE, f"{'c' if letter == 's' else 's'}{line}{digits}"
    runs = {
        "".join(str(k) for k in range(first, last + 1))
        for first in range(1, joints + 1)
        for last in range(first, joints + 1)
    }
    for run in sorted(runs - {digits}):
        yield Mistake.ANGLE, f"{letter}{line}{run}"


def _with(tree: ast.expr, index: int, node: ast.AST) -> ast.expr:
    """A copy of the tree with the node of that index (in the order of `ast.walk`) replaced."""
    whole = ast.Expression(copy.deepcopy(tree))
    target = list(ast.walk(whole.body))[index]
    for parent in ast.walk(whole):
        for field, value in ast.iter_fields(parent):
            if value is target:
                setattr(parent, field, node)
            elif isinstance(value, list):
                children = cast("list[ast.AST]", value)
                if target in children:
                    children[children.index(target)] = node
    return whole.body
