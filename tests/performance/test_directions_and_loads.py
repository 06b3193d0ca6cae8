"""Speed and effort along directions, shapes of ellipsoids, loads on links, work, and the arm described otherwise."""

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.geometry import pose, rotation, screw, twist, wrench
from mafsil.model.dh_frames import tables_of_either_sense, tables_of_screws
from mafsil.model.dh_from_axes import inverse_product, mixed_product, screws
from mafsil.model.exponentials import screw_table
from mafsil.model.library import textbook
from mafsil.model.mounting import change_frames, with_reversed_joint
from mafsil.performance import (
    force_ellipsoid,
    holding_torque,
    jacobian_by_inspection,
    joint_torque,
    largest_speed,
    manipulability,
    task_coordinates,
    task_jacobian,
    tool_jacobian,
    velocity_ellipsoid,
    virtual_work,
    work,
)
from mafsil.performance.dexterity import least_joint_rate, torque_along
from mafsil.performance.singularities import rank_of_screws
from mafsil.performance.statics import LinkLoad, generalized_force, pinned_arm, work_along
from mafsil.performance.velocity import symbolic_jacobian_by_inspection

Q = np.array([0.3, -0.4, 0.25, 0.7, -0.5, 0.6])


@pytest.mark.capability("05-101")
@pytest.mark.parametrize("part", ["linear", "angular"])
def test_effort_is_the_least_rate(part):
    arm = mf.load("puma560")
    u = np.array([1.0, -2.0, 0.5])
    effort = float(least_joint_rate(arm, Q, u, part))
    assert (
        float(least_joint_rate("puma560", Q, u, part)) == effort == float(least_joint_rate(arm.mechanism, Q, u, part))
    )
    J = task_jacobian(arm, Q, "position" if part == "linear" else "orientation")
    least = np.linalg.lstsq(J, u / np.linalg.norm(u), rcond=None)[0]
    assert effort == pytest.approx(np.linalg.norm(least), rel=1e-10)
    assert float(largest_speed(arm, Q, u, part)) == pytest.approx(1 / effort)
    tip = np.array([0.1, -0.2, 0.3])
    if part == "linear":
        assert float(least_joint_rate(arm, Q, u, part, point=tip)) != pytest.approx(effort, rel=1e-3)
    flat = mf.load("planar2r")
    assert np.isinf(least_joint_rate(flat, [0.2, 0.0], [np.cos(0.2), np.sin(0.2)], "planar"))
    assert largest_speed(flat, [0.2, 0.0], [np.cos(0.2), np.sin(0.2)], "planar") == 0
    with pytest.raises(InputError, match=r"^direction: .*not zero"):
        least_joint_rate(arm, Q, [0, 0, 0])


@pytest.mark.capability("05-102", "05-85")
def test_ellipsoids_of_arms_with_prismatic_joints_say_that_the_unit_counts():
    arm = mf.Robot(textbook.rrprrr(0.5, 0.3))
    found = velocity_ellipsoid(arm, Q)
    assert found.unit_dependent
    assert found.prismatic == ("joint3",)
    assert "joint3" in found.explain("en")
    assert found.explain("ar") != found.explain("en")
    in_mm = velocity_ellipsoid(arm, Q, length=1e-3)
    assert not in_mm.unit_dependent
    assert found.ratio == pytest.approx(1.2470, abs=1e-4)
    assert in_mm.ratio == pytest.approx(10.4186, abs=1e-3)
    assert not velocity_ellipsoid(mf.load("puma560"), Q).unit_dependent
    assert force_ellipsoid(arm, Q).unit_dependent


@pytest.mark.capability("05-82")
def test_ellipsoids_are_of_the_point_that_is_asked_for():
    arm, r = mf.load("puma560"), np.array([0.1, -0.2, 0.3])
    J = tool_jacobian(arm, Q, point=r)[3:]
    found, force = velocity_ellipsoid(arm, Q, point=r), force_ellipsoid(arm, Q, point=r)
    np.testing.assert_allclose(found.lengths, np.linalg.svd(J, compute_uv=False))
    np.testing.assert_allclose(np.sort(1 / force.lengths)[::-1], found.lengths)
    assert np.abs(found.lengths - velocity_ellipsoid(arm, Q).lengths).max() > 1e-2


@pytest.mark.capability("05-106")
def test_shapes_of_collapsed_ellipsoids():
    elbow = mf.load("elbow6r")
    disc = velocity_ellipsoid(elbow, np.zeros(6))
    assert disc.dimension == 2
    (lost,) = disc.normals().T
    np.testing.assert_allclose(lost @ task_jacobian(elbow, np.zeros(6), "position"), 0, atol=1e-12)
    flat = mf.load("planar2r")
    narrow = velocity_ellipsoid(flat, [0.3, 0.8], "linear")
    assert narrow.axes.shape == (3, 2)
    assert np.isnan(narrow.ratio)
    np.testing.assert_allclose(np.abs(narrow.normals()[:, 0]), [0, 0, 1], atol=1e-12)
    segment = velocity_ellipsoid(flat, [0.3, 0.0], "planar")
    assert segment.dimension == 1
    assert manipulability(flat, [0.3, 0.0]) == pytest.approx(0, abs=1e-12)


@pytest.mark.capability("05-103", "05-108", "05-65")
def test_three_ways_to_give_one_wrench():
    arm = mf.load("puma560")
    T = arm.forward_kinematics(Q)
    R, p = T[:3, :3], T[:3, 3]
    m, f = np.array([0.3, -0.2, 0.5]), np.array([4.0, 1.0, -2.0])
    tau = joint_torque(arm, Q, [*m, *f], given_in="tip")
    np.testing.assert_allclose(joint_torque(arm, Q, [*(m + np.cross(p, f)), *f], given_in="space"), tau, atol=1e-12)
    np.testing.assert_allclose(joint_torque(arm, Q, [*(R.T @ m), *(R.T @ f)], given_in="body"), tau, atol=1e-12)
    parts = torque_along(arm, Q, f) * np.linalg.norm(f) + torque_along(arm, Q, m, "moment") * np.linalg.norm(m)
    np.testing.assert_allclose(parts, tau, atol=1e-12)
    with pytest.raises(InputError, match="body, space, tip"):
        joint_torque(arm, Q, [*m, *f], given_in="world")


@pytest.mark.capability("05-104", "05-64")
def test_virtual_work_against_the_potential_of_the_loads():
    arm = mf.load("puma560")
    names = arm.mechanism.link_names
    loads = [LinkLoad(names[2], [3, -20, 5], point=[0.2, 0, 0.1]), LinkLoad(names[5], [-1, 2, -12], point=[0, 0.1, 0])]

    def potential(q):
        total = 0.0
        for load in loads:
            T = arm.forward_kinematics(q, frame=load.link)
            total -= np.dot(load.force, pose.act(T, np.array(load.point, float)))
        return total

    slope = [(potential(Q + 1e-6 * e) - potential(Q - 1e-6 * e)) / 2e-6 for e in np.eye(6)]
    np.testing.assert_allclose(generalized_force(arm, Q, loads), -np.array(slope), atol=1e-7)
    np.testing.assert_allclose(holding_torque(arm, Q, loads, gravity=True), arm.gravity_torque(Q) + slope, atol=1e-7)
    couple = LinkLoad(names[3], moment=[1.0, 2.0, 3.0], axes="link")
    T = arm.forward_kinematics(Q, frame=names[3])
    J = tool_jacobian(arm, Q, frame=names[3])[:3]
    np.testing.assert_allclose(generalized_force(arm, Q, [couple]), J.T @ T[:3, :3] @ [1, 2, 3], atol=1e-12)


@pytest.mark.capability("05-64", "05-68")
def test_virtual_work_of_a_linkage():
    """A planar 3R pinned at its tip is a four-bar: one torque at its crank balances a force on its coupler."""
    arm = mf.Robot(mf.load("planar3r").mechanism.with_gravity(np.zeros(3)))
    q = np.array([0.9, -0.8, 1.4])
    pin = task_jacobian(arm, q, "planar_position")
    load = LinkLoad(arm.mechanism.link_names[2], [5.0, -30.0, 0], point=[0.3, 0, 0])
    assert not virtual_work(arm, q, [load], constraint=pin)
    (rates,) = virtual_work(arm, q, [load], constraint=pin).rates
    crank = -generalized_force(arm, q, [load]) @ rates / rates[0]
    assert virtual_work(arm, q, [load], [crank, 0, 0], constraint=pin)
    linkage = pinned_arm(arm, q)
    steps = np.diff(linkage.path, axis=0)
    assert np.abs(steps).max() > 1e-3, "the linkage moves"
    np.testing.assert_allclose(np.linalg.norm(steps, axis=1), 0.02, rtol=0.05)
    T = arm.forward_kinematics(linkage.path[:2], frame=load.link)
    step = linkage.path[1] - linkage.path[0]
    gained = np.dot(load.force, np.subtract(*pose.act(T, np.array(load.point, float))[::-1]))
    assert gained == pytest.approx(-crank * step[0], rel=0.05)
    tips = arm.forward_kinematics(linkage.path)[:, :2, 3]
    np.testing.assert_allclose(tips, np.broadcast_to(tips[0], tips.shape), atol=1e-10)


@pytest.mark.capability("05-63", "05-105")
def test_work_of_moments_and_forces():
    t = np.linspace(0, 2, 201)
    F = np.broadcast_to([1.0, 2, 3, 4, 5, 6], (201, 6))
    V = np.broadcast_to([0.1, -0.2, 0.3, 0, 0, 0], (201, 6))
    assert work(F, V, t) == pytest.approx(2 * (0.1 - 0.4 + 0.9)), "moments work too"
    S, T_0, theta = screw.from_axis([1, 2, 2], [0.3, 0, 1], 0.2), pose.exp([0.1, 0.2, 0.3, 1, 0, 0.5]), 1.3
    F_b, f, mark, m = np.array([0.3, 0.1, -0.2, 2, 1, -1]), np.array([3.0, -1, 2]), np.array([0.2, 0.1, 0]), [1.0, 0, 2]

    def at(s):
        return screw.displacement(S, s) @ T_0

    exact = work_along.of_carried_wrench(S, theta, T_0, F_b)
    found = work_along.along(lambda s: F_b, lambda s: twist.transform(pose.inverse(at(s)), S), 0.0, theta)
    assert found.value == pytest.approx(exact.value, abs=1e-10)
    assert abs(found.value - exact.value) <= found.error + exact.error
    exact = work_along.of_fixed_force(S, theta, T_0, f, mark)
    found = work_along.along(lambda s: wrench.from_force(pose.act(at(s), mark), f), lambda s: S, 0.0, theta)
    assert found.value == pytest.approx(exact.value, abs=1e-10)
    exact = work_along.of_fixed_couple(S, theta, m)
    found = work_along.along(lambda s: wrench.from_couple(m), lambda s: S, 0.0, theta)
    assert found.value == pytest.approx(exact.value, abs=1e-10)


@pytest.mark.capability("05-90", "05-91", "05-94", "05-95")
@pytest.mark.parametrize("name", ["puma560", "stanford_arm", "panda", "planar2r"])
def test_one_arm_described_otherwise(name):
    arm = mf.load(name)
    q = np.linspace(-0.4, 0.6, arm.n)
    T = arm.forward_kinematics(q)
    for k in range(arm.n + 1):
        np.testing.assert_allclose(mixed_product(arm, q, k), T, atol=1e-12)
    np.testing.assert_allclose(inverse_product(name, q), np.linalg.inv(T), atol=1e-12)
    P, N = pose.exp([0.1, 0.2, -0.3, 1, 2, 3]), pose.exp([-0.2, 0.1, 0.4, 0.1, 0, 0.2])
    other = mf.Robot(change_frames(arm, base=P, tool=N))
    np.testing.assert_allclose(other.forward_kinematics(q), P @ T @ N, atol=1e-12)
    np.testing.assert_allclose(other.jacobian_space(q), pose.adjoint(P) @ arm.jacobian_space(q), atol=1e-12)
    np.testing.assert_allclose(screws(other.mechanism).S_s, screws(arm.mechanism).S_s @ pose.adjoint(P).T, atol=1e-12)
    np.testing.assert_allclose(other.gravity_torque(q), arm.gravity_torque(q), atol=1e-11)
    joint = arm.joint_names[1]
    turned = mf.Robot(with_reversed_joint(arm, joint))
    signs = np.where(np.arange(arm.n) == 1, -1.0, 1.0)
    np.testing.assert_allclose(turned.forward_kinematics(signs * q), T, atol=1e-12)
    np.testing.assert_allclose(turned.gravity_torque(signs * q), signs * arm.gravity_torque(q), atol=1e-11)
    np.testing.assert_allclose(turned.limits.lower[1], -arm.limits.upper[1])
    with pytest.raises(InputError, match="elbow_of_nobody"):
        with_reversed_joint(arm, "elbow_of_nobody")


@pytest.mark.capability("05-36")
def test_the_table_of_screws_prints_omega_and_v():
    found = screws(mf.model.library.load("rrprrr"))
    for form, axes in (("space", found.S_s), ("body", found.S_b)):
        lines = screw_table(found, form).splitlines()[1:7]
        for line, S in zip(lines, axes, strict=True):
            numbers = [float(x) for x in line.replace("(", " ").replace(")", " ").split()[1:]]
            np.testing.assert_allclose(numbers, S, atol=1e-3)


def test_rank_of_screws():
    rng = np.random.default_rng(0)
    lines = np.stack([screw.from_axis(rng.normal(size=3), rng.normal(size=3)) for _ in range(6)])
    assert rank_of_screws(lines).rank == 6
    point = rng.normal(size=3) * 100
    star = np.stack([screw.from_axis(rng.normal(size=3), point) for _ in range(4)])
    for digits in (6, 8, 10, 12):
        found = rank_of_screws(np.round(star, digits), tolerance=1e-4 if digits == 6 else 1e-6)
        assert found.rank == 3, digits
    np.testing.assert_allclose(found.reciprocal @ star.T, 0, atol=1e-8)
    np.testing.assert_allclose(found.null_rates @ star, 0, atol=1e-8)
    P = pose.exp([0.3, 0.1, 2, 10, 20, 30])
    assert rank_of_screws(star @ pose.adjoint(P).T).rank == 3
    assert rank_of_screws([[0, 0, 0, 0, 0, 1], [0, 0, 0, 1, 0, 0], [0, 0, 0, 1, 0, 1]]).rank == 2


@pytest.mark.capability("05-3")
def test_forward_kinematics_of_the_rows_that_count():
    arm, q = mf.load("planar3r"), np.random.default_rng(0).uniform(-1, 1, (5, 3))
    L, sums = np.array([1.0, 0.8, 0.5]), np.cumsum(q, axis=1)
    place = np.stack([np.cos(sums) @ L, np.sin(sums) @ L], axis=1)
    np.testing.assert_allclose(task_coordinates(arm, q, "planar_position"), place, atol=1e-14)
    full = task_coordinates(arm, q, "planar")
    np.testing.assert_allclose(full[:, 1:], place, atol=1e-14)
    np.testing.assert_allclose(np.angle(np.exp(1j * (full[:, 0] - sums[:, 2]))), 0, atol=1e-14)
    np.testing.assert_allclose(task_coordinates(arm, q, [4, 3]), place[:, ::-1], atol=1e-14)
    puma = mf.load("puma560")
    np.testing.assert_allclose(task_coordinates(puma, Q, "position"), puma.forward_kinematics(Q)[:3, 3])
    r = task_coordinates(puma, Q, "orientation")
    np.testing.assert_allclose(rotation.exp(r), puma.forward_kinematics(Q)[:3, :3], atol=1e-14)
    for robot, rows in ((puma, [0, 3]), (puma, [2, 3])):
        with pytest.raises(InputError, match="rotations"):
            task_coordinates(robot, Q, rows)


@pytest.mark.capability("05-52")
def test_inspection_with_symbols():
    sympy = pytest.importorskip("sympy")
    a, L1, L2 = sympy.symbols("q1 L1 L2")
    c, s = sympy.cos(a), sympy.sin(a)
    J = symbolic_jacobian_by_inspection(
        [[0, 0, 1], [0, 0, 1], [0, 0, 1]], [[0, 0, 0], [L1 * c, L1 * s, 0], [0, 0, 0]], "RRP"
    )
    assert J[3][1] == L1 * s
    assert J[4][1] == -L1 * c
    assert [row[2] for row in J] == [0, 0, 0, 0, 0, 1]
    numbers = np.array([[float(sympy.sympify(x).subs({a: 0.3, L1: 1.2, L2: 1})) for x in row] for row in J])
    points = [[0, 0, 0], [1.2 * np.cos(0.3), 1.2 * np.sin(0.3), 0], [0, 0, 0]]
    np.testing.assert_allclose(numbers, jacobian_by_inspection([[0, 0, 1]] * 3, points, "RRP"), atol=1e-15)
    with pytest.raises(InputError, match="letter"):
        symbolic_jacobian_by_inspection([[0, 0, 1]], [[0, 0, 0], [0, 0, 0]])


@pytest.mark.capability("05-52")
def test_inspection_from_the_tool_gives_the_body_jacobian():
    arm = mf.load("puma560")
    T_bs = np.linalg.inv(arm.forward_kinematics(Q))
    seen = pose.adjoint(T_bs) @ arm.jacobian_space(Q)
    points = np.stack([screw.nearest_point(column) for column in seen.T])
    np.testing.assert_allclose(jacobian_by_inspection(seen[:3].T, points), arm.jacobian_body(Q), atol=1e-13)


@pytest.mark.capability("05-97")
def test_tables_of_either_sense_are_one_arm():
    arm = mf.load("rrrp")
    found, q = screws(arm.mechanism), np.array([0.3, -0.4, 0.5, 0.1])
    T = arm.forward_kinematics(q)
    plain = len(list(tables_of_screws(found.S_s, found.home)))
    both = list(tables_of_either_sense(found.S_s, found.home))
    assert len(both) == 16 * plain
    for table, signs in both:
        np.testing.assert_allclose(mf.Robot(table.mechanism()).forward_kinematics(signs * q), T, atol=1e-12)
    assert len({tuple(np.round([row.alpha for row in table.rows], 9)) for table, _ in both}) > 1


@pytest.mark.capability("05-48")
def test_rules_of_differentiation():
    rng = np.random.default_rng(4)
    A, B = (pose.exp(rng.normal(size=6)) for _ in range(2))
    S, theta, rate, h = rng.normal(size=6), 0.7, 1.3, 1e-6
    np.testing.assert_allclose(pose.inverse(A @ B), pose.inverse(B) @ pose.inverse(A), atol=1e-13)
    E = pose.exp(S * theta)
    slope = (pose.exp(S * (theta + rate * h)) - pose.exp(S * (theta - rate * h))) / (2 * h)
    np.testing.assert_allclose(slope, pose.hat(S) @ E * rate, atol=1e-8)
    np.testing.assert_allclose(slope, E @ pose.hat(S) * rate, atol=1e-8)
    np.testing.assert_allclose(pose.exp(-S * theta), pose.inverse(E), atol=1e-13)


@pytest.mark.capability("05-57")
def test_a_jacobian_drives_inverse_kinematics():
    arm = mf.load("puma560")
    goal, q = arm.forward_kinematics(Q), Q + 0.05
    for _ in range(6):
        q = q + np.linalg.solve(arm.jacobian_body(q), pose.error(arm.forward_kinematics(q), goal))
    np.testing.assert_allclose(q, Q, atol=1e-10)
