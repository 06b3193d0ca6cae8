"""Closed chains run as compiled loops: the same as tick by tick, also where the compiled step is in doubt."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import closed_computed_torque, closed_gravity_compensation, computed_torque, pid
from mafsil.control.laws import driven_trajectory
from mafsil.model import Friction, JointKind
from mafsil.parallel import ClosedChain
from mafsil.simulation import ClosedPlant, Scenario, SensorNoise, WrenchPulse, simulate
from mafsil.simulation.closed_plant import ClosedStepper
from mafsil.simulation.fused import FusedRun
from mafsil.simulation.recording import SimulationStatus
from mafsil.trajectory import quintic
from mafsil.trajectory.profiles import rest
from tests.parallel.closed_chains import four_bar, random_chain

FIELDS = ("q", "qd", "qdd", "tau", "tau_commanded", "tip_position_error", "tip_rotation_error")


def rubbing(mechanism):
    joints = (replace(j, friction=Friction(viscous=0.2, coulomb=0.3)) if j.moves else j for j in mechanism.joints)
    return replace(mechanism, joints=tuple(joints))


def scenario_of(mechanism, law, **more):
    crank = ClosedChain(mechanism, ("A",))
    start = crank.close_loops([0.5, 0.5, 1.5], hold=["A"]).q
    motion = driven_trajectory(crank, quintic(start[:1], start[:1] + 0.6, 0.3), start)
    return Scenario(robot=mf.Robot(mechanism), trajectory=motion, law=law(ClosedChain(mechanism)), **more)


def compare(scenario, bound=1e-9, fields=FIELDS):
    slow, quick = simulate(scenario, fused=False), simulate(scenario, fused=True)
    assert quick.metadata["fused"]
    assert not slow.metadata["fused"]
    assert quick.status is slow.status
    for name in fields:
        a, b = getattr(quick, name), getattr(slow, name)
        assert a.shape == b.shape
        assert np.abs(a - b).max() <= bound * max(1.0, np.abs(b).max()), name
    return quick


@pytest.mark.parametrize("integrator", ["semi_implicit_euler", "rk4", "implicit_friction"])
@pytest.mark.parametrize("driven", [("A",), ("A", "B")], ids=len)
@pytest.mark.parametrize("law", [closed_computed_torque, lambda chain: closed_gravity_compensation(chain, 80.0, 8.0)])
def test_a_compiled_run_is_the_run_tick_by_tick(law, driven, integrator):
    mechanism = four_bar(driven=driven)
    if integrator == "implicit_friction":
        mechanism = rubbing(mechanism)
    scenario = scenario_of(mechanism, law, integrator=integrator)
    tape = compare(scenario)
    assert ClosedChain(mechanism).error(tape.q).max() < 1e-12


@pytest.mark.parametrize("integrator", ["semi_implicit_euler", "rk4", "implicit_friction"])
@pytest.mark.parametrize("law", [closed_computed_torque, lambda chain: closed_gravity_compensation(chain, 80.0, 8.0)])
def test_a_tick_in_two_calls_is_the_tick_part_by_part(monkeypatch, law, integrator):
    mechanism = four_bar(driven=("A", "B"))
    if integrator == "implicit_friction":
        mechanism = rubbing(mechanism)
    push = WrenchPulse(0.05, 0.2, np.array([0, 0, 0.3, 3.0, 2.0, 0.0]))
    scenario = scenario_of(mechanism, law, integrator=integrator, disturbances=(push,))
    calls = []
    run = ClosedStepper._as_kernel
    monkeypatch.setattr(ClosedStepper, "_as_kernel", lambda s, q, p: (calls.append(p), run(s, q, p))[1])
    quick = simulate(scenario, fused=False)
    assert set(calls) == {True, False}
    assert scenario.law._kept.run is not None
    monkeypatch.setattr(ClosedStepper, "_as_kernel", lambda *_: None)
    parts = simulate(replace(scenario, law=law(PartByPart(mechanism))), fused=False)
    for name in FIELDS:
        a, b = getattr(quick, name), getattr(parts, name)
        assert np.abs(a - b).max() <= 1e-9 * max(1.0, np.abs(b).max()), name


class PartByPart(ClosedChain):
    """No law is compiled for it."""

    def holding(self, q):
        return None


def test_a_law_travels_without_its_code():
    scenario = scenario_of(four_bar(), closed_computed_torque)
    simulate(scenario, fused=False)
    law = scenario.law
    again = pickle.loads(pickle.dumps(law))
    assert again._kept.run is None
    reference = scenario.trajectory.at(0.1)
    q, qd = reference.u + 0.01, reference.v
    assert np.array_equal(again(0.1, q, qd, reference), law(0.1, q, qd, reference))


def test_pushes_noise_limits_substeps_and_laws_of_trees():
    mechanism = four_bar()
    push = WrenchPulse(0.05, 0.2, np.array([0, 0, 0.3, 3.0, 2.0, 0.0]))
    noise = SensorNoise(position=1e-4, velocity=1e-3, seed=3)
    compare(scenario_of(mechanism, closed_computed_torque, disturbances=(push,), noise=noise, period=2e-3), 1e-8)
    limited = replace(
        mechanism,
        joints=tuple(replace(j, limits=replace(j.limits, effort=4.0)) if j.moves else j for j in mechanism.joints),
    )
    tape = compare(scenario_of(limited, lambda chain: closed_gravity_compensation(chain, 80.0, 8.0)))
    assert np.abs(tape.tau).max() == 4.0
    compare(scenario_of(mechanism, lambda chain: computed_torque(mf.Robot(mechanism).without_loops())))


def test_laws_with_an_integral():
    mechanism = four_bar()
    law = lambda chain: pid(3, [200.0, 0, 0], [20.0, 0, 0], [300.0, 0, 0])  # noqa: E731
    tape = compare(scenario_of(mechanism, law))
    e, rate = (tape.q_ref - tape.q)[:, 0], (tape.qd_ref - tape.qd)[:, 0]
    expected = 200.0 * e + 20.0 * rate + 300.0 * 1e-3 * np.cumsum(e)
    assert np.abs(tape.tau_commanded[:, 0] - expected).max() < 1e-9 * np.abs(expected).max()


def test_a_doubtful_tick_of_a_law_with_an_integral_takes_the_whole_run_by_hand():
    mechanism = four_bar(1.0, 0.5, 1.0, 0.5)
    q = np.zeros(3)
    law = pid(3, 20.0, 1.0, 5.0)
    scenario = Scenario(robot=mf.Robot(mechanism), trajectory=rest(q + 0.1, 0.05), law=law, q=q, qd=[2.0, -2.0, 2.0])
    quick, slow = simulate(scenario, fused=True), simulate(scenario, fused=False)
    assert not quick.metadata["fused"]
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(quick, name), getattr(slow, name))
    assert quick.status is slow.status


def test_runs_side_by_side_are_those_alone():
    scenario = scenario_of(four_bar(), closed_computed_torque)
    chain = ClosedChain(four_bar())
    q = chain.close_loops(scenario.trajectory.at(0.0).u + np.linspace(-0.1, 0.1, 20)[:, None] * [1, 0, 0], hold=["A"]).q
    tape = simulate(replace(scenario, q=q, qd=0 * q), fused=True)
    assert tape.q.shape == (301, 20, 3)
    for k in (0, 13):
        alone = simulate(replace(scenario, q=q[k], qd=0 * q[k]), fused=True)
        assert np.abs(alone.q - tape.q[:, k]).max() < 1e-11


def test_steps_near_a_singular_configuration_are_made_by_hand(monkeypatch):
    """A parallelogram swings through the place where it could fold: there its rows say less than elsewhere."""
    mechanism = four_bar(1.0, 0.5, 1.0, 0.5)
    chain, robot = ClosedChain(mechanism), mf.Robot(mechanism)
    q = np.array([-0.01, 0.01, -0.01])
    law = pid(3, 0.0)
    scenario = Scenario(robot=robot, trajectory=rest(q, 0.05), law=law, q=q, qd=[2.0, -2.0, 2.0])
    # Accelerations there magnify what rounding leaves of the gaps: they are compared at the same states.
    fields = [name for name in FIELDS if name != "qdd"]
    tape = compare(scenario, 1e-6, fields)
    again = ClosedPlant(robot).acceleration(tape.q, tape.qd, tape.tau)
    assert np.abs(again - tape.qdd).max() < 1e-8 * np.abs(again).max()
    assert (tape.q[:, 0] > 0.0).any()
    assert np.isfinite(tape.qdd).all()
    assert chain.error(tape.q).max() < 1e-10
    by_hand = []
    step = FusedRun._by_hand
    monkeypatch.setattr(FusedRun, "_by_hand", lambda run, k: (by_hand.append(k), step(run, k)))
    folded = replace(scenario, q=np.zeros(3), qd=np.zeros(3))
    assert np.isfinite(compare(folded, 1e-6, fields).q).all()
    assert by_hand[0] == 0
    both = compare(
        replace(scenario, q=np.stack([np.zeros(3), q - 0.3 * np.sign(q)]), qd=np.zeros((2, 3))), 1e-6, fields
    )
    assert both.q.shape == (51, 2, 3)


def test_ten_seconds_of_free_motion_keep_loops_and_energy():
    mechanism = four_bar()
    chain = ClosedChain(mechanism)
    q = chain.close_loops([0.5, 0.5, 1.5], hold=["A"]).q
    law = pid(3, 0.0)
    tape = simulate(
        Scenario(robot=mf.Robot(mechanism), trajectory=rest(q, 10.0), law=law, integrator="rk4"), fused=True
    )
    assert tape
    assert chain.error(tape.q).max() < 1e-12
    terms = chain.terms(tape.q, tape.qd)
    assert np.abs(np.einsum("kmn,kn->km", terms.J, tape.qd)).max() < 1e-11
    assert np.ptp(terms.energy) < 1e-7 * np.ptp(chain.terms(tape.q).energy)


def test_a_run_that_cannot_be_followed_ends_in_words():
    scenario = scenario_of(four_bar(), lambda chain: closed_gravity_compensation(chain, 1e7, 0.0))
    away = ClosedChain(four_bar()).close_loops([1.5, 0.5, 1.5], hold=["A"]).q
    wild = replace(scenario, q=away, qd=np.zeros(3), step=0.02, saturate=False)
    for fused in (True, False):
        tape = simulate(wild, fused=fused)
        assert tape.status in (SimulationStatus.LOOPS_LOST, SimulationStatus.BLOWN_UP)
        assert np.isfinite(tape.q).all()
        assert tape.explain("en")


def test_a_loop_in_space_runs_compiled():
    mechanism, q = random_chain(np.random.default_rng(5), JointKind.REVOLUTE, 7)
    # Not in the order of the joints.
    chain = ClosedChain(mechanism, ("j1", "j0"))
    a = chain.actuated
    motion = driven_trajectory(chain, quintic(q[a], q[a] + 0.1, 0.2), q)
    plant = ClosedPlant(chain.robot, actuated=("j1", "j0"))
    scenario = Scenario(robot=chain.robot, trajectory=motion, law=closed_computed_torque(chain), plant=plant)
    tape = compare(scenario)
    assert chain.error(tape.q).max() < 1e-12
    assert np.abs(tape.q - tape.q_ref).max() < 1e-2
    forces = plant.loop_forces(tape.q, tape.qd, tape.tau)
    assert np.isfinite(forces).all()
