"""Friction of the joints: viscous, Coulomb with a smooth change of sign, and a constant offset."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.errors import ModelError
from mafsil.model import Friction, Mechanism

SMOOTHING = 1e-3
"""Rate [rad/s | m/s] within which Coulomb friction changes its sign."""


@dataclass(frozen=True, eq=False, slots=True)
class FrictionLaw:
    """Friction of k joints of a robot with n coordinates.

    Attributes:
        viscous: (k,) effort per rate of the joint [N m s/rad | N s/m].
        positive, negative: (k,) Coulomb efforts against motion in either sense, magnitudes [N m | N].
        offset: (k,) constant efforts [N m | N].
        gain: (k, n) rates of the joints = gain @ qd; more than a selection where joints follow others.
    """

    viscous: Floats
    positive: Floats
    negative: Floats
    offset: Floats
    gain: Floats

    def torque(self, qd: JointVector, smoothing: float = SMOOTHING) -> JointVector:
        """Efforts (*batch, n) that friction takes [N m | N].

        f = viscous w + coulomb(sign of w) tanh(w / smoothing) + offset,  w = gain qd,  tau = gain' f

        Args:
            qd: (*batch, n) joint rates [rad/s | m/s].
            smoothing: rate [rad/s | m/s] within which the Coulomb part changes its sign.
        """
        w = qd @ self.gain.T
        coulomb = np.where(w >= 0, self.positive, self.negative) * np.tanh(w / smoothing)
        return (self.viscous * w + coulomb + self.offset) @ self.gain


def friction_law(mechanism: Mechanism) -> FrictionLaw:
    """The friction of all joints of a mechanism that have any, those that follow others included.

    Raises:
        ModelError: one of them follows another along a curve.
    """
    for joint in mechanism.joints:
        if joint.friction is not None and joint.mimic is not None and joint.mimic.higher:
            raise ModelError("model.curved_friction", joint=joint.name, leader=joint.mimic.leader)
    place = {joint.name: k for k, joint in enumerate(mechanism.coordinates)}
    rows, gains = list[tuple[float, ...]](), list[Floats]()
    for joint in mechanism.joints:
        if joint.friction is None or not joint.moves:
            continue
        gain = np.zeros(mechanism.n)
        gain[place[joint.mimic.leader if joint.mimic else joint.name]] = joint.mimic.multiplier if joint.mimic else 1.0
        rows.append(_numbers(joint.friction))
        gains.append(gain)
    viscous, positive, negative, offset = np.array(rows, dtype=np.float64).reshape(-1, 4).T
    return FrictionLaw(viscous, positive, negative, offset, np.array(gains).reshape(-1, mechanism.n))


def has_friction(mechanism: Mechanism) -> bool:
    """Whether any joint of a mechanism loses effort to friction."""
    return any(joint.moves and joint.friction is not None for joint in mechanism.joints)


def _numbers(friction: Friction) -> tuple[float, float, float, float]:
    negative = friction.coulomb if friction.coulomb_negative is None else friction.coulomb_negative
    return friction.viscous, friction.coulomb, negative, friction.offset


def friction_columns(qd: JointVector, smoothing: float = SMOOTHING) -> Floats:
    """(*batch, n, 3): viscous, Coulomb (equal both ways) and offset columns of each joint's own effort.

    Arguments as in `FrictionLaw.torque`.
    """
    return np.stack([qd, np.tanh(qd / smoothing), np.ones_like(qd)], axis=-1)
