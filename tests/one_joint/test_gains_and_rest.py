"""Gains do what they were designed for; errors at rest and behind references against the loop itself."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

import mafsil as mf
from mafsil import one_joint
from mafsil.errors import InputError
from mafsil.one_joint import ErrorDynamics, SecondOrder, routh_hurwitz
from mafsil.one_joint.gain_design import DesignStatus
from mafsil.one_joint.steady_error import RestStatus

POSITIVE = st.floats(0.05, 20.0)


@pytest.mark.capability("10-28")
@given(POSITIVE, st.floats(0.2, 3.0), st.floats(0.05, 5.0), st.floats(0.0, 0.5))
def test_gains_for_damping_and_settling(M, zeta, T, b):
    gains = one_joint.pd_for_settling(M, b, zeta, T)
    loop = SecondOrder.of_joint(M, b + gains.kd, gains.kp)
    assert float(loop.damping_ratio) == pytest.approx(zeta, rel=1e-9)
    assert float(loop.settling_time()) == pytest.approx(T, rel=1e-7)
    assert bool(gains) == (float(gains.kd) >= 0)


@pytest.mark.capability("10-100")
@given(POSITIVE, st.floats(0.0, 2.0), st.floats(-9, -0.1), st.floats(-5, -0.1), st.floats(0, 6))
def test_gains_from_roots(M, b, real, sigma, w):
    wanted = np.array([real, sigma + 1j * w, sigma - 1j * w])
    gains = one_joint.gains_from_roots(M, b, wanted)
    closed = ErrorDynamics.of(M, b + gains.kd, gains.kp, gains.ki)
    np.testing.assert_allclose(np.poly(wanted).real, closed.coefficients / M, rtol=1e-9, atol=1e-12)
    assert (gains.status is DesignStatus.DESIGNED) == (float(gains.kd) >= 0)


@pytest.mark.capability("10-100")
def test_refused_designs_say_why():
    slow = one_joint.gains_from_roots(0.5, 3.0, [-0.1, -0.2])
    assert slow.status is DesignStatus.TOO_MUCH_FRICTION
    assert "-2.85" in slow.explain()
    growing = one_joint.gains_from_roots(0.5, 0.0, [[0.5, -1.0], [-1.0, -1.0]])
    integral = one_joint.gains_from_roots(0.5, 0.1, [1.0, -2.0, -5.0])  # Kp = 1.5 and Kd = 2.9, but Ki = -5
    assert integral.status is DesignStatus.NEGATIVE_GAIN
    assert float(integral.ki) == pytest.approx(-5.0)
    assert [bool(each) for each in growing] == [False, True]
    with pytest.raises(InputError, match="conjugate"):
        one_joint.gains_from_roots(0.5, 0.0, [1j, 2.0])
    with pytest.raises(InputError):
        one_joint.gains_from_roots(0.5, 0.0, [1.0])


@pytest.mark.capability("10-33")
@given(POSITIVE, POSITIVE, POSITIVE)
def test_limit_of_the_integral_gain(M, d, kp):
    limit = float(one_joint.ki_limit(M, d, kp))
    assert bool(routh_hurwitz([M, d, kp, 0.999 * limit]))
    assert not routh_hurwitz([M, d, kp, 1.001 * limit])


@pytest.mark.capability("10-31", "10-110")
@given(POSITIVE, st.floats(-5, 5).filter(lambda x: not 0.0 < abs(x) < 1e-30), st.floats(-4, 4))
def test_rest_under_gravity_balances(kp, load, goal):
    rest = one_joint.steady_state_error(kp, load, goal)
    e = float(rest.error)
    assert abs(kp * e - load * np.cos(goal - e)) < 1e-9 * max(1.0, abs(load))
    assert (rest.status is RestStatus.UNIQUE) == (kp > abs(load))
    enough = one_joint.kp_for_rest_error(abs(load), 0.01)
    if load:
        assert abs(float(one_joint.steady_state_error(enough, load, goal).error)) <= 0.01 * (1 + 1e-12)


@pytest.mark.capability("10-31")
def test_rest_of_an_arm():
    panda = mf.load("panda")
    kp, goal = np.full(7, 400.0), np.array([0.1, 0.4, -0.3, -1.5, 0.2, 1.4, 0.3])
    rest = one_joint.steady_state_of_joints(kp, panda.gravity_torque, goal)
    assert rest.status is one_joint.steady_error.RestStatus.FOUND, "whether there are others was not looked at"
    np.testing.assert_allclose(kp * rest.error, panda.gravity_torque(goal - rest.error), atol=1e-9)


@pytest.mark.capability("10-109", "10-36")
@pytest.mark.parametrize("ki", [0.0, 1.0])
def test_tracking_errors_against_integration(ki):
    tracking = one_joint.TrackingError.of(0.5, 0.1, 2.205, ki, 2.0)
    phasor = tracking.sine([2.0])[0]

    def loop(t, y):
        error, rate = np.sin(2 * t) - y[0], 2 * np.cos(2 * t) - y[1]
        return [y[1], (2.205 * error + 2.0 * rate + ki * y[2] - 0.1 * y[1]) / 0.5, error]

    t = np.linspace(60.0, 64.0, 9)
    y = solve_ivp(loop, (0, 64), [0, 0, 0], "DOP853", t, rtol=1e-11, atol=1e-12).y
    np.testing.assert_allclose(np.sin(2 * t) - y[0], (phasor * np.exp(2j * t)).imag, atol=1e-8)


@pytest.mark.capability("10-110")
def test_a_gain_for_a_rest_error_asks_the_drive():
    kp = one_joint.kp_for_rest_error([0.5, 2.0], 0.02, torque_limit=1.0)
    assert kp[0] == pytest.approx(25.0)
    assert np.isnan(kp[1]), "the drive cannot hold the link, whatever the gain"
    assert one_joint.kp_for_rest_error(2.0, 0.02) == pytest.approx(100.0)
    with pytest.raises(InputError, match="torque_limit"):
        one_joint.kp_for_rest_error(1.0, 0.1, torque_limit=0.0)


@pytest.mark.capability("10-31")
def test_rest_of_joints_that_a_matrix_of_gains_holds():
    K = np.array([[40.0, 7.0], [7.0, 25.0]])

    def gravity(q):
        return np.array([3.0 * np.cos(q[0]) + np.cos(q[0] + q[1]), np.cos(q[0] + q[1])])

    goal = np.array([0.4, -0.9])
    rest = one_joint.steady_state_of_joints(K, gravity, goal)
    found = fsolve(lambda e: K @ e - gravity(goal - e), np.zeros(2), xtol=1e-13)
    np.testing.assert_allclose(rest.error, found, atol=1e-10)
    np.testing.assert_allclose(rest.torque, K @ found, atol=1e-9)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: one_joint.kp_for_damping_ratio(0.5, 2.0, 0.0),
        lambda: one_joint.ki_limit(0.5, -1.0, 2.0),
        lambda: one_joint.steady_state_error(0.0, 1.0, 0.0),
        lambda: one_joint.steady_state_of_joints(1.0, 3.0, [0.0]),
        lambda: one_joint.TrackingError.of(0.5, 0.1, np.nan),
        lambda: one_joint.TrackingError.of(0.5, 0.1, 1.0).sine([0.0]),
        lambda: one_joint.pd_for_settling(0.5, 0.1, 1.0, 1.0, band=2.0),
    ],
)
def test_wrong_input(wrong):
    with pytest.raises(InputError):
        wrong()
