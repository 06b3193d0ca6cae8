"""Whether a law is stable along a planned motion: by how much small errors grow from tick to tick, at worst."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.control import CurrentLoop, Delayed, Law
from mafsil.errors import MafsilError
from mafsil.job.causes import error_growth
from mafsil.job.stretch import Driven
from mafsil.simulation import Plant
from mafsil.trajectory import Motion

PLACES = 9
"""Along a stretch, where it is looked."""
ASIDE = 1e-6
"""Of positions and rates in differences [rad | m], [rad/s | m/s]."""


def growth_along(driven: Driven) -> float:
    """The largest factor by which small errors change from one evaluation of the law to the next, along a stretch.

    Of computed torque and joint feedback from their gains; of other laws of the joints from differences of the closed
    loop x+ = x + h v + h^2/2 a, v+ = v + h a, with viscous friction and without delay.

    Args:
        driven: a stretch under its law.

    Returns:
        Above one where the loop is unstable; NaN of laws that have no slope, or are not defined for a batch of states.
    """
    trajectory = driven.stretch.trajectory
    times = np.linspace(0.0, trajectory.duration, PLACES)
    found = [error_growth(driven, trajectory.at(t).u) for t in times]
    if max(found) > 0.0:
        return max(found)
    law = _inside(driven.scenario.law)
    try:
        return max(_by_differences(driven, law, float(t), Motion(*trajectory.at(t))) for t in times)
    except (MafsilError, ValueError, TypeError, np.linalg.LinAlgError):
        return float("nan")


def _inside(law: Law) -> Law:
    return _inside(law.law) if isinstance(law, Delayed | CurrentLoop) else law


def _by_differences(driven: Driven, law: Law, t: float, reference: Motion) -> float:
    """At one place; the arm is where it should be, moving as it should."""
    scenario = driven.scenario
    n, h = scenario.robot.n, scenario.control_period
    plant = Plant(scenario.true_plant.robot, friction=False)
    aside = ASIDE * np.concatenate([np.eye(2 * n), -np.eye(2 * n)])
    q, qd = reference.u + aside[:, :n], reference.v + aside[:, n:]
    there = Motion(*(np.broadcast_to(part, q.shape) for part in reference))
    a = plant.acceleration(q, qd, np.asarray(law(t, q, qd, there)))
    slope: Floats = (a[: 2 * n] - a[2 * n :]).T / (2.0 * ASIDE)
    if scenario.true_plant.has_friction:
        friction = scenario.true_plant.friction_law
        viscous = friction.gain.T @ (friction.viscous[:, None] * friction.gain)
        slope[:, n:] -= np.linalg.solve(plant.robot.mass_matrix(reference.u), viscous)
    one, both = np.eye(n), np.eye(2 * n)
    drift = np.concatenate([one, h * one], axis=1)
    step = np.concatenate([drift + h * h / 2.0 * slope, both[n:] + h * slope])
    return float(np.abs(np.linalg.eigvals(step)).max())
