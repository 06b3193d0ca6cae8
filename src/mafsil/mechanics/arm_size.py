"""The size of an arm: its one length, its mass, and from them what counts as large for each of its quantities.

The length L of an arm is the longest way from {s} along the links to a centre of mass or a frame, prismatic joints
half a metre out: no lever, and hence no moment per force and no velocity per rate, is longer. Coordinates of prismatic
joints are counted in units of L, so that all joints have one unit; efforts then compare with weight times L, the mass
matrix with mass times L^2. (`performance.characteristic_length` is another: the mean lever, by which translations of
a Jacobian are divided to compare with its rotations.)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.model import JointKind, Mechanism

GRAVITY = 9.81
"""Acceleration [m/s^2] that makes a weight of a mass, also where the robot's own gravity is another or none."""
TRAVEL = 0.5
"""Travel [m] that counts for a prismatic joint."""
RATE = 2.0
"""Rates that count [1/s], in the robot's own units."""
LEAST_LENGTH, LEAST_MASS = 1e-3, 1e-6
"""Of robots whose description has no length [m] or no mass [kg]."""


def arm_length(mechanism: Mechanism) -> float:
    """L [m]: the longest way from {s} along the links to a centre of mass, a frame or the tip.

    Args:
        mechanism: the robot; with all its joints, whatever their limits.
    """
    way = {mechanism.links[0].name: float(np.linalg.norm(mechanism.T_sb[:3, 3]))}
    for joint in mechanism.joints:
        travel = TRAVEL if joint.kind is JointKind.PRISMATIC else np.pi * abs(joint.pitch)
        way[joint.child] = way[joint.parent] + float(np.linalg.norm(joint.T_pj[:3, 3])) + travel
    ends = [
        way[link.name] + (0.0 if link.inertial is None else float(np.linalg.norm(link.inertial.com)))
        for link in mechanism.links
    ]
    return max(*ends, way[mechanism.tip] + float(np.linalg.norm(mechanism.T_lt[:3, 3])), LEAST_LENGTH)


@dataclass(frozen=True, eq=False, slots=True)
class ArmSize:
    """Sizes of a robot; what a quantity's natural size is made from.

    Attributes:
        length: of the arm, L [m].
        mass: of all links that move [kg].
        unit: (n,) of each coordinate: 1 or L.
    """

    length: float
    mass: float
    unit: Floats

    @classmethod
    def of(cls, mechanism: Mechanism) -> ArmSize:
        """Of a robot."""
        length = arm_length(mechanism)
        mass = sum(link.inertial.mass for link in mechanism.links[1:] if link.inertial is not None)
        prismatic = [joint.kind is JointKind.PRISMATIC for joint in mechanism.coordinates]
        return cls(length, max(mass, LEAST_MASS), np.where(prismatic, length, 1.0))

    @property
    def units(self) -> Floats:
        """(n, n) products of the units of two coordinates."""
        return self.unit[:, None] * self.unit

    @property
    def force(self) -> float:
        """Weight of the mass [N]."""
        return self.mass * GRAVITY

    @property
    def moment(self) -> float:
        """Weight times L [N m]; also an energy [J]."""
        return self.mass * GRAVITY * self.length

    @property
    def inertia(self) -> float:
        """Mass times L^2 [kg m^2]."""
        return self.mass * self.length**2

    @property
    def pose(self) -> Floats:
        """(4, 4): 1 for a rotation, L for a position."""
        return np.where(np.arange(4) == 3, self.length, 1.0) * np.ones((4, 1))

    @property
    def twist(self) -> Floats:
        """(6,) per unit rate: 1 for an angular velocity, L for a linear one."""
        return np.array([1.0] * 3 + [self.length] * 3)

    @property
    def wrench(self) -> Floats:
        """(6,) weight times L for a moment, weight for a force."""
        return self.force * np.array([self.length] * 3 + [1.0] * 3)

    @property
    def effort(self) -> Floats:
        """(n,) weight times L per coordinate."""
        return self.moment / self.unit

    @property
    def parameters(self) -> Floats:
        """(10,) what one unit of each inertial parameter of a body weighs at L."""
        return GRAVITY * np.array([self.length, *[1.0] * 3, *[1.0 / self.length] * 6])
