"""Several rigid surfaces at once: corners, edges and grooves against closed forms, Gauss's principle and laws."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

import mafsil as mf
from mafsil.simulation import RigidPlant, RigidSurface, simulate
from mafsil.simulation.point_contact import PointContact
from mafsil.trajectory.profiles import rest
from tests.simulation.rigid_scenes import ARM, BLOCK, MASS, ORIGIN, Force, G, moved


def events(run, kind, surface):
    found = run.metadata["rigid_contact"]["events"]
    return [event for event in found if event["kind"] == kind and event["surface"] == surface]


def corner(**each):
    return RigidSurface.plane(ORIGIN, [0, 0, 1], **each), RigidSurface.plane(ORIGIN, [1, 0, 0], **each)


@pytest.mark.capability("10-68", "10-69")
def test_a_ball_in_a_corner_bounces_on_floor_and_wall_as_on_each_alone():
    surfaces = (
        RigidSurface.plane(ORIGIN, [0, 0, 1], restitution=0.5),
        RigidSurface.plane(ORIGIN, [1, 0, 0], restitution=0.4),
    )
    run = moved(BLOCK, surfaces, [0.1, 0, 0.2], np.zeros(3), 0.8, lambda t: np.array([-6.0, 0, 0]), step=2e-3)
    for surface, height, a, e in ((0, 0.2, G, 0.5), (1, 0.1, 3.0, 0.4)):
        first = np.sqrt(2 * height / a)
        times = np.array([event["time"] for event in events(run, "impact", surface)])
        known = first + np.append(0.0, np.cumsum(2 * first * e ** np.arange(1, 30)))
        np.testing.assert_allclose(times, known[: len(times)], rtol=0, atol=1e-8)
        assert len(times) > 2
        end = first * (1 + e) / (1 - e)
        if end < 0.8:
            (closed,) = events(run, "closure", surface)
            assert closed["over"] == pytest.approx(end, abs=1e-8)
            assert closed["bounces"] == len(times)
    assert min(run.q[:, 0].min(), run.q[:, 2].min()) > -1e-11


@pytest.mark.capability("10-94")
def test_a_block_slides_along_an_edge_against_the_friction_of_both_faces():
    surfaces = (
        RigidSurface.plane(ORIGIN, [0, 0, 1], friction=0.2),
        RigidSurface.plane(ORIGIN, [1, 0, 0], friction=0.3),
    )
    run = moved(BLOCK, surfaces, ORIGIN, [0, 1.0, 0], 0.32, lambda t: np.array([-10.0, 0, 0]), step=2e-3)
    slowing = 0.2 * G + 0.3 * 5.0
    assert events(run, "stick", 0)[0]["time"] == pytest.approx(1.0 / slowing, abs=1e-9)
    assert run.q[-1, 1] == pytest.approx(0.5 / slowing, abs=1e-9)
    np.testing.assert_allclose(run.contact_wrench[10, 3:], [10.0, -MASS * slowing, MASS * G], rtol=1e-9)
    np.testing.assert_allclose(run.contact_wrench[-1, 3:], [10.0, 0.0, MASS * G], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("friction", [0.2, 0.23])
def test_a_groove_holds_more_than_a_plane_by_the_square_root_of_two(friction):
    angle, c = 0.3, np.sqrt(0.5)
    R = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    faces = [RigidSurface.plane(ORIGIN, R @ [side * c, 0, c], friction=friction) for side in (1, -1)]
    run = moved(BLOCK, tuple(faces), ORIGIN, np.zeros(3), 0.2, step=2e-3)
    slides = G * (np.sin(angle) - np.sqrt(2) * friction * np.cos(angle))
    np.testing.assert_allclose(R.T @ run.q[-1], [0, -0.02 * max(slides, 0.0), 0], rtol=0, atol=1e-10)
    assert (slides > 0.0) == (friction == 0.2)


def test_a_tip_leaves_one_face_and_stays_on_the_other():
    run = moved(BLOCK, corner(), ORIGIN, np.zeros(3), 0.4, lambda t: np.array([-5.0 + 20 * t, 0, 0]), step=1e-3)
    (left,) = events(run, "release", 1)
    # Efforts change at ticks: at 0.25 s the force is zero, a tick later it pulls.
    assert left["time"] == pytest.approx(0.251, abs=1e-12)
    assert not events(run, "release", 0)
    np.testing.assert_allclose(run.contact_wrench[100, 3:], [3.0, 0, MASS * G], rtol=1e-9)
    np.testing.assert_allclose(run.contact_wrench[-1, 3:], [0.0, 0, MASS * G], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_an_arm_in_a_corner_has_the_acceleration_of_gauss_s_principle(seed):
    rng = np.random.default_rng(seed)
    panda = mf.load("panda")
    q = rng.uniform(-1, 1, 7) + np.array([0, 0, 0, -1.5, 0, 1.5, 0])
    T = panda.forward_kinematics(q)
    J = T[:3, :3] @ panda.jacobian_body(q)[3:]
    N = rng.normal(size=(3, 3))
    N /= np.linalg.norm(N, axis=1)[:, None]
    tau = panda.gravity_torque(q) + J.T @ rng.normal(size=3) * 30
    plant = RigidPlant(panda, friction=False, surface=tuple(RigidSurface.plane(T[:3, 3], n) for n in N))
    run = simulate(
        mf.Scenario(robot=panda, trajectory=rest(q, 1e-3), law=Force(lambda t: tau), plant=plant, saturate=False)
    )
    # Least (a - a0)' M (a - a0) with A a >= 0: its dual is a problem of non-negative least squares.
    M, A = panda.mass_matrix(q), N @ J
    free = np.linalg.solve(M, tau - panda.inverse_dynamics(q, np.zeros(7), np.zeros(7)))
    W = A @ np.linalg.solve(M, A.T)
    L = np.linalg.cholesky(W)
    f, _ = nnls(L.T, -np.linalg.solve(L, A @ free))
    np.testing.assert_allclose(run.qdd[0], free + np.linalg.solve(M, A.T @ f), atol=1e-8)
    np.testing.assert_allclose(T[:3, :3] @ run.contact_wrench[0, 3:], N.T @ f, atol=1e-8)


@pytest.mark.capability("10-94")
@pytest.mark.parametrize("seed", range(5))
def test_from_rest_there_is_one_force_and_it_obeys_coulomb(seed):
    rng = np.random.default_rng(seed)

    def rays(n, mu):
        a, b = np.linalg.svd(n[None])[2][1:]
        t = np.linspace(0, 2 * np.pi, 180, endpoint=False)
        return n + mu * (np.cos(t)[:, None] * a + np.sin(t)[:, None] * b)

    ended = set()
    for _ in range(60):
        k = rng.integers(1, 4)
        A, N, mu = rng.normal(size=(3, 3)), rng.normal(size=(k, 3)), rng.choice([0.0, 0.1, 0.3], k)
        W = A @ A.T + 0.3 * np.eye(3)
        N[:, 2] = np.abs(N[:, 2]) + 0.5
        N /= np.linalg.norm(N, axis=1)[:, None]
        drift = rng.normal(size=3) * 5 - [0, 0, 4]
        touch = PointContact.of(W, N, mu).solve(drift, np.zeros(k), None)
        a = drift + W @ touch.force
        assert (N @ a > -1e-8).all()
        cones = np.vstack([rays(n, m) for n, m in zip(N, mu, strict=True)]).T
        assert nnls(cones, touch.force)[1] < 1e-3 * np.linalg.norm(touch.force) + 1e-9
        if touch.stuck:
            assert np.abs(a).max() < 1e-9
        elif touch.active:
            # What would stop it is outside the cones, and where it slides, it moves on and friction is against it.
            assert nnls(cones, -np.linalg.solve(W, drift))[1] > 0.0
            if touch.slip.any():
                assert a @ touch.slip > 0.0
                across = a - (a @ touch.slip) * touch.slip
                active = N[list(touch.active)]
                assert np.abs(across - np.linalg.pinv(active) @ (active @ across)).max() < 1e-9
        ended.add("stuck" if touch.stuck else len(touch.active))
    assert {"stuck", 0, 1, 2} <= ended


@pytest.mark.parametrize("seed", range(4))
def test_an_arm_between_rough_faces_loses_energy_only_and_enters_none(seed):
    rng = np.random.default_rng(seed)
    q, qd = rng.uniform(0.3, 1.2, 2), rng.uniform(-2, 2, 2)
    p = ARM.forward_kinematics(q)[:3, 3]
    e, mu = rng.choice([0.0, 0.5]), rng.choice([0.0, 0.3])
    angle = rng.uniform(-0.4, 0.4)
    normals = np.array([[np.sin(angle), np.cos(angle), 0.0], [np.cos(angle), -np.sin(angle), 0.0]])
    faces = tuple(RigidSurface.plane(p - 0.03 * n, n, restitution=e, friction=mu) for n in normals)
    T = ARM.forward_kinematics(q)
    J = T[:3, :3] @ ARM.jacobian_body(q)[3:]
    push = ARM.gravity_torque(q) - J.T @ (normals[0] + normals[1]) * 20.0
    run = moved(ARM, faces, q, qd, 0.25, lambda t: push, step=1e-3)
    assert run
    places = ARM.forward_kinematics(run.q)[:, :3, 3]
    assert min(face.distance(places).min() for face in faces) > -1e-11
    total = ARM.kinetic_energy(run.q, run.qd) + ARM.potential_energy(run.q)
    work = np.append(0.0, np.cumsum((run.tau[:-1] * np.diff(run.q, axis=0)).sum(axis=1)))
    assert np.diff(total - work).max() < 1e-6
    if mu == 0.0:
        assert total[-1] - total[0] - work[-1] == pytest.approx(-run.metadata["rigid_contact"]["lost"], abs=1e-5)
