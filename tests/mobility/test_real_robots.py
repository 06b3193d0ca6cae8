"""Robots as sold: their mobility is the number of their coordinates, whatever hangs on them."""

import sysconfig
import warnings
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil import mobility as mo
from mafsil.mobility.actuation import ActuationStatus
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
            with pytest.raises(mf.ModelError, match="no moving joint"):
                mf.mobility(mechanism)
            return
        found = mf.mobility(mechanism)
    assert found.count.mobility == found.instantaneous.mobility == found.mobility == mechanism.n


def test_twists_of_the_tip_are_those_of_the_jacobian():
    robot, q = mf.load("ur5e"), np.array([0.3, -1.2, 1.1, 0.2, 0.9, -0.4])
    linkage = mo.linkage_of(robot.mechanism, q)
    np.testing.assert_allclose(linkage.screws, robot.jacobian_space(q), atol=1e-12)
    end = mo.linkages.body_poses(linkage, np.full(6, 0.1))[-1] @ robot.forward_kinematics(q)
    np.testing.assert_allclose(end, robot.forward_kinematics(q + 0.1), atol=1e-12)


def gripper(ratio):
    joints = [
        mf.model.Joint("a", mf.model.JointKind.PRISMATIC, "hand", "left"),
        mf.model.Joint("b", mf.model.JointKind.PRISMATIC, "hand", "right", mimic=Mimic("a", ratio)),
    ]
    return mf.Mechanism.assemble(
        "gripper", [mf.model.Link(name) for name in ("hand", "left", "right")], joints, tip="right"
    )


def test_joints_that_follow_others_are_coupled():
    found = mf.mobility(gripper(-2.0), [0.01])
    assert (found.count.mobility, found.instantaneous.mobility, found.mobility) == (1, 1, 1)
    assert found.finite.proven
    assert found.instantaneous.rates_of("b") / found.instantaneous.rates_of("a") == pytest.approx(-2.0)
    assert found.actuation.status is ActuationStatus.FULL
    assert "- couplings" in found.count.explain("en")
    assert mf.mobility(gripper(0.0)).mobility == 1


def test_geared_five_bar():
    from mafsil.mobility import library

    free = library.five_bar()
    gears = mo.Linkage.of(free.joints, planar=True, output="rod 1", couplings=[mo.linkages.Coupling("D", "O", -1.5)])
    found = mf.mobility(gears)
    assert (found.count.mobility, found.instantaneous.mobility, found.mobility) == (1, 1, 1)
    assert found.finite.status is mo.finite.FiniteStatus.REGULAR
    curve = mo.trace_motion(gears, steps=300)
    np.testing.assert_allclose(curve.theta[:, 4], -1.5 * curve.theta[:, 0], atol=1e-9)
    assert mo.batch_mobility(gears, curve.theta).tolist() == [1] * len(curve.theta)
    locked = mo.linkages.lock_joints(gears, ["O"])
    assert len(locked.joints) == 3
    assert not mf.mobility(locked)
    assert mo.locked_mobility(gears, ["O"]) == 0
    again = mf.mobility(mo.mechanism_of(mo.Linkage.of(
        [*free.joints[:1], *free.joints[-1:]], planar=True, couplings=[mo.linkages.Coupling("D", "O", 2.0)]
    )))  # fmt: skip
    assert again.mobility == 1
    for bad in (
        mo.linkages.Coupling("D", "D", 1.0),
        mo.linkages.Coupling("D", "O", 0.0),
        mo.linkages.Coupling("D", "Q", 1.0),
    ):
        with pytest.raises(mf.ModelError):
            mo.Linkage.of(free.joints, planar=True, couplings=[bad])


def test_couplings_in_files(tmp_path):
    path = tmp_path / "gears.toml"
    text = (
        '[[joint]]\nname = "a"\nkind = "R"\nbodies = ["ground", "one"]\n'
        '[[joint]]\nname = "b"\nkind = "R"\nbodies = ["ground", "two"]\nat = [1, 0]\n'
        '[[coupling]]\nfollower = "b"\nleader = "a"\nratio = -2\n'
    )
    path.write_text(text)
    assert mf.mobility(path).mobility == 1
    for old, new in (
        ("ratio = -2", ""),
        ('leader = "a"', 'leader = "c"'),
        ("ratio = -2", 'ratio = "x"'),
        ("ratio", "rate"),
    ):
        path.write_text(text.replace(old, new))
        with pytest.raises(mf.MafsilError):
            mo.read_linkage(path)
