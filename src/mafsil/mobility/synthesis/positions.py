"""Linkages of a synthesis as batches of positions: pivots in every pose, and where the coupler's frame sits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from mafsil.arrays import Booleans, Floats, Integers
from mafsil.mobility.synthesis.assessment import Assessment, assess_four_bars, assess_slider_cranks
from mafsil.mobility.synthesis.dyads import Dyad
from mafsil.mobility.synthesis.poses import Complexes, as_complex
from mafsil.mobility.synthesis.tolerances import NO_LENGTH


@dataclass(frozen=True, eq=False)
class Positions:
    """k linkages of one kind in N positions.

    Attributes:
        A: (k,) fixed pivots of the cranks.
        B, C: (k, N) moving pivots, or crank pins and blocks.
        D: (k,) fixed pivots of the rockers; of slider-cranks the directions of the lines.
        frame: (k, 3) the coupler's frame from B: along B -> C, across it to the left [m], and its angle from it [rad].
        slider: whether they are slider-cranks.
        misses: (k,) how far the farthest position is from what was asked [m | rad]; None if all are met exactly.
    """

    A: Complexes
    B: Complexes
    C: Complexes
    D: Complexes
    frame: Floats
    slider: bool = False
    misses: Floats | None = None

    def __len__(self) -> int:
        return len(self.A)

    def chosen(self, which: Booleans | Integers) -> Positions:
        """Some of them."""
        return Positions(
            self.A[which], self.B[which], self.C[which], self.D[which], self.frame[which], self.slider,
            None if self.misses is None else self.misses[which],
        )  # fmt: skip

    def assess(self) -> Assessment:
        """Their defects."""
        assess = assess_slider_cranks if self.slider else assess_four_bars
        return assess(self.A, self.B, self.C, self.D)

    def driven_from_the_other_side(self) -> Positions:
        """The same four-bars with the rocker as crank."""
        length = np.abs(self.C - self.B).mean(axis=1)
        frame = np.stack([length - self.frame[:, 0], -self.frame[:, 1], self.frame[:, 2] - np.pi], axis=1)
        return Positions(self.D, self.C, self.B, self.A, frame)

    def built(self, size: float) -> Positions:
        """Those all of whose links have a length, for a task of a size [m]."""
        if not len(self):
            return self
        least = NO_LENGTH * size
        links = [np.abs(self.B - self.A[:, None]).min(axis=1), np.abs(self.C - self.B).min(axis=1)]
        if not self.slider:
            links += [np.abs(self.D - self.A), np.abs(self.C - self.D[:, None]).min(axis=1)]
        return self.chosen(np.asarray((np.stack(links) > least).all(axis=0), dtype=np.bool_))


def four_bars_of(first: Sequence[Dyad], second: Sequence[Dyad] | None = None) -> Positions:
    """Four-bars of cranks.

    Args:
        first: cranks.
        second: what each of them is paired with; if None, all pairs of the first.
    """
    if second is None:
        pairs = list(combinations(range(len(first)), 2))
        second = first
    else:
        pairs = list(product(range(len(first)), range(len(second))))
    return _pair(first, second, pairs, slider=False)


def slider_cranks_of(cranks: Sequence[Dyad], blocks: Sequence[Dyad]) -> Positions:
    """Slider-cranks of each crank with each block."""
    return _pair(cranks, blocks, list(product(range(len(cranks)), range(len(blocks)))), slider=True)


def _pair(first: Sequence[Dyad], second: Sequence[Dyad], pairs: list[tuple[int, int]], *, slider: bool) -> Positions:
    i, j = np.array(pairs, dtype=int).reshape(-1, 2).T
    N = max((len(one.places) for one in (*first, *second)), default=0)
    left, right = (np.array([one.places for one in side]).reshape(len(side), N, 2) for side in (first, second))
    m, n = (as_complex(np.array([one.pivot for one in side]).reshape(-1, 2)) for side in (first, second))
    v, w = (as_complex(np.array([one.point for one in side]).reshape(-1, 2)) for side in (first, second))
    rod = w[j] - v[i]
    with np.errstate(divide="ignore", invalid="ignore"):
        u = rod / np.abs(rod)
    origin = -v[i] * np.conj(u)
    frame = np.stack([origin.real, origin.imag, -np.angle(u)], axis=1)
    D = 1j * n[j] if slider else n[j]
    return Positions(m[i], as_complex(left[i]), as_complex(right[j]), D, frame, slider)
