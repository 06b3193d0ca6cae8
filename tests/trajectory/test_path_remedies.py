"""Changes that make a path followable: each is checked anew here, and a smaller one of its kind does not do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil import Robot
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.ik import track
from mafsil.model import Limits
from mafsil.model.library.textbook import planar2r
from mafsil.trajectory import diagnose_path, follow, joined_path, line_path, spline_path, suggest_path_fixes
from mafsil.trajectory.difficulties.changed_paths import MovedBasePath, PathPart, TurnedToolPath
from mafsil.trajectory.difficulties.remedies import MendStatus
from tests.sizes import size

START = np.array([0.3, -1.2, 1.2, 0.4, 1.0, 0.2])


def line(a, b):
    T_0, T_1 = np.eye(4), np.eye(4)
    T_0[:2, 3], T_1[:2, 3] = a, b
    return line_path(T_0, T_1)


def limited(arm, **bounds):
    joints = [replace(joint, limits=bounds.get(joint.name, joint.limits)) for joint in arm.joints]
    return Robot(replace(arm, joints=tuple(joints)))


def moved_line(robot, q, way):
    T = robot.forward_kinematics(q)
    goal = T.copy()
    goal[:3, 3] += way
    return line_path(T, goal)


def followed(remedy, diagnosis):
    """Does a peer, small steps of Newton's method, get along the changed path?"""
    s = np.linspace(0.0, 1.0, 151)
    if diagnosis.task == "pose":
        return track(diagnosis.robot, remedy.path.poses(s), remedy.q_start).continuous
    return bool(follow(diagnosis.robot, remedy.path, remedy.q_start, task=diagnosis.task))


@pytest.mark.capability("11-10")
def test_the_base_is_moved_by_what_the_reach_lacks():
    """The hole in the middle has the radius 0.5, the line passes the base at 0.3."""
    diagnosis = diagnose_path(Robot(planar2r((1.0, 0.5))), line((1, 0.3), (-1, 0.3)), task="position")
    answer = suggest_path_fixes(diagnosis, kinds=["base"])
    (remedy,) = answer
    assert answer.status is MendStatus.MENDED
    assert followed(remedy, diagnosis)
    assert 0.2 <= np.linalg.norm(remedy.shift) <= 0.2 * 1.03
    np.testing.assert_allclose(remedy.shift / np.linalg.norm(remedy.shift), [0.0, -1.0, 0.0], atol=1e-12)
    assert "move the base" in answer.explain("en")


@pytest.mark.capability("11-12")
def test_the_tool_is_turned_by_what_the_last_joint_lacks():
    """The last axis of a UR5e is the tool's: a turn of the tool is a turn of that joint."""
    whole = mf.load("ur5e")
    path = moved_line(whole, START, [0.05, 0.15, -0.05])
    turns = follow(whole, path, START).value.at(np.linspace(0, 1, 301)).u[:, 5]
    limit = (turns.max() + turns.min()) / 2
    near = {
        joint.name: Limits(q - 0.5, q + 0.5)
        for joint, q in zip(whole.mechanism.coordinates[:5], START[:5], strict=True)
    }
    robot = limited(whole.mechanism, **near, wrist_3_joint=Limits(limit - 3.0, limit))
    diagnosis = diagnose_path(robot, path)
    assert not diagnosis
    answer = suggest_path_fixes(diagnosis, kinds=["tool"])
    (remedy,) = answer
    assert followed(remedy, diagnosis)
    lacking = turns.max() - limit
    assert lacking <= abs(remedy.turn) <= lacking + np.radians(0.26)
    assert not diagnose_path(robot, TurnedToolPath(path, remedy.turn * (lacking - 1e-3) / abs(remedy.turn)))
    assert f"{np.degrees(remedy.turn):.4g} degrees" in answer.explain("en")


@pytest.mark.capability("11-12")
def test_another_branch_and_a_detour_in_joints():
    robot = limited(planar2r(), joint1=Limits(-1.6, np.radians(70)))
    path = line((1, -1.2), (1, 1.2))
    below, above = diagnose_path(robot, path, task="position").q[0], None
    rows = mf.ik.inverse_kinematics(robot, path.poses(0.0), task="position").q
    for q in rows:
        diagnosis = diagnose_path(robot, path, task="position", q_start=q)
        if not diagnosis:
            above = diagnosis
    assert above is not None
    remedies = {remedy.kind: remedy for remedy in suggest_path_fixes(above, kinds=["branch", "detour"])}
    np.testing.assert_allclose(remedies["branch"].q_start, below, atol=1e-9)
    assert followed(remedies["branch"], above)
    (detour,) = remedies["detour"].detours
    way = detour.q_begin + np.linspace(0, 1, 50)[:, None] * (detour.q_end - detour.q_begin)
    assert (way >= robot.limits.lower).all()
    assert (way <= robot.limits.upper).all()
    for s, q in ((detour.begin, detour.q_begin), (detour.end, detour.q_end)):
        np.testing.assert_allclose(robot.forward_kinematics(q)[:3, 3], path.poses(s)[:3, 3], atol=1e-8)
    tip = robot.forward_kinematics(way)[:, :2, 3]
    nearest = np.stack([np.ones(50), np.clip(tip[:, 1], -1.2, 1.2)], axis=-1)
    off = np.linalg.norm(tip - nearest, axis=-1).max()
    np.testing.assert_allclose(detour.distance, off, rtol=1e-2)


@pytest.mark.capability("11-11")
def test_a_detour_around_high_rates():
    robot = limited(planar2r(), joint1=Limits(velocity=2.0), joint2=Limits(velocity=2.0))
    diagnosis = diagnose_path(robot, line((1, 0.01), (-1, 0.01)), task="position", duration=10.0)
    (remedy,) = suggest_path_fixes(diagnosis, kinds=["detour"])
    (detour,) = remedy.detours
    (fast,) = diagnosis
    assert detour.begin <= fast.where.begin
    assert detour.end >= fast.where.end
    assert len(remedy.diagnoses) == 2
    assert all(remedy.diagnoses)


@pytest.mark.capability("11-10", "11-11", "11-12")
def test_remedies_of_random_paths_hold():
    robot, rng, mended = mf.load("puma560"), np.random.default_rng(1), 0
    for _ in range(size(2, 3)):
        q = rng.uniform(-1.5, 1.5, 6)
        diagnosis = diagnose_path(robot, moved_line(robot, q, rng.uniform(-0.3, 0.3, 3)))
        for remedy in suggest_path_fixes(diagnosis):
            if remedy.kind != "detour":
                assert followed(remedy, diagnosis)
            assert all(remedy.diagnoses)
            mended += 1
    assert mended


@pytest.mark.parametrize("change", ["tool", "base", "part", "part over a corner"])
def test_changed_paths_move_as_their_twists_say(change):
    T = mf.load("ur5e").forward_kinematics(START)
    a, b = T.copy(), T.copy()
    a[:3, 3] += [0.1, 0.1, 0.0]
    b[:3, 3] += [0.0, 0.2, 0.1]
    curve = spline_path([T, a, b])
    path = {
        "tool": TurnedToolPath(curve, 0.4),
        "base": MovedBasePath(curve, np.array([0.1, 0.2, 0.3])),
        "part": PathPart(curve, 0.2, 0.7),
        "part over a corner": PathPart(joined_path([line_path(T, a), line_path(a, b)]), 0.2, 0.9),
    }[change]
    s, h = np.array([0.1, 0.33, 0.8]), 1e-5
    here, V = path.poses(s), path.twists(s)
    rate = pose.error(path.poses(s - h), path.poses(s + h)) / (2 * h)
    np.testing.assert_allclose(rate, V[0], atol=1e-7)
    slope = (path.twists(s + h)[0] - path.twists(s - h)[0]) / (2 * h)
    np.testing.assert_allclose(slope, V[1], atol=1e-5)
    assert here.shape == (3, 4, 4)
    assert path.length > 0.0
    assert path.angle >= 0.0
    assert len(path.corners) == (change == "part over a corner")
    assert path.breaks[0] == 0.0
    assert path.breaks[-1] == 1.0


def test_nothing_to_mend_and_refusals():
    diagnosis = diagnose_path(Robot(planar2r()), line((1, -0.5), (1, 0.5)), task="position")
    answer = suggest_path_fixes(diagnosis)
    assert answer
    assert answer.status is MendStatus.NOT_NEEDED
    assert len(answer) == 0
    with pytest.raises(InputError, match="kinds"):
        suggest_path_fixes(diagnosis, kinds=["paint"])
    with pytest.raises(InputError):
        suggest_path_fixes(3)
    nowhere = diagnose_path(Robot(planar2r()), line((9, -0.5), (9, 0.5)), task="position")
    answer = suggest_path_fixes(nowhere, kinds=["detour", "branch", "tool"])
    assert not answer
    assert answer.to_dict() == {"status": "not_mended", "remedies": []}
