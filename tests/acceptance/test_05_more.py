"""Further worked numbers of forward and velocity kinematics and of statics, each through the public functions."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.model.dh_from_axes import inverse_product, mixed_product, screws
from mafsil.model.exponentials import representations
from mafsil.model.library import textbook
from mafsil.performance import (
    holding_torque,
    joint_reactions,
    largest_speed,
    scaled_jacobian,
    singularity,
    velocity_ellipsoid,
    virtual_work,
)
from mafsil.performance.dexterity import least_joint_rate
from mafsil.performance.singularities import rank_of_screws
from mafsil.performance.statics import LinkLoad
from tests.acceptance.reading import cases, unread_after

CASES = cases("05-more.json")


def near(case, got, expected):
    np.testing.assert_allclose(got, np.asarray(expected, dtype=float), rtol=0, atol=case["tol"])


@pytest.mark.capability("05-90", "05-91")
def test_mixed_products_and_the_inverse():
    case = CASES["c56-101-mixed-poe-and-inverse"]
    given, want = case["inputs"], case["expected"]
    arm = mf.Robot.from_screws(given["S"], given["M"])
    near(case, screws(arm.mechanism).S_b, want["B"])
    for k in given["k"]:
        near(case, mixed_product(arm, given["theta"], k), want["T"])
    near(case, arm.forward_kinematics(given["theta"]), want["T"])
    near(case, inverse_product(arm, given["theta"]), want["T_bs"])
    near(case, given["L1"] + given["L2"], given["M"][1][3])
    drawn = mf.Robot(textbook.rrprrr(given["L1"], given["L2"]))
    near(case, drawn.forward_kinematics(given["theta"]), want["T"])


@pytest.mark.capability("05-96", "05-8")
def test_independent_parameters():
    case = CASES["c56-103-independent-parameter-count"]
    want = case["expected"]
    for name, (revolute, prismatic) in case["inputs"]["robots"].items():
        by_name = {each.name: each for each in representations(revolute, prismatic)}
        assert {each.independent for each in by_name.values()} == {want["independent"][name]}
        assert by_name["denavit_hartenberg"].numbers == want["written_DH"][name]
        assert by_name["free_frames"].numbers == want["written_free_frames"][name]
        assert by_name["exponentials"].numbers == want["written_PoE"][name]
    assert case["tol"] == 0


@pytest.mark.capability("05-99")
def test_a_linear_complex_is_none_of_the_five_cases():
    case = CASES["c56-105-linear-complex-none-of-five"]
    S, want = np.array(case["inputs"]["S"]), case["expected"]
    arm = mf.Robot.from_screws(S, np.eye(4), normalise=True)
    found = singularity(arm, np.zeros(6))
    assert found.rank == want["rank"]
    assert [cause.number for cause in found.causes if cause.number] == want["case_numbers"]
    assert [cause.case for cause in found.causes] == ["complex"]
    near(case, found.wrenches[0] / found.wrenches[0][5], want["reciprocal_wrench_scaled_fz_1"])
    near(case, found.reciprocal_screws[0].pitch, want["reciprocal_pitch"])
    near(case, found.null_rates[0] / found.null_rates[0][0], want["null_rates_scaled"])
    plain = rank_of_screws(S)
    assert plain.rank == want["rank"]
    near(case, plain.null_rates[0] / plain.null_rates[0][0], want["null_rates_scaled"])
    near(case, plain.reciprocal[0] / plain.reciprocal[0][5], want["reciprocal_wrench_scaled_fz_1"])
    smallest = min(np.linalg.svd(np.delete(S, k, axis=0), compute_uv=False)[-1] for k in range(6))
    near(case, smallest, want["smallest_singular_value_of_any_five"])
    assert all(rank_of_screws(np.delete(S, k, axis=0)).rank == 5 for k in range(6))


@pytest.mark.capability("05-104", "05-64")
def test_loads_on_every_link():
    case = CASES["c56-107-virtual-work-loads-on-every-link"]
    given, want = case["inputs"], case["expected"]
    arm = mf.Robot(textbook.planar3r(given["L"]).with_gravity(np.zeros(3)))
    q = given["theta"]
    loads = [
        LinkLoad(arm.mechanism.link_names[load["link"]], [*load["f"], 0.0], [0, 0, load["m"]], [load["s"], 0, 0])
        for load in given["loads"]
    ]
    tau = holding_torque(arm, q, loads)
    near(case, tau, want["tau"])
    reactions = joint_reactions(arm, q, loads=loads)
    near(case, reactions.about_origin[:3, 3:5], want["joint_force_on_link"])
    near(case, reactions.torque, want["tau"])
    assert virtual_work(arm, q, loads, tau)
    assert not virtual_work(arm, q, loads, tau + np.array([0, 1e-3, 0]))


@pytest.mark.capability("05-101", "05-107", "05-85")
def test_effort_along_a_direction():
    case = CASES["c56-109-effort-along-a-direction"]
    given, want = case["inputs"], case["expected"]
    two = given["twoR"]
    arm, q = mf.Robot(textbook.planar2r(two["L"])), two["theta"]
    angles = np.radians(two["directions_deg"])
    along = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    near(case, [least_joint_rate(arm, q, u, "planar") for u in along], want["twoR_effort"])
    near(case, [largest_speed(arm, q, u, "planar") for u in along], want["twoR_speed"])
    six = given["sixR"]
    arm6 = mf.Robot.from_screws(six["S"], six["M"])
    assert six["M"][1][3] == pytest.approx(3 * six["L"])
    assert six["directions"].startswith("x,y,z of the fixed frame")
    assert six["part"] == "tip point"
    near(case, [least_joint_rate(arm6, six["theta"], u) for u in np.eye(3)], want["sixR_effort"])
    folded = given["folded"]
    for lengths in folded["L"]:
        key = ",".join(f"{x:g}" for x in lengths)
        found = velocity_ellipsoid(mf.Robot(textbook.planar2r(lengths)), folded["theta"], "planar")
        near(case, found.lengths, [want["folded_half_length"][key], 0.0])
        assert found.dimension == 1
    for length in given["lengths"]:
        s = np.linalg.svd(scaled_jacobian(arm6, six["theta"], task="pose", length=length).J, compute_uv=False)
        near(case, s[0] / s[-1], want["ratio_of_scaled_body_jacobian"][str(float(length))])


def test_every_key_of_every_case_is_read(request):
    del request  # an argument, so that the guard does not call itself
    assert unread_after(globals(), CASES) == []
