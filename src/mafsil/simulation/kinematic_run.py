"""A motion passed exactly as it is planned: a recording without masses, laws and forces."""

from __future__ import annotations

from math import ceil

import numpy as np

from mafsil.robot import Robot
from mafsil.simulation.recording import Recording, SimulationStatus
from mafsil.simulation.stored_arrays import KINEMATIC
from mafsil.simulation.tolerances import PART_OF_STEP
from mafsil.trajectory import Trajectory
from mafsil.version import __version__


def as_planned(robot: Robot, trajectory: Trajectory, period: float) -> Recording:
    """The recording of an arm that follows its trajectory exactly; its efforts are NaN, for nothing is known of them.

    Args:
        robot: whose joints move; it needs no masses.
        trajectory: of all its joints.
        period: between rows [s].
    """
    t = np.arange(ceil(trajectory.duration / period - PART_OF_STEP) + 1.0) * period
    q, qd, qdd = trajectory.at(t)
    unknown, zero = np.full_like(q, np.nan), np.zeros(len(t))
    metadata = {
        "version": __version__, "robot": robot.name, "plant": KINEMATIC, "joints": list(robot.joint_names),
        "integrator": KINEMATIC, "step": period, "period": period, "end": float(t[-1]), "saturate": False,
        "noise_seed": None, "friction_stiffness": 0.0, "fused": False, "law": "", "fault": "", "seconds": 0.0,
    }  # fmt: skip
    return Recording(
        t=t, q=q, qd=qd, qdd=qdd, q_ref=q, qd_ref=qd, qdd_ref=qdd, tau=unknown, tau_commanded=unknown,
        tip_position_error=zero, tip_rotation_error=zero, status=SimulationStatus.COMPLETED, metadata=metadata,
    )  # fmt: skip
