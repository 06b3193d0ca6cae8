"""Joints that do not move the asked frame are no unknowns: grippers, second arms, mimic pairs."""

import numpy as np
import pytest

import mafsil as mf
from mafsil.ik import inverse_kinematics, joint_rates, solve_ik, track
from mafsil.ik.chain import moving_part
from mafsil.ik.result import IKStatus

ARM = [
    ("0 0 1", "0 0 0.3"),
    ("0 1 0", "0 0 0"),
    ("0 1 0", "0 0 0.4"),
    ("0 0 1", "0 0 0.2"),
    ("0 1 0", "0 0 0.2"),
    ("0 0 1", "0 0 0"),
]
LIMIT = '<limit lower="-2.5" upper="2.5" velocity="1" effort="10"/>'


def _joint(name, kind, parent, child, axis="0 0 1", origin="0 0 0", more=LIMIT):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{origin}"/><axis xyz="{axis}"/>{more}</joint>'
    )


def _arm(path, extra, links):
    names = ["base", *(f"l{i}" for i in range(1, 7)), "tcp", *links]
    joints = [
        _joint(f"j{i + 1}", "revolute", names[i], names[i + 1], axis, origin) for i, (axis, origin) in enumerate(ARM)
    ]
    joints.append(_joint("t", "fixed", "l6", "tcp", origin="0 0 0.1", more=""))
    path.write_text(
        f'<robot name="a">{"".join(f"""<link name="{n}"/>""" for n in names)}{"".join(joints)}{extra}</robot>'
    )
    return mf.load(path, tip="tcp")


JAW = '<limit lower="0" upper="0.04" velocity="1" effort="10"/>'


@pytest.fixture(scope="module")
def arms(tmp_path_factory):
    """The arm alone, and with a gripper in the middle of the joints' order."""
    folder = tmp_path_factory.mktemp("arms")
    lone = _arm(folder / "lone.urdf", "", [])
    jaw = _joint("grip", "prismatic", "l3", "jaw", "0 1 0", more=JAW)
    return lone, _arm(folder / "held.urdf", jaw, ["jaw"])


def test_a_gripper_changes_nothing_but_its_own_column(arms):
    lone, held = arms
    places = [held.joint_names.index(name) for name in lone.joint_names]
    jaw = held.joint_names.index("grip")
    T = lone.forward_kinematics(np.random.default_rng(0).uniform(-2.5, 2.5, (40, 6)))
    many, other = inverse_kinematics(held, T), inverse_kinematics(lone, T)
    assert many
    assert other
    assert many.q.shape[-1] == 7
    np.testing.assert_allclose(many.q[..., places], other.q, atol=1e-12)
    np.testing.assert_array_equal(many.q[..., jaw], 0.02)
    np.testing.assert_array_equal(many.status, other.status)
    near = np.full(7, 0.01)
    for k in range(5):
        one, plain = inverse_kinematics(held, T[k], q0=near), inverse_kinematics(lone, T[k], q0=near[places])
        assert one.method == "closed form"
        assert one.complete
        assert one.branches == plain.branches
        np.testing.assert_allclose(one.q[:, places], plain.q, atol=1e-12)
        np.testing.assert_array_equal(one.q[:, jaw], 0.01)
        np.testing.assert_allclose(held.forward_kinematics(one.q), np.broadcast_to(T[k], (len(one), 4, 4)), atol=1e-9)
        kept = one.nearest(np.full(7, 0.03))
        assert kept[jaw] == 0.03
        assert (one.multi_turn_solutions()[:, jaw] == 0.01).all()


def test_a_continuum_is_told_in_coordinates_of_the_whole_robot(arms):
    lone, held = arms
    places = [held.joint_names.index(name) for name in lone.joint_names]
    straight = np.array([0.3, 0.4, 0.5, 0.2, 0.0, 0.1])
    answer = inverse_kinematics(held, lone.forward_kinematics(straight))
    assert answer.status is IKStatus.CONTINUUM
    family = answer.families[0]
    assert set(family.moving) == {"j4", "j6"}
    assert family.rates.shape == (7,)
    member = family.at(0.7)
    assert member[held.joint_names.index(family.joint)] == pytest.approx(0.7)
    np.testing.assert_allclose(held.forward_kinematics(member), lone.forward_kinematics(straight), atol=1e-8)
    free = {held.joint_names[i] for i in range(7) if int(answer.free[family.solution]) >> i & 1}
    assert free <= {"j4", "j6"}
    batch = inverse_kinematics(held, lone.forward_kinematics(np.stack([straight, straight])))
    bits = np.bitwise_or.reduce(batch.free, axis=None)
    assert {held.joint_names[i] for i in range(7) if int(bits) >> i & 1} <= {held.joint_names[i] for i in places}


def test_numerical_answers_leave_other_joints_where_they_are(arms):
    lone, held = arms
    places = [held.joint_names.index(name) for name in lone.joint_names]
    jaw = held.joint_names.index("grip")
    T = lone.forward_kinematics(np.random.default_rng(1).uniform(-2.5, 2.5, (20, 6)))
    many = solve_ik(held, T)
    np.testing.assert_allclose(many.q[:, places], solve_ik(lone, T).q, atol=1e-12)
    assert (many.q[:, jaw] == 0.02).all()
    seeded = solve_ik(held, T[0], np.full(7, 0.013))
    assert seeded
    assert seeded.q[jaw] == 0.013
    wished = solve_ik(held, T, q_preferred=np.full(7, 0.007))
    assert (wished.q[:, jaw] == 0.007).all()
    assert many.moving == 6
    with pytest.raises(mf.InputError):
        solve_ik(held, T[0], np.zeros(6))


def test_rates_and_paths_leave_other_joints_where_they_are(arms):
    lone, held = arms
    places = [held.joint_names.index(name) for name in lone.joint_names]
    jaw = held.joint_names.index("grip")
    q = np.zeros(7)
    q[places], q[jaw] = [0.2, 0.4, 0.6, 0.3, 0.8, -0.2], 0.011
    rates = joint_rates(held, q, [0.1, 0.0, 0.2, 0.3, 0.1, 0.0], qd_preferred=np.ones(7), cost=np.arange(1.0, 8.0))
    assert rates.redundancy == 0
    assert rates.qd[jaw] == 0.0
    np.testing.assert_allclose(held.jacobian_body(q) @ rates.qd, [0.1, 0.0, 0.2, 0.3, 0.1, 0.0], atol=1e-12)
    way = held.forward_kinematics(np.linspace(q, q + np.where(np.arange(7) == jaw, 0.0, 0.2), 8))
    done = track(held, way, q)
    assert done.continuous
    assert (done.q[:, jaw] == 0.011).all()


def test_a_follower_on_the_way_counts_through_its_leader_beside_it(tmp_path):
    """The leader hangs on the base's other side; the follower is the arm's third joint."""
    joints = [
        _joint("lead", "revolute", "base", "knob"),
        _joint("a", "revolute", "base", "l1"),
        _joint("b", "revolute", "l1", "l2", origin="0.5 0 0"),
        _joint("c", "revolute", "l2", "l3", origin="0.4 0 0", more=LIMIT + '<mimic joint="lead" multiplier="0.5"/>'),
        _joint("idle", "revolute", "l1", "flag"),
        _joint("t", "fixed", "l3", "tcp", origin="0.2 0 0", more=""),
    ]
    links = "".join(f'<link name="{name}"/>' for name in ("base", "knob", "l1", "l2", "l3", "flag", "tcp"))
    file = tmp_path / "mimic.urdf"
    file.write_text(f'<robot name="m">{links}{"".join(joints)}</robot>')
    robot = mf.load(file, tip="tcp")
    assert set(moving_part(robot).robot.joint_names) == {"lead", "a", "b"}
    q = np.zeros(robot.n)
    for name, value in {"lead": 1.2, "a": 0.3, "b": -0.7, "idle": 0.9}.items():
        q[robot.joint_names.index(name)] = value
    T = robot.forward_kinematics(q)
    answer = solve_ik(robot, T)
    assert answer
    assert answer.q[robot.joint_names.index("idle")] == 0.0
    np.testing.assert_allclose(robot.forward_kinematics(answer.q), T, atol=1e-9)
    found = inverse_kinematics(robot, T, q0=q)
    assert found
    assert (found.q[:, robot.joint_names.index("idle")] == 0.9).all()


def test_frames_before_the_wrist_have_their_own_part(arms):
    _, held = arms
    part = moving_part(held, "l3")
    assert part.robot.joint_names == ("j1", "j2", "j3")
    q = np.array([0.4, 0.5, 0.6, 0.0, 0.1, 0.2, 0.3])
    answer = inverse_kinematics(held, held.forward_kinematics(q, frame="l3"), frame="l3")
    assert answer
    assert np.abs(held.forward_kinematics(answer.q, frame="l3") - held.forward_kinematics(q, frame="l3")).max() < 1e-9


def test_an_arm_folded_upon_its_shoulder_is_not_refused_in_a_batch(tmp_path):
    """Equal links, folded: joint 2 is free as far as the place goes, and only the orientation tells where it is."""
    joints = [
        _joint("a", "revolute", "base", "l1", "-1 0 0"),
        _joint("b", "revolute", "l1", "l2", "0 -1 0"),
        _joint("c", "revolute", "l2", "l3", "0 -1 0", origin="0 0 -0.16", more=LIMIT.replace("2.5", "3.2")),
        _joint("t", "fixed", "l3", "tcp", origin="0 0 -0.16", more=""),
    ]
    links = "".join(f'<link name="{name}"/>' for name in ("base", "l1", "l2", "l3", "tcp"))
    file = tmp_path / "finger.urdf"
    file.write_text(f'<robot name="f">{links}{"".join(joints)}</robot>')
    robot = mf.load(file, tip="tcp")
    q = np.array([-0.6455227422838157, np.pi / 4, -np.pi])
    T = robot.forward_kinematics(q)
    assert inverse_kinematics(robot, T)
    batch = inverse_kinematics(robot, np.stack([T, robot.forward_kinematics([0.1, 0.2, 0.3])]))
    assert batch
    assert batch.status.tolist() == [inverse_kinematics(robot, T).status, IKStatus.SOLVED]
