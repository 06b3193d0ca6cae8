"""A six-joint arm of primitives, written here, and scenes of all kinds of obstacles."""

from __future__ import annotations

import numpy as np

import mafsil as mf
from mafsil import collision
from mafsil.collision import Box, Capsule, Cone, Cylinder, Obstacle, Plane, Sphere
from tests.collision.peer import random_poses

_SHAPES = (
    '<cylinder radius="0.08" length="0.2"/>',
    '<sphere radius="0.09"/>',
    '<box size="0.1 0.12 0.4"/>',
    '<cylinder radius="0.05" length="0.35"/>',
    '<sphere radius="0.06"/>',
    '<box size="0.08 0.06 0.1"/>',
    '<cylinder radius="0.03" length="0.12"/>',
)
_AXES = ("0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0", "0 0 1")
_STEPS = ("0 0 0.2", "0 0.1 0", "0 0 0.4", "0.05 0 0.35", "0 0 0.1", "0 0.02 0.1")

TOUCHING = """<robot name="touching">
<link name="base"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
<link name="middle"><collision><origin xyz="0.4 0 0"/><geometry><sphere radius="0.02"/></geometry></collision></link>
<link name="end"><collision><origin xyz="-0.4 0 0"/><geometry><sphere radius="0.05"/></geometry></collision></link>
<joint name="first" type="revolute"><parent link="base"/><child link="middle"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="second" type="revolute"><parent link="middle"/><child link="end"/><origin xyz="0.4 0 0"/>
<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint></robot>"""
"""Two links of it meet always."""
LISTED = '<robot name="touching"><disable_collisions link1="base" link2="end" reason="Default"/></robot>'
"""An SRDF file that leaves them out."""


def urdf() -> str:
    """The arm as a URDF."""
    places = ("0 0 0.1", "0 0 0", "0 0 0.2", "0 0 0.18", "0 0 0", "0 0 0.03", "0 0 0.06")
    links = "".join(
        f'<link name="link{k}"><collision><origin xyz="{places[k]}"/><geometry>{shape}</geometry></collision></link>'
        for k, shape in enumerate(_SHAPES)
    )
    return f'<robot name="primitive_arm">{links}{_joints()}</robot>'


def arm_of_many_pieces(tmp_path, kinds=("sphere", "sphere", "box")) -> mf.Robot:
    """The same joints; each link carries a dozen pieces along its way to the next one."""
    rng, links = np.random.default_rng(7), ""
    for k, step in enumerate((*_STEPS, "0 0 0.1")):
        pieces = ""
        for i in range(12):
            place = np.array(step.split(), float) * (i + 1) / 13 + rng.normal(size=3) * 0.03
            size = {"sphere": 'radius="0.02"', "box": 'size="0.03 0.04 0.02"'}[kinds[i % len(kinds)]]
            shape = f"<geometry><{kinds[i % len(kinds)]} {size}/></geometry>"
            pieces += f'<collision><origin xyz="{place[0]} {place[1]} {place[2]}"/>{shape}</collision>'
        links += f'<link name="link{k}">{pieces}</link>'
    path = tmp_path / "many.urdf"
    path.write_text(f'<robot name="many_pieces">{links}{_joints()}</robot>')
    return mf.load(str(path))


def _joints() -> str:
    return "".join(
        f'<joint name="joint{k + 1}" type="revolute"><parent link="link{k}"/><child link="link{k + 1}"/>'
        f'<origin xyz="{_STEPS[k]}"/><axis xyz="{_AXES[k]}"/>'
        '<limit lower="-2.8" upper="2.8" velocity="2" effort="50"/></joint>'
        for k in range(6)
    )


def arm(tmp_path) -> mf.Robot:
    """The arm, loaded."""
    path = tmp_path / "arm.urdf"
    path.write_text(urdf())
    return mf.load(str(path))


def scene(seed: int, count: int = 8) -> collision.Scene:
    """Obstacles of all kinds around the arm, and a floor."""
    rng = np.random.default_rng(seed)
    kinds = [
        lambda: Sphere(rng.uniform(0.05, 0.15)),
        lambda: Box(tuple(rng.uniform(0.05, 0.4, 3))),
        lambda: Cylinder(*rng.uniform(0.05, 0.3, 2)),
        lambda: Capsule(*rng.uniform(0.05, 0.2, 2)),
        lambda: Cone(*rng.uniform(0.1, 0.3, 2)),
        lambda: collision.ConvexHull(rng.normal(size=(12, 3)) * 0.1),
    ]
    poses = random_poses(count, 0.5, seed)
    directions = rng.normal(size=(count, 3))
    poses[:, :3, 3] = rng.uniform(0.35, 1.0, (count, 1)) * directions / np.linalg.norm(directions, axis=1)[:, None]
    made = [Obstacle(kinds[k % len(kinds)](), poses[k]) for k in range(count)]
    return collision.Scene([*made, Obstacle(Plane(), (0.0, 0.0, -0.4), "floor")])
