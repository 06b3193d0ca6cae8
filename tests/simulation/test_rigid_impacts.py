"""Impacts on several rigid surfaces at once: symmetry, order, energy, cones, billiards, Moreau's law in two ways."""

from __future__ import annotations

from itertools import combinations, permutations

import numpy as np
import pytest
from scipy.optimize import brentq, lsq_linear, minimize

import mafsil as mf
from mafsil.simulation import RigidSurface
from mafsil.simulation.rigid_impacts import _share, after_impacts
from tests.simulation.rigid_scenes import ARM, BLOCK, MASS, ORIGIN, moved

EFFORTLESS = {"tau": lambda t: np.array([0.0, 0.0, MASS * 9.81])}


def impacts(run):
    return [event for event in run.metadata["rigid_contact"]["events"] if event["kind"] == "impact"]


def faces(normals, **each):
    return tuple(RigidSurface.plane(ORIGIN, n, **each) for n in normals)


def groove(half, **each):
    """Two planes whose normals are `half` from the vertical on either side."""
    return faces([[side * np.sin(half), 0.0, np.cos(half)] for side in (1, -1)], **each)


@pytest.mark.capability("10-68", "10-69")
@pytest.mark.parametrize("half", [0.3, 0.8, 1.2])
@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_a_ball_that_falls_into_the_middle_of_a_groove_rises_straight_again(half, friction):
    run = moved(BLOCK, groove(half, restitution=0.6, friction=friction), [0, 0, 0.05], [0, 0, -1.0], 0.1, **EFFORTLESS)
    np.testing.assert_allclose(run.qd[-1, :2], 0.0, atol=1e-12)
    # Each face gives back 0.6 of its speed along the normal, and both together that of the fall; then friction acts.
    first, second = impacts(run)
    assert first["speed"] == pytest.approx(np.cos(half), rel=1e-10)
    assert first["impulse"] == pytest.approx(1.6 * MASS / (2.0 * np.cos(half)), rel=1e-10)
    assert second["surface"] == 1 - first["surface"]
    for name in ("time", "speed", "impulse", "across", "lost"):
        assert second[name] == pytest.approx(first[name], rel=1e-12)
    assert run.qd[-1, 2] == pytest.approx(0.6 * max(1.0 - friction * np.tan(half), 0.0), rel=1e-7, abs=1e-12)
    assert run.metadata["rigid_contact"]["lost"] == pytest.approx(MASS / 2.0 * (1.0 - run.qd[-1, 2] ** 2), rel=1e-9)


def test_a_pyramid_with_four_faces_shares_its_impulse_evenly():
    normals = [[0.6, 0, 0.8], [-0.6, 0, 0.8], [0, 0.6, 0.8], [0, -0.6, 0.8]]
    run = moved(BLOCK, faces(normals, restitution=0.5), [0, 0, 0.05], [0, 0, -1.0], 0.1, **EFFORTLESS)
    np.testing.assert_allclose([event["impulse"] for event in impacts(run)], 1.5 * MASS / 3.2, rtol=1e-7)
    np.testing.assert_allclose(run.qd[-1], [0, 0, 0.5], atol=1e-10)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_the_order_of_the_surfaces_changes_nothing(friction):
    normals = np.array([[0.5, 0.2, 0.8], [-0.6, 0.1, 0.7], [0.1, -0.7, 0.5]])
    grounds = [
        RigidSurface.plane(ORIGIN, n, restitution=e, friction=friction)
        for n, e in zip(normals, (0.9, 0.2, 0.5), strict=True)
    ]
    ends = []
    for order in permutations(grounds):
        run = moved(BLOCK, order, [0.02, 0.01, 0.06], [-0.2, -0.1, -0.6], 0.15, **EFFORTLESS)
        assert len(impacts(run)) >= 2
        ends.append(np.append(run.q[-1], run.qd[-1]))
    assert np.ptp(ends, axis=0).max() < 1e-10


@pytest.mark.parametrize("angle", [np.pi / 3, np.pi / 4, np.pi / 5 + 0.01, 2.0])
def test_a_ball_thrown_into_the_edge_of_a_wedge_leaves_it_with_its_whole_energy(angle):
    wedge = faces([[0, 0, 1], [np.sin(angle), 0, -np.cos(angle)]], restitution=1.0)
    ways = np.array([np.cos(angle / 3), 0.0, np.sin(angle / 3)])
    run = moved(BLOCK, wedge, 0.05 * ways, -ways, 0.1, **EFFORTLESS)
    assert np.linalg.norm(run.qd[-1]) == pytest.approx(1.0, rel=1e-12)
    assert all(face.outward(ORIGIN) @ run.qd[-1] > 0.0 for face in wedge)
    assert run.metadata["rigid_contact"]["impacts"] <= 2 * np.ceil(np.pi / angle) + 2


@pytest.mark.parametrize("seed", range(10))
def test_moreau_s_law_by_a_second_road_and_its_properties(seed):
    rng = np.random.default_rng(seed)
    r, k = rng.integers(2, 4), rng.integers(2, 5)
    A, N, v = rng.normal(size=(r, r)), rng.normal(size=(k, r)), rng.normal(size=r)
    G = A @ A.T + 0.1 * np.eye(r)
    N /= np.linalg.norm(N, axis=1)[:, None]
    N *= -np.sign(N @ v)[:, None]
    e, mu = rng.uniform(0, 1, k), rng.choice([0.0, 0.3, 1.0], k)
    bounds = -e * (N @ v)
    smooth, rough = (after_impacts(G, N, each, v, e) for each in (np.zeros(k), mu))
    # The nearest point of the polyhedron in the norm of the energy, by a general method.
    inverse = np.linalg.inv(G)
    known = minimize(
        lambda x: (x - v) @ inverse @ (x - v), -v, jac=lambda x: 2.0 * inverse @ (x - v), method="SLSQP", tol=1e-14,
        constraints={"type": "ineq", "fun": lambda x: N @ x - bounds, "jac": lambda x: N},
    )  # fmt: skip
    np.testing.assert_allclose(smooth.velocity, known.x, atol=1e-6)
    away = N @ smooth.velocity - bounds
    assert away.min() > -1e-12
    assert np.abs(away * smooth.normal).max() < 1e-7
    for after, p, f in (smooth, rough):
        assert (p >= -1e-12).all()
        np.testing.assert_allclose(after, v + G @ (N.T @ p + f.sum(axis=0)), atol=1e-6 * np.abs(v).max())
        assert np.abs((f * N).sum(axis=1)).max() < 1e-12
        assert (np.linalg.norm(f, axis=1) <= mu * p * (1.0 + 1e-12) + 1e-12).all()
        assert after @ inverse @ after <= v @ inverse @ v * (1.0 + 1e-12)
    for order in permutations(range(k)):
        o = list(order)
        again = after_impacts(G, N[o], mu[o], v, e[o])
        np.testing.assert_allclose(again.velocity, rough.velocity, atol=1e-9)


@pytest.mark.parametrize("seed", range(10))
def test_friction_on_several_surfaces_takes_more_energy_than_any_other_in_its_cones(seed):
    rng = np.random.default_rng(seed)
    k = 3
    A, N, v = rng.normal(size=(3, 3)), rng.normal(size=(k, 3)), rng.normal(size=3)
    G, mu = A @ A.T + 0.1 * np.eye(3), rng.choice([0.1, 0.5], k)
    N *= (-np.sign(N @ v) / np.linalg.norm(N, axis=1))[:, None]
    inverse, still = np.linalg.inv(G), np.zeros(k)
    smooth, rough = after_impacts(G, N, still, v, still), after_impacts(G, N, mu, v, still)
    np.testing.assert_allclose(rough.normal, smooth.normal, rtol=1e-12)
    least = rough.velocity @ inverse @ rough.velocity
    for _ in range(300):
        other = rng.normal(size=(k, 3))
        other -= (other * N).sum(axis=1)[:, None] * N
        other *= (mu * rough.normal * rng.uniform(0, 1, k) / np.linalg.norm(other, axis=1))[:, None]
        for mixed in (other, 0.99 * rough.across + 0.01 * other):
            after = smooth.velocity + G @ mixed.sum(axis=0)
            assert least <= after @ inverse @ after + 1e-12


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_an_arm_that_slides_on_a_floor_into_a_wall_keeps_the_floor(friction):
    q = np.array([0.4, 1.1])
    T = ARM.forward_kinematics(q)
    J = (T[:3, :3] @ ARM.jacobian_body(q)[3:])[:2]
    floor = RigidSurface.plane(T[:3, 3], [0, 1, 0], restitution=0.7, friction=friction)
    wall = RigidSurface.plane(T[:3, 3] - [0.01, 0, 0], [1, 0, 0], restitution=0.5, friction=friction)
    qd = np.linalg.solve(J, [-0.8, 0.0])
    runs = []
    for order in ((floor, wall), (wall, floor)):
        run = moved(ARM, order, q, qd, 0.03, lambda t: ARM.gravity_torque(q) - J.T @ [0.0, 60.0])
        assert run
        places = ARM.forward_kinematics(run.q)[:, :3, 3]
        assert min(one.distance(places).min() for one in order) > -1e-11
        total = ARM.kinetic_energy(run.q, run.qd)
        assert total.max() <= total[0] + 0.05
        runs.append(run.q[-1])
    np.testing.assert_allclose(runs[0], runs[1], atol=1e-9)


def test_an_impact_on_a_floor_that_the_tip_rests_on_does_not_bounce_from_it():
    # The wall leans: its impulse presses the block onto the floor, which it does not leave, whatever its restitution.
    ground = RigidSurface.plane(ORIGIN, [0, 0, 1], restitution=0.9)
    lean = RigidSurface.plane([-0.1, 0, 0], [0.8, 0, -0.6], restitution=0.5)
    run = moved(BLOCK, (ground, lean), ORIGIN, [-1.0, 0, 0], 0.2)
    (wall, floor) = sorted(impacts(run), key=lambda event: -event["surface"])
    assert run.qd[-1, 0] == pytest.approx(0.5, rel=1e-12)
    assert abs(run.qd[-1, 2]) < 1e-12
    assert wall["impulse"] * 0.8 == pytest.approx(1.5 * MASS, rel=1e-8)
    assert floor["impulse"] == pytest.approx(0.6 * wall["impulse"], rel=1e-8)
    assert wall["lost"] + floor["lost"] == pytest.approx(0.75 * MASS / 2.0, rel=1e-8)


def test_a_surface_along_which_the_arm_cannot_move_takes_no_part():
    q = np.array([0.3, 0.8])
    T = ARM.forward_kinematics(q)
    aside = RigidSurface.plane(T[:3, 3], [0, 0, 1])
    wall = RigidSurface.plane(T[:3, 3] - [0.0, 0.02, 0], [0, 1, 0], restitution=0.5)
    J = (T[:3, :3] @ ARM.jacobian_body(q)[3:])[:2]
    run = moved(ARM, (aside, wall), q, np.linalg.solve(J, [0.0, -1.0]), 0.03, lambda t: ARM.gravity_torque(q))
    assert run
    assert {event["surface"] for event in impacts(run)} == {1}
    assert mf.load("planar2r_point_masses").n == 2


def _by_trial(G, N, v, bounds):
    """Impulses p >= 0 with N (v + G N' p) >= bounds, equal where p > 0: the set of surfaces that fits, of all."""
    for some in (list(each) for size in range(len(N) + 1) for each in combinations(range(len(N)), size)):
        p = np.zeros(len(N))
        p[some] = np.linalg.solve(N[some] @ G @ N[some].T, bounds[some] - N[some] @ v)
        if (p >= -1e-13).all() and (N @ (v + G @ N.T @ p) >= bounds - 1e-12).all():
            return p
    raise AssertionError("no set fits")


def _rubbed_in_the_plane(C, across, v, most):
    """Friction in a plane has two senses, so that the least energy is a least-squares problem in a box."""
    free = most > 1e-12
    if not free.any():
        return v
    columns = C.T @ across[free].T
    return v + C @ columns @ lsq_linear(columns, -np.linalg.solve(C, v), (-most[free], most[free]), tol=1e-15).x


def test_restitution_that_is_cut_short_by_energy_is_that_of_general_solvers():
    """All four steps between two rough lines by other means; where friction would give back more, the cut by roots."""
    rng, cut = np.random.default_rng(4), 0
    for _ in range(60):
        A, N, v = rng.normal(size=(2, 2)), rng.normal(size=(2, 2)), rng.normal(size=2)
        G = A @ A.T + 0.1 * np.eye(2)
        N *= (-np.sign(N @ v) / np.linalg.norm(N, axis=1))[:, None]
        e, mu = rng.uniform(0, 1, 2), rng.choice([0.0, 0.5, 2.0], 2)
        C, across = np.linalg.cholesky(G), N[:, ::-1] * [1.0, -1.0]

        def energy(velocity, C=C):
            return np.sum(np.linalg.solve(C, velocity) ** 2) / 2.0

        held, whole = _by_trial(G, N, v, np.zeros(2)), _by_trial(G, N, v, -e * (N @ v))
        pressed, returned = v + G @ N.T @ held, G @ N.T @ (whole - held)
        rubbed = _rubbed_in_the_plane(C, across, pressed, mu * np.minimum(held, whole))
        allowed = energy(pressed + returned) - energy(pressed)

        def excess(share, rubbed=rubbed, returned=returned, allowed=allowed, energy=energy):
            return energy(rubbed + share * returned) - energy(rubbed) - allowed

        share = brentq(excess, 0.0, 1.0, xtol=1e-15) if excess(1.0) > 1e-12 and excess(0.0) < 0.0 else 1.0
        known = _rubbed_in_the_plane(
            C, across, rubbed + share * returned, mu * share * np.maximum(whole - held, 0.0)
        )  # fmt: skip
        found = after_impacts(G, N, mu, v, e)
        np.testing.assert_allclose(found.velocity, known, rtol=0, atol=2e-7)
        np.testing.assert_allclose(found.normal, held + share * (whole - held), rtol=0, atol=1e-9)
        cut += share < 0.999
    assert cut >= 4


def test_restitution_after_friction_gives_back_what_it_would_without_it_or_less():
    rng, shares = np.random.default_rng(0), []
    for _ in range(50):
        A, x, v, rubbed = rng.normal(size=(3, 3)), *rng.normal(size=(3, 3))
        C = np.linalg.cholesky(A @ A.T + 0.1 * np.eye(3))

        def energy(velocity, C=C):
            return np.sum(np.linalg.solve(C, velocity) ** 2) / 2.0

        share = _share(C, x, v, rubbed)
        without, given = energy(v + x) - energy(v), energy(rubbed + share * x) - energy(rubbed)
        if 0.0 < share < 1.0:
            assert given == pytest.approx(without, abs=1e-9)
        assert given <= max(without, 0.0) + 1e-9
        shares.append(share)
    assert {0.0, 1.0} < set(shares)
