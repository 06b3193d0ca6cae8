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
from mafsil.arrays import frozen
from mafsil.control import model_predictive
from mafsil.control.analysis import min_max
from mafsil.errors import InputError
from mafsil.simulation import Plant, Scenario
from mafsil.solvers import horizon_loops
from mafsil.trajectory import Motion, quintic
from tests.oracles.box_quadratic import box_minimum


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
    from mafsil.control.laws.sliding_mode import christoffel_regressor

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
    laws = [model_predictive(robot, horizon=N, effort_limit=np.full(6, np.inf)) for N in (1, 5, 12)]
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


def in_numpy(law, q, qd, reference):
    """The same program as one large Hessian, solved by projected Newton steps."""
    n, N = law.slope.shape[:2]
    errors = np.stack([reference.u - q, reference.v - qd], axis=-1)
    M, known = law.robot.mass_matrix(q), law.robot.inverse_dynamics(q, qd, reference.a)
    W = np.linalg.inv(M)
    H = np.einsum("ja,jkl,jb->kalb", W, law.hessian, W).reshape(N * n, N * n)
    gradient = (law.slope @ errors[..., None])[..., 0] - law.hessian.sum(axis=-1) * (W @ known)[:, None]
    g, bound = (W.T @ gradient).T.reshape(-1), np.tile(law.limit, N)
    return box_minimum(H, g, -bound, bound, np.tile(known, N)), H, g, bound


@pytest.mark.parametrize("horizon", [10, 20])
def test_the_compiled_law_is_that_of_arrays(horizon):
    rng = np.random.default_rng(horizon)
    robot = mf.load("panda")
    law = model_predictive(robot, horizon=horizon, interval=0.01)
    middle, seen = (robot.limits.lower + robot.limits.upper) / 2, set()
    for _ in range(12):
        q, qd, e = middle + 0.3 * rng.normal(size=7), 0.3 * rng.normal(size=7), rng.normal(size=7)
        reference = Motion(q + rng.choice([0.02, 0.1, 0.3]) * e, np.zeros(7), rng.normal(size=7))
        (x, _, _, residual), _, g, _ = in_numpy(law, q, qd, reference)
        if residual > 1e-9 * np.abs(g).max():
            continue  # Newton steps of arrays that did not settle
        plan = law.plan(q, qd, reference)
        assert np.abs(plan.reshape(-1) - x).max() < 1e-9 * np.abs(x).max()
        assert np.array_equal(law(0.0, q, qd, reference), plan[0])
        seen.add(int((np.abs(plan) == law.limit).sum()))
    assert max(seen) >= 3
    assert len(seen) > 2


def test_far_beyond_the_limits_it_is_the_best_as_daqp_says():
    """Errors of a radian: most efforts are at their limits. (The Newton steps of arrays do not settle there.)"""
    daqp = pytest.importorskip("daqp")
    rng = np.random.default_rng(2)
    robot = mf.load("panda")
    law = model_predictive(robot, horizon=12, interval=0.01, position=80.0**4, rate=2 * 80.0**2, acceleration=1.0)
    middle, held = (robot.limits.lower + robot.limits.upper) / 2, []
    for size in (0.1, 0.3, 1.0, 1.0):
        q, qd = middle + 0.3 * rng.normal(size=7), rng.normal(size=7)
        reference = Motion(q + size * rng.normal(size=7), np.zeros(7), np.zeros(7))
        plan = law.plan(q, qd, reference)
        _, H, g, bound = in_numpy(law, q, qd, reference)
        x, _, flag, _ = daqp.solve(H, g, np.zeros((0, len(g))), bound.copy(), -bound.copy(), np.zeros(len(g), np.intc))
        assert flag == 1
        assert np.abs(plan.reshape(-1) - x).max() < 1e-7 * np.abs(x).max()
        held.append(int((np.abs(plan) == law.limit).sum()))
    assert max(held) > 20


@given(st.integers(0, 2**32 - 1))
def test_what_is_found_meets_the_conditions_of_the_best(seed):
    rng = np.random.default_rng(seed)
    n, N = int(rng.integers(1, 5)), int(rng.integers(1, 9))
    A, B = rng.normal(size=(n, N, N)), rng.normal(size=(n, n))
    K = A @ np.swapaxes(A, 1, 2) + 0.01 * np.eye(N)
    M = B @ B.T + 0.1 * np.eye(n)
    bound = np.where(rng.random(n) < 0.2, np.inf, 0.1 + rng.random(n))
    free, x = 3 * rng.normal(size=(N, n)), np.empty((N, n))
    assert horizon_loops.within(frozen(K), M, free, frozen(bound), x)
    W = np.linalg.inv(M)
    H = np.einsum("ja,jkl,jb->kalb", W, np.linalg.inv(K), W).reshape(N * n, N * n)
    gradient = (H @ (x - free).reshape(-1)).reshape(N, n)
    size = max(np.abs(H).max(), 1.0)
    assert (np.abs(x) <= bound).all()
    assert np.abs(gradient[np.abs(x) < bound]).max(initial=0.0) < 1e-8 * size
    assert (gradient[x == bound * np.ones((N, 1))] < 1e-8 * size).all()
    assert (gradient[x == -bound * np.ones((N, 1))] > -1e-8 * size).all()


def test_one_at_a_time_where_blocks_do_not_settle(monkeypatch):
    """Both ways by themselves."""
    rng = np.random.default_rng(7)
    for _ in range(20):
        n, N = 3, 6
        A, B = rng.normal(size=(n, N, N)), rng.normal(size=(n, n))
        K, M = A @ np.swapaxes(A, 1, 2) + 0.01 * np.eye(N), B @ B.T + 0.1 * np.eye(n)
        K, bound, free = frozen(K), frozen(0.1 + rng.random(n)), 3 * rng.normal(size=(N, n))
        x, y, side = np.empty((N, n)), np.empty((N, n)), np.zeros((N, n), np.int64)
        assert horizon_loops.within(K, M, free, bound, x)
        work = (np.empty((18, 2), np.int64), np.empty((18, 18)), np.empty(18), np.zeros((N, n)), np.empty((2, n, N)))
        assert horizon_loops.one_by_one(K, M, free, bound, y, side, *work)
        assert np.abs(x - y).max() < 1e-9


def test_a_batch_is_its_states_one_by_one():
    rng = np.random.default_rng(4)
    robot = mf.load("planar2r")
    law = model_predictive(robot, horizon=6, effort_limit=[6.0, 3.0])
    q, qd = rng.normal(size=(2, 3, 4, 2))
    reference = Motion(*rng.normal(size=(3, 2)))
    together = law(0.0, q, qd, reference)
    assert together.shape == (3, 4, 2)
    for at in np.ndindex(3, 4):
        assert np.array_equal(together[at], law(0.0, q[at], qd[at], reference))
    assert law(0.0, q[:0], qd[:0], reference).shape == (0, 4, 2)


def test_efforts_that_cannot_be_found_are_an_error(monkeypatch):
    law = model_predictive(mf.load("planar2r"), effort_limit=[1.0, 1.0])
    q = np.ones(2)
    monkeypatch.setattr(horizon_loops, "first_efforts", lambda *arrays: 0)
    monkeypatch.setattr(horizon_loops, "plan_efforts", lambda *arrays: False)
    for action in (lambda: law(0.0, q, q, Motion(q, q, q)), lambda: law.plan(q, q, Motion(q, q, q))):
        with pytest.raises(InputError, match="best efforts"):
            action()


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


@pytest.mark.parametrize("interval", [1e-6, 1e-4, 0.02, 1.0])
def test_the_cost_of_an_endless_horizon_is_that_of_riccati_for_any_interval(interval):
    """It was cut off after 100,000 rounds, far from settled where intervals are short."""
    law = model_predictive(mf.load("planar2r"), horizon=1, interval=interval, position=3.0, rate=0.5, acceleration=2.0)
    A, B = np.array([[1.0, interval], [0.0, 1.0]]), -np.array([[interval**2 / 2.0], [interval]])
    P = solve_discrete_are(A, B, np.diag([3.0, 0.5]), [[2.0]])
    gain = np.linalg.solve(2.0 + B.T @ P @ B, B.T @ P @ A)
    np.testing.assert_allclose(law.gain, np.broadcast_to(gain, (2, 2)), rtol=1e-5)
    assert np.abs(np.linalg.eigvals(A - B @ law.gain[:1])).max() < 1.0


def test_an_interval_in_which_rounding_decides_is_refused():
    with pytest.raises(InputError, match="interval: 1e\\+06 s is too long"):
        model_predictive(mf.load("planar2r"), interval=1e6)
