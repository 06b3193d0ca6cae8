"""Kernels without delay: exact on polynomials, flat up to the band, and the band found in noise."""

import numpy as np
import pytest

from mafsil.identification import MotionLog
from mafsil.identification.smoothing import (
    FLATNESS,
    band_of,
    filter_samples,
    half_window,
    kernels,
    response,
    smooth_motions,
)


@pytest.mark.parametrize("half", [4, 5, 20, 301])
def test_polynomials_up_to_the_fifth_degree_pass_unchanged(half):
    period, rng = 0.01, np.random.default_rng(half)
    polynomial = np.polynomial.Polynomial(rng.normal(size=6), domain=[0, 4 * half * period])
    t = np.arange(4 * half) * period
    inner = t[half:-half]
    for order, weights in enumerate(kernels(half, period)):
        true = polynomial.deriv(order)(inner) if order else polynomial(inner)
        got = filter_samples(polynomial(t)[:, None], weights)[:, 0]
        assert np.abs(got - true).max() < 1e-9 * max(1.0, np.abs(true).max())


@pytest.mark.parametrize(("band", "period"), [(0.5, 1e-3), (2.0, 1e-3), (1.5, 0.01), (0.7, 0.02)])
def test_the_widest_flat_window(band, period):
    half = half_window(band, period, 100_000)
    for frequency in np.linspace(0.05, 1.0, 20) * band:
        assert np.abs(response(kernels(half, period), period, frequency) - 1).max() <= FLATNESS
    assert np.abs(response(kernels(half + 1, period), period, band) - 1).max() > FLATNESS
    assert np.abs(response(kernels(half, period), period, 30 * band)[:2]).max() < 0.01 or 30 * band > 0.5 / period


@pytest.mark.parametrize("noise", [0.0, 1e-5, 1e-4])
def test_the_band_of_a_motion_is_found(noise):
    t = np.arange(0, 20, 1e-3)
    q = np.sin(2 * np.pi * 0.3 * t) + 0.2 * np.sin(2 * np.pi * 1.7 * t + 1)
    q = (q + noise * np.random.default_rng(0).normal(size=q.shape))[:, None]
    band = band_of(MotionLog(t=t, q=q, tau=q))
    assert 1.6 < band < 2.2


def test_derivatives_of_a_noisy_motion():
    t = np.arange(0, 20, 1e-3)
    w = 2 * np.pi
    q = np.sin(w * t)[:, None]
    noisy = np.round(q * 2**15) / 2**15
    (motion,) = smooth_motions(MotionLog(t=t, q=noisy, tau=q), 1.0)
    inner = (len(t) - len(motion.q)) // 2
    true = t[inner : len(t) - inner, None]
    assert np.abs(motion.qd - w * np.cos(w * true)).max() < 1e-3 * w
    assert np.abs(motion.qdd + w**2 * np.sin(w * true)).max() < 2e-3 * w**2
    assert np.array_equal(motion.tau, q[inner : len(t) - inner])
