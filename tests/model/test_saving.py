"""Writing robots: one door, what is lost is named, and what a format can keep is kept."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest

import mafsil as mf
from mafsil.errors import FileError, InputError, ModelError, ModelWarning
from mafsil.model import (
    Actuator,
    Capsule,
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
    mjcf,
    sdf,
    table,
    urdf,
)
from mafsil.model.inertia_check import possible_inertias
from mafsil.model.losses import Weight
from mafsil.model.placement import pose_from_xyz_rpy
from tests.model.peer_readers import by_mujoco, by_pinocchio, differences


def arm(**changes: object) -> Mechanism:
    """Two links and a hinge, with mass."""
    body = Inertial(1.0, np.array([0.1, 0.0, 0.0]), np.diag([0.01, 0.02, 0.02]))
    joint = Joint("hinge", JointKind.REVOLUTE, "a", "b", limits=Limits(-1, 1, 2, effort=3))
    return Mechanism.assemble("arm", [Link("a"), Link("b", body)], [replace(joint, **changes)])


@pytest.mark.parametrize("suffix", [".urdf", ".sdf", ".world", ".xml", ".mjcf", ".toml"])
def test_the_ending_says_the_format(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"panda{suffix}"
    losses = mf.save(mf.load("panda"), path)
    again = mf.load(path)
    q = np.random.default_rng(1).uniform(-1, 1, (3, 7))
    np.testing.assert_allclose(again.gravity_torque(q), mf.load("panda").gravity_torque(q), rtol=0, atol=1e-13)
    head = path.read_text()[:2000]
    assert all(loss.sentence("en") in head for loss in losses)
    assert losses  # Of limits, or of shapes.


def test_names_paths_and_mechanisms_are_taken(tmp_path: Path) -> None:
    mf.save("ur5e", tmp_path / "a.urdf")
    mf.save(tmp_path / "a.urdf", str(tmp_path / "a.xml"))
    mf.save(mf.load(tmp_path / "a.xml").mechanism, tmp_path / "b.urdf")
    assert mf.load(tmp_path / "b.urdf").n == 6


def test_other_endings_are_refused_with_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"\.urdf.*\.sdf.*\.xml.*\.toml"):
        mf.save("panda", tmp_path / "panda.usd")
    with pytest.raises(FileError, match="cannot be written"):
        mf.save("panda", tmp_path / "nowhere" / "panda.urdf")
    with pytest.raises(InputError, match="limits"):
        mf.save("panda", tmp_path / "panda.urdf", without=["limit"])
    assert not list(tmp_path.iterdir())


def test_the_first_call_on_a_panda_gives_a_file_and_one_warning(tmp_path: Path) -> None:
    with pytest.warns(ModelWarning) as caught:
        mf.save("panda", tmp_path / "panda.urdf")
    assert len(caught) == 1
    assert "jerk limits need URDF 1.2" in str(caught[0].message)
    assert "joint1" in str(caught[0].message)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mf.save("panda", tmp_path / "quiet.urdf", without=["limits"])
    again, panda = mf.load(tmp_path / "panda.urdf"), mf.load("panda")
    for name in ("lower", "upper", "velocity", "acceleration", "jerk", "effort"):
        np.testing.assert_array_equal(getattr(again.limits, name), getattr(panda.limits, name))
    old = mf.load(tmp_path / "quiet.urdf")
    np.testing.assert_array_equal(old.limits.acceleration, panda.limits.acceleration)
    assert np.isinf(old.limits.jerk).all()
    texts = [(tmp_path / name).read_text() for name in ("panda.urdf", "quiet.urdf")]
    assert [pin.buildModelFromXML(text).nq for text in texts] == [7, 7]
    assert [text.splitlines()[1].endswith('name="panda" version="1.2">') for text in texts] == [True, False]


def test_urdf_is_of_the_first_version_where_no_jerk_is_known() -> None:
    text = urdf.write(arm(limits=Limits(-1, 1, acceleration=3.0)))
    assert "version" not in text.splitlines()[1]
    newer = urdf.write(arm(limits=Limits(acceleration=3.0, jerk=9.0)), without=[])
    limits = urdf.read(newer).joints[0].limits
    assert (limits.acceleration, limits.jerk, limits.effort) == (3.0, 9.0, np.inf)
    assert not urdf.diagnose(newer).errors


def test_one_signature_for_all_writers(tmp_path: Path) -> None:
    endings = ((urdf, "urdf"), (sdf, "sdf"), (sdf, "world"), (mjcf, "xml"), (table, "toml"))
    for writer, path in ((writer, tmp_path / f"a.{ending}") for writer, ending in endings):
        if path.suffix == ".world":
            assert writer.write("ur5e", path) == path.read_text() != writer.write("ur5e")
            continue
        assert writer.write("ur5e", path) == path.read_text() == writer.write("ur5e")


def test_a_typed_table_is_continuous_where_no_range_is_known() -> None:
    robot = mf.Robot.from_dh([[0, 90, 0.4, 0], [0.5, 0, 0, 0]], "classic", degrees=True)
    text = urdf.write(robot)
    assert text.count('type="continuous"') == 2
    assert "<limit" not in text
    assert pin.buildModelFromXML(text).nv == 2
    again = urdf.read(text)
    assert all(joint.limits == Limits() for joint in again.joints)


@pytest.mark.parametrize("kind", [JointKind.REVOLUTE, JointKind.PRISMATIC])
@pytest.mark.parametrize("known", [{}, {"lower": -1.0}, {"effort": 5.0}, {"velocity": 2.0}, {"acceleration": 9.0}])
def test_unknown_limits_stay_unknown(kind: JointKind, known: dict[str, float]) -> None:
    mechanism = arm(kind=kind, limits=Limits(**known))
    text = urdf.write(mechanism)
    assert urdf.read(text).joints[0].limits == Limits(**known)
    assert max(differences(mechanism, text, by_pinocchio).values()) < 1e-13
    if "1e+16" in text:
        assert "mafsil reads 1e16 as unlimited" in text


@pytest.mark.parametrize(
    ("changes", "what", "tool"),
    [
        ({"actuated": False}, "passive", urdf),
        ({"actuated": False}, "passive", mjcf),
        ({"friction": Friction(0.1, 1.0, 2.0)}, "friction", urdf),
        ({"friction": Friction(0.1, 1.0, 2.0, 0.5)}, "friction", mjcf),
    ],
)
def test_what_changes_the_motion_is_refused_by_name(changes: dict[str, object], what: str, tool: object) -> None:
    mechanism = arm(**changes)
    with pytest.raises(ModelError, match=f'hinge.*without=\\["{what}"\\]') as caught:
        tool.write(mechanism)
    assert caught.value.message("ar") != caught.value.message("en")
    back = tool.read(tool.write(mechanism, without=[what])).joints
    if what == "friction":
        assert [joint.friction for joint in back if joint.moves] == [Friction(0.1, 1.5)]


def test_only_what_is_lost_is_named() -> None:
    """Range and effort are kept; speed is what MJCF has no word for."""
    mechanism = arm()
    losses = mjcf.writer.document(mechanism).losses
    assert [(loss.key, loss.weight) for loss in losses] == [("writing.velocity", Weight.WARNED)]
    limits = mjcf.read(mjcf.write(mechanism, without=["limits"])).joints[-1].limits
    assert limits == Limits(-1, 1, effort=3)


@pytest.mark.parametrize("motor", [Actuator(1e-4, 100.0), Actuator(armature=0.3), Actuator(1e-4, 50.0, 0.2)])
def test_rotors_reach_urdf_in_the_words_of_drake(motor: Actuator) -> None:
    with pytest.warns(ModelWarning, match="drake:rotor_inertia"):
        text = urdf.write(arm(actuator=motor))
    found = urdf.read(text).joints[0].actuator
    assert found.reflected_inertia == pytest.approx(motor.reflected_inertia, rel=1e-15)
    assert found.gear_ratio == motor.gear_ratio


@pytest.mark.parametrize("tool", [urdf, mjcf], ids=["urdf", "mjcf"])
def test_a_tip_in_the_middle_is_said(tool: object) -> None:
    mechanism = library.load("elbow6r").with_tip("link2")
    with pytest.warns(ModelWarning, match='tip="link2"'):
        text = tool.write(mechanism)
    assert "<!--" in text
    assert tool.read(text).tip != "link2"


def test_a_robot_without_masses_is_for_kinematics_in_mujoco() -> None:
    robot = mf.Robot.from_dh([[0, 90, 0.4, 0], [0.5, 0, 0, 0]], "classic", degrees=True)
    with pytest.warns(ModelWarning, match="no masses.*meaningless"):
        text = mjcf.write(robot)
    assert differences(robot.mechanism, text, by_mujoco)["T"] < 1e-15
    assert not any(link.inertial for link in mjcf.read(text).links)


def test_a_joint_that_moves_nothing_is_named() -> None:
    joints = [Joint("first", JointKind.REVOLUTE, "a", "b"), Joint("idle", JointKind.REVOLUTE, "b", "c")]
    mechanism = Mechanism.assemble("arm", [Link("a"), Link("b", arm().links[1].inertial), Link("c")], joints)
    with pytest.warns(ModelWarning, match="idle move no mass"):
        text = mjcf.write(mechanism)
    assert mujoco.MjModel.from_xml_string(text).nv == 2
    driven = replace(mechanism, joints=(joints[0], replace(joints[1], actuator=Actuator(armature=0.1))))
    assert not any(loss.what == "mass" for loss in mjcf.writer.document(driven).losses)


def test_an_inertia_that_no_body_has_is_shifted_along_joint_axes() -> None:
    """The column and the forearm of the PUMA 560: no motion changes."""
    puma = library.load("puma560")
    possible, shifted, lacking = possible_inertias(puma)
    assert shifted == ("column", "upper_arm", "forearm")
    assert not lacking
    for link in possible.links[1:]:
        least, middle, largest = np.linalg.eigvalsh(link.inertial.inertia)
        assert largest <= (least + middle) * (1 + 1e-12)
    q, qd, qdd = np.random.default_rng(0).normal(size=(3, 50, 6))
    ours, theirs = (mf.Robot(m).inverse_dynamics(q, qd, qdd) for m in (puma, possible))
    np.testing.assert_allclose(theirs, ours, rtol=0, atol=1e-12)


def test_an_inertia_that_no_shift_mends_is_refused_by_name() -> None:
    joints = [Joint(f"j{k}", JointKind.REVOLUTE, f"l{k}", f"l{k + 1}") for k in range(3)]
    joints[1] = replace(joints[1], axis=np.array([0.0, 1.0, 0.0]))
    good = Inertial(1.0, np.array([0.1, 0.0, 0.0]), np.diag([0.01, 0.01, 0.01]))
    links = [
        Link("l0"),
        Link("l1", good),
        Link("l2", good),
        Link("l3", Inertial(1.0, inertia=np.diag([0.5, 0.1, 0.1]))),
    ]
    mechanism = Mechanism.assemble("arm", links, joints)
    with pytest.raises(ModelError, match=r'not physically consistent: l3.*without=\["inertia"\]'):
        mjcf.write(mechanism)
    model = mujoco.MjModel.from_xml_string(mjcf.write(mechanism, without=["inertia"]))
    assert model.body_inertia[-1].min() > 0.0
    assert max(differences(mechanism, urdf.write(mechanism), by_pinocchio).values()) < 1e-12


def test_names_in_comments_do_no_harm() -> None:
    name = "a--b-->--<joint>-"
    mechanism = arm(name=name, limits=Limits(-1, 1, jerk=3.0))
    for tool in (urdf, mjcf):
        assert tool.read(tool.write(mechanism)).joint_names == (name,)
    assert mujoco.MjModel.from_xml_string(mjcf.write(mechanism)).joint(0).name == name
    assert pin.buildModelFromXML(urdf.write(mechanism)).names[1] == name


def test_shapes_are_said_by_tables_and_named_once_in_mujoco() -> None:
    mechanism = arm()
    ball = Shape(Sphere(0.1), name="ball")
    shaped = replace(mechanism, links=tuple(replace(link, collisions=(ball,)) for link in mechanism.links))
    with pytest.warns(ModelWarning, match="a, b"):
        text = table.write(shaped)
    assert text.startswith("# Written by mafsil")
    assert table.parse(text).n == 1
    assert mujoco.MjModel.from_xml_string(mjcf.write(shaped)).ngeom == 2


def test_surfaces_in_files_are_said_to_be_left_out_of_mujoco() -> None:
    mechanism = arm()
    surface, ball = Shape(Mesh("package://arm/b.stl")), Shape(Sphere(0.1))
    links = (mechanism.links[0], replace(mechanism.links[1], visuals=(surface, ball)))
    with pytest.warns(ModelWarning, match="meshes in files are omitted: b"):
        text = mjcf.write(replace(mechanism, links=links))
    assert mujoco.MjModel.from_xml_string(text).ngeom == 1
    assert urdf.read(urdf.write(replace(mechanism, links=links))).links[1].visuals[0].geometry == surface.geometry


def test_followers_are_written_with_their_leader() -> None:
    fingers = [
        Joint("f1", JointKind.PRISMATIC, "p", "a"),
        Joint("f2", JointKind.PRISMATIC, "p", "b", mimic=Mimic("f1")),
    ]
    body = Inertial(0.1, inertia=np.eye(3) * 1e-4)
    mechanism = Mechanism.assemble("hand", [Link("p"), Link("a", body), Link("b", body)], fingers)
    for tool, reader in ((urdf, by_pinocchio), (mjcf, by_mujoco)):
        text = tool.write(mechanism)
        assert tool.read(text).n == 1
        assert max(differences(mechanism, text, reader).values()) < 1e-13


def test_capsules_reach_urdfdom_and_come_back() -> None:
    """URDF has no capsules; a colliding one of a name, and two drawn ones without."""
    T = pose_from_xyz_rpy((0.1, -0.2, 0.3), (0.4, 0.5, -0.6))
    capsules = [Shape(Capsule(0.05, 0.3), T, "tube"), Shape(Capsule(0.1, 0.2)), Shape(Capsule(0.1, 0.2), T)]
    mechanism = arm()
    links = (mechanism.links[0], replace(mechanism.links[1], collisions=tuple(capsules[:1]), visuals=tuple(capsules)))
    text = urdf.write(replace(mechanism, links=links))
    model = pin.buildModelFromXML(text)
    solids = pin.buildGeomFromUrdfString(model, text, pin.GeometryType.COLLISION).geometryObjects
    assert [type(solid.geometry).__name__ for solid in solids] == ["Cylinder", "Sphere", "Sphere"]
    back = urdf.read(text).links[1]
    for ours, theirs in ((capsules[:1], back.collisions), (capsules, back.visuals)):
        assert [(shape.geometry, shape.name) for shape in theirs] == [(shape.geometry, shape.name) for shape in ours]
        for one, two in zip(ours, theirs, strict=True):
            np.testing.assert_allclose(one.T_lg, two.T_lg, rtol=0, atol=1e-15)
    apart = text.replace('radius="0.05"', 'radius="0.06"', 1)
    assert len(urdf.read(apart).links[1].visuals) == 5
