"""The slider-crank: both assembly modes, rates, and where it dies."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, number, positive, radians
from mafsil.mobility.four_bar import least_positive, require_reached
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.linkages.linkage_joint import joint
from mafsil.mobility.spaces.planar_positions import finite_numbers, wrap_angle
from mafsil.mobility.tolerances import TOUCHING


class SliderStatus(Status):
    """Whether the rod reaches the line of the block at the given inputs."""

    ALL = ("mobility.slider_all", True)
    SOME = ("mobility.slider_some", True)
    NONE = ("mobility.slider_none", False)
    NEVER = ("mobility.slider_never", False)


@dataclass(frozen=True, eq=False, repr=False)
class SliderCrankPositions(Answer, data="theta x rod_angles missing beyond"):
    """Both assembly modes at angles of the crank; true if some input can be reached, iterable over the modes.

    Attributes:
        theta: (*batch,) angles of the crank of these positions: the input, or the dead point nearest to it if the rod
            does not reach the line [rad].
        x: (*batch, 2) place of the block, the farther one first [m].
        rod_angles: (*batch, 2) direction of the rod from crank pin to block, in (-pi, pi] [rad].
        missing: (*batch,) length by which the rod is too short to reach the line of the block at the input; zero where
            it does [m].
        beyond: (*batch,) angle of the input beyond the dead point that is given; zero where the rod reaches, and where
            it does at no angle: then crank and rod stand across the line, with a gap [rad].
    """

    theta: Floats
    x: Floats
    rod_angles: Floats
    missing: Floats
    beyond: Floats

    @property
    def reachable(self) -> Booleans:
        """(*batch,) whether the rod reaches the line at the input."""
        return np.asarray(self.missing == 0.0, dtype=np.bool_)

    @property
    def status(self) -> SliderStatus:
        """By how many inputs are reached."""
        if self.reachable.all():
            return SliderStatus.ALL
        if self.reachable.any():
            return SliderStatus.SOME
        return SliderStatus.NONE if self.beyond.any() else SliderStatus.NEVER

    def __len__(self) -> int:
        return 2

    def __iter__(self) -> Iterator[Floats]:
        return iter((self.x[..., 0], self.x[..., 1]))

    def explain(self, language: str | None = None) -> str:
        """How many inputs are reached, and what the others lack."""
        return self.status.sentence(
            language, reached=int(self.reachable.sum()), count=self.reachable.size,
            missing=least_positive(self.missing), beyond=least_positive(self.beyond),
        )  # fmt: skip


@dataclass(frozen=True)
class SliderCrank:
    """A crank at the origin, a rod, and a block on the line y = offset.

    Attributes:
        crank, rod: lengths [m].
        offset: of the line on which the block moves [m].
    """

    crank: float
    rod: float
    offset: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "crank", positive("crank", self.crank))
        object.__setattr__(self, "rod", positive("rod", self.rod))
        object.__setattr__(self, "offset", number("offset", self.offset))

    def positions(self, theta: ArrayLike) -> SliderCrankPositions:
        """Both assembly modes at angles of the crank (*batch,) [rad], the block farther out first.

        x = r cos theta +- sqrt(l^2 - (r sin theta - e)^2)
        """
        angle = radians("theta", finite_numbers("theta", theta))
        rise = self.crank * np.sin(angle) - self.offset
        reaches = (self.rod - rise) * (self.rod + rise) > -TOUCHING * max(self.rod, self.crank) ** 2
        missing = np.where(reaches, 0.0, np.abs(rise) - self.rod)
        # The dead point has sin theta = (e +- l) / r; of its two angles the nearer one.
        first = np.arcsin(np.clip((self.offset + np.copysign(self.rod, rise)) / self.crank, -1.0, 1.0))
        near, far = wrap_angle(first - angle), wrap_angle(np.pi - first - angle)
        shift = np.where(reaches, 0.0, np.where(np.abs(near) <= np.abs(far), near, far))
        closes = abs(self.offset) <= self.crank + self.rod * (1.0 + TOUCHING)
        crank = angle + shift
        rise = self.crank * np.sin(crank) - self.offset
        square = np.where(reaches, np.maximum((self.rod - rise) * (self.rod + rise), 0.0), 0.0)
        along = np.stack([np.sqrt(square), -np.sqrt(square)], axis=-1)
        rod_angles = np.arctan2(np.broadcast_to(-rise[..., None], along.shape), along)
        x = (self.crank * np.cos(crank))[..., None] + along
        return SliderCrankPositions(crank, x, rod_angles, missing, np.abs(shift) if closes else 0.0 * shift)

    def rates(self, theta: ArrayLike) -> Floats:
        """(*batch, 2) dx/dtheta in both modes [m/rad]: r (tan(rod angle) cos theta - sin theta).

        At dead points, and for inputs beyond them, the block moves while the crank stands: infinite, with the sign that
        it has when the crank comes from where the rod reaches. Where the crank passes with its rod across the line the
        modes cross: rates when the crank goes on; zeros where it cannot.
        """
        found = self.positions(theta)
        angle = found.theta[..., None]
        sine, cosine, modes = np.sin(angle), np.cos(angle), np.array([1.0, -1.0])
        across = np.abs(np.cos(found.rod_angles)) <= np.sqrt(TOUCHING)
        slope = np.tan(np.where(across, 0.0, found.rod_angles))
        regular = self.crank * (slope * cosine - sine)
        rise = self.crank * sine - self.offset
        # Near such an angle the block is at r cos theta +- sqrt(r l (sin theta sign(rise))) times the step.
        bend = self.crank * self.rod * sine * np.sign(rise)
        passing = np.where(bend > 0.0, modes * np.sqrt(np.maximum(bend, 0.0)) - self.crank * sine, 0.0)
        dead = np.copysign(np.inf, -modes * rise * cosine)
        return np.where(across, np.where(np.abs(cosine) <= np.sqrt(TOUCHING), passing, dead), regular)

    @property
    def full_turn(self) -> bool:
        """Whether the crank goes round: r + |e| <= l."""
        return self.crank + abs(self.offset) <= self.rod

    def linkage(self, theta: float = 0.7, mode: int = 0, merged: bool = False) -> Linkage:
        """The linkage drawn at an angle of the crank [rad]; merged: rod pin and block as one joint of two freedoms.

        Raises:
            InputError: the rod does not reach the line there.
        """
        found = self.positions(theta)
        require_reached(float(found.missing), float(theta))
        x = float(found.x[mode])
        pin, block = self.crank * np.array([np.cos(theta), np.sin(theta)]), [x, self.offset]
        joints = [joint("A", "R", ["ground", "crank"], [0, 0], actuated=True), joint("B", "R", ["crank", "rod"], pin)]
        if merged:
            joints.append(joint("C", "pin_in_slot", ["ground", "rod"], block, second=[1, 0]))
        else:
            joints += [joint("C", "R", ["rod", "block"], block), joint("D", "P", ["ground", "block"], block, [1, 0])]
        return Linkage.of(joints, name="slider-crank", planar=True, output="rod" if merged else "block")
