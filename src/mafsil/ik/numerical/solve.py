"""Numerical inverse kinematics for whole batches: damped least squares in the body frame, bounded, with restarts."""

from __future__ import annotations

from contextlib import suppress
from time import perf_counter
from typing import TYPE_CHECKING, Any, TypeGuard, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix, as_batch, positive, require_finite, require_kind, whole
from mafsil.errors import InputError, MafsilWarning, ModelError, warn
from mafsil.ik.chain import MovingPart
from mafsil.ik.numerical.fast_search import SOLVED, FastSearch, Report, hashable, search_of
from mafsil.ik.numerical.full_search import FullSearch, preferred_configuration
from mafsil.ik.numerical.problem import TaskKind, WeightAxes
from mafsil.ik.numerical.records import WINNER
from mafsil.ik.result import CODES, IKResult, IKStatus, printed_pose
from mafsil.lazy_module import lazily
from mafsil.model.loading import RobotLike
from mafsil.robot import as_robot
from mafsil.robot.degrees import radians_per_unit, remark_on_degrees, takes_degrees

if TYPE_CHECKING:
    import mafsil.geometry.membership as membership
else:
    membership = lazily("mafsil.geometry.membership")

AXIS = (0.0, 0.0, 1.0)
"""The axis of a frame that counts unless another is named."""

MOST_KNOWN = 64
"""Robots and tasks whose searches are found again by what the user gave."""

MOST_RESTARTS = 2**31 - 1
"""As for all whole numbers of a user."""

_known: dict[tuple[Any, ...], FastSearch] = {}
_NOT_A_POSE = CODES[IKStatus.NOT_A_POSE]
_POSE, _DOUBLE = (4, 4), np.dtype(np.float64)


class RenamedArgument(MafsilWarning, DeprecationWarning):
    """An argument is given under the name that it had before."""


@takes_degrees("q0", "q_preferred")
def solve_ik(
    robot: RobotLike,
    T_sd: ArrayLike,
    q0: ArrayLike | None = None,
    *,
    frame: str | None = None,
    task: TaskKind = "pose",
    axis: ArrayLike = AXIS,
    weights: ArrayLike | None = None,
    expressed_in: WeightAxes = "body",
    tolerance: float = 1e-10,
    rotation_tolerance: float | None = None,
    q_preferred: ArrayLike | None = None,
    preferred_weights: ArrayLike | None = None,
    restarts: int = 255,
    seconds: float | None = None,
    limits: bool = True,
    seed: int = 0,
    degrees: bool = False,
) -> IKResult:
    """Joint vectors that bring a frame to desired poses.

    dq = J' (J J' + lambda I)^-1 e,  e = (log(R_sf' R_sd), R_sf' (p_sd - p_sf)),  lambda ~ |e|^2

    1. A question of a robot and task that were asked before goes straight to its compiled search.
    2. Else arguments are checked, and the search is made and remembered.
    3. One pose alone: compiled search without batches.
    4. A batch: the fast search, and the full one for what it leaves open; with a preferred configuration or a time
       limit the full one alone.

    Joints at a bound that the step would push further are held. Poses that resist are tried again from sampled starts,
    the nearest first; a whole pose that eight and more attempts miss is looked up in the arm's closed form, where it
    has one, before it counts as not found. Every answer is checked afresh by forward kinematics. The result for a pose
    does not depend on the other poses of the batch. Batches of any size are worked on in blocks, on all cores.

    Args:
        robot: whose tip or `frame` is to be moved: a Robot, a Mechanism, a name of the library or a file. Joints that
            do not move the frame, such as those of a gripper, are no unknowns.
        T_sd: (*batch, 4, 4) desired poses in {s}; rotations printed to six digits or more are repaired.
        q0: (*batch, n) initial guess [rad | m], and where joints that do not move the frame stay (else at
            `q_preferred`, else in the middle of their limits); sampled starts if None.
        frame: name of a link; the tip if None.
        task: what of the pose counts: `pose`; `position`; `orientation`; `axis`: position, and direction of one axis;
            `direction` of one axis alone.
        axis: (3,) that axis in the frame.
        weights: (6,) of rotations about and positions along axes; zero sets one free. They balance the errors where
            not all can vanish; the nearest pose is a local one: with uneven weights along axes of {s} its error may
            be a fifth above the least, and a start `q0` or more `restarts` may find a nearer one. Ones if None.
        expressed_in: whose axes those of the weights are: `body`: the frame's own; `aligned`: those of {s}, so that
            `(1, 1, 1, 1, 1, 0)` leaves the height free.
        tolerance: largest position error [m], and rotation error [rad] where that has none of its own.
        rotation_tolerance: largest rotation error [rad].
        q_preferred: (*batch, n) preferred configuration [rad | m], such as the middle of the limits, approached as far
            as the task leaves joints free: sought in the self-motion of the first solution found.
        preferred_weights: (n,) how much each joint's distance counts; ones if None.
        restarts: how many more starts are tried after the first.
        seconds: time after which poses still open are left; no limit if None.
        limits: whether the joints' position limits hold.
        seed: random seed of the sampled starts; equal seeds give equal results. An array is taken as `q0`, with a
            warning: so it was called.
        degrees: the angles in q0 and q_preferred, and in the answer's q, are in degrees.

    Returns:
        Solutions with a status for each pose. Rows of a batch that are no poses are marked and hold NaN.

    Raises:
        InputError: a wrong shape, an unknown frame or task, numbers that are not finite, a single pose that is none.

    Reference: Chan and Lawrence, General inverse kinematics with the error damped pseudoinverse, ICRA 1988.
    """
    if degrees:
        answer = solve_ik(
            robot, T_sd, q0, frame=frame, task=task, axis=axis, weights=weights, expressed_in=expressed_in,
            tolerance=tolerance, rotation_tolerance=rotation_tolerance, q_preferred=q_preferred,
            preferred_weights=preferred_weights, restarts=restarts, seconds=seconds, limits=limits, seed=seed,
        )  # fmt: skip
        return answer.with_joints(answer.nearest / radians_per_unit(as_robot(robot).mechanism))
    # 1.
    if q0 is None and (guess := _array_seed(seed)) is not None:
        q0, seed = guess, 0
    single = q_preferred is None and seconds is None and type(restarts) is int
    if single and type(tolerance) is float and type(seed) is int and _plain(T_sd, _POSE):
        named = (robot, frame, limits, seed, task, axis, weights, tolerance, rotation_tolerance, expressed_in)
        found = _again(named, T_sd, q0, restarts)
        if found is not None:
            return found
    # 2.
    begun = perf_counter()
    robot = as_robot(robot)
    if not robot.n:
        raise ModelError("robot.no_joints", robot=robot.name)
    desired = membership.snap_to_kind("pose", "T_sd", as_batch("T_sd", T_sd, (4, 4)))
    if frame is not None:
        require_kind("frame", frame, "str", "casefold")
    whole("restarts", restarts)
    deadline = np.inf if seconds is None else begun + positive("seconds", seconds)
    turn = None if rotation_tolerance is None else positive("rotation_tolerance", rotation_tolerance)
    direction = axis if axis is AXIS else hashable("axis", axis)
    factors = None if weights is None else hashable("weights", weights)
    exact = positive("tolerance", tolerance), turn
    search = search_of(
        robot, frame, bool(limits), whole("seed", seed), str(task), direction, factors, *exact, str(expressed_in)
    )
    _remember((robot, frame, limits, seed, task, axis, weights, tolerance, rotation_tolerance, expressed_in), search)
    plan, part, batch = search.plan, search.part, desired.shape[:-2]
    first = None if q0 is None else _rows("q0", q0, robot.n, batch)
    remark_on_degrees(robot, "q0", q0)
    # 3.
    if not batch and q_preferred is None and seconds is None:
        found = _single(search, desired, None if first is None else first[0], restarts)
        if found is not None:
            return found
    # 4.
    preferred = _rows("q_preferred", q_preferred, robot.n, batch)
    scales = (
        None if preferred_weights is None else part.own(as_batch("preferred_weights", preferred_weights, (robot.n,)))
    )
    start = np.empty((0, plan.problem.robot.n)) if first is None else part.own(first)
    goal = preferred_configuration(plan.problem, part.own(preferred), scales)
    rows = np.ascontiguousarray(desired).reshape(-1, 16)
    if goal is None and seconds is None:
        report = _report(search, rows, start, restarts)
    else:
        full = FullSearch(plan, rows, start, goal, restarts, deadline)
        full.run()
        report = Report(full.report, full.attempts, plan, full.codes, full.worst)
    if not batch and report.codes is not None and report.codes[0] == _NOT_A_POSE:
        printed_pose("T_sd", desired)
    result = IKResult(report.reshape(batch).field)
    return result if part.places is None else _lifted(result, part, first, preferred)


def _array_seed(seed: object) -> ArrayLike | None:
    """The initial guess where an array is given as `seed`, as it was once called.

    Warns:
        RenamedArgument: it is one.
    """
    if type(seed) is int or not isinstance(seed, list | tuple | np.ndarray):
        return None
    given: NDArray[Any] = np.asarray(cast("ArrayLike", seed))
    if not given.ndim:
        return None
    warn(RenamedArgument("ik.array_seed"))
    return given


def _report(search: FastSearch, desired: Floats, q0: JointVector, restarts: int) -> Report:
    """All poses by the fast search, and those that it leaves open by the full one."""
    numbers, attempts = search.rows(desired, q0, restarts)
    rest = np.flatnonzero(attempts[:, WINNER] < 0)
    if not len(rest):
        return Report(numbers, attempts, search.plan)
    some = np.ascontiguousarray(q0[rest] if len(q0) else q0)
    full = FullSearch(search.plan, desired[rest], some, None, restarts, np.inf)
    full.run()
    codes = np.full(len(desired), SOLVED, np.int8)
    numbers[rest], attempts[rest], codes[rest] = full.report, full.attempts, full.codes
    return Report(numbers, attempts, search.plan, codes, {int(rest[row]): name for row, name in full.worst.items()})


def _again(named: tuple[Any, ...], T_sd: PoseMatrix, q0: ArrayLike | None, restarts: int) -> IKResult | None:
    """The answer for one more pose of a robot and task that were asked for before; None for the general way."""
    try:
        search = _known[named]
    except (KeyError, TypeError):  # Not asked for yet; or given as arrays, which have no hash.
        return None
    if not 0 <= restarts <= MOST_RESTARTS:
        return None
    if q0 is None:
        return _single(search, T_sd, None, restarts)
    if not _plain(q0, (search.part.whole.n,)) or not np.isfinite(q0).all():
        return None
    return _single(search, T_sd, q0, restarts)


def _plain(given: ArrayLike, shape: tuple[int, ...]) -> TypeGuard[Floats]:
    """Whether it is a NumPy array of float64 and of this shape, not of a class that behaves otherwise."""
    return type(given) is np.ndarray and given.shape == shape and given.dtype == _DOUBLE


def _single(search: FastSearch, T_sd: PoseMatrix, q0: JointVector | None, restarts: int) -> IKResult | None:
    part = search.part
    found = search.single(T_sd, q0 if q0 is None or part.places is None else part.own(q0), restarts)
    return found if found is None or part.places is None else _lifted(found, part, q0, None)


def _remember(named: tuple[Any, ...], search: FastSearch) -> None:
    """Find the search by what the user gave; what was given as arrays is not remembered."""
    with suppress(TypeError):
        _known[named] = search
        while len(_known) > MOST_KNOWN:
            _known.pop(next(iter(_known)), None)


def _lifted(result: IKResult, part: MovingPart, first: JointVector | None, goal: JointVector | None) -> IKResult:
    """The answer in coordinates of the whole robot; its other joints at q0, at q_preferred, or in the middle."""
    chosen = [rows for rows in (first, goal) if rows is not None and len(rows)]
    others = chosen[0].reshape(*result.nearest.shape[:-1], part.whole.n) if chosen else part.middle
    return result.with_joints(part.lift(result.nearest, others))


def _rows(name: str, given: ArrayLike | None, n: int, batch: tuple[int, ...]) -> JointVector:
    """(k, n) the user's rows, or (0, n) if there are none."""
    if given is None:
        return np.empty((0, n))
    rows = require_finite(name, as_batch(name, given, (n,)))
    try:
        return np.require(np.broadcast_to(rows, (*batch, n)), requirements=("C", "W")).reshape(-1, n)
    except ValueError:
        raise InputError("input.shape", name=name, expected=(*batch, n), got=rows.shape, hint="") from None
