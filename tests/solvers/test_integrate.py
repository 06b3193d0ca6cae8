"""Methods are data that check themselves; measured orders equal the stated; a blow-up keeps the last good state."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mafsil.errors import InputError
from mafsil.solvers import METHODS, Splitting, Tableau, first_order, integrate, method, second_order
from mafsil.solvers.outcome import SolverStatus

TABLEAUS = [m for m in METHODS.values() if isinstance(m, Tableau)]


def slope(errors):
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


@pytest.mark.capability("09-60", "09-66")
@pytest.mark.parametrize("tableau", TABLEAUS, ids=lambda m: m.name)
def test_measured_order_of_first_order_systems(tableau):
    """y' = -y + t depends on time and state; its solution is t - 1 + 2 exp(-t)."""
    errors = []
    for steps in (64, 128, 256):
        (y,) = integrate(first_order(tableau, lambda t, y: t - y), (np.array([1.0]),), 2 / steps, steps).value
        errors.append(abs(y[-1, 0] - (1.0 + 2 * np.exp(-2.0))))
    np.testing.assert_allclose(slope(errors), tableau.order, atol=0.1)


@pytest.mark.capability("09-61")
@pytest.mark.parametrize("name", METHODS)
def test_measured_order_of_damped_oscillator(name):
    """q'' = -q - 0.4 q': the force depends on the velocity, as an arm's does."""
    wd = np.sqrt(1 - 0.04)
    exact = np.exp(-0.2 * 3.0) * (np.cos(wd * 3.0) + 0.2 / wd * np.sin(wd * 3.0))
    errors = []
    for steps in (128, 256, 512):
        step = second_order(method(name), lambda t, q, v: -q - 0.4 * v)
        q, _ = integrate(step, (np.ones((2, 1)), np.zeros((2, 1))), 3 / steps, steps).value
        assert q.shape == (steps + 1, 2, 1)
        errors.append(abs(q[-1, 0, 0] - exact))
    np.testing.assert_allclose(slope(errors), method(name).order, atol=0.1)


def test_semi_implicit_euler_keeps_energy_bounded():
    step = second_order(method("semi_implicit_euler"), lambda t, q, v: -q)
    q, v = integrate(step, (np.ones(1), np.zeros(1)), 0.05, 20000).value
    energy = (q**2 + v**2)[:, 0] / 2
    assert np.abs(energy - 0.5).max() < 0.05 / 2
    explicit = second_order(method("euler"), lambda t, q, v: -q)
    q, v = integrate(explicit, (np.ones(1), np.zeros(1)), 0.05, 20000).value
    assert (q[-1] ** 2 + v[-1] ** 2)[0] > 1e10


def test_blow_up_keeps_the_last_finite_state():
    step = first_order(method("euler"), lambda t, y: y**2 * 1e200)
    with np.errstate(over="ignore"):
        outcome = integrate(step, (np.array([1.0, 0.0]),), 1.0, 50)
    assert outcome.status is SolverStatus.NOT_FINITE
    assert len(outcome.value[0]) == outcome.iterations + 1 < 51
    assert np.isfinite(outcome.value[0]).all()
    assert "not finite" in outcome.explain("en")
    assert outcome.explain("ar")


@pytest.mark.parametrize("digit", range(4))
def test_a_wrong_digit_is_refused(digit):
    rk4 = METHODS["rk4"]
    weights = list(rk4.b)
    weights[digit] += 1e-9
    with pytest.raises(InputError, match="classical Runge-Kutta"):
        replace(rk4, b=tuple(weights))
    with pytest.raises(InputError, match="a 1 = c"):
        replace(rk4, c=(0.0, 0.5, 0.5, 0.9))


def test_a_wrong_order_is_refused():
    with pytest.raises(InputError, match=r"b c\^2"):
        replace(METHODS["heun"], order=3)
    with pytest.raises(InputError, match="drifts"):
        Splitting("broken", (1.0,), (0.5,), 1)


def test_unknown_method_lists_the_known():
    with pytest.raises(InputError, match="rk4"):
        method("rk5")
