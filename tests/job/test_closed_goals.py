"""Jobs of mechanisms with loops whose goals are poses, round obstacles; and what is refused, in words."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mafsil.job import Refusal, Run, parse, solve
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
    return solve(parse(HEAD + text), HEAD + text, JOBS)


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


def test_a_start_may_be_a_pose():
    text = HEAD.replace("joints = [0, 0]", "pose = { position = [0.5, 0, 0.6], task = 'position' }") + OUT
    done = solve(parse(text), text, JOBS)
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
    done = solve(parse(text), text, JOBS)
    assert isinstance(done, Run)
    assert done
    assert ClosedChain(done.robot).error(done.recording.q).max() < 1e-10
    assert any(remark.key == "job.went_round" for remark in done.remarks)
    tip = done.robot.forward_kinematics(done.recording.q[-1])
    np.testing.assert_allclose(tip[:3, 3], [0.12, 0, 0.6], atol=1e-3)
    assert np.degrees(np.arccos(tip[2, 2])) == pytest.approx(12, abs=0.1)
