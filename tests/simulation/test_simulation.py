"""Closed loops against theory: energy, error decay, determinism, batches, and honest endings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import computed_torque, gravity_compensation, pid
from mafsil.errors import InputError
from mafsil.simulation import Plant, SensorNoise, WrenchPulse
from mafsil.simulation.recording import SimulationStatus
from mafsil.trajectory import Motion, quintic
from mafsil.trajectory.profiles import rest

Q = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])


@pytest.fixture(scope="module")
def panda():
    return mf.load("panda")


class Passive:
    """No efforts at all."""

    def __call__(self, t, q, qd, reference):
        return np.zeros_like(q)

    def session(self, period):
        return self


def reach(duration=1.0):
    return quintic(Q, Q + np.array([0.5, 0.3, -0.4, 0.5, 0.3, -0.2, 0.6]), duration)


@pytest.mark.capability("09-7", "09-65", "10-14")
@pytest.mark.parametrize(
    ("integrator", "order"), [("rk4", 4), ("heun", 2), ("midpoint", 2), ("euler", 1), ("semi_implicit_euler", 1)]
)
def test_energy_drift_of_a_falling_arm_has_the_method_s_order(integrator, order):
    robot = mf.load("planar2r_point_masses")
    drift = []
    for step in (4e-3, 2e-3, 1e-3):
        run = mf.simulate(
            mf.Scenario(
                robot=robot,
                trajectory=rest([0.3, 0.4], 0.4),
                law=Passive(),
                plant=Plant(robot, friction=False),
                step=step,
                integrator=integrator,
            )
        )
        energy = robot.kinetic_energy(run.q, run.qd) + robot.potential_energy(run.q)
        drift.append(np.abs(energy[-1] - energy[0]))
    np.testing.assert_allclose(np.log2(np.array(drift[:-1]) / drift[1:]), order, atol=0.1)


@pytest.mark.capability("10-51", "10-48")
@pytest.mark.parametrize("zeta", [0.5, 1.0, 1.5])
def test_tracking_error_decays_as_theory_says(panda, zeta):
    """With the true model e'' + 2 zeta w e' + w^2 e = 0; the loop is sampled, so the error shrinks with the period."""
    w, offset = 15.0, 0.02 * np.array([1, -1, 1, 1, -1, 1, 1])
    misfit = []
    for period in (1e-3, 5e-4):
        run = mf.simulate(
            mf.Scenario(
                robot=panda,
                trajectory=reach(),
                law=computed_torque(panda, natural_frequency=w, damping_ratio=zeta),
                q=Q - offset,
                step=period,
                integrator="heun",
                saturate=False,
            )
        )
        roots = np.roots([1.0, 2 * zeta * w, w * w]).astype(complex)
        if abs(roots[0] - roots[1]) < 1e-6:
            theory = (1 + w * run.t) * np.exp(-w * run.t)
        else:
            theory = (
                (roots[1] * np.exp(roots[0] * run.t) - roots[0] * np.exp(roots[1] * run.t)) / (roots[1] - roots[0])
            ).real
        misfit.append(np.abs((run.q_ref - run.q) / offset - theory[:, None]).max())
    assert misfit[1] < 0.01
    assert misfit[0] / misfit[1] == pytest.approx(2.0, abs=0.3)


def test_batches_equal_single_runs(panda):
    starts = Q + 0.03 * np.random.default_rng(0).normal(size=(3, 2, 7))
    scenario = mf.Scenario(robot=panda, trajectory=reach(0.1), law=computed_torque(panda), q=starts)
    whole = mf.simulate(scenario)
    assert whole.q.shape == (101, 3, 2, 7)
    assert whole.tip_position_error.shape == (101, 3, 2)
    for index in np.ndindex(3, 2):
        alone = mf.simulate(replace(scenario, q=starts[index]))
        for name, array in alone.arrays().items():
            if name != "t":
                np.testing.assert_allclose(whole.arrays()[name][(slice(None), *index)], array, rtol=1e-9, atol=1e-9)


def test_equal_scenarios_give_equal_bits(panda):
    scenario = mf.Scenario(
        robot=panda, trajectory=reach(0.2), law=computed_torque(panda, integral=100.0), noise=SensorNoise(1e-4, 1e-3, 5)
    )
    one, two = mf.simulate(scenario), mf.simulate(scenario)
    for name, array in one.arrays().items():
        np.testing.assert_array_equal(array, two.arrays()[name])
    other = mf.simulate(replace(scenario, noise=SensorNoise(1e-4, 1e-3, 6)))
    assert not np.array_equal(other.q, one.q)


@pytest.mark.capability("10-9")
def test_control_rate_and_step_are_apart(panda):
    run = mf.simulate(
        mf.Scenario(robot=panda, trajectory=reach(0.5), law=computed_torque(panda), step=1e-3, period=5e-3)
    )
    assert len(run.t) == 101
    assert run.t[1] == pytest.approx(5e-3)
    assert run.tip_position_error.max() < 0.01
    with pytest.raises(InputError, match="period"):
        mf.Scenario(robot=panda, trajectory=reach(), law=Passive(), step=1e-3, period=2.5e-3)


@pytest.mark.capability("10-32", "10-37")
def test_unknown_payload_leaves_an_error_that_the_integral_removes(panda):
    plant = Plant(panda).with_payload(2.0, [0.0, 0.0, 0.1])
    settings = {"robot": panda, "trajectory": rest(Q, 10.0), "plant": plant, "step": 2e-3}
    sagging = mf.simulate(mf.Scenario(law=computed_torque(panda, natural_frequency=10.0), **settings))
    steady = np.abs(sagging.q_ref - sagging.q)[-1].max()
    assert steady > 0.01
    # At rest M Kp e = g_true - g_model.
    e = (sagging.q_ref - sagging.q)[-1]
    q = sagging.q[-1]
    missing = plant.robot.gravity_torque(q) - panda.gravity_torque(q)
    np.testing.assert_allclose(panda.mass_matrix(q) @ (100.0 * e), missing, atol=1e-4)
    integral = computed_torque(panda, natural_frequency=10.0, integral=500.0)
    assert np.abs((lambda r: r.q_ref - r.q)(mf.simulate(mf.Scenario(law=integral, **settings))))[-1].max() < steady / 50


@pytest.mark.capability("09-64")
def test_payload_and_push_agree_with_statics(panda):
    """A payload's weight is a push at the tip: M is unchanged to first order only at rest, torques exactly."""
    mass, com = 1.5, np.array([0.02, -0.01, 0.1])
    loaded = Plant(panda).with_payload(mass, com).robot
    T = panda.forward_kinematics(Q)
    force = T[:3, :3].T @ np.array([0.0, 0.0, -9.81 * mass])
    push = np.concatenate([np.cross(com, force), force])
    np.testing.assert_allclose(
        loaded.gravity_torque(Q), panda.gravity_torque(Q) - panda.jacobian_body(Q).T @ push, atol=1e-10
    )
    held = Plant(panda, friction=False).acceleration(Q, np.zeros(7), loaded.gravity_torque(Q), push)
    np.testing.assert_allclose(held, 0.0, atol=1e-8)


def test_scaled_inertia_scales_everything(panda):
    heavy = Plant(panda).with_scaled_inertia(1.2).robot
    np.testing.assert_allclose(heavy.mass_matrix(Q), 1.2 * panda.mass_matrix(Q), rtol=1e-12)
    factors = np.ones(len(panda.mechanism.links))
    np.testing.assert_array_equal(
        Plant(panda).with_scaled_inertia(factors).robot.gravity_torque(Q), panda.gravity_torque(Q)
    )


def test_a_push_disturbs_only_from_its_start(panda):
    scenario = mf.Scenario(robot=panda, trajectory=rest(Q, 0.5), law=gravity_compensation(panda, 200.0, 20.0))
    quiet = mf.simulate(scenario)
    pulse = WrenchPulse(0.2, 0.1, [0, 0, 0, 10.0, 0, 0])
    pushed = mf.simulate(replace(scenario, disturbances=(pulse,)))
    before = pushed.t <= 0.2
    np.testing.assert_array_equal(pushed.q[before], quiet.q[before])
    assert np.abs(pushed.q - quiet.q)[-1].max() > 1e-4
    k = int(np.argmin(np.abs(pushed.t - 0.25)))
    expected = panda.forward_dynamics(pushed.q[k], pushed.qd[k], pushed.tau[k], -pulse.push)
    np.testing.assert_allclose(pushed.qdd[k], expected, atol=1e-9)


@pytest.mark.capability("10-30")
def test_saturation_is_respected_and_recorded(panda):
    run = mf.simulate(
        mf.Scenario(robot=panda, trajectory=rest(Q, 0.3), law=computed_torque(panda, natural_frequency=60.0), q=Q + 0.3)
    )
    assert (np.abs(run.tau) <= panda.limits.effort).all()
    assert run.saturated.any()
    assert (np.abs(run.tau_commanded[run.saturated]) > 12.0).all()


def test_blow_up_keeps_the_last_good_state(panda):
    run = mf.simulate(
        mf.Scenario(
            robot=panda, trajectory=rest(Q, 5.0), law=pid(7, kp=1e7, kd=0.0), q=Q + 0.1, step=5e-3, saturate=False
        )
    )
    assert run.status is SimulationStatus.BLOWN_UP
    assert 0 < len(run.t) < 1001
    for array in run.arrays().values():
        assert np.isfinite(array).all()
    assert "diverged" in run.explain("en")
    assert run.explain("ar")


class Broken(Passive):
    """Efforts that stop being numbers after a while."""

    def __call__(self, t, q, qd, reference):
        return np.full_like(q, np.nan if t > 0.05 else 0.0)


def test_a_law_that_is_not_finite_ends_the_run(panda):
    run = mf.simulate(mf.Scenario(robot=panda, trajectory=rest(Q, 1.0), law=Broken()))
    assert run.status is SimulationStatus.NOT_FINITE
    assert run.duration == pytest.approx(0.05)
    assert "law" in run.explain("en")
    assert run.explain("ar")


def test_progress_can_cancel(panda):
    seen = []

    def stop(fraction):
        seen.append(fraction)
        return fraction < 0.5

    run = mf.simulate(mf.Scenario(robot=panda, trajectory=rest(Q, 1.0), law=Passive()), stop)
    assert run.status is SimulationStatus.CANCELLED
    assert seen == sorted(seen)
    assert run.duration == pytest.approx(0.5, abs=0.02)
    assert run.explain("en")
    assert run.explain("ar")


class Misshapen(Passive):
    """Efforts of a wrong shape."""

    def __call__(self, t, q, qd, reference):
        return np.zeros(3)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"step": 0.0}, "step"),
        ({"step": np.nan}, "step"),
        ({"duration": -1.0}, "duration"),
        ({"integrator": "magic"}, "magic"),
        ({"q": np.zeros(6)}, "q"),
        ({"qd": np.full(7, np.nan)}, "qd"),
        ({"trajectory": rest([0.0], 1.0)}, "trajectory"),
    ],
)
def test_wrong_scenarios_are_named(panda, change, words):
    with pytest.raises(InputError, match=words):
        mf.Scenario(**({"robot": panda, "trajectory": rest(Q, 0.1), "law": Passive()} | change))


def test_wrong_parts_are_named(panda):
    with pytest.raises(InputError, match="law"):
        mf.simulate(mf.Scenario(robot=panda, trajectory=rest(Q, 0.1), law=Misshapen()))
    with pytest.raises(InputError, match="push"):
        WrenchPulse(0.0, 1.0, [1.0, 2.0])
    with pytest.raises(InputError, match="duration"):
        WrenchPulse(0.0, 0.0, np.zeros(6))
    with pytest.raises(InputError, match="mass"):
        Plant(panda).with_payload(-1.0)
    with pytest.raises(InputError, match="factor"):
        Plant(panda).with_scaled_inertia(0.0)
    with pytest.raises(InputError, match="factor"):
        Plant(panda).with_scaled_inertia([1.0, 2.0])


def test_start_is_the_trajectory_s(panda):
    run = mf.simulate(mf.Scenario(robot=panda, trajectory=reach(0.2), law=computed_torque(panda)))
    np.testing.assert_array_equal(run.q[0], Q)
    np.testing.assert_array_equal(run.q_ref[0], Q)
    assert isinstance(run.metadata["seconds"], float)
    assert run.status is SimulationStatus.COMPLETED
    assert Motion(run.q_ref, run.qd_ref, run.qdd_ref).v.shape == run.q.shape
