"""A block on three rails and an arm that meet rigid surfaces under given efforts; shared by their tests."""

from __future__ import annotations

import numpy as np

import mafsil as mf
from mafsil.model import Inertial, Joint, JointKind, Link, Mechanism
from mafsil.simulation import RigidPlant, simulate
from mafsil.trajectory.profiles import rest

G, MASS = 9.81, 2.0
ORIGIN = np.zeros(3)


class Force:
    """Efforts as a function of time."""

    def __init__(self, tau):
        self.tau = tau

    def __call__(self, t, q, qd, reference):
        return np.zeros_like(q) + self.tau(t)

    def session(self, period):
        return self


def block():
    """A mass on three rails: a point in space."""
    names, masses = ("base", "x rail", "y rail", "mass"), (1e-9, 1e-9, MASS)
    links = [Link("base")]
    links += [Link(n, Inertial(m, ORIGIN, m * np.eye(3))) for n, m in zip(names[1:], masses, strict=True)]
    joints = [Joint("xyz"[k], JointKind.PRISMATIC, names[k], names[k + 1], axis=tuple(np.eye(3)[k])) for k in range(3)]
    return mf.Robot(Mechanism.assemble("block", links, joints))


BLOCK, ARM = block(), mf.load("planar2r_point_masses")


def moved(robot, surfaces, q, qd, duration, tau=lambda t: 0.0, **changes):
    scenario = mf.Scenario(
        robot=robot, trajectory=rest(q, duration), q=q, qd=qd, law=Force(tau), saturate=False,
        plant=RigidPlant(robot, friction=False, surface=surfaces), **changes,
    )  # fmt: skip
    return simulate(scenario)
