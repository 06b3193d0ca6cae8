"""Worked numbers of the specification, part 03: |got - expected| <= tol max(1, |expected|)."""

from __future__ import annotations

import json
from math import cos, sin
from pathlib import Path

import numpy as np
import pytest

from mafsil.grasp import (
    Contact,
    ContactState,
    Grasp,
    NguyenCase,
    closure,
    contact_state,
    eliminate,
    friction_angle,
    motion_within_clearance,
    nguyen,
    three_finger_forces,
    three_fingers,
)
from mafsil.grasp.closure_methods import closure_by_all_methods, reduction_and_program
from mafsil.grasp.friction import margin, soft_finger_admits
from mafsil.grasp.quality import quality_of_wrenches
from mafsil.grasp.synthesis import fixture
from mafsil.solvers.linear_program import nonnegative_solution
from mafsil.solvers.rational import Location, locate_origin

CASES = {case["id"]: case for case in json.loads(Path(__file__).with_name("03-grasp.json").read_text())}


def agree(case, got, expected):
    expected = np.asarray(expected, dtype=float)
    assert np.shape(got) == expected.shape
    assert np.all(np.abs(np.asarray(got) - expected) <= case["tol"] * np.maximum(1.0, np.abs(expected)))


def grasp_of(case):
    return Grasp([Contact(c["p"], c["n"], c.get("mu", 0.0)) for c in case["input"]["contacts"]])


def agree_columns(case, A):
    """Everything that the file says about one set of columns, and all routes against each other."""
    want = case["expected"]
    A = np.asarray(A, float)
    found = closure(A)
    assert found.force_closure == want["force_closure"]
    assert found.rank == want["rank"]
    assert {answer.closed for answer in closure_by_all_methods(A).values()} == {want["force_closure"]}
    if "origin_ball_radius" in want:
        agree(case, found.margin, want["origin_ball_radius"])
    if "null_vector_sum1" in want:
        agree(case, found.combination / found.combination.sum(), want["null_vector_sum1"])
        assert (A @ found.combination) == pytest.approx(0, abs=1e-12)
        assert found.combination.min() > 0
    reduced = reduction_and_program(A)
    if "S" in want:
        agree(case, reduced.reduction.S, want["S"])
    if "lp_mu_star_sum1" in want:
        agree(case, reduced.value, want["lp_mu_star_sum1"])
    if "omega_star" in want:
        agree(case, reduced.evidence, want["omega_star"])
    return found


def test_every_case_of_the_file_has_a_test():
    source = Path(__file__).read_text()
    assert [name for name in CASES if f'"{name}"' not in source] == []


@pytest.mark.capability("03-22")
def test_friction_angle():
    case = CASES["friction-angle"]
    alpha = friction_angle(case["input"]["mu"])
    agree(case, alpha, case["expected"]["alpha_rad"])
    agree(case, np.degrees(2 * alpha), case["expected"]["opening_2alpha_deg"])


@pytest.mark.capability("03-16", "03-17")
def test_slip_state():
    case = CASES["slip-state"]
    forces, mu = np.array(case["input"]["forces_normal_z"], float), case["input"]["mu"]
    states = [contact_state(f, mu) for f in forces]
    assert [s.admissible for s in states] == case["expected"]["admissible"]
    assert [s.sentence("en") for s in states] == case["expected"]["label"]
    agree(case, margin(forces, mu), case["expected"]["margin_mu_fz_minus_ft"])
    assert states[0] is ContactState.IMPENDING


@pytest.mark.capability("03-26")
def test_soft_finger_cone():
    case = CASES["soft-finger-cone"]
    given = case["input"]
    got = soft_finger_admits(given["f"], given["tau_values"], given["mu"], given["gamma"])
    assert got.tolist() == case["expected"]["admissible"]


@pytest.mark.capability("03-38", "03-42", "03-46")
@pytest.mark.parametrize("name", ["columns-2d-b", "rectangle-pinwheel-general"])
def test_columns(name):
    case = CASES[name]
    agree_columns(case, case["input"]["A"])


@pytest.mark.capability("03-32", "03-34", "03-45", "03-47", "03-48", "03-49")
@pytest.mark.parametrize(
    "name", ["rectangle-pinwheel", "L-shape", "five-contacts-S-combination", "cube-seven-contacts"]
)
def test_frictionless_grasps(name):
    case = CASES[name]
    grasp = grasp_of(case)
    A = grasp.matrix(order="fm")
    if "A" in case["expected"]:
        agree(case, A, case["expected"]["A"])
    agree_columns(case, A)
    assert grasp.closure().force_closure
    assert grasp.form_closure().force_closure


@pytest.mark.capability("03-43")
def test_cube_needs_all_seven_contacts():
    grasp = grasp_of(CASES["cube-seven-contacts"])
    for k in range(7):
        assert not Grasp([c for i, c in enumerate(grasp.contacts) if i != k]).closure()


@pytest.mark.capability("03-3", "03-35", "03-54")
def test_rectangle_midpoints():
    case = CASES["rectangle-midpoints"]
    grasp = grasp_of(case)
    found, free = grasp.closure(), grasp.free_motions()
    assert not found.force_closure
    assert not grasp.form_closure().force_closure
    assert found.rank == case["expected"]["rank"]
    assert len(free.reversible) == 1
    assert not len(free.rays)
    y = free.reversible[0] * np.sign(free.reversible[0][0])
    agree(case, [*y[1:], y[0]], case["expected"]["free_twist_vx_vy_wz"])
    assert np.abs(found.certificate) == pytest.approx([1, 0, 0])


@pytest.mark.capability("03-31", "03-37", "03-50")
def test_l_shape_forces():
    case = CASES["L-shape-forces"]
    given, want = case["input"], case["expected"]
    b = -np.array([*given["f_ext"], given["m_ext"]], float)
    found = nonnegative_solution(np.array(given["A"], float), b)
    agree(case, found.x, want["x"])
    agree(case, found.cost, want["sum"])
    # The family of all solutions, x_i = c_i + t: each reduced row with the free column, from one elimination.
    reduced = eliminate(np.array(given["A"], float))
    particular = reduced.right_side(b)
    assert (reduced.pivots, reduced.free) == ((0, 1, 2), (3,))
    assert reduced.S[:, 0] == pytest.approx([-1, -1, -1])
    shown = ", ".join(f"x{i + 1}={v:g}+t" for i, v in enumerate(particular))
    assert f"{shown}, x4=t, t>={max(0.0, -particular.min()):g}" == want["general"]


@pytest.mark.capability("03-10")
def test_fixture():
    case = CASES["fixture-3-2-1-with-clamp"]
    grasp = grasp_of(case)
    found = grasp.closure()
    assert found.force_closure == case["expected"]["force_closure"]
    agree(case, found.margin, case["expected"]["origin_ball_radius"])
    placed = fixture(grasp.contacts[:6], grasp.contacts[6])
    assert placed.holds
    agree(case, placed.reactions, case["expected"]["locator_reactions_per_unit_clamp"])
    limit = Grasp([*grasp.contacts[:6], Contact((0.9, 0.9, 0.6), (-1, -1, -1))]).closure()
    assert (limit.verdict, limit.exact) == ("marginal", Location.BOUNDARY)


@pytest.mark.capability("03-57")
def test_two_fingers_without_friction():
    case = CASES["two-fingers-zero-friction"]
    found = grasp_of(case).closure()
    assert (found.force_closure, found.rank) == (case["expected"]["force_closure"], case["expected"]["rank"])


@pytest.mark.capability("03-8", "03-9", "03-7")
def test_pinch_against_gravity():
    case = CASES["pinch-against-gravity"]
    given = case["input"]
    pushes = []
    for mu in given["mu"]:
        pinch = Grasp([Contact((-1, 0), (1, 0), mu), Contact((1, 0), (-1, 0), mu)])
        held = pinch.resist([0, 0, -given["mass"] * given["g"]])
        pushes.append(held.total_push / 2)
        weight = [0, 0, -given["mass"] * given["g"]]
        assert pinch.resist(weight, push=pushes[-1] * 1.001).holds
        assert not pinch.resist(weight, push=pushes[-1] * 0.999).holds
        assert pinch.closure().force_closure
        assert not pinch.form_closure().force_closure
    agree(case, pushes, case["expected"]["min_normal_force_each_side"])


@pytest.mark.capability("03-61", "03-62", "03-63")
def test_nguyen_cases():
    case = CASES["nguyen-cases"]
    want = case["expected"]
    found = {name: nguyen(np.radians(theta)) for name, theta in case["input"]["theta_deg"].items()}
    assert {name: answer.force_closure for name, answer in found.items()} == want["force_closure"]
    agree(case, found["i"].combination, want["case_i_null_vector_sum1"])
    for name, y in want["certificates"].items():
        agree(case, found[name].certificate, y)
    expected = [
        NguyenCase.FACING,
        NguyenCase.ONE_CONE,
        NguyenCase.OPPOSITE_SIDES,
        NguyenCase.SAME_SIDE,
        NguyenCase.EDGE,
    ]
    assert [found[name].status for name in ("i", "ii", "iii", "iv", "boundary")] == expected
    assert (found["both_outward"].status, found["one_outward"].status) == (NguyenCase.OUTWARD, NguyenCase.SAME_WAY)
    for answer in found.values():
        checked = closure(answer.matrix)
        assert checked.force_closure == answer.force_closure
        if answer.certificate is not None:
            assert (answer.matrix.T @ answer.certificate).min() >= -1e-12
            assert np.abs(answer.certificate).max() > 0
    assert closure(found["boundary"].matrix).verdict == "marginal"


def _ring(mu, phi):
    t = np.radians([0, 120, 240])
    points = np.column_stack([np.cos(t), np.sin(t), np.zeros(3)])
    return [Contact(p, [-cos(phi) * p[0], -cos(phi) * p[1], sin(phi)], mu) for p in points]


@pytest.mark.capability("03-66", "03-67", "03-68")
def test_three_fingers():
    case = CASES["three-fingers-spatial"]
    mu, phis = case["input"]["mu"], case["input"]["phi"]
    assert [three_fingers(_ring(mu, phi)).force_closure for phi in phis] == case["expected"]["force_closure"]
    assert [Grasp(_ring(mu, phi)).closure().force_closure for phi in phis] == case["expected"]["force_closure"]
    alpha = float(friction_angle(mu))
    for shift, want in ((-1e-3, True), (1e-3, False)):
        assert three_fingers(_ring(mu, alpha + shift)).force_closure is want
        assert Grasp(_ring(mu, alpha + shift)).closure().force_closure is want


@pytest.mark.capability("03-64")
def test_two_hard_and_two_soft_fingers():
    case = CASES["two-hard-vs-two-soft"]
    given = case["input"]
    found = [
        Grasp(
            [Contact(p, n, given["mu"], gamma) for p, n in zip(given["points"], given["normals"], strict=True)]
        ).closure()
        for gamma in (0.0, 0.1)
    ]
    assert [f.rank for f in found] == case["expected"]["wrench_rank"]
    assert [f.force_closure for f in found] == case["expected"]["force_closure"]


@pytest.mark.capability("03-69", "03-70", "03-71", "03-72")
def test_constructive_forces():
    case = CASES["constructive-forces"]
    given, want = case["input"], case["expected"]
    contacts = _ring(given["mu"], 0.0)
    points = np.array([c.point for c in contacts])
    wrench = [*given["m_ext"], *given["f_ext"]]
    built = three_finger_forces(contacts, wrench, internal=-points)
    pose = three_fingers(contacts).pose
    agree(case, built.normal_part * pose[2, 2], want["f_normal_to_S"])
    agree(case, built.in_plane @ pose[:2, :2].T, want["f_S"])
    agree(case, built.squeeze, want["lambda_min"])
    best = Grasp(contacts).resist(wrench)
    agree(case, best.total_push, want["min_total_normal_force_socp"])
    assert best.total_push - best.lower <= 1e-8 * best.total_push
    assert best.margins.min() >= -1e-9
    assert max(best.residual, built.residual) < 1e-9


@pytest.mark.capability("03-36")
def test_disc():
    case = CASES["disc-any-n"]
    a = np.array(case["input"]["angles_rad"])
    points = np.column_stack([np.cos(a), np.sin(a)])
    found = Grasp([Contact(p, -p) for p in points]).closure()
    assert (found.rank, found.force_closure) == (case["expected"]["rank"], case["expected"]["force_closure"])


@pytest.mark.capability("03-4")
def test_motion_within_clearance():
    case = CASES["wiggle"]
    A = np.roll(np.array(case["input"]["A"], float), 1, axis=0)
    found = motion_within_clearance(A, case["input"]["clearance"])
    agree(case, found.largest[0], case["expected"]["max_rotation_rad"])
    agree(case, found.largest_norm, case["expected"]["max_twist_norm"])
    agree(case, found.largest_norm, case["input"]["clearance"] / quality_of_wrenches(A).epsilon)
    assert locate_origin(A.T.tolist()).place is Location.INSIDE
