"""Robots as sold: their mobility is the number of their coordinates, whatever hangs on them."""

import sysconfig
import warnings
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil import mobility as mo
from mafsil.model import Mimic

FOLDER = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix/share/example-robot-data/robots"
FILES = sorted(FOLDER.rglob("*.urdf"))[::6] if FOLDER.exists() else []


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_files_of_makers(path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            mechanism = mf.load(path).mechanism
        except mf.MafsilError:
            pytest.skip("not readable as it is")
        if not mechanism.n:
            with pytest.raises(mf.ModelError, match="no joint that moves"):
                mf.mobility(mechanism)
            return
        found = mf.mobility(mechanism)
    assert found.count.mobility == found.instantaneous.mobility == found.mobility == mechanism.n


def test_twists_of_the_tip_are_those_of_the_jacobian():
    robot, q = mf.load("ur5e"), np.array([0.3, -1.2, 1.1, 0.2, 0.9, -0.4])
    linkage = mo.linkage_of(robot.mechanism, q)
    np.testing.assert_allclose(linkage.screws, robot.jacobian_space(q), atol=1e-12)
    end = mo.body_poses(linkage, np.full(6, 0.1))[-1] @ robot.forward_kinematics(q)
    np.testing.assert_allclose(end, robot.forward_kinematics(q + 0.1), atol=1e-12)


def test_followers_are_said():
    joints = [
        mf.Joint("a", mf.JointKind.PRISMATIC, "hand", "left"),
        mf.Joint("b", mf.JointKind.PRISMATIC, "hand", "right", mimic=Mimic("a")),
    ]
    links = [mf.Link(name) for name in ("hand", "left", "right")]
    gripper = mf.Mechanism.assemble("gripper", links, joints, tip="left")
    with pytest.warns(mf.ModelWarning, match="joints b follow"):
        assert mf.mobility(gripper).mobility == 1
