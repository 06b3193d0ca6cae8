"""`mafsil trajectory`: what is impossible and what mends it, files for controllers, one clear sentence on error."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
import yaml

import mafsil as mf
from mafsil.cli.main import main

POINTS = """t,q1,q2,q3,q4,q5,q6
0,0,-1,1,0,0.5,0
0.3,0.8,-0.8,1.1,0.1,0.5,0.2
0.5,0.9,-1.4,0.6,0.3,0.7,0.1
1.2,0.2,-1.2,0.9,0,0.2,0
"""


@pytest.fixture
def points(tmp_path):
    path = tmp_path / "points.csv"
    path.write_text(POINTS)
    return str(path)


def test_suggested_fixes_name_joint_and_leg_and_mends(points, tmp_path, capsys):
    assert main(["trajectory", "suggest-fixes", "ur5e", points]) == 1
    heard = capsys.readouterr()
    assert "leg 2: joint shoulder_lift_joint" in heard.out
    assert "violates limits" in heard.err
    out = tmp_path / "mended.csv"
    assert main(["trajectory", "suggest-fixes", "ur5e", points, "--out", str(out)]) == 0
    assert main(["trajectory", "check", "ur5e", str(out)]) == 0
    assert "all joint limits are kept" in capsys.readouterr().out
    assert main(["trajectory", "suggest-fixes", "ur5e", points, "--remedy", "leave_out", "--out", str(out)]) == 0


def test_data_for_machines_and_words_in_arabic(points, capsys):
    assert main(["trajectory", "suggest-fixes", "ur5e", points, "--json"]) == 1
    data = json.loads(capsys.readouterr().out)
    assert data["remedies"][0]["kind"] == "slower"
    assert data["remedies"][0]["factor"] == pytest.approx(1.138, abs=1e-3)
    assert main(["trajectory", "suggest-fixes", "ur5e", points, "--lang", "ar"]) == 1
    assert "أبطئ" in capsys.readouterr().out


def test_a_motion_that_breaks_a_limit_is_shown_and_not_written(points, tmp_path, capsys):
    assert main(["trajectory", "check", "ur5e", points]) == 1
    heard = capsys.readouterr()
    assert "peak velocity" in heard.out
    assert "shoulder_pan_joint" in heard.err
    out = tmp_path / "motion.yaml"
    assert main(["trajectory", "export", "ur5e", points, "--out", str(out)]) == 1
    assert not out.exists()


def test_a_mended_motion_becomes_a_message(points, tmp_path):
    out = tmp_path / "motion.yaml"
    assert main(["trajectory", "suggest-fixes", "ur5e", points, "--out", str(out), "--rate", "50"]) == 0
    message = yaml.safe_load(out.read_text())
    assert message["joint_names"][0] == "shoulder_pan_joint"
    assert len(message["points"]) == 70


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["export", "ur5e", "POINTS"], "--out"),
        (["check", "ur5e", "POINTS", "--remedy", "stop"], "--remedy belongs to suggest-fixes"),
        (["suggest-fixes", "ur5e", "POINTS", "--remedy", "stop"], "--out"),
        (["check", "panda", "POINTS"], "joint7"),
        (["check", "ur5e", "missing.csv"], "missing.csv: no such file"),
        (["export", "ur5e", "POINTS", "--out", "x.csv", "--rate", "-1"], "rate"),
        (["sell", "ur5e", "POINTS"], "suggest-fixes"),
        (["doctor", "ur5e", "POINTS"], "did you mean: suggest-fixes"),
    ],
)
def test_wrong_words_are_one_sentence(points, capsys, words, says):
    assert main(["trajectory", *(points if word == "POINTS" else word for word in words)]) == 2
    heard = capsys.readouterr().err
    assert says in heard
    assert len(heard.strip().splitlines()) == 1


def test_joints_of_another_robot_are_refused_by_name(tmp_path, capsys):
    path = tmp_path / "other.csv"
    path.write_text("t,q[a],q[b]\n0,0,0\n1,1,1\n2,0,0\n")
    assert main(["trajectory", "check", "planar2r", str(path)]) == 2
    assert "holds the joints a, b" in capsys.readouterr().err


JOB = """robot = "planar2r"
angles = "degrees"
[start]
joints = [0, 30]
[limits]
velocity = 3400
acceleration = 11500
{law}
[[move]]
joints = [40, 60]
"""
WEAK = """[controller]
kind = "pd_gravity"
kp = 5.0
kd = 1.0
"""


def recorded(folder, law, code):
    """The folder of results of a job."""
    job = folder / "job.toml"
    job.write_text(JOB.format(law=law))
    assert main(["run", str(job), "--out", str(folder / "results")]) == code
    return folder / "results"


def rows_of(path):
    return np.genfromtxt(path, delimiter=",", names=True)


def test_the_plan_of_a_recording_goes_to_the_controller(tmp_path, capsys):
    results = recorded(tmp_path, "", 0)
    recording, out = results / "recording.csv", tmp_path / "motion.csv"
    capsys.readouterr()
    assert main(["trajectory", "export", "planar2r", str(recording), "--out", str(out), "--rate", "1000"]) == 0
    assert "the planned motion (columns q_ref)" in capsys.readouterr().out
    source, plan = rows_of(recording), rows_of(out)
    assert len(plan) == len(source)
    for name in ("qjoint1", "qjoint2", "qdjoint1", "qddjoint2"):
        signal = name.replace("joint", "_refjoint")
        np.testing.assert_allclose(plan[name], source[signal], rtol=0, atol=1e-9)
    assert np.abs(plan["qjoint1"] - source["qjoint1"]).max() > 1e-4
    assert (
        main(["trajectory", "export", "planar2r", str(recording), "--out", str(out), "--rate", "1000", "--driven"]) == 0
    )
    assert "the measured motion" in capsys.readouterr().out
    np.testing.assert_allclose(rows_of(out)["qjoint1"], source["qjoint1"], rtol=0, atol=1e-12)
    assert main(["trajectory", "check", "planar2r", str(recording), "--driven"]) == 0
    assert main(["trajectory", "suggest-fixes", "planar2r", str(recording), "--driven"]) == 2


def test_a_failed_run_is_written_on_request_only(tmp_path, capsys):
    recording, out = recorded(tmp_path, WEAK, 1) / "recording.csv", tmp_path / "motion.yaml"
    export = ["trajectory", "export", "planar2r", str(recording), "--out", str(out)]
    assert main(export) == 2
    heard = capsys.readouterr().err
    assert "recording of a failed run (status: failed)" in heard
    assert "--failed" in heard
    assert not out.exists()
    assert main([*export, "--driven"]) == 2
    assert main([*export, "--failed"]) == 0
    last = yaml.safe_load(out.read_text())["points"][-1]["positions"]
    np.testing.assert_allclose(last, np.radians([40, 60]), atol=1e-12)


def test_a_run_that_ended_early_is_a_failed_one(tmp_path):
    arm = mf.load("planar2r")
    motion = mf.trajectory.quintic([0.0, 0.5], [0.7, 1.0], 0.5)
    run = mf.simulate(mf.Scenario(robot=arm, trajectory=motion, law=mf.control.computed_torque(arm)))
    replace(run, status=type(run.status).BLOWN_UP).save(tmp_path / "run")
    export = ["trajectory", "export", "planar2r", str(tmp_path / "run.csv"), "--out", str(tmp_path / "m.csv")]
    assert main(export) == 2
    run.save(tmp_path / "run")
    assert main(export) == 0


def test_numbered_names_fit_any_robot(tmp_path):
    """Files of motions with limits of one's own call the joints joint1, joint2, ..."""
    motion = mf.trajectory.quintic(np.zeros(6), np.full(6, 0.5), 2.0)
    path = tmp_path / "motion.csv"
    assert mf.trajectory.export(motion, path, mf.trajectory.MotionLimits.of(6))
    assert "q[joint1]" in path.read_text()
    assert main(["trajectory", "check", "ur10e", str(path)]) == 0
    assert main(["trajectory", "check", "panda", str(path)]) == 2
