"""Writes a mechanism, with its loops, as SDFormat; what SDFormat cannot keep is refused, or said in the file.

What SDFormat cannot keep of a mechanism, and what it says by stand-ins.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from math import inf, pi
from os import PathLike
from pathlib import Path

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.model.inertia_check import STAND_IN, possible_inertias, principal_moments
from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Box, Capsule, Cylinder, Geometry, Inertial, Link, Mesh, Shape, Sphere
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
    xml_comment,
)
from mafsil.model.mechanism import STANDARD_GRAVITY, Mechanism
from mafsil.model.placement import inverse, rpy_from_rotation
from mafsil.model.reading import LONGEST_NAME, is_writable, written
from mafsil.model.sdf.frames import OWN_NAME, WORLD, WrittenNames, named_shapes, rename_for_sdf, stands_in_world
from mafsil.model.sdf.joint import ACCELERATION, GEAR_RATIO, IS_BASE, IS_TIP, OWN_JOINT, ROTOR_INERTIA
from mafsil.model.sdf.link import OWN_COLOUR
from mafsil.model.tolerances import PRINTED
from mafsil.model.urdf.writer import is_endless
from mafsil.model.xml_tree import escape

CHOICES = ("actuator", "friction", "inertia", "limits", "mass")
"""Words of `without`."""
CLOSING = (
    JointKind.REVOLUTE, JointKind.PRISMATIC, JointKind.HELICAL, JointKind.FIXED, JointKind.SPHERICAL,
    JointKind.UNIVERSAL,
)  # fmt: skip
CLOSED = 1e-9
"""How far the ends of a loop may be apart where SDFormat draws them [m | rad]."""
SPACES = {"mafsil": "https://github.com/mafsil/mafsil", "drake": "http://drake.mit.edu"}
_KINDS = {JointKind.HELICAL: "screw", JointKind.SPHERICAL: "ball"}
_NOTHING = Inertial(STAND_IN, inertia=STAND_IN * np.eye(3))


@of_any_mechanism
def write(mechanism: Mechanism, path: str | PathLike[str] | None = None, *, without: Collection[str] = ()) -> str:
    """The mechanism as the text of an SDFormat file; reading it back gives the same links, tip and mechanics.

    A fixed joint holds the base in the world. Links without mass and shape behind fixed joints, and the tip, are
    frames, those that move get 1e-12 kg and kg m^2, which `mafsil.load` reads as none. Effort and velocity are always
    written, `inf` where they are not known; joints that are not driven have an effort of zero. A world is around the
    model where gravity is another than -9.81 m/s^2, and in a file that ends with .world. What the file cannot hold, or
    says in another way, stands in a comment at its head.

    Args:
        mechanism: with or without loops, which must be closed where all joints are at zero.
        path: of a file to write the text to as well.
        without: what may be left out though what is read back will move otherwise: `friction` (different for both
            senses, an offset; the mean is written), `inertia` (of no body, and none after a shift; the nearest one is
            written); and what needs no warning: `limits` (of jerk, an effort of zero), `actuator` (rotor inertia,
            which stands in Drake's elements), `mass` (none, so that the dynamics mean nothing).

    Warns:
        ModelWarning: some of the latter is left out.

    Raises:
        InputError: a word in `without` that is not in the list.
        ModelError: loops that are open, or closed by cylindrical or planar joints, names that XML cannot hold, or
            something that changes the motion and that `without` does not name.
        FileError: the file cannot be written.
    """
    in_world = path is not None and Path(path).suffix.lower() == ".world"
    return deliver(document(mechanism, without, in_world=in_world), mechanism.name, path, without)


def document(mechanism: Mechanism, without: Collection[str] = (), *, in_world: bool = False) -> Document:
    """The text, and what it does not hold; arguments and errors as of `write`, nothing written and no warning.

    Args:
        mechanism, without: as of `write`.
        in_world: whether a world is around the model in any case.
    """
    called, changed = rename_for_sdf(mechanism)
    possible, shifted, lacking = possible_inertias(called)
    losses = settle_losses(losses_of(possible, changed, shifted, lacking), CHOICES, without)
    lines = [f"  <model {_call(possible.name, changed)}>", *_model(possible, changed), "  </model>"]
    if in_world or tuple(possible.gravity) != STANDARD_GRAVITY:
        gravity = f"    <gravity>{_numbers(possible.gravity)}</gravity>"
        lines = ['  <world name="default">', gravity, *lines, "  </world>"]
    body = "\n".join([*xml_comment(losses), *lines, "</sdf>\n"])
    spaces = "".join(f' xmlns:{name}="{uri}"' for name, uri in SPACES.items() if f"{name}:" in body)
    head = f'<?xml version="1.0" encoding="UTF-8"?>\n<sdf version="{_version(possible)}"{spaces}>'
    return Document(f"{head}\n{body}", losses)


def _version(mechanism: Mechanism) -> str:
    """The oldest that has all words that are used."""
    if any(joint.mimic is not None for joint in mechanism.joints):
        return "1.11"
    screws = any(joint.kind is JointKind.HELICAL for joint in (*mechanism.joints, *mechanism.loops))
    return "1.10" if screws else "1.9"


def _call(name: str, changed: Mapping[str, str]) -> str:
    """The name that is written, and beside it the robot's own where that is another one."""
    own = f' {OWN_NAME}="{escape(changed[name])}"' if name in changed else ""
    return f'name="{escape(name)}"{own}'


def _model(mechanism: Mechanism, changed: Mapping[str, str]) -> Iterator[str]:
    names = WrittenNames({*mechanism.link_names, *(joint.name for joint in (*mechanism.joints, *mechanism.loops))})
    base = mechanism.links[0]
    if not stands_in_world(mechanism):
        yield from _link(base, _call(base.name, changed), _pose(mechanism.T_sb))
        yield f'    <joint name="{escape(names.free(f"{base.name}_on_world"))}" type="fixed" {IS_BASE}="true">'
        yield f"      <parent>{WORLD}</parent>\n      <child>{escape(base.name)}</child>\n    </joint>"
    for joint in mechanism.joints:
        called = _call(joint.child, changed)
        if is_frame(mechanism, joint):
            own = escape(changed.get(joint.name, joint.name))
            yield _frame(called, joint.parent, joint.T_pj, f'{OWN_JOINT}="{own}"')
            continue
        yield from _link(mechanism.link(joint.child), called, _pose(joint.T_pj, joint.parent))
        yield from _joint(joint, _call(joint.name, changed))
    for loop in mechanism.loops:
        yield from _joint(loop, _call(loop.name, changed))
    yield _frame(_call(names.free("tip"), {}), mechanism.tip, mechanism.T_lt, f'{IS_TIP}="true"')


def _frame(called: str, parent: str, T: PoseMatrix, own: str) -> str:
    holder = f'    <frame {called} attached_to="{escape(parent)}" {own}'
    pose = _pose(T)
    return f"{holder}>{pose}</frame>" if pose else f"{holder}/>"


def _link(link: Link, called: str, pose: str) -> Iterator[str]:
    yield f"    <link {called}>{pose}"
    inertial = _NOTHING if link.inertial is None else link.inertial
    principal = principal_moments(np.asarray(inertial.inertia))
    three, axes = (np.zeros(3), np.eye(3)) if principal is None else principal
    (ixx, ixy, ixz), (_, iyy, iyz), (_, _, izz) = inertial.inertia if principal is None else np.diag(three)
    keys = {"ixx": ixx, "iyy": iyy, "izz": izz, "ixy": ixy, "ixz": ixz, "iyz": iyz}
    moments = "".join(f"<{key}>{written(value)}</{key}>" for key, value in keys.items())
    yield f"      <inertial>\n        <pose>{_numbers(inertial.com)} {_numbers(rpy_from_rotation(axes))}</pose>"
    yield f"        <mass>{written(max(inertial.mass, STAND_IN))}</mass>"
    yield f"        <inertia>{moments}</inertia>\n      </inertial>"
    for tag, shapes in (("visual", link.visuals), ("collision", link.collisions)):
        for name, shape in named_shapes(shapes, tag):
            yield _shape(tag, name, shape)
    yield "    </link>"


def _shape(tag: str, name: str, shape: Shape) -> str:
    own = "" if name == shape.name else f' {OWN_NAME}="{escape(shape.name)}"'
    material = ""
    if shape.colour is not None:
        rgba = _numbers(shape.colour)
        own += f' {OWN_COLOUR}="{rgba}"' if tag == "collision" else ""
        material = f"<material><ambient>{rgba}</ambient><diffuse>{rgba}</diffuse></material>" if tag == "visual" else ""
    geometry = f"<geometry>{_geometry(shape.geometry)}</geometry>"
    return f'      <{tag} name="{escape(name)}"{own}>{_pose(shape.T_lg)}{geometry}{material}</{tag}>'


def _geometry(geometry: Geometry) -> str:
    match geometry:
        case Box(size):
            return f"<box><size>{_numbers(size)}</size></box>"
        case Sphere(radius):
            return f"<sphere><radius>{written(radius)}</radius></sphere>"
        case Cylinder(radius, length) | Capsule(radius, length):
            tag = "cylinder" if isinstance(geometry, Cylinder) else "capsule"
            return f"<{tag}><radius>{written(radius)}</radius><length>{written(length)}</length></{tag}>"
        case Mesh(reference, _, scale):
            return f"<mesh><uri>{escape(reference)}</uri><scale>{_numbers(scale)}</scale></mesh>"


def _joint(joint: Joint, called: str) -> Iterator[str]:
    kind = "continuous" if is_endless(joint) else _KINDS.get(joint.kind, joint.kind.value)
    yield f'    <joint {called} type="{kind}">'
    yield f"      <parent>{escape(joint.parent)}</parent>\n      <child>{escape(joint.child)}</child>"
    if joint.kind is JointKind.HELICAL:
        yield f"      <screw_thread_pitch>{written(2 * pi * joint.pitch)}</screw_thread_pitch>"
    if joint.actuator is not None and joint.moves:
        gear, rotor = joint.actuator.equivalent_rotor
        yield f"      <{GEAR_RATIO}>{written(gear)}</{GEAR_RATIO}>"
        yield f"      <{ROTOR_INERTIA}>{written(rotor)}</{ROTOR_INERTIA}>"
    if joint.kind not in (JointKind.FIXED, JointKind.SPHERICAL):
        yield _axis("axis", joint.axis, joint)
    if joint.kind is JointKind.UNIVERSAL:
        yield _axis("axis2", joint.second, joint)
    yield "    </joint>"


def _axis(tag: str, axis: Floats, joint: Joint) -> str:
    """Direction, limits, friction and what is followed, of one freedom."""
    limits = joint.limits
    known = {"lower": limits.lower, "upper": limits.upper} if not is_endless(joint) else {}
    known |= {"effort": limits.effort if joint.actuated else 0.0, "velocity": limits.velocity}
    known |= {ACCELERATION: limits.acceleration} if limits.acceleration < np.inf else {}
    inside = f"<limit>{''.join(f'<{key}>{written(value)}</{key}>' for key, value in known.items())}</limit>"
    if joint.friction is not None:
        viscous, coulomb = written(joint.friction.viscous), written(joint.friction.mean_coulomb)
        inside += f"<dynamics><damping>{viscous}</damping><friction>{coulomb}</friction></dynamics>"
    if joint.mimic is not None:
        numbers = {"multiplier": joint.mimic.multiplier, "offset": joint.mimic.offset, "reference": 0.0}
        words = "".join(f"<{key}>{written(value)}</{key}>" for key, value in numbers.items())
        inside += f'<mimic joint="{escape(joint.mimic.leader)}">{words}</mimic>'
    return f"      <{tag}><xyz>{_numbers(axis)}</xyz>{inside}</{tag}>"


def _pose(T: PoseMatrix, relative_to: str = "") -> str:
    holder = f' relative_to="{escape(relative_to)}"' if relative_to not in ("", WORLD) else ""
    if not holder and np.array_equal(T, np.eye(4)):
        return ""
    return f"<pose{holder}>{_numbers(T[:3, 3])} {_numbers(rpy_from_rotation(T[:3, :3]))}</pose>"


def _numbers(values: Floats | tuple[float, ...]) -> str:
    return " ".join(written(value + 0.0) for value in values)


def losses_of(
    mechanism: Mechanism, changed: Mapping[str, str], shifted: tuple[str, ...], lacking: Mapping[str, float]
) -> Iterator[Loss]:
    """Everything, the grave first.

    Args:
        mechanism: as it is written: with its names and its possible inertias.
        changed: names that are written, and the robot's own, which SDFormat does not take.
        shifted: links whose inertia was made possible by a shift that changes no motion.
        lacking: links whose inertia no body has, with what it lacks.
    """
    yield from _refuse(mechanism)
    yield from curve_loss(mechanism, "SDFormat")
    yield from friction_loss(mechanism, "SDFormat")
    if gross := [name for name, lack in lacking.items() if lack > PRINTED]:
        yield Loss("writing.inertia_sdf", Weight.CHOSEN, "inertia", {"names": names_of(gross)})
    if changed:
        names = names_of(f"{old} -> {new}" for new, old in changed.items())
        yield Loss("writing.renamed", Weight.NOTED, "", {"names": names})
    yield from _of_joints(mechanism)
    yield from _of_bodies(mechanism, shifted, lacking)


def is_frame(mechanism: Mechanism, joint: Joint) -> bool:
    """Whether the child is a frame of SDFormat: without mass and shape, behind a fixed joint on a link."""
    return mechanism.link(joint.child).is_bare and not joint.moves and joint.parent != WORLD


def _refuse(mechanism: Mechanism) -> Iterator[Loss]:
    each = (*mechanism.joints, *mechanism.loops)
    names = [mechanism.name, *mechanism.link_names, *(joint.name for joint in each)]
    wrong = [name for name in names if not name or not is_writable(name) or len(name) > LONGEST_NAME]
    for link in mechanism.links:
        for shape in (*link.visuals, *link.collisions):
            texts = (shape.name, shape.geometry.reference if isinstance(shape.geometry, Mesh) else "")
            wrong += [text for text in texts if not is_writable(text)]
    for name in wrong:
        yield Loss("writing.name", Weight.REFUSED, "", {"format": "SDFormat", "name": name})
    drawn = _drawn(mechanism) if mechanism.loops else {}
    for loop in mechanism.loops:
        details: dict[str, object] = {"names": names_of([loop.name])}
        if loop.kind not in CLOSING:
            yield Loss("writing.closing_sdf", Weight.REFUSED, "", {"kind": loop.kind.value, **details})
        elif (gap := _gap(loop, inverse(drawn[loop.parent]) @ drawn[loop.child])) > CLOSED:
            yield Loss("writing.open_loop", Weight.REFUSED, "", {"gap": gap, **details})


def _drawn(mechanism: Mechanism) -> dict[str, Floats]:
    """Poses (4, 4) of the links in the base where all joints, followers too, are at their own zero."""
    drawn: dict[str, Floats] = {mechanism.links[0].name: np.eye(4)}
    for joint in mechanism.joints:
        drawn[joint.child] = drawn[joint.parent] @ joint.T_pj
    return drawn


def _gap(loop: Joint, T_pc: Floats) -> float:
    """How far a loop is open: what the joint does not let move of the way from its frame to the child [m | rad]."""
    T = inverse(loop.T_pj) @ T_pc
    R, p, axis = T[:3, :3], T[:3, 3], np.asarray(loop.axis)
    across = np.eye(3) - np.outer(axis, axis)
    turned = float(np.abs(R - np.eye(3)).max())
    match loop.kind:
        case JointKind.REVOLUTE:
            return max(float(np.abs(p).max()), float(np.abs(R @ axis - axis).max()))
        case JointKind.PRISMATIC:
            return max(float(np.abs(across @ p).max()), turned)
        case JointKind.SPHERICAL:
            return float(np.abs(p).max())
        case _:
            return max(float(np.abs(p).max()), turned)


def _of_joints(mechanism: Mechanism) -> Iterator[Loss]:
    """Limits and motors that are lost, or said by other words."""
    rows: tuple[tuple[str, Weight, str, Callable[[Joint], bool]], ...] = (
        ("jerk", Weight.WARNED, "limits", lambda joint: joint.limits.jerk < inf),
        ("zero_effort", Weight.WARNED, "limits", lambda joint: joint.actuated and joint.limits.effort == 0.0),
        ("rotor", Weight.WARNED, "actuator", lambda joint: bool(joint.actuator and joint.actuator.reflected_inertia)),
        ("acceleration_by_drake", Weight.NOTED, "limits", lambda joint: joint.limits.acceleration < inf),
        ("continuous", Weight.NOTED, "limits", lambda joint: is_endless(joint) and not joint.wraps),
        ("not_driven", Weight.NOTED, "", lambda joint: not joint.actuated),
    )
    for key, weight, what, is_so in rows:
        if names := joints_that(mechanism, lambda joint, is_so=is_so: joint.moves and is_so(joint)):
            yield Loss(f"writing.{key}", weight, what, {"format": "SDFormat", "names": names})


def _impossible(mechanism: Mechanism) -> Iterator[str]:
    """Links whose inertia no body has."""
    for link in mechanism.links:
        moments = np.zeros(3) if link.inertial is None else np.linalg.eigvalsh(link.inertial.inertia)
        if moments[0] < -PRINTED * moments[2] or moments[2] - moments[1] - moments[0] > PRINTED * moments[2]:
            yield link.name


def _of_bodies(mechanism: Mechanism, shifted: tuple[str, ...], lacking: Mapping[str, float]) -> Iterator[Loss]:
    """Masses that are not there, and the stand-ins for them."""
    if mechanism.n and not any(link.inertial is not None and link.inertial.mass for link in mechanism.links):
        yield Loss("writing.no_masses", Weight.WARNED, "mass", {"robot": mechanism.name})
    apart = {joint.child for joint in mechanism.joints if is_frame(mechanism, joint)} | {WORLD}
    bodies = [link for link in mechanism.links if link.name not in apart]
    if light := [link.name for link in bodies if link.inertial is None or not link.inertial.mass]:
        yield Loss("writing.least_sdf", Weight.NOTED, "", {"names": names_of(light), "least": f"{STAND_IN:g}"})
    if resting := [name for name in _impossible(mechanism) if name not in lacking]:
        yield Loss("writing.resting", Weight.NOTED, "", {"names": names_of(resting)})
    if shifted:
        yield Loss("writing.shifted", Weight.NOTED, "", {"names": names_of(shifted)})
    if fine := [name for name, lack in lacking.items() if lack <= PRINTED]:
        yield Loss("writing.rounded", Weight.NOTED, "", {"names": names_of(fine), "share": PRINTED})
