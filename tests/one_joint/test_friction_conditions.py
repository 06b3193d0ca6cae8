"""Friction under load, after rest, warm, and before it slides."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil import one_joint as oj
from mafsil.errors import InputError

LAW = oj.drives.SpeedFriction.stribeck(static=0.9, kinetic=0.6, viscous=0.1, speed=0.05)
CONDITIONS = oj.drives.FrictionConditions.of(LAW, load_share=0.02, rest_time=2.0, thinning=0.03, stiffness=500.0)


@pytest.mark.capability("10-18")
def test_load_rest_and_temperature_move_what_they_should():
    same = CONDITIONS.at(rest=1e12)
    speeds = np.linspace(-2, 2, 41)
    np.testing.assert_allclose(same.torque(speeds), LAW.torque(speeds), atol=1e-10)
    loaded = CONDITIONS.at(load=[-10.0, 10.0])
    assert loaded.kinetic == pytest.approx([0.8, 0.8])
    # A joint that just stopped starts again with the kinetic torque; after a while it holds more.
    rests = np.array([0.0, 2.0, 1e9])
    held = CONDITIONS.at(rest=rests)
    assert held.static == pytest.approx([0.6, 0.75, 0.9])
    assert [bool(each) for each in held.holds(0.7)] == [False, True, True]
    warm = CONDITIONS.at(temperature=[20.0, 50.0])
    assert warm.torque(10.0)[0] - warm.torque(10.0)[1] == pytest.approx(1.0 * (1 - np.exp(-0.9)))
    assert warm.static[0] == warm.static[1]


@pytest.mark.capability("10-18")
def test_before_it_slides_friction_is_a_spring():
    # Dahl: dF/dx = k (1 - F / b), by small steps of fourth order.
    b, k, h, F = 0.6, 500.0, 1e-6, 0.0
    for _ in range(2000):
        s = [0.0] * 4
        for stage, part in enumerate((0.0, 0.5, 0.5, 1.0)):
            s[stage] = k * (1.0 - (F + part * h * s[stage - 1] * (stage > 0)) / b)
        F += h / 6.0 * (s[0] + 2 * s[1] + 2 * s[2] + s[3])
    assert CONDITIONS.presliding(2e-3) == pytest.approx(F, rel=1e-10)
    assert CONDITIONS.presliding([-1e-8, 0.0, 1e-8]) == pytest.approx([-5e-6, 0.0, 5e-6], rel=1e-4)
    assert CONDITIONS.presliding(CONDITIONS.breakaway()) == pytest.approx(b * (1 - np.exp(-4.0)))
    assert CONDITIONS.presliding(1.0, load=10.0) == pytest.approx(0.8)
    rigid = oj.drives.FrictionConditions.of(LAW)
    assert rigid.presliding([-1e-9, 0.0, 1e-9]) == pytest.approx([-0.6, 0.0, 0.6])


@pytest.mark.capability("10-18")
def test_a_load_lengthens_the_way_before_sliding():
    # Four times (kinetic + share |load|) over the stiffness.
    assert CONDITIONS.breakaway([0.0, -15.0]) == pytest.approx([4 * 0.6 / 500, 4 * 0.9 / 500])
    assert CONDITIONS.presliding(CONDITIONS.breakaway(15.0), load=15.0) == pytest.approx(0.9 * (1 - np.exp(-4.0)))


def test_nonsense_is_refused():
    for wrong in ({"load_share": -1.0}, {"stiffness": 0.0}, {"stiffness": np.nan}, {"rest_time": np.nan}):
        with pytest.raises(InputError):
            oj.drives.FrictionConditions.of(LAW, **wrong)
    for wrong in ({"rest": -1.0}, {"load": np.inf}, {"temperature": np.nan}):
        with pytest.raises(InputError):
            CONDITIONS.at(**wrong)
