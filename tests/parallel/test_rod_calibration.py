"""Calibration: planted errors of Deltas, hexapods and arms are found within three sigma, held-out rows at the noise."""

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil import InputError, MafsilError
from mafsil.geometry import pose
from mafsil.identification import Measured, calibrate_arm
from mafsil.parallel.legs import LegDrive, calibrate_rods
from tests import sizes
from tests.parallel.rod_robots import ROBOTS

NOISE = 2e-5
ROWS = 40


def planted(robot, rng, tolerance=2e-3):
    """The robot with every number of its legs off by some millimetres and milliradians."""
    off = {
        name: getattr(robot, name) + tolerance * rng.normal(size=getattr(robot, name).shape)
        for name in ("rods", "base")
    }
    end = "rotating" if robot.motion.angles else "fixed"
    off[end] = getattr(robot, end) + tolerance * rng.normal(size=(robot.m, 3))
    if robot.drive is LegDrive.CRANK:
        off["arms"] = robot.arms + tolerance * rng.normal(size=robot.m)
        turned = tolerance * rng.normal(size=(robot.m, 1))
        off["zeros"] = np.cos(turned) * robot.zeros + np.sin(turned) * np.cross(robot.axes, robot.zeros)
    return replace(robot, **off)


def rows_of(robot, x, rng, spread):
    V = rng.uniform(-1, 1, (ROWS, robot.m)) * spread
    twist = np.zeros((ROWS, 6))
    twist[:, robot.motion.columns] = V
    return pose.exp(twist) @ robot.poses(x)


def noisy(T, rng):
    twist = NOISE * rng.normal(size=(len(T), 6))
    turned = T @ pose.exp(twist * [1, 1, 1, 0, 0, 0])
    turned[:, :3, 3] += twist[:, 3:]
    return turned


def differences(real, nominal, found):
    """Planted corrections in the order of the names."""
    end = "rotating" if real.motion.angles else "fixed"
    side = np.cross(nominal.axes, nominal.zeros)
    zero = np.arctan2((real.zeros * side).sum(axis=1), (real.zeros * nominal.zeros).sum(axis=1))
    values = []
    for name in found.names:
        kind, leg, *axis = name.split()
        k = int(leg) - 1
        one = {"rod": "rods", "arm": "arms", "base": "base", "end": end}
        if kind == "zero":
            values.append(zero[k])
        else:
            both = [getattr(each, one[kind])[k] for each in (real, nominal)]
            values.append((both[0] - both[1]) if not axis else (both[0] - both[1])["xyz".index(axis[0])])
    return np.array(values)


@pytest.mark.parametrize("name", ["Delta", "linear Delta", "UPS hexapod", "RUS hexapod"])
def test_planted_errors_within_three_sigma(name):
    nominal, x = ROBOTS[name]
    inside = total = 0
    for seed in range(sizes.size(3, 100)):
        rng = np.random.default_rng(seed)
        real = planted(nominal, rng)
        T = rows_of(nominal, x, rng, 0.12 if nominal.motion.angles == 0 else 0.1)
        q = nominal.inverse_kinematics(T).q[..., 0]
        there = real.forward_near(q, T).T[:, 0]
        measured = Measured(poses=noisy(there, rng), noise=NOISE, angle_noise=NOISE)
        found = calibrate_rods(nominal, q, measured)
        assert found
        assert found.held_after < 2.0 < found.held_before
        wanted = differences(real, nominal, found)
        # What the data decide, alone or in combinations, is within three sigma; the rest is left as described.
        off = np.abs(found.values - wanted)[found.decided] / found.deviations[found.decided]
        inside, total = inside + int((off < 3).sum()), total + len(off)
        known = np.eye(len(wanted)) - found.combinations @ found.combinations.T
        assert np.abs(known @ (found.values - wanted)).max() < 2e-3
    if total:
        assert inside / total > 0.98
    assert total > 0 or name in ("linear Delta",)


def test_a_delta_from_probe_heights_and_distances():
    nominal, x = ROBOTS["linear Delta"]
    rng = np.random.default_rng(5)
    real = planted(nominal, rng, 5e-4)
    T = rows_of(nominal, x, rng, 0.06)
    q = nominal.inverse_kinematics(T).q[..., 0]
    p = real.forward_near(q, T).T[:, 0, :3, 3]
    heights = Measured(heights=p[:, 2] + NOISE * rng.normal(size=ROWS), noise=NOISE)
    found = calibrate_rods(nominal, q, heights, near=T, parameters=("rods", "bases"), length_tolerance=2e-3)
    assert found
    assert found.rank < len(found.names)
    again = found.corrected.forward_near(q, T).T[:, 0, 2, 3]
    assert np.abs(again - p[:, 2]).max() < 5 * NOISE
    wire = np.array([0.3, 0.1, -0.2])
    far = np.linalg.norm(p - wire, axis=1) + NOISE * rng.normal(size=ROWS)
    found = calibrate_rods(nominal, q, Measured(distances=far, center=wire, noise=NOISE), parameters=("rods", "bases"))
    assert found
    assert found.held_after < 3.0
    assert "combinations" in found.explain("en")


def test_a_serial_arm_from_poses_and_points():
    arm = mf.load("ur5e").with_tool([0.05, 0.03, 0.1])
    rng = np.random.default_rng(2)
    q = rng.uniform(-2, 2, (60, 6))
    shift = 1e-3 * rng.normal(size=(6, 6))
    moved = iter(pose.exp(shift))
    joints = tuple(replace(j, T_pj=j.T_pj @ next(moved)) if j.moves else j for j in arm.mechanism.joints)
    real = mf.Robot(replace(arm.mechanism, joints=joints))
    there = np.asarray(real.forward_kinematics(q))
    found = calibrate_arm(arm, q, Measured(poses=noisy(there, rng), noise=NOISE, angle_noise=NOISE))
    assert found
    assert found.held_after < 2.0
    # 6R: four for each revolute joint and six of the tool; the other parameters are combinations of these.
    assert found.rank == 4 * 6 + 6
    again = np.asarray(found.corrected.forward_kinematics(q))
    assert np.abs(again - there).max() < 10 * NOISE
    points = Measured(points=there[:, :3, 3] + NOISE * rng.normal(size=(60, 3)), noise=NOISE)
    by_points = calibrate_arm(arm, q, points)
    assert by_points
    assert by_points.rank == 4 * 6 + 3


def test_wrong_input_is_refused():
    robot, x = ROBOTS["Delta"]
    with pytest.raises(InputError, match="give one of"):
        Measured()
    with pytest.raises(InputError, match="give one of"):
        Measured(points=np.zeros((3, 3)), heights=np.zeros(3))
    with pytest.raises(InputError):
        Measured(points=np.zeros((3, 3)), noise=-1.0)
    q = np.tile(robot.branch(x), (12, 1))
    with pytest.raises(InputError, match="parameters"):
        calibrate_rods(robot, q, Measured(heights=np.zeros(12)), parameters=("screws",))
    with pytest.raises(InputError, match="q"):
        calibrate_rods(robot, q[:5], Measured(heights=np.zeros(12)))
    with pytest.raises(MafsilError, match="too few"):
        calibrate_rods(robot, q[:3], Measured(points=np.tile(x, (3, 1))))
