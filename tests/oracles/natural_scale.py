"""The one place that says against what an error is relative: a robot's own sizes, never a number that may be small.

Every quantity's row knows its natural size. Where the quantity itself is larger than that (fast motion, long chains),
its largest entry of the state counts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.mechanics.arm_size import ArmSize
from mafsil.mechanics.catalogue import quantity as row_of
from mafsil.model import Mechanism


@dataclass(frozen=True, eq=False)
class NaturalScale:
    """Of one robot."""

    size: ArmSize

    @property
    def unit(self) -> Floats:
        return self.size.unit

    def dimensionless(self, quantity: str, values: Floats) -> Floats:
        """Values (N, ...) of a quantity divided by its natural size, entry by entry."""
        return values / row_of(quantity.split()[0]).size(self.size)

    def error(self, quantity: str, ours: Floats, reference: Floats, mass_matrix: Floats | None = None) -> Floats:
        """(N,) largest error of each state, relative to the natural size or the state's largest entry.

        With the mass matrix, each acceleration compares with the one that efforts of natural size may produce there,
        |M^-1| (|M| |qdd| + weight x L / unit): what a relative error of one in the numbers would change (Skeel).
        """
        if quantity.startswith("forward_dynamics") and mass_matrix is not None:
            driving = np.einsum("kij,kj->ki", np.abs(mass_matrix), np.abs(reference)) + self.size.effort
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
    """Of a robot, by its length and mass."""
    return NaturalScale(ArmSize.of(mechanism))
