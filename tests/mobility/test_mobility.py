"""Mobility counted, by rank and finite, of mechanisms whose answers are known."""

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil import mobility as mo
from mafsil.mobility.actuation import ActuationStatus
from mafsil.mobility.finite import screw_rates
from mafsil.mobility.gruebler import StructureStatus
from mafsil.mobility.linkages import loop_closure as closure
from mafsil.mobility.linkages.loop_closure import loop_state, reduced_screws
from tests.mobility.mechanisms import five_bar, four_bar, parallel_cranks, platform, three_upu

OPEN = [(0, 0), (1, 2), (4, 3), (4, 0)]


def twist_nullity(linkage):
    """The other method: twists of all bodies as unknowns, one set of rows for each joint."""
    N, rows = len(linkage.bodies), []
    hat = reduced_screws(linkage)
    for k, (a, b) in enumerate(linkage.ends):
        S = hat[:, linkage.joint_of == k]
        U, s, _ = np.linalg.svd(S, full_matrices=True) if S.shape[1] else (np.eye(6), np.zeros(0), None)
        W = U[:, int((s > 1e-12).sum()) :]
        row = np.zeros((W.shape[1], 6 * N))
        row[:, 6 * b : 6 * b + 6], row[:, 6 * a : 6 * a + 6] = W.T, -W.T
        rows.append(row)
    A = np.vstack(rows)[:, 6:]
    s = np.linalg.svd(A, compute_uv=False)
    return A.shape[1] - int((s > 1e-9 * s[0]).sum())


@pytest.mark.capability("02-49", "02-51")
@pytest.mark.parametrize(
    ("linkage", "counted", "here", "finite", "status"),
    [
        (four_bar(OPEN), 1, 1, 1, "MOVES"),
        (four_bar(OPEN, planar=False), 1, 1, 1, "MOVES"),
        (four_bar([(0, 0), (1, 0), (2, 0), (3, 0)]), 1, 2, 0, "ONLY_INSTANTANEOUS"),
        (four_bar([(0, 0), (1, 0), (3, 0), (2, 0)]), 1, 2, 1, "BRANCH_POINT"),
        (four_bar([(0, 0), (0.5, 1), (2.5, 1), (2, 0)]), 1, 1, 1, "MOVES"),
        (parallel_cranks([1.0] * 3), 0, 1, 1, "MOVES_DEPENDENT"),
        (parallel_cranks([0.0] * 3), 0, 2, 1, "SHAKY"),
        (parallel_cranks([1.0, 1.2, 1.4]), 0, 0, 0, "RIGID"),
        (platform("U", np.random.default_rng(1)), 6, 6, 6, "MOVES"),
        (platform("S", np.random.default_rng(1)), 12, 12, 12, "MOVES"),
        (three_upu("tangent"), 3, 3, 3, "MOVES"),
        (three_upu("radial", (0.2, 0.1, 0)), 3, 3, 3, "MOVES"),
        (three_upu("radial"), 3, 5, 3, "BRANCH_POINT"),
    ],
    ids=lambda value: value.name if isinstance(value, mo.Linkage) else str(value),
)
def test_named_mechanisms(linkage, counted, here, finite, status):
    found = mf.mobility(linkage)
    assert (found.count.mobility, found.instantaneous.mobility, found.mobility) == (counted, here, finite)
    assert found.status is mo.report.MobilityStatus[status]
    assert bool(found) is (finite > 0)
    assert twist_nullity(linkage) == here
    assert all(found.explain(language).split("\n") for language in ("en", "ar"))


@pytest.mark.capability("02-54")
def test_legs_that_spin_are_idle():
    found = mo.instantaneous_mobility(platform("S", np.random.default_rng(2)))
    assert found.output_mobility == 6
    assert [(one.joints, one.count) for one in found.idle] == [((f"A{k}", f"B{k}"), 1) for k in range(6)]
    assert mo.instantaneous_mobility(platform("U", np.random.default_rng(2))).idle == ()


@pytest.mark.capability("02-52")
def test_five_bar_with_every_pair_locked():
    overlapped = mo.mobility_with_locked_joints(five_bar((1, 1), (1, 1)), 2)
    assert {pair for pair, left in overlapped.items() if left} == {("O", "D"), ("O", "M"), ("M", "D")}
    assert set(mo.mobility_with_locked_joints(five_bar((0.3, 1), (1.7, 1.1)), 2).values()) == {0}
    for pair, left in overlapped.items():
        linkage = mo.linkages.lock_joints(five_bar((1, 1), (1, 1)), pair)
        assert mo.instantaneous_mobility(linkage).mobility == left == mo.locked_mobility(five_bar((1, 1), (1, 1)), pair)
    assert mo.gruebler(mo.linkages.lock_joints(five_bar((1, 1), (1, 1)), ("O", "D"))).mobility == 0


def test_wrong_choice_of_motors_is_said():
    bad = mo.actuation(five_bar((1, 1), (1, 1)), joints=["O", "D"])
    assert bad.status is ActuationStatus.SINGULAR_CHOICE
    assert not bad
    assert mo.actuation(five_bar((0.3, 1), (1.7, 1.1)), joints=["O", "D"]).status is ActuationStatus.FULL
    assert mo.actuation(five_bar((0.3, 1), (1.7, 1.1)), joints=["O"]).status is ActuationStatus.UNDERACTUATED
    over = mo.actuation(five_bar((0.3, 1), (1.7, 1.1)), joints=["O", "M", "D"])
    assert over.status is ActuationStatus.REDUNDANT
    assert over.antagonistic == 1
    assert mo.actuation(platform("S", np.random.default_rng(2))).status is ActuationStatus.IDLE_LEFT


@pytest.mark.capability("02-46", "02-47", "02-48", "02-50")
def test_count_by_numbers_and_its_warnings():
    four = mo.gruebler_count(4, [1] * 4, "planar")
    assert four.mobility == 1
    assert "3 (4 - 1 - 4) + 4 = 1" in four.explain("en")
    assert mo.gruebler_count(4, [1] * 4, "spatial").mobility == -2
    assert not mo.gruebler_count(4, [1] * 4, "spatial")
    assert "the rank decides" in mo.gruebler_count(4, [1] * 4, "spatial").explain("en")
    wrong = mo.gruebler(four_bar(OPEN, planar=False), rule="spatial")
    assert (wrong.mobility, wrong.warnings) == (-2, ("warn_planar_as_spatial",))
    assert mo.gruebler(platform("U", np.random.default_rng(0)).with_output("platform")).warnings == ()
    assert mo.mobility(mo.library.truss()).status is mo.report.MobilityStatus.RIGID
    body = mo.Linkage.of([mo.joint("F", "floating", ["ground", "body"])])
    with pytest.raises(mf.InputError, match="3 freedoms"):
        mo.gruebler(body, rule="planar")


@pytest.mark.capability("02-41")
def test_split_joints_leave_count_and_mobility():
    for linkage, links, joints in (
        (platform("U", np.random.default_rng(3)), 32, 36),
        (platform("S", np.random.default_rng(3)), 38, 42),
    ):
        fine = mo.linkages.split_joints(linkage)
        assert (len(fine.bodies), len(fine.joints)) == (links, joints)
        assert mo.gruebler(fine).mobility == mo.gruebler(linkage).mobility
        assert mo.instantaneous_mobility(fine).mobility == mo.instantaneous_mobility(linkage).mobility
        assert np.allclose(fine.screws, linkage.screws)


@pytest.mark.parametrize(
    "make", [lambda: platform("S", np.random.default_rng(5)), lambda: three_upu("radial"), lambda: four_bar(OPEN)]
)
def test_second_derivatives_of_the_gaps(make):
    linkage = make()
    moved = screw_rates(linkage, reduced_screws(linkage, loop_state(linkage).screws))
    K = np.einsum("lk,kir->lrik", linkage.cycles[:, linkage.joint_of], moved).reshape(-1, *moved.shape[:2])
    scale = mo.linkages.loop_closure.units(linkage)
    for v in mo.instantaneous_mobility(linkage).rates.T:
        h = 1e-5
        numeric = (
            (mo.linkages.loop_matrix(linkage, h * v * scale) - mo.linkages.loop_matrix(linkage, -h * v * scale))
            / (2 * h)
            @ v
        )
        np.testing.assert_allclose(np.einsum("rij,i,j->r", K, v, v), numeric, atol=1e-8)


@pytest.mark.capability("02-59")
def test_rates_of_the_loop_matrix_are_derivatives_of_the_gap():
    linkage = platform("S", np.random.default_rng(6))
    rng = np.random.default_rng(7)
    theta = mo.linkages.close_loops_near(linkage, 0.1 * rng.normal(size=(4, linkage.coordinates))).theta
    A, scale = mo.linkages.loop_matrix(linkage, theta), mo.linkages.loop_closure.units(linkage)
    v, h = rng.normal(size=linkage.coordinates), 1e-6
    numeric = (loop_state(linkage, theta + h * v * scale).gap - loop_state(linkage, theta - h * v * scale).gap) / (
        2 * h
    )
    np.testing.assert_allclose(np.einsum("brf,f->br", A, v), numeric, atol=1e-7)


def test_mechanism_with_loops_and_back():
    linkage = platform("U", np.random.default_rng(8))
    mechanism = mo.mechanism_of(linkage)
    assert (mechanism.n, len(mechanism.loops)) == (31, 5)
    found = mf.mobility(mechanism)
    assert (found.mobility, found.count.links, found.count.joints) == (6, 32, 36)
    assert mf.mobility("ur5e").mobility == 6
    robot = mf.Robot(mechanism)
    assert robot.forward_kinematics(np.zeros(mechanism.n)).shape == (4, 4)
    four = mo.mechanism_of(four_bar(OPEN))
    moved = mf.mobility(four, [0.2, 0.0, 0.0])
    assert moved.mobility == 1
    assert abs(moved.linkage.joints[1].point[0] - 1.0) > 0.01


FILE = """
planar = true
output = "b"
bodies = ["ground", "a", "b"]
[[joint]]
name = "A"
kind = "R"
bodies = ["ground", "a", "b"]
at = [0, 0]
[[joint]]
kind = "R"
bodies = ["b", "ground"]
at = [1, 0]
"""


@pytest.mark.capability("02-40")
def test_pin_through_three_links_is_two_joints(tmp_path):
    path = tmp_path / "pin.toml"
    path.write_text(FILE)
    linkage = mo.read_linkage(path)
    assert [(each.name, each.parent, each.child) for each in linkage.joints] == [
        ("A-1", "ground", "a"), ("A-2", "a", "b"), ("J2", "b", "ground"),
    ]  # fmt: skip
    assert mf.mobility(path).count.mobility == 0


@pytest.mark.capability("02-38", "02-40")
def test_names_of_joints_and_pins_through_many_bodies():
    words = {
        "hinge": "R", "Revolute": "R", "translational": "P", "linear": "P", "screw": "H", "ball-and-socket": "S",
        "Ball and socket": "S", "hooke": "U", "rp": "RP", "e": "E",
    }  # fmt: skip
    for word, letter in words.items():
        assert mo.joint("J", word, ["a", "b"], second=[1, 0, 0], pitch=0.1).kind is mo.linkages.KINDS[letter]
    with pytest.raises(mf.ModelError, match="glue is not a kind of joint"):
        mo.joint("J", "glue", ["a", "b"])
    with pytest.raises(mf.ModelError, match="coincident_joints"):
        mo.joint("J", "R", ["a", "b", "c"])
    pin = mo.linkages.coincident_joints("P", "hinge", ["ground", "a", "b", "c"], [1, 0])
    assert [(one.name, one.parent, one.child) for one in pin] == [
        ("P-1", "ground", "a"), ("P-2", "a", "b"), ("P-3", "b", "c"),
    ]  # fmt: skip
    assert mf.mobility(mo.Linkage.of(pin, planar=True)).mobility == 3


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            'kind = "R"\nbodies = ["ground", "a", "b"]',
            'kind = "Q"\nbodies = ["ground", "a"]',
            "joint 1 (A): joint A: Q is not a kind",
        ),
        ('bodies = ["b", "ground"]', 'bodies = ["b", "grund"]', "no body grund"),
        ("at = [1, 0]", "at = [1, 0, 0, 0]", "joint 2: J2: at"),
        ("at = [1, 0]", 'at = "here"', "joint 2"),
        ("at = [1, 0]", "at = [1, nan]", "joint 2"),
        ("at = [1, 0]", "point = [1, 0]", "joint 2: unknown key point"),
        ("at = [1, 0]", "axis = [0, 1, 0]", "axes are normal to the plane"),
        ('output = "b"', 'output = "c"', "no body c"),
        ("planar = true", "planar = 3", "planar: expected bool"),
        ('bodies = ["b", "ground"]', "", "bodies is missing"),
    ],
)
def test_errors_of_files_name_the_place(tmp_path, old, new, said):
    path = tmp_path / "pin.toml"
    path.write_text(FILE.replace(old, new))
    with pytest.raises(mf.MafsilError) as caught:
        mo.read_linkage(path)
    assert said in str(caught.value)
    assert caught.value.message("ar")


def test_gaping_loops_are_refused_and_closed_on_request():
    linkage = four_bar(OPEN)
    with pytest.raises(mf.ModelError, match="gape"):
        mf.mobility(linkage, [0.5, 0, 0, 0])
    found = mo.linkages.close_loops_near(linkage, [0.5, 0, 0, 0], fixed=["A"])
    assert found
    assert found.theta[0] == 0.5
    assert mf.mobility(linkage, found.theta).mobility == 1
    lost = mo.linkages.close_loops_near(mo.linkages.lock_joints(linkage, ["B"]), [0.5, 0, 0], fixed=["A"])
    assert not lost
    assert "were found" in lost.explain("en")


@pytest.mark.capability("02-2", "02-75")
def test_structure():
    assert mo.structure(mo.linkages.as_linkage("ur5e")).status is StructureStatus.SERIAL
    assert mo.structure(platform("U", np.random.default_rng(0))).loops == 5
    hand = mo.Linkage.of(
        [mo.joint("W", "R", ["ground", "palm"]), *(mo.joint(f"F{k}", "R", ["palm", f"f{k}"]) for k in range(3))]
    )
    assert mo.structure(hand).status is StructureStatus.TREE
    mixed = mo.Linkage.of([*four_bar(OPEN).joints, mo.joint("E", "R", ["coupler", "tool"], [5, 5])])
    assert mo.structure(mixed).status is StructureStatus.HYBRID
    assert mo.structure(four_bar(OPEN)).status is StructureStatus.SINGLE_LOOP


@pytest.mark.capability("02-76")
def test_rule_follows_from_the_axes():
    assert mo.gruebler(four_bar(OPEN, planar=False)).rule == "planar"
    angles = np.random.default_rng(1).normal(size=(4, 3))
    bodies = ["ground", "a", "b", "c", "ground"]
    ball = mo.Linkage.of([mo.joint(f"J{k}", "R", bodies[k : k + 2], [1, 2, 3], w) for k, w in enumerate(angles)])
    assert mo.gruebler(ball).rule == "spherical"
    assert mf.mobility(ball).mobility == mo.gruebler(ball).mobility == 1
    assert mo.gruebler(ball).group.point == pytest.approx(np.zeros(3), abs=1e-12)
    assert mo.gruebler(platform("U", np.random.default_rng(0))).rule == "spatial"
    crossed = mo.Linkage.of(
        [*four_bar(OPEN, planar=False).joints, mo.joint("E", "R", ["coupler", "tool"], [5, 5], [1, 0, 0])]
    )
    assert mo.gruebler(crossed).rule == "spatial"


@pytest.mark.capability("02-78")
def test_two_hinges_of_a_door():
    def door(tilt):
        second = [np.sin(tilt), 0, np.cos(tilt)]
        high = mo.joint("high", "R", ["ground", "door"], [0, 0, 1], second)
        return mo.Linkage.of([mo.joint("low", "R", ["ground", "door"]), high], name="door")

    right, tilted = mf.mobility(door(0.0)), mf.mobility(door(np.radians(1)))
    assert (right.count.mobility, right.mobility, right.redundancy.count) == (-4, 1, 5)
    assert tilted.mobility == 0
    assert mo.linkages.common_freedoms(*door(0.0).joints).shape[1] == 1
    assert mo.linkages.common_freedoms(*door(np.radians(1)).joints).shape[1] == 0


def test_a_search_for_closed_loops_stops_where_it_stands_still(monkeypatch):
    """A plane four-bar whose last joint lies above the plane: the gap across it stays whatever the others do."""
    looked = []
    monkeypatch.setattr(closure, "loop_state", lambda one, theta: looked.append(len(theta)) or loop_state(one, theta))
    linkage = four_bar(OPEN)
    assert mo.linkages.close_loops_near(linkage, 0.01 * np.eye(4))
    assert len(looked) <= 7
    looked.clear()
    last = linkage.joints[-1]
    above = replace(last, child_point=last.point - [0.0, 0.0, 1e-3])
    found = mo.linkages.close_loops_near(mo.Linkage.of([*linkage.joints[:-1], above]), 0.01 * np.eye(4))
    assert not found
    assert np.abs(found.gap * linkage.size - 1e-3).max() < 1e-9
    assert len(looked) <= 12


def test_a_dead_point_is_no_idle_freedom():
    """Crank and rod in line: the slider stands still for an instant, and moves with them around."""
    joints = [
        mo.joint("O", "R", ["ground", "crank"]), mo.joint("A", "R", ["crank", "rod"], [1, 0]),
        mo.joint("B", "R", ["rod", "slider"], [3, 0]), mo.joint("S", "P", ["ground", "slider"], [3, 0], [1, 0]),
    ]  # fmt: skip
    found = mf.mobility(mo.Linkage.of(joints, planar=True, output="slider"))
    assert [(one.joints, one.count) for one in found.dead_points] == [(("O", "A", "B"), 1)]
    text = found.explain("en")
    assert "dead point: O, A, B move while slider is instantaneously at rest" in text
    assert "idle freedom" not in text
    spins = mf.mobility(mo.library.six_sps())
    assert not spins.dead_points
    assert spins.explain("en").count("idle freedom (1)") == 6
