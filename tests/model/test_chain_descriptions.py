"""Tables, screws, local exponentials, locked chains and files describe the same arm."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from mafsil.errors import InputError, ModelError
from mafsil.model import Joint, Link, Mechanism, Mimic, library, mechanism_from_screws, screws, urdf
from mafsil.model.denavit_hartenberg import DHRow, HayatiRow, hayati_parameters, mechanism_from_dh
from mafsil.model.dh_from_axes import dh_from_mechanism, dh_from_screws
from mafsil.model.exponentials import chain_to_tip, representations, screw_matrices, screw_table
from mafsil.model.joint import JointKind
from mafsil.model.library import textbook
from mafsil.model.local_exponentials import (
    local_screws,
    local_screws_of_table,
    mechanism_from_local_screws,
    shift_zero,
)
from mafsil.model.placement import adjoint, rotation_x, rotation_z, screw_motion, translation


def bracket(S):
    (x, y, z), v = S[:3], S[3:]
    return np.array([[0, -z, y, v[0]], [z, 0, -x, v[1]], [-y, x, 0, v[2]], [0, 0, 0, 0]])


def same(one, other, atol=1e-12):
    a, b = screws(one), screws(other)
    np.testing.assert_allclose(a.S_s, b.S_s, atol=atol)
    np.testing.assert_allclose(a.S_b, b.S_b, atol=atol)
    np.testing.assert_allclose(a.home, b.home, atol=atol)


@pytest.mark.capability("05-40", "05-46")
@pytest.mark.parametrize("convention", ["modified", "classic"])
@pytest.mark.parametrize("name", library.robots())
def test_round_trip_table_screws_table_urdf(name, convention, tmp_path):
    """DH -> screws -> DH -> URDF -> screws over the library."""
    robot = library.load(name)
    first = dh_from_mechanism(robot, convention)
    S, _, home = screws(first.mechanism())
    second = dh_from_screws(S, home, convention)
    text = urdf.write(second.mechanism(name=name))
    path = tmp_path / "arm.urdf"
    path.write_text(text, encoding="utf-8")
    again = urdf.read(path)
    same(second.mechanism(), robot)
    got, wanted = screws(again), screws(robot)
    np.testing.assert_allclose(got.S_s, wanted.S_s, atol=1e-12)
    np.testing.assert_allclose(got.home, wanted.home, atol=1e-12)


@pytest.mark.capability("05-41", "05-11")
@pytest.mark.parametrize("name", library.robots())
def test_local_exponentials_are_the_arm(name):
    robot = library.load(name)
    local = local_screws(robot)
    same(mechanism_from_local_screws(local.M, local.A, local.tool), robot)
    for convention in ("modified", "classic"):
        table = dh_from_mechanism(robot, convention)
        M, A, tool = local_screws_of_table(table)
        same(mechanism_from_local_screws(M, A, tool), robot)
        assert set(np.abs(A).ravel()) <= {0.0, 1.0}
    q = np.random.default_rng(1).uniform(-1, 1, robot.n)
    product, by_space = np.eye(4), np.eye(4)
    for constant, axis, value in zip(local.M, local.A, q, strict=True):
        product = product @ constant @ expm(bracket(axis) * value)
    for axis, value in zip(screws(robot).S_s, q, strict=True):
        by_space = by_space @ expm(bracket(axis) * value)
    np.testing.assert_allclose(product @ local.tool, by_space @ screws(robot).home, atol=1e-12)


@pytest.mark.capability("05-42", "05-43")
@given(st.integers(0, 2**32 - 1))
def test_constants_move_through_exponentials(seed):
    rng = np.random.default_rng(seed)
    M, P = expm(bracket(rng.normal(size=6))), rng.normal(size=6)
    inverse = np.linalg.inv(M)
    np.testing.assert_allclose(M @ expm(bracket(P)) @ inverse, expm(M @ bracket(P) @ inverse), atol=1e-10)
    np.testing.assert_allclose(M @ bracket(P) @ inverse, bracket(adjoint(M) @ P), atol=1e-11)


@pytest.mark.capability("05-31", "05-32")
@given(st.integers(0, 2**32 - 1))
def test_any_displacement_of_the_home_pose_is_one_screw(seed):
    """Chasles-Mozzi: T = exp([S] theta) M; S, theta and the pitch are found again, M arbitrary."""
    from mafsil.geometry import pose

    rng = np.random.default_rng(seed)
    w, q, h = rng.normal(size=3), rng.normal(size=3), rng.uniform(-1, 1)
    w /= np.linalg.norm(w)
    S, theta = np.concatenate([w, -np.cross(w, q) + h * w]), rng.uniform(0.1, 3.0)
    M = expm(bracket(rng.normal(size=6)))
    T = screw_motion(S, theta) @ M
    found = np.asarray(pose.log(T @ np.linalg.inv(M)))
    np.testing.assert_allclose(found, S * theta, atol=1e-9)
    assert found[:3] @ found[3:] / (found[:3] @ found[:3]) == pytest.approx(h, abs=1e-9)


@pytest.mark.capability("05-34", "05-35")
@settings(deadline=None, max_examples=20)
@given(st.sampled_from(library.robots()), st.integers(0, 2**32 - 1))
def test_another_zero_configuration(name, seed):
    robot = library.load(name)
    rng = np.random.default_rng(seed)
    q0, q = rng.uniform(-1, 1, (2, robot.n))
    moved, old = shift_zero(robot, q0), screws(robot)
    assert moved.S_s.shape == (robot.n, 6)

    def tip(S, home, values):
        T = np.eye(4)
        for axis, value in zip(S, values, strict=True):
            T = T @ expm(bracket(axis) * value)
        return T @ home

    np.testing.assert_allclose(tip(moved.S_s, moved.home, q - q0), tip(old.S_s, old.home, q), atol=1e-10)
    np.testing.assert_allclose(moved.S_b @ adjoint(moved.home).T, moved.S_s, atol=1e-11)


@pytest.mark.capability("05-36")
def test_screws_are_printed_as_table_and_matrices():
    found = screws(textbook.arm6r(0.4))
    text = screw_table(found)
    assert text.splitlines()[0].split() == ["i", "omega_i", "v_i"]
    assert "[S_6] =" in text
    assert "[B_6] =" in screw_table(found, "body")
    assert len(text.splitlines()) == 1 + 6 + 6 * 6
    matrices = screw_matrices(found.S_s)
    for S, matrix in zip(found.S_s, matrices, strict=True):
        np.testing.assert_array_equal(matrix, bracket(S))
    assert not matrices[:, 3].any()


@pytest.mark.capability("05-8", "05-14", "05-21")
def test_representations_are_counted():
    by_name = {each.name: each for each in representations(5, 1)}
    assert by_name["denavit_hartenberg"].numbers == 4 * 6
    assert by_name["free_frames"].numbers == 6 * 6
    assert by_name["exponentials"].numbers == 6 * 6 + 6
    assert not by_name["exponentials"].needs_link_frames
    assert by_name["exponentials"].independent == 4 * 5 + 2 + 6


@pytest.mark.capability("05-1", "05-2", "05-3", "05-4", "05-5", "05-7")
def test_planar_3r_in_three_routes():
    """Closed form, product of frames in SE(2), product of exponentials in SE(2), and the spatial arm: equal."""
    from mafsil.geometry import planar as plane
    from mafsil.robot import Robot

    lengths, theta = np.array([1.0, 0.8, 0.5]), np.array([0.3, -0.7, 1.1])
    sums = np.cumsum(theta)
    closed = np.array([lengths @ np.cos(sums), lengths @ np.sin(sums), sums[-1]])
    frames = np.eye(3)
    for before, angle in zip([0.0, *lengths[:2]], theta, strict=True):
        frames = frames @ plane.pose(angle, [before, 0.0])
    frames = frames @ plane.pose(0.0, [lengths[2], 0.0])
    home = plane.pose(0.0, [lengths.sum(), 0.0])
    exponentials = np.eye(3)
    for x, angle in zip([0.0, 1.0, 1.8], theta, strict=True):
        S = plane.twist_of_pole(1.0, [x, 0.0])
        np.testing.assert_allclose(S, [1.0, 0.0, -x], atol=1e-15)
        exponentials = exponentials @ plane.exp(np.asarray(S) * angle)
    exponentials = exponentials @ home
    np.testing.assert_allclose(frames, exponentials, atol=1e-15)
    np.testing.assert_allclose(frames[:2, 2], closed[:2], atol=1e-15)
    assert np.arctan2(frames[1, 0], frames[0, 0]) == pytest.approx(closed[2])
    spatial = Robot(textbook.planar3r(lengths)).forward_kinematics(theta)
    np.testing.assert_allclose(spatial, plane.to_spatial_pose(frames), atol=1e-15)


@pytest.mark.capability("05-6")
def test_partially_locked_chains_are_built_from_the_last_joint_inward():
    arm = textbook.planar3r((1.0, 0.8, 0.5))
    S, _, home = screws(arm)
    theta = [0.3, -0.7, 1.1]
    for free in (1, 2, 3):
        held = dict.fromkeys(arm.joint_names[: 3 - free], 0.0)
        partly = arm.with_locked_joints(held)
        assert partly.n == free
        assert partly.joint_names == arm.joint_names[3 - free :]
        T = home
        for axis, value in reversed(list(zip(S, theta, strict=True))[3 - free :]):
            T = screw_motion(axis, value) @ T
        got = screws(partly)
        product = np.eye(4)
        for axis, value in zip(got.S_s, theta[3 - free :], strict=True):
            product = product @ expm(bracket(axis) * value)
        np.testing.assert_allclose(product @ got.home, T, atol=1e-13)


@pytest.mark.parametrize("value", [0.4, -1.0])
def test_joints_held_away_from_zero(value):
    arm = library.load("stanford_arm")
    partly = arm.with_locked_joints({arm.joint_names[2]: value})
    moved = np.zeros(6)
    moved[2] = value
    wanted = np.delete(shift_zero(arm, moved).S_s, 2, axis=0)
    np.testing.assert_allclose(screws(partly).S_s, wanted, atol=1e-12)
    assert [joint.moves for joint in chain_to_tip(partly)].count(False) == 1


@given(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(0, 2), st.floats(-3, 3), st.floats(-1, 1))
def test_hayati_parameters_give_nearly_parallel_axes_back(alpha, beta, a, theta, d):
    T = HayatiRow(theta, a, alpha, beta).transform() @ translation(0, 0, d) @ rotation_z(0.3)
    row, rest = hayati_parameters(T)
    np.testing.assert_allclose(row.transform() @ rest, T, atol=1e-12)
    np.testing.assert_allclose(rest[:3, 2], [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(rest[:2, 3], 0, atol=1e-9)


def test_hayati_stays_small_where_denavit_hartenberg_runs_away():
    tilt = 1e-4
    S = [[0, 0, 1, 0, 0, 0], [0, np.sin(tilt), np.cos(tilt), 0, -np.cos(tilt), np.sin(tilt)]]
    T = translation(1, 0, 0) @ rotation_x(-tilt)
    assert abs(dh_from_screws(S, np.eye(4)).rows[1].a) < 1.1
    row, _ = hayati_parameters(T)
    assert row.a == pytest.approx(1.0)
    assert abs(row.alpha) == pytest.approx(tilt)


@pytest.mark.parametrize(
    ("call", "error", "key"),
    [
        (lambda: hayati_parameters(rotation_x(np.pi / 2)), ModelError, "dh.hayati"),
        (lambda: library.load("rrrp").with_locked_joints({"elbow": 0.0}), ModelError, "dh.lock_unknown"),
        (lambda: _mimic().with_locked_joints({"one": float("nan")}), InputError, "input.finite_alone"),
        (lambda: _mimic().with_locked_joints({"one": 0.0, "two": 9.0}), ModelError, "dh.lock_contradiction"),
        (lambda: local_screws(_mimic()), ModelError, "screws.mimic"),
        (lambda: mechanism_from_local_screws([np.eye(4)], np.eye(6)[:2]), ModelError, "serial.length"),
        (lambda: shift_zero(library.load("rrrp"), [0.0]), InputError, "input.shape"),
    ],
)
def test_wrong_descriptions_are_refused_in_both_languages(call, error, key):
    with pytest.raises(error) as caught:
        call()
    assert caught.value.key == key
    assert caught.value.message("en") != caught.value.message("ar")


def _mimic():
    return Mechanism.assemble(
        "pair",
        [Link("base"), Link("a"), Link("b")],
        [
            Joint("one", JointKind.REVOLUTE, "base", "a"),
            Joint("two", JointKind.REVOLUTE, "a", "b", mimic=Mimic("one")),
        ],
    )


@pytest.mark.capability("05-33", "05-44")
def test_fixed_and_tool_frames_are_arbitrary():
    rng = np.random.default_rng(4)
    P, Q = (expm(bracket(rng.normal(size=6))) for _ in range(2))
    S, _, home = screws(mechanism_from_dh([DHRow(), DHRow(a=1.0, alpha=0.7), DHRow(a=0.4, kind="P")], "modified"))
    moved = mechanism_from_screws(S @ adjoint(P).T, P @ home @ Q)
    np.testing.assert_allclose(
        screws(moved).S_b, screws(mechanism_from_screws(S, home)).S_b @ adjoint(np.linalg.inv(Q)).T, atol=1e-12
    )
