"""The form of a robot table, key by key and type by type, and the mechanism that a valid one describes, in SI units."""

from __future__ import annotations

from dataclasses import replace
from math import inf, radians
from typing import Annotated, Literal

import msgspec
import numpy as np

from mafsil.arrays import Floats, PoseMatrix, Vector6, frozen
from mafsil.errors import ModelError
from mafsil.model.denavit_hartenberg import DHRow, mechanism_from_dh
from mafsil.model.exponentials import ArmParts, JointPlace, mechanism_from_screws, serial_arm
from mafsil.model.joint import JointKind
from mafsil.model.limits import Actuator, Friction, Limits
from mafsil.model.link import Inertial
from mafsil.model.mechanism import STANDARD_GRAVITY, Mechanism, Provenance
from mafsil.model.placement import checked_pose, pose_from_xyz_rpy

JOINT_LIMIT = 1000
"""Most joints of one file."""
Three = tuple[float, float, float]
Six = tuple[float, float, float, float, float, float]
Four = tuple[float, float, float, float]
KEYS: dict[str, tuple[str, ...]] = {
    "modified": ("a", "alpha", "d", "theta", "offset"),
    "classic": ("a", "alpha", "d", "theta", "offset"),
    "space": ("screw",),
    "body": ("screw",),
    "frames": ("xyz", "rpy", "matrix", "axis", "pitch"),
}
"""Keys of a joint that belong to a convention."""
KINDS = {"R": JointKind.REVOLUTE, "P": JointKind.PRISMATIC, "H": JointKind.HELICAL}


def mechanism_of(table: RobotTable) -> Mechanism:
    """The mechanism of a valid table."""
    angle_unit, length_unit = _units(table)
    parts = _parts(table, angle_unit, length_unit)
    base, tool = _pose(table.base, angle_unit, length_unit), _pose(table.tool, angle_unit, length_unit)
    if table.convention in ("modified", "classic"):
        rows = [_row(joint, angle_unit, length_unit) for joint in table.joint]
        return mechanism_from_dh(rows, table.convention, base=base, tool=tool, **parts)
    if table.convention == "frames":
        return serial_arm(
            [_place(joint, angle_unit, length_unit) for joint in table.joint], base=base, T_lt=tool, **parts
        )
    screws = [_screw(joint, length_unit) for joint in table.joint]
    home = _pose(table.home or PoseTable(), angle_unit, length_unit)
    arm = mechanism_from_screws(screws, home, form="space" if table.convention == "space" else "body", **parts)
    return replace(arm, T_sb=frozen(base), T_lt=frozen(arm.T_lt @ tool))


def constants_of(table: RobotTable) -> tuple[PoseMatrix | None, PoseMatrix | None]:
    """Base and tool of a valid table in metres, None where the file says nothing about them."""
    angle_unit, length_unit = _units(table)
    base, tool = (
        None if pose == PoseTable() else _pose(pose, angle_unit, length_unit) for pose in (table.base, table.tool)
    )
    return base, tool


def rows_of(table: RobotTable) -> tuple[DHRow, ...]:
    """The Denavit-Hartenberg rows of a valid table in SI."""
    return tuple(_row(joint, *_units(table)) for joint in table.joint)


def screws_of(table: RobotTable) -> tuple[Vector6, ...]:
    """The screw axes of a valid table, lengths in metres."""
    return tuple(_screw(joint, _units(table)[1]) for joint in table.joint)


def _units(table: RobotTable) -> tuple[float, float]:
    """Radians and metres of the file's units."""
    return (radians(1.0) if table.units.angle == "deg" else 1.0), (1e-3 if table.units.length == "mm" else 1.0)


def _parts(table: RobotTable, angle_unit: float, length_unit: float) -> ArmParts:
    """Everything besides the kinematics, in SI."""
    joints = table.joint
    return ArmParts(
        name=table.name,
        inertials=[_inertial(joint.inertial, length_unit) for joint in joints],
        limits=[_limits(joint.limits, length_unit if _is_prismatic(joint) else angle_unit) for joint in joints],
        actuators=[
            None
            if (motor := joint.actuator) is None
            else Actuator(motor.rotor_inertia, motor.gear_ratio, motor.armature)
            for joint in joints
        ],
        frictions=[
            None
            if (brake := joint.friction) is None
            else Friction(brake.viscous, brake.coulomb, brake.coulomb_negative, brake.offset)
            for joint in joints
        ],
        joint_names=[joint.name or f"joint{k}" for k, joint in enumerate(joints, start=1)],
        link_names=[table.base_link, *(joint.link or f"link{k}" for k, joint in enumerate(joints, start=1))],
        gravity=table.gravity,
        provenance=Provenance(table.provenance.source, table.provenance.licence, table.provenance.notes),
    )


def _row(joint: JointTable, angle_unit: float, length_unit: float) -> DHRow:
    """A Denavit-Hartenberg row in SI."""
    if joint.kind == "H":
        raise ModelError("table.kind", joint=joint.name or "", kind=joint.kind)
    return DHRow(
        a=length_unit * (joint.a or 0.0),
        alpha=angle_unit * (joint.alpha or 0.0),
        d=length_unit * (joint.d or 0.0),
        theta=angle_unit * (joint.theta or 0.0),
        kind=joint.kind,
        offset=(angle_unit if joint.kind == "R" else length_unit) * (joint.offset or 0.0),
    )


def _place(joint: JointTable, angle_unit: float, length_unit: float) -> JointPlace:
    """A joint at a free frame, about a free axis."""
    zero = (0.0, 0.0, 0.0)
    pose = _pose(PoseTable(joint.xyz or zero, joint.rpy or zero, joint.matrix), angle_unit, length_unit)
    axis = np.array(joint.axis or (0.0, 0.0, 1.0))
    length = float(np.linalg.norm(axis))
    if length == 0.0:
        raise ModelError("table.axis", joint=joint.name or "")
    return JointPlace(KINDS[joint.kind], pose, np.eye(4), length_unit * (joint.pitch or 0.0), axis / length)


def _pose(table: PoseTable, angle_unit: float, length_unit: float) -> PoseMatrix:
    """A pose (4, 4) in metres."""
    if table.matrix is None:
        return pose_from_xyz_rpy(tuple(length_unit * x for x in table.xyz), tuple(angle_unit * x for x in table.rpy))
    T = np.array(checked_pose("matrix", table.matrix))
    T[:3, 3] *= length_unit
    return T


def _screw(joint: JointTable, length_unit: float) -> Vector6:
    """A screw with v in metres; the direction of a prismatic screw has no unit."""
    S: Floats = np.array(joint.screw)
    return S if _is_prismatic(joint) else S * np.array([1.0, 1.0, 1.0, length_unit, length_unit, length_unit])


def _is_prismatic(joint: JointTable) -> bool:
    """Whether the coordinate is a length."""
    return joint.kind == "P" if joint.screw is None else not any(joint.screw[:3])


def _limits(table: LimitsTable, unit: float) -> Limits:
    bounds = (table.lower, table.upper, table.velocity, table.acceleration, table.jerk)
    return Limits(*(unit * bound for bound in bounds), effort=table.effort)


def _inertial(table: InertialTable | None, length_unit: float) -> Inertial | None:
    if table is None:
        return None
    xx, yy, zz, xy, xz, yz = (*table.inertia, 0.0, 0.0, 0.0)[:6]
    com = [length_unit * x for x in table.com]
    return Inertial(table.mass, frozen(com), frozen([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))


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
