"""Defects of many planar linkages at once: circuits, branches, order, dead points, transmission.

A linkage is assessed as driven by its crank (at A) through its positions in their order. All arrays are batches of
linkages (k,) with positions (k, N), points as complex numbers.

- Circuit: a Grashof four-bar moves in two separate pieces of its configurations. The shortest link goes round against
  its neighbours, so the angles at the two other hinges never pass 0 or pi: the sign of one of them names the piece.
- Branch: between positions of one circuit on different sides of the line B-C-D the crank meets a dead point.
- Order: the crank reaches the positions in another sequence than theirs, whichever way it turns.
- Transmission angle: between coupler and rocker, as an angle in [0, pi/2]. It depends on the distance B-D alone, so
  its extremes over a range of the crank lie at the ends of the range and where the crank lies along the ground.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Booleans, Floats, Integers, positive, real_array
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.mobility.spaces.planar_positions import wrap_angle
from mafsil.mobility.synthesis.dyads import Complexes
from mafsil.mobility.tolerances import DEAD, TYPED


@dataclass(frozen=True, eq=False)
class LinkageLimits:
    """What a linkage must keep to beside its task; None leaves it free.

    Attributes:
        pivots: (2, d) opposite corners of the box in which fixed pivots lie [m]; of spherical linkages, d = 3, the box
            of unit vectors along fixed axes, in either sense.
        transmission: least transmission angle on the way through the positions, below a right angle [rad].
        longest: of all links [m]; of spherical linkages the longest arc [rad].
    """

    pivots: Floats | None = None
    transmission: float | None = None
    longest: float | None = None

    def __post_init__(self) -> None:
        if self.pivots is not None:
            box = real_array("pivots", self.pivots)
            if box.ndim != 2 or len(box) != 2 or box.shape[1] not in (2, 3) or not np.isfinite(box).all():
                raise InputError("synthesis.limit_box", got=box.shape)
            object.__setattr__(self, "pivots", np.sort(box, axis=0))
        for name in ("transmission", "longest"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, positive(name, getattr(self, name)))
        if self.transmission is not None and self.transmission >= np.pi / 2:
            raise InputError("synthesis.limit_transmission", value=self.transmission)

    def contains(self, points: Floats) -> Booleans:
        """(*batch,) whether points (*batch, d) lie in the box.

        Raises:
            InputError: the box has another dimension.
        """
        if self.pivots is None:
            return np.ones(points.shape[:-1], dtype=np.bool_)
        if self.pivots.shape[1] != points.shape[-1]:
            raise InputError("synthesis.limit_box", got=self.pivots.shape)
        return np.asarray(((points >= self.pivots[0]) & (points <= self.pivots[1])).all(axis=-1), dtype=np.bool_)

    def violations(self, pivots: Sequence[Floats], worst: Floats, longest: Floats) -> Booleans:
        """(3, k) which linkages break the limit of pivots, of transmission, of links.

        Args:
            pivots: (k, d) fixed pivots, one array for each.
            worst: (k,) least transmission angles [rad].
            longest: (k,) links.
        """
        inside = np.stack([self.contains(each) for each in pivots]).all(axis=0)
        weak = worst < (self.transmission or 0.0)
        long = longest > (np.inf if self.longest is None else self.longest)
        return np.stack([~inside, weak, long])


NO_LIMITS = LinkageLimits()


@dataclass(frozen=True, eq=False)
class Assessment:
    """What was found of k linkages in N positions.

    Attributes:
        lengths: (k, 4) crank, coupler, rocker, ground; of a slider-crank crank, rod, 0, offset [m].
        theta: (k, N) angles of the crank from the ground line in (-pi, pi] [rad].
        circuits: (k, N) sign that names the circuit; 0 if there is one only.
        branches: (k, N) +1 or -1: the assembly mode; 0 in a dead point.
        full: (k,) whether the crank goes round.
        ordered: (k,) whether it reaches the positions in their order.
        transmission: (k, N) transmission angle at the positions [rad].
        worst: (k,) least transmission angle on the way; 0 if a dead point lies on it [rad].
        residual: (k,) largest change of a length between positions [m].
    """

    lengths: Floats
    theta: Floats
    circuits: Integers
    branches: Integers
    full: Booleans
    ordered: Booleans
    transmission: Floats
    worst: Floats
    residual: Floats

    @property
    def circuit_defect(self) -> Booleans:
        """(k,) whether positions lie on different circuits."""
        return np.asarray((self.circuits != self.circuits[:, :1]).any(axis=1), dtype=np.bool_)

    @property
    def branch_defect(self) -> Booleans:
        """(k,) whether a dead point lies between positions of one circuit, or at one."""
        changed = (self.branches != self.branches[:, :1]).any(axis=1) | (self.branches == 0).any(axis=1)
        return np.asarray(changed & ~self.circuit_defect, dtype=np.bool_)

    @property
    def order_defect(self) -> Booleans:
        """(k,) whether the crank reaches the positions in another order."""
        return np.asarray(~self.ordered, dtype=np.bool_)

    @property
    def severity(self) -> Integers:
        """(k,) 0 without defects; a circuit defect weighs more than a branch defect, that more than one of order."""
        return 4 * self.circuit_defect.astype(int) + 2 * self.branch_defect + self.order_defect


def assess_four_bars(A: Complexes, B: Complexes, C: Complexes, D: Complexes) -> Assessment:
    """Four-bars by their pivots.

    Args:
        A, D: (k,) fixed pivots of crank and rocker.
        B, C: (k, N) moving pivots in the positions.
    """
    ground = D - A
    links = np.abs(np.stack([B - A[:, None], C - B, D[:, None] - C], axis=1))
    lengths = np.concatenate([links.mean(axis=2), np.abs(ground)[:, None]], axis=1)
    residual = np.abs(links - links.mean(axis=2, keepdims=True)).max(axis=(1, 2))
    theta = np.angle((B - A[:, None]) / ground[:, None])
    turn = np.conj(C - B) * (D[:, None] - C)
    turn = turn / np.maximum(np.abs(turn), LEAST_DIVISOR)
    branches = np.where(np.abs(turn.imag) > DEAD, np.sign(turn.imag), 0).astype(int)
    L1, L2, L3, L4 = lengths.T
    small = TYPED * lengths.max(axis=1)
    grashof = 2 * (lengths.min(axis=1) + lengths.max(axis=1)) - lengths.sum(axis=1) < -small
    shortest = lengths.argmin(axis=1)
    by_crank = ((shortest == 1) | (shortest == 2))[:, None]
    circuits = np.where(grashof[:, None], np.where(by_crank, np.sign(np.sin(theta)), branches), 0).astype(int)
    passes_0 = np.abs(L4 - L1) >= np.abs(L2 - L3) - small
    passes_pi = L1 + L4 <= L2 + L3 + small
    full = passes_0 & passes_pi
    middle = np.where(passes_0, 0.0, np.where(passes_pi, np.pi, np.pi / 2))[:, None] * np.ones(theta.shape)
    middle = np.where((passes_0 | passes_pi)[:, None], middle, middle * np.sign(theta))
    ordered, low, high = _passage(theta, middle, full)
    extremes = [low, high, *(np.where(_passes(low, high, angle), angle, low) for angle in (0.0, np.pi))]
    reach = L1[:, None] ** 2 + L4[:, None] ** 2 - 2 * (L1 * L4)[:, None] * np.cos(np.stack(extremes, axis=1))
    cosine = np.abs((L2**2 + L3**2)[:, None] - reach) / np.maximum(2 * (L2 * L3)[:, None], LEAST_DIVISOR)
    transmission = np.arctan2(np.abs(turn.imag), np.abs(turn.real))
    return _assessment(lengths, theta, circuits, branches, full, ordered, transmission, cosine, residual)


def assess_slider_cranks(A: Complexes, B: Complexes, C: Complexes, along: Complexes) -> Assessment:
    """Slider-cranks by pivots, blocks and the directions of their lines.

    Args:
        A: (k,) fixed pivots of the cranks.
        B, C: (k, N) crank pins and blocks.
        along: (k,) directions of the lines, of length one.
    """
    crank_arm, rod_arm = (B - A[:, None]) * np.conj(along)[:, None], (C - B) * np.conj(along)[:, None]
    offsets = ((C - A[:, None]) * np.conj(along)[:, None]).imag
    links = np.stack([np.abs(crank_arm), np.abs(rod_arm), offsets], axis=1)
    r, rod, e = links.mean(axis=2).T
    residual = np.abs(links - links.mean(axis=2, keepdims=True)).max(axis=(1, 2))
    theta, ahead = np.angle(crank_arm), rod_arm.real / np.maximum(np.abs(rod_arm), LEAST_DIVISOR)
    branches = np.where(np.abs(ahead) > DEAD, np.sign(ahead), 0).astype(int)
    small = TYPED * (r + rod + np.abs(e))
    passes_up, passes_down = np.abs(r - e) <= rod + small, np.abs(r + e) <= rod + small
    full, apart = passes_up & passes_down, ~passes_up & ~passes_down
    side = np.where(np.cos(theta) > 0, 1, -1)
    circuits = np.where(full[:, None], branches, np.where(apart[:, None], side, 0)).astype(int)
    middle = np.where(passes_up, np.pi / 2, -np.pi / 2)[:, None] * np.ones(theta.shape)
    middle = np.where(apart[:, None], np.where(side > 0, 0.0, np.pi), middle)
    ordered, low, high = _passage(theta, middle, full)
    tops = (np.pi / 2, -np.pi / 2)
    extremes = [low, high, *(np.where(_passes(low, high, angle), angle, low) for angle in tops)]
    cosine = (
        np.abs(r[:, None] * np.sin(np.stack(extremes, axis=1)) - e[:, None]) / np.maximum(rod, LEAST_DIVISOR)[:, None]
    )
    lengths = np.stack([r, rod, np.zeros_like(r), e], axis=1)
    transmission = np.arctan2(np.abs(ahead), np.abs(rod_arm.imag) / np.maximum(np.abs(rod_arm), LEAST_DIVISOR))
    return _assessment(lengths, theta, circuits, branches, full, ordered, transmission, cosine, residual)


def _assessment(
    lengths: Floats,
    theta: Floats,
    circuits: Integers,
    branches: Integers,
    full: Booleans,
    ordered: Booleans,
    transmission: Floats,
    cosine: Floats,
    residual: Floats,
) -> Assessment:
    """The record, with the least transmission angle: 0 beyond a dead point, at the positions where no way is known.

    Args:
        lengths, theta, circuits, branches, full, ordered, transmission, residual: as in the record.
        cosine: (k, m) cosines of the transmission angle where it can be least on the way.
    """
    one_mode = (branches == branches[:, :1]).all(axis=1) & (branches != 0).all(axis=1)
    one_circuit = (circuits == circuits[:, :1]).all(axis=1)
    at_positions = transmission.min(axis=1)
    on_the_way = np.minimum(at_positions, np.arccos(np.clip(cosine.max(axis=1), 0.0, 1.0)))
    worst = np.where(one_circuit, np.where(one_mode, on_the_way, 0.0), at_positions)
    return Assessment(lengths, theta, circuits, branches, full, ordered, transmission, worst, residual)


def _passage(theta: Floats, middle: Floats, full: Booleans) -> tuple[Booleans, Floats, Floats]:
    """Whether positions follow each other, and the range (k,), (k,) of the crank between first and last [rad].

    Args:
        theta: (k, N) angles of the crank.
        middle: (k, N) middle of the range of a crank that swings: angles are counted from it.
        full: (k,) whether the crank goes round: then the way is the shorter one of both senses that keeps the order.
    """
    counted = middle + wrap_angle(theta - middle)
    steps = np.diff(counted, axis=1)
    rising, falling = (steps > 0).all(axis=1), (steps < 0).all(axis=1)
    forward, back = (np.mod(sign * np.diff(theta, axis=1), 2 * np.pi).sum(axis=1) for sign in (1.0, -1.0))
    ordered = np.where(full, np.minimum(forward, back) < 2 * np.pi, rising | falling)
    start = theta[:, 0]
    low = np.where(forward <= back, start, start - back)
    high = np.where(forward <= back, start + forward, start)
    around = full & ~ordered
    low, high = np.where(around, -np.pi, low), np.where(around, np.pi, high)
    low, high = np.where(full, low, counted.min(axis=1)), np.where(full, high, counted.max(axis=1))
    return np.asarray(ordered, dtype=np.bool_), low, high


def _passes(low: Floats, high: Floats, angle: float) -> Booleans:
    """(k,) whether a range of angles contains an angle, modulo a turn."""
    return np.asarray(np.ceil((low - angle) / (2 * np.pi)) * 2 * np.pi + angle <= high, dtype=np.bool_)
