"""Paths of a frame in space: the straight line, turning about one axis, and the screw motion.

Straight moves of the tip as joint trajectories: planned, checked against the rates, stretched if asked.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, Vector6, as_batch, positive, require_finite
from mafsil.errors import InputError
from mafsil.geometry import pose, rotation
from mafsil.robot import Robot, of_robot
from mafsil.robot.degrees import remark_on_degrees
from mafsil.solvers import Outcome
from mafsil.trajectory.checks.limit_check import check
from mafsil.trajectory.motion import PlanStatus
from mafsil.trajectory.path import PathMotion
from mafsil.trajectory.paths.pose_path import STRICTER, PathTask
from mafsil.trajectory.profiles.laws import LawName, rest_law
from mafsil.trajectory.timing.path_following import follow
from mafsil.trajectory.tolerances import GIVEN

Interpolation = Literal["straight", "screw"]


@dataclass(frozen=True, eq=False)
class CartesianPath:
    """From one pose to another, over the parameter s in 0 .. 1.

    straight: p = p_0 + s (p_1 - p_0), R = R_0 exp(s log(R_0' R_1));  screw: T = T_0 exp(s log(T_0^-1 T_1))

    Attributes:
        T_start, T_goal: (4, 4) in {s}.
        interpolation: `straight` moves the origin on a line; `screw` moves the frame about one screw axis.

    Raises:
        InputError: a wrong shape, a number that is not finite, an unknown interpolation.

    Reference: Lynch and Park, Modern Robotics, sec. 9.2.1.
    """

    T_start: PoseMatrix
    T_goal: PoseMatrix
    interpolation: Interpolation = "straight"

    def __post_init__(self) -> None:
        for name in ("T_start", "T_goal"):
            object.__setattr__(self, name, require_finite(name, as_batch(name, getattr(self, name), (4, 4))))
        if self.interpolation not in ("straight", "screw"):
            raise InputError("input.choice", name="interpolation", value=self.interpolation, known="straight, screw")

    @property
    def length(self) -> float:
        """Length of the way of the origin [m]: of a straight one the distance, of a screw the arc about its axis."""
        return float(np.linalg.norm(self._screw[3:] if self.interpolation == "screw" else self._chord))

    @property
    def angle(self) -> float:
        """Angle between the orientations [rad]."""
        return float(np.linalg.norm(self._turn))

    @property
    def breaks(self) -> Floats:
        """0 and 1: it is smooth throughout."""
        return np.array([0.0, 1.0])

    @property
    def corners(self) -> Floats:
        """None."""
        return np.zeros(0)

    def poses(self, s: ArrayLike) -> PoseMatrix:
        """(*s, 4, 4) in {s}."""
        along = np.asarray(s, dtype=np.float64)[..., None]
        if self.interpolation == "screw":
            return self.T_start @ pose.exp(along * self._screw)
        T = np.zeros((*along.shape[:-1], 4, 4))
        T[..., :3, :3] = self.T_start[:3, :3] @ rotation.exp(along * self._turn)
        T[..., :3, 3] = self.T_start[:3, 3] + along * self._chord
        T[..., 3, 3] = 1.0
        return T

    def twists(self, s: ArrayLike) -> tuple[Vector6, Vector6]:
        """Body twist by the path parameter, and its derivative: (*s, 6) each.

        straight: V = (w, R' d), dV/ds = (0, -w x R' d);  screw: V constant.
        """
        T = self.poses(s)
        V, slope = np.zeros((*T.shape[:-2], 6)), np.zeros((*T.shape[:-2], 6))
        if self.interpolation == "screw":
            V[...] = self._screw
            return V, slope
        V[..., :3] = self._turn
        V[..., 3:] = self._chord @ T[..., :3, :3]
        slope[..., 3:] = V[..., 3:] @ self._spin
        return V, slope

    @cached_property
    def _chord(self) -> Floats:
        return self.T_goal[:3, 3] - self.T_start[:3, 3]

    @cached_property
    def _turn(self) -> Floats:
        return rotation.log(self.T_start[:3, :3].T @ self.T_goal[:3, :3])

    @cached_property
    def _spin(self) -> Floats:
        return rotation.hat(self._turn)

    @cached_property
    def _screw(self) -> Floats:
        return pose.error(self.T_start, self.T_goal)


@of_robot
def cartesian_line(
    robot: Robot,
    q_start: ArrayLike,
    T_goal: ArrayLike,
    *,
    duration: float | None = None,
    law: LawName = "quintic",
    interpolation: Interpolation = "straight",
    stretch: bool = False,
    frame: str | None = None,
    task: PathTask = "pose",
    tolerance: float = 1e-6,
) -> Outcome[PathMotion | None]:
    """Move the tip from where it is to `T_goal`, from rest to rest, on the branch of `q_start`.

    Args:
        robot: whose tip or `frame` moves; its limits hold.
        q_start: (n,) [rad | m].
        T_goal: (4, 4) in {s}.
        duration: [s]; the shortest that the joints' velocities, accelerations and jerks allow if None.
        law: time law along the path, a name of `mafsil.trajectory.profiles.LAWS`.
        interpolation: `straight` (line, turning about one axis) or `screw`.
        stretch: take more time than `duration` if the limits need it.
        frame: name of a link; the tip if None.
        task: what of the path the frame keeps to: `pose`; `axis`, the position and the direction of z; `position`. The
            shortest of the motions that keep to it, with the rest left to the arm or kept to as well.
        tolerance: largest deviation from the path [m, rad].

    Returns:
        The motion. Failing that the status and its details say why and where: NOT_FOUND, ORIENTATION_NOT_FOUND,
        SINGULAR, JOINT_LIMIT or DEVIATES without a motion, RATE_LIMIT with the motion that breaks the limits.

    Raises:
        InputError: a wrong shape, a number that is not finite, an unknown law, no duration and no finite limit.
    """
    tolerance = positive("tolerance", tolerance)
    q = require_finite("q_start", as_batch("q_start", q_start, (robot.n,)))
    remark_on_degrees(robot, "q_start", q_start)
    goal: PoseMatrix = require_finite("T_goal", as_batch("T_goal", T_goal, (4, 4)))
    if q.ndim != 1 or goal.ndim != 2:
        name, got = ("q_start", q.shape) if q.ndim != 1 else ("T_goal", goal.shape)
        raise InputError("input.shape", name=name, expected="one start and one goal", got=got, hint="")
    unit = rest_law(law).unit()
    start = robot.forward_kinematics(q) if frame is None else robot.forward_kinematics(q, frame=frame)
    path = CartesianPath(start, goal, interpolation)
    found: list[Outcome[PathMotion | None]] = []
    for each in (task, *STRICTER.get(task, ())):
        joints = follow(robot, path, q, frame=frame, tolerance=tolerance, task=each)
        if joints.value is not None and joints.succeeded:
            found.append(set_duration(robot, PathMotion(joints.value, unit), duration, stretch, joints.residual))
        elif not found:
            return Outcome(None, joints.status, joints.residual, joints.iterations, details=joints.details)
        if duration is not None and found[-1].status is PlanStatus.PLANNED:
            return found[-1]
    # A motion that keeps to more keeps to less: the shortest of all.
    return min(found, key=_shortest)


def _shortest(motion: Outcome[PathMotion | None]) -> float:
    return float(str(motion.details.get("shortest", motion.details["duration"])))


def set_duration(
    robot: Robot, unit: PathMotion, duration: float | None, stretch: bool, residual: float
) -> Outcome[PathMotion | None]:
    """Give a motion of one second its duration.

    Args:
        robot: whose limits hold.
        unit: the motion, one second long.
        duration: requested [s], or None for the shortest.
        stretch: take more time if the limits need it.
        residual: handed on: the deviation from the path.
    """
    shortest = unit.stretch_needed(robot.limits)
    if duration is None:
        if shortest == 0.0:
            raise InputError("trajectory.no_duration")
        return Outcome(unit.scale_time(shortest), PlanStatus.PLANNED, residual, details={"duration": shortest})
    requested = positive("duration", duration)
    motion = unit.scale_time(requested)
    if requested >= shortest * (1.0 - GIVEN):
        return Outcome(motion, PlanStatus.PLANNED, residual, details={"duration": requested})
    worst = check(motion, robot.limits, robot.joint_names).violations[0]
    details = {"joint": worst.joint, "quantity": worst.quantity_name(), "requested": requested, "duration": shortest}
    if stretch:
        return Outcome(unit.scale_time(shortest), PlanStatus.STRETCHED, residual, details=details)
    details |= {"time": worst.time, "value": worst.value, "limit": worst.limit, "shortest": shortest}
    return Outcome(motion, PlanStatus.RATE_LIMIT, residual, details=details)
