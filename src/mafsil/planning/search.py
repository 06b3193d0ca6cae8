"""Sampling planners: RRT-Connect, PRM, and RRT* in the ellipsoid of what is still better. A planner is a function.

A planner gets the problem, the start, the goals and what it may use, and gives the best path that it found, or None,
and how many nodes it made; one row of `PLANNERS` makes it known everywhere.

A tree of configurations that grows, with the nearest node found at once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import pairwise
from time import perf_counter
from typing import TypeAlias

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.planning.outcome import best_kept
from mafsil.planning.problem import Problem, length_of

STEP = 0.15
"""Longest edge of a tree that grows, as share of the diagonal of the bounds."""
GOAL_BIAS = 0.05
"""Share of the samples of RRT* that are goals."""
NEIGHBOURS = 12
"""Of a configuration in a roadmap."""
ROADMAP = 200
"""Configurations by which a roadmap grows at a time."""


@dataclass(frozen=True, slots=True)
class SearchBudget:
    """Limits of a search; equal seeds give equal searches unless time ends them.

    Attributes:
        rng: source of samples.
        deadline: end of the time [s of perf_counter].
        nodes: most that it may make.
    """

    rng: np.random.Generator
    deadline: float
    nodes: int

    def left(self, nodes: int) -> bool:
        """Whether it may go on."""
        return nodes < self.nodes and perf_counter() < self.deadline


Planner: TypeAlias = Callable[[Problem, JointVector, JointVector, SearchBudget], tuple[JointVector | None, int]]
"""(problem, start (n,), goals (k, n), budget) -> path (m, n) or None, and how many nodes there are."""


def rrt_connect(
    problem: Problem, start: JointVector, goals: JointVector, budget: SearchBudget
) -> tuple[JointVector | None, int]:
    """Two trees, one from the start and one from the goals, that grow towards each other.

    1. The one tree goes one step towards a sample, from its nearest node.
    2. The other one goes step by step towards the new node, as far as it is free. If it arrives, the path is found.
    3. They change roles.

    Args:
        problem: what is free.
        start: (n,).
        goals: (k, n).
        budget: for samples and nodes.

    Reference: Kuffner and LaValle, RRT-Connect, ICRA 2000.
    """
    step = STEP * float(np.linalg.norm(problem.upper - problem.lower))
    for goal in goals:
        if problem.is_free_segment(start, goal):
            return np.stack([start, goal]), 2
    forest = [[Tree(start)], [Tree(goal) for goal in goals]]
    nodes, side = 1 + len(goals), 0
    while budget.left(nodes):
        # 1.
        sample = problem.sample(budget.rng, 1)[0]
        ours = min(forest[side], key=lambda tree: float(np.linalg.norm(tree.q[tree.nearest(sample)] - sample)))
        new = _grown(problem, ours, sample, step)
        if new is not None:
            nodes += 1
            target = ours.q[new].copy()
            # 2.
            for theirs in forest[1 - side]:
                reached = _grown(problem, theirs, target, step)
                while reached is not None and not np.array_equal(theirs.q[reached], target) and budget.left(nodes):
                    nodes += 1
                    reached = _grown(problem, theirs, target, step, reached)
                if reached is not None and np.array_equal(theirs.q[reached], target):
                    ways = [ours.way(new), theirs.way(reached)[-2::-1]]
                    path = np.concatenate(ways)
                    return (path if side == 0 else path[::-1]), nodes
        # 3.
        side = 1 - side
    return None, nodes


def _grown(problem: Problem, tree: Tree, target: JointVector, step: float, origin: int | None = None) -> int | None:
    """The node one step towards a target, or at it; None if the way is blocked."""
    node = tree.nearest(target) if origin is None else origin
    way = target - tree.q[node]
    distance = float(np.linalg.norm(way))
    new = target if distance <= step else tree.q[node] + way * (step / distance)
    if distance == 0.0 or not problem.is_free_segment(tree.q[node].copy(), new):
        return None
    return tree.add(new, node)


def prm(
    problem: Problem, start: JointVector, goals: JointVector, budget: SearchBudget
) -> tuple[JointVector | None, int]:
    """A roadmap of random configurations, whose edges are looked at only when a shortest path wants them.

    1. Free configurations are added, each joined to its nearest ones.
    2. The shortest path by A*; its first edge that is blocked is removed, until a path is free or there is none.
    3. Again, with more configurations.

    Args:
        problem: what is free.
        start: (n,).
        goals: (k, n).
        budget: for samples and nodes.

    Reference: Bohlin and Kavraki, Path planning using lazy PRM, ICRA 2000.
    """
    q = np.concatenate([start[None], goals])
    ends = set(range(1, len(q)))
    blocked: set[tuple[int, int]] = set()
    while budget.left(len(q)):
        # 1.
        some = problem.sample(budget.rng, ROADMAP)
        q = np.concatenate([q, some[problem.is_free(some)]])
        edges = _neighbours(q)
        # 2.
        while (way := shortest_way(q, edges, 0, ends, blocked)) is not None:
            first = next(
                ((a, b) for a, b in pairwise(way) if not problem.is_free_segment(q[a], q[b])),
                None,
            )
            if first is None:
                return q[way], len(q)
            blocked |= {first, (first[1], first[0])}
            if not budget.left(0):
                return None, len(q)
    return None, len(q)


def _neighbours(q: JointVector) -> list[set[int]]:
    """The nearest ones of each configuration, in both directions."""
    edges: list[set[int]] = [set() for _ in q]
    for k, one in enumerate(q):
        away = np.einsum("kn,kn->k", q - one, q - one)
        for near in np.argsort(away, kind="stable")[1 : NEIGHBOURS + 1]:
            edges[k].add(int(near))
            edges[int(near)].add(k)
    return edges


def shortest_way(
    q: JointVector, edges: list[set[int]], start: int, ends: set[int], blocked: set[tuple[int, int]] | None = None
) -> list[int] | None:
    """The shortest way through a graph, by A* with straight distances; None if there is none.

    Args:
        q: (k, n) places of the nodes.
        edges: neighbours of each node.
        start: a node.
        ends: nodes at one of which it may end.
        blocked: edges that do not count.
    """
    goals = q[sorted(ends)]
    ahead = np.min(np.linalg.norm(q[:, None] - goals[None], axis=2), axis=1)
    best, before, done = {start: 0.0}, {start: -1}, set[int]()
    queue = [(float(ahead[start]), start)]
    while queue:
        _, node = heappop(queue)
        if node in ends:
            way = [node]
            while before[way[-1]] >= 0:
                way.append(before[way[-1]])
            return way[::-1]
        if node in done:
            continue
        done.add(node)
        for other in edges[node]:
            if blocked and (node, other) in blocked:
                continue
            cost = best[node] + float(np.linalg.norm(q[node] - q[other]))
            if cost < best.get(other, np.inf):
                best[other], before[other] = cost, node
                heappush(queue, (cost + float(ahead[other]), other))
    return None


def rrt_star(
    problem: Problem, start: JointVector, goals: JointVector, budget: SearchBudget
) -> tuple[JointVector | None, int]:
    """A tree that is rewired as it grows, so its paths become ever shorter; the whole budget is used.

    1. A first path by two trees gives a length to beat.
    2. Samples from the ellipsoid of all that a shorter path can pass (both ends are its foci).
    3. The new node takes the parent through which it is cheapest, and becomes that of whom it makes cheaper.
    4. A goal that is reached more cheaply shrinks the ellipsoid.

    Args:
        problem: what is free.
        start: (n,).
        goals: (k, n); the one that the first path reaches is kept.
        budget: for samples and nodes.

    Reference: Karaman and Frazzoli, IJRR 2011; Gammell, Srinivasa and Barfoot, Informed RRT*, IROS 2014.
    """
    # 1.
    first, nodes = rrt_connect(problem, start, goals, budget)
    if first is None:
        return None, nodes
    best, goal, n = first, first[-1], problem.n
    span = float(np.linalg.norm(problem.upper - problem.lower))
    tree, root = Tree(start), 0
    for place in first[1:]:
        root = tree.add(place, root)
    reached = [root]
    with best_kept(lambda: True):
        while budget.left(nodes + tree.count) and length_of(best) > float(np.linalg.norm(goal - start)) * (1 + 1e-9):
            # 2.
            sample = (
                goal if budget.rng.random() < GOAL_BIAS else _inform(problem, start, goal, length_of(best), budget.rng)
            )
            node = tree.nearest(sample)
            way = sample - tree.q[node]
            distance = float(np.linalg.norm(way))
            if distance == 0.0:
                continue
            new = sample if distance <= STEP * span else tree.q[node] + way * (STEP * span / distance)
            # 3.
            radius = min(STEP * span, span * (np.log(tree.count + 1) / (tree.count + 1)) ** (1.0 / n))
            near = sorted(
                tree.near(new, radius) or [node], key=lambda k: tree.cost[k] + float(np.linalg.norm(tree.q[k] - new))
            )
            parent = next((k for k in near if problem.is_free_segment(tree.q[k].copy(), new)), None)
            if parent is None:
                continue
            added = tree.add(new, parent)
            for k in near:
                cost = tree.cost[added] + float(np.linalg.norm(tree.q[k] - new))
                if cost < tree.cost[k] - 1e-12 and problem.is_free_segment(new, tree.q[k].copy()):
                    tree.parent[k] = added
                    _recost(tree)
            if np.array_equal(new, goal):
                reached.append(added)
            # 4.
            end = min(reached, key=lambda k: tree.cost[k])
            if tree.cost[end] < length_of(best) - 1e-12:
                best = tree.way(end)
    return best, nodes + tree.count


def _recost(tree: Tree) -> None:
    """Costs after a change of parents, from the root on."""
    children: list[list[int]] = [[] for _ in range(tree.count)]
    for k, parent in enumerate(tree.parent):
        if parent >= 0:
            children[parent].append(k)
    stack = [0]
    while stack:
        node = stack.pop()
        for k in children[node]:
            tree.cost[k] = tree.cost[node] + float(np.linalg.norm(tree.q[k] - tree.q[node]))
            stack.append(k)


def _inform(problem: Problem, a: JointVector, b: JointVector, length: float, rng: np.random.Generator) -> JointVector:
    """A sample of the ellipsoid with foci a and b whose points have a sum of distances of at most `length`."""
    n, apart = problem.n, float(np.linalg.norm(b - a))
    axes = np.full(n, np.sqrt(max(length**2 - apart**2, 0.0)) / 2.0)
    axes[0] = length / 2.0
    first = (b - a) / apart if apart else np.eye(n)[0]
    basis, _ = np.linalg.qr(np.column_stack([first, np.eye(n)]))
    for _ in range(50):
        x = rng.normal(size=n)
        x *= rng.random() ** (1.0 / n) / np.linalg.norm(x)
        sample = (a + b) / 2.0 + basis[:, :n] @ (axes * x)
        if (sample >= problem.lower).all() and (sample <= problem.upper).all():
            return sample
    return problem.sample(rng, 1)[0]


PLANNERS: dict[str, Planner] = {"rrt_connect": rrt_connect, "prm": prm, "rrt_star": rrt_star}
"""All planners by name; a new one is a row."""


class Tree:
    """Configurations, each but the root with a parent and the cost of the way from the root.

    Memory: n + 2 numbers a node, doubled where more are needed.

    Args:
        root: (n,).
    """

    def __init__(self, root: JointVector) -> None:
        self.count = 1
        self._q: Floats = np.empty((64, len(root)))
        self._q[0] = root
        self.parent, self.cost = [-1], [0.0]

    @property
    def q(self) -> Floats:
        """(count, n) configurations."""
        return self._q[: self.count]

    def nearest(self, q: JointVector) -> int:
        """The node nearest to a configuration (n,)."""
        away = self.q - q
        return int(np.einsum("kn,kn->k", away, away).argmin())

    def near(self, q: JointVector, radius: float) -> list[int]:
        """Nodes within a radius of a configuration (n,)."""
        away = self.q - q
        return [int(k) for k in np.flatnonzero(np.einsum("kn,kn->k", away, away) <= radius**2)]

    def add(self, q: JointVector, parent: int) -> int:
        """A node more; its index."""
        if self.count == len(self._q):
            self._q = np.concatenate([self._q, np.empty_like(self._q)])
        self._q[self.count] = q
        self.parent.append(parent)
        self.cost.append(self.cost[parent] + float(np.linalg.norm(q - self._q[parent])))
        self.count += 1
        return self.count - 1

    def way(self, node: int) -> JointVector:
        """(k, n) from the root to a node."""
        rows: list[JointVector] = []
        while node >= 0:
            rows.append(self._q[node].copy())
            node = self.parent[node]
        return np.stack(rows[::-1])
