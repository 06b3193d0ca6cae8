"""Intervals of the free parameter: against dense sampling, and as the proof of what inverse kinematics says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.ik import inverse_kinematics, redundancy
from mafsil.ik.result import IKStatus
from mafsil.model.dh_from_axes import screws

TURN = 2 * np.pi
X, Y, Z = np.eye(3)


def limited(robot, low, high):
    """The robot with other joint limits."""
    ends = iter(zip(low, high, strict=True))
    joints = []
    for joint in robot.mechanism.joints:
        if joint.moves:
            lower, upper = next(ends)
            joint = replace(joint, limits=replace(joint.limits, lower=float(lower), upper=float(upper)))
        joints.append(joint)
    return mf.Robot(replace(robot.mechanism, joints=tuple(joints)))


def of_lines(axes, places, tip, low, high):
    """An arm of turning joints."""
    home = np.eye(4)
    home[:3, 3] = tip
    rows = [np.concatenate([w, np.cross(r, w)]) for w, r in zip(axes, places, strict=True)]
    return limited(mf.Robot.from_screws(np.array(rows), home), np.radians(low), np.radians(high))


def offset_shoulder():
    """Seven turning joints, the second axis beside the first, a spherical wrist, narrow elbow: as Motoman SIA arms."""
    places = [0 * Z, 0.15 * X + 0.3 * Z, 0.15 * X, 0.15 * X + 0.75 * Z, 0.15 * X, 0.15 * X + 1.2 * Z, 0.15 * X]
    low, high = [-180, -60, -170, -35, -180, -125, -180], [180, 125, 170, 215, 180, 125, 180]
    return of_lines([Z, Y, Z, Y, Z, Y, Z], places, 0.15 * X + 1.4 * Z, low, high)


def no_shape():
    """Seven turning joints of which none leaves a closed form: as Kinova Gen3."""
    sides = [0.0, 0.005, 0.012, 0.01, 0.02, 0.02, 0.03]
    heights = [0.0, 0.28, 0.5, 0.7, 0.9, 1.0, 1.1]
    places = [a * Y + b * Z for a, b in zip(sides, heights, strict=True)]
    most = np.array([60, 45, 60, 50, 60, 40, 60])
    return of_lines([Z, Y, Z, Y, Z, Y, Z], places, 0.03 * Y + 1.2 * Z, 10 - most, 10 + most)


def on_rail(name):
    """An arm that a slide carries sideways."""
    S, _, home = screws(mf.load(name).mechanism)
    rows = np.concatenate([[[0, 0, 0, 0, 1, 0]], S])
    return limited(mf.Robot.from_screws(rows, home), [-1.0] + [-2.5] * 6, [1.0] + [2.5] * 6)


ARMS = {
    "iiwa7": lambda: mf.load("iiwa7"),
    "fr3": lambda: mf.load("fr3"),
    "panda": lambda: mf.load("panda"),
    "offset shoulder": offset_shoulder,
    "ur on rail": lambda: on_rail("ur5e"),
    "puma on rail": lambda: on_rail("puma560"),
}


def configurations(robot, count, seed):
    return np.random.default_rng(seed).uniform(robot.limits.lower, robot.limits.upper, (count, robot.n))


def covered(values, families, margin, turn):
    """Which values lie in one of some intervals, wider by a margin on either side."""
    inside = np.zeros(len(values), dtype=bool)
    for one in families:
        for shift in (-turn, 0.0, turn):
            inside |= (values + shift >= one.low - margin) & (values + shift <= one.high + margin)
    return inside


@pytest.mark.capability("07-45", "07-53")
@pytest.mark.parametrize("name", ARMS)
def test_dense_sampling_finds_nothing_outside_and_nothing_wrong_inside(name):
    robot = ARMS[name]()
    form = redundancy(robot)
    around = form.angle_form is not None
    ends = (-np.pi, np.pi) if around else (robot.limits.lower[form.locked], robot.limits.upper[form.locked])
    values = np.linspace(*ends, 2001)
    seen = 0
    for T in robot.forward_kinematics(configurations(robot, 12, 9)):
        families = form.families(T)
        within = form.solve(T, values).within
        assert all(one.certain for one in families)
        seen += len(families)
        for branch in range(within.shape[1]):
            mine = [one for one in families if one.branch == branch]
            turn = TURN if around else 0.0
            assert not (within[:, branch] & ~covered(values, mine, 2e-9, turn)).any()
            assert not (covered(values, mine, -2e-9, turn) & ~within[:, branch]).any()
    assert seen > 12


@pytest.mark.capability("07-45")
def test_an_interval_of_an_iiwa_holds_no_posture_beyond_the_limits():
    robot = mf.load("iiwa7")
    form = redundancy(robot)
    q = configurations(robot, 115, 9)[-1]
    families = form.families(robot.forward_kinematics(q))
    assert all(np.abs(f.low - 1.69050216) > 1e-6 or f.high < 1.7687883624819 for f in families if f.branch == 0)
    for one in families:
        members = np.array([one.at(v) for v in np.linspace(one.low, one.high, 201)])
        assert (members >= robot.limits.lower - 1e-9).all()
        assert (members <= robot.limits.upper + 1e-9).all()


@pytest.mark.capability("07-45", "07-1")
def test_a_posture_in_a_narrow_interval_is_not_answered_no():
    robot = mf.load("iiwa7")
    q = np.array([-1.6189, -1.5712, -2.7711, 0.014, -2.2364, -1.3559, 2.202])
    answer = inverse_kinematics(robot, robot.forward_kinematics(q))
    assert answer.within.any()
    # An elbow that is almost straight: the locked joint has 3e-3 rad to choose from.
    robot = offset_shoulder()
    q = configurations(robot, 6, 5)[5]
    T = robot.forward_kinematics(q)
    widths = [one.high - one.low for one in redundancy(robot).families(T)]
    assert max(widths) < 3e-3
    answer = inverse_kinematics(robot, T)
    assert answer.within.any()
    assert np.abs(robot.forward_kinematics(answer.q) - T).max() < 1e-9


@pytest.mark.capability("07-45", "07-3")
def test_no_interval_is_the_proof_of_beyond_limits_and_none_without_limits_of_out_of_reach():
    whole = mf.load("fr3")
    q = np.array([0.4, 0.9, -0.3, -1.5, 0.5, 2.0, 0.6])
    T = whole.forward_kinematics(q)
    answer = inverse_kinematics(whole, T)
    elbow = sorted({round(float(x), 6) for x in answer.q[:, 3]})
    narrow = limited(whole, [*whole.limits.lower[:3], max(elbow) + 0.9, *whole.limits.lower[4:]], whole.limits.upper)
    assert redundancy(narrow).families(T) == ()
    answer = inverse_kinematics(narrow, T)
    assert answer.status is IKStatus.BEYOND_LIMITS
    assert len(answer.q)
    T = T.copy()
    T[:3, 3] = [0.75, 0.0, 0.9]
    assert inverse_kinematics(whole, T).status is IKStatus.OUT_OF_REACH


@pytest.mark.capability("07-45")
@pytest.mark.parametrize("name", ["iiwa7", "offset shoulder", "ur on rail"])
def test_every_reachable_pose_of_a_batch_is_reached_within_the_limits_near_the_preferred_configuration(name):
    robot = ARMS[name]()
    T = robot.forward_kinematics(configurations(robot, 400, 11))
    many = inverse_kinematics(robot, T)
    assert many.solved.all()
    errors = np.abs(robot.forward_kinematics(many.q) - T[:, None]).max(axis=(2, 3))
    assert errors[many.valid].max() < 1e-9
    inside = ((many.q >= robot.limits.lower - 1e-9) & (many.q <= robot.limits.upper + 1e-9)).all(axis=-1)
    assert (inside[many.within]).all()
    for k in range(0, 400, 40):
        assert many[k].within.any()


@pytest.mark.capability("07-45")
def test_families_carry_the_intervals_of_the_held_joint():
    robot = mf.load("fr3")
    q = np.array([0.1, 0.5, 0.2, -1.8, 0.3, 1.9, 0.4])
    T = robot.forward_kinematics(q)
    answer = inverse_kinematics(robot, T, q0=q)
    mine = [f for f in answer.families if f.joint == "joint7" and np.abs(answer.q[f.solution] - q).max() < 1e-9]
    assert len(mine) == 1
    assert any(low <= q[6] <= high for low, high in mine[0].intervals)
    for low, high in mine[0].intervals:
        for value in np.linspace(low, high, 9):
            member = mine[0].at(value)
            assert np.abs(robot.forward_kinematics(member) - T).max() < 1e-8
    assert any(not f.intervals for f in answer.families)


@pytest.mark.capability("07-45", "07-4")
def test_an_arm_on_a_rail_counts_its_postures_by_a_joint():
    robot = on_rail("puma560")
    q = np.array([0.3, 0.2, -0.4, 0.5, 0.6, -0.7, 0.8])
    T = robot.forward_kinematics(q)
    form = redundancy(robot)
    answer = inverse_kinematics(robot, T, free={form.parameter: float(form.value(q))})
    assert np.abs(answer.nearest(q) - q).max() < 1e-9
    rail = redundancy(robot, robot.joint_names[0])
    assert rail.parameter == robot.joint_names[0]
    families = rail.families(T)
    assert any(one.low <= 0.3 <= one.high and np.abs(one.at(0.3) - q).max() < 1e-9 for one in families)


@pytest.mark.capability("07-45", "07-44")
def test_without_a_closed_form_postures_at_limits_lead_to_those_within():
    robot = no_shape()
    T = robot.forward_kinematics(configurations(robot, 4, 5))
    many = inverse_kinematics(robot, T)
    assert many.solved.all()
    assert inverse_kinematics(robot, T[3]).within.any()
