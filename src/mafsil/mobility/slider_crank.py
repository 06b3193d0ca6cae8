"""The slider-crank: both assembly modes, rates, and where it dies."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, positive, real_array
from mafsil.messages.tables import on_screen
from mafsil.mobility.four_bar import require_reached
from mafsil.mobility.linkage import Linkage
from mafsil.mobility.linkage_joint import joint
from mafsil.mobility.planar_positions import numbers_or_nan
from mafsil.mobility.tolerances import TOUCHING


class SliderStatus(Status):
    """Whether the rod reaches the line of the block at the given inputs."""

    ALL = ("mobility.slider_all", True)
    SOME = ("mobility.slider_some", True)
    NONE = ("mobility.slider_none", False)


@dataclass(frozen=True, eq=False, repr=False)
class SliderCrankPositions(Answer):
    """Both assembly modes at angles of the crank; true if some input can be reached, iterable over the modes.

    Attributes:
        x: (*batch, 2) place of the block, the farther one first; NaN where the rod does not reach [m].
        rod_angles: (*batch, 2) direction of the rod from crank pin to block, in (-pi, pi] [rad].
        missing: (*batch,) length by which the rod is too short to reach the line of the block; zero where it does [m].
    """

    x: Floats
    rod_angles: Floats
    missing: Floats

    @property
    def reachable(self) -> Booleans:
        """(*batch,) whether the rod reaches there."""
        return np.asarray(np.isfinite(self.x).all(axis=-1), dtype=np.bool_)

    @property
    def status(self) -> SliderStatus:
        """By how many inputs are reached."""
        if self.reachable.all():
            return SliderStatus.ALL
        return SliderStatus.SOME if self.reachable.any() else SliderStatus.NONE

    def __bool__(self) -> bool:
        return self.status.succeeded

    def __len__(self) -> int:
        return 2

    def __iter__(self) -> Iterator[Floats]:
        return iter((self.x[..., 0], self.x[..., 1]))

    def __repr__(self) -> str:
        return on_screen(self.explain())

    def explain(self, language: str | None = None) -> str:
        """How many inputs are reached, and what the others lack."""
        return self.status.sentence(
            language, reached=int(self.reachable.sum()), count=self.reachable.size,
            missing=float(np.min(self.missing[self.missing > 0.0], initial=np.inf)),
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "status": self.status.name.lower(), "x": self.x, "rod_angles": self.rod_angles, "missing": self.missing
        }  # fmt: skip


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

    def positions(self, theta: ArrayLike) -> SliderCrankPositions:
        """Both assembly modes at angles of the crank (*batch,) [rad], the block farther out first.

        x = r cos theta +- sqrt(l^2 - (r sin theta - e)^2)
        """
        angle = numbers_or_nan("theta", theta)
        rise = self.crank * np.sin(angle) - self.offset
        square: Floats = (self.rod - rise) * (self.rod + rise)
        touching = TOUCHING * max(self.rod, self.crank) ** 2
        with np.errstate(invalid="ignore"):
            half = np.sqrt(np.where(square > -touching, np.maximum(square, 0.0), square))
        along = np.stack([half, -half], axis=-1)
        rod_angles = np.arctan2(np.broadcast_to(-rise[..., None], along.shape), along)
        missing = np.where(square > -touching, 0.0, np.abs(rise) - self.rod)
        return SliderCrankPositions((self.crank * np.cos(angle))[..., None] + along, rod_angles, missing)

    def rates(self, theta: ArrayLike) -> Floats:
        """(*batch, 2) dx/dtheta in both modes [m/rad]: r (tan(rod angle) cos theta - sin theta); NaN out of reach."""
        angle = numbers_or_nan("theta", theta)[..., None]
        slope = np.tan(self.positions(theta).rod_angles)
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
