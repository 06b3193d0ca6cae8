"""Paths that keep something, such as a tool upright or loops closed: the search, and the proof of what a path keeps."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil import parallel
from mafsil.arrays import Floats, JointVector, positive
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.messages import clauses
from mafsil.model import Joint, JointKind, Mechanism
from mafsil.planning.arm_limits import bounds_of
from mafsil.planning.path_constraints import Constraint, LoopClosed, kept_of

if TYPE_CHECKING:
    import mafsil.planning.arm_search_loops as arm_search_loops
    import mafsil.planning.kept_loops as kept_loops
    import mafsil.planning.kept_search_loops as kept_search_loops
    from mafsil.collision import Checker
    from mafsil.parallel import ClosedChain
    from mafsil.robot import Robot
else:
    arm_search_loops = lazily("mafsil.planning.arm_search_loops")
    kept_loops = lazily("mafsil.planning.kept_loops")
    kept_search_loops = lazily("mafsil.planning.kept_search_loops")


STEP = 0.2
"""Longest motion between two projections [rad | m]."""
REACH = 0.15
"""Way that a tree is steered towards a sample, as share of the diagonal of the limits."""
SLACK = 0.8
"""Share of the limits that a search uses: what is left is for rounded corners."""
FIRST_NODES = 4096
SLICE = 32
"""Samples between two looks at the clock."""


@dataclass(frozen=True, eq=False)
class Kept:
    """Constraints of one arm as people write them and as loops read them.

    Attributes:
        constraints: one for each measure.
        arrays: `kept_loops.Kept`.
    """

    constraints: tuple[Constraint, ...]
    arrays: kept_loops.Kept

    @property
    def asked(self) -> bool:
        """Whether anything but closed loops is kept."""
        return not all(isinstance(one, LoopClosed) for one in self.constraints)

    def measures(self, checker: Checker, q: JointVector) -> Floats:
        """(m, k) measures of configurations (m, n)."""
        return kept_loops.measure_constraints(self.arrays, checker.world().kinematics, np.ascontiguousarray(q))

    def holds(self, checker: Checker, q: JointVector) -> NDArray[np.bool_]:
        """(m,) whether configurations (m, n) keep everything."""
        return np.atleast_1d((self.measures(checker, q) <= self.arrays.limit).all(axis=1))

    def along(self, checker: Checker, A: JointVector, B: JointVector) -> Floats | None:
        """(k,) bounds of the measures on straight motions (m, n) to (m, n), proved; None if not within the limits."""
        worst = np.zeros(len(self.constraints))
        A, B = np.ascontiguousarray(A), np.ascontiguousarray(B)
        proved = kept_loops.kept_along(self.arrays, checker.world().kinematics, A, B, worst)
        return worst if proved == len(A) else None

    def on_curve(self, checker: Checker, places: JointVector, apart: JointVector) -> bool:
        """Whether a curve through places (m, n) keeps everything that leaves its chords by no more than `apart` (n,).

        A change of the joints by dq moves no point by more than sum |dq_j| reach_j, and turns no direction by more than
        sum |dq_j|.
        """
        worst = self.along(checker, places[:-1], places[1:])
        if worst is None:
            return False
        kept = self.arrays
        rates = np.abs(kept.joints[:, 2]) * np.abs(apart)[kept.joints[:, 1].astype(np.int64)]
        furthest = np.abs(places).max(axis=0) + np.abs(apart)
        turns = kept.joints[:, 3] != 0.0
        lever = kept.reach + kept.stretch @ furthest + np.abs(kept.joints[:, 4])
        of_point = (np.where(turns, lever, 1.0) * kept.moves) @ rates
        of_axis = kept.moves @ (rates * turns)
        points = np.repeat(kept.rows[:, 0] == kept_loops.POINT, 2)
        group = np.repeat(kept.rows[:, 3].astype(np.int64), 2) if len(kept.rows) else np.zeros(0, np.int64)
        real = np.stack([kept.rows[:, 1], kept.rows[:, 2]], axis=1).ravel() >= 0.0
        extra = np.bincount(group, np.where(points, of_point, of_axis) * real, minlength=len(kept.limit))
        return bool((worst + extra <= kept.limit).all())

    def sentences(self, measures: Floats, language: str | None = None) -> list[str]:
        """What each constraint keeps, and within what."""
        return [one.sentence(float(m), language) for one, m in zip(self.constraints, measures, strict=True)]


@dataclass(frozen=True, eq=False, slots=True)
class Measured:
    """What is kept and how well, in words.

    Attributes:
        kept: the constraints.
        measures: (k,) of each of them.
    """

    kept: Kept
    measures: Floats

    @property
    def amounts(self) -> Floats:
        """(k,) the measures as angles [rad] or distances [m]."""
        return np.array([one.amount(float(m)) for one, m in zip(self.kept.constraints, self.measures, strict=True)])

    @property
    def holds(self) -> bool:
        """Whether each is within its limit."""
        return bool((self.measures <= self.kept.arrays.limit).all())

    def explain(self, language: str | None = None) -> str:
        """A clause for each constraint; loops that stay closed need none beside others."""
        every, limits = self.kept.sentences(self.measures, language), self.kept.arrays.limit
        some = [
            said for said, one, measure, limit in zip(every, self.kept.constraints, self.measures, limits, strict=True)
            if measure > limit or not isinstance(one, LoopClosed)
        ]  # fmt: skip
        return clauses(some or every, language)


def search_kept(
    checker: Checker, kept: Kept, q: JointVector, goals: JointVector, seed: int, seconds: float, nodes: int,
    shorten: int,
) -> tuple[JointVector | None, int, tuple[int, int, int]]:  # fmt: skip
    """RRT-Connect on what keeps the constraints, in slices; the path, the nodes, and what was looked at.

    1. Steering straight to a goal.
    2. Both sides grow; arrays double where they are full.
    3. Shorter chains.
    4. The proof once more, of the whole path.
    """
    shop, arrays = checker.workshop(), kept.arrays
    seen, random = np.zeros(3, np.int64), np.array([seed], np.uint64)
    ends = kept.measures(checker, np.concatenate([q[None], goals]))
    slack = SLACK if (ends <= 0.9 * SLACK * arrays.limit).all() else 1.0
    order = np.argsort(np.linalg.norm(goals - q, axis=1), kind="stable")
    if np.array_equal(goals[order[0]], q):
        return np.stack([q, q]), 1, (0, 0, 0)
    # 1.
    rows = kept_search_loops.steer_to_first_goal(shop, arrays, slack, q, np.ascontiguousarray(goals[order]), STEP, seen)
    made, path = 2, np.concatenate([q[None], rows])
    if not len(rows):
        # 2.
        forests = arm_search_loops.forests_of(q, goals, FIRST_NODES, random, seen)
        reach = REACH * float(np.linalg.norm(arrays.upper - arrays.lower))
        deadline = np.inf
        while (
            code := kept_search_loops.grow_kept(
                shop, arrays, slack, arrays.lower, arrays.upper, STEP, reach, SLICE, forests
            )
        ) != arm_search_loops.JOINED:
            made = int(forests.sizes[:2].sum())
            deadline = min(deadline, perf_counter() + seconds)
            if made >= nodes or perf_counter() > deadline:
                return None, made, _count(seen)
            if code == arm_search_loops.FULL:
                forests = arm_search_loops.double_forests(forests)
        made, path = int(forests.sizes[:2].sum()), forests.path[: forests.sizes[2]].copy()
    # 3.
    path = kept_search_loops.shorten_kept(shop, arrays, slack, path, STEP, shorten, random, seen)
    # 4.
    if not checker.check_path(path) or kept.along(checker, path[:-1], path[1:]) is None:
        return None, made, _count(seen)
    return path, made, _count(seen)


def _count(seen: NDArray[np.int64]) -> tuple[int, int, int]:
    looked_at, proved, states = (int(x) for x in seen)
    return looked_at, proved, states


TOLERANCE = 1e-3
"""How far the points of a loop may part between two points of a path [m]."""
AIM = 1e-7
"""Share of it to which points of a path close their loops."""
ROUNDED = 1e-6
"""How far the tip may be from a pose that is not met exactly [m, rad]: typed digits, where freedoms are few."""
KINDS = (JointKind.SPHERICAL, JointKind.REVOLUTE, JointKind.FIXED)
"""Joints that keep points of two links together, which is what a path can keep."""


def loop_constraints(mechanism: Mechanism, tolerance: float = TOLERANCE) -> tuple[LoopClosed, ...]:
    """Path constraints that keep the loops of a mechanism closed: coincident points of two links.

    A ball joint keeps one point, a hinge two on its axis, a fixed joint three. Between two configurations of a path
    they may part by the tolerance; at them they are closed to a ten-millionth of it.

    Args:
        mechanism: with loops, or without: then nothing.
        tolerance: [m].

    Raises:
        InputError: a loop is closed by another kind of joint.
    """
    tolerance = positive("tolerance", tolerance)
    lever = _lever(mechanism)
    kept: list[LoopClosed] = []
    for joint in mechanism.loops:
        if joint.kind not in KINDS:
            known = ", ".join(kind.value for kind in KINDS)
            raise InputError("planning.loop_kind", joint=joint.name, kind=joint.kind.value, known=known)
        kept += [_point(joint, lever * way, tolerance) for way in _ways(joint)]
    return tuple(kept)


def _ways(joint: Joint) -> Floats:
    """(k, 3) the joint's own place, and directions in which it keeps further points together."""
    if joint.kind is JointKind.FIXED:
        return np.eye(3) - np.eye(3)[2]
    return np.array([np.zeros(3), joint.axis])[: 1 if joint.kind is JointKind.SPHERICAL else 2]


def _point(joint: Joint, x: Floats, tolerance: float) -> LoopClosed:
    """A point given in the frame of a joint, on both of its links."""
    on_parent = joint.T_pj[:3, :3] @ x + joint.T_pj[:3, 3]
    return LoopClosed(joint.parent, joint.child, on_parent, x, tolerance, AIM)


def _lever(mechanism: Mechanism) -> float:
    """Distance of the second point of a hinge [m]: half the longest step from joint to joint."""
    lengths = [float(np.linalg.norm(joint.T_pj[:3, 3])) for joint in (*mechanism.joints, *mechanism.loops)]
    return 0.5 * max(lengths, default=0.0) or 1.0


def kept_loops_of(checker: Checker, q: JointVector) -> Kept | None:
    """What a path of an arm, or of several, keeps so that loops stay closed; None where there are none.

    Args:
        checker: the arm.
        q: (n,) a configuration of the path.
    """
    loops = loop_constraints(checker.robot.mechanism)
    return Kept(*kept_of(checker, loops, q, bounds_of(checker, q[None]))) if loops else None


def closed_near(robot: Robot, q: JointVector) -> JointVector:
    """(k, n) of configurations (m, n) those near them with closed loops and within the limits, found by a search."""
    if not robot.mechanism.loops:
        return q
    found = _chain_of(robot).close_loops(q)
    limits = robot.limits
    within = limits.within(found.q).all(axis=1)
    return np.asarray(found.q[found.found & within])


def require_tree(robot: Robot) -> None:
    """Refuse a robot with loops where straight motions would leave them open.

    Raises:
        InputError: it has loops.
    """
    if robot.mechanism.loops:
        raise InputError("planning.loops_left_open", robot=robot.name)


def closed_configurations(robot: Robot, poses: Floats, start: JointVector) -> JointVector:
    """(k, n) configurations with closed loops and the tip at one of some poses (m, 4, 4), within the limits.

    Args:
        robot: with loops.
        poses: of the tip in {s}.
        start: (n,) near which they should be.
    """
    chain = _chain_of(robot)
    rows = [np.zeros((0, chain.n))]
    for T in poses:
        found = parallel.closed_inverse_kinematics(chain, T, start)
        if not len(found):
            found = parallel.closed_inverse_kinematics(chain, T, start, tolerance=ROUNDED, rotation_tolerance=ROUNDED)
        rows.append(found.q[found.within])
    return np.concatenate(rows)


@lru_cache(maxsize=16)
def _chain_of(robot: Robot) -> ClosedChain:
    return parallel.ClosedChain(robot)
