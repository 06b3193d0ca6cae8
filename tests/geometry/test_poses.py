"""Laws of rigid motions, frame bookkeeping, and the group Jacobians."""

from __future__ import annotations

import copy
import pickle
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.errors import InputError
from mafsil.geometry import Point, Pose, Rotation, Vector, pose, rotation, screw
from tests.geometry.samples import batches, poses, seeds

EPS = 2.0**-52


@settings(max_examples=60, deadline=None)
@given(seeds, batches)
@pytest.mark.capability("04-78", "04-81", "04-84")
def test_group_axioms(seed: int, shape: tuple[int, ...]):
    A, B, C = poses(seed, shape, 3)
    identity = np.broadcast_to(np.eye(4), A.shape)
    product = pose.compose(A, B)
    assert product.shape == (*shape, 4, 4)
    assert np.abs(product - A @ B).max() <= 4 * EPS
    assert np.all(pose.is_pose(product, 16 * EPS))
    assert np.abs(pose.compose(product, C) - pose.compose(A, pose.compose(B, C))).max() <= 32 * EPS
    assert np.abs(pose.compose(A, pose.inverse(A)) - identity).max() <= 16 * EPS
    assert np.abs(pose.inverse(A) - np.linalg.inv(A)).max() <= 32 * EPS
    assert np.array_equal(pose.compose(A, identity), A)


@settings(max_examples=60, deadline=None)
@given(seeds, batches)
@pytest.mark.capability("04-82", "04-83")
def test_distances_and_angles_are_kept(seed: int, shape: tuple[int, ...]):
    (T,) = poses(seed, shape)
    x, y, z = np.random.default_rng(seed).standard_normal((3, *shape, 3))
    X, Y, Z = (pose.act(T, point) for point in (x, y, z))
    assert np.abs(np.linalg.norm(X - Y, axis=-1) - np.linalg.norm(x - y, axis=-1)).max() <= 64 * EPS
    assert np.abs(np.sum((X - Z) * (Y - Z), -1) - np.sum((x - z) * (y - z), -1)).max() <= 256 * EPS
    homogeneous = np.concatenate([x, np.ones((*shape, 1))], axis=-1)
    assert np.abs((T @ homogeneous[..., None])[..., :3, 0] - X).max() <= 16 * EPS


def test_points_broadcast_against_one_pose():
    (T,) = poses(0, ())
    x = np.random.default_rng(0).standard_normal((5, 7, 3))
    assert pose.act(T, x).shape == (5, 7, 3)
    assert pose.act(np.stack([T] * 7), x).shape == (5, 7, 3)


@pytest.mark.capability("04-84", "04-85", "04-5")
def test_frame_bookkeeping():
    T_ab, T_bc = (Pose(T, frames) for T, frames in zip(poses(1, (), 2), [("a", "b"), ("b", "c")], strict=True))
    T_ac = T_ab @ T_bc
    assert T_ac.frames == ("a", "c")
    assert T_ab.inverse().frames == ("b", "a")
    assert (T_ab @ T_ab.inverse()).frames == ("a", "a")
    assert (T_ab @ T_ab.inverse()).close_to(Pose.identity(), 8 * EPS)
    q_b = Point(T_bc.origin, "b")
    assert (T_ab @ q_b).close_to(Point(T_ac.origin), 8 * EPS)
    assert (T_ab @ q_b).frame == "a"
    v_b = Vector([1.0, 2.0, 3.0], "b")
    assert (T_ab @ v_b).close_to(Vector(rotation.apply(T_ab.array[:3, :3], v_b.array)), EPS)
    for wrong in (T_ab, Point([0, 0, 0], "a"), Vector([0, 0, 1], "a")):
        with pytest.raises(InputError, match="adjacent letters must cancel"):
            T_ab @ wrong
    assert (T_ab @ Pose.identity()).frames is None


@pytest.mark.capability("04-88", "04-89", "04-3")
def test_displacements_are_prescriptive_poses():
    T_01, T_02 = poses(2, (), 2)
    D = pose.displacement(T_01, T_02)
    body_point = np.array([0.3, -0.2, 0.8])
    before, after = pose.act(T_01, body_point), pose.act(T_02, body_point)
    assert np.abs(pose.act(D, before) - after).max() <= 32 * EPS
    assert Pose(T_01).displacement_to(Pose(T_02)).close_to(Pose(D), EPS)
    assert np.abs(Pose(D).displace(before) - after).max() <= 32 * EPS
    # A frame {b} that sits to the initial body as {a} to the displaced one: the displacement is T_ba.
    T_a_initial = T_01
    T_ab = pose.inverse(D)
    assert np.abs(pose.compose(pose.inverse(T_ab), T_a_initial) - T_02).max() <= 32 * EPS


@pytest.mark.capability("04-78", "04-22")
def test_membership():
    (T,) = poses(3, ())
    assert pose.is_pose(T)
    assert pose.check(T) is not None
    bad_rows = T.copy()
    bad_rows[3] = [0, 0, 1e-3, 1]
    with pytest.raises(InputError, match="last row"):
        pose.log(bad_rows)
    scaled = T.copy()
    scaled[:3, :3] *= 1.01
    with pytest.raises(InputError, match=r"have the length 1\.01"):
        pose.inverse(scaled)
    assert pose.is_pose(pose.project(scaled), 8 * EPS)
    assert np.abs(pose.project(scaled) - T).max() <= 8 * EPS
    assert Pose.nearest(scaled).close_to(Pose(T), 8 * EPS)
    mirrored = T @ np.diag([1, 1, -1, 1])
    with pytest.raises(InputError, match="determinant is -1"):
        pose.log(mirrored)
    with pytest.raises(InputError, match="expected shape"):
        pose.log(np.eye(3))
    with pytest.raises(InputError, match="not a finite number"):
        pose.log(np.full((4, 4), np.nan))


def test_nan_rows_of_a_batch_stay_marked_and_touch_nothing():
    T = np.stack(poses(4, (6,))[0])
    T[2] = np.nan
    V = pose.log(T)
    assert np.isnan(V[2]).all()
    keep = [0, 1, 3, 4, 5]
    assert np.array_equal(V[keep], pose.log(T[keep]))
    assert pose.log(np.empty((0, 4, 4))).shape == (0, 6)
    assert pose.exp(np.empty((0, 3, 6))).shape == (0, 3, 4, 4)


@pytest.mark.capability("04-80")
def test_six_coordinate_charts():
    rng = np.random.default_rng(5)
    p, rpy = rng.uniform(-1, 1, (2, 20, 3))
    T = pose.from_rotation_translation(rotation.from_rpy(rpy), p)
    assert np.abs(rotation.to_rpy(pose.rotation_of(T)) - rpy).max() < 1e-14
    assert np.array_equal(pose.translation_of(T), p)
    by_exponential = pose.from_rotation_translation(rotation.exp(rotation.log(pose.rotation_of(T))), p)
    assert np.abs(by_exponential - T).max() <= 8 * EPS
    assert np.abs(pose.exp(pose.log(T)) - T).max() <= 16 * EPS
    S, theta = screw.chasles(T)
    assert np.abs(pose.exp(S * theta[:, None]) - T).max() <= 16 * EPS


@settings(max_examples=100, deadline=None)
@given(seeds, st.floats(0, pi - 1e-6), batches)
@pytest.mark.capability("04-97")
def test_log_undoes_exp(seed: int, theta: float, shape: tuple[int, ...]):
    V = np.random.default_rng(seed).standard_normal((*shape, 6))
    V[..., :3] *= theta / np.linalg.norm(V[..., :3], axis=-1, keepdims=True)
    error = np.abs(pose.log(pose.exp(V)) - V).max()
    assert error <= 16 * EPS * max(1, np.abs(V).max())


@pytest.mark.capability("04-97")
def test_three_cases_of_the_logarithm():
    assert pose.log(np.eye(4)).tolist() == [0] * 6
    assert pose.log(pose.from_translation([0.3, -0.4, 1.2])) == pytest.approx([0, 0, 0, 0.3, -0.4, 1.2], abs=0)
    half = pose.from_rotation_translation(np.diag([1.0, -1, -1]), [0.5, 1.0, 0.0])
    V = pose.log(half)
    assert V[:3] == pytest.approx([pi, 0, 0])
    assert np.abs(pose.exp(V) - half).max() <= 4 * EPS


@settings(max_examples=40, deadline=None)
@given(seeds, batches)
@pytest.mark.capability("04-103", "04-101", "04-102")
def test_adjoint_laws(seed: int, shape: tuple[int, ...]):
    A, B = poses(seed, shape, 2)
    Ad = pose.adjoint
    assert np.abs(Ad(A) @ Ad(B) - Ad(pose.compose(A, B))).max() <= 32 * EPS
    assert np.abs(Ad(A) @ Ad(pose.inverse(A)) - np.eye(6)).max() <= 32 * EPS
    assert np.array_equal(Ad(np.eye(4)), np.eye(6))
    V = np.random.default_rng(seed).standard_normal((*shape, 6))
    conjugated = pose.vee(A @ pose.hat(V) @ pose.inverse(A))
    assert np.abs(np.matmul(Ad(A), V[..., None])[..., 0] - conjugated).max() <= 128 * EPS
    # T exp([V]) T^-1 = exp([Ad V])
    small = 0.3 * V
    left = A @ pose.exp(small) @ pose.inverse(A)
    right = pose.exp(np.matmul(Ad(A), small[..., None])[..., 0])
    assert np.abs(left - right).max() <= 1e-13


def test_jacobians_relate_rates_and_invert():
    rng = np.random.default_rng(6)
    V, dV = rng.standard_normal((2, 40, 6))
    h = 1e-6
    Tdot = (pose.exp(V + h * dV) - pose.exp(V - h * dV)) / (2 * h)
    T = pose.exp(V)
    V_s, V_b = pose.vee(Tdot @ pose.inverse(T)), pose.vee(pose.inverse(T) @ Tdot)
    assert np.abs((pose.left_jacobian(V) @ dV[..., None])[..., 0] - V_s).max() < 1e-8
    assert np.abs((pose.right_jacobian(V) @ dV[..., None])[..., 0] - V_b).max() < 1e-8
    assert np.abs(pose.left_jacobian(V) @ pose.left_jacobian_inverse(V) - np.eye(6)).max() < 1e-13
    assert np.abs(pose.right_jacobian(V) @ pose.right_jacobian_inverse(V) - np.eye(6)).max() < 1e-13
    assert np.abs(pose.adjoint(T) @ pose.right_jacobian(V) - pose.left_jacobian(V)).max() < 1e-13


def test_errors_are_the_twists_between_poses():
    T_sb, T_sd = poses(7, (30,), 2)
    V_b, V_s = pose.error(T_sb, T_sd), pose.space_error(T_sb, T_sd)
    assert np.abs(pose.compose(T_sb, pose.exp(V_b)) - T_sd).max() <= 32 * EPS
    assert np.abs(pose.compose(pose.exp(V_s), T_sb) - T_sd).max() <= 32 * EPS
    assert np.abs((pose.adjoint(T_sb) @ V_b[..., None])[..., 0] - V_s).max() < 1e-12


def test_interpolations_meet_their_ends():
    A, B = poses(8, (3, 1, 2), 2)
    for way in (pose.interpolate_screw, pose.interpolate_decoupled):
        assert np.abs(way(A, B, 0.0) - A).max() <= 16 * EPS
        assert np.abs(way(A, B, 1.0) - B).max() <= 32 * EPS
        assert np.all(pose.is_pose(way(A, B, 0.37), 16 * EPS))
    middle = pose.interpolate_decoupled(A, B, 0.5)
    assert np.abs(middle[..., :3, 3] - (A + B)[..., :3, 3] / 2).max() <= 4 * EPS
    halves = [pose.error(A, pose.interpolate_screw(A, B, 0.5)), pose.error(pose.interpolate_screw(A, B, 0.5), B)]
    assert np.abs(halves[0] - halves[1]).max() < 1e-13
    value = Pose(A[0, 0, 0]).interpolate_screw(Pose(B[0, 0, 0]), 0.5)
    assert value.close_to(Pose(pose.interpolate_screw(A, B, 0.5)[0, 0, 0]), EPS)
    other = Pose(A[0, 0, 0]).interpolate_decoupled(Pose(B[0, 0, 0]), 0.5)
    assert other.close_to(Pose(middle[0, 0, 0]), EPS)


@pytest.mark.capability("04-2", "04-17")
def test_values():
    R = Rotation.from_rpy([0.1, 0.2, 0.3], ("s", "b"))
    T = Pose.of(R, [1.0, 2.0, 3.0])
    assert T.frames == ("s", "b")
    assert T.rotation.close_to(R, 0)
    assert T.origin.tolist() == [1, 2, 3]
    assert T.array.size == 16
    rebuilt = eval(repr(T), {"Pose": Pose})
    assert rebuilt.frames == T.frames
    assert np.array_equal(rebuilt.array, T.array)
    for copied in (T, copy.deepcopy(T), *(pickle.loads(pickle.dumps(T, protocol)) for protocol in range(2, 6))):
        assert np.array_equal(copied.array, T.array)
        assert copied.frames == T.frames
        with pytest.raises(ValueError, match="read-only"):
            copied.array[0, 0] = 2.0
    batch = Pose.exp(np.zeros((4, 2, 6)), ("a", "b"))
    assert batch.batch == (4, 2)
    assert len(batch) == 4
    assert batch[1].batch == (2,)
    assert batch[:, 0].frames == ("a", "b")
    assert [one.batch for one in batch] == [(2,)] * 4
    assert np.asarray(batch).shape == (4, 2, 4, 4)
    with pytest.raises(TypeError):
        len(T)
    assert Pose.translation([1, 0, 0]).adjoint()[5, 1] == 1
    assert np.abs(Pose.exp([0.1] * 6).log() - 0.1).max() <= EPS
    assert Rotation.from_euler([0.1, 0.2, 0.3], "ZYX").euler("ZYX") == pytest.approx([0.1, 0.2, 0.3])
    assert Rotation.from_quaternion([0.0, 1, 0, 0]).quaternion().tolist() == [0, 1, 0, 0]
    axis, angle = Rotation.exp([0, 0, 0.5]).axis_angle()
    assert (axis.tolist(), float(angle)) == ([0, 0, 1], 0.5)
    assert Rotation.exp([0, 0, 0.5]).rpy() == pytest.approx([0, 0, 0.5])
    assert Rotation.exp([0, 0, 0.5]).log() == pytest.approx([0, 0, 0.5])
    assert Rotation.identity().angle_to(Rotation.exp([0, 0.5, 0])) == pytest.approx(0.5)
    assert Rotation.identity().slerp(Rotation.exp([0, 0.5, 0]), 0.5).log() == pytest.approx([0, 0.25, 0])
