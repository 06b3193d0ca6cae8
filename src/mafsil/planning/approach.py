"""Gross and fine motion: freely to a place before the goal, then along a straight line of the tip, both proved free.

1. All solutions of the inverse kinematics of the goal that are within the limits and free.
2. From each, the straight line of the tip back to the place before the goal, as chords of the joints proved free.
3. The gross motion, to any of the configurations in which such a line ends.

Reference: T. Lozano-Perez, M. Mason, R. Taylor, Automatic synthesis of fine-motion strategies, IJRR 3(1), 1984.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer
from mafsil.arrays import Floats, JointVector, PoseMatrix, Vector3, as_batch, positive, single
from mafsil.collision import Checker
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.planning.arm_plan import ArmPlan
from mafsil.planning.arm_planning import configurations_of, plan
from mafsil.planning.outcome import PlanningStatus, Reason, reason_text
from mafsil.trajectory import follow, line_path

CHORD = 0.02
"""Largest change of a coordinate over a chord of the fine motion [rad | m]."""
MOST_CHORDS = 2000


@dataclass(frozen=True, eq=False, slots=True)
class Branch:
    """One configuration of the goal.

    Attributes:
        q: (n,) [rad | m].
        fine: (k, n) chords to it, proved free; empty where there are none.
        reason: why there are none.
    """

    q: JointVector
    fine: JointVector
    reason: str


@dataclass(frozen=True, eq=False, repr=False)
class ApproachPlan(Answer, data="path fine deviation"):
    """A gross motion and a straight approach, or why there is none; true if there are both.

    Attributes:
        status: how it ended.
        gross: the free motion to the place before the goal; None where no fine motion leads on from there.
        fine: (k, n) from there to the goal; empty where there is none [rad | m].
        deviation: largest distance of the tip from its line, in the middles of the chords of the fine motion [m].
        branches: all configurations of the goal, with what came of each.
    """

    status: PlanningStatus
    gross: ArmPlan | None
    fine: JointVector
    deviation: float
    branches: tuple[Branch, ...]

    @property
    def path(self) -> JointVector:
        """(m, n) both motions, one after the other; the start alone where there is no path."""
        if not self or self.gross is None:
            return np.zeros((0, self.fine.shape[-1]))
        return np.concatenate([self.gross.path, self.fine[1:]])

    def explain(self, language: str | None = None) -> str:
        """The status, and what came of each configuration of the goal."""
        lines = [self.status.sentence(language)]
        if self:
            lines.append(say("planning.approach", language=language, points=len(self.fine), off=1e3 * self.deviation))
        lines += [
            say(
                "planning.approach_branch", language=language, number=k + 1, reason=reason_text(branch.reason, language)
            )
            for k, branch in enumerate(self.branches)
            if branch.reason
        ]
        if self.gross is not None and not self:
            lines.append(self.gross.explain(language))
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return Answer.to_dict(self) | {
            "branches": [{"q": branch.q, "reason": branch.reason} for branch in self.branches],
        }


def plan_approach(
    checker: Checker,
    start: ArrayLike,
    T_goal: ArrayLike,
    *,
    away: ArrayLike = (0.0, 0.0, -0.1),
    planner: str = "rrt_connect",
    seed: int = 0,
    seconds: float = 10.0,
) -> ApproachPlan:
    """A path to a pose whose last part is a straight line of the tip.

    Args:
        checker: the arm in its scene.
        start: (n,) [rad | m].
        T_goal: (4, 4) of the tip in {s}.
        away: (3,) from the goal to the place where the line begins, in the tip frame at the goal [m].
        planner: of the gross motion, see `plan`.
        seed, seconds: of the gross motion.

    Raises:
        InputError: a wrong shape, a number that is not finite, a line of no length, an unknown planner.
    """
    robot = checker.robot
    q = np.asarray(single("start", start, (robot.n,)), dtype=np.float64)
    goal = np.asarray(as_batch("T_goal", T_goal, (4, 4), finite=True))
    if goal.ndim != 2:
        raise InputError("input.shape", name="T_goal", expected=(4, 4), got=goal.shape, hint="")
    step = single("away", away, (3,))
    positive("away", float(np.linalg.norm(step)))
    positive("seconds", seconds)
    before = goal.copy()
    before[:3, 3] += goal[:3, :3] @ step
    branches = tuple(_branches(checker, q, goal, before))  # 1., 2.
    ready = [branch for branch in branches if len(branch.fine)]
    none = np.zeros((0, robot.n))
    if not ready:
        status = PlanningStatus.FINE_BLOCKED if branches else PlanningStatus.UNREACHABLE
        return ApproachPlan(status, None, none, np.inf, branches)
    ends = np.stack([branch.fine[0] for branch in ready])
    gross = plan(checker, None, q, ends, planner=planner, seed=seed, seconds=seconds)  # 3.
    if not gross:
        return ApproachPlan(gross.status, gross, none, np.inf, branches)
    fine = ready[int(np.abs(ends - gross.path[-1]).max(axis=1).argmin())].fine
    return ApproachPlan(PlanningStatus.FOUND, gross, fine, _deviation(checker, fine, before, goal, step), branches)


def _branches(checker: Checker, start: JointVector, goal: PoseMatrix, before: PoseMatrix) -> Iterator[Branch]:
    none = np.zeros((0, len(start)))
    line = line_path(goal, before)
    for q in configurations_of(checker, goal, start):
        if not checker.free(q):
            yield Branch(q, none, Reason(checker.check(q)))
            continue
        followed = follow(checker.robot, line, q)
        if not followed or followed.value is None:
            yield Branch(q, none, Reason(followed))
            continue
        limits = checker.robot.limits
        chords = limits.snap_to_limits(_chords(followed.value.at))
        if ((chords < limits.lower) | (chords > limits.upper)).any():
            yield Branch(q, none, Reason((PlanningStatus.GOAL_OUTSIDE.key, {})))
            continue
        proved = checker.check_path(chords)
        yield Branch(q, chords[::-1] if proved else none, "" if proved else Reason(proved))


def _chords(at: Any) -> JointVector:
    """Places along a path over 0..1 by whose chords no coordinate changes by more than CHORD."""
    rough = np.asarray(at(np.linspace(0.0, 1.0, 65))[0])
    way = float(np.abs(np.diff(rough, axis=0)).sum(axis=0).max())
    count = int(min(max(way / CHORD, 8.0), MOST_CHORDS)) + 2
    return np.asarray(at(np.linspace(0.0, 1.0, count))[0])


def _deviation(checker: Checker, fine: JointVector, before: PoseMatrix, goal: PoseMatrix, step: Vector3) -> float:
    places: Floats = checker.robot.forward_kinematics((fine[1:] + fine[:-1]) / 2)[..., :3, 3] - before[:3, 3]
    way = goal[:3, :3] @ step
    way = way / np.linalg.norm(way)
    return float(np.linalg.norm(places - (places @ way)[:, None] * way, axis=1).max())
