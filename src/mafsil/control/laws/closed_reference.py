"""Motions of all joints of a closed chain that keep its loops closed, from those of its driven joints or of its tip.

What stops a path is named with its place.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, PoseMatrix, as_batch, not_negative, positive, require_kind, single
from mafsil.errors import InputError
from mafsil.parallel import ClosedChain
from mafsil.parallel.closed_poses import Task, closed_pose_near, pose_miss
from mafsil.solvers import Outcome, decompositions
from mafsil.trajectory import Motion, Trajectory, cubic_through
from mafsil.trajectory.motion import PlanStatus
from mafsil.trajectory.paths import TipPath
from mafsil.trajectory.splines import PiecewisePolynomial

Followed = Outcome[PiecewisePolynomial | None]
FEWEST_PIECES, MOST_PIECES = 16, 1024
"""Pieces between two breaks of the path."""
MET = 1e-9
"""What may be left of the task at a knot [m, rad]."""
SLOPE = np.array([-25.0, 48.0, -36.0, 16.0, -3.0]) / 12.0
"""Derivative at the first of five points at a distance of one, with an error of the fourth order."""
FARTHEST_KNOT = 0.5
"""Way of a joint between two knots beyond which it has gone another way [rad | sizes]."""
LONGEST_STEP = 0.05
"""Of the driven joints between two places from which configurations are found [rad | m]."""
FEWEST, MOST = 16, 20_000
SAMPLES = 400
"""Times at which the length of the motion is measured."""
FARTHEST = 10.0
"""Times the driven step, or its own usual step, that a passive joint may go in one: more is another way to close."""
DIFFERENCE = 1e-5
"""Time between accelerations for their derivative, over the duration."""
RANK = 1e-9
"""Singular value of the passive columns over the largest below which driven joints do not decide the others."""


@dataclass(frozen=True, eq=False)
class DrivenTrajectory:
    """All joints of a closed chain while its driven joints follow a trajectory.

    Attributes:
        chain: whose loops stay closed.
        driven: (a,) trajectory of the driven joints.
        places: (k,) times [s] of known configurations.
        known: (k, n) configurations that close the loops; those between are found from them.
    """

    chain: ClosedChain
    driven: Trajectory
    places: Floats = field(repr=False)
    known: JointVector = field(repr=False)

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return self.driven.duration

    @property
    def n(self) -> int:
        """Number of coordinates of the tree."""
        return self.chain.n

    def breaks(self) -> Floats:
        """Times between which the motion is smooth [s]."""
        return self.driven.breaks()

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration of all joints at the times `t` (*times) [s]."""
        motion, chain = self.driven.at(t), self.chain
        moment = np.clip(np.asarray(t, dtype=np.float64), 0.0, self.duration)
        columns: list[Floats] = [np.interp(moment, self.places, column) for column in self.known.T]
        guess: Floats = np.stack(columns, axis=-1)
        return Motion(*chain.following(guess, np.stack([motion.u, motion.v, motion.a], axis=-2)))

    def jerk(self, t: ArrayLike) -> Floats:
        """(*times, n) third derivative, by differences of accelerations on the side that moves [rad/s^3 | m/s^3]."""
        moment = np.asarray(t, dtype=np.float64)
        h = DIFFERENCE * max(self.duration, DIFFERENCE)
        low, high = (np.clip(moment + s, 0.0, self.duration) for s in (-h, h))
        return (self.at(high).a - self.at(low).a) / np.maximum(high - low, h)[..., None]


def driven_trajectory(chain: ClosedChain, driven: Trajectory, q_0: ArrayLike) -> DrivenTrajectory:
    """The motion of all joints that keeps the loops closed while the driven ones follow a trajectory.

    1. The start is closed with the driven joints where the trajectory begins.
    2. Configurations are followed from place to place, driven joints held, by Newton's method.
    3. Where the loops cannot be closed, or the driven joints do not decide the others, there is no such motion.

    Args:
        chain: a mechanism with loops.
        driven: trajectory of its a driven joints.
        q_0: (n,) all joints near the start: they say which way the loops are closed.

    Raises:
        InputError: a trajectory of another width; the loops cannot be closed at some time (named, with the gap), or the
            motion passes a singular configuration of the driven joints.
    """
    require_kind("chain", chain, "ClosedChain", "actuated", "close_loops")
    require_kind("driven", driven, "Trajectory", "n", "duration", "at")
    a = chain.actuated
    if driven.n != len(a):
        details = {"expected": f"n = {len(a)}", "got": f"n = {driven.n}", "hint": ""}
        raise InputError("input.shape", name="driven", **details)
    here = np.array(as_batch("q_0", q_0, (chain.n,), finite=True))
    if here.ndim != 1:
        raise InputError("input.shape", name="q_0", expected=(chain.n,), got=here.shape, hint="")
    t = _places(driven)
    u = driven.at(t).u
    known = np.empty((len(t), chain.n))
    for k, place in enumerate(u):
        guess = here + (known[k - 1] - known[k - 2] if k > 1 else 0.0)
        guess[a] = place
        found = chain.close_loops(guess, hold=a, tries=1)
        if not found:
            gap = float(found.error) if np.isfinite(found.error) else np.inf
            raise InputError("control.loops_not_closed", time=float(t[k]), gap=gap)
        if k and np.abs(found.q - here).max() > FARTHEST * max(np.abs(place - u[k - 1]).max(), LONGEST_STEP):
            raise InputError("control.loops_jump", time=float(t[k]), gap=float(np.abs(found.q - here).max()))
        known[k] = here = found.q
    _require_decided(chain, t, known)
    return DrivenTrajectory(chain, driven, t, known)


def _places(driven: Trajectory) -> Floats:
    """Times so close that no driven joint goes farther than a step between two of them."""
    t = np.linspace(0.0, driven.duration, SAMPLES)
    length = float(np.abs(np.diff(driven.at(t).u, axis=0)).sum(axis=0).max(initial=0.0))
    count = int(np.clip(np.ceil(length / LONGEST_STEP), FEWEST, MOST))
    return np.linspace(0.0, driven.duration, count + 1)


def _require_decided(chain: ClosedChain, t: Floats, known: JointVector) -> None:
    """Refuse places where the rates of the driven joints do not decide those of the others."""
    passive = np.setdiff1d(np.arange(chain.n), chain.actuated)
    s = decompositions.singular_values(np.ascontiguousarray(chain.terms(known).J[..., passive]))
    least = s[:, len(passive) - 1] if s.shape[1] >= len(passive) else np.zeros(len(t))
    free = least <= RANK * np.maximum(s[:, 0], 1.0)
    if len(passive) and free.any():
        raise InputError("control.loops_undecided", time=float(t[int(free.argmax())]))


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
    pieces = FEWEST_PIECES
    while True:
        between: list[Floats] = [np.linspace(a, b, pieces + 1)[1:] for a, b in pairwise(path.breaks.tolist())]
        knots: Floats = np.concatenate([np.zeros(1), *between])
        found = _at_knots(chain, path.poses(knots), knots, q_start, task, slack)
        if isinstance(found, Outcome):
            # Steps that are too long for Newton's method look the same as what cannot be reached.
            if pieces >= MOST_PIECES // 4:
                return found
            pieces *= 4
            continue
        joints = _through(knots, found, pieces)
        deviation = _deviation(chain, path, joints, knots, task)
        if deviation <= tolerance + slack:
            return Outcome(joints, PlanStatus.FOLLOWED, deviation, len(knots) - 1)
        if pieces >= MOST_PIECES:
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
        if (np.abs(closed.q - known[k - 1]) > FARTHEST_KNOT * chain.unit).any():
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
