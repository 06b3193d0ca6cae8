"""Searches for all poses and all branches of platforms on legs, against closed forms that know how many there are."""

import numpy as np
import pytest

from mafsil import parallel as pa
from mafsil.geometry import pose
from mafsil.parallel.legs.leg_configurations import LegSearchStatus


@pytest.mark.capability("08-29", "08-31", "08-35")
def test_both_poses_of_a_delta_are_found():
    robot = pa.DeltaRobot(0.4, 0.1, 0.5, 1.0)
    legs = pa.delta_legs(robot, 0.35)
    q = np.array([0.3, 0.1, -0.2])
    found = pa.legs.leg_assembly_modes(legs, q - 0.35, 200)
    assert found
    for p in robot.forward_kinematics(q):
        level = [T for T in found if np.allclose(T[:3, :3], np.eye(3), atol=1e-6)]
        assert min(np.linalg.norm(T[:3, 3] - p) for T in level) < 1e-8
    for row, T in zip(found.q, found, strict=True):
        assert np.abs(legs.closure(row)).max() < 1e-8
        np.testing.assert_allclose(legs.legs[2].pose(row[10:]), T, atol=1e-7)
    assert "may be more" in found.explain("en")


@pytest.mark.capability("08-35")
def test_all_real_modes_of_three_rps_are_found():
    change = np.array([0.1, -0.05, 0.15])
    exact = pa.ThreeRPS(1.0, 0.5).forward_kinematics(np.sqrt(1.25) + change)
    found = pa.legs.leg_assembly_modes(pa.three_rps(1.0, 0.5, 1.0), change, 300)
    for T in exact.T:
        assert min(np.linalg.norm(each[:3, 3] - T[:3, 3]) for each in found) < 1e-7
    assert found.met.sum() <= 300


@pytest.mark.capability("08-32", "08-35")
def test_branches_of_the_legs_of_a_delta():
    robot = pa.DeltaRobot(0.4, 0.1, 0.5, 1.0)
    legs = pa.delta_legs(robot, 0.35)
    p = robot.forward_kinematics([0.3, 0.1, -0.2]).x[0]
    found = pa.legs.leg_branches(legs, pose.from_translation(p), 100)
    assert found
    assert found.free == (0, 0, 0)
    assert found.count == np.prod([len(each) for each in found])
    for leg, both, rows in zip(legs.legs, robot.inverse_kinematics(p).q, found, strict=True):
        arms = np.unique((rows[:, 0] + 0.35).round(6))
        for angle in both:
            assert np.abs(np.angle(np.exp(1j * (arms - angle)))).min() < 1e-5
        for row in rows:
            np.testing.assert_allclose(leg.pose(row), pose.from_translation(p), atol=1e-7)


def test_nothing_is_found_where_nothing_is():
    legs = pa.three_rps(1.0, 0.5, 1.0)
    found = pa.legs.leg_assembly_modes(legs, [9.0, -1.0, 0.0], 40)
    assert not found
    assert found.status is LegSearchStatus.NOT_FOUND
    assert "proves nothing" in found.explain("en")
    away = pose.exp([0, 0, 0.3, 0, 0, 0]) @ pose.from_translation([0, 0, 1.0])
    assert not pa.legs.leg_branches(legs, away, 20)
    idle = pa.stewart_legs(
        pa.StewartPlatform.on_circles(2.0, 1.0, np.arange(6) * 1.0, np.arange(6) * 0.9 + 0.3),
        pose.from_translation([0, 0, 1.5]),
        "S",
    )
    assert pa.legs.leg_branches(idle, pose.from_translation([0, 0, 1.5]), 10).free == (1,) * 6
