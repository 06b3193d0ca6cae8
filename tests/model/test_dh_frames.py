"""Frames of tables: which are forced, which are free, and that free moves change nothing."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from mafsil.errors import ModelError
from mafsil.model import library, screws
from mafsil.model.denavit_hartenberg import DHRow, mechanism_from_dh
from mafsil.model.dh_frames import Freedom, frame_choices, frame_poses, slid, tables_of_screws, turn_frame
from mafsil.model.dh_from_axes import dh_from_mechanism, dh_from_screws
from mafsil.model.library import textbook

Z = [0, 0, 1, 0, 0, 0]


def bracket(S):
    (x, y, z), v = S[:3], S[3:]
    return np.array([[0, -z, y, v[0]], [z, 0, -x, v[1]], [-y, x, 0, v[2]], [0, 0, 0, 0]])


def same_arm(one, other):
    a, b = screws(one.mechanism()), screws(other.mechanism())
    np.testing.assert_allclose(a.S_s, b.S_s, atol=1e-12)
    np.testing.assert_allclose(a.home, b.home, atol=1e-12)


@pytest.mark.capability("05-30")
def test_frames_1_and_2_of_the_3r_arm_are_forced_and_0_and_3_are_free():
    choices = frame_choices(dh_from_mechanism(textbook.spatial3r(1.0, 0.5)))
    assert [choice.freedom for choice in choices] == [
        Freedom.ANY,
        Freedom.DETERMINED,
        Freedom.DETERMINED,
        Freedom.CYLINDRICAL,
    ]
    assert [choice.determined for choice in choices] == [False, True, True, False]
    for choice in choices:
        assert choice.explain("en") != choice.explain("ar")


@pytest.mark.capability("05-15", "05-16", "05-17")
@pytest.mark.parametrize(
    ("second", "freedom", "prismatic"),
    [
        ([1, 0, 0, 0, 0, -1], Freedom.DETERMINED, False),
        ([1, 0, 0, 0, 0, 0], Freedom.DIRECTION_OF_X, False),
        ([0, 0, 1, 0, -1, 0], Freedom.TRANSLATION, False),
        (Z, Freedom.CYLINDRICAL, False),
        ([0, 0, 0, 0, 0, 1], Freedom.CYLINDRICAL, True),
        ([0, 0, 0, 1, 0, 0], Freedom.DIRECTION_OF_X, True),
    ],
)
def test_what_each_pair_of_axes_leaves_free(second, freedom, prismatic):
    choice = frame_choices(dh_from_screws([Z, second], np.eye(4)))[1]
    assert (choice.freedom, choice.prismatic) == (freedom, prismatic)
    assert choice.explain("ar")


@pytest.mark.capability("05-17")
def test_a_sliding_joint_varies_d_along_its_positive_direction():
    """Figure 5.3: a revolute joint followed by a prismatic one."""
    table = dh_from_screws([Z, [0, 0, 0, 0, 0.6, 0.8]], np.eye(4))
    arm = table.mechanism()
    assert [row.kind for row in table.rows] == ["R", "P"]
    T = frame_poses(table, [0.0, 0.3])[-1] @ table.tool
    np.testing.assert_allclose(T[:3, 3], [0, 0.18, 0.24], atol=1e-15)
    np.testing.assert_allclose(screws(arm).S_s[1], [0, 0, 0, 0, 0.6, 0.8], atol=1e-15)


@pytest.mark.capability("05-16")
@settings(deadline=None, max_examples=25)
@given(st.floats(-2, 2), st.sampled_from([0.0, pi]), st.floats(-1, 1), st.floats(0.1, 1))
def test_frames_between_parallel_axes_slide_freely(distance, alpha, d, a):
    arm = mechanism_from_dh([DHRow(), DHRow(a=a, alpha=alpha, d=d), DHRow(alpha=1.0)], "modified")
    table = dh_from_mechanism(arm)
    moved = slid(table, 1, distance)
    same_arm(moved, table)
    assert moved.rows[0].d == pytest.approx(distance)
    same_arm(slid(table, 3, distance), table)
    same_arm(turn_frame(table, 3, distance), table)


@settings(deadline=None, max_examples=10)
@given(st.floats(-3, 3), st.sampled_from([0.0, pi]))
def test_frames_of_collinear_axes_turn_freely(angle, alpha):
    table = dh_from_mechanism(mechanism_from_dh([DHRow(), DHRow(alpha=alpha, d=0.4), DHRow(alpha=1.0)], "modified"))
    same_arm(turn_frame(table, 1, angle), table)


@pytest.mark.capability("05-15")
def test_both_senses_of_every_pair_of_meeting_axes():
    S, _, home = screws(library.load("puma560"))
    tables = list(tables_of_screws(S, home))
    assert len(tables) == 2**4 or len(tables) == 2**3
    assert len({tuple(np.round([row.alpha for row in table.rows], 6)) for table in tables}) > 1
    for table in tables:
        same_arm(table, dh_from_mechanism(library.load("puma560")))


@pytest.mark.parametrize("convention", ["modified", "classic"])
@pytest.mark.parametrize("name", ["puma560", "stanford_arm", "scara_rrrp"])
def test_the_last_frame_and_the_tool_give_the_tip(name, convention):
    table = dh_from_mechanism(library.load(name), convention)
    q = np.random.default_rng(3).uniform(-1, 1, len(table.rows))
    S, _, home = screws(table.mechanism())
    T = np.eye(4)
    for axis, value in zip(S, q, strict=True):
        T = T @ expm(bracket(axis) * value)
    np.testing.assert_allclose(frame_poses(table, q)[-1] @ table.tool, T @ home, atol=1e-12)
    assert frame_poses(table).shape == (len(table.rows) + 1, 4, 4)


@pytest.mark.parametrize(
    ("call", "key"),
    [
        (lambda: frame_choices(dh_from_mechanism(textbook.rrrp(), "classic")), "dh.modified_only"),
        (lambda: slid(dh_from_mechanism(textbook.spatial3r()), 1, 0.1), "dh.not_free"),
        (lambda: turn_frame(dh_from_mechanism(textbook.rrrp()), 2, 0.1), "dh.not_free"),
        (lambda: slid(dh_from_mechanism(textbook.rrrp()), 9, 0.1), "dh.no_frame"),
    ],
)
def test_moves_that_are_not_free_are_refused_in_both_languages(call, key):
    with pytest.raises(ModelError) as caught:
        call()
    assert caught.value.key == key
    assert caught.value.message("en") != caught.value.message("ar")
