"""Names of branches: which side of the shoulder, elbow up or down, wrist flipped or not; and solutions printed by them.

What the names mean stands in `mafsil.mechanics.arm_sides`: they are read off the joints of a configuration, however it
was found.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.ik.chain import Chain
from mafsil.ik.result import STATUSES
from mafsil.kernels.lazy import lazy
from mafsil.lazy_module import lazily
from mafsil.mechanics.arm_pattern import ArmPattern, FailedStep, Family
from mafsil.messages import say
from mafsil.messages.tables import COLUMNS, MOST_ROWS, table

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


BESIDE = 46
"""Columns that number, branch, residual and limits take at most."""
COORDINATE = 8
"""Columns of a coordinate with the space before it: three decimals."""
MOST_COORDINATES = (COLUMNS - BESIDE) // COORDINATE + 1
"""Beyond these a row does not fit a screen: the last is then left out for a mark."""
ELLIPSIS = "\N{HORIZONTAL ELLIPSIS}"


def solution_table(
    q: JointVector,
    branches: Sequence[Branch],
    residual: Floats,
    within: NDArray[np.bool_],
    revolute: NDArray[np.bool_],
    language: str | None = None,
    *,
    degrees: bool = False,
) -> list[str]:
    """Lines: number, branch, coordinates, residual, and whether the limits are kept, of each solution.

    Args:
        q: (k, n) solutions of one pose.
        branches: of each.
        residual, within: (k,) of each.
        revolute: (n,) which coordinates are angles.
        language: `en` or `ar`; the current one if None.
        degrees: angles in degrees.
    """
    n = q.shape[-1]
    shown = n if n <= MOST_COORDINATES else MOST_COORDINATES - 1
    cut = [ELLIPSIS] if shown < n else []
    scale, units = angle_units(revolute[:shown], degrees=degrees)
    head = ["#", _column("branch", language), *(f"q{i} {unit}" for i, unit in enumerate(units, 1)), *cut]
    rows = [
        [
            str(k + 1),
            str(branches[k]),
            *(f"{x + 0.0:.3f}" for x in q[k, :shown] * scale),
            *cut,
            f"{residual[k]:.0e}",
            say("ik.inside" if within[k] else "ik.outside", language=language),
        ]
        for k in range(min(len(q), MOST_ROWS))
    ]
    # Rows beyond the last that is printed are counted only.
    rows += [[]] * (len(q) - len(rows))
    return table([*head, _column("residual", language), _column("limits", language)], rows, language) if rows else []


def angle_units(revolute: NDArray[np.bool_], *, degrees: bool) -> tuple[Floats, list[str]]:
    """(n,) the factor to what is printed, and its unit, of each coordinate.

    Args:
        revolute: (n,) which coordinates are angles.
        degrees: angles in degrees.
    """
    scale = np.where(revolute & degrees, 180.0 / np.pi, 1.0)
    return scale, [("deg" if degrees else "rad") if turns else "m" for turns in revolute]


def pose_table(
    valid: NDArray[np.bool_],
    within: NDArray[np.bool_],
    residual: Floats,
    codes: NDArray[np.int8],
    language: str | None = None,
) -> list[str]:
    """Lines: index, number of solutions, of those within the limits, largest residual, status, of each pose.

    Args:
        valid, within, residual: (*batch, k) of the rows of each pose.
        codes: (*batch,) index into `STATUSES`.
        language: `en` or `ar`; the current one if None.
    """
    shape = codes.shape
    rows: list[list[str]] = []
    for flat in range(min(codes.size, MOST_ROWS)):
        at = np.unravel_index(flat, shape)
        off = f"{residual[at][valid[at]].max():.0e}" if valid[at].any() else "-"
        counts = str(int(valid[at].sum())), str(int(within[at].sum()))
        status = STATUSES[int(codes[at])].name.lower().replace("_", " ")
        rows.append([", ".join(str(int(i)) for i in at), *counts, off, status])
    rows += [[]] * (codes.size - len(rows))
    head = [_column(name, language) for name in ("pose", "solutions", "allowed", "residual", "status")]
    return table(head, rows, language) if rows else []


def _column(name: str, language: str | None) -> str:
    return say(f"ik.column_{name}", language=language)
