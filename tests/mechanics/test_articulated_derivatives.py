"""Derivatives of forward dynamics by recursion along the tree, and matrices factored along it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil.expression as ex
from mafsil.kernels.reduce import reduce
from mafsil.kernels.tape import read
from mafsil.mechanics.articulated_derivatives import forward_derivatives
from mafsil.mechanics.body_tree import lump_bodies
from mafsil.mechanics.branch_factor import BranchFactor
from mafsil.mechanics.catalogue import quantity
from mafsil.mechanics.frame_choice import in_chosen_frames, regroup
from mafsil.mechanics.quantities import dynamics_derivatives
from mafsil.mechanics.quantities import forward_dynamics as mass_matrix
from mafsil.mechanics.quantities.forward_dynamics import forward_dynamics
from mafsil.mechanics.wrench import ground_is_shorter
from mafsil.model import library
from mafsil.robot.trace import trace
from tests.oracles.random_tree import branched_tree, random_tree, serial_chain
from tests.oracles.states import sample

CLOSE = 1e-11


def gap(a, b):
    return np.abs(a - b).max() / max(1.0, np.abs(b).max())


def without_followers(seed, helical):
    """A random tree none of whose joints follows another, the first from that seed on."""
    while True:
        mechanism = random_tree(np.random.default_rng(seed), most_joints=18, helical=helical)
        if not lump_bodies(mechanism).follows:
            return mechanism
        seed += 1


def recursion(mechanism):
    """The recursion as a function of q, qd, tau and the tip wrench, and its arguments as symbols."""
    tree = regroup(in_chosen_frames(lump_bodies(mechanism)))
    symbols = [ex.symbol(name, tree.n) for name in ("q", "qd", "tau")] + [ex.symbol("F", 6)]
    blocks = forward_derivatives(tree, *symbols)
    return ex.Function("derivatives", symbols, blocks), forward_dynamics(tree, *symbols), symbols


@pytest.mark.parametrize("seed", [100, 200, 300, 400])
def test_trees_against_pinocchio(seed):
    """Random trees of revolute and prismatic joints: computeABADerivatives and computeMinverse."""
    pin = pytest.importorskip("pinocchio")
    from tests.oracles.pinocchio_model import model_of

    mechanism = without_followers(seed, helical=False)
    model, _ = model_of(mechanism)
    data, states = model.createData(), sample(mechanism, 5, np.random.default_rng(seed))
    ours, _, _ = recursion(mechanism)
    for q, qd, tau in zip(states.q, states.qd, states.tau, strict=True):
        pin.computeABADerivatives(model, data, q, qd, tau)
        theirs = [data.ddq_dq.copy(), data.ddq_dv.copy(), np.triu(data.Minv) + np.triu(data.Minv, 1).T]
        inverse = np.triu(pin.computeMinverse(model, data, q))
        found = [block.full() for block in ours.call([q, qd, tau, np.zeros(6)])]
        for block, reference in zip(found, theirs, strict=True):
            assert gap(block, reference) < CLOSE
        assert gap(np.triu(found[2]), inverse) < CLOSE


@pytest.mark.parametrize("seed", [500, 600, 700])
def test_trees_against_automatic_differentiation(seed):
    """Helical joints and a tip wrench too; M^-1 symmetric to the bit."""
    mechanism = without_followers(seed, helical=True)
    ours, qdd, symbols = recursion(mechanism)
    automatic = ex.Function("automatic", symbols, [ex.jacobian(qdd, x) for x in symbols[:3]])
    states = sample(mechanism, 3, np.random.default_rng(seed))
    for values in zip(*states.arguments(("q", "qd", "tau", "tip_wrench")), strict=True):
        found = [block.full() for block in ours.call(values)]
        for block, reference in zip(found, automatic.call(values), strict=True):
            assert gap(block, reference.full()) < CLOSE
        np.testing.assert_array_equal(found[2], found[2].T)


@pytest.mark.parametrize("mechanism", [serial_chain(14, np.random.default_rng(3)), library.load("panda")])
def test_both_roads_agree(mechanism):
    """What the catalogue gives: by recursion for the chain of 14, by the factored mass matrix for the arm."""
    ours, _, _ = recursion(mechanism)
    catalogue = trace(mechanism, quantity("forward_dynamics_derivatives"), None)
    inverse = trace(mechanism, quantity("inverse_dynamics_derivatives"), None)
    forward = trace(mechanism, quantity("forward_dynamics"), None)
    n, states = mechanism.n, sample(mechanism, 4, np.random.default_rng(8))
    for q, qd, tau in zip(states.q, states.qd, states.tau, strict=True):
        by_q, by_qd, M = inverse(q, qd, forward(q, qd, tau)).full().reshape(3, n, n)
        dense = np.stack([-np.linalg.solve(M, by_q), -np.linalg.solve(M, by_qd), np.linalg.inv(M)])
        own = np.stack([block.full() for block in ours.call([q, qd, tau, np.zeros(6)])])
        for blocks in (own, catalogue(q, qd, tau).full()):
            assert gap(blocks.reshape(3, n, n), dense) < 1e-9


@pytest.mark.parametrize(
    ("mechanism", "most"),
    [(serial_chain(20, np.random.default_rng(30)), 29_000), (branched_tree(20, np.random.default_rng(30)), 22_000)],
    ids=["chain", "tree"],
)
def test_operations_grow_with_pairs_of_joints(mechanism, most):
    """Eliminating in n x n matrices took 51,000 for the chain and 23,000 for the tree."""
    tape = reduce(read(trace(mechanism, quantity("forward_dynamics_derivatives"), None)))
    assert tape.operations < most


@st.composite
def branched_matrices(draw):
    """A symmetric positive definite matrix with the zeros of a random tree, and right sides with zeros."""
    n = draw(st.integers(1, 9))
    parents = [draw(st.integers(-1, k - 1)) for k in range(n)]
    rng = np.random.default_rng(draw(st.integers(0, 1 << 32)))
    L = np.eye(n)
    for k in range(n):
        i = parents[k]
        while i >= 0:
            L[k, i] = rng.uniform(-1, 1)
            i = parents[i]
    M = L.T @ np.diag(rng.uniform(0.5, 2, n)) @ L
    return M, rng.uniform(-1, 1, n) * (rng.random(n) < 0.5)


@settings(deadline=None, max_examples=60)
@given(branched_matrices())
def test_factored_along_any_tree(case):
    M, b = case
    factor = BranchFactor(ex.Expression(M))
    x = np.array([float(ex.evalf(value)) for value in factor.solve([ex.Expression(float(v)) for v in b])])
    inverse = np.array([[float(ex.evalf(value)) for value in row] for row in factor.inverse()])
    scale = np.abs(np.linalg.inv(M)).max()
    np.testing.assert_allclose(x, np.linalg.solve(M, b), rtol=0, atol=1e-12 * scale)
    np.testing.assert_allclose(inverse, np.linalg.inv(M), rtol=0, atol=1e-12 * scale)


def test_a_branch_that_nothing_drives_stays_a_structural_zero():
    """Two chains on one base: nothing of the one reaches the other."""
    M = ex.Expression([[2, 1, 0, 0], [1, 3, 0, 0], [0, 0, 2, 1], [0, 0, 1, 4]])
    factor = BranchFactor(M)
    x = factor.solve([ex.Expression(1), ex.Expression(0), ex.Expression(0), ex.Expression(0)])
    assert [value.is_zero() for value in x] == [False, False, True, True]
    assert [value.is_zero() for value in factor.inverse()[2]] == [True, True, False, False]


@pytest.mark.parametrize("mechanism", [serial_chain(9, np.random.default_rng(1)), without_followers(40, helical=True)])
def test_pairs_of_joints_in_either_frame(mechanism, monkeypatch):
    """d tau and M with every wrench in the ground frame, and from body to body."""
    tree = regroup(in_chosen_frames(lump_bodies(mechanism)))
    symbols = [ex.symbol(name, tree.n) for name in ("q", "qd", "qdd")] + [ex.symbol("F", 6)]
    states = sample(mechanism, 3, np.random.default_rng(9))
    functions = []
    for ground in (False, True):
        for module in (dynamics_derivatives, mass_matrix):
            monkeypatch.setattr(module, "ground_is_shorter", lambda *_a, ground=ground, **_k: ground)
        blocks = [*dynamics_derivatives.matrices(tree, *symbols), mass_matrix.mass_matrix(tree, symbols[0])]
        functions.append(ex.Function("blocks", symbols, blocks))
    for values in zip(*states.arguments(("q", "qd", "qdd", "tip_wrench")), strict=True):
        body, ground = ([block.full() for block in function.call(values)] for function in functions)
        for a, b in zip(body, ground, strict=True):
            assert gap(a, b) < 1e-14
        assert gap(ground[2], ground[3]) < 1e-15


def test_the_ground_frame_is_chosen_for_long_chains_of_any_angles():
    arms = [in_chosen_frames(lump_bodies(library.load(name))) for name in ("panda", "ur5e", "iiwa7", "puma560")]
    assert not any(ground_is_shorter(arm, wrenches=3, rows=1) for arm in arms)
    assert ground_is_shorter(
        in_chosen_frames(lump_bodies(serial_chain(20, np.random.default_rng(2)))), wrenches=1, rows=0
    )
