"""Laws that hold between the quantities of any robot, for any batch: nothing here knows a number of a robot."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import count

import casadi as ca
import numpy as np
import pytest

from mafsil.mechanics.catalogue import CATALOGUE
from mafsil.model import JointKind, Mechanism
from mafsil.robot import Robot
from mafsil.robot.trace import trace
from tests.oracles import subjects
from tests.oracles.casadi_expression import as_casadi
from tests.oracles.natural_scale import NaturalScale, natural_scale
from tests.oracles.random_tree import random_tree
from tests.oracles.states import States, sample

ROBOTS = ("panda", "puma560", "stanford_arm", "cobra600", "planar2r_point_masses", "tree")
SHAPES = ((), (1,), (3, 1, 2), (0,))
ONE_FREEDOM = {kind for kind in JointKind if kind.freedoms <= 1}
EXACT = 1e-12
"""Relative to the robot's natural scale."""


@cache
def robot(name: str) -> Robot:
    """`tree` branches, and has helical, prismatic and mimic joints and massless links."""
    return Robot(_rich_tree() if name == "tree" else subjects.mechanism(name))


def _rich_tree() -> Mechanism:
    trees = (random_tree(np.random.default_rng(seed), most_joints=12) for seed in count())
    return next(tree for tree in trees if tree.n > 6 and _has_all(tree))


def _has_all(tree: Mechanism) -> bool:
    kinds = {joint.kind for joint in tree.joints}
    branches = len(set(tree.parents)) < len(tree.parents)
    massless = any(link.inertial is None for link in tree.links[1:])
    return kinds == ONE_FREEDOM and branches and massless and any(joint.mimic for joint in tree.joints)


@cache
def scale(name: str) -> NaturalScale:
    return natural_scale(robot(name).mechanism)


def states(name: str, shape: tuple[int, ...]) -> States:
    """States with that batch shape."""
    rows = sample(robot(name).mechanism, int(np.prod(shape)), np.random.default_rng([9, len(shape)]))
    return States(*(x.reshape(*shape, x.shape[-1]) for x in rows.arguments(("q", "qd", "qdd", "tau", "tip_wrench"))))


def agree(name: str, quantity: str, a: np.ndarray, b: np.ndarray, limit: float = EXACT) -> None:
    """Both have the same shape and differ by less than `limit` of the natural scale."""
    assert a.shape == b.shape
    core = len(CATALOGUE[quantity].shape)
    flat = (int(np.prod(a.shape[: a.ndim - core])), *a.shape[a.ndim - core :])
    errors = scale(name).error(quantity, a.reshape(flat), b.reshape(flat))
    assert errors.max(initial=0.0) < limit


def times(A: np.ndarray, x: np.ndarray) -> np.ndarray:
    """A x over batches."""
    return (A @ x[..., None])[..., 0]


def derivative(name: str, quantity: str, values: States, rates: np.ndarray) -> np.ndarray:
    """d/dt of a quantity of q along qd, exact: by CasADi's differentiation of the traced expression."""
    mechanism = robot(name).mechanism
    function = as_casadi(trace(mechanism, CATALOGUE[quantity], None))
    q, qd = ca.SX.sym("q", mechanism.n), ca.SX.sym("qd", mechanism.n)
    shape = getattr(robot(name), quantity)(values.q).shape
    if 0 in shape:
        return np.zeros(shape)
    along = ca.Function("along", [q, qd], [ca.jtimes(function(q), q, qd)])
    result = along(values.q.reshape(-1, mechanism.n).T, rates.reshape(-1, mechanism.n).T).full().T
    return np.ascontiguousarray(result).reshape(shape)


@pytest.fixture(params=ROBOTS)
def name(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture(params=SHAPES, ids=str)
def shape(request: pytest.FixtureRequest) -> tuple[int, ...]:
    return request.param


@pytest.mark.capability("09-2", "09-19", "09-55")
def test_inverse_dynamics_is_the_sum_of_its_terms(name: str, shape: tuple[int, ...]) -> None:
    r, s = robot(name), states(name, shape)
    M, c, g = r.mass_matrix(s.q), r.velocity_torque(s.q, s.qd), r.gravity_torque(s.q)
    agree(name, "inverse_dynamics", times(M, s.qdd) + c + g, r.inverse_dynamics(s.q, s.qd, s.qdd))
    load = times(np.swapaxes(r.jacobian_body(s.q), -1, -2), s.tip_wrench)
    agree(
        name,
        "inverse_dynamics",
        times(M, s.qdd) + c + g + load,
        r.inverse_dynamics(s.q, s.qd, s.qdd, tip_wrench=s.tip_wrench),
    )


@pytest.mark.capability("09-4", "09-62", "09-63", "09-64")
def test_forward_dynamics_undoes_inverse_dynamics(name: str, shape: tuple[int, ...]) -> None:
    r, s = robot(name), states(name, shape)
    tau = r.inverse_dynamics(s.q, s.qd, s.qdd)
    agree(name, "inverse_dynamics", r.inverse_dynamics(s.q, s.qd, r.forward_dynamics(s.q, s.qd, tau)), tau, 1e-10)
    agree(name, "forward_dynamics", r.forward_dynamics(s.q, s.qd, tau), s.qdd, 1e-8)
    loaded = r.inverse_dynamics(s.q, s.qd, s.qdd, s.tip_wrench)
    agree(name, "forward_dynamics", r.forward_dynamics(s.q, s.qd, loaded, s.tip_wrench), s.qdd, 1e-8)


@pytest.mark.capability("09-51")
def test_columns_of_the_mass_matrix_are_inverse_dynamics_of_unit_accelerations(name: str) -> None:
    r, s = robot(name), states(name, (3,))
    g = r.gravity_torque(s.q)[:, None]
    columns = r.inverse_dynamics(s.q[:, None], np.zeros(r.n), np.eye(r.n)) - g
    agree(name, "mass_matrix", np.swapaxes(columns, -1, -2), r.mass_matrix(s.q))


@pytest.mark.capability("09-5", "09-18")
def test_mass_matrix_is_symmetric_and_positive_definite(name: str, shape: tuple[int, ...]) -> None:
    r, s = robot(name), states(name, shape)
    M = r.mass_matrix(s.q)
    assert np.array_equal(M, np.swapaxes(M, -1, -2))
    unit = scale(name).unit
    assert (np.linalg.eigvalsh(M * unit * unit[:, None]) > 0).all()
    agree(name, "kinetic_energy", (s.qd * times(M, s.qd)).sum(-1) / 2, r.kinetic_energy(s.q, s.qd))


@pytest.mark.capability("09-57", "09-58", "09-59")
def test_passivity(name: str, shape: tuple[int, ...]) -> None:
    r, s = robot(name), states(name, shape)
    C = r.coriolis_matrix(s.q, s.qd)
    agree(name, "velocity_torque", times(C, s.qd), r.velocity_torque(s.q, s.qd))
    skew = derivative(name, "mass_matrix", s, s.qd) - 2 * C
    agree(name, "coriolis_matrix", skew, -np.swapaxes(skew, -1, -2))


def test_coriolis_matrix_is_that_of_the_christoffel_symbols(name: str) -> None:
    """c is quadratic in the rates with symmetric coefficients: C(a) b = C(b) a."""
    r, s = robot(name), states(name, (4,))
    a, b = s.qd, s.qdd
    agree(name, "velocity_torque", times(r.coriolis_matrix(s.q, a), b), times(r.coriolis_matrix(s.q, b), a))
    agree(name, "coriolis_matrix", r.coriolis_matrix(s.q, -2 * a), -2 * r.coriolis_matrix(s.q, a))


@pytest.mark.capability("09-21", "09-59")
def test_gravity_is_the_slope_of_the_potential_energy(name: str, shape: tuple[int, ...]) -> None:
    r, s = robot(name), states(name, shape)
    g = r.gravity_torque(s.q)
    agree(name, "potential_energy", derivative(name, "potential_energy", s, s.qd), (g * s.qd).sum(-1))


@pytest.mark.capability("09-18")
def test_power_balance(name: str) -> None:
    """d/dt (K + P) = tau . qd; along a motion, dK/dt = qd' M qdd + qd' dM/dt qd / 2."""
    r, s = robot(name), states(name, (5,))
    M, dM = r.mass_matrix(s.q), derivative(name, "mass_matrix", s, s.qd)
    power = (r.inverse_dynamics(s.q, s.qd, s.qdd) * s.qd).sum(-1)
    kinetic = (s.qd * times(M, s.qdd)).sum(-1) + (s.qd * times(dM, s.qd)).sum(-1) / 2
    agree(name, "kinetic_energy", kinetic + derivative(name, "potential_energy", s, s.qd), power)


@pytest.mark.capability("09-7")
def test_free_motion_keeps_its_energy_as_well_as_the_step_allows() -> None:
    """Halving the step of Heun's second order method divides the drift by eight or so (per unit time: 4 to 9)."""
    r = robot("panda")
    q0 = np.array([0.1, -0.5, 0.3, -1.5, 0.2, 1.5, 0.1])

    def drift(steps: int) -> float:
        q, qd, h = q0, np.zeros(7), 0.2 / steps
        start = r.potential_energy(q)
        for _ in range(steps):
            a = r.forward_dynamics(q, qd, np.zeros(7))
            b = r.forward_dynamics(q + h * qd, qd + h * a, np.zeros(7))
            q, qd = q + h * qd + h * h / 2 * a, qd + h / 2 * (a + b)
        return abs(float(r.kinetic_energy(q, qd) + r.potential_energy(q) - start))

    coarse, fine = drift(200), drift(400)
    assert coarse < 1e-2
    assert 3.5 < coarse / fine < 9


@pytest.mark.capability("09-47", "09-64")
def test_the_tip_wrench_is_what_the_robot_exerts() -> None:
    """The world answers with the opposite wrench: pushing on the wall along x drives the arm back along -x."""
    r = robot("panda")
    q, zero = np.array([0.1, -0.5, 0.3, -1.5, 0.2, 1.5, 0.1]), np.zeros(7)
    rest = r.gravity_torque(q)
    for axis in range(6):
        F = np.zeros(6)
        F[axis] = 5.0
        acceleration = r.jacobian_body(q) @ r.forward_dynamics(q, zero, rest, F)
        assert acceleration[axis] < 0
        assert np.abs(r.forward_dynamics(q, zero, rest, 0 * F)).max() < 1e-10


def test_gravity_is_an_upward_acceleration_of_the_base(name: str) -> None:
    """Gravity and base turned together change nothing; no gravity, no effort at rest; twice it, twice the effort."""
    r, s = robot(name), states(name, (3,))
    turned = turned_about_x(r, 0.7)
    agree(name, "inverse_dynamics", turned.inverse_dynamics(s.q, s.qd, s.qdd), r.inverse_dynamics(s.q, s.qd, s.qdd))
    agree(name, "potential_energy", turned.potential_energy(s.q), r.potential_energy(s.q))
    weightless = Robot(r.mechanism.with_gravity(np.zeros(3)))
    assert (weightless.gravity_torque(s.q) == 0).all()
    agree(name, "velocity_torque", weightless.inverse_dynamics(s.q, s.qd, 0 * s.qdd), r.velocity_torque(s.q, s.qd))
    heavy = Robot(r.mechanism.with_gravity(2 * r.mechanism.gravity))
    agree(name, "gravity_torque", heavy.gravity_torque(s.q), 2 * r.gravity_torque(s.q))


def turned_about_x(r: Robot, angle: float) -> Robot:
    """The robot with base pose and gravity turned about x of {s}, through {s}'s origin."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    T = np.eye(4)
    T[:3, :3] = R
    return Robot(replace(r.mechanism, T_sb=T @ r.mechanism.T_sb, gravity=R @ r.mechanism.gravity))
