"""Why a pose has no solution: which step misses and by how much, and the nearest pose that can be reached."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.geometry import pose
from mafsil.ik.answers.branch import missed
from mafsil.ik.answers.setting import MASKS, Setting
from mafsil.ik.answers.verdict import Verdict
from mafsil.ik.problem import reach_bound
from mafsil.ik.refine import misses, refined, residuals
from mafsil.mechanics.arm_pattern import ArmPattern, Family, Missed

STARTS = 24
"""Random postures from which the nearest place is sought, besides the rows of the closed form."""

DESCENT = 100
"""Steps of that search."""

STEPS = {
    Missed.SHOULDER: "ik.missed_shoulder",
    Missed.FAR: "ik.missed_far",
    Missed.NEAR: "ik.missed_near",
    Missed.DIRECTION: "ik.missed_direction",
    Missed.ORIENTATION: "ik.missed_orientation",
}
"""The sentence for each step of a closed form."""


@dataclass(frozen=True, eq=False)
class Refusal:
    """A no with its reason.

    Attributes:
        verdict: of what kind.
        facts: what its sentence mentions.
        q: (n,) the posture of the nearest pose that was found.
        step: key of the sentence about the step that misses; empty if none is known.
    """

    verdict: Verdict
    facts: Mapping[str, object]
    q: JointVector
    step: str = ""


def refusal(
    setting: Setting,
    T: PoseMatrix,
    near: JointVector,
    rows: tuple[Floats, Floats, Floats] | None,
    tolerance: float,
    *,
    eliminated: bool,
) -> Refusal:
    """The reason why there is no solution.

    Args:
        setting: the arm.
        T: (4, 4) wanted pose.
        near: (n,) a posture to start from.
        rows: of the closed form: coordinates and facts.
        tolerance: residual of a solution.
        eliminated: whether elimination proves that there is no solution.
    """
    arm = setting.arm
    exact = arm.exact and not arm.held and rows is not None
    kind, shortfall = (Missed.NONE, 0.0) if not exact or rows is None else _step(rows[1])
    q = None
    if exact and arm.form is not None and rows is not None and kind in _PLACE:
        q = _nearest_place(setting, arm.form.pattern, T, near, rows)
    if q is None:
        q = _nearest(setting, T, near, rows)
    few = exact and setting.robot.n < 6 and setting.task == "pose"
    places = _reaching_the_place(setting, T, q, tolerance) if few else setting.nothing
    if len(places):
        q = _least_turned(setting, T, places, q)
    error = misses(setting.robot, q[None], T, setting.mask, None)[0]
    position, rotation = float(np.linalg.norm(error[3:])), float(np.linalg.norm(error[:3]))
    facts: dict[str, object] = {"position_error": position, "rotation_error": rotation, "shortfall": position}
    centre, radius = reach_bound(setting.robot.mechanism, None)
    distance = float(np.linalg.norm(T[:3, 3] - centre))
    # Merged roots of an equation of fourth degree may be lost: elimination has to prove that there are none.
    sure = exact and not setting.quartic
    proven = sure or eliminated
    step = STEPS.get(kind, "")
    if distance > radius * (1 + 1e-12):
        facts["shortfall"] = distance - radius if not exact else max(position, distance - radius)
        return Refusal(Verdict.OUT_OF_REACH, facts, q, step)
    if len(places):
        return Refusal(Verdict.NOT_OF_THIS_ARM, {**facts, "joints": setting.robot.n}, q, step)
    if proven and (kind is not Missed.NONE or arm.form is None or setting.robot.n >= 6):
        facts["shortfall"] = max(position, shortfall if kind is Missed.ORIENTATION else 0.0, 0.0)
        return Refusal(Verdict.OUT_OF_REACH, facts, q, step)
    if sure:
        return Refusal(Verdict.NOT_OF_THIS_ARM, {**facts, "joints": setting.robot.n}, q, step)
    return Refusal(Verdict.NOT_FOUND, facts, q)


_PLACE = (Missed.SHOULDER, Missed.FAR, Missed.NEAR, Missed.DIRECTION)


def _step(facts: Floats) -> tuple[Missed, float]:
    """The step that misses in the row that misses least, and by how much."""
    short = np.where(np.isfinite(facts[:, 1]), facts[:, 1], np.inf)
    best = int(short.argmin())
    return (missed(int(facts[best, 3])), float(short[best])) if short[best] > 1e-12 else (Missed.NONE, 0.0)


def _nearest_place(
    setting: Setting, pattern: ArmPattern, T: PoseMatrix, near: JointVector, rows: tuple[Floats, Floats, Floats]
) -> JointVector | None:
    """The posture that keeps the orientation and brings the placed point as near as possible; None where unknown.

    The point's distance is minimised over the first three joints from every row, and the pose moved by what is left.
    """
    if pattern.family not in (Family.SPHERICAL_WRIST, Family.POINT) or pattern.shifted:
        return None
    if any(j < 0 for j in pattern.joints):
        return None
    P = T @ pose.inverse(pattern.home)
    P = pose.inverse(P) if pattern.reversed else P
    goal = P[:3, :3] @ pattern.centre + P[:3, 3]
    # The pattern's joints are the robot's: of a reversed chain with axes in the opposite sense.
    starts = rows[0][np.isfinite(rows[0]).all(axis=1)][:, list(pattern.joints[:3])]
    # Where two steps miss at once, the nearest place is where both borders meet, and rows may lead past it.
    stroke = np.where(pattern.slides[:3], pattern.size, np.pi)
    starts = np.concatenate([starts, np.random.default_rng(0).uniform(-stroke, stroke, (STARTS, 3))])
    found = _descended(pattern, starts, goal)
    places = _placed(pattern, found)[0]
    best = int(np.linalg.norm(places - goal, axis=1).argmin())
    moved = np.eye(4)
    moved[:3, 3] = places[best] - goal
    reachable = moved @ P
    reachable = (pose.inverse(reachable) if pattern.reversed else reachable) @ pattern.home
    form = setting.arm.form
    assert form is not None
    table = form.solve(reachable, near)
    residual = np.where(np.isfinite(table.residual), table.residual, np.inf)
    q = table.q[int(residual.argmin())]
    return q if residual.min() < 1e-6 else None


def _placed(pattern: ArmPattern, q: Floats) -> tuple[Floats, Floats, Floats]:
    """(k, 3) the point carried by the first three joints, (k, 3, 3) its velocities, and (k, 3, 3, 3) their slopes.

    The slope of velocity j with joint i, i <= j, is w_i x (velocity j).
    """
    x, columns, axes = (
        np.repeat(pattern.centre[None], len(q), axis=0),
        np.zeros((len(q), 3, 3)),
        np.zeros((len(q), 3, 3)),
    )
    for i in (2, 1, 0):
        w, r = pattern.axes[i], pattern.points[i]
        screw = np.concatenate([np.zeros(3), w] if pattern.slides[i] else [w, np.cross(r, w)])
        E = pose.exp(screw * q[:, i, None])
        columns, axes = (rows @ E[:, :3, :3].transpose(0, 2, 1) for rows in (columns, axes))
        x = (E[:, :3, :3] @ x[:, :, None])[:, :, 0] + E[:, :3, 3]
        columns[:, i] = w if pattern.slides[i] else np.cross(w, x - r)
        axes[:, i] = 0.0 if pattern.slides[i] else w
    i, j = np.minimum(*np.indices((3, 3))), np.maximum(*np.indices((3, 3)))
    return x, columns.transpose(0, 2, 1), np.cross(axes[:, i], columns[:, j])


def _descended(pattern: ArmPattern, q: Floats, goal: Floats) -> Floats:
    """(k, 3) damped Newton steps on the squared distance of the placed point, from many starts."""
    x, J, slopes = _placed(pattern, q)
    damping, unit, stride = np.full(len(q), 1e-3), pattern.size**2 * np.eye(3), max(1.0, pattern.size)
    for _ in range(DESCENT):
        away = goal - x
        gradient = (away[:, None] @ J)[:, 0]
        if np.abs(gradient).max() < 1e-13 * pattern.size**2:
            break
        hessian = J.transpose(0, 2, 1) @ J - np.einsum("kijx,kx->kij", slopes, away)
        lowest = np.maximum(-np.linalg.eigvalsh(hessian)[:, 0] / pattern.size**2, 0.0)
        step = np.linalg.solve(hessian + (damping + 1.1 * lowest)[:, None, None] * unit, gradient[:, :, None])[:, :, 0]
        trial = q + step * np.minimum(1.0, stride / np.maximum(np.abs(step).max(axis=1, keepdims=True), 1e-300))
        moved, J_moved, slopes_moved = _placed(pattern, trial)
        better = np.linalg.norm(goal - moved, axis=1) <= np.linalg.norm(away, axis=1)
        q, x = np.where(better[:, None], trial, q), np.where(better[:, None], moved, x)
        J = np.where(better[:, None, None], J_moved, J)
        slopes = np.where(better[:, None, None, None], slopes_moved, slopes)
        damping = np.where(better, np.maximum(damping / 8, 1e-12), np.minimum(damping * 8, 1e6))
    return q


def _nearest(
    setting: Setting, T: PoseMatrix, near: JointVector, rows: tuple[Floats, Floats, Floats] | None
) -> JointVector:
    """The posture nearest to a pose, by least squares from every row."""
    starts = [near[None]]
    if rows is not None:
        starts.append(rows[0][np.isfinite(rows[0]).all(axis=1)])
    q, size = refined(setting.robot, np.concatenate(starts), T, setting.mask, None, steps=40)
    return q[int(size.argmin())]


def _reaching_the_place(setting: Setting, T: PoseMatrix, q: JointVector, tolerance: float) -> JointVector:
    """(k, n) postures of an arm of few joints that reach the position alone, sought from q and from others."""
    mask = np.array(MASKS["position"], dtype=np.bool_)
    others = setting.middle + np.random.default_rng(0).uniform(-np.pi, np.pi, (STARTS, setting.robot.n))
    found, size = refined(setting.robot, np.concatenate([q[None], others]), T, mask, None, steps=40)
    return found[size <= tolerance]


def _least_turned(setting: Setting, T: PoseMatrix, places: JointVector, q: JointVector) -> JointVector:
    """The nearest posture among q and those that reach the place; of equally near ones that which is at the place."""
    turned, _ = refined(setting.robot, places, T, setting.mask, None, steps=40)
    rows = np.concatenate([q[None], turned, places])
    error = misses(setting.robot, rows, T, setting.mask, None)
    order = np.lexsort((np.linalg.norm(error[:, 3:], axis=1), np.round(residuals(error), 9)))
    return rows[order[0]]
