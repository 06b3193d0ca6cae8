"""Linkages of known local dimension: base mechanisms, and shaky parts that add none, of any scale and anywhere.

A part is a list of joints that hang on the body "ground", with what it adds to the dimension of the set of
configurations through the drawing. Parts that share only a body add up.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mafsil.mobility import Linkage, joint
from mafsil.mobility.linkages import LinkageJoint

Part = tuple[list[LinkageJoint], int]
EX, EY, EZ = np.eye(3)


def taut(order: int, scale: float = 1.0) -> Part:
    """Taut dyads, each holding the end of the one before: loops open with the power `order` = 2, 4, 8: 0."""
    along, across = EX, EY
    joints = [pin("A", "ground", "a", 0 * EX), pin("B", "a", "b0", scale * along)]
    end, level = 2 * scale * along, 0
    while 2 ** (level + 1) < order:
        level += 1
        joints += [
            pin(f"C{level}", "ground", f"c{level}", end - scale * across),
            pin(f"D{level}", f"c{level}", f"b{level - 1}", end),
            pin(f"E{level}", f"b{level}", f"b{level - 1}", end),
        ]
        end, along, across = end + scale * across, across, along
    return [*joints, pin("Z", f"b{level}", "ground", end)], 0


def pin(name: str, first: str, second: str, place, axis=EZ) -> LinkageJoint:
    return joint(name, "R", [first, second], place, axis)


def taut_in_space(scale: float = 1.0) -> Part:
    """Two bars of one line between three balls: they spin, and do not bend: 2 spins."""
    line = scale * np.array([0.6, 0.0, 0.8])
    balls = [joint(n, "S", bodies, k * line) for k, (n, bodies) in enumerate(
        {"A": ("ground", "a"), "B": ("a", "b"), "C": ("b", "ground")}.items())]  # fmt: skip
    return balls, 2


def flat_sarrus(taut: bool, scale: float = 1.0) -> Part:
    """Two chains of three hinges in one plane, not parallel: folded the plate rises, 1; stretched it cannot, 0."""
    joints = []
    for k, u in enumerate((EX, EY)):
        axis, places = np.cross(EZ, u), (3, 2, 1) if taut else (3, 4, 1)
        bodies = ["ground", f"f{k}", f"g{k}", "plate"]
        joints += [pin(f"S{k}{m}", *bodies[m : m + 2], scale * place * u, axis) for m, place in enumerate(places)]
    return joints, int(not taut)


def taut_three(scale: float = 1.0) -> Part:
    """Three bars of one line between ground pins: 0."""
    places = scale * np.array([[0, 0, 0], [1, 0, 0], [2.5, 0, 0], [3.2, 0, 0]])
    bodies = ["ground", "p", "q", "r", "ground"]
    return [pin(f"T{k}", *bodies[k : k + 2], p) for k, p in enumerate(places)], 0


def concurrent_bars(scale: float = 1.0) -> Part:
    """A plate of the plane on three bars whose lines meet in a point: 0."""
    feet, ends = np.array([[2, 0, 0], [-1, 2, 0], [-1, -1.5, 0]]), [0.4, 0.5, 0.45]
    joints = []
    for k, (foot, share) in enumerate(zip(feet, ends, strict=True)):
        joints += [
            pin(f"F{k}", "ground", f"bar{k}", scale * foot),
            pin(f"G{k}", f"bar{k}", "disc", scale * share * foot),
        ]
    return joints, 0


def bars(points: dict[str, tuple[float, ...]], edges: list[str], fixed: str, scale: float = 1.0) -> list[LinkageJoint]:
    """A framework of the plane: pins, bars between them, the bar `fixed` as the ground."""
    holds: dict[str, list[str]] = {}
    for edge in edges:
        for point in edge:
            holds.setdefault(point, []).append("ground" if edge == fixed else f"bar {edge}")
    joints = []
    for point, bodies in holds.items():
        first = next((b for b in bodies if b == "ground"), bodies[0])
        others = [b for b in bodies if b != first]
        place = scale * np.append(points[point], 0.0)[:3]
        joints += [pin(f"{point}{k}", first, other, place) for k, other in enumerate(others)]
    return joints


K33 = [a + b for a in "abc" for b in "xyz"]
K44 = [a + b for a in "abcd" for b in "wxyz"]


def dixon_1(scale: float = 1.0) -> Part:
    """K33 with its points on two lines at right angles: 1."""
    points = {"a": (0.5, 0), "b": (1.3, 0), "c": (-0.8, 0), "x": (0, 0.7), "y": (0, -1.1), "z": (0, 1.6)}
    return bars(points, K33, "ax", scale), 1


def dixon_2(scale: float = 1.0) -> Part:
    """K44 with its points at the corners of two rectangles of common axes: 1."""
    first = {k: (0.6 * p, 0.9 * q) for k, (p, q) in zip("abcd", [(1, 1), (1, -1), (-1, -1), (-1, 1)], strict=True)}
    second = {k: (1.1 * p, 0.5 * q) for k, (p, q) in zip("wxyz", [(1, 1), (1, -1), (-1, -1), (-1, 1)], strict=True)}
    return bars({**first, **second}, K44, "aw", scale), 1


def k33(scale: float = 1.0, conic: bool = False) -> Part:
    """K33 of random points, or with its points on a conic, where it is shaky: 0."""
    angles = np.array([0.2, 1.5, 2.4, 3.3, 4.6, 5.5])
    radii = np.ones(6) if conic else np.array([1.0, 1.4, 0.7, 1.2, 0.9, 1.6])
    places = radii[:, None] * np.column_stack([1.5 * np.cos(angles), np.sin(angles)])
    return bars(dict(zip("axbycz", map(tuple, places.tolist()), strict=True)), K33, "ax", scale), 0


def cranks(count: int, angle: float, scale: float = 1.0) -> Part:
    """Equal parallel cranks between two bodies, flat at angle 0: 1."""
    tip = scale * np.array([np.cos(angle), np.sin(angle), 0.0])
    joints = []
    for k in range(count):
        foot = scale * np.array([1.7 * k, 0.0, 0.0])
        joints += [pin(f"L{k}", "ground", f"crank{k}", foot), pin(f"M{k}", f"crank{k}", "coupler", foot + tip)]
    return joints, 1


def prism_bars(scale: float = 1.0) -> Part:
    """A plate on three parallel equal bars: 1."""
    feet = scale * np.array([[0, 0, 0], [1, 0.3, 0], [0.4, 1.1, 0]])
    tip = scale * np.array([0.6, 0.9, 0])
    joints = []
    for k, foot in enumerate(feet):
        joints += [pin(f"F{k}", "ground", f"bar{k}", foot), pin(f"G{k}", f"bar{k}", "plate", foot + tip)]
    return joints, 1


def kite(scale: float = 1.0) -> Part:
    """Four bars, two and two equal, folded onto a line: two curves meet: 1."""
    return four_bar([(0, 0), (2, 0), (3, 0), (1, 0)], scale)


def four_bar(points, scale: float = 1.0) -> Part:
    bodies = ["ground", "k1", "k2", "k3", "ground"]
    places = [scale * np.append(p, 0.0) for p in points]
    return [pin(f"K{k}", *bodies[k : k + 2], p) for k, p in enumerate(places)], 1


def folded_dyads(count: int, scale: float = 1.0) -> Part:
    """Dyads of equal bars folded over one pin, side by side: each turns alone, or their ends move: max(count, 2)."""
    joints = []
    for k in range(count):
        u = scale * EX * (1 if k % 2 else -1)
        joints += [pin(f"O{k}", "ground", f"d{k}", 0 * EX), pin(f"P{k}", f"d{k}", f"e{k}", u)]
        joints.append(pin(f"Q{k}", f"e{k}", "e0" if k else "hand", 0 * EX))
    return joints, max(count, 2) + 1


def equal_legs(count: int, scale: float = 1.0) -> Part:
    """A platform on equal parallel legs, universal and ball, of congruent feet and ends: it moves on a sphere: 2."""
    feet = scale * np.array([[1, 0, 0], [0, 1, 0.3], [-1, 0.2, 0], [0, -1, 0.4], [0.6, 0.5, 0.9], [-0.4, 0.7, -0.5]])
    leg = scale * np.array([0.3, -0.4, 1.2])
    return legs(feet[:count], feet[:count] + leg), 3 if count == 3 else 2


def legs(feet, ends) -> list[LinkageJoint]:
    """Legs of fixed lengths, universal joint and ball."""
    joints = []
    for k, (a, b) in enumerate(zip(feet, ends, strict=True)):
        d = (b - a) / np.linalg.norm(b - a)
        u = np.cross(d, EX if abs(d[0]) < 0.8 else EY)
        joints.append(joint(f"U{k}", "U", ["ground", f"leg{k}"], a, u, second=np.cross(d, u)))
        joints.append(joint(f"B{k}", "S", [f"leg{k}", "platform"], b))
    return joints


def octahedron(kind: int, scale: float = 1.0) -> Part:
    """An octahedron of bars on its face: convex 0; Bricard's, symmetric about a line 1, about a plane 1."""
    v = scale * np.array([[0.4, 0.3, 0.9], [1, 0.2, -0.1], [-0.3, 1.1, 0.3]])
    if kind == 0:
        feet, tops = scale * np.eye(3), -scale * np.array([[1, 0.1, 0], [0, 1.2, 0.1], [0.2, 0, 0.9]])
        pairs = [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)]
        return legs(np.array([feet[i] for i, _ in pairs]), np.array([tops[j] for _, j in pairs])), 0
    w = v * np.array([-1, -1, 1]) if kind == 1 else None
    if w is None:
        # Symmetric about z = 0: two corners lie in the plane, the others are mirrored in pairs.
        a, b, c = scale * np.array([[0.7, -0.2, 0], [0.3, 0.5, 0.6], [-0.6, 0.3, 0.8]])
        d = scale * np.array([-0.4, -0.9, 0])
        mirror = np.array([1, 1, -1])
        v, w = np.array([a, b, c]), np.array([d, b * mirror, c * mirror])
    i, j = [0, 0, 1, 1, 2, 2], [1, 2, 0, 2, 0, 1]
    return legs(v[i], w[j]), 1


def griffis_duffy(scale: float = 1.0) -> Part:
    """Legs from the corners of a triangle to the middles of the sides of an equal one, and back: it moves: 1."""
    turn = [np.array([np.cos(t), np.sin(t), 0]) for t in np.radians([90, 210, 330])]
    half = [-0.5 * u for u in turn]
    feet = np.array([p for u, h in zip(turn, half, strict=True) for p in (u, h)])
    ends = np.array([*(p for u, h in zip(half, turn, strict=True) for p in (u, h))])
    R = np.diag([1.0, 1.0, 1.0])
    return legs(scale * feet, scale * (ends @ R.T + [0.0, 0.0, 0.9])), 1


def beside_crank(order: int, scale: float = 1.0) -> Part:
    """A four-bar with taut bars along its crank, between its pins; of order 4 with a second dyad across them: 1."""
    A, B, C, D = np.array([[0, 0, 0], [1.2, 0, 0], [2.0, 1.4, 0], [2.6, -0.2, 0]]) * scale
    joints = [pin("A", "ground", "crank", A), pin("B", "crank", "coupler", B), pin("C", "coupler", "rocker", C),
              pin("D", "rocker", "ground", D)]  # fmt: skip
    if order == 2:
        middle = 0.4 * B
        joints += [pin("T1", "ground", "t1", A), pin("T2", "t1", "t2", middle), pin("T3", "t2", "coupler", B)]
        return joints, 1
    part, _ = taut(4, 0.3 * scale)
    return [*joints, *hung((part, 0), " on it", "crank", tuple(0.1 * B))], 1


def hung(part: Part, mark: str, ground: str = "ground", shift=(0.0, 0.0, 0.0)) -> list[LinkageJoint]:
    """The joints of a part at another place, hung on another body."""
    moved = []
    for each in part[0]:
        bodies = [ground if name == "ground" else name + mark for name in (each.parent, each.child)]
        more = {"second": each.second} if each.second is not None else {}
        moved.append(
            joint(each.name + mark, each.kind, bodies, each.point + shift, each.axis, pitch=each.pitch, **more)
        )
    return moved


def linkage(*parts: list[LinkageJoint], planar: bool = False) -> Linkage:
    return Linkage.of([each for part in parts for each in part], ground="ground", planar=planar)


PENDULUM: Part = ([pin("pendulum", "ground", "bob", -2 * EY)], 1)
SHAKY: dict[str, Callable[[float], Part]] = {
    "taut 2": lambda s: taut(2, s), "taut 4": lambda s: taut(4, s), "taut 8": lambda s: taut(8, s),
    "taut three": taut_three, "concurrent bars": concurrent_bars, "K33 on a conic": lambda s: k33(s, conic=True),
}  # fmt: skip
"""Parts that are shaky and add nothing."""
MOVING: dict[str, Callable[[float], Part]] = {
    "pendulum": lambda s: PENDULUM, "four bars": lambda s: four_bar([(0, 0), (0.5, 1), (2.5, 1.5), (2.2, 0)], s),
    "three cranks": lambda s: cranks(3, 1.1, s), "three cranks flat": lambda s: cranks(3, 0.0, s),
    "two cranks flat": lambda s: cranks(2, 0.0, s), "kite": kite, "prism": prism_bars, "Dixon 1": dixon_1,
    "Dixon 2": dixon_2, "K33": k33, "three dyads": lambda s: folded_dyads(3, s),
    "taut Sarrus": lambda s: flat_sarrus(True, s), "folded Sarrus": lambda s: flat_sarrus(False, s),
    "two dyads": lambda s: folded_dyads(2, s), "four dyads": lambda s: folded_dyads(4, s),
    "three equal legs": lambda s: equal_legs(3, s), "five equal legs": lambda s: equal_legs(5, s),
    "six equal legs": lambda s: equal_legs(6, s), "convex octahedron": lambda s: octahedron(0, s),
    "Bricard, line": lambda s: octahedron(1, s), "Bricard, plane": lambda s: octahedron(2, s),
    "dyad along a crank": lambda s: beside_crank(2, s), "order 4 on a crank": lambda s: beside_crank(4, s),
    "Griffis and Duffy": griffis_duffy, "taut balls": taut_in_space,
}  # fmt: skip
"""Parts of one mechanism each."""
