"""SDFormat files whose joints form cycles, written in any direction and order: read as trees with loops."""

from __future__ import annotations

import warnings
from importlib import metadata
from itertools import product
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.model import JointKind, sdf
from mafsil.parallel import ClosedChain

PLACES = {"base": "0 0 0 0 0 0", "crank": "0 0 0 0 0 0.6", "coupler": "0.33 0.226 0 0 0 0.2", "rocker": "1 0 0 0 0 1.5"}
PINS = {"A": "0 0 0", "B": "0.33 0.226 0", "C": "1.07 0.9 0", "D": "1 0 0"}
ENDS = {"A": ("base", "crank"), "B": ("crank", "coupler"), "D": ("base", "rocker"), "C": ("rocker", "coupler")}


def bars(ends, order, *, fixed=True, kinds=()):
    text = '<sdf version="1.9"><model name="bars">'
    for name, place in PLACES.items():
        text += (
            f'<link name="{name}"><pose>{place}</pose><inertial><pose>0.1 0.05 0 0 0 0</pose><mass>1</mass>'
            "<inertia><ixx>.01</ixx><iyy>.02</iyy><izz>.03</izz></inertia></inertial></link>"
        )
    if fixed:
        text += '<joint name="W" type="fixed"><parent>world</parent><child>base</child></joint>'
    for name in order:
        parent, child = ends[name]
        kind = dict(kinds).get(name, "revolute")
        axis = "" if kind == "ball" else "<axis><xyz>0 0 1</xyz></axis>"
        text += (
            f'<joint name="{name}" type="{kind}"><pose relative_to="__model__">{PINS[name]} 0 0 0</pose>'
            f"<parent>{parent}</parent><child>{child}</child>{axis}</joint>"
        )
    return text + "</model></sdf>"


@pytest.mark.parametrize("flips", list(product([False, True], repeat=4)), ids=str)
@pytest.mark.parametrize("order", ["ABDC", "CDBA"])
def test_bars_in_any_direction_and_order_are_the_same_mechanism(flips, order):
    """All links move as they do in the file written as a tree, per turn of the crank; joints turn as the file says."""
    ends = {name: ends[::-1] if flip else ends for flip, (name, ends) in zip(flips, ENDS.items(), strict=True)}
    mechanism = sdf.read(bars(ends, order))
    assert (mechanism.n, len(mechanism.loops)) == (3, 1)
    np.testing.assert_allclose(motion(mechanism)[0], motion(sdf.read(bars(ENDS, "ABDC")))[0], atol=1e-7)
    plain = dict(zip("ABD", motion(sdf.read(bars(ENDS, "ABDC")))[1], strict=True))
    for joint, rate in zip(mechanism.coordinates, motion(mechanism)[1], strict=True):
        if joint.name in plain:
            assert rate == pytest.approx(-plain[joint.name] if flips["ABDC".index(joint.name)] else plain[joint.name])


def motion(mechanism):
    """Rates of the poses of the links against the base, and of the joints, for a crank that turns at 1 rad/s."""
    chain = ClosedChain(mechanism)
    assert chain.error(np.zeros(3)) < 1e-14
    v = np.linalg.svd(chain.terms(np.zeros(3)).J)[2][-1]

    def poses(q):
        T = dict(zip(mechanism.link_names, chain.robot.link_poses(q), strict=True))
        return np.array([np.linalg.inv(T["base"]) @ T[name] for name in ("crank", "coupler", "rocker")])

    rates, here = (poses(1e-5 * v) - poses(-1e-5 * v)) / 2e-5, poses(np.zeros(3))
    crank = (rates[0] @ np.linalg.inv(here[0]))[1, 0]
    return rates / crank, v / crank


@pytest.mark.parametrize("fixed", [True, False])
def test_a_ring_of_joints_without_a_first_one(fixed):
    ring = {"A": ("base", "crank"), "B": ("crank", "coupler"), "C": ("coupler", "rocker"), "D": ("rocker", "base")}
    mechanism = sdf.read(bars(ring, "ABCD", fixed=fixed))
    assert (mechanism.n, len(mechanism.loops)) == (3, 1)
    assert mf.mobility(mechanism).mobility == 1


def test_balls_close_loops_as_one_joint_and_carry_links_as_three_hinges():
    closing = sdf.read(bars(ENDS, "ABDC", kinds={"C": "ball"}))
    assert closing.loops[0].kind is JointKind.SPHERICAL
    assert closing.n == 3
    carrying = sdf.read(bars(ENDS, "ABDC", kinds={"B": "ball"}))
    assert carrying.n == 5
    assert [joint.name for joint in carrying.coordinates][1:4] == ["B", "B/axis2", "B/axis3"]
    assert ClosedChain(carrying).error(np.zeros(5)) < 1e-14
    assert mf.mobility(closing).mobility == mf.mobility(carrying).mobility == 1


def test_balls_springs_and_joints_of_no_effort_are_not_driven_and_no_frame_of_a_loop_is_the_tip():
    text = bars(ENDS, "ABDC", kinds={"B": "ball"})
    free = "<axis><limit><effort>0</effort></limit><xyz>0 0 1</xyz></axis>"
    sprung = "<axis><dynamics><spring_stiffness>5</spring_stiffness></dynamics><xyz>0 0 1</xyz></axis>"
    plain = "<axis><xyz>0 0 1</xyz></axis>"
    head, first, rest, last = text.split(plain)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        read = sdf.read(head + plain + first + free + rest + sprung + last)
    driven = {joint.name: joint.actuated for joint in (*read.coordinates, *read.loops)}
    assert driven == {"A": True, "B": False, "B/axis2": False, "B/axis3": False, "D": False, "C": False}
    assert read.tip in PLACES
    assert sdf.read(bars(ENDS, "ABDC")).tip == "coupler"


def test_friction_of_a_joint_that_closes_a_loop_is_left_out_and_said():
    head, plain, tail = bars(ENDS, "ABDC").rpartition("<axis><xyz>0 0 1</xyz></axis>")
    damped = "<dynamics><damping>0.5</damping></dynamics></axis>"
    for axis, said in ((plain, False), (plain.replace("</axis>", damped), True)):
        robot = mf.Robot(sdf.read(head + axis + tail))
        still = mf.trajectory.profiles.rest(ClosedChain(robot).close_loops(np.zeros(robot.n)).q, 0.01)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            mf.Scenario(robot=robot, trajectory=still, law=lambda t, q, qd, reference: 0.0 * q).start()
        assert any("friction of joints that close loops (C)" in str(each.message) for each in caught) == said


def test_parts_that_hang_on_nothing_are_left_out_and_named():
    """The robot is the part with the most moving joints, wherever it stands in the file."""
    text = bars({**ENDS, "D": ("rocker", "coupler"), "C": ("rocker", "coupler")}, "ABDC")
    robot = sdf.read(text)
    assert robot.loops
    table = '<link name="top"/><link name="leg"/>'
    table += '<joint name="glue" type="fixed"><parent>top</parent><child>leg</child></joint>'
    cart = '<link name="rail"/><link name="cart"/>'
    cart += '<joint name="drive" type="prismatic"><parent>rail</parent><child>cart</child>'
    cart += "<axis><xyz>1 0 0</xyz></axis></joint>"
    first = text.index("<link")
    for lonely in ('<link name="top"/>', table, cart, table + cart):
        for at in (first, text.rindex("</model>")):
            report = sdf.diagnose(text[:at] + lonely + text[at:])
            said = {str(d.details["body"]) for d in report if d.code == "M0722"}
            assert report.mechanism is not None
            assert said == {name for name in ("top", "rail") if f'"{name}"' in lonely}
            assert set(report.mechanism.link_names) == set(robot.link_names)
            assert report.mechanism.n == robot.n


@pytest.mark.parametrize(
    ("name", "coordinates", "mobility"),
    [
        ("cassie_reduced", 23, 11),
        ("cassie_simple", 27, 11),
        ("cassie_wo_gearbox_spring", 27, 13),
    ],
)
def test_cassie_with_its_rods_on_balls(name, coordinates, mobility):
    """Published files with four loops: each freedom of the loops is one of real motions."""
    mechanism = cassie(name)
    assert (mechanism.n, len(mechanism.loops)) == (coordinates, 4)
    found = mf.mobility(mechanism)
    assert found.mobility == found.instantaneous.mobility == mobility


def test_digits_of_a_file_that_leave_a_motion_in_doubt_count_with_a_play():
    """One foot of the published file opens by a billionth of its size: neither rounding nor clear, and said so."""
    mechanism = cassie("cassie_v2")
    assert (mechanism.n, len(mechanism.loops)) == (22, 4)
    found = mf.mobility(mechanism)
    assert found.instantaneous.mobility == 12
    assert (found.finite.mobility, found.finite.at_most) == (11, 12)
    assert found.status.name == "IN_DOUBT"
    assert 1e-9 < found.finite.gap < 1e-8
    assert mf.mobility(mechanism, play=1e-7).mobility == 12


def test_cassie_with_its_gearboxes():
    """The motors of the published file turn 16 to 50 times as fast as what they drive, the other way round."""
    mechanism = cassie("cassie")
    assert (mechanism.n, len(mechanism.loops)) == (28, 6)
    ratios = {joint.name: joint.mimic.multiplier for joint in mechanism.joints if joint.mimic is not None}
    assert ratios == {
        f"{side}-{name}-ip": pytest.approx(-turns)
        for side in ("left", "right")
        for name, turns in (("roll", 25), ("yaw", 25), ("pitch", 16), ("knee", 16), ("foot", 50))
    }
    assert ClosedChain(mechanism).close_loops(np.full(28, 0.05))
    assert mf.mobility(mechanism).mobility == 10


def cassie(name):
    """As it was published; skips where it is not installed."""
    try:
        package = metadata.distribution("example-robot-data")
    except metadata.PackageNotFoundError:
        pytest.skip("example-robot-data is not installed")
    folder = Path(package.locate_file("cmeel.prefix/share/example-robot-data/robots/cassie_description/robots"))
    if not (folder / f"{name}.sdf").exists():
        pytest.skip("no such file in this version")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return mf.load(folder / f"{name}.sdf").mechanism


def test_digits_of_a_file_that_contradict_each_other_do_not_keep_loops_open():
    """Two rows of four loops depend on the others but for the last digits: what they leave is no gap to be closed."""
    chain = ClosedChain(cassie("cassie_v2"))
    found = chain.close_loops(0.05 * np.random.default_rng(0).normal(size=(4, chain.n)))
    assert found.found.all()
    assert 1e-13 < found.error.max() < 1e-9
