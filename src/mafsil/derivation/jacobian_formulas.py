"""The entries of a robot's Jacobian as text, for the sentence that says what should stand there."""

from __future__ import annotations

from collections.abc import Collection

from mafsil.derivation.arm import SymbolicArm, symbolic_arm
from mafsil.derivation.jacobian import space_columns, tip_columns
from mafsil.derivation.matrices import Row, plus, transform, transpose
from mafsil.derivation.matrices import cross as moment
from mafsil.derivation.text import formula
from mafsil.errors import ModelError
from mafsil.model import Mechanism

MOST_JOINTS = 7
"""Formulas of longer chains are longer than what a sentence holds."""
LONGEST = 400
"""Characters of one entry."""


def expected_formulas(
    mechanism: Mechanism, kind: str, rows: int, columns: Collection[int]
) -> dict[int, tuple[str, ...]]:
    """The entries of some columns; nothing where they are too long or the arm has no letters.

    Args:
        mechanism: the robot.
        kind: `space`, `body` or `tip`.
        rows: 6, or 3 or 2 of the tip's velocity.
        columns: numbers from 1, in the order of q.
    """
    try:
        arm = symbolic_arm(mechanism, None)
    except ModelError:
        return {}
    if arm.n > MOST_JOINTS:
        return {}
    found = {arm.coordinates[i] + 1: column for i, column in enumerate(_columns(arm, kind, rows))}
    zero = ("0",) * rows
    texts = {c: tuple(formula(x) for x in found[c]) if c in found else zero for c in set(columns)}
    return {c: text for c, text in texts.items() if max(map(len, text)) <= LONGEST}


def _columns(arm: SymbolicArm, kind: str, rows: int) -> tuple[Row, ...]:
    space = space_columns(arm)
    if kind == "space":
        return space
    if kind == "tip":
        moved = tip_columns(arm)
        return tuple((*column[:3], *p) if rows == 6 else p[:rows] for column, p in zip(space, moved, strict=True))
    tip = arm.poses()[-1]
    turned = transpose(tip.R)
    return tuple(
        (*transform(turned, column[:3]), *transform(turned, plus(column[3:], moment(column[:3], tip.p))))
        for column in space
    )
