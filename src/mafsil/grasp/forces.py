"""Contact forces against one load: the smallest squeeze, within the pushes and joint torques that a hand can give.

  min sum of pushes  with  G f = -wrench,  f in the true cones,  f_n <= push,  |J' f| <= torque

Round cones are second-order constraints. They are met by columns that grow: the multipliers of one linear program
price all forces of a cone in closed form, the best ones are the next columns, and the prices bound the optimum from
below, so that every answer knows its own gap.

Internal forces: sets of contact forces that squeeze a body without moving it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, as_batch, spread
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.grasp.contact import Contact
from mafsil.grasp.enclosure import furthest
from mafsil.grasp.tolerances import MULTIPLIER, OPTIMUM, RANK, ROUNDOFF, UNLOADED
from mafsil.solvers.linear_program import minimise

ROUNDS = 60
"""Linear programs at most; each adds the best force of every cone, and few are needed."""


class HoldStatus(Status):
    """Whether the load is held."""

    HOLDS = ("grasp.holds", True)
    DROPS = ("grasp.drops", False)


@dataclass(frozen=True, eq=False, repr=False)
class ContactForces(Answer, data="holds torques certificate"):
    """Forces that hold a load, or the proof that none do; true if it is held.

    Attributes:
        status: holds or drops.
        components: for each contact the components of its basis: push, tangential forces, torsion.
        forces: (contacts, d) forces on the body [N]; zero if it drops.
        total_push: sum of the normal forces [N].
        lower: no forces with a smaller sum exist.
        margins: (contacts,) distance of each force from the edge of its cone [N].
        torques: (joints,) of the hand that give the forces [N m], or None.
        residual: |G f + wrench| recomputed.
        certificate: (m,) y with y . w >= 0 for every wrench that the contacts can give and y . (-wrench) < 0, or None
            where limits of the hand (not the cones) are what fails.
        unbalanced: least part of the wrench that is left over if it drops [N m, N].
    """

    status: HoldStatus
    components: tuple[Floats, ...]
    forces: Floats
    total_push: float
    lower: float
    margins: Floats
    torques: Floats | None
    residual: float
    certificate: Floats | None
    unbalanced: float

    def moments(self, points: ArrayLike) -> Floats:
        """Moments of the contact forces about the origin [N m]: (contacts,) in the plane, (contacts, 3) in space.

        Args:
            points: (contacts, d) of the contacts [m].
        """
        at = as_batch("points", points, self.forces.shape, finite=True)
        if self.forces.shape[1] == 2:
            return at[:, 0] * self.forces[:, 1] - at[:, 1] * self.forces[:, 0]
        return np.cross(at, self.forces)

    @property
    def holds(self) -> bool:
        """Whether the load is held."""
        return self.status is HoldStatus.HOLDS

    def explain(self, language: str | None = None) -> str:
        """The answer in one sentence."""
        return self.status.sentence(language, push=self.total_push, unbalanced=self.unbalanced)

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return Answer.to_dict(self) | {
            "forces": self.forces if self.holds else None,
            "total_push": self.total_push if self.holds else None,
        }


def resist(
    contacts: Sequence[Contact],
    wrench: ArrayLike,
    *,
    push: float | ArrayLike | None = None,
    jacobian: ArrayLike | None = None,
    torque: ArrayLike | None = None,
) -> ContactForces:
    """Smallest contact forces that balance an external wrench.

    1. An elastic program finds the least part of the wrench that no forces balance; if there is one, it drops.
    2. Else the program of least total push starts from the columns of the first.
    3. In both, the multipliers price the forces of every cone; the best ones join until none improves the optimum.

    Args:
        contacts: of the grasp.
        wrench: (m,) external (m, f) on the body [N m, N].
        push: greatest normal force of each contact [N], one number or (contacts,); unlimited if None.
        jacobian: (joints, contacts d) map from contact forces on the body (in its frame) to the joint torques that
            give them: the transposed Jacobian of the hand. None for no hand.
        torque: (joints,) greatest absolute torques [N m], with `jacobian`.

    Raises:
        InputError: shapes do not fit, or a jacobian without torques.
    """
    program = _Program(contacts, wrench, push, jacobian, torque)
    nearest = program.solve(elastic=True)  # 1
    if nearest.value > UNLOADED * max(float(np.abs(program.b).max()), LEAST_DIVISOR):
        return program.refusal(nearest)
    return program.answer(program.solve(elastic=False, start=nearest.columns))  # 2


@dataclass(frozen=True, eq=False)
class _Solved:
    value: float
    lower: float
    x: Floats
    columns: list[tuple[int, Floats]]
    prices: Floats
    limit_prices: Floats


class _Program:
    """Columns (contact, force of unit push), grown until no force of any cone improves the optimum; loads of size 1."""

    def __init__(self, contacts: Sequence[Contact], wrench: ArrayLike, push: Any, jacobian: Any, torque: Any) -> None:
        if not len(contacts):
            raise InputError("grasp.no_contacts")
        self.contacts = contacts
        self.m = len(contacts[0].basis)
        load = as_batch("wrench", wrench, (self.m,), finite=True)
        if load.ndim != 1:
            raise InputError("input.shape", name="wrench", expected=(self.m,), got=load.shape, hint="")
        self.scale = float(np.abs(load).max()) or 1.0
        self.b = -load / self.scale
        d = contacts[0].dimension
        self.to_force = [_force_map(c) for c in contacts]
        bounds: list[float] = []
        if push is not None:
            each = spread("push", push, (len(contacts),))
            if (each < 0.0).any():
                raise InputError("input.range", name="push", value=float(each.min()), low=0.0, high=np.inf)
            bounds.extend(float(v) for v in each)
        self.pushes = len(bounds)
        self.J: Floats | None = None
        if jacobian is not None or torque is not None:
            if jacobian is None or torque is None:
                raise InputError("grasp.hand_incomplete")
            most = np.atleast_1d(as_batch("torque", torque, (), finite=True))
            self.J = as_batch("jacobian", jacobian, (len(most), len(contacts) * d), finite=True)
            bounds.extend([*most, *most])
        self.h = np.array(bounds) / self.scale
        self.maps = [self._limit_map(i, d) for i in range(len(contacts))]

    def _limit_map(self, i: int, d: int) -> Floats:
        """(limits, k) components of contact i to what the limits bound."""
        k = self.contacts[i].basis.shape[1]
        rows = np.zeros((self.pushes, k))
        if self.pushes:
            rows[i, 0] = 1.0
        if self.J is None:
            return rows
        effort = self.J[:, i * d : (i + 1) * d] @ self.to_force[i]
        return np.vstack([rows, effort, -effort])

    def solve(self, *, elastic: bool, start: list[tuple[int, Floats]] | None = None) -> _Solved:
        """The least total push, or (elastic) the least sum of what is left of the wrench."""
        columns = start or [(i, e) for i, c in enumerate(self.contacts) for e in c.edges(8)]
        best_lower = -np.inf
        rounds = 0
        while True:
            found = self._program(columns, elastic)
            fresh, worst = self._price(found, elastic)  # 3
            bound = found.value if not fresh else self._lower(found, elastic, worst)
            best_lower = max(best_lower, bound)
            solved = _Solved(found.value, best_lower, found.x, columns, found.prices, found.limit_prices)
            rounds += 1
            if not fresh or rounds == ROUNDS or found.value - best_lower <= OPTIMUM * max(ROUNDOFF, abs(found.value)):
                return solved
            columns = columns + fresh

    def _program(self, columns: list[tuple[int, Floats]], elastic: bool) -> _Solved:
        W = np.column_stack([self.contacts[i].basis @ e for i, e in columns])
        G = np.column_stack([self.maps[i] @ e for i, e in columns]) if len(self.h) else None
        costs = np.zeros(len(columns)) if elastic else np.ones(len(columns))
        if elastic:
            W = np.hstack([W, np.eye(self.m), -np.eye(self.m)])
            costs = np.append(costs, np.ones(2 * self.m))
            G = None if G is None else np.hstack([G, np.zeros((len(self.h), 2 * self.m))])
        best = minimise(costs, W, self.b, G, self.h if G is not None else None)
        assert best is not None, "the first program has slack, the second starts from its columns"
        limits = best.inequality if len(self.h) else np.zeros(0)
        return _Solved(best.value, -np.inf, best.x[: len(columns)], columns, best.equality, limits)

    def _price(self, found: _Solved, elastic: bool) -> tuple[list[tuple[int, Floats]], float]:
        """Forces whose reduced cost is negative, and the greatest price of any."""
        cost = 0.0 if elastic else 1.0
        fresh: list[tuple[int, Floats]] = []
        worst = cost
        for i, contact in enumerate(self.contacts):
            g = contact.basis.T @ found.prices + self.maps[i].T @ found.limit_prices
            e = furthest(contact, g)
            price = float(g @ e)
            worst = max(worst, price)
            if price > cost + MULTIPLIER:
                fresh.append((i, e))
        return fresh, worst

    def _lower(self, found: _Solved, elastic: bool, worst: float) -> float:
        """Prices scaled down until no force is too cheap are feasible for the dual: a lower bound."""
        if elastic or worst <= 0:
            return -np.inf
        return float(found.prices @ self.b + (found.limit_prices @ self.h if len(self.h) else 0.0)) / worst

    def answer(self, solved: _Solved) -> ContactForces:
        components = [np.zeros(c.basis.shape[1]) for c in self.contacts]
        for x, (i, e) in zip(solved.x, solved.columns, strict=True):
            components[i] = components[i] + x * self.scale * e
        forces = np.array([T @ f for T, f in zip(self.to_force, components, strict=True)])
        reached = np.sum([c.basis @ f for c, f in zip(self.contacts, components, strict=True)], axis=0)
        return ContactForces(
            HoldStatus.HOLDS,
            tuple(components),
            forces,
            float(sum(f[0] for f in components)),
            solved.lower * self.scale,
            np.array([c.margin(f) for c, f in zip(self.contacts, components, strict=True)]),
            None if self.J is None else self.J @ forces.ravel(),
            float(np.linalg.norm(reached / self.scale - self.b)) * self.scale,
            None,
            0.0,
        )

    def refusal(self, nearest: _Solved) -> ContactForces:
        d = self.contacts[0].dimension
        by_limits = bool(len(self.h)) and bool(np.abs(nearest.limit_prices).max() > MULTIPLIER)
        return ContactForces(
            HoldStatus.DROPS,
            tuple(np.zeros(c.basis.shape[1]) for c in self.contacts),
            np.zeros((len(self.contacts), d)),
            np.inf,
            np.inf,
            np.zeros(len(self.contacts)),
            None,
            float(np.linalg.norm(self.b)) * self.scale,
            None if by_limits else -nearest.prices,
            nearest.value * self.scale,
        )


def _force_map(contact: Contact) -> Floats:
    """(d, k) components of a contact's basis to its force."""
    d = contact.dimension
    return contact.basis[-d:]


def internal_basis(contacts: Sequence[Contact]) -> Floats:
    """(q, contacts, d) basis of the forces at the contact points whose resultant force and moment are zero.

    For three points that are not on a line one member for each side: equal and opposite forces along it (q = 3). For
    others an orthonormal basis of the null space of the grasp map.

    Args:
        contacts: at least one; only their points matter.
    """
    points = np.array([c.point for c in contacts])
    n, d = points.shape
    resultant = _resultant(points)
    _, s, Vt = np.linalg.svd(resultant)
    rank = int((s > RANK * s[0]).sum())
    if n == 3 and n * d - rank == 3:
        basis = np.zeros((3, n, d))
        for row, (i, j) in enumerate(((0, 1), (1, 2), (2, 0))):
            u = (points[j] - points[i]) / np.linalg.norm(points[j] - points[i])
            basis[row, i], basis[row, j] = u, -u
        return basis
    return Vt[rank:].reshape(-1, n, d)


def split_forces(contacts: Sequence[Contact], forces: ArrayLike) -> tuple[Floats, Floats]:
    """Forces as the part of least norm with the same resultant, and the internal part.

    Args:
        contacts: of the grasp.
        forces: (contacts, d) [N].

    Returns:
        Two arrays (contacts, d) whose sum is `forces`.
    """
    points = np.array([c.point for c in contacts])
    given = as_batch("forces", forces, points.shape, finite=True)
    resultant = _resultant(points)
    external = (np.linalg.pinv(resultant, rcond=RANK) @ (resultant @ given.ravel())).reshape(points.shape)
    return external, given - external


def _resultant(points: Floats) -> Floats:
    """(m, n d) forces at the points to their resultant, moments about the middle and divided by the spread."""
    d = points.shape[1]
    arms = points - points.mean(axis=0)
    arms = arms / (float(np.linalg.norm(arms, axis=1).max()) or 1.0)
    blocks: list[Floats] = []
    for r in arms:
        turn = np.array([[-r[1], r[0]]]) if d == 2 else np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
        blocks.append(np.vstack([turn, np.eye(d)]))
    return np.hstack(blocks)
