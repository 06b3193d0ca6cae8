"""All poses of platforms on six legs for given lengths, complex ones included, by continuation; batches first.

1. Lengths over the size of each platform, ends about the middles of their bodies.
2. All poses of a start are followed to every row; rows where some are missing are tried again from other starts.
3. Ends that are not simple are judged: `platform_sets`. Poses that are nearly real are made real by Newton's method,
   which decides whether they are.

Memory: 3 kB times the number of poses of the start for each row of a block of BLOCK rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil import threads
from mafsil.arrays import Booleans, Floats
from mafsil.lazy_module import lazily
from mafsil.parallel.platforms.platform_sets import (
    CORRECTIONS,
    MOST,
    Complexes,
    judge_ends,
    pose_numbers,
    simple,
    start_platform,
    suspects,
)
from mafsil.parallel.tolerances import LENGTH, REAL, SAME

if TYPE_CHECKING:
    import mafsil.parallel.platforms.path_lane_loops as path_lane_loops
    import mafsil.parallel.platforms.path_loops as path_loops
    import mafsil.parallel.platforms.stewart_loops as stewart_loops
else:
    path_lane_loops = lazily("mafsil.parallel.platforms.path_lane_loops")
    path_loops = lazily("mafsil.parallel.platforms.path_loops")
    stewart_loops = lazily("mafsil.parallel.platforms.stewart_loops")

BLOCK = 256
PART = 16
"""Rows that a thread takes at once: some 10 ms of work."""
POLISH = 30
"""Most Newton steps that make a pose real; a double one needs them, others three."""


@dataclass(frozen=True, eq=False)
class Start:
    """A platform whose poses are known.

    Attributes:
        geometry: (6, 7) complex: ends on the base, on the platform, squares of lengths.
        poses: (m, 7) all its isolated poses.
    """

    geometry: Complexes
    poses: Complexes


def general_start(number: int) -> Start:
    """A general platform with its forty poses."""
    return Start(*start_platform(number))


def own_start(base: Floats, platform: Floats, number: int) -> Start:
    """All isolated poses of one platform (6, 3), (6, 3) of size one, for random complex lengths.

    A platform of special geometry has fewer than forty; its lengths then are followed from these only. Poses of general
    lengths are simple: other ends of paths are none.
    """
    rng = np.random.default_rng(1000 + number)
    goal = np.zeros((1, 6, 7), dtype=np.complex128)
    goal[0, :, :3], goal[0, :, 3:6] = base, platform
    goal[0, :, 6] = 2.0 + rng.normal(size=6) + 1j * rng.normal(size=6)
    kept, count, _ = distinct_poses(goal, [general_start(k) for k in range(len(CORRECTIONS))], MOST, real=False)
    return Start(goal[0], simple(kept[0, : int(count[0])], goal[0]))


def distinct_poses(
    ends: Complexes, starts: list[Start], expected: int, real: bool
) -> tuple[Complexes, NDArray[np.int64], NDArray[np.int64]]:
    """Poses that differ of each end (k, 6, 7): (k, n, 7), their number (k,), and paths that ended there (k, n)."""
    rows, most = len(ends), max(len(start.poses) for start in starts)
    kept = np.zeros((rows, most, 7), dtype=np.complex128)
    count, times = np.zeros(rows, dtype=np.int64), np.zeros((rows, most), dtype=np.int64)
    missing = np.arange(rows)
    for start, correction in zip(starts, CORRECTIONS, strict=True):
        if not len(missing) or not len(start.poses):
            break
        out = np.empty((len(missing), len(start.poses), 7), dtype=np.complex128)
        how = np.zeros(out.shape[:2], dtype=np.int8)
        _follow(start, ends[missing], correction, out, how)
        some, number, again = kept[missing], count[missing], np.zeros((len(missing), most), dtype=np.int64)
        path_loops.collect(out, how <= path_lane_loops.MERGED, SAME, real, some, number, again)
        kept[missing], count[missing] = some, number
        times[missing] = np.maximum(times[missing], again)
        missing = missing[number < expected]
    return kept, count, times


def _follow(start: Start, ends: Complexes, correction: float, out: Complexes, how: NDArray[np.int8]) -> None:
    """`path_lane_loops.follow_all` over the threads of this machine, a few rows at a time."""

    def part(k: int) -> None:
        rows = slice(k * PART, (k + 1) * PART)
        path_lane_loops.follow_all(start.geometry, ends[rows], start.poses, correction, out[rows], how[rows])

    threads.run(part, -(-len(ends) // PART), threads.available())


@dataclass(frozen=True, eq=False)
class AllPoses:
    """Poses of a batch of platforms.

    Attributes:
        x: (k, n, 7) real poses; NaN beyond their number.
        real: (k,) number of real poses that differ.
        finite: (k,) number of isolated poses that differ, complex ones included.
        paths: (k,) the same with multiplicity, and ends on sets of poses.
        on_set: (k,) number of paths that ended on sets of poses, which are not isolated.
        error: (k, n) largest error of a leg of each real pose, in units of the size.
        complexes: (k, n, 7) all poses.
    """

    x: Floats
    real: NDArray[np.int64]
    finite: NDArray[np.int64]
    paths: NDArray[np.int64]
    on_set: NDArray[np.int64]
    error: Floats
    complexes: Complexes


def all_poses(base: Floats, platform: Floats, lengths: Floats, starts: list[Start], expected: int) -> AllPoses:
    """All poses of platforms of size one, with ends (k, 6, 3) about their middles, for lengths (k, 6)."""
    ends = np.zeros((len(lengths), 6, 7), dtype=np.complex128)
    ends[..., :3], ends[..., 3:6], ends[..., 6] = base, platform, lengths**2
    # 2.
    blocks = range(0, len(ends), BLOCK) if len(ends) else [0]
    pieces = [distinct_poses(ends[k : k + BLOCK], starts, expected, real=True) for k in blocks]
    kept = np.concatenate([piece[0] for piece in pieces])
    count = np.concatenate([piece[1] for piece in pieces])
    times = np.concatenate([piece[2] for piece in pieces])
    there = np.asarray(np.arange(kept.shape[1])[None] < count[:, None], dtype=np.bool_)
    several, on_set = _several(kept, ends, times, there)
    isolated = there & (several > 0)
    # 3.
    near = isolated & (np.abs(pose_numbers(kept).imag).max(axis=-1) < REAL)
    x, error = np.full(kept.shape, np.nan), np.full(kept.shape[:2], np.nan)
    for row in np.flatnonzero(near.any(axis=1)).tolist():
        x[row], error[row] = _made_real(base[row], platform[row], lengths[row], kept[row], near[row])
    real = np.isfinite(error).sum(axis=1)
    paths = np.where(isolated, several, 0).sum(axis=1).astype(np.int64) + on_set
    return AllPoses(
        x, real, isolated.sum(axis=1), paths, on_set, error, np.where(isolated[..., None], kept, np.nan)
    )  # fmt: skip


def _several(
    kept: Complexes, ends: Complexes, times: NDArray[np.int64], there: Booleans
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(k, n) multiplicities of ends of paths, 0 on sets of poses, and (k,) how many are there; `kept` is made exact."""
    several, on_set = there.astype(np.int64), np.zeros(len(kept), dtype=np.int64)
    suspect, off = suspects(kept, ends[:, None])
    for row in np.flatnonzero(((suspect | off) & there).any(axis=1)).tolist():
        columns = np.flatnonzero((suspect | off)[row] & there[row])
        found = judge_ends(kept[row, columns], ends[row], times[row, columns])
        kept[row, columns], several[row, columns] = found.x, found.multiplicity
        on_set[row] = int(np.maximum(times[row, columns], 1)[found.multiplicity == 0].sum())
    return several, on_set


def _made_real(
    base: Floats, platform: Floats, lengths: Floats, poses: Complexes, near: Booleans
) -> tuple[Floats, Floats]:
    """Real poses in order of z, then x, and their errors; NaN after them."""
    guess = poses[near].real
    guess = guess / np.maximum(np.linalg.norm(guess[:, :4], axis=1), 1e-12)[:, None] ** np.array([1, 1, 1, 1, 0, 0, 0])
    n = len(guess)
    x, error, steps, pivot = np.empty((n, 7)), np.empty(n), np.zeros(n, dtype=np.int64), np.empty(n)
    limit = LENGTH * max(1.0, float(lengths.max()))
    wanted = np.tile(lengths, (n, 1))
    stewart_loops.newton(wanted, guess, base, platform, limit, POLISH, x, error, steps, pivot)
    moved = np.minimum(
        np.abs(x - guess).max(axis=1), np.abs(x + np.array([1, 1, 1, 1, -1, -1, -1]) * guess).max(axis=1)
    )
    fits = (error <= 100 * limit) & (moved < 10 * REAL)
    kept: list[int] = []
    for k in np.flatnonzero(fits).tolist():
        if all(float(path_loops.apart(x[k], x[j])) > SAME for j in kept):
            kept.append(k)
    order = sorted(kept, key=lambda k: (-round(x[k, 6], 9), round(x[k, 4], 9), round(x[k, 5], 9)))
    found, errors = np.full(poses.shape, np.nan), np.full(len(poses), np.nan)
    found[: len(order)], errors[: len(order)] = x[order], error[order]
    return found, errors


def nearly_real(x: Complexes, real: Floats) -> bool:
    """Whether a pose (7,) is one of the real ones (k, 7)."""
    return any(float(path_loops.apart(x, each.astype(np.complex128))) < 10 * REAL for each in real)
