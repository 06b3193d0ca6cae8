"""Configuration spaces: products, tori, implicit and explicit forms, curves of configurations, bodies that roll."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import mafsil as mf
import mafsil.expression as ex
from mafsil import mobility as mo
from mafsil.mobility import library, torus

ANGLES = st.floats(-50, 50, allow_nan=False)


@pytest.mark.capability("02-26", "02-27", "02-28", "02-29", "02-36")
def test_spaces_of_bodies():
    names = {
        name: (mo.named_space(name).name, mo.named_space(name).dimension)
        for name in mo.spaces.configuration_space_names()
    }
    assert names["door"] == ("I", 1)
    assert names["point in a plane"] == ("R^2", 2)
    assert names["coin"] == ("R^2 x S^1", 3)
    assert names["coin with two faces"] == ("(R^2 x S^1) x {1, 2}", 3)
    assert names["body in space"] == ("SE(3)", 6)
    assert names["rolling coin"] == ("R^2 x T^2", 4)
    with pytest.raises(mf.InputError, match="there is no space pillow"):
        mo.named_space("pillow")


@pytest.mark.capability("02-77", "02-70", "02-71", "02-73")
def test_spaces_of_chains():
    joints = [mo.joint(f"J{k}", "R", ["ground", "a", "b", "c"][k : k + 2], [k, 0]) for k in range(3)]
    scara = mo.Linkage.of([*joints, mo.joint("Z", "P", ["c", "d"], [3, 0], limits=(0.0, 0.2))])
    assert mo.configuration_space(scara).name == "I x T^3"
    limited = mo.Linkage.of([mo.joint("hinge", "R", ["ground", "door"], limits=(0.0, 2.0))])
    assert mo.configuration_space(limited).name == "I"
    kinds = {"H": "R", "C": "R x S^1", "U": "T^2", "S": "SO(3)", "E": "R^2 x S^1", "F": "SE(3)", "R": "S^1", "P": "R"}
    for kind, name in kinds.items():
        second = [1, 0, 0] if kind == "U" else None
        pitch = 0.1 if kind == "H" else 0.0
        one = mo.Linkage.of([mo.joint("J", kind, ["ground", "b"], second=second, pitch=pitch)])
        assert mo.configuration_space(one).name == name
        assert mo.configuration_space(one).dimension == mf.mobility(one).mobility
    assert mo.configuration_space(mo.linkages.as_linkage("ur5e")).dimension == 6
    with pytest.raises(mf.InputError, match="1 loops"):
        mo.configuration_space(library.four_bar())
    assert mo.named_space("position and angle").dimension == 4
    assert mo.named_space("position and direction").name == "R^3 x S^2"
    assert mo.spaces.task_redundancy(6, "position and direction") == 1
    assert mo.spaces.task_redundancy(4, "position and angle") == 0


@pytest.mark.capability("02-77")
def test_coordinates_that_wrap_and_that_do_not():
    scara = mo.Linkage.of(
        [mo.joint("R", "R", ["ground", "a"]), mo.joint("P", "P", ["a", "b"], limits=(0.0, 0.2))]
    )  # fmt: skip
    space = mo.linkages.JointCoordinates.of(scara)
    np.testing.assert_allclose(space.difference([0.1, 0.0], [6.2, 0.2]), [6.1 - 2 * np.pi, 0.2])
    assert space.distance([0.0, 0.0], [2 * np.pi, 0.1]) == pytest.approx(0.1)
    assert space.inside([[100.0, 0.1], [0.0, 0.3]]).tolist() == [True, False]
    samples = space.sample(1000)
    assert space.inside(samples).all()
    assert np.ptp(samples, axis=0) == pytest.approx([2 * np.pi, 0.2], rel=0.02)
    assert space.wrap_angles([-0.1, 0.1]) == pytest.approx([2 * np.pi - 0.1, 0.1])


@pytest.mark.capability("02-57")
@settings(max_examples=50, deadline=None)
@given(st.lists(ANGLES, min_size=2, max_size=2), st.lists(ANGLES, min_size=2, max_size=2))
def test_the_torus_wraps_around(a, b):
    step = torus.difference(a, b)
    assert (np.abs(step) <= np.pi).all()
    np.testing.assert_allclose(torus.embed_in_space(np.add(a, step)), torus.embed_in_space(b), atol=1e-12)
    assert torus.distance(a, b) == pytest.approx(torus.distance(b, a), abs=1e-9)
    np.testing.assert_allclose(
        torus.embed_in_space(torus.angles_of(torus.embed_in_space(a))), torus.embed_in_space(a), atol=1e-12
    )
    np.testing.assert_allclose(torus.embed_in_space(torus.between(a, b, 1.0)), torus.embed_in_space(b), atol=1e-11)
    assert (torus.chart(a) >= 0).all()
    assert (torus.chart(a) < 2 * np.pi).all()


def test_paths_are_cut_where_they_cross_the_seam():
    path = np.stack([np.linspace(0, 4 * np.pi - 0.01, 400), np.linspace(1, 1.5, 400)], axis=1)
    pieces = torus.cut_at_seams(path)
    assert len(pieces) == 2
    assert sum(map(len, pieces)) == 400


@pytest.mark.capability("02-55", "02-56", "02-33")
def test_explicit_and_implicit_body_of_the_plane():
    rng = np.random.default_rng(0)
    explicit = rng.uniform(-3, 3, (20, 3))
    implicit = mo.bodies.implicit_body(explicit, 1.3)
    assert np.abs(mo.bodies.planar_residual(implicit, 1.3)).max() < 1e-14
    np.testing.assert_allclose(mo.bodies.explicit_body(implicit, 1.3), explicit, atol=1e-14)
    with pytest.raises(mf.InputError, match="not points of this body"):
        mo.bodies.explicit_body(implicit, 1.4)
    A, B = implicit[0, :2], implicit[0, 2:]
    for face, sign in ((True, 1), (False, -1)):
        C = mo.bodies.third_point(A, B, 1.0, 0.9, face_up=face)
        assert [np.linalg.norm(C - A), np.linalg.norm(C - B)] == pytest.approx([1.0, 0.9])
        u, w = B - A, C - A
        assert np.sign(u[0] * w[1] - u[1] * w[0]) == sign
    with pytest.raises(mf.InputError, match="make no triangle"):
        mo.bodies.third_point(A, B, 0.1, 0.1)


@pytest.mark.capability("02-25", "02-80")
def test_every_point_of_every_body():
    linkage = library.four_bar()
    found = mo.linkages.close_loops_near(linkage, [[0.0] * 4, [0.3, 0, 0, 0]], fixed=["A"])
    C = linkage.joints[linkage.index_of(["C"])[0]].point
    on_coupler = mo.point_position(linkage, "coupler", C, found.theta)
    on_rocker = mo.point_position(linkage, "rocker", C, found.theta)
    np.testing.assert_allclose(on_coupler, on_rocker, atol=1e-10)
    np.testing.assert_allclose(on_coupler[0], C, atol=1e-12)
    assert np.linalg.norm(on_coupler[1] - C) > 0.1
    with pytest.raises(mf.ModelError, match="no body wheel"):
        mo.point_position(linkage, "wheel", C)


@pytest.mark.capability("02-38", "02-39", "02-32", "02-31")
def test_table_of_joints():
    table = {
        "R": (1, 2, 5),
        "P": (1, 2, 5),
        "H": (1, None, 5),
        "C": (2, None, 4),
        "U": (2, None, 4),
        "S": (3, None, 3),
        "RP": (2, 1, None),
    }
    for letter, (freedoms, plane, space) in table.items():
        kind = mo.linkages.KINDS[letter]
        assert kind.freedoms == freedoms
        if plane is not None:
            assert mo.gruebler_count(2, [freedoms], "planar").constraints == (plane,)
        if space is not None:
            assert mo.gruebler_count(2, [freedoms], "spatial").constraints == (space,)
        second, pitch = ([1, 0, 0] if letter in ("U", "RP") else None), (0.2 if letter == "H" else 0.0)
        drawn = mo.joint("J", letter, ["ground", "body"], [0.3, -0.2, 0.5], [0, 0, 1], second=second, pitch=pitch)
        assert np.linalg.matrix_rank(drawn.screws) == freedoms
        point = np.array([0.3, -0.2, 0.5])
        for S in drawn.screws.T:
            velocity = np.cross(S[:3], point) + S[3:]
            if letter in ("R", "S", "U"):
                np.testing.assert_allclose(velocity, 0, atol=1e-15)
            if letter == "H":
                np.testing.assert_allclose(velocity, [0, 0, 0.2], atol=1e-15)


@pytest.mark.capability("02-72")
@settings(max_examples=50, deadline=None)
@given(st.floats(0, np.pi), st.floats(-np.pi, np.pi))
def test_directions_and_their_poles(theta, phi):
    d = mo.spaces.direction_of(theta, phi)
    assert np.linalg.norm(d) == pytest.approx(1)
    angles, pole = mo.spaces.angles_of_direction(d)
    np.testing.assert_allclose(mo.spaces.direction_of(*angles), d, atol=1e-8)
    assert bool(pole) == (np.hypot(d[0], d[1]) <= 1e-9)


@pytest.mark.capability("02-67", "02-66")
def test_reach_against_samples():
    rng = np.random.default_rng(1)
    for lengths in ((3.0, 3.0), (2.0, 2.0, 2.0), (5.0, 1.0, 1.0), (1.0, 2.0, 4.0, 0.5)):
        angles = np.cumsum(rng.uniform(-np.pi, np.pi, (200_000, len(lengths))), axis=1)
        tips = np.hypot(np.cos(angles) @ lengths, np.sin(angles) @ lengths)
        low, high = mo.spaces.annulus(lengths)
        assert low - 1e-12 <= tips.min() < low + 0.15
        assert high - 0.15 < tips.max() <= high + 1e-12


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(0.5, 3), min_size=4, max_size=4))
def test_pieces_of_four_bars_against_their_curves(lengths):
    four = mo.FourBar(*lengths)
    margin = 2 * (min(lengths) + max(lengths)) - sum(lengths)
    if abs(margin) < 0.01 or abs(four.space.excess) < 0.01:
        return
    assert len(four.curves()) == four.space.components
    assert four.space.components == (0 if four.space.excess > 0 else 2 if margin < 0 else 1)
    for curve in four.curves(181):
        assert np.abs(four.closure(curve)).max() < 1e-9
        assert float(np.linalg.norm(torus.difference(curve[0], curve[-1]))) < 0.2


@pytest.mark.capability("02-59", "02-60")
@pytest.mark.parametrize("lengths", [(2, 4, 3.5, 4.5), (4, 2, 3.5, 4.5), (3, 4, 3.5, 4.6), (1.5, 1.2, 1.4, 1.0)])
def test_curves_of_configurations_by_continuation(lengths):
    four = mo.FourBar(*lengths)
    low, high = four.input_range
    middle = (low + high) / 2
    curve = mo.trace_motion(four.linkage(middle))
    assert curve.status is mo.tracing.TraceStatus.CLOSED
    assert len(curve.branch_points) == 0
    crank = curve.theta[:, 0] + middle
    turned = abs(crank[-1] - crank[0]) > np.pi
    assert turned == (low < 1e-9 and high > np.pi - 1e-9)
    if not turned:
        reached = np.abs(torus.difference(0.0, np.unwrap(crank)))
        dead = np.abs(torus.difference(0.0, curve.dead_points("A")[:, 0] + middle))
        limits = [value for value in (low, high) if 1e-9 < value < np.pi - 1e-9]
        for value in dead:
            assert min(abs(value - limit) for limit in limits) < 1e-9
        assert reached.max() <= high + 1e-9


def test_branch_points_of_a_parallelogram():
    curve = mo.trace_motion(library.parallelogram(1.0, 2.0, 1.0))
    assert curve.status is mo.tracing.TraceStatus.CLOSED
    assert sorted(np.round(np.abs(torus.difference(0.0, curve.branch_points[:, 0] + 1.0)), 6)) == pytest.approx(
        [0, np.pi], abs=1e-5
    )
    there = mo.finite_mobility(library.parallelogram(1.0, 2.0, 0.0))
    assert (there.status, there.mobility, there.branches) == (mo.finite.FiniteStatus.BRANCH_POINT, 1, 2)


@pytest.mark.capability("02-60")
def test_ways_of_assembly():
    four = mo.FourBar(2, 4, 3.5, 4.5)
    found = mo.assembly_modes(four.linkage(1.0), {"A": 0.2})
    expected = four.positions(1.2).theta
    absolute = found.theta[:, :3] + four.positions(1.0).theta[0][:3]
    for mode in expected:
        assert min(np.abs(torus.difference(mode[:3], one)).max() for one in absolute) < 1e-8
    assert len(found) == 2
    none = mo.assembly_modes(mo.FourBar(1, 1, 1, 2.5).linkage(0.3), {"A": 1.5})
    assert not none
    assert none.least_gap > 0.1
    assert "was found" in none.explain("en")


@pytest.mark.capability("02-83", "02-64")
@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(-3, 3), min_size=4, max_size=4), st.floats(-2, 2), st.floats(-2, 2), st.floats(0.01, 1))
def test_the_coin_rolls_without_slip(q, phi_dot, theta_dot, r):
    coin, h = mo.bodies.Coin(r), 1e-6
    start = np.array(q)
    rate = (coin.drive(start, phi_dot, theta_dot, h) - coin.drive(start, phi_dot, theta_dot, -h)) / (2 * h)
    np.testing.assert_allclose(coin.constraints.residual(start, rate), 0, atol=1e-8)
    T = coin.pose(start)
    np.testing.assert_allclose(T[:3, :3].T @ T[:3, :3], np.eye(3), atol=1e-12)
    contact = np.linalg.inv(T) @ np.array([start[0], start[1], 0, 1])
    move = (coin.pose(start + h * rate) - coin.pose(start - h * rate)) / (2 * h)
    np.testing.assert_allclose(move @ contact, 0, atol=1e-7)
    flat = coin.rim_point(np.array([q[0], q[1], q[2], 0.0]))
    np.testing.assert_allclose(flat, [q[0], q[1], 0], atol=1e-12)
    whole = coin.drive(start, phi_dot, theta_dot, 1.0)
    halves = coin.drive(coin.drive(start, phi_dot, theta_dot, 0.4), phi_dot, theta_dot, 0.6)
    np.testing.assert_allclose(whole, halves, atol=1e-12)


@pytest.mark.capability("02-65")
def test_car_and_unicycle():
    car = mo.bodies.Car(2.0)
    assert car.constraints.integrability.growth == (2, 3, 4)
    path = car.drive([0, 0, 0.3, 0.4], lambda t: (1.0, 0.0), 3.0)
    unicycle = mo.bodies.Unicycle().drive([0, 0, 0.3], 1.0, np.tan(0.4) / 2.0, 3.0)
    np.testing.assert_allclose(path[-1, :3], unicycle, atol=1e-10)
    rng = np.random.default_rng(0)
    for q in rng.uniform(-1, 1, (10, 4)):
        rate = car.rates(q, np.array(0.7), np.array(0.2))
        np.testing.assert_allclose(car.constraints.residual(q, rate), 0, atol=1e-14)
    with pytest.raises(mf.InputError, match="right angle"):
        car.drive([0, 0, 0, 2.0], lambda t: (1.0, 0.0), 1.0)


@pytest.mark.capability("02-63", "02-62")
@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e4])
def test_gradients_of_any_function_are_holonomic_and_their_products_too(scale):
    """Brackets that cancel leave rounding, which has no direction: rows of gradients of products, sums and sines."""
    functions = [
        lambda q: [q[1] * q[2], q[0] * q[2], q[0] * q[1]],  # of x y z
        lambda q: [q[1] * ex.cos(q[0] * q[1]) + q[2], q[0] * ex.cos(q[0] * q[1]), q[0]],  # of sin(x y) + x z
        lambda q: [
            (1 + q[1] ** 2) * g for g in (2 * q[0] / q[2], 3.0, -((q[0] / q[2]) ** 2))
        ],  # of x^2/z + 3 y, and a factor
    ]
    for row in functions:
        found = mo.spaces.Pfaffian(
            tuple("xyz"), lambda q, row=row: [[scale * a for a in row(q)]], about=(1.0, 2.0, 3.0)
        )
        assert found.integrability.status is mo.spaces.Integrability.HOLONOMIC
        assert found.integrability.growth == (2,)
        assert found.integrability.first_integrals == 1
    two = mo.spaces.Pfaffian(
        tuple("xyzw"), lambda q: [[q[1] * scale, q[0] * scale, 0, 0], [0, 0, q[3], q[2]]], (1, 2, 3, 4)
    )
    assert two.integrability.growth == (2,)
    assert two.integrability.first_integrals == 2
    # Dx ^ dx is not zero: -y dx + x dy + dz.
    twisted = mo.spaces.Pfaffian(tuple("xyz"), lambda q: [[-scale * q[1], scale * q[0], scale]], about=(0.3, 0.2, 0.1))
    assert twisted.integrability.status is mo.spaces.Integrability.NONHOLONOMIC
    partly = mo.spaces.Pfaffian(tuple("xyzw"), lambda q: [[1, 0, 0, 0], [0, 0, scale, scale * q[1]]], (1, 2, 3, 1))
    assert (partly.integrability.status, partly.integrability.growth) == (mo.spaces.Integrability.PARTLY, (2, 3))


@pytest.mark.capability("02-63")
def test_potentials_and_contradictions():
    holonomic = mo.spaces.Pfaffian(("x", "y"), lambda q: [[2 * q[0] * q[1], q[0] * q[0]]], (1.0, 1.0))
    assert holonomic.integrability.closed
    assert holonomic.potential(0, [2.0, 3.0], [0.0, 0.0]) == pytest.approx(12.0)
    coin = mo.bodies.Coin(0.1).constraints
    row, j, k = coin.integrability.contradiction
    assert {coin.names[j], coin.names[k]} == {"theta", "phi"}
    with pytest.raises(mf.InputError, match="not a gradient"):
        coin.potential(row, [1.0, 1.0, 1.0, 1.0])
    mixed = mo.spaces.Pfaffian(tuple("xyz"), lambda q: [[q[2] * q[2], q[2] * q[2], q[2]]], (0.0, 0.0, 2.0))
    assert mixed.integrability
    assert not mixed.integrability.closed


@pytest.mark.capability("02-60")
@pytest.mark.parametrize("lengths", [(2, 4, 3.5, 4.5), (4, 2, 3.5, 4.5), (3, 4, 3.5, 4.6), (1.5, 1.2, 1.4, 1.0)])
def test_pieces_by_continuation_are_those_of_the_inequality(lengths):
    four = mo.FourBar(*lengths)
    found = mo.configuration_curves(four.linkage(sum(four.input_range) / 2), starts=32)
    assert len(found) == four.space.components
    assert sum(found.hits) == 32
    assert all(curve.status is mo.tracing.TraceStatus.CLOSED for curve in found)


def test_curves_of_other_mechanisms():
    assert len(mo.configuration_curves(library.slider_crank(), starts=32)) == 2
    assert len(mo.configuration_curves(library.bennett(), starts=32)) == 1
    crossing = mo.configuration_curves(library.parallelogram(), starts=32)
    assert [len(curve.branch_points) for curve in crossing] == [2, 2]
    assert not mo.configuration_curves(mo.linkages.lock_joints(library.four_bar(), ["A"]), starts=8)


@pytest.mark.capability("02-53")
def test_bars_that_do_not_close_say_how_much_is_missing():
    bar = mo.FourBar(1, 1, 1, 3.5)
    found = bar.positions([0.1, 0.7])
    way = np.hypot(3.5 - np.cos([0.1, 0.7]), np.sin([0.1, 0.7]))
    np.testing.assert_allclose(found.missing, way - 2.0)
    assert "0.507 m" in found.explain("en")
    short = mo.FourBar(2, 4, 1, 2.5).positions(0.0)
    assert short.missing == pytest.approx(3 - 0.5)
    assert mo.FourBar(2, 4, 3.5, 4.5).positions([0.0, 1.0]).missing.tolist() == [0.0, 0.0]
    assert mo.SliderCrank(3, 1).positions([0.0, np.pi / 2]).missing.tolist() == [0.0, 2.0]
    with pytest.raises(mf.InputError, match=r"0\.5\d* m are missing"):
        bar.linkage(0.1)
    with pytest.raises(mf.InputError, match="m are missing"):
        mo.SliderCrank(3, 1).linkage(1.0)


@pytest.mark.capability("02-77")
def test_coordinates_of_balls_are_orientations():
    chain = mo.Linkage.of([
        mo.joint("C", "C", ["ground", "a"], limits=(-1, 1)), mo.joint("U", "U", ["a", "b"], second=[1, 0, 0]),
        mo.joint("S", "ball and socket", ["b", "c"]),
    ])  # fmt: skip
    space = mo.linkages.JointCoordinates.of(chain)
    assert space.wraps.tolist() == [False, *[True] * 6]
    assert space.balls == (4,)
    first, last = space.sample(20), space.sample(20, seed=1)
    ball = mo.Linkage.of([chain.joints[2]], ground="b")
    R_a, R_b = (mo.linkages.body_poses(ball, q[:, 4:])[:, -1, :3, :3] for q in (first, last))
    apart = Rotation.from_matrix(np.swapaxes(R_a, 1, 2) @ R_b).as_rotvec()
    np.testing.assert_allclose(space.difference(first, last)[:, 4:], apart, atol=1e-9)
    assert space.distance(first[0], first[0] + [0, 0, 2 * np.pi, 0, 0, 0, 0]) == pytest.approx(0.0, abs=1e-7)


@pytest.mark.capability("02-63", "02-64")
def test_brackets_of_a_rolling_coin():
    """Roll and steer do not commute: with both brackets they lead everywhere, det = -r^2."""
    r, q, h = 0.3, np.array([0.1, 0.2, 0.7, 0.4]), 1e-4

    def roll(q):
        return [r * ex.cos(q[2]), r * ex.sin(q[2]), 0, 1]

    def steer(q):
        return [0, 0, 1, 0]

    aside = mo.spaces.lie_bracket(roll, steer)
    back = mo.spaces.lie_bracket(steer, aside)
    coin = mo.bodies.Coin(r)
    end = coin.manoeuvre(q, [(0, h), (h, 0), (0, -h), (-h, 0)])[-1]
    np.testing.assert_allclose((end - q) / h**2, aside(q), atol=1e-3)
    fields = [[r * np.cos(0.7), r * np.sin(0.7), 0, 1], [0, 0, 1, 0], aside(q), back(q)]
    assert np.linalg.det(fields) == pytest.approx(-(r**2))
