"""Where numbers leave their range, joints are missing, or degrees stand for radians: said, never silent."""

from __future__ import annotations

import copy
import pickle
import warnings

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError, InputWarning, ModelError
from mafsil.geometry import pose
from mafsil.mechanics.catalogue import CATALOGUE
from mafsil.model import Inertial, Joint, JointKind, Link, Mechanism

SMALL = np.array([0.1, -0.4, 0.3])


@pytest.fixture(scope="module")
def arm() -> mf.Robot:
    return mf.load("planar3r")


@pytest.mark.parametrize("name", ["inverse_dynamics", "kinetic_energy", "velocity_torque"])
@pytest.mark.parametrize("kind", [np.asarray, list], ids=["array", "list"])
def test_a_single_call_that_overflows_says_which_number_did_it(arm: mf.Robot, name: str, kind: object) -> None:
    inputs = [kind(SMALL if each != "qd" else SMALL * 1e200) for each in CATALOGUE[name].inputs]  # type: ignore[operator]
    with pytest.raises(InputError) as caught:
        getattr(arm, name)(*inputs)
    assert caught.value.key == "call.overflow"
    assert caught.value.details["input"] == "qd"
    assert "4e+199" in caught.value.message("en")
    assert caught.value.message("en") != caught.value.message("ar")


def test_efforts_that_overflow_are_said_too(arm: mf.Robot) -> None:
    with pytest.raises(InputError, match=r"5e\+307 in tau"):
        arm.forward_dynamics(SMALL, SMALL, np.full(3, 5e307))
    with pytest.raises(InputError, match="range of floating-point"):
        arm.fused_routine("mass_matrix", "velocity_torque")(SMALL, SMALL * 1e200)
    with pytest.raises(InputError, match="range of floating-point"):
        arm.velocity_torque(SMALL, SMALL * 1e200, out=np.empty(3))


def test_in_a_batch_the_row_that_overflows_stays_alone(arm: mf.Robot) -> None:
    rates = np.stack([SMALL, SMALL * 1e200, SMALL])
    found = arm.velocity_torque(SMALL, rates)
    assert not np.isfinite(found[1]).any()
    np.testing.assert_array_equal(found[[0, 2]], arm.velocity_torque(SMALL, rates[[0, 2]]))


def test_large_numbers_that_do_not_overflow_keep_their_result(arm: mf.Robot) -> None:
    rates = SMALL * 1e80
    expected = 1e160 * arm.velocity_torque(SMALL, SMALL)
    np.testing.assert_allclose(arm.velocity_torque(SMALL, rates), expected, rtol=1e-13)
    turned = arm.forward_kinematics(np.array([1e70, 0.0, 0.0]))
    np.testing.assert_allclose(np.linalg.det(turned), 1.0, rtol=1e-12)


def test_a_robot_without_joints_has_poses() -> None:
    table, lamp = Link("table", Inertial(1.0)), Link("lamp")
    T = pose.exp([0.1, 0.2, 0.3, 1.0, 2.0, 3.0])
    stand = Joint("stand", JointKind.FIXED, "table", "lamp", T_pj=T)
    robot = mf.Robot(Mechanism.assemble("desk", [table, lamp], [stand]))
    np.testing.assert_allclose(robot.forward_kinematics([]), T, atol=1e-15)
    np.testing.assert_allclose(robot.forward_kinematics(np.zeros((2, 0)), frame="table"), np.stack([np.eye(4)] * 2))
    assert robot.link_poses(np.zeros((5, 0))).shape == (5, 2, 4, 4)
    out = np.empty((4, 4))
    assert robot.forward_kinematics(np.zeros(0), out=out) is out
    again = pickle.loads(pickle.dumps(robot.forward_kinematics))
    np.testing.assert_array_equal(again([]), out)
    np.testing.assert_array_equal(copy.copy(robot).forward_kinematics([]), out)
    with pytest.raises(InputError):
        robot.forward_kinematics([0.1])
    with pytest.raises(ModelError, match="lamp"):
        robot.forward_kinematics([], frame="sofa")
    with pytest.raises(InputError, match="frame"):
        robot.link_poses([], frame="lamp")


@pytest.mark.parametrize("q", [[0, -45, 0, -90, 0, 90, 45], [0.0, 0.0, 0.0, -2.0, 0.0, 90.5, 0.0]])
def test_angles_that_look_like_degrees_are_hinted_at_once(q: list[float]) -> None:
    robot = mf.load("panda")
    with pytest.warns(InputWarning, match="numpy.radians") as caught:
        robot.forward_kinematics(q)
    assert caught[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        robot.forward_kinematics(q)


@pytest.mark.parametrize(
    "q", [[0, -1, 0, -2, 0, 2, 1], [0.1, -0.4, 0.2, -7.0, 0.1, 1.2, 0.3], np.full((2, 7), 30.0), np.zeros((0, 7))]
)
def test_angles_that_may_be_radians_are_left_alone(q: object) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mf.load("panda").forward_kinematics(q)  # type: ignore[arg-type]


def test_slides_are_no_angles_and_free_joints_may_turn_for_long() -> None:
    robot = mf.load("scara_rrrp")
    slide = robot.mechanism.coordinates.index(
        next(joint for joint in robot.mechanism.coordinates if joint.kind is JointKind.PRISMATIC)
    )
    q = np.zeros(robot.n)
    q[slide] = 100.0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        robot.forward_kinematics(q.tolist())
        mf.Robot.from_screws([[0, 0, 1, 0, 0, 0]], np.eye(4)).forward_kinematics([31.7])


@pytest.mark.parametrize("distance", [1e120, 1e300])
def test_a_pose_beyond_all_numbers_is_named_alike_by_both_inverses(distance: float) -> None:
    robot, T = mf.load("puma560"), np.eye(4)
    T[0, 3] = distance
    said = []
    for solve in (mf.inverse_kinematics, mf.solve_ik):
        with pytest.raises(InputError, match=r"beyond 1e\+100") as caught:
            solve(robot, T)
        said.append(str(caught.value))
        assert not solve(robot, T[None]).solved.any()
    assert said[0] == said[1]


def test_a_motion_that_blew_up_is_not_taken_for_degrees(recwarn):
    mf.load("planar2r").forward_kinematics([1e35, 2e35])
    assert not recwarn.list
