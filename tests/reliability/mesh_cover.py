"""R21: what is checked of an arm contains every mesh vertex of example-robot-data, as Pinocchio reads and places them.

`python -m tests.reliability.mesh_cover --robots 69 --resume DIR`

Pinocchio's own reader (assimp) gives the vertices of the collision meshes, or of the visual ones where a file has no
others, in the frames of its links; our checker's bodies are taken as they come, without any setting. Vertices that no
triangle uses count too where Pinocchio keeps them. Also: the hulls of each body hold nothing beyond the convex hull of
its shapes' vertices by more than rounding, so that nothing is thickened.
"""

from __future__ import annotations

import sys
import warnings
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from mafsil import collision
from mafsil.collision import Checker
from mafsil.errors import MafsilError
from tests.reliability import figures

INSIDE = 1e-7
"""How far outside a vertex may be: files keep seven digits of most numbers, and readers differ in the last one [m]."""
MOST_VERTICES = 4_000
"""Of one mesh that are looked at; evenly through the file, and its extremes along 200 directions."""


@cache
def files() -> list[Path]:
    """All URDF files of example-robot-data."""
    import cmeel

    folder = Path(cmeel.__path__[0]).parent / "cmeel.prefix" / "share" / "example-robot-data" / "robots"
    return sorted(folder.rglob("*.urdf"))


def vertices_by_link(file: Path) -> dict[str, list[np.ndarray]]:
    """Vertices (k, 3) of every mesh in the frame of its link, as Pinocchio reads them."""
    import pinocchio as pin

    model = pin.buildModelFromUrdf(str(file))
    folders = [str(files()[0].parents[4]), str(files()[0].parents[5])]
    for kind in (pin.GeometryType.COLLISION, pin.GeometryType.VISUAL):
        shapes = pin.buildGeomFromUrdf(model, str(file), kind, package_dirs=folders)
        if len(shapes.geometryObjects):
            break
    found: dict[str, list[np.ndarray]] = {}
    for each in shapes.geometryObjects:
        own = _vertices(each.geometry)
        if own is not None:
            frame = model.frames[each.parentFrame]
            T = (frame.placement.inverse() * each.placement).homogeneous
            found.setdefault(frame.name, []).append(own @ T[:3, :3].T + T[:3, 3])
    return found


def _vertices(geometry: Any) -> np.ndarray | None:
    return np.array(geometry.vertices()) if hasattr(geometry, "vertices") else None


def some(vertices: np.ndarray) -> np.ndarray:
    """Vertices of a large mesh that say whether all are inside: its extremes along many directions, and others."""
    if len(vertices) <= MOST_VERTICES:
        return vertices
    directions = np.random.default_rng(21).normal(size=(200, 3))
    extremes = (vertices @ directions.T).argmax(axis=0)
    even = np.linspace(0, len(vertices) - 1, MOST_VERTICES).astype(np.intp)
    return vertices[np.unique([*extremes, *even])]


def work(seed: int, robots: int) -> dict[str, int]:
    """Counts of one shard: robots from `seed` times `robots` on."""
    names = ("robots", "without_shapes", "refused", "meshes", "vertices", "bad_vertex", "bad_link", "bad_thickened")
    counts = dict.fromkeys(names, 0)
    for file in files()[seed * robots : (seed + 1) * robots]:
        counts["robots"] += 1
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                checker = Checker(str(file), samples=0)
            except MafsilError as no:
                counts["without_shapes" if no.key == "collision.no_shapes" else "refused"] += 1
                continue
            theirs = vertices_by_link(file)
        for name, value in covered(checker, theirs).items():
            counts[name] += value
    return counts


def covered(checker: Checker, theirs: dict[str, list[np.ndarray]]) -> dict[str, int]:
    """Counts over the meshes of one robot: vertices outside their body, links without one, hulls that are larger."""
    counts = dict.fromkeys(("meshes", "vertices", "bad_vertex", "bad_link", "bad_thickened"), 0)
    bodies = {body.name: body for body in checker.bodies}
    for link, meshes in theirs.items():
        if link not in bodies:
            counts["bad_link"] += 1
            continue
        for vertices in map(some, meshes):
            counts["meshes"] += 1
            counts["vertices"] += len(vertices)
            outside = np.full(len(vertices), np.inf)
            for geometry, T in bodies[link].shapes:
                at = np.tile(np.eye(4), (len(vertices), 1, 1))
                at[:, :3, 3] = vertices
                apart = collision.distance(collision.Sphere(1e-9), geometry, at, np.tile(T, (len(vertices), 1, 1)))
                outside = np.minimum(outside, apart.distance)
            counts["bad_vertex"] += int((outside > INSIDE).sum())
        every = np.concatenate(meshes)
        directions = np.random.default_rng(7).normal(size=(64, 3))
        reach = (every @ directions.T).max(axis=0)
        for geometry, T in bodies[link].shapes:
            if isinstance(geometry, collision.ConvexHull):
                points = np.asarray(geometry.points) @ T[:3, :3].T + T[:3, 3]
                counts["bad_thickened"] += int(((points @ directions.T).max(axis=0) > reach + 1e-6).any())
    return counts


if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "robots", 69, 10)
    sys.exit(not figures.run("R21", options, work)["passed"])
