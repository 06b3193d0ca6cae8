"""Inverse kinematics of mechanisms with loops: every configuration checked again, planted ones found."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil import mobility as mo
from mafsil import parallel
from mafsil.errors import InputError, ModelError
from mafsil.model import JointKind, mjcf
from mafsil.parallel import ClosedChain, closed_inverse_kinematics
from mafsil.parallel.closed_poses import ClosedPoseStatus
from tests.parallel.closed_chains import random_chain

ROBOTS = Path(__file__).resolve().parents[2] / "examples" / "robots"


@pytest.fixture(scope="module")
def palletiser():
    return ClosedChain(mf.load(ROBOTS / "palletiser.xml"))


@pytest.fixture(scope="module")
def hexapod():
    return ClosedChain(mf.load(ROBOTS / "stewart.xml", tip="platform"))


@pytest.mark.capability("08-31", "08-32", "08-35")
@pytest.mark.parametrize("seed", range(4))
def test_planted_poses_of_a_platform_are_found(hexapod, seed):
    rng = np.random.default_rng(seed)
    planted = hexapod.close_loops(0.12 * rng.normal(size=hexapod.n))
    assert planted
    T = hexapod.robot.forward_kinematics(planted.q)
    found = closed_inverse_kinematics(hexapod, T, seed=seed)
    limits = hexapod.robot.limits
    assert bool(found) == bool(((found.q >= limits.lower) & (found.q <= limits.upper)).all(axis=1).any())
    assert found.freedom == 0
    assert hexapod.error(found.q).max() < 1e-12
    reached = hexapod.robot.forward_kinematics(found.q)
    np.testing.assert_allclose(reached, np.broadcast_to(T, reached.shape), atol=1e-8)
    assert np.abs(found.q - planted.q).max(axis=1).min() < 1e-8


def test_leg_lengths_are_those_of_the_platform_in_closed_form(hexapod):
    base = np.radians([-15, 15, 105, 135, 225, 255])
    top = np.radians([-45, 45, 75, 165, 195, 285])
    closed_form = parallel.StewartPlatform.on_circles(0.5, 0.3, base, top)
    tip = hexapod.robot.forward_kinematics(np.zeros(hexapod.n))
    T = np.eye(4)
    T[:3, :3] = mf.geometry.rotation.exp([0.1, -0.15, 0.2])
    T[:3, 3] = [0.05, -0.04, 0.63]
    lengths, home = closed_form.lengths(T), closed_form.lengths(_raised(0.6))
    found = closed_inverse_kinematics(hexapod, T @ np.linalg.inv(_raised(0.6)) @ tip)
    slides = [hexapod.robot.joint_names.index(f"leg {k}") for k in range(1, 7)]
    np.testing.assert_allclose(found.q[0][slides], lengths - home, atol=1e-5)


def _raised(z):
    T = np.eye(4)
    T[2, 3] = z
    return T


@pytest.mark.capability("08-33", "08-35")
def test_all_ways_to_close_a_palletiser_are_found(palletiser):
    """Two elbows of the tip, two ways to close the parallelogram: four by elementary geometry."""
    q = palletiser.close_loops([0.3, 0.2, 0.1, -0.1], hold=["shoulder", "lever"]).q
    T = palletiser.robot.forward_kinematics(q)
    found = closed_inverse_kinematics(palletiser, T, task="position", starts=100)
    assert len(found) == 4
    assert found.within.sum() == 1
    places = palletiser.robot.forward_kinematics(found.q)[:, :3, 3]
    np.testing.assert_allclose(places, np.broadcast_to(T[:3, 3], places.shape), atol=1e-9)
    assert closed_inverse_kinematics(palletiser, T)
    T[0, 3] += 5.0
    missed = closed_inverse_kinematics(palletiser, T, task="position")
    assert missed.status is ClosedPoseStatus.NOT_FOUND
    # The tool is 0.35 m from the elbow, that 0.4 m from the shoulder.
    shoulder = np.array([0, 0, 0.3])
    assert missed.position_error == pytest.approx(np.linalg.norm(T[:3, 3] - shoulder) - 0.75, abs=1e-6)
    assert "nothing is proved" in missed.explain("en").lower()
    assert missed.explain("ar") != missed.explain("en")


def test_out_of_its_plane_and_beyond_its_limits(palletiser):
    q = palletiser.close_loops([0.3, 0.2, 0.1, -0.1], hold=["shoulder", "lever"]).q
    T = palletiser.robot.forward_kinematics(q)
    T[1, 3] = 0.05
    missed = closed_inverse_kinematics(palletiser, T, task="position")
    assert not missed
    assert missed.position_error == pytest.approx(0.05, abs=1e-9)
    assert closed_inverse_kinematics(palletiser, T, task="position", tolerance=0.06)
    bent = palletiser.close_loops([-1.5, 0.2, -1.2, 0.1], hold=["shoulder", "lever"])
    assert bent
    found = closed_inverse_kinematics(palletiser, palletiser.robot.forward_kinematics(bent.q))
    assert found.status is ClosedPoseStatus.OUTSIDE
    assert len(found)
    assert not found


@pytest.mark.capability("08-32")
@pytest.mark.parametrize("kind", list(JointKind), ids=lambda kind: kind.value)
def test_loops_closed_by_any_joint(kind):
    mechanism, q = random_chain(np.random.default_rng(0), kind)
    chain = ClosedChain(mechanism)
    T = chain.robot.forward_kinematics(q)
    for task in ("pose", "axis", "position"):
        found = closed_inverse_kinematics(chain, T, q + 0.05, task=task, starts=6)
        assert len(found)
        assert chain.error(found.q).max() < 1e-9
        reached = chain.robot.forward_kinematics(found.q)
        np.testing.assert_allclose(reached[:, :3, 3], np.broadcast_to(T[:3, 3], (len(found), 3)), atol=1e-8)


def test_families_are_called_so():
    """The legs of a platform with two balls each spin: a pose is reached by a family of six freedoms."""
    chain = ClosedChain(mo.mechanism_of(mo.library.stewart_gough("SPS")))
    found = closed_inverse_kinematics(
        chain, chain.robot.forward_kinematics(np.zeros(chain.n)), np.zeros(chain.n), starts=4
    )
    assert found.status is ClosedPoseStatus.FAMILY
    assert found.freedom == 6


def test_wrong_input_is_named(palletiser):
    T = np.eye(4)
    with pytest.raises(InputError, match="task"):
        closed_inverse_kinematics(palletiser, T, task="place")
    with pytest.raises(InputError, match="T"):
        closed_inverse_kinematics(palletiser, np.full((4, 4), np.nan))
    with pytest.raises(InputError, match="T"):
        closed_inverse_kinematics(palletiser, np.ones((4, 4)))
    with pytest.raises(InputError, match="q_0"):
        closed_inverse_kinematics(palletiser, T, [0.0, 0.0])
    with pytest.raises(InputError, match="starts"):
        closed_inverse_kinematics(palletiser, T, starts=-1)
    with pytest.raises(ModelError, match="loop"):
        closed_inverse_kinematics("ur5e", T)


def test_open_chain_functions_refuse_loops(palletiser):
    with pytest.raises(ModelError, match="closed_inverse_kinematics"):
        mf.inverse_kinematics(mf.Robot(palletiser.robot.mechanism), np.eye(4))


def test_three_parallelograms_keep_a_tool_level():
    """A palletiser as they are built: motors at the shoulder, rods that keep the wrist level wherever it stands."""
    levelled = ClosedChain(mjcf.read(LEVELLED))
    assert mf.mobility(levelled.robot.mechanism).mobility == 4
    rng, driven = np.random.default_rng(0), ["turn", "shoulder", "lever", "roll"]
    start = np.zeros((12, levelled.n))
    where = [levelled.robot.joint_names.index(name) for name in driven]
    start[:, where] = rng.uniform(-0.4, 0.4, (12, 4))
    found = levelled.close_loops(start, hold=driven)
    assert found
    np.testing.assert_allclose(levelled.robot.forward_kinematics(found.q)[:, :3, 2], [[0, 0, 1]] * 12, atol=1e-12)


LEVELLED = """<mujoco model="levelled palletiser">
  <compiler angle="radian"/><default><joint type="hinge" axis="0 1 0"/></default>
  <worldbody><body name="column"><joint name="turn" axis="0 0 1"/>
    <inertial pos="0 0 .2" mass="60" diaginertia="2 2 2"/>
    <body name="upper" pos="0.1 0 0.5"><joint name="shoulder"/>
      <inertial pos="0 0 .5" mass="30" diaginertia="3 3 .3"/>
      <body name="forearm" pos="0 0 1"><joint name="elbow"/>
        <inertial pos=".5 0 0" mass="20" diaginertia=".2 2 2"/>
        <body name="wrist" pos="1.1 0 0"><joint name="wrist"/>
          <inertial pos=".05 0 0" mass="5" diaginertia=".05 .05 .05"/>
          <body name="tool" pos="0.1 0 -0.1"><joint name="roll" axis="0 0 1"/>
            <inertial pos="0 0 0" mass="3" diaginertia=".02 .02 .02"/></body></body></body>
      <body name="triangle" pos="0 0 1"><joint name="tri"/>
        <inertial pos="0 0 .1" mass="3" diaginertia=".03 .03 .03"/>
        <body name="rod2" pos="0.05 0 0.2"><joint name="rod2"/>
          <inertial pos=".5 0 0" mass="3" diaginertia=".01 .3 .3"/></body></body></body>
    <body name="rod1" pos="-0.1 0 0.4"><joint name="rod1"/>
      <inertial pos="0 0 .5" mass="3" diaginertia=".3 .3 .01"/></body>
    <body name="lever" pos="0.1 0 0.5"><joint name="lever"/>
      <inertial pos="-.1 0 0" mass="6" diaginertia=".05 .1 .1"/>
      <body name="rod3" pos="-0.25 0 0"><joint name="rod3"/>
        <inertial pos="0 0 .5" mass="3" diaginertia=".3 .3 .01"/></body></body>
  </body></worldbody>
  <equality>
    <connect body1="rod1" body2="triangle" anchor="0 0 1"/><connect body1="rod2" body2="wrist" anchor="1.1 0 0"/>
    <connect body1="rod3" body2="forearm" anchor="0 0 1"/>
  </equality>
  <actuator><motor joint="turn"/><motor joint="shoulder"/><motor joint="lever"/><motor joint="roll"/></actuator>
</mujoco>"""
