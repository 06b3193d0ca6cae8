"""Independent equations of a constrained tip, friction of a sliding contact, and joints that leave each other alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import Gains, TaskCoordinates, TaskTarget, hybrid_control, joint_coupling
from mafsil.control.analysis.tune_gains import CouplingStatus
from mafsil.control.contact import ContactMode, constrained_dynamics, contact_mode, reduced_dynamics, sliding_friction
from mafsil.errors import InputError
from mafsil.model import Actuator, Inertial, Joint, JointKind, Link, Mechanism


@pytest.mark.capability("10-114", "10-73", "10-72")
@pytest.mark.parametrize(("m", "k"), [(2, 1), (6, 5), (6, 3), (4, 1)])
def test_reduced_equations_against_the_whole_system(m, k):
    rng = np.random.default_rng(10 * m + k)
    root = rng.normal(size=(m, m))
    Lambda, A, A_rate = root @ root.T + np.eye(m), rng.normal(size=(k, m)), rng.normal(size=(k, m))
    h, F = rng.normal(size=(2, m))
    V = np.linalg.svd(A)[2][k:].T @ rng.normal(size=m - k)
    found = reduced_dynamics(Lambda, h, A, F, V, A_rate)
    assert found.N.shape == (m, m - k), "as many freedoms of motion as directions that are not blocked"
    np.testing.assert_allclose(A @ found.N, 0.0, atol=1e-12)
    np.testing.assert_allclose(found.N.T @ found.N, np.eye(m - k), atol=1e-12)
    whole = np.block([[Lambda, A.T], [A, np.zeros((k, k))]])
    V_dot = np.linalg.solve(whole, np.concatenate([F - h, -A_rate @ V]))[:m]
    np.testing.assert_allclose(found.N.T @ V_dot, found.acceleration, atol=1e-9)
    np.testing.assert_allclose(found.force, found.inertia @ found.acceleration + found.rest_force, atol=1e-9)
    np.testing.assert_allclose(found.inertia, found.N.T @ Lambda @ found.N, atol=1e-10)
    np.testing.assert_allclose(found.N.T @ F, found.force, atol=1e-12)
    held = constrained_dynamics(Lambda, h, A, F, V, A_rate)
    np.testing.assert_allclose(held.acceleration, V_dot, atol=1e-9)
    assert np.trace(held.P) == pytest.approx(m - k, abs=1e-9)
    both = reduced_dynamics(np.stack([Lambda, 2 * Lambda]), h, np.stack([A, A]), F, V, A_rate)
    np.testing.assert_allclose(both.acceleration[0], found.acceleration, atol=1e-9)
    half = reduced_dynamics(2 * Lambda, h, A, F, V, A_rate)
    np.testing.assert_allclose(both.acceleration[1], half.acceleration, atol=1e-9)
    with pytest.raises(InputError, match="depend"):
        reduced_dynamics(Lambda, h, np.vstack([A[:1], 2 * A[:1]]), F)


@pytest.mark.capability("10-94", "10-68")
def test_friction_of_a_contact_that_slides_is_against_its_velocity():
    found = sliding_friction(8.0, [[3.0, 4.0], [0.0, 0.0], [-0.1, 0.0]], 0.5)
    np.testing.assert_allclose(found, [[-2.4, -3.2], [0.0, 0.0], [4.0, 0.0]])
    assert not sliding_friction(-1.0, [1.0, 0.0], 0.5).any(), "what is not pressed is not held back"
    assert contact_mode(8.0, [2.4, 3.2], 0.5) is ContactMode.STICKING
    assert contact_mode(8.0, [2.4, 3.2001], 0.5) is ContactMode.SLIDING
    for wrong in ((np.nan, 1.0, 0.5), (1.0, np.inf, 0.5), (1.0, 1.0, -0.1), (1.0, 1.0, np.nan)):
        with pytest.raises(InputError):
            contact_mode(*wrong)
        with pytest.raises(InputError):
            sliding_friction(wrong[0], [wrong[1], 0.0], wrong[2])


@pytest.mark.capability("10-106", "10-74")
@pytest.mark.parametrize("radius", [np.inf, 0.4])
def test_both_errors_of_hybrid_control_obey_their_equations_on_a_rigid_constraint(radius):
    """Flat, and on a circle: what the whole system of motion and multipliers does under the law's efforts."""
    arm, q = mf.load("planar2r"), np.array([0.4, 1.1])
    task, middle = (
        TaskCoordinates(rows=(3, 4)),
        arm.forward_kinematics(q)[:2, 3] - (0 if np.isinf(radius) else [0.0, radius]),
    )

    def constraint(T, V):
        if np.isinf(radius):
            return np.array([[0.0, 1.0]]), np.zeros((1, 2))
        return (T[:2, 3] - middle)[None] / radius, V[None] / radius

    J, V = task.jacobian(arm, q), np.array([0.3, 0.0])
    qd, T = np.linalg.solve(J, V), arm.forward_kinematics(q)
    A, A_rate = constraint(T, V)
    A_d = np.array([0.7, float(-(A_rate @ V)[0])])  # along the constraint, with the curvature that keeps to it
    place = T.copy()
    place[0, 3] += 0.02
    wanted, measured, kp, ki = 9.0, 7.5, 0.6, 8.0
    law = hybrid_control(
        arm, lambda t: TaskTarget(place, np.array([0, 0, 0, 0.35, 0, 0]), np.array([0, 0, 0, *A_d, 0])), constraint,
        lambda T: wanted * constraint(T, V)[0][0], coordinates=task, gains=Gains.of(2, 50.0, 12.0),
        sensor=lambda q, qd: measured * A[0], force_kp=kp, force_ki=ki,
    )  # fmt: skip
    tau = law.session(0.01)(0.0, q, qd, None)
    # The arm on the rigid constraint: M qdd + J' A' lambda = tau - c - g, with A J qdd = -(A dJ/dt + dA/dt J) qd.
    AJ, bend = A @ J, A @ task.jacobian_rate(arm, q, qd) + A_rate @ J
    whole = np.block([[arm.mass_matrix(q), AJ.T], [AJ, np.zeros((1, 1))]])
    rest = arm.velocity_torque(q, qd) + arm.gravity_torque(q)
    *qdd, multiplier = np.linalg.solve(whole, [*(tau - rest), *(-bend @ qd)])
    V_dot = J @ qdd + task.jacobian_rate(arm, q, qd) @ qd
    np.testing.assert_allclose(A_d - V_dot + [12.0 * 0.05 + 50.0 * 0.02, 0.0], 0.0, atol=1e-9)
    # What the multiplier makes of the measured one: lambda = lambda_d + Kfp e + Kfi int e, curvature taken out.
    error = wanted - measured
    assert multiplier == pytest.approx(wanted + kp * error + ki * 0.01 * error, abs=1e-9)


def lifts(effort, tilt=0.0):
    """Two slides under gravity, the second one tilted against the first: M_12 = m cos(angle between them)."""
    links = [
        Link("base"),
        Link("a", Inertial(1.0, np.zeros(3), np.eye(3))),
        Link("b", Inertial(2.0, np.zeros(3), np.eye(3))),
    ]
    axes = [[0.0, 0.0, 1.0], [np.cos(tilt), 0.0, np.sin(tilt)]]
    joints = [
        Joint(f"j{k}", JointKind.PRISMATIC, links[k].name, links[k + 1].name, axis=np.array(axes[k])) for k in range(2)
    ]
    joints = [replace(each, limits=replace(each.limits, effort=effort)) for each in joints]
    return mf.Robot(Mechanism.assemble("lifts", links, joints))


@pytest.mark.capability("10-50", "10-98")
def test_the_three_numbers_of_coupling_and_their_thresholds():
    # M = [[3, 2 s], [2 s, 2]]: kappa = s, no spread; gravity 3 g on the first slide.
    s = np.sin(0.08)
    found = joint_coupling(lifts(1000.0, 0.08))
    np.testing.assert_allclose(found.coupling, [2 * s / 3, s], atol=1e-9)
    np.testing.assert_allclose(found.spread, 0.0, atol=1e-12)
    np.testing.assert_allclose(found.gravity_share, [3 * 9.81 / 1000, 2 * 9.81 * s / 1000], rtol=1e-9)
    assert found.status is CouplingStatus.WEAK
    assert joint_coupling(lifts(1000.0, 0.11)).status is CouplingStatus.STRONG, "a tenth by default"
    assert joint_coupling(lifts(1000.0, 0.11), coupling=0.2).status is CouplingStatus.WEAK
    assert joint_coupling(lifts(1000.0)).status is CouplingStatus.DECOUPLED
    heavy = joint_coupling(lifts(100.0))
    assert heavy.status is CouplingStatus.GRAVITY
    assert not heavy
    assert "0.294" in heavy.explain("en")
    assert joint_coupling(lifts(100.0), gravity_share=0.3)
    with pytest.raises(InputError, match="spread"):
        joint_coupling(lifts(100.0), spread=-1.0)


@pytest.mark.capability("10-50", "10-98")
def test_spread_of_a_geared_arm_by_its_own_mass_matrix():
    arm = mf.load("planar2r")
    rotor = Actuator(rotor_inertia=1e-3, gear_ratio=60.0)
    joints = tuple(replace(joint, actuator=rotor) if joint.moves else joint for joint in arm.mechanism.joints)
    geared = mf.Robot(replace(arm.mechanism, joints=joints))
    q = np.stack([np.zeros(4001), np.linspace(-np.pi, np.pi, 4001)], axis=1)
    M = arm.mass_matrix(q) + 3.6 * np.eye(2)
    own = M[:, [0, 1], [0, 1]]
    found = joint_coupling(geared)
    np.testing.assert_allclose(found.spread, (np.abs(own - own.mean(0)) / own.mean(0)).max(0), rtol=0.05, atol=1e-9)
    np.testing.assert_allclose(found.coupling, (np.abs(M[:, 0, 1])[:, None] / own).max(0), rtol=0.02)


@pytest.mark.capability("10-68", "10-72", "10-73")
def test_a_tip_without_constraints_has_all_freedoms():
    """The chalk that is lifted: no row of A, six freedoms of motion, none of force."""
    rng = np.random.default_rng(3)
    root, h, F = rng.normal(size=(6, 6)), *rng.normal(size=(2, 6))
    Lambda, none = root @ root.T + np.eye(6), np.zeros((0, 6))
    free = constrained_dynamics(Lambda, h, none, F)
    assert free.multipliers.shape == (0,)
    np.testing.assert_allclose(free.P, np.eye(6))
    np.testing.assert_allclose(free.acceleration, np.linalg.solve(Lambda, F - h))
    reduced = reduced_dynamics(Lambda, h, none, F)
    assert reduced.N.shape == (6, 6)
    np.testing.assert_allclose(reduced.N @ reduced.acceleration, free.acceleration)
