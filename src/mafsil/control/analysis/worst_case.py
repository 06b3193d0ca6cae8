"""The min-max law after Spong: the worst inertial parameters within a bound are met by the best answer to them.

With s = qd_r - qd, qd_r = v + L (u - q), and Y the regressor of Christoffel's C, the law is

    tau = Y (p + w) + Kd s,    w = share D x / max(|x|, width),    x = D Y' s,  D = diag |p|.

Of all parameters with |D^-1 (p_true - p)| <= share the worst add s' Y (p_true - p) = share |x| to V = s' M s/2, which
w takes away again outside the boundary layer; inside V rises by at most share width / 4:

    dV/dt <= -s' Kd s + share width / 4.

Reference: Spong, On the robust control of robot manipulators, IEEE Trans. Automatic Control 37, 1992; Leitmann, On the
efficacy of nonlinear control in uncertain linear systems, J. Dyn. Syst. Meas. Control 103, 1981.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, as_batch, positive, real_array
from mafsil.control.laws.gains import per_joint
from mafsil.control.laws.law import Law
from mafsil.control.laws.sliding_mode import christoffel_regressor, rotor_inertias
from mafsil.errors import InputError
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion


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
