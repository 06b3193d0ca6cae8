"""The honest result of a computation that may fail: a value, a status with its sentence, a residual."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, frozen

Value = TypeVar("Value")


class SolverStatus(Status):
    """How an iteration ended."""

    CONVERGED = ("solvers.converged", True)
    STALLED = ("solvers.stalled", False)
    BUDGET_SPENT = ("solvers.budget_spent", False)
    NOT_FINITE = ("solvers.not_finite", False)


@dataclass(frozen=True, slots=True, repr=False)
class Outcome(Answer, Generic[Value], data="value residual iterations details"):
    """The result of a solver; true if it succeeded.

    Attributes:
        value: the answer, or the best that was reached.
        status: how it ended; `status.succeeded` says whether the value is an answer.
        residual: size of what is left of the equation, recomputed at `value`.
        iterations: number of steps made.
        history: (iterations + 1,) residual before the first and after each step; may be empty.
        details: what the status's sentence mentions besides residual and iterations.
    """

    value: Value
    status: Status
    residual: float = 0.0
    iterations: int = 0
    history: Floats = field(default_factory=lambda: frozen([]))
    details: Mapping[str, object] = field(default_factory=dict[str, object])

    @property
    def succeeded(self) -> bool:
        """Whether the value is an answer."""
        return self.status.succeeded

    def explain(self, language: str | None = None) -> str:
        """One sentence: how it ended and why."""
        known = {"residual": self.residual, "iterations": self.iterations, **self.details}
        return self.status.sentence(language, **known)
