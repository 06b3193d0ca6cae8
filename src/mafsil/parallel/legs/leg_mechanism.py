"""Platforms on any legs: open chains of screws that end at one platform, with any choice of driven joints.

Leg i: T = exp([S_i1] q_i1) ... exp([S_in] q_in) M_i. All legs end in the same frame of the platform; the coordinates q
(n,) are those of the legs one after the other. H stacks, for each leg after the first, J_1 q_1' - J_i q_i' = 0.

Reference: Lynch & Park, Modern Robotics, sec. 7.1.3 and 7.2.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, frozen, real_array, single, whole
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.messages import say
from mafsil.parallel.closure import DrivenRates, driven_rates
from mafsil.parallel.loop_singularity import LoopSingularities, choose_actuators, loop_singularities, require_closed
from mafsil.parallel.tolerances import FEASIBLE, RANK
from mafsil.solvers.decompositions import pinv, ranks

CLOSING_STEPS = 12
"""Newton's steps back to closed loops from a tenth of a radian: six would do."""


@dataclass(frozen=True, eq=False)
class Leg:
    """An open chain from the base to the platform.

    Attributes:
        screws: (n, 6) of its joints in {s}, where it is drawn: a row for each, as `Robot.from_screws` takes them.
        home: (4, 4) pose of the platform at zero coordinates.
    """

    screws: Floats
    home: Floats

    def __post_init__(self) -> None:
        S = real_array("screws", self.screws)
        if S.ndim != 2 or S.shape[1] != 6 or not len(S) or not np.isfinite(S).all():
            hint = "; " + say("parallel.rows_of_screws") if S.ndim == 2 and len(S) == 6 else ""
            raise InputError("input.shape", name="screws", expected="(n, 6)", got=S.shape, hint=hint)
        object.__setattr__(self, "screws", frozen(S))
        object.__setattr__(self, "home", frozen(single("home", pose.check(self.home, "home"), (4, 4))))

    @property
    def n(self) -> int:
        """Number of joints of one freedom."""
        return len(self.screws)

    def pose(self, q: ArrayLike) -> Floats:
        """(*batch, 4, 4) of the platform at coordinates (*batch, n)."""
        return self._carried(q)[1]

    def jacobian(self, q: ArrayLike) -> Floats:
        """(*batch, 6, n) space Jacobian: V_s = J q'."""
        return self._carried(q)[0]

    def _carried(self, q: ArrayLike) -> tuple[Floats, Floats]:
        value = as_batch("q", q, (self.n,))
        T = np.broadcast_to(np.eye(4), (*value.shape[:-1], 4, 4))
        columns: list[Floats] = []
        for k in range(self.n):
            columns.append(np.einsum("...ij,j->...i", pose.adjoint(T), self.screws[k]))
            T = T @ pose.exp(self.screws[k] * value[..., k, None])
        return np.stack(columns, axis=-1), T @ self.home


@dataclass(frozen=True, eq=False)
class LegMechanism:
    """A platform on legs.

    Attributes:
        legs: two or more; they meet in one pose of the platform at zero coordinates if they are drawn there.
        driven: indices of the driven coordinates.
    """

    legs: tuple[Leg, ...]
    driven: tuple[int, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "legs", tuple(self.legs))
        if len(self.legs) < 2:
            raise InputError("parallel.few_legs", count=len(self.legs))
        driven = tuple(int(k) for k in self.driven)
        if len(set(driven)) != len(driven) or not driven or not all(0 <= k < self.n for k in driven):
            raise InputError("parallel.driven", driven=list(driven), most=self.n - 1)
        object.__setattr__(self, "driven", driven)

    @cached_property
    def n(self) -> int:
        """Number of coordinates."""
        return sum(leg.n for leg in self.legs)

    @cached_property
    def passive(self) -> tuple[int, ...]:
        """Indices of the coordinates that are not driven."""
        return tuple(k for k in range(self.n) if k not in self.driven)

    @cached_property
    def parts(self) -> tuple[slice, ...]:
        """Places of the coordinates of each leg."""
        ends = np.cumsum([leg.n for leg in self.legs]).tolist()
        return tuple(slice(end - leg.n, end) for leg, end in zip(self.legs, ends, strict=True))

    @property
    def counted_mobility(self) -> int:
        """By counting: sum of the freedoms of the legs less 6 (m - 1); the rank decides whether it is true."""
        return self.n - 6 * (len(self.legs) - 1)

    @cached_property
    def size(self) -> float:
        """Largest distance of an axis of rotation from the origin, or of the platform [m]."""
        far = [float(np.linalg.norm(leg.home[:3, 3])) for leg in self.legs]
        for leg in self.legs:
            w, v = leg.screws[:, :3], leg.screws[:, 3:]
            turns = np.linalg.norm(w, axis=1) > 0
            far += np.linalg.norm(np.cross(w[turns], v[turns]), axis=1).tolist()
        return max(far, default=1.0) or 1.0

    def with_driven(self, *driven: int) -> LegMechanism:
        """The same mechanism with other joints driven."""
        return LegMechanism(self.legs, driven)

    def poses(self, q: ArrayLike) -> Floats:
        """(*batch, m, 4, 4) of the platform as each leg has it."""
        value = as_batch("q", q, (self.n,))
        return np.stack([leg.pose(value[..., part]) for leg, part in zip(self.legs, self.parts, strict=True)], axis=-3)

    def closure(self, q: ArrayLike) -> Floats:
        """(*batch, 6 (m - 1)) twists log(T_1 T_i^-1) by which the legs miss each other [rad, m]."""
        T = self.poses(q)
        gap = pose.log(T[..., :1, :, :] @ pose.inverse(T[..., 1:, :, :]))
        return gap.reshape(*gap.shape[:-2], -1)

    def leg_jacobians(self, q: ArrayLike) -> list[Floats]:
        """(*batch, 6, n_i) space Jacobian of each leg."""
        value = as_batch("q", q, (self.n,))
        return [leg.jacobian(value[..., part]) for leg, part in zip(self.legs, self.parts, strict=True)]

    def loop_matrix(self, q: ArrayLike) -> Floats:
        """(*batch, 6 (m - 1), n) H with H q' = 0: rows J_1 q_1' - J_i q_i'."""
        J = self.leg_jacobians(q)
        H = np.zeros((*J[0].shape[:-2], 6 * (len(J) - 1), self.n))
        for i in range(1, len(J)):
            rows = slice(6 * (i - 1), 6 * i)
            H[..., rows, self.parts[0]], H[..., rows, self.parts[i]] = J[0], -J[i]
        return H

    def curvature(self, q: ArrayLike) -> Floats:
        """(6 (m - 1), n, n) second derivatives of the loops on motions that H leaves."""
        J = self.leg_jacobians(single("q", q, (self.n,)))
        found = np.zeros((6 * (len(J) - 1), self.n, self.n))
        for i, columns in enumerate(J):
            bent = _bent(columns)
            at = self.parts[i]
            for k in range(1, len(J)):
                rows = slice(6 * (k - 1), 6 * k)
                if i == 0:
                    found[rows, at, at] = bent
                elif i == k:
                    found[rows, at, at] = -bent
        return found

    def rates(self, q: ArrayLike) -> DrivenRates:
        """Rates of the passive joints per rate of the driven ones at one configuration that closes the loops."""
        return driven_rates(self.loop_matrix(self.require_closed(q)), self.driven)

    def jacobian(self, q: ArrayLike, leg: int = 0) -> Floats:
        """(6, a) space Jacobian of the platform by the driven joints, taken through one of the legs.

        Idle freedoms of the passive joints, such as the spin of a rod, do not matter. With more motors than motions it
        holds for the rates that the loops admit (`rates(q).admissible`), all others have none.

        Args:
            q: (n,) coordinates that close the loops.
            leg: through which the twist is read; all give the same.

        Raises:
            InputError: legs miss each other there, or the driven joints do not decide the motion of the platform.
        """
        value = self.require_closed(q)
        J, found = self.leg_jacobians(value), driven_rates(self.loop_matrix(value), self.driven)
        columns = np.zeros((self.n, len(self.driven)))
        columns[list(self.driven)] = np.eye(len(self.driven))
        columns[list(self.passive)] = found.passive_map
        free = np.zeros((self.n, found.free.shape[1]))
        free[list(self.passive)] = found.free
        scale = np.concatenate([np.ones(3), np.full(3, self.size)])
        moves = np.abs(J[0] @ free[self.parts[0]] / scale[:, None]).max(initial=0.0) > 10 * RANK
        if moves:
            raise InputError("parallel.undecided", free=found.free.shape[1])
        return J[leg] @ columns[self.parts[leg]]

    def require_closed(self, q: ArrayLike) -> Floats:
        """(n,) coordinates, looked at.

        Args:
            q: (n,) that close the loops.

        Raises:
            InputError: wrong ones, or legs that miss each other there.
        """
        value = single("q", q, (self.n,))
        require_closed(self._scale * self.closure(value))
        return value

    @cached_property
    def _scale(self) -> Floats:
        """(6 (m - 1),) one for angles, one over the size for lengths, so that no singular value depends on units."""
        return np.tile(np.concatenate([np.ones(3), np.full(3, 1 / self.size)]), len(self.legs) - 1)

    def generic_rank(self, q: ArrayLike, samples: int = 6, seed: int = 0) -> int:
        """Largest rank of H at closed configurations around one: what the loops ask on most configurations.

        Legs that move in one plane, or translate, ask less than 6 (m - 1) everywhere.

        Args:
            q: (n,) coordinates that close the loops.
            samples: random steps of up to 0.1 rad, or as much of the size, that are closed by Newton's method.
            seed: of the steps.
        """
        here, rng = self.require_closed(q), np.random.default_rng(seed)
        around = here + 0.1 * rng.uniform(-1.0, 1.0, (whole("samples", samples, 0), self.n)) * self._units
        for _ in range(CLOSING_STEPS):
            H = self._scale[:, None] * self.loop_matrix(around) * self._units
            gap = self._scale * self.closure(around)
            around = around - np.einsum("kij,kj->ki", pinv(H, RANK), gap) * self._units
        closed = np.abs(self._scale * self.closure(around)).max(axis=-1, initial=0.0) < FEASIBLE
        looked_at = np.concatenate([here[None], around[closed]])
        return int(ranks(self._scale[:, None] * self.loop_matrix(looked_at) * self._units, RANK).max())

    @cached_property
    def _units(self) -> Floats:
        """(n,) one for angles, the size for slides."""
        slides = np.concatenate([np.linalg.norm(leg.screws[:, :3], axis=1) == 0 for leg in self.legs])
        return np.where(slides, self.size, 1.0)

    def singularity(self, q: ArrayLike, full_rank: int | None = None) -> LoopSingularities:
        """All that is singular about a configuration that closes the loops, for the motion of the platform.

        Args:
            q: (n,) coordinates.
            full_rank: rank of H on most configurations; `generic_rank` if None.

        Raises:
            InputError: legs miss each other there.
        """
        value, scale, units = self.require_closed(q), self._scale, self._units
        H, task = self._without_units(value)
        bent = scale[:, None, None] * self.curvature(value) * units[:, None] * units

        def closure(x: Floats) -> tuple[Floats, Floats]:
            return scale * self.closure(x * units), scale[:, None] * self.loop_matrix(x * units) * units

        expected = self.generic_rank(value) if full_rank is None else full_rank
        return loop_singularities(
            H, bent, self.driven, full_rank=expected, closure=closure, q=value / units, task=task,
            idle=True,
        )  # fmt: skip

    def _without_units(self, q: Floats) -> tuple[Floats, Floats]:
        """H, and the twist of the platform by all rates (6, n), with lengths over the size."""
        task = np.zeros((6, self.n))
        task[:, self.parts[0]] = self.leg_jacobians(q)[0]
        H = self._scale[:, None] * self.loop_matrix(q) * self._units
        return H, self._scale[:6, None] * task * self._units

    def choose_actuators(
        self, q: ArrayLike, count: int | None = None, among: Sequence[int] | None = None
    ) -> tuple[tuple[int, ...], ...]:
        """All choices of joints that, when driven, decide the motion of the platform; spins of rods do not matter.

        Args:
            q: (n,) coordinates that close the loops.
            count: of motors; as many as are driven if None.
            among: joints that may be driven; all if None.

        Raises:
            InputError: legs miss each other there, or too many choices.
        """
        value = self.require_closed(q)
        H, task = self._without_units(value)
        wanted = len(self.driven) if count is None else whole("count", count, 1, self.n)
        return choose_actuators(H, wanted, self.generic_rank(value), task=task, among=among)

    def sampled_rank(self, configurations: ArrayLike) -> int:
        """The largest rank of H over configurations (k, n) that close the loops: the rank on most of them."""
        H = self.loop_matrix(as_batch("configurations", configurations, (self.n,)))
        return int(ranks(self._scale[:, None] * H * self._units, RANK).max(initial=0))


def _bent(J: Floats) -> Floats:
    """(6, n, n) symmetric: ad(J_a) J_b / 2 for a before b."""
    n = J.shape[1]
    found = np.zeros((6, n, n))
    for a in range(n):
        w, v = J[:3, a], J[3:, a]
        for b in range(a + 1, n):
            turn = np.concatenate([np.cross(w, J[:3, b]), np.cross(w, J[3:, b]) + np.cross(v, J[:3, b])])
            found[:, a, b] = found[:, b, a] = turn / 2
    return found


def legs_from_screws(screws: Sequence[ArrayLike], home: ArrayLike) -> tuple[Leg, ...]:
    """Legs that are drawn in one pose of the platform (4, 4), by their screws (n_i, 6), a row for each joint."""
    T = real_array("home", home)
    return tuple(Leg(real_array("screws", each), T) for each in screws)
