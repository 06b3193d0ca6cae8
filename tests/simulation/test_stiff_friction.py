"""Friction on light links: too stiff for explicit integrators at the default step, chosen and integrated implicitly."""

from __future__ import annotations

import sysconfig
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import computed_torque
from mafsil.errors import InputError
from mafsil.simulation import Plant, choose_integrator
from mafsil.simulation.recording import SimulationStatus
from mafsil.simulation.stepping import by_secants, damped_acceleration
from mafsil.trajectory import quintic
from mafsil.trajectory.profiles import rest

FOLDER = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix" / "share" / "example-robot-data" / "robots"
LIGHT = ("xarm_description/urdf/xarm7.urdf", "z1_description/urdf/z1.urdf")


def light_pendulum(coulomb=1.0, viscous=0.0):
    """A bob of 10 g m^2 with friction: 1e5 times its inertia over a millisecond."""
    link = mf.model.Link("bob", mf.model.Inertial(0.1, np.array([0.3, 0.0, 0.0]), 1e-3 * np.eye(3)))
    joint = mf.model.Joint(
        "pivot",
        mf.model.JointKind.REVOLUTE,
        "ground",
        "bob",
        axis=(0, 1, 0),
        friction=mf.model.Friction(viscous, coulomb),
    )
    return mf.Robot(mf.Mechanism.assemble("pendulum", [mf.model.Link("ground"), link], [joint], tip="bob"))


class Held:
    """A constant effort."""

    def __init__(self, effort):
        self.effort = effort

    def __call__(self, t, q, qd, reference):
        return np.full_like(q, self.effort)

    def session(self, period):
        return self


@pytest.mark.parametrize("path", LIGHT)
@pytest.mark.parametrize("step", [1e-3, 2e-3])
def test_light_arms_run_at_the_default_step(path, step):
    if not (FOLDER / path).exists():
        pytest.skip("example-robot-data is not installed")
    robot = mf.load(str(FOLDER / path))
    q = np.clip(np.full(robot.n, 0.3), robot.limits.lower, robot.limits.upper)
    scenario = mf.Scenario(
        robot=robot, trajectory=quintic(q, q + 0.1, 0.5), law=computed_torque(robot, natural_frequency=20.0), step=step
    )
    run = mf.simulate(scenario)
    assert run.status is SimulationStatus.COMPLETED
    assert run.metadata["integrator"] == "implicit_friction"
    assert run.tip_position_error.max() < 0.05
    wrong = mf.simulate(replace(scenario, integrator="semi_implicit_euler"))
    assert wrong.status is SimulationStatus.BLOWN_UP
    assert "implicit_friction" in wrong.explain("en")
    assert "implicit_friction" in wrong.explain("ar")
    assert choose_integrator(Plant(robot), q, step, "rk4") == "implicit_friction"
    assert choose_integrator(Plant(robot, friction=False), q, step, "rk4") == "rk4"


def test_a_joint_below_breakaway_stays_and_above_it_accelerates_by_the_rest():
    robot = light_pendulum(coulomb=1.0)
    q = np.array([np.pi / 2])  # hanging: gravity is balanced
    gravity = robot.gravity_torque(q)[0]

    def run(effort):
        return mf.simulate(
            mf.Scenario(robot=robot, trajectory=rest(q, 0.3), law=Held(effort + gravity), duration=0.3, step=2e-3)
        )

    held = run(0.5)
    assert held.metadata["integrator"] == "implicit_friction"
    # The smooth sign creeps at the rate where the curve carries the load: atanh(1/2) mm/s, no more.
    assert abs(held.qd[-1, 0]) < 1.01e-3 * np.arctanh(0.55)
    moving = run(3.0)
    inertia = robot.mass_matrix(q)[0, 0]
    early = slice(5, 15)
    np.testing.assert_allclose(moving.qdd[early, 0], (3.0 - 1.0) / inertia, rtol=0.3)


@pytest.mark.parametrize("step", [1e-3, 1e-2])
def test_friction_alone_never_adds_energy(step):
    robot = light_pendulum(coulomb=2.0, viscous=0.5)
    free = replace(robot.mechanism, gravity=np.zeros(3))
    robot = mf.Robot(free)
    starts = np.geomspace(1e-6, 1e3, 25)[:, None]
    run = mf.simulate(
        mf.Scenario(
            robot=robot,
            trajectory=rest([0.0], 0.2),
            law=Held(0.0),
            q=np.zeros((25, 1)),
            qd=starts,
            step=step,
            integrator="implicit_friction",
        )
    )
    speed = np.abs(run.qd[..., 0])
    assert (np.diff(speed, axis=0) <= 1e-12).all()
    assert (speed[-1] < 1e-3).sum() >= 15


def test_implicit_friction_converges_to_the_explicit_motion():
    arm = mf.load("puma560")
    q = np.array([0.2, -0.4, 0.6, 0.3, -0.5, 0.1])
    base = mf.Scenario(
        robot=arm, trajectory=quintic(q, q + 0.3, 0.1), law=computed_torque(arm), saturate=False, period=1e-3, step=1e-3
    )
    fine = mf.simulate(replace(base, step=2e-5, integrator="rk4"))
    errors = [
        np.abs(mf.simulate(replace(base, step=step, integrator="implicit_friction")).q[-1] - fine.q[-1]).max()
        for step in (1e-3, 5e-4, 2.5e-4)
    ]
    np.testing.assert_allclose(np.log2(np.array(errors[:-1]) / errors[1:]), 1.0, atol=0.1)


def test_unknown_integrators_are_named():
    arm = mf.load("planar2r")
    with pytest.raises(InputError, match="implicit_friction"):
        mf.Scenario(robot=arm, trajectory=rest([0, 0], 1.0), law=Held(0.0), integrator="magic")


def test_long_tables_leave_ticks_out_and_say_so(tmp_path, monkeypatch):
    import json

    from mafsil.simulation import recording

    arm = mf.load("planar2r")
    run = mf.simulate(mf.Scenario(robot=arm, trajectory=rest([0.1, 0.2], 0.5), law=computed_torque(arm)))
    monkeypatch.setattr(recording, "TABLE_NUMBERS", 1000)
    npz, csv, note = run.save(tmp_path / "long")
    every = json.loads(note.read_text())["csv_every_tick"]
    rows = np.loadtxt(csv, delimiter=",", skiprows=1, usecols=0)
    assert every > 1
    assert len(rows) <= 1000 / len(run.columns()) + 2
    np.testing.assert_array_equal(rows[:-1], run.t[::every][: len(rows) - 1])
    assert rows[-1] == run.t[-1]
    assert len(mf.Recording.load(npz).t) == len(run.t)


def test_a_compiled_step_is_that_by_secants_and_a_row_that_is_lost_leaves_the_others_alone():
    plant, rng = Plant(mf.load("puma560")), np.random.default_rng(8)
    q, qd, tau = rng.uniform(-1.0, 1.0, (4, 6)), rng.normal(size=(4, 6)), 20.0 * rng.normal(size=(4, 6))
    qd[2] = 0.0
    found = damped_acceleration(plant, q, qd, tau, None, 1e-3)
    M, load = plant.robot.mass_matrix(q), tau - plant.robot.inverse_dynamics(q, qd, np.zeros(6))

    def solved(D, b):
        return np.linalg.solve(M + D, b[..., None])[..., 0]

    np.testing.assert_allclose(found, by_secants(plant, qd, load, 1e-3, solved), rtol=1e-11, atol=1e-11)
    qd[1, 2] = np.nan
    spoilt = damped_acceleration(plant, q, qd, tau, None, 1e-3)
    assert np.isnan(spoilt[1]).all()
    np.testing.assert_array_equal(spoilt[[0, 2, 3]], found[[0, 2, 3]])
    np.testing.assert_array_equal(damped_acceleration(plant, q[3], qd[3], tau[3], None, 1e-3), found[3])
