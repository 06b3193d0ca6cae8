"""Assembly modes of many platforms on six legs at once, each of its own geometry; and of one with many lengths."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch
from mafsil.geometry import pose, rotation
from mafsil.geometry.quaternion import from_quaternion
from mafsil.parallel.legs.leg_lines import line_matrix
from mafsil.parallel.platforms.assembly_modes import PlatformModes
from mafsil.parallel.platforms.nearest_lengths import LegEnds
from mafsil.parallel.platforms.platform_paths import AllPoses, Start, all_poses, general_start
from mafsil.parallel.platforms.platform_sets import real_pose_of_set
from mafsil.parallel.platforms.start_platforms import CORRECTIONS, MOST


def stewart_assembly_modes(base: ArrayLike, platform: ArrayLike, lengths: ArrayLike) -> PlatformModes:
    """All poses of many platforms on six legs, each followed from a general platform with its forty poses.

    For one platform with many lengths `StewartPlatform.forward_kinematics` is faster and knows how many poses its
    geometry has; here a special geometry is said to lack poses, which lie at infinity.

    Args:
        base, platform: (*batch, 6, 3) ends of the legs in {s} and in {b} [m].
        lengths: (*batch, 6) of the legs [m].

    Returns:
        Modes of every row; as memory, 11 kB for each row.
    """
    a, b = as_batch("base", base, (6, 3), finite=True), as_batch("platform", platform, (6, 3), finite=True)
    s = as_batch("lengths", lengths, (6,), finite=True)
    shape = np.broadcast_shapes(a.shape[:-2], b.shape[:-2], s.shape[:-1])
    starts = [general_start(number) for number in range(len(CORRECTIONS))]
    a, b = np.broadcast_to(a, (*shape, 6, 3)), np.broadcast_to(b, (*shape, 6, 3))
    return modes_of(a, b, np.broadcast_to(s, (*shape, 6)), starts, MOST)


def of_size_one(base: Floats, platform: Floats) -> tuple[Floats, Floats, Floats]:
    """Ends (*batch, 6, 3) about the middles of their bodies over the size, and the size (*batch,) [m].

    The size is the largest distance of an end from the middle of its body: lengths are judged over it.
    """
    a, b = (p - p.mean(axis=-2, keepdims=True) for p in (base, platform))
    size = np.linalg.norm(np.concatenate([a, b], axis=-2), axis=-1).max(axis=-1)
    size = np.where(size > 0.0, size, 1.0)
    return a / size[..., None, None], b / size[..., None, None], size


def modes_of(base: Floats, platform: Floats, lengths: Floats, starts: Sequence[Start], expected: int) -> PlatformModes:
    """The modes of platforms (*batch, 6, 3), (*batch, 6, 3) with lengths (*batch, 6), from starts with known poses."""
    shape = lengths.shape[:-1]
    a, b = base.reshape(-1, 6, 3), platform.reshape(-1, 6, 3)
    reduced_a, reduced_b, size = of_size_one(a, b)
    s = np.abs(lengths.reshape(-1, 6)) / size[:, None]
    found = all_poses(reduced_a, reduced_b, s, list(starts), expected)
    T, sign = _in_metres(found, a, b, size)
    through = np.full((len(a), 4, 4), np.nan)
    for row in np.flatnonzero(found.on_set).tolist():
        ends = np.concatenate([reduced_a[row], reduced_b[row], (s[row] ** 2)[:, None]], axis=1)
        x = real_pose_of_set(ends)
        if x is not None:
            through[row] = _place(x[None], a[row, None], b[row, None], size[row, None])[0]
    error = float((np.nan_to_num(found.error) * size[:, None]).max(initial=0.0))
    count, finite, paths, on_set = (
        each.reshape(shape) for each in (found.real, found.finite, found.paths, found.on_set)
    )
    return PlatformModes(
        T.reshape(*shape, *T.shape[1:]), count, finite, paths, on_set, through.reshape(*shape, 4, 4), expected, error,
        sign.reshape(*shape, T.shape[1]), LegEnds(base, platform, lengths),
    )  # fmt: skip


def _in_metres(found: AllPoses, a: Floats, b: Floats, size: Floats) -> tuple[Floats, Floats]:
    """Poses (k, n, 4, 4), NaN beyond their number, and signs of det G (k, n), zero there."""
    x = found.x[:, : int(found.real.max(initial=0))]
    T, sign = np.full((*x.shape[:2], 4, 4), np.nan), np.zeros(x.shape[:2])
    row, column = np.nonzero(np.isfinite(x).all(axis=-1))
    if not len(row):
        return T, sign
    place = _place(x[row, column], a[row], b[row], size[row])
    d = place[:, None, :3, 3] + b[row] @ np.swapaxes(place[:, :3, :3], -1, -2) - a[row]
    T[row, column], sign[row, column] = place, np.sign(np.linalg.det(line_matrix(a[row], d)))
    return T, sign


def _place(x: Floats, a: Floats, b: Floats, size: Floats) -> Floats:
    """(k, 4, 4) poses in metres of rows (k, 7) of platforms of size one, about the middles of their bodies."""
    T = poses_of(x)
    turned = np.einsum("kij,kj->ki", T[:, :3, :3], b.mean(axis=1))
    T[:, :3, 3] = size[:, None] * T[:, :3, 3] + a.mean(axis=1) - turned
    return T


def poses_of(x: Floats) -> Floats:
    """(*batch, 4, 4) poses of rows (w, x, y, z, p) (*batch, 7)."""
    if not len(x):
        return np.zeros((*x.shape[:-1], 4, 4))
    return pose.from_rotation_translation(rotation.project(from_quaternion(x[..., :4])), x[..., 4:])
