"""Accuracy at the tool from tolerances: first order and Monte Carlo side by side, shares of causes.

Every cause is a small motion e_k of a joint's frame: the tool moves by J_k e_k, with J_k its axis seen from the tool.
With independent causes the covariance of the tool is the sum of J_k J_k' sigma_k^2. Causes and their distributions:

    encoder      uniform over one resolution: sigma = r / sqrt(12)
    backlash     uniform over the free play b: sigma = b / sqrt(12)
    zero, length, angle    +- t at three standard deviations: sigma = t / 3
    temperature  +- T at three standard deviations, one number for the whole arm: links grow by expansion T
    deflection   a known bias, which the compliance's own uncertainty +- s (three standard deviations) scales

Encoder and backlash differ from visit to visit: they make up repeatability. All together make up accuracy.

Reference: Mooring, Roth & Driels, Fundamentals of Manipulator Calibration, 1991, ch. 2; ISO 9283.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, PoseMatrix, as_batch, not_negative, spread, whole
from mafsil.design.arm import ArmDesign
from mafsil.design.elastic import FlexibleArm
from mafsil.design.family import ArmNumbers
from mafsil.errors import InputError
from mafsil.fields import check_fields, finite
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import pose
from mafsil.messages import say
from mafsil.model.loading import RobotLike
from mafsil.model.placement import adjoint

UNIFORM, LIMIT = sqrt(12.0), 3.0
"""Width of a distribution in standard deviations: of a uniform one, and on either side of a toleranced one."""
AGREES = 0.1
"""Share by which the first order's standard deviation may differ from that of the samples."""
REPEATED = ("encoder", "backlash")
"""Causes that differ from visit to visit."""
CHI2_95 = 7.814727903251179
"""95 % quantile of the chi-square distribution with three degrees of freedom."""
_AMOUNT = finite(0, 1, low=0.0)


@dataclass(frozen=True, eq=False, slots=True)
class Tolerances:
    """What is not exact; one number for all, or one for each joint (`length`, `angle`: for the tool too).

    Attributes:
        encoder: resolution, seen at the joint [rad | m].
        backlash: whole free play at the joint [rad | m].
        zero: +- of the joint's zero position [rad | m].
        length: +- of a joint frame's position in the link before it, along each axis [m].
        angle: +- of the direction of a joint's axis, about each axis across it [rad].
        temperature: +- from the temperature of calibration [K].
        expansion: of the link that leads to a joint, and of that to the tool [1/K]; that of its tube if it has one.
        stiffness: +- of the compliance, as share of it.
    """

    encoder: ArrayLike = 0.0
    backlash: ArrayLike = 0.0
    zero: ArrayLike = 0.0
    length: ArrayLike = 0.0
    angle: ArrayLike = 0.0
    temperature: float = 0.0
    expansion: ArrayLike = 0.0
    stiffness: float = 0.0
    __post_init__ = check_fields(
        encoder=_AMOUNT, backlash=_AMOUNT, zero=_AMOUNT, length=_AMOUNT, angle=_AMOUNT,
        temperature=not_negative, expansion=finite(0, 1), stiffness=not_negative,
    )  # fmt: skip


class AccuracyStatus(Status):
    """Whether the first order holds, by the samples."""

    AGREES = ("design.first_order_agrees", True)
    DIFFERS = ("design.first_order_differs", False)
    UNCHECKED = ("design.first_order_unchecked", True)


@dataclass(frozen=True, eq=False, repr=False)
class Accuracy(
    Answer, data="rms repeatability bias covariance axes directions shares pays_most sampled_rms sampled_radius inside"
):
    """The error of the tool at one configuration; true unless samples contradict the first order.

    Attributes:
        q: (n,) configuration.
        labels: (k,) of the causes, such as `length joint2 x`.
        columns: (6, k) motion (rotation, translation) of the tool for one standard deviation of each, in {s}.
        bias: (6,) known error (deflection) [rad, m], in {s}.
        samples: (N, 6) errors of sampled arms less the bias, in {s}; empty without sampling.
    """

    q: JointVector
    labels: tuple[str, ...]
    columns: Floats
    bias: Floats
    samples: Floats

    @property
    def status(self) -> AccuracyStatus:
        """Whether the standard deviations of first order are those of the samples."""
        if not len(self.samples):
            return AccuracyStatus.UNCHECKED
        first, sampled = (np.sqrt(np.linalg.eigvalsh(C[3:, 3:])) for C in (self.covariance, self.sampled_covariance))
        # An ellipsoid may be flat: axes are judged beside the largest.
        apart = float(np.abs(first - sampled).max())
        return AccuracyStatus.AGREES if apart <= AGREES * float(first[-1]) else AccuracyStatus.DIFFERS

    @property
    def covariance(self) -> Floats:
        """(6, 6) of the tool's error (rotation, translation), in {s} [rad^2, rad m, m^2]."""
        return self.columns @ self.columns.T

    @property
    def sampled_covariance(self) -> Floats:
        """(6, 6) the same from the samples, about their mean."""
        away = self.samples - self.samples.mean(axis=0)
        return away.T @ away / max(len(away) - 1, 1)

    @property
    def rms(self) -> float:
        """Root mean square of the distance from where the tool should be, without bias [m]."""
        return sqrt(float(np.trace(self.covariance[3:, 3:])))

    @property
    def repeatability(self) -> float:
        """The same of the causes that differ from visit to visit alone [m]."""
        own = [k for k, label in enumerate(self.labels) if label.split()[0] in REPEATED]
        return float(np.linalg.norm(self.columns[3:, own]))

    @property
    def axes(self) -> Floats:
        """(3,) semi-axes of the ellipsoid that holds 95 % of the positions, the longest first [m]."""
        return np.sqrt(CHI2_95 * np.maximum(np.linalg.eigvalsh(self.covariance[3:, 3:])[::-1], 0.0))

    @property
    def directions(self) -> Floats:
        """(3, 3) their directions as columns, in {s}."""
        return np.linalg.eigh(self.covariance[3:, 3:])[1][:, ::-1]

    @property
    def variances(self) -> dict[str, float]:
        """Variance of the position that each cause adds, the largest first [m^2]."""
        added = dict(zip(self.labels, (self.columns[3:] ** 2).sum(axis=0).tolist(), strict=True))
        return dict(sorted(added.items(), key=lambda pair: -pair[1]))

    def _shares(self, words: int) -> dict[str, float]:
        """Shares of the variance by the first words of the labels, the largest first."""
        total, whole_sum = dict[str, float](), sum(self.variances.values()) or 1.0
        for label, value in self.variances.items():
            name = " ".join(label.split()[:words])
            total[name] = total.get(name, 0.0) + value / whole_sum
        return dict(sorted(total.items(), key=lambda pair: -pair[1]))

    @property
    def shares(self) -> dict[str, float]:
        """Share of the variance by kind of cause, the largest first."""
        return self._shares(1)

    @property
    def pays_most(self) -> str:
        """The tolerance of one joint with the largest share: halving it gains most; empty without any."""
        return next(iter(self._shares(2)), "")

    @property
    def sampled_rms(self) -> float:
        """Root mean square of the distance, by the samples; NaN without any [m]."""
        return float(np.sqrt((self.samples[:, 3:] ** 2).sum(axis=1).mean())) if len(self.samples) else float("nan")

    @property
    def sampled_radius(self) -> float:
        """Distance that 95 % of the samples keep to; NaN without any [m]."""
        distances = np.linalg.norm(self.samples[:, 3:], axis=1)
        return float(np.quantile(distances, 0.95)) if len(distances) else float("nan")

    @property
    def inside(self) -> float:
        """Share of the samples inside the ellipsoid of 95 %; NaN without any."""
        if not len(self.samples):
            return float("nan")
        long = self.axes > 1e-9 * max(float(self.axes[0]), LEAST_DIVISOR)
        along = (self.samples[:, 3:] @ self.directions)[:, long] / self.axes[long]
        return float(((along**2).sum(axis=1) <= 1.0).mean())

    def explain(self, language: str | None = None) -> str:
        """The error in numbers, where it comes from, and whether samples confirm it."""
        numbers = {"rms": 1e3 * self.rms, "repeatability": 1e3 * self.repeatability}
        bias = 1e3 * float(np.linalg.norm(self.bias[3:]))
        lines = [say("design.accuracy", language=language, **numbers, bias=bias)]
        lines.append(say("design.ellipsoid", language=language, axes=", ".join(f"{1e3 * a:.3g}" for a in self.axes)))
        for kind, share in self.shares.items():
            lines.append(say("design.share", language=language, kind=kind, share=100.0 * share))
        if self.pays_most:
            share = 100.0 * self._shares(2)[self.pays_most]
            lines.append(say("design.pays_most", language=language, name=self.pays_most, share=share))
        details = {"rms": 1e3 * self.sampled_rms, "inside": 100.0 * self.inside, "count": len(self.samples)}
        return "\n".join([*lines, self.status.sentence(language, **details)])


def accuracy(
    robot: RobotLike | ArmDesign,
    q: ArrayLike,
    tolerances: Tolerances,
    *,
    payload: float = 0.0,
    samples: int = 0,
    seed: int = 0,
) -> Accuracy:
    """The error of the tool that tolerances give at a configuration.

    Args:
        robot: the arm; of a design its tubes and gears deflect and grow too.
        q: (n,) configuration [rad | m].
        tolerances: what is not exact.
        payload: mass at the tip for the deflection [kg].
        samples: arms with drawn errors whose kinematics is computed exactly, to hold against the first order.
        seed: of the draws; equal seeds give equal results.

    Raises:
        InputError: tolerances for another number of joints, no serial chain, a number out of its range.
    """
    design = ArmDesign.of(robot)
    arm = design.robot
    numbers, u = ArmNumbers.of(arm), as_batch("q", q, (arm.n,), finite=True)
    if u.ndim != 1:
        raise InputError("input.shape", name="q", expected=(arm.n,), got=u.shape, hint="")
    count, payload = whole("samples", samples, least=0), not_negative("payload", payload)
    causes = Causes.of(numbers, arm.joint_names, tolerances, design)
    bias = FlexibleArm(design, payload=payload).deflection(u)
    nominal, _ = numbers.pose_and_jacobian(u)
    columns = causes.columns(u, nominal)
    labels = causes.labels
    if tolerances.stiffness and bias.any():
        labels, columns = (*labels, "stiffness"), np.column_stack([columns, tolerances.stiffness / LIMIT * bias])
    drawn = np.zeros((0, 6))
    if count:
        rng = np.random.default_rng(whole("seed", seed, least=0))
        drawn = causes.draw(u, nominal, rng, count)
        if len(labels) > len(causes.labels):
            drawn = drawn + rng.normal(size=(count, 1)) * columns[:, -1]
    return Accuracy(u, labels, columns, bias, drawn)


@dataclass(frozen=True, eq=False, slots=True)
class Causes:
    """Independent errors of an arm, each a motion of one of its frames, before or after the joint moves.

    Attributes:
        numbers: of the arm.
        labels: of the errors.
        frame: (k,) which of the n + 1 frames moves.
        axes: (k, 6) along which (rotation, translation), in that frame.
        sigma: (k,) standard deviations.
        uniform: (k,) whether the error is uniform.
        growth: (n + 1, 3) growth of each link per standard deviation of the temperature [m], in the frame before.
    """

    numbers: ArmNumbers
    labels: tuple[str, ...]
    frame: Any
    axes: Floats
    sigma: Floats
    uniform: Any
    growth: Floats

    @staticmethod
    def of(numbers: ArmNumbers, names: tuple[str, ...], given: Tolerances, design: ArmDesign) -> Causes:
        """Those of an arm."""
        n = numbers.n
        amounts = {field.name: spread(field.name, getattr(given, field.name), (n,)) for field in fields(given)[:3]} | {
            name: for_frames(name, getattr(given, name), n) for name in ("length", "angle", "expansion")
        }
        rows = list[tuple[str, int, int, float, bool]]()
        for k in range(n):
            along = 2 if numbers.kinds[k][0] != "prismatic" else 5
            for kind, width in (("encoder", UNIFORM), ("backlash", UNIFORM), ("zero", LIMIT)):
                rows.append((f"{kind} {names[k]}", k, along, amounts[kind][k] / width, kind in REPEATED))
        for k, name in enumerate((*names, "tool")):
            for axis, letter in enumerate("xyz"):
                rows.append((f"length {name} {letter}", k, 3 + axis, amounts["length"][k] / LIMIT, False))
            for axis, letter in enumerate("xy"):
                rows.append((f"angle {name} {letter}", k, axis, amounts["angle"][k] / LIMIT, False))
        rows = [row for row in rows if row[3] > 0.0]
        labels, frame, axis, sigma, uniform = zip(*rows, strict=True) if rows else ((), (), (), (), ())
        expansion = np.array(amounts["expansion"])
        for k, tube in enumerate(design.tubes):
            if tube is not None:
                expansion[k + 1] = tube.material.expansion
        growth = (given.temperature / LIMIT) * expansion[:, None] * numbers.places[:, :3, 3]
        axes = np.eye(6)[list(axis)].reshape(-1, 6)
        return Causes(
            numbers,
            (*map(str, labels), *(("temperature",) if growth.any() else ())),
            np.array(frame, dtype=np.int64), axes, np.array(sigma, dtype=np.float64),
            np.array(uniform, dtype=np.bool_), growth,
        )  # fmt: skip

    def columns(self, q: JointVector, nominal: PoseMatrix) -> Floats:
        """(6, k) motion of the tool for one standard deviation of each, axes of {s} at the tool's origin."""
        frames = self._frames(q)
        turned = [adjoint(np.linalg.inv(nominal) @ frames[k]) for k in range(len(frames))]
        body: list[Floats] = [self.sigma[i] * turned[k] @ self.axes[i] for i, k in enumerate(self.frame)]
        if self.growth.any():
            # A link grows in the axes of the frame before it; its own frame has not turned by its joint.
            T_frames = self.numbers.places[:, :3, :3]
            grown = [turned[k] @ [0, 0, 0, *(T_frames[k].T @ self.growth[k])] for k in range(len(frames))]
            body.append(np.sum(grown, axis=0))
        R = nominal[:3, :3]
        both = np.array(body).reshape(-1, 2, 3) @ R.T
        return both.reshape(-1, 6).T

    def _frames(self, q: JointVector) -> PoseMatrix:
        """(n + 1, 4, 4) frames in {s} before their joints move, and the tool's."""
        return np.stack([_chain(self.numbers, q, k) for k in range(self.numbers.n + 1)])

    def draw(self, q: JointVector, nominal: PoseMatrix, rng: np.random.Generator, count: int) -> Floats:
        """(count, 6) errors of arms with drawn errors, exact kinematics, axes of {s}."""
        k = len(self.sigma)
        normal, flat = rng.normal(size=(count, k)), rng.uniform(-sqrt(3.0), sqrt(3.0), (count, k))
        errors = np.where(self.uniform, flat, normal) * self.sigma
        moves = np.zeros((count, self.numbers.n + 1, 6))
        for i, frame in enumerate(self.frame):
            moves[:, frame] += errors[:, i, None] * self.axes[i]
        places = np.broadcast_to(self.numbers.places, (count, *self.numbers.places.shape)).copy()
        places[..., :3, 3] += rng.normal(size=(count, 1, 1)) * self.growth
        exact = ArmNumbers(
            self.numbers.kinds, places @ pose.exp(moves), self.numbers.bodies, self.numbers.armature,
            self.numbers.gravity,
        )  # fmt: skip
        T, _ = exact.pose_and_jacobian(q)
        turn = pose.error(nominal, T)[:, :3] @ nominal[:3, :3].T
        return np.concatenate([turn, T[:, :3, 3] - nominal[:3, 3]], axis=1)


def for_frames(name: str, value: ArrayLike, n: int) -> Floats:
    """(n + 1,) one for each joint's frame and the tool's; of n numbers the tool has none."""
    given = np.asarray(value, dtype=np.float64)
    return np.append(given, 0.0) if given.shape == (n,) else spread(name, given, (n + 1,))


def _chain(numbers: ArmNumbers, q: JointVector, k: int) -> PoseMatrix:
    """Pose in {s} of frame k before its joint moves."""
    T = np.eye(4)
    for j in range(k):
        kind, pitch = numbers.kinds[j]
        turns, slides = (0.0, 1.0) if kind == "prismatic" else (1.0, pitch)
        T = T @ numbers.places[j] @ pose.exp(np.array([0.0, 0.0, turns, 0.0, 0.0, slides]) * q[j])
    return T @ numbers.places[k]
