"""How quick are collision checks, beside Pinocchio with coal on the same shapes, in the same run?

python benchmarks/collision.py [--batch 4096] [--verdicts 20000] [--planning FOLDER] [--json FILE]

The six-joint arm of the tests among 8 obstacles of all kinds, and, where the folder of planning problems is, the Panda
of 59 balls in a scene of each set. Rows: verdicts one by one and in batches beside `computeCollisions` (which stops at
the first), distances with gradient beside `computeDistances` (without), motions proved free beside checks every 0.02
rad, pairs of bodies beside `coal.distance`. Last: on how many random states the verdicts differ.
"""

from __future__ import annotations

import argparse
import json
import lzma
import os
import sys
import tempfile
import warnings
from functools import partial
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
os.environ.setdefault("MAFSIL_THREADS", "1")

import coal  # noqa: E402
import numpy as np  # noqa: E402
import pinocchio as pin  # noqa: E402

from benchmarks.comparison import Comparisons  # noqa: E402
from benchmarks.stopwatch import machine, race  # noqa: E402
from mafsil import collision  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.collision import Box, Checker, Cylinder, Obstacle, Sphere  # noqa: E402
from mafsil.geometry.quaternion import from_quaternion  # noqa: E402
from tests.collision.arms import scene, urdf  # noqa: E402
from tests.collision.peer import BODIES, coal_pose, coal_shape, random_poses  # noqa: E402


class Peer:
    """Pinocchio and coal with the shapes, obstacles and pairs of a checker."""

    def __init__(self, file: str, checker: Checker):
        self.model = pin.buildModelFromUrdf(file)
        self.shapes = pin.buildGeomFromUrdf(self.model, file, pin.GeometryType.COLLISION)
        names = [self.model.frames[each.parentFrame].name for each in self.shapes.geometryObjects]
        own = len(names)
        for each in checker.scene:
            place = pin.SE3(each.T_so[:3, :3].copy(), each.T_so[:3, 3].copy())
            self.shapes.addGeometryObject(pin.GeometryObject(each.name, 0, 0, place, coal_shape(each.geometry)))
        bodies = [body.name for body in checker.bodies]
        pairs = {frozenset((bodies[a], bodies[b])) for a, b in checker.arm.pairs}
        for a in range(own):
            for b in range(a + 1, own):
                if frozenset((names[a], names[b])) in pairs:
                    self.shapes.addCollisionPair(pin.CollisionPair(a, b))
            for b in range(own, len(self.shapes.geometryObjects)):
                self.shapes.addCollisionPair(pin.CollisionPair(a, b))
        self.data, self.own = self.model.createData(), self.shapes.createData()

    def collides(self, q: Floats) -> bool:
        """Whether a state collides."""
        return pin.computeCollisions(self.model, self.data, self.shapes, self.own, q, True)

    def verdicts(self, rows: Floats) -> list[bool]:
        """Of many states."""
        return [self.collides(q) for q in rows]

    def distances(self, rows: Floats) -> None:
        """All distances of many states."""
        for q in rows:
            pin.computeDistances(self.model, self.data, self.shapes, self.own, q)

    def least_distance(self, q: Floats) -> float:
        """The smallest of all distances of a state."""
        pin.computeDistances(self.model, self.data, self.shapes, self.own, q)
        return min(each.min_distance for each in self.own.distanceResults)

    def motion(self, a: Floats, b: Floats) -> bool:
        """Whether samples along a motion, 0.02 rad apart, are free."""
        count = max(2, int(np.abs(b - a).max() / 0.02))
        return not any(self.collides(a + t * (b - a)) for t in np.linspace(0.0, 1.0, count))


def problems(folder: Path) -> dict[str, collision.Scene]:
    """The first scene of each set of the Panda's planning problems."""
    with lzma.open(folder / "panda.json.xz") as file:
        sets: dict[str, Any] = json.load(file)["sets"]
    return {name: collision.Scene(map(obstacle, found["problems"][0]["obstacles"])) for name, found in sets.items()}


def obstacle(row: dict[str, Any]) -> Obstacle:
    """One obstacle of a planning problem."""
    T = np.eye(4)
    quaternion = np.array(row["quaternion_wxyz"])
    T[:3, :3] = from_quaternion(quaternion / np.linalg.norm(quaternion))
    T[:3, 3] = row["position"]
    made = {
        "box": lambda: Box(tuple(row["size"])),
        "cylinder": lambda: Cylinder(row["radius"], row["length"]),
        "sphere": lambda: Sphere(row["radius"]),
    }
    return Obstacle(made[row["kind"]](), T, row["name"])


def compare(found: Comparisons, name: str, file: str, checker: Checker, batch: int, verdicts: int) -> None:
    """Print and keep the rows of one arm in one scene."""
    peer, q = Peer(file, checker), checker.random_configurations(batch)
    some = q[:40]
    free = q[checker.free(q)]
    a, b = free[0], free[0] + 0.3 * (free[1] - free[0])
    tasks = {
        "peer": partial(peer.verdicts, some),
        "one": partial(checker.free, q[0]),
        "batch": partial(checker.in_collision, q),
        "peer distance": partial(peer.distances, some[:5]),
        "distance": partial(checker.distance, q[:256]),
        "peer motion": partial(peer.motion, a, b),
        "motion": partial(checker.free_segment, a, b),
    }
    least = {key: timing.least * 1e6 for key, timing in race(tasks, repeats=7).items()}
    rows = [
        ("Checker.free(q)", "one", least["one"], least["peer"] / len(some)),
        ("Checker.in_collision(q)", f"batch of {batch}", least["batch"] / batch, least["peer"] / len(some)),
        ("Checker.distance(q)", "batch of 256", least["distance"] / 256, least["peer distance"] / 5),
        ("Checker.free_segment(a, b)", "one", least["motion"], least["peer motion"]),
    ]
    for call, case, ours, theirs in rows:
        found.add(call, f"{name}, {case}", ours, "pin + coal", theirs)
        print(f"{name:18} {call:27} {case:14} {ours:9.3f} us   pin + coal {theirs:9.2f} us   {theirs / ours:8.1f}x")
    many = checker.random_configurations(verdicts)
    ours = checker.in_collision(many)
    different = np.flatnonzero(ours != np.array(peer.verdicts(many)))
    sided = sum(int((peer.least_distance(many[k]) <= 0.0) == ours[k]) for k in different)
    agreed = f"; coal's own distances side with ours on {sided} of them" if len(different) else ""
    print(f"{name:18} verdicts differ on {len(different)} of {verdicts}{agreed}")


def pairs(found: Comparisons) -> None:
    """Print and keep distances of two bodies."""
    T_a, T_b = random_poses(1000, 0.6, 1), random_poses(1000, 0.6, 2)
    placed = [(coal_pose(a), coal_pose(b)) for a, b in zip(T_a[:200], T_b[:200], strict=True)]
    request = coal.DistanceRequest(True, True)

    def theirs(first: Any, second: Any) -> None:
        for a, b in placed:
            coal.distance(first, a, second, b, request, coal.DistanceResult())

    for one, other in (
        ("sphere", "box"),
        ("capsule", "capsule"),
        ("box", "box"),
        ("cylinder", "cylinder"),
        ("hull", "hull"),
    ):
        tasks = {
            "ours": partial(collision.distance, BODIES[one][0], BODIES[other][0], T_a, T_b),
            "theirs": partial(theirs, BODIES[one][1], BODIES[other][1]),
        }
        times = race(tasks, repeats=5)
        ours, coals = times["ours"].least * 1e6 / 1000, times["theirs"].least * 1e6 / 200
        found.add("collision.distance(a, b)", f"{one} and {other}, 1000 poses", ours, "coal", coals)
        print(f"{one + ' and ' + other:46} 1000 poses {ours:12.3f} us   coal {coals:15.2f} us   {coals / ours:8.1f}x")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--batch", type=int, default=4096)
    parser.add_argument("--verdicts", type=int, default=20000)
    parser.add_argument("--planning", type=Path, default=ROOT.parent / "shared" / "data" / "planning")
    parser.add_argument("--json")
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    print(machine("numpy", "pin", "coal"))
    found = Comparisons()
    pairs(found)
    with tempfile.TemporaryDirectory() as folder:
        file = str(Path(folder) / "arm.urdf")
        Path(file).write_text(urdf())
        compare(found, "arm of primitives", file, Checker(file, scene(1)), given.batch, given.verdicts)
    if (given.planning / "panda.json.xz").exists():
        file = str(given.planning / "panda_spherized.urdf")
        panda = Checker(file, srdf=given.planning / "panda.srdf")
        for name, surroundings in problems(given.planning).items():
            compare(found, name, file, panda.with_scene(surroundings), given.batch, given.verdicts // 20)
    if given.json:
        Path(given.json).write_text(json.dumps(found.plain()))


if __name__ == "__main__":
    main()
