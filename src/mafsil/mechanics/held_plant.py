"""One integration step of a closed chain as an expression: it begins with closed loops, only driven joints get efforts.

1. Newton's method with the shortest steps takes the coordinates that the step before left back to closed loops; the
   matrix of its first step serves the others, which correct far less.
2. Rates lose what would open the loops, with the least kinetic energy.
3. A step of the integrator with the accelerations of the closed chain: mass matrix and rows of the loops are those of
   the second step, so that the whole is shorter than with closed loops at its end.

Reference: Hairer, Lubich and Wanner, Geometric Numerical Integration, sec. IV.4 (standard projection).
"""

from __future__ import annotations

from collections.abc import Sequence

import mafsil.expression as ex
from mafsil.mechanics.body_tree import BodyTree, lump_bodies
from mafsil.mechanics.composite_motion import CompositeInertia
from mafsil.mechanics.frame_choice import in_chosen_frames, regroup
from mafsil.mechanics.loop_constraints import gaps, loops
from mafsil.mechanics.loop_dynamics import HeldTree, error_of, spread
from mafsil.mechanics.loop_terms import Holding, Loop
from mafsil.mechanics.placement import Expression
from mafsil.mechanics.quantities.mass_matrix import mass_matrix
from mafsil.mechanics.tree_plant import TreePlant
from mafsil.model import Joint, Mechanism

CORRECTIONS = 2
"""Steps of Newton's method after the first, each some thousand times as short as the one before."""


class HeldPlant(TreePlant):
    """Steps of a closed chain under an effort that is constant.

    Args:
        loop: whose plant it is.
        holding: how its loops hold it.
        tree: of its bodies.
        effort: (n,) of the motors; that of joints that are not driven does nothing.
        x: inputs of the loop by name.

    Attributes:
        doubt: sum over all that was solved so far; see `HeldTree`.
    """

    def __init__(
        self, loop: Loop, holding: Holding, tree: BodyTree, effort: Expression, x: dict[str, Expression]
    ) -> None:
        driven = ex.vertcat(ex.zeros(0, 1), *(effort[k] for k in holding.driven))
        super().__init__(loop, tree, spread(driven, holding.driven, tree.n), x)
        self.holding, self.joints = holding, loop.plant.loops

    def _free(self, q: Expression, v: Expression, load: Expression) -> Expression:
        M, bias = self._terms(q, v)
        return self._solve(M, load - bias, q, v)

    def _solve(self, M: Expression, load: Expression, q: Expression, v: Expression) -> Expression:
        asked = loops(self.tree, self.joints, q, v)
        held = HeldTree(M, asked.rows, self.holding.rows)
        qdd, _ = held.accelerations(load, asked.bias)
        self.doubt = self.doubt + held.distrust(qdd, asked.bias)
        return qdd


def closed_state(
    tree: BodyTree,
    joints: Sequence[Joint],
    holding: Holding,
    q: Expression,
    v: Expression,
    inertias: Sequence[CompositeInertia] | None = None,
) -> tuple[Expression, Expression, Expression, Expression]:
    """Coordinates (n,) that close the loops, rates (n,) that keep them closed, the largest gap left, and the doubt.

    Args:
        tree: the bodies.
        joints: that close the loops.
        holding: their independent rows.
        q, v: (n,) coordinates near closed loops, and rates.
        inertias: of the bodies, where they are not the tree's own numbers.
    """
    rest = ex.zeros(tree.n, 1)
    asked = loops(tree, joints, q, rest)
    flat = HeldTree(ex.eye(tree.n), asked.rows, holding.rows)
    q = q + flat.accelerations(rest, asked.gap)[0]
    for _ in range(CORRECTIONS):
        q = q + flat.accelerations(rest, gaps(tree, joints, q)[0])[0]
    after = loops(tree, joints, q, rest)
    held = HeldTree(mass_matrix(tree, q, inertias), after.rows, holding.rows)
    error = error_of(after.gap, after.facing)
    v = held.closing(v)
    doubt = flat.doubt + held.doubt + error / holding.tolerance + held.finite(ex.vertcat(q, v))
    return q, v, error, doubt


def closing_function(mechanism: Mechanism, holding: Holding) -> ex.Function:
    """Coordinates and rates taken back to closed loops: q, v (n,) to both (n,), the largest gap left, and the doubt.

    Args:
        mechanism: with loops.
        holding: their independent rows.
    """
    tree = regroup(in_chosen_frames(lump_bodies(mechanism)))
    q, v = ex.symbol("q", tree.n), ex.symbol("qd", tree.n)
    return ex.Function("closed_state", [q, v], ex.cse([*closed_state(tree, mechanism.loops, holding, q, v)]))


def step_function(loop: Loop, holding: Holding) -> ex.Function:
    """A step and what takes its end back to closed loops: q, qd, tau (n,) and the length to q, qd (n,), gap and doubt.

    Args:
        loop: whose plant it is; a push is an input behind the length.
        holding: how its loops hold it.
    """
    tree = regroup(in_chosen_frames(lump_bodies(loop.plant)))
    q, v, tau, h = ex.symbol("q", tree.n), ex.symbol("qd", tree.n), ex.symbol("tau", tree.n), ex.symbol("step", 1)
    x = {"push": ex.symbol("push", 6)} if loop.pushed else {}
    plant = HeldPlant(loop, holding, tree, tau, x)
    here, rate, _ = plant.step(q, v, h)
    here, rate, error, doubt = closed_state(tree, loop.plant.loops, holding, here, rate)
    outputs = [here, rate, error, doubt + plant.doubt]
    return ex.Function("closed_step", [q, v, tau, h, *x.values()], ex.cse(outputs))
