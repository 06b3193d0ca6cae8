"""Rules about joints: units of their bounds, mirror images, axes, what they move."""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import degrees, inf, isfinite, pi, radians

import numpy as np

from mafsil.arrays import Floats
from mafsil.model.inertia_check import joints_that_move_matter
from mafsil.model.joint import Joint, JointKind
from mafsil.model.lint.finding import (
    ABSURD_BOUND,
    ANTIPARALLEL,
    DEGREES,
    DEGREES_RATE,
    LONG_LINK,
    MILLIMETRES_TRAVEL,
    MIMIC_RANGE,
    MIRRORED_RANGE,
    MOVES_NOTHING,
    NEARLY_ALONG,
    NO_RANGE,
    SAME_LINE,
    ZERO_BOUND,
    ZERO_OUTSIDE,
    Finding,
    Put,
)
from mafsil.model.mechanism import Mechanism
from mafsil.model.reading import written
from mafsil.model.tolerances import PRINTED, WRITTEN

TURNS = 4 * pi + 0.1
"""No range of a joint is wider to one side, unless it is wound or in degrees [rad]."""
MOST_DEGREES = 720.0
FASTEST, STRONGEST = 1e3, 1e6
"""Rates [rad/s | m/s] and efforts [N m | N] beyond what arms have; 'unknown' is often written so."""
SHORT = 20.0
"""Travel [m] of a prismatic joint from which on millimetres are likely."""
ALMOST = 0.02
"""Angle [rad] to a coordinate axis within which that axis was meant."""
LOPSIDED = 0.1
"""By how much a range must differ from its mirror image to tell them apart [rad | m]."""
_SIDES = {
    "left": "right", "Left": "Right", "LEFT": "RIGHT", "l": "r", "L": "R", "lf": "rf", "lh": "rh",
    "LF": "RF", "LH": "RH", "FL": "FR", "RL": "RR", "BL": "BR", "HL": "HR",
}  # fmt: skip
_SIDE = re.compile(rf"(?<![A-Za-z])({'|'.join(sorted(_SIDES, key=len, reverse=True))})(?![a-z])")


def joints(mechanism: Mechanism, *, from_file: bool) -> Iterator[Finding]:
    """All remarks about joints.

    Args:
        mechanism: the robot.
        from_file: the reader has remarked on missing and zero bounds already.
    """
    for joint in mechanism.joints:
        if joint.moves:
            yield from _bounds(joint, from_file=from_file)
            yield from _axis(joint)
    yield from _distances(mechanism)
    yield from _mimics(mechanism)
    poses = _home(mechanism)
    yield from _mirrors(mechanism, poses)
    yield from _neighbours(mechanism, poses)
    yield from _loads(mechanism)


def _of_degrees(joint: Joint, known: list[float], details: dict[str, object]) -> Iterator[Finding]:
    """Bounds that were meant in degrees, perhaps with the rate."""
    name, velocity = joint.name, joint.limits.velocity
    puts = tuple(Put(("limit",), key, written(radians(x))) for key, x in zip(("lower", "upper"), known, strict=False))
    yield Finding(DEGREES, "joint", name, details, ("limit",), "lower", puts, "lint.to_radians")
    if 30 <= velocity < inf:
        put = Put(("limit",), "velocity", written(radians(velocity)))
        rate: dict[str, object] = {"joint": name, "velocity": f"{velocity:.6g}"}
        yield Finding(DEGREES_RATE, "joint", name, rate, ("limit",), "velocity", (put,), "lint.to_radians_rate")


def _bounds(joint: Joint, *, from_file: bool) -> Iterator[Finding]:
    limits, name = joint.limits, joint.name
    details: dict[str, object] = {"joint": name, "lower": f"{limits.lower:.6g}", "upper": f"{limits.upper:.6g}"}
    known = [x for x in (limits.lower, limits.upper) if isfinite(x)]
    largest = max((abs(x) for x in known), default=0.0)
    in_degrees = joint.kind is JointKind.REVOLUTE and _looks_like_degrees(known)
    if in_degrees:
        details["degrees"] = f"{degrees(limits.lower):.0f}..{degrees(limits.upper):.0f}"
        yield from _of_degrees(joint, known, details)
    elif joint.kind is JointKind.PRISMATIC and SHORT <= largest < 1e5:
        puts = tuple(Put(("limit",), key, factor=1e-3) for key in ("lower", "upper"))
        yield Finding(MILLIMETRES_TRAVEL, "joint", name, details, ("limit",), "lower", puts, "lint.to_metres")
    for what, value, most in (("velocity", limits.velocity, FASTEST), ("effort", limits.effort, STRONGEST)):
        if most < value < inf and not in_degrees:
            absurd: dict[str, object] = {"joint": name, "attribute": what, "value": f"{value:.3g}"}
            yield Finding(ABSURD_BOUND, "joint", name, absurd, ("limit",), what)
        if value == 0.0 and not from_file:
            yield Finding(ZERO_BOUND, "joint", name, {"joint": name, "attribute": what})
    if not known and not joint.wraps and not from_file and joint.mimic is None:
        yield Finding(NO_RANGE, "joint", name, {"joint": name})
    if known and not limits.lower <= 0.0 <= limits.upper:
        yield Finding(ZERO_OUTSIDE, "joint", name, details, ("limit",))


def _distances(mechanism: Mechanism) -> Iterator[Finding]:
    """Joints so far from the one before, or a tip so far from the last, that the distance must be in millimetres."""
    places = [(joint.name, joint.T_pj) for joint in mechanism.joints]
    for name, T in (*places, (mechanism.tip, mechanism.T_lt)):
        distance = float(np.linalg.norm(T[:3, 3]))
        if distance >= SHORT:
            details: dict[str, object] = {"joint": name, "distance": f"{distance:.6g}"}
            yield Finding(LONG_LINK, "joint", name, details, ("origin",), "xyz")


def _looks_like_degrees(bounds: list[float]) -> bool:
    """Wider than two turns, and round numbers of degrees."""
    if not bounds or not TURNS < max(abs(x) for x in bounds) <= MOST_DEGREES:
        return False
    return all(abs(x - round(2 * x) / 2) < WRITTEN for x in bounds)


def _axis(joint: Joint) -> Iterator[Finding]:
    """An axis that misses a coordinate axis by a little: a rounded or mistyped direction."""
    axis = np.asarray(joint.axis)
    k = int(np.abs(axis).argmax())
    deviation = float(np.linalg.norm(np.delete(axis, k)))
    if PRINTED < deviation < ALMOST:
        details: dict[str, object] = {"joint": joint.name, "angle": f"{degrees(deviation):.3g}", "axis": "xyz"[k]}
        yield Finding(NEARLY_ALONG, "joint", joint.name, details, ("axis",), "xyz")


def _mimics(mechanism: Mechanism) -> Iterator[Finding]:
    """The leader's range carries the follower out of its own."""
    by_name = {joint.name: joint for joint in mechanism.joints}
    for joint in mechanism.joints:
        if joint.mimic is None:
            continue
        leader, m = by_name[joint.mimic.leader].limits, joint.mimic
        ends = m.range(leader.lower, leader.upper)
        own = joint.limits
        slack = 1e-3 + 0.01 * max((abs(x) for x in (own.lower, own.upper) if isfinite(x)), default=0.0)
        if all(isfinite(x) for x in ends) and (ends[0] < own.lower - slack or ends[1] > own.upper + slack):
            details: dict[str, object] = {
                "joint": joint.name, "leader": m.leader, "from": f"{ends[0]:.4g}", "to": f"{ends[1]:.4g}",
                "lower": f"{own.lower:.4g}", "upper": f"{own.upper:.4g}",
            }  # fmt: skip
            yield Finding(MIMIC_RANGE, "joint", joint.name, details, ("mimic",))


def _home(mechanism: Mechanism) -> list[Floats]:
    """Poses of the joint frames in {s} at zero, in the order of the joints."""
    poses = [np.asarray(mechanism.T_sb)]
    for joint, parent in zip(mechanism.joints, mechanism.parents, strict=True):
        poses.append(poses[parent] @ joint.T_pj)
    return poses[1:]


def _mirrors(mechanism: Mechanism, poses: list[Floats]) -> Iterator[Finding]:
    """Left and right: where the axes mirror each other the ranges are equal, where they oppose, they are reversed.

    The mirror stands between the two joint frames; a revolute axis is reflected as a rotation (an axial vector).
    """
    places = {joint.name: (joint, T) for joint, T in zip(mechanism.joints, poses, strict=True) if joint.moves}
    for name, (left, T) in places.items():
        other = _SIDE.sub(lambda found: _SIDES[found[1]], name)
        if other == name or other not in places:
            continue
        right, T_right = places[other]
        normal = T[:3, 3] - T_right[:3, 3]
        if left.kind is not right.kind or np.linalg.norm(normal) < 1e-3:
            continue
        normal = normal / np.linalg.norm(normal)
        axis, found = T[:3, :3] @ left.axis, T_right[:3, :3] @ right.axis
        mirrored = axis - 2 * (normal @ axis) * normal
        sense = float(found @ (mirrored if left.kind is JointKind.PRISMATIC else -mirrored))
        if abs(sense) < 0.99:
            continue
        ours, theirs = (left.limits.lower, left.limits.upper), (right.limits.lower, right.limits.upper)
        if not all(isfinite(x) for x in (*ours, *theirs)):
            continue
        straight, reversed_ = _gap(ours, theirs), _gap((-ours[1], -ours[0]), theirs)
        expected, opposite = (straight, reversed_) if sense > 0 else (reversed_, straight)
        if opposite < PRINTED < LOPSIDED < expected:
            details: dict[str, object] = {
                "joint": other, "other": name, "lower": f"{theirs[0]:.4g}", "upper": f"{theirs[1]:.4g}",
                "sense": "same" if sense > 0 else "opposite",
            }  # fmt: skip
            yield Finding(MIRRORED_RANGE, "joint", other, details, ("limit",), "lower")


def _gap(one: tuple[float, float], two: tuple[float, float]) -> float:
    return max(abs(one[0] - two[0]), abs(one[1] - two[1]))


def _neighbours(mechanism: Mechanism, poses: list[Floats]) -> Iterator[Finding]:
    """Joints one after the other: on one line, or parallel in opposite senses."""
    before = _moving_before(mechanism)
    for k, joint in enumerate(mechanism.joints):
        if k not in before or joint.kind is not JointKind.REVOLUTE:
            continue
        first, T, T_k = mechanism.joints[before[k]], poses[before[k]], poses[k]
        if first.kind is not JointKind.REVOLUTE:
            continue
        one, two = T[:3, :3] @ first.axis, T_k[:3, :3] @ joint.axis
        apart = float(np.linalg.norm(np.cross(T_k[:3, 3] - T[:3, 3], one)))
        if np.linalg.norm(np.cross(one, two)) > WRITTEN:
            continue
        details: dict[str, object] = {"joint": joint.name, "other": first.name}
        if apart < WRITTEN:
            yield Finding(SAME_LINE, "joint", joint.name, details, ("origin",))
        elif one @ two < 0:
            yield Finding(ANTIPARALLEL, "joint", joint.name, details, ("axis",))


def _moving_before(mechanism: Mechanism) -> dict[int, int]:
    """For each moving joint the moving joint before it."""
    carried: dict[str, int] = {}
    found: dict[int, int] = {}
    for k, joint in enumerate(mechanism.joints):
        last = carried.get(joint.parent)
        if joint.moves:
            if last is not None:
                found[k] = last
            carried[joint.child] = k
        elif last is not None:
            carried[joint.child] = last
    return found


def _loads(mechanism: Mechanism) -> Iterator[Finding]:
    """A joint behind which nothing has mass, or a last one about whose axis nothing has inertia, among masses."""
    mass = {link.name: 0.0 if link.inertial is None else link.inertial.mass for link in mechanism.links}
    if not any(mass.values()):
        return
    moving, loaded = joints_that_move_matter(mechanism), set[str]()
    for joint in reversed(mechanism.joints):
        last = joint.child not in loaded
        if joint.moves:
            loaded.add(joint.parent)
            if joint.name not in moving and joint.mimic is None and (last or mass[joint.child] == 0.0):
                yield Finding(MOVES_NOTHING, "joint", joint.name, {"joint": joint.name, "link": joint.child})
        elif not last:
            loaded.add(joint.parent)
        mass[joint.parent] += mass[joint.child]
