"""Complex platforms all of whose poses are known: where continuation starts. Made once in a process, from a fixed seed.

1. A random complex platform and a random pose give legs that fit: one pose is known.
2. The platform goes round a random triangle of platforms and comes back: the pose comes back as another one. Poses
   are gathered from rounds until there are forty, which is the most that isolated poses can be.
3. Further starts: the forty followed to other random platforms.

References: Raghavan, The Stewart platform of general geometry has 40 configurations, J. Mech. Design 115, 1993;
Duff and others, Solving polynomial systems via homotopy continuation and monodromy, IMA J. Num. Anal. 39, 2019.
"""

from __future__ import annotations

import itertools
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.errors import MafsilError
from mafsil.lazy_module import lazily
from mafsil.parallel.tolerances import SAME

if TYPE_CHECKING:
    import mafsil.parallel.platforms.path_lane_loops as path_lane_loops
    import mafsil.parallel.platforms.path_loops as path_loops
else:
    path_lane_loops = lazily("mafsil.parallel.platforms.path_lane_loops")
    path_loops = lazily("mafsil.parallel.platforms.path_loops")

Complexes = NDArray[np.complex128]

MOST = 40
"""Isolated poses of a platform on six legs, complex ones included: never more (Raghavan 1993)."""
MOST_ROUNDS = 60
"""Of step 2; with random rounds forty are there after about ten."""
CORRECTIONS = (1e-3, 1e-4, 1e-5)
"""Shares of a pose that a corrector may move, from the first attempt to the last."""


@lru_cache(maxsize=4)
def start_platform(number: int) -> tuple[Complexes, Complexes]:
    """A complex platform (6, 7), ends and squares of lengths, with all its forty poses (40, 7).

    Raises:
        MafsilError: not all forty were found, which happens on no machine so far.
    """
    rng = np.random.default_rng(number)
    if number:
        goal, (geometry, poses) = random_platform(rng), start_platform(0)
        found = follow_paths(geometry, goal[None], poses)[0]
        if len(found) != MOST:
            raise MafsilError("parallel.starts", count=len(found), most=MOST)
        return goal, found
    # 1.
    geometry = random_platform(rng)
    x = _complex(rng, 7)
    x[:4] /= np.sqrt((x[:4] ** 2).sum())
    geometry[:, 6] = squares(x, geometry)
    poses = x[None]
    # 2.
    for _ in range(MOST_ROUNDS):
        came = poses
        corners = [geometry, random_platform(rng), random_platform(rng), geometry]
        for start, end in itertools.pairwise(corners):
            came = follow_paths(start, end[None], came)[0]
        poses = distinct(np.concatenate([poses, came])[None])[0]
        if len(poses) == MOST:
            return geometry, poses
    raise MafsilError("parallel.starts", count=len(poses), most=MOST)


def _complex(rng: np.random.Generator, *shape: int) -> Complexes:
    return rng.normal(size=shape) + 1j * rng.normal(size=shape)


def random_platform(rng: np.random.Generator) -> Complexes:
    """(6, 7) random complex ends and squares of lengths."""
    return _complex(rng, 6, 7)


def squares(x: Complexes, geometry: Complexes) -> Complexes:
    """(6,) squares of the lengths of a platform in a pose (7,): d.d, without conjugation."""
    w, i, j, k = x[:4]
    R = np.array(
        [
            [1 - 2 * (j * j + k * k), 2 * (i * j - w * k), 2 * (i * k + w * j)],
            [2 * (i * j + w * k), 1 - 2 * (i * i + k * k), 2 * (j * k - w * i)],
            [2 * (i * k - w * j), 2 * (j * k + w * i), 1 - 2 * (i * i + j * j)],
        ]
    )
    d = x[4:] + geometry[:, 3:6] @ R.T - geometry[:, :3]
    return np.asarray((d * d).sum(axis=1))


def follow_paths(
    start: Complexes, ends: Complexes, poses: Complexes, correction: float = CORRECTIONS[0]
) -> list[Complexes]:
    """Poses that differ at each end (k, 6, 7), from all poses (m, 7) of a start (6, 7)."""
    out = np.empty((len(ends), len(poses), 7), dtype=np.complex128)
    how = np.zeros((len(ends), len(poses)), dtype=np.int8)
    path_lane_loops.follow_all(start, ends, np.ascontiguousarray(poses), correction, out, how)
    return distinct(np.where((how == path_lane_loops.ARRIVED)[..., None], out, np.nan))


def distinct(poses: Complexes) -> list[Complexes]:
    """Of each row of poses (k, m, 7) those that differ; NaN are none."""
    kept = np.zeros((len(poses), poses.shape[1], 7), dtype=np.complex128)
    count, times = np.zeros(len(poses), dtype=np.int64), np.zeros(kept.shape[:2], dtype=np.int64)
    all_of_them = np.ones(poses.shape[:2], dtype=np.bool_)
    path_loops.collect(np.ascontiguousarray(poses), all_of_them, SAME, False, kept, count, times)
    return [row[:n].copy() for row, n in zip(kept, count.tolist(), strict=True)]
