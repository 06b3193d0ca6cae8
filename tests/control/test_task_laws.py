"""Laws of the motion of a tip, simulated and in closed form; arms joint by joint; an adaptive law."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import (
    TaskCoordinates,
    adaptive_control,
    hold_pose,
    joint_coupling,
    task_computed_torque,
    task_dynamics,
)
from mafsil.control.analysis.tune_gains import CouplingStatus
from mafsil.control.laws import TipMotion
from mafsil.geometry import pose
from mafsil.model import Actuator, Inertial, Joint, JointKind, Link, Mechanism
from mafsil.simulation import Plant
from mafsil.trajectory import Motion, circle_path, time_law
from tests.control.tip_runs import AXES, PANDA, Q7, UR5E, Q, T, run


@pytest.mark.capability("10-57", "10-58")
@pytest.mark.parametrize("axes", AXES)
def test_task_dynamics_are_those_of_the_joints(axes):
    rng = np.random.default_rng(1)
    q, qd, qdd = rng.uniform(-1, 1, (3, 40, 6))
    task = TaskCoordinates(axes)
    now = task_dynamics(UR5E, q, qd, task)
    V_dot = np.einsum("kij,kj->ki", now.J, qdd) + np.einsum("kij,kj->ki", now.J_rate, qd)
    np.testing.assert_allclose(now.effort(now.force(V_dot)), UR5E.inverse_dynamics(q, qd, qdd), atol=1e-7)
    h = 1e-6
    rate = (task.jacobian(UR5E, q + h * qd) - task.jacobian(UR5E, q - h * qd)) / (2 * h)
    np.testing.assert_allclose(now.J_rate, rate, atol=1e-7)


@pytest.mark.capability("10-55", "10-102")
def test_a_redundant_arm_moves_its_tip_and_its_posture_apart():
    q, qd = Q7, np.linspace(0.3, -0.2, 7)
    now = task_dynamics(PANDA, q, qd)
    wanted = np.array([0.1, -0.2, 0.3, 0.5, 0.1, -0.4])
    for rest_effort in (np.zeros(7), np.linspace(5, -5, 7)):
        tau = now.effort(now.force(wanted), rest_effort)
        qdd = PANDA.forward_dynamics(q, qd, tau)
        np.testing.assert_allclose(now.J @ qdd + now.J_rate @ qd, wanted, atol=1e-9)
    np.testing.assert_allclose(now.J @ now.inverse, np.eye(6), atol=1e-9)


@pytest.mark.capability("10-54", "10-57")
@pytest.mark.parametrize("axes", AXES)
def test_a_tip_follows_a_circle(axes):
    circle = circle_path(T, T[:3, 3] + [0.0, 0.08, 0.0], [0.0, 0.0, 1.0])
    motion = TipMotion(circle, time_law("quintic").unit().scale_time(2.0), axes)
    law = task_computed_torque(UR5E, motion, coordinates=TaskCoordinates(axes), natural_frequency=30.0)
    found = run(UR5E, law, Q, 2.0)
    assert found.status.name == "COMPLETED"
    wanted = np.stack([motion(t).pose for t in found.t[::50]])
    np.testing.assert_allclose(UR5E.forward_kinematics(found.q[::50]), wanted, atol=2e-4)


@pytest.mark.capability("10-51", "10-57")
def test_the_error_of_a_position_obeys_its_equation():
    w, away = 12.0, np.array([0.03, -0.02, 0.04])
    goal = T.copy()
    goal[:3, 3] += away
    law = task_computed_torque(UR5E, hold_pose(goal), natural_frequency=w)
    found = run(UR5E, law, Q, 0.5, step=2e-4)
    e = goal[:3, 3] - UR5E.forward_kinematics(found.q)[:, :3, 3]
    exact = np.exp(-w * found.t[:, None]) * (1 + w * found.t[:, None]) * away
    np.testing.assert_allclose(e, exact, atol=2e-4)


@pytest.mark.capability("10-58", "10-101")
def test_ways_of_the_tip_by_the_error_that_is_used():
    """Decoupled: the origin goes straight. Body and space with scalar gains: both along the same screw."""
    goal = T @ pose.exp([0.4, -0.3, 0.5, 0.05, -0.06, 0.04])
    ways = {}
    for axes in AXES:
        law = task_computed_torque(UR5E, hold_pose(goal), coordinates=TaskCoordinates(axes), natural_frequency=10.0)
        ways[axes] = UR5E.forward_kinematics(run(UR5E, law, Q, 1.5).q[::20])
    line = goal[:3, 3] - T[:3, 3]
    off = np.linalg.norm(np.cross(ways["decoupled"][:, :3, 3] - T[:3, 3], line), axis=1) / np.linalg.norm(line)
    assert off.max() < 2e-4
    axis = pose.log(pose.inverse(T) @ goal)
    for axes in ("body", "space"):
        moved = pose.log(pose.inverse(T) @ ways[axes])
        along = moved @ axis / (axis @ axis)
        assert np.abs(moved - along[:, None] * axis).max() < 5e-3
    assert np.abs(ways["decoupled"][10, :3, 3] - ways["body"][10, :3, 3]).max() > 1e-3
    assert np.abs(ways["decoupled"][-1] - goal).max() < 1e-4


def test_an_integral_removes_a_constant_disturbance():
    plant = Plant(UR5E, friction=False).with_payload(1.0)
    errors = []
    for integral in (0.0, 300.0):
        law = task_computed_torque(UR5E, hold_pose(T), natural_frequency=10.0, integral=integral)
        found = run(UR5E, law, Q, 3.0, plant=plant)
        errors.append(np.linalg.norm(UR5E.forward_kinematics(found.q[-1])[:3, 3] - T[:3, 3]))
    assert errors[0] > 5e-3
    assert errors[1] < 2e-4


@pytest.mark.capability("10-87", "10-112")
def test_an_adaptive_law_finds_the_payload():
    """Two kilograms 5 cm before the flange: the error goes to zero, and mass and first moments are found."""
    plant = Plant(UR5E, friction=False).with_payload(2.0, com=[0.0, 0.0, 0.05])
    law = adaptive_control(
        UR5E, rate=10.0, damping=60.0 * np.diag(UR5E.mass_matrix(Q)), learning=[4.0, 0.4, 0.4, 0.4, *[0.02] * 6]
    )
    # On the surface s = 0 only the dynamics are left: tau = M (a + L (v - qd)) + c(q, qd) + g.
    e, v, a = np.array([[0.1, -0.2, 0.3, 0.1, 0.2, -0.1], [0.5, 0.4, -0.3, 0.2, 0.1, 0.6], [1.0, 2.0, 3.0, -1, 0.5, 0]])
    tau = UR5E.inverse_dynamics(Q, v + 10.0 * e, a - 100.0 * e)
    np.testing.assert_allclose(law(0.0, Q, v + 10.0 * e, Motion(Q + e, v, a)), tau, rtol=0, atol=1e-9)
    session = law.session(1e-3)

    class Watched:
        def __call__(self, t, q, qd, reference):
            return session(t, q, qd, reference)

        def session(self, period):
            return self

    reference = _Waves(Q, 20.0)
    scenario = mf.Scenario(robot=UR5E, plant=plant, trajectory=reference, law=Watched(), step=1e-3, saturate=False)
    found = mf.simulate(scenario, fused=False)
    error = np.abs(found.q - found.q_ref).max(axis=1)
    assert error[-2000:].max() < 0.2 * error[:2000].max()
    assert session.parameters[0] == pytest.approx(2.0, rel=0.05)
    assert session.parameters[3] == pytest.approx(0.1, abs=0.03)


class _Waves:
    """Every joint swings with a period of its own."""

    def __init__(self, middle, duration):
        self.middle, self.duration, self.n = middle, duration, len(middle)
        self.w = 1.0 + 0.4 * np.arange(self.n)

    def at(self, t):
        phase = np.asarray(t)[..., None] * self.w
        swing = 0.4
        return Motion(
            self.middle + swing * (1 - np.cos(phase)), swing * self.w * np.sin(phase), swing * self.w**2 * np.cos(phase)
        )

    def breaks(self):
        return np.array([0.0, self.duration])

    def jerk(self, t):
        return -0.4 * self.w**3 * np.sin(np.asarray(t)[..., None] * self.w)


@pytest.mark.capability("10-49", "10-50", "10-98")
def test_which_arms_can_be_controlled_joint_by_joint():
    body = Inertial(2.0, np.zeros(3), 0.01 * np.eye(3))
    links = [Link("base"), *(Link(f"l{k}", body) for k in range(3))]
    axes = np.eye(3)
    joints = [Joint(f"j{k}", JointKind.PRISMATIC, links[k].name, links[k + 1].name, axis=axes[k]) for k in range(3)]
    gantry = joint_coupling(mf.Robot(Mechanism.assemble("gantry", links, joints)))
    assert gantry.status is CouplingStatus.DECOUPLED
    arm = mf.load("planar2r")
    direct = joint_coupling(arm)
    assert direct.status is CouplingStatus.STRONG
    rotor = Actuator(rotor_inertia=1e-3, gear_ratio=200.0)
    heavy = tuple(replace(joint, actuator=rotor) if joint.moves else joint for joint in arm.mechanism.joints)
    driven = joint_coupling(mf.Robot(replace(arm.mechanism, joints=heavy)))
    assert driven
    assert driven.coupling.max() < direct.coupling.max()
    assert driven.explain("ar") != driven.explain("en")
