"""Writes a mechanism as URDF; what URDF cannot keep is refused, or said in the file.

What URDF cannot keep of a mechanism, and what it says by stand-ins.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from math import inf, isfinite
from os import PathLike

from mafsil.arrays import Floats, PoseMatrix
from mafsil.model.joint import Joint, JointKind
from mafsil.model.limits import UNBOUNDED, Limits
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
    tip_loss,
    with_space_link,
    with_tip_link,
    xml_comment,
)
from mafsil.model.mechanism import STANDARD_GRAVITY, Mechanism
from mafsil.model.placement import rpy_from_rotation
from mafsil.model.reading import LONGEST_NAME, is_writable, written
from mafsil.model.urdf.joint import ACCELERATION
from mafsil.model.urdf.shape import without_capsules
from mafsil.model.urdf.vocabulary import FIRST, WIDER_LIMITS
from mafsil.model.vocabulary import Version
from mafsil.model.xml_tree import escape

CHOICES = ("gravity", "actuator", "friction", "limits", "passive", "tip")
"""Words of `without`."""
LOSSES = CHOICES
DRAKE = ' xmlns:drake="http://drake.mit.edu"'


@of_any_mechanism
def write(mechanism: Mechanism, path: str | PathLike[str] | None = None, *, without: Collection[str] = ()) -> str:
    """The mechanism as the text of a URDF file; reading it back gives the same mechanics.

    A tip frame or a base pose other than the identity becomes a massless link behind a fixed joint, a capsule three
    shapes, which `mafsil.load` reads as one. A joint without a known range is `continuous`, or has 1e16 for its
    bounds, as it has for an unknown effort or velocity: urdfdom demands a number, and `mafsil.load` reads it as
    none. Limits of jerk need URDF 1.2, which readers before urdfdom 6 refuse; files without any are 1.0, with
    limits of acceleration in Drake's words. What the file cannot hold, or says in another way, stands in a comment
    at its head.

    Args:
        mechanism: an open chain or tree.
        path: of a file to write the text to as well.
        without: what may be left out though what is read back will move otherwise: `gravity` (not the standard one),
            `friction` (different for both senses, an offset; the mean is written), `passive` (joints that are not
            actuated); and what needs no warning: `limits` (of jerk, then in URDF 1.0; of zero), `actuator` (rotor
            inertia, which stands in Drake's elements), `tip` (one that readers do not choose).

    Warns:
        ModelWarning: limits of jerk or of zero, a rotor's inertia or the choice of the tip do not reach all readers.

    Raises:
        InputError: a word in `without` that is not in the list.
        ModelError: the mechanism has loops, helical joints, names that XML cannot hold, or something that changes the
            motion and that `without` does not name.
        FileError: the file cannot be written.
    """
    return deliver(document(mechanism, without), mechanism.name, path, without)


def document(mechanism: Mechanism, without: Collection[str] = ()) -> Document:
    """The text, and what it does not hold; arguments and errors as of `write`, nothing written and no warning."""
    framed = with_space_link(with_tip_link(mechanism))
    version = version_for(framed, without)
    losses = settle_losses(losses_of(framed, version), CHOICES, without)
    blocks = [*xml_comment(losses)]
    blocks += [_link(link) for link in framed.links]
    blocks += [_joint(joint, version) for joint in framed.joints]
    body = "\n".join([*blocks, "</robot>\n"])
    drake = DRAKE if "drake:" in body else ""
    newer = f' version="{version[0]}.{version[1]}"' if version > FIRST else ""
    head = f'<?xml version="1.0" encoding="UTF-8"?>\n<robot{drake} name="{escape(framed.name)}"{newer}>'
    return Document(f"{head}\n{body}", losses)


def _link(link: Link) -> str:
    parts = [] if link.inertial is None else [_inertial(link.inertial)]
    parts += [_shape("visual", shape) for shape in without_capsules(link.visuals)]
    parts += [_shape("collision", shape) for shape in without_capsules(link.collisions)]
    name = escape(link.name)
    return f'  <link name="{name}">\n{"".join(parts)}  </link>' if parts else f'  <link name="{name}"/>'


def _inertial(inertial: Inertial) -> str:
    (ixx, ixy, ixz), (_, iyy, iyz), (_, _, izz) = inertial.inertia
    keys = {"ixx": ixx, "ixy": ixy, "ixz": ixz, "iyy": iyy, "iyz": iyz, "izz": izz}
    moments = " ".join(f'{key}="{written(value)}"' for key, value in keys.items())
    return (
        f'    <inertial>\n      <origin xyz="{_numbers(inertial.com)}"/>\n'
        f'      <mass value="{written(inertial.mass)}"/>\n      <inertia {moments}/>\n    </inertial>\n'
    )


def _shape(tag: str, shape: Shape) -> str:
    name = f' name="{escape(shape.name)}"' if shape.name else ""
    colour = "" if shape.colour is None else _material(shape.colour)
    geometry = f"      <geometry>{_geometry(shape.geometry)}</geometry>\n"
    return f"    <{tag}{name}>\n      {_origin(shape.T_lg)}\n{geometry}{colour}    </{tag}>\n"


def _geometry(geometry: Geometry) -> str:
    match geometry:
        case Box(size):
            return f'<box size="{_numbers(size)}"/>'
        case Cylinder(radius, length):
            return f'<cylinder radius="{written(radius)}" length="{written(length)}"/>'
        case Sphere(radius):
            return f'<sphere radius="{written(radius)}"/>'
        case Capsule():
            raise ValueError(geometry)
        case Mesh(reference, _, scale):
            return f'<mesh filename="{escape(reference)}" scale="{_numbers(scale)}"/>'


def _material(colour: tuple[float, ...]) -> str:
    rgba = _numbers(colour)
    return f'      <material name="{rgba}"><color rgba="{rgba}"/></material>\n'


def _joint(joint: Joint, version: Version) -> str:
    kind = "continuous" if is_endless(joint) else joint.kind.value
    lines = [
        f'  <joint name="{escape(joint.name)}" type="{kind}">',
        f"    {_origin(joint.T_pj)}",
        f'    <parent link="{escape(joint.parent)}"/>\n    <child link="{escape(joint.child)}"/>',
    ]
    if joint.moves:
        lines.append(f'    <axis xyz="{_numbers(joint.axis)}"/>')
        lines += [f"    {_limit(joint, version)}"] if has_limit(joint) else []
        lines += _extras(joint)
    return "\n".join([*lines, "  </joint>", *_transmission(joint)])


def _extras(joint: Joint) -> Iterator[str]:
    """Friction and mimic of a moving joint."""
    if joint.friction is not None:
        viscous, coulomb = written(joint.friction.viscous), written(joint.friction.mean_coulomb)
        yield f'    <dynamics damping="{viscous}" friction="{coulomb}"/>'
    if joint.mimic is not None:
        multiplier, offset = written(joint.mimic.multiplier), written(joint.mimic.offset)
        yield f'    <mimic joint="{escape(joint.mimic.leader)}" multiplier="{multiplier}" offset="{offset}"/>'


def _transmission(joint: Joint) -> Iterator[str]:
    """Gear ratio and rotor inertia, as a simple transmission; the words for inertia are those of Drake."""
    if joint.actuator is None or not joint.moves:
        return
    name, ratio = escape(joint.name), joint.actuator.gear_ratio
    yield f'  <transmission name="{name}">\n    <type>transmission_interface/SimpleTransmission</type>'
    yield f'    <joint name="{name}"/>\n    <actuator name="{name}">'
    yield f"      <mechanicalReduction>{written(ratio)}</mechanicalReduction>"
    if joint.actuator.reflected_inertia:
        gear, rotor = joint.actuator.equivalent_rotor
        yield f'      <drake:gear_ratio value="{written(gear)}"/>'
        yield f'      <drake:rotor_inertia value="{written(rotor)}"/>'
    yield "    </actuator>\n  </transmission>"


def _limit(joint: Joint, version: Version) -> str:
    """The bounds; those that are not known, but that urdfdom demands, by a number that reads back as none."""
    limits, known = joint.limits, dict[str, float]()
    if not is_endless(joint):
        known = {"lower": limits.lower, "upper": limits.upper}
    known |= {"effort": limits.effort, "velocity": limits.velocity}
    if isfinite(limits.acceleration):
        words = ("acceleration", "deceleration") if version >= WIDER_LIMITS else (ACCELERATION,)
        known |= dict.fromkeys(words, limits.acceleration)
    if isfinite(limits.jerk) and version >= WIDER_LIMITS:
        known["jerk"] = limits.jerk
    numbers = (f'{key}="{written(min(max(value, -UNBOUNDED), UNBOUNDED))}"' for key, value in known.items())
    return f"<limit {' '.join(numbers)}/>"


def _origin(T: PoseMatrix) -> str:
    return f'<origin xyz="{_numbers(T[:3, 3])}" rpy="{_numbers(rpy_from_rotation(T[:3, :3]))}"/>'


def _numbers(values: Floats | tuple[float, ...]) -> str:
    return " ".join(written(value) for value in values)


def losses_of(mechanism: Mechanism, version: Version) -> Iterator[Loss]:
    """Everything, the grave first.

    Args:
        mechanism: whose tip frame and base pose are those of links.
        version: of URDF that is written.
    """
    yield from _refuse(mechanism)
    yield from curve_loss(mechanism, "URDF")
    yield from _changing_the_motion(mechanism)
    yield from _of_limits(mechanism, version)
    if geared := joints_that(
        mechanism, lambda joint: joint.actuator is not None and bool(joint.actuator.reflected_inertia)
    ):
        yield Loss("writing.rotor", Weight.WARNED, "actuator", {"names": geared})
    yield from tip_loss(mechanism)
    if mechanism.n and not any(link.inertial is not None and link.inertial.mass for link in mechanism.links):
        yield Loss("writing.no_masses", Weight.NOTED, "", {"robot": mechanism.name})


def version_for(mechanism: Mechanism, without: Collection[str]) -> Version:
    """The version that is written: the first, which every reader takes, unless only a later one has limits of jerk."""
    jerky = any(joint.moves and joint.limits.jerk < inf for joint in mechanism.joints)
    return WIDER_LIMITS if jerky and "limits" not in without else FIRST


def is_endless(joint: Joint) -> bool:
    """Whether URDF calls the joint `continuous`: it turns without end, or no bound of its range is known."""
    unknown = not isfinite(joint.limits.lower) and not isfinite(joint.limits.upper)
    return joint.kind is JointKind.REVOLUTE and (joint.wraps or unknown)


def _refuse(mechanism: Mechanism) -> Iterator[Loss]:
    for name in (mechanism.name, *mechanism.link_names, *(joint.name for joint in mechanism.joints)):
        if not is_writable(name) or not name or len(name) > LONGEST_NAME:
            yield Loss("writing.name", Weight.REFUSED, "", {"format": "URDF", "name": name})
    for link in mechanism.links:
        for shape in (*link.visuals, *link.collisions):
            reference = shape.geometry.reference if isinstance(shape.geometry, Mesh) else ""
            if not is_writable(shape.name) or not is_writable(reference):
                yield Loss("writing.name", Weight.REFUSED, "", {"format": "URDF", "name": shape.name or reference})
    if mechanism.loops:
        yield Loss("writing.loops", Weight.REFUSED, "", {"names": names_of(loop.name for loop in mechanism.loops)})
    if names := joints_that(mechanism, lambda joint: joint.kind is JointKind.HELICAL):
        yield Loss("writing.helical", Weight.REFUSED, "", {"format": "URDF", "names": names})


def _changing_the_motion(mechanism: Mechanism) -> Iterator[Loss]:
    if tuple(mechanism.gravity) != STANDARD_GRAVITY:
        gravity = ", ".join(f"{x:g}" for x in mechanism.gravity)
        yield Loss("writing.gravity", Weight.CHOSEN, "gravity", {"gravity": gravity})
    yield from friction_loss(mechanism, "URDF")
    if names := joints_that(mechanism, lambda joint: not joint.actuated):
        yield Loss("writing.passive", Weight.CHOSEN, "passive", {"format": "URDF", "names": names})


def _of_limits(mechanism: Mechanism, version: Version) -> Iterator[Loss]:
    """Limits that are lost, and stand-ins for those that are not known."""
    first = version < WIDER_LIMITS
    rows: tuple[tuple[str, Weight, Callable[[Joint], bool]], ...] = (
        ("jerk" if first else "newer_urdf", Weight.WARNED, lambda joint: joint.limits.jerk < inf),
        ("zero", Weight.WARNED, lambda joint: _is_zero(joint.limits)),
        (
            "acceleration_by_drake",
            Weight.NOTED,
            lambda joint: joint.limits.acceleration < inf and version < WIDER_LIMITS,
        ),
        ("continuous", Weight.NOTED, lambda joint: is_endless(joint) and not joint.wraps),
        ("stand_in", Weight.NOTED, _needs_stand_in),
    )
    for key, weight, is_so in rows:
        if names := joints_that(mechanism, lambda joint, is_so=is_so: joint.moves and is_so(joint)):
            yield Loss(f"writing.{key}", weight, "limits", {"format": "URDF", "names": names})


def _is_zero(limits: Limits) -> bool:
    """Whether a limit is zero, which readers take for one that is not known."""
    return limits.lower == limits.upper == 0.0 or 0.0 in (limits.velocity, limits.effort)


def has_limit(joint: Joint) -> bool:
    """Whether URDF wants, or can say, a `limit` of the joint."""
    limits = joint.limits
    return not is_endless(joint) or min(limits.velocity, limits.effort, limits.acceleration, limits.jerk) < inf


def _needs_stand_in(joint: Joint) -> bool:
    limits = joint.limits
    wanted = (limits.velocity, limits.effort, *(() if is_endless(joint) else (limits.lower, limits.upper)))
    return has_limit(joint) and not all(isfinite(value) for value in wanted)
