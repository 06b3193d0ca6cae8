"""What is no robot is refused, by both solvers; names and mechanisms stand for robots."""

import numpy as np
import pytest

import mafsil as mf


@pytest.mark.parametrize("solve", [mf.solve_ik, mf.inverse_kinematics])
@pytest.mark.parametrize("robot", [None, 3])
def test_something_else_than_a_robot(solve, robot) -> None:
    with pytest.raises(mf.InputError, match="a robot is a Robot, a Mechanism"):
        solve(robot, np.eye(4))


@pytest.mark.parametrize("solve", [mf.solve_ik, mf.inverse_kinematics])
def test_a_name_and_a_mechanism_stand_for_robots(solve) -> None:
    robot = mf.load("puma560")
    T = robot.forward_kinematics(np.linspace(0.2, 0.7, 6))
    for other in ("puma560", robot.mechanism):
        np.testing.assert_array_equal(solve(other, T).q, solve(robot, T).q)
