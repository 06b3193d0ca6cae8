"""Poses of a platform on rods: the answer, the crossing of spheres, and a search."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, Integers
from mafsil.geometry import pose
from mafsil.parallel.tolerances import FEASIBLE, SAME

STARTS = 60
"""Of a search."""
TOUCHING = 1e-13
"""Squares below it, over the largest, are rounding: spheres that nearly touch do."""


class RodPosesStatus(Status):
    """Whether poses were found."""

    ALL = ("parallel.rod_poses_all", True)
    SOME = ("parallel.rod_poses_some", True)
    NEAR = ("parallel.rod_poses_near", True)
    NONE = ("parallel.rod_poses_none", False)
    NOT_FOUND = ("parallel.rod_poses_not_found", False)


class HasCoordinates(Protocol):
    """A robot whose poses have short coordinates."""

    @property
    def size(self) -> float:
        """Of the robot [m]."""
        ...

    def coordinates(self, T: Floats) -> Floats:
        """Short coordinates of poses."""
        ...


@dataclass(frozen=True, eq=False, repr=False)
class RodPoses(Answer, data="x count miss"):
    """Poses for coordinates of the motors; true if every row has one, iterable over them, of a batch over its rows.

    Attributes:
        T: (*batch, k, 4, 4) poses, NaN beyond the number of each row.
        x: (*batch, k, m) the same as short coordinates; of six motions T itself.
        count: (*batch,) how many.
        miss: largest error of a rod [m].
        complete: whether there are no others.
        single: whether one was asked for, from a first guess.
    """

    T: Floats
    x: Floats
    count: Integers
    miss: float
    complete: bool
    single: bool

    @classmethod
    def of(cls, robot: HasCoordinates, T: Floats, miss: Floats, *, complete: bool, single: bool = False) -> RodPoses:
        """Of poses (*batch, k, 4, 4) and what their rods miss (*batch, k): those that fit, first in each row."""
        fits = np.asarray(miss <= FEASIBLE * robot.size)
        order = np.argsort(~fits, axis=-1, kind="stable")
        T = np.take_along_axis(np.where(fits[..., None, None], T, np.nan), order[..., None, None], axis=-3)
        count = fits.sum(axis=-1)
        T = T[..., : int(count.max(initial=0)), :, :]
        worst = float(miss[fits].max(initial=0.0))
        return cls(T, robot.coordinates(T), np.asarray(count, dtype=np.intp), worst, complete, single)

    @property
    def there(self) -> Booleans:
        """(*batch, k) which entries are poses."""
        return np.asarray(np.isfinite(self.T[..., 0, 0]), dtype=np.bool_)

    @property
    def status(self) -> RodPosesStatus:
        """Of all rows together."""
        if not (self.count > 0).all():
            return RodPosesStatus.NONE if self.complete else RodPosesStatus.NOT_FOUND
        return RodPosesStatus.NEAR if self.single else RodPosesStatus.ALL if self.complete else RodPosesStatus.SOME

    def __len__(self) -> int:
        return int(self.count) if self.count.ndim == 0 else len(self.count)

    def __iter__(self) -> Iterator[Floats]:
        return iter(self.x[: int(self.count)] if self.count.ndim == 0 else self.x)

    def explain(self, language: str | None = None) -> str:
        """How many poses, how many rows have none, and how well the rods fit."""
        missed = int((self.count == 0).sum())
        return self.status.sentence(
            language, poses=int(self.count.sum()), rows=self.count.size, missed=missed, miss=self.miss
        )


def crossing_of_spheres(C: Floats, r: Floats) -> Floats:
    """(k, 2, 3) both points at distances r (k, m) from centres C (k, m, 3): of three in space, of two in a plane z.

    NaN where they do not meet, or the centres are on one line. The lower one first; of a plane that to the left of the
    way from the first centre to the second.
    """
    way = C[:, 1] - C[:, 0]
    if C.shape[1] == 2:
        way = way * np.array([1.0, 1.0, 0.0])
    d = np.linalg.norm(way, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        e = way / d
        x = (r[:, :1] ** 2 - r[:, 1:2] ** 2 + d**2) / (2 * d)
        rest = r[:, :1] ** 2 - x**2
        if C.shape[1] == 2:
            n, middle = np.cross(np.array([0.0, 0.0, 1.0]), e), C[:, 0] * np.array([1.0, 1.0, 0.0]) + x * e
        else:
            other = C[:, 2] - C[:, 0]
            i = (other * e).sum(axis=-1, keepdims=True)
            aside = other - i * e
            j = np.linalg.norm(aside, axis=-1, keepdims=True)
            f = aside / j
            y = (r[:, :1] ** 2 - r[:, 2:3] ** 2 + (other**2).sum(axis=-1, keepdims=True)) / (2 * j) - i / j * x
            n, middle, rest = np.cross(e, f), C[:, 0] + x * e + y * f, rest - y**2
        rest = np.where(np.abs(rest) < TOUCHING * r[:, :1] ** 2, 0.0, rest)
        h = np.sqrt(np.where(rest < 0.0, np.nan, rest))
    both = np.stack([middle + h * n, middle - h * n], axis=1)
    if C.shape[1] == 2:
        return both
    order = np.argsort(both[..., 2], axis=1)
    return np.take_along_axis(both, order[..., None], axis=1)


def search_poses(
    robot: HasCoordinates, C: Floats, l: Floats, newton: Callable[[Floats, Floats, Floats], tuple[Floats, Floats]]
) -> Floats:
    """(k, n, 4, 4) poses that Newton's method finds from random starts, NaN beyond the number of each row."""
    rng, rows = np.random.default_rng(0), len(C)
    T = np.tile(np.eye(4), (rows, STARTS, 1, 1))
    turn = np.zeros((rows, STARTS, 6))
    turn[..., 2] = rng.uniform(-np.pi, np.pi, (rows, STARTS))
    T = pose.exp(turn) @ T
    T[..., :3, 3] = C.mean(axis=1)[:, None] + robot.size * rng.uniform(-1.0, 1.0, (rows, STARTS, 3))
    flat = T.reshape(-1, 4, 4)
    found, miss = newton(np.repeat(C, STARTS, axis=0), np.repeat(l, STARTS, axis=0), flat)
    kept: list[list[Floats]] = []
    for each, off in zip(found.reshape(T.shape), miss.reshape(rows, STARTS), strict=True):
        own: list[Floats] = []
        for one in each[off <= FEASIBLE * robot.size]:
            if all(np.abs(one - other).max() > SAME * max(1.0, robot.size) for other in own):
                own.append(one)
        kept.append(own)
    result = np.full((rows, max((len(each) for each in kept), default=0), 4, 4), np.nan)
    for k, own in enumerate(kept):
        result[k, : len(own)] = np.array(own).reshape(-1, 4, 4)
    return result
