"""What the tip of a job touches: tables of the file as environments, and the faces of surfaces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, Vector3
from mafsil.control.contact import AtPoints, Door, Hole, RoundSurface, guiding_line, guiding_plane
from mafsil.control.contact.environment import CombinedEnvironment, Environment, Wall
from mafsil.job import contact_tables as tables
from mafsil.job.description import Job
from mafsil.simulation import RigidSurface


def environment_of(job: Job, doors: tuple[Door, ...] = ()) -> CombinedEnvironment | None:
    """What acts on the tip of a job: all that it can touch and all that holds it; None of a job without any.

    Args:
        job: with its tables.
        doors: whose handles the tip holds.
    """
    parts: list[Environment] = [solid(one) for one in job.surface if not one.rigid]
    parts += [_hole(one) for one in job.hole]
    parts += doors
    parts += [_guide(one) for one in job.guide]
    return CombinedEnvironment(tuple(parts)) if parts else None


def solid(one: tables.Surface) -> Wall | RoundSurface:
    """A surface that gives way as what pushes the tip."""
    assert one.stiffness is not None
    point, constants = np.array(one.point), (one.stiffness, one.damping, one.friction)
    if one.normal is not None:
        return Wall(point, np.array(one.normal), *constants)
    radius = one.sphere if one.sphere is not None else one.cylinder
    assert radius is not None
    axis = None if one.axis is None else np.array(one.axis)
    return RoundSurface(point, radius, *constants, axis=axis, hollow=one.hollow)


def rigid_surfaces_of(job: Job) -> tuple[RigidSurface, ...]:
    """The surfaces of a job that do not give way, in the order of its file."""
    return tuple(shape_of(one) for one in job.surface if one.rigid)


def shape_of(one: tables.Surface) -> RigidSurface:
    """Where a surface is, as if it did not give way."""
    radius = one.sphere if one.sphere is not None else one.cylinder
    normal, axis = (None if given is None else np.array(given) for given in (one.normal, one.axis))
    return RigidSurface(np.array(one.point), one.restitution or 0.0, normal, radius, axis, one.hollow, one.friction)


def _hole(one: tables.Hole) -> Environment:
    hole = Hole(
        np.array(one.mouth), np.array(one.axis), one.clearance, one.depth, one.chamfer, one.stiffness, one.damping,
        one.friction,
    )  # fmt: skip
    return AtPoints(hole, np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -one.peg]])) if one.peg else hole


def _guide(one: tables.Guide) -> Environment:
    if one.direction is not None:
        return guiding_line(one.point, one.direction, one.stiffness, one.damping)
    assert one.normal is not None
    return guiding_plane(one.point, one.normal, one.stiffness, one.damping)


@dataclass(frozen=True, eq=False, slots=True)
class Face:
    """The side of a surface that the tip touches, as constraint of a law.

    Attributes:
        surface: whose it is; where it is, whether it gives way or not.
        rows: coordinates of the task, as in `TaskCoordinates`.
    """

    surface: RigidSurface
    rows: tuple[int, ...]

    def normal(self, p: Vector3) -> Vector3:
        """(3,) out of the surface at a point (3,)."""
        return self.surface.outward(p)

    def depth(self, T: PoseMatrix) -> float:
        """How deep the tip is in it [m]."""
        return -float(self.surface.distance(T[:3, 3]))

    def along(self, T: PoseMatrix) -> Floats:
        """(m,) the normal at the tip in the coordinates of the task."""
        return np.concatenate([np.zeros(3), self.normal(T[:3, 3])])[list(self.rows)]

    def constraint(self, T: PoseMatrix, V: Floats) -> tuple[Floats, Floats]:
        """A (1, m) and dA/dt (1, m): along a round surface the normal turns as the tip moves."""
        whole = np.zeros(6)
        whole[list(self.rows)] = V
        rate = self.surface.outward_rate(T[:3, 3], whole[3:])
        return self.along(T)[None], np.concatenate([np.zeros(3), rate])[list(self.rows)][None]
