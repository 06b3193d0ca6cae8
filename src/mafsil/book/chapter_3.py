"""Figures of chapter 3: contacts, friction cones, planar and spatial grasps, the theorems of Nguyen and of Li."""

from __future__ import annotations

from math import atan, cos, pi, sin, tan

import numpy as np

from mafsil.arrays import Floats
from mafsil.book.drawing import add_contacts, rim, tube
from mafsil.book.entry import EntryStatus, Fact, Slider
from mafsil.book.figure import Drawing, draws
from mafsil.figures.panel import ACCENT, BLUE, GREEN, PALE, RED, SECOND, SOFT, Panel
from mafsil.grasp import Contact, Grasp, contact_state, eliminate, friction_angle, three_fingers, two_fingers
from mafsil.grasp.hull import convex_hull

REBUILT = EntryStatus.REBUILT
SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
SIDES = (((0, 1), (0, -1)), ((1, 0), (-1, 0)), ((0, -1), (0, 1)), ((-1, 0), (1, 0)))
"""Middle of each side of the square, top first and clockwise, with its inward normal."""


def _held(grasp: Grasp, outline: Floats = SQUARE, scale: float = 0.55) -> Panel:
    """A planar body with its contacts."""
    return add_contacts(Panel().fill(outline, SOFT, name="body"), grasp, scale)


def _square_grasp(offsets: tuple[float, float, float, float], mu: float = 0.0) -> Grasp:
    """A contact on each side of the square, moved along it: to the right on top and bottom, up at right and left."""
    moved = [np.array(p) + a * np.array([abs(n[1]), abs(n[0])]) for (p, n), a in zip(SIDES, offsets, strict=True)]
    return Grasp([Contact(p, n, mu) for p, (_, n) in zip(moved, SIDES, strict=True)])


@draws("3.1", status=REBUILT, mu=Slider(0.05, 1.0, 0.5, ""))
def three_grasps_of_a_body(mu: float) -> Drawing:
    """Normals through one point, a pinwheel of normals, two fingers with friction."""
    through, pinwheel = _square_grasp((0, 0, 0, 0)), _square_grasp((0.5, 0.5, -0.5, -0.5))
    pinch = Grasp([Contact((-1, 0), (1, 0), mu), Contact((1, 0), (-1, 0), mu)])
    named = {"a": through, "b": pinwheel, "c": pinch}
    panels = {name: _held(grasp) for name, grasp in named.items()}
    panels["a"].arc((0, 0), 0.3, (0.3, 5.2), colour=RED, name="free rotation", head=True)
    facts = [Fact(f"epsilon_{name}", grasp.quality().epsilon) for name, grasp in named.items()]
    facts.append(Fact("free", len(through.free_motions().reversible)))
    return Drawing(panels, named, facts)


@draws("3.2", mu=Slider(0.1, 1.5, 0.6, ""), beta=Slider(-1.3, 1.3, 0.35))
def friction_angle_of_a_force(mu: float, beta: float) -> Drawing:
    """A force at an angle to the normal, its two parts, and the friction angle."""
    alpha, force = friction_angle(mu), np.array([sin(beta), cos(beta)])
    edges = [[sin(side * alpha), cos(side * alpha)] for side in (-1, 1)]
    panel = Panel().fill([(0, 0), edges[0], edges[1]], BLUE, name="cone").line([[-1, 0], [1, 0]], SOFT, width=5.0)
    panel.arrow((0, 0), (0, 1.25), r"$\hat n$", colour=SOFT).arrow((0, 0), force, "$f$", colour=RED, name="force")
    panel.arrow((0, 0), (0, force[1]), colour=GREEN, name="normal part").label((0, 0.5 * force[1]), "$f_n$", GREEN)
    panel.arrow((0, 0), (force[0], 0), "$f_t$", colour=SECOND, name="tangential part")
    panel.arc((0, 0), 0.75, (pi / 2, pi / 2 + alpha), r"$\alpha$", name="alpha")
    panel.arc((0, 0), 0.55, (pi / 2 - beta, pi / 2), r"$\beta$", colour=RED, name="beta")
    state = contact_state(force, mu, (0.0, 1.0))
    facts = Fact("alpha", alpha, unit="rad"), Fact("ratio", abs(tan(beta)) / mu)
    return Drawing({"contact": panel}, {"force": force, "state": state}, facts)


@draws("3.3", mu=Slider(0.1, 1.5, 0.6, ""))
def spatial_friction_cone(mu: float) -> Drawing:
    """The cone of contact forces at a point of a surface."""
    contact = Contact((0, 0, 0), (0, 0, 1), mu)
    panel = add_contacts(Panel(), Grasp([contact]), 1.0, letters=False).frame(np.eye(4), 0.7, "c")
    floor = np.append(1.1 * SQUARE, np.zeros((4, 1)), axis=1)
    return Drawing({"cone": panel.fill(floor, SOFT, 0.15)}, {"contact": contact}, [Fact("alpha", friction_angle(mu))])


@draws("3.4", status=REBUILT, offset=Slider(-0.9, 0.9, 0.5, "m"))
def rectangle_on_four_contacts(offset: float) -> Drawing:
    """Offsets that turn alternately, and with the printed signs of the moments."""
    named = {
        "pinwheel": _square_grasp((offset, offset, -offset, -offset)),
        "printed": _square_grasp((offset, offset, offset, offset)),
    }
    facts = [Fact(f"epsilon_{name}", grasp.quality().epsilon) for name, grasp in named.items()]
    moments = named["pinwheel"].matrix()[0]
    facts.append(Fact("moments", moments, offset * np.array([-1.0, 1.0, 1.0, -1.0]), "N m"))
    return Drawing({name: _held(grasp) for name, grasp in named.items()}, named, facts)


@draws("3.5")
def positive_combinations() -> Drawing:
    """Three vectors that reach a sector, and three that reach every b."""
    sets = {"a": np.array([[1.0, 0], [0, 1], [-1, 1]]), "b": np.array([[1.0, 0], [0, 1], [-1, -1]])}
    panels = {name: _combination(vectors) for name, vectors in sets.items()}
    panels["a"].fill(np.vstack([[0, 0], 1.7 * rim(1.0)[: 73 * 3 // 8 + 1]]), GREEN, 0.12, edge=False, name="sector")
    panels["a"].arrow((0, 0), (0, -1), "$b$", colour=RED, name="unreachable")
    b = np.array([-1.0, 2.0])
    panels["a"].arrow((0, 0), 0.6 * b, "$b'$", colour=GREEN, name="reachable")
    pairs = [np.linalg.solve(sets["a"][[i, j]].T, b) for i, j in ((1, 2), (0, 1), (0, 2))]
    shares = next(pair for pair in pairs if (pair >= 0).all())
    null = np.linalg.svd(sets["b"].T)[2][-1]
    return Drawing(panels, sets, [Fact("shares", shares, (1, 1)), Fact("null", null / null[0], (1, 1, 1))])


def _combination(vectors: Floats) -> Panel:
    panel = Panel().fill(vectors, BLUE, 0.15, name="triangle").dots((0, 0), name="origin")
    for k, vector in enumerate(vectors):
        panel.arrow((0, 0), vector, f"$a_{k + 1}$", colour=BLUE, name=f"a{k + 1}")
    return panel


@draws("3.6", status=REBUILT, seed=Slider(0, 50, 7, ""))
def convex_hulls(seed: float) -> Drawing:
    """Hulls of a point, a segment and points of the plane."""
    scattered = np.random.default_rng(int(seed)).normal(size=(12, 2))
    inside = np.vstack([SQUARE[:3], [[0.4, -0.5]]])
    sets = {"a": np.array([[-1.0, 0.2], [0, 0], [1, -0.2]]), "b": inside, "c": scattered}
    panels, hulls = dict[str, Panel](), dict[str, Floats]()
    for name, points in sets.items():
        corners = hulls[name] = points[convex_hull(points).vertices]
        panel = Panel().line(np.vstack([corners, corners[:1]]), BLUE, width=2.0, name="hull")
        panels[name] = (panel.fill(corners, BLUE) if len(corners) > 2 else panel).dots(points, name="points")
    return Drawing(panels, {"points": sets, "hulls": hulls}, [Fact("corners", len(hulls["c"]))])


L_SHAPE = np.array([[-1, -1], [2, -1], [2, 0], [0, 0], [0, 2], [-1, 2]], np.float64)


@draws("3.7", status=REBUILT, L=Slider(0.3, 1.8, 1.2, "m"))
def body_on_three_fingers(L: float) -> Drawing:
    """An L on three fingers without friction, one of them in the inner corner: four normals."""
    pushes = (((0, 0), (-1, 0)), ((0, 0), (0, -1)), ((-1, L), (1, 0)), ((L, -1), (0, 1)))
    grasp = Grasp([Contact(p, n) for p, n in pushes])
    reduction = eliminate(grasp.matrix(order="fm"))
    S = np.asarray(reduction.rows, float)[:, list(reduction.free)].ravel()
    facts = Fact("S", S, (-1, -1, -1)), Fact("epsilon", grasp.quality().epsilon)
    return Drawing({"body": _held(grasp, L_SHAPE, 0.7)}, {"grasp": grasp, "reduction": reduction}, facts)


@draws("3.8", mu=Slider(0.1, 1.5, 0.5, ""), height=Slider(-0.9, 0.9, 0.0, "m"))
def two_contacts_with_friction(mu: float, height: float) -> Drawing:
    """Two fingers on the upright sides of a box, and the forces that hold its weight."""
    grasp = Grasp([Contact((-1, 0), (1, 0), mu), Contact((1, height), (-1, 0), mu)])
    closed, forces = grasp.closure(), grasp.resist((0.0, 0.0, -9.81))
    panel = Panel().fill(SQUARE, SOFT, name="body").arrow((0, 0), (0, -0.6), "$m g$", colour=RED, name="weight")
    for k, (contact, force) in enumerate(zip(grasp.contacts, np.asarray(forces.forces), strict=True)):
        panel.arrow(contact.point, 0.06 * force, f"$f_{k + 1}$", colour=GREEN, name=f"force {k}")
    facts = Fact("closed", int(bool(closed))), Fact("least", abs(height) / 2)
    return Drawing({"a": _held(grasp), "b": panel}, {"grasp": grasp, "closure": closed, "forces": forces}, facts)


@draws("3.9", mu=Slider(0.1, 1.5, 0.5, ""), shift=Slider(-0.9, 0.9, 0.3, "m"))
def nguyen_theorem(mu: float, shift: float) -> Drawing:
    """The line between two contacts inside both cones, and beside them."""
    named = {name: _pinch(mu, x) for name, x in (("inside", shift), ("beside", 2.4 * mu + 0.1))}
    facts = [Fact("delta", abs(atan(shift / 2)), unit="rad"), Fact("alpha", friction_angle(mu), unit="rad")]
    outcome = {name: two_fingers(*grasp.contacts) for name, grasp in named.items()}
    facts += [Fact(name, int(bool(answer))) for name, answer in outcome.items()]
    return Drawing({name: _join(grasp) for name, grasp in named.items()}, {**named, "verdicts": outcome}, facts)


def _pinch(mu: float, shift: float) -> Grasp:
    """Contacts below and above, the upper one moved to the right."""
    return Grasp([Contact((0, -1), (0, 1), mu), Contact((shift, 1), (0, -1), mu)])


def _join(grasp: Grasp) -> Panel:
    first, second = (contact.point for contact in grasp.contacts)
    width = max(1.2, float(second[0]) + 0.3)
    panel = _held(grasp, np.array([[-1.0, -1], [width, -1], [width, 1], [-1.0, 1]]), 1.2)
    return panel.line([first, second], RED, "--", name="line")


@draws("3.10", tilt=Slider(0.05, 1.2, 0.7))
def proof_of_nguyen(tilt: float) -> Drawing:
    """The four positions of the line and the cones: in both, in one, in none on two sides or on one."""
    tilts = {"both": (0.1, 0.1), "one": (0.1, tilt), "opposite": (tilt, tilt), "same": (tilt, -tilt)}
    named = {name: _tilt(*pair) for name, pair in tilts.items()}
    outcome = {name: two_fingers(*grasp.contacts) for name, grasp in named.items()}
    facts = [Fact(name, int(bool(answer))) for name, answer in outcome.items()]
    panels = {
        name: add_contacts(Panel().line([[0, -1], [0, 1]], RED, "--", name="line"), grasp, 0.7)
        for name, grasp in named.items()
    }
    return Drawing(panels, {**named, "verdicts": outcome}, facts, 4)


def _tilt(first: float, second: float) -> Grasp:
    """Contacts at (0, -1) and (0, 1) whose normals are turned from the line by two angles."""
    normals = (-sin(first), cos(first)), (sin(second), -cos(second))
    return Grasp([Contact((0, y), n, tan(0.35)) for y, n in zip((-1, 1), normals, strict=True)])


@draws("3.11", tilt=Slider(-0.8, 0.8, 0.2))
def three_spatial_contacts(tilt: float) -> Drawing:
    """Three fingers with friction on a circle, and the plane through their points."""
    grasp = _three(tilt)
    answer = three_fingers(grasp.contacts)
    plane = np.append(1.2 * SQUARE, np.zeros((4, 1)), axis=1)
    panel = add_contacts(Panel().fill(plane, SOFT, 0.12, name="plane S"), grasp, 0.6)
    corners = np.array([contact.point for contact in grasp.contacts])
    panel.line(corners[[0, 1, 2, 0]], SECOND, "--", name="triangle")
    facts = Fact("closed", int(bool(answer))), Fact("tilt", abs(answer.sections[0].tilt), unit="rad")
    return Drawing({"grasp": panel}, {"grasp": grasp, "verdict": answer}, facts)


def _three(tilt: float, mu: float = 0.5) -> Grasp:
    """Contacts on the unit circle, normals towards its centre and turned out of the plane."""
    angles = 2 * pi * np.arange(3) / 3
    return Grasp([
        Contact((cos(a), sin(a), 0), (-cos(a) * cos(tilt), -sin(a) * cos(tilt), sin(tilt)), mu) for a in angles
    ])  # fmt: skip


@draws("3.12", mu=Slider(0.2, 1.2, 0.5, ""))
def cone_and_plane(mu: float) -> Drawing:
    """A cone with its apex on a plane: it meets the plane in a sector, a ray or its apex."""
    alpha = friction_angle(mu)
    tilts = {"cone": 0.5 * alpha, "line": alpha, "point": alpha + 0.5 * (pi / 2 - alpha)}
    sections = {name: three_fingers(_three(tilt, mu).contacts).sections[0] for name, tilt in tilts.items()}
    panels = {name: _cut_cone(tilts[name], alpha, section.half_angle) for name, section in sections.items()}
    beta = sections["cone"].half_angle
    facts = Fact("half_angle", beta, unit="rad"), Fact("by_formula", float(np.arccos(cos(alpha) / cos(0.5 * alpha))))
    return Drawing(panels, {"sections": sections, "alpha": alpha}, facts)


def _cut_cone(tilt: float, alpha: float, half_angle: float) -> Panel:
    axis = np.array([cos(tilt), 0.0, sin(tilt)])
    plane = np.append(SQUARE * [0.8, 0.8] + [0.3, 0.0], np.zeros((4, 1)), axis=1)
    panel = Panel(azimuth=-75.0).fill(plane, SOFT, 0.2, name="plane S")
    panel.surface(tube(np.zeros(3), cos(alpha) * axis, 0.0, sin(alpha)), BLUE, 0.35, "cone")
    panel.arrow(np.zeros(3), axis, r"$\hat n$", name="normal").dots(np.zeros(3), width=6.0, name="apex")
    angles = np.linspace(-half_angle, half_angle, 25)
    arc = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=-1)
    if half_angle > 1e-6:
        panel.fill(np.vstack([np.zeros(3), arc]), ACCENT, 0.5, name="section")
    elif tilt <= alpha:
        panel.line([np.zeros(3), arc[0]], ACCENT, width=3.0, name="section")
    return panel.line(np.array([[0, -0.8, 0], [0, 0.8, 0]]), PALE)
