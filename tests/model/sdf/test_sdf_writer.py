"""SDFormat as we write it, read back: the same links, joints, tip and numbers; what is lost is named."""

from __future__ import annotations

import warnings
from dataclasses import replace
from math import inf
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import FileError, ModelError, ModelWarning
from mafsil.mechanics.textbook import Textbook
from mafsil.model import (
    Actuator,
    Box,
    Capsule,
    Cylinder,
    Friction,
    Inertial,
    Joint,
    JointKind,
    Limits,
    Link,
    Mechanism,
    Mesh,
    Mimic,
    Shape,
    Sphere,
    library,
    sdf,
)
from mafsil.model.inertia_check import possible_inertias
from mafsil.model.losses import Weight
from mafsil.model.placement import pose_from_xyz_rpy
from tests.model.peer_readers import text_of
from tests.model.random_robots import random_robot
from tests.model.sdf.test_sdf_loops import ENDS, bars
from tests.model.test_saving import arm
from tests.oracles.random_tree import random_tree
from tests.sizes import few


def assert_same(again: Mechanism, mechanism: Mechanism) -> None:
    """Everything that SDFormat keeps; inertias no body has are compared as they are moved."""
    possible, _, _ = possible_inertias(mechanism)
    assert (again.name, again.link_names, again.tip) == (mechanism.name, mechanism.link_names, mechanism.tip)
    for name in ("T_lt", "T_sb", "gravity"):
        np.testing.assert_allclose(getattr(again, name), getattr(mechanism, name), rtol=0, atol=1e-14, err_msg=name)
    for ours, theirs in zip(mechanism.joints + mechanism.loops, again.joints + again.loops, strict=True):
        same_joint(ours, theirs)
    for ours, theirs in zip(possible.links, again.links, strict=True):
        assert (ours.inertial is None) == (theirs.inertial is None), ours.name
        if ours.inertial is not None and theirs.inertial is not None:
            assert theirs.inertial.mass == ours.inertial.mass
            np.testing.assert_allclose(theirs.inertial.com, ours.inertial.com, rtol=0, atol=1e-15)
            large = np.abs(ours.inertial.inertia).max()
            np.testing.assert_allclose(theirs.inertial.inertia, ours.inertial.inertia, rtol=0, atol=1e-11 * large)
        for kind in ("visuals", "collisions"):
            pairs = list(zip(getattr(ours, kind), getattr(theirs, kind), strict=True))
            assert [(a.geometry, a.name, a.colour) for a, _ in pairs] == [
                (b.geometry, b.name, b.colour) for _, b in pairs
            ]
            for a, b in pairs:
                np.testing.assert_allclose(b.T_lg, a.T_lg, rtol=0, atol=1e-15)


def same_joint(ours: Joint, theirs: Joint) -> None:
    """Names, kind, place, axis, limits, friction, motor, and what is followed."""
    for name in ("name", "kind", "parent", "child", "mimic"):
        assert getattr(theirs, name) == getattr(ours, name)
    np.testing.assert_allclose(theirs.T_pj, ours.T_pj, rtol=0, atol=2e-15)
    if not ours.moves or ours.kind is JointKind.SPHERICAL:
        return
    assert theirs.pitch == pytest.approx(ours.pitch, rel=1e-15)
    np.testing.assert_allclose(theirs.axis, ours.axis, rtol=0, atol=1e-15)
    assert theirs.actuated == ours.actuated
    assert theirs.limits == replace(ours.limits, jerk=inf, effort=ours.limits.effort if ours.actuated else 0.0)
    motor = 0.0 if ours.actuator is None else ours.actuator.reflected_inertia
    assert (theirs.actuator.reflected_inertia if theirs.actuator else 0.0) == pytest.approx(motor, rel=1e-15)
    friction = ours.friction and Friction(ours.friction.viscous, ours.friction.mean_coulomb)
    assert (theirs.friction or Friction()) == (friction or Friction())


@pytest.mark.parametrize("name", library.robots())
def test_library_arms_come_back_whole(name: str) -> None:
    mechanism = library.load(name)
    assert_same(sdf.read(text_of(mechanism, sdf)), mechanism)


@pytest.mark.parametrize("seed", few(range(200), 25))
def test_random_robots_come_back_whole(seed: int) -> None:
    mechanism = random_robot(seed)
    again = sdf.read(text_of(mechanism, sdf))
    assert_same(again, mechanism)
    q, qd, qdd = np.random.default_rng(seed).uniform(-2, 2, (3, 1, mechanism.n))
    ours, theirs = (Textbook(m).newton_euler(q, qd, qdd, None).tau for m in (mechanism, again))
    np.testing.assert_allclose(theirs, ours, rtol=0, atol=1e-10 * max(1.0, np.abs(ours).max(initial=0.0)))


@pytest.mark.parametrize("seed", few(range(40), 5))
def test_screws_come_back(seed: int) -> None:
    mechanism = random_tree(np.random.default_rng(seed), most_joints=9)
    assert_same(sdf.read(text_of(mechanism, sdf)), mechanism)


def test_all_that_a_joint_has() -> None:
    limits = Limits(-1.0, 2.0, 3.0, 4.0, effort=5.0)
    full = arm(limits=limits, friction=Friction(0.1, 0.2), actuator=Actuator(1e-4, 100.0, 0.5))
    assert_same(sdf.read(sdf.write(full)), full)
    assert_same(sdf.read(sdf.write(arm(actuated=False))), arm(actuated=False))


def test_effort_and_velocity_are_always_written() -> None:
    robot = library.load("elbow6r")
    bare = replace(robot, joints=tuple(replace(joint, limits=Limits()) for joint in robot.joints))
    for limit in ElementTree.fromstring(sdf.write(bare)).iter("limit"):
        assert (limit.findtext("effort"), limit.findtext("velocity")) == ("inf", "inf")
    for tag in ("effort", "velocity"):
        assert sdf.write("panda").count(f"<{tag}>") == 7


def test_shapes_of_one_name_and_colours_of_what_collides() -> None:
    T = pose_from_xyz_rpy((0.1, -0.2, 0.3), (0.4, 0.5, -0.6))
    red = (1.0, 0.0, 0.0, 0.5)
    shapes = (
        Shape(Capsule(0.05, 0.3), T, "tube", red),
        Shape(Cylinder(0.1, 0.2), T, "tube"),
        Shape(Box((0.1, 0.2, 0.3))),
        Shape(Sphere(0.1), T),
        Shape(Mesh("package://arm/a.stl", scale=(0.001, 0.001, 0.002))),
    )
    robot = arm()
    links = (robot.links[0], replace(robot.links[1], visuals=shapes, collisions=shapes))
    shaped = replace(robot, links=links)
    text = sdf.write(shaped)
    assert_same(sdf.read(text), shaped)
    for tag in ("visual", "collision"):
        names = [each.get("name") for each in ElementTree.fromstring(text).iter(tag)]
        assert len(set(names)) == len(shapes)
        assert all(names)


def test_massless_links_are_frames_where_they_can_be(tmp_path: Path) -> None:
    """A flange, a tool on it, and a mount that carries a joint."""
    T = pose_from_xyz_rpy((0.1, 0.2, 0.3), (0.4, 0.5, 0.6))
    body = Inertial(1.0, np.array([0.1, 0.0, 0.0]), np.diag([0.01, 0.02, 0.02]))
    joints = [
        Joint("a_to_mount", JointKind.FIXED, "a", "mount", T),
        Joint("j", JointKind.REVOLUTE, "mount", "b", T),
        Joint("b_to_flange", JointKind.FIXED, "b", "flange", T),
        Joint("flange_to_camera", JointKind.FIXED, "flange", "camera", T),
        Joint("k", JointKind.PRISMATIC, "a", "c", T),
    ]
    links = [Link("a", body), Link("mount"), Link("b", body), Link("flange"), Link("camera"), Link("c", body)]
    robot = Mechanism.assemble("arm", links, joints, tip="camera", T_lt=T, T_sb=T)
    path = tmp_path / "arm.sdf"
    losses = mf.save(robot, path)
    assert [loss.weight for loss in losses] == [Weight.NOTED]  # A revolute joint without a range.
    root = ElementTree.parse(path).getroot()
    assert [frame.get("name") for frame in root.iter("frame")] == ["mount", "flange", "camera", "tip"]
    assert [link.get("name") for link in root.iter("link")] == ["a", "b", "c"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        again = mf.load(path)
    assert_same(again.mechanism, robot)


@pytest.mark.parametrize("ending", [".sdf", ".world", ".SDF"])
def test_gravity_stands_in_a_world(ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"arm{ending}"
    for gravity, world in (((0.0, 0.0, -9.81), ending == ".world"), ((0.0, 0.1, -1.62), True)):
        mf.save(arm().with_gravity(np.array(gravity)), path)
        assert (ElementTree.parse(path).find("world") is not None) == world
        np.testing.assert_array_equal(mf.load(path).mechanism.gravity, gravity)
        assert sdf.write(arm(), path) == path.read_text()


def test_a_base_that_is_the_world() -> None:
    robot = Mechanism.assemble("arm", [Link("world"), arm().links[1]], [Joint("j", JointKind.REVOLUTE, "world", "b")])
    text = sdf.write(robot)
    assert text.count("<link") == 1
    assert_same(sdf.read(text), robot)
    stands = replace(robot, T_sb=pose_from_xyz_rpy((0, 0, 1), (0, 0, 0)))
    assert "world -> world_" in sdf.write(stands)
    assert_same(sdf.read(sdf.write(stands)), stands)


def test_names_that_sdformat_does_not_take() -> None:
    """One set of names for links and joints; scopes and words that are kept. They come back."""
    body = arm().links[1].inertial
    links = [Link("a"), Link("m::b", body), Link("__c__", body), Link("j")]
    joints = [
        Joint("a", JointKind.REVOLUTE, "a", "m::b"),
        Joint("m::b", JointKind.REVOLUTE, "m::b", "__c__", mimic=Mimic("a")),
        Joint("j", JointKind.FIXED, "__c__", "j"),
    ]
    robot = Mechanism.assemble("my::arm", links, joints)
    text = sdf.write(robot)
    assert "my::arm -> my/arm, m::b -> m/b, __c__ -> c, a -> a_joint, m::b -> m/b_joint, j -> j_joint" in text
    assert_same(sdf.read(text), robot)
    with pytest.raises(FileError, match="__c__"):
        sdf.read(text.replace('mafsil:name="m::b"', 'mafsil:name="__c__"'))
    with pytest.raises(ModelError, match=r"cannot represent the name 'a\$\(b\)'"):
        sdf.write(arm(name="a$(b)"))


def test_what_is_lost_is_named() -> None:
    with pytest.warns(ModelWarning, match="no jerk limits: those of hinge"):
        sdf.write(arm(limits=Limits(-1, 1, jerk=3.0)))
    with pytest.warns(ModelWarning, match="means a passive joint: hinge"):
        sdf.write(arm(limits=Limits(-1, 1, effort=0.0)))
    with pytest.warns(ModelWarning, match="hinge are written as drake:rotor_inertia"):
        sdf.write(arm(actuator=Actuator(1e-4, 100.0)))
    with pytest.warns(ModelWarning, match="no masses"):
        sdf.write(replace(arm(), links=(Link("a"), Link("b"))))
    with pytest.raises(ModelError, match=r'hinge.*without=\["friction"\]') as caught:
        sdf.write(arm(friction=Friction(0.1, 1.0, 2.0)))
    assert caught.value.message("ar") != caught.value.message("en")
    text = sdf.write(arm(friction=Friction(0.1, 1.0, 2.0)), without="friction")
    assert sdf.read(text).joints[0].friction == Friction(0.1, 1.5)


def test_inertias_that_stand_still_change_no_motion() -> None:
    impossible = Inertial(1.0, inertia=np.diag([0.5, 0.1, 0.1]))
    losses = sdf.writer.document(replace(arm(), links=(Link("a", impossible), arm().links[1]))).losses
    assert [loss.key for loss in losses] == ["writing.resting"]


@pytest.mark.parametrize("kind", ["revolute", "ball", "universal", "fixed", "prismatic"])
def test_loops_come_back(kind: str) -> None:
    """Closed where they are drawn, by joints of every kind that closes one."""
    drawn = sdf.read(bars(ENDS, "ABDC"))
    (pin,) = drawn.loops
    kinds = {"ball": JointKind.SPHERICAL, "universal": JointKind.UNIVERSAL}
    loop = replace(pin, kind=kinds.get(kind) or JointKind(kind), actuated=False)
    robot = replace(drawn, loops=(loop,))
    again = sdf.read(sdf.write(robot))
    assert_same(again, robot)
    np.testing.assert_array_equal(again.loops[0].second, loop.second)
    assert mf.mobility(again).mobility == mf.mobility(robot).mobility


@pytest.mark.parametrize("kind", list(JointKind))
def test_loops_that_cannot_be_drawn_are_refused(kind: JointKind) -> None:
    drawn = sdf.read(bars(ENDS, "ABDC"))
    T = np.array(drawn.loops[0].T_pj)
    T[:3, 3] += 0.01
    robot = replace(drawn, loops=(replace(drawn.loops[0], kind=kind, T_pj=T),))
    reason = "not with a" if kind in (JointKind.CYLINDRICAL, JointKind.PLANAR) else "C is open there by 0.01"
    with pytest.raises(ModelError, match=reason):
        sdf.write(robot)
