"""Writes a mechanism as URDF; refuses what URDF cannot keep."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from math import inf, isfinite

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.errors import ModelError
from mafsil.model.joint import Joint, JointKind
from mafsil.model.limits import Limits
from mafsil.model.link import Inertial, Link
from mafsil.model.loading import of_mechanism
from mafsil.model.mechanism import STANDARD_GRAVITY, Mechanism
from mafsil.model.numbers import written
from mafsil.model.reading import LONGEST_NAME, is_writable
from mafsil.model.rpy import rpy_from_rotation
from mafsil.model.shape import OUTLINE, Box, Capsule, Cylinder, Geometry, Mesh, Shape, Sphere
from mafsil.model.urdf.joint import UNBOUNDED
from mafsil.model.xml_tree import escaped

LOSSES = ("gravity", "actuator", "friction", "limits", "passive")


@of_mechanism
def write(mechanism: Mechanism, *, without: Collection[str] = ()) -> str:
    """The mechanism as the text of a URDF file; reading it back gives the same mechanics.

    A tip frame or a base pose other than the identity becomes a massless link behind a fixed joint.

    Args:
        mechanism: an open chain or tree.
        without: what may be left out though URDF cannot keep it: `gravity` (not the standard one), `actuator` (rotor
            inertia, armature), `friction` (different for both senses, an offset), `limits` (acceleration, jerk,
            an empty range), `passive` (joints that are not actuated).

    Raises:
        ModelError: the mechanism has loops, helical joints, names that XML cannot hold, or something of the list
            above that `without` does not name.
    """
    _require_representable(mechanism, without)
    blocks = [f'<?xml version="1.0" encoding="UTF-8"?>\n<robot name="{escaped(mechanism.name)}">']
    blocks += [_link(link) for link in mechanism.links]
    blocks += [_joint(joint) for joint in mechanism.joints]
    blocks += _outer_frames(mechanism)
    return "\n".join([*blocks, "</robot>\n"])


def _require_representable(mechanism: Mechanism, without: Collection[str]) -> None:
    for what, name in _losses(mechanism):
        if what not in without:
            key = "urdf.cannot_keep_by_choice" if what in LOSSES else "urdf.cannot_keep"
            raise ModelError(key, what=what, name=name)


def _losses(mechanism: Mechanism) -> Iterator[tuple[str, str]]:
    """What URDF cannot keep, with the name of the part that has it."""
    for name in (mechanism.name, *mechanism.link_names, *(joint.name for joint in mechanism.joints)):
        if not is_writable(name) or not name or len(name) > LONGEST_NAME:
            yield "name", repr(name)
    for link in mechanism.links:
        for shape in (*link.visuals, *link.collisions):
            reference = shape.geometry.reference if isinstance(shape.geometry, Mesh) else ""
            if not is_writable(shape.name) or not is_writable(reference):
                yield "name", repr(shape.name or reference)
    for loop in mechanism.loops:
        yield "loop", loop.name
    if tuple(mechanism.gravity) != STANDARD_GRAVITY:
        yield "gravity", mechanism.name
    for joint in mechanism.joints:
        yield from ((what, joint.name) for what in _losses_of_joint(joint))


def _losses_of_joint(joint: Joint) -> Iterator[str]:
    limits, friction, actuator = joint.limits, joint.friction, joint.actuator
    if joint.kind is JointKind.HELICAL:
        yield "helical joint"
    if not joint.actuated:
        yield "passive"
    if actuator is not None and actuator.reflected_inertia != 0.0:
        yield "actuator"
    if friction is not None and (friction.coulomb_negative not in (None, friction.coulomb) or friction.offset):
        yield "friction"
    empty = limits.lower == limits.upper == 0.0
    if min(limits.acceleration, limits.jerk) < inf or empty or 0.0 in (limits.velocity, limits.effort):
        yield "limits"


def _link(link: Link) -> str:
    parts = [] if link.inertial is None else [_inertial(link.inertial)]
    parts += [_shape("visual", shape) for shape in link.visuals]
    parts += [_shape("collision", piece) for shape in link.collisions for piece in _known_to_readers(shape)]
    name = escaped(link.name)
    return f'  <link name="{name}">\n{"".join(parts)}  </link>' if parts else f'  <link name="{name}"/>'


def _known_to_readers(shape: Shape) -> tuple[Shape, ...]:
    """A tube of an outline as a cylinder and two balls: most readers know no capsule; anything else as it is."""
    tube = shape.geometry
    if shape.name != OUTLINE or not isinstance(tube, Capsule):
        return (shape,)
    ends = [_moved(shape.T_lg, side * tube.length / 2.0) for side in (-1.0, 1.0)]
    balls = [replace(shape, geometry=Sphere(tube.radius), T_lg=T) for T in ends]
    return (replace(shape, geometry=Cylinder(tube.radius, tube.length)), *balls)


def _moved(T: PoseMatrix, along: float) -> PoseMatrix:
    """A pose moved along its z axis [m]."""
    found = np.array(T)
    found[:3, 3] += along * found[:3, 2]
    return found


def _inertial(inertial: Inertial) -> str:
    (ixx, ixy, ixz), (_, iyy, iyz), (_, _, izz) = inertial.inertia
    keys = {"ixx": ixx, "ixy": ixy, "ixz": ixz, "iyy": iyy, "iyz": iyz, "izz": izz}
    moments = " ".join(f'{key}="{written(value)}"' for key, value in keys.items())
    return (
        f'    <inertial>\n      <origin xyz="{_numbers(inertial.com)}"/>\n'
        f'      <mass value="{written(inertial.mass)}"/>\n      <inertia {moments}/>\n    </inertial>\n'
    )


def _shape(tag: str, shape: Shape) -> str:
    name = f' name="{escaped(shape.name)}"' if shape.name else ""
    colour = "" if shape.colour is None else _material(shape.colour)
    geometry = f"      <geometry>{_geometry(shape.geometry)}</geometry>\n"
    return f"    <{tag}{name}>\n      {_origin(shape.T_lg)}\n{geometry}{colour}    </{tag}>\n"


def _geometry(geometry: Geometry) -> str:
    match geometry:
        case Box(size):
            return f'<box size="{_numbers(size)}"/>'
        case Cylinder(radius, length):
            return f'<cylinder radius="{written(radius)}" length="{written(length)}"/>'
        case Capsule(radius, length):
            return f'<capsule radius="{written(radius)}" length="{written(length)}"/>'
        case Sphere(radius):
            return f'<sphere radius="{written(radius)}"/>'
        case Mesh(reference, _, scale):
            return f'<mesh filename="{escaped(reference)}" scale="{_numbers(scale)}"/>'


def _material(colour: tuple[float, ...]) -> str:
    rgba = _numbers(colour)
    return f'      <material name="{rgba}"><color rgba="{rgba}"/></material>\n'


def _joint(joint: Joint) -> str:
    kind = "continuous" if joint.wraps else joint.kind.value
    lines = [
        f'  <joint name="{escaped(joint.name)}" type="{kind}">',
        f"    {_origin(joint.T_pj)}",
        f'    <parent link="{escaped(joint.parent)}"/>\n    <child link="{escaped(joint.child)}"/>',
    ]
    if joint.moves:
        lines += [f'    <axis xyz="{_numbers(joint.axis)}"/>', f"    {_limit(joint.limits)}", *_extras(joint)]
    return "\n".join([*lines, "  </joint>", *_transmission(joint)])


def _extras(joint: Joint) -> Iterator[str]:
    """Friction and mimic of a moving joint."""
    if joint.friction is not None:
        viscous, coulomb = written(joint.friction.viscous), written(joint.friction.coulomb)
        yield f'    <dynamics damping="{viscous}" friction="{coulomb}"/>'
    if joint.mimic is not None:
        multiplier, offset = written(joint.mimic.multiplier), written(joint.mimic.offset)
        yield f'    <mimic joint="{escaped(joint.mimic.leader)}" multiplier="{multiplier}" offset="{offset}"/>'


def _transmission(joint: Joint) -> Iterator[str]:
    """The gear ratio, as a simple transmission."""
    if joint.actuator is None or not joint.moves:
        return
    name, ratio = escaped(joint.name), written(joint.actuator.gear_ratio)
    yield f'  <transmission name="{name}">\n    <joint name="{name}"/>'
    yield f'    <actuator name="{name}"><mechanicalReduction>{ratio}</mechanicalReduction></actuator>'
    yield "  </transmission>"


def _limit(limits: Limits) -> str:
    """Bounds that are known; a range open at one end says so by a number that reads back as infinite."""
    known: dict[str, float] = {}
    if isfinite(limits.lower) or isfinite(limits.upper):
        known = {"lower": max(limits.lower, -UNBOUNDED), "upper": min(limits.upper, UNBOUNDED)}
    known |= {key: v for key, v in (("effort", limits.effort), ("velocity", limits.velocity)) if isfinite(v)}
    return "<limit" + "".join(f' {key}="{written(value)}"' for key, value in known.items()) + "/>"


def _outer_frames(mechanism: Mechanism) -> Iterator[str]:
    """Tip frame and base pose as massless links, where they are not the identity."""
    taken = {*mechanism.link_names, *(joint.name for joint in mechanism.joints)}
    if not np.array_equal(mechanism.T_lt, np.eye(4)):
        yield from _frame(_free("tip", taken), mechanism.tip, mechanism.T_lt, new_is_child=True)
    if not np.array_equal(mechanism.T_sb, np.eye(4)):
        yield from _frame(_free("space", taken), mechanism.links[0].name, mechanism.T_sb, new_is_child=False)


def _frame(new: str, link: str, T: PoseMatrix, *, new_is_child: bool) -> Iterator[str]:
    parent, child = (link, new) if new_is_child else (new, link)
    yield f'  <link name="{new}"/>'
    yield _joint(Joint(f"{new}_joint", JointKind.FIXED, parent, child, T))


def _free(name: str, taken: set[str]) -> str:
    """The name, with underscores until nothing else is called so."""
    while name in taken or f"{name}_joint" in taken:
        name += "_"
    return name


def _origin(T: PoseMatrix) -> str:
    return f'<origin xyz="{_numbers(T[:3, 3])}" rpy="{_numbers(rpy_from_rotation(T[:3, :3]))}"/>'


def _numbers(values: Floats | tuple[float, ...]) -> str:
    return " ".join(written(value) for value in values)
