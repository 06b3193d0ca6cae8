"""Numerical inverse kinematics for whole batches: damped least squares in the body frame, bounded, with restarts."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil import threads
from mafsil.arrays import (
    Floats,
    JointVector,
    PoseMatrix,
    gate,
    positive,
    real_array,
    require_finite,
    require_kind,
    whole,
)
from mafsil.errors import InputError, ModelError
from mafsil.ik.moving_part import MovingPart
from mafsil.ik.numerical.posture import Wish, settled, wish_of
from mafsil.ik.numerical.problem import problem_of
from mafsil.ik.numerical.search import Plan, cached_plan
from mafsil.ik.numerical.task import PoseTask, TaskKind, pose_task
from mafsil.ik.problem import ORTHOGONALITY
from mafsil.ik.result import STATUSES, IKResult, IKStatus
from mafsil.model.loading import RobotLike
from mafsil.robot import as_robot

FREE_RESTARTS = 7
"""Restarts for poses proven out of reach, and for asking whether the limits are what forbids a pose."""

QUICK_ATTEMPTS = 32
"""Attempts of the shortest way for a single pose; what resists them is begun again by the way that can be stopped."""

BLOCK = 4096
"""Poses that a thread takes at once; what it needs besides input and answer is proportional to them."""

AXIS = (0.0, 0.0, 1.0)
"""The axis of a frame that counts unless another is named."""

_CODE = {status: code for code, status in enumerate(STATUSES)}
_SOLVED = np.array(_CODE[IKStatus.SOLVED], np.int8)
_SOLVED.setflags(write=False)
_NOBODY = np.array("", dtype="U1")
_NOBODY.setflags(write=False)


def solve_ik(
    robot: RobotLike,
    T_sd: ArrayLike,
    seed: ArrayLike | None = None,
    *,
    frame: str | None = None,
    task: TaskKind = "pose",
    axis: ArrayLike = AXIS,
    weights: ArrayLike | None = None,
    tolerance: float = 1e-10,
    rotation_tolerance: float | None = None,
    posture: ArrayLike | None = None,
    posture_weights: ArrayLike | None = None,
    restarts: int = 255,
    seconds: float | None = None,
    limits: bool = True,
    rng: int = 0,
) -> IKResult:
    """Joint vectors that bring a frame to wanted poses.

    dq = J' (J J' + lambda I)^-1 e,  e = (log(R_sf' R_sd), R_sf' (p_sd - p_sf)),  lambda ~ |e|^2

    Joints at a bound that the step would push further are held. Poses that resist are tried again from sampled starts,
    the nearest first. Every answer is checked afresh by forward kinematics. The result for a pose does not depend on
    the other poses of the batch. Batches of any size are worked on in blocks, on all cores.

    Args:
        robot: whose tip or `frame` is to be moved: a Robot, a Mechanism, a name of the library or a file. Joints that
            do not move the frame, such as those of a gripper, are no unknowns.
        T_sd: (*batch, 4, 4) wanted poses in {s}; rotations printed to six digits or more are repaired.
        seed: (*batch, n) where to start first [rad | m], and where joints that do not move the frame stay (else at the
            posture, else in the middle of their limits); sampled starts if None.
        frame: name of a link; the tip if None.
        task: what of the pose counts: `pose`; `position`; `orientation`; `axis`: position, and direction of one axis;
            `direction` of one axis alone.
        axis: (3,) that axis in the frame.
        weights: (6,) of rotations about and positions along the frame's own axes; zero sets one free. They balance the
            errors where not all can vanish. Ones if None.
        tolerance: largest position error [m], and rotation error [rad] where that has none of its own.
        rotation_tolerance: largest rotation error [rad].
        posture: (*batch, n) what joints should be near to as far as the task leaves them free, such as
            `robot.limits.middle`; sought in the self-motion of the first solution found.
        posture_weights: (n,) how much each joint's distance counts; ones if None.
        restarts: how many more starts are tried after the first.
        seconds: time after which poses still open are left; no limit if None.
        limits: whether the joints' position limits hold.
        rng: seed of the sampled starts; equal seeds give equal results.

    Returns:
        Solutions with a status for each pose. Rows of a batch that are no poses are marked and hold NaN.

    Raises:
        InputError: a wrong shape, an unknown frame or task, numbers that are not finite, a single pose that is none.

    Reference: Chan and Lawrence, General inverse kinematics with the error damped pseudoinverse, ICRA 1988.
    """
    begun = perf_counter()
    robot = as_robot(robot)
    if not robot.n:
        raise ModelError("robot.no_joints", robot=robot.name)
    wanted = gate("T_sd", T_sd, (4, 4))
    if frame is not None:
        require_kind("frame", frame, "str", "casefold")
    whole("restarts", restarts)
    deadline = np.inf if seconds is None else begun + positive("seconds", seconds)
    turn = None if rotation_tolerance is None else positive("rotation_tolerance", rotation_tolerance)
    exact = positive("tolerance", tolerance), turn
    asked = _task(
        str(task), _hashable("axis", axis), None if weights is None else _hashable("weights", weights), *exact
    )
    plan = cached_plan(problem_of(robot, frame, bool(limits)), asked, whole("rng", rng))
    batch, part = wanted.shape[:-2], plan.problem.part
    first = None if seed is None else _rows("seed", seed, robot.n, batch)
    if not batch and posture is None and seconds is None:
        quick = _quick(plan, wanted, None if first is None else part.own(first), restarts)
        if quick is not None:
            return quick if part.places is None else _lifted(quick, part, first, None)
    goal = _rows("posture", posture, robot.n, batch)
    weights_left = None if posture_weights is None else part.own(gate("posture_weights", posture_weights, (robot.n,)))
    start = np.empty((0, plan.problem.robot.n)) if first is None else part.own(first)
    work = _Work(plan, wanted, start, wish_of(plan.problem, part.own(goal), weights_left), restarts, deadline)
    blocks = -(-work.count // BLOCK)
    threads.run(work.block, blocks, threads.available() if blocks > 1 else 1)
    if not batch and not work.valid[0]:
        raise InputError("ik.no_pose", name="T_sd", limit=ORTHOGONALITY)
    result = work.result(batch)
    return result if part.places is None else _lifted(result, part, first, goal)


def _lifted(result: IKResult, part: MovingPart, first: JointVector | None, goal: JointVector | None) -> IKResult:
    """The answer in coordinates of the whole robot; the other joints at the start, the posture or the middle."""
    chosen = [rows for rows in (first, goal) if rows is not None and len(rows)]
    others = chosen[0].reshape(*result.nearest.shape[:-1], part.whole.n) if chosen else part.middle
    return replace(result, nearest=part.lifted(result.nearest, others))


def _hashable(name: str, values: ArrayLike) -> tuple[float, ...]:
    return AXIS if values is AXIS else tuple(real_array(name, values).ravel().tolist())


@lru_cache(maxsize=64)
def _task(
    kind: str,
    axis: tuple[float, ...],
    weights: tuple[float, ...] | None,
    tolerance: float,
    rotation_tolerance: float | None,
) -> PoseTask:
    return pose_task(kind, axis, weights, tolerance, rotation_tolerance)


def _rows(name: str, given: ArrayLike | None, n: int, batch: tuple[int, ...]) -> JointVector:
    """(k, n) the user's rows, or (0, n) if there are none."""
    if given is None:
        return np.empty((0, n))
    rows = require_finite(name, gate(name, given, (n,)))
    try:
        return np.require(np.broadcast_to(rows, (*batch, n)), requirements=("C", "W")).reshape(-1, n)
    except ValueError:
        raise InputError("input.shape", name=name, expected=(*batch, n), got=rows.shape, hint="") from None


def _quick(plan: Plan, wanted: PoseMatrix, first: JointVector | None, restarts: int) -> IKResult | None:
    """A single pose by the shortest way; None where it is not solved by it, for the general way to say why."""
    from mafsil.ik.numerical import single_loops as loops

    n = plan.vector.shape[0] // 2 - 4
    best, report, counts = np.empty((1, n + 1)), np.empty(loops.REPORT), np.empty(2, np.int64)
    target, start = np.array(wanted, order="C").reshape(1, 16), np.empty((0, n)) if first is None else first
    asked = min(restarts + 1, QUICK_ATTEMPTS), ORTHOGONALITY
    if not loops.single(*plan.entries, *asked, *plan.setting, target, start, *plan.tables, best, report, counts):
        return None
    return IKResult(
        nearest=best[0, :n],
        codes=_SOLVED,
        T_reached=report[loops.REACHED : loops.REACHED + 16].reshape(4, 4),
        position_error=report[loops.POSITION : loops.DISTANCE].reshape(()),
        rotation_error=report[loops.ROTATION : loops.POSITION].reshape(()),
        iterations=counts[:1].reshape(()),
        attempts=counts[1:].reshape(()),
        reach=np.asarray(plan.problem.reach[1]),
        distance=report[loops.DISTANCE : loops.REACHED].reshape(()),
        worst_joint=_NOBODY,
        moving=n,
    )


class _Work:
    """Poses, and the arrays that their answers go to."""

    def __init__(
        self, plan: Plan, wanted: PoseMatrix, first: JointVector, wish: Wish | None, restarts: int, deadline: float
    ) -> None:
        from mafsil.ik.numerical import search_loops as loops

        self.plan, self.first, self.wish, self.restarts, self.deadline = plan, first, wish, restarts, deadline
        self.loops = loops
        self.wanted = np.require(wanted, requirements=("C", "W")).reshape(-1, 16)
        self.count = k = len(self.wanted)
        n = plan.problem.robot.n
        self.valid, self.distance, self.radius = np.empty(k, np.int64), np.empty(k), plan.problem.reach[1]
        self.q, self.T = np.empty((k, n)), np.empty((k, 16))
        self.rotation, self.position = np.empty(k), np.empty(k)
        self.codes, self.iterations, self.attempts = np.empty(k, np.int8), np.empty(k, np.int64), np.empty(k, np.int64)
        self.worst: dict[int, str] = {}

    def block(self, index: int) -> None:
        """Solve one block of poses."""
        rows = slice(index * BLOCK, min((index + 1) * BLOCK, self.count))
        T, first, problem = np.empty((rows.stop - rows.start, 16)), self.first[rows], self.plan.problem
        check = problem.reach[0], T, self.valid[rows], self.distance[rows]
        self.loops.clean(self.wanted[rows], ORTHOGONALITY, *check)
        beyond = self._beyond(rows)
        allowed = np.where(beyond, min(self.restarts, FREE_RESTARTS) + 1, self.restarts + 1) * self.valid[rows]
        best, records = self.plan.run(T, first, allowed, deadline=self.deadline)
        unseen = ~np.isfinite(best[:, :-1]).all(axis=1)
        best[unseen, :-1] = np.clip(first[unseen] if len(first) else problem.middle, problem.lower, problem.upper)
        winner = records[:, self.loops.WINNER]
        self._wind(best, rows)
        found = self.plan.checked(best, T)
        if (found[3] != 1).any():
            self._again(best, records, T, found[3] == 1, allowed)
            self._wind(best, rows)
            found = self.plan.checked(best, T)
        if self.wish is not None:
            settled(self.plan, best, T, self.wish.of(rows), found[3] == 1, self.deadline)
            found = self.plan.checked(best, T)
        out, self.rotation[rows], self.position[rows], good = found
        self.q[rows], self.T[rows] = best[:, :-1], out[:, :16]
        self.iterations[rows] = records[:, self.loops.STEPS]
        self.attempts[rows] = np.where(winner >= 0, winner + 1, records[:, self.loops.STARTED])
        self._verdicts(rows, T, good == 1, beyond, records)

    def _beyond(self, rows: slice) -> NDArray[np.bool_]:
        """(k,) poses whose place is proven out of reach."""
        counts = self.plan.task.all_positions
        return (self.distance[rows] > self.radius * (1.0 + 1e-12)) & counts

    def _wind(self, best: Floats, rows: slice) -> None:
        """Whole turns towards the user's start, the wished posture or zero."""
        near = self.first[rows]
        if not len(self.first):
            near = np.zeros((1, best.shape[1] - 1)) if self.wish is None else self.wish.of(rows).posture
        self.loops.wind(best, near, self.plan.problem.turning, self.plan.vector)

    def _again(
        self,
        best: Floats,
        records: NDArray[np.int64],
        T: Floats,
        good: NDArray[np.bool_],
        allowed: NDArray[np.int64],
    ) -> None:
        """Rows that the check refused: trusted steps are looked at, and misses go on to the nearest configuration."""
        winner = self.loops.WINNER
        refused = np.flatnonzero(~good & (records[:, winner] >= 0))
        if len(refused):
            new, again = self.plan.run(
                T[refused], best[refused, :-1].copy(), allowed[refused], trust=False, deadline=self.deadline
            )
            best[refused] = new
            records[refused, winner] = np.where(again[:, winner] < 0, -1, records[refused, winner] + again[:, winner])
        missed = np.flatnonzero((records[:, winner] < 0) & (records[:, self.loops.STARTED] > 0))
        if len(missed) and perf_counter() < self.deadline:
            once = np.ones(len(missed), np.int64)
            new, again = self.plan.run(T[missed], best[missed, :-1].copy(), once, trust=False, patient=True)
            # Of poses so far away that their squares overflow nothing is seen.
            best[missed] = np.where(np.isfinite(new), new, best[missed])
            records[missed, winner] = np.where(again[:, winner] < 0, -1, records[missed, self.loops.STARTED] - 1)

    def _verdicts(
        self, rows: slice, T: Floats, good: NDArray[np.bool_], beyond: NDArray[np.bool_], records: NDArray[np.int64]
    ) -> None:
        """A status for every row, from the check and what is proven."""
        codes = self.codes[rows]
        codes[:] = _CODE[IKStatus.SOLVED]
        if good.all():
            return
        valid, begun = self.valid[rows] == 1, records[:, self.loops.STARTED]
        codes[~good] = _CODE[IKStatus.BUDGET_SPENT]
        if perf_counter() >= self.deadline:
            codes[~good & (begun <= self.restarts)] = _CODE[IKStatus.TIME_SPENT]
        codes[~good & beyond] = _CODE[IKStatus.OUT_OF_REACH]
        codes[~valid] = _CODE[IKStatus.NOT_A_POSE]
        for array in (self.q, self.T, self.rotation, self.position):
            array[rows][~valid] = np.nan
        self._beyond_limits(rows.start, T, codes)
        if self.plan.task.dimension > self.plan.problem.robot.n:
            codes[codes == _CODE[IKStatus.BUDGET_SPENT]] = _CODE[IKStatus.FEW_JOINTS]

    def _beyond_limits(self, start: int, T_sd: Floats, codes: NDArray[np.int8]) -> None:
        """For poses not found: whether they can be reached without limits, and which joint leaves them most."""
        rows = np.flatnonzero(codes == _CODE[IKStatus.BUDGET_SPENT])
        problem = self.plan.problem
        if not len(rows) or not problem.bounded or perf_counter() >= self.deadline:
            return
        free = cached_plan(problem_of(problem.part.whole, problem.part.asked, False), self.plan.task, 0)
        T = T_sd[rows]
        allowed = np.full(len(rows), FREE_RESTARTS + 1)
        best, _ = free.run(T, np.empty((0, problem.robot.n)), allowed, trust=False, deadline=self.deadline)
        self.loops.wind(best, problem.middle[None], problem.turning, free.vector)
        good = free.checked(best, T)[3] == 1
        excess = np.maximum(problem.lower - best[:, :-1], best[:, :-1] - problem.upper)
        for row, q_excess in zip(rows[good], excess[good], strict=True):
            codes[row] = _CODE[IKStatus.BEYOND_LIMITS]
            self.worst[start + int(row)] = problem.robot.joint_names[int(q_excess.argmax())]

    def result(self, batch: tuple[int, ...]) -> IKResult:
        """The answer in the shape of the batch."""
        worst = np.zeros(batch, dtype=f"U{self._name_width()}")
        for row, name in self.worst.items():
            worst.reshape(-1)[row] = name
        return IKResult(
            nearest=self.q.reshape(*batch, self.q.shape[1]),
            codes=self.codes.reshape(batch),
            T_reached=self.T.reshape(*batch, 4, 4),
            position_error=self.position.reshape(batch),
            rotation_error=self.rotation.reshape(batch),
            iterations=self.iterations.reshape(batch),
            attempts=self.attempts.reshape(batch),
            reach=np.full(batch, self.radius),
            distance=self.distance.reshape(batch),
            worst_joint=worst,
            moving=self.q.shape[1],
        )

    def _name_width(self) -> int:
        return max((len(name) for name in self.worst.values()), default=1)
