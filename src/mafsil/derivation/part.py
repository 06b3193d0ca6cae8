"""One summand of a formula on paper: number, factors, and perhaps a bracket."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from typing import Any

from mafsil.derivation.polynomial import Factor, Values, factor_value


@dataclass(frozen=True, slots=True)
class Part:
    """One summand: number, factors, a bracket or nothing, and factors behind the bracket."""

    number: float
    factors: tuple[Factor, ...]
    bracket: tuple[Part, ...] = ()
    behind: tuple[Factor, ...] = ()

    def evaluate(self, values: Values) -> Any:
        """The number, or array of numbers."""
        total: Any = self.number
        for factor in (*self.factors, *self.behind):
            total = total * factor_value(factor, values)
        return total * evaluate(self.bracket, values) if self.bracket else total


def powers(factors: tuple[Factor, ...]) -> tuple[tuple[Factor, int], ...]:
    """Factors with how often they stand side by side."""
    return tuple((factor, len(list(same))) for factor, same in groupby(factors))


def evaluate(parts: tuple[Part, ...], values: Values) -> Any:
    """The sum of the summands."""
    return sum((part.evaluate(values) for part in parts), start=0.0)
