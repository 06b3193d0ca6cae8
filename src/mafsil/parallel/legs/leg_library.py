"""Platforms on legs of screws, drawn in one configuration: 6-UPS, 3-RPS, 3-RUU (Delta), Eclipse, 3-UPU, on rods, 3-RRR.

Each leg is drawn in the pose of the platform, at zero coordinates.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, positive
from mafsil.errors import InputError
from mafsil.geometry import pose, rotation
from mafsil.parallel.legs.leg_mechanism import LegMechanism, legs_from_screws
from mafsil.parallel.legs.rod_robot import LegDrive, PlatformMotion, RodRobot
from mafsil.parallel.platforms.delta import DeltaRobot, Eclipse
from mafsil.parallel.platforms.spherical_platform import SphericalPlatform
from mafsil.parallel.platforms.stewart import StewartPlatform

TURNS = (0.0, 0.3, -0.3, 0.6, -0.6)
"""Of platforms that extending rods hold in a plane, tried where they are drawn [rad]: similar triangles jam at zero."""
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
        screws.append(np.stack([*feet, slider_screw(u), *ball(a + d)]))
    slider = 3 if foot == "S" else 2
    n = len(screws[0])
    return LegMechanism(legs_from_screws(screws, T), tuple(slider + n * k for k in range(6)))


def three_rps(base: float, platform: float, height: float) -> LegMechanism:
    """A platform on three legs RPS with tangent hinges on the base, drawn level; the sliders are driven [m]."""
    rb, rp, h = positive("base", base), positive("platform", platform), positive("height", height)
    screws: list[Floats] = []
    for angle in THIRDS:
        u = np.array([np.cos(angle), np.sin(angle), 0.0])
        t = np.array([-np.sin(angle), np.cos(angle), 0.0])
        A, B = rb * u, rp * u + [0.0, 0.0, h]
        screws.append(np.stack([hinge_screw(t, A), slider_screw(_unit(B - A)), *ball(B)]))
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
        screws.append(np.stack([hinge_screw(w, at) for w, at in ((t, A), (t, E), (n, E), (n, C), (t, C))]))
    return LegMechanism(legs_from_screws(screws, pose.from_translation(p)), (0, 5, 10))


def eclipse_legs(robot: Eclipse, T: ArrayLike) -> LegMechanism:
    """The Eclipse machine drawn in a pose (4, 4): legs of column, block, hinge, ball; columns and blocks are driven."""
    found = robot.inverse_kinematics(T)
    screws: list[Floats] = []
    z = np.array([0.0, 0.0, 1.0])
    for (gamma, _), foot, B in zip(found, robot.feet(T), robot.platform_joints(T), strict=True):
        t = np.array([-np.sin(gamma), np.cos(gamma), 0.0])
        screws.append(np.stack([hinge_screw(z, np.zeros(3)), slider_screw(z), hinge_screw(t, foot), *ball(B)]))
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
        screws.append(np.stack(both))
    return LegMechanism(legs_from_screws(screws, pose.from_translation([0.0, 0.0, h])), (2, 7, 12))


def rod_legs(robot: RodRobot) -> LegMechanism:
    """A robot on rods at zero motor coordinates, or extending rods half-way; the motors are driven.

    Rods are held as the platform needs it: by universal joints and balls, of points by parallelograms (two hinges along
    one axis and two across at either end), in a plane by hinges. The body of a point in a plane is the first rod.

    Raises:
        InputError: no pose for motors at zero; a plate that is articulated or kept parallel.
    """
    kept = robot.motion is PlatformMotion.PLANE_POINT and np.abs(robot.fixed).max() > 0
    if robot.motion is PlatformMotion.SCHOENFLIES or kept:
        raise InputError("parallel.not_rigid")
    T = _drawn(robot)
    C = robot.carriers(np.zeros(robot.m))
    screws = [_rod_screws(robot, k, a, b) for k, (a, b) in enumerate(zip(C, robot.ends(T), strict=True))]
    if robot.motion is PlatformMotion.PLANE_POINT:
        screws[0] = screws[0][:-1]
    slider = 0 if robot.drive is not LegDrive.EXTEND else 1 if robot.is_flat else 2
    first = np.cumsum([0, *(len(each) for each in screws[:-1])])
    legs = legs_from_screws([np.stack(each) for each in screws], T)
    return LegMechanism(legs, tuple(int(k) + slider for k in first))


def _drawn(robot: RodRobot) -> Floats:
    """(4, 4) the best conditioned pose for motors at zero; of extending rods above, or in, the middle of the base."""
    if robot.drive is LegDrive.EXTEND:
        T = np.tile(np.eye(4), (len(TURNS), 1, 1))
        T[:, :3, :3] = rotation.exp(np.array(TURNS)[:, None] * np.eye(3)[2] * robot.is_flat)
        middle = np.einsum("kij,j->ki", T[:, :3, :3], robot.rotating.mean(axis=0)) + robot.fixed.mean(axis=0)
        T[:, :3, 3] = robot.base.mean(axis=0) - middle + [0.0, 0.0, 0.0 if robot.is_flat else robot.size]
        q = robot.inverse_kinematics(T).q[..., 0]
    else:
        found = robot.forward_kinematics(np.zeros(robot.m))
        T = found.T[: int(found.count)]
        q = np.zeros((len(T), robot.m))
    if not len(T):
        raise InputError("parallel.not_reached", name="q")
    units = np.concatenate([np.full(robot.motion.angles, 1 / robot.size), np.ones(robot.m - robot.motion.angles)])
    least = np.linalg.svd(robot.motor_matrices(T, q)[0] * units, compute_uv=False)[:, -1]
    return T[int(np.argmax(np.round(least, 6)))]


def _rod_screws(robot: RodRobot, k: int, a: Floats, b: Floats) -> list[Floats]:
    """Screws of leg k, its rod drawn from a to b."""
    u, n = _unit(b - a), np.asarray(robot.axes[k], dtype=np.float64)
    least: Floats = np.eye(3)[int(np.abs(u).argmin())]
    across = _unit(np.cross(u, least))
    if robot.motion is PlatformMotion.POINT:
        across = n if robot.drive is LegDrive.CRANK else _unit(np.cross(n, u))
    other: Floats = _unit(np.cross(across, u))
    if robot.is_flat:
        near, far = [hinge_screw(np.eye(3)[2], a)], [hinge_screw(np.eye(3)[2], b)]
    elif robot.motion is PlatformMotion.POINT:
        near, far = ([hinge_screw(across, p), hinge_screw(other, p)] for p in (a, b))
        far.reverse()
    else:
        near, far = [hinge_screw(across, a), hinge_screw(other, a)], ball(b)
    match robot.drive:
        case LegDrive.CRANK:
            return [hinge_screw(n, robot.base[k]), *near, *far]
        case LegDrive.LINEAR:
            return [slider_screw(n), *near, *far]
        case LegDrive.EXTEND:
            return [*near, slider_screw(u), *far]


def spherical_legs(robot: SphericalPlatform) -> LegMechanism:
    """A spherical platform as three legs RRR through the origin, drawn at motor angles of zero."""
    found = robot.forward_kinematics(np.zeros(3))
    if not found.count:
        raise InputError("parallel.not_reached", name="q")
    R = found.x[: int(found.count)]
    A, _ = robot.motor_matrices(R, np.zeros((len(R), 3)))
    R = R[int(np.argmax(np.round(np.linalg.svd(A, compute_uv=False)[:, -1], 6)))]
    axes = np.stack([robot.motors, robot.elbows(np.zeros(3))[0], robot.platform @ R.T], axis=1)
    screws = [np.stack([hinge_screw(w, np.zeros(3)) for w in leg]) for leg in axes]
    return LegMechanism(legs_from_screws(screws, pose.from_rotation_translation(R, np.zeros(3))), (0, 3, 6))
