"""Force control on rigid surfaces: the sensor reads the multiplier, and the force is the one that is asked for."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import (
    Gains,
    Impedance,
    TaskCoordinates,
    admittance_control,
    hold_pose,
    hybrid_control,
    task_dynamics,
)
from mafsil.control.contact import TipForceSensor, hybrid_certificate, sampled_force_radius
from mafsil.control.contact.hybrid import HybridStatus
from mafsil.control.laws import TipMotion
from mafsil.errors import InputError
from mafsil.simulation import RigidPlant, RigidSurface, simulate
from mafsil.trajectory import line_path, time_law
from mafsil.trajectory.profiles import rest
from tests.simulation.rigid_scenes import BLOCK, MASS, G

PUMA, AT = mf.load("puma560"), np.array([0.2, 0.6, -0.9, 0.1, 0.7, 0.3])
START = PUMA.forward_kinematics(AT)
OUT = -START[:3, 2]


def surfaces():
    R = 0.3
    return {
        "plane": RigidSurface.plane(START[:3, 3], OUT),
        "rough plane": RigidSurface.plane(START[:3, 3], OUT, friction=0.2),
        "sphere": RigidSurface.sphere(START[:3, 3] - R * OUT, R),
        "hollow cylinder": RigidSurface.cylinder(START[:3, 3] + R * OUT, START[:3, 1], R, hollow=True),
    }


def wiped(surface, press, duration=0.15, heavier=0.0, **gains):
    """A line of 30 mm on a surface, pressed onto it."""
    plant = RigidPlant(PUMA, friction=False, surface=surface).with_scaled_inertia(1.0 + heavier)

    def normal(T):
        return np.concatenate([np.zeros(3), surface.outward(T[:3, 3])])

    def constraint(T, V):
        rate = surface.outward_rate(T[:3, 3], V[3:])
        return normal(T)[None], np.concatenate([np.zeros(3), rate])[None]

    end = START.copy()
    end[:3, 3] += 0.03 * START[:3, 0]
    tip = TipMotion(line_path(START, end), time_law("quintic").unit().scale_time(duration))
    law = hybrid_control(
        PUMA, tip, constraint, lambda T: -press * normal(T), gains=Gains.from_natural_frequency(6, 20.0),
        sensor=TipForceSensor(plant.robot, None, TaskCoordinates()), **gains,
    )  # fmt: skip
    return (
        law,
        tip,
        simulate(
            mf.Scenario(robot=PUMA, trajectory=rest(AT, duration), law=law, plant=plant, saturate=False, step=1e-3)
        ),
    )


def pressed(surface, run):
    """Force along the normal at each tick."""
    T = PUMA.forward_kinematics(run.q)
    return np.einsum("kij,kj,ki->k", T[:, :3, :3], run.contact_wrench[:, 3:], surface.outward(T[:, :3, 3]))


def apart(surface, run):
    return np.abs(surface.distance(PUMA.forward_kinematics(run.q)[:, :3, 3])).max()


@pytest.mark.capability("10-73", "10-74", "10-106")
@pytest.mark.parametrize("kind", ["plane", "sphere", "hollow cylinder"])
def test_hybrid_control_presses_with_the_force_that_is_asked_and_keeps_the_constraint(kind):
    surface = surfaces()[kind]
    _, tip, run = wiped(surface, 10.0)
    assert run
    assert np.abs(pressed(surface, run) - 10.0).max() < 1e-9
    assert apart(surface, run) < 1e-12
    if kind == "plane":
        T = PUMA.forward_kinematics(run.q)
        aside = T[:, :3, 3] - np.array([tip(t).pose[:3, 3] for t in run.t])
        assert np.linalg.norm(aside, axis=1).max() < 1e-4
    # The first reading is zero: the integral takes it for an error of one period, and forgets it.
    *_, run = wiped(surface, 10.0, force_ki=40.0)
    left = 0.4 * 0.96 ** np.arange(8)
    np.testing.assert_allclose(pressed(surface, run)[:8] - 10.0, left, atol=5e-4)


def test_on_a_rough_plane_the_integral_takes_out_what_friction_adds():
    surface = surfaces()["rough plane"]
    *_, run = wiped(surface, 10.0, duration=0.3, force_ki=100.0)
    T = PUMA.forward_kinematics(run.q)
    force = np.einsum("kij,kj->ki", T[:, :3, :3], run.contact_wrench[:, 3:])
    normal = force @ OUT
    assert np.abs(normal[100:250] - 10.0).max() < 0.3
    across = np.linalg.norm(force - np.outer(normal, OUT), axis=1)
    np.testing.assert_allclose(across[50:250], 0.2 * normal[50:250], rtol=1e-9)
    assert apart(surface, run) < 1e-12


def test_with_a_wrong_model_the_integral_brings_the_force_to_what_is_asked():
    surface = surfaces()["sphere"]
    off = []
    for gains in ({}, {"force_ki": 60.0}):
        *_, run = wiped(surface, 10.0, duration=0.25, heavier=0.2, **gains)
        off.append(np.abs(pressed(surface, run)[125:] - 10.0).max())
        assert apart(surface, run) < 1e-12
    assert off[0] > 3.0
    assert off[1] < 1.2


@pytest.mark.parametrize(("kp", "ki"), [(0.0, 40.0), (0.5, 100.0), (0.9, 10.0)])
def test_the_error_of_the_force_obeys_the_equation_of_the_sampled_loop(kp, ki):
    # A block that is heavier than its model: a constant disturbance. Each reading is of the effort one period before.
    plant = RigidPlant(BLOCK, surface=RigidSurface.plane(np.zeros(3), [0, 0, 1])).with_scaled_inertia(1.25)
    task, h, wanted = TaskCoordinates(rows=(3, 4, 5)), 2e-3, 30.0
    law = hybrid_control(
        BLOCK, hold_pose(np.eye(4)), [[0.0, 0.0, -1.0]], [0.0, 0.0, -wanted], coordinates=task,
        force_kp=kp, force_ki=ki,
        sensor=TipForceSensor(plant.robot, None, task),
    )  # fmt: skip
    run = simulate(
        mf.Scenario(robot=BLOCK, trajectory=rest(np.zeros(3), 12 * h), law=law, plant=plant, step=h, saturate=False)
    )
    errors, integral, e = [], 0.0, wanted
    for _ in range(12):
        integral += ki * h * e
        e = wanted - (wanted + kp * e + integral + 0.25 * MASS * G)
        errors.append(e)
    np.testing.assert_allclose(wanted - run.contact_wrench[:12, 5], errors, rtol=1e-8, atol=1e-8)
    # z^2 + (kp + ki h - 1) z - kp of the spec, whose largest root is the factor that is left in the end.
    ahead = np.array(errors[2:]) + (kp + ki * h - 1.0) * np.array(errors[1:-1]) - kp * np.array(errors[:-2])
    assert np.abs(ahead).max() < 1e-8
    assert float(sampled_force_radius(kp, ki * h)) < 1.0


@pytest.mark.capability("10-82")
@pytest.mark.parametrize("ratio", [0.7, 3.0])
def test_admittance_on_a_rigid_surface_renders_its_spring(ratio):
    surface = surfaces()["plane"]
    plant, task = RigidPlant(PUMA, friction=False, surface=surface), TaskCoordinates()
    sensor = TipForceSensor(PUMA, None, task)
    inertia = task_dynamics(PUMA, AT).inertia
    D = ratio * np.diagonal(inertia)
    soft = Impedance.of(6, inertia=D, damping=40.0 * D, stiffness=400.0 * D)
    target = START.copy()
    target[:3, 3] -= 0.005 * OUT
    law = admittance_control(PUMA, soft, hold_pose(target), sensor, coordinates=task)
    run = simulate(mf.Scenario(robot=PUMA, trajectory=rest(AT, 0.02), law=law, plant=plant, saturate=False))
    n = np.concatenate([np.zeros(3), OUT])
    felt = (n / D) @ n / (n @ np.linalg.solve(inertia, n))
    # f(k + 1) = f(k) (1 - n D^-1 n m) + m n D^-1 K X, from nothing read at the first tick, while the arm hardly moves.
    spring = 400.0 * 0.005 / (n @ np.linalg.solve(inertia, n))
    known = spring * np.cumsum((1.0 - felt) ** np.arange(5.0))
    force = np.linalg.norm(run.contact_wrench[:5, 3:], axis=1)
    np.testing.assert_allclose(force, known, rtol=2e-3)


def test_runs_beside_each_other_read_their_own_forces_and_none_is_read_outside():
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(lambda press: wiped(surfaces()["plane"], press, force_ki=40.0)[2], (5.0, 20.0)))
    for press, run in zip((5.0, 20.0), found, strict=True):
        assert np.linalg.norm(run.contact_wrench[7, 3:]) == pytest.approx(press * (1.0 + 0.04 * 0.96**7), rel=1e-4)
    with pytest.raises(InputError, match="RigidPlant"):
        TipForceSensor(PUMA, None, TaskCoordinates())(AT, np.zeros(6))


@pytest.mark.capability("10-106")
@pytest.mark.parametrize("heavier", [0.0, 0.2])
def test_a_certificate_says_whether_both_errors_obeyed_their_equations(heavier):
    law, _, run = wiped(surfaces()["plane"], 10.0, heavier=heavier, force_ki=40.0)
    found = hybrid_certificate(law, run.t, run.q, run.qd, run.contact_wrench)
    assert bool(found) == (heavier == 0.0)
    assert found.status is (HybridStatus.DEPARTED if heavier else HybridStatus.OBEYED)
    assert found.slowest_root == pytest.approx(-20.0)
    assert found.force_radius == pytest.approx(0.96)
    # What is along the constraint is no part of the motion's equation.
    assert np.abs(found.motion @ np.concatenate([np.zeros(3), OUT])).max() < 1e-9
    assert found.explain("en") != found.explain("ar")
    alone = hybrid_certificate(law, run.t, run.q, run.qd)
    assert alone.force_share == 0.0
    assert alone.motion_share == found.motion_share


@pytest.mark.capability("10-106")
def test_a_certificate_of_a_block_has_the_disturbance_as_its_rest():
    """Pressing with a weight that the model does not know: F_e + Kfp F_e' + Kfi int F_e' = -0.25 m g at each tick."""
    plant = RigidPlant(BLOCK, surface=RigidSurface.plane(np.zeros(3), [0, 0, 1])).with_scaled_inertia(1.25)
    task = TaskCoordinates(rows=(3, 4, 5))

    def law_of(ki):
        return hybrid_control(
            BLOCK, hold_pose(np.eye(4)), [[0.0, 0.0, -1.0]], [0.0, 0.0, -30.0], coordinates=task, force_kp=0.5,
            force_ki=ki, sensor=TipForceSensor(plant.robot, None, task),
        )  # fmt: skip

    law = law_of(100.0)
    scenario = mf.Scenario(
        robot=BLOCK, trajectory=rest(np.zeros(3), 0.024), law=law, plant=plant, step=2e-3, saturate=False
    )
    run = simulate(scenario)
    found = hybrid_certificate(law, run.t, run.q, run.qd, run.contact_wrench)
    np.testing.assert_allclose(found.force, np.tile([0.0, 0.0, 0.25 * MASS * G], (12, 1)), atol=1e-9)
    assert found.status is HybridStatus.DEPARTED
    assert found.motion_share == 0.0
    wild = hybrid_certificate(law_of(600.0), run.t, run.q, run.qd)
    assert wild.status is HybridStatus.UNSTABLE
    assert wild.force_radius == pytest.approx(float(sampled_force_radius(0.5, 1.2)))
    with pytest.raises(InputError, match="evenly"):
        hybrid_certificate(law, run.t**2, run.q, run.qd)
    with pytest.raises(InputError, match="HybridControl"):
        hybrid_certificate(hold_pose(np.eye(4)), run.t, run.q, run.qd)
