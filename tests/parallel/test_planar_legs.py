"""Planar platforms on three legs: planted poses, self-motions, rates, singularities of both kinds."""

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve, least_squares

from mafsil.errors import InputError
from mafsil.mobility import torus
from mafsil.parallel import FiveBar, ParallelCranks, PlanarThreeRPR, PlanarThreeRRR, SingularKind, choose_actuators
from mafsil.parallel.planar.planar_poses import PlanarPosesStatus


def turned(x, step):
    """The pose after a small motion of twist (omega, v)."""
    c, s = np.cos(step[..., 0]), np.sin(step[..., 0])
    p = np.stack([c * x[..., 0] - s * x[..., 1], s * x[..., 0] + c * x[..., 1]], axis=-1) + step[..., 1:]
    return np.concatenate([p, x[..., 2:] + step[..., :1]], axis=-1)


def random_poses(rng, count):
    return np.concatenate([rng.normal(size=(count, 2)), rng.uniform(-np.pi, np.pi, (count, 1))], axis=1)


@pytest.mark.capability("08-22", "08-35", "02-20")
def test_planted_poses_are_found_and_all_fit():
    rng = np.random.default_rng(0)
    for _ in range(30):
        robot = PlanarThreeRPR(*rng.normal(size=(2, 3, 2)) * 10 + [[[50, 0]], [[0, -30]]])
        x = random_poses(rng, 40) * [10, 10, 1]
        s = robot.lengths(x)
        found = robot.forward_kinematics(s)
        assert found
        assert (found.count % 2 == 0).all()
        assert (found.count <= 6).all()
        assert np.nanmin(np.abs(found.x - x[:, None]).max(axis=2), axis=1).max() < 1e-5
        there = np.isfinite(found.x[..., 0])
        again = robot.lengths(np.where(there[..., None], found.x, 0.0))
        assert np.abs(again - s[:, None])[there].max() < 1e-9
        assert found.error < 1e-9


@pytest.mark.capability("08-22")
def test_a_search_from_many_starts_finds_no_more():
    rng = np.random.default_rng(1)
    robot = PlanarThreeRPR(*rng.normal(size=(2, 3, 2)))
    s = robot.lengths(random_poses(rng, 1)[0])
    seen = {tuple(np.round(x, 6)) for x in robot.forward_kinematics(s)}
    for start in random_poses(rng, 300):
        x, _, ended, _ = fsolve(lambda x: robot.lengths(x) - s, start, full_output=True)
        if ended == 1 and np.abs(robot.lengths(x) - s).max() < 1e-10:
            x[2] = np.angle(np.exp(1j * x[2]))
            assert tuple(np.round(x, 6)) in seen


@pytest.mark.capability("08-22")
def test_self_motion_and_isolated_poses_together():
    hinges = [[0, 0], [4, 0], [1, 3]]
    found = PlanarThreeRPR(hinges, hinges).forward_kinematics([2, 2, 2])
    assert found.status is PlanarPosesStatus.MOVABLE
    assert found.movable
    assert np.tan(found.x[:, 2] / 2) == pytest.approx([-0.5, 0.5])


@pytest.mark.capability("08-22", "08-21")
def test_lengths_that_cannot_be_joined():
    robot = PlanarThreeRPR([[0, 0], [4, 0], [2, 3.5]], [[-0.5, -0.3], [0.5, -0.3], [0, 0.6]])
    found = robot.forward_kinematics([[1, 1, 1], [1.9, 1.8, 1.6]])
    assert found.status is PlanarPosesStatus.SOME
    assert not found
    assert not found[0]
    assert found[1]
    with pytest.raises(InputError, match="signed"):
        robot.forward_kinematics([-1, 1, 1])
    np.testing.assert_allclose(
        robot.forward_kinematics([-1.9, 1.8, 1.6], signed=True).x, robot.forward_kinematics([1.9, 1.8, 1.6]).x
    )
    with pytest.raises(InputError, match="leg 2"):
        robot.jacobian([4 - 0.5, 0.3, 0])


@pytest.mark.capability("08-40", "08-4")
def test_rates_of_three_rpr_are_differences():
    rng = np.random.default_rng(2)
    robot = PlanarThreeRPR(*rng.normal(size=(2, 3, 2)))
    x, V, h = random_poses(rng, 30), rng.normal(size=(30, 3)), 1e-6
    ahead, behind = turned(x, h * V), turned(x, -h * V)
    difference = (robot.lengths(ahead) - robot.lengths(behind)) / (2 * h)
    np.testing.assert_allclose(robot.leg_rates(x, V), difference, rtol=1e-6, atol=1e-6)
    tau = rng.normal(size=(30, 3))
    power = (tau * robot.leg_rates(x, V)).sum(1), (robot.wrench(x, tau) * V).sum(1)
    np.testing.assert_allclose(power[0], power[1], atol=1e-12)
    A, B = robot.motor_matrices(x)
    angle = [np.arctan2(d[..., 1], d[..., 0]) for d in (robot.leg_vectors(ahead), robot.leg_vectors(behind))]
    rate = np.angle(np.exp(1j * (angle[0] - angle[1]))) / (2 * h)
    np.testing.assert_allclose(np.einsum("kij,kj->ki", A, V), np.einsum("kij,kj->ki", B, rate), rtol=1e-5, atol=1e-5)


@pytest.mark.capability("08-54")
def test_second_order_is_a_difference():
    rng = np.random.default_rng(3)
    robot, h = PlanarThreeRPR(*rng.normal(size=(2, 3, 2))), 1e-4
    x, V, w = random_poses(rng, 10), rng.normal(size=(10, 3)), rng.normal(size=(10, 3))
    ahead, behind = (robot.lengths(_exp(x, k * h * V)) for k in (1, -1))
    second = (ahead - 2 * robot.lengths(x) + behind) / h**2
    np.testing.assert_allclose(robot.second_order(x, V, w), (w * second).sum(1), rtol=1e-5, atol=1e-5)


def _exp(x, V):
    """The pose after the motion exp(V) of the plane."""
    c, s = np.cos(V[..., 0]), np.sin(V[..., 0])
    one, other = s / V[..., 0], (1 - c) / V[..., 0]
    move = np.stack([one * V[..., 1] - other * V[..., 2], other * V[..., 1] + one * V[..., 2]], axis=-1)
    p = np.stack([c * x[..., 0] - s * x[..., 1], s * x[..., 0] + c * x[..., 1]], axis=-1) + move
    return np.concatenate([p, x[..., 2:] + V[..., :1]], axis=-1)


def three_rrr():
    angles = np.radians([90, 210, 330])
    corners = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    return PlanarThreeRRR(2 * corners, 0.6 * corners, [1.0, 1.1, 0.9], [1.2, 1.0, 1.1])


@pytest.mark.capability("08-35", "08-29", "08-30")
def test_three_rrr_there_and_back():
    robot, rng = three_rrr(), np.random.default_rng(4)
    x = random_poses(rng, 50) * 0.1
    answer = robot.inverse_kinematics(x)
    assert answer
    both = answer.q
    for choice in range(8):
        q = np.stack([both[:, leg, choice >> leg & 1] for leg in range(3)], axis=1)
        found = robot.forward_kinematics(q)
        assert found
        assert np.nanmin(np.abs(found.x - x[:, None]).max(axis=2), axis=1).max() < 1e-7
    assert not robot.inverse_kinematics([9.0, 0, 0])


@pytest.mark.capability("08-53", "08-58", "08-60", "02-20")
def test_three_rrr_rates_and_both_kinds():
    robot, rng = three_rrr(), np.random.default_rng(5)
    x, V, h = random_poses(rng, 50) * 0.2, rng.normal(size=(50, 3)), 1e-6
    q = robot.inverse_kinematics(x).q[..., 0]
    A, B = robot.motor_matrices(x, q)
    ahead, back = (robot.inverse_kinematics(turned(x, sign * h * V)).q[..., 0] for sign in (1, -1))
    rate = (ahead - back) / (2 * h)
    np.testing.assert_allclose(np.einsum("kij,kj->ki", A, V), np.einsum("kij,kj->ki", B, rate), rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(np.einsum("kij,kj->ki", robot.jacobian(x, q), rate), V, rtol=1e-5, atol=1e-5)
    F = rng.normal(size=(50, 3))
    power = (robot.torques(x, q, F) * rate).sum(axis=1)
    np.testing.assert_allclose(power, (F * V).sum(axis=1), rtol=1e-5, atol=1e-5)
    assert robot.singularity(x, q)
    # A stretched leg: the end of the platform stands at the sum of both lengths from its motor.
    turn = 0.1
    end = robot.base[0] + (robot.cranks[0] + robot.rods[0]) * np.array([np.cos(-1.6), np.sin(-1.6)])
    b = robot.platform[0]
    p = end - [np.cos(turn) * b[0] - np.sin(turn) * b[1], np.sin(turn) * b[0] + np.cos(turn) * b[1]]
    stretched = np.array([*p, turn])
    q = robot.inverse_kinematics(stretched).q[:, 0]
    found = robot.singularity(stretched, q)
    assert found.status is SingularKind.FIRST
    blocked = found.blocked_motion
    A, B = robot.motor_matrices(stretched, q)
    for motor in (1, 2):
        rate = np.zeros(3)
        rate[motor] = 1.0
        assert blocked @ np.linalg.solve(A, B @ rate) == pytest.approx(0, abs=1e-9)
    assert "blocked" in found.explain("en")


@pytest.mark.capability("08-53", "08-55")
def test_parallel_rods_are_singular_of_the_second_kind():
    q = np.radians([90, 90, 90])
    base = np.array([[0, 0], [2, 0], [1, 2.0]])
    robot = PlanarThreeRRR(base, base, [1, 1, 1], [1, 1, 1])
    x = np.array([np.cos(0.3), 1 + np.sin(0.3), 0.0])
    found = robot.singularity(x, q)
    assert found.status is SingularKind.SECOND
    V = found.free_motion
    assert np.abs(robot.motor_matrices(x, q)[0] @ V).max() < 1e-12
    assert robot.forward_kinematics(q).movable


@pytest.mark.capability("08-62", "08-51")
def test_cranks_of_any_length_close_and_their_derivatives_are_differences():
    robot, h = ParallelCranks(0.7, [0.0, 1.5, 2.2]), 1e-6
    rng = np.random.default_rng(6)
    turned = np.append(np.full(3, 0.9), 0.0)
    assert np.abs(robot.closure(turned)).max() < 1e-15
    for q in rng.uniform(-2, 2, (5, 4)):
        # The platform's pins stand at the crank ends: what each misses, in the plane.
        ends = np.array([[c + 0.7 * np.cos(a), 0.7 * np.sin(a)] for c, a in zip((0.0, 1.5, 2.2), q[:3], strict=True)])
        along = np.array([np.cos(q[3]), np.sin(q[3])])
        missed = ends[1:] - (ends[0] + np.outer([1.5, 2.2], along))
        np.testing.assert_allclose(robot.closure(q), missed.T.reshape(-1), atol=1e-12)
        steps = [(robot.closure(q + h * e) - robot.closure(q - h * e)) / (2 * h) for e in np.eye(4)]
        np.testing.assert_allclose(robot.loop_matrix(q), np.array(steps).T, atol=1e-8)
        second = [(robot.loop_matrix(q + h * e) - robot.loop_matrix(q - h * e)) / (2 * h) for e in np.eye(4)]
        np.testing.assert_allclose(robot.curvature(q), np.moveaxis(second, 0, -1), atol=1e-8)


@pytest.mark.capability("08-57", "08-52", "08-56")
def test_all_links_in_line_are_singular_for_every_pair_of_motors_and_nothing_else_is():
    """Random five-bars that can lie in one line: there no pair drives them; elsewhere some pair does."""
    rng = np.random.default_rng(7)
    for _ in range(12):
        signs = np.append(rng.choice([-1.0, 1.0], 4), 1.0)
        lengths = rng.uniform(0.5, 2.0, 4)
        ground = float(signs[:4] @ lengths)
        if ground < 0.3:
            signs[:4], ground = -signs[:4], -ground
        if ground < 0.3:
            continue
        robot = FiveBar(*lengths, ground)
        absolute = np.where(signs[:4] > 0, 0.0, np.pi)
        flat = np.diff(absolute, prepend=0.0)
        np.testing.assert_allclose(robot.chain.closure(flat), 0.0, atol=1e-12)
        assert choose_actuators(robot.chain.loop_matrix(flat), 2, full_rank=3) == ()
        assert np.abs(torus.difference(robot.chain.collinear_configurations(), flat)).max(axis=1).min() < 1e-9
        q = np.array([absolute[0] + 0.3, rng.uniform(-3, 3)])
        bent = robot.chain_angles(q)
        if robot.forward_kinematics(q):
            H = robot.chain.loop_matrix(bent[:4])
            assert np.linalg.matrix_rank(H, 1e-9) == 3
            good = choose_actuators(H, 2, full_rank=3)
            assert good
            for pair in ((0, 1), (0, 4), (2, 3)):
                passive = np.delete(H, pair, axis=1)
                assert (pair in good) == (np.linalg.matrix_rank(passive, 1e-9) == 3)


@pytest.mark.capability("08-21", "08-22")
def test_legs_of_length_zero_pin_the_platform():
    """Newton's method has no slope there; s = 0 must neither divide nor lose the pose."""
    rng = np.random.default_rng(8)
    platform, x = rng.normal(size=(3, 2)), np.array([0.3, 0.2, 0.5])
    ends = PlanarThreeRPR(np.zeros((3, 2)), platform).leg_vectors(x)
    for pinned in (1, 2, 3):
        base = np.where(np.arange(3)[:, None] < pinned, ends, ends + rng.normal(size=(3, 2)))
        robot = PlanarThreeRPR(base, platform)
        s = np.where(np.arange(3) < pinned, 0.0, robot.lengths(x))
        found = robot.forward_kinematics(s)
        assert found
        assert not found.movable
        assert np.abs(found.x - x).max(axis=1).min() < 1e-9
        with pytest.raises(InputError, match="has length zero"):
            robot.jacobian(x)


@pytest.mark.capability("08-21", "08-22")
def test_lengths_that_no_pose_has_say_how_far_they_are_off():
    base, platform = [[0, 0], [3, 0.2], [1.1, 2.7]], [[-0.4, -0.2], [0.6, -0.1], [0.1, 0.7]]
    robot = PlanarThreeRPR(base, platform)
    wanted = np.array([[0.1, 0.1, 0.1], [5, 1, 1], robot.lengths([1.0, 1.0, 0.3])])
    found = robot.forward_kinematics(wanted)
    assert not found
    assert "1 of 3 rows" in found.explain("en")
    np.testing.assert_allclose(robot.lengths(found.nearest.x) - wanted, found.nearest.misfit, atol=1e-12)
    assert found.nearest.distance[2] == pytest.approx(0.0, abs=1e-12)
    rng = np.random.default_rng(0)
    for row, s in zip(found, wanted[:2], strict=False):
        starts = rng.uniform([-3, -3, -4], [5, 5, 4], (40, 3))
        fits = [least_squares(lambda x, s=s: robot.lengths(x) - s, start).cost for start in starts]
        assert row.nearest.distance == pytest.approx(np.sqrt(2 * min(fits)), rel=1e-6)
        assert f"{row.nearest.distance:.4g} m away" in row.explain("en")
    # A platform on cranks: its rods are the legs.
    cranks = PlanarThreeRRR(base, platform, [1, 1, 1], [0.5, 0.6, 0.5])
    assert cranks.forward_kinematics([3.0, 0.0, 1.5]).nearest.distance > 0.1


@pytest.mark.capability("08-22")
def test_rows_of_other_sizes_and_short_legs_lose_nothing():
    """Each row has its own scale; where three lines meet and a leg is short, the pose is double and hardly stiff."""
    robot = PlanarThreeRPR([[0, 0], [3, 0.2], [1.1, 2.7]], [[-0.4, -0.2], [0.6, -0.1], [0.1, 0.7]])
    alone = robot.forward_kinematics(robot.lengths([0.3, 0.2, 0.5]))
    beside = robot.forward_kinematics([robot.lengths([0.3, 0.2, 0.5]), [0, 0, 1e7]])
    np.testing.assert_allclose(beside.x[0], alone.x, atol=1e-12)
    rng = np.random.default_rng(183)
    robot, p = PlanarThreeRPR(rng.normal(size=(3, 2)), rng.normal(size=(3, 2))), rng.normal(size=2)
    x = np.array([*p, brentq(lambda phi: np.linalg.det(robot.jacobian([*p, phi])), -0.96, -0.92, xtol=1e-16)])
    found = robot.forward_kinematics(robot.lengths(x))
    assert robot.lengths(x).min() < 1e-4
    assert np.abs(found.x - x).max() < 1e-6
