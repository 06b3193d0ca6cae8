"""Laws and measures against their formulas, written out a second time: integrals, bounds, noise, delays."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

import mafsil as mf
from mafsil.control import (
    Gains,
    SpringDamper,
    TaskCoordinates,
    TaskTarget,
    add_delay,
    block_diagram,
    computed_torque,
    current_loop,
    elastic_arm,
    energy_certificate,
    force_control,
    gravity_compensation,
    hybrid_control,
    motor_feedback,
    sliding_mode,
    task_computed_torque,
    task_dynamics,
)
from mafsil.control.analysis import min_max
from mafsil.control.contact import TipForceSensor, force_error
from mafsil.control.joints import set_point_condition
from mafsil.control.laws.sliding_mode import christoffel_regressor
from mafsil.errors import InputError
from mafsil.model import Inertial, Joint, JointKind, Link, Mechanism
from mafsil.trajectory import Motion

ARM, Q, QD = mf.load("planar2r"), np.array([0.4, 1.1]), np.array([0.3, -0.5])
XY = TaskCoordinates(rows=(3, 4))
WANTED = Motion(np.array([0.7, 0.8]), np.array([0.1, 0.2]), np.array([-0.3, 0.4]))


def target(t):
    P = ARM.forward_kinematics(Q)
    P[:2, 3] += [0.05, -0.02]
    return TaskTarget(P, np.array([0, 0, 0, 0.1, 0.3, 0]), np.array([0, 0, 0, -0.2, 0.5, 0]))


@pytest.mark.capability("10-51", "10-40")
def test_computed_torque_sums_its_error():
    law, total = computed_torque(ARM, natural_frequency=[8.0, 6.0], damping_ratio=0.7, integral=[30.0, 20.0]), 0.0
    session, e, rate = law.session(0.01), WANTED.u - Q, WANTED.v - QD
    for _ in range(4):
        total = total + 0.01 * e
        qdd = ARM.forward_dynamics(Q, QD, session(0.0, Q, QD, WANTED))
        left = WANTED.a - qdd + 1.4 * np.array([8.0, 6.0]) * rate + np.array([64.0, 36.0]) * e
        np.testing.assert_allclose(left + np.array([30.0, 20.0]) * total, 0.0, atol=1e-9)


@pytest.mark.capability("10-57")
def test_computed_torque_of_the_tip_sums_its_error():
    law = task_computed_torque(ARM, target, coordinates=XY, natural_frequency=9.0, integral=[40.0, 10.0])
    session, now = law.session(0.02), task_dynamics(ARM, Q, QD, XY)
    X_e, V_e = np.array([0.05, -0.02]), np.array([0.1, 0.3]) - now.V
    for count in range(1, 4):
        qdd = ARM.forward_dynamics(Q, QD, session(0.0, Q, QD, WANTED))
        wanted = [-0.2, 0.5] + 81.0 * X_e + 18.0 * V_e + np.array([40.0, 10.0]) * X_e * 0.02 * count
        np.testing.assert_allclose(now.J @ qdd + now.J_rate @ QD, wanted, atol=1e-9)


@pytest.mark.capability("10-74")
def test_hybrid_control_sums_both_errors():
    """Blocked along n, free along t, F_e and X_e held: one tick after the other against the law written out."""
    n = np.array([[0.6, 0.8]])
    F_d, F_e, now = 10.0 * n[0], np.array([1.0, -2.0]), task_dynamics(ARM, Q, QD, XY)
    law = hybrid_control(
        ARM, target, n, F_d, coordinates=XY, gains=Gains.of(2, [50.0, 70.0], [9.0, 11.0], [20.0, 30.0]),
        sensor=lambda q, qd: F_d - F_e, force_kp=0.4, force_ki=[5.0, 6.0],
    )  # fmt: skip
    session, along = law.session(0.01), n.T @ n
    inverse = np.linalg.inv(now.inertia)
    P = np.eye(2) - n.T @ np.linalg.inv(n @ inverse @ n.T) @ n @ inverse
    X_e, V_e = np.array([0.05, -0.02]), np.array([0.1, 0.3]) - now.V
    for count in range(1, 4):
        pull = [50.0, 70.0] * X_e + [9.0, 11.0] * V_e + 0.01 * count * np.array([20.0, 30.0]) * X_e
        push = F_d + 0.4 * along @ F_e + 0.01 * count * np.array([5.0, 6.0]) * (along @ F_e)
        F = P @ now.inertia @ ([-0.2, 0.5] + (np.eye(2) - along) @ pull) + (np.eye(2) - P) @ push
        tau = now.J.T @ (F + now.velocity_force + now.gravity_force)
        np.testing.assert_allclose(session(0.0, Q, QD, WANTED), tau, atol=1e-9)


@pytest.mark.capability("10-86")
def test_bounds_of_robust_laws_are_their_formulas():
    M, c, g = ARM.mass_matrix(Q), ARM.coriolis_matrix(Q, QD), ARM.gravity_torque(Q)
    rate, growth = np.array([0.7, -0.4]), np.array([1.2, 0.5])
    Y, p = christoffel_regressor(ARM, Q, QD, rate, growth), ARM.inertial_parameters.reshape(-1)
    np.testing.assert_allclose(Y @ p, M @ growth + c @ rate + g, atol=1e-9)
    law = sliding_mode(ARM, share=0.2, rate=[5.0, 4.0], damping=[3.0, 2.0], margin=0.5, width=0.1)
    known, bound, s = law.parts(Q, QD, WANTED)
    e, e_rate = WANTED.u - Q, WANTED.v - QD
    r, growth = WANTED.v + [5.0, 4.0] * e, WANTED.a + [5.0, 4.0] * e_rate
    np.testing.assert_allclose(known, M @ growth + c @ r + g, atol=1e-9)
    np.testing.assert_allclose(s, r - QD, atol=1e-12)
    Y = christoffel_regressor(ARM, Q, QD, r, growth)
    np.testing.assert_allclose(bound, 0.2 * np.abs(Y) @ np.abs(p) + 0.5, rtol=1e-9)
    sign = np.clip(s / 0.1, -1, 1)
    np.testing.assert_allclose(law(0.0, Q, QD, WANTED), known + [3.0, 2.0] * s + bound * sign, rtol=1e-9)
    np.testing.assert_allclose(law.error_bound, [0.1 / 5, 0.1 / 4])
    places = np.stack([Q, Q + 0.5, Q - 1.0])
    sizes = np.linalg.eigvalsh(ARM.mass_matrix(places))
    best = min_max(ARM, share=0.3, rate=[5.0, 4.0], damping=[3.0, 2.0], width=0.7)
    expected = np.sqrt(0.3 * 0.7 / (4 * 2.0) * sizes.max() / sizes.min())
    assert best.surface_bound(places) == pytest.approx(expected, rel=1e-12)
    np.testing.assert_allclose(best.error_bound(places), expected / np.array([5.0, 4.0]), rtol=1e-12)
    other = mf.Robot(ARM.mechanism.with_payload(3.0))
    assert best.surface_bound(places, other) != pytest.approx(expected, rel=1e-3)


@pytest.mark.capability("10-53")
def test_an_energy_that_rises_and_the_balance_of_what_was_lost():
    law, goal = gravity_compensation(ARM, [30.0, 20.0], [6.0, 4.0]), np.array([0.9, -0.5])
    t = np.sort(np.r_[0.0, 2.0, np.random.default_rng(1).uniform(0, 2, 400)])
    q = goal + 0.1 * np.exp(0.3 * t)[:, None] * np.array([1.0, -1.0])
    qd = 0.3 * (q - goal)
    proof = energy_certificate(ARM, law, goal, t, q, qd, viscous=[0.5, 0.25])
    assert not proof
    assert proof.status.name == "RISES"
    lost = [quad(lambda s: 0.0009 * np.exp(0.6 * s) * (6.5 + 4.25), 0.0, one)[0] for one in t[::50]]
    np.testing.assert_allclose(proof.balance[::50], proof.energy[0] - proof.energy[::50] - lost, atol=1e-8)


@pytest.mark.capability("10-64", "10-65")
def test_force_errors_of_coupled_gains_against_their_loop():
    """(I + Kfp) F_e + Kfi int F_e = -w, integrated; by single gains where the matrices are diagonal."""
    kp, ki, w = np.array([[0.5, 0.2], [0.1, 0.8]]), np.array([[6.0, -1.0], [2.0, 9.0]]), np.array([3.0, -2.0])
    t = np.array([0.0, 0.1, 0.5, 40.0])
    slope = solve_ivp(
        lambda _, y: np.linalg.solve(np.eye(2) + kp, -w - ki @ y), (0, 40), [0, 0], "LSODA", t, rtol=1e-11, atol=1e-13
    ).y.T
    expected = np.linalg.solve(np.eye(2) + kp, (-w - slope @ ki.T).T).T
    np.testing.assert_allclose(force_error(kp, ki, w, t), expected, atol=1e-8)
    np.testing.assert_allclose(force_error(kp, ki, w, 0.1), expected[1], atol=1e-8)
    plain = [force_error(0.5, [6.0, 9.0], w, one) for one in t]
    np.testing.assert_allclose(force_error(0.5, np.diag([6.0, 9.0]), w, t), plain, atol=1e-12)
    with pytest.raises(InputError, match="disturbance"):
        force_error(kp, ki, [1.0, 2.0, 3.0], t)


@pytest.mark.capability("10-64")
def test_a_force_law_with_matrices_of_gains():
    robot, q = mf.load("ur5e"), np.array([0.3, -1.2, 1.2, 0.4, 1.0, 0.2])
    rng, qd = np.random.default_rng(0), np.linspace(0.3, -0.2, 6)
    P, I, D = (root @ root.T for root in rng.normal(size=(3, 6, 6)))
    wrench, felt = rng.normal(size=(2, 6))
    law = force_control(robot, wrench, sensor=lambda q, qd: felt, kp=P, ki=I, damping=D)
    session, J = law.session(0.01), robot.jacobian_body(q)
    for count in range(1, 3):
        F = wrench + (P + 0.01 * count * I) @ (wrench - felt) - D @ J @ qd
        np.testing.assert_allclose(session(0.0, q, qd, WANTED), robot.gravity_torque(q) + J.T @ F, atol=1e-9)
    single = force_control(robot, wrench, sensor=lambda q, qd: felt, kp=0.5, damping=[1, 2, 3, 4, 5, 6])
    same = force_control(
        robot, wrench, sensor=lambda q, qd: felt, kp=0.5 * np.eye(6), damping=np.diag([1, 2, 3, 4, 5, 6])
    )
    np.testing.assert_allclose(single(0.0, q, qd, WANTED), same(0.0, q, qd, WANTED), atol=1e-12)
    assert np.abs(block_diagram(law).effort(0.0, q, qd, WANTED) - law(0.0, q, qd, WANTED)).max() < 1e-9
    with pytest.raises(InputError, match="kp"):
        force_control(robot, wrench, sensor=lambda q, qd: felt, kp=-np.eye(6))


@pytest.mark.capability("10-63")
def test_noise_of_a_force_sensor_and_the_axes_that_it_reads_in():
    spring = SpringDamper(
        ARM.forward_kinematics(Q)[:3, 3] + [0.01, 0.02, 0.0], stiffness=[300.0, 500.0, 1.0], damping=7.0
    )
    task = TaskCoordinates()
    still = TipForceSensor(ARM, spring, task)(Q, QD)
    v = (task.jacobian(ARM, Q) @ QD)[3:]
    np.testing.assert_allclose(still[3:], -(np.array([300.0, 500.0, 1.0]) * [0.01, 0.02, 0.0] - 7.0 * v), atol=1e-9)
    noisy = TipForceSensor(ARM, spring, task, noise=2.0, seed=3)
    readings = noisy(np.tile(Q, (20_000, 1)), np.tile(QD, (20_000, 1))) - still
    np.testing.assert_allclose(readings.std(axis=0), [0.2, 0.2, 0.2, 2.0, 2.0, 2.0], rtol=0.03)
    assert np.abs(readings.mean(axis=0)).max() < 0.05


@pytest.mark.capability("10-93", "10-8")
def test_late_efforts_and_those_of_a_drive():
    class Ramp:
        def __call__(self, t, q, qd, reference):
            return np.full(2, t)

        def session(self, period):
            return self

    session = add_delay(Ramp(), 0.03).session(0.01)
    got = [float(session(0.01 * k, Q, QD, WANTED)[0]) for k in range(8)]
    np.testing.assert_allclose(got[3:], 0.01 * np.arange(5), atol=1e-12)
    assert got[:3] == [0.0, 0.0, 0.0]
    # A drive of bandwidth w follows a ramp with a lag of 1 / w in the end.
    drive = current_loop(Ramp(), 40.0).session(0.001)
    end = [float(drive(0.001 * k, Q, QD, WANTED)[0]) for k in range(1000)][-1]
    assert end == pytest.approx(0.999 - 1 / 40.0, abs=1e-3)


@pytest.mark.capability("10-89")
def test_the_steepest_gravity_of_a_pendulum():
    body = Inertial(2.0, np.array([0.3, 0.0, 0.0]), 0.01 * np.eye(3))
    hinge = Joint("hinge", JointKind.REVOLUTE, "base", "arm")
    pendulum = mf.Robot(
        Mechanism.assemble("pendulum", [Link("base"), Link("arm", body)], [hinge], gravity=(0, -9.81, 0))
    )
    found = set_point_condition(motor_feedback(elastic_arm(pendulum, 50.0, motor_inertia=0.1), 30.0, 2.0))
    assert found.gravity == pytest.approx(2.0 * 9.81 * 0.3, rel=1e-4)
    assert found.stiffness == pytest.approx(np.linalg.eigvalsh([[50.0, -50.0], [-50.0, 80.0]])[0])
