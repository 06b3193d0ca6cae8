"""Wrong input is our own error with a remedy, NaN stays in its row, and nothing else is raised."""

import contextlib
import warnings

import numpy as np
import pytest

import mafsil as mf
from mafsil import mobility as mo
from mafsil.mobility import library

FOUR = mo.FourBar(2, 4, 3.5, 4.5)
REFUSED = {
    "text for an angle": lambda: FOUR.positions("a"),
    "negative length": lambda: mo.FourBar(-1, 2, 3, 4),
    "length NaN": lambda: mo.FourBar(np.nan, 2, 3, 4),
    "wrong shape": lambda: mo.bodies.Coin(0.1).drive([0, 0, 0], 1, 1, 1),
    "NaN coordinates": lambda: mo.batch_mobility(library.four_bar(), [np.nan] * 4),
    "no linkage": lambda: mf.mobility(5),
    "nothing": lambda: mf.mobility(None),
    "no file": lambda: mf.mobility("nowhere.toml"),
    "wrong number of coordinates": lambda: mf.mobility("four_bar", [0, 0]),
    "NaN place": lambda: mo.joint("A", "R", ["a", "b"], [np.nan, 0]),
    "bodies as a word": lambda: mo.joint("A", "R", "ab", [0, 0]),
    "kind as a number": lambda: mo.joint("A", 3, ["a", "b"], [0, 0]),
    "limits NaN": lambda: mo.joint("A", "R", ["a", "b"], limits=(np.nan, 1)),
    "limits as a number": lambda: mo.joint("A", "R", ["a", "b"], limits=3),
    "no joints": lambda: mo.Linkage.of([]),
    "all locked": lambda: mo.linkages.lock_joints(library.four_bar(), list("ABCD")),
    "no links": lambda: mo.gruebler_count(0, []),
    "half a freedom": lambda: mo.gruebler_count(4, [1.5]),
    "points that coincide": lambda: mo.bodies.count_points([[0, 0], [0, 0]]),
    "no points": lambda: mo.bodies.count_points(np.zeros((0, 2))),
    "points on a line": lambda: mo.bodies.body_of_points([0, 0, 0], [1, 0, 0], [2, 0, 0]),
    "infinite length": lambda: mo.spaces.polygon_space([1, np.inf, 1]),
    "no length at all": lambda: mo.spaces.polygon_space([0, 0, 0]),
    "no lengths": lambda: mo.spaces.annulus([]),
    "angle NaN": lambda: mo.spaces.spatial_2r(np.nan, 1),
    "row too long": lambda: mo.spaces.Pfaffian(("x", "y"), lambda q: [[1, 2, 3]]).rank([0, 0]),
    "curve of a structure": lambda: mo.trace_motion(library.truss()),
    "curve of mobility 2": lambda: mo.trace_motion(library.five_bar()),
    "surface of mobility 1": lambda: mo.trace_surface(library.four_bar()),
    "surface with balls": lambda: mo.trace_surface(library.rssr()),
    "surface from where nothing closes": lambda: mo.trace_surface(mo.library.truss(), [0.1, 0.1, 0.1]),
    "surface of step zero": lambda: mo.trace_surface(library.five_bar(), step=0),
    "surface of no points": lambda: mo.configuration_surfaces(library.five_bar(), points=0),
    "step zero": lambda: mo.trace_motion(library.four_bar(), step=0),
    "unknown joint": lambda: mo.assembly_modes(library.four_bar(), {"Z": 1}),
    "joint of three freedoms": lambda: mo.assembly_modes(library.six_sps(), {"A0": 1}),
    "too many joints": lambda: mo.mobility_with_locked_joints(library.four_bar(), 9),
    "one input of two": lambda: mo.bodies.Car(1.0).drive([0, 0, 0, 0], lambda t: (1.0,), 1.0),
    "unknown rule": lambda: mo.gruebler(library.four_bar(), "curved"),
    "planar rule for six freedoms": lambda: mo.gruebler(mo.Linkage.of([mo.joint("F", "F", ["ground", "b"])]), "planar"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_wrong_input_is_refused_in_both_languages(case):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(mf.MafsilError) as caught:
            REFUSED[case]()
    assert caught.value.message("en")
    assert caught.value.message("ar") != caught.value.message("en")


def test_nan_and_infinity_stay_in_their_rows():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert FOUR.positions([np.nan, np.inf, 1.0]).reachable.tolist() == [False, False, True]
        assert np.isnan(mo.SliderCrank(1, 3).positions([np.inf, 0.1]).x).tolist() == [[True, True], [False, False]]
        assert np.isnan(mo.torus.difference([np.inf, 0], [0, 1])).tolist() == [True, False]
        assert np.isnan(mo.bodies.Coin(0.1).drive(np.zeros((2, 4)), [np.inf, 1.0], 1.0, 1.0)[:, 0]).tolist() == [
            True,
            False,
        ]
        assert mo.SliderCrank(3, 1).positions([1.5, 0.0]).x.shape == (2, 2)
        assert len(FOUR.positions(np.zeros(0)).theta) == 0


@pytest.mark.parametrize("ask", [FOUR.positions, mo.SliderCrank(1, 3).positions, mo.SliderCrank(1, 3).rates])
def test_a_single_angle_that_is_no_number_is_refused(ask):
    with pytest.raises(mf.InputError, match="finite"):
        ask(np.inf)


def test_trivial_constraints():
    assert mo.spaces.Pfaffian(("x", "y"), lambda q: [[1, 0], [0, 1]]).integrability.first_integrals == 2
    assert mo.spaces.Pfaffian(("x", "y"), lambda q: [[0, 0]]).integrability.first_integrals == 0


NO_LINKAGE = (None, 3, "four_bar", [0, 1], np.zeros((2, 2)), {}, object(), mo.Linkage)
ON_A_LINKAGE = (
    mo.actuation, mo.close_drawing, mo.assembly_modes, mo.linkages.body_poses, mo.configuration_curves,
    mo.configuration_space,
    mo.linkages.draw_at, mo.can_assemble, mo.finite_mobility, mo.generic_mobility, mo.gruebler,
    mo.instantaneous_mobility, mo.linkages.loop_matrix,
    mo.configuration_surfaces, mo.mechanism_of, mo.redundant_constraints, mo.linkages.split_joints, mo.structure,
    mo.trace_motion, mo.trace_surface,
)  # fmt: skip


@pytest.mark.parametrize("function", ON_A_LINKAGE, ids=lambda function: function.__name__)
def test_what_is_no_linkage_is_told_how_to_make_one(function):
    for given in NO_LINKAGE:
        with pytest.raises(mf.InputError, match="as_linkage"):
            function(given)
    with pytest.raises(mf.InputError, match="as_linkage"):
        function(linkage=None)


FIVE_BAR_PATCH = mo.trace_surface(library.five_bar(), points=20)
NONSENSE = (None, 3.5, np.inf, [np.nan], np.zeros((3, 5)), object(), [[1, 2], [3]], "x", {}, -1, 10**9)
TAKES = {
    "rule": lambda x: mf.mobility("four_bar", rule=x),
    "theta": lambda x: mo.instantaneous_mobility(library.four_bar(), x),
    "theta of finite": lambda x: mo.finite_mobility(library.four_bar(), x),
    "theta of surface": lambda x: mo.trace_surface(library.five_bar(), x, points=50),
    "held by surface": FIVE_BAR_PATCH.holds,
    "theta of trace_motion": lambda x: mo.trace_motion(library.four_bar(), x),
    "locked": lambda x: mo.instantaneous_mobility(library.four_bar(), locked=x),
    "driven": lambda x: mo.actuation(library.four_bar(), joints=x),
    "given": lambda x: mo.assembly_modes(library.four_bar(), x),
    "bodies": lambda x: mo.joint("A", "R", x, [0, 0]),
    "joints": mo.Linkage.of,
    "name": library.linkage,
    "legs": library.stewart_gough,
    "axes": library.three_upu,
    "space": mo.named_space,
    "distance": lambda x: mo.self_motion_manifold([1, 1], x),
    "angles": lambda x: mo.torus.distance(x, [0, 0]),
    "freedoms": lambda x: mo.spaces.task_redundancy(x, "pose"),
    "row": lambda x: mo.spaces.Pfaffian(("x", "y"), lambda q: [[1, x]]).integrability,
    "file": mo.read_linkage,
}


@pytest.mark.parametrize("name", TAKES)
def test_nonsense_raises_nothing_foreign(name):
    for given in NONSENSE:
        with contextlib.suppress(mf.MafsilError):
            TAKES[name](given)
