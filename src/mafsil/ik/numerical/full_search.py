"""The full search, block by block: attempts, check, second attempts, preferred configurations, and a status for all."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil import threads
from mafsil.arrays import Floats, JointVector, as_batch
from mafsil.errors import InputError
from mafsil.ik.numerical.fast_search import BLOCK
from mafsil.ik.numerical.problem import PoseProblem, PoseTask, problem_of
from mafsil.ik.numerical.records import (
    BEGUN,
    CONFIGURATION,
    DISTANCE,
    POSITION_ERROR,
    REACHED,
    ROTATION_ERROR,
    STEPS,
    WINNER,
    Whole,
)
from mafsil.ik.numerical.search import SearchPlan, cached_plan
from mafsil.ik.result import CODES, IKStatus
from mafsil.ik.tolerances import EXACT_POSE, LEAST_GAIN, NEARLY_REACHED, ON_LIMIT, STILL
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.ik.structure.analysis as analysis
else:
    analysis = lazily("mafsil.ik.structure.analysis")


TURN = 2.0 * np.pi
SELF_MOTION_STEPS = 300
"""Most steps of self-motion."""
LONGEST = 0.2
"""Longest step of self-motion [rad | m]: the task is left by its square, and brought back by the next step."""
FREE_RESTARTS = 7
"""Restarts for poses proven out of reach, and for asking whether the limits are what forbids a pose."""
EXACT_FROM = 8
"""Attempts after which a pose that was not found is looked up in the arm's closed form; fewer restarts than that are
asked for by those who want the solution near their own start, or none."""


class FullSearch:
    """Poses, and the report that their answers go to: second looks, configuration goals, time limits, and reasons.

    Args:
        plan: of the search.
        desired: (k, 16) poses.
        q0: (k, n) initial guesses, or (0, n).
        goal: the preferred configuration, or None.
        restarts: how many more starts are tried after the first.
        deadline: of `perf_counter`.
    """

    def __init__(
        self,
        plan: SearchPlan,
        desired: Floats,
        q0: JointVector,
        goal: PreferredConfiguration | None,
        restarts: int,
        deadline: float,
    ) -> None:
        self.plan, self.q0, self.goal, self.restarts, self.deadline = plan, q0, goal, restarts, deadline
        self.desired, self.count = desired, len(desired)
        self.report = np.full((self.count, CONFIGURATION + plan.problem.robot.n), np.nan)
        self.attempts = np.zeros((self.count, 4), np.int64)
        self.codes = np.empty(self.count, np.int8)
        self.worst: dict[int, str] = {}

    def run(self) -> None:
        """Solve all poses, on all cores where there are several blocks."""
        blocks = -(-self.count // BLOCK)
        threads.run(self.block, blocks, threads.available() if blocks > 1 else 1)

    def block(self, index: int) -> None:
        """Solve one block of poses."""
        rows = slice(index * BLOCK, min((index + 1) * BLOCK, self.count))
        q0, problem = self.q0[rows], self.plan.problem
        T, distance = self.plan.clean(self.desired[rows])
        valid = distance >= 0.0
        # Poses whose place is proven out of reach.
        beyond = (distance > problem.reach[1] * (1.0 + EXACT_POSE)) & self.plan.task.all_positions
        allowed = np.where(beyond, min(self.restarts, FREE_RESTARTS) + 1, self.restarts + 1) * valid
        best, attempts = self.plan.run(T, q0, allowed, deadline=self.deadline)
        unseen = ~np.isfinite(best[:, :-1]).all(axis=1)
        best[unseen, :-1] = np.clip(q0[unseen] if len(q0) else problem.middle, problem.lower, problem.upper)
        self._wind(best, rows)
        found = self.plan.check_best(best, T)
        if (found[3] != 1).any():
            self._again(best, attempts, T, found[3] == 1, allowed)
            self._wind(best, rows)
            found = self.plan.check_best(best, T)
            self._exact(best, attempts, T, found[3] == 1, rows)
            self._wind(best, rows)
            found = self.plan.check_best(best, T)
        if self.goal is not None:
            approach_goal(self.plan, best, T, self.goal.of(rows), found[3] == 1, self.deadline)
            found = self.plan.check_best(best, T)
        out, rotation, position, good = found
        report = self.report[rows]
        report[:, ROTATION_ERROR], report[:, POSITION_ERROR], report[:, DISTANCE] = rotation, position, distance
        report[:, REACHED:CONFIGURATION], report[:, CONFIGURATION:] = out, best[:, :-1]
        report[~valid] = np.nan
        self.attempts[rows] = attempts
        self._verdicts(rows, T, good == 1, beyond, valid, attempts)

    def _initial_guess(self, rows: slice) -> JointVector:
        """(k, n) or (1, n) what solutions are wound to: the user's, or the preferred configuration, or zero."""
        if len(self.q0):
            return self.q0[rows]
        return np.zeros((1, self.plan.problem.robot.n)) if self.goal is None else self.goal.of(rows).q

    def _wind(self, best: Floats, rows: slice) -> None:
        """Whole turns of the joints."""
        self.plan.wind(best, self._initial_guess(rows))

    def _again(
        self,
        best: Floats,
        attempts: Whole,
        T: Floats,
        good: NDArray[np.bool_],
        allowed: NDArray[np.int64],
    ) -> None:
        """Rows that the check refused: trusted steps are checked, failed searches end at the nearest configuration."""
        winner, begun = attempts[:, WINNER], attempts[:, BEGUN]
        refused = np.flatnonzero(~good & (winner >= 0))
        if len(refused):
            new, again = self.plan.run(
                T[refused], best[refused, :-1].copy(), allowed[refused], trust=False, deadline=self.deadline
            )
            best[refused] = new
            winner[refused] = np.where(again[:, WINNER] < 0, -1, winner[refused] + again[:, WINNER])
        open_rows = np.flatnonzero((winner < 0) & (begun > 0))
        if len(open_rows) and perf_counter() < self.deadline:
            once = np.ones(len(open_rows), np.int64)
            new, again = self.plan.run(T[open_rows], best[open_rows, :-1].copy(), once, trust=False, patient=True)
            # Of poses so far away that their squares overflow nothing is seen.
            best[open_rows] = np.where(np.isfinite(new), new, best[open_rows])
            winner[open_rows] = np.where(again[:, WINNER] < 0, -1, begun[open_rows] - 1)

    def _exact(self, best: Floats, attempts: Whole, T: Floats, good: NDArray[np.bool_], rows: slice) -> None:
        """Rows that the search did not solve: the arm's closed form, where it has one, gives branches to begin at."""
        begun = attempts[:, BEGUN]
        failed = np.flatnonzero(~good & (begun >= EXACT_FROM))
        if not len(failed) or perf_counter() >= self.deadline:
            return
        q0 = self._initial_guess(rows)
        starts = exact_starts(self.plan.problem, self.plan.task, T[failed], q0 if len(q0) == 1 else q0[failed])
        if starts is None:
            return
        open_rows, branch = np.nonzero(np.isfinite(starts).all(axis=-1))
        tried = failed[open_rows]
        once = np.ones(len(tried), np.int64)
        new, again = self.plan.run(T[tried], starts[open_rows, branch], once, trust=False)
        # In the order of the branches, the nearest last: it is the one that stays.
        for k in np.flatnonzero(again[:, WINNER] >= 0)[::-1]:
            row = tried[k]
            best[row] = new[k]
            attempts[row, WINNER], attempts[row, STEPS] = begun[row], again[k, STEPS]

    def _verdicts(
        self,
        rows: slice,
        T: Floats,
        good: NDArray[np.bool_],
        beyond: NDArray[np.bool_],
        valid: NDArray[np.bool_],
        attempts: Whole,
    ) -> None:
        """A status for every row, from the check and what is proven."""
        codes = self.codes[rows]
        codes[:] = CODES[IKStatus.SOLVED]
        if good.all():
            return
        begun = attempts[:, BEGUN]
        codes[~good] = CODES[IKStatus.BUDGET_SPENT]
        if perf_counter() >= self.deadline:
            codes[~good & (begun <= self.restarts)] = CODES[IKStatus.TIME_SPENT]
        codes[~good & beyond] = CODES[IKStatus.OUT_OF_REACH]
        codes[~valid] = CODES[IKStatus.NOT_A_POSE]
        self._on_limits(rows, T, codes)
        self._beyond_limits(rows.start, T, codes)
        if self.plan.task.dimension > self.plan.problem.robot.n:
            codes[codes == CODES[IKStatus.BUDGET_SPENT]] = CODES[IKStatus.FEW_JOINTS]

    def _on_limits(self, rows: slice, T_sd: Floats, codes: NDArray[np.int8]) -> None:
        """Poses that are solved beside the configuration found, with joints a measured number beyond their limits."""
        problem = self.plan.problem
        left = np.flatnonzero(codes == CODES[IKStatus.BUDGET_SPENT])
        if not len(left) or not problem.bounded or perf_counter() >= self.deadline:
            return
        free = cached_plan(problem_of(problem.part.whole, problem.part.requested, False), self.plan.task, 0)
        report = self.report[rows]
        once = np.ones(len(left), np.int64)
        best, _ = free.run(T_sd[left], np.ascontiguousarray(report[left, CONFIGURATION:]), once, trust=False)
        out, rotation, position, good = free.check_best(best, T_sd[left])
        excess = np.maximum(problem.lower - best[:, :-1], best[:, :-1] - problem.upper)
        for k in np.flatnonzero((good == 1) & (excess.max(axis=1) <= ON_LIMIT)):
            row = left[k]
            report[row, ROTATION_ERROR], report[row, POSITION_ERROR] = rotation[k], position[k]
            report[row, REACHED:CONFIGURATION], report[row, CONFIGURATION:] = out[k], best[k, :-1]
            codes[row] = CODES[IKStatus.SOLVED]
            self.worst[rows.start + int(row)] = problem.robot.joint_names[int(excess[k].argmax())]

    def _beyond_limits(self, start: int, T_sd: Floats, codes: NDArray[np.int8]) -> None:
        """For poses not found: whether they can be reached without limits, and which joint leaves them most."""
        rows = np.flatnonzero(codes == CODES[IKStatus.BUDGET_SPENT])
        problem = self.plan.problem
        if not len(rows) or not problem.bounded or perf_counter() >= self.deadline:
            return
        free = cached_plan(problem_of(problem.part.whole, problem.part.requested, False), self.plan.task, 0)
        T = T_sd[rows]
        allowed = np.full(len(rows), FREE_RESTARTS + 1)
        best, _ = free.run(T, np.empty((0, problem.robot.n)), allowed, trust=False, deadline=self.deadline)
        free.wind(best, problem.middle[None])
        good = free.check_best(best, T)[3] == 1
        excess = np.maximum(problem.lower - best[:, :-1], best[:, :-1] - problem.upper)
        for row, q_excess in zip(rows[good], excess[good], strict=True):
            codes[row] = CODES[IKStatus.BEYOND_LIMITS]
            self.worst[start + int(row)] = problem.robot.joint_names[int(q_excess.argmax())]


@dataclass(frozen=True, eq=False)
class PreferredConfiguration:
    """Minimise the sum of w_i (q_i - q_preferred_i)^2 over the self-motion.

    Attributes:
        q: (k, n) or (1, n) [rad | m].
        weights: (n,) the largest is one.
    """

    q: JointVector
    weights: Floats

    def of(self, rows: slice) -> PreferredConfiguration:
        """The goal for some rows."""
        return self if len(self.q) == 1 else PreferredConfiguration(self.q[rows], self.weights)

    def cost(self, q: JointVector) -> Floats:
        """(k,) the sum."""
        return ((q - self.q) ** 2 * self.weights).sum(axis=1)


def preferred_configuration(
    problem: PoseProblem, q: JointVector, weights: ArrayLike | None
) -> PreferredConfiguration | None:
    """The goal of a user, or None.

    Args:
        problem: the frame.
        q: (k, n) preferred, or (0, n) for none.
        weights: (n,) or None.

    Raises:
        InputError: weights that are negative or all zero.
    """
    if not len(q):
        return None
    n = problem.robot.n
    given = np.ones(n) if weights is None else as_batch("preferred_weights", weights, (n,), finite=True)
    if (given < 0.0).any() or not given.any():
        raise InputError("ik.weight", name="preferred_weights", value=float(given.min()))
    return PreferredConfiguration(q, given / given.max())


def approach_goal(
    plan: SearchPlan,
    best: Floats,
    T_sd: Floats,
    goal: PreferredConfiguration,
    good: NDArray[np.bool_],
    deadline: float = np.inf,
) -> None:
    """Move solutions along their self-motion towards the goal; those that gain by it replace the first ones.

    Args:
        plan: of the search.
        best: (k, n + 1) solutions, changed.
        T_sd: (k, 16).
        goal: the preferred configuration.
        good: (k,) which rows are solutions.
        deadline: of `perf_counter`.
    """
    rows = np.flatnonzero(good)
    if not len(rows):
        return
    local = goal if len(goal.q) == 1 else PreferredConfiguration(goal.q[rows], goal.weights)
    q_preferred = np.broadcast_to(local.q, (len(rows), best.shape[1] - 1))
    start = best[rows, :-1].copy()
    q = _descend(plan, start, T_sd[rows], q_preferred, goal.weights, deadline)
    once = np.ones(len(rows), np.int64)
    back, _ = plan.run(T_sd[rows], q, once, trust=False, deadline=np.inf)
    fine = plan.check_best(back, T_sd[rows])[3] == 1
    gains = fine & (local.cost(back[:, :-1]) < local.cost(start))
    best[rows[gains]] = back[gains]


def _descend(
    plan: SearchPlan, start: JointVector, T_sd: Floats, q_preferred: JointVector, weights: Floats, deadline: float
) -> JointVector:
    """(k, n) where the self-motion towards the preferred configuration comes to rest."""
    n = start.shape[1]
    q, step = start.copy(), plan.problem.step_with_self_motion(plan.task.one_axis, plan.task.aligned).ufunc
    moving, gain, cost = np.arange(len(q)), np.ones(len(q)), np.full(len(q), np.inf)
    for _ in range(SELF_MOTION_STEPS):
        gap = q_preferred[moving] - q[moving]
        now = (weights * gap * gap).sum(axis=1)
        # A step that did not pay was too long for the curvature of the self-motion.
        gain[moving] = np.where(now < cost[moving], np.minimum(1.0, 1.3 * gain[moving]), 0.5 * gain[moving])
        cost[moving] = now
        z = weights * gap
        size = np.linalg.norm(z, axis=1)
        pace = gain[moving] * np.minimum(1.0, LONGEST / np.maximum(size, LONGEST))
        out = step(q[moving], T_sd[moving].reshape(-1, 4, 4), plan.vector, pace[:, None] * z)
        q[moving] = out[:, :n]
        still = np.abs(out[:, n + 6 :]).max(axis=1, initial=0.0) <= STILL * pace
        moving = moving[~still & (gain[moving] > LEAST_GAIN)]
        if not len(moving) or perf_counter() >= deadline:
            break
    return q


def exact_starts(problem: PoseProblem, task: PoseTask, T_sd: Floats, near: JointVector) -> JointVector | None:
    """Solutions of the arm's own closed form within the limits, the nearest first.

    Args:
        problem: the frame and its bounds.
        task: what counts.
        T_sd: (k, 16) clean poses.
        near: (k, n) or (1, n) what they are to be near to.

    Returns:
        (k, branches, n), NaN where there are fewer; None where the arm has no closed form for this task.
    """
    whole_pose = task.kind == "pose" and task.dimension == 6
    if problem.frame is not None or not whole_pose or problem.robot.mechanism.loops:
        return None
    arm = analysis.analysis(problem.robot.mechanism)
    if arm.form is None or not arm.exact or arm.locked:
        return None
    branches = arm.form.solve(T_sd.reshape(-1, 4, 4))
    q, revolute = branches.q, problem.revolute == 1
    # Angles come within half a turn of zero: first near to the given, then up or down into the bounds.
    q = q - np.where(revolute, TURN * np.round((q - near[:, None]) / TURN), 0.0)
    q = q + np.where(revolute & (q < problem.lower), TURN * np.ceil((problem.lower - q) / TURN - NEARLY_REACHED), 0.0)
    q = q - np.where(revolute & (q > problem.upper), TURN * np.ceil((q - problem.upper) / TURN - NEARLY_REACHED), 0.0)
    fits = (q >= problem.lower - NEARLY_REACHED) & (q <= problem.upper + NEARLY_REACHED)
    good = fits.all(axis=-1) & (branches.residual <= NEARLY_REACHED)
    far = np.where(good, np.abs(q - near[:, None]).max(axis=-1), np.inf)
    order = np.argsort(far, axis=1, kind="stable")
    q[~good] = np.nan
    return np.take_along_axis(q, order[..., None], axis=1)
