"""Tools of a job by name, and their change."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import JobError
from mafsil.job import Refusal, parse_job, solve
from mafsil.job.solve import prepare
from mafsil.report.replay import tool_tracks

TOOLS = """
robot = "panda"
[tools.short]
offset = { position = [0, 0, 0.10], rpy = [0, 0, 0] }
mass = 0.5
size = [0.2, 0.06, 0.1]
centre = [0, 0, 0.05]
[tools.long]
offset = { position = [0, 0.05, 0.25], rpy = [0, 0, 0.5] }
mass = 1.5
com = [0, 0, 0.1]
size = [0.05, 0.05, 0.25]
centre = [0, 0, 0.125]
[start]
tool = "short"
joints = [0, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6]
"""
MOVES = """
[[move]]
pose = { position = [0.5, 0.2, 0.5], rpy = [3.1, 0, 0] }
[[move]]
tool = "long"
[[move]]
pose = { position = [0.5, 0.0, 0.5], rpy = [3.1, 0, 0] }
[[move]]
pose = { position = [0.55, 0.1, 0.5] }
path = "line"
[[move]]
tool = "short"
hold = 0.5
[[move]]
pose = { position = [0.5, 0.2, 0.5], rpy = [3.1, 0, 0] }
"""


def solved(text):
    return solve(parse_job(text, "job.toml"), text, Path())


@pytest.fixture(scope="module")
def run():
    found = solved(TOOLS + MOVES)
    assert found, found.explain("en")
    return found


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [("[0, 0, 0.10]", "[0, 0, 100]", "tools.short.offset"), ("[0.05, 0.05, 0.25]", "[50, 50, 250]", "tools.long.size")],
)
def test_a_tool_in_millimetres_is_refused_by_name(old, new, key):
    text = TOOLS.replace(old, new) + MOVES
    with pytest.raises(JobError, match=key) as refused:
        solved(text)
    assert "millimetres" in refused.value.message("en") != refused.value.message("ar")


@pytest.mark.capability("11-40")
def test_the_tip_of_the_mounted_tool_goes_to_the_pose(run):
    """Poses from the bare arm and the offsets of the tools, by hand."""
    bare = solved('robot = "panda"\n[[move]]\njoints = [0, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6]\n').robot
    offsets = {"short": np.eye(4), "long": np.eye(4)}
    offsets["short"][2, 3] = 0.10
    c, s = np.cos(0.5), np.sin(0.5)
    offsets["long"][:3] = [[c, -s, 0, 0], [s, c, 0, 0.05], [0, 0, 1, 0.25]]
    names = ["short", "short", "long", "long", "long", "short", "short"]
    assert [leg.load.equipment.name for leg in run.plan.legs] == names
    for leg in run.plan.legs:
        if leg.target is not None:
            q = leg.trajectory.at(leg.trajectory.duration).u
            T = np.asarray(bare.forward_kinematics(q)) @ offsets[leg.load.equipment.name]
            np.testing.assert_allclose(T, leg.target, atol=1e-6)


def test_the_arm_carries_the_mass_of_the_mounted_tool(run):
    robots = {leg.load.equipment.name: leg.load.robot for leg in run.plan.legs}
    masses = {
        name: sum(link.inertial.mass for link in r.mechanism.links if link.inertial) for name, r in robots.items()
    }
    assert masses["long"] - masses["short"] == pytest.approx(1.0)
    for driven in run.driven:
        links = driven.scenario.true_plant.robot.mechanism.links
        mass = sum(link.inertial.mass for link in links if link.inertial)
        assert mass == pytest.approx(masses[driven.stretch.load.equipment.name])


def test_tips_of_the_run_follow_the_mounted_tool(run):
    tips, references = run.tips()
    np.testing.assert_allclose(tips[:, :3, 3], references[:, :3, 3], atol=2e-3)
    starts, t = run.plan.starts, run.recording.t
    change = np.searchsorted(t, starts[2])
    jump = np.linalg.norm(tips[change, :3, 3] - tips[change - 1, :3, 3])
    assert jump == pytest.approx(np.hypot(0.05, 0.15), abs=1e-3)


def test_tools_are_drawn_on_the_flange_and_stay_where_they_were_left(run):
    moments = np.linspace(0.0, run.recording.duration, 200)
    short, long = tool_tracks(run, moments)
    assert (short.body.name, long.body.name) == ("short", "long")
    begin, end = run.plan.starts[2], run.plan.starts[5]
    away = (moments > begin + 0.05) & (moments < end - 0.05)
    np.testing.assert_allclose(short.track[away], np.tile(short.track[away][0], (away.sum(), 1, 1)))
    assert np.ptp(long.track[away][:, :3, 3], axis=0).max() > 0.1
    after = moments > end + 0.05
    np.testing.assert_allclose(long.track[after], np.tile(long.track[after][0], (after.sum(), 1, 1)))


def test_the_box_of_a_tool_meets_things():
    wall = '\n[[obstacle]]\nname = "wall"\nbox = [0.5, 0.8, 0.02]\nposition = [0.65, 0, 0.3]\n'
    move = "\n[[move]]\npose = { position = [0.5, 0.2, 0.42], rpy = [3.1416, 0, 0] }\n"
    assert solved(TOOLS + wall + move)
    tall = TOOLS.replace("size = [0.2, 0.06, 0.1]", "size = [0.2, 0.06, 0.5]")
    refused = solved(tall + wall + move)
    assert isinstance(refused, Refusal)
    assert "short" in refused.explain("en")
    assert "wall" in refused.explain("en")


def test_a_tool_that_meets_something_when_it_is_mounted_is_refused():
    wall = '\n[[obstacle]]\nname = "wall"\nbox = [0.5, 0.8, 0.02]\nposition = [0.65, 0, 0.3]\n'
    moves = '\n[[move]]\npose = { position = [0.5, 0.2, 0.42], rpy = [3.1416, 0, 0] }\n[[move]]\ntool = "long"\n'
    refused = solved(TOOLS + wall + moves)
    assert isinstance(refused, Refusal)
    assert "long" in refused.explain("en")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (('tool = "long"', 'tool = "lung"'), ("lung", "short, long")),
        (('tool = "short"\njoints', 'tool = "none"\njoints'), ("start.tool", "none")),
        (('tool = "long"\n', 'tool = "long"\nspeed = 0.5\n'), ("speed", "hold")),
        (("mass = 1.5", "mass = -1"), ("tools.long.mass",)),
        (("size = [0.05, 0.05, 0.25]", "size = [0.05, 0.05]"), ("tools.long.size",)),
        (('[[move]]\ntool = "long"', '[[move]]\npick = { mass = 0.1 }\n[[move]]\ntool = "long"'), ("holds", "part")),
        (("[tools.long]", '[tools.long]\nlink = "link2"'), ("long", "flange")),
    ],
)
def test_what_is_wrong_with_tools_is_said(change, words):
    with pytest.raises(JobError) as error:
        solved((TOOLS + MOVES).replace(*change))
    for word in words:
        assert word in error.value.message("en")


def test_tools_in_millimetres():
    text = TOOLS.replace('robot = "panda"', 'robot = "panda"\nlengths = "millimetres"') + "\n[[move]]\npause = 1\n"
    job = parse_job(text.replace("size = [0.2, 0.06, 0.1]", "size = [200, 60, 100]"))
    assert job.tools["short"].size == pytest.approx((0.2, 0.06, 0.1))
    assert job.tools["long"].com == pytest.approx((0, 0, 1e-4))


@pytest.mark.parametrize("name", ["ur5e", "ur10e", "panda", "iiwa7", "puma560"])
def test_an_offset_counts_from_the_flange_as_everywhere(name):
    """As `with_tool` and `--tool` count, and every pendant; from a link's frame where the job names the link."""
    arm = mf.load(name)
    q = 0.5 * (np.maximum(arm.limits.lower, -1.0) + np.minimum(arm.limits.upper, 1.5))
    text = f'robot = "{name}"\n[tool]\noffset = {{ position = [0.01, 0.02, 0.16] }}\n[[move]]\njoints = {q.tolist()}\n'
    robot, _ = prepare(parse_job(text), text, Path())
    tool = mf.Pose.of(mf.Rotation.identity(), [0.01, 0.02, 0.16])
    np.testing.assert_allclose(robot.forward_kinematics(q), arm.with_tool(tool).forward_kinematics(q), atol=1e-12)
    on_link = text.replace("[tool]", f'[tool]\nlink = "{arm.mechanism.tip}"')
    robot, _ = prepare(parse_job(on_link), on_link, Path())
    index = list(arm.mechanism.link_names).index(arm.mechanism.tip)
    expected = np.asarray(arm.link_poses(q))[index] @ np.asarray(tool)
    np.testing.assert_allclose(robot.forward_kinematics(q), expected, atol=1e-12)
