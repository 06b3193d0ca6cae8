"""Roadmaps of an arm: shortest paths that get shorter while the budget lasts, and many questions to one roadmap."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, single, whole
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.planning.arm_limits import bounds_of
from mafsil.planning.kept_planning import require_tree
from mafsil.planning.outcome import best_kept
from mafsil.planning.problem import length_of

if TYPE_CHECKING:
    import mafsil.planning.arm_question_loops as shorten_loops
    import mafsil.planning.roadmap_loops as roadmap_loops
    from mafsil.collision import Checker
else:
    shorten_loops = lazily("mafsil.planning.arm_question_loops")
    roadmap_loops = lazily("mafsil.planning.roadmap_loops")

Scalar = TypeVar("Scalar", bound=np.generic)
BATCH = 200
"""Samples by which a roadmap grows at a time."""
MOST_MISSED = 100_000
"""Samples in turn that are not free before a roadmap gives up to grow."""
ROUNDS = 20
"""Ways that are settled between two looks at the clock."""
SHORTCUTS = 30
"""Of each path that is shorter than all before."""


class ArmRoadmap:
    """A roadmap of an arm: collision-free configurations and verified edges, reused between queries.

    Memory: 8 (n + 2) bytes a node and 40 bytes an edge, some 30 edges a node at 10,000 nodes of 7 joints.

    `mf.plan(roadmap, None, start, goal, max_nodes=...)` asks it.

    Args:
        checker: the arm in its scene.
        seed: of the samples.

    Reference: L. Kavraki et al., Probabilistic roadmaps, IEEE Trans. Robotics and Automation 12(4), 1996.
    """

    def __init__(self, checker: Checker, seed: int = 0) -> None:
        require_tree(checker.robot)
        self.checker = checker
        n = checker.robot.n
        random = np.array([whole("seed", seed)], np.uint64)
        self._arrays = roadmap_loops.Roadmap(
            np.empty((BATCH, n)), np.empty((BATCH, 5), np.int64), np.empty(BATCH, np.int64), np.zeros(2, np.int64),
            random, np.zeros(3, np.int64),
        )  # fmt: skip

    @property
    def nodes(self) -> int:
        """How many there are."""
        return int(self._arrays.sizes[0])

    @property
    def proved(self) -> int:
        """How many motions are proved free."""
        return int((self._arrays.edges[: self._arrays.sizes[1], 4] == roadmap_loops.PROVED).sum())

    @property
    def seen(self) -> tuple[int, int, int]:
        """Motions looked at, motions proved or tried to be, states, so far."""
        a, b, c = (int(x) for x in self._arrays.seen)
        return a, b, c

    def grow(self, nodes: int, q: ArrayLike) -> None:
        """Add free configurations until there are so many nodes, wherever the limits allow.

        Args:
            nodes: of the whole roadmap.
            q: (n,) coordinates that do not move the tip, such as those of a gripper, keep these values.

        Raises:
            InputError: a wrong shape, no free configuration in 100,000 samples.
        """
        like = np.asarray(single("q", q, (self.checker.robot.n,)), dtype=np.float64)
        wanted, missed = whole("nodes", nodes, least=1), 0
        lower, upper = bounds_of(self.checker, like[None])
        nothing = np.empty((0, len(like)))
        while self.nodes < wanted:
            before, tries = self.nodes, min(BATCH, wanted - self.nodes)
            self._reserve(tries)
            joined = roadmap_loops.neighbours(before, len(like))
            roadmap_loops.grow_roadmap(
                self.checker.workshop(), self._arrays, lower, upper, nothing, np.inf, tries, joined
            )
            missed = missed + tries if self.nodes == before else 0
            if missed >= MOST_MISSED:
                raise InputError("planning.nothing_free", count=missed)

    def path(
        self, start: JointVector, goals: JointVector, *, seconds: float = 1.0, nodes: int = 2000,
        first: JointVector | None = None, bounds: tuple[Floats, Floats] | None = None,
    ) -> JointVector | None:  # fmt: skip
        """The shortest path that was found and proved, (k, n); None if the budget ends before there is one.

        1. Start and goals become nodes; so does a path that is known.
        2. The shortest way by motions that are not blocked is settled; what is blocked is left out; until a way is
           proved or none is left. Shortcuts of it set the length to beat, and it becomes part of the roadmap.
        3. More nodes where a shorter path can pass; again, until the budget ends.

        Args:
            start: (n,) free.
            goals: (k, n) free; any will do.
            seconds: after which the best so far is given.
            nodes: of the whole roadmap, after which it is given; equal seeds and questions give equal paths then.
            first: (k, n) a path of proved motions to begin with.
            bounds: (n,) between which to search; the limits if None.
        """
        shop = self.checker.workshop()
        lower, upper = bounds_of(self.checker, np.concatenate([start[None], goals])) if bounds is None else bounds
        # Nothing to shorten: a first call ever waits for the compiler, before the clock starts.
        shorten_loops.shorten(shop, np.stack([start, start]), 0, self._arrays.random, self._arrays.seen)
        deadline, best = perf_counter() + seconds, np.empty((0, len(start)))
        length, shortest = np.inf, float(np.linalg.norm(goals - start, axis=1).min())
        if shortest == 0.0:
            return np.stack([start, start])
        # 1.
        at_start = self._node(start)
        ends = np.array([self._node(goal) for goal in goals], np.int64)
        if first is not None:
            best, length = first, length_of(first)
            self.include(first)
        with best_kept(lambda: len(best) > 0):
            while True:
                # 2.
                code = -1
                while code != 0 and perf_counter() < deadline:
                    code, way = roadmap_loops.shortest_proved(shop, self._arrays, at_start, ends, length, ROUNDS)
                    if code == 1:
                        arrays = self._arrays
                        best = arrays.q[way].copy()
                        short = shorten_loops.shorten(shop, best, SHORTCUTS, arrays.random, arrays.seen)
                        if self.checker.free_segment(short[:-1], short[1:]).all():
                            best = short
                        length = length_of(best) * (1.0 - 1e-9)
                        self.include(best)
                ended = perf_counter() >= deadline or self.nodes >= nodes
                if ended or length <= shortest * (1.0 + 1e-9):
                    return best if len(best) else None
                # 3.
                tries = min(BATCH, nodes - self.nodes)
                self._reserve(tries)
                joined = roadmap_loops.neighbours(self.nodes, len(start))
                # Other goals may be nearer than that of the best path: then its ellipsoid is no bound.
                bound = length if len(goals) == 1 else np.inf
                roadmap_loops.grow_roadmap(shop, self._arrays, lower, upper, best, bound, tries, joined)
        return best

    def include(self, path: JointVector) -> None:
        """A path (k, n) of proved motions becomes part of the roadmap."""
        self._reserve(2 * len(path))
        joined = roadmap_loops.neighbours(self.nodes, path.shape[1])
        roadmap_loops.add_path(self._arrays, np.ascontiguousarray(path), joined)

    def _node(self, q: JointVector) -> int:
        """The index of a configuration, new where none equals it."""
        same = np.flatnonzero((self._arrays.q[: self.nodes] == q).all(axis=1))
        if len(same):
            return int(same[0])
        self._reserve(1)
        return int(roadmap_loops.add_node(self._arrays, q, roadmap_loops.neighbours(self.nodes, len(q))))

    def _reserve(self, more: int) -> None:
        """Arrays twice as long where they would be full."""
        arrays = self._arrays
        nodes = self.nodes + more
        edges = int(arrays.sizes[1]) + more * (1 + roadmap_loops.neighbours(nodes, arrays.q.shape[1]))
        if nodes > len(arrays.q):
            longer = max(nodes, 2 * len(arrays.q))
            arrays = arrays._replace(q=_longer(arrays.q, longer), first=_longer(arrays.first, longer))
        if edges > len(arrays.edges):
            arrays = arrays._replace(edges=_longer(arrays.edges, max(edges, 2 * len(arrays.edges))))
        self._arrays = arrays


def _longer(array: NDArray[Scalar], rows: int) -> NDArray[Scalar]:
    longer = np.empty((rows, *array.shape[1:]), array.dtype)
    longer[: len(array)] = array
    return longer
