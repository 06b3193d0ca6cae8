"""Paths one after the other, their corners rounded within a stated distance and angle."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, Vector6, cross
from mafsil.errors import InputError
from mafsil.geometry import rotation
from mafsil.trajectory.paths.pose_path import TipPath, jumps, merge_breaks
from mafsil.trajectory.paths.rotation_curves import RotationMotion, inverse, product, rotate_rows, run
from mafsil.trajectory.tolerances import GIVEN, ROUNDING

TURN_WEIGHT = 0.25
"""Share of the parameter that turning gets [m/rad]: a turn by 1 rad takes as much of it as 0.25 m."""

SMALLEST_WEIGHT = 1e-9
LOOK = 65
"""Places at which the deviation of a blend is looked at, before the largest is refined."""

ROUNDS = 60


@dataclass(frozen=True, slots=True)
class CornerBlend:
    """A rounded corner.

    Attributes:
        place: s of the corner.
        half: half of the stretch of s that is blended.
        deviation: largest distance to the unblended path, at the same s [m].
        turn_deviation: largest angle to it [rad].
    """

    place: float
    half: float
    deviation: float
    turn_deviation: float


@dataclass(frozen=True, eq=False)
class JoinedPath:
    """Legs one after the other, each over a share of s by its length and its angle.

    In a blend of width 2 h around the corner s_k, with x = (s - s_k + h) / 2 h, the leg that ends runs out while the
    next runs in:  p = p_A(s_A) + p_B(s_B) - p_k,  R = R_A(s_A) R_k' R_B(s_B),
    s_A = s_k - h + 2 h (x - x^3 + x^4 / 2),  s_B = s_k + 2 h (x^3 - x^4 / 2):  pose, twist and its derivative are
    continuous; between straight legs it is the quintic blend that misses the corner by 3 |dv| 2h / 32.

    Attributes:
        legs: each begins where the one before ends.
        shares: (k + 1,) places of the ends of the legs.
        blends: rounded corners.
    """

    legs: tuple[TipPath, ...]
    shares: Floats
    blends: tuple[CornerBlend, ...] = ()

    @property
    def length(self) -> float:
        """Length of the way of the origin; in blends by Gauss and Legendre [m]."""
        return self._length

    @cached_property
    def _length(self) -> float:
        return self._path_measure(slice(3, 6))

    @property
    def angle(self) -> float:
        """By how much it turns [rad]."""
        return self._angle

    @cached_property
    def _angle(self) -> float:
        return self._path_measure(slice(0, 3))

    @property
    def breaks(self) -> Floats:
        """Ends of legs that are not blended away, breaks within legs, and ends of blends."""
        return self._breaks

    @cached_property
    def _breaks(self) -> Floats:
        inside = [a + (b - a) * leg.breaks for leg, (a, b) in zip(self.legs, pairwise(self.shares), strict=True)]
        ends = [np.array([one.place - one.half, one.place + one.half]) for one in self.blends]
        places = merge_breaks(*inside, *ends)
        if not self.blends:
            return places
        at, half = self._blended
        hidden = np.zeros(len(places) + 1, dtype=np.int64)
        np.add.at(hidden, np.searchsorted(places, at - half * (1 - GIVEN), side="right"), 1)
        np.add.at(hidden, np.searchsorted(places, at + half * (1 - GIVEN), side="left"), -1)
        return places[np.cumsum(hidden[:-1]) <= 0]

    @property
    def corners(self) -> Floats:
        """Corners that are not blended."""
        return self._corners

    @cached_property
    def _corners(self) -> Floats:
        return jumps(self)

    @property
    def deviation(self) -> float:
        """Largest distance of a blend from the unblended path [m]."""
        return max((one.deviation for one in self.blends), default=0.0)

    @property
    def turn_deviation(self) -> float:
        """Largest angle of a blend from it [rad]."""
        return max((one.turn_deviation for one in self.blends), default=0.0)

    def with_sharp_corners(self) -> JoinedPath:
        """The same legs with sharp corners."""
        return replace(self, blends=())

    def poses(self, s: ArrayLike) -> PoseMatrix:
        """(*s, 4, 4) in {s}."""
        p, curve = self._motion(np.asarray(s, dtype=np.float64))
        T = np.zeros((*p.shape[1:-1], 4, 4))
        T[..., :3, :3], T[..., :3, 3], T[..., 3, 3] = curve.R, p[0], 1.0
        return T

    def twists(self, s: ArrayLike) -> tuple[Vector6, Vector6]:
        """Body twist by s, and its derivative: (*s, 6) each."""
        p, (R, w, a) = self._motion(np.asarray(s, dtype=np.float64))
        back = np.swapaxes(R, -1, -2)
        v = rotate_rows(back, p[1])
        return np.concatenate([w, v], axis=-1), np.concatenate([a, rotate_rows(back, p[2]) - cross(w, v)], axis=-1)

    def _motion(self, s: Floats) -> tuple[Floats, RotationMotion]:
        """(3, *s, 3) the origin with two derivatives, and the turning."""
        flat = np.clip(s.ravel(), 0.0, 1.0)
        p, R = np.empty((3, len(flat), 3)), np.empty((len(flat), 3, 3))
        w, a = np.empty((len(flat), 3)), np.empty((len(flat), 3))
        leg = np.clip(np.searchsorted(self.shares, flat, side="right") - 1, 0, len(self.legs) - 1)
        part = leg.copy()
        if self.blends:
            # Blends lie in order and do not overlap: only the nearest one can hold a place.
            places, halves = self._blended
            before = np.clip(np.searchsorted(places, flat) - 1, 0, len(places) - 1)
            after = np.minimum(before + 1, len(places) - 1)
            nearest = np.where(np.abs(flat - places[after]) < np.abs(flat - places[before]), after, before)
            within = np.abs(flat - places[nearest]) < halves[nearest]
            part[within] = len(self.legs) + nearest[within]
        parts: list[int] = np.unique(part).tolist()
        for k in parts:
            mask = part == k
            if k < len(self.legs):
                p[:, mask], (R[mask], w[mask], a[mask]) = self._leg(k, flat[mask])
            else:
                p[:, mask], (R[mask], w[mask], a[mask]) = self._blend(self.blends[k - len(self.legs)], flat[mask])
        shape = s.shape
        return p.reshape(3, *shape, 3), RotationMotion(
            R.reshape(*shape, 3, 3), w.reshape(*shape, 3), a.reshape(*shape, 3)
        )

    @cached_property
    def _blended(self) -> tuple[Floats, Floats]:
        """(k,) places of all blends, and halves of their widths."""
        return np.array([one.place for one in self.blends]), np.array([one.half for one in self.blends])

    def _leg(self, k: int, s: Floats) -> tuple[Floats, RotationMotion]:
        """One leg at places of the whole."""
        begin, width = self.shares[k], self.shares[k + 1] - self.shares[k]
        local = np.clip((s - begin) / width, 0.0, 1.0)
        T = self.legs[k].poses(local)
        V, slope = self.legs[k].twists(local)
        V, slope, R = V / width, slope / width**2, T[..., :3, :3]
        w, v = V[..., :3], V[..., 3:]
        p = np.stack([T[..., :3, 3], rotate_rows(R, v), rotate_rows(R, cross(w, v) + slope[..., 3:])])
        return p, RotationMotion(R, w, slope[..., :3])

    def _blend(self, one: CornerBlend, s: Floats) -> tuple[Floats, RotationMotion]:
        """The two legs of a corner at once."""
        k = int(np.searchsorted(self.shares, one.place))
        h = one.half
        x = (s - one.place + h) / (2 * h)
        inward = 2 * h * (x**3 - x**4 / 2)
        rate, growth = 3 * x**2 - 2 * x**3, (6 * x - 6 * x**2) / (2 * h)
        p_A, out = self._leg(k - 1, s - inward)
        p_B, into = self._leg(k, one.place + inward)
        p_k, corner = self._leg(k, np.array([one.place]))
        p = np.stack(
            [
                p_A[0] + p_B[0] - p_k[0],
                _scale(1 - rate) * p_A[1] + _scale(rate) * p_B[1],
                _scale(1 - rate) ** 2 * p_A[2] + _scale(rate) ** 2 * p_B[2] + _scale(growth) * (p_B[1] - p_A[1]),
            ]
        )
        back = inverse(RotationMotion(corner.R[0], np.zeros(3), np.zeros(3))).R
        ahead = run(into, rate, growth)
        return p, product(run(out, 1 - rate, -growth), RotationMotion(back @ ahead.R, ahead.w, ahead.a))

    def deviations(self, s: Floats) -> tuple[Floats, Floats]:
        """(k,) distance [m] and angle [rad] to the unblended path at the same places."""
        here, sharp = self.poses(s), self.with_sharp_corners().poses(s)
        distance = np.linalg.norm(here[..., :3, 3] - sharp[..., :3, 3], axis=-1)
        return distance, np.linalg.norm(
            rotation.log(np.swapaxes(sharp[..., :3, :3], -1, -2) @ here[..., :3, :3]), axis=-1
        )

    def _path_measure(self, rows: slice) -> float:
        """Integral of the size of a part of the twist."""
        nodes, weights = np.polynomial.legendre.leggauss(16)
        breaks: list[float] = self.breaks.tolist()
        panels = [np.linspace(a, b, 8, endpoint=False) for a, b in pairwise(breaks)]
        edges: Floats = np.concatenate([*panels, [1.0]])
        half = np.diff(edges) / 2
        V = self.twists(edges[:-1, None] + half[:, None] * (nodes + 1))[0][..., rows]
        return float(((np.linalg.norm(V, axis=-1) * weights).sum(axis=1) * half).sum())


def join_legs(legs: tuple[TipPath, ...], blend: tuple[float, ...] | None, blend_angle: float | None) -> JoinedPath:
    """Legs one after the other; see `mafsil.trajectory.joined_path`.

    Args:
        legs: each begins where the one before ends.
        blend: largest deviation at the end of each leg but the last [m]; None leaves the corners sharp.
        blend_angle: largest deviation [rad]; unbounded if None.

    Raises:
        InputError: no legs, or one that does not begin where the one before ends.
    """
    if not legs:
        raise InputError("trajectory.no_legs")
    for k, (one, next_one) in enumerate(pairwise(legs), start=1):
        gap = float(np.abs(one.poses(1.0) - next_one.poses(0.0)).max())
        if not gap <= GIVEN:
            raise InputError("trajectory.leg_gap", index=k, gap=gap, limit=GIVEN)
    weights = np.array([max(np.hypot(leg.length, TURN_WEIGHT * leg.angle), SMALLEST_WEIGHT) for leg in legs])
    shares = np.concatenate([[0.0], np.cumsum(weights)]) / weights.sum()
    shares[-1] = 1.0
    sharp = JoinedPath(legs, shares)
    if blend is None or not len(sharp.corners):
        return sharp
    wanted = {k for k in range(1, len(legs)) if np.abs(sharp.corners - shares[k]).min() < ROUNDING}
    return replace(sharp, blends=tuple(_fit(sharp, k, wanted, blend[k - 1], blend_angle) for k in sorted(wanted)))


def _fit(sharp: JoinedPath, k: int, wanted: set[int], blend: float, blend_angle: float | None) -> CornerBlend:
    """The widest blend at corner k that keeps both bounds and leaves its neighbours their half of the legs."""
    free = [sharp.shares[i + 1] - sharp.shares[i] for i in (k - 1, k)]
    shared = [free[0] / 2 if k - 1 in wanted else free[0], free[1] / 2 if k + 1 in wanted else free[1]]
    place, half = float(sharp.shares[k]), min(shared)
    angle = np.inf if blend_angle is None else blend_angle
    for _ in range(ROUNDS):
        found = _deviations(sharp, place, half)
        excess = max(found[0] / blend, found[1] / angle)
        if excess <= 1.0:
            return CornerBlend(place, half, *found)
        half *= min(0.98, 0.9999999 / excess)
    raise InputError("trajectory.blend_small", index=k, value=blend)


def _deviations(sharp: JoinedPath, place: float, half: float) -> tuple[float, float]:
    """Largest distance and angle of a blend from its corner, refined around the largest samples."""
    path = replace(sharp, blends=(CornerBlend(place, half, 0.0, 0.0),))
    low, high = place - half, place + half
    s = np.linspace(low, high, LOOK)
    found = [path.deviations(s)]
    for which in (0, 1):
        step, centre = (high - low) / (LOOK - 1), float(s[found[0][which].argmax()])
        for _ in range(3):
            near = np.clip(np.linspace(centre - step, centre + step, 33), low, high)
            found.append(path.deviations(near))
            centre, step = float(near[found[-1][which].argmax()]), step / 16
    return max(float(d.max()) for d, _ in found), max(float(a.max()) for _, a in found)


def _scale(x: Floats) -> Floats:
    return x[..., None]
