"""`lint`: every rule finds its fault and nothing else, with place, numbers, both languages and a repair that works."""

from __future__ import annotations

import json
from dataclasses import replace
from math import pi

import numpy as np
import pytest

import mafsil as mf
from mafsil import messages
from mafsil.cli.main import main
from mafsil.errors import FileError, InputError
from mafsil.model import Actuator, Inertial, Joint, JointKind, Limits, Link, Mechanism, Mimic, library
from mafsil.model.diagnostics import Severity
from mafsil.model.link import Box, Mesh, Shape, Sphere
from mafsil.model.lint import FAULTS, findings, lint, repair

HEAD = '<?xml version="1.0"?>\n<robot name="arm">\n  <link name="base"/>\n'
BODY = """  <link name="{name}">
    <inertial><origin xyz="{com}"/><mass value="{mass}"/><inertia {inertia}/></inertial>
    <visual><origin xyz="0.2 0 0"/><geometry>{shape}</geometry></visual>
    <collision><origin xyz="0.2 0 0"/><geometry>{shape}</geometry></collision>
  </link>
"""
JOINT = """  <joint name="{name}" type="{kind}">
    <origin xyz="0 0 {height}"/><parent link="{parent}"/><child link="{child}"/><axis xyz="{axis}"/>
    <limit lower="{lower}" upper="{upper}" velocity="{velocity}" effort="20"/>
  </joint>
"""
BOX = '<box size="0.4 0.1 0.06"/>'
SIZE = np.array([0.4, 0.1, 0.06])
MASS = 4.0


def moments(matrix) -> str:
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = np.asarray(matrix).tolist()
    return f'ixx="{xx!r}" ixy="{xy!r}" ixz="{xz!r}" iyy="{yy!r}" iyz="{yz!r}" izz="{zz!r}"'


def box_inertia(mass: float = MASS) -> np.ndarray:
    return mass / 12 * np.diag((SIZE**2).sum() - SIZE**2)


def urdf(**changes) -> str:
    """A sound arm of two links, or one with a mistake."""
    body = {"com": "0.2 0 0", "mass": MASS, "inertia": moments(box_inertia()), "shape": BOX}
    joint = {"kind": "revolute", "axis": "0 0 1", "lower": -2.0, "upper": 2.0, "velocity": 3.0, "height": 0.1}
    body |= {key: value for key, value in changes.items() if key in body}
    joint |= {key: value for key, value in changes.items() if key in joint}
    text = HEAD + BODY.format(name="one", **body) + BODY.format(name="two", **(body | changes.get("two", {})))
    text += JOINT.format(name="first", parent="base", child="one", **joint)
    text += JOINT.format(
        name="second", parent="one", child="two", **(joint | {"axis": "0 1 0"} | changes.get("j2", {}))
    )
    return text + "</robot>\n"


def plausible(report) -> list[str]:
    return [code for code in report.codes if code.startswith("P")]


def shifted() -> np.ndarray:
    c = np.array([0.2, 0.0, 0.0])
    return box_inertia() + MASS * (c @ c * np.eye(3) - np.outer(c, c))


MISTAKES = {
    "P0801": {"mass": 100.0, "inertia": moments(box_inertia(100.0))},
    "P0802": {"mass": 0.05, "inertia": moments(box_inertia(0.05))},
    "P0803": {"mass": 1e3 * MASS, "inertia": moments(box_inertia(1e3 * MASS))},
    "P0810": {"com": "0.9 0 0"},
    "P0811": {"com": "-0.2 0 0"},
    "P0812": {"inertia": moments(shifted())},
    "P0813": {"inertia": moments(box_inertia() * 50)},
    "P0814": {"inertia": moments(box_inertia() * 1e-4)},
    "P0815": {"inertia": moments(box_inertia() * 1e6)},
    "P0820": {"mass": 1.0, "inertia": moments(np.eye(3))},
    "P0901": {"lower": -170, "upper": 170},
    "P0902": {"lower": -170, "upper": 170, "velocity": 120},
    "P0903": {"kind": "prismatic", "lower": -500, "upper": 500},
    "P0904": {"velocity": 1e5},
    "P0907": {"lower": 0.5},
    "P0910": {"axis": "0.0099995 0 0.99995000374"},
    "P0911": {"j2": {"axis": "0 0 -1", "height": 0.0}},
    "P0913": {"j2": {"axis": "0 0 1"}},
}
REPAIRED = ("P0803", "P0811", "P0815", "P0901", "P0902", "P0903")


def write(tmp_path, **changes):
    path = tmp_path / "arm.urdf"
    path.write_text(urdf(**changes), encoding="utf-8")
    return path


@pytest.mark.capability("09-1", "09-29")
def test_a_sound_arm_is_clean(tmp_path) -> None:
    report = lint(write(tmp_path))
    assert not report.errors
    assert plausible(report) == []


@pytest.mark.parametrize("code", MISTAKES)
def test_each_mistake_is_found_at_its_place(tmp_path, code: str) -> None:
    changes = dict(MISTAKES[code])
    if code == "P0911":
        path = tmp_path / "arm.urdf"
        path.write_text(urdf(**changes).replace('xyz="0 0 0.0"', 'xyz="0.4 0 0"'), encoding="utf-8")
    else:
        path = write(tmp_path, **changes)
    report = lint(path)
    found = [item for item in report if item.code == code]
    assert found, report.codes
    lines = path.read_text().splitlines()
    for item in found:
        assert item.line > 0
        assert any(
            word in lines[item.line - 1] for word in ("inertia", "mass", "limit", "axis", "origin", "link", "joint")
        )
        english, arabic = item.sentence("en"), item.sentence("ar")
        assert english != arabic
        assert any(name in english for name in ("one", "two", "first", "second"))
        assert "{" not in english + arabic


FROM_THE_READER = {
    "I0502": (
        f'<mass value="4.0"/><inertia {moments(box_inertia())}/>',
        f'<mass value="0"/><inertia {moments(np.zeros((3, 3)))}/>',
    ),
    "I0508": ('<mass value="4.0"/>', '<mass value="0"/>'),
    "I0506": (moments(box_inertia()), moments(np.diag([1e-2, 1e-2, 5e-2]))),
    "P0916": ('    <limit lower="-2.0" upper="2.0" velocity="3.0" effort="20"/>\n', ""),
    "P0917": (' effort="20"', ""),
    "J0411": ('lower="-2.0" upper="2.0" ', ""),
}


@pytest.mark.capability("09-29")
@pytest.mark.parametrize("code", FROM_THE_READER)
def test_masses_moments_and_limits_of_files(tmp_path, code: str) -> None:
    """Mass 0, the triangle inequality, missing limits: the reader's own remarks, each with a place and what to do."""
    path = tmp_path / "arm.urdf"
    path.write_text(urdf().replace(*FROM_THE_READER[code], 1))
    item = next(item for item in lint(path) if item.code == code)
    assert item.line > 0
    assert ";" in item.sentence("en")
    assert "؛" in item.sentence("ar")


def test_every_remark_says_what_to_do() -> None:
    """A name for the part, what is wrong with its numbers, and after that what to do about it."""
    for fault in FAULTS.values():
        for language, marks in (("en", ";:,"), ("ar", "؛:،")):
            assert any(mark in messages.template(fault.key, language) for mark in marks), fault.code


@pytest.mark.parametrize("code", REPAIRED)
def test_repairs_take_the_mistake_away(tmp_path, code: str) -> None:
    path = write(tmp_path, **MISTAKES[code])
    before = path.read_text()
    text, changes = repair(path, only=[code])
    assert path.read_text() == before, "the file itself is never touched"
    assert code in [change.diagnostic.code for change in changes]
    assert all(change.sentence("en") != change.sentence("ar") for change in changes)
    mended = tmp_path / "mended.urdf"
    mended.write_text(text, encoding="utf-8")
    assert code not in lint(mended).codes


def test_degrees_become_radians_and_kilograms_stay_kilograms(tmp_path) -> None:
    text, _ = repair(write(tmp_path, **MISTAKES["P0902"]), only=["P0901", "P0902"])
    joint = mf.model.urdf.read(text).joints[0]
    assert joint.limits.upper == pytest.approx(170 * pi / 180, abs=1e-12)
    assert joint.limits.velocity == pytest.approx(120 * pi / 180, abs=1e-12)
    text, _ = repair(write(tmp_path, **MISTAKES["P0815"]), only=["P0815"])
    np.testing.assert_allclose(mf.model.urdf.read(text).links[1].inertial.inertia, box_inertia(), rtol=1e-12)
    text, _ = repair(write(tmp_path, **MISTAKES["P0811"]), only=["P0811"])
    np.testing.assert_allclose(mf.model.urdf.read(text).links[1].inertial.com, [0.2, 0, 0])
    assert repair(write(tmp_path))[1] == ()


def test_an_impossible_inertia_about_the_frame_is_shifted(tmp_path) -> None:
    """Far from the frame no distribution inside the shape has it, so the repair is offered; nearby only the remark."""
    far, c = "2 0 0", np.array([2.0, 0.0, 0.0])
    wrong = box_inertia() + MASS * (c @ c * np.eye(3) - np.outer(c, c))
    text = urdf(com=far, inertia=moments(wrong)).replace('origin xyz="0.2 0 0"', 'origin xyz="2 0 0"')
    path = tmp_path / "far.urdf"
    path.write_text(text.replace("<inertial><origin", '<inertial><origin rpy="0 0 0"'), encoding="utf-8")
    corrected, changes = repair(path, only=["P0812"])
    assert {change.diagnostic.code for change in changes} >= {"P0812"}
    np.testing.assert_allclose(mf.model.urdf.read(corrected).links[1].inertial.inertia, box_inertia(), atol=1e-12)
    near = lint(write(tmp_path, inertia=moments(shifted())))
    assert all(item.repair is None for item in near if item.code == "P0812")


def test_one_number_copied_to_all_links_is_no_unit(tmp_path) -> None:
    """Two links with the same stand-in are one witness, and another sound inertia outvotes it."""
    third = replace(hand_built().links[2], name="three", inertial=Inertial(MASS, np.array([0.2, 0, 0]), box_inertia()))
    stand_in = Inertial(MASS, np.array([0.2, 0, 0]), 1e3 * box_inertia())
    built = hand_built(two={"inertial": stand_in})
    links = [built.links[0], replace(built.links[1], inertial=stand_in), built.links[2], third]
    joints = [*built.joints, replace(built.joints[1], name="third", parent="two", child="three")]
    codes = lint(Mechanism.assemble("stand-ins", links, joints)).codes
    assert "P0813" in codes
    assert "P0815" not in codes


def test_meshes_in_millimetres(tmp_path) -> None:
    corners = np.array([[x, y, z] for x in (0, 400) for y in (-50, 50) for z in (-30, 30)], float)
    quads = ((1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4))
    obj = [f"v {x} {y} {z}" for x, y, z in corners]
    obj += [f"f {a} {b} {c}\nf {a} {c} {d}" for a, b, c, d in quads]
    (tmp_path / "arm.obj").write_text("\n".join(obj) + "\n")
    text = urdf(shape='<mesh filename="arm.obj"/>').replace('<origin xyz="0.2 0 0"/><geometry', "<geometry")
    path = tmp_path / "arm.urdf"
    path.write_text(text)
    assert plausible(lint(path)) == ["P0804", "P0804"]
    corrected, changes = repair(path, only=["P0804"])
    assert len(changes) == 2
    path.write_text(corrected)
    assert plausible(lint(path)) == []
    assert 'scale="0.001 0.001 0.001"' in corrected


LIGHT = Inertial(1e-3, np.array([0.2, 0, 0]), box_inertia(1e-3))


def hand_built(**options) -> Mechanism:
    body = Inertial(MASS, np.array([0.2, 0, 0]), box_inertia())
    shape = Shape(Box(tuple(SIZE)), np.array([[1, 0, 0, 0.2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]]))
    links = [Link("base"), Link("one", body, (shape,), (shape,)), Link("two", body, (shape,), (shape,))]
    joints = [
        Joint("first", JointKind.REVOLUTE, "base", "one", limits=Limits(-1, 1, 2, effort=5)),
        Joint(
            "second", JointKind.REVOLUTE, "one", "two", axis=np.array([0, 1.0, 0]), limits=Limits(-1, 1, 2, effort=5)
        ),
    ]
    joints[1] = replace(joints[1], **options.pop("second", {}))
    links[2] = replace(links[2], **options.pop("two", {}))
    return Mechanism.assemble("hand", links, joints, **options)


@pytest.mark.capability("09-29")
@pytest.mark.parametrize(
    ("code", "options"),
    [
        ("I0504", {"two": {"inertial": Inertial(1.0, np.zeros(3), np.diag([-1.0, 1, 1]))}}),
        ("I0505", {"two": {"inertial": Inertial(1.0, np.zeros(3), np.diag([-0.001, 1, 1]))}}),
        ("I0506", {"two": {"inertial": Inertial(1.0, np.zeros(3), np.diag([1.0, 1, 9]))}}),
        ("I0507", {"two": {"inertial": Inertial(1.0, np.zeros(3))}}),
        ("I0508", {"two": {"inertial": Inertial(0.0, np.zeros(3), np.eye(3))}}),
        ("P0905", {"second": {"limits": Limits()}}),
        ("P0906", {"second": {"limits": Limits(-1, 1, 0.0)}}),
        ("P0914", {"two": {"inertial": None}}),
        ("P0914", {"two": {"inertial": Inertial(1.0, np.array([0, 0.1, 0]), np.diag([0.01, 0.0, 0.01]))}}),
        ("P0822", {"two": {"inertial": LIGHT, "visuals": (), "collisions": ()}}),
        ("P1001", {"gravity": (0, 0, 9.81)}),
        ("P1002", {"gravity": (0, 0, -9810.0)}),
    ],
)  # fmt: skip
def test_robots_made_by_hand(code: str, options: dict) -> None:
    report = lint(hand_built(**options))
    assert code in report.codes, report.codes
    item = next(item for item in report if item.code == code)
    assert item.line == 0
    assert item.sentence("ar") != item.sentence("en")
    assert (item.severity is Severity.ERROR) == (code == "I0504")


def test_a_sound_hand_built_robot_is_clean() -> None:
    assert lint(hand_built()).codes == ()
    assert mf.lint(mf.Robot(hand_built())).codes == ()
    motor = {"two": {"inertial": None}, "second": {"actuator": Actuator(armature=1.0)}}
    assert "P0914" not in lint(hand_built(**motor)).codes
    bare = Mechanism.assemble("bare", [Link("a"), Link("b")], [Joint("j", JointKind.REVOLUTE, "a", "b", wraps=True)])
    assert lint(bare).codes == ("P1003",)
    drawn = hand_built(two={"collisions": ()})
    first = replace(drawn.links[1], collisions=())
    assert "P0830" in lint(replace(drawn, links=(drawn.links[0], first, drawn.links[2]))).codes


def test_copied_mass_properties() -> None:
    ball = (Shape(Sphere(0.2)),)
    assert "P0821" in lint(hand_built(two={"visuals": ball, "collisions": ball})).codes


def pair(right_axis, right_limits: Limits, kind: JointKind = JointKind.REVOLUTE) -> Mechanism:
    """A left and a right arm, mirrored at the x-z plane."""
    joints = []
    for side, y, axis, limits in (
        ("left", 0.3, (1, 0, 0), Limits(-0.2, 2.0)),
        ("right", -0.3, right_axis, right_limits),
    ):
        T = np.eye(4)
        T[1, 3] = y
        joints.append(
            Joint(f"{side}_shoulder", kind, "torso", f"{side}_arm", T_pj=T, axis=np.array(axis, float), limits=limits)
        )
    return Mechanism.assemble("torso", [Link("torso"), Link("left_arm"), Link("right_arm")], joints)


@pytest.mark.parametrize(
    ("axis", "limits", "wrong"),
    [
        ((-1, 0, 0), Limits(-0.2, 2.0), False),
        ((1, 0, 0), Limits(-2.0, 0.2), False),
        ((1, 0, 0), Limits(-0.2, 2.0), True),
        ((-1, 0, 0), Limits(-2.0, 0.2), True),
        ((1, 0, 0), Limits(-2.0, 0.9), False),
        ((0, 0, 1), Limits(-0.2, 2.0), False),
        ((1, 0, 0), Limits(), False),
    ],
)
def test_mirror_images(axis, limits: Limits, wrong: bool) -> None:
    """A turn reflects as an axial vector: mirrored axes have equal ranges, equal ones along the mirror reversed."""
    assert ("P0912" in lint(pair(axis, limits)).codes) is wrong


def test_slides_reflect_as_arrows() -> None:
    assert "P0912" not in lint(pair((1, 0, 0), Limits(-0.2, 2.0), JointKind.PRISMATIC)).codes
    assert "P0912" in lint(pair((-1, 0, 0), Limits(-0.2, 2.0), JointKind.PRISMATIC)).codes


def test_a_leader_that_drives_its_follower_beyond_its_range() -> None:
    good = hand_built(second={"mimic": Mimic("first", 0.5), "limits": Limits(-0.5, 0.5)})
    assert "P0908" not in lint(good).codes
    assert "P0908" in lint(hand_built(second={"mimic": Mimic("first", -3.0), "limits": Limits(-0.5, 0.5)})).codes


EXPLAINED = {
    "puma560": {"I0506", "I0508"},  # published moments; the column's mass was never measured
    "planar2r_point_masses": {"I0507"},  # point masses are its purpose
}


@pytest.mark.parametrize("name", library.robots())
def test_robots_of_the_library_are_plausible(name: str) -> None:
    """Notes only: unknown ranges (textbook arms), zero outside the range (Panda); what is more is explained."""
    report = mf.lint(name)
    assert not report.errors
    assert {item.code for item in report.warnings} == EXPLAINED.get(name, set())
    assert {item.code for item in report if item.severity is Severity.INFO} <= {"P0905", "P0907", "P0911"}


def test_published_files(monkeypatch: pytest.MonkeyPatch) -> None:
    """Files of example-robot-data without large meshes: what is known to be wrong in them stays found."""
    from tests.model.urdf.real_files import FOLDER

    if not FOLDER.exists():
        pytest.skip("example-robot-data is not installed")
    found = {}
    for name in ("double_pendulum", "ur5_robot", "panda"):
        path = next(iter(sorted(FOLDER.rglob(f"{name}.urdf"))), None)
        if path is not None:
            found[name] = lint(path)
            assert not found[name].errors
    assert found


def test_every_code_has_both_languages_and_is_raised_here() -> None:
    for fault in FAULTS.values():
        assert messages.template(fault.key, "en") != messages.template(fault.key, "ar")
    by_hand = {
        "P0804",
        "P0821",
        "P0822",
        "P0830",
        "P0905",
        "P0906",
        "P0908",
        "P0912",
        "P0914",
        "P0915",
        "P0916",
        "P0917",
        "P1001",
        "P1002",
        "P1003",
    }
    assert set(FAULTS) == {*MISTAKES, *by_hand}


def test_wrong_arguments(tmp_path) -> None:
    with pytest.raises(InputError, match="lint takes"):
        lint(3.0)  # type: ignore[arg-type]
    with pytest.raises(FileError, match="no such file"):
        lint("no_such_robot")
    with pytest.raises(InputError, match="not a plain URDF"):
        repair("panda")
    assert lint(tmp_path / "none.urdf").errors
    broken = tmp_path / "broken.urdf"
    broken.write_text("<robot name='x'><link name='a'>")
    assert lint(broken).errors


def test_mesh_that_cannot_be_read_says_nothing(tmp_path) -> None:
    shape = (Shape(Mesh("gone.stl", tmp_path / "gone.stl")),)
    own = Inertial(2 * MASS, np.array([0.2, 0, 0]), box_inertia(2 * MASS))
    assert list(findings(hand_built(two={"inertial": own, "visuals": shape, "collisions": shape}))) == []


def test_command(tmp_path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(tmp_path, **MISTAKES["P0902"])
    out = tmp_path / "out.urdf"
    assert main(["lint", str(path), "--fix", str(out), "--only", "P0901", "P0902"]) == 0
    text = capsys.readouterr().out
    assert "P0901" in text
    assert "radians" in text
    assert "P0901" not in lint(out).codes
    assert main(["lint", str(path), "--json", "--lang", "ar"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["diagnostics"][0]["sentence"]["ar"]
    assert main(["lint", "iiwa7", "--lang", "en"]) == 0
    assert "no remarks" in capsys.readouterr().out
    path.write_text(urdf(mass=-1.0))
    assert main(["lint", str(path)]) == 1
    assert "errors" in capsys.readouterr().err
    assert main(["lint", "panda", "--fix", str(out)]) == 2
    assert main(["lint", str(write(tmp_path)), "--fix", str(tmp_path / "no" / "x.urdf")]) == 2
    assert main(["lint", str(write(tmp_path)), "--fix", str(out)]) == 0
