"""Dynamics of closed chains against Pinocchio, against derivatives, and against what is conserved."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import simpson
from scipy.linalg import null_space

from mafsil import mobility, parallel
from mafsil.errors import InputError, ModelError
from mafsil.model import Inertial, JointKind
from tests.parallel.closed_chains import Twin, four_bar, random_chain

KINDS = list(JointKind)


@pytest.fixture(scope="module", params=KINDS, ids=lambda kind: kind.value)
def closed(request):
    mechanism, q = random_chain(np.random.default_rng(KINDS.index(request.param)), request.param)
    return parallel.ClosedChain(mechanism), q


def test_accelerations_are_those_of_newton_and_keep_the_loops_closed(closed):
    chain, q = closed
    rng = np.random.default_rng(1)
    qd, tau = chain.rates(q, rng.normal(size=(20, chain.n))), rng.normal(size=(20, chain.n))
    found, terms = chain.forward_dynamics(q, qd, tau), chain.terms(q, qd)
    assert found
    balance = (
        np.einsum("kij,kj->ki", terms.M, found.qdd) + terms.h - tau - np.einsum("kmi,km->ki", terms.J, found.force)
    )
    assert np.abs(balance).max() < 1e-11
    h = 2e-4
    for k in range(3):
        gaps = [chain.terms(q + s * qd[k] + s * s / 2 * found.qdd[k]).gap for s in (-h, 0.0, h)]
        assert np.abs(gaps[1]).max() < 1e-13
        assert np.abs(gaps[2] - gaps[0]).max() / (2 * h) < 1e-4
        assert np.abs(gaps[2] - 2 * gaps[1] + gaps[0]).max() / h**2 < 1e-3


def test_added_inertia_acts_as_masses_that_only_the_joints_feel(closed):
    """Gauss's principle: of all accelerations that keep the loops closed, that of least (a - f)' (M + D) (a - f)."""
    chain, q = closed
    rng = np.random.default_rng(5)
    qd, tau = chain.rates(q, rng.normal(size=chain.n)), rng.normal(size=chain.n)
    A = rng.normal(size=(chain.n, chain.n))
    D = A @ A.T
    found, terms = chain.forward_dynamics(q, qd, tau, added_inertia=D), chain.terms(q, qd)
    heavier = chain.robot.mass_matrix(q) + D
    free = np.linalg.solve(heavier, tau - chain.robot.inverse_dynamics(q, qd, np.zeros(chain.n)))
    ways = null_space(terms.J, rcond=1e-9)
    kept = -np.linalg.pinv(terms.J, rcond=1e-9) @ terms.gamma
    least = np.linalg.solve(ways.T @ heavier @ ways, ways.T @ heavier @ (free - kept))
    np.testing.assert_allclose(found.qdd, kept + ways @ least, atol=1e-9)
    assert np.abs(found.qdd - chain.forward_dynamics(q, qd, tau).qdd).max() > 1e-3
    twice = chain.forward_dynamics(q, qd, tau, added_inertia=np.stack([D, 0 * D]))
    np.testing.assert_allclose(twice.qdd, [found.qdd, chain.forward_dynamics(q, qd, tau).qdd], atol=1e-9)


@pytest.mark.parametrize("kind", [JointKind.FIXED, JointKind.REVOLUTE, JointKind.SPHERICAL])
@pytest.mark.parametrize("seed", range(4))
def test_accelerations_against_pinocchio(kind, seed):
    rng = np.random.default_rng(seed)
    mechanism, q = random_chain(rng, kind)
    chain, twin = parallel.ClosedChain(mechanism), Twin(mechanism)
    for _ in range(5):
        qd, tau = chain.rates(q, rng.normal(size=chain.n)), 5 * rng.normal(size=chain.n)
        found = chain.forward_dynamics(q, qd, tau)
        np.testing.assert_allclose(found.qdd, twin.accelerations(q, qd, tau), rtol=1e-6, atol=1e-6)


def test_inverse_dynamics_undo_forward_dynamics(closed):
    chain, q = closed
    rng = np.random.default_rng(2)
    qd, tau = chain.rates(q, rng.normal(size=(10, chain.n))), rng.normal(size=(10, chain.n))
    ahead = chain.forward_dynamics(q, qd, tau)
    back = chain.inverse_dynamics(q, qd, ahead.qdd)
    assert back.status.name == "SEVERAL"
    assert (back.redundancy == chain.m).all()
    again = chain.forward_dynamics(q, qd, back.tau)
    np.testing.assert_allclose(again.qdd, ahead.qdd, atol=1e-9)
    assert (np.linalg.norm(back.tau, axis=1) <= np.linalg.norm(tau, axis=1) + 1e-12).all()
    strained = back.tau[0] + back.preload((0,)) @ rng.normal(size=chain.m)
    np.testing.assert_allclose(chain.forward_dynamics(q, qd[0], strained).qdd, ahead.qdd[0], atol=1e-9)


def test_as_few_actuators_as_freedoms_do_it_in_one_way():
    mechanism, q = random_chain(np.random.default_rng(5), JointKind.REVOLUTE)
    chain = parallel.ClosedChain(mechanism, actuated=("j0", "j1", "j2", "j3"))
    rng = np.random.default_rng(0)
    qd = chain.rates(q, rng.normal(size=9))
    ahead = chain.forward_dynamics(q, qd, rng.normal(size=4))
    back = chain.inverse_dynamics(q, qd, ahead.qdd)
    assert back.status.name == "UNIQUE"
    assert chain.forward_dynamics(q, qd, back.tau).qdd == pytest.approx(ahead.qdd, abs=1e-8)
    few = parallel.ClosedChain(mechanism, actuated=("j0", "j1"))
    lacking = few.inverse_dynamics(q, qd, ahead.qdd)
    assert lacking.status.name == "IMPOSSIBLE"
    assert f"{float(lacking.missing):.4g}" in lacking.explain("en")
    opened = chain.inverse_dynamics(q, qd, ahead.qdd + 1.0)
    assert opened.status.name == "BROKEN"


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_loops_are_closed_from_nearby(seed):
    rng = np.random.default_rng(seed)
    mechanism, q = random_chain(np.random.default_rng(seed % 8), KINDS[seed % 8])
    chain = parallel.ClosedChain(mechanism)
    found = chain.close_loops(q + rng.uniform(-0.05, 0.05, (5, chain.n)))
    np.testing.assert_array_equal(found.found, chain.error(found.q) <= found.tolerance)
    assert found.found.all()
    fixed = chain.close_loops(q + 0.02, hold=["j0", "j5"])
    assert fixed
    assert fixed.q[0] == q[0] + 0.02
    assert fixed.q[5] == q[5] + 0.02


def test_where_one_search_fails_others_begin_near_it():
    rng = np.random.default_rng(2)
    mechanism, q = random_chain(rng, JointKind.FIXED, 7)
    chain, starts = parallel.ClosedChain(mechanism), q + rng.uniform(-3, 3, (40, 7))
    alone, tried = chain.close_loops(starts, tries=1), chain.close_loops(starts)
    assert alone.found.sum() < 35
    assert tried.found.all()
    np.testing.assert_array_equal(tried.q[alone.found], alone.q[alone.found])
    assert (chain.error(tried.q) <= tried.tolerance).all()
    held = chain.close_loops(starts[:5], hold=["j2"])
    np.testing.assert_array_equal(held.q[:, 2], starts[:5, 2])
    failed = np.flatnonzero(~alone.found)
    gaps = chain.loop_errors(alone.q[failed])
    assert alone.widest == mechanism.loops[0].name
    np.testing.assert_allclose(gaps.max(axis=1), alone.error[failed])


def test_a_planar_four_bar_asks_the_same_three_times():
    chain = parallel.ClosedChain(four_bar())
    start = chain.close_loops([0.5, 0.5, 1.5], hold=["A"])
    assert start
    found = chain.forward_dynamics(start.q, np.zeros(3), [1.0])
    assert (found.rank, found.redundant) == (2, 3)
    # One freedom: the reduced equation of the crank.
    terms, rate = chain.terms(start.q), chain.rates(start.q, [1.0, 0, 0], hold=["A"])
    inertia = rate @ terms.M @ rate
    expected = (rate @ (np.array([1.0, 0, 0]) - terms.h)) / inertia
    assert found.qdd[0] == pytest.approx(expected, rel=1e-10)
    held = chain.inverse_dynamics(start.q, np.zeros(3), np.zeros(3))
    assert held.status.name == "UNIQUE"
    assert held.tau[0] == pytest.approx(rate @ terms.h, rel=1e-10)
    both = parallel.ClosedChain(four_bar(driven=("A", "D"))).inverse_dynamics(start.q, np.zeros(3), np.zeros(3))
    assert both.status.name == "SEVERAL"
    assert both.preload().shape == (2, 1)
    assert np.linalg.norm(both.tau) < abs(held.tau[0])


def test_ten_seconds_keep_energy_and_loops():
    chain = parallel.ClosedChain(four_bar())
    q = chain.close_loops([0.5, 0.5, 1.5], hold=["A"]).q
    fine, coarse = (parallel.simulate_closed(chain, q, duration=2.0, step=h) for h in (2e-3, 4e-3))
    assert fine
    drift = [np.abs(run.energy - run.energy[0]).max() for run in (fine, coarse)]
    assert drift[0] < 1e-6
    assert 8 < drift[1] / drift[0] < 32, "order four"
    np.testing.assert_allclose(fine.q[::2], coarse.q, atol=1e-5)
    long = parallel.simulate_closed(chain, q, duration=10.0, step=2e-3)
    assert long.error.max() < 1e-10
    assert (long.rank == 2).all()
    assert np.ptp(long.q[:, 0]) > 0.5, "it moves"
    assert f"{long.error.max():.2g}" in long.explain("en")


def test_work_of_the_motor_is_the_change_of_energy():
    chain = parallel.ClosedChain(four_bar())
    q = chain.close_loops([0.5, 0.5, 1.5], hold=["A"]).q
    run = parallel.simulate_closed(
        chain, np.stack([q, q]), efforts=lambda t, q, qd: [[5 * np.sin(3 * t)], [0.0]], duration=1.0, step=1e-3
    )
    power = 5 * np.sin(3 * run.t) * run.qd[:, 0, 0]
    work = simpson(power, x=run.t)
    assert run.energy[-1, 0] - run.energy[0, 0] == pytest.approx(work, abs=1e-6)
    assert np.ptp(run.energy[:, 1]) < 1e-8


def test_what_cannot_be_is_said():
    mechanism, q = random_chain(np.random.default_rng(0), JointKind.FIXED)
    with pytest.raises(ModelError, match="open chain"):
        parallel.ClosedChain(replace(mechanism, loops=()))
    with pytest.raises(ModelError, match="nowhere"):
        parallel.ClosedChain(mechanism, actuated=("nowhere",))
    chain = parallel.ClosedChain(four_bar())
    contradictory = chain.close_loops([0.5, 0.5, 1.5], hold=["A", "B"])
    assert not contradictory
    assert contradictory.error > 0.1
    assert "nothing is proved" in contradictory.explain("en")
    too_short = parallel.ClosedChain(four_bar(ground=3.0)).close_loops([0.5, 0.5, 1.5])
    assert not too_short
    assert too_short.error == pytest.approx(3.0 - 0.4 - 1.1 - 0.8, abs=0.4)
    with pytest.raises(InputError, match="does not close"):
        parallel.simulate_closed(chain, [0.5, 0.5, 1.5], duration=1.0)
    with pytest.raises(InputError, match="tau"):
        chain.forward_dynamics(q[:3], q[:3], [np.nan])
    good = chain.close_loops([0.5, 0.5, 1.5], hold=["A"]).q
    wild = parallel.simulate_closed(chain, good, efforts=lambda t, q, qd: 1e3 * qd[:1] + 1, duration=10, step=0.02)
    assert not wild
    assert wild.status.name in ("LOST", "NOT_FINITE")
    assert np.isfinite(wild.q).all()


def test_a_mechanism_without_mass_is_told_so_before_it_runs():
    chain = parallel.ClosedChain(mobility.mechanism_of(mobility.library.four_bar()))
    assert not chain.forward_dynamics(np.zeros(chain.n), np.zeros(chain.n), np.zeros(chain.n))
    with pytest.raises(ModelError, match="moves no mass"):
        parallel.simulate_closed(chain, np.zeros(chain.n), duration=0.1)


@pytest.mark.parametrize(("ground", "hold", "left"), [(5.0, None, 2.7), (1.0, ["A", "D"], None)])
def test_loops_that_cannot_close_say_by_how_much(ground, hold, left):
    """Stretched bars miss 5 - 0.4 - 1.1 - 0.8 m; with both cranks held it is the coupler that is too short or long."""
    chain, q = parallel.ClosedChain(four_bar(ground, 0.4, 1.1, 0.8)), np.array([0.5, 0.3, 2.6])
    found = chain.close_loops(q, hold=hold)
    assert not found
    if left is None:
        ends = [0.4 * np.exp(1j * q[0]), ground + 0.8 * np.exp(1j * q[2])]
        left = abs(abs(ends[1] - ends[0]) - 1.1)
    assert (found.widest, found.distance) == ("C", pytest.approx(left, abs=1e-6))
    assert f"{left:.3g} m" in found.explain("en")


@pytest.mark.parametrize("driven", [("D",), ("D", "B")])
def test_at_a_dead_point_a_motor_makes_nothing(driven):
    """Crank and coupler in line: the rocker stands still, and no effort of its motor moves the crank."""
    angle = np.arccos((1.5**2 + 1.0 - 0.8**2) / (2 * 1.5))
    pin = 1.5 * np.exp(1j * angle)
    q = np.array([angle, 0.0, np.angle(pin - 1.0)])
    chain = parallel.ClosedChain(four_bar(driven=driven))
    assert chain.error(q) < 1e-12
    found = chain.inverse_dynamics(q, np.zeros(3), np.zeros(3))
    tau = np.zeros(3)
    tau[chain.actuated] = found.tau
    assert tau[2] == pytest.approx(0.0, abs=1e-6)
    assert bool(found) == (driven != ("D",))
    near = chain.close_loops(q - [0.2, 0, 0], hold=["A"]).q
    assert parallel.ClosedChain(four_bar(driven=driven)).inverse_dynamics(near, np.zeros(3), np.zeros(3))


def test_efforts_beyond_all_numbers_end_a_run():
    chain = parallel.ClosedChain(four_bar())
    q = chain.close_loops([0.5, 0.5, 1.5], hold=["A"]).q
    run = parallel.simulate_closed(chain, q, None, [1e200], duration=0.01)
    assert run.status.name == "NOT_FINITE"
    assert np.isfinite(run.q).all()


@pytest.mark.capability("08-18")
@pytest.mark.parametrize("seed", [3, 5])
def test_over_constrained_loops_keep_their_energy(seed):
    """Four skew hinges of Bennett: beside closed loops, where a step of the integrator ends, five rows seem independent
    of which two are, and would lock the linkage."""
    rng = np.random.default_rng(seed)
    bare = mobility.mechanism_of(mobility.library.bennett())
    links = []
    for link in bare.links:
        half = rng.normal(size=(3, 3))
        inertia = 0.01 * half @ half.T + 0.02 * np.eye(3)
        links.append(replace(link, inertial=Inertial(rng.uniform(0.3, 1.0), 0.1 * rng.normal(size=3), inertia)))
    chain = parallel.ClosedChain(replace(bare, links=tuple(links)))
    q = chain.close_loops(np.zeros(chain.n)).q
    run = parallel.simulate_closed(chain, q, chain.rates(q, 3.0 * rng.normal(size=chain.n)), duration=0.6, step=2e-3)
    assert run
    assert run.error.max() < 1e-10
    assert np.abs(run.energy - run.energy[0]).max() < 1e-6 * np.abs(run.energy).max()
    assert np.ptp(run.q[:, 0]) > 1.0
