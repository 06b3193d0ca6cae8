"""What an arm is for: poses, payload, cycle, obstacles; and the answers of one design, or of many at once.

One design is judged by the whole model: inverse kinematics with restarts, the robot's own kernels, flexible links,
collisions. Many designs are judged by kernels of the family (`mafsil.design.family`), every pose of every design a row
of one batch: the numbers of the two agree at the same configurations, which a test holds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import (
    Booleans,
    Floats,
    JointVector,
    PoseMatrix,
    Vector3,
    as_batch,
    frozen,
    not_negative,
    positive,
    whole,
)
from mafsil.collision import Checker, Scene
from mafsil.design.arm import ArmDesign, Design
from mafsil.design.elastic import FlexibleArm
from mafsil.design.family import ArmNumbers, configurations, reach_and_void
from mafsil.errors import FileError, InputError
from mafsil.fields import check_fields, or_none, vector
from mafsil.geometry import rotation
from mafsil.ik import solve_ik
from mafsil.mechanics.inertial_parameters import moved_parameters, parameters_of
from mafsil.messages import say
from mafsil.model import Inertial
from mafsil.model.loading import RobotLike
from mafsil.performance.statics import largest_payload
from mafsil.performance.velocity.scaling import ranges
from mafsil.robot import Robot
from mafsil.robot.compiled_robot import has_inertia

SAMPLES = 25
"""Moments of each leg of a cycle at which efforts are taken."""
MEASURES: dict[str, bool] = {
    "reached": True, "condition": True, "static_torque": False, "utilisation": False, "peak_torque": False,
    "rms_torque": False, "speed": False, "energy": False, "mass": False, "deflection": False, "frequency": True,
    "payload": True, "reach": True, "void": False, "singular_distance": True, "amplification": False,
}  # fmt: skip
"""What designs are judged by, and whether more is better."""
OF_JACOBIAN = ("condition", "singular_distance", "amplification")
IN_CYCLE = ("peak_torque", "rms_torque", "speed", "energy")


def _poses(name: str, value: Any) -> PoseMatrix:
    T = as_batch(name, value, (4, 4), finite=True)
    if T.ndim != 3 or not len(T):
        raise InputError("input.shape", name=name, expected="(poses, 4, 4)", got=T.shape, hint="")
    return frozen(T)


@dataclass(frozen=True, eq=False, slots=True)
class TaskSet:
    """What the tool shall do.

    Attributes:
        poses: (P, 4, 4) of the tool in {s}.
        task: what of them counts: `pose` or `position`.
        payload: mass at the tool [kg].
        centre: (3,) of its mass, in the tip frame [m].
        period: of the cycle through all poses and back to the first, every leg a fifth-degree motion from rest to rest
            of the same duration [s]; None: the poses are only held.
        characteristic_length: makes turns and translations comparable in the condition number [m]; None: that of the
            tool's velocity alone.
        scene: obstacles, for single designs.
    """

    poses: PoseMatrix
    task: Literal["pose", "position"] = "pose"
    payload: float = 0.0
    centre: Vector3 | tuple[float, float, float] = (0.0, 0.0, 0.0)
    period: float | None = None
    characteristic_length: float | None = None
    scene: Scene | None = None
    _numbers = check_fields(
        poses=_poses, payload=not_negative, centre=vector(3), period=or_none(positive),
        characteristic_length=or_none(positive),
    )  # fmt: skip

    def __post_init__(self) -> None:
        self._numbers()
        if self.task not in ("pose", "position"):
            raise InputError("input.choice", name="task", value=self.task, known="pose, position")

    @classmethod
    def of(cls, table: Mapping[str, Any], path: str = "<table>") -> TaskSet:
        """From plain data: `points` (x, y, z) or `poses` (x, y, z, roll, pitch, yaw), and the other attributes.

        Args:
            table: such as `[tasks]` of a file.
            path: of the file, for sentences.

        Raises:
            FileError: an unknown key, points and poses together, or neither.
            InputError: numbers that are none, or out of range.
        """
        given = dict(table)
        known = ("points", "poses", "payload", "centre", "period", "characteristic_length")
        for name in given:
            if name not in known:
                raise FileError("design.unknown_key", path=path, place=f"tasks.{name}", known=", ".join(known))
        if ("points" in given) == ("poses" in given):
            raise FileError("design.points_or_poses", path=path)
        columns = 3 if "points" in given else 6
        rows = as_batch(
            "points" if columns == 3 else "poses",
            given.pop("points", given.pop("poses", None)),
            (columns,),
            finite=True,
        )
        T = np.tile(np.eye(4), (*rows.shape[:-1], 1, 1))
        T[..., :3, 3] = rows[..., :3]
        if columns == 6:
            T[..., :3, :3] = rotation.from_rpy(rows[..., 3:])
        return cls(T, "position" if columns == 3 else "pose", **given)

    def loaded(self, robot: Robot) -> Robot:
        """A robot with the payload at its tool."""
        return robot.with_payload(self.payload, com=self.centre) if self.payload else robot

    def with_payload(self, arms: ArmNumbers) -> ArmNumbers:
        """Arms with the payload in their last body."""
        load = parameters_of(Inertial(self.payload, frozen(np.asarray(self.centre)), np.zeros((3, 3))))
        tips = arms.places[..., -1, :, :].reshape(-1, 4, 4)
        moved = np.array([moved_parameters(load, T[:3, :3], T[:3, 3]) for T in tips])
        bodies = arms.bodies.copy()
        bodies[..., -1, :] += moved.reshape(bodies[..., -1, :].shape)
        return replace(arms, bodies=bodies)


class EvaluationStatus(Status):
    """Whether a design does its tasks."""

    SERVES = ("design.serves", True)
    NOT_FOUND = ("design.not_reached", False)
    COLLIDES = ("design.collides", False)
    OVERLOADED = ("design.overloaded", False)


@dataclass(frozen=True, eq=False, repr=False)
class Evaluation(Answer, data="measures q reached condition torque deflection frequency payload collides peak rms"):
    """How a design does its tasks; true if all poses are reached, clear of obstacles, within the effort limits.

    Attributes:
        design: what was judged.
        q: (P, n) configurations; NaN where none was found.
        reached: (P,) whether one was found.
        collides: (P,) whether the arm meets an obstacle or itself there; no without a scene.
        gains: (P, 2) smallest and largest singular value of the tool's Jacobian: what its joints give and can give.
        torque: (P, n) static efforts with the payload [N m | N].
        payload: (P,) the largest mass that the effort limits allow [kg]; infinite without limits.
        deflection: (P,) of the tool under weight and payload [m].
        frequency: (P,) the lowest natural one with the payload [Hz]; infinite for a rigid arm.
        peak, rms, speed: (n,) efforts and rates of a cycle; NaN without one or with poses not reached.
        energy: mechanical work of the drives in a cycle, without what comes back [J].
        reach, void: largest and least distance of the tool from the shoulder, where the first two axes meet or are
            nearest to each other, that a search found [m].
    """

    design: Design
    q: JointVector
    reached: Booleans
    collides: Booleans
    gains: Floats
    torque: Floats
    payload: Floats
    deflection: Floats
    frequency: Floats
    peak: Floats
    rms: Floats
    speed: Floats
    energy: float
    reach: float
    void: float

    @property
    def status(self) -> EvaluationStatus:
        """What stands in the way, if anything."""
        if not self.reached.all():
            return EvaluationStatus.NOT_FOUND
        if self.collides.any():
            return EvaluationStatus.COLLIDES
        return EvaluationStatus.OVERLOADED if self.measures["utilisation"] > 1.0 else EvaluationStatus.SERVES

    @property
    def condition(self) -> Floats:
        """(P,) smallest over largest singular value of the tool's Jacobian."""
        return self.gains[:, 0] / self.gains[:, 1]

    @property
    def measures(self) -> dict[str, float]:
        """The worst of each over all poses, by the names of `MEASURES`."""
        with np.errstate(invalid="ignore"):
            used = np.abs(self.torque) / self.design.effort
        return {
            "reached": float(self.reached.mean()), "condition": _worst(self.condition, np.min),
            "static_torque": _worst(np.abs(self.torque), np.max), "utilisation": _worst(used, np.max),
            "peak_torque": float(self.peak.max()), "rms_torque": float(self.rms.max()),
            "speed": float(self.speed.max()), "energy": self.energy, "mass": self.design.mass,
            "deflection": _worst(self.deflection, np.max), "frequency": _worst(self.frequency, np.min),
            "payload": _worst(self.payload, np.min), "reach": self.reach, "void": self.void,
            "singular_distance": _worst(self.gains[:, 0], np.min), "amplification": _worst(self.gains[:, 1], np.max),
        }  # fmt: skip

    def explain(self, language: str | None = None) -> str:
        """Whether it serves, then every measure."""
        missed = [str(k) for k in np.flatnonzero(~self.reached)]
        struck = [str(k) for k in np.flatnonzero(self.collides)]
        measures = self.measures
        details = {
            "missed": ", ".join(missed), "count": len(self.reached), "struck": ", ".join(struck),
            "share": 100.0 * measures["utilisation"],
        }  # fmt: skip
        lines = [self.status.sentence(language, **details)]
        for name, value in measures.items():
            if np.isfinite(value):
                lines.append(say(f"design.measure_{name}", language=language, value=value))
        return "\n".join(lines)


def evaluate_arm(
    design: ArmDesign | RobotLike, tasks: TaskSet, *, q0: ArrayLike | None = None, seed: int = 0
) -> Evaluation:
    """`mafsil.design.evaluate` of an arm."""
    design = ArmDesign.of(design)
    robot = design.robot
    numbers = ArmNumbers.of(robot)
    far, near = reach_and_void(ArmNumbers.stack([numbers]), *(bound[None] for bound in ranges(robot)))
    rank = numbers.rank(tasks.characteristic_length is not None)
    if q0 is not None:
        given = as_batch("q0", q0, (robot.n,))
        q0 = np.where(np.isfinite(given), given, np.mean(ranges(robot), axis=0))
    found = solve_ik(robot, tasks.poses, q0, task=tasks.task, seed=seed)
    reached = np.asarray(found.solved)
    q = np.where(reached[:, None], found.nearest, np.nan)
    here = np.where(reached[:, None], q, 0.0)
    hollow = np.where(reached, 1.0, np.nan)
    loaded = tasks.loaded(robot)
    flexible = FlexibleArm(design, payload=tasks.payload, centre=tasks.centre)
    rests = np.linalg.norm(flexible.deflection(here)[:, 3:], axis=1)
    collides = np.zeros(len(q), dtype=np.bool_)
    if tasks.scene is not None:
        collides = np.asarray(Checker(robot, tasks.scene).in_collision(here)) & reached
    J = np.asarray(robot.jacobian_body(here))
    hung = np.full(len(q), np.inf)
    if np.any(robot.mechanism.gravity) and has_inertia(robot.mechanism):
        hung = np.asarray(largest_payload(robot, here, tasks.centre).largest)
    torque, period = _nothing, tasks.period if reached.all() else None
    if has_inertia(loaded.mechanism):
        torque = loaded.inverse_dynamics
    peak, rms, speed, energy = _cycle(torque, here, period)
    return Evaluation(
        design, q, reached, collides, gains(J, tasks, rank) * hollow[:, None],
        np.asarray(torque(here, 0.0 * here, 0.0 * here)) * hollow[:, None], hung * hollow,
        rests * hollow, flexible.frequencies(here, 1)[:, 0] * hollow, peak, rms, speed, float(energy),
        float(far[0]), float(near[0]),
    )  # fmt: skip


def _nothing(q: JointVector, qd: JointVector, qdd: JointVector) -> JointVector:
    """Efforts of an arm without masses."""
    return 0.0 * q


def measure_arms(
    designs: Sequence[ArmDesign], tasks: TaskSet, names: Sequence[str], *, seed: int = 0, starts: int = 1
) -> tuple[dict[str, Floats], JointVector]:
    """`mafsil.design.measure_designs` of arms, by the kernels of the family."""
    single = ArmNumbers.stack([ArmNumbers.of(design.robot) for design in designs])
    arms = single.spread()
    bounds = np.array([ranges(design.robot) for design in designs])
    rank = arms.rank(tasks.characteristic_length is not None)
    q = configurations(
        arms, tasks.poses, tasks.task, bounds[:, 0], bounds[:, 1], seed, whole("starts", starts, least=1, most=1000),
        lambda T, J: np.divide(*np.moveaxis(gains(J, tasks, rank), -1, 0)),
    )  # fmt: skip
    reached: Booleans = np.asarray(np.isfinite(q).all(axis=-1))
    here, hollow = np.where(reached[..., None], q, 0.0), np.where(reached.all(axis=-1), 1.0, np.nan)
    loaded, limits = tasks.with_payload(arms), np.array([design.robot.limits.effort for design in designs])[:, None]
    found: dict[str, Floats] = {"reached": np.asarray(reached.mean(axis=-1))}
    if set(OF_JACOBIAN) & set(names):
        least, most = np.moveaxis(gains(arms.pose_and_jacobian(here)[1], tasks, rank), -1, 0)
        worst = ((least / most).min(axis=-1), least.min(axis=-1), most.max(axis=-1))
        found |= {name: np.asarray(values) * hollow for name, values in zip(OF_JACOBIAN, worst, strict=True)}
    if {"static_torque", "utilisation"} & set(names):
        tau = np.abs(loaded.torque(here, 0.0 * here, 0.0 * here, np.zeros(6)))
        found["static_torque"] = np.asarray(tau.max(axis=(1, 2))) * hollow
        found["utilisation"] = np.asarray((tau / limits).max(axis=(1, 2))) * hollow
    if set(IN_CYCLE) & set(names):
        cycle = _cycle(partial(loaded.spread().torque, tip_wrench=np.zeros(6)), here, tasks.period)
        for name, values in zip(IN_CYCLE, cycle, strict=True):
            found[name] = (values if name == "energy" else np.asarray(values.max(axis=-1))) * hollow
    if {"reach", "void"} & set(names):
        found["reach"], found["void"] = reach_and_void(single, bounds[:, 0], bounds[:, 1])
    if "mass" in names:
        found["mass"] = np.array([design.mass for design in designs])
    for name in {"deflection", "frequency"} & set(names):
        bent = [_elastic(design, tasks, u, name) for design, u in zip(designs, here, strict=True)]
        found[name] = np.array(bent) * hollow
    return {name: found[name] for name in names}, q


def _elastic(design: ArmDesign, tasks: TaskSet, q: JointVector, name: str) -> float:
    arm = FlexibleArm(design, payload=tasks.payload, centre=tasks.centre)
    if name == "frequency":
        return float(arm.frequencies(q, 1).min())
    return float(np.linalg.norm(arm.deflection(q)[:, 3:], axis=1).max())


def gains(J: Floats, tasks: TaskSet, rank: int) -> Floats:
    """(..., 2) smallest and largest singular value of the tool's Jacobian.

    Args:
        J: (..., 6, n) body Jacobians.
        tasks: say whether turns count.
        rank: of the Jacobian in general: a plane arm has only so many singular values.
    """
    rows = J[..., 3:, :]
    if tasks.characteristic_length is not None:
        rows = np.concatenate([tasks.characteristic_length * J[..., :3, :], rows], axis=-2)
    values = np.linalg.svd(rows, compute_uv=False)
    return np.asarray(values[..., [rank - 1, 0]], dtype=np.float64)


def cycle_motion(q: JointVector, period: float) -> tuple[JointVector, JointVector, JointVector]:
    """Positions, rates and accelerations (..., P, SAMPLES, n) of the cycle through q (..., P, n).

    Every leg is q + (q' - q) (10 u^3 - 15 u^4 + 6 u^5).

    Args:
        q: configurations in order.
        period: of the whole cycle, the way back to the first included [s].
    """
    u = ((np.arange(SAMPLES) + 0.5) / SAMPLES)[:, None]
    leg = period / q.shape[-2]
    way = (np.roll(q, -1, axis=-2) - q)[..., None, :]
    at = q[..., None, :] + way * (10 * u**3 - 15 * u**4 + 6 * u**5)
    rate = way * (30 * u**2 - 60 * u**3 + 30 * u**4) / leg
    return at, rate, way * (60 * u - 180 * u**2 + 120 * u**3) / leg**2


def _cycle(
    torque: Callable[[Floats, Floats, Floats], Floats], q: JointVector, period: float | None
) -> tuple[Any, Any, Any, Any]:
    """Peak and rms efforts, largest rates (..., n) and work (...) of the cycle through q (..., P, n)."""
    if period is None:
        nothing = np.full((*q.shape[:-2], q.shape[-1]), np.nan)
        return nothing, nothing, nothing, nothing[..., 0]
    at, rate, acceleration = cycle_motion(q, period)
    tau, over = np.asarray(torque(at, rate, acceleration)), (-3, -2)
    work = np.maximum(tau * rate, 0.0).mean(axis=over).sum(axis=-1) * period
    return np.abs(tau).max(axis=over), np.sqrt((tau**2).mean(axis=over)), np.abs(rate).max(axis=over), work


def _worst(values: Floats, least: Any) -> float:
    kept = values[np.isfinite(values) | np.isposinf(values)]
    return float(least(kept)) if kept.size else float("nan")
