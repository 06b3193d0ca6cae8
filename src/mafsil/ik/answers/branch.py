"""Names of branches: which side of the shoulder, elbow up or down, wrist flipped or not.

What the names mean stands in `mafsil.mechanics.arm_sides`: they are read off the joints of a configuration, however it
was found.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import JointVector
from mafsil.ik.chain import Chain
from mafsil.kernels.lazy import lazy
from mafsil.lazy_module import lazily
from mafsil.mechanics.arm_pattern import ArmPattern, FailedStep, Family
from mafsil.messages import say

if TYPE_CHECKING:
    import mafsil.ik.structure.sides as sides
    from mafsil.kernels import Kernel
    from mafsil.mechanics.arm_sides import ArmSides, Words
else:
    sides = lazily("mafsil.ik.structure.sides")

MERGED = "merged"
"""Where two branches are one."""

_SHOULDER = ("left", MERGED, "right")
_WRIST = ("flip", MERGED, "noflip")
_BEND = ("flip", "straight", "noflip")
_STEPS = tuple(FailedStep)


class Branch(NamedTuple):
    """Which of the solutions of its pose a solution is; empty where the arm has no such choice.

    Attributes:
        shoulder: `left`, `right`, or `merged` where both are one.
        elbow: `up`, `down`, `merged`, or `level` where both may still differ; `in`, `out` of a prismatic joint; of an
            arm without such a shape the sign of the determinant of the joints that place the wrist, `+` or `-`.
        wrist: `flip`, `noflip`, `merged`, or `straight` where both may still differ.
        root: letter of the row of the closed form, where the other names may be those of several solutions of a pose;
            it need not stay along a path.
    """

    shoulder: str = ""
    elbow: str = ""
    wrist: str = ""
    root: str = ""

    def __str__(self) -> str:
        return "/".join(part for part in self if part) or "-"

    def label(self, language: str | None = None) -> str:
        """The branch in words, such as `shoulder right, elbow up, wrist not flipped`."""
        words: list[str] = []
        for name, value in zip(self._fields, self, strict=True):
            if value in ("+", "-") or (value and name == "root"):
                words.append(say(f"ik.branch_{name}_sign", language=language, value=value))
            elif value:
                words.append(say(f"ik.branch_{name}_{value}", language=language))
        return say("ik.branch_joint", language=language).join(words) or say("ik.branch_only", language=language)


UNNAMED = 13
"""The code of a solution that is no row of the closed form, and so of no merged roots: 1 + 3 + 9."""

SIDES = 27
"""Numbers of branches: three signs."""


class BranchNames:
    """How the branches of an arm are called.

    Attributes:
        chain: of the arm, base first.
        pattern: of its closed form.
        kernel: of q (n,) to the number of the branch.
    """

    def __init__(self, chain: Chain, pattern: ArmPattern) -> None:
        self.chain, self.pattern = chain, pattern

    @lazy
    def kernel(self) -> Kernel:
        """Of q (n,) to the number of the branch."""
        return sides.branch_kernel(self._sides)

    @lazy
    def _sides(self) -> ArmSides:
        return sides.sides_of(self.chain, self.pattern)

    @lazy
    def _words(self) -> tuple[Words | None, Words | None, Words | None]:
        """Of shoulder, elbow and wrist, where the arm has them."""
        found = self._sides
        wrist = _BEND if self.pattern.reversed else _WRIST
        elbow = None if found.elbow is None else found.elbow.words
        return _SHOULDER if found.shoulder else None, elbow, wrist if found.wrist else None

    def numbers(self, q: JointVector) -> NDArray[np.int64]:
        """(*batch,) branches of configurations (*batch, n) as numbers."""
        return np.asarray(self.kernel(q), dtype=np.int64)

    def branch(self, number: int, row: int = -1) -> Branch:
        """A branch by its number.

        Args:
            number: of the branch.
            row: of the closed form's table; negative for a solution found otherwise.
        """
        shoulder, elbow, wrist = (
            "" if words is None else words[number // weight % 3]
            for words, weight in zip(self._words, (1, 3, 9), strict=True)
        )
        return Branch(shoulder, elbow, wrist, self._letter(row))

    def branches(self, q: JointVector, rows: NDArray[np.int64]) -> tuple[Branch, ...]:
        """The branches of (k, n) configurations that are rows of the closed form's table."""
        return tuple(self.branch(int(x), int(row)) for x, row in zip(self.numbers(q), rows, strict=True))

    def _letter(self, row: int) -> str:
        quartic, paired = self.pattern.quartic, self.pattern.family not in (Family.PLANAR, Family.POINT)
        if not 0 <= row < self.pattern.branches or not (quartic or not self._sides.exact):
            return ""
        return "abcdefgh"[row >> 1 if quartic and paired else row]


def failed_step(code: int) -> FailedStep:
    """The step that fails in a row."""
    return _STEPS[min(max(code // 27, 0), len(_STEPS) - 1)]
