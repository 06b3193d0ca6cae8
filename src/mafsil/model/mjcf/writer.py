"""Writes a mechanism, with its loops, as MJCF; what MJCF cannot keep is refused, or said by stand-ins or comments."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from math import inf, isfinite
from os import PathLike

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.model.inertia_check import STAND_IN, possible_inertias
from mafsil.model.joint import Joint, JointKind
from mafsil.model.limits import UNBOUNDED, Limits
from mafsil.model.link import Box, Capsule, Cylinder, Geometry, Link, Mesh, Shape, Sphere
from mafsil.model.loading import of_any_mechanism
from mafsil.model.losses import (
    Document,
    Loss,
    Weight,
    curve_loss,
    deliver,
    friction_loss,
    joints_that,
    names_of,
    settle_losses,
    tip_loss,
    with_tip_link,
    xml_comment,
)
from mafsil.model.mechanism import Mechanism
from mafsil.model.mjcf.body import WORLD
from mafsil.model.mjcf.inertial import BOUNDS, idle_joints, inertial_element, numbers, orientation, weighs
from mafsil.model.reading import is_writable, written
from mafsil.model.tip import is_named_as_tip
from mafsil.model.tolerances import PRINTED
from mafsil.model.xml_tree import escape

CHOICES = ("friction", "inertia", "limits", "mass", "mesh", "passive", "tip")
"""Words of `without`."""
CLOSING = (JointKind.SPHERICAL, JointKind.FIXED, JointKind.REVOLUTE)
APART = 0.1
"""Distance of the two points of a hinge that closes a loop [m]."""
_KINDS = {JointKind.REVOLUTE: "hinge", JointKind.PRISMATIC: "slide"}


@of_any_mechanism
def write(mechanism: Mechanism, path: str | PathLike[str] | None = None, *, without: Collection[str] = ()) -> str:
    """The mechanism as the text of an MJCF file; reading it back gives the same mechanics.

    Loops are constraints between sites, so that they do not depend on where the file draws the bodies: a ball joint
    is a `connect`, a fixed one a `weld`, a hinge two points of its axis. A base of another name hangs on the world.
    Links that are frames alone are sites, a tip that readers would not choose then a body. Bodies that move get as
    much mass and inertia as MuJoCo demands by `boundmass` and `boundinertia`, which `mafsil.load` reads as none. An
    inertia that no body has is shifted along joint axes, which changes no motion. What the file cannot hold, or
    says in another way, stands in a comment at its head.

    Args:
        mechanism: with or without loops.
        path: of a file to write the text to as well.
        without: what may be left out though what is read back will move otherwise: `friction` (different for both
            senses, an offset; the mean is written), `inertia` (of no body, and none after a shift; the nearest one is
            written), `passive` (joints that are not actuated where none is); and what needs no warning: `limits` (of
            velocity, acceleration and jerk), `mass` (none, so that the dynamics mean nothing), `mesh` (surfaces in
            files), `tip` (one that readers do not choose).

    Warns:
        ModelWarning: some of the latter is left out.

    Raises:
        InputError: a word in `without` that is not in the list.
        ModelError: helical joints, loops closed by other joints, names that XML cannot hold, or something that changes
            the motion and that `without` does not name.
        FileError: the file cannot be written.
    """
    return deliver(document(mechanism, without), mechanism.name, path, without)


def document(mechanism: Mechanism, without: Collection[str] = ()) -> Document:
    """The text, and what it does not hold; arguments and errors as of `write`, nothing written and no warning."""
    framed, shifted, lacking = possible_inertias(with_tip_link(mechanism, sites_of))
    losses = settle_losses(losses_of(framed, shifted, lacking), CHOICES, without)
    bounds = BOUNDS if light_links(framed) else ""
    lines = [
        f'<mujoco model="{escape(framed.name)}">',
        *xml_comment(losses),
        f'  <compiler angle="radian" autolimits="true" inertiafromgeom="false"{bounds}/>',
        f'  <option gravity="{numbers(framed.gravity)}"/>',
        "  <worldbody>",
        *_bodies(framed),
        "  </worldbody>",
    ]
    constraints = [*_couplings(framed), *(line for loop in framed.loops for line in _constraints(loop))]
    if constraints:
        lines += ["  <equality>", *constraints, "  </equality>"]
    motors = list(_motors(framed))
    if motors:
        lines += ["  <actuator>", *motors, "  </actuator>"]
    return Document("\n".join([*lines, "</mujoco>\n"]), losses)


def _bodies(mechanism: Mechanism) -> Iterator[str]:
    """The tree, depth first: bodies are closed when the next joint starts further up."""
    sites, named, frames = _sites(mechanism), set[str](), sites_of(mechanism)
    base, open_ = mechanism.links[0], [mechanism.links[0].name]
    in_world = stands_in_world(mechanism)
    if not in_world:
        yield f'    <body name="{escape(base.name)}"{_pose(mechanism.T_sb)}>'
    yield from _content(base, None, sites, named)
    for joint, link in zip(mechanism.joints, mechanism.links[1:], strict=True):
        if joint.child in frames:
            continue
        while open_[-1] != joint.parent:
            open_.pop()
            yield "    </body>"
        yield f'    <body name="{escape(link.name)}"{_pose(joint.T_pj)}>'
        yield from _content(link, joint, sites, named)
        open_.append(joint.child)
    yield from ["    </body>"] * (len(open_) - in_world)


def _content(link: Link, joint: Joint | None, sites: dict[str, list[str]], named: set[str]) -> Iterator[str]:
    """What stands in a body besides other bodies; names that are `named` already are not given to shapes again."""
    if link.inertial is not None and (link.inertial.mass or link.inertial.inertia.any()):
        yield inertial_element(link.inertial)
    if joint is not None and joint.moves:
        yield _joint(joint)
    both = {id(shape) for shape in link.visuals} & {id(shape) for shape in link.collisions}
    for shape in link.visuals:
        yield from _geom(shape, named, "" if id(shape) in both else ' contype="0" conaffinity="0"')
    for shape in link.collisions:
        if id(shape) not in both:
            yield from _geom(shape, named, ' group="3"')
    yield from sites.get(link.name, ())


def _joint(joint: Joint) -> str:
    text = f'      <joint name="{escape(joint.name)}" type="{_KINDS[joint.kind]}" axis="{numbers(joint.axis)}"'
    armature = 0.0 if joint.actuator is None else joint.actuator.reflected_inertia
    friction = joint.friction
    values = {
        "armature": armature,
        "damping": 0.0 if friction is None else friction.viscous,
        "frictionloss": 0.0 if friction is None else friction.mean_coulomb,
    }
    text += "".join(f' {key}="{written(value)}"' for key, value in values.items() if value)
    return text + _limits(joint.limits) + "/>"


def _limits(limits: Limits) -> str:
    text = ""
    if isfinite(limits.lower) or isfinite(limits.upper):
        text += f' range="{numbers([max(limits.lower, -UNBOUNDED), min(limits.upper, UNBOUNDED)])}"'
    if isfinite(limits.effort) and limits.effort:
        text += f' actuatorfrcrange="{numbers([-limits.effort, limits.effort])}"'
    return text


def _geom(shape: Shape, named: set[str], purpose: str) -> Iterator[str]:
    colour = "" if shape.colour is None else f' rgba="{numbers(shape.colour)}"'
    if not isinstance(shape.geometry, Mesh):
        name = f' name="{escape(shape.name)}"' if shape.name and shape.name not in named else ""
        named.add(shape.name)
        kind, size = _size(shape.geometry)
        yield f'      <geom{name} type="{kind}" size="{numbers(size)}"{_pose(shape.T_lg)}{purpose}{colour}/>'


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
    """The sites by body: ends of loops, and frames, each on the body that carries it, perhaps over other frames."""
    found: dict[str, list[str]] = {}

    def add(link: str, name: str, T: Floats) -> None:
        found.setdefault(link, []).append(f'      <site name="{escape(name)}"{_pose(T)}/>')

    for loop in mechanism.loops:
        for name, T_pj, T_cj in _points(loop):
            add(loop.parent, f"{name}/parent", T_pj)
            add(loop.child, f"{name}/child", T_cj)
    frames, carried = sites_of(mechanism), dict[str, tuple[str, Floats]]()
    for joint in mechanism.joints:
        if joint.child in frames:
            body, T = carried.get(joint.parent, (joint.parent, np.eye(4)))
            carried[joint.child] = (body, T @ joint.T_pj)
            add(body, joint.child, carried[joint.child][1])
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
        each = escape(name)
        yield f'    <{tag} name="{each}" site1="{each}/parent" site2="{each}/child"/>'


def _couplings(mechanism: Mechanism) -> Iterator[str]:
    for joint in mechanism.joints:
        if joint.mimic is not None:
            line = numbers((*joint.mimic.curve(), 0.0, 0.0, 0.0)[:5])
            pair = f'joint1="{escape(joint.name)}" joint2="{escape(joint.mimic.leader)}"'
            yield f'    <joint {pair} polycoef="{line}"/>'


def _motors(mechanism: Mechanism) -> Iterator[str]:
    """One for each driven joint, if a joint is passive or geared: without actuators all joints count as driven."""
    ratios = {j.name: 1.0 if j.actuator is None else j.actuator.gear_ratio for j in mechanism.coordinates if j.actuated}
    if all(mechanism.actuated) and all(ratio == 1.0 for ratio in ratios.values()):
        return
    for name, ratio in ratios.items():
        yield f'    <motor name="{escape(name)}" joint="{escape(name)}" gear="{written(ratio)}"/>'


def _pose(T: PoseMatrix | Floats) -> str:
    """Place and axes, where they are not the identity; axes of right angles are exact."""
    text = f' pos="{numbers(T[:3, 3])}"' if np.any(T[:3, 3]) else ""
    return text + orientation(T[:3, :3])


def losses_of(mechanism: Mechanism, shifted: tuple[str, ...], lacking: Mapping[str, float]) -> Iterator[Loss]:
    """Everything, the grave first.

    Args:
        mechanism: as it is written: its tip frame is that of a link, its inertias are possible where that can be.
        shifted: links whose inertia was made possible by a shift that changes no motion.
        lacking: links whose inertia no body has, with what it lacks.
    """
    yield from _refuse(mechanism)
    yield from curve_loss(mechanism, "MJCF", degree=4)
    yield from friction_loss(mechanism, "MJCF")
    if gross := [name for name, lack in lacking.items() if lack > PRINTED]:
        yield Loss("writing.inertia", Weight.CHOSEN, "inertia", {"names": names_of(gross)})
    if mechanism.n and not any(mechanism.actuated):
        names = names_of(mechanism.joint_names)
        yield Loss("writing.passive", Weight.CHOSEN, "passive", {"format": "MJCF", "names": names})
    yield from _of_limits(mechanism)
    yield from tip_loss(mechanism, sites_of)
    yield from _of_bodies(mechanism)
    if shifted:
        yield Loss("writing.shifted", Weight.NOTED, "", {"names": names_of(shifted)})
    if fine := [name for name, lack in lacking.items() if lack <= PRINTED]:
        yield Loss("writing.rounded", Weight.NOTED, "", {"names": names_of(fine), "share": PRINTED})


def sites_of(mechanism: Mechanism) -> tuple[str, ...]:
    """Links that are written as sites: frames alone, but for a tip that readers would not choose among sites.

    What carries a link that is a body is one, too.
    """
    sites = {name for name in mechanism.frame_names if name != mechanism.tip or is_named_as_tip(name)}
    for joint in reversed(mechanism.joints):
        if joint.child not in sites:
            sites.discard(joint.parent)
    return tuple(name for name in mechanism.frame_names if name in sites)


def stands_in_world(mechanism: Mechanism) -> bool:
    """Whether the base is the world itself."""
    base = mechanism.links[0]
    return base.name == WORLD and base.inertial is None and np.array_equal(mechanism.T_sb, np.eye(4))


def light_links(mechanism: Mechanism) -> list[str]:
    """Links that move and have less mass or inertia than MuJoCo demands."""
    heavy = weighs(mechanism)
    return [joint.child for joint in mechanism.joints if joint.moves and not heavy[joint.child]]


def _refuse(mechanism: Mechanism) -> Iterator[Loss]:
    each = (*mechanism.joints, *mechanism.loops)
    names = [mechanism.name, *mechanism.link_names, *(joint.name for joint in each)]
    wrong = [name for name in names if not name or not is_writable(name)]
    first = 0 if stands_in_world(mechanism) else -1
    wrong += [link.name for k, link in enumerate(mechanism.links) if link.name == WORLD and k != first]
    for name in wrong:
        yield Loss("writing.name", Weight.REFUSED, "", {"format": "MJCF", "name": name})
    for loop in mechanism.loops:
        if loop.kind not in CLOSING:
            yield Loss("writing.closing", Weight.REFUSED, "", {"kind": loop.kind.value, "names": names_of([loop.name])})
    if names_ := joints_that(mechanism, lambda joint: joint.kind is JointKind.HELICAL):
        yield Loss("writing.helical", Weight.REFUSED, "", {"format": "MJCF", "names": names_})


def _of_limits(mechanism: Mechanism) -> Iterator[Loss]:
    rows: tuple[tuple[str, Weight, Callable[[Joint], bool]], ...] = (
        ("velocity", Weight.WARNED, lambda joint: joint.limits.velocity < inf),
        ("acceleration", Weight.WARNED, lambda joint: joint.limits.acceleration < inf),
        ("jerk", Weight.WARNED, lambda joint: joint.limits.jerk < inf),
        ("zero", Weight.WARNED, lambda joint: joint.limits.effort == 0.0),
        ("no_width", Weight.WARNED, lambda joint: joint.limits.lower == joint.limits.upper),
        ("open_end", Weight.NOTED, lambda joint: isfinite(joint.limits.lower) != isfinite(joint.limits.upper)),
    )
    for key, weight, is_so in rows:
        if names := joints_that(mechanism, lambda joint, is_so=is_so: joint.moves and is_so(joint)):
            yield Loss(f"writing.{key}", weight, "limits", {"format": "MJCF", "names": names})


def _of_bodies(mechanism: Mechanism) -> Iterator[Loss]:
    """Surfaces in files, masses that are not there, and the stand-ins for them."""
    surfaces = [
        link.name
        for link in mechanism.links
        if any(isinstance(shape.geometry, Mesh) for shape in (*link.visuals, *link.collisions))
    ]
    if surfaces:
        yield Loss("writing.mesh", Weight.WARNED, "mesh", {"names": names_of(surfaces)})
    idle = idle_joints(mechanism)
    if idle and len(idle) == sum(joint.moves for joint in mechanism.joints):
        yield Loss("writing.no_masses", Weight.WARNED, "mass", {"robot": mechanism.name})
    elif idle:
        yield Loss("writing.moves_nothing", Weight.WARNED, "mass", {"names": names_of(idle)})
    if light := light_links(mechanism):
        yield Loss("writing.least", Weight.NOTED, "", {"names": names_of(light), "least": f"{STAND_IN:g}"})
