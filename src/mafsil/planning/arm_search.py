"""RRT-Connect of an arm: the compiled search in slices, with the arrays of each thread kept for the next question.

The limbs of an arm whose tools can go back from where they are, for `retreat_loops`.
"""

from __future__ import annotations

from math import dist
from threading import local
from time import perf_counter
from typing import TYPE_CHECKING, TypeAlias
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import JointVector, Truth
from mafsil.lazy_module import lazily, load_module
from mafsil.planning.arm_limits import UNBOUNDED, Moving, rule_for
from mafsil.planning.problem import length_of

if TYPE_CHECKING:
    import mafsil.kernels.loops.loop as holding
    import mafsil.planning.arm_question_loops as arm_question_loops
    import mafsil.planning.arm_search_loops as arm_search_loops
    import mafsil.planning.retreat_loops as retreat_loops
    from mafsil.collision import Checker
    from mafsil.collision.layout import LaidArm
    from mafsil.kernels.loops.entry import Held
    from mafsil.planning.arm_question_loops import Question
    from mafsil.planning.arm_search_loops import Forests
    from mafsil.planning.retreat_loops import Limbs
else:
    arm_question_loops = lazily("mafsil.planning.arm_question_loops")
    arm_search_loops = lazily("mafsil.planning.arm_search_loops")
    holding = lazily("mafsil.kernels.loops.loop")
    retreat_loops = lazily("mafsil.planning.retreat_loops")


FEWEST = 2
"""Joints of a limb."""
FIRST_ROOM = 1024
"""Nodes of each side that there are arrays for at first."""
SLICE = 512
"""Samples between two looks at the clock."""
SECOND = 64
"""Samples of a second search."""
GLIMPSE = 4
"""One in so many of the tries shows how short a path will become."""
DETOUR = 1.2
"""How often as long as the straight motion a path may be before another one is looked for beside it."""
Searched: TypeAlias = tuple[JointVector | None, int, tuple[int, int, int]]
"""Path, nodes, (edges looked at, proofs, states)."""


class _OfThread(local):
    def __init__(self) -> None:
        self.forests: dict[int, Forests] = {}
        self.questions: WeakKeyDictionary[LaidArm, dict[Moving, Held[Question]]] = WeakKeyDictionary()


_OF_THREAD = _OfThread()


def search(
    checker: Checker, q: JointVector, goals: JointVector, seed: int, seconds: float, nodes: int, shorten: int,
    moving: Moving = None, leave: bool = True,
) -> Searched:  # fmt: skip
    """RRT-Connect, and its path made shorter or another one: shortcuts leave a path on its side of what it goes round.

    1. A path, for which the tools have gone back first; a few of the tries make it shorter.
    2. If it is a detour, another path is sought by few samples and without going back, and made shorter by as many
       tries.
    3. The shorter one gets the others.

    Args:
        checker, q, goals, seed, seconds, nodes, shorten, moving: as `plan` has them.
        leave: whether it begins with tools that go back, whatever the seed; else there is no second path.

    Returns:
        None in place of the path if there is none, or if an end cannot be, which leaves no nodes.
    """
    few = -(-shorten // GLIMPSE) if leave else shorten
    path, made, seen = _grown(checker, q, goals, seed, seconds, nodes, few, moving, leave)  # 1
    if few == shorten or path is None or len(path) < 3:
        return path, made, seen
    length = length_of(path)
    if length > DETOUR * dist(path[0], path[-1]):  # 2
        other, more, also = _grown(checker, q, goals, seed, 0.0, SECOND, few, moving, False)
        made, seen = made + more, add_counts(seen, also)
        if other is not None and length_of(other) < length:
            path = other
    random, counts = _question_for(checker, len(goals), moving).value.forests.random, np.zeros(3, np.int64)
    path = load_module(arm_question_loops).shorten(checker.workshop(), path, shorten - few, random, counts)  # 3
    return path, made, add_counts(seen, _count(counts))


def _grown(
    checker: Checker, q: JointVector, goals: JointVector, seed: int, seconds: float, nodes: int, shorten: int,
    moving: Moving, leave: bool,
) -> Searched:  # fmt: skip
    """RRT-Connect in compiled slices: the clock and an interruption are looked at between them. As `search`.

    1. A slice is one compiled call; the first also looks at the ends and tries straight motions, the last makes
       shortcuts.
    2. Arrays double where they are full. The clock starts after the first slice: a first call ever also waits for the
       compiler.
    """
    loops, workshop = load_module(arm_question_loops), checker.workshop()
    question = _question_for(checker, len(goals), moving)
    forests, deadline = question.value.forests, np.inf
    drawn = min(SLICE, nodes)
    code, path = loops.solve(workshop, question, q, goals, seed, 0, drawn, shorten, leave)  # 1
    if code == loops.REFUSED:
        return None, 0, (0, 0, 0)
    while code != loops.JOINED:
        made, now = _nodes(forests), perf_counter()
        deadline = min(deadline, now + seconds)
        if made >= nodes or now >= deadline:
            return None, made, _count(forests.seen)
        if code == loops.FULL:  # 2
            forests = arm_search_loops.double_forests(forests)
            question = holding.hold(question.value._replace(forests=forests))
        left = max(min(SLICE, nodes - made), 1)
        code, path = loops.solve(workshop, question, q, goals, seed, drawn, left, shorten, leave)
        drawn += left
    return path, _nodes(forests), _count(forests.seen)


def _question_for(checker: Checker, goals: int, moving: Moving) -> Held[Question]:
    """Where this thread searches for paths of an arm, with place for so many goals; kept for the next question."""
    of_arm = _OF_THREAD.questions.get(checker.laid)
    if of_arm is None:
        of_arm = _OF_THREAD.questions[checker.laid] = {}
    known = of_arm.get(moving)
    if known is None or known.value.forests.q.shape[1] < goals + 2:
        n, limits, rule = checker.robot.n, checker.robot.limits, rule_for(checker, moving)
        between = arm_question_loops.Limits(
            limits.lower.copy(), limits.upper.copy(), *rule, np.zeros(n, np.bool_), UNBOUNDED
        )
        forests, bounds, near = _forests_for(n, goals), np.empty((2, n)), np.empty((2, n))
        known = holding.hold(arm_question_loops.Question(between, forests, bounds, near, limbs_of(checker)))
        of_arm[moving] = known
    return known


def _forests_for(n: int, goals: int) -> Forests:
    """Arrays of this thread for a search, used again by the next one."""
    known = _OF_THREAD.forests
    if n not in known or known[n].q.shape[1] < goals + 2:
        ends, random = np.zeros((goals, n)), np.zeros(1, np.uint64)
        known[n] = arm_search_loops.forests_of(np.zeros(n), ends, FIRST_ROOM, random, np.zeros(3, np.int64))
    return known[n]


def _nodes(forests: Forests) -> int:
    of_start, of_goals, _ = forests.sizes.tolist()
    return of_start + of_goals


def _count(seen: NDArray[np.int64]) -> tuple[int, int, int]:
    looked_at, proved, states = seen.tolist()
    return looked_at, proved, states


def add_counts(a: tuple[int, int, int], b: tuple[int, int, int]) -> tuple[int, int, int]:
    """What was looked at by two searches."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def limbs_of(checker: Checker) -> Limbs:
    """The limbs of an arm with arrays to work in, for this thread.

    The longest chain of joints to a body is a limb; of the other chains, longest first, each that has more joints of
    its own than it shares with limbs before it. So are both arms of a torso, but not the fingers of a hand.
    """
    motion, mechanism = checker.laid.motion, checker.robot.mechanism
    n, taken = mechanism.n, np.zeros(len(motion.joints), np.bool_)
    parts: list[tuple[int, int, int, int, int]] = []
    own: list[Truth] = []
    reach: list[float] = []
    while (new := motion.moves & ~taken[:, None]).any():
        tool = int(new.sum(axis=0).argmax())
        chain, fresh = motion.moves[:, tool], new[:, tool]
        if fresh.sum() < FEWEST or 2 * fresh.sum() <= chain.sum():
            break
        taken |= chain
        far = _reach(checker, fresh, tool)
        if far == 0.0:
            continue
        parts.append(_parts(checker, chain, fresh, tool))
        own.append(np.isin(np.arange(n), motion.joints[fresh, 1]))
        reach.append(far)
    gravity = np.asarray(mechanism.gravity)
    up = -gravity / np.linalg.norm(gravity) if gravity.any() else np.zeros(3)
    rows, mine = np.array(parts, np.int64).reshape(-1, 5), np.array(own, np.bool_).reshape(len(parts), n)
    kinematics = checker.world().kinematics
    return retreat_loops.room_for(kinematics, motion.joints, rows, mine, np.array(reach, np.float64), up)


def _reach(checker: Checker, fresh: Truth, tool: int) -> float:
    """How far a limb reaches: from the axis of a hinge, and along its sliding joints as far as they have limits [m]."""
    motion, limits = checker.laid.motion, checker.robot.limits
    slides = motion.joints[fresh & (motion.joints[:, 3] == 0.0), 1].astype(np.int64)
    travel = (limits.upper - limits.lower)[np.unique(slides)]
    return float(motion.reach[fresh, tool].max() + travel[np.isfinite(travel)].sum())


def _parts(checker: Checker, chain: Truth, fresh: Truth, tool: int) -> tuple[int, int, int, int, int]:
    """A row of `Limbs.parts`.

    Args:
        checker: the arm.
        chain: (j,) the joints that move the tool.
        fresh: (j,) those of the limb.
        tool: index of its body.
    """
    motion = checker.laid.motion
    columns, hinges = motion.joints[:, 1].astype(np.int64), np.flatnonzero(fresh & (motion.joints[:, 3] == 1.0))
    if not len(hinges):
        return int(motion.last[tool]), tool, -1, -1, -1
    roll = int(hinges[-1])
    before = np.flatnonzero(~motion.moves[roll] & np.isin(motion.last, np.flatnonzero(chain)))
    nearest = int(before[motion.last[before].argmax()]) if len(before) else -1
    return int(motion.last[tool]), tool, nearest, int(columns[roll]), int(columns[hinges[0]])
