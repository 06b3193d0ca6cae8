"""Laws of one joint as numbers: PID and its special cases, feedforward, both, computed torque."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, require_kind
from mafsil.errors import InputError
from mafsil.one_joint.arguments import check_batch, magnitude, together
from mafsil.one_joint.error_dynamics import ErrorDynamics
from mafsil.one_joint.joint_arm import JointArm


class LawKind(IntEnum):
    """What the law computes."""

    FEEDBACK = 0
    FEEDFORWARD = 1
    FEEDFORWARD_FEEDBACK = 2
    COMPUTED_TORQUE = 3


NO_MODEL = JointArm.of(1.0)
"""What a law without a model carries: unit inertia, nothing else."""


@dataclass(frozen=True, eq=False, slots=True)
class JointLaw:
    """A law of one joint; e = theta_d - theta.

    FEEDBACK              tau = Kp e + Ki int e + Kd e'
    FEEDFORWARD           tau = M^ theta_d'' + h^(theta_d, theta_d')
    FEEDFORWARD_FEEDBACK  their sum
    COMPUTED_TORQUE       tau = M^ (theta_d'' + Kp e + Ki int e + Kd e') + h^(theta, theta')

    Attributes:
        kind: which of them.
        kp, ki, kd: (*batch) gains: torques per error, for computed torque accelerations per error.
        model: M^, h^; apart from the arm, so that it can be wrong.
    """

    kind: LawKind
    kp: Floats
    ki: Floats
    kd: Floats
    model: JointArm = NO_MODEL
    __post_init__ = check_batch(kp=magnitude, ki=magnitude, kd=magnitude)

    @classmethod
    def pid(cls, kp: ArrayLike = 0.0, ki: ArrayLike = 0.0, kd: ArrayLike = 0.0) -> JointLaw:
        """Feedback alone; P, I, D, PD, PI by gains of zero.

        Args:
            kp, ki, kd: (*batch) [N m/rad, N m/(rad s), N m s/rad].

        Raises:
            InputError: a negative gain, shapes that do not go together.
        """
        return cls._of(LawKind.FEEDBACK, NO_MODEL, kp, ki, kd)

    @classmethod
    def feedforward(cls, model: JointArm) -> JointLaw:
        """The torque of the reference, blind to the state: exact with a perfect model from a matching start."""
        return cls._of(LawKind.FEEDFORWARD, model)

    @classmethod
    def feedforward_pid(cls, model: JointArm, kp: ArrayLike, ki: ArrayLike = 0.0, kd: ArrayLike = 0.0) -> JointLaw:
        """Feedforward and PID added."""
        return cls._of(LawKind.FEEDFORWARD_FEEDBACK, model, kp, ki, kd)

    @classmethod
    def computed_torque(cls, model: JointArm, kp: ArrayLike, ki: ArrayLike = 0.0, kd: ArrayLike = 0.0) -> JointLaw:
        """Feedback that the model makes linear; gains are accelerations per error: divide torque gains by M."""
        return cls._of(LawKind.COMPUTED_TORQUE, model, kp, ki, kd)

    @classmethod
    def _of(
        cls, kind: LawKind, model: JointArm, kp: ArrayLike = 0.0, ki: ArrayLike = 0.0, kd: ArrayLike = 0.0
    ) -> JointLaw:
        require_kind("model", model, "JointArm", "gravity_moment", "friction")
        p, i, d = together(kp=kp, ki=ki, kd=kd)
        return cls(kind, p, i, d, model)

    @property
    def letters(self) -> NDArray[np.str_]:
        """(*batch) which terms the gains leave: "P", "PI", "PD", "PID", "I", "D", "ID", or "" for none."""
        names = np.where(self.kp > 0.0, "P", "").astype("<U3")
        names = np.char.add(names, np.where(self.ki > 0.0, "I", ""))
        return np.char.add(names, np.where(self.kd > 0.0, "D", ""))

    def error_dynamics(self, arm: JointArm) -> ErrorDynamics:
        """Linear error dynamics of the arm under this law about a set point, without gravity.

        M e'' + (b + Kd) e' + Kp e = 0, and one order more with an integral: the order that is actually closed, so gains
        Ki must be all zero or all positive. Of computed torque with an exact model, e'' + Kd e' + Kp e + Ki int e = 0.

        Args:
            arm: the true arm; only its viscous friction counts.

        Raises:
            InputError: some Ki zero and others not; a law without feedback.
        """
        require_kind("arm", arm, "JointArm", "gravity_moment", "friction")
        M, b = arm.inertia, arm.friction.viscous
        if self.kind is LawKind.COMPUTED_TORQUE:
            M, b = np.ones_like(M), np.zeros_like(b)
        terms = [M, b + self.kd, self.kp]
        if not self.ki.any():
            return ErrorDynamics.of(*terms)
        if not self.ki.all():
            raise InputError("one_joint.mixed_orders")
        return ErrorDynamics.of(*terms, self.ki)
