"""The ways of a tip by the error of its law: closed forms, an arm that moves so, and measures in sentences."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import TaskCoordinates, compare_pose_errors, hold_pose, task_computed_torque
from mafsil.errors import InputError
from mafsil.geometry import euler, pose, rotation
from mafsil.simulation import Plant
from mafsil.trajectory.profiles import rest

T = pose.from_rotation_translation(rotation.exp([0.3, -0.2, 0.5]), [0.4, 0.1, 0.3])
GOAL = T @ pose.exp([0.9, -0.6, 1.1, 0.2, -0.3, 0.25])
W = 8.0


@pytest.fixture(scope="module")
def ways():
    axes = ("decoupled", "body", "space", "ZYX")
    return dict(zip(axes, compare_pose_errors(T, GOAL, axes=axes, natural_frequency=W), strict=True))


@pytest.mark.capability("10-58", "10-101")
def test_the_ways_are_those_of_closed_forms(ways):
    """From rest every error shrinks to the share s = (1 + w t) exp(-w t) of itself, along a way of its own."""
    t = ways["body"].t
    s = ((1.0 + W * t) * np.exp(-W * t))[:, None]
    R, R_d, p, p_d = T[:3, :3], GOAL[:3, :3], T[:3, 3], GOAL[:3, 3]
    apart = rotation.log(R_d @ R.T)
    decoupled = pose.from_rotation_translation(rotation.exp(-s * apart) @ R_d, p_d + s * (p - p_d))
    screw = GOAL @ pose.exp(-s * pose.log(pose.inverse(T) @ GOAL))
    angles = [euler.to_euler(x, "ZYX") for x in (R, R_d)]
    by_angles = pose.from_rotation_translation(
        euler.from_euler(angles[1] + s * (angles[0] - angles[1]), "ZYX"), p_d + s * (p - p_d)
    )
    for axes, known in (("decoupled", decoupled), ("body", screw), ("space", screw), ("ZYX", by_angles)):
        np.testing.assert_allclose(ways[axes].poses, known, rtol=0, atol=2e-7)


@pytest.mark.capability("10-101")
def test_what_is_measured_of_a_way_is_what_the_way_is(ways):
    straight, screw, angles = ways["decoupled"], ways["body"], ways["ZYX"]
    whole = float(rotation.angle_between(T[:3, :3], GOAL[:3, :3]))
    for one in (straight, screw):
        assert one.off_turn < 1e-7
        assert one.turned == pytest.approx(whole, rel=1e-3)
    assert straight.off_line < 1e-8
    assert straight.length == pytest.approx(np.linalg.norm(GOAL[:3, 3] - T[:3, 3]), rel=1e-3)
    assert screw.off_line > 0.02
    assert screw.length > straight.length + 1e-3
    assert angles.off_line < 1e-8
    assert angles.off_turn > 0.05
    assert angles.turned > whole + 0.01
    # (1 + x) exp(-x) = 0.02 at x = 5.8339.
    assert straight.settling_time == pytest.approx(5.8339 / W, abs=1e-3)
    for one, language, word in ((screw, "en", "settled after"), (straight, "ar", "يستقر بعد")):
        assert word in one.explain(language)
    assert "not settled" in compare_pose_errors(T, GOAL, natural_frequency=W, duration=0.2)[0].explain("en")
    assert set(screw.to_dict()) >= {"axes", "off_line", "turned"}


@pytest.mark.parametrize("axes", ["decoupled", "body", "space"])
def test_an_arm_goes_the_way_that_is_foretold(axes):
    arm, q = mf.load("ur5e"), np.array([0.2, -1.2, 1.5, -0.6, 0.9, 0.3])
    start = arm.forward_kinematics(q)
    goal = start @ pose.exp([0.3, -0.2, 0.4, 0.05, -0.04, 0.03])
    law = task_computed_torque(
        arm, hold_pose(goal), coordinates=TaskCoordinates(axes), natural_frequency=[9.0] * 3 + [6.0] * 3
    )
    plant = Plant(arm, friction=False)
    scenario = mf.Scenario(
        robot=arm, trajectory=rest(q, 0.8), law=law, plant=plant, saturate=False, integrator="rk4", step=5e-4
    )
    run = mf.simulate(scenario)
    (way,) = compare_pose_errors(start, goal, axes=(axes,), natural_frequency=[9.0] * 3 + [6.0] * 3, duration=0.8)
    np.testing.assert_allclose(arm.forward_kinematics(run.q[::4]), way.poses, atol=1e-3)


def test_ways_that_are_none():
    (still,) = compare_pose_errors(T, T, axes=("body",))
    assert max(still.settling_time, still.length, still.turned) < 1e-10
    with pytest.raises(InputError, match="goal"):
        compare_pose_errors(T, np.eye(3))
    with pytest.raises(InputError, match="axes"):
        compare_pose_errors(T, GOAL, axes=("sideways",))
