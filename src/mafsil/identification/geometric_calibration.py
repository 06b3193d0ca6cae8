"""Calibration of geometry from measured poses, points, heights or distances: what can be decided, and how well.

A model predicts poses of a body and how they change with its parameters. Gauss-Newton steps are taken in the space of
the singular vectors that the data decide better than the tolerance of the parameters does; along the others a parameter
stays as described. Some rows are held out, and their errors are those of rows that nobody fitted.

References: Hollerbach, Khalil and Gautier, Model identification, Springer Handbook of Robotics, ch. 6; Khalil and
Dombre, Modeling, Identification and Control of Robots, ch. 11.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, as_batch, positive, single, spread
from mafsil.errors import InputError
from mafsil.fields import between
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import pose, rotation
from mafsil.messages import say
from mafsil.messages.tables import number, table
from mafsil.model import Joint, Mechanism
from mafsil.model.exponentials import chain_to_tip
from mafsil.model.loading import RobotLike
from mafsil.robot import Robot, as_robot

STEPS = 20
ANGLE, LENGTH = between(1e-9, 1.0), between(1e-9, 1e3)
"""What tolerances of parameters may be [rad, m]."""
SETTLED = 1e-6
"""Step over the tolerances that ends the fit: above the rounding of poses found by Newton's method."""
ALONE = 1e-3
"""Share of a parameter outside of what the data decide, up to which it can be decided by itself."""
FEWEST = 4
"""Rows that are held out at least, where any are."""


@dataclass(frozen=True, eq=False)
class Measured:
    """What was measured of a body, row by row; one of the four kinds.

    Attributes:
        poses: (k, 4, 4).
        points: (k, 3) places of its origin [m].
        heights: (k,) of its origin along `direction` [m], as a probe gives them.
        distances: (k,) of its origin from the point `center` [m], as a wire gives them.
        direction: (3,) unit, of heights.
        center: (3,) [m], of distances.
        noise: standard deviation of lengths [m].
        angle_noise: of angles [rad], of poses.
    """

    poses: ArrayLike | None = None
    points: ArrayLike | None = None
    heights: ArrayLike | None = None
    distances: ArrayLike | None = None
    direction: ArrayLike = (0.0, 0.0, 1.0)
    center: ArrayLike = (0.0, 0.0, 0.0)
    noise: float = 1e-4
    angle_noise: float = 1e-4

    def __post_init__(self) -> None:
        kinds = [each for each in ("poses", "points", "heights", "distances") if getattr(self, each) is not None]
        if len(kinds) != 1:
            raise InputError("identification.one_kind", given=", ".join(kinds) or "-")
        core = {"poses": (4, 4), "points": (3,), "heights": (), "distances": ()}[kinds[0]]
        value = as_batch(kinds[0], getattr(self, kinds[0]), core, finite=True)
        if value.ndim != len(core) + 1:
            raise InputError("input.shape", name=kinds[0], expected=("k", *core), got=value.shape, hint="")
        object.__setattr__(self, kinds[0], pose.check(value, kinds[0]) if kinds[0] == "poses" else value)
        for name in ("direction", "center"):
            object.__setattr__(self, name, single(name, getattr(self, name), (3,)))
        for name in ("noise", "angle_noise"):
            object.__setattr__(self, name, positive(name, getattr(self, name)))

    @property
    def rows(self) -> int:
        """Number of rows."""
        return next(
            len(np.asarray(v)) for v in (self.poses, self.points, self.heights, self.distances) if v is not None
        )

    def residuals(self, T: Floats, D: Floats) -> tuple[Floats, Floats]:
        """Errors (k, r) over the noise, measured less predicted, and their slopes (k, r, P).

        Args:
            T: (k, 4, 4) predicted poses.
            D: (k, 6, P) their changes (omega, p') by the parameters.
        """
        p = T[:, :3, 3]
        if self.poses is not None:
            given = np.asarray(self.poses)
            turn = rotation.log(given[:, :3, :3] @ np.swapaxes(T[:, :3, :3], -1, -2)) / self.angle_noise
            weights = np.repeat([1 / self.angle_noise, 1 / self.noise], 3)[:, None]
            return np.concatenate([turn, (given[:, :3, 3] - p) / self.noise], axis=1), D * weights
        if self.points is not None:
            return (np.asarray(self.points) - p) / self.noise, D[:, 3:] / self.noise
        if self.heights is not None:
            along = np.broadcast_to(np.asarray(self.direction) / np.linalg.norm(self.direction), p.shape)
            off = np.asarray(self.heights) - (p * along).sum(axis=1)
        else:
            far = np.linalg.norm(p - np.asarray(self.center), axis=1, keepdims=True)
            along = (p - np.asarray(self.center)) / np.maximum(far, LEAST_DIVISOR)
            off = np.asarray(self.distances) - far[:, 0]
        return off[:, None] / self.noise, np.einsum("ki,kip->kp", along, D[:, 3:])[:, None] / self.noise


class CalibrationStatus(Status):
    """Whether the corrected description predicts what was held out better."""

    BETTER = ("identification.calibrated", True)
    NO_BETTER = ("identification.calibrated_no_better", False)
    NOT_SETTLED = ("identification.calibrated_not_settled", False)


@dataclass(frozen=True, eq=False, repr=False)
class GeometricCalibration(Answer, data="names values deviations decided rank errors held_before held_after"):
    """Corrections of geometric parameters; true if rows that were held out are predicted better.

    Attributes:
        status: how it ended.
        names: of the parameters.
        values: (P,) corrections to add [rad | m].
        deviations: (P,) their standard deviations; of what cannot be decided the tolerance.
        decided: (P,) whether the data decide it alone; the others only in combinations, or not at all.
        combinations: (P, n) unit directions over the tolerances that the data do not decide.
        rank: number of combinations that they do.
        errors: (k,) of each row after the correction, over the noise: root mean square of its components.
        before: (k,) the same before.
        held: (k,) which rows were held out.
        corrected: the robot with the corrections.
    """

    status: CalibrationStatus
    names: tuple[str, ...]
    values: Floats
    deviations: Floats
    decided: NDArray[np.bool_]
    combinations: Floats
    rank: int
    errors: Floats
    before: Floats
    held: NDArray[np.bool_]
    corrected: object

    @property
    def held_before(self) -> float:
        """Root mean square error of the rows held out before, over the noise; of all if none were."""
        return _rms(self.before[self.held] if self.held.any() else self.before)

    @property
    def held_after(self) -> float:
        """The same after."""
        return _rms(self.errors[self.held] if self.held.any() else self.errors)

    def explain(self, language: str | None = None) -> str:
        """Errors before and after, how many parameters can be decided, and the worst row."""
        worst = int(self.errors.argmax())
        return self.status.sentence(
            language, before=self.held_before, after=self.held_after, rank=self.rank, parameters=len(self.names),
            decided=int(self.decided.sum()), rows=len(self.errors), held=int(self.held.sum()), worst=worst,
            error=float(self.errors[worst]),
        )  # fmt: skip

    def _table(self) -> list[str]:
        head = tuple(
            say(f"identification.calibration_{key}") for key in ("parameter", "correction", "deviation", "decided")
        )
        rows = [
            (name, number(value), number(off), say(f"identification.calibration_{'alone' if alone else 'combined'}"))
            for name, value, off, alone in zip(
                self.names, self.values.tolist(), self.deviations.tolist(), self.decided.tolist(), strict=True
            )
        ]
        return table(head, rows)


def fit_geometry(
    names: tuple[str, ...],
    tolerances: ArrayLike,
    predict: Callable[[Floats], tuple[Floats, Floats]],
    measured: Measured,
    correct: Callable[[Floats], object],
    held_out: float = 0.2,
) -> GeometricCalibration:
    """Corrections of parameters by which a model predicts what was measured.

    Args:
        names: of P parameters.
        tolerances: (P,) how far they may be off as described [rad | m].
        predict: of corrections (P,): poses (k, 4, 4) and their changes (omega, p') (k, 6, P).
        measured: what was measured.
        correct: the robot with corrections.
        held_out: share of the rows that are not fitted but predicted.
    """
    scale, value = spread("tolerances", tolerances, (len(names),)), np.zeros(len(names))
    held = _held_out(measured.rows, held_out)
    settled, before = False, None
    for _ in range(STEPS):
        r, J = measured.residuals(*predict(value))
        before = _per_row(r) if before is None else before
        U, s, Vt = np.linalg.svd((J[~held] * scale).reshape(-1, len(names)), full_matrices=True)
        rank = int((s > 1.0).sum())
        step = Vt[:rank].T @ ((U[:, :rank].T @ r[~held].ravel()) / s[:rank]) * scale
        value = value + step
        if np.abs(step / scale).max(initial=0.0) < SETTLED:
            settled = True
            break
    r, J = measured.residuals(*predict(value))
    _, s, Vt = np.linalg.svd((J[~held] * scale).reshape(-1, len(names)), full_matrices=True)
    rank = int((s > 1.0).sum())
    spare = max(r[~held].size - rank, 1)
    noise = float(np.sqrt((r[~held] ** 2).sum() / spare))
    known, open_ = Vt[:rank], Vt[rank:].T
    deviations = scale * np.sqrt(((noise * known.T / s[:rank]) ** 2).sum(axis=1) + (open_**2).sum(axis=1))
    decided = np.asarray(np.linalg.norm(open_, axis=1) < ALONE, dtype=np.bool_)
    found = GeometricCalibration(
        CalibrationStatus.BETTER, names, value, deviations, decided, open_, rank, _per_row(r), np.asarray(before), held,
        correct(value),
    )  # fmt: skip
    if not settled:
        return replace(found, status=CalibrationStatus.NOT_SETTLED)
    return found if found.held_after < found.held_before else replace(found, status=CalibrationStatus.NO_BETTER)


def _held_out(rows: int, share: float) -> NDArray[np.bool_]:
    """(k,) rows spread evenly over all; none if the share is zero."""
    share = between(0.0, 0.9)("held_out", share)
    found = np.zeros(rows, dtype=np.bool_)
    count = max(round(share * rows), FEWEST) if share > 0.0 else 0
    if count >= rows:
        raise InputError("identification.few_rows", rows=rows, held=count)
    found[np.linspace(0, rows - 1, count).round().astype(np.intp)] = True
    return found


def _per_row(r: Floats) -> Floats:
    return np.sqrt((r**2).mean(axis=1))


def _rms(values: Floats) -> float:
    return float(np.sqrt((values**2).mean())) if values.size else 0.0


def calibrate_arm(
    robot: RobotLike, q: ArrayLike, measured: Measured, *, held_out: float = 0.2, angle_tolerance: float = 2e-2,
    length_tolerance: float = 1e-2,
) -> GeometricCalibration:  # fmt: skip
    """Calibrate an open arm: every joint frame may be displaced in its parent, and the tip in the last link.

    Six parameters for each frame, more than any motion can tell: those that it cannot are named, and stay.

    Args:
        robot: a Robot, Mechanism, library name or path, without loops.
        q: (k, n) coordinates at which was measured [rad | m].
        measured: what was measured of its tip.
        held_out: share of the rows that are predicted, not fitted.
        angle_tolerance, length_tolerance: how far frames may be off as described [rad, m].

    Reference: He, Zhao, Yang and Yang, Kinematic-parameter identification for serial-robot calibration based on POE
    formula, IEEE Trans. Robotics 26 (2010).
    """
    mechanism = as_robot(robot).mechanism
    value = as_batch("q", q, (mechanism.n,), finite=True)
    if value.shape != (measured.rows, mechanism.n):
        raise InputError("input.shape", name="q", expected=(measured.rows, mechanism.n), got=value.shape, hint="")
    path = chain_to_tip(mechanism)
    chain = [joint.name for joint in path if joint.moves]
    names = tuple(f"{frame}.{axis}" for frame in (*chain, "tip") for axis in ("rx", "ry", "rz", "x", "y", "z"))

    def correct(theta: Floats) -> Robot:
        *shifts, last = pose.exp(theta.reshape(-1, 6))
        shift = dict(zip(chain, shifts, strict=True))
        joints = tuple(
            replace(joint, T_pj=joint.T_pj @ shift[joint.name]) if joint.name in shift else joint
            for joint in mechanism.joints
        )
        return Robot(replace(mechanism, joints=joints, T_lt=mechanism.T_lt @ last))

    def predict(theta: Floats) -> tuple[Floats, Floats]:
        change = theta.reshape(-1, 6)
        T = np.broadcast_to(np.asarray(mechanism.T_sb), (len(value), 4, 4))
        columns: list[Floats] = []
        for each in path:
            T = T @ each.T_pj
            if each.moves:
                x = change[len(columns)]
                columns.append(pose.adjoint(T) @ rotation_slope(x))
                T = T @ pose.exp(x)
                T = T @ pose.exp(each.screw * _coordinate(mechanism, value, each)[:, None])
        columns.append(pose.adjoint(T @ mechanism.T_lt) @ rotation_slope(change[-1]))
        T = T @ mechanism.T_lt @ pose.exp(change[-1])
        D = np.concatenate(columns, axis=-1)
        D[:, 3:] += np.cross(D[:, :3], T[:, :3, 3][:, :, None], axis=1)
        return T, D

    both = [ANGLE("angle_tolerance", angle_tolerance), LENGTH("length_tolerance", length_tolerance)]
    scale = np.tile(np.repeat(both, 3), len(chain) + 1)
    return fit_geometry(names, scale, predict, measured, correct, held_out)


def rotation_slope(x: Floats) -> Floats:
    """(6, 6) body twist of exp(x) per change of x, to second order: 1 - ad(x) / 2 + ad(x)^2 / 6."""
    ad = np.zeros((6, 6))
    ad[:3, :3] = ad[3:, 3:] = rotation.hat(x[:3])
    ad[3:, :3] = rotation.hat(x[3:])
    return np.eye(6) - ad / 2 + ad @ ad / 6


def _coordinate(mechanism: Mechanism, q: Floats, joint: Joint) -> Floats:
    """(rows,) coordinate of a joint, of one that follows another too."""
    if joint.mimic is None:
        return q[:, mechanism.joint_names.index(joint.name)]
    return np.array([joint.mimic.value(v) for v in q[:, mechanism.joint_names.index(joint.mimic.leader)].tolist()])
