"""The planar five-bar: two motors on the ground move a point C in the plane; all its positions, rates, singularities.

B = L1 e(alpha) and D = E + L4 e(beta) with E = (L5, 0) are the ends of the cranks; |C - B| = L2, |C - D| = L3.
As a chain of relative angles: alpha = theta_1, beta = theta_1 + ... + theta_4 + pi.

Closed planar chains of links on hinges by relative angles: closure, its rates and curvature, all singular points.

Links L_1 ... L_n-1 as a chain from the first ground pivot at the origin, angles theta_i relative to the link before;
the last link is the ground of length L_n, from the origin along x. With s_i = theta_1 + ... + theta_i:
sum L_i cos s_i = L_n, sum L_i sin s_i = 0, and sum of all n angles = pi modulo 2 pi.

Angles of cranks whose rods hold a platform, for poses of the platform: both of each, or by how much its rod misses.

A crank of length L goes round in a plane; its rod of length l ends at a point of that plane, `reach` from the motor, or
at some distance `across` from it. The angle between crank and point is acos(K / reach), with
K = (reach^2 + across^2 + L^2 - l^2) / (2 L).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, as_batch, frozen, positive, radians, real_array, single
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.messages.tables import number, table
from mafsil.mobility.spaces.planar_positions import circle_crossings, circle_gap, wrap_angle
from mafsil.mobility.tolerances import TOUCHING, TYPED
from mafsil.parallel.legs.leg_lines import require_regular, require_rods, resultant
from mafsil.parallel.loop_singularity import LoopSingularities, loop_singularities
from mafsil.parallel.platforms.nearest_lengths import LegEnds
from mafsil.parallel.platforms.platform_points import PlatformPoints
from mafsil.parallel.singular_kinds import SingularKinds, singular_kinds


@dataclass(frozen=True)
class FiveBar:
    """A planar five-bar by its lengths [m].

    Attributes:
        crank_1, rod_1, rod_2, crank_2, ground: L1 ... L5.
    """

    crank_1: float
    rod_1: float
    rod_2: float
    crank_2: float
    ground: float

    def __post_init__(self) -> None:
        for name in ("crank_1", "rod_1", "rod_2", "crank_2", "ground"):
            object.__setattr__(self, name, positive(name, getattr(self, name)))

    @cached_property
    def chain(self) -> PlanarChain:
        """The same as a chain of relative angles."""
        return PlanarChain(np.array([self.crank_1, self.rod_1, self.rod_2, self.crank_2, self.ground]))

    def crank_ends(self, q: ArrayLike) -> tuple[Floats, Floats]:
        """B and D (*batch, 2) at angles (alpha, beta) (*batch, 2) [rad]."""
        angle = radians("q", as_batch("q", q, (2,), finite=True))
        e = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        return self.crank_1 * e[..., 0, :], self.crank_2 * e[..., 1, :] + np.array([self.ground, 0.0])

    def forward_kinematics(self, q: ArrayLike) -> PlatformPoints:
        """Both places of C at angles (alpha, beta) (*batch, 2): left of B -> D first.

        Where the rods do not meet, C is in the middle of their gap, and `missing` says how far their lengths are off.
        """
        B, D = self.crank_ends(q)
        apart = np.linalg.norm(D - B, axis=-1)
        free = np.asarray(np.maximum(apart, abs(self.rod_1 - self.rod_2)) <= TOUCHING * self.rod_1, dtype=np.bool_)
        C, gap = circle_crossings(B, self.rod_1, D, self.rod_2), circle_gap(B, self.rod_1, D, self.rod_2)
        around = B[..., None, :] + self.rod_1 * np.array([[1.0, 0.0], [-1.0, 0.0]])
        ends = np.stack([B, D], axis=-2)
        rods = np.broadcast_to(np.array([self.rod_1, self.rod_2]), ends.shape[:-1])
        meets = np.asarray((gap == 0.0) | free, dtype=np.bool_)
        places = np.where(free[..., None, None], around, C)
        return PlatformPoints(places, meets, free, LegEnds(ends, np.zeros_like(ends), rods))

    def inverse_kinematics(self, C: ArrayLike) -> MotorAngles:
        """Both angles alpha and both angles beta for a place C (*batch, 2): elbow left of the line to C first."""
        place = as_batch("C", C, (2,), finite=True)
        along = place[..., None, 0] - np.array([0.0, self.ground])
        up = np.broadcast_to(place[..., None, 1], along.shape)
        cranks, rods = np.array([self.crank_1, self.crank_2]), np.array([self.rod_1, self.rod_2])
        return crank_angles(along, up, 0.0, cranks, rods)

    def chain_angles(self, q: ArrayLike, mode: int = 0) -> Floats:
        """(*batch, 5) relative angles at (alpha, beta) in one of both assembly modes.

        Where the rods do not meet, they point at each other: the cranks stand as asked, and `chain.closure` is the gap.
        """
        angle = as_batch("q", q, (2,))
        B, D = self.crank_ends(angle)
        C = self.forward_kinematics(angle).x[..., mode, :]
        forth, back = C - B, D - C
        turned = [
            angle[..., 0], np.arctan2(forth[..., 1], forth[..., 0]), np.arctan2(back[..., 1], back[..., 0]),
            angle[..., 1] + np.pi, np.full(angle.shape[:-1], np.pi),
        ]  # fmt: skip
        absolute = np.stack(turned, axis=-1)
        before = np.concatenate([np.zeros_like(absolute[..., :1]), absolute[..., :-1]], axis=-1)
        return wrap_angle(absolute - before)

    def motor_matrices(self, q: ArrayLike, C: ArrayLike) -> tuple[Floats, Floats]:
        """A and B (*batch, 2, 2) of A C' = B (alpha', beta'): rows (C - B)' and (C - D)'.

        Args:
            q, C: (*batch, 2) angles and places that belong together.

        Raises:
            InputError: they do not.
        """
        first, second = self.crank_ends(q)
        place = as_batch("C", C, (2,))
        rods = np.stack([place - first, place - second], axis=-2)
        require_rods(rods, np.array([self.rod_1, self.rod_2]))
        cranks = np.stack([first, second - np.array([self.ground, 0.0])], axis=-2)
        across = np.stack([-cranks[..., 1], cranks[..., 0]], axis=-1)
        return rods, (rods * across).sum(axis=-1)[..., None] * np.eye(2)

    def jacobian(self, q: ArrayLike, C: ArrayLike) -> Floats:
        """(*batch, 2, 2) of C' = J (alpha', beta').

        Args:
            q, C: (*batch, 2) angles and places that belong together.

        Raises:
            InputError: they do not, or the rods are in line.
        """
        A, B = self.motor_matrices(q, C)
        return np.asarray(np.linalg.solve(require_regular(A), B), dtype=np.float64)

    def torques(self, q: ArrayLike, C: ArrayLike, force: ArrayLike) -> Floats:
        """(*batch, 2) efforts of both motors [N m] with which C exerts a force (*batch, 2) [N].

        Args:
            q, C: (*batch, 2) angles and places that belong together.
            force: (*batch, 2) [N].

        Raises:
            InputError: as `jacobian`.
        """
        return resultant(self.jacobian(q, C), force)

    def motor_singularity(self, q: ArrayLike, C: ArrayLike) -> SingularKinds:
        """Kind of singularity with both motors on the ground: first, a crank in line with its rod; second, the rods."""
        A, B = self.motor_matrices(q, C)
        rods = np.array([[self.rod_1], [self.rod_2]])
        return singular_kinds(A / rods, B / (rods * np.array([[self.crank_1], [self.crank_2]])), 1.0, 0)

    def point_rates(self, theta: ArrayLike) -> Floats:
        """(*batch, 2, 5) of C' = J theta' for all five relative angles of the chain, given by the first four."""
        s = np.cumsum(as_batch("theta", theta, (4,)), axis=-1)[..., :2]
        x, y = (np.array([self.crank_1, self.rod_1]) * f(s) for f in (np.cos, np.sin))
        zero = np.zeros((*s.shape[:-1], 3))
        rows = [np.concatenate([np.stack(r, axis=-1), zero], axis=-1) for r in _both(x, y)]
        return np.stack(rows, axis=-2)

    def singularity(self, theta: ArrayLike, driven: Sequence[int] = (0, 4)) -> LoopSingularities:
        """All that is singular for any choice of driven joints, with C as the task.

        Args:
            theta: (4,) relative angles of the chain that close it.
            driven: joints that are driven, counted from 0.
        """
        angles = single("theta", theta, (4,))
        full = np.append(angles, self.chain.last_angle(angles))

        def closure(q: Floats) -> tuple[Floats, Floats]:
            miss = np.append(self.chain.closure(q[:4]), wrap_angle(q.sum() - np.pi))
            return miss, self.chain.loop_matrix(q[:4])

        return loop_singularities(
            self.chain.loop_matrix(angles), self.chain.curvature(angles), driven, full_rank=3, closure=closure, q=full,
            task=self.point_rates(angles),
        )  # fmt: skip


def _both(x: Floats, y: Floats) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """Rows of C' by theta_1 and theta_2."""
    return (-y[..., 0] - y[..., 1], -y[..., 1]), (x[..., 0] + x[..., 1], x[..., 1])


@dataclass(frozen=True, eq=False)
class PlanarChain:
    """A closed planar chain of n links on n hinges.

    Attributes:
        lengths: (n,) of the links, the ground last [m].
    """

    lengths: Floats

    def __post_init__(self) -> None:
        L = real_array("lengths", self.lengths)
        if L.ndim != 1 or len(L) < 3 or not (np.isfinite(L).all() and (L > 0).all()):
            raise InputError("parallel.chain_lengths", got=np.asarray(self.lengths).tolist())
        object.__setattr__(self, "lengths", frozen(L))

    @property
    def size(self) -> float:
        """The longest link [m]."""
        return float(self.lengths.max())

    def last_angle(self, theta: ArrayLike) -> Floats:
        """(*batch,) the last angle, at the second ground pivot: pi minus the sum of the others, in (-pi, pi]."""
        return wrap_angle(np.pi - self._given(theta).sum(axis=-1))

    def closure(self, theta: ArrayLike) -> Floats:
        """(*batch, 2) how far the chain misses the second ground pivot, for the n - 1 angles (*batch, n - 1) [m]."""
        s = np.cumsum(self._given(theta), axis=-1)
        L = self.lengths[:-1]
        return np.stack([np.cos(s) @ L - self.lengths[-1], np.sin(s) @ L], axis=-1)

    def closure_matrix(self, theta: ArrayLike) -> Floats:
        """(*batch, 2, n - 1) derivatives of `closure` by the angles."""
        s = np.cumsum(self._given(theta), axis=-1)
        x, y = self.lengths[:-1] * np.cos(s), self.lengths[:-1] * np.sin(s)
        return np.stack([-_tails(y), _tails(x)], axis=-2)

    def loop_matrix(self, theta: ArrayLike) -> Floats:
        """(*batch, 3, n) the same with all n angles and a third row, that their sum stays: any joint may be driven."""
        H = self.closure_matrix(theta)
        wide = np.concatenate([H, np.zeros((*H.shape[:-1], 1))], axis=-1)
        return np.concatenate([wide, np.ones((*wide.shape[:-2], 1, wide.shape[-1]))], axis=-2)

    def curvature(self, theta: ArrayLike) -> Floats:
        """(*batch, 3, n, n) second derivatives of the rows of the loop by all n angles."""
        angles = self._given(theta)
        s = np.cumsum(angles, axis=-1)
        x, y = _tails(self.lengths[:-1] * np.cos(s)), _tails(self.lengths[:-1] * np.sin(s))
        n = len(self.lengths)
        later = np.maximum(np.arange(n - 1)[:, None], np.arange(n - 1))
        found = np.zeros((*angles.shape[:-1], 3, n, n))
        found[..., 0, :-1, :-1], found[..., 1, :-1, :-1] = -x[..., later], -y[..., later]
        return found

    def collinear_configurations(self) -> Floats:
        """(k, n - 1) all configurations with every link on one line: there the rank of the loop drops, nowhere else.

        Signs e with sum e_i L_i = L_n. Each absolute angle is 0 or pi.
        """
        found: list[Floats] = []
        L = self.lengths
        for signs in product([1.0, -1.0], repeat=len(L) - 1):
            if abs(np.dot(signs, L[:-1]) - L[-1]) <= TYPED * self.size:
                absolute = np.where(np.array(signs) > 0, 0.0, np.pi)
                found.append(wrap_angle(np.diff(absolute, prepend=0.0)))
        return np.array(found).reshape(-1, len(L) - 1)

    def _given(self, theta: ArrayLike) -> Floats:
        return as_batch("theta", theta, (len(self.lengths) - 1,))


def _tails(v: Floats) -> Floats:
    """Sums from each entry to the last."""
    return np.cumsum(v[..., ::-1], axis=-1)[..., ::-1]


class MotorAnglesStatus(Status):
    """Whether all motors reach all poses."""

    REACHED = ("parallel.motors_reach", True)
    SOME = ("parallel.motors_some", False)
    OUT_OF_REACH = ("parallel.motors_out_of_reach", False)


@dataclass(frozen=True, eq=False, repr=False)
class MotorAngles(Answer, data="q misfit free reached"):
    """Both angles of each motor; true if every pose is reached, iterable over all choices, of a batch over its rows.

    Attributes:
        q: (*batch, m, 2) angles in (-pi, pi]; twice the one at which the rod comes nearest where it does not fit [rad].
        misfit: (*batch, m) by how much each rod is too short (positive) or too long; zero where it fits [m].
        free: (*batch, m) whether any angle will do: the rod ends on the axis of its motor, at the right distance.
        unit: deg of motors that turn, whose angles are radians all the same; m of motors that slide.
    """

    q: Floats
    misfit: Floats
    free: Booleans
    unit: str = "deg"

    @property
    def reached(self) -> Booleans:
        """(*batch,) whether all rods fit."""
        return np.asarray((self.misfit == 0.0).all(axis=-1), dtype=np.bool_)

    @property
    def choices(self) -> Floats:
        """(*batch, 2^m, m) all combinations of one angle for each motor, the last motor changing first."""
        m = self.q.shape[-2]
        picked = [self.q[..., np.arange(m), list(choice)] for choice in product((0, 1), repeat=m)]
        return np.stack(picked, axis=-2)

    @property
    def status(self) -> MotorAnglesStatus:
        """Of all rows together."""
        if self.reached.all():
            return MotorAnglesStatus.REACHED
        return MotorAnglesStatus.SOME if self.reached.any() else MotorAnglesStatus.OUT_OF_REACH

    def __len__(self) -> int:
        if self.misfit.ndim > 1:
            return len(self.q)
        return int(2 ** self.q.shape[-2]) if self else 0

    def __iter__(self) -> Iterator[Any]:
        if self.misfit.ndim > 1:
            return (MotorAngles(*row, self.unit) for row in zip(self.q, self.misfit, self.free, strict=True))
        return iter(self.choices if self else self.choices[:0])

    def _table(self) -> list[str]:
        if self.misfit.ndim > 1 or not self:
            return []
        head = (say("cli.parallel_motor"), f"1 [{self.unit}]", f"2 [{self.unit}]")
        shown = np.degrees(self.q) if self.unit == "deg" else self.q
        rows = [(str(k + 1), *map(number, both)) for k, both in enumerate(shown.tolist())]
        return table(head, rows)

    def explain(self, language: str | None = None) -> str:
        """How many poses are reached; of the row that misses most which motor, and by how much."""
        rows = self.misfit.reshape(-1, self.misfit.shape[-1])
        row, motor = np.unravel_index(int(np.abs(rows).argmax()), rows.shape) if rows.size else (0, 0)
        worst = float(rows[row, motor]) if rows.size else 0.0
        sentence = self.status.sentence(
            language, reached=int(self.reached.sum()), rows=len(rows), motors=rows.shape[-1], free=int(self.free.sum())
        )
        if not worst:
            return sentence
        reason = "short" if worst > 0 else "long"
        missed = say(f"parallel.rod_{reason}", language=language, motor=int(motor) + 1, length=abs(worst))
        return f"{sentence}: {missed}"


def crank_angles(along: Floats, up: Floats, across: Floats | float, crank: Floats | float, rod: Floats) -> MotorAngles:
    """Both angles of cranks, that with its elbow to the left of the line from the motor to the point first.

    Args:
        along, up: (*batch, m) place of the end of the rod in the plane of the crank, from its motor [m].
        across: (*batch, m) its distance from that plane [m].
        crank, rod: lengths [m].
    """
    reach = np.hypot(along, up)
    misfit = rod_misfit(reach, across, crank, rod)
    misfit = np.where(np.abs(misfit) <= TOUCHING * (crank + rod), 0.0, misfit)
    K = (reach**2 + across**2 + crank**2 - rod**2) / (2 * crank)
    free = np.asarray((reach <= TOUCHING * (crank + rod)) & (misfit == 0.0), dtype=np.bool_)
    ratio = np.divide(K, reach, out=np.ones_like(K), where=reach > 0.0)
    half = np.arccos(np.clip(ratio, -1.0, 1.0))
    middle = np.arctan2(up, along)
    return MotorAngles(wrap_angle(np.stack([middle + half, middle - half], axis=-1)), misfit, free)


def rod_misfit(along: Floats, across: Floats | float, crank: Floats | float, rod: Floats | float) -> Floats:
    """Lengths [m] that rods miss: positive where they are too short, negative where too long, zero where they fit.

    Args:
        along: distance of the far end of the rod from the motor, in the plane in which the crank goes round [m].
        across: its distance from that plane [m].
        crank, rod: lengths [m].
    """
    near, far = np.hypot(across, along - crank), np.hypot(across, along + crank)
    return np.maximum(near - rod, 0.0) - np.maximum(rod - far, 0.0)
