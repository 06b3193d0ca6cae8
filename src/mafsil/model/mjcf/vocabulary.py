"""Every element and attribute of MJCF, and what becomes of it: read, without bearing on a mechanism, left out.

The table is the rule of the reader: what stands in it as read is read, what it does not know is an error. `frame`,
`replicate` and `worldbody` hold what a body holds, and a default class sets attributes of the elements it names.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from mafsil.model.faults import UNKNOWN_ATTRIBUTE, UNKNOWN_PART
from mafsil.model.vocabulary import Row, Treatment, Vocabulary

_TURN = "quat axisangle euler xyaxes zaxis"
_INSIDE = "body frame replicate attach inertial joint freejoint geom site"
_BESIDE = {
    Treatment.PICTURE: "camera light",
    Treatment.LEFT_OUT: "plugin",
    Treatment.SOFT: "composite flexcomp",
}
_SOLVED = "solref solimp solreflimit solimplimit solreffriction solimpfriction margin"
_JOINT = Row(
    "name class type pos axis range limited ref armature damping frictionloss actuatorfrcrange actuatorfrclimited",
    {
        Treatment.LEFT_OUT: "stiffness springdamper actuatorgravcomp",
        Treatment.SPRING: "springref springyield",
        Treatment.SOLVER: _SOLVED,
        Treatment.DATA: "group user",
    },
)
_GEOM = Row(
    f"name class type size fromto pos {_TURN} mesh fitscale mass density shellinertia group contype conaffinity "
    "rgba material hfield",
    {
        Treatment.CONTACT: "condim friction priority solmix solref solimp margin gap surfacevel adhesion",
        Treatment.MEDIUM: "fluidshape fluidcoef",
        Treatment.PICTURE: "castshadow",
        Treatment.DATA: "user",
    },
    whole={Treatment.DATA: "plugin"},
)
_SITE = Row(
    f"name class pos {_TURN} fromto",
    {Treatment.SENSING: "type size", Treatment.PICTURE: "rgba material mesh", Treatment.DATA: "group user"},
)
_MESH = Row(
    "name class file vertex face refpos refquat scale inertia maxhullvert builtin content_type",
    {Treatment.PICTURE: "normal texcoord smoothnormal material", Treatment.DATA: "params"},
    children="plugin",
)
_MATERIAL = Row(
    "name class rgba",
    {Treatment.PICTURE: "texture texrepeat texuniform emission specular shininess reflectance metallic roughness"},
    whole={Treatment.PICTURE: "layer"},
)
_CONSTRAINT = {Treatment.SOLVER: "solref solimp"}
_TENDON = Row(
    "name class armature",
    {
        Treatment.LEFT_OUT: "stiffness damping frictionloss limited range actuatorfrclimited actuatorfrcrange",
        Treatment.SPRING: "springlength springyield",
        Treatment.SOLVER: _SOLVED,
        Treatment.PICTURE: "rgba material width",
        Treatment.DATA: "group user",
    },
    children="joint",
    whole={Treatment.SENSING: "site geom pulley"},
)
_ACTUATOR = Row(
    "name class joint jointinparent tendon gear forcelimited forcerange ctrllimited ctrlrange armature damping",
    {
        Treatment.LEFT_OUT: "site body refsite slidersite cranksite",
        Treatment.COMMAND: "actdim actearly actlimited actrange biasprm biastype gainprm gaintype dynprm dyntype "
        "kp kv ki dampratio timeconst inheritrange input imax posrange velrange ffrange slewmax area bias diameter "
        "force fpmax fvmax lmax lmin range scale tausmooth vmax gain cogging controller inductance lugre motorconst "
        "nominal resistance saturation thermal lengthrange cranklength delay interp nsample",
        Treatment.DATA: "group user plugin instance",
    },
    whole={Treatment.DATA: "config"},
)
MOTORS = (
    "general", "motor", "position", "velocity", "intvelocity", "orientation", "pid", "damper", "cylinder", "muscle",
    "adhesion", "dcmotor", "plugin",
)  # fmt: skip
"""Elements of `actuator`; all have the row of the first."""

ROWS: Mapping[str, Row] = MappingProxyType(
    {
        "mujoco": Row(
            "model",
            children="compiler option default asset worldbody tendon equality actuator deformable include keyframe",
            whole={
                Treatment.PICTURE: "visual statistic",
                Treatment.CONTACT: "contact",
                Treatment.SENSING: "sensor",
                Treatment.DATA: "size custom extension",
            },
        ),
        "keyframe": Row(children="key"),
        "key": Row("name qpos", {Treatment.DATA: "time qvel act mpos mquat plastic", Treatment.COMMAND: "ctrl"}),
        "compiler": Row(
            "angle autolimits balanceinertia boundinertia boundmass coordinate eulerseq fitaabb inertiafromgeom "
            "inertiagrouprange settotalmass meshdir assetdir strippath",
            {
                Treatment.PICTURE: "texturedir discardvisual",
                Treatment.CONVERTING: "fusestatic alignfree conflict passthrough savecanonical savecompiled "
                "saveinertial usethread convexhull exactmeshinertia",
            },
            whole={Treatment.COMMAND: "lengthrange"},
        ),
        "option": Row(
            "gravity",
            {
                Treatment.LEFT_OUT: "density viscosity",
                Treatment.MEDIUM: "wind",
                Treatment.SENSING: "magnetic",
                Treatment.CONTACT: "o_margin o_solref o_solimp o_friction",
                Treatment.COMMAND: "actuatorgroupdisable",
                Treatment.SOLVER: "timestep apirate impratio tolerance ls_tolerance noslip_tolerance ccd_tolerance "
                "mpr_tolerance sleep_tolerance integrator cone jacobian solver iterations ls_iterations "
                "noslip_iterations ccd_iterations mpr_iterations sdf_iterations sdf_initpoints collision",
            },
            children="flag",
        ),
        "flag": Row(
            "gravity damper frictionloss equality constraint limit",
            {
                Treatment.SPRING: "spring",
                Treatment.COMMAND: "actuation clampctrl",
                Treatment.SENSING: "sensor energy",
                Treatment.CONTACT: "contact filterparent override multiccd nativeccd midphase",
                Treatment.SOLVER: "warmstart refsafe eulerdamp autoreset island ipc fwdinv invdiscrete sleep diagexact "
                "speculative passive",
            },
        ),
        "default": Row(
            "class",
            children=f"default joint geom mesh material equality tendon site {' '.join(MOTORS[:-1])}",
            whole={Treatment.PICTURE: "texture camera light", Treatment.CONTACT: "pair"},
        ),
        "asset": Row(
            children="mesh material model",
            whole={Treatment.PICTURE: "texture skin", Treatment.CONTACT: "hfield"},
        ),
        "asset/mesh": _MESH,
        "mesh/plugin": Row("plugin instance", whole={Treatment.DATA: "config"}),
        "asset/material": _MATERIAL,
        "asset/model": Row("name file content_type"),
        "worldbody": Row(children="body frame replicate attach geom site", whole=_BESIDE),
        "body": Row(
            f"name childclass pos {_TURN}",
            {
                Treatment.LEFT_OUT: "gravcomp mocap",
                Treatment.SOLVER: "sleep simple",
                Treatment.CONVERTING: "fuse",
                Treatment.DATA: "user",
            },
            children=_INSIDE,
            whole=_BESIDE,
        ),
        "frame": Row(f"name childclass pos {_TURN}", children=_INSIDE, whole=_BESIDE),
        "replicate": Row(
            "count offset euler sep childclass", {Treatment.DATA: "prefix"}, children=_INSIDE, whole=_BESIDE
        ),
        "attach": Row("model body frame prefix"),
        "inertial": Row(f"pos {_TURN} mass diaginertia fullinertia"),
        "body/joint": _JOINT,
        "freejoint": Row("name", {Treatment.CONVERTING: "align", Treatment.DATA: "group"}),
        "body/geom": _GEOM,
        "body/site": _SITE,
        "deformable": Row(whole={Treatment.PICTURE: "skin", Treatment.LEFT_OUT: "flex"}),
        "tendon": Row(children="fixed spatial"),
        "tendon/fixed": _TENDON,
        "tendon/spatial": _TENDON,
        "fixed/joint": Row("joint coef"),
        "equality": Row(
            children="joint weld connect",
            whole={Treatment.LEFT_OUT: "tendon flex flexvert flexstrain distance"},
        ),
        "equality/joint": Row("name class active joint1 joint2 polycoef", _CONSTRAINT),
        "equality/weld": Row(
            "name class active body1 body2 relpose site1 site2 anchor", {Treatment.SOLVER: "solref solimp torquescale"}
        ),
        "equality/connect": Row("name class active body1 body2 anchor site1 site2", _CONSTRAINT),
        "default/equality": Row("active", _CONSTRAINT),
        "default/tendon": _TENDON,
        "actuator": Row(children=" ".join(MOTORS)),
        "actuator/motor": _ACTUATOR,
        "include": Row("file"),
    }
)
"""What becomes of everything that a file may hold, by the element and, where a tag means several things, its parent."""

NUMBERS = frozenset(
    f"{_TURN} pos size fromto rgba mass density diaginertia fullinertia axis range ref armature damping frictionloss "
    "actuatorfrcrange group contype conaffinity fitscale shellinertia scale refpos refquat gear forcerange ctrlrange "
    "polycoef anchor relpose coef gravity count offset sep boundmass boundinertia settotalmass inertiagrouprange "
    "vertex face".split()
)
"""Attributes of numbers that are read: MuJoCo takes an empty one as not given."""

_STYLED = {
    "joint": "body/joint",
    "geom": "body/geom",
    "mesh": "asset/mesh",
    "material": "asset/material",
    "equality": "default/equality",
    "tendon": "default/tendon",
    "site": "body/site",
}


def row_of(tag: str, parent: str) -> Row | None:
    """The row of an element that is read.

    Args:
        tag: of the element.
        parent: tag of the element around it; `frame` and `replicate` hold what a body holds.
    """
    holder = "body" if parent in ("worldbody", "frame", "replicate") else parent
    if holder == "default" and tag in _STYLED:
        return ROWS[_STYLED[tag]]
    if tag in MOTORS and holder in ("actuator", "default"):
        return ROWS["actuator/motor"]
    return ROWS.get(f"{holder}/{tag}") or ROWS.get(tag)


def is_neutral(tag: str, attribute: str, text: str) -> bool:
    """Whether a value leaves things as they are: zeros, `false`, `none`, a spring that is no spring."""
    words = text.split()
    if attribute in ("limited", "actuatorfrclimited", "range", "actuatorfrcrange"):
        return tag == "default" or attribute.endswith("limited")
    return all(word.lower() in ("false", "none", "auto") or _is_zero(word) for word in words)


def _is_zero(word: str) -> bool:
    try:
        return float(word) == 0.0
    except ValueError:
        return False


MJCF = Vocabulary(
    "MJCF", row_of, UNKNOWN_ATTRIBUTE, UNKNOWN_PART, strict=True, is_neutral=is_neutral,
    is_neutral_part=lambda _part: False,
)  # fmt: skip
