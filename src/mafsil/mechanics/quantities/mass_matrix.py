"""The mass matrix by composite bodies."""

from __future__ import annotations

from collections.abc import Sequence

import mafsil.expression as ex
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.composite_motion import CompositeInertia
from mafsil.mechanics.placement import Expression, Placement, placements, times, world_placements
from mafsil.mechanics.quantity import FEATHERSTONE, Quantity, SecondMethod
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
