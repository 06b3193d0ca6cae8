"""Is the origin strictly inside a convex set of wrenches? One linear program; for round cones a few.

From a point c inside the hull of the columns, how far beyond the origin does the hull reach?

  max lambda  with  W x = -lambda c,  sum x = 1,  x >= 0

lambda > 0 proves closure by finitely many wrenches. The multipliers z (c . z = -1) bound lambda from above by the
support function h(z) of the whole set: h(z) < 0 proves that there is none, and y = -z is the certificate. Where the
bounds disagree, the support points along z are the next columns.

What finitely many wrenches cannot say of round friction cones is asked of the support function: a contact with unit
push gives the wrenches B (1, mu d, tau), |d| <= 1, |tau| <= gamma; in the direction y they reach

  h(y) = g_n + mu |g_t| + gamma |g_tau|,  g = B' y
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, frozen
from mafsil.errors import MafsilError
from mafsil.grasp import loops
from mafsil.grasp.contact import Contact
from mafsil.grasp.tolerances import SOLVER
from mafsil.solvers.linear_program import minimise


def furthest(contact: Contact, g: Floats) -> Floats:
    """Contact force with unit push, in components of the contact's basis, that goes furthest along g.

    Args:
        contact: where.
        g: (k,) direction in the same components.
    """
    best = np.zeros(len(g))
    best[0] = 1.0
    d = contact.dimension
    if contact.mu > 0 and (size := float(np.linalg.norm(g[1:d]))) > 0:
        best[1:d] = contact.mu * g[1:d] / size
    if contact.model == "soft":
        best[3] = contact.gamma * (1.0 if g[3] >= 0 else -1.0)
    return best


@dataclass(frozen=True, eq=False)
class ConeWrenches:
    """Wrenches of unit push at each contact, a disc (in the plane a segment) for each.

    Their hull is what total push 1 can give.

    Attributes:
        discs: (contacts, 4, m) centre, two friction directions, torsion; as in `solvers.hull_growth_loops`.
    """

    discs: Floats

    @staticmethod
    def of(contacts: Sequence[Contact], transform: Floats) -> ConeWrenches:
        """The set of some contacts.

        Args:
            contacts: of the grasp.
            transform: (m, m) applied to the wrenches: change of frame and units.
        """
        found = np.empty((len(contacts), 4, len(transform)))
        points, normals = np.array([c.point for c in contacts]), np.array([c.normal for c in contacts])
        coefficients = np.array([(c.mu, c.gamma) for c in contacts])
        loops.disc_loops.contact_discs(points, normals, coefficients, np.ascontiguousarray(transform), found)
        return ConeWrenches(found)

    def rim(self, edges: int) -> Floats:
        """(m, contacts edges) points on the rims of the discs, torsion to and fro in turn.

        Args:
            edges: points of each disc.
        """
        columns = np.empty((self.discs.shape[2], len(self.discs) * edges))
        loops.disc_loops.rim_columns(self.discs, edges, columns)
        return columns

    def transform(self, M: Floats) -> ConeWrenches:
        """The set in other coordinates.

        Args:
            M: (m, m) applied to the wrenches.
        """
        return ConeWrenches(self.discs @ M.T)

    def furthest(self, u: Floats) -> tuple[float, Floats]:
        """h(u) = max u . w over the set, and the wrench of each contact that goes furthest.

        Args:
            u: (m,) direction.

        Returns:
            h(u), wrenches (m, contacts).
        """
        along = self.discs @ u
        size = np.hypot(along[:, 1], along[:, 2])
        weight = np.ones_like(along)
        weight[:, 1:3] = along[:, 1:3] / np.where(size > 0, size, 1.0)[:, None]
        weight[:, 3] = np.where(along[:, 3] >= 0, 1.0, -1.0)
        points = np.einsum("kp,kpm->mk", weight, self.discs)
        return float((u @ points).max()), points


def has_round_cones(contacts: Sequence[Contact]) -> bool:
    """Whether some cone is not spanned by finitely many edges."""
    return any(contact.dimension == 3 and contact.mu > 0 for contact in contacts)


ROUNDS = 100
ANSWER = {1: True, 0: False, -1: None}
"""Meaning of the verdicts of `solvers.positive_span_loops`."""


@cache
def positive_weights(n: int) -> Floats:
    """(n,) reproducible weights in general position, about 1 each; read-only."""
    return frozen(np.random.default_rng(1986).uniform(0.5, 1.5, n))


@dataclass(frozen=True, eq=False)
class Enclosure:
    """What the programs proved.

    Attributes:
        lower, upper: bounds of lambda.
        columns: (m, n) wrenches used.
        combination: (n,) x > 0 with columns x = 0, if lower > 0; else the last x >= 0.
        certificate: (m,) y with y . w >= -upper for every wrench w of unit push.
        rounds: linear programs solved.
    """

    lower: float
    upper: float
    columns: Floats
    combination: Floats
    certificate: Floats
    rounds: int

    @property
    def decided(self) -> bool:
        """Whether the sign of lambda is certain."""
        return self.lower > SOLVER or self.upper < -SOLVER


def enclose(W: Floats, cones: ConeWrenches | None = None) -> Enclosure:
    """Bounds of lambda that decide its sign, or place it within SOLVER of zero.

    Args:
        W: (m, n) columns of rank m, of comparable size.
        cones: the set of which the columns are some; the columns are all if None.

    Raises:
        MafsilError: the bounds did not meet.
    """
    weights = positive_weights(W.shape[1])
    weights = weights / weights.sum()
    c = W @ weights  # the point inside from which the program looks
    grown = W
    upper, lower = np.inf, -np.inf
    for rounds in range(1, ROUNDS + 1):
        x, lower, z = _shoot(grown, c)
        if cones is None:
            upper, fresh = lower, grown[:, :0]
        else:
            upper, fresh = cones.furthest(z)
        found = Enclosure(lower, upper, grown, x, -z, rounds)
        if found.decided or upper - lower <= SOLVER:
            return _strict(found, weights)
        grown = np.hstack([grown, fresh])
    raise MafsilError("solvers.budget_spent", iterations=ROUNDS, residual=upper - lower)


@dataclass(frozen=True, eq=False)
class SimplexVerdict:
    """What the compiled program says.

    Attributes:
        closed: whether the origin is strictly inside; None in doubt.
        columns: (m, n) wrenches used.
        x: (n,) > 0 with columns x = 0 and sum 1, if closed.
        y: (m,) of length 1 with y . w >= 0 for every wrench, if not.
    """

    closed: bool | None
    columns: Floats
    x: Floats
    y: Floats


def positive_combination(W: Floats, cones: ConeWrenches | None = None) -> SimplexVerdict:
    """The verdict of the compiled program, a few microseconds; near the boundary it doubts.

    Args:
        W: (m, n) columns of any size, n > m.
        cones: the set of which the columns are some; the columns are all if None.
    """
    program, y = loops.positive_span_loops, np.empty(len(W))
    m: int = W.shape[0]
    n: int = W.shape[1]
    weights = positive_weights(n)
    if cones is None:
        x = np.empty(n)
        verdict = program.positive_span((0,) * m, np.ascontiguousarray(W), weights, SOLVER, x, y)
        return SimplexVerdict(ANSWER[verdict], W, x, y)
    more = np.empty((m, len(cones.discs) * program.ROUNDS))
    x = np.empty(n + more.shape[1])
    verdict, count = program.positive_span_of_discs((0,) * m, cones.discs, W, more, weights, SOLVER, x, y)
    columns = np.hstack([W, more[:, : count - n]])
    used: NDArray[np.intp] = np.flatnonzero(x[:count] > 0) if verdict == program.SPANS else np.arange(n)
    return SimplexVerdict(ANSWER[verdict], columns[:, used], x[used], y)


def _shoot(W: Floats, c: Floats) -> tuple[Floats, float, Floats]:
    """x, lambda and the multipliers z of one program."""
    m, n = W.shape
    A = np.vstack([np.column_stack([W, c]), np.append(np.ones(n), 0.0)])
    b = np.append(np.zeros(m), 1.0)
    best = minimise(np.append(np.zeros(n), -1.0), A, b, free=1)
    assert best is not None, "x = the weights of c and lambda = -1 is a solution"
    return best.x[:n], float(best.x[n]), best.equality[:m]


def _strict(found: Enclosure, weights: Floats) -> Enclosure:
    """W x = -lambda W w, so x + lambda w is positive and combines to zero; unused later columns go."""
    if found.lower <= 0:
        return found
    x = found.combination.copy()
    x[: len(weights)] += found.lower * weights
    used = (x > 0) | (np.arange(len(x)) < len(weights))
    x = x[used] / x[used].sum()
    return Enclosure(found.lower, found.upper, found.columns[:, used], x, found.certificate, found.rounds)
