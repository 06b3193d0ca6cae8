"""Platforms in cables: what they hold, held against a linear program, and the proofs of what they do not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog, lsq_linear, minimize
from scipy.spatial.transform import Rotation

from mafsil import parallel
from mafsil.errors import InputError
from mafsil.geometry import pose, rotation
from mafsil.parallel import CableRobot, cable_poses, cable_tensions
from mafsil.parallel.cables.cable_tensions import CableStatus
from mafsil.parallel.cables.cable_workspace import ClosureStatus

CORNERS = np.array([[x, y, z] for x in (-2, 2) for y in (-1.5, 1.5) for z in (0, 3)], dtype=float)
EYES = np.array([[0.3 * np.sign(x), 0, -0.2] if z else [0, 0.3 * np.sign(y), 0.2] for x, y, z in CORNERS])


def crane() -> parallel.CableRobot:
    """Eight cables from the corners of a room, crossed at the platform."""
    return parallel.CableRobot(CORNERS, EYES, 10.0, 800.0)


def poses(rng, count, spread=0.4):
    T = np.tile(np.eye(4), (count, 1, 1))
    T[:, :3, 3] = rng.uniform([-1.2, -0.9, 0.7], [1.2, 0.9, 2.3], (count, 3))
    T[:, :3, :3] = Rotation.from_rotvec(rng.uniform(-spread, spread, (count, 3))).as_matrix()
    return T


@settings(max_examples=40)
@example(27781)  # At first all cables are at their bounds: Newton's method began with a step of 10^12 there.
@given(st.integers(0, 2**32 - 1))
def test_loads_are_held_exactly_where_a_linear_program_says_so(seed):
    rng = np.random.default_rng(seed)
    m = int(rng.integers(6, 10))
    robot = parallel.CableRobot(rng.uniform(-3, 3, (m, 3)), rng.uniform(-0.5, 0.5, (m, 3)), 5.0, 400.0)
    T = poses(rng, 6, 2.0)
    held_by_some = rng.uniform(0, 450, (6, m))
    load = -robot.wrench(T, held_by_some)
    found = parallel.cable_tensions(robot, T, load)
    W = robot.structure_matrix(T)
    for k, one in enumerate(found):
        program = linprog(np.zeros(m), A_eq=W[k], b_eq=-load[k], bounds=[(5, 400)] * m)
        if abs(one.margin) < 1e-6 or not one.direction.any():
            continue
        assert bool(one) == (program.status == 0) == bool(one.margin > 0)
        if one:
            assert (one.tensions >= 5 - 1e-9).all()
            assert (one.tensions <= 400 + 1e-9).all()
            np.testing.assert_allclose(W[k] @ one.tensions, -load[k], atol=1e-6)
        else:
            assert one.needed - one.offered == pytest.approx(-one.margin)


def test_the_proof_of_a_no_holds_for_all_tensions():
    rng = np.random.default_rng(1)
    robot, T = crane(), poses(rng, 1)[0]
    load = robot.weight(T, mass=400.0)
    no = parallel.cable_tensions(robot, T, load)
    assert no.status is CableStatus.BEYOND
    tried = robot.about_platform(T, robot.wrench(T, rng.uniform(10, 800, (5000, 8)))[..., None])[..., 0]
    assert (tried @ no.direction).max() <= no.offered < no.needed
    assert f"{no.needed:.6g}" in no.explain("en")
    assert f"{no.offered:.6g}" in no.explain("ar")


def test_tensions_are_the_nearest_to_the_preferred_ones():
    rng = np.random.default_rng(2)
    robot, T = crane(), poses(rng, 5, 0.05)
    load = robot.weight(T, mass=40.0, com=[0.0, 0.05, -0.02])
    for prefer in (None, 300.0):
        found = parallel.cable_tensions(robot, T, load, prefer=prefer)
        assert found.held.sum() >= 3
        W, aim = robot.structure_matrix(T), np.full(8, 10.0 if prefer is None else prefer)
        for k in np.flatnonzero(found.held):
            best = minimize(
                lambda t, aim=aim: ((t - aim) ** 2).sum(), np.full(8, 100.0), jac=lambda t, aim=aim: 2 * (t - aim),
                bounds=[(10, 800)] * 8, method="SLSQP", options={"maxiter": 500, "ftol": 1e-14},
                constraints={"type": "eq", "fun": lambda t, A=W[k], b=load[k]: A @ t + b, "jac": lambda t, A=W[k]: A},
            )  # fmt: skip
            np.testing.assert_allclose(found.tensions[k], best.x, atol=1e-3)


def test_rates_are_the_derivatives_of_lengths_and_dual_to_wrenches():
    rng = np.random.default_rng(3)
    robot, T = crane(), poses(rng, 1)[0]
    V, h = rng.normal(size=6), 1e-6
    W = np.zeros((4, 4))
    W[:3, :3], W[:3, 3] = np.cross(np.eye(3), -V[:3]).T, V[3:]
    ahead, behind = T + h * W @ T, T - h * W @ T
    for moved in (ahead, behind):
        u, _, v = np.linalg.svd(moved[:3, :3])
        moved[:3, :3] = u @ v
    numeric = (robot.lengths(ahead) - robot.lengths(behind)) / (2 * h)
    np.testing.assert_allclose(robot.cable_rates(T, V), numeric, atol=1e-8)
    t = rng.uniform(10, 100, 8)
    assert robot.wrench(T, t) @ V == pytest.approx(-t @ robot.cable_rates(T, V))


def test_a_planar_robot_is_the_spatial_one_in_its_plane():
    base, platform = (
        np.array([[-1.0, 0], [-1, 2], [1, 2], [1, 0]]),
        0.1 * np.array([[-1.0, 1], [-1, -1], [1, -1], [1, 1]]),
    )
    flat = parallel.CableRobot(base, platform, 1.0, 200.0)
    x = np.array([0.2, 0.9, 0.1])
    c, s = np.cos(0.1), np.sin(0.1)
    T = np.array([[c, -s, 0, 0.2], [s, c, 0, 0.9], [0, 0, 1, 0], [0, 0, 0, 1]])
    space = parallel.CableRobot(np.c_[base, np.zeros(4)], np.c_[platform, np.zeros(4)], 1.0, 200.0)
    np.testing.assert_allclose(flat.structure_matrix(x), space.structure_matrix(T)[[2, 3, 4]], atol=1e-12)
    load = flat.weight(x, mass=5.0)
    assert load[2] == pytest.approx(-5 * 9.81)
    held = parallel.cable_tensions(flat, x, load)
    assert held
    np.testing.assert_allclose(flat.wrench(x, held.tensions), -load, atol=1e-9)
    assert parallel.cable_tensions(space, T, space.weight(T, 5.0)).status is CableStatus.SINGULAR


def test_a_point_in_three_cables_from_above_hangs_but_is_not_enclosed():
    base = np.array([[1.0, 0, 2], [-0.5, 0.8, 2], [-0.5, -0.8, 2]])
    robot = parallel.CableRobot(base, np.zeros((3, 3)), 0.0, 1000.0)
    T = np.eye(4)
    assert robot.freedoms == 3
    weight = robot.weight(T, mass=10.0)
    held = parallel.cable_tensions(robot, T, weight)
    assert held
    np.testing.assert_allclose(held.tensions, np.linalg.solve(robot.structure_matrix(T)[3:], -weight[3:]), atol=1e-9)
    closure = parallel.cables.cable_closure(robot, T)
    assert closure.status is ClosureStatus.OPEN
    pulls = robot.structure_matrix(T)[3:].T @ closure.direction
    assert (pulls <= 1e-9).all(), "no cable pulls along it"
    assert parallel.cables.cable_closure(parallel.CableRobot(
        np.vstack([base, [0, 0, -2]]), np.zeros((4, 3)), 0.0, 1.0), T)  # fmt: skip


def test_closure_is_that_of_random_directions():
    rng = np.random.default_rng(5)
    robot, T = crane(), poses(rng, 30, 1.5)
    found = parallel.cables.cable_closure(robot, T)
    assert 0 < found.closed.sum() < 30
    W = robot.about_platform(T, robot.structure_matrix(T))
    directions = rng.normal(size=(20000, 6))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    for k, one in enumerate(found):
        pulls = (directions @ W[k]).max(axis=1).min()
        if one:
            assert pulls > 0
        else:
            assert (one.direction @ W[k]).max() <= 1e-9


def test_the_workspace_is_where_all_loads_are_held():
    flat = parallel.CableRobot(
        [[-1.0, 0], [-1, 2], [1, 2], [1, 0]], 0.05 * np.array([[-1.0, 1], [-1, -1], [1, -1], [1, 1]]), 2.0, 150.0
    )
    loads = [[0, 0, -30], [0, 20, -30], [0, -20, -30]]
    found = parallel.cable_workspace(flat, loads, [-1, 0], [1, 2], cells=24, orientations=[0.0, 0.2])
    assert found
    assert found.margin.shape == (2, 24, 24)
    for k, i, j in np.random.default_rng(0).integers([2, 24, 24], size=(60, 3)):
        x = np.array([found.axes[0][i], found.axes[1][j], (0.0, 0.2)[k]])
        W = flat.structure_matrix(x)
        for load in loads:
            m, fx, fy = load
            at = np.array([m + x[0] * fy - x[1] * fx, fx, fy])
            program = linprog(np.zeros(4), A_eq=W, b_eq=-at, bounds=[(2, 150)] * 4)
            if found.feasible[k, i, j]:
                assert program.status == 0
    area, error = found.volume(found.feasible.all(axis=0))
    finer = parallel.cable_workspace(flat, loads, [-1, 0], [1, 2], cells=72, orientations=[0.0, 0.2])
    assert abs(finer.volume(finer.feasible.all(axis=0))[0] - area) <= error
    assert "m^2" in found.explain("en")
    assert not parallel.cable_workspace(flat, [[0, 0, -9000]], [-1, 0], [1, 2], cells=5)


def test_what_is_no_robot_is_refused():
    with pytest.raises(InputError, match="lowest"):
        parallel.CableRobot(CORNERS, EYES, 10.0, 5.0)
    with pytest.raises(InputError, match="platform"):
        parallel.CableRobot(CORNERS, EYES[:4], 10.0, 50.0)
    with pytest.raises(InputError, match="base"):
        parallel.CableRobot(np.zeros((3, 4)), np.zeros((3, 4)), 10.0, 50.0)
    with pytest.raises(InputError, match="load"):
        parallel.cable_tensions(crane(), np.eye(4), [np.nan] * 6)
    few = parallel.CableRobot(CORNERS[:3], EYES[:3], 1.0, 50.0)
    assert parallel.cable_tensions(few, np.eye(4), np.zeros(6)).status is CableStatus.SINGULAR


def test_the_nearest_tensions_where_none_hold_the_load():
    """Bounded least squares, by another program; the distance is never less than the facet's."""
    rng, robot = np.random.default_rng(7), crane()
    T, load = np.tile(np.eye(4), (20, 1, 1)), 3000.0 * rng.normal(size=(20, 6))
    T[:, :3, 3] = rng.uniform(-0.3, 0.3, (20, 3))
    load[:10] /= 10
    found = parallel.cable_tensions(robot, T, load)
    W, open_rows = robot.about_platform(T, robot.structure_matrix(T)), np.flatnonzero(~found.held)
    wanted = robot.about_platform(T, -load[..., None])[..., 0]
    assert len(open_rows) > 10
    for k in open_rows:
        best = lsq_linear(W[k], wanted[k], (robot.lowest, robot.highest), tol=1e-14)
        assert found.missing[k] == pytest.approx(np.sqrt(2 * best.cost), rel=1e-9)
        assert ((found.tensions[k] >= robot.lowest) & (found.tensions[k] <= robot.highest)).all()
    assert (found.missing[open_rows] >= -found.margin[open_rows] - 1e-9).all()
    few = parallel.CableRobot(robot.base[:4], robot.platform[:4], robot.lowest[:4], robot.highest[:4])
    none = parallel.cable_tensions(few, np.eye(4), [0, 0, 0, 0, 0, -30.0])
    assert none.margin == -np.inf
    assert f"{float(none.missing):.4g} N" in none.explain("en")


def on_pulleys(radius, planar=False):
    """A crane whose cables come up to its upper pulleys and down to its lower ones, or a planar one."""
    if planar:
        frame = np.array([[-2.0, 0], [-2, 3], [2, 0], [2, 3]])
        platform = np.array([[-0.2, -0.1], [-0.2, 0.1], [0.2, -0.1], [0.2, 0.1]])
    else:
        frame, platform = CORNERS, EYES
    up = np.where(frame[:, -1:] > 0, 1.0, -1.0) * np.eye(frame.shape[1])[-1]
    return CableRobot(frame, platform, 1.0, 500.0, pulleys=radius, arrivals=up)


@pytest.mark.capability("08-40")
@pytest.mark.parametrize("planar", [False, True])
def test_cables_on_pulleys(planar):
    radius = np.linspace(0.05, 0.2, 4 if planar else 8)
    robot = on_pulleys(radius, planar)
    rng = np.random.default_rng(3)
    V, x = rng.normal(size=3 if planar else 6), np.array([0.3, 1.4, 0.1])
    if not planar:
        x = pose.from_rotation_translation(rotation.exp([0.1, 0.2, -0.1]), [0.3, 0.2, 1.4])
    d, ends = robot.cable_vectors(x), robot._ends(x)
    tangent = ends - d
    spoke = tangent - robot.base
    # From a_i over the pulley to the tangent: a chord of its wrapped angle, and the end on the tangent.
    beta = (robot.lengths(x) - np.linalg.norm(d, axis=1)) / radius
    np.testing.assert_allclose(np.linalg.norm(spoke, axis=1), 2 * radius * np.abs(np.sin(beta / 2)), atol=1e-12)
    assert ((beta > 0) & (beta < np.pi)).all()
    u = d / np.linalg.norm(d, axis=1, keepdims=True)
    np.testing.assert_allclose((u * robot.arrivals).sum(axis=1), np.cos(beta), atol=1e-12)

    def at(t):
        if not planar:
            return pose.exp(V * t) @ x
        turn = np.array([[np.cos(V[0] * t), -np.sin(V[0] * t)], [np.sin(V[0] * t), np.cos(V[0] * t)]])
        return np.append(turn @ x[:2] + V[1:] * t, x[2] + V[0] * t)

    step = 1e-6
    slope = (robot.lengths(at(step)) - robot.lengths(at(-step))) / (2 * step)
    np.testing.assert_allclose(robot.cable_rates(x, V), slope, atol=1e-8)
    assert cable_poses(robot, robot.lengths(x), at(0.05))
    np.testing.assert_allclose(cable_poses(robot, robot.lengths(x), at(0.05)).x, x, atol=1e-10)
    held = cable_tensions(robot, x, robot.weight(x, 20.0))
    assert held
    np.testing.assert_allclose(robot.wrench(x, held.tensions) + robot.weight(x, 20.0), 0.0, atol=1e-8)


def test_small_pulleys_are_points_and_large_ones_are_refused():
    x = pose.from_translation([0.3, 0.2, 1.4])
    small, none = on_pulleys(1e-9), on_pulleys(0.0)
    np.testing.assert_allclose(small.lengths(x), none.lengths(x), atol=1e-8)
    np.testing.assert_allclose(small.structure_matrix(x), none.structure_matrix(x), atol=1e-8)
    with pytest.raises(InputError, match="within its pulley"):
        on_pulleys(2.3).lengths(x)
    with pytest.raises(InputError, match="negative"):
        on_pulleys(-0.1)
