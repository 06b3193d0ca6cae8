"""Files that a job names beside its robots: shapes of obstacles, semantic descriptions."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np

from mafsil.collision import ConvexHull, HeightMap, PointCloud, TriangleMesh
from mafsil.collision.srdf import disabled_pairs
from mafsil.errors import FileError, InputError
from mafsil.job.language.description import Job, Obstacle
from mafsil.job.language.text import Fault, Keys, Places
from mafsil.regular_file import whole_path

MOST_ACROSS = 100.0
"""What is larger was probably meant in millimetres [m]."""


def shape_of(obstacle: Obstacle, folder: Path) -> TriangleMesh | ConvexHull | PointCloud | HeightMap:
    """The shape of an obstacle that stands in a file, in metres.

    Args:
        obstacle: as the job has it.
        folder: to which its path is relative.

    Raises:
        FileError: no such file, another format, a damaged one, one too large.
        InputError: heights that do not lie above the underside.
    """
    if obstacle.cloud is not None:
        assert obstacle.radius is not None
        return PointCloud.from_file(folder / obstacle.cloud, obstacle.radius, scale=obstacle.scale)
    if obstacle.heights is not None:
        assert obstacle.size is not None
        return HeightMap.from_file(folder / obstacle.heights, obstacle.size, scale=obstacle.scale, base=obstacle.base)
    assert obstacle.mesh is not None
    mesh = TriangleMesh.from_file(folder / obstacle.mesh, scale=obstacle.scale)
    return ConvexHull(mesh.vertices) if obstacle.hull else mesh


def _across(shape: TriangleMesh | ConvexHull | PointCloud | HeightMap) -> float:
    """Largest extent of what stands in the file [m]."""
    match shape:
        case TriangleMesh(vertices=points) | ConvexHull(points=points) | PointCloud(points=points):
            return float(np.ptp(points, axis=0).max())
        case HeightMap(heights=heights):
            return float(np.ptp(heights))


def with_files(job: Job, folder: Path, places: Places) -> Job:
    """The same job with paths that hold from everywhere; each file was read once.

    Args:
        job: the job.
        folder: to which its paths are relative.
        places: of the keys, for errors.

    Raises:
        FileError: a file that cannot be read, with the place of the key that names it.
        JobError: a shape so large that its numbers are probably millimetres, or that cannot be.
    """
    obstacles = list(job.obstacle)
    for k, one in enumerate(obstacles):
        if one.file is None:
            continue
        key, path = one.file
        try:
            size = _across(shape_of(one, folder))
        except FileError as fault:
            raise places.of_file(fault, ("obstacle", k, key)) from None
        except InputError as fault:
            raise places.error("job.obstacle_shape", ("obstacle", k, key), fault=Fault(fault)) from None
        if size > MOST_ACROSS:
            raise places.error("job.mesh_far", ("obstacle", k, key), size=f"{size:.3g}")
        changed: dict[str, object] = {key: str(whole_path(folder / path))}
        obstacles[k] = msgspec.structs.replace(one, **changed)
    rule = job.collision
    if rule is not None and rule.srdf is not None:
        rule = msgspec.structs.replace(rule, srdf=_semantic(rule.srdf, folder, places, ("collision", "srdf")))
    others = list(job.other_robot)
    for k, other in enumerate(others):
        if other.srdf is not None:
            path = _semantic(other.srdf, folder, places, ("other_robot", k, "srdf"))
            others[k] = msgspec.structs.replace(other, srdf=path)
    return msgspec.structs.replace(job, obstacle=tuple(obstacles), collision=rule, other_robot=tuple(others))


def _semantic(name: str, folder: Path, places: Places, keys: Keys) -> str:
    """The whole path of a semantic description that can be read."""
    path = whole_path(folder / name)
    try:
        disabled_pairs(path)
    except FileError as fault:
        raise places.of_file(fault, keys) from None
    return str(path)
