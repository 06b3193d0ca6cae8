"""The cheapest tolerances for a wanted accuracy: a convex problem, with its dual as certificate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, sqrt
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, as_batch, positive
from mafsil.design.accuracy import Causes, Tolerances, for_frames
from mafsil.design.arm import ArmDesign
from mafsil.design.family import ArmNumbers
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.model.loading import RobotLike

CLOSED = 1e-6
"""Share of the cost by which the least one may lie below it."""
FELT = 1e-12
"""Share of the largest variance below which a cause does not move the tool."""
EXACT = Tolerances()


class AllocationStatus(Status):
    """Whether tolerances for the wanted accuracy were found."""

    ALLOCATED = ("design.allocated", True)
    NO_ROOM = ("design.no_room", False)
    NOT_PROVED = ("design.allocation_not_proved", False)


@dataclass(frozen=True, eq=False, repr=False)
class Allocation(Answer, data="tolerances cost bound rms wanted fixed"):
    """The cheapest tolerances with which the tool is as accurate as wanted; true if their cost is proved least.

    Attributes:
        status: allocated, no room left by fixed causes, or not proved.
        tolerances: by `kind joint`, in the unit of each.
        cost: their cost, the sum of c / t.
        bound: below which no tolerances cost, by the dual problem.
        rms: (poses,) of the tool with them [m].
        wanted: allowed rms [m].
        fixed: largest rms of the causes that were not free [m].
    """

    status: AllocationStatus
    tolerances: dict[str, float]
    cost: float
    bound: float
    rms: Floats
    wanted: float
    fixed: float

    def explain(self, language: str | None = None) -> str:
        """Whether there are such tolerances, and each of them."""
        details = {"wanted": 1e3 * self.wanted, "fixed": 1e3 * self.fixed, "cost": self.cost, "bound": self.bound}
        lines = [self.status.sentence(language, **details)]
        return "\n".join([*lines, *(f"  {name}: {value:.4g}" for name, value in self.tolerances.items())])


def allocate(
    robot: RobotLike | ArmDesign,
    q: ArrayLike,
    wanted: float,
    costs: Mapping[str, ArrayLike],
    *,
    fixed: Tolerances = EXACT,
) -> Allocation:
    """The cheapest tolerances for a wanted accuracy at some configurations: minimise sum c / t, convex.

    The Lagrangian is least at t_k^3 = c_k / (2 sum_p lambda_p a_pk), a_pk the variance at pose p for t_k = 1; its
    dual is concave in lambda >= 0. At one pose this is the closed form t_k proportional to (c_k / a_k)^(1/3).

    Args:
        robot: the arm.
        q: (*batch, n) configurations at which the tool shall be accurate [rad | m].
        wanted: allowed root mean square of the tool's distance from where it should be [m].
        costs: of one over the tolerance, by kind (`encoder`, `backlash`, `zero`, `length`, `angle`); one number, or one
            for each joint; kinds without a cost are taken from `fixed`.
        fixed: tolerances that stay.

    Raises:
        InputError: an unknown kind, no cost at all, numbers out of range.
    """
    design = ArmDesign.of(robot)
    arm, wanted = design.robot, positive("wanted", wanted)
    kinds = ("encoder", "backlash", "zero", "length", "angle")
    if not isinstance(cast("object", costs), Mapping) or not costs or set(costs) - set(kinds):
        raise InputError("input.choice", name="costs", value=", ".join(map(str, costs)), known=", ".join(kinds))
    numbers, poses = ArmNumbers.of(arm), as_batch("q", q, (arm.n,), finite=True).reshape(-1, arm.n)
    own = replace(fixed, **dict.fromkeys(costs, 0.0))
    unit = Tolerances(**dict.fromkeys(costs, 1.0))
    spent = np.array([_variance(Causes.of(numbers, arm.joint_names, own, design), u).sum() for u in poses])
    causes = Causes.of(numbers, arm.joint_names, unit, design)
    joined = [" ".join(label.split()[:2]) for label in causes.labels]
    names = list(dict.fromkeys(joined))
    A = np.zeros((len(poses), len(names)))
    for p, u in enumerate(poses):
        np.add.at(A[p], [names.index(name) for name in joined], _variance(causes, u))
    c = np.array([_cost(costs, name, arm.joint_names) for name in names])
    room, most = wanted**2 - spent, sqrt(float(spent.max()))
    if (room <= 0.0).any():
        return Allocation(AllocationStatus.NO_ROOM, {}, inf, inf, np.sqrt(spent), wanted, most)
    felt = A.max(axis=0) > FELT * A.max()
    # In units in which numbers near one meet.
    size = float(np.sqrt(room / A[:, felt].mean(axis=1)).min())
    unit_cost = float(c[felt].mean())
    t, bound = _cheapest(A[:, felt] * (size**2 / room[:, None]), c[felt] / unit_cost)
    t, bound = t * size, bound * unit_cost / size
    cost = float((c[felt] / t).sum())
    proved = cost - bound <= CLOSED * cost
    found = dict(zip([name for name, one in zip(names, felt, strict=True) if one], t.tolist(), strict=True))
    rms = np.sqrt(spent + A[:, felt] @ t**2)
    status = AllocationStatus.ALLOCATED if proved else AllocationStatus.NOT_PROVED
    return Allocation(status, found, cost, bound, rms, wanted, most)


def _cheapest(A: Floats, c: Floats) -> tuple[Floats, float]:
    """Minimise sum c / t with A t^2 <= 1: tolerances that satisfy it, and a lower bound of the cost."""

    def least(weights: Floats) -> Floats:
        return np.cbrt(c / (2.0 * np.maximum(weights @ A, LEAST_DIVISOR)))

    def dual(log_weights: Floats) -> tuple[float, Floats]:
        weights = np.exp(log_weights)
        t = least(weights)
        return -float((c / t).sum() + weights @ (A @ t**2 - 1.0)), -(A @ t**2 - 1.0) * weights

    start = np.full(len(A), np.log(_one_pose(A.mean(axis=0), c) / len(A)))
    options = {"maxiter": 10_000, "ftol": 1e-15, "gtol": 1e-12}
    found: Any = minimize(dual, start, jac=True, method="L-BFGS-B", options=options)
    t = least(np.exp(found.x))
    return t / sqrt(float((A @ t**2).max())), -float(found.fun)


def _one_pose(a: Floats, c: Floats) -> float:
    """The multiplier of a single pose: sum a t^2 = 1 with t = (c / (2 lambda a))^(1/3)."""
    return 0.5 * float(np.cbrt(a * c**2).sum()) ** 1.5


def _variance(causes: Causes, q: JointVector) -> Floats:
    """(k,) variance of the position that each cause adds [m^2]."""
    nominal, _ = causes.numbers.pose_and_jacobian(q)
    return np.asarray((causes.columns(q, nominal)[3:] ** 2).sum(axis=0))


def _cost(costs: Mapping[str, ArrayLike], name: str, joints: Sequence[str]) -> float:
    kind, _, place = name.partition(" ")
    values = for_frames(kind, costs[kind], len(joints))
    if np.size(costs[kind]) == len(joints) and place == "tool":
        values = np.append(values[:-1], values[:-1].max())
    return positive(f"costs.{kind}", values[(*joints, "tool").index(place)])
