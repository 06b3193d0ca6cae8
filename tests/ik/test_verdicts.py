"""What is said is proven and worded by what misses; tolerance is the largest residual; answers are falsy when a no."""

import numpy as np
import pytest

import mafsil as mf
from mafsil.ik import inverse_kinematics, redundancy, solve_ik
from mafsil.ik.result import IKStatus
from tests.model.urdf.real_files import robots as real_files

AT_THE_SHOULDER = [
    1.123431614329727,
    -0.0009061631496094513,
    -0.29799586905569875,
    1.0549215382401087,
    -0.09678784700837495,
    0.506770025356264,
    -0.7870511219548769,
]


@pytest.mark.parametrize("name", ["planar2r", "planar3r"])
@pytest.mark.parametrize("task", ["pose", "position"])
def test_a_pose_lifted_out_of_the_plane_is_a_matter_of_place(name, task):
    robot = mf.load(name)
    T = robot.forward_kinematics(np.full(robot.n, 0.4))
    T[2, 3] += 0.1
    answer = inverse_kinematics(robot, T, task=task)
    told = answer.explain("en")
    assert answer.status is (IKStatus.OUT_OF_REACH if task == "position" else IKStatus.NOT_OF_THIS_ARM)
    assert "100 mm" in told
    assert "the position is off its plane" in told
    assert "orientation" not in told
    assert answer.details["position_error"] == pytest.approx(0.1, abs=1e-9)


def test_a_tilted_pose_at_a_place_within_reach_is_a_matter_of_orientation():
    robot = mf.load("cobra600")
    T = robot.forward_kinematics([0.3, 0.5, 0.05, 0.2])
    T[:3, :3] = T[:3, :3] @ mf.geometry.rotation.rot_x(0.2)
    answer = inverse_kinematics(robot, T)
    assert answer.status is IKStatus.NOT_OF_THIS_ARM
    assert "the position is reachable, but not with this orientation" in answer.explain("en")
    assert inverse_kinematics(robot, T[None]).status[0] is IKStatus.NOT_OF_THIS_ARM


def test_the_nearest_posture_is_accepted_with_the_tolerance_that_is_named():
    """The example of Lynch and Park, Modern Robotics, sec. 6.2, with its four printed decimals."""
    S = [[0, 0, 1, 4, 0, 0], [0, 0, 0, 0, 1, 0], [0, 0, -1, -6, 0, -0.1]]
    robot = mf.Robot.from_screws(S, [[-1, 0, 0, 0], [0, 1, 0, 6], [0, 0, -1, 2], [0, 0, 0, 1]])
    T = np.array([[0, 1, 0, -5], [1, 0, 0, 4], [0, 0, -1, 1.6858], [0, 0, 0, 1.0]])
    loose = inverse_kinematics(robot, T, tolerance=1e-3)
    assert loose
    assert loose.residual.max() <= 1e-3
    np.testing.assert_allclose(loose.nearest([1.5, 2.5, 3.0]), [1.57073819, 2.999667, 3.14153913], atol=1e-3)
    strict = inverse_kinematics(robot, T)
    assert not strict
    named = float(strict.explain("en").split("tolerance of ")[1].split()[0])
    assert named == pytest.approx(4.03e-5, rel=0.05)
    assert inverse_kinematics(robot, T, tolerance=named)
    assert not inverse_kinematics(robot, T, tolerance=0.9 * named)


@pytest.mark.parametrize("name", ["planar2r", "planar3r", "cobra600", "scara_rrrp", "rrrp"])
def test_poses_typed_with_few_digits(name):
    robot = mf.load(name)
    q = np.random.default_rng(1).uniform(
        np.maximum(robot.limits.lower, -2), np.minimum(robot.limits.upper, 2), (6, robot.n)
    )
    exact = robot.forward_kinematics(q)
    # Turned and shifted by what four digits leave.
    rng = np.random.default_rng(2)
    T = exact @ mf.geometry.pose.exp(rng.uniform(-5e-5, 5e-5, (6, 6)))
    batch = inverse_kinematics(robot, T, tolerance=1e-3)
    assert batch
    for X, good in zip(T, exact, strict=True):
        answer = inverse_kinematics(robot, X, tolerance=1e-3)
        assert answer
        known = len(inverse_kinematics(robot, good))
        # Elimination, for arms without a closed form, needs a pose of the arm: its list may be shorter here.
        assert len(answer) == known or (answer.method != "closed form" and len(answer) < known)
        reached = robot.forward_kinematics(answer.q)
        assert np.abs(reached[:, :3, 3] - X[:3, 3]).max() <= 1e-3
        assert not answer.complete
        assert inverse_kinematics(robot, good).complete


def test_a_place_just_beyond_reach_is_met_within_a_loose_tolerance():
    robot = mf.load("elbow6r")
    T = robot.forward_kinematics(np.zeros(6)).copy()
    T[0, 3] += 1e-3
    assert inverse_kinematics(robot, T).status is IKStatus.OUT_OF_REACH
    loose = inverse_kinematics(robot, T, tolerance=5e-3)
    assert loose
    assert 5e-4 < loose.residual.max() <= 5e-3
    assert not loose.complete
    assert inverse_kinematics(robot, T[None], tolerance=5e-3)
    assert not inverse_kinematics(robot, T[None])


def test_a_search_says_what_it_tried():
    robot = mf.load("planar3r")
    three = np.full((3, 6), 0.0)
    three[:, 2] = 1.0
    three[1:, 4] = [-1.0, -1.8]
    screws = [*three, [0, 0, 1, 0, -2.3, 0]]
    four = mf.Robot.from_screws(screws, np.eye(4) + np.eye(4, k=3) * 2.6)
    assert four.n == robot.n + 1
    T = four.forward_kinematics([0.2, 0.3, 0.4, 0.5])
    T[0, 3], T[1, 3] = 5.0, 0.0
    assert inverse_kinematics(four, T).status is IKStatus.OUT_OF_REACH
    T[0, 3] = 2.59
    T[:3, :3] = mf.geometry.rotation.rot_z(np.pi)
    # With one joint locked the others have a closed form: intervals of its values prove that there is no configuration.
    assert inverse_kinematics(four, T).status is IKStatus.NOT_OF_THIS_ARM
    # Nothing but a search is known of six joints for a place and a direction.
    six = mf.load("ur5e")
    T = np.eye(4)
    T[:3, 3] = [0.02, 0.03, 0.1625]
    answer = inverse_kinematics(six, T, task="axis")
    assert answer.status is IKStatus.NOT_FOUND
    assert "starts within the limits" in answer.explain("en")
    assert answer.details["starts"] > 0


def test_beyond_the_limits_needs_a_complete_list():
    robot = mf.load("puma560")
    q = np.array([3.0, 0.4, 0.2, 0.3, 0.5, 0.1])
    T = robot.forward_kinematics(q)
    answer = inverse_kinematics(robot, T)
    if not answer:
        assert answer.status is IKStatus.BEYOND_LIMITS
        assert answer.complete
    arm = mf.load("panda")
    T = arm.forward_kinematics([0.1, 0.2, 0.3, -1.0, 0.2, 1.5, 0.4])
    T[:3, 3] *= 0.2
    # With a joint held the list is one of many: what is proven of the limits, intervals of its values prove.
    held = inverse_kinematics(arm, T)
    assert held.status is IKStatus.BEYOND_LIMITS
    form = redundancy(arm)
    assert form.families(T) == ()
    assert not form.sweep(T, 4001).within.any()


@pytest.mark.skipif(not real_files(), reason="example-robot-data is not installed")
def test_a_pose_beside_the_shoulder_singularity_is_found():
    robot = mf.load(next(path for path in real_files() if path.stem == "talos_left_arm"))
    T = robot.forward_kinematics(AT_THE_SHOULDER)
    answer = inverse_kinematics(robot, T)
    assert answer
    assert answer.within.any()
    assert np.abs(robot.forward_kinematics(answer.q[answer.within]) - T).max() < 1e-9


def test_answers_of_one_shape():
    robot = mf.load("puma560")
    good = robot.forward_kinematics(np.full(6, 0.3))
    far = good.copy()
    far[:3, 3] += 10.0
    assert solve_ik(robot, good)
    assert not solve_ik(robot, far, restarts=3)
    assert solve_ik(robot, far, restarts=3).status is IKStatus.OUT_OF_REACH
    assert np.isnan(solve_ik(robot, far, restarts=3).solution).all()
    many = solve_ik(robot, np.stack([good, far, good]), restarts=3)
    assert not many
    assert many.status.tolist() == [IKStatus.SOLVED, IKStatus.OUT_OF_REACH, IKStatus.SOLVED]
    assert [bool(one) for one in many] == [True, False, True]
    assert "2 of 3 poses solved" in many.explain(language="en")
    assert "[1]: out of reach" in many.explain(language="en")
    assert many.explain(0, language="en").startswith("solved")
    assert many[1].status is IKStatus.OUT_OF_REACH
    assert np.isfinite(many.solution[[0, 2]]).all()
    assert len(solve_ik(robot, good)) == len(list(solve_ik(robot, good))) == 1
    batch = inverse_kinematics(robot, np.stack([good, far]))
    assert not batch
    assert inverse_kinematics(robot, good[None])
    assert batch.status.tolist() == [IKStatus.SOLVED, IKStatus.OUT_OF_REACH]
    assert "1 of 2 poses solved" in batch.explain(language="en")
    assert "out of reach: 1 pose," in batch.explain(language="en")
    assert "no joint coordinates" in batch.explain(1, language="en")
    assert [len(one) for one in batch] == batch.count.tolist()
    one = inverse_kinematics(robot, good)
    np.testing.assert_array_equal(list(one), one.q)


def test_three_slides_are_linear():
    S = [[0, 0, 0, 1, 0, 0], [0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1]]
    robot = mf.Robot.from_screws(S, np.eye(4))
    answer = inverse_kinematics(robot, robot.forward_kinematics([0.1, 0.2, 0.3]))
    np.testing.assert_allclose(answer.q, [[0.1, 0.2, 0.3]], atol=1e-12)
    assert answer.complete
    assert answer.status is IKStatus.SOLVED
