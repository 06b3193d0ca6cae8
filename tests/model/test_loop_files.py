"""Loops beside a file whose format cannot say them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import FileError
from mafsil.model import with_loops
from mafsil.parallel import ClosedChain

ROOT = Path(__file__).resolve().parents[2]
BODIES = {
    "upper": ("column", (0, 0, 0.3), "shoulder", 6, (0, 0, 0.2), (0.09, 0.09, 0.01)),
    "forearm": ("upper", (0, 0, 0.4), "elbow", 3, (0.12, 0, 0), (0.004, 0.05, 0.05)),
    "lever": ("column", (0, 0, 0.3), "lever", 0.8, (-0.06, 0, 0), (0.0005, 0.002, 0.002)),
    "rod": ("lever", (-0.12, 0, 0), "rod", 0.7, (0, 0, 0.2), (0.01, 0.01, 0.0004)),
}
LOOP = """driven = ["shoulder", "lever"]
[[loop]]
name = "rod end"
kind = "spherical"
parent = "rod"
child = "forearm"
parent_at = { xyz = [0, 0, 0.4] }
child_at = { xyz = [-0.12, 0, 0] }
"""


def urdf(folder: Path, loops: str | None = LOOP) -> Path:
    text = '<robot name="palletiser"><link name="column"/>'
    for name, (parent, xyz, joint, mass, com, (x, y, z)) in BODIES.items():
        place, middle = (" ".join(map(str, each)) for each in (xyz, com))
        text += (
            f'<link name="{name}"><inertial><mass value="{mass}"/><origin xyz="{middle}"/>'
            f'<inertia ixx="{x}" iyy="{y}" izz="{z}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
            f'<joint name="{joint}" type="continuous"><parent link="{parent}"/><child link="{name}"/>'
            f'<origin xyz="{place}"/><axis xyz="0 1 0"/></joint>'
        )
    path = folder / "arm.urdf"
    path.write_text(text + "</robot>")
    if loops is not None:
        (folder / "arm.loops.toml").write_text(loops)
    return path


@pytest.mark.parametrize("kind", ["spherical", "revolute"])
def test_the_urdf_moves_as_the_mjcf_file_does(kind, tmp_path):
    loops = LOOP.replace("spherical", kind) + ("axis = [0, 1, 0]\n" if kind == "revolute" else "")
    ours = mf.load(urdf(tmp_path, loops), tip="forearm")
    other = mf.load(ROOT / "examples" / "robots" / "palletiser.xml")
    one, two = ClosedChain(ours), ClosedChain(other)
    names = [list(robot.joint_names) for robot in (ours, other)]
    order = [names[1].index(name) for name in names[0]]
    assert [ours.joint_names[k] for k in one.actuated] == ["shoulder", "lever"]
    rng = np.random.default_rng(0)
    start = two.close_loops(rng.uniform(-0.4, 0.4, (20, 4)), hold=["shoulder", "lever"])
    assert start
    qd = two.rates(start.q, rng.normal(size=(20, 4)))
    tau = rng.normal(size=(20, 4))
    theirs = two.forward_dynamics(start.q, qd, tau).qdd
    found = one.forward_dynamics(start.q[:, order], qd[:, order], tau[:, order]).qdd
    assert one.error(start.q[:, order]).max() < 1e-12
    assert np.abs(found - theirs[:, order]).max() < 1e-8 * np.abs(theirs).max()


def test_without_the_file_it_is_a_tree(tmp_path):
    mechanism = mf.load(urdf(tmp_path, None)).mechanism
    assert not mechanism.loops
    (tmp_path / "other.toml").write_text(LOOP)
    closed = with_loops(mechanism, tmp_path / "other.toml")
    assert [loop.name for loop in closed.loops] == ["rod end"]
    assert closed.provenance.notes[-1] == "other.toml closes loops: rod end"
    assert closed.tip == mechanism.tip


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "loop"),
        ("loop = 3", "loop"),
        ("[[loop]]\nname = 'a'\nkind = 'ball'\nparent = 'rod'\nchild = 'forearm'", "spherical"),
        ("[[loop]]\nname = 'a'\nkind = 'fixed'\nparent = 'rood'\nchild = 'forearm'", "column, upper"),
        ("[[loop]]\nname = 'a'\nkind = 'fixed'\nparent = 'rod'", "child is missing"),
        ("[[loop]]\nkind = 'fixed'\nparent = 'rod'\nchild = 'forearm'", "name is missing"),
        (LOOP + "at = 3", "at"),
        (LOOP.replace("[0, 0, 0.4]", "[0, 0]"), r"parent_at: xyz"),
        (LOOP.replace("[0, 0, 0.4]", "[0, 0, nan]"), r"parent_at: xyz"),
        (LOOP.replace("xyz = [0, 0, 0.4]", "yaw = 3"), "yaw"),
        (LOOP.replace("spherical", "revolute") + "axis = [0, 3, 0]", "length 3"),
        (LOOP.replace("spherical", "helical") + "pitch = true", "pitch"),
        (LOOP + LOOP.partition("\n")[2], "two links are called"),
        (LOOP.replace('"lever"]', '"levver"]'), "driven"),
        ("[[loop]", "TOML"),
    ],
)
def test_bad_files_are_named(text, said, tmp_path):
    with pytest.raises(FileError, match=said):
        mf.load(urdf(tmp_path, text))


def xacro(folder: Path) -> Path:
    """The same arm with its lengths as a property and its bars from a macro."""
    plain = urdf(folder, None).read_text()
    (folder / "arm.urdf").unlink()
    text = plain.replace('<robot name="palletiser">', '<robot name="palletiser" xmlns:xacro="http://www.ros.org/wiki/xacro">'
                         '<xacro:property name="reach" value="${2 * 0.2}"/>')  # fmt: skip
    path = folder / "arm.xacro"
    path.write_text(text.replace('<origin xyz="0 0 0.4"/>', '<origin xyz="0 0 ${reach}"/>'))
    return path


def sdf(folder: Path) -> Path:
    """The same arm in SDFormat, every pose given against the link before."""
    text = '<sdf version="1.9"><model name="palletiser"><link name="column"/>'
    for name, (parent, xyz, joint, mass, com, (x, y, z)) in BODIES.items():
        place, middle = (" ".join(map(str, each)) for each in (xyz, com))
        text += (
            f'<link name="{name}"><pose relative_to="{parent}">{place} 0 0 0</pose><inertial><mass>{mass}</mass>'
            f"<pose>{middle} 0 0 0</pose><inertia><ixx>{x}</ixx><iyy>{y}</iyy><izz>{z}</izz></inertia>"
            f'</inertial></link><joint name="{joint}" type="continuous"><parent>{parent}</parent><child>{name}</child>'
            "<axis><xyz>0 1 0</xyz></axis></joint>"
        )
    stand = '<joint name="stand" type="fixed"><parent>world</parent><child>column</child></joint></model></sdf>'
    path = folder / "arm.sdf"
    path.write_text(text + stand)
    return path


@pytest.mark.parametrize("written", [xacro, sdf])
def test_xacro_and_sdf_have_loops_beside_them_too(written, tmp_path):
    path = written(tmp_path)
    (tmp_path / "arm.loops.toml").write_text(LOOP)
    one = ClosedChain(mf.load(path, tip="forearm"))
    (tmp_path / "other").mkdir()
    two = ClosedChain(mf.load(urdf(tmp_path / "other"), tip="forearm"))
    assert [one.robot.joint_names[k] for k in one.actuated] == ["shoulder", "lever"]
    assert one.robot.joint_names == two.robot.joint_names
    rng = np.random.default_rng(1)
    q = two.close_loops(rng.uniform(-0.4, 0.4, (10, 4)), hold=["shoulder", "lever"]).q
    assert one.error(q).max() < 1e-12
    qd, tau = two.rates(q, rng.normal(size=(10, 4))), rng.normal(size=(10, 2))
    found, expected = one.forward_dynamics(q, qd, tau).qdd, two.forward_dynamics(q, qd, tau).qdd
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()


BALLS = """[[joint]]
name = "rod"
kind = "universal"
axis = [0, 1, 0]
second = [1, 0, 0]
[[joint]]
name = "elbow"
kind = "spherical"
[[joint]]
name = "lever"
kind = "cylindrical"
axis = [0, 1, 0]
"""


def test_joints_that_the_file_cannot_say(tmp_path):
    """A hinge is drawn in the place of a ball; loops name joints instead of links."""
    loops = LOOP.replace('parent = "rod"', 'parent = "rod/axis2"').replace("parent_at", "# ")
    with pytest.raises(FileError, match="loop 1"):
        mf.load(urdf(tmp_path, loops + BALLS))
    arm = mf.load(urdf(tmp_path, LOOP.replace('child = "forearm"', 'child = "elbow"') + BALLS), tip="forearm")
    assert arm.n == 1 + 3 + 2 + 2
    assert {"rod", "rod/axis2", "elbow/axis3", "lever/axis2"} <= set(arm.joint_names)
    chain = ClosedChain(arm)
    assert [arm.joint_names[k] for k in chain.actuated] == ["shoulder", "lever"]
    assert mf.mobility(arm.mechanism).mobility == 8 - 3
    plain = mf.load(urdf(tmp_path), tip="forearm")
    q = ClosedChain(plain).close_loops([0.2, 0.3, -0.1, 0.4]).q
    wide = np.zeros(arm.n)
    for name, value in zip(plain.joint_names, q, strict=True):
        wide[arm.joint_names.index({"elbow": "elbow/axis2", "lever": "lever/axis2"}.get(name, name))] = value
    assert chain.error(wide) < 1e-12
    assert np.allclose(arm.forward_kinematics(wide), plain.forward_kinematics(q), atol=1e-12)


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ('[[joint]]\nname = "knee"\nkind = "spherical"', "'knee'"),
        ('[[joint]]\nname = "rod"\nkind = "planar"', "universal"),
        ('[[joint]]\nname = "rod"\nkind = "universal"\naxis = [0, 0, 2]', "rod"),
        ('[[joint]]\nname = "rod"\nkind = "universal"\nsecond = [0, 0, 1]', "rod"),
        ('[[joint]]\nname = "rod"\nkind = "spherical"\nrange = 3', "range"),
        ("joint = 3", "table"),
    ],
)
def test_wrong_joints_are_named(wrong, says, tmp_path):
    text = LOOP + wrong if wrong.startswith("[") else wrong + "\n" + LOOP
    with pytest.raises(FileError, match=says):
        mf.load(urdf(tmp_path, text))
