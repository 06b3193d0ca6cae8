"""The one place that says against what an error is relative: a robot's own sizes, never a number that may be small.

Prismatic coordinates are counted in units of reach, so that all joints and all rows of Jacobians have one unit. Then
poses compare with 1, efforts with weight x reach, the mass matrix with mass x reach^2. Where the quantity itself is
larger than that (fast motion, long chains), its largest entry of the state counts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.model import Mechanism
from mafsil.verification.sizes import Sizes

STANDARD_FALL = 9.81


@dataclass(frozen=True, eq=False)
class NaturalScale:
    """Sizes of a robot: reach [m], mass [kg] and the unit of each coordinate, 1 or `reach`."""

    reach: float
    mass: float
    unit: Floats

    @property
    def weight_times_reach(self) -> float:
        return self.mass * STANDARD_FALL * self.reach

    def dimensionless(self, quantity: str, values: Floats) -> Floats:
        """Values (N, ...) of a quantity divided by its natural scale, entry by entry."""
        u, L = self.unit, self.reach
        rows = np.array([1.0, 1.0, 1.0, 1 / L, 1 / L, 1 / L])[:, None]
        inertia, effort = self.mass * L * L, self.weight_times_reach
        match quantity.split()[0]:
            case "forward_kinematics" | "link_poses":
                size = np.ones((4, 4))
                size[:3, 3] = 1 / L
                return values * size
            case "jacobian_space" | "jacobian_body" | "jacobian_space_rate" | "jacobian_body_rate":
                return values * rows * u
            case "mass_matrix" | "coriolis_matrix":
                return values * u[:, None] * u / inertia
            case "kinetic_energy" | "potential_energy":
                return values / effort
            case "forward_dynamics":
                return values / u
            case _:
                return values * u / effort

    def error(self, quantity: str, ours: Floats, reference: Floats, mass_matrix: Floats | None = None) -> Floats:
        """(N,) largest error of each state, relative to the natural scale or the state's largest entry.

        With the mass matrix, each acceleration compares with the one that efforts of natural size may produce there,
        |M^-1| (|M| |qdd| + weight x reach): what a relative error of one in the robot's numbers would change (Skeel).
        """
        if quantity.startswith("forward_dynamics") and mass_matrix is not None:
            driving = (
                np.einsum("kij,kj->ki", np.abs(mass_matrix), np.abs(reference)) + self.weight_times_reach / self.unit
            )
            size = np.einsum("kij,kj->ki", np.abs(np.linalg.inv(mass_matrix)), driving)
            return np.nan_to_num(np.abs(ours - reference) / size, nan=np.inf).max(axis=1, initial=0.0)
        return self._relative(quantity, ours - reference, reference)

    def _relative(self, quantity: str, gap: Floats, size: Floats) -> Floats:
        a, b = self.dimensionless(quantity, gap), self.dimensionless(quantity, size)
        if not a.size:
            return np.zeros(len(a))
        core = tuple(range(1, a.ndim))
        worst = np.abs(a).max(axis=core, initial=0.0)
        return np.where(np.isfinite(worst), worst, np.inf) / np.maximum(1.0, np.abs(b).max(axis=core, initial=0.0))


def natural_scale(mechanism: Mechanism) -> NaturalScale:
    """Reach: the longest way from {s} along the links to a centre of mass, frame or tip, slides at 0.5 m."""
    sizes = Sizes.of(mechanism)
    return NaturalScale(sizes.reach, sizes.mass, sizes.unit)
