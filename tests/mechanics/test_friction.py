"""Friction, gears and rotor inertia as terms of the model: by name, switchable, against Pinocchio and MuJoCo."""

from dataclasses import replace

import numpy as np
import pytest

from mafsil.errors import InputError, ModelError
from mafsil.mechanics.friction import friction_law
from mafsil.mechanics.inertial_parameters import reflected_inertias
from mafsil.model import Actuator, Friction, library
from mafsil.robot import Robot
from tests.oracles.random_tree import random_tree
from tests.oracles.states import sample

TERMS = ("links", "rotors", "centrifugal", "coriolis", "gravity", "friction", "tip", "other")


def close(a, b, limit=1e-11):
    assert np.abs(a - b).max() < limit * max(1.0, np.abs(b).max())


def resisted(mechanism, seed=3):
    """The mechanism with friction and a geared motor at every moving joint, followers included."""
    rng = np.random.default_rng(seed)
    joints = tuple(
        replace(
            joint,
            friction=Friction(*rng.uniform(0, 2, 3), offset=rng.normal()),
            actuator=Actuator(rng.uniform(0, 1e-4), rng.uniform(-120, 120), rng.uniform(0, 0.1)),
        )
        if joint.moves
        else joint
        for joint in mechanism.joints
    )
    return replace(mechanism, joints=joints)


@pytest.fixture(params=["puma560", "scara_rrrp", "tree"], scope="module")
def robot(request):
    if request.param == "tree":
        return Robot(resisted(random_tree(np.random.default_rng(0), most_joints=12)))
    return Robot(resisted(library.load(request.param)))


@pytest.mark.capability("09-3")
def test_terms_sum_to_the_whole_effort(robot):
    s = sample(robot.mechanism, 4, np.random.default_rng(1))
    springs = -3.0 * s.q
    terms = robot.torque_terms(s.q, s.qd, s.qdd, s.tip_wrench, other=springs)
    whole = robot.inverse_dynamics(s.q, s.qd, s.qdd, s.tip_wrench) + robot.friction_torque(s.qd) + springs
    close(terms.total, whole)
    close(sum(getattr(terms, name) for name in TERMS), whole)
    close(terms.without("friction", "other"), robot.inverse_dynamics(s.q, s.qd, s.qdd, s.tip_wrench))
    close(terms.only("links", "rotors"), np.einsum("bij,bj->bi", robot.mass_matrix(s.q), s.qdd))
    close(terms.only("centrifugal", "coriolis"), robot.velocity_torque(s.q, s.qd))


@pytest.mark.capability("09-3")
def test_terms_take_single_states_and_broadcast(robot):
    s = sample(robot.mechanism, 3, np.random.default_rng(2))
    batch = robot.torque_terms(s.q, s.qd[0], s.qdd[0])
    single = robot.torque_terms(s.q[1], s.qd[0], s.qdd[0])
    assert single.total.shape == (robot.n,)
    close(batch.total[1], single.total)
    assert (single.tip == 0).all()
    assert (single.other == 0).all()
    with pytest.raises(InputError, match="centrifugal"):
        single.without("wind")
    with pytest.raises(InputError, match="qdd"):
        robot.torque_terms(s.q[0], s.qd[0], np.full(robot.n, np.nan))


@pytest.mark.capability("09-3")
def test_rotors_add_the_square_of_the_gear_to_the_diagonal(robot):
    bare = tuple(replace(joint, actuator=None) for joint in robot.mechanism.joints)
    q = sample(robot.mechanism, 1, np.random.default_rng(4)).q[0]
    added = robot.mass_matrix(q) - Robot(replace(robot.mechanism, joints=bare)).mass_matrix(q)
    close(added, np.diag(reflected_inertias(robot.mechanism)), 1e-10)


@pytest.mark.capability("09-3")
def test_friction_takes_power_and_follows_mimic_joints(robot):
    qd = np.random.default_rng(5).uniform(-2, 2, (6, robot.n))
    joints = tuple(
        replace(j, friction=replace(j.friction, offset=0.0) if j.friction else None) for j in robot.mechanism.joints
    )
    law = friction_law(replace(robot.mechanism, joints=joints))
    power = np.einsum("bi,bi->b", law.torque(qd), qd)
    assert (power > 0).all()
    moving = [j for j in joints if j.moves]
    factors = [j.mimic.multiplier if j.mimic else 1.0 for j in moving]
    index = {j.name: k for k, j in enumerate(robot.mechanism.coordinates)}
    rates = [f * qd[:, index[j.mimic.leader if j.mimic else j.name]] for j, f in zip(moving, factors, strict=True)]
    lost = 0.0
    for joint, w in zip(moving, rates, strict=True):
        f = joint.friction
        lost = (
            lost
            + f.viscous * w**2
            + np.where(w > 0, f.coulomb, f.coulomb_negative) * np.abs(w) * np.tanh(np.abs(w) / 1e-3)
        )
    close(power, lost)


@pytest.mark.capability("09-3")
def test_coulomb_friction_changes_its_sign_smoothly():
    robot = Robot(resisted(library.load("planar2r")))
    rates = np.linspace(-5e-3, 5e-3, 2001)
    effort = robot.friction_torque(np.stack([rates, rates], axis=1))
    assert (np.diff(effort, axis=0) > 0).all()
    offsets = [joint.friction.offset for joint in robot.mechanism.coordinates]
    close(robot.friction_torque(np.zeros(2)), np.array(offsets))


def test_an_offset_must_be_finite():
    with pytest.raises(ModelError, match="offset"):
        Friction(offset=np.inf)


@pytest.mark.capability("09-3")
def test_rotor_inertia_and_friction_against_pinocchio():
    pin = pytest.importorskip("pinocchio")
    from tests.oracles.pinocchio_model import model_of

    mechanism = resisted(library.load("panda"))
    robot = Robot(mechanism)
    model, _ = model_of(mechanism)
    coordinates = mechanism.coordinates
    assert np.allclose(model.armature, [j.actuator.reflected_inertia for j in coordinates])
    s = sample(mechanism, 5, np.random.default_rng(6))
    for q, qd, qdd in zip(s.q, s.qd, s.qdd, strict=True):
        rnea = pin.rnea(model, model.createData(), q, qd, qdd)
        close(robot.torque_terms(q, qd, qdd).without("friction"), rnea)


@pytest.mark.capability("09-3")
def test_rotor_inertia_and_friction_against_mujoco():
    """MuJoCo solves dry friction as a constraint; while the joints slip it takes the whole Coulomb effort."""
    mujoco = pytest.importorskip("mujoco")
    joint = '<joint axis="{axis}" armature="{armature}" damping="{damping}" frictionloss="{loss}"/>'
    body = '<body pos="{pos}">' + joint + '<inertial pos="0.1 0.02 0.3" mass="{mass}" diaginertia="0.02 0.03 0.04"/>'
    rows = [
        ("0 0 1", 0.3, 1.5, 2.0, "0 0 0.2", 3),
        ("0 1 0", 0.2, 0.7, 1.0, "0 0.1 0.4", 2),
        ("1 0 0", 0.0, 0.4, 0.6, "0 0 0.4", 1),
    ]
    bodies = "".join(
        body.format(axis=axis, armature=a, damping=d, loss=f, pos=pos, mass=m) for axis, a, d, f, pos, m in rows
    )
    xml = f"<mujoco><option gravity='0 0 -9.81'/><worldbody>{bodies}{'</body>' * 3}</worldbody></mujoco>"
    from mafsil.model import mjcf

    robot = Robot(mjcf.read(xml))
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    rng = np.random.default_rng(7)
    for _ in range(5):
        q, qdd = rng.uniform(-2, 2, (2, 3))
        qd = rng.uniform(0.5, 2, 3) * rng.choice([-1, 1], 3)
        data.qpos[:], data.qvel[:], data.qacc[:] = q, qd, qdd
        mujoco.mj_inverse(model, data)
        terms = robot.torque_terms(q, qd, qdd)
        close(terms.total, data.qfrc_inverse, 1e-9)
        viscous = np.array([row[2] for row in rows]) * qd
        close(terms.friction - viscous, np.array([row[3] for row in rows]) * np.sign(qd), 1e-9)
        close(-data.qfrc_passive, viscous, 1e-9)
