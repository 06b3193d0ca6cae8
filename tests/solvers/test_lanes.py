"""Eight numbers side by side: the same results as NumPy's, in every lane, whatever stands beside."""

from __future__ import annotations

import numpy as np
import pytest

from tests.solvers.lanes_probe_loops import angles, arithmetic, table


def test_every_operation_is_that_of_numpy():
    rng = np.random.default_rng(0)
    for _ in range(20):
        x, y = rng.normal(size=(2, 1, 8)) * 3
        x[0, 3] = y[0, 3]
        out = np.zeros((7, 8))
        bits, equal = arithmetic(x, y, out)
        a, b = x[0], y[0]
        assert [bool(bits >> i & 1) for i in range(8)] == list(a > b)
        assert equal
        wanted = [
            a + b * 2 - 1 / b,
            np.sqrt(np.abs(a)) / b,
            np.where((a > b) & ~(a < 0) | (b >= 3), a, -b),
            ((0.5 + a) * b - 1) / 2,
            np.where(np.arange(8) == 5, 9.5, 3.0),
        ]
        assert np.allclose(out[:5], wanted, rtol=1e-15, atol=1e-15)
        assert out[5, 0] == 7.5
        assert (out[6] == a).all()


def test_angles_are_those_of_the_standard_library():
    rng = np.random.default_rng(1)
    seams = np.outer([-1, 1], np.array([0, 1, 3, 4]) * np.pi / 4).reshape(-1, 1)
    near = seams + np.array([0.0, 1e-17, -1e-17, 3e-16, -3e-16, 1e-9, -1e-9, 1e-5])
    theta = np.concatenate([rng.uniform(-np.pi, np.pi, 8000), near.ravel()])
    theta = np.resize(theta, (len(theta) // 8, 8))
    size = np.exp(rng.normal(size=theta.shape))
    cosines, sines, out = size * np.cos(theta), size * np.sin(theta), np.empty((1, 8))
    for c, s in zip(cosines, sines, strict=True):
        angles(c[None], s[None], out)
        wanted = np.arctan2(s, c)
        wanted = np.where(wanted == -np.pi, np.pi, wanted)
        assert (np.abs(out[0] - wanted) <= 2 * np.spacing(np.abs(wanted))).all()


@pytest.mark.parametrize(("cosine", "sine", "angle"), [
    (1.0, 0.0, 0.0), (0.0, 1.0, np.pi / 2), (-1.0, 0.0, np.pi), (-1.0, -0.0, np.pi), (0.0, -1.0, -np.pi / 2),
    (0.0, 0.0, 0.0), (-1.0, -1e-30, np.pi),
])  # fmt: skip
def test_angles_lie_in_the_half_open_circle(cosine, sine, angle):
    out = np.empty((1, 8))
    angles(np.full((1, 8), cosine), np.full((1, 8), sine), out)
    assert (out == angle).all()


def test_a_lane_does_not_depend_on_its_neighbours():
    rng = np.random.default_rng(2)
    x, y = rng.normal(size=(2, 1, 8))
    out, again = np.zeros((7, 8)), np.zeros((7, 8))
    arithmetic(x, y, out)
    x[0, 1:], y[0, 1:] = np.nan, 0.0
    arithmetic(x, y, again)
    assert (out[:4, 0] == again[:4, 0]).all()


def test_lanes_look_up_a_table_each_for_itself():
    x, numbers, out = (
        np.array([[0.0, 1.2, -1.2, 6.999, 3.0, -0.5, 2.5, -6.0]]),
        np.arange(7.0) ** 2 + 0.5,
        np.empty((2, 8)),
    )
    table(x, numbers, out)
    assert out[0].tolist() == np.floor(x[0]).tolist()
    assert out[1].tolist() == numbers[np.abs(x[0]).astype(int)].tolist()
