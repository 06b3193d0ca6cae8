"""An arm of one joint after the other, from lists of parts: what tables and screws are turned into."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypedDict, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import PoseMatrix, Vector3, as_batch, frozen
from mafsil.errors import ModelError
from mafsil.model.actuator import Actuator, Friction
from mafsil.model.joint import Joint, JointKind
from mafsil.model.limits import Limits
from mafsil.model.link import Inertial, Link, moved_inertial
from mafsil.model.mechanism import STANDARD_GRAVITY, Mechanism, Provenance
from mafsil.model.placement import checked_pose

_Part = TypeVar("_Part")


class ArmParts(TypedDict, total=False):
    """What an arm has besides its kinematics; every key may be left out.

    Attributes:
        name: of the robot.
        inertials: n mass properties, or None for a massless link.
        limits, actuators, frictions: n each.
        joint_names: n names; `joint1`, `joint2` ... by default.
        link_names: n + 1 names, the base first; `base`, `link1` ... by default.
        gravity: (3,) acceleration in the space frame [m/s^2].
        provenance: where the numbers come from.
    """

    name: str
    inertials: Sequence[Inertial | None] | None
    limits: Sequence[Limits] | None
    actuators: Sequence[Actuator | None] | None
    frictions: Sequence[Friction | None] | None
    joint_names: Sequence[str] | None
    link_names: Sequence[str] | None
    gravity: Vector3 | tuple[float, float, float]
    provenance: Provenance


@dataclass(frozen=True, eq=False, slots=True)
class JointPlace:
    """Kinematics of one joint of an arm.

    Attributes:
        kind: revolute, prismatic or helical.
        T_pj: (4, 4) joint frame in the link before.
        T_li: (4, 4) frame of the link in which the user gives its mass properties, in the joint frame.
        pitch: of a helical joint [m/rad].
        axis: (3,) unit direction in the joint frame.
    """

    kind: JointKind
    T_pj: PoseMatrix
    T_li: PoseMatrix
    pitch: float = 0.0
    axis: Vector3 = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))


def serial_arm(
    places: Sequence[JointPlace],
    *,
    base: ArrayLike | None,
    T_lt: PoseMatrix,
    name: str = "robot",
    inertials: Sequence[Inertial | None] | None = None,
    limits: Sequence[Limits] | None = None,
    actuators: Sequence[Actuator | None] | None = None,
    frictions: Sequence[Friction | None] | None = None,
    joint_names: Sequence[str] | None = None,
    link_names: Sequence[str] | None = None,
    gravity: Vector3 | tuple[float, float, float] = STANDARD_GRAVITY,
    provenance: Provenance = Provenance(),
) -> Mechanism:
    """Joints in a row, from the base to the tip.

    Args:
        places: n joints.
        base: (4, 4) pose of the base link in the space frame; identity if None.
        T_lt: (4, 4) pose of the tip in the last link.
        name, inertials, limits, actuators, frictions, joint_names, link_names, gravity, provenance: see `ArmParts`.

    Raises:
        ModelError: a list has another length than it should, or a name is used twice.
        InputError: `base` or `gravity` has another shape or is not finite.
    """
    n = len(places)
    chain = _list("link_names", link_names, ["base", *(f"link{i + 1}" for i in range(n))])
    names = _list("joint_names", joint_names, [f"joint{i + 1}" for i in range(n)])
    bounds = _list("limits", limits, [Limits()] * n)
    motors: list[Actuator | None] = _list("actuators", actuators, [None] * n)
    brakes: list[Friction | None] = _list("frictions", frictions, [None] * n)
    masses: list[Inertial | None] = _list("inertials", inertials, [None] * n)
    return Mechanism.assemble(
        name,
        (Link(chain[0]), *(Link(chain[i + 1], _move(masses[i], places[i].T_li)) for i in range(n))),
        (
            Joint(
                name=names[i],
                kind=place.kind,
                parent=chain[i],
                child=chain[i + 1],
                T_pj=frozen(place.T_pj),
                pitch=place.pitch,
                axis=frozen(place.axis),
                limits=bounds[i],
                actuator=motors[i],
                friction=brakes[i],
            )
            for i, place in enumerate(places)
        ),
        tip=chain[-1],
        T_lt=T_lt,
        T_sb=np.eye(4) if base is None else checked_pose("base", base),
        gravity=as_batch("gravity", gravity, (3,), finite=True),
        provenance=provenance,
    )


def _move(inertial: Inertial | None, T_li: PoseMatrix) -> Inertial | None:
    return None if inertial is None else moved_inertial(inertial, T_li)


def _list(what: str, parts: Sequence[_Part] | None, default: list[_Part]) -> list[_Part]:
    """The parts given, as many as the default has, or the default."""
    if parts is None:
        return default
    if len(parts) != len(default):
        raise ModelError("serial.length", name=what, got=len(parts), expected=len(default))
    return list(parts)
