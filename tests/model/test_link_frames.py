"""Frames {0} to {n} of a table on the links of a moving arm, and the Jacobian that they give."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.geometry import twist
from mafsil.model.dh_frames import frame_poses
from mafsil.model.dh_from_axes import dh_from_mechanism

ARMS = ("puma560", "ur5e", "stanford_arm", "scara_rrrp")


@pytest.mark.capability("05-92")
@pytest.mark.parametrize("name", ARMS)
def test_every_frame_of_the_table_moves_with_its_link(name):
    """T_0i is fixed to link i: its pose seen from the compiled link does not depend on q; T_jk = T_0j^-1 T_0k."""
    robot = mf.load(name)
    table = dh_from_mechanism(robot.mechanism)
    rng = np.random.default_rng(3)
    links = [robot.mechanism.link_names.index(joint.child) for joint in robot.mechanism.joints if joint.moves]
    seen = []
    for q in rng.uniform(-1, 1, (4, robot.n)):
        poses, compiled = frame_poses(table, q), robot.link_poses(q)
        seen.append([np.linalg.inv(compiled[link]) @ T for link, T in zip(links, poses[1:], strict=True)])
        between = np.linalg.inv(poses[1]) @ poses[3]
        product = table.rows[1].transform(table.convention, q[1]) @ table.rows[2].transform(table.convention, q[2])
        np.testing.assert_allclose(between, product, atol=1e-12)
        np.testing.assert_allclose(poses[-1] @ table.tool, robot.forward_kinematics(q), atol=1e-9)
    np.testing.assert_allclose(np.ptp(seen, axis=0), 0.0, atol=1e-9)


@pytest.mark.capability("05-93")
@pytest.mark.parametrize("name", ARMS)
def test_the_jacobian_from_link_frames(name):
    """Column i is Ad(T_0i) A_i with A_i the joint's constant screw in {i}: (z_i, o_i x z_i), or (0, z_i) of a slide."""
    robot = mf.load(name)
    table = dh_from_mechanism(robot.mechanism, "modified")
    q = np.random.default_rng(5).uniform(-1, 1, robot.n)
    poses = frame_poses(table, q)[1:]
    columns = []
    for row, T in zip(table.rows, poses, strict=True):
        A = np.eye(6)[2 if row.kind == "R" else 5]
        columns.append(twist.transform(T, A))
        z, o = T[:3, 2], T[:3, 3]
        direct = np.concatenate([z, np.cross(o, z)] if row.kind == "R" else [np.zeros(3), z])
        np.testing.assert_allclose(columns[-1], direct, atol=1e-12)
    np.testing.assert_allclose(np.stack(columns, axis=1), robot.jacobian_space(q), atol=1e-9)
