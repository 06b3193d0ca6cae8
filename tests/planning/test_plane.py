"""Planning in the plane: polygons, visibility, quadtrees, potentials, navigation functions, arms, several robots."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from mafsil.errors import InputError
from mafsil.planning import (
    PolygonWorld,
    PotentialField,
    Problem,
    avoid_moving_obstacles,
    cell_decomposition,
    configuration_space_obstacles,
    coordinate_robots,
    disc_distance,
    find_path,
    minkowski_sum,
    navigation_function,
    planar_arm,
    quadtree,
    visibility_path,
)
from mafsil.planning.outcome import PlanningStatus
from mafsil.planning.waiting_places import CoordinationStatus
from tests.sizes import size

SQUARE = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
ONE = PolygonWorld.of([-5, -5], [5, 5], [SQUARE])
WALLED = PolygonWorld.of(
    [-5, -5], [5, 5], [[[-5, -0.5], [5, -0.5], [5, 0.5], [-5, 0.5]], [[2, 2], [3, 2], [3, 3], [2, 3]]]
)


def point_problem(world, resolution=0.02):
    return Problem(world.lower, world.upper, world.free, world.free_segment, resolution)


@pytest.mark.capability("11-43")
def test_the_shortest_way_round_a_square():
    """From (-3, 0) to (3, 0): two corners, 2 sqrt(2^2 + 1) + 2 = 6.472136."""
    found = visibility_path(ONE, [-3.0, 0.0], [3.0, 0.0])
    assert found
    assert found.length == pytest.approx(2 * np.sqrt(5) + 2, rel=1e-12)
    assert len(found.path) == 4
    assert found.explain("en") != found.explain("ar")
    assert visibility_path(ONE, [-3, 1.0], [3, 1.0]).length == pytest.approx(6.0), "along an edge is free"
    assert visibility_path(ONE, [0, 0], [3, 0]).status is PlanningStatus.START_BLOCKED
    assert visibility_path(ONE, [3, 0], [0.5, 0]).status is PlanningStatus.GOAL_BLOCKED
    assert visibility_path(WALLED, [0, 2], [0, -2]).status is PlanningStatus.SEPARATED
    with pytest.raises(InputError, match="area"):
        PolygonWorld.of([0, 0], [1, 1], [[[0, 0], [1, 1], [2, 2]]])


@settings(deadline=None, max_examples=size(2, 4))
@given(st.integers(0, 2**32 - 1))
def test_visibility_is_never_longer_than_a_search(seed):
    rng = np.random.default_rng(seed)
    polygons = [c + 0.6 * SQUARE_AT(rng) for c in rng.uniform(-3.5, 3.5, (5, 2))]
    world = PolygonWorld.of([-5, -5], [5, 5], polygons)
    start, goal = np.array([-4.9, -4.9]), np.array([4.9, 4.9])
    exact = visibility_path(world, start, goal)
    search = find_path(point_problem(world), start, goal, planner="rrt_star", seed=1, max_nodes=400, seconds=30.0)
    assert exact
    assert search
    assert exact.length <= search.length * (1 + 1e-9)
    assert search.length <= exact.length * 1.3
    for a, b in pairwise(search.path):
        assert world.free(a + np.linspace(0, 1, 200)[:, None] * (b - a)).all()


@pytest.mark.capability("11-43")
def test_a_corner_on_the_border_is_passed():
    """The diamond's lowest corner is on the border: the way bends there once, and is not led along an edge."""
    world = PolygonWorld.of([-5, -5], [5, 5], [[[3, -5], [4, -4], [3, -3], [2, -4]]])
    a, corner, b = np.array([4.3, -4.5]), np.array([3.0, -5.0]), np.array([-3.5, -3.6])
    over = np.linalg.norm(a - corner) + np.linalg.norm(corner - b)
    assert visibility_path(world, a, b).length == pytest.approx(over, rel=1e-12)


@pytest.mark.capability("11-43")
def test_trapezoids_round_a_square():
    """Left, below, above, right of a square of area 4 in a room of area 100; a wall across separates."""
    found = cell_decomposition(ONE)
    heights = found.cells[:, (3, 2), 1] - found.cells[:, (0, 1), 1]
    areas = (found.cells[:, 1, 0] - found.cells[:, 0, 0]) * heights.mean(axis=1)
    np.testing.assert_allclose(np.sort(areas), [8.0, 8.0, 40.0, 40.0])
    assert len(found.doors) == 4
    way = found.path([-3, 0], [3, 0])
    assert way.length == pytest.approx(2 * (np.sqrt(13) + 1), rel=1e-12)
    assert found.path([0, 0], [3, 0]).status is PlanningStatus.START_BLOCKED
    assert found.path([3, 0], [9, 0]).status is PlanningStatus.GOAL_BLOCKED
    assert cell_decomposition(WALLED).path([0, 2], [0, -2]).status is PlanningStatus.SEPARATED


@settings(deadline=None, max_examples=8)
@given(st.integers(0, 2**32 - 1))
@pytest.mark.capability("11-43")
def test_trapezoids_fill_what_is_free_and_find_a_way_where_the_visibility_graph_does(seed):
    """Squares at random places, or at whole numbers, where they share edges and corners, and stand over the border."""
    rng = np.random.default_rng(seed)
    centres = rng.uniform(-5, 5, (6, 2))
    if seed % 2:
        polygons = [
            np.round(c) + size * np.array(SQUARE) for c, size in zip(centres, rng.integers(1, 3, 6), strict=True)
        ]
    else:
        polygons = [c + 1.5 * SQUARE_AT(rng) for c in centres]
    world = PolygonWorld.of([-5, -5], [5, 5], polygons)
    found, points = cell_decomposition(world), rng.uniform(-5, 5, (60, 2))
    free = world.free(points)
    assert [bool(found.holding(point)) for point in points] == free.tolist()
    some = points[free]
    for a, b in zip(some[:6:2], some[1:6:2], strict=False):
        way, shortest = found.path(a, b), visibility_path(world, a, b)
        assert way.status is shortest.status
        assert way.length >= shortest.length * (1 - 1e-9) or not way
        assert all(world.free_segment(p, q) for p, q in pairwise(way.path))


def SQUARE_AT(rng):
    angle = rng.uniform(0, np.pi)
    c, s = np.cos(angle), np.sin(angle)
    return np.array(SQUARE) @ np.array([[c, s], [-s, c]])


@pytest.mark.capability("11-42")
@settings(deadline=None, max_examples=50)
@given(st.integers(0, 2**32 - 1), st.integers(3, 8), st.integers(3, 8))
def test_sums_of_convex_polygons_are_hulls(seed, m, n):
    rng = np.random.default_rng(seed)
    a, b = rng.normal(size=(m + 3, 2)), rng.normal(size=(n + 3, 2))
    a, b = a[ConvexHull(a).vertices], b[ConvexHull(b).vertices]
    found = minkowski_sum(a, b[::-1])
    hull = ConvexHull((a[:, None] + b[None]).reshape(-1, 2))
    ours = ConvexHull(found)
    assert ours.volume == pytest.approx(hull.volume, rel=1e-9)
    assert len(found) <= len(a) + len(b)
    assert len(ours.vertices) == len(found)


@pytest.mark.capability("11-43")
def test_a_quadtree_finds_its_way_and_proves_separation():
    tree = quadtree(ONE, 5)
    area = sum(float(np.prod(cells[:, 1] - cells[:, 0], axis=1).sum()) for cells in (tree.free, tree.full, tree.mixed))
    assert area == pytest.approx(100.0)
    assert float(np.prod(tree.full[:, 1] - tree.full[:, 0], axis=1).sum()) <= 4.0
    found = tree.path([-3, 0.1], [3, 0.1])
    assert found
    assert found.length >= visibility_path(ONE, [-3, 0.1], [3, 0.1]).length
    for a, b in pairwise(found.path):
        assert ONE.free_segment(a, b)
    assert quadtree(WALLED, 5).path([0, 2], [0, -2]).status is PlanningStatus.SEPARATED
    narrow = PolygonWorld.of(
        [0, 0], [1, 1], [[[0, 0.4], [0.49, 0.4], [0.49, 0.6], [0, 0.6]], [[0.51, 0.4], [1, 0.4], [1, 0.6], [0.51, 0.6]]]
    )
    assert quadtree(narrow, 3).path([0.2, 0.1], [0.2, 0.9]).status is PlanningStatus.NOT_FOUND
    assert quadtree(narrow, 8).path([0.2, 0.1], [0.2, 0.9])
    assert tree.path([0, 0], [3, 0]).status is PlanningStatus.START_BLOCKED


@pytest.mark.capability("11-43")
def test_cells_of_a_quadtree_are_counted_as_by_recursion():
    """A square of the lower left quarter: one full, three free; a smaller one divides that quarter again."""
    quarter = PolygonWorld.of([0, 0], [8, 8], [[[0, 0], [4, 0], [4, 4], [0, 4]]])
    tree = quadtree(quarter, 4)
    assert (len(tree.free), len(tree.full), len(tree.mixed)) == (3, 1, 0)
    smaller = quadtree(PolygonWorld.of([0, 0], [8, 8], [[[0, 0], [2, 0], [2, 2], [0, 2]]]), 4)
    assert (len(smaller.free), len(smaller.full), len(smaller.mixed)) == (6, 1, 0)


@pytest.mark.capability("11-44")
@settings(deadline=None, max_examples=40)
@given(st.integers(0, 2**32 - 1))
def test_forces_are_gradients(seed):
    rng = np.random.default_rng(seed)
    field = PotentialField.of(
        rng.normal(size=3), [disc_distance(rng.normal(size=3), 0.3) for _ in range(3)], kp=2.0, eta=0.5, reach=1.5
    )
    x, h = rng.normal(size=3) * 2, 1e-6
    if field.near(x).rho.min() < 0.05:
        return
    slope = [(field.potential(x + h * e) - field.potential(x - h * e)) / (2 * h) for e in np.eye(3)]
    np.testing.assert_allclose(field.force(x), -np.array(slope), rtol=1e-4, atol=1e-4)


@pytest.mark.capability("11-40", "11-44")
def test_a_local_method_is_stuck_where_a_global_one_arrives():
    obstacle = disc_distance([2.0, 0.0], 0.5)
    field = PotentialField.of([4.0, 0.0], [obstacle], kp=2.0)
    problem = Problem([-1.0, -2.0], [5.0, 2.0], lambda x: obstacle(x)[0] > 0.0)
    assert field.path([0.0, 0.0]).status is PlanningStatus.LOCAL_MINIMUM
    assert find_path(problem, [0.0, 0.0], [4.0, 0.0])
    assert navigation_function(problem, [4.0, 0.0], 60).path([0.0, 0.0])


@pytest.mark.capability("11-44")
def test_a_navigation_function_has_one_minimum():
    world = PolygonWorld.of([0, 0], [10, 10], [[[3, 0], [4, 0], [4, 8], [3, 8]], [[6, 2], [7, 2], [7, 10], [6, 10]]])
    field = navigation_function(point_problem(world), [9.5, 9.5], 40)
    inner = field.steps.copy()
    reachable = inner >= 0
    lower = np.zeros_like(reachable)
    for axis in (0, 1):
        for shift in (-1, 1):
            other = np.roll(inner, shift, axis=axis)
            edge = np.zeros_like(reachable)
            np.moveaxis(edge, axis, 0)[0 if shift == 1 else -1] = True
            lower |= ~edge & (other >= 0) & (other < inner)
    assert (reachable & ~lower).sum() == 1, "every cell but the goal's has a lower neighbour"
    found = field.path([0.5, 0.5])
    assert found
    assert found.length >= visibility_path(world, [0.5, 0.5], [9.5, 9.5]).length
    cut_off = navigation_function(point_problem(WALLED), [0, -2], 40).path([0, 2])
    assert cut_off.status is PlanningStatus.NOT_FOUND
    assert "40 x 40" in cut_off.explain("en")


def _signed_distance(points, corners):
    """(m, m) of points (m, m, 2) to a convex polygon, negative inside, from its definition."""
    a, b = corners, np.roll(corners, -1, axis=0)
    to, along = points[..., None, :] - a, b - a
    share = np.clip((to * along).sum(axis=-1) / (along**2).sum(axis=-1), 0.0, 1.0)
    distance = np.linalg.norm(to - share[..., None] * along, axis=-1).min(axis=-1)
    sides = along[:, 0] * to[..., 1] - along[:, 1] * to[..., 0]
    return np.where((sides > 0).all(axis=-1) | (sides < 0).all(axis=-1), -distance, distance)


@pytest.mark.capability("11-42", "11-44")
@pytest.mark.parametrize("seed", range(2))
def test_paths_down_a_navigation_function_are_free_between_the_cells(seed):
    """Splinters thinner than the cells: their middles are free, motions between them need not be."""
    rng = np.random.default_rng(seed)
    places, ways = rng.uniform(-0.9, 0.9, (20, 2)), rng.normal(size=(20, 2))
    ways *= 0.25 / np.linalg.norm(ways, axis=1, keepdims=True)
    beside = ways[:, ::-1] * [0.02, -0.02]
    splinters = [[p - w, p - w + n, p + w + n, p + w] for p, w, n in zip(places, ways, beside, strict=True)]
    world = PolygonWorld.of([-1, -1], [1, 1], splinters)
    field = navigation_function(point_problem(world), [0.95, 0.95], 30)
    for start in ([-0.95, -0.95], [-0.95, 0.95], [0.95, -0.95], [0.93, 0.95], [0.95, 0.95]):
        found = field.path(start)
        exact = visibility_path(world, start, [0.95, 0.95])
        assert bool(found) == bool(exact), found.explain("en")
        assert found.length >= exact.length - 1e-12
        np.testing.assert_array_equal(found.path[[0, -1]], [start, [0.95, 0.95]])
        share = np.linspace(0.0, 1.0, 300)[:, None]
        assert all(world.free(a + share * (b - a)).all() for a, b in pairwise(found.path))
    assert field.path([3.0, 0.0]).status is PlanningStatus.START_BLOCKED
    inside = navigation_function(point_problem(ONE), [0.0, 0.0], 20)
    assert inside.path([3.0, 3.0]).status is PlanningStatus.GOAL_BLOCKED
    for cells, words in ((0, "cells"), ((5,), "cells"), ((9000, 9000), "larger than")):
        with pytest.raises(InputError, match=words):
            navigation_function(point_problem(ONE), [3.0, 3.0], cells)


def test_no_proof_of_separation_where_corners_touch():
    """Obstacles are open: the visibility graph passes between them, so a quadtree must not prove that nothing does."""
    world = PolygonWorld.of([0, 0], [2, 2], [[[0, 0], [1, 0], [1, 1], [0, 1]], [[1, 1], [2, 1], [2, 2], [1, 2]]])
    assert visibility_path(world, [0.5, 1.5], [1.5, 0.5])
    assert quadtree(world, 4).path([0.5, 1.5], [1.5, 0.5]).status is PlanningStatus.NOT_FOUND


@pytest.mark.capability("11-44")
def test_ends_inside_obstacles_of_a_potential_are_blocked_and_walks_touch_nothing():
    disc_there = disc_distance([2.0, 0.0], 0.5)
    assert PotentialField.of([4.0, 0.0], [disc_there]).path([2.1, 0.0]).status is PlanningStatus.START_BLOCKED
    assert PotentialField.of([2.1, 0.0], [disc_there]).path([0.0, 0.0]).status is PlanningStatus.GOAL_BLOCKED
    small = [disc_distance([1.5, 0.04 * k], 0.02) for k in range(-8, 9)]
    found = PotentialField.of([3.0, 0.0], small, reach=0.1, eta=1e-4).path([0.0, 0.0], step=0.3, escapes=8, seed=1)
    share = np.linspace(0.0, 1.0, 50)[:, None]
    for some in np.array_split(np.arange(len(found.path) - 1), len(found.path) // 5000 + 1):
        places = found.path[some, None] + share * (found.path[some + 1] - found.path[some])[:, None]
        assert all((one(places.reshape(-1, 2))[0] > 0.0).all() for one in small), "no jump over what is thin"


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: PolygonWorld.of([1, 1], [0, 0], []), "lower bound"),
        (lambda: PolygonWorld.of([0, 0], [1, 1], None), "list of polygons"),
        (lambda: minkowski_sum([[0, np.nan], [1, 0], [1, 1]], SQUARE), "not a finite number"),
        (lambda: minkowski_sum([[0, 0], [2, 0], [2, 2], [1, 0.2]], SQUARE), "not convex"),
        (lambda: minkowski_sum([[0, 1], [0.6, -0.8], [-1, 0.3], [1, 0.3], [-0.6, -0.8]], SQUARE), "not convex"),
        (lambda: planar_arm([1.0, -1.0], ONE), r"lengths\[1\]"),
        (lambda: planar_arm([1.0], ONE, thickness=-0.1), "thickness"),
        (lambda: planar_arm([1.0, 1.0], ONE).free([0.0]), "q: expected shape"),
        (lambda: configuration_space_obstacles(planar_arm([1.0] * 6, ONE), 20), "larger than"),
        (lambda: disc_distance([np.nan, 0.0], 1.0), "centre"),
        (lambda: PotentialField.of([4.0, 0.0], []).path([0.0, 0.0], escapes=-1), "escapes"),
        (lambda: find_path(Problem([0], [1], lambda q: np.full(len(q), np.nan)), [0.0], [1.0]), "no truth value"),
        (lambda: find_path(Problem([0], [1e9], lambda q: q[:, 0] >= 0), [0.0], [1e9]), "coarser"),
        (lambda: find_path(point_problem(ONE), [3.0, 3.0], [4.0, 4.0], planner=[]), "rrt_connect"),
        (lambda: coordinate_robots(lambda a, b: True, (1.0, 1.0)), "collides: expected bools"),
        (lambda: coordinate_robots(lambda a, b: a < 0, (1.0,)), "durations"),
        (lambda: avoid_moving_obstacles(lambda s, t: s < 0, 1.0, 0.5), "horizon"),
    ],
)
def test_wrong_input_of_the_plane_is_named(call, words):
    with pytest.raises(InputError, match=words):
        call()


@pytest.mark.capability("11-39", "11-42")
def test_configuration_space_of_an_arm_is_that_of_brute_force():
    """All 40,000 cells, each obstacle's patch by itself; every link counts, not only the tip."""
    world = PolygonWorld.of(
        [-3, -3], [3, 3], [[[0.9, 0.4], [1.4, 0.4], [1.4, 0.9], [0.9, 0.9]], [[-1.2, -0.6], [-0.6, -0.6], [-0.9, 0.2]]]
    )
    arm = planar_arm([1.0, 0.8], world, thickness=0.03)
    axes, patches = configuration_space_obstacles(arm, 200)
    assert patches.shape == (2, 200, 200)
    T1, T2 = np.meshgrid(*axes, indexing="ij")
    elbow = np.stack([np.cos(T1), np.sin(T1)], axis=-1)
    tip = elbow + 0.8 * np.stack([np.cos(T1 + T2), np.sin(T1 + T2)], axis=-1)
    share = np.linspace(0.0, 1.0, 81)[:, None, None, None]
    for patch, corners in zip(patches, world.polygons, strict=True):
        first = _signed_distance((share * elbow[:, :1]), corners).min(axis=0)
        second = [_signed_distance(points, corners) for points in elbow + share * (tip - elbow)]
        least = np.minimum(first, np.min(second, axis=0))
        # Places along a link are at most 12.5 mm apart: on the edge of a patch that errs by less than 0.7 mm.
        decided = np.abs(least - 0.03) > 7e-4
        assert decided.mean() > 0.98
        np.testing.assert_array_equal(patch[decided], (least < 0.03)[decided])
    folded = np.array([0.45, 3.0])
    assert world.free(arm.joints(folded)[0, -1][None])[0]
    assert not arm.free(folded)[0], "the tip is free, the first link is not"


@pytest.mark.capability("11-39", "11-50")
def test_an_arm_goes_round_an_obstacle():
    world = PolygonWorld.of([-3, -3], [3, 3], [[[1.1, -0.2], [1.6, -0.2], [1.6, 0.2], [1.1, 0.2]]])
    arm = planar_arm([1.0, 0.8], world, thickness=0.02)
    start, goal = [-0.9, 0.3], [0.9, -0.3]
    assert not arm.problem().is_free_segment(np.array(start), np.array(goal))
    for planner in ("rrt_connect", "prm", "rrt_star"):
        nodes = 250 if planner == "rrt_star" else 3000
        found = find_path(arm.problem(), start, goal, planner=planner, seed=4, max_nodes=nodes, seconds=20.0)
        assert found, found.explain("en")
        shares = np.linspace(0, 1, 400)[:, None]
        dense = np.concatenate([a + shares * (b - a) for a, b in pairwise(found.path)])
        assert arm.free(dense).all()


def wall_with_gap(q):
    """A wall in the first coordinate with a gap in all the others, a tenth of it in any dimension."""
    inside, wide = np.abs(q[:, 0]) < 0.1, 2 * 0.125 ** (1 / (q.shape[1] - 1))
    gap = (q[:, 1:] > 1.0 - wide).all(axis=1)
    return ~inside | gap


@pytest.mark.capability("11-40", "11-42")
@pytest.mark.parametrize("n", [2, 4, 6])
@pytest.mark.parametrize("planner", ["rrt_connect", "prm", "rrt_star"])
def test_searches_in_any_dimension(n, planner):
    problem = Problem(-np.ones(n), np.ones(n), wall_with_gap, resolution=0.02)
    start, goal = np.full(n, -0.5), np.full(n, 0.5)
    start[1:] = goal[1:] = -0.5
    budget = {"seed": 2, "seconds": 60.0, "max_nodes": 800 if planner == "rrt_star" else 50_000}
    found = find_path(problem, start, goal, planner=planner, **budget)
    assert found, found.explain("en")
    np.testing.assert_array_equal(found.path[[0, -1]], [start, goal])
    assert problem.is_free_path(found.path)
    again = find_path(problem, start, goal, planner=planner, **budget)
    np.testing.assert_array_equal(found.path, again.path)


def test_what_cannot_be_planned_is_said():
    problem = Problem([-1, -1], [1, 1], lambda q: np.abs(q[:, 0]) > 0.1)
    assert find_path(problem, [0.0, 0.0], [0.5, 0.0]).status is PlanningStatus.START_BLOCKED
    assert find_path(problem, [0.5, 0.0], [0.0, 0.0]).status is PlanningStatus.GOAL_BLOCKED
    assert find_path(problem, [0.5, 0.0], [2.0, 0.0]).status is PlanningStatus.GOAL_BLOCKED
    never = find_path(problem, [-0.5, 0.0], [0.5, 0.0], max_nodes=500)
    assert never.status is PlanningStatus.NOT_FOUND
    assert "not proven" in never.explain("en")
    assert find_path(problem, [0.5, 0.0], [0.5, 0.0]).length == 0.0
    several = find_path(problem, [-0.5, 0.0], [[0.5, 0.0], [-0.5, 0.5]])
    np.testing.assert_array_equal(several.path[-1], [-0.5, 0.5])
    for wrong, match in (({"planner": "magic"}, "rrt_connect"), ({"seconds": 0.0}, "seconds")):
        with pytest.raises(InputError, match=match):
            find_path(problem, [-0.5, 0.0], [0.5, 0.0], **wrong)
    with pytest.raises(InputError, match="finite"):
        find_path(problem, [np.nan, 0.0], [0.5, 0.0])
    with pytest.raises(InputError, match="bools"):
        find_path(Problem([-1], [1], lambda q: True), [0.0], [0.5])
    with pytest.raises(InputError, match="lower"):
        Problem([1.0], [0.0], lambda q: q[:, 0] > 0)


@pytest.mark.capability("11-45")
def test_two_robots_cross_and_one_waits():
    """Discs of radius 0.5 on crossing ways of 10 m at 1 m/s: who comes second waits 1.41 s, by the grid's rule."""

    def collides(s1, s2):
        a = np.stack([10 * s1 - 5, 0 * s1], axis=-1)
        b = np.stack([0 * s2, 10 * s2 - 5], axis=-1)
        return np.linalg.norm(a - b, axis=-1) < 1.0

    found = coordinate_robots(collides, (10.0, 10.0), cells=400)
    assert found
    assert not collides(*found.shares.T).any()
    assert (np.diff(found.shares, axis=0) >= 0).all()
    assert found.duration == pytest.approx(10.0 + np.sqrt(2.0), abs=0.08)
    first = coordinate_robots(collides, (10.0, 10.0), cells=400, priority=True)
    assert first
    assert (np.diff(first.shares[:400, 0]) > 0).all()


@pytest.mark.capability("11-45")
def test_robots_that_meet_head_on_block_each_other():
    found = coordinate_robots(lambda a, b: np.abs(10 * a - (10 - 10 * b)) < 1.0, (10.0, 10.0))
    assert found.status is CoordinationStatus.NOT_FOUND
    assert not found
    assert sum(found.reached) == pytest.approx(0.9, abs=0.02)
    assert found.explain("en") != found.explain("ar")
    assert coordinate_robots(lambda a, b: (a < 0.1) & (b < 0.1), (1.0, 1.0)).status is CoordinationStatus.BLOCKED_END


@pytest.mark.capability("11-46")
def test_an_obstacle_that_moves_is_let_pass():
    """A disc of radius 1 crosses at half way when a robot at full speed would be there: it waits as short as it can."""

    def collides(s, t):
        robot = np.stack([10 * s - 5, 0 * s], axis=-1)
        obstacle = np.stack([0 * t, 5 - t], axis=-1)
        return np.linalg.norm(robot - obstacle, axis=-1) < 1.0

    found = avoid_moving_obstacles(collides, 10.0, 20.0, cells=500)
    assert found
    assert not collides(found.shares[:, 0], found.t).any()
    assert found.duration == pytest.approx(10.0 + np.sqrt(2.0), abs=0.06)
    stays = avoid_moving_obstacles(lambda s, t: np.abs(s - 0.5) < 0.05, 10.0, 15.0)
    assert stays.status is CoordinationStatus.NOT_FOUND
    assert stays.reached[0] == pytest.approx(0.45, abs=0.01)


@pytest.mark.capability("11-41", "11-50")
def test_gross_motion_to_a_stand_off_then_fine_motion_to_the_goal():
    """Planned as far as the stand-off; from there straight in, where only the last straight approach is free."""
    slot = PolygonWorld.of(
        [-5, -5], [5, 5], [[[1, -1], [3, -1], [3, -0.05], [1, -0.05]], [[1, 0.05], [3, 0.05], [3, 1], [1, 1]]]
    )
    problem = point_problem(slot)
    stand_off, goal = np.array([0.8, 0.0]), np.array([2.5, 0.0])
    gross = find_path(problem, [4.5, 4.0], stand_off, seed=1)
    assert gross
    assert problem.is_free_segment(stand_off, goal)
    handed_over = np.concatenate([gross.path, goal[None]])
    assert problem.is_free_path(handed_over)
