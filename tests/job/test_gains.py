"""What more of a limit would save is said of moves in the shortest time, and it is so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.job.description import Move
from mafsil.job.joint_motion import joint_motion
from mafsil.job.planned_remarks import decided_by

Q = [np.array([0.4, -0.3, 0.1, -1.8, 0.1, 1.7, 0.6]), np.array([-0.4, 0.2, 0.5, -1.2, -0.4, 1.2, 0.1])]


def test_one_per_cent_more_saves_what_is_said():
    robot = mf.load("panda")
    limits = replace(robot.limits, velocity=robot.limits.velocity * 0.5, acceleration=np.full(7, 5.0))
    limits = replace(limits, jerk=np.full(7, np.inf))
    move = Move(joints=tuple(Q[1]), profile="time_optimal")
    planned = joint_motion(robot, Q, move, limits, "move")
    (share, seconds), *_ = planned.binding.gains()
    more = np.array(getattr(limits, share.quantity))
    more[share.joint] *= 1.01
    faster = joint_motion(robot, Q, move, replace(limits, **{share.quantity: more}), "move")
    saved = planned.trajectory.duration - faster.trajectory.duration
    assert saved == pytest.approx(seconds, rel=0.05)
    said = [remark.key for remark in decided_by(robot, planned.binding, "move")]
    assert said == ["job.decided_by", "job.would_gain"]
    remark = decided_by(robot, planned.binding, "move")[1]
    assert robot.joint_names[share.joint] in remark.sentence("en")
    assert remark.sentence("ar") != remark.sentence("en")
    slow = joint_motion(robot, Q, Move(joints=tuple(Q[1]), profile="time_optimal", duration=9.0), limits, "move")
    assert decided_by(robot, slow.binding, "move") == []
