"""What we write is read by the tools it is for: Pinocchio (urdfdom) and MuJoCo compute the same from it."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from mafsil.arrays import frozen
from mafsil.errors import ModelError
from mafsil.model import Inertial, Joint, JointKind, Link, Mechanism, library, mjcf, urdf
from tests.model.peer_readers import Reader, by_mujoco, by_pinocchio, differences, text_of
from tests.model.random_robots import random_robot
from tests.model.urdf.real_files import robots
from tests.sizes import few

NEAR = 1e-10
"""MuJoCo gets 1e-12 kg where a moving body has no mass."""
IMPOSSIBLE = {"allegro_left_hand", "allegro_right_hand", "icub_reduced", "pr2", "romeo_small", "romeo_laas_small"}
"""Published robots with inertias that no body has, where no shift along joint axes mends them."""
MOST_JOINTS = 30
"""Of a published robot that is compared here."""
TOOLS: list[tuple[ModuleType, Reader]] = [(urdf, by_pinocchio), (mjcf, by_mujoco)]
REFUSED = {
    ("planar2r", urdf): "gravity",
    ("planar2r_point_masses", urdf): "gravity",
    ("planar3r", urdf): "gravity",
    ("puma560", urdf): "friction",
    ("puma560", mjcf): "friction",
}
"""Arms of the library whose motion would be another one in a format, and what would be lost."""


@pytest.mark.parametrize(("tool", "reader"), TOOLS, ids=["urdf", "mjcf"])
@pytest.mark.parametrize("name", library.robots())
def test_library_arms(name: str, tool: ModuleType, reader: Reader) -> None:
    mechanism, lost = library.load(name), REFUSED.get((name, tool))
    if lost is None:
        text = tool.write(mechanism)
    else:
        with pytest.raises(ModelError) as caught:
            tool.write(mechanism)
        assert caught.value.details["what"] == lost
        text = tool.write(mechanism, without=[lost])
    assert max(differences(mechanism, text, reader).values()) < NEAR


@pytest.mark.parametrize(("tool", "reader"), TOOLS, ids=["urdf", "mjcf"])
@pytest.mark.parametrize("seed", few(range(200), 20))
def test_random_robots(seed: int, tool: ModuleType, reader: Reader) -> None:
    mechanism = random_robot(seed)
    worst = differences(mechanism, text_of(mechanism, tool), reader, seed)
    assert max(worst.values()) < NEAR, worst


def test_a_tip_on_a_frame_on_the_base() -> None:
    """The frame carries a body, the tip's, so that MJCF has no site for it."""
    turned = frozen(np.diag([1.0, -1.0, -1.0, 1.0]))
    links = [Link("base"), Link("arm", Inertial(1.0, np.full(3, 0.1), np.eye(3))), Link("flange"), Link("camera")]
    joints = [
        Joint("hinge", JointKind.REVOLUTE, "base", "arm", frozen(np.eye(4)), frozen(np.eye(3)[1])),
        Joint("mount", JointKind.FIXED, "base", "flange", turned),
        Joint("eye", JointKind.FIXED, "flange", "camera", turned),
    ]
    for tip in ("flange", "camera", "arm"):
        for T_lt in (np.eye(4), turned):
            mechanism = Mechanism.assemble("stand", links, joints, tip=tip, T_lt=T_lt)
            for tool, reader in TOOLS:
                assert max(differences(mechanism, text_of(mechanism, tool), reader).values()) < NEAR


SOME = {path.stem for path in few(robots(), 12)} | set(few(sorted(IMPOSSIBLE), 2))


@pytest.mark.parametrize(("tool", "reader"), TOOLS, ids=["urdf", "mjcf"])
@pytest.mark.parametrize(
    "path",
    [path for path in robots() if path.stem in SOME],
    ids=lambda path: path.stem,
)
def test_published_robots(path: Path, tool: ModuleType, reader: Reader) -> None:
    """Inertias that no body has and no shift mends are refused for MuJoCo, or the nearest are written."""
    mechanism = urdf.read(path)
    if not 0 < mechanism.n <= MOST_JOINTS:
        pytest.skip("too large for this test, or nothing moves")
    if tool is mjcf and path.stem in IMPOSSIBLE:
        with pytest.raises(ModelError) as caught:
            mjcf.write(mechanism)
        assert caught.value.details["what"] == "inertia"
        assert reader(mechanism, mjcf.write(mechanism, without=["inertia"]))
        return
    worst = differences(mechanism, tool.write(mechanism), reader)
    assert max(worst.values()) < NEAR, worst


@pytest.mark.parametrize("tool", [urdf, mjcf], ids=["urdf", "mjcf"])
@pytest.mark.parametrize("seed", few(range(0, 200, 4), 10))
def test_random_robots_come_back_to_us(seed: int, tool: ModuleType) -> None:
    """Limits that are known come back, those that are not stay so, and no mass is invented."""
    mechanism = random_robot(seed)
    text = text_of(mechanism, tool)
    again = tool.read(text)
    assert again.joint_names == mechanism.joint_names
    names = ("lower", "upper", "effort") if tool is mjcf else ("lower", "upper", "effort", "velocity", "acceleration")
    for name in names:
        np.testing.assert_array_equal(getattr(again.limits, name), getattr(mechanism.limits, name), name)
    bodies = {link.name: link.inertial for link in again.links}
    for link in mechanism.links:
        assert (bodies[link.name] is None) == (link.inertial is None), link.name
        if link.inertial is not None:
            assert bodies[link.name].mass == link.inertial.mass
    assert not {link.name for link in again.links if link.inertial} - set(mechanism.link_names)
    assert again.tip.rstrip("_") in (mechanism.tip, "tip", "tcp") or "default tip" in text
