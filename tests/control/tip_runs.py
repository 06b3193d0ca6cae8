"""Arms at rest and runs of laws of the tip; shared by their tests."""

from __future__ import annotations

import numpy as np

import mafsil as mf
from mafsil.control import TaskCoordinates
from mafsil.simulation import Plant
from mafsil.trajectory.profiles import rest

UR5E, PANDA = mf.load("ur5e"), mf.load("panda")
Q = np.array([0.3, -1.2, 1.2, 0.4, 1.0, 0.2])
Q7 = np.array([0.1, -0.4, 0.2, -2.0, 0.1, 1.8, 0.5])
T = UR5E.forward_kinematics(Q)
POSITION = TaskCoordinates(rows=(3, 4, 5))
AXES = ["decoupled", "body", "space"]


def run(robot, law, q, duration, *, plant=None, qd=None, step=1e-3, goal=None):
    scenario = mf.Scenario(
        robot=robot,
        plant=plant or Plant(robot, friction=False),
        trajectory=rest(q if goal is None else goal, duration),
        law=law,
        q=q,
        qd=np.zeros(robot.n) if qd is None else qd,
        step=step,
        saturate=False,
        integrator="rk4",
    )
    return mf.simulate(scenario)
