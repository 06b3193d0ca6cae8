"""The ways of a tip to a pose by the error that its law uses: decoupled, body, space, or angles; on one move."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, positive, require_kind, single
from mafsil.control.laws.feedback import Gains, per_joint
from mafsil.control.laws.task_coordinates import TWISTS, TaskAxes, TaskCoordinates, TaskTarget, rates_of_angles
from mafsil.errors import InputError
from mafsil.geometry import euler, pose, quaternion, rotation
from mafsil.messages import say
from mafsil.messages.quantities import quantity
from mafsil.one_joint import measure_response
from mafsil.solvers import Tolerance, integrate_adaptively, pair

PLACES = 401
MOST_ANGLE = 3e3
"""Largest product of duration and rate of the error: what an integration follows, step by step."""
"""Times at which a way is kept."""
ACCURACY = Tolerance(1e-10, 1e-12)
"""Of the integration."""
SETTLED = 0.02
"""Share of the whole move below which what is left counts as settled."""


@dataclass(frozen=True, eq=False, slots=True)
class PoseErrorResponse:
    """The motion of a tip to a set point under one definition of the pose error.

    Attributes:
        axes: of the error: `decoupled`, `body`, `space`, or a sequence of angles.
        t: (k,) times [s].
        poses: (k, 4, 4).
        off_line: largest distance of the origin from the straight line [m].
        length: of the way of the origin [m].
        off_turn: largest angle of the rotation from the shortest way of rotating [rad].
        turned: angle that is rotated through in all [rad].
        settling_time: after which the origin and the rotation keep within a fiftieth of the move [s]; NaN if later than
            the last time.
    """

    axes: TaskAxes
    t: Floats = field(repr=False)
    poses: PoseMatrix = field(repr=False)
    off_line: float
    length: float
    off_turn: float
    turned: float
    settling_time: float

    def explain(self, language: str | None = None) -> str:
        """What the way is like, in a sentence."""
        details = {name: quantity(getattr(self, name), "m") for name in ("off_line", "length")}
        details |= {name: quantity(getattr(self, name), "rad") for name in ("off_turn", "turned")}
        key = "control.tip_way" if np.isfinite(self.settling_time) else "control.tip_way_unsettled"
        time = quantity(float(self.settling_time if np.isfinite(self.settling_time) else self.t[-1]), "s")
        return say(key, language=language, axes=self.axes, **details, time=time)

    def to_dict(self) -> dict[str, Any]:
        """Plain data without the poses."""
        names = ("axes", "off_line", "length", "off_turn", "turned", "settling_time")
        return {name: getattr(self, name) for name in names}

    def __str__(self) -> str:
        return self.explain()


def compare_pose_errors(
    start: ArrayLike,
    goal: ArrayLike,
    *,
    axes: tuple[TaskAxes, ...] = TWISTS,
    natural_frequency: ArrayLike = 10.0,
    damping_ratio: ArrayLike = 1.0,
    duration: float | None = None,
) -> tuple[PoseErrorResponse, ...]:
    """Compare pose errors X_e: motions of a tip from rest to a set point under dV/dt = Kp X_e + Kd V_e.

    Computed torque of the tip with a right model makes any arm move so. With `decoupled` the origin goes straight and
    the rotation the shortest way, each for itself. With `body` and `space` and gains that are numbers both follow the
    same screw. With angles these change in proportion.

    Args:
        start, goal: (4, 4) poses in {s}.
        axes: of the errors.
        natural_frequency, damping_ratio: of each error, numbers or (6,) [rad/s, 1].
        duration: that is looked at; 10 over the lowest natural frequency if None [s].

    Raises:
        InputError: not poses, a wrong shape, unknown axes.

    Reference: Lynch and Park, Modern Robotics, sec. 11.4.3.
    """
    T, T_d = (pose.check(single(name, x, (4, 4)), name) for name, x in (("start", start), ("goal", goal)))
    require_kind("axes", axes, "tuple of TaskAxes", "__len__", "__iter__")
    per_joint("natural_frequency", natural_frequency, 6, positive=True)
    gains = Gains.from_natural_frequency(6, natural_frequency, damping_ratio)
    end = 10.0 / float(np.sqrt(gains.kp.min())) if duration is None else positive("duration", duration)
    fastest = float(np.max(np.sqrt(gains.kp) + gains.kd))
    if end * fastest > MOST_ANGLE:
        raise InputError("input.range", name="duration", value=end, low=0.0, high=MOST_ANGLE / fastest)
    t = np.linspace(0.0, end, PLACES)
    return tuple(_measure(one, t, _way(one, T, T_d, gains, t), T_d) for one in axes)


def _way(axes: TaskAxes, T: PoseMatrix, T_d: PoseMatrix, gains: Gains, t: Floats) -> PoseMatrix:
    """(k, 4, 4) poses over time, from rest."""
    task, target = TaskCoordinates(axes), TaskTarget(T_d, np.zeros(6), np.zeros(6))

    def field(_: float, y: Floats) -> Floats:
        here, V = _pose(y), y[12:]
        X_e, V_e, ahead = task.error(here, target, V)
        omega, velocity = _in_space(axes, here, V)
        spin = rotation.hat(omega) @ here[:3, :3]
        return np.concatenate([spin.ravel(), velocity, ahead + gains.kp * X_e + gains.kd * V_e])

    start = np.concatenate([T[:3, :3].ravel(), T[:3, 3], np.zeros(6)])
    found = integrate_adaptively(pair("dop853"), field, start, (0.0, float(t[-1])), tolerance=ACCURACY)
    if not found:
        raise InputError("control.tip_way_lost", axes=axes, reason=found.status.sentence())
    return _pose(found.value.at(t))


def _pose(y: Floats) -> PoseMatrix:
    """(*batch, 4, 4) of states (*batch, 18); rotations of a state that an integration left are nearly such."""
    R = rotation.project(y[..., :9].reshape(*y.shape[:-1], 3, 3))
    return pose.from_rotation_translation(R, y[..., 9:12])


def _in_space(axes: TaskAxes, T: PoseMatrix, V: Floats) -> tuple[Floats, Floats]:
    """Angular velocity and velocity of the origin, both in {s}, of a velocity in coordinates of a task."""
    R, p, omega, v = T[:3, :3], T[:3, 3], V[:3], V[3:]
    if axes == "body":
        return R @ omega, R @ v
    if axes == "space":
        return omega, v + np.cross(omega, p)
    if axes == "decoupled":
        return omega, v
    back = rates_of_angles(euler.to_euler(R, axes), axes)
    return np.asarray(np.linalg.solve(back, omega), dtype=np.float64), v


def _measure(axes: TaskAxes, t: Floats, poses: PoseMatrix, T_d: PoseMatrix) -> PoseErrorResponse:
    """The measures of a way.

    The rotation about the axis a of the whole one that is nearest to Q = R_0' R, with the quaternion (w, v), leaves the
    angle 2 atan2(|v - (v . a) a|, |(w, v . a)|).
    """
    R, p = poses[:, :3, :3], poses[:, :3, 3]
    line, whole = T_d[:3, 3] - p[0], rotation.log(R[0].T @ T_d[:3, :3])
    distance, angle = float(np.linalg.norm(line)), float(np.linalg.norm(whole))
    away = p - p[0]
    if distance > 0.0:
        away = away - (away @ line)[:, None] * line / distance**2
    axis = whole / angle if angle > 0.0 else whole
    q = np.asarray(quaternion.to_quaternion(R[0].T @ R), dtype=np.float64)
    along: Floats = q[:, 1:] @ axis
    off = 2.0 * np.arctan2(np.linalg.norm(q[:, 1:] - along[:, None] * axis, axis=1), np.hypot(q[:, 0], along))
    shares = [
        np.asarray(left) / most
        for left, most in (
            (np.linalg.norm(T_d[:3, 3] - p, axis=1), distance),
            (rotation.angle_between(R, T_d[:3, :3]), angle),
        )
        if most > 0.0
    ]
    settled = measure_response(t, np.max(shares, axis=0), 0.0, SETTLED).settling_time if shares else 0.0
    return PoseErrorResponse(
        axes, t, poses, off_line=float(np.linalg.norm(away, axis=1).max()),
        length=float(np.linalg.norm(np.diff(p, axis=0), axis=1).sum()), off_turn=float(off.max()),
        turned=float(np.sum(rotation.angle_between(R[:-1], R[1:]))), settling_time=float(settled),
    )  # fmt: skip
