"""Robust laws on a sliding variable s: sliding mode after Slotine and Li, the min-max law after Spong.

With s = (v - qd) + L (u - q) and the rate qd_r = v + L (u - q), sliding mode is

    tau = M qdd_r + C qd_r + g + Kd s + K sat(s / width),    K_i = share sum_k |Y_ik p_k| + margin.

Y p are the model's efforts for (qd_r, qdd_r); whatever parameters within the share of p the arm has, its own efforts
differ by less than K - margin. So V = s' M s/2 falls at least by s' Kd s + margin |s| outside the boundary layer, and
inside |u - q| <= width / L in the end.

The min-max law meets the worst inertial parameters within a bound by the best answer to them. With s = qd_r - qd and Y
the regressor of Christoffel's C it is

    tau = Y (p + w) + Kd s,    w = share D x / max(|x|, width),    x = D Y' s,  D = diag |p|.

Of all parameters with |D^-1 (p_true - p)| <= share the worst add s' Y (p_true - p) = share |x| to V = s' M s/2, which
w takes away again outside the boundary layer; inside V rises by at most share width / 4:

    dV/dt <= -s' Kd s + share width / 4.

Reference: Slotine and Li, Applied Nonlinear Control, 1991, sec. 9.1 and ch. 7; Spong, On the robust control of robot
manipulators, IEEE Trans. Automatic Control 37, 1992; Leitmann, On the efficacy of nonlinear control in uncertain linear
systems, J. Dyn. Syst. Meas. Control 103, 1981.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, as_batch, positive, real_array, require_kind
from mafsil.control.laws.feedback import Gains, per_joint
from mafsil.control.laws.law import Law
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.robot import Robot, as_robot, of_robot
from mafsil.trajectory import Motion, Trajectory

SETTLING = 8.0
"""Time constants of the surface after which an error has died."""


@dataclass(frozen=True, eq=False, slots=True)
class SlidingMode:
    """A law that keeps |u - q| below width / L in the end, whatever the masses are within a share of the model's.

    Attributes:
        robot: the model.
        rates: (n,) L [1/s].
        damping: (n,) Kd [N m s/rad | N s/m].
        share: of every inertial parameter by which it may be wrong.
        margin: (n,) effort beyond what the share needs, for friction and disturbances [N m | N].
        width: (n,) of the boundary layer of s [rad/s | m/s]; a narrow one chatters.
    """

    robot: Robot
    rates: Floats
    damping: Floats
    share: float
    margin: Floats
    width: Floats

    @property
    def error_bound(self) -> Floats:
        """(n,) largest error in the end, width / L [rad | m]."""
        return self.width / self.rates

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N]."""
        known, bound, s = self.parts(q, qd, reference)
        return known + self.damping * s + bound * np.clip(s / self.width, -1.0, 1.0)

    def parts(self, q: JointVector, qd: JointVector, reference: Motion) -> tuple[Floats, Floats, Floats]:
        """Efforts of the model, the bound K and the distance s from the surface, (*batch, n) each.

        The Coriolis terms are those of Christoffel's symbols, symmetric in both rates: C(q, x) y is half of what
        c(x + y) has beyond c(x) and c(y).

        Args:
            q, qd: (*batch, n) state.
            reference: desired motion.
        """
        e = reference.u - q
        rate = reference.v + self.rates * e
        growth = reference.a + self.rates * (reference.v - qd)
        Y = christoffel_regressor(self.robot, q, qd, rate, growth)
        p = self.robot.inertial_parameters.reshape(-1)
        return (
            Y @ p + rotor_inertias(self.robot) * growth,
            self.share * (np.abs(Y) @ np.abs(p)) + self.margin,
            rate - qd,
        )

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self


def rotor_inertias(robot: Robot) -> Floats:
    """(n,) inertias of the rotors, as the joints feel them [kg m^2 | kg]."""
    joints = robot.mechanism.coordinates
    return np.array([0.0 if j.actuator is None else j.actuator.reflected_inertia for j in joints])


def christoffel_regressor(robot: Robot, q: JointVector, qd: JointVector, rate: Floats, growth: Floats) -> Floats:
    """(*batch, n, 10 L) Y with Y p = M growth + C(q, qd) rate + g for the inertial parameters p of all links.

    Args:
        robot: the model.
        q, qd: (*batch, n) state.
        rate, growth: (*batch, n) a rate and an acceleration other than those of the state.
    """
    still = np.zeros_like(rate)
    at_rest = robot.regressor(q, still, still)
    both, own, other = (robot.regressor(q, x, still) - at_rest for x in (qd + rate, qd + still, rate))
    found = robot.regressor(q, still, growth) + 0.5 * (both - own - other)
    return found.reshape(*found.shape[:-2], -1)


@of_robot
def sliding_mode(
    robot: Robot,
    *,
    share: float = 0.2,
    rate: ArrayLike = 10.0,
    damping: ArrayLike = 10.0,
    margin: ArrayLike = 1.0,
    width: ArrayLike = 0.02,
) -> SlidingMode:
    """Sliding mode control of an arm whose masses are known within a fraction.

    Args:
        robot: the model.
        share: of every mass, first moment and inertia by which it may be wrong, such as 0.2.
        rate: L, a number or (n,): how fast an error dies on the surface [1/s].
        damping: Kd, a number or (n,) [N m s/rad | N s/m].
        margin: effort for what the share does not cover, a number or (n,) [N m | N].
        width: of the boundary layer, a number or (n,) [rad/s | m/s].

    Raises:
        InputError: a wrong shape, a negative number, no width.
        ModelError: the robot has no masses.
    """
    part = float(real_array("share", share))
    if not 0.0 <= part < np.inf:
        raise InputError("input.range", name="share", value=part, low=0.0, high=np.inf)
    gains = Gains.of(robot.n, rate, damping)
    others = Gains.of(robot.n, margin, width)
    for name, values in (("rate", gains.kp), ("width", others.kd)):
        if not (values > 0.0).all():
            raise InputError("input.positive", name=name, value=float(values.min()))
    return SlidingMode(robot, gains.kp, gains.kd, part, others.kp, others.kd)


class SlidingStatus(Status):
    """Whether the guarantee of a sliding mode held along a motion."""

    GUARANTEED = ("control.sliding_guaranteed", True)
    BROKEN = ("control.sliding_broken", False)


@dataclass(frozen=True, eq=False, repr=False)
class SlidingCertificate(Answer, data="t needed bound distance error error_bound reached"):
    """Whether the bound K covered the true difference of model and arm at every moment of a motion.

    Attributes:
        status: GUARANTEED or BROKEN.
        t: (k,) times [s].
        needed: (k, n) efforts by which the arm differs from the model on the surface [N m | N].
        bound: (k, n) K [N m | N].
        distance: (k, n) s [rad/s | m/s].
        error: (n,) largest error from eight time constants after the surface was reached on; NaN if the motion ends
            before [rad | m].
        error_bound: (n,) width / L [rad | m].
        reached: when all joints came into the boundary layer to stay [s]; infinite if they did not.
    """

    status: SlidingStatus
    t: Floats
    needed: Floats
    bound: Floats
    distance: Floats
    error: Floats
    error_bound: Floats
    reached: float

    def explain(self, language: str | None = None) -> str:
        """The largest share of the bound that was needed, where and when."""
        share = np.abs(self.needed) / np.maximum(self.bound, LEAST_DIVISOR)
        k, joint = (int(each) for each in np.unravel_index(int(share.argmax()), share.shape))
        said = self.status.sentence(language, share=float(share[k, joint]), joint=joint + 1, time=float(self.t[k]))
        if self.status is SlidingStatus.BROKEN:
            return said
        worst = int((self.error / self.error_bound).argmax())
        end = "error" if np.isfinite(self.error[worst]) else "late" if np.isfinite(self.reached) else "not_reached"
        details = {"error": float(self.error[worst]), "limit": float(self.error_bound[worst]), "worst": worst + 1}
        return said + say(f"control.sliding_{end}", language=language, reached=self.reached, **details)


def sliding_certificate(
    law: SlidingMode, arm: Robot, trajectory: Trajectory, t: ArrayLike, q: ArrayLike, qd: ArrayLike
) -> SlidingCertificate:
    """The guarantee of a sliding mode compared with the true arm along a motion, such as a recorded one.

    Args:
        law: whose bound is looked at.
        arm: the true one.
        trajectory: the reference.
        t: (k,) times [s].
        q, qd: (k, n) motion.

    Raises:
        InputError: another law, wrong shapes.
    """
    arm = as_robot(arm)
    require_kind("law", law, "SlidingMode", "parts", "error_bound")
    n = law.robot.n
    times = as_batch("t", t, (), finite=True)
    x, v = as_batch("q", q, (n,), finite=True), as_batch("qd", qd, (n,), finite=True)
    wanted = trajectory.at(times)
    known, bound, s = law.parts(x, v, wanted)
    needed = replace(law, robot=arm).parts(x, v, wanted)[0] - known
    outside = np.flatnonzero((np.abs(s) > law.width).any(axis=1))
    first = 0 if not len(outside) else int(outside[-1]) + 1
    reached = float(times[first]) if first < len(times) else np.inf
    # On the surface errors die as exp(-L t): the bound holds some time constants after it was reached.
    settled = times > reached + SETTLING / law.rates.min()
    error = np.abs(wanted.u - x)[settled].max(axis=0) if settled.any() else np.full(n, np.nan)
    broken = (np.abs(needed) > bound).any()
    status = SlidingStatus.BROKEN if broken else SlidingStatus.GUARANTEED
    return SlidingCertificate(status, times, needed, bound, s, error, law.error_bound, reached)


@dataclass(frozen=True, eq=False, slots=True)
class MinMax:
    """A law whose error ends below a stated bound for all parameters within a ball about the model's.

    Attributes:
        robot: the model.
        rates: (n,) L [1/s].
        damping: (n,) Kd [N m s/rad | N s/m].
        share: radius of the ball: of all parameters together, in shares of themselves.
        width: of the boundary layer of |x| [N m/s | N/s].
    """

    robot: Robot
    rates: Floats
    damping: Floats
    share: float
    width: float

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N]."""
        e = reference.u - q
        rate = reference.v + self.rates * e
        growth = reference.a + self.rates * (reference.v - qd)
        s = rate - qd
        Y = christoffel_regressor(self.robot, q, qd, rate, growth)
        p = self.robot.inertial_parameters.reshape(-1)
        x = np.abs(p) * np.einsum("...nk,...n->...k", Y, s)
        length = np.linalg.norm(x, axis=-1, keepdims=True)
        w = self.share * np.abs(p) * x / np.maximum(length, self.width)
        return (Y @ (p + w)[..., None])[..., 0] + rotor_inertias(self.robot) * growth + self.damping * s

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self

    def surface_bound(self, q: ArrayLike, arm: Robot | None = None) -> float:
        """Length of s below which it ends, by the extreme inertias of an arm along a motion [rad/s | m/s].

        V falls where s' Kd s > share width / 4, so s ends within sqrt(share width / (4 kd)) sqrt(M_max / M_min).

        Args:
            q: (k, n) configurations that the motion passes.
            arm: the true one, whose inertias count; the model if None.
        """
        places = as_batch("q", q, (self.robot.n,), finite=True)
        if not places.size:
            raise InputError("input.shape", name="q", expected=f"(k, {self.robot.n}), k > 0", got=places.shape, hint="")
        inertias = np.linalg.eigvalsh((self.robot if arm is None else arm).mass_matrix(places))
        ratio = float(inertias.max()) / float(inertias.min())
        return float(np.sqrt(self.share * self.width / (4.0 * self.damping.min()) * ratio))

    def error_bound(self, q: ArrayLike, arm: Robot | None = None) -> Floats:
        """(n,) errors below which every joint ends: the bound of s over L [rad | m]; arguments as `surface_bound`."""
        return self.surface_bound(q, arm) / self.rates


@of_robot
def min_max(
    robot: Robot,
    *,
    share: float = 0.2,
    rate: ArrayLike = 10.0,
    damping: ArrayLike = 10.0,
    width: float = 1.0,
) -> MinMax:
    """A robust law for an arm whose inertial parameters lie in a ball about the model's.

    Args:
        robot: the model.
        share: radius of the ball: length of the relative errors of all masses, first moments and inertias together.
        rate: L, a number or (n,): how fast an error dies on the surface [1/s].
        damping: Kd, a number or (n,) [N m s/rad | N s/m].
        width: of the boundary layer [N m/s | N/s]; a narrow one chatters.

    Raises:
        InputError: a wrong shape, a negative number, no rate, damping or width.
        ModelError: the robot has no masses.
    """
    part = float(real_array("share", share))
    if not 0.0 <= part < np.inf:
        raise InputError("input.range", name="share", value=part, low=0.0, high=np.inf)
    rates = per_joint("rate", rate, robot.n, positive=True)
    return MinMax(robot, rates, per_joint("damping", damping, robot.n, positive=True), part, positive("width", width))
