"""Which family of laws suits a task and an arm; what cannot be asked, and why."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, as_batch, not_negative, require_kind
from mafsil.control.contact.impedance import Impedance
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.robot import Robot, of_robot

ENVIRONMENTS = ("free", "compliant", "rigid")
"""What a direction meets."""
DEMANDS = ("motion", "force", "impedance")
"""What can be asked along a direction."""
MOSTLY = 0.9
"""Share of a motion that must be kept to count as a source of motion; one tenth or less is a source of force."""
ROTORS, DRY = 0.5, 0.1
"""Shares up to which an arm counts as light: rotors of the inertia of a joint, dry friction of its limit of effort."""


class RecommendedController(Status):
    """The family of control laws for a task, or why there is none."""

    MOTION = ("control.suits_motion", True)
    FORCE = ("control.suits_force", True)
    HYBRID = ("control.suits_hybrid", True)
    IMPEDANCE = ("control.suits_impedance", True)
    BOTH_ASKED = ("control.suits_both_asked", False)
    BLOCKED = ("control.suits_blocked", False)
    UNANSWERED = ("control.suits_unanswered", False)
    MIXED = ("control.suits_mixed", False)


LAWS = {
    RecommendedController.MOTION: (
        "computed_torque",
        "task_computed_torque",
        "gravity_compensation",
        "sliding_mode",
        "min_max",
        "model_predictive",
    ),
    RecommendedController.FORCE: ("force_control",),
    RecommendedController.HYBRID: ("hybrid_control",),
    RecommendedController.IMPEDANCE: ("impedance_control", "admittance_control"),
}
"""Names in `mafsil.control` of each family."""


@dataclass(frozen=True, eq=False, repr=False)
class Suitability(Answer, data="direction laws"):
    """The family of laws that a task needs; true if there is one.

    Attributes:
        status: which, or why none.
        direction: name of the direction that decided it; empty if all are alike.
        laws: names in `mafsil.control`; none without a family.
    """

    status: RecommendedController
    direction: str
    laws: tuple[str, ...]

    def explain(self, language: str | None = None) -> str:
        """The family with its laws, or the direction that cannot be had and why."""
        return self.status.sentence(language, direction=self.direction, laws=", ".join(self.laws))


def recommend_controller(
    environment: Sequence[str], wanted: Sequence[str | Sequence[str]], names: Sequence[str] | None = None
) -> Suitability:
    """The family of control laws for a task, by the environment and the goal along each direction.

    Motion and force along one direction cannot both be asked: the environment fixes the other.

    Algorithm:
        1. A direction with motion and force: refused. Motion against something rigid, or force where nothing resists:
           refused.
        2. Only motion, only force, motion and force in different directions: motion, force, hybrid control.
        3. A direction that shall give way makes it impedance control; beside force it is mixed, which no law here does.

    Args:
        environment: of each direction: free, compliant or rigid.
        wanted: of each direction: motion, force or impedance, or several of them.
        names: of the directions; x, y, z or numbers if None.

    Raises:
        InputError: another word, lists of different lengths, nothing asked.

    Reference: Lynch and Park, Modern Robotics, sec. 11.1.
    """
    for name, each in (("environment", environment), ("wanted", wanted)):
        require_kind(name, each, "sequence, a word for each direction", "__len__", "__getitem__")
    count = len(environment)
    labels = tuple(names or ("xyz"[:count] if count <= 3 else map(str, range(1, count + 1))))
    if not count or not count == len(wanted) == len(labels):
        got = (count, len(wanted), len(labels))
        raise InputError("input.shape", name="wanted", expected=(max(count, 1),), got=got, hint="")
    demands: list[set[str]] = [{each} if isinstance(each, str) else set(each) for each in wanted]
    _require_words("environment", environment, ENVIRONMENTS)
    for each in demands:
        _require_words("wanted", sorted(each) or [""], DEMANDS)
    # 1
    for label, meets, asked in zip(labels, environment, demands, strict=True):
        if (refused := _refuse(meets, asked)) is not None:
            return Suitability(refused, label, ())
    # 2, 3
    first = {demand: label for label, asked in reversed([*zip(labels, demands, strict=True)]) for demand in asked}
    if "impedance" in first:
        family = RecommendedController.MIXED if "force" in first else RecommendedController.IMPEDANCE
        return Suitability(family, first["impedance"], LAWS.get(family, ()))
    if len(first) == 2:
        return Suitability(RecommendedController.HYBRID, first["force"], LAWS[RecommendedController.HYBRID])
    family = RecommendedController.MOTION if "motion" in first else RecommendedController.FORCE
    return Suitability(family, "", LAWS[family])


def _refuse(meets: str, asked: set[str]) -> RecommendedController | None:
    """Why what is asked along a direction cannot be had there, if it cannot."""
    if {"motion", "force"} <= asked:
        return RecommendedController.BOTH_ASKED
    if meets == "rigid" and "motion" in asked:
        return RecommendedController.BLOCKED
    if meets == "free" and "force" in asked:
        return RecommendedController.UNANSWERED
    return None


def _require_words(name: str, words: Sequence[str], known: Sequence[str]) -> None:
    for word in words:
        if word not in known:
            raise InputError("input.choice", name=name, value=word, known=", ".join(known))


class RecommendedInteraction(Status):
    """Impedance or admittance control, by the arm's drive train."""

    IMPEDANCE = ("control.suits_impedance_control", True)
    ADMITTANCE = ("control.suits_admittance_control", True)
    NOT_KNOWN = ("control.suits_not_known", False)


@dataclass(frozen=True, eq=False, repr=False)
class Interaction(Answer, data="joint rotor_share friction_share"):
    """Impedance or admittance control; true if the model knows enough to say.

    Attributes:
        status: which.
        rotor_share: (n,) of the inertia of each joint that is its rotor behind its gear; the others held.
        friction_share: (n,) of the limit of effort that dry friction takes; NaN where either is not known.
        joint: number of the joint that decided, from 1.
    """

    status: RecommendedInteraction
    rotor_share: Floats
    friction_share: Floats
    joint: int

    def explain(self, language: str | None = None) -> str:
        """The realisation with the shares of the deciding joint."""
        k = self.joint - 1
        known = np.isfinite(self.friction_share[k])
        key = "control.dry_friction_share" if known else "control.dry_friction_unknown"
        friction = say(key, language=language, friction=float(self.friction_share[k]), dry=DRY)
        rotor = float(self.rotor_share[k])
        return self.status.sentence(language, joint=self.joint, rotor=rotor, light=ROTORS, friction=friction)


@of_robot
def recommend_interaction(robot: Robot, q: ArrayLike) -> Interaction:
    """Whether an arm is made for impedance control (light, driven backwards easily) or for admittance control (geared).

    The rule: impedance control if the rotors are at most half of the inertia of every joint and dry friction takes at
    most a tenth of what its motor gives; admittance control otherwise.

    Args:
        robot: its model, with rotors and friction.
        q: (n,) configuration [rad | m].

    Raises:
        InputError: a wrong shape, a number that is not finite.
        ModelError: the robot has no masses.

    Reference: Lynch and Park, Modern Robotics, sec. 11.7.
    """
    place = as_batch("q", q, (robot.n,), finite=True).reshape(robot.n)
    joints = robot.mechanism.coordinates
    rotors = np.array([0.0 if j.actuator is None else j.actuator.reflected_inertia for j in joints])
    share = rotors / np.diagonal(robot.mass_matrix(place))
    dry = np.array([np.nan if j.friction is None else j.friction.coulomb for j in joints])
    limit = np.where(np.isfinite(robot.limits.effort), robot.limits.effort, np.nan)
    friction = np.divide(dry, limit, out=np.full(robot.n, np.nan), where=limit > 0.0)
    if not rotors.any() and np.isnan(friction).all():
        return Interaction(RecommendedInteraction.NOT_KNOWN, share, friction, 1)
    badness = np.maximum(share / ROTORS, np.nan_to_num(friction) / DRY)
    worst = int(badness.argmax())
    status = RecommendedInteraction.IMPEDANCE if badness[worst] <= 1.0 else RecommendedInteraction.ADMITTANCE
    return Interaction(status, share, friction, worst + 1)


class ImpedanceClass(Status):
    """The class of an impedance relative to an environment."""

    HIGH = ("control.impedance_high", True)
    LOW = ("control.impedance_low", True)
    BETWEEN = ("control.impedance_between", True)


@dataclass(frozen=True, eq=False, repr=False)
class RenderedImpedance(Answer, data="kept frequency"):
    """The fraction of a wanted motion that remains against an environment, at one frequency.

    Attributes:
        status: HIGH, a source of motion; LOW, a source of force; BETWEEN.
        kept: (m,) sizes of the motion kept along the principal directions, increasing: 1 is ideal control of motion, 0
            of force.
        frequency: [rad/s].
    """

    status: ImpedanceClass
    kept: Floats
    frequency: float

    def explain(self, language: str | None = None) -> str:
        """The class with the least and the largest share."""
        details = {"least": float(self.kept[0]), "most": float(self.kept[-1]), "frequency": self.frequency}
        return self.status.sentence(language, **details)


def impedance_class(impedance: Impedance, environment: Impedance, frequency: float = 0.0) -> RenderedImpedance:
    """Whether an impedance is high or low for an environment: X = (Z + Z_env)^-1 Z X_wanted.

    Args:
        impedance: of the law, such as that of `impedance_control`.
        environment: what the tip touches, in the same coordinates.
        frequency: of the motion [rad/s].

    Raises:
        InputError: a frequency that is negative or not finite; both are nothing in some direction.
    """
    frequency = not_negative("frequency", frequency)
    for name, each in (("impedance", impedance), ("environment", environment)):
        require_kind(name, each, "Impedance", "frequency_response")
    Z, E = (each.frequency_response(frequency) for each in (impedance, environment))
    if Z.shape != E.shape or np.linalg.matrix_rank(Z + E) < len(Z):
        raise InputError("control.nothing_resists", frequency=frequency)
    kept = np.sort(np.abs(np.linalg.eigvals(np.linalg.solve(Z + E, Z))))
    status = ImpedanceClass.BETWEEN
    if kept[0] >= MOSTLY:
        status = ImpedanceClass.HIGH
    elif kept[-1] <= 1.0 - MOSTLY + 1e-12:
        status = ImpedanceClass.LOW
    return RenderedImpedance(status, np.asarray(kept, dtype=np.float64), float(frequency))
