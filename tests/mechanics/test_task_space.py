"""Dynamics in the tip's coordinates: two-way relation, frames, redundancy, singular states."""

import numpy as np
import pytest

from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.model import library
from mafsil.robot import Robot
from tests.oracles.states import sample


@pytest.fixture(scope="module")
def six():
    return Robot(library.load("ur5e"))


@pytest.fixture(scope="module")
def seven():
    return Robot(library.load("panda"))


def state(robot, count=4):
    return sample(robot.mechanism, count, np.random.default_rng(6))


def times(A, x):
    return np.einsum("...ij,...j->...i", A, x)


def close(a, b, limit=1e-9):
    assert np.abs(a - b).max() < limit * max(1.0, np.abs(b).max())


@pytest.mark.capability("09-67", "09-69", "09-72")
def test_six_joints_by_the_inverse_jacobian(six):
    """Lambda = J^-T M J^-1, eta = J^-T b - Lambda dJ J^-1 V, F = J^-T tau."""
    s = state(six)
    task = six.task_space(s.q, s.qd)
    Jinv = np.linalg.inv(six.jacobian_body(s.q))
    Jt = np.swapaxes(Jinv, -1, -2)
    Lambda = Jt @ six.mass_matrix(s.q) @ Jinv
    close(task.Lambda, Lambda)
    close(task.J_bar, Jinv)
    b = six.inverse_dynamics(s.q, s.qd, 0 * s.qdd)
    eta = times(Jt, b) - times(Lambda, times(six.jacobian_body_rate(s.q, s.qd), s.qd))
    close(task.eta, eta)
    close(task.p, times(Jt, six.gravity_torque(s.q)))
    tau = six.inverse_dynamics(s.q, s.qd, s.qdd)
    dV = times(task.J, s.qdd) + times(six.jacobian_body_rate(s.q, s.qd), s.qd)
    close(task.force(dV), times(Jt, tau))


@pytest.mark.capability("09-69", "09-70")
@pytest.mark.parametrize("arm", ["six", "seven"])
def test_two_way_relation(arm, request):
    """The efforts J' F accelerate the tip by Lambda^-1 (F - eta), as forward dynamics says; back again by F."""
    robot = request.getfixturevalue(arm)
    s = state(robot)
    task = robot.task_space(s.q, s.qd)
    F = s.tip_wrench
    qdd = robot.forward_dynamics(s.q, s.qd, task.joint_torque(F))
    dV = times(task.J, qdd) + times(robot.jacobian_body_rate(s.q, s.qd), s.qd)
    close(task.acceleration(F), dV)
    close(task.force(dV), F, 1e-7)


@pytest.mark.capability("09-69")
def test_internal_efforts_of_a_redundant_arm_leave_its_tip_alone(seven):
    s = state(seven)
    task = seven.task_space(s.q, s.qd)
    F = s.tip_wrench
    plain = seven.forward_dynamics(s.q, s.qd, task.joint_torque(F))
    moved = seven.forward_dynamics(s.q, s.qd, task.joint_torque(F, internal=s.tau))
    assert np.abs(moved - plain).max() > 1
    close(times(task.J, moved), times(task.J, plain), 1e-9)
    close(task.J @ task.J_bar, np.broadcast_to(np.eye(6), (4, 6, 6)))


@pytest.mark.capability("09-67", "09-69")
def test_change_of_frame(six):
    """Lambda_s = Ad(T_bs)' Lambda_b Ad(T_bs); F . V is the same in both."""
    s = state(six, 1)
    body, space = (six.task_space(s.q[0], s.qd[0], expressed_in=frame) for frame in ("body", "space"))
    Ad = pose.adjoint(pose.inverse(six.forward_kinematics(s.q[0])))
    close(space.Lambda, Ad.T @ body.Lambda @ Ad)
    close(space.p, Ad.T @ body.p)
    close(space.eta, Ad.T @ body.eta)


@pytest.mark.capability("09-68")
def test_singular_states_are_marked_and_their_neighbours_are_not(six):
    q = np.array([[0.3, -1.0, 1.2, 0.4, 0.0, 0.2], [0.3, -1.0, 1.2, 0.4, 0.7, 0.2]])
    task = six.task_space(q, np.zeros((2, 6)))
    assert task.singular.tolist() == [True, False]
    assert np.isnan(task.Lambda[0]).all()
    assert np.isfinite(task.Lambda[1]).all()
    assert np.isfinite(task.inverse).all()
    assert task.margin[0] < 1e-12 < task.margin[1]


@pytest.mark.capability("09-68", "09-69")
def test_chosen_rows():
    arm = Robot(library.load("planar3r"))
    q, qd = np.array([0.3, 0.8, -0.5]), np.array([0.1, 0.2, -0.4])
    assert arm.task_space(q, qd).singular
    task = arm.task_space(q, qd, rows=(2, 3, 4))
    assert not task.singular
    F = np.array([0.3, 1.0, -2.0])
    qdd = arm.forward_dynamics(q, qd, task.joint_torque(F))
    dV = arm.jacobian_body(q) @ qdd + arm.jacobian_body_rate(q, qd) @ qd
    close(task.acceleration(F), dV[[2, 3, 4]])


@pytest.mark.parametrize("rows", [(), (1, 1), (6,)])
def test_wrong_rows(six, rows):
    with pytest.raises(InputError, match="rows") as caught:
        six.task_space(np.zeros(6), np.zeros(6), rows=rows)
    assert caught.value.key == "dynamics.task_rows"


def test_wrong_frame(six):
    with pytest.raises(InputError, match="'body' or 'space'"):
        six.task_space(np.zeros(6), np.zeros(6), expressed_in="tool")
