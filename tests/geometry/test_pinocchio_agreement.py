"""Agreement with Pinocchio's exp, log and their derivatives (motions there are linear part first)."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from mafsil.geometry import pose, rotation, twist, wrench

pin = pytest.importorskip("pinocchio")
COUNT = 20_000


def swapped(V: np.ndarray) -> np.ndarray:
    return np.concatenate([V[..., 3:], V[..., :3]], axis=-1)


def test_exp_and_log_on_random_inputs():
    rng = np.random.default_rng(0)
    V = rng.standard_normal((COUNT, 6))
    V[:, :3] *= (rng.uniform(0, pi - 1e-6, COUNT) / np.linalg.norm(V[:, :3], axis=-1))[:, None]
    V[::5, :3] *= 10.0 ** rng.uniform(-9, 0, (COUNT // 5, 1))
    T = pose.exp(V)
    theirs = np.stack([pin.exp6(pin.Motion(x)).homogeneous for x in swapped(V)])
    theta = np.linalg.norm(V[:, :3], axis=-1)
    assert np.abs(T - theirs)[theta > 0.1].max() < 1e-14
    # Their translation loses up to 1e-12 to cancellation between 1e-4 and 0.1 rad; ours is held against 60 digits.
    assert np.abs(T - theirs).max() < 1e-11
    logs = swapped(np.stack([pin.log6(pin.SE3(x)).vector for x in T]))
    assert np.abs(pose.log(T) - logs).max() < 1e-8  # theirs loses digits near pi
    assert np.abs(pose.log(T) - logs)[theta < 3.0].max() < 1e-11
    R = np.stack([pin.exp3(x) for x in V[:, :3]])
    assert np.abs(rotation.exp(V[:, :3]) - R).max() < 2e-15


def test_jacobians_and_changes_of_frame():
    rng = np.random.default_rng(1)
    order = [3, 4, 5, 0, 1, 2]
    for V in rng.standard_normal((300, 6)):
        J = pin.Jexp6(pin.Motion(swapped(V)))[np.ix_(order, order)]
        assert np.abs(pose.right_jacobian(V) - J).max() < 1e-13
        assert np.abs(rotation.right_jacobian(V[:3]) - pin.Jexp3(V[:3])).max() < 1e-14
        M = pin.SE3(pose.exp(V))
        W = rng.standard_normal(6)
        assert np.abs(swapped(M.act(pin.Motion(swapped(W))).vector) - twist.transform(M.homogeneous, W)).max() < 1e-13
        force = swapped(M.actInv(pin.Force(swapped(W))).vector)
        assert np.abs(force - wrench.transform(M.homogeneous, W)).max() < 1e-13
        crossed = swapped(pin.Motion(swapped(V)).cross(pin.Motion(swapped(W))).vector)
        assert np.abs(crossed - twist.bracket(V, W)).max() < 1e-13
