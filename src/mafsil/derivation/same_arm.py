"""Whether lists of screws are the same arm, and the change of base frame between them; many lists at once.

A student's list of screw axes against the robot: which joint is wrong, and by which mistake.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Vector6, as_batch, not_negative
from mafsil.derivation.review import Finding, Mistake, Review, shown
from mafsil.derivation.tolerances import ALMOST_PARALLEL, NEAREST, PSEUDOINVERSE
from mafsil.errors import InputError
from mafsil.model.dh_from_axes import screws
from mafsil.model.loading import RobotLike, as_mechanism

_REFINEMENTS = 3


def misfit(S: Floats, other: Floats, B: Floats) -> Floats:
    """(m, n, 6) how far Ad(B) S is from the other axes.

    Args:
        S: (m, n, 6) lists of screw axes (omega, v).
        other: (n, 6) the axes they should be.
        B: (m, 4, 4) poses.
    """
    R, p = B[:, None, :3, :3], B[:, None, :3, 3]
    omega = (R @ S[..., :3, None])[..., 0]
    v = (R @ S[..., 3:, None])[..., 0] + np.cross(p, omega)
    return np.concatenate([omega, v], axis=-1) - other


def base_between(S: Floats, other: Floats) -> Floats:
    """The poses B (m, 4, 4) that bring every list of axes nearest to the other one.

    1. The rotation between the directions (Kabsch). Where all are parallel, or almost, it leaves a turn about them
       free: there the turn that fits the places of the axes in the plane across them is tried too.
    2. The origin by linear least squares: p x omega' = v' - R v for every revolute axis.
    3. Where the misfit is small, all six freedoms together by Gauss-Newton: places also tell directions.

    Args:
        S: (m, n, 6) lists of screw axes.
        other: (n, 6) axes.

    Reference: Kabsch, Acta Crystallographica A 32, 1976.
    """
    revolute = np.abs(S[..., :3]).max(axis=-1) > 0.5
    before = np.where(revolute[..., None], S[..., :3], S[..., 3:])
    after = np.where((np.abs(other[:, :3]).max(axis=1) > 0.5)[:, None], other[:, :3], other[:, 3:])
    U, sizes, Vt = np.linalg.svd(np.einsum("nj,mnk->mjk", after, before))
    U[..., 2] *= np.linalg.det(U @ Vt)[:, None]
    R = U @ Vt
    B = _with_origin(R, S, other, revolute)
    flat = sizes[:, 1] < ALMOST_PARALLEL * sizes[:, 0]
    if flat.any():
        spun = _spun(R[flat], S[flat], other, after[0], revolute[flat])
        B[flat] = _better(S[flat], other, B[flat], _with_origin(spun, S[flat], other, revolute[flat]))
    return _refine(S, other, B)


def _with_origin(R: Floats, S: Floats, other: Floats, revolute: Floats) -> Floats:
    """Poses (m, 4, 4) with those rotations, and p with R v + p x R omega = v' as nearly as possible."""
    omega = (R[:, None] @ S[..., :3, None])[..., 0] * revolute[..., None]
    missing = other[:, 3:] - (R[:, None] @ S[..., 3:, None])[..., 0]
    square = np.einsum("mni,mni->m", omega, omega)[:, None, None] * np.eye(3) - np.einsum("mni,mnj->mij", omega, omega)
    right = np.cross(omega, missing).sum(axis=1)
    B = np.broadcast_to(np.eye(4), (len(S), 4, 4)).copy()
    B[:, :3, :3] = R
    B[:, :3, 3] = (np.linalg.pinv(square, rcond=PSEUDOINVERSE, hermitian=True) @ right[..., None])[..., 0]
    return B


def _spun(R: Floats, S: Floats, other: Floats, z: Floats, revolute: Floats) -> Floats:
    """Rotations turned further about z, the direction of all axes, so that the axes' places fit."""
    weight = revolute[..., None].astype(np.float64)
    count = np.maximum(weight.sum(axis=1, keepdims=True), 1.0)
    mine = np.cross(S[..., :3], S[..., 3:]) @ R.transpose(0, 2, 1)
    theirs = np.broadcast_to(np.cross(other[:, :3], other[:, 3:]), mine.shape)
    mine, theirs = ((x - (weight * x).sum(axis=1, keepdims=True) / count) * weight for x in (mine, theirs))
    angle = np.arctan2((np.cross(mine, theirs) @ z).sum(axis=1), (mine * theirs).sum(axis=(1, 2)))
    c, s = np.cos(angle)[:, None, None], np.sin(angle)[:, None, None]
    Z = np.cross(z, np.eye(3)).T
    return (np.eye(3) + s * Z + (1 - c) * (Z @ Z)) @ R


def _better(S: Floats, other: Floats, one: Floats, two: Floats) -> Floats:
    """Of two poses for every list, the one with the smaller misfit."""
    sizes = [np.abs(misfit(S, other, B)).max(axis=(1, 2), initial=0.0) for B in (one, two)]
    return np.where((sizes[0] <= sizes[1])[:, None, None], one, two)


def _refine(S: Floats, other: Floats, B: Floats) -> Floats:
    scale = max(1.0, float(np.abs(other).max(initial=0.0)))
    for _ in range(_REFINEMENTS):
        size = np.abs(misfit(S, other, B)).max(axis=(1, 2), initial=0.0)
        near = (size < 1e-2 * scale) & (size > NEAREST * scale)
        if not near.any():
            break
        B[near] = _better(S[near], other, B[near], _step(S[near], other, B[near]))
    return B


def _step(S: Floats, other: Floats, B: Floats) -> Floats:
    """One Gauss-Newton step: B moved by the small twist that takes most of the misfit away."""
    error = misfit(S, other, B)
    omega, v = error[..., :3] + other[:, :3], error[..., 3:] + other[:, 3:]
    J = np.zeros((*error.shape, 6))
    J[..., :3, :3] = J[..., 3:, 3:] = -_skew(omega)
    J[..., 3:, :3] = -_skew(v)
    rows = J.reshape(len(S), -1, 6)
    twist = -(np.linalg.pinv(rows, rcond=PSEUDOINVERSE / 10) @ error.reshape(len(S), -1, 1))[..., 0]
    U, _, Vt = np.linalg.svd(np.eye(3) + _skew(twist[:, :3]))
    moved = np.broadcast_to(np.eye(4), B.shape).copy()
    moved[:, :3, :3], moved[:, :3, 3] = U @ Vt, twist[:, 3:]
    return moved @ B


def _skew(w: Floats) -> Floats:
    """(..., 3, 3) matrices [w] with [w] x = w x x."""
    out = np.zeros((*w.shape, 3))
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -w[..., 2], w[..., 1], -w[..., 0]
    out[..., 1, 0], out[..., 2, 0], out[..., 2, 1] = w[..., 2], -w[..., 1], w[..., 0]
    return out


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
