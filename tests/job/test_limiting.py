"""What limits a cycle and what more of each limit would save: held against planning the whole job again."""

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
from mafsil.messages.quantities import quantity
from tests.job.test_job_planning import planned

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
