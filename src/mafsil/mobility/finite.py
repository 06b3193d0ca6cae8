"""Finite mobility: how many of the first-order motions are beginnings of real ones, and what is proven of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import SingleAnswer, Status
from mafsil.arrays import Booleans, Floats, whole
from mafsil.mobility.instantaneous import InstantaneousMobility, at_state, instantaneous, null_space
from mafsil.mobility.linkage import Linkage
from mafsil.mobility.loop_closure import closed_beside, configuration, loop_state, reduced_screws, units
from mafsil.mobility.many import by_singular_values
from mafsil.mobility.on_linkage import on_linkage
from mafsil.mobility.redundancy import loop_groups
from mafsil.mobility.second_order import admitted, second_order_forms
from mafsil.mobility.tolerances import NEAR, PATH_STEP

MOST_DIRECTIONS = 48
SAME_BRANCH = 0.02
"""Tangents [radians between them] nearer than this belong to one branch: steps of PATH_STEP bend less."""


class FiniteStatus(Status):
    """What is known of the motions through a configuration, and how."""

    REGULAR = ("mobility.finite_regular", True)
    SMOOTH = ("mobility.finite_smooth", True)
    BRANCH_POINT = ("mobility.finite_branch_point", True)
    SHAKY = ("mobility.finite_shaky", True)
    RIGID = ("mobility.finite_rigid", False)
    RIGID_SECOND_ORDER = ("mobility.finite_rigid_second", False)
    NOT_FOUND = ("mobility.finite_not_found", False)


@dataclass(frozen=True, eq=False, repr=False)
class FiniteMobility(SingleAnswer):
    """Dimension of the set of configurations through one of them; true if it is known to move.

    Attributes:
        status: regular (proven by full rank), smooth (the rank stays around), branch point (several sets of
            configurations meet), shaky (more first-order motions than real ones), rigid (proven to first or second
            order), not found.
        mobility: largest dimension that was found.
        instantaneous: number of first-order motions.
        proven: whether `mobility` is a theorem here; else it is what a search found.
        branches: number of curves that meet, if all are curves; else 0.
        dimensions: those of the sets that were found, largest first.
        tangents: (k, F) directions along which motions were found, rates over `units`.
        theta: (k, F) configurations a small step along them [rad | m].
    """

    status: FiniteStatus
    mobility: int
    instantaneous: int
    proven: bool
    branches: int
    dimensions: tuple[int, ...]
    tangents: Floats
    theta: Floats

    def explain(self, language: str | None = None) -> str:
        """The finding in one sentence."""
        return self.status.sentence(
            language, mobility=self.mobility, instantaneous=self.instantaneous, branches=self.branches,
            looked=len(self.tangents), dimensions=", ".join(map(str, self.dimensions)) or "0",
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "status": self.status.name.lower(), "mobility": self.mobility, "instantaneous": self.instantaneous,
            "proven": self.proven, "branches": self.branches, "dimensions": list(self.dimensions),
        }  # fmt: skip


@on_linkage
def finite_mobility(linkage: Linkage, theta: ArrayLike | None = None, *, seed: int = 0) -> FiniteMobility:
    """How many independent motions a linkage really has around a configuration.

    1. No first-order motion: rigid, proven.
    2. Each loop stays in the group that its joints generate; if the rank is the sum of the dimensions of these groups
       and the number of couplings, the configurations are smooth around this one and their dimension is the number of
       first-order motions: proven.
    3. Forms of second order: if a combination is definite, this configuration is isolated: proven.
    4. Else steps along the motions that second order admits, closed again by Newton's method; those whose correction is
       small against the step are motions, and the rank there gives the dimension, tried by steps along all of it.

    Args:
        linkage: as drawn.
        theta: (F,) closed configuration [rad | m].
        seed: of the directions tried.

    Reference: A. Mueller, Local kinematic analysis of closed-loop linkages, Mechanism and Machine Theory 139 (2019).
    """
    linkage.require_all_joints()
    value = configuration(linkage, theta)
    state = loop_state(linkage, value)
    here = at_state(linkage, value, state, np.ones(linkage.coordinates))
    d, none = here.mobility, np.zeros((0, linkage.coordinates))
    if not d:  # 1
        return FiniteMobility(FiniteStatus.RIGID, 0, 0, True, 0, (), none, none)
    asked = sum(g.dimension for _, g in loop_groups(linkage, reduced_screws(linkage, state.screws)))
    if here.rank == asked + len(linkage.couplings):  # 2
        tangents = here.rates.T
        return FiniteMobility(
            FiniteStatus.REGULAR, d, d, True, 0, (d,), tangents, value + PATH_STEP * tangents * units(linkage)
        )
    second = second_order_forms(linkage, state, here.rates)  # 3
    if second.definite is not None:
        return FiniteMobility(FiniteStatus.RIGID_SECOND_ORDER, 0, d, True, 0, (), none, none)
    directions = admitted(second.forms, d, seed)[:MOST_DIRECTIONS] @ here.rates.T  # 4
    points, tangents = _steps(linkage, value, state.matrix, directions)
    if not len(points):
        return FiniteMobility(FiniteStatus.NOT_FOUND, 0, d, False, 0, (), none, none)
    found = tuple(sorted(set(_dimensions(linkage, points)), reverse=True))
    branches = _lines(tangents) if found == (1,) else 0
    largest = found[0]
    if largest == d and len(found) == 1 and branches <= 1:
        status = FiniteStatus.SMOOTH
    elif branches > 1 or len(found) > 1 or (len(second.forms) and _bends(tangents, largest)):
        status = FiniteStatus.BRANCH_POINT
    else:
        status = FiniteStatus.SHAKY
    return FiniteMobility(status, largest, d, False, branches, found, tangents, points)


def _steps(linkage: Linkage, theta: Floats, matrix: Floats, directions: Floats) -> tuple[Floats, Floats]:
    """Configurations (k, F) a small step along directions, and the tangents that were really gone."""
    if not len(directions):
        return np.zeros((0, len(theta))), np.zeros((0, len(theta)))
    end, gone, good = _gone(linkage, theta[None], matrix[None], directions[None], PATH_STEP)
    length = np.linalg.norm(gone, axis=-1, keepdims=True)
    return end[good], (gone / np.maximum(length, 1e-300))[good]


def _dimensions(linkage: Linkage, points: Floats) -> list[int]:
    """Dimension at points (k, F) of general position: the rank, cut down to directions along which steps close."""
    A = loop_state(linkage, points).matrix
    bases = [null_space(each)[1].T for each in A]
    found = [0] * len(points)
    for d in sorted({len(rates) for rates in bases} - {0}):
        alike = [k for k, rates in enumerate(bases) if len(rates) == d]
        good = _gone(linkage, points[alike], A[alike], np.stack([bases[k] for k in alike]), PATH_STEP / 16)[2]
        for k, count in zip(alike, good.sum(axis=1).tolist(), strict=True):
            found[k] = count
    return found


def _gone(
    linkage: Linkage, theta: Floats, matrix: Floats, directions: Floats, step: float
) -> tuple[Floats, Floats, Booleans]:
    """Where steps end, closed again (p, k, F), how far that is over `units`, and which went along their direction.

    Args:
        linkage: as drawn.
        theta: (p, F) configurations.
        matrix: (p, 6 L + K, F) of their loops.
        directions: (p, k, F) unit rates.
        step: length.
    """
    scale = units(linkage)
    closed = closed_beside(linkage, matrix, theta[:, None] + step * directions * scale)
    gone = (closed.theta - theta[:, None]) / scale
    correction = np.linalg.norm(gone - step * directions, axis=-1)
    return closed.theta, gone, np.asarray(closed.closed & (correction < NEAR * step))


def _lines(tangents: Floats) -> int:
    """Number of different lines among unit tangents."""
    lines: list[Floats] = []
    for tangent in tangents:
        if all(abs(float(tangent @ line)) < np.cos(SAME_BRANCH) for line in lines):
            lines.append(tangent)
    return len(lines)


def _bends(tangents: Floats, dimension: int) -> bool:
    """Whether the tangents span more than one set of that dimension has: several sets meet."""
    s = np.linalg.svd(tangents, compute_uv=False)
    return int((s > SAME_BRANCH * s[0]).sum()) > dimension


@on_linkage
def generic_mobility(
    linkage: Linkage, theta: ArrayLike | None = None, *, step: float = 0.05, samples: int = 12, seed: int = 0
) -> int | None:
    """Least mobility by rank at configurations found around one by steps and Newton's method; None if none closed.

    Args:
        linkage: as drawn.
        theta: (F,) closed configuration [rad | m].
        step: length of the steps [rad, sizes].
        samples: number of steps.
        seed: of their directions.
    """
    found = mobility_around(linkage, theta, step=step, samples=samples, seed=seed)
    return None if found is None else found.mobility


@on_linkage
def mobility_around(
    linkage: Linkage, theta: ArrayLike | None = None, *, step: float = 0.05, samples: int = 12, seed: int = 0
) -> InstantaneousMobility | None:
    """Mobility by rank where it is least around a configuration; there where nothing moves, None if nothing closed.

    Arguments as for `generic_mobility`.
    """
    value, count = configuration(linkage, theta), whole("samples", samples, 1, 100_000)
    state = loop_state(linkage, value)
    here = at_state(linkage, value, state, np.ones(linkage.coordinates))
    if not here.mobility:
        return here
    along = np.random.default_rng(seed).normal(size=(count, here.mobility)) @ here.rates.T
    along = along / np.linalg.norm(along, axis=1, keepdims=True)
    closed = closed_beside(linkage, state.matrix[None], (value + step * along * units(linkage))[None])
    around = closed.theta[closed.closed]
    if not len(around):
        return None
    return instantaneous(linkage, around[int(by_singular_values(linkage, around).argmin())])
