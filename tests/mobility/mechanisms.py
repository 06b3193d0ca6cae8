"""Mechanisms of textbooks, drawn by points, for the tests."""

import numpy as np

from mafsil.mobility import Linkage, joint


def four_bar(points, planar=True, name="four-bar"):
    bodies = ["ground", "crank", "coupler", "rocker", "ground"]
    joints = [joint(n, "R", bodies[k : k + 2], p) for k, (n, p) in enumerate(zip("ABCD", points, strict=True))]
    return Linkage.of(joints, planar=planar, output="coupler", name=name)


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
