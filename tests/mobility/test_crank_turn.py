"""Linkages driven once round: curves against equations, accelerations against differences, forces against work."""

import numpy as np
import pytest

from mafsil import InputError, MafsilError, ModelError
from mafsil.mobility import FourBar, Linkage, joint, library
from mafsil.mobility.crank_range import TurnStatus
from mafsil.mobility.linkages import (
    BodyLoad,
    BodyMass,
    Coupling,
    LinkageLoads,
    read_linkage,
    read_loads,
    turn_crank,
    write_plates,
)
from tests.mobility import mechanisms

UPRIGHT = (0.0, -9.81)


def foot_of(turn, body, at):
    return turn.point(body, at)[0][:, :2]


def masses_of(linkage, rng):
    every = [BodyMass(body, rng.uniform(0.5, 2), rng.normal(size=2), rng.uniform(0, 1)) for body in linkage.bodies[1:]]
    return LinkageLoads(every, [BodyLoad(linkage.output, rng.normal(size=2), rng.normal(size=2))], UPRIGHT)


@pytest.mark.parametrize(("leg", "places"), [("jansen", "jansen_places"), ("klann", "klann_places")])
def test_walking_legs_follow_their_circles(leg, places):
    linkage, where = getattr(mechanisms, leg)(), getattr(mechanisms, places)
    crank = linkage.joints[0].name
    turn = turn_crank(linkage, crank)
    assert turn
    assert (turn.status, turn.turns) == (TurnStatus.ROUND, 1)
    expected = where(0.4 + turn.angle)["foot"]
    np.testing.assert_allclose(foot_of(turn, linkage.output, where(np.array(0.4))["foot"]), expected, atol=1e-9)


def test_exact_straight_lines():
    linkage, places = mechanisms.hart()
    turn = turn_crank(linkage, "G")
    across = (places["G"] - places["O"]) / np.linalg.norm(places["G"] - places["O"])
    assert np.ptp(foot_of(turn, "output", places["Q"]) @ across) < 1e-10 < np.ptp(turn.angle)
    found = turn_crank(library.peaucellier(), "A")
    assert (found.status, len(found.ends)) == (TurnStatus.BETWEEN, 2)
    assert all(each.in_line and len(each.moving) == 3 for each in found.ends)
    Q = next(each.point for each in found.linkage.joints if each.name == "Q")
    assert np.ptp(foot_of(found, "side 3", Q)[:, 0]) < 1e-10


def test_watts_curve_is_its_sextic():
    a, b, c = 2.0, 1.6, 0.9
    bar = FourBar(b, 2 * c, b, 2 * a)
    low, high = bar.input_range
    linkage = bar.linkage((low + high) / 2)
    turn = turn_crank(linkage, "A")
    assert turn.status is TurnStatus.BETWEEN
    B, C = (next(each.point for each in linkage.joints if each.name == name) for name in "BC")
    x, y = (foot_of(turn, "coupler", (B + C)[:2] / 2) - [a, 0]).T
    r2, s = x**2 + y**2, y**2
    sextic = r2 * (r2 - a**2 - b**2 + c**2) ** 2 + 4 * a**2 * s * (r2 - b**2)
    assert np.abs(sextic).max() < 1e-10


@pytest.mark.parametrize("lengths", [(1, 2.5, 2.5, 2), (2.5, 1, 2.5, 2)], ids=["Hoecken", "Chebyshev"])
def test_approximate_straight_lines(lengths):
    crank, coupler, rocker, ground = lengths
    linkage = FourBar(*lengths).linkage(*((np.pi / 2, 0) if crank == 1 else (0.9, 1)))
    turn = turn_crank(linkage, "A")
    B, C = (next(each.point[:2] for each in linkage.joints if each.name == name) for name in "BC")
    T = B + 2 * (C - B) if crank == 1 else (B + C) / 2
    pin, end = foot_of(turn, "crank", B), foot_of(turn, "coupler", C)
    np.testing.assert_allclose(np.linalg.norm(pin, axis=1), crank)
    np.testing.assert_allclose(np.linalg.norm(end - [ground, 0], axis=1), rocker)
    np.testing.assert_allclose(np.linalg.norm(end - pin, axis=1), coupler)
    path = foot_of(turn, "coupler", T)
    straight = (
        path[np.abs(turn.theta[:, 0] + np.pi / 2 - np.pi) < np.pi / 2]
        if crank == 1
        else path[(np.abs(path[:, 0] - 1) < 1) & (path[:, 1] < 2.1)]
    )
    assert np.ptp(straight[:, 1]) < 0.02 * np.ptp(path[:, 0])


LINKAGES = {
    "four-bar": (library.four_bar, "A"),
    "slider-crank": (library.slider_crank, "A"),
    "quick return": (library.quick_return, "A"),
    "Jansen": (mechanisms.jansen, "O"),
    "Klann": (mechanisms.klann, "A"),
    "Watt six-bar": (library.watt, "01"),
    "parallelogram": (library.parallelogram, "A"),
    "Peaucellier": (library.peaucellier, "A"),
    "trammel": (library.elliptic_trammel, "X"),
    "Bennett": (library.bennett, None),
}


@pytest.mark.parametrize("name", LINKAGES)
def test_rates_against_differences_and_forces_against_work(name):
    build, crank = LINKAGES[name]
    linkage = build()
    loads = masses_of(linkage, np.random.default_rng(5))
    turn = turn_crank(linkage, crank, speed=1.3, rows=1500, loads=loads)
    assert turn
    size = linkage.size
    power = turn.loads.torque * turn.rates[:, linkage.columns_of([turn.crank])[0]]
    energy, given = np.zeros(len(power)), np.zeros(len(power))
    for each in loads.masses:
        x, v, a = turn.point(each.body, each.center)
        w = turn.twists[:, linkage.bodies.index(each.body), :3]
        R = turn.poses[:, linkage.bodies.index(each.body), :3, :3]
        spin = np.einsum("kji,kj->ki", R, w)
        energy += (
            each.mass * ((v**2).sum(1) / 2 - x @ loads.gravity) + np.einsum("ki,ij,kj->k", spin, each.inertia, spin) / 2
        )
        for k in range(turn.arc.max() + 1):
            rows = np.flatnonzero(turn.arc == k)
            dv = np.gradient(v[rows], turn.time[rows], axis=0)[2:-2]
            dx = np.gradient(x[rows], turn.time[rows], axis=0)[2:-2]
            np.testing.assert_allclose(dx, v[rows][2:-2], atol=3e-4 * np.abs(v).max())
            np.testing.assert_allclose(dv, a[rows][2:-2], atol=3e-3 * np.abs(a).max())
    for each in loads.loads:
        given += turn.point(each.body, each.at)[1] @ each.force
    for k in range(turn.arc.max() + 1):
        rows = np.flatnonzero(turn.arc == k)
        work = np.gradient(energy[rows], turn.time[rows])[2:-2] - given[rows][2:-2]
        np.testing.assert_allclose(power[rows][2:-2], work, atol=1e-3 * np.abs(power).max() + 1e-12 * size)


def test_pin_force_of_a_rod_is_the_work_of_its_stretch():
    bar, step = FourBar(1.0, 2.6, 2.2, 2.8), 1e-5
    loads = LinkageLoads([BodyMass("rocker", 3.0, (2.3, 1.0), 0.0)], [], UPRIGHT)
    turn = turn_crank(bar.linkage(0.7), "A", speed=1e-9, rows=24, loads=loads)
    C = next(each.point for each in turn.linkage.joints if each.name == "C")
    D = np.array([2.8, 0.0, 0.0])
    weight = np.array([2.3, 1.0, 0.0]) - D

    def height(longer, angle):
        """Of the mass of the rocker when the coupler is longer and the crank held."""
        B = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        moved = mechanisms.at_lengths(B, 2.6 + longer, D[:2], 2.2, 1) - D[:2]
        turned = np.arctan2(moved[:, 1], moved[:, 0]) - np.arctan2(*(C - D)[1::-1])
        return np.sin(turned) * weight[0] + np.cos(turned) * weight[1]

    push = 3.0 * 9.81 * (height(step, 0.7 + turn.angle) - height(-step, 0.7 + turn.angle)) / (2 * step)
    force = turn.loads.forces[:, turn.loads.joints.index("C"), :2]
    np.testing.assert_allclose(np.linalg.norm(force, axis=1), np.abs(push), rtol=1e-6, atol=1e-6)
    assert turn.loads.unique


def test_transmission_angle_is_the_angle_of_coupler_and_rocker():
    bar = FourBar(1.0, 2.6, 2.2, 2.8)
    turn = turn_crank(bar.linkage(0.7), "A")
    assert turn.followers == ("D",)
    d2 = 1.0 + 2.8**2 - 2 * 2.8 * np.cos(0.7 + turn.angle)
    mu = np.arccos((2.6**2 + 2.2**2 - d2) / (2 * 2.6 * 2.2))
    np.testing.assert_allclose(turn.transmission[:, 0], np.minimum(mu, np.pi - mu), atol=1e-9)
    slotted = turn_crank(library.quick_return())
    np.testing.assert_allclose(slotted.transmission, np.pi / 2)


def test_a_crank_that_cannot_go_round_tells_between_which_angles_and_why():
    bar = FourBar(3.0, 4.0, 3.5, 4.6)
    turn = turn_crank(bar.linkage(1.0), "A", rows=50)
    assert (turn.status, turn.turns) == (TurnStatus.BETWEEN, 0)
    low, high = bar.input_range
    np.testing.assert_allclose(np.array(turn.range) + 1.0, [low if low > 0 else -high, high], atol=1e-9)
    assert all(each.moving == ("B", "C", "D") and each.in_line for each in turn.ends)
    assert "pins B, C, D on one line" in turn.explain("en")
    assert np.isfinite(turn.accelerations).all()
    assert np.abs(turn.rates[:, 0]).max() == pytest.approx(1.0, rel=1e-3)


def test_limits_of_joints_end_the_motion():
    free = FourBar(2, 4, 3.5, 4.5).linkage(1.0)
    joints = [
        joint(e.name, "R", [e.parent, e.child], e.point, limits=(-0.5, 0.7) if e.name == "D" else (-9, 9))
        for e in free.joints
    ]
    turn = turn_crank(Linkage.of(joints, planar=True, output="coupler"), "A")
    assert {each.limit for each in turn.ends if each.limit} == {"D"}
    D = turn.theta[:, turn.linkage.columns_of(["D"])[0]]
    assert np.abs(np.clip(D, -0.5, 0.7) - D).max() < 1e-9


def test_gears_and_cams():
    gears = Linkage.of(
        [joint("A", "R", ["ground", "a"], [0, 0], actuated=True), joint("D", "R", ["ground", "d"], [3, 0])],
        planar=True, output="d", couplings=[Coupling("D", "A", -1.5)],
    )  # fmt: skip
    turn = turn_crank(gears, loads=LinkageLoads([], [BodyLoad("d", moment=(0, 0, 2.0))]))
    assert (turn.status, turn.turns) == (TurnStatus.ROUND_SEVERAL, 2)
    np.testing.assert_allclose(turn.loads.torque, 3.0)
    angle = np.linspace(0, 2 * np.pi, 61)
    lift = 0.05 * (1 - np.cos(angle)) / 2
    cam = Linkage.of(
        [joint("A", "R", ["ground", "cam"], actuated=True), joint("S", "P", ["ground", "valve"], [0, 1], [0, 1])],
        planar=True, output="valve", couplings=[Coupling("S", "A", table=tuple(zip(angle, lift, strict=True)))],
    )  # fmt: skip
    turn = turn_crank(cam, speed=10.0, loads=LinkageLoads([BodyMass("valve", 2.0)], [], UPRIGHT))
    c = turn.angle
    np.testing.assert_allclose(turn.theta[:, 1], 0.025 * (1 - np.cos(c)), atol=1e-7)
    np.testing.assert_allclose(turn.accelerations[:, 1], 2.5 * np.cos(c), atol=3e-3)
    np.testing.assert_allclose(turn.loads.torque, 2.0 * (2.5 * np.cos(c) + 9.81) * 0.025 * np.sin(c), atol=2e-4)


FILE = """
planar = true
gravity = [0, -9.81]
joint = [
    {name = "A", kind = "R", bodies = ["ground", "crank"], at = [0, 0], actuated = true},
    {name = "B", kind = "R", bodies = ["crank", "rod"], at = [1, 0]},
    {name = "C", kind = "R", bodies = ["rod", "block"], at = [4, 0], child_at = [9, 0]},
    {name = "D", kind = "P", bodies = ["block", "ground"], at = [9, 0], axis = [1, 0]},
]
body = [{name = "block", mass = 2, center = [9, 0]}]
load = [{body = "block", at = [9, 0], force = [-100, 0]}]
"""


def test_files_have_masses_and_loads(tmp_path):
    path = tmp_path / "press.toml"
    path.write_text(FILE)
    assert (read_linkage(path).loops, len(read_loads(path).masses)) == (1, 1)
    turn = turn_crank(str(path), speed=2.0)
    _, v, a = turn.point("block", turn.linkage.joints[3].point)
    np.testing.assert_allclose(turn.loads.torque * 2.0, (2.0 * a + [100, 0, 0])[:, 0] * v[:, 0], atol=1e-8)
    for right, wrong, sentence in (
        ("mass = 2,", "", "mass is missing"), ("force =", "thrust =", "unknown key thrust"),
        ("mass = 2", "mass = -2", "mass"),
        ('load = [{body = "block"', 'load = [{body = "blok"', "body blok, which is not there"),
    ):  # fmt: skip
        path.write_text(FILE.replace(right, wrong))
        with pytest.raises(MafsilError, match=sentence):
            turn_crank(path)


def test_wrong_input_is_refused():
    with pytest.raises(ModelError, match="driven joint"):
        turn_crank(library.five_bar())
    with pytest.raises(InputError, match="speed"):
        turn_crank(library.four_bar(), "A", speed=0.0)
    with pytest.raises(InputError, match="mobility by rank is 2"):
        turn_crank(library.five_bar(), "O")
    with pytest.raises(ModelError, match="which is not there"):
        turn_crank(library.four_bar(), "A", loads=LinkageLoads([BodyMass("wheel", 1.0)]))
    with pytest.raises(InputError, match="principal moments"):
        BodyMass("a", 1.0, (0, 0), (1.0, 1.0, 5.0))
    with pytest.raises(InputError, match="over one turn"):
        Coupling("S", "A", table=((0, 0), (1, 1), (2, 0), (3, 0)))


def test_plates_that_cannot_be_cut_are_refused(tmp_path):
    bar, path = library.four_bar(), tmp_path / "bar.svg"
    for details in ({"width": 0.01, "hole": 0.02}, {"width": 0.0}, {"hole": np.nan}, {"width": 1e308}):
        with pytest.raises(InputError):
            write_plates(bar, path, **details)
    with pytest.raises(InputError, match=r"\.svg, \.dxf"):
        write_plates(bar, tmp_path / "bar.step")
    write_plates(bar, path, width=0.3, hole=0.1)
    assert path.read_text().count("<circle") == 8
