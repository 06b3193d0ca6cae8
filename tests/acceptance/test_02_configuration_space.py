"""Worked numbers of part 02 (configuration space, mobility): every case, every key, through the public face."""

import numpy as np
import pytest

import mafsil as mf
import mafsil.expression as ex
from mafsil import mobility as mo
from mafsil.mobility import library
from tests.acceptance.reading import cases, unread_after

CASES = cases("02-configuration-space.json", "02-more.json")


def near(got, expected, case, key="tol"):
    assert np.shape(got) == np.shape(expected)
    assert np.asarray(got, float) == pytest.approx(np.asarray(expected, float), abs=case[key])


@pytest.mark.capability("02-46")
def test_planar_count():
    case = CASES["C2-01-grubler-planar"]
    for given, expected in zip(case["input"], case["expected"], strict=True):
        assert mo.gruebler_count(given["N"], given["f"], "planar").mobility == expected


@pytest.mark.capability("02-47", "02-48")
def test_spatial_count():
    case = CASES["C2-02-grubler-spatial"]
    for given, expected in zip(case["input"], case["expected"], strict=True):
        assert mo.gruebler_count(given["N"], given["f"], "spatial").mobility == expected
    drawn = mo.gruebler(library.four_bar(), "spatial")
    assert drawn.mobility == case["expected"][-1]
    assert drawn.warnings == ("warn_planar_as_spatial",)


@pytest.mark.capability("02-30", "02-34", "02-37")
def test_points_of_a_rigid_body():
    case, rng = CASES["C2-03-rigid-body-points"], np.random.default_rng(0)
    for given, expected in zip(case["input"], case["expected"], strict=True):
        points = rng.normal(size=(given["n"], given["d"]))
        if given.get("special") == "collinear":
            points = np.outer(points[:, 0], [1.0, 2.0])
        elif given.get("special") == "coplanar":
            points[:, 2] = 0.3 * points[:, 0] - 0.8 * points[:, 1]
        found = mo.bodies.count_points(points)
        assert (found.constraints, found.rank) == (expected["constraints"], expected["rank"])
        assert found.redundant == expected["constraints"] - expected["rank"]
        rigid = "SHAKY" if found.nullity > found.body_dof else "RIGID"
        on_a_line = given.get("special") == "collinear" and given["d"] == 3
        assert found.status.name == ("FIX_NO_BODY" if on_a_line else rigid)
        assert found.nullity == (expected["nullity"] if "nullity" in expected else expected["dof"])
        assert found.body_dof == (expected["true_dof"] if "true_dof" in expected else expected["dof"])


@pytest.mark.capability("02-35")
def test_body_from_six_parameters():
    case = CASES["C2-05-spatial-body-six-params"]
    x = case["input"]
    angles = np.radians([x["lon_deg"], x["lat_deg"], x["psi_deg"]])
    found = mo.bodies.points_of_body(x["A"], *angles, x["d_AB"], x["d_AC"], x["d_BC"])
    near(found.B, case["expected"]["B"], case)
    near(found.C, case["expected"]["C"], case)


@pytest.mark.capability("02-58")
def test_closure_of_the_four_bar():
    case = CASES["C2-06-fourbar-closure"]
    found = mo.FourBar(*case["input"]["L"]).positions(np.radians(case["input"]["theta1_deg"]))
    for mode, expected in enumerate(case["expected"]):
        near(found.theta[mode], expected["theta"], case)
        near(found.C[mode], expected["C"], case)
        assert found.turns[mode] == expected["sum_over_pi"]


@pytest.mark.capability("02-61")
def test_rates_of_the_four_bar():
    case = CASES["C2-07-fourbar-pfaffian"]
    four = mo.FourBar(*case["input"]["L"])
    theta = four.positions(np.radians(case["input"]["theta1_deg"])).theta
    A = four.closure_matrix(theta[0])
    near(A, case["input"]["A_branch1"], case)
    assert np.linalg.matrix_rank(A) == case["expected"]["rank"]
    near(four.rates(theta)[0], case["expected"]["rates_branch1"], case)
    near(four.rates(theta)[1], case["expected"]["rates_branch2"], case)
    for mode in (0, 1):
        by_rank = mo.unit_rates(four.linkage(np.radians(case["input"]["theta1_deg"]), mode), "A")
        near(list(by_rank.values()), four.rates(theta)[mode], case)


@pytest.mark.capability("02-52", "02-51")
def test_locked_pairs_of_the_five_bar():
    case = CASES["C2-09-fivebar-lock-pairs"]
    overlapped, regular = library.five_bar(2, (1, 1), (1, 1)), library.five_bar()
    for linkage, expected in ((overlapped, case["expected"]["overlapped"]), (regular, case["expected"]["regular"])):
        left = [mo.locked_mobility(linkage, pair.split("-")) for pair in case["input"]["pairs"]]
        assert left == expected
        found = mo.instantaneous_mobility(linkage)
        assert found.mobility == case["expected"]["unlocked_mobility_both"]
        assert found.rank == case["expected"]["loop_jacobian_rank_both"]


@pytest.mark.capability("02-54")
def test_legs_that_spin():
    case = CASES["C2-10-stewart-spin"]
    for k, legs in enumerate(case["input"]["legs"]):
        found = mo.instantaneous_mobility(library.stewart_gough(legs))
        assert found.mobility == case["expected"]["mobility"][k]
        assert found.output_mobility == case["expected"]["platform_mobility"][k]
        assert sum(one.count for one in found.idle) == case["expected"]["internal_spins"][k]


@pytest.mark.capability("02-51")
def test_extra_motions_of_three_legs():
    case = CASES["C2-11-3upu-extra"]
    for given, expected in zip(case["input"], case["expected"], strict=True):
        offset = (0.2, 0.1, 0.0) if given["pose"] == "offset" else (0.0, 0.0, 0.0)
        radius = 1.0 if "platform radius 1" in given["pose"] else 0.5
        linkage = library.three_upu(given["axes"], platform=radius, offset=offset)
        locked = ["P0", "P1", "P2"] if given.get("prismatic") == "locked" else []
        found = mo.instantaneous_mobility(linkage, locked=locked)
        assert found.mobility == expected["mobility"]
        if "rotational" in expected:
            assert found.output_rotations == expected["rotational"]


@pytest.mark.capability("02-64")
def test_motions_of_the_coin():
    case = CASES["C2-13-rolling-coin-motions"]
    one, two = case["input"]["case1"], case["input"]["case2"]
    start = [np.pi / 6 if word == "pi/6" else float(word) for word in one["q0"]]
    end = mo.bodies.Coin(one["r"]).drive(start, one["phi_dot"], one["theta_dot"], one["T"])
    near(end, case["expected"]["case1"], case)
    quarter = np.pi / 2
    path = mo.bodies.Coin(two["r"]).manoeuvre(two["q0"], [(0, 1), (quarter, 0), (0, -1), (-quarter, 0)])
    near(path[-1], case["expected"]["case2"], case)


def four_bar_rows(lengths):
    def rows(q):
        s = [q[0]]
        for k in range(1, 4):
            s.append(s[-1] + q[k])
        x, y = (
            [L * ex.cos(a) for L, a in zip(lengths, s, strict=True)],
            [L * ex.sin(a) for L, a in zip(lengths, s, strict=True)],
        )
        return [
            [-sum(y[k] for k in range(j, 4)) for j in range(4)],
            [sum(x[k] for k in range(j, 4)) for j in range(4)],
            [1] * 4,
        ]

    return rows


@pytest.mark.capability("02-62", "02-63")
def test_integrability():
    case = CASES["C2-14-integrability"]
    lengths = (2, 4, 3.5, 4.5)
    regular = tuple(mo.FourBar(*lengths).positions(1.0).theta[0])
    systems = {
        "coin 2x4": mo.bodies.Coin(0.02).constraints,
        "unicycle [sin phi,-cos phi,0]": mo.bodies.Unicycle().constraints,
        "four-bar dg/dtheta (any regular pose)": mo.spaces.Pfaffian(tuple("abcd"), four_bar_rows(lengths), regular),
        "[z,z,1] in (x,y,z)": mo.spaces.Pfaffian(tuple("xyz"), lambda q: [[q[2], q[2], 1]], (0.0, 0.0, 2.0)),
    }
    integrals = {"x+y+ln z": lambda q: q[0] + q[1] + ex.log(q[2])}
    for name, expected in zip(case["input"], case["expected"], strict=True):
        found = systems[name].integrability
        assert (found.closed, bool(found), list(found.growth)) == (
            expected["closed"], expected["integrable"], expected["growth"],
        )  # fmt: skip
        if "first_integral" in expected:
            assert systems[name].keeps(integrals[expected["first_integral"]])
            assert not systems[name].keeps(lambda q: q[0] + q[1] + q[2])


@pytest.mark.capability("02-66")
def test_reach_of_planar_chains():
    case = CASES["C2-15-planar-reach"]
    for lengths, expected in zip(case["input"], case["expected"], strict=True):
        assert mo.spaces.annulus(lengths) == pytest.approx(expected)


@pytest.mark.capability("02-57")
def test_torus():
    case = CASES["C2-17-torus"]
    a, b = case["input"]["a"], case["input"]["b"]
    near(mo.torus.difference(a, b), case["expected"]["diff"], case)
    near(mo.torus.distance(a, b), case["expected"]["distance"], case)
    near(np.linalg.norm(np.subtract(a, b)), case["expected"]["naive_wrong"], case)
    near(mo.torus.embed_in_space(np.radians([50, 130]), 2.0, 0.7), case["expected"]["embedded"], case)


@pytest.mark.capability("02-60")
def test_slider_crank():
    case = CASES["C2-18-slider-crank"]
    crank, theta = mo.SliderCrank(case["input"]["r"], case["input"]["l"]), np.radians(case["input"]["theta_deg"])
    expected = case["expected"]
    near(crank.positions(theta).x, [expected["x_plus"], expected["x_minus"]], case)
    near(crank.positions(theta).rod_angles[0], expected["rod_angle_plus"], case)
    near(crank.rates(theta)[0], expected["dx_dtheta_plus"], case)


@pytest.mark.capability("02-60")
def test_pieces_of_four_bars():
    case = CASES["C2-19-fourbar-components"]
    for lengths, expected in zip(case["input"], case["expected"], strict=True):
        assert mo.FourBar(*lengths).space.components == expected


@pytest.mark.capability("02-42", "02-43", "02-44", "02-45", "02-79")
def test_joints_between_two_bodies():
    case = CASES["M2-01-two-body-joint-maps"]
    x = case["input"]
    phi, slot = np.radians(x["phi_AB_deg"]), np.radians(x["slide_angle_deg"])
    for kind in ("R", "P", "RP", "PR"):
        theta = np.radians(x["P_fixed_phi_CD_minus_phi_AB_deg" if kind == "P" else "theta_deg"])
        found = mo.bodies.second_body(kind, x["A"], phi, x["d_AB"], x["d_CD"], theta=theta, d=x["d"], slot=slot)
        for name in ("B", "C", "D"):
            near(getattr(found, name), case["expected"][kind][name], case)
        near(mo.bodies.planar_angle(x["A"], found.B), phi, case)


@pytest.mark.capability("02-81")
def test_six_parameters_of_a_body():
    case = CASES["M2-03-spatial-body-inverse"]
    found, expected = mo.bodies.body_of_points(*(case["input"][name] for name in "ABC")), case["expected"]
    for name in ("lon", "lat", "psi", "a", "h", "R_body"):
        near(getattr(found, name), expected[name], case)
    distances = [
        np.linalg.norm(found.B - found.A),
        np.linalg.norm(found.C - found.A),
        np.linalg.norm(found.C - found.B),
    ]
    near(distances, [expected["d_AB"], expected["d_AC"], expected["d_BC"]], case)
    again = mo.bodies.points_of_body(found.A, found.lon, found.lat, found.psi, *distances)
    near(again.C, case["input"]["C"], case)


@pytest.mark.capability("02-49")
def test_rates_of_six_bars():
    case = CASES["M2-05-sixbar-rates"]
    for k, name in enumerate(("watt", "stephenson")):
        edges = case["input"][name]
        joints = [mo.joint(f"{a}{b}", "R", [str(a), str(b)], place) for (a, b), place in edges]
        linkage = mo.Linkage.of(joints, ground="0", planar=True, output="5")
        found = mo.instantaneous_mobility(linkage)
        assert found.mobility == case["expected"]["mobility"][k]
        near(mo.body_rates(linkage, "01", [str(b) for b in range(1, 6)]), case["expected"][name], case)
        assert mo.instantaneous_mobility(library.linkage(name)).mobility == 1


@pytest.mark.capability("02-53", "02-60")
def test_input_ranges_of_four_bars():
    case = CASES["M2-07-fourbar-input-range"]
    for k, lengths in enumerate(case["input"]):
        four, expected = mo.FourBar(*lengths), case["expected"]["range"][k]
        assert bool(four.space) is expected["assemblable"]
        assert four.space.components == case["expected"]["closed_curves"][k] == len(four.curves())
        if expected["abs_theta1_deg"] is None:
            assert four.input_range is None
        else:
            near(np.degrees(four.input_range), expected["abs_theta1_deg"], case)


@pytest.mark.capability("02-84", "02-62")
def test_cart_of_two_wheels():
    case = CASES["M2-09-two-wheel-cart"]
    x, expected = case["input"], case["expected"]
    cart = mo.bodies.Cart(x["r"], x["b"])
    q, found = [0.0, 0.0, x["phi"], 0.0, 0.0], cart.constraints.integrability
    assert cart.constraints.rank(q) == expected["rank"]
    assert (bool(found), list(found.growth)) == (expected["integrable"], expected["growth"])
    assert found.first_integrals == expected["number_of_first_integrals"]
    assert expected["first_integral"] == "phi - (r/b)(thetaR - thetaL)"
    assert cart.constraints.keeps(lambda v: v[2] - x["r"] / x["b"] * (v[3] - v[4]))
    near(cart.constraints.project_velocity(q, x["qdot"]), expected["projected_qdot"], case)
    near(cart.drive(np.zeros(5), x["wheel_rates"], x["T"]), expected["final_q"], case)
    near(cart.first_integral([0.0, 0.0, 0.5, 0.7, 0.3]), 0.5 - x["r"] / x["b"] * 0.4, case)


@pytest.mark.capability("02-82", "02-66")
def test_what_lies_behind_a_task_point():
    case = CASES["M2-11-self-motion-fibre"]
    for k, d in enumerate(case["input"]["d"]):
        found = mo.self_motion_manifold([2, 2, 2], d)
        assert found.components == case["expected"]["components"][k]
        assert found.dimension == case["expected"]["dimension"][k]
        assert found.smooth == case["expected"]["smooth"][k]
    assert case["tol"] == 0


@pytest.mark.capability("02-68")
def test_band_of_the_spatial_two_r():
    case = CASES["M2-13-spatial-2R-band"]
    for given, expected in zip(case["input"], case["expected"], strict=True):
        found = mo.spaces.spatial_2r(np.radians(given["alpha_deg"]), 1.0, given["c"])
        near([found.radius, found.z_min, found.z_max], [expected[k] for k in ("radius", "z_min", "z_max")], case)
        assert found.whole_sphere is expected["whole_sphere"]


def test_every_key_of_every_case_was_read():
    others = {name: test for name, test in globals().items() if name != "test_every_key_of_every_case_was_read"}
    assert unread_after(others, CASES) == []
    assert mf.mobility is mo
