"""Accelerations, all screws, kinds of displacements, helices, units, axis triples, charts, vehicles, lines."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.geometry import (
    acceleration,
    axis_triples,
    euler,
    length_units,
    planar,
    pose,
    relative_motion,
    rotation,
    screw,
    twist,
    vehicle,
    wrench,
)
from mafsil.geometry.frames import CameraScene
from mafsil.geometry.logarithms import screws
from mafsil.geometry.points import common_normal
from mafsil.geometry.representations import POSE_CHARTS, convert
from mafsil.geometry.screw import DisplacementKind, classify, helix


def motion(t):
    return pose.exp(np.array([0.3 * t, -0.2 + t**2, 0.5 * t, t**2, 0.4 * t, -0.3 * t**3])) @ pose.exp(
        [0.1, 0.2 * t, 0, 0.5, 0, t]
    )


def rates(t, h=1e-4):
    """T, Tdot, Tddot by central differences."""
    before, now, after = motion(t - h), motion(t), motion(t + h)
    return now, (after - before) / (2 * h), (after - 2 * now + before) / h**2


@pytest.mark.capability("04-116")
def test_accelerations_of_frames_and_points():
    h = 1e-5
    T, Tdot, Tddot = rates(0.7)
    dV_s, dV_b = acceleration.space_from_pose_rates(T, Tdot, Tddot), acceleration.body_from_pose_rates(T, Tdot, Tddot)
    twists = [twist.space_from_pose_rate(*rates(0.7 + s)[:2]) for s in (-h, h)]
    np.testing.assert_allclose(dV_s, (twists[1] - twists[0]) / (2 * h), atol=2e-5)
    np.testing.assert_allclose(dV_s, twist.transform(T, dV_b), atol=1e-6)
    np.testing.assert_allclose(T[:3, :3] @ dV_b[:3], dV_s[:3], atol=1e-6)
    V_s, V_b = twist.space_from_pose_rate(T, Tdot), twist.body_from_pose_rate(T, Tdot)
    for mark in np.eye(3):
        place = pose.act(T, mark)
        want = (Tddot @ [*mark, 1.0])[:3]
        np.testing.assert_allclose(acceleration.of_point(V_s, dV_s, place), want, atol=1e-6)
        np.testing.assert_allclose(T[:3, :3] @ acceleration.of_point(V_b, dV_b, mark), want, atol=1e-6)
    origin = acceleration.of_point(V_b, dV_b, np.zeros(3))
    np.testing.assert_allclose(origin, dV_b[3:] + np.cross(V_b[:3], V_b[3:]), atol=1e-12)
    np.testing.assert_allclose(T[:3, :3] @ origin, Tddot[:3, 3], atol=1e-6)
    np.testing.assert_allclose(acceleration.pose_second_rate(T, V_b, dV_b), Tddot, atol=1e-6)


@pytest.mark.capability("04-117")
def test_all_screws_of_a_displacement():
    rng = np.random.default_rng(0)
    for _ in range(20):
        T = pose.exp(np.concatenate([rng.uniform(-1.5, 1.5, 3), rng.normal(size=3)]))
        found = screws(T, -4 * np.pi, 4 * np.pi)
        assert len(found) == 8
        lines = []
        for each in found:
            np.testing.assert_allclose(screw.displacement(each.screw, each.amount), T, atol=1e-11)
            advance = each.pitch * each.amount * np.sign(each.screw[:3] @ found[0].screw[:3])
            lines.append([*screw.nearest_point(each.screw), advance])
        np.testing.assert_allclose(lines, np.broadcast_to(lines[0], np.shape(lines)), atol=1e-9)
    slide = screws(pose.from_translation([0, 0, 2.0]), 0.0, 4 * np.pi)
    assert [each.any_line for each in slide] == [False, True, True, True, True]
    for each in slide:
        S = each.screw.copy()
        if each.any_line:
            S = twist.transform(pose.from_translation([0.7, -0.4, 0]), S)
            assert abs(each.pitch) == pytest.approx(2.0 / each.amount)
        np.testing.assert_allclose(screw.displacement(S, each.amount), pose.from_translation([0, 0, 2.0]), atol=1e-12)
    assert all(each.any_axis for each in screws(np.eye(4), 0.0, 2 * np.pi))


@pytest.mark.capability("04-118", "04-119")
def test_relative_motion_and_resultants():
    T_ab, T_bc = motion(0.3), motion(0.8)
    V_ab, V_bc = np.array([0.2, -0.1, 0.4, 1, 0.5, -0.3]), np.array([-0.3, 0.6, 0.1, -0.2, 0.4, 0.7])
    h = 1e-6
    moved = [pose.exp(s * h * V_ab) @ T_ab @ pose.exp(s * h * V_bc) @ T_bc for s in (-1, 1)]
    seen = pose.log(moved[1] @ pose.inverse(moved[0])) / (2 * h)
    np.testing.assert_allclose(relative_motion.space(V_ab, T_ab, V_bc), seen, atol=1e-8)
    F = np.array([[0, 0, 1.0, 2, 0, 0], [0.5, 0, 0, 0, 0, 3]])
    poses = np.stack([np.eye(4), T_ab])
    total = wrench.resultant(F, poses)
    np.testing.assert_allclose(total, F[0] + wrench.transform(pose.inverse(T_ab), F[1]), atol=1e-14)
    np.testing.assert_allclose(wrench.resultant([total, -total]), 0)
    with pytest.raises(InputError, match="poses"):
        wrench.resultant(F, poses[:1])


@pytest.mark.capability("04-120")
def test_units_of_length():
    T, V, F, k = motion(0.4), np.arange(1.0, 7.0), np.arange(6.0) - 2, length_units.factor("m", "mm")
    np.testing.assert_allclose(
        twist.transform(length_units.pose(T, k), length_units.twist(V, k)), length_units.twist(twist.transform(T, V), k)
    )
    np.testing.assert_allclose(
        wrench.transform(length_units.pose(T, k), length_units.wrench(F, k)),
        length_units.wrench(wrench.transform(T, F), k),
    )
    np.testing.assert_allclose(length_units.adjoint(pose.adjoint(T), k), pose.adjoint(length_units.pose(T, k)))
    with pytest.raises(InputError, match="parsec"):
        length_units.factor("m", "parsec")


@pytest.mark.capability("04-124")
@pytest.mark.parametrize(
    ("S", "amount", "kind"),
    [
        ([0, 0, 1, 0, 0, 0], 0.0, DisplacementKind.IDENTITY),
        ([0, 0, 0, 0.6, 0, 0.8], 2.0, DisplacementKind.TRANSLATION),
        (screw.from_axis([1, 2, 2], [0.3, 0, 1]), 0.7, DisplacementKind.ROTATION),
        (screw.from_axis([1, 2, 2], [0.3, 0, 1], 0.2), 0.7, DisplacementKind.RIGHT_HANDED),
        (screw.from_axis([1, 2, 2], [0.3, 0, 1], -0.2), 0.7, DisplacementKind.LEFT_HANDED),
        (screw.from_axis([1, 2, 2], [0.3, 0, 1], 0.2), -0.7, DisplacementKind.RIGHT_HANDED),
        (screw.from_axis([1, 2, 2], [0.3, 0, 1], 0.2), np.pi, DisplacementKind.HALF_TURN),
        (screw.from_axis([1, 2, 2], [0.3, 0, 1]), np.pi, DisplacementKind.ROTATION),
    ],
)
def test_kinds_of_displacements(S, amount, kind):
    found = classify(screw.displacement(S, amount))
    assert found.kind is kind
    assert found.explain("en") != found.explain("ar")
    if kind in (DisplacementKind.RIGHT_HANDED, DisplacementKind.LEFT_HANDED):
        assert found.pitch == pytest.approx(screw.pitch(S))
        np.testing.assert_allclose(found.point, screw.nearest_point(S), atol=1e-12)
        assert f"{found.angle * 180 / np.pi:.6g} deg" in found.explain("en")


@pytest.mark.capability("04-125", "04-43")
def test_what_three_turns_reach():
    rng = np.random.default_rng(1)
    for _ in range(20):
        axes = rng.normal(size=(3, 3))
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        low, high = axis_triples.reached_cosines(axes)
        angles = rng.uniform(-np.pi, np.pi, (4000, 3))
        R = np.eye(3)
        for k in range(3):
            R = R @ rotation.from_axis_angle(axes[k], angles[:, k])
        cosines = (R @ axes[2]) @ axes[0]
        assert cosines.min() >= low - 1e-12
        assert cosines.max() <= high + 1e-12
        assert cosines.max() - cosines.min() > 0.98 * (high - low)
        assert axis_triples.reaches(R, axes).all()
        assert not axis_triples.reaches_everything(axes)
    every = rotation.random(rng, 200)
    skew = [[0, 0, 1], [1, 0, 1], [0, 0, 1]]
    some = axis_triples.reaches(every, skew)
    np.testing.assert_array_equal(some, every[:, 2, 2] >= 0)
    assert axis_triples.reaches(every, np.eye(3)).all()
    assert axis_triples.reaches_everything([[0, 0, 2], [0, 1, 0], [1, 0, 1]])
    axes = np.array([[0, 0, 1.0], [0, 1, 0], [np.sin(0.4), 0, np.cos(0.4)]])
    offset = float(axis_triples.middle_zero(axes))
    principal = rotation.to_davenport(every, axes)[:, :, 1]
    inside = (principal >= -offset - 1e-12) & (principal <= np.pi - offset + 1e-12)
    assert inside.any(axis=1).all()
    assert abs(offset) == pytest.approx(0.4)


@pytest.mark.capability("04-77", "04-126")
def test_every_set_of_angles_converts_and_charts_go_both_ways():
    R = rotation.random(np.random.default_rng(3), 10)
    axes = np.array([[0, 0, 1.0], [0, 1, 0], [0.6, 0, 0.8]])
    for target in ("ZXZ", "xyz", axes):
        value = convert(R, "matrix", target)
        assert value.shape == (10, 3)
        np.testing.assert_allclose(convert(value, target, "matrix"), R, atol=1e-12)
    np.testing.assert_allclose(rotation.from_davenport(convert(R, "matrix", axes), axes), R, atol=1e-12)
    with pytest.raises(InputError, match="orthogonal"):
        convert(R, "matrix", [[0, 0, 1], [0, 1, 1], [0, 0, 1]])
    with pytest.raises(InputError, match="determinant"):
        convert(np.diag([1.0, 1, -1]), "matrix", "quaternion")
    with pytest.raises(InputError, match="ZYX"):
        convert(R, "matrix", "euler")
    T, N = motion(0.6), motion(0.2)
    for chart in POSE_CHARTS.values():
        np.testing.assert_allclose(chart.to_pose(chart.from_pose(T)), T, atol=1e-12)
        assert chart.note
        moved = chart.from_pose(N @ T @ pose.inverse(N))
        if chart.name != "matrix":
            carried = np.abs(moved - pose.adjoint(N) @ chart.from_pose(T)).max() < 1e-12
            assert carried == chart.carried, chart.name


@pytest.mark.capability("04-127", "04-58")
def test_paths_of_body_points():
    S = screw.from_axis([1, 2, 2], [1, -1, 2], 0.25)
    path = helix(S, [2.0, 0, 1])
    theta = np.linspace(0, 2, 4001)
    points = path.at(theta)
    length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    assert path.length(2.0) == pytest.approx(length, rel=1e-6)
    axis, foot = S[:3], screw.nearest_point(S)
    np.testing.assert_allclose(np.linalg.norm(np.cross(points - foot, axis), axis=1), path.radius, atol=1e-12)
    turn = path.at(2 * np.pi) - path.start
    np.testing.assert_allclose(turn, path.lead * axis, atol=1e-12)
    straight = helix([0, 0, 0, 0, 1, 0], [1.0, 2, 3])
    np.testing.assert_allclose(straight.at(2.0), [1, 4, 3])
    assert straight.length(-2.0) == 2.0


@pytest.mark.capability("04-49")
def test_frames_of_vehicles():
    rpy = np.array([0.1, -0.2, 0.3])
    down = rotation.from_rpy(rpy)
    np.testing.assert_allclose(vehicle.rotation(down), rotation.from_rpy(vehicle.roll_pitch_yaw(rpy)), atol=1e-15)
    np.testing.assert_allclose(vehicle.vector(down @ [1, 2, 3]), vehicle.rotation(down) @ vehicle.vector([1, 2, 3]))
    half = pose.from_rotation_translation(np.diag([1.0, -1, -1]), [0, 0, 0])
    V = np.arange(1.0, 7.0)
    np.testing.assert_allclose(vehicle.twist(V), twist.transform(half, V))
    nose_up = rotation.from_rpy([0, 0.2, 0])  # z down: positive pitch lifts the nose, away from z
    assert (nose_up @ [1, 0, 0])[2] < 0
    assert (vehicle.rotation(nose_up) @ [1, 0, 0])[2] > 0, "in a frame with z up the nose points up"


@pytest.mark.capability("04-50")
@pytest.mark.parametrize("sequence", ["ZYX", "ZYZ", "xyz"])
def test_principal_ranges_of_angles(sequence):
    R = rotation.random(np.random.default_rng(5), 500)
    both = euler.solutions(R, sequence).angles
    assert euler.is_principal(both[:, 0], sequence).all()
    assert not euler.is_principal(both[:, 1], sequence).any()
    np.testing.assert_array_equal(euler.require_principal(both[:, 0], sequence), both[:, 0])
    with pytest.raises(InputError, match=r"angles\[0\]: .* not the principal angles"):
        euler.require_principal(both[:, 1], sequence)
    low, high = euler.range_of_middle(sequence)
    assert high - low == pytest.approx(np.pi)


@pytest.mark.capability("04-97")
def test_planar_screws():
    rng = np.random.default_rng(6)
    V = np.concatenate([rng.uniform(-3, 3, (50, 1)), rng.normal(size=(50, 2))], axis=1)
    V[:5, 0] = 0
    omega, amount, v = planar.screw(planar.exp(V))
    np.testing.assert_allclose(planar.exp(np.column_stack([omega, v]) * amount[:, None]), planar.exp(V), atol=1e-12)
    assert set(np.unique(omega)) == {-1.0, 0.0, 1.0}
    assert (amount >= 0).all()


@pytest.mark.capability("04-14")
def test_the_identity_has_every_pole_and_a_translation_one_at_infinity():
    poles, exists = planar.finite_pole(np.stack([np.eye(3), planar.pose(0.0, [1.0, 2.0]), planar.pose(np.pi, [2, 0])]))
    assert exists.tolist() == [False, False, True]
    assert np.isnan(poles[0]).all()
    assert np.isinf(poles[1]).all()
    np.testing.assert_allclose(poles[2], [1, 0], atol=1e-12)


def test_common_normals():
    rng = np.random.default_rng(7)
    p, d, r, e = rng.normal(size=(4, 100, 3))
    found = common_normal(p, d, r, e)
    for ends, point, direction in ((found.first, p, d), (found.second, r, e)):
        np.testing.assert_allclose(np.cross(ends - point, direction), 0, atol=1e-9)
    np.testing.assert_allclose(np.sum(found.direction * d, axis=1), 0, atol=1e-9)
    np.testing.assert_allclose(np.sum(found.direction * e, axis=1), 0, atol=1e-9)
    np.testing.assert_allclose(found.second - found.first, found.distance[:, None] * found.direction, atol=1e-9)
    turned = [rotation.from_axis_angle(n, a) @ x for n, a, x in zip(found.direction, found.angle, d, strict=True)]
    np.testing.assert_allclose(np.cross(turned, e), 0, atol=1e-9)
    side = common_normal([0, 0, 0], [0, 0, 1], [3, 4, 7], [0, 0, -2])
    assert side.parallel
    assert side.distance == pytest.approx(5)
    assert side.angle == pytest.approx(np.pi)
    meeting = common_normal([1, 0, 0], [1, 0, 0], [0, 2, 0], [0, 1, 0])
    assert meeting.distance == 0
    np.testing.assert_allclose(meeting.direction, [0, 0, 1])
    assert np.isnan(common_normal([0, 0, 0], [0, 0, 1], [0, 0, 5], [0, 0, 1]).direction).all()
    with pytest.raises(InputError, match="direction_2"):
        common_normal([0, 0, 0], [0, 0, 1], [0, 0, 5], [0, 0, 0])


@pytest.mark.capability("04-87")
def test_the_camera_scene_with_the_pose_that_an_arm_tells():
    arm, q = mf.load("ur5e"), [0.3, -1.2, 1.5, 0.4, 1.1, 0.2]
    down = pose.from_rotation_translation(rotation.from_rpy([np.pi, 0, 0]), [1.5, 1.0, 2.0])
    T_db, T_de = motion(0.2), motion(0.5)
    scene = CameraScene.of(down, T_db, T_de, arm.forward_kinematics(q))
    reached = scene.T_ab.array @ arm.forward_kinematics(q) @ scene.grasp_pose().array
    np.testing.assert_allclose(reached, down @ T_de, atol=1e-12)
