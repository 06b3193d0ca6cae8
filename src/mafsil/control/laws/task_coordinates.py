"""Tasks of a tip: the coordinates in which they are said, and the dynamics of the arm in them.

Coordinates are velocities of the tip, all six or some, in the axes of {s} or of the tip; orientations may be three
angles. Dynamics are inertia, velocity and gravity forces there. What a redundant arm does beside its task: its joints
are drawn to their reference without moving the tip.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, TypeAlias, TypedDict

import numpy as np
from numpy.typing import ArrayLike

from mafsil.algebra.euler_sequence import SEQUENCES
from mafsil.arrays import (
    Floats,
    JointVector,
    Matrix3,
    PoseMatrix,
    Symbolic,
    Vector3,
    Vector6,
    as_batch,
    fails,
    real_array,
)
from mafsil.control.laws.feedback import Gains
from mafsil.control.laws.law import Law
from mafsil.errors import InputError
from mafsil.geometry import euler, pose, rotation
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion

LOCKED = 1e-6
"""Determinant of the matrix from rates to angular velocity below which angles are locked: rates beyond a million."""
TaskAxes: TypeAlias = str
"""`decoupled`, `body`, `space`, or one of the 24 Euler sequences such as `ZYX`."""
TWISTS = ("decoupled", "body", "space")


class _Where(TypedDict, total=False):
    frame: str


class TaskTarget(NamedTuple):
    """The reference of a tip at one time.

    Attributes:
        pose: (4, 4) T_sd.
        velocity, acceleration: (6,) in the coordinates of the task, all six.
    """

    pose: PoseMatrix
    velocity: Vector6
    acceleration: Vector6


@dataclass(frozen=True, slots=True)
class TaskCoordinates:
    """Velocities of a frame as (m,) numbers V = J qd.

    Attributes:
        axes: `decoupled`: angular velocity and velocity of the origin, both in {s}; `body`: the body twist; `space`:
            the spatial twist; a sequence such as `ZYX` (body axes) or `xyz` (fixed axes): rates of its three angles
            and velocity of the origin in {s}, minimal coordinates whose error is their plain difference.
        rows: which of the six numbers count: (3, 4, 5) of `decoupled` is the position of the tip.
        frame: name of the link whose frame is meant; the tip frame if None.
    """

    axes: TaskAxes = "decoupled"
    rows: tuple[int, ...] = (0, 1, 2, 3, 4, 5)
    frame: str | None = None

    def __post_init__(self) -> None:
        if self.axes not in (*TWISTS, *SEQUENCES):
            raise InputError("input.choice", name="axes", value=self.axes, known=", ".join((*TWISTS, *SEQUENCES)))
        if not len(self.rows) or len(set(self.rows)) < len(self.rows) or not set(self.rows) <= set(range(6)):
            raise InputError("input.choice", name="rows", value=self.rows, known="0, 1, 2, 3, 4, 5")

    @property
    def _where(self) -> _Where:
        """The frame as a keyword; none for that of the tip, whose calls are the fast ones."""
        return {} if self.frame is None else {"frame": self.frame}

    def pose(self, robot: Robot, q: JointVector) -> PoseMatrix:
        """(*batch, 4, 4) of the frame in {s}."""
        return robot.forward_kinematics(q, **self._where)

    def jacobian(self, robot: Robot, q: JointVector) -> Floats:
        """(*batch, m, n) J."""
        if self.axes == "space":
            return robot.jacobian_space(q, **self._where)[..., self.rows, :]
        J, T = robot.jacobian_body(q, **self._where), None
        if self.axes != "body":
            T = self.pose(robot, q)
            J = _turn(T, J)
        if T is not None and self.axes in SEQUENCES:
            J = _upper(rates_of_angles(self._angles(T), self.axes), J)
        return J[..., self.rows, :]

    def jacobian_rate(self, robot: Robot, q: JointVector, qd: JointVector) -> Floats:
        """(*batch, m, n) dJ/dt; of `decoupled` R (dJ_b/dt + [w_b] J_b)."""
        if self.axes == "space":
            return robot.jacobian_space_rate(q, qd, **self._where)[..., self.rows, :]
        rate = robot.jacobian_body_rate(q, qd, **self._where)
        if self.axes != "body":
            J, T = robot.jacobian_body(q, **self._where), self.pose(robot, q)
            W = rotation.hat((J[..., :3, :] @ qd[..., None])[..., 0])
            rate = _turn(T, rate + np.concatenate([W @ J[..., :3, :], W @ J[..., 3:, :]], axis=-2))
            if self.axes in SEQUENCES:
                angles = self._angles(T)
                back = rates_of_angles(angles, self.axes)
                own = back @ _turn(T, J)[..., :3, :]
                E_rate = axes_rate(angles, (own @ qd[..., None])[..., 0], self.axes)
                rate = _upper(back, rate - np.concatenate([E_rate @ own, 0.0 * own], axis=-2))
        return rate[..., self.rows, :]

    def _angles(self, T: PoseMatrix) -> Floats:
        return euler.to_euler(T[..., :3, :3], self.axes)

    def all_six(self, x: Floats) -> Floats:
        """(*batch, 6) of the numbers that count (*batch, m); zero for the others."""
        full = np.zeros_like(x, shape=(*x.shape[:-1], 6))
        full[..., list(self.rows)] = x
        return full

    def integrate(self, T: PoseMatrix, step: Floats) -> PoseMatrix:
        """(*batch, 4, 4) a pose after a step V dt of constant velocity.

        Args:
            T: (*batch, 4, 4).
            step: (*batch, m) in these coordinates.
        """
        whole = self.all_six(step)
        if self.axes == "space":
            return pose.exp(whole) @ T
        if self.axes == "body":
            return T @ pose.exp(whole)
        if self.axes in SEQUENCES:
            turned = euler.from_euler(self._angles(T) + whole[..., :3], self.axes)
        else:
            turned = rotation.exp(whole[..., :3]) @ T[..., :3, :3]
        return pose.from_rotation_translation(turned, T[..., :3, 3] + whole[..., 3:])

    def error(self, T: PoseMatrix, target: TaskTarget, V: Floats) -> tuple[Floats, Floats, Floats]:
        """Configuration error, velocity error and the acceleration to feed forward, (*batch, m) each.

        decoupled: X_e = (log(R_d R'), p_d - p),  V_e = V_d - V;
        space:     X_e = log(T_d T^-1),           V_e = V_d - V;
        body:      X_e = log(T^-1 T_d),           V_e = Ad V_d - V,  A = Ad A_d + ad(Ad V_d) V,  Ad = Ad(T^-1 T_d);
        angles:    X_e = (phi_d - phi, p_d - p),  V_e = V_d - V, and dX_e/dt = V_e exactly.

        Each of the others is the rate of the other to first order in X_e; at half a turn the logarithm has two values.

        Args:
            T: (*batch, 4, 4) pose of the frame.
            target: what it should do.
            V: (*batch, m) its velocity in these coordinates.

        Reference: Lynch and Park, Modern Robotics, sec. 11.4.3.
        """
        rows, T, V = list(self.rows), real_array("T", T), real_array("V", V)
        T_d, ahead, A = (real_array("target", part) for part in target)
        if self.axes == "decoupled":
            apart = rotation.log(T_d[..., :3, :3] @ np.swapaxes(T[..., :3, :3], -1, -2))
            X = np.concatenate([apart, T_d[..., :3, 3] - T[..., :3, 3]], axis=-1)
        elif self.axes in SEQUENCES:
            apart = angle_error(self._angles(T_d), self._angles(T))
            X = np.concatenate([apart, T_d[..., :3, 3] - T[..., :3, 3]], axis=-1)
        elif self.axes == "space":
            X = pose.log(T_d @ pose.inverse(T))
        else:
            between = pose.inverse(T) @ T_d
            Ad = pose.adjoint(between)
            X, ahead, A = pose.log(between), (Ad @ ahead[..., None])[..., 0], (Ad @ A[..., None])[..., 0]
            if len(rows) == 6:
                A = A + _bracket(ahead, V)
        return X[..., rows], ahead[..., rows] - V, A[..., rows]


def _turn(T: PoseMatrix, J: Floats) -> Floats:
    """Both halves of a Jacobian in the axes of {s}."""
    R = T[..., :3, :3]
    return np.concatenate([R @ J[..., :3, :], R @ J[..., 3:, :]], axis=-2)


def _upper(A: Floats, J: Floats) -> Floats:
    """A times the upper three rows; the others as they are."""
    return np.concatenate([A @ J[..., :3, :], J[..., 3:, :]], axis=-2)


def _bracket(V: Vector6, W: Vector6) -> Vector6:
    """ad_V W."""
    turn = np.cross(V[..., :3], W[..., :3])
    return np.concatenate([turn, np.cross(V[..., :3], W[..., 3:]) + np.cross(V[..., 3:], W[..., :3])], axis=-1)


def rates_of_angles(angles: Vector3, sequence: str) -> Matrix3:
    """(*batch, 3, 3) from the angular velocity in {s} to the rates of three angles.

    Args:
        angles: (*batch, 3) [rad].
        sequence: such as `ZYX`.

    Raises:
        InputError: a gimbal lock, where there are no such rates.
    """
    E = euler.rates_to_angular_velocity(angles, sequence)
    if not isinstance(E, Symbolic) and fails(np.abs(np.linalg.det(E)) < LOCKED):
        raise InputError("performance.gimbal_lock", sequence=sequence)
    return real_array("E", np.linalg.inv(E))


def axes_rate(angles: Vector3, rates: Vector3, sequence: str) -> Matrix3:
    """(*batch, 3, 3) time derivative of the matrix E of omega_s = E dphi/dt, whose columns are the axes of the turns.

    Each axis is carried by the turns that stand before it: dc_i/dt = (sum of c_j dphi_j/dt before it) x c_i.

    Args:
        angles, rates: (*batch, 3) [rad, rad/s].
        sequence: such as `ZYX`.
    """
    E = euler.rates_to_angular_velocity(angles, sequence)
    E_rate, carried = np.zeros_like(E), np.zeros_like(rates)
    order = (2, 1, 0) if euler.sequence_named(sequence).fixed else (0, 1, 2)
    for k in order:
        E_rate[..., k] = np.cross(carried, E[..., k])
        carried = carried + E[..., k] * rates[..., k, None]
    return E_rate


def angle_error(wanted: Vector3, angles: Vector3) -> Floats:
    """(*batch, 3) difference of angles, each the short way round [rad].

    Args:
        wanted, angles: (*batch, 3) [rad].
    """
    return euler.wrap_symmetric(wanted - angles)


LOST = 1e-12
"""Share of the largest eigenvalue of J M^-1 J' below which a direction of the task is lost: no force acts along it."""


@dataclass(frozen=True, eq=False, slots=True)
class TaskDynamics:
    """F = Lambda dV/dt + gamma + eta, with tau = J' F.

    Attributes:
        J, J_rate: (*batch, m, n) Jacobian and its derivative in time.
        inertia: (*batch, m, m) Lambda = (J M^-1 J')^-1.
        velocity_force: (*batch, m) gamma = Lambda (J M^-1 c - dJ/dt qd).
        gravity_force: (*batch, m) eta = Lambda J M^-1 g.
        inverse: (*batch, n, m) M^-1 J' Lambda, the inverse of J of least kinetic energy.
        V: (*batch, m) velocity.
    """

    J: Floats
    J_rate: Floats
    inertia: Floats
    velocity_force: Floats
    gravity_force: Floats
    inverse: Floats
    V: Floats

    def force(self, acceleration: Floats) -> Floats:
        """(*batch, m) that makes the tip accelerate so.

        Args:
            acceleration: (*batch, m) dV/dt.
        """
        return _times(self.inertia, acceleration) + self.velocity_force + self.gravity_force

    def effort(self, force: Floats, rest: Floats | None = None) -> JointVector:
        """(*batch, n) tau = J' F, and what does not move the tip: (I - J' Jbar') tau_0.

        Args:
            force: (*batch, m) at the tip, in the coordinates of the task.
            rest: (*batch, n) efforts of which only the part in the null space is taken.
        """
        tau = _times(np.swapaxes(self.J, -1, -2), force)
        if rest is None:
            return tau
        felt = _times(np.swapaxes(self.inverse, -1, -2), rest)
        return tau + rest - _times(np.swapaxes(self.J, -1, -2), felt)


@of_robot
def task_dynamics(
    robot: Robot, q: ArrayLike, qd: ArrayLike | None = None, coordinates: TaskCoordinates | None = None
) -> TaskDynamics:
    """Inertia, velocity and gravity forces at the tip.

    In directions that the arm has lost (at a singularity) the inverse is that of Moore and Penrose.

    Args:
        robot: its model; friction is not part of it.
        q, qd: (*batch, n) positions and rates; at rest if None [rad | m].
        coordinates: of the task; all six, decoupled, if None.

    Raises:
        InputError: a wrong shape, a number that is not finite.
        ModelError: the robot has no masses.

    Reference: Khatib, A unified approach for motion and force control of robot manipulators, 1987; Lynch and Park,
        Modern Robotics, eq. (8.90).
    """
    task = coordinates or TaskCoordinates()
    q = as_batch("q", q, (robot.n,), finite=True)
    qd = np.zeros_like(q) if qd is None else as_batch("qd", qd, (robot.n,), finite=True)
    J, J_rate = task.jacobian(robot, q), task.jacobian_rate(robot, q, qd)
    M = robot.mass_matrix(q)
    c, g = robot.velocity_torque(q, qd), robot.gravity_torque(q)
    columns = np.concatenate([np.swapaxes(J, -1, -2), c[..., None], g[..., None]], axis=-1)
    solved = real_array("mass_matrix", np.linalg.solve(M, columns))
    m = J.shape[-2]
    inertia = _inverse(J @ solved[..., :m])
    pulls = J @ solved[..., m:]
    gamma = _times(inertia, pulls[..., 0] - _times(J_rate, qd))
    eta = _times(inertia, pulls[..., 1])
    return TaskDynamics(J, J_rate, inertia, gamma, eta, solved[..., :m] @ inertia, _times(J, qd))


def _inverse(A: Floats) -> Floats:
    """(*batch, m, m) of Moore and Penrose, of a symmetric A; `np.linalg.pinv` sorts and checks for 45 us more."""
    sizes, axes = np.linalg.eigh(A)
    kept = np.abs(sizes) > LOST * np.abs(sizes).max(axis=-1, keepdims=True)
    with np.errstate(divide="ignore"):
        shares = np.where(kept, 1.0 / sizes, 0.0)
    return real_array("A", (axes * shares[..., None, :]) @ np.swapaxes(axes, -1, -2))


def _times(A: Floats, x: Floats) -> Floats:
    return (A @ x[..., None])[..., 0]


@dataclass(frozen=True, eq=False, slots=True)
class NullSpaceFeedback:
    """tau = (I - J' Jbar') (M (a + Kp (u - q) + Kd (v - qd)) + c + g): efforts that do not accelerate the tip.

    Laws of the tip bear what they feel of gravity; the rest of it, along motions that leave the tip at rest, is borne
    here.

    Attributes:
        robot: the model.
        coordinates: of the task that is left alone.
        gains: (n,) in units of acceleration.
    """

    robot: Robot
    coordinates: TaskCoordinates
    gains: Gains

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N]."""
        now = task_dynamics(self.robot, q, qd, self.coordinates)
        pull = reference.a + self.gains.kp * (reference.u - q) + self.gains.kd * (reference.v - qd)
        return now.effort(np.zeros_like(now.V), self.robot.inverse_dynamics(q, qd, pull))

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self


@of_robot
def null_space_feedback(
    robot: Robot, *, coordinates: TaskCoordinates | None = None, natural_frequency: ArrayLike = 2.0
) -> NullSpaceFeedback:
    """Joint feedback in the null space of a task; combine it with a task-space law.

    Args:
        robot: the model, with more joints than the task has coordinates.
        coordinates: of the task; all six, decoupled, if None.
        natural_frequency: w, a number or (n,), critically damped [rad/s].

    Reference: Khatib, A unified approach for motion and force control of robot manipulators, 1987.
    """
    gains = Gains.from_natural_frequency(robot.n, natural_frequency)
    return NullSpaceFeedback(robot, coordinates or TaskCoordinates(), gains)
