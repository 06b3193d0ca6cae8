"""Forward and inverse dynamics over time against closed forms, each other and conservation laws."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mafsil as mf
from mafsil.errors import InputError
from mafsil.simulation import Plant
from mafsil.simulation.motion import differentiate
from mafsil.simulation.motion.forward import METHOD_NAMES
from mafsil.simulation.motion.system import DrivenRobot
from mafsil.solvers import PAIRS, Event

HOME = np.array([0.2, -0.4, 0.6, 0.3, -0.5, 0.1])


@pytest.fixture(scope="module")
def arm():
    return mf.load("puma560")


@pytest.fixture(scope="module")
def planar():
    return mf.load("planar2r_point_masses")


def end_of(robot, **options):
    settings = {"duration": 0.25, "q": [-1.2, 0.3], "qd": [0.5, -0.2]} | options
    moved = mf.simulation.forward_dynamics_trajectory(robot, **settings)
    assert moved.succeeded
    return np.concatenate([moved.q[-1], moved.qd[-1]])


@pytest.mark.capability("09-7", "09-66")
@pytest.mark.parametrize("method", METHOD_NAMES)
def test_every_integrator_finds_the_same_motion(planar, method):
    reference = end_of(planar, tolerance=1e-13)
    options = {} if method in PAIRS else {"step": 0.25 / 512}
    order = {"euler": 1, "semi_implicit_euler": 1, "midpoint": 2, "heun": 2, "variational": 2}.get(method, 4)
    error = np.abs(end_of(planar, method=method, **options) - reference).max()
    assert error < {1: 3e-2, 2: 3e-5, 4: 3e-8}[order]


@pytest.mark.row("R10")
@pytest.mark.parametrize(
    ("method", "order", "span", "counts"),
    [
        ("euler", 1, 0.25, (2000, 4000)),
        ("semi_implicit_euler", 1, 0.25, (2000, 4000)),
        ("midpoint", 2, 0.25, (200, 400)),
        ("heun", 2, 0.25, (200, 400)),
        ("rk4", 4, 0.5, (100, 200)),
        ("variational", 2, 0.25, (100, 200)),
        ("variational4", 4, 0.5, (40, 80)),
        ("variational6", 6, 1.0, (30, 60)),
        ("variational8", 8, 2.0, (32, 64)),
    ],
)
def test_measured_order_on_an_arm(planar, method, order, span, counts):
    reference = end_of(planar, duration=span, tolerance=1e-14)
    errors = [np.abs(end_of(planar, duration=span, method=method, step=span / n) - reference).max() for n in counts]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)


@pytest.mark.capability("09-65", "09-63", "09-60")
def test_euler_with_sampled_efforts_is_the_textbook_s_recursion(arm):
    """theta_k+1 = theta_k + h thetadot_k, thetadot_k+1 = thetadot_k + h GetJointAccel(theta_k, ...)."""
    rng, h, steps = np.random.default_rng(2), 1e-3, 50
    tau, wrench = 5.0 * rng.normal(size=(steps + 1, 6)), 2.0 * rng.normal(size=(steps + 1, 6))
    moved = mf.simulation.forward_dynamics_trajectory(
        arm,
        HOME,
        tau=mf.simulation.Sampled(tau, h),
        tip_wrench=mf.simulation.Sampled(wrench, h),
        duration=h * steps,
        friction=False,
        method="euler",
        step=h,
    )
    q, qd = HOME.copy(), np.zeros(6)
    for k in range(steps):
        np.testing.assert_allclose(moved.q[k], q, rtol=0, atol=1e-12)
        qdd = arm.forward_dynamics(q, qd, tau[k], wrench[k])
        np.testing.assert_allclose(moved.qdd[k], qdd, rtol=1e-9, atol=1e-9)
        np.testing.assert_array_equal(moved.tau[k], tau[k])
        q, qd = q + h * qd, qd + h * qdd
    np.testing.assert_allclose(moved.qd[-1], qd, rtol=0, atol=1e-11)
    assert len(moved.t) == steps + 1


@pytest.mark.capability("09-6", "09-7")
def test_inverse_and_forward_dynamics_undo_each_other(arm):
    trajectory = mf.trajectory.quintic(HOME, HOME + 0.4, 0.6)
    wrench = [0.1, -0.2, 0.3, 4.0, 5.0, -6.0]
    wanted = mf.simulation.inverse_dynamics_trajectory(arm, trajectory, np.linspace(0.0, 0.6, 101), tip_wrench=wrench)

    def tau(t):
        return mf.simulation.inverse_dynamics_trajectory(arm, trajectory, [t], tip_wrench=wrench).tau[0]

    for momenta in (False, True):
        moved = mf.simulation.forward_dynamics_trajectory(
            arm, wanted.q[0], wanted.qd[0], tau, tip_wrench=wrench, duration=0.6, tolerance=1e-11, momenta=momenta
        )
        found = moved.at(wanted.t)
        np.testing.assert_allclose(found.u, wanted.q, atol=1e-7)
        np.testing.assert_allclose(found.v, wanted.qd, atol=1e-6)
        np.testing.assert_allclose(found.a, wanted.qdd, atol=1e-4)


@pytest.mark.capability("09-6")
def test_efforts_of_sampled_motions_by_differentiation(arm):
    trajectory, t = mf.trajectory.quintic(HOME, HOME + 0.4, 1.0), np.linspace(0.0, 1.0, 201)
    exact = mf.simulation.inverse_dynamics_trajectory(arm, trajectory, t, friction=False)
    for given in ({}, {"qd": exact.qd}, {"qd": exact.qd, "qdd": exact.qdd}):
        np.testing.assert_allclose(
            mf.simulation.inverse_dynamics_trajectory(arm, exact.q, t, friction=False, **given).tau,
            exact.tau,
            rtol=1e-6,
            atol=1e-6,
        )
    of_function = mf.simulation.inverse_dynamics_trajectory(arm, lambda s: trajectory.at(s).u, t, friction=False)
    np.testing.assert_allclose(of_function.tau, exact.tau, rtol=1e-6, atol=1e-6)
    # Power is the change of energy: nothing is lost without friction.
    energy = arm.kinetic_energy(exact.q, exact.qd) + arm.potential_energy(exact.q)
    np.testing.assert_allclose(exact.power, differentiate(t, energy), atol=1e-4)


@pytest.mark.parametrize("order", [1, 2])
def test_differences_are_exact_for_polynomials_on_any_grid(order):
    t = np.sort(np.random.default_rng(0).uniform(0, 1, 30))
    p = np.polynomial.Polynomial([1.0, -2.0, 0.5, 3.0, -1.0, 0.7, 0.2])
    found = differentiate(t, np.stack([p(t), 2 * p(t)], axis=-1), order)
    np.testing.assert_allclose(found[:, 0], p.deriv(order)(t), rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(found[:, 1], 2 * found[:, 0], rtol=1e-9)
    np.testing.assert_allclose(differentiate([0.0, 1.0, 3.0], [0.0, 1.0, 9.0], order), p.deriv(0)(0) * 0 + [
        [0.0, 2.0, 6.0], [2.0, 2.0, 2.0]][order - 1], atol=1e-12)  # fmt: skip


@pytest.mark.row("R10")
def test_momentum_about_a_free_axis_is_kept(arm):
    """Without gravity nothing turns the first joint's momentum: exactly constant in momenta and for the variational."""
    from dataclasses import replace

    free = mf.Robot(replace(arm.mechanism, gravity=np.zeros(3)))
    rates = np.array([0.5, -0.3, 0.7, 2.0, -1.0, 3.0])
    for options, limit in (
        ({"momenta": True, "tolerance": 1e-12}, 1e-15),
        ({"method": "variational", "step": 2e-3}, 1e-13),
        ({"method": "variational4", "step": 4e-3}, 1e-13),
    ):
        moved = mf.simulation.forward_dynamics_trajectory(free, HOME, rates, duration=2.0, friction=False, **options)
        p = np.einsum("kij,kj->ki", free.mass_matrix(moved.q), moved.qd)
        assert np.abs(p[:, 0] - p[0, 0]).max() < max(limit, 1e-14) * 100 * np.abs(p).max()
        raw = moved.outcome.value.y[:, 6]
        assert not options.get("momenta") or np.ptp(raw) == 0.0


@pytest.mark.parametrize("method", ["dop853", "rk4", "variational"])
def test_batches_equal_single_motions(arm, method):
    starts = HOME + 0.1 * np.random.default_rng(1).normal(size=(3, 6))
    whole = mf.simulation.forward_dynamics_trajectory(
        arm, starts, duration=0.2, friction=False, method=method, tolerance=1e-12
    )
    for row in range(3):
        alone = mf.simulation.forward_dynamics_trajectory(
            arm, starts[row], duration=0.2, friction=False, method=method, tolerance=1e-12
        )
        np.testing.assert_allclose(whole.at(0.2).u[row], alone.at(0.2).u, atol=1e-9)
    assert whole.energy.shape == (len(whole.t), 3)


@pytest.mark.parametrize("options", [{}, {"momenta": True}, {"method": "rk4"}, {"method": "variational"}])
def test_the_arm_hits_the_floor_where_the_event_says(planar, options):
    def height(t, y):
        q = y[:2]
        return np.sin(q[0]) + np.sin(q[0] + q[1]) + 0.5

    moved = mf.simulation.forward_dynamics_trajectory(
        planar, [0.5, 0.2], duration=2.0, events=[Event(height, -1, terminal=True, name="floor")], **options
    )
    assert moved.outcome.status.name == "EVENT"
    assert height(0.0, np.append(moved.q[-1], 0.0)) == pytest.approx(0.0, abs=1e-9)
    assert moved.events[0].t == moved.t[-1] == moved.duration
    assert np.all(np.diff(moved.t) > 0.0)


def test_a_reset_is_an_impact_in_rates_and_in_momenta(planar):
    def reversed_rates(t, y):
        return np.concatenate([y[:2], -0.5 * y[2:]])

    stop = Event(lambda t, y: y[0] + 0.5, -1, reset=reversed_rates)
    ends = [
        mf.simulation.forward_dynamics_trajectory(
            planar, [0.0, 0.3], duration=0.6, events=[stop], tolerance=1e-12, momenta=momenta
        )
        for momenta in (False, True)
    ]
    assert len(ends[0].events) == len(ends[1].events) >= 1
    np.testing.assert_allclose(ends[0].q[-1], ends[1].q[-1], atol=1e-7)
    with pytest.raises(InputError, match="adaptive"):
        mf.simulation.forward_dynamics_trajectory(planar, [0.0, 0.3], duration=0.1, events=[stop], method="rk4")


@pytest.mark.parametrize("method", ["dop853", "rk4", "variational"])
@pytest.mark.parametrize("batch", [(), (2,)])
def test_a_blow_up_ends_at_the_last_good_state(planar, method, batch):
    def feedback(t, q, qd):
        return 1e3 * qd * np.abs(qd)

    with np.errstate(all="ignore"):
        moved = mf.simulation.forward_dynamics_trajectory(
            planar, np.full((*batch, 2), 0.3), np.ones((*batch, 2)), feedback, duration=5.0, method=method, seconds=20.0
        )
    assert not moved.succeeded
    assert np.isfinite(moved.q).all()
    assert np.isfinite(moved.qd).all()
    assert moved.duration < 5.0
    assert moved.explain("en") != moved.explain("ar")


def test_friction_takes_energy_and_comes_from_the_description(arm):
    assert Plant(arm).has_friction
    lossy, free = (
        mf.simulation.forward_dynamics_trajectory(
            arm, HOME, duration=0.05, friction=friction, method="dp45", tolerance=1e-8, most_steps=200_000
        )
        for friction in (True, False)
    )
    assert lossy.succeeded
    assert free.energy_drift < 1e-6
    assert np.diff(lossy.energy).max() < 1e-7
    assert lossy.energy[-1] < lossy.energy[0]


def test_friction_acts_unless_left_out():
    """The equation on the page has friction in it: a joint with Coulomb friction falls slower, without a switch."""
    hinge = mf.Robot.from_screws(
        [[0, 0, 1, 0, 0, 0]],
        np.eye(4),
        inertials=[mf.model.Inertial(1.0, np.array([0.3, 0.0, 0.0]), np.diag([0.01] * 3))],
        frictions=[mf.model.Friction(viscous=0.3)],
        gravity=[0, -9.81, 0],
    )
    inertia, t = 0.01 + 0.09, np.linspace(0.0, 1.0, 5)
    exact = solve_ivp(
        lambda _, y: [y[1], (-0.3 * 9.81 * np.cos(y[0]) - 0.3 * y[1]) / inertia],
        (0, 1), [0.0, 0.0], t_eval=t, rtol=1e-11, atol=1e-12,
    )  # fmt: skip
    moved = mf.simulation.forward_dynamics_trajectory(hinge, [0.0], duration=1.0, tolerance=1e-11)
    np.testing.assert_allclose(moved.at(t).u[:, 0], exact.y[0], atol=1e-8)
    needed = mf.simulation.inverse_dynamics_trajectory(hinge, np.linspace(0, 1, 7)[:, None], np.linspace(0, 1, 7))
    free = mf.simulation.inverse_dynamics_trajectory(
        hinge, np.linspace(0, 1, 7)[:, None], np.linspace(0, 1, 7), friction=False
    )
    np.testing.assert_allclose(needed.tau - free.tau, 0.3, atol=1e-10)


def test_variational_methods_refuse_coulomb_friction(arm):
    with pytest.raises(InputError, match="joint1 has Coulomb friction"):
        mf.simulation.forward_dynamics_trajectory(arm, HOME, duration=0.1, method="variational")


def test_loads_agree_between_rates_and_momenta(arm):
    rng = np.random.default_rng(3)
    q, qd, tau, wrench = rng.normal(size=6), rng.normal(size=6), rng.normal(size=6), rng.normal(size=6)
    system = DrivenRobot(arm, lambda t, q, qd: tau, lambda t, q, qd: wrench, True)
    p = system.momentum(q, qd)
    rate = system.momentum_rates(0.0, np.concatenate([q, p]))
    np.testing.assert_allclose(rate[:6], qd, rtol=1e-12)
    C = arm.coriolis_matrix(q, qd)
    wanted = arm.mass_matrix(q) @ system.acceleration(0.0, q, qd) + (C + C.T) @ qd
    np.testing.assert_allclose(rate[6:], wanted, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"method": "magic"}, "dop853"),
        ({"duration": -1.0}, "duration"),
        ({"step": 0.0}, "step"),
        ({"tau": [1.0, 2.0, 3.0]}, "tau"),
        ({"tau": lambda t: [1.0]}, "tau"),
        ({"tip_wrench": [1.0]}, "tip_wrench"),
        ({"tau": mf.simulation.Sampled(np.zeros((3, 5)), 0.1)}, "tau"),
        ({"method": "rk4", "momenta": True}, "momenta"),
        ({"method": "rk4", "most_steps": 10}, "most_steps"),
        ({"qd": [np.nan, 0.0]}, "qd"),
    ],
)
def test_wrong_arguments_are_named(planar, options, word):
    with pytest.raises(InputError, match=word) as caught:
        mf.simulation.forward_dynamics_trajectory(planar, **({"q": [0.1, 0.2], "duration": 1.0} | options))
    assert caught.value.message("ar") != caught.value.message("en")


@pytest.mark.parametrize(
    "make",
    [
        lambda r: mf.simulation.Sampled([1.0, 2.0], 0.1),
        lambda r: mf.simulation.Sampled([[1.0]], -1.0),
        lambda r: mf.simulation.inverse_dynamics_trajectory(r, [[0.0, 0.0]] * 3, [0.0, 0.0, 1.0]),
        lambda r: mf.simulation.inverse_dynamics_trajectory(r, [[0.0, 0.0]] * 2, [0.0, 1.0]),
        lambda r: mf.simulation.inverse_dynamics_trajectory(r, [[0.0, 0.0]] * 2, [0.0, 1.0, 2.0]),
        lambda r: mf.simulation.inverse_dynamics_trajectory(r, [[0.0, 0.0]] * 3, [0.0, 1.0, 2.0], qd=[[0.0, 0.0]] * 2),
    ],
)
def test_wrong_samples_are_named(planar, make):
    with pytest.raises(InputError) as caught:
        make(planar)
    assert caught.value.message("ar") != caught.value.message("en")


def test_samples_are_held_or_joined():
    held, joined = (
        mf.simulation.Sampled([[0.0], [2.0], [4.0]], 0.5),
        mf.simulation.Sampled([[0.0], [2.0], [4.0]], 0.5, joined=True),
    )
    assert [held.at(t)[0] for t in (-1, 0, 0.49, 0.5, 0.99, 1.0, 9.0)] == [0, 0, 0, 2, 2, 4, 4]
    assert [joined.at(t)[0] for t in (-1, 0.25, 0.5, 0.75, 9.0)] == [0, 1, 2, 3, 4]
    np.testing.assert_allclose(held.breaks, [0.5, 1.0])
