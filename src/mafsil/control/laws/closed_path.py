"""From a path of the tip to a path of all joints of a mechanism with loops; what stops it is named with its place."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from mafsil.arrays import Floats, JointVector, PoseMatrix, not_negative, positive, require_kind, single
from mafsil.parallel import ClosedChain
from mafsil.parallel.closed_poses import Task, closed_pose_near, pose_miss
from mafsil.solvers import Outcome
from mafsil.trajectory import cubic_through
from mafsil.trajectory.motion import PlanStatus
from mafsil.trajectory.paths import TipPath
from mafsil.trajectory.splines import PiecewisePolynomial

Followed = Outcome[PiecewisePolynomial | None]
FEWEST, MOST = 16, 1024
"""Pieces between two breaks of the path."""
MET = 1e-9
"""What may be left of the task at a knot [m, rad]."""
SLOPE = np.array([-25.0, 48.0, -36.0, 16.0, -3.0]) / 12.0
"""Derivative at the first of five points at a distance of one, with an error of the fourth order."""
FARTHEST = 0.5
"""Way of a joint between two knots beyond which it has gone another way [rad | sizes]."""


def follow_with_loops(
    chain: ClosedChain,
    path: TipPath,
    q_start: JointVector,
    *,
    task: Task = "pose",
    tolerance: float = 1e-6,
    slack: float = 0.0,
) -> Followed:
    """The path of all joints over s in 0 .. 1 that moves the tip along `path` with closed loops, starting at `q_start`.

    1. From knot to knot: loops and task together by Levenberg's method, from where the joints are heading.
    2. Cubics through the knots, twice continuously differentiable between the breaks of the path.
    3. In the middle of each piece the driven joints are held and the loops closed: where the tip is then off the path
       by more than the tolerance, there are twice as many knots.

    Args:
        chain: a mechanism with loops.
        path: of the tip, which it begins with at q_start: a line, an arc, a screw motion, a spline, several joined.
        q_start: (n,) configuration with closed loops [rad | m].
        task: what of the path counts: all of it, place and z axis, or the place.
        tolerance: largest deviation from the path [m, rad].
        slack: how far beside the path the tip may be at the knots of mechanisms with fewer freedoms than the task asks.

    Returns:
        The path of the joints, its residual the largest deviation; or None with NOT_FOUND, SINGULAR or JOINT_LIMIT
        and the place where it ends, DEVIATES if more knots do not help.
    """
    tolerance, slack = positive("tolerance", tolerance), not_negative("slack", slack)
    require_kind("chain", chain, "ClosedChain", "actuated", "close_loops")
    require_kind("path", path, "TipPath", "breaks", "poses")
    pieces = FEWEST
    while True:
        between: list[Floats] = [np.linspace(a, b, pieces + 1)[1:] for a, b in pairwise(path.breaks.tolist())]
        knots: Floats = np.concatenate([np.zeros(1), *between])
        found = _at_knots(chain, path.poses(knots), knots, q_start, task, slack)
        if isinstance(found, Outcome):
            # Steps that are too long for Newton's method look the same as what cannot be reached.
            if pieces >= MOST // 4:
                return found
            pieces *= 4
            continue
        joints = _through(knots, found, pieces)
        deviation = _deviation(chain, path, joints, knots, task)
        if deviation <= tolerance + slack:
            return Outcome(joints, PlanStatus.FOLLOWED, deviation, len(knots) - 1)
        if pieces >= MOST:
            details = {"tolerance": tolerance + slack}
            return Outcome(joints, PlanStatus.DEVIATES, deviation, len(knots) - 1, details=details)
        pieces *= 2


def _at_knots(
    chain: ClosedChain, T: PoseMatrix, knots: Floats, q: JointVector, task: Task, slack: float
) -> JointVector | Followed:
    """(k, n) configurations at the knots, or what stops them."""
    known = np.empty((len(knots), chain.n))
    limits, allowed = chain.robot.limits, max(MET, slack)
    known[0] = single("q_start", q, (chain.n,))
    for k in range(1, len(knots)):
        guess = known[k - 1] + (known[k - 1] - known[k - 2] if k > 1 else 0.0)
        closed = closed_pose_near(chain, T[k], guess, task, nearest=slack > 0.0)
        place, turn = (float(part) for part in pose_miss(chain, T[k], closed.q, task))
        details = {"place": float(knots[k - 1])}
        if not closed or max(place, turn) > allowed:
            residual = max(place, turn)
            return Outcome(None, PlanStatus.NOT_FOUND, residual, details=details | {"steps": len(knots)})
        if (np.abs(closed.q - known[k - 1]) > FARTHEST * chain.unit).any():
            return Outcome(None, PlanStatus.SINGULAR, 0.0, details=details | {"margin": 0.0})
        known[k] = closed.q
        beyond = np.maximum(limits.lower - closed.q, closed.q - limits.upper)
        joint = int(beyond.argmax())
        if not limits.within(closed.q)[joint]:
            value = float(closed.q[joint])
            limit = float(limits.lower[joint] if value < limits.lower[joint] else limits.upper[joint])
            details |= {"joint": chain.robot.joint_names[joint], "value": value, "limit": limit}
            return Outcome(None, PlanStatus.JOINT_LIMIT, 0.0, details=details)
    return known


def _through(knots: Floats, q: JointVector, pieces: int) -> PiecewisePolynomial:
    """Cubics through configurations (k, n) at the knots (k,), splines of so many pieces between the path's breaks."""
    parts: list[Floats] = []
    for first in range(0, len(knots) - 1, pieces):
        u, s = q[first : first + pieces + 1], knots[first : first + pieces + 1]
        step = float(s[1] - s[0])
        begin, end = SLOPE @ u[:5] / step, -SLOPE @ u[::-1][:5] / step
        parts.append(cubic_through(u, np.diff(s), start_velocity=begin, goal_velocity=end).coefficients)
    return PiecewisePolynomial(knots, np.concatenate(parts))


def _deviation(chain: ClosedChain, path: TipPath, joints: PiecewisePolynomial, knots: Floats, task: Task) -> float:
    """How far the tip is off its path in the middle of the pieces, driven joints held and loops closed."""
    middle = (knots[1:] + knots[:-1]) / 2
    closed = chain.close_loops(joints.at(middle).u, hold=chain.actuated, tries=1)
    if not closed:
        return np.inf
    worst = 0.0
    for T, q in zip(path.poses(middle), closed.q, strict=True):
        place, turn = pose_miss(chain, T, q, task)
        worst = max(worst, float(place), float(turn))
    return worst
