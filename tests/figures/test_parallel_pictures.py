"""Pictures of parallel robots: they show what they say, and the same picture is the same file."""

import numpy as np
import pytest

from mafsil import parallel as pa
from mafsil.figures import parallel_robot as pictures
from mafsil.geometry import pose
from mafsil.mobility import FourBar

HOME = pose.from_translation([0.1, -0.2, 1.6])


def stewart():
    return pa.StewartPlatform.on_circles(
        2.0, 1.0, np.radians([-15, 15, 105, 135, 225, 255]), np.radians([-45, 45, 75, 165, 195, 285])
    )


CASES = {
    "stewart": lambda path: pictures.save_platform(stewart(), HOME, path),
    "delta": lambda path: pictures.save_delta(pa.DeltaRobot(0.4, 0.1, 0.5, 1.0), [0.3, 0.1, -0.2], path),
    "eclipse": lambda path: pictures.save_eclipse(pa.Eclipse(1.0, 1.0, 0.3), pose.from_translation([0, 0, 1.2]), path),
    "planar": lambda path: pictures.save_planar_platform(
        pa.PlanarThreeRPR([[0, 0], [4, 0], [2, 3.5]], [[-0.5, -0.3], [0.5, -0.3], [0, 0.6]]), [2.1, 1.3, 0.35], path
    ),
    "five_bar": lambda path: pictures.save_five_bar(
        pa.FiveBar(2, 3, 3, 2, 2), [1.308996939, 0.0, -2.556789314, -0.446490054], path
    ),
    "curve": lambda path: pictures.save_four_bar_curve(FourBar(4, 4, 2, 2), path),
}


@pytest.mark.capability("08-61")
@pytest.mark.parametrize("name", CASES)
def test_a_picture_is_written_and_the_same_again(name, tmp_path):
    first, again = tmp_path / f"{name}.svg", tmp_path / f"{name} again.svg"
    CASES[name](first)
    CASES[name](again)
    assert first.stat().st_size > 5000
    assert first.read_bytes() == again.read_bytes()


@pytest.mark.capability("08-48", "08-61")
def test_the_curve_marks_where_branches_cross():
    axes = pictures.draw_four_bar_curve(FourBar(4, 4, 2, 2)).axes[0]
    points = [line.get_xydata()[0] for line in axes.lines if line.get_marker() == "o"]
    np.testing.assert_allclose(sorted(map(tuple, points)), [(0, 180), (180, 180)])


@pytest.mark.capability("08-61")
def test_driven_joints_are_filled_and_a_blocked_velocity_is_dotted():
    robot, theta = pa.FiveBar(2, 3, 3, 2, 2), np.array([1.308996939, 0.0, -2.556789314, -0.446490054])
    axes = pictures.draw_five_bar(robot, theta, robot.singularity(theta)).axes[0]
    joints = [line for line in axes.lines if line.get_marker() == "o"]
    assert [line.get_markerfacecolor() != "white" for line in joints] == [True, False, False, False, True]
    (dotted,) = [line for line in axes.lines if line.get_linestyle() == ":"]
    along = np.diff(dotted.get_xydata(), axis=0)[0]
    np.testing.assert_allclose(np.abs(along / np.linalg.norm(along)), [0.258819045, 0.965925826], atol=1e-6)
