"""Platforms on legs of screws: both ways, rates, statics, idle freedoms, special platforms, against closed forms."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares

from mafsil import mobility as mo
from mafsil import parallel as pa
from mafsil.errors import InputError
from mafsil.geometry import pose, rotation


def stewart():
    return pa.StewartPlatform.on_circles(
        2.0, 1.0, np.radians([-15, 15, 105, 135, 225, 255]), np.radians([-45, 45, 75, 165, 195, 285])
    )


HOME = pose.from_translation([0.1, -0.2, 1.6])


@pytest.mark.capability("08-29", "08-31", "08-34", "08-46")
def test_legs_of_screws_are_the_platform_of_distances():
    robot, rng = stewart(), np.random.default_rng(0)
    legs = pa.stewart_legs(robot, HOME)
    change = 0.1 * rng.normal(size=(20, 6))
    found = pa.leg_forward(legs, change)
    assert found
    wanted = robot.forward_near(robot.lengths(HOME) + change, HOME)
    np.testing.assert_allclose(found.T, wanted.T, atol=1e-9)
    np.testing.assert_allclose(robot.lengths(found.T), robot.lengths(HOME) + change, atol=1e-10)
    for q in found.q[:3]:
        T = legs.legs[0].pose(q[:6])
        np.testing.assert_allclose(legs.jacobian(q) @ robot.jacobian(T), np.eye(6), atol=1e-9)


@pytest.mark.capability("08-32", "08-35")
def test_inverse_of_every_leg():
    robot, rng = stewart(), np.random.default_rng(1)
    legs = pa.stewart_legs(robot, HOME)
    T = HOME @ pose.exp(0.2 * rng.normal(size=(15, 6)))
    found = pa.leg_inverse(legs, T)
    assert found
    np.testing.assert_allclose(found.q[:, list(legs.driven)], robot.lengths(T) - robot.lengths(HOME), atol=1e-9)
    np.testing.assert_allclose(legs.poses(found.q), np.repeat(T[:, None], 6, axis=1), atol=1e-8)
    again = pa.leg_forward(legs, found.q[:, list(legs.driven)], found.q)
    np.testing.assert_allclose(again.T, T, atol=1e-8)


@pytest.mark.capability("08-33", "08-64")
def test_poses_and_twists_that_three_legs_cannot_follow():
    legs = pa.three_rps(1.0, 0.5, 1.0)
    there = pa.leg_forward(legs, [0.1, -0.05, 0.15])
    found = pa.leg_inverse(legs, there.T, there.q + 0.05)
    assert found
    away = there.T @ pose.exp([0, 0, 0.2, 0, 0, 0])
    missed = pa.leg_inverse(legs, away, there.q)
    assert not missed
    assert missed.status is pa.legs.leg_configurations.ConfigurationStatus.NOT_FOUND
    assert missed.gap > 1e-3
    assert "misses" in missed.explain("en")
    V = legs.jacobian(there.q) @ [0.3, -0.2, 0.1]
    rates = pa.legs.inverse_rates(legs, there.q, V)
    assert rates.feasible
    np.testing.assert_allclose(rates.rates[list(legs.driven)], [0.3, -0.2, 0.1], atol=1e-9)
    np.testing.assert_allclose(legs.loop_matrix(there.q) @ rates.rates, 0, atol=1e-9)
    turn = pa.legs.inverse_rates(legs, there.q, [0, 0, 1, 0, 0, 0])
    assert not turn
    assert turn.status is pa.legs.leg_statics.LegRatesStatus.NOT_FEASIBLE
    assert "cannot follow" in turn.explain("en")
    assert np.abs(turn.residual).max() > 0.1
    np.testing.assert_allclose(np.linalg.pinv(legs.jacobian(there.q)) @ V, [0.3, -0.2, 0.1], atol=1e-9)


@pytest.mark.capability("08-37", "08-63")
@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000))
def test_power_of_the_motors_is_that_of_the_platform(seed):
    rng = np.random.default_rng(seed)
    legs = pa.three_rps(*rng.uniform(0.5, 1.5, 3))
    there = pa.leg_forward(legs, rng.uniform(-0.1, 0.1, 3))
    assume(there)
    J, F = legs.jacobian(there.q), rng.normal(size=6)
    forces = pa.leg_forces(legs, there.q, F)
    np.testing.assert_allclose(forces.efforts, J.T @ F, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(forces.leg_wrenches.sum(axis=0), F, atol=1e-9)
    for k, part in enumerate(legs.parts):
        carried = legs.leg_jacobians(there.q)[k].T @ forces.leg_wrenches[k]
        driven = [i - part.start for i in legs.driven if part.start <= i < part.stop]
        np.testing.assert_allclose(np.delete(carried, driven), 0, atol=1e-8)
    rate = rng.normal(size=3)
    assert forces.efforts @ rate == pytest.approx(F @ (J @ rate), rel=1e-6, abs=1e-6)


@pytest.mark.capability("08-4", "08-5", "08-65")
def test_under_exact_and_redundant():
    legs = pa.three_rps(1.0, 0.5, 1.0)
    q = pa.leg_forward(legs, [0.1, -0.05, 0.15]).q
    exact, under, over = (legs.with_driven(*driven).rates(q) for driven in ((1, 6, 11), (1, 6), (1, 6, 11, 0)))
    assert (exact.actuation, under.actuation, over.actuation) == ("exact", "under", "redundant")
    assert exact.regular
    assert under.free.shape[1] == 1
    assert over.forbidden.shape == (4, 1)
    assert not over.independent
    redundant = legs.with_driven(1, 6, 11, 0)
    for rate in over.admissible.T:
        np.testing.assert_allclose(redundant.jacobian(q) @ rate, legs.jacobian(q) @ rate[:3], atol=1e-9)
        np.testing.assert_allclose(redundant.jacobian(q, 1) @ rate, legs.jacobian(q) @ rate[:3], atol=1e-9)
    F = np.array([0.1, -0.2, 0.3, 1.0, 2.0, -9.0])
    shared = pa.leg_forces(redundant, q, F)
    assert shared.possible
    assert not shared.unique
    np.testing.assert_allclose(shared.leg_wrenches.sum(axis=0), F, atol=1e-9)
    assert shared.status is pa.legs.leg_statics.LegForcesStatus.SHARED
    assert "load each other" in shared.explain("en")
    statuses = [each.status for each in (exact, under, over)]
    assert statuses == [
        pa.closure.DrivenStatus.REGULAR,
        pa.closure.DrivenStatus.FREE,
        pa.closure.DrivenStatus.FORBIDDEN,
    ]
    assert "break" in over.explain("en")
    alone = pa.leg_forces(legs.with_driven(1, 6), q, F)
    assert not alone.possible
    with pytest.raises(InputError, match="1 motions are left"):
        legs.with_driven(1, 6).jacobian(q)
    order = legs.with_driven(11, 1, 6)
    np.testing.assert_allclose(order.jacobian(q), legs.jacobian(q)[:, [2, 0, 1]], atol=1e-12)


@pytest.mark.capability("08-18", "08-51", "08-62")
def test_the_additional_freedoms_of_three_upu():
    radial = pa.three_upu(1.0, 0.5, 2.0)
    H = radial.loop_matrix(np.zeros(15))
    assert radial.counted_mobility == 3
    assert np.linalg.matrix_rank(H, 1e-9) == 10
    found = radial.singularity(np.zeros(15))
    assert not found
    assert found.rank == 10
    same = pa.three_upu(1.0, 1.0, 2.0, "tangent").loop_matrix(np.zeros(15))
    assert np.linalg.matrix_rank(same, 1e-9) == 10
    regular = pa.three_upu(1.0, 0.5, 2.0, "tangent")
    assert np.linalg.matrix_rank(regular.loop_matrix(np.zeros(15)), 1e-9) == 12
    assert mo.mobility(mo.library.three_upu("radial")).mobility >= 3


@pytest.mark.capability("08-53", "08-60")
def test_a_stewart_platform_at_a_quarter_turn_is_singular():
    T = pose.from_translation([0, 0, 1.5])
    T[:3, :3] = rotation.rot_z(np.pi / 2)
    legs = pa.stewart_legs(stewart(), T)
    found = legs.singularity(np.zeros(legs.n))
    assert found.status is pa.LoopSingularity.NONDEGENERATE
    with pytest.raises(InputError, match="do not decide the motion of the platform"):
        legs.jacobian(np.zeros(legs.n))
    assert found.to_dict()["rank"] == 30
    assert "shaky" in found.explain("en")


@pytest.mark.capability("08-9")
def test_motion_simulator_follows_a_trajectory():
    robot, rng = stewart(), np.random.default_rng(2)
    screw, h = rng.normal(size=6) * 0.3, 1e-4
    t = np.linspace(0, 1, 7)

    def along(t):
        return pose.exp(screw * np.sin(t)[:, None]) @ HOME

    V, Vd = screw * np.cos(t)[:, None], -screw * np.sin(t)[:, None]
    ahead, here, behind = (robot.lengths(along(t + k * h)) for k in (1, 0, -1))
    np.testing.assert_allclose(robot.leg_rates(along(t), V), (ahead - behind) / (2 * h), atol=1e-7)
    second = (ahead - 2 * here + behind) / h**2
    np.testing.assert_allclose(robot.leg_accelerations(along(t), V, Vd), second, atol=1e-6)


@pytest.mark.capability("08-14")
def test_a_planar_platform_is_a_flat_stewart_platform():
    rng = np.random.default_rng(3)
    a, b = rng.normal(size=(2, 3, 2))
    flat = pa.PlanarThreeRPR(a, b)
    solid = pa.StewartPlatform(np.pad(np.vstack([a, a]), ((0, 0), (0, 1))), np.pad(np.vstack([b, b]), ((0, 0), (0, 1))))
    x = np.array([0.4, -0.3, 0.7])
    T = pose.from_translation([0.4, -0.3, 0])
    T[:3, :3] = rotation.rot_z(0.7)
    np.testing.assert_allclose(solid.lengths(T)[:3], flat.lengths(x), atol=1e-14)
    np.testing.assert_allclose(solid.jacobian(T)[:3, [2, 3, 4]], flat.jacobian(x), atol=1e-14)


@pytest.mark.capability("08-19", "08-48")
def test_the_curve_of_a_four_bar_and_the_surface_of_a_five_bar():
    theta = np.linspace(0, 2 * np.pi, 2001)
    phi, every, missing = pa.planar.output_angles(mo.FourBar(4, 4, 3, 2), theta)
    assert not every.any()
    assert not missing.any()
    gap = np.abs(np.angle(np.exp(1j * (phi[:, 0] - phi[:, 1]))))
    assert gap.min() == pytest.approx(1.268, abs=1e-3)
    slope = np.gradient(np.unwrap(phi[:, 0]), theta)[1:-1]
    assert (slope.min(), slope.max()) == pytest.approx((0.3323, 2.2397), abs=2e-3)
    tips = 4 * np.exp(1j * theta)[:, None] - 2 - 3 * np.exp(1j * phi)
    np.testing.assert_allclose(np.abs(tips), 4, atol=1e-12)
    robot = pa.FiveBar(2, 3, 3, 2, 2)
    q = np.stack(np.meshgrid(np.linspace(-3, 3, 30), np.linspace(-3, 3, 30)), axis=-1)
    for mode in (0, 1):
        surface, off = robot.chain_angles(q, mode), robot.forward_kinematics(q).missing
        assert (off == 0.0).any()
        # Two rods that point at each other share their gap: it is the root of two times the distance of their lengths.
        gap = np.linalg.norm(robot.chain.closure(surface[..., :4]), axis=-1)
        np.testing.assert_allclose(gap, np.sqrt(2) * off, atol=1e-12)


@pytest.mark.capability("08-54", "08-42")
def test_second_order_of_any_legs_is_a_difference():
    """Along motions that the loops leave to first order: d/dt (H q') with q' held, for legs of several kinds."""
    h = 1e-5
    for legs, q in (
        (pa.three_rps(1.0, 0.5, 1.0), pa.leg_forward(pa.three_rps(1.0, 0.5, 1.0), [0.1, -0.05, 0.15]).q),
        (pa.stewart_legs(stewart(), HOME), np.zeros(36)),
        (pa.three_upu(1.0, 0.5, 2.0), np.zeros(15)),
    ):
        K, H = legs.curvature(q), legs.loop_matrix(q)
        assert np.abs(K - np.swapaxes(K, 1, 2)).max() < 1e-15
        motions = np.linalg.svd(H)[2][np.linalg.matrix_rank(H, 1e-9) :]
        for v in (*motions, motions.sum(axis=0)):
            bend = (legs.loop_matrix(q + h * v) - legs.loop_matrix(q - h * v)) @ v / (2 * h)
            np.testing.assert_allclose(np.einsum("rij,i,j->r", K, v, v), bend, atol=1e-8)


@pytest.mark.capability("08-12", "08-61")
def test_rods_of_an_eclipse_reach_from_its_blocks_to_its_platform():
    robot = pa.Eclipse(1.3, 1.2, 0.35)
    T = pose.from_translation([0.1, -0.05, 1.0]) @ pose.exp([0.1, 0.2, 0.3, 0, 0, 0])
    feet = robot.feet(T)
    np.testing.assert_allclose(np.hypot(feet[:, 0], feet[:, 1]), 1.3, rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(robot.platform_joints(T) - feet, axis=1), 1.2, rtol=1e-12)
    # Across the axis these rods are too short; of a narrow guide all four solutions of each leg are there.
    short = robot.rod_misfit(T, far=True)
    joints = np.linalg.norm(robot.platform_joints(T)[:, :2], axis=1)
    np.testing.assert_allclose(short, 1.3 + joints - 1.2, rtol=1e-12)
    with pytest.raises(InputError, match=f"leg {short.argmax() + 1} is {short.max():.4g} m too short"):
        robot.inverse_kinematics(T, far=True)
    narrow = pa.Eclipse(0.4, 1.2, 0.35)
    heights = set()
    for upper in (False, True):
        for far in (False, True):
            found = narrow.inverse_kinematics(T, upper=upper, far=far)
            block = np.column_stack([0.4 * np.cos(found[:, 0]), 0.4 * np.sin(found[:, 0]), found[:, 1]])
            np.testing.assert_allclose(np.linalg.norm(block - narrow.platform_joints(T), axis=1), 1.2, rtol=1e-12)
            heights.add(float(found[0, 1]))
    assert len(heights) == 4


@pytest.mark.capability("08-53", "08-60")
@pytest.mark.parametrize("size", [1e-3, 1e3])
def test_what_is_singular_does_not_depend_on_units(size):
    q = pa.leg_forward(pa.three_rps(1.0, 0.5, 1.0), [0.1, -0.05, 0.15]).q
    quarter = pose.from_translation([0, 0, 1.5])
    quarter[:3, :3] = rotation.rot_z(np.pi / 2)
    larger = quarter.copy()
    larger[:3, 3] *= size
    robot = stewart()
    cases = (
        (pa.three_rps(1.0, 0.5, 1.0), pa.three_rps(size, 0.5 * size, size), q),
        (pa.three_upu(1.0, 0.5, 2.0), pa.three_upu(size, 0.5 * size, 2 * size), np.zeros(15)),
        (
            pa.stewart_legs(robot, quarter),
            pa.stewart_legs(pa.StewartPlatform(size * robot.base, size * robot.platform), larger),
            np.zeros(36),
        ),
    )
    for metres, scaled, at in cases:
        slides = np.concatenate([np.linalg.norm(leg.screws[:, :3], axis=1) == 0 for leg in metres.legs])
        found, other = metres.singularity(at), scaled.singularity(np.where(slides, size, 1.0) * at)
        assert (found.status, found.rank) == (other.status, other.rank)
    some = pa.leg_forward(pa.three_rps(1.0, 0.5, 1.0), [[0.1, -0.05, 0.15], [5.0, -1.0, 0.0]])
    assert some.status is pa.legs.leg_configurations.ConfigurationStatus.SOME


def test_wrong_input_is_refused():
    legs = pa.three_rps(1.0, 0.5, 1.0)
    with pytest.raises(InputError, match="driven"):
        legs.with_driven(1, 1)
    with pytest.raises(InputError, match="driven"):
        legs.with_driven(15)
    with pytest.raises(InputError, match="legs"):
        pa.LegMechanism(legs.legs[:1], (0,))
    with pytest.raises(InputError, match="screws"):
        pa.Leg(np.zeros((5, 3)), np.eye(4))
    with pytest.raises(InputError, match="transpose"):
        pa.Leg(np.zeros((6, 3)), np.eye(4))
    with pytest.raises(InputError, match="q_driven"):
        pa.leg_forward(legs, [np.nan, 0, 0])
    with pytest.raises(InputError, match="lengths"):
        pa.PlanarChain([1.0, -1.0, 1.0])
    far = pa.leg_forward(legs, [5.0, -1.0, 0.0])
    assert not far
    assert np.isfinite(far.q).all()


@pytest.mark.capability("08-42", "08-51", "08-60")
def test_nothing_is_said_of_configurations_that_do_not_close():
    legs, open_ = pa.three_rps(1.0, 0.5, 1.0), np.full(15, 0.2)
    five = pa.FiveBar(1, 1.2, 1.1, 0.9, 1.5)
    asked = (
        legs.singularity, legs.rates, legs.jacobian, lambda q: pa.leg_forces(legs, q, np.ones(6)),
        lambda q: pa.legs.inverse_rates(legs, q, np.ones(6)), lambda q: pa.legs.reduced_equations(legs, q),
        lambda q: five.singularity(q[:4]), lambda q: pa.ParallelCranks(0.7, [0, 1.2]).singularity([1.0, 0.0, 0.5]),
    )  # fmt: skip
    for function in asked:
        with pytest.raises(InputError, match="does not close the loops"):
            function(open_)


@pytest.mark.capability("08-51")
def test_the_rank_of_most_configurations_is_found():
    """Planar legs ask 6 of 12 rows wherever they are: not singular; three radial UPU legs at home are."""
    places = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    tops = [[0.4, 0.9, 0], [0.8, 0.9, 0], [0.5, 1.3, 0]]
    screws: list[np.ndarray] = []
    for a, b in zip(places, tops, strict=True):
        along = np.subtract(b, a) / np.linalg.norm(np.subtract(b, a))
        screws.append(np.stack([[0, 0, 1, a[1], -a[0], 0], [0, 0, 0, *along], [0, 0, 1, b[1], -b[0], 0]]))
    planar = pa.LegMechanism(pa.legs_from_screws(screws, pose.from_translation([0.5, 1, 0])), (1, 4, 7))
    assert planar.generic_rank(np.zeros(9)) == 6
    assert planar.singularity(np.zeros(9))
    radial = pa.three_upu(1.0, 0.5, 2.0, "radial")
    found = radial.singularity(np.zeros(radial.n))
    assert (found.rank, found.full_rank) == (10, 12)


@pytest.mark.capability("08-28")
def test_legs_that_lie_flat_are_not_lost():
    """tan(th / 2) is infinite there; and lengths that do not fit say how far the sides of the platform are off."""
    flat = pa.ThreeRPS(1.0, 2.0).forward_kinematics([1.0, 1.0, 1.0])
    assert flat.status is pa.platforms.three_rps_forward.ThreeRPSStatus.SOME
    np.testing.assert_allclose(np.abs(flat.theta), np.pi, atol=1e-5)
    robot = pa.ThreeRPS(1.0, 0.5)
    missed = robot.forward_kinematics([0.1, 0.1, 3.0])
    assert missed.status is pa.platforms.three_rps_forward.ThreeRPSStatus.NONE
    rng, pairs = np.random.default_rng(0), ((0, 1), (0, 2), (1, 2))

    def sides(theta):
        B = robot.joints([0.1, 0.1, 3.0], theta)
        return [np.linalg.norm(B[i] - B[j]) - 0.5 * np.sqrt(3) for i, j in pairs]

    fits = [least_squares(sides, start).cost for start in rng.uniform(-np.pi, np.pi, (12, 3))]
    assert np.linalg.norm(missed.misfit) == pytest.approx(np.sqrt(2 * min(fits)), rel=1e-6)
    with pytest.raises(InputError, match="negative"):
        robot.forward_kinematics([-0.1, 1, 1])
    assert pa.platforms.resultant([6, -5, 1], [-2, 1]) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.capability("08-55", "08-56", "08-57")
def test_other_motors_that_decide_the_platform_are_found_past_idle_rods():
    """Against the null space of every choice; rods that spin idly spoil none."""
    rods = pa.stewart_legs(stewart(), HOME, "S")
    sliders = [3, 10, 17, 24, 31, 38]
    zero, among = np.zeros(rods.n), [*sliders, 0, 1, 2]
    expected, J, H = [], rods.leg_jacobians(zero)[0], rods.loop_matrix(zero)
    for driven in combinations(sorted(among), 6):
        passive = np.delete(np.arange(rods.n), driven)
        _, s, right = np.linalg.svd(H[:, passive])
        motions = np.zeros((rods.n, rods.n - 6 - int((s > 1e-8 * s[0]).sum())))
        motions[passive] = right[int((s > 1e-8 * s[0]).sum()) :].T
        if np.abs(J @ motions[rods.parts[0]]).max() < 1e-8:
            expected.append(driven)
    assert rods.choose_actuators(zero, 6, sorted(among)) == tuple(expected)
    assert tuple(sliders) in expected
    assert len(expected) < 84
    radial = pa.three_upu(1.0, 0.5, 2.0, "radial")
    assert radial.choose_actuators(np.zeros(radial.n)) == ()
    with pytest.raises(InputError, match="give fewer joints"):
        rods.choose_actuators(zero)
