"""The Delta robot and the elimination of one unknown: laws on random input."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares

from mafsil import parallel as pa
from mafsil.errors import InputError
from mafsil.geometry import pose


@pytest.mark.capability("08-11", "08-35")
@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10_000))
def test_there_and_back(seed):
    rng = np.random.default_rng(seed)
    robot = pa.DeltaRobot(0.4, 0.1, 0.5, 1.0)
    p = rng.uniform([-0.3, -0.3, -1.1], [0.3, 0.3, -0.6], size=(20, 3))
    found = robot.inverse_kinematics(p)
    assert found
    both = found.q
    for mode in (0, 1):
        q = both[..., mode]
        ends = robot.forward_kinematics(q).x
        assert np.nanmin(np.abs(ends - p[:, None]).max(axis=2), axis=1).max() < 1e-9
        gap = np.linalg.norm(ends[:, :, None] - robot.elbows(q)[:, None], axis=-1) - robot.forearm
        assert np.nanmax(np.abs(gap)) < 1e-10


@pytest.mark.capability("08-11", "08-37")
def test_rates_and_torques():
    rng = np.random.default_rng(0)
    robot, h = pa.DeltaRobot(0.4, 0.1, 0.5, 1.0), 1e-6
    q = rng.uniform(0, 0.8, size=(30, 3))
    p = robot.forward_kinematics(q).x[:, 0]
    J = robot.jacobian(q, p)
    for k in range(3):
        step = h * np.eye(3)[k]
        difference = (robot.forward_kinematics(q + step).x[:, 0] - robot.forward_kinematics(q - step).x[:, 0]) / (2 * h)
        np.testing.assert_allclose(J[..., k], difference, atol=1e-7)
    force = rng.normal(size=(30, 3))
    np.testing.assert_allclose(robot.torques(q, p, force), np.einsum("kij,ki->kj", J, force), atol=1e-10)
    assert robot.singularity(q, p)
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
    assert abs(pa.platforms.resultant(f, g)) == pytest.approx(abs(expected), rel=1e-8, abs=1e-10)
    shared = np.polynomial.polynomial.polyfromroots([b[0], 3.0])
    assert abs(pa.platforms.resultant(f, f * 1.0)) < 1e-9
    assert abs(pa.platforms.resultant(shared, g)) < 1e-9
    x, c = rng.uniform(-3, 3), rng.normal(size=3)
    t = np.tan(x / 2)
    value = pa.platforms.half_angle_polynomial(*c) @ t ** np.arange(3)
    assert value == pytest.approx((1 + t * t) * (c[0] + c[1] * np.cos(x) + c[2] * np.sin(x)), rel=1e-9, abs=1e-9)
    coefficients = pa.platforms.eliminant(lambda t: np.polynomial.polynomial.polyval(t, f), 5)
    np.testing.assert_allclose(coefficients[:4], f, atol=1e-10)
    assert len(pa.platforms.trim_leading(coefficients)) == 4
    with pytest.raises(InputError, match="degree"):
        pa.platforms.sylvester_matrix(np.ones(1), f)


@pytest.mark.capability("08-28")
def test_three_rps_is_found_by_its_legs():
    rng = np.random.default_rng(1)
    robot, legs = pa.ThreeRPS(1.0, 0.5), pa.three_rps(1.0, 0.5, 1.0)
    for change in 0.08 * rng.normal(size=(5, 3)):
        there = pa.leg_forward(legs, change)
        assert there
        found = robot.forward_kinematics(np.sqrt(1.25) + change)
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
    found = robot.inverse_kinematics(places)
    assert found.status is pa.planar.five_bar.MotorAnglesStatus.SOME
    assert np.isfinite(found.q).all()
    fits = found.misfit == 0
    assert 0.05 < fits.mean() < 0.95
    np.testing.assert_allclose(missed(robot, places, found.q[..., 0])[fits], 0.0, atol=1e-12)
    np.testing.assert_allclose(missed(robot, places, found.q[..., 1])[fits], 0.0, atol=1e-12)
    # Elsewhere the angle is the best one, of which the rod misses so much.
    np.testing.assert_allclose(missed(robot, places, found.q[..., 0]), found.misfit, atol=1e-12)
    turn = np.linspace(-np.pi, np.pi, 4001)[:, None]
    for place, row in zip(places[:20], found, strict=False):
        far = missed(robot, place, turn + np.zeros(row.misfit.shape))
        best = np.where((far > 0).all(axis=0), far.min(axis=0), np.where((far < 0).all(axis=0), far.max(axis=0), 0.0))
        np.testing.assert_allclose(row.misfit, best, atol=1e-5)
        assert bool(row) == bool((best == 0).all()) == (len(row) > 0)
        if not row:
            worst = int(np.abs(row.misfit).argmax())
            assert f"motor {worst + 1}: its rod is {abs(row.misfit[worst]):.4g} m too" in row.explain("en")


def missed(robot, places, q):
    """Distances from the ends of the cranks to the platform, less the lengths of the rods."""
    match robot:
        case pa.DeltaRobot():
            return np.linalg.norm(places[..., None, :] - robot.elbows(q), axis=-1) - robot.forearm
        case pa.FiveBar():
            elbows = np.stack(robot.crank_ends(q), axis=-2)
            return np.linalg.norm(places[..., None, :] - elbows, axis=-1) - [robot.rod_1, robot.rod_2]
    return np.linalg.norm(robot.ends(places) - robot.elbows(q), axis=-1) - robot.rods


def test_choices_of_the_motors_are_all_combinations():
    bar = pa.FiveBar(1.0, 1.2, 1.1, 0.9, 1.5)
    found = bar.inverse_kinematics([0.7, 1.3])
    assert len(found) == len({tuple(q) for q in found}) == 4
    for q in found:
        assert np.linalg.norm(bar.forward_kinematics(q).x - [0.7, 1.3], axis=-1).min() < 1e-12
        J = bar.jacobian(q, [0.7, 1.3])
        np.testing.assert_allclose(bar.torques(q, [0.7, 1.3], [3.0, -4.0]), J.T @ [3.0, -4.0], rtol=1e-12)
    assert pa.DeltaRobot(0.4, 0.1, 0.5, 1.0).inverse_kinematics(np.zeros((5, 3)) - [0, 0, 0.9]).choices.shape == (
        5,
        8,
        3,
    )


@pytest.mark.capability("08-11", "08-29")
def test_rods_that_do_not_meet_say_how_far_their_lengths_are_off():
    q = np.random.default_rng(5).uniform(-np.pi, np.pi, (60, 3))
    for robot, motors in ((pa.DeltaRobot(0.3, 0.1, 0.4, 0.5), q), (pa.FiveBar(1.0, 0.6, 0.5, 0.9, 1.2), q[:, :2])):
        found = robot.forward_kinematics(motors)
        assert found.status is pa.platforms.platform_points.PlatformPointsStatus.SOME
        off, none = found.nearest.distance, found.count == 0
        assert 0.1 < none.mean() < 0.9
        np.testing.assert_allclose(off[~none], 0.0, atol=1e-8)
        ends, rods = found.legs.base, found.legs.lengths
        for k in np.flatnonzero(none)[:4]:
            fits = [
                least_squares(lambda p, C, l: np.linalg.norm(p - C, axis=-1) - l, start, args=(ends[k], rods[k])).cost
                for start in np.random.default_rng(0).normal(size=(12, ends.shape[-1]))
            ]
            assert off[k] == pytest.approx(np.sqrt(2 * min(fits)), rel=1e-6)
            alone = robot.forward_kinematics(motors[k])
            assert not alone
            assert f"{off[k]:.4g} m away" in alone.explain("en")


@pytest.mark.capability("08-55")
def test_ends_of_cranks_that_coincide_leave_a_circle():
    free = pa.FiveBar(1, 1, 1, 1, 1).forward_kinematics(np.radians([60, 120]))
    assert free.status is pa.platforms.platform_points.PlatformPointsStatus.FREE
    assert free.count == 0
    # All elbows of this Delta stand in the middle: the platform goes anywhere on a sphere.
    assert pa.DeltaRobot(0.1, 0.5, 0.4, 0.3).forward_kinematics([0, 0, 0]).free
    line = pa.DeltaRobot(0.1, 0.1, 0.4, 0.3).forward_kinematics([np.pi / 2, np.pi / 2, -np.pi / 2])
    assert not line
    # A rod that ends on the axis of its motor fits at any angle.
    assert pa.FiveBar(1, 1, 1, 1, 1).inverse_kinematics([0, 0]).free.tolist() == [True, False]


@pytest.mark.capability("08-36", "08-39", "08-53")
def test_nothing_is_made_of_places_that_do_not_fit_or_are_singular():
    delta, bar = pa.DeltaRobot(0.4, 0.1, 0.5, 1.0), pa.FiveBar(1, 1, 1, 1, 2)
    rrr = pa.PlanarThreeRRR([[0, 0], [3, 0], [1, 2]], [[0, 0], [0.5, 0], [0, 0.5]], [0.8] * 3, [1.0, 0.5, 1.5])
    for ask in (
        lambda: delta.jacobian([0.3, 0.1, -0.2], [5, 5, 5]), lambda: delta.torques([0, 0, 0], [0, 0, 0], [0, 0, 1]),
        lambda: bar.motor_matrices([1, 2], [0, 0.3]), lambda: rrr.singularity([0.5, 0.5, 0], [0, 0, 0]),
    ):  # fmt: skip
        with pytest.raises(InputError, match="do not belong together"):
            ask()
    level = pa.DeltaRobot(0.5, 0.1, 0.6, 0.8)  # of which forearms lie flat
    q = np.full(3, 0.8410686705679303)
    p = level.elbows(q).mean(axis=0)
    stewart = pa.StewartPlatform.on_circles(
        2.0, 1.0, np.radians([-15, 15, 105, 135, 225, 255]), np.radians([-45, 45, 75, 165, 195, 285])
    )
    T = np.tile(pose.from_translation([0, 0, 1.5]), (2, 1, 1))
    T[1, :3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]  # Fichter's
    for ask in (
        lambda: level.jacobian(q, p), lambda: bar.jacobian(np.radians([90, 90]), [1, 1]),
        lambda: stewart.leg_forces(T, np.ones(6)), lambda: stewart.twist(T, np.ones(6)),
    ):  # fmt: skip
        with pytest.raises(InputError, match=r"is singular .* ask `singularity`"):
            ask()
