"""Surfaces of configurations: topology against theorems, areas against lengths, branch points and singular places."""

from dataclasses import replace
from itertools import combinations, product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mafsil as mf
import mafsil.mobility as mo
from mafsil.mobility import Linkage, joint, library, trace_surface
from mafsil.mobility.balls import without_balls, without_balls_at
from mafsil.mobility.charts import cut, farthest, open_cell, owners
from mafsil.mobility.surface import SurfaceStatus
from mafsil.mobility.surface_mesh import edges, is_closed, is_orientable, trim_openings


def polygon(lengths):
    """A closed planar chain of these links, the first on the ground."""
    n, x = len(lengths), np.concatenate([[0.0], np.cumsum(lengths[1:])])
    names = ["ground", *(f"link {k}" for k in range(1, n)), "ground"]
    joints = [joint(f"J{k}", "R", names[k : k + 2], [x[k], 0]) for k in range(n - 1)]
    joints.append(joint(f"J{n - 1}", "R", names[n - 1 :], [x[-1], 0], child_at=[lengths[0], 0]))
    return mo.close_drawing(Linkage.of(joints, planar=True))


def beside(first, second):
    """Two linkages on one ground: their configurations are pairs."""
    joints = [
        replace(
            each, name=f"{each.name}{k}",
            parent=each.parent if each.parent == "ground" else f"{each.parent} {k}",
            child=each.child if each.child == "ground" else f"{each.child} {k}",
        )
        for k, linkage in enumerate((first, second), 1) for each in linkage.joints
    ]  # fmt: skip
    return Linkage.of(joints)


def pentagon_numbers(lengths):
    """Pieces and Euler characteristic of all configurations of a pentagon: M. Farber, D. Schuetz, Homology of planar
    polygon spaces, Geometriae Dedicata 125 (2007), theorem 1."""
    longest, *rest = sorted(lengths, reverse=True)
    half = sum(lengths) / 2
    short = [sum(longest + sum(chosen) < half for chosen in combinations(rest, k)) for k in range(3)]
    return short[0] + short[2], 2 * (short[0] + short[2]) - 2 * short[1]


def pentagons(count, seed, away=0.08):
    """Lengths of pentagons that close and keep away from a line."""
    random = np.random.default_rng(seed)
    found = []
    while len(found) < count:
        lengths = random.uniform(0.5, 2.0, 5)
        sums = [abs(float(np.dot(signs, lengths))) for signs in product((1, -1), repeat=5)]
        if pentagon_numbers(lengths)[0] and min(sums) > away:
            found.append(tuple(lengths.tolist()))
    return found


@pytest.mark.capability("02-60")
@pytest.mark.parametrize(
    "lengths", [(1, 1, 1, 1, 1), (1, 1, 1, 1, 3.5), (2, 2, 2, 0.3, 0.5), (1, 1, 1, 1, 1.9), *pentagons(6, 11)]
)
def test_pentagons_have_the_topology_of_the_theorem(lengths):
    pieces, euler = pentagon_numbers(lengths)
    found = mo.configuration_surfaces(polygon(lengths), starts=24)
    assert len(found) == pieces == mo.spaces.polygon_space(lengths).components
    assert all(one.status is SurfaceStatus.CLOSED for one in found)
    assert sum(one.euler_characteristic for one in found) == euler
    assert sum(found.hits) > 20
    assert not found.others
    for one in found:
        assert not len(one.branch_points)
        assert mo.linkages.close_loops_near(one.linkage, one.theta, steps=0).gap.max() < 1e-9


def test_small_spherical_pentagon_is_the_planar_one():
    flat = polygon([1.0] * 5)
    axes = [each.point * 0.05 + (0, 0, 1) for each in flat.joints]
    joints = [
        joint(each.name, "R", [each.parent, each.child], axis=w) for each, w in zip(flat.joints, axes, strict=True)
    ]
    assert trace_surface(Linkage.of(joints)).genus == 4


def test_arm_of_two_hinges_is_the_flat_torus():
    surface = trace_surface(library.chain(2))
    assert (surface.status, surface.euler_characteristic, surface.genus) == (SurfaceStatus.CLOSED, 0, 1)
    np.testing.assert_allclose(surface.area, (2 * np.pi) ** 2, rtol=1e-12)
    wrist = Linkage.of([joint("W", "U", ["ground", "hand"], second=[1, 0, 0])])
    assert trace_surface(wrist).genus == 1


@pytest.mark.capability("02-60")
@pytest.mark.parametrize("other", [library.four_bar, library.slider_crank, library.bennett])
def test_two_linkages_side_by_side_are_products_of_curves(other):
    first, second = library.four_bar(), other()
    curves = mo.configuration_curves(first, starts=16), mo.configuration_curves(second, starts=16)
    both = beside(first, second)
    found = mo.configuration_surfaces(both, starts=24, step=0.25)
    assert len(found) == len(curves[0]) * len(curves[1])
    assert all((one.genus, len(one.branch_points)) == (1, 0) for one in found)
    if other is library.four_bar:  # hinges only: lengths need no common size
        wanted = sorted(a.length * b.length for a, b in product(*curves))
        np.testing.assert_allclose(sorted(one.area for one in found), wanted, rtol=0.01)


def test_sheets_that_cross_go_straight_on():
    flat, bar = library.parallelogram(), library.four_bar()
    surface = trace_surface(beside(flat, bar))
    assert surface.genus == 1
    np.testing.assert_allclose(surface.area, mo.trace_motion(flat).length * mo.trace_motion(bar).length, rtol=0.01)
    crossing = mo.trace_motion(flat).branch_points
    angle = np.angle(np.exp(1j * (surface.branch_points[:, None, :4] - crossing)))
    nearest = np.abs(angle).max(axis=-1)
    assert len(crossing) == 2
    assert set(nearest.argmin(axis=1).tolist()) == {0, 1}
    assert nearest.min(axis=1).max() < 1e-5


def ball_of(flat):
    """The last joint of a linkage as a ball."""
    return replace(flat.joints[-1], kind=mo.linkages.Kind.SPHERICAL)


@pytest.mark.capability("02-60")
def test_a_pentagon_closed_by_a_ball_has_the_topology_of_the_theorem():
    flat = polygon([1.0] * 5)
    surface = trace_surface(Linkage.of([*flat.joints[:-1], ball_of(flat)]))
    assert pentagon_numbers([1.0] * 5) == (1, surface.euler_characteristic)
    assert surface.left_out == ("J4",)
    assert "J4" in surface.explain("en").split("\n")[1]


@pytest.mark.capability("02-60")
def test_rods_between_balls_keep_their_length():
    """An ankle in closed form: with the foot anywhere each crank has two places, so there are four tori."""
    ankle = mo.read_linkage("examples/linkages/ankle.toml")
    found = mo.configuration_surfaces(ankle, starts=24)
    assert [one.genus for one in found] == [1] * 4
    assert all(
        set(one.left_out) == {f"{s} {e} ball" for s in ("left", "right") for e in ("upper", "lower")} for one in found
    )
    tilt = np.random.default_rng(0).uniform(-np.pi, np.pi, (40, 2))
    foot = Rotation.from_rotvec(tilt[:, :1] * [1, 0, 0]) * Rotation.from_rotvec(tilt[:, 1:] * [0, 1, 0])
    cranks = []
    for y in (0.15, -0.15):
        ball = foot.apply([0.2, y, 0.0]) - [0, y, 1]
        # The pin (cos a, 0, -sin a) / 2 is at the root of 1.09 from the ball: cos(a - middle) = reach / far.
        far, reach = np.hypot(ball[:, 0], ball[:, 2]), (np.sum(ball**2, axis=1) + 0.25 - 1.09)
        cranks.append((np.arctan2(-ball[:, 2], ball[:, 0]), np.arccos(reach / far)))
    for signs in product((1, -1), repeat=2):
        turns = [middle + sign * half for sign, (middle, half) in zip(signs, cranks, strict=True)]
        on = np.stack([one.holds(np.column_stack([tilt, *turns])) for one in found])
        assert (on.sum(axis=0) == 1).all()
        assert on.all(axis=1).sum() == 1


def test_balls_left_out_leave_the_mobility_but_for_spins():
    for linkage, spins in ((library.three_rps(), 0), (library.rssr(), 1), (library.three_prs(), 0)):
        simple = without_balls(linkage)
        assert mo.instantaneous_mobility(simple).mobility == mo.instantaneous_mobility(linkage).mobility - spins
        kept = np.concatenate([linkage.columns_of([each.name]) for each in simple.joints])
        near = 0.1 * np.random.default_rng(0).normal(size=(5, linkage.coordinates))
        whole = mo.linkages.close_loops_near(linkage, near)
        assert whole
        assert mo.linkages.close_loops_near(simple, whole.theta[:, kept], steps=0).gap.max() < 1e-9
        A, h = mo.linkages.loop_matrix(simple, near[0, kept]), 1e-6 * np.eye(simple.coordinates)
        u = mo.linkages.loop_closure.units(simple)
        gaps = [mo.linkages.loop_closure.loop_state(simple, near[0, kept] + sign * h * u).gap for sign in (1, -1)]
        assert np.abs((gaps[0] - gaps[1]).T / 2e-6 - A)[6 * simple.loops :].max() < 1e-8


def table_on_cranks(radius):
    """A table on four balls at the ends of cranks that stay parallel, with a spindle: circle times circle."""
    cranks = [
        each
        for k, (x, y) in enumerate(((0, 0), (1, 0.2), (1.2, 1.1), (-0.1, 0.9)))
        for each in (
            joint(f"R{k}", "R", ["ground", f"crank {k}"], [x, y, 0]),
            joint(f"S{k}", "S", [f"crank {k}", "table"], [x + radius, y, 0]),
        )
    ]
    return Linkage.of([*cranks, joint("spindle", "R", ["table", "tool"], [0.3, 0.3, 0], [0.3, 0.5, 0.6])])


@pytest.mark.capability("02-60")
def test_a_body_on_four_balls_stands_by_three_points():
    surface = trace_surface(table_on_cranks(0.4))
    assert surface.genus == 1
    around = 2 * np.pi * np.hypot(2, 0.4 / surface.linkage.size)
    np.testing.assert_allclose(surface.area, 2 * np.pi * around, rtol=1e-3)
    assert surface.left_out == ("S0", "S1", "S2", "S3")
    assert "coordinates of table" in surface.explain("en").split("\n")[2]
    whole = table_on_cranks(0.4)
    start = np.zeros(whole.coordinates)
    start[[*whole.columns_of(["R0", "R1", "R2", "R3"]), *whole.columns_of(["S0"])[2:]]] = [0.3] * 4 + [-0.3]
    start[whole.columns_of(["spindle"])] = 1.0
    assert surface.holds(without_balls_at(whole, start)).all()
    assert trace_surface(whole, start, points=20).charts.points[0] @ np.eye(surface.linkage.coordinates)[4] == 1.0


@pytest.mark.capability("02-60")
def test_a_floating_rod_spins_on_a_circle_bundle():
    bars = library.rssr()
    free = Linkage.of([*bars.joints, joint("F", "F", ["ground", "coupler"])])
    assert mo.instantaneous_mobility(free).mobility == 2
    (torus,) = mo.configuration_surfaces(free, starts=12)
    assert torus.genus == 1
    A, B, C, D = (each.point for each in bars.joints)
    crank = Rotation.from_rotvec(torus.theta[:, :1] * bars.joints[0].axis).apply(B - A) + A
    rocker = Rotation.from_rotvec(-torus.theta[:, 1:2] * bars.joints[3].axis).apply(C - D) + D
    corners = torus.theta[:, 2:].reshape(-1, 3, 3) + torus.linkage.joints[2].corners
    np.testing.assert_allclose(corners.mean(axis=1), (crank + rocker) / 2, atol=1e-9)


def test_the_platform_of_a_delta_of_rods_is_where_its_closed_form_says():
    delta, q, joints = mf.parallel.DeltaRobot(0.3, 0.1, 0.4, 0.8), np.full(3, 0.3), []
    height = delta.forward_kinematics(q).x[0]
    for k, (u, elbow) in enumerate(zip(delta.directions, delta.elbows(q), strict=True)):
        across = np.cross([0, 0, 1], u)
        joints.append(joint(f"M{k}", "R", ["ground", f"arm {k}"], delta.base * u, across))
        for side in (-0.05, 0.05):
            low = height + delta.platform * u + side * across
            ends = elbow + low - height, low
            joints.append(joint(f"A{k}{side}", "S", [f"arm {k}", f"rod {k}{side}"], ends[0]))
            joints.append(joint(f"B{k}{side}", "S", [f"rod {k}{side}", "platform"], ends[1]))
    robot = without_balls(Linkage.of(joints))
    assert mo.instantaneous_mobility(robot).mobility == 3
    start = 0.1 * np.random.default_rng(5).normal(size=(20, robot.coordinates)) * mo.linkages.loop_closure.units(robot)
    found = mo.linkages.close_loops_near(robot, start)
    assert found
    places = found.theta[:, 3:].reshape(-1, 3, 3)
    np.testing.assert_allclose(places - places.mean(axis=1, keepdims=True), 0.0, atol=1e-9)
    np.testing.assert_allclose(
        places.mean(axis=1) + height, delta.forward_kinematics(q + found.theta[:, :3]).x[:, 0], atol=1e-8
    )


@pytest.mark.parametrize(("lengths", "places"), [((1, 1, 1, 1, 2), 4), ((1, 2, 3, 1, 1), 3)])
def test_links_on_one_line_pinch_the_surface(lengths, places):
    surface = trace_surface(polygon(lengths))
    assert surface.status is SurfaceStatus.PINCHED
    assert (len(surface.singular_points), surface.openings) == (places, 2 * places)
    longer = np.array(lengths, dtype=float)
    longer[longer.argmax()] += 0.1
    assert pentagon_numbers(longer) == (1, surface.euler_characteristic)
    assert surface.genus is None
    for theta in surface.singular_points:
        assert mo.instantaneous_mobility(surface.linkage, theta).mobility == 3
        poses = mo.linkages.body_poses(surface.linkage, theta)
        pins = [
            mo.linkages.loop_closure.pose.act(T, each.point)
            for T, each in zip(poses, surface.linkage.joints, strict=True)
        ]
        assert np.linalg.svd(np.array(pins) - pins[0])[1][1] < 1e-6


@pytest.mark.capability("02-60")
def test_planar_platform_with_one_motor_locked():
    linkage = mo.linkages.lock_joints(library.three_rrr(), ["A0"])
    coarse, fine = trace_surface(linkage), trace_surface(linkage, step=0.2)
    assert coarse.status is fine.status is SurfaceStatus.CLOSED
    assert coarse.euler_characteristic == fine.euler_characteristic
    assert coarse.holds(fine.theta[::40]).all()
    np.testing.assert_allclose(coarse.area, fine.area, rtol=0.01)


def test_what_does_not_end_is_open():
    table = Linkage.of([joint("X", "P", ["ground", "a"], axis=[1, 0]), joint("Y", "P", ["a", "b"], axis=[0, 1])])
    surface = trace_surface(table, points=200)
    assert surface.status is SurfaceStatus.OPEN
    assert surface.euler_characteristic is None is surface.genus
    assert trace_surface(library.five_bar(), points=100).status is SurfaceStatus.OPEN
    assert (
        mo.configuration_surfaces(mo.linkages.lock_joints(library.five_bar(), ["O"]), starts=8).status.name
        == "NOT_FOUND"
    )


def test_refusals_say_what_helps():
    with pytest.raises(mf.InputError, match="mobility by rank is 1"):
        trace_surface(library.four_bar())
    with pytest.raises(mf.InputError, match="mobility by rank is 1"):
        trace_surface(library.rssr())
    with pytest.raises(mf.InputError, match="mobility by rank is 6"):
        trace_surface(library.six_ups())
    with pytest.raises(mf.InputError, match="mobility by rank is 6"):
        trace_surface(Linkage.of([joint("F", "F", ["ground", "body"])]))
    rods = [("A", "ground", "rod", [0, 0]), ("B", "rod", "next", [1, 0]), ("C", "next", "ground", [1, 1])]
    with pytest.raises(mf.ModelError, match="next is a rod between two balls, such as B"):
        trace_surface(Linkage.of([joint(name, "S", [a, b], at) for name, a, b, at in rods]))
    left = trace_surface(Linkage.of([*polygon([1.0] * 5).joints[:-1], ball_of(polygon([1.0] * 5))]), points=20).linkage
    for judge in (
        mf.mobility,
        mo.gruebler,
        mo.finite_mobility,
        mo.redundant_constraints,
        mo.structure,
        mo.linkages.split_joints,
    ):
        with pytest.raises(mf.ModelError, match="J4"):
            judge(left)


TORUS = np.sort([[k, (k + a) % 7, (k + 3) % 7] for k in range(7) for a in (1, 2)], axis=1)
PROJECTIVE = np.array(
    [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 1, 5], [1, 2, 4], [2, 4, 5], [2, 3, 5], [1, 3, 5], [1, 3, 4]]
)


def test_triangles_of_known_surfaces():
    assert is_closed(TORUS, 7)
    assert is_orientable(TORUS)
    assert is_closed(PROJECTIVE, 6)
    assert not is_orientable(PROJECTIVE)
    assert 7 - len(edges(TORUS)[0]) + len(TORUS) == 0
    assert 6 - len(edges(PROJECTIVE)[0]) + len(PROJECTIVE) == 1
    assert not is_closed(TORUS[1:], 7)
    assert not is_closed(np.concatenate([TORUS, PROJECTIVE + 7]), 13)
    pinched = np.concatenate([PROJECTIVE, np.sort(np.where(PROJECTIVE > 0, PROJECTIVE + 5, 0), axis=1)])
    assert not is_closed(pinched, 11)
    left, rim, openings = trim_openings(TORUS, {0})
    assert (len(left), len(rim), openings) == (8, 6, 1)
    assert trim_openings(pinched, {0})[2] == 2


def test_cells_are_cut_and_keep_their_owners():
    cell = open_cell(2.0)
    for k in range(6):
        a, b = np.cos(np.pi * k / 3), np.sin(np.pi * k / 3)
        cell = cut(cell, a, b, 0.5, k)
    assert sorted(owners(cell)) == list(range(6))
    np.testing.assert_allclose(farthest(cell)[0], 1 / np.sqrt(3), rtol=1e-12)
    assert cut(cell, 1.0, 0.0, 5.0, 9) is cell
    assert not cut(cell, 1.0, 0.0, -5.0, 9)
