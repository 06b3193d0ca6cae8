"""Robots without enough mass: quantities that would be zeros or NaN are refused, with the reason."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.errors import InputError, ModelError
from mafsil.mechanics.catalogue import quantity
from mafsil.mechanics.mass_matrix_singularity import MassMatrixSingularity
from mafsil.mechanics.quantity import Quantity
from mafsil.model import Mechanism
from mafsil.model.moved_matter import joints_that_move_matter
from mafsil.robot.routines import signature_of

NO_FINITE_ANSWER = ("call.overflow", "call.undefined")
"""Keys of the errors of a kernel that finds no finite number."""


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


def may_be_singular(mechanism: Mechanism) -> bool:
    """Whether some joint moves no matter of its own, so that the mass matrix may be singular at some position.

    Args:
        mechanism: the robot.
    """
    moving = {joint.name for joint in mechanism.joints if joint.moves}
    return not moving <= joints_that_move_matter(mechanism)


class Answered:
    """A routine that divides by the mass matrix: a single call that has no finite answer raises, with the reason.

    In batches such rows stay NaN, and the others keep their numbers.

    Args:
        name: of the quantity.
        routine: which gives NaN there.
        singularity: of a position, by the robot of the routine.
    """

    def __init__(self, name: str, routine: Any, singularity: Callable[..., MassMatrixSingularity]) -> None:
        self.name, self.routine, self.singularity = name, routine, singularity
        self.row = quantity(name)
        self.__name__, self.__doc__, self.__signature__ = name, self.routine.__doc__, signature_of(self.row)

    def __call__(self, *arrays: Any, **named: Any) -> Floats:
        """As the routine.

        Raises:
            ModelError: the mass matrix is singular at this position; the joints and their motion are named.
            InputError: as the routine.
        """
        try:
            found: Floats = self.routine(*arrays, **named)
        except InputError as error:
            if error.key in NO_FINITE_ANSWER:
                self._require_regular(*arrays[:1], **named)
            raise
        if found.ndim == len(self.row.shape) and not np.isfinite(found).all():
            self._require_regular(*arrays[:1], **named)
        return found

    def _require_regular(self, q: ArrayLike, *, degrees: bool = False, **_: Any) -> None:
        self.singularity(q, degrees=degrees).require_regular()

    def __reduce__(self) -> tuple[type[Answered], tuple[Any, ...]]:
        return Answered, (self.name, self.routine, self.singularity)
