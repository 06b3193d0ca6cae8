"""Polynomials as a person writes them: common factors in front of brackets; in dynamics one bracket a mass.

Terms that share all but the mass stand together, (m1 + m2) L1^2 + m2 (L2^2 + 2 L1 L2 c2) rather than factors in the
order of their frequency. A part is one summand of a formula on paper: number, factors, and perhaps a bracket.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import groupby
from typing import Any

from mafsil.derivation.polynomial import (
    RATES,
    Factor,
    Monomial,
    Polynomial,
    Symbol,
    Values,
    collect_terms,
    factor_value,
    rank,
)

Terms = Mapping[Monomial, float]


def is_inertial(factor: Factor) -> bool:
    """Whether a factor is a mass m_k or an inertia I_k."""
    return isinstance(factor, Symbol) and factor.name[0] in "mI" and factor.name[1:2] in "_123456789"


def has_inertia(polynomial: Polynomial) -> bool:
    """Whether any term holds a mass or an inertia."""
    return any(is_inertial(factor) for monomial in polynomial.terms for factor in monomial)


def group_summands(polynomial: Polynomial) -> tuple[Part, ...]:
    """Summands grouped by accelerations, then what goes with rates, then the rest; within each by masses.

    Args:
        polynomial: with masses and inertias in at most first power, else the terms stand one by one.
    """
    accelerated: dict[Factor, dict[Monomial, float]] = {}
    moving: dict[Monomial, float] = {}
    still: dict[Monomial, float] = {}
    for monomial, number in polynomial.terms.items():
        gains = [factor for factor in monomial if _is_rate(factor, "dd")]
        if len(gains) == 1:
            accelerated.setdefault(gains[0], {})[_without(monomial, (gains[0],))] = number
        else:
            (moving if any(_is_rate(factor) for factor in monomial) else still)[monomial] = number
    parts = [_accelerate(gain, terms) for gain, terms in sorted(accelerated.items(), key=lambda pair: rank(pair[0]))]
    return (*parts, *_by_mass(moving), *_by_mass(still))


def _is_rate(factor: Factor, start: str = "d") -> bool:
    letter = factor.name.rstrip("0123456789") if isinstance(factor, Symbol) else ""
    return letter in RATES and letter.startswith(start)


def _accelerate(gain: Factor, terms: Terms) -> Part:
    """[m_ij] qdd_j."""
    inside = _by_mass(terms)
    if len(inside) > 1:
        return Part(1.0, (), tuple(inside), (gain,))
    only = inside[0]
    if not only.bracket:
        return Part(only.number, (*only.factors, gain))
    return Part(only.number, only.factors, only.bracket, (*only.behind, gain))


def _by_mass(terms: Terms) -> list[Part]:
    split = [(*_split(monomial), number) for monomial, number in terms.items()]
    if any(len(inertial) != 1 for inertial, _, _ in split):
        return _bracket(terms)
    sharers: dict[tuple[Monomial, float], list[Factor]] = {}
    for inertial, rest, number in split:
        sharers.setdefault((rest, number), []).append(inertial[0])
    shared = {key: masses for key, masses in sharers.items() if len(masses) > 1 and key[0]}
    parts = [_several(masses, rest, number) for (rest, number), masses in shared.items()]
    by_mass: dict[Factor, dict[Monomial, float]] = {}
    for inertial, rest, number in split:
        if (rest, number) not in shared:
            by_mass.setdefault(inertial[0], {})[rest] = number
    for mass, behind in sorted(by_mass.items(), key=lambda pair: rank(pair[0])):
        parts.append(_behind(mass, behind))
    return parts


def _split(monomial: Monomial) -> tuple[Monomial, Monomial]:
    return tuple(f for f in monomial if is_inertial(f)), tuple(f for f in monomial if not is_inertial(f))


def _several(masses: Iterable[Factor], rest: Monomial, number: float) -> Part:
    """(m1 + m2) rest."""
    bracket = tuple(Part(1.0, (mass,)) for mass in sorted(masses, key=rank))
    return Part(number, (), bracket, rest)


def _behind(mass: Factor, terms: Terms) -> Part:
    """Mass times common factors, rates not among them, times a bracket of what is left."""
    common = tuple(factor for factor in _common(terms) if not _is_rate(factor))
    inside = {_without(monomial, common): number for monomial, number in terms.items()}
    if len(inside) == 1:
        ((rest, number),) = inside.items()
        return Part(number, tuple(sorted((mass, *common, *rest), key=rank)))
    size = 0.5 if any(abs(number) == 0.5 for number in inside.values()) else 1.0
    sign = -size if all(number < 0 for number in inside.values()) else size
    bracket = _inside({monomial: number / sign for monomial, number in inside.items()})
    return Part(sign, tuple(sorted((mass, *common), key=rank)), tuple(bracket))


def _inside(terms: Terms) -> list[Part]:
    """Terms of a bracket, by their rates or by what stands before them, whichever gives fewer groups."""
    by_rate: dict[Monomial, dict[Monomial, float]] = {}
    by_rest: dict[Monomial, dict[Monomial, float]] = {}
    for monomial, number in terms.items():
        rate = tuple(factor for factor in monomial if _is_rate(factor))
        rest = _without(monomial, rate)
        by_rate.setdefault(rate, {})[rest] = number
        by_rest.setdefault(rest, {})[rate] = number
    fewer, rates_behind = (by_rate, True) if len(by_rate) < len(by_rest) else (by_rest, False)
    if set(by_rate) == {()} or len(fewer) == len(terms):
        return [Part(number, monomial) for monomial, number in terms.items()]
    if set(fewer) == {()}:
        return [Part(number, monomial) for monomial, number in terms.items()]
    return [_one_group(shared, others, rates_behind) for shared, others in fewer.items()]


def _one_group(shared: Monomial, others: Terms, rates_behind: bool) -> Part:
    """(others) shared with rates behind, or shared (others) with rates inside."""
    if len(others) == 1:
        ((rest, number),) = others.items()
        return Part(number, tuple(sorted((*shared, *rest), key=rank)))
    whole = all(number % 2 == 0 for number in others.values())
    size = 2.0 if whole else 1.0
    sign = -size if all(number < 0 for number in others.values()) else size
    bracket = tuple(Part(number / sign, rest) for rest, number in others.items())
    return Part(sign, (), bracket, shared) if rates_behind else Part(sign, shared, bracket)


def _bracket(terms: Terms) -> list[Part]:
    """Terms of a determinant and the like: common factors of all in front."""
    common = _common(terms)
    if not common or len(terms) < 2:
        return [Part(number, monomial) for monomial, number in terms.items()]
    bracket = tuple(Part(number, _without(monomial, common)) for monomial, number in terms.items())
    return [Part(1.0, common, bracket)]


def _common(terms: Terms) -> Monomial:
    """Factors of all terms, with their smallest power."""
    counts = [Counter(monomial) for monomial in terms]
    shared = counts[0]
    for count in counts[1:]:
        shared = shared & count
    return tuple(sorted(shared.elements(), key=rank))


def _without(monomial: Monomial, common: Monomial) -> Monomial:
    rest = list(monomial)
    for factor in common:
        rest.remove(factor)
    return tuple(rest)


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


def factor_out(polynomial: Polynomial) -> tuple[Part, ...]:
    """Summands with the most frequent common factors taken out, first those of most terms; masses in front of all."""
    if has_inertia(polynomial):
        return group_summands(polynomial)
    common = _most_frequent(polynomial)
    if common is None:
        return tuple(Part(number, monomial) for monomial, number in polynomial.terms.items())
    inside = {m: x for m, x in polynomial.terms.items() if common in m}
    outside = Polynomial({m: x for m, x in polynomial.terms.items() if common not in m})
    bracket = factor_out(collect_terms((_divide(m, common), x) for m, x in inside.items()))
    first = next(iter(polynomial.terms))
    here = _in_front(common, bracket)
    rest = factor_out(outside)
    return (here, *rest) if common in first else (*rest, here)


def _most_frequent(polynomial: Polynomial) -> Factor | None:
    """The factor of most terms, at least two; of equally frequent ones the first on paper."""
    counts = Counter(factor for monomial in polynomial.terms for factor in set(monomial))
    best = min(counts, key=lambda f: (-counts[f], isinstance(f, Symbol), rank(f)), default=None)
    return best if best is not None and counts[best] > 1 else None


def _divide(monomial: Monomial, factor: Factor) -> Monomial:
    rest = list(monomial)
    rest.remove(factor)
    return tuple(rest)


def _in_front(factor: Factor, bracket: tuple[Part, ...]) -> Part:
    """Factor (bracket), with a bracket of one summand dissolved and a leading minus taken out."""
    if len(bracket) == 1:
        only = bracket[0]
        return Part(only.number, tuple(sorted((factor, *only.factors), key=rank)), only.bracket)
    if all(part.number < 0 for part in bracket):
        return Part(-1.0, (factor,), tuple(Part(-p.number, p.factors, p.bracket) for p in bracket))
    return Part(1.0, (factor,), bracket)
