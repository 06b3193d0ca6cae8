"""Exp, log and Jacobians of SO(3) and SE(3), compiled, against 60 digits: from 0 over every switch point to pi."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from math import nextafter, pi

import mpmath as mp
import numpy as np
import pytest

from mafsil.algebra import series
from mafsil.geometry import pose, rotation

EPS = 2.0**-52
DIGITS = 60
AXES = [np.array([1.0, 2.0, -2.0]) / 3, np.array([1.0, 0.0, 0.0]), np.array([0.6, 1e-9, -0.8])]
V = np.array([0.3, -0.7, 0.5])


def _neighbours(x: float) -> list[float]:
    return [nextafter(x, 0), x, nextafter(x, 10)]


def _switches() -> list[float]:
    tables = [value for name, value in vars(series).items() if name.startswith("_") and isinstance(value, list)]
    points = [series._switch(table) ** 0.5 for table in tables] + [series._HALF_SWITCH**0.5]
    return sorted({theta for theta in points if theta < pi})


SEAMS = [1e-300, 1e-160, 1e-150, 1e-20, 1e-12, 1e-9, 1e-8, 9e-8, 9e-7, 9e-6, 1e-4, 1e-3, 1e-2]
SEAMS += [theta for switch in _switches() for theta in _neighbours(switch)]
SEAMS += [0.5, 1.0, pi / 2, 2 * pi / 3, 2.5, 3.0, 3.14]
SEAMS += [pi - d for d in (1e-3, 1e-5, 1e-7, 1e-9, 1e-12, 1e-15)] + [nextafter(pi, 0), pi]


def _matrix(rows: object) -> mp.matrix:
    return mp.matrix(rows)


def _hat(w: list[mp.mpf]) -> mp.matrix:
    x, y, z = w
    return mp.matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def _series(A: mp.matrix, shift: int) -> mp.matrix:
    """Sum of A^k / (k + shift)!."""
    total, term, k = mp.zeros(A.rows), mp.eye(A.rows) / mp.factorial(shift), 0
    while mp.mnorm(term, 1) > mp.mpf(10) ** (-DIGITS - 5) or k < 3:
        total, k = total + term, k + 1
        term = term * A / (k + shift)
    return total


def _ad(v: list[mp.mpf]) -> mp.matrix:
    M = mp.zeros(6)
    M[0:3, 0:3] = M[3:6, 3:6] = _hat(v[:3])
    M[3:6, 0:3] = _hat(v[3:])
    return M


def _hat4(v: list[mp.mpf]) -> mp.matrix:
    M = mp.zeros(4)
    M[0:3, 0:3] = _hat(v[:3])
    for k in range(3):
        M[k, 3] = v[3 + k]
    return M


def _error(value: np.ndarray, exact: mp.matrix, scale: float) -> float:
    """Largest deviation of an entry, in units of the rounding error of the scale."""
    flat = value.reshape(exact.rows, exact.cols)
    worst = max(abs(mp.mpf(float(flat[i, j])) - exact[i, j]) for i in range(exact.rows) for j in range(exact.cols))
    return float(worst / (EPS * scale))


def _thetas(every: int = 1) -> list[float]:
    sweep = [float(x) for x in np.geomspace(1e-14, 3.14, 60)]
    return sorted([*SEAMS, *sweep])[::every]


@pytest.fixture(scope="module", autouse=True)
def _digits() -> object:
    before, mp.mp.dps = mp.mp.dps, DIGITS
    yield
    mp.mp.dps = before


Case = tuple[str, Callable[[np.ndarray], np.ndarray], Callable[[list[mp.mpf]], mp.matrix], int]
CASES: list[Case] = [
    ("rotation.exp", rotation.exp, lambda r: _series(_hat(r), 0), 3),
    ("rotation.left_jacobian", rotation.left_jacobian, lambda r: _series(_hat(r), 1), 3),
    ("rotation.left_jacobian_inverse", rotation.left_jacobian_inverse, lambda r: _series(_hat(r), 1) ** -1, 3),
    ("pose.exp", pose.exp, lambda v: _series(_hat4(v), 0), 6),
    ("pose.left_jacobian", pose.left_jacobian, lambda v: _series(_ad(v), 1), 6),
    ("pose.left_jacobian_inverse", pose.left_jacobian_inverse, lambda v: _series(_ad(v), 1) ** -1, 6),
]


@pytest.mark.row("R8")
@pytest.mark.parametrize(("name", "compiled", "exact", "size"), CASES, ids=[case[0] for case in CASES])
def test_entries_are_within_8_ulp_of_their_natural_scale_from_0_to_pi(
    name: str,
    compiled: Callable[[np.ndarray], np.ndarray],
    exact: Callable[[list[mp.mpf]], mp.matrix],
    size: int,
    record_property: Callable[[str, object], None],
) -> None:
    """The natural scale is 1: every entry is a rotation's, or a length over |v| = 1."""
    worst, where = 0.0, 0.0
    for axis in AXES[: 1 if size == 6 else 3]:
        for theta in _thetas(2 if size == 6 else 1):
            coordinates = np.concatenate([axis * theta, V])[:size]
            reference = exact([mp.mpf(float(x)) for x in coordinates])
            error = _error(compiled(coordinates), reference, 1.0)
            worst, where = max((worst, where), (error, theta))
    record_property("worst_ulp", worst)
    print(f"{name}: worst {worst:.2f} ulp at theta = {where!r}")
    assert worst <= 8


def _rotation_of(r: np.ndarray) -> np.ndarray:
    exact = _series(_hat([mp.mpf(float(x)) for x in r]), 0)
    return np.array([[float(exact[i, j]) for j in range(3)] for i in range(3)])


@pytest.mark.row("R8")
@pytest.mark.capability("04-65", "04-67")
def test_log_of_a_correctly_rounded_rotation_is_within_8_ulp_of_the_angle(
    record_property: Callable[[str, object], None],
) -> None:
    worst, where = 0.0, 0.0
    for axis in AXES:
        for theta in _thetas():
            r = axis * theta
            found = rotation.log(_rotation_of(r))
            if theta > pi - 1e-7 and found @ r < 0:
                found = -found * (2 * pi - np.linalg.norm(found)) / np.linalg.norm(found)
            error = float(np.abs(found - r).max()) / (EPS * theta)
            worst, where = max((worst, where), (error, theta))
    record_property("worst_ulp", worst)
    print(f"rotation.log: worst {worst:.2f} ulp of theta at theta = {where!r}")
    assert worst <= 8


@pytest.mark.row("R8")
@pytest.mark.capability("04-97")
def test_log_of_a_correctly_rounded_pose_is_within_8_ulp(record_property: Callable[[str, object], None]) -> None:
    worst, where = 0.0, 0.0
    for theta in _thetas():
        coordinates = np.concatenate([AXES[0] * theta, V])
        exact = _series(_hat4([mp.mpf(float(x)) for x in coordinates]), 0)
        T = np.array([[float(exact[i, j]) for j in range(4)] for i in range(4)])
        found = pose.log(T)
        if found[:3] @ coordinates[:3] >= 0:
            error = float(np.abs(found - coordinates).max()) / (EPS * max(1.0, theta))
            worst, where = max((worst, where), (error, theta))
    record_property("worst_ulp", worst)
    print(f"pose.log: worst {worst:.2f} ulp at theta = {where!r}")
    assert worst <= 8


@pytest.mark.capability("04-67", "04-70")
@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0, -1, 0), (1, 2, 2), (-2, 1, 2), (1e-9, 1, 0)])
def test_an_exact_half_turn_has_an_axis(axis: tuple[float, float, float]) -> None:
    w = np.array(axis) / np.linalg.norm(axis)
    R = 2 * np.outer(w, w) - np.eye(3)
    r = rotation.log(R)
    assert abs(abs(r @ w) - pi) <= 4 * EPS * pi
    assert np.abs(rotation.exp(r) - R).max() <= 4 * EPS


def test_switch_points_are_where_the_dropped_term_is_one_rounding_error() -> None:
    for table in (series._SINC_DEFECT, series._COTANGENT_DEFECT, series._VERSINC_SLOPE):
        s = series._switch(table)
        dropped = abs(table[-1]) * s ** (len(table) - 1)
        assert dropped == pytest.approx(EPS * abs(table[0]), rel=1e-9)


def test_bernoulli_numbers() -> None:
    known = [Fraction(1), Fraction(-1, 2), Fraction(1, 6), Fraction(0), Fraction(-1, 30), Fraction(0), Fraction(1, 42)]
    assert series.bernoulli_numbers(7) == known
