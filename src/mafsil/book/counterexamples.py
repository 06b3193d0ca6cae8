"""The names in which the proofs of `errata.toml` are written: of `math`, `np`, `mf`, and these short functions."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from importlib import import_module
from math import acos, atan2, cos, hypot, pi, sin, sqrt, tan
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.errors import MafsilError
from mafsil.geometry import Pose, Rotation
from mafsil.geometry.matrix_exponential import exponential
from mafsil.grasp import closure
from mafsil.mobility import gruebler_count
from mafsil.robot import as_robot
from mafsil.solvers.linear_program import minimise

STEP = 1e-6
"""Of central differences: the error of order STEP**2 and the rounding EPS/STEP are far below a proof's 0.5 %."""
Q = np.array([0.4, -0.7])
Q6 = np.array([0.3, -0.8, 0.4, 0.5, 0.9, -0.2])
BASES = np.array([[0.0, 0.0], [2.0, 0.0], [1.0, 2.0]])
PINWHEEL = [[[0.5, 1], [0, -1]], [[1, 0.5], [-1, 0]], [[-0.5, -1], [0, 1]], [[-1, -0.5], [1, 0]]]


def rank(A: ArrayLike) -> int:
    """Of a matrix."""
    return int(np.linalg.matrix_rank(np.asarray(A, float)))


def derivative(f: Callable[[float], Any], x: float, step: float = STEP) -> Any:
    """Central difference."""
    return (np.asarray(f(x + step)) - f(x - step)) / (2 * step)


def count(links: int, freedoms: Sequence[int], space: str = "planar") -> int:
    """Mobility by Gruebler's count."""
    return int(gruebler_count(links, list(freedoms), space).mobility)


def distance_rank(*pairs: str) -> int:
    """Rank of the distances between named points of a body with A and B fixed, for the positions of C and D."""
    at = dict(zip("ABCD", np.array([[0, 0, 0], [1, 0, 0], [0.3, 1.1, 0.2], [0.7, 0.4, 1.3]]), strict=True))
    rows = [[(end == a) * (at[a] - at[b]) - (end == b) * (at[a] - at[b]) for end in "CD"] for a, b in pairs]
    return rank(np.reshape(rows, (len(pairs), 6)))


def pins(*points: Sequence[float]) -> Floats:
    """(3, n) loop matrix of pins in the plane: columns (1, y, -x)."""
    return np.array([[1.0, y, -x] for x, y in points]).T


def is_closed(A: ArrayLike) -> bool:
    """Whether the columns give force closure."""
    return bool(closure(np.asarray(A, float)))


def rectangle(*moments: float) -> Floats:
    """Wrenches (f, m) of four contacts on the sides of a rectangle."""
    return np.array([[0, -1, 0, 1], [-1, 0, 1, 0], moments], float)


def l_body(corner: float) -> Floats:
    """(3.20) with the third entry of its first row, for the L-shaped body."""
    return np.array([[-1, 0, corner, 0], [0, -1, 0, 1], [0, 0, -1, 1]], float)


def bounded_program(bounded: bool) -> int:
    """1 if the program `S w <= mu 1, w >= 0` of a closed grasp has a solution, with or without a bound on w."""
    equality = (np.array([[1.0, 1.0, 0.0]]), np.ones(1)) if bounded else (None, None)
    try:
        return int(minimise(np.array([0.0, 0.0, 1.0]), *equality, -np.ones((3, 3)), np.zeros(3), free=1) is not None)
    except MafsilError:
        return 0


def rot(r: ArrayLike) -> Floats:
    """Matrix of the exponential coordinates of a rotation."""
    return np.asarray(Rotation.exp(np.asarray(r, float)))


def Rx(t: float) -> Floats:
    """Rotation about x."""
    return rot([t, 0, 0])


def Ry(t: float) -> Floats:
    """Rotation about y."""
    return rot([0, t, 0])


def Rz(t: float) -> Floats:
    """Rotation about z."""
    return rot([0, 0, t])


def euler_matrix(a: float, b: float, g: float) -> Floats:
    """ZYX Euler angles as a product of rotations."""
    return Rz(a) @ Ry(b) @ Rx(g)


def skew(w: ArrayLike) -> Floats:
    """[w]: the matrix of the vector product."""
    x, y, z = np.asarray(w, float)
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def hat(S: ArrayLike) -> Floats:
    """[S]: the 4 x 4 matrix of six numbers."""
    S = np.asarray(S, float)
    return np.block([[skew(S[:3]), S[3:, None]], [np.zeros((1, 4))]])


def motion(S: ArrayLike) -> Floats:
    """The pose of the exponential coordinates of a rigid motion."""
    return np.asarray(Pose.exp(np.asarray(S, float)))


def adjoint(R: ArrayLike, p: ArrayLike) -> Floats:
    """(6, 6) adjoint map of the pose (R, p)."""
    return np.asarray(Pose.of(R, p).adjoint())


def lie_map(V: ArrayLike) -> Floats:
    """(6, 6) ad_V: the Lie bracket with a twist."""
    V = np.asarray(V, float)
    return np.block([[skew(V[:3]), np.zeros((3, 3))], [skew(V[3:]), skew(V[:3])]])


def rodrigues(w: ArrayLike, t: float) -> Floats:
    """Rodrigues' formula as printed, whatever the length of w."""
    return np.eye(3) + sin(t) * skew(w) + (1 - cos(t)) * skew(w) @ skew(w)


def G(t: float) -> Floats:
    """The matrix G of a screw about z."""
    K = skew([0, 0, 1])
    return np.eye(3) * t + (1 - cos(t)) * K + (t - sin(t)) * K @ K


def G_inverse(sign: float, t: float = 0.9) -> Floats:
    """Its inverse by (4.116), with the sign of the middle term."""
    K = skew([0, 0, 1])
    return np.eye(3) / t + sign * K / 2 + (1 / t - 1 / tan(t / 2) / 2) * K @ K


def p_of(t: float) -> Floats:
    """A point on a circle of radius 2 about (1, 0)."""
    return np.array([1 + 2 * cos(t), 2 * sin(t), 0])


def v_space(t: float) -> Floats:
    """The linear part of dT/dt T^-1 of a frame that goes along that circle."""
    T = derivative(lambda s: np.asarray(Pose.of(Rz(s), p_of(s))), t) @ np.linalg.inv(Pose.of(Rz(t), p_of(t)))
    return T[:3, 3]


def tip(q: ArrayLike) -> Floats:
    """Position of the tip of the planar 2R arm."""
    return as_robot("planar2r").forward_kinematics(np.asarray(q, float))[:2, 3]


def two_link(bend: float = Q[1]) -> Floats:
    """(2, 2) Jacobian of the tip of the planar 2R arm, by differences."""
    q = np.array([Q[0], bend])
    return np.stack([derivative(lambda t, e=e: tip(q + t * e), 0.0) for e in np.eye(2)], axis=1)


def planar_rate() -> Floats:
    """Velocity of the tip at the joint rates 0.5 and -0.3, by differences."""
    return derivative(lambda t: tip(Q + t * np.array([0.5, -0.3])), 0.0)


def symmetric_part() -> tuple[float, float]:
    """The greatest entries of the symmetric parts of dM/dt - 2 C and of M."""
    robot, qd = as_robot("planar2r"), np.array([0.5, -0.3])
    N = derivative(lambda t: robot.mass_matrix(Q + t * qd), 0.0) - 2 * robot.coriolis_matrix(Q, qd)
    M = robot.mass_matrix(Q)
    return float(np.abs(N + N.T).max()), float(np.abs(M + M.T).max())


def coriolis_torques(sign: float) -> Floats:
    """(9.83) for two links with unit masses at their ends, with the sign of its first term; rates 0.5 and -0.3."""
    A, qd, zero = np.zeros((12, 2)), np.array([0.5, -0.3]), np.zeros((6, 6))
    A[2, 0] = A[8, 1] = 1
    p = skew([1, 0, 0])
    G = np.kron(np.eye(2), np.block([[-p @ p, p], [-p, np.eye(3)]]))
    gamma = np.block([[zero, zero], [np.linalg.inv(adjoint(Rz(Q[1]), [1, 0, 0])), zero]])
    L = np.linalg.inv(np.eye(12) - gamma)

    def blocks(V: Floats) -> Floats:
        return np.block([[lie_map(V[:6]), zero], [zero, lie_map(V[6:])]])

    inner = sign * G @ L @ blocks(A @ qd) @ gamma - blocks(L @ A @ qd).T @ G
    return A.T @ L.T @ inner @ L @ A @ qd


def rate_cost(W: Floats) -> float:
    """The cost with Q = diag(1, 2, 3) of the rates of a planar 3R arm for one tip velocity, weighted by W."""
    lines = [tip_of_three(np.array([0.3, 0.8, -0.5]) + h * e) for h in (STEP, -STEP) for e in np.eye(3)]
    J = (np.array(lines[:3]) - lines[3:]).T / (2 * STEP)
    qd = W @ J.T @ np.linalg.solve(J @ W @ J.T, [0.3, 0.5])
    return float(qd @ np.diag([1, 2, 3]) @ qd)


def tip_of_three(q: Floats) -> Floats:
    """Position of the tip of the planar 3R arm."""
    return as_robot("planar3r").forward_kinematics(q)[:2, 3]


def newton_error(form: str, sign: float) -> float:
    """The error of the pose after one step of Newton's method: `body`, `space`, or a space twist with the body's J."""
    robot, Q0 = as_robot("puma560"), Pose(as_robot("puma560").forward_kinematics(Q6))
    X = Pose(robot.forward_kinematics(Q6 + 0.1))
    S = np.asarray((Q0.inverse() @ X if form == "body" else X @ Q0.inverse()).log())
    J = robot.jacobian_space(Q6) if form == "space" else robot.jacobian_body(Q6)
    T = Pose(robot.forward_kinematics(Q6 + np.linalg.solve(J, sign * S)))
    return float(np.linalg.norm(np.asarray((T.inverse() @ X).log())))


def pose_error_after(sign: float) -> float:
    """The pose error after half a step towards the goal along the error, or against it."""
    goal = Pose.exp([0, 0, 0.65, 0, -0.325, 0.065])
    step = Pose.exp(0.5 * sign * np.asarray(goal.log()))
    return float(np.linalg.norm(np.asarray((step.inverse() @ goal).log())))


def carried_rate() -> Floats:
    """Rate of the desired twist, which is constant, seen from a body that moves otherwise."""
    V, V_d = np.array([0, 0, 0.4, 0.1, 0, 0]), np.array([0.2, 0, 0, 0, 0.3, 0])
    return derivative(lambda t: np.asarray((Pose.exp(t * V).inverse() @ Pose.exp(t * V_d)).adjoint()) @ V_d, 0.0)


def free_speed(t: float, integral: float = 10.0) -> float:
    """Speed of a unit mass in free space under force control: F_d = 2, Kfp = 0.5, damping 20."""
    speed, steps = 0.0, 4000
    for k in range(steps):
        speed += t / steps * (1.5 * 2 + integral * 2 * t * k / steps - 20 * speed)
    return speed


def elbow_point(t1: float, t2: float, t3: float) -> Floats:
    """Wrist centre of an arm with the links 0.5 and 0.4: heading, elevation, elbow."""
    r, z = 0.5 * cos(t2) + 0.4 * cos(t2 + t3), 0.5 * sin(t2) + 0.4 * sin(t2 + t3)
    return np.array([r * cos(t1), r * sin(t1), z])


def circle_meets_sphere() -> list[float]:
    """The angles in [0, 2 pi) about z that bring (1, 0, 0) to the distance 1 of (0.6, -0.8, 0)."""
    centre, half = atan2(-0.8, 0.6), acos(0.5)
    return [(centre + side * half) % (2 * pi) for side in (1, -1)]


def chain(order: Sequence[int], sign: float = 1.0) -> Floats:
    """Product of the exponentials of three joints in an order."""
    screws = np.array([[0, 0, 1, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0.5]]) * [[0.3], [-0.8], [0.4]]
    product = np.eye(4)
    for k in order:
        product = product @ motion(sign * screws[k])
    return product


def second_branch(sign: float) -> float:
    """The orientation missed by the second set of ZYX angles, whose arguments get a sign."""
    R = euler_matrix(0.3, 0.7, 0.5)
    b = pi - 0.7
    a, g = atan2(sign * R[1, 0], sign * R[0, 0]), atan2(sign * R[2, 1], sign * R[2, 2])
    return float(np.abs(euler_matrix(a, b, g) - R).max())


def fifth_axis(sign: float) -> Floats:
    """The axis of the fifth joint of figure 6.3 with the sign of a term."""
    (s1, s2, s4), (c1, c2, c4) = np.sin([0.4, 0.7, 1.1]), np.cos([0.4, 0.7, 1.1])
    return np.array([-c1 * c4 + s1 * c2 * s4, -s1 * c4 + sign * c1 * c2 * s4, s2 * s4])


def ellipse(a: float, b: float, g: float) -> float:
    """The form a x^2 + b x y + g y^2 at a point that (1, 2; 3, 4) takes to the unit circle."""
    x, y = np.linalg.solve([[1.0, 2.0], [3.0, 4.0]], [0.6, 0.8])
    return float(a * x * x + b * x * y + g * y * y)


def leg_gap(first: int, second: int) -> float:
    """Distance of the tips of two bases of a platform, with the joints of the legs 2 and 3 that meet in (1, 1)."""
    legs = np.array([1.0, 1.0]) - BASES[1:]
    return float(np.linalg.norm(BASES[first - 1] + legs[0] - BASES[second - 1] - legs[1]))


def leg_push(load: ArrayLike) -> Floats:
    """Forces of two legs from (-1, 0) and (1, 0) to (0, 1) that add up to a force."""
    return np.asarray(
        np.linalg.solve(np.array([[1.0, -1.0], [1.0, 1.0]]) / sqrt(2), np.asarray(load, float)), np.float64
    )


def four_bar_gap(angle: float) -> float:
    """What is left of the closure of the four-bar 4, 4, 3, 2 with its crank at zero, for an angle of (beta, alpha)."""
    (a, b, c, d), theta = (4.0, 4.0, 3.0, 2.0), 0.0
    alpha, beta = 2 * c * d - 2 * a * c * cos(theta), -2 * a * c * sin(theta)
    gamma = b * b - d * d - c * c - a * a + 2 * a * d * cos(theta)
    phi = angle + acos(gamma / hypot(alpha, beta))
    return alpha * cos(phi) + beta * sin(phi) - gamma


NAMES: dict[str, Any] = {**vars(math), "mf": import_module("mafsil"), "matrix_exp": exponential, **globals()}
"""What a proof may name."""
