"""Laws of closed chains that are expressions, as data: what a closed loop is compiled from."""

from __future__ import annotations

from numpy.typing import ArrayLike

from mafsil.control.closed_chain_laws import ClosedComputedTorque, ClosedGravityCompensation
from mafsil.control.law import Combined, Law
from mafsil.control.law_terms import LawTerms, all_together, law_terms


def closed_law_terms(law: Law, q: ArrayLike) -> LawTerms | None:
    """A law as data; None if it is Python that only Python can run, or if its efforts cannot be compiled.

    Args:
        law: of a closed chain, or any other.
        q: (*batch, n) configurations that close the loops.
    """
    if isinstance(law, Combined):
        return all_together([closed_law_terms(part, q) for part in law.laws])
    if not isinstance(law, ClosedComputedTorque | ClosedGravityCompensation):
        return law_terms(law)
    return law.as_terms(q)
