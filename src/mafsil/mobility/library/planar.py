"""Planar linkages by parameters, drawn where they close."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, positive, spread, whole
from mafsil.mobility.four_bar import FourBar, require_reached
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.linkages.linkage_joint import LinkageJoint, joint
from mafsil.mobility.slider_crank import SliderCrank
from mafsil.mobility.spaces.planar_positions import circle_crossings


def direction(angle: float) -> Floats:
    """(2,) unit direction at an angle from x."""
    return np.array([np.cos(angle), np.sin(angle)])


def pins(places: Sequence[tuple[str, str, str, ArrayLike]], driven: str = "") -> list[LinkageJoint]:
    """Revolute joints (name, parent, child, place), one of them with a motor."""
    return [joint(name, "R", [parent, child], at, actuated=name == driven) for name, parent, child, at in places]


def four_bar(
    crank: float = 2, coupler: float = 4, rocker: float = 3.5, ground: float = 4.5, theta: float = 1.0
) -> Linkage:
    """A four-bar by its lengths [m], drawn at an angle of the crank [rad]."""
    return FourBar(crank, coupler, rocker, ground).linkage(theta)


def parallelogram(crank: float = 1, ground: float = 2, theta: float = 1.0) -> Linkage:
    """A four-bar with equal opposite links [m], drawn as a parallelogram at an angle of the crank [rad]."""
    u = crank * direction(theta)
    places = [("A", "ground", "crank", [0, 0]), ("B", "crank", "coupler", u)]
    places += [("C", "coupler", "rocker", u + np.array([ground, 0.0])), ("D", "rocker", "ground", [ground, 0])]
    return Linkage.of(pins(places, "A"), name="parallelogram", planar=True, output="coupler")


def three_cranks(
    pivots: Sequence[float] = (0, 1.5, 3), length: float = 1, angles: float | Sequence[float] = 1.0
) -> Linkage:
    """Cranks on a line that carry one coupler: equal and parallel ones move, though the count says 0.

    Args:
        pivots: places on x [m].
        length: of the cranks [m].
        angles: of all cranks, or of each [rad].
    """
    each = spread("angles", angles, (len(pivots),))
    joints: list[LinkageJoint] = []
    for k, (x, angle) in enumerate(zip(pivots, each.tolist(), strict=True)):
        tip = np.array([x, 0.0]) + length * direction(angle)
        joints += pins([(f"G{k}", "ground", f"crank{k}", [x, 0]), (f"K{k}", f"crank{k}", "coupler", tip)], "G0")
    return Linkage.of(joints, name="three parallel cranks", planar=True, output="coupler")


def stretched_four_bar() -> Linkage:
    """Links 1, 1, 1 on a ground of 3 m: one configuration, shaky and rigid."""
    names = ("ground", "crank", "coupler", "rocker", "ground")
    places = [(n, names[k], names[k + 1], [float(k), 0.0]) for k, n in enumerate("ABCD")]
    return Linkage.of(pins(places), name="stretched four-bar", planar=True, output="coupler")


def slider_crank(crank: float = 1, rod: float = 3, offset: float = 0, theta: float = 0.7) -> Linkage:
    """A crank, a rod and a block on a line [m], drawn at an angle of the crank [rad]."""
    return SliderCrank(crank, rod, offset).linkage(theta)


def slotted_slider_crank(crank: float = 1, rod: float = 3, theta: float = 0.7) -> Linkage:
    """The same with the pin of the rod in a slot of the ground: two pins and one joint of two freedoms."""
    return SliderCrank(crank, rod).linkage(theta, merged=True)


def scotch_yoke(crank: float = 1, theta: float = 0.7) -> Linkage:
    """A crank pin in a slot across a bar that moves along x."""
    pin = crank * direction(theta)
    joints = [
        joint("A", "R", ["ground", "crank"], [0, 0], actuated=True),
        joint("B", "pin_in_slot", ["yoke", "crank"], pin, second=[0, 1]),
        joint("C", "P", ["ground", "yoke"], [2, 0], [1, 0]),
    ]
    return Linkage.of(joints, name="scotch yoke", planar=True, output="yoke")


def quick_return(crank: float = 1, ground: float = 2, theta: float = 1.0) -> Linkage:
    """A crank pin in the slot of a lever that swings about the origin (Whitworth)."""
    pin = np.array([0.0, ground]) + crank * direction(theta)
    along = pin / np.linalg.norm(pin)
    joints = [
        joint("A", "R", ["ground", "crank"], [0, ground], actuated=True),
        joint("B", "pin_in_slot", ["lever", "crank"], pin, second=along),
        joint("C", "R", ["ground", "lever"], [0, 0]),
    ]
    return Linkage.of(joints, name="quick return", planar=True, output="lever")


def elliptic_trammel(length: float = 2, theta: float = 0.6) -> Linkage:
    """A rod whose ends move on two crossed lines: its points draw ellipses."""
    x, y = length * np.cos(theta), length * np.sin(theta)
    joints = [
        joint("X", "P", ["ground", "block x"], [x, 0], [1, 0], actuated=True),
        joint("A", "R", ["block x", "rod"], [x, 0]),
        joint("B", "R", ["rod", "block y"], [0, y]),
        joint("Y", "P", ["ground", "block y"], [0, y], [0, 1]),
    ]
    return Linkage.of(joints, name="elliptic trammel", planar=True, output="rod")


def five_bar(
    ground: float = 2, T1: ArrayLike = (0.3, 1), T2: ArrayLike = (1.7, 1.1), M: ArrayLike = (1.6, 2)
) -> Linkage:
    """Two cranks with tips T1 and T2 whose rods meet in M, on pivots O = (0, 0) and D = (ground, 0) [m]."""
    names = ("ground", "crank 1", "rod 1", "rod 2", "crank 2", "ground")
    places = zip(("O", "T1", "M", "T2", "D"), ((0, 0), T1, M, T2, (ground, 0)), strict=True)
    joints = [joint(n, "R", names[k : k + 2], p, actuated=n in "OD") for k, (n, p) in enumerate(places)]
    return Linkage.of(joints, name="five-bar", planar=True, output="rod 1")


SIX_BAR_PLACES = {"watt": ((2.5, 4), (5, 6), (6, 2)), "stephenson": ((0.4, 3), (3, 5.5), (6, 2))}


def watt(places: Sequence[ArrayLike] = SIX_BAR_PLACES["watt"]) -> Linkage:
    """Watt's six-bar: the two ternary links 2 and 3 joined; places of the joints of the outer loop [m]."""
    return _six_bar("Watt six-bar", "2", places)


def stephenson(places: Sequence[ArrayLike] = SIX_BAR_PLACES["stephenson"]) -> Linkage:
    """Stephenson's six-bar: the two ternary links 1 and 3 not joined; places of the joints of the outer loop [m]."""
    return _six_bar("Stephenson six-bar", "1", places)


def _six_bar(name: str, carrier: str, places: Sequence[ArrayLike]) -> Linkage:
    outer = as_batch("places", np.asarray(places, dtype=float), (3, 2), finite=True)
    inner = [("01", "0", "1", (0, 0)), ("12", "1", "2", (1, 2)), ("23", "2", "3", (4, 3)), ("30", "3", "0", (4, 0))]
    rest = [(f"{carrier}4", carrier, "4", outer[0]), ("45", "4", "5", outer[1]), ("53", "5", "3", outer[2])]
    return Linkage.of(pins([*inner, *rest], "01"), name=name, ground="0", planar=True, output="5")


def peaucellier(arm: float = 3, side: float = 1.2, crank: float = 1, theta: float = 0.5) -> Linkage:
    """Peaucellier's inversor: eight bodies, one freedom, and a point on an exact straight line.

    Args:
        arm: of the two long links from the origin [m].
        side: of the rhombus [m].
        crank: length, and distance of its pivot from the origin, so that the line is straight [m].
        theta: angle of the crank [rad].
    """
    pivot = np.array([crank, 0.0])
    P = pivot + crank * direction(theta)
    ends = circle_crossings([0.0, 0.0], arm, P, side)
    way = float(np.linalg.norm(P))
    require_reached(max(way - (arm + side), abs(arm - side) - way), theta)
    Q = ends[0] + ends[1] - P
    places = [
        ("O1", "ground", "arm 1", [0, 0]), ("O2", "ground", "arm 2", [0, 0]), ("A", "ground", "crank", pivot),
        ("P1", "crank", "side 1", P), ("P2", "crank", "side 2", P), ("E1", "arm 1", "side 1", ends[0]),
        ("E2", "arm 2", "side 2", ends[1]), ("F1", "arm 1", "side 3", ends[0]), ("F2", "arm 2", "side 4", ends[1]),
        ("Q", "side 3", "side 4", Q),
    ]  # fmt: skip
    return Linkage.of(pins(places, "A"), name="Peaucellier inversor", planar=True, output="side 3")


def overlapping_joints() -> Linkage:
    """A body on three legs RRR, RPR and RRR, of which two share a pin: eight links, mobility 3."""
    shared = [3.0, 2.0]
    joints = [
        *pins([("A1", "ground", "a1", [0, 0]), ("A2", "a1", "a2", [-0.5, 1.2]), ("A3", "a2", "body", [0.5, 2.2])]),
        joint("B1", "R", ["ground", "b1"], [2, 0]),
        joint("B2", "P", ["b1", "b2"], [2, 0], [1, 2]),
        joint("B3", "R", ["b2", "body"], shared),
        *pins([("C1", "ground", "c1", [4, 0]), ("C2", "c1", "c2", [4.4, 1.1]), ("C3", "c2", "body", shared)]),
    ]  # fmt: skip
    return Linkage.of(joints, name="overlapping joints", planar=True, output="body")


def chain(joints: int = 7, length: float = 1) -> Linkage:
    """A planar serial chain of equal links [m]."""
    k = whole("joints", joints, 1, 1000)
    angles = np.cumsum(np.full(k, 0.3))
    places = np.concatenate([[[0, 0]], np.cumsum(length * np.stack([np.cos(angles), np.sin(angles)], axis=1), axis=0)])
    names = ["ground", *(f"link {n + 1}" for n in range(k))]
    given = [joint(f"J{n + 1}", "R", names[n : n + 2], places[n], actuated=True) for n in range(k)]
    return Linkage.of(given, name=f"chain of {k}", planar=True)


def truss() -> Linkage:
    """A triangle of bars: a structure, to first order and by the count."""
    places = [("A", "ground", "bar 1", [0, 0]), ("B", "bar 1", "bar 2", [1, 1.5]), ("C", "bar 2", "ground", [2, 0])]
    return Linkage.of(pins(places), name="truss", planar=True, output="bar 1")


def planar_platform(
    legs: str = "RPR", base: float = 2, platform: float = 0.7, center: ArrayLike = (0.2, 0.1), angle: float = 0.3
) -> Linkage:
    """A platform on three planar legs, RPR (actuated extension) or RRR (actuated base joint).

    Args:
        legs: letters of the joints.
        base, platform: radii of the triangles of their ends [m].
        center: (2,) of the platform [m].
        angle: of the platform [rad].
    """
    middle = as_batch("center", center, (2,), finite=True)
    base, platform = positive("base", base), positive("platform", platform)
    joints: list[LinkageJoint] = []
    for k in range(3):
        a = base * direction(np.pi / 2 + 2 * np.pi * k / 3)
        b = middle + platform * direction(np.pi / 2 + 2 * np.pi * k / 3 + angle)
        if legs == "RPR":
            inner = joint(f"P{k}", "P", [f"lower{k}", f"upper{k}"], a, b - a, actuated=True)
        else:
            elbow = circle_crossings(a, 0.75 * float(np.linalg.norm(b - a)), b, 0.75 * float(np.linalg.norm(b - a)))[0]
            inner = joint(f"E{k}", "R", [f"lower{k}", f"upper{k}"], elbow)
        joints += [
            joint(f"A{k}", "R", ["ground", f"lower{k}"], a, actuated=legs != "RPR"), inner,
            joint(f"B{k}", "R", [f"upper{k}", "platform"], b),
        ]  # fmt: skip
    return Linkage.of(joints, name=f"3-{legs}", planar=True, output="platform")


def three_rpr() -> Linkage:
    """A planar platform on three extending legs."""
    return planar_platform("RPR")


def three_rrr() -> Linkage:
    """A planar platform on three folding legs."""
    return planar_platform("RRR")
