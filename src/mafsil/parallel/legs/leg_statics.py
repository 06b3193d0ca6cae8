"""Forces and rates in platforms on legs: efforts of the motors, wrench of every leg, reduced equations.

F is the wrench (m, f) in {s} that the motors are to exert through the platform on the world; a load F_load on the
platform at rest needs F = - F_load.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, single
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.parallel.closure import kernel
from mafsil.parallel.legs.leg_mechanism import LegMechanism
from mafsil.parallel.tolerances import FEASIBLE, POSSIBLE, RANK


class LegForcesStatus(Status):
    """Whether motors can exert a wrench."""

    UNIQUE = ("parallel.forces_unique", True)
    SHARED = ("parallel.forces_shared", True)
    IMPOSSIBLE = ("parallel.forces_impossible", False)


@dataclass(frozen=True, eq=False, repr=False)
class LegForces(Answer, data="efforts leg_wrenches residual"):
    """Efforts and forces of a platform on legs at rest; true if the motors can exert the wrench.

    Attributes:
        efforts: (a,) of the driven joints [N m | N].
        leg_wrenches: (m, 6) wrench of each leg on the platform, in {s}; their sum is F.
        residual: largest effort that the passive joints would need [N m | N]: zero if F can be exerted.
        unique: whether the efforts are the only ones; otherwise they are those of least norm.
    """

    efforts: Floats
    leg_wrenches: Floats
    residual: float
    unique: bool

    @property
    def possible(self) -> bool:
        """Whether the motors can exert the wrench: no passive joint has to carry an effort."""
        size = max(
            float(np.abs(self.efforts).max(initial=0.0)),
            float(np.abs(self.leg_wrenches).max(initial=0.0)),
            LEAST_DIVISOR,
        )
        return self.residual <= POSSIBLE * size

    @property
    def status(self) -> LegForcesStatus:
        """Exerted in one way, in many, or not at all."""
        if not self.possible:
            return LegForcesStatus.IMPOSSIBLE
        return LegForcesStatus.UNIQUE if self.unique else LegForcesStatus.SHARED

    def explain(self, language: str | None = None) -> str:
        """The status with the largest effort, or with what passive joints would have to carry."""
        largest = float(np.abs(self.efforts).max(initial=0.0))
        return self.status.sentence(language, largest=largest, residual=self.residual)


def leg_forces(mechanism: LegMechanism, q: ArrayLike, F: ArrayLike) -> LegForces:
    """Efforts of the driven joints and the wrench of every leg for a wrench F on the world.

    Leg i pushes the platform with F_i, sum F_i = F, and its joints carry tau_i = J_i' F_i; passive ones carry nothing.
    Solved together for all F_i, so that no multiplier has to be interpreted.

    Args:
        mechanism: legs and driven joints.
        q: (n,) coordinates that close the loops.
        F: (6,) wrench in {s}.
    """
    value, wrench = mechanism.require_closed(q), single("F", F, (6,))
    J = mechanism.leg_jacobians(value)
    m = len(J)
    rows: list[Floats] = []
    driven: list[Floats] = []
    for k in range(mechanism.n):
        leg = next(i for i, part in enumerate(mechanism.parts) if part.start <= k < part.stop)
        row = np.zeros(6 * m)
        row[6 * leg : 6 * leg + 6] = J[leg][:, k - mechanism.parts[leg].start]
        (driven if k in mechanism.driven else rows).append(row)
    order = sorted(mechanism.driven)
    sums = np.tile(np.eye(6), m)
    M = np.vstack([*rows, sums])
    right = np.concatenate([np.zeros(len(rows)), wrench])
    # Moments over the size, so that the least norm does not depend on units.
    units = np.tile(np.concatenate([np.full(3, mechanism.size), np.ones(3)]), m)
    found = units * np.linalg.lstsq(M * units, right, rcond=RANK)[0]
    efforts = {k: float(row @ found) for k, row in zip(order, driven, strict=True)}
    residual = float(np.abs(M @ found - right).max())
    free = kernel(M * units)
    unique = (
        not free.size or float(np.abs((np.array(driven) * units) @ free).max(initial=0.0)) < POSSIBLE * mechanism.size
    )
    return LegForces(np.array([efforts[k] for k in mechanism.driven]), found.reshape(m, 6), residual, unique)


class LegRatesStatus(Status):
    """Whether legs can follow a twist."""

    FEASIBLE = ("parallel.rates_feasible", True)
    NOT_FEASIBLE = ("parallel.rates_not_feasible", False)


@dataclass(frozen=True, eq=False, repr=False)
class LegRates(Answer, data="rates residual"):
    """Rates of all joints for a twist of the platform; true if every leg can follow it.

    Attributes:
        rates: (n,) of all joints, of least norm where a leg has idle freedoms.
        residual: (6,) twist that the legs cannot follow, the largest of all legs; zero if feasible.
        feasible: whether all legs can.
    """

    rates: Floats
    residual: Floats
    feasible: bool

    @property
    def status(self) -> LegRatesStatus:
        """Feasible or not."""
        return LegRatesStatus.FEASIBLE if self.feasible else LegRatesStatus.NOT_FEASIBLE

    def explain(self, language: str | None = None) -> str:
        """The status with what is left of the twist."""
        return self.status.sentence(
            language, turn=float(np.linalg.norm(self.residual[:3])), move=float(np.linalg.norm(self.residual[3:]))
        )


def inverse_rates(mechanism: LegMechanism, q: ArrayLike, V: ArrayLike) -> LegRates:
    """Rates of all joints for a twist V (6,) in {s}, leg by leg: q_i' = J_i^+ V; infeasible if some leg cannot follow.

    Args:
        mechanism: its legs.
        q: (n,) coordinates that close the loops.
        V: (6,) twist.
    """
    value, twist = mechanism.require_closed(q), single("V", V, (6,))
    scale = np.concatenate([np.ones(3), np.full(3, 1 / mechanism.size)])
    rates, left = np.zeros(mechanism.n), np.zeros(6)
    for part, J in zip(mechanism.parts, mechanism.leg_jacobians(value), strict=True):
        rates[part] = np.linalg.pinv(scale[:, None] * J, rcond=RANK) @ (scale * twist)
        missed = twist - J @ rates[part]
        left = max(left, missed, key=lambda each: float(np.abs(each * scale).max()))
    size = max(float(np.abs(twist * scale).max()), LEAST_DIVISOR)
    return LegRates(rates, left, float(np.abs(left * scale).max()) <= FEASIBLE * size)


def reduced_equations(mechanism: LegMechanism, q: ArrayLike) -> tuple[Floats, Floats]:
    """A (k, 6) and B (k, a) of A V = B q_a' without any passive joint: a few rows for each leg.

    Wrenches of leg i that its passive joints do not feel, N_i' J_passive = 0, give N_i' V = N_i' J_driven q_driven'.
    det A = 0 at actuator singularities; where A is square and regular, V = A^-1 B q_a'.

    Args:
        mechanism: legs and driven joints.
        q: (n,) coordinates that close the loops.
    """
    value = mechanism.require_closed(q)
    rows_A: list[Floats] = []
    rows_B: list[Floats] = []
    for part, J in zip(mechanism.parts, mechanism.leg_jacobians(value), strict=True):
        own = list(range(part.start, part.stop))
        passive = [k for k, name in enumerate(own) if name not in mechanism.driven]
        N = kernel(J[:, passive].T) if passive else np.eye(6)
        B = np.zeros((N.shape[1], len(mechanism.driven)))
        for column, name in enumerate(mechanism.driven):
            if name in own:
                B[:, column] = N.T @ J[:, own.index(name)]
        rows_A.append(N.T)
        rows_B.append(B)
    return np.vstack(rows_A), np.vstack(rows_B)
