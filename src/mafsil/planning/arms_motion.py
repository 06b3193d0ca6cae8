"""Several arms planned at once, and how planning in time ended: motions proved free of each other, or why none.

That a motion in time is free at every moment is proved by chords that keep clear of what lies between.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise, product
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer
from mafsil.arrays import Floats, JointVector
from mafsil.collision import Checker, Clearance, CollisionCheck, MultiArmCell
from mafsil.geometry import Pose
from mafsil.messages import say
from mafsil.planning.arm_plan import ArmPlan
from mafsil.planning.arm_planning import configurations_of, plan
from mafsil.planning.outcome import PlanningStatus, reason_text
from mafsil.trajectory import Trajectory

MOST_GOALS = 256
"""Combinations of the arms' goals that are tried, the nearest to the start first."""
CHORD = 0.05
"""Largest change of a coordinate over a chord at first [rad | m]."""
HALVINGS = 6
"""How often a chord that cannot be proved is halved."""
Places: TypeAlias = Callable[[Floats], Floats]
"""(k,) moments [s] -> (k, n) coordinates."""


@dataclass(frozen=True, eq=False, slots=True)
class TimedArm:
    """The timed motion of one arm, with waits.

    Attributes:
        parts: its motions, rests among them, one after the other.
        starts: (k + 1,) when they begin, and the end [s].
        rests: (k,) whether a part is a rest.
        acceleration: (n,) largest magnitudes while it moves.
    """

    parts: tuple[Trajectory, ...]
    starts: Floats
    rests: tuple[bool, ...]
    acceleration: Floats

    @property
    def duration(self) -> float:
        """When it has arrived [s]."""
        return float(self.starts[-1])

    @property
    def waiting(self) -> float:
        """How long it rests before it arrives [s]."""
        return float(np.diff(self.starts)[np.array(self.rests, dtype=np.bool_)].sum())

    def at(self, t: ArrayLike) -> JointVector:
        """(*times, n) coordinates at times (*times) [s]; at its ends before and after."""
        moments = np.asarray(t, dtype=np.float64)
        which = np.clip(np.searchsorted(self.starts, moments, side="right") - 1, 0, len(self.parts) - 1)
        out = np.empty((*moments.shape, len(self.acceleration)))
        present: list[int] = np.unique(which).tolist()
        for k in present:
            here, part = which == k, self.parts[k]
            out[here] = part.at(np.clip(moments[here] - self.starts[k], 0.0, part.duration)).u
        return out

    def later(self, begin: float) -> TimedArm:
        """The same with a clock that starts at a moment of it [s]; parts before it begin at negative times."""
        return TimedArm(self.parts, self.starts - begin, self.rests, self.acceleration)

    def then(self, other: TimedArm) -> TimedArm:
        """This one, and another that begins when this one ends."""
        starts = np.concatenate([self.starts, self.duration + other.starts[1:]])
        return TimedArm((*self.parts, *other.parts), starts, (*self.rests, *other.rests), self.acceleration)

    def is_moving(self, begin: float, end: float) -> bool:
        """Whether it moves at any time between two moments [s]."""
        moving = ~np.array(self.rests, dtype=np.bool_)
        return bool(np.any(moving & (self.starts[:-1] < end) & (self.starts[1:] > begin)))


@dataclass(frozen=True, eq=False, repr=False)
class ArmsMotion(Answer):
    """A timed motion for each of several arms, verified collision-free at every time; or why there is none.

    Attributes:
        status: how it ended.
        cell: the arms in their scene.
        motions: of each arm that was planned, in the order of the turns.
        seconds: that it took.
        reason: which arm found no way past which others, where that is the end.
        ends: what the arms meet at the start or at the goals, where that is the reason.
    """

    status: PlanningStatus
    cell: MultiArmCell
    motions: Mapping[str, TimedArm] = field(default_factory=dict[str, TimedArm])
    seconds: float = 0.0
    reason: str = ""
    ends: tuple[CollisionCheck, ...] = ()

    @property
    def duration(self) -> float:
        """Until all have arrived; infinite where there is no motion [s]."""
        return max((each.duration for each in self.motions.values()), default=0.0) if self else np.inf

    def at(self, t: ArrayLike) -> JointVector:
        """(*times, n) coordinates of all arms at times (*times) [s]."""
        return self.cell.join({name: motion.at(t) for name, motion in self.motions.items()})

    def clearance(self, count: int = 200) -> Clearance:
        """Smallest distances at moments evenly over the motion.

        Args:
            count: how many moments.
        """
        return self.cell.distance(self.at(np.linspace(0.0, self.duration, count)))

    def explain(self, language: str | None = None) -> str:
        """The status; when each arm arrives and how long it waits, or what stands in the way."""
        reason = reason_text(self.reason, language)
        first = self.status.sentence(language) + (f" ({reason})" if reason else "")
        lines = [first] + [
            say(
                "planning.arm_arrives", language=language, arm=name, duration=each.duration, waiting=each.waiting
            )
            for name, each in self.motions.items()
        ]  # fmt: skip
        return "\n".join([*lines, *(check.explain(language) for check in self.ends)])

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        each = {name: {"duration": motion.duration, "waiting": motion.waiting} for name, motion in self.motions.items()}
        return {"status": self.status.name.lower(), "duration": self.duration, "reason": self.reason, "arms": each}


def unproved_moment(
    cell: MultiArmCell, motions: Mapping[str, TimedArm], fixed: Mapping[str, JointVector]
) -> float | None:
    """The earliest moment from which motions are not proved to be free of each other and the scene; None if all are.

    Args:
        cell: the arms that count.
        motions: of some of them.
        fixed: (n of the arm) coordinates of the others, which stand still.
    """
    breaks = np.unique(np.concatenate([[0.0], *(np.maximum(each.starts, 0.0) for each in motions.values())]))
    accelerations = np.zeros((len(breaks) - 1, cell.robot.n))
    for name, motion in motions.items():
        for m, (begin, end) in enumerate(pairwise(breaks)):
            if motion.is_moving(float(begin), float(end)):
                accelerations[m, cell.columns[name]] = motion.acceleration

    def places(t: Floats) -> Floats:
        return cell.join({**fixed, **{name: motion.at(t) for name, motion in motions.items()}})

    return first_unproved(cell, places, breaks, accelerations)


def first_unproved(checker: Checker, places: Places, breaks: Floats, accelerations: Floats) -> float | None:
    """The earliest moment from which a motion is not proved to keep more than the clearance; None if all of it is.

    1. Chords between the breaks and moments between which no coordinate moves by much more than CHORD.
    2. Over a chord of h seconds a coordinate leaves the straight line by no more than h^2 / 8 times its largest
       acceleration: the line is proved with a clearance larger by all that two bodies can move by so much.
    3. Chords that cannot be proved are halved, HALVINGS times.

    Args:
        checker: what has to be free.
        places: the motion; its velocity may jump nowhere.
        breaks: (m + 1,) moments between which the bounds of the acceleration hold [s].
        accelerations: (m, n) largest magnitudes between them; zero for a coordinate that rests [rad/s^2 | m/s^2].
    """
    for m, (first, last) in enumerate(pairwise(breaks)):
        t = _chords(places, float(first), float(last))  # 1
        for begin, end in pairwise(t):
            spans = [(float(begin), float(end), 0)]
            while spans:
                a, b, halved = spans.pop()
                if _is_proved(checker, places(np.array([a, b])), accelerations[m] * (b - a) ** 2 / 8.0):  # 2
                    continue
                if halved == HALVINGS:
                    return a
                middle = (a + b) / 2.0  # 3
                spans += [(middle, b, halved + 1), (a, middle, halved + 1)]
    return None


def _chords(places: Places, begin: float, end: float) -> Floats:
    """Moments from begin to end between which coordinates move by about CHORD."""
    t = np.linspace(begin, end, max(int((end - begin) / 0.01), 1) + 1)
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(places(t), axis=0)).max(axis=1, initial=0.0))])
    chosen = np.unique((way / CHORD).astype(np.int64), return_index=True)[1]
    return np.union1d(t[chosen], [begin, end])


def _is_proved(checker: Checker, ends: Floats, apart: Floats) -> bool:
    extra = checker.largest_way(apart, np.abs(ends).max(axis=0) + apart)
    return bool(checker.free_segment(ends[0], ends[1], extra=2.0 * extra))


def plan_coupled(
    cell: MultiArmCell,
    start: Mapping[str, ArrayLike],
    goal: Mapping[str, ArrayLike | Pose],
    *,
    planner: str = "rrt_connect",
    seed: int = 0,
    seconds: float = 10.0,
    max_nodes: int = 200_000,
    shortcut_iterations: int = 100,
) -> ArmPlan:
    """A path of all arms at once, each straight motion of all their joints proved free.

    Any arm may move, also one that ends where it starts: it makes way. Of poses all solutions of the inverse kinematics
    that are free without the other arms are combined. Loops of mechanisms stay closed, as in `mf.plan`.

    Args:
        cell: the arms in their scene.
        start: for each arm (n of the arm) [rad | m].
        goal: for each arm its configuration, several of which any will do, or poses of its tip, as for `mf.plan`;
            an arm that is not named ends where it starts.
        planner, seed, seconds, max_nodes, shortcut_iterations: as for `mf.plan`.

    Returns:
        Rows of the path are coordinates of all arms: `cell.split(plan.path)` has those of each.

    Raises:
        InputError: an unknown arm, a start that is missing, a wrong shape.
    """
    q = cell.join(start)
    goals = _combine(cell, cell.split(q), goal)
    return plan(
        cell, None, q, goals, planner=planner, seed=seed, seconds=seconds, max_nodes=max_nodes,
        shortcut_iterations=shortcut_iterations,
    )  # fmt: skip


def _combine(cell: MultiArmCell, start: Mapping[str, JointVector], goal: Mapping[str, ArrayLike | Pose]) -> JointVector:
    """(k, n) goals of all arms, the nearest to the start first."""
    for name in goal:
        cell.alone(name)
    each = [
        configurations_of(cell.alone(name), goal[name], q) if name in goal else q[None] for name, q in start.items()
    ]
    open_rows = [_open(cell, name, rows) for name, rows in zip(cell.names, each, strict=True)]
    away = [np.linalg.norm(rows - q, axis=1) for rows, q in zip(open_rows, start.values(), strict=True)]
    sorted_rows = [rows[np.argsort(far, kind="stable")] for rows, far in zip(open_rows, away, strict=True)]
    per_arm = max(int(MOST_GOALS ** (1.0 / len(cell.names))), 1)
    rows = [np.concatenate(parts) for parts in product(*(rows[:per_arm] for rows in sorted_rows))]
    return np.stack(rows) if rows else np.zeros((0, cell.robot.n))


def _open(cell: MultiArmCell, name: str, rows: JointVector) -> JointVector:
    """Of some configurations of one arm those that are free without the others; all if none is, so that it is said."""
    free = cell.alone(name).free(rows) if len(rows) else np.zeros(0, np.bool_)
    return rows[free] if np.any(free) else rows
