"""Quantities that mean nothing for an arm without masses: refused, where zeros would look like an answer."""

from __future__ import annotations

from mafsil.errors import ModelError
from mafsil.mechanics.quantity import Quantity
from mafsil.model import Mechanism


def require_masses(mechanism: Mechanism, row: Quantity) -> None:
    """Refuse a quantity of masses for a mechanism in which nothing has any.

    Args:
        mechanism: the robot.
        row: the quantity.

    Raises:
        ModelError: no link has mass or inertia and no motor a rotor; the sentence says how to give them.
    """
    if row.needs_mass and not has_inertia(mechanism):
        raise ModelError("robot.massless", robot=mechanism.name, name=row.name)


def has_inertia(mechanism: Mechanism) -> bool:
    """Whether a link has mass or inertia, or a motor a rotor."""
    bodies = (link.inertial for link in mechanism.links)
    heavy = any(body is not None and (body.mass > 0.0 or body.inertia.any()) for body in bodies)
    motors = (joint.actuator for joint in mechanism.joints)
    return heavy or any(motor is not None and motor.reflected_inertia > 0.0 for motor in motors)
