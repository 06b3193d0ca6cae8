"""Figures of chapters 1 and 2: robots, configurations, joints, linkages and their freedoms, torus, task spaces."""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.book.drawing import add_arm, add_linkage, circle, rim, sphere, tube
from mafsil.book.entry import EntryStatus, Fact, Slider
from mafsil.book.figure import Drawing, draws
from mafsil.figures.panel import ACCENT, BLUE, GREEN, INK, PALE, SECOND, SOFT, Panel
from mafsil.geometry import screw
from mafsil.mobility import FourBar, Linkage, SliderCrank, library, locked_mobility, mobility, torus
from mafsil.mobility.bodies import Coin, count_points, planar_body, third_point
from mafsil.mobility.linkages import Kind
from mafsil.mobility.spaces import annulus
from mafsil.model import mechanism_from_screws
from mafsil.model.library import six_joints, textbook
from mafsil.model.placement import translation
from mafsil.performance import tool_jacobian
from mafsil.robot import Robot

REBUILT = EntryStatus.REBUILT


@draws("1.1", status=REBUILT, bend=Slider(-1.5, 1.5, 0.6), height=Slider(0.8, 1.6, 1.2, "m"))
def serial_and_parallel_robot(bend: float, height: float) -> Drawing:
    """A Mitsubishi RV-7FLM and a Stewart-Gough platform."""
    robot, platform = Robot(six_joints.rv7flm()), library.stewart_gough(center=(0.05, -0.1, height))
    q = np.array([0.4, bend, 0.5 + bend, 0.3, 0.7, 0.0])
    arm = add_arm(Panel(), robot, q, letters="J")
    counts = robot.n, mobility(platform).count.mobility
    facts = Fact("arm", counts[0], 6), Fact("platform", counts[1], 6)
    panels = {"a": arm, "b": add_linkage(Panel(), platform, letters=False)}
    return Drawing(panels, {"robot": robot, "platform": platform, "q": q}, facts)


@draws("1.2", status=REBUILT)
def multifingered_hand() -> Drawing:
    """Three fingers of three hinges that touch a body."""
    hand = library.hand(3, 3)
    answer = mobility(hand)
    panel = add_linkage(Panel(), hand, letters=False)
    facts = Fact("loops", hand.loops), Fact("mobility", answer.count.mobility)
    return Drawing({"hand": panel}, {"hand": hand}, facts)


@draws("2.1", door=Slider(0.0, 2.0, 0.8), heading=Slider(-pi, pi, 0.5))
def configurations_of_three_bodies(door: float, heading: float) -> Drawing:
    """A door by one number, a point of the plane by two, a coin on a table by three."""
    edge = np.array([np.cos(door), np.sin(door)])
    opened = Panel().line([[-0.5, 0], [0, 0]], SOFT, width=6.0).line([[0, 0], edge], BLUE, width=4.0, name="door")
    opened.dots([0, 0], name="hinge").arc([0, 0], 0.4, (0.0, door), r"$\theta$", name="angle")
    opened.line([[0, 0], [1.05, 0]], SOFT, "--")
    place = np.array([1.2, 0.8])
    flat = _corner(Panel(), 1.6).dots(place, ACCENT, width=8.0, name="point").label(place, "$(x, y)$", offset=(14, 14))
    flat.line([[place[0], 0], place, [0, place[1]]], SOFT, "--")
    coin = _corner(Panel(), 1.6).fill(place + rim(0.45)[:-1], BLUE, name="coin")
    coin.dots(place, name="centre").label(place, "$(x, y)$", offset=(0, -12))
    coin.arrow(place, 0.45 * np.array([np.cos(heading), np.sin(heading)]), r"$\varphi$", name="nose", reach=1.3)
    freedoms = mobility(library.door()).mobility, len(place), count_points(place + np.eye(3)[:, :2]).nullity
    facts = [Fact(name, n, k + 1) for k, (name, n) in enumerate(zip(("door", "point", "coin"), freedoms, strict=True))]
    return Drawing({"a": opened, "b": flat, "c": coin}, {"door": door, "point": place, "heading": heading}, facts)


@draws("2.2", phi=Slider(-pi, pi, 0.4))
def three_points_of_a_coin(phi: float) -> Drawing:
    """A free, B on a circle about A, C where circles about A and B meet: on one side for each face."""
    A, (ab, ac, bc) = np.array([0.5, 0.3]), (1.2, 0.9, 1.0)
    B = planar_body(A, phi, ab)
    C = third_point(A, B, ac, bc)
    panel = _corner(Panel(), 0.8)
    for name, centre, radius, colour in (("AB", A, ab, SOFT), ("AC", A, ac, PALE), ("BC", B, bc, PALE)):
        panel.line(centre + rim(radius), colour, "--", 1.2, f"circle {name}")
    panel.line([A, B, C, A], BLUE, width=2.2, name="body").arc(A, 0.35, (0.0, phi), r"$\varphi$")
    for name, point in (("A", A), ("B", B), ("C", C)):
        panel.dots(point, name=name, width=7.0).label(point, f"${name}$", offset=(-10, 10))
    panel.dots(third_point(A, B, ac, bc, face_up=False), SOFT, name="other face").line(
        [A, A + np.array([0.6, 0])], SOFT
    )
    return Drawing({"coin": panel}, {"A": A, "B": B, "C": C}, [Fact("freedoms", count_points([A, B, C]).nullity, 3)])


JOINTS = (
    (Kind.REVOLUTE, r"$\theta$"), (Kind.PRISMATIC, "$d$"), (Kind.HELICAL, r"$\theta$"),
    (Kind.CYLINDRICAL, r"$\theta,\ d$"), (Kind.UNIVERSAL, r"$\theta_1,\ \theta_2$"),
    (Kind.SPHERICAL, r"$\theta_1,\ \theta_2,\ \theta_3$"),
)  # fmt: skip
"""Joints of the table with the letters of their coordinates."""


@draws("2.3")
def table_of_joints() -> Drawing:
    """Six joints: each as a solid, with the path of a point of the child along each freedom."""
    panels = {kind.symbol: _joint_symbol(kind, letters) for kind, letters in JOINTS}
    facts = [Fact(kind.symbol, kind.freedoms, n) for (kind, _), n in zip(JOINTS, (1, 1, 1, 2, 2, 3), strict=True)]
    return Drawing(panels, {kind.symbol: kind for kind, _ in JOINTS}, facts)


def _joint_symbol(kind: Kind, letters: str) -> Panel:
    """The solid of a joint about z, and where a point beside it goes."""
    z, x = np.eye(3)[2], np.eye(3)[0]
    panel, start = Panel(zoom=1.35), np.array([0.55, -0.55, 0.25])
    if kind is Kind.SPHERICAL:
        panel.surface(sphere(0.35), SOFT, 0.5).line([[0, 0, 0.35], 1.1 * z], INK, width=5.0)
    elif kind is Kind.UNIVERSAL:
        panel.surface(tube(-0.7 * x, 0.7 * x, 0.09), SOFT, 0.7).surface(tube(-0.7 * z, 0.7 * z, 0.09), SOFT, 0.7)
    else:
        inner = 0.3 if kind is Kind.PRISMATIC else 0.16
        corners = 5 if kind is Kind.PRISMATIC else 25
        panel.surface(tube(-0.5 * z, 0.5 * z, 0.3, corners=corners), SOFT, 0.5)
        panel.surface(tube(-z, z, 0.5 * inner, corners=corners), SOFT, 0.8)
    screws = kind.screws(np.zeros(3), z, x, 0.12)
    for k, (S, colour) in enumerate(zip(screws.T, (ACCENT, BLUE, GREEN), strict=False)):
        reach = 4 * pi if kind is Kind.HELICAL else 2.6 if S[:3].any() else 0.8
        way = screw.displacement(S, np.linspace(0.0, reach, 61))
        path = (way @ np.append(start, 1.0))[:, :3]
        panel.line(path, colour, width=2.2, name=f"freedom {k + 1}").arrow(path[-4], path[-1] - path[-4], colour=colour)
    return panel.label([0.0, 0.0, -1.25], letters, width=11.0)


@draws("2.4", phi=Slider(-pi, pi, 0.6))
def planar_body_coordinates(phi: float) -> Drawing:
    """A body of the plane by its point A and the angle of AB."""
    A, d = np.array([1.0, 0.8]), 1.3
    B = planar_body(A, phi, d)
    R = np.array([[np.cos(phi), -np.sin(phi)], [np.sin(phi), np.cos(phi)]])
    outline = A + rim(1.0) * [1.05, 0.6] @ R.T + 0.5 * d * R[:, 0]
    panel = _corner(Panel(), 1.2).fill(outline[:-1], BLUE, name="body").line([A, B], INK, width=2.0, name="AB")
    panel.line([A, A + np.array([0.9, 0])], SOFT, "--").arc(A, 0.5, (0.0, phi), r"$\varphi_{AB}$", name="angle")
    for name, point in (("A", A), ("B", B)):
        panel.dots(point, name=name, width=7.0).label(point, f"${name}\\,(x_{name}, y_{name})$", offset=(0, -14))
    return Drawing({"body": panel}, {"A": A, "B": B, "phi": phi}, [Fact("B", B, unit="m")])


@draws("2.5", crank=Slider(-pi, pi, 1.0))
def four_bar_and_slider_crank(crank: float) -> Drawing:
    """Four-bar and slider-crank at one angle of their cranks, counted."""
    four_bar, slider = FourBar(2.0, 4.0, 3.5, 4.5).linkage(crank), SliderCrank(1.0, 3.0).linkage(crank)
    return _counted({"four_bar": (four_bar, 1), "slider_crank": (slider, 1)})


def _counted(linkages: dict[str, tuple[Linkage, int]], columns: int | None = None, *, letters: bool = True) -> Drawing:
    """Linkages side by side, each with Gruebler's count beside the printed one."""
    panels = {name: add_linkage(Panel(), each, letters=letters) for name, (each, _) in linkages.items()}
    facts = [
        Fact(f"{name}_count", mobility(each).count.mobility, printed) for name, (each, printed) in linkages.items()
    ]
    return Drawing(panels, {name: each for name, (each, _) in linkages.items()}, facts, columns)


@draws("2.6")
def planar_classics() -> Drawing:
    """A serial chain of k = 4 links, a five-bar, the six-bars of Stephenson and Watt."""
    chain, five = (library.chain(4), 4), (library.five_bar(), 2)
    six = {"stephenson": (library.stephenson(), 1), "watt": (library.watt(), 1)}
    return _counted({"chain": chain, "five_bar": five, **six}, 2, letters=False)


@draws("2.7", status=REBUILT)
def overlapping_joints() -> Drawing:
    """A body on legs RRR, RPR and RRR of which two share a pin."""
    return _counted({"overlap": (library.overlapping_joints(), 3)})


@draws("2.8", angle=Slider(0.3, 2.8, 1.0))
def redundant_bar_and_five_bar(angle: float) -> Drawing:
    """Three parallel cranks, and a five-bar whose middle links lie on each other, beside a regular one."""
    cranks = library.three_cranks(angles=angle)
    folded = library.five_bar(T1=(1.0, 1.0), T2=(1.0, 1.0))
    regular = library.five_bar()
    named = {"parallelogram": cranks, "regular": regular, "singular": folded}
    panels = {name: add_linkage(Panel(), each, letters=name != "parallelogram") for name, each in named.items()}
    locked = [locked_mobility(each, ["O", "D"]) for each in (regular, folded)]
    report = mobility(cranks)
    facts = (
        Fact("count", report.count.mobility, 0), Fact("true", report.mobility, 1),
        Fact("locked_regular", locked[0], 0), Fact("locked_singular", locked[1], 1),
    )  # fmt: skip
    return Drawing(panels, named, facts)


@draws("2.9", height=Slider(0.8, 1.6, 1.2, "m"))
def stewart_gough_platform(height: float) -> Drawing:
    """Six legs UPS; with spherical joints at both ends each leg spins idly."""
    ups, sps = (library.stewart_gough(legs, center=(0.05, -0.1, height)) for legs in ("UPS", "SPS"))
    answers = mobility(ups), mobility(sps)
    facts = (
        Fact("count", answers[0].count.mobility, 6), Fact("spinning", answers[1].count.mobility, 12),
        Fact("idle", sum(each.count for each in answers[1].instantaneous.idle), 6),
    )  # fmt: skip
    panel = add_linkage(Panel(), ups, letters=False)
    return Drawing({"platform": panel}, {"platform": ups, "sps": sps}, facts)


@draws("2.10", status=REBUILT, height=Slider(1.2, 2.6, 2.0, "m"))
def three_upu_platform(height: float) -> Drawing:
    """Outer axes tangential or radial: the count is 3 for both, the freedoms at home are 3 and 5."""
    named = {axes: library.three_upu(axes, height=height) for axes in ("tangent", "radial")}
    answers = {axes: mobility(each) for axes, each in named.items()}
    facts = [Fact("count", answers["tangent"].count.mobility, 3)]
    facts += [Fact(axes, answer.instantaneous.mobility) for axes, answer in answers.items()]
    return Drawing({axes: add_linkage(Panel(), each, letters=False) for axes, each in named.items()}, named, facts)


@draws("2.11", a=Slider(0.0, 2 * pi, 0.9), b=Slider(0.0, 2 * pi, 2.2))
def torus_of_two_joints(a: float, b: float) -> Drawing:
    """The square of two angles, whose opposite sides are one, and the torus that it closes to."""
    square = Panel((r"$\theta_1$ [rad]", r"$\theta_2$ [rad]"), limits=(-0.6, 6.9, -0.6, 6.9))
    for k, colour in enumerate((ACCENT, BLUE)):
        for side in (0.0, 2 * pi):
            ends = np.array([[side, 0.0], [side, 2 * pi]])[:, :: 1 - 2 * k]
            square.line(ends, colour, width=2.4, name=f"side {k} {side:.0f}")
            square.arrow(ends[0], 0.55 * (ends[1] - ends[0]), colour=colour, width=2.4)
    square.dots([a, b], INK, width=8.0, name="point")
    solid, point = _torus(a, b)
    facts = (Fact("place", point, unit="m"), Fact("dimension", int(np.linalg.matrix_rank(_tangents(a, b))), 2))
    return Drawing({"a": square, "b": solid}, {"angles": np.array([a, b])}, facts)


def _tangents(a: float, b: float, step: float = 1e-6) -> Floats:
    """(2, 3) differences of the torus along both angles."""
    return (torus.embed_in_space([[a + step, b], [a, b + step]]) - torus.embed_in_space([a, b])) / step


def _torus(a: float, b: float, through: tuple[float, float] = (0.0, 0.0)) -> tuple[Panel, Floats]:
    """A torus with its two circles through a point, and the place of two angles on it."""
    both = np.stack(np.meshgrid(np.linspace(0, 2 * pi, 49), np.linspace(0, 2 * pi, 25)), axis=-1)
    solid, point = (
        Panel(elevation=50.0, zoom=1.45).surface(torus.embed_in_space(both), name="torus"),
        torus.embed_in_space([a, b]),
    )
    for axis, colour in ((1, ACCENT), (0, BLUE)):
        seam = np.tile(np.array(through), (97, 1))
        seam[:, axis] = np.linspace(0, 2 * pi, 97)
        solid.line(torus.embed_in_space(seam), colour, width=2.4, name=f"seam {1 - axis}")
    return solid.dots(point, INK, width=8.0, name="point"), point


@draws("2.12", a=Slider(0.0, 2 * pi, 5.4), b=Slider(0.0, 2 * pi, 1.0))
def product_of_two_circles(a: float, b: float) -> Drawing:
    """A point of each of two circles is a point of the torus."""
    circles = {
        name: Panel().line(rim(1.0), colour, width=2.4, name="circle").line([[0, 0], [1, 0]], SOFT, "--")
        .arc([0, 0], 0.35, (0.0, angle), text, name="angle").line([[0, 0], rim(1.0, angle)], SOFT)
        .dots(rim(1.0, angle), INK, width=8.0, name="point")
        for name, angle, text, colour in (("a", a, r"$\theta_1$", BLUE), ("b", b, r"$\theta_2$", ACCENT))
    }  # fmt: skip
    solid, point = _torus(a, b, (a, b))
    return Drawing({**circles, "c": solid}, {"angles": np.array([a, b])}, [Fact("place", point, unit="m")])


@draws("2.13", heading=Slider(-pi, pi, 0.6), roll=Slider(-2 * pi, 2 * pi, 0.9))
def rolling_coin(heading: float, roll: float) -> Drawing:
    """An upright coin by contact point, heading and roll, and the straight path that it rolls."""
    coin, q = Coin(0.5), np.array([1.0, 0.7, heading, roll])
    T, low = coin.pose(q), coin.rim_point(q)
    contact, ahead = np.array([1.0, 0.7, 0.0]), np.array([np.cos(heading), np.sin(heading), 0.0])
    panel = Panel().frame(np.eye(4), 0.6, "s").line(circle(T[:3, 3], T[:3, 1], 0.5), BLUE, width=2.6, name="rim")
    panel.dots(contact, ACCENT, width=7.0, name="contact").label(contact - [0, 0, 0.12], "$(x, y)$", ACCENT)
    panel.arrow(contact, 0.7 * ahead, r"$\varphi$", name="heading").line([T[:3, 3], low], INK, name="spoke")
    panel.line([T[:3, 3], contact], SOFT, "--").label((T[:3, 3] + low) / 2 + [0, 0, 0.1], r"$\theta$")
    table = np.array([[0, 0, 0], [2.2, 0, 0], [2.2, 1.8, 0], [0, 1.8, 0]], np.float64)
    rows = coin.constraints.matrix(q)
    facts = (Fact("coordinates", len(q), 4), Fact("velocities", 4 - int(np.linalg.matrix_rank(rows)), 2))
    return Drawing({"coin": panel.fill(table, SOFT, 0.12)}, {"coin": coin, "q": q}, facts)


def _spray_arm() -> Robot:
    """Six revolute joints with a wrist that is not spherical, as painting arms have."""
    axes = ((2, 0, 0, 0.0), (1, 0, 0, 0.7), (1, 0, 0, 1.4), (0, 0.5, 0, 1.4), (1, 0.8, 0, 1.4), (0, 0.95, 0, 1.4))
    S = [screw.from_axis(np.eye(3)[axis], place) for axis, *place in axes]
    return Robot(mechanism_from_screws(S, translation(1.15, 0.0, 1.4), name="spray arm"))


@draws("2.14", status=REBUILT, bend=Slider(0.2, 2.6, 1.1))
def task_spaces(bend: float) -> Drawing:
    """Tips of six robots and what they reach: the same joints, other spaces."""
    two, three = Robot(textbook.planar2r((3.0, 3.0))), Robot(textbook.planar3r((2.0, 2.0, 2.0)))
    panels = {"planar_2r": _disc(two, [0.5, bend]), "planar_3r": _disc(three, [0.5, bend, 0.6])}
    pointer = np.array([[0, 0, 1, 0, 0, 0], [0, -1, 0, 0, 0, 0.0]])
    spatial = Robot(mechanism_from_screws(pointer, translation(1.0, 0, 0), name="spatial 2R"))
    ball = Panel().surface(sphere(1.0), BLUE, 0.15, "sphere")
    panels["spatial_2r"] = add_arm(ball, spatial, [0.6, bend], tip="")
    wrist = Robot(mechanism_from_screws(np.array([*pointer, [1, 0, 0, 0, 0, 0]]), translation(1.0, 0, 0), name="wrist"))
    panels["wrist"] = add_arm(Panel(), wrist, [0.4, bend, 0.5])
    cobra, spray = Robot(textbook.cobra600()), _spray_arm()
    panels["scara"] = add_arm(Panel(), cobra, [0.5, bend, 0.1, 0.0], letters="", through=COBRA)
    panels["spray"] = add_arm(Panel(), spray, [0.4, 0.2, bend, 0.3, 0.6, 0.0], letters="")
    robots = dict(zip(panels, (two, three, spatial, wrist, cobra, spray), strict=True))
    configurations = ([0.5, bend], [0.5, bend, 0.6], [0.6, bend], [0.4, bend, 0.5], [0.5, bend, 0.1, 0.0],
                [0.4, 0.2, bend, 0.3, 0.6, 0.0])  # fmt: skip
    rows = ([3, 4], [3, 4], [3, 4, 5], [0, 1, 2], [2, 3, 4, 5], [1, 2, 3, 4, 5])
    ranks = [
        int(np.linalg.matrix_rank(_turn(robot, np.asarray(q))[row], tol=1e-9))
        for robot, q, row in zip(robots.values(), configurations, rows, strict=True)
    ]
    facts = [Fact(name, m, n) for name, m, n in zip(panels, ranks, (2, 2, 2, 3, 4, 5), strict=True)]
    return Drawing(panels, robots, facts)


def _turn(robot: Robot, q: Floats) -> Floats:
    """(6, n) velocity of the tip, its rotation in the axes of the tip: row 0 is a turn about the nozzle, x_b."""
    R = np.asarray(robot.forward_kinematics(q))[:3, :3]
    return np.vstack([R.T @ tool_jacobian(robot, q)[:3], tool_jacobian(robot, q)[3:]])


def _disc(robot: Robot, q: ArrayLike) -> Panel:
    """A planar arm of equal lengths in the disc that its tip reaches."""
    lengths = np.linalg.norm(np.diff(robot.link_poses(np.zeros(robot.n))[1:, :3, 3], axis=0), axis=1)
    least, greatest = annulus([*lengths, lengths[0]])
    panel = Panel().fill(rim(greatest), BLUE, 0.12, name="reach")
    return add_arm(panel.line(rim(max(least, 1e-9)), BLUE, "--"), robot, q, flat=True, tip="")


COBRA = [(0, (0.0, 0.0, 0.0)), (1, (0.0, 0.0, 0.387)), (1, (0.325, 0.0, 0.387)), (2, (0.6, 0.0, 0.387))]
"""Corners of the line that stands for the arm: column, elbow, quill."""


@draws("2.15", q1=Slider(-1.8, 1.8, 0.5), q2=Slider(-2.0, 2.0, 1.0), q3=Slider(0.0, 0.2, 0.1, "m"))
def scara_arm(q1: float, q2: float, q3: float) -> Drawing:
    """Four parallel axes: two elbows, a quill, the rotation of the tool."""
    robot, q = Robot(textbook.cobra600()), np.array([q1, q2, q3, 0.4])
    floor = np.asarray(robot.forward_kinematics(q))[:3, 3] * [1, 1, 0]
    panel = add_arm(Panel(), robot, q, letters="J", through=COBRA).line([floor * 0, floor], SOFT, ":")
    J = robot.jacobian_space(q)
    facts = (Fact("joints", robot.n, 4), Fact("dimension", int(np.linalg.matrix_rank(J)), 4))
    return Drawing({"scara": panel}, {"robot": robot, "q": q}, facts)


@draws("2.16", status=REBUILT, bend=Slider(0.2, 2.9, 1.9), azimuth=Slider(-pi, pi, 0.5))
def spray_painting_arm(bend: float, azimuth: float) -> Drawing:
    """Six joints; the cone of paint does not change when the nozzle turns about its own axis."""
    robot, q = _spray_arm(), np.array([azimuth, -0.3, 0.5 * bend, 0.4, 0.3 * bend, 0.0])
    T = np.asarray(robot.forward_kinematics(q))
    nozzle, tip = T[:3, 0], T[:3, 3]
    panel = add_arm(Panel(), robot, q, letters="J", tip="")
    panel.surface(tube(tip, tip + 0.5 * nozzle, 0.01, 0.18), ACCENT, 0.35, "cone")
    panel.arrow(tip, 0.6 * nozzle, r"$\hat u(\theta, \varphi)$", colour=SECOND, name="nozzle")
    facts = (Fact("joints", robot.n, 6), Fact("dimension", int(np.linalg.matrix_rank(_turn(robot, q)[1:])), 5))
    return Drawing({"arm": panel}, {"robot": robot, "q": q, "direction": nozzle}, facts)


def _corner(panel: Panel, length: float) -> Panel:
    """Axes x and y of {s} from the origin."""
    return panel.frame(np.eye(3), length, "s")
