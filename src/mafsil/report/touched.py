"""What the tip touches in the replay: plates, balls, bars, rails and holes that stand, doors that turn with the tip.

Things that the job lays down where it describes nothing below them lie on thin trays, each on a post, so that nothing
hangs in the air; no planner and no check knows of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, Vector3
from mafsil.geometry import rotation
from mafsil.job import Job, Run
from mafsil.job.language.surrounding_tables import Guide, Hole, Surface
from mafsil.job.planning.stretch import grips
from mafsil.scene import Body, Solid
from mafsil.scene.drawing import Colour
from mafsil.scene.inline import near_side, patch, stretch

TRAY_COLOUR = (0.80, 0.80, 0.77, 1.0)
TRAY, RIM, POST = 6e-3, 0.03, 0.01
"""Thickness of a tray, what it has beside things, radius of its post, as shares of the scene."""
SEEN = 0.02
"""Height above the floor below which a thing lies on it, as share of the scene."""
SAME = 1e-3
"""Difference of heights at which things lie on one tray or on one another [m]."""
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


def shelves(
    lying: Iterable[tuple[Body, PoseMatrix]], others: Iterable[tuple[Body, PoseMatrix]], floor: float, size: float
) -> list[tuple[Body, PoseMatrix]]:
    """Trays below boxes that would hang in the air: one for all that lie side by side at one height.

    Args:
        lying: boxes where they lie, with their poses (4, 4).
        others: solids that stand around, with theirs; what reaches up to a box carries it.
        floor: its height [m].
        size: radius of the scene [m].
    """
    boxes = [_extent(body, T) for body, T in lying]
    carriers = [*boxes, *(_extent(body, T) for body, T in others)]
    trays: list[Floats] = []
    for box in boxes:
        low = box[0, 2]
        if low - floor < SEEN * size or any(_carries(other, box) for other in carriers):
            continue
        rim = RIM * size * np.array([1.0, 1.0, 0.0])
        tray, apart = np.stack([box[0] - rim, [*(box[1, :2] + rim[:2]), low]]), list[Floats]()
        for other in trays:
            if abs(other[0, 2] - low) < SAME and _overlap(other, tray):
                tray = np.stack([np.minimum(tray[0], other[0]), np.maximum(tray[1], other[1])])
            else:
                apart.append(other)
        trays = [*apart, tray]
    return [_drawn(tray, floor, size) for tray in trays]


def _extent(body: Body, T: PoseMatrix) -> Floats:
    """(2, 3) lowest and highest coordinates of solids that are not turned in their body."""
    corners = np.concatenate([_corners(solid) @ T[:3, :3].T + T[:3, 3] for solid in body.solids])
    return np.stack([corners.min(axis=0), corners.max(axis=0)])


def _corners(solid: Solid) -> Floats:
    if solid.surface is not None:
        return solid.surface.vertices
    half = np.array(_edges(solid.kind, solid.size)) / 2.0
    signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, 8).T
    return signs * half + np.array(solid.pose[:3])


def _edges(kind: str, size: Sequence[float]) -> Sequence[float]:
    """Edges of the box around a solid."""
    width = 2.0 * size[0]
    if kind == "box":
        return size
    return (width, width, width if kind == "sphere" else size[1] + (width if kind == "capsule" else 0.0))


def _overlap(a: Floats, b: Floats) -> bool:
    """Whether two extents lie over one another, seen from above."""
    return bool((a[0, :2] < b[1, :2]).all() and (b[0, :2] < a[1, :2]).all())


def _carries(other: Floats, box: Floats) -> bool:
    """Whether something reaches from below to the underside of a box, or around it."""
    low = box[0, 2]
    return bool(other[0, 2] < low - SAME and other[1, 2] > low - SAME and _overlap(other, box))


def _drawn(tray: Floats, floor: float, size: float) -> tuple[Body, PoseMatrix]:
    """A tray whose upper side is as wide as said, and its post down to the floor."""
    (x, y, top), (width, depth, _) = tray.mean(axis=0).tolist(), (tray[1] - tray[0]).tolist()
    T, height = np.eye(4), top - floor
    T[:3, 3] = x, y, top
    plate = Solid("box", (width, depth, TRAY * size), (0.0, 0.0, -TRAY * size / 2.0, 1.0, 0.0, 0.0, 0.0), TRAY_COLOUR)
    post = Solid("cylinder", (POST * size, height), (0.0, 0.0, -height / 2.0, 1.0, 0.0, 0.0, 0.0), TRAY_COLOUR)
    return Body("shelf", (plate, post)), T
