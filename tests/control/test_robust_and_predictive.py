"""Min-max control keeps its bound; model-predictive control keeps efforts within limits and is optimal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are
from scipy.optimize import minimize

import mafsil as mf
from mafsil.control import min_max, model_predictive
from mafsil.errors import InputError
from mafsil.simulation import Plant, Scenario
from mafsil.solvers.box_quadratic import box_minimum
from mafsil.trajectory import Motion, quintic


def wrong(robot, rng, length):
    """The same arm with all masses off by relative errors of that length together, inertias with them."""
    bodies = [link.inertial is not None for link in robot.mechanism.links[1:]]
    errors = rng.normal(size=len(bodies)) * bodies
    # Ten parameters of a body move together with its mass.
    errors *= length / (np.sqrt(10.0) * np.linalg.norm(errors))
    links = [robot.mechanism.links[0]]
    for link, error in zip(robot.mechanism.links[1:], errors, strict=True):
        own = link.inertial
        changed = own and replace(own, mass=(1 + error) * own.mass, inertia=(1 + error) * own.inertia)
        links.append(replace(link, inertial=changed))
    return mf.Robot(replace(robot.mechanism, links=tuple(links)))


@pytest.mark.capability("10-86")
@pytest.mark.parametrize("seed", range(3))
def test_min_max_ends_below_its_bound(seed):
    rng = np.random.default_rng(seed)
    robot = mf.load("puma560")
    arm = wrong(robot, rng, 0.6)
    law = min_max(robot, share=0.6, rate=10.0, damping=15.0, width=0.5)
    path = quintic(np.zeros(6), rng.uniform(-0.8, 0.8, 6), 1.0)
    scenario = Scenario(
        robot=robot, plant=Plant(arm, friction=False), trajectory=path, law=law, saturate=False, integrator="rk4"
    )
    run = mf.simulate(scenario)
    error = np.abs(run.q_ref - run.q).max(axis=0)
    assert (error < law.error_bound(run.q, arm)).all()
    soft = min_max(robot, share=0.0, rate=10.0, damping=15.0, width=0.5)
    assert np.abs(mf.simulate(replace(scenario, law=soft)).q - run.q_ref).max() > 2 * error.max()


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_no_parameters_in_the_ball_raise_the_energy_by_more_than_stated(seed):
    from mafsil.control.sliding_mode import christoffel_regressor

    rng = np.random.default_rng(seed)
    robot = mf.load("planar3r")
    law = min_max(robot, share=0.5, rate=5.0, damping=2.0, width=0.3)
    q, qd, u, v, a = rng.normal(size=(5, 3)) * rng.uniform(0.1, 3)
    e = u - q
    s = v + law.rates * e - qd
    Y = christoffel_regressor(robot, q, qd, v + law.rates * e, a + law.rates * (v - qd))
    p = robot.inertial_parameters.reshape(-1)
    delta = rng.normal(size=p.shape)
    true = p + law.share * rng.uniform(0, 1) * np.abs(p) * delta / np.linalg.norm(delta)
    tau = law(0.0, q, qd, Motion(u, v, a))
    assert s @ (Y @ true - tau) <= -s @ (law.damping * s) + law.share * law.width / 4 + 1e-9


def test_without_limits_the_horizon_does_not_matter():
    robot, rng = mf.load("puma560"), np.random.default_rng(0)
    q, qd, u, v, a = rng.normal(size=(5, 4, 6))
    reference = Motion(u, v, a)
    laws = [model_predictive(robot, horizon=N, effort_limit=np.full(6, np.inf)) for N in (1, 5, 30)]
    efforts = [law(0.0, q, qd, reference) for law in laws]
    assert np.abs(efforts[0] - efforts[1]).max() < 1e-6 * np.abs(efforts[0]).max()
    assert np.abs(efforts[0] - efforts[2]).max() < 1e-6 * np.abs(efforts[0]).max()
    h, A = 0.02, np.array([[1, 0.02], [0, 1]])
    B = -np.array([[h * h / 2], [h]])
    P = solve_discrete_are(A, B, np.diag([1e4, 10.0]), np.array([[0.01]]))
    gain = np.linalg.solve(0.01 + B.T @ P @ B, B.T @ P @ A)[0]
    np.testing.assert_allclose(laws[0].gain, np.tile(gain, (6, 1)), rtol=1e-8)
    w = -(gain[0] * (u - q) + gain[1] * (v - qd))
    np.testing.assert_allclose(efforts[0], robot.inverse_dynamics(q, qd, a + w), rtol=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_within_limits_no_other_efforts_cost_less(seed):
    rng = np.random.default_rng(seed)
    robot = mf.load("planar2r")
    law = model_predictive(robot, horizon=6, effort_limit=[6.0, 3.0])
    q, qd, u = rng.normal(size=(3, 2))
    reference = Motion(u, np.zeros(2), np.zeros(2))
    plan = law.plan(q, qd, reference)
    assert (np.abs(plan) <= law.limit + 1e-12).all()
    assert (np.abs(plan) == law.limit).any()
    assert np.allclose(plan[0], law(0.0, q, qd, reference))
    M, known = robot.mass_matrix(q), robot.inverse_dynamics(q, qd, np.zeros(2))

    def cost(efforts):
        w = np.linalg.solve(M, (efforts.reshape(6, 2) - known).T)
        x0 = np.stack([u - q, -qd], axis=-1)
        linear = np.einsum("nkx,nx->nk", law.slope, x0)
        return float(np.einsum("nk,nkl,nl->", w, law.hessian, w) / 2 + (linear * w).sum())

    other = minimize(
        cost, rng.uniform(-1, 1, 12) * np.tile(law.limit, 6), bounds=[(-b, b) for b in np.tile(law.limit, 6)],
        method="L-BFGS-B", options={"maxiter": 5000, "ftol": 1e-15, "gtol": 1e-10},
    )  # fmt: skip
    assert cost(plan.reshape(-1)) <= other.fun + 1e-7 * abs(other.fun)


def test_a_run_stays_within_limits_and_arrives():
    robot = mf.load("planar2r")
    limit = np.array([25.0, 8.0])
    law = model_predictive(robot, effort_limit=limit)
    path = quintic([0, 0], [1.0, -0.8], 0.8)
    run = mf.simulate(Scenario(robot=robot, trajectory=path, law=law, saturate=False, q=[0.1, -0.1], duration=2.0))
    assert (np.abs(run.tau_commanded) <= limit).all()
    assert np.abs(run.q[-1] - run.q_ref[-1]).max() < 1e-2


@given(st.integers(0, 2**32 - 1))
def test_box_minimum_meets_the_conditions(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 12))
    A = rng.normal(size=(n, n))
    H, g = A @ A.T + 0.01 * np.eye(n), 3 * rng.normal(size=n)
    lower = np.where(rng.random(n) < 0.2, -np.inf, -rng.random(n))
    upper = np.where(rng.random(n) < 0.2, np.inf, rng.random(n))
    found = box_minimum(H, g, lower, upper, rng.normal(size=n))
    gradient = H @ found.x + g
    assert ((found.x >= lower) & (found.x <= upper)).all()
    inside = (found.x > lower) & (found.x < upper)
    assert np.abs(gradient[inside]).max(initial=0.0) < 1e-6
    assert (gradient[found.x == lower] > -1e-6).all()
    assert (gradient[found.x == upper] < 1e-6).all()


def test_bad_settings_are_named():
    robot = mf.load("planar2r")
    for name, arguments in (
        ("share", {"share": -1}), ("width", {"width": 0}), ("rate", {"rate": 0}), ("damping", {"damping": [1, -1]}),
    ):  # fmt: skip
        with pytest.raises(InputError, match=name):
            min_max(robot, **arguments)
    for name, arguments in (
        ("horizon", {"horizon": 0}), ("horizon", {"horizon": 5000}), ("interval", {"interval": -1}),
        ("position", {"position": 0}), ("acceleration", {"acceleration": 0}),
        ("effort_limit", {"effort_limit": [0, 1]}), ("effort_limit", {"effort_limit": [1, 1, 1]}),
    ):  # fmt: skip
        with pytest.raises(InputError, match=name):
            model_predictive(robot, **arguments)
