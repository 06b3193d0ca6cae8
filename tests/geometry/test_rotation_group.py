"""Laws of the rotation group, at batch shapes (), (1,) and (3, 1, 2)."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.errors import InputError
from mafsil.geometry import Rotation, membership, rotation
from mafsil.geometry.values import Vector

SHAPES = [(), (1,), (3, 1, 2)]
EPS = 2.0**-52
TINY = 16 * EPS

batches = st.sampled_from(SHAPES)
seeds = st.integers(0, 2**32 - 1)


def rotations(seed: int, shape: tuple[int, ...], count: int = 1) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [rotation.random(rng, shape) for _ in range(count)]


@settings(max_examples=60, deadline=None)
@given(seeds, batches)
@pytest.mark.capability("04-24", "04-25", "04-26")
def test_group_axioms(seed: int, shape: tuple[int, ...]):
    A, B, C = rotations(seed, shape, 3)
    identity = np.broadcast_to(np.eye(3), A.shape)
    product = rotation.compose(A, B)
    assert product.shape == (*shape, 3, 3)
    assert np.all(rotation.is_rotation(product, TINY))
    assert np.abs(rotation.compose(product, C) - rotation.compose(A, rotation.compose(B, C))).max() <= TINY
    assert np.abs(rotation.compose(A, rotation.inverse(A)) - identity).max() <= TINY
    assert np.abs(rotation.compose(A, identity) - A).max() == 0
    assert np.abs(rotation.inverse(A) - np.linalg.inv(A)).max() <= TINY


@settings(max_examples=60, deadline=None)
@given(seeds, batches)
@pytest.mark.capability("04-27", "04-31")
def test_lengths_and_vectors(seed: int, shape: tuple[int, ...]):
    (R,) = rotations(seed, shape)
    x = np.random.default_rng(seed).standard_normal((*shape, 3))
    y = rotation.apply(R, x)
    assert y.shape == x.shape
    assert np.abs(np.linalg.norm(y, axis=-1) - np.linalg.norm(x, axis=-1)).max() <= TINY * 8
    assert np.abs(rotation.apply(rotation.inverse(R), y) - x).max() <= TINY * 8
    # The row of axes: [axes of a] = [axes of b] R_ba.
    axes_b = R
    assert np.abs(axes_b @ rotation.inverse(R) - np.eye(3)).max() <= TINY


@settings(max_examples=60, deadline=None)
@given(seeds, batches)
@pytest.mark.capability("04-59", "04-60", "04-61")
def test_skew_algebra(seed: int, shape: tuple[int, ...]):
    (R,) = rotations(seed, shape)
    rng = np.random.default_rng(seed)
    x, y = rng.standard_normal((2, *shape, 3))
    X, Y = rotation.hat(x), rotation.hat(y)
    assert np.abs(np.matmul(X, y[..., None])[..., 0] - np.cross(x, y)).max() <= TINY * 8
    assert np.abs(rotation.hat(np.cross(x, y)) - (X @ Y - Y @ X)).max() <= TINY * 16
    assert np.abs(R @ X @ rotation.inverse(R) - rotation.hat(rotation.apply(R, x))).max() <= TINY * 16
    assert np.array_equal(rotation.vee(X), x)


@pytest.mark.capability("04-62")
def test_characteristic_polynomial_and_powers_of_a_unit_skew_matrix():
    from mafsil.geometry.matrix_exponential import characteristic_polynomial

    w = np.array([1.0, 2.0, 2.0]) / 3
    W = rotation.hat(w)
    assert np.abs(characteristic_polynomial(3 * W) - [1, 0, 9, 0]).max() <= 1e-14
    assert np.abs(W @ W @ W + W).max() <= TINY
    assert np.abs(np.linalg.matrix_power(W, 4) + W @ W).max() <= TINY
    assert np.abs(np.linalg.matrix_power(W, 5) - W).max() <= TINY


@pytest.mark.capability("04-19", "04-20", "04-21", "04-22", "04-16")
def test_constraints_and_handedness():
    R = rotation.random(np.random.default_rng(3))
    a, b, c = R.T
    triples = [a @ np.cross(b, c), c @ np.cross(a, b), b @ np.cross(c, a)]
    assert np.abs(np.array(triples) - 1).max() <= TINY
    assert np.abs(np.cross(a, b) - c).max() <= TINY
    assert np.abs(rotation.residuals(R)).max() <= TINY
    flipped = R * [1, 1, -1]
    assert np.abs(rotation.residuals(flipped)[:6]).max() <= TINY
    assert rotation.residuals(flipped)[6] == pytest.approx(-2)
    assert not rotation.is_rotation(flipped)
    with pytest.raises(InputError, match="determinant is -1"):
        rotation.check(flipped)
    with pytest.raises(InputError, match=r"the length 1\.001, required 1"):
        rotation.check(1.001 * R)


@pytest.mark.capability("04-28", "04-29", "04-30")
def test_orientation_of_frames_and_subscript_cancellation():
    rng = np.random.default_rng(4)
    R_ab = Rotation.random(rng, (5,))
    R_ab = Rotation(R_ab.array, ("a", "b"))
    R_bc = Rotation(rotation.random(rng, (5,)), ("b", "c"))
    assert (R_ab @ R_bc).frames == ("a", "c")
    assert R_ab.inverse().frames == ("b", "a")
    assert np.all((R_ab @ R_ab.inverse()).close_to(Rotation.identity(), TINY))
    with pytest.raises(InputError, match=r"frame \{b\} meets frame \{a\}"):
        R_ab @ R_ab
    columns = [R_ab.array[..., k] for k in range(3)]
    assert np.array_equal(Rotation.from_axes(*columns).array, R_ab.array)
    # Axes of {a} and {b} given in a third frame {s}: R_ab holds their inner products.
    R_sa, R_sb = rotation.random(rng, (2, 5))
    assert np.abs(rotation.inverse(R_sa) @ R_sb - np.einsum("...ki,...kj->...ij", R_sa, R_sb)).max() <= TINY
    assert Rotation.identity(("a", "a")).frames == ("a", "a")
    v_b = Vector(rng.standard_normal((5, 3)), "b")
    assert (R_ab @ v_b).frame == "a"
    with pytest.raises(InputError, match="adjacent letters"):
        R_bc @ v_b


@pytest.mark.capability("04-22")
def test_tolerance_of_membership_is_named_and_measured():
    for size in (1e-9, 1e-7, 1e-5):
        M = np.eye(3) * (1 + size)
        assert membership.measure("rotation", M) == pytest.approx(2 * size * np.sqrt(3), rel=1e-3)
    single = rotation.random(np.random.default_rng(5), (1000,)).astype(np.float32)
    assert rotation.is_rotation(single).all()
    assert not rotation.is_rotation(np.full((3, 3), np.nan))
    with pytest.raises(InputError, match=r"R\[7\]: not a rotation"):
        rotation.log(np.stack([np.eye(3)] * 7 + [np.diag([1, 2, 0.5])]))


@settings(max_examples=40, deadline=None)
@given(seeds, batches)
def test_projection_is_the_nearest_rotation(seed: int, shape: tuple[int, ...]):
    M = np.random.default_rng(seed).standard_normal((*shape, 3, 3))
    U, S, Vt = np.linalg.svd(M)
    sign = np.ones((*shape, 3))
    sign[..., 2] = np.sign(np.linalg.det(U @ Vt))
    gap = S[..., 1] + sign[..., 2] * S[..., 2]
    wanted = (U * sign[..., None, :]) @ Vt
    error = np.abs(rotation.project(M) - wanted).max((-1, -2))
    assert np.all(error <= 1e-14 * (1 + S[..., 0] / gap))


def test_projection_keeps_rotations_and_repairs_noise():
    rng = np.random.default_rng(6)
    R = rotation.random(rng, (2000,))
    assert np.abs(rotation.project(R) - R).max() <= 8 * EPS
    noisy = R + 1e-3 * rng.standard_normal(R.shape)
    assert rotation.angle_between(rotation.project(noisy), R).max() < 5e-3
    assert Rotation.nearest(noisy).batch == (2000,)
    assert rotation.is_rotation(rotation.project(np.zeros((3, 3))))


def test_random_rotations_are_uniform():
    R = rotation.random(np.random.default_rng(7), 200_000)
    assert np.abs(R.mean(0)).max() < 0.01
    # The angle has density (1 - cos) / pi: its mean is pi/2 + 2/pi.
    assert rotation.angle(R).mean() == pytest.approx(pi / 2 + 2 / pi, abs=5e-3)


@pytest.mark.capability("04-45", "04-47", "04-48")
def test_fixed_axes_multiply_on_the_left_and_body_axes_on_the_right():
    a, b, c = 0.3, -0.7, 1.1
    v = np.array([0.2, -0.4, 0.9])
    v1 = rotation.apply(rotation.rot_x(c), v)
    v2 = rotation.apply(rotation.rot_y(b), v1)
    v3 = rotation.apply(rotation.rot_z(a), v2)
    R = rotation.from_rpy([c, b, a])
    assert np.abs(rotation.apply(R, v) - v3).max() <= TINY
    start = Rotation.from_rpy([0.1, 0.2, 0.3])
    turn = Rotation.exp([0.0, 0.0, 0.4])
    assert np.abs(start.then_about_fixed(turn).array - turn.array @ start.array).max() <= TINY
    assert np.abs(start.then_about_body(turn).array - start.array @ turn.array).max() <= TINY
    # Turning about a body axis is turning about where that axis stands now.
    axis_now = rotation.apply(start.array, np.array([0.0, 0.0, 1.0]))
    about_now = Rotation.from_axis_angle(axis_now, 0.4)
    assert np.all(start.then_about_body(turn).close_to(start.then_about_fixed(about_now), TINY))


@pytest.mark.capability("04-3", "04-64")
def test_descriptive_and_prescriptive_readings():
    R_ab = Rotation.from_axis_angle([1.0, 2.0, -1.0], 0.8, ("a", "b"))
    x = np.array([0.3, 0.4, -0.2])
    described = (R_ab @ Vector(x, "b")).array
    turned = R_ab.turn(x)
    assert np.array_equal(described, turned)
    assert np.linalg.norm(turned) == pytest.approx(np.linalg.norm(x))


@settings(max_examples=40, deadline=None)
@given(seeds, batches, st.floats(-1, 2))
def test_slerp_turns_at_constant_speed(seed: int, shape: tuple[int, ...], t: float):
    A, B = rotations(seed, shape, 2)
    R = rotation.slerp(A, B, t)
    whole = rotation.angle_between(A, B)
    assert np.abs(rotation.slerp(A, B, 0.0) - A).max() <= TINY
    assert np.abs(rotation.slerp(A, B, 1.0) - B).max() <= TINY
    if 0 <= t <= 1:
        assert np.abs(rotation.angle_between(A, R) - t * whole).max() <= 1e-13
    halves = rotation.slerp(A, B, 0.5)
    assert np.abs(rotation.angle_between(A, halves) - rotation.angle_between(halves, B)).max() <= 1e-13


def test_jacobians_relate_rates_and_invert():
    rng = np.random.default_rng(8)
    r, dr = rng.standard_normal((2, 50, 3))
    h = 1e-6
    Rdot = (rotation.exp(r + h * dr) - rotation.exp(r - h * dr)) / (2 * h)
    R = rotation.exp(r)
    omega_s = rotation.vee(Rdot @ rotation.inverse(R))
    omega_b = rotation.vee(rotation.inverse(R) @ Rdot)
    assert np.abs(np.matmul(rotation.left_jacobian(r), dr[..., None])[..., 0] - omega_s).max() < 1e-8
    assert np.abs(np.matmul(rotation.right_jacobian(r), dr[..., None])[..., 0] - omega_b).max() < 1e-8
    for J, Ji in (
        (rotation.left_jacobian, rotation.left_jacobian_inverse),
        (rotation.right_jacobian, rotation.right_jacobian_inverse),
    ):
        assert np.abs(J(r) @ Ji(r) - np.eye(3)).max() <= TINY * 8
