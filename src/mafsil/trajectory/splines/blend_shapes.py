"""Shapes of a blend between two straight lines, as rows of one table: parabola and quintic."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.trajectory.tolerances import ROUNDING

BlendName: TypeAlias = Literal["parabolic", "quintic"]


@dataclass(frozen=True)
class BlendShape:
    """How the speed changes from v to v + dv in a blend of duration b around a corner at u_k.

    u = u_k - v b/2 + b (v s + dv g(s)),  s from 0 to 1 in the blend.

    Attributes:
        coefficients: of g in ascending powers: g(0) = g'(0) = 0, g(1) = 1/2, g'(1) = 1.

    Raises:
        InputError: g does not lead from one line to the other.
    """

    coefficients: tuple[float, ...]

    def __post_init__(self) -> None:
        ends = [self._at(s, order) for order in (0, 1) for s in (0.0, 1.0)]
        if not np.allclose(ends, [0.0, 0.5, 0.0, 1.0], rtol=0.0, atol=1e-14):
            raise InputError("trajectory.blend_ends", coefficients=self.coefficients)

    def g(self, s: Floats, order: int) -> Floats:
        """A derivative of g by s.

        Args:
            s: share of the blend that has passed.
            order: 0 for g itself.
        """
        value = np.zeros_like(s)
        for c in np.polynomial.polynomial.polyder(np.array(self.coefficients), order)[::-1].tolist():
            value = value * s + c
        return value

    @cached_property
    def peak(self) -> float:
        """Peak acceleration over the mean one, dv/b: largest g''."""
        third = np.polynomial.polynomial.polyder(np.array(self.coefficients), 3)
        bends: NDArray[np.complex128] = np.asarray(np.polynomial.polynomial.polyroots(third), dtype=np.complex128)
        inside = [float(s) for s in bends.real[np.abs(bends.imag) < ROUNDING] if 0.0 < s < 1.0]
        return max(abs(self._at(s, 2)) for s in (0.0, *inside, 1.0))

    @property
    def miss(self) -> float:
        """Distance from the corner to the middle of the blend, as share of dv b."""
        return self._at(0.5, 0)

    def _at(self, s: float, order: int) -> float:
        return float(self.g(np.array(s), order))


BLENDS: dict[BlendName, BlendShape] = {
    "parabolic": BlendShape((0.0, 0.0, 0.5)),
    "quintic": BlendShape((0.0, 0.0, 0.0, 1.0, -0.5)),
}
"""All shapes by name. The quintic has no acceleration at its ends; its coefficient of the fifth power vanishes."""


def blend_shape(name: BlendName) -> BlendShape:
    """The shape of that name.

    Raises:
        InputError: there is none; the sentence lists those that are.
    """
    if name not in BLENDS:
        raise InputError("input.choice", name="blend", value=name, known=", ".join(BLENDS))
    return BLENDS[name]
