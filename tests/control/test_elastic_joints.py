"""Arms with elastic joints: energy, closed forms, the rigid limit, and what each law promises."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import (
    computed_torque,
    elastic_arm,
    elastic_linearization,
    motor_feedback,
    singular_perturbation_control,
)
from mafsil.control.joints import ElasticState, set_point_condition
from mafsil.control.joints.elastic_laws import SetPointStatus
from mafsil.errors import InputError
from mafsil.model import Actuator
from mafsil.one_joint import ElasticJoint
from mafsil.simulation import simulate_elastic
from mafsil.simulation.recording import SimulationStatus
from mafsil.trajectory import quintic
from mafsil.trajectory.profiles import rest


@pytest.fixture(scope="module")
def arm():
    return elastic_arm(mf.load("planar2r"), [2000.0, 1000.0], motor_inertia=[0.4, 0.1])


class Nothing:
    def __call__(self, t, state, reference):
        return np.zeros_like(state.q)

    def session(self, period):
        return self


@pytest.mark.capability("10-89", "02-10")
def test_energy_is_kept_without_a_law_and_falls_with_damping(arm):
    start = ElasticState(*np.random.default_rng(3).normal(size=(4, 5, 2)) * [[[1.0]], [[0.5]], [[1.0]], [[0.5]]])
    start = start._replace(motor=start.q + 0.01)
    run = simulate_elastic(arm, Nothing(), rest(np.zeros(2), 0.5), start=start)
    energy = arm.energy(ElasticState(run.q, run.qd, run.motor, run.motor_rate))
    assert run.q.shape == (2501, 5, 2)
    np.testing.assert_allclose(energy, energy[:1] + 0 * energy, rtol=1e-7, atol=1e-7)
    loose = elastic_arm(mf.load("planar2r"), [2000.0, 1000.0], damping=5.0, motor_inertia=[0.4, 0.1])
    lost = simulate_elastic(loose, Nothing(), rest(np.zeros(2), 0.5), start=start)
    fallen = loose.energy(ElasticState(lost.q, lost.qd, lost.motor, lost.motor_rate))
    assert (np.diff(fallen, axis=0) < 1e-9).all()
    assert (fallen[-1] < fallen[0] - 1e-3).all()


@pytest.mark.capability("10-89")
def test_small_swings_are_those_of_the_linear_joints():
    # Without gravity and far from motion, M(q) is constant: eigenvalues of [[M, 0], [0, B]]^-1 [[K, -K], [-K, K]].
    robot = mf.load("planar2r")
    arm = elastic_arm(robot, [2000.0, 1000.0], motor_inertia=[0.4, 0.1])
    q = np.array([0.3, 0.9])
    M, K, zero = arm.links.mass_matrix(q), np.diag(arm.stiffness), np.zeros((2, 2))
    mass = np.block([[M, zero], [zero, np.diag(arm.motor_inertia)]])
    wave, mode = np.linalg.eig(np.linalg.solve(mass, np.block([[K, -K], [-K, K]])))
    fastest = int(wave.argmax())
    w, shape = np.sqrt(wave[fastest]), 1e-7 * mode[:, fastest].real / np.abs(mode[:, fastest]).max()
    still = arm.at_rest(q)
    start = still._replace(q=still.q + shape[:2], motor=still.motor + shape[2:])

    class Holding(Nothing):
        def __call__(self, t, state, reference):
            return arm.links.gravity_torque(q)

    run = simulate_elastic(arm, Holding(), rest(q, 0.05), start=start, step=5e-5)
    swing = run.motor - still.motor
    np.testing.assert_allclose(swing, np.cos(w * run.t)[:, None] * shape[2:], atol=3e-10)
    single = ElasticJoint.of(M[0, 0], 0.4, 2000.0)
    assert single.first_mode > single.locked_frequency


@pytest.mark.capability("10-89")
def test_rotors_of_the_model_are_the_motors_and_the_rigid_arm_is_the_limit():
    robot = mf.load("puma560")
    stiff = elastic_arm(robot, 3e6)
    q = np.random.default_rng(1).normal(size=(4, 6))
    together = stiff.links.mass_matrix(q) + np.diag(stiff.motor_inertia)
    np.testing.assert_allclose(together, robot.mass_matrix(q), rtol=1e-10, atol=1e-12)
    bare = mf.load("planar2r").mechanism
    rotors = [Actuator(armature=0.4), Actuator(armature=0.1), *[None] * (len(bare.joints) - 2)]
    joints = tuple(replace(j, actuator=rotors.pop(0)) if j.moves else j for j in bare.joints)
    geared = mf.Robot(replace(bare, joints=joints))
    path, errors = quintic(np.zeros(2), np.array([0.5, -0.8]), 0.5), []
    for stiffness in (1e4, 1e5):
        arm = elastic_arm(geared, stiffness)
        np.testing.assert_allclose(arm.motor_inertia, [0.4, 0.1])
        law = singular_perturbation_control(
            arm, computed_torque(geared, natural_frequency=30.0), 0.5 * np.sqrt(stiffness * 0.1)
        )
        run = simulate_elastic(arm, law, path, step=1e-4)
        assert run
        errors.append(np.abs(run.q - run.q_ref).max())
    assert errors[1] < 0.2 * errors[0] < 1e-3


@pytest.mark.capability("10-89")
def test_motors_alone_bring_the_links_to_the_goal(arm):
    law = motor_feedback(arm, [600.0, 300.0], [60.0, 20.0])
    condition = set_point_condition(law)
    assert condition.status is SetPointStatus.GLOBAL
    assert f"{condition.gravity:.4g}" in condition.explain("en")
    goal = np.array([0.7, -0.4])
    starts = arm.at_rest(np.random.default_rng(2).uniform(-2, 2, (4, 2)))
    run = simulate_elastic(arm, law, rest(goal, 6.0), start=starts, step=5e-4)
    assert run
    np.testing.assert_allclose(run.q[-1], np.broadcast_to(goal, (4, 2)), atol=1e-4)
    np.testing.assert_allclose(run.tau[-1], np.broadcast_to(arm.links.gravity_torque(goal), (4, 2)), atol=0.05)
    weak = set_point_condition(motor_feedback(arm, 1.0, 1.0))
    assert weak.status is SetPointStatus.NOT_SHOWN
    assert weak.explain("ar") != weak.explain("en")


@pytest.mark.capability("10-89", "10-112")
def test_the_linearised_links_fall_as_four_equal_roots(arm):
    goal, away, p = np.array([0.4, 0.6]), np.array([0.3, -0.2]), 15.0
    law = elastic_linearization(arm, rest(goal, 1.0), rate=p)
    run = simulate_elastic(arm, law, rest(goal, 1.0), start=arm.at_rest(goal + away), step=2e-4)
    x = p * run.t
    shape = np.exp(-x) * (1 + x + x**2 / 2 + x**3 / 6)
    np.testing.assert_allclose(run.q - goal, shape[:, None] * away, atol=2e-3)
    # The efforts are held within each step: a quarter of the step leaves a quarter of the difference.
    worst = []
    for step in (8e-4, 2e-4):
        again = simulate_elastic(arm, law, rest(goal, 0.4), start=arm.at_rest(goal + away), step=step)
        x = p * again.t
        shape = np.exp(-x) * (1 + x + x**2 / 2 + x**3 / 6)
        worst.append(np.abs(again.q - goal - shape[:, None] * away).max())
    assert worst[0] / worst[1] == pytest.approx(4.0, rel=0.3)


@pytest.mark.capability("10-89")
def test_a_law_for_rigid_joints_makes_soft_ones_swing_and_damping_helps():
    robot = mf.load("planar2r")
    soft = elastic_arm(robot, [150.0, 80.0], motor_inertia=[0.4, 0.1])
    rigid = computed_torque(robot, natural_frequency=12.0)
    path = quintic(np.zeros(2), np.array([0.5, 0.5]), 0.6)
    plain = simulate_elastic(soft, singular_perturbation_control(soft, rigid, 0.0), path, duration=2.0, step=5e-4)
    exact = simulate_elastic(soft, elastic_linearization(soft, path, rate=20.0), path, duration=2.0, step=5e-4)
    assert np.abs(exact.q[-1] - exact.q_ref[-1]).max() < 1e-4
    assert not plain or np.abs(plain.q[-1] - plain.q_ref[-1]).max() > 1e-2


def test_what_is_wrong_is_refused(arm):
    robot = mf.load("planar2r")
    with pytest.raises(InputError, match="stiffness"):
        elastic_arm(robot, [0.0, 1.0], motor_inertia=1.0)
    with pytest.raises(InputError, match="motor_inertia"):
        elastic_arm(robot, 100.0, motor_inertia=0.0)
    damped = elastic_arm(robot, 100.0, damping=1.0, motor_inertia=1.0)
    with pytest.raises(InputError, match="damping"):
        elastic_linearization(damped, rest(np.zeros(2), 1.0))
    with pytest.raises(InputError):
        simulate_elastic(arm, Nothing(), rest(np.zeros(2), 1.0), step=0.0)

    class Nonsense(Nothing):
        def __call__(self, t, state, reference):
            return np.full_like(state.q, np.nan) if t > 0.01 else np.zeros_like(state.q)

    run = simulate_elastic(arm, Nonsense(), rest(np.zeros(2), 1.0))
    assert run.status is SimulationStatus.NOT_FINITE
    assert np.isfinite(run.q).all()
    coarse = simulate_elastic(arm, Nothing(), rest(np.zeros(2), 60.0), step=0.1)
    assert coarse.status is SimulationStatus.BLOWN_UP


@pytest.mark.capability("10-89")
@pytest.mark.parametrize(
    ("wrong", "status"),
    [
        (lambda: np.zeros(2)[[3]], SimulationStatus.LAW_RAISED),
        (lambda: "much", SimulationStatus.LAW_NONSENSE),
        (lambda: np.full(2, np.nan), SimulationStatus.NOT_FINITE),
    ],
)
def test_a_function_that_fails_ends_the_run_with_its_name(arm, wrong, status):
    def clumsy(t, state, reference):
        return wrong() if t > 0.01 else arm.links.gravity_torque(reference.u)

    run = simulate_elastic(arm, clumsy, rest(np.zeros(2), 0.1))
    assert run.status is status
    assert run.t[-1] == pytest.approx(0.0102)
    assert status is SimulationStatus.NOT_FINITE or "clumsy" in run.explain("en")
    with pytest.raises(InputError, match="ElasticLaw"):
        simulate_elastic(arm, lambda t, state: state, rest(np.zeros(2), 0.1))
