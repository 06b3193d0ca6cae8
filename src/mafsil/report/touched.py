"""What the tip touches in the replay: plates, balls, bars, rails and holes that stand, doors that turn with the tip."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, Vector3
from mafsil.geometry import rotation
from mafsil.job import Job, Run
from mafsil.job.contact_tables import Guide, Hole, Surface
from mafsil.job.door_grips import grips
from mafsil.scene import Body, Solid
from mafsil.scene.drawing import Colour
from mafsil.scene.inline import near_side, patch, stretch

COLOUR = (0.62, 0.70, 0.74, 1.0)
CLEAR = (*COLOUR[:3], 0.22)
"""Of what is hollow, and of the face of a hole: the arm shows through."""
SHAFT_COLOUR = (0.24, 0.26, 0.30, 1.0)
DOOR_COLOUR = (0.66, 0.52, 0.36, 1.0)
PLATE, THIN, RAIL = 0.45, 2e-3, 4e-3
"""Edge of a plate that is touched in a point, thickness of plates and of rails, as shares of the scene."""
BESIDE = 0.01
"""How far from a plane the tip still is at it, beyond where it is nearest, as share of the scene."""
PANEL_HEIGHT, PANEL_THICKNESS = 0.7, 0.03
"""Of a door, as shares of its width."""


def standing(job: Job, size: float, tips: Floats) -> list[tuple[Body, PoseMatrix]]:
    """Surfaces, guides and holes with their poses; of what is endless the part that the tip is beside.

    Args:
        job: what is asked.
        size: radius of the scene [m].
        tips: (frames, 3) where the tip was, or will be [m].
    """
    found = [_surface(one, size, tips) for one in job.surface]
    found += [_guide(one, size, tips) for one in job.guide]
    return [*found, *(_hole(one, size, tips) for one in job.hole)]


def _surface(one: Surface, size: float, tips: Floats) -> tuple[Body, PoseMatrix]:
    place = np.array(one.point)
    if one.normal is not None:
        T = _facing(place, np.array(one.normal))
        return Body(one.name, (_plate(T, near_side(T, tips, BESIDE * size), size),)), T
    colour = CLEAR if one.hollow else COLOUR
    if one.sphere is not None:
        return Body(one.name, (Solid("sphere", (one.sphere,), colour=colour),)), _facing(place, np.array([0.0, 0, 1]))
    assert one.cylinder is not None
    T = _facing(place, np.array(one.axis))
    return Body(one.name, (_bar(T, tips, one.cylinder, size, colour),)), T


def _hole(one: Hole, size: float, tips: Floats) -> tuple[Body, PoseMatrix]:
    """The room of the peg's axis, from the mouth to the bottom and at least as wide as a rail, in a face."""
    radius = max(one.clearance + one.chamfer, RAIL * size)
    shaft = Solid("cylinder", (radius, one.depth), (0.0, 0.0, -one.depth / 2.0, 1.0, 0.0, 0.0, 0.0), SHAFT_COLOUR)
    T = _facing(np.array(one.mouth), np.array(one.axis))
    around = np.concatenate([np.array([one.mouth]), near_side(T, tips, BESIDE * size)])
    return Body(one.name, (_plate(T, around, size, CLEAR), shaft)), T


def _guide(one: Guide, size: float, tips: Floats) -> tuple[Body, PoseMatrix]:
    if one.direction is not None:
        T = _facing(np.array(one.point), np.array(one.direction))
        return Body(one.name, (_bar(T, tips, RAIL * size, size, COLOUR),)), T
    T = _facing(np.array(one.point), np.array(one.normal))
    return Body(one.name, (_plate(T, tips, size),)), T


def _plate(T: PoseMatrix, seen: Floats, size: float, colour: Colour = COLOUR) -> Solid:
    """A thin plate whose upper side is the part of the x-y plane beside some points."""
    (x, y), (a, b) = (each.tolist() for each in patch(T, seen, PLATE * size))
    return Solid("box", (a, b, THIN * size), (x, y, -THIN * size / 2.0, 1.0, 0.0, 0.0, 0.0), colour)


def _bar(T: PoseMatrix, seen: Floats, radius: float, size: float, colour: Colour) -> Solid:
    """A round bar along the part of the z axis beside some points."""
    middle, length = stretch(T, seen, PLATE * size)
    return Solid("cylinder", (radius, length), (0.0, 0.0, middle, 1.0, 0.0, 0.0, 0.0), colour)


def _facing(place: Vector3, direction: Vector3) -> PoseMatrix:
    """(4, 4) with z along a direction."""
    z = direction / np.linalg.norm(direction)
    aside = np.eye(3)[int(np.abs(z).argmin())]
    x = aside - (aside @ z) * z
    x = x / np.linalg.norm(x)
    T = np.eye(4)
    T[:3, 0], T[:3, 1], T[:3, 2], T[:3, 3] = x, np.cross(z, x), z, place
    return T


def doors(run: Run, moments: Floats, tips: PoseMatrix) -> list[tuple[Body, Floats]]:
    """Each door with its pose (frames, 4, 4): shut, then with its handle in the hand, then where it was let go.

    Args:
        run: what happened.
        moments: (frames,) times [s].
        tips: (frames, 4, 4) poses of the tip then.
    """
    found: list[tuple[Body, Floats]] = []
    for grip in grips(run.job, run.plan):
        door = grip.door
        arm = door.handle[:3, 3] - door.hinge
        out = arm - (arm @ door.axis) * door.axis
        width = float(np.linalg.norm(out))
        T = np.eye(4)
        T[:3, 0], T[:3, 2] = out / width, door.axis
        T[:3, 1] = np.cross(door.axis, T[:3, 0])
        angle = np.where(moments >= grip.start, door.angle(tips), 0.0)
        held = np.flatnonzero(moments <= grip.end)
        angle[moments > grip.end] = angle[held[-1]] if len(held) else 0.0
        turned = np.tile(np.eye(4), (len(tips), 1, 1))
        turned[:, :3, :3] = rotation.exp(angle[:, None] * door.axis) @ T[:3, :3]
        turned[:, :3, 3] = door.hinge + (arm @ door.axis) * door.axis
        centre = (width / 2.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
        panel = Solid("box", (width, PANEL_THICKNESS * width, PANEL_HEIGHT * width), centre, DOOR_COLOUR)
        found.append((Body(grip.table.name, (panel,)), turned))
    return found
