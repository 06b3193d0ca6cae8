"""Cognates of a four-bar: the two other four-bars whose coupler point draws the same curve (Roberts, Chebyshev).

With crank z1, coupler z2 and rocker z3 as complex numbers, z1 + z2 - z3 = D - A, and the point P = B + r z2 of the
coupler given by the complex ratio r, P ends three pairs of links from A, D and E = A + r (D - A):

    P = A + z1 + r z2 = D + z3 - (1 - r) z2 = E + r z3 + (1 - r) z1.

Exchanging the links of each pair gives the cognates: A, A + r z2, E + r z3, E and D, D - (1 - r) z2, E + (1 - r) z1, E.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, single, whole
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages.tables import table
from mafsil.mobility.four_bar import FourBar
from mafsil.mobility.synthesis.answers import rank_candidates, rows_of
from mafsil.mobility.synthesis.candidate import Candidate, candidate
from mafsil.mobility.synthesis.dyads import Complexes, as_complex, as_points
from mafsil.mobility.synthesis.fitting import Positions
from mafsil.mobility.tolerances import EXACT, ILL_CONDITIONED, NO_LENGTH

SIDES = 3
"""Four-bars that draw one coupler curve."""


class CognateStatus(Status):
    """Whether all three four-bars draw the same curve."""

    SAME = ("synthesis.cognates_same", True)
    APART = ("synthesis.cognates_apart", False)


@dataclass(frozen=True, eq=False, repr=False)
class Cognates(Answer, entries="candidates", data="pivot difference samples candidates"):
    """Three four-bars with one coupler curve, each in the positions of the first, which is the given one.

    Attributes:
        candidates: the given four-bar, that on A and E, that on D and E; each driven by its better side link.
        pivot: (2,) E, the third fixed pivot [m].
        difference: largest distance between their curves, each closed by its own lengths [m].
        samples: configurations at which the curves were compared.
        size: longest link of the three [m].
    """

    candidates: tuple[Candidate, ...]
    pivot: Floats
    difference: float
    samples: int
    size: float

    @property
    def status(self) -> CognateStatus:
        """By the difference between the curves."""
        return CognateStatus.SAME if self.difference <= EXACT * self.size else CognateStatus.APART

    @property
    def x(self) -> float:
        """Of the third pivot [m]."""
        return float(self.pivot[0])

    @property
    def y(self) -> float:
        """Of the third pivot [m]."""
        return float(self.pivot[1])

    def __getitem__(self, index: int) -> Candidate:
        return self.candidates[index]

    def _table(self) -> list[str]:
        return table(*rows_of(self.candidates))


def cognates(
    linkage: Candidate | FourBar, along: float = 0.0, across: float = 0.0, *, mode: int = 0, samples: int = 360
) -> Cognates:
    """The three four-bars that draw one coupler curve, with their defects in the positions of the given one.

    Args:
        linkage: a candidate of a synthesis, or a four-bar on the origin with its ground along x.
        along, across: of a four-bar, the point of its coupler: from B towards C, to the left of it [m].
        mode: of a four-bar, the assembly mode of its positions.
        samples: crank angles on each side of the ground line at which the curves are compared, in both modes.

    Raises:
        InputError: the point is a pin of the coupler, whose curve is a circle; the four-bar never closes; a
            slider-crank.
    """
    count = whole("samples", samples, 1, 1_000_000)
    one = _in_positions(linkage, along, across, whole("mode", mode, 0, 1)) if isinstance(linkage, FourBar) else linkage
    bar = one.linkage
    if not isinstance(bar, FourBar):
        raise InputError("synthesis.cognate_kind")
    ratio = complex(one.along, one.across) / bar.coupler
    if min(abs(ratio), abs(1 - ratio)) < NO_LENGTH:
        raise InputError("synthesis.cognate_pin")
    A, D = (as_complex(end[None]) for end in (one.A, one.D))
    batches = _three(A, D, as_complex(one.B), as_complex(one.C), ratio)
    first = candidate(batches[0], batches[0].assess(), 0)
    others = [rank_candidates([batch], bar.ground, either_side=True).candidates for batch in batches[1:]]
    found = (first, *(each[0] for each in others if each))
    # Between dead points, at which both modes are one, and on both sides of the ground line.
    low, high = bar.input_range or (0.0, np.pi)
    half = low + (high - low) * (np.arange(count) + 0.5) / count
    angles = np.concatenate([half, -half])
    curves = [[as_complex(pins) for pins in one.moving_pivots(angles, k)] for k in (0, 1)]
    gaps = [_difference(_three(A, D, B, C, ratio)) for B, C in curves]
    size = max(float(each.linkage.lengths.max()) for each in found if isinstance(each.linkage, FourBar))
    difference = max(gaps) if len(found) == SIDES else float("inf")
    return Cognates(found, as_points(A + ratio * (D - A))[0], difference, 2 * len(angles), size)


def cognate_positions(positions: Positions) -> list[Positions]:
    """The four-bars (k,) of a batch and their two cognates each; of those whose point is a pin the cognates vanish."""
    ratio = (positions.frame[:, 0] + 1j * positions.frame[:, 1]) / np.abs(positions.C - positions.B).mean(axis=1)
    return _three(positions.A, positions.D, positions.B, positions.C, ratio, positions.misses)


def _in_positions(bar: FourBar, along: float, across: float, mode: int) -> Candidate:
    """A four-bar on the origin in five positions of its crank, spread over its range."""
    if bar.input_range is None:
        raise InputError("synthesis.cognate_open")
    low, high = bar.input_range
    theta = low + (high - low) * np.array([0.1, 0.3, 0.5, 0.7, 0.9])
    point = single("along, across", [along, across], (2,))
    B = as_complex(bar.crank * np.stack([np.cos(theta), np.sin(theta)], axis=1))
    C = as_complex(bar.positions(theta).C[:, mode])
    ends, frame = np.array([0.0, bar.ground]) + 0j, np.append(point, 0.0)[None]
    positions = Positions(ends[:1], B[None], C[None], ends[1:], frame)
    return candidate(positions, positions.assess(), 0)


def _three(
    A: Complexes, D: Complexes, B: Complexes, C: Complexes, ratio: Complexes | complex, misses: Floats | None = None
) -> list[Positions]:
    """The four-bars and their cognates as batches.

    Args:
        A, D: (k,) fixed pivots, or one.
        B, C: (k, N) moving pivots.
        ratio: (k,) of the point on the coupler.
        misses: (k,) of the points.
    """
    r = np.atleast_1d(np.asarray(ratio, dtype=np.complex128))
    B, C, q = np.atleast_2d(B), np.atleast_2d(C), r[:, None]
    z1, z2, z3 = B - A[:, None], C - B, C - D[:, None]
    E = A + r * (D - A)
    corners: list[tuple[Complexes, Complexes, Complexes, Complexes]] = [
        (A, B, C, D),
        (A, A[:, None] + q * z2, E[:, None] + q * z3, E),
    ]
    corners += [(D, D[:, None] - (1 - q) * z2, E[:, None] + (1 - q) * z1, E)]
    ratios = [r, 1 / np.where(r == 0, np.inf, r), 1 / np.where(r == 1, np.inf, 1 - r)]
    batches: list[Positions] = []
    for (a, b, c, d), share in zip(corners, ratios, strict=True):
        arm = as_points(share * np.abs(c - b).mean(axis=1))
        frame = np.concatenate([arm, np.zeros((len(arm), 1))], axis=1)
        batches.append(Positions(a, b, c, d, frame, misses=misses))
    return batches


def _difference(three: list[Positions]) -> float:
    """Largest distance of the curves: each cognate closed from its own crank by its own lengths [m]."""
    points = [_point(each, each.C[0]) for each in three]
    gaps = [0.0]
    for each in three[1:]:
        closed, regular = _close_pin(each)
        gaps.append(float(np.abs(_point(each, closed) - points[0])[regular].max(initial=0.0)))
    return max(gaps)


def _point(four_bar: Positions, C: Complexes) -> Complexes:
    """(N,) the coupler point of one four-bar whose pin C is there."""
    u = C - four_bar.B[0]
    return four_bar.B[0] + complex(*four_bar.frame[0, :2]) * u / np.maximum(np.abs(u), LEAST_DIVISOR)


def _close_pin(four_bar: Positions) -> tuple[Complexes, np.ndarray[tuple[int, ...], np.dtype[np.bool_]]]:
    """(N,) pin C by the mean lengths of one four-bar on its side of B-D, and where it stands away from dead points."""
    B, D = four_bar.B[0], four_bar.D[0]
    b, c = (float(np.abs(four_bar.C[0] - end).mean()) for end in (B, D))
    way = D - B
    s = np.maximum(np.abs(way), LEAST_DIVISOR)
    along = (s**2 + b**2 - c**2) / (2 * s)
    height = np.sqrt(np.maximum(b**2 - along**2, 0.0))
    side = np.where((np.conj(way) * (four_bar.C[0] - B)).imag >= 0, 1.0, -1.0)
    regular = np.asarray((height > ILL_CONDITIONED * b) & (s > ILL_CONDITIONED * b), dtype=np.bool_)
    return B + (along + 1j * side * height) * way / s, regular
