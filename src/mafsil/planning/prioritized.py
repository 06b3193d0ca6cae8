"""Several arms planned in turn: each avoids the timed motions of those before it, by waiting or another path."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from itertools import islice, pairwise, permutations
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, frozen, positive, whole
from mafsil.collision import MultiArmCell
from mafsil.errors import InputError
from mafsil.geometry import Pose
from mafsil.planning.arm_planning import configurations_of, plan
from mafsil.planning.arms_motion import ArmsMotion, TimedArm, unproved_moment
from mafsil.planning.kept_planning import Measured, closed_near, kept_loops_of
from mafsil.planning.outcome import PlanningStatus, Reason
from mafsil.planning.path_optimisation import round_corners
from mafsil.planning.waiting_places import RESTS, route_along, standing, timed_way
from mafsil.trajectory import JointPath, MotionLimits
from mafsil.trajectory.motion_limits import Limits, motion_limits
from mafsil.trajectory.splines import PiecewisePolynomial

MOST_ORDERS = 6
ASIDE = 8
"""Random places to step aside that are tried for an arm that finds no other way."""
APART = 0.003
"""Distance between arms beyond the clearance by which moments are chosen, so that the proof has room to spare [m].

Of what an arm keeps from itself and from the scene its path is the proof, at any moment."""
TRIES = 6
"""Times that a way that cannot be proved is looked for again."""
DIRECT = 3
"""Paths that are compared where more than one leads to the goal; further ones are only tried where none does."""
SEEDS = 4
SECONDS, NODES = 2.0, 5_000
"""Of the search of one path."""


def plan_prioritized(
    cell: MultiArmCell,
    start: Mapping[str, ArrayLike],
    goal: Mapping[str, ArrayLike | Pose],
    limits: Limits,
    *,
    order: tuple[str, ...] | None = None,
    seed: int = 0,
    seconds: float = 20.0,
) -> ArmsMotion:
    """A timed motion for each arm, one planned after the other: none is slowed for those after it.

    1. The first arm goes as if alone, but round the others at their starts where that is possible.
    2. Each further arm has paths that ignore the arms before it, that go round them at their goals or at their starts,
       and that step aside first. On each it moves from one place to rest to another in the shortest time within its
       limits, and waits: the earliest arrival on the grid of places and moments is taken.
    3. What was found is proved free at every moment, of all arms. Orders are tried one after the other.

    Not every problem that has an answer is solved in turn; `plan_coupled` searches all joints at once. Loops of
    mechanisms stay closed, as in `mf.plan`.

    Args:
        cell: the arms in their scene.
        start: for each arm (n of the arm) [rad | m].
        goal: for each arm a configuration, several of which any will do, or poses of its tip; an arm that is not named
            ends where it starts.
        limits: of all coordinates, in the order of the cell; velocities and accelerations are finite.
        order: of the turns; None tries up to six, the order of the cell first.
        seed: of the searches.
        seconds: after which it gives up.

    Raises:
        InputError: an unknown arm, a start that is missing, limits that do not fit or are infinite.

    Reference:
        M. Erdmann, T. Lozano-Perez, On multiple moving objects, Algorithmica 1987; K. Kant, S. Zucker, Toward
        efficient trajectory planning: the path-velocity decomposition, IJRR 1986.
    """
    begun = perf_counter()
    turns = _Turns(cell, start, goal, limits, whole("seed", seed), positive("seconds", seconds))
    blocked = turns.blocked_end()
    if blocked is not None:
        return turns.refuse(*blocked, perf_counter() - begun)
    if order is not None and sorted(order) != sorted(cell.names):
        raise InputError("planning.order", order=", ".join(order), known=", ".join(cell.names))
    orders = [order] if order is not None else list(islice(permutations(cell.names), MOST_ORDERS))
    failed = ""
    for each in orders:
        found, failed = turns.plan_in_order(each)
        if found is not None:
            return ArmsMotion(PlanningStatus.FOUND, cell, found, perf_counter() - begun)
    return ArmsMotion(PlanningStatus.NOT_FOUND, cell, {}, perf_counter() - begun, failed)


def plan_around_moving(
    cell: MultiArmCell,
    name: str,
    start: Mapping[str, ArrayLike],
    goal: ArrayLike | Pose,
    limits: Limits,
    others: Mapping[str, TimedArm],
    *,
    seed: int = 0,
    seconds: float = 20.0,
) -> ArmsMotion:
    """A timed motion of one arm past others whose motions are settled: a turn of `plan_prioritized` by itself.

    Args:
        cell: the arms in their scene.
        name: of the arm that is planned.
        start: for each arm (n of the arm) [rad | m]; of those that move, where they are at time 0.
        goal: of the arm that is planned, as for `plan_prioritized`.
        limits: of all coordinates; finite velocities and accelerations.
        others: motions of other arms from time 0 on; arms without one stand at their start.
        seed, seconds: as for `plan_prioritized`.

    Raises:
        InputError: an unknown arm, a start that is missing, limits that do not fit or are infinite.
    """
    begun = perf_counter()
    turns = _Turns(cell, start, {name: goal}, limits, whole("seed", seed), positive("seconds", seconds))
    ends = {each: motion.at(motion.duration) for each, motion in others.items()}
    blocked = turns.blocked_past(name, ends)
    if blocked is not None:
        return turns.refuse(*blocked, perf_counter() - begun)
    waiting = tuple(each for each in cell.names if each != name and each not in others)
    found = turns.turn(name, others, waiting)
    if found is None:
        reason = _no_turn(name, others)
        return ArmsMotion(PlanningStatus.NOT_FOUND, cell, {}, perf_counter() - begun, reason)
    still = {each: standing(turns.start[each], turns.limits[each]) for each in waiting}
    motions = {**others, **still, name: found}
    if unproved_moment(cell, motions, {}) is not None:
        reason = _no_turn(name, (*others, *waiting))
        return ArmsMotion(PlanningStatus.NOT_FOUND, cell, {}, perf_counter() - begun, reason)
    return ArmsMotion(PlanningStatus.FOUND, cell, motions, perf_counter() - begun)


class _Turns:
    """What all turns share: the arms, their ends and limits, the time that is left [s]."""

    def __init__(
        self, cell: MultiArmCell, start: Mapping[str, ArrayLike], goal: Mapping[str, ArrayLike | Pose], limits: Limits,
        seed: int, seconds: float,
    ) -> None:  # fmt: skip
        self.cell, self.seed, self.left = cell, seed, seconds
        self.warm = set[str]()
        self.start = cell.split(cell.join(start))
        for name in goal:
            cell.alone(name)
        self.goals = {
            name: configurations_of(cell.alone(name), goal[name], q) if name in goal else q[None]
            for name, q in self.start.items()
        }
        bounds = motion_limits(limits, cell.robot.n)
        if not (np.isfinite(bounds.velocity).all() and np.isfinite(bounds.acceleration).all()):
            raise InputError("planning.infinite_limits")
        self.limits = {name: _part(bounds, columns) for name, columns in cell.columns.items()}

    def blocked_end(self) -> tuple[PlanningStatus, JointVector] | None:
        """Starts at which something meets; goals are chosen so that all arms are free at them together."""
        start = self.cell.join(self.start)
        if not self.cell.free(start):
            return PlanningStatus.START_BLOCKED, start
        if self._gapes(start):
            return PlanningStatus.START_OFF, start
        chosen: dict[str, JointVector] = {}
        for name, rows in self.goals.items():
            if not len(rows):
                return PlanningStatus.UNREACHABLE, start
            near = rows[np.argsort(np.linalg.norm(rows - self.start[name], axis=1), kind="stable")]
            among = self.cell.among([*chosen, name])
            free = among.free(among.join({**self.start, **chosen, name: near}))
            if not np.any(free):
                return PlanningStatus.GOAL_BLOCKED, among.join({**self.start, **chosen, name: near[0]})
            closed = free & ~self._gapes(self.cell.join({**self.start, **chosen, name: near}))
            if not np.any(closed):
                return PlanningStatus.GOAL_OFF, self.cell.join({**self.start, **chosen, name: near[0]})
            chosen[name] = near[int(np.argmax(closed))]
        self.goal = chosen
        return None

    def blocked_past(self, name: str, ends: Mapping[str, JointVector]) -> tuple[PlanningStatus, JointVector] | None:
        """The start, or goals none of which is free when all others have arrived."""
        start = self.cell.join(self.start)
        if not self.cell.free(start):
            return PlanningStatus.START_BLOCKED, start
        if self._gapes(start):
            return PlanningStatus.START_OFF, start
        rows = self.goals[name]
        if not len(rows):
            return PlanningStatus.UNREACHABLE, start
        near = rows[np.argsort(np.linalg.norm(rows - self.start[name], axis=1), kind="stable")]
        q = self.cell.join({**self.start, **ends, name: near})
        free = np.asarray(self.cell.free(q))
        if not free.any():
            return PlanningStatus.GOAL_BLOCKED, q[0]
        closed = free & ~self._gapes(q)
        if not closed.any():
            return PlanningStatus.GOAL_OFF, q[0]
        self.goal = {**self.start, **ends, name: near[int(closed.argmax())]}
        return None

    def refuse(self, status: PlanningStatus, q: JointVector, seconds: float) -> ArmsMotion:
        """The answer where an end cannot be: what meets there, or by how much loops gape."""
        kept = kept_loops_of(self.cell, q)
        if kept is None or status not in (PlanningStatus.START_OFF, PlanningStatus.GOAL_OFF):
            return ArmsMotion(status, self.cell, seconds=seconds, ends=(self.cell.check(q),))
        reason = Reason(Measured(kept, kept.measures(self.cell, q[None])[0]))
        return ArmsMotion(status, self.cell, seconds=seconds, reason=reason)

    def _gapes(self, q: JointVector) -> NDArray[np.bool_]:
        """(*batch,) whether a loop gapes at configurations of all arms (*batch, n)."""
        rows = q.reshape(-1, q.shape[-1])
        kept = kept_loops_of(self.cell, rows[0])
        open_rows = np.zeros(len(rows), np.bool_) if kept is None else ~kept.holds(self.cell, rows)
        return open_rows.reshape(q.shape[:-1])

    def plan_in_order(self, order: tuple[str, ...]) -> tuple[dict[str, TimedArm] | None, str]:
        """Motions in an order of turns; else which arm found none."""
        motions: dict[str, TimedArm] = {}
        for k, name in enumerate(order):
            found = self.turn(name, motions, order[k + 1 :])
            if found is None:
                return None, _no_turn(name, order[:k])
            motions[name] = found
        # 3.
        if unproved_moment(self.cell, motions, {}) is not None:
            return None, _no_turn(order[0], order[1:])
        return motions, ""

    def turn(self, name: str, before: Mapping[str, TimedArm], after: tuple[str, ...]) -> TimedArm | None:
        """The motion of one arm among those planned; where it can be, it leaves those after it where they stand."""
        for waiting in dict.fromkeys((after, ())):
            counted = (*before, name, *waiting)
            fixed = {each: q for each, q in self.start.items() if each != name and each not in before}
            best: TimedArm | None = None
            for k, points in enumerate(self._paths(name, before, waiting)):
                if best is not None and (k >= DIRECT or self.left <= 0.0):
                    break
                begun = perf_counter()
                found = self._way(name, points, before, counted, fixed)
                self._spent("way", perf_counter() - begun)
                if found is not None and (best is None or found.duration < best.duration):
                    best = found
            if best is not None:
                return best
        return None

    def _spent(self, what: str, seconds: float) -> None:
        """Time that counts: the first of each kind does not, for a first call ever also waits for the compiler."""
        if what in self.warm:
            self.left -= seconds
        self.warm.add(what)

    def _way(
        self, name: str, points: JointVector, before: Mapping[str, TimedArm],
        counted: tuple[str, ...], fixed: Mapping[str, JointVector],
    ) -> TimedArm | None:  # fmt: skip
        """The earliest arrival along one path, proved."""
        among, between = self.cell.among(counted), self.cell.met_by_each_other(counted)
        horizon = max(0.0, *(each.duration for each in before.values())) if before else 0.0

        def is_free(q: JointVector, t: Floats, room: float = APART) -> NDArray[np.bool_]:
            places = {each: motion.at(t) for each, motion in before.items()}
            all_of_them = among.join({**fixed, **places, name: q})
            return np.asarray(between.with_clearance(among.clearance + room).free(all_of_them), dtype=np.bool_)

        ends = points[[0, -1]][:, self.cell.columns[name]]
        if not is_free(ends, np.array([0.0, horizon])).all():
            is_free = partial(is_free, room=0.0)

        def is_proved(motion: TimedArm) -> float | None:
            return unproved_moment(among, {**before, name: motion}, fixed)

        limits = self.limits[name]
        if len(points) == 1:
            still = standing(points[0, self.cell.columns[name]], limits)
            return still if is_proved(still) is None else None
        path = self._round(name, points)
        route = route_along(path, limits)
        return None if route is None else timed_way(route, is_free, horizon, TRIES, is_proved)

    def _round(self, name: str, points: JointVector) -> JointPath:
        """A path of one arm with corners rounded as far as the scene lets them, and breaks at which it may rest."""
        ways = np.linalg.norm(np.diff(points, axis=0), axis=1)
        counts = np.maximum(np.ceil(RESTS * ways / ways.sum()).astype(np.int64), 1)
        rows = [
            a + np.linspace(0.0, 1.0, int(count), endpoint=False)[:, None] * (b - a)
            for (a, b), count in zip(pairwise(points), counts, strict=True)
        ]
        alone = self.cell.among([name])
        full = round_corners(alone, np.concatenate([*rows, points[-1:]]), kept=kept_loops_of(alone, points[0])).curve
        columns = self.cell.columns[name]
        return JointPath(PiecewisePolynomial(full.knots, frozen(full.coefficients[:, :, columns])))

    def _paths(self, name: str, before: Mapping[str, TimedArm], waiting: tuple[str, ...]) -> Iterator[JointVector]:
        """(k, n) points of paths of one arm, in the coordinates of all, the most promising first (step 2).

        First to the goal, one for each way to count the others and each of SEEDS; then those that step aside.
        """
        q, goal = self.start[name], self.goal[name]
        at_goal = {each: self.goal[each] for each in before}
        nowhere: dict[str, JointVector] = {}
        places = [(nowhere, waiting)]
        if before:
            places += [(at_goal, (*before, *waiting)), (nowhere, (*before, *waiting))]
        if np.array_equal(q, goal):
            yield self.cell.join(self.start)[None]
        else:
            for seed in range(self.seed, self.seed + SEEDS):
                for there, counted in places:
                    path = self._points(name, there, counted, q, goal, seed)
                    if path is not None:
                        yield path
        if not before:
            return
        alone, rng = self.cell.alone(name), np.random.default_rng(self.seed)
        limits = alone.robot.limits
        aside = np.clip(q + rng.uniform(-1.0, 1.0, (16 * ASIDE, len(q))), limits.lower, limits.upper)
        aside = closed_near(alone.robot, aside)
        for there in aside[alone.free(aside)][:ASIDE]:
            first = self._points(name, {}, waiting, q, there, self.seed)
            second = self._points(name, at_goal, (*before, *waiting), there, goal, self.seed)
            if first is not None and second is not None:
                second = second.copy()
                for each in before:
                    second[:, self.cell.columns[each]] = first[-1, self.cell.columns[each]]
                yield np.concatenate([first, second[1:]])

    def _points(
        self, name: str, places: Mapping[str, JointVector], counted: tuple[str, ...], q: JointVector, goal: JointVector,
        seed: int,
    ) -> JointVector | None:  # fmt: skip
        """A path of one arm among some of the others, which stand still; None when the time is over, too."""
        if self.left <= 0.0:
            return None
        checker = self.cell.among([name, *counted], [name])
        a, b = (checker.join({**self.start, **places, name: end}) for end in (q, goal))
        found = plan(checker, None, a, b, seed=seed, seconds=min(SECONDS, self.left), max_nodes=NODES)
        self._spent("path", found.seconds)
        return found.path if found else None


def _no_turn(arm: str, past: Iterable[str]) -> Reason:
    """Which arm found no way past which others."""
    return Reason(("planning.no_turn", {"arm": arm, "past": ", ".join(past) or "-"}))


def _part(limits: MotionLimits, columns: slice) -> MotionLimits:
    """The limits of some of the coordinates."""
    fields = ("position", "velocity", "acceleration", "jerk", "effort")
    return MotionLimits(**{each: getattr(limits, each)[:, columns] for each in fields})
