"""What was not checked of a job is said, and nothing more is claimed than what was looked at."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mafsil.job import Refusal, Run, parse_job, solve
from mafsil.job.judging.judgement import summary
from mafsil.job.solve import prepare
from mafsil.report.contents import page

HEAD = """
robot = "ur5e"
angles = "degrees"
[start]
joints = [0, -90, 90, -90, -90, 0]
[simulation]
settle = 0.05
"""
MOVE = "[[move]]\njoints = [10, -90, 90, -90, -90, 0]\n"
TABLE = '[[obstacle]]\nname = "far table"\nbox = [0.2, 0.2, 0.02]\nposition = [2, 0, 0]\n'
HIT = {"both": "job.nothing_hit", "others": "job.no_other_hit", "itself": "job.not_itself_hit"}


def ended(text):
    run = solve(parse_job(text), text, Path())
    assert isinstance(run, Run), run
    return run


def keys(run):
    return {remark.key for remark in run.remarks}


def claim(run):
    """The key of what is claimed about hits; None if nothing is."""
    said = [remark for remark in run.remarks if remark.key.startswith("job.least_clearance")]
    assert len(said) <= 1
    return said[0].details["verdict"][1:] if said else None


@pytest.mark.parametrize(
    ("more", "claimed", "said"),
    [
        (TABLE, HIT["both"], set()),
        ("", HIT["itself"], {"job.unchecked_surroundings"}),
        ("[collision]\nclearance = 0.005\n", HIT["itself"], {"job.unchecked_clearance"}),
        ("[collision]\nself_collision = false\n" + TABLE, HIT["others"], {"job.unchecked_itself_off"}),
        ("[collision]\nself_collision = false\n", None, {"job.unchecked_itself_off", "job.unchecked_surroundings"}),
        ("[tool]\noffset = { position = [0, 0, 0.2] }\n" + TABLE, HIT["both"], {"job.unchecked_tool"}),
    ],
)
def test_each_check_that_is_off_is_said(more, claimed, said):
    run = ended(HEAD + more + MOVE)
    assert claim(run) == claimed
    assert {key for key in keys(run) if key.startswith("job.unchecked_")} == said
    for language in ("en", "ar"):
        shown = page(run, summary(run), language)
        sentences = [remark.sentence(language) for remark in run.remarks if remark.key in said]
        assert set(sentences) <= {finding.text for finding in shown.findings}
    whole = " ".join(remark.sentence("en") for remark in run.remarks)
    assert ("no collision" in whole and "no collision with" not in whole) == (claimed == HIT["both"])


def test_a_clearance_from_nothing_and_a_check_that_is_switched_off_are_warnings():
    run = ended(HEAD + "[collision]\nclearance = 20\nself_clearance = 0\n" + MOVE)
    level = {remark.key: remark.level for remark in run.remarks}
    assert level["job.unchecked_clearance"] == "warning"
    off = ended(HEAD + "[collision]\nself_collision = false\n" + MOVE)
    assert {remark.key: remark.level for remark in off.remarks}["job.unchecked_itself_off"] == "warning"


def test_limits_that_nobody_described_are_said():
    text = 'robot = "planar3r"\n[start]\njoints = [0.1, 0.3, 0.3]\n[[move]]\njoints = [0.2, 0.3, 0.3]\n'
    assert {"collision.unchecked_range", "job.effort_unknown", "job.velocity_assumed"} <= keys(ended(text))
    assert "collision.unchecked_range" not in keys(ended(HEAD + MOVE))


def test_a_robot_without_shapes_is_not_said_to_miss_itself(tmp_path):
    inertial = '<inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'
    links = "".join(f'<link name="l{k}">{inertial}</link>' for k in range(3))
    joints = "".join(
        f'<joint name="j{k}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/><origin xyz="0.4 0 0"/>'
        '<axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="50" velocity="2"/></joint>'
        for k in range(2)
    )
    file = tmp_path / "bare.urdf"
    file.write_text(f'<robot name="bare">{links}{joints}</robot>')
    text = f"robot = '{file}'\n[start]\njoints = [0.1, 0.3]\n[[move]]\njoints = [0.2, 0.3]\n"
    run = ended(text)
    assert "job.unchecked_itself_shapes" in keys(run)
    assert claim(run) is None


def test_an_elbow_that_folds_into_the_shoulder_is_refused_by_default():
    """It was called planned, with "nothing is hit", for the check of the arm against itself was off."""
    text = HEAD.replace("[simulation]", "[collision]\nclearance = 0.01\n[simulation]") + TABLE
    text += "[[move]]\njoints = [0, -90, 175, -90, -90, 0]\n"
    refused = solve(parse_job(text), text, Path())
    assert isinstance(refused, Refusal)
    pair = {"upper_arm", "wrist_3"}
    for language in ("en", "ar"):
        assert all(name in refused.explain(language) for name in pair)


TOUCH = """
robot = "ur5e"
angles = "degrees"
[tool]
offset = { position = [0, 0, 0.2796], rpy = [0, 0, 0] }
size = [0.02, 0.02, 0.16]
centre = [0, 0, 0.19]
[start]
joints = [0, -90, 90, -90, -90, 0]
[collision]
clearance = 0.0
[[obstacle]]
name = "table"
box = [0.4, 0.4, 0.1]
position = [-0.5, -0.13, HEIGHT]
[[move]]
name = "down"
path = "line"
pose = { relative = "space", position = [0, 0, -0.2] }
"""


@pytest.mark.parametrize(("above", "free"), [(0.0179, True), (0.0001, True), (-0.002, True), (-0.0101, False)])
def test_the_tip_of_a_tool_reaches_a_table(above, free):
    """Its box ends 10 mm before the tip, and nothing else of the arm is beyond it."""
    probe = TOUCH.replace("HEIGHT", "-5")
    _, plan = prepare(parse_job(probe), probe, Path())
    height = float(plan.legs[0].target[2, 3])
    text = TOUCH.replace("HEIGHT", repr(height - above - 0.05))
    found = prepare(parse_job(text), text, Path())
    assert isinstance(found, Refusal) != free
    if not free:
        assert "tool" in found.explain("en")


def test_bodies_that_are_always_near_are_no_news():
    """The nearest that is told of is one that comes nearer than usual, or something else."""
    run = ended(HEAD + TABLE.replace("[2, 0, 0]", "[0.35, -0.13, 0.0]") + MOVE)
    (said,) = (remark for remark in run.remarks if remark.key == "job.least_clearance")
    assert "far table" in (said.details["first"], said.details["second"])
    assert np.isfinite(run.plan.duration)
