"""Where the tip of a planar arm can be: the annulus between two circles, and the class of a point of its plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, Vector3, as_batch, positive
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.ik.chain import chain_of, moving_part
from mafsil.ik.tolerances import DEFECT
from mafsil.messages import say
from mafsil.model.loading import RobotLike
from mafsil.robot import as_robot


class PlaceClass(Status):
    """Where a point lies, and whether the tip gets there without regard to joint limits."""

    OUTSIDE = ("ik.place_outside", False)
    OUTER_BOUNDARY = ("ik.place_outer_boundary", True)
    INTERIOR = ("ik.place_interior", True)
    INNER_BOUNDARY = ("ik.place_inner_boundary", True)
    HOLE = ("ik.place_hole", False)
    OFF_PLANE = ("ik.place_off_plane", False)


class ReachShape(Status):
    """What the places of the tip form."""

    DISC = ("ik.reach_disc", True)
    ANNULUS = ("ik.reach_annulus", True)


@dataclass(frozen=True, eq=False, repr=False)
class Place(Answer, data="distance inner outer"):
    """Where a point lies: true if the tip gets there without regard to joint limits.

    Attributes:
        status: the class of the point.
        distance: of the point from the centre [m].
        inner, outer: radii of the annulus [m].
    """

    status: PlaceClass
    distance: float
    inner: float
    outer: float

    def explain(self, language: str | None = None) -> str:
        """The class in a sentence with the distance and both radii."""
        lengths = {"distance": self.distance, "inner": self.inner, "outer": self.outer}
        words = {name: f"{x:.6g}" for name, x in lengths.items()}
        return self.status.sentence(language) + say("ik.place_annulus", language=language, **words)


@dataclass(frozen=True, eq=False, repr=False)
class PlanarReach(Answer, data="inner outer centre normal lengths"):
    """The annulus that the tip of an arm of parallel revolute axes can reach.

    Attributes:
        centre: (3,) where the first axis meets the tip's plane, in {s} [m].
        normal: (3,) unit direction of the axes, in {s}.
        lengths: (n,) of the links, as seen along the axes [m].
        inner, outer: radii [m]; for two links |L1 - L2| and L1 + L2. The inner one is zero where the other links
            together are as long as the longest.
    """

    centre: Vector3
    normal: Vector3
    lengths: Floats

    @property
    def outer(self) -> float:
        """The largest distance from the centre [m]: all links stretched."""
        return float(self.lengths.sum())

    @property
    def inner(self) -> float:
        """The least distance from the centre [m]: the longest link against all others."""
        return max(0.0, float(2 * self.lengths.max(initial=0.0) - self.lengths.sum()))

    @property
    def status(self) -> ReachShape:
        """A disc, or an annulus with a hole."""
        return ReachShape.ANNULUS if self.inner > 0.0 else ReachShape.DISC

    def explain(self, language: str | None = None) -> str:
        """The shape with its radii."""
        return self.status.sentence(language, inner=f"{self.inner:.6g}", outer=f"{self.outer:.6g}")

    def place(self, point: ArrayLike, tolerance: float = 1e-9) -> Place:
        """Where a point lies, and how far from the centre; arguments as `classify`."""
        away = as_batch("point", point, (3,), finite=True) - self.centre
        return Place(self.classify(point, tolerance), float(np.linalg.norm(away)), self.inner, self.outer)

    def classify(self, point: ArrayLike, tolerance: float = 1e-9) -> PlaceClass:
        """The class of a point; the centre of two equal links, reached in infinitely many ways, is an `INNER_BOUNDARY`.

        Args:
            point: (3,) in {s} [m].
            tolerance: distance from a circle, or from the plane, that counts as none, relative to the outer radius.

        Raises:
            InputError: a wrong shape, a tolerance that is not positive.
        """
        away = as_batch("point", point, (3,), finite=True) - self.centre
        margin = positive("tolerance", tolerance) * max(self.outer, LEAST_DIVISOR)
        if abs(float(away @ self.normal)) > margin:
            return PlaceClass.OFF_PLANE
        r = float(np.linalg.norm(away - (away @ self.normal) * self.normal))
        if abs(r - self.outer) <= margin:
            return PlaceClass.OUTER_BOUNDARY
        if r > self.outer:
            return PlaceClass.OUTSIDE
        closed = len(self.lengths) < 3 or self.inner > 0.0
        if closed and abs(r - self.inner) <= margin:
            return PlaceClass.INNER_BOUNDARY
        return PlaceClass.INTERIOR if r > self.inner or not closed else PlaceClass.HOLE


def planar_reach(robot: RobotLike) -> PlanarReach:
    """The annulus of an arm whose moving joints all turn about parallel axes.

    Args:
        robot: a Robot, a Mechanism, a name of the library or a file.

    Raises:
        InputError: another arm; the sentence says which joint is not so.

    Reference: Lynch and Park, Modern Robotics, sec. 6 (law of cosines of the 2R arm).
    """
    part = moving_part(as_robot(robot)).robot
    chain = chain_of(part.mechanism)
    if chain is None or not len(chain):
        raise InputError("ik.not_planar", joint=", ".join(part.joint_names))
    h = chain.axes[0]
    for name, w, prismatic in zip(part.joint_names, chain.axes, chain.prismatic, strict=True):
        if prismatic or float(np.linalg.norm(np.cross(h, w))) > DEFECT:
            raise InputError("ik.not_planar", joint=name)
    tip = chain.home[:3, 3]
    places = np.concatenate([chain.points, tip[None]])
    flat = places + ((tip - places) @ h)[:, None] * h
    return PlanarReach(flat[0], h, np.linalg.norm(np.diff(flat, axis=0), axis=1))
