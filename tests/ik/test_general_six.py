"""Six joints without a special shape: nothing planted is lost, nothing is wrong, and a proof is never wrong."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.geometry import pose
from mafsil.ik import inverse_kinematics
from mafsil.ik.result import IKStatus
from mafsil.ik.structure import elimination
from mafsil.ik.structure.analysis import analysis

H = np.pi / 2
TURN = 2 * np.pi


def apart(found, q, slides=(False,) * 6):
    """Largest difference of coordinates, angles up to whole turns."""
    d = found - q
    return np.abs(np.where(np.array(slides), d, (d + np.pi) % TURN - np.pi)).max(axis=-1)


def random_arm(rng, slides=(False,) * 6):
    w = rng.normal(size=(6, 3))
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    r = rng.normal(size=(6, 3))
    turning = ~np.array(slides)[:, None]
    screws = np.concatenate([w * turning, np.where(turning, np.cross(r, w), w)], axis=1)
    return mf.Robot.from_screws(screws, pose.exp(rng.normal(size=6)))


def dh_arm(alpha, a, d):
    rows = [mf.DHRow(a=a[i], alpha=alpha[i], d=d[i], theta=0.0, kind="R") for i in range(len(a))]
    return mf.Robot.from_dh(rows, "classic")


def offset_wrist(e):
    """A PUMA whose last axes miss each other by e."""
    return dh_arm((H, 0, -H, H, -H, 0), (0, 0.43, 0.02, 0, e, 0), (0, 0, 0.15, 0.43, 0, 0.1))


def condition(robot, q):
    """(k,) smallest over largest singular value of the Jacobian."""
    values = np.linalg.svd(robot.jacobian_space(q), compute_uv=False)
    return values[..., -1] / values[..., 0]


def solved(robot, q):
    """All solutions of the poses of configurations, checked by forward kinematics; which configurations came back."""
    T = robot.forward_kinematics(q)
    found = elimination(robot).solve_all(T, threads=1)
    listed = np.arange(found.q.shape[1]) < found.count[:, None]
    assert (np.isfinite(found.q).all(axis=-1) == listed).all()
    reached = robot.forward_kinematics(np.nan_to_num(found.q).reshape(-1, 6)).reshape(*found.q.shape[:2], 4, 4)
    assert np.abs(np.where(listed[..., None, None], reached - T[:, None], 0.0)).max() < 1e-8
    slides = [joint.kind.value == "prismatic" for joint in robot.mechanism.coordinates]
    away = np.where(listed, apart(found.q, q[:, None], slides), np.inf)
    for i in range(len(q)):
        some = found.q[i, : found.count[i]]
        if len(some) > 1:
            between = apart(some[:, None], some[None], slides) + 9 * np.eye(len(some))
            assert between.min() > 1e-8
    return found, away.min(axis=1)


@pytest.mark.capability("07-44", "07-1", "07-2")
def test_random_arms_are_solved_completely():
    rng = np.random.default_rng(11)
    for _ in range(20):
        robot = random_arm(rng)
        q = rng.uniform(-np.pi, np.pi, (50, 6))
        found, away = solved(robot, q)
        assert away.max() < 1e-6
        assert found.complete.mean() > 0.97
        assert (found.count[found.complete] % 2 == 0).all()


@pytest.mark.capability("07-44")
def test_the_count_is_that_of_many_newton_starts():
    """A second method: Newton's method from starts everywhere finds no solution that a complete list lacks."""
    rng = np.random.default_rng(12)
    for _ in range(3):
        robot = random_arm(rng)
        T = robot.forward_kinematics(rng.uniform(-np.pi, np.pi, 6))
        answer = inverse_kinematics(robot, T)
        assert answer.complete
        q = rng.uniform(-np.pi, np.pi, (600, 6))
        for _ in range(40):
            error = pose.error(robot.forward_kinematics(q), np.broadcast_to(T, (len(q), 4, 4)))
            J = robot.jacobian_body(q)
            step = np.linalg.solve(J.swapaxes(1, 2) @ J + 1e-9 * np.eye(6), J.swapaxes(1, 2) @ error[..., None])[..., 0]
            q = q + step * np.minimum(1.0, 0.8 / (1e-300 + np.abs(step).max(axis=1, keepdims=True)))
        error = pose.error(robot.forward_kinematics(q), np.broadcast_to(T, (len(q), 4, 4)))
        hits = q[np.abs(error).max(axis=1) < 1e-9]
        assert len(hits) > 50
        nearest = apart(answer.q[None], hits[:, None])
        assert nearest.min(axis=1).max() < 1e-6
        assert len(np.unique(nearest.argmin(axis=1))) <= len(answer.q)


@pytest.mark.capability("07-44")
def test_sixteen_real_solutions():
    """Manocha and Canny, 1994, example 1 (after Wampler and Morgan): sixteen real solutions, no more beyond it."""
    r = np.deg2rad(1.0)
    robot = dh_arm((H, r, H, r, H, r), (0.3, 1, 0, 1.5, 0, 0), (0, 0, 0.2, 0, 0, 0))
    q = np.random.default_rng(1).uniform(-np.pi, np.pi, (300, 6))
    found, away = solved(robot, q)
    assert away.max() < 1e-6
    assert found.count.max() == 16
    assert found.complete[found.count == 16].any()


@pytest.mark.capability("07-44", "07-4")
def test_round_arms_at_round_angles_lose_nothing_regular_and_prove_nothing_wrong():
    rng = np.random.default_rng(5)
    for _ in range(6):
        robot = dh_arm(rng.choice([H, -H, 0.0], 6, p=[0.45, 0.45, 0.1]), *rng.integers(0, 4, (2, 6)) * 0.5)
        q = rng.integers(-4, 5, (200, 6)) * (np.pi / 4)
        found, away = solved(robot, q)
        regular = condition(robot, q) > 1e-3
        if analysis(robot.mechanism).form is None:
            assert away[regular & found.complete].max(initial=0.0) < 1e-6
        # A proof where the planted configuration is singular: it is still in the list, as far as rounding allows.
        assert away[found.complete].max(initial=0.0) < 1e-3


@pytest.mark.capability("07-42", "07-44")
@pytest.mark.parametrize("e", [1e-2, 1e-3, 1e-4, 1e-6, 1e-9])
def test_between_the_families_nothing_is_lost(e):
    robot = offset_wrist(e)
    q = np.random.default_rng(3).uniform(-np.pi, np.pi, (200, 6))
    found, away = solved(robot, q)
    regular = condition(robot, q) > 1e-3
    assert away[regular].max() < 1e-6
    assert away[found.complete].max() < 1e-6
    # A proof needs zeros beyond the rounding of the equations, which grows as the arm comes near the family.
    assert found.complete.mean() > (0.85 if e > 1e-9 else 0.6)


@pytest.mark.capability("07-44", "07-2")
def test_solutions_that_share_a_joint_value_are_both_found():
    """A collaborative arm with an offset wrist: solutions in pairs that almost agree in some joints."""
    robot = dh_arm((-H, 0, -H, H, -H, 0), (0, 0.54, 0, 0, 0, 0), (0.245, 0, 0, 0.54, 0.15, 0.16))
    q = np.random.default_rng(1).uniform(-np.pi, np.pi, (1000, 6))
    found, away = solved(robot, q)
    regular = condition(robot, q) > 1e-3
    assert away[regular].max() < 1e-6
    assert (found.count[regular] % 2 == 0).all()
    assert found.complete.mean() > 0.9


@pytest.mark.capability("07-44", "07-32")
@pytest.mark.parametrize("k", range(6))
def test_one_slide_anywhere(k):
    rng = np.random.default_rng(k)
    slides = tuple(i == k for i in range(6))
    robot = random_arm(rng, slides)
    q = rng.uniform(-np.pi, np.pi, (60, 6))
    q[:, k] = rng.uniform(-1.5, 1.5, 60)
    found, away = solved(robot, q)
    assert away.max() < 1e-5
    assert found.complete.mean() > 0.95


@pytest.mark.capability("07-44", "07-32")
@pytest.mark.parametrize("slides", [(1, 3), (0, 1), (0, 5), (2, 3), (1, 3, 5), (0, 1, 2)])
def test_several_slides_anywhere(slides):
    """Two slides: at most eight solutions; three: at most two."""
    rng = np.random.default_rng(sum(slides))
    flags = tuple(i in slides for i in range(6))
    robot = random_arm(rng, flags)
    q = rng.uniform(-1.5, 1.5, (40, 6))
    found, away = solved(robot, q)
    assert away.max() < 1e-6
    assert found.complete.mean() > 0.95
    assert found.count.max() <= (8 if len(slides) == 2 else 2)
    assert (found.count[found.complete] % 2 == 0).all()


@pytest.mark.capability("07-44", "07-4")
@pytest.mark.parametrize("slides", [(0, 1), (0, 1, 2)])
def test_slides_that_depend_on_each_other_prove_nothing(slides):
    """The first two slide along one line: what one does the other undoes, a continuum through every configuration."""
    rng = np.random.default_rng(9)
    w, r = rng.normal(size=(2, 6, 3))
    w[1] = w[0]
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    turning = np.array([i not in slides for i in range(6)])[:, None]
    screws = np.concatenate([w * turning, np.where(turning, np.cross(r, w), w)], axis=1)
    robot = mf.Robot.from_screws(screws, pose.exp(rng.normal(size=6)))
    found = elimination(robot).solve_all(robot.forward_kinematics(rng.uniform(-1.0, 1.0, (20, 6))))
    assert not found.complete.any()


@pytest.mark.capability("07-3", "07-44")
def test_an_arm_that_is_almost_everywhere_singular_proves_no_empty_list():
    """Its determinant is little more than rounding: what looks like no zero may be one."""
    for seed in range(12):
        rng = np.random.default_rng(seed)
        near = [rng.choice([H, -H, 0.0], 6, p=[0.3, 0.3, 0.4]), *rng.integers(0, 2, (2, 6)) * 0.5]
        robot = dh_arm(*(x + 1e-9 * rng.normal(size=6) for x in near))
        found = elimination(robot).solve_all(robot.forward_kinematics(rng.uniform(-np.pi, np.pi, (40, 6))))
        assert not found.complete[found.count == 0].any()


@pytest.mark.capability("07-44", "07-4")
@pytest.mark.parametrize("beside", [1e-3, 1e-4, 1e-5])
def test_near_a_fold_the_pair_is_two_and_no_more(beside):
    """Configurations beside the singular set: both solutions that meet there, none of them twice."""
    rng = np.random.default_rng(21)
    robot = random_arm(rng)
    low = rng.uniform(-np.pi, np.pi, (40, 6))
    high = low + rng.normal(size=low.shape)

    def side(q):
        return np.linalg.det(robot.jacobian_space(q))

    crossing = side(low) * side(high) < 0
    low, high = low[crossing], high[crossing]
    for _ in range(50):
        middle = (low + high) / 2
        over = side(middle) * side(low) < 0
        low, high = np.where(over[:, None], low, middle), np.where(over[:, None], middle, high)
    q = low + beside * rng.normal(size=low.shape)
    found, away = solved(robot, q)
    assert away.max() < 1e-6
    assert found.count.max() <= 12
    for one, k in zip(found.q, found.count, strict=True):
        between = apart(one[:k, None], one[None, :k]) + 9 * np.eye(k)
        # Of three in a row two would be one.
        assert (np.sort(between, axis=1)[:, 1] > 1e-5).all()


@pytest.mark.capability("07-3")
def test_an_empty_list_may_be_a_proof():
    robot = random_arm(np.random.default_rng(31))
    T = robot.forward_kinematics(np.zeros(6))
    rng = np.random.default_rng(0)
    proven = 0
    for _ in range(20):
        X = T @ pose.exp(rng.normal(size=6))
        answer = inverse_kinematics(robot, X)
        if not len(answer.q):
            proven += answer.complete
            assert answer.status is IKStatus.OUT_OF_REACH
    assert proven


@pytest.mark.capability("07-44")
def test_scale_and_place_of_the_arm_do_not_matter():
    rng = np.random.default_rng(4)
    w = rng.normal(size=(6, 3))
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    r = rng.normal(size=(6, 3))
    q = rng.uniform(-np.pi, np.pi, (40, 6))
    counts = []
    for scale, place in [(1.0, 0.0), (1e-3, 0.0), (1e3, 0.0), (1.0, 100.0)]:
        p = scale * r + place
        home = np.eye(4)
        home[:3, 3] = p[5] + scale * np.array([0.1, 0.2, 0.3])
        robot = mf.Robot.from_screws(np.concatenate([w, np.cross(p, w)], axis=1), home)
        found = elimination(robot).solve_all(robot.forward_kinematics(q))
        assert min(apart(s[:k], x).min() for s, k, x in zip(found.q, found.count, q, strict=True)) < 1e-6
        assert max(apart(s[:k], x).min() for s, k, x in zip(found.q, found.count, q, strict=True)) < 1e-6
        counts.append(found.count)
    assert all((one == counts[0]).all() for one in counts)


def test_batches_of_any_shape_and_none():
    robot = random_arm(np.random.default_rng(2))
    T = robot.forward_kinematics(np.random.default_rng(3).uniform(-3, 3, (2, 3, 6)))
    found = elimination(robot).solve_all(T)
    assert found.q.shape == (2, 3, 16, 6)
    assert found.count.shape == found.complete.shape == (2, 3)
    again = elimination(robot).solve_all(T[1, 2])
    np.testing.assert_array_equal(again.q, found.q[1, 2])
    assert elimination(robot).solve_all(np.zeros((0, 4, 4))).q.shape == (0, 16, 6)
    assert elimination(mf.load("iiwa7")) is None


def test_numbers_that_are_no_poses_have_no_solutions():
    robot = random_arm(np.random.default_rng(2))
    T = np.full((3, 4, 4), np.nan)
    T[1] = np.inf
    T[2] = 1e200
    found = elimination(robot).solve_all(T)
    assert (found.count == 0).all()
    assert not found.complete.any()
