"""What limits a cycle, and moves in the shortest time: along paths and lines, with limited jerk, through points."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import mafsil as mf
from mafsil.job.language.reading import parse_job
from mafsil.job.planning.equipment import Equipment
from mafsil.job.planning.limiting import DECIDES, MORE, labels_of, limits_of_cycle, most_used, name_limit, would_save
from mafsil.job.planning.move_planner import plan_moves
from mafsil.job.planning.planned_remarks import driving_limits
from mafsil.messages.quantities import quantity
from mafsil.trajectory import check
from tests.job.test_job_planning import PANDA, SLOW, VIA, complaint, planned, refused

JOB = """
robot = "panda"
[limits]
velocity = 2.0
jerk = 80
tip_speed = {tip_speed}
tip_acceleration = {tip_acceleration}
[start]
joints = [0, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6]
[[move]]
joints = [0.6, 0.1, 0.1, -1.5, 0.3, 1.9, 0.2]
[[move]]
joints = [-0.3, 0.4, 0.2, -1.7, 0.2, 2.0, 0.3]
profile = "time_optimal"
[[move]]
pose = {{ position = [0.5, 0.1, 0.5] }}
path = "line"
profile = "time_optimal"
[[move]]
pose = {{ position = [0.45, -0.1, 0.4] }}
path = "line"
[[move]]
joints = [0, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6]
profile = "jerk_limited"
[[move]]
pause = 0.2
"""
BOUNDS = {"tip_speed": 0.25, "tip_acceleration": 1.0}
TEXT = JOB.format(**BOUNDS)


@pytest.fixture(scope="module")
def job():
    robot, found = planned(TEXT)
    return robot, found, limits_of_cycle(found)


def cycle_with(text=TEXT, robot=None):
    """Of the job, planned again; with another robot if one is given."""
    if robot is None:
        _, again = planned(text)
    else:
        job = parse_job(text)
        again = plan_moves(job, (Equipment(None, job.tool, robot, np.eye(4), np.eye(4)),), text=text)
    assert again.legs
    return again.duration


@pytest.mark.capability("11-47")
def test_more_of_each_limit_saves_what_planning_the_job_again_saves(job):
    robot, found, limits = job
    assert {one.quantity for one in limits} >= {"velocity", "acceleration", "tip_speed"}
    assert all(one.saved <= earlier.saved for earlier, one in pairwise(limits))
    for one in limits:
        if one.joint < 0 and one.quantity in BOUNDS:
            more = JOB.format(**BOUNDS | {one.quantity: BOUNDS[one.quantity] * (1 + MORE)})
            duration = cycle_with(more)
        elif one.quantity in ("velocity", "acceleration") and np.isfinite(getattr(robot.limits, one.quantity)).all():
            values = np.array(getattr(robot.limits, one.quantity))
            values[one.joint] *= 1 + MORE
            joints = iter(range(robot.n))
            changed = tuple(
                replace(each, limits=replace(each.limits, **{one.quantity: float(values[next(joints)])}))
                if each.moves
                else each
                for each in robot.mechanism.joints
            )
            faster = mf.Robot(replace(robot.mechanism, joints=changed))
            duration = cycle_with(robot=faster)
        else:
            continue
        assert found.duration - duration == pytest.approx(one.saved, abs=1e-6 * found.duration)


@pytest.mark.capability("11-47")
def test_where_a_limit_decides_the_motion_uses_it_up(job):
    robot, found, limits = job
    t = np.linspace(0.0, found.duration, 4001)
    values, labels = most_used(found, t)
    assert labels[-1] == ("others", -1)
    assert set(labels[:-1]) <= set(labels_of(robot.n))
    assert np.nanmax(values) <= 1.0 + 1e-3
    begin, end = found.starts[1:3]
    inside = (t > begin) & (t < end)
    used = np.nanmax(values[inside], axis=1)
    assert np.median(used) > 0.999, "at every moment of a move in the shortest time some limit is used up"
    for one in limits:
        if one.deciding > 0.05 * found.duration:
            column = values[:, labels.index((one.quantity, one.joint))]
            share = np.count_nonzero(column >= DECIDES) / len(t)
            assert share * found.duration == pytest.approx(one.deciding, rel=0.1)


def test_a_pause_has_no_limits_and_a_given_duration_saves_nothing():
    slow = 'robot = "panda"\n[[move]]\njoints = [0.3, 0, 0, -1.5, 0, 1.5, 0]\nduration = 20\n[[move]]\npause = 1\n'
    _, found = planned(slow)
    assert limits_of_cycle(found) == ()
    assert found.legs[1].timing is None


def test_the_most_precious_limit_is_among_the_findings(job):
    robot, found, limits = job
    (remark,) = would_save(robot, limits, found.duration)
    assert remark.details["saved"] == quantity(limits[0].saved, "s")
    best = name_limit(robot, limits[0].quantity, limits[0].joint)
    assert best.explain(language="en") in remark.sentence("en")
    assert remark.sentence("ar") != remark.sentence("en")
    assert would_save(robot, limits, 1e3 * limits[0].saved) == would_save(robot, (), 1.0) == []


POINTS = "joints = [0.3, 0.4, 0.1, -1.2, 0.3, 1.9, 0.2]\n"
THROUGH = POINTS + "via = [[0.2, 0.2, 0.3, -2.0, 0.2, 1.5, 0.5], [-0.3, 0.5, 0.2, -1.7, 0.2, 2.0, 0.3]]\n"
LINE = 'pose = { position = [0.5, 0.1, 0.5] }\npath = "line"\n'


def leg_of(text):
    robot, plan = planned(text)
    return robot, plan, plan.legs[0].trajectory


@pytest.mark.parametrize("goal", [POINTS, THROUGH, LINE])
def test_the_shortest_time_keeps_all_limits_and_beats_every_law(goal):
    robot, plan, motion = leg_of(PANDA + f'[[move]]\n{goal}profile = "time_optimal"\n')
    limits, _ = driving_limits(parse_job(PANDA + f"[[move]]\n{goal}"), robot)
    assert check(motion, limits, tolerance=1e-6)
    t = np.linspace(0.0, motion.duration, 20001)
    u = motion.at(t)
    used = np.maximum((np.abs(u.v) / limits.velocity).max(axis=1), (np.abs(u.a) / limits.acceleration).max(axis=1))
    tip = robot.forward_kinematics(u.u)[:, :3, 3]
    speed = np.linalg.norm(np.gradient(tip, t, axis=0), axis=1)
    if goal is LINE:
        assert speed.max() <= 0.25 * (1 + 1e-4)
    else:
        assert np.median(used) > 0.999, "at every moment some limit decides"
    laws = [None] if goal is THROUGH else ["quintic", "trapezoid", "double_s"]
    for law in laws:
        profile = "" if law is None else f'profile = "{law}"\n'
        assert motion.duration < leg_of(PANDA + f"[[move]]\n{goal}{profile}")[2].duration * (1 + 1e-7)
    said = [remark for remark in plan.remarks if remark.key == "job.decided_by"]
    assert len(said) == 1
    assert "%" in said[0].sentence("en")
    assert said[0].sentence("ar") != said[0].sentence("en")


def test_a_nearly_singular_line_is_as_quick_as_it_can_be():
    """A smooth law along the same line takes up to twice as long; TOPP-RA, on a grid, 1.29 s."""
    robot, _, motion = leg_of(SLOW + 'profile = "time_optimal"\n')
    assert 1.2 < motion.duration < 1.29
    limits, _ = driving_limits(parse_job(SLOW), robot)
    assert check(motion, limits, tolerance=1e-6)


@pytest.mark.parametrize("goal", [POINTS, THROUGH, LINE])
def test_limited_jerk_is_limited(goal):
    text = PANDA + f'[limits]\njerk = 60\n[[move]]\n{goal}profile = "jerk_limited"\n'
    robot, _, motion = leg_of(text)
    limits, _ = driving_limits(parse_job(text), robot)
    assert np.isfinite(limits.jerk).all()
    assert check(motion, limits, tolerance=1e-6)
    if goal is not THROUGH:
        assert motion.duration > leg_of(PANDA + f'[[move]]\n{goal}profile = "time_optimal"\n')[2].duration
    end = motion.at(motion.duration)
    if goal is LINE:
        np.testing.assert_allclose(robot.forward_kinematics(end.u)[:3, 3], [0.5, 0.1, 0.5], atol=1e-6)
    else:
        np.testing.assert_allclose(end.u, [0.3, 0.4, 0.1, -1.2, 0.3, 1.9, 0.2], atol=1e-9)
    np.testing.assert_allclose(motion.at([0.0, motion.duration]).v, 0.0, atol=1e-9)


@pytest.mark.parametrize(
    "move",
    [POINTS + 'profile = "time_optimal"\n', POINTS + 'profile = "jerk_limited"\n', LINE + 'profile = "time_optimal"\n'],
)
def test_a_duration_is_kept_or_the_shortest_is_said(move):
    shortest = leg_of(PANDA + f"[[move]]\n{move}")[2].duration
    _, plan, slow = leg_of(PANDA + f"[[move]]\n{move}duration = {2 * shortest}\n")
    assert slow.duration == pytest.approx(2 * shortest)
    assert not [remark for remark in plan.remarks if remark.key in ("job.decided_by", "job.slow_line_velocity")]
    said = float(str(refused(PANDA + f"[[move]]\n{move}duration = {shortest / 2}\n").details["shortest"]))
    assert shortest <= said <= shortest + 1e-3


def test_profiles_that_do_not_fit_are_refused_with_what_does():
    fault = complaint(PANDA + f'[[move]]\n{VIA}profile = "cubic"\n')
    assert fault.key == "job.via_profile"
    assert "time_optimal" in fault.message("en")


def test_points_that_are_all_one_are_a_rest():
    text = PANDA + '[[move]]\njoints = [0, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6]\nprofile = "time_optimal"\n'
    motion = leg_of(text)[2]
    np.testing.assert_array_equal(motion.at(motion.duration).u, [0, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6])


@pytest.mark.parametrize("robot", ["panda", "ur5e", "cobra600"])
@pytest.mark.parametrize("kind", ["computed_torque", "pd_gravity", "pid"])
def test_the_default_is_the_shortest_within_all_limits_unless_the_law_lags(robot, kind):
    """Jerk counts where the description has it; a straight line of the joints stays one."""
    arm = mf.load(robot)
    middle = np.clip(0.5, arm.limits.lower + 0.3, arm.limits.upper - 0.9)
    middle = np.where(arm.mechanism.angular, middle, np.clip(0.05, arm.limits.lower, arm.limits.upper))
    goal = middle + 0.1 * np.arange(1, arm.n + 1) * np.where(arm.mechanism.angular, 1.0, 0.1)
    head = f'robot = "{robot}"\n[controller]\nkind = "{kind}"\n[collision]\nself_collision = false\n'
    text = head + f"[start]\njoints = {middle.tolist()}\n[[move]]\njoints = {goal.tolist()}\n"

    def leg(more):
        return leg_of(text + more)[2]

    default, optimal, quintic = leg(""), leg('profile = "time_optimal"\n'), leg('profile = "quintic"\n')
    if kind != "computed_torque":
        assert default.duration == quintic.duration
        return
    assert optimal.duration * (1 - 1e-6) <= default.duration < 1.03 * optimal.duration < quintic.duration
    t = np.linspace(0.0, default.duration, 301)
    share = (default.at(t).u - middle) / (goal - middle)
    assert np.ptp(share, axis=1).max() < 1e-9
    if np.isfinite(arm.limits.jerk).all():
        assert (np.abs(default.jerk(t)) <= 0.7 * arm.limits.jerk * (1 + 1e-6)).all()
    # A duration that a quintic suits makes it one; a shorter one that is possible is kept.
    assert np.abs(leg(f"duration = {2 * quintic.duration}\n").at(0.0).a).max() < 1e-9
    short = 0.5 * (default.duration + quintic.duration)
    assert leg(f"duration = {short}\n").duration == pytest.approx(short)
