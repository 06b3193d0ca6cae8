"""A student's list of screw axes against the robot: which joint is wrong, and by which mistake."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Vector6, as_batch, not_negative
from mafsil.derivation.review import Finding, Mistake, Review, shown
from mafsil.derivation.same_arm import base_between, misfit
from mafsil.errors import InputError
from mafsil.model.loading import RobotLike, as_mechanism
from mafsil.model.screw_axes import screws


def check_screws(
    S: ArrayLike, mechanism: RobotLike, form: Literal["space", "body"] = "space", *, tolerance: float = 1e-6
) -> Review:
    """Whether screw axes are those of the robot at q = 0; if not, which are wrong and why.

    Args:
        S: (n, 6) axes (omega, v), rows as the joints from the base.
        mechanism: a Robot, a Mechanism, a name of the library or a path.
        form: `space` if the axes are given in {s}, `body` if in the tip frame.
        tolerance: of every entry.

    Raises:
        InputError: not (n, 6) finite numbers, or an unknown form.
    """
    tolerance = not_negative("tolerance", tolerance)
    if form not in ("space", "body"):
        raise InputError("derivation.form", value=form, known="space, body")
    space, body, _ = screws(as_mechanism(mechanism))
    truth, other = (space, body) if form == "space" else (body, space)
    given = as_batch("S", S, truth.shape, finite=True)
    if given.ndim != 2:
        raise InputError("input.shape", name="S", expected=truth.shape, got=given.shape, hint="")
    if np.abs(given - truth).max() <= tolerance:
        return Review()
    if np.abs(given - other).max() <= tolerance:
        return Review((Finding(Mistake.FRAME),))
    if np.abs(np.roll(given, 3, axis=1) - truth).max() <= tolerance:
        return Review((Finding(Mistake.PARTS_SWAPPED),))
    findings = [
        _finding(i, given[i], truth, other, tolerance)
        for i in range(len(truth))
        if np.abs(given[i] - truth[i]).max() > tolerance
    ]
    proven = all(finding.mistake is not Mistake.VALUE for finding in findings)
    if not proven and _is_moved(given, truth, tolerance):
        return Review((Finding(Mistake.OTHER_BASE),))
    return Review(tuple(findings), proven=proven)


def _is_moved(given: Floats, truth: Floats, tolerance: float) -> bool:
    """Whether one change of frame makes all axes right."""
    B = base_between(given[None], truth)
    return float(np.abs(misfit(given[None], truth, B)).max(initial=0.0)) <= tolerance


def _finding(i: int, S: Vector6, truth: Floats, other: Floats, tolerance: float) -> Finding:
    for mistake, entry, right in _mistaken(i, truth, other):
        if np.abs(S - right).max() <= tolerance:
            return _name(mistake, i, entry, S, truth[i])
    wrong = truth[i]
    if np.abs(S[:3] - wrong[:3]).max() > tolerance:
        length = float(np.linalg.norm(S[:3]))
        aligned = length > 0 and np.abs(S / length - wrong).max() <= tolerance
        return _name(Mistake.NOT_UNIT if aligned else Mistake.VALUE, i, "S" if aligned else "ω", S, wrong)
    # A point q on the axis written where its moment belongs: -omega x q is then the right v.
    if wrong[:3].any() and np.abs(-np.cross(wrong[:3], S[3:]) - wrong[3:]).max() <= tolerance:
        return _name(Mistake.POINT_AS_MOMENT, i, "v", S, wrong)
    flipped = np.abs(np.abs(S[3:]) - np.abs(wrong[3:])).max() <= tolerance
    return _name(Mistake.SIGN if flipped else Mistake.VALUE, i, "v", S, wrong)


def _mistaken(i: int, truth: Floats, other: Floats) -> Iterator[tuple[Mistake, str, Vector6]]:
    """What the axis would be after each mistake."""
    omega, v = truth[i, :3], truth[i, 3:]
    revolute = bool(omega.any())
    if revolute and v.any():
        yield Mistake.CROSS_ORDER, "v", np.concatenate([omega, -v])
        yield Mistake.NO_MOMENT, "v", np.concatenate([omega, np.zeros(3)])
    yield Mistake.REVERSED, "S", -truth[i]
    if revolute:
        yield Mistake.SIGN, "ω", np.concatenate([-omega, v])
    yield Mistake.PARTS_SWAPPED, "S", np.concatenate([v, omega])
    yield Mistake.FRAME, "S", other[i]
    for k in range(len(truth)):
        if k != i:
            yield Mistake.COLUMN_SWAPPED, "S", truth[k]
    if revolute:
        yield Mistake.KIND, "S", np.concatenate([np.zeros(3), omega])
    else:
        yield Mistake.KIND, "S", np.concatenate([v, np.zeros(3)])


def _name(mistake: Mistake, i: int, entry: str, S: Vector6, right: Vector6) -> Finding:
    part = {"v": slice(3, 6), "ω": slice(0, 3)}.get(entry, slice(0, 6))
    return Finding(mistake, row=i + 1, entry=entry, given=_tuple(S[part]), expected=_tuple(right[part]))


def _tuple(values: Floats) -> str:
    return "(" + ", ".join(shown(float(x)) for x in values) + ")"
