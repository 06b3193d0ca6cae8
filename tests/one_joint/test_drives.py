"""Gears, motors and elastic joints against two-body solves, integration and eigenvalues."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

from mafsil import one_joint
from mafsil.errors import InputError
from mafsil.one_joint import ElasticJoint, Gear, Motor
from mafsil.one_joint.drives.elastic_joint import BandwidthStatus

POSITIVE = st.floats(0.1, 10.0)


@pytest.mark.capability("10-43")
@given(st.floats(1.0, 300.0), st.floats(0.3, 1.0), st.floats(-2, 2), st.floats(-100, 100))
def test_power_through_a_gear(G, eta, torque, speed):
    gear = Gear.of(G, 0.0, eta)
    out = float(gear.link_torque(torque, speed)) * float(gear.link_speed(speed))
    into = torque * speed
    expected = eta * into if into >= 0 else into / eta
    assert out == pytest.approx(expected, rel=1e-12, abs=1e-300)
    assert out <= into + 1e-12 * abs(into) + 1e-300, "power is never made: what arrives is at most what went in"


@pytest.mark.capability("10-45")
@given(st.floats(1.0, 200.0), POSITIVE, st.floats(1e-5, 1e-2), st.floats(-1, 1))
def test_two_bodies_with_a_reaction_torque(G, link, rotor, torque):
    """I_m w' = tau - r, I_l w' / G = G r: solved for both, without reflected inertias."""
    alpha, _ = np.linalg.solve([[rotor * G, 1.0], [link, -G]], [torque, 0.0])
    gear = Gear.of(G, rotor)
    assert float(gear.link_acceleration(link, torque)) == pytest.approx(alpha, rel=1e-12, abs=1e-300)
    power = float(gear.apparent_inertia(link)) * alpha * 3.0
    assert power == pytest.approx(torque * G * 3.0, rel=1e-9, abs=1e-300), "K' = (I_l + G^2 I_m) w w'"
    assert float(gear.kinetic_energy(link, 3.0)) == pytest.approx(4.5 * (link + G * G * rotor))


@pytest.mark.capability("10-46")
@given(POSITIVE, st.floats(1e-5, 1e-2))
def test_matching_is_the_best_ratio(link, rotor):
    best = float(one_joint.drives.matching_ratio(link, rotor))
    a = Gear.of([0.9 * best, best, 1.1 * best], rotor).link_acceleration(link, 1.0)
    assert a[1] > max(a[0], a[2])
    assert float(Gear.of(best, rotor).motor_share(link)) == pytest.approx(0.5)


@pytest.mark.capability("10-43", "10-44")
def test_stages_and_direct_drive():
    np.testing.assert_allclose(
        one_joint.drives.staged_efficiency([1.0, 10.0, 11.0, 100.0, 101.0]), 0.9 ** np.array([0, 1, 2, 2, 3])
    )
    np.testing.assert_allclose(Gear.of([1.0, 50.0], 1e-4, 1.0, 2e-4).reflected_friction, [2e-4, 0.5])


@pytest.mark.capability("10-47", "10-99")
def test_geared_joints_are_nearly_first_order():
    """With M / b short against the loop, the error under P control dies with b / Kp."""
    first = one_joint.ErrorDynamics.of(5.0, 2.0)
    second = one_joint.ErrorDynamics.of([0.01, 2.0], 5.0, 2.0)
    assert float(first.time_constants[0]) == pytest.approx(2.5)
    t = np.linspace(0, 10, 50)
    gap = np.abs(second.response(t, [1.0, -0.4]) - first.response(t, [1.0])).max(axis=-1)
    assert gap[0] < 2e-3
    assert gap[1] > 20 * gap[0]


@pytest.mark.capability("10-8")
def test_inner_loop_makes_torque_true():
    motor = Motor.of(0.05, 0.8, 4e-4, 24.0)
    loop = motor.current_loop(3000.0)
    t = np.linspace(0.0, 3e-3, 31)

    def circuit(_, y):
        i, total = y
        return [(loop.kp * (1 - i) + loop.ki * total - 0.8 * i) / 4e-4, 1 - i]

    peer = solve_ivp(circuit, (0, 3e-3), [0.0, 0.0], "DOP853", t, rtol=1e-11, atol=1e-13).y[0]
    np.testing.assert_allclose(loop.step_response(t), peer, atol=1e-8)
    np.testing.assert_allclose(peer, 1 - np.exp(-3000 * t), atol=1e-8)
    np.testing.assert_allclose(np.abs(loop.torque_realised([1.0, 3000.0])), [1.0, np.sqrt(0.5)], atol=1e-6)
    assert abs(loop.back_emf_torque([1.0])[0]) < 1e-4 < abs(loop.back_emf_torque([3000.0])[0])


@pytest.mark.capability("10-7", "10-44")
def test_what_a_drive_can_do():
    motor = Motor.of(0.05, 0.8, 4e-4, 24.0)
    assert float(motor.no_load_speed) == pytest.approx(480.0)
    low, high = motor.torque_range(480.0)
    assert high == pytest.approx(0.0, abs=1e-12)
    assert low == pytest.approx(-3.0)
    assert float(motor.stall_torque) == pytest.approx(1.5)
    answer = one_joint.operating_point(motor, [1.0, 1.0, -1.0], [0.0, 300.0, 300.0])
    assert [bool(each) for each in answer] == [True, False, True]
    assert "31 V" in next(each for each in answer if not each).explain()


@pytest.mark.capability("10-8", "10-30")
@given(POSITIVE, POSITIVE, POSITIVE, st.floats(0.2, 20.0))
def test_loop_through_a_slow_drive(M, kd, kp, w):
    stable = one_joint.joint_with_drive(M, kd, kp, w).stability()
    if abs(kd * w - kp) > 1e-6 * kp:
        assert bool(stable) == (kd * w > kp)


@pytest.mark.capability("10-89")
@given(POSITIVE, POSITIVE, st.floats(10.0, 1e4))
def test_modes_of_an_elastic_joint(M, B, k):
    joint = ElasticJoint.of(M, B, k)
    squares = eigh(k * np.array([[1.0, -1.0], [-1.0, 1.0]]), np.diag([M, B]), eigvals_only=True)
    assert float(joint.first_mode) == pytest.approx(np.sqrt(squares[1]), rel=1e-9)
    assert float(joint.locked_frequency) == pytest.approx(np.sqrt(k / M))


@pytest.mark.capability("10-89")
@pytest.mark.parametrize("side", ["motor", "link"])
def test_fourth_order_loops_against_their_matrices(side):
    rng = np.random.default_rng(0)
    for M, B, k, d, b, b_m, kp, kd in rng.uniform(0.1, 5.0, size=(50, 8)):
        joint = ElasticJoint.of(M, B, 20 * k, 0.1 * d, b, b_m)
        A = np.zeros((4, 4))
        A[0, 2] = A[1, 3] = 1.0
        A[2] = np.array([-20 * k, 20 * k, -0.1 * d - b, 0.1 * d]) / M
        A[3] = np.array([20 * k, -20 * k, 0.1 * d, -0.1 * d - b_m]) / B
        own = 1 if side == "motor" else 0
        A[3, own] -= kp / B
        A[3, 2 + own] -= kd / B
        loop = joint.pd_loop(kp, kd, side)
        np.testing.assert_allclose(loop.coefficients / loop.coefficients[0], np.poly(A), rtol=1e-8, atol=1e-8)
        assert bool(loop.stability()) == (np.linalg.eigvals(A).real.max() < 0)


@pytest.mark.capability("10-89", "10-30")
def test_gain_that_an_elastic_joint_bears():
    joint = ElasticJoint.of(1.0, 0.5, 400.0, 0.5, 0.1, 0.1)
    limit = float(joint.largest_kp(0.3, "link"))
    assert joint.pd_loop(0.999 * limit, 0.3, "link").stability()
    assert not joint.pd_loop(1.001 * limit, 0.3, "link").stability()
    assert np.isinf(joint.largest_kp(5.0, "motor"))
    assert joint.largest_kp(5.0, "link") == 0.0, "so much damping from the link's side destabilises by itself"


@pytest.mark.capability("10-89", "10-11")
def test_bandwidth_that_an_elastic_joint_allows():
    joint = ElasticJoint.of(1.0, 0.5, 400.0, 0.2)
    answer = joint.allowed_bandwidth([2.0, 15.0], 1.0, "motor")
    assert answer.statuses[int(answer.verdict[0])] is BandwidthStatus.ALLOWED
    assert not list(answer)[1]
    np.testing.assert_allclose(answer.by_rule, 10.0)
    assert joint.allowed_bandwidth(15.0, 1.0, "link").status is BandwidthStatus.UNSTABLE


@pytest.mark.capability("10-8")
def test_back_emf_of_a_turning_rotor_is_that_of_the_circuit():
    """L i' = u - R i - k w with u = -kp i - ki int i, by complex amplitudes: i (j w L + R + kp + ki / (j w)) = -k."""
    motor = Motor.of(0.07, 1.1, 5e-4, 24.0)
    loop = motor.current_loop(900.0)
    w = np.array([3.0, 80.0, 2500.0])
    s = 1j * w
    current = -0.07 / (s * 5e-4 + 1.1 + loop.kp + loop.ki / s)
    np.testing.assert_allclose(loop.back_emf_torque(w), 0.07 * current, rtol=1e-12)


@pytest.mark.capability("10-7", "10-44")
def test_current_voltage_and_losses_of_a_drive():
    found = one_joint.operating_point(Motor.of(0.05, 0.8, 4e-4, 24.0), [0.5, -0.2], [200.0, 100.0])
    np.testing.assert_allclose(found.current, [10.0, -4.0])
    np.testing.assert_allclose(found.voltage, [0.8 * 10.0 + 10.0, -0.8 * 4.0 + 5.0])
    np.testing.assert_allclose(found.losses, [80.0, 12.8])


@pytest.mark.capability("10-8")
def test_loop_through_a_drive_against_its_matrix():
    for M, kd, kp, w in np.random.default_rng(3).uniform(0.2, 6.0, (20, 4)):
        A = [[0.0, 1.0, 0.0], [0.0, 0.0, -1.0 / M], [w * kp, w * kd, -w]]
        loop = one_joint.joint_with_drive(M, kd, kp, w)
        np.testing.assert_allclose(loop.coefficients / loop.coefficients[0], np.poly(A), rtol=1e-10)


@pytest.mark.capability("10-43", "10-45")
def test_power_of_a_lossy_gear_goes_into_both_bodies():
    gear, link, torque, speed = Gear.of(30.0, 2e-4, 0.8), 0.5, 0.4, 1.7
    a = float(gear.link_acceleration(link, torque))
    assert a == pytest.approx(0.8 * 30.0 * 0.4 / (0.5 + 900 * 2e-4))
    power = float(gear.kinetic_power(link, speed, a))
    assert power == pytest.approx(0.8 * torque * 30.0 * speed), "efficiency times the motor's power"
    h = 1e-6
    energy = [float(gear.kinetic_energy(link, speed + side * h * a)) for side in (1, -1)]
    assert (energy[0] - energy[1]) / (2 * h) == pytest.approx(power, rel=1e-8)


@pytest.mark.capability("10-47", "10-99")
def test_a_joint_ruled_by_friction_is_of_first_order():
    joint = one_joint.ViscousJoint.of([0.01, 2.0], 5.0)
    np.testing.assert_allclose(joint.speed(3.0, load=[1.0, -2.0]), [0.4, 1.0])
    np.testing.assert_allclose(joint.time_constant(2.0), 2.5)
    np.testing.assert_allclose(joint.inertia_share(2.0), [0.01 * 2 / 25, 2.0 * 2 / 25])
    t = np.linspace(0.0, 10.0, 60)
    gap = np.abs(joint.second_order(2.0).response(t, [1.0, -0.4]) - joint.first_order(2.0).response(t, [1.0]))
    peer = solve_ivp(
        lambda _, y: [y[1], (-5 * y[1] - 2 * y[0]) / 2.0], (0, 10), [1.0, -0.4], "DOP853", t, rtol=1e-10, atol=1e-12
    )
    np.testing.assert_allclose(gap[1], np.abs(peer.y[0] - np.exp(-t / 2.5)), atol=1e-7)
    assert gap[0].max() < 2e-3 < 20 * gap[0].max() < gap[1].max()
    with pytest.raises(InputError, match="friction"):
        one_joint.ViscousJoint.of(1.0, 0.0)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Gear.of(0.0),
        lambda: Gear.of(10.0, efficiency=1.2),
        lambda: Motor.of(0.0, 1.0, 1.0, 1.0),
        lambda: ElasticJoint.of(1.0, 1.0, -5.0),
        lambda: ElasticJoint.of(1.0, 1.0, 5.0).pd_loop(1.0, 1.0, "gear"),
        lambda: one_joint.operating_point("motor", 1.0, 1.0),
        lambda: one_joint.drives.staged_efficiency(10.0, 1.0),
    ],
)
def test_wrong_input(wrong):
    with pytest.raises(InputError):
        wrong()


@pytest.mark.capability("10-89", "10-11")
@pytest.mark.parametrize("side", ["motor", "link"])
def test_the_bandwidth_of_an_elastic_joint_is_that_of_its_state_matrix(side):
    """Gains of a rigid joint on four states (q, p, q', p'): eigenvalues instead of the loop's polynomial."""
    rng, seen = np.random.default_rng(4), set()
    for _ in range(60):
        M, B, d, b, bm = rng.uniform([0.2, 0.1, 0.0, 0.0, 0.0], [2.0, 1.0, 5.0, 0.2, 0.2])
        k, w, zeta = rng.uniform(100, 900), rng.uniform(0.3, 25.0 if side == "motor" else 4.0), rng.uniform(0.4, 1.3)
        kp, kd = (M + B) * w**2, 2.0 * zeta * w * (M + B)
        A = np.zeros((4, 4))
        A[:2, 2:] = np.eye(2)
        A[2] = np.array([-k, k, -d - b, d]) / M
        A[3] = np.array([k, -k, d, -d - bm]) / B
        felt = 1 if side == "motor" else 0
        A[3, [felt, 2 + felt]] -= np.array([kp, kd]) / B
        s = np.linalg.eigvals(A)
        near = s[np.argsort(np.abs(s))[:2]]
        ratio = float((-near.real / np.abs(near)).min())
        found = ElasticJoint.of(M, B, k, d, b, bm).allowed_bandwidth(w, zeta, side)
        assert found.damping_ratio == pytest.approx(ratio, abs=1e-6)
        assert found.least_damping == pytest.approx((-s.real / np.abs(s)).min(), abs=1e-6)
        assert found.slowest == pytest.approx(-s.real.max(), abs=1e-6 * np.abs(s).max())
        assert found.by_rule == pytest.approx(np.sqrt(k / M) / 2.0, rel=1e-12)
        stable, kept = s.real.max() < 0.0, ratio >= 0.9 * min(zeta, 1.0)
        names = (BandwidthStatus.UNSTABLE, BandwidthStatus.POORLY_DAMPED, BandwidthStatus.ALLOWED)
        assert found.status is names[int(stable) + int(stable and kept)]
        seen.add(found.status)
    assert len(seen) >= 2
