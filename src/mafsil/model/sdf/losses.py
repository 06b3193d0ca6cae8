"""What SDFormat cannot keep of a mechanism, and what it says by stand-ins."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from math import inf

import numpy as np

from mafsil.arrays import Floats
from mafsil.model.inertia_check import STAND_IN
from mafsil.model.joint import Joint, JointKind
from mafsil.model.losses import Loss, Weight, curve_loss, friction_loss, joints_that, names_of
from mafsil.model.mechanism import Mechanism
from mafsil.model.placement import inverse
from mafsil.model.reading import LONGEST_NAME, is_writable
from mafsil.model.sdf.frames import WORLD
from mafsil.model.shape import Mesh
from mafsil.model.tolerances import PRINTED
from mafsil.model.urdf.losses import is_endless

CHOICES = ("actuator", "friction", "inertia", "limits", "mass")
"""Words of `without`."""
CLOSING = (
    JointKind.REVOLUTE, JointKind.PRISMATIC, JointKind.HELICAL, JointKind.FIXED, JointKind.SPHERICAL,
    JointKind.UNIVERSAL,
)  # fmt: skip
CLOSED = 1e-9
"""How far the ends of a loop may be apart where SDFormat draws them [m | rad]."""


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
    yield from _refused(mechanism)
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


def _refused(mechanism: Mechanism) -> Iterator[Loss]:
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
