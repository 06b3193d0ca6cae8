"""The slider-crank: both assembly modes, rates, and where it dies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, positive, real_array
from mafsil.mobility.four_bar import require_reached
from mafsil.mobility.linkage import Linkage
from mafsil.mobility.linkage_joint import joint
from mafsil.mobility.planar_positions import numbers_or_nan
from mafsil.mobility.tolerances import TOUCHING


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
        object.__setattr__(self, "offset", float(real_array("offset", self.offset)))

    def positions(self, theta: ArrayLike) -> Floats:
        """(*batch, 2) place x of the block in both modes, the farther one first [m]; NaN where length is `missing`.

        x = r cos theta +- sqrt(l^2 - (r sin theta - e)^2)
        """
        angle = numbers_or_nan("theta", theta)
        rise = self.crank * np.sin(angle) - self.offset
        square: Floats = (self.rod - rise) * (self.rod + rise)
        touching = TOUCHING * max(self.rod, self.crank) ** 2
        with np.errstate(invalid="ignore"):
            half = np.sqrt(np.where(square > -touching, np.maximum(square, 0.0), square))
        middle = self.crank * np.cos(angle)
        return np.stack([middle + half, middle - half], axis=-1)

    def missing(self, theta: ArrayLike) -> Floats:
        """(*batch,) length by which the rod is too short to reach the line of the block; zero where it does [m]."""
        return np.maximum(np.abs(self.crank * np.sin(numbers_or_nan("theta", theta)) - self.offset) - self.rod, 0.0)

    def rod_angles(self, theta: ArrayLike) -> Floats:
        """(*batch, 2) direction of the rod from crank pin to block, in both modes, in (-pi, pi] [rad]."""
        angle = numbers_or_nan("theta", theta)
        along = self.positions(angle) - (self.crank * np.cos(angle))[..., None]
        drop = (self.offset - self.crank * np.sin(angle))[..., None]
        return np.arctan2(np.broadcast_to(drop, along.shape), along)

    def rates(self, theta: ArrayLike) -> Floats:
        """(*batch, 2) dx/dtheta in both modes [m/rad]: r (tan(rod angle) cos theta - sin theta)."""
        angle = numbers_or_nan("theta", theta)[..., None]
        slope = np.tan(self.rod_angles(theta))
        return self.crank * (slope * np.cos(angle) - np.sin(angle))

    @property
    def full_turn(self) -> bool:
        """Whether the crank goes round: r + |e| <= l."""
        return self.crank + abs(self.offset) <= self.rod

    def linkage(self, theta: float = 0.7, mode: int = 0, merged: bool = False) -> Linkage:
        """The linkage drawn at an angle of the crank [rad]; merged: rod pin and block as one joint of two freedoms.

        Raises:
            InputError: the rod does not reach the line there.
        """
        x = float(self.positions(theta)[mode])
        require_reached(float(self.missing(theta)), float(theta))
        pin, block = self.crank * np.array([np.cos(theta), np.sin(theta)]), [x, self.offset]
        joints = [joint("A", "R", ["ground", "crank"], [0, 0], actuated=True), joint("B", "R", ["crank", "rod"], pin)]
        if merged:
            joints.append(joint("C", "pin_in_slot", ["ground", "rod"], block, second=[1, 0]))
        else:
            joints += [joint("C", "R", ["rod", "block"], block), joint("D", "P", ["ground", "block"], block, [1, 0])]
        return Linkage.of(joints, name="slider-crank", planar=True, output="rod" if merged else "block")
