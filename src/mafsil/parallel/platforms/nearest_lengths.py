"""Lengths of legs that no pose has: the nearest ones that some pose has, which leg is how much too short or too long.

f(x) = |s(x) - s|^2 / 2 over all poses x, from many starts, by Newton's method. Its minimum is where the platform is
singular, so that first derivatives alone would never settle: the lengths bend,
s_i'' = |(1 - u u') (w x r + v)|^2 / s_i + u . (w x (w x r)) along a screw motion (w, v) about the platform's middle.

1. Steps along the eigenvectors of the Hessian, against the slope over the size of the eigenvalue.
2. A step that does not lead down is taken back, and the next ones are shorter.
3. Of all starts the least, and two steps more that make its slope smaller. That there is nothing nearer is not proven.

Reference: Nocedal and Wright, Numerical Optimization, 2006, sec. 3.4 and 4.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mafsil.arrays import Booleans, Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import pose, rotation

STARTS_IN_PLANE, STARTS = 24, 48
STEPS = 120
LONGEST = 0.5
"""First bound of a step [rad, sizes]."""
SETTLED = 1e-14
"""Steps [rad, sizes] after which nothing changes any more."""
FLAT = 1e-9
"""Eigenvalues below this share of the largest count as this much: directions in which nothing changes."""
POLISHING = 2
"""Newton steps on the slope at the end."""
SHORTEST = 1e-9
"""Of a leg whose direction turns, over the size."""
BLOCK = 64
"""Rows whose starts are followed together: 3 MB."""


@dataclass(frozen=True, eq=False)
class NearestLengths:
    """The nearest lengths that a platform can have, row by row, of those that searches found.

    Attributes:
        x: (*batch, 4, 4) or (*batch, 3) poses that have them; of a point its places.
        misfit: (*batch, m) what each leg lacks of the length that it has there [m]: positive where it is too short.
        starts: of the search for each row.
    """

    x: Floats
    misfit: Floats
    starts: int

    @property
    def distance(self) -> Floats:
        """(*batch,) distance of the lengths from feasible ones, root of the sum of squares over the legs [m]."""
        return np.linalg.norm(self.misfit, axis=-1)

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {"x": self.x, "misfit": self.misfit, "distance": self.distance, "starts": self.starts}

    def details(self) -> dict[str, object]:
        """Of one row, for its sentence: the distance, the leg that is most wrong, and what it would have to change."""
        leg = int(np.abs(self.misfit).argmax())
        return {
            "distance": float(self.distance), "leg": leg + 1, "change": float(self.misfit[leg]), "starts": self.starts
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class LegEnds:
    """Ends and lengths of the legs of platforms, of which the nearest lengths can be asked.

    Attributes:
        base: (*batch, m, 3 | 2) ends on the base [m].
        platform: (*batch, m, 3 | 2) ends on the platform, in its frame [m].
        lengths: (*batch, m) of the legs [m].
    """

    base: Floats
    platform: Floats
    lengths: Floats

    def __getitem__(self, row: object) -> LegEnds:
        index: tuple[object, ...] = (row, ...)
        return LegEnds(self.base[index], self.platform[index], self.lengths[index])  # type: ignore[index]

    def nearest_unless(self, met: Booleans, x: Floats) -> NearestLengths:
        """The nearest lengths of rows that are not met, and the poses themselves of those that are.

        Args:
            met: (*batch,) which rows have a pose.
            x: (*batch, 4, 4) or (*batch, 3) their poses, of no meaning elsewhere.
        """
        open_rows = ~met
        found = self[open_rows].nearest()
        place, misfit = x.copy(), np.zeros_like(self.lengths)
        place[open_rows], misfit[open_rows] = found.x, found.misfit
        return NearestLengths(place, misfit, found.starts)

    def nearest(self, seed: int = 0) -> NearestLengths:
        """The nearest lengths that the platform can have.

        Args:
            seed: of the starts.
        """
        planar, (*shape, m) = self.base.shape[-1] == 2, self.lengths.shape
        starts = STARTS_IN_PLANE if planar else STARTS
        a, b = (_in_space(ends.reshape(-1, m, ends.shape[-1])) for ends in (self.base, self.platform))
        s, rng = np.abs(self.lengths.reshape(-1, m)), np.random.default_rng(seed)
        blocks = [slice(k, k + BLOCK) for k in range(0, len(s), BLOCK)]
        found = [_nearest(a[rows], b[rows], s[rows], starts, planar, rng) for rows in blocks]
        T = np.concatenate([np.zeros((0, 4, 4)), *(each[0] for each in found)])
        misfit = np.concatenate([np.zeros((0, m)), *(each[1] for each in found)])
        x = np.stack([T[:, 0, 3], T[:, 1, 3], np.arctan2(T[:, 1, 0], T[:, 0, 0])], axis=-1) if planar else T
        return NearestLengths(x.reshape(*shape, *x.shape[1:]), misfit.reshape(*shape, m), starts)


def _in_space(ends: Floats) -> Floats:
    return ends if ends.shape[-1] == 3 else np.concatenate([ends, np.zeros((*ends.shape[:-1], 1))], axis=-1)


def _nearest(
    a: Floats, b: Floats, s: Floats, starts: int, planar: bool, rng: np.random.Generator
) -> tuple[Floats, Floats]:
    """Poses (k, 4, 4) and misfits (k, m) of rows, from random starts."""
    middle, centre = a.mean(axis=1, keepdims=True), b.mean(axis=1, keepdims=True)
    spread = np.linalg.norm(np.concatenate([a - middle, b - centre], axis=1), axis=-1).max(axis=1)
    size = np.maximum(np.maximum(spread, s.max(axis=1)), LEAST_DIVISOR)
    near, ends, wanted = (
        np.repeat(each / size.reshape(-1, *[1] * (each.ndim - 1)), starts, axis=0)
        for each in (a - middle, b - centre, s)
    )
    k = len(wanted)
    if planar:
        R = rotation.rot_z(rng.uniform(-np.pi, np.pi, k))
        p = rng.normal(size=(k, 3)) * np.array([1.0, 1.0, 0.0])
    else:
        R, p = rotation.random(rng, k), rng.normal(size=(k, 3))
    p *= (wanted.mean(axis=1) / np.maximum(np.linalg.norm(p, axis=1), LEAST_DIVISOR))[:, None]
    R, p = _descend(near, ends, wanted, R, p, planar)
    missed = _lengths(near, ends, R, p)[0] - wanted
    best = (missed**2).sum(axis=1).reshape(-1, starts).argmin(axis=1) + starts * np.arange(len(s))
    near, ends, wanted = near[best], ends[best], wanted[best]
    R, p = _polish(near, ends, wanted, R[best], p[best], planar)
    missed = _lengths(near, ends, R, p)[0] - wanted
    R, place = rotation.project(R), p * size[:, None] + middle[:, 0]
    place -= np.einsum("kij,kj->ki", R, centre[:, 0])
    return pose.from_rotation_translation(R, place), missed * size[:, None]


def _descend(a: Floats, b: Floats, s: Floats, R: Floats, p: Floats, planar: bool) -> tuple[Floats, Floats]:
    """Rotations and places (k, 3, 3), (k, 3) at minima of f, all rows together."""
    R, p = R.copy(), p.copy()
    live, bound = np.arange(len(s)), np.full(len(s), LONGEST)
    for _ in range(STEPS):
        here = (a[live], b[live], s[live], R[live], p[live])
        value, g, H = _slopes(*here)
        # 1.
        step = _step(g, H, planar)
        length = np.linalg.norm(step, axis=1)
        step *= np.minimum(1.0, bound[live] / np.maximum(length, SETTLED))[:, None]
        # 2.
        after_R, after_p = rotation.exp(step[:, :3]) @ R[live], p[live] + step[:, 3:]
        missed = _lengths(a[live], b[live], after_R, after_p)[0] - s[live]
        down = (missed**2).sum(axis=1) / 2 < value
        R[live[down]], p[live[down]] = after_R[down], after_p[down]
        taken = np.minimum(length, bound[live])
        bound[live] = np.where(down, np.minimum(2 * bound[live], LONGEST), taken / 4)
        live = live[taken > SETTLED]
        if not len(live):
            break
    return R, p


def _step(g: Floats, H: Floats, planar: bool) -> Floats:
    """(k, 6) along the eigenvectors of the Hessian, against the slope over the size of the eigenvalue."""
    columns = [2, 3, 4] if planar else [0, 1, 2, 3, 4, 5]
    eigenvalues, U = np.linalg.eigh(H[:, columns][:, :, columns])
    stiff = np.abs(eigenvalues)
    stiff = np.maximum(stiff, FLAT * np.maximum(stiff.max(axis=1, keepdims=True), FLAT))
    step = np.zeros((len(g), 6))
    step[:, columns] = -np.einsum("kij,kj->ki", U, np.einsum("kji,kj->ki", U, g[:, columns]) / stiff)
    return step


def _polish(a: Floats, b: Floats, s: Floats, R: Floats, p: Floats, planar: bool) -> tuple[Floats, Floats]:
    """Minima with a smaller slope: f itself is flat within the root of the rounding, its slope is not."""
    for _ in range(POLISHING):
        _, g, H = _slopes(a, b, s, R, p)
        step = _step(g, H, planar)
        after_R, after_p = rotation.exp(step[:, :3]) @ R, p + step[:, 3:]
        after = _slopes(a, b, s, after_R, after_p)[1]
        less = np.linalg.norm(after, axis=1) < np.linalg.norm(g, axis=1)
        R, p = np.where(less[:, None, None], after_R, R), np.where(less[:, None], after_p, p)
    return R, p


def _lengths(a: Floats, b: Floats, R: Floats, p: Floats) -> tuple[Floats, Floats, Floats]:
    """Lengths (k, m), directions (k, m, 3), and ends r = R b of the platform (k, m, 3)."""
    r = b @ np.swapaxes(R, -1, -2)
    d = r + p[:, None] - a
    s = np.linalg.norm(d, axis=-1)
    return s, d / np.maximum(s, SHORTEST)[..., None], r


def _slopes(a: Floats, b: Floats, s: Floats, R: Floats, p: Floats) -> tuple[Floats, Floats, Floats]:
    """f (k,), its gradient (k, 6) and Hessian (k, 6, 6) by screw motions (w, v) about the platform's middle."""
    length, u, r = _lengths(a, b, R, p)
    missed, one = length - s, np.eye(3)
    J = np.concatenate([np.cross(r, u), u], axis=-1)
    ends = np.concatenate([-rotation.hat(r), np.broadcast_to(one, (*r.shape[:-1], 3, 3))], axis=-1)
    across = ends - u[..., :, None] * J[..., None, :]
    weight = missed / np.maximum(length, SHORTEST)
    H = np.einsum("kmi,kmj->kij", J, J) + np.einsum("km,kmci,kmcj->kij", weight, across, across)
    both = np.einsum("km,kmi,kmj->kij", missed, r, u)
    along = np.einsum("km,kmi,kmi->k", missed, r, u)
    H[:, :3, :3] += (both + np.swapaxes(both, -1, -2)) / 2 - along[:, None, None] * one
    return (missed**2).sum(axis=1) / 2, np.einsum("km,kmi->ki", missed, J), H
