"""What URDF cannot keep of a mechanism, and what it says by stand-ins."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from math import inf, isfinite

from mafsil.model.joint import Joint, JointKind
from mafsil.model.limits import Limits
from mafsil.model.losses import Loss, Weight, curve_loss, friction_loss, joints_that, names_of
from mafsil.model.mechanism import STANDARD_GRAVITY, Mechanism
from mafsil.model.outer_frames import tip_loss
from mafsil.model.reading import LONGEST_NAME, is_writable
from mafsil.model.shape import Mesh
from mafsil.model.urdf.vocabulary import FIRST, WIDER_LIMITS
from mafsil.model.vocabulary import Version

CHOICES = ("gravity", "actuator", "friction", "limits", "passive", "tip")
"""Words of `without`."""


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
