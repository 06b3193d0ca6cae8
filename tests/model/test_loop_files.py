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
    with pytest.warns(mf.ModelWarning):
        other = mf.load(ROOT / "examples" / "robots" / "palletiser.xml")
    one, two = ClosedChain(ours), ClosedChain(other)
    names = [list(robot.joint_names) for robot in (ours, other)]
    order = [names[1].index(name) for name in names[0]]
    assert [ours.joint_names[k] for k in one.actuated] == ["shoulder", "lever"]
    rng = np.random.default_rng(0)
    start = two.closed(rng.uniform(-0.4, 0.4, (20, 4)), hold=["shoulder", "lever"])
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
