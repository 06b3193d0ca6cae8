"""Tools, payloads and held joints: variants of a robot, on Robot and Mechanism alike."""

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError, ModelError
from mafsil.mechanics.inertial_parameters import parameters_of
from mafsil.model import Joint, JointKind, Link, Mechanism, library
from mafsil.model.joint import Mimic
from mafsil.model.placement import rotation_x, translation

RNG = np.random.default_rng(5)
T_TOOL = translation(0.02, -0.01, 0.13) @ rotation_x(0.4)
MASS, COM = 1.3, np.array([0.01, 0.02, 0.06])
INERTIA = np.diag([0.004, 0.003, 0.002])


def motion(robot, count=5):
    return RNG.uniform(-1, 1, (3, count, robot.n))


@pytest.mark.parametrize("name", ["panda", "ur5e", "scara_rrrp"])
def test_tool_is_mounted_on_the_tip_frame_and_its_mass_is_carried(name):
    bare = mf.load(name)
    tooled = bare.with_tool(T_TOOL, mass=MASS, com=COM, inertia=INERTIA)
    q, qd, qdd = motion(bare)
    assert np.allclose(tooled.forward_kinematics(q), bare.forward_kinematics(q) @ T_TOOL, atol=1e-12)
    by_regressor = bare.payload_regressor(q, qd, qdd) @ parameters_of(mf.model.Inertial(MASS, COM, INERTIA))
    assert np.allclose(tooled.inverse_dynamics(q, qd, qdd), bare.inverse_dynamics(q, qd, qdd) + by_regressor, atol=1e-9)


def test_payload_leaves_the_tip_where_it_is():
    bare = mf.load("ur5e")
    loaded = bare.with_payload(2.0, com=[0, 0, 0.1])
    q = motion(bare)[0]
    assert np.array_equal(loaded.forward_kinematics(q), bare.forward_kinematics(q))
    points = bare.forward_kinematics(q) @ np.array([0, 0, 0.1, 1.0])
    assert np.allclose(loaded.potential_energy(q) - bare.potential_energy(q), 2.0 * 9.81 * points[:, 2], atol=1e-9)


def test_tool_as_three_numbers_and_on_a_named_link():
    bare = mf.load("panda")
    q = motion(bare)[0]
    shifted = bare.with_tool([0, 0, 0.1])
    assert np.allclose(shifted.forward_kinematics(q), bare.forward_kinematics(q) @ translation(0, 0, 0.1), atol=1e-12)
    on_link = bare.with_tool(mf.Pose(T_TOOL), link="link4")
    assert on_link.tip == "link4"
    assert np.allclose(on_link.forward_kinematics(q), bare.forward_kinematics(q, frame="link4") @ T_TOOL, atol=1e-12)


def test_robot_and_mechanism_have_the_same_variants():
    robot, mechanism = mf.load("panda"), library.load("panda")
    pairs = [
        (robot.with_tool(T_TOOL, mass=MASS, com=COM), mechanism.with_tool(T_TOOL, mass=MASS, com=COM)),
        (robot.with_payload(MASS, com=COM), mechanism.with_payload(MASS, com=COM)),
        (robot.with_locked_joints({"joint3": 0.4}), mechanism.with_locked_joints({"joint3": 0.4})),
        (robot.with_tip("link4"), mechanism.with_tip("link4")),
    ]
    for ours, theirs in pairs:
        q = np.full(ours.n, 0.3)
        assert np.array_equal(ours.gravity_torque(q), mf.Robot(theirs).gravity_torque(q))
        assert np.array_equal(ours.forward_kinematics(q), mf.Robot(theirs).forward_kinematics(q))


def test_tool_without_mass_and_no_tool_at_all():
    bare = mf.load("ur5e")
    q = motion(bare)[0]
    assert np.array_equal(bare.with_tool().forward_kinematics(q), bare.forward_kinematics(q))
    assert np.array_equal(bare.with_tool(T_TOOL).gravity_torque(q), bare.gravity_torque(q))


@pytest.mark.capability("05-44")
def test_held_joint_stays_where_it_is_held():
    robot = mf.load("panda")
    held = robot.with_locked_joints({"joint3": 0.4, "joint7": -0.2})
    q = motion(robot)[0]
    q[:, 2], q[:, 6] = 0.4, -0.2
    assert held.joint_names == tuple(f"joint{k}" for k in (1, 2, 4, 5, 6))
    assert np.allclose(held.forward_kinematics(q[:, [0, 1, 3, 4, 5]]), robot.forward_kinematics(q), atol=1e-12)


def pair(multiplier=-0.5, offset=0.01):
    links = [Link(name) for name in ("base", "arm", "left", "right")]
    joints = [
        Joint("turn", JointKind.REVOLUTE, "base", "arm"),
        Joint("left", JointKind.PRISMATIC, "arm", "left"),
        Joint("right", JointKind.PRISMATIC, "arm", "right", mimic=Mimic("left", multiplier, offset)),
    ]
    return mf.Robot(Mechanism.assemble("gripper", links, joints))


@pytest.mark.parametrize("held", [{"left": 0.03}, {"right": -0.005}, {"left": 0.03, "right": -0.005}])
def test_a_mimic_pair_is_held_together_by_either_member(held):
    free, fixed = pair(), pair().with_locked_joints(held)
    assert fixed.joint_names == ("turn",)
    for frame in ("left", "right"):
        T = fixed.forward_kinematics([0.7], frame=frame)
        assert np.allclose(T, free.forward_kinematics([0.7, 0.03], frame=frame), atol=1e-15)


@pytest.mark.parametrize(
    ("held", "error", "key"),
    [
        ({"left": 0.03, "right": 0.02}, ModelError, "dh.lock_contradiction"),
        ({"lfet": 0.03}, ModelError, "dh.lock_unknown"),
        ({"left": np.nan}, InputError, "input.finite_alone"),
        ([("left", 0.0)], InputError, "input.kind"),
    ],
)
def test_what_cannot_be_held_is_said(held, error, key):
    with pytest.raises(error) as caught:
        pair().with_locked_joints(held)
    assert caught.value.key == key
    assert caught.value.message("en") != caught.value.message("ar")


def test_follower_that_never_moves_cannot_set_its_leader():
    with pytest.raises(ModelError) as caught:
        pair(multiplier=0.0).with_locked_joints({"right": 0.5})
    assert caught.value.key == "dh.lock_idle"


@pytest.mark.parametrize(
    ("call", "key"),
    [
        (lambda r: r.with_payload(-1.0), "input.range"),
        (lambda r: r.with_payload(1.0, inertia=np.diag([1.0, 1.0, 9.0])), "dynamics.moments"),
        (lambda r: r.with_payload(1.0, link="tip"), "model.no_such_link"),
        (lambda r: r.with_payload(np.nan), "input.finite_alone"),
        (lambda r: r.with_tool(np.diag([1.0, 1.0, -1.0, 1.0])), "geometry.improper"),
        (lambda r: r.with_tool([0, 0]), "input.shape"),
    ],
)
def test_impossible_tools_and_loads_are_refused(call, key):
    with pytest.raises((InputError, ModelError)) as caught:
        call(mf.load("ur5e"))
    assert caught.value.key == key
    assert caught.value.message("en") != caught.value.message("ar")
