"""A derivation as data: numbered steps of text and formulas, every formula with the error of its numerical check.

The first step of every derivation of an arm shows its frames, their table, and the numbers behind the letters.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import degrees, pi
from typing import Any, TypeAlias, TypeGuard

from mafsil.answer import Answer, Status
from mafsil.derivation.arm import NOTHING, SymbolicArm, SymbolicRow
from mafsil.derivation.expression import Expression
from mafsil.derivation.polynomial import Angle, Entries, Polynomial, constant, symbol
from mafsil.messages import say


@dataclass(frozen=True, slots=True)
class Name:
    """A letter with an index: T_03, z_2, det J."""

    letter: str
    index: str = ""


Product: TypeAlias = tuple[Name, ...]
"""Names side by side."""


@dataclass(frozen=True, slots=True, eq=False)
class Factors:
    """Formulas multiplied with each other, sums among them in brackets."""

    formulas: tuple[Polynomial, ...]


Side: TypeAlias = Product | Entries | Polynomial | Factors | Expression | str
"""One side of an equation: names, a matrix, a formula, a product of formulas, a tree, or text such as numbers."""


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """left = sides[0] = sides[1] ...

    Attributes:
        left: names.
        sides: what they equal.
        error: largest difference from the compiled robot over the random states; None for a definition.
    """

    left: Product
    sides: tuple[Side, ...]
    error: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """A table: head and rows, formulas or text in the cells."""

    head: tuple[Name | str, ...]
    rows: tuple[tuple[Polynomial | str, ...], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One numbered step.

    Attributes:
        key: of its sentence in the messages; details fill it.
        lines: its formulas.
        grid: a table between sentence and formulas, or None.
    """

    key: str
    details: Mapping[str, object] = field(default_factory=dict[str, object])
    lines: tuple[Line, ...] = ()
    grid: Grid | None = None


class DerivationStatus(Status):
    """Whether the lines of a derivation were compared with the robot; lines that differ raise `DerivationError`."""

    CHECKED = ("derivation.short_checked", True)
    TOO_LONG = ("derivation.short_too_long", False)
    """The formulas are too long to be written; the steps say how long."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Derivation(Answer, entries="steps", data="robot states worst_error"):
    """What the functions `derive_...` hand back, iterable over its steps; `to_text`, `to_latex`, `to_html` write it.

    Attributes:
        key: of the title's sentence.
        robot: name.
        steps: in order.
        states: number of random states at which every line was checked.
        checked: key of the sentence that says against what.
    """

    key: str
    robot: str
    steps: tuple[Step, ...]
    states: int
    checked: str = "derivation.checked"

    @property
    def status(self) -> DerivationStatus:
        """Whether its lines were compared with the robot."""
        return DerivationStatus.CHECKED if self.states else DerivationStatus.TOO_LONG

    def explain(self, language: str | None = None) -> str:
        """The title, the number of steps, and how the lines were checked."""
        title = say(self.key, language=language, robot=self.robot)
        error = f"{self.worst_error:.1e}"
        checked = say(self.checked, language=language, states=self.states, error=error) if self.states else ""
        return self.status.sentence(language, title=title, steps=len(self.steps), checked=checked)

    def to_dict(self) -> dict[str, Any]:
        """Plain data: the sentence of every step with its details, and the error of its lines."""
        steps = [
            {
                "sentence": say(step.key, language=None, **dict(step.details)),
                "lines": len(step.lines),
                "error": max((line.error for line in step.lines if line.error is not None), default=None),
            }
            for step in self.steps
        ]
        return Answer.to_dict(self) | {"steps": steps}

    @property
    def worst_error(self) -> float:
        """Largest error of all lines."""
        return max((line.error for line in self.lines if line.error is not None), default=0.0)

    @property
    def lines(self) -> tuple[Line, ...]:
        """All formulas."""
        return tuple(line for step in self.steps for line in step.lines)


def is_matrix(side: Side) -> TypeGuard[Entries]:
    """Whether a side is a matrix of formulas."""
    return isinstance(side, tuple) and bool(side) and isinstance(side[0], tuple) and not isinstance(side[0], Name)


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
