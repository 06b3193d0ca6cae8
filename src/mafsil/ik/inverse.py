"""Inverse kinematics in one call: all solutions, the nearest one, or those that continue branches of the ideal arm.

A measured arm is off the shape that gave it a closed form by millimetres. Its solutions are those of the ideal arm
moved a little, except near folds, where two branches meet: there a pair may vanish or appear.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer
from mafsil.arrays import LARGEST, SMALLEST, Floats, JointVector, PoseMatrix, as_batch, positive, single
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.ik.answers.candidate_table import CandidateTable
from mafsil.ik.answers.one_pose import POSE, OffsetPoses, clear_set, judged_pose, offset_poses, one_pose, pose_near
from mafsil.ik.answers.question import Question
from mafsil.ik.answers.setting import MASKS, Quick, require_task, setting
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.redundant.parametric_form import has_redundant_joints
from mafsil.ik.refine import distinct, refine_rows
from mafsil.ik.result import IKResult, IKStatus
from mafsil.ik.structure.analysis import Task, analysis
from mafsil.ik.tolerances import IDEAL_QUARTIC_REACHED, IDEAL_REACHED, NEARLY_REACHED, SHORTEST
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.model.loading import RobotLike
from mafsil.robot import Robot, as_robot
from mafsil.robot.degrees import DegreesView, remark_on_degrees, takes_degrees

if TYPE_CHECKING:
    import mafsil.geometry.membership as membership
    import mafsil.ik.answers.many_poses as many_poses
    import mafsil.ik.answers.redundant_batch as redundant_single
    import mafsil.ik.numerical.solve as numerical
    import mafsil.ik.redundant.at_parameter as at_parameter
    from mafsil.ik.answers.batch import SolutionBatch
else:
    membership = lazily("mafsil.geometry.membership")
    at_parameter = lazily("mafsil.ik.redundant.at_parameter")
    redundant_single = lazily("mafsil.ik.answers.redundant_batch")
    many_poses = lazily("mafsil.ik.answers.many_poses")
    numerical = lazily("mafsil.ik.numerical.solve")


_POSE: Task = "pose"
_KEPT, _UNKNOWN = "closed form of the tip", object()
"""Where a robot keeps the compiled closed form of its tip: no name that an attribute could have."""


@takes_degrees("q0")
def inverse_kinematics(
    robot: RobotLike,
    T_sd: ArrayLike,
    *,
    frame: str | None = None,
    task: Task = _POSE,
    q0: ArrayLike | None = None,
    free: float | Mapping[str, float] | None = None,
    tolerance: float = 1e-9,
    degrees: bool = False,
) -> SolutionSet | SolutionBatch:
    """All joint vectors that bring the tip to a pose, or to each pose of a batch.

    Joints that do not move the frame, such as those of a gripper, are no unknowns.

    Args:
        robot: any arm, a Mechanism, a name of the library or a file.
        T_sd: (4, 4) requested pose in {s}, or (*batch, 4, 4).
        frame: name of a link; the tip if None.
        task: `pose`, `position` only, or `axis`: position and direction of the tip's z axis.
        q0: (n,) values that free joints, locked joints of redundant arms and joints that do not move the frame take;
            the middle of their limits if None.
        free: of arms with seven coordinates and one pose: value of their free parameter, or {name: value} of the
            `arm angle` or of a joint; see `redundancy`.
        tolerance: largest residual [m | rad] of a solution. Arms with fewer joints than the task has equations meet a
            rounded pose in the sense of least squares; other arms the nearest configuration where there is no exact
            one.
        degrees: the angles in q0 and in the answer's solutions, sentences and tables are in degrees.

    Returns:
        For one pose a `SolutionSet`: solutions with branches, families and reasons; where `complete` is set there are
        no others. A redundant arm (more joints than the task needs) gets the solutions with the locked joints at `q0`,
        each the member of a family. For a batch a `SolutionBatch`: padded arrays, and a `SolutionSet` by index.

    Raises:
        InputError: a wrong shape, no pose, an unknown task, a tolerance that is not positive.
        ModelError: an unknown frame.
    """
    if type(T_sd) is np.ndarray and T_sd.shape == POSE and type(robot) is Robot and not degrees and _ready(robot, q0):
        plain = type(tolerance) is float and SMALLEST <= tolerance <= LARGEST and T_sd.dtype == np.float64
        # One pose as programs give it: the compiled closed form decides, and most often its rows are the answer.
        quick = _quick(robot, frame, task) if free is None else None
        if quick is not None and plain:
            if type(quick) is OffsetPoses:
                known = quick.proven(T_sd, cast("JointVector | None", q0), tolerance)
                return _answer(robot, T_sd, frame, task, q0, free, tolerance) if known is None else known
            if q0 is not None:
                return pose_near(quick, T_sd, cast("JointVector", q0), tolerance)
            q, details, decision = quick.call(T_sd, *quick.preferences, tolerance)
            if decision > 0.0:
                chosen = quick.rows(decision)
                return clear_set(quick.setting, q[chosen], details, chosen)
            question = Question(quick.setting, T_sd.copy(), quick.setting.middle, tolerance)
            return judged_pose(question, (q, details, decision))
        if plain and q0 is None and type(task) is str and task in MASKS:
            arm = setting(robot, frame, task)
            if free is not None:
                return at_parameter.with_parameter(arm, T_sd, free, tolerance)
            if has_redundant_joints(arm):
                return redundant_single.redundant_single(arm, T_sd, arm.middle, tolerance)
    answer = _answer(as_robot(robot), T_sd, frame, task, q0, free, tolerance)
    return cast("SolutionSet", DegreesView(answer, as_robot(robot))) if degrees else answer


def _ready(robot: Robot, q0: ArrayLike | None) -> bool:
    """Whether preferred values are as programs give them: nothing has to be converted, and all are finite."""
    if q0 is None:
        return True
    # A NaN is not less than anything.
    return type(q0) is np.ndarray and q0.dtype == np.float64 and q0.shape == (robot.n,) and q0.dot(q0) < LARGEST


def _answer(
    robot: Robot,
    T_sd: ArrayLike,
    frame: str | None,
    task: Task,
    q0: ArrayLike | None,
    free: float | Mapping[str, float] | None,
    tolerance: float,
) -> SolutionSet | SolutionBatch:
    """The answer to whatever is arm for, all arguments checked."""
    require_task(task)
    tolerance = positive("tolerance", tolerance)
    requested = as_batch("T_sd", T_sd, POSE)
    arm = setting(robot, frame, task)
    others = arm.part.middle if q0 is None else single("q0", q0, (robot.n,))
    remark_on_degrees(robot, "q0", q0)
    if requested.ndim > 2:
        if free is not None:
            raise InputError("redundant.one_pose", shape=requested.shape)
        return many_poses.solved_batch(arm, membership.snap_to_kind("pose", "T_sd", requested), others, tolerance)
    if free is None:
        start = arm.middle if q0 is None else arm.part.own(others)
        return one_pose(arm, requested, start, tolerance, others)
    return at_parameter.with_parameter(arm, requested, free, tolerance)


def _quick(robot: Robot, frame: str | None, task: Task) -> Quick | OffsetPoses | None:
    """The compiled way of a robot's tip or of a frame; None where there is none, or no such task."""
    if frame is None and task is _POSE:
        known = vars(robot).get(_KEPT, _UNKNOWN)
        if known is _UNKNOWN:
            arm = setting(robot, None, _POSE)
            vars(robot)[_KEPT] = known = arm.quick or offset_poses(arm)
        return known
    return setting(robot, frame, task).quick if type(task) is str and task in MASKS else None


def nearest_solution(
    robot: RobotLike,
    T_sd: ArrayLike,
    q0: ArrayLike | None = None,
    *,
    frame: str | None = None,
    task: Task = "pose",
) -> IKResult:
    """The solution nearest to `q0` for each pose, checked by forward kinematics.

    1. Of an arm without redundant joints all solutions are found; the start is the nearest within the limits, wound.
    2. Of a redundant arm the start is `q0`, which is also the preferred configuration of its self-motion.
    3. Damped least squares confirm the start, or go on from it.

    Args:
        robot: a Robot, a Mechanism, a name of the library or a file.
        T_sd: (*batch, 4, 4) desired poses in {s}.
        q0: (n,) or (*batch, n) configuration [rad | m]; the middle of the limits if None.
        frame: name of a link; the tip if None.
        task: `pose`, `position` or `axis`.

    Raises:
        InputError: a wrong shape, no pose, an unknown task.
        ModelError: an unknown frame, a robot with loops.
    """
    arm = as_robot(robot)
    require_task(task)
    known = setting(arm, frame, task)
    if known.arm.locked:
        return numerical.solve_ik(arm, T_sd, q0, frame=frame, task=task, q_preferred=q0)
    start = known.part.middle if q0 is None else as_batch("q0", q0, (arm.n,), finite=True)
    return numerical.solve_ik(arm, T_sd, _nearest_of_all(arm, T_sd, start, frame, task), frame=frame, task=task)


def _nearest_of_all(arm: Robot, T_sd: ArrayLike, q0: JointVector, frame: str | None, task: Task) -> JointVector:
    """(*batch, n) the nearest of all solutions, free joints at `q0`; `q0` itself where there is none."""
    answer = inverse_kinematics(arm, T_sd, frame=frame, task=task)
    if isinstance(answer, SolutionSet):
        if answer.free.any():
            answer = cast("SolutionSet", inverse_kinematics(arm, T_sd, frame=frame, task=task, q0=q0))
        return answer.nearest(q0) if len(answer) else q0
    nearest = answer.nearest(q0)
    nearest = np.where(np.isnan(nearest), q0, nearest)
    poses, starts = np.asarray(T_sd, dtype=np.float64), np.broadcast_to(q0, nearest.shape)
    for row in map(tuple, np.argwhere((answer.free != 0).any(axis=-1)).tolist()):
        nearest[row] = _nearest_of_all(arm, poses[row], starts[row], frame, task)
    return nearest


LEAP = 0.3
"""Joint motion of one step beyond which another branch may have been caught [rad | m]."""


@dataclass(frozen=True, eq=False, repr=False)
class Continuation(Answer, entries="answer"):
    """Solutions of an arm by the branches of the nearest ideal arm; true if one is within the limits.

    Attributes:
        answer: solutions of the arm itself; `complete` where elimination proves that there are no others.
        ideal: (b, n) branches of the ideal arm; NaN where it does not reach the pose on that branch.
        solution: (b,) index of the solution that continues a branch; -1 if lost, or not there from the start.
        moved: (b,) largest joint motion from the ideal branch to the solution; NaN without one [rad | m].
        lost: branches of the ideal arm that end before the measured arm: they met another at a fold.
        gained: solutions that continue no branch of the ideal arm.
        defect: how far the arm is from the ideal one [rad, and m relative to its size].
    """

    answer: SolutionSet
    ideal: JointVector
    solution: NDArray[np.int64]
    moved: Floats
    lost: tuple[int, ...]
    gained: tuple[int, ...]
    defect: float

    @property
    def status(self) -> IKStatus:
        """What can be said about the arm's own solutions."""
        return self.answer.status

    def __bool__(self) -> bool:
        return bool(self.answer)

    def to_dict(self) -> dict[str, Any]:
        """Plain data; arrays are those of the answer."""
        kept = {"ideal": self.ideal, "solution": self.solution, "moved": self.moved}
        return {**self.answer.to_dict(), **kept, "lost": self.lost, "gained": self.gained, "defect": self.defect}

    def explain(self, language: str | None = None) -> str:
        """In sentences: how many branches go on, which are lost or gained, and the answer's own words."""
        kept = int((self.solution >= 0).sum())
        lines = [say("calibrated.kept", language=language, kept=kept, defect=self.defect)]
        if self.lost:
            lines.append(say("calibrated.lost", language=language, branches=_list(self.lost)))
        if self.gained:
            lines.append(say("calibrated.gained", language=language, solutions=_list(self.gained)))
        return "\n".join([*lines, self.answer.explain(language)])


def continued_branches(robot: RobotLike, T_sd: ArrayLike) -> Continuation:
    """The solutions of one pose, each with the branch of the nearest ideal arm that it continues.

    Args:
        robot: of up to six joints that move its tip, of a shape that has a closed form or nearly so. The answer has
            these joints only.
        T_sd: (4, 4) requested pose in {s}.

    Raises:
        InputError: no such arm, a wrong shape, or no pose.
    """
    shared = setting(as_robot(robot), None, "pose")
    robot = shared.robot
    answer, arm = inverse_kinematics(robot, T_sd), analysis(robot.mechanism)
    if arm.form is None or arm.locked:
        raise InputError("calibrated.no_ideal", joints=robot.n)
    if not isinstance(answer, SolutionSet):
        raise InputError("input.shape", name="T_sd", expected="(4, 4)", got=np.shape(T_sd), hint="")
    T = np.asarray(T_sd, dtype=np.float64)
    q, details, _ = arm.form.labelled(T, shared.middle, shared.middle_turns, *shared.bounds)
    reached = IDEAL_QUARTIC_REACHED if shared.quartic else IDEAL_REACHED
    exists = np.isfinite(q).all(axis=-1) & (CandidateTable.of(details).subproblem_residual <= reached)
    ideal = np.where(exists[:, None], q, np.nan)
    rows = np.flatnonzero(exists)
    rows = rows[distinct(ideal[rows], shared.revolute)]
    solution, moved = np.full(len(ideal), -1), np.full(len(ideal), np.nan)
    ends = [_continue(robot, ideal[row], T) for row in rows]
    order = np.argsort([way for _, way in ends])
    for i in map(int, order):
        if not len(answer) or not np.isfinite(ends[i][0]).all():
            continue
        away = _apart(answer.q, ends[i][0], shared.revolute)
        best = int(away.argmin())
        if away[best] < NEARLY_REACHED and best not in solution:
            solution[rows[i]] = best
            moved[rows[i]] = _apart(answer.q[best], ideal[rows[i]], shared.revolute)
    lost = tuple(int(row) for row in rows if solution[row] < 0)
    gained = tuple(k for k in range(len(answer)) if k not in solution)
    return Continuation(answer, ideal, solution, moved, lost, gained, float(arm.form.pattern.defect))


def _continue(robot: Robot, q: JointVector, T: PoseMatrix) -> tuple[JointVector, float]:
    """Where the measured configuration q goes while its pose moves to T, and by how much; NaN where it ends on the way.

    The pose moves along a screw, by steps that Newton's method can follow.
    """
    start = robot.forward_kinematics(q)
    V, s, step = pose.error(start, T), 0.0, 0.25
    everything, here = np.ones(6, dtype=np.bool_), q
    while s < 1.0:
        goal = start @ pose.exp(V * min(1.0, s + step))
        trial, residual = refine_rows(robot, here[None], goal, everything)
        if residual[0] <= IDEAL_REACHED and np.abs(trial[0] - here).max() <= LEAP:
            here, s, step = trial[0], min(1.0, s + step), 2 * step
        elif step > SHORTEST:
            step /= 4
        else:
            return np.full(len(q), np.nan), np.inf
    return here, float(np.abs(here - q).max())


def _apart(q: JointVector, other: JointVector, revolute: NDArray[np.bool_]) -> Floats:
    d = q - other
    return np.abs(np.where(revolute, (d + np.pi) % (2 * np.pi) - np.pi, d)).max(axis=-1)


def _list(numbers: tuple[int, ...]) -> str:
    return ", ".join(str(k + 1) for k in numbers)
