"""Sites and named frames of MJCF: links without mass, where MuJoCo has them, and sites again when they are written."""

from __future__ import annotations

import re
from pathlib import Path

import mujoco
import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import FileError, ModelError
from mafsil.model import mjcf, sdf, urdf
from mafsil.model.placement import pose_from_xyz_rpy
from tests.model.mjcf.test_mjcf_loops import GRIPPER

ARM = """<mujoco model="arm">
  <compiler angle="degree" autolimits="true"/>
  <default><site size="0.01"/><default class="drawn"><site pos="0 0 0.2" euler="10 20 30"/></default></default>
  <worldbody>
    <site name="desk" pos="0.5 0 0"/>
    <body name="upper" pos="0 0 0.3" euler="0 0 15">
      <joint name="j1" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.03"/>
      <site name="eye" class="drawn"/>
      <body name="lower" pos="0.4 0 0" childclass="drawn">
        <joint name="j2" axis="0 0 1" pos="0.01 0.02 0"/><geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02"/>
        <frame name="mount" pos="0.3 0 0" euler="0 90 0">
          <site name="pinch" pos="0 0.01 0.1" quat="1 2 3 4"/>
          <site name="rod" class="main" type="capsule" fromto="0 0 0 0.1 0.2 -0.3"/>
        </frame>
        <replicate count="3" offset="0.05 0 0" euler="0 0 20"><site name="pad" pos="0 0 0.05"/></replicate>
        <site name="lower" pos="0.2 0 0"/>
      </body>
    </body>
  </worldbody>
</mujoco>"""
PINCH = '<site name="pinch" pos="0 0.01 0.1" quat="1 2 3 4"/>'
SITES = ("desk", "eye", "pinch", "rod", "pad0", "pad1", "pad2")


def by_mujoco(text: str, q: np.ndarray, names: tuple[str, ...]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Pose and body Jacobian (omega, v) of sites."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[:] = q
    mujoco.mj_forward(model, data)
    found: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for name in names:
        k = model.site(name).id
        T, moving, turning = np.eye(4), np.zeros((3, model.nv)), np.zeros((3, model.nv))
        T[:3, :3], T[:3, 3] = data.site_xmat[k].reshape(3, 3), data.site_xpos[k]
        mujoco.mj_jacSite(model, data, moving, turning, k)
        found[name] = T, np.concatenate([T[:3, :3].T @ turning, T[:3, :3].T @ moving])
    return found


def test_sites_stand_and_move_as_in_mujoco(tmp_path: Path) -> None:
    (tmp_path / "arm.xml").write_text(ARM)
    robot, q = mf.load(tmp_path / "arm.xml"), np.array([0.3, -0.8])
    theirs = by_mujoco(ARM, q, (*SITES, "lower"))
    for name in SITES:
        np.testing.assert_allclose(robot.forward_kinematics(q, frame=name), theirs[name][0], atol=1e-14)
        np.testing.assert_allclose(robot.jacobian_body(q, frame=name), theirs[name][1], atol=1e-14)
    same_name = robot.forward_kinematics(q, frame="lower/site")
    np.testing.assert_allclose(same_name, theirs["lower"][0], atol=1e-14)
    assert set(robot.mechanism.frame_names) == {*SITES, "lower/site", "mount"}
    bare = mjcf.read(re.sub(r"<site name=.*?/>", "", ARM).replace(' name="mount"', ""))
    assert set(robot.mechanism.link_names) - set(robot.mechanism.frame_names) == set(bare.link_names)
    assert f"{len(bare.links)} links, 9 named frames" in repr(robot)


def test_a_site_is_a_tip_and_a_target(tmp_path: Path) -> None:
    (tmp_path / "arm.xml").write_text(ARM)
    robot = mf.load(tmp_path / "arm.xml", tip="pinch")
    q = np.array([0.3, -0.8])
    T = by_mujoco(ARM, q, ("pinch",))["pinch"][0]
    np.testing.assert_allclose(robot.forward_kinematics(q), T, atol=1e-14)
    assert mf.solve_ik(robot, T)
    assert mf.solve_ik(mf.load(tmp_path / "arm.xml"), T, frame="pinch")


@pytest.mark.parametrize(("name", "tip"), [("pinch", "lower"), ("tool0", "tool0"), ("left_tcp", "left_tcp")])
def test_a_site_is_the_tip_by_itself_only_if_it_is_called_like_a_tool(name: str, tip: str) -> None:
    assert mjcf.read(ARM.replace("pinch", name)).tip == tip


def test_a_named_frame_stands_where_a_site_in_it_does() -> None:
    """MuJoCo forgets its frames when it has compiled them."""
    text = ARM.replace(PINCH, '<site name="pinch" pos="0 0 0" euler="0 0 0"/>')
    q = np.array([0.3, -0.8])
    robot = mf.Robot(mjcf.read(text))
    np.testing.assert_allclose(
        robot.forward_kinematics(q, frame="mount"), by_mujoco(text, q, ("pinch",))["pinch"][0], atol=1e-14
    )


@pytest.mark.parametrize(
    ("wrong", "code"),
    [('pos="0 0"', "N0205"), ('pos="0 0 x"', "N0202"), ('quat="0 0 0 0"', "M0714"), ('class="nowhere"', "M0705")],
)
def test_sites_without_a_pose_are_refused_as_mujoco_does(wrong: str, code: str) -> None:
    text = ARM.replace(PINCH, f'<site name="pinch" {wrong}/>')
    with pytest.raises(ValueError, match="site"):
        mujoco.MjModel.from_xml_string(text)
    with pytest.raises(FileError, match=code):
        mjcf.read(text)


def test_named_frames_of_any_robot_are_written_and_read_again() -> None:
    T_lf = pose_from_xyz_rpy((0.1, -0.2, 0.3), (0.4, 0.5, 0.6))
    robot = mf.load("panda").with_frame("camera", T_lf, "link4").with_frame("lens", [0, 0, 0.02], "camera")
    q = np.linspace(-0.6, 0.7, robot.n)
    texts = {format_: format_.write(robot, without=["limits"]) for format_ in (mjcf, sdf)}
    texts[urdf] = urdf.write(robot, without=["limits", "actuator"])
    assert '<site name="lens"' in texts[mjcf]
    assert '<frame name="lens"' in texts[sdf]
    assert '<link name="lens"/>' in texts[urdf]
    for format_, text in texts.items():
        again = mf.Robot(format_.read(text))
        for frame in ("camera", "lens", None):
            np.testing.assert_allclose(
                again.forward_kinematics(q, frame=frame), robot.forward_kinematics(q, frame=frame), atol=1e-12
            )
        assert {"camera", "lens"} <= set(again.mechanism.frame_names)
        np.testing.assert_allclose(again.mass_matrix(q), robot.mass_matrix(q), atol=1e-9)
    theirs = by_mujoco(texts[mjcf], q, ("camera", "lens"))
    np.testing.assert_allclose(theirs["lens"][0], robot.forward_kinematics(q, frame="lens"), atol=1e-12)


def test_sites_that_only_hold_loops_are_no_frames() -> None:
    closed = mjcf.read(GRIPPER)
    assert "knuckle" not in closed.link_names
    again = mjcf.read(mjcf.write(closed))
    assert set(again.link_names) == set(closed.link_names)
    assert again.frame_names == closed.frame_names


def test_a_frame_changes_neither_masses_nor_motion() -> None:
    bare = mf.load("ur5e")
    framed = bare.with_frame("here").with_frame("there", [0, 0, 0.1])
    q, qd, qdd = np.random.default_rng(3).uniform(-1, 1, (3, 4, bare.n))
    np.testing.assert_array_equal(framed.inverse_dynamics(q, qd, qdd), bare.inverse_dynamics(q, qd, qdd))
    np.testing.assert_array_equal(framed.forward_kinematics(q), bare.forward_kinematics(q))
    np.testing.assert_array_equal(framed.forward_kinematics(q, frame="here"), bare.forward_kinematics(q))
    np.testing.assert_allclose(
        framed.forward_kinematics(q, frame="there"), bare.with_tool([0, 0, 0.1]).forward_kinematics(q), atol=1e-15
    )
    assert framed.tip == bare.tip
    assert len(framed.mechanism.links) == len(bare.mechanism.links) + 2


def test_a_frame_needs_a_name_of_its_own_and_a_link() -> None:
    robot = mf.load("ur5e")
    with pytest.raises(ModelError, match="forearm"):
        robot.with_frame(robot.mechanism.link_names[3])
    with pytest.raises(ModelError, match="nowhere"):
        robot.with_frame("here", link="nowhere")
    twice = robot.with_frame(f"{robot.with_frame('a').mechanism.joints[-1].name}")
    assert len({joint.name for joint in twice.with_frame("a").mechanism.joints}) == len(twice.mechanism.joints) + 1
