"""Mechanisms of known local dimension beyond those of `known_dimensions`: paradoxical, degenerate, of many branches.

`TABLE` holds all of them by name: a function of no argument that gives joints on the body "ground", and the dimension
of the set of configurations through the drawing, each by the theorem that its docstring names.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from scipy.optimize import least_squares

from mafsil.arrays import Floats
from mafsil.geometry import pose
from mafsil.mobility import Linkage, joint, library
from mafsil.mobility.linkages import LinkageJoint
from tests.mobility.known_dimensions import (
    EX,
    EY,
    EZ,
    MOVING,
    SHAKY,
    Part,
    four_bar,
    legs,
    pin,
)  # fmt: skip
from tests.mobility.mechanisms import hart, jansen
from tests.reliability import over_constrained as oc

RIGHT = np.pi / 2


def scaled(part: Part, scale: float, mark: str = "") -> list[LinkageJoint]:
    """The joints of a part, all lengths times a scale; names of joints and bodies get a mark, "ground" none."""
    return [
        joint(
            each.name + mark, each.kind, [b if b == "ground" else b + mark for b in (each.parent, each.child)],
            scale * each.point, each.axis, second=each.second,
            pitch=scale * each.pitch,
        )
        for each in part[0]
    ]  # fmt: skip


def drawn(linkage: Linkage, dimension: int) -> Part:
    """A mechanism of the library on the body "ground"."""
    names = {linkage.ground: "ground"}
    return [
        joint(
            each.name, each.kind, [names.get(b, b) for b in (each.parent, each.child)], each.point, each.axis,
            second=each.second, pitch=each.pitch,
        )
        for each in linkage.joints
    ], dimension  # fmt: skip


def ring(axes: Sequence[tuple[Floats, Floats]], dimension: int) -> Part:
    """One loop of hinges: (place, direction) of each."""
    bodies = ["ground", *(f"link {k}" for k in range(1, len(axes))), "ground"]
    return [pin(f"J{k}", *bodies[k : k + 2], p, w) for k, (p, w) in enumerate(axes)], dimension


def closed_ring(steps: Sequence[tuple[float, float, float]], start: Sequence[float], dimension: int = 1) -> Part:
    """Hinges with lengths, twists and offsets (a, alpha, R), at angles near `start` that close the loop."""

    def places(theta: Floats) -> list[Floats]:
        T = [np.eye(4)]
        for angle, (a, alpha, R) in zip(theta, steps, strict=True):
            T.append(T[-1] @ pose.exp([0, 0, angle, 0, 0, 0]) @ _shift(a, R) @ pose.exp([alpha, 0, 0, 0, 0, 0]))
        return T

    found = least_squares(lambda t: (places(t)[-1] - np.eye(4))[:3].ravel(), start, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    assert found.cost < 1e-24
    return ring([(T[:3, 3], T[:3, 2]) for T in places(found.x)[:-1]], dimension)


def _shift(a: float, R: float) -> Floats:
    T = np.eye(4)
    T[:3, 3] = a, 0, R
    return T


def bennetts(*sides: tuple[float, float]) -> list[list[LinkageJoint]]:
    """Bennett's linkages with side a = 1, alpha = 0.4 in common: (b, theta) of each, turned so that the next fits."""
    turned, found = 0.0, list[list[LinkageJoint]]()
    for k, (b, theta) in enumerate(sides):
        joints = list(library.bennett(1.0, 0.4, b, theta).joints)
        turned = 0.0 if not k else turned + sides[0][1] - theta
        found.append(oc.displaced(joints, pose.exp([0, 0, turned, 0, 0, 0]), f" {k}"))
    return found


def goldberg(first: tuple[float, float], second: tuple[float, float], kept: bool) -> Part:
    """Two of Bennett's linkages on one side, two sides welded; the common side kept, or left out (5R): 1.

    Myard's five hinges: both with twists of a right angle.
    """
    one, two = bennetts(first, second)
    middle = one[1]
    joints = [*one[2:], *two[2:]]
    if not kept:
        return [*joints, pin("M", "link 2 0", "link 2 1", middle.point, middle.axis)], 1
    return [one[0], middle, pin("M", "link 1 0", "link 2 1", middle.point, middle.axis), *joints], 1


def bennett_chain() -> list[tuple[Floats, Floats]]:
    """Three hinges of Bennett's linkage that turn their ends about the fourth: about z."""
    return [(each.point, each.axis) for each in library.bennett(1.0, 0.5, 1.6, 1.0).joints[1:]]


def planar_chain() -> list[tuple[Floats, Floats]]:
    """Three hinges of a plane four-bar that turn their ends about z."""
    return [(np.array(p), EZ) for p in ([1.1, 0.2, 0.0], [1.6, 1.4, 0.0], [-0.3, 0.9, 0.0])]


def spherical_chain() -> list[tuple[Floats, Floats]]:
    """Three hinges of a spherical four-bar that turn their ends about z."""
    return [(np.array([0, 0, 0.4]), np.array(w)) for w in ([0.8, 0.1, 0.5], [0.7, 0.9, 0.3], [-0.2, 0.8, 0.6])]


def hybrid(first: list[tuple[Floats, Floats]], second: list[tuple[Floats, Floats]], turn: float) -> Part:
    """Waldron's hybrids: two chains of three that turn their ends about one axis, which is left out: 1."""
    T = pose.exp([0, 0, turn, 0, 0, 0.3])
    moved = [(T[:3, :3] @ p + T[:3, 3], T[:3, :3] @ w) for p, w in second]
    return ring([*first, *moved[::-1]], 1)


def trihedral() -> Part:
    """Bricard's trihedral loop: right angles, no offsets, squares of every other side of one sum: 1."""
    sides = [1.0, 0.9, 1.2, 1.1, 0.8]
    sides.append(float(np.sqrt(np.dot([1, -1, 1, -1, 1], np.square(sides)))))
    twists = [RIGHT, -RIGHT] * 3
    return closed_ring([(a, t, 0.0) for a, t in zip(sides, twists, strict=True)], [1.9, -1.9] * 3)


def schatz() -> Part:
    """Schatz's inversor: five right angles and two parallel axes, sides 0 1 1 1 0 and the root of three: 1."""
    offset = 0.3
    steps = [(0.0, RIGHT, offset), *[(1.0, RIGHT, 0.0)] * 3, (0.0, RIGHT, 0.0), (np.sqrt(3), 0.0, -offset)]
    return closed_ring(steps, [0.6, 2.4, 1.9, -2.2, 2.0, 0.9])


def octahedral(kind: int) -> Floats:
    """(6, 3) corners a b c and those opposite: Bricard's flexible octahedra of line, plane and third kind."""
    v = np.array([[0.4, 0.3, 0.9], [1, 0.2, -0.1], [-0.3, 1.1, 0.3]])
    if kind == 1:
        return np.vstack([v, v * [-1, -1, 1]])
    if kind == 2:
        b, c = np.array([[0.3, 0.5, 0.6], [-0.6, 0.3, 0.8]])
        mirror = np.array([1, 1, -1])
        return np.array([[0.7, -0.2, 0], b, c, [-0.4, -0.9, 0], b * mirror, c * mirror])
    flat = _third_kind_flat()
    edges = [(i, j) for i in range(6) for j in range(i) if i - j != 3]
    first, last = np.array(edges).T
    wanted = np.linalg.norm(flat[first] - flat[last], axis=1)
    lift = flat + 0.3 * np.random.default_rng(3).normal(size=6)[:, None] * EZ

    def gaps(x: Floats) -> Floats:
        p = x.reshape(6, 3)
        return np.linalg.norm(p[first] - p[last], axis=1) - wanted

    found = least_squares(gaps, lift.ravel(), xtol=1e-15, ftol=1e-15, gtol=1e-15)
    assert found.cost < 1e-24
    corners = found.x.reshape(6, 3)
    assert np.linalg.svd(corners - corners.mean(axis=0))[1][2] > 0.05, "still flat"
    return corners


def _third_kind_flat() -> Floats:
    """The third kind folded flat: tangents from two corners to two circles of one middle meet in the other four."""
    A, D = np.array([2.0, 0.3]), np.array([-1.7, 0.9])
    corners = [A, None, None, D, None, None]
    for k, radius in enumerate((0.5, 0.8)):
        one, other = _tangents(A, radius), _tangents(D, radius)
        corners[1 + k], corners[4 + k] = _meet(A, one[0], D, other[0]), _meet(A, one[1], D, other[1])
    return np.column_stack([np.array(corners), np.zeros(6)])


def _tangents(p: Floats, radius: float) -> tuple[Floats, Floats]:
    """Directions from a point to both tangents of a circle about the origin."""
    along, far = np.arctan2(-p[1], -p[0]), np.arcsin(radius / np.linalg.norm(p))
    return tuple(np.array([np.cos(along + s), np.sin(along + s)]) for s in (far, -far))


def _meet(p: Floats, u: Floats, q: Floats, v: Floats) -> Floats:
    t = np.linalg.solve(np.column_stack([u, -v]), q - p)
    return p + t[0] * u


def octahedron_bars(corners: Floats, dimension: int = 1) -> Part:
    """The twelve edges: a face as ground, its opposite as platform, six legs."""
    i, j = np.array([0, 0, 1, 1, 2, 2]), np.array([4, 5, 3, 5, 3, 4])
    return legs(corners[i], corners[j]), dimension


def octahedron_ring(corners: Floats, dimension: int = 1) -> Part:
    """Six of its faces as one ring of hinges: Bricard's octahedral loops; of a convex one 0 (Cauchy)."""
    a, b, c, d, e, f = corners
    return ring([(p, q - p) for p, q in ((b, f), (b, d), (c, d), (c, e), (a, e), (a, f))], dimension)


CONVEX = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, -0.1, 0], [0, -1.2, -0.1], [-0.2, 0, -0.9]])


def roberts() -> Part:
    """The three four-bars of one coupler curve, all of them on its point: 1 (Roberts and Chebyshev)."""
    A, B, C, D, ratio = 0j, 0.3 + 1j, 2.4 + 1.5j, 2.9 + 0.1j, 0.45 + 0.6j
    P, F = B + ratio * (C - B), A + ratio * (D - A)
    L, R = A + P - B, D + P - C
    place = {"A": A, "B": B, "C": C, "D": D, "P": P, "F": F, "L": L, "R": R,
             "U": L + ratio * (B - A), "V": R + (ratio - 1) * (D - C)}  # fmt: skip
    bodies = {
        "A": "ground crank l1", "B": "crank coupler", "C": "coupler rocker", "D": "ground rocker r1",
        "P": "coupler l2 r2", "L": "l1 l2", "R": "r1 r2", "U": "l2 u1", "V": "r2 u2", "F": "ground u1 u2",
    }  # fmt: skip
    return _pins(bodies, {name: (z.real, z.imag) for name, z in place.items()}), 1


def double_watt() -> Part:
    """Two of Watt's linkages, a bar between the middles of their couplers: the set has a cusp here: 1.

    Reference: R. Connelly and H. Servatius, Higher-order rigidity - what is the proper definition?, 1994.
    """
    places = {"A": (-1, 1), "B": (0, 1), "C": (0, -1), "D": (1, -1), "M": (0, 0)}
    places |= {f"{n}'": (6 - x, y) for n, (x, y) in places.items()}
    bodies = {"M": "coupler bar", "M'": "bar coupler'"}
    for mark in ("", "'"):
        on = {"A": "ground crank", "B": "crank coupler", "C": "coupler rocker", "D": "rocker ground"}
        bodies |= {n + mark: " ".join(b if b == "ground" else b + mark for b in two.split()) for n, two in on.items()}
    return _pins(bodies, places), 1


def _pins(bodies: dict[str, str], places: dict[str, tuple[float, float]]) -> list[LinkageJoint]:
    """Pins of the plane, each through the bodies named."""
    return [
        pin(f"{name}{k}", through.split()[0], other, np.array([*places[name], 0.0]))
        for name, through in bodies.items()
        for k, other in enumerate(through.split()[1:])
    ]


def slider(points: Sequence[tuple[float, float]], along: Floats, dimension: int) -> Part:
    """Crank and slider with pins at three places, the slide along a direction."""
    bodies = ["ground", "crank", "rod", "block"]
    joints = [pin(f"K{k}", *bodies[k : k + 2], np.array([*p, 0.0])) for k, p in enumerate(points)]
    return [*joints, joint("slide", "P", ["block", "ground"], [0, 0, 0], along)], dimension


def slides(directions: Floats, dimension: int) -> Part:
    """A loop of prismatic joints."""
    bodies = ["ground", *(f"block {k}" for k in range(1, len(directions))), "ground"]
    return [joint(f"P{k}", "P", bodies[k : k + 2], [0, 0, 0], u) for k, u in enumerate(directions)], dimension


def bars_along_bennett() -> Part:
    """Two bars of one line between a place on an axis of Bennett's linkage and one of its links: 1 and two spins."""
    joints, _ = drawn(library.bennett(), 1)
    foot = joints[0].point + 0.3 * joints[0].axis
    end = joints[1].point + 0.7 * joints[1].axis
    names = {"A": ("ground", "s"), "B": ("s", "t"), "C": ("t", joints[0].child)}
    balls = [joint(n, "S", on, foot + k * (end - foot)) for (n, on), k in zip(names.items(), (0, 0.4, 1), strict=True)]
    return [*joints, *balls], 3


FEET = np.array([[1, 0, 0.1], [0.3, 1, 0.3], [-1, 0.2, -0.1], [-0.2, -1, 0.4], [0.6, 0.5, 0.9], [-0.4, 0.7, -0.5]])
ENDS = np.array([[0.5, 0.1, 1], [0.1, 0.6, 1.1], [-0.5, 0.1, 1.3], [-0.1, -0.4, 1.4], [0.2, 0.3, 1.8], [0, 0.5, 1.2]])


def four_on_lines() -> Part:
    """Feet and ends of four legs on two lines, of one cross ratio: their lines stay dependent: 1."""
    feet, ends, t = FEET.copy(), ENDS.copy(), np.array([0.0, 0.3, 0.8, 1.4])[:, None]
    feet[:4], ends[:4] = [0.2, -0.9, 0.1] + t * [0.5, 1, 0.3], [-0.3, -0.2, 1.2] + t * [0.2, 0.6, -0.1]
    return legs(feet, ends), 1


def three_on_line() -> Part:
    """Feet of three legs on a line, their ends in one point: 1."""
    feet, ends = FEET.copy(), ENDS.copy()
    feet[:3], ends[:3] = [0.2, -0.9, 0.1] + np.array([[0.0], [0.7], [1.5]]) * [0.5, 1, 0.3], ends[0]
    return legs(feet, ends), 1


def ends_on_line() -> Part:
    """All ends on one line, about which the platform turns: 1."""
    return legs(FEET, [0.1, 0.0, 1.2] + np.linspace(-0.7, 0.9, 6)[:, None] * [0.3, 0.9, 0.2]), 1


def on_conics() -> Part:
    """Feet and ends on two ellipses of the plane, one the image of the other: 1."""
    angles = np.array([0.1, 0.9, 2.2, 3.0, 4.1, 5.3])
    feet = np.column_stack([1.4 * np.cos(angles), np.sin(angles), 0 * angles])
    T = pose.exp([0.3, -0.2, 0.5, 0.2, 0.1, 1.3])
    return legs(feet, (feet * [0.5, 0.8, 1]) @ T[:3, :3].T + T[:3, 3]), 1


def wren() -> Part:
    """Equal upright legs of equal regular hexagons: the platform shifts over a sphere, 2, or screws up and down, 1."""
    turn = np.radians(60 * np.arange(6))
    feet = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    return legs(feet, feet + 1.3 * EZ), 2


def folded_platform() -> Part:
    """Six legs, the last across the motion that the other five leave its end: shaky of order two: 0."""
    d = ENDS - FEET
    lines = np.hstack([np.cross(FEET, d), d])[:5]
    V = np.linalg.svd(lines)[2][5]
    velocity = np.cross(V[:3], ENDS[5]) + V[3:]
    feet = FEET.copy()
    feet[5] = ENDS[5] - np.cross(velocity / np.linalg.norm(velocity), [0.3, 0.5, -0.7])
    return legs(feet, ENDS), 0


def doubled_leg() -> Part:
    """Two of six legs in one: 1."""
    return legs(FEET[[0, 1, 2, 3, 4, 4]], ENDS[[0, 1, 2, 3, 4, 4]]), 1


def miura(rows: int, columns: int, fold: float = 0.6) -> Part:
    """A Miura sheet of rigid panels, folded: 1."""
    tangent = np.cos(fold) * np.tan(1.1)
    across = tangent / np.sqrt(1 + tangent**2), 1 / np.sqrt(1 + tangent**2)
    along = np.sqrt(1 - (np.sin(fold) * np.sin(1.1)) ** 2), np.sin(fold) * np.sin(1.1)

    def corner(i: int, j: int) -> Floats:
        return np.array([across[0] * i, along[0] * j + across[1] * (i % 2), along[1] * (j % 2)])

    def panel(i: int, j: int) -> str:
        return f"panel {i} {j}" if i or j else "ground"

    joints = []
    for i in range(rows):
        for j in range(columns):
            if i:
                joints.append(
                    pin(f"A{i}.{j}", panel(i - 1, j), panel(i, j), corner(i, j), corner(i, j + 1) - corner(i, j))
                )
            if j:
                joints.append(
                    pin(f"B{i}.{j}", panel(i, j - 1), panel(i, j), corner(i, j), corner(i + 1, j) - corner(i, j))
                )
    return joints, 1


def _theorem(name: str, seed: int = 4) -> Part:
    return oc.BUILDERS[name](np.random.default_rng(seed))


def flat(*angles: float) -> list[tuple[Floats, Floats]]:
    """Hinges of one plane through a point."""
    return [(np.zeros(3), np.array([np.cos(t), np.sin(t), 0])) for t in angles]


TABLE: dict[str, Callable[[], Part]] = {
    **{name: partial(make, 1.0) for name, make in {**MOVING, **SHAKY}.items()},
    **{name: partial(lambda n, d: drawn(library.linkage(n), d), name, d) for name, d in {
        "bennett": 1, "kaleidocycle": 1, "sarrus": 1, "watt": 1, "stephenson": 1, "peaucellier": 1, "truss": 0,
        "elliptic_trammel": 1, "universal_shaft": 1, "rccc": 1, "rssr": 2, "tripteron": 3, "delta": 9, "three_rps": 3,
        "spherical_four_bar": 1, "screw_press": 1, "parallelogram": 1,
    }.items()},
    "Hart": lambda: drawn(hart()[0], 1), "Jansen": lambda: drawn(jansen(), 1), "Roberts": roberts,
    "Goldberg, five": partial(goldberg, (1.5, 0.9), (1.8, 1.7), False),
    "Goldberg, kept": partial(goldberg, (1.5, 0.9), (1.8, 1.7), True),
    "Myard": partial(goldberg, (1 / np.sin(0.4), 0.9), (1 / np.sin(0.4), 1.6), False),
    "Waldron, two Bennett": lambda: hybrid(bennett_chain(), bennett_chain(), 1.9),
    "Waldron, Bennett and plane": lambda: hybrid(bennett_chain(), planar_chain(), 1.2),
    "Waldron, Bennett and sphere": lambda: hybrid(bennett_chain(), spherical_chain(), 2.2),
    "Waldron, plane and sphere": lambda: hybrid(planar_chain(), spherical_chain(), 0.7),
    "Bricard, line-symmetric": partial(_theorem, "line_symmetric"),
    "Bricard, plane-symmetric": partial(_theorem, "plane_symmetric"),
    "Bricard, trihedral": trihedral, "Schatz": schatz,
    **{f"Bricard, octahedral {k}": partial(lambda k: octahedron_ring(octahedral(k)), k) for k in (1, 2, 3)},
    "flexible octahedron 3": lambda: octahedron_bars(octahedral(3)),
    "convex ring": lambda: octahedron_ring(CONVEX, 0),
    "three Sarrus legs": partial(_theorem, "sarrus", 6), "bent Bennett": partial(_theorem, "bent_bennett"),
    "change point": lambda: four_bar([(0, 0), (1, 0), (4, 0), (1.5, 0)]),
    "taut four": lambda: (four_bar([(0, 0), (6, 0), (5, 0), (3, 0)])[0], 0),
    "slider, dead point": partial(slider, [(0, 0), (1, 0), (3, 0)], EX, 1),
    "slider, equal": partial(slider, [(0, 0), (1, 0), (0, 0)], EX, 1),
    "slider, taut": partial(slider, [(0, 0), (1, 0), (3, 0)], EY, 0),
    "slides of the plane": lambda: slides(np.array([EX, EY, EX + EY]), 1),
    "slides of space": lambda: slides(np.array([EX, EY, EZ, [1, 2, 3]]), 1),
    "one axis": lambda: ring([(np.zeros(3), EZ)] * 3, 2),
    "flat vertex 3": lambda: ring(flat(0, 2, 4), 0), "flat vertex 4": lambda: ring(flat(0, 1.3, 3, 4.4), 1),
    "flat vertex 5": lambda: ring(flat(0, 1.3, 2.5, 3.9, 5), 2),
    "flat vertex 6": lambda: ring(flat(0, 1, 2.2, 3.1, 4.3, 5.2), 3),
    "sphere, taut three": lambda: ring(flat(0, 0.5, 1.2), 0),
    "sphere, taut four": lambda: ring(flat(0, 0.3, 0.7, 1.2), 0),
    "sphere, folded": lambda: ring(flat(0, 0.8, 1.2, 0.4), 1),
    "four legs on lines": four_on_lines, "three legs on a line": three_on_line, "ends on a line": ends_on_line,
    "conics": on_conics, "Wren": wren, "folded platform": folded_platform, "doubled leg": doubled_leg,
    "five legs": lambda: (legs(FEET[:5], ENDS[:5]), 1), "six legs": lambda: (legs(FEET, ENDS), 0),
    "bars along Bennett": bars_along_bennett, "double Watt": double_watt,
    "Miura 2 2": partial(miura, 2, 2), "Miura 3 3": partial(miura, 3, 3), "Miura 2 2 flat": partial(miura, 2, 2, 0.0),
}  # fmt: skip
SCALES = (1e-3, 1e-2, 0.1, 1.0, 10.0, 1e2, 1e3)


def beside_four_bar(part: Part, scale: float, bridged: bool) -> tuple[Linkage, int]:
    """A part of any size beside a four-bar of unit size; bridged, a chain of six general joints makes them one block.

    A chain of six general joints spans all motions of space, so that closing it takes exactly what it brings: 0.
    """
    rng = np.random.default_rng(7)
    unit_bar, one = four_bar([(0, 0), (0.5, 1), (2.5, 1.5), (2.2, 0)])
    joints = [*scaled(part, scale, " part"), *oc.displaced(unit_bar, oc.somewhere(rng))]
    if bridged:
        far = max((each for each in joints if each.name.endswith(" part")), key=lambda each: each.name).parent
        joints += oc.chain("E", far, "k2", "RRPRRR", rng.normal(size=(6, 3)), rng.normal(size=(6, 3)))
    return Linkage.of(joints, ground="ground"), part[1] + one
