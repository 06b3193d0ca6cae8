"""Poses of jobs that name their configuration."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import JobError
from mafsil.job import Refusal, parse_job
from mafsil.job.solve import prepare
from tests.job.test_job_planning import planned

POSE = "position = [0.3, 0.4, 0.3], rpy = [2.5, 0.3, 0.4]"
JOB = 'robot = "ur5e"\n[[move]]\npose = {{ {pose}, branch = {{ {branch} }} }}\n'


@pytest.mark.parametrize("branch", product(("left", "right"), ("up", "down"), ("flip", "noflip")))
def test_each_branch_of_an_arm_can_be_asked_for(branch):
    words = ", ".join(f'{name} = "{value}"' for name, value in zip(("shoulder", "elbow", "wrist"), branch, strict=True))
    robot, plan = planned(JOB.format(pose=POSE, branch=words))
    leg = plan.legs[0]
    q = leg.trajectory.at(leg.trajectory.duration).u
    np.testing.assert_allclose(robot.forward_kinematics(q), leg.target, atol=1e-9)
    answer = mf.inverse_kinematics(robot, leg.target)
    near = np.abs(np.exp(1j * answer.q) - np.exp(1j * q)).max(axis=1)
    assert answer.branches[int(near.argmin())][:3] == branch
    assert near.min() < 1e-6


def test_what_is_left_out_may_be_anything():
    _, plan = planned(JOB.format(pose=POSE, branch='elbow = "down"'))
    robot = mf.load("ur5e")
    answer = mf.inverse_kinematics(robot, plan.legs[0].target)
    q, start = plan.legs[0].trajectory.at(plan.legs[0].trajectory.duration).u, plan.start
    rows = [row for row, kind in zip(answer.q, answer.branches, strict=True) if kind.elbow == "down"]
    wound = [row + 2 * np.pi * np.round((start - row) / (2 * np.pi)) for row in rows]
    assert np.abs(q - start).max() <= min(np.abs(row - start).max() for row in [*rows, *wound]) + 1e-9


def test_a_branch_that_the_arm_does_not_have_is_refused_with_those_it_has():
    text = (
        'robot = "cobra600"\n[[move]]\n'
        'pose = { position = [0.4, 0.3, 0.3], rpy = [3.141592653589793, 0, 0.5], branch = { shoulder = "left" } }\n'
    )
    found = prepare(parse_job(text), text, Path())
    assert isinstance(found, Refusal)
    assert "shoulder left" in found.explain()
    assert "down" in found.explain()
    line = JOB.format(pose=POSE, branch='elbow = "up"') + 'path = "line"\n'
    with pytest.raises(JobError, match="stays on the branch"):
        parse_job(line)
    with pytest.raises(JobError, match="elbow"):
        parse_job(JOB.format(pose=POSE, branch='elbow = "left"'))


def test_a_limit_of_an_arm_of_few_joints_is_named():
    """The pose needs joint 2 of the SCARA at 1.63 rad, beyond its range: no word of too few joints."""
    text = 'robot = "cobra600"\n[[move]]\npose = { position = [0.4, 0.1, 0.1], rpy = [3.141592653589793, 0, 0] }\n'
    refused = prepare(parse_job(text), text, Path())
    assert isinstance(refused, Refusal)
    assert "beyond the joint limits" in refused.explain("en")
    assert "joint2 at 1.63" in refused.explain("en")
