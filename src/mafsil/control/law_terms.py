"""Laws that are expressions, as data: what a closed loop is compiled from, and what is exported."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, cast

from mafsil.control.computed_torque import ComputedTorque
from mafsil.control.gains import Gains
from mafsil.control.joint_feedback import Feedforward, JointFeedback
from mafsil.control.law import Combined, Law
from mafsil.mechanics.loop_terms import Term


@dataclass(frozen=True, eq=False, slots=True)
class LawTerms:
    """A control law as data: its terms, the gains of those that have some."""

    terms: tuple[Term, ...]
    gains: tuple[Gains, ...]


def _computed_torque(law: ComputedTorque) -> LawTerms:
    return LawTerms((Term("computed_torque", law.robot.mechanism),), (law.gains,))


def _joint_feedback(law: JointFeedback) -> LawTerms | None:
    if law.effort_limit is not None and law.gains.integrates:
        return None  # An integral that waits is a decision at each call.
    gravity = () if law.model is None else (Term("gravity", law.model.mechanism),)
    return LawTerms((Term("feedback"), *gravity), (law.gains,))


def _feedforward(law: Feedforward) -> LawTerms:
    return LawTerms((Term("feedforward", law.robot.mechanism),), ())


def _combined(law: Combined) -> LawTerms | None:
    parts = [law_terms(part) for part in law.laws]
    if not parts or any(part is None for part in parts):
        return None
    known = cast("list[LawTerms]", parts)
    return LawTerms(sum((p.terms for p in known), ()), sum((p.gains for p in known), ()))


LAWS: dict[type, Callable[[Any], LawTerms | None]] = {
    ComputedTorque: _computed_torque,
    JointFeedback: _joint_feedback,
    Feedforward: _feedforward,
    Combined: _combined,
}
"""Laws that are expressions, and how they are read."""


def law_terms(law: Law) -> LawTerms | None:
    """A law as data, or None if it is Python that only Python can run."""
    reader = LAWS.get(type(law))
    return None if reader is None else reader(law)
