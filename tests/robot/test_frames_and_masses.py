"""Typed wrenches in the wrong frame, arms without masses, foreign poses, languages: said, not computed."""

import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation as ScipyRotation

import mafsil as mf
from mafsil import performance
from mafsil.errors import InputError, MafsilError, ModelError

ARM = mf.load("planar2r")
Q = np.array([0.3, 0.4])
F = [0, 0, 1.0, 2.0, 3.0, 0]


@pytest.mark.parametrize("frame", [None, "b", "t", "link2"])
def test_wrenches_of_the_tip_frame_pass(frame):
    plain = ARM.inverse_dynamics(Q, Q, Q, F)
    np.testing.assert_array_equal(ARM.inverse_dynamics(Q, Q, Q, mf.Wrench(F, frame)), plain)
    np.testing.assert_array_equal(
        performance.joint_torque(ARM, Q, mf.Wrench(F, frame)), performance.joint_torque(ARM, Q, F)
    )


@pytest.mark.parametrize(
    "call",
    [
        lambda: ARM.inverse_dynamics(Q, Q, Q, mf.Wrench(F, "s")),
        lambda: ARM.inverse_dynamics(Q, Q, Q, tip_wrench=mf.Wrench(F, "s")),
        lambda: performance.joint_torque(ARM, Q, mf.Wrench(F, "s")),
        lambda: performance.joint_torque(ARM, Q, mf.Wrench(F, "b"), given_in="space"),
    ],
)
def test_wrenches_of_another_frame_are_refused(call):
    with pytest.raises(InputError) as caught:
        call()
    assert caught.value.key == "robot.wrench_frame"
    assert "seen_from" in caught.value.message("ar")


def test_a_twist_is_no_wrench():
    with pytest.raises(InputError):
        ARM.inverse_dynamics(Q, Q, Q, mf.Twist(F))


@pytest.mark.parametrize("name", ["gravity_torque", "mass_matrix", "kinetic_energy", "inverse_dynamics"])
def test_arms_without_masses_say_so(name):
    arm = mf.Robot.from_dh([[0.3, 0, 0, 0], [0.2, 0, 0, 0]], "classic")
    with pytest.raises(ModelError) as caught:
        getattr(arm, name)(Q)
    assert caught.value.key == "robot.massless"
    assert np.isfinite(arm.with_payload(1.0).gravity_torque(Q)).all()
    assert "no masses" in str(arm)


def test_objects_with_a_matrix_are_poses_and_rotations():
    turn = ScipyRotation.from_euler("z", 0.3)
    np.testing.assert_allclose(mf.Rotation(turn).rpy(), [0, 0, 0.3], atol=1e-15)


def test_another_language_is_refused_by_our_own_error():
    with pytest.raises(MafsilError):
        mf.language("fr")
    assert mf.language() in ("en", "ar")
    with pytest.raises(InputError):
        ARM.forward_kinematics(np.zeros((4, 2)), threads=2.7)


def test_rows_of_a_table_as_people_write_them():
    by_rows = mf.Robot.from_dh([[0.3, 90, 0.1, 0], [0.2, 0, 0, 45]], "classic", degrees=True)
    by_names = mf.Robot.from_dh([{"a": 0.3, "alpha": np.pi / 2, "d": 0.1}, mf.DHRow(a=0.2, theta=np.pi / 4)], "classic")
    columns = ("theta", "d", "a", "alpha")
    by_columns = mf.Robot.from_dh([[0, 0.1, 0.3, 90], [45, 0, 0.2, 0]], "classic", columns=columns, degrees=True)
    for other in (by_names, by_columns):
        np.testing.assert_allclose(other.forward_kinematics(Q), by_rows.forward_kinematics(Q), atol=1e-15)
    with pytest.warns(mf.InputWarning, match="degrees=True"):
        mf.Robot.from_dh([[0.3, 90, 0, 0]], "classic")
    for wrong in ([[1, 2]], [[0, 0, 0, 0, "X"]], [{"aa": 1}], 5, [3]):
        with pytest.raises(MafsilError):
            mf.Robot.from_dh(wrong, "classic")


def test_misspelt_names_and_print():
    with pytest.raises(AttributeError, match="forward_kinematics"):
        _ = ARM.forward_kinematic
    assert max(map(len, str(mf.load("ur5e")).splitlines())) <= 80


def test_warnings_travel_to_other_processes():
    """Test runners and process pools make a warning again from its arguments alone, or by pickle."""
    warning = mf.InputWarning("dh.degrees", row=1, field="alpha", value=90.0)
    for again in (type(warning)(*warning.args), pickle.loads(pickle.dumps(warning))):
        assert str(again) == str(warning)
        assert again.message("ar") == warning.message("ar")


def test_a_printed_robot_fits_a_screen_and_a_notebook_shows_the_same() -> None:
    names = [f"joint_with_a_very_long_name_indeed_{k}" for k in range(60)]
    links = [mf.model.Link(f"link{k}") for k in range(61)]
    joints = [
        mf.model.Joint(
            name,
            mf.model.JointKind.REVOLUTE,
            f"link{k}",
            f"link{k + 1}",
            limits=mf.model.Limits(-123.4567, 123.4567, 10, 1e4),
        )
        for k, name in enumerate(names)
    ]
    robot = mf.Robot(mf.Mechanism.assemble("snake", links, joints))
    lines = str(robot).splitlines()
    assert len(lines) <= 25
    assert max(map(len, lines)) <= 100
    page = robot._repr_html_()
    assert page.count("<tr>") == 21
    assert all(word in page for word in ("snake", "123.5 rad", "40 more joints"))
