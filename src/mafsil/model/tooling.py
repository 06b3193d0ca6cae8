"""What a robot carries (the frame of a tool, a payload that becomes part of a link), and joints locked in place.

A locked joint becomes a fixed one; the others keep their names and order.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from difflib import get_close_matches

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import PoseMatrix, frozen, real_array, require_finite, single
from mafsil.errors import InputError, InputWarning, ModelError, warn
from mafsil.model.joint import Joint, JointKind, require_lines
from mafsil.model.link import Inertial, Link, moved_inertial
from mafsil.model.mass_properties import require_physical, unite_bodies
from mafsil.model.placement import checked_pose, screw_motion
from mafsil.model.tolerances import WRITTEN

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


def lock_joints(joints: tuple[Joint, ...], coordinates: Mapping[str, float]) -> tuple[Joint, ...]:
    """The joints of a tree, some of them locked; arguments and errors as `Mechanism.with_locked_joints`."""
    values = _coordinates(joints, coordinates)
    return tuple(_locked_joint(joint, values) for joint in joints)


def _coordinates(joints: tuple[Joint, ...], coordinates: Mapping[str, float]) -> dict[str, float]:
    """The value of every joint that owns a coordinate and is locked."""
    moving = {joint.name: joint for joint in joints if joint.moves}
    if not isinstance(coordinates, Mapping):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise InputError("input.kind", name="coordinates", expected='{"joint": value}', got=type(coordinates).__name__)
    values: dict[str, float] = {}
    said: dict[str, str] = {}
    for name, given in coordinates.items():
        if name not in moving:
            close = get_close_matches(str(name), moving, n=3) or list(moving)
            raise ModelError("dh.lock_unknown", joint=name, known=", ".join(close))
        value = _number(name, given)
        mimic = moving[name].mimic
        leader = name if mimic is None else mimic.leader
        if mimic is not None:
            require_lines([moving[name]])
            if mimic.multiplier == 0.0:
                raise ModelError("dh.lock_idle", joint=name, value=mimic.offset)
            value = (value - mimic.offset) / mimic.multiplier
        if leader in values and abs(values[leader] - value) > WRITTEN * max(1.0, abs(value)):
            values_given = {"first": values[leader], "second": value}
            raise ModelError("dh.lock_contradiction", joint=name, other=said[leader], leader=leader, **values_given)
        values[leader], said[leader] = value, name
    return values


def _number(name: str, given: float) -> float:
    value = real_array(name, given)
    if value.size != 1 or not abs(float(value.reshape(-1)[0])) < float("inf"):
        raise InputError("input.finite_alone", name=name, value=given)
    return float(value.reshape(-1)[0])


def _locked_joint(joint: Joint, values: Mapping[str, float]) -> Joint:
    """The joint fixed where it stands when the coordinates have their values; itself if it depends on none of them."""
    mimic = joint.mimic
    owner = joint.name if mimic is None else mimic.leader
    if not joint.moves or owner not in values:
        return joint
    value = values[owner] if mimic is None else mimic.value(values[owner])
    T_pj = frozen(joint.T_pj @ screw_motion(joint.screw, value))
    return replace(joint, kind=JointKind.FIXED, T_pj=T_pj, pitch=0.0, mimic=None)
