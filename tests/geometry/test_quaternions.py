"""Unit quaternions, SU(2), Rodrigues parameters, and any representation to any other."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.errors import InputError
from mafsil.geometry import quaternion, rotation
from mafsil.geometry.representations import REPRESENTATIONS, convert
from mafsil.messages import say

EPS = 2.0**-52
AXIS = np.array([1.0, 2.0, 2.0]) / 3
seeds = st.integers(0, 2**32 - 1)
batches = st.sampled_from([(), (1,), (3, 1, 2)])


def unit(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    return quaternion.normalise_quaternion(rng.standard_normal((*shape, 4)))


@settings(max_examples=60, deadline=None)
@given(seeds, batches)
@pytest.mark.capability("04-72", "04-74", "04-75", "04-76")
def test_products_and_double_cover(seed: int, shape: tuple[int, ...]):
    rng = np.random.default_rng(seed)
    q, p = unit(rng, shape), unit(rng, shape)
    product = quaternion.multiply(q, p)
    assert np.abs(np.linalg.norm(product, axis=-1) - 1).max() <= 8 * EPS
    together = rotation.from_quaternion(q) @ rotation.from_quaternion(p)
    assert np.abs(rotation.from_quaternion(product) - together).max() <= 16 * EPS
    assert np.array_equal(rotation.from_quaternion(-q), rotation.from_quaternion(q))
    assert np.all(quaternion.same_rotation(q, -q))
    assert not np.any(quaternion.same_rotation(q, p))
    assert np.array_equal(quaternion.canonical(q), quaternion.canonical(-q))
    assert np.abs(quaternion.to_su2(product) - quaternion.to_su2(q) @ quaternion.to_su2(p)).max() <= 8 * EPS
    assert np.abs(quaternion.from_su2(quaternion.to_su2(q)) - q).max() <= EPS
    x = rng.standard_normal((*shape, 3))
    assert np.abs(quaternion.rotate(q, x) - rotation.apply(rotation.from_quaternion(q), x)).max() <= 64 * EPS
    back = quaternion.multiply(quaternion.conjugate(q), q)
    assert np.abs(back - [1, 0, 0, 0]).max() <= 4 * EPS


@settings(max_examples=60, deadline=None)
@given(seeds, batches)
@pytest.mark.capability("04-73")
def test_from_matrix_and_back(seed: int, shape: tuple[int, ...]):
    q = quaternion.canonical(unit(np.random.default_rng(seed), shape))
    assert np.abs(quaternion.to_quaternion(rotation.from_quaternion(q)) - q).max() <= 8 * EPS


@pytest.mark.capability("04-73", "04-75")
@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0, -0.6, 0.8), (-1, 2, 2)])
def test_half_turns_have_a_quaternion(axis: tuple[float, ...]):
    w = np.array(axis) / np.linalg.norm(axis)
    q = quaternion.to_quaternion(2 * np.outer(w, w) - np.eye(3))
    assert np.abs(np.outer(q[1:], q[1:]) - np.outer(w, w)).max() <= 4 * EPS
    assert q[0] == 0
    assert q[np.flatnonzero(q)[0]] > 0


@pytest.mark.capability("04-77", "04-65")
@pytest.mark.parametrize("theta", [1e-300, 1e-12, 1e-8, 1e-4, 1.0, pi - 1e-8, pi])
def test_no_sensitivity_at_small_angles(theta: float):
    q = quaternion.exp(AXIS * theta)
    assert np.abs(quaternion.log(q) - AXIS * theta).max() <= 4 * EPS * theta
    assert np.abs(rotation.log(rotation.from_quaternion(q)) - AXIS * theta).max() <= 8 * EPS * theta
    assert 2 * np.arctan2(np.linalg.norm(q[1:]), q[0]) == pytest.approx(theta, rel=4 * EPS, abs=1e-150)


def test_log_ignores_sign_and_slerp_takes_the_short_way():
    rng = np.random.default_rng(0)
    p, q = unit(rng, (500,)), unit(rng, (500,))
    assert np.abs(quaternion.log(-q) - quaternion.log(q)).max() <= EPS
    for t in (0.0, 0.3, 1.0):
        both = [rotation.from_quaternion(quaternion.slerp(p, s * q, t)) for s in (1, -1)]
        assert np.abs(both[0] - both[1]).max() <= 32 * EPS
        want = rotation.slerp(rotation.from_quaternion(p), rotation.from_quaternion(q), t)
        assert np.abs(both[0] - want).max() <= 1e-14


def test_lengths_are_never_repaired_unasked():
    with pytest.raises(InputError, match="differs from 1 by 1"):
        rotation.from_quaternion([2.0, 0, 0, 0])
    with pytest.raises(InputError, match="length zero"):
        rotation.normalise_quaternion(np.zeros(4))
    with pytest.raises(InputError, match=r"q\[1\]"):
        rotation.from_quaternion([[1.0, 0, 0, 0], [1.0, 1, 0, 0]])
    with pytest.raises(InputError, match="SU"):
        quaternion.from_su2(2 * np.eye(2))
    tiny, huge = (rotation.normalise_quaternion(np.array([1.0, -1, 1, 1]) * s) for s in (1e-300, 1e300))
    assert tiny.tolist() == huge.tolist() == [0.5, -0.5, 0.5, 0.5]
    # What lies within the tolerance is divided out: the result is a rotation to rounding.
    R = rotation.from_quaternion(np.array([1.0, 1e-7, 0, 0]) * (1 + 5e-7))
    assert rotation.is_rotation(R, 8 * EPS)


def test_gibbs_and_modified_rodrigues_parameters():
    q = quaternion.exp(AXIS * 2.0)
    assert quaternion.to_gibbs(q) == pytest.approx(AXIS * np.tan(1.0))
    assert quaternion.to_modified_rodrigues(-q) == pytest.approx(AXIS * np.tan(0.5))
    assert quaternion.from_gibbs(AXIS * np.tan(1.0)) == pytest.approx(q)
    assert quaternion.from_modified_rodrigues(AXIS * np.tan(0.5)) == pytest.approx(q)


@pytest.mark.capability("04-18", "04-77")
@pytest.mark.parametrize("source", REPRESENTATIONS)
@pytest.mark.parametrize("target", REPRESENTATIONS)
def test_any_to_any(source: str, target: str):
    R = rotation.random(np.random.default_rng(1), (3, 1, 2))
    start = REPRESENTATIONS[source].from_matrix(R)
    value = convert(start, source, target)
    assert np.shape(value) == (3, 1, 2, *REPRESENTATIONS[target].shape)
    assert np.abs(REPRESENTATIONS[target].to_matrix(value) - R).max() < 1e-13


@pytest.mark.capability("04-77")
def test_table_of_representations_speaks_both_languages():
    for entry in REPRESENTATIONS.values():
        size = 2 * np.prod(entry.shape) if entry.name == "su2" else np.prod(entry.shape)
        assert entry.parameters == size
        assert entry.note == say(f"geometry.representation_{entry.name}")
        assert entry.note != say(f"geometry.representation_{entry.name}", language="ar")
    with pytest.raises(InputError, match="quaternion, su2"):
        convert(np.eye(3), "matrix", "euler")
