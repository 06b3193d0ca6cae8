"""Ends of paths that are no simple poses of a platform on six legs: multiple poses, points of sets, or no poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Booleans, Floats
from mafsil.parallel.platforms.start_platforms import Complexes
from mafsil.solvers.local_dimension import (
    SPLIT,
    Equations,
    Numbers,
    local_set,
    multiplicity,
    null_directions,
    solved_in_planes,
)

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
