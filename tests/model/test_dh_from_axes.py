"""From screws to tables: the table found is the same arm, special positions of the axes included."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from mafsil.errors import ModelError
from mafsil.model import library
from mafsil.model.denavit_hartenberg import Convention, DHRow, mechanism_from_dh
from mafsil.model.dh_from_axes import Relation, classic_from_modified, dh_from_mechanism, dh_from_screws, screws
from mafsil.model.library import textbook


def bracket(S):
    (x, y, z), v = S[:3], S[3:]
    return np.array([[0, -z, y, v[0]], [z, 0, -x, v[1]], [-y, x, 0, v[2]], [0, 0, 0, 0]])


def tip_pose(mechanism, q):
    T = mechanism.T_sb
    for joint, value in zip(mechanism.joints, q, strict=True):
        T = T @ joint.T_pj @ expm(bracket(joint.screw) * value)
    return T @ mechanism.T_lt


@pytest.mark.capability("05-12", "05-13", "05-19", "05-46")
@pytest.mark.parametrize("convention", ["modified", "classic"])
@pytest.mark.parametrize("name", library.robots())
def test_every_robot_of_the_library_has_a_table(name, convention):
    robot = library.load(name)
    table = dh_from_mechanism(robot, convention)
    assert table.convention is Convention(convention)
    assert table.residual < 1e-12
    again = table.mechanism()
    q = np.random.default_rng(0).uniform(-1, 1, robot.n)
    np.testing.assert_allclose(tip_pose(again, q), tip_pose(robot, q), atol=1e-12)


numbers = st.one_of(st.floats(-2, 2), st.just(0.0))
angles = st.sampled_from([0.0, pi / 2, -pi / 2, pi, 0.3, -1.2])
rows = st.builds(DHRow, a=numbers, alpha=angles, d=numbers, theta=angles, kind=st.sampled_from("RP"))


@settings(deadline=None, max_examples=40)
@given(st.lists(rows, min_size=1, max_size=7), st.sampled_from(["modified", "classic"]), st.integers(0, 2**32 - 1))
def test_the_table_of_a_random_arm_with_special_axes_is_the_arm(table, convention, seed):
    rng = np.random.default_rng(seed)
    base, tool = (expm(bracket(rng.normal(size=6))) for _ in range(2))
    arm = mechanism_from_dh(table, convention, base=base, tool=tool)
    S_s, _, home = screws(arm)
    found = dh_from_screws(S_s, home, convention)
    assert found.residual < 1e-9
    q = rng.uniform(-pi, pi, len(table))
    np.testing.assert_allclose(tip_pose(found.mechanism(), q), tip_pose(arm, q), atol=1e-8)


@pytest.mark.capability("05-19")
def test_6r_of_figure_5_9():
    """Its table as the book's rules give it; the tip's z is not along axis 6, so a tool pose is needed."""
    L = 0.4
    table = dh_from_mechanism(textbook.arm6r(L))
    np.testing.assert_allclose([row.a for row in table.rows], [0, 0, 0, L, L, 0], atol=1e-14)
    np.testing.assert_allclose(np.abs([row.alpha for row in table.rows]), np.deg2rad([0, 90, 90, 0, 0, 90]), atol=1e-14)
    np.testing.assert_allclose(np.abs([row.d for row in table.rows]), [0, 0, 0, 0, 0, L], atol=1e-14)
    np.testing.assert_allclose(table.tool[:3, 3], 0, atol=1e-14)
    assert [relation.value for relation in table.relations] == [
        "intersecting",
        "intersecting",
        "parallel",
        "parallel",
        "intersecting",
    ]


@pytest.mark.capability("05-14", "05-18")
def test_the_ground_frame_is_frame_1_at_zero():
    for name in library.robots():
        arm = library.load(name)
        table = dh_from_mechanism(arm)
        first = table.rows[0]
        assert (first.a, first.alpha, first.d, first.theta) == (0, 0, 0, 0)
        axis = screws(arm).S_s[0]
        direction = axis[:3] if axis[:3].any() else axis[3:]
        np.testing.assert_allclose(table.base[:3, 2], direction, atol=1e-12)


def test_the_panda_gets_its_published_lengths_back():
    table = dh_from_mechanism(library.load("panda"))
    np.testing.assert_allclose(np.abs([row.a for row in table.rows]), [0, 0, 0, 0.0825, 0.0825, 0, 0.088], atol=1e-12)
    np.testing.assert_allclose(np.abs([row.d for row in table.rows]), [0, 0, 0.316, 0, 0.384, 0, 0.107], atol=1e-12)
    np.testing.assert_allclose(table.base[:3, 3], [0, 0, 0.333], atol=1e-12)
    np.testing.assert_allclose(table.tool, np.eye(4), atol=1e-12)


@pytest.mark.capability("05-15")
def test_meeting_axes_have_two_tables():
    arm = library.load("puma560")
    one, other = dh_from_mechanism(arm), dh_from_mechanism(arm, flipped=[1])
    assert one.relations[0] is Relation.INTERSECTING
    assert one.rows[1].alpha == pytest.approx(-other.rows[1].alpha)
    assert other.residual < 1e-12


@pytest.mark.capability("05-16")
def test_relations_of_special_pairs():
    z = [0, 0, 1, 0, 0, 0]
    assert dh_from_screws([z, z], np.eye(4)).relations == (Relation.COLLINEAR,)
    assert dh_from_screws([z, [0, 0, -1, 0, 0, 0]], np.eye(4)).relations == (Relation.COLLINEAR,)
    assert dh_from_screws([z, [0, 0, 1, 0, -1, 0]], np.eye(4)).relations == (Relation.PARALLEL,)
    assert dh_from_screws([z, [1, 0, 0, 0, 0, 0]], np.eye(4)).relations == (Relation.INTERSECTING,)
    assert dh_from_screws([z, [1, 0, 0, 0, 0, -1]], np.eye(4)).relations == (Relation.SKEW,)


@pytest.mark.parametrize("tilt", [1e-3, 1e-5, 1e-6, 2e-7, 5e-8, 1e-12])
def test_nearly_parallel_axes_say_what_the_table_misses(tilt):
    """Feet of normals run away; the residual tells what is lost, and below the tolerance it is the tilt itself."""
    S = [[0, 0, 1, 0, 0, 0], [0, np.sin(tilt), np.cos(tilt), 0, -np.cos(tilt), np.sin(tilt)]]
    table = dh_from_screws(S, np.eye(4))
    assert table.residual < 2e-7
    assert np.isfinite([row.d for row in table.rows]).all()


@given(rows, rows)
def test_classic_and_modified_tables_shift_by_half_a_row(first, second):
    arm = mechanism_from_dh([first, second], "modified")
    table = dh_from_mechanism(arm)
    q = [0.3, -0.4]
    np.testing.assert_allclose(
        tip_pose(classic_from_modified(table).mechanism(), q), tip_pose(table.mechanism(), q), atol=1e-12
    )


@pytest.mark.parametrize(
    ("call", "key"),
    [
        (lambda: dh_from_screws([[0, 0, 1, 0, 0, 0.1]], np.eye(4)), "dh.helical"),
        (lambda: dh_from_screws([[0, 0, 1, 0, 0, 0], [0, 0, 1, 0, -1, 0]], np.eye(4), flipped=[1]), "dh.flip"),
        (lambda: dh_from_screws([[0, 0, 1, 0, 0, 0]], np.eye(4), "hayati"), "dh.convention"),
        (lambda: dh_from_screws([[0, 0, 1, 0, 0, 0]], 2 * np.eye(4)), "geometry.last_row"),
    ],
)
def test_what_has_no_table_is_refused_in_both_languages(call, key):
    with pytest.raises(ModelError) as caught:
        call()
    assert caught.value.key == key
    assert caught.value.message("en") != caught.value.message("ar")
