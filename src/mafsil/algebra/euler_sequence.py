"""The 24 sequences of three coordinate axes, as data. Knows no expressions, so that reading a name costs nothing."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product


@dataclass(frozen=True)
class EulerSequence:
    """Three coordinate axes (0 = x, 1 = y, 2 = z) and whether they are carried by the body or stay fixed.

    Body axes i, j, k: R = Rot(i, a) Rot(j, b) Rot(k, c). Fixed axes i, j, k, in this order of turning:
    R = Rot(k, c) Rot(j, b) Rot(i, a).
    """

    axes: tuple[int, int, int]
    fixed: bool

    def __post_init__(self) -> None:
        i, j, k = self.axes
        if not {i, j, k} <= {0, 1, 2} or i == j or j == k:
            raise ValueError(self.axes)

    @property
    def name(self) -> str:
        """`ZYX` for body axes (capitals), `xyz` for fixed axes (small letters), as SciPy spells them."""
        letters = "".join("xyz"[axis] for axis in self.axes)
        return letters if self.fixed else letters.upper()

    @property
    def symmetric(self) -> bool:
        """First and third axis equal (proper Euler angles); gimbal lock at middle angle 0 and pi, else at +-pi/2."""
        return self.axes[0] == self.axes[2]

    @property
    def body_axes(self) -> tuple[int, int, int]:
        """The axes of the factors of R from left to right."""
        i, j, k = self.axes
        return (k, j, i) if self.fixed else (i, j, k)


SEQUENCES: dict[str, EulerSequence] = {
    sequence.name: sequence
    for sequence in (
        EulerSequence((i, j, k), fixed)
        for fixed in (False, True)
        for i, j, k in product(range(3), repeat=3)
        if i != j and j != k
    )
}
"""All 24: 12 of body axes (`ZYX`) and 12 of fixed axes (`xyz`)."""
