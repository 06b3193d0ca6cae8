"""R20: verdicts on random configurations are coal's on the same shapes, distances of primitives are right to 1e-9.

`python -m tests.reliability.coal_verdicts --states 1000000 --resume DIR`

The Panda and the UR5 of balls in the scenes of MotionBenchMaker where `../shared/data/planning` is, and an arm of
primitives in random scenes of all kinds of obstacles. Where coal's verdict differs, its own distance is asked: it
decides, unless it is smaller than coal's tolerance. Distances of two bodies apart are bounded from both sides: by two
points of which NumPy says that they are in the bodies, and by the slab between two planes that support them. Those
with a cylinder or cone are promised to 1e-9 of the bodies' size; how many are off by more than 1e-9 m is counted.
Pairs of awkward bodies (needles, plates, nanometres to kilometres, aligned, concentric, touching) are held to the same
bounds; of those that meet, none of many directions parts them sooner than the depth says.
"""

from __future__ import annotations

import sys
from functools import cache
from itertools import combinations_with_replacement

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.planning import posed
from mafsil import collision
from mafsil.collision import Checker
from tests.collision.arms import scene
from tests.collision.peer import BODIES, ROUND, random_poses
from tests.reliability import figures
from tests.reliability.coal_paths import PROBLEMS, Peer, peers, primitives

TOLERANCE = 1e-6
"""Of coal's distances [m]."""
RIGHT = 1e-9
"""Of ours [m]."""
SIZE = 1.4
"""Of two of the bodies with a cylinder or cone, their diameters together [m]."""
PER_SCENE = 1_000
PAIRS_PER_STATE = 0.1
"""Pairs of bodies beside each state."""
WAYS = 2_000
"""Directions in which two bodies that meet are parted."""
NORMAL = 1e-5
"""What the slab of bodies that all but touch, and points of bodies that meet, may be off by, relative to their size."""
SETS = 100
"""Problems of each set of others whose scenes are taken."""


@cache
def scenes() -> list[tuple[str, Checker, Peer]]:
    """Arms of others in the scenes of others."""
    if not PROBLEMS.exists():
        return []
    found = []
    for name, (_, peer) in peers().items():
        found += [(name, checker, peer) for checker, _, _ in posed(PROBLEMS, name, SETS)]
    return found


def work(seed: int, states: int) -> dict[str, int]:
    """Counts of one shard."""
    rng = np.random.default_rng([20, seed])
    counts = dict.fromkeys(("states", "colliding", "undecided", "coal_corrected", "bad_verdict"), 0)
    left = states
    while left > 0:
        count, own = min(PER_SCENE, left), not scenes() or rng.random() < 1.0 / 3.0
        if own:
            arm, peer = primitives()
            checker = arm.with_scene(scene(int(rng.integers(2**31)), int(rng.integers(2, 10))))
        else:
            _, checker, peer = scenes()[int(rng.integers(len(scenes())))]
        lower, upper = checker.robot.limits.lower, checker.robot.limits.upper
        q = rng.uniform(lower, upper, (count, checker.robot.n))
        for name, value in compared(checker, peer, q).items():
            counts[name] += value
        left -= count
    count = max(round(PAIRS_PER_STATE * states), 1)
    return counts | pairs(seed, count) | awkward_pairs(seed, -(-count // 10))


def compared(checker: Checker, peer: Peer, q: np.ndarray) -> dict[str, int]:
    """Counts over (k, n) states."""
    ours = checker.in_collision(q)
    theirs, distance = peer.verdicts(checker, q, ours)
    differ = ours != theirs
    undecided = differ & (np.abs(distance) < TOLERANCE)
    corrected = differ & ~undecided & ((distance <= 0.0) == ours)
    return {
        "states": len(q), "colliding": int(ours.sum()), "undecided": int(undecided.sum()),
        "coal_corrected": int(corrected.sum()), "bad_verdict": int((differ & ~undecided & ~corrected).sum()),
    }  # fmt: skip


def pairs(seed: int, count: int) -> dict[str, int]:
    """Counts over distances of two primitives at random poses."""
    kinds = [pair for pair in combinations_with_replacement(BODIES, 2) if pair != ("plane", "plane")]
    counts = {"pairs": 0, "apart": 0, "over_1e9": 0, "bad_distance": 0}
    for k, (first, second) in enumerate(kinds):
        many = -(-count // len(kinds))
        T_a, T_b = (random_poses(many, 0.6, 7919 * seed + 101 * k + side) for side in (1, 2))
        a, b = BODIES[first][0], BODIES[second][0]
        found = collision.distance(a, b, T_a, T_b)
        apart = found.distance > 0.0
        counts["pairs"] += many
        counts["apart"] += int(apart.sum())
        least = slab(a, T_a, b, T_b, found.normal)
        outside = np.maximum(beyond(a, T_a, found.point_a), beyond(b, T_b, found.point_b))
        between = np.linalg.norm(found.point_a - found.point_b, axis=1)
        off = np.maximum(np.maximum(np.abs(found.distance - between), outside), between - least)[apart]
        counts["over_1e9"] += int((off > RIGHT).sum())
        counts["bad_distance"] += int((off > RIGHT * (SIZE if {first, second} & set(ROUND) else 1.0)).sum())
    return counts


def awkward_pairs(seed: int, count: int) -> dict[str, int]:
    """Counts over distances of two awkward bodies."""
    rng, counts = np.random.default_rng([39, seed]), {"awkward": count, "bad_awkward": 0}
    ways = rng.normal(size=(WAYS, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    for _ in range(count):
        scale = 10.0 ** rng.uniform(-5.0, 5.0) if rng.random() < 0.3 else 1.0
        a, b, T_a, T_b = _some_body(rng, scale), _some_body(rng, scale), _some_pose(rng, scale), _some_pose(rng, scale)
        if rng.random() < 0.15:
            T_b = T_a
        if rng.random() < 0.3:
            met = collision.distance(a, b, T_a, T_b)
            T_a = T_a.copy()
            T_a[:, :3, 3] -= met.distance * met.normal * (1.0 + rng.choice([0.0, 1e-12, -1e-9, 1e-6, -1e-3]))
        counts["bad_awkward"] += not _is_right(collision.distance(a, b, T_a, T_b), a, T_a, b, T_b, scale, ways)
    return counts


def _is_right(found: collision.Separation, a: object, T_a: np.ndarray, b: object, T_b: np.ndarray, scale: float,
              ways: np.ndarray) -> bool:  # fmt: skip
    distance, size = float(found.distance[0]), 3.0 * scale
    off = max(float(beyond(a, T_a, found.point_a)[0]), float(beyond(b, T_b, found.point_b)[0]))
    joined = np.abs(found.point_a - found.point_b - distance * found.normal).max()
    least = float(slab(a, T_a, b, T_b, found.normal)[0])
    if distance > 0.0:
        sharp = RIGHT if distance > 1e-6 * size else NORMAL
        return bool(max(off, joined) <= RIGHT * size and abs(distance - least) <= sharp * size)
    every = [np.repeat(T, len(ways), axis=0) for T in (T_a, T_b)]
    sooner = -slab(a, every[0], b, every[1], ways).max()
    exact = max(abs(distance - least), joined, -distance - sooner) <= RIGHT * size
    return bool(exact and off <= NORMAL * size)


def _some_body(rng: np.random.Generator, scale: float):
    """A ball, capsule, box, cylinder, cone or hull; some with sides a hundredth of the others, or flat."""
    x, y, z = (scale * 10.0 ** rng.uniform(-2.5 if rng.random() < 0.4 else -0.5, 0.0, 3)).tolist()
    kind = int(rng.integers(6))
    if kind == 5:
        corners = rng.normal(size=(int(rng.choice([5, 8, 30])), 3)) * (x, y, z)
        return collision.ConvexHull(corners)
    makes = (
        lambda: collision.Sphere(x), lambda: collision.Capsule(x, y), lambda: collision.Box((x, y, z)),
        lambda: collision.Cylinder(x, y), lambda: collision.Cone(x, y),
    )  # fmt: skip
    return makes[kind]()


def _some_pose(rng: np.random.Generator, scale: float) -> np.ndarray:
    """(1, 4, 4) a pose: anywhere, by quarter turns, about one axis, or all but parallel to the axes."""
    T, kind = random_poses(1, 0.7, int(rng.integers(2**31))), int(rng.integers(4))
    if kind > 0:
        quarters = np.eye(3)[rng.integers(3)] * rng.integers(4) * np.pi / 2
        about_one = np.eye(3)[rng.integers(3)] * rng.uniform(-3.0, 3.0)
        turns = (quarters, about_one, rng.normal(size=3) * 10.0 ** rng.uniform(-12.0, -2.0))
        T[0, :3, :3] = Rotation.from_rotvec(turns[kind - 1]).as_matrix()
        T[0, rng.integers(3), 3] *= rng.integers(2)
    T[0, :3, 3] *= scale
    return T


def slab(a: object, T_a: np.ndarray, b: object, T_b: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Thickness of the slab between two bodies across a direction from b to a: never more than their distance."""
    return -support(a, T_a, -normal) - support(b, T_b, normal)


def support(body: object, T: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """How far a body at poses (k, 4, 4) reaches along unit directions (k, 3); infinite where it does not end."""
    u = np.einsum("kji,kj->ki", T[:, :3, :3], direction)
    across, offset = np.hypot(u[:, 0], u[:, 1]), np.einsum("ki,ki->k", T[:, :3, 3], direction)
    match body:
        case collision.Sphere(radius=r):
            own = np.full(len(u), r)
        case collision.Capsule(radius=r, length=h):
            own = r + h / 2 * np.abs(u[:, 2])
        case collision.Cylinder(radius=r, length=h):
            own = r * across + h / 2 * np.abs(u[:, 2])
        case collision.Cone(radius=r, length=h):
            own = np.maximum(h / 2 * u[:, 2], r * across - h / 2 * u[:, 2])
        case collision.Box(size=size):
            own = np.abs(u) @ np.array(size) / 2
        case collision.ConvexHull(points=points):
            own = (u @ np.asarray(points).T).max(axis=1)
        case _:
            # The half space below its frame ends only upwards, up to rounding of the direction.
            own = np.where((u[:, 2] > 0.0) & (across < 1e-7), 0.0, np.inf)
    return offset + own


def beyond(body: object, T: np.ndarray, points: np.ndarray) -> np.ndarray:
    """How far points (k, 3) are outside a body, at least; 0 within."""
    p = np.einsum("kji,kj->ki", T[:, :3, :3], points - T[:, :3, 3])
    across = np.hypot(p[:, 0], p[:, 1])
    match body:
        case collision.Sphere(radius=r):
            out = np.linalg.norm(p, axis=1) - r
        case collision.Capsule(radius=r, length=h):
            out = np.hypot(across, np.maximum(np.abs(p[:, 2]) - h / 2, 0.0)) - r
        case collision.Cylinder(radius=r, length=h):
            out = np.maximum(across - r, np.abs(p[:, 2]) - h / 2)
        case collision.Cone(radius=r, length=h):
            slope = (across - r * (0.5 - p[:, 2] / h)) * h / np.hypot(r, h)
            out = np.maximum(slope, np.abs(p[:, 2]) - h / 2)
        case collision.Box(size=size):
            out = (np.abs(p) - np.array(size) / 2).max(axis=1)
        case collision.ConvexHull(points=corners):
            from scipy.spatial import ConvexHull as Facets

            planes = Facets(np.asarray(corners)).equations
            out = (p @ planes[:, :3].T + planes[:, 3]).max(axis=1)
        case _:
            out = p[:, 2]
    return np.maximum(out, 0.0)


if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "states", 1_000_000, 20_000)
    sys.exit(not figures.run("R20", options, work)["passed"])
