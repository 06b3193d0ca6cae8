"""Jobs of mechanisms with loops whose goals are poses, round obstacles; and what is refused, in words."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from mafsil.job import Refusal, Run, parse_job, solve
from mafsil.parallel import ClosedChain

JOBS = Path(__file__).resolve().parents[2] / "examples" / "jobs"
HEAD = """
robot = "../robots/palletiser.xml"
[tool]
link = "forearm"
offset = { position = [0.35, 0, 0] }
[simulation]
step = 0.002
[start]
joints = [0, 0]
"""
OUT = "[[move]]\nname = 'out'\npose = { position = [0.6, 0, 0.4], task = 'position' }\n"
POST = "[[obstacle]]\nname = 'post'\nsphere = 0.03\nposition = [0.52, 0, 0.62]\n"


def run(text: str):
    return solve(parse_job(HEAD + text), HEAD + text, JOBS)


def test_poses_are_reached_with_closed_loops_and_taken_again_as_before():
    back = "[[move]]\npose = { position = [0.3, 0, 0.75], task = 'position' }\n"
    done = run(OUT + back + OUT)
    assert isinstance(done, Run)
    assert done
    chain = ClosedChain(done.robot)
    assert chain.error(done.recording.q).max() < 1e-10
    ends = [leg.trajectory.at(leg.trajectory.duration).u for leg in done.plan.legs if leg.kind == "joint"]
    np.testing.assert_allclose(done.robot.forward_kinematics(ends[0])[:3, 3], [0.6, 0, 0.4], atol=1e-9)
    np.testing.assert_allclose(ends[0], ends[2], atol=1e-9)


def test_the_way_goes_round_and_without_avoid_it_is_refused():
    met = run(POST + OUT)
    assert isinstance(met, Refusal)
    assert "post" in met.explain("en")
    assert "avoid" in met.explain("en")
    done = run("[collision]\navoid = true\n" + POST + OUT)
    assert isinstance(done, Run)
    assert done
    assert any(remark.key == "job.went_round" for remark in done.remarks)
    assert ClosedChain(done.robot).error(done.recording.q).max() < 1e-10
    assert "as simulated" not in done.explain("en")
    kept = run("[collision]\n" + OUT + "constraints = { plane = [0, 1, 0] }\n")
    assert kept
    assert "as simulated, point within" in kept.explain("en")
    assert "loop closed" not in kept.explain("en")
    assert ClosedChain(kept.robot).error(kept.recording.q).max() < 1e-10


LINES = """[[move]]
name = 'down'
path = 'line'
pose = { position = [0.6, 0, 0.25], task = 'position' }
[[move]]
name = 'back'
path = 'line'
blend = 0.03
pose = { position = [0.5, 0, 0.25], task = 'position' }
[[move]]
name = 'up'
path = 'line'
pose = { position = [0.5, 0, 0.4], task = 'position' }
"""


@pytest.mark.parametrize(
    "profile", ["", "profile = 'time_optimal'\n", "profile = 'jerk_limited'\n"], ids=["law", "quick", "smooth"]
)
def test_the_tip_keeps_to_lines_with_closed_loops(profile):
    done = run(OUT + LINES.replace("path = 'line'\n", "path = 'line'\n" + profile, 1))
    assert isinstance(done, Run)
    assert done
    chain = ClosedChain(done.robot)
    straight, rounded = (leg.trajectory for leg in done.plan.legs if leg.kind in ("line", "blended"))
    t = np.linspace(0.0, straight.duration, 400)
    q = straight.at(t).u
    place = np.asarray(done.robot.forward_kinematics(q))[:, :3, 3]
    assert chain.error(q).max() < 1e-12
    assert np.abs(place[:, :2] - [0.6, 0.0]).max() < 1e-6
    assert (np.diff(place[:, 2]) < 1e-9).all()
    np.testing.assert_allclose(place[[0, -1], 2], [0.4, 0.25], atol=1e-8)
    speed = np.abs(np.gradient(place[:, 2], t))
    assert 0.24 < speed.max() < 0.2502  # the tip's own bound
    corner = np.asarray(done.robot.forward_kinematics(rounded.at(np.linspace(0, rounded.duration, 400)).u))[:, :3, 3]
    from_corner = np.linalg.norm(corner - [0.5, 0.0, 0.25], axis=1).min()
    assert 0.001 < from_corner < 0.03
    assert np.abs(corner[:, 1]).max() < 1e-9


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("position = [1.6, 0, 0.25], task = 'position'", "reach"),
        ("position = [0.6, 0.3, 0.25], task = 'position'", "no configuration was found"),
        ("position = [0.6, 0, 0.25], task = 'position' }\nduration = 0.05 #", "too fast|so fast"),
    ],
)
def test_lines_that_cannot_be_are_refused(line, said):
    refused = run(OUT + f"[[move]]\nname = 'far'\npath = 'line'\npose = {{ {line} }}\n")
    assert isinstance(refused, Refusal)
    assert re.search(said, refused.explain("en"))
    assert "far" in refused.explain("ar")


def test_a_start_may_be_a_pose():
    text = HEAD.replace("joints = [0, 0]", "pose = { position = [0.5, 0, 0.6], task = 'position' }") + OUT
    done = solve(parse_job(text), text, JOBS)
    assert isinstance(done, Run)
    assert done
    np.testing.assert_allclose(done.robot.forward_kinematics(done.plan.start)[:3, 3], [0.5, 0, 0.6], atol=1e-9)


@pytest.mark.parametrize(
    ("pose", "said"),
    [
        ("position = [2.6, 0, 0.4], task = 'position'", "not found"),
        ("position = [0.6, 0.2, 0.4], task = 'position'", "200 mm"),
        ("position = [0.6, 0, 0.4], rpy = [0, -1.5, 0]", "not found"),
        ("position = [-0.1, 0, 0.3], task = 'position'", "closed differently"),
        ("position = [-0.4, 0, 0.2], task = 'position'", "limits"),
    ],
)
def test_poses_out_of_reach_are_refused_with_what_is_missing(pose, said):
    refused = run(f"[[move]]\nname = 'far'\npose = {{ {pose} }}\n")
    assert isinstance(refused, Refusal)
    assert said in refused.explain("en")
    assert "far" in refused.explain("en")
    assert "far" in refused.explain("ar")


def test_an_obstacle_at_the_goal_is_named():
    refused = run("[collision]\navoid = true\n" + POST.replace("[0.52, 0, 0.62]", "[0.6, 0, 0.4]") + OUT)
    assert isinstance(refused, Refusal)
    assert "post" in refused.explain("en")


def test_the_platform_on_six_legs_does_its_job():
    text = (JOBS / "stewart.toml").read_text()
    done = solve(parse_job(text), text, JOBS)
    assert isinstance(done, Run)
    assert done
    assert ClosedChain(done.robot).error(done.recording.q).max() < 1e-10
    assert any(remark.key == "job.went_round" for remark in done.remarks)
    tip = done.robot.forward_kinematics(done.recording.q[-1])
    np.testing.assert_allclose(tip[:3, 3], [0.12, 0, 0.6], atol=1e-3)
    assert np.degrees(np.arccos(tip[2, 2])) == pytest.approx(12, abs=0.1)
