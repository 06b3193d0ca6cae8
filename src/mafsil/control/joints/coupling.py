"""How much the joints of an arm disturb each other: whether every joint can be controlled for itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, whole
from mafsil.control.laws.gains import per_joint
from mafsil.messages import say
from mafsil.robot import Robot, of_robot

RANGE = np.pi
"""Configurations of joints without limits are taken from -RANGE .. RANGE [rad | m]."""
NONE = 1e-9
"""Coupling and spread below which there is none but rounding."""
SMALL = 0.1
"""Coupling, spread and share of gravity, each, up to which every joint can be controlled for itself."""


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
