"""The form of a robot table: which keys it may have, of which type."""

from __future__ import annotations

from math import inf
from typing import Annotated, Literal

import msgspec

from mafsil.model.mechanism import STANDARD_GRAVITY

JOINT_LIMIT = 1000
"""Most joints of one file."""

Three = tuple[float, float, float]
Six = tuple[float, float, float, float, float, float]
Four = tuple[float, float, float, float]


class UnitsTable(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Units of the numbers of one file."""

    angle: Literal["rad", "deg"] = "rad"
    length: Literal["m", "mm"] = "m"


class PoseTable(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A constant pose: position and roll, pitch, yaw, or a matrix."""

    xyz: Three = (0.0, 0.0, 0.0)
    rpy: Three = (0.0, 0.0, 0.0)
    matrix: tuple[Four, Four, Four, Four] | None = None


class LimitsTable(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Bounds of a joint in the units of the file; efforts in N m or N."""

    lower: float = -inf
    upper: float = inf
    velocity: float = inf
    acceleration: float = inf
    jerk: float = inf
    effort: float = inf


class InertialTable(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Mass properties; `inertia` about the centre of mass in kg m^2, three numbers or six."""

    mass: Annotated[float, msgspec.Meta(ge=0)]
    com: Three = (0.0, 0.0, 0.0)
    inertia: Annotated[tuple[float, ...], msgspec.Meta(min_length=3, max_length=6)] = (0.0, 0.0, 0.0)


class ActuatorTable(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Motor and gear, SI."""

    rotor_inertia: float = 0.0
    gear_ratio: float = 1.0
    armature: float = 0.0


class FrictionTable(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Friction at the joint, SI."""

    viscous: float = 0.0
    coulomb: float = 0.0
    coulomb_negative: float | None = None
    offset: float = 0.0


class JointTable(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """One joint and the link that it moves."""

    name: str | None = None
    link: str | None = None
    kind: Literal["R", "P", "H"] = "R"
    a: float | None = None
    alpha: float | None = None
    d: float | None = None
    theta: float | None = None
    offset: float | None = None
    screw: Six | None = None
    xyz: Three | None = None
    rpy: Three | None = None
    matrix: tuple[Four, Four, Four, Four] | None = None
    axis: Three | None = None
    pitch: float | None = None
    limits: LimitsTable = LimitsTable()
    inertial: InertialTable | None = None
    actuator: ActuatorTable | None = None
    friction: FrictionTable | None = None


class ProvenanceTable(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Where the numbers come from."""

    source: str = ""
    licence: str = ""
    notes: tuple[str, ...] = ()


class RobotTable(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A whole file."""

    convention: Literal["modified", "classic", "space", "body", "frames"]
    joint: Annotated[list[JointTable], msgspec.Meta(min_length=1, max_length=JOINT_LIMIT)]
    name: str = "robot"
    base_link: str = "base"
    units: UnitsTable = UnitsTable()
    gravity: Three = STANDARD_GRAVITY
    base: PoseTable = PoseTable()
    tool: PoseTable = PoseTable()
    home: PoseTable | None = None
    provenance: ProvenanceTable = ProvenanceTable()


KEYS: dict[str, tuple[str, ...]] = {
    "modified": ("a", "alpha", "d", "theta", "offset"),
    "classic": ("a", "alpha", "d", "theta", "offset"),
    "space": ("screw",),
    "body": ("screw",),
    "frames": ("xyz", "rpy", "matrix", "axis", "pitch"),
}
"""Keys of a joint that belong to a convention."""
