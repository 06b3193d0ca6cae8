"""Joint efforts as a linear model of parameters, and descriptions of robots with new numbers for them.

Parameters, P = 10 L + 4 n in this order: ten numbers of each link (see `mechanics.inertial_parameters`); viscous,
Coulomb and offset of each joint; the inertia of each joint's rotor. Base parameters are those that efforts decide.

Identified robots go into files: what the format can hold, and a sentence for what it cannot.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.identification.log import Remark
from mafsil.identification.smoothing import SmoothMotion, kernels
from mafsil.mechanics.body_tree import RigidInertia
from mafsil.mechanics.friction import friction_columns
from mafsil.mechanics.inertial_parameters import (
    LABELS,
    BaseParameters,
    independent_parameters,
    inertial_of,
    inertial_parameters,
    parameters_of,
    reflected_inertias,
)
from mafsil.model import Actuator, Friction, Joint, Mechanism
from mafsil.model.losses import Weight
from mafsil.model.saving import save as save_robot
from mafsil.robot import Robot

FRICTION = ("viscous", "coulomb", "offset")
"""Parameters of a joint's friction; then comes its rotor."""
STATES = 200
"""Random states at which the structure of the model is looked at."""
CHUNK = 2048
"""Rows of a log that are in memory at once."""


@dataclass(frozen=True, eq=False)
class TorqueModel:
    """The linear model of a robot: tau = columns @ parameters.

    Attributes:
        robot: its kinematics; its inertias play no part.
        smoothing: rate within which Coulomb friction changes its sign [rad/s | m/s].
    """

    robot: Robot
    smoothing: float

    @property
    def inertial_count(self) -> int:
        """How many parameters belong to links: 10 L."""
        return 10 * len(self.robot.mechanism.links)

    @property
    def rotor_count(self) -> int:
        """How many parameters belong to rotors, at the end."""
        return self.robot.n

    @property
    def nonnegative(self) -> NDArray[np.int64]:
        """Indices of viscous and Coulomb friction and of rotors."""
        start, n = self.inertial_count, self.robot.n
        return np.array([start + 3 * j + k for j in range(n) for k in range(2)] + [start + 3 * n + j for j in range(n)])

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """Names of the parameters, such as `link3.Ixx` and `joint2.coulomb`."""
        links = [f"{link.name}.{label}" for link in self.robot.mechanism.links for label in LABELS]
        friction = [f"{joint}.{label}" for joint in self.robot.joint_names for label in FRICTION]
        return (*links, *friction, *(f"{joint}.rotor" for joint in self.robot.joint_names))

    @cached_property
    def prior(self) -> Floats:
        """(P,) the parameters of the description; a difference between both senses of Coulomb is half an offset."""
        friction = np.zeros((self.robot.n, 3))
        for row, joint in zip(friction, self.robot.mechanism.coordinates, strict=True):
            f = joint.friction
            if f is not None:
                negative = f.coulomb if f.coulomb_negative is None else f.coulomb_negative
                row[:] = f.viscous, (f.coulomb + negative) / 2, f.offset + (f.coulomb - negative) / 2
        mechanism = self.robot.mechanism
        return np.concatenate([inertial_parameters(mechanism).ravel(), friction.ravel(), reflected_inertias(mechanism)])

    @cached_property
    def base(self) -> BaseParameters:
        """The base parameters: what some motion identifies; rotors last, so that links keep what they can explain."""
        rng = np.random.default_rng(0)
        W = self.columns(*rng.uniform(-2.0, 2.0, (3, STATES, self.robot.n)))
        return independent_parameters(self.labels, W.reshape(-1, W.shape[-1]))

    def columns(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        """(N, n, P) efforts per parameter."""
        count, n = q.shape
        Y = np.zeros((count, n, self.inertial_count + 4 * n))
        Y[..., : self.inertial_count] = self.robot.regressor(q, qd, qdd).reshape(count, n, -1)
        resistance = friction_columns(qd, self.smoothing)
        joints = np.asarray(np.arange(n), dtype=np.int64)
        for k in range(3):
            Y[:, joints, self.inertial_count + 3 * joints + k] = resistance[..., k]
        Y[:, joints, self.inertial_count + 3 * n + joints] = qdd
        return Y

    def equations(self, motion: SmoothMotion) -> Iterator[Floats]:
        """Blocks (rows, n, k + 1) of base columns and the efforts they should add up to, through the same kernel."""
        columns = list(self.base.columns)

        def rows(part: slice) -> Floats:
            Y = self.columns(motion.q[part], motion.qd[part], motion.qdd[part])[..., columns]
            return np.concatenate([Y, motion.tau[part][..., None]], axis=-1)

        return thin_rows(motion, rows)


def thin_rows(motion: SmoothMotion, rows: Callable[[slice], Floats]) -> Iterator[Floats]:
    """Blocks of rows under the kernel for efforts, thinned out to about one sample per independent one.

    Args:
        motion: how long it is, its kernel and period.
        rows: from a piece of the motion to (samples, n, columns).
    """
    half = motion.half
    weights = kernels(half, motion.period)[0]
    every = max(int(1.0 / (weights @ weights)), 1)
    centres = np.arange(half, len(motion.q) - half, every)
    group = max((CHUNK - 2 * half) // every, 1)
    for start in range(0, len(centres), group):
        chosen = centres[start : start + group]
        part = slice(int(chosen[0]) - half, int(chosen[-1]) + half + 1)
        thinning = np.zeros((len(chosen), part.stop - part.start))
        for row, centre in zip(thinning, chosen - part.start, strict=True):
            row[centre - half : centre + half + 1] = weights
        yield np.tensordot(thinning, rows(part), axes=1)


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
