"""Structure of arms with the conditions that fail, lengths of the PUMA shape, planar places, roots and their course."""

import numpy as np
import pytest

import mafsil as mf
from mafsil.geometry import pose, rotation
from mafsil.ik import arm_structure, find_root, inverse_kinematics, newton_ik, planar_reach, twists_between
from mafsil.ik.newton import RootStatus
from mafsil.ik.structure import ArmClass, PlaceClass, conjugated_wrist, project_off_axis, puma_shape, signed_angle


@pytest.mark.capability("07-55")
@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("puma560", ArmClass.PUMA_WITH_OFFSET),
        ("offset_puma", ArmClass.PUMA_WITH_OFFSET),
        ("generalized_puma", ArmClass.PUMA_WITH_OFFSET),
        ("stanford_arm", ArmClass.STANFORD_WITH_OFFSET),
        ("arm6r", ArmClass.PUMA),
        ("ur5e", ArmClass.NONE),
    ],
)
def test_classes_and_failing_conditions(name, expected):
    told = arm_structure(name)
    assert told.arm_class is expected, told.explain("en")
    if expected is ArmClass.NONE:
        assert told.failing
        assert all(one.size > 1e-9 for one in told.failing)
        assert "violated by" in told.explain("en")


@pytest.mark.capability("07-55")
def test_generalized_classes():
    """Third joints that are neither parallel to the second nor lead straight away from it."""
    rows = [[0, 0, 1, 0, 0, 0], [0, 1, 0, 0, 0, 0], None]
    rows += [[0, 0, 1, -0.3, 1, 0], [0, 1, 0, 0.5, 0, -1], [0, 0, 1, -0.3, 1, 0]]
    w3 = np.array([0.3, 0.8, 0.1]) / np.linalg.norm([0.3, 0.8, 0.1])
    for third, expected in (
        ([0, 0, 0, 0.6, 0, 0.8], ArmClass.GENERALIZED_STANFORD),
        ([*w3, *np.cross([0.4, 0.0, 0.1], w3)], ArmClass.GENERALIZED_PUMA),
    ):
        home = np.eye(4)
        home[:3, 3] = [-1, -0.3, -0.4]
        told = arm_structure(mf.Robot.from_screws([row if row is not None else third for row in rows], home))
        assert told.arm_class is expected, told.explain("en")
        np.testing.assert_allclose(told.wrist_centre, [-1, -0.3, -0.5], atol=1e-12)


@pytest.mark.capability("07-55")
def test_the_size_of_a_missed_condition():
    lean = np.deg2rad(0.3)
    w2 = [0.0, -np.cos(lean), np.sin(lean)]
    rows = [[0, 0, 1, 0, 0, 0], [*w2, 0, 0, 0], [0, -1, 0, 0, 0, -0.5]]
    rows += [[1, 0, 0, 0, 0, 0], [0, -1, 0, 0, 0, -1.0], [1, 0, 0, 0, 0.0, 0]]
    home = np.eye(4)
    home[0, 3] = 1.1
    told = arm_structure(mf.Robot.from_screws(rows, home))
    sizes = {(one.name, one.joints): one.size for one in told.failing}
    assert sizes[("ik.condition_orthogonal", (1, 2))] == pytest.approx(np.sin(lean))
    with pytest.raises(mf.InputError, match="orthogonal"):
        puma_shape(mf.Robot.from_screws(rows, home))


@pytest.mark.capability("07-13")
def test_lengths_of_the_puma():
    robot = mf.load("puma560")
    shape = puma_shape(robot)
    assert shape.upper_arm == pytest.approx(0.4318)
    assert shape.forearm == pytest.approx(np.hypot(0.4318, 0.0203), abs=1e-4)
    rng = np.random.default_rng(0)
    # The formulas of the shape place the wrist: its distance from axis 1's foot does not depend on joint 1.
    for q in rng.uniform(-2, 2, (5, 6)):
        T = robot.forward_kinematics(q) @ pose.inverse(robot.forward_kinematics(np.zeros(6)))
        p = pose.act(T, shape.wrist_centre)
        reach = np.hypot(np.hypot(p[0], p[1]), p[2] - shape.height)
        assert np.abs(shape.upper_arm - shape.forearm) <= reach + 1e-9
        assert reach <= np.hypot(shape.upper_arm + shape.forearm, shape.offset) + 1e-9
        assert np.hypot(p[0], p[1]) >= abs(shape.offset) - 1e-9


@pytest.mark.capability("07-29")
def test_the_wrist_is_a_turn_about_its_centre_where_the_joints_before_are_right():
    robot = mf.load("puma560")
    wrist = conjugated_wrist(robot)
    np.testing.assert_allclose(wrist.S[:, 3:], 0.0, atol=1e-12)
    np.testing.assert_allclose(wrist.S[0, :3], [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(wrist.S[1, :3], [0, 1, 0], atol=1e-12)
    q = np.array([0.3, 0.5, -0.7, 0.4, 0.6, -0.2])
    home = robot.forward_kinematics(np.zeros(6))
    before = robot.forward_kinematics([*q[:3], 0, 0, 0]) @ pose.inverse(home)
    X2 = pose.inverse(before) @ robot.forward_kinematics(q) @ pose.inverse(home)
    assert wrist.shift(X2) < 1e-12
    turns = [rotation.exp(S[:3] * x) for S, x in zip(wrist.S, q[3:], strict=True)]
    np.testing.assert_allclose(wrist.conjugate(X2)[:3, :3], turns[0] @ turns[1] @ turns[2], atol=1e-12)
    wrong = robot.forward_kinematics([0.4, *q[1:3], 0, 0, 0]) @ pose.inverse(home)
    assert wrist.shift(pose.inverse(wrong) @ robot.forward_kinematics(q) @ pose.inverse(home)) > 1e-3


@pytest.mark.capability("07-26")
def test_projections_and_signed_angles():
    rng = np.random.default_rng(1)
    w = rng.normal(size=(50, 3))
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    a, angle = rng.normal(size=(50, 3)), rng.uniform(-np.pi, np.pi, 50)
    b = (rotation.exp(w * angle[:, None]) @ a[:, :, None])[:, :, 0] * 1.7 + 0.4 * w
    np.testing.assert_allclose(signed_angle(w, a, b), angle, atol=1e-12)
    np.testing.assert_allclose((project_off_axis(w, a) * w).sum(axis=1), 0.0, atol=1e-14)
    np.testing.assert_allclose(project_off_axis(w, b), project_off_axis(w, b - 0.4 * w), atol=1e-12)


@pytest.mark.capability("07-7", "07-8")
def test_places_of_planar_arms_agree_with_their_solutions():
    robot = mf.load("planar2r")
    reach = planar_reach(robot)
    rng = np.random.default_rng(2)
    z = robot.forward_kinematics(np.zeros(2))[2, 3]
    reached = {PlaceClass.INTERIOR: 2, PlaceClass.OUTSIDE: 0, PlaceClass.HOLE: 0}
    for r in [*rng.uniform(0, 1.3 * reach.outer, 12), reach.inner / 2]:
        angle = rng.uniform(-np.pi, np.pi)
        T = np.eye(4)
        T[:3, 3] = [r * np.cos(angle), r * np.sin(angle), z]
        place = reach.classify(T[:3, 3])
        if place in reached and (place is not PlaceClass.HOLE or reach.inner > 0):
            assert len(inverse_kinematics(robot, T, task="position")) == reached[place]
    assert reach.classify([reach.outer, 0, z]) is PlaceClass.OUTER_BOUNDARY
    assert reach.classify([reach.outer, 0, z + 0.1]) is PlaceClass.OFF_PLANE
    assert "ring" in reach.place([2 * reach.outer, 0, z]).explain("en")
    three = planar_reach("planar3r")
    assert three.outer == pytest.approx(three.lengths.sum())
    q = rng.uniform(-np.pi, np.pi, (20_000, 3))
    r = np.linalg.norm(mf.load("planar3r").forward_kinematics(q)[:, :2, 3], axis=1)
    assert three.inner - 1e-9 <= r.min() <= three.inner + 0.2 * three.outer
    assert r.max() <= three.outer + 1e-9
    with pytest.raises(mf.InputError, match="joint2"):
        planar_reach("puma560")


@pytest.mark.capability("07-37", "07-60")
def test_how_newtons_method_ends():
    def f(x):
        return np.array([x[0] ** 2 + x[1] ** 2 - 4.0, x[0] * x[1] - 1.0])

    def slopes(x):
        return np.array([[2 * x[0], 2 * x[1]], [x[1], x[0]]])

    record = find_root(f, [2.0, 1.0], slopes)
    assert record
    assert record.residuals[-1] < 1e-12
    np.testing.assert_allclose(f(record.x), 0.0, atol=1e-12)
    assert record.orders[np.isfinite(record.orders)][-1] == pytest.approx(2.0, abs=0.2)
    np.testing.assert_allclose(record.iterates[1], [2.0, 1.0] - np.linalg.solve(slopes([2, 1]), f([2, 1])))
    assert record.ranks == (2,) * record.iterations
    by_differences = find_root(f, [2.0, 1.0])
    np.testing.assert_allclose(by_differences.x, record.x, atol=1e-10)
    refused = find_root(f, [1.0, 1.0], slopes)
    assert refused.status is RootStatus.SINGULAR
    assert refused.ranks == (1,)
    assert refused.iterations == 0
    away = find_root(np.arctan, [2.0], lambda x: np.diag(1 / (1 + x**2)))
    assert not away
    assert away.status in (RootStatus.DIVERGED, RootStatus.SINGULAR)
    assert (
        find_root(lambda x: x**2 + 1, [0.3], lambda x: np.diag(2 * x), max_steps=4).status is not RootStatus.CONVERGED
    )
    assert "order" in record.explain("en")


@pytest.mark.capability("07-38")
@pytest.mark.parametrize("variant", ["newton", "damped", "broyden", "levenberg"])
def test_variants_find_the_same_root(variant):
    def f(x):
        return np.array([np.exp(x[0]) - x[1], x[0] + x[1] - 2.0])

    record = find_root(f, [0.2, 1.0], variant=variant)
    assert record, record.explain("en")
    np.testing.assert_allclose(f(record.x), 0.0, atol=1e-11)
    # From where Newton's own steps run away, damping still comes home.
    far = find_root(np.arctan, [4.0], variant=variant)
    assert bool(far) == (variant in ("damped", "levenberg"))


@pytest.mark.capability("07-39", "07-60")
def test_forms_of_the_residual_lead_to_the_same_solution():
    robot = mf.load("puma560")
    q = np.array([0.3, 0.5, -0.7, 0.4, 0.6, -0.2])
    X, start = robot.forward_kinematics(q), q + np.array([0.1, -0.1, 0.1, -0.1, 0.1, 0.1])
    for form in ("body", "space"):
        exact = newton_ik(robot, X, start, form=form)
        assert exact.status is RootStatus.CONVERGED
        np.testing.assert_allclose(newton_ik(robot, X, start, form=form, by_differences=True).q, q, atol=1e-9)
        np.testing.assert_allclose(exact.q, q, atol=1e-9)
        # The arm's own Jacobian is the derivative of the residual at the solution only: still of second order.
        assert exact.orders[np.isfinite(exact.orders)][-1] > 1.7
    euler = newton_ik(robot, X, start, residual="euler")
    np.testing.assert_allclose(euler.q, q, atol=1e-9)
    straight = newton_ik(robot, X, [0.4, 0.4, -0.6, 0.3, 0.0, -0.1], max_steps=1)
    assert straight.status is RootStatus.SINGULAR


@pytest.mark.capability("07-54")
def test_twists_between_samples_lead_from_one_to_the_next():
    rng = np.random.default_rng(3)
    poses, times = pose.exp(rng.normal(size=(6, 6))), np.cumsum(rng.uniform(0.1, 1.0, 6))
    V = twists_between(poses, times)
    reached = poses[:-1] @ pose.exp(V * np.diff(times)[:, None])
    np.testing.assert_allclose(reached, poses[1:], atol=1e-12)
    with pytest.raises(mf.InputError):
        twists_between(poses, times[::-1])
