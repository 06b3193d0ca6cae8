"""For every routine of a robot a road to the same number that shares nothing with it.

A row of `ROADS` names the road (a key of the messages) and computes the number from a `Textbook` and a set of states.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.model import JointKind, Mechanism
from mafsil.verification.sizes import FALL, RATE, SLIDE, Sizes
from mafsil.verification.textbook import (
    Numbers,
    Textbook,
    adjoint,
    along,
    dual_bracket,
    gradient,
    inverse,
    skew,
)


@dataclass(frozen=True, eq=False, slots=True)
class States:
    """Random states (b, ...), the arguments of all routines.

    Attributes:
        q, qd, qdd, tau: (b, n).
        tip_wrench, base_twist, base_acceleration: (b, 6), or None where a routine is called without them.
        frame: name of the link whose frame is asked for; the tip frame if None.
    """

    q: Floats
    qd: Floats
    qdd: Floats
    tau: Floats
    tip_wrench: Floats | None = None
    base_twist: Floats | None = None
    base_acceleration: Floats | None = None
    frame: str | None = None


def random_states(mechanism: Mechanism, sizes: Sizes, count: int, seed: int) -> States:
    """Positions within the limits (at most one turn and half a metre), rates, loads and wrenches of natural size."""
    rng, n = np.random.default_rng(seed), mechanism.n
    reach = np.array([SLIDE if joint.kind is JointKind.PRISMATIC else np.pi for joint in mechanism.coordinates])
    lower, upper = np.maximum(mechanism.limits.lower, -reach), np.minimum(mechanism.limits.upper, reach)
    lower, upper = np.where(lower < upper, lower, -reach), np.where(lower < upper, upper, reach)
    weight = sizes.mass * FALL
    return States(
        rng.uniform(lower, upper, (count, n)),
        rng.uniform(-RATE, RATE, (count, n)) * sizes.unit,
        rng.uniform(-5, 5, (count, n)) * sizes.unit,
        rng.uniform(-1, 1, (count, n)) * weight * sizes.reach / sizes.unit,
        rng.uniform(-1, 1, (count, 6)) * weight * np.array([sizes.reach] * 3 + [1.0] * 3),
        rng.uniform(-1, 1, (count, 6)),
        rng.uniform(-3, 3, (count, 6)),
    )


@dataclass(frozen=True, slots=True)
class Road:
    """One independent way to a number.

    Attributes:
        key: of its sentence.
        value: the number for a set of states.
    """

    key: str
    value: Callable[[Textbook, States], Floats]


def _christoffel(book: Textbook, s: States) -> Floats:
    """Gamma_ijk = (dm_ij/dq_k + dm_ik/dq_j - dm_jk/dq_i) / 2."""
    dM = gradient(book.mass_matrix, s.q)
    return (dM + np.swapaxes(dM, 2, 3) - np.moveaxis(dM, 3, 1)) / 2


def _coriolis(book: Textbook, s: States) -> Floats:
    return np.einsum("bijk,bk->bij", _christoffel(book, s), s.qd)


def _velocity(book: Textbook, s: States) -> Floats:
    return book.virtual_work(s.q, s.qd, np.zeros_like(s.qd), weight=0.0)


def _centrifugal(book: Textbook, s: States) -> Floats:
    return np.einsum("bijj,bj->bi", _christoffel(book, s), s.qd**2)


def _pairs(book: Textbook, s: States) -> Floats:
    Gamma = _christoffel(book, s)
    return np.einsum("bijk,bj,bk->bi", Gamma, s.qd, s.qd) - np.einsum("bijj,bj->bi", Gamma, s.qd**2)


def _inverse_dynamics(book: Textbook, s: States) -> Floats:
    """Virtual work on a resting base, the recursion on one that is carried."""
    if s.base_twist is None:
        return book.virtual_work(s.q, s.qd, s.qdd, s.tip_wrench)
    return book.newton_euler(s.q, s.qd, s.qdd, s.tip_wrench, s.base_twist, s.base_acceleration).tau


def _lagrange(book: Textbook, s: States) -> Floats:
    """M qdd + (dM/dt) qd - dK/dq + dP/dq, all by the complex step."""
    momentum_rate = np.einsum("bij,bj->bi", along(book.mass_matrix, s.q, s.qd), s.qd)
    slope = gradient(lambda q: book.kinetic_energy(q, _repeated(s.qd, len(q))), s.q)
    weight = gradient(book.potential_energy, s.q)
    return np.einsum("bij,bj->bi", book.mass_matrix(s.q), s.qdd) + momentum_rate - slope + weight


def _inverse_derivatives(book: Textbook, s: States) -> Floats:
    """The recursion of Newton and Euler, differentiated by the complex step."""

    def efforts(q: Numbers, qd: Numbers, qdd: Numbers) -> Numbers:
        F = None if s.tip_wrench is None else _repeated(s.tip_wrench, len(q))
        return book.newton_euler(_complex(q), _complex(qd), _complex(qdd), F).tau

    return _blocks(efforts, s.q, s.qd, s.qdd)


def _forward_derivatives(book: Textbook, s: States) -> Floats:
    """The equation M qdd = tau - bias, solved in complex numbers."""

    def motion(q: Numbers, qd: Numbers, tau: Numbers) -> Numbers:
        F = None if s.tip_wrench is None else _repeated(s.tip_wrench, len(q))
        return book.accelerations_of(_complex(q), _complex(qd), _complex(tau), F)

    return _blocks(motion, s.q, s.qd, s.tau)


def _blocks(function: Callable[[Numbers, Numbers, Numbers], Numbers], *inputs: Floats) -> Floats:
    """(b, 3, n, n): derivatives by each of three inputs (b, n)."""
    found: list[Floats] = []
    for k in range(3):

        def varied(x: Numbers, k: int = k) -> Numbers:
            others = [_repeated(value, len(x)) for value in inputs]
            return function(*(x if j == k else other for j, other in enumerate(others)))

        found.append(gradient(varied, inputs[k]))
    return np.stack(found, axis=1)


def _complex(x: Numbers) -> Numbers:
    return x.astype(np.complex128)


def _repeated(x: Numbers, count: int) -> Numbers:
    """Rows of states repeated for the directions in which `gradient` asks."""
    return np.repeat(x, count // len(x), axis=0)


def _twists(book: Textbook, s: States) -> Floats:
    """J_l qd, and the base's twist seen from each link."""
    V = np.einsum("blin,bn->bli", book.link_jacobians(s.q), s.qd)
    if s.base_twist is None:
        return V
    return V + np.einsum("blij,bj->bli", adjoint(inverse(book.poses(s.q))), s.base_twist)


def _accelerations(book: Textbook, s: States) -> Floats:
    """Time derivatives of the twists by the complex step along the motion."""
    dV = book.accelerations(s.q, s.qd, s.qdd)
    if s.base_twist is None or s.base_acceleration is None:
        return dV

    def seen(q: Numbers) -> Numbers:
        return adjoint(inverse(book.poses(q)))

    turned = np.einsum("blij,bj->bli", along(seen, s.q, s.qd), s.base_twist)
    return dV + turned + np.einsum("blij,bj->bli", seen(s.q), s.base_acceleration)


def _wrenches(book: Textbook, s: States) -> Floats:
    return book.newton_euler(s.q, s.qd, s.qdd, s.tip_wrench, s.base_twist, s.base_acceleration).F


def _com_frames(book: Textbook) -> Floats:
    """(L, 4, 4) poses in the links of frames at their centres of mass, parallel to {s} at zero coordinates."""
    home = book.poses(np.zeros((1, book.mechanism.n)))[0]
    frames = np.tile(np.eye(4), (len(home), 1, 1))
    frames[:, :3, :3] = np.swapaxes(home[:, :3, :3], 1, 2)
    for k, link in enumerate(book.mechanism.links):
        if link.inertial is not None and link.inertial.mass:
            frames[k, :3, 3] = link.inertial.com
    return frames


def _at_com(motion: Callable[[Textbook, States], Floats]) -> Callable[[Textbook, States], Floats]:
    def moved(book: Textbook, s: States) -> Floats:
        return np.einsum("lij,blj->bli", adjoint(inverse(_com_frames(book))), motion(book, s))

    return moved


def _com_wrenches(book: Textbook, s: States) -> Floats:
    return np.einsum("lji,blj->bli", adjoint(_com_frames(book)), _wrenches(book, s))


def _regressor(book: Textbook, s: States) -> Floats:
    """Virtual work of a body with one parameter equal to one, link by link."""
    V, dV = _twists(book, s), book.accelerations(s.q, s.qd, s.qdd)
    columns = _columns(V, dV, book.poses(s.q), book.mechanism)
    return np.einsum("blin,blip->bnlp", book.link_jacobians(s.q), columns)


def _payload(book: Textbook, s: States) -> Floats:
    link, T_lf = book.place(s.frame)
    X = adjoint(inverse(T_lf))
    V = np.einsum("ij,bj->bi", X, _twists(book, s)[:, link])
    dV = np.einsum("ij,bj->bi", X, book.accelerations(s.q, s.qd, s.qdd)[:, link])
    T = book.pose(s.q, s.frame)
    columns = _columns(V[:, None], dV[:, None], T[:, None], book.mechanism)[:, 0]
    return np.einsum("bin,bip->bnp", book.jacobian_body(s.q, s.frame), columns)


def _columns(V: Floats, dV: Floats, T: Floats, mechanism: Mechanism) -> Floats:
    """(b, L, 6, 10) wrench that each unit parameter needs in the frame of its link."""
    fall = np.zeros_like(V)
    fall[..., 3:] = np.einsum("blji,j->bli", T[..., :3, :3], mechanism.gravity)
    columns = [
        np.einsum("ij,blj->bli", G, dV - fall) - dual_bracket(V, np.einsum("ij,blj->bli", G, V))
        for G in _unit_inertias()
    ]
    return np.stack(columns, axis=-1)


def _unit_inertias() -> list[Floats]:
    """(6, 6) inertias of m, hx, hy, hz, Ixx, Iyy, Izz, Ixy, Ixz, Iyz, each one alone."""
    found = [np.diag([0.0, 0, 0, 1, 1, 1])]
    for axis in np.eye(3):
        G = np.zeros((6, 6))
        G[:3, 3:], G[3:, :3] = skew(axis), skew(axis).T
        found.append(G)
    for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)):
        G = np.zeros((6, 6))
        G[i, j] = G[j, i] = 1.0
        found.append(G)
    return found


ROADS: dict[str, Road] = {
    "forward_kinematics": Road("verification.rodrigues", lambda b, s: b.pose(s.q, s.frame)),
    "link_poses": Road("verification.rodrigues", lambda b, s: b.poses(s.q)),
    "jacobian_space": Road("verification.screws", lambda b, s: b.jacobian_space(s.q, s.frame)),
    "jacobian_body": Road("verification.screws", lambda b, s: b.jacobian_body(s.q, s.frame)),
    "jacobian_space_rate": Road(
        "verification.complex_step", lambda b, s: along(lambda q: b.jacobian_space(q, s.frame), s.q, s.qd)
    ),
    "jacobian_body_rate": Road(
        "verification.complex_step", lambda b, s: along(lambda q: b.jacobian_body(q, s.frame), s.q, s.qd)
    ),
    "inverse_dynamics": Road("verification.virtual_work", _inverse_dynamics),
    "forward_dynamics": Road("verification.solved", lambda b, s: b.accelerations_of(s.q, s.qd, s.tau, s.tip_wrench)),
    "mass_matrix": Road("verification.sum_over_links", lambda b, s: b.mass_matrix(s.q)),
    "coriolis_matrix": Road("verification.christoffel", _coriolis),
    "velocity_torque": Road("verification.virtual_work", _velocity),
    "gravity_torque": Road("verification.potential", lambda b, s: gradient(b.potential_energy, s.q)),
    "kinetic_energy": Road("verification.sum_over_links", lambda b, s: b.kinetic_energy(s.q, s.qd)),
    "potential_energy": Road("verification.sum_over_links", lambda b, s: b.potential_energy(s.q)),
    "centrifugal_torque": Road("verification.christoffel", _centrifugal),
    "coriolis_torque": Road("verification.christoffel", _pairs),
    "christoffel_symbols": Road("verification.christoffel", _christoffel),
    "lagrange_torque": Road("verification.lagrange", _lagrange),
    "inverse_dynamics_derivatives": Road("verification.complex_recursion", _inverse_derivatives),
    "forward_dynamics_derivatives": Road("verification.complex_solution", _forward_derivatives),
    "link_twists": Road("verification.screws", _twists),
    "link_accelerations": Road("verification.complex_step", _accelerations),
    "link_wrenches": Road("verification.newton_euler", _wrenches),
    "com_twists": Road("verification.screws", _at_com(_twists)),
    "com_accelerations": Road("verification.complex_step", _at_com(_accelerations)),
    "com_wrenches": Road("verification.newton_euler", _com_wrenches),
    "regressor": Road("verification.unit_bodies", _regressor),
    "payload_regressor": Road("verification.unit_bodies", _payload),
}
"""The road to each quantity of the catalogue; a quantity without one is reported as not held."""
