"""Reductions that suffice, held against trying them all."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mafsil as mf
from mafsil import one_joint as oj
from mafsil.errors import InputError


def tried(motor, torque, speed, acceleration, efficiency, ratios):
    """Whether each ratio suffices, by the definition."""
    a = torque * np.where(torque * speed >= 0, 1 / efficiency, efficiency)
    m = a / ratios[:, None] + motor.inertia * ratios[:, None] * acceleration
    peak = np.abs(m).max(axis=1) <= motor.peak_torque
    heat = np.sqrt((m**2).mean(axis=1)) <= motor.continuous_torque
    return peak & heat & (ratios * np.abs(speed).max() <= motor.speed)


@pytest.mark.capability("02-5")
@given(st.integers(0, 2**32 - 1))
def test_exactly_the_ratios_of_the_interval_suffice(seed):
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 1, 40)
    scale = np.exp(rng.normal(0, 1, 4))
    speed = 3 * scale[0] * np.sin(2 * np.pi * t)
    acceleration = 6 * np.pi * scale[0] * np.cos(2 * np.pi * t)
    torque = scale[1] * acceleration + 20 * scale[2] * rng.normal(size=40).cumsum() / 6
    motor = oj.drives.MotorRating.of(2.0 * scale[3], 0.8 * scale[3], 400, 2e-4)
    found = oj.size_drive(motor, torque, speed, acceleration, efficiency=0.8)
    ratios = np.geomspace(0.1, 1e4, 4001)
    good = tried(motor, torque, speed, acceleration, 0.8, ratios)
    clear = (np.abs(ratios / found.least - 1) > 1e-9) & (np.abs(ratios / max(found.most, 1e-300) - 1) > 1e-9)
    expected = (ratios >= found.least) & (ratios <= found.most)
    assert (good == expected)[clear].all()
    assert bool(found) == (found.least <= found.most)
    if found:
        assert max(found.peak, found.heat, found.speed) <= 1 + 1e-9
        m = torque * np.where(torque * speed >= 0, 1.25, 0.8) / found.ratio + 2e-4 * found.ratio * acceleration
        assert found.heat == pytest.approx(np.sqrt((m**2).mean()) / motor.continuous_torque, rel=1e-12)
        for other in np.linspace(found.least, found.most, 7):
            heat = oj.size_drive(motor, torque, speed, acceleration, efficiency=0.8)
            m = torque * np.where(torque * speed >= 0, 1.25, 0.8) / other + 2e-4 * other * acceleration
            assert np.sqrt((m**2).mean()) >= heat.heat * motor.continuous_torque * (1 - 1e-12)


@pytest.mark.capability("02-5")
def test_each_reason_for_a_no():
    t = np.linspace(0, 1, 50)
    torque, speed = 50 * np.ones(50), 10 * np.sin(np.pi * t)
    slow = oj.size_drive(oj.drives.MotorRating.of(1.0, 1.0, 100), torque, speed)
    assert slow.status is oj.drives.drive_sizing.SizingStatus.TOO_FAST
    assert slow.least == pytest.approx(50)
    assert slow.most == pytest.approx(10, rel=1e-2)
    assert "50" in slow.explain("en")
    hot = oj.size_drive(oj.drives.MotorRating.of(100, 1e-2, 1e6, 1e-3), torque, speed, 100 * np.cos(np.pi * t))
    assert hot.status is oj.drives.drive_sizing.SizingStatus.OVERHEATS
    assert hot.heat > 1
    weak = oj.size_drive(oj.drives.MotorRating.of(0.1, 1e3, 1e6, 1e-2), torque, speed, 100 * np.ones(50))
    assert weak.status is oj.drives.drive_sizing.SizingStatus.TOO_WEAK
    assert weak.peak > 1
    assert weak.explain("ar") != weak.explain("en")


@pytest.mark.capability("02-5")
def test_a_batch_of_joints_of_an_arm_and_uneven_samples():
    robot = mf.load("puma560")
    move = mf.trajectory.quintic(np.zeros(6), [1.0, -0.5, 0.8, 0.4, -0.6, 1.2], 1.0)
    t = np.linspace(0, 1, 200) ** 1.5
    u, v, a = move.at(t)
    torque = robot.inverse_dynamics(u, v, a)
    motor = oj.drives.MotorRating.of(3.0, 1.0, 500, 1e-4)
    found = oj.size_drive(motor, torque.T, v.T, a.T, t=t, efficiency=0.85)
    assert found.ratio.shape == (6,)
    for k, one in enumerate(found):
        alone = oj.size_drive(motor, torque[:, k], v[:, k], a[:, k], t=t, efficiency=0.85)
        assert one.ratio == pytest.approx(float(alone.ratio))
        m = (
            torque[:, k] * np.where(torque[:, k] * v[:, k] >= 0, 1 / 0.85, 0.85) / one.ratio
            + 1e-4 * one.ratio * a[:, k]
        )
        assert one.heat == pytest.approx(np.sqrt(np.trapezoid(m**2, t)), rel=1e-9)


def test_what_cannot_be_sized_is_refused():
    motor = oj.drives.MotorRating.of(1.0, 1.0, 100)
    with pytest.raises(InputError, match="nothing to size"):
        oj.size_drive(motor, np.zeros(5), np.zeros(5))
    with pytest.raises(InputError, match="increasing"):
        oj.size_drive(motor, np.ones(3), np.ones(3), t=[0, 0, 1])
    with pytest.raises(InputError, match="torque"):
        oj.size_drive(motor, [np.nan, 1.0], [1.0, 1.0])
    with pytest.raises(InputError, match="peak_torque"):
        oj.drives.MotorRating.of(-1.0, 1.0, 100)
    still = oj.size_drive(motor, np.ones(4), np.zeros(4))
    assert still
    assert np.isinf(still.most)
    assert np.isfinite(still.ratio)
