"""SDFormat: rules of frames and axes of each version, against products of exponentials computed here."""

from __future__ import annotations

from math import inf, pi
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

import mafsil as mf
from mafsil.errors import FileError
from mafsil.model import sdf, urdf
from mafsil.model.joint import JointKind
from mafsil.model.loading import load_mechanism
from mafsil.model.placement import pose_from_xyz_rpy

INERTIAL = "<inertial><mass>2</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>"
N = 3


def line(numbers: np.ndarray) -> str:
    return " ".join(map(repr, map(float, numbers)))


def model(inside: str, version: str = "1.9", name: str = "m", rest: str = "") -> str:
    return f'<sdf version="{version}"><model name="{name}">{rest}{inside}</model></sdf>'


def link(name: str, pose: str = "", inside: str = INERTIAL) -> str:
    return f'<link name="{name}">{pose}{inside}</link>'


def joint(name: str, parent: str, child: str, kind: str = "revolute", inside: str = "<axis/>") -> str:
    return f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>{inside}</joint>'


def expected_poses(X: list[np.ndarray], P: list[np.ndarray], axes: list[np.ndarray], q: np.ndarray) -> np.ndarray:
    """Pose of the last link: product of exponentials of axes in the model's frame, through the joints' origins."""
    T = np.eye(4)
    for k in range(N):
        w, p = axes[k], (X[k + 1] @ P[k])[:3, 3]
        S = np.zeros((4, 4))
        S[:3, :3] = [[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]]
        S[:3, 3] = -np.cross(w, p)
        T = T @ expm(S * q[k])
    return T @ X[N]


@pytest.mark.parametrize("version", ["1.4", "1.6 model", "1.6", "1.7 model", "1.9", "1.11 chained"])
def test_axes_and_poses_of_every_version(version: str) -> None:
    rng = np.random.default_rng(5)
    given = rng.uniform(-1, 1, (N + 1, 6))
    offsets = rng.uniform(-0.3, 0.3, (N, 6))
    X = [pose_from_xyz_rpy(g[:3], g[3:]) for g in given]
    P = [pose_from_xyz_rpy(g[:3], g[3:]) for g in offsets]
    xyz = rng.normal(size=(N, 3))
    number, _, manner = version.partition(" ")
    in_model = number == "1.4" or manner == "model"
    parts = []
    for k in range(N + 1):
        pose = f"<pose>{line(given[k])}</pose>"
        if manner == "chained" and k:
            pose = f'<pose relative_to="f{k}"/>'
            parts.append(f'<frame name="f{k}" attached_to="l{k - 1}"><pose relative_to="g{k}"/></frame>')
            parts.append(f'<frame name="g{k}"><pose>{line(given[k])}</pose></frame>')
        parts.append(link(f"l{k}", pose))
    for k in range(N):
        extra = "<use_parent_model_frame>true</use_parent_model_frame>" if version == "1.6 model" else ""
        where = ' expressed_in="__model__"' if version == "1.7 model" else ""
        axis = f"<axis><xyz{where}>{line(xyz[k])}</xyz>{extra}</axis>"
        parts.append(joint(f"j{k}", f"l{k}", f"l{k + 1}", inside=f"<pose>{line(offsets[k])}</pose>{axis}"))
    mechanism = sdf.read(model("".join(parts), number))
    axes = []
    for k in range(N):
        R = np.eye(3) if in_model else (X[k + 1] @ P[k])[:3, :3]
        axes.append(R @ xyz[k] / np.linalg.norm(xyz[k]))
    q = rng.uniform(-2, 2, N)
    robot = mf.Robot(mechanism.with_tip(f"l{N}"))
    np.testing.assert_allclose(robot.forward_kinematics(q), expected_poses(X, P, axes, q), atol=1e-12)
    assert {r.code for r in mechanism.provenance.remarks} == {"D1209"}


def test_the_same_arm_in_urdf() -> None:
    """Joints at the origins of their children: link by link the URDF of the same numbers."""
    T = "<origin xyz='0.1 0.2 0.3' rpy='0.4 0.5 0.6'/>"
    limit = "<limit lower='-1' upper='2' effort='5' velocity='3'/>"
    body = (
        "<inertial><origin xyz='0.1 0 0' rpy='0 0 0.3'/><mass value='2'/>"
        "<inertia ixx='1' ixy='0.1' ixz='0' iyy='1.2' iyz='0' izz='1.1'/></inertial>"
    )
    other = urdf.read(
        f"<robot name='m'><link name='world'/><link name='a'>{body}</link><joint name='j' type='revolute'>"
        f"<parent link='world'/><child link='a'/>{T}<axis xyz='0 1 0'/>{limit}"
        "<dynamics damping='0.2' friction='0.3'/></joint></robot>"
    )
    inertia = "<ixx>1</ixx><ixy>0.1</ixy><iyy>1.2</iyy><izz>1.1</izz>"
    inside = f"<inertial><pose>0.1 0 0 0 0 0.3</pose><mass>2</mass><inertia>{inertia}</inertia></inertial>"
    axis = (
        "<axis><xyz>0 1 0</xyz><limit><lower>-1</lower><upper>2</upper><effort>5</effort><velocity>3</velocity></limit>"
        "<dynamics><damping>0.2</damping><friction>0.3</friction></dynamics></axis>"
    )
    mine = sdf.read(
        model(link("a", "<pose>0.1 0.2 0.3 0.4 0.5 0.6</pose>", inside) + joint("j", "world", "a", inside=axis))
    )
    assert mine.link_names == other.link_names
    one, two = mine.joints[0], other.joints[0]
    assert (one.limits, one.friction, one.wraps) == (two.limits, two.friction, two.wraps)
    np.testing.assert_allclose(one.T_pj, two.T_pj, atol=1e-15)
    np.testing.assert_allclose(mine.links[1].inertial.inertia, other.links[1].inertial.inertia, atol=1e-15)
    np.testing.assert_allclose(mine.links[1].inertial.com, other.links[1].inertial.com, atol=1e-15)
    assert mine.provenance.remarks == ()


def test_types_of_joints() -> None:
    two = "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>"
    pitch = "<screw_thread_pitch>0.02</screw_thread_pitch><axis><xyz>0 0 1</xyz></axis>"
    text = model(
        "".join(link(c) for c in "abcde")
        + joint("u", "a", "b", "universal", two)
        + joint("s", "b", "c", "screw", pitch)
        + joint("p", "c", "d", "prismatic", "<axis><limit><lower>0</lower><upper>1</upper></limit></axis>")
        + joint("f", "d", "e", "fixed", "")
    )
    mechanism = sdf.read(text)
    assert mechanism.joint_names == ("u", "u/axis2", "s", "p")
    assert mechanism.joints[2].kind is JointKind.HELICAL
    assert mechanism.joints[2].pitch == pytest.approx(0.02 / (2 * pi))
    assert mechanism.limits.upper[3] == 1.0
    assert mechanism.joints[0].wraps
    assert mechanism.limits.upper[0] == inf


def test_quaternions_degrees_and_nested_models() -> None:
    inner = (
        '<model name="hand"><pose relative_to="a">1 0 0 0 0 0</pose>'
        f"{link('palm', '<pose degrees=' + chr(34) + 'true' + chr(34) + '>0 0 0 0 0 90</pose>')}</model>"
    )
    turned = '<pose rotation_format="quat_xyzw">0 0 1 0 0 0.7071067811865476 0.7071067811865476</pose>'
    mechanism = sdf.read(model(link("a", turned) + inner + joint("j", "a", "hand::palm", "fixed", "")))
    T = mechanism.joints[0].T_pj
    np.testing.assert_allclose(T, pose_from_xyz_rpy((1, 0, 0), (0, 0, pi / 2)), atol=1e-15)
    np.testing.assert_allclose(mechanism.T_sb, pose_from_xyz_rpy((0, 0, 1), (0, 0, pi / 2)), atol=1e-15)


def test_a_second_parent_closes_a_loop() -> None:
    places = {"a": "0 0 0 0 0 0", "b": "1 0 0 0 0 0", "c": "1 1 0 0 0 0", "d": "0 1 0 0 0 0"}
    links = "".join(link(name, f"<pose>{place}</pose>") for name, place in places.items())
    ring = [joint(f"j{k}", p, c) for k, (p, c) in enumerate([("a", "b"), ("b", "c"), ("a", "d"), ("d", "c")])]
    mechanism = sdf.read(model(links + "".join(ring)))
    assert [loop.name for loop in mechanism.loops] == ["j3"]
    assert mechanism.n == 3


def test_worlds_includes_and_static_models(tmp_path: Path) -> None:
    package = tmp_path / "arm"
    package.mkdir()
    (package / "model.config").write_text('<model><sdf version="1.6">arm.sdf</sdf></model>')
    (package / "arm.sdf").write_text(model(link("a") + joint("j", "world", "a")))
    world = tmp_path / "cell.world"
    world.write_text(
        '<sdf version="1.6"><world name="w"><gravity>0 0 -1.62</gravity>'
        "<include><uri>model://ground_plane</uri></include>"
        f'<model name="table"><static>true</static>{link("top")}</model>'
        "<include><uri>model://arm</uri><name>left</name><pose>0 0 2 0 0 0</pose></include></world></sdf>"
    )
    mechanism = load_mechanism(world)
    assert mechanism.name == "left"
    np.testing.assert_array_equal(mechanism.gravity, [0, 0, -1.62])
    np.testing.assert_array_equal(mechanism.joints[0].T_pj[:3, 3], [0, 0, 2])
    assert {remark.code for remark in mechanism.provenance.remarks} == {"D1205", "D1207"}
    table = sdf.read(model(link("top") + link("foot", "<pose>0 0 -1 0 0 0</pose>"), rest="<static>true</static>"))
    assert [j.parent for j in table.joints] == ["world", "world"]


def test_a_placement_frame() -> None:
    text = model(link("a", "<pose>0 0 1 0 0 0</pose>"), rest="<pose>5 0 0 0 0 0</pose>")
    text = text.replace('name="m"', 'name="m" placement_frame="a"')
    np.testing.assert_array_equal(sdf.read(text).T_sb[:3, 3], [5, 0, 0])


def test_mimics() -> None:
    follow = (
        '<axis><mimic joint="j"><multiplier>2</multiplier><offset>1</offset><reference>3</reference></mimic></axis>'
    )
    text = model("".join(link(c) for c in "abc") + joint("j", "a", "b") + joint("k", "b", "c", inside=follow))
    mimic = sdf.read(text).joints[1].mimic
    assert mimic is not None
    assert (mimic.leader, mimic.multiplier, mimic.offset) == ("j", 2.0, -5.0)


def geared(axis: str, ratio: str, other: str = "0 0 1", turned: bool = False) -> str:
    """Two wheels on a frame that a gearbox couples."""
    along, second = (f"<axis><xyz>{xyz}</xyz></axis>" for xyz in ("0 0 1", other))
    ends = ("b", "a") if turned else ("a", "b")
    text = "".join(link(c) for c in "abc") + joint("j", "world", "a", inside="<axis><xyz>0 1 0</xyz></axis>")
    text += joint("input", *ends, inside=along) + joint("output", "a", "c", inside=second)
    box = f"<gearbox_reference_body>a</gearbox_reference_body>{ratio}<axis><xyz>{axis}</xyz></axis>"
    return model(text + joint("box", "b", "c", "gearbox", box + "<axis2><xyz>0 0 1</xyz></axis2>"))


@pytest.mark.parametrize(("other", "turned", "sign"), [("0 0 1", False, -1), ("0 0 -1", False, 1), ("0 0 1", True, 1)])
def test_gearboxes(other: str, turned: bool, sign: int) -> None:
    """theta_2 = -ratio theta_1: seen from their frame, the wheels turn so, however their hinges are drawn."""
    ratio = "<gearbox_ratio>0.25</gearbox_ratio>"
    mechanism = sdf.read(geared("0 0 1", ratio, other, turned))
    follower = next(joint for joint in mechanism.joints if joint.name == "input")
    assert follower.mimic is not None
    assert (follower.mimic.leader, follower.mimic.multiplier) == ("output", sign / 0.25)
    robot = mf.Robot(mechanism)
    assert robot.joint_names == ("j", "output")
    a, b, c = (robot.forward_kinematics([0.3, 0.2], frame=name)[:3, :3] for name in "abc")
    first, second = a.T @ b, a.T @ c
    angles = [float(np.arctan2(R[1, 0], R[0, 0])) for R in (first, second)]
    assert angles[1] == pytest.approx(-0.25 * angles[0], abs=1e-12)


HOSTILE = {
    "D1201": model(link("a") + link("b") + joint("j", "a", "b", "spring", "")),
    "D1202": model(link("a", '<pose relative_to="nothing"/>')),
    "D1203": model(link("a", '<pose relative_to="f"/>') + '<frame name="f"><pose relative_to="a"/></frame>'),
    "D1204": '<sdf version="1.7"/>',
    "D1206": model("<include><uri>model://nowhere</uri></include>" + link("a")),
    "D1208": model(link("a", inside="")),
    "D1209": model(link("a")),
    "D1210": model(link("a"), rest="<static>perhaps</static>"),
    "D1211": model(link("a", '<pose rotation_format="quat_xyzw">0 0 0 0 0 0 0</pose>')),
    "D1212": model(link("a", inside='<inertial auto="true"/>')),
    "D1213": geared("1 0 0", "<gearbox_ratio>2</gearbox_ratio>"),
    "D1214": geared("0 0 1", "<gearbox_ratio>0</gearbox_ratio>"),
    "N0202": model(link("a", "<pose>0 0 zero 0 0 0</pose>")),
    "N0205": model(link("a", "<pose>0 0 0</pose>")),
    "S0303": model(link("a") + link("a")),
    "S0310": model(""),
    "F0130": "<robot/>",
    "I0503": model(link("a", inside="<inertial><mass>-1</mass></inertial>")),
    "J0404": model(link("a") + joint("j", "world", "a", inside="<axis><xyz>0 0 0</xyz></axis>")),
    "G0603": model(link("a", inside="<visual><geometry><sphere><radius>0</radius></sphere></geometry></visual>")),
}


@pytest.mark.row("F2")
@pytest.mark.parametrize("code", HOSTILE)
def test_hostile_files(code: str) -> None:
    report = sdf.diagnose(HOSTILE[code])
    found = [diagnostic for diagnostic in report if diagnostic.code == code]
    assert found, report.lines()
    assert found[0].line == 1
    assert found[0].line_of_text("en") != found[0].line_of_text("ar")
    assert found[0].repair is None
    assert report.ok == (not report.errors)
    if report.errors:
        with pytest.raises(FileError, match=code):
            sdf.read(HOSTILE[code])


@pytest.mark.parametrize("tag", ["mass", "ixx", "izz", "ixy", "damping", "friction"])
@pytest.mark.parametrize("value", ["inf", "-inf", "1e308"])
def test_only_limits_may_be_infinite(tag: str, value: str) -> None:
    inertial = INERTIAL.replace("</inertia>", "<ixy>0</ixy></inertia>")
    dynamics = "<dynamics><damping>0</damping><friction>0</friction></dynamics>"
    axis = f"<axis>{dynamics}<limit><lower>-inf</lower></limit></axis>"
    text = model(link("a") + link("b", inside=inertial) + joint("j", "a", "b", inside=axis))
    assert sdf.read(text).limits.lower[0] == -inf
    start, end = f"<{tag}>", f"</{tag}>"
    broken = text[: text.rindex(start)] + start + value + text[text.rindex(end) :]
    with pytest.raises(FileError, match="N020"):
        sdf.read(broken)
