"""Inertia of rigid bodies as expressions, against sums over point masses."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from mafsil.algebra.membership import function
from mafsil.expression import Function
from mafsil.geometry import pose, rotation, twist


def ports(text: str) -> list[tuple[str, tuple[int, ...]]]:
    parts = (entry.partition(":") for entry in text.split())
    return [(name, tuple(map(int, shape.split(","))) if shape else ()) for name, _, shape in parts]


@cache
def built(source: str, inputs: str, outputs: str) -> Function:
    return function(source, ports(inputs), ports(outputs))


def evaluate(source: str, inputs: str, outputs: str, *values: object) -> list[np.ndarray]:
    found = built(source, inputs, outputs).call([np.ravel(value) for value in values])
    return [np.array(x).reshape(shape) for x, (_, shape) in zip(found, ports(outputs), strict=True)]


@pytest.fixture
def body() -> tuple[np.ndarray, np.ndarray, float, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    points, masses = rng.standard_normal((20, 3)), rng.uniform(0.1, 1, 20)
    mass = float(masses.sum())
    com = masses @ points / mass
    return points, masses, mass, com, about(points - com, masses)


def about(points: np.ndarray, masses: np.ndarray) -> np.ndarray:
    return np.einsum(
        "k,kij->ij",
        masses,
        np.einsum("kl,kl,ij->kij", points, points, np.eye(3)) - points[:, :, None] * points[:, None],
    )


def test_momentum_and_energy_are_those_of_the_points(body):
    points, masses, mass, com, inertia = body
    V = np.array([0.3, -0.5, 0.7, 1.0, 0.2, -0.4])
    velocities = twist.point_velocity(V, points)
    p = masses @ velocities
    h = np.concatenate([np.cross(points, masses[:, None] * velocities).sum(0), p])
    (G,) = evaluate("inertia.spatial_inertia", "m c:3 I:3,3", "G:6,6", mass, com, inertia)
    assert np.abs(G @ V - h).max() < 1e-12
    (direct,) = evaluate("inertia.momentum", "m c:3 I:3,3 V:6", "h:6", mass, com, inertia, V)
    assert np.abs(direct - h).max() < 1e-12
    (energy,) = evaluate("inertia.kinetic_energy", "G:6,6 V:6", "T", G, V)
    assert energy == pytest.approx(0.5 * masses @ (velocities**2).sum(-1))


def test_changes_of_frame(body):
    points, masses, mass, com, inertia = body
    T_ab = pose.exp([0.3, -0.2, 0.9, 0.5, 1.0, -0.7])
    moved = pose.act(T_ab, points)
    (G_b,) = evaluate("inertia.spatial_inertia", "m c:3 I:3,3", "G:6,6", mass, com, inertia)
    (G_a,) = evaluate("inertia.transform_inertia", "G:6,6 T:4,4", "G_a:6,6", G_b, T_ab)
    com_a = masses @ moved / mass
    (direct,) = evaluate("inertia.spatial_inertia", "m c:3 I:3,3", "G:6,6", mass, com_a, about(moved - com_a, masses))
    assert np.abs(G_a - direct).max() < 1e-12
    (turned,) = evaluate("inertia.rotate_inertia", "I:3,3 R:3,3", "I_a:3,3", inertia, T_ab[:3, :3])
    assert np.abs(turned - about(moved - com_a, masses)).max() < 1e-12
    (shifted,) = evaluate("inertia.shift_inertia", "I:3,3 m d:3", "I_o:3,3", inertia, mass, com)
    assert np.abs(shifted - about(points, masses)).max() < 1e-12


def test_realisability(body):
    points, masses, mass, com, inertia = body
    (margin,) = evaluate("inertia.realisability", "m I:3,3", "x", mass, inertia)
    assert margin > 0
    (Sigma,) = evaluate("inertia.pseudo_inertia", "m c:3 I:3,3", "P:4,4", mass, com, inertia)
    homogeneous = np.concatenate([points, np.ones((20, 1))], axis=-1)
    assert np.abs(Sigma - np.einsum("k,ki,kj->ij", masses, homogeneous, homogeneous)).max() < 1e-12
    assert np.linalg.eigvalsh(Sigma).min() > 0
    for impossible in (np.diag([1.0, 1, 2.5]), np.diag([1.0, -0.1, 1])):
        (margin,) = evaluate("inertia.realisability", "m I:3,3", "x", 1.0, impossible)
        assert margin < 0
    (rod,) = evaluate("inertia.realisability", "m I:3,3", "x", 1.0, np.diag([1.0, 1, 0]))
    assert abs(rod) < 1e-15


def test_principal_moments(body):
    inertia = body[4]
    moments, axes = evaluate("inertia.principal_moments", "I:3,3", "moments:3 axes:3,3", inertia)
    assert np.abs(np.sort(moments) - np.linalg.eigvalsh(inertia)).max() < 1e-13
    assert np.abs(axes @ np.diag(moments) @ axes.T - inertia).max() < 1e-13
    assert np.abs(axes.T @ axes - np.eye(3)).max() < 1e-14


@pytest.mark.parametrize("size", [3, 4])
def test_jacobi_converges_on_hard_matrices(size: int):
    rng = np.random.default_rng(size)
    for k in range(200):
        Q = np.linalg.qr(rng.standard_normal((size, size)))[0]
        values = rng.choice([0.0, 1.0, 1.0 + 1e-9, -1.0, 1e-8, 3.0], size) if k % 2 else rng.standard_normal(size)
        K = Q @ np.diag(values) @ Q.T
        K = (K + K.T) / 2
        found, vectors = evaluate("so3.symmetric", f"K:{size},{size}", f"d:{size} V:{size},{size}", K)
        assert np.abs(vectors @ np.diag(found) @ vectors.T - K).max() < 1e-14 * max(1, np.abs(values).max()) * 4
        assert np.abs(vectors.T @ vectors - np.eye(size)).max() < 1e-14


def test_derivatives_are_clean_at_the_seams():
    """Jacobians of exp and log by automatic differentiation: finite at zero, equal to the closed forms."""
    import mafsil.expression as ex
    from mafsil.algebra import se3, so3

    V = ex.symbol("V", 6)
    slope = ex.Function("slope", [V], [ex.jacobian(ex.vec(se3.exp(V)), V), ex.jacobian(se3.log(se3.exp(V)), V)])
    for point in (np.zeros(6), np.full(6, 1e-200), np.full(6, 1e-9), np.full(6, 0.7)):
        first, identity = (np.array(x) for x in slope.call([point]))
        assert np.isfinite(first).all()
        assert np.abs(identity - np.eye(6)).max() < 1e-12
    r = ex.symbol("r", 3)
    columns = ex.horzcat(
        *[so3.vee(ex.reshape(ex.jacobian(ex.vec(so3.exp(r)), r)[:, k], 3, 3) @ so3.exp(r).T) for k in range(3)]
    )
    both = ex.Function("both", [r], [columns, so3.left_jacobian(r), ex.hessian(so3.log(so3.exp(r))[0], r)[0]])
    for point in (np.zeros(3), np.array([0.3, -0.2, 0.5]), np.array([1.0, 2.0, -0.5])):
        by_differentiation, closed, second = (np.array(x) for x in both.call([point]))
        assert np.abs(by_differentiation - closed).max() < 1e-13
        assert np.abs(second).max() < 1e-10


def test_kernels_of_rotations_agree_with_the_expressions():
    r = np.array([0.3, 0.2, -0.9])
    (R,) = evaluate("so3.exp", "r:3", "R:3,3", r)
    assert np.abs(rotation.exp(r) - R).max() <= 2.0**-52
