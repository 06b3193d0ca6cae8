"""Sensors against what their figures say of many readings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mafsil import one_joint as oj
from mafsil.errors import InputError

KINDS = {kind.name: kind for kind in oj.drives.SENSORS}


@pytest.mark.capability("10-6", "02-8", "02-9")
def test_every_sensor_of_the_book_reads():
    own = {"position", "velocity", "torque", "force", "acceleration"}
    assert {kind.measures for kind in oj.drives.SENSORS} == own | {"place", "distance", "pressure"}
    for kind in oj.drives.SENSORS:
        seen = kind.read(np.full((20, 2000), 0.7), 1e-3)
        assert seen.mean() == pytest.approx(0.7 + kind.bias, abs=3 * kind.noise / np.sqrt(seen.size) + kind.quantum / 2)
        assert seen.std() == pytest.approx(kind.noise, rel=0.05, abs=kind.quantum / 2)
        assert (seen == kind.read(np.full((20, 2000), 0.7), 1e-3)).all()
        assert kind.explain("ar") != kind.explain("en")
        if kind.quantum:
            assert np.abs(seen / kind.quantum - np.round(seen / kind.quantum)).max() < 1e-6


@pytest.mark.capability("10-6")
def test_bandwidth_is_that_of_a_first_order_lag():
    lag = replace(KINDS["tachometer"], noise=0.0, bias=0.0, bandwidth=50.0)
    t = 1e-3 * np.arange(200)
    seen = lag.read(np.where(t > 0, 1.0, 0.0), 1e-3)
    np.testing.assert_allclose(seen[1:], 1.0 - np.exp(-50.0 * (t[1:] - 1e-3)), atol=1e-12)


@pytest.mark.capability("10-6")
def test_differencing_makes_the_noise_that_is_stated():
    rng = np.random.default_rng(4)
    start = rng.uniform(0, 1, (4000, 1))
    for name in ("encoder", "resolver", "potentiometer"):
        kind = replace(KINDS[name], bandwidth=np.inf)
        # A motion through many quanta, of another share of one each time.
        true = start + np.array([0.0, 37.3]) * rng.uniform(1, 2, (4000, 1)) * max(kind.quantum, 1e-4)
        rate = np.diff(kind.read(true, 1e-3), axis=1) / 1e-3 - np.diff(true, axis=1) / 1e-3
        assert rate.std() == pytest.approx(float(kind.rate_noise(1e-3)), rel=0.06)
    with pytest.raises(InputError, match="period"):
        KINDS["encoder"].read([0.0], 0.0)
    with pytest.raises(InputError, match="truth"):
        KINDS["encoder"].read([np.nan], 1e-3)
