"""Moves in frames that move, such as those of conveyors and turntables: catching up, staying on them, leaving them.

T(t) = F(t) R(sigma(t)): the path R of the tip in the frame from rest to rest, on the motion F of the frame.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, PoseMatrix, Vector6
from mafsil.geometry import pose, rotation, twist
from mafsil.job.language.description import TIP_PATHS, Goal, Grasp, Move, Task
from mafsil.job.language.units import goal_matrix, pose_matrix, tolerances
from mafsil.job.planning.fitting import coordinates
from mafsil.job.planning.goals import FIXES
from mafsil.job.planning.tip_motion import SHORTEST, time_law, tip_rates, too_fast
from mafsil.job.planning.tip_moves import path_or_refusal
from mafsil.job.planning.walk import Walk
from mafsil.job.remark import Refused
from mafsil.job.tolerances import WITHIN_LIMITS
from mafsil.messages.visible import visible
from mafsil.trajectory import Trajectory, check
from mafsil.trajectory.motion import Stretchable
from mafsil.trajectory.paths import TipPath
from mafsil.trajectory.profiles import rest
from mafsil.trajectory.profiles.polynomial import quintic_coefficients
from mafsil.trajectory.splines import PiecewisePolynomial
from mafsil.trajectory.timing.path_following import follow

FIRST, LONGEST = 0.05, 30.0
"""Shortest and longest time in which a frame is caught up with, or left [s]."""
SLOWER, HALVINGS = 1.25, 7
"""Factor between durations that are tried, and how often the step to the first that suits is halved."""
GLANCE = 0.02
"""Of the motion with the frame from which velocity and acceleration at its beginning are taken [s]."""
ON_FRAME, OFF_FRAME = ("profile", "constraints", "blend"), ("via", "avoid")
"""Keys of moves that have no meaning on a moving frame, and on the way to it or off it."""


@dataclass(frozen=True, eq=False, slots=True)
class FrameMotion:
    """A frame on its way.

    Attributes:
        T: (4, 4) where it is at its time zero, in {s}.
        velocity: (3,) of its origin in {s} [m/s].
        angular_speed: about its z axis [rad/s].
        start: its time zero, in the time of the plan [s].
    """

    T: PoseMatrix
    velocity: Floats
    angular_speed: float
    start: float

    def pose(self, t: ArrayLike) -> PoseMatrix:
        """(*t, 4, 4) in {s} at times of the plan [s]."""
        past = np.asarray(t, dtype=np.float64)[..., None] - self.start
        T = np.zeros((*past.shape[:-1], 4, 4))
        T[..., :3, :3] = self.T[:3, :3] @ rotation.exp(past * np.array([0.0, 0.0, self.angular_speed]))
        T[..., :3, 3] = self.T[:3, 3] + past * self.velocity
        T[..., 3, 3] = 1.0
        return T

    def twist(self, T: PoseMatrix) -> tuple[Vector6, Vector6]:
        """Body twist where it is at T (*t, 4, 4), and its rate: (*t, 6) each."""
        V, rate = np.zeros((*T.shape[:-2], 6)), np.zeros((*T.shape[:-2], 6))
        V[..., 2] = self.angular_speed
        V[..., 3:] = self.velocity @ T[..., :3, :3]
        rate[..., 3:] = -np.cross(V[..., :3], V[..., 3:])
        return V, rate


@dataclass(frozen=True, eq=False)
class CarriedPath:
    """The tip's path on a moving frame over a share of a time: a `TipPath` whose twists do not vanish at its ends.

    Attributes:
        frame: that moves.
        path: of the tip in it, or the (4, 4) pose at which it stays.
        law: share of that path over time; None where it stays.
        start, duration: in the time of the plan [s].
    """

    frame: FrameMotion
    path: TipPath | PoseMatrix
    law: Stretchable | None
    start: float
    duration: float
    breaks = np.array([0.0, 1.0])
    corners = np.zeros(0)

    @property
    def length(self) -> float:
        """Length of the way of its origin [m]."""
        p = self.poses(np.linspace(0.0, 1.0, 65))[:, :3, 3]
        return float(np.linalg.norm(np.diff(p, axis=0), axis=1).sum())

    @property
    def angle(self) -> float:
        """By how much it turns on the way [rad]."""
        own = 0.0 if isinstance(self.path, np.ndarray) else self.path.angle
        return own + abs(self.frame.angular_speed) * self.duration

    def poses(self, s: ArrayLike) -> PoseMatrix:
        """(*s, 4, 4) in {s}."""
        share = np.asarray(s, dtype=np.float64)
        return self.frame.pose(self.start + share * self.duration) @ self._relative(share)[0]

    def twists(self, s: ArrayLike) -> tuple[Vector6, Vector6]:
        """Body twist by the share, and its derivative: (*s, 6) each.

        V = Ad(R^-1) V_F + V_R,  dV/ds = Ad(R^-1) dV_F/ds - ad(V_R) Ad(R^-1) V_F + dV_R/ds
        """
        share = np.asarray(s, dtype=np.float64)
        R, V_R, slope_R = self._relative(share)
        V_F, slope_F = self.frame.twist(self.frame.pose(self.start + share * self.duration))
        Ad = pose.adjoint(pose.inverse(R))
        V = self.duration * np.einsum("...ij,...j->...i", Ad, V_F)
        slope = self.duration**2 * np.einsum("...ij,...j->...i", Ad, slope_F)
        return V + V_R, slope - twist.bracket(V_R, V) + slope_R

    def _relative(self, share: Floats) -> tuple[PoseMatrix, Vector6, Vector6]:
        """Pose in the frame, body twist there by the share, and its derivative."""
        if isinstance(self.path, np.ndarray) or self.law is None:
            zero = np.zeros((*share.shape, 6))
            return np.broadcast_to(np.asarray(self.path), (*share.shape, 4, 4)), zero, zero
        law = self.law.scale_time(1.0 / self.law.duration).at(np.clip(share, 0.0, 1.0))
        sigma, rate, growth = (np.asarray(each)[..., 0] for each in law)
        V, slope = self.path.twists(sigma)
        rate, growth = rate[..., None], growth[..., None]
        return self.path.poses(sigma), rate * V, rate**2 * slope + growth * V


class FrameMoves:
    """Plans moves in frames that move.

    Args:
        walk: where the robot is.
    """

    def __init__(self, walk: Walk) -> None:
        self.walk = walk
        self.frame: FrameMotion | None = None
        self.name = ""
        self.task: Task = "pose"

    def concerns(self, move: Move) -> bool:
        """Whether a move is one of these: it is to a moving frame, or leaves one."""
        return self.frame is not None or (move.pose is not None and move.pose.carrier is not None)

    def stay(self, index: int, duration: float) -> Trajectory:
        """A rest on the frame that the arm is on, or where it is, for a time [s]."""
        if self.frame is None:
            return rest(self.walk.q, duration)
        motion = self._move_with_frame(self._from_frame(self.frame), None, duration, index)
        if not check(motion, self.walk.limits, tolerance=WITHIN_LIMITS, ends=False):
            raise Refused("job.frame_too_fast", move=self.walk.where(index), frame=visible(self.name))
        return motion

    def miss(self, part: Grasp, tip: PoseMatrix) -> float | None:
        """Distance from the grip to the nearest part of that name on the frame [m]; as `PlacedParts.miss`.

        Args:
            part: as the move describes it.
            tip: (4, 4) pose of the tip in {s}, now.
        """
        if self.frame is None:
            rides = any(part.name == one.name and carrier for one, _, carrier in self.walk.job.lying)
            stands = any(each.kind == part.name for each in self.walk.parts.standing)
            return float("inf") if rides and not stands else None
        return self.walk.riding[self.name].miss(part, self._at_zero(self.frame, tip))

    def take(self, part: Grasp, tip: PoseMatrix) -> None:
        """A part on the frame is taken; where a signal brings the frame, it brings a new one each time."""
        if self.frame is not None and self.walk.job.moving[self.name].since is None:
            self.walk.riding[self.name].take(part, self._at_zero(self.frame, tip), -1, self.walk.past)

    def go(self, index: int, name: str, move: Move) -> None:
        """Along a path in the frame, to it, or off it."""
        walk, goal = self.walk, move.pose
        task: Task = "pose" if goal is None else goal.task
        inside = goal is not None and (goal.carrier == self.name or goal.relative is not None)
        along = self.frame is not None and inside and move.path in TIP_PATHS
        if refused := self._refused_keys(move, along=along):
            raise Refused("job.frame_alone", move=walk.where(index), keys=", ".join(refused))
        if self.frame is not None and goal is not None and along:
            trajectory, target = self._along(self.frame, move, goal, index)
        elif goal is not None and goal.carrier is not None:
            trajectory, target = self._catch_up(move, goal, index)
        else:
            trajectory, target = self._leave(move, index)
        kind = move.path if along else "joint"
        walk.append(index, name, kind, trajectory, None, target, task, frame=self.name if self.frame else "")

    def _refused_keys(self, move: Move, *, along: bool) -> list[str]:
        """Options of a move that mean nothing on a frame, or off a path in it."""
        refused = [key for key in ON_FRAME if getattr(move, key)]
        if not along:
            refused += [key for key in OFF_FRAME if getattr(move, key)]
            refused += ["path"] * (move.path != "joint" or (self.frame is not None and move.carried))
        return refused

    def _catch_up(self, move: Move, goal: Goal, index: int) -> tuple[Trajectory, PoseMatrix]:
        """All joints from rest onto the frame, with its velocity and acceleration at the end."""
        walk, where, name = self.walk, self.walk.where(index), str(goal.carrier)
        frame = self._frame_motion(name, where)
        relative = goal_matrix(goal, self._from_frame(frame), degrees=walk.degrees)
        allowed, q, start = tolerances(walk.job, walk.robot, index), walk.q, walk.past
        self.frame, self.name = frame, name
        # What an arm may leave aside where it arrives, it keeps from there on: its rates would jump where tasks change.
        self.task = "pose" if walk.robot.n >= FIXES["pose"] else goal.task

        def motion(duration: float) -> Trajectory:
            target = frame.pose(start + duration) @ relative
            end = walk.goals.configuration(target, goal.task, q, allowed, where)
            at = pose.inverse(frame.pose(start + duration)) @ np.asarray(walk.robot.forward_kinematics(end))
            beyond = self._move_with_frame(at, None, GLANCE, index, end, start + duration).at(0.0)
            return _between(q, np.zeros_like(q), np.zeros_like(q), end, beyond.v, beyond.a, duration)

        trajectory = self._shortest(move, index, motion)
        return trajectory, frame.pose(start + trajectory.duration) @ relative

    def _along(self, frame: FrameMotion, move: Move, goal: Goal, index: int) -> tuple[Trajectory, PoseMatrix]:
        """A path of the tip in the frame, from rest to rest in it."""
        walk, where, before = self.walk, self.walk.where(index), self._from_frame(frame)
        if goal.relative is None:
            after = goal_matrix(goal, before, degrees=walk.degrees)
        else:
            here = np.asarray(walk.robot.forward_kinematics(walk.q))
            after = pose.inverse(frame.pose(walk.past)) @ goal_matrix(goal, here, degrees=walk.degrees)
        path = path_or_refusal(before, [move], [after], walk.degrees, where)
        if path is None:
            trajectory = self.stay(index, move.duration or SHORTEST)
        else:
            law = time_law(*tip_rates(path, walk.bounds(move), move), move)

            def motion(duration: float) -> Trajectory:
                return self._move_with_frame(path, law, duration, index)

            trajectory = self._shortest(move, index, motion, law.duration)
        return trajectory, frame.pose(walk.past + trajectory.duration) @ after

    def _leave(self, move: Move, index: int) -> tuple[Trajectory, PoseMatrix | None]:
        """All joints from the frame to rest at a goal."""
        walk, goal, target = self.walk, move.pose, None
        if goal is None:
            end = coordinates(walk.job, walk.robot, move.joints or ())
        else:
            target = walk.target(goal, walk.q)
            allowed = tolerances(walk.job, walk.robot, index)
            end = walk.goals.configuration(target, goal.task, walk.q, allowed, walk.where(index))
        before, q, still = walk.legs[-1].trajectory, walk.q, np.zeros_like(walk.q)
        leaving = before.at(before.duration)

        def motion(duration: float) -> Trajectory:
            return _between(q, leaving.v, leaving.a, end, still, still, duration)

        self.frame = None
        return self._shortest(move, index, motion), target

    def _frame_motion(self, name: str, where: object) -> FrameMotion:
        """The frame as it moves since its signal last came."""
        walk, moving = self.walk, self.walk.job.moving[name]
        begin = 0.0 if moving.since is None else walk.signals.last_rise(moving.since, walk.past)
        if begin is None:
            raise Refused("job.frame_not_started", move=where, frame=visible(name), signal=visible(str(moving.since)))
        T = pose_matrix(moving.pose, degrees=False)
        return FrameMotion(T, np.array(moving.velocity), moving.angular_speed, begin)

    def _at_zero(self, frame: FrameMotion, tip: PoseMatrix) -> PoseMatrix:
        """(4, 4) of a tip as it would be if the frame were where it is at its time zero."""
        return frame.T @ pose.inverse(frame.pose(self.walk.past)) @ tip

    def _from_frame(self, frame: FrameMotion) -> PoseMatrix:
        """(4, 4) of the tip in a frame, now."""
        return pose.inverse(frame.pose(self.walk.past)) @ np.asarray(self.walk.robot.forward_kinematics(self.walk.q))

    def _move_with_frame(
        self, path: TipPath | PoseMatrix, law: Stretchable | None, duration: float, index: int,
        q: JointVector | None = None, start: float | None = None,
    ) -> Trajectory:  # fmt: skip
        """The joints that bring the tip along a path in the frame, or keep it at a pose there."""
        walk, frame = self.walk, self.frame
        assert frame is not None
        carried = CarriedPath(frame, path, law, walk.past if start is None else start, duration)
        found = follow(walk.robot, carried, walk.q if q is None else q, task=self.task)
        if found.value is None or not found.succeeded:
            raise Refused("job.no_path", move=walk.where(index), reason=found)
        return found.value.scale_time(duration)

    def _shortest(
        self, move: Move, index: int, motion: Callable[[float], Trajectory], first: float = FIRST
    ) -> Trajectory:
        """The quickest motion within the limits, of those that are not shorter than `first` [s]."""
        limits, where, wrong = self.walk.scaled_limits(move), self.walk.where(index), [Refused("job.frame_too_fast")]

        def suits(duration: float) -> Trajectory | None:
            try:
                found = motion(duration)
            except Refused as no:
                wrong.append(no)
                return None
            return found if check(found, limits, tolerance=WITHIN_LIMITS, ends=False) else None

        if move.duration is not None and move.duration >= first and (found := suits(move.duration)) is not None:
            return found
        duration, found = first, suits(first)
        while found is None and duration < LONGEST:
            duration *= SLOWER
            found = suits(duration)
        if found is None and wrong[1:]:
            raise wrong[-1]
        if found is None:
            raise Refused("job.frame_too_fast", move=where, frame=visible(self.name))
        if move.duration is not None:
            raise too_fast(where, duration)
        step = duration - duration / SLOWER
        for _ in range(HALVINGS if duration > first else 0):
            step /= 2.0
            if (quicker := suits(duration - step)) is not None:
                duration, found = duration - step, quicker
        return found


def _between(q: Floats, v: Floats, a: Floats, q_end: Floats, v_end: Floats, a_end: Floats, T: float) -> Trajectory:
    """A quintic between two states of motion in a time T [s]."""
    return PiecewisePolynomial.from_pieces([T], quintic_coefficients(q, q_end, v, v_end, a, a_end, T)[None])
