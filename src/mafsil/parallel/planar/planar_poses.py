"""All poses of a planar platform as an answer: its assembly modes, or the sentence why there are none.

Where three rods come nearest to meeting if they cannot: distances from their ends that fit best, by least squares.

Away from the plane of the ends, f(p) = sum (|p - C_k| - l_k)^2 / 2 is level only where the rods meet: its gradient
sum w_k (p - C_k), w_k = 1 - l_k / |p - C_k|, needs sum w_k = 0 across the plane and then sum w_k C_k = 0 in it. So the
least value of rods that do not meet lies in that plane.

1. Starts around the middle of the ends, in their plane.
2. Newton's method with both eigenvalues of the Hessian made positive; a step that does not lead down is shortened.
3. Of all starts the least. That there is nothing nearer is not proven.

Reference: Nocedal and Wright, Numerical Optimization, 2006, sec. 3.4.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, Integers
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.messages.tables import number, table
from mafsil.parallel.platforms.nearest_lengths import LegEnds, NearestLengths

STARTS, STEPS = 6, 60
SETTLED = 1e-13
"""Steps over the size after which nothing changes any more."""
FLAT = 1e-9
"""Eigenvalues below it count as this much: of a pair of rods it is one at most."""
TINY = 1e-12
"""Of a rod whose direction turns, over the size."""


class PlanarPosesStatus(Status):
    """Whether the platform can be put together, and whether it stays movable then."""

    ALL = ("parallel.planar_all", True)
    SOME = ("parallel.planar_some", False)
    NONE = ("parallel.planar_none", False)
    MOVABLE = ("parallel.planar_movable", True)


@dataclass(frozen=True, eq=False, repr=False)
class PlanarPoses(Answer, data="x count there multiplicity movable error"):
    """All real poses of a planar platform; true if every row has one, iterable over the poses, of a batch over rows.

    Attributes:
        x: (*batch, n, 3) isolated poses (x, y, phi), by ascending phi in (-pi, pi]; of a batch NaN beyond their number,
            where `there` is false [m, rad].
        count: (*batch,) number of them, that differ.
        multiplicity: (*batch, n) of each: 1 of a simple pose, 2 of a double one; zero beyond their number.
        movable: (*batch,) whether there is a curve of poses besides: the platform moves with its actuators locked.
        error: largest error of a length [m].
        legs: whose poses they are.
    """

    x: Floats
    count: Integers
    multiplicity: Integers
    movable: Booleans
    error: float
    legs: LegEnds

    @property
    def there(self) -> Booleans:
        """(*batch, n) which places of `x` hold a pose."""
        return np.asarray(np.arange(self.x.shape[-2]) < self.count[..., None], dtype=np.bool_)

    @cached_property
    def nearest(self) -> NearestLengths:
        """The nearest lengths that the platform can have: of rows with a pose their own, else how far they are off."""
        first = self.x[..., 0, :] if self.x.shape[-2] else np.zeros((*self.count.shape, 3))
        return self.legs.nearest_unless(np.asarray(self.count > 0), first)

    @property
    def missing(self) -> Floats:
        """(*batch,) distance of the lengths from the nearest ones that a pose has; zero where there is a pose [m]."""
        return self.nearest.distance

    @property
    def status(self) -> PlanarPosesStatus:
        """Of all rows together."""
        if self.movable.any():
            return PlanarPosesStatus.MOVABLE
        if self.count.all():
            return PlanarPosesStatus.ALL
        return PlanarPosesStatus.SOME if self.count.any() else PlanarPosesStatus.NONE

    def __len__(self) -> int:
        return int(self.count) if self.count.ndim == 0 else int(self.count.shape[0])

    def __iter__(self) -> Iterator[Any]:
        if self.count.ndim == 0:
            return iter(self.x[: int(self.count)])
        return (self[k] for k in range(len(self)))

    def __getitem__(self, row: int) -> PlanarPoses:
        """The poses of one row of a batch."""
        return PlanarPoses(
            self.x[row], self.count[row, ...], self.multiplicity[row], self.movable[row, ...], self.error,
            self.legs[row],
        )  # fmt: skip

    def _table(self) -> list[str]:
        if self.count.ndim:
            return []
        head = (say("mobility.mode_head"), "x [m]", "y [m]", "phi [deg]", say("parallel.multiplicity_head"))
        rows = [
            (str(k + 1), *map(number, [*x[:2].tolist(), float(np.degrees(x[2]))]), str(self.multiplicity[k]))
            for k, x in enumerate(self)
        ]
        return table(head, rows) if rows else []

    def explain(self, language: str | None = None) -> str:
        """How many poses there are, and how exactly the lengths fit; of one row without any how far they are off."""
        if self.status is PlanarPosesStatus.NONE and self.count.ndim == 0:
            return self.status.sentence(language, **self.nearest.details())
        status = PlanarPosesStatus.SOME if self.status is PlanarPosesStatus.NONE else self.status
        low, high = int(self.count.min(initial=99)), int(self.count.max(initial=0))
        return status.sentence(
            language, count=str(high) if low >= high else f"{low}-{high}", most=high, rows=self.count.size,
            reached=int((self.count > 0).sum()), movable=int(self.movable.sum()), error=self.error,
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Plain data; if rows have no pose, the nearest lengths too."""
        found = Answer.to_dict(self)
        if not (self.count.all() or self.movable.any()):
            found["nearest"] = self.nearest.to_dict()
        return found


def nearest_places(ends: Floats, lengths: Floats) -> Floats:
    """(k, 3) points nearest to rods from ends (k, 3, 3) of lengths (k, 3), that do not meet [m]."""
    middle = ends.mean(axis=1)
    size = np.maximum(np.abs(ends - middle[:, None]).max(axis=(1, 2)), lengths.max(axis=1))
    first, second = _basis(ends)
    away = (ends - middle[:, None]) / size[:, None, None]
    flat = np.stack([(away * first[:, None]).sum(axis=-1), (away * second[:, None]).sum(axis=-1)], axis=-1)
    # 1.
    angle = 2 * np.pi * (np.arange(STARTS) + 0.25) / STARTS
    around = (lengths.mean(axis=1) / size)[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    C, s = np.repeat(flat, STARTS, axis=0), np.repeat(lengths / size[:, None], STARTS, axis=0)
    # 2. and 3.
    p = _descend(C, s, around.reshape(-1, 2))
    value = _slopes(C, s, p)[0].reshape(-1, STARTS)
    best = p.reshape(-1, STARTS, 2)[np.arange(len(ends)), value.argmin(axis=1)] * size[:, None]
    return middle + best[:, :1] * first + best[:, 1:] * second


def _basis(ends: Floats) -> tuple[Floats, Floats]:
    """Two orthonormal directions (k, 3) each of the plane of three points, any plane of points on one line."""
    _, _, rows = np.linalg.svd(ends - ends.mean(axis=1, keepdims=True))
    return rows[:, 0], rows[:, 1]


def _descend(C: Floats, s: Floats, p: Floats) -> Floats:
    """Points (k, 2) at minima of f, for ends (k, 3, 2), lengths (k, 3) and starts (k, 2) of size one."""
    p, live, bound = p.copy(), np.arange(len(p)), np.full(len(p), 0.5)
    for _ in range(STEPS):
        value, g, H = _slopes(C[live], s[live], p[live])
        step = -_against(H, g)
        length = np.linalg.norm(step, axis=1)
        step *= np.minimum(1.0, bound[live] / np.maximum(length, SETTLED))[:, None]
        after = p[live] + step
        down = _slopes(C[live], s[live], after)[0] < value
        p[live[down]] = after[down]
        taken = np.minimum(length, bound[live])
        bound[live] = np.where(down, 2 * bound[live], taken / 4)
        live = live[taken > SETTLED]
        if not len(live):
            break
    return p


def _slopes(C: Floats, s: Floats, p: Floats) -> tuple[Floats, Floats, Floats]:
    """f (k,), its gradient (k, 2), and its Hessian as (k, 3): xx, xy, yy."""
    d = p[:, None] - C
    far = np.linalg.norm(d, axis=-1)
    u, missed = d / np.maximum(far, TINY)[..., None], far - s
    bend = missed / np.maximum(far, TINY)
    x, y = u[..., 0], u[..., 1]
    H = np.stack([x * x + bend * y * y, (1 - bend) * x * y, y * y + bend * x * x], axis=-1).sum(axis=1)
    return (missed**2).sum(axis=1) / 2, (missed[..., None] * u).sum(axis=1), H


def _against(H: Floats, g: Floats) -> Floats:
    """(k, 2) the gradient over the sizes of the eigenvalues, along their directions."""
    middle, half = (H[:, 0] + H[:, 2]) / 2, (H[:, 0] - H[:, 2]) / 2
    radius = np.maximum(np.hypot(half, H[:, 1]), LEAST_DIVISOR)
    mirrored = np.stack([half * g[:, 0] + H[:, 1] * g[:, 1], H[:, 1] * g[:, 0] - half * g[:, 1]], axis=-1)
    mirrored /= radius[:, None]
    larger, lesser = (np.maximum(np.abs(middle + sign * radius), FLAT)[:, None] for sign in (1.0, -1.0))
    return (g + mirrored) / (2 * larger) + (g - mirrored) / (2 * lesser)
