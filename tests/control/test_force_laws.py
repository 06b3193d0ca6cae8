"""Force, hybrid control, constraints and contact: simulated, and against the whole system of equations."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil.control import SpringDamper, TaskTarget, Wall, combine, force_control, hybrid_control, task_dynamics
from mafsil.control.contact import (
    ContactMode,
    applied_wrench,
    constrained_dynamics,
    constraint_in_joints,
    contact_mode,
    tip_wrench_of,
)
from mafsil.errors import InputError
from mafsil.geometry import pose, rotation
from mafsil.simulation import Plant
from mafsil.trajectory import time_law
from tests.control.tip_runs import UR5E, Q, T, run


@pytest.mark.capability("10-59", "10-60", "10-61", "10-64")
def test_force_control_against_a_spring():
    """The environment resists in both directions of a planar arm; the model forgets half a kilogram."""
    arm, q = mf.load("planar2r"), np.array([0.4, 1.1])
    place = arm.forward_kinematics(q)
    spring = SpringDamper(place[:3, 3], stiffness=2e4, damping=300.0)
    plant = Plant(arm, friction=False, environment=spring).with_payload(0.5)

    def sensed(q, qd):
        return -tip_wrench_of(arm, spring, q, qd)

    wrench, errors = np.array([0.0, 0.0, 0.0, 12.0, -7.0, 0.0]), {}
    for name, gains in (("open", {}), ("closed", {"sensor": sensed, "kp": 0.5, "ki": 10.0})):
        law = combine(force_control(arm, wrench, damping=20.0, **gains), _Damping(arm, 5.0))
        found = run(arm, law, q, 2.0, plant=plant, step=2.5e-4)
        assert found.status.name == "COMPLETED"
        errors[name] = np.abs(wrench - sensed(found.q[-1], found.qd[-1])).max()
        end, J = arm.forward_kinematics(found.q[-1]), arm.jacobian_body(found.q[-1])
        pull = 2e4 * (place[:3, 3] - end[:3, 3]) - 300.0 * end[:3, :3] @ (J @ found.qd[-1])[3:]
        felt = np.concatenate([np.zeros(3), end[:3, :3].T @ pull])
        np.testing.assert_allclose(tip_wrench_of(arm, spring, found.q[-1], found.qd[-1]), felt, rtol=0, atol=1e-9)
        held = plant.robot.gravity_torque(found.q[-1]) - J.T @ felt
        np.testing.assert_allclose(found.tau[-1], held, atol=2e-3, err_msg="at rest: tau = g + J' F_app")
    blind = force_control(arm, wrench)(0.0, q, np.zeros(2), None)
    np.testing.assert_allclose(blind, arm.gravity_torque(q) + arm.jacobian_body(q).T @ wrench, rtol=0, atol=1e-12)
    assert errors["open"] > 1.0
    assert errors["closed"] < 0.01


class _Damping:
    """Damping of the joints in proportion to their inertia."""

    def __init__(self, robot, rate):
        self.robot, self.rate = robot, rate

    def __call__(self, t, q, qd, reference):
        return -self.rate * (self.robot.mass_matrix(q) @ qd)

    def session(self, period):
        return self


@pytest.mark.capability("10-64", "10-66")
def test_force_gains_need_a_sensor_and_the_integral_is_clamped():
    with pytest.raises(InputError, match="sensor"):
        force_control(UR5E, np.zeros(6), ki=1.0)
    law = force_control(UR5E, np.zeros(6), sensor=lambda q, qd: np.full(6, -50.0), ki=10.0, clamp=3.0).session(0.01)
    for _ in range(100):
        tau = law(0.0, Q, np.zeros(6), None)
    np.testing.assert_allclose(tau - UR5E.gravity_torque(Q), UR5E.jacobian_body(Q).T @ np.full(6, 3.0), atol=1e-9)


@pytest.mark.capability("10-63", "10-111")
def test_a_sensor_before_the_tool():
    """What the sensor reads less the tool's weight, moved to the tip, is what the tip exerts."""
    tip = pose.from_rotation_translation(rotation.rot_x(0.4), [0.0, 0.05, 0.2])
    applied, weight, bias = np.array([0.1, 0.2, -0.3, 4.0, -5.0, 6.0]), np.array([0, 0, 0, 0, 0, 9.81]), np.full(6, 0.2)
    sensed = pose.adjoint(pose.inverse(tip)).T @ (applied + weight) + bias
    np.testing.assert_allclose(applied_wrench(sensed, pose.adjoint(tip), weight, bias), applied, atol=1e-12)


@pytest.mark.capability("10-72", "10-73", "10-106", "10-113", "10-114")
@settings(deadline=None, max_examples=60)
@given(st.integers(2, 7), st.data())
def test_constrained_motion_against_the_whole_system(m, data):
    k = data.draw(st.integers(1, m - 1))
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    root = rng.normal(size=(m, m))
    Lambda, A, A_rate = root @ root.T + np.eye(m), rng.normal(size=(k, m)), rng.normal(size=(k, m))
    h, F = rng.normal(size=(2, m))
    N = np.linalg.svd(A)[2][k:].T
    V = N @ rng.normal(size=m - k)
    held = constrained_dynamics(Lambda, h, A, F, V, A_rate)
    whole = np.block([[Lambda, A.T], [A, np.zeros((k, k))]])
    exact = np.linalg.solve(whole, np.concatenate([F - h, -A_rate @ V]))
    np.testing.assert_allclose(held.acceleration, exact[:m], atol=1e-8)
    np.testing.assert_allclose(held.multipliers, exact[m:], atol=1e-8)
    P = held.P
    np.testing.assert_allclose(P @ P, P, atol=1e-8)
    np.testing.assert_allclose(P @ A.T, 0.0, atol=1e-8)
    np.testing.assert_allclose(A @ np.linalg.solve(Lambda, P), 0.0, atol=1e-8)
    assert np.linalg.matrix_rank(P, tol=1e-7) == m - k
    np.testing.assert_allclose(N.T @ F, N.T @ (Lambda @ held.acceleration + h), atol=1e-8)
    J = rng.normal(size=(m, m))
    np.testing.assert_allclose(constraint_in_joints(A, J), A @ J)


@pytest.mark.capability("10-70", "10-113")
def test_constraints_said_in_joints_have_the_same_multipliers():
    qd, F = np.linspace(0.2, -0.1, 6), np.linspace(-3, 4, 6)
    now = task_dynamics(UR5E, Q, qd)
    A = np.eye(6)[[2, 5]]
    at_tip = constrained_dynamics(now.inertia, now.velocity_force + now.gravity_force, A, F, now.V)
    rate = constraint_in_joints(A, now.J_rate)
    bias = UR5E.velocity_torque(Q, qd) + UR5E.gravity_torque(Q)
    at_joints = constrained_dynamics(UR5E.mass_matrix(Q), bias, constraint_in_joints(A, now.J), now.J.T @ F, qd, rate)
    np.testing.assert_allclose(at_joints.multipliers, at_tip.multipliers, atol=1e-8)
    with pytest.raises(InputError, match="depend"):
        constrained_dynamics(now.inertia, np.zeros(6), [[1.0, 0, 0, 0, 0, 0], [2.0, 0, 0, 0, 0, 0]], F)


@pytest.mark.capability("10-68", "10-69", "10-94")
def test_contacts_stick_slide_or_are_lost():
    assert contact_mode(10.0, [3.0, 4.0], 0.5) is ContactMode.STICKING
    assert contact_mode(10.0, [3.0, 4.1], 0.5) is ContactMode.SLIDING
    assert contact_mode(0.0, 0.0, 0.5) is ContactMode.FREE
    assert [mode.force_freedoms for mode in (ContactMode.FREE, ContactMode.SLIDING, ContactMode.STICKING)] == [0, 1, 3]


@pytest.mark.capability("10-74", "10-106")
def test_hybrid_control_slides_along_a_wall():
    """10 N into a stiff wall while the tip moves 0.1 m along it: force and position both as asked for."""
    wall = Wall(T[:3, 3], [0.0, 0.0, 1.0], stiffness=5e4, damping=400.0)
    plant = Plant(UR5E, friction=False, environment=wall)
    law_of_time = time_law("quintic").unit().scale_time(1.5)

    def reference(t):
        s, rate, growth = (float(x[..., 0]) for x in law_of_time.at(t))
        P = T.copy()
        P[1, 3] += 0.1 * s
        along = np.array([0.0, 0.0, 0.0, 0.0, 0.1, 0.0])
        return TaskTarget(P, along * rate, along * growth)

    def sensed(q, qd):
        F = -tip_wrench_of(UR5E, wall, q, qd)
        R = UR5E.forward_kinematics(q)[:3, :3]
        return np.concatenate([R @ F[:3], R @ F[3:]])

    law = hybrid_control(
        UR5E, reference, np.eye(6)[5:], [0, 0, 0, 0, 0, -10.0], sensor=sensed, force_kp=0.3, force_ki=20.0
    )
    found = run(UR5E, law, Q, 2.0, plant=plant, step=2.5e-4)
    assert found.status.name == "COMPLETED"
    assert sensed(found.q[-1], found.qd[-1])[5] == pytest.approx(-10.0, abs=0.1)
    end = UR5E.forward_kinematics(found.q[-1])
    np.testing.assert_allclose(end[:2, 3], T[:2, 3] + [0.0, 0.1], atol=2e-4)
    np.testing.assert_allclose(end[:3, :3], T[:3, :3], atol=2e-3)


@pytest.mark.capability("10-92", "10-60")
def test_springs_pull_and_dampers_brake():
    spring = SpringDamper([0.0, 0.0, 0.0], stiffness=[100.0, 200.0, 300.0], damping=10.0)
    P = pose.from_rotation_translation(rotation.rot_z(0.3), [0.1, 0.2, -0.1])
    F = spring.wrench(P, np.array([0, 0, 0, 1.0, 0, 0]))
    velocity = P[:3, :3] @ [1.0, 0.0, 0.0]
    np.testing.assert_allclose(P[:3, :3] @ F[3:], [-10.0, -40.0, 30.0] - 10.0 * velocity, atol=1e-12)
    wall = Wall([0, 0, 0], [0, 0, 2.0], stiffness=1e3, damping=10.0, friction=0.5)
    deep = pose.from_translation([0.0, 0.0, -0.01])
    np.testing.assert_allclose(wall.wrench(deep, np.array([0, 0, 0, 0.1, 0.0, 0.0]))[3:], [-5.0, 0.0, 10.0], atol=1e-12)
    assert not wall.wrench(pose.from_translation([0.0, 0.0, 0.01]), np.zeros(6)).any()
    away = wall.wrench(deep, np.array([0, 0, 0, 0.0, 0.0, 5.0]))
    assert away[5] == 0.0, "a wall does not pull"
