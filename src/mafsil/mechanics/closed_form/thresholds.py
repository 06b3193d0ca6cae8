"""From which numbers on a row of a closed form is a solution, may become one, or is one with another.

The same numbers stand in the compiled decision (`mafsil.mechanics.closed_form.decision`) and in inverse kinematics,
which refines what the decision leaves open.
"""

from __future__ import annotations

from mafsil.mechanics.arm_pattern import ArmPattern, Family
from mafsil.model.limits import MEASURED

ORTHOGONALITY = 1e-6
"""Largest |R'R - I| that is taken for rounding of a printed matrix and repaired."""

FARTHEST = 1e100
"""Numbers of a position from here on [m] are refused: squares of distances would soon overflow."""

CLEAR = 1e-11
"""Residual below which a row of the closed form needs no refinement [m | rad]."""

SPLIT = 0.5
"""Residual, in units of the arm, up to which a row with four merged roots may become a solution by refinement.

A merged shoulder lets a straight wrist seem bent, and the turn of its last link is then anything.
"""

NEARLY, BENT = 1e-3, 1e-2
"""Residual up to which a row may become a solution by refinement where a solution's branch margin is that small."""

MERGED = 1e-7
"""Branch margins up to which two branches are one, and a solution may be a member of a continuum."""

APART = 1e-5
"""Branch margins above which two branches are distinct solutions: their coordinates differ by as much at least."""

QUARTIC = 1e-4
"""The same of roots of an equation of fourth degree, which merge by three and four: by elimination below."""

SECOND = 1e-2
"""Branch margins above which a branch takes no part where two others meet: four merged roots split by so much."""

ROUNDED = 1e-10
"""Residuals, in units of the arm and times the square of the second branch margin, that rounding may explain, amply."""

FOLD = 1e-6
"""Branch margins below which roots of an equation of fourth degree may have merged."""

LOOSE = 1e-8
"""Tolerances, and residuals of the closed form, above which a configuration that is near enough is looked for."""

INSIDE = 1e-12
"""By how much a joint may seem beyond its limit by rounding [rad | m]: where its value is chosen, not measured."""

ON_LIMIT = MEASURED
"""By how much a joint of an isolated solution may lie beyond its limit and count as on it [rad | m]."""

WHOLE_TURN = 1e-12
"""Share of a turn by which rounding may miss a whole one."""

FIRST_JOINTS = {Family.SPHERICAL_WRIST: 3, Family.THREE_PARALLEL: 1, Family.LINKED: 1}
"""How many joints of a closed form are found before those of the wrist; where they are free, continua may cross."""

WRIST_JOINTS = {Family.SPHERICAL_WRIST: (3, 5), Family.THREE_PARALLEL: (1, 2, 3, 5)}
"""Which joints of a closed form move while a wrist that stands straight is turned."""


def candidate(pattern: ArmPattern) -> float:
    """Residual up to which a row of an exact closed form may become a solution by refinement.

    Rounding splits merged roots: two by its square root, four by its fourth root.
    """
    return 1e-2 if pattern.quartic else 1e-5


def folds(pattern: ArmPattern) -> bool:
    """Whether two pairs of roots may merge at once, so that rounding moves rows far off."""
    return pattern.family in (Family.SPHERICAL_WRIST, Family.THREE_PARALLEL)


def merges_twice(pattern: ArmPattern) -> bool:
    """Whether two of shoulder, elbow and wrist may do so; prismatic joints alone are linear: nothing merges."""
    revolute = (j >= 0 and not prismatic for j, prismatic in zip(pattern.joints, pattern.prismatic, strict=True))
    return folds(pattern) and any(revolute)
