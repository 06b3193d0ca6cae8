"""Planar arms in the x-y plane: joint axes along z, gravity along -y as on the page of a book."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mafsil.arrays import frozen
from mafsil.model.denavit_hartenberg import DHRow, mechanism_from_dh
from mafsil.model.library.outline import with_slim_tubes
from mafsil.model.link import Inertial
from mafsil.model.mechanism import Mechanism, Provenance
from mafsil.model.placement import translation

PAGE_GRAVITY = (0.0, -9.81, 0.0)
SLIM = 0.02
"""Radius of the tubes that stand for the rods, as share of the longest one."""


def planar2r(lengths: Sequence[float] = (1.0, 1.0), masses: Sequence[float] = (1.0, 1.0)) -> Mechanism:
    """Planar 2R arm of uniform thin rods (Lynch & Park fig. 6.9; spec part 05-06).

    Args:
        lengths: (2,) of the links [m].
        masses: (2,) of the links [kg].
    """
    return _planar("planar2r", lengths, [_rod(m, L) for m, L in zip(masses, lengths, strict=True)], "uniform thin rods")


def planar3r(lengths: Sequence[float] = (1.0, 0.8, 0.5), masses: Sequence[float] = (1.0, 0.8, 0.5)) -> Mechanism:
    """Planar 3R arm of uniform thin rods.

    Args:
        lengths: (3,) of the links [m].
        masses: (3,) of the links [kg].
    """
    return _planar("planar3r", lengths, [_rod(m, L) for m, L in zip(masses, lengths, strict=True)], "uniform thin rods")


def planar2r_point_masses(lengths: Sequence[float] = (1.0, 1.0), masses: Sequence[float] = (1.0, 1.0)) -> Mechanism:
    """Planar 2R arm with all mass of a link in a point at its far end: the textbook example of dynamics.

    Args:
        lengths: (2,) of the links [m].
        masses: (2,) at the ends of the links [kg].

    Reference: Lynch & Park, Modern Robotics, sec. 8.1.1.
    """
    points = [Inertial(m, frozen([L, 0.0, 0.0])) for m, L in zip(masses, lengths, strict=True)]
    return _planar("planar2r_point_masses", lengths, points, "point masses at the far ends of the links")


def _planar(name: str, lengths: Sequence[float], inertials: Sequence[Inertial], masses: str) -> Mechanism:
    """Frame {i} at the near end of link i, x along the link."""
    before = (0.0, *lengths[:-1])
    bare = mechanism_from_dh(
        [DHRow(a=a) for a in before],
        "modified",
        name=name,
        tool=translation(lengths[-1], 0.0, 0.0),
        inertials=inertials,
        gravity=PAGE_GRAVITY,
        provenance=Provenance(
            source="textbook arm; lengths and masses are parameters",
            notes=(f"masses: {masses}", "gravity along -y of the space frame, 9.81 m/s^2", "no joint limits"),
        ),
    )
    return with_slim_tubes(bare, SLIM * max(lengths))


def _rod(mass: float, length: float) -> Inertial:
    """Uniform thin rod along x from the origin: no inertia about its own axis."""
    across = mass * length**2 / 12
    return Inertial(mass, frozen([length / 2, 0.0, 0.0]), frozen(np.diag([0.0, across, across])))
