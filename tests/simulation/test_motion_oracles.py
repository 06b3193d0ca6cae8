"""Motion over time against closed forms (elliptic functions) and SciPy's integrators, between the steps too."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk

import mafsil as mf
from mafsil.errors import InputError
from mafsil.simulation.motion.forward import METHOD_NAMES
from mafsil.solvers import PAIRS, Tolerance, integrate_adaptively, pair
from mafsil.solvers.solution import IntegrationStatus

START = np.array([0.2, -0.4, 0.6, 0.3, -0.5, 0.1])


@pytest.fixture(scope="module")
def arm():
    return mf.load("puma560")


@pytest.fixture(scope="module")
def planar():
    return mf.load("planar2r")


def pendulum() -> mf.Robot:
    """A point mass of 2 kg on a rod of 0.7 m that turns about y; it hangs down at zero."""
    mass, length = 2.0, 0.7
    bob = mf.model.Inertial(mass, np.array([0.0, 0.0, -length]), np.zeros((3, 3)))
    hinge = mf.model.Joint(
        "hinge", mf.model.JointKind.REVOLUTE, parent="base", child="rod", axis=np.array([0.0, 1.0, 0.0])
    )
    links = (mf.model.Link("base"), mf.model.Link("rod", inertial=bob))
    return mf.Robot(mf.Mechanism.assemble("pendulum", links, (hinge,), tip="rod"))


@pytest.mark.capability("09-7", "09-66")
@pytest.mark.parametrize(
    "options", [{}, {"momenta": True}, {"method": "rk4"}, {"method": "variational8", "step": 5e-3}]
)
def test_a_pendulum_swings_by_elliptic_functions(options):
    """q = 2 asin(k sn(K - w t, k)), k the sine of half the amplitude."""
    amplitude, w = 2.5, np.sqrt(9.81 / 0.7)
    k = np.sin(amplitude / 2.0)
    t = np.linspace(0.0, 3.0, 301)
    sn, cn, dn, _ = ellipj(ellipk(k**2) - w * t, k**2)
    q, qd = 2.0 * np.arcsin(k * sn), -2.0 * w * k * cn * dn / np.sqrt(1.0 - (k * sn) ** 2)
    moved = mf.simulation.forward_dynamics_trajectory(
        pendulum(), [amplitude], duration=3.0, **{"tolerance": 1e-12, **options}
    )
    found = moved.at(t)
    np.testing.assert_allclose(found.u[:, 0], q, atol=1e-9)
    np.testing.assert_allclose(found.v[:, 0], qd, atol=1e-8)
    np.testing.assert_allclose(found.a[:, 0], -(w**2) * np.sin(q), atol=1e-6)


@pytest.mark.capability("09-31")
def test_a_free_body_turns_by_elliptic_functions():
    """Euler's equations without moments, I1 < I2 < I3 and L^2 > 2 E I2.

    Reference: Landau and Lifshitz, Mechanics, sec. 37.
    """
    I1, I2, I3 = 0.1, 0.2, 0.25
    w1, w3 = 1.0, 3.0
    twice_E, L2 = I1 * w1**2 + I3 * w3**2, (I1 * w1) ** 2 + (I3 * w3) ** 2
    assert L2 > twice_E * I2
    rate = np.sqrt((I3 - I2) * (L2 - twice_E * I1) / (I1 * I2 * I3))
    m = (I2 - I1) * (twice_E * I3 - L2) / ((I3 - I2) * (L2 - twice_E * I1))
    body = mf.simulation.RigidBody(mf.model.Inertial(1.5, np.zeros(3), np.diag([I1, I2, I3])))
    moved = mf.simulation.free_body_motion(
        body, np.eye(4), [w1, 0.0, w3, 0.0, 0.0, 0.0], duration=20.0, tolerance=1e-13
    )
    sn, cn, dn, _ = ellipj(rate * moved.t, m)
    size1 = np.sqrt((twice_E * I3 - L2) / (I1 * (I3 - I1)))
    size2 = np.sqrt((twice_E * I3 - L2) / (I2 * (I3 - I2)))
    size3 = np.sqrt((L2 - twice_E * I1) / (I3 * (I3 - I1)))
    np.testing.assert_allclose(moved.V[:, :3], np.stack([size1 * cn, size2 * sn, size3 * dn], axis=1), atol=1e-10)


@pytest.mark.capability("09-7", "09-66")
@pytest.mark.parametrize("method", PAIRS)
def test_the_arm_moves_as_scipy_s_dop853_says(arm, method):
    def tau(t, q, qd):
        return 8.0 * np.sin(3.0 * t + np.arange(6.0)) - 2.0 * qd

    def rates(t, y):
        return np.concatenate([y[6:], arm.forward_dynamics(y[:6], y[6:], tau(t, y[:6], y[6:]))])

    start = np.concatenate([START, np.zeros(6)])
    exact = solve_ivp(rates, (0.0, 1.0), start, "DOP853", rtol=1e-12, atol=1e-13, dense_output=True)
    tolerance = 1e-7 if method == "bs23" else 1e-11
    moved = mf.simulation.forward_dynamics_trajectory(
        arm, START, tau=tau, duration=1.0, friction=False, method=method, tolerance=tolerance
    )
    t = np.random.default_rng(0).uniform(0.0, 1.0, 50)
    found = moved.at(t)
    np.testing.assert_allclose(np.concatenate([found.u, found.v], axis=1), exact.sol(t).T, atol=2e3 * tolerance)


@pytest.mark.capability("09-7")
def test_stiff_friction_agrees_with_an_implicit_method(arm):
    """Smoothed Coulomb friction decays within milliseconds; Radau is made for it."""

    def rates(t, y):
        load = -arm.friction_torque(y[6:])
        return np.concatenate([y[6:], arm.forward_dynamics(y[:6], y[6:], load)])

    start = np.concatenate([START, np.zeros(6)])
    exact = solve_ivp(rates, (0.0, 0.3), start, "Radau", rtol=1e-9, atol=1e-11)
    for method in ("dop853", "dp45"):
        moved = mf.simulation.forward_dynamics_trajectory(
            arm, START, duration=0.3, friction=True, method=method, tolerance=1e-9
        )
        assert moved.succeeded
        np.testing.assert_allclose(np.concatenate([moved.q[-1], moved.qd[-1]]), exact.y[:, -1], atol=1e-6)


@pytest.mark.capability("09-66")
@pytest.mark.parametrize("direction", [-1, 0, 1])
def test_events_are_scipy_s(planar, direction):
    def elbow(t, y):
        return np.sin(y[1]) - 0.3

    elbow.direction = direction
    start = np.array([0.3, 0.4, 0.0, 0.0])

    def rates(t, y):
        return np.concatenate([y[2:], planar.forward_dynamics(y[:2], y[2:], np.zeros(2))])

    exact = solve_ivp(rates, (0.0, 4.0), start, "DOP853", rtol=1e-12, atol=1e-13, events=elbow)
    moved = mf.simulation.forward_dynamics_trajectory(
        planar, start[:2], duration=4.0, tolerance=1e-12, events=[mf.simulation.Event(elbow, direction)]
    )
    assert len(exact.t_events[0]) >= 2
    np.testing.assert_allclose([c.t for c in moved.events], exact.t_events[0], atol=1e-8)


@pytest.mark.capability("09-63", "09-7")
def test_held_samples_are_asked_from_their_own_side(planar):
    """Efforts that jump: the motion is that of constant pieces, and a jump costs a step or two."""
    tau = 5.0 * np.random.default_rng(0).normal(size=(11, 2))
    q, qd = np.array([0.1, 0.2]), np.zeros(2)
    whole = mf.simulation.forward_dynamics_trajectory(
        planar, q, tau=mf.simulation.Sampled(tau, 0.1), duration=1.1, tolerance=1e-11
    )
    steps = 0
    for row in tau:
        piece = mf.simulation.forward_dynamics_trajectory(planar, q, qd, row, duration=0.1, tolerance=1e-12)
        q, qd, steps = piece.q[-1], piece.qd[-1], steps + piece.outcome.iterations
    np.testing.assert_allclose(whole.q[-1], q, atol=1e-9)
    np.testing.assert_allclose(whole.qd[-1], qd, atol=1e-8)
    assert whole.outcome.iterations < 1.5 * steps


@pytest.mark.parametrize("method", ["dop853", "rk4", "variational"])
def test_one_state_and_many_efforts_are_many_motions(planar, method):
    tau, wrench = np.array([[0.0, 0.0], [1.0, -1.0], [3.0, 0.5]]), np.array([0.0, 0.0, 0.1, 1.0, 2.0, 0.0])
    options = {"duration": 0.2, "tip_wrench": wrench, "method": method, "tolerance": 1e-11}
    many = mf.simulation.forward_dynamics_trajectory(planar, [0.3, 0.4], tau=tau, **options)
    assert many.q.shape[1:] == many.tau.shape[1:] == (3, 2)
    for i in range(3):
        alone = mf.simulation.forward_dynamics_trajectory(planar, [0.3, 0.4], tau=tau[i], **options)
        np.testing.assert_allclose(many.q[-1, i], alone.q[-1], atol=1e-9)


@pytest.mark.capability("09-65")
@pytest.mark.parametrize("method", ["euler", "rk4", "variational4"])
def test_the_last_fixed_step_is_shortened(planar, method):
    moved = mf.simulation.forward_dynamics_trajectory(planar, [0.3, 0.4], duration=0.1234, method=method, step=1e-3)
    assert moved.duration == pytest.approx(0.1234, abs=1e-15)
    assert len(moved.t) == 125
    exact = mf.simulation.forward_dynamics_trajectory(planar, [0.3, 0.4], duration=0.1234, tolerance=1e-12)
    bound = 3e-2 if method == "euler" else 1e-8
    np.testing.assert_allclose(moved.at(0.1234).u, exact.q[-1], atol=bound)
    np.testing.assert_allclose(moved.at(0.1231).v, exact.at(0.1231).v, atol=bound)
    short = mf.simulation.forward_dynamics_trajectory(planar, [0.3, 0.4], duration=1e-4, method=method, step=1e-3)
    assert short.t.tolist() == [0.0, 1e-4]


@pytest.mark.parametrize("method", METHOD_NAMES)
def test_every_method_stops_when_its_time_is_over(planar, method):
    moved = mf.simulation.forward_dynamics_trajectory(
        planar, [0.3, 0.4], duration=1e4, method=method, step=1e-2, seconds=0.02, tolerance=1e-12
    )
    assert moved.outcome.status is IntegrationStatus.TIME_SPENT
    assert 0.0 <= moved.duration < 1e4
    assert np.isfinite(moved.q).all()
    assert "1000" in moved.explain()


def test_a_spinning_body_ends_with_its_budget():
    body = mf.simulation.RigidBody(mf.model.Inertial(2.0, np.zeros(3), np.diag([0.1, 0.25, 0.2])))
    fast = [1e6, 0.0, 1e5, 0.0, 0.0, 0.0]
    steps = mf.simulation.free_body_motion(body, np.eye(4), fast, duration=10.0, most_steps=200)
    assert steps.outcome.status is IntegrationStatus.BUDGET_SPENT
    assert steps.outcome.iterations <= 201
    seconds = mf.simulation.free_body_motion(body, np.eye(4), fast, duration=10.0, seconds=0.02)
    assert seconds.outcome.status is IntegrationStatus.TIME_SPENT
    assert "10 s" in seconds.explain("en")
    with pytest.raises(InputError, match="V: 1e"):
        mf.simulation.free_body_motion(body, np.eye(4), np.full(6, 1e200), duration=0.1)


HOSTILE = {
    "tolerance finer than rounding": ({"tolerance": 1e-30}, "tolerance"),
    "tolerance zero": ({"tolerance": 0}, "tolerance"),
    "step that underflows": ({"step": 1e-320}, "step"),
    "step that underflows, fixed": ({"step": 1e-39, "method": "rk4"}, "most_steps"),
    "backwards": ({"duration": -1.0}, "duration"),
    "budget no number": ({"most_steps": 0.5}, "most_steps"),
    "time no number": ({"seconds": np.nan}, "seconds"),
    "events no list": ({"events": 3}, "events"),
    "events of another kind": ({"events": [3]}, "events"),
    "an event alone": ({"events": mf.simulation.Event(lambda t, y: y[0])}, "events"),
    "event is NaN": ({"events": [mf.simulation.Event(lambda t, y: np.nan, name="floor")]}, "floor"),
    "event is text": ({"events": [mf.simulation.Event(lambda t, y: "a", name="floor")]}, "floor"),
    "reset to NaN": (
        {"events": [mf.simulation.Event(lambda t, y: y[0] - 0.29, reset=lambda t, y: np.nan * y)]},
        "event.reset",
    ),
    "reset to less": (
        {"events": [mf.simulation.Event(lambda t, y: y[0] - 0.29, reset=lambda t, y: y[:1])]},
        "event.reset",
    ),
    "efforts of too many arguments": ({"tau": lambda t, q, qd, z: q}, "tau: expected a function"),
    "efforts of none": ({"tau": lambda: [0.0, 0.0]}, "tau: expected a function"),
    "another batch": ({"q": np.zeros((3, 2)), "tau": np.zeros((4, 2))}, "tau"),
    "rates of another batch": ({"q": np.zeros((3, 2)), "qd": np.zeros((4, 2))}, "qd"),
    "efforts that grow": ({"tau": lambda t: np.zeros((2, 2)) if t > 0.05 else np.zeros(2)}, "tau"),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_hostile_input_is_refused_by_name(planar, case):
    options, words = HOSTILE[case]
    with pytest.raises(InputError, match=words) as caught:
        mf.simulation.forward_dynamics_trajectory(planar, **({"q": [0.3, 0.4], "duration": 0.2} | options))
    assert caught.value.message("ar") != caught.value.message("en")


@pytest.mark.parametrize("method", ["dop853", "rk4", "variational"])
def test_efforts_that_turn_to_nan_end_the_motion_there(planar, method):
    for since in (-1.0, 0.1):
        moved = mf.simulation.forward_dynamics_trajectory(
            planar, [0.3, 0.4], tau=lambda t, s=since: np.full(2, np.nan if t > s else 0.0), duration=0.2, method=method
        )
        assert moved.outcome.status is IntegrationStatus.BLOWN_UP
        assert moved.duration == pytest.approx(max(since, 0.0), abs=2e-3)
        assert np.isfinite(moved.q).all()


def test_wrong_events_bodies_and_motions_are_named(planar):
    body = mf.simulation.RigidBody(mf.model.Inertial(2.0, np.zeros(3), np.diag([0.1, 0.25, 0.2])))
    t = np.linspace(0.0, 1.0, 5)
    for make, words in (
        (lambda: mf.simulation.Event(lambda t: t), "function"),
        (lambda: mf.simulation.Event(lambda t, y: y, reset=3), "reset"),
        (lambda: mf.simulation.free_body_motion(body, np.eye(4), np.zeros(6), lambda t: t, duration=1.0), "F"),
        (
            lambda: mf.simulation.free_body_motion(body, np.eye(4), np.zeros(6), duration=1.0, tolerance=1e-40),
            "tolerance",
        ),
        (
            lambda: mf.simulation.free_body_motion(body, np.eye(4), np.zeros(6), duration=1.0, most_steps=0),
            "most_steps",
        ),
        (lambda: mf.simulation.inverse_dynamics_trajectory(planar, lambda: t, t), "motion"),
        (
            lambda: mf.simulation.inverse_dynamics_trajectory(planar, lambda s: np.zeros((1 + int(s > 0.5), 2)), t),
            "motion",
        ),
        (lambda: mf.simulation.inverse_dynamics_trajectory(planar, lambda s: [0.0, s], []), "samples"),
        (
            lambda: mf.simulation.inverse_dynamics_trajectory(planar, lambda s: [0.0, s], t, tip_wrench=[np.nan] * 6),
            "tip_wrench",
        ),
    ):
        with pytest.raises(InputError, match=words):
            make()


@pytest.mark.parametrize("interval", [(1.0, 0.0), (0.0, 0.0), (0.0, np.nan), (0.0, np.inf)])
def test_intervals_go_forward(interval):
    with pytest.raises(InputError, match="interval"):
        integrate_adaptively(pair("dp45"), lambda t, y: -y, np.ones(1), interval)
    with pytest.raises(InputError, match="tolerance"):
        Tolerance(1e-6, 0.0)
    ended = integrate_adaptively(pair("dp45"), lambda t, y: -y, np.full(2, np.nan), (0.0, 1.0))
    assert ended.status is IntegrationStatus.BLOWN_UP
