"""Along a path of poses: the same branch as long as it lasts, every switch and every near-singularity named."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, PoseMatrix, as_batch, positive, single
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.ik.answers import Branch, SolutionSet
from mafsil.ik.inverse import inverse_kinematics
from mafsil.ik.numerical import solve_ik
from mafsil.ik.numerical.problem import problem_of
from mafsil.ik.refine import wound_near
from mafsil.ik.result import IKResult, clean_poses, printed_pose
from mafsil.ik.tolerances import FROM_THE_POSE, NEARLY_SINGULAR, PULLED, REACHED, SELF_MOTION
from mafsil.messages import say
from mafsil.model.loading import RobotLike
from mafsil.robot import Robot, as_robot
from mafsil.robot.degrees import remark_on_degrees

TrackTask = Literal["pose", "position"]
"""What of a path is tracked; the rest is left to the arm."""
LOOK = 4
"""Configurations that show how many freedoms an arm has."""
FINEST = 2.0**-14
"""Smallest part of the way between two poses that is tried before the branch is given up."""


class TrackStatus(Status):
    """How a path was followed."""

    FOLLOWED = ("ik.track_followed", True)
    SWITCHED = ("ik.track_switched", False)
    STOPPED = ("ik.track_stopped", False)


@dataclass(frozen=True, eq=False)
class BranchSwitch:
    """A place where the branch could not be kept.

    Attributes:
        index: sample of the path that was reached on the new branch.
        time: where the old branch ended, in the path's times.
        jump: (n,) change of the coordinates there [rad | m].
        conditioning: of the configuration before: near zero, the branch ended at a singular configuration.
        reason: `limit` or `singular`.
        joint: the joint that would have left its limits, or that jumps most.
        branches: the branch at the pose before, and the one at this pose; alike where only whole turns differ, and
            where the arm's branches have no names.
    """

    index: int
    time: float
    jump: JointVector
    conditioning: float
    reason: str
    joint: str
    branches: tuple[Branch, Branch]

    def explain(self, language: str | None = None) -> str:
        """The switch in a sentence or two."""
        details = {"index": self.index, "joint": self.joint, "jump": float(np.abs(self.jump).max()), "time": self.time}
        sentence = say(f"ik.switch_{self.reason}", language=language, **details, conditioning=self.conditioning)
        if self.branches[0] == self.branches[1]:
            return sentence
        before, after = (branch.label(language) for branch in self.branches)
        return sentence + say("ik.switch_branches", language=language, before=before, after=after)


@dataclass(frozen=True, eq=False)
class NearSingularity:
    """A nearly singular configuration on the way.

    Attributes:
        index: sample of the path.
        time: of it.
        conditioning: there.
        lost: (6,) unit body twist that the arm can hardly make there.
    """

    index: int
    time: float
    conditioning: float
    lost: Floats

    def explain(self, language: str | None = None) -> str:
        """The near-singularity in a sentence."""
        rotation, translation = (", ".join(f"{x:.3g}" for x in part) for part in (self.lost[:3], self.lost[3:]))
        details = {"index": self.index, "time": self.time, "conditioning": self.conditioning}
        return say(
            "ik.near_singularity",
            language=language,
            **details,
            rotation=f"({rotation})",
            translation=f"({translation})",
        )


@dataclass(frozen=True, eq=False, repr=False)
class Track(Answer, data="reached times q residual conditioning", entries="q"):
    """Joint path along a path of poses; true when it was followed to its end on one branch.

    Attributes:
        q: (k, n) coordinates; rows after the last pose that could be reached are NaN.
        times: (k,) of the poses.
        residual: (k,) larger of position and rotation error, as far as they count [m | rad].
        conditioning: (k,) smallest over largest singular value of the Jacobian, lengths in units of the reach.
        switches: where the branch was left.
        near_singularities: nearly singular configurations, one for each visit.
        reached: number of poses reached, from the first on.
        stopped_at: time at which the path had to be given up; NaN if it was not.
        refusal: what inverse kinematics says of the pose, or the position, that stopped it, or None.
        closed: whether the path ends at the pose where it began.
        drift: (n,) by how much the coordinates differ at the end of a closed path; NaN if it is open or not done.
    """

    q: JointVector
    times: Floats
    residual: Floats
    conditioning: Floats
    switches: tuple[BranchSwitch, ...]
    near_singularities: tuple[NearSingularity, ...]
    reached: int
    stopped_at: float
    refusal: SolutionSet | IKResult | None
    closed: bool
    drift: JointVector

    def to_dict(self) -> dict[str, Any]:
        """Plain data; arrays are those of the answer."""
        return Answer.to_dict(self) | {
            "switches": [place.index for place in self.switches],
            "near_singularities": [place.index for place in self.near_singularities],
        }

    @property
    def status(self) -> TrackStatus:
        """Followed on one branch, with switches, or not to the end."""
        if self.reached < len(self.q):
            return TrackStatus.STOPPED
        return TrackStatus.SWITCHED if self.switches else TrackStatus.FOLLOWED

    @property
    def continuous(self) -> bool:
        """Whether the whole path was followed on one branch."""
        return self.status is TrackStatus.FOLLOWED

    def explain(self, language: str | None = None) -> str:
        """How it went, every switch and near-singularity, and the drift of a closed path."""
        details = {"reached": self.reached, "count": len(self.q), "switches": len(self.switches)}
        reason = "" if self.refusal is None else self.refusal.explain(language=language).split("\n")[0]
        lines = [self.status.sentence(language, **details, time=self.stopped_at, reason=reason)]
        lines += [place.explain(language) for place in (*self.switches, *self.near_singularities)]
        if self.closed and self.reached == len(self.q):
            drift = float(np.abs(self.drift).max(initial=0.0))
            lines.append(
                say("ik.track_drift" if drift > FROM_THE_POSE else "ik.track_closed", language=language, drift=drift)
            )
        return "\n".join(lines)


def track(
    robot: RobotLike,
    T_path: ArrayLike,
    q0: ArrayLike,
    *,
    times: ArrayLike | None = None,
    task: TrackTask = "pose",
    tolerance: float = 1e-9,
    largest_step: float = 0.1,
) -> Track:
    """Joint coordinates along a path of poses, each from the one before.

    Between two poses the tip follows one screw motion; an arm of fewer than six joints that cannot, stays as near to it
    as it can. Steps that would change a coordinate by more than `largest_step` are halved, so that the arm cannot jump
    to another branch unseen; joints at their limits are locked if the others can do the motion. Where the branch ends,
    at a limit or a singular configuration, the nearest other solution of the next pose is taken, and the switch is
    named with its time, its reason and both branches.

    Args:
        robot: any arm; joints that do not move its tip stay where `q0` has them.
        T_path: (k, 4, 4) poses of the tip in {s}.
        q0: (n,) initial guess, near the first pose [rad | m].
        times: (k,) increasing; 0, 1, 2, ... if None.
        task: `pose`, or `position`: the orientation is left to the arm.
        tolerance: largest residual [m | rad].
        largest_step: largest change of a coordinate in one step [rad | m].

    Raises:
        InputError: wrong shapes, numbers that are not finite, a row that is no pose, times that do not increase,
            another task.
    """
    if task not in get_args(TrackTask):
        raise InputError("input.choice", name="task", value=task, known=", ".join(get_args(TrackTask)))
    robot = as_robot(robot)
    poses = as_batch("T_path", T_path, (4, 4), finite=True)
    if poses.ndim != 3:
        raise InputError("input.shape", name="T_path", expected="(k, 4, 4)", got=poses.shape, hint="")
    clean, rigid = clean_poses(poses)
    poses = clean if rigid.all() else printed_pose("T_path", poses)
    begin = single("q0", q0, (robot.n,))
    remark_on_degrees(robot, "q0", q0)
    clock = np.arange(len(poses), dtype=np.float64) if times is None else as_batch("times", times, (), finite=True)
    if clock.shape != (len(poses),):
        raise InputError("input.shape", name="times", expected=(len(poses),), got=clock.shape, hint="")
    if (np.diff(clock) <= 0.0).any():
        raise InputError("ik.times", name="times", index=int((np.diff(clock) <= 0.0).argmax()) + 1)
    sizes = positive("tolerance", tolerance), positive("largest_step", largest_step)
    return _Tracker(robot, poses, clock, *sizes, task).run(begin)


class _Tracker:
    """The state of a walk along a path."""

    def __init__(
        self, robot: Robot, poses: PoseMatrix, times: Floats, tolerance: float, largest: float, task: TrackTask
    ) -> None:
        self.robot, self.poses, self.times, self.tolerance, self.largest = robot, poses, times, tolerance, largest
        self.task: TrackTask = task
        self.rows = slice(0 if task == "pose" else 3, 6)
        self.q = np.full((len(poses), robot.n), np.nan)
        self.residual = np.full(len(poses), np.nan)
        self.switches: list[BranchSwitch] = []
        problem = problem_of(robot, None, True)
        # Joints that do not move the tip stay where they are: they are no columns of its Jacobian.
        self.moving = problem.part.columns
        self._scale = np.repeat([1.0, 1.0 / problem.length], 3)[self.rows, None]
        # Of how many freedoms the arm can move what counts: that of a plane never moves across it.
        anywhere = np.random.default_rng(0).uniform(-1.0, 1.0, (LOOK, robot.n))
        values = self._singular_values(anywhere)
        self.rank = int((values > SELF_MOTION * values[:, :1]).sum(axis=1).max(initial=1))

    def run(self, q0: JointVector) -> Track:
        """Walk as far as possible."""
        stopped_at, refusal = np.nan, None
        q = q0
        for k, T in enumerate(self.poses):
            done, q_end = (0.0, q) if k == 0 else self._walk(q, self.poses[k - 1], T)
            if k == 0 and (found := self._step(q, T)) is not None:
                done, q_end = 1.0, found
            if done < 1.0:
                new, others = self._elsewhere(T, q_end)
                time = float(self.times[max(k - 1, 0)] + done * (self.times[k] - self.times[max(k - 1, 0)]))
                if new is None:
                    stopped_at, refusal = time, others
                    break
                if k > 0:
                    self.switches.append(self._switch(k, time, q_end, new, others))
                q_end = new
            self.q[k], self.residual[k], q = q_end, self._residual(q_end, T), q_end
        return self._track(stopped_at, refusal)

    def _elsewhere(self, T: PoseMatrix, q: JointVector) -> tuple[JointVector | None, SolutionSet | IKResult]:
        """The nearest solution on any branch within the limits, if there is one; of positions, one that is found."""
        if self.task != "pose":
            found = solve_ik(self.robot, T, q, task=self.task, tolerance=self.tolerance)
            return (found.nearest if found.solved else None), found
        others = inverse_kinematics(self.robot, T, q0=q, tolerance=self.tolerance)
        assert isinstance(others, SolutionSet)
        return (others.nearest(q) if others and others.within.any() else None), others

    def _walk(self, q: JointVector, T_0: PoseMatrix, T_1: PoseMatrix) -> tuple[float, JointVector]:
        """How far of the screw motion between two poses the branch lasts, and the coordinates there."""
        at, step = 0.0, 1.0
        followable = self._can_follow(q, T_1)
        while at < 1.0:
            ahead = min(at + step, 1.0)
            T = T_1 if ahead == 1.0 else pose.interpolate_screw(T_0, T_1, ahead)
            found = self._step(q, T, exact=followable or ahead == 1.0)
            if found is None:
                step /= 2.0
                if step < FINEST:
                    return at, q
            else:
                at, q, step = ahead, found, 2.0 * step
        return 1.0, q

    def _can_follow(self, q: JointVector, T: PoseMatrix) -> bool:
        """Whether the arm can set out on the motion: with joints enough, or if its twist is among those it has."""
        if self.rank == self.rows.stop - self.rows.start:
            return True
        J, V = self._jacobian(q), self._error(q, T)
        return bool(
            np.linalg.norm(J @ (np.linalg.pinv(J, rcond=SELF_MOTION) @ V) - V) <= SELF_MOTION * np.linalg.norm(V)
        )

    def _step(self, q: JointVector, T: PoseMatrix, *, exact: bool = True) -> JointVector | None:
        """The solution that Newton's method finds from q, within the limits, if it is a step away."""
        found = solve_ik(self.robot, T, q, task=self.task, tolerance=self.tolerance, restarts=0)
        near = bool(found.solved or not exact) and bool(np.abs(found.nearest - q).max(initial=0.0) <= self.largest)
        return found.nearest if near else None

    def _residual(self, q: JointVector, T: PoseMatrix) -> float:
        e = self._error(q, T)
        return float(max(np.linalg.norm(e[:3]), np.linalg.norm(e[3:])))

    def _error(self, q: JointVector, T: PoseMatrix) -> Floats:
        """(6,) body twist to the pose, or (3,) way to its position in the axes of the tip."""
        at = self.robot.forward_kinematics(q)
        return pose.error(at, T) if self.task == "pose" else at[:3, :3].T @ (T[:3, 3] - at[:3, 3])

    def _jacobian(self, q: JointVector) -> Floats:
        """(*batch, 6 or 3, n) what moves the error."""
        return self.robot.jacobian_body(q)[..., self.rows, :]

    def _switch(
        self, k: int, time: float, q: JointVector, new: JointVector, others: SolutionSet | IKResult
    ) -> BranchSwitch:
        """Why the branch ended: a joint at its limit that has to go on, or a singular configuration."""
        limits = self.robot.limits
        ahead = np.linalg.pinv(self._jacobian(q), rcond=SELF_MOTION) @ self._error(q, self.poses[k])
        reach = q + np.sign(ahead) * 1e-2 * self.largest
        pushed = ((reach > limits.upper) | (reach < limits.lower)) & (np.abs(ahead) > PULLED)
        reason = "limit" if pushed.any() else "singular"
        joint = int(np.where(pushed, np.abs(ahead), 0.0).argmax()) if pushed.any() else int(np.abs(new - q).argmax())
        branches = Branch(), Branch()
        if isinstance(others, SolutionSet):
            before = inverse_kinematics(self.robot, self.poses[k - 1], q0=self.q[k - 1], tolerance=self.tolerance)
            assert isinstance(before, SolutionSet)
            branches = _branch(before, self.q[k - 1]), _branch(others, new)
        conditioning = float(self._conditioning(q[None])[0])
        return BranchSwitch(k, time, new - q, conditioning, reason, self.robot.joint_names[joint], branches)

    def _conditioning(self, q: JointVector) -> Floats:
        """(k,) smallest over largest singular value, without those that are zero everywhere."""
        values = self._singular_values(q)
        return values[:, self.rank - 1] / values[:, 0]

    def _singular_values(self, q: JointVector) -> Floats:
        """(k, m) singular values, largest first, of the Jacobian in the lengths of the arm."""
        values = np.linalg.svd((self._scale * self._jacobian(q))[..., self.moving], compute_uv=False)
        return np.asarray(values, dtype=np.float64)

    def _track(self, stopped_at: float, refusal: SolutionSet | IKResult | None) -> Track:
        reached = int(np.isfinite(self.residual).sum())
        conditioning = np.full(len(self.poses), np.nan)
        if reached:
            conditioning[:reached] = self._conditioning(self.q[:reached])
        counted = self.poses if self.task == "pose" else self.poses[:, :3, 3]
        closed = len(self.poses) > 1 and bool(np.abs(counted[0] - counted[-1]).max() <= REACHED)
        drift = np.full(self.robot.n, np.nan)
        if closed and reached == len(self.poses):
            drift = self.q[-1] - self.q[0]
        return Track(
            self.q,
            self.times,
            self.residual,
            conditioning,
            tuple(self.switches),
            self._near_singularities(conditioning, reached),
            reached,
            stopped_at,
            refusal,
            closed,
            drift,
        )

    def _near_singularities(self, conditioning: Floats, reached: int) -> tuple[NearSingularity, ...]:
        """The worst sample of every visit to nearly singular configurations."""
        inside = np.flatnonzero(conditioning[:reached] < NEARLY_SINGULAR)
        visits = np.split(inside, np.flatnonzero(np.diff(inside) > 1) + 1) if len(inside) else []
        found: list[NearSingularity] = []
        for visit in visits:
            k = int(visit[conditioning[visit].argmin()])
            U, _, _ = np.linalg.svd(self._scale * self._jacobian(self.q[k]))
            lost = np.zeros(6)
            lost[self.rows] = U[:, self.rank - 1]
            lost = lost * np.sign(lost[np.abs(lost).argmax()])
            found.append(NearSingularity(k, float(self.times[k]), float(conditioning[k]), lost))
        return tuple(found)


def _branch(answer: SolutionSet, q: JointVector) -> Branch:
    """The branch of the solution that a configuration is, up to whole turns."""
    if not len(answer):
        return Branch()
    wound = wound_near(answer.q, q, np.full(len(q), -np.inf), np.full(len(q), np.inf), answer.revolute)
    return answer.branches[int(np.linalg.norm(wound - q, axis=1).argmin())]
