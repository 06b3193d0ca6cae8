"""Chains with some joints locked: the joint becomes a fixed one, the others keep their names and order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from difflib import get_close_matches

from mafsil.arrays import frozen, real_array
from mafsil.errors import InputError, ModelError
from mafsil.model.joint import Joint, JointKind, require_lines
from mafsil.model.placement import screw_motion
from mafsil.model.tolerances import WRITTEN


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
        raise InputError("input.finite", name=name, value=given, index=())
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
