"""Torque loops against small steps, and joints of variable stiffness against their own energy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mafsil import one_joint as oj
from mafsil.errors import InputError

JOINT = oj.drives.VariableStiffness.of(spring=2e5, radius=0.03, motor_radius=0.02, longest=0.02)


@pytest.mark.capability("10-90")
@given(st.floats(-1.0, 1.0), st.floats(-1.5, 1.5), st.floats(0.5, 20.0))
def test_torque_and_stiffness_are_chosen_each_for_itself(q, torque, stiffness):
    found = JOINT.command(q, torque, stiffness)
    assert bool(found) == bool(found.softest <= stiffness <= found.stiffest)
    if not found:
        assert np.isnan(found.first)
        assert np.isnan(found.second)
        return
    motors = (found.first, found.second)
    assert JOINT.torque(q, *motors) == pytest.approx(torque, abs=1e-9)
    assert JOINT.stiffness(q, *motors) == pytest.approx(stiffness, rel=1e-9)
    # The torque is the slope of the energy, the stiffness that of the torque: away from slack springs.
    h = 1e-6
    if min(JOINT.extensions(q, *motors)) > 1e-5:
        turned = np.array([q - h, q + h])
        energy, pull = JOINT.energy(turned, *motors), JOINT.torque(turned, *motors)
        assert (energy[0] - energy[1]) / (2 * h) == pytest.approx(torque, abs=1e-6)
        assert (pull[0] - pull[1]) / (2 * h) == pytest.approx(stiffness, rel=1e-6)


@pytest.mark.capability("10-90")
def test_bounds_are_named_and_sharp():
    found = JOINT.command(0.0, 0.4, [1.0, 8.0, 1000.0])
    assert [each.name for each in found.status] == ["SLACK", "REACHED", "OVERSTRETCHED"]
    for bound, inside in ((found.softest[0], 1 + 1e-9), (found.stiffest[0], 1 - 1e-9)):
        assert JOINT.command(0.0, 0.4, bound * inside)
        assert not JOINT.command(0.0, 0.4, bound / inside**2)
    too_much = JOINT.command(0.0, 1e3, 8.0)
    assert not too_much
    assert np.isnan(too_much.stiffest)
    assert f"{found.softest[0]:.4g}" in next(iter(found)).explain("en")
    assert found.explain("ar") != found.explain("en")
    with pytest.raises(InputError, match="stiffness"):
        JOINT.command(0.0, 0.0, 0.0)


@pytest.mark.capability("10-90")
def test_a_spring_of_software_is_one_at_low_frequencies_only():
    w = np.array([0.01, 200.0, 2e4])
    k = oj.drives.software_stiffness(100.0, 200.0, w)
    assert k[0].real == pytest.approx(100.0, rel=1e-6)
    assert k[1].real == pytest.approx(50.0)
    assert k[2].real < 0.02
    # One period of a displacement sin(wt): the work that the spring does on the outside is not negative.
    t = np.linspace(0, 2 * np.pi / 50.0, 20001)
    one = oj.drives.software_stiffness(100.0, 200.0, 50.0, delay=1e-3)
    force = -(one * np.exp(1j * 50.0 * t)).imag
    speed = 50.0 * np.cos(50.0 * t)
    work = np.trapezoid(force * speed, t)
    assert work == pytest.approx(-np.pi * one.imag, rel=1e-6)
    assert work > 0


def rest_torque(loop, wanted, seconds, h=2e-5):
    """Of the held joint from zero, with dry friction, by small steps."""
    B, k, b, f = (float(x) for x in (loop.motor_inertia, loop.stiffness, loop.viscous, loop.dry))
    p = v = summed = 0.0
    for _ in range(int(seconds / h)):
        e = wanted - k * p
        summed += e * h
        drive = wanted + float(loop.kp) * e + float(loop.ki) * summed - b * v - k * p
        if v == 0.0 and abs(drive) <= f:
            continue
        sense = np.sign(v) if v else np.sign(drive)
        after = v + h / B * (drive - f * sense)
        v = 0.0 if v * after < 0 else after
        p += h * v
    return k * p


@pytest.mark.capability("10-62")
def test_friction_takes_of_the_current_and_the_gauge_gives_back():
    alone = oj.drives.TorqueLoop.of(0.5, 2e4, 150.0, 3.0)
    stiffer = oj.drives.TorqueLoop.of(0.5, 2e4, 150.0, 3.0, kp=4.0)
    whole = oj.drives.TorqueLoop.of(0.5, 2e4, 150.0, 3.0, kp=4.0, ki=100.0)
    direct = oj.drives.TorqueLoop.of(0.05, 1e5, 50.0, 0.0)
    lacking = [20.0 - rest_torque(loop, 20.0, 0.4) for loop in (alone, stiffer, whole)]
    assert abs(lacking[0]) <= float(alone.steady_error) + 1e-6
    assert abs(lacking[0]) > 0.5
    assert abs(lacking[1]) <= float(stiffer.steady_error) + 1e-6
    assert abs(lacking[2]) < 0.1
    assert alone.steady_error == 3.0
    assert stiffer.steady_error == pytest.approx(0.6)
    assert whole.steady_error == direct.steady_error == 0.0


@pytest.mark.capability("10-62")
@given(st.floats(0.1, 5.0), st.floats(10, 1e5), st.floats(0.1, 500), st.floats(0, 20), st.floats(0.01, 3.0))
def test_stability_is_that_of_the_roots(B, k, b, kp, share):
    limit = float(oj.drives.TorqueLoop.of(B, k, b, kp=kp).largest_ki)
    if abs(share - 1.0) < 1e-3:
        return
    loop = oj.drives.TorqueLoop.of(B, k, b, kp=kp, ki=share * limit)
    assert bool(loop.stable) == bool((loop.dynamics.roots.real < 0).all())
    assert loop.response(1e-6) == pytest.approx(1.0, abs=1e-4)
    assert abs(loop.response(1e9)) < 1e-3


@pytest.mark.capability("10-62")
def test_response_of_the_torque_loop_by_complex_amplitudes():
    """B p'' + b p' = tau_d + Kp e + Ki int e - k p, e = tau_d - k p."""
    w = np.array([2.0, 90.0, 700.0])
    s, (B, k, b, P, ki) = 1j * w, (0.5, 2e4, 150.0, 4.0, 100.0)
    p = (1 + P + ki / s) / (B * s**2 + b * s + k * (1 + P + ki / s))
    np.testing.assert_allclose(oj.drives.TorqueLoop.of(B, k, b, kp=P, ki=ki).response(w), k * p, rtol=1e-12)


@pytest.mark.capability("10-90")
def test_a_late_spring_of_software_by_its_lag_and_delay():
    one = complex(oj.drives.software_stiffness(100.0, 200.0, 50.0, delay=4e-3))
    assert abs(one) == pytest.approx(100.0 / np.hypot(1.0, 0.25))
    assert np.angle(one) == pytest.approx(-50.0 * 4e-3 - np.arctan(0.25))
