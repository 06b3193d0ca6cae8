"""Backlash: the gap, hysteresis, and the first harmonic against Fourier's integral of the motion itself."""

import numpy as np
import pytest

from mafsil.errors import InputError
from mafsil.one_joint import Backlash
from mafsil.one_joint.drives import SpeedFriction


@pytest.mark.capability("02-10", "10-11")
def test_nothing_passes_within_the_gap():
    play = Backlash.of(0.01, 200.0)
    np.testing.assert_allclose(play.torque([-0.02, -0.005, 0.0, 0.004, 0.005, 0.015]), [-3, 0, 0, 0, 0, 2], atol=1e-12)
    assert Backlash.of([0.0, 0.01], 100.0).torque(0.01).tolist() == [1.0, 0.5]


@pytest.mark.capability("02-10", "10-11")
def test_the_link_stands_elsewhere_on_the_way_back():
    play = Backlash.of(0.2)
    out, back = np.linspace(0, 1, 101), np.linspace(1, 0, 101)
    y = play.link_position(np.concatenate([out, back]))
    np.testing.assert_allclose(y[:101], np.maximum(out - 0.1, 0.0), atol=1e-12)
    np.testing.assert_allclose(y[101:], np.minimum(back + 0.1, 0.9), atol=1e-12)
    # A small swing inside the gap does not move it, wherever it began.
    assert np.ptp(play.link_position(0.09 * np.sin(np.linspace(0, 20, 400)), start=0.0)) == 0.0
    # Once wound to one side, it follows from there.
    assert play.link_position([0.5], start=2.0)[0] == pytest.approx(0.6)


@pytest.mark.capability("02-10", "10-11")
@pytest.mark.parametrize("amplitude", [0.051, 0.06, 0.1, 0.5, 5.0])
def test_the_first_harmonic_is_that_of_the_motion(amplitude):
    play, t = Backlash.of(0.1), np.linspace(0, 4 * np.pi, 80_001)
    y = play.link_position(amplitude * np.sin(t))[40_000:-1]
    s = t[40_000:-1]
    harmonic = 2 * np.mean(y * (np.sin(s) + 1j * np.cos(s))) / amplitude
    assert play.describing_function(amplitude) == pytest.approx(harmonic, abs=2e-6)


def test_ends_of_the_describing_function():
    play = Backlash.of(0.1)
    assert play.describing_function(0.04) == 0.0
    assert play.describing_function(1e6) == pytest.approx(1.0, abs=1e-6)
    assert Backlash.of(0.0).describing_function(1.0) == 1.0


@pytest.mark.capability("02-10", "10-11")
def test_friction_is_a_term_that_can_be_left_out():
    assert SpeedFriction.of().torque(3.0) == 0.0
    assert SpeedFriction.of(viscous=2.0).torque(3.0) == pytest.approx(6.0)


@pytest.mark.parametrize("call", [lambda: Backlash.of(-1.0), lambda: Backlash.of(0.1, 0.0), lambda: Backlash.of(np.nan),
                                  lambda: Backlash.of(0.1).link_position(1.0),
                                  lambda: Backlash.of(0.1).describing_function(0.0),
                                  lambda: Backlash.of(0.1).torque("a")])  # fmt: skip
def test_wrong_input_is_refused(call):
    with pytest.raises(InputError):
        call()
