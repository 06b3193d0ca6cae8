"""URDF 1.0 to 1.2: what each version has is read, held against urdfdom in Pinocchio; what it lacks is said."""

from __future__ import annotations

import re
from math import inf

import numpy as np
import pytest

from mafsil.model import urdf
from mafsil.model.faults import FAULTS
from mafsil.model.urdf.vocabulary import ROWS
from mafsil.model.vocabulary import Treatment
from mafsil.model.xml_tree import parse
from mafsil.robot import Robot

BODY = '<inertia ixx="1" iyy="2" izz="2.5" ixy="0" ixz="0" iyz="0"/>'
LIMIT = '<limit lower="-1" upper="1" effort="5" velocity="2"/>'


def robot(version: str = "", joint: str = "", com: str = "", limit: str = LIMIT, kind: str = "revolute") -> str:
    """One joint; texts of the origins of joint and mass."""
    head = f' version="{version}"' if version else ""
    return (
        f'<robot name="r"{head}><link name="a"/><link name="b"><inertial><origin {com}/><mass value="1"/>{BODY}'
        f'</inertial></link><joint name="j" type="{kind}"><origin {joint}/><parent link="a"/><child link="b"/>'
        f'<axis xyz="1 0 0"/>{limit}</joint></robot>'
    )


def quaternions() -> list[str]:
    """Random ones, of any length."""
    rng = np.random.default_rng(7)
    numbers = rng.normal(size=(30, 4)) * rng.choice([1e-6, 1.0, 1e6], size=(30, 1))
    return [" ".join(repr(float(x)) for x in row) for row in numbers]


@pytest.mark.parametrize("version", ["1.1", "1.2"])
def test_quaternions_as_in_urdfdom(version: str) -> None:
    pin = pytest.importorskip("pinocchio")
    for text in quaternions():
        given = robot(version, f'xyz="0.1 0.2 0.3" quat_xyzw="{text}"', f'xyz="1 0 2" quat_xyzw="{text}"')
        joint, model = urdf.read(given).joints[0], pin.buildModelFromXML(given)
        inertial = urdf.read(given).link("b").inertial
        assert inertial is not None
        np.testing.assert_allclose(joint.T_pj, model.jointPlacements[1].homogeneous, atol=1e-14)
        np.testing.assert_allclose(inertial.inertia, model.inertias[1].inertia, atol=1e-13)
        np.testing.assert_allclose(inertial.com, model.inertias[1].lever, atol=1e-14)


def test_a_quaternion_turns_axes_inertias_and_shapes() -> None:
    turn = 'quat_xyzw="0 0 0.7071067811865476 0.7071067811865476"'
    turned = Robot(urdf.read(robot("1.1", f'xyz="0 0 0.5" {turn}')))
    np.testing.assert_allclose(turned.jacobian_space([0.0])[:3, 0], (0, 1, 0), atol=1e-15)
    matter = Robot(urdf.read(robot("1.1", com=turn)))
    np.testing.assert_allclose(matter.inverse_dynamics([0.0], [0.0], [1.0]), [2.0], atol=1e-14)
    shape = f'<collision><origin {turn}/><geometry><box size="1 2 3"/></geometry></collision>'
    (box,) = urdf.read(robot("1.1").replace('<link name="b">', f'<link name="b">{shape}')).link("b").collisions
    np.testing.assert_allclose(box.T_lg[:3, 0], (0, 1, 0), atol=1e-15)


def test_urdf_1_0_ignores_the_quaternion_and_says_so() -> None:
    given = robot(joint='quat_xyzw="0 0 1 1"')
    report = urdf.diagnose(given)
    assert "F0140" in report.codes
    np.testing.assert_array_equal(urdf.read(given).joints[0].T_pj, np.eye(4))
    both = urdf.read(robot("1.0", 'rpy="0 0 1" quat_xyzw="0 0 0 1"')).joints[0]
    assert both.T_pj[1, 0] == pytest.approx(np.sin(1.0))


@pytest.mark.parametrize(
    "text",
    ["1.0", "1.1", "1.2", "01.01", " 1.1", "+1.1", "1.3", "2.0", "1.10", "1", "", "1.1 ", "1.1.0", "-1.0", "a.b"],
)
def test_versions_are_taken_or_refused_as_by_urdfdom(text: str) -> None:
    pin = pytest.importorskip("pinocchio")
    given = robot().replace('name="r"', f'name="r" version="{text}"')
    try:
        pin.buildModelFromXML(given)
        taken = True
    except ValueError:
        taken = False
    assert urdf.diagnose(given).ok is taken
    assert ("F0141" in urdf.diagnose(given).codes) is not taken


def test_wider_limits_of_urdf_1_2() -> None:
    limit = LIMIT.replace("/>", ' acceleration="3" deceleration="2" jerk="40"/>')
    limits = urdf.read(robot("1.2", limit=limit)).joints[0].limits
    assert (limits.acceleration, limits.jerk, limits.velocity) == (2.0, 40.0, 2.0)
    alone = urdf.diagnose(robot("1.2", limit=LIMIT.replace("/>", ' acceleration="3" jerk="40"/>')))
    assert alone.mechanism is not None
    assert alone.mechanism.joints[0].limits.acceleration == 3.0
    assert "J0435" not in alone.codes
    earlier = urdf.diagnose(robot("1.1", limit=limit))
    assert earlier.codes.count("F0140") == 3
    nothing = urdf.diagnose(robot("1.2", limit='<limit lower="-1" upper="1"/>'))
    assert nothing.mechanism is not None
    assert nothing.mechanism.joints[0].limits.effort == inf
    assert "J0415" not in nothing.codes
    half = urdf.read(robot("1.2", limit='<limit lower="-1"/>')).joints[0].limits
    assert (half.lower, half.upper) == (-1.0, inf)
    assert urdf.read(robot("1.1", limit='<limit lower="-1" effort="1" velocity="1"/>')).joints[0].limits.upper == 0.0


@pytest.mark.parametrize("word", ["-1", "-1.0", "0", "1e16", "1e308", "inf", "Infinity", "+inf"])
@pytest.mark.parametrize("key", ["effort", "velocity"])
def test_signs_for_no_limit(key: str, word: str) -> None:
    given = robot(limit=re.sub(rf'{key}="\d"', f'{key}="{word}"', LIMIT))
    report = urdf.diagnose(given)
    assert report.mechanism is not None
    assert getattr(report.mechanism.joints[0].limits, key) == inf
    mended, changes = urdf.repair(given)
    assert getattr(urdf.read(mended).joints[0].limits, key) == inf
    assert len(changes) == (word not in ("0", "1e16", "1e308"))
    assert report.warnings or word.startswith("1e")


def test_infinite_ranges() -> None:
    limit = '<limit lower="-inf" upper="inf" effort="5" velocity="2"/>'
    assert urdf.read(robot(limit=limit)).joints[0].limits.lower == -inf
    for wrong in ('lower="inf"', 'upper="-inf"', 'lower="nan"', 'effort="-inf"', 'velocity="-2"'):
        key = wrong.partition("=")[0]
        assert not urdf.diagnose(robot(limit=re.sub(rf'{key}="[-\d]+"', wrong, LIMIT))).ok, wrong


def test_the_inertia_of_a_rotor_is_felt_times_the_square_of_the_reduction() -> None:
    actuator = "<mechanicalReduction>100</mechanicalReduction><motorInertia>1e-5</motorInertia>"
    gear = f'<transmission name="t"><joint name="j"/><actuator name="m">{actuator}</actuator></transmission></robot>'
    plain, geared = robot(), robot().replace("</robot>", gear)
    masses = [float(Robot(urdf.read(text)).mass_matrix([0.3])[0, 0]) for text in (plain, geared)]
    assert masses[1] - masses[0] == pytest.approx(0.1, abs=1e-15)
    broken = urdf.diagnose(geared.replace("1e-5", "light"))
    assert "J0432" in broken.codes


WHOLE = f"""<robot name="r" version="1.2" xmlns:drake="http://drake.mit.edu">
<material name="red"><color rgba="1 0 0 1"/></material>
<link name="a"><visual name="v"><origin xyz="1 0 0" rpy="0 0 1"/>
<geometry><mesh filename="m.stl" scale="2 2 2"/></geometry><material name="red"/></visual>
<collision name="c"><geometry><box size="1 2 3"/></geometry></collision>
<collision><geometry><cylinder radius="1" length="2"/></geometry></collision>
<collision><geometry><sphere radius="3"/></geometry></collision>
<collision><geometry><capsule radius="1" length="2"/></geometry></collision></link>
<link name="b"><inertial><origin xyz="0 0 1" quat_xyzw="0 0 1 0"/><mass value="3"/>
<inertia ixx="2" ixy="0.1" ixz="0.2" iyy="2.1" iyz="0.3" izz="2.2"/></inertial></link>
<link name="c"/>
<joint name="j" type="revolute"><origin xyz="1 2 3" rpy="1 2 3"/><parent link="a"/><child link="b"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="3" effort="4" velocity="5" acceleration="6" deceleration="6" drake:acceleration="6" jerk="7"/>
<dynamics damping="1" friction="2"/></joint>
<joint name="k" type="prismatic"><parent link="b"/><child link="c"/><axis xyz="0 1 0"/>{LIMIT}
<mimic joint="j" multiplier="2" offset="3"/></joint>
<transmission name="t"><joint name="j"/><actuator name="m"><mechanicalReduction>100</mechanicalReduction>
<motorInertia>1e-5</motorInertia></actuator></transmission>
<transmission name="u"><joint name="k"/><actuator name="m"><drake:gear_ratio value="3"/><drake:rotor_inertia value="1"/>
</actuator></transmission>
</robot>"""
NAMES = {"actuator.name", "limit.acceleration", "limit.deceleration", "limit.drake:acceleration", "transmission.name"}
"""Read as names for people alone, or beside two others that say the same."""


def test_what_is_called_read_is_read() -> None:
    """Without any one of its attributes the file says something else."""

    def meaning(text: str) -> tuple[str, list[str]]:
        report = urdf.diagnose(text)
        return repr(report.mechanism), [d.sentence() for d in report]

    table = {
        f"{place.rpartition('/')[2]}.{name}"
        for place, row in ROWS.items()
        for name, word in row.words.items()
        if word.treatment is Treatment.READ
    }
    document = parse(WHOLE.encode())
    whole, tried = meaning(WHOLE), set[str]()
    for element in document.root.walk():
        for attribute in element.attributes:
            name = f"{element.tag}.{attribute}"
            tried.add(name)
            span = document.attribute_span(element, attribute)
            if span is not None and name in table - NAMES:
                assert meaning(WHOLE[: span[0]] + WHOLE[span[1] :]) != whole, name
    assert table <= tried


SCHEMA = {
    "origin": "xyz rpy quat_xyzw", "color": "rgba", "mass": "value", "inertia": "ixx ixy ixz iyy iyz izz",
    "box": "size",
    "cylinder": "radius length", "sphere": "radius", "capsule": "radius length", "mesh": "filename scale",
    "material": "name", "visual": "name", "collision": "name", "link": "name type", "parent": "link", "child": "link",
    "axis": "xyz", "dynamics": "damping friction",
    "limit": "lower upper effort velocity acceleration deceleration jerk",
    "safety_controller": "soft_lower_limit soft_upper_limit k_position k_velocity", "mimic": "joint multiplier offset",
    "transmission": "name type", "robot/joint": "name type", "robot": "name version",
}  # fmt: skip
"""Elements and attributes of the schema of urdfdom (BSD licence) with the additions of its versions 5.1 and 6.0."""
INSIDE = {
    "robot": "link joint material transmission gazebo sensor", "link": "inertial visual collision",
    "inertial": "origin mass inertia", "visual": "origin geometry material", "collision": "origin geometry verbose",
    "geometry": "box cylinder sphere mesh capsule", "material": "color texture",
    "robot/joint": "origin parent child axis calibration dynamics limit safety_controller mimic",
    "transmission": "leftActuator rightActuator flexJoint rollJoint gap_joint passive_joint "
    "use_simulated_gripper_joint mechanicalReduction actuator joint",
}  # fmt: skip


def test_the_published_schema_is_whole_in_the_table() -> None:
    for place, names in SCHEMA.items():
        assert set(names.split()) <= set(ROWS[place].words), place
    for place, names in INSIDE.items():
        assert set(names.split()) <= set(ROWS[place].parts), place
    assert {"F0139", "F0140", "F0141"} <= set(FAULTS)
