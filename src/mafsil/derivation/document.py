"""A derivation as data: numbered steps of text and formulas, every formula with the error of its numerical check."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeAlias, TypeGuard

from mafsil.derivation.expression import Expression
from mafsil.derivation.matrices import Entries
from mafsil.derivation.polynomial import Polynomial
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


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Derivation:
    """What the functions `derive_...` hand back; `to_text`, `to_latex` and `to_html` write it.

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

    def __repr__(self) -> str:
        title, checked = say(self.key, robot=self.robot), ""
        if self.states:
            checked = say(self.checked, states=self.states, error=f"{self.worst_error:.1e}")
        return say("derivation.short", title=title, steps=len(self.steps), checked=checked).strip()

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
