"""Laws at the tip: task space, force, hybrid, impedance, admittance, adaptive; simulated, and in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil.control import (
    ContactMode,
    Impedance,
    SpringDamper,
    TaskCoordinates,
    TaskTarget,
    TipMotion,
    Wall,
    adaptive_control,
    admittance_control,
    applied_wrench,
    combined,
    constrained_dynamics,
    contact_mode,
    force_control,
    hold,
    hybrid_control,
    impedance_control,
    in_joints,
    joint_coupling,
    linearize,
    null_space_feedback,
    sampled_wall_radius,
    stiffest_wall,
    task_computed_torque,
    task_dynamics,
    tip_wrench_of,
)
from mafsil.control.coupling import CouplingStatus
from mafsil.errors import InputError
from mafsil.geometry import pose, rotation
from mafsil.model import Actuator, Inertial, Joint, JointKind, Link, Mechanism
from mafsil.simulation import Plant
from mafsil.trajectory import Motion, circle_path, rest, time_law

UR5E, PANDA = mf.load("ur5e"), mf.load("panda")
Q = np.array([0.3, -1.2, 1.2, 0.4, 1.0, 0.2])
Q7 = np.array([0.1, -0.4, 0.2, -2.0, 0.1, 1.8, 0.5])
T = UR5E.forward_kinematics(Q)
POSITION = TaskCoordinates(rows=(3, 4, 5))
AXES = ["decoupled", "body", "space"]


def run(robot, law, q, duration, *, plant=None, qd=None, step=1e-3, goal=None):
    scenario = mf.Scenario(
        robot=robot,
        plant=plant or Plant(robot, friction=False),
        trajectory=rest(q if goal is None else goal, duration),
        law=law,
        q=q,
        qd=np.zeros(robot.n) if qd is None else qd,
        step=step,
        saturate=False,
        integrator="rk4",
    )
    return mf.simulate(scenario)


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
    motion = TipMotion(circle, time_law("quintic").unit().stretched(2.0), axes)
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
    law = task_computed_torque(UR5E, hold(goal), natural_frequency=w)
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
        law = task_computed_torque(UR5E, hold(goal), coordinates=TaskCoordinates(axes), natural_frequency=10.0)
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
        law = task_computed_torque(UR5E, hold(T), natural_frequency=10.0, integral=integral)
        found = run(UR5E, law, Q, 3.0, plant=plant)
        errors.append(np.linalg.norm(UR5E.forward_kinematics(found.q[-1])[:3, 3] - T[:3, 3]))
    assert errors[0] > 5e-3
    assert errors[1] < 2e-4


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
        law = combined(force_control(arm, wrench, damping=20.0, **gains), _Damping(arm, 5.0))
        found = run(arm, law, q, 2.0, plant=plant, step=2.5e-4)
        assert found.status.name == "COMPLETED"
        errors[name] = np.abs(wrench - sensed(found.q[-1], found.qd[-1])).max()
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
    np.testing.assert_allclose(in_joints(A, J), A @ J)


@pytest.mark.capability("10-70", "10-113")
def test_constraints_said_in_joints_have_the_same_multipliers():
    qd, F = np.linspace(0.2, -0.1, 6), np.linspace(-3, 4, 6)
    now = task_dynamics(UR5E, Q, qd)
    A = np.eye(6)[[2, 5]]
    at_tip = constrained_dynamics(now.inertia, now.velocity_force + now.gravity_force, A, F, now.V)
    rate = in_joints(A, now.J_rate)
    bias = UR5E.velocity_torque(Q, qd) + UR5E.gravity_torque(Q)
    at_joints = constrained_dynamics(UR5E.mass_matrix(Q), bias, in_joints(A, now.J), now.J.T @ F, qd, rate)
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
    law_of_time = time_law("quintic").unit().stretched(1.5)

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


@pytest.mark.capability("10-78", "10-79", "10-81", "10-82")
@pytest.mark.parametrize("kind", ["impedance", "admittance"])
def test_a_tip_that_is_pushed_moves_as_its_virtual_mass(kind):
    """A constant push of 5 N along x: x(t) of the wanted mass, damper and spring."""
    wanted = Impedance.of(3, inertia=4.0, damping=30.0, stiffness=200.0)
    push = np.array([5.0, 0.0, 0.0])
    plant = Plant(PANDA, friction=False, environment=_Push(push))
    start = PANDA.forward_kinematics(Q7)
    if kind == "impedance":
        law = impedance_control(PANDA, wanted, hold(start), coordinates=POSITION, sensor=lambda q, qd: push)
    else:
        law = admittance_control(PANDA, wanted, hold(start), lambda q, qd: push, coordinates=POSITION)
    still = combined(law, _NullDamping(PANDA))
    found = run(PANDA, still, Q7, 1.0, plant=plant, step=5e-4)
    moved = PANDA.forward_kinematics(found.q)[:, :3, 3] - start[:3, 3]
    roots = Impedance.of(1, inertia=4.0, damping=30.0, stiffness=200.0).roots
    c = np.linalg.solve(np.array([[1.0, 1.0], roots]), [-5.0 / 200.0, 0.0])
    exact = 5.0 / 200.0 + (c * np.exp(np.outer(found.t, roots))).sum(axis=1).real
    np.testing.assert_allclose(moved[:, 0], exact, atol=3e-4)
    assert np.abs(moved[:, 1:]).max() < 1e-3


class _Push:
    """A constant force in {s} on the tip."""

    def __init__(self, force):
        self.force = force

    def wrench(self, T, V):
        turned = np.swapaxes(T[..., :3, :3], -1, -2) @ self.force
        return np.concatenate([np.zeros_like(turned), turned], axis=-1)


class _NullDamping:
    """Damping of what does not move the tip's origin."""

    def __init__(self, robot):
        self.robot = robot

    def __call__(self, t, q, qd, reference):
        now = task_dynamics(self.robot, q, qd, POSITION)
        return now.effort(np.zeros(3), -5.0 * (self.robot.mass_matrix(q) @ qd))

    def session(self, period):
        return self


@pytest.mark.capability("10-80")
def test_stiffness_alone_is_a_spring():
    wanted = Impedance.of(6, stiffness=[20.0, 20.0, 20.0, 400.0, 400.0, 400.0])
    away = T.copy()
    away[0, 3] -= 0.01
    law = impedance_control(UR5E, wanted, hold(away))
    tau = law(0.0, Q, np.zeros(6), None) - UR5E.gravity_torque(Q)
    F = np.linalg.solve(task_dynamics(UR5E, Q).J.T, tau)
    np.testing.assert_allclose(F, [0, 0, 0, -4.0, 0, 0], atol=1e-9)
    with pytest.raises(InputError, match="mass"):
        wanted.acceleration(np.zeros(6), np.zeros(6), np.zeros(6))


@pytest.mark.capability("10-84", "10-97")
def test_virtual_walls_that_a_sampled_arm_can_render():
    period, damping = 1e-3, 2.0
    assert stiffest_wall(damping, period) == 4000.0
    assert sampled_wall_radius(1.0, damping, 0.9 * 4000.0, period) < 1.0
    limit = next(K for K in np.geomspace(100.0, 1e6, 400) if sampled_wall_radius(1.0, damping, K, period) > 1.0)
    late = next(K for K in np.geomspace(1.0, 1e6, 400) if sampled_wall_radius(1.0, damping, K, period, delay=5) > 1.0)
    assert late < limit < 1.1 * stiffest_wall(damping, period)
    with pytest.raises(InputError, match="stiffness"):
        Wall([0, 0, 0], [0, 0, 1], stiffness=0.0)


@pytest.mark.capability("10-87", "10-112")
def test_an_adaptive_law_finds_the_payload():
    """Two kilograms 5 cm before the flange: the error goes to zero, and mass and first moments are found."""
    plant = Plant(UR5E, friction=False).with_payload(2.0, com=[0.0, 0.0, 0.05])
    law = adaptive_control(
        UR5E, rate=10.0, damping=60.0 * np.diag(UR5E.mass_matrix(Q)), learning=[4.0, 0.4, 0.4, 0.4, *[0.02] * 6]
    )
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


@pytest.mark.capability("10-55", "10-102")
@pytest.mark.parametrize("law", ["impedance", "computed_torque"])
def test_a_redundant_arm_bears_its_gravity_beside_the_task_too(law):
    """Motions that leave the tip at rest obey e'' + 2 w e' + w^2 e = 0: a double root at -w, in any pose."""
    arm, w = mf.load("panda"), 3.0
    for q in np.array([[0.8, 0.8, -0.8, -1.3, 0.8, 1.3, -0.8], [0.2, -0.4, 0.1, -2.0, 0.1, 1.6, 0.5]]):
        T = arm.forward_kinematics(q)
        if law == "impedance":
            soft = Impedance.of(6, damping=[20, 20, 20, 200, 200, 200], stiffness=[40, 40, 40, 900, 900, 900])
            chosen = combined(impedance_control(arm, soft, hold(T)), null_space_feedback(arm, natural_frequency=w))
        else:
            chosen = task_computed_torque(arm, hold(T), natural_frequency=30.0, rest_frequency=w)
        loop = linearize(arm, q).closed(chosen, Motion(q, np.zeros(7), np.zeros(7)))
        friction = np.array([0.0 if j.friction is None else j.friction.viscous for j in arm.mechanism.coordinates])
        assert not friction.any()
        poles = loop.poles
        at_rest = np.sort(np.abs(poles + w))[:2]
        assert at_rest.max() < 2e-3 * w
        assert poles.real.max() < -0.5
