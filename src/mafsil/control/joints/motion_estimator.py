"""What sensors tell of a motion: accelerometers, and an estimator of joints and tip with rates and accelerations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, PoseMatrix, Vector3, as_batch, positive
from mafsil.control.laws.task_coordinates import TaskCoordinates
from mafsil.robot import Robot, as_robot, of_robot

BLIND = 1e-9
"""Share of the largest singular value, or of a joint's own part, below which readings do not see a joint."""


@dataclass(frozen=True, eq=False, slots=True)
class TipMotionEstimate:
    """Pose, velocity and acceleration of a tip: X, V = J qd, dV/dt = J qdd + dJ/dt qd.

    Attributes:
        pose: (*batch, 4, 4).
        velocity, acceleration: (*batch, m) in the coordinates of the task.
    """

    pose: PoseMatrix
    velocity: Floats
    acceleration: Floats


@dataclass(frozen=True, eq=False, slots=True)
class JointMotionEstimate:
    """Positions, rates and accelerations of the joints, (*batch, n) each."""

    q: JointVector
    qd: JointVector
    qdd: JointVector

    def tip(self, robot: Robot, coordinates: TaskCoordinates | None = None) -> TipMotionEstimate:
        """The same of the tip.

        Args:
            robot: whose tip it is.
            coordinates: of the velocities; all six, decoupled, if None.
        """
        robot, task = as_robot(robot), coordinates or TaskCoordinates()
        J, rate = task.jacobian(robot, self.q), task.jacobian_rate(robot, self.q, self.qd)
        V, A = (J @ self.qd[..., None])[..., 0], (J @ self.qdd[..., None] + rate @ self.qd[..., None])[..., 0]
        return TipMotionEstimate(task.pose(robot, self.q), V, A)


class MotionEstimator:
    """Rates and accelerations from positions that are measured once a period: a filter with fading memory.

    1. Predict with constant acceleration over the period T.
    2. Correct by the surprise e = measured - predicted: q += (1 - z^3) e,  qd += 1.5 (1 - z^2) (1 - z) e / T,
       qdd += (1 - z)^3 e / T^2,  z = exp(-w T): three equal roots, no overshoot of its own.

    Motions of constant acceleration are followed exactly in the end; a lower bandwidth passes less noise.

    Args:
        period: T [s].
        bandwidth: w [rad/s].
        q, qd: (*batch, n) where it begins, and how fast; at rest if None.

    Raises:
        InputError: a number that is not positive.

    Reference: Morrison, Introduction to Sequential Smoothing and Prediction, 1969.
    """

    def __init__(self, period: float, bandwidth: float, q: ArrayLike, qd: ArrayLike | None = None) -> None:
        self._period = positive("period", period)
        self._keep = float(np.exp(-positive("bandwidth", bandwidth) * period))
        start = np.array(q, dtype=np.float64)
        rates = np.zeros_like(start) if qd is None else np.broadcast_to(np.asarray(qd, dtype=np.float64), start.shape)
        self._now = JointMotionEstimate(start, rates, np.zeros_like(start))

    def update(self, q: JointVector, qdd: JointVector | None = None) -> JointMotionEstimate:
        """The estimate with one more measurement, a period after the last.

        Args:
            q: (*batch, n) measured.
            qdd: (*batch, n) accelerations from accelerometers, which then are taken as they are; None without any.

        Raises:
            InputError: a wrong shape, or a number that is not finite: nothing is remembered of it.
        """
        T, z, now = self._period, self._keep, self._now
        q = as_batch("q", q, now.q.shape[-1:], finite=True)
        # 1.
        ahead = now.q + T * now.qd + T**2 / 2.0 * now.qdd
        faster = now.qd + T * now.qdd
        # 2.
        e = q - ahead
        found = now.qdd + (1.0 - z) ** 3 * e / T**2 if qdd is None else as_batch("qdd", qdd, q.shape[-1:], finite=True)
        self._now = JointMotionEstimate(
            ahead + (1.0 - z**3) * e, faster + 1.5 * (1.0 - z**2) * (1.0 - z) * e / T, found
        )  # fmt: skip
        return self._now


@of_robot
def accelerometer(robot: Robot, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, frame: str | None = None) -> Vector3:
    """What an ideal accelerometer at a link's frame reads, (*batch, 3) [m/s^2]: R' (dv/dt - gravity).

    At rest it reads the gravity that holds it up.

    Args:
        robot: the arm.
        q, qd, qdd: (*batch, n) motion.
        frame: name of the link; the tip frame if None.
    """
    q, qd, qdd = (as_batch(name, x, (robot.n,), finite=True) for name, x in (("q", q), ("qd", qd), ("qdd", qdd)))
    task = TaskCoordinates(rows=(3, 4, 5), frame=frame)
    A = JointMotionEstimate(q, qd, qdd).tip(robot, task)
    specific = A.acceleration - np.asarray(robot.mechanism.gravity)
    return (np.swapaxes(A.pose[..., :3, :3], -1, -2) @ specific[..., None])[..., 0]


@of_robot
def joint_acceleration(robot: Robot, q: ArrayLike, qd: ArrayLike, readings: dict[str, ArrayLike]) -> JointVector:
    """Joint accelerations (*batch, n) from accelerometers on several links, in the sense of least squares.

    R_k a_k + g = J_k qdd + dJ_k/dt qd for each; enough of them on the outer links make it unique.

    Args:
        robot: the arm.
        q, qd: (*batch, n) state.
        readings: (*batch, 3) by the link that carries the accelerometer.

    Returns:
        NaN for a joint whose acceleration the readings do not decide, such as one whose axis passes through all of the
        accelerometers that it moves.
    """
    q, qd = as_batch("q", q, (robot.n,), finite=True), as_batch("qd", qd, (robot.n,), finite=True)
    rows, right = list[Floats](), list[Floats]()
    for link, reading in readings.items():
        task = TaskCoordinates(rows=(3, 4, 5), frame=link)
        a = as_batch(link, reading, (3,), finite=True)
        R = task.pose(robot, q)[..., :3, :3]
        moved = (R @ a[..., None])[..., 0] + np.asarray(robot.mechanism.gravity)
        rows.append(task.jacobian(robot, q))
        right.append(moved - (task.jacobian_rate(robot, q, qd) @ qd[..., None])[..., 0])
    J, b = np.concatenate(rows, axis=-2), np.concatenate(right, axis=-1)
    back = np.asarray(np.linalg.pinv(J, rcond=BLIND), dtype=np.float64)
    found = (back @ b[..., None])[..., 0]
    decided = np.einsum("...ij,...ji->...i", back, J) > 1.0 - BLIND
    return np.asarray(np.where(decided, found, np.nan), dtype=np.float64)
