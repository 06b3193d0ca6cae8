"""The efforts of a motion, separated by where they come from."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, as_batch
from mafsil.errors import InputError
from mafsil.mechanics.inertial_parameters import reflected_inertias
from mafsil.robot.compiled_robot import CompiledRobot


@dataclass(frozen=True, eq=False, slots=True)
class TorqueTerms:
    """Joint efforts by name, each (*batch, n) [N m | N]; together they are the whole effort.

    Attributes:
        links: M qdd of the links.
        rotors: reflected rotor inertia times qdd.
        centrifugal: the part of c with squares of one rate.
        coriolis: the part of c with products of different rates.
        gravity: what holds the links up.
        friction: viscous, Coulomb and offset.
        tip: J' F_tip, what the tip does to the world.
        other: what the caller gave, such as springs.
    """

    links: Floats
    rotors: Floats
    centrifugal: Floats
    coriolis: Floats
    gravity: Floats
    friction: Floats
    tip: Floats
    other: Floats

    @property
    def total(self) -> Floats:
        """(*batch, n) the sum of all terms."""
        return self.without()

    def only(self, *names: str) -> Floats:
        """(*batch, n) the sum of the named terms.

        Raises:
            InputError: a name that is no term.
        """
        _known(names)
        return sum((getattr(self, name) for name in dict.fromkeys(names)), np.zeros_like(self.links))

    def without(self, *names: str) -> Floats:
        """(*batch, n) the sum of all terms but the named ones.

        Raises:
            InputError: a name that is no term.
        """
        return self.only(*(name for name in _known(names) if name not in names))


def _known(names: tuple[str, ...]) -> tuple[str, ...]:
    """All terms, after a look that the named ones are among them."""
    known = tuple(field.name for field in fields(TorqueTerms))
    for name in names:
        if name not in known:
            raise InputError("input.choice", name="term", value=name, known=", ".join(known))
    return known


def torque_terms_of(
    robot: CompiledRobot,
    q: ArrayLike,
    qd: ArrayLike,
    qdd: ArrayLike,
    tip_wrench: ArrayLike | None,
    other: ArrayLike | None,
    smoothing: float,
) -> TorqueTerms:
    """The terms; arguments as in `Robot.torque_terms`, and the robot."""
    given = (("q", q), ("qd", qd), ("qdd", qdd), ("other", np.zeros(robot.n) if other is None else other))
    motion = [as_batch(name, value, (robot.n,), finite=True) for name, value in given]
    wrench = None if tip_wrench is None else as_batch("tip_wrench", tip_wrench, (6,), finite=True)
    batch = np.broadcast_shapes(*(part.shape[:-1] for part in motion), () if wrench is None else wrench.shape[:-1])
    position, rate, acceleration, rest = (np.broadcast_to(part, (*batch, robot.n)).copy() for part in motion)
    rotors: JointVector = reflected_inertias(robot.mechanism) * acceleration
    inertia = np.einsum("...ij,...j->...i", robot.mass_matrix(position), acceleration)
    tip = np.zeros_like(rotors)
    if wrench is not None:
        tip = np.einsum("...ji,...j->...i", robot.jacobian_body(position), wrench)
    return TorqueTerms(
        links=inertia - rotors,
        rotors=rotors,
        centrifugal=robot.centrifugal_torque(position, rate),
        coriolis=robot.coriolis_torque(position, rate),
        gravity=robot.gravity_torque(position),
        friction=robot.friction_torque(rate, smoothing=smoothing),
        tip=tip,
        other=rest,
    )
