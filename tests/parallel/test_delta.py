"""The Delta robot and the elimination of one unknown: laws on random input."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil import parallel as pa
from mafsil.errors import InputError


@pytest.mark.capability("08-11", "08-35")
@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10_000))
def test_there_and_back(seed):
    rng = np.random.default_rng(seed)
    robot = pa.DeltaRobot(0.4, 0.1, 0.5, 1.0)
    p = rng.uniform([-0.3, -0.3, -1.1], [0.3, 0.3, -0.6], size=(20, 3))
    both = robot.angles(p)
    for mode in (0, 1):
        q = both[..., mode]
        ends = robot.positions(q)
        assert np.nanmin(np.abs(ends - p[:, None]).max(axis=2), axis=1).max() < 1e-9
        gap = np.linalg.norm(ends[:, :, None] - robot.elbows(q)[:, None], axis=-1) - robot.forearm
        assert np.nanmax(np.abs(gap)) < 1e-10


@pytest.mark.capability("08-11", "08-37")
def test_rates_and_torques():
    rng = np.random.default_rng(0)
    robot, h = pa.DeltaRobot(0.4, 0.1, 0.5, 1.0), 1e-6
    q = rng.uniform(0, 0.8, size=(30, 3))
    p = robot.positions(q)[:, 0]
    J = robot.jacobian(q, p)
    for k in range(3):
        step = h * np.eye(3)[k]
        difference = (robot.positions(q + step)[:, 0] - robot.positions(q - step)[:, 0]) / (2 * h)
        np.testing.assert_allclose(J[..., k], difference, atol=1e-7)
    force = rng.normal(size=(30, 3))
    np.testing.assert_allclose(robot.torques(q, p, force), np.einsum("kij,ki->kj", J, force), atol=1e-10)
    assert robot.singularity(q, p)
    assert np.isnan(robot.angles([0, 0, -5.0])).all()
    with pytest.raises(InputError, match="arm"):
        pa.DeltaRobot(0.4, 0.1, -0.5, 1.0)


@pytest.mark.capability("08-24", "08-28")
@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000))
def test_resultant_is_the_product_of_differences(seed):
    rng = np.random.default_rng(seed)
    a, b = rng.normal(size=3), rng.normal(size=2)
    f, g = np.polynomial.polynomial.polyfromroots(a), np.polynomial.polynomial.polyfromroots(b)
    expected = np.prod(a[:, None] - b)
    assert abs(pa.resultant(f, g)) == pytest.approx(abs(expected), rel=1e-8, abs=1e-10)
    shared = np.polynomial.polynomial.polyfromroots([b[0], 3.0])
    assert abs(pa.resultant(f, f * 1.0)) < 1e-9
    assert abs(pa.resultant(shared, g)) < 1e-9
    x, c = rng.uniform(-3, 3), rng.normal(size=3)
    t = np.tan(x / 2)
    value = pa.half_angle_polynomial(*c) @ t ** np.arange(3)
    assert value == pytest.approx((1 + t * t) * (c[0] + c[1] * np.cos(x) + c[2] * np.sin(x)), rel=1e-9, abs=1e-9)
    coefficients = pa.eliminant(lambda t: np.polynomial.polynomial.polyval(t, f), 5)
    np.testing.assert_allclose(coefficients[:4], f, atol=1e-10)
    assert len(pa.trimmed(coefficients)) == 4
    with pytest.raises(InputError, match="degree"):
        pa.sylvester_matrix(np.ones(1), f)


@pytest.mark.capability("08-28")
def test_three_rps_is_found_by_its_legs():
    rng = np.random.default_rng(1)
    robot, legs = pa.ThreeRPS(1.0, 0.5), pa.three_rps(1.0, 0.5, 1.0)
    for change in 0.08 * rng.normal(size=(5, 3)):
        there = pa.leg_forward(legs, change)
        assert there
        found = robot.modes(np.sqrt(1.25) + change)
        assert len(found.t) == 16
        assert found.error < 1e-12
        assert np.linalg.norm(found.T[:, :3, 3] - there.T[:3, 3], axis=1).min() < 1e-8
        for theta in found.theta:
            B = robot.joints(np.sqrt(1.25) + change, theta)
            np.testing.assert_allclose(np.linalg.norm(B - np.roll(B, 1, axis=0), axis=1), 0.5 * 3**0.5, atol=1e-9)


@pytest.mark.parametrize(
    ("robot", "dimension"),
    [
        (pa.DeltaRobot(0.3, 0.1, 0.4, 0.8), 3),
        (pa.FiveBar(1.0, 1.5, 0.3, 0.9, 1.2), 2),
        (
            pa.PlanarThreeRRR([[0, 0], [3, 0], [1, 2]], [[0, 0], [0.5, 0], [0, 0.5]], [0.8] * 3, [1.0, 0.5, 1.5]),
            3,
        ),
    ],
    ids=["delta", "five-bar", "3-RRR"],
)
def test_rods_miss_a_place_by_as_much_as_the_best_angle_of_the_crank_leaves(robot, dimension):
    places = np.random.default_rng(4).uniform(-2.0, 2.0, (200, dimension))
    misfit = robot.rod_misfit(places)
    angles = robot.angles(places)
    if isinstance(robot, pa.FiveBar):
        reached = np.stack([np.isfinite(angles[:, 0, 0, 0]), np.isfinite(angles[:, 0, 0, 1])], axis=-1)
    else:
        reached = np.isfinite(angles[..., 0])
    assert (reached == (misfit == 0)).all()
    assert 0.05 < reached.mean() < 0.95
    turn = np.linspace(-np.pi, np.pi, 4001)[:, None]
    for place, miss in zip(places[:20], misfit, strict=False):
        match robot:
            case pa.DeltaRobot():
                far = np.linalg.norm(place - robot.elbows(turn + np.zeros(3)), axis=-1) - robot.forearm
            case pa.FiveBar():
                elbows = np.stack(robot.crank_ends(turn + np.zeros(2)), axis=1)
                far = np.linalg.norm(place - elbows, axis=-1) - [robot.rod_1, robot.rod_2]
            case _:
                far = np.linalg.norm(robot.ends(place) - robot.elbows(turn + np.zeros(3)), axis=-1) - robot.rods
        best = np.where((far > 0).all(axis=0), far.min(axis=0), np.where((far < 0).all(axis=0), far.max(axis=0), 0.0))
        np.testing.assert_allclose(miss, best, atol=1e-5)


def test_rods_that_do_not_meet_say_by_how_much():
    """Rods that are longer by that much just meet."""
    q = np.random.default_rng(5).uniform(-np.pi, np.pi, (100, 3))
    delta = pa.DeltaRobot(0.3, 0.1, 0.4, 0.5)
    short = delta.forearms_short(q)
    assert ((short == 0) == np.isfinite(delta.positions(q)[:, 0, 0])).all()
    assert 0.1 < (short > 0).mean() < 0.9
    for each, miss in zip(q[short > 0], short[short > 0], strict=True):
        for more, meets in ((1.001, True), (0.999, False)):
            longer = pa.DeltaRobot(0.3, 0.1, 0.4, 0.5 + more * miss)
            assert np.isfinite(longer.positions(each)).all() == meets
    bar = pa.FiveBar(1.0, 0.6, 0.5, 0.9, 1.2)
    apart = bar.rods_apart(q[:, :2])
    assert ((apart == 0) == np.isfinite(bar.points(q[:, :2])[:, 0, 0])).all()
    for each, miss in zip(q[apart > 0], apart[apart > 0], strict=True):
        assert np.isfinite(pa.FiveBar(1.0, 0.6 + 1.001 * miss, 0.5, 0.9, 1.2).points(each[:2])).all()
