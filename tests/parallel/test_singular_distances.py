"""How far the nearest singular pose is, and ways between assembly modes that meet none."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from mafsil import parallel
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.parallel.platforms.pose_space import pose_space, regular_radius

INNOCENTI = parallel.PlanarThreeRPR(
    base=[[0, 0], [15.91, 0], [0, 10]], platform=[[0, 0], [17.04, 0], [13.236373239, 16.096708467]]
)
HEXAPOD = parallel.StewartPlatform.on_circles(
    2.0, 1.0, np.radians([-15, 15, 105, 135, 225, 255]), np.radians([-45, 45, 75, 165, 195, 285])
)
T = pose.from_translation([0.1, -0.2, 1.6]) @ pose.exp([0.1, -0.08, 0.17, 0, 0, 0])
seeds = st.integers(0, 10_000)


def random_robot(rng: np.random.Generator, planar: bool):
    if planar:
        return parallel.PlanarThreeRPR(rng.normal(size=(3, 2)), rng.normal(size=(3, 2)))
    return parallel.StewartPlatform(rng.normal(size=(6, 3)), rng.normal(size=(6, 3)))


def random_pose(rng: np.random.Generator, planar: bool):
    return rng.normal(size=3) if planar else pose.exp(np.append(rng.normal(size=3), rng.normal(size=3)))


def sign(robot, x) -> np.ndarray:
    return np.sign(np.linalg.det(robot.jacobian(x)))


@given(seeds, st.booleans())
def test_nothing_within_the_free_length_is_singular(seed, planar):
    rng = np.random.default_rng(seed)
    robot, x = random_robot(rng, planar), random_pose(rng, planar)
    space = pose_space(robot)
    free = float(regular_radius(space, x))
    steps = rng.normal(size=(200, space.dimension))
    steps *= free * rng.uniform(0.5, 1.0, (200, 1)) / np.linalg.norm(steps, axis=1, keepdims=True)
    assert (sign(robot, space.integrate(x, steps)) == sign(robot, x)).all()


@given(seeds, st.booleans())
def test_steps_lead_from_pose_to_pose(seed, planar):
    rng = np.random.default_rng(seed)
    space = pose_space(random_robot(rng, planar))
    x, y = random_pose(rng, planar), random_pose(rng, planar)
    back = space.integrate(x, space.step(x, y))
    assert np.abs(np.asarray(space.lengths(back)) - space.lengths(y)).max() < 1e-9
    half = space.integrate(x, space.step(x, y) / 2)
    assert np.linalg.norm(space.step(x, half)) == pytest.approx(np.linalg.norm(space.step(half, y)), abs=1e-9)


@pytest.mark.capability("08-53")
@pytest.mark.parametrize("planar", [True, False])
def test_the_nearest_singular_pose_is_that_of_a_general_minimiser(planar):
    rng = np.random.default_rng(5)
    for _ in range(3):
        robot, x = random_robot(rng, planar), random_pose(rng, planar)
        found = parallel.nearest_singularity(robot, x)
        assert found
        assert found.free <= found.distance
        assert robot.singularity(found.x).status is parallel.SingularKind.SECOND
        space = pose_space(robot)
        assert np.linalg.norm(space.step(x, found.x)) == pytest.approx(found.distance, rel=1e-6)

        def measure(step, space=space, x=x):
            return np.linalg.det(space.lines(space.integrate(x, step)))

        others = [
            minimize(
                lambda step: step @ step, rng.normal(size=space.dimension), method="SLSQP",
                constraints={"type": "eq", "fun": measure}, options={"maxiter": 300, "ftol": 1e-14},
            )
            for _ in range(20)
        ]  # fmt: skip
        best = min(np.linalg.norm(each.x) for each in others if each.success and abs(measure(each.x)) < 1e-9)
        assert found.distance < best * (1 + 1e-4)


def test_a_singular_pose_is_its_own_nearest():
    square = parallel.PlanarThreeRPR([[0, 0], [4, 0], [1, 3]], [[0, 0], [4, 0], [1, 3]])
    here = parallel.nearest_singularity(square, [1.0, 2.0, 0.0])
    assert here.distance == here.free == 0.0
    assert here.status.name == "HERE"
    assert "singular" in here.explain("en")


@pytest.mark.capability("08-35")
def test_modes_of_one_sign_are_joined_and_those_of_two_are_not():
    modes = INNOCENTI.forward_kinematics([14.98, 15.38, 12.0]).x
    for i in range(6):
        for j in range(i + 1, 6):
            way = parallel.mode_path(INNOCENTI, modes[i], modes[j])
            if sign(INNOCENTI, modes[i]) != sign(INNOCENTI, modes[j]):
                assert way.status is parallel.platforms.regular_way.ModePathStatus.OPPOSITE
                assert not len(way.x)
                continue
            assert way.status is parallel.platforms.regular_way.ModePathStatus.PROVEN
            assert np.allclose(way.x[[0, -1]], modes[[i, j]])
            assert np.allclose(way.lengths[0], way.lengths[-1])
            dense = np.concatenate([np.linspace(a, b, 2000) for a, b in zip(way.x[:-1], way.x[1:], strict=True)])
            turned = np.abs(np.diff(way.x[:, 2])).max()
            if turned < np.pi:
                assert (sign(INNOCENTI, dense) == sign(INNOCENTI, modes[i])).all()


def test_a_platform_on_six_legs_goes_through_the_floor():
    modes = HEXAPOD.forward_kinematics(HEXAPOD.lengths(T))
    joined = [k for k in range(1, len(modes)) if parallel.mode_path(HEXAPOD, modes.T[0], modes.T[k])]
    same = [k for k in range(1, len(modes)) if modes.orientation[k] == modes.orientation[0]]
    assert joined == same
    way = parallel.mode_path(HEXAPOD, modes.T[0], modes.T[same[0]])
    space = pose_space(HEXAPOD)
    for a, b in zip(way.x[:-1], way.x[1:], strict=True):
        between = space.integrate(a, np.linspace(0, 1, 3000)[:, None] * space.step(a, b))
        assert (sign(HEXAPOD, between) == modes.orientation[0]).all()


def test_ways_that_are_not_found_prove_nothing_and_ends_are_checked():
    modes = HEXAPOD.forward_kinematics(HEXAPOD.lengths(T))
    none = parallel.mode_path(HEXAPOD, modes.T[0], modes.T[4], tries=0)
    assert none.status is parallel.platforms.regular_way.ModePathStatus.NOT_FOUND
    assert "may exist" in none.explain("en")
    square = parallel.PlanarThreeRPR([[0, 0], [4, 0], [1, 3]], [[0, 0], [4, 0], [1, 3]])
    assert (
        parallel.mode_path(square, [1, 2, 0], [1, 2, 1]).status
        is parallel.platforms.regular_way.ModePathStatus.SINGULAR_END
    )
    with pytest.raises(InputError, match="x_1"):
        parallel.mode_path(square, [1, 2, 0.5], [np.nan, 2, 1])
    with pytest.raises(InputError, match="tries"):
        parallel.mode_path(square, [1, 2, 0.5], [1, 2, 1], tries=-1)


@pytest.mark.parametrize("planar", [True, False])
def test_lines_have_no_units(planar):
    """Rows are (moment about the middle of the base over the size, direction), in millimetres as in metres."""
    rng = np.random.default_rng(2)
    robot, x = random_robot(rng, planar), random_pose(rng, planar)
    tiny = type(robot)(1e-3 * robot.base, 1e-3 * robot.platform)
    small = x * [1e-3, 1e-3, 1.0] if planar else x @ np.diag([1, 1, 1, 1.0])
    if not planar:
        small[:3, 3] *= 1e-3
    lines = pose_space(robot).lines(x)
    np.testing.assert_allclose(pose_space(tiny).lines(small), lines, atol=1e-12)
    arms, d = robot.base - robot.base.mean(axis=0), robot.leg_vectors(x)
    u = d / np.linalg.norm(d, axis=-1, keepdims=True)
    both = robot.base, robot.platform
    size = max(np.linalg.norm(ends[:, None] - (ends if planar else ends.mean(axis=0)), axis=-1).max() for ends in both)
    moments = np.cross(arms, u).reshape(len(u), -1) / size if not planar else None
    flat = (arms[:, 0] * u[:, 1] - arms[:, 1] * u[:, 0])[:, None] / size if planar else moments
    np.testing.assert_allclose(lines, np.hstack([flat, u]), atol=1e-12)


@pytest.mark.capability("08-53")
def test_a_measure_that_bends_keeps_no_search_going_to_and_fro():
    """Full steps never settle here; the nearest singular pose is that of sequential quadratic programming."""
    base = [[3.3492809, 2.09874664], [-3.56252963, 0.34089953], [1.56372649, -1.09168355]]
    platform = [[0.33988143, -0.40159311], [0.41614666, -1.55756987], [-1.87425086, -0.49733158]]
    robot, x = parallel.PlanarThreeRPR(base, platform), np.array([0.26492153, 1.3531397, -0.5136435])
    found = parallel.nearest_singularity(robot, x)
    assert found
    unit, best = np.array([1.0, 1.0, robot.size]), np.inf
    for start in np.random.default_rng(0).normal(size=(8, 3)):
        fit = minimize(
            lambda u: u @ u, 2 * start, method="SLSQP", options={"ftol": 1e-12, "maxiter": 200},
            constraints=[{"type": "eq", "fun": lambda u: np.linalg.det(robot.jacobian(x + u / unit))}],
        )  # fmt: skip
        best = min(best, np.sqrt(fit.fun)) if fit.success else best
    assert found.distance == pytest.approx(best, rel=1e-6)
