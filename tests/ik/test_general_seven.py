"""Seven joints without a closed form: one held, the others by elimination; a no is a search that failed."""

import numpy as np
import pytest

import mafsil as mf
from mafsil.ik import inverse_kinematics
from mafsil.ik.result import IKStatus


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    rng = np.random.default_rng(3)
    axes, steps = rng.normal(size=(7, 3)), rng.normal(size=(7, 3)) * 0.4
    words = [" ".join(f"{x:.4f}" for x in row) for row in np.concatenate([axes, steps])]
    links = "".join(f'<link name="l{i}"/>' for i in range(8))
    joints = "".join(
        f'<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{i + 1}"/>'
        f'<origin xyz="{words[7 + i]}"/><axis xyz="{words[i]}"/>'
        '<limit lower="-1.2" upper="1.2" velocity="1" effort="1"/></joint>'
        for i in range(7)
    )
    file = tmp_path_factory.mktemp("seven") / "arm.urdf"
    file.write_text(f'<robot name="arm">{links}{joints}</robot>')
    return mf.load(file)


def test_planted_postures_within_the_limits_are_reached(robot):
    T = robot.forward_kinematics(np.random.default_rng(0).uniform(-1.2, 1.2, (30, 7)))
    batch = inverse_kinematics(robot, T)
    assert batch
    rows = np.nonzero(batch.within)
    np.testing.assert_allclose(robot.forward_kinematics(batch.q[rows]), T[rows[0]], atol=1e-9)


def test_a_no_is_a_search_that_failed_and_says_what_it_tried(robot):
    T = robot.forward_kinematics(np.random.default_rng(1).uniform(-3.1, 3.1, (12, 7)))
    answers = [inverse_kinematics(robot, one) for one in T]
    refused = [one for one in answers if not one]
    assert len(refused) >= 6
    for one in refused:
        assert one.status in (IKStatus.NOT_FOUND, IKStatus.NOT_FOUND_WITHIN_LIMITS)
        assert not one.complete
        assert one.details["starts"] >= 1000


def test_the_same_values_of_the_held_joint_are_tried_for_all_poses(robot):
    from mafsil.ik.redundant.form import _lock

    T = robot.forward_kinematics(np.random.default_rng(2).uniform(-1.2, 1.2, (20, 7)))
    inverse_kinematics(robot, T)
    before = _lock.cache_info()
    inverse_kinematics(robot, T)
    after = _lock.cache_info()
    # One elimination for all poses of a value.
    assert 1 <= after.hits - before.hits < 24
    assert after.misses - before.misses <= 5
