"""Every element and attribute of SDFormat 1.4 to 1.12 around a mechanism, and what becomes of it.

Facts from the specification files of libsdformat, which brings older files to its newest version before it reads them:
words of later versions are read in older files too, those that a later version gave up carry the last one that has
them. Numbers stand as text between tags.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType

from mafsil.model.faults import FOREIGN_ATTRIBUTE, UNKNOWN_ELEMENT
from mafsil.model.vocabulary import Row, Treatment, Version, Vocabulary
from mafsil.model.xml_tree import Element

NEWEST = (1, 12)
_PLACED = {Treatment.DATA: "frame@-1.6"}
_AXIS = Row(
    children="xyz dynamics limit mimic use_parent_model_frame@-1.6", whole={Treatment.DATA: "initial_position@-1.8"}
)

ROWS: Mapping[str, Row] = MappingProxyType(
    {
        "sdf": Row(
            "version", children="world", whole={Treatment.DATA: "model include", Treatment.PICTURE: "actor light"}
        ),
        "gazebo": Row(
            "version", children="world", whole={Treatment.DATA: "model include", Treatment.PICTURE: "actor light"}
        ),
        "world": Row(
            "name",
            children="gravity",
            whole={
                Treatment.DATA: "model include frame plugin spherical_coordinates state population",
                Treatment.PICTURE: "actor audio gui light road scene",
                Treatment.SOLVER: "physics",
                Treatment.MEDIUM: "atmosphere magnetic_field wind",
                Treatment.LEFT_OUT: "joint",
            },
        ),
        "model": Row(
            "name placement_frame merge",
            {Treatment.DATA: "canonical_link namespace"},
            children="static pose link joint frame model include",
            whole={
                Treatment.SOLVER: "allow_auto_disable",
                Treatment.CONTACT: "self_collide",
                Treatment.MEDIUM: "enable_wind",
                Treatment.COMMAND: "plugin",
                Treatment.DATA: "gripper model_state drake:collision_filter_group",
                Treatment.LEFT_OUT: "drake:joint drake:ball_constraint drake:linear_bushing_rpy "
                "drake:linear_spring_damper drake:prismatic_spring",
            },
        ),
        "include": Row(
            "merge",
            children="uri name pose static placement_frame",
            whole={Treatment.COMMAND: "plugin", Treatment.DATA: "namespace model_state"},
        ),
        "pose": Row("relative_to rotation_format degrees frame@-1.6"),
        "frame": Row("name attached_to", children="pose"),
        "link": Row(
            "name",
            children="pose inertial collision visual",
            whole={
                Treatment.LEFT_OUT: "gravity kinematic velocity_decay",
                Treatment.CONTACT: "self_collide",
                Treatment.SENSING: "sensor",
                Treatment.PICTURE: "audio_sink audio_source light particle_emitter projector",
                Treatment.MEDIUM: "enable_wind",
                Treatment.DATA: "battery must_be_base_link frame@-1.6",
            },
        ),
        "inertial": Row(
            "auto",
            children="mass pose inertia density",
            whole={Treatment.MEDIUM: "fluid_added_mass", Treatment.DATA: "auto_inertia_params frame@-1.6"},
        ),
        "inertia": Row(children="ixx ixy ixz iyy iyz izz"),
        "collision": Row(
            "name",
            children="pose geometry density",
            whole={
                Treatment.SENSING: "laser_retro",
                Treatment.CONTACT: "max_contacts surface drake:proximity_properties",
                Treatment.DATA: "auto_inertia_params frame@-1.6",
            },
        ),
        "visual": Row(
            "name",
            children="pose geometry material",
            whole={
                Treatment.PICTURE: "cast_shadows laser_retro meta plugin transparency visibility_flags "
                "drake:accepting_renderer",
                **_PLACED,
            },
        ),
        "geometry": Row(
            children="box capsule cylinder mesh sphere",
            whole={
                Treatment.CONTACT: "cone ellipsoid empty heightmap image plane polyline drake:capsule drake:ellipsoid"
            },
            judged=True,
        ),
        "box": Row(children="size"),
        "capsule": Row(children="radius length"),
        "cylinder": Row(children="radius length"),
        "sphere": Row(children="radius"),
        "mesh": Row(
            other={Treatment.CONTACT: "optimization"},
            children="uri scale",
            whole={Treatment.CONTACT: "convex_decomposition drake:declare_convex", Treatment.LEFT_OUT: "submesh"},
        ),
        "material": Row(
            children="diffuse",
            whole={
                Treatment.PICTURE: "ambient double_sided emissive lighting pbr render_order script shader shininess "
                "specular"
            },
        ),
        "joint": Row(
            "name type",
            children="parent child pose axis axis2 gearbox_ratio gearbox_reference_body thread_pitch "
            "screw_thread_pitch drake:gear_ratio drake:rotor_inertia drake:mimic",
            whole={
                Treatment.SOLVER: "physics",
                Treatment.SENSING: "sensor",
                Treatment.COMMAND: "drake:controller_gains",
                **_PLACED,
            },
        ),
        "axis": _AXIS,
        "axis2": _AXIS,
        "xyz": Row("expressed_in"),
        "dynamics": Row(children="damping friction spring_stiffness", whole={Treatment.SPRING: "spring_reference"}),
        "limit": Row(
            children="lower upper effort velocity drake:acceleration", whole={Treatment.SOLVER: "stiffness dissipation"}
        ),
        "mimic": Row("joint axis", children="multiplier offset reference"),
        "drake:mimic": Row("joint multiplier offset"),
    }
)
"""What becomes of everything that a file may hold; elements without a row are text alone."""
_TEXT = Row()
_NEUTRAL = {"gravity": ("", "true", "1"), "kinematic": ("", "false", "0")}


def row_of(tag: str, _parent: str) -> Row:
    """The row of an element that is read."""
    return ROWS.get(tag, _TEXT)


def _changes_nothing(element: Element) -> bool:
    """Whether an element that is left out has the value that it has without it."""
    if element.tag in _NEUTRAL:
        return element.text.strip().lower() in _NEUTRAL[element.tag]
    return not element.text and all(child.text.strip() in ("", "0", "0.0") for child in element.children)


SDF = Vocabulary(
    "SDFormat", row_of, FOREIGN_ATTRIBUTE, UNKNOWN_ELEMENT, strict=False,
    is_neutral=lambda _tag, _attribute, _text: False, is_neutral_part=_changes_nothing,
)  # fmt: skip


def version_of(root: Element) -> Version:
    """The version that a file declares; the newest if it declares none."""
    found = re.match(r"(\d{1,3})\.(\d{1,3})", root.get("version"))
    return NEWEST if found is None else (int(found[1]), int(found[2]))
