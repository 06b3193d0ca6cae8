"""What is no robot is refused by name, by both solvers."""

import numpy as np
import pytest

import mafsil as mf


@pytest.mark.parametrize("solve", [mf.solve_ik, mf.inverse_kinematics])
@pytest.mark.parametrize("robot", [None, "panda"])
def test_something_else_than_a_robot(solve, robot) -> None:
    with pytest.raises(mf.InputError, match="robot: expected a Robot"):
        solve(robot, np.eye(4))
