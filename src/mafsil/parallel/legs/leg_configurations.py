"""Configurations of platforms on legs: all coordinates for given driven ones, and for a given pose of the platform.

Forward: Newton's method on the passive coordinates, H_p dq_p = - r, steps of least norm, so that idle freedoms stay.
Inverse: each leg on its own, J_i dq_i = log(T T_i^-1), damped while the residual does not fall; a leg of fewer than six
joints reaches only some poses, and the others are said to be infeasible, never approximated.

All that a search finds: poses of a platform on legs for given motors, and branches of every leg for a given pose.

Newton's method from many random starts in one batch. What comes back several times is one answer; how often the rarest
was met says how much may have been missed. A search proves nothing about others.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import prod

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, Integers, as_batch, single, whole
from mafsil.geometry import pose
from mafsil.mobility.spaces.planar_positions import wrap_angle
from mafsil.parallel.closure import numerical_rank
from mafsil.parallel.legs.leg_mechanism import Leg, LegMechanism
from mafsil.parallel.tolerances import FEASIBLE, SAME

CLOSED = 1e-11
"""Gap of the loops, lengths over the size, that ends Newton's method."""
LONGEST = 0.5
"""Of a Newton step [rad, sizes]."""
LEAST_DAMPING = 1e-12
"""Of normal equations of size one: a leg with idle freedoms stays solvable, other steps do not change."""


class ConfigurationStatus(Status):
    """How a search for configurations ended."""

    FOUND = ("parallel.configuration_found", True)
    SOME = ("parallel.configuration_some", False)
    NOT_FOUND = ("parallel.configuration_not_found", False)


@dataclass(frozen=True, eq=False, repr=False)
class LegConfigurations(Answer, data="q T found gap steps"):
    """Configurations of a platform on legs; true if all were found, iterable over the rows of the batch.

    Attributes:
        q: (*batch, n) coordinates of all joints, leg by leg; the last of the search where none was found.
        T: (*batch, 4, 4) poses of the platform.
        found: (*batch,) whether the loops close there.
        gap: (*batch,) largest entry of what the legs miss, lengths over the size.
        steps: (*batch,) steps of the search.
    """

    q: Floats
    T: Floats
    found: Booleans
    gap: Floats
    steps: Integers

    @property
    def status(self) -> ConfigurationStatus:
        """Of all rows together."""
        if self.found.all():
            return ConfigurationStatus.FOUND
        return ConfigurationStatus.SOME if self.found.any() else ConfigurationStatus.NOT_FOUND

    def __len__(self) -> int:
        return int(self.found.size)

    def __iter__(self) -> Iterator[Floats]:
        return iter(self.q.reshape(-1, self.q.shape[-1]))

    def explain(self, language: str | None = None) -> str:
        """How many were found and how well the legs meet."""
        return self.status.sentence(
            language, found=int(self.found.sum()), count=self.found.size, gap=float(self.gap.max(initial=0.0)),
            steps=int(self.steps.max(initial=0)),
        )  # fmt: skip


def leg_forward(
    mechanism: LegMechanism, q_driven: ArrayLike, q_guess: ArrayLike | None = None, max_steps: int = 50
) -> LegConfigurations:
    """Configurations with given driven coordinates, near first ones: the assembly mode of the guess, if it is near.

    Args:
        mechanism: legs and driven joints.
        q_driven: (*batch, a) of the driven joints [rad | m].
        q_guess: (*batch, n) first coordinates of all joints; zero, where the legs are drawn, if None.
        max_steps: most steps.
    """
    wanted = as_batch("q_driven", q_driven, (len(mechanism.driven),), finite=True)
    guess = as_batch("q_guess", np.zeros(mechanism.n) if q_guess is None else q_guess, (mechanism.n,), finite=True)
    most, shape = whole("max_steps", max_steps, 1), np.broadcast_shapes(wanted.shape[:-1], guess.shape[:-1])
    q = np.broadcast_to(guess, (*shape, mechanism.n)).reshape(-1, mechanism.n).copy()
    q[:, list(mechanism.driven)] = np.broadcast_to(wanted, (*shape, wanted.shape[-1])).reshape(len(q), -1)
    passive, scale = list(mechanism.passive), _scale(mechanism.size, len(mechanism.legs) - 1)
    steps, moving = np.zeros(len(q), dtype=np.intp), np.arange(len(q))
    gap = np.full(len(q), np.inf)
    for _ in range(most + 1):
        miss = scale * mechanism.closure(q[moving])
        gap[moving] = np.abs(miss).max(axis=1)
        moving, miss = moving[gap[moving] > CLOSED], miss[gap[moving] > CLOSED]
        if not len(moving):
            break
        H = scale[:, None] * mechanism.loop_matrix(q[moving])[:, :, passive]
        step = -np.einsum("kij,kj->ki", np.linalg.pinv(H, rcond=1e-10), miss)
        q[moving[:, None], passive] += _shorten(step)
        steps[moving] += 1
    found = np.asarray(gap <= FEASIBLE)
    T = mechanism.legs[0].pose(q[:, mechanism.parts[0]])
    return _shape(q, T, found, gap, np.minimum(steps, most), shape)


def leg_inverse(
    mechanism: LegMechanism, T: ArrayLike, q_guess: ArrayLike | None = None, max_steps: int = 100
) -> LegConfigurations:
    """Configurations with given poses of the platform, leg by leg, near first ones.

    Args:
        mechanism: its legs.
        T: (*batch, 4, 4) poses.
        q_guess: (*batch, n) first coordinates: they choose the branch of each leg; zero if None.
        max_steps: most steps.

    Returns:
        Configurations; not found where some leg misses its pose, which legs of fewer than six joints mostly do.
    """
    wanted = pose.check(T)
    guess = as_batch("q_guess", np.zeros(mechanism.n) if q_guess is None else q_guess, (mechanism.n,), finite=True)
    most, shape = whole("max_steps", max_steps, 1), np.broadcast_shapes(wanted.shape[:-2], guess.shape[:-1])
    q = np.broadcast_to(guess, (*shape, mechanism.n)).reshape(-1, mechanism.n).copy()
    goals = np.broadcast_to(wanted, (*shape, 4, 4)).reshape(-1, 4, 4)
    gap, steps = np.zeros(len(q)), np.zeros(len(q), dtype=np.intp)
    for leg, part in zip(mechanism.legs, mechanism.parts, strict=True):
        q[:, part], missed, taken = _of_one_leg(leg, goals, q[:, part], mechanism.size, most)
        gap, steps = np.maximum(gap, missed), np.maximum(steps, taken)
    return _shape(q, goals, np.asarray(gap <= FEASIBLE), gap, steps, shape)


def _of_one_leg(leg: Leg, goals: Floats, q: Floats, size: float, most: int) -> tuple[Floats, Floats, Integers]:
    scale, moving = _scale(size, 1), np.arange(len(q))
    q, damping = q.copy(), np.full(len(q), 1e-3)
    miss = scale * pose.space_error(leg.pose(q), goals)
    gap, taken = np.abs(miss).max(axis=1, initial=0.0), np.zeros(len(q), dtype=np.intp)
    moving = moving[gap > CLOSED]
    for _ in range(most):
        if not len(moving):
            break
        J = scale[:, None] * leg.jacobian(q[moving])
        normal = np.swapaxes(J, 1, 2) @ J
        regular: Floats = normal + damping[moving][:, None, None] * np.eye(leg.n)
        downhill: Floats = np.einsum("kji,kj->ki", J, miss[moving])
        step = np.asarray(np.linalg.solve(regular, downhill[..., None])[..., 0], dtype=np.float64)
        trial = q[moving] + _shorten(step)
        after = scale * pose.space_error(leg.pose(trial), goals[moving])
        better = np.linalg.norm(after, axis=1) < np.linalg.norm(miss[moving], axis=1)
        kept = moving[better]
        q[kept], miss[kept] = trial[better], after[better]
        damping[moving] = np.where(better, np.maximum(damping[moving] / 20, LEAST_DAMPING), damping[moving] * 10)
        taken[moving] += 1
        gap = np.abs(miss).max(axis=1)
        moving = np.arange(len(q))[(gap > CLOSED) & (damping < 1e8)]
    return q, gap, taken


def _scale(size: float, loops: int) -> Floats:
    return np.tile(np.concatenate([np.ones(3), np.full(3, 1 / size)]), loops)


def _shorten(step: Floats) -> Floats:
    longest = np.abs(step).max(axis=1, keepdims=True)
    with np.errstate(divide="ignore"):
        return step * np.minimum(1.0, LONGEST / longest)


def _shape(
    q: Floats, T: Floats, found: Booleans, gap: Floats, steps: Integers, shape: tuple[int, ...]
) -> LegConfigurations:
    return LegConfigurations(
        q.reshape(*shape, -1), T.reshape(*shape, 4, 4), found.reshape(shape), gap.reshape(shape), steps.reshape(shape)
    )


class LegSearchStatus(Status):
    """Whether a search found anything."""

    FOUND = ("parallel.search_found", True)
    NOT_FOUND = ("parallel.search_not_found", False)


@dataclass(frozen=True, eq=False, repr=False)
class LegModes(Answer, data="T q met starts", entries="T"):
    """Poses of a platform on legs that a search found; true if there are any, iterable over the poses.

    Attributes:
        T: (k, 4, 4) poses that differ, in the order of how often they were met.
        q: (k, n) coordinates of all joints of each, one of those where a joint is idle.
        met: (k,) how many starts ended there.
        starts: number of starts.
    """

    T: Floats
    q: Floats
    met: Integers
    starts: int

    @property
    def status(self) -> LegSearchStatus:
        """Found or not."""
        return LegSearchStatus.FOUND if len(self.T) else LegSearchStatus.NOT_FOUND

    def explain(self, language: str | None = None) -> str:
        """How many were found, and how often the rarest."""
        return self.status.sentence(
            language, count=len(self), starts=self.starts, rarest=int(self.met.min(initial=self.starts))
        )


@dataclass(frozen=True, eq=False, repr=False)
class LegBranches(Answer, data="branches met free starts", entries="branches"):
    """Branches of every leg for one pose of the platform; true if every leg has one, iterable over the legs.

    Attributes:
        branches: for each leg (k_i, n_i) coordinates that differ [rad | m]; turns in (-pi, pi].
        met: for each leg (k_i,) how many starts ended there.
        free: for each leg how many freedoms it keeps with the platform held: more than zero, it has curves of
            solutions, of which one is given.
        starts: number of starts.
    """

    branches: tuple[Floats, ...]
    met: tuple[Integers, ...]
    free: tuple[int, ...]
    starts: int

    @property
    def count(self) -> int:
        """Configurations of the whole mechanism: the product of the branches of its legs."""
        return prod(len(each) for each in self.branches)

    @property
    def status(self) -> LegSearchStatus:
        """Found for every leg or not."""
        return LegSearchStatus.FOUND if self.count else LegSearchStatus.NOT_FOUND

    def explain(self, language: str | None = None) -> str:
        """How many configurations there are, and how often the rarest branch of a leg was met."""
        rarest = min((int(each.min(initial=self.starts)) for each in self.met), default=0)
        return self.status.sentence(language, count=self.count, starts=self.starts, rarest=rarest)


def leg_assembly_modes(mechanism: LegMechanism, q_driven: ArrayLike, starts: int = 200, seed: int = 0) -> LegModes:
    """Poses of the platform for one row of driven coordinates (a,) that Newton's method finds from random starts.

    Args:
        mechanism: legs and driven joints.
        q_driven: (a,) of the driven joints [rad | m].
        starts: number of starts: turns all around, slides up to the size of the mechanism.
        seed: of the starts.
    """
    driven, count = single("q_driven", q_driven, (len(mechanism.driven),)), whole("starts", starts, 1, 100_000)
    found = leg_forward(mechanism, driven, _starts(mechanism, count, seed))
    q, T = found.q[found.found], found.T[found.found]
    scale = np.ones((4, 4))
    scale[:3, 3] = 1 / mechanism.size
    groups = _groups((T * scale).reshape(-1, 16))
    first = [group[0] for group in groups]
    q = q[first]
    q[:, _turns(mechanism)] = wrap_angle(q[:, _turns(mechanism)])
    return LegModes(T[first], q, np.array([len(group) for group in groups], dtype=np.intp), count)


def leg_branches(mechanism: LegMechanism, T: ArrayLike, starts: int = 100, seed: int = 0) -> LegBranches:
    """All coordinates of every leg for one pose of the platform (4, 4) that a search from random starts finds.

    Args:
        mechanism: its legs.
        T: the pose.
        starts: number of starts.
        seed: of the starts.
    """
    goal, count = pose.check(single("T", T, (4, 4))), whole("starts", starts, 1, 100_000)
    begin, turns = _starts(mechanism, count, seed), _turns(mechanism)
    branches: list[Floats] = []
    met: list[Integers] = []
    free: list[int] = []
    for leg, part in zip(mechanism.legs, mechanism.parts, strict=True):
        own = LegMechanism((leg, leg), (0,))
        found = leg_inverse(own, goal, np.tile(begin[:, part], 2))
        q = found.q[found.found, : leg.n]
        q[:, turns[part]] = wrap_angle(q[:, turns[part]])
        rank = min((numerical_rank(leg.jacobian(each)) for each in q), default=0)
        free.append(leg.n - rank if len(q) else 0)
        units = np.where(turns[part], 1.0, mechanism.size)
        around = np.concatenate([np.cos(q[:, turns[part]]), np.sin(q[:, turns[part]])], axis=1)
        groups = _groups(np.concatenate([around, (q / units)[:, ~turns[part]]], axis=1))
        groups = groups[:1] if free[-1] else groups
        branches.append(q[[group[0] for group in groups]])
        met.append(np.array([len(group) for group in groups], dtype=np.intp))
    return LegBranches(tuple(branches), tuple(met), tuple(free), count)


def _turns(mechanism: LegMechanism) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """(n,) whether a coordinate is an angle."""
    turns = [np.linalg.norm(leg.screws[:, :3], axis=1) > 0 for leg in mechanism.legs]
    return np.asarray(np.concatenate(turns), dtype=np.bool_)


def _starts(mechanism: LegMechanism, count: int, seed: int) -> Floats:
    """(count, n) random coordinates, the first where the legs are drawn."""
    begin = np.random.default_rng(seed).uniform(-1, 1, (count, mechanism.n))
    begin *= np.where(_turns(mechanism), np.pi, mechanism.size)
    begin[0] = 0.0
    return begin


def _groups(x: Floats) -> list[list[int]]:
    """Rows that are the same, the largest groups first."""
    groups: list[list[int]] = []
    for k, row in enumerate(x):
        for group in groups:
            if float(np.abs(row - x[group[0]]).max(initial=0.0)) < SAME:
                group.append(k)
                break
        else:
            groups.append([k])
    return sorted(groups, key=len, reverse=True)
