"""The planar four-bar: Grashof's classes, all positions, closure and its rates, dead points, coupler curves.

Links: crank L1 at the origin, coupler L2, rocker L3, ground L4 from the origin to (L4, 0). Relative angles theta_1 ...
theta_4 as a chain that returns to the origin along the ground, so that their sum is pi modulo 2 pi.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, as_batch, positive, radians, single
from mafsil.errors import InputError, InputWarning, warn
from mafsil.messages import say
from mafsil.messages.tables import number, table
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.linkages.linkage_joint import Kind, joint
from mafsil.mobility.spaces.planar_positions import (
    PolygonSpace,
    circle_crossings,
    circle_gap,
    directions,
    finite_numbers,
    per_crank,
    polygon_space,
    wrap_angle,
)
from mafsil.mobility.tolerances import TOUCHING, TYPED

INSET = 1e-9
"""Share of an interval of the crank by which curves stay off its ends, where rounding decides whether links reach."""


class GrashofClass(Enum):
    """What goes round; the value is the key of its sentence."""

    CRANK_ROCKER = "grashof_crank_rocker"
    ROCKER_CRANK = "grashof_rocker_crank"
    DOUBLE_CRANK = "grashof_double_crank"
    DOUBLE_ROCKER = "grashof_double_rocker"
    TRIPLE_ROCKER = "grashof_triple_rocker"
    CHANGE_POINT = "grashof_change_point"
    STRETCHED = "grashof_stretched"
    IMPOSSIBLE = "grashof_impossible"

    def sentence(self, language: str | None = None) -> str:
        """What the class means."""
        return say(f"mobility.{self.value}", language=language)


class PositionStatus(Status):
    """Whether the linkage closes at the given inputs."""

    ALL = ("mobility.positions_all", True)
    FREE = ("mobility.positions_free", True)
    SOME = ("mobility.positions_some", True)
    NONE = ("mobility.positions_none", False)
    NEVER = ("mobility.positions_never", False)


@dataclass(frozen=True, eq=False, repr=False)
class FourBarPositions(Answer, data="theta C turns residual missing beyond free"):
    """Both assembly modes at angles of the crank; true if some input can be reached, iterable over the modes.

    Attributes:
        theta: (*batch, 2, 4) relative angles in (-pi, pi], mode with C left of B -> D first; where the linkage does not
            close twice those of the dead point nearest to the input, with the crank turned back as far as that.
        C: (*batch, 2, 2) joint of coupler and rocker there [m].
        turns: (*batch, 2) the sum of the angles over pi: an odd number.
        residual: largest closure error [m, rad].
        missing: (*batch,) length by which coupler and rocker are too short or too unequal to meet at the input; zero
            where they do [m].
        beyond: (*batch,) angle of the input beyond the dead point that is given; zero where they meet, and where the
            lengths close at no angle: then all links are on one line with a gap of `space.excess` [rad].
        free: (*batch,) whether B and D coincide there and coupler and rocker are of one length, so that C is anywhere
            on a circle about them: theta and C are the two places where the crank, coming to 0 from above, leaves it.
    """

    theta: Floats
    C: Floats
    turns: Floats
    residual: float
    missing: Floats
    beyond: Floats
    free: Booleans

    @property
    def reachable(self) -> Booleans:
        """(*batch,) whether the linkage closes at the input."""
        return np.asarray(self.missing == 0.0, dtype=np.bool_)

    @property
    def status(self) -> PositionStatus:
        """By how many inputs close."""
        if self.reachable.all():
            return PositionStatus.FREE if self.free.any() else PositionStatus.ALL
        if self.reachable.any():
            return PositionStatus.SOME
        return PositionStatus.NONE if self.beyond.any() else PositionStatus.NEVER

    def __len__(self) -> int:
        return 2

    def __iter__(self) -> Iterator[Floats]:
        return iter((self.theta[..., 0, :], self.theta[..., 1, :]))

    def _table(self) -> list[str]:
        head = (say("mobility.mode_head"), *(f"theta_{k + 1} [rad]" for k in range(4)), "C_x [m]", "C_y [m]")
        flat, places = self.theta.reshape(-1, 2, 4), self.C.reshape(-1, 2, 2)
        rows = [
            (str(mode + 1), *map(number, flat[k, mode].tolist()), *map(number, places[k, mode].tolist()))
            for k in range(len(flat))
            for mode in range(2)
        ]
        return table(head, rows)

    def explain(self, language: str | None = None) -> str:
        """How many inputs close, and how exactly."""
        return self.status.sentence(
            language, reached=int(self.reachable.sum()), count=self.reachable.size, residual=self.residual,
            missing=least_positive(self.missing), beyond=least_positive(self.beyond), free=int(self.free.sum()),
        )  # fmt: skip


@dataclass(frozen=True)
class FourBar:
    """A planar four-bar by its lengths [m].

    Attributes:
        crank, coupler, rocker, ground: L1, L2, L3, L4.
    """

    crank: float
    coupler: float
    rocker: float
    ground: float

    def __post_init__(self) -> None:
        for name in ("crank", "coupler", "rocker", "ground"):
            object.__setattr__(self, name, positive(name, getattr(self, name)))

    @property
    def lengths(self) -> Floats:
        """(4,) L1 ... L4."""
        return np.array([self.crank, self.coupler, self.rocker, self.ground])

    @cached_property
    def space(self) -> PolygonSpace:
        """All configurations together: how many closed curves they are."""
        return polygon_space(self.lengths)

    @cached_property
    def grashof(self) -> GrashofClass:
        """What goes round: by shortest + longest < sum of the other two, and by which link is shortest."""
        L = self.lengths
        if not self.space:
            return GrashofClass.IMPOSSIBLE
        if self.space.excess >= -TYPED * L.max():
            return GrashofClass.STRETCHED
        margin = 2 * (L.min() + L.max()) - L.sum()
        if abs(margin) <= TYPED * L.max():
            return GrashofClass.CHANGE_POINT
        if margin > 0:
            return GrashofClass.TRIPLE_ROCKER
        return (
            GrashofClass.CRANK_ROCKER, GrashofClass.DOUBLE_ROCKER, GrashofClass.ROCKER_CRANK, GrashofClass.DOUBLE_CRANK,
        )[int(L.argmin())]  # fmt: skip

    @property
    def input_range(self) -> tuple[float, float] | None:
        """Least and greatest |theta_1| at which the linkage closes [rad]; None if it never does.

        From |L2 - L3| <= |BD| <= L2 + L3 with |BD|^2 = L1^2 + L4^2 - 2 L1 L4 cos theta_1.
        """
        return self._dead_points if self.space else None

    @cached_property
    def _dead_points(self) -> tuple[float, float]:
        """`input_range`; twice the angle at which the gap is least, if it never closes."""
        L1, L2, L3, L4 = self.lengths.tolist()
        cosines = [(L1**2 + L4**2 - reach**2) / (2 * L1 * L4) for reach in (abs(L2 - L3), L2 + L3)]
        low, high = (float(np.arccos(np.clip(c, -1.0, 1.0))) for c in cosines)
        return low, high

    def positions(self, theta_1: ArrayLike) -> FourBarPositions:
        """Both assembly modes at angles of the crank (*batch,) [rad]."""
        angle = radians("theta_1", finite_numbers("theta_1", theta_1))
        L2, L3, D = self.coupler, self.rocker, np.array([self.ground, 0.0])
        B = self._crank_end(angle)
        way = np.linalg.norm(D - B, axis=-1)
        free = np.asarray(np.maximum(way, abs(L2 - L3)) <= TOUCHING * self.lengths.max(), dtype=np.bool_)
        missing = np.where(free, 0.0, circle_gap(B, L2, D, L3))
        closes = missing == 0.0
        wound = wrap_angle(angle)
        back = np.copysign(np.clip(np.abs(wound), *self._dead_points), wound)
        beyond = np.where(closes, 0.0, np.abs(wrap_angle(wound - back)) if self.space else 0.0)
        crank = np.where(closes, angle, back)
        B = self._crank_end(crank)
        C = circle_crossings(B, L2, D, L3)
        # At a dead point both places are one, which rounding would take apart by its root.
        C = np.where(closes[..., None, None], C, C.mean(axis=-2, keepdims=True))
        folded = B[..., None, :] + L2 * np.array([[1.0, 0.0], [-1.0, 0.0]])
        C = np.where(free[..., None, None], folded, C)
        theta = self._relative(crank[..., None], C - B[..., None, :], D - C)
        residual = float(np.abs(self.closure(theta[closes])).max(initial=0.0))
        turns = np.asarray(np.round(theta.sum(axis=-1) / np.pi), dtype=np.float64)
        return FourBarPositions(theta, C, turns, residual, missing, beyond, free)

    def _crank_end(self, angle: Floats) -> Floats:
        return self.crank * np.stack([np.cos(angle), np.sin(angle)], axis=-1)

    @staticmethod
    def _relative(theta_1: Floats, coupler: Floats, rocker: Floats) -> Floats:
        """(*batch, 4) relative angles, from that of the crank and the vectors from B to C and from C to D."""
        directions = [np.arctan2(link[..., 1], link[..., 0]) for link in (coupler, rocker)]
        first, *rest = np.broadcast_arrays(theta_1, *directions, np.pi)
        return wrap_angle(np.diff(np.stack([np.zeros_like(first), first, *rest], axis=-1), axis=-1))

    def closure(self, theta: ArrayLike) -> Floats:
        """(*batch, 3) sum L cos s [m], sum L sin s [m], s_4 - pi in (-pi, pi], with s_j = theta_1 + ... + theta_j."""
        s = np.cumsum(as_batch("theta", theta, (4,)), axis=-1)
        with np.errstate(invalid="ignore"):
            around = wrap_angle(s[..., 3] - np.pi)
        return np.stack([np.cos(s) @ self.lengths, np.sin(s) @ self.lengths, around], axis=-1)

    def closure_matrix(self, theta: ArrayLike) -> Floats:
        """(*batch, 3, 4) derivatives of the closure equations by the angles: A(theta) theta' = 0."""
        s = np.cumsum(as_batch("theta", theta, (4,)), axis=-1)
        x, y = self.lengths * np.cos(s), self.lengths * np.sin(s)
        rows = [
            -np.cumsum(y[..., ::-1], axis=-1)[..., ::-1],
            np.cumsum(x[..., ::-1], axis=-1)[..., ::-1],
            np.ones(s.shape),
        ]
        return np.stack(rows, axis=-2)

    def rates(self, theta: ArrayLike) -> Floats:
        """(*batch, 4) rates of the angles for a crank of rate 1 [rad/s].

        At dead points the crank stands: the others are infinite with the signs of `tangents`, zero if they stand too.
        Where all links lie on one line two branches may cross: those of the first, `branch_rates` has both.

        Warns:
            InputWarning: two branches cross at a configuration.
        """
        found = self.branch_rates(theta)
        if not np.array_equal(found[..., 0, :], found[..., 1, :]):
            warn(InputWarning("mobility.two_branches"))
        return found[..., 0, :]

    def branch_rates(self, theta: ArrayLike) -> Floats:
        """(*batch, 2, 4) rates for a crank of rate 1 on both branches that cross there; equal ones where one passes.

        Zeros at a configuration that the linkage cannot leave.
        """
        return per_crank(self.tangents(theta))

    def tangents(self, theta: ArrayLike) -> Floats:
        """(*batch, 2, 4) unit directions in which the angles change on both branches; equal ones where one passes.

        Finite at dead points too, where the first entry is zero. Two branches cross where all links lie on one line,
        unless the linkage cannot leave that configuration: zeros.
        """
        return directions(self.lengths, self.closure_matrix(theta), as_batch("theta", theta, (4,)))

    def transmission_angle(self, theta: ArrayLike) -> Floats:
        """(*batch,) angle between coupler and rocker in [0, pi] [rad]: pi/2 is best, 0 and pi are dead points."""
        return np.abs(wrap_angle(as_batch("theta", theta, (4,))[..., 2]))

    def coupler_point(self, theta: ArrayLike, along: float, across: float) -> Floats:
        """(*batch, 2) a point of the coupler: `along` from B towards C and `across` to the left of it [m]."""
        s = np.cumsum(as_batch("theta", theta, (4,)), axis=-1)
        u = np.stack([np.cos(s[..., 1]), np.sin(s[..., 1])], axis=-1)
        B = self.crank * np.stack([np.cos(s[..., 0]), np.sin(s[..., 0])], axis=-1)
        return B + along * u + across * np.stack([-u[..., 1], u[..., 0]], axis=-1)

    def coupler_curves(self, along: float, across: float, samples: int = 361) -> tuple[Floats, ...]:
        """Closed curves (k, 2) that a point of the coupler draws, one for each piece of the configurations [m]."""
        place = single("along, across", [along, across], (2,)).tolist()
        return tuple(self.coupler_point(theta, *place) for theta in self.curves(samples))

    def curves(self, samples: int = 361) -> tuple[Floats, ...]:
        """The configurations as closed curves (k, 4) of angles, sampled along the crank.

        Where the crank goes round each mode is a curve; where it swings the modes join at its ends, in one curve
        for each interval of theta_1 that is reached. Where crank and ground, and coupler and rocker, are of one
        length, each mode goes on as the other one at theta_1 = 0, and there the folded linkage has a curve of its own.
        """
        reach = self.input_range
        if reach is None:
            return ()
        low, high = reach
        spread = np.clip((1 - np.cos(np.linspace(0, np.pi, samples))) / 2, INSET, 1 - INSET)
        round_trip = low <= TYPED and high >= np.pi - TYPED
        if self.positions(0.0).free:
            return self._kite_curves((2 * np.pi if round_trip else high) * spread, round_trip)
        if round_trip:
            theta = self.positions(np.linspace(-np.pi, np.pi, samples)).theta
            return theta[:, 0], theta[:, 1]
        if low <= TYPED:
            intervals = [(-high, high)]
        elif high >= np.pi - TYPED:
            intervals = [(low, 2 * np.pi - low)]
        else:
            intervals = [(low, high), (-high, -low)]
        found: list[Floats] = []
        for start, end in intervals:
            places = self.positions(start + (end - start) * spread)
            theta = places.theta[places.reachable]
            found.append(np.concatenate([theta[:, 0], theta[::-1, 1]]))
        return tuple(found)

    def _kite_curves(self, forth: Floats, round_trip: bool) -> tuple[Floats, Floats]:
        """The curve of both modes, and that of the folded linkage, from crank angles (k,) that rise from 0."""
        ahead = self.positions(forth).theta
        pieces = [ahead[:, 0], ahead[:, 1]] if round_trip else [ahead[:, 0], ahead[::-1, 1]]
        if not round_trip:
            back = self.positions(-forth).theta
            pieces += [back[:, 0], back[::-1, 1]]
        around = np.linspace(-np.pi, np.pi, len(forth))
        coupler = np.stack([np.cos(around), np.sin(around)], axis=-1)
        return np.concatenate(pieces), self._relative(np.zeros(len(forth)), coupler, -coupler)

    def linkage(self, theta_1: float = 1.0, mode: int = 0) -> Linkage:
        """The linkage drawn at an angle of the crank [rad], in the first or second assembly mode.

        Raises:
            InputError: it does not close there.
        """
        found = self.positions(theta_1)
        require_reached(float(found.missing), float(theta_1))
        B = self.crank * np.array([np.cos(theta_1), np.sin(theta_1)])
        return Linkage.of(
            [
                joint("A", "R", ["ground", "crank"], [0, 0], actuated=True),
                joint("B", "R", ["crank", "coupler"], B),
                joint("C", "R", ["coupler", "rocker"], found.C[mode]),
                joint("D", "R", ["rocker", "ground"], [self.ground, 0]),
            ],
            name="four-bar", planar=True, output="coupler",
        )  # fmt: skip


def four_bar_of(linkage: Linkage) -> FourBar | None:
    """The planar four-bar that a linkage is, with its driven link on the ground as the crank; None for all others.

    Args:
        linkage: as drawn.
    """
    around = {body: [each for each in linkage.joints if body in (each.parent, each.child)] for body in linkage.bodies}
    hinged = linkage.planar and not linkage.apart and all(each.kind is Kind.REVOLUTE for each in linkage.joints)
    if not hinged or len(around) != 4 or any(len(joints) != 2 for joints in around.values()):
        return None
    body = linkage.bodies[0]
    pivot, last = sorted(around[body], key=lambda each: not each.actuated)
    lengths = [float(np.linalg.norm(pivot.point - last.point))]
    while pivot is not last:
        body = pivot.child if pivot.parent == body else pivot.parent
        one, other = around[body]
        following = other if one is pivot else one
        lengths.append(float(np.linalg.norm(following.point - pivot.point)))
        pivot = following
    ground, crank, coupler, rocker = lengths
    return FourBar(crank, coupler, rocker, ground) if min(lengths) > 0.0 else None


def least_positive(numbers: Floats) -> float:
    """The least number above zero, zero if there is none."""
    return float(np.min(numbers, where=numbers > 0.0, initial=np.inf)) if (numbers > 0.0).any() else 0.0


def require_reached(missing: float, angle: float) -> None:
    """Refuse an input at which a linkage does not close, by how much [m]."""
    if not missing <= 0.0:
        raise InputError("mobility.not_reached", angle=angle, missing=missing)
