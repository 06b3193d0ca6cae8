"""Ends of paths that are no simple poses of a platform on six legs: multiple poses, points of sets, or no poses.

Complex platforms all of whose poses are known: where continuation starts. Made once in a process, from a fixed seed.

1. A random complex platform and a random pose give legs that fit: one pose is known.
2. The platform goes round a random triangle of platforms and comes back: the pose comes back as another one. Poses
   are gathered from rounds until there are forty, which is the most that isolated poses can be.
3. Further starts: the forty followed to other random platforms.

References: Raghavan, The Stewart platform of general geometry has 40 configurations, J. Mech. Design 115, 1993;
Duff and others, Solving polynomial systems via homotopy continuation and monodromy, IMA J. Num. Anal. 39, 2019.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Booleans, Floats
from mafsil.errors import MafsilError
from mafsil.lazy_module import lazily
from mafsil.parallel.tolerances import SAME
from mafsil.solvers.local_dimension import (
    SPLIT,
    Equations,
    Numbers,
    local_set,
    multiplicity,
    null_directions,
    solved_in_planes,
)

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
SUSPECT = 1e-8
"""Determinant over the product of the lengths of its rows below which a pose may not be simple; double ones stand at
1e-11."""
SIMPLE = 1e-12
"""The same of the ends of paths to general lengths, where all poses are simple, though some are far away."""
FITS = 1e-8
"""What legs may miss of a pose, over the squares of their lengths and of its place."""
LOOSE = 1e-7
"""Least singular value over the largest at a pose that is not simple: of a multiple one the root of rounding."""
CLOSED = 1e-13
"""Gaps up to it are closed: a few hundred roundings of polynomials of degree four."""
STARTS = 96
"""Of searches for a real pose on a set."""


def suspects(x: Complexes, ends: Complexes) -> tuple[Booleans, Booleans]:
    """(*batch,) which poses (*batch, 7) of ends (*batch, 6, 7) may not be simple, and which do not fit."""
    d, miss = _legs(x, ends)
    M = np.concatenate([np.cross(ends[..., :3], d), d], axis=-1)
    lengths = np.linalg.norm(M, axis=-1).prod(axis=-1)
    with np.errstate(invalid="ignore"):
        off = ~(np.abs(miss).max(axis=-1) <= FITS * (1.0 + (np.abs(d) ** 2).sum(axis=-1).max(axis=-1)))
        return np.asarray(np.abs(np.linalg.det(M)) < SUSPECT * lengths), np.asarray(off)


def simple(x: Complexes, ends: Complexes) -> Complexes:
    """Of poses (m, 7) of one platform (6, 7) with general lengths those that fit and are simple."""
    d, _ = _legs(x, ends[None])
    M = np.concatenate([np.cross(ends[None, :, :3], d), d], axis=-1)
    regular = np.abs(np.linalg.det(M)) > SIMPLE * np.linalg.norm(M, axis=-1).prod(axis=-1)
    return x[regular & ~suspects(x, ends[None])[1]]


def _legs(x: Numbers, ends: Numbers) -> tuple[Numbers, Numbers]:
    """Leg vectors d (*batch, 6, 3), and d.d - s^2 (*batch, 6)."""
    w, v, p = x[..., None, :1], x[..., None, 1:4], x[..., None, 4:]
    b = ends[..., 3:6]
    d = p + b + 2 * np.cross(v, w * b + np.cross(v, b)) - ends[..., :3]
    return d, (d * d).sum(axis=-1) - ends[..., 6]


def pose_equations(ends: Numbers, near: Numbers) -> Equations:
    """(d.d - s^2) / 2 of each leg over what it is made of near a pose (7,), and (q.q - 1) / 2, of poses (k, 7)."""
    b, over = ends[:, 3:6], 1.0 / (1.0 + np.abs(ends[:, 6]) + float((np.abs(near[4:]) ** 2).sum()))

    def equations(x: Numbers) -> tuple[Numbers, Numbers]:
        d, miss = _legs(x, ends[None])
        w, v = x[:, None, :1], x[:, None, 1:4]
        F, J = np.zeros((len(x), 7), dtype=x.dtype), np.zeros((len(x), 7, 7), dtype=x.dtype)
        F[:, :6], F[:, 6] = miss / 2 * over, ((x[:, :4] ** 2).sum(axis=1) - 1) / 2
        inner = w * b + np.cross(v, b)
        J[:, :6, 0] = 2 * (d * np.cross(v, b)).sum(axis=-1)
        for k, e in enumerate(np.eye(3)):
            J[:, :6, 1 + k] = 2 * (d * (np.cross(e, inner) + np.cross(v, np.cross(e, b)))).sum(axis=-1)
        J[:, :6, 4:], J[:, 6, :4] = d, x[:, :4]
        J[:, :6] *= over[:, None]
        return F, J

    return equations


@dataclass(frozen=True, eq=False)
class Ends:
    """What ends of paths are.

    Attributes:
        x: (m, 7) poses, made exact.
        multiplicity: (m,) of isolated poses; 0 on a set of poses, -1 where no pose is or one of before is met again.
    """

    x: Complexes
    multiplicity: NDArray[np.intp]


def judge_ends(x: Complexes, ends: Complexes, times: NDArray[np.int64]) -> Ends:
    """What ends (m, 7) of paths to one platform (6, 7) of size one are.

    1. Newton's method to rounding; what it does not close is no pose.
    2. Null directions, and what is around: a set, or an isolated pose. Along one null direction the gap grows with its
       multiplicity; of d of them that have no linear term it is 2^d or more, told by the paths that ended there.
    3. What is found several times is one.

    Args:
        x: rough.
        ends: of the legs, and squares of their lengths.
        times: (m,) paths that ended in each.
    """
    equations, m = pose_equations(ends, np.zeros(7)), len(x)
    x, _ = solved_in_planes(equations, x, np.zeros((m, 0, 7)), 1.0, closed=0.0)  # 1
    several = np.where(suspects(x, ends[None])[1], -1, 1)
    for k in np.flatnonzero(several > 0).tolist():  # 2
        found = multiplicity(pose_equations(ends, x[k]), x[k], LOOSE, CLOSED)
        several[k] = max(found, int(times[k])) if found > 3 else found
    kept = list[int]()
    for k in np.flatnonzero(several > 0).tolist():  # 3
        if all(np.abs(pose_numbers(x[k]) - pose_numbers(x[j])).max() > SPLIT ** (1 / several[k]) for j in kept):
            kept.append(k)
        else:
            several[k] = -1
    return Ends(x, several)


def real_pose_of_set(ends: Floats, seed: int = 0) -> Floats | None:
    """(7,) a real pose on a set of real poses of one platform (6, 7) of size one, if one is found from random starts.

    Args:
        ends: of the legs, and squares of their lengths.
        seed: of the starts.
    """
    rng, far = np.random.default_rng(seed), float(np.sqrt(ends[:, 6]).max()) + 1.0
    starts = np.concatenate([rng.normal(size=(STARTS, 4)), rng.uniform(-far, far, (STARTS, 3))], axis=1)
    starts[:, :4] /= np.linalg.norm(starts[:, :4], axis=1, keepdims=True)
    equations = pose_equations(ends, np.zeros(7))
    x, gap = solved_in_planes(equations, starts, np.zeros((STARTS, 0, 7)), 1.0, closed=CLOSED / 10)
    for each in x[gap <= CLOSED]:
        K = null_directions(equations(each[None])[1][0], LOOSE)
        tried = rng.normal(size=(4 * K.shape[1], K.shape[1])) @ K.T
        if (
            len(tried)
            and local_set(equations, each, tried / np.linalg.norm(tried, axis=1, keepdims=True), CLOSED).dimension
        ):
            return each
    return None


def pose_numbers(x: Complexes) -> Complexes:
    """(..., 13) what a pose (..., 7) means: products of its quaternion with its largest entry, squares, the place."""
    q = x[..., :4]
    largest = np.take_along_axis(q, np.abs(q).argmax(axis=-1)[..., None], axis=-1)
    return np.concatenate([q * largest, q**2, x[..., 4:]], axis=-1)


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
