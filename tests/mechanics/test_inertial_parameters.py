"""Efforts as linear functions of inertial parameters: regressors, payloads, base parameters, friction."""

from dataclasses import replace

import numpy as np
import pytest

from mafsil.errors import InputError
from mafsil.mechanics.inertial_parameters import inertial_of, parameters_of
from mafsil.model import Friction, Inertial, Link, library
from mafsil.robot import Robot
from tests.oracles.random_tree import random_tree
from tests.oracles.states import sample


def mechanism_named(name):
    return random_tree(np.random.default_rng(0), most_joints=12) if name == "tree" else library.load(name)


@pytest.fixture(params=["panda", "stanford_arm", "tree"], scope="module")
def robot(request):
    return Robot(mechanism_named(request.param))


def close(a, b, limit=1e-12):
    assert np.abs(a - b).max() < limit * max(1.0, np.abs(b).max())


def with_inertial(mechanism, name, inertial):
    links = tuple(replace(link, inertial=inertial) if link.name == name else link for link in mechanism.links)
    return replace(mechanism, links=links)


@pytest.mark.capability("09-18", "09-48")
def test_efforts_are_linear_in_the_parameters(robot):
    s = sample(robot.mechanism, 5, np.random.default_rng(1))
    Y = robot.regressor(s.q, s.qd, s.qdd)
    assert Y.shape == (5, robot.n, len(robot.mechanism.links), 10)
    still = np.zeros_like(s.qd)
    armature = robot.inverse_dynamics(s.q, still, s.qdd) - robot.inverse_dynamics(s.q, still, still)
    links = np.einsum("bilk,lk->bi", robot.regressor(s.q, still, s.qdd), robot.inertial_parameters)
    links = links - np.einsum("bilk,lk->bi", robot.regressor(s.q, still, still), robot.inertial_parameters)
    total = np.einsum("bilk,lk->bi", Y, robot.inertial_parameters) + armature - links
    close(total, robot.inverse_dynamics(s.q, s.qd, s.qdd))


@pytest.mark.capability("09-48")
def test_regressor_against_pinocchio():
    pin = pytest.importorskip("pinocchio")
    from tests.oracles.pinocchio_model import model_of

    robot = Robot(library.load("panda"))
    model, _ = model_of(robot.mechanism)
    s = sample(robot.mechanism, 3, np.random.default_rng(3))
    ours = robot.regressor(s.q, s.qd, s.qdd)
    names = robot.mechanism.link_names
    bodies = [names.index(joint.child) for joint in robot.mechanism.joints if joint.moves]
    order = [0, 1, 2, 3, 4, 7, 5, 8, 9, 6]  # m, h, Ixx, Ixy, Iyy, Ixz, Iyz, Izz
    for k in range(3):
        theirs = pin.computeJointTorqueRegressor(model, model.createData(), s.q[k], s.qd[k], s.qdd[k])
        close(ours[k][:, bodies][:, :, order].reshape(7, 70), theirs)


@pytest.mark.capability("09-1")
def test_a_payload_is_ten_numbers_at_the_tip(robot):
    """The regressor of the tip frame gives the difference that a body fixed there makes."""
    load = Inertial(1.3, np.array([0.02, -0.05, 0.11]), np.diag([0.01, 0.02, 0.015]))
    mechanism = robot.mechanism
    tip = next(link for link in mechanism.links if link.name == mechanism.tip)
    T = mechanism.T_lt
    placed = Inertial(load.mass, T[:3, :3] @ load.com + T[:3, 3], T[:3, :3] @ load.inertia @ T[:3, :3].T)
    together = inertial_of(parameters_of(tip.inertial) + parameters_of(placed))
    loaded = Robot(with_inertial(mechanism, tip.name, together))
    s = sample(mechanism, 4, np.random.default_rng(2))
    motion = (s.q, s.qd, s.qdd)
    extra = robot.payload_regressor(*motion) @ parameters_of(load)
    close(robot.inverse_dynamics(*motion) + extra, loaded.inverse_dynamics(*motion))
    at_link = robot.payload_regressor(*motion, frame=tip.name) @ parameters_of(placed)
    close(at_link, extra)


def test_parameters_there_and_back():
    body = Inertial(2.0, np.array([0.1, -0.2, 0.3]), np.array([[0.3, 0.01, 0.02], [0.01, 0.2, 0], [0.02, 0, 0.25]]))
    again = inertial_of(parameters_of(body))
    close(again.com, body.com)
    close(again.inertia, body.inertia)
    assert (parameters_of(None) == 0).all()
    assert inertial_of(np.zeros(10)).mass == 0


@pytest.mark.capability("09-48")
@pytest.mark.parametrize(("name", "count"), [("panda", 43), ("puma560", 36), ("planar2r", None)])
def test_base_parameters(name, count):
    """As many as the literature counts; any change they cannot see changes no effort; they give all efforts."""
    robot = Robot(library.load(name))
    base = robot.base_parameters()
    if count is not None:
        assert base.count == count
    pi = robot.inertial_parameters.ravel()
    s = sample(robot.mechanism, 6, np.random.default_rng(9))
    Y = robot.regressor(s.q, s.qd, s.qdd).reshape(6, robot.n, -1)
    close(Y[..., list(base.columns)] @ (base.combination @ pi), Y @ pi, 1e-9)
    silent = np.random.default_rng(0).standard_normal(pi.size)
    silent -= np.linalg.pinv(base.combination) @ (base.combination @ silent)
    assert np.abs(silent).max() > 0.1
    close(Y @ (pi + silent), Y @ pi, 1e-9)
    assert any(label.startswith(robot.mechanism.links[0].name) for label in base.silent)
    assert len(base.labels) == base.count


def test_base_parameters_need_states():
    with pytest.raises(InputError, match="at least one sample"):
        Robot(library.load("planar2r")).base_parameters(samples=0)


@pytest.mark.capability("09-3")
def test_friction_columns():
    mechanism = library.load("planar2r")
    frictions = (Friction(viscous=0.3, coulomb=0.5, offset=0.2), Friction(viscous=0.1, coulomb=0.7, offset=-0.1))
    joints, left = [], list(frictions)
    for joint in mechanism.joints:
        joints.append(replace(joint, friction=left.pop(0)) if joint.moves and left else joint)
    robot = Robot(replace(mechanism, joints=tuple(joints)))
    qd = np.random.default_rng(0).uniform(-1, 1, (5, 2))
    parameters = np.array([0.3, 0.1, 0.5, 0.7, 0.2, -0.1])
    close(robot.friction_regressor(qd) @ parameters, robot.friction_torque(qd))


@pytest.mark.capability("09-5")
def test_the_reason_of_a_degenerate_mass_matrix():
    """A massless last link on its own axis: the last joint moves nothing, everywhere."""
    mechanism = library.load("planar2r")
    last = mechanism.links[-1].name if mechanism.links[-1].inertial is not None else mechanism.links[-2].name
    robot = Robot(with_inertial(mechanism, last, None))
    report = robot.mass_matrix_singularity([0.3, 0.4])
    assert report.singular
    assert report.joints == (robot.joint_names[-1],)
    assert report.energy == 0
    regular = Robot(mechanism).mass_matrix_singularity([0.3, 0.4])
    assert not regular.singular
    assert 0 < regular.margin < 1
    regular.require_regular()
    assert isinstance(mechanism.links[0], Link)
