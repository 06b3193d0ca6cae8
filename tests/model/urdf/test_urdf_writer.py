"""What URDF can keep comes back to the last bit or so; what it cannot keep is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mafsil.errors import ModelError
from mafsil.model import Friction, Joint, JointKind, Limits, Link, Mechanism, urdf
from mafsil.model.placement import pose_from_xyz_rpy, rpy_from_rotation
from mafsil.model.urdf.writer import is_endless
from tests.model.urdf.hostile_files import CASES
from tests.model.urdf.real_files import robots
from tests.sizes import few


def two_links(**changes: object) -> Mechanism:
    joint = Joint("j", JointKind.REVOLUTE, "a", "b", limits=Limits(-1, 1, 2, effort=3))
    return Mechanism.assemble("r", [Link("a"), Link("b")], [replace(joint, **changes)])


def assert_same(first: Mechanism, second: Mechanism) -> None:
    assert first.link_names == second.link_names
    assert first.joint_names == second.joint_names
    assert first.parents == second.parents
    for a, b in zip(first.joints, second.joints, strict=True):
        np.testing.assert_allclose(b.T_pj, a.T_pj, rtol=0, atol=1e-15)
        if a.moves:
            np.testing.assert_allclose(b.axis, a.axis, rtol=0, atol=1e-15)
        assert is_endless(a) == is_endless(b), a.name
        for name in ("name", "kind", "limits", "mimic", "friction", "actuator"):
            assert getattr(a, name) == getattr(b, name), (a.name, name)
    for a, b in zip(first.links, second.links, strict=True):
        assert (a.inertial is None) == (b.inertial is None)
        if a.inertial is not None and b.inertial is not None:
            assert a.inertial.mass == b.inertial.mass
            np.testing.assert_array_equal(a.inertial.com, b.inertial.com)
            np.testing.assert_array_equal(a.inertial.inertia, b.inertial.inertia)
        for ours, theirs in ((a.visuals, b.visuals), (a.collisions, b.collisions)):
            assert [(s.name, s.colour) for s in ours] == [(s.name, s.colour) for s in theirs]
            for s, t in zip(ours, theirs, strict=True):
                np.testing.assert_allclose(s.T_lg, t.T_lg, rtol=0, atol=1e-15)


@pytest.mark.parametrize("path", few(robots(), 14), ids=lambda path: path.stem)
def test_real_robots_come_back(path: Path) -> None:
    mechanism = urdf.read(path)
    assert_same(mechanism, urdf.read(urdf.write(mechanism)))


@pytest.mark.parametrize("case", [case for case in CASES if case.accepted], ids=lambda case: case.name)
def test_hostile_but_accepted_files_come_back(case: object) -> None:
    mechanism = urdf.read(case.data)
    if case.code != "S0302":
        assert_same(mechanism, urdf.read(urdf.write(mechanism)))


@pytest.mark.parametrize("name", ["ذراع", "a & b", "<a>", 'a"b', "a'b", "a/b"])
def test_names_are_escaped(name: str) -> None:
    mechanism = Mechanism.assemble(name, [Link(name), Link("b")], [Joint(name, JointKind.FIXED, name, "b")])
    assert urdf.read(urdf.write(mechanism)).link_names == (name, "b")


def test_one_sided_range_comes_back() -> None:
    mechanism = two_links(limits=Limits(lower=-1.0))
    assert urdf.read(urdf.write(mechanism)).joints[0].limits == Limits(lower=-1.0)


def test_tip_and_base_pose_become_links() -> None:
    T = pose_from_xyz_rpy([1, 2, 3], [0.1, 0.2, 0.3])
    joint = Joint("j", JointKind.REVOLUTE, "a", "tip")
    mechanism = Mechanism.assemble("r", [Link("a"), Link("tip")], [joint], T_lt=T, T_sb=T)
    again = urdf.read(urdf.write(mechanism))
    assert again.link_names == ("space", "a", "tip", "tip_")
    assert again.tip == "tip_"
    for fixed in (again.joints[0], again.joints[-1]):
        np.testing.assert_allclose(fixed.T_pj, T, rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"kind": JointKind.HELICAL, "pitch": 0.1}, None),
        ({"name": "a\nb"}, None),
        ({"actuated": False}, "passive"),
        ({"friction": Friction(coulomb=1.0, coulomb_negative=2.0)}, "friction"),
    ],
)
def test_what_urdf_cannot_keep_is_refused(changes: dict[str, object], what: str | None) -> None:
    mechanism = two_links(**changes)
    with pytest.raises(ModelError) as caught:
        urdf.write(mechanism)
    assert caught.value.message("en") != caught.value.message("ar")
    if what is not None:
        assert urdf.read(urdf.write(mechanism, without=[what])).n == 1


def test_loops_and_gravity_are_refused() -> None:
    mechanism = two_links()
    with pytest.raises(ModelError, match="loop"):
        urdf.write(replace(mechanism, loops=(Joint("k", JointKind.REVOLUTE, "b", "a"),)))
    lunar = mechanism.with_gravity(np.array([0.0, 0.0, -1.62]))
    with pytest.raises(ModelError, match="gravity"):
        urdf.write(lunar)
    assert "gravity" in urdf.write(lunar, without=["gravity"]).partition("-->")[0]
    assert_same(mechanism, urdf.read(urdf.write(lunar, without=["gravity"])))


@pytest.mark.parametrize("pitch", [0.0, 1.0, np.pi / 2, -np.pi / 2, np.pi / 2 - 1e-8, np.pi / 2 - 1e-13, 3.0])
@pytest.mark.parametrize("seed", range(5))
def test_angles_at_the_gimbal(pitch: float, seed: int) -> None:
    roll, yaw = np.random.default_rng(seed).uniform(-np.pi, np.pi, 2)
    R = pose_from_xyz_rpy([0, 0, 0], [roll, pitch, yaw])[:3, :3]
    again = pose_from_xyz_rpy([0, 0, 0], rpy_from_rotation(R))[:3, :3]
    np.testing.assert_allclose(again, R, rtol=0, atol=1e-15)
