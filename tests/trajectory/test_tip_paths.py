"""Paths of a frame: shapes, orientation laws, corners; rates against differences, laws against scipy."""

from __future__ import annotations

import timeit
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, RotationSpline, Slerp

from mafsil.errors import InputError
from mafsil.geometry import pose, rotation
from mafsil.trajectory import arc_path, circle_path, joined_path, line_path, screw_path, spline_path
from mafsil.trajectory.paths import TipPath
from mafsil.trajectory.paths.cartesian_path import CartesianPath
from mafsil.trajectory.paths.joined import CornerBlend, JoinedPath

LAWS = ("relative", "relative_long", "rotation_vector", "euler", "cosines", "fixed", "tangent", "squad", "spline")


def random_poses(count, seed, turn=0.8):
    rng = np.random.default_rng(seed)
    T = np.tile(np.eye(4), (count, 1, 1))
    R = rotation.random(rng)
    for k in range(count):
        R = R @ rotation.exp(turn * rng.standard_normal(3))
        T[k, :3, :3], T[k, :3, 3] = R, rng.uniform(-1, 1, 3)
    return T


def _difference(f, s, h):
    """Central difference of fourth order."""
    return (8 * (f(s + h) - f(s - h)) - (f(s + 2 * h) - f(s - 2 * h))) / (12 * h)


def assert_twists(path: TipPath, places=None, step=1e-4, tolerance=2e-6):
    """Twists and their derivatives are those of the poses, by central differences."""
    s = np.linspace(0.013, 0.987, 41) if places is None else places
    apart = np.abs(s[:, None] - path.breaks).min(axis=1) > 5 * step
    s = s[apart]
    V, slope = path.twists(s)
    here = path.poses(s)
    back = pose.inverse(here)
    numeric = _difference(lambda x: pose.log(back @ path.poses(x)), s, step)
    np.testing.assert_allclose(numeric, V, atol=tolerance * max(1, np.abs(V).max()))
    numeric = _difference(lambda x: path.twists(x)[0], s, step)
    np.testing.assert_allclose(numeric, slope, atol=tolerance * max(1, np.abs(slope).max()))


@pytest.mark.capability("11-7", "11-9")
@pytest.mark.parametrize("law", LAWS)
def test_rates_of_lines_are_derivatives(law):
    T = random_poses(2, 3)
    path = line_path(T[0], T[1], orientation=law)
    assert_twists(path)
    np.testing.assert_allclose(path.poses(0.0), T[0], atol=1e-12)
    if law not in ("fixed", "tangent"):
        np.testing.assert_allclose(path.poses(1.0), T[1], atol=1e-12)


@pytest.mark.capability("11-7")
@pytest.mark.parametrize("law", [name for name in LAWS if name != "relative_long"])
def test_splines_pass_their_poses(law):
    T = random_poses(6, 5, 0.4)
    path = spline_path(T, orientation=law)
    assert_twists(path)
    places = path.position.breaks
    np.testing.assert_allclose(path.poses(places)[:, :3, 3], T[:, :3, 3], atol=1e-12)
    if law not in ("fixed", "tangent"):
        np.testing.assert_allclose(path.poses(places), T, atol=1e-11)
    assert (len(path.corners) > 0) == (law == "relative")


@pytest.mark.parametrize("law", ["rotation_vector", "euler", "cosines", "spline", "fixed", "tangent"])
def test_splines_have_a_continuous_derivative_of_the_twist(law):
    path = spline_path(random_poses(6, 8, 0.4), orientation=law)
    inner = path.breaks[1:-1]
    before, after = (path.twists(np.nextafter(inner, side)) for side in (0.0, 1.0))
    np.testing.assert_allclose(before[0], after[0], atol=1e-9)
    if law != "tangent":
        np.testing.assert_allclose(before[1], after[1], atol=1e-8 * np.abs(after[1]).max())


def test_squad_has_a_continuous_rate():
    path = spline_path(random_poses(6, 8, 0.3), orientation="squad")
    assert len(path.corners) == 0


@pytest.mark.capability("11-7")
def test_relative_axis_is_scipys_slerp_and_the_spline_scipys():
    T = random_poses(5, 2, 0.5)
    line = line_path(T[0], T[1])
    s = np.linspace(0, 1, 11)
    expected = Slerp([0, 1], Rotation.from_matrix(T[:2, :3, :3]))(s).as_matrix()
    np.testing.assert_allclose(line.poses(s)[:, :3, :3], expected, atol=1e-13)
    path = spline_path(T, orientation="spline")
    spline = RotationSpline(path.position.breaks, Rotation.from_matrix(T[:, :3, :3]))
    s = np.linspace(0, 1, 101)
    np.testing.assert_allclose(path.poses(s)[:, :3, :3], spline(s).as_matrix(), atol=1e-9)
    np.testing.assert_allclose(path.twists(s)[0][:, :3], spline(s, 1), atol=1e-7)


def test_the_long_turn_is_the_other_way_round():
    T = random_poses(2, 4)
    short, long = (line_path(T[0], T[1], orientation=law) for law in ("relative", "relative_long"))
    assert short.angle + long.angle == pytest.approx(2 * np.pi)
    np.testing.assert_allclose(short.poses(1.0), long.poses(1.0), atol=1e-12)
    with pytest.raises(InputError):
        line_path(T[0], T[0], orientation="relative_long")


@pytest.mark.capability("11-7")
def test_arcs_and_circles():
    T = np.tile(np.eye(4), (2, 1, 1))
    T[0, :3, 3], T[1, :3, 3] = [1, 0, 0.5], [0, -1, 0.5]
    path = arc_path(T[0], [0, 1, 0.5], T[1])
    assert path.length == pytest.approx(1.5 * np.pi)
    p = path.poses(np.linspace(0, 1, 21))[:, :3, 3]
    np.testing.assert_allclose(np.linalg.norm(p[:, :2], axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(path.poses(1.0), T[1], atol=1e-12)
    np.testing.assert_allclose(path.poses(1 / 3)[:3, 3], [0, 1, 0.5], atol=1e-12)
    assert_twists(path)
    round_trip = circle_path(T[0], [0, 0, 0], [0, 0, 2], orientation="tangent")
    np.testing.assert_allclose(round_trip.poses(1.0), T[0], atol=1e-12)
    np.testing.assert_allclose(round_trip.poses(0.25)[:3, :3], rotation.rot_z(np.pi / 2), atol=1e-12)
    assert round_trip.angle == pytest.approx(2 * np.pi)
    assert_twists(round_trip)
    assert_twists(circle_path(T[0], [0, 0, 0], [0, 0, 2], -1.0))
    with pytest.raises(InputError, match="line"):
        arc_path(T[0], (T[0, :3, 3] + T[1, :3, 3]) / 2, T[1])
    with pytest.raises(InputError):
        circle_path(T[0], [1, 0, 7], [0, 0, 1])


@settings(max_examples=6, deadline=None)
@given(st.integers(0, 10_000), st.floats(1e-4, 0.2), st.sampled_from(["line", "arc", "screw"]))
def test_blends_keep_their_bound_and_the_path_is_twice_smooth(seed, bound, shape):
    T = random_poses(4, seed)
    legs = [line_path(T[0], T[1]), line_path(T[1], T[2]), screw_path(T[2], T[3])]
    if shape == "arc":
        legs[1] = arc_path(T[1], (T[1, :3, 3] + T[2, :3, 3]) / 2 + [0.1, 0.2, -0.3], T[2])
    if shape == "screw":
        legs[1] = screw_path(T[1], T[2])
    path = joined_path(legs, blend=bound, blend_angle=0.2)
    assert len(path.blends) == 2
    assert len(path.corners) == 0
    s = np.linspace(0, 1, 4001)
    distance, angle = path.deviations(s)
    assert distance.max() <= bound
    assert angle.max() <= 0.2
    assert distance.max() <= path.deviation * (1 + 1e-6)
    assert angle.max() <= path.turn_deviation * (1 + 1e-6) + 1e-7
    ends = np.array([one.place + side * one.half for one in path.blends for side in (-1, 1)])
    ends = ends[(ends > 1e-9) & (ends < 1 - 1e-9)]
    before, after = (path.twists(ends + d * 1e-13) for d in (-1, 1))
    size = max(1.0, float(np.abs(after[0]).max()))
    np.testing.assert_allclose(before[0], after[0], atol=1e-6 * size)
    # In a blend of width h the derivative is of the size of V / h.
    np.testing.assert_allclose(before[1], after[1], atol=1e-3 * size / min(one.half for one in path.blends))


@pytest.mark.capability("11-48")
def test_the_blend_of_two_lines_misses_its_corner_as_the_formula_says():
    T = np.tile(np.eye(4), (3, 1, 1))
    T[1, :3, 3], T[2, :3, 3] = [1, 0, 0], [1, 1, 0]
    path = joined_path([line_path(T[0], T[1]), line_path(T[1], T[2])], blend=0.02)
    (one,) = path.blends
    change = np.linalg.norm([-2.0, 2.0])
    assert one.deviation == pytest.approx(3 * change * 2 * one.half / 32, rel=1e-9)
    assert one.deviation == pytest.approx(0.02, rel=1e-5)
    assert_twists(path, places=np.linspace(0.46, 0.54, 33), step=1e-5)
    assert path.length < 2.0


def test_sharp_corners_are_named_and_gaps_refused():
    T = random_poses(3, 0)
    path = joined_path([line_path(T[0], T[1]), line_path(T[1], T[2])])
    assert len(path.corners) == 1
    assert path.length == pytest.approx(line_path(T[0], T[1]).length + line_path(T[1], T[2]).length)
    with pytest.raises(InputError, match="legs"):
        joined_path([line_path(T[0], T[1]), line_path(T[2], T[1])])
    with pytest.raises(InputError):
        joined_path([])


def test_half_a_turn_of_cosines_is_refused():
    T = np.tile(np.eye(4), (2, 1, 1))
    T[1, :3, :3] = rotation.rot_x(np.pi)
    with pytest.raises(InputError, match="determinant"):
        line_path(T[0], T[1], orientation="cosines")


def test_euler_angles_at_gimbal_lock_are_warned_of():
    T = np.tile(np.eye(4), (2, 1, 1))
    T[1, :3, :3] = rotation.rot_y(np.pi / 2)
    with pytest.warns(Warning, match="gimbal"):
        line_path(T[0], T[1], orientation="euler")


def chain(count):
    """A zigzag of so many straight legs, each corner rounded over a third of its legs."""
    corners = np.tile(np.eye(4), (count + 1, 1, 1))
    corners[:, 0, 3], corners[:, 1, 3] = 0.01 * np.arange(count + 1), 0.01 * (np.arange(count + 1) % 2)
    legs = tuple(CartesianPath(a, b) for a, b in pairwise(corners))
    shares = np.arange(count + 1) / count
    return JoinedPath(legs, shares, tuple(CornerBlend(float(s), 1 / (3 * count), 0.0, 0.0) for s in shares[1:-1]))


def test_a_place_on_a_path_of_many_legs_costs_what_it_costs_on_a_path_of_few():
    """The corner that rounds it is looked up: with each asked in turn it took twenty times as long here."""
    took: list[float] = []
    for path in (chain(15), chain(6000)):
        s = path.blends[7].place
        path.twists(s)
        took.append(min(timeit.repeat(lambda path=path, s=s: path.twists(s), number=20, repeat=15)))
    assert took[1] < 4.0 * took[0]


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=40))
def test_places_in_corners_are_those_that_a_look_at_each_corner_finds(s):
    path = chain(7)
    places = np.array([*s, *(one.place for one in path.blends), *(one.place + one.half for one in path.blends)])
    right = [next((one for one in path.blends if abs(x - one.place) < one.half), None) for x in places]
    sharp = path.with_sharp_corners().poses(places)[:, :3, 3]
    rounded = path.poses(places)[:, :3, 3]
    for x, one, a, b in zip(places, right, sharp, rounded, strict=True):
        if one is None:
            np.testing.assert_array_equal(a, b)
        else:
            alone = replace(path, blends=(one,)).poses(x)[:3, 3]
            np.testing.assert_allclose(b, alone, atol=1e-15)
    hidden = (
        np.abs(path.with_sharp_corners().breaks[:, None] - np.array([one.place for one in path.blends])).min(axis=1)
        < 1e-9
    )
    ends = np.array([place for one in path.blends for place in (one.place - one.half, one.place + one.half)])
    np.testing.assert_allclose(path.breaks, np.union1d(path.with_sharp_corners().breaks[~hidden], ends), atol=1e-12)
