"""Writes a mechanism, with its loops, as MJCF; refuses what MJCF cannot keep."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from math import inf, isfinite

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix
from mafsil.errors import ModelError
from mafsil.model.joint import Joint, JointKind
from mafsil.model.limits import Limits
from mafsil.model.link import Inertial, Link
from mafsil.model.loading import of_mechanism
from mafsil.model.mechanism import Mechanism
from mafsil.model.mjcf.body import WORLD
from mafsil.model.numbers import written
from mafsil.model.reading import is_writable
from mafsil.model.shape import Box, Capsule, Cylinder, Geometry, Mesh, Shape, Sphere
from mafsil.model.tip import choose_tip
from mafsil.model.xml_tree import escaped

LOSSES = ("friction", "limits", "mesh", "passive", "tip")
APART = 0.1
"""Distance of the two points of a hinge that closes a loop [m]."""
_KINDS = {JointKind.REVOLUTE: "hinge", JointKind.PRISMATIC: "slide"}
_CLOSING = (JointKind.SPHERICAL, JointKind.FIXED, JointKind.REVOLUTE)


@of_mechanism
def write(mechanism: Mechanism, *, without: Collection[str] = ()) -> str:
    """The mechanism as the text of an MJCF file; reading it back gives the same mechanics.

    Loops are constraints between sites, so that they do not depend on where the file draws the bodies: a ball joint is
    a `connect`, a fixed one a `weld`, a hinge two points of its axis. A base of another name hangs on the world.

    Args:
        mechanism: with or without loops.
        without: what may be left out though MJCF cannot keep it: `friction` (different for both senses, an offset),
            `limits` (of velocity, acceleration and jerk, a range with one end), `mesh`, `passive` (joints that are
            not actuated where none is), `tip` (a tip frame that a reader would not choose).

    Raises:
        ModelError: helical joints, loops closed by other joints, moving bodies without mass, names that XML cannot
            hold, or something of the list above that `without` does not name.
    """
    for what, name in _losses(mechanism):
        if what not in without:
            key = "mjcf.cannot_keep_by_choice" if what in LOSSES else "mjcf.cannot_keep"
            raise ModelError(key, what=what, name=name)
    gravity = _numbers(mechanism.gravity)
    lines = [
        f'<mujoco model="{escaped(mechanism.name)}">',
        '  <compiler angle="radian" autolimits="true" inertiafromgeom="false"/>',
        f'  <option gravity="{gravity}"/>',
        "  <worldbody>",
        *_bodies(mechanism),
        "  </worldbody>",
    ]
    constraints = [*_couplings(mechanism), *(line for loop in mechanism.loops for line in _constraints(loop))]
    if constraints:
        lines += ["  <equality>", *constraints, "  </equality>"]
    motors = list(_motors(mechanism))
    if motors:
        lines += ["  <actuator>", *motors, "  </actuator>"]
    return "\n".join([*lines, "</mujoco>\n"])


def _losses(mechanism: Mechanism) -> Iterator[tuple[str, str]]:
    """What MJCF cannot keep, with the name of the part that has it."""
    each = (*mechanism.joints, *mechanism.loops)
    for name in (mechanism.name, *mechanism.link_names, *(joint.name for joint in each)):
        if not name or not is_writable(name):
            yield "name", repr(name)
    first = 0 if _stands_in_world(mechanism) else -1
    for k, link in enumerate(mechanism.links):
        if link.name == WORLD and k != first:
            yield "name", repr(WORLD)
        if any(isinstance(shape.geometry, Mesh) for shape in (*link.visuals, *link.collisions)):
            yield "mesh", link.name
    for loop in mechanism.loops:
        if loop.kind not in _CLOSING:
            yield f"{loop.kind.value} joint that closes a loop", loop.name
    weighs = _weighs(mechanism)
    for joint in mechanism.joints:
        if joint.moves and not weighs[joint.child]:
            yield "body without mass", joint.child
        yield from ((what, joint.name) for what in _losses_of_joint(joint))
    if mechanism.n and not any(mechanism.actuated):
        yield "passive", mechanism.name
    chosen = choose_tip(mechanism.links[0].name, mechanism.joints).tip
    if chosen != mechanism.tip or not np.array_equal(mechanism.T_lt, np.eye(4)):
        yield "tip", mechanism.name


def _losses_of_joint(joint: Joint) -> Iterator[str]:
    limits, friction = joint.limits, joint.friction
    if joint.kind is JointKind.HELICAL:
        yield "helical joint"
    if friction is not None and (friction.coulomb_negative not in (None, friction.coulomb) or friction.offset):
        yield "friction"
    one_end = isfinite(limits.lower) != isfinite(limits.upper)
    if joint.moves and (min(limits.velocity, limits.acceleration, limits.jerk) < inf or one_end or not limits.effort):
        yield "limits"


def _weighs(mechanism: Mechanism) -> dict[str, bool]:
    """For each link whether it, or something fixed to it, has mass and inertia."""
    found = {
        link.name: link.inertial is not None and link.inertial.mass > 0.0 and bool(link.inertial.inertia.any())
        for link in mechanism.links
    }
    for joint in reversed(mechanism.joints):
        if not joint.moves:
            found[joint.parent] |= found[joint.child]
    return found


def _stands_in_world(mechanism: Mechanism) -> bool:
    """Whether the base is the world itself."""
    base = mechanism.links[0]
    return base.name == WORLD and base.inertial is None and np.array_equal(mechanism.T_sb, np.eye(4))


def _bodies(mechanism: Mechanism) -> Iterator[str]:
    """The tree, depth first: bodies are closed when the next joint starts further up."""
    sites = _sites(mechanism)
    base, open_ = mechanism.links[0], [mechanism.links[0].name]
    in_world = _stands_in_world(mechanism)
    if not in_world:
        yield f'    <body name="{escaped(base.name)}"{_pose(mechanism.T_sb)}>'
    yield from _content(base, None, sites)
    for joint, link in zip(mechanism.joints, mechanism.links[1:], strict=True):
        while open_[-1] != joint.parent:
            open_.pop()
            yield "    </body>"
        yield f'    <body name="{escaped(link.name)}"{_pose(joint.T_pj)}>'
        yield from _content(link, joint, sites)
        open_.append(joint.child)
    yield from ["    </body>"] * (len(open_) - in_world)


def _content(link: Link, joint: Joint | None, sites: dict[str, list[str]]) -> Iterator[str]:
    """What stands in a body besides other bodies."""
    if link.inertial is not None and (link.inertial.mass or link.inertial.inertia.any()):
        yield _inertial(link.inertial)
    if joint is not None and joint.moves:
        yield _joint(joint)
    both = {id(shape) for shape in link.visuals} & {id(shape) for shape in link.collisions}
    for shape in link.visuals:
        yield from _geom(shape, "" if id(shape) in both else ' contype="0" conaffinity="0"')
    for shape in link.collisions:
        if id(shape) not in both:
            yield from _geom(shape, ' group="3"')
    yield from sites.get(link.name, ())


def _inertial(inertial: Inertial) -> str:
    (ixx, ixy, ixz), (_, iyy, iyz), (_, _, izz) = inertial.inertia
    six = _numbers([ixx, iyy, izz, ixy, ixz, iyz])
    return (
        f'      <inertial pos="{_numbers(inertial.com)}" mass="{written(inertial.mass)}" fullinertia="{six}"/>'
    )  # fmt: skip


def _joint(joint: Joint) -> str:
    text = f'      <joint name="{escaped(joint.name)}" type="{_KINDS[joint.kind]}" axis="{_numbers(joint.axis)}"'
    armature = 0.0 if joint.actuator is None else joint.actuator.reflected_inertia
    friction = joint.friction
    values = {
        "armature": armature,
        "damping": 0.0 if friction is None else friction.viscous,
        "frictionloss": 0.0 if friction is None else friction.coulomb,
    }
    text += "".join(f' {key}="{written(value)}"' for key, value in values.items() if value)
    return text + _limits(joint.limits) + "/>"


def _limits(limits: Limits) -> str:
    text = ""
    if isfinite(limits.lower) and isfinite(limits.upper):
        text += f' range="{_numbers([limits.lower, limits.upper])}"'
    if isfinite(limits.effort) and limits.effort:
        text += f' actuatorfrcrange="{_numbers([-limits.effort, limits.effort])}"'
    return text


def _geom(shape: Shape, purpose: str) -> Iterator[str]:
    colour = "" if shape.colour is None else f' rgba="{_numbers(shape.colour)}"'
    name = f' name="{escaped(shape.name)}"' if shape.name else ""
    if not isinstance(shape.geometry, Mesh):
        kind, size = _size(shape.geometry)
        yield f'      <geom{name} type="{kind}" size="{_numbers(size)}"{_pose(shape.T_lg)}{purpose}{colour}/>'


def _size(geometry: Geometry) -> tuple[str, list[float]]:
    """Type and half sizes."""
    match geometry:
        case Box(size):
            return "box", [edge / 2 for edge in size]
        case Cylinder(radius, length):
            return "cylinder", [radius, length / 2]
        case Capsule(radius, length):
            return "capsule", [radius, length / 2]
        case Sphere(radius):
            return "sphere", [radius]
        case Mesh():
            return "mesh", []


def _sites(mechanism: Mechanism) -> dict[str, list[str]]:
    """The sites of all loops by link."""
    found: dict[str, list[str]] = {}
    for loop in mechanism.loops:
        for name, T_pj, T_cj in _points(loop):
            for link, end, T in ((loop.parent, "parent", T_pj), (loop.child, "child", T_cj)):
                found.setdefault(link, []).append(f'      <site name="{escaped(name)}/{end}"{_pose(T)}/>')
    return found


def _points(loop: Joint) -> Iterator[tuple[str, Floats, Floats]]:
    """Name, pose in the parent and pose in the child of what a loop holds together; of ball and hinge only points."""
    if loop.kind is JointKind.FIXED:
        yield loop.name, np.asarray(loop.T_pj), np.eye(4)
        return
    along = (0.0, APART) if loop.kind is JointKind.REVOLUTE else (0.0,)
    for suffix, distance in zip(("", "/axis"), along, strict=False):
        ends = [np.eye(4), np.eye(4)]
        for end, T in zip(ends, (np.asarray(loop.T_pj), np.eye(4)), strict=True):
            end[:3, 3] = T[:3, 3] + distance * (T[:3, :3] @ loop.axis)
        yield f"{loop.name}{suffix}", ends[0], ends[1]


def _constraints(loop: Joint) -> Iterator[str]:
    tag = "weld" if loop.kind is JointKind.FIXED else "connect"
    for name, _, _ in _points(loop):
        each = escaped(name)
        yield f'    <{tag} name="{each}" site1="{each}/parent" site2="{each}/child"/>'


def _couplings(mechanism: Mechanism) -> Iterator[str]:
    for joint in mechanism.joints:
        if joint.mimic is not None:
            line = _numbers([joint.mimic.offset, joint.mimic.multiplier, 0.0, 0.0, 0.0])
            pair = f'joint1="{escaped(joint.name)}" joint2="{escaped(joint.mimic.leader)}"'
            yield f'    <joint {pair} polycoef="{line}"/>'


def _motors(mechanism: Mechanism) -> Iterator[str]:
    """One for each driven joint, if a joint is passive or geared: without actuators all joints count as driven."""
    ratios = {j.name: 1.0 if j.actuator is None else j.actuator.gear_ratio for j in mechanism.coordinates if j.actuated}
    if all(mechanism.actuated) and all(ratio == 1.0 for ratio in ratios.values()):
        return
    for name, ratio in ratios.items():
        yield f'    <motor name="{escaped(name)}" joint="{escaped(name)}" gear="{written(ratio)}"/>'


def _pose(T: PoseMatrix | Floats) -> str:
    """Place and axes, where they are not the identity; axes of right angles are exact."""
    text = f' pos="{_numbers(T[:3, 3])}"' if np.any(T[:3, 3]) else ""
    if np.array_equal(T[:3, :3], np.eye(3)):
        return text
    return f'{text} xyaxes="{_numbers(T[:3, :2].T.reshape(-1))}"'


def _numbers(values: ArrayLike) -> str:
    return " ".join(written(float(value)) for value in np.asarray(values, dtype=np.float64).reshape(-1))
