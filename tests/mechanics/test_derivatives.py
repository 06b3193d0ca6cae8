"""Derivatives of dynamics in closed form: against Pinocchio, automatic differentiation and each other."""

import casadi as ca
import numpy as np
import pytest

import mafsil.expression as ex
from mafsil.kernels.reduce import reduce
from mafsil.kernels.tape import read
from mafsil.mechanics.catalogue import quantity
from mafsil.model import library
from mafsil.robot import Robot
from mafsil.robot.trace import trace
from tests.oracles.casadi_expression import as_casadi
from tests.oracles.random_tree import random_tree
from tests.oracles.states import sample

ROBOTS = ("panda", "stanford_arm", "tree", "planar2r_point_masses")
CLOSE = 1e-9


def mechanism_named(name):
    """`tree` branches, and has helical, prismatic and mimic joints and massless links."""
    return random_tree(np.random.default_rng(0), most_joints=12) if name == "tree" else library.load(name)


def gap(a, b):
    return np.abs(a - b).max() / max(1.0, np.abs(b).max())


@pytest.mark.capability("09-4")
@pytest.mark.parametrize("name", ["panda", "ur5e", "stanford_arm"])
def test_both_against_pinocchio(name):
    pin = pytest.importorskip("pinocchio")
    from tests.oracles.pinocchio_model import model_of

    mechanism = library.load(name)
    robot, (model, _) = Robot(mechanism), model_of(mechanism)
    data, states = model.createData(), sample(mechanism, 20, np.random.default_rng(4))
    inverse = robot.inverse_dynamics_derivatives(states.q, states.qd, states.qdd)
    forward = robot.forward_dynamics_derivatives(states.q, states.qd, states.tau)
    for k in range(20):
        pin.computeRNEADerivatives(model, data, states.q[k], states.qd[k], states.qdd[k])
        M = np.triu(data.M) + np.triu(data.M, 1).T
        for ours, theirs in zip(inverse[k], (data.dtau_dq, data.dtau_dv, M), strict=True):
            assert gap(ours, theirs) < CLOSE
        pin.computeABADerivatives(model, data, states.q[k], states.qd[k], states.tau[k])
        Minv = np.triu(data.Minv) + np.triu(data.Minv, 1).T
        for ours, theirs in zip(forward[k], (data.ddq_dq, data.ddq_dv, Minv), strict=True):
            assert gap(ours, theirs) < CLOSE


@pytest.mark.parametrize("optional", [(), ("tip_wrench",)])
@pytest.mark.parametrize("name", ROBOTS)
def test_inverse_against_automatic_differentiation(name, optional):
    """Every kind of joint, followers, branches and a tip wrench."""
    mechanism = mechanism_named(name)
    n, states = mechanism.n, sample(mechanism, 3, np.random.default_rng(1))
    symbols = [ca.SX.sym(x, n) for x in ("q", "qd", "qdd")] + [ca.SX.sym("F", 6)] * len(optional)
    tau = as_casadi(trace(mechanism, quantity("inverse_dynamics"), None, optional))(*symbols)
    automatic = ca.Function("d", symbols, [ca.jacobian(tau, x) for x in symbols[:3]])
    ours = trace(mechanism, quantity("inverse_dynamics_derivatives"), None, optional)
    for k in range(3):
        values = [x[k] for x in states.arguments(("q", "qd", "qdd", *optional))]
        blocks = ours(*values).full().reshape(3, n, n)
        for block, reference in zip(blocks, automatic(*values), strict=True):
            assert gap(block, reference.full()) < 1e-13


@pytest.mark.parametrize("name", ROBOTS[:2])
def test_forward_undoes_inverse(name):
    """d qdd = -M^-1 d tau at the same motion, with the tip wrench too; M^-1 M = E."""
    robot = Robot(mechanism_named(name))
    s = sample(robot.mechanism, 5, np.random.default_rng(2))
    for F in ((), (s.tip_wrench,)):
        qdd = robot.forward_dynamics(s.q, s.qd, s.tau, *F)
        by_q, by_qd, M = np.moveaxis(robot.inverse_dynamics_derivatives(s.q, s.qd, qdd, *F), 1, 0)
        q, qd, Minv = np.moveaxis(robot.forward_dynamics_derivatives(s.q, s.qd, s.tau, *F), 1, 0)
        assert gap(Minv @ M, np.eye(robot.n)) < 1e-10
        assert gap(q, -Minv @ by_q) < 1e-10
        assert gap(qd, -Minv @ by_qd) < 1e-10
        assert gap(M, robot.mass_matrix(s.q)) < 1e-14


def test_rates_give_twice_the_coriolis_matrix():
    robot = Robot(mechanism_named("tree"))
    s = sample(robot.mechanism, 4, np.random.default_rng(3))
    by_qd = robot.inverse_dynamics_derivatives(s.q, s.qd, s.qdd)[:, 1]
    assert gap(by_qd, 2 * robot.coriolis_matrix(s.q, s.qd)) < 1e-13


@pytest.mark.capability("09-10")
def test_the_closed_form_needs_fewer_operations_than_differentiation():
    mechanism = library.load("panda")

    def operations(function):
        return sum(node.op not in ("input", "const") for node in reduce(read(function)).nodes)

    symbols = [ex.symbol(x, 7) for x in ("q", "qd", "qdd")]
    tau = trace(mechanism, quantity("inverse_dynamics"), None)(*symbols)
    automatic = ex.Function("d", symbols, [ex.vec(ex.jacobian(tau, x)) for x in symbols], cse=True)
    ours = operations(trace(mechanism, quantity("inverse_dynamics_derivatives"), None))
    assert ours < 2050
    assert ours < operations(automatic) / 2
