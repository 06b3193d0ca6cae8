"""Assembly modes: all poses that a platform can be put together in for given lengths of its legs.

Assembly modes of many platforms on six legs at once, each of its own geometry; and of one with many lengths.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, Integers, as_batch
from mafsil.geometry import pose, rotation
from mafsil.geometry.quaternion import from_quaternion
from mafsil.messages import say
from mafsil.messages.tables import number, table
from mafsil.parallel.legs.leg_lines import line_matrix
from mafsil.parallel.platforms.nearest_lengths import LegEnds, NearestLengths
from mafsil.parallel.platforms.platform_paths import AllPoses, Start, all_poses, general_start
from mafsil.parallel.platforms.platform_sets import CORRECTIONS, MOST, real_pose_of_set


class AssemblyModesStatus(Status):
    """Whether all poses were found, and whether there are real ones."""

    ALL = ("parallel.modes_all", True)
    SOME = ("parallel.modes_some", False)
    NONE = ("parallel.modes_none", False)
    INCOMPLETE = ("parallel.modes_incomplete", True)
    INCOMPLETE_NONE = ("parallel.modes_incomplete_none", False)
    NOT_ISOLATED = ("parallel.modes_not_isolated", False)
    MOVABLE = ("parallel.modes_movable", True)
    ON_SET = ("parallel.modes_on_set", False)


@dataclass(frozen=True, eq=False, repr=False)
class PlatformModes(Answer, data="T count finite there expected error orientation"):
    """All poses of a platform for given lengths; true if there is a real one, iterable over the real ones.

    Of a batch: true if each row has one, iterable over the rows.

    Attributes:
        T: (*batch, n, 4, 4) real poses in {s}, higher ones first; of a batch NaN beyond their number, where `there` is
            false.
        count: (*batch,) number of real poses that differ.
        finite: (*batch,) number of isolated poses that differ, complex ones included.
        paths: (*batch,) the same, double ones counted twice, and ends of paths on sets of poses.
        on_set: (*batch,) number of paths that ended on sets of poses, along which the legs keep their lengths.
        through: (*batch, 4, 4) a real pose on such a set; NaN where there is none or none was found.
        expected: number of isolated poses of this geometry with general lengths; 40 if general.
        error: largest error of a leg over all real poses [m].
        orientation: (*batch, n) sign of det G of each, zero beyond their number: from + to - a platform passes a
            singular pose.
        legs: whose modes they are.
    """

    T: Floats
    count: Integers
    finite: Integers
    paths: Integers
    on_set: Integers
    through: Floats
    expected: int
    error: float
    orientation: Floats
    legs: LegEnds

    @property
    def there(self) -> Booleans:
        """(*batch, n) which places of `T` hold a pose."""
        return np.asarray(np.arange(self.T.shape[-3]) < self.count[..., None], dtype=np.bool_)

    @cached_property
    def nearest(self) -> NearestLengths:
        """The nearest lengths that the platform can have: of rows with a pose their own, else how far they are off."""
        first = self.T[..., 0, :, :] if self.T.shape[-3] else np.zeros((*self.count.shape, 4, 4))
        return self.legs.nearest_unless(np.asarray(self.count > 0), first)

    @property
    def missing(self) -> Floats:
        """(*batch,) distance of the lengths from the nearest ones that a pose has; zero where there is a pose [m]."""
        return self.nearest.distance

    @property
    def movable(self) -> Booleans:
        """(*batch,) whether a set of real poses was found: the platform moves with its legs locked."""
        return np.asarray(np.isfinite(self.through[..., 0, 0]), dtype=np.bool_)

    @property
    def status(self) -> AssemblyModesStatus:
        """Of all rows together."""
        complete, some = bool((self.paths >= self.expected).all()), bool(self.count.all())
        if not self.expected:
            return AssemblyModesStatus.NOT_ISOLATED
        if self.on_set.any():
            return AssemblyModesStatus.MOVABLE if self.movable.any() else AssemblyModesStatus.ON_SET
        if complete and self.count.any():
            return AssemblyModesStatus.ALL if some else AssemblyModesStatus.SOME
        if complete:
            return AssemblyModesStatus.NONE if self.count.size else AssemblyModesStatus.ALL
        return AssemblyModesStatus.INCOMPLETE if some else AssemblyModesStatus.INCOMPLETE_NONE

    def __bool__(self) -> bool:
        return self.status.succeeded or (self.status is AssemblyModesStatus.ON_SET and bool(self.count.all()))

    def __len__(self) -> int:
        return int(self.count) if self.count.ndim == 0 else int(self.count.shape[0])

    def __iter__(self) -> Iterator[Any]:
        if self.count.ndim == 0:
            return iter(self.T[: int(self.count)])
        return (self[k] for k in range(len(self)))

    def __getitem__(self, row: int) -> PlatformModes:
        """The modes of one row of a batch."""
        return PlatformModes(
            self.T[row], self.count[row, ...], self.finite[row, ...], self.paths[row, ...],
            self.on_set[row, ...], self.through[row], self.expected, self.error, self.orientation[row], self.legs[row],
        )  # fmt: skip

    def _table(self) -> list[str]:
        if self.count.ndim:
            return []
        head = (say("mobility.mode_head"), "x [m]", "y [m]", "z [m]", "det G")
        rows = [
            (str(k + 1), *map(number, T[:3, 3].tolist()), "+" if self.orientation[k] > 0 else "-")
            for k, T in enumerate(self)
        ]
        return table(head, rows) if rows else []

    def explain(self, language: str | None = None) -> str:
        """How many poses there are, real and complex, how exactly the legs fit; of one row without any how far off."""
        real, finite, status = self.count.reshape(-1), self.finite.reshape(-1), self.status
        if status is AssemblyModesStatus.NONE and self.count.ndim:
            status = AssemblyModesStatus.SOME
        sentence = status.sentence(
            language, real=_span(real), finite=_span(finite), expected=self.expected, error=self.error,
            missing=int((self.expected - self.paths).max(initial=0)), rows=self.count.size,
            reached=int((real > 0).sum()), most=int(real.max(initial=0)), on_set=int(self.on_set.sum()),
            movable=int(self.movable.sum()), place=self._place(),
        )  # fmt: skip
        if self.count.ndim or self.count or not self.expected or self.on_set:
            return sentence
        return sentence + say("parallel.nearest_lengths", language=language, **self.nearest.details())

    def _place(self) -> str:
        """Where the platform stands in the first pose on a set of real ones."""
        places = self.through[..., :3, 3].reshape(-1, 3)[self.movable.reshape(-1)]
        return ", ".join(map(number, places[0].tolist())) if len(places) else "-"

    def to_dict(self) -> dict[str, Any]:
        """Plain data; if rows have no pose, the nearest lengths too."""
        found = Answer.to_dict(self)
        if self.on_set.any():
            found |= {"on_set": self.on_set, "movable": self.movable, "through": self.through}
        elif not self.count.all() and self.expected:
            found["nearest"] = self.nearest.to_dict()
        return found


def _span(counts: Integers) -> str:
    if not counts.size:
        return "0"
    low, high = int(counts.min()), int(counts.max())
    return str(low) if low == high else f"{low}-{high}"


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
