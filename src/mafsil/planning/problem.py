"""A planning problem: a box of configurations, which of them are free, and which segments between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, as_batch, frozen, positive, real_array, require_finite, require_function
from mafsil.errors import InputError

Free: TypeAlias = Callable[[JointVector], Any]
"""(k, n) configurations -> (k,) whether each is free."""
MOST_PLACES = 1_000_000
"""Of a segment that are looked at: longer ones need a coarser resolution."""
MOST_CELLS = 20_000_000
"""Of a grid of configurations."""
FreeSegment: TypeAlias = Callable[[JointVector, JointVector], bool]
"""(n,), (n,) -> whether the straight segment between them is free."""


@dataclass(eq=False)
class Counts:
    """What a search asked for.

    Attributes:
        configurations: that were looked at by themselves.
        segments: that were looked at.
    """

    configurations: int = 0
    segments: int = 0


@dataclass(frozen=True, eq=False)
class Problem:
    """Configurations between bounds, some of them free.

    Attributes:
        lower, upper: (n,) bounds [rad | m].
        free: (k, n) -> (k,) bools; any function.
        segment: (n,), (n,) -> bool, such as a proof without gaps; None to look at places `resolution` apart, between
            which nothing is proven.
        resolution: largest change of a coordinate between two places that are looked at [rad | m].
        counts: of questions, for the account.
    """

    lower: Floats
    upper: Floats
    free: Free
    segment: FreeSegment | None = None
    resolution: float = 0.02
    counts: Counts = field(default_factory=Counts)

    def __post_init__(self) -> None:
        low, high = (require_finite(name, real_array(name, getattr(self, name))) for name in ("lower", "upper"))
        if low.ndim != 1 or low.shape != high.shape or not low.size:
            raise InputError("input.shape", name="upper", expected=low.shape, got=high.shape, hint="")
        if (low > high).any():
            k = int((low > high).argmax())
            raise InputError("planning.bounds", index=k, lower=float(low[k]), upper=float(high[k]))
        require_function("free", self.free, "function of (k, n) configurations", 1)
        positive("resolution", self.resolution)
        object.__setattr__(self, "lower", frozen(low))
        object.__setattr__(self, "upper", frozen(high))

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return len(self.lower)

    def is_free(self, q: ArrayLike) -> NDArray[np.bool_]:
        """(k,) whether configurations (k, n) are within the bounds and free.

        Args:
            q: (k, n).
        """
        rows = np.atleast_2d(as_batch("q", q, (self.n,)))
        self.counts.configurations += len(rows)
        inside = ((rows >= self.lower - 1e-12) & (rows <= self.upper + 1e-12)).all(axis=1)
        return inside & answers("free", self.free(rows), (len(rows),))

    def is_free_segment(self, a: JointVector, b: JointVector) -> bool:
        """Whether a segment is free, its ends included.

        Args:
            a, b: (n,) its ends.
        """
        self.counts.segments += 1
        if self.segment is not None:
            return bool(self.segment(a, b))
        steps = max(int(np.ceil(np.abs(b - a).max() / self.resolution)), 1)
        if steps > MOST_PLACES:
            raise InputError("planning.too_fine", resolution=self.resolution, places=steps, most=MOST_PLACES)
        # Halves first: what blocks is found early.
        shares = _spread(steps)
        for begin in range(0, len(shares), 64):
            if not self.is_free(a + shares[begin : begin + 64, None] * (b - a)).all():
                return False
        return True

    def is_free_path(self, path: JointVector) -> bool:
        """Whether all segments of a path (k, n) are free."""
        return all(self.is_free_segment(a, b) for a, b in pairwise(path))

    def sample(self, rng: np.random.Generator, count: int) -> JointVector:
        """(count, n) configurations evenly between the bounds."""
        return rng.uniform(self.lower, self.upper, (count, self.n))


def answers(name: str, given: object, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """What a user's function says of many places, as bools.

    Args:
        name: of the function, for the error.
        given: what it gave.
        shape: that it should have.

    Raises:
        InputError: another shape, or numbers that are none, which would count as true.
    """
    array = np.asarray(given)
    number = array.dtype.kind in "biuf" and not np.isnan(array.astype(np.float64)).any()
    if array.shape != shape or not number:
        got = array.shape if number else "what is no truth value"
        raise InputError("planning.answers", name=name, expected=shape, got=got)
    return array.astype(np.bool_)


def require_few_cells(count: int) -> None:
    """Nothing, if a grid of so many cells fits the memory.

    Raises:
        InputError: it does not.
    """
    if count > MOST_CELLS:
        raise InputError("planning.too_many_cells", count=count, most=MOST_CELLS)


def _spread(steps: int) -> Floats:
    """Shares 0, 1/steps, ... 1 in the order of halves, quarters, ..."""
    shares = np.arange(steps + 1) / steps
    reverse = [int(f"{k:020b}"[::-1], 2) for k in range(steps + 1)]
    return shares[np.argsort(reverse, kind="stable")]


def length_of(path: JointVector) -> float:
    """Length of a path (k, n) [rad | m]."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
