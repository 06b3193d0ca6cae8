"""Joints that follow others along curves, against MuJoCo's open tree and the chain rule, and what takes lines alone."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from numpy.polynomial.polynomial import polyder, polyval

import mafsil as mf
from mafsil.arrays import Floats
from mafsil.collision import Checker
from mafsil.errors import ModelError
from mafsil.model import Mechanism, Mimic, mjcf, sdf, urdf
from mafsil.robot import Robot
from tests.oracles.mujoco_model import MuJoCoOracle
from tests.oracles.random_tree import random_tree
from tests.oracles.states import States, sample

KNEE = """<mujoco><compiler angle="radian"/><worldbody><body name="thigh">
  <inertial pos="0.01 0.02 -0.2" mass="3" diaginertia="0.05 0.04 0.01"/>
  <joint name="hip" axis="0 1 0" range="-2 2"/>
  <body name="shank" pos="0 0 -0.4"><inertial pos="0 0.01 -0.2" mass="2" fullinertia="0.03 0.03 0.012 0.001 0 0"/>
    <joint name="knee" axis="0 1 0" ref="0.2" range="-2 2"/>
    <body name="patella"><inertial pos="0.04 0 0" mass="0.3" diaginertia="1e-3 1e-3 1e-3"/>
      <joint name="glide" type="slide" axis="1 0 0.2" ref="0.01" armature="0.05" range="-1 1"/>
      <body name="tendon" pos="0.1 0 0"><inertial pos="0.04 0 0.1" mass="0.2" diaginertia="1e-3 1e-3 1e-3"/>
        <joint name="last" axis="1 0 0"/></body>
    </body></body></body></worldbody>
  <equality><joint joint1="last" joint2="glide" polycoef="0.1 0 3"/>
  <joint joint1="glide" joint2="knee" polycoef="0.03 -0.08 0.05 0.02 -0.01"/></equality></mujoco>"""
CURVES = ((0.1,), (0.0, 0.2), (-0.15, 0.05, 0.02))


def curved(mechanism: Mechanism, rng: np.random.Generator) -> Mechanism:
    """Each mimic made a curve of degree two to four."""
    return replace(mechanism, joints=tuple(
        joint if joint.mimic is None else replace(joint, mimic=replace(joint.mimic, higher=CURVES[rng.integers(3)]))
        for joint in mechanism.joints
    ))  # fmt: skip


def independent(mechanism: Mechanism) -> Mechanism:
    """The same bodies where every joint owns its coordinate."""
    return replace(mechanism, joints=tuple(replace(joint, mimic=None) for joint in mechanism.joints))


def joints_along(mechanism: Mechanism, q: Floats, order: int) -> Floats:
    """(moving joints,) values or derivatives by the leading coordinate."""
    column, found = {joint.name: k for k, joint in enumerate(mechanism.coordinates)}, []
    for joint in mechanism.joints:
        if not joint.moves:
            continue
        m = joint.mimic or Mimic(joint.name)
        coefficients = np.array([m.offset, m.multiplier, *m.higher])
        found.append(polyval(q[column[m.leader]], polyder(coefficients, order) if order else coefficients))
    return np.array(found)


def selection(mechanism: Mechanism) -> Floats:
    """(moving joints, n) one where a coordinate moves a joint."""
    names = mechanism.joint_names
    rows = [j.name if j.mimic is None else j.mimic.leader for j in mechanism.joints if j.moves]
    return np.array([[float(name == row) for name in names] for row in rows])


def pulled_back(mechanism: Mechanism, s: States) -> dict[str, Floats]:
    """MuJoCo's numbers of the open tree, brought to the coordinates by the chain rule, state by state."""
    oracle, E, rows = MuJoCoOracle(independent(mechanism)), selection(mechanism), []
    for q, qd, qdd, tau, F in zip(*s.arguments(("q", "qd", "qdd", "tau", "tip_wrench")), strict=True):
        G, bend = joints_along(mechanism, q, 1)[:, None] * E, joints_along(mechanism, q, 2)[:, None] * E
        y = [joints_along(mechanism, q, 0), G @ qd, G @ qdd + bend @ qd**2]
        a = oracle.evaluate(States(*(x[None] for x in (*y, E @ tau, F))))
        free = oracle.evaluate(States(*(x[None] for x in (y[0], y[1], bend @ qd**2, E @ tau, F))))
        M, bias = G.T @ a["mass_matrix"][0] @ G, G.T @ free["inverse_dynamics"][0]
        row = {name: a[name][0] for name in ("link_poses", "forward_kinematics", "kinetic_energy", "potential_energy")}
        row |= {name: a[name][0] @ G for name in ("jacobian_space", "jacobian_body")}
        row |= {
            f"{name}_rate": a[f"{name}_rate"][0] @ G + a[name][0] @ (bend * qd)
            for name in ("jacobian_space", "jacobian_body")
        }
        row |= {name: G.T @ a[name][0] for name in ("inverse_dynamics", "gravity_torque")}
        row |= {"mass_matrix": M, "forward_dynamics": np.linalg.lstsq(M, tau - bias)[0]}
        row["velocity_torque"] = bias - row["gravity_torque"]
        rows.append(row)
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


@pytest.mark.parametrize("seed", range(12))
def test_curves_are_the_open_tree_by_the_chain_rule(seed: int) -> None:
    """All that MuJoCo has of the open tree; the rest against the second method of `verify`."""
    rng = np.random.default_rng([71, seed])
    mechanism = random_tree(rng, most_joints=12, helical=False)
    while not any(joint.mimic is not None for joint in mechanism.joints):
        mechanism = random_tree(rng, most_joints=12, helical=False)
    mechanism = curved(mechanism, rng)
    robot, s = Robot(mechanism), sample(mechanism, 5, rng)
    for name, value in pulled_back(mechanism, s).items():
        if name == "forward_dynamics":
            continue
        inputs = {"inverse_dynamics": ("q", "qd", "qdd"), "velocity_torque": ("q", "qd"), "kinetic_energy": ("q", "qd")}
        rates = ("q", "qd") if name.endswith("_rate") else ("q",)
        ours = getattr(robot, name)(*s.arguments(inputs.get(name, rates)))
        assert np.allclose(ours, value, rtol=1e-9, atol=1e-9 * max(1.0, np.abs(value).max())), name


def test_a_knee_of_a_file_moves_as_in_mujoco() -> None:
    """A chain of two curves (of degree eight together), references, armature; MuJoCo holds the couplings softly."""
    robot = Robot(mjcf.read(KNEE))
    assert robot.joint_names == ("hip", "knee")
    model = mujoco.MjModel.from_xml_string(KNEE)
    data, q = mujoco.MjData(model), np.array([0.3, 0.9])
    x = q[1] - 0.2
    glide = 0.01 + polyval(x, [0.03, -0.08, 0.05, 0.02, -0.01])
    last = polyval(glide - 0.01, [0.1, 0, 3])
    data.qpos[:] = [*q, glide, last]
    mujoco.mj_forward(model, data)
    assert np.abs(data.efc_pos[: data.ne]).max() < 1e-15
    poses = robot.link_poses(q)
    for k, name in enumerate(robot.mechanism.link_names):
        if name != "world":
            assert np.allclose(poses[k, :3, 3], data.body(name).xpos, atol=1e-14)
    report = mf.verify(robot)
    assert report, report.explain()


def test_what_takes_lines_alone_says_so() -> None:
    """Refused by name: nothing is computed with the linear part of a curve."""
    robot = Robot(mjcf.read(KNEE))
    for task in (
        lambda: Checker(robot, radius=0.02), lambda: mf.mobility(robot.mechanism),
        lambda: robot.with_locked_joints({"glide": 0.0}),
        lambda: urdf.write(robot.mechanism), lambda: sdf.write(robot.mechanism), lambda: mjcf.write(robot.mechanism),
    ):  # fmt: skip
        with pytest.raises(ModelError, match=r"glide|last"):
            task()
    held = robot.with_locked_joints({"knee": 0.9})
    assert held.n == 1
    assert np.allclose(held.link_poses([0.3]), robot.link_poses([0.3, 0.9]), atol=1e-14)


def test_curves_of_four_degrees_are_written_to_mjcf() -> None:
    """And read back with the same numbers, the velocity efforts too."""
    first = Robot(mjcf.read(KNEE.replace('<joint joint1="last" joint2="glide" polycoef="0.1 0 3"/>', "")))
    again = Robot(mjcf.read(mjcf.write(first.mechanism)))
    q, qd, qdd = np.random.default_rng(1).uniform(-1, 1, (3, 20, first.n))
    assert np.allclose(first.inverse_dynamics(q, qd, qdd), again.inverse_dynamics(q, qd, qdd), atol=1e-12)


def test_inverse_kinematics_and_simulation_follow_a_curve() -> None:
    """The pose is found again; the plant under computed torque stays on its path."""
    robot = Robot(mjcf.read(KNEE))
    q = np.array([0.4, 0.7])
    found = robot.ik(robot.fk(q), q + 0.05)
    assert found
    assert np.allclose(robot.fk(found.q), robot.fk(q), atol=1e-9)
    recording = robot.simulate(mf.trajectory.quintic([0.1, 0.2], [0.8, -0.3], duration=1.0))
    assert np.abs(recording.q - recording.q_ref).max() < 1e-3


def test_friction_along_a_curve_is_refused_with_what_to_leave_out() -> None:
    text = KNEE.replace('name="last"', 'name="last" damping="0.3"')
    assert text != KNEE
    robot, motion = Robot(mjcf.read(text)), mf.trajectory.quintic([0.1, 0.2], [0.3, -0.1], duration=0.3)
    with pytest.raises(ModelError, match=r"'last' has friction .* friction=False"):
        robot.friction_torque([0.1, 0.1])
    law = mf.control.computed_torque(robot, friction=False)
    plant = mf.simulation.Plant(robot, friction=False)
    assert mf.simulate(mf.Scenario(robot=robot, plant=plant, trajectory=motion, law=law))
