"""Mechanisms with loops in scenarios: laws at the driven joints, closed loops, and MuJoCo's equality constraints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import closed_computed_torque, closed_gravity_compensation, computed_torque
from mafsil.control.laws import driven_trajectory
from mafsil.errors import InputError
from mafsil.model import Friction, JointKind
from mafsil.parallel import ClosedChain, simulate_closed
from mafsil.simulation import ClosedPlant, Scenario, WrenchPulse, simulate
from mafsil.simulation.recording import SimulationStatus
from mafsil.trajectory import Motion, quintic
from mafsil.trajectory.profiles import rest
from tests.parallel.closed_chains import four_bar, random_chain

mujoco = pytest.importorskip("mujoco")


class NoEffort:
    """The mechanism by itself."""

    def __call__(self, t, q, qd, reference):
        return np.zeros_like(q)

    def session(self, period):
        return self


def crank_scenario(law=None, start=0.5, end=2.0, duration=1.0, mechanism=None, **more):
    mechanism = four_bar() if mechanism is None else mechanism
    chain = ClosedChain(mechanism)
    q_0 = chain.close_loops([start, 0.5, 1.5], hold=["A"]).q
    motion = driven_trajectory(chain, quintic([start], [end], duration), q_0)
    law = closed_computed_torque(chain) if law is None else law(chain)
    return chain, Scenario(robot=mf.Robot(mechanism), trajectory=motion, law=law, **more)


@pytest.mark.capability("08-43")
def test_a_driven_trajectory_is_one_motion_with_closed_loops():
    chain, scenario = crank_scenario()
    motion, t, h = scenario.trajectory, np.linspace(0.05, 0.95, 40), 1e-5
    here, before, after = (motion.at(x) for x in (t, t - h, t + h))
    assert chain.error(here.u).max() < 1e-12
    assert np.abs(here.u[:, 0] - motion.driven.at(t).u[:, 0]).max() < 1e-12
    assert np.abs((after.u - before.u) / (2 * h) - here.v).max() < 1e-6
    assert np.abs((after.v - before.v) / (2 * h) - here.a).max() < 1e-5
    assert np.abs((after.a - before.a) / (2 * h) - motion.jerk(t)).max() < 1e-2 * np.abs(motion.jerk(t)).max()


@pytest.mark.parametrize("integrator", ["semi_implicit_euler", "rk4"])
def test_computed_torque_follows_with_closed_loops(integrator):
    chain, scenario = crank_scenario(duration=1.0, integrator=integrator)
    tape = simulate(scenario)
    assert tape
    assert chain.error(tape.q).max() < 1e-10
    assert np.abs(tape.q - tape.q_ref).max() < 5e-3
    assert not tape.tau[:, 1:].any()
    # An error at the start dies out as e'' + 2 w e' + w^2 e = 0 says.
    away = chain.close_loops(scenario.trajectory.at(0.0).u + np.array([0.02, 0, 0]), hold=["A"]).q
    moved = simulate(replace(scenario, q=away, integrator="rk4"))
    e, t = (moved.q_ref - moved.q)[:, 0], moved.t
    assert np.abs(e + 0.02 * np.exp(-20 * t) * (1 + 20 * t)).max() < 1e-3


def test_gravity_compensation_holds_the_mechanism():
    chain, scenario = crank_scenario(lambda chain: closed_gravity_compensation(chain, 50.0, 10.0), 0.7, 0.7, 1.0)
    tape = simulate(scenario)
    assert np.abs(tape.q - tape.q[0]).max() < 1e-9
    assert np.allclose(tape.tau[:, 0], chain.inverse_dynamics(tape.q[0], np.zeros(3), np.zeros(3)).tau[0])


def test_ten_seconds_of_free_motion_keep_loops_and_energy():
    mechanism = four_bar()
    chain = ClosedChain(mechanism)
    q = chain.close_loops([0.5, 0.5, 1.5], hold=["A"]).q
    tape = simulate(Scenario(robot=mf.Robot(mechanism), trajectory=rest(q, 10.0), law=NoEffort(), integrator="rk4"))
    assert tape
    assert chain.error(tape.q).max() < 1e-10
    energy = chain.terms(tape.q, tape.qd).energy
    assert np.ptp(energy) < 1e-5 * np.ptp(chain.terms(tape.q).energy)
    own = simulate_closed(chain, q, duration=1.0, step=1e-3)
    assert np.abs(own.q - tape.q[:1001]).max() < 1e-9


@pytest.mark.parametrize("kind", [JointKind.SPHERICAL, JointKind.FIXED])
def test_mujoco_moves_it_the_same(kind, tmp_path):
    """Free motion beside MuJoCo with stiff equality constraints, which yield a little."""
    mechanism, q = random_chain(np.random.default_rng(3), kind)
    assert mechanism.n == 9
    tape = simulate(
        Scenario(robot=mf.Robot(mechanism), trajectory=rest(q, 0.1), law=NoEffort(), integrator="rk4", step=1e-3)
    )
    from mafsil.model import mjcf

    model = mujoco.MjModel.from_xml_string(mjcf.write(mechanism))
    model.opt.timestep, model.opt.integrator = 1e-5, mujoco.mjtIntegrator.mjINT_RK4
    model.eq_solref[:], model.eq_solimp[:] = (2e-4, 1.0), (0.9999, 0.9999, 0.001, 0.5, 2)
    data = mujoco.MjData(model)
    order = [model.joint(joint.name).qposadr[0] for joint in mechanism.coordinates]
    data.qpos[order] = q
    worst = 0.0
    for k in range(1, len(tape.t)):
        for _ in range(100):
            mujoco.mj_step(model, data)
        worst = max(worst, float(np.abs(data.qpos[order] - tape.q[k]).max()))
    assert worst < 5e-4 * max(1.0, np.abs(tape.q - q).max())


def test_friction_limits_and_pushes_act_at_the_joints_they_name():
    mechanism = four_bar()
    rubbing = replace(
        mechanism,
        joints=tuple(
            replace(joint, friction=Friction(viscous=0.2, coulomb=0.3)) if joint.name == "D" else joint
            for joint in mechanism.joints
        ),
    )
    chain, scenario = crank_scenario(mechanism=rubbing, duration=1.5)
    tape = simulate(scenario)
    assert tape.metadata["integrator"] in ("implicit_friction", "semi_implicit_euler")
    smooth = simulate(crank_scenario(duration=1.5)[1])
    assert np.abs(tape.q - smooth.q).max() > 1e-4
    still = crank_scenario(lambda c: closed_gravity_compensation(c, 200.0, 20.0), 0.7, 0.7, 2.0)
    pushed = simulate(replace(still[1], disturbances=(WrenchPulse(0.0, 5.0, np.array([0, 0, 0, 3.0, 2.0, 0.0])),)))
    q = pushed.q[-1]
    J = chain.robot.jacobian_body(q)
    load = J.T @ [0, 0, 0, 3.0, 2.0, 0]
    holding = pushed.tau[-1]
    free = chain.rates(q, [1.0, 0, 0], hold=["A"])
    weight = chain.robot.gravity_torque(q)
    assert abs(free @ (holding + load - weight)) < 1e-6


def test_redundant_and_other_laws_only_drive_what_is_driven():
    robot = mf.Robot(four_bar())
    chain, scenario = crank_scenario(lambda chain: computed_torque(robot.without_loops()))
    tape = simulate(scenario)
    assert chain.error(tape.q).max() < 1e-10
    forces = ClosedPlant(robot).loop_forces(tape.q, tape.qd, tape.tau)
    terms = chain.terms(tape.q, tape.qd)
    tau = np.zeros_like(tape.tau)
    tau[:, 0] = tape.tau[:, 0]
    rest_of_it = np.einsum("kij,kj->ki", terms.M, tape.qdd) + terms.h - tau
    assert np.abs(rest_of_it - np.einsum("kmi,km->ki", terms.J, forces)).max() < 1e-8


def test_what_cannot_be_run_is_said():
    mechanism = four_bar()
    chain, scenario = crank_scenario()
    with pytest.raises(InputError, match="gape"):
        replace(scenario, q=np.array([0.5, 0.5, 1.5]))
    with pytest.raises(InputError, match=r"n = 1"):
        driven_trajectory(chain, quintic([0, 0], [1, 1], 1.0), [0.5, 0.5, 1.5])
    short = four_bar(ground=1.0, crank=0.7, coupler=0.6, rocker=0.5)
    stiff = ClosedChain(short)
    q = stiff.close_loops([0.3, 0.5, 1.5], hold=["A"]).q
    with pytest.raises(InputError, match="no closed configuration was found"):
        driven_trajectory(stiff, quintic([0.3], [2.5], 1.0), q)
    parallelogram = ClosedChain(four_bar(1.0, 0.5, 1.0, 0.5))
    with pytest.raises(InputError, match="do not decide"):
        driven_trajectory(parallelogram, rest([0.0], 1.0), [0.0, 0.0, 0.0])
    huge = simulate(replace(scenario, law=Pushing(), step=0.05, duration=3.0))
    assert huge.status in (SimulationStatus.LOOPS_LOST, SimulationStatus.BLOWN_UP)
    assert mechanism.n == 3


class Pushing(NoEffort):
    """An effort that no step of this length can follow."""

    def __call__(self, t, q, qd, reference: Motion):
        return np.full_like(q, 1e5)
