"""Momentum of the whole robot about its centre of mass, the matrix that gives it from the rates, and its derivative.

Order (angular, linear), in the axes of {s}; links only, without the rotors that armatures stand for.

Reference: Orin, Goswami & Lee, Centroidal dynamics of a humanoid robot, Autonomous Robots 35, 2013.

Centre of mass of the whole robot, and its Jacobian.

The robot's matter is all that its joints carry; the base link, and what is fixed to it, does not move and is left out.
"""

from __future__ import annotations

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.errors import ModelError
from mafsil.mechanics.arm_size import ArmSize
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.composite_motion import CompositeInertia
from mafsil.mechanics.placement import Expression, constant, placements, world_placements
from mafsil.mechanics.quantities.link_motion import outward_motion
from mafsil.mechanics.quantity import Quantity, SecondMethod, States
from mafsil.mechanics.textbook import Numbers, Textbook, adjoint, along, gradient, inverse
from mafsil.mechanics.wrench import Wrench


def centroidal_momentum_matrix(tree: BodyTree, q: Expression) -> Expression:
    """A (6, n) with (k, l) = A qd: column j is the momentum of all that joint j carries, at its unit rate.

    1. Composite bodies are gathered from the leaves, each in the frame of its joint.
    2. G S of a composite body and its joint's screw is its momentum about the frame's origin.
    3. That, seen from the centre of mass in the axes of {s}, is the column.

    Args:
        tree: the bodies with their true inertias.
        q: (n,) joint coordinates [rad | m].

    Raises:
        ModelError: nothing that moves has mass.

    Reference: as the module.
    """
    steps = placements(tree, q)
    # 1.
    composite = [CompositeInertia.of(b.inertia) for b in tree.bodies]
    for i, body in reversed(tree.moving):
        if body.parent:
            composite[body.parent] = composite[body.parent].add(composite[i].in_parent(steps[i]))
    # 2. and 3.
    columns: list[Expression] = [ex.zeros(6, 1) for _ in range(tree.n)]
    seen = _SeenFromCom(tree, q)
    for i, body in tree.moving:
        momentum = Wrench(*composite[i].unit_acceleration(steps[i]))
        columns[body.coordinate] = columns[body.coordinate] + steps[i].slopes[0] * seen(i, momentum)
    return ex.horzcat(*columns) if columns else ex.zeros(6, 0)


def centroidal_momentum(tree: BodyTree, q: Expression, qd: Expression) -> Expression:
    """(k, l) (6,) angular momentum about the centre of mass and linear momentum, in the axes of {s}.

    Args:
        tree: the bodies with their true inertias.
        q, qd: (n,) coordinates [rad | m] and rates.

    Raises:
        ModelError: nothing that moves has mass.

    Reference: as the module.
    """
    return centroidal_momentum_matrix(tree, q) @ qd


def centroidal_momentum_rate(tree: BodyTree, q: Expression, qd: Expression, qdd: Expression) -> Expression:
    """d(k, l)/dt (6,): what all bodies' motions need together, by Newton and Euler, about the centre of mass.

    The centre of mass moves, but with it goes the linear momentum alone, and that along its own velocity: no term.

    Args:
        tree: the bodies with their true inertias.
        q, qd, qdd: (n,) coordinates [rad | m] and time derivatives.

    Raises:
        ModelError: nothing that moves has mass.

    Reference: as the module.
    """
    motion, seen, total = outward_motion(tree, placements(tree, q), qd, qdd), _SeenFromCom(tree, q), ex.zeros(6, 1)
    for i, body in tree.moving:
        need = Wrench.of_motion(
            CompositeInertia.of(body.inertia), motion.omega[i], motion.alpha[i], motion.a[i], motion.spin[i]
        )
        total = total + seen(i, need)
    return total


class _SeenFromCom:
    """Momenta or wrenches at the origin of a body's frame {i}, moved to the centre of mass, in the axes of {s}."""

    def __init__(self, tree: BodyTree, q: Expression) -> None:
        self.R, self.o = world_placements(tree, placements(tree, q))
        self.R_s0 = constant(tree.R_s0)
        self.center = self.R_s0.T @ (center_of_mass(tree, q) - constant(tree.p_s0))

    def __call__(self, i: int, at_origin: Wrench) -> Expression:
        """(6,) of body i."""
        f = self.R[i] @ at_origin.f
        m = self.R[i] @ at_origin.m + ex.cross(self.o[i] - self.center, f)
        return ex.vertcat(self.R_s0 @ m, self.R_s0 @ f)


def _matrix(book: Textbook, q: Numbers) -> Numbers:
    """(b, 6, n) the second method: the sum of Ad(T_lc)' G_l J_l over the links that some joint moves."""
    T = book.poses(q)
    T_sc = np.zeros((len(q), 4, 4), dtype=T.dtype)
    T_sc[:] = np.eye(4)
    T_sc[:, :3, 3] = com_of(book, q)
    J, total = book.link_jacobians(q), 0.0
    for k in moving_links(book):
        X = adjoint(inverse(T[:, k]) @ T_sc)
        total = total + np.swapaxes(X, 1, 2) @ book.G[k] @ J[:, k]
    return np.asarray(total)


def _momentum(book: Textbook, s: States) -> Floats:
    return np.einsum("bij,bj->bi", _matrix(book, s.q), s.qd)


def _rate(book: Textbook, s: States) -> Floats:
    """A qdd + (dA/dt) qd, dA/dt by the complex step along the motion."""
    drift = np.einsum("bij,bj->bi", along(lambda q: _matrix(book, q), s.q, s.qd), s.qd)
    return np.einsum("bij,bj->bi", _matrix(book, s.q), s.qdd) + drift


def _size(arm: ArmSize) -> Floats:
    """(6,) at unit rates."""
    return arm.mass * arm.length * np.array([arm.length] * 3 + [1.0] * 3)


CENTROIDAL_MOMENTUM_MATRIX = Quantity(
    name="centroidal_momentum_matrix",
    symbol="A",
    title="Centroidal momentum matrix: (k, l) = A qd, about the centre of mass of all that the joints carry.",
    builder=centroidal_momentum_matrix,
    inputs=("q",),
    shape=(6, "n"),
    unit="kg m^2 | kg m, kg m | kg",
    expressed_in="the axes of {s}",
    reference="Orin, Goswami & Lee, Centroidal dynamics of a humanoid robot, 2013",
    size=lambda arm: _size(arm)[:, None] / arm.unit,
    second=SecondMethod("verification.sum_over_links", lambda book, s: _matrix(book, s.q)),
    regrouped=False,
    needs_mass=True,
)
CENTROIDAL_MOMENTUM = Quantity(
    name="centroidal_momentum",
    symbol="(k, l)",
    title="Momentum of the robot, angular first, about the centre of mass of all that the joints carry.",
    builder=centroidal_momentum,
    inputs=("q", "qd"),
    shape=(6,),
    unit="N m s, N s",
    expressed_in="the axes of {s}",
    reference="Orin, Goswami & Lee, Centroidal dynamics of a humanoid robot, 2013",
    size=_size,
    second=SecondMethod("verification.sum_over_links", _momentum),
    regrouped=False,
    needs_mass=True,
)
CENTROIDAL_MOMENTUM_RATE = Quantity(
    name="centroidal_momentum_rate",
    symbol="d(k, l)/dt",
    title="Time derivative of the momentum about the centre of mass: the wrench that everything outside exerts.",
    builder=centroidal_momentum_rate,
    inputs=("q", "qd", "qdd"),
    shape=(6,),
    unit="N m, N",
    expressed_in="the axes of {s}",
    reference="Orin, Goswami & Lee, Centroidal dynamics of a humanoid robot, 2013",
    size=_size,
    second=SecondMethod("verification.complex_step", _rate),
    regrouped=False,
    needs_mass=True,
)


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
