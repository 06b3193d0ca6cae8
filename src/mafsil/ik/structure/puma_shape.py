"""Arms of the PUMA type: whether the axes are so, their residuals it, and the lengths of the shape.

Two axes w_i, w_j of moments v_i, v_j are in one plane where w_i . v_j + w_j . v_i = 0, and meet there if they are not
parallel. With p the wrist's centre, h the height of the shoulder, d its offset to the side, a1 and a2 upper arm and
forearm:

    p = (rho cos q1 - d sin q1, rho sin q1 + d cos q1, h + s),  (rho, s) = a1 (c2, s2) + a2 (c23, s23)

Reference: Lee and Ziegler, A geometric approach in solving the inverse kinematics of PUMA robots, 1984.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mafsil.algebra.tolerance import DESCRIBED
from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, Vector3, not_negative
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.ik.chain import Chain, chain_of, common_point, moving_part
from mafsil.messages import say
from mafsil.model.loading import RobotLike
from mafsil.robot import as_robot


class ArmClass(Status):
    """Classes of arms with a wrist of orthogonal axes that meet, and that an arm is of none."""

    PUMA = ("ik.class_puma", True)
    PUMA_WITH_OFFSET = ("ik.class_puma_with_offset", True)
    GENERALIZED_PUMA = ("ik.class_generalized_puma", True)
    STANFORD = ("ik.class_stanford", True)
    STANFORD_WITH_OFFSET = ("ik.class_stanford_with_offset", True)
    GENERALIZED_STANFORD = ("ik.class_generalized_stanford", True)
    NONE = ("ik.class_none", False)


@dataclass(frozen=True)
class Condition:
    """One condition on axes.

    Attributes:
        name: sentence key.
        joints: of the arm, counted from one in the direction in which it is seen.
        size: how far it is from being met [rad, or m relative to the size of the arm].
        satisfied: whether it is within the tolerance.
    """

    name: str
    joints: tuple[int, ...]
    size: float
    satisfied: bool

    def explain(self, language: str | None = None) -> str:
        """The condition in words, and how far it is from being met."""
        which = ", ".join(map(str, self.joints))
        key = "ik.condition_satisfied" if self.satisfied else "ik.condition_violated"
        words = say(self.name, language=language, joints=which)
        return say(key, language=language, condition=words, size=f"{self.size:.3g}")


@dataclass(frozen=True, eq=False, repr=False)
class ArmStructure(Answer, data="reversed wrist_centre"):
    """What an arm of six joints is, and why it is not more: true if it is of one of the classes.

    Attributes:
        arm_class: the narrowest class whose conditions hold.
        conditions: all that were checked, with their sizes.
        reversed: whether the arm is so when seen from its tip.
        wrist_centre: (3,) the point nearest to axes 4, 5, 6 at q = 0, in {s} [m].
    """

    arm_class: ArmClass
    conditions: tuple[Condition, ...]
    reversed: bool
    wrist_centre: Vector3

    @property
    def status(self) -> ArmClass:
        """The class."""
        return self.arm_class

    @property
    def failing(self) -> tuple[Condition, ...]:
        """The conditions that are not met."""
        return tuple(condition for condition in self.conditions if not condition.satisfied)

    def explain(self, language: str | None = None) -> str:
        """The class, then every condition with its size."""
        lines = [self.arm_class.sentence(language)]
        return "\n".join([*lines, *(condition.explain(language) for condition in self.conditions)])

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        conditions = [
            {"condition": one.explain(), "joints": list(one.joints), "size": one.size, "satisfied": one.satisfied}
            for one in self.conditions
        ]
        return Answer.to_dict(self) | {"conditions": conditions}


@dataclass(frozen=True, eq=False)
class PumaShape:
    """Lengths of an arm of the PUMA type.

    Attributes:
        height: h, of axis 2 above the base along axis 1 [m].
        offset: d, of the arm's plane to the left of the heading [m]; zero without.
        upper_arm: a1, between axes 2 and 3 [m].
        forearm: a2, between axis 3 and the wrist's centre [m].
        wrist_centre: (3,) at q = 0, in {s} [m].
    """

    height: float
    offset: float
    upper_arm: float
    forearm: float
    wrist_centre: Vector3


def arm_structure(robot: RobotLike, tolerance: float = DESCRIBED) -> ArmStructure:
    """The class of an arm of six joints, with every condition and how far it is from being met.

    Args:
        robot: a Robot, a Mechanism, a name of the library or a file.
        tolerance: sizes of conditions that count as rounding; what a description of six digits leaves open.

    Raises:
        InputError: not six revolute or prismatic joints on the way to the tip.
    """
    tolerance = not_negative("tolerance", tolerance)
    chain = _six(robot)
    forward = _structure(chain, tolerance, backwards=False)
    if forward.arm_class is not ArmClass.NONE:
        return forward
    seen = _structure(chain.backwards(), tolerance, backwards=True)
    return seen if seen.arm_class is not ArmClass.NONE else forward


def puma_shape(robot: RobotLike, tolerance: float = DESCRIBED) -> PumaShape:
    """The lengths h, d, a1, a2 of an arm of the PUMA type, read from its axes.

    Args:
        robot: a Robot, a Mechanism, a name of the library or a file; of its joints the first three and the wrist, or
            the first three alone, whose tip is then the wrist's centre.
        tolerance: as for `arm_structure`.

    Raises:
        InputError: another arm; the sentence says which condition fails and by how much.
    """
    tolerance = not_negative("tolerance", tolerance)
    part = moving_part(as_robot(robot)).robot
    chain = chain_of(part.mechanism)
    if chain is None or len(chain) not in (3, 6) or any(chain.prismatic):
        raise InputError("ik.no_puma", reason=say("ik.six_joints", joints=part.n))
    centre = chain.home[:3, 3] if len(chain) == 3 else common_point(chain.axes[3:], chain.points[3:])[0]
    requested = [*_shoulder(chain), _parallel(chain)]
    if len(chain) == 6:
        requested += _wrist(chain)
    failed_step = next((one for one in requested if one.size > tolerance), None)
    if failed_step is not None:
        raise InputError("ik.no_puma", reason=failed_step.explain())
    w1, w2 = chain.axes[0], chain.axes[1]
    shoulder = _meeting(chain)
    elbow = chain.points[2] + (w2 @ (shoulder - chain.points[2])) * w2
    beyond = centre - elbow
    reach = beyond - (beyond @ w2) * w2
    # The heading is where the wrist is at q = 0.
    ahead = np.cross(w1, w2)
    ahead = -ahead if (centre - shoulder) @ ahead < 0.0 else ahead
    left = np.cross(w1, ahead)
    base = as_robot(robot).mechanism.T_sb[:3, 3]
    return PumaShape(
        float(w1 @ (shoulder - base)),
        float(left @ (centre - shoulder)),
        float(np.linalg.norm(elbow - shoulder)),
        float(np.linalg.norm(reach)),
        centre,
    )


def _six(robot: RobotLike) -> Chain:
    part = moving_part(as_robot(robot)).robot
    chain = chain_of(part.mechanism)
    if chain is None or len(chain) != 6:
        raise InputError("ik.six_joints", joints=part.n)
    return chain


def _structure(chain: Chain, tolerance: float, *, backwards: bool) -> ArmStructure:
    """What the arm is in one direction."""
    common = [*_shoulder(chain), *_wrist(chain)]
    centre = common_point(chain.axes[3:], chain.points[3:])[0]
    special = _across(chain, centre) if chain.prismatic[2] else _parallel(chain)
    offset = _offset(chain, centre)
    conditions = tuple(
        Condition(one.name, one.joints, one.size, one.size <= tolerance) for one in (*common, special, offset)
    )
    *requested, narrow, central = (one.satisfied for one in conditions)
    classes = (
        (ArmClass.GENERALIZED_STANFORD, ArmClass.STANFORD_WITH_OFFSET, ArmClass.STANFORD)
        if chain.prismatic[2]
        else (ArmClass.GENERALIZED_PUMA, ArmClass.PUMA_WITH_OFFSET, ArmClass.PUMA)
    )
    found = classes[(1 + central) if narrow else 0] if all(requested) else ArmClass.NONE
    return ArmStructure(found, conditions, backwards, centre)


def _shoulder(chain: Chain) -> list[Condition]:
    w, turns = chain.axes, not any(chain.prismatic[:2])
    apart = abs(float(chain.screws[0] @ np.roll(chain.screws[1], 3))) / chain.size if turns else np.inf
    return [
        Condition("ik.condition_meet", (1, 2), apart, False),
        Condition("ik.condition_orthogonal", (1, 2), abs(float(w[0] @ w[1])), False),
    ]


def _wrist(chain: Chain) -> list[Condition]:
    w = chain.axes
    distance = common_point(w[3:], chain.points[3:])[1] / chain.size if not any(chain.prismatic[3:]) else np.inf
    return [
        Condition("ik.condition_meet", (4, 5, 6), distance, False),
        Condition("ik.condition_orthogonal", (4, 5), abs(float(w[3] @ w[4])), False),
        Condition("ik.condition_orthogonal", (5, 6), abs(float(w[4] @ w[5])), False),
    ]


def _parallel(chain: Chain) -> Condition:
    size = float(np.linalg.norm(np.cross(chain.axes[1], chain.axes[2])))
    return Condition("ik.condition_parallel", (2, 3), size, False)


def _across(chain: Chain, centre: Vector3) -> Condition:
    """The stroke is normal to axis 2, and leads the wrist's centre straight away from it."""
    w2, v3 = chain.axes[1], chain.axes[2]
    away = centre - _meeting(chain)
    beside = float(np.linalg.norm(np.cross(v3, away - (w2 @ away) * w2))) / chain.size
    return Condition("ik.condition_across", (2, 3), max(abs(float(w2 @ v3)), beside), False)


def _offset(chain: Chain, centre: Vector3) -> Condition:
    """How far the plane of the arm passes axis 1."""
    if any(chain.prismatic[:2]) or not np.isfinite(centre).all():
        return Condition("ik.condition_no_offset", (1, 2), np.inf, False)
    size = abs(float(chain.axes[1] @ (centre - _meeting(chain)))) / chain.size
    return Condition("ik.condition_no_offset", (1, 2), size, False)


def _meeting(chain: Chain) -> Vector3:
    """The point nearest to axes 1 and 2; of axis 1 where they are parallel."""
    place = common_point(chain.axes[:2], chain.points[:2])[0]
    return place if np.isfinite(place).all() else chain.points[0]


class ConjugatedWrist:
    """The wrist's screws carried to its centre, where they are pure turns.

    T_w = (R_w, r_w): Ad(T_w^-1) S_i has no linear part, and T_w^-1 X T_w is a rotation if the steps before were right.

    Attributes:
        T_w: (4, 4) frame at the wrist's centre: z along w4, y along w5.
        S: (3, 6) the conjugated screws of joints 4, 5, 6.
    """

    def __init__(self, screws: Floats, centre: Vector3) -> None:
        w4, w5 = screws[0, :3], screws[1, :3]
        self.T_w = np.eye(4)
        self.T_w[:3, :3] = np.stack([np.cross(w5, w4), w5, w4], axis=1)
        self.T_w[:3, 3] = centre
        self.S = screws @ pose.adjoint(pose.inverse(self.T_w)).T

    def conjugate(self, X: Floats) -> Floats:
        """(4, 4) T_w^-1 X T_w of a displacement of the wrist in {s}."""
        return pose.inverse(self.T_w) @ X @ self.T_w

    def shift(self, X: Floats) -> float:
        """What moves the centre [m]: zero if the joints before the wrist are at a solution."""
        return float(np.linalg.norm(self.conjugate(X)[:3, 3]))


def conjugated_wrist(robot: RobotLike) -> ConjugatedWrist:
    """The wrist of an arm of six joints as turns about one point.

    Args:
        robot: whose axes 4 and 5 are orthogonal, and 4, 5, 6 meet.

    Raises:
        InputError: another arm; the sentence says which condition fails and by how much.
    """
    chain = _six(robot)
    failed_step = next((one for one in _wrist(chain)[:2] if one.size > DESCRIBED), None)
    if failed_step is not None:
        raise InputError("ik.no_puma", reason=failed_step.explain())
    return ConjugatedWrist(chain.screws[3:], common_point(chain.axes[3:], chain.points[3:])[0])
