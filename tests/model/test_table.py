"""Robot tables: what is written comes back, units become SI, and every fault is named with its line."""

import contextlib
from dataclasses import asdict, replace
from math import pi, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.errors import FileError, MafsilError, ModelError
from mafsil.model import Inertial, Joint, JointKind, Limits, Link, Mechanism, Mimic, library
from mafsil.model import table as table_package
from mafsil.model.denavit_hartenberg import DHRow, mechanism_from_dh
from mafsil.model.dh_from_axes import screws
from mafsil.model.exponentials import mechanism_from_screws
from mafsil.model.table import format_table, parse, read, write
from mafsil.model.table.reading import SIZE_LIMIT, line_of, toml_text


def assert_same(a, b, rtol=0.0, atol=0.0):
    def close(x, y):
        np.testing.assert_allclose(x, y, rtol=rtol, atol=atol)

    assert (a.name, a.link_names, a.joint_names, a.tip) == (b.name, b.link_names, b.joint_names, b.tip)
    assert a.provenance == b.provenance
    for ours, theirs in ((a.T_sb, b.T_sb), (a.T_lt, b.T_lt), (a.gravity, b.gravity)):
        close(ours, theirs)
    for i, j in zip(a.joints, b.joints, strict=True):
        assert (i.kind, i.actuator, i.friction) == (j.kind, j.actuator, j.friction)
        close(i.T_pj, j.T_pj)
        close(i.axis, j.axis)
        close([i.pitch, *asdict(i.limits).values()], [j.pitch, *asdict(j.limits).values()])
    for i, j in zip(a.links, b.links, strict=True):
        assert (i.inertial is None) == (j.inertial is None)
        if i.inertial is not None:
            assert i.inertial.mass == j.inertial.mass
            close(i.inertial.com, j.inertial.com)
            close(i.inertial.inertia, j.inertial.inertia)


# ---- round trips


@pytest.mark.parametrize("name", library.robots())
def test_every_robot_of_the_library_comes_back_to_the_last_bit(name, tmp_path):
    robot = library.load(name)
    write(robot, tmp_path / "robot.toml")
    assert_same(read(tmp_path / "robot.toml"), robot)


def test_helical_joints_and_oblique_axes_come_back():
    arm = mechanism_from_screws([[0, 0, 1, 0, -1, 0.1], [0.6, 0, 0.8, 0, 0, 0]], np.eye(4))
    oblique = replace(arm.joints[1], axis=np.array([0.6, 0.0, 0.8]), T_pj=np.eye(4))
    assert_same(parse(format_table(replace(arm, joints=(arm.joints[0], oblique)))), replace(
        arm, joints=(arm.joints[0], oblique)), atol=1e-16)  # fmt: skip


@given(st.text(max_size=30).filter(lambda text: text.strip() != ""))
def test_any_name_and_note_survives(text):
    text = text.encode("utf-8", "ignore").decode()
    robot = mechanism_from_dh([DHRow()], "modified", name=text, joint_names=["joint" + text])
    robot = replace(robot, provenance=replace(robot.provenance, source=text, notes=(text, "")))
    assert_same(parse(format_table(robot)), robot)


# ---- meaning


def test_the_example_of_the_documentation_is_a_robot():
    lines = table_package.__doc__.split("\n\n    ", 1)[1].split("\n\nA joint holds")[0]
    robot = parse("\n".join(line.removeprefix("    ") for line in ("    " + lines).splitlines()))
    assert robot.name == "two_link"
    assert robot.limits.lower[0] == pytest.approx(radians(-170))
    assert robot.limits.velocity[0] == pytest.approx(pi / 2)
    assert robot.limits.effort[0] == 20.0
    np.testing.assert_allclose(screws(robot).home[:3, 3], [1.5, 0, 0])
    assert robot.provenance.source == "my notes"


DEGREES = """
convention = "classic"
units = { angle = "deg", length = "mm" }
base = { xyz = [0.0, 0.0, 500.0], rpy = [0.0, 0.0, 90.0] }
tool = { xyz = [0.0, 0.0, 100.0] }

[[joint]]
a = 300.0
alpha = 90.0
d = 50.0
offset = 30.0
limits = { lower = -90.0, upper = 90.0, velocity = 180.0, acceleration = 360.0, jerk = 720.0, effort = 5.0 }
inertial = { mass = 2.0, com = [10.0, 0.0, 0.0], inertia = [0.1, 0.2, 0.25, 0.01, 0.02, 0.03] }
friction = { viscous = 0.1, coulomb = 0.2, coulomb_negative = 0.3 }
actuator = { rotor_inertia = 1e-4, gear_ratio = -50.0, armature = 0.01 }

[[joint]]
kind = "P"
theta = 45.0
offset = 200.0
limits = { lower = 0.0, upper = 400.0, velocity = 1000.0, effort = 100.0 }
"""


def test_degrees_and_millimetres_become_si():
    turn = np.eye(4)
    turn[:2, :2] = [[0, -1], [1, 0]]
    turn[2, 3] = 0.5
    tool = np.eye(4)
    tool[2, 3] = 0.1
    robot = parse(DEGREES)
    rows = [DHRow(a=0.3, alpha=pi / 2, d=0.05, offset=pi / 6), DHRow(theta=pi / 4, kind="P", offset=0.2)]
    tensor = np.array([[0.1, 0.01, 0.02], [0.01, 0.2, 0.03], [0.02, 0.03, 0.25]])
    expected = mechanism_from_dh(
        rows,
        "classic",
        base=turn,
        tool=tool,
        inertials=[Inertial(2.0, np.array([0.01, 0, 0]), tensor), None],
        limits=[Limits(-pi / 2, pi / 2, pi, 2 * pi, 4 * pi, 5.0), Limits(0.0, 0.4, 1.0, effort=100.0)],
        actuators=[robot.joints[0].actuator, None],
        frictions=[robot.joints[0].friction, None],
    )
    assert_same(robot, expected, rtol=1e-14, atol=1e-15)
    assert robot.joints[0].actuator.reflected_inertia == pytest.approx(1e-4 * 2500 + 0.01)
    assert robot.joints[0].friction.coulomb_negative == 0.3


SCREWS = """
convention = "space"
units = { length = "mm" }
home = { xyz = [1500.0, 0.0, 0.0] }
base = { xyz = [0.0, 0.0, 200.0] }
tool = { xyz = [0.0, 0.0, 50.0] }
[[joint]]
screw = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
[[joint]]
screw = [0.0, 0.0, 1.0, 0.0, -1000.0, 10.0]
[[joint]]
screw = [0.0, 0.0, 0.0, 0.0, 0.0, -1.0]
limits = { lower = -50.0 }
"""


def test_screws_in_millimetres():
    robot = parse(SCREWS)
    assert [joint.kind for joint in robot.joints] == [JointKind.REVOLUTE, JointKind.HELICAL, JointKind.PRISMATIC]
    S_s, _, home = screws(robot)
    np.testing.assert_allclose(S_s[1], [0, 0, 1, 0, -1, 0.01], atol=1e-15)
    np.testing.assert_allclose(S_s[2], [0, 0, 0, 0, 0, -1], atol=1e-15)
    np.testing.assert_allclose(home[:3, 3], [1.5, 0, 0.25], atol=1e-15)
    assert robot.limits.lower[2] == pytest.approx(-0.05)


def test_body_screws_are_those_of_the_tool_frame():
    S_s, S_b, home = screws(library.load("arm6r"))
    lines = [f"[[joint]]\nscrew = {S.tolist()}" for S in S_b]
    text = f'convention = "body"\nhome = {{ matrix = {home.tolist()} }}\n' + "\n".join(lines)
    np.testing.assert_allclose(screws(parse(text)).S_s, S_s, atol=1e-12)


def test_whole_numbers_and_infinite_limits_are_numbers():
    robot = parse('convention = "modified"\n[[joint]]\na = 1\nlimits = { lower = -inf, upper = 2 }')
    assert robot.joints[0].T_pj[0, 3] == 1.0
    assert robot.limits.upper[0] == 2.0


# ---- faults

ROW = 'convention = "modified"\n[[joint]]\n'
FAULTS = [
    ("convention = ", "table.toml", None),
    ('convention = "modified"\n[[joint]]\na = 1\na = 2', "table.toml", None),
    ("x = " + "[" * 5000, "table.toml", None),
    ("[[joint]]\na = 1", "table.form", 1),
    ('convention = "craig"\n[[joint]]', "table.form", 1),
    (ROW + "a = 1\n\n[[joint]]\n# elbow\nalpha = 'half'", "table.form", 7),
    (ROW + "a = 1\nbeta = 2", "table.unknown_close", 4),
    (ROW + "limits = { lower = 'no' }", "table.form", 3),
    (ROW + "[joint.limits]\nlower = 1\nupper = 'no'", "table.form", 5),
    (ROW + "inertial = { mass = -1.0 }", "table.form", 3),
    (ROW + "inertial = { mass = 1.0, inertia = [1, 2, 3, 4] }", "table.moments", 3),
    ('convention = "modified"\njoint = []', "table.form", 2),
    (ROW + "a = nan", "table.finite", 3),
    (ROW + "limits = { upper = nan }", "table.finite", 3),
    (ROW + "a = 1e999", "table.finite", 3),
    ('gravity = [0.0, 0.0, -inf]\nconvention = "modified"\n[[joint]]', "table.finite", 1),
    (ROW + "screw = [0, 0, 1, 0, 0, 0]", "table.foreign", 3),
    ('home = { xyz = [1, 0, 0] }\nconvention = "classic"\n[[joint]]', "table.foreign", 1),
    ('convention = "space"\nhome = {}\n[[joint]]\nscrew = [0, 0, 1, 0, 0, 0]\n[[joint]]', "table.missing", 5),
    ('convention = "body"\n[[joint]]\nscrew = [0, 0, 1, 0, 0, 0]', "table.missing", 1),
]


@pytest.mark.parametrize(("text", "key", "line"), FAULTS)
def test_faults_of_form_are_named_with_their_line(text, key, line):
    with pytest.raises(FileError) as caught:
        parse(text, "arm.toml")
    assert caught.value.key == key
    assert caught.value.details.get("line") == line
    for language in ("en", "ar"):
        assert "arm.toml" in caught.value.message(language)
    assert caught.value.message("en") != caught.value.message("ar")


@pytest.mark.parametrize(
    ("text", "key"),
    [
        (ROW + 'kind = "H"', "table.kind"),
        ('convention = "frames"\n[[joint]]\naxis = [0, 0, 0]', "table.axis"),
        (
            'convention = "frames"\n[[joint]]\nmatrix = [[2,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]',
            "geometry.pose",
        ),
        (ROW + "\n[base]\nmatrix = [[-1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]", "geometry.improper"),
        (ROW + 'name = "a"\n[[joint]]\nname = "a"', "model.duplicate_joint"),
        ('convention = "space"\nhome = {}\n[[joint]]\nscrew = [0, 0, 2, 0, 0, 0]', "screws.unit"),
    ],
)
def test_numbers_that_are_no_mechanism_are_refused(text, key):
    with pytest.raises(ModelError) as caught:
        parse(text)
    assert caught.value.key == key
    assert caught.value.message("en") != caught.value.message("ar")


def test_files_that_cannot_be_read(tmp_path):
    def key_of(path):
        with pytest.raises(FileError) as caught:
            read(path)
        assert str(path) in caught.value.message("en")
        assert caught.value.message("en") != caught.value.message("ar")
        return caught.value.key

    assert key_of(tmp_path / "none.toml") == "table.open"
    assert key_of(tmp_path) == "table.open"
    large = tmp_path / "large.toml"
    large.write_bytes(b"#" * (SIZE_LIMIT + 1))
    assert key_of(large) == "table.size"
    latin = tmp_path / "latin.toml"
    latin.write_bytes(b"# a\n# b\nname = '\xe9'")
    assert key_of(latin) == "table.utf8"
    with pytest.raises(FileError, match="line 3"):
        read(latin)


def test_a_byte_order_mark_does_no_harm(tmp_path):
    file = tmp_path / "mark.toml"
    file.write_bytes(b"\xef\xbb\xbf" + ROW.encode())
    assert read(file).n == 1


def test_a_file_that_cannot_be_written(tmp_path):
    with pytest.raises(FileError) as caught:
        write(library.load("planar2r"), tmp_path / "none" / "robot.toml")
    assert caught.value.key == "file.cannot_write"
    assert "robot.toml" in caught.value.message("ar")


def test_a_name_that_is_no_unicode_is_not_written(tmp_path):
    robot = mechanism_from_dh([DHRow()], "modified", name="\ud800")
    with pytest.raises(FileError) as caught:
        write(robot, tmp_path / "robot.toml")
    assert caught.value.key == "file.cannot_write"


def arm(*joints, loops=(), base=None, tip=None):
    links = [Link("base", base), *(Link(name) for name in ("a", "b"))]
    return Mechanism.assemble("arm", links, joints, loops=loops, tip=tip)


FIRST = Joint("j1", JointKind.REVOLUTE, "base", "a")
SECOND = Joint("j2", JointKind.REVOLUTE, "a", "b")


@pytest.mark.parametrize(
    ("robot", "lost", "part"),
    [
        (arm(FIRST, replace(SECOND, kind=JointKind.FIXED)), "fixed", "j2"),
        (arm(FIRST, replace(SECOND, parent="base")), "branch", "j2"),
        (arm(FIRST, replace(SECOND, mimic=Mimic("j1"))), "follower", "j2"),
        (arm(FIRST, replace(SECOND, actuated=False)), "passive", "j2"),
        (arm(FIRST, SECOND, loops=[Joint("loop", JointKind.REVOLUTE, "base", "b")]), "loops", "loop"),
        (arm(FIRST, SECOND, base=Inertial(1.0)), "mass", "base"),
        (arm(FIRST, SECOND, tip="a"), "tip", "not on a"),
        (Mechanism.assemble("stone", [Link("base")], []), "tip", "base"),
    ],
)
def test_what_a_table_cannot_hold_is_not_written(robot, lost, part):
    """The sentence names the one thing that would be lost."""
    with pytest.raises(ModelError, match=part) as caught:
        format_table(robot)
    assert caught.value.details["loss"].key == f"table.lost_{lost}"
    assert caught.value.message("en") != caught.value.message("ar")


WORDS = [
    *("convention = ", '"modified"', '"space"', "\n", "[[joint]]", "[joint.limits]", "a = ", "1.0", "nan", "1e400"),
    *(
        "9" * 400,
        "[",
        "]",
        "{",
        "}",
        "screw = ",
        "[0,0,1,0,0,0]",
        "home",
        "=",
        "[home]",
        "matrix",
        "'",
        '"""',
        ".",
        "#",
    ),
    *("inertial = {mass = 1, inertia = [1,1,1]}", "name = 'x'", "kind = 'H'", "\x00", "true", "1979-05-27"),
]


@settings(deadline=None, max_examples=300)
@given(st.lists(st.sampled_from(WORDS), max_size=20))
def test_any_text_gives_a_robot_or_our_error(words):
    with contextlib.suppress(MafsilError):
        assert parse("".join(words)).n >= 1


@settings(deadline=None, max_examples=200)
@given(st.integers(0, 1000), st.text(max_size=3))
def test_a_damaged_table_gives_a_robot_or_our_error_in_both_languages(place, damage):
    text = DEGREES[: place % len(DEGREES)] + damage + DEGREES[place % len(DEGREES) + 1 :]
    sentences = []
    try:
        parse(text)
    except MafsilError as error:
        sentences = [error.message("en"), error.message("ar")]
    assert all(sentences)


@given(st.integers(0, 4), st.integers(1, 5))
def test_a_line_is_found_whatever_stands_above_it(blank, joints):
    blocks = ["\n" * blank + f"[[joint]]\na = {k}\nlimits = {{ lower = {k} }}" for k in range(joints)]
    text = "convention = 'modified'\n" + "\n".join(blocks)
    last = line_of(text, f"$.joint[{joints - 1}].limits.lower")
    assert text.splitlines()[last - 1] == f"limits = {{ lower = {joints - 1} }}"


def test_text_of_plain_values():
    text = toml_text({"flag": True, "count": 3}, [])
    assert text == "flag = true\ncount = 3\n"
