"""Platforms on six legs: laws on random platforms and poses."""

import numpy as np
import pytest

from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.parallel import PlanarThreeRPR, StewartPlatform
from mafsil.parallel.platforms.stewart import ForwardStatus


def random_platform(rng):
    return StewartPlatform(rng.normal(size=(6, 3)), rng.normal(size=(6, 3)))


def random_poses(rng, count, turn=1.0, reach=1.0):
    return pose.exp(np.concatenate([turn * rng.normal(size=(count, 3)), reach * rng.normal(size=(count, 3))], axis=1))


@pytest.mark.capability("08-36")
@pytest.mark.parametrize("frame", ["space", "body"])
def test_rates_are_differences(frame):
    rng = np.random.default_rng(1)
    robot, T, V, h = random_platform(rng), random_poses(rng, 20), rng.normal(size=(20, 6)), 1e-5
    moved = [pose.exp(k * h * V) @ T if frame == "space" else T @ pose.exp(k * h * V) for k in (-1, 1)]
    difference = (robot.lengths(moved[1]) - robot.lengths(moved[0])) / (2 * h)
    np.testing.assert_allclose(robot.leg_rates(T, V, frame), difference, atol=1e-8)
    np.testing.assert_allclose(robot.twist(T, robot.leg_rates(T, V, frame), frame), V, rtol=1e-6, atol=1e-7)


@pytest.mark.capability("08-37", "08-38", "08-39")
def test_wrench_of_the_legs_is_the_sum_of_moments_and_forces():
    rng = np.random.default_rng(2)
    robot, T, tau = random_platform(rng), random_poses(rng, 20), rng.normal(size=(20, 6))
    u = robot.leg_vectors(T) / robot.lengths(T)[..., None]
    ends = pose.act(T[:, None], robot.platform)
    f = tau[..., None] * u
    expected = np.concatenate([np.cross(ends, f).sum(1), f.sum(1)], axis=1)
    np.testing.assert_allclose(robot.wrench(T, tau), expected, atol=1e-12)
    V = rng.normal(size=(20, 6))
    np.testing.assert_allclose((tau * robot.leg_rates(T, V)).sum(1), (robot.wrench(T, tau) * V).sum(1), atol=1e-11)
    np.testing.assert_allclose(robot.leg_forces(T, robot.wrench(T, tau)), tau, rtol=1e-6, atol=1e-7)


@pytest.mark.capability("08-26")
def test_newton_comes_back_from_near():
    rng = np.random.default_rng(3)
    robot = StewartPlatform.on_circles(
        2.0, 1.0, np.radians([-15, 15, 105, 135, 225, 255]), np.radians([-45, 45, 75, 165, 195, 285])
    )
    home = pose.from_translation([0, 0, 1.5])
    T = home @ random_poses(rng, 2000, 0.15, 0.15)
    found = robot.forward_near(robot.lengths(T), home)
    assert found.found.mean() > 0.999
    np.testing.assert_allclose(robot.lengths(found.T[found.found]), robot.lengths(T)[found.found], atol=3e-12)
    np.testing.assert_allclose(found.T[found.found], T[found.found], atol=1e-8)
    assert found.T.shape == (2000, 4, 4)
    assert len(list(found)) == 2000


@pytest.mark.capability("08-25", "08-21")
def test_negative_lengths_are_another_branch_of_the_same_poses():
    robot = StewartPlatform.on_circles(
        2.0, 1.0, np.radians([-15, 15, 105, 135, 225, 255]), np.radians([-45, 45, 75, 165, 195, 285])
    )
    T = pose.from_translation([0.1, -0.2, 1.6]) @ pose.exp([0.1, -0.08, 0.17, 0, 0, 0])
    both = robot.lengths(T, signed=True)
    np.testing.assert_array_equal(both[:, 0], robot.lengths(T))
    for branch in (both[:, 1], np.where(np.arange(6) % 2, both[:, 0], both[:, 1])):
        np.testing.assert_allclose(branch**2, (robot.leg_vectors(T) ** 2).sum(axis=-1), rtol=1e-14)
        np.testing.assert_allclose(
            robot.forward_near(branch, pose.from_translation([0, 0, 1.5]), signed=True).T, T, atol=1e-9
        )
        for refused in (lambda s=branch: robot.forward_near(s, T), lambda s=branch: robot.forward_kinematics(s)):
            with pytest.raises(InputError, match="signed"):
                refused()
    planar = PlanarThreeRPR([[0, 0], [4, 0], [2, 3.5]], [[-0.5, -0.3], [0.5, -0.3], [0, 0.6]])
    np.testing.assert_array_equal(planar.lengths([2.1, 1.3, 0.3], signed=True)[:, 1], -planar.lengths([2.1, 1.3, 0.3]))


@pytest.mark.capability("08-27", "08-28")
def test_one_polynomial_has_a_coordinate_of_every_pose_as_zero():
    robot = random_platform(np.random.default_rng(8))
    s = robot.lengths(pose.exp([0.2, -0.3, 0.4, 0.1, 0.2, 0.9]))
    modes = robot.forward_kinematics(s)
    for k, name in enumerate("xyz"):
        polynomial = robot.eliminant(s, name)
        assert polynomial.degree() == modes.finite == 40
        middles = pose.act(modes.T[: modes.count], robot.platform.mean(axis=0))[:, k]
        # Zeros of such a polynomial shake with its last digits: what is asked is that it vanishes but for these.
        t = polynomial.mapparms()[0] + polynomial.mapparms()[1] * middles
        largest = np.abs(polynomial.coef) @ np.abs(t) ** np.arange(41)[:, None]
        assert (np.abs(polynomial(middles)) < 1e-12 * largest).all()
        between = (middles[1:] + middles[:-1]) / 2
        assert (np.abs(polynomial(between)) > 1e3 * np.abs(polynomial(middles)).max()).all()
        zeros = np.sort_complex(polynomial.roots())
        assert np.abs(zeros[:, None] - middles).min(axis=0).max() < 1e-2
    with pytest.raises(InputError, match="coordinate"):
        robot.eliminant(s, "w")


@pytest.mark.capability("08-26")
def test_a_search_that_starts_at_a_singular_pose_says_so():
    base = random_platform(np.random.default_rng(9)).base
    similar = StewartPlatform(base, 0.5 * base)  # singular wherever it is not turned
    found = similar.forward_near(
        similar.lengths(pose.exp([0.3, 0.2, 0.1, 0.2, 0.1, 1.0])), pose.from_translation([0, 0, 1.0])
    )
    assert found.status is ForwardStatus.SINGULAR
    far = random_platform(np.random.default_rng(4)).forward_near([100, 1, 1, 1, 1, 1], np.eye(4))
    assert far.status is ForwardStatus.NOT_FOUND


def test_lengths_that_cannot_be_are_said_not_to_be_found():
    robot = random_platform(np.random.default_rng(4))
    found = robot.forward_near([100, 1, 1, 1, 1, 1], np.eye(4))
    assert not found
    assert found.status in (ForwardStatus.NOT_FOUND, ForwardStatus.SINGULAR)
    assert found.error > 1
    assert "no pose" in found.explain("en") or "singular" in found.explain("en")
    assert found.to_dict()["status"] == found.status.name.lower()


def test_wrong_input_is_refused():
    robot = random_platform(np.random.default_rng(5))
    with pytest.raises(InputError, match="lengths"):
        robot.forward_near([np.nan] * 6, np.eye(4))
    with pytest.raises(InputError, match="lengths"):
        robot.forward_near([1.0] * 5, np.eye(4))
    with pytest.raises(InputError, match="T"):
        robot.lengths(2 * np.eye(4))
    with pytest.raises(InputError, match="frame"):
        robot.jacobian(np.eye(4), "tip")
    with pytest.raises(InputError, match="leg 1"):
        StewartPlatform(robot.base, robot.base).jacobian(np.eye(4))
    with pytest.raises(InputError, match="base"):
        StewartPlatform(np.zeros((5, 3)), np.zeros((6, 3)))
