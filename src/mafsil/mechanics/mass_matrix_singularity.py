"""Whether a mass matrix is singular at a position, and which motion of the joints moves no inertia there.

A mass matrix is positive definite only where every motion of the joints moves mass: point masses in line with an axis,
massless links or coaxial wrists break it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, JointVector, frozen
from mafsil.errors import ModelError
from mafsil.mechanics.tolerances import INVOLVED, SINGULAR


@dataclass(frozen=True, eq=False, slots=True)
class MassMatrixSingularity:
    """What is known about the inverse of one mass matrix.

    Attributes:
        margin: smallest eigenvalue after scaling to a unit diagonal: 1 for independent joints, 0 for singular.
        motion: (n,) the rates, largest 1, that move the least inertia.
        joints: names of the joints that take part in it.
        energy: kinetic energy of that motion [J].
    """

    margin: float
    motion: JointVector
    joints: tuple[str, ...]
    energy: float

    @property
    def singular(self) -> bool:
        """Efforts do not determine accelerations."""
        return self.margin < SINGULAR

    def require_regular(self) -> None:
        """Nothing, if the mass matrix can be inverted.

        Raises:
            ModelError: names the joints and their motion.
        """
        if self.singular:
            rates = zip(self.joints, self.motion[self.motion != 0], strict=True)
            motion = ", ".join(f"{name}: {rate:.6g}" for name, rate in rates)
            raise ModelError("dynamics.degenerate", motion=motion)


def mass_matrix_singularity(M: Floats, names: Sequence[str]) -> MassMatrixSingularity:
    """The report on a mass matrix.

    Args:
        M: (n, n) mass matrix.
        names: of the joints.
    """
    size = np.sqrt(np.maximum(np.diag(M), 0.0))
    still = size <= np.sqrt(SINGULAR) * 1e-3 * size.max(initial=0.0)
    if still.any():
        motion, margin = np.zeros(len(M)), 0.0
        motion[int(np.argmax(still))] = 1.0
    else:
        values, vectors = np.linalg.eigh(M / np.outer(size, size))
        motion, margin = vectors[:, 0] / size, max(float(values[0]), 0.0)
        motion = motion / motion[np.abs(motion).argmax()]
    motion = np.where(np.abs(motion) < INVOLVED, 0.0, motion)
    joints = tuple(name for name, rate in zip(names, motion, strict=True) if rate)
    return MassMatrixSingularity(margin, frozen(motion), joints, float(motion @ M @ motion / 2))
