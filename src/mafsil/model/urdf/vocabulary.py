"""Every element and attribute of URDF 1.0 to 1.2, and of its widespread extensions, and what becomes of it.

Facts from the schema and the parser of urdfdom 6, and from the documents of transmissions of ROS and of Drake.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType

from mafsil.model.diagnostics import Repair
from mafsil.model.faults import FOREIGN_ATTRIBUTE, UNKNOWN_ELEMENT, UNKNOWN_VERSION
from mafsil.model.reading import Reading
from mafsil.model.vocabulary import Row, Treatment, Version, Vocabulary
from mafsil.model.xml_tree import Element

FIRST, NEWEST = (1, 0), (1, 2)
WIDER_LIMITS = (1, 2)
"""From this version on what a `limit` does not give is infinite."""
_VERSION = re.compile(r"\s*\+?([0-9]{1,9})\.\s*\+?([0-9]{1,9})")

ROWS: Mapping[str, Row] = MappingProxyType(
    {
        "robot": Row(
            "name version",
            children="link joint material transmission",
            whole={
                Treatment.DATA: "gazebo verbose drake:collision_filter_group",
                Treatment.COMMAND: "ros2_control",
                Treatment.SENSING: "sensor",
                Treatment.LEFT_OUT: "loop_joint drake:joint drake:ball_constraint drake:linear_bushing_rpy "
                "drake:linear_spring_damper drake:prismatic_spring",
            },
            extensible=True,
        ),
        "link": Row(
            "name",
            {Treatment.DATA: "type"},
            children="inertial visual collision",
            whole={Treatment.CONTACT: "contact self_collision_checking", Treatment.SOLVER: "kinematic gravity"},
        ),
        "inertial": Row(children="origin mass inertia"),
        "origin": Row("xyz rpy quat_xyzw@1.1"),
        "mass": Row("value"),
        "inertia": Row("ixx ixy ixz iyy iyz izz"),
        "visual": Row(
            "name", children="origin geometry material", whole={Treatment.PICTURE: "drake:accepting_renderer verbose"}
        ),
        "collision": Row(
            "name",
            children="origin geometry",
            whole={
                Treatment.PICTURE: "material verbose",
                Treatment.CONTACT: "contact_coefficients drake:proximity_properties",
            },
        ),
        "geometry": Row(other={Treatment.DATA: "name"}, children="box cylinder sphere capsule mesh", judged=True),
        "box": Row("size"),
        "cylinder": Row("radius length"),
        "sphere": Row("radius"),
        "capsule": Row("radius length"),
        "mesh": Row("filename scale", whole={Treatment.CONTACT: "drake:declare_convex"}),
        "material": Row("name", children="color", whole={Treatment.PICTURE: "texture drake:diffuse_map"}),
        "color": Row("rgba"),
        "robot/joint": Row(
            "name type",
            {Treatment.DATA: "dont_collapse"},
            children="origin parent child axis limit dynamics mimic safety_controller",
            whole={Treatment.DATA: "calibration", Treatment.COMMAND: "hardwareInterface drake:controller_gains"},
        ),
        "parent": Row("link"),
        "child": Row("link"),
        "axis": Row("xyz"),
        "limit": Row("lower upper effort velocity acceleration@1.2 deceleration@1.2 jerk@1.2 drake:acceleration"),
        "dynamics": Row("damping friction"),
        "mimic": Row("joint multiplier offset"),
        "safety_controller": Row(other={Treatment.COMMAND: "soft_lower_limit soft_upper_limit k_position k_velocity"}),
        "transmission": Row(
            "name",
            {Treatment.DATA: "type"},
            children="joint actuator mechanicalReduction motorInertia",
            whole={
                Treatment.DATA: "type simulated_actuated_joint use_simulated_gripper_joint gap_joint passive_joint "
                "leftActuator rightActuator flexJoint rollJoint compensator motorTorqueConstant",
                Treatment.COMMAND: "hardwareInterface",
            },
            extensible=True,
        ),
        "transmission/joint": Row(
            "name",
            children="mechanicalReduction motorInertia",
            whole={Treatment.DATA: "role offset", Treatment.COMMAND: "hardwareInterface"},
            extensible=True,
        ),
        "transmission/actuator": Row(
            "name",
            children="mechanicalReduction motorInertia drake:gear_ratio drake:rotor_inertia",
            whole={
                Treatment.DATA: "role motorTorqueConstant encoderCountsPerRev drake:controller_gains",
                Treatment.COMMAND: "hardwareInterface",
            },
            extensible=True,
        ),
        "mechanicalReduction": Row(),
        "motorInertia": Row(),
        "drake:gear_ratio": Row("value"),
        "drake:rotor_inertia": Row("value"),
    }
)
"""What becomes of everything that a file may hold."""


def row_of(tag: str, parent: str) -> Row | None:
    """The row of an element that is read."""
    return ROWS.get(f"{parent}/{tag}") or ROWS.get(tag)


URDF = Vocabulary(
    "URDF", row_of, FOREIGN_ATTRIBUTE, UNKNOWN_ELEMENT, strict=False, is_neutral=lambda _tag, _attribute, _text: False,
    is_neutral_part=lambda _part: False,
)  # fmt: skip


def version_of(reading: Reading, robot: Element) -> Version:
    """The version that a robot declares; without one 1.0, as urdfdom has it. Others than 1.0 to 1.2 are errors."""
    text = robot.attributes.get("version")
    if text is None:
        return FIRST
    found = _VERSION.fullmatch(text)
    version = (int(found[1]), int(found[2])) if found else None
    if version is not None and FIRST <= version <= NEWEST:
        return version
    repair: Repair = reading.set_attribute(robot, "version", "1.0", guess=text.strip() != "1")
    reading.report(UNKNOWN_VERSION, robot, "version", repair, text=text)
    return NEWEST
