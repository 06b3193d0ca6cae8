"""Rigid surfaces with friction: sticking, sliding and impacts against closed forms, walls that give way, and laws."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mafsil as mf
from mafsil.control import Wall
from mafsil.errors import InputError
from mafsil.simulation import Plant, RigidPlant, RigidSurface
from mafsil.simulation.frictional_impact import after_impact
from mafsil.simulation.point_contact import PointContact, cone_margin
from mafsil.simulation.recording import SimulationStatus
from mafsil.trajectory.profiles import rest
from tests.simulation.rigid_scenes import ARM, BLOCK, MASS, Force, G, moved

FLOOR = np.zeros(3), np.array([0.0, 0.0, 1.0])


def events(run, *kinds):
    return [event for event in run.metadata["rigid_contact"]["events"] if event["kind"] in kinds]


def slope(angle, friction):
    """A plane that rises along x, and the direction up it."""
    up = np.array([np.cos(angle), 0.0, np.sin(angle)])
    return RigidSurface.plane(np.zeros(3), [-np.sin(angle), 0.0, np.cos(angle)], friction=friction), up


@pytest.mark.capability("10-16", "10-94")
@pytest.mark.parametrize("step", [1e-3, 7e-3])
def test_a_block_slides_to_rest_after_its_speed_squared_over_twice_mu_g_and_lies_still(step):
    mu, v = 0.3, np.array([0.6, 0.8, 0.0])
    run = moved(BLOCK, RigidSurface.plane(*FLOOR, friction=mu), np.zeros(3), v, 0.42, step=step)
    (stop,) = events(run, "stick")
    assert stop["time"] == pytest.approx(1.0 / (mu * G), abs=1e-8)
    np.testing.assert_allclose(run.q[-1], v / (2.0 * mu * G), rtol=0, atol=1e-8)
    sliding = run.t < stop["time"]
    weight, rub = MASS * G * FLOOR[1], -mu * MASS * G * v
    world = run.contact_wrench[:, 3:]
    assert np.abs(world[sliding] - weight - rub).max() < 1e-6
    assert np.abs(world[~sliding] - weight).max() < 1e-9
    assert np.abs(run.qd[~sliding]).max() < 1e-15


@pytest.mark.capability("10-17", "10-94")
@pytest.mark.parametrize(("friction", "stays"), [(0.2, False), (0.4, True), (np.tan(0.3), True)])
def test_a_block_pushed_up_a_slope_stops_and_stays_or_slides_back(friction, stays):
    surface, up = slope(0.3, friction)
    run = moved(BLOCK, surface, np.zeros(3), 1.2 * up, 0.6)
    there = 1.2 / (G * (np.sin(0.3) + friction * np.cos(0.3)))
    back = 0.0 if stays else G * (np.sin(0.3) - friction * np.cos(0.3))
    assert run.q[-1] @ up == pytest.approx(0.6 * there - back * (0.6 - there) ** 2 / 2.0, abs=1e-8)
    assert np.abs(surface.distance(run.q)).max() < 1e-14
    stops = events(run, "stick")
    assert len(stops) == stays
    if stays:
        assert stops[0]["time"] == pytest.approx(there, abs=1e-8)
        # What holds it is its weight, inside the cone.
        np.testing.assert_allclose(run.contact_wrench[-1, 3:], [0.0, 0.0, MASS * G], atol=1e-9)


def test_a_block_that_slides_across_a_slope_turns_and_stops_where_and_when_it_should():
    angle, mu, v = 0.2, 0.5, 0.8
    surface, up = slope(angle, mu)
    run = moved(BLOCK, surface, np.zeros(3), [0.0, v, 0.0], 0.25)
    down, friction = G * np.sin(angle), mu * G * np.cos(angle)
    (stop,) = events(run, "stick")
    assert stop["time"] == pytest.approx(v * friction / (friction**2 - down**2), abs=1e-7)

    def fall(t, y):
        speed = np.hypot(y[2], y[3])
        return [y[2], y[3], -down - friction * y[2] / speed, -friction * y[3] / speed]

    def slow(t, y):
        return np.hypot(y[2], y[3]) - 1e-7

    slow.terminal = True
    known = solve_ivp(fall, (0.0, 1.0), [0.0, 0.0, 0.0, v], rtol=1e-11, atol=1e-12, method="DOP853", events=slow)
    np.testing.assert_allclose([run.q[-1] @ up, run.q[-1, 1]], known.y[:2, -1], rtol=0, atol=2e-9)


@pytest.mark.capability("10-94")
def test_a_force_that_comes_and_goes_breaks_the_block_loose_when_it_leaves_the_cone():
    mu, w, F = 0.4, 8.0, 12.0
    surface = RigidSurface.plane(*FLOOR, friction=mu)
    run = moved(BLOCK, surface, np.zeros(3), np.zeros(3), 1.0, lambda t: np.array([F * np.sin(w * t), 0.0, 0.0]))
    loose = events(run, "slip")
    assert [event["kind"] for event in events(run, "stick", "slip")] == ["stick", "slip"] * 3
    # Efforts change at ticks: it slips at the first at which the force is too large.
    first = np.ceil(1e3 * np.arcsin(mu * MASS * G / F) / w) / 1e3
    assert loose[0]["time"] == pytest.approx(first, abs=1e-12)
    assert loose[1]["time"] - loose[0]["time"] == pytest.approx(np.pi / w, abs=1e-3)
    across, normal = np.abs(run.contact_wrench[:, 3]), run.contact_wrench[:, 5]
    assert (across <= mu * normal * (1.0 + 2e-9)).all()
    slides = np.abs(run.qd[:, 0]) > 1e-6
    np.testing.assert_allclose(run.contact_wrench[slides, 3], -mu * MASS * G * np.sign(run.qd[slides, 0]), rtol=1e-9)


def test_a_mass_slides_down_a_rough_ball_and_leaves_it_where_the_equation_says():
    R, mu, first = 0.5, 0.3, np.arcsin(0.4)
    start = R * np.array([np.sin(first), 0.0, np.cos(first)])
    run = moved(BLOCK, RigidSurface.sphere(np.zeros(3), R, friction=mu), start, np.zeros(3), 0.6, step=2e-3)

    def pressed(t, y):
        return G * np.cos(y[0]) - R * y[1] ** 2

    pressed.terminal = True
    known = solve_ivp(
        lambda t, y: [y[1], (G * np.sin(y[0]) - mu * pressed(t, y)) / R], (0.0, 2.0), [first, 0.0], rtol=1e-11,
        atol=1e-12, events=pressed,
    )  # fmt: skip
    (end,) = events(run, "release")
    assert end["time"] == pytest.approx(known.t[-1], abs=1e-7)


def wall_task(force):
    """A planar arm at a wall whose normal is y, pressed onto it with a force (2,)."""
    q = np.array([0.4, 0.9])
    T = ARM.forward_kinematics(q)
    J = (T[:3, :3] @ ARM.jacobian_body(q)[3:])[:2]
    return q, T[:3, 3], J, ARM.gravity_torque(q) + J.T @ np.array(force)


def world_force(run):
    return np.einsum("kij,kj->ki", ARM.forward_kinematics(run.q)[:, :3, :3], run.contact_wrench[:, 3:])


@pytest.mark.capability("10-68", "10-94")
def test_an_arm_that_presses_inside_the_cone_is_held_by_friction_and_outside_it_slides():
    q, p, J, efforts = wall_task((11.9, -30.0))
    surface = RigidSurface.plane(p, [0.0, 1.0, 0.0], friction=0.4)
    held = moved(ARM, surface, q, np.zeros(2), 0.3, lambda t: efforts)
    assert np.abs(held.q - q).max() < 1e-15
    assert np.abs(world_force(held)[:, :2] - [-11.9, 30.0]).max() < 1e-10
    q, p, J, efforts = wall_task((12.1, -30.0))
    slid = moved(ARM, surface, q, np.zeros(2), 0.01, lambda t: efforts)
    # One equation for the normal force, one for the acceleration: n . a = 0, friction against the motion.
    W = J @ np.linalg.solve(ARM.mass_matrix(q), J.T)
    drift, push = W @ [12.1, -30.0], np.array([-0.4, 1.0])
    normal = -drift[1] / (W @ push)[1]
    np.testing.assert_allclose(world_force(slid)[0, :2], normal * push, rtol=1e-9)
    np.testing.assert_allclose(J @ slid.qdd[0], drift + normal * (W @ push), atol=1e-8)


def test_walls_with_friction_become_the_rigid_one_as_they_get_stiffer():
    q, p, J, efforts = wall_task((0.0, -30.0))
    start = np.linalg.solve(J, [0.5, 0.0])
    rigid = moved(ARM, RigidSurface.plane(p, [0.0, 1.0, 0.0], friction=0.3), q, start, 0.1, lambda t: efforts)
    apart = []
    for stiffness, step in ((1e4, 1e-4), (1e5, 5e-5)):
        wall = Wall(p, [0.0, 1.0, 0.0], stiffness, 2.0 * np.sqrt(stiffness), 0.3, slow=10.0 / stiffness)
        soft = mf.simulate(
            mf.Scenario(
                robot=ARM, trajectory=rest(q, 0.1), q=q, qd=start, law=Force(lambda t: efforts), saturate=False,
                plant=Plant(ARM, friction=False, environment=wall), step=step, period=1e-3, integrator="rk4",
            )
        )  # fmt: skip
        apart.append(np.abs(soft.q - rigid.q).max())
    assert apart[0] > 5.0 * apart[1]
    assert apart[1] < 1e-3


@pytest.mark.parametrize(("mu", "e"), [(0.1, 0.5), (2.0, 0.5), (0.3, 0.0), (0.2, 1.0)])
def test_a_ball_thrown_at_the_floor_loses_what_friction_can_take(mu, e):
    start = np.array([0.0, 0.0, 0.1])
    run = moved(BLOCK, RigidSurface.plane(*FLOOR, friction=mu, restitution=e), start, [0.6, 0.8, -1.0], 0.1)
    hit = events(run, "impact")[0]
    assert hit["impulse"] == pytest.approx((1.0 + e) * MASS * hit["speed"], rel=1e-9)
    taken = min(mu * hit["impulse"], MASS)
    assert hit["across"] == pytest.approx(taken, rel=1e-8)
    left = 1.0 - taken / MASS
    lost = MASS / 2.0 * (1.0 - left**2 + (1.0 - e**2) * hit["speed"] ** 2)
    assert hit["lost"] == pytest.approx(lost, rel=1e-8)


@pytest.mark.parametrize("seed", range(25))
def test_impacts_take_energy_stay_in_the_cone_and_give_back_their_share(seed):
    rng = np.random.default_rng(seed)
    for r in (2, 3):
        A, n, v = rng.normal(size=(r, r)), rng.normal(size=r), rng.normal(size=r)
        W, n = A @ A.T + 0.05 * np.eye(r), n / np.linalg.norm(n)
        v = v - 2.0 * max(n @ v, 0.0) * n
        mu, e = rng.choice([0.1, 0.4, 1.0, 3.0]), rng.choice([0.0, 0.5, 1.0])
        after = after_impact(W, n, mu, v, e)
        P = np.linalg.solve(W, after - v)
        gained = (after @ np.linalg.solve(W, after) - v @ np.linalg.solve(W, v)) / 2.0
        assert gained < 1e-9
        assert n @ after > -1e-12
        assert np.linalg.norm(P - (n @ P) * n) <= mu * (n @ P) * (1.0 + 1e-9)
        # Where friction is too little to matter, Newton's law.
        smooth = after_impact(W, n, 0.0, v, e)
        np.testing.assert_allclose(smooth, v - (1.0 + e) * (n @ v) / (n @ W @ n) * (W @ n), atol=1e-12)


def test_an_impact_whose_sliding_turns_is_that_of_its_equation():
    # Little friction and no end of sliding: dv/dp = G (n - mu v_t / |v_t|), integrated by itself.
    W = np.array([[1.0, 0.3, 0.1], [0.3, 0.6, -0.2], [0.1, -0.2, 0.8]])
    n, mu, e, v = np.array([0.0, 0.0, 1.0]), 0.25, 0.6, np.array([1.0, -0.7, -0.9])

    def rate(p, y):
        d = np.append(y[:2], 0.0) / np.hypot(y[0], y[1])
        return np.append(W @ (n - mu * d), y[2])

    def compressed(p, y):
        return y[2]

    compressed.terminal = True
    first = solve_ivp(rate, (0.0, 10.0), np.append(v, 0.0), rtol=1e-11, atol=1e-12, events=compressed)

    def restored(p, y):
        return y[3] - (1.0 - e**2) * first.y[3, -1]

    restored.terminal, restored.direction = True, 1.0
    second = solve_ivp(rate, (0.0, 10.0), first.y[:, -1], rtol=1e-11, atol=1e-12, events=restored)
    np.testing.assert_allclose(after_impact(W, n, mu, v, e), second.y[:3, -1], atol=1e-8)


@pytest.mark.capability("10-94")
@pytest.mark.parametrize("seed", range(6))
def test_with_friction_energy_is_accounted_for_and_the_force_stays_in_the_cone(seed):
    rng = np.random.default_rng(seed)
    q, qd, n = rng.uniform(-2, 2, 2), rng.uniform(-2, 2, 2), np.append(rng.normal(size=2), 0.0)
    n, e, mu = n / np.linalg.norm(n), rng.choice([0.0, 0.5]), rng.choice([0.2, 0.6])
    p = ARM.forward_kinematics(q)[:3, 3]
    surface = RigidSurface.plane(p - 0.02 * n, n, restitution=e, friction=mu)
    push = -ARM.jacobian_body(q)[3:].T @ ARM.forward_kinematics(q)[:3, :3].T @ (25.0 * n)
    w = rng.uniform(5, 20)
    run = moved(ARM, surface, q, qd, 0.25, lambda t: push * (0.6 + np.sin(w * t)), step=5e-4)
    assert run
    force = world_force(run)
    normal, across = force @ n, force - np.outer(force @ n, n)
    assert (normal >= 0.0).all()
    assert (np.linalg.norm(across, axis=1) <= mu * normal * (1.0 + 2e-9) + 1e-12).all()
    assert surface.distance(ARM.forward_kinematics(run.q)[:, :3, 3]).min() > -1e-11
    total = ARM.kinetic_energy(run.q, run.qd) + ARM.potential_energy(run.q)
    work = np.append(0.0, np.cumsum((run.tau[:-1] * np.diff(run.q, axis=0)).sum(axis=1)))
    left = total - total[0] - work
    # Neither sliding nor impacts give energy, at any tick.
    assert np.diff(left).max() < 1e-7
    power = np.linalg.norm(across, axis=1) * np.linalg.norm(run.qd, axis=1)
    slid = np.diff(ARM.forward_kinematics(run.q)[:, :3, 3], axis=0)
    rubbed = ((across[:-1] + across[1:]) / 2.0 * slid).sum()
    # Where something happens within a tick, the sum takes it as a straight line.
    changes = len(run.metadata["rigid_contact"]["events"])
    assert left[-1] == pytest.approx(
        rubbed - run.metadata["rigid_contact"]["lost"], abs=1e-5 + changes * 5e-4 * power.max()
    )


@pytest.mark.parametrize("language", ["en", "ar"])
def test_rigid_bodies_without_a_force_of_contact_are_named(language):
    # Dragged against the elbow with friction beyond n G n / n G d the normal force would have to be negative.
    q, p, J, efforts = wall_task((0.0, -30.0))
    W = J @ np.linalg.solve(ARM.mass_matrix(q), J.T)
    least = W[1, 1] / abs(W[0, 1])
    start = np.linalg.solve(J, [0.5 * np.sign(W[0, 1]), 0.0])
    for mu, status in ((0.9 * least, SimulationStatus.COMPLETED), (1.1 * least, SimulationStatus.NO_CONTACT_FORCE)):
        surface = RigidSurface.plane(p, [0.0, 1.0, 0.0], friction=mu)
        run = moved(ARM, surface, q, start, 2e-3, lambda t: efforts)
        assert run.status is status
    assert not run
    assert ("Painleve" if language == "en" else "بانلوفيه") in run.explain(language)


def test_an_arm_with_more_joints_moves_on_while_its_tip_sticks():
    panda = mf.load("panda")
    q = np.array([0.1, 0.2, 0.3, -1.8, 0.2, 1.9, 0.4])
    T = panda.forward_kinematics(q)
    J = T[:3, :3] @ panda.jacobian_body(q)[3:]
    still = np.linalg.svd(J)[2][3:].sum(axis=0)
    down = panda.gravity_torque(q) - J.T @ np.array([3.0, 2.0, 40.0])
    run = moved(panda, RigidSurface.plane(T[:3, 3], [0, 0, 1], friction=0.5), q, 0.5 * still, 0.05, lambda t: down)
    places = panda.forward_kinematics(run.q)[:, :3, 3]
    assert np.abs(places - T[:3, 3]).max() < 1e-13
    assert np.abs(run.q[-1] - q).max() > 1e-3
    assert len(events(run, "stick")) == 1


@pytest.mark.parametrize("seed", range(3))
def test_the_margin_of_cones_says_what_a_dense_choice_of_forces_says(seed):
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(2, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    mu = np.array([0.3, 0.7])
    angles = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    rays = []
    for n, m in zip(normals, mu, strict=True):
        a, b = np.linalg.svd(n[None])[2][1:]
        rays.append(n + m * (np.cos(angles)[:, None] * a + np.sin(angles)[:, None] * b))
    for _ in range(20):
        weights = rng.uniform(0.1, 2, 2)
        chosen = [each[rng.integers(400)] for each in rays]
        inside = weights[0] * (0.99 * chosen[0] + 0.01 * normals[0]) + weights[1] * chosen[1]
        assert cone_margin(inside, normals, mu) > -1e-12
        # A direction that no ray is against separates what is outside.
        w = rng.normal(size=3)
        if min((each @ w).min() for each in rays) > 0.0:
            assert cone_margin(-w, normals, mu) < 0.0
    assert PointContact.of(np.eye(3), normals, mu).sticking((0, 1), -inside).slack >= 0.0


def test_what_makes_no_sense_is_refused_by_name():
    with pytest.raises(InputError, match="friction"):
        RigidSurface.plane(*FLOOR, friction=-0.1)
    with pytest.raises(InputError, match="friction"):
        RigidSurface.sphere([0, 0, 0], 1.0, friction=np.nan)
    with pytest.raises(InputError, match="surface"):
        RigidPlant(BLOCK, surface=())
    with pytest.raises(InputError, match="surface"):
        RigidPlant(BLOCK, surface=(0.3,))
