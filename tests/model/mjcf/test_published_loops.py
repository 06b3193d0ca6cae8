"""Mechanisms with loops as published MJCF files write them: classes of defaults, tendons, springs, rods on balls.

The lengths are those of the Robotiq 2F-85 gripper and of a leg of Agility's Cassie.
"""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.model import JointKind, mjcf
from mafsil.parallel import ClosedChain
from mafsil.simulation import Scenario, simulate
from mafsil.trajectory.profiles import rest
from tests.model.mjcf.test_mjcf_loops import MuJoCoChain, across, read

mujoco = pytest.importorskip("mujoco")

MASS = '<inertial pos="0.01 0.01 0.01" mass="0.05" diaginertia="2e-5 2e-5 1e-5"/>'


def finger(side: str, y: float, turn: str) -> str:
    return f"""
      <body name="{side}_driver" pos="0 {0.0306011 * y} 0.054904" quat="{turn}">{MASS}
        <joint name="{side}_driver" class="driver"/>
        <body name="{side}_coupler" pos="0 0.0315 -0.0041">{MASS}<joint name="{side}_coupler" class="coupler"/></body>
      </body>
      <body name="{side}_spring_link" pos="0 {0.0132 * y} 0.0609" quat="{turn}">{MASS}
        <joint name="{side}_spring_link" class="spring_link"/>
        <body name="{side}_follower" pos="0 0.055 0.0375">{MASS}<joint name="{side}_follower" class="follower"/></body>
      </body>"""


GRIPPER = f"""<mujoco model="two fingers">
  <compiler angle="radian" autolimits="true"/>
  <option impratio="10"/>
  <default><default class="gripper">
    <general biastype="affine"/>
    <joint axis="1 0 0"/>
    <default class="driver"><joint range="0 0.8" armature="0.005" damping="0.1" solreflimit="0.005 1"/></default>
    <default class="follower"><joint range="-0.9 0.9" pos="0 -0.018 0.0065"/></default>
    <default class="spring_link"><joint range="-0.3 0.8" damping="0.00125"/></default>
    <default class="coupler"><joint range="-1.57 0"/></default>
  </default></default>
  <worldbody><body name="base" childclass="gripper">{MASS}
    {finger("right", 1.0, "1 0 0 0")}{finger("left", -1.0, "0 0 0 1")}
  </body></worldbody>
  <contact><exclude body1="right_coupler" body2="right_follower"/></contact>
  <tendon><fixed name="split">
    <joint joint="right_driver" coef="0.5"/><joint joint="left_driver" coef="0.5"/>
  </fixed></tendon>
  <equality>
    <connect anchor="0 0 0" body1="right_follower" body2="right_coupler" solref="0.005 1"/>
    <connect anchor="0 0 0" body1="left_follower" body2="left_coupler" solref="0.005 1"/>
    <joint joint1="right_driver" joint2="left_driver" polycoef="0 1 0 0 0" solref="0.005 1"/>
  </equality>
  <actuator><general class="gripper" tendon="split" forcerange="-5 5" gainprm="0.3" biasprm="0 -100 -10"/></actuator>
</mujoco>"""

LEG = f"""<mujoco model="leg">
  <compiler eulerseq="zyx" autolimits="true"/>
  <default><equality solref="0.005 1"/><default class="leg"><geom contype="0"/></default></default>
  <worldbody><body name="hip" pos="0 0 1.1" childclass="leg">{MASS}
    <body name="achilles-rod" pos="0 0 0.045" xyaxes="0.7922 -0.60599 -0.072096 0.60349 0.79547 -0.054922">
      <inertial pos="0.24719 0 0" mass="0.1567" diaginertia="3.754e-06 0.004487 0.004488"/>
      <joint name="achilles-rod" type="ball"/>
    </body>
    <body name="knee" pos="0.12 0 0.0045" xyaxes="0.70711 -0.70711 0 0.70711 0.70711 0">{MASS}
      <joint name="knee" type="hinge" ref="-45" range="-164 -37" damping="1" armature="0.09344"/>
      <body name="shin" pos="0.06068 0.04741 0">{MASS}
        <joint name="shin" type="hinge" range="-20 20"/>
        <body name="tarsus" pos="0.43476 0.02 0" xyaxes="0.52992 0.84805 0 -0.84805 0.52992 0">{MASS}
          <joint name="tarsus" type="hinge" ref="58" range="50 170"/>
          <body name="heel-spring" pos="-0.01269 -0.03059 0.00092"
                xyaxes="-0.91211 0.40829 0.036948 -0.40992 -0.90952 -0.068841">{MASS}
            <joint name="heel-spring" type="hinge"/>
          </body>
        </body>
      </body>
    </body>
  </body></worldbody>
  <equality><connect body1="achilles-rod" body2="heel-spring" anchor="0.5012 0 0"/></equality>
  <actuator><motor name="knee" joint="knee" gear="16" ctrlrange="-12.2 12.2"/></actuator>
</mujoco>"""


class NoEffort:
    """The mechanism by itself."""

    def __call__(self, t, q, qd, reference):
        return np.zeros_like(q)

    def session(self, period):
        return self


def falls(mechanism, q, seconds=0.05):
    """A short run without efforts, from rest."""
    robot = mf.Robot(mechanism)
    chain = ClosedChain(robot)
    tape = simulate(Scenario(robot=robot, trajectory=rest(q, seconds), law=NoEffort(), step=5e-4, integrator="rk4"))
    assert tape
    assert chain.error(tape.q).max() < 1e-10
    return tape


@pytest.mark.capability("02-65")
def test_a_gripper_of_two_fingers():
    mechanism = read(GRIPPER)
    assert [loop.kind for loop in mechanism.loops] == [JointKind.SPHERICAL] * 2
    chain = ClosedChain(mechanism)
    assert chain.n == 7
    found = mf.mobility(mechanism)
    assert found.mobility == found.instantaneous.mobility == 3  # drivers together, and each finger's spring
    start = chain.close_loops(np.zeros(7))
    assert start
    tape = falls(mechanism, start.q)
    energy = chain.terms(tape.q, tape.qd).energy
    assert energy[-1] <= energy[0] + 1e-9
    assert np.abs(tape.q[-1] - start.q).max() > 1e-3


def test_a_leg_with_a_rod_on_balls():
    """A ball joint in the tree is three hinges; written so, all numbers are MuJoCo's."""
    text, _ = mjcf.repair(LEG)
    mechanism = read(text)
    assert mechanism.joint_names == mjcf.read(LEG).joint_names
    chain = ClosedChain(mechanism)
    assert (chain.n, len(mechanism.loops)) == (7, 1)
    assert [mechanism.joint_names[k] for k in chain.actuated] == ["knee"]
    found = mf.mobility(mechanism)
    assert found.mobility == 4  # of which one spins the rod between its balls
    assert "idle" in found.explain("en")
    start = chain.close_loops(np.zeros(7))
    assert start
    tape = falls(mechanism, start.q)
    peer = MuJoCoChain(text)
    for q, qd in zip(tape.q[::40], tape.qd[::40], strict=True):
        M, h, J, gap = peer.terms(q, qd)
        terms = chain.terms(q, qd)
        assert np.abs(gap).max() < 1e-9
        np.testing.assert_allclose(terms.M, M, atol=1e-12)
        np.testing.assert_allclose(terms.h, h, atol=1e-10)
        np.testing.assert_allclose(across(terms.J), across(J), atol=1e-8)


def test_cables_are_left_out_by_name():
    """Springs of cables and what ties their lengths are no part of a mechanism; the file is read, and it is said."""
    cable = '<tendon><spatial name="cable" stiffness="5"><site site="a"/><site site="b"/></spatial></tendon>'
    text = LEG.replace('type="ball"', 'type="hinge"').replace("<actuator>", cable + "<actuator>")
    text = text.replace('<joint name="heel-spring"', '<site name="a"/><joint name="heel-spring"')
    text = text.replace('<joint name="shin"', '<site name="b"/><joint name="shin"')
    mechanism = read(text.replace("<equality>", '<equality><tendon tendon1="cable"/>'))
    notes = " ".join(mechanism.provenance.notes)
    assert "M0702 tendon of <equality>" in notes
    assert "M0702 stiffness of <spatial>" in notes
    assert len(mechanism.loops) == 1
