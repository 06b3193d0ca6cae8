"""How quick are checks of two arms against each other and a scene, beside Pinocchio with coal, in the same run?

python benchmarks/two_arms.py [--batch 4096] [--verdicts 5000]

Two six-joint arms of the tests face each other among 8 obstacles. Pinocchio has both as one model (`appendModel`), with
the same pairs. Rows as in benchmarks/collision.py: verdicts beside `computeCollisions`, which stops at the first. The
last one is the coordination diagram of two straight paths, 100 x 100 cells: ours proved, theirs one state for each.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import warnings
from functools import partial
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
os.environ.setdefault("MAFSIL_THREADS", "1")

import numpy as np  # noqa: E402
import pinocchio as pin  # noqa: E402

from benchmarks.stopwatch import machine, race  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.collision import ArmMount, MultiArmCell  # noqa: E402
from mafsil.model.placement import rotation_z  # noqa: E402
from mafsil.planning import coordinate_arms  # noqa: E402
from tests.collision.arms import scene, urdf  # noqa: E402
from tests.collision.peer import coal_shape  # noqa: E402

FACING = rotation_z(np.pi)
FACING[0, 3] = 0.9


class Peer:
    """Both arms as one model of Pinocchio, with the pairs of ours."""

    def __init__(self, file: str, cell: MultiArmCell):
        one = pin.buildModelFromUrdf(file)
        shapes = pin.buildGeomFromUrdf(one, file, pin.GeometryType.COLLISION)
        place = pin.SE3(FACING[:3, :3].copy(), FACING[:3, 3].copy())
        other, other_shapes = pin.buildModelFromUrdf(file), shapes.copy()
        for index in range(1, other.njoints):
            other.names[index] = "right_" + other.names[index]
        for frame in other.frames:
            frame.name = "right_" + frame.name
        for each in other_shapes.geometryObjects:
            each.name = "right_" + each.name
        self.model, self.shapes = pin.appendModel(one, other, shapes, other_shapes, 0, place)
        names = [each.name for each in self.shapes.geometryObjects]
        pairs = {frozenset((cell.bodies[a].name, cell.bodies[b].name)) for a, b in cell.arm.pairs}
        still = {cell.bodies[b].name for b, row in enumerate(cell.arm.bodies) if row[3] == row[1]}
        bodies = [_body(name) for name in names]
        for each in cell.scene:
            T = pin.SE3(each.T_so[:3, :3].copy(), each.T_so[:3, 3].copy())
            self.shapes.addGeometryObject(pin.GeometryObject(each.name, 0, 0, T, coal_shape(each.geometry)))
        self.shapes.removeAllCollisionPairs()
        for a, first in enumerate(bodies):
            for b in range(a + 1, len(bodies)):
                if frozenset((first, bodies[b])) in pairs:
                    self.shapes.addCollisionPair(pin.CollisionPair(a, b))
            for b in range(len(bodies), len(self.shapes.geometryObjects)):
                if first not in still:
                    self.shapes.addCollisionPair(pin.CollisionPair(a, b))
        self.data, self.own = self.model.createData(), self.shapes.createData()

    def verdicts(self, rows: Floats) -> list[bool]:
        """Of many states."""
        return [pin.computeCollisions(self.model, self.data, self.shapes, self.own, q, True) for q in rows]

    def distances(self, rows: Floats) -> None:
        """All distances of many states."""
        for q in rows:
            pin.computeDistances(self.model, self.data, self.shapes, self.own, q)


def _body(name: str) -> str:
    arm, link = ("right", name.removeprefix("right_")) if name.startswith("right_") else ("left", name)
    return f"{arm}/{link.split('_')[0]}"


def diagram(alone: MultiArmCell, peer: Peer) -> None:
    """Both arms turn past each other; the whole call beside the states of its grid."""
    ends = np.array([0.0, 1.2, 0.3, 0.0, 0.0, 0.0]) + np.array([[-0.9], [0.9]]) * np.eye(6)[0]
    shares = (np.arange(100) + 0.5) / 100
    rows = ends[0] + shares[:, None] * (ends[1] - ends[0])
    grid = alone.join({"left": rows[:, None], "right": rows[None]}).reshape(-1, 12)
    tasks = {
        "ours": partial(coordinate_arms, alone, {"left": ends, "right": ends}),
        "theirs": partial(peer.verdicts, grid[:1000]),
    }
    least = {key: timing.least * 1e3 for key, timing in race(tasks, repeats=5).items()}
    theirs = 10.0 * least["theirs"]
    print(f"coordinate_arms        100 x 100    {least['ours']:9.1f} ms   pin + coal {theirs:9.1f} ms", end="")
    print(f"   {theirs / least['ours']:8.1f}x")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--batch", type=int, default=4096)
    parser.add_argument("--verdicts", type=int, default=5000)
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    print(machine("numpy", "pin", "coal"))
    with tempfile.TemporaryDirectory() as folder:
        file = str(Path(folder) / "arm.urdf")
        Path(file).write_text(urdf())
        cell = MultiArmCell([ArmMount("left", file), ArmMount("right", file, FACING)], scene(1))
        peer, alone = Peer(file, cell), Peer(file, cell.with_scene(()))
    q = cell.random_configurations(given.batch)
    some, near = q[:60], q[:256]
    tasks = {
        "theirs": partial(peer.verdicts, some),
        "one": partial(cell.free, q[0]),
        "batch": partial(cell.in_collision, q),
        "their distance": partial(peer.distances, some[:10]),
        "distance": partial(cell.distance, near),
    }
    least = {key: timing.least * 1e6 for key, timing in race(tasks, repeats=7).items()}
    for call, case, ours, theirs in (
        ("Arms.free(q)", "one", least["one"], least["theirs"] / len(some)),
        ("Arms.in_collision(q)", f"batch of {given.batch}", least["batch"] / given.batch, least["theirs"] / len(some)),
        ("Arms.distance(q)", "batch of 256", least["distance"] / 256, least["their distance"] / 10),
    ):
        print(f"{call:22} {case:14} {ours:9.3f} us   pin + coal {theirs:9.2f} us   {theirs / ours:8.1f}x")
    diagram(cell.with_scene(()), alone)
    many = cell.random_configurations(given.verdicts)
    differ = int((cell.in_collision(many) != np.array(peer.verdicts(many))).sum())
    print(f"verdicts differ on {differ} of {given.verdicts}")


if __name__ == "__main__":
    main()
