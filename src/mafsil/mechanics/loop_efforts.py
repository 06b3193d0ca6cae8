"""Efforts of driven joints of a closed chain, as expressions of fixed size: for a motion, and to hold it up.

Motions that the loops allow feel only efforts, no forces of the loops. With P the orthogonal projection on them and S
the columns of the driven joints, efforts tau do what is needed, w, if P S tau = P w:

1. K = S' P S and b = S' P w, of a driven joints and d freedoms.
2. a <= d: tau = K^-1 b. a > d: the d equations `deciding` say it all, the shortest tau = K_T' (K_T K_T')^-1 b_T.
3. The rest w - S tau is carried by the loops: J_B J_B' x = J_B (w - S tau).

Reference: Nakamura and Ghodoussi, Dynamics computation of closed-link robot mechanisms with nonredundant and redundant
actuators, IEEE Trans. Rob. Autom. 5, 1989.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mafsil.expression as ex
from mafsil.mechanics.body_tree import lump_bodies
from mafsil.mechanics.branch_factor import BranchFactor
from mafsil.mechanics.frame_choice import in_chosen_frames, regroup
from mafsil.mechanics.loop_constraints import gaps, loops
from mafsil.mechanics.loop_dynamics import HeldTree, error_of, pivot_doubt, spread
from mafsil.mechanics.loop_terms import Holding
from mafsil.mechanics.placement import Expression
from mafsil.mechanics.quantities.inverse_dynamics import inverse_dynamics
from mafsil.model import Mechanism

DEAD = 1e-12
"""Square of the share that driven joints have of a motion, one where they are all of it: below it is a dead point."""


@dataclass(frozen=True, eq=False, slots=True)
class Efforts:
    """Efforts tau (a,), what is then left to the loops (n,), P S (n, a), and what speaks against them all."""

    tau: Expression
    rest: Expression
    allowed: Expression
    doubt: Expression


def efforts(held: HeldTree, w: Expression, driven: Sequence[int], deciding: Sequence[int]) -> Efforts:
    """The shortest efforts of the driven joints that do what is needed, as far as they can.

    Args:
        held: the loops with the unit matrix in place of a mass matrix.
        w: (n,) efforts that are needed.
        driven: coordinates of the driven joints.
        deciding: which of them decide, as many as freedoms or as driven joints.
    """
    n = held.n
    columns = [held.closing(spread(ex.ones(1), [k], n)) for k in driven]
    allowed = ex.horzcat(*columns) if columns else ex.zeros(n, 0)
    if not columns:
        return Efforts(ex.zeros(0, 1), w, allowed, held.doubt)
    b = allowed.T @ w
    K = ex.vertcat(*(allowed[k, :] for k in driven))
    least = DEAD
    if len(deciding) == len(driven):
        A, right, back = K, b, ex.eye(len(driven))
    else:
        across = ex.vertcat(*(K[k, :] for k in deciding))
        A, right, back = across @ across.T, ex.vertcat(*(b[k] for k in deciding)), across.T
        least = DEAD**2
    factor = BranchFactor(A)
    tau = back @ ex.vertcat(*factor.solve(list(right)))
    doubt = held.doubt + pivot_doubt(factor, A)
    for pivot in factor.inverse_pivots:
        doubt = doubt + least * pivot
    return Efforts(tau, w - spread(tau, driven, n), allowed, doubt)


class Passive:
    """What joints that are not driven do so that the loops stay closed, the driven ones as they are.

    The shortest change where the driven joints do not decide it, least squares where they contradict the loops.

    Args:
        J: (m, n) rows of the loops.
        driven: coordinates of the driven joints.
        chosen: independent rows.

    Attributes:
        doubt: as of `HeldTree`.
    """

    def __init__(self, J: Expression, driven: Sequence[int], chosen: Sequence[int]) -> None:
        self.n, self.driven = J.shape[1], list(driven)
        self.others = [k for k in range(self.n) if k not in driven]
        self.doubt = ex.Expression(0)
        self._held: HeldTree | None = None
        if not self.others:
            return
        self._across = ex.horzcat(*(J[:, k] for k in self.others))
        if len(self.others) >= len(chosen):
            self._held = HeldTree(ex.eye(len(self.others)), self._across, chosen)
            self.doubt = self._held.doubt
        else:
            A = self._across.T @ self._across
            self._factor = BranchFactor(A)
            self.doubt = pivot_doubt(self._factor, A)

    def change(self, missing: Expression) -> Expression:
        """(n,) with J change = -missing, zero for driven joints.

        Args:
            missing: (m,).
        """
        if not self.others:
            return ex.zeros(self.n, 1)
        if self._held is not None:
            part = self._held.accelerations(ex.zeros(len(self.others), 1), missing)[0]
        else:
            part = -ex.vertcat(*self._factor.solve(list(self._across.T @ missing)))
        return spread(part, self.others, self.n)

    @property
    def decided(self) -> bool:
        """Whether the driven joints decide the others, and are no more than that takes."""
        return not self.others or (self._held is not None and len(self.others) == len(self._held.chosen))

    def efforts(self, J: Expression, w: Expression) -> Expression:
        """(a,) the only efforts of the driven joints that do what is needed, where they decide the others.

        The loops carry what the others need, J_p' x = w_p; the driven joints feel w_a - J_a' x.

        Args:
            J: (m, n) rows of the loops.
            w: (n,) efforts that are needed.
        """
        if self._held is None:
            return ex.vertcat(*(w[k] for k in self.driven))
        x = self._held.carrying_forces(ex.vertcat(*(w[k] for k in self.others)))
        rows = ex.vertcat(*(J[k, :] for k in self._held.chosen))
        felt = rows.T @ ex.vertcat(*x)
        return ex.vertcat(*(w[k] - felt[k] for k in self.driven))


def accelerations_of_all(
    J: Expression, gamma: Expression, given: Expression, driven: Sequence[int], chosen: Sequence[int]
) -> tuple[Expression, Expression]:
    """Accelerations (n,) of all joints that keep the loops closed, from those of the driven joints; and the doubt.

    Args:
        J, gamma: (m, n), (m,) rows of the loops and their bias.
        given: (a,) accelerations of the driven joints.
        driven: their coordinates.
        chosen: independent rows.
    """
    part, passive = spread(given, driven, J.shape[1]), Passive(J, driven, chosen)
    return part + passive.change(J @ part + gamma), passive.doubt


def inverse_function(mechanism: Mechanism, holding: Holding) -> ex.Function:
    """Efforts for a motion: q, qd, qdd (n,) to tau (a,), force (m,), missing, broken, needed, P S (n, a) and doubt.

    Missing is the size of what no driven joint makes, broken the acceleration with which the motion opens a loop, and
    needed the size of the efforts that the tree needs.

    Args:
        mechanism: with loops.
        holding: how they hold it.
    """
    n = mechanism.n
    full = in_chosen_frames(lump_bodies(mechanism))
    q, qd, qdd = ex.symbol("q", n), ex.symbol("qd", n), ex.symbol("qdd", n)
    asked = loops(full, mechanism.loops, q, qd)
    held = HeldTree(ex.eye(n), asked.rows, holding.rows)
    w = inverse_dynamics(regroup(full), q, qd, qdd)
    found = efforts(held, w, holding.driven, holding.deciding)
    force = held.forces(held.carrying_forces(found.rest))
    missing = ex.sqrt(ex.sumsqr(held.closing(found.rest)))
    broken = ex.Expression(0)
    for each in asked.rows @ qdd + asked.bias:
        broken = ex.if_else(ex.fabs(each) <= broken, broken, ex.fabs(each))
    doubt = found.doubt + held.finite(ex.vertcat(found.tau, w))
    outputs = [found.tau, force, missing, broken, ex.sqrt(ex.sumsqr(w)), ex.vec(found.allowed.T), doubt]
    return ex.Function("closed_inverse_dynamics", [q, qd, qdd], ex.cse(outputs))


CORRECTIONS = 3
"""Steps of Newton's method with the matrix of the first, after it."""


def following_function(mechanism: Mechanism, holding: Holding) -> ex.Function:
    """All joints while the driven ones move: guess (n,), driven (3, a) to positions, rates, accelerations (n,), doubt.

    1. Newton's method from the guess, the driven joints where they should be.
    2. Rates and accelerations of the others, by the rows of the loops there.

    Args:
        mechanism: with loops.
        holding: how they hold it.
    """
    tree, n, a = in_chosen_frames(lump_bodies(mechanism)), mechanism.n, len(holding.driven)
    guess, given = ex.symbol("guess", n), ex.symbol("driven", 3 * a)
    u, v, acceleration = (given[part * a : (part + 1) * a] for part in range(3))
    rest, joints = ex.zeros(n, 1), mechanism.loops
    # 1
    q = ex.vertcat(*(guess[k] for k in range(n)))
    for value, k in zip(u, holding.driven, strict=True):
        q[k] = value
    asked = loops(tree, joints, q, rest)
    passive = Passive(asked.rows, holding.driven, holding.rows)
    doubt = passive.doubt
    q = q + passive.change(asked.gap)
    for _ in range(CORRECTIONS):
        q = q + passive.change(gaps(tree, joints, q)[0])
    # 2
    rows = loops(tree, joints, q, rest)
    passive = Passive(rows.rows, holding.driven, holding.rows)
    qd = spread(v, holding.driven, n)
    qd = qd + passive.change(rows.rows @ qd)
    qdd = spread(acceleration, holding.driven, n)
    qdd = qdd + passive.change(rows.rows @ qdd + loops(tree, joints, q, qd).bias)
    doubt = doubt + passive.doubt + error_of(rows.gap, rows.facing) / holding.tolerance
    doubt = doubt + HeldTree.finite(ex.vertcat(q, qd, qdd))
    return ex.Function("closed_following", [guess, given], ex.cse([q, qd, qdd, doubt]))
