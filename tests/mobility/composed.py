"""Over-constrained mechanisms put together from blocks whose mobility and redundant constraints are theorems.

`python -m tests.mobility.composed 3000` judges so many and prints those that are judged wrongly.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial.transform import Rotation

import mafsil as mf
from mafsil import mobility as mo
from mafsil.mobility import Linkage, joint, library


@dataclass
class Block:
    """A linkage, its mobility, conditions that loops imply by their groups, and those by lengths and angles."""

    linkage: Linkage
    mobility: int
    implied: list[int] = field(default_factory=list)
    special: int = 0


def ring(kind, places, axes):
    """One loop of joints of a kind."""
    n = len(places)
    bodies = ["ground", *(f"b{k}" for k in range(1, n)), "ground"]
    joints = [joint(f"J{k}", kind, bodies[k : k + 2], places[k], axes[k]) for k in range(n)]
    return Linkage.of(joints, output=bodies[n // 2])


def planar(rng, n):
    return Block(ring("R", np.c_[rng.normal(size=(n, 2)), np.zeros(n)], [[0, 0, 1]] * n), n - 3, [3])


def spherical(rng):
    return Block(ring("R", np.zeros((4, 3)), rng.normal(size=(4, 3))), 1, [3])


def bennett(rng):
    alpha, b = rng.uniform(0.3, 1.2), rng.uniform(0.5, 1.0)
    return Block(library.bennett(1.0, alpha, b, rng.uniform(0.4, 2.4)), 1, [], 3)


def sarrus(rng):
    return Block(library.sarrus(), 1, [], 1)


def seven_hinges(rng):
    return Block(ring("R", rng.normal(size=(7, 3)), rng.normal(size=(7, 3))), 1)


def cranks(rng):
    """A bar on parallel cranks of one length: 2 k hinges and mobility 1 leave rank 2 k - 1."""
    k, arm = int(rng.integers(2, 5)), rng.normal(size=2)
    joints = []
    for each in range(k):
        at = rng.normal(size=2)
        joints.append(joint(f"A{each}", "R", ["ground", f"crank {each}"], at))
        joints.append(joint(f"B{each}", "R", [f"crank {each}", "bar"], at + arm))
    loops = k - 1
    return Block(Linkage.of(joints, output="bar"), 1, [3] * loops, 6 * loops - (2 * k - 1) - 3 * loops)


def parallel(rng, kind, freedoms):
    """Joints that allow the same motions, side by side: each but one is implied by its 6 - f conditions."""
    k, axis = int(rng.integers(2, 5)), rng.normal(size=3)
    along = np.zeros(k) if kind == "S" else rng.normal(size=k)
    joints = [joint(f"H{each}", kind, ["ground", "body"], along[each] * axis, axis) for each in range(k)]
    return Block(Linkage.of(joints), freedoms, [6 - freedoms] * (k - 1))


BLOCKS = (
    lambda rng: planar(rng, 3), lambda rng: planar(rng, 4), lambda rng: planar(rng, 5), spherical, bennett, sarrus,
    seven_hinges, cranks, lambda rng: parallel(rng, "R", 1), lambda rng: parallel(rng, "P", 1),
    lambda rng: parallel(rng, "C", 2), lambda rng: parallel(rng, "S", 3),
)  # fmt: skip
GLUED = (lambda rng: planar(rng, 4), spherical, bennett, sarrus, seven_hinges)


def placed(block, R, t, scale, bodies, prefix):
    """Joints of a block elsewhere; bodies that are named so keep to that, the others get the prefix."""
    return [
        joint(
            prefix + each.name, each.kind, [bodies.get(b, prefix + b) for b in (each.parent, each.child)],
            R @ (scale * each.point) + t, R @ each.axis,
        )
        for each in block.linkage.joints
    ]  # fmt: skip


def composed(seed):
    """Blocks one on the other, at any place and scale, some glued by a joint that both share, one joint doubled."""
    rng = np.random.default_rng(seed)
    scale = 10.0 ** rng.uniform(-3, 3)
    joints, bodies, whole = [], ["ground"], Block(Linkage("", (), (), ""), 0)
    for k in range(int(rng.integers(1, 5))):
        block = BLOCKS[int(rng.integers(len(BLOCKS)))](rng)
        R = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix()
        base = {block.linkage.ground: bodies[int(rng.integers(len(bodies)))]}
        joints += placed(block, R, scale * rng.normal(size=3), scale, base, f"{k}.")
        bodies.append(f"{k}.{block.linkage.output}")
        added(whole, block)
    moving = [each for each in joints if each.kind is mo.linkages.Kind.REVOLUTE] if whole.mobility else []
    for k in range(int(rng.integers(0, 3)) if moving and rigid_free(whole, joints) else 0):
        block = GLUED[int(rng.integers(len(GLUED)))](rng)
        host, own = (each[int(rng.integers(len(each)))] for each in (moving, block.linkage.joints))
        turn, _ = Rotation.align_vectors([host.axis], [own.axis])
        R = (Rotation.from_rotvec(host.axis * rng.uniform(-3, 3)) * turn).as_matrix()
        t = host.point + scale * rng.normal() * host.axis - R @ (scale * own.point)
        new = placed(block, R, t, scale, {own.parent: host.parent, own.child: host.child}, f"glued {k}.")
        joints += [each for each in new if each.name != f"glued {k}.{own.name}"]
        added(whole, block)
        whole.mobility -= 1
    if rng.random() < 0.4:
        each = joints[int(rng.integers(len(joints)))]
        joints.append(replace(each, name=f"{each.name} doubled"))
        whole.implied.append(6 - each.freedoms)
    whole.linkage = Linkage.of([joints[k] for k in rng.permutation(len(joints))], output=bodies[-1])
    return whole


def added(whole, block):
    whole.mobility += block.mobility
    whole.implied += block.implied
    whole.special += block.special


def rigid_free(whole, joints):
    """Whether every hinge moves: blocks glued to one that does not would be locked."""
    linkage = Linkage.of(joints)
    rates = mo.instantaneous_mobility(linkage).rates
    return bool((np.abs(rates).max(axis=1) > 1e-6).all())


def wrong(seed):
    """What is judged wrongly of a mechanism, which half of the time is moved before; empty if nothing."""
    whole = composed(seed)
    linkage = whole.linkage
    if seed % 2:
        rates = mo.instantaneous_mobility(linkage).rates
        step = 0.25 * rates @ np.random.default_rng(seed).normal(size=rates.shape[1])
        if near := mo.linkages.close_loops_near(linkage, step * mo.linkages.loop_closure.units(linkage)):
            linkage = mo.linkages.draw_at(linkage, near.theta)
    found = mf.mobility(linkage)
    wanted = whole.mobility, sorted(whole.implied), whole.special
    got = found.mobility, sorted(cause.implied for cause in found.redundancy), found.redundancy.special
    return "" if got == wanted else f"{seed}: wanted {wanted}, got {got}"


if __name__ == "__main__":
    faults = [text for seed in range(int(sys.argv[1])) if (text := wrong(seed))]
    print("\n".join([*faults, f"{len(faults)} of {sys.argv[1]} judged wrongly"]))
