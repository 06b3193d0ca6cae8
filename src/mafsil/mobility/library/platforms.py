"""Platforms on legs in space, by parameters: Stewart-Gough, Delta, 3xUPU, 3-RPS, Eclipse, Tripteron, a hand."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, single
from mafsil.errors import InputError
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.linkages.linkage_joint import LinkageJoint, joint
from mafsil.mobility.spaces.motion_group import cross

THIRDS = tuple(np.radians([90.0, 210.0, 330.0]).tolist())


def point_on_circle(radius: float, angle: float, height: float = 0.0) -> Floats:
    """(3,) a point on a circle about z [m]."""
    return np.array([radius * np.cos(angle), radius * np.sin(angle), height])


def stewart_gough(
    legs: str = "UPS", base: float = 1.0, platform: float = 0.6, center: ArrayLike = (0.05, -0.1, 1.2),
    base_spread: float = 0.35, platform_spread: float = 0.7,
) -> Linkage:  # fmt: skip
    """A platform on six extending legs UPS or SPS.

    Args:
        legs: letters of the joints.
        base, platform: radii of the circles of their ends [m].
        center: (3,) of the platform [m].
        base_spread, platform_spread: angles by which neighbouring ends stand off the thirds of the circles [rad].

    Raises:
        InputError: other letters.
    """
    if not isinstance(cast("object", legs), str) or legs not in ("UPS", "SPS"):
        raise InputError("mobility.legs", legs=legs, known="UPS, SPS")
    middle = single("center", center, (3,))
    joints: list[LinkageJoint] = []
    for k in range(6):
        sign = 1 if k % 2 else -1
        a = point_on_circle(base, 2 * np.pi / 3 * (k // 2) + sign * base_spread)
        b = middle + point_on_circle(platform, 2 * np.pi / 3 * (k // 2) + sign * platform_spread)
        joints += _extending_leg(k, legs[0], a, b)
    return Linkage.of(joints, name=f"Stewart-Gough 6{legs}", output="platform")


def _extending_leg(k: int, foot: str, a: Floats, b: Floats) -> list[LinkageJoint]:
    d = b - a
    first = cross(d, np.array([0.0, 0.0, 1.0]) if abs(d[2]) < 0.9 * np.linalg.norm(d) else np.array([1.0, 0.0, 0.0]))
    second = cross(first, d) if foot == "U" else None
    return [
        joint(f"A{k}", foot, ["ground", f"lower{k}"], a, first, second=second),
        joint(f"P{k}", "P", [f"lower{k}", f"upper{k}"], a, d, actuated=True),
        joint(f"B{k}", "S", [f"upper{k}", "platform"], b),
    ]


def six_ups() -> Linkage:
    """The Stewart-Gough platform with universal joints on the base: mobility 6."""
    return stewart_gough("UPS")


def six_sps() -> Linkage:
    """The same with spherical joints at both ends: each leg spins idly, mobility 12."""
    return stewart_gough("SPS")


def three_upu(
    axes: str = "tangent", base: float = 1.0, platform: float = 0.5, height: float = 2.0, offset: ArrayLike = (0, 0, 0)
) -> Linkage:
    """A platform on three legs UPU; outer axes parallel on base and platform.

    Args:
        axes: of the outer joints: "tangent" to the circle of pivots (translates) or "radial" (gains two rotations at
            home).
        base, platform: radii of the circles of pivots [m].
        height: of the platform [m].
        offset: (3,) of the platform from the axis [m].
    """
    if not isinstance(cast("object", axes), str) or axes not in ("tangent", "radial"):
        raise InputError("mobility.legs", legs=axes, known="tangent, radial")
    joints: list[LinkageJoint] = []
    for k, angle in enumerate(THIRDS):
        radial = point_on_circle(1.0, angle)
        outer = radial if axes == "radial" else point_on_circle(1.0, angle + np.pi / 2)
        a = base * radial
        b = platform * radial + np.array([0.0, 0.0, height]) + as_batch("offset", offset, (3,), finite=True)
        inner = cross(b - a, outer)
        joints += [
            joint(f"A{k}", "U", ["ground", f"lower{k}"], a, outer, second=inner),
            joint(f"P{k}", "P", [f"lower{k}", f"upper{k}"], a, b - a, actuated=True),
            joint(f"B{k}", "U", [f"upper{k}", "platform"], b, inner, second=outer),
        ]
    return Linkage.of(joints, name=f"3xUPU {axes}", output="platform")


def radial_three_upu() -> Linkage:
    """Three legs UPU with radial outer axes at home: count 3, five first-order motions."""
    return three_upu("radial")


def three_rps(base: float = 1.0, platform: float = 0.6, height: float = 1.3) -> Linkage:
    """A platform on three legs RPS with tangent hinges on the base [m]."""
    joints: list[LinkageJoint] = []
    for k, angle in enumerate(THIRDS):
        a, b = point_on_circle(base, angle), point_on_circle(platform, angle, height)
        joints += [
            joint(f"A{k}", "R", ["ground", f"lower{k}"], a, point_on_circle(1.0, angle + np.pi / 2)),
            joint(f"P{k}", "P", [f"lower{k}", f"upper{k}"], a, b - a, actuated=True),
            joint(f"B{k}", "S", [f"upper{k}", "platform"], b),
        ]
    return Linkage.of(joints, name="3-RPS", output="platform")


def three_prs(base: float = 1.0, platform: float = 0.6, height: float = 1.3) -> Linkage:
    """A platform on three legs PRS with vertical guides [m]."""
    joints: list[LinkageJoint] = []
    for k, angle in enumerate(THIRDS):
        a, b = point_on_circle(base, angle, 0.2), point_on_circle(platform, angle, height)
        joints += [
            joint(f"P{k}", "P", ["ground", f"block{k}"], a, [0, 0, 1], actuated=True),
            joint(f"A{k}", "R", [f"block{k}", f"rod{k}"], a, point_on_circle(1.0, angle + np.pi / 2)),
            joint(f"B{k}", "S", [f"rod{k}", "platform"], b),
        ]
    return Linkage.of(joints, name="3-PRS", output="platform")


def delta(
    base: float = 0.5, platform: float = 0.2, arm: float = 0.6, height: float = 1.1, half: float = 0.1
) -> Linkage:
    """The Delta robot: three arms, each with two parallel rods with spherical ends: three translations, six idle spins.

    Args:
        base, platform: radii of the hinges of the arms and of the ends of the rods [m].
        arm: length [m].
        height: of the base above the platform [m].
        half: half of the distance of the two rods of an arm [m].
    """
    joints: list[LinkageJoint] = []
    for k, angle in enumerate(THIRDS):
        t = point_on_circle(1.0, angle + np.pi / 2)
        a = point_on_circle(base, angle)
        elbow = a + point_on_circle(arm * np.cos(0.4), angle, -arm * np.sin(0.4))
        b = point_on_circle(platform, angle, -height)
        joints.append(joint(f"A{k}", "R", ["ground", f"arm{k}"], a, t, actuated=True))
        for side, shift in (("left", half * t), ("right", -half * t)):
            joints += [
                joint(f"E{k} {side}", "S", [f"arm{k}", f"rod{k} {side}"], elbow + shift),
                joint(f"B{k} {side}", "S", [f"rod{k} {side}", "platform"], b + shift),
            ]
    return Linkage.of(joints, name="Delta", output="platform")


def eclipse(radius: float = 1.0, platform: float = 0.5, height: float = 1.2) -> Linkage:
    """The Eclipse machine: three legs PPRS, columns that go round on a circle and up, six freedoms [m]."""
    joints: list[LinkageJoint] = []
    for k, angle in enumerate(THIRDS):
        foot, b = point_on_circle(radius, angle, 0.3), point_on_circle(platform, angle, height)
        joints += [
            joint(f"G{k}", "R", ["ground", f"column{k}"], [0, 0, 0], [0, 0, 1], actuated=True),
            joint(f"P{k}", "P", [f"column{k}", f"block{k}"], foot, [0, 0, 1], actuated=True),
            joint(f"A{k}", "R", [f"block{k}", f"rod{k}"], foot, point_on_circle(1.0, angle + np.pi / 2)),
            joint(f"B{k}", "S", [f"rod{k}", "platform"], b),
        ]
    return Linkage.of(joints, name="Eclipse", output="platform")


def tripteron(reach: float = 1.0) -> Linkage:
    """Three legs PRRR with axes along x, y and z: three translations, each driven alone; the count says 0 [m]."""
    joints: list[LinkageJoint] = []
    for k, axis in enumerate(np.eye(3)):
        u, v = np.eye(3)[(k + 1) % 3], np.eye(3)[(k + 2) % 3]
        places = [-reach * u - 0.4 * v, -0.7 * reach * u + 0.3 * v, -0.2 * reach * u + 0.1 * v]
        names = ["ground", f"block{k}", f"lower{k}", f"upper{k}", "platform"]
        joints.append(joint(f"P{k}", "P", names[:2], places[0], axis, actuated=True))
        joints += [
            joint(f"{n}{k}", "R", names[i + 1 : i + 3], p, axis)
            for i, (n, p) in enumerate(zip("ABC", places, strict=True))
        ]
    return Linkage.of(joints, name="Tripteron", output="platform")


def hand(fingers: int = 3, joints_each: int = 3, contacts: Sequence[str] | str = "S") -> Linkage:
    """Fingers that hold a body by point contacts with friction: each contact is a spherical joint.

    Args:
        fingers: number of them.
        joints_each: hinges of a finger, the first across to the others.
        contacts: letters of joints: S for a point with friction.
    """
    kinds = [contacts] * fingers if isinstance(contacts, str) else list(contacts)
    joints: list[LinkageJoint] = []
    for k, kind in enumerate(kinds):
        angle = 2 * np.pi * k / fingers + 0.1
        places = [point_on_circle(0.08 - 0.01 * i, angle + 0.05 * i, 0.04 * i) for i in range(joints_each)]
        names = ["ground", *(f"finger{k}.{i + 1}" for i in range(joints_each)), "object"]
        for i, place in enumerate(places):
            axis = point_on_circle(1.0, angle) if i == 0 else point_on_circle(1.0, angle + np.pi / 2)
            joints.append(joint(f"F{k}.{i + 1}", "R", names[i : i + 2], place, axis, actuated=True))
        joints.append(joint(f"C{k}", kind, names[-2:], point_on_circle(0.03, angle, 0.04 * joints_each)))
    return Linkage.of(joints, name=f"hand of {fingers} fingers", output="object")
