"""Jacobians for every reading of a velocity: of a frame, of a point, of angles, quaternions and rotation vectors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Vector3, Vector6, as_batch
from mafsil.errors import InputError
from mafsil.geometry import euler, pose, quaternion, rotation
from mafsil.performance.tolerances import CLEAR
from mafsil.robot import Robot, of_robot


@of_robot
def tool_jacobian(robot: Robot, q: ArrayLike, *, frame: str | None = None, point: ArrayLike | None = None) -> Floats:
    """Angular velocity of a frame and velocity of one of its points, both in the axes of {s}.

    (omega_s, pdot) = J qd, J = (R J_omega, R (J_v + J_omega x r)) with J_b = (J_omega, J_v).

    Args:
        robot: the arm.
        q: (*batch, n) joint coordinates [rad | m].
        frame: name of a link; the tip frame if None.
        point: (*batch, 3) point r in that frame [m]; its origin if None.

    Returns:
        (*batch, 6, n).

    Reference: Lynch & Park, Modern Robotics, sec. 5.1.
    """
    R = robot.forward_kinematics(q, frame=frame)[..., :3, :3]
    J_b = robot.jacobian_body(q, frame=frame)
    omega, v = J_b[..., :3, :], J_b[..., 3:, :]
    if point is not None:
        r = as_batch("point", point, (3,), finite=True)
        v = v + np.cross(omega, r[..., None], axisa=-2, axisb=-2, axisc=-2)
    return np.concatenate([R @ omega, R @ v], axis=-2)


@of_robot
def point_velocity(
    robot: Robot, q: ArrayLike, qd: ArrayLike, *, frame: str | None = None, point: ArrayLike | None = None
) -> Vector3:
    """(*batch, 3) velocity [m/s], in the axes of {s}, of a point carried by a frame.

    Args:
        robot: the arm.
        q, qd: (*batch, n) joint coordinates [rad | m] and rates.
        frame: name of a link; the tip frame if None.
        point: (*batch, 3) in that frame [m]; its origin if None.
    """
    rates = as_batch("qd", qd, (robot.n,))
    return np.einsum("...ij,...j->...i", tool_jacobian(robot, q, frame=frame, point=point)[..., 3:, :], rates)


@of_robot
def joint_twists(robot: Robot, q: ArrayLike, qd: ArrayLike) -> Vector6:
    """(*batch, n, 6) what each joint alone contributes to V_s; their sum is V_s = J_s qd.

    Args:
        robot: the arm.
        q, qd: (*batch, n) joint coordinates [rad | m] and rates.
    """
    return np.swapaxes(robot.jacobian_space(q) * as_batch("qd", qd, (robot.n,))[..., None, :], -1, -2)


@of_robot
def analytic_jacobian(robot: Robot, q: ArrayLike, orientation: str = "ZYX", *, frame: str | None = None) -> Floats:
    """Rates of orientation coordinates and of the position, from joint rates.

    Args:
        robot: the arm.
        q: (*batch, n) joint coordinates [rad | m].
        orientation: one of the 24 Euler sequences such as `ZYX` (body axes) or `xyz` (fixed axes); `quaternion`
            (w, x, y, z); or `exponential`, the rotation vector.
        frame: name of a link; the tip frame if None.

    Returns:
        (*batch, 3 + 3, n), for quaternions (*batch, 4 + 3, n): rates of the coordinates, then pdot in {s}. At a gimbal
        lock the rates do not exist: rows of a batch are NaN there.

    Raises:
        InputError: no such coordinates, or a single configuration at a gimbal lock.
    """
    J = tool_jacobian(robot, q, frame=frame)
    R = robot.forward_kinematics(q, frame=frame)[..., :3, :3]
    match orientation:
        case "quaternion":
            rates = _quaternion_rates(quaternion.to_quaternion(R))
        case "exponential":
            rates = rotation.left_jacobian_inverse(rotation.log(R))
        case _:
            rates = _euler_rates(R, orientation)
    return np.concatenate([rates @ J[..., :3, :], J[..., 3:, :]], axis=-2)


def _quaternion_rates(q: Floats) -> Floats:
    """(*batch, 4, 3) G with qdot = G omega_s: (0, omega_s) q / 2."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    rows = [[-x, -y, -z], [w, z, -y], [-z, w, x], [y, -x, w]]
    return 0.5 * np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _euler_rates(R: Floats, sequence: str) -> Floats:
    """(*batch, 3, 3) from omega_s to the rates of three angles."""
    E = euler.rates_to_angular_velocity(euler.to_euler(R, sequence), sequence)
    with np.errstate(invalid="ignore"):
        locked = np.abs(np.linalg.det(E)) < CLEAR
    if E.ndim == 2 and locked:
        raise InputError("performance.gimbal_lock", sequence=sequence)
    inverse = np.linalg.inv(np.where(locked[..., None, None], np.eye(3), E))
    return np.where(locked[..., None, None], np.nan, inverse)


def space_from_body(T_sb: ArrayLike, J_b: ArrayLike) -> Floats:
    """(*batch, 6, k) J_s = Ad(T_sb) J_b: columns seen from {s}; also a single twist as (6, 1).

    Args:
        T_sb: (*batch, 4, 4) pose of {b} in {s}.
        J_b: (*batch, 6, k) columns in {b}.
    """
    return pose.adjoint(T_sb) @ _columns("J_b", J_b)


def body_from_space(T_sb: ArrayLike, J_s: ArrayLike) -> Floats:
    """(*batch, 6, k) J_b = Ad(T_bs) J_s; arguments as `space_from_body`."""
    return pose.adjoint(pose.inverse(T_sb)) @ _columns("J_s", J_s)


def jacobian_by_inspection(
    directions: ArrayLike, points: ArrayLike, kinds: str | Sequence[str] | None = None, pitches: ArrayLike = 0.0
) -> Floats:
    """J_s from where the axes stand now: (w, -w x p + h w) for a revolute joint, (0, w) for a prismatic one.

    Args:
        directions: (*batch, n, 3) of the axes, any length but zero, in {s}.
        points: (*batch, n, 3) a point of each axis [m]; not read for prismatic joints.
        kinds: a letter for each joint, `R` or `P`; all R if None.
        pitches: (n,) advance per angle of helical joints [m/rad].

    Returns:
        (*batch, 6, n).

    Raises:
        InputError: a direction is zero, or the letters do not fit.
    """
    w = as_batch("directions", directions, (np.shape(directions)[-2] if np.ndim(directions) > 1 else 1, 3), finite=True)
    n = w.shape[-2]
    p = as_batch("points", points, (n, 3), finite=True)
    letters = "R" * n if kinds is None else "".join(kinds).upper()
    if len(letters) != n or set(letters) - {"R", "P"}:
        raise InputError("performance.joint_letters", given=letters, n=n)
    length = np.linalg.norm(w, axis=-1, keepdims=True)
    if not length.all():
        joint = int(np.argwhere(length[..., 0] == 0.0)[0][-1])
        raise InputError("performance.zero_direction", joint=joint)
    w = w / length
    prismatic = np.array([letter == "P" for letter in letters])[:, None]
    pitch = np.broadcast_to(as_batch("pitches", pitches, ()), (n,))[:, None]
    revolute = np.concatenate([w, np.cross(p, w) + pitch * w], axis=-1)
    columns = np.where(prismatic, np.concatenate([np.zeros_like(w), w], axis=-1), revolute)
    return np.swapaxes(columns, -1, -2)


def symbolic_jacobian_by_inspection(
    directions: Sequence[Sequence[Any]],
    points: Sequence[Sequence[Any]],
    kinds: str | None = None,
    pitches: Sequence[Any] | None = None,
) -> list[list[Any]]:
    """`jacobian_by_inspection` of symbols: entries that add and multiply, such as those of SymPy.

    Args:
        directions: n unit vectors along the axes; nothing is normalised.
        points: n points of the axes.
        kinds: a letter for each joint, `R` or `P`; all R if None.
        pitches: of helical joints; none if None.

    Returns:
        Six rows of n entries.

    Raises:
        InputError: not one point, letter and pitch for each direction.
    """
    letters = "R" * len(directions) if kinds is None else kinds.upper()
    h = [0] * len(directions) if pitches is None else list(pitches)
    if len({len(directions), len(points), len(letters), len(h)}) > 1 or set(letters) - {"R", "P"}:
        raise InputError("performance.joint_letters", given=letters, n=len(directions))
    columns: list[list[Any]] = []
    for (wx, wy, wz), (px, py, pz), letter, pitch in zip(directions, points, letters, h, strict=True):
        if letter == "P":
            columns.append([0, 0, 0, wx, wy, wz])
            continue
        v = (py * wz - pz * wy, pz * wx - px * wz, px * wy - py * wx)
        columns.append([wx, wy, wz, *(m + pitch * w for m, w in zip(v, (wx, wy, wz), strict=True))])
    return [list(row) for row in zip(*columns, strict=True)]


def _columns(name: str, J: ArrayLike) -> Floats:
    k = np.shape(J)[-1] if np.ndim(J) > 1 else 1
    return as_batch(name, J, (6, k))


@of_robot
def jacobian_hessian(robot: Robot, q: ArrayLike) -> Floats:
    """(*batch, n, 6, n) derivatives of the tool Jacobian (axes of {s}, at the tip) by each coordinate.

    Args:
        robot: the arm.
        q: (*batch, n) joint coordinates [rad | m].
    """
    configuration = as_batch("q", q, (robot.n,))
    R = robot.forward_kinematics(configuration)[..., None, :3, :3]
    J_b = robot.jacobian_body(configuration)[..., None, :, :]
    rate = robot.jacobian_body_rate(configuration[..., None, :], np.eye(robot.n))
    omega = np.swapaxes(J_b[..., 0, :3, :], -1, -2)[..., None]
    turned = [part + np.cross(omega, J_b[..., rows, :], axis=-2) for part, rows in _halves(rate)]
    return np.concatenate([R @ part for part in turned], axis=-2)


def _halves(rate: Floats) -> list[tuple[Floats, slice]]:
    return [(rate[..., :3, :], slice(0, 3)), (rate[..., 3:, :], slice(3, 6))]
