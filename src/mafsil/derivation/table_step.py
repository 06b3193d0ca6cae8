"""First step of every derivation: the frames, their table, and the numbers behind the letters."""

from __future__ import annotations

from math import degrees, pi

from mafsil.derivation.arm import NOTHING, SymbolicArm, SymbolicRow
from mafsil.derivation.document import Grid, Line, Name, Step
from mafsil.derivation.polynomial import Angle, Polynomial, constant, symbol

HEAD = (Name("i"), Name("α", "i−1"), Name("a", "i−1"), Name("d", "i"), Name("θ", "i"))
CLASSIC_HEAD = (Name("i"), Name("θ", "i"), Name("d", "i"), Name("a", "i"), Name("α", "i"))


def table_step(arm: SymbolicArm) -> Step:
    """The Denavit-Hartenberg table in letters, and what the letters stand for.

    Args:
        arm: in letters.
    """
    if arm.classic is not None:
        return Step("derivation.table_classic", {"robot": arm.mechanism.name}, _letters(arm), _classic_grid(arm))
    rows = tuple((str(i), *_cells(row)) for i, row in enumerate(arm.rows, start=1))
    return Step("derivation.table", {"robot": arm.mechanism.name}, _letters(arm), Grid(HEAD, rows))


def _classic_grid(arm: SymbolicArm) -> Grid:
    """theta, d, a, alpha: the order in which they act."""
    assert arm.classic is not None
    rows: list[tuple[Polynomial | str, ...]] = []
    for i, (row, end) in enumerate(zip(arm.rows, arm.classic.ends, strict=True), start=1):
        _, _, d, theta = _cells(row)
        rows.append((str(i), theta, d, end.p[0], _twist_cell(arm, i)))
    return Grid(CLASSIC_HEAD, tuple(rows))


def _twist_cell(arm: SymbolicArm, i: int) -> Polynomial | str:
    """Alpha_i of a classic table."""
    if i < arm.n:
        row = arm.rows[i]
        return _angle_cell(row.alpha, row.alpha_quarters)
    name = f"alpha{i}"
    return (
        symbol(name)
        if name in arm.letters
        else _degrees(90 * ((round(arm.shown_table.rows[-1].alpha / (pi / 2)) + 1) % 4 - 1))
    )


def _with_offsets(arm: SymbolicArm) -> list[tuple[SymbolicRow, float]]:
    return list(zip(arm.rows, arm.offsets, strict=True))


def _cells(row: SymbolicRow) -> tuple[Polynomial | str, ...]:
    alpha = _angle_cell(row.alpha, row.alpha_quarters)
    if row.row.kind == "P":
        return alpha, row.a, row.d, _angle_cell(row.theta, row.theta_quarters)
    name = row.theta[0][0]
    turned = _degrees(90 * ((row.theta_quarters + 1) % 4 - 1))
    return alpha, row.a, row.d, f"{name}{'' if turned == '0' else turned if turned[0] == '−' else '+' + turned}"


def _angle_cell(angle: Angle, quarters: int) -> Polynomial | str:
    return symbol(angle[0][0]) if angle else _degrees(90 * ((quarters + 1) % 4 - 1))


def _degrees(value: int) -> str:
    return f"{value}°".replace("-", "−") if value else "0"


def _letters(arm: SymbolicArm) -> tuple[Line, ...]:
    """Definitions: numbers of the lengths and twists, joint angles with constant offsets."""
    lines: list[Line] = []
    lines += [letter_line(name, value) for name, value in arm.letters.items()]
    for i, (row, offset) in enumerate(_with_offsets(arm), start=1):
        if row.row.kind == "R":
            turned = symbol(f"q{i}") if abs(offset) < NOTHING else symbol(f"q{i}") + constant(offset)
            lines.append(Line((Name(f"theta{i}"),), (turned,)))
    return tuple(lines)


def letter_line(name: str, value: float) -> Line:
    """The number of a letter: an angle in degrees, a pitch per radian, a length.

    Args:
        name: of the letter.
        value: [rad | m/rad | m].
    """
    if name.startswith(("alpha", "theta")):
        number = f"{degrees(value):.10g}°"
    else:
        number = f"{round(value, 12):.10g} {'m/rad' if name.startswith('h') else 'm'}"
    return Line((Name(name),), (number.replace("-", "−"),))
