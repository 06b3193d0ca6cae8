"""The tip of a description that names none: the tool frame of convention, else the last link before the hand forks."""

import warnings

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import ModelWarning
from mafsil.model import Joint, JointKind, Link, Mechanism, library
from mafsil.model.joint import Mimic
from mafsil.model.loading import load_mechanism
from mafsil.model.tip import choose_tip
from tests.model.urdf.real_files import FOLDER, robots

R, P, F = JointKind.REVOLUTE, JointKind.PRISMATIC, JointKind.FIXED


def arm(*extra, joints=6):
    chain = [Joint(f"joint{k}", R, f"link{k}", f"link{k + 1}") for k in range(joints)]
    return [*chain, *extra]


def tip(joints, base="link0"):
    return choose_tip(base, joints)


def fixed(parent, child):
    return Joint(f"{parent}-{child}", F, parent, child)


@pytest.mark.parametrize("name", ["tool0", "my_tcp", "ee_link", "arm_hand_tcp", "link_eef", "end_effector", "flange"])
def test_frame_of_convention_is_the_tip_wherever_it_stands_among_the_fixed_links(name):
    joints = arm(fixed("link6", "bracket"), fixed("bracket", "cover"), fixed("link6", name), fixed("link6", "other"))
    choice = tip(joints)
    assert choice.tip == name
    assert set(choice.others) == {"cover", "other"}


def test_the_most_telling_name_wins():
    joints = arm(fixed("link6", "flange"), fixed("flange", "tool0"), fixed("tool0", "hand"), fixed("hand", "hand_tcp"))
    assert tip(joints).tip == "hand_tcp"


def test_a_name_of_convention_elsewhere_does_not_count():
    assert tip(arm(fixed("link2", "tool0"))).tip == "link6"


def test_last_link_before_the_hand_forks_and_never_a_finger():
    hand = [
        fixed("link6", "palm"),
        Joint("finger_left", P, "palm", "left"),
        Joint("finger_right", P, "palm", "right", mimic=Mimic("finger_left")),
    ]
    choice = tip(arm(*hand))
    assert choice.tip == "palm"
    assert choice.others == ("left", "right")


def test_one_jaw_is_a_hand_too():
    assert tip(arm(fixed("link6", "stator"), Joint("gripper", R, "stator", "jaw"))).tip == "stator"


def test_fingers_longer_than_the_arm_are_no_arm():
    fingers = [
        Joint(f"{f}finger{k}", R, "link3" if k == 0 else f"{f}{k - 1}", f"{f}{k}") for f in "ab" for k in range(5)
    ]
    assert tip(arm(*fingers, joints=3)).tip == "link3"


def test_head_and_wheels_fork_the_base_but_the_arm_is_followed():
    joints = [
        Joint("wheel", R, "base", "wheel"),
        Joint("lift", P, "base", "torso"),
        Joint("head1", R, "torso", "head1"),
        Joint("head2", R, "head1", "head2"),
        *(Joint(f"arm{k}", R, "torso" if k == 0 else f"arm{k - 1}", f"arm{k}") for k in range(7)),
    ]
    assert tip(joints, "base").tip == "arm6"


def test_bars_that_follow_do_not_end_an_arm():
    """A palletiser: the bar beside the arm is a mimic, and so is the wrist that stays level."""
    joints = [
        Joint("turn", R, "base", "column"),
        Joint("shoulder", R, "column", "upper"),
        Joint("bar", R, "column", "bar", mimic=Mimic("shoulder")),
        Joint("elbow", R, "upper", "fore"),
        Joint("level", R, "fore", "plate", mimic=Mimic("shoulder", -1.0)),
    ]
    assert tip(joints, "base").tip == "plate"


def test_given_tip_is_kept_and_nothing_is_noted():
    links = [Link(f"link{k}") for k in range(7)] + [Link("tool0"), Link("bracket")]
    joints = arm(fixed("link6", "tool0"), fixed("link6", "bracket"))
    assert Mechanism.assemble("x", links, joints, tip="link3").provenance.notes == ()
    chosen = Mechanism.assemble("x", links, joints)
    assert chosen.tip == "tool0"
    assert "bracket" in chosen.provenance.notes[0]


def test_library_arms_keep_their_tips():
    for name in library.robots():
        mechanism = library.load(name)
        assert mechanism.tip == choose_tip(mechanism.links[0].name, mechanism.joints).tip


CHOSEN = {
    "a1_description/urdf/a1.urdf": "FR_foot",
    "alex_description/urdf/alex_nub_hands.urdf": "leftNub",
    "alex_description/urdf/alex_psyonic_hands.urdf": "Left_thumb_base",
    "alex_description/urdf/alex_sake_hands.urdf": "LeftSakePalmLink",
    "alexander_description/urdf/alexander_v1.lowerBodyOnly.urdf": "LEFT_FOOT",
    "allegro_hand_description/urdf/allegro_left_hand.urdf": "link_11.0_tip",
    "allegro_hand_description/urdf/allegro_right_hand.urdf": "link_3.0_tip",
    "anymal_b_simple_description/robots/anymal-kinova.urdf": "j2s6s200_end_effector",
    "anymal_b_simple_description/robots/anymal.urdf": "LF_FOOT",
    "anymal_c_simple_description/urdf/anymal.urdf": "LF_FOOT",
    "asr_twodof_description/urdf/TwoDofs.urdf": "Tip",
    "b1_description/urdf/b1-z1.urdf": "gripperStator",
    "b1_description/urdf/b1.urdf": "FR_foot",
    "baxter_description/urdf/baxter.urdf": "right_gripper_base_link",
    "bolt_description/robots/bolt.urdf": "FL_FOOT",
    "borinot_description/urdf/borinot_flying_arm_2.urdf": "flying_arm_2__ee",
    "centauro_description/urdf/centauro.urdf": "ball1",
    "double_pendulum_description/urdf/double_pendulum.urdf": "link2",
    "double_pendulum_description/urdf/double_pendulum_continuous.urdf": "link2",
    "double_pendulum_description/urdf/double_pendulum_simple.urdf": "link3",
    "finger_edu_description/robots/finger_edu.urdf": "finger_tip_link",
    "g1_description/urdf/g1_29dof_rev_1_0.urdf": "left_rubber_hand",
    "g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf": "left_hand_palm_link",
    "go1_description/urdf/go1.urdf": "FR_foot",
    "go2_description/urdf/go2.urdf": "FL_foot",
    "hector_description/robots/quadrotor_base.urdf": "base_link",
    "hextilt_description/urdf/hextilt_flying_arm_5.urdf": "flying_arm_5__gripper",
    "human_description/robots/human.urdf": "left_hand",
    "hyq_description/robots/hyq_no_sensors.urdf": "lf_foot",
    "icub_description/robots/icub.urdf": "l_hand",
    "icub_description/robots/icub_reduced.urdf": "l_hand",
    "iris_description/robots/iris.urdf": "iris__rotor_0",
    "iris_description/robots/iris_simple.urdf": "iris__base_link",
    "kinova_description/robots/kinova.urdf": "j2s6s200_end_effector",
    "laikago_description/urdf/laikago.urdf": "FR_foot",
    "panda_description/urdf/panda.urdf": "panda_hand_tcp",
    "panda_description/urdf/panda_collision.urdf": "panda_hand_tcp",
    "pr2_description/urdf/pr2.urdf": "r_gripper_tool_frame",
    "quadruped_description/urdf/quadruped.urdf": "FL_contact",
    "romeo_description/urdf/romeo.urdf": "l_wrist",
    "romeo_description/urdf/romeo_laas_small.urdf": "LArm_effector",
    "romeo_description/urdf/romeo_small.urdf": "l_gripper",
    "simple_humanoid_description/urdf/simple_humanoid.urdf": "r_wrist",
    "simple_humanoid_description/urdf/simple_humanoid_classical.urdf": "r_wrist",
    "so_arm_description/urdf/so100.urdf": "gripper",
    "so_arm_description/urdf/so101.urdf": "gripper_frame_link",
    "solo_description/robots/solo.urdf": "FL_FOOT",
    "solo_description/robots/solo12.urdf": "FL_FOOT",
    "talos_data/robots/talos_full_v2.urdf": "wrist_left_ft_tool_link",
    "talos_data/robots/talos_full_v2_box.urdf": "wrist_left_ft_tool_link",
    "talos_data/robots/talos_left_arm.urdf": "wrist_left_ft_tool_link",
    "talos_data/robots/talos_reduced.urdf": "wrist_left_ft_tool_link",
    "talos_data/robots/talos_reduced_box.urdf": "wrist_left_ft_tool_link",
    "talos_data/robots/talos_reduced_corrected.urdf": "wrist_left_ft_tool_link",
    "tiago_description/robots/tiago.urdf": "hand_grasping_frame",
    "tiago_description/robots/tiago_dual.urdf": "hand_left_grasping_frame",
    "tiago_description/robots/tiago_no_hand.urdf": "wrist_ft_tool_link",
    "tiago_pro_description/robots/tiago_pro.urdf": "arm_left_tool_link",
    "ur_description/urdf/ur10_joint_limited_robot.urdf": "tool0",
    "ur_description/urdf/ur10_robot.urdf": "tool0",
    "ur_description/urdf/ur3_gripper.urdf": "tool0",
    "ur_description/urdf/ur3_joint_limited_robot.urdf": "tool0",
    "ur_description/urdf/ur3_robot.urdf": "tool0",
    "ur_description/urdf/ur5_gripper.urdf": "tool0",
    "ur_description/urdf/ur5_joint_limited_robot.urdf": "tool0",
    "ur_description/urdf/ur5_robot.urdf": "tool0",
    "xarm_description/urdf/xarm7.urdf": "link_eef",
    "z1_description/urdf/z1.urdf": "gripperStator",
}
"""Every robot of example-robot-data: hands, feet and tools at the end of the longest arm or leg."""
LONGEST_WARNING = 700


def test_every_robot_of_example_robot_data_stands_in_the_list():
    found = {str(path.relative_to(FOLDER)) for path in robots()}
    assert not found or found == CHOSEN.keys()


@pytest.mark.parametrize("file", CHOSEN)
def test_makers_robots_get_the_frame_that_people_mean_with_one_warning_at_most(file):
    path = FOLDER / file
    if not path.exists():
        pytest.skip("example-robot-data is not installed")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        assert load_mechanism(path).tip == CHOSEN[file]
    assert len(caught) <= 1
    assert all(len(str(warning.message)) - len(str(path)) < LONGEST_WARNING for warning in caught)


def test_load_says_the_tip_and_the_remarks_at_the_callers_line():
    path = FOLDER / "panda_description" / "urdf" / "panda.urdf"
    if not path.exists():
        pytest.skip("example-robot-data is not installed")
    with pytest.warns(ModelWarning) as caught:
        robot = mf.load(path)
    keys = [warning.message.key for warning in caught]
    assert keys == ["model.load_tip_remarks"]
    assert all(warning.filename == __file__ for warning in caught)
    choice = caught[0].message
    assert "panda_hand_tcp" in choice.message("en")
    assert "panda_leftfinger" in choice.message("ar")
    assert any(note.startswith("tip: panda_hand_tcp") for note in robot.mechanism.provenance.notes)
    with pytest.warns(ModelWarning) as caught:
        other = mf.load(path, tip="panda_link8")
    assert [warning.message.key for warning in caught] == ["model.load_remarks"]
    assert not any(note.startswith("tip:") for note in other.mechanism.provenance.notes)


def test_library_and_clean_files_load_in_silence(tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        robot = mf.load("panda")
        path = tmp_path / "arm.urdf"
        path.write_text(
            '<robot name="a"><link name="b"/><link name="c"/><joint name="j" type="revolute"><parent link="b"/>'
            '<child link="c"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>'
        )
        assert mf.load(path).tip == "c"
    assert np.isfinite(robot.forward_kinematics(np.zeros(7))).all()


def test_impossible_inertia_and_lost_mimic_are_warned_of(tmp_path):
    """What the reader changed reaches a script, not only `mafsil lint`."""
    path = tmp_path / "arm.urdf"
    path.write_text(
        '<robot name="a"><link name="b"/><link name="c"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="9" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        '<joint name="j" type="revolute"><parent link="b"/><child link="c"/>'
        '<limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>'
    )
    with pytest.warns(ModelWarning, match="I0506"):
        mf.load(path)
