"""Against what an error is relative: sizes of the robot itself, never a number that may happen to be small.

Coordinates of slides are counted in units of reach, so that all joints have one unit; efforts then compare with weight
times reach, the mass matrix with mass times reach^2, and so on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.model import JointKind, Mechanism

FALL = 9.81
SLIDE = 0.5
"""Travel [m] that counts for a slide."""
RATE = 2.0
"""Rates of the states [1/s], in the robot's own units."""


@dataclass(frozen=True, eq=False, slots=True)
class Sizes:
    """Sizes of a robot.

    Attributes:
        reach: longest way along the links [m].
        mass: of all links that move [kg].
        unit: (n,) of each coordinate: 1 or the reach.
    """

    reach: float
    mass: float
    unit: Floats

    @classmethod
    def of(cls, mechanism: Mechanism) -> Sizes:
        """Measured along the links, slides half a metre out."""
        way = {mechanism.links[0].name: float(np.linalg.norm(mechanism.T_sb[:3, 3]))}
        for joint in mechanism.joints:
            travel = SLIDE if joint.kind is JointKind.PRISMATIC else np.pi * abs(joint.pitch)
            way[joint.child] = way[joint.parent] + float(np.linalg.norm(joint.T_pj[:3, 3])) + travel
        ends = [
            way[link.name] + (0.0 if link.inertial is None else float(np.linalg.norm(link.inertial.com)))
            for link in mechanism.links
        ]
        reach = max(*ends, way[mechanism.tip] + float(np.linalg.norm(mechanism.T_lt[:3, 3])), 1e-3)
        mass = sum(link.inertial.mass for link in mechanism.links[1:] if link.inertial is not None)
        slides = [joint.kind is JointKind.PRISMATIC for joint in mechanism.coordinates]
        return cls(reach, max(mass, 1e-6), np.where(slides, reach, 1.0))

    def of_quantity(self, name: str) -> Floats:
        """Natural size of every entry of a quantity, broadcast to its core shape."""
        u, L, m = self.unit, self.reach, self.mass
        effort, inertia, uu = m * FALL * L, m * L * L, self.unit[:, None] * self.unit
        twist = np.array([1.0, 1.0, 1.0, L, L, L])
        match name:
            case "forward_kinematics" | "link_poses":
                return np.where(np.arange(4) == 3, L, 1.0) * np.ones((4, 1))
            case "jacobian_space" | "jacobian_body":
                return twist[:, None] / u
            case "jacobian_space_rate" | "jacobian_body_rate":
                return RATE * twist[:, None] / u
            case "mass_matrix":
                return inertia / uu
            case "coriolis_matrix":
                return RATE * inertia / uu
            case "christoffel_symbols":
                return inertia / (uu[:, :, None] * u)
            case "kinetic_energy" | "potential_energy":
                return np.array(effort)
            case "link_twists" | "com_twists":
                return RATE * twist
            case "link_accelerations" | "com_accelerations":
                return RATE**2 * twist
            case "link_wrenches" | "com_wrenches":
                return m * FALL * np.array([L, L, L, 1.0, 1.0, 1.0])
            case "regressor":
                return _parameters(L) / u[:, None, None]
            case "payload_regressor":
                return _parameters(L) / u[:, None]
            case "inverse_dynamics_derivatives":
                return np.stack([effort / uu, RATE * inertia / uu, inertia / uu])
            case _:
                return effort / u


def _parameters(reach: float) -> Floats:
    """(10,) what one unit of each inertial parameter of a body weighs at the reach."""
    return FALL * np.array([reach, *[1.0] * 3, *[1.0 / reach] * 6])
