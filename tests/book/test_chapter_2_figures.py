"""Figures of chapters 1 and 2: counts, places and what is drawn there."""

import numpy as np
import pytest

import mafsil as mf
from mafsil.mobility.linkages import Linkage
from tests.book.artists import artist_points, drawn


def gruebler(linkage: Linkage) -> int:
    """Counted here: m (N - 1 - J) + sum f."""
    m = 3 if linkage.planar else 6
    return m * (len(linkage.bodies) - 1 - len(linkage.joints)) + sum(each.freedoms for each in linkage.joints)


def pins_are_on_bodies(figure: mf.book.Figure, panel: str, linkage: Linkage) -> None:
    """Every drawn joint is an end or corner of both bodies that it joins."""
    points = drawn(figure)
    for joint in linkage.joints:
        (pin,) = points(panel, f"joint {joint.name}")
        for body in (joint.parent, joint.child):
            assert np.linalg.norm(points(panel, body) - pin, axis=1).min() < 1e-9, (joint.name, body)


@pytest.mark.capability("12-13")
def test_figure_1_1() -> None:
    figure = mf.book.figure("1.1", bend=0.3, height=1.4)
    robot, platform = figure.objects["robot"], figure.objects["platform"]
    points = drawn(figure)
    assert points("a", "arm")[-1] == pytest.approx(robot.fk(figure.objects["q"])[:3, 3])
    assert (figure["arm"], figure["platform"]) == (6, gruebler(platform))
    ends = [points("b", "joint " + name) for name in ("A3", "B3")]
    assert points("b", "lower3")[0] == pytest.approx(ends[0][0])
    assert points("b", "platform")[:, 2] == pytest.approx(1.4)


@pytest.mark.capability("12-14")
def test_figure_1_2() -> None:
    figure = mf.book.figure("1.2")
    hand = figure.objects["hand"]
    assert figure["loops"] == len(hand.joints) - len(hand.bodies) + 1 == 2
    assert figure["mobility"] == gruebler(hand)
    body = artist_points(figure, "hand", "object")
    assert len(body) >= 3
    assert np.linalg.norm(body[:, :2], axis=1) == pytest.approx(0.03)
    pins_are_on_bodies(figure, "hand", hand)


@pytest.mark.capability("12-15", "12-8")
def test_figure_2_1() -> None:
    door, heading = 0.7, -2.0
    figure = mf.book.figure("2.1", door=door, heading=heading)
    assert [figure[name] for name in ("door", "point", "coin")] == [1, 2, 3]
    points = drawn(figure)
    assert points("a", "door")[1] == pytest.approx([np.cos(door), np.sin(door)])
    tail, tip = points("c", "nose")
    assert np.arctan2(*(tip - tail)[::-1]) == pytest.approx(heading)
    assert np.linalg.norm(points("c", "coin") - tail, axis=1) == pytest.approx(np.linalg.norm(tip - tail))


@pytest.mark.capability("12-16", "12-8")
def test_figure_2_2() -> None:
    for phi in (-1.0, 0.4):
        figure = mf.book.figure("2.2", phi=phi)
        points = drawn(figure)
        A, B, C = (points("coin", name)[0] for name in "ABC")
        assert [np.linalg.norm(B - A), np.linalg.norm(C - A), np.linalg.norm(C - B)] == pytest.approx([1.2, 0.9, 1.0])
        assert np.arctan2(*(B - A)[::-1]) == pytest.approx(phi)
        assert np.linalg.det([B - A, C - A]) > 0
        (other,) = points("coin", "other face")
        for circle, centre, point in (("AB", A, B), ("AC", A, other), ("BC", B, other)):
            radii = np.linalg.norm(points("coin", f"circle {circle}") - centre, axis=1)
            assert radii == pytest.approx(np.linalg.norm(point - centre))
    assert figure["freedoms"] == 2 * 3 - 3


@pytest.mark.capability("12-17", "12-7")
def test_figure_2_3() -> None:
    figure = mf.book.figure("2.3")
    points = drawn(figure)
    assert {name: figure[name] for name in figure.panels} == {"R": 1, "P": 1, "H": 1, "C": 2, "U": 2, "S": 3}
    for symbol, freedoms in (("R", 1), ("C", 2), ("U", 2), ("S", 3)):
        assert sum(name.startswith("freedom") for name in figure.panels[symbol].names) == freedoms
    turned = points("R", "freedom 1")
    assert np.linalg.norm(turned[:, :2], axis=1) == pytest.approx(0.55 * np.sqrt(2))
    assert np.ptp(turned[:, 2]) < 1e-12
    moved = points("P", "freedom 1")
    assert np.ptp(moved[:, :2], axis=0) == pytest.approx([0, 0])
    helix = points("H", "freedom 1")
    assert helix[-1, 2] - helix[0, 2] == pytest.approx(0.12 * 4 * np.pi)
    assert np.linalg.norm(points("S", "freedom 3"), axis=1) == pytest.approx(np.linalg.norm([0.55, 0.55, 0.25]))


@pytest.mark.capability("12-18", "12-8")
def test_figure_2_4() -> None:
    figure = mf.book.figure("2.4", phi=-0.9)
    A, B = artist_points(figure, "body", "AB")
    assert B == pytest.approx(A + 1.3 * np.array([np.cos(-0.9), np.sin(-0.9)]))
    assert figure["B"] == pytest.approx(B)
    assert artist_points(figure, "body", "B")[0] == pytest.approx(B)


@pytest.mark.capability("12-19")
def test_figure_2_5() -> None:
    for crank in (-2.0, 0.4):
        figure = mf.book.figure("2.5", crank=crank)
        points = drawn(figure)
        for name, length in {"crank": 2.0, "coupler": 4.0, "rocker": 3.5}.items():
            assert np.linalg.norm(np.diff(points("four_bar", name), axis=0)) == pytest.approx(length)
        assert points("four_bar", "joint B")[0] == pytest.approx(2 * np.array([np.cos(crank), np.sin(crank)]))
        (block,) = points("slider_crank", "joint C")
        assert block == pytest.approx([np.cos(crank) + np.sqrt(9 - np.sin(crank) ** 2), 0.0])
        for name in ("four_bar", "slider_crank"):
            pins_are_on_bodies(figure, name, figure.objects[name])
            assert figure[f"{name}_count"] == gruebler(figure.objects[name]) == 1


@pytest.mark.capability("12-20")
def test_figure_2_6() -> None:
    figure = mf.book.figure("2.6")
    for name, mobility in {"chain": 4, "five_bar": 2, "stephenson": 1, "watt": 1}.items():
        assert figure[f"{name}_count"] == gruebler(figure.objects[name]) == mobility
        pins_are_on_bodies(figure, name, figure.objects[name])
    ternary = {}
    for name in ("watt", "stephenson"):
        joints = figure.objects[name].joints
        three = {b for b in "012345" if sum(b in (j.parent, j.child) for j in joints) == 3}
        ternary[name] = any({j.parent, j.child} == three for j in joints)
    assert ternary == {"watt": True, "stephenson": False}


@pytest.mark.capability("12-21")
def test_figure_2_7() -> None:
    figure = mf.book.figure("2.7")
    linkage = figure.objects["overlap"]
    assert figure["overlap_count"] == gruebler(linkage) == 3 * (8 - 1 - 9) + 9
    places = [tuple(artist_points(figure, "overlap", f"joint {name}")[0]) for name in ("B3", "C3")]
    assert places[0] == pytest.approx(places[1])
    pins_are_on_bodies(figure, "overlap", linkage)


@pytest.mark.capability("12-22")
def test_figure_2_8() -> None:
    figure = mf.book.figure("2.8", angle=0.8)
    assert figure["count"] == gruebler(figure.objects["parallelogram"]) == 0
    assert (figure["true"], figure["locked_regular"], figure["locked_singular"]) == (1, 0, 1)
    points = drawn(figure)
    for k in range(3):
        crank = np.diff(points("parallelogram", f"crank{k}"), axis=0)[0]
        assert np.abs(crank) == pytest.approx(np.abs([np.cos(0.8), np.sin(0.8)]))
    assert np.sort(points("singular", "rod 1"), axis=0) == pytest.approx(np.sort(points("singular", "rod 2"), axis=0))


@pytest.mark.capability("12-23")
def test_figure_2_9() -> None:
    figure = mf.book.figure("2.9", height=1.0)
    assert figure["count"] == gruebler(figure.objects["platform"]) == 6
    assert figure["spinning"] == gruebler(figure.objects["sps"]) == 12
    assert figure["idle"] == 6
    assert artist_points(figure, "platform", "platform")[:, 2] == pytest.approx(1.0)


@pytest.mark.capability("12-24")
def test_figure_2_10() -> None:
    figure = mf.book.figure("2.10")
    assert figure["count"] == gruebler(figure.objects["tangent"]) == 3
    assert (figure["tangent"], figure["radial"]) == (3, 5)
    points = drawn(figure)
    for axes, along in (("tangent", 0.0), ("radial", 1.0)):
        ends = points(axes, "axis A0")
        pivot = ends.mean(axis=0)
        direction = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        assert abs(direction @ pivot) / np.linalg.norm(pivot) == pytest.approx(along, abs=1e-9)


@pytest.mark.capability("12-25")
def test_figure_2_11() -> None:
    a, b = 5.0, 1.2
    figure = mf.book.figure("2.11", a=a, b=b)
    points = drawn(figure)
    (point,) = points("b", "point")
    out = 2.0 + 0.7 * np.cos(b)
    assert point == pytest.approx([out * np.cos(a), out * np.sin(a), 0.7 * np.sin(b)])
    assert figure["place"] == pytest.approx(point)
    assert figure["dimension"] == 2
    for k in (0, 1):
        glued = [[mf.mobility.torus.embed_in_space(end) for end in points("a", f"side {k} {side}")] for side in (0, 6)]
        assert glued[0] == pytest.approx(np.array(glued[1]))
        seam = points("b", f"seam {k}")
        assert seam[0] == pytest.approx(glued[0][0])
        assert seam[0] == pytest.approx(seam[-1])


@pytest.mark.capability("12-26")
def test_figure_2_12() -> None:
    figure = mf.book.figure("2.12", a=2.0, b=4.0)
    points = drawn(figure)
    angles = [np.arctan2(*points(name, "point")[0][::-1]) % (2 * np.pi) for name in "ab"]
    assert angles == pytest.approx([2.0, 4.0])
    (point,) = points("c", "point")
    assert mf.mobility.torus.angles_of(point) % (2 * np.pi) == pytest.approx([2.0, 4.0])
    for k in (0, 1):
        assert np.linalg.norm(points("c", f"seam {k}") - point, axis=1).min() < 0.1


@pytest.mark.capability("12-27", "12-8")
def test_figure_2_13() -> None:
    heading, roll = 1.1, 0.8
    figure = mf.book.figure("2.13", heading=heading, roll=roll)
    assert (figure["coordinates"], figure["velocities"]) == (4, 2)
    points = drawn(figure)
    (contact,) = points("coin", "contact")
    rim, (centre, low) = points("coin", "rim"), points("coin", "spoke")
    assert np.linalg.norm(rim - centre, axis=1) == pytest.approx(0.5)
    assert rim[:, 2].min() == pytest.approx(0.0, abs=1e-3)
    ahead = np.array([np.cos(heading), np.sin(heading), 0])
    assert (rim - centre) @ np.array([-ahead[1], ahead[0], 0]) == pytest.approx(0.0, abs=1e-12)
    assert low - centre == pytest.approx(0.5 * (-np.cos(roll) * np.eye(3)[2] - np.sin(roll) * ahead))
    assert centre == pytest.approx(contact + 0.5 * np.eye(3)[2])


@pytest.mark.capability("12-28")
def test_figure_2_14() -> None:
    figure = mf.book.figure("2.14", bend=0.9)
    assert [figure[name] for name in figure.panels] == [2, 2, 2, 3, 4, 5]
    points = drawn(figure)
    for name in ("planar_2r", "planar_3r"):
        assert np.linalg.norm(points(name, "reach"), axis=1) == pytest.approx(6.0)
        tip = points(name, "arm")[-1]
        assert np.linalg.norm(tip) <= 6.0
    two = 3 * np.array([np.cos(0.5) + np.cos(1.4), np.sin(0.5) + np.sin(1.4)])
    assert points("planar_2r", "arm")[-1] == pytest.approx(two)
    assert np.linalg.norm(points("spatial_2r", "arm")[-1]) == pytest.approx(1.0)


@pytest.mark.capability("12-29")
def test_figure_2_15() -> None:
    q1, q2, q3 = 0.7, -1.1, 0.15
    figure = mf.book.figure("2.15", q1=q1, q2=q2, q3=q3)
    arm = artist_points(figure, "scara", "arm")
    elbow = 0.325 * np.array([np.cos(q1), np.sin(q1)])
    wrist = elbow + 0.275 * np.array([np.cos(q1 + q2), np.sin(q1 + q2)])
    assert arm[2] == pytest.approx([*elbow, 0.387])
    assert arm[3] == pytest.approx([*wrist, 0.387])
    assert arm[4] == pytest.approx([*wrist, 0.387 - q3])
    assert (figure["joints"], figure["dimension"]) == (4, 4)
    for k in range(1, 5):
        axis = np.diff(artist_points(figure, "scara", f"axis {k}"), axis=0)[0]
        assert axis[:2] == pytest.approx([0, 0], abs=1e-12)


@pytest.mark.capability("12-30")
def test_figure_2_16() -> None:
    figure = mf.book.figure("2.16", bend=1.0, azimuth=-0.4)
    robot, q = figure.objects["robot"], np.array(figure.objects["q"])
    points = drawn(figure)
    start, end = points("arm", "nozzle")
    nozzle = (end - start) / np.linalg.norm(end - start)
    assert points("arm", "arm")[-1] == pytest.approx(start)
    spun = robot.fk(q + np.eye(6)[5])
    assert spun[:3, 3] == pytest.approx(start)  # the last joint turns about the nozzle: the paint does not change
    assert spun[:3, 0] == pytest.approx(nozzle)
    assert (figure["joints"], figure["dimension"]) == (6, 5)
