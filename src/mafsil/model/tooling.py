"""What a robot carries: the frame of a tool, and a payload that becomes part of a link."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import PoseMatrix, real_array, require_finite, single
from mafsil.errors import InputError, InputWarning, warn
from mafsil.model.link import Inertial, Link, moved_inertial
from mafsil.model.mass_properties import require_physical, unite_bodies
from mafsil.model.placement import checked_pose

LONGEST_TOOL = 10.0
"""Offset [m] beyond which that of a tool counts as one in millimetres, of 1 cm and more."""


def payload(mass: float, com: ArrayLike, inertia: ArrayLike | None, T_lm: PoseMatrix | None) -> Inertial:
    """A body in the frame of the link that carries it; arguments and errors as `Mechanism.with_payload`.

    Args:
        mass: [kg].
        com: (3,) [m] in its mounting frame.
        inertia: (3, 3) about the centre of mass [kg m^2]; zero if None.
        T_lm: (4, 4) mounting frame in the link; that of the link if None.
    """
    kilograms = float(single("mass", mass, ()))
    if kilograms < 0.0:
        raise InputError("input.range", name="mass", value=kilograms, low=0.0, high=np.inf)
    own = np.zeros((3, 3)) if inertia is None else single("inertia", inertia, (3, 3))
    body = Inertial(kilograms, single("com", com, (3,)), own)
    if own.any():
        require_physical(body)
    return body if T_lm is None else moved_inertial(body, T_lm)


def with_body(link: Link, body: Inertial) -> Link:
    """The link with a body fixed to it."""
    return replace(link, inertial=unite_bodies(link.inertial, body))


def tool_pose(name: str, value: ArrayLike | None) -> PoseMatrix:
    """A pose (4, 4), or the origin (3,) of one; the identity if None."""
    if value is None:
        return np.eye(4)
    array = real_array(name, value)
    place = array if array.shape == (3,) else array[..., :3, -1] if array.ndim > 1 else array
    if place.size and (longest := float(np.abs(place).max())) > LONGEST_TOOL:
        warn(InputWarning("input.millimetres", name=name, value=longest))
    if array.shape == (3,):
        T = np.eye(4)
        T[:3, 3] = require_finite(name, array)
        return T
    if array.shape != (4, 4):
        raise InputError("input.shape", name=name, expected="(4, 4) or (3,)", got=array.shape, hint="")
    return checked_pose(name, array)
