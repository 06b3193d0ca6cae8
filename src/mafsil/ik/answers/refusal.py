"""Why a pose has no solution: which step fails and by how much, and the nearest pose that can be reached."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix, cross
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import pose
from mafsil.ik.answers.branch import failed_step
from mafsil.ik.answers.candidate_table import CandidateTable
from mafsil.ik.answers.setting import Setting
from mafsil.ik.refine import least_squares, pose_errors, residuals
from mafsil.ik.result import IKResult, IKStatus, rounded_up
from mafsil.ik.tolerances import (
    EXACT_POSE,
    FROM_THE_POSE,
    LEAST_DAMPING,
    MILLIMETRES,
    NO_GRADIENT,
    REACHED,
    START_DAMPING,
)
from mafsil.lazy_module import lazily
from mafsil.mechanics.arm_pattern import ArmPattern, FailedStep, Family
from mafsil.messages import say

if TYPE_CHECKING:
    import mafsil.ik.numerical as numerical
else:
    numerical = lazily("mafsil.ik.numerical")

STARTS = 24
"""Random configurations from which the nearest place is sought, besides the rows of the closed form."""

DESCENT = 100
"""Steps of that search."""

STEPS = {
    FailedStep.SHOULDER: "ik.failed_shoulder",
    FailedStep.TOO_FAR: "ik.failed_far",
    FailedStep.TOO_NEAR: "ik.failed_near",
    FailedStep.DIRECTION: "ik.failed_direction",
    FailedStep.ORIENTATION: "ik.failed_orientation",
}
"""The sentence for each step of a closed form."""


@dataclass(frozen=True, eq=False)
class Refusal:
    """A no with its reason.

    Attributes:
        verdict: of what kind.
        details: what its sentence mentions.
        q: (m,) the configuration of the nearest pose that was found.
        residual: its error, the larger of distance [m] and angle [rad].
        steps: keys of the sentences about what fails: place or orientation, and which step of the closed form.
    """

    verdict: IKStatus
    details: Mapping[str, object]
    q: JointVector
    residual: float
    steps: tuple[str, ...] = ()

    def words(self, language: str | None = None, *, degrees: bool = False) -> dict[str, str]:
        """The error with its units, and the tolerance that would accept the nearest configuration."""
        position, rotation = (self.details[name] for name in ("position_error", "rotation_error"))
        place = say("ik.length", language=language, value=plain(1e3 * float(str(position))))
        angle, unit = (np.degrees(float(str(rotation))), "deg") if degrees else (float(str(rotation)), "rad")
        turn = say("ik.angle", language=language, value=plain(float(angle)), unit=unit)
        only = self.details["place_only"]
        residual = place if only else say("ik.place_and_turn", language=language, place=place, turn=turn)
        return {
            "residual": residual,
            "error": turn if self.details["placed"] else place,
            "accepting": f"{rounded_up(self.residual):.3g}",
        }


def plain(x: float) -> str:
    """Four digits, without an exponent where a person would write none; rounding is nothing."""
    if abs(x) < EXACT_POSE:
        return "0"
    return f"{x:.4g}" if x == 0.0 or not 1e-4 <= abs(x) < 1e6 else f"{float(f'{x:.4g}'):.10f}".rstrip("0").rstrip(".")


def refusal(
    setting: Setting,
    T: PoseMatrix,
    q0: JointVector,
    rows: tuple[JointVector, CandidateTable] | None,
    tolerance: float,
    *,
    eliminated: bool,
    tried: Mapping[str, int],
) -> Refusal:
    """The reason why there is no solution.

    Args:
        setting: the arm.
        T: (4, 4) requested pose.
        q0: (m,) a configuration to start from.
        rows: of the closed form: coordinates and details.
        tolerance: residual of a solution.
        eliminated: whether elimination proves that there is no solution.
        tried: starts of searches before.
    """
    arm, n = setting.arm, setting.robot.n
    exact = arm.exact and not arm.locked and rows is not None
    kind = FailedStep.NONE if not exact or rows is None else failed_step_of(rows[1])
    few = setting.few and setting.task == "pose"
    reached = _places(setting, T[None]) if few else None
    places = setting.nothing if reached is None else reached.q[reached.solved]
    q = _least_off(setting, T, q0, rows, places, by_place=exact and kind in _PLACE)
    error = pose_errors(setting.robot, q[None], T, setting.mask)[0]
    position, rotation = float(np.linalg.norm(error[3:])), float(np.linalg.norm(error[:3]))
    known: dict[str, object] = {"position_error": position, "rotation_error": rotation, "joints": n, **tried}
    known |= {"error": position if position > tolerance else rotation, "placed": position <= tolerance}
    known["place_only"] = setting.task == "position"
    residual = max(position, rotation)
    # Merged roots of an equation of fourth degree may be lost: elimination has to prove that there are none.
    proven = setting.decisive or eliminated
    verdict = verdict_without_solution(setting, T, proven=proven)
    if beyond_reach(setting, T):
        far = _reasons(kind, (FailedStep.TOO_FAR, FailedStep.SHOULDER))
        return Refusal(verdict, known, q, residual, (*far, *unit_reasons(position, setting)))
    if off := out_of_plane(setting, T):
        return Refusal(verdict, known, q, residual, (f"ik.part_off_{off}",))
    if not proven:
        return Refusal(verdict, known, q, residual)
    if not few:
        allowed = _PLACE if position > tolerance else (FailedStep.ORIENTATION,)
        return Refusal(verdict, known, q, residual, _reasons(kind, allowed))
    if len(places):
        return Refusal(IKStatus.NOT_OF_THIS_ARM, known, q, residual, ("ik.part_orientation",))
    if kind in _PLACE:
        return Refusal(IKStatus.OUT_OF_REACH, known, q, residual, _reasons(kind, _PLACE))
    part = "ik.part_place" if rotation <= tolerance else "ik.part_both"
    return Refusal(IKStatus.NOT_OF_THIS_ARM, known, q, residual, (part,))


def _least_off(
    setting: Setting,
    T: PoseMatrix,
    q0: JointVector,
    rows: tuple[JointVector, CandidateTable] | None,
    places: JointVector,
    *,
    by_place: bool,
) -> JointVector:
    """(m,) the configuration that is least off the pose, of `places` (k, m) at its place the least turned.

    Args:
        setting, T, q0, rows: as of `refusal`.
        places: configurations at the place of the pose.
        by_place: whether the closed form failed at the place.
    """
    form, q = setting.arm.form, None
    if by_place and form is not None and rows is not None:
        q = _nearest_place(setting, form.pattern, T, q0, rows)
    if q is None:
        q = _nearest(setting, T, q0, rows)
    return _least_turned(setting, T, places, q) if len(places) else q


def unit_reasons(distance: float, setting: Setting) -> tuple[str, ...]:
    """The remark that a place is given in millimetres, where it lies many reaches away."""
    return ("ik.part_millimetres",) if distance > MILLIMETRES * setting.reach[1] else ()


def _reasons(kind: FailedStep, allowed: Container[FailedStep]) -> tuple[str, ...]:
    """The sentence of a step of the closed form, where it agrees with what is off."""
    return (STEPS[kind],) if kind in allowed else ()


def verdict_without_solution(setting: Setting, T: PoseMatrix, *, proven: bool) -> IKStatus:
    """What is said of a pose without a solution, but that an arm of few joints may reach the place alone.

    Args:
        setting: the arm.
        T: (4, 4) requested pose.
        proven: whether it is proven that there is none.
    """
    if beyond_reach(setting, T):
        return IKStatus.OUT_OF_REACH
    if out_of_plane(setting, T):
        return IKStatus.OUT_OF_REACH if setting.task == "position" else IKStatus.NOT_OF_THIS_ARM
    return IKStatus.OUT_OF_REACH if proven else IKStatus.NOT_FOUND


def beyond_reach(setting: Setting, T: PoseMatrix) -> bool:
    """Whether a place is outside the sphere that the frame cannot leave."""
    centre, radius = setting.reach
    away = T[:3, 3] - centre
    return float(away @ away) > (radius * (1 + EXACT_POSE)) ** 2


def out_of_plane(setting: Setting, T: PoseMatrix) -> str:
    """Which part of a pose a planar arm cannot have, `plane` or `tilt`; empty if none, or of another arm.

    With the normal h of its plane, h . p never changes, nor does the direction of h in the tip.
    """
    h, chain = setting.normal, setting.arm.chain
    if h is None or chain is None:
        return ""
    if abs(float(h @ (T[:3, 3] - chain.home[:3, 3]))) > REACHED * chain.size:
        return "plane"
    tilted = float(np.linalg.norm(np.cross(T[:3, :3] @ chain.home[:3, :3].T @ h, h))) > REACHED
    return "tilt" if tilted and setting.task == "pose" else ""


_PLACE = (FailedStep.SHOULDER, FailedStep.TOO_FAR, FailedStep.TOO_NEAR, FailedStep.DIRECTION)


def failed_step_of(details: CandidateTable) -> FailedStep:
    """The step that fails in the row of a pose with the least subproblem residual.

    Args:
        details: of the rows of one pose.
    """
    short = np.where(np.isfinite(details.subproblem_residual), details.subproblem_residual, np.inf)
    best = int(short.argmin())
    return failed_step(int(np.nan_to_num(details.code[best]))) if short[best] > EXACT_POSE else FailedStep.NONE


def _nearest_place(
    setting: Setting, pattern: ArmPattern, T: PoseMatrix, q0: JointVector, rows: tuple[JointVector, CandidateTable]
) -> JointVector | None:
    """The configuration that keeps the orientation and brings the placed point as near as possible; None where unknown.

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
    # Where two steps fail at once, the nearest place is where both borders meet, and rows may lead past it.
    stroke = np.where(pattern.prismatic[:3], pattern.size, np.pi)
    starts = np.concatenate([starts, np.random.default_rng(0).uniform(-stroke, stroke, (STARTS, 3))])
    found = _descend(pattern, starts, goal)
    places = _placed(pattern, found)[0]
    best = int(np.linalg.norm(places - goal, axis=1).argmin())
    moved = np.eye(4)
    moved[:3, 3] = places[best] - goal
    reachable = moved @ P
    reachable = (pose.inverse(reachable) if pattern.reversed else reachable) @ pattern.home
    form = setting.arm.form
    assert form is not None
    table = form.solve(reachable, q0)
    residual = np.where(np.isfinite(table.residual), table.residual, np.inf)
    q = table.q[int(residual.argmin())]
    return q if residual.min() < FROM_THE_POSE else None


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
        screw = np.concatenate([np.zeros(3), w] if pattern.prismatic[i] else [w, cross(r, w)])
        E = pose.exp(screw * q[:, i, None])
        columns, axes = (rows @ E[:, :3, :3].transpose(0, 2, 1) for rows in (columns, axes))
        x = (E[:, :3, :3] @ x[:, :, None])[:, :, 0] + E[:, :3, 3]
        columns[:, i] = w if pattern.prismatic[i] else cross(w, x - r)
        axes[:, i] = 0.0 if pattern.prismatic[i] else w
    i, j = np.minimum(*np.indices((3, 3))), np.maximum(*np.indices((3, 3)))
    return x, columns.transpose(0, 2, 1), cross(axes[:, i], columns[:, j])


def _descend(pattern: ArmPattern, q: Floats, goal: Floats) -> Floats:
    """(k, 3) damped Newton steps on the squared distance of the placed point, from many starts."""
    x, J, slopes = _placed(pattern, q)
    damping, unit, stride = np.full(len(q), START_DAMPING), pattern.size**2 * np.eye(3), max(1.0, pattern.size)
    for _ in range(DESCENT):
        away = goal - x
        gradient = (away[:, None] @ J)[:, 0]
        if np.abs(gradient).max() < NO_GRADIENT * pattern.size**2:
            break
        hessian = J.transpose(0, 2, 1) @ J - np.einsum("kijx,kx->kij", slopes, away)
        lowest = np.maximum(-np.linalg.eigvalsh(hessian)[:, 0] / pattern.size**2, 0.0)
        damped = hessian + (damping + 1.1 * lowest)[:, None, None] * unit
        step = np.asarray(np.linalg.solve(damped, gradient[:, :, None])[:, :, 0], dtype=np.float64)
        length: Floats = np.abs(step).max(axis=1, keepdims=True)
        trial = q + step * np.minimum(1.0, stride / np.maximum(length, LEAST_DIVISOR))
        moved, J_moved, slopes_moved = _placed(pattern, trial)
        better = np.linalg.norm(goal - moved, axis=1) <= np.linalg.norm(away, axis=1)
        q, x = np.where(better[:, None], trial, q), np.where(better[:, None], moved, x)
        J = np.where(better[:, None, None], J_moved, J)
        slopes = np.where(better[:, None, None, None], slopes_moved, slopes)
        damping = np.where(better, np.maximum(damping / 8, LEAST_DAMPING), np.minimum(damping * 8, 1e6))
    return q


def _nearest(
    setting: Setting, T: PoseMatrix, q0: JointVector, rows: tuple[JointVector, CandidateTable] | None
) -> JointVector:
    """The configuration nearest to a pose: by least squares from every row, and from where a search comes nearest."""
    starts = [q0[None]]
    if rows is not None:
        starts.append(rows[0][np.isfinite(rows[0]).all(axis=1)])
    if not setting.arm.exact:
        best = numerical.solve_ik(setting.robot, T, task=setting.task, limits=False, restarts=STARTS).nearest[None]
        starts.append(best[np.isfinite(best).all(axis=1)])
    q, size = least_squares(setting.robot, np.concatenate(starts), T, setting.mask)
    return q[int(size.argmin())]


def reached_places(setting: Setting, T: PoseMatrix) -> NDArray[np.bool_]:
    """(k,) whether a search finds a configuration that reaches the position alone of poses (k, 4, 4)."""
    return _places(setting, T).solved


def _places(setting: Setting, T: PoseMatrix) -> IKResult:
    return numerical.solve_ik(setting.robot, T, task="position", limits=False, restarts=STARTS)


def _least_turned(setting: Setting, T: PoseMatrix, places: JointVector, q: JointVector) -> JointVector:
    """The nearest configuration among q and those that reach the place, which come first where equally near."""
    turned, _ = least_squares(setting.robot, places, T, setting.mask)
    rows = np.concatenate([q[None], turned, places])
    error = pose_errors(setting.robot, rows, T, setting.mask)
    order = np.lexsort((np.linalg.norm(error[:, 3:], axis=1), np.round(residuals(error), 9)))
    return rows[order[0]]
