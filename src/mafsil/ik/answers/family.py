"""Continua of solutions: which joints may be chosen, which follow, and the members at chosen values."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from mafsil.arrays import JointVector


@dataclass(frozen=True, eq=False)
class SolutionFamily:
    """A continuum of solutions.

    Attributes:
        solution: index of the member in the solution set.
        joint: name of the joint that may be chosen.
        moving: names of the joints that move within the family.
        rates: (n,) their rates along the family at the member, that of `joint` one [rad | m per rad | m].
        joints: names of all joints that may be chosen at this solution, `joint` among them; more than one where
            several families cross.
        within: the intervals of `joint` in which the branch is within the limits; see `intervals`.
        follow: solution (n,) with joints at values, by name; NaN where the family does not go so far.
    """

    solution: int
    joint: str
    moving: tuple[str, ...]
    rates: JointVector
    joints: tuple[str, ...]
    follow: Callable[[Mapping[str, float]], JointVector]
    within: Callable[[], tuple[tuple[float, float], ...]] = tuple

    @property
    def intervals(self) -> tuple[tuple[float, float], ...]:
        """Ends of the intervals of `joint` in which the branch of the member is within the joint limits [rad | m].

        Proven but for gaps of 1e-9; known where the arm has an exact closed form once this joint is locked, else empty.
        """
        return self.within()

    def at(self, value: float, **others: float) -> JointVector:
        """(n,) the member with the joint at a value; NaN where the family does not go so far.

        Args:
            value: of `joint` [rad | m].
            others: values of further joints among `joints`, by name.
        """
        return self.follow({self.joint: value, **others})

    def sample(self, values: JointVector) -> JointVector:
        """(k, n) members at many values of the joint.

        Args:
            values: (k,) [rad | m].
        """
        return np.array([self.at(float(value)) for value in values]).reshape(len(values), len(self.rates))

    def relation(self) -> str:
        """How the joints move together near the member, such as `joint4: +1, joint6: -1`."""
        others = [(name, rate) for name, rate in zip(self.moving, self.rates[self.rates != 0.0], strict=True)]
        return ", ".join(f"{name}: {rate:+.6g}" for name, rate in others)
