"""Limits of URDF files that our reader takes and urdfdom refuses, and with it ROS, MoveIt and Pinocchio."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from mafsil.model.diagnostics import Diagnostic, Repair
from mafsil.model.faults import NO_BOUND, NO_LIMIT
from mafsil.model.limits import UNBOUNDED
from mafsil.model.lint.catalogue import BOUND_REFUSED, LIMIT_REFUSED
from mafsil.model.numbers import written
from mafsil.model.reading import Reading
from mafsil.model.urdf.vocabulary import WIDER_LIMITS, version_of
from mafsil.model.xml_tree import Element

MOVING = ("revolute", "prismatic", "continuous")
"""Joints whose limits our reader looks at."""


def refuse_limits(reading: Reading, *, repairs: bool) -> None:
    """Make errors of the remarks that a limit is missing, and look at joints whose limits our reader does not need.

    Args:
        reading: of a URDF file, with its reader's diagnostics.
        repairs: whether the file itself can be changed.
    """
    root = reading.document.root
    joints = {joint.get("name"): joint for joint in root.all("joint")}
    reading.diagnostics[:] = [_raised(reading, remark, joints, repairs) for remark in reading.diagnostics]
    wider = version_of(Reading(reading.document), root) >= WIDER_LIMITS
    for joint in joints.values():
        for limit, attribute in _gaps(joint, wider=wider):
            if wider or joint.get("type") not in MOVING:
                none = written(-UNBOUNDED if attribute == "lower" else UNBOUNDED)
                repair = reading.set_attribute(limit, attribute, none) if repairs else None
                reading.report(BOUND_REFUSED, limit, None, repair, joint=joint.get("name"), attribute=attribute)


def _raised(reading: Reading, remark: Diagnostic, joints: dict[str, Element], repairs: bool) -> Diagnostic:
    """The remark as an error with its repair, if it is about a limit that urdfdom demands."""
    if remark.fault not in (NO_LIMIT, NO_BOUND):
        return remark
    joint = joints.get(str(remark.details["joint"])) if repairs else None
    limit = None if joint is None else joint.first("limit")
    if remark.fault is NO_BOUND:
        attribute = str(remark.details["attribute"])
        repair = None if limit is None else reading.set_attribute(limit, attribute, written(UNBOUNDED))
        return replace(remark, fault=BOUND_REFUSED, repair=repair)
    return replace(remark, fault=LIMIT_REFUSED, repair=None if joint is None else _with_limit(reading, joint))


def _with_limit(reading: Reading, joint: Element) -> Repair:
    """A joint without a `limit` may turn without end, or its range is open: a guess either way."""
    if joint.get("type") == "revolute":
        return reading.set_attribute(joint, "type", "continuous", guess=True)
    none = written(UNBOUNDED)
    text = f'<limit lower="-{none}" upper="{none}" effort="{none}" velocity="{none}"/>'
    return replace(reading.append(joint, text), guess=True)


def _gaps(joint: Element, *, wider: bool) -> Iterator[tuple[Element, str]]:
    """What a `limit` has to have: effort and velocity, from URDF 1.2 on the range alone, where there is one."""
    ranged = joint.get("type") in ("revolute", "prismatic")
    demanded = (("lower", "upper") if ranged else ()) if wider else ("effort", "velocity")
    for limit in joint.all("limit")[:1]:
        yield from ((limit, attribute) for attribute in demanded if attribute not in limit.attributes)
