"""What the first chapters promise of the others: one short piece of work of each through the public face."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil import mobility as mo
from mafsil.mobility import library
from mafsil.mobility.actuation import ActuationStatus

DOCS = Path(__file__).parents[2] / "docs"


@pytest.mark.capability("02-1")
def test_one_model_for_every_question():
    robot = mf.load("panda")
    assert robot.mechanism.tip in robot.mechanism.link_names
    assert all(robot.mechanism.actuated)
    q = np.array([0.1, -0.4, 0.3, -1.9, 0.2, 1.6, 0.5])
    assert robot.forward_kinematics(q).shape == (4, 4)
    assert robot.inverse_dynamics(q, q, q).shape == (7,)
    assert mf.mobility(robot, q).mobility == robot.n == 7
    assert mf.mobility(robot, q).linkage.output is not None
    passive = mo.mechanism_of(library.four_bar())
    assert passive.actuated == (True, False, False)


@pytest.mark.capability("02-3")
def test_actuated_joints_determine_the_passive_ones():
    arm = mf.mobility("ur5e", [0.1, -1.0, 1.2, 0.3, 0.8, 0.2])
    assert arm.actuation.actuators == arm.mobility == 6
    closed = library.five_bar()
    assert mo.actuation(closed).status is ActuationStatus.FULL
    driven = {"O": 0.1, "D": -0.2}
    start = np.zeros(closed.coordinates)
    for name, value in driven.items():
        start[closed.columns_of([name])] = value
    found = mo.linkages.close_loops_near(closed, start, fixed=driven)
    assert found
    for name, value in driven.items():
        assert found.theta[closed.columns_of([name])[0]] == value
    M = closed.joints[2].point
    left = mo.point_position(closed, "rod 1", M, found.theta)
    np.testing.assert_allclose(left, mo.point_position(closed, "rod 2", M, found.theta), atol=1e-9)


@pytest.mark.capability("02-14", "02-32")
def test_configurations_and_freedoms():
    chain = library.chain(3)
    assert mo.configuration_space(chain).dimension == mo.gruebler(chain).mobility == mf.mobility(chain).mobility == 3
    assert mo.gruebler(library.six_ups()).mobility == 6
    assert mo.spaces.annulus([2, 2, 2]) == (0.0, 6.0)


@pytest.mark.capability("02-15", "02-74")
def test_grasps():
    four = [
        mf.Contact(p, n)
        for p, n in (([-1, 0.3], [1, 0]), ([1, -0.3], [-1, 0]), ([-0.3, 1], [0, -1]), ([0.3, -1], [0, 1]))
    ]
    assert mf.Grasp(four).form_closure()
    assert not mf.Grasp(four[:3]).form_closure()
    rough = [mf.Contact(p, -np.array(p, float), 0.5) for p in ([1, 0], [-1, 0])]
    assert mf.Grasp(rough).closure()


@pytest.mark.capability("02-16")
def test_motions_of_bodies():
    V = np.array([0.1, -0.2, 0.3, 1.0, 2.0, 3.0])
    T = mf.geometry.pose.exp(V)
    np.testing.assert_allclose(mf.geometry.pose.log(T), V, atol=1e-14)
    np.testing.assert_allclose(T[:3, :3], mf.geometry.rotation.exp(V[:3]), atol=1e-14)


@pytest.mark.capability("02-17", "02-18", "02-19", "02-21")
def test_chains():
    robot, q = mf.load("ur5e"), np.array([0.3, -1.2, 1.1, 0.2, 0.9, -0.4])
    T, h = robot.forward_kinematics(q), 1e-6
    J = robot.jacobian_body(q)
    numeric = [mf.geometry.pose.log(np.linalg.inv(T) @ robot.forward_kinematics(q + h * e)) / h for e in np.eye(6)]
    np.testing.assert_allclose(J, np.array(numeric).T, atol=1e-5)
    found = mf.inverse_kinematics(robot, T)
    assert len(found) == 8
    np.testing.assert_allclose(robot.forward_kinematics(found.q[0]), T, atol=1e-9)
    qd, qdd = np.full(6, 0.2), np.full(6, -0.1)
    tau = robot.inverse_dynamics(q, qd, qdd)
    np.testing.assert_allclose(robot.forward_dynamics(q, qd, tau), qdd, atol=1e-9)


@pytest.mark.capability("02-69")
def test_which_quantities_of_the_tip_count():
    expected = {
        "position": (3, "R^3"),
        "position and angle": (4, "R^3 x S^1"),
        "position and direction": (5, "R^3 x S^2"),
        "pose": (6, "SE(3)"),
    }
    for task, (dimension, name) in expected.items():
        assert (mo.named_space(task).dimension, mo.named_space(task).name) == (dimension, name)
        assert mo.spaces.task_redundancy(7, task) == 7 - dimension
    robot = mf.load("ur5e")
    T = robot.forward_kinematics(np.array([0.3, -1.2, 1.1, 0.2, 0.9, -0.4]))
    found = mf.solve_ik(robot, T, task="position")
    np.testing.assert_allclose(robot.forward_kinematics(found.q)[..., :3, 3], T[:3, 3], atol=1e-8)


@pytest.mark.capability("02-70", "02-71", "02-68")
def test_what_a_scara_a_spray_gun_and_a_wrist_leave_free():
    """Task spaces by the ranks of velocities, not by their names."""
    scara, q = mf.load("scara_rrrp"), np.array([0.3, -0.7, 0.5, 0.1])
    J = scara.jacobian_space(q)
    assert np.linalg.matrix_rank(J, 1e-9) == mo.named_space("position and angle").dimension == 4
    np.testing.assert_allclose(J[:2], 0.0, atol=1e-12)
    # The gun turns about its own axis z_b: a rate of the joints that neither the place nor the direction notices.
    arm, q = mf.load("ur5e"), np.array([0.3, -1.2, 1.1, 0.2, 0.9, -0.4])
    spin = np.linalg.solve(arm.jacobian_body(q), [0, 0, 1.0, 0, 0, 0])
    turned = arm.forward_kinematics(q + 1e-5 * spin) - arm.forward_kinematics(q - 1e-5 * spin)
    np.testing.assert_allclose(turned[:3, 2:], 0.0, atol=1e-9)
    assert np.abs(turned[:3, 0]).max() > 1e-5
    rows = [0, 1, 3, 4, 5]
    assert np.linalg.matrix_rank(arm.jacobian_body(q)[rows], 1e-9) == mo.named_space("position and direction").dimension
    assert mo.spaces.task_redundancy(6, "position and direction") == 1
    # A wrist of three joints: all rotations, none of the place.
    wrist = mf.Robot.from_screws([[0, 0, 1, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0]], np.eye(4))
    J = wrist.jacobian_space([0.4, 0.8, -0.3])
    assert np.linalg.matrix_rank(J[:3], 1e-9) == 3
    np.testing.assert_allclose(J[3:], 0.0, atol=1e-12)


@pytest.mark.capability("02-36")
def test_a_body_of_the_plane_is_one_of_space_with_three_constraints():
    """z_A = z_B = z_C = 0 take three of six: one translation and two rotations; 2 + 1 stay."""
    given = (1.0, 0.9, 0.7)

    def heights(x):
        found = mo.bodies.points_of_body(x[:3], x[3], x[4], x[5], *given)
        return np.array([found.A[2], found.B[2], found.C[2]])

    flat, h = np.array([0.3, -0.2, 0.0, 0.7, 0.0, 0.0]), 1e-6
    assert np.abs(heights(flat)).max() < 1e-12
    J = np.array([(heights(flat + h * e) - heights(flat - h * e)) / (2 * h) for e in np.eye(6)]).T
    assert np.linalg.matrix_rank(J, 1e-6) == 3
    assert np.linalg.matrix_rank(J[:, :3], 1e-6) == 1
    assert np.linalg.matrix_rank(J[:, 3:], 1e-6) == 2
    for name, linear, angular in (("body in space", 3, 3), ("coin", 2, 1)):
        assert mo.named_space(name).dimension == linear + angular


@pytest.mark.capability("02-85")
def test_the_glossary_has_the_words_of_both_sources():
    terms = {term["english"]: term for term in tomllib.loads((DOCS / "glossary.toml").read_text("utf-8"))["term"]}
    pairs = {
        "configuration space": ("فضاء الهيئات", "فضاء الوضعية"),
        "singular configuration": ("هيئة شاذة", "قصور حركي"),
        "tip (end effector)": ("الطرف", "المؤثر الطرفي"),
        "frame": ("إطار", "جملة محاور"),
        "roll, pitch, yaw": ("اللف", "الالتفاف"),
    }
    page = (DOCS / "glossary.ar.md").read_text("utf-8")
    for english, (preferred, other) in pairs.items():
        assert preferred in terms[english]["arabic"]
        assert any(other in word for word in terms[english]["not"])
        assert preferred in page
