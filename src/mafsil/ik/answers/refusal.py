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
from mafsil.ik.refine import misses, refined
from mafsil.mechanics.arm_pattern import ArmPattern, Family, Missed

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
    setting: Setting, T: PoseMatrix, near: JointVector, rows: tuple[Floats, Floats, Floats] | None, tolerance: float
) -> Refusal:
    """The reason why there is no solution.

    Args:
        setting: the arm.
        T: (4, 4) wanted pose.
        near: (n,) a posture to start from.
        rows: of the closed form: coordinates and facts.
        tolerance: residual of a solution.
    """
    arm = setting.arm
    exact = arm.exact and not arm.held and rows is not None
    kind, shortfall = (Missed.NONE, 0.0) if not exact or rows is None else _step(rows[1])
    q = None
    if exact and arm.form is not None and rows is not None and kind in _PLACE:
        q = _nearest_place(setting, arm.form.pattern, T, near, rows)
    if q is None:
        q = _nearest(setting, T, near, rows)
    error = misses(setting.robot, q[None], T, setting.mask, None)[0]
    position, rotation = float(np.linalg.norm(error[3:])), float(np.linalg.norm(error[:3]))
    facts: dict[str, object] = {"position_error": position, "rotation_error": rotation, "shortfall": position}
    centre, radius = reach_bound(setting.robot.mechanism, None)
    distance = float(np.linalg.norm(T[:3, 3] - centre))
    proven = exact or (arm.general is not None and arm.general.proves(T, 0))
    step = STEPS.get(kind, "")
    if distance > radius * (1 + 1e-12):
        facts["shortfall"] = distance - radius if not exact else max(position, distance - radius)
        return Refusal(Verdict.OUT_OF_REACH, facts, q, step)
    if exact and setting.robot.n < 6 and setting.task == "pose" and _place_reached(setting, T, q, tolerance):
        return Refusal(Verdict.NOT_OF_THIS_ARM, {**facts, "joints": setting.robot.n}, q, step)
    if proven and (kind is not Missed.NONE or arm.form is None or setting.robot.n >= 6):
        facts["shortfall"] = max(position, shortfall if kind is Missed.ORIENTATION else 0.0, 0.0)
        return Refusal(Verdict.OUT_OF_REACH, facts, q, step)
    if exact:
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
    found = np.array([_descended(pattern, q, goal) for q in starts])
    if not len(found):
        return None
    places = np.array([_placed(pattern, q)[0] for q in found])
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


def _placed(pattern: ArmPattern, q: Floats) -> tuple[Floats, Floats]:
    """(3,) the point carried by the first three joints, and (3, 3) its velocities."""
    x, columns = pattern.centre, []
    for i in (2, 1, 0):
        w, r = pattern.axes[i], pattern.points[i]
        E = pose.exp(np.concatenate([np.zeros(3), w] if pattern.slides[i] else [w, np.cross(r, w)]) * q[i])
        columns = [E[:3, :3] @ c for c in columns]
        x = E[:3, :3] @ x + E[:3, 3]
        columns.insert(0, w if pattern.slides[i] else np.cross(w, x - r))
    return x, np.stack(columns, axis=1)


def _descended(pattern: ArmPattern, q: Floats, goal: Floats) -> Floats:
    """Damped least squares on the distance of the placed point."""
    x, J = _placed(pattern, q)
    damping = 1e-3
    for _ in range(60):
        gradient = J.T @ (goal - x)
        if np.linalg.norm(gradient) < 1e-13 * pattern.size**2:
            break
        trial = q + np.linalg.solve(J.T @ J + damping * pattern.size**2 * np.eye(3), gradient)
        moved, J_moved = _placed(pattern, trial)
        if np.linalg.norm(goal - moved) <= np.linalg.norm(goal - x):
            q, x, J, damping = trial, moved, J_moved, max(damping / 4, 1e-12)
        else:
            damping = min(damping * 8, 1e6)
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


def _place_reached(setting: Setting, T: PoseMatrix, q: JointVector, tolerance: float) -> bool:
    """Whether the position alone can be reached, by an arm of few joints."""
    mask = np.array(MASKS["position"], dtype=np.bool_)
    _, size = refined(setting.robot, q[None], T, mask, None, steps=40)
    return bool(size[0] <= tolerance)
