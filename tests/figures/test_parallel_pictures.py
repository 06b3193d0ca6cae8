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
    "stewart": lambda path: pictures.plot_platform(stewart(), HOME, path),
    "delta": lambda path: pictures.plot_delta(pa.DeltaRobot(0.4, 0.1, 0.5, 1.0), [0.3, 0.1, -0.2], path),
    "eclipse": lambda path: pictures.plot_eclipse(pa.Eclipse(1.0, 1.0, 0.3), pose.from_translation([0, 0, 1.2]), path),
    "planar": lambda path: pictures.plot_planar_platform(
        pa.PlanarThreeRPR([[0, 0], [4, 0], [2, 3.5]], [[-0.5, -0.3], [0.5, -0.3], [0, 0.6]]), [2.1, 1.3, 0.35], path
    ),
    "five_bar": lambda path: pictures.plot_five_bar(
        pa.FiveBar(2, 3, 3, 2, 2), [1.308996939, 0.0, -2.556789314, -0.446490054], path
    ),
    "legs": lambda path: pictures.plot_legs(pa.three_rps(1.0, 0.5, 1.0), np.zeros(15), path),
    "curve": lambda path: pictures.plot_four_bar_curve(FourBar(4, 4, 2, 2), path),
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


def drawn(figure):
    """Ends of all straight pieces of two points in space."""
    pieces = [np.column_stack(line.get_data_3d()) for line in figure.axes[0].lines]
    return np.array([piece for piece in pieces if len(piece) == 2])


def shown(pieces, a, b):
    return np.abs(pieces - np.stack([a, b])).max(axis=(1, 2)).min() < 1e-12


@pytest.mark.capability("08-61")
def test_legs_arms_and_rods_are_drawn_from_joint_to_joint():
    robot = stewart()
    pieces = drawn(pictures.draw_platform(robot, HOME))
    ends = robot.platform @ HOME[:3, :3].T + HOME[:3, 3]
    assert all(shown(pieces, a, b) for a, b in zip(robot.base, ends, strict=True))
    delta, q = pa.DeltaRobot(0.4, 0.1, 0.5, 1.0), np.array([0.3, 0.1, -0.2])
    pieces, u = drawn(pictures.draw_delta(delta, q)), delta.directions
    elbow = [0.4 * u[k] + 0.5 * (np.cos(q[k]) * u[k] - np.sin(q[k]) * np.array([0, 0, 1.0])) for k in range(3)]
    assert all(shown(pieces, 0.4 * u[k], elbow[k]) for k in range(3))
    lengths = np.linalg.norm(pieces[:, 1] - pieces[:, 0], axis=1)
    assert (np.abs(lengths - 1.0) < 1e-12).sum() == 6, "two rods for each forearm"
    eclipse, T = pa.Eclipse(1.3, 1.2, 0.35), pose.from_translation([0.1, -0.05, 1.2])
    pieces = drawn(pictures.draw_eclipse(eclipse, T))
    for foot, joint in zip(eclipse.feet(T), eclipse.platform_joints(T), strict=True):
        assert shown(pieces, foot, joint)
        assert shown(pieces, foot * [1, 1, 0], foot)


@pytest.mark.capability("08-61", "08-20")
def test_a_planar_platform_has_its_vectors():
    robot, x = (
        pa.PlanarThreeRPR([[0, 0], [4, 0], [2, 3.5]], [[-0.5, -0.3], [0.5, -0.3], [0, 0.6]]),
        np.array([2.1, 1.3, 0.35]),
    )
    axes = pictures.draw_planar_platform(robot, x).axes[0]
    legs = [line.get_xydata() for line in axes.lines if len(line.get_xydata()) == 2]
    c, s = np.cos(0.35), np.sin(0.35)
    for a, b in zip(robot.base, robot.platform, strict=True):
        end = [2.1 + c * b[0] - s * b[1], 1.3 + s * b[0] + c * b[1]]
        assert min(np.abs(leg - [a, end]).max() for leg in legs) < 1e-12
    words = {text.get_text() for text in axes.texts}
    assert {f"${name}_{k}$" for name in "abd" for k in (1, 2, 3)} | {"$p$"} <= words


@pytest.mark.capability("08-61", "08-15")
def test_joints_of_any_legs_stand_where_their_axes_meet():
    legs = pa.three_rps(1.0, 0.5, 1.0)
    q = pa.leg_forward(legs, [0.1, -0.05, 0.15]).q
    T, J = legs.poses(q)[0], legs.leg_jacobians(q)
    for k, columns in enumerate(J):
        angle = 2 * np.pi * k / 3
        u = np.array([np.cos(angle), np.sin(angle), 0.0])
        hinge, slide, *ball = pictures.joint_places(columns, T[:3, 3])
        end = T[:3, :3] @ (0.5 * u) + T[:3, 3]
        np.testing.assert_allclose(ball, [end] * 3, atol=1e-9)
        np.testing.assert_allclose(hinge, u, atol=1e-9)
        np.testing.assert_allclose(slide, (u + end) / 2, atol=1e-9)
    marks = [(line.get_marker(), line.get_markerfacecolor()) for line in pictures.draw_legs(legs, q).axes[0].lines]
    assert sum(marker == "s" and face == pictures.DRIVEN for marker, face in marks) == 3
    assert sum(marker == "o" and face == "white" for marker, face in marks) >= 12
    robot = stewart()
    for columns, a, b in zip(
        pa.stewart_legs(robot, HOME).leg_jacobians(np.zeros(36)), robot.base, robot.platform, strict=True
    ):
        universal, _, _, *ball = pictures.joint_places(columns, HOME[:3, 3])
        np.testing.assert_allclose(universal, a, atol=1e-9)
        np.testing.assert_allclose(ball[-1], b + HOME[:3, 3], atol=1e-9)
