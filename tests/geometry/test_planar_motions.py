"""Rigid motions of the plane: pairs, poles (finite and at infinity), exponential coordinates, embedding in space."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.errors import InputError
from mafsil.geometry import planar, pose, rotation, screw, twist

EPS = 2.0**-52
seeds = st.integers(0, 2**32 - 1)
batches = st.sampled_from([(), (1,), (3, 1, 2)])


@settings(max_examples=60, deadline=None)
@given(seeds, batches)
@pytest.mark.capability("04-9", "04-10", "04-11", "04-12", "04-79")
def test_pairs(seed: int, shape: tuple[int, ...]):
    rng = np.random.default_rng(seed)
    theta, phi = rng.uniform(0, 2 * pi, (2, *shape))
    p, r = rng.standard_normal((2, *shape, 2))
    T_sb, T_sc = planar.pose(theta, p), planar.pose(phi, r)
    P, R = T_sb[..., :2, :2], T_sc[..., :2, :2]
    assert np.abs(np.swapaxes(P, -1, -2) @ P - np.eye(2)).max() <= 4 * EPS
    assert np.abs(np.linalg.inv(P) - np.swapaxes(P, -1, -2)).max() <= 8 * EPS
    T_bc = planar.compose(planar.inverse(T_sb), T_sc)
    Q, q = T_bc[..., :2, :2], T_bc[..., :2, 2]
    assert np.abs(P @ Q - R).max() <= 8 * EPS
    assert np.abs(p + (P @ q[..., None])[..., 0] - r).max() <= 64 * EPS
    psi = planar.angle(Q)
    assert np.abs(np.angle(np.exp(1j * (psi - (phi - theta))))).max() <= 16 * EPS
    coordinates = planar.coordinates(T_sb)
    assert coordinates.shape == (*shape, 3)
    assert np.abs(np.angle(np.exp(1j * (coordinates[..., 0] - theta)))).max() <= 8 * EPS
    assert np.all((coordinates[..., 0] >= 0) & (coordinates[..., 0] < 2 * pi))
    assert np.array_equal(coordinates[..., 1:], p)


@settings(max_examples=60, deadline=None)
@given(seeds, batches)
@pytest.mark.capability("04-14", "04-98")
def test_three_forms_of_the_pole(seed: int, shape: tuple[int, ...]):
    rng = np.random.default_rng(seed)
    theta, psi = rng.uniform(0, 2 * pi, shape), rng.uniform(0.1, 2 * pi - 0.1, shape)
    p, s = rng.standard_normal((2, *shape, 2))
    T_sb = planar.pose(theta, p)
    E = planar.about_pole(psi, s)
    T_sc = planar.compose(E, T_sb)
    found, exists = planar.finite_pole(planar.displacement(T_sb, T_sc))
    assert np.all(exists)
    assert np.abs(found - s).max() < 1e-12
    d = E[..., :2, 2]
    by_solve = np.linalg.solve(np.eye(2) - E[..., :2, :2], d[..., None])[..., 0]
    assert np.abs(by_solve - s).max() < 1e-11
    r = T_sc[..., :2, 2]
    across = np.stack([-(r - p)[..., 1], (r - p)[..., 0]], axis=-1)
    by_figure = (p + r) / 2 + 0.5 / np.tan(psi / 2)[..., None] * across
    assert np.abs(by_figure - s).max() < 1e-11
    V = planar.log(planar.displacement(T_sb, T_sc))
    rate = planar.twist_of_pole(V[..., 0], s)
    assert np.abs(rate - V).max() < 1e-11


@pytest.mark.capability("04-15")
def test_translation_has_its_pole_at_infinity():
    moved = planar.displacement(planar.pose(0.7, [1.0, 2.0]), planar.pose(0.7, [3.0, 3.0]))
    x, y, w = planar.pole(moved)
    assert abs(w) <= EPS
    assert np.abs(np.array([x, y]) - [-0.5, 1.0]).max() <= 4 * EPS
    point, exists = planar.finite_pole(moved)
    assert not exists
    assert np.isinf(point).all()
    assert planar.pole(np.eye(3)).tolist() == [0, 0, 0]
    # Coming from small rotations, the pole runs off along that direction without a jump.
    near = planar.pole(planar.pose(1e-9, [2.0, 1.0]))
    assert near[2] == pytest.approx(5e-10)
    assert near[:2] == pytest.approx([-0.5, 1.0])


@pytest.mark.capability("04-13", "04-3")
def test_the_pair_as_a_motion():
    T_sb, T_bc = planar.pose(0.4, [1.0, 2.0]), planar.pose(0.3, [0.5, -0.1])
    T_sc = planar.compose(T_sb, T_bc)
    E = planar.displacement(T_sb, T_sc)
    assert np.abs(E @ [1, 2, 1] - T_sc[:, 2]).max() <= 8 * EPS
    x = np.array([0.3, 0.9, 1.0])
    assert np.abs(E @ (T_sb @ x) - T_sb @ (T_bc @ x)).max() <= 16 * EPS


@settings(max_examples=100, deadline=None)
@given(seeds, st.floats(-3.1, 3.1), batches)
@pytest.mark.capability("04-98", "04-99", "04-79", "04-23")
def test_exponential_coordinates_and_embedding(seed: int, omega: float, shape: tuple[int, ...]):
    V = np.random.default_rng(seed).standard_normal((*shape, 3))
    V[..., 0] = omega
    T = planar.exp(V)
    assert np.abs(planar.log(T) - V).max() <= 64 * EPS * max(1, np.abs(V).max())
    spatial = planar.to_spatial_twist(V)
    assert np.abs(pose.exp(spatial) - planar.to_spatial_pose(T)).max() <= 32 * EPS * max(1, np.abs(V).max())
    assert np.abs(screw.pitch(spatial)).max() <= 0 if omega else True
    Ad = planar.adjoint(T)
    moved = planar.to_spatial_twist(np.matmul(Ad, V[..., None])[..., 0])
    want = twist.transform(planar.to_spatial_pose(T), spatial)
    assert np.abs(moved - want).max() <= 1e-13 * max(1, np.abs(V).max() ** 2)


@pytest.mark.capability("04-23")
def test_planar_rotations_are_rotations_about_z():
    theta = np.linspace(0, 2 * pi, 20, endpoint=False)
    R = planar.rotation(theta)
    assert planar.is_rotation(R).all()
    assert np.abs(planar.angle(R) - theta).max() <= 8 * EPS
    assert np.abs(planar.to_spatial_rotation(R) - rotation.rot_z(theta)).max() <= 2 * EPS
    assert not planar.is_rotation(np.diag([1.0, -1.0]))
    assert not planar.is_pose(np.diag([1.0, 1.0, 2.0]))
    assert planar.is_pose(planar.pose(0.3, [1, 2]))
    with pytest.raises(InputError, match="determinant"):
        planar.angle(np.diag([1.0, -1.0]))
    with pytest.raises(InputError, match="not a planar rotation"):
        planar.angle(np.diag([2.0, 1.0]))
    with pytest.raises(InputError, match="last row"):
        planar.log(np.ones((3, 3)))
    with pytest.raises(InputError, match="not a planar pose"):
        planar.log(np.diag([1.1, 1.0, 1.0]))


@pytest.mark.parametrize("omega", [0.0, 1e-300, 1e-9, 1e-3, pi - 1e-9, pi])
def test_no_digit_is_lost_at_the_ends(omega: float):
    V = np.array([omega, 0.3, -0.7])
    assert np.abs(planar.log(planar.exp(V)) - V).max() <= 8 * EPS * max(1, omega)
