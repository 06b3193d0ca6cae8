"""Poses that are not isolated: movable platforms say so, multiple poses are one, counts at general lengths agree."""

import numpy as np
import pytest

from mafsil.geometry import pose, rotation
from mafsil.mobility import FourBar
from mafsil.parallel import PlanarThreeRPR, StewartPlatform
from mafsil.parallel.planar import output_angles
from mafsil.parallel.platforms.assembly_modes import AssemblyModesStatus, of_size_one
from mafsil.parallel.platforms.platform_paths import own_start

HALF_TURN = np.diag([-1.0, -1.0, 1.0])


def octahedron(seed):
    """Bricard's, symmetric about the axis z: three corners and what half a turn makes of them."""
    v = np.random.default_rng(seed).normal(size=(3, 3))
    return StewartPlatform(v[[0, 0, 1, 1, 2, 2]], (v @ HALF_TURN)[[1, 2, 0, 2, 0, 1]])


def require_movable(robot, lengths):
    found = robot.forward_kinematics(lengths)
    assert found.status is AssemblyModesStatus.MOVABLE
    assert found
    assert found.movable
    np.testing.assert_allclose(robot.lengths(found.through), lengths, atol=1e-9)
    least = np.linalg.svd(robot.jacobian(found.through), compute_uv=False)[-1]
    assert least < 1e-6
    assert "moves there with all legs locked" in found.explain("en")
    assert "none is missing" not in found.explain("en")
    assert found.explain("ar")
    assert found.to_dict()["on_set"] == found.on_set
    return found


@pytest.mark.capability("08-27")
@pytest.mark.parametrize("seed", range(6))
def test_flexible_octahedra_are_movable(seed):
    robot = octahedron(seed)
    found = require_movable(robot, robot.lengths(np.eye(4)))
    assert found.finite + found.on_set <= found.expected


@pytest.mark.capability("08-27")
def test_congruent_platforms_on_equal_parallel_legs_are_movable():
    a = np.array([[1, 0, 0], [0, 1, 0.3], [-1, 0.2, 0], [0, -1, 0.4], [0.6, 0.5, 0.9], [-0.4, 0.7, -0.5]])
    robot = StewartPlatform(a, a)
    found = require_movable(robot, robot.lengths(pose.from_translation([0.3, -0.4, 1.2])))
    assert found.count == 0


def test_a_batch_says_which_rows_move():
    robot = octahedron(1)
    T = pose.from_rotation_translation(rotation.exp([0.3, -0.2, 0.5]), [0.4, 0.1, 0.7])
    found = robot.forward_kinematics(robot.lengths(np.stack([np.eye(4), T])))
    assert found.movable.tolist() == [True, False]
    assert found[1].status is AssemblyModesStatus.ALL
    assert min(np.abs(each - T).max() for each in found[1]) < 1e-8


def test_congruent_platforms_a_little_off_claim_nothing_false():
    for seed in range(4):
        rng = np.random.default_rng(seed)
        a = rng.normal(size=(6, 3))
        robot = StewartPlatform(a, a)
        axis = rng.normal(size=3)
        T = pose.from_rotation_translation(rotation.exp(1e-3 * axis / np.linalg.norm(axis)), rng.normal(size=3))
        found = robot.forward_kinematics(robot.lengths(T))
        assert found.status is AssemblyModesStatus.ALL
        assert min(np.abs(each - T).max() for each in found) < 1e-6


def test_counts_of_congruent_platforms_agree_at_general_lengths():
    for seed in (1008, 1020, 1026, 1037):
        a = np.random.default_rng(seed).uniform(-1, 1, size=(6, 3))
        reduced = of_size_one(a, a)[0]
        assert [len(own_start(reduced, reduced, number).poses) for number in range(3)] == [24, 24, 24]


def test_geometry_that_moves_for_all_lengths_is_told():
    a = [[1, 0, 0], [0, 1, 0.3], [-1, 0.2, 0], [0, -1, 0.4], [0.6, 0.5, 0.9], [0.6, 0.5, 0.9]]
    b = [[0.5, 0.1, 0], [0.1, 0.6, 0.1], [-0.5, 0.1, 0.2], [0, -0.4, 0.3], [0.2, 0.3, 0.4], [0.2, 0.3, 0.4]]
    robot = StewartPlatform(a, b)
    found = robot.forward_kinematics(robot.lengths(pose.from_translation([0.1, 0.2, 1.5])))
    assert found.status is AssemblyModesStatus.NOT_ISOLATED
    rng = np.random.default_rng(4)
    for platform in (np.outer(rng.normal(size=6), rng.normal(size=3)), np.tile(rng.normal(size=3), (6, 1))):
        robot = StewartPlatform(rng.normal(size=(6, 3)), platform)
        lengths = robot.lengths(pose.from_translation([0.1, 0.2, 1.5]))
        assert robot.forward_kinematics(lengths).status is AssemblyModesStatus.NOT_ISOLATED


def test_a_triple_pose_counts_once():
    robot = PlanarThreeRPR([[1, 0], [4, 3], [-2, 0]], [[0, 0], [-2, 3], [-1, 1]])
    found = robot.forward_kinematics([2, np.sqrt(45), np.sqrt(5)])
    assert found.count == 4
    assert sorted(found.multiplicity.tolist()) == [1, 1, 1, 3]
    assert np.abs(found.x[found.multiplicity == 3] - [1, 2, np.pi / 2]).max() < 1e-4
    assert found.to_dict()["multiplicity"].sum() == 6


@pytest.mark.capability("08-47")
def test_angles_of_the_rocker_are_left_of_the_line_first():
    rng = np.random.default_rng(5)
    for lengths in [(2, 4, 3.5, 4.5), *rng.uniform(1, 2, size=(5, 4)).tolist()]:
        bar, theta = FourBar(*lengths), float(rng.uniform(-3, 3))
        pin = bar.lengths[0] * np.array([np.cos(theta), np.sin(theta)])
        pivot = np.array([bar.lengths[3], 0.0])
        for phi, sign in zip(np.ravel(output_angles(bar, theta).phi), (1, -1), strict=True):
            end = pivot + bar.lengths[2] * np.array([np.cos(phi), np.sin(phi)])
            line, arm = pivot - pin, end - pin
            assert sign * (line[0] * arm[1] - line[1] * arm[0]) > 0
