"""Workspaces of platforms on six legs: volumes known exactly, reasons, distances of legs."""

import numpy as np
import pytest
from scipy.optimize import minimize

from mafsil import parallel as pa
from mafsil.errors import InputError
from mafsil.geometry import pose, rotation
from mafsil.parallel.platforms.platform_workspace import segment_distance


def stewart():
    return pa.StewartPlatform.on_circles(
        2.0, 1.0, np.radians([-15, 15, 105, 135, 225, 255]), np.radians([-45, 45, 75, 165, 195, 285])
    )


def test_volume_of_a_shell_and_of_a_cone():
    point = pa.StewartPlatform(np.zeros((6, 3)), np.zeros((6, 3)))
    found = pa.platform_workspace(point, pa.PlatformLimits(0.5, 1.0), [-1, -1, -1], [1, 1, 1], 61)
    volume, error = found.volume(found.everywhere)
    exact = 4 / 3 * np.pi * (1 - 0.125)
    assert abs(volume - exact) < 0.01 * exact
    assert abs(volume - exact) < error
    cone = pa.platform_workspace(point, pa.PlatformLimits(0.5, 1.0, base_cone=0.6), [-1, -1, -1], [1, 1, 1], 61)
    volume, _ = cone.volume(cone.everywhere)
    assert volume == pytest.approx(exact * (1 - np.cos(0.6)) / 2, rel=0.03)
    assert cone.reasons["base_cone"] > 0


def test_allowed_poses_keep_their_limits_and_others_break_one():
    robot, limits = stewart(), pa.PlatformLimits(1.5, 2.6, base_cone=1.0, platform_cone=1.2, leg_radius=0.05)
    turns = np.stack([np.eye(3), rotation.rot_x(0.3), rotation.rot_z(0.5)])
    found = pa.platform_workspace(robot, limits, [-1, -1, 0.5], [1, 1, 2.5], 13, turns)
    assert found
    assert (found.everywhere <= found.somehow).all()
    x, y, z = np.meshgrid(*found.axes, indexing="ij")
    places = np.stack([x, y, z], axis=-1)
    for turn, allowed in zip(turns, found, strict=True):
        T = pose.from_rotation_translation(np.broadcast_to(turn, (*places.shape[:-1], 3, 3)), places)
        s = robot.lengths(T)
        assert s[allowed].min() >= 1.5
        assert s[allowed].max() <= 2.6
        u = robot.leg_vectors(T) / s[..., None]
        assert np.arccos(u[allowed][..., 2]).max() <= 1.0 + 1e-9
        assert np.arccos(np.clip(u[allowed] @ turn[:, 2], -1, 1)).max() <= 1.2 + 1e-9
    assert sum(found.reasons.values()) + int(found.allowed.sum()) == found.allowed.size
    assert "m^3" in found.explain("en")
    far = pa.platform_workspace(robot, limits, [9, 9, 9], [10, 10, 10], 3)
    assert not far
    assert far.reasons["long"] == 27


def test_poses_near_a_singularity_are_refused():
    robot = stewart()
    quarter = rotation.rot_z(np.pi / 2)[None]
    limits = pa.PlatformLimits(0.1, 10.0, least_measure=1e-6)
    found = pa.platform_workspace(robot, limits, [-1e-9, -1e-9, 1.4], [1e-9, 1e-9, 1.6], 3, quarter)
    assert not found
    assert found.reasons["singular"] == 27


def apart(x, p, u, q, v):
    return np.linalg.norm(p + x[0] * u - q - x[1] * v)


def test_distance_of_segments_is_the_least():
    rng = np.random.default_rng(0)
    for _ in range(40):
        p, u, q, v = rng.normal(size=(4, 3))
        best = min(
            minimize(apart, x, (p, u, q, v), bounds=[(0, 1)] * 2).fun
            for x in ([0.5, 0.5], [0, 0], [1, 1], [0, 1], [1, 0])
        )
        assert segment_distance(p, u[None], q, v[None])[0] == pytest.approx(best, abs=1e-6)
    assert segment_distance(np.zeros(3), np.eye(3)[:1], np.array([0.0, 1, 0]), np.eye(3)[:1])[0] == pytest.approx(1)


def test_wrong_limits_are_refused():
    with pytest.raises(InputError, match="shortest"):
        pa.PlatformLimits(2.0, 1.0)
    with pytest.raises(InputError, match="lower"):
        pa.platform_workspace(stewart(), pa.PlatformLimits(1.0, 2.0), [1, 1, 1], [0, 2, 2])
