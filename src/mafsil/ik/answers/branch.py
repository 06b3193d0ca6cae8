"""Names of branches: which side of the shoulder, elbow up or down, wrist flipped or not.

Each name is the sign of a number that vanishes exactly where two branches merge, so it cannot change along a motion
that meets no singular configuration. w_i and r_i are axis and a point of joint i in the configuration, c the wrist's
centre.

shoulder  right if (w1 x w2) . (c - r1) > 0: a small positive turn of joint 2 raises c along w1; else left
elbow     up if joint 3 is above the line from joint 2 to c: s w2 . ((r3 - r2) x (c - r3)) < 0, s = 1 right, -1 left;
          of a prismatic third joint out if its stroke leads c away from the shoulder, else in
wrist     no flip if w5 . (w4 x w6) > 0, the wrist bent to the positive side; else flip

References: Lee and Ziegler, A geometric approach in solving the inverse kinematics of PUMA robots, 1984.
"""

from __future__ import annotations

from typing import NamedTuple

from mafsil.mechanics.arm_pattern import ArmPattern, FailedStep, Family, PositioningMethod
from mafsil.messages import say

MERGED = "merged"
"""Where two branches are one."""

_SHOULDER = ("left", MERGED, "right")
_ELBOW = ("down", MERGED, "up")
_STROKE = ("in", MERGED, "out")
_WRIST = ("flip", MERGED, "noflip")
_SIGN = ("-", MERGED, "+")
_STEPS = tuple(FailedStep)


class Branch(NamedTuple):
    """Which of the solutions of its pose a solution is; empty where the arm has no such choice.

    Attributes:
        shoulder: `left`, `right`, or `merged` where both are one.
        elbow: `up`, `down`; `in`, `out` of a prismatic joint; `merged`; of an arm without such a shape the sign of the
            determinant of the joints that place the wrist, `+` or `-`.
        wrist: `flip`, `noflip`, `merged`; of an arm without such a shape a sign.
        root: letter of the root where an equation of higher degree was solved: it tells solutions of one pose apart,
            but need not stay along a path.
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
"""The code of a solution of which neither shoulder nor elbow nor wrist is said: 1 + 3 + 9."""


def branch(pattern: ArmPattern | None, row: int, code: int) -> Branch:
    """The branch of a row of the closed form.

    Args:
        pattern: of the arm; None without closed form.
        row: of its table; negative for a solution found otherwise.
        code: of the row, see `mafsil.mechanics.closed_form.table`.
    """
    if pattern is None or row < 0:
        return Branch()
    shoulder, elbow, wrist = code % 3, code // 3 % 3, code // 9 % 3
    family, linked = pattern.family, pattern.family is Family.LINKED
    quartic = family in (Family.SPHERICAL_WRIST, Family.POINT) and pattern.positioning is PositioningMethod.QUARTIC
    has_shoulder = not linked and family is not Family.PLANAR and _has_shoulder(pattern)
    has_elbow = (
        linked
        or family in (Family.PLANAR, Family.THREE_PARALLEL)
        or pattern.positioning is not PositioningMethod.LINEAR
    )
    has_wrist = family not in (Family.PLANAR, Family.POINT)
    elbows = _SIGN if quartic else _STROKE if _strokes(pattern) else _ELBOW
    wrists = _SIGN if linked else _WRIST
    letter = (row >> 1 if has_wrist else row) if quartic or linked else -1
    return Branch(
        _SHOULDER[shoulder] if has_shoulder else "",
        elbows[elbow] if has_elbow else "",
        wrists[wrist] if has_wrist else "",
        "abcd"[letter] if letter >= 0 else "",
    )


def failed_step(code: int) -> FailedStep:
    """The step that fails in a row."""
    return _STEPS[min(max(code // 27, 0), len(_STEPS) - 1)]


def _has_shoulder(pattern: ArmPattern) -> bool:
    if pattern.family is Family.THREE_PARALLEL:
        return not pattern.prismatic[0]
    first, last = (2, 0) if pattern.positioning_reversed else (0, 2)
    match pattern.positioning:
        case PositioningMethod.PARALLEL:
            return not pattern.prismatic[first]
        case PositioningMethod.MEET:
            return True
        case PositioningMethod.ACROSS:
            return not pattern.prismatic[last]
        case _:
            return False


def _strokes(pattern: ArmPattern) -> bool:
    """Whether the elbow is a prismatic joint."""
    if pattern.family not in (Family.SPHERICAL_WRIST, Family.POINT):
        return False
    return (
        pattern.positioning is PositioningMethod.ACROSS or pattern.prismatic[0 if pattern.positioning_reversed else 2]
    )
