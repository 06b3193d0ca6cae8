"""Named frames of SDFormat: links without mass, ends of joints, and no tip unless they are called like one."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import FileError
from mafsil.model import JointKind, sdf
from mafsil.model.placement import pose_from_xyz_rpy
from tests.model.drake_reader import plant_of
from tests.model.sdf.test_sdf import joint, link, model

MOUNT = '<frame name="mount" attached_to="a"><pose>0 0 0.4 0 0 0.5</pose></frame>'
ABOUT_Y = "<axis><xyz>0 1 0</xyz></axis>"


def pose_of(robot: mf.Robot, q: float, frame: str) -> np.ndarray:
    return robot.forward_kinematics([q], frame=frame)


def hinged(xyz: tuple[float, ...], rpy: tuple[float, ...], axis: int, q: float) -> np.ndarray:
    """A pose, and a turn about an axis of it."""
    turn = np.zeros(3)
    turn[axis] = q
    return pose_from_xyz_rpy(xyz, rpy) @ pose_from_xyz_rpy((0, 0, 0), tuple(turn))


def test_a_joint_on_a_frame() -> None:
    """The joint stands at its child, turned as it; the frame only says what carries it."""
    text = model(link("a") + link("b", "<pose>0 0 1 0.3 0 0</pose>") + MOUNT + joint("j", "mount", "b", inside=ABOUT_Y))
    robot = mf.Robot(sdf.read(text))
    assert robot.joint_names == ("j",)
    np.testing.assert_allclose(pose_of(robot, 0.7, "b"), hinged((0, 0, 1), (0.3, 0, 0), 1, 0.7), atol=1e-15)
    np.testing.assert_allclose(pose_of(robot, 0.7, "mount"), pose_from_xyz_rpy((0, 0, 0.4), (0, 0, 0.5)), atol=1e-15)
    turning = [each for each in robot.mechanism.joints if each.moves]
    assert [(each.parent, each.child) for each in turning] == [("mount", "b")]


def test_a_joint_to_a_frame() -> None:
    """The joint stands and points as the frame that it names as its child, and carries the link of the frame."""
    frame = '<frame name="socket" attached_to="b"><pose>0.1 0.2 0 0 0 1.1</pose></frame>'
    text = model(
        link("a") + link("b", "<pose>0 0 1 0 0 0.4</pose>") + frame + joint("j", "a", "socket", inside=ABOUT_Y)
    )
    robot = mf.Robot(sdf.read(text))
    T_ab, T_bf = pose_from_xyz_rpy((0, 0, 1), (0, 0, 0.4)), pose_from_xyz_rpy((0.1, 0.2, 0), (0, 0, 1.1))
    expected = T_ab @ T_bf @ hinged((0, 0, 0), (0, 0, 0), 1, 0.7) @ np.linalg.inv(T_bf)
    np.testing.assert_allclose(pose_of(robot, 0.7, "b"), expected, atol=1e-15)
    assert robot.mechanism.links[0].name == "a"


@pytest.mark.parametrize("canonical", ["", ' canonical_link="c"'])
def test_a_joint_on_the_model(canonical: str) -> None:
    """The model's frame hangs on its canonical link: the first one, or the one it names."""
    text = model(
        link("a") + link("b", "<pose>0 0 1 0 0 0</pose>") + link("c", "<pose>1 0 0 0 0 0</pose>")
        + joint("w", "a", "c", "fixed", "") + joint("j", "__model__", "b", inside=ABOUT_Y)
    )  # fmt: skip
    mechanism = sdf.read(text.replace('name="m"', f'name="m"{canonical}'))
    assert {each.name: each.parent for each in mechanism.joints}["j"] == ("c" if canonical else "a")
    np.testing.assert_allclose(pose_of(mf.Robot(mechanism), 0.7, "b"), hinged((0, 0, 1), (0, 0, 0), 1, 0.7), atol=1e-15)


def test_frames_of_nested_models_joints_and_other_frames() -> None:
    """`hand::F` on a frame on a joint, and a nested model by its name: its first link."""
    inner = (
        f'<model name="hand"><pose>0 0 2 0 0 0</pose>{link("palm")}'
        '<frame name="F" attached_to="palm"><pose>0 0.1 0 0 0 0</pose></frame></model>'
    )
    text = model(
        link("a") + link("b", "<pose>0 0 1 0 0 0</pose>") + joint("j", "a", "b", inside=ABOUT_Y) + inner
        + '<frame name="on_joint" attached_to="j"><pose>0 0 0.2 0 0 0</pose></frame>'
        + '<frame name="on_frame" attached_to="on_joint"><pose>0 0 0.3 0 0 0</pose></frame>'
        + '<frame name="on_hand" attached_to="hand"><pose>0.5 0 0 0 0 0</pose></frame>'
        + joint("k", "on_frame", "hand::F", "fixed", "")
    )  # fmt: skip
    robot = mf.Robot(sdf.read(text))
    turn = hinged((0, 0, 1), (0, 0, 0), 1, 0.7)
    for name, xyz in (
        ("on_joint", (0, 0, 0.2)), ("on_frame", (0, 0, 0.5)), ("hand::palm", (0, 0, 1)), ("hand::F", (0, 0.1, 1)),
        ("on_hand", (0.5, 0, 1)),
    ):  # fmt: skip
        np.testing.assert_allclose(pose_of(robot, 0.7, name), turn @ pose_from_xyz_rpy(xyz, (0, 0, 0)), atol=1e-14)


@pytest.mark.parametrize(("name", "tip"), [("mount", "b"), ("tool0", "tool0"), ("arm_tcp", "arm_tcp")])
def test_frames_are_tips_only_by_a_name_of_convention(name: str, tip: str, tmp_path) -> None:
    frame = f'<frame name="{name}" attached_to="b"><pose>0 0 0.1 0 0 0</pose></frame>'
    path = tmp_path / "arm.sdf"
    path.write_text(model(link("a") + link("b") + frame + joint("j", "a", "b", inside=ABOUT_Y)))
    assert mf.load(path).mechanism.tip == tip
    chosen = mf.load(path, tip=name)
    np.testing.assert_allclose(chosen.forward_kinematics([0.0])[:3, 3], [0, 0, 0.1], atol=1e-15)


def test_frames_in_loops_hang_on_what_moves_them() -> None:
    """A loop whose last joint names frames on both of its links."""
    text = model(
        link("a") + link("b") + link("c") + joint("j", "a", "b") + joint("k", "a", "c")
        + '<frame name="f" attached_to="b"><pose>1 0 0 0 0 0</pose></frame>'
        + '<frame name="g" attached_to="c"><pose>1 0 0 0 0 0</pose></frame>' + joint("z", "f", "g")
    )  # fmt: skip
    mechanism = sdf.read(text)
    assert [(loop.parent, loop.child) for loop in mechanism.loops] == [("f", "g")]
    assert mechanism.n == 2
    assert mechanism.tip in ("a", "b", "c")


def test_a_joint_called_like_a_link_has_a_place_of_its_own() -> None:
    """Up to 1.6 that was allowed; the joint's own pose counts, wherever it stands in the file."""
    hinge = joint("b", "a", "b", inside="<pose>0 0 0.2 0.5 0 0</pose>" + ABOUT_Y)
    parts = [link("a"), link("b", "<pose>0 0 1 0 0 0</pose>"), hinge]
    expected = hinged((0, 0, 1.2), (0.5, 0, 0), 1, 0.7) @ np.linalg.inv(pose_from_xyz_rpy((0, 0, 0.2), (0.5, 0, 0)))
    for order in (parts, parts[::-1]):
        robot = mf.Robot(sdf.read(model("".join(order), "1.6")).with_tip("b"))
        np.testing.assert_allclose(robot.forward_kinematics([0.7]), expected, atol=1e-15)


def test_models_that_stand_keep_their_frames() -> None:
    text = model(link("a", "<pose>0 0 1 0 0 0</pose>") + MOUNT, rest="<static>true</static>")
    mechanism = sdf.read(text)
    assert [(each.kind, each.parent, each.child) for each in mechanism.joints] == [
        (JointKind.FIXED, "world", "a"), (JointKind.FIXED, "a", "mount"),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "code"),
    [
        (model(link("a") + '<frame name="f" attached_to="nothing"/>'), "D1202"),
        (model(link("a") + '<frame name="f" attached_to="g"/><frame name="g" attached_to="f"/>'), "D1203"),
        (model(link("a") + '<frame name="a"/>'), "S0303"),
        (model(link("a") + joint("j", "nowhere", "a")), "D1202"),
    ],
)
def test_frames_that_are_not_there(text: str, code: str) -> None:
    with pytest.raises(FileError, match=code):
        sdf.read(text)


@pytest.mark.parametrize(
    "element", ["<drake:gear_ratio>0</drake:gear_ratio>", "<drake:rotor_inertia>-1</drake:rotor_inertia>"]
)
def test_motors_that_are_none(element: str) -> None:
    mechanism = sdf.read(model(link("a") + link("b") + joint("j", "a", "b", inside=element + ABOUT_Y)))
    assert mechanism.joints[0].actuator is None
    assert any("drake:" in remark.sentence("en") for remark in mechanism.provenance.remarks)


HAND = """<model name="M1"><pose>0 0 1 0.1 0 0</pose>{b}
<frame name="F" attached_to="b"><pose>0.1 0 0 0 0 0.4</pose></frame></model>
<model name="M2" placement_frame="{placed}"><pose relative_to="M1::F">0 1 0 0.2 0 0</pose>{c}
<frame name="G" attached_to="c"><pose>0 0.3 0 0 0.5 0</pose></frame>
<model name="M3" placement_frame="H"><pose>0.1 0 0 0 0 0</pose>{e}
<frame name="H"><pose>0 0 0.2 0 1 0</pose></frame></model></model>
<frame name="top" attached_to="M2"><pose>0 0 1 0 0 0</pose></frame>"""


@pytest.mark.parametrize("placed", ["G", "c", "M3::H"])
def test_nested_models_are_placed_by_their_frames_as_in_drake(placed: str) -> None:
    inside = HAND.format(placed=placed, **{name: link(name) for name in "bce"})
    text = model(
        link("a") + inside + link("d", '<pose relative_to="M2">1 1 1 0 0 0</pose>')
        + joint("w", "world", "a", "fixed", "") + joint("j", "a", "M1::F", inside=ABOUT_Y)
        + joint("k", "M1::F", "M2::G", inside='<axis><xyz expressed_in="M1">0 0.6 0.8</xyz></axis>')
        + joint("l", "__model__", "d", "fixed", "") + joint("m", "M2::c", "M2::M3::H", "fixed", "")
    )  # fmt: skip
    robot, q = mf.Robot(sdf.read(text)), np.array([0.3, -0.5])
    plant = plant_of(text)
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    for frame in ("M1::b", "M2::c", "M2::M3::e", "d", "M1::F", "M2::G", "M2::M3::H", "top"):
        theirs = plant.GetFrameByName(frame.split("::")[-1]).CalcPoseInWorld(context).GetAsMatrix4()
        np.testing.assert_allclose(robot.forward_kinematics(q, frame=frame), theirs, atol=1e-14, err_msg=frame)
