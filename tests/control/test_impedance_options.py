"""Impedances by frequency, references that move, and virtual masses that move by themselves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import (
    Gains,
    Impedance,
    TaskCoordinates,
    TaskTarget,
    admittance_control,
    hold_pose,
    impedance_by_force,
    impedance_control,
    task_dynamics,
)
from mafsil.control.contact import TipForceSensor
from mafsil.model import Friction
from mafsil.simulation import Plant, RigidPlant, RigidSurface, Scenario, simulate
from mafsil.trajectory.profiles import rest

ARM, Q = mf.load("planar2r"), np.array([0.4, 1.1])
XY = TaskCoordinates(rows=(3, 4))
T = ARM.forward_kinematics(Q)
PUSH = np.array([3.0, -2.0])


def pushed(q, qd):
    return np.broadcast_to(PUSH, (*np.shape(q)[:-1], 2))


class Hand:
    """The same force on the tip."""

    def wrench(self, T, V):
        force = np.array([*PUSH, 0.0])
        turned = (np.swapaxes(T[..., :3, :3], -1, -2) @ force[..., None])[..., 0]
        return np.concatenate([np.zeros_like(turned), turned], axis=-1)


def swinging(t):
    P = T.copy()
    P[0, 3] += 0.1 * np.sin(2 * t)
    V, A = np.zeros(6), np.zeros(6)
    V[3], A[3] = 0.2 * np.cos(2 * t), -0.4 * np.sin(2 * t)
    return TaskTarget(P, V, A)


@pytest.mark.capability("10-76", "10-77")
def test_an_impedance_is_a_spring_when_slow_and_a_mass_when_fast():
    m, b, k = np.array([[2.0, 0.3], [0.3, 1.0]]), [3.0, 5.0], [800.0, 300.0]
    Z = Impedance.of(2, inertia=m, damping=b, stiffness=k)
    w = np.array([1e-3, 7.0, 1e5])
    for at, exact in zip(w, Z.frequency_response(w), strict=True):
        s = 1j * at
        np.testing.assert_allclose(exact, m * s**2 + np.diag(b) * s + np.diag(k), rtol=1e-12)
    spring, mass = Z.asymptotes(w)
    np.testing.assert_allclose(spring, np.broadcast_to(np.diag(k), (3, 2, 2)))
    np.testing.assert_allclose(mass, -(w**2)[:, None, None] * m)
    np.testing.assert_allclose(Z.frequency_response(w)[0], spring[0], atol=1e-2)
    np.testing.assert_allclose(Z.frequency_response(w)[2], mass[2], rtol=1e-3, atol=1e6)
    np.testing.assert_allclose(
        Z.admittance(w) @ Z.frequency_response(w), np.broadcast_to(np.eye(2), (3, 2, 2)), atol=1e-9
    )
    # Without damping nothing holds back at resonance.
    free = Impedance.of(1, inertia=2.0, stiffness=50.0)
    assert np.isinf(free.admittance(5.0)).all()
    assert free.admittance(10.0)[0, 0] == pytest.approx(-1 / 150.0)


@pytest.mark.capability("10-79", "10-78", "10-81")
@pytest.mark.parametrize("shift", [False, True])
@pytest.mark.parametrize("axes", ["decoupled", "body"])
def test_what_is_measured_from_a_moving_reference(shift, axes):
    """D dV/dt + B (V - V_d) + K (X - X_d) = F, or D (dV/dt - A_d) + ...: by the arm's own forward dynamics."""
    task = TaskCoordinates(axes=axes, rows=(3, 4))
    D, B, K = np.diag([2.0, 1.5]), np.diag([9.0, 7.0]), np.diag([60.0, 90.0])
    wanted = Impedance.of(2, inertia=D, damping=B, stiffness=K)
    q, qd, t = Q + np.array([0.1, -0.05]), np.array([0.3, -0.4]), 0.6
    law = impedance_control(ARM, wanted, swinging, coordinates=task, sensor=pushed, shift_acceleration=shift)
    now = task_dynamics(ARM, q, qd, task)
    outside = np.linalg.solve(now.J.T, now.J.T @ PUSH)
    qdd = ARM.forward_dynamics(q, qd, law(t, q, qd, None) + now.J.T @ outside)
    V_dot = now.J @ qdd + now.J_rate @ qd
    X_e, V_e, ahead = task.error(ARM.forward_kinematics(q), swinging(t), now.V)
    left = D @ (V_dot - shift * ahead) - B @ V_e - K @ X_e
    np.testing.assert_allclose(left, PUSH, atol=1e-9)
    # Without a sensor the arm's own inertia is felt in place of D.
    plain = impedance_control(ARM, wanted, swinging, coordinates=task, shift_acceleration=shift)
    force = np.linalg.solve(now.J.T, plain(t, q, qd, None)) - now.velocity_force - now.gravity_force
    np.testing.assert_allclose(force, B @ V_e + K @ X_e + shift * now.inertia @ ahead, atol=1e-9)


def run(law, plant, step):
    found = simulate(
        Scenario(robot=ARM, plant=plant, trajectory=rest(Q, 1.0), law=law, step=step, saturate=False, integrator="rk4")
    )
    assert found
    return found.t, ARM.forward_kinematics(found.q)[:, :2, 3]


@pytest.mark.capability("10-82")
def test_a_virtual_mass_of_its_own_hides_the_friction_of_the_joints():
    """With friction that no model knows the tip follows the mass all the same; from the arm's own state it does not."""
    joints = tuple(replace(j, friction=Friction(viscous=1.5)) if j.moves else j for j in ARM.mechanism.joints)
    rough = Plant(mf.Robot(replace(ARM.mechanism, joints=joints)), environment=Hand())
    m, b, k = 4.0, 30.0, 40.0
    wanted = Impedance.of(2, inertia=m, damping=b, stiffness=k)
    options = {"coordinates": XY, "gains": Gains.from_natural_frequency(2, 60.0)}
    t, tip = run(admittance_control(ARM, wanted, hold_pose(T), pushed, **options), rough, 1e-3)
    # m x'' + b x' + k x = F from rest, overdamped.
    r = np.roots([m, b, k]).real
    x = PUSH / k * (1 - (r[1] * np.exp(r[0] * t) - r[0] * np.exp(r[1] * t)) / (r[1] - r[0]))[:, None]
    off = np.abs(tip - tip[0] - x).max()
    book = admittance_control(ARM, wanted, hold_pose(T), pushed, coordinates=XY, own_state=False)
    _, felt = run(book, rough, 1e-3)
    assert off < 0.15 * np.abs(felt - felt[0] - x).max() < 0.15 * np.abs(x).max()


@pytest.mark.capability("10-82")
def test_steps_of_the_virtual_mass_are_velocity_first():
    law = admittance_control(
        ARM, Impedance.of(2, inertia=[2.0, 3.0], damping=[5.0, 4.0], stiffness=[100.0, 50.0]), swinging, pushed,
        coordinates=XY, gains=Gains.of(2, 400.0, 30.0),
    )  # fmt: skip
    dt, q, qd = 0.004, Q, np.array([0.2, -0.1])
    session, now = law.session(dt), task_dynamics(ARM, q, np.array([0.2, -0.1]), XY)
    x, v, place = T[:2, 3].copy(), now.V.copy(), T[:2, 3]
    D, B, K = np.array([[2.0, 3.0], [5.0, 4.0], [100.0, 50.0]])
    for k in range(5):
        target = swinging(dt * k)
        wanted = (PUSH - B * (v - target.velocity[3:5]) - K * (x - target.pose[:2, 3])) / D
        force = now.force(wanted + 400.0 * (x - place) + 30.0 * (v - now.V)) - PUSH
        np.testing.assert_allclose(session(dt * k, q, qd, None), now.effort(force), atol=1e-9)
        v = v + dt * wanted
        x = x + dt * v
    assert np.allclose(law.session(dt)(0.0, q, qd, None), law.session(dt)(0.0, q, qd, None)), "runs share no mass"


@pytest.mark.capability("10-82")
def test_masses_side_by_side_are_masses_by_themselves():
    wanted = Impedance.of(2, inertia=2.0, damping=9.0, stiffness=40.0)
    law = admittance_control(ARM, wanted, swinging, pushed, coordinates=XY)
    q, qd = Q + 0.1 * np.arange(3)[:, None], np.array([[0.1, 0.0], [0.0, -0.2], [0.3, 0.2]])
    together, alone = law.session(0.01), [law.session(0.01) for _ in range(3)]
    for k in range(4):
        found = together(0.01 * k, q, qd, None)
        assert found.shape == (3, 2)
        np.testing.assert_allclose(found, [one(0.01 * k, a, b, None) for one, a, b in zip(alone, q, qd, strict=True)])


def in_a_corner(kp, ki, duration=0.2):
    """Force (k, 2) that a planar arm exerts on two rigid walls, by an impedance whose model knows no payload."""
    walls = tuple(RigidSurface.plane(T[:3, 3], normal) for normal in ([-1, 0, 0], [0, -1, 0]))
    sensor, goal = TipForceSensor(ARM, None, XY), T.copy()
    goal[:2, 3] += [0.02, 0.01]
    law = impedance_by_force(
        ARM, Impedance.of(2, damping=20.0, stiffness=[500.0, 800.0]), hold_pose(goal), lambda q, qd: -sensor(q, qd),
        coordinates=XY, kp=kp, ki=ki,
    )  # fmt: skip
    plant = RigidPlant(ARM, friction=False, surface=walls).with_payload(0.3)
    run = simulate(Scenario(robot=ARM, trajectory=rest(Q, duration), law=law, plant=plant, saturate=False))
    assert run
    assert np.abs(run.q - Q).max() < 1e-12
    return -(ARM.forward_kinematics(run.q)[:, :3, :3] @ run.contact_wrench[:, 3:, None])[:, :2, 0]


@pytest.mark.capability("10-96", "10-81")
@pytest.mark.parametrize(("kp", "ki"), [(0.0, 40.0), (0.5, 40.0), (0.5, 0.0)])
def test_an_impedance_by_force_is_felt_although_the_model_is_wrong(kp, ki):
    """On rigid walls the sensor reads one tick late: z^2 + (Kfp + Kfi dt - 1) z - Kfp = 0, and F_e ends at zero."""
    wanted, force = np.array([10.0, 8.0]), in_a_corner(kp, ki)
    lacking = wanted - force
    late = np.vstack([wanted[None], lacking[:-1]])  # the first reading is zero
    # F(k) = F_cmd + Kfp F_e(k) + Kfi dt sum F_e - w, of the readings.
    w = (wanted + kp * late + ki * 1e-3 * np.cumsum(late, axis=0)) - force
    np.testing.assert_allclose(w, np.tile(w[0], (len(w), 1)), atol=1e-6)
    assert np.abs(w[0]).max() > 2.0
    if ki:
        assert np.abs(lacking[-1]).max() < 0.02 * np.abs(lacking[1]).max()
    else:
        np.testing.assert_allclose(lacking[-1], w[0] / (1.0 + kp), rtol=1e-6, atol=1e-12)


def test_an_impedance_by_force_without_feedback_is_the_simple_one_and_batches():
    wanted = Impedance.of(2, inertia=1.0, damping=9.0, stiffness=40.0)
    by_force = impedance_by_force(ARM, wanted, swinging, pushed, coordinates=XY)
    simple = impedance_control(ARM, wanted, swinging, coordinates=XY)
    q, qd = Q + 0.1 * np.arange(3)[:, None], np.array([[0.1, 0.0], [0.0, -0.2], [0.3, 0.2]])
    np.testing.assert_allclose(by_force(0.3, q, qd, None), simple(0.3, q, qd, None), atol=1e-12)
    clamped = impedance_by_force(ARM, wanted, swinging, pushed, coordinates=XY, ki=1e3, clamp=0.5).session(0.01)
    now = task_dynamics(ARM, Q, np.zeros(2), XY)
    for _ in range(50):
        tau = clamped(0.3, Q, np.zeros(2), None)
    commanded, error = by_force.forces(0.3, Q, np.zeros(2))
    np.testing.assert_allclose(tau, now.effort(now.force(np.zeros(2)) + commanded + 0.5 * np.sign(error)), atol=1e-9)


@pytest.mark.parametrize(
    "law",
    [
        lambda sensor, wanted: impedance_control(ARM, wanted, hold_pose(T), coordinates=XY, sensor=sensor),
        lambda sensor, wanted: admittance_control(ARM, wanted, hold_pose(T), sensor, coordinates=XY, own_state=False),
        lambda sensor, wanted: impedance_by_force(ARM, wanted, hold_pose(T), sensor, coordinates=XY),
    ],
)
def test_a_sensor_of_the_tip_brings_its_own_sign(law):
    """It says what the tip exerts; these laws ask for the force from outside, as a function gives it."""
    hand = TipForceSensor(ARM, Hand(), XY)
    wanted = Impedance.of(2, inertia=4.0, damping=30.0, stiffness=40.0)
    by_sensor, by_function = law(hand, wanted), law(lambda q, qd: -hand(q, qd), wanted)
    now = rest(Q, 1.0).at(0.2)
    efforts = by_sensor(0.2, Q, np.zeros(2), now)
    np.testing.assert_array_equal(efforts, by_function(0.2, Q, np.zeros(2), now))
    assert hand(Q, np.zeros(2)).any()
