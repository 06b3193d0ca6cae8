"""All that a search finds: poses of a platform on legs for given motors, and branches of every leg for a given pose.

Newton's method from many random starts in one batch. What comes back several times is one answer; how often the rarest
was met says how much may have been missed. A search proves nothing about others.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import prod

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, Integers, single, whole
from mafsil.geometry import pose
from mafsil.mobility.spaces.planar_positions import wrap_angle
from mafsil.parallel.closure import numerical_rank
from mafsil.parallel.legs.leg_configurations import leg_forward, leg_inverse
from mafsil.parallel.legs.leg_mechanism import LegMechanism
from mafsil.parallel.tolerances import SAME


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
    turns = [np.linalg.norm(leg.screws[:3], axis=0) > 0 for leg in mechanism.legs]
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
