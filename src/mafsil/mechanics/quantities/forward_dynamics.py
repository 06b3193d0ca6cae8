"""The mass matrix by composite bodies, and joint accelerations from joint efforts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import mafsil.expression as ex
from mafsil.errors import ModelError
from mafsil.mechanics.articulated_body import articulated_body
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.branch_factor import BranchFactor
from mafsil.mechanics.composite_motion import CompositeInertia
from mafsil.mechanics.placement import Expression, Placement, placements, times, world_placements
from mafsil.mechanics.quantities.inverse_dynamics import inverse_dynamics
from mafsil.mechanics.quantities.kinematics import jacobian_body
from mafsil.mechanics.quantity import FEATHERSTONE, Quantity, SecondMethod
from mafsil.mechanics.tolerances import SINGULAR_PIVOT
from mafsil.mechanics.wrench import Wrench, along, ground_is_shorter, twist_at_ground, wrench_at_ground


def mass_matrix(tree: BodyTree, q: Expression, inertias: Sequence[CompositeInertia] | None = None) -> Expression:
    """M(q) (n, n) [kg m^2 | kg m | kg], symmetric.

    Composite inertias are gathered from the leaves; F = I_composite S is the wrench that accelerates joint i by one,
    and its projections on the axes before it are the column's entries; of long chains all of it in the ground frame.

    Args:
        tree: the bodies.
        q: (n,) joint coordinates [rad | m].
        inertias: of the bodies (base first), where they are not the tree's own numbers.

    Reference: Featherstone, Rigid Body Dynamics Algorithms, sec. 6.2 (composite-rigid-body algorithm).
    """
    steps = placements(tree, q)
    composite = _composites(tree, steps, inertias)
    entries: dict[tuple[int, int], Expression] = {}
    if ground_is_shorter(tree, wrenches=1, rows=0):
        _fill_in_ground_frame(tree, steps, composite, entries)
        return _symmetric(entries, tree.n)
    for i, body in tree.moving:
        moment, force = composite[i].unit_acceleration(steps[i])
        j = i
        while j:
            effort = steps[j].omega * moment[2] + steps[j].v * force[2]
            _accumulate(tree, steps, entries, i, j, effort + body.armature if i == j else effort)
            force = steps[j].to_parent(force)
            moment = steps[j].to_parent(moment) + ex.cross(steps[j].offset, force)
            j = tree.bodies[j].parent
    return _symmetric(entries, tree.n)


def _fill_in_ground_frame(
    tree: BodyTree,
    steps: list[Placement],
    composite: list[CompositeInertia],
    entries: dict[tuple[int, int], Expression],
) -> None:
    """All entries, those of pairs from wrenches and screws in {0}."""
    R, o = world_placements(tree, steps)
    screws = [twist_at_ground(s.omega * R[k][:, 2], s.v * R[k][:, 2], o[k]) for k, s in enumerate(steps)]
    for i, body in tree.moving:
        unit = Wrench(*composite[i].unit_acceleration(steps[i]))
        _accumulate(tree, steps, entries, i, i, unit.along(steps[i]) + body.armature)
        there = wrench_at_ground(Wrench(R[i] @ unit.m, R[i] @ unit.f), o[i])
        for j in tree.path(body.parent):
            _accumulate(tree, steps, entries, i, j, along(there, screws[j]))


def _composites(
    tree: BodyTree, steps: list[Placement], inertias: Sequence[CompositeInertia] | None
) -> list[CompositeInertia]:
    own = [CompositeInertia.of(body.inertia) for body in tree.bodies] if inertias is None else list(inertias)
    for i, body in reversed(tree.moving):
        if body.parent:
            own[body.parent] = own[body.parent].add(own[i].in_parent(steps[i]))
    return own


def _accumulate(
    tree: BodyTree,
    steps: list[Placement],
    entries: dict[tuple[int, int], Expression],
    i: int,
    j: int,
    effort: Expression,
) -> None:
    """Add joint entry (i, j), j an ancestor or i itself, to the entry of their coordinates; once per unordered pair."""
    a, b = tree.bodies[i], tree.bodies[j]
    key = (max(a.coordinate, b.coordinate), min(a.coordinate, b.coordinate))
    both = 2.0 if i != j and a.coordinate == b.coordinate else 1.0
    scaled = times(both * steps[i].slopes[0] * steps[j].slopes[0], effort)
    entries[key] = entries[key] + scaled if key in entries else scaled


def _symmetric(entries: dict[tuple[int, int], Expression], n: int) -> Expression:
    zero = ex.Expression(0)
    rows = [[entries.get((max(i, j), min(i, j)), zero) for j in range(n)] for i in range(n)]
    return ex.vertcat(*(ex.horzcat(*row) for row in rows)) if n else ex.zeros(0, 0)


MASS_MATRIX = Quantity(
    name="mass_matrix",
    symbol="M",
    title="Mass matrix, symmetric: kinetic energy qd' M qd / 2.",
    builder=mass_matrix,
    inputs=("q",),
    shape=("n", "n"),
    unit="kg m^2 | kg m | kg",
    reference=FEATHERSTONE + "sec. 6.2",
    size=lambda arm: arm.inertia / arm.units,
    second=SecondMethod("verification.sum_over_links", lambda book, s: book.mass_matrix(s.q)),
    needs_mass=True,
)
LONG_CHAIN = 15
"""From this many joints in a row on, articulated bodies need fewer operations than the factored mass matrix."""


def forward_dynamics(
    tree: BodyTree, q: Expression, qd: Expression, tau: Expression, F_tip: Expression | None = None
) -> Expression:
    """qdd (n,) with M(q) qdd = tau - c(q, qd) - g(q) - J' F_tip.

    Of two exact methods the one with fewer operations for this tree: articulated bodies for long chains, otherwise the
    mass matrix factored along the tree; the latter always where joints follow each other.

    Args:
        tree: the bodies.
        q, qd: (n,) coordinates [rad | m] and rates.
        tau: (n,) joint efforts [N m | N].
        F_tip: (6,) wrench (m, f) the tip exerts on the world, in {tip} [N m, N]; None for none.

    Raises:
        ModelError: some joints move no inertia, so that no acceleration follows from their efforts.
    """
    if by_mass_matrix_shorter(tree):
        _require_inertia(tree)
        return by_mass_matrix(tree, q, qd, tau, F_tip)
    require_accelerations(tree, q)
    return articulated_body(tree, q, qd, tau, F_tip)


def by_mass_matrix_shorter(tree: BodyTree) -> bool:
    """Whether `forward_dynamics` solves with the mass matrix."""
    return tree.depth < LONG_CHAIN or tree.follows


def require_accelerations(tree: BodyTree, q: Expression) -> None:
    """Efforts determine the accelerations.

    Raises:
        ModelError: some joints move no inertia, so that no acceleration follows from their efforts.
    """
    _require_inertia(tree)
    _require_definite(tree, mass_matrix(tree, q))


def _require_inertia(tree: BodyTree) -> None:
    """Every coordinate moves some mass, rotational inertia or armature: of a body of its joints, or behind it."""
    loaded: set[int] = set()
    for i, body in reversed(tree.moving):
        if i in loaded or body.armature or body.inertia.mass or body.inertia.h.any() or body.inertia.I.any():
            loaded.update((i, body.parent))
    moved = {body.coordinate for i, body in tree.moving if i in loaded}
    for coordinate, joint in enumerate(tree.coordinates):
        if coordinate not in moved:
            raise ModelError("mechanics.no_inertia", joint=joint)


def _require_definite(tree: BodyTree, M: Expression) -> None:
    """No joint's share of the mass matrix is taken away by the others: two coaxial joints with nothing in between."""
    coordinates = ex.vertcat(ex.zeros(0, 1), *ex.symvar(M))
    anywhere = 0.3 + 0.7 * np.arange(coordinates.shape[0])
    values = ex.Function("M", [coordinates], [M])(anywhere).full()
    size = np.sqrt(np.maximum(np.diag(values), 0.0))
    joints = tree.coordinates
    if not size.all():
        raise ModelError("mechanics.no_inertia", joint=joints[int(np.argmin(size))])
    scaled = values / np.outer(size, size)
    weights, directions = np.linalg.eigh(scaled)
    if weights[0] < SINGULAR_PIVOT:
        involved = [joints[int(k)] for k in np.flatnonzero(np.abs(directions[:, 0]) > 0.1)]
        raise ModelError("mechanics.singular", joints=", ".join(involved))


def by_mass_matrix(
    tree: BodyTree, q: Expression, qd: Expression, tau: Expression, F_tip: Expression | None = None
) -> Expression:
    """qdd (n,) by solving with the mass matrix; arguments as in `forward_dynamics`.

    Reference: Featherstone, Rigid Body Dynamics Algorithms, sec. 6.5 (M = L' D L keeps the tree's zeros).
    """
    load = tau - inverse_dynamics(tree, q, qd, ex.zeros(tree.n, 1))
    if F_tip is not None:
        load = load - jacobian_body(tree, q, tree.tip).T @ F_tip
    M = mass_matrix(tree, q)
    _require_definite(tree, M)
    return solve_mass_matrix(M, load)


def solve_mass_matrix(M: Expression, b: Expression) -> Expression:
    """x (n,) with M x = b (n,) for a symmetric positive definite M (n, n), factored along the tree (`BranchFactor`)."""
    factor = BranchFactor(M)
    return ex.vertcat(*factor.solve([b[i, :] for i in range(factor.n)]))


FORWARD_DYNAMICS = Quantity(
    name="forward_dynamics",
    symbol="qdd",
    title="Joint accelerations that efforts produce: M qdd = tau - c - g - J' F_tip.",
    builder=forward_dynamics,
    inputs=("q", "qd", "tau"),
    optional=("tip_wrench",),
    shape=("n",),
    unit="rad/s^2 | m/s^2",
    reference=FEATHERSTONE + "sec. 6.5 and 7.3",
    size=lambda arm: arm.unit,
    second=SecondMethod("verification.solved", lambda book, s: book.accelerations_of(s.q, s.qd, s.tau, s.tip_wrench)),
    needs_mass=True,
    solves_mass_matrix=True,
)
