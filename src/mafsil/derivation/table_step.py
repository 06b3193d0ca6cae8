"""First step of every derivation: the frames, their table, and the numbers behind the letters."""

from __future__ import annotations

from math import degrees

from mafsil.derivation.arm import NOTHING, SymbolicArm, SymbolicRow
from mafsil.derivation.document import Grid, Line, Name, Step
from mafsil.derivation.polynomial import Angle, Polynomial, constant, symbol

HEAD = (Name("i"), Name("α", "i−1"), Name("a", "i−1"), Name("d", "i"), Name("θ", "i"))


def table_step(arm: SymbolicArm) -> Step:
    """The Denavit-Hartenberg table in letters, and what the letters stand for.

    Args:
        arm: in letters.
    """
    rows = tuple((str(i), *_cells(row, offset)) for i, (row, offset) in enumerate(_with_offsets(arm), start=1))
    return Step("derivation.table", {"robot": arm.mechanism.name}, _letters(arm), Grid(HEAD, rows))


def _with_offsets(arm: SymbolicArm) -> list[tuple[SymbolicRow, float]]:
    return list(zip(arm.rows, arm.offsets, strict=True))


def _cells(row: SymbolicRow, offset: float) -> tuple[Polynomial | str, ...]:
    alpha = _angle_cell(row.alpha, row.alpha_quarters)
    if row.row.kind == "P":
        return alpha, row.a, row.d, _angle_cell(row.theta, row.theta_quarters)
    name = row.theta[0][0]
    turned = _degrees(90 * ((row.theta_quarters + 1) % 4 - 1))
    del offset
    return alpha, row.a, row.d, f"{name}{'' if turned == '0' else turned if turned[0] == '−' else '+' + turned}"


def _angle_cell(angle: Angle, quarters: int) -> Polynomial | str:
    return symbol(angle[0][0]) if angle else _degrees(90 * ((quarters + 1) % 4 - 1))


def _degrees(value: int) -> str:
    return f"{value}°".replace("-", "−") if value else "0"


def _letters(arm: SymbolicArm) -> tuple[Line, ...]:
    """Definitions: numbers of the lengths and twists, joint angles with constant offsets."""
    lines: list[Line] = []
    for name, value in arm.letters.items():
        angle = name.startswith(("alpha", "theta"))
        number = f"{degrees(value):.10g}°" if angle else f"{round(value, 12):.10g} m"
        lines.append(Line((Name(name),), (number.replace("-", "−"),)))
    for i, (row, offset) in enumerate(_with_offsets(arm), start=1):
        if row.row.kind == "R":
            turned = symbol(f"q{i}") if abs(offset) < NOTHING else symbol(f"q{i}") + constant(offset)
            lines.append(Line((Name(f"theta{i}"),), (turned,)))
    return tuple(lines)
