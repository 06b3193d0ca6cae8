"""`mafsil trajectory`: what is impossible and what mends it, files for controllers, one clear sentence on error."""

from __future__ import annotations

import json

import pytest
import yaml

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


def test_the_doctor_names_joint_and_leg_and_mends(points, tmp_path, capsys):
    assert main(["trajectory", "doctor", "ur5e", points]) == 1
    heard = capsys.readouterr()
    assert "leg 2: joint shoulder_lift_joint" in heard.out
    assert "impossible" in heard.err
    out = tmp_path / "mended.csv"
    assert main(["trajectory", "doctor", "ur5e", points, "--out", str(out)]) == 0
    assert main(["trajectory", "check", "ur5e", str(out)]) == 0
    assert "every joint keeps its limits" in capsys.readouterr().out
    assert main(["trajectory", "doctor", "ur5e", points, "--remedy", "leave_out", "--out", str(out)]) == 0


def test_data_for_machines_and_words_in_arabic(points, capsys):
    assert main(["trajectory", "doctor", "ur5e", points, "--json"]) == 1
    data = json.loads(capsys.readouterr().out)
    assert data["remedies"][0]["kind"] == "slower"
    assert data["remedies"][0]["factor"] == pytest.approx(1.138, abs=1e-3)
    assert main(["trajectory", "doctor", "ur5e", points, "--lang", "ar"]) == 1
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
    assert main(["trajectory", "doctor", "ur5e", points, "--out", str(out), "--rate", "50"]) == 0
    message = yaml.safe_load(out.read_text())
    assert message["joint_names"][0] == "shoulder_pan_joint"
    assert len(message["points"]) == 70


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["export", "ur5e", "POINTS"], "--out"),
        (["check", "ur5e", "POINTS", "--remedy", "stop"], "--remedy belongs to doctor"),
        (["doctor", "ur5e", "POINTS", "--remedy", "stop"], "--out"),
        (["check", "panda", "POINTS"], "joint7"),
        (["check", "ur5e", "missing.csv"], "missing.csv: no such file"),
        (["export", "ur5e", "POINTS", "--out", "x.csv", "--rate", "-1"], "rate"),
        (["sell", "ur5e", "POINTS"], "doctor"),
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
