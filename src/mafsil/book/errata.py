"""Errata of sections that no worked example shows: what the source prints, computed, beside what is right."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import atan, atan2, cos, pi, sin, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.book.entry import Fact
from mafsil.book.example import example
from mafsil.geometry import Pose, Rotation, ScrewAxis, Twist
from mafsil.grasp import closure
from mafsil.mobility import gruebler_count
from mafsil.one_joint import ForceLoop, SecondOrder
from mafsil.robot import as_robot

COUNTEREXAMPLES: dict[str, Callable[[], Iterable[Fact]]] = {}
"""By section: facts whose printed value is wrong."""
_Q = np.array([0.4, -0.7])


def refutes(section: str) -> Callable[[Callable[[], Iterable[Fact]]], Callable[[], Iterable[Fact]]]:
    """Declare the counterexample to what a section prints.

    Args:
        section: as the source has it.
    """

    def declare(compute: Callable[[], Iterable[Fact]]) -> Callable[[], Iterable[Fact]]:
        COUNTEREXAMPLES[section] = compute
        return compute

    return declare


@refutes("2.2.1")
def two_bodies() -> Iterable[Fact]:
    """Two bodies in space on a revolute joint."""
    k = 1
    free = 6 * 2 - (6 - k)
    assert free - 6 == int(gruebler_count(2, [k], "spatial").mobility)
    yield Fact("parameters", free, 6 - (6 - k))


@refutes("3.2.4")
def corner_contact() -> Iterable[Fact]:
    """The matrix of the L-shaped body with the printed first row."""
    A = np.array(example("3.2.4").objects["A"])
    printed = A.copy()
    printed[0, 2] = 0.0
    yield Fact("closure", int(bool(closure(A))), int(bool(closure(printed))))


@refutes("4.2.3")
def locked_angles() -> Iterable[Fact]:
    """Entry r31 of ZYX angles with beta = 90 degrees."""
    yield Fact("r31", float(np.asarray(Rotation.from_euler([0.3, pi / 2, 0.5], "ZYX"))[2, 0]), 1.0)


@refutes("4.3.3.1")
def series() -> Iterable[Fact]:
    """Two terms of the series of G against the exponential, one radian about z."""
    K, v = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]), np.array([1.0, 0.0, 0.0])
    yield Fact("position", np.asarray(Pose.exp([0.0, 0.0, 1.0, *v]))[:3, 3], (np.eye(3) + K) @ v, "m")


@refutes("4.3.3.3")
def shifted_rate() -> Iterable[Fact]:
    """An angular velocity in another frame."""
    T_ba = Pose.of(Rotation.exp([0.0, 0.0, pi / 2]), [1.0, 2.0, 0.0])
    omega = np.array([1.0, 0.0, 0.0])
    twist = np.asarray(Twist(np.concatenate([omega, np.zeros(3)])).seen_from(T_ba))
    T = np.asarray(T_ba)
    yield Fact("omega_b", twist[:3], T[:3, :3] @ omega + T[:3, 3], "rad/s")


@refutes("5.1.2")
def second_row() -> Iterable[Fact]:
    """The determinant of a rotation by 1 rad about z."""
    c, s = cos(1.0), sin(1.0)
    printed = np.linalg.det([[c, -s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    yield Fact("determinant", float(np.linalg.det(np.asarray(Rotation.exp([0.0, 0.0, 1.0])))), float(printed))


@refutes("6.4")
def columns() -> Iterable[Fact]:
    """The first column of the Jacobian of a planar 2R arm, against the position of its elbow."""
    robot, step = as_robot("planar2r"), 1e-6
    ahead, behind = (robot.forward_kinematics(_Q + np.array([h, 0.0]))[:2, 3] for h in (step, -step))
    yield Fact("column", (ahead - behind) / (2 * step), [cos(_Q[0]), sin(_Q[0])], "m")


@refutes("7.1.1")
def shoulder_angle() -> Iterable[Fact]:
    """The first angle for a wrist centre above (3, 4)."""
    yield Fact("theta_1", atan2(4.0, 3.0), atan(3.0 / 4.0), "rad")


@refutes("7.2")
def body_step() -> Iterable[Fact]:
    """The error of the pose after one step of Newton's method in the body form."""
    robot = as_robot("puma560")
    q = np.array([0.3, -0.8, 0.4, 0.5, 0.9, -0.2])
    X = robot.forward_kinematics(q + 0.1)
    S, J = np.asarray((Pose(robot.forward_kinematics(q)).inverse() @ Pose(X)).log()), robot.jacobian_body(q)

    def error(step: Any) -> float:
        T = Pose(robot.forward_kinematics(q + step))
        return float(np.linalg.norm(np.asarray((T.inverse() @ Pose(X)).log())))

    yield Fact("error", error(np.linalg.solve(J, S)), error(np.linalg.solve(J, -S)))


@refutes("7.3")
def weighted_rates() -> Iterable[Fact]:
    """The cost of joint rates of a planar 3R arm for one tip velocity."""
    robot, Q, v = as_robot("planar3r"), np.diag([1.0, 2.0, 3.0]), np.array([0.3, 0.5])
    J, p = robot.jacobian_space([0.3, 0.8, -0.5]), robot.forward_kinematics([0.3, 0.8, -0.5])[:3, 3]
    Jp = (J[3:] + np.cross(J[:3].T, p).T)[:2]

    def cost(W: NDArray[np.floating[Any]]) -> float:
        qd = W @ Jp.T @ np.linalg.solve(Jp @ W @ Jp.T, v)
        return float(qd @ Q @ qd)

    yield Fact("cost", cost(np.linalg.inv(Q)), cost(Q))


@refutes("8.1.3")
def three_legs() -> Iterable[Fact]:
    """Mobility of 3xRPR: nine joints of one freedom on eight links in the plane."""
    d = int(gruebler_count(8, [1] * 9, "planar").mobility)
    yield Fact("d", d, -d)


@refutes("8.3")
def closing_angle() -> Iterable[Fact]:
    """The closure alpha cos(phi) + beta sin(phi) = gamma of the four-bar 4, 4, 3, 2 with its crank at zero."""
    (a, b, c, d), theta = (4.0, 4.0, 3.0, 2.0), 0.0
    alpha, beta = 2 * c * d - 2 * a * c * cos(theta), -2 * a * c * sin(theta)
    gamma = b * b - d * d - c * c - a * a + 2 * a * d * cos(theta)

    def left_over(angle: float) -> float:
        phi = angle + np.arccos(gamma / sqrt(alpha**2 + beta**2))
        return float(alpha * np.cos(phi) + beta * np.sin(phi) - gamma)

    yield Fact("closing_error", left_over(atan2(beta, alpha)), left_over(atan(beta / alpha)), "m²")


@refutes("9.3")
def gravity() -> Iterable[Fact]:
    """Torques that hold a planar 2R arm at rest."""
    tau = as_robot("planar2r").inverse_dynamics(_Q, [0.0, 0.0], [0.0, 0.0])
    yield Fact("tau", tau, -tau, "N m")


@refutes("9.4")
def skew_part() -> Iterable[Fact]:
    """The symmetric part of dM/dt - 2 C, and of M."""
    robot, qd, h = as_robot("planar2r"), np.array([0.5, -0.3]), 1e-6
    rate = (robot.mass_matrix(_Q + h * qd) - robot.mass_matrix(_Q - h * qd)) / (2 * h)
    N, M = rate - 2 * robot.coriolis_matrix(_Q, qd), robot.mass_matrix(_Q)
    yield Fact("symmetric_part", round(float(np.abs(N + N.T).max()), 6), float(np.abs(M + M.T).max()))


@refutes("10.2.1.1")
def slowest_root() -> Iterable[Fact]:
    """The slowest root of an overdamped loop with zeta = 1.2 and omega_n = 4 rad/s."""
    loop = SecondOrder.of(4.0, 1.2)
    printed = -1.2 * 4.0 - 4.0 * sqrt(1.2**2 - 1.0)
    yield Fact("root", float(np.asarray(loop.roots).real.max()), printed, "1/s")


@refutes("10.2.3")
def error_sign() -> Iterable[Fact]:
    """The pose error after half a step towards the goal by either error."""
    X_d = Pose.exp(np.asarray(ScrewAxis.of([0.0, 0.0, 1.0], [0.5, 0.0, 0.0], 0.1)) * 0.65)
    toward = np.asarray(X_d.log())
    after = [np.linalg.norm(np.asarray((Pose.exp(0.5 * s * toward).inverse() @ X_d).log())) for s in (1.0, -1.0)]
    yield Fact("error", float(after[0]), float(after[1]))


@refutes("10.3")
def force_pole() -> Iterable[Fact]:
    """The pole of a force loop with Kfp = 0.5 and Kfi = 10."""
    yield Fact("pole", -1.0 / float(ForceLoop.of(0.5, 10.0).time_constant), -10.0 / 0.5, "1/s")
