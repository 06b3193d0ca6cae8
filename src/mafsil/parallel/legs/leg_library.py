"""Named platforms on legs of screws, drawn in one configuration: 6-UPS, 6-SPS, 3-RPS, 3-RUU (Delta), Eclipse, 3-UPU.

Each leg is drawn in the pose of the platform, at zero coordinates.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, positive
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.parallel.legs.leg_mechanism import LegMechanism, legs_from_screws
from mafsil.parallel.platforms.delta import DeltaRobot, Eclipse
from mafsil.parallel.platforms.stewart import StewartPlatform

THIRDS = 2 * np.pi * np.arange(3) / 3


def hinge_screw(direction: Floats, point: Floats) -> Floats:
    """(6,) screw of a hinge along a unit direction through a point."""
    return np.concatenate([direction, -np.cross(direction, point)])


def slider_screw(direction: Floats) -> Floats:
    """(6,) screw of a slider along a unit direction."""
    return np.concatenate([np.zeros(3), direction])


def ball(point: Floats) -> list[Floats]:
    """Three screws of a spherical joint, along x, y and z."""
    return [hinge_screw(axis, point) for axis in np.eye(3)]


def _unit(v: Floats) -> Floats:
    return v / float(np.linalg.norm(v))


def stewart_legs(robot: StewartPlatform, T: ArrayLike, foot: str = "U") -> LegMechanism:
    """A platform on six legs UPS or SPS, drawn in a pose (4, 4); the sliders are driven.

    Args:
        robot: ends of the legs.
        T: pose T_sb.
        foot: "U" or "S", the joint on the base; S lets each leg spin idly.
    """
    screws: list[Floats] = []
    for a, d in zip(robot.base, robot.leg_vectors(T), strict=True):
        u = _unit(d)
        least: Floats = np.eye(3)[int(np.abs(u).argmin())]
        first = _unit(np.cross(u, least))
        feet = ball(a) if foot == "S" else [hinge_screw(first, a), hinge_screw(np.cross(u, first), a)]
        screws.append(np.stack([*feet, slider_screw(u), *ball(a + d)], axis=1))
    slider = 3 if foot == "S" else 2
    n = screws[0].shape[1]
    return LegMechanism(legs_from_screws(screws, T), tuple(slider + n * k for k in range(6)))


def three_rps(base: float, platform: float, height: float) -> LegMechanism:
    """A platform on three legs RPS with tangent hinges on the base, drawn level; the sliders are driven [m]."""
    rb, rp, h = positive("base", base), positive("platform", platform), positive("height", height)
    screws: list[Floats] = []
    for angle in THIRDS:
        u = np.array([np.cos(angle), np.sin(angle), 0.0])
        t = np.array([-np.sin(angle), np.cos(angle), 0.0])
        A, B = rb * u, rp * u + [0.0, 0.0, h]
        screws.append(np.stack([hinge_screw(t, A), slider_screw(_unit(B - A)), *ball(B)], axis=1))
    return LegMechanism(legs_from_screws(screws, pose.from_translation([0.0, 0.0, h])), (1, 6, 11))


def delta_legs(robot: DeltaRobot, q: float) -> LegMechanism:
    """A Delta robot as three legs RUU, drawn with all arms at the angle q [rad]; the arms are driven.

    Coordinates of the arms count from there.
    """
    found = robot.forward_kinematics(np.full(3, float(q)))
    if not found.count:
        raise InputError("parallel.not_reached", name="q")
    p = found.x[0]
    screws: list[Floats] = []
    for u in robot.directions:
        t = np.array([-u[1], u[0], 0.0])
        A = robot.base * u
        E = A + robot.arm * (np.cos(q) * u - np.sin(q) * np.array([0.0, 0.0, 1.0]))
        C = p + robot.platform * u
        n = np.cross(t, _unit(C - E))
        screws.append(np.stack([hinge_screw(w, at) for w, at in ((t, A), (t, E), (n, E), (n, C), (t, C))], axis=1))
    return LegMechanism(legs_from_screws(screws, pose.from_translation(p)), (0, 5, 10))


def eclipse_legs(robot: Eclipse, T: ArrayLike) -> LegMechanism:
    """The Eclipse machine drawn in a pose (4, 4): legs of column, block, hinge, ball; columns and blocks are driven."""
    found = robot.inverse_kinematics(T)
    screws: list[Floats] = []
    z = np.array([0.0, 0.0, 1.0])
    for (gamma, _), foot, B in zip(found, robot.feet(T), robot.platform_joints(T), strict=True):
        t = np.array([-np.sin(gamma), np.cos(gamma), 0.0])
        screws.append(np.stack([hinge_screw(z, np.zeros(3)), slider_screw(z), hinge_screw(t, foot), *ball(B)], axis=1))
    return LegMechanism(legs_from_screws(screws, T), (0, 1, 6, 7, 12, 13))


def three_upu(base: float, platform: float, height: float, axes: str = "radial") -> LegMechanism:
    """A platform on three legs UPU, drawn level; the sliders are driven [m].

    Args:
        base, platform: radii of the circles of the joints.
        height: of the platform.
        axes: direction of the outer axes, `radial` or `tangent`.
    """
    rb, rp, h = positive("base", base), positive("platform", platform), positive("height", height)
    screws: list[Floats] = []
    for angle in THIRDS:
        u = np.array([np.cos(angle), np.sin(angle), 0.0])
        outer = u if axes == "radial" else np.array([-np.sin(angle), np.cos(angle), 0.0])
        A, B = rb * u, rp * u + [0.0, 0.0, h]
        d = _unit(B - A)
        inner = _unit(np.cross(d, outer))
        both = [
            hinge_screw(outer, A),
            hinge_screw(inner, A),
            slider_screw(d),
            hinge_screw(inner, B),
            hinge_screw(outer, B),
        ]
        screws.append(np.stack(both, axis=1))
    return LegMechanism(legs_from_screws(screws, pose.from_translation([0.0, 0.0, h])), (2, 7, 12))
