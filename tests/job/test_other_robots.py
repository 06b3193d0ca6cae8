"""Other robots of a job: standing ones are obstacles, moving ones are planned past it, both proved and reported."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mafsil.collision import Arms, Mounted
from mafsil.errors import JobError
from mafsil.job.clearances import clearances
from mafsil.job.reading import parse, read
from mafsil.job.remark import Refusal
from mafsil.job.solve import prepare, solve
from mafsil.report.replay import replay_scene

EXAMPLE = Path(__file__).parents[2] / "examples" / "jobs" / "two_arms.toml"
HEAD = """
robot = "ur5"
angles = "degrees"
[start]
joints = [140, -35, 60, -25, -90, 0]
[collision]
clearance = 0.01
[[move]]
joints = [220, -35, 60, -25, -90, 0]
"""
RIGHT = """
[[other_robot]]
name = "right"
robot = "ur5"
position = [1.2, 0, 0]
rpy = [0, 0, 180]
joints = [180, -35, 60, -25, -90, 0]
"""


def planned(text):
    return prepare(parse(text), text, Path())


@pytest.fixture(scope="module")
def run():
    text = EXAMPLE.read_text("utf-8")
    return solve(read(EXAMPLE), text, EXAMPLE.parent)


@pytest.mark.capability("11-45", "11-46")
def test_two_arms_run_on_one_clock_and_nothing_meets(run):
    """Looked at densely, by arms mounted here; the second waits, and ends where its moves say."""
    assert run, run.explain("en")
    (beside,) = run.plan.neighbours
    assert beside.motion.waiting > 0.5
    robot, other = run.robot, beside.neighbour.robot
    t = np.linspace(0.0, run.plan.duration, 6000)
    main = np.concatenate([leg.trajectory.at(t[(t >= a) & (t <= b)] - a).u for leg, a, b in _legs(run.plan)])
    times = np.concatenate([t[(t >= a) & (t <= b)] for _, a, b in _legs(run.plan)])
    q = beside.motion.at(times)
    assert max(np.abs(np.diff(q, axis=0)).max(), np.abs(np.diff(main, axis=0)).max()) < 2e-3
    mechanisms = [run.plan.surroundings._mechanism, other.mechanism]
    cell = Arms([Mounted(name, each, self_collision=False) for name, each in zip(("a", "b"), mechanisms, strict=True)])
    gap = cell.distance(np.concatenate([main, q], axis=1)).distance
    assert gap.min() > 0.01
    goals = np.radians([[180, -35, 60, -25, -90, 0], [100, -70, 60, -25, -90, 0]])
    for goal in goals:
        assert np.abs(q - goal).max(axis=1).min() < 1e-3
    np.testing.assert_allclose(q[-1], goals[-1], atol=1e-9)
    assert robot.n == other.n == 6


def _legs(plan):
    starts = plan.starts
    return [(leg, a, b) for leg, a, b in zip(plan.legs, starts[:-1], starts[1:], strict=True)]


@pytest.mark.capability("11-45")
def test_both_stand_in_the_replay_and_in_the_clearance(run):
    found = clearances(run)
    names = {*found.first, *found.second}
    assert any(name.startswith("right/") for name in names)
    assert any(name.startswith("job/") for name in names)
    assert found.distance.min() > 0.005
    drawn = replay_scene(run)
    (beside,) = run.plan.neighbours
    assert len(drawn.carried) == len(beside.neighbour.robot.mechanism.links)
    assert len(drawn.fixed) == 1, "the table"
    poses = beside.poses(drawn.times)
    for k, each in enumerate(drawn.carried):
        np.testing.assert_allclose(each.poses[:, :3], poses[:, k, :3, 3], atol=1e-12)
    assert np.ptp(drawn.carried[-1].poses[:, :3], axis=0).max() > 0.3
    sentences = [remark.sentence("en") for remark in run.remarks]
    assert any("right moves beside" in each for each in sentences)


@pytest.mark.capability("11-45")
def test_a_robot_that_only_stands_there_is_gone_round():
    """Its body is met by the straight way; with avoid the way leads round, else the job is refused by its name."""
    refused = planned(HEAD + RIGHT)
    assert isinstance(refused, Refusal)
    assert "right/" in refused.explain("en")
    text = HEAD.replace("clearance = 0.01", "clearance = 0.01\navoid = true") + RIGHT
    _, plan = planned(text)
    leg = plan.legs[0]
    assert plan.surroundings.checker(leg.load).free(leg.trajectory.at(np.linspace(0, plan.duration, 3000)).u).all()
    (beside,) = plan.neighbours
    assert beside.neighbour.stands
    np.testing.assert_allclose(beside.motion.at([0.0, 5.0]), np.radians([[180, -35, 60, -25, -90, 0]] * 2))


@pytest.mark.capability("11-45")
def test_a_move_without_a_way_is_refused_by_name():
    """The robot of the job ends where the other one is to go."""
    text = HEAD.replace("[220,", "[180,") + RIGHT.replace("joints = [180, -35", "joints = [100, -70")
    text += "[[other_robot.move]]\njoints = [177, -35, 60, -25, -90, 0]\n"
    refused = planned(text)
    assert isinstance(refused, Refusal)
    assert refused.explain("en").startswith("right, move 1")
    assert "job/" in refused.explain("en")
    assert refused.explain("ar") != refused.explain("en")


@pytest.mark.parametrize(
    ("words", "change"),
    [
        ("exactly one of", "[[other_robot.move]]\nspeed = 0.5\n"),
        ("exactly one of", "[[other_robot.move]]\npause = 1\njoints = [0, 0, 0, 0, 0, 0]\n"),
        ("has 3 numbers", "[[other_robot.move]]\njoints = [0, 0, 0]\n"),
        ("beyond its limits", "[[other_robot.move]]\njoints = [900, 0, 0, 0, 0, 0]\n"),
        ("no name of another robot", RIGHT),
        ("is not known", "[[other_robot.move]]\njoint = [0]\n"),
        ("both rpy and quaternion", "quaternion = [1, 0, 0, 0]\n"),
    ],
)
def test_what_is_refused_names_the_line(words, change):
    with pytest.raises(JobError, match=words) as caught:
        planned(HEAD + RIGHT + change)
    assert "<text>:" in str(caught.value)


def test_lengths_and_files_of_other_robots():
    text = HEAD.replace('angles = "degrees"', 'angles = "degrees"\nlengths = "millimetres"').replace("0.01", "10")
    job = parse(text + RIGHT.replace("[1.2, 0, 0]", "[1200, 0, 0]"))
    assert job.other_robot[0].position == (1.2, 0.0, 0.0)


@pytest.mark.capability("11-45")
def test_another_robot_goes_to_a_pose_in_space():
    """With the orientation that its tip has; through the inverse kinematics, a configuration that is free."""
    text = HEAD + RIGHT.replace("joints = [180, -35", "joints = [100, -70")
    text += "[[other_robot.move]]\npose = { position = [1.5, 0.3, 0.3] }\n"
    _, plan = planned(text)
    (beside,) = plan.neighbours
    robot, motion = beside.neighbour.robot, beside.motion
    first, last = robot.forward_kinematics(motion.at([0.0, motion.duration]))
    np.testing.assert_allclose(last[:3, 3], [1.5, 0.3, 0.3], atol=1e-8)
    np.testing.assert_allclose(last[:3, :3], first[:3, :3], atol=1e-8)
    far = text.replace("[1.5, 0.3, 0.3]", "[9.0, 0.3, 0.3]")
    assert "no configuration was found" in planned(far).explain("en")
