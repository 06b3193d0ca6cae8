"""Mechanisms of textbooks, drawn by points, for the tests."""

import numpy as np

from mafsil.mobility import Linkage, joint
from mafsil.mobility.linkages import coincident_joints


def four_bar(points, planar=True, name="four-bar"):
    bodies = ["ground", "crank", "coupler", "rocker", "ground"]
    joints = [joint(n, "R", bodies[k : k + 2], p) for k, (n, p) in enumerate(zip("ABCD", points, strict=True))]
    return Linkage.of(joints, planar=planar, output="coupler", name=name)


def scissors(count, angle=0.6):
    """Crossed pairs of equal bars in a row."""
    w, h, joints = np.cos(angle), np.sin(angle), []
    for k in range(count):
        joints.append(joint(f"M{k}", "R", [f"up{k}", f"down{k}"], [2 * w * k + w, 0]))
        if k:
            joints.append(joint(f"T{k}", "R", [f"up{k - 1}", f"down{k}"], [2 * w * k, h]))
            joints.append(joint(f"B{k}", "R", [f"down{k - 1}", f"up{k}"], [2 * w * k, -h]))
    return Linkage.of(joints, ground="up0", planar=True, name="scissors")


def parallel_cranks(angles):
    joints = []
    for k, (x, angle) in enumerate(zip((0.0, 1.5, 3.0), angles, strict=True)):
        tip = [x + np.cos(angle), np.sin(angle)]
        joints += [joint(f"G{k}", "R", ["ground", f"c{k}"], [x, 0]), joint(f"K{k}", "R", [f"c{k}", "coupler"], tip)]
    return Linkage.of(joints, planar=True, output="coupler", name="parallel cranks")


def five_bar(T1, T2, M=(1.6, 2.0)):
    bodies = ["ground", "a", "b", "c", "d", "ground"]
    points = {"O": (0, 0), "T1": T1, "M": M, "T2": T2, "D": (2, 0)}
    joints = [joint(n, "R", bodies[k : k + 2], p) for k, (n, p) in enumerate(points.items())]
    return Linkage.of(joints, planar=True, output="b", name="five-bar")


def platform(inner, rng):
    """Six legs of random places."""
    joints = []
    for k in range(6):
        a, b = rng.normal(size=3), np.append(rng.normal(size=2) / 2, 2 + rng.normal() / 10)
        d = (b - a) / np.linalg.norm(b - a)
        u = np.cross(d, rng.normal(size=3))
        w = np.cross(u, rng.normal(size=3))
        joints += [
            joint(f"A{k}", inner, ["ground", f"lower{k}"], a, u, second=w if inner == "U" else None),
            joint(f"P{k}", "P", [f"lower{k}", f"upper{k}"], a, d, actuated=True),
            joint(f"B{k}", "S", [f"upper{k}", "platform"], b),
        ]
    return Linkage.of(joints, name=f"6{inner}PS", output="platform")


def three_upu(axes, offset=(0.0, 0.0, 0.0), radius=0.5):
    joints = []
    for k, angle in enumerate(np.radians([90, 210, 330])):
        r, t = np.array([np.cos(angle), np.sin(angle), 0]), np.array([-np.sin(angle), np.cos(angle), 0])
        B = radius * r + np.array([0, 0, 2]) + offset
        outer, d = (r if axes == "radial" else t), B - r
        inner = np.cross(d, outer)
        joints += [
            joint(f"A{k}", "U", ["ground", f"lower{k}"], r, outer, second=inner),
            joint(f"P{k}", "P", [f"lower{k}", f"upper{k}"], r, d, actuated=True),
            joint(f"B{k}", "U", [f"upper{k}", "platform"], B, inner, second=outer),
        ]
    return Linkage.of(joints, name=f"3UPU {axes}", output="platform")


def random_linkage(rng, loops, bodies):
    """A random connected graph of bodies and joints R, P, H, C, U, S, with special axes now and then."""
    kinds = ["R", "R", "R", "P", "H", "C", "U", "S"]
    edges = [(int(rng.integers(0, k)), k) for k in range(1, bodies)]
    while len(edges) < bodies - 1 + loops:
        a, b = rng.integers(0, bodies, 2)
        if a != b:
            edges.append((int(a), int(b)))
    special, joints = rng.random() < 0.5, []
    for k, (a, b) in enumerate(edges):
        kind = kinds[rng.integers(len(kinds))]
        axis = np.eye(3)[rng.integers(3)] if special else rng.normal(size=3)
        second = np.cross(axis, rng.normal(size=3)) if kind == "U" else None
        place = rng.integers(-2, 3, 3).astype(float) if special else rng.normal(size=3)
        pitch = 0.3 if kind == "H" else 0.0
        joints.append(joint(f"J{k}", kind, [f"b{a}", f"b{b}"], place, axis, second=second, pitch=pitch))
    return Linkage.of(joints, ground="b0")


def at_lengths(A, a, B, b, side):
    """(..., 2) the point at lengths a from A and b from B, to the left of A -> B if side is 1."""
    A, B = np.asarray(A, float), np.asarray(B, float)
    d = B - A
    far = np.sum(d**2, axis=-1, keepdims=True)
    along = (far + a**2 - b**2) / (2 * far)
    across = np.sqrt(a**2 / far - along**2)
    return A + along * d + side * across * np.stack([-d[..., 1], d[..., 0]], axis=-1)


def drawn(joints, places, output, **details):
    """A planar linkage of pins {name: bodies} at places {name: (2,)}; a pin through several bodies is one entry."""
    every = [each for name, bodies in joints.items() for each in coincident_joints(name, "R", bodies, places[name])]
    return Linkage.of(every, planar=True, output=output, **details)


JANSEN = dict(zip("abcdefghijklm", (38, 41.5, 39.3, 40.1, 55.8, 39.4, 36.7, 65.7, 49, 50, 61.9, 7.8, 15), strict=True))


def jansen_places(angle):
    """Places of Jansen's leg [m] at angles of its crank: {name: (..., 2)}, by circles alone."""
    n, one = JANSEN, np.ones_like(angle)[..., None]
    O, B = 0.0 * one * [1, 1], one * [-n["a"], -n["l"]]
    P = n["m"] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    U = at_lengths(B, n["b"], P, n["j"], 1)
    W = at_lengths(B, n["d"], U, n["e"], 1)
    L = at_lengths(B, n["c"], P, n["k"], -1)
    F = at_lengths(W, n["f"], L, n["g"], -1)
    return {"O": O, "P": P, "U": U, "B": B, "W": W, "L": L, "F": F, "foot": at_lengths(F, n["h"], L, n["i"], 1)}


def jansen():
    joints = {
        "O": ["ground", "crank"], "P": ["crank", "j", "k"], "U": ["j", "top"], "B": ["top", "ground", "c"],
        "W": ["top", "f"], "L": ["k", "c", "shin"], "F": ["f", "shin"],
    }  # fmt: skip
    return drawn(joints, jansen_places(np.array(0.4)), "shin", name="Jansen")


def klann_places(angle):
    """Places of a leg of Klann's kind (lengths of boim.com/Walkin8r/Klann.html) at angles of its crank."""
    one = np.ones_like(angle)[..., None]
    A, B, D = 0.0 * one * [1, 1], one * [-38.8, -12.5], one * [-14.6, 41.9]
    C = 17.5 * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    H = at_lengths(B, 23.7, C, 38.8, 1)
    F = at_lengths(C, 73.4, H, 35.2, 1)
    E = at_lengths(D, 34.1, F, 57.7, -1)
    return {"A": A, "B": B, "C": C, "D": D, "E": E, "F": F, "H": H, "foot": at_lengths(E, 111.7, F, 59.0, 1)}


def klann():
    joints = {
        "A": ["ground", "crank"], "C": ["crank", "rod"], "H": ["rod", "lower"], "B": ["lower", "ground"],
        "F": ["rod", "leg"], "E": ["leg", "upper"], "D": ["upper", "ground"],
    }  # fmt: skip
    return drawn(joints, klann_places(np.array(0.4)), "leg", name="Klann")


def hart():
    """Hart's inversor: Q of the output draws an exact straight line across O -> G."""
    share, A, B, C, D = 0.4, *(np.array(p, float) for p in ((-2, 0), (1, 1.5), (2, 0), (-1, 1.5)))
    places = {
        "A": A, "B": B, "C": C, "D": D, "O": A + share * (B - A), "P": A + share * (D - A), "Q": C + share * (B - C),
        "G": np.array([-1.2, -0.3]),
    }  # fmt: skip
    joints = {
        "G": ["ground", "crank"], "O": ["ground", "long"], "A": ["long", "short"], "B": ["long", "output"],
        "C": ["output", "other"], "D": ["other", "short"], "P": ["crank", "short"],
    }  # fmt: skip
    return drawn(joints, places, "output", name="Hart"), places
