"""A rigid surface: impacts to rounding, bounces and their end, force of a held tip, energy, and where contact ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import Wall
from mafsil.control.contact import constrained_dynamics
from mafsil.errors import InputError
from mafsil.model import Inertial, Joint, JointKind, Link, Mechanism
from mafsil.simulation import Plant, Recording, RigidPlant, RigidSurface
from mafsil.simulation.recording import join_recordings
from mafsil.trajectory.profiles import rest
from tests.simulation.rigid_scenes import Force, G


def slider(mass=2.0, axis=(0.0, 0.0, 1.0)):
    """One mass on a rail."""
    links = (Link("base"), Link("mass", Inertial(mass, np.zeros(3), 0.01 * np.eye(3))))
    joint = Joint("rail", JointKind.PRISMATIC, "base", "mass", axis=axis)
    return mf.Robot(Mechanism.assemble("slider", links, [joint]))


BALL = slider()
FLOOR = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def dropped(height, restitution, duration, *, law=None, surface=None, **changes):
    plant = RigidPlant(BALL, surface=surface or RigidSurface.plane(*FLOOR, restitution=restitution))
    law = law or Force(lambda t: 0.0)
    return mf.simulate(
        mf.Scenario(robot=BALL, trajectory=rest([height], duration), law=law, plant=plant, saturate=False, **changes)
    )


def events(run, kind):
    return [event for event in run.metadata["rigid_contact"]["events"] if event["kind"] == kind]


def energy(robot, run):
    return robot.kinetic_energy(run.q, run.qd) + robot.potential_energy(run.q)


@pytest.mark.parametrize(("restitution", "step"), [(0.5, 1e-3), (0.5, 0.05), (0.7, 3e-3), (0.2, 1e-2)])
def test_the_times_of_all_bounces_and_their_sum_are_those_of_the_geometric_series(restitution, step):
    h = 0.3
    run = dropped(h, restitution, 1.6, step=step)
    assert run
    first = np.sqrt(2 * h / G)
    found = np.array([event["time"] for event in events(run, "impact")])
    flights = 2 * first * restitution ** np.arange(1.0, len(found))
    np.testing.assert_allclose(found, first + np.append(0.0, np.cumsum(flights)), rtol=0, atol=1e-10)
    (end,) = events(run, "closure")
    whole = first * (1 + restitution) / (1 - restitution)
    assert end["over"] == pytest.approx(whole, abs=1e-10)
    assert end["bounces"] == len(found)
    assert end["time"] == found[-1]
    speeds = [event["speed"] for event in events(run, "impact")]
    np.testing.assert_allclose(speeds, np.sqrt(2 * G * h) * restitution ** np.arange(len(found)), rtol=1e-8)
    # Afterwards it lies still, and the floor carries it.
    late = run.t > whole
    assert np.abs(run.q[late]).max() < 1e-12
    assert np.abs(run.qd[late]).max() < 1e-12
    np.testing.assert_allclose(run.contact_wrench[late, 5], 2.0 * G, rtol=1e-12)
    assert run.metadata["rigid_contact"]["lost"] == pytest.approx(2.0 * G * h, rel=1e-9)


def test_restitution_one_keeps_the_energy_and_zero_loses_what_moves_along_the_normal():
    run = dropped(0.3, 1.0, 2.0)
    assert np.abs(energy(BALL, run) - 2.0 * G * 0.3).max() < 1e-11
    assert run.metadata["rigid_contact"]["lost"] == pytest.approx(0.0, abs=1e-11)
    arm, start, rate = mf.load("planar2r_point_masses"), np.array([0.4, 0.9]), np.array([-1.2, -0.4])
    p = arm.forward_kinematics(start)[:3, 3]
    J = arm.jacobian_body(start)[3:]
    R = arm.forward_kinematics(start)[:3, :3]
    A = (R @ J)[1]
    surface = RigidSurface.plane(p - [0, 1e-9, 0], [0, 1, 0])
    scenario = mf.Scenario(
        robot=arm, trajectory=rest(start, 2e-4), law=Force(lambda t: 0.0), q=start, qd=rate, step=1e-4, saturate=False,
        plant=RigidPlant(arm, friction=False, surface=surface),
    )  # fmt: skip
    run = mf.simulate(scenario)
    (hit,) = events(run, "impact")
    mass = 1.0 / (A @ np.linalg.solve(arm.mass_matrix(start), A))
    assert hit["lost"] == pytest.approx(0.5 * mass * (A @ rate) ** 2, rel=1e-6)
    assert hit["impulse"] == pytest.approx(-mass * (A @ rate), rel=1e-6)


def pressed(surface, *, q=(0.4, 0.9), qd=(0.3, 0.0), duration=0.5, wall=None, **changes):
    """A planar arm in the plane of x and y, pushed against a surface with constant efforts, 30 N where it starts."""
    arm, at = mf.load("planar2r_point_masses"), np.array(q)
    T = arm.forward_kinematics(at)
    n = surface.outward(T[:3, 3])
    efforts = arm.gravity_torque(at) - (T[:3, :3] @ arm.jacobian_body(at)[3:]).T @ (30.0 * n)
    plant = RigidPlant(arm, friction=False, surface=surface) if wall is None else Plant(arm, environment=wall)
    law = Force(lambda t: efforts)
    scenario = mf.Scenario(
        robot=arm, trajectory=rest(q, duration), q=q, qd=qd, law=law, plant=plant, saturate=False, **changes
    )
    return arm, mf.simulate(scenario)


def tip(arm, q):
    return arm.forward_kinematics(q)[..., :3, 3]


def along(surface, arm, q):
    """(n,) gradient of the distance of the tip."""
    return surface.outward(tip(arm, q)) @ (arm.forward_kinematics(q)[:3, :3] @ arm.jacobian_body(q)[3:])


def surfaces():
    p = tip(mf.load("planar2r_point_masses"), np.array([0.4, 0.9]))
    n = np.array([0.6, -0.8, 0.0])
    return {
        "plane": RigidSurface.plane(p - 0.02 * n, n),
        "sphere": RigidSurface.sphere(p - 0.52 * n, 0.5),
        "cylinder": RigidSurface.cylinder(p + 0.48 * n, [0, 0, 1], 0.5, hollow=True),
    }


@pytest.mark.capability("10-68", "10-69", "10-72")
@pytest.mark.parametrize("kind", surfaces())
def test_the_force_of_a_held_tip_is_the_multiplier_of_the_constrained_equations(kind):
    surface = surfaces()[kind]
    arm, run = pressed(surface, duration=0.3)
    assert run
    force = np.linalg.norm(run.contact_wrench[:, 3:], axis=-1)
    held = np.flatnonzero(force)
    assert len(held) > 20
    assert np.abs(surface.distance(tip(arm, run.q[held[1:]]))).max() < 1e-12
    for k in held[::20]:
        q, qd = run.q[k], run.qd[k]
        A = along(surface, arm, q)
        rate = (along(surface, arm, q + 1e-6 * qd) - along(surface, arm, q - 1e-6 * qd)) / 2e-6
        still = arm.inverse_dynamics(q, qd, np.zeros(2))
        # There the multiplier is what the arm exerts, and A qd = 0.
        known = constrained_dynamics(arm.mass_matrix(q), still, A, run.tau[k], A_rate=rate, V=qd)
        assert force[k] == pytest.approx(-known.multipliers[0], rel=1e-6)
        np.testing.assert_allclose(run.qdd[k], known.acceleration, rtol=1e-6, atol=1e-6)


def test_a_surface_that_gives_way_becomes_the_rigid_one_as_it_gets_stiffer():
    rigid = surfaces()["plane"]
    _, hard = pressed(rigid, duration=0.3)
    apart = []
    for stiffness in (1e4, 1e5, 1e6):
        wall = Wall(rigid.point, rigid.normal, stiffness, damping=2.0 * np.sqrt(stiffness))
        _, soft = pressed(rigid, duration=0.3, wall=wall, step=1e-4, period=1e-3, integrator="rk4")
        apart.append(np.abs(soft.q - hard.q).max())
    assert apart[0] > 2.0 * apart[1] > 4.0 * apart[2]
    assert apart[2] < 2e-3


def test_contact_ends_where_the_surface_would_have_to_pull():
    run = dropped(0.0, 0.0, 0.2)
    assert not events(run, "release")
    np.testing.assert_allclose(run.contact_wrench[:, 5], 2.0 * G)
    # A mass slides over the top of a ball and leaves it where its weight no longer bends its path so far.
    cart = sliding()
    R, v = 0.5, 0.6
    surface = RigidSurface.sphere([0, 0, 0], R)
    scenario = mf.Scenario(
        robot=cart, trajectory=rest([0.0, R], 0.6), q=[0.0, R], qd=[v, 0.0], law=Force(lambda t: 0.0), saturate=False,
        plant=RigidPlant(cart, surface=surface),
    )  # fmt: skip
    run = mf.simulate(scenario)
    (end,) = events(run, "release")
    k = int(np.searchsorted(run.t, end["time"])) - 1
    T = end["time"] - run.t[k]
    q, qd = run.q[k], run.qd[k]
    # cos(angle) = 2/3 + v^2 / (3 g R): the classical place, reached within the step.
    angle = np.arctan2(q[0], q[1])
    speed = np.hypot(*qd)
    last = angle + T * speed / R + 0.5 * T**2 * G * np.sin(angle) / R
    assert np.cos(last) == pytest.approx(2 / 3 + v**2 / (3 * G * R), abs=1e-7)
    free = run.t > end["time"]
    assert not run.contact_wrench[free].any()
    assert np.abs(energy(cart, run) - energy(cart, run)[0]).max() < 1e-9


def sliding():
    """A mass on two rails, along x and z."""
    links = (
        Link("base"), Link("rail", Inertial(1e-9, np.zeros(3), 1e-12 * np.eye(3))),
        Link("mass", Inertial(1.0, np.zeros(3), 0.01 * np.eye(3))),
    )  # fmt: skip
    joints = (
        Joint("x", JointKind.PRISMATIC, "base", "rail", axis=(1.0, 0.0, 0.0)),
        Joint("z", JointKind.PRISMATIC, "rail", "mass", axis=(0.0, 0.0, 1.0)),
    )
    return mf.Robot(Mechanism.assemble("cart", links, joints))


def test_a_tip_that_dips_in_between_two_ticks_is_caught():
    # Thrown so that within one step of 0.1 s it would go 1 mm in and come out again: pushed up by 40 times its weight.
    run = dropped(0.01, 1.0, 0.1, law=Force(lambda t: 2.0 * 41 * G), step=0.1, qd=[-np.sqrt(2 * 40 * G * 0.011)])
    (hit,) = events(run, "impact")
    assert hit["speed"] == pytest.approx(np.sqrt(2 * 40 * G * 0.001), rel=1e-9)


def test_friction_too_stiff_for_the_step_bounces_and_rests_too():
    run = dropped(0.3, 0.5, 1.0, integrator="implicit_friction", step=1e-3)
    first = np.sqrt(2 * 0.3 / G)
    (end,) = events(run, "closure")
    assert end["over"] == pytest.approx(3 * first, abs=1e-9)
    puma = mf.load("puma560")
    q = np.array([0.2, 0.6, -0.9, 0.1, 0.7, 0.3])
    T = puma.forward_kinematics(q)
    down = np.concatenate([np.zeros(3), T[:3, :3].T @ [0.0, 0.0, -60.0]])
    efforts = puma.gravity_torque(q) + puma.jacobian_body(q).T @ down
    scenario = mf.Scenario(
        robot=puma, trajectory=rest(q, 0.2), law=Force(lambda t: efforts), saturate=False, step=2e-3,
        plant=RigidPlant(puma, surface=RigidSurface.plane(T[:3, 3] - [0, 0, 1e-3], [0, 0, 1], restitution=0.3)),
    )  # fmt: skip
    run = mf.simulate(scenario)
    assert run
    assert run.metadata["integrator"] == "implicit_friction"
    (end,) = events(run, "closure")
    held = run.t > end["over"]
    assert held.sum() > 20
    assert np.abs(puma.forward_kinematics(run.q[held])[:, 2, 3] - T[2, 3] + 1e-3).max() < 1e-12
    q, qd, qdd = run.q[held], run.qd[held], run.qdd[held]
    lost = puma.friction_torque(qd + 2e-3 * qdd)
    left = run.tau[held] - lost - puma.inverse_dynamics(q, qd, qdd, -run.contact_wrench[held])
    assert np.abs(left).max() < 1e-5 * np.abs(efforts).max()
    assert (run.contact_wrench[held, 3:] @ down[3:] < 0.0).all()


@pytest.mark.parametrize("language", ["en", "ar"])
def test_sentences_say_the_numbers_of_the_run(language):
    run = dropped(0.3, 0.5, 1.0)
    said = run.explain(language)
    found = run.metadata["rigid_contact"]
    (end,) = events(run, "closure")
    for word in (str(found["impacts"]), str(end["bounces"]), "742 ms", "5.89 J"):
        assert word in said, said
    assert "Zeno" in said or "زينون" in said
    quiet = dropped(0.3, 0.5, 0.1)
    assert "Zeno" not in quiet.explain("en")
    assert "Impacts" not in quiet.explain("en")


def test_events_stay_with_the_recording_and_follow_each_other(tmp_path):
    run = dropped(0.3, 0.5, 1.0)
    run.save(tmp_path / "run")
    assert Recording.load(tmp_path / "run").metadata["rigid_contact"] == run.metadata["rigid_contact"]


def test_what_does_not_go_is_refused_by_name():
    plane = RigidSurface.plane(*FLOOR)
    with pytest.raises(InputError, match=r"0\.2 m inside"):
        dropped(-0.2, 0.0, 0.1)
    with pytest.raises(InputError, match="restitution"):
        RigidSurface.plane(*FLOOR, restitution=1.5)
    with pytest.raises(InputError, match="exactly one"):
        RigidSurface(np.zeros(3))
    with pytest.raises(InputError, match="integrator"):
        dropped(0.1, 0.0, 0.1, integrator="semi_implicit_euler")
    with pytest.raises(InputError, match="batch"):
        dropped(0.1, 0.0, 0.1, q=np.ones((3, 1)))
    scenario = mf.Scenario(
        robot=BALL, trajectory=rest([0.1], 0.1), law=Force(lambda t: 0.0),
        plant=RigidPlant(BALL, surface=plane),
    )  # fmt: skip
    with pytest.raises(InputError, match="one by one"):
        mf.simulation.monte_carlo(scenario, mf.simulation.Variation(payload=(0.0, 0.1)), 3)
    with pytest.raises(InputError, match="fused"):
        mf.simulate(replace(scenario), fused=True)


@pytest.mark.parametrize("seed", range(12))
def test_energy_is_accounted_for_and_no_tip_enters_the_surface(seed):
    rng, arm = np.random.default_rng(seed), mf.load("planar2r_point_masses")
    q, qd, n = rng.uniform(-2, 2, 2), rng.uniform(-2, 2, 2), np.append(rng.normal(size=2), 0.0)
    n, gap, e = n / np.linalg.norm(n), rng.choice([0.0, 1e-9, 0.02, 0.2]), rng.choice([0.0, 0.3, 0.7, 0.95, 1.0])
    p = arm.forward_kinematics(q)[:3, 3]
    surface = (
        RigidSurface.plane(p - gap * n, n, restitution=e),
        RigidSurface.sphere(p - (gap + 0.5) * n, 0.5, restitution=e),
        RigidSurface.cylinder(p + (0.6 - gap) * n, [0, 0, 1], 0.6, hollow=True, restitution=e),
    )[seed % 3]
    w, size = rng.uniform(1, 30), rng.uniform(0, 20, 2)
    scenario = mf.Scenario(
        robot=arm, trajectory=rest(q, 0.6), q=q, qd=qd, saturate=False,
        law=Force(lambda t: size * np.sin(w * t + np.array([0.0, 1.0]))),
        step=2e-3, plant=RigidPlant(arm, friction=False, surface=surface),
    )  # fmt: skip
    run = mf.simulate(scenario)
    assert run
    assert surface.distance(tip(arm, run.q)).min() > -1e-11
    force = arm.forward_kinematics(run.q)[:, :3, :3] @ run.contact_wrench[:, 3:, None]
    push = np.einsum("ki,ki->k", surface.outward(tip(arm, run.q)), force[..., 0])
    assert (push >= 0.0).all()
    # Efforts are constant within a tick: their work is known exactly.
    total = energy(arm, run)
    work = (run.tau[:-1] * np.diff(run.q, axis=0)).sum()
    assert total[-1] - total[0] == pytest.approx(work - run.metadata["rigid_contact"]["lost"], abs=2e-5)


def test_many_bounces_are_counted_listed_up_to_a_thousand_and_their_end_is_named():
    run = dropped(2e-5, 0.995, 1.0, step=2e-3)
    found = run.metadata["rigid_contact"]
    assert found["impacts"] > 1000
    (end,) = events(run, "closure")
    assert end["bounces"] == found["impacts"]
    assert end["over"] == pytest.approx(np.sqrt(2 * 2e-5 / G) * 1.995 / 0.005, rel=1e-6)
    assert len(events(run, "impact")) == 1000
    assert str(found["impacts"]) in run.explain("en")
    assert "Zeno" in run.explain("en")


def test_runs_that_follow_each_other_keep_their_events_in_one_time():
    first = dropped(0.3, 0.5, 0.3)
    plant = RigidPlant(BALL, surface=RigidSurface.plane(*FLOOR, restitution=0.5))
    scenario = mf.Scenario(
        robot=BALL, trajectory=rest([0.0], 0.7), law=Force(lambda t: 0.0), plant=plant, saturate=False,
        q=first.q[-1], qd=first.qd[-1],
    )  # fmt: skip
    both, whole = join_recordings([first, mf.simulate(scenario)]), dropped(0.3, 0.5, 1.0)
    one, two = ([event["time"] for event in events(run, "impact")] for run in (both, whole))
    np.testing.assert_allclose(one, two, rtol=0, atol=1e-9)
    assert both.metadata["rigid_contact"]["impacts"] == whole.metadata["rigid_contact"]["impacts"]
    assert both.metadata["rigid_contact"]["lost"] == pytest.approx(whole.metadata["rigid_contact"]["lost"], rel=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_the_normal_acceleration_of_a_spatial_arm_is_the_second_derivative_of_its_distance(seed):
    rng, arm = np.random.default_rng(seed), mf.load("panda")
    q, qd, qdd = (
        rng.uniform(-1, 1, 7) + np.array([0, 0, 0, -1.5, 0, 1.5, 0]),
        rng.uniform(-1, 1, 7),
        rng.uniform(-2, 2, 7),
    )
    p, n = arm.forward_kinematics(q)[:3, 3], rng.normal(size=3)
    surface = (
        RigidSurface.plane(p, n), RigidSurface.sphere(p - 0.3 * n, 0.2),
        RigidSurface.cylinder(p - 0.3 * n, rng.normal(size=3), 0.4, hollow=True),
    )[seed]  # fmt: skip
    tip_now = RigidPlant(arm, surface=surface).tip_state(q, qd)
    gap, A = tip_now.gaps[0], tip_now.normals[0] @ tip_now.J
    bend = tip_now.normals[0] @ tip_now.bend + tip_now.bends[0]
    h = 1e-3
    before, now, after = (surface.distance(tip(arm, q + s * qd + s * s / 2 * qdd)) for s in (-h, 0.0, h))
    assert gap == pytest.approx(now)
    assert A @ qd == pytest.approx((after - before) / (2 * h), rel=1e-5, abs=1e-6)
    assert A @ qdd + bend == pytest.approx((after - 2 * now + before) / h**2, rel=1e-4, abs=1e-4)
