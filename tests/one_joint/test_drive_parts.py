"""Actuators, transmissions and brakes of a joint."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil import one_joint as oj
from mafsil.errors import InputError


@pytest.mark.capability("02-4", "02-5", "10-7")
def test_fast_actuators_need_a_reduction_before_a_joint():
    kinds = {kind.name: kind for kind in oj.drives.ACTUATORS}
    assert set(kinds) == {
        "dc_servo", "ac_servo", "stepper", "pneumatic_cylinder", "hydraulic_cylinder", "combustion_engine"
    }  # fmt: skip
    least, most = kinds["ac_servo"].reduction(joint_speed=np.pi)
    assert 30 < least < most < 250
    least, most = kinds["hydraulic_cylinder"].reduction(joint_speed=0.2)
    assert least < 1 < most
    for kind in oj.drives.ACTUATORS:
        assert kind.explain("ar") != kind.explain("en")
        assert kind.linear == kind.name.endswith("cylinder")
    assert not kinds["combustion_engine"].regulated
    with pytest.raises(InputError, match="joint_speed"):
        kinds["stepper"].reduction(0.0)


@pytest.mark.capability("02-6", "10-7")
def test_transmissions_are_judged_by_what_they_do_to_the_tip():
    kinds = {kind.name: kind for kind in oj.drives.TRANSMISSIONS}
    backlash, slip = (
        [kind.backlash for kind in oj.drives.TRANSMISSIONS],
        [kind.slip for kind in oj.drives.TRANSMISSIONS],
    )
    found = oj.drives.transmission_suits(backlash, reach=0.8, repeatability=1e-3, slip=slip)
    good = {name for name, answer in zip(kinds, found, strict=True) if answer}
    assert good == {"low_backlash_gear", "harmonic_drive", "ball_screw"}
    assert found.play == pytest.approx(0.8 * np.array(backlash))
    (belt,) = [one for name, one in zip(kinds, found, strict=True) if name == "friction_belt"]
    assert belt.status is oj.drives.drive_parts.TransmissionStatus.SLIPS
    assert f"{0.8 * kinds['friction_belt'].slip:.4g}" in belt.explain("en")
    chain = oj.drives.transmission_suits(kinds["chain"].backlash, 0.8, 1e-3)
    assert chain.status is oj.drives.drive_parts.TransmissionStatus.TOO_MUCH_PLAY
    assert oj.drives.transmission_suits(kinds["chain"].backlash, 0.8, 0.02)


def stopped(torque, inertia, speed, load, delay, step=1e-5):
    """Time and angle by small steps."""
    t, angle, w = 0.0, 0.0, speed
    while t < delay:
        w, angle, t = w + load / inertia * step, angle + w * step, t + step
    sense = np.sign(w)
    while w * sense > 0:
        w, angle, t = w + (load - torque * sense) / inertia * step, angle + w * step, t + step
    return t, angle


@pytest.mark.capability("02-7")
@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_a_brake_stops_as_small_steps_say(seed):
    rng = np.random.default_rng(seed)
    torque, inertia = rng.uniform(5, 20), rng.uniform(0.2, 1)
    speed, load, delay = rng.uniform(-3, 3), rng.uniform(-0.8, 0.8) * torque, rng.uniform(0, 0.03)
    found = oj.drives.brake(torque, inertia, speed, load, delay)
    time, angle = stopped(torque, inertia, speed, load, delay)
    assert found
    assert found.time == pytest.approx(time, abs=1e-3)
    assert found.angle == pytest.approx(angle, abs=2e-3)
    # What the brake takes up is what there was, and what the load gave.
    assert found.heat == pytest.approx(inertia * speed**2 / 2 + load * found.angle, rel=1e-9, abs=1e-9)


@pytest.mark.capability("02-7")
def test_a_brake_weaker_than_the_load_gives_way():
    found = oj.drives.brake([10, 10], 1.0, [0.0, 2.0], [11.0, 0.0])
    assert [one.status for one in found] == [
        oj.drives.drive_parts.BrakeStatus.GIVES_WAY,
        oj.drives.drive_parts.BrakeStatus.HOLDS,
    ]
    assert np.isinf(found.time[0])
    assert np.isinf(found.angle[0])
    assert found.time[1] == pytest.approx(0.2)
    assert np.isinf(found.margin[1])
    assert not found
    assert "0.909" in next(iter(found)).explain("en")
