"""Platforms on legs of screws, drawn in one configuration: 6-UPS, 3-RPS, 3-RUU (Delta), Eclipse, 3-UPU, on rods, 3-RRR.

Each leg is drawn in the pose of the platform, at zero coordinates.

Parallel robots as descriptions with loops: what jobs and other commands load.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, positive
from mafsil.errors import FileError, InputError
from mafsil.geometry import pose, rotation
from mafsil.model import Limits, Mechanism
from mafsil.model.exponentials import frame_on_screw, kind_of_screw
from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Link
from mafsil.parallel.cables.cable_robot import CableRobot
from mafsil.parallel.legs.leg_mechanism import LegMechanism, legs_from_screws
from mafsil.parallel.legs.rod_library import OnRods, as_rod_robot
from mafsil.parallel.legs.rod_robot import LegDrive, PlatformMotion, RodRobot
from mafsil.parallel.platforms.delta import DeltaRobot, Eclipse
from mafsil.parallel.platforms.spherical_platform import SphericalPlatform
from mafsil.parallel.platforms.stewart import StewartPlatform
from mafsil.parallel.robot_file import parse_parallel

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


STROKE = 0.3
"""How far legs and carriages go either way from where they are drawn, as share of the length of legs or rods."""
SWING = 0.5 * np.pi
"""How far cranks turn either way from where they are drawn [rad]."""


def described(data: dict[str, Any], source: str) -> Mechanism:
    """The mechanism of a parallel robot in plain data, without masses and shapes.

    Args:
        data: as `mafsil.parallel.robot_file` reads it.
        source: name for errors.

    Raises:
        FileError: no parallel robot, or one of cables, of an articulated plate, or of no pose with motors at zero.
    """
    robot = parse_parallel(data, source)
    try:
        if isinstance(robot, CableRobot):
            raise InputError("parallel.not_rigid")
        return mechanism_of_parallel(robot, str(data.get("name", data["kind"])))
    except InputError as fault:
        reason = fault.message()
        raise FileError("parallel.not_described", path=source, given=str(data["kind"]), reason=reason) from None


def mechanism_of_parallel(robot: OnRods | SphericalPlatform | LegMechanism, name: str) -> Mechanism:
    """A parallel robot as a description with loops, without masses and shapes; its tip is the platform.

    Args:
        robot: a platform on six legs is drawn level above its base, as high as the base is wide; robots on rods with
            motors at zero, as `rod_legs` says; legs as they are drawn.
        name: of the robot.

    Raises:
        InputError: motors at zero have no pose; a plate that is articulated.
    """
    match robot:
        case StewartPlatform():
            middle, below = robot.base.mean(axis=0), robot.platform.mean(axis=0)
            height = float(np.linalg.norm(robot.base - middle, axis=1).mean())
            T = pose.from_translation(middle - below + [0.0, 0.0, height])
            way = STROKE * float(robot.inverse_kinematics(T).min())
            return mechanism_of_legs(stewart_legs(robot, T), name, Limits(lower=-way, upper=way))
        case DeltaRobot():
            return mechanism_of_legs(delta_legs(robot, 0.0), name, Limits(lower=-SWING, upper=SWING))
        case LegMechanism():
            return mechanism_of_legs(robot, name, Limits())
        case SphericalPlatform():
            return mechanism_of_legs(spherical_legs(robot), name, Limits(lower=-SWING, upper=SWING))
        case _:
            rods = as_rod_robot(robot)
            way = SWING if rods.drive is LegDrive.CRANK else STROKE * (float(rods.rods.min()) or rods.size)
            return mechanism_of_legs(rod_legs(rods), name, Limits(lower=-way, upper=way))


def mechanism_of_legs(drawn: LegMechanism, name: str, driven: Limits) -> Mechanism:
    """A platform on legs as a tree, whose first leg carries the platform, and loops through the last joints of others.

    Args:
        drawn: the legs, at zero coordinates in one pose of the platform.
        name: of the robot.
        driven: limits of the driven joints.
    """
    links, joints, loops, count = [Link("base")], list[Joint](), list[Joint](), 0
    T_platform = np.eye(4)
    for i, leg in enumerate(drawn.legs, start=1):
        parent, T_parent = "base", np.eye(4)
        for k, S in enumerate(leg.screws, start=1):
            kind, direction, pitch = kind_of_screw(S)
            T = frame_on_screw(S, kind, direction, pitch, T_parent[:3, 3])
            last, moved = k == leg.n, count in drawn.driven
            child = "platform" if last and i == 1 else f"leg {i} link {k}"
            joint = Joint(
                f"leg {i} joint {k}", kind, parent, child, pose.inverse(T_parent) @ T, pitch=pitch,
                limits=driven if moved else Limits(), actuated=moved,
            )  # fmt: skip
            links.append(Link(child))
            if last and i == 1:
                T_platform = T
            if last and i > 1:
                held = Joint(f"foot {i}", JointKind.FIXED, "platform", child, pose.inverse(T_platform) @ T)
                joints, loops = [*joints, held], [*loops, joint]
            else:
                joints.append(joint)
            parent, T_parent, count = child, T, count + 1
    T_lt = pose.inverse(T_platform) @ drawn.legs[0].home
    return Mechanism.assemble(name, links, joints, loops=loops, tip="platform", T_lt=T_lt)
