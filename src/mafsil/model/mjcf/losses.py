"""What MJCF cannot keep of a mechanism, and what it says by stand-ins."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from math import inf, isfinite

import numpy as np

from mafsil.model.inertia_check import STAND_IN
from mafsil.model.joint import Joint, JointKind
from mafsil.model.losses import Loss, Weight, curve_loss, friction_loss, joints_that, names_of, tip_loss
from mafsil.model.mechanism import Mechanism
from mafsil.model.mjcf.body import WORLD
from mafsil.model.mjcf.inertial import idle_joints, weighs
from mafsil.model.reading import is_writable
from mafsil.model.shape import Mesh
from mafsil.model.tip import is_named_as_tip
from mafsil.model.tolerances import PRINTED

CHOICES = ("friction", "inertia", "limits", "mass", "mesh", "passive", "tip")
"""Words of `without`."""
CLOSING = (JointKind.SPHERICAL, JointKind.FIXED, JointKind.REVOLUTE)


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
