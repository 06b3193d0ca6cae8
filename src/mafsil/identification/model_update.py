"""A description with new numbers: masses, friction, rotors, loads.

Identified robots in files: what the format can hold, and a sentence for what it cannot.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from mafsil.arrays import Floats
from mafsil.identification.remark import Remark
from mafsil.identification.torque_model import TorqueModel
from mafsil.mechanics.body_tree import RigidInertia
from mafsil.mechanics.inertial_parameters import inertial_of, parameters_of
from mafsil.model import Actuator, Friction, Joint, Mechanism
from mafsil.model.losses import Weight
from mafsil.model.saving import save as save_robot

LEFT_OUT = {".urdf": ("gravity", "actuator", "friction", "limits", "passive", "tip"), ".toml": ("shapes",)}
"""What a format may lose; the remarks say what it did."""


def with_parameters(model: TorqueModel, found: Floats, rotors: bool) -> Mechanism:
    """The description with new masses, friction and rotors; what the data do not touch stays to the last digit.

    Args:
        model: the robot and the order of its parameters.
        found: (P,) all parameters.
        rotors: whether rotors were looked for; otherwise the description's stay.
    """
    mechanism, n = model.robot.mechanism, model.robot.n
    links = tuple(
        link if np.array_equal(part, old) else replace(link, inertial=inertial_of(part))
        for link, part, old in zip(
            mechanism.links,
            found[: model.inertial_count].reshape(-1, 10),
            model.prior[: model.inertial_count].reshape(-1, 10),
            strict=True,
        )
    )
    friction = found[model.inertial_count : -n].reshape(n, 3)
    order = {joint.name: k for k, joint in enumerate(mechanism.coordinates)}
    joints = tuple(
        _resist(joint, friction[order[joint.name]], found[-n:][order[joint.name]] if rotors else None)
        if joint.name in order
        else replace(joint, friction=None)
        for joint in mechanism.joints
    )
    return replace(mechanism, links=links, joints=joints)


def _resist(joint: Joint, friction: Floats, rotor: float | None) -> Joint:
    """A joint with friction and, if it was looked for, the inertia of its rotor, all referred to the joint."""
    viscous, coulomb, offset = map(float, friction)
    actuator = joint.actuator
    if rotor is not None:
        motor = actuator or Actuator()
        if motor.rotor_inertia and motor.gear_ratio:
            actuator = replace(motor, rotor_inertia=float(rotor) / motor.gear_ratio**2, armature=0.0)
        else:
            actuator = replace(motor, armature=float(rotor))
    return replace(joint, friction=Friction(viscous, coulomb, None, offset), actuator=actuator)


def with_load(mechanism: Mechanism, load: Floats) -> Mechanism:
    """The description with a body fixed to its tip frame.

    Args:
        mechanism: without the body.
        load: (10,) parameters of the body in the tip frame.
    """
    m, h = float(load[0]), load[1:4]
    xx, yy, zz, xy, xz, yz = load[4:]
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    at_tip = RigidInertia(m, h, inertia).in_frame(mechanism.T_lt[:3, :3], mechanism.T_lt[:3, 3])
    I = at_tip.I
    added = np.array([at_tip.mass, *at_tip.h, I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]])
    tip = mechanism.link(mechanism.tip)
    loaded = replace(tip, inertial=inertial_of(parameters_of(tip.inertial) + added))
    return replace(mechanism, links=tuple(loaded if link is tip else link for link in mechanism.links))


def save(mechanism: Mechanism, path: Path) -> tuple[Remark, ...]:
    """Write a .toml table or a .urdf file and say what it could not keep.

    Args:
        mechanism: what to write.
        path: an existing file is replaced.

    Raises:
        FileError: the place cannot be written.
        ModelError: a mechanism that the format cannot hold.
    """
    losses = save_robot(mechanism, path, without=LEFT_OUT[path.suffix.lower()])
    lost = [loss for loss in losses if loss.weight is not Weight.NOTED]
    return tuple(Remark("identification.lost", {"path": path.name, "loss": loss}) for loss in lost)
