"""Figures of chapter 7: the planar 2R arm, arms of the PUMA and Stanford types, constructions, Newton's method."""

from __future__ import annotations

from math import acos, atan2, cos, hypot, pi, sin, sqrt

import numpy as np
from numpy.typing import ArrayLike

from mafsil import ik
from mafsil.arrays import Floats
from mafsil.book.drawing import circle, sphere
from mafsil.book.entry import EntryStatus, Fact, Slider
from mafsil.book.figure import Drawing, draws
from mafsil.figures.panel import ACCENT, BLUE, COLOURS, GREEN, INK, RED, SOFT, Panel
from mafsil.geometry import rotation
from mafsil.ik.chain import chain_of
from mafsil.ik.structure import subproblems
from mafsil.robot import Robot, as_robot

HEIGHT, UPPER, FOREARM = 0.6, 0.5, 0.4
"""h, a1, a2 of the spatial arms [m]."""
CENTRE = np.array([0.4, 0.3, 0.9])
"""Wrist centre of the worked numbers [m]."""


def _arm(offset: float = 0.0, sliding: bool = False) -> Robot:
    """The first three joints of an arm of the PUMA type, or of the Stanford type; the tip is the wrist centre."""
    across = np.array([0.0, -1.0, 0.0])
    shoulder, elbow = np.array([0.0, 0.0, HEIGHT]), np.array([UPPER, 0.0, HEIGHT])
    third = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0] if sliding else [*across, *-np.cross(across, elbow)]
    home = np.eye(4)
    home[:3, 3] = UPPER + (0.0 if sliding else FOREARM), offset, HEIGHT
    rows = [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0], [*across, *-np.cross(across, shoulder)], third]
    return Robot.from_screws(np.array(rows), home)


def _solutions(robot: Robot, centre: ArrayLike) -> ik.SolutionSet:
    T = np.eye(4)
    T[:3, 3] = centre
    answer = ik.inverse_kinematics(robot, T, task="position")
    assert isinstance(answer, ik.SolutionSet)
    return answer


def arm_points(robot: Robot, q: Floats, offset: float = 0.0) -> Floats:
    """(5, 3) base, shoulder, the shoulder set off, elbow and wrist centre of an arm of the PUMA type.

    Args:
        robot: whose tip is the wrist centre.
        q: (3,) [rad].
        offset: of the arm's plane, to the left [m].
    """
    ahead, left = np.array([cos(q[0]), sin(q[0]), 0.0]), np.array([-sin(q[0]), cos(q[0]), 0.0])
    shoulder = np.array([0.0, 0.0, HEIGHT])
    elbow = shoulder + offset * left + UPPER * (cos(q[1]) * ahead + [0.0, 0.0, sin(q[1])])
    return np.array([[0, 0, 0], shoulder, shoulder + offset * left, elbow, robot.forward_kinematics(q)[:3, 3]])


def _add_arm(panel: Panel, points: Floats, colour: str = BLUE, name: str = "arm") -> Panel:
    return panel.line(points, colour, width=4.0, name=name).dots(points[1:], INK, width=5.0)


@draws("7.1", x=Slider(-2.4, 2.4, 2.0, "m"), y=Slider(0.1, 2.4, 1.0, "m"))
def planar_arm_and_law_of_cosines(x: float, y: float) -> Drawing:
    """Annulus and both postures of a planar 2R arm; the triangle of the law of cosines."""
    first, second = 2.0, 1.5
    reach = min(max(hypot(x, y), first - second + 1e-9), first + second - 1e-9)
    x, y = reach * x / hypot(x, y), reach * y / hypot(x, y)
    screws = [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0, -first, 0.0]]
    home = np.eye(4)
    home[0, 3] = first + second
    robot = Robot.from_screws(np.array(screws), home)
    solutions = sorted(_solutions(robot, [x, y, 0.0]), key=lambda q: -q[1])
    alpha = acos((reach**2 + first**2 - second**2) / (2 * first * reach))
    beta = acos((first**2 + second**2 - reach**2) / (2 * first * second))
    panels = {"a": Panel(), "b": Panel()}
    for name, radius in (("outer", first + second), ("inner", first - second)):
        panels["a"].arc([0, 0], radius, (0.0, 2 * pi), colour=SOFT, style="--", name=name)
    for k, q in enumerate(solutions):
        elbow = first * np.array([cos(q[0]), sin(q[0])])
        panels["a"].line([[0, 0], elbow, [x, y]], COLOURS[k], width=4.0, name=("down", "up")[k]).dots(elbow, INK)
    q = solutions[0]
    elbow = first * np.array([cos(q[0]), sin(q[0])])
    panels["b"].line([[0, 0], elbow, [x, y]], BLUE, width=4.0, name="arm").line([[0, 0], [x, y]], SOFT, "--")
    panels["b"].arc([0, 0], 0.5, (q[0], q[0] + alpha), r"$\alpha$", name="alpha")
    panels["b"].arc(elbow, 0.35, (q[0] + pi - beta, q[0] + pi), r"$\beta$", name="beta")
    panels["b"].arc([0, 0], 0.9, (0.0, atan2(y, x)), r"$\gamma$", name="gamma").line([[0, 0], [2.2, 0]], SOFT, "--")
    for panel in panels.values():
        panel.dots([[0, 0]], INK, width=7.0).dots([x, y], RED, width=7.0, name="point")
    wrong = (reach**2 + first**2 + second**2) / (2 * first * reach)
    facts = (
        Fact("down", solutions[0], unit="rad"), Fact("up", solutions[-1], unit="rad"),
        Fact("cosine", cos(alpha), wrong),
    )  # fmt: skip
    return Drawing(panels, {"robot": robot, "reach": ik.planar_reach(robot)}, facts)


@draws("7.2", branch=Slider(0.0, 3.0, 0.0, "1"))
def wrist_centre_projected(branch: float) -> Drawing:
    """An arm of the PUMA type without offset, its wrist centre dropped to the plane of the base."""
    robot = _arm()
    solutions = _solutions(robot, CENTRE)
    q = list(solutions)[int(branch)]
    points = arm_points(robot, q)
    foot, theta = CENTRE * [1, 1, 0], q[0]
    panel = _add_arm(Panel().frame(np.eye(4), 0.2, "0"), points)
    panel.line([CENTRE, foot, [0, 0, 0]], SOFT, "--", name="projection").label(CENTRE, "$p$", RED, (10, 8))
    panel.line(circle([0, 0, 0], [0.0, 0.0, 1.0], hypot(*foot[:2])), SOFT, ":")
    arc = np.linspace(0.0, atan2(foot[1], foot[0]), 31)
    panel.line(0.25 * np.column_stack([np.cos(arc), np.sin(arc), 0 * arc]), RED, name="theta_1")
    panel.label([0.29, 0.1, 0.0], r"$\theta_1$", RED)
    facts = Fact("theta_1", theta, unit="rad"), Fact("solutions", len(solutions))
    return Drawing({"a": panel}, {"robot": robot, "solutions": solutions}, facts)


@draws("7.3", status=EntryStatus.REBUILT, offset=Slider(0.0, 0.45, 0.15, "m"))
def shoulder_with_offset(offset: float) -> Drawing:
    """The arm whose plane is set off from axis 1, and both of its arms from above."""
    robot = _arm(offset)
    solutions = sorted(_solutions(robot, CENTRE), key=lambda q: abs(q[0]))
    p, angles = CENTRE[:2], [solutions[0][0], solutions[-1][0]]
    spatial = _add_arm(Panel().frame(np.eye(4), 0.2, "0"), arm_points(robot, solutions[0], offset))
    spatial.line([CENTRE, CENTRE * [1, 1, 0]], SOFT, "--")
    plan = Panel().arc([0, 0], offset, (0.0, 2 * pi), colour=SOFT, style="--", name="cylinder")
    plan.line([[0, 0], p], INK, ":").line([[0, 0], [0.5, 0]], SOFT, "--")
    reach = sqrt(hypot(*p) ** 2 - offset**2)
    for k, (theta, rho) in enumerate(zip(angles, (reach, -reach), strict=True)):
        ahead, left = np.array([cos(theta), sin(theta)]), np.array([-sin(theta), cos(theta)])
        plan.line(
            [[0, 0], offset * left, offset * left + rho * ahead], COLOURS[k], width=3.0, name=("left", "right")[k]
        )
    phi, alpha = atan2(p[1], p[0]), atan2(offset, reach)
    plan.arc([0, 0], 0.34, (0.0, phi), r"$\varphi$", name="phi").arc([0, 0], 0.24, (phi - alpha, phi), r"$\alpha$")
    plan.dots([0, 0], INK, width=7.0).dots(p, RED, width=7.0, name="wrist").label(p, "$p$", RED, (10, 6))
    facts = Fact("left", angles[0], unit="rad"), Fact("right", angles[1], unit="rad"), Fact("alpha", alpha, unit="rad")
    return Drawing({"a": spatial, "b": plan}, {"robot": robot, "solutions": solutions}, facts)


@draws("7.4", free=Slider(-pi, pi, 0.8))
def shoulder_singularity(free: float) -> Drawing:
    """The wrist centre on axis 1: the first angle is free."""
    robot = _arm()
    solutions = _solutions(robot, [0.0, 0.0, 1.2])
    panel = Panel().frame(np.eye(4), 0.2, "0").line([[0, 0, 0], [0, 0, 1.4]], SOFT, "-.", name="axis 1")
    shape = solutions.families[0].at(0.0)
    for k, theta in enumerate((free, free + 2 * pi / 3, free - 2 * pi / 3)):
        points = arm_points(robot, np.array([theta, shape[1], shape[2]]))
        panel.line(points, BLUE if k == 0 else SOFT, width=4.0 if k == 0 else 1.6, name=f"arm {k}")
    panel.dots([0, 0, 1.2], RED, width=8.0, name="wrist")
    facts = Fact("families", len(solutions.families)), Fact("elbow", abs(float(shape[2])), unit="rad")
    return Drawing({"a": panel}, {"robot": robot, "solutions": solutions}, facts)


@draws("7.5")
def four_postures() -> Drawing:
    """Left and right arm, elbow up and down, of an arm with offset."""
    robot, offset = _arm(0.15), 0.15
    solutions = _solutions(robot, CENTRE)
    panels: dict[str, Panel] = {}
    for k, q in enumerate(solutions):
        panel = _add_arm(Panel(azimuth=-70.0).frame(np.eye(4), 0.15), arm_points(robot, q, offset), COLOURS[k])
        panels["abcd"[k]] = panel.dots(CENTRE, RED, width=7.0, name="wrist")
    facts = [Fact(f"posture_{k}", q, unit="rad") for k, q in enumerate(solutions)]
    return Drawing(panels, {"robot": robot, "solutions": solutions}, facts, columns=2)


@draws("7.6")
def generalised_puma() -> Drawing:
    """Axes of the library's generalised PUMA at zero: two that cross, any third, three through the wrist centre."""
    robot = as_robot("generalized_puma")
    chain = chain_of(robot.mechanism)
    assert chain is not None
    structure = ik.structure.arm_structure(robot)
    panel = Panel().frame(np.eye(4), 0.15, "0").dots(structure.wrist_centre, RED, width=8.0, name="wrist")
    for k, (w, q) in enumerate(zip(chain.axes, chain.points, strict=True)):
        foot = structure.wrist_centre if k > 2 else q + (w @ (np.zeros(3) - q)) * w if k < 2 else q
        panel.line([foot - 0.3 * w, foot + 0.3 * w], COLOURS[k % 6], "-.", name=f"axis {k + 1}")
        panel.label(foot + 0.36 * w, rf"$\omega_{k + 1}$", COLOURS[k % 6])
    panel.line([[0, 0, 0], chain.points[2], structure.wrist_centre], SOFT, width=3.0)
    facts = Fact("crossing", float(chain.axes[0] @ chain.axes[1])), Fact("wrist", structure.wrist_centre, unit="m")
    return Drawing({"a": panel}, {"robot": robot, "structure": structure}, facts)


@draws("7.7", distance=Slider(0.3, 2.6, 1.4, "m"))
def turned_to_a_distance(distance: float) -> Drawing:
    """A point turned about an axis until it has a given distance from the origin, seen along the axis."""
    r, p = np.array([1.0, 0.4, 0.0]), np.array([2.0, 0.4, 0.0])
    turns = subproblems.distances([0.0, 0.0, 1.0], r, p, distance).solutions()
    panel = Panel().arc(r[:2], 1.0, (0.0, 2 * pi), colour=BLUE, name="way").dots(r[:2], INK).label(r[:2], "$r$")
    panel.arc([0, 0], distance, (0.0, 2 * pi), colour=ACCENT, name="distance").dots([0, 0], INK).label([0, 0], "$0$")
    panel.dots(p[:2], SOFT, width=8.0, name="start").label(p[:2], "$p$", offset=(12, 0))
    for k, theta in enumerate(turns):
        z = r[:2] + np.array([cos(theta), sin(theta)])
        panel.dots(z, RED, width=8.0, name=f"reached {k}").line([[0, 0], z, r[:2]], SOFT, "--")
    panel.label([-distance / sqrt(2), -distance / sqrt(2)], "$c$", ACCENT, (-8, -8))
    return Drawing({"a": panel}, {"turns": turns}, [Fact("turns", turns, unit="rad"), Fact("count", len(turns))])


@draws("7.8", turn_1=Slider(-pi, pi, 0.7), turn_2=Slider(-pi, pi, -0.4))
def two_circles_on_a_sphere(turn_1: float, turn_2: float) -> Drawing:
    """Two crossing axes that bring a point to another: circles on a sphere that meet where both can be done."""
    w1, w2, p2 = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0]), np.array([0.7, 0.35, 0.62])
    p2 = p2 / np.linalg.norm(p2)
    p1 = rotation.exp(turn_1 * w1) @ rotation.exp(turn_2 * w2) @ p2
    turns = subproblems.two_axes(w1, w2, p2, p1).solutions()
    panel = Panel(zoom=1.3).surface(sphere(1.0), alpha=0.15)
    for name, w, p, colour in (("w_1", w1, p1, ACCENT), ("w_2", w2, p2, BLUE)):
        panel.line(
            circle((w @ p) * w, w, float(np.linalg.norm(np.cross(w, p)))), colour, width=2.0, name=f"circle {name}"
        )
        panel.arrow([0, 0, 0], 1.35 * w, rf"$\omega_{name[-1]}$", colour=colour)
        panel.dots(p, colour, width=8.0, name=f"p {name}").label(1.15 * p, f"$p_{name[-1]}$", colour)
    for k, (_, theta) in enumerate(turns):
        panel.dots(rotation.exp(theta * w2) @ p2, RED, width=8.0, name=f"z {k}")
    return Drawing({"a": panel}, {"turns": turns}, [Fact("turns", turns, unit="rad"), Fact("count", len(turns))])


@draws("7.9")
def stanford_arm() -> Drawing:
    """The first three joints of a Stanford arm: two turns and a stroke."""
    robot = _arm(sliding=True)
    solutions = _solutions(robot, CENTRE)
    q = min(solutions, key=lambda each: abs(each[0]))
    shoulder = np.array([0.0, 0.0, HEIGHT])
    along = (CENTRE - shoulder) / np.linalg.norm(CENTRE - shoulder)
    panel = Panel().frame(np.eye(4), 0.2, "0").line([[0, 0, 0], shoulder], BLUE, width=5.0, name="column")
    panel.line([shoulder, shoulder + UPPER * along], BLUE, width=7.0, name="sleeve")
    panel.line([shoulder, CENTRE], INK, width=2.5, name="rod").dots(CENTRE, RED, width=8.0, name="wrist")
    panel.dots(shoulder, INK, width=8.0).label(CENTRE, "$p$", RED, (10, 8)).label(
        shoulder, r"$\theta_2$", offset=(-14, 8)
    )
    panel.arrow(shoulder + (UPPER + 0.02) * along, 0.12 * along, r"$d_3$", colour=GREEN, reach=1.8)
    facts = (
        Fact("joints", q, unit="rad, rad, m"),
        Fact("stroke", float(np.linalg.norm(CENTRE - shoulder)) - UPPER, unit="m"),
    )
    return Drawing({"a": panel}, {"robot": robot, "solutions": solutions}, facts)


@draws("7.10", start=Slider(0.6, 3.5, 3.2, "1"))
def newton_tangents(start: float) -> Drawing:
    """Tangents of f(x) = x^2 - 2 that lead to its root."""
    record = ik.find_root(lambda x: x**2 - 2.0, [start], lambda x: np.array([[2.0 * x[0]]]), tolerance=1e-9)
    x = record.iterates[:, 0]
    graph = np.linspace(0.5, max(start, float(x.max())) + 0.2, 121)
    panel = Panel(("$x$", "$f(x)$"), equal=False).line(
        np.column_stack([graph, graph**2 - 2]), BLUE, width=2.0, name="f"
    )
    panel.line([[graph[0], 0], [graph[-1], 0]], INK, width=0.8)
    for k in range(min(3, len(x) - 1)):
        panel.line([[x[k], x[k] ** 2 - 2], [x[k + 1], 0]], ACCENT, name=f"tangent {k}")
        panel.line([[x[k], 0], [x[k], x[k] ** 2 - 2]], SOFT, ":").label([x[k], 0], f"$x_{k}$", offset=(0, -12))
    panel.dots([x[-1], 0], RED, width=7.0, name="root")
    facts = Fact("root", float(x[-1])), Fact("steps", len(x) - 1)
    return Drawing({"a": panel}, {"record": record}, facts)
