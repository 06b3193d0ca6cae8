"""Centre of mass and momentum about it: against Pinocchio on random trees, and against each other."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil.errors import ModelError
from mafsil.model import Actuator, Joint, JointKind, Link, Mechanism
from mafsil.robot import Robot
from mafsil.verification import verify
from tests.oracles.random_tree import random_tree

pin = pytest.importorskip("pinocchio")

EPS = 2.0**-52
ROUNDING = 1e3 * EPS
"""Of a few hundred operations, relative to the largest entry."""


def _placed(seed: int) -> Mechanism:
    """A random tree that stands somewhere else than at the origin of {s}."""
    return random_tree(np.random.default_rng(seed), most_joints=7)


@pytest.mark.parametrize("seed", range(8))
def test_agrees_with_pinocchio(seed: int) -> None:
    from tests.oracles.pinocchio_model import PinocchioOracle

    mechanism = _placed(seed)
    robot, oracle = Robot(mechanism), PinocchioOracle(mechanism)
    B, b = oracle.expansion.B, oracle.expansion.b
    q, qd, qdd = np.random.default_rng(seed).uniform(-2, 2, (3, 2, 3, robot.n))
    ours = (
        robot.center_of_mass(q),
        robot.com_jacobian(q),
        robot.centroidal_momentum_matrix(q),
        robot.centroidal_momentum(q, qd),
        robot.centroidal_momentum_rate(q, qd, qdd),
    )
    angular_first = [3, 4, 5, 0, 1, 2]
    for index in np.ndindex(2, 3):
        x, xd, xdd = B @ q[index] + b, B @ qd[index], B @ qdd[index]
        p = pin.centerOfMass(oracle.model, oracle.data, x).copy()
        J = pin.jacobianCenterOfMass(oracle.model, oracle.data, x) @ B
        pin.computeCentroidalMomentumTimeVariation(oracle.model, oracle.data, x, xd, xdd)
        h, dh = (part.vector[angular_first] for part in (oracle.data.hg, oracle.data.dhg))
        A = pin.computeCentroidalMap(oracle.model, oracle.data, x)[angular_first] @ B
        for mine, theirs in zip(ours, (p, J, A, h, dh), strict=True):
            assert np.abs(mine[index] - theirs).max() <= ROUNDING * max(1.0, np.abs(theirs).max())


@pytest.mark.parametrize("seed", range(3))
def test_the_momentum_is_that_of_the_centre_of_mass(seed: int) -> None:
    robot = Robot(_placed(seed))
    q, qd, qdd = np.random.default_rng(seed).uniform(-2, 2, (3, 5, robot.n))
    links = robot.mechanism.links[1:]
    moved = {robot.mechanism.links[0].name}
    mass = 0.0
    for joint, link in zip(robot.mechanism.joints, links, strict=True):
        if not joint.moves and joint.parent in moved:
            moved.add(link.name)
        elif link.inertial is not None:
            mass += link.inertial.mass
    momentum = robot.centroidal_momentum(q, qd)
    np.testing.assert_allclose(
        momentum[:, 3:], mass * np.einsum("bij,bj->bi", robot.com_jacobian(q), qd), atol=1e-12 * mass
    )
    np.testing.assert_allclose(
        momentum, np.einsum("bij,bj->bi", robot.centroidal_momentum_matrix(q), qd), atol=1e-12 * mass
    )
    still = robot.centroidal_momentum_rate(q, np.zeros_like(q), qdd)
    np.testing.assert_allclose(
        still, np.einsum("bij,bj->bi", robot.centroidal_momentum_matrix(q), qdd), atol=1e-11 * mass
    )


def test_the_ground_turns_the_momentum() -> None:
    """Newton and Euler for the whole robot: d(k, l)/dt is what the ground exerts and the weight."""
    mechanism = _placed(1)
    robot = Robot(mechanism)
    q, qd, qdd = np.random.default_rng(5).uniform(-1, 1, (3, 4, robot.n))
    rate = robot.centroidal_momentum_rate(q, qd, qdd)
    floating = robot.link_wrenches(q, qd, qdd)[:, 0]  # what the ground exerts on the first link, in its frame
    base = mechanism.links[0].inertial
    mass_of_base = 0.0 if base is None else base.mass
    T = robot.link_poses(q)[:, 0]
    force = np.einsum("bij,bj->bi", T[:, :3, :3], floating[:, 3:]) + mass_of_base * mechanism.gravity
    mass = sum(link.inertial.mass for link in mechanism.links[1:] if link.inertial is not None)
    np.testing.assert_allclose(rate[:, 3:], force + mass * mechanism.gravity, atol=1e-11 * mass)


def test_without_moving_mass_there_is_no_centre() -> None:
    links = [Link("a"), Link("b")]
    joint = Joint("j", JointKind.REVOLUTE, "a", "b", actuator=Actuator(rotor_inertia=1e-3, gear_ratio=10.0))
    robot = Robot(Mechanism.assemble("rotor", links, [joint]))
    with pytest.raises(ModelError, match="centre of mass"):
        robot.center_of_mass([0.1])
    report = verify(robot, states=2)
    assert report, report.explain()
