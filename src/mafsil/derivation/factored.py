"""A polynomial as a person writes it: common factors in front of brackets."""

from __future__ import annotations

from collections import Counter

from mafsil.derivation.grouping import Part as Part
from mafsil.derivation.grouping import evaluate as evaluate
from mafsil.derivation.grouping import group_summands, has_inertia
from mafsil.derivation.polynomial import Factor, Monomial, Polynomial, Symbol, collect_terms, rank


def factor_out(polynomial: Polynomial) -> tuple[Part, ...]:
    """Summands with the most frequent common factors taken out, first those of most terms; masses in front of all."""
    if has_inertia(polynomial):
        return group_summands(polynomial)
    common = _most_frequent(polynomial)
    if common is None:
        return tuple(Part(number, monomial) for monomial, number in polynomial.terms.items())
    inside = {m: x for m, x in polynomial.terms.items() if common in m}
    outside = Polynomial({m: x for m, x in polynomial.terms.items() if common not in m})
    bracket = factor_out(collect_terms((_without(m, common), x) for m, x in inside.items()))
    first = next(iter(polynomial.terms))
    here = _in_front(common, bracket)
    rest = factor_out(outside)
    return (here, *rest) if common in first else (*rest, here)


def _most_frequent(polynomial: Polynomial) -> Factor | None:
    """The factor of most terms, at least two; of equally frequent ones the first on paper."""
    counts = Counter(factor for monomial in polynomial.terms for factor in set(monomial))
    best = min(counts, key=lambda f: (-counts[f], isinstance(f, Symbol), rank(f)), default=None)
    return best if best is not None and counts[best] > 1 else None


def _without(monomial: Monomial, factor: Factor) -> Monomial:
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
