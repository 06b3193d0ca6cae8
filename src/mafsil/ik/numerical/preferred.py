"""Null-space goals: what the task leaves free is used to come near a preferred configuration."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, as_batch
from mafsil.errors import InputError
from mafsil.ik.numerical.problem import PoseProblem
from mafsil.ik.numerical.search import SearchPlan
from mafsil.ik.tolerances import LEAST_GAIN, STILL

STEPS = 300
"""Most steps of self-motion."""

LONGEST = 0.2
"""Longest step of self-motion [rad | m]: the task is left by its square, and brought back by the next step."""


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
    for _ in range(STEPS):
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
