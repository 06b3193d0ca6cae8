"""Compiled dynamics of closed chains beside the careful ones that find the rank of the loops at each state."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil import parallel
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.model import JointKind
from mafsil.parallel import closed_terms
from mafsil.parallel.closed_compiled import independent_rows
from tests.parallel.closed_chains import four_bar, random_body, random_chain


def heavy(linkage, rng):
    """The mechanism of a linkage with random bodies."""
    mechanism = mf.mobility.mechanism_of(linkage)
    ground, *bodies = mechanism.links
    return replace(mechanism, links=(ground, *(random_body(rng, body.name) for body in bodies)))


def tilted(mechanism):
    """The same mechanism on a base whose axes are nobody's: what is zero by its plane is now a rounding."""
    T = pose.exp(np.array([0.3, 0.7, -0.4, 0.1, 0.2, 0.3]))
    joints = (replace(j, T_pj=T @ j.T_pj) if j.parent == "base" else j for j in mechanism.joints)
    return replace(mechanism, joints=tuple(joints))


def carefully(chain, q, qd, tau):
    return chain.forward_dynamics(q, qd, tau, added_inertia=np.zeros((chain.n, chain.n)))


@pytest.mark.parametrize("name", ["bennett", "sarrus", "kaleidocycle", "peaucellier", "tripteron", "three_rps"])
def test_redundant_loops_have_one_motion_and_the_shortest_forces(name):
    rng = np.random.default_rng(3)
    chain = parallel.ClosedChain(heavy(getattr(mf.mobility.library, name)(), rng))
    near = chain.close_loops(rng.uniform(-0.1, 0.1, (6, chain.n)))
    q = near.q[near.found]
    assert len(q) > 2
    qd, tau = chain.rates(q, rng.normal(size=q.shape)), rng.normal(size=q.shape)
    quick, slow = chain.forward_dynamics(q, qd, tau), carefully(chain, q, qd, tau)
    assert (quick.rank == slow.rank).all()
    for a, b in ((quick.qdd, slow.qdd), (quick.force, slow.force), (quick.error, slow.error)):
        assert np.abs(a - b).max() < 1e-10 * max(1.0, np.abs(b).max())
    one = chain.forward_dynamics(q[1], qd[1], tau[1])
    assert np.abs(one.qdd - slow.qdd[1]).max() < 1e-10 * max(1.0, np.abs(slow.qdd[1]).max())
    assert one
    assert int(one.rank) == slow.rank[1]


def test_a_plane_that_is_tilted_stays_a_plane():
    chain, aside = (parallel.ClosedChain(m) for m in (four_bar(), tilted(four_bar())))
    q = chain.close_loops([0.5, 0.5, 1.5], hold=["A"]).q
    qd = chain.rates(q, [1.0, 0, 0])
    for each in (chain, aside):
        quick, slow = each.forward_dynamics(q, qd, [1.0]), carefully(each, q, qd, np.array([1.0, 0, 0]))
        assert (int(quick.rank), int(slow.rank)) == (2, 2)
        assert np.abs(quick.qdd - slow.qdd).max() < 1e-11
        assert np.abs(quick.force - slow.force).max() < 1e-11


def test_singular_rows_of_a_batch_are_found_with_their_rank():
    chain = parallel.ClosedChain(four_bar(1.0, 0.5, 1.0, 0.5))
    q = np.array([[0.7, -0.7, 0.7], [0.0, 0.0, 0.0], [1e-9, -1e-9, 1e-9], [-0.4, 0.4, -0.4]])
    found, slow = chain.forward_dynamics(q, 0 * q, [1.0]), carefully(chain, q, 0 * q, np.array([1.0, 0, 0]))
    assert found.rank.tolist() == slow.rank.tolist() == [2, 1, 1, 2]
    np.testing.assert_allclose(found.qdd, slow.qdd, rtol=1e-9)
    alone = chain.forward_dynamics(q[1], np.zeros(3), [1.0])
    assert int(alone.rank) == 1
    np.testing.assert_allclose(alone.qdd, slow.qdd[1])


def test_a_mass_matrix_without_mass_is_said_and_not_nan():
    chain = parallel.ClosedChain(mf.mobility.mechanism_of(mf.mobility.library.bennett()))
    q = np.zeros((2, 3))
    found = chain.forward_dynamics(q, q, [[0.0, 0, 0], [1.0, 0, 0]])
    assert found.status.name == "SINGULAR_MASS"
    np.testing.assert_allclose(found.qdd[0], 0.0, atol=1e-9)
    along = chain.rates(q[0], [1.0, 0.0, 0.0])
    np.testing.assert_allclose(chain.terms(q[0]).J @ along, 0.0, atol=1e-9)
    np.testing.assert_array_equal(found.qdd[1], np.copysign(np.inf, along))


def test_a_massless_link_that_loops_hold_accelerates_as_a_light_one():
    """A four-bar whose coupler has no mass, as parts of universal joints have none."""
    chains = []
    for share in (0.0, 1e-9):
        drawn = four_bar()
        links = list(drawn.links)
        k = drawn.link_names.index("coupler")
        body = links[k].inertial
        links[k] = replace(links[k], inertial=replace(body, mass=share * body.mass, inertia=share * body.inertia))
        chains.append(parallel.ClosedChain(replace(drawn, links=tuple(links))))
    q = chains[1].close_loops([0.9, -0.5, 1.4]).q
    none, little = (chain.forward_dynamics([q, q], np.zeros((2, 3)), [[1.0], [-2.0]]) for chain in chains)
    assert none
    assert none.rank.tolist() == [2, 2]
    np.testing.assert_allclose(none.qdd, little.qdd, rtol=1e-5)
    np.testing.assert_allclose(none.force, little.force, atol=1e-5 * np.abs(little.force).max())


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("place", [0, 1, 2])
def test_numbers_that_are_not_finite_are_refused_by_name(bad, place):
    mechanism, q = random_chain(np.random.default_rng(0), JointKind.FIXED)
    chain = parallel.ClosedChain(mechanism)
    given = [np.tile(q, (3, 1)), np.zeros((3, 9)), np.zeros((3, 9))]
    given[place][1, 4] = bad
    with pytest.raises(InputError, match=("q", "qd", "tau")[place]):
        chain.forward_dynamics(*given)
    with pytest.raises(InputError, match=("q", "qd", "tau")[place]):
        chain.forward_dynamics(*(x[1] for x in given))


def test_efforts_of_all_joints_and_of_the_driven_ones_take_turns():
    chain = parallel.ClosedChain(four_bar())
    q = chain.close_loops([0.5, 0.5, 1.5], hold=["A"]).q
    qd = chain.rates(q, [1.0, 0, 0])
    for _ in range(2):
        for tau in ([0.7], [0.7, 0.0, 0.0], np.array([0.7]), np.array([[0.7], [0.7], [0.7]])):
            found, slow = chain.forward_dynamics(q, qd, tau), carefully(chain, q, qd, tau)
            assert np.abs(found.qdd - slow.qdd).max() < 1e-10
            assert found.force.shape == slow.force.shape == (*np.shape(tau)[:-1], chain.m)
            assert np.shape(found.error) == np.shape(found.rank) == np.shape(tau)[:-1]
            assert found == found
            assert found != slow
    with pytest.raises(InputError, match="tau"):
        chain.forward_dynamics(q, qd, [0.7, 0.0])
    again = pickle.loads(pickle.dumps(found))
    assert (again.qdd == found.qdd).all()
    assert again.explain() == found.explain()


def test_batches_broadcast_and_may_be_empty():
    mechanism, q = random_chain(np.random.default_rng(0), JointKind.FIXED)
    chain = parallel.ClosedChain(mechanism)
    rng = np.random.default_rng(1)
    qd, tau = chain.rates(q, rng.normal(size=(2, 1, 9))), rng.normal(size=(4, 9))
    found = chain.forward_dynamics(q, qd, tau)
    assert found.qdd.shape == (2, 4, 9)
    assert found.force.shape == (2, 4, 6)
    assert found.rank.shape == found.error.shape == (2, 4)
    np.testing.assert_allclose(found.qdd[1, 2], chain.forward_dynamics(q, qd[1, 0], tau[2]).qdd, atol=1e-11)
    assert len(chain.forward_dynamics(np.zeros((0, 9)), np.zeros((0, 9)), np.zeros((0, 9)))) == 0
    with pytest.raises(InputError, match="tau"):
        chain.forward_dynamics(q, q, np.zeros(4))


@pytest.mark.parametrize("driven", [("j0", "j1", "j2"), ("j0", "j3"), ("j1", "j2", "j4", "j7"), None])
def test_efforts_are_the_shortest_however_many_joints_are_driven(driven):
    mechanism, q = random_chain(np.random.default_rng(2), JointKind.FIXED)
    chain, rng = parallel.ClosedChain(mechanism, driven), np.random.default_rng(1)
    qd = chain.rates(q, rng.normal(size=(5, 9)))
    qdd = chain.forward_dynamics(q, qd, rng.normal(size=(5, 9))).qdd
    found = chain.inverse_dynamics(q, qd, qdd)
    expected = parallel.ActuatorEfforts(*closed_terms.efforts(chain.terms(q, qd), qdd, chain.actuated))
    for name in ("tau", "force", "missing", "broken", "needed", "driven"):
        a, b = getattr(found, name), getattr(expected, name)
        np.testing.assert_allclose(a, b, atol=1e-9 * max(1.0, np.abs(b).max()))
    assert (found.redundancy == expected.redundancy).all()
    assert found.status is expected.status
    alone = chain.inverse_dynamics(q, qd[0], qdd[0])
    np.testing.assert_allclose(alone.tau, found.tau[0], atol=1e-10)
    assert alone.status is found.status
    opened = chain.inverse_dynamics(q, qd[0], qdd[0] + 1.0)
    assert opened.status.name == "BROKEN"


def test_efforts_at_a_singular_configuration_take_the_careful_way():
    chain = parallel.ClosedChain(four_bar(1.0, 0.5, 1.0, 0.5))
    q = np.array([[0.7, -0.7, 0.7], [0.0, 0.0, 0.0]])
    found = chain.inverse_dynamics(q, 0 * q, 0 * q)
    expected = closed_terms.efforts(chain.terms(q), 0 * q, chain.actuated)
    for a, b in zip((found.tau, found.force, found.missing), expected[:3], strict=True):
        np.testing.assert_allclose(a, b, atol=1e-10)
    with pytest.raises(InputError, match="qdd"):
        chain.inverse_dynamics(q, 0 * q, 0 * q + np.nan)


def test_independent_rows_are_the_first_that_are_well_apart():
    rng = np.random.default_rng(0)
    J = rng.normal(size=(5, 3, 6))
    doubled = np.stack([J[:, 0], 2 * J[:, 0], J[:, 1], J[:, 0] + J[:, 1], 1e-12 * J[:, 2], J[:, 2]], axis=1)
    M = np.tile(np.eye(6), (5, 1, 1))
    assert independent_rows(M, doubled) == (0, 2, 5)
    assert independent_rows(0 * M, doubled) is None
