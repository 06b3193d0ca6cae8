"""A derivation as data: numbered steps of text and formulas, every formula with the error of its numerical check."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias, TypeGuard

from mafsil.answer import Answer, Status
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
