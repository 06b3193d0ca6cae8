"""Figures of chapter 6: screws moved by the adjoint map, space Jacobians, statics, singularities, manipulability."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np

from mafsil.arrays import Floats, Vector3
from mafsil.book.chapter_5 import meeting_point
from mafsil.book.drawing import add_arm, rim
from mafsil.book.entry import EntryStatus, Fact, Slider
from mafsil.book.figure import Drawing, draws
from mafsil.figures.panel import ACCENT, COLOURS, INK, RED, SECOND, SOFT, Panel
from mafsil.geometry import pose, rotation, screw, twist
from mafsil.model.library import textbook
from mafsil.performance import velocity_ellipsoid
from mafsil.robot import Robot

ARM = textbook.elbow6r(1.0, 1.0)


def _rank(J: Floats) -> int:
    return int(np.linalg.matrix_rank(J, tol=1e-9))


@draws("6.1", angle=Slider(-pi, pi, 0.8), shift=Slider(0.2, 1.5, 0.9, "m"))
def two_readings_of_the_adjoint_map(angle: float, shift: float) -> Drawing:
    """The same screw in two frames, and a screw carried along by a motion."""
    T = pose.from_rotation_translation(rotation.from_axis_angle([0, 0, 1.0], angle), [shift, 0.4, 0.2])
    S = screw.from_axis([0.0, 0.6, 0.8], [0.7, 0.2, 0.1], 0.0)
    moved, seen = twist.transform(T, S), twist.transform(pose.inverse(T), S)
    same = Panel().frame(np.eye(4), 0.5, "a").frame(T, 0.5, "b")
    _axis(same, S, "$S$", ACCENT, "S")
    both = Panel().frame(np.eye(4), 0.5, "s")
    _axis(both, S, "$S$", ACCENT, "S")
    _axis(both, moved, r"$\mathrm{Ad}_T S$", SECOND, "moved")
    foot = np.asarray(screw.nearest_point(S))
    gap = (T @ np.append(foot, 1.0))[:3]
    both.line([foot, gap], SOFT, "--", name="carried")
    facts = Fact("S_b", seen), Fact("moved", moved)
    return Drawing({"a": same, "b": both}, {"T": T, "S": S, "moved": moved, "seen": seen}, facts)


def _axis(panel: Panel, S: Floats, text: str, colour: str, name: str) -> None:
    """The line of a screw about its point nearest to the origin."""
    foot, omega = np.asarray(screw.nearest_point(S)), S[:3]
    panel.line([foot - 0.5 * omega, foot + 1.1 * omega], colour, "-.", name=name).dots(foot, colour)
    panel.arrow(foot, 0.8 * omega, text, colour=colour, reach=1.5)


@draws("6.2", q1=Slider(-pi, pi, 0.5), q2=Slider(-pi, pi, 0.9), q4=Slider(0.0, 0.8, 0.4, "m"))
def jacobian_of_rrrp(q1: float, q2: float, q4: float) -> Drawing:
    """Axes and points of the columns of a SCARA-type arm."""
    robot, q = Robot(textbook.scara_rrrp(0.8, 1.0, 0.7)), np.array([q1, q2, 0.3, q4])
    corners = [(0, (0, 0, 0)), (1, (0, 0, 0.8)), (2, (1.0, 0, 0.8)), (3, (1.7, 0, 0.8))]
    J = robot.jacobian_space(q)
    points = [np.zeros(3), np.array([cos(q1), sin(q1), 0.0])]
    points.append(points[1] + 0.7 * np.array([cos(q1 + q2), sin(q1 + q2), 0.0]))
    panel = add_arm(Panel(), robot, q, through=corners)
    for k, point in enumerate(points):
        panel.dots(point, RED, name=f"q{k + 1}").label(point - [0, 0, 0.12], f"$q_{k + 1}$", RED)
    columns = np.array([[0, 0, 1, *-np.cross([0, 0, 1], p)] for p in points]).T
    gap = float(np.abs(J[:, :3] - columns).max())
    return Drawing({"arm": panel}, {"robot": robot, "q": q, "J": J}, [Fact("gap", gap), Fact("v4", J[3:, 3])])


@draws("6.3", status=EntryStatus.REBUILT, q1=Slider(-pi, pi, 0.4), q2=Slider(-1.5, 1.5, -0.5), q4=Slider(-pi, pi, 0.6))
def jacobian_of_rrprrr(q1: float, q2: float, q4: float) -> Drawing:
    """Axes of an arm with a prismatic third joint and a wrist whose first axis is upright at zero."""
    robot, q = Robot(textbook.rrprrr_upright(1.0, 0.8)), np.array([q1, q2, 0.3, q4, 0.5, 0.0])
    J = robot.jacobian_space(q)
    c1, s1, c2, s2, c4, s4 = cos(q1), sin(q1), cos(q2), sin(q2), cos(q4), sin(q4)
    w5 = np.array([-c1 * c4 + s1 * c2 * s4, -s1 * c4 - c1 * c2 * s4, s2 * s4])
    centre = meeting_point(J[:, 3:])
    corners = [(0, (0, 0, 0)), (1, (0, 0, 1.0)), (3, (0, 0.8, 1.0))]
    panel = add_arm(Panel(), robot, q, through=corners).dots(centre, RED, name="q_w")
    facts = (
        Fact("w5", J[:3, 4]), Fact("gap", float(np.abs(J[:3, 4] - w5).max())),
        Fact("centre", centre, unit="m"), Fact("rank", _rank(J)),
    )  # fmt: skip
    return Drawing({"arm": panel}, {"robot": robot, "q": q, "J": J}, facts)


@draws("6.4", angle=Slider(-pi, pi, 0.9), force=Slider(1.0, 20.0, 10.0, "N"))
def force_and_moment(angle: float, force: float) -> Drawing:
    """A force at a point, and its moment about the frame at right angles to both."""
    r, f = np.array([1.2, 0.5, 0.3]), force * np.array([cos(angle), sin(angle), 0.6])
    m = np.cross(r, f)
    panel = Panel().frame(np.eye(4), 0.5, "s").line([np.zeros(3), r], SOFT, "--", name="r")
    panel.label(r / 2 + [0, 0, 0.1], "$r$", SOFT).dots(r, name="point")
    panel.arrow(r, 0.8 * f / np.linalg.norm(f), "$f$", colour=RED, name="f")
    panel.arrow(np.zeros(3), 0.8 * m / np.linalg.norm(m), r"$m = r \times f$", colour=SECOND, name="m", reach=1.25)
    facts = Fact("m", m, unit="N m"), Fact("across", float(abs(m @ f) + abs(m @ r)))
    return Drawing({"wrench": panel}, {"r": r, "F": np.concatenate([m, f])}, facts)


@draws("6.5", yaw=Slider(-pi, pi, 1.0), tilt=Slider(-pi, pi, 0.6))
def base_and_tool_do_not_matter(yaw: float, tilt: float) -> Drawing:
    """A stretched arm with two base frames and two tool frames: the rank of every Jacobian is the same."""
    robot, q = Robot(ARM), np.array([0.3, 0.6, 0.0, 0.2, 0.8, 0.1])
    base = pose.from_rotation_translation(rotation.from_rpy([0, 0, yaw]), [-0.7, 0.5, 0.0])
    tool = pose.from_rotation_translation(rotation.from_rpy([tilt, 0, 0]), [0.3, 0.1, 0.2])
    J_s, J_b = robot.jacobian_space(q), robot.jacobian_body(q)
    moved = np.column_stack([twist.transform(pose.inverse(base), S) for S in J_s.T])
    held = np.column_stack([twist.transform(pose.inverse(tool), S) for S in J_b.T])
    T = np.asarray(robot.forward_kinematics(q))
    panel = add_arm(Panel(), robot, q).frame(base, 0.4, "s'").frame(T @ tool, 0.4, "b'")
    facts = [Fact(name, _rank(J)) for name, J in (("space", J_s), ("body", J_b), ("base", moved), ("tool", held))]
    return Drawing({"arm": panel}, {"robot": robot, "q": q, "base": base, "tool": tool}, facts)


def _singular(q: Floats, columns: tuple[int, ...]) -> Drawing:
    """The elbow arm with some axes emphasised; the rank of its Jacobian and of these columns."""
    robot = Robot(ARM)
    J = robot.jacobian_space(q)
    panel = add_arm(Panel(), robot, q)
    for k in columns:
        panel.line(panel[f"axis {k + 1}"], RED, width=2.6, name=f"bold {k + 1}")
    facts = Fact("rank", _rank(J)), Fact("of_columns", _rank(J[:, list(columns)]))
    return Drawing({"arm": panel}, {"robot": robot, "q": q, "columns": J[:, list(columns)]}, facts)


@draws("6.6", q5=Slider(-1.5, 1.5, 0.0))
def two_collinear_axes(q5: float) -> Drawing:
    """The first and the last axis of the wrist on one line."""
    return _singular(np.array([0.3, 0.7, -1.1, 0.4, q5, 0.2]), (3, 5))


@draws("6.7", q3=Slider(-1.5, 1.5, 0.0))
def three_parallel_coplanar_axes(q3: float) -> Drawing:
    """Shoulder, elbow and wrist axes parallel and, with the arm stretched, in one plane."""
    return _singular(np.array([0.3, 0.7, q3, 0.0, 0.8, 0.2]), (1, 2, 4))


@draws("6.8", q2=Slider(0.3, 1.4, 0.9), error=Slider(-0.5, 0.5, 0.0))
def four_axes_through_one_point(q2: float, error: float) -> Drawing:
    """The wrist centre on the first axis: this and the wrist's three meet there."""
    q = np.array([0.3, q2, pi - 2 * q2 + error, 0.5, 0.8, 0.2])
    drawing = _singular(q, (0, 3, 4, 5))
    centre = meeting_point(drawing.objects["columns"])
    drawing.panels["arm"].dots(centre, RED, width=8.0, name="meeting point")
    return Drawing(drawing.panels, drawing.objects, [*drawing.facts, Fact("centre", centre, unit="m")])


@draws("6.9", status=EntryStatus.REBUILT, L2=Slider(0.5, 1.5, 1.0, "m"))
def manipulability_ellipses(L2: float) -> Drawing:
    """A planar 2R arm with link 1 of 1 m at four angles of its elbow, and the ellipse of tip velocities of each."""
    robot = Robot(textbook.planar2r((1.0, L2)))
    elbows = np.array([0.35, pi / 2, 2.2, 2.9])
    panel, found = Panel(("$x$ [m]", "$y$ [m]")), list[Vector3]()
    for k, (shoulder, elbow) in enumerate(zip((-0.2, 0.25, 0.9, 1.6), elbows, strict=True)):
        q = np.array([shoulder, elbow])
        ellipsoid = velocity_ellipsoid(robot, q, "planar")
        tip = np.asarray(robot.forward_kinematics(q))[:2, 3]
        points = robot.link_poses(q)[1:, :2, 3]
        outline = tip + 0.25 * (rim(1.0) * ellipsoid.lengths[:2]) @ ellipsoid.axes[:2, :2].T
        panel.line([*points, tip], COLOURS[k], width=3.0, name=f"arm {k}").dots(points, INK)
        panel.fill(outline, COLOURS[k], 0.15, name=f"ellipse {k}")
        found.append(ellipsoid.lengths[:2])
    facts = Fact("lengths", found[1]), Fact("area", float(found[1].prod()))
    return Drawing({"ellipses": panel}, {"robot": robot, "elbows": elbows, "lengths": found}, facts)
