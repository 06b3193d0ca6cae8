"""Over-constrained mechanisms of known mobility, built at random: each by the theorem that says why it moves.

A builder takes a generator and gives joints, which hang on the body "ground", and the dimension of the set of
configurations through the drawing. `composed` hangs several on each other and adds chains that take what they give.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from mafsil.arrays import Floats
from mafsil.geometry import pose
from mafsil.mobility import Linkage, joint, library
from mafsil.mobility.linkages import LinkageJoint

Built = tuple[list[LinkageJoint], int]
EX, EY, EZ = np.eye(3)


def displaced(joints: list[LinkageJoint], T: Floats, mark: str = "", ground: str = "ground") -> list[LinkageJoint]:
    """Joints at another place, hung on another body; names of joints and bodies get a mark."""
    moved: list[LinkageJoint] = []
    for each in joints:
        bodies = [ground if name == "ground" else name + mark for name in (each.parent, each.child)]
        place = T[:3, :3] @ each.point + T[:3, 3]
        moved.append(joint(each.name + mark, each.kind, bodies, place, T[:3, :3] @ each.axis, pitch=each.pitch))
    return moved


def somewhere(rng: np.random.Generator) -> Floats:
    """(4, 4) a random pose."""
    return pose.exp(rng.normal(size=6) * [1.5, 1.5, 1.5, 2, 2, 2])


def chain(name: str, start: str, end: str, kinds: Iterable[str], places: Floats, axes: Floats) -> list[LinkageJoint]:
    """A row of joints from body to body; the bodies between get names of their own."""
    kinds = list(kinds)
    bodies = [start, *(f"{name} {k}" for k in range(len(kinds) - 1)), end]
    return [
        joint(f"{name}{k}", kind, bodies[k : k + 2], places[k], axes[k], pitch=0.4 if kind == "H" else 0.0)
        for k, kind in enumerate(kinds)
    ]


def planar(rng: np.random.Generator, count: int) -> tuple[list[str], Floats, Floats]:
    """Kinds, places and axes of parallel hinges, at most two of them sliders across."""
    kinds = np.array(list("R" * count))
    kinds[rng.permutation(count)[: int(rng.integers(0, min(2, count - 2) + 1))]] = "P"
    angles = rng.uniform(0, np.pi, count)
    across = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(count)])
    return kinds.tolist(), rng.normal(size=(count, 3)), np.where(kinds[:, None] == "R", EZ, across)


def spherical(rng: np.random.Generator, count: int, centre: Floats) -> tuple[list[str], Floats, Floats]:
    """Kinds, places and axes of hinges through one point."""
    axes = rng.normal(size=(count, 3))
    return ["R"] * count, centre + rng.uniform(-2, 2, (count, 1)) * axes, axes


def planar_loop(rng: np.random.Generator) -> Built:
    """n joints of the plane in one loop: n - 3."""
    n = int(rng.integers(4, 8))
    return chain("J", "ground", "ground", *planar(rng, n)), n - 3


def planar_platform(rng: np.random.Generator) -> Built:
    """k chains of the plane between two bodies, each of three joints or more: 3 + sum (n - 3)."""
    counts = rng.integers(3, 5, int(rng.integers(2, 5)))
    joints = [chain(f"L{k}", "ground", "platform", *planar(rng, int(n))) for k, n in enumerate(counts)]
    return [each for leg in joints for each in leg], 3 + int((counts - 3).sum())


def tilted_planar_loop(rng: np.random.Generator) -> Built:
    """One hinge of a planar loop tilted: it stands still, the others lose it: n - 4."""
    n = int(rng.integers(4, 8))
    axes = np.tile(EZ, (n, 1))
    axes[int(rng.integers(n))] += 0.3 * rng.uniform(0.5, 1) * EX
    return chain("J", "ground", "ground", "R" * n, rng.normal(size=(n, 3)), axes), n - 4


def spherical_loop(rng: np.random.Generator) -> Built:
    """n hinges through one point in one loop: n - 3."""
    n = int(rng.integers(4, 8))
    return chain("J", "ground", "ground", *spherical(rng, n, rng.normal(size=3))), n - 3


def spherical_platform(rng: np.random.Generator) -> Built:
    """k chains of hinges through one point between two bodies: 3 + sum (n - 3)."""
    counts, centre = rng.integers(3, 5, int(rng.integers(2, 5))), rng.normal(size=3)
    joints = [chain(f"L{k}", "ground", "platform", *spherical(rng, int(n), centre)) for k, n in enumerate(counts)]
    return [each for leg in joints for each in leg], 3 + int((counts - 3).sum())


def parallel_cranks(rng: np.random.Generator) -> Built:
    """Equal parallel cranks, three to six, between two bodies: 1."""
    tip = np.array([np.cos(angle := rng.uniform(0.3, 2.8)), np.sin(angle), 0.0])
    joints: list[LinkageJoint] = []
    for k in range(int(rng.integers(3, 7))):
        foot = np.append(np.array([2.0 * k, 0.0]) + rng.uniform(-0.8, 0.8, 2), 0.0)
        joints += chain(f"C{k}", "ground", "coupler", "RR", np.array([foot, foot + tip]), np.tile(EZ, (2, 1)))
    return joints, 1


def bent_cranks(rng: np.random.Generator) -> Built:
    """Parallel cranks, one of them a tenth longer: 0."""
    joints, _ = parallel_cranks(rng)
    joints[1] = joint(joints[1].name, "R", [joints[1].parent, joints[1].child], joints[1].point + 0.1 * EX, EZ)
    return joints, 0


def palletiser(rng: np.random.Generator) -> Built:
    """A turning column, two arms, and parallelograms that keep the hand level: 3."""
    reach, fore = rng.uniform(0.6, 1.4, 2)
    a, b = rng.uniform(0.5, 1.2), rng.uniform(-0.6, 0.4)
    elbow = reach * np.array([np.cos(a), 0, np.sin(a)])
    wrist = elbow + fore * np.array([np.cos(b), 0, np.sin(b)])
    off, along = np.array([-0.2, 0, 0.15]), np.array([0.1, 0, 0.25])
    places = {
        "column": np.zeros(3), "shoulder": np.zeros(3), "elbow": elbow, "wrist": wrist, "rod foot": off,
        "rod knee": elbow + off, "knee": elbow, "upper rod": elbow + along, "level": wrist + along,
    }  # fmt: skip
    bodies = {
        "column": ("ground", "post"), "shoulder": ("post", "upper arm"), "elbow": ("upper arm", "forearm"),
        "wrist": ("forearm", "hand"), "rod foot": ("post", "rod"), "rod knee": ("rod", "triangle"),
        "knee": ("upper arm", "triangle"), "upper rod": ("triangle", "link"), "level": ("link", "hand"),
    }  # fmt: skip
    return [joint(n, "R", bodies[n], places[n], EZ if n == "column" else EY) for n in places], 3


def sarrus(rng: np.random.Generator) -> Built:
    """k planar chains in planes that share one direction: 1 + sum (n - 3)."""
    counts = rng.integers(3, 5, int(rng.integers(2, 5)))
    joints: list[LinkageJoint] = []
    for k, n in enumerate(counts):
        angle = np.pi * (k + rng.uniform(0.15, 0.85)) / len(counts)
        axis = np.array([np.cos(angle), np.sin(angle), 0])
        joints += chain(f"L{k}", "ground", "platform", "R" * int(n), rng.normal(size=(n, 3)), np.tile(axis, (n, 1)))
    return joints, 1 + int((counts - 3).sum())


def translating_platform(rng: np.random.Generator) -> Built:
    """k legs of a slider and parallel hinges in different directions: 3 + sum (n - 4)."""
    counts, joints = rng.integers(4, 6, int(rng.integers(2, 5))), list[LinkageJoint]()
    for k, n in enumerate(counts):
        axes = np.tile(rng.normal(size=3), (n, 1))
        axes[0] = rng.normal(size=3)
        joints += chain(f"L{k}", "ground", "platform", "P" + "R" * (int(n) - 1), rng.normal(size=(n, 3)), axes)
    return joints, 3 + int((counts - 4).sum())


def bennett_sides(rng: np.random.Generator) -> tuple[float, float]:
    """Length and angle of the first side, such that others of up to twice the length exist."""
    return float(rng.uniform(0.8, 1.4)), float(rng.uniform(0.2, 0.45)) * float(rng.choice([-1, 1]))


def bennett(rng: np.random.Generator) -> Built:
    """Bennett's four hinges: 1."""
    a, alpha = bennett_sides(rng)
    b = a * float(rng.uniform(1.2, 2.0))
    return list(library.bennett(a, alpha, b, float(rng.uniform(0.4, 2.6))).joints), 1


def bent_bennett(rng: np.random.Generator) -> Built:
    """Bennett's linkage with one hinge moved: 0."""
    joints, _ = bennett(rng)
    bent = joints[2]
    joints[2] = joint(bent.name, "R", [bent.parent, bent.child], bent.point + 0.1 * rng.normal(size=3), bent.axis)
    return joints, 0


def goldberg(rng: np.random.Generator) -> Built:
    """Two of Bennett's linkages with one side in common, two sides welded; the common side kept or left out: 1."""
    a, alpha = bennett_sides(rng)
    angles = rng.uniform(0.4, 2.6, 2)
    sides = a * rng.uniform(1.2, 2.0, 2)
    first, second = (list(library.bennett(a, alpha, b, t).joints) for b, t in zip(sides, angles, strict=True))
    second = displaced(second, pose.exp([0, 0, angles[0] - angles[1], 0, 0, 0]), "'")
    common, middle = first[0], first[1]
    joints = [*first[2:], *second[2:]]
    if rng.random() < 0.5:
        return [*joints, joint("M", "R", ["link 2", "link 2'"], middle.point, middle.axis)], 1
    kept = [common, middle, joint("M", "R", ["link 1", "link 2'"], middle.point, middle.axis)]
    return [*kept, *joints], 1


def line_symmetric(rng: np.random.Generator) -> Built:
    """Three joints and what half a turn about a line makes of them, in one loop (Bricard): 1."""
    kinds = list(rng.choice(["R", "R", "R", "H", "P"], 3))
    if "P" in kinds:
        kinds = ["R", "P", "R"]
    places, axes = rng.normal(size=(3, 3)), rng.normal(size=(3, 3))
    half = np.diag([-1.0, -1.0, 1.0])
    both = np.vstack([places, places @ half]), np.vstack([axes, axes @ half])
    return chain("J", "ground", "ground", [*kinds, *kinds], *both), 1


def plane_symmetric(rng: np.random.Generator) -> Built:
    """Six hinges, two of them in a plane and four mirrored by it (Bricard): 1."""
    places, axes = rng.normal(size=(4, 3)), rng.normal(size=(4, 3))
    places[[0, 3], 2] = axes[[0, 3], 2] = 0
    mirror = np.diag([1.0, 1.0, -1.0])
    both = np.vstack([places, places[[2, 1]] @ mirror]), np.vstack([axes, axes[[2, 1]] @ mirror])
    return chain("J", "ground", "ground", "R" * 6, *both), 1


BUILDERS: dict[str, Callable[[np.random.Generator], Built]] = {
    each.__name__: each
    for each in (
        planar_loop, planar_platform, tilted_planar_loop, spherical_loop, spherical_platform, parallel_cranks,
        bent_cranks, palletiser, sarrus, translating_platform, bennett, bent_bennett, goldberg, line_symmetric,
        plane_symmetric,
    )
}  # fmt: skip


def composed(rng: np.random.Generator, names: Iterable[str]) -> tuple[Linkage, int]:
    """Mechanisms, each hung on a body of the one before, and sometimes a chain of general joints between two bodies.

    What hangs on one body adds its mobility. A chain of n general joints of one freedom, n >= 6, spans all motions of
    space by itself, so that closing it takes exactly 6: it adds n - 6.
    """
    joints, mobility, body = list[LinkageJoint](), 0, "ground"
    for k, name in enumerate(names):
        more, freedoms = BUILDERS[name](rng)
        joints += displaced(more, somewhere(rng), f" {k}", body)
        mobility += freedoms
        body = str(rng.choice(sorted({each.child for each in joints})))
    if rng.random() < 0.3:
        n = int(rng.integers(6, 8))
        start, end = rng.choice(sorted({each.child for each in joints} | {"ground"}), 2, replace=False)
        kinds = rng.choice(["R", "R", "R", "P"], n)
        kinds[:4] = "R"
        joints += chain(
            "E", str(start), str(end), rng.permutation(kinds), rng.normal(size=(n, 3)), rng.normal(size=(n, 3))
        )
        mobility += n - 6
    return Linkage.of(joints, ground="ground"), mobility
