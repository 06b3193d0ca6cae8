"""Centre of mass of the whole robot, and its Jacobian.

The robot's matter is all that its joints carry; the base link, and what is fixed to it, does not move and is left out.
"""

from __future__ import annotations

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.errors import ModelError
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.placement import Expression, constant, placements, world_placements
from mafsil.mechanics.quantity import Quantity, SecondMethod
from mafsil.mechanics.states import States
from mafsil.mechanics.textbook import Numbers, Textbook, gradient


def center_of_mass(tree: BodyTree, q: Expression) -> Expression:
    """p_sc (3,) = sum of m_i p_i over the moving bodies, divided by their mass, in {s} [m].

    Args:
        tree: the bodies with their true inertias.
        q: (n,) joint coordinates [rad | m].

    Raises:
        ModelError: nothing that moves has mass.
    """
    R, o = world_placements(tree, placements(tree, q))
    total = ex.zeros(3, 1)
    for i, body in tree.moving:
        total = total + body.inertia.mass * o[i] + R[i] @ constant(body.inertia.h)
    return constant(tree.p_s0) + constant(tree.R_s0) @ (total / moving_mass(tree))


def com_jacobian(tree: BodyTree, q: Expression) -> Expression:
    """J_com (3, n) with dp_sc/dt = J_com qd, in {s}.

    With m, c the mass and first moment of all that a joint with the screw (w, v) along z through o carries:
        column = (w z x (c - m o) + v m z) / mass

    Args:
        tree: the bodies with their true inertias.
        q: (n,) joint coordinates [rad | m].

    Raises:
        ModelError: nothing that moves has mass.
    """
    steps = placements(tree, q)
    R, o = world_placements(tree, steps)
    masses = [body.inertia.mass for body in tree.bodies]
    moments = [m * p + r @ constant(body.inertia.h) for m, p, r, body in zip(masses, o, R, tree.bodies, strict=True)]
    columns: list[Expression] = [ex.zeros(3, 1) for _ in range(tree.n)]
    for i, body in reversed(tree.moving):
        z, step = R[i][:, 2], steps[i]
        moved = step.omega * ex.cross(z, moments[i] - masses[i] * o[i]) + step.v * masses[i] * z
        columns[body.coordinate] = columns[body.coordinate] + step.slopes[0] * moved
        masses[body.parent] += masses[i]
        moments[body.parent] = moments[body.parent] + moments[i]
    return constant(tree.R_s0) @ ex.horzcat(*columns) / moving_mass(tree)


def moving_mass(tree: BodyTree) -> float:
    """Mass of all bodies but the base [kg].

    Raises:
        ModelError: it is zero.
    """
    mass = sum(body.inertia.mass for _, body in tree.moving)
    if not mass:
        raise ModelError("mechanics.no_moving_mass")
    return mass


def com_of(book: Textbook, q: Numbers) -> Numbers:
    """(b, 3) the second method: the sum over the links that some joint moves."""
    T, mass, moment = book.poses(q), np.float64(0.0), np.zeros((len(q), 3), dtype=q.dtype)
    for k in moving_links(book):
        body = book.mechanism.links[k].inertial
        if body is not None:
            mass = mass + body.mass
            moment = moment + body.mass * (T[:, k, :3, :3] @ body.com + T[:, k, :3, 3])
    return moment / mass


def moving_links(book: Textbook) -> list[int]:
    """Numbers of the links that some joint moves."""
    moves: Floats = book.carries @ np.abs(np.nan_to_num(book.share, nan=1.0)).sum(axis=1)
    return [k for k, number in enumerate(moves) if number]


CENTER_OF_MASS = Quantity(
    name="center_of_mass",
    symbol="p_sc",
    title="Centre of mass of all that the joints carry.",
    builder=center_of_mass,
    inputs=("q",),
    shape=(3,),
    unit="m",
    expressed_in="{s}",
    reference="Orin, Goswami & Lee, Centroidal dynamics of a humanoid robot, 2013, eq. 20",
    size=lambda arm: np.array(arm.length),
    second=SecondMethod("verification.sum_over_links", lambda book, s: com_of(book, s.q)),
    regrouped=False,
    needs_mass=True,
)


def _slope(book: Textbook, s: States) -> Floats:
    return gradient(lambda q: com_of(book, q), s.q)


COM_JACOBIAN = Quantity(
    name="com_jacobian",
    symbol="J_com",
    title="Jacobian of the centre of mass: dp_sc/dt = J_com qd.",
    builder=com_jacobian,
    inputs=("q",),
    shape=(3, "n"),
    unit="m | 1",
    expressed_in="{s}",
    reference="Orin, Goswami & Lee, Centroidal dynamics of a humanoid robot, 2013",
    size=lambda arm: np.full((3, 1), arm.length) / arm.unit,
    second=SecondMethod("verification.complex_step", _slope),
    regrouped=False,
    needs_mass=True,
)
