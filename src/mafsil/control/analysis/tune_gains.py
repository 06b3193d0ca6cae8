"""Gain cards: the gains that sampling, delay and elastic joints allow, the worst pose, and what they assume.

The whole arm under PD of every joint (its gravity compensated) or under computed torque is, near a pose, a linear
system from sample to sample; its eigenvalues say how every mode is damped. The card holds the fastest gains whose least
damped mode, in any of many poses, keeps nine tenths of the damping that it would have without sampling and delay.
Whether every joint may be tuned for itself shows in how much the joints of the arm disturb each other.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, as_batch, not_negative, positive, whole
from mafsil.control.laws.feedback import Gains, per_joint
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.robot import Robot, of_robot

RANGE = np.pi
"""Configurations of joints without limits are taken from -RANGE .. RANGE [rad | m]."""
NONE = 1e-9
"""Coupling and spread below which there is none but rounding."""
SMALL = 0.1
"""Coupling, spread and share of gravity, each, up to which every joint can be controlled for itself."""
MOST_LATE = 200
"""Periods of delay: the matrices of a step grow with them."""
KEPT = 0.9
"""Share of the damping that sampling and delay may leave."""
SLOWEST, BISECTIONS = 1e-3, 40
"""Share of one radian a period at which sampling does not matter, and steps of the search."""
ELASTIC = 0.5
"""Share of the frequency of an elastic joint, its motor locked, up to which gains stay below its resonance."""
OSCILLATES = 1e-6
"""Share of the size of an eigenvalue by which it is off the real axis if its mode oscillates."""
GONE = 2.0
"""Decay over the delay and a period, as a logarithm, from which on a mode is of the efforts under way, not of the arm:
feedback that comes late makes no motion of the arm that dies faster than e^-1 within the delay."""


class GainLimit(Status):
    """The cause that limits a gain."""

    SAMPLING = ("control.gain_sampling", True)
    DELAY = ("control.gain_delay", True)
    ELASTICITY = ("control.gain_elasticity", True)
    NONE_STABLE = ("control.gain_none", False)


@dataclass(frozen=True, eq=False, repr=False)
class GainReport(
    Answer,
    data="law natural_frequency damping_ratio worst_pose frequency period delay poses kp=gains.kp kd=gains.kd",
):
    """Gains with what they promise and assume; true if there are some.

    Attributes:
        status: what limits them.
        law: `pd_gravity` or `computed_torque`.
        gains: of the law.
        natural_frequency: of every joint at the largest inertia that it has in the poses, the others locked [rad/s].
        damping_ratio: of the least damped mode in the worst pose.
        worst_pose: (n,) where that is [rad | m].
        mode: (2 n,) displacement and rates of that mode, the largest one.
        frequency: of that mode [rad/s].
        period, delay: of the law [s].
        poses: how many were looked at.
    """

    status: GainLimit
    law: str
    gains: Gains
    natural_frequency: float
    damping_ratio: float
    worst_pose: JointVector
    mode: Floats
    frequency: float
    period: float
    delay: float
    poses: int

    def explain(self, language: str | None = None) -> str:
        """The limit, the promise, the worst pose, and what is assumed."""
        pose = ", ".join(f"{each:.3g}" for each in self.worst_pose)
        return self.status.sentence(
            language, law=self.law, w=self.natural_frequency, zeta=self.damping_ratio, pose=pose,
            frequency=self.frequency, period=self.period, delay=self.delay, poses=self.poses,
        )  # fmt: skip


@of_robot
def tune_gains(
    robot: Robot,
    *,
    law: Literal["pd_gravity", "computed_torque"] = "pd_gravity",
    period: float = 1e-3,
    delay: float = 0.0,
    damping_ratio: float = 0.7,
    stiffness: ArrayLike | None = None,
    poses: int = 500,
    seed: int = 0,
) -> GainReport:
    """The fastest gains that sampling, delay and elastic joints allow, in all of many poses.

    1. Inertias in random poses within the limits; gains by the largest inertia of each joint.
    2. The least damping without sampling, in the worst pose.
    3. The largest natural frequency that keeps nine tenths of it, by bisection; elastic joints may lower it.

    Assumes masses as the model says, efforts within their limits, rates measured without noise.

    Args:
        robot: the model.
        law: whose gains are wanted.
        period: between two calls of the law [s].
        delay: from the measurement to the effort; counted in whole periods, upwards [s].
        damping_ratio: that is asked of every joint by itself.
        stiffness: (n,) of the joints; rigid where infinite, all of them if None [N m/rad | N/m].
        poses: how many are looked at.
        seed: of the poses.

    Raises:
        InputError: a number out of its range, an unknown law, wrong shapes.
    """
    h, zeta, count = positive("period", period), positive("damping_ratio", damping_ratio), whole("poses", poses, 1)
    if law not in ("pd_gravity", "computed_torque"):
        raise InputError("input.choice", name="law", value=law, known="pd_gravity, computed_torque")
    late = whole("delay / period", int(np.ceil(not_negative("delay", delay) / h - 1e-9)), most=MOST_LATE)
    # 1
    places = _places(robot, count, seed)
    M = np.asarray(robot.mass_matrix(places))
    largest = np.einsum("kii->ki", M).max(axis=0)
    weight = np.ones(robot.n) if law == "computed_torque" else largest
    loop = _Loop(np.broadcast_to(np.eye(robot.n), M.shape) if law == "computed_torque" else M, weight, zeta, h)
    # 2
    slow = SLOWEST / h / (1 + late)
    wanted = KEPT * float(loop.damping(slow, 0).min())
    # 3
    limit, w = GainLimit.SAMPLING, loop.fastest(slow, wanted, late)
    if late and loop.fastest(slow, wanted, 0) > w / KEPT:
        limit = GainLimit.DELAY
    if stiffness is not None:
        springs = as_batch("stiffness", stiffness, (robot.n,))
        elastic = ELASTIC * float(np.sqrt(springs / largest).min())
        limit, w = (GainLimit.ELASTICITY, elastic) if elastic < w else (limit, w)
    damping = loop.damping(w, late)
    worst = int(damping.argmin())
    if not wanted > 0.0 or not damping[worst] > 0.0:
        limit = GainLimit.NONE_STABLE
    frequency, mode = loop.mode(w, late, worst)
    gains = Gains.of(robot.n, w * w * weight, 2.0 * zeta * w * weight)
    return GainReport(limit, law, gains, w, float(damping[worst]), places[worst], mode, frequency, h, late * h, count)


class _Loop:
    """The arm under PD from sample to sample, in many poses.

    Args:
        M: (k, n, n) mass matrices.
        weight: (n,) inertias that the gains are made for.
        zeta: damping ratio of the gains.
        period: [s].
    """

    def __init__(self, M: Floats, weight: Floats, zeta: float, period: float) -> None:
        self._inverse: Floats = np.asarray(np.linalg.inv(M), dtype=np.float64)
        self._weight, self._zeta, self._period = weight, zeta, period

    def matrices(self, w: float, late: int) -> Floats:
        """(k, m, m) steps of (q, qd, efforts under way): x+ = x + h v + h^2/2 a, v+ = v + h a, a = M^-1 u."""
        h, n = self._period, len(self._weight)
        k, size = len(self._inverse), n * (2 + late)
        push = np.concatenate([h * h / 2.0 * self._inverse, h * self._inverse], axis=1)
        law = -np.concatenate([np.diag(w * w * self._weight), np.diag(2.0 * self._zeta * w * self._weight)], axis=1)
        A = np.zeros((k, size, size))
        A[:, : 2 * n, : 2 * n] = np.eye(2 * n)
        A[:, :n, n : 2 * n] = h * np.eye(n)
        if not late:
            A += push @ law
            return A
        A[:, : 2 * n, 2 * n : 3 * n] = push
        A[:, 2 * n : -n, 3 * n :] = np.eye(n * (late - 1))
        A[:, -n:, : 2 * n] = law
        return A

    def damping(self, w: float, late: int) -> Floats:
        """(k,) least damping ratio of the oscillating modes; negative where one grows, one where none oscillates."""
        return self._ratios(np.linalg.eigvals(self.matrices(w, late)), late).min(axis=-1)

    def fastest(self, slow: float, wanted: float, late: int) -> float:
        """The largest frequency from slow on whose damping is at least what is wanted."""
        low, high = slow, slow
        while high * self._period < np.pi and float(self.damping(high, late).min()) >= wanted:
            low, high = high, 2.0 * high
        for _ in range(BISECTIONS):
            middle = (low * high) ** 0.5
            low, high = (middle, high) if float(self.damping(middle, late).min()) >= wanted else (low, middle)
        return low

    def mode(self, w: float, late: int, pose: int) -> tuple[float, Floats]:
        """Frequency [rad/s] and (2 n,) real part of the least damped mode in a pose, its largest displacement one."""
        values, vectors = np.linalg.eig(self.matrices(w, late)[pose])
        k = int(self._ratios(values, late).argmin())
        found = vectors[: 2 * len(self._weight), k]
        largest = found[: len(self._weight)]
        found = found / largest[int(np.abs(largest).argmax())]
        return float(np.abs(np.log(values[k])) / self._period), np.asarray(found.real)

    def _ratios(self, z: Any, late: int) -> Floats:
        """Damping ratios of eigenvalues from sample to sample; one of those that no motion of the arm shows."""
        size = np.maximum(np.abs(z), LEAST_DIVISOR)
        decay, turn = -np.log(size), np.abs(np.angle(z))
        # A real negative eigenvalue alternates from sample to sample: it oscillates as fast as sampling can show.
        ratio = decay / np.maximum(np.hypot(decay, turn), LEAST_DIVISOR)
        gone = (decay * (late + 1) > GONE) if late else np.zeros_like(size, dtype=np.bool_)
        return np.where(((turn > OSCILLATES) | (size > 1.0)) & ~gone, ratio, 1.0)


def _places(robot: Robot, count: int, seed: int) -> JointVector:
    """(count, n) random coordinates within the limits."""
    limits = robot.limits
    low = np.where(np.isfinite(limits.lower), limits.lower, -np.pi)
    high = np.where(np.isfinite(limits.upper), limits.upper, np.pi)
    return low + np.random.default_rng(seed).random((count, robot.n)) * (high - low)


class CouplingStatus(Status):
    """Whether joints can be controlled each for itself."""

    DECOUPLED = ("control.coupling_none", True)
    WEAK = ("control.coupling_weak", True)
    STRONG = ("control.coupling_strong", False)
    GRAVITY = ("control.coupling_gravity", False)


@dataclass(frozen=True, eq=False, repr=False)
class JointCoupling(Answer, data="coupling spread gravity_share samples"):
    """The inertias that a joint feels of the others; true if decentralised control is sensible.

    Attributes:
        status: none (a Cartesian arm), weak (within the thresholds) or strong; or gravity alone is too large.
        coupling: (n,) largest sum_j |M_ij| / M_ii over the configurations, j other than i.
        spread: (n,) largest deviation of M_ii from its mean, as share of it.
        gravity_share: (n,) largest |g_i| as share of the limit of effort; NaN where there is none.
        samples: configurations that were looked at: the figures are lower bounds.
    """

    status: CouplingStatus
    coupling: Floats
    spread: Floats
    gravity_share: Floats
    samples: int

    def explain(self, language: str | None = None) -> str:
        """The status with its figures."""
        details = {"coupling": float(self.coupling.max()), "spread": float(self.spread.max()), "samples": self.samples}
        if self.status is CouplingStatus.GRAVITY:
            joint = int(np.nanargmax(self.gravity_share))
            said = self.status.sentence(language, joint=joint, share=float(self.gravity_share[joint]))
            return said + say("control.coupling_figures", language=language, **details)
        return self.status.sentence(language) + say("control.coupling_figures", language=language, **details)


@of_robot
def joint_coupling(
    robot: Robot,
    samples: int = 2000,
    *,
    seed: int = 0,
    coupling: float = SMALL,
    spread: float = SMALL,
    gravity_share: float = SMALL,
) -> JointCoupling:
    """How far the mass matrix, rotors included, is from a constant diagonal.

    Args:
        robot: its model; gears enter by the reflected inertia of their rotors.
        samples: random configurations within the limits.
        seed: of these.
        coupling, spread, gravity_share: the largest of each that still lets every joint be controlled for itself.

    Raises:
        InputError: a threshold that is not finite or negative.
        ModelError: the robot has no masses.

    Reference: Lynch and Park, Modern Robotics, sec. 11.4.1; Siciliano et al., Robotics, sec. 8.3.
    """
    count = whole("samples", samples, least=1)
    limits = {"coupling": coupling, "spread": spread, "gravity_share": gravity_share}
    most = {name: float(per_joint(name, value, 1)[0]) for name, value in limits.items()}
    low, high = (np.clip(side, -RANGE, RANGE) for side in (robot.limits.lower, robot.limits.upper))
    q = np.random.default_rng(seed).uniform(low, high, (count, robot.n))
    M = robot.mass_matrix(q)
    own = np.diagonal(M, axis1=-2, axis2=-1)
    others = np.abs(M).sum(axis=-1) - np.abs(own)
    disturbed = (others / own).max(axis=0)
    varied = (np.abs(own - own.mean(axis=0)) / own.mean(axis=0)).max(axis=0)
    g = np.abs(robot.gravity_torque(q)).max(axis=0)
    limit = robot.limits.effort
    share = np.divide(g, limit, out=np.full(robot.n, np.nan), where=np.isfinite(limit) & (limit > 0.0))
    worst = float(disturbed.max()), float(varied.max())
    if worst[0] > most["coupling"] or worst[1] > most["spread"]:
        status = CouplingStatus.STRONG
    elif bool((share > most["gravity_share"]).any()):
        status = CouplingStatus.GRAVITY
    else:
        status = CouplingStatus.DECOUPLED if max(worst) < NONE else CouplingStatus.WEAK
    return JointCoupling(status, disturbed, varied, share, count)
