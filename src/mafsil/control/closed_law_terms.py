"""Laws of closed chains that are expressions, as data: what a closed loop is compiled from."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.control.closed_chain_laws import ClosedComputedTorque, ClosedGravityCompensation
from mafsil.control.gains import Gains
from mafsil.control.law import Combined, Law
from mafsil.control.law_terms import LawTerms, law_terms
from mafsil.mechanics.loop_terms import Term


def closed_law_terms(law: Law, q: ArrayLike) -> LawTerms | None:
    """A law as data; None if it is Python that only Python can run, or if its efforts cannot be compiled.

    Args:
        law: of a closed chain, or any other.
        q: (*batch, n) configurations that close the loops.
    """
    if isinstance(law, Combined):
        parts = [closed_law_terms(part, q) for part in law.laws]
        known = [part for part in parts if part is not None]
        if not known or len(known) < len(parts):
            return None
        return LawTerms(sum((p.terms for p in known), ()), sum((p.gains for p in known), ()))
    if not isinstance(law, ClosedComputedTorque | ClosedGravityCompensation):
        return law_terms(law)
    chain = law.chain
    holding = chain.holding(q)
    if holding is None or not holding.deciding:
        return None
    gains = Gains(*(_of_all(chain.n, holding.driven, part) for part in (law.gains.kp, law.gains.kd, law.gains.ki)))
    model = chain.robot.mechanism
    if isinstance(law, ClosedComputedTorque):
        return LawTerms((Term("closed_computed_torque", model, holding),), (gains,))
    return LawTerms((Term("feedback"), Term("closed_gravity", model, holding)), (gains,))


def _of_all(n: int, driven: tuple[int, ...], part: Floats) -> Floats:
    """(n,) gains of all joints, zero where none drives."""
    whole = np.zeros(n)
    whole[list(driven)] = part
    return whole
