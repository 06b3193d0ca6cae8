"""Laws that are expressions, as data: what a closed loop is compiled from, and what is exported."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from mafsil.arrays import Floats
from mafsil.control.joints.friction_compensation import FrictionCompensation
from mafsil.control.laws.computed_torque import ComputedTorque
from mafsil.control.laws.gains import Gains
from mafsil.control.laws.joint_feedback import Feedforward, JointFeedback
from mafsil.control.laws.law import Combined, Law
from mafsil.mechanics.friction import has_friction
from mafsil.mechanics.loop_terms import Term
from mafsil.model.loading import require_no_loops
from mafsil.robot import Robot


@dataclass(frozen=True, eq=False, slots=True)
class LawTerms:
    """A control law as data: its terms, the gains of those that have some, the limits of those whose integral waits."""

    terms: tuple[Term, ...]
    gains: tuple[Gains, ...]
    limits: tuple[Floats, ...] = ()


def _computed_torque(law: ComputedTorque) -> LawTerms:
    return LawTerms((_of_model("computed_torque", law.robot, law.friction),), (law.gains,))


def _of_model(kind: str, robot: Robot, friction: bool, waits: bool = False) -> Term:
    """A term that believes in a robot without loops; it compensates friction where the robot has any."""
    mechanism = require_no_loops(robot.mechanism)
    return Term(kind, mechanism, waits=waits, friction=friction and has_friction(mechanism))


def _joint_feedback(law: JointFeedback) -> LawTerms | None:
    if law.effort_limit is not None and law.gains.integrates:
        waiting = Term("feedback", waits=True)
        if law.model is not None:
            waiting = _of_model("feedback", law.model, law.friction, waits=True)
        return LawTerms((waiting,), (law.gains,), (law.effort_limit,))
    gravity = () if law.model is None else (_of_model("gravity", law.model, law.friction),)
    return LawTerms((Term("feedback"), *gravity), (law.gains,))


def _feedforward(law: Feedforward) -> LawTerms:
    return LawTerms((_of_model("feedforward", law.robot, law.friction),), ())


def _friction_compensation(law: FrictionCompensation) -> LawTerms:
    return LawTerms((_of_model("friction", law.robot, True),), ())


def _combine(law: Combined) -> LawTerms | None:
    return all_together([law_terms(part) for part in law.laws])


def all_together(parts: Sequence[LawTerms | None]) -> LawTerms | None:
    """The sum of laws as data; None if there is none, or if one of them is no data.

    Args:
        parts: laws as data.
    """
    known = [part for part in parts if part is not None]
    if not known or len(known) < len(parts):
        return None
    return LawTerms(
        sum((part.terms for part in known), ()),
        sum((part.gains for part in known), ()),
        sum((part.limits for part in known), ()),
    )


LAWS: dict[type, Callable[[Any], LawTerms | None]] = {
    ComputedTorque: _computed_torque,
    JointFeedback: _joint_feedback,
    Feedforward: _feedforward,
    FrictionCompensation: _friction_compensation,
    Combined: _combine,
}
"""Laws that are expressions, and how they are read."""


def law_terms(law: Law) -> LawTerms | None:
    """A law as data, or None if it is Python that only Python can run."""
    reader = LAWS.get(type(law))
    return None if reader is None else reader(law)
