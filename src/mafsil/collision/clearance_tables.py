"""Tables of how near two bodies come over the two coordinates between them, and balls that the bodies never leave.

Where a third moves them, as one that turns a hand about itself, a cell holds the least over all of its values.

From link to link, towards the base or away from it: what turns about an axis stays in a ball about the foot of the
ball's centre on the axis, larger by the centre's distance from it; what slides, in one larger by half of the way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import groupby
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.code_store import digest_of, kept_array
from mafsil.collision.arm_loops import Arm
from mafsil.collision.clearance_loops import SIDE, Clearances, lower_clearances
from mafsil.collision.joints import Joints
from mafsil.collision.piece_loops import HULL, POINT
from mafsil.collision.placing_loops import Motion
from mafsil.model import JointLimits, Mechanism

Ball: TypeAlias = tuple[Floats, float]
"""Centre (3,) and radius."""
MOST = 0.3
"""Distances beyond it are not told apart [m]."""
COARSEST = 0.06
"""Distance that a table may give away for the size of its cells and for coordinates that it does not have [m]."""
SLACK = 1e-6
"""Distance given away for what distances of hulls are inexact by [m]."""
GIVEN_FOR_THIRD = 0.02
"""Distance to give away for the values between those that a third coordinate is taken at [m]."""
LONGEST = 6000
"""What a cell of all tables may cost, in comparisons of balls: 0.1 to 0.4 s at the first question to an arm."""
EXACT, OF_HULLS = 30, 500
"""What a comparison of pieces costs, in comparisons of balls."""
USEFUL = 0.3
"""Share of cells of which a table has to know that the bodies are apart."""
OFTEN, OFTENER, SAMPLES = 0.05, 0.15, 200
"""Share of configurations in which the balls around two bodies meet that a table is worth, one that is taken at many
values of a third coordinate is worth, and of how many configurations."""
Poses: TypeAlias = Callable[[Floats], Iterator[tuple[int, Floats]]]
"""(m, n) -> link poses in parts, each with the index of its first."""
NearestInCells: TypeAlias = dict[tuple[object, ...], Floats]
"""(SIDE^2,) distances of pairs of bodies at the middles of cells, 32 kB each, by what they depend on."""


@dataclass(frozen=True, slots=True)
class _Plan:
    """How a pair is put into a table.

    Attributes:
        columns: of the two coordinates; equal where there is one.
        third: a coordinate whose values all count, at `turns` of them; -1 for none.
        others: coordinates that are taken at their middle.
        pair: row of the arm's pairs.
        loss: what its distances give away [m].
    """

    columns: tuple[int, int]
    third: int
    turns: int
    others: tuple[int, ...]
    pair: int
    loss: float

    @property
    def of_table(self) -> tuple[tuple[int, int], int, tuple[int, ...]]:
        """What the pairs of a table have in common."""
        return self.columns, self.third, self.others


def clearances_of(
    arm: Arm, motion: Motion, regions: Regions, limits: JointLimits, poses: Poses, nearest: NearestInCells, basis: str
) -> Clearances:
    """Tables for the pairs of an arm that two coordinates decide.

    1. Pairs whose balls meet often, the most often first, as long as that costs little: to others balls are enough.
    2. Pairs are put together that the same coordinates decide.
    3. At the middle of each cell the distances of a table's pairs, less how far the bodies can come nearer in the cell.

    Args:
        arm, motion: as the compiled loops read them.
        regions: where the bodies can be within the limits.
        limits: of the coordinates; where they are infinite, only those of hinges have a table.
        poses: of configurations.
        nearest: what is known already of pairs of the same bodies, in and out.
        basis: digest of all else that distances at configurations follow from: the joints, the code.
    """
    grid, size, plans, cost = _Grid(motion, regions, limits), SIDE * SIDE, list[_Plan](), 0
    for k, share in _often_near(arm, poses, grid.samples()):  # 1
        plan = grid.plan(arm, k, share >= OFTENER)
        if plan is not None and cost + plan.turns * _cost(arm, *arm.pairs[k]) <= LONGEST:
            plans.append(plan)
            cost += plan.turns * _cost(arm, *arm.pairs[k])
    plans.sort(key=lambda plan: (*plan.of_table, plan.pair))
    groups = [list(alike) for _, alike in groupby(plans, key=lambda plan: plan.of_table)]  # 2
    known = Clearances(
        np.full(len(arm.pairs), -1), np.zeros(len(arm.pairs), np.int64), np.zeros((len(groups), 2, 4)),
        np.zeros((len(groups), len(limits.lower), 2)), np.zeros((len(groups), 2), np.int64),
        np.empty(size * len(plans)),
    )  # fmt: skip
    begin = 0
    for t, group in enumerate(groups):
        pairs, (first, second) = np.array([plan.pair for plan in group]), group[0].columns
        known.table[pairs], known.slot[pairs] = t, np.arange(len(pairs))
        known.axes[t], known.span[t] = grid.axes[[first, second]], grid.span(group[0])
        known.axes[t, 1, 2] *= first != second
        known.cells[t] = begin, len(pairs)
        found = known.values[begin : begin + size * len(pairs)].reshape(size, len(pairs))
        _look_at_cells(arm, grid, group, poses, nearest, basis)  # 3
        for slot, plan in enumerate(group):
            found[:, slot] = nearest[_key(arm, plan, group)] - plan.loss
        known.table[pairs[(found > 0.0).mean(axis=0) < USEFUL]] = -1
        begin += found.size
    return known


def _key(arm: Arm, plan: _Plan, group: list[_Plan]) -> tuple[object, ...]:
    """What the distances of a pair in the cells of its table depend on, of arms with the same bodies."""
    a, b = arm.pairs[plan.pair].tolist()
    return a, b, plan.of_table, max(each.turns for each in group)


def _look_at_cells(
    arm: Arm, grid: _Grid, group: list[_Plan], poses: Poses, nearest: NearestInCells, basis: str
) -> None:  # fmt: skip
    """The distances at the middles of all cells, of the pairs of a table of which they are not known."""
    missing = [plan for plan in group if _key(arm, plan, group) not in nearest]
    if not missing:
        return

    def measure() -> Floats:
        pairs, found = np.array([plan.pair for plan in missing]), np.full((SIDE * SIDE, len(missing)), MOST)
        for third in grid.values(group):
            for row, some in poses(grid.middles(group[0], third)):
                lower_clearances(arm, some, pairs, found[row : row + len(some)])
        return found

    keys = [_key(arm, plan, group) for plan in missing]
    content = *arm.pieces, arm.bodies, grid.axes, grid.lower, grid.upper
    found = kept_array(digest_of("clearances", basis, repr(keys), *content), measure)
    for column, key in zip(found.T, keys, strict=True):
        nearest[key] = column.copy()


class _Grid:
    """The cells along each coordinate.

    Attributes:
        axes: (n, 4) as in `Clearances`.
    """

    def __init__(self, motion: Motion, regions: Regions, limits: JointLimits) -> None:
        self.motion, self.regions, joints = motion, regions, motion.joints
        lower, upper = limits.lower.copy(), limits.upper.copy()
        whole = np.array([
            all(joints[j, 3] != 0.0 and joints[j, 4] == 0.0 and abs(joints[j, 2]) == 1.0
                for j in np.flatnonzero(joints[:, 1] == c)) for c in range(len(lower))
        ], np.bool_)  # fmt: skip
        turns = whole & ~(upper - lower < 2 * np.pi)
        lower[turns], upper[turns] = -np.pi, np.pi
        self.known = np.isfinite(lower) & np.isfinite(upper) & (upper > lower)
        self.lower, self.upper = np.where(self.known, lower, 0.0), np.where(self.known, upper, 0.0)
        scale = SIDE / np.where(self.known, self.upper - self.lower, 1.0)
        self.axes = np.column_stack([np.arange(len(lower)), self.lower, scale, turns])

    def samples(self) -> Floats:
        """(SAMPLES, n) configurations, anywhere."""
        return np.random.default_rng(0).uniform(self.lower, self.upper, (SAMPLES, len(self.lower)))

    def plan(self, arm: Arm, k: int, often: bool) -> _Plan | None:
        """How pair k is put into a table, with a third coordinate if it is often near; None if it is not."""
        moved = np.flatnonzero(self.motion.moves[:, arm.pairs[k, 0]] ^ self.motion.moves[:, arm.pairs[k, 1]])
        columns = np.unique(self.motion.joints[moved, 1].astype(np.int64))
        if not len(columns) or not self.known[columns].all():
            return None
        way = self._ways(arm, moved, k)
        order = sorted((int(c) for c in columns), key=lambda c: -way[c])
        first, third, others, turns = sorted(order[:2]), -1, order[2:], 1
        if often and way[others].sum() > GIVEN_FOR_THIRD:
            third, others, turns = others[0], others[1:], max(1, int(np.ceil(way[others[0]] / GIVEN_FOR_THIRD)))
        loss = float(way[first].sum() / SIDE + way[third] / turns * (third >= 0) + way[others].sum()) + SLACK
        return (
            None if not loss <= COARSEST else _Plan((first[0], first[-1]), third, turns, tuple(sorted(others)), k, loss)
        )

    def _ways(self, arm: Arm, moved: NDArray[np.int64], k: int) -> Floats:
        """(n,) how far half of what a coordinate can do moves one body of pair k, seen from the other, at most.

        A hinge moves either as seen from the other: the one that stays nearer to its axis says how far.
        """
        way, (a, b) = np.zeros(len(self.lower)), arm.pairs[k]
        for j in moved:
            row = self.motion.joints[j]
            lever = min(self.regions.lever(j, a), self.regions.lever(j, b)) + row[4] if row[3] != 0.0 else 1.0
            way[int(row[1])] += abs(row[2]) * lever
        return way * (self.upper - self.lower) / 2

    def values(self, group: list[_Plan]) -> list[float]:
        """Of the third coordinate of a table."""
        third, turns = group[0].third, max(plan.turns for plan in group)
        lower, upper = self.lower[third], self.upper[third]
        return [lower + (upper - lower) * (m + 0.5) / turns for m in range(turns)] if third >= 0 else [0.0]

    def middles(self, plan: _Plan, third: float) -> Floats:
        """(SIDE^2, n) configurations at the middles of the cells."""
        rows = np.tile((self.lower + self.upper) / 2, (SIDE * SIDE, 1))
        first, second = np.divmod(np.arange(SIDE * SIDE), SIDE)
        a, b = plan.columns
        if plan.third >= 0:
            rows[:, plan.third] = third
        rows[:, b] = self.lower[b] + (second + 0.5) / self.axes[b, 2]
        rows[:, a] = self.lower[a] + (first + 0.5) / self.axes[a, 2]
        return rows

    def span(self, plan: _Plan) -> Floats:
        """(n, 2) between which coordinates that are no axes of a table have to lie."""
        span = np.full((len(self.lower), 2), [-np.inf, np.inf])
        for c in (plan.third, *plan.others):
            if c >= 0 and (c != plan.third or self.axes[c, 3] == 0.0):
                span[c] = self.lower[c], self.upper[c]
        return span


def _often_near(arm: Arm, poses: Poses, q: Floats) -> list[tuple[int, float]]:
    """The pairs whose balls meet often at some configurations, the most often first; in which share of them."""
    if not len(arm.pairs):
        return []
    links, counts = arm.bodies[:, 0].astype(np.int64), np.zeros(len(arm.pairs), np.int64)
    reach = arm.bodies[arm.pairs[:, 0], 7] + arm.bodies[arm.pairs[:, 1], 7]
    for _, some in poses(q):
        at = some[:, links]
        centres = (at[..., :3, :3] @ arm.bodies[:, 4:7, None])[..., 0] + at[..., :3, 3]
        away = np.linalg.norm(centres[:, arm.pairs[:, 0]] - centres[:, arm.pairs[:, 1]], axis=2)
        counts += (away <= reach).sum(axis=0)
    order, shares = np.argsort(-counts, kind="stable"), counts / len(q)
    return [(int(k), float(shares[k])) for k in order if shares[k] >= OFTEN]


def _cost(arm: Arm, a: int, b: int) -> int:
    """What the distance of two bodies costs, in comparisons of balls."""
    kinds = [arm.pieces.rows[int(arm.bodies[c, 1]) : int(arm.bodies[c, 2]), 0] for c in (a, b)]
    balls, hulls = ([int((each == kind).sum()) for each in kinds] for kind in (POINT, HULL))
    total, plain = len(kinds[0]) * len(kinds[1]), (len(kinds[0]) - hulls[0]) * (len(kinds[1]) - hulls[1])
    return OF_HULLS * (total - plain) + EXACT * (plain - balls[0] * balls[1]) + balls[0] * balls[1]


class Regions:
    """Where the bodies of an arm can be.

    Args:
        mechanism, joints, arm: the arm.
        lower, upper: (n,) ends of the coordinates of sliding joints; hinges may turn as they like.
    """

    def __init__(self, mechanism: Mechanism, joints: Joints, arm: Arm, lower: Floats, upper: Floats) -> None:
        self._mechanism, self._joints, self._arm = mechanism, joints, arm
        self._ends = lower, upper
        self._of_link = {int(link): j for j, link in enumerate(joints.link)}
        self._above: list[set[int]] = [{0}]
        for link, parent in enumerate(mechanism.parents, start=1):
            self._above.append(self._above[parent] | {link})
        self._known: dict[tuple[int, int], Ball] = {}

    def in_space(self) -> Floats:
        """(b, 4) for each body a ball in {s} that it never leaves."""
        T, found = self._mechanism.T_sb, np.empty((len(self._arm.bodies), 4))
        for b in range(len(found)):
            centre, radius = self.ball(b, 0)
            found[b] = *(T[:3, :3] @ centre + T[:3, 3]), radius
        return found

    def levers(self) -> Floats:
        """(j, b) how far any point of a body gets from the axis of a hinge that moves it; zero elsewhere."""
        joints, links = self._joints, self._arm.bodies[:, 0].astype(np.int64)
        found = np.zeros((len(joints.link), len(links)))
        for j, screw in enumerate(joints.screw):
            for b, link in enumerate(links):
                if screw[:3].any() and joints.moves[j, link]:
                    found[j, b] = self.lever(j, b)
        return found

    def lever(self, j: int, b: int) -> float:
        """How far any point of body b gets from the axis of hinge j, whether that moves it or not."""
        link, axis = int(self._joints.link[j]), self._joints.screw[j, :3]
        carried = self._joints.moves[j, int(self._arm.bodies[b, 0])]
        centre, radius = self.ball(b, link) if carried else self._into(b, link)
        return float(np.linalg.norm(centre - axis * (axis @ centre))) + radius

    def ball(self, b: int, link: int) -> Ball:
        """Where body b stays as link sees it."""
        if (b, link) not in self._known:
            self._known[b, link] = self._from_neighbour(b, link)
        return self._known[b, link]

    def _from_neighbour(self, b: int, link: int) -> Ball:
        row, parents = self._arm.bodies[b], self._mechanism.parents
        own = int(row[0])
        if own == link:
            return row[4:7], float(row[7])
        if link not in self._above[own]:
            return self._sweep(self._into(b, link), link, -1.0)
        child = own
        while parents[child - 1] != link:
            child = parents[child - 1]
        T = self._mechanism.joints[child - 1].T_pj
        centre, radius = self._sweep(self.ball(b, child), child, 1.0)
        return T[:3, :3] @ centre + T[:3, 3], radius

    def _into(self, b: int, link: int) -> Ball:
        """Where body b stays as the joint frame of a link sees it, which that joint does not move."""
        T = self._mechanism.joints[link - 1].T_pj
        centre, radius = self.ball(b, self._mechanism.parents[link - 1])
        return T[:3, :3].T @ (centre - T[:3, 3]), radius

    def _sweep(self, ball: Ball, link: int, direction: float) -> Ball:
        """What a ball sweeps while the joint of a link moves it, or moves backwards what sees it."""
        if link not in self._of_link:
            return ball
        j, joints, (centre, radius) = self._of_link[link], self._joints, ball
        axis, along = joints.screw[j, :3], joints.screw[j, 3:]
        foot = axis * (axis @ centre) if axis.any() else centre
        radius += float(np.linalg.norm(centre - foot))
        if along.any():
            mimic = self._mechanism.joints[link - 1].mimic
            ends = np.array([end[joints.column[j]] for end in self._ends])
            ends = (joints.factor[j] * ends if joints.factor[j] else 0.0 * np.sign(ends)) + (
                0.0 if mimic is None else mimic.offset
            )
            middle = ends.mean() if np.isfinite(ends).all() else 0.0
            foot = foot + direction * middle * along
            radius += float(np.abs(ends - middle).max() * np.linalg.norm(along))
        return foot, radius
