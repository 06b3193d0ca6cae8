"""Quantities that mean nothing for an arm without masses: refused, where zeros would look like an answer."""

from __future__ import annotations

from mafsil.errors import ModelError
from mafsil.model import Mechanism

OF_MASSES = frozenset(
    {
        "inverse_dynamics", "forward_dynamics", "mass_matrix", "coriolis_matrix", "velocity_torque", "gravity_torque",
        "kinetic_energy", "potential_energy", "centrifugal_torque", "coriolis_torque", "christoffel_symbols",
        "lagrange_torque", "inverse_dynamics_derivatives", "forward_dynamics_derivatives", "link_wrenches",
        "com_wrenches",
    }
)  # fmt: skip
"""Names of the catalogue whose value is zero everywhere, or undefined, where nothing has mass."""


def require_masses(mechanism: Mechanism, name: str) -> None:
    """Refuse a quantity of masses for a mechanism in which nothing has any.

    Args:
        mechanism: the robot.
        name: of the catalogue.

    Raises:
        ModelError: no link has mass or inertia and no motor a rotor; the sentence says how to give them.
    """
    if name in OF_MASSES and not _has_inertia(mechanism):
        raise ModelError("robot.massless", robot=mechanism.name, name=name)


def _has_inertia(mechanism: Mechanism) -> bool:
    bodies = (link.inertial for link in mechanism.links)
    heavy = any(body is not None and (body.mass > 0.0 or body.inertia.any()) for body in bodies)
    motors = (joint.actuator for joint in mechanism.joints)
    return heavy or any(motor is not None and motor.reflected_inertia > 0.0 for motor in motors)
