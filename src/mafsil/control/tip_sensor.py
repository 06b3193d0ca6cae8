"""A force and torque sensor at the tip: what an environment does to it, in the axes of a task, with noise."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.control.environment import Environment, tip_wrench_of
from mafsil.control.task_coordinates import TaskCoordinates
from mafsil.robot import Robot


class TipForceSensor:
    """(q, qd) -> (m,) force that the tip exerts on the world, in the axes of {s}.

    Several readings of one measured state are the same; noise is reproducible by the seed.

    Args:
        robot: the true arm.
        environment: what its tip touches.
        coordinates: of the task, decoupled ones.
        noise: standard deviation of forces [N]; of moments a tenth of it [N m].
        seed: of the noise.
    """

    def __init__(
        self, robot: Robot, environment: Environment, coordinates: TaskCoordinates, noise: float = 0.0, seed: int = 0
    ) -> None:
        self._robot, self._environment, self._coordinates = robot, environment, coordinates
        self._noise, self._random = noise, np.random.default_rng(seed)
        self._state: JointVector | None = None
        self._reading: Floats = np.zeros(0)

    def __call__(self, q: JointVector, qd: JointVector) -> Floats:
        """The reading (*batch, m) [N m, N]."""
        if q is self._state:
            return self._reading
        wrench = tip_wrench_of(self._robot, self._environment, q, qd)
        R = self._coordinates.pose(self._robot, q)[..., :3, :3]
        halves = [(R @ part[..., None])[..., 0] for part in (wrench[..., :3], wrench[..., 3:])]
        exerted: Floats = -np.concatenate(halves, axis=-1)
        if self._noise:
            exerted = exerted + self._noise * np.repeat([0.1, 1.0], 3) * self._random.standard_normal(exerted.shape)
        self._state, self._reading = q, exerted[..., list(self._coordinates.rows)]
        return self._reading
