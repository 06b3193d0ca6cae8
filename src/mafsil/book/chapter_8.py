"""Figures of chapter 8: parallel robots with their vectors, four-bar and five-bar and their singular poses."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, pi, radians, sin

import numpy as np

import mafsil.parallel as pa
from mafsil.arrays import Floats
from mafsil.book.drawing import add_linkage
from mafsil.book.entry import EntryStatus, Fact, Slider
from mafsil.book.figure import Drawing, draws
from mafsil.figures.panel import ACCENT, BLUE, COLOURS, GREEN, INK, RED, SOFT, Panel
from mafsil.figures.parallel_robot import joint_places
from mafsil.geometry import pose
from mafsil.mobility import FourBar
from mafsil.parallel.planar import output_angles, singular_points

BASE = np.array([[0.0, 0.0], [4.0, 0.0], [2.0, 3.5]])
PLATFORM = np.array([[-0.5, -0.3], [0.5, -0.3], [0.0, 0.6]])
"""Joints of the planar platform of figure 8.4 [m]."""
UP = np.array([0.0, 0.0, 1.0])


@draws("8.1", height=Slider(0.8, 2.4, 1.6, "m"), turn=Slider(-1.0, 1.0, 0.2))
def stewart_platform(height: float, turn: float) -> Drawing:
    """A platform on six legs, frames of base and platform, and the vectors of a leg."""
    robot = pa.StewartPlatform.on_circles(
        2.0, 1.0, np.radians([-15, 15, 105, 135, 225, 255]), np.radians([-45, 45, 75, 165, 195, 285])
    )
    T = pose.from_translation([0.1, -0.2, height])
    T[:2, :2] = [[cos(turn), -sin(turn)], [sin(turn), cos(turn)]]
    d = robot.leg_vectors(T)
    panel = Panel(zoom=1.3).fill(robot.base, SOFT, name="base").fill(robot.base + d, ACCENT, 0.4, name="platform")
    for k, (a, leg) in enumerate(zip(robot.base, d, strict=True)):
        panel.line([a, a + leg], BLUE, width=3.0, name=f"leg {k + 1}")
    panel.frame(np.eye(4), 0.7, "s").frame(T, 0.6, "b")
    p, a, b = T[:3, 3], robot.base[0], robot.base[0] + d[0]
    panel.arrow([0, 0, 0], p, "$p$", colour=RED, reach=0.5, name="p").arrow(
        [0, 0, 0], a, "$a_1$", colour=RED, reach=0.6
    )
    panel.arrow(p, b - p, "$b_1$", colour=RED, reach=0.6).label((a + b) / 2, "$d_1$", INK, (12, 0))
    facts = Fact("lengths", robot.lengths(T), unit="m"), Fact("rank", int(np.linalg.matrix_rank(robot.jacobian(T))))
    return Drawing({"a": panel}, {"robot": robot, "T_sb": T}, facts)


@draws(
    "8.2", status=EntryStatus.REBUILT, q1=Slider(-0.4, 0.9, 0.3), q2=Slider(-0.4, 0.9, 0.1), q3=Slider(-0.4, 0.9, 0.2)
)
def delta_robot(q1: float, q2: float, q3: float) -> Drawing:
    """A Delta robot hanging from its base; the platform keeps its orientation."""
    robot, q = pa.DeltaRobot(0.4, 0.1, 0.5, 1.0), np.array([q1, q2, q3])
    p, u = robot.forward_kinematics(q).x[0], robot.directions
    elbows, ends = robot.elbows(q) + robot.platform * u, p + robot.platform * u
    panel = (
        Panel(elevation=12.0, zoom=1.3).fill(robot.base * u, SOFT, name="base").fill(ends, ACCENT, 0.5, name="platform")
    )
    for k in range(3):
        across = 0.07 * np.cross(UP, u[k])
        panel.line([robot.base * u[k], elbows[k]], BLUE, width=4.0, name=f"arm {k + 1}").dots(robot.base * u[k], GREEN)
        for side in (-1, 1):
            panel.line([elbows[k] + side * across, ends[k] + side * across], INK, width=1.2, name=f"rod {k + 1} {side}")
        panel.line([elbows[k] - across, elbows[k] + across], INK).line([ends[k] - across, ends[k] + across], INK)
    return Drawing({"a": panel}, {"robot": robot, "q": q}, [Fact("place", p, unit="m")])


@draws("8.3", status=EntryStatus.SCHEMATIC, tilt=Slider(-0.6, 0.6, 0.25))
def eclipse(tilt: float) -> Drawing:
    """The Eclipse by its published architecture: columns on a circle, blocks, rods, platform."""
    robot, T = pa.Eclipse(1.0, 1.0, 0.3), pose.from_translation([0.0, 0.0, 1.2])
    T[np.ix_([0, 2], [0, 2])] = [[cos(tilt), sin(tilt)], [-sin(tilt), cos(tilt)]]
    feet, ends = robot.feet(T), robot.platform_joints(T)
    t = np.linspace(0, 2 * pi, 121)
    panel = Panel(zoom=1.25).line(np.column_stack([np.cos(t), np.sin(t), 0 * t]), SOFT, width=3.0, name="guide")
    panel.fill(ends, ACCENT, 0.5, name="platform").frame(T, 0.3, "b")
    for k, (foot, end) in enumerate(zip(feet, ends, strict=True)):
        panel.line([foot * [1, 1, 0], foot], SOFT, width=4.0, name=f"column {k + 1}").dots(foot, GREEN, "s", 7.0)
        panel.line([foot, end], BLUE, width=3.0, name=f"rod {k + 1}")
    facts = [Fact("rod", np.linalg.norm(ends - feet, axis=1), unit="m")]
    return Drawing({"a": panel}, {"robot": robot, "T_sb": T}, facts)


@draws("8.4", x=Slider(1.2, 2.8, 2.1, "m"), y=Slider(0.6, 2.2, 1.3, "m"), phi=Slider(-1.0, 1.0, radians(20.0)))
def planar_three_rpr(x: float, y: float, phi: float) -> Drawing:
    """A planar platform on three sliding legs with its vectors."""
    robot = pa.PlanarThreeRPR(BASE, PLATFORM)
    place = np.array([x, y, phi])
    d = robot.leg_vectors(place)
    ends = robot.base + d
    panel = Panel().fill(ends, ACCENT, name="platform").arrow([0, 0], [x, y], "$p$", colour=RED, reach=0.55, name="p")
    for k, (a, leg) in enumerate(zip(robot.base, d, strict=True)):
        panel.line([a, a + leg], BLUE, width=3.0, name=f"leg {k + 1}").dots(a, INK, "^", 10.0).dots(a + leg, INK)
        panel.label(a + 0.5 * leg, f"$d_{k + 1}$", offset=(10, 8)).label(a, f"$a_{k + 1}$", offset=(0, -14))
        panel.label(a + leg, f"$b_{k + 1}$", ACCENT, (9, 9))
    T = np.array([[cos(phi), -sin(phi), x], [sin(phi), cos(phi), y], [0, 0, 1]])
    panel.frame(T, 0.7, "b").frame(np.eye(3), 0.7, "s")
    lengths = robot.lengths(place)
    facts = Fact("lengths", lengths, unit="m"), Fact("modes", len(robot.forward_kinematics(lengths)))
    return Drawing({"a": panel}, {"robot": robot, "pose": place}, facts)


@draws("8.5")
def three_chains() -> Drawing:
    """A platform carried by three chains of five joints; the first of each slides and is driven."""
    legs = pa.three_rps(1.0, 0.5, 1.0)
    closed = pa.leg_forward(legs, [0.1, -0.05, 0.15])
    T, panel = legs.poses(closed.q)[0], Panel(zoom=1.3)
    feet, ends = list[Floats](), list[Floats]()
    for k, J in enumerate(legs.leg_jacobians(closed.q)):
        places = joint_places(J, T[:3, 3])
        panel.line(places, BLUE, width=2.4, name=f"chain {k + 1}").dots(places, INK, width=6.0)
        panel.label(places[0], (r"$\theta$", r"$\varphi$", r"$\psi$")[k], offset=(-12, 0))
        feet.append(places[0])
        ends.append(places[-1])
    panel.fill(feet, SOFT, name="base").fill(ends, ACCENT, 0.4, name="platform").frame(np.eye(4), 0.4, "s").frame(
        T, 0.3, "b"
    )
    facts = Fact("mobility", legs.counted_mobility), Fact("gap", float(np.abs(legs.closure(closed.q)).max()))
    return Drawing({"a": panel}, {"legs": legs, "q": closed.q}, facts)


def _curve(linkage: FourBar) -> Panel:
    panel = Panel((r"$\theta$ [rad]", r"$\varphi$ [rad]"), limits=(0.0, 2 * pi, 0.0, 2 * pi))
    theta = np.linspace(0, 2 * pi, 1441)
    answer = output_angles(linkage, theta)
    for k, branch in enumerate(np.where(answer.missing > 0.0, np.nan, answer.phi.T % (2 * pi))):
        jumps = np.abs(np.diff(branch, append=branch[-1])) > pi
        panel.line(np.column_stack([theta, np.where(jumps, np.nan, branch)]), COLOURS[k], width=1.8, name=f"branch {k}")
    for point in singular_points(linkage):
        panel.dots([point.theta % (2 * pi), point.phi % (2 * pi)], RED, width=8.0, name="crossing")
    return panel


@draws("8.6", status=EntryStatus.REBUILT, crank=Slider(0.0, 2 * pi, 1.0))
def four_bar_and_its_curve(crank: float) -> Drawing:
    """The four-bar of the printed lengths, its curve, and a four-bar whose curve does cross itself."""
    printed, crossing = FourBar(4.0, 4.0, 3.0, 2.0), FourBar(4.0, 3.0, 3.0, 2.0)
    gap = output_angles(printed, np.linspace(0, 2 * pi, 721)).phi
    apart = np.abs((gap[:, 0] - gap[:, 1] + pi) % (2 * pi) - pi).min()
    facts = (
        Fact("printed_crossings", len(singular_points(printed)), 1),
        Fact("crossings", len(singular_points(crossing))), Fact("apart", float(apart), unit="rad"),
    )  # fmt: skip
    panels = {"a": add_linkage(Panel(), printed.linkage(crank)), "b": _curve(printed), "c": _curve(crossing)}
    return Drawing(panels, {"printed": printed, "crossing": crossing}, facts)


def _five_bar(robot: pa.FiveBar, theta: Floats, driven: Sequence[int] = (0, 4)) -> tuple[Panel, pa.LoopSingularities]:
    """Bars, joints (driven ones filled), a blocked velocity as a dotted line through the tip."""
    s = np.cumsum(theta[:4])
    steps = robot.chain.lengths[:4, None] * np.column_stack([np.cos(s), np.sin(s)])
    places = np.vstack([[0.0, 0.0], np.cumsum(steps, axis=0)])
    finding = robot.singularity(theta[:4], driven)
    panel = Panel().line([[0, 0], [robot.ground, 0]], SOFT, "--").line(places, BLUE, width=4.0, name="bars")
    panel.dots(places, INK, width=9.0, name="joints").dots(places, "white", width=5.5)
    panel.dots(places[[*driven]], RED, width=10.0, name="driven")
    if finding.blocked.size:
        along = 0.5 * robot.chain.size * np.ravel(finding.blocked)[:2]
        panel.line([places[2] - along, places[2] + along], RED, ":", 2.0, name="blocked")
    return panel, finding


@draws("8.7", alpha=Slider(0.6, 2.6, 1.9), beta=Slider(0.3, 2.4, 1.1))
def five_bar(alpha: float, beta: float) -> Drawing:
    """A five-bar with its relative angles."""
    robot = pa.FiveBar(2.0, 3.0, 3.0, 2.0, 2.0)
    theta = robot.chain_angles([alpha, beta])
    panel, finding = _five_bar(robot, theta)
    s, places = np.cumsum(theta), panel["bars"]
    for k in range(4):
        before = 0.0 if k == 0 else float(s[k - 1])
        ahead = np.array([cos(before), sin(before)])
        panel.line([places[k], places[k] + 0.9 * ahead], SOFT, ":")
        panel.arc(places[k], 0.45, (before, before + float(theta[k])), rf"$\theta_{k + 1}$", name=f"theta {k + 1}")
    facts = Fact("theta", theta, unit="rad"), Fact("modes", len(robot.forward_kinematics([alpha, beta]).x))
    return Drawing({"a": panel}, {"robot": robot, "finding": finding}, facts)


@draws("8.8", status=EntryStatus.REBUILT)
def five_bar_flat() -> Drawing:
    """Singular poses of the configuration space: all bars in one line."""
    robot = pa.FiveBar(1.0, 1.0, 1.0, 1.0, 2.0)
    flat = robot.chain.collinear_configurations()
    panels: dict[str, Panel] = {}
    ranks: list[int] = []
    for name, theta in zip("abc", flat, strict=False):
        panels[name], finding = _five_bar(robot, theta)
        ranks.append(finding.rank)
    return Drawing(panels, {"robot": robot, "flat": flat}, [Fact("count", len(flat)), Fact("rank", ranks)])


@draws("8.9", status=EntryStatus.REBUILT)
def five_bar_motors() -> Drawing:
    """Actuator singularities of a five-bar: inner bars stretched, and inner bars folded on each other."""
    stretched, folded = pa.FiveBar(1.0, 1.0, 1.0, 1.0, 2.0), pa.FiveBar(1.0, 1.0, 1.0, 1.0, 1.0)
    panels: dict[str, Panel] = {}
    panels["a"], first = _five_bar(stretched, np.radians([90.0, -90.0, 0.0, -90.0]))
    panels["b"], second = _five_bar(folded, folded.chain_angles([pi / 3, 2 * pi / 3]))
    facts = Fact("form_a", first.second_order), Fact("form_b", second.second_order)
    kinds = {"a": first.findings[0].name, "b": second.findings[0].name}
    return Drawing(panels, {"a": stretched, "b": folded, "kinds": kinds}, facts, cell=(4.2, 3.8))


@draws("8.10", status=EntryStatus.REBUILT)
def five_bar_tip() -> Drawing:
    """End-effector singularity: crank and rod in one line block the tip along them."""
    robot = pa.FiveBar(2.0, 3.0, 3.0, 2.0, 2.0)
    panel, finding = _five_bar(robot, np.array([radians(75.0), 0.0, -2.556789314, -0.446490054]))
    facts = [Fact("blocked", np.abs(np.ravel(finding.blocked)))]
    return Drawing({"a": panel}, {"robot": robot, "finding": finding}, facts)
