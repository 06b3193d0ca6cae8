"""Named mechanisms: the right numbers, and the sentences that say why."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil import mobility as mo
from mafsil.mobility import library
from mafsil.mobility.linkages.loop_closure import largest_gap
from mafsil.mobility.report import spoken_name

# name: rule, count, rank here, of the output body, finite, status
EXPECTED = {
    "bennett": ("spatial", -2, 1, 1, 1, "MOVES_DEPENDENT"),
    "chain": ("planar", 7, 7, 3, 7, "MOVES"),
    "delta": ("spatial", 9, 9, 3, 9, "MOVES"),
    "door": ("spatial", -4, 1, 1, 1, "MOVES_DEPENDENT"),
    "eclipse": ("spatial", 6, 6, 6, 6, "MOVES"),
    "elliptic_trammel": ("planar", 1, 1, 1, 1, "MOVES"),
    "five_bar": ("planar", 2, 2, 2, 2, "MOVES"),
    "four_bar": ("planar", 1, 1, 1, 1, "MOVES"),
    "hand": ("spatial", 6, 6, 6, 6, "MOVES"),
    "kaleidocycle": ("spatial", 0, 1, 1, 1, "MOVES_DEPENDENT"),
    "overlapping_joints": ("planar", 3, 3, 3, 3, "MOVES"),
    "parallelogram": ("planar", 1, 1, 1, 1, "MOVES"),
    "peaucellier": ("planar", 1, 1, 1, 1, "MOVES"),
    "planar_platform": ("planar", 3, 3, 3, 3, "MOVES"),
    "quick_return": ("planar", 1, 1, 1, 1, "MOVES"),
    "radial_three_upu": ("spatial", 3, 5, 5, 3, "BRANCH_POINT"),
    "rccc": ("spatial", 1, 1, 1, 1, "MOVES"),
    "rssr": ("spatial", 2, 2, 1, 2, "MOVES"),
    "sarrus": ("spatial", 0, 1, 1, 1, "MOVES_DEPENDENT"),
    "scotch_yoke": ("planar", 1, 1, 1, 1, "MOVES"),
    "screw_press": ("spatial", -3, 1, 1, 1, "MOVES_DEPENDENT"),
    "six_sps": ("spatial", 12, 12, 6, 12, "MOVES"),
    "six_ups": ("spatial", 6, 6, 6, 6, "MOVES"),
    "slider_crank": ("planar", 1, 1, 1, 1, "MOVES"),
    "slotted_slider_crank": ("planar", 1, 1, 1, 1, "MOVES"),
    "spherical_four_bar": ("spherical", 1, 1, 1, 1, "MOVES"),
    "stephenson": ("planar", 1, 1, 1, 1, "MOVES"),
    "stewart_gough": ("spatial", 6, 6, 6, 6, "MOVES"),
    "stretched_four_bar": ("planar", 1, 2, 2, 0, "ONLY_INSTANTANEOUS"),
    "three_cranks": ("planar", 0, 1, 1, 1, "MOVES_DEPENDENT"),
    "three_prs": ("spatial", 3, 3, 3, 3, "MOVES"),
    "three_rpr": ("planar", 3, 3, 3, 3, "MOVES"),
    "three_rps": ("spatial", 3, 3, 3, 3, "MOVES"),
    "three_rrr": ("planar", 3, 3, 3, 3, "MOVES"),
    "three_upu": ("spatial", 3, 3, 3, 3, "MOVES"),
    "tripteron": ("spatial", 0, 3, 3, 3, "MOVES_DEPENDENT"),
    "truss": ("planar", 0, 0, 0, 0, "RIGID"),
    "universal_shaft": ("spherical", 1, 1, 1, 1, "MOVES"),
    "watt": ("planar", 1, 1, 1, 1, "MOVES"),
}
SENTENCES = {
    "MOVES": "as counted by Gruebler",
    "MOVES_DEPENDENT": "because constraints are dependent",
    "BRANCH_POINT": "a branch point of its configuration space",
    "ONLY_INSTANTANEOUS": "blocked at second order",
    "RIGID": "is a structure",
}


@pytest.mark.capability("02-49", "02-51")
@pytest.mark.parametrize("name", library.names())
def test_mobility_of_named_mechanisms(name):
    rule, counted, here, output, finite, status = EXPECTED[name]
    linkage = library.linkage(name)
    assert largest_gap(linkage) < 1e-12
    found = mf.mobility(name)
    assert (found.count.rule, found.count.mobility, found.instantaneous.mobility) == (rule, counted, here)
    assert (found.instantaneous.output_mobility, found.mobility) == (output, finite)
    assert found.status.name == status
    assert SENTENCES[status] in found.explain("en")
    assert found.explain("ar") != found.explain("en")


def test_reasons_of_named_mechanisms():
    def said(name):
        return mf.mobility(name).explain("en")

    assert "translations of space" not in said("four_bar")
    assert "motions of the plane across (0, 0, 1), so 3 of its 6 constraints" in said("four_bar")
    assert "3 further conditions hold by the lengths" in said("bennett")
    assert "1 further condition holds by" in said("sarrus")
    assert "rotations about the point" in said("universal_shaft")
    assert "motions along and about one axis (0, 0, 1)" in said("screw_press")
    assert said("delta").count("idle freedom (1)") == 6
    assert "singular choice" not in said("delta")


def test_output_of_the_delta_translates():
    found = mo.instantaneous_mobility(library.delta())
    assert (found.output_mobility, found.output_rotations) == (3, 0)
    assert mo.instantaneous_mobility(library.sarrus()).output_rotations == 0


def test_peaucellier_draws_a_straight_line():
    points = []
    for theta in np.linspace(0.2, 0.9, 9):
        linkage = library.peaucellier(theta=theta)
        points.append(linkage.joints[-1].point[0])
    assert np.ptp(points) < 1e-12


def test_inversor_followed_by_newton_stays_on_the_line():
    linkage = library.peaucellier()
    theta = np.zeros((20, linkage.coordinates))
    theta[:, linkage.columns_of(["A"])[0]] = np.linspace(0.0, 0.3, 20)
    for k in range(1, 20):
        start = theta[k - 1].copy()
        start[linkage.columns_of(["A"])[0]] = theta[k, linkage.columns_of(["A"])[0]]
        found = mo.linkages.close_loops_near(linkage, start, fixed=["A"])
        assert found
        theta[k] = found.theta
    T = mo.linkages.body_poses(linkage, theta)[:, linkage.bodies.index("side 3")]
    x = T[:, 0, :3] @ linkage.joints[-1].point + T[:, 0, 3]
    assert np.ptp(x) < 1e-9


@settings(max_examples=25, deadline=None)
@given(
    st.floats(0.5, 3), st.floats(0.2, 1.2), st.floats(0.5, 3), st.floats(0.3, 2.6)
)  # fmt: skip
def test_every_bennett_moves(a, alpha, b, theta):
    if b * np.sin(alpha) / a > 0.95 or abs(a - b) < 0.05:
        return
    found = mf.mobility(library.bennett(a, alpha, b, theta))
    assert (found.count.mobility, found.mobility) == (-2, 1)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**31))
def test_random_single_loops_of_seven_hinges_move_and_of_six_do_not(seed):
    rng = np.random.default_rng(seed)

    def loop(n):
        names = ["ground", *(f"b{k}" for k in range(n - 1)), "ground"]
        return mo.Linkage.of(
            [mo.joint(f"J{k}", "R", names[k : k + 2], rng.normal(size=3), rng.normal(size=3)) for k in range(n)]
        )

    assert mf.mobility(loop(7)).mobility == 1
    assert not mf.mobility(loop(6))


def test_unknown_names_and_parameters_are_said():
    with pytest.raises(mf.InputError, match="did you mean: bennett"):
        library.linkage("benet")
    with pytest.raises(mf.InputError, match="must not exceed 1"):
        library.bennett(1.0, 1.2, 2.0)
    with pytest.raises(mf.InputError):
        library.stewart_gough("RPR")
    with pytest.raises(mf.InputError, match="does not close"):
        library.four_bar(1, 1, 1, 2.5, 2.0)


def test_no_mechanism_has_the_name_of_a_robot():
    from mafsil.model.library import robots

    assert not set(library.names()) & set(robots())


def test_every_mechanism_has_a_name_in_both_languages():
    for name in library.names():
        linkage = library.linkage(name)
        assert spoken_name(linkage.name, "en") == linkage.name
        assert any("\u0600" < letter < "\u06ff" for letter in spoken_name(linkage.name, "ar")), linkage.name
    assert spoken_name("chain of 12", "ar").endswith("12")
    assert spoken_name("my gripper 3 of 4", "ar") == "my gripper 3 of 4"
    assert spoken_name("") == "-"


@pytest.mark.parametrize("name", ["sarrus", "kaleidocycle", "spherical_four_bar", "watt", "stephenson", "peaucellier"])
def test_what_moves_has_a_motor(name):
    drawn = library.linkage(name)
    assert sum(each.actuated for each in drawn.joints) == 1
    assert mo.linkages.turn_crank(drawn, rows=8).angle.size
