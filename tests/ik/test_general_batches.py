"""Batches of arms without a special shape: the lists are those of one pose after another."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.ik.answers.verdict import Verdict


@pytest.fixture(scope="module")
def arm() -> mf.Robot:
    rng = np.random.default_rng(5)
    rows = [mf.DHRow(a=a, alpha=alpha, d=d, theta=0.0) for a, alpha, d in rng.uniform(-1, 1, (6, 3)).tolist()]
    return mf.Robot.from_dh(rows, convention="modified")


@pytest.mark.capability("07-44")
def test_batches_are_the_single_answers(arm):
    q = np.random.default_rng(6).uniform(-np.pi, np.pi, (5, 8, 6))
    T = arm.forward_kinematics(q)
    batch = mf.inverse_kinematics(arm, T)
    assert batch.solved.all()
    for index in np.ndindex(5, 8):
        one = mf.inverse_kinematics(arm, T[index])
        kept = batch.valid[index]
        assert kept.sum() == len(one)
        gaps = np.abs(batch.q[index][kept][:, None] - one.q).max(axis=-1)
        assert gaps.min(axis=1).max() < 1e-8
        assert batch.within[index].sum() == one.within.sum()
        planted = np.abs((batch.q[index][kept] - q[index] + np.pi) % (2 * np.pi) - np.pi).max(axis=1)
        assert planted.min() < 1e-7


def test_rows_that_are_no_pose_or_out_of_reach_keep_their_places(arm):
    T = np.repeat(arm.forward_kinematics(np.full(6, 0.4))[None], 4, axis=0)
    T[1] = np.nan
    T[2, :3, 3] = 50.0
    batch = mf.inverse_kinematics(arm, T)
    assert [batch.status[i] for i in range(4)] == [
        Verdict.SOLVED,
        Verdict.NOT_A_POSE,
        Verdict.OUT_OF_REACH,
        Verdict.SOLVED,
    ]
    assert not batch.valid[1:3].any()
    assert np.isnan(batch.q[1]).all()
    np.testing.assert_array_equal(batch.q[0], batch.q[3])


def test_limits_count_in_proven_lists(arm):
    limits = [mf.Limits(-1.0, 1.0)] * 6
    moving = iter(limits)
    joints = [
        mf.Joint(j.name, j.kind, j.parent, j.child, T_pj=j.T_pj, axis=j.axis, limits=next(moving)) if j.moves else j
        for j in arm.mechanism.joints
    ]
    from dataclasses import replace

    narrow = mf.Robot(replace(arm.mechanism, joints=tuple(joints)))
    q = np.random.default_rng(7).uniform(-1, 1, (30, 6))
    batch = mf.inverse_kinematics(narrow, narrow.forward_kinematics(q))
    assert batch.solved.all()
    inside = (np.abs(batch.q) <= 1.0 + 1e-12).all(axis=-1)
    np.testing.assert_array_equal(batch.within, batch.valid & inside)
    assert (batch.valid & ~inside).any()
