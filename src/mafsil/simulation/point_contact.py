"""Forces of rigid surfaces with Coulomb friction on one point: which press, stick and slide, solved exactly.

The point accelerates with drift + G F, G = J M^-1 J'. Surface i exerts f_i (n_i + friction), f_i >= 0, |friction| at
most mu_i, and holds what it presses on: 0 <= n_i . a + c_i, zero where f_i > 0.

1. Where the point slides, friction is mu_i against the velocity, and the f_i of every set of surfaces that may press
   follow from linear equations; the set whose f_i push and whose others part is the answer.
2. At rest it sticks if the force that stops it lies in the sum of the friction cones.
3. If it does not, it starts to slide: on one surface in a direction along which it is then accelerated, on two along
   their common edge.
4. Rigid bodies with much friction may have no such force, or several (Painleve): that is said, and nothing is computed.

In directions in which the arm cannot move the point no friction is assumed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

from mafsil.arrays import Floats, Vector3
from mafsil.errors import InputError
from mafsil.simulation.tolerances import IMMOBILE, ON_THE_CONE, PARALLEL, QUIET, SINGULAR_CONTACT
from mafsil.solvers.solution import bracketed_root

DIRECTIONS = 72
"""Directions of sliding that are looked at before the right one is located between two of them."""

ALL = np.eye(3)
"""Directions of a point that can move everywhere."""


class NoContactForce(InputError):
    """Rigid surfaces with friction have no force that fits, or several."""


class Touch(NamedTuple):
    """What surfaces do to a point.

    Attributes:
        active: of the surfaces that press, in increasing order.
        stuck: whether friction holds the point.
        slip: (r,) direction in which it begins to slide, zero if it slides already or without friction.
        force: (r,) on the point, in the directions in which it can move [N].
        pressed: accelerations into the active surfaces that their forces prevent [m/s^2]; none if it is stuck.
        slack: how far within the friction cones the force of a point that is stuck is [N]; infinite of others.
    """

    active: tuple[int, ...]
    stuck: bool
    slip: Floats
    force: Floats
    pressed: Floats
    slack: float = np.inf


@dataclass(frozen=True, eq=False, slots=True)
class PointContact:
    """Surfaces that one point touches, in the r directions in which it can move.

    Attributes:
        G: (r, r) acceleration for a force [1/kg].
        U: (3, r) unit vectors of the directions.
        normals: (k, r) units.
        reach: (k,) lengths of the normals' parts along the directions.
        friction: (k,) coefficients, over `reach`.
        whole: (k, 3) the normals in space.
    """

    G: Floats
    U: Floats
    normals: Floats
    reach: Floats
    friction: Floats
    whole: Floats

    @classmethod
    def of(cls, response: Floats, normals: Floats, friction: Floats) -> PointContact:
        """In the directions that G reaches.

        Args:
            response: (3, 3) G [1/kg].
            normals: (k, 3).
            friction: (k,) mu.
        """
        if _determinant(response) > IMMOBILE * float(response[0, 0] + response[1, 1] + response[2, 2]) ** 3:
            return cls(response, ALL, normals, np.ones(len(normals)), friction, normals)
        sizes, axes = np.linalg.eigh(response)
        U = axes[:, sizes > IMMOBILE * sizes[-1]]
        inside = normals @ U
        reach = np.maximum(np.linalg.norm(inside, axis=1), IMMOBILE)
        return cls(U.T @ response @ U, U, inside / reach[:, None], reach, friction / reach, normals)

    def load(self, drift: Vector3, bends: Floats) -> tuple[Floats, Floats]:
        """Drift (r,) in the directions, and c (k,) with what of it lies outside them, over `reach` [m/s^2].

        Args:
            drift: (3,) acceleration without the surfaces.
            bends: (k,) of the distances, by the curvature of the surfaces.
        """
        if self.U is ALL:
            return drift, bends
        inside = self.U.T @ drift
        outside = drift - self.U @ inside
        return inside, (bends + self.whole @ outside) / self.reach

    def sliding(self, active: Sequence[int], along: Floats, drift: Floats, bends: Floats) -> Touch | None:
        """The forces of surfaces that press on a point that slides; None where they are not determined.

        Args:
            active: the surfaces.
            along: (r,) direction of sliding, zero without friction.
            drift, bends: of `load`.
        """
        if len(active) == 1:
            return self._sliding_on_one(active[0], along, drift, bends)
        chosen = list(active)
        N = self.normals[chosen]
        push = N - self.friction[chosen, None] * along
        A = N @ self.G @ push.T
        own = np.einsum("ki,ij,kj->k", N, self.G, N)
        if not _all_minors_positive(A, own):
            return None
        f = np.linalg.solve(A, -(N @ drift + bends[chosen]))
        return Touch(tuple(active), False, np.zeros_like(drift), push.T @ f, f * own)

    def _sliding_on_one(self, i: int, along: Floats, drift: Floats, bends: Floats) -> Touch | None:
        n = self.normals[i]
        answer = self.G @ n
        push = n - float(self.friction[i]) * along
        own, share = float(n @ answer), float(push @ answer)
        if share <= PARALLEL * own:
            return None
        f = -(float(n @ drift) + float(bends[i])) / share
        return Touch((i,), False, np.zeros(len(n)), f * push, np.array([f * own]))

    def sticking(self, active: Sequence[int], drift: Floats) -> Touch:
        """The force that stops a point, and whether friction can exert it.

        Args:
            active: the surfaces.
            drift: (r,) of `load`.
        """
        force = np.asarray(-np.linalg.solve(self.G, drift), dtype=np.float64)
        margin = cone_margin(force, self.normals[list(active)], self.friction[list(active)])
        slack = margin + ON_THE_CONE * float(np.linalg.norm(force))
        return Touch(tuple(active), True, np.zeros_like(drift), force, np.zeros(0), slack)

    def solve(self, drift: Floats, bends: Floats, along: Floats | None) -> Touch:
        """What the surfaces do to the point.

        Args:
            drift, bends: of `load`.
            along: (r,) direction of its velocity; None at rest.

        Raises:
            NoContactForce: rigid bodies have no force here, or several.
        """
        everything = tuple(range(len(self.reach)))
        if bool((self._into(drift, bends) <= QUIET).all()):
            return Touch((), False, np.zeros_like(drift), np.zeros_like(drift), np.zeros(0))
        rough = bool(self.friction.any())
        if along is None and rough:
            stuck = self.sticking(everything, drift)
            if stuck.slack >= 0.0:
                return stuck
            found = self._starting(drift, bends)
        else:
            direction = np.zeros_like(drift) if along is None else along
            found = [
                self.sliding(some, direction, drift, bends)
                for size in range(1, len(drift) + 1)
                for some in combinations(everything, size)
            ]
        fitting: list[Touch] = []
        for one in found:
            if one is None or (one.pressed < 0.0).any() or not self._is_parted(one, drift, bends):
                continue
            if all(np.abs(self.G @ (one.force - other.force)).max() > SINGULAR_CONTACT for other in fitting):
                fitting.append(one)
        if len(fitting) != 1:
            kind = "several" if fitting else "none"
            raise NoContactForce(f"simulation.contact_force_{kind}", friction=float((self.friction * self.reach).max()))
        return fitting[0]

    def holds(self, touch: Touch, drift: Floats, bends: Floats) -> bool:
        """Whether what is pressed goes on to be, and nothing else is: with what rounding is allowed.

        Args:
            touch: forces at a state.
            drift, bends: of `load` there.
        """
        return touch.slack >= 0.0 and bool((touch.pressed >= -QUIET).all()) and self._is_parted(touch, drift, bends)

    def _into(self, acceleration: Floats, bends: Floats) -> Floats:
        return -(self.normals @ acceleration + bends)

    def _is_parted(self, touch: Touch, drift: Floats, bends: Floats) -> bool:
        """Whether no surface that does not press is sunk into."""
        into = self._into(drift + self.G @ touch.force, bends)
        into[list(touch.active)] = 0.0
        return bool((into <= QUIET).all())

    def _starting(self, drift: Floats, bends: Floats) -> list[Touch | None]:
        """Forces with which a point at rest may begin to slide."""
        found: list[Touch | None] = []
        for i in range(len(self.reach)):
            if self.friction[i] == 0.0:
                found.append(self.sliding((i,), np.zeros_like(drift), drift, bends))
                continue
            for d in self.directions(i, drift, bends):
                found.append(self._begun((i,), d, drift, bends))
        if len(drift) == 3:
            for i, j in combinations(range(len(self.reach)), 2):
                edge = np.cross(self.normals[i], self.normals[j])
                length = float(np.linalg.norm(edge))
                if length > PARALLEL:
                    for d in (edge / length, -edge / length):
                        touch = self._begun((i, j), d, drift, bends)
                        if touch is not None and d @ (drift + self.G @ touch.force) > 0.0:
                            found.append(touch)
        return found

    def _begun(self, active: Sequence[int], d: Floats, drift: Floats, bends: Floats) -> Touch | None:
        touch = self.sliding(active, d, drift, bends)
        return None if touch is None else touch._replace(slip=d)

    def directions(self, i: int, drift: Floats, bends: Floats, before: Floats | float = 0.0) -> list[Floats]:
        """Directions (r,) of sliding on one surface in which a point moves after a while of friction against them.

        Args:
            i: the surface.
            drift, bends: of `load`.
            before: (r,) velocity at the beginning, over the while; zero at rest [m/s^2].
        """
        n = self.normals[i]
        need = -(float(n @ drift) + float(bends[i]))

        def acceleration(d: Floats) -> Floats:
            push = n - self.friction[i] * d
            share = push @ (self.G @ n)
            with np.errstate(divide="ignore", invalid="ignore"):
                f = np.where(share > 0.0, need / share, np.nan)
            return before + drift + f[:, None] * (push @ self.G)

        return aligned_directions(tangents(n), acceleration)


def aligned_directions(T: Floats, rate: Callable[[Floats], Floats]) -> list[Floats]:
    """Unit directions d (r,) of a tangent plane along which a rate points that depends on them.

    Args:
        T: (r, m) basis of the plane.
        rate: (k, r) -> (k, r); only its part in the plane counts.
    """
    if T.shape[1] == 0:
        return []
    if T.shape[1] == 1:
        both = np.array([T[:, 0], -T[:, 0]])
        return [d for d, r in zip(both, rate(both), strict=True) if d @ r > 0.0]

    def turned(angle: Floats) -> tuple[Floats, Floats, Floats]:
        d = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        r = rate(d @ T.T) @ T
        return d, d[:, 0] * r[:, 1] - d[:, 1] * r[:, 0], (d * r).sum(axis=-1)

    angles = np.linspace(0.0, 2.0 * np.pi, DIRECTIONS + 1)
    across = turned(angles)[1]
    found: list[Floats] = []
    for k in np.flatnonzero((across[:-1] > 0.0) != (across[1:] > 0.0)):
        if not np.isfinite(across[k : k + 2]).all():
            continue
        low, width = float(angles[k]), float(angles[k + 1] - angles[k])
        share = bracketed_root(lambda s, a=low, w=width: float(turned(np.array([a + s * w]))[1][0]), 0.0, 1.0)
        d, _, forward = turned(np.array([low + share * width]))
        if forward[0] > 0.0:
            found.append(T @ d[0])
    return found


def _determinant(A: Floats) -> float:
    """Of a (3, 3) matrix."""
    (a, b, c), (d, e, f), (g, h, i) = A.tolist()
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def tangents(n: Floats) -> Floats:
    """(r, r - 1) orthonormal directions at right angles to a unit vector (r,)."""
    return np.linalg.svd(n[None])[2][1:].T


def cone_margin(force: Floats, normals: Floats, friction: Floats) -> float:
    """How far within the sum of friction cones a force is, by the directions of the dual cones: negative outside [N].

    A force is in the sum iff no direction of all dual cones is against it. On the unit sphere a dual cone is the cap
    w . n >= mu / sqrt(1 + mu^2), so that the least w . F is taken at -F, at the lowest point of one edge, or where two
    edges cross.

    Args:
        force: (r,) r at most 3.
        normals: (k, r) units.
        friction: (k,) mu.
    """
    size = float(np.linalg.norm(force))
    if size == 0.0:
        return 0.0
    sines = friction / np.sqrt(1.0 + friction**2)
    found = [-force / size]
    if len(force) == 1:
        found = [np.array([1.0]), np.array([-1.0])]
    for n, s in zip(normals, sines, strict=True):
        found += _on_the_edge(n, float(s), force)
    if len(force) == 3:
        for i, j in combinations(range(len(sines)), 2):
            found += _where_edges_cross(normals[[i, j]], sines[[i, j]])
    W = np.array(found)
    kept = W[(W @ normals.T >= sines - PARALLEL).all(axis=1)]
    return float((kept @ force).min()) if len(kept) else size


def _on_the_edge(n: Floats, s: float, force: Floats) -> list[Floats]:
    """Directions on the edge of a cap that may be against a force most: its ends in the plane."""
    c = np.sqrt(1.0 - s * s)
    if len(n) == 1:
        return []
    if len(n) == 2:
        t = np.array([-n[1], n[0]])
        return [s * n + c * t, s * n - c * t]
    t = force - (force @ n) * n
    length = float(np.linalg.norm(t))
    t = t / length if length > 0.0 else tangents(n)[:, 0]
    return [s * n - c * t]


def _where_edges_cross(normals: Floats, sines: Floats) -> list[Floats]:
    """Directions (3,) on the edges of two caps."""
    g = float(normals[0] @ normals[1])
    determinant = 1.0 - g * g
    if determinant <= PARALLEL:
        return []
    weights = np.array([sines[0] - g * sines[1], sines[1] - g * sines[0]]) / determinant
    base = weights @ normals
    rest = 1.0 - float(base @ base)
    if rest < 0.0:
        return []
    across = np.cross(normals[0], normals[1]) * np.sqrt(rest / determinant)
    return [base + across, base - across]


def _all_minors_positive(A: Floats, own: Floats) -> bool:
    """Whether forces follow from accelerations in one way only: all principal minors are positive."""
    k = len(A)
    for size in range(1, k + 1):
        for some in combinations(range(k), size):
            chosen = np.ix_(some, some)
            if np.linalg.det(A[chosen]) <= PARALLEL * np.prod(own[list(some)]):
                return False
    return True
