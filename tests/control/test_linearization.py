"""Arms as linear systems: against differences, MuJoCo, SciPy; gain cards against simulation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

import mafsil as mf
from mafsil.control import add_delay, computed_torque, gravity_compensation, linearize, tune_gains
from mafsil.control.analysis import GainLimit
from mafsil.control.analysis.linearization import exponential
from mafsil.errors import InputError
from mafsil.simulation import Plant, Scenario
from mafsil.trajectory import Motion
from mafsil.trajectory.profiles import rest


@pytest.fixture(scope="module")
def states():
    rng = np.random.default_rng(0)
    robot = mf.load("panda")
    low, high = robot.limits.lower, robot.limits.upper
    return robot, rng.uniform(low, high, (4, 7)), rng.normal(size=(4, 7)), 5 * rng.normal(size=(4, 7))


def test_derivatives_are_those_of_forward_dynamics(states):
    robot, q, qd, tau = states
    found, h = linearize(robot, q, qd, tau), 1e-6
    viscous = np.array([0.0 if j.friction is None else j.friction.viscous for j in robot.mechanism.coordinates])

    def accelerations(x, u):
        return robot.forward_dynamics(x[:, :7], x[:, 7:], u - viscous * x[:, 7:])

    x = np.concatenate([q, qd], axis=1)
    effort = tau + viscous * qd
    scale = np.abs(found.A).max()
    for k, step in enumerate(h * np.eye(14)):
        numeric = (accelerations(x + step, effort) - accelerations(x - step, effort)) / (2 * h)
        np.testing.assert_allclose(found.A[:, 7:, k], numeric, atol=1e-6 * scale)
    for k, step in enumerate(h * np.eye(7)):
        numeric = (accelerations(x, effort + step) - accelerations(x, effort - step)) / (2 * h)
        np.testing.assert_allclose(found.B[:, 7:, k], numeric, atol=1e-6 * np.abs(found.B).max())
    np.testing.assert_array_equal(found.A[:, :7], np.broadcast_to(np.eye(7, 14, 7), (4, 7, 14)))
    still = linearize(robot, q[0])
    np.testing.assert_allclose(still.tau, robot.gravity_torque(q[0]), atol=1e-12)


def test_exponentials_and_discrete_systems_are_those_of_scipy(states):
    rng = np.random.default_rng(1)
    A = rng.normal(size=(20, 6, 6)) * np.geomspace(1e-3, 30, 20)[:, None, None]
    for one, found in zip(A, exponential(A), strict=True):
        reference = expm(one)
        np.testing.assert_allclose(found, reference, atol=1e-10 * np.abs(reference).max())
    robot, q, *_ = states
    system = linearize(robot, q[0])
    Ad, Bd = system.discrete(0.01)
    whole = np.zeros((21, 21))
    whole[:14, :14], whole[:14, 14:] = system.A, system.B
    reference = expm(0.01 * whole)
    np.testing.assert_allclose(Ad, reference[:14, :14], atol=1e-11)
    np.testing.assert_allclose(Bd, reference[:14, 14:], atol=1e-11)


def test_the_loop_of_computed_torque_has_the_poles_that_are_asked_for(states):
    robot, q, *_ = states
    law = computed_torque(robot, natural_frequency=20.0, damping_ratio=0.5)
    frictionless = linearize(robot, q[0])
    loop = frictionless.close_loop(law, Motion(q[0], np.zeros(7), np.zeros(7)))
    viscous = [j.friction.viscous if j.friction else 0.0 for j in robot.mechanism.coordinates]
    if not any(viscous):
        np.testing.assert_allclose(np.abs(loop.poles), 20.0, rtol=1e-3)
        np.testing.assert_allclose(-loop.poles.real / np.abs(loop.poles), 0.5, rtol=1e-3)
    assert (loop.poles.real < 0).all()


def test_conversion_says_what_is_missing(states):
    robot, q, *_ = states
    system = linearize(robot, q[0])
    try:
        import control
    except ImportError:
        with pytest.raises(InputError, match="pip install control"):
            system.to_control()
    else:
        assert isinstance(system.to_control(), control.StateSpace)
    with pytest.raises(InputError):
        linearize(robot, q).to_control()
    assert system.D.shape == (14, 7)
    assert (system.C == np.eye(14)).all()


def measured_damping(card, robot, law):
    """The least damped mode of the map from sample to sample that small simulated motions at the worst pose have."""
    n, late = robot.n, round(card.delay / card.period)
    rng, ticks = np.random.default_rng(0), 14 + 3 * late
    starts = 1e-6 * rng.normal(size=(2, (8 + 2 * late) * n, n)) * np.array([1.0, card.frequency])[:, None, None]
    run = mf.simulate(
        Scenario(
            robot=robot, plant=Plant(robot, friction=False), trajectory=rest(card.worst_pose, ticks * card.period),
            law=add_delay(law, card.delay) if late else law, q=card.worst_pose + starts[0], qd=starts[1],
            step=card.period / 4, period=card.period, saturate=False, integrator="rk4",
        )
    )  # fmt: skip
    effort = run.tau_commanded - robot.gravity_torque(card.worst_pose)
    parts = [run.q - card.worst_pose, run.qd / card.frequency]
    parts += [np.roll(effort, -k, axis=0) / (card.gains.kp.max()) for k in range(late)]
    x = np.concatenate(parts, axis=-1)[late : ticks - late]
    before, after = (part.reshape(-1, n * (2 + late)) for part in (x[:-1], x[1:]))
    z = np.linalg.eigvals(np.linalg.lstsq(before, after, rcond=None)[0].T).astype(complex)
    z = z[(np.abs(np.angle(z)) > 1e-4) & (np.abs(z) > 1e-3)]
    # What dies within the delay is the queue of efforts, no motion of the arm.
    z = z[-np.log(np.abs(z)) * (late + 1) <= 2.0] if late else z
    decay, turn = -np.log(np.abs(z)), np.abs(np.angle(z))
    return (decay / np.hypot(decay, turn)).min()


@pytest.mark.parametrize("delay", [0.0, 0.002])
@pytest.mark.parametrize("kind", ["pd_gravity", "computed_torque"])
def test_the_promised_damping_is_that_of_a_simulation_at_the_worst_pose(kind, delay):
    robot = mf.load("puma560")
    card = tune_gains(robot, law=kind, period=0.002, delay=delay, poses=100)
    assert card
    assert card.status is (GainLimit.DELAY if delay else GainLimit.SAMPLING)
    law = (
        gravity_compensation(robot, card.gains.kp, card.gains.kd)
        if kind == "pd_gravity"
        else computed_torque(robot, natural_frequency=card.natural_frequency, damping_ratio=0.7)
    )
    assert measured_damping(card, robot, law) == pytest.approx(card.damping_ratio, rel=0.1)


@pytest.mark.parametrize(("name", "period", "delay"), [("ur5e", 0.001, 0.01), ("planar2r", 0.004, 0.008)])
def test_a_delay_of_many_periods_costs_no_more_than_its_time(name, period, delay):
    """Efforts that wait in a queue are no oscillation: a step overshoots as it does without sampling and delay."""
    robot = mf.load(name)
    card = tune_gains(robot, law="computed_torque", period=period, delay=delay, poses=20)
    law = computed_torque(robot, natural_frequency=card.natural_frequency, damping_ratio=0.7)
    assert card.damping_ratio == pytest.approx(0.63, rel=1e-3)
    assert measured_damping(card, robot, law) == pytest.approx(card.damping_ratio, rel=0.1)
    # Half a period of holding and the delay: a second-order loop loses a tenth of its damping at a third of a radian.
    assert 0.25 < card.natural_frequency * (delay + period / 2) < 0.45
    run = mf.simulate(
        Scenario(
            robot=robot, plant=Plant(robot, friction=False), law=add_delay(law, delay), q=card.worst_pose - 1e-3,
            trajectory=rest(card.worst_pose, 8 / card.natural_frequency), step=period / 2, period=period,
            saturate=False, integrator="rk4",
        )
    )  # fmt: skip
    overshoot = (run.q - card.worst_pose).max() / 1e-3
    assert overshoot < np.exp(-np.pi * 0.63 / np.sqrt(1 - 0.63**2)) + 0.02


def test_a_run_is_as_many_linear_systems_as_it_has_ticks(states):
    robot, q, qd, *_ = states
    along = linearize(robot, q, qd)
    assert len(along) == len(q)
    for k, each in enumerate(along):
        one = linearize(robot, q[k], qd[k])
        assert np.array_equal(each.A, one.A)
        assert np.array_equal(each.B, one.B)
    assert len(along[2:4]) == 2
    assert np.array_equal(along[-1].A, along.A[-1])
    assert len(linearize(robot, q[0])) == 1
    assert next(iter(linearize(robot, q[0]))).A.shape == (14, 14)


def test_slower_clocks_and_soft_joints_lower_the_gains():
    robot = mf.load("ur5e")
    quick, slow = (tune_gains(robot, period=period, poses=100) for period in (0.001, 0.004))
    assert slow.natural_frequency == pytest.approx(quick.natural_frequency / 4, rel=1e-3)
    late = tune_gains(robot, period=0.001, delay=0.003, poses=100)
    assert late.natural_frequency < 0.7 * quick.natural_frequency
    soft = tune_gains(robot, period=0.001, stiffness=np.full(6, 1e3), poses=100)
    assert soft.status is GainLimit.ELASTICITY
    inertia = np.einsum("kii->ki", robot.mass_matrix(np.stack([soft.worst_pose]))).max()
    assert soft.natural_frequency <= 0.5 * np.sqrt(1e3 / inertia) + 1e-9
    assert soft.explain("ar") != soft.explain("en")
    assert f"{soft.natural_frequency:.4g}" in soft.explain("en")
    with pytest.raises(InputError, match="law"):
        tune_gains(robot, law="magic")
    with pytest.raises(InputError, match="period"):
        tune_gains(robot, period=0.0)
