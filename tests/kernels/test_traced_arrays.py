"""Arrays of expressions answer NumPy as arrays of numbers do, and say so where they cannot."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.expression import Function
from mafsil.geometry import pose, rotation
from mafsil.kernels.traced_array import Traced
from mafsil.kernels.traced_number import Untraceable


def value(function, *arrays):
    """What a function of arrays computes, by way of its expression."""
    pairs = [Traced.symbols(f"x{k}", np.shape(x)) for k, x in enumerate(arrays)]
    found = function(*(array for array, _ in pairs))
    found = found if isinstance(found, tuple) else (found,)
    made = Function("made", [column for _, column in pairs], [x.column() for x in found])
    numbers = made.call([np.ravel(x) for x in arrays])
    results = [np.array(x.full()).reshape(y.shape) for x, y in zip(numbers, found, strict=True)]
    return results[0] if len(results) == 1 else tuple(results)


def assigned(A, b):
    full = np.zeros_like(A, shape=(4, 6))
    full[..., [0, 2, 4, 5]] = A
    full[1, 1:3] = b[:2]
    return full


FUNCTIONS = {
    "arithmetic": lambda A, b: (A * 2 - b) / (3.0 + b) ** 2 + 1.0 / (2.0 + A) - -A,
    "products": lambda A, b: A @ A.T @ b + b @ A + np.eye(4) @ b + np.diag([1.0, 2.0, 3.0, 4.0]) @ A @ b,
    "functions": lambda A, b: np.sin(A) + np.cos(A) * np.tanh(A) + np.exp(A) + np.sqrt(np.abs(A)) + np.arctan2(A, b),
    "extremes": lambda A, b: np.maximum(A, 0.1) + np.minimum(A, b) + np.clip(A, -0.2, 0.3) + A.max() + A.min(axis=0),
    "choices": lambda A, b: np.where((A > 0.1) & (b < 0.5) | (A <= -0.5), A, 2 * b) + np.where(~(A >= b), 1.0, A),
    "truths": lambda A, b: np.where(np.any(A > 1.5, axis=1), b, np.where((A < 9.0).all(), 2.0 * b, 0.0)),
    "parts": lambda A, b: np.concatenate([A[..., :2, :], A[[3, 0]], np.stack([b, 2 * b])], axis=0)[::-1, (0, 2)],
    "shapes": lambda A, b: np.swapaxes(A, 0, 1)[..., None].reshape(2, 8) + np.broadcast_to(b[:2, None], (2, 8)),
    "sums": lambda A, b: np.einsum("ij,j->i", A, b) + A.sum(axis=1) + np.sum(A) + np.linalg.norm(A, axis=0),
    "cross": lambda A, b: np.cross(A[:, :3], b[:3]) + np.zeros_like(A[:, :3]) + np.ones_like(b[:3]),
    "rounding": lambda A, b: np.round(7 * A) + np.floor(A) + np.ceil(b) + np.sign(A) + np.mod(A, 0.3),
    "halves": lambda A, b: np.round(np.round(4 * A) / 2) + np.copysign(b, A),
    "solve": lambda A, b: np.linalg.solve(A, b) + np.linalg.solve(A, A + np.eye(4)) @ b + np.linalg.inv(A) @ b,
    "solve with numbers": lambda A, b: np.linalg.solve(np.diag([1.0, 2.0, 3.0, 4.0]) + 0.1, A),
    "pseudoinverse": lambda A, b: np.linalg.pinv(A[:2]) @ b[:2],
    "assignment": assigned,
}


@pytest.mark.parametrize("name", list(FUNCTIONS))
@pytest.mark.parametrize("seed", range(3))
def test_numpy_does_to_expressions_what_it_does_to_numbers(name, seed):
    rng = np.random.default_rng(seed)
    A, b = rng.normal(size=(4, 4)), rng.normal(size=4)
    np.testing.assert_allclose(value(FUNCTIONS[name], A, b), FUNCTIONS[name](A, b), rtol=1e-11, atol=1e-11)


def test_what_is_no_number_stays_none():
    """A clipped effort that is NaN is no limit."""
    A, b = np.array([np.nan, 1.0, -3.0, 2.0]), np.array([0.5, np.nan, 1.0, np.inf])
    for function in (
        np.maximum,
        np.minimum,
        lambda A, b: np.clip(A, -2.0, 1.5),
        lambda A, b: np.minimum(np.maximum(A, -np.inf), np.inf),
        lambda A, b: np.fmax(A, b) + np.fmin(b, A),
        lambda A, b: np.where(A > 0.0, b, 1.0),
    ):
        np.testing.assert_array_equal(value(function, A, b), function(A, b))


@pytest.mark.parametrize("n", range(1, 8))
@pytest.mark.parametrize("seed", range(4))
def test_axes_of_symmetric_matrices(n, seed):
    """Of sizes ten decades apart, with equal ones, or of lower rank, as arms at singularities have."""
    rng = np.random.default_rng(10 * n + seed)
    turn, _ = np.linalg.qr(rng.normal(size=(n, n)))
    sizes = [10.0 ** rng.uniform(-5, 5, n), np.ones(n), np.arange(n) // 2.0, rng.normal(size=n)][seed]
    A = (turn * sizes) @ turn.T
    A = (A + A.T) / 2
    found, axes = value(np.linalg.eigh, A)
    scale = np.abs(sizes).max(initial=1e-300)
    np.testing.assert_allclose(np.sort(found), np.linalg.eigvalsh(A), rtol=0, atol=1e-14 * scale)
    np.testing.assert_allclose(axes @ axes.T, np.eye(n), rtol=0, atol=1e-13)
    np.testing.assert_allclose((axes * found) @ axes.T, A, rtol=0, atol=1e-13 * scale)


@pytest.mark.parametrize("n", range(1, 8))
def test_elimination_exchanges_rows(n):
    """Where pivots vanish, too."""
    rng = np.random.default_rng(n)
    A = rng.normal(size=(n, n))[::-1] * (rng.random((n, n)) < 0.7) + np.eye(n)[rng.permutation(n)]
    b = rng.normal(size=(n, 3))
    expected = np.linalg.solve(A, b)
    np.testing.assert_allclose(value(np.linalg.solve, A, b), expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_compiled_functions_answer_with_what_they_are_compiled_from():
    """Quantities of robots by position, name and frame, and of geometry; batches too."""
    robot = mf.load("puma560")
    q, qd = np.random.default_rng(0).uniform(-1, 1, (2, 6))

    def all_together(q, qd):
        T = robot.forward_kinematics(q)
        J = robot.jacobian_body(q, frame="forearm")
        tau = robot.inverse_dynamics(q, qd=qd, qdd=0.5 * q, tip_wrench=J @ qd)
        V = pose.log(T @ pose.inverse(pose.exp(0.1 * qd))) + pose.adjoint(T) @ qd
        r = rotation.log(T[:3, :3])
        two = robot.gravity_torque(np.stack([q, qd])).sum(axis=0)
        return np.concatenate([tau, V, r, two, robot.friction_torque(qd), robot.mass_matrix(q)[2]])

    np.testing.assert_allclose(value(all_together, q, qd), all_together(q, qd), rtol=1e-12, atol=1e-12)


REFUSED = {
    "if": (lambda x: x if x[0] > 0.0 else -x, "decides"),
    "any": (lambda x: bool((x > 0.0).any()), "decides"),
    "round": (lambda x: round(x[0]), "decides"),
    "index": (lambda x: np.arange(3)[x[0]], "leaves"),
    "float": (lambda x: float(x[0]), "leaves"),
    "asarray": (np.asarray, "leaves"),
    "into numbers": (lambda x: np.zeros(3).__setitem__(slice(None), x), "leaves"),
    "svd": (lambda x: np.linalg.svd(x[None]), "leaves"),
    "decimals": (lambda x: np.round(x, 2), "leaves"),
    "norm of one": (lambda x: np.linalg.norm(x, 1), "leaves"),
    "initial": (lambda x: np.max(x, initial=3.0), "leaves"),
    "where": (lambda x: np.add(x, 1.0, where=[True, False, True]), "leaves"),
    "sort": (np.sort, "leaves"),
    "spacing": (np.spacing, "leaves"),
}


@pytest.mark.parametrize("name", list(REFUSED))
def test_what_cannot_be_traced_says_so(name):
    function, reason = REFUSED[name]
    array, _ = Traced.symbols("x", (3,))
    with pytest.raises(Untraceable) as caught:
        function(array)
    assert caught.value.reason == reason
