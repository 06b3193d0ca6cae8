"""The MJCF reader against MuJoCo's own compiler: numbers of the model, and where everything is at random states."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil.model import JointKind, Mechanism, mjcf
from mafsil.model.link import moved_inertial
from mafsil.model.placement import screw_motion
from tests.model.mjcf.mjcf_models import MODELS

mujoco = pytest.importorskip("mujoco")


def poses(mechanism: Mechanism, q: dict[str, float]) -> dict[str, np.ndarray]:
    """Poses of all links in the world; mimics follow."""
    at = {mechanism.links[0].name: np.eye(4)}
    for joint in mechanism.joints:
        mimic = joint.mimic
        value = q.get(joint.name, 0.0) if mimic is None else mimic.multiplier * q[mimic.leader] + mimic.offset
        at[joint.child] = at[joint.parent] @ joint.T_pj @ screw_motion(joint.screw, value)
    return at


def compiled(text: str) -> tuple[Mechanism, object, object]:
    model = mujoco.MjModel.from_xml_string(text)
    return mjcf.read(text), model, mujoco.MjData(model)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("seed", range(5))
def test_bodies_are_where_mujoco_has_them(name: str, seed: int) -> None:
    mechanism, model, data = compiled(MODELS[name])
    data.qpos[:] = np.random.default_rng(seed).uniform(-2, 2, model.nq)
    mimics = {joint.name: joint.mimic for joint in mechanism.joints if joint.mimic}
    q = {model.joint(k).name: float(data.qpos[k]) for k in range(model.njnt)}
    for follower, mimic in mimics.items():
        q[follower] = mimic.multiplier * q[mimic.leader] + mimic.offset
        data.qpos[model.joint(follower).qposadr] = q[follower]
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    ours = poses(mechanism, q)
    for k in range(1, model.nbody):
        T = ours[model.body(k).name]
        np.testing.assert_allclose(T[:3, 3], data.xpos[k], rtol=0, atol=1e-14)
        np.testing.assert_allclose(T[:3, :3], data.xmat[k].reshape(3, 3), rtol=0, atol=1e-14)
        inertial = mechanism.link(model.body(k).name).inertial
        assert inertial is not None
        moved = moved_inertial(inertial, T)
        R = data.ximat[k].reshape(3, 3)
        np.testing.assert_allclose(moved.mass, model.body_mass[k], rtol=1e-14)
        np.testing.assert_allclose(moved.com, data.xipos[k], rtol=0, atol=1e-14)
        theirs = R @ np.diag(model.body_inertia[k]) @ R.T
        np.testing.assert_allclose(moved.inertia, theirs, rtol=0, atol=1e-12 * np.abs(theirs).max())


@pytest.mark.parametrize("name", MODELS)
def test_joints_are_mujocos(name: str) -> None:
    mechanism, model, _ = compiled(MODELS[name])
    moving = {joint.name: joint for joint in mechanism.joints if joint.moves}
    assert set(moving) == {model.joint(k).name for k in range(model.njnt)}
    for k in range(model.njnt):
        joint = moving[model.joint(k).name]
        np.testing.assert_allclose(joint.axis, model.jnt_axis[k], rtol=0, atol=1e-15)
        slides = model.jnt_type[k] == mujoco.mjtJoint.mjJNT_SLIDE
        assert (joint.kind is JointKind.PRISMATIC) == slides
        if model.jnt_limited[k]:
            np.testing.assert_allclose([joint.limits.lower, joint.limits.upper], model.jnt_range[k], rtol=1e-15)
        else:
            assert joint.wraps != slides
        dof = model.jnt_dofadr[k]
        friction = joint.friction
        assert (0.0 if friction is None else friction.coulomb) == model.dof_frictionloss[dof]
        assert (0.0 if friction is None else friction.viscous) == np.ravel(model.dof_damping)[dof]
        assert (0.0 if joint.actuator is None else joint.actuator.armature) == model.dof_armature[dof]
    np.testing.assert_array_equal(mechanism.gravity, model.opt.gravity)


def test_actuators_limit_the_effort() -> None:
    mechanism = mjcf.read(MODELS["arm"])
    np.testing.assert_array_equal(mechanism.limits.effort, [100.0, 30.0, 2.0, 2.0])
    assert mechanism.joints[1].actuator is not None
    assert mechanism.actuated == (True,) * 4
    assert [joint.actuator.gear_ratio for joint in mechanism.coordinates if joint.actuator] == [50.0, 1.0, 1.0, 1.0]


def test_coupling_is_a_mimic_with_the_references() -> None:
    mechanism = mjcf.read(MODELS["coupled"])
    assert mechanism.n == 1
    (mimic,) = [joint.mimic for joint in mechanism.joints if joint.mimic]
    assert (mimic.leader, mimic.multiplier) == ("f1", 0.5)
    assert mimic.offset == pytest.approx(0.002 - 0.5 * 0.01, abs=1e-18)


KEYS = """<mujoco><worldbody><body name="a"><inertial pos="0 0 .1" mass="1" diaginertia=".1 .1 .1"/>
<joint name="turn" axis="0 0 1" ref="20"/><body name="b" pos="0 0 .3"><inertial pos="0 0 .1" mass="1" diaginertia=
".1 .1 .1"/><joint name="slide" type="slide" axis="1 0 0"/><joint name="swing" axis="0 1 0"/><body name="tcp"
pos=".2 0 .1"><inertial pos="0 0 0" mass=".1" diaginertia=".01 .01 .01"/></body></body></body></worldbody>
<keyframe><key name="home" qpos="0.5 0.1 -0.4"/><key time="1" qpos="1 0 1" qvel="0 0 0"/></keyframe></mujoco>"""


def test_keyframes_are_postures() -> None:
    mechanism, model, data = compiled(KEYS)
    assert [name for name, _ in mechanism.provenance.postures] == ["home", "key 1"]
    for k, (_, q) in enumerate(mechanism.provenance.postures):
        mujoco.mj_resetDataKeyframe(model, data, k)
        mujoco.mj_kinematics(model, data)
        assert np.abs(poses(mechanism, dict(q))["tcp"][:3, 3] - data.body("tcp").xpos).max() < 1e-12
    names = {joint.name for joint in mechanism.coordinates}
    assert all(q.keys() == names for _, q in mechanism.provenance.postures)
    short, _, _ = compiled(KEYS.replace('qpos="0.5 0.1 -0.4"', 'ctrl=""'))
    assert [name for name, _ in short.provenance.postures] == ["key 1"]
