"""Random mechanisms: every joint kind, branches, mimic joints, massless links, right angles among random ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mafsil.arrays import Floats
from mafsil.model import Actuator, Inertial, Joint, JointKind, Link, Mechanism, Mimic

RIGHT_ANGLES = 0.3
"""Share of rotations made of exact quarter turns, of axes along a coordinate axis, of offsets with exact zeros."""
SMALL_ANGLES = 0.1
"""Share of rotations by tiny angles, as calibrations give: neighbouring axes almost parallel.

None is so small (1e-11) that it counts as what eleven decimals of pi/2 leave behind.
"""


def random_tree(rng: np.random.Generator, *, most_joints: int = 40, helical: bool = True) -> Mechanism:
    """A mechanism with 1 to `most_joints` moving joints, fixed ones between them.

    Args:
        rng: source of all choices.
        most_joints: largest number of moving joints, mimic joints included.
        helical: whether helical joints may appear.
    """
    count = int(rng.integers(1, most_joints + 1))
    kinds = [JointKind.REVOLUTE, JointKind.PRISMATIC, *([JointKind.HELICAL] if helical else [])]
    weights = np.array([0.7, 0.2, *([0.1] if helical else [])])
    return _tree(rng, count, kinds, weights / weights.sum(), fixed=0.15, mimic=0.1, massless=0.15)


def branched_tree(count: int, rng: np.random.Generator) -> Mechanism:
    """A tree of `count` revolute joints without extras: the size of a torso with two arms and hands."""
    return _tree(rng, count, [JointKind.REVOLUTE], np.ones(1), fixed=0.0, mimic=0.0, massless=0.0)


def serial_chain(count: int, rng: np.random.Generator) -> Mechanism:
    """A chain of `count` revolute joints in a row, without extras."""
    return _tree(rng, count, [JointKind.REVOLUTE], np.ones(1), fixed=0.0, mimic=0.0, massless=0.0, straightness=1.0)


def _tree(
    rng: np.random.Generator,
    count: int,
    kinds: list[JointKind],
    weights: Floats,
    *,
    fixed: float,
    mimic: float,
    massless: float,
    straightness: float | None = None,
) -> Mechanism:
    if straightness is None:
        straightness = float(rng.choice([0.5, 0.8, 0.95]))
    links, joints, moving = [Link("base", _inertial(rng))], [], 0
    while moving < count:
        parent = links[-1] if rng.random() < straightness else links[int(rng.integers(len(links)))]
        kind = JointKind.FIXED if rng.random() < fixed else kinds[int(rng.choice(len(kinds), p=weights))]
        moving += kind is not JointKind.FIXED
        link = Link(f"link{len(links)}", None if rng.random() < massless else _inertial(rng))
        joints.append(_joint(rng, f"joint{len(links)}", kind, parent.name, link.name))
        links.append(link)
    links = _with_heavy_leaves(rng, links, joints)
    joints = _with_mimics(rng, joints, mimic)
    carried = _pose(rng) if rng.random() < 0.5 else np.eye(4)
    return Mechanism.assemble(
        "random tree",
        links,
        joints,
        tip=links[int(rng.integers(1, len(links)))].name,
        T_lt=_pose(rng),
        T_sb=carried,
        gravity=rng.normal(size=3) * 6 if rng.random() < 0.3 else (0.0, 0.0, -9.81),
    )


def _joint(rng: np.random.Generator, name: str, kind: JointKind, parent: str, child: str) -> Joint:
    armature = float(rng.uniform(0.01, 1.0)) if rng.random() < 0.3 else 0.0
    return Joint(
        name,
        kind,
        parent,
        child,
        T_pj=_pose(rng),
        axis=_axis(rng),
        pitch=float(rng.uniform(-0.1, 0.1)) if kind is JointKind.HELICAL else 0.0,
        actuator=Actuator(armature=armature) if armature else None,
    )


def _with_heavy_leaves(rng: np.random.Generator, links: list[Link], joints: list[Joint]) -> list[Link]:
    """Massless links only inside: what ends a branch, and what a massless chain needs behind it, gets an inertia."""
    parents = {joint.parent for joint in joints}
    return [
        replace(link, inertial=_inertial(rng)) if link.inertial is None and link.name not in parents else link
        for link in links
    ]


def _with_mimics(rng: np.random.Generator, joints: list[Joint], share: float) -> list[Joint]:
    """Some joints follow others, before or behind them in the tree."""
    moving = [joint for joint in joints if joint.moves]
    leaders = [joint.name for joint in moving if rng.random() >= share] or [moving[0].name]
    result: list[Joint] = []
    for joint in joints:
        if joint.moves and joint.name not in leaders:
            leader = leaders[int(rng.integers(len(leaders)))]
            ratio = float(rng.choice([1.0, -1.0, 0.5, rng.uniform(-2, 2)]))
            joint = replace(joint, mimic=Mimic(leader, ratio, float(rng.choice([0.0, rng.uniform(-1, 1)]))))
        result.append(joint)
    return result


def _inertial(rng: np.random.Generator) -> Inertial:
    """A cloud of six points: mass 0.1 to 10 kg, realisable by construction, its centre beside the frame."""
    mass = float(10 ** rng.uniform(-1, 1))
    points = rng.normal(size=(6, 3)) * 10 ** rng.uniform(-1.5, -0.5, 3)
    points -= points.mean(axis=0)
    square = np.einsum("ki,kj->ij", points, points) * mass / len(points)
    return Inertial(
        mass, rng.normal(size=3) * 0.1 * (rng.random(3) > RIGHT_ANGLES), np.trace(square) * np.eye(3) - square
    )


def _pose(rng: np.random.Generator) -> Floats:
    exact = rng.random() < RIGHT_ANGLES
    rpy = rng.integers(-2, 3, 3) * (np.pi / 2) if exact else rng.uniform(-np.pi, np.pi, 3)
    if rng.random() < SMALL_ANGLES:
        rpy = (
            rng.choice([-1, 1], 3) * rng.uniform(0.3, 3, 3) * 10 ** rng.uniform(-9, -1) * (rng.random(3) > RIGHT_ANGLES)
        )
    xyz = rng.uniform(-0.4, 0.4, 3) * (rng.random(3) > RIGHT_ANGLES)
    R = _rotation(rpy)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = np.round(R) if exact and rng.random() < 0.5 else R, xyz
    return T


def _rotation(rpy: Floats) -> Floats:
    """Rot(z, yaw) Rot(y, pitch) Rot(x, roll), with the roundoff that cosines of right angles leave."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    Rx = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    Ry = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    Rz = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return Rz @ Ry @ Rx


def _axis(rng: np.random.Generator) -> Floats:
    if rng.random() < 2 * RIGHT_ANGLES:
        return np.eye(3)[int(rng.integers(3))] * rng.choice([-1.0, 1.0])
    axis = rng.normal(size=3)
    return axis / np.linalg.norm(axis)
