"""Batches of arms without a special shape: the lists are those of one pose after another."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.geometry import pose
from mafsil.ik.refine import wound_near
from mafsil.ik.result import IKStatus
from mafsil.ik.structure import elimination


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
        IKStatus.SOLVED,
        IKStatus.NOT_A_POSE,
        IKStatus.OUT_OF_REACH,
        IKStatus.SOLVED,
    ]
    assert not batch.valid[1:3].any()
    assert np.isnan(batch.q[1]).all()
    np.testing.assert_array_equal(batch.q[0], batch.q[3])


def test_limits_count_in_proven_lists(arm):
    limits = [mf.model.Limits(-1.0, 1.0)] * 6
    moving = iter(limits)
    joints = [
        mf.model.Joint(j.name, j.kind, j.parent, j.child, T_pj=j.T_pj, axis=j.axis, limits=next(moving))
        if j.moves
        else j
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


def test_one_pose_and_a_batch_give_the_same_lists_to_the_last_digits(arm):
    """One look and the whole way agree, and lanes do not depend on their neighbours."""
    q = np.random.default_rng(8).uniform(-np.pi, np.pi, (21, 6))
    T = arm.forward_kinematics(q)
    solver = elimination(arm)
    many = solver.solve_all(T)
    assert many.complete.all()
    for i in range(len(T)):
        one = solver.solve_all(T[i])
        assert one.count == many.count[i]
        assert one.complete
        np.testing.assert_allclose(one.q, many.q[i], rtol=0, atol=1e-12)
    np.testing.assert_array_equal(solver.solve_all(T[::-1]).q[::-1], many.q)
    np.testing.assert_array_equal(solver.solve_all(T, threads=2).q, many.q)


def test_solutions_are_judged_as_the_residual_and_the_winding_say():
    from mafsil.ik.refine_loops import judge_solutions

    rng = np.random.default_rng(9)
    T = pose.exp(rng.normal(size=(40, 6)))
    off = np.concatenate([rng.normal(size=(20, 6)) * 1e-9, rng.normal(size=(20, 6)) * 1e-3])
    reached = T @ pose.exp(off)
    lower, upper = np.array([-np.inf, -1.0, -7.0, 0.0]), np.array([np.inf, 1.0, 7.0, 0.5])
    near, turning = np.array([3.0, 0.0, 6.0, 0.2]), np.array([True, True, True, False])
    given = rng.uniform(-9, 9, (40, 4))
    q, residual, within = given.copy(), np.empty(40), np.empty(40, dtype=np.bool_)
    judge_solutions(reached, T, np.arange(40), near, lower, upper, turning, q, residual, within)
    error = pose.error(reached, T)
    wanted = np.maximum(np.linalg.norm(error[:, :3], axis=1), np.linalg.norm(error[:, 3:], axis=1))
    np.testing.assert_allclose(residual, wanted, rtol=1e-2, atol=1e-15)
    np.testing.assert_allclose(q, wound_near(given, near, lower, upper, turning), rtol=0, atol=1e-14)
    np.testing.assert_array_equal(within, ((q >= lower - 1e-12) & (q <= upper + 1e-12)).all(axis=1))
    reached[0, 0, 0], reached[1, 0, 3] = np.nan, np.nan
    judge_solutions(reached, T, np.arange(40), near, lower, upper, turning, q, residual, within)
    assert (residual[:2] > 1.0).all()
