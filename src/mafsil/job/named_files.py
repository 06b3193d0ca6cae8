"""Files that a job names beside its robots: meshes of obstacles, semantic descriptions."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np

from mafsil.collision import TriangleMesh
from mafsil.collision.srdf import disabled_pairs
from mafsil.errors import FileError
from mafsil.job.description import Job, Obstacle
from mafsil.job.lines import Path as Keys
from mafsil.job.lines import Places

MOST_ACROSS = 100.0
"""A mesh that is larger was probably meant in millimetres [m]."""


def mesh_of(obstacle: Obstacle, folder: Path) -> TriangleMesh:
    """The triangles of an obstacle that is a mesh, in metres.

    Args:
        obstacle: as the file has it.
        folder: to which its path is relative.

    Raises:
        FileError: no such file, another format, a damaged one.
    """
    assert obstacle.mesh is not None
    return TriangleMesh.from_file(folder / obstacle.mesh, scale=obstacle.scale)


def with_files(job: Job, folder: Path, places: Places) -> Job:
    """The same job with paths that hold from everywhere; each file was read once.

    Args:
        job: the job.
        folder: to which its paths are relative.
        places: of the keys, for errors.

    Raises:
        FileError: a file that cannot be read, with the place of the key that names it.
        JobError: a mesh so large that its numbers are probably millimetres.
    """
    obstacles = list(job.obstacle)
    for k, one in enumerate(obstacles):
        if one.mesh is None:
            continue
        try:
            size = float(np.ptp(mesh_of(one, folder).vertices, axis=0).max())
        except FileError as fault:
            raise places.of_file(fault, ("obstacle", k, "mesh")) from None
        if size > MOST_ACROSS:
            raise places.error("job.mesh_far", ("obstacle", k, "mesh"), size=f"{size:.3g}")
        obstacles[k] = msgspec.structs.replace(one, mesh=str((folder / one.mesh).resolve()))
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
    path = (folder / name).resolve()
    try:
        disabled_pairs(path)
    except FileError as fault:
        raise places.of_file(fault, keys) from None
    return str(path)
