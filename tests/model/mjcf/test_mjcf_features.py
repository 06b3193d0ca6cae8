"""What a file says once and what stands around the arm: flags, tendons, loose bodies, includes, attachments, bases."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mafsil.errors import FileError
from mafsil.model import JointKind, Mechanism, mjcf
from mafsil.robot import Robot
from tests.corpus.mujoco_file import MuJoCoFile

pytest.importorskip("mujoco")

BALL = '<geom type="sphere" size="0.1"/>'
HAND = f'<body name="hand" pos="0.3 0 0"><joint name="k"/>{BALL}</body>'
ARM = f'<body name="arm"><joint name="j" axis="0 1 0"/>{BALL}{HAND}</body>'


def document(bodies: str = ARM, more: str = "") -> str:
    return f"<mujoco>{more}<worldbody>{bodies}</worldbody></mujoco>"


def agreed(text: str) -> Mechanism:
    """The mechanism of a text, once MuJoCo has the same poses, masses and forces."""
    mechanism = mjcf.read(text)
    error, where = MuJoCoFile(text).difference(mechanism, 3)
    assert error < 1e-12, where
    return mechanism


def notes(mechanism: Mechanism) -> str:
    return " ".join(mechanism.provenance.notes)


def test_without_gravity_nothing_weighs() -> None:
    text = document(more='<option gravity="0 0 -5"><flag gravity="disable"/></option>')
    np.testing.assert_array_equal(agreed(text).gravity, np.zeros(3))


def test_flags_switch_off_what_resists() -> None:
    arm = ARM.replace('name="j"', 'name="j" damping="3" frictionloss="2"')
    friction = {}
    for flag in ("damper", "frictionloss", "constraint", "contact"):
        text = document(arm, f'<option><flag {flag}="disable"/></option>')
        friction[flag] = mjcf.read(text).joints[0].friction
    assert friction["damper"] is not None
    assert (friction["damper"].viscous, friction["damper"].coulomb) == (0.0, 2.0)
    for flag in ("frictionloss", "constraint"):
        assert friction[flag] is not None
        assert (friction[flag].viscous, friction[flag].coulomb) == (3.0, 0.0)
    assert friction["contact"] is not None
    assert (friction["contact"].viscous, friction["contact"].coulomb) == (3.0, 2.0)


def test_couplings_that_are_switched_off_do_not_couple() -> None:
    coupling = '<equality><joint joint1="j" joint2="k"/></equality>'
    off = '<option><flag equality="disable"/></option>'
    assert mjcf.read(document().replace("</mujoco>", f"{coupling}</mujoco>")).n == 1
    assert mjcf.read(document(more=off).replace("</mujoco>", f"{coupling}</mujoco>")).n == 2


def test_tendon_armature_on_one_coordinate_is_inertia_of_that_joint() -> None:
    tendon = '<tendon><fixed armature="2"><joint joint="j" coef="0.5"/><joint joint="k" coef="3"/></fixed></tendon>'
    coupling = '<equality><joint joint1="k" joint2="j" polycoef="0 0.25 0 0 0"/></equality>'
    with pytest.raises(FileError, match="M0724"):
        mjcf.read(document().replace("</mujoco>", f"{tendon}</mujoco>"))
    mechanism = agreed(document().replace("</mujoco>", f"{coupling}{tendon}</mujoco>"))
    assert mechanism.joints[0].actuator is not None
    assert mechanism.joints[0].actuator.armature == pytest.approx(2 * (0.5 + 3 * 0.25) ** 2)


def test_springs_of_tendons_and_joints_are_said() -> None:
    tendon = '<tendon><fixed stiffness="2"><joint joint="j" coef="0.5"/></fixed></tendon>'
    mechanism = mjcf.read(
        document(ARM.replace('name="k"', 'name="k" stiffness="4"')).replace("</mujoco>", f"{tendon}</mujoco>")
    )
    assert notes(mechanism).count("M0702") == 2
    assert notes(agreed(document(ARM.replace('name="k"', 'name="k" stiffness="0"')))) == ""


def test_an_object_beside_the_arm_is_left_out_with_all_its_faults() -> None:
    cube = '<body name="cube"><freejoint/><geom type="mesh" mesh="m"/></body>'
    mechanism = mjcf.read(document(ARM + cube, '<asset><mesh name="m" file="none.stl"/></asset>'))
    assert mechanism.link_names == ("world", "arm", "hand")
    assert "M0722" in notes(mechanism)
    assert "cube" in notes(mechanism)
    with pytest.raises(FileError, match="M0717"):
        mjcf.read(
            document(ARM + cube.replace("<freejoint/>", "<joint/>"), '<asset><mesh name="m" file="none.stl"/></asset>')
        )


def test_what_refers_to_a_left_out_object_goes_with_it() -> None:
    more = f'<body name="lid"><freejoint/>{BALL}<body name="knob"><joint name="turn"/>{BALL}</body></body>'
    weld = '<equality><weld body1="lid" body2="hand"/></equality>'
    weld += '<actuator><motor joint="turn"/><motor joint="j"/></actuator>'
    mechanism = mjcf.read(document(ARM + more).replace("</mujoco>", f"{weld}</mujoco>"))
    assert (mechanism.joint_names, mechanism.loops) == (("j", "k"), ())


def test_a_robot_that_floats_is_held_by_its_base() -> None:
    robot = f'<body name="torso" pos="0 0 1" euler="10 20 30"><joint type="free"/>{BALL}{ARM}</body>'
    mechanism = agreed(document(robot))
    assert mechanism.joint_names == ("j", "k")
    assert "M0721" in notes(mechanism)
    np.testing.assert_array_equal(mechanism.joints[0].T_pj[:3, 3], [0, 0, 1])
    beside = f'<body name="door"><joint name="hinge"/>{BALL}</body>'
    assert set(mjcf.read(document(robot + beside)).joint_names) == {"j", "k", "hinge"}


def test_a_base_fixed_in_the_world_needs_no_inertia() -> None:
    asset = '<asset><mesh name="m" file="none.stl"/></asset>'
    base = f'<body name="base"><geom type="mesh" mesh="m"/>{ARM}</body>'
    assert mjcf.read(document(base, asset)).link("base").inertial is None
    moving = base.replace("<geom", '<joint name="rail" type="slide"/><geom')
    with pytest.raises(FileError, match="M0717"):
        mjcf.read(document(moving, asset))


def test_a_geometry_without_a_type_is_a_ball_fitted_to_its_mesh() -> None:
    points, faces = "0 0 0  0.2 0 0  0 0.3 0  0 0 0.25", "0 2 1  0 1 3  0 3 2  1 2 3"
    asset = f'<asset><mesh name="m" vertex="{points}" face="{faces}"/></asset>'
    agreed(document(ARM.replace('type="sphere" size="0.1"', 'mesh="m"'), asset))


def test_joints_stand_in_frames() -> None:
    frame = '<frame pos="0.1 0.2 0.3" euler="20 30 40"><joint name="f" axis="1 2 3" pos="0.1 0 0"/></frame>'
    assert agreed(document(ARM.replace('<joint name="k"/>', frame))).joint_names == ("j", "f")


@pytest.mark.parametrize("mark", ["LICENSE", "package.xml", "pyproject.toml"])
def test_includes_reach_as_far_as_what_was_published_together(mark: str, tmp_path: Path) -> None:
    (tmp_path / "common").mkdir()
    (tmp_path / "robot").mkdir()
    (tmp_path / "common/arm.xml").write_text(f"<mujocoinclude>{ARM}</mujocoinclude>")
    path = tmp_path / "robot/main.xml"
    path.write_text(document('<include file="../common/arm.xml"/>'))
    with pytest.raises(FileError, match="M0703"):
        mjcf.read(path)
    (tmp_path / mark).touch()
    assert mjcf.read(path).joint_names == ("j", "k")


def test_a_file_may_be_included_twice(tmp_path: Path) -> None:
    (tmp_path / "ball.xml").write_text(f"<x>{BALL}</x>")
    path = tmp_path / "main.xml"
    twice = '<include file="ball.xml"/>'
    path.write_text(document(f'<body name="a"><joint/>{twice}</body><body name="b"><joint/>{twice}</body>'))
    mechanism = mjcf.read(path)
    assert all(mechanism.link(name).inertial is not None for name in "ab")


def test_part_of_a_model_is_attached_with_what_belongs_to_it(tmp_path: Path) -> None:
    couplings = '<equality><joint joint1="k" joint2="j"/></equality><actuator><motor joint="k"/></actuator>'
    (tmp_path / "tool.xml").write_text(document().replace("</mujoco>", f"{couplings}</mujoco>"))
    attach = '<attach model="t" {} prefix="t_"/>'
    asset = '<asset><model name="t" file="tool.xml"/></asset>'
    bodies = [
        f'<body name="a"><joint name="a"/>{BALL}{attach.format(what)}</body>' for what in ("", 'body="hand"')
    ]  # fmt: skip
    texts = [document(body, asset) for body in bodies]
    path = tmp_path / "main.xml"
    path.write_text(texts[0])
    whole = mjcf.read(path)
    assert [(joint.name, joint.mimic and joint.mimic.leader) for joint in whole.joints if joint.moves] == [
        ("a", None), ("t_j", None), ("t_k", "t_j")
    ]  # fmt: skip
    path.write_text(texts[1])
    part = mjcf.read(path)
    assert (part.joint_names, part.actuated) == (("a", "t_k"), (False, True))


def test_loops_are_said_and_leave_the_tree_as_it_is() -> None:
    connect = '<equality><connect body1="arm" body2="hand" anchor="0 0 0"/></equality>'
    mechanism = agreed(document().replace("</mujoco>", f"{connect}</mujoco>"))
    assert "M0728" in notes(mechanism)
    assert (mechanism.n, [loop.kind for loop in mechanism.loops]) == (2, [JointKind.SPHERICAL])


def test_replication_is_bounded() -> None:
    nested = ARM.replace(' name="arm"', "").replace(' name="hand"', "")
    for _ in range(4):
        nested = f'<replicate count="300">{nested}</replicate>'
    assert "F0121" in mjcf.diagnose(document(nested)).codes


def test_a_mesh_is_drawn_where_it_weighs(tmp_path: Path) -> None:
    corners = np.array([[x, y, z] for x in (0, 2) for y in (0, 3) for z in (0, 1)], float)
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + ["f " + " ".join(str(i + 1) for i in q) for q in quads]
    (tmp_path / "block.obj").write_text("\n".join(lines))
    reference = 'refpos="0.3 0.1 0.2" refquat="1 0.2 0.3 0.4" scale="0.1 0.1 0.1"'
    path = tmp_path / "main.xml"
    geom = '<geom type="mesh" mesh="block" pos="1 0 0" euler="0 0 30"/>'
    path.write_text(
        document(f'<body name="b"><joint/>{geom}</body>', f'<asset><mesh file="block.obj" {reference}/></asset>')
    )
    link = mjcf.read(path).link("b")
    (shape,) = link.visuals
    assert link.inertial is not None
    np.testing.assert_allclose(
        shape.T_lg[:3, :3] @ [0.1, 0.15, 0.05] + shape.T_lg[:3, 3], link.inertial.com, atol=1e-12
    )


BALLS = """
<body name="a" pos="0 0 1" euler="20 30 50"><joint name="h" axis="1 2 0" pos="0 .1 0"/>
  <geom type="capsule" size=".05 .2"/><body name="b" pos=".1 .2 .3" euler="10 -40 70">
    <frame euler="30 0 20" pos="0.05 0 0"><joint name="b" type="ball" pos=".02 .03 .1" damping="0.1"/></frame>
    <inertial pos="0.1 0.2 0" mass="2" fullinertia="1 2 2.5 .1 .2 .3"/><site name="pinch" pos="0 0 .1"/>
    <body name="c" pos="0 0 .4"><joint type="ball"/><geom type="box" size=".1 .2 .3"/>
      <body name="d" pos="0 .2 0"><joint type="ball"/><joint name="e" type="slide" axis="0 1 1"/>
        <geom type="sphere" size=".1"/></body></body></body></body>"""


def test_balls_are_three_hinges_with_the_same_motion_and_forces() -> None:
    """A body that is called like its ball keeps what refers to it, and motors of a ball are left out."""
    mechanism = agreed(
        document(BALLS).replace("</mujoco>", "<actuator><motor joint='b'/><motor joint='e'/></actuator></mujoco>")
    )
    assert mechanism.joint_names[1:4] == ("b_x", "b_y", "b_z")
    assert mechanism.n == 11
    assert "pinch" in mechanism.link_names
    said = notes(mechanism)
    assert said.count("M0711") == 3
    assert 'damping="0.1"' in said
    text, _ = mjcf.repair(document(BALLS).replace(' damping="0.1"', ""))
    for q in np.random.default_rng(0).normal(size=(5, 11)):
        poses = [Robot(mjcf.read(each)).link_poses(q) for each in (text, document(BALLS))]
        np.testing.assert_allclose(*poses, atol=1e-14)
