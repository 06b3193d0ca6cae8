"""The kernels of an arm for checks against the poses of its links, and against how these change."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil.collision import Checker
from mafsil.collision.joints import CENTRE, POSE, TWIST, arm_kernels, joints_of
from mafsil.robot import load
from tests.collision.arms import arm

SLIDING = """<mujoco><worldbody><body name="a" pos="0.1 0.2 0.3" euler="20 30 40">
  <joint name="z" type="slide" axis="0.6 0 0.8" range="-1 1"/><geom type="box" size="0.1 0.05 0.02" pos="0.1 0 0"/>
  <body name="b" pos="0.2 0 0.1"><joint name="t" type="hinge" axis="0 1 0"/><geom type="sphere" size="0.07"/>
    <body name="c" pos="0 0.3 0"><geom type="capsule" size="0.03 0.1" pos="0 0 0.2"/></body>
    <body name="d" pos="0 -0.3 0" euler="0 50 0"><joint name="u" type="hinge" axis="1 0 0"/>
      <geom type="sphere" size="0.05"/></body></body></body></worldbody></mujoco>"""


@pytest.fixture(params=["hinges", "a slide and branches"])
def checker(request, tmp_path):
    if request.param == "hinges":
        return Checker(arm(tmp_path))
    path = tmp_path / "sliding.xml"
    path.write_text(SLIDING)
    return Checker(load(str(path)))


@pytest.mark.capability("11-39")
def test_kernels_say_where_bodies_are_and_how_links_move(checker):
    mechanism, bodies, rng = checker.robot.mechanism, checker.arm.bodies, np.random.default_rng(1)
    joints = joints_of(mechanism)
    kernels = arm_kernels(mechanism, joints, bodies)
    q, qd, h = checker.random_configurations(7), rng.normal(size=(7, checker.robot.n)), 1e-6
    poses = checker.robot.link_poses(q)
    after, before = checker.robot.link_poses(q + h * qd), checker.robot.link_poses(q - h * qd)
    found = kernels.in_motion.call(q, joints.factor * qd[:, joints.column])
    ends = np.cumsum([TWIST * len(joints.link), POSE * len(kernels.links), CENTRE * len(bodies)])
    assert found.shape == (7, ends[-1])
    np.testing.assert_array_equal(kernels.at_rest.call(q), found[:, ends[0] :])
    T = found[:, ends[0] : ends[1]].reshape(7, -1, 3, 4)
    np.testing.assert_allclose(T, poses[:, kernels.links, :3], atol=1e-14)
    own = poses[:, bodies[:, 0].astype(int)]
    centres = (own[..., :3, :3] @ bodies[:, 4:7, None])[..., 0] + own[..., :3, 3]
    np.testing.assert_allclose(found[:, ends[1] :].reshape(7, -1, 3), centres, atol=1e-14)
    change = (after - before)[:, joints.link] / (2 * h)
    at = poses[:, joints.link]
    omega_cross = change[..., :3, :3] @ np.swapaxes(at[..., :3, :3], -1, -2)
    omega = np.stack([omega_cross[..., 2, 1], omega_cross[..., 0, 2], omega_cross[..., 1, 0]], axis=-1)
    v = change[..., :3, 3] - np.cross(omega, at[..., :3, 3])
    twists = found[:, : ends[0]].reshape(7, -1, 6)
    np.testing.assert_allclose(twists, np.concatenate([omega, v], axis=-1), atol=1e-8)
