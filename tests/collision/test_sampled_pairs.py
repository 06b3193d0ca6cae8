"""Pairs of a robot's own bodies that are left out without a semantic description, and what is said of them."""

import sysconfig
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.collision import Checker, SkipReason, Sphere

ROBOTS = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix/share/example-robot-data/robots"


def chain(folder, *links):
    """A chain of hinges; each link is (balls along x, place of its joint, axis)."""
    parts = list[str]()
    for k, (balls, xyz, axis) in enumerate(links):
        shapes = "".join(
            f'<collision><origin xyz="{x} 0 0"/><geometry><sphere radius="{r}"/></geometry></collision>'
            for x, r in balls
        )
        parts.append(f'<link name="l{k}">{shapes}</link>')
        if k:
            parts.append(
                f'<joint name="j{k}" type="revolute"><parent link="l{k - 1}"/><child link="l{k}"/><origin xyz="{xyz}"/>'
                f'<axis xyz="{axis}"/><limit lower="-2.5" upper="2.5" effort="1" velocity="1"/></joint>'
            )
    file = folder / "chain.urdf"
    file.write_text(f'<robot name="chain">{"".join(parts)}</robot>')
    return mf.load(file)


def reasons(checker):
    return {(each.first, each.second): each.reason for each in checker.skipped}


@pytest.mark.parametrize(
    ("between", "hand", "out"), [("0 0 0", 0.07, True), ("0 0 0.01", 0.07, False), ("0 0 0", 0.03, False)]
)
def test_hinges_at_one_point_with_empty_links_between_are_one_joint(tmp_path, between, hand, out):
    """A wrist of three hinges: hand and forearm that overlap often are left out, unless an axis is elsewhere."""
    arm = [(0.0, 0.05), (0.25, 0.05)]
    robot = chain(
        tmp_path, (arm, "", ""), (arm, "0.4 0 0", "0 0 1"), ((), "0.3 0 0", "1 0 0"), ((), between, "0 1 0"),
        ([(0.1, hand)], "0 0 0", "0 0 1"),
    )  # fmt: skip
    plain = Checker(robot, samples=0)
    pair = plain.with_scene(())
    share = float(pair.in_collision(pair.random_configurations(1000)).mean())
    assert (share > 0.45) is (hand > 0.05)
    assert not plain.in_collision(plain.zero)
    assert (reasons(Checker(robot)).get(("l1", "l4")) is SkipReason.OFTEN) is out


def test_bodies_that_meet_at_zero_and_often_are_left_out_and_named(tmp_path):
    """A middle link without length: its neighbours meet unless they are bent far away."""
    robot = chain(
        tmp_path, ([(0.0, 0.1)], "", ""), ([(0.0, 0.02)], "0.1 0 0", "0 0 1"), ([(-0.05, 0.02)], "0 0 0", "0 1 0")
    )
    checker = Checker(robot)
    assert reasons(checker)["l0", "l2"] is SkipReason.OFTEN
    assert checker.free(np.zeros(2))
    assert "l0 - l2" in checker.account()
    assert "l0 - l2" in checker.account("ar")
    plain = Checker(robot, samples=0)
    assert not plain.free(np.zeros(2))
    assert "l0 hits l2" in Checker(robot, self_collision=True, samples=0).check(np.zeros(2)).explain()
    share = float(plain.in_collision(plain.random_configurations(1000)).mean())
    assert 0.4 < share < 0.95
    srdf = tmp_path / "none.srdf"
    srdf.write_text("<robot name='chain'/>")
    assert ("l0", "l2") not in reasons(Checker(robot, srdf=srdf))
    known = Checker(robot, samples=0, known_free=[[1.5, 0.0], [0.0, 0.0]])
    assert reasons(known)["l0", "l2"] is SkipReason.REST
    assert known.free(np.zeros(2))
    assert "known_free=): 1 (l0 - l2)" in known.account("en")
    assert ("l0", "l2") not in reasons(Checker(robot, samples=0, known_free=[2.4, 0.0]))
    with pytest.raises(mf.MafsilError, match="known_free"):
        Checker(robot, known_free=[0.0])


def test_a_robot_that_is_never_free_of_itself_says_what_meets(tmp_path):
    robot = chain(
        tmp_path, ([(0.0, 0.1)], "", ""), ([(0.0, 0.02)], "0.1 0 0", "0 0 1"), ([(-0.05, 0.02)], "0 0 0", "0 1 0")
    )
    checker = Checker(robot, samples=0)
    checker.samples = 100
    said = checker.account()
    assert "zero configuration is in self-collision: l0 hits l2" in said
    found = mf.plan(checker, None, np.zeros(2), np.ones(2))
    assert 'skip=[("l0", "l2")]' in found.explain()
    blocked = mf.plan(checker, [mf.collision.Obstacle(Sphere(0.5), (0, 0, 0), "ball")], np.zeros(2), np.ones(2))
    assert "skip=" not in blocked.explain()


@pytest.mark.parametrize(
    ("file", "left_out", "free"),
    [
        ("baxter_description/urdf/baxter.urdf", ("torso", "left_lower_shoulder"), True),
        ("human_description/robots/human.urdf", ("right_lowerarm", "right_hand"), True),
        ("icub_description/robots/icub.urdf", ("l_hip_1", "l_upper_leg"), False),
    ],
)
def test_real_robots_at_zero(file, left_out, free):
    """The shins of the iCub overlap by 78 mm in its description: that is said."""
    if not (ROBOTS / file).exists():
        pytest.skip("example-robot-data is not installed")
    checker = Checker(str(ROBOTS / file), samples=300)
    assert left_out in reasons(checker)
    assert bool(checker.free(checker.zero)) is free
    assert free or "l_lower_leg hits r_lower_leg by 77.7 mm" in checker.account()
    assert Checker(str(ROBOTS / file), samples=300, known_free=checker.zero).free(checker.zero)


def test_a_margin_that_the_robot_never_keeps_from_itself_is_named(tmp_path):
    """Two bodies across a link without a shape stay 10 mm apart: no start keeps 20 mm between them."""
    robot = chain(tmp_path, ([(0.0, 0.05)], "", ""), ((), "0 0 0", "0 0 1"), ([(0.0, 0.04)], "0.1 0 0", "0 0 1"))
    usual = Checker(robot, clearance=0.02)
    assert usual.always_near[("l0", "l2")] == pytest.approx(0.009)
    assert not usual.never_apart("l0", "l2")
    assert mf.plan(usual, None, np.zeros(2), np.ones(2))
    checker = Checker(robot, clearance=0.02, self_clearance=0.02)
    assert checker.never_apart("l0", "l2")
    assert not checker.with_clearance(0.005, own=0.005).never_apart("l0", "l2")
    assert not checker.never_apart("l0", "nothing")
    assert "l0 - l2" in checker.account()
    found = mf.plan(checker, None, np.zeros(2), np.ones(2))
    assert "closer than the clearance in nearly every configuration" in found.explain()
    assert 'skip=[("l0", "l2")]' in found.explain("ar")
    assert "self_clearance" in found.explain("ar")
    assert mf.plan(checker, None, np.zeros(2), np.ones(2), self_clearance=0.005)
    assert mf.plan(robot, None, np.zeros(2), np.ones(2), clearance=0.02, self_clearance=0.005)
    assert mf.plan(checker, None, np.zeros(2), np.ones(2), clearance=0.005, self_clearance=0.005)
