"""R18: every path that planning returns, looked at by Pinocchio and coal on the same shapes at 0.001 rad.

`python -m tests.reliability.coal_paths --problems 1400 --resume DIR`

The problems of MotionBenchMaker for the Panda and the UR5 where `../shared/data/planning` is, else random scenes around
the arm of primitives. Half of the found paths are also timed, and the motion is looked at as well. What no joint moves
is not checked against the scene, by either. A state in which coal's verdict says contact counts as wrong if its own
distance agrees.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

import mafsil as mf
from benchmarks.planning import posed
from mafsil.collision import Checker
from mafsil.trajectory import MotionLimits
from tests.collision.arms import scene, urdf
from tests.reliability import figures

STEP = 1e-3
"""Largest change of a coordinate between states that are looked at [rad]."""
PROBLEMS = Path(__file__).parents[3] / "shared" / "data" / "planning"


class Peer:
    """Pinocchio and coal with the shapes, obstacles and pairs of a checker; its scene may change."""

    def __init__(self, file: str, checker: Checker) -> None:
        import pinocchio as pin

        from tests.collision.peer import coal_shape

        self.pin, self.coal_shape = pin, coal_shape
        self.model = pin.buildModelFromUrdf(file)
        self.shapes = pin.buildGeomFromUrdf(self.model, file, pin.GeometryType.COLLISION)
        self.links = [self.model.frames[each.parentFrame].name for each in self.shapes.geometryObjects]
        bodies = [body.name for body in checker.bodies]
        self.pairs = {frozenset((bodies[a], bodies[b])) for a, b in checker.arm.pairs}
        self.still = {bodies[b] for b, row in enumerate(checker.arm.bodies) if row[3] == row[1]}
        names = [joint.name for joint in checker.robot.mechanism.coordinates]
        assert list(self.model.names)[1:] == names, "coordinates in the same order"
        self.data = self.model.createData()

    def first_contact(self, checker: Checker, states: np.ndarray) -> int:
        """The first of (k, n) states that collides; -1 if none does."""
        shapes = self._with_scene(checker)
        data = shapes.createData()
        for k, q in enumerate(states):
            if self._touches(shapes, data, q) and self._distance(shapes, data, q) <= 0.0:
                return k
        return -1

    def verdicts(self, checker: Checker, states: np.ndarray, asked: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which of (k, n) states collide, and the least distance where that is not what is asked; else NaN."""
        shapes = self._with_scene(checker)
        data = shapes.createData()
        found = np.array([self._touches(shapes, data, q) for q in states])
        distance = np.full(len(states), np.nan)
        for k in np.flatnonzero(found != asked):
            distance[k] = self._distance(shapes, data, states[k])
        return found, distance

    def _touches(self, shapes: Any, data: Any, q: np.ndarray) -> bool:
        return self.pin.computeCollisions(self.model, self.data, shapes, data, q, True)

    def _distance(self, shapes: Any, data: Any, q: np.ndarray) -> float:
        self.pin.computeDistances(self.model, self.data, shapes, data, q)
        return min(each.min_distance for each in data.distanceResults)

    def _with_scene(self, checker: Checker) -> Any:
        """The arm's shapes and the obstacles, with the pairs that the checker looks at."""
        pin, shapes = self.pin, self.shapes.copy()
        own = len(self.links)
        for each in checker.scene:
            place = pin.SE3(each.T_so[:3, :3].copy(), each.T_so[:3, 3].copy())
            shapes.addGeometryObject(pin.GeometryObject(each.name, 0, 0, place, self.coal_shape(each.geometry)))
        shapes.removeAllCollisionPairs()
        for a in range(own):
            for b in range(a + 1, own):
                if frozenset((self.links[a], self.links[b])) in self.pairs:
                    shapes.addCollisionPair(pin.CollisionPair(a, b))
            if self.links[a] not in self.still:
                for b in range(own, len(shapes.geometryObjects)):
                    shapes.addCollisionPair(pin.CollisionPair(a, b))
        return shapes


def dense(path: np.ndarray) -> np.ndarray:
    """States of a path, no coordinate more than STEP apart."""
    parts = [a + np.linspace(0, 1, int(np.abs(b - a).max() / STEP) + 2)[:, None] * (b - a) for a, b in pairwise(path)]
    return np.concatenate(parts)


@cache
def peers() -> dict[str, tuple[Checker, Peer]]:
    """Arms with their peers."""
    if PROBLEMS.exists():
        found = {}
        for name in ("panda", "ur5"):
            file = str(PROBLEMS / f"{name}_spherized.urdf")
            checker = Checker(file, srdf=PROBLEMS / f"{name}.srdf")
            found[name] = checker, Peer(file, checker)
        return found
    return {"primitives": primitives()}


@cache
def primitives() -> tuple[Checker, Peer]:
    """The arm of the tests."""
    with tempfile.TemporaryDirectory() as folder:
        file = str(Path(folder) / "arm.urdf")
        Path(file).write_text(urdf())
        checker = Checker(file)
        return checker, Peer(file, checker)


def random_problems(seed: int, count: int) -> Iterator[tuple[Checker, np.ndarray, np.ndarray]]:
    """Free ends in random scenes around the arm of primitives."""
    arm, _ = primitives()
    rng = np.random.default_rng([18, seed])
    for _ in range(count):
        checker = arm.with_scene(scene(int(rng.integers(2**31)), int(rng.integers(2, 10))))
        q = checker.random_configurations(200)[rng.permutation(200)]
        free = q[checker.free(q)]
        if len(free) > 1:
            yield checker, free[0], free[1]


def examined(peer: Peer, problems: Iterator[tuple[Checker, Any, Any]]) -> dict[str, int]:
    """Counts over problems."""
    counts = dict.fromkeys(("problems", "found", "timed", "states", "bad_path", "bad_motion"), 0)
    for k, (checker, start, goal) in enumerate(problems):
        found = mf.plan(checker, None, start, goal, seed=k, seconds=20.0)
        counts["problems"] += 1
        if not found:
            continue
        counts["found"] += 1
        states = dense(found.path)
        counts["states"] += len(states)
        counts["bad_path"] += peer.first_contact(checker, states) >= 0
        if k % 2:
            motion = found.time_optimal(MotionLimits.of(checker.robot.n, velocity=2.0, acceleration=8.0))
            t = np.linspace(0.0, motion.duration, int(2.0 * motion.duration / STEP) + 2)
            states = motion.trajectory.at(t).u
            counts["timed"] += 1
            counts["states"] += len(states)
            counts["bad_motion"] += peer.first_contact(checker, states) >= 0
    return counts


def work(seed: int, problems: int) -> dict[str, int]:
    """Counts of one shard: each takes its part of the problems of every set, or random ones."""
    if not PROBLEMS.exists():
        return examined(primitives()[1], random_problems(seed, problems))
    total: dict[str, int] = {}
    for name, (_, peer) in peers().items():
        rows = [row for k, row in enumerate(posed(PROBLEMS, name, 100)) if k % SHARDS == seed % SHARDS]
        for key, value in examined(peer, iter(rows)).items():
            total[key] = total.get(key, 0) + value
    return total


SHARDS = 14
"""Parts that the problems of others are taken in; the number of problems of a shard is theirs, then."""

if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "problems", 1_400, 100)
    sys.exit(not figures.run("R18", options, work)["passed"])
