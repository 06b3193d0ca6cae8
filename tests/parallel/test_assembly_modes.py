"""Assembly modes of platforms on six legs: planted poses, counts, special and impossible platforms."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from mafsil.errors import InputError
from mafsil.geometry import pose, rotation
from mafsil.parallel import StewartPlatform, stewart_assembly_modes
from mafsil.parallel.platforms.assembly_modes import AssemblyModesStatus


def planted(seed, count):
    rng = np.random.default_rng(seed)
    a, b = rng.normal(size=(2, count, 6, 3))
    T = pose.from_rotation_translation(rotation.random(rng, count), rng.normal(size=(count, 3)))
    return a, b, T, np.linalg.norm(T[:, None, :3, 3] + b @ np.swapaxes(T[:, :3, :3], 1, 2) - a, axis=-1)


@pytest.mark.capability("08-27", "08-35")
def test_planted_poses_of_random_platforms_are_found():
    a, b, T, s = planted(1, 60)
    found = stewart_assembly_modes(a, b, s)
    assert found
    assert (found.finite == 40).all()
    assert (found.count % 2 == 0).all()
    apart = np.abs(found.T - T[:, None]).max(axis=(2, 3))
    assert np.nanmin(apart, axis=1).max() < 1e-8
    ends = np.einsum("knij,kmj->knmi", found.T[..., :3, :3], b) + found.T[..., None, :3, 3]
    error = np.linalg.norm(ends - a[:, None], axis=-1) - s[:, None]
    assert np.nanmax(np.abs(error)) < 1e-11
    assert found.error < 1e-11
    assert found[3].count == found.count[3]
    assert len(list(found)) == 60


@pytest.mark.capability("08-27")
def test_one_platform_with_many_lengths_is_the_same():
    a, b, _, _ = planted(2, 1)
    robot = StewartPlatform(10 * a[0], 10 * b[0] + [100, 0, 0])
    rng = np.random.default_rng(3)
    T = pose.from_rotation_translation(rotation.random(rng, 5), 10 * rng.normal(size=(5, 3)) - [100, 0, 0])
    s = robot.lengths(T)
    one, many = robot.forward_kinematics(s), stewart_assembly_modes(robot.base, robot.platform, s)
    np.testing.assert_array_equal(one.count, many.count)
    np.testing.assert_allclose(one.T, many.T, atol=1e-7)
    G = np.linalg.det(robot.jacobian(one.T[0][: one.count[0]]))
    np.testing.assert_array_equal(one.orientation[0, : one.count[0]], np.sign(G))


def test_lengths_without_a_real_pose():
    a, b, _, s = planted(4, 1)
    found = StewartPlatform(a[0], b[0]).forward_kinematics(s[0] * [50, 1, 1, 1, 1, 1])
    assert not found
    assert (found.status, found.count, found.finite) == (AssemblyModesStatus.NONE, 0, 40)
    assert "complex" in found.explain("en")
    assert not list(found)


def test_a_platform_that_is_singular_everywhere():
    angles = np.array([0.1, 0.9, 2.0, 3.3, 4.1, 5.5])
    found = StewartPlatform.on_circles(1.0, 0.5, angles, angles).forward_kinematics(np.full(6, 2.0))
    assert found.status is AssemblyModesStatus.NOT_ISOLATED
    assert not found


@pytest.mark.capability("08-27")
def test_a_double_pose_is_counted_twice():
    robot = StewartPlatform.on_circles(
        2.0, 1.0, np.radians([-15, 15, 105, 135, 225, 255]), np.radians([-45, 45, 75, 165, 195, 285])
    )
    T = pose.from_translation([0, 0, 1.5])
    T[:3, :3] = rotation.rot_z(np.pi / 2)
    found = robot.forward_kinematics(robot.lengths(T))
    assert found
    assert min(np.abs(each - T).max() for each in found) < 1e-6
    assert found.finite < found.expected


def test_lengths_that_are_no_numbers_are_refused():
    a, b, _, _ = planted(6, 1)
    with pytest.raises(InputError, match="lengths"):
        StewartPlatform(a[0], b[0]).forward_kinematics([np.inf] * 6)
    with pytest.raises(InputError, match="base"):
        stewart_assembly_modes(a[0][:5], b[0], np.ones(6))


@pytest.mark.capability("08-27")
@pytest.mark.parametrize(
    ("base", "platform", "expected"),
    [
        ([0, 0, 1, 1, 2, 2], [2, 0, 0, 1, 1, 2], 16),
        ([0, 1, 2, 3, 4, 5], [2, 0, 0, 1, 1, 2], 16),
        ([0, 1, 2, 3, 4, 4], [0, 1, 2, 3, 3, 4], 40),
        ([0, 0, 0, 1, 1, 2], [0, 1, 2, 3, 4, 5], 8),
    ],
    ids=["octahedral 3-3", "6-3", "5-5", "3-2-1"],
)
def test_counts_of_platforms_with_common_ends(base, platform, expected):
    """Nanua, Waldron, Murthy 1990 (16), Innocenti 1995 (40 of 5-5), trilateration thrice (8)."""
    rng = np.random.default_rng(8)
    robot = StewartPlatform(rng.normal(size=(6, 3))[base], rng.normal(size=(6, 3))[platform])
    T = pose.from_rotation_translation(rotation.random(rng), rng.normal(size=3))
    found = robot.forward_kinematics(robot.lengths(T))
    assert found.expected == found.finite == expected
    assert min(np.abs(each - T).max() for each in found) < 1e-8


def test_degenerate_platforms_and_empty_batches():
    a, b, _, _ = planted(9, 1)
    robot = StewartPlatform(a[0], b[0])
    none = robot.forward_kinematics(np.zeros((0, 6)))
    assert none.count.shape == (0,)
    assert robot.forward_near(np.zeros((0, 6)), np.eye(4)).T.shape == (0, 4, 4)
    point = StewartPlatform(np.zeros((6, 3)), np.zeros((6, 3)))
    assert point.forward_kinematics(np.ones(6)).status is AssemblyModesStatus.NOT_ISOLATED
    zero = robot.forward_kinematics(np.zeros(6))
    assert zero.finite <= 40
    assert zero.explain("en")
    huge = StewartPlatform(1e6 * a[0], 1e6 * b[0])
    T = pose.from_rotation_translation(rotation.random(3), [1e6, -2e6, 5e5])
    found = huge.forward_kinematics(huge.lengths(T))
    assert min(np.abs(each - T).max() for each in found) < 1e-2


@pytest.mark.capability("08-25", "08-27")
def test_lengths_that_no_pose_has_say_how_far_they_are_off():
    a, b, _, s = planted(3, 1)
    robot = StewartPlatform(a[0], b[0])
    found = robot.forward_kinematics(np.stack([np.full(6, 0.01), s[0]]))
    assert found.status is AssemblyModesStatus.SOME
    assert not found
    assert "1 of 2 rows" in found.explain("en")
    assert found.nearest.distance[1] == pytest.approx(0.0, abs=1e-11)
    row = found[0]
    assert row.status is AssemblyModesStatus.NONE
    np.testing.assert_allclose(robot.lengths(row.nearest.x) - 0.01, row.nearest.misfit, atol=1e-12)
    assert f"{row.nearest.distance:.4g} m away" in row.explain("en")
    # Where nothing is nearer the platform is singular, and the misfit an equilibrium of the legs.
    np.testing.assert_allclose(robot.wrench(row.nearest.x, row.nearest.misfit), 0.0, atol=1e-9)
    rng = np.random.default_rng(1)
    for _ in range(30):
        start = pose.from_rotation_translation(rotation.random(rng), rng.normal(size=3))
        fit = least_squares(lambda V, start=start: robot.lengths(start @ pose.exp(V)) - 0.01, np.zeros(6), max_nfev=60)
        assert np.sqrt(2 * fit.cost) > row.nearest.distance - 1e-6
