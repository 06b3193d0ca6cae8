"""Adaptive integration against known solutions: tolerance, order, dense output, events, breaks, honest endings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mafsil.errors import InputError
from mafsil.solvers import (
    PAIRS,
    Budget,
    Event,
    Tableau,
    Tolerance,
    first_order,
    integrate,
    integrate_adaptively,
    pair,
)
from mafsil.solvers.embedded import density, nodes, trees, violation
from mafsil.solvers.solution import IntegrationStatus


def oscillator(t, y):
    return np.stack([y[..., 1], -y[..., 0]], axis=-1)


def kepler(t, y):
    r = (y[0] ** 2 + y[1] ** 2) ** 1.5
    return np.array([y[2], y[3], -y[0] / r, -y[1] / r])


def solve(name, field, y, end, tolerance=1e-9, **options):
    return integrate_adaptively(
        pair(name), field, np.asarray(y, dtype=float), (0.0, end), tolerance=Tolerance(tolerance, tolerance), **options
    )


def test_numbers_of_rooted_trees():
    assert [len(trees(k)) for k in range(1, 9)] == [1, 1, 2, 4, 9, 20, 48, 115]
    assert all(nodes(tree) == 5 for tree in trees(5))
    assert sorted(density(tree) for tree in trees(4)) == [4, 8, 12, 24]


@pytest.mark.parametrize("name", PAIRS)
def test_a_wrong_digit_of_a_pair_is_refused(name):
    good = pair(name)
    for i, j in np.argwhere(good.a)[::7]:
        wrong = good.a.copy()
        wrong[i, j] += 1e-9
        with pytest.raises(InputError):
            replace(good, a=wrong)
    for k in range(len(good.dense)):
        wrong = good.dense.copy()
        wrong[k, 1] += 1e-7
        with pytest.raises(InputError):
            replace(good, dense=wrong)
    with pytest.raises(InputError):
        replace(good, order=good.order + 1)
    with pytest.raises(InputError):
        replace(good, error=good.error + 1e-6)


@pytest.mark.parametrize("name", PAIRS)
def test_error_estimates_and_polynomials_have_their_orders(name):
    good = pair(name)
    matrix = good.a[: good.steps, : good.steps]
    full = np.append(good.b, 0.0)
    for row in good.error:
        lower = full - row
        assert violation(matrix, lower, 2)[0] < 1e-13
        assert violation(matrix, lower, good.order)[0] > 1e-6


@pytest.mark.row("R10")
@pytest.mark.parametrize(("name", "steps"), [("bs23", (320, 640)), ("dp45", (160, 320)), ("dop853", (8, 16))])
def test_measured_order_of_a_pair(name, steps):
    """Kepler's ellipse, and for the order 8, whose errors drown in rounding there, y' = y cos t."""
    good = pair(name)
    last = good.steps - 1
    rows = tuple(tuple(map(float, good.a[i, :i])) for i in range(last))
    fixed = Tableau(good.name, rows, tuple(map(float, good.b)), tuple(map(float, good.c[:last])), good.order)
    if name == "dop853":
        field, start, end, wanted = (lambda t, y: y * np.cos(t)), np.ones(1), 2.0, np.exp([np.sin(2.0)])
    else:
        e, end = 0.3, 3.0
        field, start = kepler, np.array([1.0 - e, 0.0, 0.0, np.sqrt((1.0 + e) / (1.0 - e))])
        anomaly = end
        for _ in range(50):
            anomaly -= (anomaly - e * np.sin(anomaly) - end) / (1.0 - e * np.cos(anomaly))
        wanted = np.array([np.cos(anomaly) - e, np.sqrt(1.0 - e * e) * np.sin(anomaly)])
    errors = []
    for count in steps:
        (found,) = integrate(first_order(fixed, field), (start,), end / count, count).value
        errors.append(np.linalg.norm(found[-1, : len(wanted)] - wanted))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(good.order, abs=0.1)


@pytest.mark.capability("09-66")
@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-7])
def test_tolerance_is_kept_also_between_the_steps(name, tolerance):
    found = solve(name, oscillator, [[1.0, 0.0], [0.0, 1.0]], 10.0, tolerance)
    assert found.status is IntegrationStatus.COMPLETED
    t = np.linspace(0.0, 10.0, 997)
    y = found.value.at(t)
    assert y.shape == (997, 2, 2)
    np.testing.assert_allclose(y[:, 0, 0], np.cos(t), atol=60 * tolerance)
    np.testing.assert_allclose(y[:, 1, 0], np.sin(t), atol=60 * tolerance)
    np.testing.assert_allclose(found.value.rate_at(t)[:, 0, 1], -np.cos(t), atol=1e3 * tolerance)
    np.testing.assert_allclose(found.value.at(found.value.t), found.value.y, atol=1e-14)


def test_a_batch_row_does_not_fail_for_its_shape_and_zero_rates_are_fine():
    found = solve("dp45", lambda t, y: 0.0 * y, np.zeros((3, 2, 4)), 5.0)
    assert found.succeeded
    assert found.value.y.shape[1:] == (3, 2, 4)
    with pytest.raises(InputError, match="t: 6"):
        found.value.at(6.0)


def test_breaks_are_met_exactly():
    """A force that jumps at 1/3: with a break the end is exact to the tolerance, and a step ends there."""

    def pushed(t, y):
        return np.array([y[1], 0.0 if t < 1 / 3 else 6.0])

    found = solve("dop853", pushed, [0.0, 0.0], 1.0, 1e-12, breaks=[1 / 3])
    assert 1 / 3 in found.value.t
    assert found.value.y[-1, 0] == pytest.approx(3.0 * (2 / 3) ** 2, abs=1e-4)


@pytest.mark.parametrize("name", PAIRS)
def test_events_are_found_at_their_place_and_direction(name):
    events = [Event(lambda t, y: y[0], direction) for direction in (0, 1, -1)]
    found = solve(name, oscillator, [1.0, 0.0], 10.0, 1e-7, events=events)
    places = {k: [c.t for c in found.value.crossings if c.event == k] for k in range(3)}
    every = np.pi * (np.arange(3) + 0.5)
    np.testing.assert_allclose(places[0], every, atol=1e-5)
    np.testing.assert_allclose(places[1], every[1::2], atol=1e-5)
    np.testing.assert_allclose(places[2], every[::2], atol=1e-5)
    assert [c.t for c in found.value.crossings] == sorted(c.t for c in found.value.crossings)


def test_several_events_in_one_step_and_a_terminal_one_cuts():
    events = [Event(lambda t, y, s=s: t - s) for s in (0.30, 0.31, 0.32)]
    events.append(Event(lambda t, y: t - 0.315, terminal=True))
    found = solve("dop853", lambda t, y: np.ones(1), [0.0], 1.0, events=events)
    assert [c.event for c in found.value.crossings] == [0, 1, 3]
    assert found.status is IntegrationStatus.EVENT
    assert found.succeeded
    assert found.value.t[-1] == pytest.approx(0.315, abs=1e-12)
    assert found.value.at(0.3)[0] == pytest.approx(0.3, abs=1e-12)


def test_an_event_at_the_start_does_not_count_and_one_that_only_touches_neither():
    found = solve("dp45", lambda t, y: np.ones(1), [0.0], 1.0, events=[Event(lambda t, y: y[0], terminal=True)])
    assert found.status is IntegrationStatus.COMPLETED
    found = solve("dp45", lambda t, y: np.ones(1), [-0.5], 1.0, events=[Event(lambda t, y: y[0] ** 2)])
    assert not found.value.crossings


def test_events_of_a_batch_name_their_row():
    found = solve("dp45", oscillator, [[1.0, 0.0], [0.0, 1.0]], 2.0, events=[Event(lambda t, y: y[:, 0])])
    assert [c.batch for c in found.value.crossings] == [(0,)]
    with pytest.raises(InputError, match="floor"):
        solve("dp45", oscillator, np.eye(2), 2.0, events=[Event(lambda t, y: y[0, 0], name="floor")])


def test_a_bouncing_ball_bounces_and_its_chattering_ends():
    def reset(t, y):
        return np.array([0.0, -0.8 * y[1]])

    floor = Event(lambda t, y: y[0], -1, reset=reset)
    found = solve("dp45", lambda t, y: np.array([y[1], -9.81]), [1.0, 0.0], 6.0, events=[floor])
    fall = np.sqrt(2 / 9.81)
    bounces = fall * (1.0 + 2.0 * np.cumsum(0.8 ** np.arange(1, 6)))
    np.testing.assert_allclose([c.t for c in found.value.crossings[:6]], [fall, *bounces], rtol=1e-9)
    assert found.status is IntegrationStatus.CHATTERING
    assert found.value.t[-1] == pytest.approx(fall * 9.0, rel=1e-5)
    assert found.value.y[:, 0].min() > -1e-9
    assert "without end" in found.explain("en")
    assert found.explain("ar") != found.explain("en")


@pytest.mark.parametrize(
    ("field", "status"),
    [
        (lambda t, y: y**2, IntegrationStatus.BLOWN_UP),
        (lambda t, y: np.where(t < 0.5, 1.0, np.nan) + 0 * y, IntegrationStatus.BLOWN_UP),
    ],
)
def test_a_blow_up_keeps_the_last_good_state(field, status):
    with np.errstate(over="ignore", invalid="ignore"):
        found = solve("dop853", field, [1.0], 3.0)
    assert found.status is status
    assert not found.succeeded
    assert np.isfinite(found.value.y).all()
    assert 0.45 < found.value.t[-1] <= 1.0 + 1e-6
    assert found.explain("ar") != found.explain("en")


def test_budgets_end_an_integration_where_it_is():
    few = solve("bs23", oscillator, [1.0, 0.0], 100.0, 1e-9, budget=Budget(steps=50))
    assert few.status is IntegrationStatus.BUDGET_SPENT
    short = solve("bs23", oscillator, [1.0, 0.0], 1e5, 1e-9, budget=Budget(seconds=0.05))
    assert short.status is IntegrationStatus.TIME_SPENT
    for found in (few, short):
        t = found.value.t[-1]
        assert found.value.y[-1, 0] == pytest.approx(np.cos(t), abs=1e-5)
        assert found.explain("en") != found.explain("ar")


def test_wrong_events_and_methods_are_named():
    with pytest.raises(InputError, match="dop853"):
        pair("rk45")
    with pytest.raises(InputError, match="direction"):
        Event(lambda t, y: 0.0, direction=2)
    with pytest.raises(InputError, match="function"):
        Event(3)  # type: ignore[arg-type]
