"""All quantities of real and textbook robots against Pinocchio and MuJoCo; `tests.oracles.compare` at full size."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("pinocchio")
pytest.importorskip("mujoco")

from functools import partial

from mafsil.errors import ModelError
from mafsil.model import Inertial, Joint, JointKind, Link, Mechanism
from mafsil.robot import Robot
from tests.oracles import ours, subjects
from tests.oracles.compare import LIMIT, worst
from tests.oracles.comparison import compared, oracles_of, states_of
from tests.oracles.natural_scale import natural_scale
from tests.sizes import few

STATES = 500
ROUNDING = 1e-11
"""Library robots have exact right angles; files write pi/2 with eleven decimals, which we read as a right angle."""
MANY_JOINTS = 30


def _sized(name: str) -> int:
    """Large robots get fewer states, so that all stay quick."""
    return STATES if subjects.mechanism(name).n <= MANY_JOINTS else 50


@pytest.mark.capability("05-10", "05-47", "05-49", "05-55", "09-2", "09-4", "09-18", "09-57", "09-62")
@pytest.mark.row("R4")
@pytest.mark.parametrize("name", few(subjects.names(), 20))
def test_every_quantity_agrees_with_every_oracle(name: str) -> None:
    mechanism = subjects.mechanism(name)
    table, _ = compared(
        mechanism, oracles_of(name, mechanism), partial(ours.traced, mechanism), states_of(mechanism, _sized(name), 3)
    )
    assert {"pinocchio", "mujoco"} <= table.keys()
    assert worst(table) < (LIMIT if ":" in name else ROUNDING), table


@pytest.mark.row("R2")
@pytest.mark.parametrize("name", ["panda", "puma560", "planar2r_point_masses", "urdf:panda_hand"])
def test_compiled_kernels_agree_with_every_oracle(name: str) -> None:
    mechanism = subjects.mechanism(name)
    table, _ = compared(
        mechanism,
        oracles_of(name, mechanism),
        partial(ours.compiled, Robot(mechanism)),
        states_of(mechanism, STATES, 5),
    )
    assert worst(table) < ROUNDING


@pytest.mark.parametrize("name", ["panda", "urdf:baxter"])
def test_any_frame_has_its_pose_and_jacobian(name: str) -> None:
    mechanism = subjects.mechanism(name)
    robot, states, scale = Robot(mechanism), states_of(mechanism, 20, 7), natural_scale(mechanism)
    for link in (mechanism.link_names[0], mechanism.link_names[2], mechanism.link_names[-1]):
        oracle = oracles_of(name, mechanism.with_tip(link))[0].evaluate(states)
        for quantity, *rest in (("forward_kinematics",), ("jacobian_space",), ("jacobian_body",)):
            mine = getattr(robot, quantity)(states.q, frame=link)
            assert scale.error(quantity, mine, oracle[quantity]).max() < LIMIT, (link, quantity, rest)
        for quantity in ("jacobian_space_rate", "jacobian_body_rate"):
            mine = getattr(robot, quantity)(states.q, states.qd, frame=link)
            assert scale.error(quantity, mine, oracle[quantity]).max() < LIMIT, (link, quantity)


@pytest.mark.capability("09-5")
def test_a_joint_that_moves_nothing_is_named_and_has_no_acceleration() -> None:
    mechanism = subjects.mechanism("urdf:romeo")
    robot = Robot(mechanism)
    zero = np.zeros(robot.n)
    with pytest.raises(ModelError, match="inertia") as caught:
        robot.forward_dynamics(zero, zero, zero)
    joint = next(each for each in mechanism.joints if each.name == caught.value.details["joint"])
    k = robot.joint_names.index(joint.name if joint.mimic is None else joint.mimic.leader)
    oracle = oracles_of("romeo", mechanism)[0]
    assert abs(oracle.evaluate(states_of(mechanism, 1, 1))["mass_matrix"][0, k, k]) < 1e-15


@pytest.mark.row("R1")
@pytest.mark.parametrize("exponent", [-1, -1.9, -2.1, -2.9, -3.1, -5, -6, -7, -8, -9])
def test_axes_that_are_almost_parallel_cost_no_digits(exponent: float) -> None:
    """The frames along such axes are chosen by common normals, whose feet go to infinity with the angle."""
    mechanism = _almost_parallel(10**exponent)
    oracle = oracles_of("almost parallel", mechanism)[:1]
    table, _ = compared(mechanism, oracle, partial(ours.traced, mechanism), states_of(mechanism, 40, 2))
    assert worst(table) < 1e-13, table


def _almost_parallel(angle: float) -> Mechanism:
    inertial = Inertial(2.0, np.array([0.1, 0.05, -0.08]), np.diag([0.02, 0.03, 0.025]))
    links = [Link("base"), *(Link(f"link{k}", inertial) for k in range(6))]
    joints = []
    for k in range(6):
        c, s = np.cos(angle), np.sin(angle)
        T = np.array([[1, 0, 0, 0.3], [0, c, -s, 0.2], [0, s, c, 0.1], [0, 0, 0, 1]])
        joints.append(Joint(f"joint{k}", JointKind.REVOLUTE, links[k].name, links[k + 1].name, T_pj=T))
    return Mechanism.assemble("almost parallel", links, joints)
