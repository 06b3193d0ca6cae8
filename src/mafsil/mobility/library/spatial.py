"""Spatial linkages with single loops by parameters: overconstrained ones, shafts, spherical chains, a door."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mafsil.arrays import number, positive, single
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.linkages.linkage_joint import LinkageJoint, joint


def bennett(a: float = 1.0, alpha: float = 0.5, b: float = 1.6, theta: float = 1.0) -> Linkage:
    """Bennett's linkage: four skew axes, sin(alpha)/a = sin(beta)/b, mobility 1 where the count says -2.

    tan(theta_1/2) tan(theta_2/2) = sin((beta + alpha)/2) / sin((beta - alpha)/2); opposite links are equal.

    Args:
        a, alpha: distance [m] and angle [rad] of the axes of two opposite links.
        b: distance of the others [m].
        theta: angle of the first joint [rad].

    Raises:
        InputError: b sin(alpha)/a exceeds 1.

    Reference: G. T. Bennett, A new mechanism, Engineering 76 (1903).
    """
    a, b, alpha, theta = positive("a", a), positive("b", b), number("alpha", alpha), number("theta", theta)
    sine = b * np.sin(alpha) / a
    if not abs(sine) <= 1:
        raise InputError("mobility.bennett", a=a, b=b, alpha=alpha)
    beta = float(np.arcsin(sine))
    across = np.sin((beta - alpha) / 2) * np.tan(theta / 2)
    second = 2 * np.arctan2(np.copysign(1.0, across) * np.sin((beta + alpha) / 2), abs(across))
    steps = [(theta, a, alpha), (second, b, beta), (-theta, a, alpha), (-second, b, beta)]
    return _loop("Bennett linkage", steps)


def _loop(name: str, steps: Sequence[tuple[float, float, float]]) -> Linkage:
    """Revolute joints along z of frames that follow each other by (theta, a, alpha), classic Denavit-Hartenberg."""
    T, joints = np.eye(4), list[LinkageJoint]()
    names = ["ground", *(f"link {k + 1}" for k in range(len(steps) - 1)), "ground"]
    for k, (theta, a, alpha) in enumerate(steps):
        joints.append(joint(f"J{k + 1}", "R", names[k : k + 2], T[:3, 3], T[:3, 2], actuated=k == 0))
        T = T @ pose.exp([0, 0, theta, 0, 0, 0]) @ pose.exp([0, 0, 0, a, 0, 0]) @ pose.exp([alpha, 0, 0, 0, 0, 0])
    return Linkage.of(joints, name=name, output="link 2")


def sarrus(width: float = 1.0, height: float = 1.6, knee: float = 0.6) -> Linkage:
    """Sarrus' linkage: two folding chains in crossed planes, a platform that rises on an exact straight line.

    Args:
        width: distance of the hinges from the axis [m].
        height: of the platform [m].
        knee: how far the knees stand out [m].
    """
    joints: list[LinkageJoint] = []
    for k, (out, axis) in enumerate((([0, 1, 0], [1, 0, 0]), ([1, 0, 0], [0, 1, 0]))):
        u, z = np.array(out, dtype=float), np.array([0.0, 0.0, 1.0])
        places = [width * u, (width + knee) * u + height / 2 * z, width * u + height * z]
        names = ["ground", f"lower{k}", f"upper{k}", "platform"]
        joints += [
            joint(f"{n}{k}", "R", names[i : i + 2], p, axis, actuated=n == "A" and not k)
            for i, (n, p) in enumerate(zip("ABC", places, strict=True))
        ]
    return Linkage.of(joints, name="Sarrus linkage", output="platform")


def kaleidocycle(radius: float = 1.0) -> Linkage:
    """Bricard's threefold symmetric linkage of six axes at right angles: a band of tetrahedra that turns inside out.

    Args:
        radius: of the middles of the hinges in the symmetric configuration [m].

    Reference: R. Bricard, Lecons de cinematique, 1927.
    """
    tilt = float(np.arctan(1 / np.sqrt(2)))
    joints: list[LinkageJoint] = []
    names = ["ground", *(f"link {k}" for k in range(1, 6)), "ground"]
    for k in range(6):
        out = np.array([np.cos(np.pi / 3 * k), np.sin(np.pi / 3 * k), 0.0])
        sign = 1 if k % 2 == 0 else -1
        axis = np.cos(tilt) * out + sign * np.sin(tilt) * np.array([0, 0, 1.0])
        place = radius * out + (0 if k % 2 == 0 else radius / np.sqrt(2)) * np.array([0, 0, 1.0])
        joints.append(joint(f"J{k + 1}", "R", names[k : k + 2], place, axis, actuated=not k))
    return Linkage.of(joints, name="Bricard kaleidocycle", output="link 3")


def spherical_four_bar(
    axes: Sequence[Sequence[float]] = ((1, 0, 0), (0.8, 0.5, 0.3), (0.2, 0.9, 0.5), (0, 1, 0.1)),
) -> Linkage:
    """Four hinges whose axes meet in one point.

    Args:
        axes: (4, 3) directions from that point.
    """
    names = ("ground", "crank", "coupler", "rocker", "ground")
    directions = zip("ABCD", single("axes", axes, (4, 3)), strict=True)
    joints = [joint(n, "R", names[k : k + 2], [0, 0, 0], w, actuated=not k) for k, (n, w) in enumerate(directions)]
    return Linkage.of(joints, name="spherical four-bar", output="coupler")


def universal_shaft(bend: float = 0.5, theta: float = 0.4) -> Linkage:
    """Two shafts that meet at an angle [rad], joined by a cross (Hooke's joint), at an angle of the first [rad]."""
    first = np.array([0.0, 0.0, 1.0])
    last = np.array([np.sin(bend), 0.0, np.cos(bend)])
    pin = np.array([np.cos(theta), np.sin(theta), 0.0])
    other = np.cross(last, pin)
    joints = [
        joint("A", "R", ["ground", "shaft 1"], [0, 0, -1], first, actuated=True),
        joint("B", "R", ["shaft 1", "cross"], [0, 0, 0], pin),
        joint("C", "R", ["cross", "shaft 2"], [0, 0, 0], other),
        joint("D", "R", ["shaft 2", "ground"], last, last),
    ]
    return Linkage.of(joints, name="universal shaft", output="shaft 2")


def rssr() -> Linkage:
    """A spatial four-bar with two spherical joints: its coupler spins idly about its own line."""
    joints = [
        joint("A", "R", ["ground", "crank"], [0, 0, 0], [0, 0.2, 1], actuated=True),
        joint("B", "S", ["crank", "coupler"], [0.5, 0.3, 0.1]),
        joint("C", "S", ["coupler", "rocker"], [1.2, 0.9, 0.8]),
        joint("D", "R", ["rocker", "ground"], [1.5, 0.1, 0.2], [1, 0.3, 0]),
    ]
    return Linkage.of(joints, name="RSSR", output="rocker")


def rccc() -> Linkage:
    """A revolute and three cylindrical joints: the general spatial four-bar, mobility 1."""
    axes = ([0, 0, 1], [0.5, 0.2, 1], [1, -0.6, 0.3], [0.2, 1, 0.5])
    places = ([0, 0, 0], [1, 0.2, 0], [1.2, 1, 0.4], [0.1, 0.8, 0.9])
    names = ("ground", "crank", "coupler", "rocker", "ground")
    joints = [
        joint(n, "R" if k == 0 else "C", names[k : k + 2], places[k], axes[k], actuated=k == 0)
        for k, n in enumerate("ABCD")
    ]
    return Linkage.of(joints, name="RCCC", output="rocker")


def screw_press(first: float = 0.01, second: float = 0.004) -> Linkage:
    """A spindle in two nuts of different pitch [m/rad], one fixed, one guided: a differential screw."""
    joints = [
        joint("nut", "helical", ["ground", "spindle"], [0, 0, 0], pitch=first, actuated=True),
        joint("inner", "helical", ["block", "spindle"], [0, 0, 1], pitch=second),
        joint("guide", "P", ["ground", "block"], [0, 0, 1], [0, 0, 1]),
    ]
    return Linkage.of(joints, name="differential screw", output="block")


def door(hinges: int = 2, tilt: float = 0.0) -> Linkage:
    """A door on coaxial hinges; tilt turns the last one out of line [rad]."""
    joints = [
        joint(
            f"hinge {k + 1}",
            "R",
            ["ground", "door"],
            [0, 0, k],
            [np.sin(tilt) * (k == hinges - 1), 0, np.cos(tilt)] if tilt else None,
        )
        for k in range(hinges)
    ]
    return Linkage.of(joints, name="door", output="door")
